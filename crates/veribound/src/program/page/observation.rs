//! The page of an observation.

use super::{Material, head};
use crate::program::ending::Ending;
use crate::program::message::list;
use crate::program::numbers::{counted, show_time, shrink};
use crate::program::observe::Findings;
use crate::program::verdict;
use veribound_data::Record;
use veribound_interval::Interval;
use veribound_model::diagnostic::{Diagnostic, Diagnostics};
use veribound_report::{Block, Entry, Page, Section, Table, Tone};

/// Verdict, tables, and what limits the bounds; `boxes` is the number that merging reduces the list to.
pub fn observation(
    material: &Material<'_>,
    record: &Record,
    found: &Findings,
    boxes: usize,
) -> Result<Page, Diagnostic> {
    let mut page = material.page("observe", limits(material, record, found, boxes))?;
    let (tone, headline) = match found.ending {
        Ending::Inconsistent => (
            Tone::Refuted,
            format!("Refuted: {}", verdict::NOTHING_EXPLAINS),
        ),
        Ending::Undecided => (Tone::Open, "Undecided: the run stopped early".to_owned()),
        Ending::Interrupted if found.last.is_none() => {
            (Tone::Open, "Interrupted before the first sample".to_owned())
        }
        Ending::Interrupted => (Tone::Open, "Consistent until interrupted".to_owned()),
        _ => (
            Tone::Bounds,
            "Consistent: bounds are proved, and no sample refutes the model".to_owned(),
        ),
    };
    (page.tone, page.headline) = (tone, headline);
    page.sentences = sentences(material, record, found);
    if let Some(problem) = verdict::problem(material.model, record, found) {
        page.before.push(Section {
            title: match found.ending {
                Ending::Inconsistent => "Where it fails".to_owned(),
                _ => "Where it stopped".to_owned(),
            },
            blocks: proof(material, found, problem),
        });
    }
    if found.refutation.is_none() {
        page.before.push(bounds(material, found));
    }
    page.after.insert(0, work(material));
    Ok(page)
}

fn sentences(material: &Material<'_>, record: &Record, found: &Findings) -> Vec<String> {
    let read = format!(
        "{} of {} were read; the last one in the bounds is at t = {} s.",
        found.samples,
        counted(record.len(), "sample", "samples"),
        show_time(found.last.as_ref().map_or(record.first(), |(time, _)| time)),
    );
    let mut sentences = vec![match found.ending {
        Ending::Inconsistent => String::from(
            "This is proved: no parameters inside the priors, no start inside its intervals, no inputs and errors \
             inside their bounds give this record.",
        ),
        _ => String::from(
            "If the errors of the record stay inside the bounds of the model file, the true values lie inside the \
             bounds below.",
        ),
    }];
    if found.ending == Ending::Undecided {
        let reason = material.word(&["reason"]);
        sentences.push(format!("Why: {reason}. What was proved before holds."));
    }
    sentences.push(read);
    sentences
}

/// What refuted the model, or what stood in the way of a proof.
fn proof(material: &Material<'_>, found: &Findings, problem: Diagnostic) -> Vec<Block> {
    let mut blocks = Vec::new();
    if found.refutation.is_some() {
        let at = |name| material.value(&["refutation", name]);
        let text = |name| Entry::Text(material.word(&["refutation", name]));
        let mut facts = vec![
            ("what", text("output")),
            ("time in s", at("time")),
            ("line of the record", at("line")),
            (
                "all that the model allows",
                material.bounds(&["refutation", "enclosure"]),
            ),
            (
                "all that the record allows",
                material.bounds(&["refutation", "measured"]),
            ),
            ("at least so far apart", at("gap")),
        ];
        let unit = material.word(&["refutation", "unit"]);
        if !unit.is_empty() {
            facts.push(("unit", Entry::Text(unit)));
        }
        let facts = facts
            .into_iter()
            .map(|(name, entry)| (name.to_owned(), entry));
        blocks.push(Block::Facts(facts.collect()));
    }
    blocks.push(Block::Listing {
        title: None,
        text: Diagnostics::from(problem).render(false),
    });
    blocks
}

