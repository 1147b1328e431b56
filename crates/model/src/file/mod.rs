//! From a model file to a [`Model`]: one pass that collects every problem before it gives up.

mod advice;
mod constants;
mod dimensions;
mod disturbances;
mod equations;
mod jumps;
mod lower;
mod measured;
mod modes;
mod quantities;
mod reader;
mod scope;
mod template;
mod terms;
mod text;

use crate::coverage::{self, Finding};
use crate::diagnostic::{Diagnostic, Diagnostics, SourceText};
use crate::file::lower::Lowering;
use crate::file::reader::{Reader, Table};
use crate::file::scope::Scope;
use crate::graph::ExprId;
use crate::model::{Coverage, Guard, Mode, ModeGroup, Model, State};
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;
use std::sync::Arc;
use toml::de::{DeTable, DeValue};

pub use modes::MOST_MODES;

/// Longer files are no models written by hand.
pub(crate) const LARGEST_FILE: usize = 1 << 18;
/// More entries in one section are a mistake.
const MOST_ENTRIES: usize = 1000;

const SECTIONS: [&str; 15] = [
    "format",
    "name",
    "sizes",
    "states",
    "init",
    "inputs",
    "disturbances",
    "params",
    "let",
    "modes",
    "der",
    "jumps",
    "outputs",
    "signals",
    "events",
];

impl Model {
    /// Reads a model file (TOML with equations in strings).
    ///
    /// # Errors
    /// Everything that is wrong in the file, each with its place.
    pub fn from_file(path: impl AsRef<Path>) -> Result<Model, Diagnostics> {
        let path = path.as_ref();
        let name = path.display().to_string();
        let bytes = read(path).map_err(|problem| {
            let message = format!("cannot read `{name}`: {problem}");
            Diagnostics::from(
                Diagnostic::new("E0101", message).help("check the path of the model file"),
            )
        })?;
        match String::from_utf8(bytes) {
            Ok(text) => Model::from_text(&name, text),
            Err(error) => {
                let at = error.utf8_error().valid_up_to();
                let message = format!("`{name}` is not a text file: byte {at} is not UTF-8");
                Err(Diagnostic::new("E0102", message)
                    .help("give a model file, saved as UTF-8 text")
                    .into())
            }
        }
    }

    /// Reads a model from the text of a model file; `name` is what messages call the file.
    ///
    /// # Errors
    /// Everything that is wrong in the text, each with its place.
    pub fn from_text(name: &str, text: impl Into<String>) -> Result<Model, Diagnostics> {
        let source = Arc::new(SourceText::new(name, text));
        let mut reader = Reader::new(Arc::clone(&source));
        let model = document(&mut reader, &source);
        let mut problems = reader.origin.restore(reader.problems, &source);
        match model {
            Some(model) if problems.is_empty() => Ok(model),
            _ => {
                problems.sort_by_key(|problem| {
                    problem.place.as_ref().map_or(0, |(_, range)| range.start)
                });
                Err(Diagnostics(problems))
            }
        }
    }
}

/// The bytes of a file of sensible size.
fn read(path: &Path) -> Result<Vec<u8>, String> {
    let says = |error: std::io::Error| match error.kind() {
        ErrorKind::NotFound => "there is no such file".to_string(),
        ErrorKind::PermissionDenied => "there is no permission to read it".to_string(),
        ErrorKind::IsADirectory => "it is a folder".to_string(),
        _ => error.to_string(),
    };
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(says)?;
    file.take(LARGEST_FILE as u64 + 1)
        .read_to_end(&mut bytes)
        .map_err(says)?;
    if bytes.len() > LARGEST_FILE {
        return Err(format!(
            "it is longer than {LARGEST_FILE} bytes and cannot be a model"
        ));
    }
    Ok(bytes)
}

