//! The sections [outputs], [signals] and [events].

use crate::diagnostic::nearest;
use crate::file::equations::report_all;
use crate::file::lower::Lowering;
use crate::file::quantities::{ReadParam, column, error_bound, unit};
use crate::file::reader::{Entry, Reader, Table, Value};
use crate::file::scope::{Equation, Meaning, Scope};
use crate::file::text::Text;
use crate::graph::{Node, Var};
use crate::model::{ErrorBound, Outliers, Output, Reset, Signal, State};
use crate::syntax::{number, parse};
use crate::units::{self, Unit};
use std::ops::Range;
use toml::de::DeValue;
use veribound_interval::Decimal;

/// An output before its expression is in the graph.
pub(crate) struct ReadOutput {
    pub name: String,
    pub unit: String,
    column: Option<String>,
    error: ErrorBound,
    outliers: Option<Outliers>,
    pub equation: Equation,
}

/// A signal before its equalities are in the graph.
pub(crate) struct ReadSignal {
    name: String,
    column: Option<String>,
    pub proves: Vec<Equation>,
    latency: Decimal,
}

/// [outputs]: `"phi +- 0.1"` or a table with `expr` and `error`.
pub(crate) fn outputs(reader: &mut Reader, file: &Table, scope: &mut Scope) -> Vec<ReadOutput> {
    let help = "write [outputs] with lines like phi_m = \"phi +- 0.1\"";
    let section = file.find("outputs");
    let table = section.and_then(|entry| reader.table(entry.value, entry.place.clone(), help));
    let entries = table.map(|table| table.entries).unwrap_or_default();
    if entries.is_empty()
        && section.is_none_or(|entry| matches!(entry.value.value, DeValue::Table(_)))
    {
        let place = section.map_or(0..0, |entry| entry.place.clone());
        reader.report(
            "E0109",
            "the model has no outputs",
            place,
            "nothing is measured",
            help,
        );
    }
    let mut found = Vec::new();
    for entry in &entries {
        scope.declare(
            reader,
            entry.key,
            entry.place.clone(),
            Meaning::Measured("an output"),
        );
        let output = match entry.value.value {
            DeValue::String(text) => {
                let text = Text::new(&reader.source.text, entry.value.place(), text);
                short_output(reader, entry, text)
            }
            _ => long_output(reader, entry),
        };
        found.extend(output);
    }
    found
}

fn short_output(reader: &mut Reader, entry: &Entry, text: Text) -> Option<ReadOutput> {
    let (body, unit_range) = match units::split_unit(&text.value) {
        Ok(parts) => parts,
        Err(problem) => {
            reader.report_in(&text, problem);
            return None;
        }
    };
    let unit = unit_range
        .clone()
        .and_then(|range| text.value.get(range))
        .unwrap_or("");
    if let Err(problem) = Unit::read(unit) {
        let start = unit_range.map_or(0, |range| range.start);
        reader.report_in(&text, problem.shifted(start));
    }
    let (ast, bound) = match parse::measurement(body) {
        Ok(parts) => parts,
        Err(problems) => {
            for problem in problems {
                reader.report_in(&text, problem);
            }
            return None;
        }
    };
    let Some(bound) = bound else {
        no_bound(
            reader,
            entry.key,
            text.range,
            &format!("write \"{} +- 0.1\"", body.trim()),
        );
        return None;
    };
    let absolute = match number::decimal(body.get(bound.clone()).unwrap_or(""), bound) {
        Ok(decimal) => decimal,
        Err(problem) => {
            reader.report_in(&text, problem);
            return None;
        }
    };
    Some(ReadOutput {
        name: entry.key.to_string(),
        unit: unit.trim().to_string(),
        column: None,
        error: ErrorBound {
            absolute,
            relative: Decimal::zero(),
        },
        outliers: None,
        equation: Equation { text, ast },
    })
}

