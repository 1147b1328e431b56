//! `run.toml`: all that repeats the run.

use super::arguments::Observe;
use clap::ValueEnum;
use std::path::PathBuf;
use toml::{Table, Value};
use veribound_data::{FileInfo, Platform, Program, Record, RecordInfo, RunInfo};
use veribound_model::diagnostic::Diagnostic;

/// What repeats the run that `arguments` ask for.
pub fn of(
    arguments: &Observe,
    record: &Record,
    start: Option<&PathBuf>,
    assumptions: &[String],
) -> Result<RunInfo, Diagnostic> {
    Ok(RunInfo {
        program: Program {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            command: std::env::args_os()
                .map(|word| word.to_string_lossy().into_owned())
                .collect(),
        },
        platform: Platform::current(),
        model: FileInfo::of(&arguments.model)?,
        record: Some(RecordInfo::of(record)),
        start: start.map(FileInfo::of).transpose()?,
        options: options(arguments, assumptions),
    })
}

/// Every option with its value, given or default.
fn options(arguments: &Observe, assumptions: &[String]) -> Table {
    let (reading, given, method, showing) = (
        &arguments.reading,
        &arguments.assumptions,
        &arguments.method,
        &arguments.showing,
    );
    let mut table = Table::new();
    let mut put = |name: &str, value: Value| table.insert(name.to_owned(), value);
    let texts = |list: Vec<String>| Value::Array(list.into_iter().map(Value::String).collect());
    if let Some(time) = &reading.time {
        put("time", Value::String(time.clone()));
    }
    let columns = reading
        .column
        .iter()
        .map(|flag| format!("{}={}", flag.variable, flag.column));
    put("column", texts(columns.collect()));
    // Times are kept as text: TOML numbers are floats.
    for (name, time) in [("from", &reading.from), ("to", &reading.to)] {
        if let Some(time) = time {
            put(name, Value::String(time.to_string()));
        }
    }
    put(
        "reset",
        texts(given.reset.iter().map(|flag| flag.text.clone()).collect()),
    );
    put(
        "input_error",
        texts(
            given
                .input_error
                .iter()
                .map(|flag| flag.text.clone())
                .collect(),
        ),
    );
    put("assumptions", texts(assumptions.to_vec()));
    for (name, count) in [
        ("boxes", method.boxes),
        ("bisections", method.bisections),
        ("every", method.every),
        ("order", method.order),
        ("halvings", method.halvings as usize),
    ] {
        put(name, Value::Integer(count as i64));
    }
    for (name, number) in [
        ("epsilon", method.epsilon),
        ("velocity_horizon", method.velocity_horizon),
        ("longest_step", method.longest_step),
    ] {
        put(name, Value::Float(number));
    }
    let windows = method
        .windows
        .iter()
        .map(|length| Value::Integer(*length as i64));
    put("windows", Value::Array(windows.collect()));
    put("trisect", Value::Boolean(method.trisect));
    put(
        "merge_across_modes",
        Value::Boolean(method.merge_across_modes),
    );
    put("parameter_rule", named(method.parameter_rule));
    put(
        "figures",
        Value::Array(
            showing
                .figures
                .iter()
                .map(|format| named(*format))
                .collect(),
        ),
    );
    table
}

/// The name of a choice as it is typed.
fn named(choice: impl ValueEnum) -> Value {
    let name = choice
        .to_possible_value()
        .map(|value| value.get_name().to_owned());
    Value::String(name.unwrap_or_default())
}
