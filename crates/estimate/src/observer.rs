//! The observer: a list of boxes that follows a record.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: every box holds one interval per state and parameter, and a sample's lengths \
              are checked when it comes in"
)]

use crate::batch::Batches;
use crate::cell::{Cell, cut, insert, remove_contained};
use crate::engine::{Follower, Kept};
use crate::history::Windows;
use crate::measure::Measurements;
use crate::merge::merge;
use crate::options::{Method, ObserverOptions};
use crate::polytope::{Boxes, Polytope, Refuted};
use crate::signals::Signals;
use crate::split::Splitter;
use crate::verdict::{Contradiction, Estimate, Refutation, Undecided, Verdict};
use veribound_flow::{ModeSet, StepFailure, System, Workspace};
use veribound_interval::lanes::{LANES, Mask};
use veribound_interval::{Decimal, Interval};
use veribound_model::{Model, Output, Sample};

/// Where boxes with different modes are kept apart, the list grows to this many times `L` at most.
const MOST_LABELS: usize = 4;

/// A box that cannot be integrated is halved, and its halves again, at most this often; so the time
/// per sample stays bounded.
const RESCUES: u32 = 4;

/// The observer of the talk: a list of boxes over states and parameters that is bisected,
/// integrated from sample to sample, intersected with the measurements, and merged.
///
/// Guarantee: if the true start state and parameters lie in the declared bounds, every measurement
/// error and input in theirs, the signals mean what the model says, and parameters change only
/// where a reset allows it, then after every sample the true state and parameters lie in some box
/// of [`Observer::cells`]. Source: Rauh, Senkel, Aschemann, SCAN 2014; steps numbered as there.
///
/// Cost: memory does not grow with the record. Bisection ends at `L + M` boxes, merging at `L` or
/// at one box per set of active modes, if there are more of these, but at `4 L` always; the time per
/// sample is bounded by the number of boxes.
///
/// ```
/// use veribound_estimate::{Observer, ObserverOptions, Verdict};
/// # use veribound_interval::{Decimal, Interval};
/// # use veribound_model::{Model, Sample};
/// # let text = "format = 1\nstates = [\"x\"]\ninit.x = 1\nparams.k = [0, 2]\nder.x = \"-k*x\"\noutputs.y = \"x +- 0.01\"";
/// # let model = Model::from_text("decay.toml", text)?;
/// # let sample = |time: &str, y: f64| Sample {
/// #     time: Decimal::parse(time).unwrap(),
/// #     inputs: vec![],
/// #     outputs: vec![Some(model.outputs[0].error.enclose(Interval::point(y)))],
/// #     signals: vec![],
/// #     line: 1,
/// # };
/// // x' = -k x from 1, with a true k of 1, read to 0.01.
/// let mut observer = Observer::new(&model, ObserverOptions { every: 1, ..Default::default() });
/// for (time, read) in [("0", 1.0), ("0.5", 0.6065), ("1", 0.3679)] {
///     match observer.step(&sample(time, read))? {
///         Verdict::Consistent(estimate) => assert!(estimate.params[0].contains(1.0)),
///         other => panic!("{other:?}"),
///     }
/// }
/// let left: f64 = observer.cells().iter().map(|cell| cell.z[1].width()).fold(0.0, f64::max);
/// assert!(left < 0.2, "of a prior of 2");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Observer {
    options: ObserverOptions,
    system: System,
    workspace: Workspace,
    follower: Option<Follower>,
    polytope: Option<Polytope>,
    splitter: Splitter,
    measurements: Measurements,
    /// Outputs that may have outliers.
    doubtful: Vec<usize>,
    windows: Windows,
    /// Start intervals of the states and priors of the parameters.
    prior: Vec<Interval>,
    signals: Signals,
    cells: Vec<Cell>,
    batches: Batches,
    /// Boxes of an earlier sample, for their memory.
    spare: Vec<Cell>,
    scale: Vec<f64>,
    held: Option<(Decimal, Vec<Interval>)>,
    samples: u64,
    box_steps: u64,
    boxes_max: usize,
    finished: bool,
}

