//! `run.toml`: all that is needed to repeat a run.

use super::folder::ResultFolder;
use crate::digest::sha256_of_file;
use crate::record::Record;
use serde::Serialize;
use std::path::Path;
use veribound_model::diagnostic::Diagnostic;

/// The content of `run.toml`; it holds nothing that differs between two equal runs.
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
    /// The `summary.json` of the run that this one started from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start: Option<FileInfo>,
    /// Every option with the value that was used, given or default.
    pub options: toml::Table,
}

/// What ran.
#[derive(Debug, Clone, Serialize)]
pub struct Program {
    /// Version of the program.
    pub version: String,
    /// The command line, word by word.
    pub command: Vec<String>,
}

/// Where it ran. Results do not depend on it, times do.
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
#[derive(Debug, Clone, Serialize)]
pub struct FileInfo {
    /// Path as the user gave it.
    pub path: String,
    /// SHA-256 of its bytes, in hexadecimal digits.
    pub sha256: String,
}

/// A record and what was read from it.
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

impl RunInfo {
    /// Writes `run.toml`.
    ///
    /// *Errors*: `E0501`, `E0502`; `E0503` when an option has no form in TOML.
    pub fn write(&self, folder: &ResultFolder) -> Result<(), Diagnostic> {
        let text = toml::to_string(self).map_err(|error| {
            Diagnostic::new(
                "E0503",
                format!("the run cannot be written as TOML: {error}"),
            )
        })?;
        folder.write("run.toml", text.as_bytes())
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
    /// Takes the digest of a file.
    ///
    /// *Errors*: `E0401` when it cannot be read.
    pub fn of(path: impl AsRef<Path>) -> Result<Self, Diagnostic> {
        let path = path.as_ref();
        Ok(FileInfo {
            path: path.display().to_string(),
            sha256: sha256_of_file(path)?,
        })
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
        folder.write("model.toml", b"format = 1\n").unwrap();
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
            model: FileInfo::of(place.path().join("model.toml")).unwrap(),
            record: None,
            start: None,
            options,
        };
        run.write(&folder).unwrap();
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
