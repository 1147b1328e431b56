//! Writing SVG: every coordinate is a whole number of hundredths, rounded in a direction that is
//! chosen where it is made, so that no NaN, no exponent and no inward rounding can reach the file.

use std::fmt::{self, Write as _};

/// A coordinate in hundredths of an SVG unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Px(pub i64);

/// Slack, in hundredths, for the rounding errors of mapping a value into the picture. These are a
/// few units in the last place of a number below 10^7, hence below 10^-8.
const SLACK: f64 = 1e-6;

impl Px {
    /// The nearest coordinate, for everything that is not a bound.
    pub fn near(x: f64) -> Self {
        Self((x * 100.0).round() as i64)
    }

    /// A coordinate certainly not above x.
    pub fn below(x: f64) -> Self {
        Self((x * 100.0 - SLACK).floor() as i64)
    }

    /// A coordinate certainly not below x.
    pub fn above(x: f64) -> Self {
        Self((x * 100.0 + SLACK).ceil() as i64)
    }
}

impl fmt::Display for Px {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (whole, rest) = (self.0.unsigned_abs() / 100, self.0.unsigned_abs() % 100);
        let sign = if self.0 < 0 { "-" } else { "" };
        match (rest % 10, rest) {
            (_, 0) => write!(f, "{sign}{whole}"),
            (0, _) => write!(f, "{sign}{whole}.{}", rest / 10),
            _ => write!(f, "{sign}{whole}.{rest:02}"),
        }
    }
}

/// An axis-parallel rectangle in SVG units, y downwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rect {
    pub x: f64,
    pub y: f64,
    pub w: f64,
    pub h: f64,
}

impl Rect {
    pub fn right(self) -> f64 {
        self.x + self.w
    }

    pub fn bottom(self) -> f64 {
        self.y + self.h
    }
}

/// Which point of a text lies at its position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// Size, colour and weight of a text.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Font {
    pub size: f64,
    pub color: &'static str,
    pub bold: bool,
}

/// An SVG picture in the making.
pub(crate) struct Canvas {
    name: String,
    width: f64,
    defs: String,
    body: String,
    ids: usize,
}

/// Sans-serif fonts of the usual systems; all have similar widths.
const FONTS: &str = "Helvetica Neue, Helvetica, Arial, Liberation Sans, Noto Sans, sans-serif";

impl Canvas {
    /// An empty picture; `name` makes its ids unique among the figures put into one document.
    pub fn new(name: &str, width: f64) -> Self {
        Self {
            name: name.to_owned(),
            width,
            defs: String::new(),
            body: String::new(),
            ids: 0,
        }
    }

