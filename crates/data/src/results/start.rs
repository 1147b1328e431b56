//! The parameters that an earlier run proved, to start from.

use super::number::Number;
use super::run_info::FileInfo;
use crate::failure;
use crate::reader::table::{TableReader, TableRow};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::Path;
use veribound_interval::{Decimal, Interval};
use veribound_model::diagnostic::{Diagnostic, SourceText};
use veribound_model::model::Model;

/// What an earlier run of the same model proved about its parameters.
///
/// *Guarantee*: contains the parameters that the earlier run printed. (Printing rounds outward, and
/// what is printed is read as the exact decimal, so nothing is lost.) Whether the earlier result is
/// true of the new record is the user's word: that its parameters were the same.
///
/// Example: [`Summary`](crate::Summary).
#[derive(Debug, Clone)]
pub struct Start {
    /// Bounds of every parameter, in the order of the model, from `summary.json`.
    pub params: Vec<Interval>,
    /// Boxes of the parameters at the end of the run, in the order of the model, from `boxes.csv`;
    /// empty when the run wrote none.
    pub boxes: Vec<Vec<Interval>>,
    /// What the run assumed beside its model file; its results hold only with it.
    pub assumptions: Vec<String>,
    /// The files that were read.
    pub files: Vec<FileInfo>,
}

/// The part of `summary.json` that is read first: not every verdict comes with bounds.
#[derive(Deserialize)]
struct WrittenVerdict {
    verdict: String,
}

/// The part of `summary.json` that is read back.
#[derive(Deserialize)]
struct Written {
    parameters: BTreeMap<String, WrittenBounds>,
    #[serde(default)]
    assumptions: Vec<String>,
}

#[derive(Deserialize)]
struct WrittenBounds {
    lo: Number,
    hi: Number,
}

impl Start {
    /// Reads the results in the folder `path`.
    ///
    /// *Errors*: `E0401` when a file cannot be read, `E0504` when it is no result or the folder holds
    /// no complete one, `E0505` when it does not fit the model or the run proved the model
    /// inconsistent.
    pub fn read(path: impl AsRef<Path>, model: &Model) -> Result<Start, Diagnostic> {
        let folder = path.as_ref();
        let (params, assumptions, summary) = read_summary(folder, model)?;
        let mut files = vec![summary];
        let boxes = folder.join("boxes.csv");
        let boxes = if boxes.is_file() {
            let (boxes, table) = read_boxes(&boxes, model)?;
            files.push(table);
            boxes
        } else {
            Vec::new()
        };
        Ok(Start {
            params,
            boxes,
            assumptions,
            files,
        })
    }
}

type ReadSummary = (Vec<Interval>, Vec<String>, FileInfo);

fn read_summary(folder: &Path, model: &Model) -> Result<ReadSummary, Diagnostic> {
    let path = folder.join("summary.json");
    let name = path.display().to_string();
    let text = fs::read_to_string(&path).map_err(|error| {
        if error.kind() == io::ErrorKind::NotFound && folder.is_dir() {
            let message = format!(
                "`{}` holds no complete results: it has no summary.json",
                folder.display()
            );
            return Diagnostic::new("E0504", message)
                .help("run the earlier observation again, or name the folder of another one");
        }
        failure::unreadable(&name, &error)
            .help("name the folder that an earlier run wrote with `-o DIR`")
    })?;
    let no_json = |error| no_json(&name, &text, &error);
    let written: WrittenVerdict = serde_json::from_str(&text).map_err(no_json)?;
    if written.verdict == "inconsistent" {
        let message =
            format!("the run in `{name}` proved the model inconsistent: it left no parameters");
        return Err(
            Diagnostic::new("E0505", message).help("start from a run that ended consistent")
        );
    }
    let written: Written = serde_json::from_str(&text).map_err(no_json)?;
    let mut params = Vec::with_capacity(model.params.len());
    for param in &model.params {
        let bounds = written.parameters.get(&param.name);
        let bounds = bounds.ok_or_else(|| not_of_this_model(&name, &param.name))?;
        let ends = (bounds.lo.decimal(), bounds.hi.decimal());
        params.push(enclose(ends).ok_or_else(|| reversed(&name, &param.name))?);
    }
    Ok((params, written.assumptions, FileInfo::of_text(&path, &text)))
}

fn read_boxes(path: &Path, model: &Model) -> Result<(Vec<Vec<Interval>>, FileInfo), Diagnostic> {
    let name = path.display().to_string();
    let mut table = TableReader::open(path).map_err(no_result)?;
    let mut places = Vec::with_capacity(model.params.len());
    for param in &model.params {
        let column = |end| table.column(&format!("{}.{end}", param.name));
        let pair = column("lo").zip(column("hi"));
        places.push(pair.ok_or_else(|| not_of_this_model(&name, &param.name))?);
    }
    let mut last_time: Option<Decimal> = None;
    let mut boxes = Vec::new();
    while let Some(row) = table.next_row().map_err(no_result)? {
        let time = number(row, 0)?;
        // Only the boxes of the last sample describe the end of the run.
        if last_time.as_ref().is_none_or(|last| *last != time) {
            boxes.clear();
        }
        last_time = Some(time);
        let mut one = Vec::with_capacity(places.len());
        for ((lo, hi), param) in places.iter().zip(&model.params) {
            let ends = (end(row, *lo, "-inf")?, end(row, *hi, "inf")?);
            one.push(enclose(ends).ok_or_else(|| reversed(&name, &param.name))?);
        }
        boxes.push(one);
    }
    let table = FileInfo {
        path: name,
        sha256: table.sha256(),
    };
    Ok((boxes, table))
}

fn number(row: TableRow<'_>, at: usize) -> Result<Decimal, Diagnostic> {
    let text = row.field(at);
    Decimal::parse(&text).map_err(|_| {
        let problem = Diagnostic::new("E0504", format!("`{text}` is no number"));
        row.mark(problem, at, "written by no run of this program")
            .help("run the earlier observation again")
    })
}

/// A printed end; `None` where it is `infinite`.
fn end(row: TableRow<'_>, at: usize, infinite: &str) -> Result<Option<Decimal>, Diagnostic> {
    if row.field(at) == infinite {
        Ok(None)
    } else {
        number(row, at).map(Some)
    }
}

/// A table that this program did not write.
fn no_result(mut problem: Diagnostic) -> Diagnostic {
    if problem.code != "E0401" {
        problem.code = "E0504";
    }
    problem.help("run the earlier observation again")
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
