//! The sections [let], [der] and [modes].

use crate::diagnostic::nearest;
use crate::file::lower::Lowering;
use crate::file::reader::{Reader, Table, Value};
use crate::file::scope::{Equation, Meaning, Scope};
use crate::model::{Guard, State};
use std::ops::Range;

/// A named intermediate result; without an equation when that could not be read.
pub(crate) struct Definition {
    pub name: String,
    place: Range<usize>,
    pub equation: Option<Equation>,
}

/// A mode as the file says it: set-valued functions are not expanded yet.
pub(crate) struct WrittenMode {
    /// Empty for the one mode that [der] stands for.
    pub name: String,
    pub place: Range<usize>,
    pub guard: Option<Equation>,
    /// By state.
    pub der: Vec<Option<Equation>>,
}

pub(crate) fn equation(reader: &mut Reader, value: Value, help: &str) -> Option<Equation> {
    use toml::de::DeValue;
    let text = match value.value {
        // A plain number is an equation too.
        DeValue::Integer(_) | DeValue::Float(_) => {
            let decimal = reader.decimal(value, help)?;
            crate::file::text::Text::new(&reader.source.text, value.place(), &decimal.to_string())
        }
        _ => reader.string(value, help)?,
    };
    let ast = reader.expression(&text)?;
    Some(Equation { text, ast })
}

/// [let]: names are declared in any order, equations are kept for [`define`].
pub(crate) fn definitions(reader: &mut Reader, file: &Table, scope: &mut Scope) -> Vec<Definition> {
    let Some(section) = file.find("let") else {
        return Vec::new();
    };
    let help = "write [let] with lines like drive = \"beta*u\"";
    let Some(table) = reader.table(section.value, section.place.clone(), help) else {
        scope.is_incomplete = true;
        return Vec::new();
    };
    let mut found = Vec::new();
    for entry in &table.entries {
        scope.declare(
            reader,
            entry.key,
            entry.place.clone(),
            Meaning::Let(found.len()),
        );
        found.push(Definition {
            name: entry.key.to_string(),
            place: entry.place.clone(),
            equation: equation(reader, entry.value, "write an expression as a string"),
        });
    }
    found
}

/// Puts every [let] into the graph, in the order in which they need each other; gives that order.
pub(crate) fn define(
    reader: &mut Reader,
    scope: &Scope,
    lowering: &mut Lowering,
    definitions: &[Definition],
) -> Vec<usize> {
    let needs: Vec<Vec<usize>> = definitions
        .iter()
        .map(|definition| {
            let names = definition
                .equation
                .iter()
                .flat_map(|equation| equation.ast.names());
            names
                .filter_map(|(name, _)| match scope.find(name) {
                    Some(Meaning::Let(i)) => Some(i),
                    _ => None,
                })
                .collect()
        })
        .collect();
    let mut is_done = vec![false; definitions.len()];
    let mut open: Vec<usize> = (0..definitions.len()).collect();
    let mut order = Vec::new();
    loop {
        let is_ready = |i: &usize| {
            let needed = needs.get(*i).into_iter().flatten();
            needed
                .into_iter()
                .all(|need| is_done.get(*need) == Some(&true))
        };
        let (ready, rest): (Vec<usize>, Vec<usize>) = open.iter().partition(|i| is_ready(i));
        open = rest;
        if ready.is_empty() {
            break;
        }
        for index in ready {
            order.push(index);
            if let Some(done) = is_done.get_mut(index) {
                *done = true;
            }
            let Some(equation) = definitions.get(index).and_then(|d| d.equation.as_ref()) else {
                continue;
            };
            match lowering.right_hand_side(equation) {
                Ok(e) => {
                    if let Some(slot) = lowering.lets.get_mut(index) {
                        *slot = Some(e);
                    }
                }
                Err(problems) => report_all(reader, equation, problems),
            }
        }
    }
    report_cycles(reader, definitions, &needs, &open);
    order
}

/// Reports each circle among the definitions that wait for each other for ever.
fn report_cycles(
    reader: &mut Reader,
    definitions: &[Definition],
    needs: &[Vec<usize>],
    open: &[usize],
) {
    let mut told: Vec<usize> = Vec::new();
    for &start in open {
        let mut path = vec![start];
        while let Some(next) = path
            .last()
            .and_then(|at| needs.get(*at))
            .and_then(|n| n.iter().find(|need| open.contains(need)).copied())
        {
            if told.contains(&next) {
                break;
            }
            if let Some(first) = path.iter().position(|seen| *seen == next) {
                let circle = path.split_off(first);
                told.extend(&circle);
                let mut names: Vec<&str> = circle
                    .iter()
                    .chain([&next])
                    .filter_map(|i| definitions.get(*i).map(|d| d.name.as_str()))
                    .collect();
                names.dedup();
                if let Some(definition) = definitions.get(next) {
                    reader.report(
                        "E0206",
                        format!("`{}` is defined by itself", definition.name),
                        definition.place.clone(),
                        if circle.len() == 1 {
                            "needs itself".to_string()
                        } else {
                            format!("a circle: {}", names.join(" needs "))
                        },
                        "break the circle; a dynamic quantity is a state with its own equation in [der]",
                    );
                }
                break;
            }
            path.push(next);
        }
        told.extend(path);
    }
}