/// Misuse of an observer.
///
/// ```
/// use veribound_estimate::{Misuse, Observer, ObserverOptions};
/// # use veribound_interval::{Decimal, Interval};
/// # use veribound_model::{Model, Sample};
/// # let text = "format = 1\nstates = [\"x\"]\ninit.x = 1\nparams.k = [0, 2]\nder.x = \"-k*x\"\noutputs.y = \"x +- 0.01\"";
/// # let model = Model::from_text("decay.toml", text)?;
/// # let sample = |time: &str, y: f64| Sample {
/// #     time: Decimal::parse(time).unwrap(),
/// #     inputs: vec![],
/// #     outputs: vec![Some(model.outputs[0].error.enclose(Interval::point(y)))],
/// #     signals: vec![],
/// #     line: 1,
/// # };
/// let mut observer = Observer::new(&model, ObserverOptions::default());
/// observer.step(&sample("1", 1.0))?;
/// assert_eq!(observer.step(&sample("1", 1.0)).unwrap_err(), Misuse::Time);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Misuse {
    /// The sample's lists do not have the lengths of the model's.
    Shape,
    /// The sample's time is not after the one before.
    Time,
    /// The observer has already given a final verdict.
    Finished,
}

impl std::fmt::Display for Misuse {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Misuse::Shape => {
                "the sample does not have the inputs, outputs and signals of the model"
            }
            Misuse::Time => "the sample is not later than the one before",
            Misuse::Finished => "the observer has already given its final verdict",
        })
    }
}

impl std::error::Error for Misuse {}

impl Observer {
    /// An observer for `model`, before the first sample.
    pub fn new(model: &Model, options: ObserverOptions) -> Observer {
        let options = ObserverOptions {
            boxes: options.boxes.max(1),
            every: options.every.max(1),
            ..options
        };
        let may_miss = |output: &Output| output.outliers.is_some_and(|outliers| outliers.most > 0);
        let doubtful = model.outputs.iter().enumerate();
        let doubtful = doubtful.filter(|(_, output)| may_miss(output));
        let doubtful = doubtful.map(|(position, _)| position).collect();
        let system = System::new(model);
        let layout = system.layout();
        let prior: Vec<Interval> = model
            .states
            .iter()
            .map(|state| state.init)
            .chain(model.params.iter().map(|param| param.bounds))
            .collect();
        Observer {
            workspace: Workspace::new(&system, options.step),
            follower: Follower::new(model, options.engine),
            polytope: (options.method == Method::Polytope).then(|| Polytope::new(model, &options)),
            splitter: Splitter::new(model),
            measurements: Measurements::new(model, layout),
            doubtful,
            windows: Windows::new(&system, &options.windows),
            cells: vec![Cell::new(prior.clone())],
            batches: Batches::default(),
            spare: Vec::new(),
            scale: vec![1.0; prior.len()],
            prior,
            signals: Signals::new(model),
            system,
            options,
            held: None,
            samples: 0,
            box_steps: 0,
            boxes_max: 1,
            finished: false,
        }
    }

    /// [`Method::Polytope`]: what the last sample took, in products of coefficients; at most its budget and one piece of work, as
    /// a try to cross a surface.
    pub fn spent(&self) -> u64 {
        self.polytope.as_ref().map_or(0, |polytope| polytope.spent)
    }

    /// Starts from a list of parameter boxes, the estimate of an earlier run on the same system,
    /// instead of the whole prior. Each is intersected with the prior; the parameters that a
    /// signal can reset keep their prior. Returns false, and changes nothing, when no box is left
    /// or a sample was already taken.
    pub fn start_from(&mut self, params: &[Vec<Interval>]) -> bool {
        let states = self.system.layout().states;
        if self.samples > 0 {
            return false;
        }
        let mut cells = Vec::new();
        for list in params {
            if list.len() != self.prior.len() - states {
                return false;
            }
            let mut z = self.prior.clone();
            for (param, bounds) in list.iter().enumerate() {
                if !self.signals.can_reset(param) {
                    z[states + param] = z[states + param].intersect(*bounds);
                }
            }
            if z.iter().all(|x| !x.is_empty()) {
                cells.push(Cell::new(z));
            }
        }
        if cells.is_empty() {
            return false;
        }
        remove_contained(&mut cells);
        self.cells = cells;
        true
    }

