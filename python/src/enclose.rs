//! Enclosures of all solutions.

use crate::model::PyModel;
use crate::problem::{misuse, raise};
use crate::source::Source;
use crate::table::{Bands, Told, Words, floats, seconds};
use crate::watch::{Standing, Watch, watched};
use crate::words;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyList};
use veribound::program::arguments::{Command, Enclose};
use veribound::program::enclose::files::mode_names;
use veribound::program::enclose::{Done, Prepared, in_words, refuse_flags, told};
use veribound::program::ending::Ending;
use veribound_data::TableSource;
use veribound_flow::form;
use veribound_model::Model;
use veribound_model::diagnostic::Diagnostics;

/// An enclosure that is done.
#[pyclass(frozen, module = "veribound._veribound")]
pub struct Enclosed {
    done: Done,
    said: Vec<String>,
    json: String,
    asked_to_end: bool,
}

/// Encloses all solutions with the options of the program.
#[pyfunction]
#[pyo3(signature = (model, inputs, words, wants_files, progress))]
pub fn enclose(
    py: Python<'_>,
    model: PyRef<'_, PyModel>,
    inputs: Option<PyRef<'_, Source>>,
    words: Vec<String>,
    wants_files: bool,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Enclosed> {
    let Command::Enclose(mut arguments) = words::parse(&words)? else {
        return Err(misuse("this is no enclosure"));
    };
    arguments.words = words::told(words);
    let model = Model::clone(&model.0);
    let inputs = inputs.map(|inputs| inputs.0.clone());
    let work = |watch: &Watch| work(&arguments, model, inputs, wants_files, watch);
    let (done, asked_to_end) = watched(py, progress.as_ref(), work)?;
    let (done, said, json) = done.map_err(raise)?;
    Ok(Enclosed {
        done,
        said,
        json,
        asked_to_end,
    })
}

fn work(
    arguments: &Enclose,
    model: Model,
    inputs: Option<TableSource>,
    wants_files: bool,
    watch: &Watch,
) -> Result<(Done, Vec<String>, String), Diagnostics> {
    if wants_files {
        refuse_flags(arguments)?;
    }
    let prepared = Prepared::new(arguments, model, inputs)?;
    let said = prepared.said.clone();
    let first = prepared.first();
    let go_on = |standing: form::Standing| {
        watch.tell(Standing {
            done: standing.done as u64,
            whole: 0,
            text: in_words(standing, first),
        });
        watch.goes_on()
    };
    let done = prepared.carry_out(arguments, wants_files, &go_on)?;
    let json = done.summary.to_json()?;
    Ok((done, said, json))
}

#[pymethods]
impl Enclosed {
    /// Whether Ctrl-C was pressed.
    #[getter]
    fn asked_to_end(&self) -> bool {
        self.asked_to_end
    }

    /// "proved" to the end, or "undecided" from the last time on.
    #[getter]
    fn verdict(&self) -> &str {
        match self.done.found.ending {
            Ending::Done => "proved",
            _ => "undecided",
        }
    }

    /// Why it ended early, and which widths are past use.
    #[getter]
    fn message(&self) -> Option<String> {
        let Done {
            model,
            times,
            found,
            ..
        } = &self.done;
        let told = told::remarks(model, times, found).join("\n");
        (!told.is_empty()).then_some(told)
    }

    /// What is assumed beside the model file.
    #[getter]
    fn assumptions(&self) -> Vec<String> {
        self.said.clone()
    }

    /// Nothing: no record was read.
    #[getter]
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }

    /// Whether the run ended early, at the user's wish.
    #[getter]
    fn interrupted(&self) -> bool {
        self.done.found.ending == Ending::Interrupted
    }

    /// `summary.json`.
    #[getter]
    fn json(&self) -> &str {
        &self.json
    }

    /// The table that the program prints.
    fn table(&self) -> String {
        let Done {
            model,
            times,
            found,
            summary,
        } = &self.done;
        told::bounds(model, times, (found, summary))
    }

    /// Time stamps in seconds, as bytes of floats.
    fn times<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        floats(py, self.done.times.iter().map(seconds))
    }

    /// Bounds over time: "states" or "outputs" at the times, "states_since" or "outputs_since" the time before.
    fn bands<'py>(&self, py: Python<'py>, kind: &str) -> PyResult<Bound<'py, PyList>> {
        let Done { model, found, .. } = &self.done;
        let is_of_states = kind.starts_with("states");
        let count = if is_of_states {
            model.states.len()
        } else {
            model.outputs.len()
        };
        let mut bands = Bands::new(count);
        let start = found.start();
        for number in 0..found.rows {
            let row = found.row(&start, number);
            bands.push(match kind {
                "states" => row.states,
                "states_since" => row.states_since,
                "outputs" => &row.outputs,
                _ => &row.outputs_since,
            });
        }
        if is_of_states {
            let names = model.states.iter().map(|state| state.name.as_str());
            bands.to_python(py, names)
        } else {
            let names = model.outputs.iter().map(|output| output.name.as_str());
            bands.to_python(py, names)
        }
    }

    /// Modes that may have acted since the time before.
    fn words<'py>(&self, py: Python<'py>, _kind: &str) -> (Vec<String>, Bound<'py, PyBytes>) {
        let Done { model, found, .. } = &self.done;
        let start = found.start();
        let mut modes = Words::default();
        for number in 0..found.rows {
            modes.push(mode_names(model, found.row(&start, number).modes));
        }
        modes.to_python(py)
    }

    /// Ranges of states, or of outputs: at the last time, and "always".
    fn bounds<'py>(&self, py: Python<'py>, kind: &str) -> PyResult<Bound<'py, PyList>> {
        let Done { model, found, .. } = &self.done;
        let [states, outputs] = found.ranges();
        let list = PyList::empty(py);
        let known: Vec<_> = if kind == "states" {
            let all = model.states.iter().zip(states);
            all.map(|(state, range)| (&state.name, &state.unit, Some(state.init), range))
                .collect()
        } else {
            let all = model.outputs.iter().zip(outputs);
            all.map(|(output, range)| (&output.name, &output.unit, None, range))
                .collect()
        };
        for (name, unit, prior, (bounds, always)) in known {
            let told = Told {
                name,
                unit,
                prior,
                bounds,
            };
            let entry = told.to_python(py)?;
            entry.set_item("always", crate::table::ends(always))?;
            entry.set_item("always_shown", veribound::program::numbers::show(always))?;
            entry.set_item("shown", veribound::program::numbers::show(bounds))?;
            list.append(entry)?;
        }
        Ok(list)
    }
}
