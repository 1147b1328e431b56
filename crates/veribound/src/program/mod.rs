//! The parts of the program: what was typed, what it means, what is done, what is said.

mod arguments;
mod assumptions;
mod check;
mod ending;
mod files;
mod flags;
mod interrupt;
mod message;
mod noise;
mod numbers;
mod observe;
mod overlay;
mod overwriting;
mod profile;
mod progress;
mod run_info;
mod same_units;
mod simulate;
mod table;
mod verdict;

use arguments::{Arguments, Command};
use clap::Parser;
use ending::Ending;
use std::process::ExitCode;
use veribound_interval::lanes::Path;
use veribound_model::diagnostic::{Diagnostic, Diagnostics};

/// Runs the program; the exit code is the verdict.
pub fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let done = veribound_interval::self_test()
        .map_err(|error| unsound(&error).into())
        .and_then(|()| match Path::refused() {
            Some(wish) => Err(no_such_path(wish).into()),
            None => Ok(()),
        })
        .and_then(|()| match &arguments.command {
            Command::Check(check) => check::run(check),
            Command::Observe(observe) => observe::run(observe),
            Command::Simulate(simulate) => simulate::run(simulate),
        });
    let ending = done.unwrap_or_else(|problems| {
        message::complain(&problems);
        Ending::Misuse
    });
    ending.code()
}

fn unsound(error: &veribound_interval::SelfTestError) -> Diagnostic {
    Diagnostic::new(
        "E0507",
        format!("the arithmetic of this machine cannot be trusted: {error}"),
    )
    .help("run it on a machine, or in a process, with plain round-to-nearest arithmetic")
}

fn no_such_path(wish: &str) -> Diagnostic {
    let known: Vec<&str> = Path::available().map(Path::name).collect();
    Diagnostic::new(
        "E0508",
        format!("VERIBOUND_LANES is `{wish}`, which this processor cannot do"),
    )
    .help(format!(
        "leave the variable out, or choose one of {}; the results are the same",
        known.join(", ")
    ))
}

/// What every part of the program gives back: how it ended, or what was wrong with the input.
type Outcome = Result<Ending, Diagnostics>;
