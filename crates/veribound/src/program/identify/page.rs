//! The page of an identification.

use super::super::ending::Ending;
use super::super::message::list;
use super::super::numbers::{counted, show_time, show_times, shrink};
use super::super::page::{Material, head};
use super::super::verdict::NOTHING_EXPLAINS;
use super::told::{DISTURBED, MEASURED, least_in_words};
use super::verdict::{problem, refuted_by};
use super::{Data, Findings};
use veribound_estimate::identify::{Bounds, Conclusion, Limit};
use veribound_interval::Interval;
use veribound_model::diagnostic::{Diagnostic, Diagnostics};
use veribound_report::{Block, Entry, Page, Section, Table, Tone};

/// Verdict, tables, and what limits the bounds.
pub fn page(material: &Material<'_>, data: &Data, found: &Findings) -> Result<Page, Diagnostic> {
    let mut page = material.page("identify", limits(material, found))?;
    let identified = &found.identified;
    let interrupted = if identified.interrupted {
        ", interrupted"
    } else {
        ""
    };
    let (tone, headline) = match &identified.conclusion {
        Conclusion::Inconsistent(_) => (Tone::Refuted, format!("Refuted: {NOTHING_EXPLAINS}")),
        Conclusion::Consistent => (
            Tone::Bounds,
            format!("Consistent{interrupted}: bounds are proved from both sides"),
        ),
        Conclusion::Undecided => (
            Tone::Open,
            format!("Undecided{interrupted}: no parameters are proved to agree with the record"),
        ),
    };
    (page.tone, page.headline) = (tone, headline);
    page.sentences = sentences(data, found);
    if let Some(problem) = problem(material.model, data, found) {
        page.before.push(Section {
            title: match found.ending {
                Ending::Inconsistent => "Where it fails".to_owned(),
                _ => "Why".to_owned(),
            },
            blocks: vec![Block::Listing {
                title: None,
                text: Diagnostics::from(problem).render(false),
            }],
        });
    }
    if !matches!(identified.conclusion, Conclusion::Inconsistent(_)) {
        page.before.push(parameters(material, found));
        page.before.extend(resets(material, data, found));
        page.before.push(starts(material, data, found));
    }
    let mut facts: Vec<(&str, &[&str])> = vec![
        ("samples", &["samples"]),
        ("time in s", &["work", "wall_s"]),
        ("sets looked at", &["work", "sets"]),
        ("passes through a record", &["work", "passes"]),
        ("points proved to agree", &["points"]),
    ];
    let is_refuted = matches!(identified.conclusion, Conclusion::Inconsistent(_));
    if !identified.tiles.is_empty() && !is_refuted {
        facts.extend::<[(&str, &[&str]); 5]>([
            ("tiles", &["paving", "tiles"]),
            (
                "inside, share of the outer box at least",
                &["paving", "inside"],
            ),
            (
                "undecided, share of the outer box at most",
                &["paving", "undecided"],
            ),
            (
                "volume of what agrees at least",
                &["paving", "volume", "lo"],
            ),
            ("volume of what agrees at most", &["paving", "volume", "hi"]),
        ]);
    }
    page.after.insert(0, material.cost(&facts));
    Ok(page)
}

fn sentences(data: &Data, found: &Findings) -> Vec<String> {
    let read = format!(
        "{} of {} were read.",
        counted(data.count(), "sample", "samples"),
        counted(data.records.len(), "record", "records")
    );
    let said = match &found.identified.conclusion {
        Conclusion::Inconsistent(refuted) => vec![
            "This is proved: no parameters inside the priors, no start inside its intervals, no inputs and errors \
             inside their bounds give these samples."
                .to_owned(),
            format!("Proved: {}.", refuted_by(data, refuted)),
        ],
        Conclusion::Undecided => vec![
            "Outer bounds hold every value that agrees with model and records, if any does: that is not proved."
                .to_owned(),
        ],
        Conclusion::Consistent => vec![
            "Outer bounds hold every value that agrees with model and records. Both ends of the inner ones are proved \
             to be reached, so nobody can prove narrower bounds than those from these records."
                .to_owned(),
        ],
    };
    said.into_iter().chain([read]).collect()
}

fn parameters(material: &Material<'_>, found: &Findings) -> Section {
    let bounds = found.params(material.model);
    let rows = material.model.params.iter().zip(&bounds).enumerate();
    let rows = rows.map(|(at, (param, both))| {
        let place: &[&str] = &["parameters", &param.name];
        let limit = found
            .identified
            .limits
            .get(at)
            .map_or("", |limit| limit_in_words(*limit));
        let mut row = vec![
            Entry::Text(param.name.clone()),
            Entry::Text(param.unit.clone()),
            material.bounds(&[place, &["prior"]].concat()),
        ];
        row.extend(both_sides(material, place, both, param.bounds));
        row.extend([
            Entry::Text(shrink(both.outer, param.bounds).unwrap_or_default()),
            Entry::Text(limit.to_owned()),
        ]);
        row
    });
    let titles = [
        "parameter",
        "unit",
        "prior",
        "outer bounds",
        "inner bounds",
        "",
        "too wide at most",
        "shrink",
        "limited by",
    ];
    Section {
        title: "Bounds of the parameters".to_owned(),
        blocks: vec![Block::Table(Table {
            head: head(&titles),
            rows: rows.collect(),
        })],
    }
}

