//! Tables of text in: lines, and the fields of a line. Records, profiles and results of earlier runs
//! are all read here, by the same rules.

pub(crate) mod fields;
pub(crate) mod lines;
pub(crate) mod source;
pub(crate) mod table;

use fields::QuoteError;
use lines::quote;
use std::ops::Range;
use veribound_model::diagnostic::Diagnostic;

/// A line of a file, as the place of a message.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line<'a> {
    /// Path as the user gave it.
    pub file: &'a str,
    pub text: &'a str,
    /// The first line is 1.
    pub number: usize,
}

impl Line<'_> {
    /// Adds `range` of this line to a message.
    pub(crate) fn mark(
        self,
        problem: Diagnostic,
        range: Range<usize>,
        label: impl Into<String>,
    ) -> Diagnostic {
        let (source, range) = quote(self.file, self.text, self.number, range);
        problem.at(&source, range, label)
    }
}

/// Whether a line is no row of the table: blank, or a comment.
pub(crate) fn is_comment(line: &str) -> bool {
    let text = line.trim();
    text.is_empty() || text.starts_with('#')
}

/// Quotes that do not enclose a whole field.
pub(crate) fn bad_quotes(line: Line<'_>, error: QuoteError) -> Diagnostic {
    let (message, range, label, help) = match error {
        QuoteError::NeverClosed(range) => (
            "a quoted field is never closed",
            range.start..range.start + 1,
            "the quote opens here",
            "add the closing quote on the same line, or remove this one",
        ),
        QuoteError::TextAfter(range) => (
            "text follows a closing quote",
            range,
            "after the quote",
            "quote the whole field, and double the quotes inside it",
        ),
    };
    line.mark(Diagnostic::new("E0406", message), range, label)
        .help(help)
}
