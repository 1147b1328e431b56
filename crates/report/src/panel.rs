//! A panel: a rectangle of the picture with a time axis and a value axis.

use crate::axis::{Axis, Label, Room};
use crate::svg::{Anchor, Canvas, Font, Rect};
use crate::theme;
use crate::track::Band;

/// A rectangle and the axes mapped onto it.
#[derive(Clone, Debug)]
pub(crate) struct Panel {
    pub area: Rect,
    pub time: Axis,
    pub value: Axis,
    /// Width of a bucket of time, in hundredths of an SVG unit: see `ribbon`.
    pub bucket: i64,
}

impl Panel {
    /// Horizontal place of a time.
    pub fn px(&self, t: f64) -> f64 {
        self.area.x + self.time.position(t) * self.area.w
    }

    /// Vertical place of a value, growing downwards.
    pub fn py(&self, v: f64) -> f64 {
        self.area.bottom() - self.value.position(v) * self.area.h
    }

    /// Grid lines, to lie below the data.
    pub fn grid(&self, canvas: &mut Canvas) {
        let style = format!("stroke=\"{}\" stroke-width=\"0.6\"", theme::GRID);
        for tick in &self.value.ticks {
            let y = self.py(tick.value);
            canvas.line((self.area.x, y), (self.area.right(), y), &style);
        }
        for tick in &self.time.ticks {
            let x = self.px(tick.value);
            canvas.line((x, self.area.y), (x, self.area.bottom()), &style);
        }
    }

    /// Axis lines, ticks and tick labels, to lie above the data.
    pub fn axes(&self, canvas: &mut Canvas, font: Font) {
        let style = format!(
            "stroke=\"{}\" stroke-width=\"0.9\" stroke-linecap=\"square\"",
            theme::INK
        );
        let (left, bottom) = (self.area.x, self.area.bottom());
        canvas.line((left, self.area.y), (left, bottom), &style);
        canvas.line((left, bottom), (self.area.right(), bottom), &style);
        for tick in &self.value.ticks {
            let y = self.py(tick.value);
            canvas.line((left - 3.5, y), (left, y), &style);
            label(
                canvas,
                (left - 6.5, y + 0.36 * font.size),
                &tick.label,
                Anchor::End,
                font,
            );
        }
        for tick in &self.time.ticks {
            let x = self.px(tick.value);
            canvas.line((x, bottom), (x, bottom + 3.5), &style);
            let below = bottom + 5.0 + font.size;
            label(canvas, (x, below), &tick.label, Anchor::Middle, font);
        }
        if self.value.exponent != 0 {
            let above = (left - 4.0, self.area.y - 5.0);
            canvas.power_of_ten(above, ("\u{d7}", self.value.exponent), Anchor::End, font);
        }
        if self.time.exponent != 0 {
            let at = (self.area.right(), bottom + 2.0 * font.size + 8.0);
            canvas.power_of_ten(at, ("\u{d7}", self.time.exponent), Anchor::End, font);
        }
    }
}

fn label(canvas: &mut Canvas, at: (f64, f64), label: &Label, anchor: Anchor, font: Font) {
    match label {
        Label::Text(text) => canvas.text(at, text, anchor, font),
        Label::PowerOfTen(exponent) => canvas.power_of_ten(at, ("", *exponent), anchor, font),
        Label::None => {}
    }
}

/// A time axis over the span of the samples; a single moment gets a span around it.
pub(crate) fn time_axis(span: Option<(f64, f64)>, length: f64, font: Font) -> Axis {
    let (from, to) = span.unwrap_or((0.0, 1.0));
    let (from, to) = if from < to {
        (from, to)
    } else {
        (from - 0.5, from + 0.5)
    };
    Axis::linear(
        from,
        to,
        Room {
            length,
            spacing: 5.0 * font.size,
            font: font.size,
        },
    )
}

/// A value axis that shows all finite bounds of the bands, and the extra values, with a margin.
///
/// Bounds that start out far wider than they soon become would press the rest into a line: where
/// all but one cell in fifty fit into a tenth of the range, the axis shows these, and the band runs
/// out of the panel elsewhere.
pub(crate) fn value_axis(bands: &[Band], extra: &[f64], length: f64, font: Font) -> Axis {
    let finite = |values: &mut Vec<f64>| {
        values.retain(|v| v.is_finite());
        values.sort_by(f64::total_cmp);
    };
    let mut los: Vec<f64> = bands.iter().map(|b| b.lo).collect();
    let mut his: Vec<f64> = bands.iter().map(|b| b.hi).collect();
    finite(&mut los);
    finite(&mut his);
    let all = range(&los, &his, extra, 0);
    let most = range(&los, &his, extra, bands.len() / 50);
    let (lo, hi) = match (all, most) {
        (Some(all), Some(most)) if most.1 - most.0 < 0.1 * (all.1 - all.0) => most,
        (Some(all), _) => all,
        _ => (0.0, 1.0),
    };
    let margin = 0.05 * (hi - lo);
    let margin = if margin > 0.0 && margin.is_finite() {
        margin
    } else {
        0.05 * hi.abs()
    };
    Axis::linear(
        lo - margin,
        hi + margin,
        Room {
            length,
            spacing: 2.0 * font.size,
            font: 0.0,
        },
    )
}

/// From the least to the greatest value, leaving out `skip` values at each end. An end without any
/// finite bound is taken from the other bounds.
fn range(los: &[f64], his: &[f64], extra: &[f64], skip: usize) -> Option<(f64, f64)> {
    let low = los.get(skip).or_else(|| his.first()).copied();
    let high = his.iter().rev().nth(skip).or_else(|| los.last()).copied();
    let extra = || extra.iter().copied().filter(|v| v.is_finite());
    let lo = extra().chain(low).fold(f64::INFINITY, f64::min);
    let hi = extra().chain(high).fold(f64::NEG_INFINITY, f64::max);
    (lo <= hi).then_some((lo, hi))
}
