//! What the user is told of an enclosure.

use super::super::ending::Ending;
use super::super::message::{list, remark};
use super::super::numbers::{show, show_prior};
use super::super::table::push_rows;
use super::diagnosis::Cause;
use super::{Findings, trajectories};
use std::fmt::Write as _;
use std::path::Path;
use veribound_data::{EnclosureSummary, EnclosureWork, PastUse, RangeSummary, Reach, Time};
use veribound_flow::form::Obstacle;
use veribound_interval::{Decimal, Interval};
use veribound_model::Model;

/// The content of `summary.json`.
pub fn summary(
    model: &Model,
    times: &[Decimal],
    found: &Findings,
    assumptions: Vec<String>,
) -> EnclosureSummary {
    let [states, outputs] = found.ranges();
    let states = model
        .states
        .iter()
        .zip(states)
        .map(|(state, (end, always))| {
            (
                state.name.clone(),
                RangeSummary::new(&state.unit, end, always),
            )
        });
    let outputs = model
        .outputs
        .iter()
        .zip(outputs)
        .map(|(output, (end, always))| {
            (
                output.name.clone(),
                RangeSummary::new(&output.unit, end, always),
            )
        });
    let zero = Decimal::zero();
    let past_use = found.past_use.iter().filter_map(|past| {
        Some(PastUse {
            state: model.states.get(past.cause.state)?.name.clone(),
            since: Time::new(&past.since),
            term: past.cause.term.as_ref().map(|term| term.0.clone()),
            line: past.cause.term.as_ref().map(|term| term.1),
            remedy: past.cause.remedy.clone(),
        })
    });
    EnclosureSummary {
        verdict: match found.ending {
            Ending::Done => Reach::Proved,
            _ => Reach::Undecided,
        },
        reason: reason(model, found),
        until: Time::new(times.last().unwrap_or(&zero)),
        times: times.len(),
        states: states.collect(),
        outputs: outputs.collect(),
        modes: found.last_modes(model),
        engine: found.engine.clone(),
        parts: found.enclosure.parts.len(),
        trajectories: found.asked.then(|| trajectories::counted(&found.drawn)),
        past_use: past_use.collect(),
        work: EnclosureWork {
            wall_s: found.seconds,
            steps: found.enclosure.steps,
        },
        interrupted: found.ending == Ending::Interrupted,
        assumptions,
    }
}

/// What stood in the way, in one sentence.
pub fn reason(model: &Model, found: &Findings) -> Option<String> {
    let stopped = found.enclosure.stopped.as_ref()?;
    let cause = found.obstacle.as_ref()?;
    let state = model
        .states
        .get(cause.state)
        .map_or("", |state| &state.name);
    let what = match stopped.obstacle {
        Obstacle::TooLong => "the set grows too fast for any step",
        Obstacle::Undefined => "a function may be undefined, or not smooth, on the set",
        Obstacle::Jump => "the right-hand side may jump on the set",
        Obstacle::Unbounded => "numbers became too large",
        Obstacle::NotAffine => {
            return Some(format!(
                "there is no closed form, since the rate of `{state}` is not affine in the states"
            ));
        }
        Obstacle::NotMonotone => "the right-hand side is not proved to be monotone",
        Obstacle::Costly => "bounds were given up that take many times the work of forms",
        Obstacle::Interrupted => return Some("the run was interrupted".to_owned()),
        Obstacle::LeavesDomain => {
            return Some(
                "the set, or an input, may leave the domain in which the guards are proved to leave no gap"
                    .to_owned(),
            );
        }
    };
    let term = term(model, cause);
    Some(format!("{what}; the width of `{state}` grew most{term}"))
}

/// The term that made a width grow, in a sentence.
fn term(model: &Model, cause: &Cause) -> String {
    cause.term.as_ref().map_or(String::new(), |(text, line)| {
        format!(", by the term `{text}` ({}:{line})", model.source.name)
    })
}

/// Tells on stderr why the run ended early, and which widths are past use.
pub fn explain(model: &Model, times: &[Decimal], found: &Findings) {
    let remarks = remarks(model, times, found);
    remarks.iter().for_each(|told| remark(told));
}

/// Why the run ended early, and which widths are past use.
pub fn remarks(model: &Model, times: &[Decimal], found: &Findings) -> Vec<String> {
    let mut said = Vec::new();
    let kept = match times {
        [_, .., last] => format!("The results end at t = {last} s."),
        _ => "Nothing is proved beyond the start.".to_owned(),
    };
    match found.ending {
        Ending::Interrupted => said.push(format!("interrupted. {kept}")),
        Ending::Undecided => {
            let reached = found.enclosure.stopped.as_ref();
            let reached = reached.map_or(0.0, |stopped| stopped.reached.lo());
            let reason = reason(model, found).unwrap_or_default();
            let remedy = found.obstacle.as_ref().map_or("", |cause| &cause.remedy);
            said.push(format!(
                "undecided after {reached:.6} s: {reason}. {kept} Try {remedy}."
            ));
        }
        _ => {}
    }
    said.extend(past_use(model, found).map(|told| format!("warning: {told}")));
    said
}