fn long_output(reader: &mut Reader, entry: &Entry) -> Option<ReadOutput> {
    let help = "write { expr = \"phi\", unit = \"rad\", error = { absolute = 0.1 } }";
    let table = reader.table(entry.value, entry.place.clone(), help)?;
    let keys = ["expr", "unit", "error", "column", "outliers"];
    reader.allow(&table, &keys, "an output");
    let outliers = outliers(reader, &table);
    let unit = unit(reader, &table);
    let column = column(reader, &table);
    let error = match table.value("error") {
        Some(value) => error_bound(reader, &table, value, &[]),
        None => {
            no_bound(
                reader,
                entry.key,
                entry.place.clone(),
                "write error = { absolute = 0.1 }",
            );
            None
        }
    };
    let text = match table.value("expr") {
        Some(value) => reader.string(value, help),
        None => {
            reader.report(
                "E0109",
                format!("the output `{}` has no expression", entry.key),
                entry.place.clone(),
                "what is measured?",
                "write expr = \"phi\"",
            );
            None
        }
    };
    let equation = text.and_then(|text| {
        let ast = reader.expression(&text)?;
        Some(Equation { text, ast })
    });
    Some(ReadOutput {
        name: entry.key.to_string(),
        unit,
        column,
        error: error?,
        outliers,
        equation: equation?,
    })
}

/// How many samples may be off by more than the bound: `outliers = "2 in 100"`.
fn outliers(reader: &mut Reader, table: &Table) -> Option<Outliers> {
    let help = "write outliers = \"2 in 100\": of any 100 samples in a row at most 2 are off by more than the error bound";
    let text = reader.string(table.value("outliers")?, help)?;
    let numbers: Option<Vec<usize>> = text
        .value
        .split(" in ")
        .map(|number| number.trim().parse().ok())
        .collect();
    match numbers.as_deref() {
        Some([most, of]) if most < of => Some(Outliers {
            most: *most,
            of: *of,
        }),
        Some([most, of]) => {
            let message =
                format!("{most} of {of} samples may be outliers: then none tells anything");
            reader.report("E0107", message, text.range, "all of them", help);
            None
        }
        _ => {
            let message = format!("`{}` does not say how many of how many", text.value);
            reader.report("E0107", message, text.range, "not understood", help);
            None
        }
    }
}

fn no_bound(reader: &mut Reader, name: &str, place: Range<usize>, help: &str) {
    reader.report(
        "E0212",
        format!("the output `{name}` has no error bound"),
        place,
        "how wrong can a recorded value be?",
        help,
    );
}

/// [signals]: binary columns of the record.
pub(crate) fn signals(reader: &mut Reader, file: &Table, scope: &mut Scope) -> Vec<ReadSignal> {
    let Some(section) = file.find("signals") else {
        return Vec::new();
    };
    let help = "write [signals] with lines like still = { from = \"column\", type = \"bool\" }";
    let Some(table) = reader.table(section.value, section.place.clone(), help) else {
        return Vec::new();
    };
    let mut found = Vec::new();
    for entry in &table.entries {
        scope.declare(
            reader,
            entry.key,
            entry.place.clone(),
            Meaning::Measured("a signal"),
        );
        let Some(table) = reader.table(entry.value, entry.place.clone(), help) else {
            continue;
        };
        reader.allow(
            &table,
            &["column", "from", "type", "proves", "latency"],
            "a signal",
        );
        only(reader, &table, "from", "column");
        only(reader, &table, "type", "bool");
        let column = column(reader, &table);
        let proves = proofs(reader, &table);
        let latency_help =
            "write latency = 0.02: seconds from standstill until the signal tells it";
        let latency = match table.value("latency") {
            Some(value) => reader
                .magnitude(value, "the latency", latency_help)
                .unwrap_or_else(Decimal::zero),
            None => {
                if let Some(proves) = table.find("proves") {
                    reader.report(
                        "E0214",
                        format!(
                            "the signal `{}` proves something, but its latency is not stated",
                            entry.key
                        ),
                        proves.place.clone(),
                        "true since when?",
                        latency_help,
                    );
                }
                Decimal::zero()
            }
        };
        found.push(ReadSignal {
            name: entry.key.to_string(),
            column,
            proves,
            latency,
        });
    }
    found
}

