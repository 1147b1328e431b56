//! The phase plane: all values of two states together.

use super::left_margin;
use crate::legend::{self, Entry};
use crate::panel::{Panel, value_axis};
use crate::svg::{Anchor, Canvas, Px, Rect, push};
use crate::theme;
use crate::track::{Band, Cell};
use crate::tube::Tube;

const HEIGHT: f64 = 420.0;
/// Height of tick labels and the label below.
const FOOT: f64 = 42.0;
const HEADING: f64 = 26.0;

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
        let right = theme::WIDTH - 12.0;
        let top = 4.0 + HEADING + legend::draw(&mut canvas, &entries, (2.0, right), 4.0);

        let (xs, ys) = (self.since_and_at(x), self.since_and_at(y));
        let value = value_axis(&ys, &[], HEIGHT, theme::SMALL);
        let left = left_margin(value.label_width(theme::SMALL.size));
        let area = Rect {
            x: left,
            y: top,
            w: right - left,
            h: HEIGHT,
        };
        let panel = Panel {
            area,
            time: value_axis(&xs, &[], area.w / 2.5, theme::SMALL),
            value,
            bucket: super::BUCKET,
        };
        panel.grid(&mut canvas);
        canvas.open_clip(area);
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
        panel.axes(&mut canvas, theme::SMALL);
        canvas.text((2.0, top - 9.0), &label(y), Anchor::Start, theme::NAME);
        let below = (left + area.w / 2.0, area.bottom() + 34.0);
        canvas.text(below, &label(x), Anchor::Middle, theme::NAME);
        canvas.finish(area.bottom() + FOOT, &history.title("phase plane"))
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
        let (left, right) = (Px::below(panel.px(x.lo)), Px::above(panel.px(x.hi)));
        let (top, bottom) = (Px::below(panel.py(y.hi)), Px::above(panel.py(y.lo)));
        push(
            &mut data,
            format_args!("M{left} {top}H{right}V{bottom}H{left}Z"),
        );
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
