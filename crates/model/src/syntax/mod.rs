//! The language inside the strings of a model file: equations, conditions, units.

pub(crate) mod ast;
pub(crate) mod number;
pub(crate) mod parse;
mod print;
pub(crate) mod token;

use std::ops::Range;

/// Something wrong in a piece of text, with offsets relative to that piece.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Problem {
    pub code: &'static str,
    pub message: String,
    pub range: Range<usize>,
    pub label: String,
    pub help: String,
}

impl Problem {
    pub fn new(
        code: &'static str,
        message: impl Into<String>,
        range: Range<usize>,
        label: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Problem {
            code,
            message: message.into(),
            range,
            label: label.into(),
            help: help.into(),
        }
    }

    /// The same problem in a text in which this one begins at `offset`.
    pub fn shifted(mut self, offset: usize) -> Self {
        self.range = self.range.start + offset..self.range.end + offset;
        self
    }
}

/// How tightly the operators bind.
pub(crate) mod strength {
    pub const ANY: u8 = 0;
    pub const OR: u8 = 1;
    pub const AND: u8 = 2;
    pub const NOT: u8 = 3;
    pub const COMPARE: u8 = 4;
    pub const SUM: u8 = 5;
    pub const PRODUCT: u8 = 6;
    pub const SIGN: u8 = 7;
    pub const POWER: u8 = 8;
    /// Names, numbers, calls and brackets.
    pub const ALONE: u8 = 9;
}
