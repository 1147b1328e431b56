//! Strings of the file with the place of every byte, so that a message can point into them.

use crate::diagnostic::{Diagnostic, SourceText};
use crate::syntax::Problem;
use std::ops::Range;
use std::sync::Arc;

/// A string value: what it means and where each byte of it stands in the file.
#[derive(Debug, Clone)]
pub(crate) struct Text {
    pub value: String,
    /// The whole value in the file, with its quotes.
    pub range: Range<usize>,
    /// For every byte of `value` and for its end, the offset in the file; empty when unknown.
    places: Vec<usize>,
}

impl Text {
    /// The string `value` that is written at `range` of `source`.
    pub fn new(source: &str, range: Range<usize>, value: &str) -> Self {
        let raw = source.get(range.clone()).unwrap_or("");
        let places = places(raw)
            // The map is used only if it yields what the TOML reader understood.
            .filter(|(decoded, _)| decoded == value)
            .map(|(_, places)| places.into_iter().map(|at| at + range.start).collect())
            .unwrap_or_default();
        Text {
            value: value.to_string(),
            range,
            places,
        }
    }

    /// The place in the file of a range of the value.
    pub fn place(&self, inside: Range<usize>) -> Range<usize> {
        match (self.places.get(inside.start), self.places.get(inside.end)) {
            (Some(start), Some(end)) => *start..*end,
            _ => self.range.clone(),
        }
    }

    /// A problem inside the value as a message about the file.
    pub fn diagnose(&self, source: &Arc<SourceText>, problem: Problem) -> Diagnostic {
        Diagnostic::new(problem.code, problem.message)
            .at(source, self.place(problem.range), problem.label)
            .help(problem.help)
    }
}

/// Decodes a TOML string literal and gives for each byte of the result (and its end) the offset in
/// `raw`. `None` for anything that is not such a literal.
fn places(raw: &str) -> Option<(String, Vec<usize>)> {
    let (quotes, escapes) = match raw {
        _ if raw.starts_with("\"\"\"") => (3, true),
        _ if raw.starts_with("'''") => (3, false),
        _ if raw.starts_with('"') => (1, true),
        _ if raw.starts_with('\'') => (1, false),
        _ => return None,
    };
    let inner = raw.get(quotes..)?.strip_suffix(raw.get(..quotes)?)?;
    let mut decoded = String::new();
    let mut map = Vec::new();
    let mut rest = inner.char_indices().peekable();
    // A line break directly after the opening quotes does not belong to the value.
    if quotes == 3 {
        rest.next_if(|(_, c)| *c == '\r');
        rest.next_if(|(_, c)| *c == '\n');
    }
    let mut push = |symbol: char, at: usize| {
        decoded.push(symbol);
        map.extend(std::iter::repeat_n(at + quotes, symbol.len_utf8()));
    };
    while let Some((at, symbol)) = rest.next() {
        if !(escapes && symbol == '\\') {
            push(symbol, at);
            continue;
        }
        let (_, escape) = rest.next()?;
        match escape {
            'b' => push('\u{8}', at),
            't' => push('\t', at),
            'n' => push('\n', at),
            'f' => push('\u{c}', at),
            'r' => push('\r', at),
            'e' => push('\u{1b}', at),
            '"' | '\\' => push(escape, at),
            'x' | 'u' | 'U' => {
                let digits = match escape {
                    'x' => 2,
                    'u' => 4,
                    _ => 8,
                };
                let mut code = 0_u32;
                for _ in 0..digits {
                    code = code * 16 + rest.next()?.1.to_digit(16)?;
                }
                push(char::from_u32(code)?, at);
            }
            // A backslash at the end of a line swallows all blanks that follow.
            _ if escape.is_whitespace() => {
                while rest.next_if(|(_, c)| c.is_whitespace()).is_some() {}
            }
            _ => return None,
        }
    }
    map.push(quotes + inner.len());
    Some((decoded, map))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_and_line_breaks_are_followed() {
        let (decoded, map) = places(r#""a\tb\u00e9c""#).unwrap();
        assert_eq!(decoded, "a\tbéc");
        assert_eq!(map, [1, 2, 4, 5, 5, 11, 12]);
        let (decoded, map) = places("\"\"\"\na\\\n   b\"\"\"").unwrap();
        assert_eq!(decoded, "ab");
        assert_eq!(map, [4, 10, 11]);
        let (decoded, _) = places(r"'a\tb'").unwrap();
        assert_eq!(decoded, r"a\tb");
        assert_eq!(places("12"), None);
        assert_eq!(places("\""), None);
        assert_eq!(places("\"\\"), None);
    }
}