/// The key, if given, must have the one value there is.
fn only(reader: &mut Reader, table: &Table, key: &str, wanted: &str) {
    if let Some(value) = table.value(key)
        && let Some(text) = reader.string(value, &format!("write {key} = \"{wanted}\""))
        && text.value != wanted
    {
        reader.report(
            "E0107",
            format!("`{key}` cannot be `{}`", text.value),
            text.range,
            "unknown",
            format!("write {key} = \"{wanted}\""),
        );
    }
}

fn proofs(reader: &mut Reader, table: &Table) -> Vec<Equation> {
    let Some(value) = table.value("proves") else {
        return Vec::new();
    };
    let items: Vec<Value> = value.array().unwrap_or_else(|| vec![value]);
    items
        .into_iter()
        .filter_map(|item| {
            let text = reader.string(item, "write an equality, as in proves = \"omega == 0\"")?;
            let ast = reader.expression(&text)?;
            Some(Equation { text, ast })
        })
        .collect()
}

/// [events]: what a signal does to parameters. Gives the resets with the index of their signal.
pub(crate) fn events(
    reader: &mut Reader,
    file: &Table,
    signals: &[ReadSignal],
    params: &[ReadParam],
) -> Vec<(usize, Reset)> {
    let help =
        "write [events.standstill] with when = \"still\", lasts = 0.2, action = \"reset T_Fs\"";
    let mut found = Vec::new();
    let mut known: Vec<&str> = Vec::new();
    let table = file
        .find("events")
        .and_then(|entry| reader.table(entry.value, entry.place.clone(), help));
    for entry in table.iter().flat_map(|table| &table.entries) {
        known.push(entry.key);
        if let Some(table) = reader.table(entry.value, entry.place.clone(), help) {
            found.extend(event(reader, entry, &table, signals, params));
        }
    }
    for param in params {
        let Some(resets) = &param.resets else {
            continue;
        };
        if !known.contains(&resets.value.as_str()) {
            let help = match nearest(&resets.value, known.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => help.to_string(),
            };
            let message = format!("there is no event `{}`", resets.value);
            reader.report(
                "E0216",
                message,
                resets.range.clone(),
                "not in [events]",
                help,
            );
        }
    }
    found
}

fn event(
    reader: &mut Reader,
    entry: &Entry,
    table: &Table,
    signals: &[ReadSignal],
    params: &[ReadParam],
) -> Vec<(usize, Reset)> {
    reader.allow(table, &["when", "lasts", "action"], "an event");
    let missing = |reader: &mut Reader, key: &str, help: &str| {
        let message = format!("the event `{}` has no `{key}`", entry.key);
        reader.report("E0109", message, entry.place.clone(), "incomplete", help);
    };
    let when_help = "write when = \"still\", the name of a signal";
    let signal = match table.value("when") {
        Some(value) => reader.string(value, when_help).and_then(|text| {
            let names = || signals.iter().map(|signal| signal.name.as_str());
            let position = names().position(|name| name == text.value.trim());
            if position.is_none() {
                let help = match nearest(text.value.trim(), names()) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => "declare it in [signals]".to_string(),
                };
                let message = format!("there is no signal `{}`", text.value);
                reader.report("E0216", message, text.range, "not in [signals]", help);
            }
            position
        }),
        None => {
            missing(reader, "when", when_help);
            None
        }
    };
    let lasts_help = "write lasts = 0.2: seconds for which the signal must have been true";
    let lasts = match table.value("lasts") {
        Some(value) => reader.magnitude(value, "a duration", lasts_help),
        None => {
            missing(reader, "lasts", lasts_help);
            None
        }
    };
    let mut targets: Vec<usize> = (0..params.len())
        .filter(|i| {
            let resets = params.get(*i).and_then(|param| param.resets.as_ref());
            resets.is_some_and(|resets| resets.value == entry.key)
        })
        .collect();
    match table.value("action") {
        Some(value) => targets.extend(actions(reader, value, params)),
        None if targets.is_empty() => missing(reader, "action", "write action = \"reset T_Fs\""),
        None => {}
    }
    targets.sort_unstable();
    targets.dedup();
    let (Some(signal), Some(lasts)) = (signal, lasts) else {
        return Vec::new();
    };
    targets
        .into_iter()
        .map(|param| {
            (
                signal,
                Reset {
                    event: entry.key.to_string(),
                    param,
                    lasts: lasts.clone(),
                },
            )
        })
        .collect()
}

