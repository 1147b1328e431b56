//! `veribound completions` and `veribound man`: made of the same flags that are parsed.

use super::arguments::{Arguments, Completions, Man};
use super::ending::Ending;
use super::{Outcome, message};
use clap::CommandFactory;
use std::io;
use veribound_data::ResultFolder;
use veribound_model::diagnostic::Diagnostic;

/// Prints the completions of a shell.
pub fn completions(arguments: &Completions) -> Outcome {
    let mut script = Vec::new();
    clap_complete::generate(
        arguments.shell,
        &mut Arguments::command(),
        "veribound",
        &mut script,
    );
    message::say(&String::from_utf8_lossy(&script));
    Ok(Ending::Done)
}

/// Prints the manual page, or writes one for every command.
pub fn pages(arguments: &Man) -> Outcome {
    let mut command = Arguments::command();
    // Commands of commands get the whole name, and flags that all have.
    command.build();
    let Some(output) = &arguments.output else {
        let page = page(&command).map_err(|error| unwritten(&error))?;
        message::say(&page);
        return Ok(Ending::Done);
    };
    let folder = ResultFolder::create(output)?;
    let commands = command
        .get_subcommands()
        .filter(|one| one.get_name() != "help");
    let mut files = Vec::new();
    for one in std::iter::once(&command).chain(commands) {
        let name = one.get_display_name().unwrap_or(one.get_name());
        let page = page(one).map_err(|error| unwritten(&error))?;
        files.push(folder.write(&format!("{name}.1"), page.as_bytes())?);
    }
    files
        .into_iter()
        .try_for_each(veribound_data::CompleteFile::put_in_place)?;
    Ok(Ending::Done)
}

/// A manual page in the language of man (roff).
fn page(command: &clap::Command) -> io::Result<String> {
    let mut text = Vec::new();
    clap_mangen::Man::new(command.clone()).render(&mut text)?;
    Ok(String::from_utf8_lossy(&text).into_owned())
}

fn unwritten(error: &io::Error) -> Diagnostic {
    Diagnostic::new("E0503", format!("the manual cannot be written: {error}"))
}
