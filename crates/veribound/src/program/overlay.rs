//! Parameters of an earlier run, to be shown behind those of this one.

use std::path::Path;
use veribound_interval::Decimal;
use veribound_model::Model;
use veribound_model::diagnostic::Diagnostic;
use veribound_report::{FigureMeta, History, SampleRow};

/// Reads `params.csv` of the run in `folder`. The numbers are for a figure; nothing is proved with
/// them.
///
/// *Errors*: `E0605` when there is no such table, or it does not have the model's parameters.
pub fn read(folder: &Path, model: &Model, meta: &FigureMeta) -> Result<History, Diagnostic> {
    let path = folder.join("params.csv");
    let refuse = |what: String| {
        Diagnostic::new("E0605", format!("cannot show `{}`: {what}", path.display()))
            .help("name the folder that an earlier run of this model wrote with `-o DIR`")
    };
    let mut table = csv::Reader::from_path(&path).map_err(|error| refuse(error.to_string()))?;
    let header = table
        .headers()
        .map_err(|error| refuse(error.to_string()))?
        .clone();
    let column = |name: &str| header.iter().position(|known| known == name);
    let mut places = Vec::new();
    for param in &model.params {
        let lo = column(&format!("{}.lo", param.name));
        let hi = column(&format!("{}.hi", param.name));
        let missing = || {
            refuse(format!(
                "it has no bounds of the parameter `{}`",
                param.name
            ))
        };
        places.push(lo.zip(hi).ok_or_else(missing)?);
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
    for row in table.records() {
        let row = row.map_err(|error| refuse(error.to_string()))?;
        let number = |at: usize| {
            let text = row.get(at).unwrap_or_default();
            match text {
                "-inf" => Some(f64::NEG_INFINITY),
                "inf" => Some(f64::INFINITY),
                _ => Decimal::parse(text)
                    .ok()
                    .map(|decimal| decimal.to_interval().mid()),
            }
        };
        let bounds = places.iter().map(|(lo, hi)| number(*lo).zip(number(*hi)));
        let bounds: Option<Vec<(f64, f64)>> = bounds.collect();
        let Some((t, params)) = number(0).zip(bounds) else {
            return Err(refuse("a row of it is not complete".to_owned()));
        };
        history
            .push(&SampleRow {
                t,
                params: &params,
                ..SampleRow::default()
            })
            .map_err(|error| refuse(error.to_string()))?;
    }
    Ok(history)
}
