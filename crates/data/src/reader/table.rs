//! A table of text, row by row.

use super::fields::{content, separator, split};
use super::lines::Lines;
use super::source::{Bytes, TableSource};
use super::{Line, bad_quotes, is_comment};
use crate::digest::Digesting;
use std::borrow::Cow;
use std::io::BufReader;
use std::ops::Range;
use veribound_model::diagnostic::Diagnostic;

/// Reads a table of text: a header line, then rows with as many fields; by the rules of records
/// (comments, separators, quotes), but without a meaning of the columns.
///
/// *Cost*: memory does not grow with the number of rows.
///
/// ```
/// use veribound_data::{TableReader, TableRow, TableSource};
///
/// let mut table = TableReader::open(TableSource::text("t.csv", "# made by hand\na; b\n1; \"x; y\"\n"))?;
/// let b = table.column("b").unwrap();
/// let row: TableRow<'_> = table.next_row()?.unwrap();
/// assert_eq!((row.field(b).as_ref(), row.line()), ("x; y", 3));
/// assert!(table.next_row()?.is_none());
/// # Ok::<(), veribound_model::diagnostic::Diagnostic>(())
/// ```
#[derive(Debug)]
pub struct TableReader {
    lines: Lines<BufReader<Digesting<Bytes>>>,
    name: String,
    separator: char,
    columns: Vec<String>,
    /// The line at hand, its number, and where its fields are.
    text: String,
    number: usize,
    ranges: Vec<Range<usize>>,
}

/// One row of a table.
///
/// Example: [`TableReader`].
#[derive(Debug, Clone, Copy)]
pub struct TableRow<'a> {
    line: Line<'a>,
    ranges: &'a [Range<usize>],
}

impl TableReader {
    /// Opens a table and reads its header line.
    ///
    /// *Errors*: `E0401` when it cannot be read, `E0402` when it has no header line, `E0404` to
    /// `E0406` when it is no table of text.
    pub fn open(source: impl Into<TableSource>) -> Result<TableReader, Diagnostic> {
        let source = source.into();
        let name = source.path().display().to_string();
        let bytes = Digesting::new(source.open(true)?);
        let mut table = TableReader {
            lines: Lines::new(BufReader::with_capacity(1 << 16, bytes), &name)?,
            name,
            separator: ',',
            columns: Vec::new(),
            text: String::new(),
            number: 0,
            ranges: Vec::new(),
        };
        if !table.next_line()? {
            let message = format!("`{}` has no header line", table.name);
            return Err(Diagnostic::new("E0402", message)
                .help("write the names of the columns into the first line"));
        }
        table.separator = separator(&table.text);
        table.split()?;
        let ranges = table.ranges.iter();
        table.columns = ranges
            .map(|range| content(&table.text, range.clone()).into_owned())
            .collect();
        Ok(table)
    }

    /// The names of the columns.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The first column of this name.
    pub fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column == name)
    }

    /// The next row; `None` at the end.
    ///
    /// *Errors*: `E0401` when it cannot be read, `E0407` when it has more or fewer fields than the
    /// header, `E0404` to `E0406` when it is no text.
    pub fn next_row(&mut self) -> Result<Option<TableRow<'_>>, Diagnostic> {
        loop {
            if !self.next_line()? {
                return Ok(None);
            }
            self.split()?;
            if self.ranges.iter().any(|range| !range.is_empty()) {
                break;
            }
        }
        let row = self.row();
        let (found, expected) = (self.ranges.len(), self.columns.len());
        if found != expected {
            let message = format!("the row has {found} fields, the header has {expected}");
            let problem = Diagnostic::new("E0407", message);
            let whole = 0..row.line.text.len();
            return Err(row
                .line
                .mark(problem, whole, "this row")
                .help("write one field for every column"));
        }
        Ok(Some(row))
    }

    /// SHA-256 of the bytes that were read so far, of the whole file after the last row.
    pub fn sha256(self) -> String {
        self.lines.into_input().into_inner().finish()
    }

    fn row(&self) -> TableRow<'_> {
        TableRow {
            line: Line {
                file: &self.name,
                text: &self.text,
                number: self.number,
            },
            ranges: &self.ranges,
        }
    }

    /// Goes to the next line that is no comment; false at the end.
    fn next_line(&mut self) -> Result<bool, Diagnostic> {
        while let Some((text, number)) = self.lines.next_line()? {
            if !is_comment(text) {
                self.text.clear();
                self.text.push_str(text);
                self.number = number;
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn split(&mut self) -> Result<(), Diagnostic> {
        let done = split(&self.text, self.separator, &mut self.ranges);
        done.map_err(|error| bad_quotes(self.row().line, error))
    }
}

impl<'a> TableRow<'a> {
    /// The text of a field without its quotes; empty where there is none.
    pub fn field(&self, at: usize) -> Cow<'a, str> {
        content(self.line.text, self.range(at))
    }

    /// Its line in the file; the first line is 1.
    pub fn line(&self) -> usize {
        self.line.number
    }

    /// Adds the place of a field to a message.
    pub(crate) fn mark(&self, problem: Diagnostic, at: usize, label: &str) -> Diagnostic {
        self.line.mark(problem, self.range(at), label)
    }

    fn range(&self, at: usize) -> Range<usize> {
        self.ranges.get(at).cloned().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn rows(text: &str) -> Result<Vec<String>, Diagnostic> {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("x.csv");
        fs::write(&path, text).unwrap();
        let mut table = TableReader::open(&path)?;
        let columns = table.columns().len();
        let mut rows = vec![table.columns().join("|")];
        while let Some(row) = table.next_row()? {
            let fields: Vec<_> = (0..columns).map(|at| row.field(at)).collect();
            rows.push(format!("{}: {}", row.line(), fields.join("|")));
        }
        assert_eq!(table.sha256(), crate::sha256_of_file(&path).unwrap());
        Ok(rows)
    }

    #[test]
    fn tables_are_read_by_the_rules_of_records() {
        let expected = ["t|u, v|x", "3: 0|1|a", "5: 1||b c"];
        for text in [
            "# made\nt,\"u, v\",x\n0,1,a\n\n1,,\"b c\"\n",
            "\u{feff}t;u, v;x\r\n# made\r\n 0; 1;a\r\n;;\r\n1;;b c",
            "\nt\tu, v\tx\n0\t1\ta\n # pause\n1\t\tb c\n",
        ] {
            assert_eq!(rows(text).unwrap(), expected, "{text}");
        }
    }

    #[test]
    fn what_is_no_table_is_refused() {
        let code = |text| rows(text).unwrap_err().code;
        assert_eq!(code("# only this\n"), "E0402");
        assert_eq!(code("t,u\n0\n"), "E0407");
        assert_eq!(code("t,u\n0,\"1\n"), "E0406");
        assert_eq!(code("t,u\n0,\u{1}\n"), "E0404");
        let nowhere = TableReader::open("nowhere.csv").unwrap_err();
        assert_eq!(nowhere.code, "E0401");
    }
}
