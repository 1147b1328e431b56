//! The observer, sample by sample, for data that arrive while the machine runs.

use crate::model::PyModel;
use crate::problem::misuse;
use crate::source::float;
use crate::table::{Told, ends};
use crate::words;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFloat, PyList, PyString};
use std::sync::Arc;
use std::time::Instant;
use veribound::program::arguments::Command;
use veribound::program::assumptions;
use veribound::program::files::mode_names;
use veribound::program::verdict::{NOTHING_EXPLAINS, not_decided_at, refuted_at, stopped};
use veribound_estimate::{Estimate, Observer, Verdict};
use veribound_interval::{Decimal, Interval};
use veribound_model::{Model, Sample};

/// The observer of a stream of samples.
#[pyclass(module = "veribound._veribound", subclass)]
pub struct Stepper {
    model: Arc<Model>,
    observer: Observer,
    samples: usize,
    exact: bool,
    assumptions: Vec<String>,
}

/// What is known after a sample.
#[pyclass(frozen, module = "veribound._veribound")]
pub struct Step {
    model: Arc<Model>,
    /// Time of the sample, in seconds.
    #[pyo3(get)]
    t: f64,
    /// What the step took in Rust, in nanoseconds.
    #[pyo3(get)]
    nanoseconds: u64,
    outcome: Verdict,
}

/// A number that Python gave.
enum Given {
    Missing,
    Number(Interval),
}

#[pymethods]
impl Stepper {
    /// An observer of `model` with the options of the program.
    #[new]
    fn new(model: PyRef<'_, PyModel>, words: Vec<String>, exact: bool) -> PyResult<Stepper> {
        let Command::Observe(arguments) = words::parse(&words)? else {
            return Err(misuse("this is no observation"));
        };
        let mut model = Model::clone(&model.0);
        let weakening = &arguments.assumptions.weakening;
        let assumptions =
            assumptions::weaken(&mut model, weakening).map_err(crate::problem::raise)?;
        assumptions::refuse_outliers(&model)
            .map_err(|problem| crate::problem::raise(problem.into()))?;
        Ok(Stepper {
            observer: Observer::new(&model, arguments.method.options()),
            model: Arc::new(model),
            samples: 0,
            exact,
            assumptions,
        })
    }

    /// What is assumed beside the model file.
    #[getter]
    fn assumptions(&self) -> Vec<String> {
        self.assumptions.clone()
    }

    /// Number of samples that were taken.
    #[getter]
    fn samples(&self) -> usize {
        self.samples
    }

    /// Takes the next sample: its time in seconds, and a value for every input, output and signal by name.
    #[pyo3(signature = (t, values = None, /, **named))]
    fn step(
        &mut self,
        py: Python<'_>,
        t: &Bound<'_, PyAny>,
        values: Option<&Bound<'_, PyDict>>,
        named: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Step> {
        let sample = self.sample(t, values, named)?;
        let seconds = crate::table::seconds(&sample.time);
        let observer = &mut self.observer;
        let (outcome, nanoseconds) = py.detach(|| {
            let begin = Instant::now();
            let outcome = observer.step(&sample);
            (outcome, begin.elapsed().as_nanos() as u64)
        });
        let outcome = outcome.map_err(|error| misuse(&error.to_string()))?;
        self.samples += 1;
        Ok(Step {
            model: Arc::clone(&self.model),
            t: seconds,
            nanoseconds,
            outcome,
        })
    }
}

impl Stepper {
    fn sample(
        &self,
        t: &Bound<'_, PyAny>,
        values: Option<&Bound<'_, PyDict>>,
        named: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Sample> {
        let mut used = 0;
        let mut find = |name: &str| -> PyResult<Option<Bound<'_, PyAny>>> {
            let mut found = None;
            for values in [values, named].into_iter().flatten() {
                found = found.or(values.get_item(name)?);
            }
            used += usize::from(found.is_some());
            Ok(found)
        };
        let mut inputs = Vec::with_capacity(self.model.inputs.len());
        for input in self.model.recorded_inputs() {
            let given = find(&input.name)?.map(|x| self.number(&x)).transpose()?;
            let Some(Given::Number(value)) = given else {
                return Err(misuse(&format!(
                    "the input `{}` has no value at t = {t} s; give one with every sample",
                    input.name
                )));
            };
            inputs.push(input.error.enclose(value));
        }
        inputs.extend(self.model.disturbances().map(|(_, bounds)| bounds));
        let mut outputs = Vec::with_capacity(self.model.outputs.len());
        for output in &self.model.outputs {
            let given = find(&output.name)?.map(|x| self.number(&x)).transpose()?;
            outputs.push(match given {
                Some(Given::Number(value)) => Some(output.error.enclose(value)),
                _ => None,
            });
        }
        let mut signals = Vec::with_capacity(self.model.signals.len());
        for signal in &self.model.signals {
            let given = find(&signal.name)?.filter(|given| !given.is_none());
            signals.push(given.map(|given| given.is_truthy()).transpose()?);
        }
        let given = [values, named].into_iter().flatten();
        let given: Vec<Bound<'_, PyDict>> = given.cloned().collect();
        if given.iter().map(|values| values.len()).sum::<usize>() > used {
            return Err(self.unknown(&given));
        }
        Ok(Sample {
            time: self.decimal(t)?,
            inputs,
            outputs,
            signals,
            line: self.samples + 1,
        })
    }

