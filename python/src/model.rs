//! Models.

use crate::problem::raise;
use crate::table::ends;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::path::PathBuf;
use std::sync::Arc;
use veribound::program::check;
use veribound_interval::Interval;
use veribound_model::Model;

/// A model.
#[pyclass(frozen, name = "Model", module = "veribound._veribound")]
pub struct PyModel(pub Arc<Model>);

impl PyModel {
    pub fn new(model: Model) -> PyModel {
        PyModel(Arc::new(model))
    }
}

#[pymethods]
impl PyModel {
    /// Reads a model file.
    #[staticmethod]
    fn from_file(py: Python<'_>, path: PathBuf) -> PyResult<PyModel> {
        let model = py.detach(|| Model::from_file(path)).map_err(raise)?;
        Ok(PyModel::new(model))
    }

    /// Reads the text of a model file.
    #[staticmethod]
    fn from_text(py: Python<'_>, name: &str, text: &str) -> PyResult<PyModel> {
        let model = py.detach(|| Model::from_text(name, text)).map_err(raise)?;
        Ok(PyModel::new(model))
    }

    /// The name that the model gives itself.
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    /// The path or name under which messages show its text.
    #[getter]
    fn source(&self) -> &str {
        &self.0.source.name
    }

    /// The text of the model file.
    fn to_toml(&self) -> &str {
        self.0.to_toml()
    }

    /// What was understood, and how its solutions will be enclosed.
    fn check(&self, py: Python<'_>) -> String {
        py.detach(|| check::told(&self.0))
    }

    /// The quantities of a kind, as `{name, unit, bounds, ...}`.
    fn quantities<'py>(&self, py: Python<'py>, kind: &str) -> PyResult<Bound<'py, PyList>> {
        let list = PyList::empty(py);
        let push = |name: &str, unit: &str, bounds: Option<Interval>| {
            let entry = PyDict::new(py);
            entry.set_item("name", name)?;
            entry.set_item("unit", unit)?;
            entry.set_item("bounds", bounds.map(ends))?;
            list.append(entry)
        };
        let model = &*self.0;
        match kind {
            "states" => {
                for state in &model.states {
                    push(&state.name, &state.unit, Some(state.init))?;
                }
            }
            "params" => {
                for param in &model.params {
                    push(&param.name, &param.unit, Some(param.bounds))?;
                }
            }
            "inputs" => {
                for input in model.recorded_inputs() {
                    push(&input.name, &input.unit, None)?;
                }
            }
            "disturbances" => {
                for (input, bounds) in model.disturbances() {
                    push(&input.name, &input.unit, Some(bounds))?;
                }
            }
            "outputs" => {
                for output in &model.outputs {
                    push(&output.name, &output.unit, None)?;
                }
            }
            "signals" => {
                for signal in &model.signals {
                    push(&signal.name, "", None)?;
                }
            }
            _ => {
                for mode in &model.modes {
                    push(&mode.name, "", None)?;
                }
            }
        }
        Ok(list)
    }
}
