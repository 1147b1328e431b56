//! The phase plane: all values of two states together.

use super::pair::{self, HEIGHT};
use crate::legend::Entry;
use crate::panel::{Panel, value_axis};
use crate::svg::{Canvas, Px, push};
use crate::theme;
use crate::track::{Band, Cell};
use crate::tube::Tube;

impl Tube {
    /// The union of the boxes of two states, the first and the last of them marked.
    pub(crate) fn draw_plane(&self, (x, y): (usize, usize)) -> String {
        let history = &self.history;
        let states = &history.meta().states;
        let label = |state: usize| states.get(state).map_or(String::new(), |s| s.label());
        let mut canvas = Canvas::new("plane", theme::WIDTH);
        let mut entries = vec![Entry::area(theme::union(), "proved at all times")];
        entries.push(Entry::area(theme::start(), "start"));
        entries.push(Entry::area(theme::band(theme::RED), "end"));
        if self.count > 0 {
            entries.push(Entry::line(theme::trajectory(), "true trajectories"));
        }
        let (xs, ys) = (self.since_and_at(x), self.since_and_at(y));
        let value = value_axis(&ys, &[], HEIGHT, theme::SMALL);
        let panel = pair::panel(&mut canvas, &entries, value, |width| {
            value_axis(&xs, &[], width / 2.5, theme::SMALL)
        });
        panel.grid(&mut canvas);
        canvas.open_clip(panel.area);
        let tube = self.since.cells().iter();
        let data: String = tube.map(|cell| rectangle(&panel, cell, (x, y))).collect();
        canvas.path(&data, &theme::union());
        let places = (history.state_series(x), history.state_series(y));
        let cells = history.cells();
        let ends = [
            (cells.first(), theme::start()),
            (cells.last(), theme::band(theme::RED)),
        ];
        for (cell, style) in ends {
            let data = cell.map(|cell| rectangle(&panel, cell, places));
            canvas.path(&data.unwrap_or_default(), &style);
        }
        for number in 0..self.count {
            let own = |state| self.trajectory_series(number, state);
            let line = line(&panel, self.trajectories.cells(), (own(x), own(y)));
            canvas.path(&line, &format!("fill=\"none\" {}", theme::trajectory()));
        }
        canvas.close();
        let title = history.title("phase plane");
        pair::finish(canvas, &panel, (&label(x), &label(y)), &title)
    }

    fn since_and_at(&self, state: usize) -> Vec<Band> {
        let last = self.last_useful();
        let since = self.since.cells().iter().filter(|cell| cell.t1 <= last);
        let at = self.history.cells().iter().filter(|cell| cell.t1 <= last);
        let place = self.history.state_series(state);
        let bands = since.filter_map(|cell| cell.band(state));
        bands
            .chain(at.filter_map(|cell| cell.band(place)))
            .collect()
    }
}

/// The box of two series of a cell, rounded outward.
fn rectangle(panel: &Panel, cell: &Cell, (x, y): (usize, usize)) -> String {
    let mut data = String::new();
    if let Some((x, y)) = cell.band(x).zip(cell.band(y)) {
        pair::rectangle(&mut data, panel, (x.lo, x.hi), (y.lo, y.hi));
    }
    data
}

/// A line through the middles of two series.
fn line(panel: &Panel, cells: &[Cell], (x, y): (usize, usize)) -> String {
    let mut data = String::new();
    for cell in cells {
        let Some((x, y)) = cell.band(x).zip(cell.band(y)) else {
            break;
        };
        let middle = |band: Band| band.lo / 2.0 + band.hi / 2.0;
        let (x, y) = (Px::near(panel.px(middle(x))), Px::near(panel.py(middle(y))));
        let command = if data.is_empty() { 'M' } else { 'L' };
        push(&mut data, format_args!("{command}{x} {y}"));
    }
    data
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::meta::{FigureMeta, Quantity};
    use crate::svg::Rect;
    use crate::tube::TubeRow;

    /// Every box given lies in the rectangle drawn for it.
    #[test]
    fn boxes_are_rounded_outward() {
        let states = vec![Quantity::new("x", ""), Quantity::new("v", "")];
        let meta = FigureMeta {
            states,
            columns: 8,
            ..FigureMeta::default()
        };
        let mut tube = Tube::new(meta, Some((0, 1)), 0);
        let at = |k: u32| (f64::from(k) * 0.1).sin();
        for k in 0..100 {
            let now = [(at(k) - 0.1, at(k) + 0.1), (at(k + 16), at(k + 16))];
            let since = [(at(k) - 0.2, at(k) + 0.2), (at(k + 16) - 0.1, at(k + 16))];
            tube.push(&TubeRow {
                t: f64::from(k),
                states: &now,
                states_since: &since,
                ..TubeRow::default()
            })
            .unwrap();
        }
        let (xs, ys) = (tube.since_and_at(0), tube.since_and_at(1));
        let panel = Panel {
            area: Rect {
                x: 33.3,
                y: 11.1,
                w: 555.5,
                h: 222.2,
            },
            time: value_axis(&xs, &[], 200.0, theme::SMALL),
            value: value_axis(&ys, &[], 200.0, theme::SMALL),
            bucket: 20,
        };
        for k in 1..100 {
            let t = f64::from(k);
            let cells = tube.since.cells().iter();
            let cell = { cells }.find(|cell| cell.t0 < t && t <= cell.t1).unwrap();
            let data = rectangle(&panel, cell, (0, 1));
            let numbers: Vec<f64> = data
                .split(|c: char| !c.is_ascii_digit() && c != '.')
                .filter_map(|text| text.parse().ok())
                .collect();
            let [left, top, right, bottom, ..] = numbers[..] else {
                panic!("{data}")
            };
            assert!(left <= panel.px(at(k) - 0.2) && panel.px(at(k) + 0.2) <= right);
            assert!(top <= panel.py(at(k + 16)) && panel.py(at(k + 16) - 0.1) <= bottom);
        }
    }
}
