//! The frame of figures that show two quantities against each other.

use super::{BUCKET, left_margin};
use crate::axis::Axis;
use crate::legend::{self, Entry};
use crate::panel::Panel;
use crate::svg::{Anchor, Canvas, Px, Rect, push};
use crate::theme;

/// Height of the panel.
pub(super) const HEIGHT: f64 = 420.0;
/// Height of tick labels and the label below.
const FOOT: f64 = 42.0;
const HEADING: f64 = 26.0;

/// Draws the legend, and gives the panel below it; `across` makes the axis below for a width.
pub(super) fn panel(
    canvas: &mut Canvas,
    entries: &[Entry],
    value: Axis,
    across: impl FnOnce(f64) -> Axis,
) -> Panel {
    let right = theme::WIDTH - 12.0;
    let top = 4.0 + HEADING + legend::draw(canvas, entries, (2.0, right), 4.0);
    let left = left_margin(value.label_width(theme::SMALL.size));
    let area = Rect {
        x: left,
        y: top,
        w: right - left,
        h: HEIGHT,
    };
    Panel {
        area,
        time: across(area.w),
        value,
        bucket: BUCKET,
    }
}

/// Draws axes and the labels of both, and ends the figure.
pub(super) fn finish(
    mut canvas: Canvas,
    panel: &Panel,
    (x, y): (&str, &str),
    title: &str,
) -> String {
    let area = panel.area;
    panel.axes(&mut canvas, theme::SMALL);
    canvas.text((2.0, area.y - 9.0), y, Anchor::Start, theme::NAME);
    let below = (area.x + area.w / 2.0, area.bottom() + 34.0);
    canvas.text(below, x, Anchor::Middle, theme::NAME);
    canvas.finish(area.bottom() + FOOT, title)
}

/// Adds a rectangle to path data, rounded outward.
pub(super) fn rectangle(data: &mut String, panel: &Panel, x: (f64, f64), y: (f64, f64)) {
    let (left, right) = (Px::below(panel.px(x.0)), Px::above(panel.px(x.1)));
    let (top, bottom) = (Px::below(panel.py(y.1)), Px::above(panel.py(y.0)));
    push(data, format_args!("M{left} {top}H{right}V{bottom}H{left}Z"));
}
