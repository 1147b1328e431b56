//! What stands in a string with braces.

use super::index::Index;
use crate::syntax::Problem;
use std::ops::Range;

/// Sums inside each other; each multiplies the length of the text.
const DEEPEST: usize = 8;

/// A piece of a string.
#[derive(Debug, Clone)]
pub(super) enum Part {
    /// Bytes that stand for themselves.
    Plain(Range<usize>),
    /// `{i+1}`
    Index(Index, Range<usize>),
    /// `{i=1..n}` in a name.
    Range(Binder),
    /// `sum{i=1..n}(...)`
    Fold(Fold, Binder, Vec<Part>),
}

/// `{i=first..last}` with the place of the whole.
#[derive(Debug, Clone)]
pub(super) struct Binder {
    pub name: String,
    pub first: Index,
    pub last: Index,
    pub range: Range<usize>,
}

/// How instances are joined to one value or condition.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fold {
    Sum,
    Product,
    Min,
    Max,
    All,
    Any,
}

impl Fold {
    const WORDS: [(&str, Fold); 6] = [
        ("sum", Fold::Sum),
        ("product", Fold::Product),
        ("min", Fold::Min),
        ("max", Fold::Max),
        ("all", Fold::All),
        ("any", Fold::Any),
    ];

    /// What stands before, between and behind the instances.
    pub fn joints(self) -> [&'static str; 3] {
        match self {
            Fold::Sum => ["(", " + ", ")"],
            Fold::Product => ["(", "*", ")"],
            Fold::Min => ["min(", ", ", ")"],
            Fold::Max => ["max(", ", ", ")"],
            Fold::All => ["(", " and ", ")"],
            Fold::Any => ["(", " or ", ")"],
        }
    }

    /// The value of no instance, if there is one.
    pub fn of_nothing(self) -> Option<&'static str> {
        match self {
            Fold::Sum => Some("0"),
            Fold::Product => Some("1"),
            Fold::All => Some("true"),
            Fold::Min | Fold::Max | Fold::Any => None,
        }
    }
}

/// Cuts `text` into its parts.
///
/// # Errors
/// The first brace that means nothing.
pub(super) fn read(text: &str) -> Result<Vec<Part>, Problem> {
    read_range(text, 0..text.len(), 0)
}

fn read_range(text: &str, whole: Range<usize>, depth: usize) -> Result<Vec<Part>, Problem> {
    let mut parts = Vec::new();
    let mut at = whole.start;
    let rest = |at: usize| text.get(at..whole.end).unwrap_or("");
    while let Some(found) = rest(at).find(['{', '}']) {
        let open = at + found;
        if text.as_bytes().get(open) == Some(&b'}') {
            return Err(unclosed(open, "a brace is closed that was never opened"));
        }
        let inside = rest(open + 1);
        let Some(length) = inside
            .find(['{', '}'])
            .filter(|end| inside.as_bytes().get(*end) == Some(&b'}'))
        else {
            return Err(unclosed(open, "a brace is never closed"));
        };
        let (inner, range) = (open + 1..open + 1 + length, open..open + length + 2);
        let content = text.get(inner.clone()).unwrap_or("");
        if !content.contains('=') && !content.contains("..") {
            parts.push(Part::Plain(at..open));
            let index = Index::read(text, inner).map_err(|problem| placed(problem, &range))?;
            at = range.end;
            parts.push(Part::Index(index, range));
            continue;
        }
        let mut binder = binder(text, inner, range.clone())?;
        match fold(text, at..open, rest(range.end)) {
            Some(_) if depth == DEEPEST => {
                return Err(Problem::new(
                    "E0245",
                    "sums stand too deep inside each other",
                    range,
                    format!("level {}", DEEPEST + 1),
                    "give inner sums a name in [let]",
                ));
            }
            Some((fold, word, body)) => {
                parts.push(Part::Plain(at..word));
                let start = range.end + body;
                let end = closing(text, start, whole.end).ok_or_else(|| {
                    Problem::new(
                        "E0111",
                        "a bracket is never closed",
                        start..start + 1,
                        "opened here",
                        "add the missing `)`",
                    )
                })?;
                binder.range.start = word;
                parts.push(Part::Fold(
                    fold,
                    binder,
                    read_range(text, start..end, depth + 1)?,
                ));
                at = end;
            }
            None => {
                parts.push(Part::Plain(at..open));
                parts.push(Part::Range(binder));
                at = range.end;
            }
        }
    }
    parts.push(Part::Plain(at..whole.end));
    Ok(parts)
}

fn unclosed(at: usize, message: &str) -> Problem {
    Problem::new(
        "E0240",
        message,
        at..at + 1,
        "this brace",
        "write {i} for an index and {i=1..n} for a range; group values with round brackets",
    )
}

/// An empty place gets that of the braces.
fn placed(mut problem: Problem, braces: &Range<usize>) -> Problem {
    if problem.range.is_empty() {
        problem.range = braces.clone();
    }
    problem
}

fn binder(text: &str, inner: Range<usize>, range: Range<usize>) -> Result<Binder, Problem> {
    let content = text.get(inner.clone()).unwrap_or("");
    let parts = content.split_once('=').and_then(|(name, ends)| {
        let (first, _) = ends.split_once("..")?;
        let trimmed = name.trim();
        let mut symbols = trimmed.chars();
        let begins = symbols
            .next()
            .is_some_and(|c| c.is_alphabetic() || c == '_');
        let is_name = begins && symbols.all(|c| c.is_alphanumeric() || c == '_');
        is_name.then_some((trimmed, name.len() + 1, first.len()))
    });
    let Some((name, before, length)) = parts else {
        return Err(Problem::new(
            "E0244",
            "a range in braces cannot be read",
            range,
            "not of the form {i=1..n}",
            "write the index, `=`, the first number, `..` and the last number",
        ));
    };
    let first = inner.start + before..inner.start + before + length;
    let last = first.end + 2..inner.end;
    let read = |part| Index::read(text, part).map_err(|problem| placed(problem, &range));
    Ok(Binder {
        name: name.to_string(),
        first: read(first)?,
        last: read(last)?,
        range: range.clone(),
    })
}

/// The fold whose word ends at the end of `before`, where its word begins, and how far behind the
/// braces its body begins.
fn fold(text: &str, before: Range<usize>, behind: &str) -> Option<(Fold, usize, usize)> {
    let body = behind.len() - behind.trim_start().len();
    if !behind.trim_start().starts_with('(') {
        return None;
    }
    let above = text.get(before.clone())?;
    let word = above.trim_end_matches(|c: char| c.is_alphanumeric() || c == '_');
    let word = above.get(word.len()..)?;
    let (_, fold) = Fold::WORDS.iter().find(|(known, _)| *known == word)?;
    Some((*fold, before.end - word.len(), body))
}

/// The end of the bracket that opens at `start`.
fn closing(text: &str, start: usize, limit: usize) -> Option<usize> {
    let mut depth = 0_usize;
    for (at, symbol) in text.get(start..limit)?.char_indices() {
        match symbol {
            '(' => depth += 1,
            ')' => depth = depth.checked_sub(1)?,
            _ => {}
        }
        if depth == 0 {
            return Some(start + at + 1);
        }
    }
    None
}
