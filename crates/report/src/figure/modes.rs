//! The mode strip: one row per mode, possible and impossible over time.
//!
//! A sample speaks for itself and for the time since the sample before, so bars and gaps hold
//! everywhere, not only at the samples.

use super::{BUCKET, left_margin, mark_empty, mark_refuted, refuted_entry, right_edge, why_empty};
use crate::axis::{Axis, Room};
use crate::history::{History, NOT_ALONE, POSSIBLE};
use crate::legend::{self, Entry};
use crate::panel::{Panel, time_axis};
use crate::svg::{Anchor, Canvas, Px, Rect, push, text_width};
use crate::theme;

const ROW: f64 = 26.0;
const BAR: f64 = 16.0;

/// A bar wherever a mode can be active: full where it is the only one, hatched where others can be
/// active too; no bar where it is proved impossible.
pub(super) fn draw(history: &History) -> String {
    let mut canvas = Canvas::new("modes", theme::WIDTH);
    let right = right_edge(history);
    let modes = &history.meta.modes;
    let hatch = canvas.hatch(theme::BLUE, "#DCEEF9");
    let hatched = format!(
        "fill=\"{hatch}\" stroke=\"{}\" stroke-width=\"0.5\"",
        theme::BLUE
    );
    let full = format!(
        "fill=\"{0}\" stroke=\"{0}\" stroke-width=\"0.5\"",
        theme::BLUE
    );
    let blank = format!(
        "fill=\"#fff\" stroke=\"{}\" stroke-width=\"0.6\"",
        theme::GREY_EDGE
    );

    let mut entries = vec![
        Entry::area(full.clone(), "the only possible mode"),
        Entry::area(hatched.clone(), "possible beside others"),
        Entry::area(blank, "proved impossible"),
    ];
    entries.extend(refuted_entry(history));
    let top = 10.0 + legend::draw(&mut canvas, &entries, (2.0, right), 4.0);

    let widest = modes
        .iter()
        .map(|m| text_width(m, theme::LABEL.size))
        .fold(0.0, f64::max);
    let left = left_margin(widest);
    let area = Rect {
        x: left,
        y: top,
        w: right - left,
        h: ROW * modes.len() as f64,
    };
    let time = time_axis(history.time_span(), area.w, theme::SMALL);
    let mut value = Axis::linear(
        0.0,
        1.0,
        Room {
            length: area.h,
            spacing: area.h,
            font: 0.0,
        },
    );
    value.ticks.clear();
    let panel = Panel {
        area,
        time,
        value,
        bucket: BUCKET,
    };

    panel.grid(&mut canvas);
    let rule = format!("stroke=\"{}\" stroke-width=\"0.6\"", theme::GRID);
    canvas.open_clip(area);
    for (i, _) in modes.iter().enumerate() {
        let y = top + ROW * i as f64;
        canvas.line((left, y), (right, y), &rule);
        let bar = (y + (ROW - BAR) / 2.0, y + (ROW + BAR) / 2.0);
        let mark = history.mode_marks(i);
        let can = spans(
            history,
            &panel,
            |m| m & POSSIBLE != 0,
            Rounding::Outward,
            mark,
        );
        canvas.path(&bars(&can, bar), &hatched);
        let alone = |m: u8| m & POSSIBLE != 0 && m & NOT_ALONE == 0;
        canvas.path(
            &bars(&spans(history, &panel, alone, Rounding::Inward, mark), bar),
            &full,
        );
    }
    canvas.close();
    for (i, mode) in modes.iter().enumerate() {
        let baseline = top + ROW * (i as f64 + 0.5) + 0.36 * theme::LABEL.size;
        canvas.text((left - 7.0, baseline), mode, Anchor::End, theme::LABEL);
    }
    mark_refuted(&mut canvas, history, &panel);
    if history.samples() == 0 {
        mark_empty(&mut canvas, &panel, why_empty(history));
    }
    panel.axes(&mut canvas, theme::SMALL);
    let bottom = area.bottom();
    let label_at = (left + area.w / 2.0, bottom + 34.0);
    canvas.text(
        label_at,
        &history.time_label(),
        Anchor::Middle,
        theme::LABEL,
    );
    canvas.finish(bottom + super::FOOT, &history.title("modes over time"))
}

