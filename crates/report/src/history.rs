//! The memory of a run, fed sample by sample, from which the figures are drawn.

use crate::error::ReportError;
use crate::meta::FigureMeta;
use crate::track::{Band, Cell, Track};
use crate::zoom::Spotlight;

/// Mark of a mode that can be active at some sample of the cell, or since the sample before it.
pub(crate) const POSSIBLE: u8 = 1;
/// Mark of a mode that is not, for every sample of the cell, the only possible one.
pub(crate) const NOT_ALONE: u8 = 2;
/// Mark of a parameter that was reset at some sample of the cell.
pub(crate) const RESET: u8 = 1;

/// What is known after one sample. Bounds are pairs lo, hi; infinite bounds are allowed, and a pair
/// with lo > hi is the empty set, drawn as nothing.
///
/// Example: [`FigureMeta`].
#[derive(Clone, Copy, Debug, Default)]
pub struct SampleRow<'a> {
    /// Time, in the figures' time unit; increases from row to row.
    pub t: f64,
    /// Proved bounds of each output.
    pub outputs: &'a [(f64, f64)],
    /// What the measurement of each output allows; `None` where nothing was measured.
    pub measured: &'a [Option<(f64, f64)>],
    /// Proved bounds of each state.
    pub states: &'a [(f64, f64)],
    /// Proved bounds of each parameter.
    pub params: &'a [(f64, f64)],
    /// Whether each parameter was reset at this sample; an empty slice stands for no reset.
    pub resets: &'a [bool],
    /// Whether each mode can be active at this sample or at some time since the sample before; false
    /// means proved impossible there.
    pub modes: &'a [bool],
    /// Number of boxes after the sample, when those that it refutes are gone and any merging is done.
    pub boxes: u64,
    /// Time spent on the sample, in milliseconds.
    pub milliseconds: f64,
}

/// Totals of the work, over all samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Work {
    pub samples: u64,
    pub milliseconds: f64,
    pub worst: f64,
    pub most_boxes: u64,
}

/// All series of a run over time, in memory that does not grow with the length of the record.
///
/// # Guarantee
/// Each series is kept in at most `FigureMeta::columns` cells of time. Where samples share a cell,
/// the cell has the hull of their bounds, so that no sample's bounds stick out of the drawn band;
/// a mode is shown as impossible only where it is impossible at all samples of the cell, which speak
/// for the time since the cell before.
///
/// # Cost
/// `push` is O(number of series) on average; memory is O(columns x number of series).
///
/// ```
/// use veribound_report::{FigureMeta, History, Quantity, SampleRow};
///
/// let meta = FigureMeta { states: vec![Quantity::new("x", "m")], ..FigureMeta::default() };
/// let mut history = History::new(meta);
/// for k in 0..10 {
///     let t = f64::from(k);
///     history.push(&SampleRow { t, states: &[(t - 0.5, t + 0.5)], ..SampleRow::default() })?;
/// }
/// let names: Vec<String> = history.render_all().into_iter().map(|figure| figure.name).collect();
/// assert!(names.contains(&"states".to_string()));
/// # Ok::<(), veribound_report::ReportError>(())
/// ```
#[derive(Clone, Debug)]
pub struct History {
    pub(crate) meta: FigureMeta,
    pub(crate) refuted_at: Option<f64>,
    pub(crate) work: Work,
    clash: Option<(usize, [(f64, f64); 2])>,
    last: Option<Cell>,
    track: Track,
    /// Finer cells, for the page.
    detail: Option<Track>,
    spotlight: Spotlight,
}

impl History {
    /// An empty history of the described quantities.
    pub fn new(meta: FigureMeta) -> Self {
        let track = Track::new(meta.columns);
        let spotlight = Spotlight::new(meta.zoom, meta.outputs.len(), meta.columns);
        let work = Work::default();
        let series = 2 * meta.outputs.len() + meta.states.len() + meta.params.len() + 2;
        let detail = meta.page.then(|| Track::fine(series, meta.columns));
        Self {
            meta,
            refuted_at: None,
            work,
            clash: None,
            last: None,
            track,
            detail,
            spotlight,
        }
    }

    /// The description the history was made with.
    pub fn meta(&self) -> &FigureMeta {
        &self.meta
    }

    /// Number of samples taken so far.
    pub fn samples(&self) -> u64 {
        self.work.samples
    }

