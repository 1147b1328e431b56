//! Messages about what a user wrote: file, place, text, and one thing to do.

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// A text a user wrote, with the name under which to show it.
///
/// ```
/// use veribound_model::SourceText;
///
/// let line = SourceText::excerpt("rig.csv", "0.02,0,0.0941,1", 5);
/// assert_eq!((line.first_line, SourceText::new("m.toml", "format = 1").first_line), (5, 1));
/// ```
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
///
/// ```
/// use std::sync::Arc;
/// use veribound_model::{Diagnostic, Diagnostics, SourceText};
///
/// let source = Arc::new(SourceText::new("valve.txt", "open = 120\n"));
/// let problem = Diagnostic::new("E0608", "a valve cannot be open by more than 100 %")
///     .at(&source, 7..10, "this much")
///     .help("write a share of at most 100");
/// let told = Diagnostics::from(problem).render(false);
/// assert!(told.contains("valve.txt:1:8") && told.contains("^^^ this much"));
/// ```
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
///
/// ```
/// use veribound_model::Model;
///
/// let problems = Model::from_text("m.toml", "format = 1\nstates = [\"x\"]\ninit.x = 0\nder.x = \"y\"").unwrap_err();
/// let told = problems.render(false);
/// assert!(told.contains("error[E0201]: `y` is not declared"));
/// assert!(told.contains("--> m.toml:4:"));
/// ```
#[derive(Debug, Clone)]
pub struct Diagnostics(pub Vec<Diagnostic>);

/// More problems than this at once help nobody; the rest is counted.
const MOST_SHOWN: usize = 40;

impl Diagnostics {
    /// All problems as text: message, file, line, column, the line itself with a caret, and help.
    ///
    /// Without `color` the text holds no terminal codes and is complete without them.
    pub fn render(&self, color: bool) -> String {
        let renderer = if color {
            Renderer::styled()
        } else {
            Renderer::plain()
        };
        let mut shown: Vec<String> = self
            .0
            .iter()
            .take(MOST_SHOWN)
            .map(|one| one.render(&renderer))
            .collect();
        let rest = self.0.len().saturating_sub(MOST_SHOWN);
        if rest > 0 {
            shown.push(format!("and {rest} more\n"));
        }
        shown.join("\n")
    }
}

impl Diagnostic {
    fn render(&self, renderer: &Renderer) -> String {
        let title = Level::ERROR
            .primary_title(self.message.as_str())
            .id(self.code);
        let mut group = Group::with_title(title);
        let excerpt = self
            .place
            .as_ref()
            .map(|(source, range)| Excerpt::new(source, range));
        if let Some(excerpt) = &excerpt {
            group = group.element(
                Snippet::source(excerpt.lines)
                    .line_start(excerpt.first_line)
                    .path(excerpt.name)
                    .annotation(
                        AnnotationKind::Primary
                            .span(excerpt.range.clone())
                            .label(self.label.as_str()),
                    ),
            );
        }
        if !self.help.is_empty() {
            group = group.element(Level::HELP.message(self.help.as_str()));
        }
        let mut text = renderer.render(&[group]);
        text.push('\n');
        text
    }
}

/// The one line a problem is shown on.
struct Excerpt<'s> {
    name: &'s str,
    lines: &'s str,
    first_line: usize,
    range: Range<usize>,
}

impl<'s> Excerpt<'s> {
    /// The line where `range` begins; a range that goes on for more lines is shown up to its end.
    fn new(source: &'s SourceText, range: &Range<usize>) -> Self {
        let text = source.text.as_str();
        // A place at the very end of the text is shown behind its last line that is not empty.
        let mut start = floor_boundary(text, range.start);
        if start == text.len() {
            start = text.trim_end_matches(['\n', '\r']).len();
        }
        let (before, after) = text.split_at_checked(start).unwrap_or((text, ""));
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        let line_end = start + after.find('\n').unwrap_or(after.len());
        let lines = text
            .get(line_start..line_end)
            .unwrap_or("")
            .trim_end_matches('\r');
        let end = floor_boundary(text, range.end)
            .clamp(start, line_start + lines.len().max(start - line_start));
        Excerpt {
            name: &source.name,
            lines,
            first_line: source.first_line + before.matches('\n').count(),
            range: start - line_start..end - line_start,
        }
    }
}

/// The last character boundary of `text` that is not after `at`.
fn floor_boundary(text: &str, at: usize) -> usize {
    let mut at = at.min(text.len());
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

/// The known name that `typed` was most likely meant to be, if one is near enough to be worth a
/// question.
pub(crate) fn nearest<'k>(
    typed: &str,
    known: impl IntoIterator<Item = &'k str>,
) -> Option<&'k str> {
    let limit = match typed.chars().count() {
        0 => return None,
        1..=2 => 1,
        3..=5 => 2,
        _ => 3,
    };
    known
        .into_iter()
        .map(|name| (edit_distance(typed, name, limit), name))
        .filter(|(distance, name)| *distance <= limit && *distance < name.chars().count().max(2))
        .min()
        .map(|(_, name)| name)
}

/// Fewest insertions, deletions, changes and swaps of neighbours that turn one word into the other;
/// a change of case alone counts one. Words whose lengths alone differ by more than `limit` are not
/// compared.
#[allow(
    clippy::indexing_slicing,
    reason = "PROOF: rows have b.len() + 1 entries; i and j run over 1..=len of a and b"
)]
fn edit_distance(a: &str, b: &str, limit: usize) -> usize {
    if a.to_lowercase() == b.to_lowercase() {
        return usize::from(a != b);
    }
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    if a.len().abs_diff(b.len()) > limit || a.len().max(b.len()) > 64 {
        return usize::MAX;
    }
    let mut rows: Vec<Vec<usize>> = vec![(0..=b.len()).collect()];
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let change = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            row[j] = change.min(rows[i - 1][j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(rows[i - 2][j - 2] + 1);
            }
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}

impl From<Diagnostic> for Diagnostics {
    fn from(one: Diagnostic) -> Self {
        Diagnostics(vec![one])
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for diagnostic in &self.0 {
            writeln!(f, "{diagnostic}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Diagnostics {}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "error[{}]: {}", self.code, self.message)
    }
}

impl std::error::Error for Diagnostic {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_name_is_near() {
        let known = ["omega", "phi", "alpha", "T_Fs"];
        assert_eq!(nearest("omgea", known), Some("omega"));
        assert_eq!(nearest("T_fs", known), Some("T_Fs"));
        assert_eq!(nearest("zzz", known), None);
        assert_eq!(nearest("", known), None);
    }

    #[test]
    fn every_range_can_be_shown() {
        for text in ["", "\n", "a\r\nß = 1\n", "ßß"] {
            let source = Arc::new(SourceText::new("m.toml", text));
            for start in 0..=text.len() + 2 {
                for end in start..=text.len() + 2 {
                    let one = Diagnostic::new("E0100", "wrong").at(&source, start..end, "here");
                    assert!(Diagnostics::from(one).render(true).contains("wrong"));
                }
            }
        }
    }
}
