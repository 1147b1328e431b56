//! The sections [states], [init], [inputs] and [params].

use crate::diagnostic::nearest;
use crate::file::constants;
use crate::file::reader::{Reader, Table, Value};
use crate::file::scope::{Meaning, Scope};
use crate::file::text::Text;
use crate::model::{ErrorBound, Hold, Input, Param, State};
use crate::units::{self, Unit};
use std::ops::Range;
use toml::de::DeValue;
use veribound_interval::{Decimal, Interval};

/// A parameter and the event that resets it, with the event's place.
pub(crate) struct ReadParam {
    pub param: Param,
    pub resets: Option<Text>,
}

/// Checks a unit and keeps it as written.
pub(crate) fn unit(reader: &mut Reader, table: &Table) -> String {
    let Some(value) = table.value("unit") else {
        return String::new();
    };
    let Some(text) = reader.string(value, "write the unit as a string, as in \"rad/s\"") else {
        return String::new();
    };
    if let Err(problem) = Unit::read(&text.value) {
        reader.report_in(&text, problem);
    }
    text.value
}

/// A name with an optional unit in square brackets: `omega [rad/s]`.
fn name_with_unit(reader: &mut Reader, text: &Text) -> Option<(String, Range<usize>, String)> {
    let (body, unit) = match units::split_unit(&text.value) {
        Ok(parts) => parts,
        Err(problem) => {
            reader.report_in(text, problem);
            return None;
        }
    };
    let unit_text = unit
        .clone()
        .and_then(|range| text.value.get(range))
        .unwrap_or("");
    if let Err(problem) = Unit::read(unit_text) {
        let start = unit.map_or(0, |range| range.start);
        reader.report_in(text, problem.shifted(start));
    }
    let name = body.trim();
    let start = body.len() - body.trim_start().len();
    Some((
        name.to_string(),
        text.place(start..start + name.len()),
        unit_text.trim().to_string(),
    ))
}

/// The optional name of the record's column.
pub(crate) fn column(reader: &mut Reader, table: &Table) -> Option<String> {
    let text = reader.string(
        table.value("column")?,
        "write the column's name as a string",
    )?;
    if text.value.trim().is_empty() {
        reader.report(
            "E0107",
            "the name of a column is empty",
            text.range,
            "expected a name",
            "write the name from the record's header",
        );
        return None;
    }
    Some(text.value)
}

/// A hard error bound: `{ absolute = 0.1, relative = 0.01 }` or a number, which is absolute.
///
/// What else the table may say, `more`, is for others to read.
pub(crate) fn error_bound(
    reader: &mut Reader,
    table: &Table,
    value: Value,
    more: &[&str],
) -> Option<ErrorBound> {
    let help = "write error = { absolute = 0.1 } or { relative = 0.01 }";
    let place = table
        .find("error")
        .map_or(table.place.clone(), |entry| entry.place.clone());
    if !matches!(value.value, DeValue::Table(_)) {
        let absolute = reader.magnitude(value, "an error bound", help)?;
        return Some(ErrorBound {
            absolute,
            relative: Decimal::zero(),
        });
    }
    let table = reader.table(value, place.clone(), help)?;
    let keys = [&["absolute", "relative"], more].concat();
    reader.allow(&table, &keys, "an error bound");
    let mut part = |key: &str| match table.value(key) {
        Some(value) => reader.magnitude(value, "an error bound", help),
        None => Some(Decimal::zero()),
    };
    let (absolute, relative) = (part("absolute"), part("relative"));
    let bound = ErrorBound {
        absolute: absolute?,
        relative: relative?,
    };
    if table.value("absolute").is_none() && table.value("relative").is_none() {
        reader.report(
            "E0212",
            "an error bound is empty",
            place,
            "no bound given",
            help,
        );
        return None;
    }
    Some(bound)
}

/// How long the error of an input stays the same: `hold = "sample"` or `"level"` beside its bound.
fn error_hold(reader: &mut Reader, value: Value) -> Hold {
    let help = "write hold = \"sample\" for an error that is constant from each sample to the next, hold = \"level\" \
                for one that is constant as long as the recorded value stays the same, or leave it out for any \
                function of time";
    let DeValue::Table(_) = value.value else {
        return Hold::Free;
    };
    let table = reader.table(value, value.place(), help);
    let Some(value) = table.and_then(|table| table.value("hold")) else {
        return Hold::Free;
    };
    let Some(text) = reader.string(value, help) else {
        return Hold::Free;
    };
    match text.value.as_str() {
        "sample" => Hold::Sample,
        "level" => Hold::Level,
        other => {
            let message = format!("there is no hold `{other}` of an error");
            reader.report("E0107", message, text.range, "unknown", help);
            Hold::Free
        }
    }
}