    /// The boxes; every solution that agrees with the record so far lies in one of them.
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// Steps of single boxes done so far.
    pub fn box_steps(&self) -> u64 {
        self.box_steps
    }

    /// The longest list there has been.
    pub fn boxes_max(&self) -> usize {
        self.boxes_max
    }

    /// Takes the next sample.
    ///
    /// Errors are misuse; what can and cannot be proved is in the [`Verdict`].
    ///
    /// Outputs that may have outliers are taken for missing: no single sample of them proves anything.
    pub fn step(&mut self, sample: &Sample) -> Result<Verdict, Misuse> {
        self.check(sample)?;
        let mut without = None;
        for output in &self.doubtful {
            without.get_or_insert_with(|| sample.clone()).outputs[*output] = None;
        }
        let sample = without.as_ref().unwrap_or(sample);
        let steps_before = self.box_steps;
        let position = self.samples;
        let held = self.held.take();
        if let Some((time, inputs)) = &held {
            let dt = (&sample.time - time).to_interval();
            let turn = position.is_multiple_of(self.options.every as u64);
            if turn {
                self.bisect(inputs, dt);
            }
            if let Err((reason, cell)) = self.integrate(inputs, dt) {
                return Ok(self.undecided((position, sample), reason, cell));
            }
        }
        self.samples += 1;
        self.signals.note(sample);
        let resets = self.reset(sample);
        let before = held.as_ref().map(|(_, inputs)| inputs.as_slice());
        let before_time = held.as_ref().map(|(time, _)| time);
        if let Err((reason, cell)) = self.jump(sample, before, &resets) {
            return Ok(self.undecided((position, sample), reason, cell));
        }
        if let Err(contradiction) = self.narrow(sample) {
            self.finished = true;
            return Ok(Verdict::Inconsistent(Refutation {
                sample: position,
                line: sample.line,
                time: sample.time.clone(),
                contradiction,
            }));
        }
        let dt = before_time.map_or(Interval::ZERO, |time| (&sample.time - time).to_interval());
        if let Err(refuted) = self.gather((position, dt), sample, &resets) {
            self.finished = true;
            return Ok(Verdict::Inconsistent(Refutation {
                sample: refuted.sample,
                line: refuted.line,
                time: refuted.time,
                contradiction: refuted.contradiction,
            }));
        }
        if position == 0 {
            self.windows.restart(&mut self.cells);
        }
        self.windows.renew(&mut self.cells);
        self.boxes_max = self.boxes_max.max(self.cells.len());
        self.label(&sample.inputs);
        if self.crowded() || position.is_multiple_of(self.options.every as u64) {
            self.merge();
        }
        self.held = Some((sample.time.clone(), sample.inputs.clone()));
        Ok(Verdict::Consistent(self.estimate(
            sample,
            resets,
            self.box_steps - steps_before,
        )))
    }

    fn check(&self, sample: &Sample) -> Result<(), Misuse> {
        let layout = self.system.layout();
        if self.finished {
            return Err(Misuse::Finished);
        }
        let fits = sample.outputs.len() == self.measurements.len()
            && sample.signals.len() == self.signals.len();
        if !fits || sample.inputs.len() != layout.inputs {
            return Err(Misuse::Shape);
        }
        match &self.held {
            Some((time, _)) if sample.time <= *time => Err(Misuse::Time),
            _ => Ok(()),
        }
    }

    fn crowded(&self) -> bool {
        self.cells.len() > self.options.boxes + self.options.bisections
    }

    /// Step 8.
    fn merge(&mut self) {
        self.update_scale();
        let across = self.options.merge_across_modes;
        merge(&mut self.cells, self.options.boxes, across, &self.scale);
        // Groups of modes that switch independently multiply the sets of modes there can be.
        let most = self.options.boxes.saturating_mul(MOST_LABELS);
        merge(&mut self.cells, most, true, &self.scale);
    }

