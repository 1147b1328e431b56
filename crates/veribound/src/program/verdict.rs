//! Verdicts in words.

use super::ending::Ending;
use super::message;
use super::numbers::{show, show_time};
use super::observe::Findings;
use std::sync::Arc;
use veribound_data::{Kind, Record, Verdict};
use veribound_estimate::{Contradiction, Refutation, Undecided};
use veribound_flow::{AprioriFailure, StepFailure};
use veribound_interval::{Interval, text};
use veribound_model::Model;
use veribound_model::diagnostic::{Diagnostic, SourceText};

/// The verdict, and why where that is not plain.
pub fn in_words(model: &Model, found: &Findings) -> (Verdict, Option<String>) {
    match (&found.refutation, &found.undecided) {
        (Some(_), _) => (Verdict::Inconsistent, Some(NOTHING_EXPLAINS.to_owned())),
        (None, Some(undecided)) => (
            Verdict::Undecided,
            Some(format!("{}: {}", stopped(undecided), why(model, undecided))),
        ),
        (None, None) if found.samples == 0 => (
            Verdict::Undecided,
            Some("interrupted before the first sample".to_owned()),
        ),
        (None, None) => (Verdict::Consistent, None),
    }
}

/// Of a model that is proved not to fit.
pub const NOTHING_EXPLAINS: &str = "no parameter in the prior explains the data";

/// The refutation for `summary.json`.
pub fn entry(model: &Model, refutation: &Refutation) -> veribound_data::Refutation {
    let told = told(model, refutation);
    let kind = match refutation.contradiction {
        Contradiction::Output { .. } => Kind::Output,
        Contradiction::Signal { .. } => Kind::Signal,
        Contradiction::Motion { .. } => Kind::Motion,
        Contradiction::Apart { .. } => Kind::Apart,
    };
    veribound_data::Refutation::new(
        kind,
        (refutation.sample, refutation.line, &refutation.time),
        (told.name, told.unit),
        (told.enclosure, told.allowed),
    )
}

/// What the refuting sample says about one quantity.
struct Told<'m> {
    name: &'m str,
    unit: &'m str,
    enclosure: Interval,
    allowed: Interval,
    /// What the enclosure is one of: `phi_m`, or `what still proves to be zero`.
    subject: String,
}

fn told<'m>(model: &'m Model, refutation: &Refutation) -> Told<'m> {
    match &refutation.contradiction {
        Contradiction::Output {
            output,
            enclosure,
            measured,
            ..
        } => {
            let output = model.outputs.get(*output);
            let name = output.map_or("", |output| output.name.as_str());
            Told {
                name,
                unit: output.map_or("", |output| output.unit.as_str()),
                enclosure: *enclosure,
                allowed: *measured,
                subject: name.to_owned(),
            }
        }
        Contradiction::Signal { signal, enclosure } => {
            let name = model
                .signals
                .get(*signal)
                .map_or("", |signal| signal.name.as_str());
            Told {
                name,
                unit: "",
                enclosure: *enclosure,
                allowed: Interval::ZERO,
                subject: format!("what `{name}` proves to be zero"),
            }
        }
        Contradiction::Motion {
            pair,
            enclosure,
            needed,
        } => {
            let rate = model.states.get(pair.rate);
            let name = rate.map_or("", |state| state.name.as_str());
            Told {
                name,
                unit: rate.map_or("", |state| state.unit.as_str()),
                enclosure: *enclosure,
                allowed: *needed,
                subject: name.to_owned(),
            }
        }
        Contradiction::Apart {
            quantity,
            enclosure,
            allowed,
        } => {
            let states = model.states.iter().map(|state| (&state.name, &state.unit));
            let params = model.params.iter().map(|param| (&param.name, &param.unit));
            let own = states.chain(params).nth(*quantity);
            let (name, unit) = own.map_or(("", ""), |(name, unit)| (name.as_str(), unit.as_str()));
            Told {
                name,
                unit,
                enclosure: *enclosure,
                allowed: *allowed,
                subject: name.to_owned(),
            }
        }
    }
}

/// Why a run did not end consistent.
pub fn problem(model: &Model, record: &Record, found: &Findings) -> Option<Diagnostic> {
    let refutation = found.refutation.as_ref();
    let undecided = found.undecided.as_ref();
    refutation
        .map(|refutation| refuted(model, record, refutation))
        .or_else(|| undecided.map(|undecided| not_decided(model, record, undecided)))
}

/// Tells on stderr why a run did not end consistent.
pub fn explain(model: &Model, record: &Record, found: &Findings, at_length: bool) {
    if let Some(problem) = problem(model, record, found) {
        message::complain(&problem.into());
    }
    if found.ending == Ending::Interrupted && at_length {
        message::remark("interrupted: the files are complete up to the last sample");
    }
}

