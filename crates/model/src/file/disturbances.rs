//! The section [disturbances]: unknown functions of time inside bounds.

use crate::file::constants;
use crate::file::quantities::unit;
use crate::file::reader::{Reader, Table};
use crate::file::scope::{Meaning, Scope};
use crate::model::{ErrorBound, Hold, Input};
use toml::de::DeValue;
use veribound_interval::{Decimal, Interval};

/// Adds every disturbance behind the inputs: to the equations it is one, which no column measures.
pub(crate) fn disturbances(
    reader: &mut Reader,
    file: &Table,
    scope: &mut Scope,
    inputs: &mut Vec<Input>,
) {
    let Some(section) = file.find("disturbances") else {
        return;
    };
    let help = "write [disturbances] with lines like wind = [-0.5, 0.5]";
    let Some(table) = reader.table(section.value, section.place.clone(), help) else {
        scope.is_incomplete = true;
        return;
    };
    for entry in &table.entries {
        let meaning = Meaning::Input(inputs.len());
        scope.declare(reader, entry.key, entry.place.clone(), meaning);
        let what = format!("the range of `{}`", entry.key);
        let mut own_unit = String::new();
        let mut hold = Hold::Free;
        let bounds = if matches!(entry.value.value, DeValue::Table(_)) {
            let table = reader.table(entry.value, entry.place.clone(), help);
            table.and_then(|table| {
                reader.allow(&table, &["unit", "bounds", "hold"], "a disturbance");
                hold = held(reader, &table);
                own_unit = unit(reader, &table);
                let bounds = table.value("bounds");
                if bounds.is_none() {
                    reader.report(
                        "E0109",
                        format!("the disturbance `{}` has no bounds", entry.key),
                        table.place.clone(),
                        "which values are possible?",
                        "write bounds = [lower, upper]",
                    );
                }
                constants::range(reader, bounds?, &what)
            })
        } else {
            constants::range(reader, entry.value, &what)
        };
        let bounds = bounds.unwrap_or(Interval::ZERO);
        inputs.push(Input {
            name: entry.key.to_string(),
            unit: own_unit,
            column: None,
            error: ErrorBound {
                absolute: Decimal::zero(),
                relative: Decimal::zero(),
            },
            domain: Some(bounds),
            within: Some(bounds),
            hold,
        });
    }
}

/// Whether the disturbance says `hold = "sample"`.
fn held(reader: &mut Reader, table: &Table) -> Hold {
    let help = "write hold = \"sample\" for a value that is constant from each sample to the next, \
                or leave it out for any function of time";
    let Some(value) = table.value("hold") else {
        return Hold::Free;
    };
    let Some(text) = reader.string(value, help) else {
        return Hold::Free;
    };
    if text.value != "sample" {
        let message = format!("there is no hold `{}`", text.value);
        reader.report("E0107", message, text.range, "unknown", help);
    }
    Hold::Sample
}
