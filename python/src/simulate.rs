//! Simulated records.

use crate::model::PyModel;
use crate::problem::{misuse, raise};
use crate::source::Source;
use crate::watch::{Standing, Watch, watched};
use crate::words;
use pyo3::prelude::*;
use veribound::program::arguments::{Command, Simulate};
use veribound::program::progress::PARTS;
use veribound::program::simulate::{Prepared, asks_for_forms, refuse_flags};
use veribound_data::TableSource;
use veribound_model::Model;
use veribound_model::diagnostic::Diagnostics;

/// A simulated record.
#[pyclass(frozen, module = "veribound._veribound")]
pub struct Simulated {
    /// The text of the record (CSV).
    #[pyo3(get)]
    text: String,
    /// What the user should know.
    #[pyo3(get)]
    notes: Vec<String>,
    /// Whether it was ended early, so that there is no whole record.
    #[pyo3(get)]
    interrupted: bool,
    /// Whether Ctrl-C was pressed.
    #[pyo3(get)]
    asked_to_end: bool,
}

/// Makes a record with the options of the program.
#[pyfunction]
#[pyo3(signature = (model, inputs, words, progress))]
pub fn simulate(
    py: Python<'_>,
    model: PyRef<'_, PyModel>,
    inputs: Option<PyRef<'_, Source>>,
    words: Vec<String>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Simulated> {
    let Command::Simulate(arguments) = words::parse(&words)? else {
        return Err(misuse("this is no simulation"));
    };
    let model = std::sync::Arc::clone(&model.0);
    let inputs = inputs.map(|inputs| inputs.0.clone());
    let work = |watch: &Watch| work(&arguments, &model, inputs, watch);
    let (done, asked_to_end) = watched(py, progress.as_ref(), work)?;
    let (text, notes, is_whole) = done.map_err(raise)?;
    Ok(Simulated {
        text,
        notes,
        interrupted: !is_whole,
        asked_to_end,
    })
}

fn work(
    arguments: &Simulate,
    model: &Model,
    inputs: Option<TableSource>,
    watch: &Watch,
) -> Result<(String, Vec<String>, bool), Diagnostics> {
    refuse_flags(arguments)?;
    let prepared = Prepared::new(arguments, model, inputs)?;
    let mut text = String::new();
    let go_on = |part| {
        watch.tell(Standing {
            done: part,
            whole: PARTS,
            text: "simulated".to_owned(),
        });
        watch.goes_on()
    };
    let mut attempt = |with_forms: bool| {
        text.clear();
        let mut take = |line: &str| {
            text.push_str(line);
            Ok(())
        };
        prepared.carry_out(arguments, with_forms, &mut take, &go_on)
    };
    let samples = match attempt(false) {
        Err(problems) if asks_for_forms(&problems) => attempt(true)?,
        done => done?,
    };
    Ok((text, prepared.notes, samples.is_some()))
}