/// What contradicts what at the sample that refutes, in one sentence.
pub fn refuted_at(model: &Model, refutation: &Refutation) -> String {
    let Told {
        unit,
        enclosure,
        allowed,
        subject,
        ..
    } = told(model, refutation);
    let unit = if unit.is_empty() {
        String::new()
    } else {
        format!(" {unit}")
    };
    let gap = text::lower((allowed - enclosure).mig(), 3);
    let who = match &refutation.contradiction {
        Contradiction::Output { .. } => "the measurement allows",
        Contradiction::Signal { .. } => "the signal allows",
        Contradiction::Motion { .. } => "how far the measurements say it moved allows",
        Contradiction::Apart { .. } => "all samples together allow",
    };
    format!(
        "t = {} s: the enclosure of {subject} is {}{unit}; {who} {}{unit}: gap {gap}{unit}",
        show_time(&refutation.time),
        show(enclosure),
        show(allowed),
    )
}

/// The message of a proved contradiction.
fn refuted(model: &Model, record: &Record, refutation: &Refutation) -> Diagnostic {
    let name = told(model, refutation).name;
    let label = refuted_at(model, refutation);
    let help = match &refutation.contradiction {
        Contradiction::Output { .. } if refutation.sample == 0 => format!(
            "no parameter has acted yet: check `init` in the model file, and that `{name}` is recorded in \
             the unit of the model"
        ),
        Contradiction::Output { .. } => format!(
            "widen what is not certain: the error bound of `{name}`, the priors, disturbances, `--input-error`, \
             or `--reset` for a parameter that changes"
        ),
        Contradiction::Motion { .. } | Contradiction::Apart { .. } => String::from(
            "widen what is not certain: the error bounds of the outputs, the priors, disturbances, `--input-error`, \
             or `--reset` for a parameter that changes",
        ),
        Contradiction::Signal { .. } => {
            format!("check what `{name}` proves and its latency in the model file, or the priors")
        }
    };
    at_line(
        Diagnostic::new("E0301", format!("{NOTHING_EXPLAINS} (proved)")),
        record,
        refutation.line,
        label,
    )
    .help(help)
}

/// What could not be proved, and on which box, in one sentence.
pub fn not_decided_at(model: &Model, undecided: &Undecided) -> String {
    let boxed = model.states.iter().map(|state| state.name.as_str());
    let boxed = boxed.chain(model.params.iter().map(|param| param.name.as_str()));
    let cell: Vec<String> = boxed
        .zip(&undecided.cell)
        .map(|(name, x)| format!("{name} {}", show(*x)))
        .collect();
    format!("{} on the box {}", why(model, undecided), cell.join(", "))
}

/// The message of a run that stopped without a proof.
fn not_decided(model: &Model, record: &Record, undecided: &Undecided) -> Diagnostic {
    let help = match undecided.reason {
        StepFailure::Apriori(AprioriFailure::Undefined { .. }) => {
            "narrow the priors or start intervals so that every function is defined on them"
                .to_owned()
        }
        StepFailure::LeavesDomain { .. } | StepFailure::InputOutsideDomain { .. } => {
            "declare a larger domain in the model file, if its modes leave no gap there".to_owned()
        }
        _ => {
            "try more boxes (`--boxes`, `--bisections`), or narrower priors; the results up to the \
              sample before hold"
                .to_owned()
        }
    };
    let label = not_decided_at(model, undecided);
    at_line(
        Diagnostic::new("E0302", stopped(undecided)),
        record,
        undecided.line,
        label,
    )
    .help(help)
}

/// That a run stopped, and where.
pub fn stopped(undecided: &Undecided) -> String {
    format!(
        "nothing could be proved about the step to t = {} s",
        show_time(&undecided.time)
    )
}

fn why(model: &Model, undecided: &Undecided) -> String {
    if let Some(state) = undecided.undefined_state() {
        let name = model
            .states
            .get(state)
            .map_or("", |state| state.name.as_str());
        return format!("the derivative of `{name}` is not defined everywhere");
    }
    match undecided.reason {
        StepFailure::Unbounded => "the enclosure grew beyond all numbers".to_owned(),
        StepFailure::Apriori(_) => {
            "no bounding box holds the solutions, even for the shortest step".to_owned()
        }
        StepFailure::LeavesDomain { state } => {
            let name = model
                .states
                .get(state)
                .map_or("", |state| state.name.as_str());
            format!("`{name}` may leave the domain in which the modes leave no gap")
        }
        StepFailure::InputOutsideDomain { input } => {
            let name = model
                .inputs
                .get(input)
                .map_or("", |input| input.name.as_str());
            format!("`{name}` is outside the domain in which the modes leave no gap")
        }
    }
}

/// Shows the line of the record; without it where it cannot be read again.
pub fn at_line(problem: Diagnostic, record: &Record, number: usize, label: String) -> Diagnostic {
    let name = record.path().display().to_string();
    let line = record.line(number).unwrap_or_default();
    let end = line.len();
    problem.at(
        &Arc::new(SourceText::excerpt(name, line, number)),
        0..end,
        label,
    )
}
