//! The mode strip: one row per mode, possible and impossible over time.

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

/// The stretches of time, in the picture, over which a claim holds in every cell. A cell lasts
/// until the next one begins.
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
    for (k, cell) in cells.iter().enumerate() {
        if claim(cell.mark(mark)) {
            begun.get_or_insert(cell.t0);
        }
        let end = cells.get(k + 1).map_or(cell.t1, |next| next.t0);
        let goes_on = cells.get(k + 1).is_some_and(|next| claim(next.mark(mark)));
        if let Some(from) = begun
            && !goes_on
        {
            let (from, to) = (panel.px(from), panel.px(end));
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
