//! Bounds of parameters from both sides: a panel for each.

use super::titled;
use crate::axis::{Axis, Room};
use crate::identification::{Identification, ProvedParameter};
use crate::legend::{self, Entry};
use crate::panel::Panel;
use crate::svg::{Anchor, Canvas, Px, Rect, push, text_width};
use crate::theme;
use veribound_interval::{Interval, text};

/// Height of the name above each panel.
const HEADING: f64 = 22.0;
/// Height of the strip that shows the whole prior, and of the way from there to the enlargement.
const STRIP: f64 = 8.0;
const WAY: f64 = 18.0;
/// Height of the panel.
const HEIGHT: f64 = 40.0;
/// Height of the tick labels below it, and room to the next.
const FOOT: f64 = 32.0;

/// The prior is shown apart where what is left of it is less than this part.
const SMALL_PART: f64 = 0.3;

impl Identification {
    /// Of every parameter the prior, what holds all values, and what is reached.
    pub(crate) fn draw_bounds(&self) -> String {
        let mut canvas = Canvas::new("bounds", theme::WIDTH);
        let inner = theme::inside(&mut canvas);
        let right = theme::WIDTH - 24.0;
        let mut entries = vec![
            Entry::area(theme::band(theme::BLUE), "outer: proved to hold all values"),
            Entry::layers(&inner, "inner: proved to be reached"),
        ];
        let is_bounded =
            |param: &ProvedParameter| param.prior.0.is_finite() || param.prior.1.is_finite();
        if self.params.iter().any(is_bounded) {
            entries.push(Entry::line(theme::prior(), "prior"));
        }
        let mut y = 8.0 + legend::draw(&mut canvas, &entries, (2.0, right), 4.0);
        for param in &self.params {
            y = draw(&mut canvas, param, (y, right), &inner);
        }
        canvas.finish(y, &titled(&self.title, "proved bounds of the parameters"))
    }
}

/// Draws one parameter from `top` down; returns where it ends.
fn draw(
    canvas: &mut Canvas,
    param: &ProvedParameter,
    (top, right): (f64, f64),
    inner: &[String],
) -> f64 {
    let left = 24.0;
    let mut y = top + HEADING;
    let name = param.quantity.label();
    canvas.text((2.0, y - 8.0), &name, Anchor::Start, theme::NAME);
    let remark = remark(param);
    let room = right - 2.0 - text_width(&name, 1.1 * theme::NAME.size);
    if text_width(&remark, theme::REMARK.size) < room {
        canvas.text((right, y - 8.0), &remark, Anchor::End, theme::REMARK);
    }
    let area = |y: f64, h: f64| Rect {
        x: left,
        y,
        w: right - left,
        h,
    };
    let ((lo, hi), is_part) = view(param);
    if is_part {
        let strip = panel(area(y, STRIP), param.prior);
        draw_strip(canvas, &strip, param);
        if let Some(outer) = param.outer {
            let below = panel(area(y + STRIP + WAY, HEIGHT), (lo, hi));
            for end in [outer.0, outer.1] {
                let from = (strip.px(end), strip.area.bottom());
                canvas.line(from, (below.px(end), below.area.y), &theme::guide());
            }
        }
        y += STRIP + WAY;
    }
    let panel = panel(area(y, HEIGHT), (lo, hi));
    panel.grid(canvas);
    canvas.open_clip(panel.area);
    let outer = param.outer.map(|outer| wide(&panel, outer, 0.0));
    canvas.path(&outer.unwrap_or_default(), &theme::band(theme::BLUE));
    if let Some(bounds) = param.inner {
        match narrow(&panel, bounds, 0.28 * HEIGHT) {
            Some(data) => canvas.layers(&data, inner),
            // Too narrow for the picture: a mark where it is.
            None => {
                let x = panel.px(bounds.0 / 2.0 + bounds.1 / 2.0);
                let style = format!("stroke=\"{}\" stroke-width=\"1\"", theme::INSIDE);
                canvas.line((x, y + 0.28 * HEIGHT), (x, y + 0.72 * HEIGHT), &style);
            }
        }
    }
    canvas.close();
    for end in [param.prior.0, param.prior.1] {
        if lo <= end && end <= hi {
            let x = panel.px(end);
            canvas.line((x, y), (x, y + HEIGHT), &theme::prior());
        }
    }
    panel.axes(canvas, theme::SMALL);
    y + HEIGHT + FOOT
}

/// The range that the panel shows, and whether that is only a small part of the prior.
fn view(param: &ProvedParameter) -> ((f64, f64), bool) {
    let prior = param.prior;
    let is_bounded = prior.0.is_finite() && prior.1.is_finite();
    let (lo, hi) = param.outer.unwrap_or(prior);
    let finite = |x: f64, other: f64| if x.is_finite() { x } else { other };
    let (lo, hi) = (finite(lo, hi.min(0.0) - 1.0), finite(hi, lo.max(0.0) + 1.0));
    let is_part = is_bounded && hi - lo < SMALL_PART * (prior.1 - prior.0);
    let (lo, hi) = if is_part || !is_bounded {
        (lo, hi)
    } else {
        prior
    };
    let margin = if is_part { 0.2 } else { 0.05 } * (hi - lo);
    let margin = if margin > 0.0 {
        margin
    } else {
        0.05 * hi.abs()
    };
    ((lo - margin, hi + margin), is_part)
}