/// Reads the TOML and, if that can be read, what it means.
fn document(reader: &mut Reader, source: &Arc<SourceText>) -> Option<Model> {
    if source.text.trim().is_empty() {
        reader.problems.push(
            Diagnostic::new("E0104", format!("`{}` is empty", source.name))
                .help("begin with format = 1, then write [states], [der] and [outputs]"),
        );
        return None;
    }
    if source.text.len() > LARGEST_FILE {
        let message = format!("`{}` is longer than {LARGEST_FILE} bytes", source.name);
        reader
            .problems
            .push(Diagnostic::new("E0113", message).help("give a model file"));
        return None;
    }
    let (table, errors) = DeTable::parse_recoverable(&source.text);
    for error in &errors {
        let is_duplicate = error.message().contains("duplicate key");
        let is_record = Path::new(&source.name)
            .extension()
            .is_some_and(|end| end.eq_ignore_ascii_case("csv"));
        let help = if is_record {
            "this looks like a record; give the model first, then the record"
        } else if is_duplicate {
            "keep one of the two"
        } else if error.message().contains("table") || error.message().contains("comma") {
            "correct the TOML here: a comma, `}` or `]` is missing here or above"
        } else {
            "correct the TOML here: key = value lines below [section] headers, text in quotes"
        };
        reader.report(
            "E0103",
            format!("the file is not valid TOML: {}", error.message()),
            error.span().unwrap_or(0..0),
            "here",
            help,
        );
        // What follows a missing quote or bracket is mostly its echo.
        if !is_duplicate {
            break;
        }
    }
    if !errors.is_empty() {
        return None;
    }
    let expanded = template::expand(reader, table.get_ref())?;
    let end = source.text.len();
    let file = Table::new(&reader.origin, &expanded, end..end);
    let mut model = model(reader, &file)?;
    model.source = Arc::clone(source);
    Some(model)
}

fn model(reader: &mut Reader, file: &Table) -> Option<Model> {
    reader.allow(file, &SECTIONS, "a model");
    if !is_of_sensible_size(reader, file) {
        return None;
    }
    format(reader, file);
    let name = name(reader, file);

    // [1/4] Declarations: after these every name is known.
    let mut scope = Scope::default();
    template::declare_sizes(reader, file, &mut scope);
    let states = quantities::states(reader, file, &mut scope);
    let mut inputs = quantities::inputs(reader, file, &mut scope);
    disturbances::disturbances(reader, file, &mut scope, &mut inputs);
    let params = quantities::params(reader, file, &mut scope);
    let definitions = equations::definitions(reader, file, &mut scope);
    let outputs = measured::outputs(reader, file, &mut scope);
    let signals = measured::signals(reader, file, &mut scope);
    let resets = measured::events(reader, file, &signals, &params);
    let written = equations::modes(reader, file, &states);
    let jumps = jumps::jumps(reader, file, &states);

    // [2/4] Equations into the graph.
    let mut lowering = Lowering::new(&scope, params.len(), definitions.len());
    let order = equations::define(reader, &scope, &mut lowering, &definitions);
    let has_guards = file.find("modes").is_some();
    let lowered: Vec<Option<(Guard, Vec<_>)>> = written
        .iter()
        .map(|mode| equations::lower_mode(reader, &mut lowering, mode, has_guards))
        .collect();
    let units = dimensions::Written {
        scope: &scope,
        states: &states,
        inputs: &inputs,
        params: &params,
        definitions: &definitions,
        order: &order,
        modes: &written,
        jumps: &jumps,
        outputs: &outputs,
        signals: &signals,
    };
    let mut notes = dimensions::check(reader, &units);
    notes.extend(advice::advise(&units));
    let (jumps, flows) = jumps::lower(reader, &mut lowering, jumps);
    let outputs = measured::lower_outputs(reader, &mut lowering, outputs, &states);
    let signals = measured::lower_signals(reader, &mut lowering, signals, resets);
    let lowered: Vec<(Guard, Vec<_>)> = lowered.into_iter().collect::<Option<_>>()?;

    // [3/4] Set-valued functions into modes.
    let (modes, groups) = expanded(
        reader,
        &mut lowering,
        &written,
        &lowered,
        &states,
        &mut notes,
    )?;
    let terms = terms::of(&reader.source, &mut lowering, &written);
    let graph = lowering.graph;
    if !reader.problems.is_empty() {
        return None;
    }

    // [4/4] The guards of the written modes, and the conditions of jumps, must leave no gap; branches
    // of set-valued functions leave none by construction.
    let mut model = Model {
        name,
        graph,
        states,
        inputs,
        params: params.into_iter().map(|read| read.param).collect(),
        modes,
        groups,
        jumps,
        flows,
        outputs,
        signals,
        terms,
        coverage: Coverage::Everywhere,
        notes,
        source: Arc::clone(&reader.source),
    };
    let jumps = model.jumps.iter().map(|jump| jump.guard.clone());
    let guards = lowered.into_iter().map(|(guard, _)| guard).chain(jumps);
    let guards: Vec<Guard> = guards.collect();
    match coverage::examine(&model, &guards) {
        Finding::Covered(coverage) => model.coverage = coverage,
        Finding::Gap(gap) => {
            let place = file.find("modes").map_or(0..0, |entry| entry.place.clone());
            reader.report(
                "E0213",
                format!("the modes leave a gap: {gap}"),
                place,
                "no guard holds there",
                "add a mode or widen a guard, for instance with `<=` or `>=`; \
                 domain = [lower, upper] of a state or input says which values are possible",
            );
            return None;
        }
    }
    Some(model)
}

