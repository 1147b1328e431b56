//! Observations of whole records.

use crate::model::PyModel;
use crate::problem::{misuse, raise, shown};
use crate::source::Source;
use crate::table::{Bands, Told, Words, floats, seconds};
use crate::watch::{Standing, Watch, watched};
use crate::words;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyList};
use veribound::program::arguments::{Command, Observe};
use veribound::program::ending::Ending;
use veribound::program::files::{joined, mode_names};
use veribound::program::observe::{Done, Prepared, refuse_flags};
use veribound::program::{table, verdict};
use veribound_data::TableSource;
use veribound_estimate::Estimate;
use veribound_interval::Interval;
use veribound_model::diagnostic::Diagnostics;
use veribound_model::{Model, Sample};

/// What was proved after every sample.
struct Trace {
    times: Vec<f64>,
    states: Bands,
    params: Bands,
    outputs: Bands,
    measured: Bands,
    modes: Words,
    resets: Words,
    boxes: Vec<f64>,
}

impl Trace {
    fn of(model: &Model) -> Trace {
        Trace {
            times: Vec::new(),
            states: Bands::new(model.states.len()),
            params: Bands::new(model.params.len()),
            outputs: Bands::new(model.outputs.len()),
            measured: Bands::new(model.outputs.len()),
            modes: Words::default(),
            resets: Words::default(),
            boxes: Vec::new(),
        }
    }

    fn push(&mut self, model: &Model, sample: &Sample, estimate: &Estimate) {
        self.times.push(seconds(&sample.time));
        self.states.push(&estimate.states);
        self.params.push(&estimate.params);
        self.outputs.push(&estimate.outputs);
        self.measured.push_some(&sample.outputs);
        self.modes.push(mode_names(model, estimate.modes));
        let names = model.params.iter().zip(&estimate.resets);
        let reset = names.filter(|(_, is_reset)| **is_reset);
        self.resets
            .push(joined(reset.map(|(param, _)| param.name.as_str())));
        self.boxes.push(estimate.boxes as f64);
    }
}

/// An observation that is done.
#[pyclass(frozen, module = "veribound._veribound")]
pub struct Observed {
    done: Done,
    trace: Trace,
    said: Vec<String>,
    asked_to_end: bool,
}