    /// The whole SVG text, once the height is known.
    pub fn finish(self, height: f64, title: &str) -> String {
        let (w, h) = (Px::near(self.width), Px::near(height));
        let title = escape(title);
        let title = if title.is_empty() {
            String::new()
        } else {
            format!("<title>{title}</title>\n")
        };
        let defs = if self.defs.is_empty() {
            String::new()
        } else {
            format!("<defs>\n{}</defs>\n", self.defs)
        };
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" \
             viewBox=\"0 0 {w} {h}\" font-family=\"{FONTS}\">\n{title}{defs}\
             <rect width=\"{w}\" height=\"{h}\" fill=\"#fff\"/>\n{}</svg>\n",
            self.body
        )
    }

    fn fresh_id(&mut self) -> String {
        self.ids += 1;
        format!("veribound-{}-{}", self.name, self.ids)
    }

    /// A group that shows only what lies in the rectangle, to be closed with `close`.
    pub fn open_clip(&mut self, r: Rect) {
        let id = self.fresh_id();
        let (x, y, w, h) = (Px::near(r.x), Px::near(r.y), Px::near(r.w), Px::near(r.h));
        push(
            &mut self.defs,
            format_args!(
                "<clipPath id=\"{id}\"><rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"/>\
                 </clipPath>\n"
            ),
        );
        push(
            &mut self.body,
            format_args!("<g clip-path=\"url(#{id})\">\n"),
        );
    }

    /// Ends the group begun last.
    pub fn close(&mut self) {
        self.body.push_str("</g>\n");
    }

    /// A fill of slanted lines on a ground, as a value for `fill`.
    pub fn hatch(&mut self, line: &str, ground: &str) -> String {
        let ground = format!("<rect width=\"4\" height=\"4\" fill=\"{ground}\"/>");
        self.pattern(line, &ground, (45, 4))
    }

    /// A fill of lines at this angle in degrees and so far apart, on nothing: what is below is seen between
    /// them, without the seams that the tiles of a pattern leave.
    pub fn lines(&mut self, line: &str, (angle, gap): (i32, i32)) -> String {
        self.pattern(line, "", (angle, gap))
    }

    fn pattern(&mut self, line: &str, ground: &str, (angle, gap): (i32, i32)) -> String {
        let id = self.fresh_id();
        push(
            &mut self.defs,
            format_args!(
                "<pattern id=\"{id}\" width=\"{gap}\" height=\"{gap}\" patternUnits=\"userSpaceOnUse\" \
                 patternTransform=\"rotate({angle})\">{ground}\
                 <rect width=\"1.1\" height=\"{gap}\" fill=\"{line}\"/></pattern>\n"
            ),
        );
        format!("url(#{id})")
    }

    /// A rectangle; `style` holds its SVG attributes.
    pub fn rect(&mut self, r: Rect, style: &str) {
        let (x, y, w, h) = (Px::near(r.x), Px::near(r.y), Px::near(r.w), Px::near(r.h));
        push(
            &mut self.body,
            format_args!("<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" {style}/>\n"),
        );
    }

    /// A straight line; `style` holds its SVG attributes.
    pub fn line(&mut self, from: (f64, f64), to: (f64, f64), style: &str) {
        let (x1, y1, x2, y2) = (
            Px::near(from.0),
            Px::near(from.1),
            Px::near(to.0),
            Px::near(to.1),
        );
        push(
            &mut self.body,
            format_args!("<path d=\"M{x1} {y1}L{x2} {y2}\" fill=\"none\" {style}/>\n"),
        );
    }

    /// A path of given data; an empty one is left out.
    pub fn path(&mut self, data: &str, style: &str) {
        if !data.is_empty() {
            push(
                &mut self.body,
                format_args!("<path d=\"{data}\" {style}/>\n"),
            );
        }
    }

    /// A path in several styles, one over the other.
    pub fn layers(&mut self, data: &str, styles: &[String]) {
        styles.iter().for_each(|style| self.path(data, style));
    }

    /// A text on one line, with its baseline at the position.
    pub fn text(&mut self, at: (f64, f64), text: &str, anchor: Anchor, font: Font) {
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let bold = if font.bold {
            " font-weight=\"bold\""
        } else {
            ""
        };
        let (x, y, size) = (Px::near(at.0), Px::near(at.1), Px::near(font.size));
        push(
            &mut self.body,
            format_args!(
                "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" fill=\"{}\"{anchor}{bold}>{}</text>\n",
                font.color,
                escape(text)
            ),
        );
    }

    /// A power of ten, `prefix 10^exponent`, with its baseline at the position.
    pub fn power_of_ten(&mut self, at: (f64, f64), text: (&str, i32), anchor: Anchor, font: Font) {
        let (prefix, exponent) = text;
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let (x, y, size) = (Px::near(at.0), Px::near(at.1), Px::near(font.size));
        let (raise, small) = (Px::near(-0.38 * font.size), Px::near(0.72 * font.size));
        let exponent = exponent.to_string().replace('-', "\u{2212}");
        push(
            &mut self.body,
            format_args!(
                "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" fill=\"{}\"{anchor}>{}10\
                 <tspan dy=\"{raise}\" font-size=\"{small}\">{exponent}</tspan></text>\n",
                font.color,
                escape(prefix)
            ),
        );
    }
}

/// Appends formatted text; writing into a `String` cannot fail.
pub(crate) fn push(out: &mut String, text: fmt::Arguments<'_>) {
    let _ = out.write_fmt(text);
}

/// A text with the characters of XML's own syntax, and those XML cannot hold, made harmless.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\u{FFFE}' | '\u{FFFF}' => out.push('\u{FFFD}'),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// A width that the text does not exceed in any of the fonts named, in SVG units.
pub(crate) fn text_width(text: &str, size: f64) -> f64 {
    let em: f64 = text
        .chars()
        .map(|c| match c {
            'i' | 'j' | 'l' | 'I' | '.' | ',' | ':' | ';' | '|' | '\'' | ' ' => 0.3,
            'f' | 't' | 'r' | '[' | ']' | '(' | ')' | '/' => 0.41,
            'm' | 'w' | 'M' | 'W' | '%' | '@' => 0.95,
            c if c.is_ascii_uppercase() => 0.74,
            c if c.is_ascii() => 0.6,
            '\u{2212}' => 0.6,
            c if (c as u32) < 0x1100 => 0.75,
            _ => 1.05,
        })
        .sum();
    em * size
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_short_decimals() {
        let shown: Vec<String> = [0, 5, -5, 50, 100, -1234, 1230]
            .iter()
            .map(|h| Px(*h).to_string())
            .collect();
        assert_eq!(shown, ["0", "0.05", "-0.05", "0.5", "1", "-12.34", "12.3"]);
    }

    #[test]
    fn nothing_but_numbers_comes_of_strange_values() {
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
            for px in [Px::near(x), Px::below(x), Px::above(x)] {
                assert!(
                    px.to_string()
                        .chars()
                        .all(|c| c.is_ascii_digit() || "-.".contains(c))
                );
            }
        }
    }

    #[test]
    fn rounding_keeps_its_side() {
        for k in 0..10_000 {
            let x = f64::from(k) * 0.0371 - 100.0;
            assert!(Px::below(x).0 as f64 / 100.0 <= x && x <= Px::above(x).0 as f64 / 100.0);
        }
    }

    #[test]
    fn names_cannot_break_the_markup() {
        assert_eq!(escape("a<b>&\"c\u{1}"), "a&lt;b&gt;&amp;&quot;c ");
    }
}
