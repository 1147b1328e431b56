//! Records that are no text: columns of numbers, told line by line as a text table would have them.
//!
//! So columns are found, units converted, values checked and messages written in one way for all formats. A float of
//! such a file means that float exactly: its line has all digits of it.

mod hdf5;
mod mat;
mod parquet;

use crate::failure;
use crate::reader::lines::MAT;
use std::fs::File;
use std::io::{self, BufRead, Read};
use std::path::Path;
use std::sync::Arc;
use veribound_interval::text;
use veribound_model::diagnostic::Diagnostic;

/// Columns of equal length.
#[derive(Debug)]
pub(crate) struct Sheet {
    columns: Vec<Column>,
    rows: usize,
}

/// A named column.
#[derive(Debug)]
pub(crate) struct Column {
    pub name: String,
    pub values: Values,
}

/// The values of a column.
#[derive(Debug)]
pub(crate) enum Values {
    /// Each means exactly this number; NaN is a missing value.
    Floats(Vec<f64>),
    Whole(Vec<i64>),
    Large(Vec<u64>),
    /// As they are spelled; empty where missing.
    Texts(Vec<String>),
}

/// How a file of numbers begins, and what it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Mat,
    Hdf5,
    Parquet,
}

impl Format {
    const ALL: [(&'static [u8], Format); 4] = [
        (MAT, Format::Mat),
        (b"MATLAB 7.3 MAT-file", Format::Hdf5),
        (b"\x89HDF\r\n\x1a\n", Format::Hdf5),
        (b"PAR1", Format::Parquet),
    ];

    fn word(self) -> &'static str {
        match self {
            Format::Mat => "MATLAB MAT file",
            Format::Hdf5 => "HDF5 file (MATLAB v7.3 MAT files are such)",
            Format::Parquet => "Parquet file",
        }
    }
}

impl Sheet {
    /// The columns of a MAT, HDF5 or Parquet file; `None` where the file is none of these.
    ///
    /// *Errors*: `E0401`, `E0422`.
    ///
    /// *Cost*: the whole file is held in memory.
    pub(crate) fn read(path: &Path, name: &str) -> Result<Option<Sheet>, Diagnostic> {
        let refuse = |error| failure::unreadable(name, &error);
        let mut file = File::open(path).map_err(refuse)?;
        let mut start = Vec::new();
        file.by_ref()
            .take(32)
            .read_to_end(&mut start)
            .map_err(refuse)?;
        let known = Format::ALL
            .iter()
            .find(|(magic, _)| start.starts_with(magic));
        let Some((_, format)) = known else {
            return Ok(None);
        };
        let mut bytes = start;
        file.read_to_end(&mut bytes).map_err(refuse)?;
        let columns = match format {
            Format::Mat => mat::columns(&bytes),
            Format::Hdf5 => hdf5::columns(bytes),
            Format::Parquet => parquet::columns(bytes),
        };
        let columns = columns.map_err(|what| damaged(name, *format, &what))?;
        Sheet::of(columns).map(Some).ok_or_else(|| {
            let message = format!("`{name}` holds no columns of numbers");
            let help = "a record is several vectors of one length side by side: one of times, and one for every variable";
            Diagnostic::new("E0422", message).help(help)
        })
    }

    /// The columns that are as long as most of them are; the longer ones where that is not decided.
    fn of(columns: Vec<Column>) -> Option<Sheet> {
        let lengths = columns.iter().map(|column| column.values.len());
        let count = |length: usize| {
            columns
                .iter()
                .filter(|column| column.values.len() == length)
                .count()
        };
        let rows = lengths
            .filter(|length| *length > 1)
            .max_by_key(|length| (count(*length), *length))?;
        let columns = columns
            .into_iter()
            .filter(|column| column.values.len() == rows);
        Some(Sheet {
            columns: columns.collect(),
            rows,
        })
    }

    /// A line of the table: the header has the number 1, the first sample 2; `None` after the last.
    pub(crate) fn line(&self, number: usize) -> Option<String> {
        let row = number.checked_sub(2);
        if row.is_some_and(|row| row >= self.rows) || number == 0 {
            return None;
        }
        let fields = self.columns.iter().map(|column| match row {
            None => quoted(&column.name),
            Some(row) => column.values.text(row),
        });
        Some(fields.collect::<Vec<_>>().join(","))
    }
}

impl Values {
    fn len(&self) -> usize {
        match self {
            Values::Floats(list) => list.len(),
            Values::Whole(list) => list.len(),
            Values::Large(list) => list.len(),
            Values::Texts(list) => list.len(),
        }
    }

    /// The exact text of a value.
    fn text(&self, row: usize) -> String {
        let found = match self {
            Values::Floats(list) => list.get(row).map(|x| float(*x)),
            Values::Whole(list) => list.get(row).map(ToString::to_string),
            Values::Large(list) => list.get(row).map(ToString::to_string),
            Values::Texts(list) => list.get(row).map(|text| quoted(text)),
        };
        found.unwrap_or_default()
    }
}

