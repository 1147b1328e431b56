//! The legend: one line above the panels, so that it never covers data.

use crate::svg::{Anchor, Canvas, Rect, text_width};
use crate::theme;

/// How a legend entry looks.
pub(crate) enum Swatch {
    /// A small area in one or more styles side by side.
    Area(Vec<String>),
    /// A small area with one style over the other.
    Layers(Vec<String>),
    /// A horizontal line.
    Line(String),
    /// A short vertical tick.
    Tick(String),
}

/// An entry: what it looks like and what it means.
pub(crate) struct Entry {
    pub swatch: Swatch,
    pub text: String,
}

impl Entry {
    pub fn area(style: String, text: impl Into<String>) -> Self {
        Self {
            swatch: Swatch::Area(vec![style]),
            text: text.into(),
        }
    }

    pub fn layers(styles: &[String], text: impl Into<String>) -> Self {
        Self {
            swatch: Swatch::Layers(styles.to_vec()),
            text: text.into(),
        }
    }

    pub fn line(style: String, text: impl Into<String>) -> Self {
        Self {
            swatch: Swatch::Line(style),
            text: text.into(),
        }
    }
}

const SWATCH: f64 = 24.0;
const ROW: f64 = 18.0;

/// Draws the entries from the left edge on, in as many rows as they need between the edges, below
/// the height `top`; returns the height taken.
pub(crate) fn draw(canvas: &mut Canvas, entries: &[Entry], edges: (f64, f64), top: f64) -> f64 {
    let font = theme::SMALL;
    let (left, right) = edges;
    let (mut x, mut y) = (left, top);
    for entry in entries {
        let width = SWATCH + 6.0 + text_width(&entry.text, font.size);
        if x > left && x + width > right {
            x = left;
            y += ROW;
        }
        let middle = y + ROW / 2.0;
        let area = |x: f64, w: f64| Rect {
            x,
            y: middle - 4.5,
            w,
            h: 9.0,
        };
        match &entry.swatch {
            Swatch::Area(styles) => {
                let part = SWATCH / styles.len().max(1) as f64;
                for (k, style) in styles.iter().enumerate() {
                    canvas.rect(area(x + part * k as f64, part), style);
                }
            }
            Swatch::Layers(styles) => {
                for style in styles {
                    canvas.rect(area(x, SWATCH), style);
                }
            }
            Swatch::Line(style) => canvas.line((x, middle), (x + SWATCH, middle), style),
            Swatch::Tick(style) => {
                let at = x + SWATCH - 5.0;
                canvas.line((at, middle - 4.5), (at, middle + 4.5), style);
            }
        }
        let baseline = middle + 0.36 * font.size;
        canvas.text(
            (x + SWATCH + 6.0, baseline),
            &entry.text,
            Anchor::Start,
            font,
        );
        x += width + 18.0;
    }
    if entries.is_empty() {
        0.0
    } else {
        y + ROW - top
    }
}
