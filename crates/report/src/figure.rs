//! The figures of a run, each in a file of its own, and the layout they share.

mod bands;
mod bounds;
mod modes;
mod outputs;
mod pair;
mod paving;
mod plane;
mod tube;
mod work;

use crate::axis::Axis;
use crate::history::History;
use crate::legend::{self, Entry};
use crate::panel::{Panel, time_axis};
use crate::svg::{Anchor, Canvas, Rect, text_width};
use crate::theme;

/// A finished figure.
///
/// Example: [`FigureMeta`](crate::FigureMeta).
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Name of the figure, and of its files without their ending: `outputs`, `params`, `states`,
    /// `modes`, `work`, `plane`, `bounds`, `paving_A_B` of the parameters A and B.
    pub name: String,
    /// The picture as SVG text; `png` makes a PNG of it.
    pub svg: String,
}

impl History {
    /// All figures that the description has something for.
    ///
    /// # Guarantee
    /// At every sample, a drawn band holds the bounds that were given for it: coordinates are
    /// rounded outward. Between samples, bands of outputs and states are joined by straight lines,
    /// which prove nothing; those of parameters hold until the next sample. What is drawn of modes
    /// holds between samples, too. Bounds beyond the axis are drawn out to the panel's edge. The
    /// same history gives the same bytes.
    pub fn render_all(&self) -> Vec<Figure> {
        self.render(None)
    }

    /// All figures of this run, with the parameters of another run hatched behind its own.
    /// Parameters are paired by their names.
    pub fn render_compared(&self, other: &History) -> Vec<Figure> {
        self.render(Some(other))
    }

    fn render(&self, other: Option<&History>) -> Vec<Figure> {
        let meta = &self.meta;
        let wanted = [
            (!meta.outputs.is_empty()).then(|| ("outputs", outputs::draw(self))),
            (!meta.params.is_empty()).then(|| ("params", bands::draw_params(self, other))),
            (!meta.states.is_empty()).then(|| ("states", bands::draw_states(self))),
            (!meta.modes.is_empty()).then(|| ("modes", modes::draw(self))),
            Some(("work", work::draw(self))),
        ];
        wanted
            .into_iter()
            .flatten()
            .map(|(name, svg)| Figure {
                name: name.to_owned(),
                svg,
            })
            .collect()
    }

    fn time_label(&self) -> String {
        if self.meta.time_unit.is_empty() {
            "time".to_owned()
        } else {
            format!("time [{}]", self.meta.time_unit)
        }
    }

    fn title(&self, what: &str) -> String {
        titled(&self.meta.title, what)
    }
}

/// What a figure shows, of the run with this title.
fn titled(run: &str, what: &str) -> String {
    if run.is_empty() {
        what.to_owned()
    } else {
        format!("{run}: {what}")
    }
}

/// A panel to be laid out: what stands above it, and its value axis.
struct Row {
    name: String,
    remark: String,
    value: Axis,
    height: f64,
}

/// Panels one below the other with one time axis, and where they lie.
struct Stack {
    panels: Vec<Panel>,
    bottom: f64,
}

/// Height of the heading above each panel.
const HEADING: f64 = 24.0;
/// Height of the tick labels and the label of the time axis below the last panel.
const FOOT: f64 = 42.0;
/// Width of a bucket of time in the main panels, in hundredths of a unit: 0.05 mm on paper.
const BUCKET: i64 = 20;

/// Where panels go: from `top` down, to the `right` edge, with an additional gap between them.
#[derive(Clone, Copy)]
struct Frame {
    top: f64,
    right: f64,
    gap: f64,
}

/// Lays out panels of equal width, beginning at the left margin that their tick labels need, and
/// writes their headings and the time axis' label.
fn stack(canvas: &mut Canvas, history: &History, rows: Vec<Row>, frame: Frame) -> Stack {
    let Frame { top, right, gap } = frame;
    let widest = rows
        .iter()
        .map(|row| row.value.label_width(theme::SMALL.size))
        .fold(0.0, f64::max);
    let left = left_margin(widest);
    let width = right - left;
    let mut y = top;
    let mut panels = Vec::with_capacity(rows.len());
    let count = rows.len();
    for (k, row) in rows.into_iter().enumerate() {
        y += HEADING + if k == 0 { 0.0 } else { 4.0 + gap };
        let time = time_axis(history.time_span(), width, theme::SMALL);
        let time = if k + 1 == count {
            time
        } else {
            time.unlabelled()
        };
        let area = Rect {
            x: left,
            y,
            w: width,
            h: row.height,
        };
        let name_at = if row.value.exponent == 0 { 2.0 } else { left };
        canvas.text((name_at, y - 8.0), &row.name, Anchor::Start, theme::NAME);
        let room = width + left - name_at - text_width(&row.name, 1.1 * theme::NAME.size);
        if text_width(&row.remark, theme::REMARK.size) < room {
            canvas.text((right, y - 8.0), &row.remark, Anchor::End, theme::REMARK);
        }
        panels.push(Panel {
            area,
            time,
            value: row.value,
            bucket: BUCKET,
        });
        y += row.height;
    }
    let label_at = (left + width / 2.0, y + 34.0);
    canvas.text(
        label_at,
        &history.time_label(),
        Anchor::Middle,
        theme::LABEL,
    );
    Stack {
        panels,
        bottom: y + FOOT,
    }
}

/// The left margin for tick labels of the given width.
fn left_margin(widest: f64) -> f64 {
    (widest + 11.0).max(34.0)
}

/// The right margin: half of the last time label sticks out.
fn right_edge(history: &History) -> f64 {
    let axis = time_axis(history.time_span(), 500.0, theme::SMALL);
    theme::WIDTH - (axis.label_width(theme::SMALL.size) / 2.0 + 1.0).max(10.0)
}

/// The time from which the record is refuted, as a line through the panel.
fn mark_refuted(canvas: &mut Canvas, history: &History, panel: &Panel) {
    if let Some(t) = history.refuted_at {
        let x = panel.px(t);
        let style = format!("stroke=\"{}\" stroke-width=\"1.6\"", theme::RED);
        canvas.line((x, panel.area.y), (x, panel.area.bottom()), &style);
    }
}

/// The legend entry that goes with `mark_refuted`.
fn refuted_entry(history: &History) -> Option<Entry> {
    history.refuted_at.map(|_| Entry {
        swatch: legend::Swatch::Tick(format!("stroke=\"{}\" stroke-width=\"1.6\"", theme::RED)),
        text: "proved inconsistent".to_owned(),
    })
}

/// A word in the middle of a panel that has nothing to show.
fn mark_empty(canvas: &mut Canvas, panel: &Panel, what: &str) {
    let at = (
        panel.area.x + panel.area.w / 2.0,
        panel.area.y + panel.area.h / 2.0 + 4.0,
    );
    canvas.text(at, what, Anchor::Middle, theme::REMARK);
}

/// What to say where a series has no band to draw.
fn why_empty(history: &History) -> &'static str {
    if history.samples() == 0 {
        "no samples"
    } else {
        "no bounds"
    }
}
