//! The files of an observation, written as the run goes on.

use super::arguments::Format;
use serde::Serialize;
use veribound_data::{Cell, Column, ResultFolder, Summary, TableWriter};
use veribound_estimate::{Cell as Box, Estimate};
use veribound_flow::ModeSet;
use veribound_interval::{Decimal, Interval};
use veribound_model::diagnostic::Diagnostic;
use veribound_model::{Model, Sample};
use veribound_report::{FigureMeta, History, Parameter, Quantity, ReportError, SampleRow, Zoom};

/// The tables and figures of a run. Nothing of them is seen under its name before
/// [`Files::finish`]; memory does not grow with the record.
pub struct Files<'m> {
    model: &'m Model,
    folder: ResultFolder,
    states: TableWriter,
    params: TableWriter,
    history: History,
}

/// `summary.json`: the summary of the data crate, and what concerns the run alone.
#[derive(Serialize)]
pub struct RunSummary {
    /// Verdict, bounds and work.
    #[serde(flatten)]
    pub summary: Summary,
    /// True when the user ended the run before the end of the record.
    pub interrupted: bool,
    /// What was assumed beside the model file, in sentences.
    pub assumptions: Vec<String>,
}

impl<'m> Files<'m> {
    /// Starts the tables in `folder`.
    pub fn create(
        model: &'m Model,
        folder: ResultFolder,
        meta: FigureMeta,
    ) -> Result<Files<'m>, Diagnostic> {
        Ok(Files {
            states: TableWriter::create(&folder, "states.csv", Column::of_states(model))?,
            params: TableWriter::create(&folder, "params.csv", Column::of_params(model))?,
            history: History::new(meta),
            model,
            folder,
        })
    }

    /// Takes what is known after one sample.
    pub fn sample(
        &mut self,
        sample: &Sample,
        estimate: &Estimate,
        seconds: f64,
    ) -> Result<(), Diagnostic> {
        let modes = self.mode_names(estimate.modes);
        let mut row: Vec<Cell> = estimate.states.iter().map(|x| Cell::Bounds(*x)).collect();
        row.extend([Cell::Text(&modes), Cell::Count(estimate.boxes)]);
        self.states.row(&sample.time, &row)?;
        let names = self.model.params.iter().zip(&estimate.resets);
        let resets = joined(
            names
                .filter(|(_, is_reset)| **is_reset)
                .map(|(p, _)| p.name.as_str()),
        );
        let mut row: Vec<Cell> = estimate.params.iter().map(|p| Cell::Bounds(*p)).collect();
        row.push(Cell::Text(&resets));
        self.params.row(&sample.time, &row)?;
        let pairs = |list: &[Interval]| list.iter().map(|x| (x.lo(), x.hi())).collect::<Vec<_>>();
        let measured: Vec<Option<(f64, f64)>> = sample
            .outputs
            .iter()
            .map(|y| y.map(|y| (y.lo(), y.hi())))
            .collect();
        let modes: Vec<bool> = (0..self.model.modes.len())
            .map(|mode| estimate.modes.contains(mode))
            .collect();
        let row = SampleRow {
            t: sample.time.to_interval().mid(),
            outputs: &pairs(&estimate.outputs),
            measured: &measured,
            states: &pairs(&estimate.states),
            params: &pairs(&estimate.params),
            resets: &estimate.resets,
            modes: &modes,
            boxes: estimate.boxes as u64,
            milliseconds: seconds * 1e3,
        };
        match self.history.push(&row) {
            // Stamps that differ by less than a float can tell share a point of the time axis.
            Ok(()) | Err(ReportError::TimeNotIncreasing { .. }) => Ok(()),
            Err(error) => Err(undrawable(&error)),
        }
    }

    /// Marks the sample that refutes the model in all figures.
    pub fn refuted_at(&mut self, time: &Decimal) {
        self.history.refute_at(time.to_interval().mid());
    }

    /// Writes the boxes that are left after the last sample.
    pub fn boxes(&self, time: &Decimal, boxes: &[Box]) -> Result<(), Diagnostic> {
        let columns = Column::of_boxes(self.model);
        let mut table = TableWriter::create(&self.folder, "boxes.csv", columns)?;
        for (number, cell) in boxes.iter().enumerate() {
            let modes = self.mode_names(cell.modes);
            let mut row = vec![Cell::Count(number + 1)];
            row.extend(cell.z.iter().map(|z| Cell::Bounds(*z)));
            row.push(Cell::Text(&modes));
            table.row(time, &row)?;
        }
        table.finish()
    }

    /// Draws the figures, puts the tables and `summary.json` under their names, and gives the text
    /// of the latter.
    pub fn finish(
        self,
        formats: &[Format],
        overlay: Option<&History>,
        summary: &RunSummary,
    ) -> Result<String, Diagnostic> {
        let (svg, png) = (
            formats.contains(&Format::Svg),
            formats.contains(&Format::Png),
        );
        if (svg || png) && !formats.contains(&Format::None) {
            let figures = match overlay {
                Some(other) => self.history.render_compared(other),
                None => self.history.render_all(),
            };
            for figure in figures {
                let name = format!("fig/{}", figure.name);
                if svg {
                    self.folder
                        .write(&format!("{name}.svg"), figure.svg.as_bytes())?;
                }
                if png {
                    let pixels =
                        veribound_report::png(&figure.svg).map_err(|error| undrawable(&error))?;
                    self.folder.write(&format!("{name}.png"), &pixels)?;
                }
            }
        }
        self.states.finish()?;
        self.params.finish()?;
        let mut text = serde_json::to_string_pretty(summary).map_err(|error| {
            Diagnostic::new(
                "E0503",
                format!("the summary cannot be written as JSON: {error}"),
            )
        })?;
        text.push('\n');
        self.folder.write("summary.json", text.as_bytes())?;
        Ok(text)
    }

    /// Where the files go.
    pub fn folder(&self) -> &ResultFolder {
        &self.folder
    }

    fn mode_names(&self, modes: ModeSet) -> String {
        let names = self.model.modes.iter().enumerate();
        joined(
            names
                .filter(|(mode, _)| modes.contains(*mode))
                .map(|(_, m)| m.name.as_str()),
        )
    }
}

/// What the figures are about.
pub fn figure_meta(model: &Model, zoom: Zoom, sample_time_ms: Option<f64>) -> FigureMeta {
    let params = model.params.iter().map(|param| Parameter {
        quantity: Quantity::new(param.name.as_str(), param.unit.as_str()),
        prior: (param.bounds.lo(), param.bounds.hi()),
        nominal: param
            .nominal
            .as_ref()
            .map(|nominal| nominal.to_interval().mid()),
    });
    FigureMeta {
        title: model.name.clone(),
        outputs: model
            .outputs
            .iter()
            .map(|output| Quantity::new(output.name.as_str(), output.unit.as_str()))
            .collect(),
        states: model
            .states
            .iter()
            .map(|state| Quantity::new(state.name.as_str(), state.unit.as_str()))
            .collect(),
        params: params.collect(),
        modes: model.modes.iter().map(|mode| mode.name.clone()).collect(),
        zoom,
        sample_time_ms,
        ..FigureMeta::default()
    }
}

fn joined<'n>(names: impl Iterator<Item = &'n str>) -> String {
    names.collect::<Vec<_>>().join("|")
}

fn undrawable(error: &ReportError) -> Diagnostic {
    Diagnostic::new("E0506", format!("the figures cannot be drawn: {error}"))
        .help("leave them out with `--figures none`")
}
