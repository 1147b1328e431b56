//! The work of a run: boxes, and time spent, for each sample.

use super::{Frame, Row, mark_empty, mark_refuted, refuted_entry, right_edge, stack, why_empty};
use crate::axis::{Axis, Room};
use crate::history::History;
use crate::legend::{self, Entry};
use crate::ribbon::{Between, outline};
use crate::svg::Canvas;
use crate::theme;
use crate::track::{Band, Cell};

const HEIGHT: f64 = 120.0;

/// Two panels: boxes, and milliseconds for each sample with the time between samples as deadline.
pub(super) fn draw(history: &History) -> String {
    let mut canvas = Canvas::new("work", theme::WIDTH);
    let right = right_edge(history);
    let deadline = history
        .meta
        .sample_time_ms
        .filter(|ms| ms.is_finite() && *ms > 0.0);
    let (boxes, spent) = (history.boxes_series(), history.milliseconds_series());
    let bands = |series: usize| -> Vec<Band> {
        history
            .cells()
            .iter()
            .filter_map(|cell| cell.band(series))
            .collect()
    };
    let rows = vec![
        Row {
            name: "boxes after each sample".to_owned(),
            remark: boxes_remark(history),
            value: from_zero(history.work.most_boxes as f64),
            height: HEIGHT,
        },
        Row {
            name: "time per sample [ms]".to_owned(),
            remark: time_remark(history),
            value: time_spent_axis(&bands(spent), deadline),
            height: HEIGHT,
        },
    ];

    let merged = history.cells().iter().any(|cell| cell.t0 < cell.t1);
    let text = if merged {
        "range of neighbouring samples"
    } else {
        "each sample"
    };
    let mut entries = vec![Entry::area(theme::work(), text)];
    entries.extend(deadline.map(|ms| Entry::line(theme::dashed(), format!("sample time {ms} ms"))));
    entries.extend(refuted_entry(history));
    let top = 4.0 + legend::draw(&mut canvas, &entries, (2.0, right), 4.0);
    let stack = stack(
        &mut canvas,
        history,
        rows,
        Frame {
            top,
            right,
            gap: 0.0,
        },
    );
    for (series, panel) in [boxes, spent].into_iter().zip(&stack.panels) {
        panel.grid(&mut canvas);
        let data = outline(
            panel,
            history.cells(),
            |cell| cell.band(series),
            Between::Holds,
        );
        let ground = |cell: &Cell| {
            Some(Band {
                lo: f64::NEG_INFINITY,
                hi: cell.band(series)?.hi,
            })
        };
        canvas.open_clip(panel.area);
        let area = outline(panel, history.cells(), ground, Between::Holds);
        canvas.path(&area, &theme::below_work());
        canvas.path(&data, &theme::work());
        canvas.close();
        if let (Some(ms), true) = (deadline, series == spent) {
            let y = panel.py(ms);
            canvas.line((panel.area.x, y), (panel.area.right(), y), &theme::dashed());
        }
        mark_refuted(&mut canvas, history, panel);
        if data.is_empty() {
            mark_empty(&mut canvas, panel, why_empty(history));
        }
        panel.axes(&mut canvas, theme::SMALL);
    }
    canvas.finish(stack.bottom, &history.title("work for each sample"))
}

/// Logarithmic where the times, and the deadline, lie more than a factor of 30 apart.
fn time_spent_axis(bands: &[Band], deadline: Option<f64>) -> Axis {
    let positive = || {
        let bounds = bands.iter().flat_map(|b| [b.lo, b.hi]).chain(deadline);
        bounds.filter(|ms| ms.is_finite() && *ms > 0.0)
    };
    let least = positive().fold(f64::INFINITY, f64::min);
    let most = positive().fold(0.0, f64::max);
    if most > 30.0 * least {
        let room = Room {
            length: HEIGHT,
            spacing: 2.0 * theme::SMALL.size,
            font: 0.0,
        };
        // Times below a ten-thousandth of the longest tell nothing about the work.
        return Axis::logarithmic(least.max(1e-4 * most), most, room);
    }
    from_zero(most)
}

/// A linear axis from exactly zero to a little more than the most there is.
fn from_zero(most: f64) -> Axis {
    let most = if most > 0.0 { most } else { 1.0 };
    let room = Room {
        length: HEIGHT,
        spacing: 2.0 * theme::SMALL.size,
        font: 0.0,
    };
    Axis::linear(0.0, 1.06 * most, room)
}

fn boxes_remark(history: &History) -> String {
    match history.samples() {
        0 => String::new(),
        _ => format!("at most {}", history.work.most_boxes),
    }
}

/// A positive number with three significant digits, as far as these are decimals.
fn short(x: f64) -> String {
    let before = x.log10().floor();
    let places = if before.is_finite() {
        (2.0 - before).clamp(0.0, 9.0) as usize
    } else {
        0
    };
    format!("{x:.places$}")
}

fn time_remark(history: &History) -> String {
    let work = history.work;
    if work.samples == 0 {
        return String::new();
    }
    let mean = work.milliseconds / work.samples as f64;
    format!("mean {} ms, worst {} ms", short(mean), short(work.worst))
}
