//! `run.toml`: all that repeats the run.

use super::arguments::{Enclose, Format, Identify, Observe, Reading, Weakening};
use clap::ValueEnum;
use toml::{Table, Value};
use veribound_data::{FileInfo, Platform, Program, Record, RecordInfo, RunInfo};
use veribound_flow::engine::Engine;
use veribound_model::Model;

/// The files of earlier runs that a run has read.
pub struct Earlier {
    /// Those it starts from.
    pub start: Vec<FileInfo>,
    /// The one its figures show.
    pub overlay: Option<FileInfo>,
}

/// What repeats the run that `arguments` ask for.
pub fn of(
    arguments: &Observe,
    (model, record): (&Model, &Record),
    earlier: Earlier,
    assumptions: &[String],
) -> RunInfo {
    RunInfo {
        program: program(&arguments.words),
        platform: Platform::current(),
        model: FileInfo::of_text(&arguments.model, &model.source.text),
        record: Some(RecordInfo::of(record)),
        records: Vec::new(),
        profile: None,
        start: earlier.start,
        overlay: earlier.overlay,
        options: options(arguments, assumptions),
    }
}

/// What repeats an enclosure.
pub fn of_enclosure(
    arguments: &Enclose,
    model: &Model,
    profile: Option<RecordInfo>,
    assumptions: &[String],
) -> RunInfo {
    let mut options = Table::new();
    let mut put = |name: &str, value: Value| options.insert(name.to_owned(), value);
    // Times are kept as text: TOML numbers are floats.
    for (name, time) in [
        ("until", &arguments.times.until),
        ("every", &arguments.times.every),
    ] {
        if let Some(time) = time {
            put(name, Value::String(time.to_string()));
        }
    }
    put("assumptions", texts(assumptions));
    put("parts", Value::Integer(arguments.parts as i64));
    let engine = Engine::from(arguments.engine).name();
    put("engine", Value::String(engine.to_owned()));
    put("sample", Value::Integer(arguments.sample as i64));
    put("seed", Value::String(arguments.seed.to_string()));
    put("plane", Value::String(arguments.plane.to_string()));
    put("figures", formats(&arguments.showing.figures));
    put("report", named(arguments.showing.report));
    put("parquet", Value::Boolean(arguments.showing.parquet));
    RunInfo {
        program: program(&arguments.words),
        platform: Platform::current(),
        model: FileInfo::of_text(&arguments.model, &model.source.text),
        record: None,
        records: Vec::new(),
        profile,
        start: Vec::new(),
        overlay: None,
        options,
    }
}

/// What repeats an identification.
pub fn of_identification(
    arguments: &Identify,
    (model, records): (&Model, &[Record]),
    assumptions: &[String],
) -> RunInfo {
    let mut options = Table::new();
    put_reading(&mut options, &arguments.reading);
    put_weakening(&mut options, &arguments.weakening, assumptions);
    let mut put = |name: &str, value: Value| options.insert(name.to_owned(), value);
    put("tightness", Value::Float(arguments.tightness));
    if let Some(share) = &arguments.paving {
        put("paving", Value::String(share.to_string()));
    }
    put("sets", Value::Integer(arguments.sets as i64));
    put("least-error", Value::Boolean(arguments.least_error));
    put(
        "least-disturbance",
        Value::Boolean(arguments.least_disturbance),
    );
    // Results do not depend on it; where it is not given, it is the machine's.
    if let Some(threads) = arguments.threads {
        put("threads", Value::Integer(threads as i64));
    }
    put("figures", formats(&arguments.showing.figures));
    put("report", named(arguments.showing.report));
    put("parquet", Value::Boolean(arguments.showing.parquet));
    RunInfo {
        program: program(&arguments.words),
        platform: Platform::current(),
        model: FileInfo::of_text(&arguments.model, &model.source.text),
        record: None,
        records: records.iter().map(RecordInfo::of).collect(),
        profile: None,
        start: Vec::new(),
        overlay: None,
        options,
    }
}

/// The program and its command line.
fn program(words: &[String]) -> Program {
    Program {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        command: words.to_vec(),
    }
}

/// The command line; the program may lie anywhere, and has the same name everywhere.
pub fn typed() -> Vec<String> {
    let program = std::iter::once("veribound".to_owned());
    let words = std::env::args_os().skip(1);
    let words = words.map(|word| word.to_string_lossy().into_owned());
    program.chain(words).collect()
}

fn formats(list: &[Format]) -> Value {
    Value::Array(list.iter().map(|format| named(*format)).collect())
}

/// How records are read.
fn put_reading(table: &mut Table, reading: &Reading) {
    let mut put = |name: &str, value: Value| table.insert(name.to_owned(), value);
    if let Some(time) = &reading.time {
        put("time", Value::String(time.clone()));
    }
    let columns = reading.column.iter();
    let columns = columns.map(|flag| format!("{}={}", flag.variable, flag.column));
    put("column", texts(columns));
    // Times are kept as text: TOML numbers are floats.
    for (name, time) in [("from", &reading.from), ("to", &reading.to)] {
        if let Some(time) = time {
            put(name, Value::String(time.to_string()));
        }
    }
}

/// What is assumed beside the model file.
fn put_weakening(table: &mut Table, given: &Weakening, assumptions: &[String]) {
    let mut put = |name: &str, value: Value| table.insert(name.to_owned(), value);
    put("reset", texts(given.reset.iter().map(|flag| &flag.text)));
    for (name, flags) in [
        (
            "input_error",
            texts(given.input_error.iter().map(|flag| &flag.text)),
        ),
        (
            "output_error",
            texts(given.output_error.iter().map(|flag| &flag.text)),
        ),
    ] {
        put(name, flags);
    }
    put("assumptions", texts(assumptions));
}

fn texts(list: impl IntoIterator<Item = impl ToString>) -> Value {
    let texts = list.into_iter().map(|text| Value::String(text.to_string()));
    Value::Array(texts.collect())
}

/// Every option with its value, given or default.
fn options(arguments: &Observe, assumptions: &[String]) -> Table {
    let (given, method, showing) = (
        &arguments.assumptions,
        &arguments.method,
        &arguments.showing,
    );
    let mut table = Table::new();
    put_reading(&mut table, &arguments.reading);
    put_weakening(&mut table, &given.weakening, assumptions);
    let mut put = |name: &str, value: Value| table.insert(name.to_owned(), value);
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
    put("engine", named(method.engine));
    put("method", named(method.method));
    put("rows", Value::Integer(method.rows as i64));
    put("replay", Value::Integer(method.replay as i64));
    put("history", Value::Integer(method.history as i64));
    put("budget", Value::Integer(method.budget as i64));
    put("figures", formats(&showing.output.figures));
    put("report", named(showing.output.report));
    put("parquet", Value::Boolean(showing.output.parquet));
    put("zoom", Value::String(showing.zoom.to_string()));
    for (name, folder) in [
        ("start_from", &given.start_from),
        ("overlay", &showing.overlay),
    ] {
        if let Some(folder) = folder {
            put(name, Value::String(folder.display().to_string()));
        }
    }
    table
}

/// The name of a choice as it is typed.
fn named(choice: impl ValueEnum) -> Value {
    let name = choice
        .to_possible_value()
        .map(|value| value.get_name().to_owned());
    Value::String(name.unwrap_or_default())
}