/// The tables of parameters and states.
fn bounds(material: &Material<'_>, found: &Findings) -> Section {
    let last = found.last.as_ref().map(|(_, estimate)| estimate);
    let pair = |x: Interval| (x.lo(), x.hi());
    let params = material.model.params.iter().enumerate().map(|(at, param)| {
        let proved = last.and_then(|last| last.params.get(at)).copied();
        let proved = proved.unwrap_or(param.bounds);
        let reset = found.resets.get(at).and_then(Option::as_ref);
        vec![
            Entry::Text(param.name.clone()),
            Entry::Text(param.unit.clone()),
            material.bounds(&["parameters", &param.name, "prior"]),
            material.bounds(&["parameters", &param.name]),
            Entry::Bar {
                prior: pair(param.bounds),
                outer: Some(pair(proved)),
                inner: None,
            },
            Entry::Text(shrink(proved, param.bounds).unwrap_or_default()),
            Entry::Text(reset.map_or(String::new(), |time| {
                format!("since the reset at {} s", show_time(time))
            })),
        ]
    });
    let states = material.model.states.iter().map(|state| {
        vec![
            Entry::Text(state.name.clone()),
            Entry::Text(state.unit.clone()),
            material.bounds(&["states", &state.name]),
        ]
    });
    let time = found.last.as_ref().map_or(String::new(), |(time, _)| {
        format!(" at {} s", show_time(time))
    });
    let mut blocks = Vec::new();
    if !material.model.params.is_empty() {
        blocks.push(Block::Table(Table {
            head: head(&[
                "parameter",
                "unit",
                "prior",
                "proved bounds",
                "",
                "shrink",
                "",
            ]),
            rows: params.collect(),
        }));
    }
    blocks.push(Block::Table(Table {
        head: head(&["state", "unit", "proved bounds"]),
        rows: states.collect(),
    }));
    Section {
        title: format!("Bounds{time}"),
        blocks,
    }
}

/// What the run cost.
fn work(material: &Material<'_>) -> Section {
    material.cost(&[
        ("samples in the bounds", &["samples"]),
        ("time in s", &["work", "wall_s"]),
        ("worst sample in s", &["work", "worst_sample_s"]),
        ("boxes at most", &["work", "boxes_max"]),
        ("steps of boxes", &["work", "box_steps"]),
    ])
}

/// What stands in the way of narrower bounds, as far as the run itself tells.
fn limits(material: &Material<'_>, record: &Record, found: &Findings, boxes: usize) -> Vec<String> {
    let mut said = Vec::new();
    if found.refutation.is_some() {
        said.push(
            "Nothing: there are no bounds. Widen what is not certain, one thing at a time."
                .to_owned(),
        );
        return said;
    }
    if let Some((_, last)) = &found.last {
        let params = material.model.params.iter().zip(&last.params);
        let untouched = params
            .filter(|(param, proved)| {
                param.bounds.lo() < param.bounds.hi() && **proved == param.bounds
            })
            .map(|(param, _)| param.name.as_str());
        let untouched: Vec<&str> = untouched.collect();
        if !untouched.is_empty() {
            said.push(format!(
                "Nothing in the record narrowed {}: does the experiment excite what depends on it?",
                list(untouched)
            ));
        }
    }
    if found.work.boxes_max >= boxes {
        said.push(format!(
            "The list of boxes was full ({boxes}) and was merged again and again. More boxes (--boxes) cost time and \
             give narrower bounds."
        ));
    } else {
        said.push(format!(
            "The list of boxes was never full (at most {} of {boxes}): more bisections (--bisections, --every) may help.",
            found.work.boxes_max
        ));
    }
    let missing: usize = record.missing().iter().map(|(_, count)| count).sum();
    if missing > 0 {
        said.push(format!("{missing} values of the record are missing."));
    }
    said.push(
        "An observation reads the record once, forward. A second pass (--start-from this folder) uses what the end of \
         the record says about its start; `veribound identify` uses all samples together and tells how far the \
         bounds are from the best that can be proved."
            .to_owned(),
    );
    said
}
