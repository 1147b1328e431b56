//! What the program says: results to stdout, talk to stderr.

use super::arguments::Color;
use serde::Serialize;
use std::io::{self, IsTerminal, Write};
use std::ops::Range;
use std::sync::{Arc, OnceLock};
use veribound_model::diagnostic::{Diagnostic, Diagnostics, SourceText};

/// Writes a result to stdout. A reader that has gone away (`veribound check x | head`) is no error.
pub fn say(text: &str) {
    let mut out = io::stdout().lock();
    let _ = out.write_all(text.as_bytes());
    if !text.ends_with('\n') {
        let _ = out.write_all(b"\n");
    }
    let _ = out.flush();
}

/// Writes a JSON document to stdout.
///
/// *Errors*: `E0503` when it has no form in JSON.
pub fn say_json(document: &impl Serialize) -> Result<(), Diagnostic> {
    say(&veribound_data::to_json(document)?);
    Ok(())
}

/// What was typed of colours; the same for the whole process.
static COLOR: OnceLock<Color> = OnceLock::new();

/// Takes what was typed of colours, once, at the start.
pub fn choose_color(color: Color) {
    let _ = COLOR.set(color);
}

/// Whether problems are shown in colour. The variable counts when it is not empty (no-color.org).
fn has_color() -> bool {
    match COLOR.get() {
        Some(Color::Always) => true,
        Some(Color::Never) => false,
        _ => {
            let refused = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
            io::stderr().is_terminal() && !refused
        }
    }
}

/// Writes a remark to stderr.
pub fn remark(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// Writes problems to stderr, in colour on a terminal, and where more is told about them.
pub fn complain(problems: &Diagnostics) {
    let text = format!("{}\n{}", problems.render(has_color()), more_about(problems));
    let _ = io::stderr().lock().write_all(text.as_bytes());
}

/// The command that explains the codes of `problems`, each once.
fn more_about(problems: &Diagnostics) -> String {
    let mut codes: Vec<&str> = Vec::new();
    for problem in &problems.0 {
        if !codes.contains(&problem.code) {
            codes.push(problem.code);
        }
    }
    let it = if problems.0.len() == 1 {
        "this error"
    } else {
        "these errors"
    };
    format!(
        "for more about {it}, try: veribound explain {}\n",
        codes.join(" ")
    )
}

/// A problem with the value of a flag, shown as it was typed.
pub fn flag_problem(
    code: &'static str,
    message: impl Into<String>,
    (flag, value, part): (&str, &str, Range<usize>),
    label: &str,
    help: impl Into<String>,
) -> Diagnostic {
    let typed = format!("{flag} {value}");
    let start = flag.len() + 1;
    let source = Arc::new(SourceText::new("command line", typed));
    Diagnostic::new(code, message)
        .at(&source, start + part.start..start + part.end, label)
        .help(help)
}

/// `a`, `b` and `c`.
pub fn list<'n>(names: impl IntoIterator<Item = &'n str>) -> String {
    let quoted: Vec<String> = names.into_iter().map(|name| format!("`{name}`")).collect();
    match quoted.as_slice() {
        [] => "none".to_owned(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}
