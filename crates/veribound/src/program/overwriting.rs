//! Refuses to replace with results what a run reads.

use std::fs;
use std::path::{Component, Path, PathBuf};
use veribound_data::ResultFolder;
use veribound_model::diagnostic::Diagnostic;

/// A file that a run reads, and what it is.
pub type Read<'a> = (&'static str, &'a Path);

/// Refuses results in `folder` that would replace one of the files that are read, or those of an
/// earlier run in one of the folders `earlier`.
///
/// *Errors*: `E0611`.
pub fn refuse_results(
    folder: &Path,
    files: &[Read<'_>],
    earlier: &[Read<'_>],
) -> Result<(), Diagnostic> {
    let help = "choose another folder with `-o DIR`";
    for (what, path) in earlier {
        if is_same(folder, path) {
            let message = format!(
                "the results would replace those in `{}`, {what}",
                path.display()
            );
            return Err(Diagnostic::new("E0611", message).help(help));
        }
    }
    ResultFolder::names(folder)
        .iter()
        .try_for_each(|result| refuse(result, files, help))
}

/// Refuses a record in `result` that would replace one of the files that are read.
///
/// *Errors*: `E0611`.
pub fn refuse_record(result: &Path, files: &[Read<'_>]) -> Result<(), Diagnostic> {
    refuse(result, files, "choose another name with `-o RECORD`")
}

fn refuse(result: &Path, files: &[Read<'_>], help: &str) -> Result<(), Diagnostic> {
    match files.iter().find(|(_, path)| is_same(result, path)) {
        Some((what, path)) => {
            let message = format!("`{}` is {what}: the run would replace it", path.display());
            Err(Diagnostic::new("E0611", message).help(help))
        }
        None => Ok(()),
    }
}

/// Whether writing to `result` replaces what is at `path`, whatever links lead there.
fn is_same(result: &Path, path: &Path) -> bool {
    fs::canonicalize(path).is_ok_and(|path| canonical(result) == Some(path))
}

/// The place that a path names, whether there is something or not.
fn canonical(path: &Path) -> Option<PathBuf> {
    if let Ok(found) = fs::canonicalize(path) {
        return Some(found);
    }
    let parent = match path.parent()? {
        none if none.as_os_str().is_empty() => canonical(Path::new("."))?,
        parent => canonical(parent)?,
    };
    match path.components().next_back()? {
        Component::Normal(name) => Some(parent.join(name)),
        // Of a folder that is still to be made.
        Component::ParentDir => parent.parent().map(Path::to_path_buf),
        _ => None,
    }
}