/// Whether a span may grow or shrink by rounding: what is possible grows, what is certain shrinks.
#[derive(Clone, Copy)]
enum Rounding {
    Outward,
    Inward,
}

/// The stretches of time, in the picture, over which a claim holds in every cell. A cell speaks for
/// the time from the end of the one before to its own end.
fn spans(
    history: &History,
    panel: &Panel,
    claim: impl Fn(u8) -> bool,
    rounding: Rounding,
    mark: usize,
) -> Vec<(Px, Px)> {
    let cells = history.cells();
    let mut spans: Vec<(Px, Px)> = Vec::new();
    let mut begun: Option<f64> = None;
    let mut start = cells.first().map_or(0.0, |first| first.t0);
    for (k, cell) in cells.iter().enumerate() {
        if claim(cell.mark(mark)) {
            begun.get_or_insert(start);
        }
        start = cell.t1;
        let goes_on = cells.get(k + 1).is_some_and(|next| claim(next.mark(mark)));
        if let Some(from) = begun
            && !goes_on
        {
            let (from, to) = (panel.px(from), panel.px(cell.t1));
            let span = match rounding {
                Rounding::Outward => (Px::below(from), Px::above(to)),
                Rounding::Inward => (Px::above(from), Px::below(to)),
            };
            if span.0 < span.1 {
                spans.push(span);
            }
            begun = None;
        }
    }
    spans
}

fn bars(spans: &[(Px, Px)], (top, bottom): (f64, f64)) -> String {
    let (top, bottom) = (Px::near(top), Px::near(bottom));
    let mut data = String::new();
    for (from, to) in spans {
        push(
            &mut data,
            format_args!("M{from} {top}H{to}V{bottom}H{from}Z"),
        );
    }
    data
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::history::SampleRow;
    use crate::meta::FigureMeta;

    /// Seven samples, 0 to 6, in as many cells: the first mode is possible at 2 and 3, alone at 3;
    /// the second everywhere but at 3.
    fn run() -> History {
        let mut history = History::new(FigureMeta {
            modes: vec!["slip".to_owned(), "stick".to_owned()],
            ..FigureMeta::default()
        });
        for k in 0..7 {
            history
                .push(&SampleRow {
                    t: f64::from(k),
                    modes: &[k == 2 || k == 3, k != 3],
                    ..SampleRow::default()
                })
                .unwrap();
        }
        history
    }

    fn panel() -> Panel {
        let room = Room {
            length: 600.0,
            spacing: 60.0,
            font: 11.0,
        };
        Panel {
            area: Rect {
                x: 0.0,
                y: 0.0,
                w: 600.0,
                h: 50.0,
            },
            time: Axis::linear(0.0, 6.0, room),
            value: Axis::linear(0.0, 1.0, room),
            bucket: BUCKET,
        }
    }

    /// Times of the spans, to a hundredth of the time between samples.
    fn times(claim: impl Fn(u8) -> bool, rounding: Rounding, mark: usize) -> Vec<(f64, f64)> {
        let panel = panel();
        let scale = panel.px(6.0) - panel.px(5.0);
        let time = |x: Px| ((x.0 as f64 / 100.0 - panel.px(0.0)) / scale * 100.0).round() / 100.0;
        spans(&run(), &panel, claim, rounding, mark)
            .into_iter()
            .map(|(from, to)| (time(from), time(to)))
            .collect()
    }

    #[test]
    fn a_sample_speaks_for_the_time_since_the_one_before() {
        let can = |m: u8| m & POSSIBLE != 0;
        let alone = |m: u8| m & POSSIBLE != 0 && m & NOT_ALONE == 0;
        assert_eq!(times(can, Rounding::Outward, 0), [(1.0, 3.0)]);
        assert_eq!(times(alone, Rounding::Inward, 0), [(2.0, 3.0)]);
        // What is left white of the second mode is the step in which it is impossible.
        assert_eq!(times(can, Rounding::Outward, 1), [(0.0, 2.0), (3.0, 6.0)]);
        let second_alone = times(alone, Rounding::Inward, 1);
        assert_eq!(second_alone, [(0.0, 1.0), (3.0, 6.0)]);
    }
}