    /// Step 2: `M` bisections, the box of largest volume first, until there are `L + M` boxes.
    fn bisect(&mut self, inputs: &[Interval], dt: Interval) {
        self.update_scale();
        let mut volumes: Vec<f64> = self
            .cells
            .iter()
            .map(|cell| self.splitter.volume(cell, &self.scale))
            .collect();
        let mut left = self.options.bisections;
        while left > 0 && self.cells.len() < self.options.boxes + self.options.bisections {
            let largest = volumes
                .iter()
                .enumerate()
                .max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(&a.0)))
                .filter(|(_, volume)| **volume > 0.0);
            let Some((position, _)) = largest else {
                return;
            };
            let parts = self
                .splitter
                .split(&self.cells[position], inputs, dt.hi(), &self.options);
            if parts.len() < 2 {
                volumes[position] = 0.0;
                continue;
            }
            left -= 1;
            self.cells.swap_remove(position);
            volumes.swap_remove(position);
            for part in parts {
                volumes.push(self.splitter.volume(&part, &self.scale));
                self.cells.push(part);
            }
        }
    }

    /// Step 3: every box to the next sample; on failure the list stays what it was.
    fn integrate(
        &mut self,
        inputs: &[Interval],
        dt: Interval,
    ) -> Result<(), (StepFailure, Vec<Interval>)> {
        let cells = std::mem::take(&mut self.cells);
        // Boxes of earlier samples lend their memory.
        let mut moved = std::mem::take(&mut self.spare);
        let failed = self.advance(&cells, &mut moved, inputs, dt);
        if !failed.is_empty() {
            match self.rescue_all(&cells, moved, &failed, inputs, dt) {
                Ok(all) => moved = all,
                Err(failure) => {
                    self.cells = cells;
                    return Err(failure);
                }
            }
        }
        self.cells = moved;
        self.spare = cells;
        self.windows.advance(dt);
        Ok(())
    }

    /// Moves boxes eight at a time, those with the same modes side by side, into `moved`; behind them
    /// stand more boxes where some solutions jumped and others did not. What stands there for those
    /// that could not be integrated means nothing; they are returned by position, in order, with the
    /// reasons.
    fn advance(
        &mut self,
        cells: &[Cell],
        moved: &mut Vec<Cell>,
        inputs: &[Interval],
        dt: Interval,
    ) -> Vec<(usize, StepFailure)> {
        moved.truncate(cells.len());
        for (to, from) in moved.iter_mut().zip(cells) {
            to.copy_from(from);
        }
        moved.extend_from_slice(&cells[moved.len()..]);
        let mut failed = Vec::new();
        let mut batches = std::mem::take(&mut self.batches);
        self.box_steps += cells.len() as u64;
        for batch in batches.of_alike(cells) {
            batch.load(cells);
            let (system, workspace) = (&self.system, &mut self.workspace);
            let reports = system.step_eight(&mut batch.boxes, batch.lanes, inputs, dt, workspace);
            let mut done = Mask::NONE;
            for (lane, position) in batch.positions() {
                match reports[lane] {
                    Ok(report) => {
                        moved[position].modes_during = report.modes_during;
                        done |= Mask::lane(lane);
                    }
                    Err(reason) => failed.push((position, reason)),
                }
            }
            // Of the others nothing is known, neither where they are nor how fast they were.
            batch.lanes = done;
            batch.store(moved);
            let velocities = self.workspace.velocities();
            self.windows.extend(moved, batch, velocities, dt);
            for branch in self.workspace.branches() {
                for (_, position) in batch.positions().filter(|(lane, _)| *lane == branch.lane) {
                    let mut other = moved[position].clone();
                    other.z[..branch.states.len()].copy_from_slice(&branch.states);
                    moved.push(other);
                }
            }
        }
        self.batches = batches;
        if let Some(follower) = &self.follower {
            for (position, (cell, moved)) in cells.iter().zip(moved.iter_mut()).enumerate() {
                if failed.iter().all(|(failed, _)| *failed != position) {
                    follower.advance(cell, moved, (inputs, dt));
                }
            }
            // What stands behind them are solutions that jumped at other times.
            for other in moved.iter_mut().skip(cells.len()) {
                other.kept = Kept::default();
            }
        }
        failed.sort_by_key(|(position, _)| *position);
        failed
    }

    /// The moved boxes, in place of each that could not be integrated its moved parts.
    fn rescue_all(
        &mut self,
        cells: &[Cell],
        moved: Vec<Cell>,
        failed: &[(usize, StepFailure)],
        inputs: &[Interval],
        dt: Interval,
    ) -> Result<Vec<Cell>, (StepFailure, Vec<Interval>)> {
        let mut all = Vec::with_capacity(cells.len() + failed.len());
        let mut failed = failed.iter().peekable();
        let mut moved = moved;
        all.extend(moved.split_off(cells.len()));
        for (position, (cell, moved)) in cells.iter().zip(moved).enumerate() {
            match failed.next_if(|(failed, _)| *failed == position) {
                None => all.push(moved),
                Some((_, reason)) => self
                    .rescue(cell, 0, inputs, dt, &mut all)
                    .map_err(|()| (*reason, cell.z.clone()))?,
            }
        }
        Ok(all)
    }

    /// A smaller box may do: halves the coordinate with the largest share left, and adds the moved
    /// parts to `all`.
    fn rescue(
        &mut self,
        cell: &Cell,
        halved: u32,
        inputs: &[Interval],
        dt: Interval,
        all: &mut Vec<Cell>,
    ) -> Result<(), ()> {
        let parts = self.widest(cell).and_then(|coordinate| {
            let x = cell.z[coordinate];
            cut(x, x.mid()).map(|parts| (coordinate, parts))
        });
        let Some((coordinate, (below, above))) = parts.filter(|_| halved < RESCUES) else {
            return Err(());
        };
        let mut halves = [cell.clone(), cell.clone()];
        halves[0].z[coordinate] = below;
        halves[1].z[coordinate] = above;
        let mut moved = Vec::new();
        let failed = self.advance(&halves, &mut moved, inputs, dt);
        all.extend(moved.split_off(halves.len()));
        for (position, (half, moved)) in halves.iter().zip(moved).enumerate() {
            if failed.iter().any(|(failed, _)| *failed == position) {
                self.rescue(half, halved + 1, inputs, dt, all)?;
            } else {
                all.push(moved);
            }
        }
        Ok(())
    }

    fn widest(&self, cell: &Cell) -> Option<usize> {
        (0..cell.z.len())
            .filter(|i| cell.z[*i].width() > 0.0)
            .max_by(|a, b| {
                let share = |i: usize| cell.z[i].width() / self.scale[i];
                share(*a).total_cmp(&share(*b))
            })
    }

    /// Steps 4 to 6: intersection with the sample, deletion of boxes without a point left.
    fn narrow(&mut self, sample: &Sample) -> Result<(), Contradiction> {
        let mut nearest: Option<Contradiction> = None;
        let mut cells = std::mem::take(&mut self.cells);
        let mut impossible = vec![false; cells.len()];
        let mut batches = std::mem::take(&mut self.batches);
        for batch in batches.of_neighbours(&cells) {
            let mut found = [const { None }; LANES];
            batch.load(&cells);
            self.measurements
                .narrow(batch, sample, &self.signals, &mut found);
            self.windows.narrow(&cells, batch, &mut found);
            batch.store(&mut cells);
            for (lane, position) in batch.positions() {
                let Some(found) = found[lane].take() else {
                    continue;
                };
                impossible[position] = true;
                if nearest
                    .as_ref()
                    .is_none_or(|known| found.is_nearer_than(known))
                {
                    nearest = Some(found);
                }
            }
        }
        self.batches = batches;
        if let Some(follower) = &self.follower {
            for (cell, impossible) in cells.iter_mut().zip(&mut impossible) {
                if *impossible {
                    continue;
                }
                if let Err(found) = follower.measure(cell, sample) {
                    *impossible = true;
                    if nearest
                        .as_ref()
                        .is_none_or(|known| found.is_nearer_than(known))
                    {
                        nearest = Some(found);
                    }
                }
            }
        }
        let kept = cells.into_iter().zip(impossible).filter(|(_, gone)| !gone);
        self.cells = kept.map(|(cell, _)| cell).collect();
        match nearest {
            Some(contradiction) if self.cells.is_empty() => Err(contradiction),
            _ => Ok(()),
        }
    }

    /// What all samples say together: cuts the boxes with what is left.
    fn gather(
        &mut self,
        (position, dt): (u64, Interval),
        sample: &Sample,
        resets: &[bool],
    ) -> Result<(), Refuted> {
        let Some(polytope) = &mut self.polytope else {
            return Ok(());
        };
        let mut hull = self.cells.iter();
        let first = hull.next().map_or(Vec::new(), |cell| cell.z.clone());
        let mut states = hull.fold(first, |mut hull, cell| {
            hull.iter_mut()
                .zip(&cell.z)
                .for_each(|(all, x)| *all = all.hull(*x));
            hull
        });
        let params = states.split_off(self.system.layout().states);
        let signals = &self.signals;
        let boxes = Boxes {
            position,
            dt,
            proves: &|signal| signals.proves(signal, &sample.time),
            resets,
            states,
            params,
        };
        let hull = boxes.states.len();
        let left = polytope.take(sample, boxes)?;
        let states = left.states.unwrap_or(vec![Interval::ENTIRE; hull]);
        let all: Vec<Interval> = states.into_iter().chain(left.params).collect();
        let mut nearest: Option<Contradiction> = None;
        self.cells.retain_mut(|cell| {
            let mut apart = None;
            for (quantity, (x, allowed)) in cell.z.iter_mut().zip(&all).enumerate() {
                let (enclosure, allowed) = (*x, *allowed);
                *x = x.intersect(allowed);
                if x.is_empty() {
                    apart = apart.or(Some(Contradiction::Apart {
                        quantity,
                        enclosure,
                        allowed,
                    }));
                }
            }
            let is_left = apart.is_none();
            let is_nearer = |apart: &Contradiction| {
                nearest
                    .as_ref()
                    .is_none_or(|known| apart.is_nearer_than(known))
            };
            if let Some(apart) = apart.filter(is_nearer) {
                nearest = Some(apart);
            }
            is_left
        });
        match nearest {
            Some(contradiction) if self.cells.is_empty() => Err(Refuted {
                sample: position,
                line: sample.line,
                time: sample.time.clone(),
                contradiction,
            }),
            _ => Ok(()),
        }
    }

    /// Step 7: parameters that may be new get their whole prior back, as up to three boxes
    /// `[T_init.lo, T.lo]`, `[T.lo, T.hi]`, `[T.hi, T_init.hi]` instead of one; those that another
    /// box already contains are left out.
    ///
    /// Comes before the intersection with the sample: what is measured at a reset already knows the
    /// new value.
    fn reset(&mut self, sample: &Sample) -> Vec<bool> {
        let states = self.system.layout().states;
        if self.samples == 1 {
            // At the first sample every parameter has its whole prior.
            return vec![false; self.prior.len() - states];
        }
        let resets = self.signals.resets(&sample.time);
        if resets.iter().any(|reset| *reset) {
            // Parameters of the past say nothing of these.
            for cell in &mut self.cells {
                cell.kept = Kept::default();
            }
        }
        for (param, _) in resets.iter().enumerate().filter(|(_, reset)| **reset) {
            if self.crowded() {
                self.label(&sample.inputs);
                self.merge();
            }
            let coordinate = states + param;
            let whole = self.prior[coordinate];
            let mut added = Vec::new();
            for cell in &self.cells {
                let known = cell.z[coordinate];
                for (lo, hi) in [(whole.lo(), known.lo()), (known.hi(), whole.hi())] {
                    if lo < hi
                        && let Some(piece) = Interval::new(lo, hi)
                    {
                        let mut part = cell.clone();
                        part.z[coordinate] = piece;
                        added.push(part);
                    }
                }
            }
            for part in added {
                insert(&mut self.cells, part);
            }
            self.boxes_max = self.boxes_max.max(self.cells.len());
        }
        resets
    }

    /// What jumps at the sample because an input or a parameter is a new one there, or because it starts
    /// there: a measurement may be of the state before or after that.
    ///
    /// What jumps there for other reasons did so at the end of the step before.
    fn jump(
        &mut self,
        sample: &Sample,
        inputs_before: Option<&[Interval]>,
        resets: &[bool],
    ) -> Result<(), (StepFailure, Vec<Interval>)> {
        if !self.system.jumps() {
            return Ok(());
        }
        let states = self.system.layout().states;
        let mut changed = vec![inputs_before.is_none(); states];
        match inputs_before {
            None => changed.resize(self.system.layout().len(), true),
            Some(before) => {
                changed.extend(resets);
                let inputs = sample.inputs.iter().zip(before);
                changed.extend(inputs.map(|(now, before)| !now.is_subset_of(*before)));
            }
        }
        let mut added = Vec::new();
        for cell in &self.cells {
            let (x, p) = cell.z.split_at(states);
            let (system, w) = (&self.system, &mut self.workspace);
            let jumps = system.jump_at_once(x, p, &sample.inputs, &changed, w);
            let Some(jumps) = jumps.map_err(|reason| (reason, cell.z.clone()))? else {
                continue;
            };
            for end in jumps.ends {
                let mut other = cell.clone();
                other.z[..states].copy_from_slice(&end);
                other.kept = Kept::default();
                self.windows.forget(&mut other, &jumps.jumped);
                added.push(other);
            }
        }
        for cell in added {
            insert(&mut self.cells, cell);
        }
        Ok(())
    }

    fn undecided(
        &mut self,
        (position, sample): (u64, &Sample),
        reason: StepFailure,
        cell: Vec<Interval>,
    ) -> Verdict {
        self.finished = true;
        Verdict::Undecided(Undecided {
            sample: position,
            line: sample.line,
            time: sample.time.clone(),
            reason,
            cell,
        })
    }

    /// Marks every box with the modes possible on it, with the input of the coming step.
    fn label(&mut self, inputs: &[Interval]) {
        let mut batches = std::mem::take(&mut self.batches);
        for batch in batches.of_neighbours(&self.cells) {
            batch.load(&self.cells);
            let (system, workspace) = (&self.system, &mut self.workspace);
            let modes = system.active_modes(&batch.boxes, batch.lanes, inputs, workspace);
            for (lane, position) in batch.positions() {
                self.cells[position].modes = modes[lane];
            }
        }
        self.batches = batches;
    }

    /// Units in which widths are compared: the prior of a parameter, the list's own hull of a
    /// state.
    fn update_scale(&mut self) {
        let states = self.system.layout().states;
        for coordinate in 0..self.scale.len() {
            let width = if coordinate < states {
                let hull = |acc: Interval, cell: &Cell| acc.hull(cell.z[coordinate]);
                self.cells.iter().fold(Interval::EMPTY, hull).width()
            } else {
                self.prior[coordinate].width()
            };
            self.scale[coordinate] = if width > 0.0 && width.is_finite() {
                width
            } else {
                1.0
            };
        }
    }

    fn estimate(&mut self, sample: &Sample, resets: Vec<bool>, box_steps: u64) -> Estimate {
        let states = self.system.layout().states;
        let mut hull = vec![Interval::EMPTY; self.prior.len()];
        let mut outputs = vec![Interval::EMPTY; sample.outputs.len()];
        let mut modes = ModeSet::EMPTY;
        let mut batches = std::mem::take(&mut self.batches);
        for batch in batches.of_neighbours(&self.cells) {
            batch.load(&self.cells);
            let values = self.measurements.outputs(batch, &sample.inputs);
            for ((all, value), measured) in outputs.iter_mut().zip(values).zip(&sample.outputs) {
                for (lane, _) in batch.positions() {
                    let value = value.get(lane);
                    *all = all.hull(measured.map_or(value, |measured| value.intersect(measured)));
                }
            }
        }
        self.batches = batches;
        for cell in &self.cells {
            for (all, x) in hull.iter_mut().zip(&cell.z) {
                *all = all.hull(*x);
            }
            modes = modes.union(cell.modes).union(cell.modes_during);
        }
        let params = hull.split_off(states);
        Estimate {
            states: hull,
            params,
            outputs,
            modes,
            resets,
            boxes: self.cells.len(),
            box_steps,
        }
    }
}
