//! The folder of a simulated trajectory.

use super::arguments::Format;
use super::enclose::{meta, mode_names, plane};
use super::files::{drawn_modes, undrawable, write_figures};
use super::flags::PlaneFlag;
use crate::Simulation;
use std::path::Path;
use veribound_data::{Cell, Column, ResultFolder, TableWriter};
use veribound_interval::{Decimal, Interval};
use veribound_model::diagnostic::Diagnostic;
use veribound_model::{Model, Var};
use veribound_report::{ReportError, Tube, TubeRow};

/// States, outputs and modes over time, row by row; the files appear together at the end.
pub struct Trajectory<'m> {
    model: &'m Model,
    folder: ResultFolder,
    table: TableWriter,
    tube: Tube,
    /// Parameters and inputs since the row before, if there is one.
    before: Option<(Vec<Interval>, Vec<Interval>)>,
}

impl<'m> Trajectory<'m> {
    /// *Errors*: those of a folder that cannot be made.
    pub fn create(folder: &Path, model: &'m Model) -> Result<Trajectory<'m>, Diagnostic> {
        let folder = ResultFolder::create(folder)?;
        let columns = Column::of_tube(model);
        Ok(Trajectory {
            table: TableWriter::create(&folder, "trajectory.csv", columns)?,
            tube: Tube::new(meta(model), plane(model, &PlaneFlag::Auto)?, 0),
            model,
            folder,
            before: None,
        })
    }

    /// Adds what holds at a time, with the inputs from then on, and since the row before.
    pub fn push(
        &mut self,
        time: &Decimal,
        simulation: &Simulation,
        inputs: &[Interval],
    ) -> Result<(), Diagnostic> {
        let (states, params) = (simulation.states(), simulation.params());
        let outputs = self.outputs(states, params, inputs);
        let before = self.before.replace((params.to_vec(), inputs.to_vec()));
        let is_first = before.is_none();
        let (states_since, outputs_since) = match &before {
            None => (states, outputs.clone()),
            Some((params, inputs)) => {
                let tube = simulation.tube();
                let since = self.outputs(tube, params, inputs).into_iter();
                // New inputs may make outputs jump at the time itself.
                let since = since.zip(&outputs).map(|(since, now)| since.hull(*now));
                (tube, since.collect())
            }
        };
        let modes = simulation.modes();
        let names = match is_first {
            true => String::new(),
            false => mode_names(self.model, modes),
        };
        let lists = [states, &outputs, states_since, &outputs_since];
        let bounds = lists.into_iter().flatten().map(|x| Cell::Bounds(*x));
        let cells: Vec<Cell<'_>> = bounds.chain([Cell::Text(&names)]).collect();
        self.table.row(time, &cells)?;
        let pairs = |list: &[Interval]| -> Vec<(f64, f64)> {
            list.iter().map(|x| (x.lo(), x.hi())).collect()
        };
        let [states, outputs, states_since, outputs_since] = lists.map(pairs);
        let possible: Vec<bool> = drawn_modes(self.model)
            .flatten()
            .map(|mode| is_first || modes.contains(mode))
            .collect();
        let row = TubeRow {
            t: time.to_interval().mid(),
            states: &states,
            outputs: &outputs,
            states_since: &states_since,
            outputs_since: &outputs_since,
            modes: &possible,
            trajectories: &[],
        };
        match self.tube.push(&row) {
            Ok(()) | Err(ReportError::TimeNotIncreasing { .. }) => Ok(()),
            Err(error) => Err(undrawable(&error)),
        }
    }

    fn outputs(
        &self,
        states: &[Interval],
        params: &[Interval],
        inputs: &[Interval],
    ) -> Vec<Interval> {
        let value = |var: Var| {
            let found = match var {
                Var::State(i) => states.get(i),
                Var::Param(i) => params.get(i),
                Var::Input(i) => inputs.get(i),
            };
            found.copied().unwrap_or(Interval::ENTIRE)
        };
        let outputs = self.model.outputs.iter();
        outputs
            .map(|output| self.model.graph.eval_interval(output.expr, &value))
            .collect()
    }

    /// Writes the figures, and puts all files in place.
    pub fn finish(self, formats: &[Format]) -> Result<(), Diagnostic> {
        let Trajectory {
            folder,
            table,
            tube,
            ..
        } = self;
        let mut files = vec![table.finish()?];
        files.extend(write_figures(&folder, formats, || tube.render_all())?);
        folder.publish(files)
    }
}
