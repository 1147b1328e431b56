//! Identification from whole records.

use crate::model::PyModel;
use crate::problem::{misuse, raise, shown};
use crate::source::Source;
use crate::table::{Bands, Told, ends};
use crate::watch::{Standing, Watch, watched};
use crate::words;
use pyo3::prelude::*;
use pyo3::types::PyList;
use veribound::program::arguments::{Command, Identify};
use veribound::program::identify::files::{name, reason};
use veribound::program::identify::{Done, Prepared, in_words, refuse_flags, told, verdict};
use veribound::program::numbers::{show_reached, show_times};
use veribound::program::{progress, reading};
use veribound_data::TableSource;
use veribound_estimate::identify::Progress;
use veribound_model::Model;
use veribound_model::diagnostic::Diagnostics;

/// Turned tiles: the frame of each, their coordinates, the status of each tile, and why.
type Turned<'py> = (
    Vec<usize>,
    Bound<'py, PyList>,
    Vec<&'static str>,
    Vec<String>,
);

/// An identification that is done.
#[pyclass(frozen, module = "veribound._veribound")]
pub struct Found {
    done: Done,
    said: Vec<String>,
    asked_to_end: bool,
}

/// Identifies from records with the options of the program.
#[pyfunction]
#[pyo3(signature = (model, records, words, wants_files, progress))]
pub fn identify(
    py: Python<'_>,
    model: PyRef<'_, PyModel>,
    records: Vec<PyRef<'_, Source>>,
    words: Vec<String>,
    wants_files: bool,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Found> {
    let Command::Identify(mut arguments) = words::parse(&words)? else {
        return Err(misuse("this is no identification"));
    };
    arguments.words = words::told(words);
    let model = Model::clone(&model.0);
    let sources: Vec<TableSource> = records.iter().map(|record| record.0.clone()).collect();
    let work = |watch: &Watch| work(&arguments, model, sources, wants_files, watch);
    let (done, asked_to_end) = watched(py, progress.as_ref(), work)?;
    let (done, said) = done.map_err(raise)?;
    Ok(Found {
        done,
        said,
        asked_to_end,
    })
}

fn work(
    arguments: &Identify,
    model: Model,
    sources: Vec<TableSource>,
    wants_files: bool,
    watch: &Watch,
) -> Result<(Done, Vec<String>), Diagnostics> {
    if wants_files {
        refuse_flags(arguments)?;
    }
    let mut silent = |_: &TableSource| progress::of_parts(0, "", true);
    let prepared = Prepared::new(arguments, model, sources, &mut silent)?;
    let said = prepared.said.clone();
    let go_on = |standing: &Progress| {
        watch.tell(Standing {
            done: standing.sets as u64,
            whole: 0,
            text: in_words(standing),
        });
        watch.goes_on()
    };
    Ok((prepared.carry_out(arguments, wants_files, &go_on)?, said))
}

#[pymethods]
impl Found {
    /// Whether Ctrl-C was pressed.
    #[getter]
    fn asked_to_end(&self) -> bool {
        self.asked_to_end
    }

    /// "consistent", "inconsistent" or "undecided".
    #[getter]
    fn verdict(&self) -> &str {
        verdict::in_words(&self.done.found).0.name()
    }

    /// Why it is not consistent, as the program tells it.
    #[getter]
    fn message(&self, py: Python<'_>) -> Option<String> {
        let Done {
            model, data, found, ..
        } = &self.done;
        py.detach(|| verdict::problem(model, data, found).map(shown))
    }

    /// What is assumed beside the model file.
    #[getter]
    fn assumptions(&self) -> Vec<String> {
        self.said.clone()
    }

    /// What a user should know of the records.
    #[getter]
    fn notes(&self) -> Vec<String> {
        reading::notes(&self.done.data.records)
    }

    /// Whether the run ended early, at the user's wish.
    #[getter]
    fn interrupted(&self) -> bool {
        self.done.found.identified.interrupted
    }

    /// `summary.json`.
    #[getter]
    fn json(&self) -> &str {
        &self.done.json
    }

    /// The table that the program prints.
    fn table(&self) -> String {
        let Done {
            model, data, found, ..
        } = &self.done;
        told::bounds(model, data, found)
    }

    /// Bounds of the parameters, or of the states at the first sample of a record.
    #[pyo3(signature = (record = None))]
    fn bounds<'py>(&self, py: Python<'py>, record: Option<usize>) -> PyResult<Bound<'py, PyList>> {
        let Done { model, found, .. } = &self.done;
        let list = PyList::empty(py);
        let bounds = match record {
            None => found.params(model),
            Some(record) => found.start(model, record),
        };
        let params = model.params.iter().map(|p| (&p.name, &p.unit, p.bounds));
        let states = model.states.iter().map(|s| (&s.name, &s.unit, s.init));
        let quantities: Vec<_> = match record {
            None => params.collect(),
            Some(_) => states.collect(),
        };
        for ((name, unit, prior), both) in quantities.into_iter().zip(&bounds) {
            let told = Told {
                name,
                unit,
                prior: Some(prior),
                bounds: both.outer,
            };
            let entry = told.to_python(py)?;
            entry.set_item("inner", both.inner.map(ends))?;
            entry.set_item("inner_shown", show_reached(both.inner, both.tightness()))?;
            entry.set_item("tightness", both.tightness())?;
            entry.set_item("tightness_shown", show_times(both.tightness()))?;
            list.append(entry)?;
        }
        Ok(list)
    }

    /// Points that are proved to agree: parameters, each `(name, bytes, bytes)`.
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let Done { model, found, .. } = &self.done;
        let mut bands = Bands::new(model.params.len());
        let points = found.identified.points.iter();
        points.for_each(|point| bands.push(point));
        bands.to_python(py, model.params.iter().map(|param| param.name.as_str()))
    }

    /// Turned tiles: the frame of each, their coordinates, each `(name, bytes, bytes)`; the status of each tile, and why.
    fn turned<'py>(&self, py: Python<'py>) -> PyResult<Turned<'py>> {
        let Done { data, found, .. } = &self.done;
        let tiles = found.identified.tiles.iter();
        let tiles = tiles.filter_map(|tile| Some((tile, tile.turned.as_ref()?)));
        let tiles: Vec<_> = tiles.collect();
        let axes = tiles.first().map_or(0, |(_, turned)| turned.unknowns.len());
        let mut bands = Bands::new(axes);
        tiles
            .iter()
            .for_each(|(_, turned)| bands.push(&turned.unknowns));
        let names: Vec<String> = (1..=axes).map(|axis| format!("y{axis}")).collect();
        Ok((
            tiles.iter().map(|(_, turned)| turned.frame + 1).collect(),
            bands.to_python(py, names.iter().map(String::as_str))?,
            tiles.iter().map(|(tile, _)| name(tile.status)).collect(),
            tiles
                .iter()
                .map(|(tile, _)| reason(data, &tile.reason))
                .collect(),
        ))
    }

    /// Frames of turned tiles: the middle of every parameter, and by how much each coordinate changes it.
    fn frames(&self) -> Vec<(Vec<f64>, Vec<Vec<f64>>)> {
        let frames = self.done.found.identified.frames.iter();
        let frames = frames.map(|frame| (frame.centre.clone(), frame.axes.clone()));
        frames.collect()
    }

    /// Tiles of the prior that are not turned: parameters, each `(name, bytes, bytes)`; the status of each tile, and why.
    fn paving<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyList>, Vec<&'static str>, Vec<String>)> {
        let Done {
            model, data, found, ..
        } = &self.done;
        let upright = found.identified.tiles.iter();
        let tiles: Vec<_> = upright.filter(|tile| tile.turned.is_none()).collect();
        let mut bands = Bands::new(model.params.len());
        tiles.iter().for_each(|tile| bands.push(&tile.params));
        let names = model.params.iter().map(|param| param.name.as_str());
        let status = tiles.iter().map(|tile| name(tile.status)).collect();
        let reasons = tiles.iter().map(|tile| reason(data, &tile.reason));
        Ok((bands.to_python(py, names)?, status, reasons.collect()))
    }

    /// How large measurement errors must be for anything to agree, where that was looked for.
    fn least_error(&self) -> Option<(f64, f64)> {
        self.done
            .found
            .least
            .as_ref()
            .map(|least| ends(least.factor))
    }

    /// Number of records.
    #[getter]
    fn records(&self) -> usize {
        self.done.data.records.len()
    }
}
