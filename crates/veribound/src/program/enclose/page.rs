//! The page of an enclosure.

use super::super::ending::Ending;
use super::super::numbers::show_prior;
use super::super::page::{Material, head};
use super::{Findings, told};
use veribound_interval::Decimal;
use veribound_model::diagnostic::Diagnostic;
use veribound_report::{Block, Entry, Page, Section, Table, Tone};

/// Verdict, tables, and what limits the bounds.
pub fn page(
    material: &Material<'_>,
    times: &[Decimal],
    found: &Findings,
) -> Result<Page, Diagnostic> {
    let limits = limits(material, times, found);
    let mut page = material.page("enclose", limits)?;
    let until = times.last().map_or_else(String::new, Decimal::to_string);
    (page.tone, page.headline) = match found.ending {
        Ending::Done => (
            Tone::Bounds,
            format!("Proved: all solutions stay inside these bounds until {until} s"),
        ),
        Ending::Interrupted => (Tone::Open, format!("Interrupted; proved until {until} s")),
        _ => (
            Tone::Open,
            format!("Undecided: proved only until {until} s"),
        ),
    };
    page.sentences.push(
        "Every start, parameter, disturbance and input error that the model file allows is covered, across all switches \
         and jumps, at all times."
            .to_owned(),
    );
    if let Some(reason) = told::reason(material.model, found) {
        page.sentences.push(format!("Why not further: {reason}."));
    }
    if let Some(counts) = found
        .asked
        .then(|| super::trajectories::counted(&found.drawn))
    {
        page.sentences.push(format!(
            "{} of {} random true trajectories are proved to lie inside, none outside ({} comparisons).",
            counts.inside, counts.drawn, counts.comparisons
        ));
    }
    page.before.push(bounds(material, &until));
    page.after.insert(
        0,
        material.cost(&[
            ("times in the table", &["times"]),
            ("parts", &["parts"]),
            ("time in s", &["work", "wall_s"]),
            ("steps", &["work", "steps"]),
        ]),
    );
    Ok(page)
}

fn bounds(material: &Material<'_>, until: &str) -> Section {
    let model = material.model;
    let row = |kind: &str, name: &str, unit: &str, start: String| {
        let place: &[&str] = &[kind, name];
        vec![
            Entry::Text(name.to_owned()),
            Entry::Text(unit.to_owned()),
            Entry::Text(start),
            material.bounds(place),
            material.bounds(&[place, &["always"]].concat()),
        ]
    };
    let states = model.states.iter();
    let states = states.map(|x| row("states", &x.name, &x.unit, show_prior(x.init)));
    let outputs = model.outputs.iter();
    let outputs = outputs.map(|y| row("outputs", &y.name, &y.unit, String::new()));
    let at = format!("proved at {until} s");
    let mut blocks = vec![Block::Table(Table {
        head: head(&["", "unit", "start", &at, "proved at all times until then"]),
        rows: states.chain(outputs).collect(),
    })];
    if !model.params.is_empty() {
        let rows = model.params.iter().map(|param| {
            vec![
                Entry::Text(param.name.clone()),
                Entry::Text(param.unit.clone()),
                Entry::Text(show_prior(param.bounds)),
            ]
        });
        blocks.push(Block::Table(Table {
            head: head(&["parameter", "unit", "all values in"]),
            rows: rows.collect(),
        }));
    }
    Section {
        title: "Bounds".to_owned(),
        blocks,
    }
}

fn limits(material: &Material<'_>, times: &[Decimal], found: &Findings) -> Vec<String> {
    let mut said = vec![format!("Engine: {}.", found.engine)];
    said.extend(told::past_use(material.model, found));
    if found.ending == Ending::Undecided
        && let Some(cause) = &found.obstacle
    {
        let until = times.last().map_or_else(String::new, Decimal::to_string);
        said.push(format!(
            "Nothing is proved beyond {until} s. Try {}.",
            cause.remedy
        ));
    }
    if found.past_use.is_empty() && found.ending == Ending::Done {
        said.push("No width grew past use.".to_owned());
    }
    said
}