    /// Takes what is known after one more sample.
    ///
    /// # Errors
    /// The row has another shape than the description, or its time does not increase; the history
    /// is then as before.
    pub fn push(&mut self, row: &SampleRow<'_>) -> Result<(), ReportError> {
        self.check(row)?;
        let measured = row.measured.iter().map(|m| m.and_then(Band::of));
        let of = |bounds: &'_ [(f64, f64)]| bounds.iter().map(|b| Band::of(*b)).collect::<Vec<_>>();
        let mut bands = of(row.outputs);
        bands.extend(measured);
        if !matches!(self.spotlight, Spotlight::Off) {
            let bands = bands.clone().into();
            self.spotlight.push(Cell {
                t0: row.t,
                t1: row.t,
                bands,
                marks: Box::default(),
            });
        }
        bands.extend(of(row.states));
        bands.extend(of(row.params));
        bands.push(Band::of((row.boxes as f64, row.boxes as f64)));
        bands.push(Band::of((row.milliseconds, row.milliseconds)));
        let rivals = |mode: usize| {
            let group = self.meta.mode_groups.iter().find(|g| g.contains(&mode));
            let group = group.and_then(|group| row.modes.get(group.clone()));
            group.unwrap_or(row.modes)
        };
        let possible = |mode| rivals(mode).iter().filter(|can| **can).count();
        let mut marks: Vec<u8> = (row.modes.iter().enumerate())
            .map(|(mode, can)| match (*can, possible(mode)) {
                (true, 1) => POSSIBLE,
                (true, _) => POSSIBLE | NOT_ALONE,
                (false, _) => NOT_ALONE,
            })
            .collect();
        marks.extend(
            row.resets
                .iter()
                .map(|reset| if *reset { RESET } else { 0 }),
        );
        let cell = Cell {
            t0: row.t,
            t1: row.t,
            bands: bands.into(),
            marks: marks.into(),
        };
        self.last = Some(cell.clone());
        if let Some(detail) = &mut self.detail {
            detail.push(cell.clone());
        }
        self.track.push(cell);
        let spent = if row.milliseconds.is_finite() {
            row.milliseconds.max(0.0)
        } else {
            0.0
        };
        self.work.samples += 1;
        self.work.milliseconds += spent;
        self.work.worst = self.work.worst.max(spent);
        self.work.most_boxes = self.work.most_boxes.max(row.boxes);
        Ok(())
    }

    /// Marks the time from which the record is proved inconsistent with the model: a line through
    /// every figure.
    pub fn refute_at(&mut self, t: f64) {
        self.refuted_at = t.is_finite().then_some(t);
        self.spotlight.end_here();
    }

    /// Tells what an output contradicts there: `enclosure` is all that the model allows, `measured` all that the
    /// measurement does. The page shows both.
    pub fn refute_by(&mut self, output: usize, enclosure: (f64, f64), measured: (f64, f64)) {
        self.clash = Some((output, [enclosure, measured]));
    }

    fn check(&self, row: &SampleRow<'_>) -> Result<(), ReportError> {
        let meta = &self.meta;
        let resets = if row.resets.is_empty() {
            meta.params.len()
        } else {
            row.resets.len()
        };
        let shapes = [
            ("outputs", meta.outputs.len(), row.outputs.len()),
            ("measured", meta.outputs.len(), row.measured.len()),
            ("states", meta.states.len(), row.states.len()),
            ("params", meta.params.len(), row.params.len()),
            ("modes", meta.modes.len(), row.modes.len()),
            ("resets", meta.params.len(), resets),
        ];
        for (what, expected, found) in shapes {
            if expected != found {
                return Err(ReportError::Shape {
                    what,
                    expected,
                    found,
                });
            }
        }
        if !row.t.is_finite() {
            return Err(ReportError::TimeNotFinite);
        }
        match &self.last {
            Some(last) if row.t <= last.t1 => Err(ReportError::TimeNotIncreasing {
                before: last.t1,
                found: row.t,
            }),
            _ => Ok(()),
        }
    }

    pub(crate) fn cells(&self) -> &[Cell] {
        self.track.cells()
    }

    /// The finest cells that are kept.
    pub(crate) fn detail(&self) -> &[Cell] {
        self.detail.as_ref().unwrap_or(&self.track).cells()
    }

    /// What is contradicted of an output.
    pub(crate) fn clash_of(&self, output: usize) -> Option<[(f64, f64); 2]> {
        self.clash
            .filter(|clash| clash.0 == output)
            .map(|clash| clash.1)
    }

    pub(crate) fn zoom_cells(&self) -> Option<&[Cell]> {
        self.spotlight.cells()
    }

    /// First and last time that the figures show, if there is any sample.
    pub(crate) fn time_span(&self) -> Option<(f64, f64)> {
        let (from, to) = (self.cells().first()?.t0, self.cells().last()?.t1);
        Some((from, self.refuted_at.map_or(to, |t| to.max(t))))
    }

    /// The bounds of a series after the very last sample.
    pub(crate) fn last_band(&self, series: usize) -> Option<Band> {
        self.last.as_ref()?.band(series)
    }

    pub(crate) fn output_series(&self, j: usize) -> usize {
        j
    }

    pub(crate) fn measured_series(&self, j: usize) -> usize {
        self.meta.outputs.len() + j
    }

    pub(crate) fn state_series(&self, i: usize) -> usize {
        2 * self.meta.outputs.len() + i
    }

    pub(crate) fn param_series(&self, i: usize) -> usize {
        self.state_series(self.meta.states.len()) + i
    }

    pub(crate) fn boxes_series(&self) -> usize {
        self.param_series(self.meta.params.len())
    }

    pub(crate) fn milliseconds_series(&self) -> usize {
        self.boxes_series() + 1
    }

    /// Number of marks of a cell.
    pub(crate) fn marks(&self) -> usize {
        self.meta.modes.len() + self.meta.params.len()
    }

    /// The marks of mode `i`.
    pub(crate) fn mode_marks(&self, i: usize) -> usize {
        i
    }

    /// Whether parameter `i` was reset at some sample.
    pub(crate) fn is_reset(&self, i: usize) -> bool {
        let mut cells = self.cells().iter();
        cells.any(|cell| cell.mark(self.reset_marks(i)) & RESET != 0)
    }

    /// The marks of the resets of parameter `i`.
    pub(crate) fn reset_marks(&self, i: usize) -> usize {
        self.meta.modes.len() + i
    }
}
