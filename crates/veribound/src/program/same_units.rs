//! What is simulated is in the units of the model: what says otherwise is refused.

use veribound_data::Record;
use veribound_model::Model;
use veribound_model::diagnostic::Diagnostic;
use veribound_model::units::Unit;

/// The record to be repeats the numbers of the profile as they are written.
pub fn of_profile(record: &Record) -> Result<(), Diagnostic> {
    match record.conversions().first() {
        None => Ok(()),
        Some(conversion) => Err(Diagnostic::new(
            "E0608",
            format!("the profile is not in the units of the model: {conversion}"),
        )
        .help("write the profile in the units of the model")),
    }
}

/// The model may name columns of a measured record, which can be in other units.
pub fn of_columns(model: &Model) -> Result<(), Diagnostic> {
    let inputs = model.inputs.iter().map(|x| (&x.column, &x.unit));
    let outputs = model.outputs.iter().map(|y| (&y.column, &y.unit));
    for (column, unit) in inputs.chain(outputs) {
        let Some(column) = column else { continue };
        let Some((_, written)) = column.rsplit_once('[') else {
            continue;
        };
        let written = Unit::parse(written.trim_end().trim_end_matches(']'));
        let conversion = written
            .zip(Unit::parse(unit))
            .and_then(|(written, unit)| written.conversion_to(&unit));
        if conversion.is_some_and(|conversion| !conversion.factor().is_one()) {
            let message = format!(
                "the column `{column}` is not in {unit}, the unit of the model and of simulated records"
            );
            return Err(Diagnostic::new("E0608", message)
                .help("write the name of the column without its unit into the model file"));
        }
    }
    Ok(())
}
