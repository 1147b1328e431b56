//! Lines of a text file, one at a time, each with its number; what is no text is refused by name.

use crate::failure;
use std::io::{BufRead, Read};
use std::sync::Arc;
use veribound_model::diagnostic::{Diagnostic, SourceText};

/// No line of a record is longer than this many bytes, so that memory stays bounded on any file.
const LONGEST_LINE: u64 = 1 << 20;

/// How much of a long line a message quotes, in bytes.
const LONGEST_QUOTE: usize = 400;

/// First bytes of a MAT file up to version 7.
pub(crate) const MAT: &[u8] = b"MATLAB 5.0 MAT-file";

/// First bytes of files that are often mistaken for text tables, and what they are.
const FORMATS: [(&[u8], &str); 9] = [
    (MAT, "a MATLAB MAT file"),
    (b"\x89HDF\r\n", "an HDF5 file (or a MATLAB v7.3 MAT file)"),
    (b"PAR1", "a Parquet file"),
    (b"ARROW1", "an Arrow file"),
    (b"PK\x03\x04", "a zip archive (an Excel workbook is one)"),
    (b"\xd0\xcf\x11\xe0", "an old Excel workbook"),
    (b"\x1f\x8b", "a gzip archive"),
    (b"\x89MCAP", "an MCAP log"),
    (b"ULog", "a ULog file"),
];

/// Reads lines of bounded length from `R`.
#[derive(Debug)]
pub(crate) struct Lines<R> {
    input: R,
    name: Arc<str>,
    number: usize,
    buffer: Vec<u8>,
}

impl<R: BufRead> Lines<R> {
    /// Starts reading; `name` is the path as the user gave it.
    pub(crate) fn new(mut input: R, name: &str) -> Result<Self, Diagnostic> {
        let start = input
            .fill_buf()
            .map_err(|error| failure::unreadable(name, &error))?;
        if start.starts_with(b"\xff\xfe") || start.starts_with(b"\xfe\xff") {
            return Err(Diagnostic::new(
                "E0405",
                format!("`{name}` is written in UTF-16, not in UTF-8"),
            )
            .help("save it again with the encoding UTF-8"));
        }
        if let Some((_, what)) = FORMATS.iter().find(|(magic, _)| start.starts_with(magic)) {
            return Err(not_text(name, what));
        }
        if start.starts_with(b"\xef\xbb\xbf") {
            input.consume(3);
        }
        Ok(Lines {
            input,
            name: Arc::from(name),
            number: 0,
            buffer: Vec::new(),
        })
    }

    /// The next line without its line end, and its number (the first is 1); `None` at the end.
    pub(crate) fn next_line(&mut self) -> Result<Option<(&str, usize)>, Diagnostic> {
        self.buffer.clear();
        let count = (&mut self.input)
            .take(LONGEST_LINE)
            .read_until(b'\n', &mut self.buffer)
            .map_err(|error| failure::unreadable(&self.name, &error))?;
        if count == 0 {
            return Ok(None);
        }
        self.number += 1;
        if self.buffer.last() == Some(&b'\n') {
            self.buffer.pop();
        } else if count as u64 == LONGEST_LINE {
            return Err(self.too_long());
        }
        if self.buffer.last() == Some(&b'\r') {
            self.buffer.pop();
        }
        if self.buffer.iter().copied().any(is_control) {
            return Err(not_text(&self.name, "a binary file"));
        }
        if self.buffer.contains(&b'\r') {
            return Err(self.old_line_ends());
        }
        match std::str::from_utf8(&self.buffer) {
            Ok(line) => Ok(Some((line, self.number))),
            Err(error) => Err(self.not_utf8(error.valid_up_to())),
        }
    }

    /// What the lines are read from.
    pub(crate) fn into_input(self) -> R {
        self.input
    }