    /// The smallest interval with the number in it.
    fn number(&self, x: &Bound<'_, PyAny>) -> PyResult<Given> {
        if x.is_none() {
            return Ok(Given::Missing);
        }
        if let Ok(x) = x.cast::<PyFloat>() {
            let x = x.value();
            if x.is_nan() {
                return Ok(Given::Missing);
            }
            if self.exact && x.is_finite() {
                return Ok(Given::Number(Interval::point(x)));
            }
        }
        Ok(Given::Number(self.decimal(x)?.to_interval()))
    }

    /// The number that Python's object stands for.
    fn decimal(&self, x: &Bound<'_, PyAny>) -> PyResult<Decimal> {
        let text = if let Ok(x) = x.cast::<PyFloat>() {
            float(x.value(), self.exact)
        } else if let Ok(x) = x.cast::<PyString>() {
            x.to_string()
        } else {
            let exact = x.py().import("veribound._numbers")?.getattr("number")?;
            exact.call1((x,))?.extract::<String>()?
        };
        Decimal::parse(&text)
            .map_err(|error| misuse(&format!("`{x}` is no number that can be used: {error}")))
    }

    fn unknown(&self, given: &[Bound<'_, PyDict>]) -> PyErr {
        let inputs = self.model.recorded_inputs().map(|x| x.name.as_str());
        let outputs = self.model.outputs.iter().map(|y| y.name.as_str());
        let signals = self.model.signals.iter().map(|s| s.name.as_str());
        let known: Vec<&str> = inputs.chain(outputs).chain(signals).collect();
        let names = given.iter().flat_map(|values| values.keys());
        let names = names.map(|name| name.to_string());
        let mut strange = names.filter(|name| !known.contains(&name.as_str()));
        match strange.next() {
            Some(name) => {
                let known = known.join("`, `");
                misuse(&format!(
                    "the model has no input, output or signal `{name}`; it has `{known}`"
                ))
            }
            None => misuse("a value is given twice; give each once"),
        }
    }
}

#[pymethods]
impl Step {
    /// "consistent", "inconsistent" or "undecided".
    #[getter]
    fn verdict(&self) -> &str {
        match self.outcome {
            Verdict::Consistent(_) => "consistent",
            Verdict::Inconsistent(_) => "inconsistent",
            Verdict::Undecided(_) => "undecided",
        }
    }

    /// Why it is not consistent.
    #[getter]
    fn message(&self) -> Option<String> {
        match &self.outcome {
            Verdict::Consistent(_) => None,
            Verdict::Inconsistent(refutation) => Some(format!(
                "{NOTHING_EXPLAINS} (proved): {}",
                refuted_at(&self.model, refutation)
            )),
            Verdict::Undecided(undecided) => Some(format!(
                "{}: {}",
                stopped(undecided),
                not_decided_at(&self.model, undecided)
            )),
        }
    }

    /// Number of boxes; 0 where there is no estimate.
    #[getter]
    fn boxes(&self) -> usize {
        self.estimate().map_or(0, |estimate| estimate.boxes)
    }

    /// Names of the modes that are possible now, or were since the sample before.
    #[getter]
    fn modes(&self) -> Vec<String> {
        let modes = self.estimate().map(|estimate| estimate.modes);
        let names = modes.map_or(String::new(), |modes| mode_names(&self.model, modes));
        let names = names.split('|').filter(|name| !name.is_empty());
        names.map(str::to_owned).collect()
    }

    /// Names of the parameters that may have taken a new value at this sample.
    #[getter]
    fn resets(&self) -> Vec<&str> {
        let resets = self.estimate().map_or(&[][..], |estimate| &estimate.resets);
        let names = self.model.params.iter().zip(resets);
        let reset = names.filter(|(_, is_reset)| **is_reset);
        reset.map(|(param, _)| param.name.as_str()).collect()
    }

    /// Lower and upper end of a parameter, state or output by name.
    fn ends(&self, name: &str) -> PyResult<(f64, f64)> {
        let quantities = self.quantities();
        let found = quantities.iter().find(|told| told.name == name);
        let found = found.map(|told| ends(told.bounds));
        found.ok_or_else(|| PyKeyError::new_err(name.to_owned()))
    }

    /// All bounds of a kind: "params", "states" or "outputs".
    fn bounds<'py>(&self, py: Python<'py>, kind: &str) -> PyResult<Bound<'py, PyList>> {
        let list = PyList::empty(py);
        let [params, states, outputs] = self.kinds();
        let told = match kind {
            "params" => params,
            "states" => states,
            _ => outputs,
        };
        for told in told {
            list.append(told.to_python(py)?)?;
        }
        Ok(list)
    }
}

impl Step {
    fn estimate(&self) -> Option<&Estimate> {
        match &self.outcome {
            Verdict::Consistent(estimate) => Some(estimate),
            _ => None,
        }
    }

    fn quantities(&self) -> Vec<Told<'_>> {
        self.kinds().into_iter().flatten().collect()
    }

    fn kinds(&self) -> [Vec<Told<'_>>; 3] {
        let Some(estimate) = self.estimate() else {
            return Default::default();
        };
        let params = self.model.params.iter().zip(&estimate.params);
        let states = self.model.states.iter().zip(&estimate.states);
        let outputs = self.model.outputs.iter().zip(&estimate.outputs);
        [
            params
                .map(|(param, bounds)| Told {
                    name: &param.name,
                    unit: &param.unit,
                    prior: Some(param.bounds),
                    bounds: *bounds,
                })
                .collect(),
            states
                .map(|(state, bounds)| Told {
                    name: &state.name,
                    unit: &state.unit,
                    prior: None,
                    bounds: *bounds,
                })
                .collect(),
            outputs
                .map(|(output, bounds)| Told {
                    name: &output.name,
                    unit: &output.unit,
                    prior: None,
                    bounds: *bounds,
                })
                .collect(),
        ]
    }
}
