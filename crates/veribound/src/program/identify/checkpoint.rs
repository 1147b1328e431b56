//! Where an identification is kept while it works, so that one that was ended by force can go on.

use super::Data;
use super::arguments::Identify;
use std::fs;
use std::io;
use std::sync::Mutex;
use std::time::{Duration, Instant};
use veribound_data::{ResultFolder, sha256_of_bytes};
use veribound_estimate::identify::IdentifyOptions;
use veribound_model::Model;
use veribound_model::diagnostic::Diagnostic;

/// The file in the folder of the results.
const NAME: &str = "checkpoint.bin";

/// Between two savings lies a tenth of the time so far, at least, and so long is enough.
const PAUSE: Duration = Duration::from_secs(5);

/// Digits of a digest.
const DIGEST: usize = 64;

/// The file that keeps an identification: the digest of what the run is, that of what is kept, and that.
pub struct Checkpoint<'a> {
    folder: &'a ResultFolder,
    run: String,
    begin: Instant,
    last: Mutex<Instant>,
}

impl<'a> Checkpoint<'a> {
    /// That of a run with these flags, model and records.
    pub fn new(folder: &'a ResultFolder, arguments: &Identify, model: &Model, data: &Data) -> Self {
        // Neither changes a result.
        let options = IdentifyOptions {
            threads: 1,
            memory: usize::MAX,
            ..arguments.options()
        };
        let records = data.records.iter().map(|record| record.sha256().to_owned());
        let records: Vec<String> = records.collect();
        let (reading, weakening) = (&arguments.reading, &arguments.weakening);
        let version = env!("CARGO_PKG_VERSION");
        let text = &model.source.text;
        let run = format!("{version} {text} {records:?} {options:?} {reading:?} {weakening:?}");
        Checkpoint {
            folder,
            run: sha256_of_bytes(run.as_bytes()),
            begin: Instant::now(),
            last: Mutex::new(Instant::now()),
        }
    }

    /// What was kept last; nothing where nothing was.
    ///
    /// *Errors*: `E0505` where it is of another run, or damaged.
    pub fn read(&self) -> Result<Option<Vec<u8>>, Diagnostic> {
        let path = self.folder.path().join(NAME);
        let content = match fs::read(&path) {
            Ok(content) => content,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(self.refuse(&error.to_string())),
        };
        let (run, rest) = content.split_at_checked(DIGEST).unwrap_or_default();
        let (digest, kept) = rest.split_at_checked(DIGEST).unwrap_or_default();
        if run != self.run.as_bytes() {
            return Err(self.refuse(
                "it is of a run with another model, record, flag or version of the program",
            ));
        }
        if digest != sha256_of_bytes(kept).as_bytes() {
            return Err(self.refuse("it is damaged"));
        }
        Ok(Some(kept.to_vec()))
    }

    /// The message for a file that cannot be gone on from.
    pub fn refuse(&self, why: &str) -> Diagnostic {
        let path = self.folder.path().join(NAME);
        let message = format!("`{}` cannot be gone on from: {why}", path.display());
        Diagnostic::new("E0505", message).help("begin anew: leave out `--resume`")
    }

    /// Keeps what `bytes` makes, if the last time is long enough ago. A disk that takes nothing does not end the
    /// run: its results may have another place yet.
    pub fn save(&self, bytes: &dyn Fn() -> Vec<u8>) {
        let Ok(mut last) = self.last.lock() else {
            return;
        };
        if last.elapsed() < PAUSE.min(self.begin.elapsed() / 10) {
            return;
        }
        let kept = bytes();
        let content = [
            self.run.as_bytes(),
            sha256_of_bytes(&kept).as_bytes(),
            &kept,
        ]
        .concat();
        let written = self.folder.write(NAME, &content);
        let _ = written.and_then(veribound_data::CompleteFile::put_in_place);
        *last = Instant::now();
    }

    /// Removes the file of a run that is done.
    pub fn remove(&self) {
        let _ = fs::remove_file(self.folder.path().join(NAME));
    }
}
