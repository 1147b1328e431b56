//! What can go wrong with a history or a picture.

use std::fmt;

/// Why a sample was not taken into a history, or a picture not made.
///
/// Example: [`FigureMeta`](crate::FigureMeta).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ReportError {
    /// A sample row has another number of entries than the figures were set up for.
    Shape {
        /// Which entries: `outputs`, `measured`, `states`, `params`, `modes` or `resets`.
        what: &'static str,
        /// How many the figure description names.
        expected: usize,
        /// How many the row has.
        found: usize,
    },
    /// The time of a sample is not a finite number.
    TimeNotFinite,
    /// The time of a sample is not after the time of the sample before it.
    TimeNotIncreasing {
        /// Time of the sample before, in the figures' time unit.
        before: f64,
        /// Time of the refused sample, in the figures' time unit.
        found: f64,
    },
    /// The text is not an SVG picture that can be drawn.
    NotDrawable {
        /// What the SVG reader says.
        reason: String,
    },
    /// The picture has no size, or is too large to be drawn in memory.
    Size {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },
    /// The pixels could not be written as PNG.
    Encoding {
        /// What the PNG writer says.
        reason: String,
    },
}

impl fmt::Display for ReportError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Shape {
                what,
                expected,
                found,
            } => {
                write!(
                    f,
                    "a sample has {found} {what}, the figures expect {expected}"
                )
            }
            Self::TimeNotFinite => write!(f, "the time of a sample is not a finite number"),
            Self::TimeNotIncreasing { before, found } => {
                write!(
                    f,
                    "the time of a sample, {found}, is not after the one before, {before}"
                )
            }
            Self::NotDrawable { reason } => write!(f, "the SVG picture cannot be drawn: {reason}"),
            Self::Size { width, height } => {
                write!(f, "a picture of {width} x {height} pixels cannot be made")
            }
            Self::Encoding { reason } => write!(f, "the PNG picture cannot be written: {reason}"),
        }
    }
}

impl std::error::Error for ReportError {}
