//! The memory of an enclosure over time, fed from one time to the next, from which its figures are drawn.

use crate::error::ReportError;
use crate::figure::Figure;
use crate::history::{History, SampleRow};
use crate::meta::FigureMeta;
use crate::track::{Band, Cell, Track};

/// What is proved at one time, and since the one before. Bounds are pairs lo, hi; infinite bounds are
/// allowed.
///
/// Example: [`Tube`].
#[derive(Clone, Copy, Debug, Default)]
pub struct TubeRow<'a> {
    /// Time, in the figures' time unit; increases from row to row.
    pub t: f64,
    /// Proved bounds of each state at this time,
    pub states: &'a [(f64, f64)],
    /// and of each output.
    pub outputs: &'a [(f64, f64)],
    /// Proved bounds of each state at all times since the row before,
    pub states_since: &'a [(f64, f64)],
    /// and of each output.
    pub outputs_since: &'a [(f64, f64)],
    /// Whether each mode may have acted since the row before; false means proved impossible.
    pub modes: &'a [bool],
    /// For every trajectory that is drawn, where its states and then its outputs are at this time; an empty
    /// list from where it is not known any more.
    pub trajectories: &'a [Vec<(f64, f64)>],
}

/// All bounds of an enclosure over time, in memory that does not grow with their number.
///
/// # Guarantee
/// No bounds of a row stick out of the band drawn for them: rows that share a column of the picture are joined
/// into the hull of their bounds.
///
/// # Cost
/// `push` is O(number of series) on average; memory is O(columns x number of series).
///
/// ```
/// use veribound_report::{FigureMeta, Quantity, Tube, TubeRow};
///
/// let meta = FigureMeta { states: vec![Quantity::new("x", "m")], ..FigureMeta::default() };
/// let mut tube = Tube::new(meta, None, 0);
/// for k in 0..10 {
///     let t = f64::from(k);
///     let (states, states_since) = (&[(t, t + 1.0)], &[(t - 1.0, t + 1.0)]);
///     tube.push(&TubeRow { t, states, states_since, ..TubeRow::default() })?;
/// }
/// assert_eq!(tube.render_all()[0].name, "states");
/// # Ok::<(), veribound_report::ReportError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Tube {
    /// Bounds at the times, and modes.
    pub(crate) history: History,
    /// Bounds since the row before: states, then outputs.
    pub(crate) since: Track,
    /// The same in finer cells, for the page.
    since_detail: Option<Track>,
    /// The trajectories, one after the other.
    pub(crate) trajectories: Track,
    pub(crate) count: usize,
    /// The two states of the phase plane.
    pub(crate) plane: Option<(usize, usize)>,
    /// For every state the time since when its width is past use.
    pub(crate) past_use: Vec<Option<f64>>,
    before: Option<f64>,
}

impl Tube {
    /// An empty tube of the states, outputs and modes of `meta`, with so many trajectories; `plane` names two
    /// states by their positions.
    pub fn new(meta: FigureMeta, plane: Option<(usize, usize)>, trajectories: usize) -> Tube {
        let columns = meta.columns;
        let own = meta.states.len() + meta.outputs.len();
        let since_detail = meta.page.then(|| Track::fine(own, columns));
        Tube {
            past_use: vec![None; meta.states.len()],
            history: History::new(meta),
            since: Track::new(columns),
            since_detail,
            trajectories: Track::new(columns),
            count: trajectories,
            plane,
            before: None,
        }
    }

    /// Takes what is proved at one more time. What is said of the time since the row before is not asked for in
    /// the first row.
    ///
    /// # Errors
    /// The row has another shape than the description, or its time does not increase; the tube is then as
    /// before.
    pub fn push(&mut self, row: &TubeRow<'_>) -> Result<(), ReportError> {
        let meta = self.history.meta();
        let own = meta.states.len() + meta.outputs.len();
        let since = row.states_since.len() + row.outputs_since.len();
        if since != own {
            return Err(ReportError::Shape {
                what: "bounds since the time before",
                expected: own,
                found: since,
            });
        }
        if row.trajectories.len() != self.count {
            return Err(ReportError::Shape {
                what: "trajectories",
                expected: self.count,
                found: row.trajectories.len(),
            });
        }
        let nothing = vec![None; meta.outputs.len()];
        self.history.push(&SampleRow {
            t: row.t,
            outputs: row.outputs,
            measured: &nothing,
            states: row.states,
            modes: row.modes,
            ..SampleRow::default()
        })?;
        if let Some(before) = self.before {
            let bands = row.states_since.iter().chain(row.outputs_since);
            let cell = Cell {
                t0: before,
                t1: row.t,
                bands: bands.map(|b| Band::of(*b)).collect(),
                marks: Box::default(),
            };
            if let Some(detail) = &mut self.since_detail {
                detail.push(cell.clone());
            }
            self.since.push(cell);
        }
        let mut bands = Vec::with_capacity(self.count * own);
        for one in row.trajectories {
            let known = one.iter().map(|b| Band::of(*b));
            bands.extend(known.chain(std::iter::repeat(None)).take(own));
        }
        self.trajectories.push(Cell {
            t0: row.t,
            t1: row.t,
            bands: bands.into(),
            marks: Box::default(),
        });
        self.before = Some(row.t);
        Ok(())
    }

    /// Marks the time since when the width of a state is past use.
    pub fn past_use(&mut self, state: usize, since: f64) {
        if let Some(slot) = self.past_use.get_mut(state) {
            *slot = since.is_finite().then_some(since);
        }
    }

    /// All figures that there is something for: `outputs`, `states`, `modes`, `plane`.
    ///
    /// # Guarantee
    /// A drawn band holds the bounds that were given for it, those since the row before at all times
    /// between: coordinates are rounded outward. What is drawn of modes holds between rows, too. The same
    /// tube gives the same bytes.
    pub fn render_all(&self) -> Vec<Figure> {
        let meta = self.history.meta();
        let plane = self.plane.filter(|(x, y)| (*x).max(*y) < meta.states.len());
        let wanted = [
            (!meta.outputs.is_empty()).then(|| ("outputs", self.draw_outputs())),
            (!meta.states.is_empty()).then(|| ("states", self.draw_states())),
            (meta.modes.len() > 1).then(|| ("modes", self.draw_modes())),
            plane.map(|plane| ("plane", self.draw_plane(plane))),
        ];
        let drawn = wanted.into_iter().flatten();
        drawn
            .map(|(name, svg)| Figure {
                name: name.to_owned(),
                svg,
            })
            .collect()
    }

    /// The finest cells that are kept of what holds between times.
    pub(crate) fn since_detail(&self) -> &[Cell] {
        self.since_detail.as_ref().unwrap_or(&self.since).cells()
    }

    /// The time from which on some width is past use: axes show what is before.
    pub(crate) fn last_useful(&self) -> f64 {
        let past_use = self.past_use.iter().flatten().copied();
        past_use.fold(f64::INFINITY, f64::min)
    }

    /// The series of trajectory `number` for the state or output `series`.
    pub(crate) fn trajectory_series(&self, number: usize, series: usize) -> usize {
        let meta = self.history.meta();
        number * (meta.states.len() + meta.outputs.len()) + series
    }
}
