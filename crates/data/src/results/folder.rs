//! The folder of a run. Every file is written whole under a temporary name; the results get their own
//! names together, at the end.

use crate::failure;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use veribound_model::diagnostic::Diagnostic;

/// The file that says that the results are complete: it goes first and comes last.
const MARK: &str = "summary.json";

/// The tables and texts of a run.
const TABLES: [&str; 12] = [
    MARK,
    "report.html",
    "run.toml",
    "states.csv",
    "params.csv",
    "boxes.csv",
    "tube.csv",
    "parts.csv",
    "points.csv",
    "paving.csv",
    "turned.csv",
    "frames.csv",
];

/// The figures of a run, in the folder `fig`.
const FIGURES: [&str; 7] = [
    "outputs", "params", "states", "modes", "work", "plane", "bounds",
];

/// How the names of the other figures begin: one for every two parameters.
const PAIRS: &str = "paving_";

/// Where the files of a run go.
///
/// *Guarantee*: a folder with a `summary.json` holds the results of one run, all of them and
/// nothing of another. A run that fails before [`ResultFolder::publish`] changes no result that is
/// there.
///
/// ```
/// use veribound_data::ResultFolder;
/// # let place = std::env::temp_dir().join(format!("veribound-doc-folder-{}", std::process::id()));
/// let folder = ResultFolder::create(&place)?;
/// let note = folder.write("note.txt", b"proved")?;
/// assert!(!place.join("note.txt").exists()); // nothing is seen before all of it is complete
/// let summary = folder.write("summary.json", b"{}")?;
/// folder.publish(vec![note, summary])?;
/// assert_eq!(std::fs::read(place.join("note.txt"))?, b"proved");
/// # std::fs::remove_dir_all(place)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct ResultFolder {
    path: PathBuf,
    parquet: bool,
}

impl ResultFolder {
    /// Makes the folder where it does not exist, and makes sure that files can be written to it.
    ///
    /// Results of an earlier run stay; what a run that was killed left half written is removed.
    ///
    /// *Errors*: `E0501` not writable, `E0502` disk full.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, Diagnostic> {
        let folder = ResultFolder {
            path: path.as_ref().to_path_buf(),
            parquet: false,
        };
        let refuse = |error| failure::unwritable(&folder.path.display().to_string(), &error);
        fs::create_dir_all(&folder.path).map_err(refuse)?;
        for place in [folder.path.clone(), folder.path.join("fig")] {
            remove_abandoned(&place);
        }
        // Permission bits do not tell about full or read-only disks; writing does.
        let mut probe = folder.file("writable")?;
        probe
            .write_all(b"veribound\n")
            .and_then(|()| probe.flush())
            .map_err(refuse)?;
        Ok(folder)
    }

    /// Whether every table is written as a Parquet file, too.
    #[must_use]
    pub fn with_parquet(mut self, parquet: bool) -> Self {
        self.parquet = parquet;
        self
    }

    /// Whether tables are written as Parquet files, too.
    pub fn has_parquet(&self) -> bool {
        self.parquet
    }

    /// Path of the folder as the user gave it.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Everything that a run with its results in the folder `path` may write or replace.
    pub fn names(path: &Path) -> Vec<PathBuf> {
        let twins = TABLES.iter().filter_map(|name| name.strip_suffix(".csv"));
        let twins = twins.map(|stem| path.join(format!("{stem}.parquet")));
        let tables = TABLES.iter().map(|name| path.join(name)).chain(twins);
        let figures = FIGURES.iter().flat_map(|name| {
            ["svg", "png"].map(|ending| path.join("fig").join(format!("{name}.{ending}")))
        });
        tables.chain(figures).chain(pairs(path)).collect()
    }

    /// Starts the file `name`, a path inside the folder such as `fig/outputs.svg`.
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
            output: BufWriter::with_capacity(1 << 16, file),
            place: Place {
                temporary: Some(temporary),
                path,
            },
        })
    }

    /// Writes the whole file `name`.
    ///
    /// *Errors*: `E0501`, `E0502`; nothing of the file is left then.
    pub fn write(&self, name: &str, content: &[u8]) -> Result<CompleteFile, Diagnostic> {
        let mut file = self.file(name)?;
        let written = file.write_all(content);
        written.map_err(|error| file.refuse(&error))?;
        file.finish()
    }

    /// Puts the results of a run under their names, in place of those of an earlier run.
    ///
    /// `summary.json` is the mark of a complete run: that of the earlier run is removed before
    /// anything else changes, the new one comes last. Figures of the earlier run without a new one
    /// in their place are removed.
    ///
    /// *Errors*: `E0501`; the folder holds no `summary.json` then.
    pub fn publish(&self, results: Vec<CompleteFile>) -> Result<(), Diagnostic> {
        let mark = self.path.join(MARK);
        // Without these two the folder is the user's own, and so are its figures.
        let has_results = mark.exists() || self.path.join("run.toml").exists();
        remove(&mark)?;
        for name in ResultFolder::names(&self.path) {
            if has_results && !results.iter().any(|file| file.is(&name)) {
                remove(&name)?;
            }
        }
        // Empty after the last figure; not empty, and left alone, where the user keeps more in it.
        let _ = fs::remove_dir(self.path.join("fig"));
        let (marks, others): (Vec<_>, Vec<_>) =
            results.into_iter().partition(|file| file.is(&mark));
        others
            .into_iter()
            .chain(marks)
            .try_for_each(CompleteFile::put_in_place)
    }
}

