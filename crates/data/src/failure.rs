//! What the operating system refused, said as a message to the user.

use std::io;
use veribound_model::diagnostic::Diagnostic;

/// A file that cannot be read.
pub(crate) fn unreadable(path: &str, error: &io::Error) -> Diagnostic {
    let help = match error.kind() {
        io::ErrorKind::NotFound => "check the path",
        io::ErrorKind::PermissionDenied => "allow reading it, or copy it to where you may read",
        io::ErrorKind::IsADirectory => "name a file in this folder",
        _ => "copy the file to a local disk and try again",
    };
    Diagnostic::new("E0401", format!("cannot read `{path}`: {}", said(error))).help(help)
}

/// A file or folder of results that cannot be written.
pub(crate) fn unwritable(path: &str, error: &io::Error) -> Diagnostic {
    let code = match error.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => "E0502",
        _ => "E0501",
    };
    let help = match error.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            "free some space, or choose a folder on another disk with `-o DIR`"
        }
        io::ErrorKind::NotADirectory | io::ErrorKind::AlreadyExists => {
            "choose another name with `-o DIR`: a file of this name is in the way"
        }
        _ => "choose a folder that you may write to with `-o DIR`",
    };
    Diagnostic::new(code, format!("cannot write `{path}`: {}", said(error))).help(help)
}

/// The reason in words that do not depend on the platform where there are any.
fn said(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "there is no such file or folder".to_owned(),
        io::ErrorKind::PermissionDenied => "permission denied".to_owned(),
        io::ErrorKind::IsADirectory => "it is a folder".to_owned(),
        io::ErrorKind::NotADirectory => "a part of the path is a file, not a folder".to_owned(),
        io::ErrorKind::AlreadyExists => "it exists and is no folder".to_owned(),
        io::ErrorKind::StorageFull => "the disk is full".to_owned(),
        io::ErrorKind::QuotaExceeded => "the quota of the disk is used up".to_owned(),
        io::ErrorKind::ReadOnlyFilesystem => "the disk is read-only".to_owned(),
        _ => error.to_string(),
    }
}
