//! The folder of a run. A file in it is whole or not there: it is written under a temporary name and
//! renamed when it is complete.

use crate::failure;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use veribound_model::diagnostic::Diagnostic;

/// Where the files of a run go.
#[derive(Debug, Clone)]
pub struct ResultFolder {
    path: PathBuf,
}

impl ResultFolder {
    /// Makes the folder where it does not exist, and makes sure that files can be written to it.
    ///
    /// Files of an earlier run stay until they are replaced by complete new ones.
    ///
    /// *Errors*: `E0501` not writable, `E0502` disk full.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, Diagnostic> {
        let folder = ResultFolder {
            path: path.as_ref().to_path_buf(),
        };
        let refuse = |error| failure::unwritable(&folder.path.display().to_string(), &error);
        fs::create_dir_all(&folder.path).map_err(refuse)?;
        // Permission bits do not tell about full or read-only disks; writing does.
        let mut probe = folder.file("writable")?;
        probe
            .write_all(b"veribound\n")
            .and_then(|()| probe.flush())
            .map_err(refuse)?;
        Ok(folder)
    }

    /// Path of the folder as the user gave it.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Starts the file `name`, a path inside the folder such as `fig/angle.svg`.
    ///
    /// *Errors*: `E0501`, `E0502`.
    pub fn file(&self, name: &str) -> Result<ResultFile, Diagnostic> {
        let path = self.path.join(name);
        let refuse = |error| failure::unwritable(&path.display().to_string(), &error);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(refuse)?;
        }
        if path.is_dir() {
            return Err(refuse(io::ErrorKind::IsADirectory.into()));
        }
        let temporary = temporary_name(&path);
        let file = File::create(&temporary).map_err(refuse)?;
        Ok(ResultFile {
            output: Some(BufWriter::with_capacity(1 << 16, file)),
            temporary,
            path,
        })
    }

    /// Writes the whole file `name`.
    ///
    /// *Errors*: `E0501`, `E0502`; nothing of the file is left then.
    pub fn write(&self, name: &str, content: &[u8]) -> Result<(), Diagnostic> {
        let mut file = self.file(name)?;
        let written = file.write_all(content);
        written.map_err(|error| file.refuse(&error))?;
        file.finish()
    }
}

/// A file that appears under its name when it is finished; dropped before, it leaves nothing.
#[derive(Debug)]
pub struct ResultFile {
    /// `None` when finished.
    output: Option<BufWriter<File>>,
    temporary: PathBuf,
    path: PathBuf,
}

impl ResultFile {
    /// Puts the file under its name, when all of it has reached the disk.
    ///
    /// *Errors*: `E0501`, `E0502`; nothing of the file is left then.
    pub fn finish(mut self) -> Result<(), Diagnostic> {
        let written = self.put_in_place();
        written.map_err(|error| self.refuse(&error))
    }

    /// The message for an error of writing to this file.
    pub fn refuse(&self, error: &io::Error) -> Diagnostic {
        failure::unwritable(&self.path.display().to_string(), error)
    }

    fn put_in_place(&mut self) -> io::Result<()> {
        let Some(output) = &mut self.output else {
            return Ok(());
        };
        output.flush()?;
        // A full disk may show only when the data leave the cache.
        output.get_ref().sync_all()?;
        fs::rename(&self.temporary, &self.path)?;
        self.output = None;
        Ok(())
    }
}

impl Write for ResultFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.output {
            Some(output) => output.write(bytes),
            None => Ok(bytes.len()),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.output.as_mut().map_or(Ok(()), Write::flush)
    }
}

impl Drop for ResultFile {
    fn drop(&mut self) {
        if let Some(output) = self.output.take() {
            // What is still in the buffer belongs to a file that nobody will see.
            let _ = output.into_parts();
            let _ = fs::remove_file(&self.temporary);
        }
    }
}

/// A name beside `path` that no two runs at the same time share.
fn temporary_name(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.{}.part", std::process::id()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_is_there_whole_or_not_at_all() {
        let place = tempfile::tempdir().unwrap();
        let folder = ResultFolder::create(place.path().join("a/run")).unwrap();
        assert_eq!(files(folder.path()), [""; 0]);
        let mut file = folder.file("x.csv").unwrap();
        file.write_all(b"t\n").unwrap();
        drop(file);
        assert_eq!(files(folder.path()), [""; 0]);
        folder.write("x.csv", b"old").unwrap();
        let mut file = folder.file("x.csv").unwrap();
        file.write_all(b"new").unwrap();
        assert_eq!(fs::read(folder.path().join("x.csv")).unwrap(), b"old");
        file.finish().unwrap();
        assert_eq!(fs::read(folder.path().join("x.csv")).unwrap(), b"new");
        folder.write("fig/a.svg", b"<svg/>").unwrap();
        assert_eq!(files(folder.path()), ["fig", "x.csv"]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_said_and_leaves_nothing() {
        let place = tempfile::tempdir().unwrap();
        let temporary = place.path().join(".x.csv.part");
        fs::write(&temporary, b"").unwrap();
        let full = File::options().write(true).open("/dev/full").unwrap();
        let mut file = ResultFile {
            output: Some(BufWriter::new(full)),
            temporary,
            path: place.path().join("x.csv"),
        };
        file.write_all(b"t,phi\n").unwrap();
        let error = file.finish().unwrap_err();
        assert_eq!(error.code, "E0502");
        assert!(
            error.message.ends_with("x.csv`: the disk is full"),
            "{}",
            error.message
        );
        assert_eq!(files(place.path()), [""; 0]);
    }

    #[test]
    fn what_is_in_the_way_is_said() {
        let place = tempfile::tempdir().unwrap();
        fs::write(place.path().join("file"), b"").unwrap();
        for path in ["file", "file/below"] {
            let error = ResultFolder::create(place.path().join(path)).unwrap_err();
            assert_eq!(error.code, "E0501", "{error:?}");
        }
        fs::create_dir(place.path().join("x.csv")).unwrap();
        let folder = ResultFolder::create(place.path()).unwrap();
        assert_eq!(folder.write("x.csv", b"").unwrap_err().code, "E0501");
    }
}