/// [modes] or [der], exactly one of them.
pub(crate) fn modes(reader: &mut Reader, file: &Table, states: &[State]) -> Vec<WrittenMode> {
    let der_help = "write [der] with one line for each state, as in phi = \"omega\"";
    match (file.find("der"), file.find("modes")) {
        (Some(der), None) => {
            let Some(table) = reader.table(der.value, der.place.clone(), der_help) else {
                return Vec::new();
            };
            let der_equations = derivatives(reader, &table, states, "[der]");
            vec![WrittenMode {
                name: String::new(),
                place: der.place.clone(),
                guard: None,
                der: der_equations,
            }]
        }
        (None, Some(modes)) => {
            let help = "write [modes] with lines like slide = { when = \"...\", der = { ... } }";
            let Some(table) = reader.table(modes.value, modes.place.clone(), help) else {
                return Vec::new();
            };
            if table.entries.is_empty() {
                let place = modes.place.clone();
                reader.report(
                    "E0109",
                    "the model has no modes",
                    place,
                    "declares no mode",
                    help,
                );
            }
            table
                .entries
                .iter()
                .filter_map(|entry| mode(reader, entry.key, entry, states))
                .collect()
        }
        (None, None) => {
            reader.report(
                "E0210",
                "the model has no equations",
                0..0,
                "neither [der] nor [modes] in this file",
                der_help,
            );
            Vec::new()
        }
        (Some(der), Some(modes)) => {
            let second = if der.place.start > modes.place.start {
                der
            } else {
                modes
            };
            reader.report(
                "E0210",
                "the model has both [der] and [modes]",
                second.place.clone(),
                "second set of equations",
                "keep [der] for one smooth law, or move its equations into each mode",
            );
            Vec::new()
        }
    }
}

fn mode(
    reader: &mut Reader,
    name: &str,
    entry: &crate::file::reader::Entry,
    states: &[State],
) -> Option<WrittenMode> {
    let help = "write { when = \"omega > 0\", der = { phi = \"omega\" } }";
    let table = reader.table(entry.value, entry.place.clone(), help)?;
    reader.allow(&table, &["when", "der"], "a mode");
    let guard = match table.value("when") {
        Some(value) => equation(reader, value, "write the condition as a string"),
        None => {
            reader.report(
                "E0211",
                format!("the mode `{name}` has no guard"),
                entry.place.clone(),
                "when is it active?",
                "write when = \"omega > 0\"",
            );
            None
        }
    };
    let what = format!("the mode `{name}`");
    let der = match table.find("der") {
        Some(der) => {
            let inner = reader.table(der.value, der.place.clone(), help)?;
            derivatives(reader, &inner, states, &what)
        }
        None => {
            reader.report(
                "E0208",
                format!("{what} has no equations"),
                entry.place.clone(),
                "`der` is missing",
                help,
            );
            Vec::new()
        }
    };
    Some(WrittenMode {
        name: name.to_string(),
        place: entry.place.clone(),
        guard,
        der,
    })
}

fn derivatives(
    reader: &mut Reader,
    table: &Table,
    states: &[State],
    what: &str,
) -> Vec<Option<Equation>> {
    for entry in &table.entries {
        if states.iter().any(|state| state.name == entry.key) {
            continue;
        }
        let help = match nearest(entry.key, states.iter().map(|state| state.name.as_str())) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "declare it in [states], or use [let] for an intermediate result".to_string(),
        };
        reader.report(
            "E0209",
            format!("`{}` is no state and has no derivative", entry.key),
            entry.place.clone(),
            "not in [states]",
            help,
        );
    }
    let mut found = Vec::new();
    for state in states {
        let Some(entry) = table.find(&state.name) else {
            reader.report(
                "E0208",
                format!("{what} has no equation for the state `{}`", state.name),
                table.place.clone(),
                format!("no line `{} = ...`", state.name),
                format!(
                    "write {} = \"...\" with its derivative, \"0\" if it is constant",
                    state.name
                ),
            );
            found.push(None);
            continue;
        };
        found.push(equation(
            reader,
            entry.value,
            "write the derivative as a string",
        ));
    }
    found
}

/// Guard and right-hand side in the graph; `None` when something was reported.
pub(crate) fn lower_mode(
    reader: &mut Reader,
    lowering: &mut Lowering,
    mode: &WrittenMode,
    has_guard: bool,
) -> Option<(Guard, Vec<crate::graph::ExprId>)> {
    let guard = match &mode.guard {
        Some(equation) => match lowering.guard(equation) {
            Ok(guard) => Some(guard),
            Err(problems) => {
                report_all(reader, equation, problems);
                None
            }
        },
        None => (!has_guard).then_some(Guard::Always),
    };
    let mut der = Vec::new();
    for equation in &mode.der {
        der.push(
            equation
                .as_ref()
                .and_then(|equation| match lowering.right_hand_side(equation) {
                    Ok(e) => Some(e),
                    Err(problems) => {
                        report_all(reader, equation, problems);
                        None
                    }
                }),
        );
    }
    Some((guard?, der.into_iter().collect::<Option<_>>()?))
}

/// Reports problems found in an equation.
pub(crate) fn report_all(
    reader: &mut Reader,
    equation: &Equation,
    problems: Vec<crate::syntax::Problem>,
) {
    for problem in problems {
        reader.report_in(&equation.text, problem);
    }
}
