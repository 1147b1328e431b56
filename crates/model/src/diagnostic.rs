//! Messages about what a user wrote: file, place, text, and one thing to do.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// A text a user wrote, with the name under which to show it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SourceText {
    /// Path as the user gave it.
    pub name: String,
    /// The whole text, or the lines of it that messages are about.
    pub text: String,
    /// Number of the first line of `text` in what the user sees; 1 for a whole file.
    pub first_line: usize,
}

impl SourceText {
    /// A whole file.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        SourceText {
            name: name.into(),
            text: text.into(),
            first_line: 1,
        }
    }

    /// Some lines of a file that is not held in memory as a whole.
    pub fn excerpt(name: impl Into<String>, text: impl Into<String>, first_line: usize) -> Self {
        SourceText {
            name: name.into(),
            text: text.into(),
            first_line,
        }
    }
}

/// One problem in what a user wrote.
#[derive(Debug, Clone)]
pub struct Diagnostic {
    /// Stable code, for instance `E0103`.
    pub code: &'static str,
    /// One sentence that says what is wrong, in the user's names.
    pub message: String,
    /// Where: the text and the byte range in it.
    pub place: Option<(Arc<SourceText>, Range<usize>)>,
    /// What is said under the caret.
    pub label: String,
    /// One thing to do.
    pub help: String,
}

impl Diagnostic {
    /// A problem without a place in a text (an unreadable path, say).
    pub fn new(code: &'static str, message: impl Into<String>) -> Self {
        Diagnostic {
            code,
            message: message.into(),
            place: None,
            label: String::new(),
            help: String::new(),
        }
    }

    /// Adds the place, a byte range of `source`, and what is said under the caret.
    pub fn at(
        mut self,
        source: &Arc<SourceText>,
        range: Range<usize>,
        label: impl Into<String>,
    ) -> Self {
        self.place = Some((Arc::clone(source), range));
        self.label = label.into();
        self
    }

    /// Adds the one thing to do.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = help.into();
        self
    }
}

/// All problems found in one text, in the order of the text; never empty when returned as an error.
#[derive(Debug, Clone)]
pub struct Diagnostics(pub Vec<Diagnostic>);

impl From<Diagnostic> for Diagnostics {
    fn from(one: Diagnostic) -> Self {
        Diagnostics(vec![one])
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for diagnostic in &self.0 {
            writeln!(f, "error[{}]: {}", diagnostic.code, diagnostic.message)?;
        }
        Ok(())
    }
}

impl std::error::Error for Diagnostics {}