/// The values of parameters between resets, if there are any.
fn resets(material: &Material<'_>, data: &Data, found: &Findings) -> Option<Section> {
    let all = found.identified.resets.iter().enumerate();
    let all = all.flat_map(|(record, values)| values.iter().map(move |value| (record, value)));
    // They stand in the summary in this order.
    let rows = all.enumerate().filter_map(|(at, (record, value))| {
        let param = material.model.params.get(value.param)?;
        let (from, until) = (show_time(&value.from), show_time(&value.until));
        let mut when = format!("from {from} s to {until} s");
        if data.records.len() > 1 {
            when.push_str(&format!(" in {}", data.name(record)));
        }
        let mut row = vec![
            Entry::Text(param.name.clone()),
            Entry::Text(param.unit.clone()),
            Entry::Text(when),
        ];
        let place: &[&str] = &["resets", &at.to_string()];
        row.extend(both_sides(material, place, &value.bounds, param.bounds));
        Some(row)
    });
    let rows: Vec<_> = rows.collect();
    let titles = [
        "parameter",
        "unit",
        "after a reset",
        "outer bounds",
        "inner bounds",
        "",
        "too wide at most",
    ];
    (!rows.is_empty()).then(|| Section {
        title: "Values after resets".to_owned(),
        blocks: vec![Block::Table(Table {
            head: head(&titles),
            rows,
        })],
    })
}

fn starts(material: &Material<'_>, data: &Data, found: &Findings) -> Section {
    let mut blocks = Vec::new();
    for record in 0..data.records.len() {
        let number = record.to_string();
        let bounds = found.start(material.model, record);
        let rows = material
            .model
            .states
            .iter()
            .zip(&bounds)
            .map(|(state, both)| {
                let place: &[&str] = &["starts", &number, "states", &state.name];
                let mut row = vec![
                    Entry::Text(state.name.clone()),
                    Entry::Text(state.unit.clone()),
                ];
                row.extend(both_sides(material, place, both, state.init));
                row
            });
        blocks.push(Block::Text(format!(
            "At the first sample of {}:",
            data.name(record)
        )));
        let titles = [
            "state",
            "unit",
            "outer bounds",
            "inner bounds",
            "",
            "too wide at most",
        ];
        blocks.push(Block::Table(Table {
            head: head(&titles),
            rows: rows.collect(),
        }));
    }
    Section {
        title: "Start states".to_owned(),
        blocks,
    }
}

/// Bounds from outside and inside, a picture of them, and how far they are apart.
fn both_sides(
    material: &Material<'_>,
    place: &[&str],
    both: &Bounds,
    prior: Interval,
) -> [Entry; 4] {
    let pair = |x: Interval| (x.lo(), x.hi());
    let times = show_times(both.tightness());
    [
        material.bounds(place),
        material.bounds(&[place, &["inner"]].concat()),
        Entry::Bar {
            prior: pair(prior),
            outer: (!both.outer.is_empty()).then(|| pair(both.outer)),
            inner: both.inner.map(pair),
        },
        if times.is_empty() {
            Entry::Text(String::new())
        } else {
            material.value(&[place, &["tightness"]].concat())
        },
    ]
}

/// What stands in the way of narrower bounds.
pub fn limit_in_words(limit: Limit) -> &'static str {
    match limit {
        Limit::Record => "the record",
        Limit::Budget => "the number of sets",
        Limit::Memory => "the memory",
        Limit::Enclosure => "how far solutions are enclosed",
        Limit::Inputs => "the errors of inputs",
    }
}

fn limits(material: &Material<'_>, found: &Findings) -> Vec<String> {
    if matches!(found.identified.conclusion, Conclusion::Inconsistent(_)) {
        let measured = found.least.as_ref().map(|least| (MEASURED, least));
        let disturbed = found.least_disturbance.as_ref();
        let disturbed = disturbed.map(|least| (DISTURBED, least));
        let least = measured
            .into_iter()
            .chain(disturbed)
            .map(|(errors, least)| {
                let said = least_in_words(errors, least);
                let mut letters = said.chars();
                let first = letters.next().map(|c| c.to_uppercase().to_string());
                format!("{}{}.", first.unwrap_or_default(), letters.as_str())
            });
        let nothing =
            "Nothing: there are no bounds. Widen what is not certain, one thing at a time.";
        return [nothing.to_owned()].into_iter().chain(least).collect();
    }
    let named = |wanted: Limit| {
        let params = material.model.params.iter().zip(&found.identified.limits);
        let names = params.filter(|(_, limit)| **limit == wanted);
        names
            .map(|(param, _)| param.name.as_str())
            .collect::<Vec<_>>()
    };
    let of = |wanted: Limit, advice: &str| {
        let names = named(wanted);
        (!names.is_empty())
            .then(|| format!("{}: {}. {advice}", list(names), limit_in_words(wanted)))
    };
    let said = [
        of(
            Limit::Record,
            "No method can prove much more from these samples; smaller error bounds, or other experiments, can.",
        ),
        of(Limit::Budget, "More sets (--sets) give narrower bounds."),
        of(
            Limit::Memory,
            "More memory (--memory) gives narrower bounds.",
        ),
        of(
            Limit::Enclosure,
            "Narrower priors or start intervals, or less of the record (--to), help.",
        ),
        of(
            Limit::Inputs,
            "Smaller errors of inputs (--input-error) help, or errors that stay the same for a while (@level).",
        ),
    ];
    said.into_iter().flatten().collect()
}
