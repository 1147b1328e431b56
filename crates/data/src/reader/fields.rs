//! Fields of one line: separator, quotes, and where each field stands.
//!
//! The grammar is the strict part of CSV: one sample is one line; a field is quoted as a whole or not
//! at all. Readers that also take `"0.5"6` for 0.56, or that let a forgotten quote swallow the
//! following lines, would change numbers silently; here both are errors with their place.

use std::borrow::Cow;
use std::ops::Range;

/// What is wrong with the quotes of a line, and where.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum QuoteError {
    /// The line ends inside a quoted field that starts here.
    NeverClosed(Range<usize>),
    /// Text between a closing quote and the next separator.
    TextAfter(Range<usize>),
}

/// The separator a header line is written with: a tab where one occurs, else a semicolon, else a comma.
///
/// A semicolon goes before a comma because files with semicolons use commas inside names or
/// numbers, and not the other way round.
pub(crate) fn separator(header: &str) -> char {
    let mut quoted = false;
    let mut found = ',';
    for c in header.chars() {
        match c {
            '"' => quoted = !quoted,
            '\t' if !quoted => return '\t',
            ';' if !quoted => found = ';',
            _ => {}
        }
    }
    found
}

/// Writes the byte range of every field (quotes included, blanks around it not) to `fields`.
pub(crate) fn split(
    line: &str,
    separator: char,
    fields: &mut Vec<Range<usize>>,
) -> Result<(), QuoteError> {
    fields.clear();
    let mut start = 0;
    loop {
        let rest = line.get(start..).unwrap_or_default();
        let blanks = rest.len() - trim_start(rest, separator).len();
        let from = start + blanks;
        let field = line.get(from..).unwrap_or_default();
        let end = if field.starts_with('"') {
            let close = closing_quote(field).ok_or(QuoteError::NeverClosed(from..line.len()))?;
            let after = line.get(from + close..).unwrap_or_default();
            let end = from + close + after.find(separator).unwrap_or(after.len());
            let text = line.get(from + close..end).unwrap_or_default();
            if !text.trim().is_empty() {
                return Err(QuoteError::TextAfter(from + close..end));
            }
            fields.push(from..from + close);
            end
        } else {
            let length = field.find(separator).unwrap_or(field.len());
            let text = field.get(..length).unwrap_or_default();
            fields.push(from..from + text.trim_end().len());
            from + length
        };
        if end >= line.len() {
            return Ok(());
        }
        start = end + separator.len_utf8();
    }
}

/// The text of a field as [`split`] found it: without its quotes, and without blanks around it.
pub(crate) fn content(line: &str, field: Range<usize>) -> Cow<'_, str> {
    let text = line.get(field).unwrap_or_default();
    let inner = text
        .strip_prefix('"')
        .and_then(|inner| inner.strip_suffix('"'));
    match inner {
        None => Cow::Borrowed(text),
        Some(inner) if inner.contains('"') => {
            Cow::Owned(inner.replace("\"\"", "\"").trim().to_owned())
        }
        Some(inner) => Cow::Borrowed(inner.trim()),
    }
}

/// Blanks before a field; in a file separated by tabs a tab is none.
fn trim_start(text: &str, separator: char) -> &str {
    text.trim_start_matches(|c: char| c.is_whitespace() && c != separator)
}

/// Length of the quoted field at the start of `text`, both quotes included.
fn closing_quote(text: &str) -> Option<usize> {
    let mut characters = text.char_indices().skip(1).peekable();
    while let Some((at, c)) = characters.next() {
        if c == '"' && characters.next_if(|(_, next)| *next == '"').is_none() {
            return Some(at + 1);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fields(line: &str, separator: char) -> Result<Vec<String>, QuoteError> {
        let mut ranges = Vec::new();
        split(line, separator, &mut ranges)?;
        Ok(ranges
            .into_iter()
            .map(|range| content(line, range).into_owned())
            .collect())
    }

    #[test]
    fn fields_are_trimmed_and_unquoted() {
        assert_eq!(
            fields(" a , \"b, c\" ,\"d \"\"e\"\"\",", ',').unwrap(),
            ["a", "b, c", "d \"e\"", ""]
        );
        assert_eq!(fields("1\t\t3 ", '\t').unwrap(), ["1", "", "3"]);
        assert_eq!(fields("\"\";\"\"\"\"", ';').unwrap(), ["", "\""]);
        assert_eq!(fields("", ',').unwrap(), [""]);
    }

    #[test]
    fn what_could_be_read_in_two_ways_is_an_error() {
        assert_eq!(fields("1,\"2", ','), Err(QuoteError::NeverClosed(2..4)));
        assert_eq!(fields("1,\"2\"\"", ','), Err(QuoteError::NeverClosed(2..6)));
        assert_eq!(fields("\"0.5\"6,1", ','), Err(QuoteError::TextAfter(5..6)));
    }

    #[test]
    fn well_formed_lines_are_read_as_by_the_csv_crate() {
        let pieces = [
            "",
            "a",
            " b ",
            "\"c\"",
            "\"d,;\"",
            "\"e\"\"f\"",
            "1.5",
            "\"\"",
            "ä",
        ];
        for separator in [',', ';', '\t'] {
            for first in pieces {
                for second in pieces {
                    for third in pieces {
                        let line = [first, second, third].join(&separator.to_string());
                        let mut reader = csv::ReaderBuilder::new()
                            .has_headers(false)
                            .delimiter(separator as u8)
                            .trim(csv::Trim::All)
                            .from_reader(line.as_bytes());
                        let Some(record) = reader.records().next() else {
                            assert!(line.trim().is_empty());
                            continue;
                        };
                        let record = record.unwrap();
                        let expected: Vec<&str> = record.iter().collect();
                        assert_eq!(fields(&line, separator).unwrap(), expected, "{line:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_separator_is_read_off_the_header() {
        assert_eq!(separator("t,u,phi"), ',');
        assert_eq!(separator("t;u [N,m];phi"), ';');
        assert_eq!(separator("\"t;s\",u"), ',');
        assert_eq!(separator("t\tu;v"), '\t');
        assert_eq!(separator("t"), ',');
    }
}
