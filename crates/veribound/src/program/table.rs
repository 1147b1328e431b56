//! The short table at the end of an observation.

use super::ending::Ending;
use super::numbers::{show_inside, show_prior, show_time, shrink};
use super::observe::Findings;
use std::fmt::Write;
use std::path::Path;
use veribound_data::Record;
use veribound_interval::Interval;
use veribound_model::Model;

/// Verdict, work, and one line per parameter and state.
pub fn bounds(model: &Model, record: &Record, found: &Findings) -> String {
    let mut out = String::new();
    let verdict = match (found.ending, &found.last) {
        (Ending::Inconsistent, _) => "inconsistent (proved)",
        (Ending::Undecided, _) => "undecided",
        (Ending::Interrupted, None) => "interrupted",
        (Ending::Interrupted, Some(_)) => "consistent until interrupted",
        _ => "consistent",
    };
    let work = &found.work;
    // Writing to a String cannot fail.
    let _ = writeln!(
        out,
        "  {verdict}   {} of {} samples in {:.2} s   worst sample {:.2} ms   boxes at most {}",
        found.samples,
        record.len(),
        work.wall_s,
        work.worst_sample_s * 1e3,
        work.boxes_max,
    );
    if let Some((time, estimate)) = found.last.as_ref().filter(|_| found.refutation.is_none()) {
        let elapsed = format!("at {} s", show_time(time));
        let mut rows = vec![["", "prior", &elapsed, "", "shrink", ""].map(str::to_owned)];
        let names = model.params.iter().zip(&estimate.params).zip(&found.resets);
        for ((param, bounds), reset) in names {
            rows.push([
                param.name.clone(),
                show_prior(param.bounds),
                show_inside(*bounds, param.bounds),
                param.unit.clone(),
                shrink(*bounds, param.bounds).unwrap_or_default(),
                reset.as_ref().map_or(String::new(), |time| {
                    format!("since the reset at {} s", show_time(time))
                }),
            ]);
        }
        for (state, bounds) in model.states.iter().zip(&estimate.states) {
            rows.push([
                state.name.clone(),
                String::new(),
                show_inside(*bounds, Interval::EMPTY),
                state.unit.clone(),
                String::new(),
                String::new(),
            ]);
        }
        push_rows(&mut out, &rows);
    }
    out
}

/// The same, and where the results are.
pub fn of(
    model: &Model,
    record: &Record,
    found: &Findings,
    (folder, pictures): (&Path, String),
) -> String {
    let mut out = bounds(model, record, found);
    // Writing to a String cannot fail.
    let _ = writeln!(
        out,
        "  results in {}: summary.json, params.csv, states.csv, boxes.csv, run.toml{pictures}",
        folder.display()
    );
    out
}

/// Columns as wide as their widest entry; the last ones only as wide as they are.
pub fn push_rows<const N: usize>(out: &mut String, rows: &[[String; N]]) {
    push_parts(out, &[(None, rows)]);
}

/// A part of a table: what stands above it, and its rows.
pub type Part<'a, const N: usize> = (Option<&'a str>, &'a [[String; N]]);

/// The same for several parts with the same columns.
pub fn push_parts<const N: usize>(out: &mut String, parts: &[Part<'_, N>]) {
    let mut widths = [0; N];
    for row in parts.iter().flat_map(|(_, rows)| *rows) {
        for (width, text) in widths.iter_mut().zip(row) {
            *width = (*width).max(text.chars().count());
        }
    }
    for (above, rows) in parts {
        if let Some(above) = above {
            // Writing to a String cannot fail.
            let _ = writeln!(out, "  {above}");
        }
        for row in *rows {
            let mut line = String::from("  ");
            for (width, text) in widths.iter().zip(row).filter(|(width, _)| **width > 0) {
                let _ = write!(line, "{text:width$}   ");
            }
            out.push_str(line.trim_end());
            out.push('\n');
        }
    }
}
