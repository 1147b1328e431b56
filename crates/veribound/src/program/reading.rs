//! Records that a run reads, and what is said of them.

use super::arguments::Reading;
use super::message;
use super::numbers::show_time;
use veribound_data::{Record, RecordOptions, TableSource};
use veribound_model::diagnostic::Diagnostics;
use veribound_model::{Coverage, Model};

/// Opens a record as the flags say; tells `watch` how many bytes of it have been checked.
pub fn open(
    source: TableSource,
    model: &Model,
    reading: &Reading,
    watch: &mut dyn FnMut(u64),
) -> Result<Record, Diagnostics> {
    let columns = reading.column.iter();
    let options = RecordOptions {
        time: reading.time.clone(),
        columns: columns
            .map(|flag| (flag.variable.clone(), flag.column.clone()))
            .collect(),
        from: reading.from.clone(),
        to: reading.to.clone(),
    };
    Record::open_watched(source, model, options, watch)
}

/// What a run with these records assumes beside the model file and the flags that weaken it.
pub fn assumed(model: &Model, records: &[Record], reading: &Reading) -> Vec<String> {
    let mut said = Vec::new();
    for record in records {
        said.extend(record.conversions().iter().cloned());
        said.extend(record.warnings().iter().cloned());
        if let Some(from) = &reading.from {
            said.push(format!(
                "the start intervals of the model file hold at t = {} s, the first sample from {from} s on \
                 (--from)",
                show_time(record.first())
            ));
        }
    }
    // Records of one kind are converted alike.
    let mut known = std::collections::BTreeSet::new();
    said.retain(|change| known.insert(change.clone()));
    if let Coverage::Unproved(place) = &model.coverage {
        said.push(format!(
            "the guards of the modes leave no gap, which is not proved: {place}"
        ));
    }
    said
}

/// Says what a reader of the results should know. Numbers in other units are a likely mistake and
/// never kept back.
pub fn remarks(records: &[Record], said: &[String], quiet: bool) {
    for change in said {
        let mut warnings = records.iter().flat_map(|record| record.warnings());
        if warnings.any(|warning| warning == change) {
            message::remark(&format!("warning: {change}"));
        } else if !quiet {
            message::remark(&format!("note: {change}"));
        }
    }
    if !quiet {
        let notes = notes(records);
        notes
            .iter()
            .for_each(|note| message::remark(&format!("note: {note}")));
    }
}

/// What records have that results do not tell: missing values, columns that are not used, likely slips.
pub fn notes(records: &[Record]) -> Vec<String> {
    let mut notes = Vec::new();
    for record in records {
        let of = match records {
            [_] => String::new(),
            _ => format!("{}: ", record.path().display()),
        };
        if let Some(hint) = record.hint() {
            notes.push(format!("{of}{hint}"));
        }
        for (name, count) in record.missing() {
            let values = if *count == 1 { "value" } else { "values" };
            notes.push(format!("{of}{name}: {count} {values} missing"));
        }
        let ignored = record.ignored_columns();
        if !ignored.is_empty() {
            notes.push(format!("{of}columns not used: {}", ignored.join(", ")));
        }
    }
    notes
}
