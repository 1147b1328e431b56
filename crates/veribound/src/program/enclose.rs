//! `veribound enclose`: bounds of all solutions of a model, without a record.

use super::arguments::Enclose;
use super::ending::Ending;
use super::message::{remark, say};
use super::profile::{Profile, Stretch};
use super::{Outcome, numbers, overwriting};
use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;
use veribound_data::{Cell, Column, ResultFolder, TableWriter};
use veribound_flow::form::{self, Diverged, Effort, Enclosure, Flow, FormOptions, Obstacle};
use veribound_interval::{Decimal, Interval};
use veribound_model::Model;
use veribound_model::diagnostic::Diagnostic;

/// Encloses, and writes as much of the table as is proved.
pub fn run(arguments: &Enclose) -> Outcome {
    let mut files = vec![("the model file", arguments.model.as_path())];
    let profile = arguments.times.input.as_deref();
    files.extend(profile.map(|path| ("the profile", path)));
    overwriting::refuse_record(&arguments.output, &files)?;
    let model = Model::from_file(&arguments.model)?;
    let flow = Flow::new(&model);
    let (times, stretches) = stretches(arguments, &model)?;
    let folder = arguments.output.parent();
    let folder = folder.filter(|path| !path.as_os_str().is_empty());
    let folder = ResultFolder::create(folder.unwrap_or(Path::new(".")))?;
    let start: Vec<Interval> = model.states.iter().map(|state| state.init).collect();
    let params: Vec<Interval> = model.params.iter().map(|param| param.bounds).collect();
    let effort = Effort {
        parts: arguments.parts,
        ..Effort::default()
    };
    let begin = Instant::now();
    let options = FormOptions::default();
    let enclosure = flow.enclose(&start, &params, &stretches, options, effort);
    let seconds = begin.elapsed().as_secs_f64();
    let proved = times.len().min(enclosure.ends.len() + 1);
    let times = times.get(..proved).unwrap_or(&times);
    if proved > 1 {
        write(arguments, &folder, &model, times, &start, &enclosure)?;
        say(&table(&model, times, &enclosure, seconds));
    }
    match &enclosure.stopped {
        None => Ok(Ending::Done),
        Some(diverged) => {
            remark(&why(&model, diverged, times));
            Ok(Ending::Undecided)
        }
    }
}

/// The times of the rows, and what holds between them.
fn stretches(
    arguments: &Enclose,
    model: &Model,
) -> Result<(Vec<Decimal>, Vec<form::Stretch>), veribound_model::Diagnostics> {
    let mut profile = Profile::open(&arguments.times, model)?;
    let mut times = Vec::new();
    let mut stretches = Vec::new();
    while let Some(Stretch {
        time,
        inputs,
        to_next,
        ..
    }) = profile.next()?
    {
        let recorded = model.recorded_inputs().zip(inputs);
        let mut inputs: Vec<Interval> = recorded
            .map(|(input, value)| input.error.enclose(value))
            .collect();
        inputs.extend(model.disturbances().map(|(_, bounds)| bounds));
        times.push(time);
        if let Some(dt) = to_next {
            stretches.push(form::Stretch {
                inputs,
                dt: dt.to_interval(),
            });
        }
    }
    Ok((times, stretches))
}

/// One row per time: the states then, and since the time before.
fn write(
    arguments: &Enclose,
    folder: &ResultFolder,
    model: &Model,
    times: &[Decimal],
    start: &[Interval],
    enclosure: &Enclosure,
) -> Result<(), Diagnostic> {
    let name = arguments.output.file_name().unwrap_or_default();
    let names = model.states.iter().map(|state| state.name.clone());
    let since = names.clone().map(|name| format!("{name}.since"));
    let columns = names.chain(since).map(Column::Bounds).collect();
    let mut table = TableWriter::create(folder, &name.to_string_lossy(), columns)?;
    let start = start.to_vec();
    let ends = std::iter::once(&start).chain(&enclosure.ends);
    let tubes = std::iter::once(&start).chain(&enclosure.tubes);
    for ((time, end), tube) in times.iter().zip(ends).zip(tubes) {
        let cells: Vec<Cell<'_>> = end.iter().chain(tube).map(|x| Cell::Bounds(*x)).collect();
        table.row(time, &cells)?;
    }
    table.finish()?.put_in_place()
}

/// The states at the end.
fn table(model: &Model, times: &[Decimal], enclosure: &Enclosure, seconds: f64) -> String {
    let mut text = String::new();
    let time = times.last().map_or_else(String::new, Decimal::to_string);
    let parts = match enclosure.parts.len() {
        1 => String::new(),
        parts => format!(", divided into {parts} parts"),
    };
    // Writing to a String cannot fail.
    let _ = writeln!(text, "  proved to {time} s   {seconds:.2} s of work{parts}");
    let longest = model.states.iter().map(|state| state.name.chars().count());
    let longest = longest.max().unwrap_or(0);
    let last = enclosure.ends.last().into_iter().flatten();
    for (state, bounds) in model.states.iter().zip(last) {
        let bounds = numbers::show(*bounds);
        let line = format!("  {:longest$}   {bounds}   {}", state.name, state.unit);
        let _ = writeln!(text, "{}", line.trim_end());
    }
    text
}

/// What stood in the way, where and when.
fn why(model: &Model, diverged: &Diverged, times: &[Decimal]) -> String {
    let state = model.states.get(diverged.state);
    let state = state.map_or("", |state| state.name.as_str());
    let reason = match diverged.obstacle {
        Obstacle::TooLong => "the set grows too fast for any step",
        Obstacle::Undefined => "a function may be undefined, or not smooth, on the set",
        Obstacle::Jump => "the right-hand side may jump on the set",
        Obstacle::Unbounded => "numbers became too large",
        Obstacle::Interrupted => "the run was interrupted",
        Obstacle::NotMonotone => "the right-hand side is not proved to be monotone",
        Obstacle::LeavesDomain => {
            "the set, or an input, may leave the domain in which the guards are proved to leave no gap"
        }
    };
    let kept = match times {
        [_, .., last] => format!("The table ends at {last} s."),
        _ => "Nothing is written.".to_string(),
    };
    format!(
        "undecided after {:.6} s: {reason}; the width of `{state}` grew most. {kept} Try narrower start boxes or \
         parameters, a shorter time, or more `--parts`.",
        diverged.reached.lo(),
    )
}
