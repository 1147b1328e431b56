//! Parameters of an earlier run, to be shown behind those of this one.

use std::path::Path;
use veribound_data::{FileInfo, TableReader};
use veribound_interval::Decimal;
use veribound_model::Model;
use veribound_model::diagnostic::Diagnostic;
use veribound_report::{FigureMeta, History, SampleRow};

/// Reads `params.csv` of the run in `folder`. The numbers are for a figure; nothing is proved with
/// them.
///
/// *Errors*: `E0605` when there is no such table, or it does not have the model's parameters.
pub fn read(
    folder: &Path,
    model: &Model,
    meta: &FigureMeta,
) -> Result<(History, FileInfo), Diagnostic> {
    let path = folder.join("params.csv");
    let refuse = |what: String| {
        no_table(Diagnostic::new(
            "E0605",
            format!("cannot show `{}`: {what}", path.display()),
        ))
    };
    let mut table = TableReader::open(&path).map_err(no_table)?;
    let mut places = Vec::new();
    for param in &model.params {
        let column = |end| table.column(&format!("{}.{end}", param.name));
        let missing = || {
            refuse(format!(
                "it has no bounds of the parameter `{}`",
                param.name
            ))
        };
        places.push(column("lo").zip(column("hi")).ok_or_else(missing)?);
    }
    let label = folder
        .file_name()
        .map(|name| name.to_string_lossy().into_owned());
    let mut history = History::new(FigureMeta {
        label: label.unwrap_or_else(|| folder.display().to_string()),
        params: meta.params.clone(),
        time_unit: meta.time_unit.clone(),
        ..FigureMeta::default()
    });
    while let Some(row) = table.next_row().map_err(no_table)? {
        let number = |at: usize| match row.field(at).as_ref() {
            "-inf" => Some(f64::NEG_INFINITY),
            "inf" => Some(f64::INFINITY),
            text => Decimal::parse(text)
                .ok()
                .map(|decimal| decimal.to_interval().mid()),
        };
        let bounds = places.iter().map(|(lo, hi)| number(*lo).zip(number(*hi)));
        let bounds: Option<Vec<(f64, f64)>> = bounds.collect();
        let Some((t, params)) = number(0).zip(bounds) else {
            return Err(refuse(format!("line {} is not complete", row.line())));
        };
        history
            .push(&SampleRow {
                t,
                params: &params,
                ..SampleRow::default()
            })
            .map_err(|error| refuse(error.to_string()))?;
    }
    let file = FileInfo {
        path: path.display().to_string(),
        sha256: table.sha256(),
    };
    Ok((history, file))
}

/// A table that cannot be shown.
fn no_table(mut problem: Diagnostic) -> Diagnostic {
    problem.code = "E0605";
    problem.help("name the folder that an earlier run of this model wrote with `-o DIR`")
}