/// Which widths grew past use, and what to try.
pub fn past_use(model: &Model, found: &Findings) -> Option<String> {
    let mut earliest: Vec<_> = found.past_use.iter().collect();
    let name = |state: usize| {
        let state = model.states.get(state);
        state.map_or("", |state| state.name.as_str())
    };
    // A state that only follows another one comes after it; then one whose term has others in it and not itself.
    let follows = |cause: &Cause| {
        let Some((term, _)) = cause.term.as_ref() else {
            return (false, false);
        };
        let mut others = found.past_use.iter().map(|other| name(other.cause.state));
        let is_another = others.clone().any(|name| name == term);
        let has = |name: &str| words(term).any(|word| word == name);
        (is_another, others.any(has) && !has(name(cause.state)))
    };
    earliest.sort_by(|a, b| a.since.cmp(&b.since));
    earliest.sort_by_key(|past| follows(&past.cause));
    let first = earliest.first()?;
    let others: Vec<&str> = earliest
        .iter()
        .skip(1)
        .map(|past| name(past.cause.state))
        .collect();
    let others = if others.is_empty() {
        String::new()
    } else {
        format!("; then those of {}", list(others))
    };
    Some(format!(
        "the width of `{}` grew past use from t = {} s on{}{others}. Try {}.",
        name(first.cause.state),
        first.since,
        term(model, &first.cause),
        first.cause.remedy
    ))
}

/// Names and numbers in a term.
fn words(term: &str) -> impl Iterator<Item = &str> {
    term.split(|c: char| !(c.is_alphanumeric() || c == '_'))
}

/// Verdict, work, and one line per state and output.
pub fn bounds(
    model: &Model,
    times: &[Decimal],
    (found, summary): (&Findings, &EnclosureSummary),
) -> String {
    let mut out = String::new();
    let time = times.last().map_or_else(String::new, Decimal::to_string);
    let verdict = match found.ending {
        Ending::Done => "proved",
        Ending::Interrupted => "interrupted, proved",
        _ => "proved only",
    };
    let parts = match summary.parts {
        0 | 1 => String::new(),
        parts => format!("   divided into {parts} parts"),
    };
    // Writing to a String cannot fail.
    let _ = writeln!(
        out,
        "  {verdict} to {time} s   {} times in {:.2} s{parts}",
        times.len(),
        found.seconds
    );
    let _ = writeln!(out, "  engine: {}", found.engine);
    let [states, outputs] = found.ranges();
    let at = format!("at {time} s");
    let mut rows = vec![["", "start", &at, "at all times", ""].map(str::to_owned)];
    let mut push = |name: &str, unit: &str, start: String, (end, always): (Interval, Interval)| {
        rows.push([
            name.to_owned(),
            start,
            show(end),
            show(always),
            unit.to_owned(),
        ]);
    };
    for (state, bounds) in model.states.iter().zip(states) {
        push(&state.name, &state.unit, show_prior(state.init), bounds);
    }
    for (output, bounds) in model.outputs.iter().zip(outputs) {
        push(&output.name, &output.unit, String::new(), bounds);
    }
    push_rows(&mut out, &rows);
    if model.modes.len() > 1 && !summary.modes.is_empty() {
        let modes = summary.modes.join(", ");
        let _ = writeln!(out, "  modes possible at the end: {modes}");
    }
    if let Some(counts) = summary.trajectories {
        let _ = write!(
            out,
            "  {} of {} true trajectories proved inside",
            counts.inside, counts.drawn
        );
        let lost = counts.drawn - counts.followed;
        let lost = match lost {
            0 => String::new(),
            lost => format!(", {lost} not followed to the end"),
        };
        let _ = writeln!(
            out,
            "{lost}, none outside ({} comparisons)",
            counts.comparisons
        );
    }
    out
}

/// The same, and where the results are.
pub fn table(
    model: &Model,
    times: &[Decimal],
    both: (&Findings, &EnclosureSummary),
    (folder, pictures): (&Path, String),
) -> String {
    let mut out = bounds(model, times, both);
    // Writing to a String cannot fail.
    let _ = writeln!(
        out,
        "  results in {}: summary.json, tube.csv, parts.csv, run.toml{pictures}",
        folder.display()
    );
    out
}
