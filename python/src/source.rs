//! Records from Python: files, and columns in memory.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::fmt::Write as _;
use veribound_data::TableSource;

/// A record or a profile of inputs: a file, or columns in memory.
#[pyclass(frozen, module = "veribound._veribound")]
pub struct Source(pub TableSource);

/// A column: its name, the kind of its numbers, these, and which of them are there.
type Given<'py> = (String, String, Bound<'py, PyAny>, Option<Vec<bool>>);

#[pymethods]
impl Source {
    /// A file.
    #[staticmethod]
    fn file(path: &str) -> Source {
        Source(TableSource::from(path))
    }

    /// Columns of equal length, as the text that a file would hold.
    ///
    /// Kinds: "f8" and "f4" (floats), "i8" and "u8" (whole numbers), "ns" (whole nanoseconds, written as seconds),
    /// "b1" (truth values), each as the bytes of a contiguous array in the machine's order; "text" (a list of str or
    /// None). A float stands for its shortest decimal, or with `exact` for the number that it holds.
    #[staticmethod]
    fn table(name: &str, columns: Vec<Given<'_>>, exact: bool) -> PyResult<Source> {
        let mut heads = Vec::new();
        let mut fields: Vec<Vec<String>> = Vec::new();
        for (head, kind, data, present) in columns {
            heads.push(quoted(&head));
            let mut column = read(&kind, &data, exact)?;
            if let Some(present) = present {
                let absent = column.iter_mut().zip(present).filter(|(_, there)| !there);
                absent.for_each(|(field, _)| field.clear());
            }
            fields.push(column);
        }
        let rows = fields.first().map_or(0, Vec::len);
        if fields.iter().any(|column| column.len() != rows) {
            return Err(PyValueError::new_err(
                "the columns have different lengths; give as many values for each",
            ));
        }
        let mut text = heads.join(",");
        text.push('\n');
        for row in 0..rows {
            for (at, column) in fields.iter().enumerate() {
                if at > 0 {
                    text.push(',');
                }
                text.push_str(column.get(row).map_or("", String::as_str));
            }
            text.push('\n');
        }
        Ok(Source(TableSource::text(name, text)))
    }

    /// The path, or the name of what is in memory.
    #[getter]
    fn name(&self) -> String {
        self.0.path().display().to_string()
    }
}

/// The fields of a column.
fn read(kind: &str, data: &Bound<'_, PyAny>, exact: bool) -> PyResult<Vec<String>> {
    if kind == "text" {
        let texts: Vec<Option<String>> = data.extract()?;
        let texts = texts.into_iter().map(Option::unwrap_or_default);
        return Ok(texts.map(|text| quoted(&text)).collect());
    }
    let bytes = data.cast::<PyBytes>()?.as_bytes();
    Ok(match kind {
        "f8" => numbers(bytes, f64::from_ne_bytes, |x| float(x, exact)),
        "f4" if exact => numbers(bytes, f32::from_ne_bytes, |x| float(x.into(), true)),
        // The shortest decimal that this narrow float is nearest to.
        "f4" => numbers(bytes, f32::from_ne_bytes, |x| finite(format!("{x:?}"))),
        "i8" => numbers(bytes, i64::from_ne_bytes, |x| x.to_string()),
        "u8" => numbers(bytes, u64::from_ne_bytes, |x| x.to_string()),
        "ns" => numbers(bytes, i64::from_ne_bytes, seconds),
        "b1" => numbers(bytes, |[x]: [u8; 1]| x, |x| x.to_string()),
        other => return Err(PyValueError::new_err(format!("no kind of column: {other}"))),
    })
}

fn numbers<T, const N: usize>(
    bytes: &[u8],
    number: fn([u8; N]) -> T,
    write: impl Fn(T) -> String,
) -> Vec<String> {
    let (whole, _) = bytes.as_chunks::<N>();
    whole.iter().map(|bytes| write(number(*bytes))).collect()
}

/// A float as text: its shortest decimal, or every digit of it; nothing for NaN.
pub fn float(x: f64, exact: bool) -> String {
    if exact && x.is_finite() {
        // The smallest float ends 1074 digits behind the point.
        let digits = format!("{x:.1074}");
        return digits
            .trim_end_matches('0')
            .trim_end_matches('.')
            .to_owned();
    }
    finite(format!("{x:?}"))
}

/// Nothing for NaN: a missing value.
fn finite(text: String) -> String {
    if text == "NaN" { String::new() } else { text }
}

/// Nanoseconds as exact seconds.
fn seconds(nanoseconds: i64) -> String {
    let size = nanoseconds.unsigned_abs();
    let (whole, part) = (size / 1_000_000_000, size % 1_000_000_000);
    let mut text = if nanoseconds < 0 { "-" } else { "" }.to_owned();
    // Writing to a String cannot fail.
    let _ = write!(text, "{whole}");
    if part > 0 {
        let digits = format!("{part:09}");
        let _ = write!(text, ".{}", digits.trim_end_matches('0'));
    }
    text
}

/// A field as a CSV file holds it.
fn quoted(text: &str) -> String {
    if text.contains([',', ';', '\t', '"']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