/// All digits of a float.
fn float(x: f64) -> String {
    if x.is_nan() {
        "NaN".to_owned()
    } else {
        text::exact(x)
    }
}

/// A field that no separator, comment sign or line end inside it can split.
fn quoted(text: &str) -> String {
    let text: String = { text.chars() }
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect();
    if text.contains([',', ';', '"', '#']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text
    }
}

/// The columns of a matrix that is stored column by column: `name`, or `name(1)` and so on.
fn columns_of(name: &str, width: usize, values: Values) -> Vec<Column> {
    if width <= 1 {
        let name = name.to_owned();
        return vec![Column { name, values }];
    }
    let rows = values.len() / width;
    let part = |at: usize| at * rows..(at + 1) * rows;
    let columns = (0..width).map(|at| Column {
        name: format!("{name}({})", at + 1),
        values: match &values {
            Values::Floats(list) => Values::Floats(list.get(part(at)).unwrap_or_default().to_vec()),
            Values::Whole(list) => Values::Whole(list.get(part(at)).unwrap_or_default().to_vec()),
            Values::Large(list) => Values::Large(list.get(part(at)).unwrap_or_default().to_vec()),
            Values::Texts(list) => Values::Texts(list.get(part(at)).unwrap_or_default().to_vec()),
        },
    });
    columns.collect()
}

/// A matrix has no more columns than this; a wider one is no table of samples.
const WIDEST: usize = 1000;

fn damaged(name: &str, format: Format, what: &str) -> Diagnostic {
    let message = format!("`{name}` cannot be read as a {}: {what}", format.word());
    Diagnostic::new("E0422", message)
        .help("save it again, in MATLAB with `save -v7`, or export the record as CSV")
}

/// The lines of a sheet, one after the other.
#[derive(Debug)]
pub(crate) struct SheetText {
    sheet: Arc<Sheet>,
    next: usize,
    line: Vec<u8>,
    at: usize,
}

impl SheetText {
    pub(crate) fn new(sheet: &Arc<Sheet>) -> SheetText {
        SheetText {
            sheet: Arc::clone(sheet),
            next: 1,
            line: Vec::new(),
            at: 0,
        }
    }
}

impl BufRead for SheetText {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.at >= self.line.len() {
            self.line.clear();
            self.at = 0;
            if let Some(line) = self.sheet.line(self.next) {
                self.line.extend_from_slice(line.as_bytes());
                self.line.push(b'\n');
                self.next += 1;
            }
        }
        Ok(self.line.get(self.at..).unwrap_or_default())
    }

    fn consume(&mut self, count: usize) {
        self.at += count;
    }
}

impl Read for SheetText {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.fill_buf()?.read(buffer)?;
        self.consume(count);
        Ok(count)
    }
}

/// Where the lines of a record come from.
#[derive(Debug)]
pub(crate) enum Input<F> {
    File(io::BufReader<F>),
    Sheet(SheetText),
}

impl<F: Read> Read for Input<F> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Input::File(file) => file.read(buffer),
            Input::Sheet(sheet) => sheet.read(buffer),
        }
    }
}

impl<F: Read> BufRead for Input<F> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        match self {
            Input::File(file) => file.fill_buf(),
            Input::Sheet(sheet) => sheet.fill_buf(),
        }
    }

    fn consume(&mut self, count: usize) {
        match self {
            Input::File(file) => file.consume(count),
            Input::Sheet(sheet) => sheet.consume(count),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sheet_is_a_text_table_with_every_digit() {
        let column = |name: &str, values| Column {
            name: name.to_owned(),
            values,
        };
        let sheet = Sheet::of(vec![
            column("a, \"b\"", Values::Floats(vec![0.5, f64::NAN, 0.1])),
            column("n\n", Values::Whole(vec![-3, 0, 7])),
            column("short", Values::Floats(vec![1.0])),
            column(
                "#s",
                Values::Texts(["x", "", "1,5"].map(str::to_owned).to_vec()),
            ),
            column("big", Values::Large(vec![u64::MAX, 0, 1])),
        ]);
        let mut text = String::new();
        let mut lines = SheetText::new(&Arc::new(sheet.unwrap()));
        lines.read_to_string(&mut text).unwrap();
        let tenth = "0.1000000000000000055511151231257827021181583404541015625";
        assert_eq!(
            text,
            format!(
                "\"a, \"\"b\"\"\",n ,\"#s\",big\n0.5,-3,x,18446744073709551615\nNaN,0,,0\n{tenth},7,\"1,5\",1\n"
            )
        );
    }

    #[test]
    fn matrices_are_told_apart_by_their_columns() {
        let columns = columns_of("q", 2, Values::Floats(vec![1.0, 2.0, 3.0, 4.0]));
        let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
        assert_eq!(names, ["q(1)", "q(2)"]);
        assert_eq!(columns[1].values.text(0), "3");
        assert!(Sheet::of(columns_of("x", 1, Values::Floats(vec![1.0]))).is_none());
    }
}