    fn too_long(&self) -> Diagnostic {
        Diagnostic::new(
            "E0419",
            format!(
                "line {} of `{}` is longer than {LONGEST_LINE} bytes",
                self.number, self.name
            ),
        )
        .help("check that the file is a table with one sample per line")
    }

    fn old_line_ends(&self) -> Diagnostic {
        let message = format!(
            "the lines of `{}` end with a carriage return alone",
            self.name
        );
        Diagnostic::new("E0404", message)
            .help("save the file again with line ends of Unix (LF) or Windows (CR LF)")
    }

    fn not_utf8(&self, offset: usize) -> Diagnostic {
        let byte = self.buffer.get(offset).copied().unwrap_or_default();
        let line = String::from_utf8_lossy(&self.buffer);
        let place = quote(&self.name, &line, self.number, offset..offset + 1);
        let message = format!("byte 0x{byte:02X} is not UTF-8 text");
        let label = format!("`{}` in Latin-1", char::from(byte));
        Diagnostic::new("E0405", message)
            .at(&place.0, place.1, label)
            .help("save the file again with the encoding UTF-8")
    }
}

/// A line of `name` as the place of a message: long lines are cut around `range`.
pub(crate) fn quote(
    name: &str,
    line: &str,
    number: usize,
    range: std::ops::Range<usize>,
) -> (Arc<SourceText>, std::ops::Range<usize>) {
    let mut start = range.start.saturating_sub(LONGEST_QUOTE / 2);
    if line.len() <= LONGEST_QUOTE {
        start = 0;
    }
    start = boundary_before(line, start);
    let end = boundary_before(line, start.saturating_add(LONGEST_QUOTE));
    let text = line.get(start..end).unwrap_or_default();
    let from = boundary_before(text, range.start.saturating_sub(start));
    let to = boundary_before(text, range.end.saturating_sub(start));
    let source = Arc::new(SourceText::excerpt(name, text, number));
    (source, from..to.max(from))
}

/// The last place at or before `at` where a character of `text` starts, or its end.
fn boundary_before(text: &str, at: usize) -> usize {
    let mut at = at.min(text.len());
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

fn not_text(name: &str, what: &str) -> Diagnostic {
    Diagnostic::new(
        "E0404",
        format!("`{name}` is not a text table: it looks like {what}"),
    )
    .help("export the record as CSV: a header line, then one line per sample")
}

/// Control characters that no text table holds.
fn is_control(byte: u8) -> bool {
    byte < 0x20 && !b"\t\r\x0c".contains(&byte) || byte == 0x7f
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(bytes: &[u8]) -> Vec<(String, usize)> {
        let mut lines = Lines::new(bytes, "x.csv").unwrap();
        let mut all = Vec::new();
        while let Some((line, number)) = lines.next_line().unwrap() {
            all.push((line.to_owned(), number));
        }
        all
    }

    #[test]
    fn line_ends_and_the_byte_order_mark_are_no_part_of_a_line() {
        let expected = vec![("a".to_owned(), 1), (String::new(), 2), ("b".to_owned(), 3)];
        assert_eq!(lines(b"\xef\xbb\xbfa\r\n\nb"), expected);
        assert_eq!(lines(b"a\n\r\nb\n"), expected);
    }

    #[test]
    fn a_line_without_end_is_refused_before_it_fills_the_memory() {
        let mut lines =
            Lines::new(std::io::BufReader::new(std::io::repeat(b'1')), "x.csv").unwrap();
        assert_eq!(lines.next_line().unwrap_err().code, "E0419");
    }

    #[test]
    fn a_quote_of_a_long_line_keeps_the_marked_text() {
        let line = format!("{}ä!{}", "ö".repeat(1000), "x".repeat(1000));
        let (source, range) = quote("x.csv", &line, 7, 2000..2002);
        assert_eq!(source.text.get(range), Some("ä"));
        assert!(source.text.len() <= LONGEST_QUOTE);
        assert_eq!(source.first_line, 7);
    }
}
