//! The parameters that an earlier run proved, to start from.

use super::number::Number;
use crate::failure;
use crate::record::fields::{content, split};
use crate::record::lines::{Lines, quote};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::BufReader;
use std::ops::Range;
use std::path::{Path, PathBuf};
use veribound_interval::{Decimal, Interval};
use veribound_model::diagnostic::{Diagnostic, SourceText};
use veribound_model::model::Model;

/// What an earlier run of the same model proved about its parameters.
///
/// *Guarantee*: contains the parameters that the earlier run printed. (Printing rounds outward, and
/// what is printed is read as the exact decimal, so nothing is lost.) Whether the earlier result is
/// true of the new record is the user's word: that its parameters were the same.
#[derive(Debug, Clone)]
pub struct Start {
    /// Bounds of every parameter, in the order of the model, from `summary.json`.
    pub params: Vec<Interval>,
    /// Boxes of the parameters at the end of the run, in the order of the model, from `boxes.csv`;
    /// empty when the run wrote none.
    pub boxes: Vec<Vec<Interval>>,
    /// The `summary.json` that was read.
    pub summary: PathBuf,
}

/// The part of `summary.json` that is read back.
#[derive(Deserialize)]
struct Written {
    verdict: String,
    parameters: BTreeMap<String, WrittenBounds>,
}

#[derive(Deserialize)]
struct WrittenBounds {
    lo: Number,
    hi: Number,
}

impl Start {
    /// Reads the results in the folder `path`.
    ///
    /// *Errors*: `E0401` when a file cannot be read, `E0504` when it is no result, `E0505` when it
    /// does not fit the model or the run proved the model inconsistent.
    pub fn read(path: impl AsRef<Path>, model: &Model) -> Result<Start, Diagnostic> {
        let folder = path.as_ref();
        let summary = folder.join("summary.json");
        let params = read_summary(&summary, model)?;
        let boxes = folder.join("boxes.csv");
        let boxes = if boxes.is_file() {
            read_boxes(&boxes, model)?
        } else {
            Vec::new()
        };
        Ok(Start {
            params,
            boxes,
            summary,
        })
    }
}

fn read_summary(path: &Path, model: &Model) -> Result<Vec<Interval>, Diagnostic> {
    let name = path.display().to_string();
    let text = fs::read_to_string(path).map_err(|error| {
        failure::unreadable(&name, &error)
            .help("name the folder that an earlier run wrote with `-o DIR`")
    })?;
    let written: Written =
        serde_json::from_str(&text).map_err(|error| no_json(&name, &text, &error))?;
    if written.verdict == "inconsistent" {
        let message =
            format!("the run in `{name}` proved the model inconsistent: it left no parameters");
        return Err(
            Diagnostic::new("E0505", message).help("start from a run that ended consistent")
        );
    }
    let mut params = Vec::with_capacity(model.params.len());
    for param in &model.params {
        let bounds = written.parameters.get(&param.name);
        let bounds = bounds.ok_or_else(|| not_of_this_model(&name, &param.name))?;
        let ends = (bounds.lo.decimal(), bounds.hi.decimal());
        params.push(enclose(ends).ok_or_else(|| reversed(&name, &param.name))?);
    }
    Ok(params)
}

fn read_boxes(path: &Path, model: &Model) -> Result<Vec<Vec<Interval>>, Diagnostic> {
    let name = path.display().to_string();
    let file = File::open(path).map_err(|error| failure::unreadable(&name, &error))?;
    let mut lines = Lines::new(BufReader::new(file), &name)?;
    let mut ranges: Vec<Range<usize>> = Vec::new();
    let mut places: Option<Vec<(usize, usize)>> = None;
    let mut last_time: Option<Decimal> = None;
    let mut boxes = Vec::new();
    while let Some((line, number)) = lines.next_line()? {
        let refuse = |range: Range<usize>, message: String| {
            let (source, range) = quote(&name, line, number, range);
            Diagnostic::new("E0504", message)
                .at(&source, range, "written by no run of this program")
                .help("run the earlier observation again")
        };
        if split(line, ',', &mut ranges).is_err() {
            return Err(refuse(
                0..line.len(),
                "the quotes of a field do not match".to_owned(),
            ));
        }
        let field = |at: usize| {
            let range = ranges.get(at).cloned().unwrap_or_default();
            (content(line, range.clone()), range)
        };
        let Some(places) = &places else {
            let mut found = Vec::with_capacity(model.params.len());
            for param in &model.params {
                let position = |end| {
                    let wanted = format!("{}.{end}", param.name);
                    (0..ranges.len()).find(|at| field(*at).0 == wanted)
                };
                let pair = position("lo").zip(position("hi"));
                found.push(pair.ok_or_else(|| not_of_this_model(&name, &param.name))?);
            }
            places = Some(found);
            continue;
        };
        let number_at = |at: usize| {
            let (text, range) = field(at);
            Decimal::parse(&text).map_err(|_| refuse(range, format!("`{text}` is no number")))
        };
        let end_at = |at: usize, infinite: &str| {
            if field(at).0 == infinite {
                Ok(None)
            } else {
                number_at(at).map(Some)
            }
        };
        let time = number_at(0)?;
        // Only the boxes of the last sample describe the end of the run.
        if last_time.as_ref().is_none_or(|last| *last != time) {
            boxes.clear();
        }
        last_time = Some(time);
        let mut one = Vec::with_capacity(places.len());
        for ((lo, hi), param) in places.iter().zip(&model.params) {
            let ends = (end_at(*lo, "-inf")?, end_at(*hi, "inf")?);
            one.push(enclose(ends).ok_or_else(|| reversed(&name, &param.name))?);
        }
        boxes.push(one);
    }
    Ok(boxes)
}

/// The smallest interval around two printed ends; `None` where they are reversed.
fn enclose((lo, hi): (Option<Decimal>, Option<Decimal>)) -> Option<Interval> {
    if let (Some(lo), Some(hi)) = (&lo, &hi)
        && lo > hi
    {
        return None;
    }
    let lo = lo.map_or(f64::NEG_INFINITY, |lo| lo.to_interval().lo());
    let hi = hi.map_or(f64::INFINITY, |hi| hi.to_interval().hi());
    Interval::new(lo, hi)
}

fn no_json(name: &str, text: &str, error: &serde_json::Error) -> Diagnostic {
    let line = text
        .lines()
        .nth(error.line().saturating_sub(1))
        .unwrap_or_default();
    let at = error.column().saturating_sub(1).min(line.len());
    let source = std::sync::Arc::new(SourceText::excerpt(name, line, error.line().max(1)));
    Diagnostic::new("E0504", format!("`{name}` is no result of an observation"))
        .at(&source, at..at, error.to_string())
        .help("run the earlier observation again")
}

fn not_of_this_model(name: &str, param: &str) -> Diagnostic {
    Diagnostic::new(
        "E0505",
        format!("`{name}` has no bounds of the parameter `{param}`"),
    )
    .help("start from a run of a model with the same parameters")
}

fn reversed(name: &str, param: &str) -> Diagnostic {
    Diagnostic::new(
        "E0504",
        format!("the bounds of the parameter `{param}` in `{name}` are reversed"),
    )
    .help("run the earlier observation again")
}
