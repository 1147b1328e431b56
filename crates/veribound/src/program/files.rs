//! The files of an observation, written as the run goes on.

use super::arguments::Format;
use std::ops::Range;
use veribound_data::{Cell, Column, CompleteFile, ResultFolder, RunInfo, TableWriter};
use veribound_estimate::{Cell as Box, Contradiction, Estimate, Refutation};
use veribound_flow::ModeSet;
use veribound_interval::{Decimal, Interval};
use veribound_model::diagnostic::Diagnostic;
use veribound_model::{Model, Sample};
use veribound_report::{
    Figure, FigureMeta, History, Page, Parameter, Plots, Quantity, ReportError, SampleRow, Zoom,
};

/// The tables and figures of a run. Nothing of them is seen under its name before
/// [`Files::finish`]; memory does not grow with the record.
pub struct Files<'m> {
    model: &'m Model,
    folder: ResultFolder,
    states: TableWriter,
    params: TableWriter,
    history: History,
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
        let modes = mode_names(self.model, estimate.modes);
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
        push(&mut self.history, self.model, (sample, estimate), seconds)
    }

    /// Marks the sample that refutes the model in all figures.
    pub fn refuted_at(&mut self, refutation: &Refutation) {
        self.history.refute_at(refutation.time.to_interval().mid());
        if let Contradiction::Output {
            output,
            enclosure,
            measured,
            ..
        } = &refutation.contradiction
        {
            let pair = |x: &Interval| (x.lo(), x.hi());
            self.history
                .refute_by(*output, pair(enclosure), pair(measured));
        }
    }

    /// Writes what is left to write, and gives all files their names together.
    ///
    /// `boxes` are those that are left after the last sample, at `time`.
    pub fn finish(
        self,
        (time, boxes): (&Decimal, &[Box]),
        run_info: &RunInfo,
        summary: &str,
        ((formats, overlay), page): ((&[Format], Option<&History>), Option<Page>),
    ) -> Result<(), Diagnostic> {
        let mut files = vec![self.boxes(time, boxes)?, run_info.write(&self.folder)?];
        files.extend(self.figures(formats, overlay)?);
        if let Some(mut page) = page {
            page.plots =
                Plots::of_history(&self.history).with_boxes(&self.axes(), self.flat(boxes));
            files.push(self.folder.write("report.html", page.render().as_bytes())?);
        }
        files.push(self.folder.write("summary.json", summary.as_bytes())?);
        files.push(self.states.finish()?);
        files.push(self.params.finish()?);
        self.folder.publish(files)
    }

    fn boxes(&self, time: &Decimal, boxes: &[Box]) -> Result<CompleteFile, Diagnostic> {
        let columns = Column::of_boxes(self.model);
        let mut table = TableWriter::create(&self.folder, "boxes.csv", columns)?;
        for (number, cell) in boxes.iter().enumerate() {
            let modes = mode_names(self.model, cell.modes);
            let mut row = vec![Cell::Count(number + 1)];
            row.extend(cell.z.iter().map(|z| Cell::Bounds(*z)));
            row.push(Cell::Text(&modes));
            table.row(time, &row)?;
        }
        table.finish()
    }

    /// What boxes are ranges of: parameters, then states.
    fn axes(&self) -> Vec<Parameter> {
        let meta = self.history.meta();
        let states = meta.states.iter().map(|state| Parameter {
            quantity: state.clone(),
            prior: (f64::NEG_INFINITY, f64::INFINITY),
            nominal: None,
        });
        meta.params.iter().cloned().chain(states).collect()
    }

    /// The ranges of boxes, in the same order.
    fn flat(&self, boxes: &[Box]) -> Vec<Vec<(f64, f64)>> {
        let states = self.model.states.len();
        let one = |cell: &Box| {
            let (states, params) = cell.z.split_at_checked(states)?;
            let all = params.iter().chain(states);
            Some(all.map(|x| (x.lo(), x.hi())).collect())
        };
        boxes.iter().filter_map(one).collect()
    }

    fn figures(
        &self,
        formats: &[Format],
        overlay: Option<&History>,
    ) -> Result<Vec<CompleteFile>, Diagnostic> {
        write_figures(&self.folder, formats, || match overlay {
            Some(other) => self.history.render_compared(other),
            None => self.history.render_all(),
        })
    }
}

