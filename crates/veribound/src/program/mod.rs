//! The parts of the program: what was typed, what it means, what is done, what is said.
//!
//! The Python package does the same things with the same parts, so that a run is prepared, and its results
//! and problems told, in one place. It is no interface for others.

pub mod arguments;
pub mod assumptions;
pub mod check;
mod doctor;
pub mod enclose;
pub mod ending;
mod engine;
mod explain;
pub mod files;
mod flags;
pub mod identify;
mod interrupt;
mod manual;
pub mod message;
mod noise;
pub mod numbers;
pub mod observe;
mod overlay;
mod overwriting;
mod page;
mod profile;
pub mod progress;
pub mod reading;
mod run_info;
mod same_units;
pub mod simulate;
mod starter;
pub mod table;
pub mod verdict;

use arguments::{Arguments, Command};
use clap::Parser;
use ending::Ending;
use std::process::ExitCode;
use veribound_interval::lanes::Path;
use veribound_model::diagnostic::{Diagnostic, Diagnostics};

/// Runs the program; the exit code is the verdict.
pub fn main() -> ExitCode {
    let arguments = Arguments::parse();
    message::choose_color(arguments.color);
    let done = match &arguments.command {
        // Computes nothing, and tells also what to do where the arithmetic is refused.
        Command::Explain(explain) => explain::run(explain),
        Command::Doctor(doctor) => doctor::run(doctor),
        Command::Completions(completions) => manual::completions(completions),
        Command::Man(man) => manual::pages(man),
        Command::New(new) => starter::run(new),
        Command::Check(check) => arithmetic().and_then(|()| check::run(check)),
        Command::Observe(observe) => arithmetic().and_then(|()| observe::run(observe)),
        Command::Identify(identify) => arithmetic().and_then(|()| identify::run(identify)),
        Command::Enclose(enclose) => arithmetic().and_then(|()| enclose::run(enclose)),
        Command::Simulate(simulate) => arithmetic().and_then(|()| simulate::run(simulate)),
    };
    let ending = done.unwrap_or_else(|problems| {
        message::complain(&problems);
        Ending::Misuse
    });
    ending.code()
}

/// Refuses arithmetic with which nothing would be proved.
pub fn arithmetic() -> Result<(), Diagnostics> {
    veribound_interval::self_test().map_err(|error| unsound(&error))?;
    match Path::refused() {
        Some(wish) => Err(no_such_path(wish).into()),
        None => Ok(()),
    }
}

fn unsound(error: &veribound_interval::SelfTestError) -> Diagnostic {
    Diagnostic::new("E0507", error.to_string())
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
pub type Outcome = Result<Ending, Diagnostics>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn untrusted_arithmetic_is_told_word_for_word() {
        let error = veribound_interval::SelfTestError::SubnormalOperandsFlushed;
        let said = Diagnostics::from(unsound(&error)).render(false);
        let wanted = "error[E0507]: the arithmetic of this machine cannot be trusted: very small operands are read \
            as zero\n |\n = help: run it on a machine, or in a process, with plain round-to-nearest arithmetic\n";
        assert_eq!(said, wanted);
    }
}
