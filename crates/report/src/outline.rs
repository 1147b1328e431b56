//! Text as outlines of letters, so that a picture can be drawn without fonts.
//!
//! The drawing library can shape text of all scripts; that takes as long to compile as the rest of it. Figures have
//! short labels on one line, in the alphabets of the font that comes with the program.

use std::fmt::Write as _;

use roxmltree::{Document, Node};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

use crate::error::ReportError;

/// The picture with outlines in the place of its texts.
///
/// Texts are understood as figures have them: one line, placed by `x`, `y`, `font-size`, `text-anchor`, `font-weight`
/// and `fill`, with parts (`tspan`) that have a size of their own and are shifted by `dy`.
///
/// # Errors
/// The text is no XML.
pub(crate) fn outlined(svg: &str) -> Result<String, ReportError> {
    let refuse = |reason: String| ReportError::NotDrawable { reason };
    let document = Document::parse(svg).map_err(|error| refuse(error.to_string()))?;
    let face = |font| Face::parse(font, 0).map_err(|error| refuse(error.to_string()));
    let (regular, bold) = (face(notosans::REGULAR_TTF)?, face(notosans::BOLD_TTF)?);
    let mut out = String::with_capacity(2 * svg.len());
    let mut from = 0;
    let named = |node: &Node<'_, '_>| node.tag_name().name() == "text";
    for text in document.descendants().filter(named) {
        let face = match text.attribute("font-weight") {
            Some("bold") => &bold,
            _ => &regular,
        };
        out.push_str(svg.get(from..text.range().start).unwrap_or_default());
        out.push_str(&outline(&text, face));
        from = text.range().end;
    }
    out.push_str(svg.get(from..).unwrap_or_default());
    Ok(out)
}

/// A text element as a path.
fn outline(text: &Node<'_, '_>, face: &Face<'_>) -> String {
    let number = |node: &Node<'_, '_>, name: &str| node.attribute(name)?.parse::<f64>().ok();
    let own = number(text, "font-size").unwrap_or(16.0);
    let mut pen = Pen {
        data: String::new(),
        x: 0.0,
        y: number(text, "y").unwrap_or(0.0),
        scale: 0.0,
    };
    let parts = text.descendants().filter(Node::is_text);
    let parts = parts.map(|part| {
        let holder = part.parent().unwrap_or(*text);
        let size = number(&holder, "font-size").unwrap_or(own);
        let shift = number(&holder, "dy").unwrap_or(0.0);
        (part.text().unwrap_or_default(), size, shift)
    });
    let parts: Vec<(&str, f64, f64)> = parts.collect();
    let em = f64::from(face.units_per_em());
    let glyph = |c: char| face.glyph_index(c).unwrap_or(GlyphId(0));
    let advance = |c: char| f64::from(face.glyph_hor_advance(glyph(c)).unwrap_or(0)) / em;
    let widths = parts
        .iter()
        .map(|(text, size, _)| size * text.chars().map(advance).sum::<f64>());
    let before = match text.attribute("text-anchor") {
        Some("middle") => 0.5,
        Some("end") => 1.0,
        _ => 0.0,
    };
    pen.x = number(text, "x").unwrap_or(0.0) - before * widths.sum::<f64>();
    for (text, size, shift) in parts {
        pen.y += shift;
        pen.scale = size / em;
        for c in text.chars() {
            face.outline_glyph(glyph(c), &mut pen);
            pen.x += size * advance(c);
        }
    }
    let safe = |fill: &&str| !fill.contains(['"', '<', '&']);
    let fill = text.attribute("fill").filter(safe).unwrap_or("black");
    format!("<path fill=\"{fill}\" d=\"{}\"/>", pen.data)
}

/// Where the letter at hand begins, and how large it is.
struct Pen {
    data: String,
    x: f64,
    y: f64,
    scale: f64,
}

impl Pen {
    /// Adds a command with its points; heights of letters grow upward.
    fn draw(&mut self, command: char, points: &[(f32, f32)]) {
        self.data.push(command);
        for (x, y) in points {
            let x = self.x + self.scale * f64::from(*x);
            let y = self.y - self.scale * f64::from(*y);
            // Writing into a `String` cannot fail.
            let _ = write!(self.data, "{x:.3} {y:.3} ");
        }
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        self.draw('M', &[(x, y)]);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.draw('L', &[(x, y)]);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.draw('Q', &[(x1, y1), (x, y)]);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.draw('C', &[(x1, y1), (x2, y2), (x, y)]);
    }

    fn close(&mut self) {
        self.data.push('Z');
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// First and last x of an outline.
    fn ends(svg: &str) -> (f64, f64) {
        let (_, rest) = svg.split_once(" d=\"").unwrap();
        let data = rest.split_once('"').unwrap().0;
        let numbers = data.split(|c: char| c.is_ascii_alphabetic() || c == ' ');
        let numbers: Vec<f64> = numbers.filter_map(|text| text.parse().ok()).collect();
        let x = numbers.iter().step_by(2).copied();
        x.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| {
            (lo.min(x), hi.max(x))
        })
    }

    fn text(attributes: &str, content: &str) -> String {
        let svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\"><text x=\"100\" y=\"20\" font-size=\"10\" {attributes}>{content}</text></svg>"
        );
        let drawn = outlined(&svg).unwrap();
        assert!(drawn.starts_with("<svg ") && drawn.ends_with("</svg>"));
        assert!(!drawn.contains("<text"), "{drawn}");
        drawn
    }

    #[test]
    fn texts_stand_where_their_anchor_says() {
        let (lo, hi) = ends(&text("", "HHHH"));
        let width = hi - lo;
        assert!(
            100.0 < lo && lo < 102.0 && 25.0 < width && width < 35.0,
            "{lo} {hi}"
        );
        let (lo, hi) = ends(&text("text-anchor=\"middle\"", "HHHH"));
        assert!(((lo + hi) / 2.0 - 100.0).abs() < 0.01, "{lo} {hi}");
        let (_, hi) = ends(&text("text-anchor=\"end\"", "HHHH"));
        assert!(98.0 < hi && hi < 100.0, "{hi}");
        let (lo, hi) = ends(&text("font-weight=\"bold\"", "HHHH"));
        assert!(hi - lo > width);
    }

    #[test]
    fn signs_of_xml_and_parts_are_letters() {
        assert_eq!(text("", "a&lt;b&amp;β"), text("", "a&#60;b&#38;β"));
        assert!(text("fill=\"red\"", "a").contains("<path fill=\"red\""));
        let raised = text("", "10<tspan dy=\"-4\" font-size=\"7\">-3</tspan>");
        let flat = text("", "10-3");
        assert!(ends(&raised).1 < ends(&flat).1);
        assert!(outlined("<svg>").is_err());
    }
}