/// The figures of pairs of parameters that are in the folder of a run.
fn pairs(path: &Path) -> impl Iterator<Item = PathBuf> {
    let found = fs::read_dir(path.join("fig")).into_iter().flatten();
    found.flatten().map(|entry| entry.path()).filter(|path| {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let is_figure = path
            .extension()
            .is_some_and(|end| end == "svg" || end == "png");
        is_figure && name.starts_with(PAIRS)
    })
}

/// A file that is being written; dropped before [`ResultFile::finish`], it leaves nothing.
///
/// ```
/// use std::io::Write;
/// use veribound_data::{CompleteFile, ResultFile, ResultFolder};
/// # let place = std::env::temp_dir().join(format!("veribound-doc-file-{}", std::process::id()));
/// let folder = ResultFolder::create(&place)?;
/// let mut file: ResultFile = folder.file("record.csv")?;
/// file.write_all(b"t,y\n0,1\n")?;
/// let complete: CompleteFile = file.finish()?;
/// assert!(!place.join("record.csv").exists());
/// complete.put_in_place()?;
/// assert_eq!(std::fs::read(place.join("record.csv"))?, b"t,y\n0,1\n");
/// # std::fs::remove_dir_all(place)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct ResultFile {
    output: BufWriter<File>,
    place: Place,
}

/// A file that is on the disk whole, still under its temporary name, perhaps with another that goes with it;
/// dropped, it leaves nothing.
///
/// Example: [`ResultFile`].
#[derive(Debug)]
#[must_use = "a file that is not put in place is removed"]
pub struct CompleteFile {
    places: Vec<Place>,
}

/// Where a file is and where it shall be.
#[derive(Debug)]
struct Place {
    /// `None` when the file has its name.
    temporary: Option<PathBuf>,
    path: PathBuf,
}

impl ResultFile {
    /// Ends the file, when all of it has reached the disk.
    ///
    /// *Errors*: `E0501`, `E0502`; nothing of the file is left then.
    pub fn finish(mut self) -> Result<CompleteFile, Diagnostic> {
        // A full disk may show only when the data leave the cache.
        let flushed = self.output.flush();
        flushed
            .and_then(|()| self.output.get_ref().sync_all())
            .map_err(|error| self.refuse(&error))?;
        Ok(CompleteFile {
            places: vec![self.place],
        })
    }

    /// The message for an error of writing to this file.
    pub fn refuse(&self, error: &io::Error) -> Diagnostic {
        self.place.refuse(error)
    }
}

impl CompleteFile {
    /// Puts the file under its name, in place of an earlier one.
    ///
    /// *Errors*: `E0501`; the earlier file is still there then.
    pub fn put_in_place(mut self) -> Result<(), Diagnostic> {
        for place in &mut self.places {
            if let Some(temporary) = &place.temporary {
                fs::rename(temporary, &place.path).map_err(|error| place.refuse(&error))?;
                place.temporary = None;
            }
        }
        Ok(())
    }

    /// Both files as one: they are put in place together.
    pub(crate) fn with(mut self, other: CompleteFile) -> CompleteFile {
        self.places.extend(other.places);
        self
    }

    fn is(&self, path: &Path) -> bool {
        self.places.iter().any(|place| place.path == path)
    }
}

impl Place {
    fn refuse(&self, error: &io::Error) -> Diagnostic {
        failure::unwritable(&self.path.display().to_string(), error)
    }
}

impl Write for ResultFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.output.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.output.flush()
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        if let Some(temporary) = &self.temporary {
            let _ = fs::remove_file(temporary);
        }
    }
}

/// A name beside `path` that no two runs at the same time share.
fn temporary_name(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.{}.part", std::process::id()))
}

/// The number of the process that gave a file its [`temporary_name`].
fn writer(name: &str) -> Option<u32> {
    let middle = name.strip_prefix('.')?.strip_suffix(".part")?;
    middle.rsplit_once('.')?.1.parse().ok()
}