/// The whole prior in a narrow strip, with its ends as text, and the place of the outer bounds.
fn draw_strip(canvas: &mut Canvas, strip: &Panel, param: &ProvedParameter) {
    let area = strip.area;
    let middle = area.y + area.h / 2.0;
    let style = format!("stroke=\"{}\" stroke-width=\"0.9\"", theme::GREY_EDGE);
    canvas.line((area.x, middle), (area.right(), middle), &style);
    if let Some(outer) = param.outer {
        canvas.path(&wide(strip, outer, 0.0), &theme::band(theme::BLUE));
    }
    let prior = Interval::new(param.prior.0, param.prior.1).unwrap_or(Interval::ENTIRE);
    let (lo, hi) = text::spelled(prior);
    let below = area.bottom() + 10.0;
    for (x, end, anchor) in [(area.x, lo, Anchor::Start), (area.right(), hi, Anchor::End)] {
        canvas.line((x, area.y - 2.0), (x, area.bottom() + 2.0), &theme::prior());
        let inward = if anchor == Anchor::End { -4.0 } else { 4.0 };
        let shown = end.replace('-', "\u{2212}");
        canvas.text((x + inward, below), &shown, anchor, theme::TINY);
    }
}

/// A panel over a range, with room for its labels.
fn panel(area: Rect, (lo, hi): (f64, f64)) -> Panel {
    let size = theme::SMALL.size;
    let room = |length, font| Room {
        length,
        spacing: 5.0 * size,
        font,
    };
    let mut value = Axis::linear(0.0, 1.0, room(area.h, 0.0));
    value.ticks.clear();
    Panel {
        area,
        time: Axis::linear(lo, hi, room(area.w, size)),
        value,
        bucket: super::BUCKET,
    }
}

/// Bounds as an upright band, not narrower than they are.
fn wide(panel: &Panel, (lo, hi): (f64, f64), inset: f64) -> String {
    upright(
        panel,
        Px::below(panel.px(lo)),
        Px::above(panel.px(hi)),
        inset,
    )
}

/// Bounds as an upright band, not wider than they are; `None` where that is nothing.
fn narrow(panel: &Panel, (lo, hi): (f64, f64), inset: f64) -> Option<String> {
    let (left, right) = (Px::above(panel.px(lo)), Px::below(panel.px(hi)));
    (left < right).then(|| upright(panel, left, right, inset))
}

fn upright(panel: &Panel, left: Px, right: Px, inset: f64) -> String {
    let top = Px::near(panel.area.y + inset);
    let bottom = Px::near(panel.area.bottom() - inset);
    let mut data = String::new();
    push(
        &mut data,
        format_args!("M{left} {top}H{right}V{bottom}H{left}Z"),
    );
    data
}

/// The outer bounds, and how far from the best they are at most.
fn remark(param: &ProvedParameter) -> String {
    let Some(outer) = param.outer.and_then(|(lo, hi)| Interval::new(lo, hi)) else {
        return "no value is left".to_owned();
    };
    let prior = Interval::new(param.prior.0, param.prior.1).unwrap_or(Interval::ENTIRE);
    let (lo, hi) = text::inside_prior(text::readable(outer), outer, prior);
    let bounds = format!("[{lo}, {hi}]").replace('-', "\u{2212}");
    if param.tightness.is_finite() {
        let times = text::upper(param.tightness, 4);
        format!("{bounds}, at most {times} times the exact width")
    } else {
        bounds
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::meta::Quantity;

    fn param(outer: (f64, f64), inner: Option<(f64, f64)>) -> ProvedParameter {
        ProvedParameter {
            quantity: Quantity::new("k", ""),
            prior: (0.0, 100.0),
            outer: Some(outer),
            inner,
            tightness: 1.5,
        }
    }

    /// Outer bounds are rounded outward, inner ones inward.
    #[test]
    fn neither_side_claims_more_than_is_proved() {
        let area = Rect {
            x: 24.0,
            y: 10.0,
            w: 577.7,
            h: HEIGHT,
        };
        let panel = panel(area, (1.0, 4.0));
        let ends = |data: &str| {
            let numbers: Vec<f64> = data
                .split(|c: char| !c.is_ascii_digit() && c != '.')
                .filter_map(|text| text.parse().ok())
                .collect();
            (numbers[0], numbers[2])
        };
        for k in 0..500 {
            let lo = 1.0 + f64::from(k) * 0.003_7;
            let bounds = (lo, lo + 0.01 + f64::from(k) * 1e-4);
            let (left, right) = ends(&wide(&panel, bounds, 0.0));
            assert!(left <= panel.px(bounds.0) && panel.px(bounds.1) <= right);
            let (left, right) = ends(&narrow(&panel, bounds, 3.0).unwrap());
            assert!(left >= panel.px(bounds.0) && panel.px(bounds.1) >= right);
        }
        assert_eq!(narrow(&panel, (2.0, 2.0), 0.0), None);
    }

    #[test]
    fn a_small_part_of_the_prior_is_enlarged() {
        assert_eq!(view(&param((40.0, 50.0), None)), ((38.0, 52.0), true));
        assert_eq!(view(&param((10.0, 50.0), None)), ((-5.0, 105.0), false));
        let nothing = ProvedParameter {
            outer: None,
            ..param((0.0, 1.0), None)
        };
        assert_eq!(view(&nothing), ((-5.0, 105.0), false));
        let unbounded = ProvedParameter {
            prior: (f64::NEG_INFINITY, f64::INFINITY),
            ..param((2.0, f64::INFINITY), None)
        };
        let ((lo, hi), is_part) = view(&unbounded);
        assert!(lo < 2.0 && hi > 3.0 && hi.is_finite() && !is_part);
    }

    #[test]
    fn the_remark_tells_the_outer_bounds() {
        let told = remark(&param((-2.652_81, 1.537_49), Some((0.0, 1.0))));
        assert_eq!(
            told,
            "[\u{2212}2.66, 1.54], at most 1.5 times the exact width"
        );
    }
}