/// The modes that the written ones stand for, and which states they govern. Written modes govern all
/// states together; [der] is divided into the groups that switch together.
fn expanded(
    reader: &mut Reader,
    lowering: &mut Lowering,
    written: &[equations::WrittenMode],
    lowered: &[(Guard, Vec<ExprId>)],
    states: &[State],
    notes: &mut Vec<String>,
) -> Option<(Vec<Mode>, Vec<ModeGroup>)> {
    let divided = match (written, lowered) {
        ([mode], [(_, der)]) if mode.name.is_empty() => modes::groups(lowering, der),
        _ => vec![(0..states.len()).collect()],
    };
    let mut all: Vec<Mode> = Vec::new();
    let mut groups = Vec::new();
    for group in &divided {
        let first = all.len();
        for (mode, (guard, der)) in written.iter().zip(lowered) {
            let more = modes::expand(lowering, (&mode.name, guard, der), group, notes);
            let count = more
                .as_ref()
                .map_or_else(|count| *count, Vec::len)
                .saturating_add(all.len());
            match more {
                Ok(more) if count <= modes::MOST_MODES => all.extend(more),
                _ => {
                    reader.report(
                        "E0217",
                        format!("the model has too many modes: {count}"),
                        mode.place.clone(),
                        "its sign and friction calls multiply",
                        format!(
                            "stay below {} modes: use fewer sign and friction calls",
                            modes::MOST_MODES
                        ),
                    );
                    return None;
                }
            }
        }
        groups.push(ModeGroup {
            states: group.clone(),
            modes: first..all.len(),
        });
    }
    if groups.len() > 1 {
        name_by_group(&mut all, &groups, states);
    }
    Some((all, groups))
}

/// Modes of several groups are told apart by the first state of theirs.
fn name_by_group(modes: &mut [Mode], groups: &[ModeGroup], states: &[State]) {
    for group in groups {
        let state = group.states.first().and_then(|state| states.get(*state));
        let own = modes.get_mut(group.modes.clone()).unwrap_or_default();
        if let (Some(state), [_, _, ..]) = (state, &*own) {
            for mode in own {
                mode.name = format!("{}:{}", state.name, mode.name);
            }
        }
    }
}

fn is_of_sensible_size(reader: &mut Reader, file: &Table) -> bool {
    let count = reader.problems.len();
    for section in &file.entries {
        let entries = match section.value.value {
            DeValue::Table(table) => table.len(),
            DeValue::Array(array) => array.len(),
            _ => 0,
        };
        if entries > MOST_ENTRIES {
            reader.report(
                "E0113",
                format!("[{}] has {entries} entries", section.key),
                section.place.clone(),
                format!("more than {MOST_ENTRIES}"),
                "make the model smaller",
            );
        }
    }
    reader.problems.len() == count
}

fn format(reader: &mut Reader, file: &Table) {
    let help = "write format = 1 in the first line";
    match file.value("format") {
        None => reader.report(
            "E0105",
            "the file does not say its format",
            0..0,
            "no `format`",
            help,
        ),
        Some(value) => {
            let one =
                matches!(value.value, DeValue::Integer(n) if n.as_str() == "1" && n.radix() == 10);
            if !one {
                let message = "this format of model files is not known";
                reader.report("E0105", message, value.place(), "only 1 is known", help);
            }
        }
    }
}

/// The name from the file, or the stem of the file's own name.
fn name(reader: &mut Reader, file: &Table) -> String {
    if let Some(value) = file.value("name")
        && let Some(text) = reader.string(value, "write the name as a string")
        && !text.value.trim().is_empty()
    {
        return text.value;
    }
    let stem = Path::new(&reader.source.name).file_stem();
    stem.map_or_else(
        || "model".to_string(),
        |stem| stem.to_string_lossy().into_owned(),
    )
}
