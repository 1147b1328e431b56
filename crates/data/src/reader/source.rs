//! Where the bytes of a table come from.

use crate::failure;
use crate::record::sheet::Sheet;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use veribound_model::diagnostic::Diagnostic;

/// A table of text: a file, or a text in memory with the name that messages and results give it.
///
/// Paths become sources by themselves, so that [`Record::open`](crate::Record::open) takes both.
///
/// ```
/// use veribound_data::{Record, RecordOptions, TableSource};
/// use veribound_model::Model;
///
/// let model = "format = 1\nstates = [\"x\"]\ninit.x = 0\nder.x = 1\noutputs.x_m = \"x +- 0.1\"";
/// let model = Model::from_text("clock.toml", model)?;
/// let table = TableSource::text("two samples", "t,x_m\n0,0\n1,0.98\n");
/// let record = Record::open(table, &model, RecordOptions::default())?;
/// assert_eq!(record.len(), 2);
/// # Ok::<(), veribound_model::Diagnostics>(())
/// ```
#[derive(Debug, Clone)]
pub struct TableSource {
    path: PathBuf,
    text: Option<Arc<str>>,
}

impl TableSource {
    /// A text in memory, read as a file with these bytes would be.
    pub fn text(name: impl Into<PathBuf>, text: impl Into<Arc<str>>) -> TableSource {
        TableSource {
            path: name.into(),
            text: Some(text.into()),
        }
    }

    /// The path as the user gave it, or the name of the text.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The columns of a file that is no text; `None` of one that is, and of a text in memory.
    ///
    /// *Errors*: `E0401`, `E0422`.
    pub(crate) fn sheet(&self, name: &str) -> Result<Option<Sheet>, Diagnostic> {
        match self.text {
            Some(_) => Ok(None),
            None => Sheet::read(&self.path, name),
        }
    }

    /// Number of bytes, as far as that is known.
    pub fn bytes(&self) -> u64 {
        match &self.text {
            Some(text) => text.len() as u64,
            None => std::fs::metadata(&self.path).map_or(0, |file| file.len()),
        }
    }

    /// Starts reading. What is read only once need not be a regular file.
    ///
    /// *Errors*: `E0401` when it cannot be read.
    pub(crate) fn open(&self, is_read_once: bool) -> Result<Bytes, Diagnostic> {
        if let Some(text) = &self.text {
            return Ok(Bytes::Text(io::Cursor::new(Arc::clone(text).into())));
        }
        let name = self.path.display().to_string();
        let refuse = |error| failure::unreadable(&name, &error);
        let file = File::open(&self.path).map_err(refuse)?;
        let kind = file.metadata().map_err(refuse)?.file_type();
        if kind.is_dir() {
            return Err(refuse(io::ErrorKind::IsADirectory.into()));
        }
        if !kind.is_file() && !is_read_once {
            let message = format!("cannot read `{name}`: it is no regular file");
            return Err(Diagnostic::new("E0401", message).help("write the record to a file first"));
        }
        Ok(Bytes::File(file))
    }
}

impl<P: AsRef<Path>> From<P> for TableSource {
    fn from(path: P) -> TableSource {
        TableSource {
            path: path.as_ref().to_path_buf(),
            text: None,
        }
    }
}

/// The bytes of a source.
#[derive(Debug)]
pub(crate) enum Bytes {
    File(File),
    Text(io::Cursor<Arc<[u8]>>),
}

impl Read for Bytes {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Bytes::File(file) => file.read(buffer),
            Bytes::Text(text) => text.read(buffer),
        }
    }
}