/// [states] as a table of tables or as a list of names, with start boxes there or in [init].
pub(crate) fn states(reader: &mut Reader, file: &Table, scope: &mut Scope) -> Vec<State> {
    let help = "write [states] with lines like omega = { unit = \"rad/s\", init = 0.0 }";
    let Some(section) = file.find("states") else {
        reader.report(
            "E0109",
            "the model has no states",
            0..0,
            "no [states] in this file",
            help,
        );
        scope.is_incomplete = true;
        return Vec::new();
    };
    let mut found: Vec<(State, Option<Interval>, Range<usize>)> = Vec::new();
    if let Some(items) = section.value.array() {
        for item in items {
            let Some(text) = reader.string(item, "write each state as \"name [unit]\"") else {
                scope.is_incomplete = true;
                continue;
            };
            let Some((name, place, unit)) = name_with_unit(reader, &text) else {
                scope.is_incomplete = true;
                continue;
            };
            scope.declare(reader, &name, place.clone(), Meaning::State(found.len()));
            found.push((
                State {
                    name,
                    unit,
                    init: Interval::ZERO,
                    domain: None,
                },
                None,
                place,
            ));
        }
    } else if let Some(table) = reader.table(section.value, section.place.clone(), help) {
        for entry in &table.entries {
            scope.declare(
                reader,
                entry.key,
                entry.place.clone(),
                Meaning::State(found.len()),
            );
            let mut state = State {
                name: entry.key.to_string(),
                unit: String::new(),
                init: Interval::ZERO,
                domain: None,
            };
            let help = "write { unit = \"rad\", init = [-0.1, 0.1] }";
            let table = reader.table(entry.value, entry.place.clone(), help);
            // What cannot be read was reported; a start box must not be asked for again.
            let mut init = Some(Interval::ZERO);
            if let Some(table) = table {
                reader.allow(&table, &["unit", "init", "domain"], "a state");
                state.unit = unit(reader, &table);
                state.domain = table
                    .value("domain")
                    .and_then(|value| constants::range(reader, value, "the domain"));
                init = table.value("init").map(|value| {
                    constants::range_or_point(reader, value, "the start box")
                        .unwrap_or(Interval::ZERO)
                });
            }
            found.push((state, init, entry.place.clone()));
        }
    } else {
        scope.is_incomplete = true;
    }
    if found.is_empty() && !scope.is_incomplete {
        reader.report(
            "E0109",
            "the model has no states",
            section.place.clone(),
            "declares no state",
            help,
        );
    }
    start_boxes(reader, file, found, scope.is_incomplete)
}

/// Completes the start boxes from the section [init].
fn start_boxes(
    reader: &mut Reader,
    file: &Table,
    mut found: Vec<(State, Option<Interval>, Range<usize>)>,
    is_incomplete: bool,
) -> Vec<State> {
    if let Some(section) = file.find("init")
        && let Some(table) = reader.table(
            section.value,
            section.place.clone(),
            "write [init] with lines like omega = 0.0",
        )
    {
        for entry in &table.entries {
            let init = constants::range_or_point(reader, entry.value, "the start box")
                .unwrap_or(Interval::ZERO);
            match found
                .iter_mut()
                .find(|(state, _, _)| state.name == entry.key)
            {
                Some((_, slot @ None, _)) => *slot = Some(init),
                Some(_) => reader.report(
                    "E0202",
                    format!("the start box of `{}` is given twice", entry.key),
                    entry.place.clone(),
                    "second start box",
                    "keep one of the two",
                ),
                None if is_incomplete => {}
                None => {
                    let known = found.iter().map(|(state, _, _)| state.name.as_str());
                    let help = match nearest(entry.key, known) {
                        Some(near) => format!("did you mean `{near}`?"),
                        None => "declare it in [states] or remove it".to_string(),
                    };
                    reader.report(
                        "E0201",
                        format!("`{}` is no state", entry.key),
                        entry.place.clone(),
                        "not in [states]",
                        help,
                    );
                }
            }
        }
    }
    let mut states = Vec::new();
    for (mut state, init, place) in found {
        match init {
            Some(init) => state.init = init,
            None => {
                let help = format!(
                    "write init = [lower, upper] for the state, or {} = [lower, upper] in [init]",
                    state.name
                );
                reader.report(
                    "E0207",
                    format!("the state `{}` has no start box", state.name),
                    place,
                    "where does it start?",
                    help,
                );
            }
        }
        states.push(state);
    }
    states
}