/// Observes a record with the options of the program.
#[pyfunction]
#[pyo3(signature = (model, record, words, wants_files, progress))]
pub fn observe(
    py: Python<'_>,
    model: PyRef<'_, PyModel>,
    record: PyRef<'_, Source>,
    words: Vec<String>,
    wants_files: bool,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Observed> {
    let Command::Observe(mut arguments) = words::parse(&words)? else {
        return Err(misuse("this is no observation"));
    };
    arguments.words = words::told(words);
    let (model, record) = (Model::clone(&model.0), record.0.clone());
    let work = |watch: &Watch| work(&arguments, model, record, wants_files, watch);
    let (done, asked_to_end) = watched(py, progress.as_ref(), work)?;
    let (done, trace, said) = done.map_err(raise)?;
    Ok(Observed {
        done,
        trace,
        said,
        asked_to_end,
    })
}

fn work(
    arguments: &Observe,
    model: Model,
    record: TableSource,
    wants_files: bool,
    watch: &Watch,
) -> Result<(Done, Trace, Vec<String>), Diagnostics> {
    if wants_files {
        refuse_flags(arguments)?;
    }
    let whole = record.bytes();
    let mut tell = |bytes| {
        watch.tell(Standing {
            done: bytes,
            whole,
            text: "of the record checked".to_owned(),
        });
    };
    let prepared = Prepared::new(arguments, model, record, &mut tell)?;
    let said = prepared.said.clone();
    let model = prepared.model.clone();
    let whole = prepared.record.len() as u64;
    let mut trace = Trace::of(&model);
    let mut each = |sample: &Sample, estimate: &Estimate| {
        trace.push(&model, sample, estimate);
        watch.tell(Standing {
            done: trace.times.len() as u64,
            whole,
            text: "samples".to_owned(),
        });
    };
    let done = prepared.carry_out(arguments, wants_files, &mut each, &|| watch.goes_on())?;
    Ok((done, trace, said))
}

#[pymethods]
impl Observed {
    /// Whether Ctrl-C was pressed.
    #[getter]
    fn asked_to_end(&self) -> bool {
        self.asked_to_end
    }

    /// "consistent", "inconsistent" or "undecided".
    #[getter]
    fn verdict(&self) -> &str {
        let (verdict, _) = verdict::in_words(&self.done.model, &self.done.found);
        verdict.name()
    }

    /// Why it is not consistent, as the program tells it.
    #[getter]
    fn message(&self, py: Python<'_>) -> Option<String> {
        let Done {
            model,
            record,
            found,
            ..
        } = &self.done;
        py.detach(|| verdict::problem(model, record, found).map(shown))
    }

    /// What is assumed beside the model file.
    #[getter]
    fn assumptions(&self) -> Vec<String> {
        self.said.clone()
    }

    /// What a user should know of the record.
    #[getter]
    fn notes(&self) -> Vec<String> {
        veribound::program::reading::notes(std::slice::from_ref(&self.done.record))
    }

    /// Whether the run ended before the record did, at the user's wish.
    #[getter]
    fn interrupted(&self) -> bool {
        self.done.found.ending == Ending::Interrupted
    }

    /// `summary.json`.
    #[getter]
    fn json(&self) -> &str {
        &self.done.json
    }

    /// The table that the program prints.
    fn table(&self) -> String {
        table::bounds(&self.done.model, &self.done.record, &self.done.found)
    }

    /// Time stamps in seconds, as bytes of floats.
    fn times<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        floats(py, self.trace.times.iter().copied())
    }

    /// Number of boxes after every sample, as bytes of floats.
    fn box_counts<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        floats(py, self.trace.boxes.iter().copied())
    }

    /// Bounds over time: "states", "params", "outputs" or "measured".
    fn bands<'py>(&self, py: Python<'py>, kind: &str) -> PyResult<Bound<'py, PyList>> {
        let (model, trace) = (&self.done.model, &self.trace);
        let outputs = || model.outputs.iter().map(|output| output.name.as_str());
        match kind {
            "states" => {
                let names = model.states.iter().map(|state| state.name.as_str());
                trace.states.to_python(py, names)
            }
            "params" => {
                let names = model.params.iter().map(|param| param.name.as_str());
                trace.params.to_python(py, names)
            }
            "outputs" => trace.outputs.to_python(py, outputs()),
            _ => trace.measured.to_python(py, outputs()),
        }
    }

    /// Texts over time: "modes" or "resets".
    fn words<'py>(&self, py: Python<'py>, kind: &str) -> (Vec<String>, Bound<'py, PyBytes>) {
        match kind {
            "modes" => self.trace.modes.to_python(py),
            _ => self.trace.resets.to_python(py),
        }
    }

    /// The boxes that are left: states, then parameters, each `(name, bytes, bytes)`; the names of their modes.
    fn boxes<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyList>, Vec<String>)> {
        let Done { model, cells, .. } = &self.done;
        let states = model.states.iter().map(|state| state.name.as_str());
        let names = states.chain(model.params.iter().map(|param| param.name.as_str()));
        let mut bands = Bands::new(model.states.len() + model.params.len());
        cells.iter().for_each(|cell| bands.push(&cell.z));
        let modes = cells.iter().map(|cell| mode_names(model, cell.modes));
        Ok((bands.to_python(py, names)?, modes.collect()))
    }

    /// Bounds at the end: parameters, or states; empty ones of a refuted model.
    fn bounds<'py>(&self, py: Python<'py>, kind: &str) -> PyResult<Bound<'py, PyList>> {
        let Done { model, found, .. } = &self.done;
        let last = found.last.as_ref().map(|(_, estimate)| estimate);
        let known = |bounds: Option<&Interval>, before: Interval| {
            if found.refutation.is_some() {
                Interval::EMPTY
            } else {
                bounds.copied().unwrap_or(before)
            }
        };
        let list = PyList::empty(py);
        if kind == "params" {
            for (at, param) in model.params.iter().enumerate() {
                let told = Told {
                    name: &param.name,
                    unit: &param.unit,
                    prior: Some(param.bounds),
                    bounds: known(last.and_then(|last| last.params.get(at)), param.bounds),
                };
                list.append(told.to_python(py)?)?;
            }
            return Ok(list);
        }
        for (at, state) in model.states.iter().enumerate() {
            let told = Told {
                name: &state.name,
                unit: &state.unit,
                prior: None,
                bounds: known(last.and_then(|last| last.states.get(at)), state.init),
            };
            list.append(told.to_python(py)?)?;
        }
        Ok(list)
    }
}
