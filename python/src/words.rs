//! Options of a call as words of the program's command line, so that they mean the same and are refused alike.

use crate::problem::misuse;
use clap::Parser;
use pyo3::prelude::*;
use veribound::program::arguments::{Arguments, Command};

/// What the words ask for; the first one is the command.
///
/// *Errors*: what the program says of wrong options.
pub fn parse(words: &[String]) -> PyResult<Command> {
    let program = std::iter::once("veribound");
    let typed = program.chain(words.iter().map(String::as_str));
    let arguments = Arguments::try_parse_from(typed).map_err(|error| {
        let text = error.to_string();
        // What follows tells how to use a terminal.
        let text = text.split("\n\nUsage:").next().unwrap_or_default();
        let text = text.split("\n\nFor more information").next();
        misuse(text.unwrap_or_default().trim_end())
    })?;
    Ok(arguments.command)
}

/// The words as `run.toml` tells them.
pub fn told(words: Vec<String>) -> Vec<String> {
    let program = std::iter::once("veribound".to_owned());
    program.chain(words).collect()
}
