//! How a run ended, and the exit code that says so.

use std::process::ExitCode;

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// Done; for an observation: consistent.
    Done,
    /// Proved inconsistent.
    Inconsistent,
    /// Wrong input or usage.
    Misuse,
    /// Neither was proved.
    Undecided,
    /// Stopped by the user; the files are complete up to the last sample.
    Interrupted,
}

impl Ending {
    /// The exit code of the program.
    pub fn code(self) -> ExitCode {
        ExitCode::from(match self {
            Ending::Done => 0,
            Ending::Inconsistent => 1,
            Ending::Misuse => 2,
            Ending::Undecided => 3,
            // What shells report for a program that SIGINT ended.
            Ending::Interrupted => 130,
        })
    }
}
