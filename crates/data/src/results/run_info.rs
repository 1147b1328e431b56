//! `run.toml`: all that is needed to repeat a run.

use super::folder::{CompleteFile, ResultFolder};
use crate::digest::sha256_of_text;
use crate::record::Record;
use serde::Serialize;
use std::path::Path;
use veribound_model::diagnostic::Diagnostic;

/// The content of `run.toml`: the command, every option with its value, and a digest of every file
/// that was read.
///
/// Paths are those that the user gave, relative to the folder in which the command was run; that
/// folder is not named. Two runs with the same words, files and program on the same kind of machine
/// write the same bytes: no time, no name of a user or machine is in it.
///
/// ```
/// use std::path::Path;
/// use veribound_data::{FileInfo, Platform, Program, Record, RecordInfo, RecordOptions, RunInfo, TableSource};
/// use veribound_model::Model;
///
/// let text = "format = 1\nstates = [\"x\"]\ninit.x = 1\nparams.k = [0, 2]\nder.x = \"-k*x\"\noutputs.y = \"x +- 0.01\"";
/// let model = Model::from_text("decay.toml", text)?;
/// let record = Record::open(TableSource::text("r.csv", "t,y\n0,1\n1,0.37\n"), &model, RecordOptions::default())?;
/// let info = RunInfo {
///     program: Program { version: "0.1.0".to_owned(), command: vec!["veribound".to_owned()] },
///     platform: Platform::current(),
///     model: FileInfo::of_text(Path::new("decay.toml"), text),
///     record: Some(RecordInfo::of(&record)),
///     records: Vec::new(),
///     profile: None,
///     start: Vec::new(),
///     overlay: None,
///     options: Default::default(),
/// };
/// assert!(info.to_toml()?.contains("samples = 2"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize)]
pub struct RunInfo {
    /// What ran.
    pub program: Program,
    /// Where it ran.
    pub platform: Platform,
    /// The model file.
    pub model: FileInfo,
    /// The record.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub record: Option<RecordInfo>,
    /// The records of a run that takes several together.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub records: Vec<RecordInfo>,
    /// The profile of the inputs, of a run without a record.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub profile: Option<RecordInfo>,
    /// The files of the run that this one started from.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub start: Vec<FileInfo>,
    /// The table of the run that the figures show behind this one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub overlay: Option<FileInfo>,
    /// Every option with the value that was used, given or default.
    pub options: toml::Table,
}

/// What ran.
///
/// Example: [`RunInfo`].
#[derive(Debug, Clone, Serialize)]
pub struct Program {
    /// Version of the program.
    pub version: String,
    /// The command line, word by word; the program by its name.
    pub command: Vec<String>,
}

/// Where it ran. Results do not depend on it, times do.
///
/// Example: [`RunInfo`].
#[derive(Debug, Clone, Serialize)]
pub struct Platform {
    /// Operating system.
    pub system: String,
    /// Processor architecture.
    pub processor: String,
    /// Rounding mode of the floating point unit during the run.
    pub rounding: String,
}

/// A file and its digest.
///
/// Example: [`RunInfo`].
#[derive(Debug, Clone, Serialize)]
pub struct FileInfo {
    /// Path as the user gave it.
    pub path: String,
    /// SHA-256 of its bytes, in hexadecimal digits.
    pub sha256: String,
}

/// A record and what was read from it.
///
/// Example: [`RunInfo`].
#[derive(Debug, Clone, Serialize)]
pub struct RecordInfo {
    /// Path as the user gave it.
    pub path: String,
    /// SHA-256 of its bytes, in hexadecimal digits.
    pub sha256: String,
    /// Number of samples in the window.
    pub samples: usize,
    /// First time of the window in seconds, as the exact decimal.
    pub first: String,
    /// Last time of the window in seconds, as the exact decimal.
    pub last: String,
    /// Variables and the columns they were read from.
    pub columns: Vec<[String; 2]>,
}

/// The first line of `run.toml`.
const HEAD: &str = "# Paths are relative to the folder in which the command was run.\n";

impl RunInfo {
    /// Writes `run.toml`.
    ///
    /// *Errors*: `E0501`, `E0502`; `E0503` when an option has no form in TOML.
    pub fn write(&self, folder: &ResultFolder) -> Result<CompleteFile, Diagnostic> {
        folder.write("run.toml", self.to_toml()?.as_bytes())
    }

    /// The text of `run.toml`.
    ///
    /// *Errors*: `E0503` when an option has no form in TOML.
    pub fn to_toml(&self) -> Result<String, Diagnostic> {
        let text = toml::to_string(self).map_err(|error| {
            Diagnostic::new(
                "E0503",
                format!("the run cannot be written as TOML: {error}"),
            )
        })?;
        Ok(format!("{HEAD}{text}"))
    }
}

impl Platform {
    /// This machine.
    pub fn current() -> Self {
        Platform {
            system: std::env::consts::OS.to_owned(),
            processor: std::env::consts::ARCH.to_owned(),
            rounding: "to nearest, directed bounds by error-free transformation".to_owned(),
        }
    }
}

impl FileInfo {
    /// A file that was read whole as this text.
    pub fn of_text(path: &Path, text: &str) -> Self {
        FileInfo {
            path: path.display().to_string(),
            sha256: sha256_of_text(text),
        }
    }
}

impl RecordInfo {
    /// What was read from a record.
    pub fn of(record: &Record) -> Self {
        let columns = record.columns().iter();
        RecordInfo {
            path: record.path().display().to_string(),
            sha256: record.sha256().to_owned(),
            samples: record.len(),
            first: record.first().to_string(),
            last: record.last().to_string(),
            columns: columns
                .map(|(variable, column)| [variable.clone(), column.clone()])
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_can_be_read_as_toml() {
        let place = tempfile::tempdir().unwrap();
        let folder = ResultFolder::create(place.path()).unwrap();
        let mut options = toml::Table::new();
        options.insert("boxes".to_owned(), toml::Value::Integer(50));
        let run = RunInfo {
            program: Program {
                version: "0.1.0".to_owned(),
                command: ["veribound", "observe", "a \"b\".toml"]
                    .map(str::to_owned)
                    .to_vec(),
            },
            platform: Platform::current(),
            model: FileInfo::of_text(Path::new("model.toml"), "format = 1\n"),
            record: None,
            records: Vec::new(),
            profile: None,
            start: Vec::new(),
            overlay: None,
            options,
        };
        run.write(&folder).unwrap().put_in_place().unwrap();
        let text = std::fs::read_to_string(place.path().join("run.toml")).unwrap();
        let table: toml::Table = text.parse().unwrap();
        assert_eq!(table["options"]["boxes"].as_integer(), Some(50));
        assert_eq!(
            table["program"]["command"][2].as_str(),
            Some("a \"b\".toml")
        );
        assert_eq!(table["model"]["sha256"].as_str().map(str::len), Some(64));
        assert!(table.get("record").is_none());
    }
}