/// [inputs] as a table of tables or as a list of names; an input without an error is exact.
pub(crate) fn inputs(reader: &mut Reader, file: &Table, scope: &mut Scope) -> Vec<Input> {
    let Some(section) = file.find("inputs") else {
        return Vec::new();
    };
    let exact = || ErrorBound {
        absolute: Decimal::zero(),
        relative: Decimal::zero(),
    };
    let mut inputs: Vec<Input> = Vec::new();
    if let Some(items) = section.value.array() {
        for item in items {
            let text = reader.string(item, "write each input as \"name [unit]\"");
            let Some((name, place, unit)) = text.and_then(|text| name_with_unit(reader, &text))
            else {
                scope.is_incomplete = true;
                continue;
            };
            scope.declare(reader, &name, place, Meaning::Input(inputs.len()));
            inputs.push(Input {
                name,
                unit,
                column: None,
                error: exact(),
                domain: None,
                within: None,
                hold: Hold::Free,
            });
        }
        return inputs;
    }
    let help = "write [inputs] with lines like u = { unit = \"N*m\" }";
    let Some(table) = reader.table(section.value, section.place.clone(), help) else {
        scope.is_incomplete = true;
        return inputs;
    };
    for entry in &table.entries {
        scope.declare(
            reader,
            entry.key,
            entry.place.clone(),
            Meaning::Input(inputs.len()),
        );
        let mut input = Input {
            name: entry.key.to_string(),
            unit: String::new(),
            column: None,
            error: exact(),
            domain: None,
            within: None,
            hold: Hold::Free,
        };
        if let Some(table) = reader.table(entry.value, entry.place.clone(), help) {
            reader.allow(
                &table,
                &["unit", "hold", "error", "column", "domain"],
                "an input",
            );
            input.unit = unit(reader, &table);
            input.column = column(reader, &table);
            input.domain = table
                .value("domain")
                .and_then(|v| constants::range(reader, v, "the domain"));
            if let Some(value) = table.value("error") {
                if let Some(bound) = error_bound(reader, &table, value, &["hold"]) {
                    input.error = bound;
                }
                input.hold = error_hold(reader, value);
            }
            if let Some(value) = table.value("hold")
                && let Some(text) = reader.string(value, "write hold = \"zoh\"")
                && text.value != "zoh"
            {
                reader.report(
                    "E0107",
                    format!("there is no hold `{}`", text.value),
                    text.range,
                    "unknown",
                    "write hold = \"zoh\": the value holds until the next sample",
                );
            }
        }
        inputs.push(input);
    }
    inputs
}

/// [params]: a prior `[lo, hi]`, or a table with `bounds` or `fixed`.
pub(crate) fn params(reader: &mut Reader, file: &Table, scope: &mut Scope) -> Vec<ReadParam> {
    let Some(section) = file.find("params") else {
        return Vec::new();
    };
    let help = "write [params] with lines like alpha = [-6.0, -0.5]";
    let Some(table) = reader.table(section.value, section.place.clone(), help) else {
        scope.is_incomplete = true;
        return Vec::new();
    };
    let mut params = Vec::new();
    for entry in &table.entries {
        scope.declare(
            reader,
            entry.key,
            entry.place.clone(),
            Meaning::Param(params.len()),
        );
        let what = format!("the prior of `{}`", entry.key);
        let mut param = Param {
            name: entry.key.to_string(),
            unit: String::new(),
            bounds: Interval::ZERO,
            nominal: None,
        };
        let mut resets = None;
        if matches!(entry.value.value, DeValue::Table(_)) {
            if let Some(table) = reader.table(entry.value, entry.place.clone(), help) {
                reader.allow(
                    &table,
                    &["unit", "bounds", "nominal", "fixed", "resets"],
                    "a parameter",
                );
                param.unit = unit(reader, &table);
                param.bounds = prior(reader, &table, entry.key, &what).unwrap_or(Interval::ZERO);
                param.nominal = table
                    .value("nominal")
                    .and_then(|value| reader.decimal(value, "write nominal as a number"));
                resets = table.value("resets").and_then(|value| {
                    reader.string(value, "write the name of an event: resets = \"standstill\"")
                });
            }
        } else if entry.value.array().is_some() {
            param.bounds = constants::range(reader, entry.value, &what).unwrap_or(Interval::ZERO);
        } else {
            let help = format!(
                "write {0} = [lower, upper], or {0} = {{ fixed = 2.5 }} for a known value",
                entry.key
            );
            reader.expected("the prior of a parameter", entry.value, help);
        }
        params.push(ReadParam { param, resets });
    }
    params
}

fn prior(reader: &mut Reader, table: &Table, name: &str, what: &str) -> Option<Interval> {
    match (table.find("bounds"), table.find("fixed")) {
        (Some(bounds), None) => constants::range(reader, bounds.value, what),
        (None, Some(fixed)) => constants::point(reader, fixed.value, "write fixed = 2.5"),
        (None, None) => {
            reader.report(
                "E0109",
                format!("the parameter `{name}` has no prior"),
                table.place.clone(),
                "which values are possible?",
                "write bounds = [lower, upper], or fixed = 2.5 for a known value",
            );
            None
        }
        (Some(_), Some(fixed)) => {
            reader.report(
                "E0202",
                format!("the parameter `{name}` has `bounds` and is `fixed`"),
                fixed.place.clone(),
                "second prior",
                "keep one of the two",
            );
            None
        }
    }
}
