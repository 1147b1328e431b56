//! Finding room for an inset: a rectangle of a panel in which nothing is drawn.

use crate::panel::Panel;
use crate::svg::Rect;
use crate::track::Cell;

/// What the data of a panel cover: from top to bottom, for each column one unit wide.
pub(crate) struct Shadow {
    area: Rect,
    columns: Vec<(f64, f64)>,
}

impl Shadow {
    /// The columns covered by the given series, lines between neighbours included.
    pub fn of(panel: &Panel, cells: &[Cell], series: &[usize]) -> Self {
        let area = panel.area;
        let columns = vec![(f64::INFINITY, f64::NEG_INFINITY); area.w.max(1.0).ceil() as usize];
        let mut shadow = Self { area, columns };
        for series in series {
            for (k, cell) in cells.iter().enumerate() {
                let next = cells.get(k + 1).unwrap_or(cell);
                let (Some(a), Some(b)) = (
                    cell.band(*series),
                    next.band(*series).or(cell.band(*series)),
                ) else {
                    continue;
                };
                let hull = a.hull(b);
                let (top, bottom) = (panel.py(hull.hi), panel.py(hull.lo));
                shadow.cover(panel.px(cell.t0), panel.px(next.t1), (top, bottom));
            }
        }
        shadow
    }

    fn cover(&mut self, from: f64, to: f64, (top, bottom): (f64, f64)) {
        let first = (from - self.area.x).floor().max(0.0) as usize;
        let last = (to - self.area.x).ceil().max(0.0) as usize;
        for column in self.columns.iter_mut().take(last + 1).skip(first) {
            column.0 = column.0.min(top);
            column.1 = column.1.max(bottom);
        }
    }

    /// Whether nothing is drawn inside the rectangle.
    fn leaves_free(&self, r: Rect) -> bool {
        let first = (r.x - self.area.x).floor().max(0.0) as usize;
        let count = r.w.ceil() as usize + 2;
        let mut columns = self.columns.iter().skip(first).take(count);
        columns.all(|(top, bottom)| *bottom < r.y || *top > r.bottom())
    }

    /// The free rectangle of the given size that is nearest to the target; none where there is none.
    pub fn place(&self, size: (f64, f64), target: (f64, f64)) -> Option<Rect> {
        const STEP: f64 = 6.0;
        let (w, h) = size;
        let steps = |room: f64| {
            if room < 0.0 {
                0
            } else {
                (room / STEP) as usize + 1
            }
        };
        let mut best: Option<(f64, Rect)> = None;
        for i in 0..steps(self.area.w - w) {
            for j in 0..steps(self.area.h - h) {
                let r = Rect {
                    x: self.area.x + STEP * i as f64,
                    y: self.area.y + STEP * j as f64,
                    w,
                    h,
                };
                let distance = (r.x + w / 2.0 - target.0).hypot(r.y + h / 2.0 - target.1);
                if best.as_ref().is_none_or(|(least, _)| distance < *least) && self.leaves_free(r) {
                    best = Some((distance, r));
                }
            }
        }
        best.map(|(_, r)| r)
    }
}