/// `reset NAME`, or `reset NAME, NAME`.
fn actions(reader: &mut Reader, value: Value, params: &[ReadParam]) -> Vec<usize> {
    let help = "write action = \"reset T_Fs\", the name of a parameter";
    let Some(text) = reader.string(value, help) else {
        return Vec::new();
    };
    let Some(list) = text.value.trim().strip_prefix("reset ") else {
        let message = format!("there is no action `{}`", text.value);
        reader.report("E0216", message, text.range, "expected `reset NAME`", help);
        return Vec::new();
    };
    let mut found = Vec::new();
    for name in list.split(',').map(str::trim) {
        let names = || params.iter().map(|read| read.param.name.as_str());
        match names().position(|known| known == name) {
            Some(index) => found.push(index),
            None => {
                let help = match nearest(name, names()) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => "only parameters can be reset".to_string(),
                };
                let start = text.value.find(name).unwrap_or(0);
                let place = text.place(start..start + name.len());
                let message = format!("there is no parameter `{name}`");
                reader.report("E0216", message, place, "not in [params]", help);
            }
        }
    }
    found
}

/// Puts the outputs into the graph. An output that is a state has the unit of that state, unless it
/// has one of its own.
pub(crate) fn lower_outputs(
    reader: &mut Reader,
    lowering: &mut Lowering,
    outputs: Vec<ReadOutput>,
    states: &[State],
) -> Vec<Output> {
    let mut found = Vec::new();
    for output in outputs {
        match lowering.plain(&output.equation.ast) {
            Ok(expr) => {
                let state = match *lowering.graph.node(expr) {
                    Node::Var(Var::State(state)) => states.get(state),
                    _ => None,
                };
                let own = Some(output.unit).filter(|unit| !unit.is_empty());
                found.push(Output {
                    name: output.name,
                    unit: own.unwrap_or_else(|| state.map_or(String::new(), |s| s.unit.clone())),
                    column: output.column,
                    expr,
                    error: output.error,
                    outliers: output.outliers,
                });
            }
            Err(problems) => report_all(reader, &output.equation, problems),
        }
    }
    found
}

/// Puts what the signals prove into the graph and adds the resets.
pub(crate) fn lower_signals(
    reader: &mut Reader,
    lowering: &mut Lowering,
    signals: Vec<ReadSignal>,
    resets: Vec<(usize, Reset)>,
) -> Vec<Signal> {
    let mut found = Vec::new();
    for (index, signal) in signals.into_iter().enumerate() {
        let mut proves_zero = Vec::new();
        for equation in &signal.proves {
            match lowering.equality(equation) {
                Ok(expr) => proves_zero.push(expr),
                Err(problems) => report_all(reader, equation, problems),
            }
        }
        let own = resets.iter().filter(|(signal, _)| *signal == index);
        found.push(Signal {
            name: signal.name,
            column: signal.column,
            proves_zero,
            latency: signal.latency,
            resets: own.map(|(_, reset)| reset.clone()).collect(),
        });
    }
    found
}