/// Removes files that a run which is gone left half written. Where the system tells that another process
/// of that number runs, the file stays: it may be a run at the same time.
fn remove_abandoned(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let process = writer(&entry.file_name().to_string_lossy());
        let is_gone = |process: u32| {
            process == std::process::id() || !Path::new("/proc").join(process.to_string()).exists()
        };
        if process.is_some_and(is_gone) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

fn remove(path: &Path) -> Result<(), Diagnostic> {
    match fs::remove_file(path) {
        Err(error) if !is_absent(&error) => {
            Err(failure::unwritable(&path.display().to_string(), &error))
        }
        _ => Ok(()),
    }
}

fn is_absent(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::NotFound | io::ErrorKind::NotADirectory
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use veribound_model::diagnostic::Diagnostics;

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
        drop(folder.write("y.csv", b"t\n").unwrap());
        assert_eq!(files(folder.path()), [""; 0]);
        folder
            .write("x.csv", b"old")
            .unwrap()
            .put_in_place()
            .unwrap();
        let mut file = folder.file("x.csv").unwrap();
        file.write_all(b"new").unwrap();
        let file = file.finish().unwrap();
        assert_eq!(fs::read(folder.path().join("x.csv")).unwrap(), b"old");
        file.put_in_place().unwrap();
        assert_eq!(fs::read(folder.path().join("x.csv")).unwrap(), b"new");
        assert_eq!(files(folder.path()), ["x.csv"]);
    }

    #[test]
    fn results_replace_those_of_an_earlier_run_together() {
        let place = tempfile::tempdir().unwrap();
        let folder = ResultFolder::create(place.path()).unwrap();
        let write = |names: &[&str]| {
            let files = names.iter().map(|name| folder.write(name, b"x"));
            files.collect::<Result<Vec<_>, _>>().unwrap()
        };
        fs::create_dir(place.path().join("fig")).unwrap();
        fs::write(place.path().join("fig/modes.svg"), b"the user's own").unwrap();
        folder.publish(write(&["params.csv"])).unwrap();
        assert_eq!(files(&place.path().join("fig")), ["modes.svg"]);
        folder
            .publish(write(&[
                "summary.json",
                "params.csv",
                "fig/outputs.svg",
                "fig/paving_a_b.svg",
                "fig/work.png",
            ]))
            .unwrap();
        fs::write(place.path().join("notes.txt"), b"the user's own").unwrap();
        folder
            .publish(write(&["summary.json", "fig/outputs.svg"]))
            .unwrap();
        assert_eq!(files(place.path()), ["fig", "notes.txt", "summary.json"]);
        assert_eq!(files(&place.path().join("fig")), ["outputs.svg"]);
        folder
            .publish(write(&["params.csv", "summary.json"]))
            .unwrap();
        assert_eq!(
            files(place.path()),
            ["notes.txt", "params.csv", "summary.json"]
        );
        // A name that cannot be given: nothing claims to be complete.
        let results = write(&["summary.json", "params.csv"]);
        fs::remove_file(place.path().join("params.csv")).unwrap();
        fs::create_dir_all(place.path().join("params.csv/full")).unwrap();
        assert_eq!(folder.publish(results).unwrap_err().code, "E0501");
        assert_eq!(files(place.path()), ["notes.txt", "params.csv"]);
    }

    #[test]
    fn what_a_killed_run_left_is_removed() {
        let place = tempfile::tempdir().unwrap();
        fs::create_dir(place.path().join("fig")).unwrap();
        // No process has this number.
        let left = [
            ".params.csv.4294967295.part",
            "fig/.outputs.svg.4294967295.part",
        ];
        let kept = [".mine.part", "a.1.part", ".hidden"];
        for name in left.iter().chain(&kept) {
            fs::write(place.path().join(name), b"t").unwrap();
        }
        ResultFolder::create(place.path()).unwrap();
        assert_eq!(
            files(place.path()),
            [".hidden", ".mine.part", "a.1.part", "fig"]
        );
        assert_eq!(files(&place.path().join("fig")), [""; 0]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_said_and_leaves_nothing() {
        let place = tempfile::tempdir().unwrap();
        let temporary = place.path().join(".x.csv.part");
        fs::write(&temporary, b"").unwrap();
        let full = File::options().write(true).open("/dev/full").unwrap();
        let mut file = ResultFile {
            output: BufWriter::new(full),
            place: Place {
                temporary: Some(temporary),
                path: place.path().join("x.csv"),
            },
        };
        file.write_all(b"t,phi\n").unwrap();
        let error = file.finish().unwrap_err();
        let wanted = format!(
            "error[E0502]: cannot write `{}`: the disk is full\n |\n = help: free some space, or choose a folder on \
             another disk with `-o DIR`\n",
            place.path().join("x.csv").display()
        );
        assert_eq!(Diagnostics::from(error).render(false), wanted);
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