/// Adds what is known after a sample to what figures and page are drawn from.
pub fn push(
    history: &mut History,
    model: &Model,
    (sample, estimate): (&Sample, &Estimate),
    seconds: f64,
) -> Result<(), Diagnostic> {
    let pairs = |list: &[Interval]| list.iter().map(|x| (x.lo(), x.hi())).collect::<Vec<_>>();
    let measured: Vec<Option<(f64, f64)>> = sample
        .outputs
        .iter()
        .map(|y| y.map(|y| (y.lo(), y.hi())))
        .collect();
    let modes: Vec<bool> = drawn_modes(model)
        .flatten()
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
    match history.push(&row) {
        // Stamps that differ by less than a float can tell share a point of the time axis.
        Ok(()) | Err(ReportError::TimeNotIncreasing { .. }) => Ok(()),
        Err(error) => Err(undrawable(&error)),
    }
}

/// Names of modes, joined.
pub fn mode_names(model: &Model, modes: ModeSet) -> String {
    let names = model.modes.iter().enumerate();
    joined(
        names
            .filter(|(mode, _)| modes.contains(*mode))
            .map(|(_, m)| m.name.as_str()),
    )
}

/// Writes the figures that `draw` gives in all formats, if any is asked for.
pub fn write_figures(
    folder: &ResultFolder,
    formats: &[Format],
    draw: impl FnOnce() -> Vec<Figure>,
) -> Result<Vec<CompleteFile>, Diagnostic> {
    if formats.iter().all(|format| *format == Format::None) {
        return Ok(Vec::new());
    }
    let mut files = Vec::new();
    for figure in draw() {
        let name = format!("fig/{}", figure.name);
        if formats.contains(&Format::Svg) {
            let svg = figure.svg.as_bytes();
            files.push(folder.write(&format!("{name}.svg"), svg)?);
        }
        if formats.contains(&Format::Png) {
            let pixels = veribound_report::png(&figure.svg).map_err(|error| undrawable(&error))?;
            files.push(folder.write(&format!("{name}.png"), &pixels)?);
        }
    }
    Ok(files)
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
        modes: drawn_modes(model)
            .flatten()
            .filter_map(|mode| Some(model.modes.get(mode)?.name.clone()))
            .collect(),
        mode_groups: drawn_modes(model)
            .scan(0, |first, group| {
                let start = *first;
                *first += group.len();
                Some(start..*first)
            })
            .collect(),
        zoom,
        sample_time_ms,
        ..FigureMeta::default()
    }
}

/// The groups of modes that have a choice; the only group, where there is but one.
pub fn drawn_modes(model: &Model) -> impl Iterator<Item = Range<usize>> + '_ {
    let only = model.groups.len() == 1;
    let groups = model.groups.iter().map(|group| group.modes.clone());
    groups.filter(move |modes| only || modes.len() > 1)
}

/// Names, joined.
pub fn joined<'n>(names: impl Iterator<Item = &'n str>) -> String {
    names.collect::<Vec<_>>().join("|")
}

pub fn undrawable(error: &ReportError) -> Diagnostic {
    Diagnostic::new("E0506", format!("the figures cannot be drawn: {error}"))
        .help("leave them out with `--figures none`")
}

#[cfg(test)]
mod tests {
    use super::*;
    use veribound_model::diagnostic::Diagnostics;

    #[test]
    fn figures_that_cannot_be_drawn_are_told_word_for_word() {
        let size = ReportError::Size {
            width: 0,
            height: 480,
        };
        let said = Diagnostics::from(undrawable(&size)).render(false);
        let wanted = "error[E0506]: the figures cannot be drawn: a picture of 0 x 480 pixels cannot be made\n \
            |\n = help: leave them out with `--figures none`\n";
        assert_eq!(said, wanted);
    }
}
