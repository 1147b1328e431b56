//! Colours, sizes and line styles of all figures.
//!
//! The colours are those of Okabe and Ito, which people with any common colour blindness tell
//! apart; their order below alternates light and dark, so that neighbours differ in grey print.

use crate::svg::{Canvas, Font};

/// Proved to agree, proved not to, and neither.
pub(crate) const INSIDE: &str = "#009E73";
pub(crate) const OUTSIDE: &str = "#56B4E9";
pub(crate) const UNDECIDED: &str = "#E69F00";
/// Proved enclosures of outputs and states.
pub(crate) const BLUE: &str = "#0072B2";
/// Parameters, by position.
const PARAMETERS: [&str; 6] = [
    "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#0072B2",
];
/// The proved inconsistency.
pub(crate) const RED: &str = "#A0001C";
/// Boxes and time spent.
const WORK: &str = "#3F4B59";
/// Measured bands: their fill and their edge.
pub(crate) const GREY: &str = "#C9C9C9";
pub(crate) const GREY_EDGE: &str = "#8F8F8F";
/// Text and axes.
pub(crate) const INK: &str = "#1A1A1A";
pub(crate) const SOFT: &str = "#555555";
pub(crate) const GRID: &str = "#E4E4E4";

/// Natural width in SVG units of 1/96 inch: 169 mm, the text width of a page.
pub(crate) const WIDTH: f64 = 640.0;

/// Axis labels and panel headings: 9 points in natural size.
pub(crate) const LABEL: Font = Font {
    size: 12.0,
    color: INK,
    bold: false,
};
/// Names of panels.
pub(crate) const NAME: Font = Font {
    size: 12.0,
    color: INK,
    bold: true,
};
/// Tick labels, legends and remarks.
pub(crate) const SMALL: Font = Font {
    size: 11.0,
    color: INK,
    bold: false,
};
pub(crate) const REMARK: Font = Font {
    size: 11.0,
    color: SOFT,
    bold: false,
};
/// Tick labels of an inset.
pub(crate) const TINY: Font = Font {
    size: 9.5,
    color: INK,
    bold: false,
};

/// The colour of parameter `i` in every figure.
pub(crate) fn parameter(i: usize) -> &'static str {
    PARAMETERS
        .get(i % PARAMETERS.len())
        .copied()
        .unwrap_or(BLUE)
}

/// Style of a band: tinted inside, with an edge that stays visible however thin the band is.
pub(crate) fn band(color: &str) -> String {
    format!(
        "fill=\"{color}\" fill-opacity=\"0.38\" stroke=\"{color}\" stroke-width=\"0.8\" \
         stroke-linejoin=\"round\""
    )
}

/// Style of what holds at all times between those of the table.
pub(crate) fn tube() -> String {
    "fill=\"#BFDDF0\" stroke=\"#8FC1E2\" stroke-width=\"0.8\" stroke-linejoin=\"round\"".to_owned()
}

/// Style of a union of boxes: the edges between them are not seen.
pub(crate) fn union() -> String {
    "fill=\"#9CCBE8\" stroke=\"#9CCBE8\" stroke-width=\"1\" stroke-linejoin=\"round\"".to_owned()
}

/// Style of the set at the start.
pub(crate) fn start() -> String {
    format!("fill=\"{INSIDE}\" fill-opacity=\"0.38\" stroke=\"{INSIDE}\" stroke-width=\"0.8\"")
}

/// Styles of what is proved inside, one over the other: colour, and lines that stay apart from the others in
/// grey print.
pub(crate) fn inside(canvas: &mut Canvas) -> [String; 2] {
    let lines = canvas.lines("#00604A", (-45, 6));
    [format!("fill=\"{INSIDE}\""), format!("fill=\"{lines}\"")]
}

/// Styles of what is proved outside.
pub(crate) fn outside(canvas: &mut Canvas) -> [String; 2] {
    let lines = canvas.lines(OUTSIDE, (45, 5));
    ["fill=\"#E3F2FB\"".to_owned(), format!("fill=\"{lines}\"")]
}

/// Styles of what is undecided: an edge keeps it visible however thin it is.
pub(crate) fn undecided(canvas: &mut Canvas) -> [String; 2] {
    let lines = canvas.lines("#FFD98A", (0, 3));
    let edge = format!("stroke=\"{UNDECIDED}\" stroke-width=\"0.7\" stroke-linejoin=\"round\"");
    [
        format!("fill=\"{UNDECIDED}\" {edge}"),
        format!("fill=\"{lines}\""),
    ]
}

/// Style of the edges between tiles.
pub(crate) fn edges() -> String {
    format!("fill=\"none\" stroke=\"{INK}\" stroke-opacity=\"0.35\" stroke-width=\"0.35\"")
}

/// Style of lines from a range to its enlargement.
pub(crate) fn guide() -> String {
    format!("stroke=\"{SOFT}\" stroke-width=\"0.6\"")
}

/// Style of a true trajectory.
pub(crate) fn trajectory() -> String {
    format!("stroke=\"{INK}\" stroke-width=\"0.5\" stroke-linejoin=\"round\"")
}

/// Style of a measured band.
pub(crate) fn measured() -> String {
    format!("fill=\"{GREY}\" stroke=\"{GREY_EDGE}\" stroke-width=\"0.5\" stroke-linejoin=\"round\"")
}

/// Style of a compared run's band: hatched, with a dark broken edge.
pub(crate) fn compared(hatch: &str) -> String {
    format!("fill=\"{hatch}\" stroke=\"{INK}\" stroke-width=\"0.8\" stroke-linejoin=\"round\"")
}

/// Style of the range of a count or a time over neighbouring samples.
pub(crate) fn work() -> String {
    format!("fill=\"{WORK}\" fill-opacity=\"0.75\" stroke=\"{WORK}\" stroke-width=\"0.5\"")
}

/// Style of the area below it.
pub(crate) fn below_work() -> String {
    format!("fill=\"{WORK}\" fill-opacity=\"0.14\"")
}

/// Style of prior bounds.
pub(crate) fn prior() -> String {
    format!(
        "stroke=\"{INK}\" stroke-width=\"1.3\" stroke-dasharray=\"0.1 3.2\" stroke-linecap=\"round\""
    )
}

/// Style of a nominal value or a deadline.
pub(crate) fn dashed() -> String {
    format!("stroke=\"{INK}\" stroke-width=\"0.9\" stroke-dasharray=\"6 3.5\"")
}

/// Style of the tick of a reset.
pub(crate) fn reset() -> String {
    format!("stroke=\"{INK}\" stroke-width=\"1.2\"")
}
