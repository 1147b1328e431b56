//! One step of validated integration for boxes of states and parameters, eight at a time.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: a workspace's slices have the lengths of its system's layout"
)]

use crate::apriori::{Apriori, AprioriFailure};
use crate::face::{Faces, Step};
use crate::modes::{ModeMasks, ModeSet};
use crate::system::{Registers, System};
use veribound_interval::Interval;
use veribound_interval::lanes::{Interval8, LANES, Mask};

/// A gap between two samples is divided into at most this many steps, before halvings, so that the
/// time per sample stays bounded.
const MOST_PARTS: f64 = 1024.0;

/// Settings of the box method.
///
/// ```
/// use veribound_flow::StepOptions;
///
/// let options = StepOptions { order: 4, ..StepOptions::default() };
/// assert_eq!(options.longest, 0.05);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepOptions {
    /// Order of the Taylor series where one smooth right-hand side is certain; 1 to 12.
    pub order: usize,
    /// A step that finds no a-priori box is halved at most this many times.
    pub halvings: u32,
    /// Longest single step in seconds; longer gaps between samples are divided, into at most 1024
    /// parts.
    pub longest: f64,
}

impl Default for StepOptions {
    fn default() -> Self {
        StepOptions {
            order: 2,
            halvings: 8,
            longest: 0.05,
        }
    }
}

/// Why a step could not be proved. It says nothing about the existence of solutions.
///
/// ```
/// use veribound_flow::{StepOptions, System, Workspace};
/// # use veribound_interval::Interval;
/// // x' = x^2 from 1 is infinite after a second.
/// let text = "format = 1\nstates = [\"x\"]\ninit.x = 1\nder.x = \"x^2\"\noutputs.y = \"x +- 0.01\"";
/// let model = veribound_model::Model::from_text("explosion.toml", text)?;
/// let system = System::new(&model);
/// let mut workspace = Workspace::new(&system, StepOptions::default());
/// let mut x = [Interval::ONE];
/// let failed = system.step(&mut x, &[], &[], Interval::point(2.0), &mut workspace);
/// // No claim is made, and nothing is changed.
/// assert!(failed.is_err() && x[0] == Interval::ONE);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StepFailure {
    /// No a-priori box was found, even on the shortest step allowed.
    Apriori(AprioriFailure),
    /// The box grew beyond what floating-point numbers hold.
    Unbounded,
    /// This state may leave the domain in which the guards of the modes are proved to leave no gap.
    LeavesDomain {
        /// Index of the state.
        state: usize,
    },
    /// This input lies outside the domain in which the guards are proved to leave no gap.
    InputOutsideDomain {
        /// Index of the input.
        input: usize,
    },
}

/// What is proved about one step besides the box at its end and the tube.
///
/// ```
/// use veribound_flow::{StepOptions, System, Workspace};
/// # use veribound_interval::{Decimal, Interval};
/// # let text = "format = 1\nstates = [\"x\"]\ninit.x = 1\nparams.k = [0.5, 1]\nder.x = \"-k*x\"\noutputs.y = \"x +- 0.01\"";
/// # let model = veribound_model::Model::from_text("decay.toml", text)?;
/// let system = System::new(&model);
/// let mut workspace = Workspace::new(&system, StepOptions::default());
/// let mut x = [model.states[0].init];
/// let dt = Decimal::parse("0.1").unwrap().to_interval();
/// let report = system.step(&mut x, &[model.params[0].bounds], &[], dt, &mut workspace);
/// assert!(report.expect("a proof").modes_during.contains(0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StepReport {
    /// Modes whose guard, as written, holds somewhere on the tube: no other was active during the
    /// step.
    pub modes_during: ModeSet,
}

/// Scratch for one thread.
///
/// ```
/// use veribound_flow::{StepOptions, System, Workspace};
/// # use veribound_interval::{Decimal, Interval};
/// # let text = "format = 1\nstates = [\"x\"]\ninit.x = 1\nparams.k = [0.5, 1]\nder.x = \"-k*x\"\noutputs.y = \"x +- 0.01\"";
/// # let model = veribound_model::Model::from_text("decay.toml", text)?;
/// let system = System::new(&model);
/// let mut workspace = Workspace::new(&system, StepOptions::default());
/// let mut x = [model.states[0].init];
/// let dt = Decimal::parse("0.1").unwrap().to_interval();
/// system.step(&mut x, &[model.params[0].bounds], &[], dt, &mut workspace).expect("a proof");
/// // At all times between, not at the end alone.
/// assert!(workspace.tube()[0].contains(1.0) && workspace.tube()[0].contains((-0.07_f64).exp()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Workspace {
    options: StepOptions,
    pub(crate) q: Vec<Interval8>,
    pub(crate) apriori: Apriori,
    pub(crate) registers: Registers,
    faces: Faces,
    modes: ModeMasks,
    branches: Vec<Branch>,
    divisions: Vec<Division>,
    end: Vec<Interval8>,
    part_tube: Vec<Interval8>,
    tubes: Vec<Interval8>,
    velocities: Vec<Interval8>,
    tube: Vec<Interval>,
    velocity: Vec<Interval>,
}

impl Workspace {
    /// Scratch for steps of `system`.
    pub fn new(system: &System, options: StepOptions) -> Workspace {
        let options = StepOptions {
            order: options.order.clamp(1, 12),
            ..options
        };
        let states = system.layout.states;
        Workspace {
            options,
            q: vec![Interval8::ZERO; system.layout.len()],
            apriori: Apriori::default(),
            registers: system.registers(options.order + 1),
            faces: Faces::new(system, options.order),
            modes: ModeMasks::default(),
            branches: Vec::new(),
            divisions: Vec::new(),
            end: vec![Interval8::ZERO; states],
            part_tube: vec![Interval8::ZERO; states],
            tubes: vec![Interval8::ZERO; states],
            velocities: vec![Interval8::ZERO; states],
            tube: vec![Interval::ZERO; states],
            velocity: vec![Interval::ZERO; states],
        }
    }

    /// After [`System::step`]: encloses the states at every time of the step.
    pub fn tube(&self) -> &[Interval] {
        &self.tube
    }

    /// After [`System::step`]: encloses the velocity of every state at almost every time of the
    /// step; everything for a state that may have jumped.
    pub fn velocity(&self) -> &[Interval] {
        &self.velocity
    }

    /// After [`System::step_eight`]: boxes that belong to the end of a step beside the ones it was given.
    pub fn branches(&self) -> &[Branch] {
        &self.branches
    }

    /// After [`System::step_eight`]: as [`Workspace::tube`], for every box that was moved; of the other
    /// lanes it says nothing.
    pub fn tubes(&self) -> &[Interval8] {
        &self.tubes
    }

    /// After [`System::step_eight`]: as [`Workspace::velocity`], for every box that was moved; of the
    /// other lanes it says nothing.
    pub fn velocities(&self) -> &[Interval8] {
        &self.velocities
    }
}

/// One more box at the end of a step that jumps, for a box of which some solutions jumped and others
/// did not, or some earlier and some later.
///
/// ```
/// use veribound_flow::{Branch, StepOptions, System, Workspace};
/// use veribound_interval::Interval;
///
/// // A ball that has reached the floor, or not.
/// let text = r#"
///     format = 1
///     states = ["h", "v"]
///     init = { h = 1, v = 0 }
///     der = { h = "v", v = "-10" }
///     jumps.floor = { when = "h <= 0 and v <= 0", set.v = "-0.5*v" }
///     outputs.y = "h +- 0.1"
/// "#;
/// let model = veribound_model::Model::from_text("ball.toml", text)?;
/// let system = System::new(&model);
/// let mut workspace = Workspace::new(&system, StepOptions::default());
/// let mut states = [Interval::new(0.05, 0.2).unwrap(), Interval::point(-1.0)];
/// let moved = system.step(&mut states, &[], &[], Interval::point(0.1), &mut workspace);
/// moved.map_err(|failed| format!("{failed:?}"))?;
/// let others: &[Branch] = workspace.branches();
/// assert!(!others.is_empty() && others[0].states.len() == 2);
/// // The hull holds both kinds: falling, and thrown back.
/// assert!(states[1].contains(-2.0) && states[1].hi() > 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Branch {
    /// Where the box stood among the eight.
    pub lane: usize,
    /// One interval per state.
    pub states: Vec<Interval>,
}

/// Boxes whose step is under way in parts of equal length, `done` of `parts` behind them.
#[derive(Debug, Clone)]
struct Division {
    lanes: Mask,
    parts: u64,
    done: u64,
    halvings: u32,
}

impl System {
    /// Moves a box of states over `dt` seconds.
    ///
    /// Guarantee: for every start state in `states`, every constant parameter in `params`, every
    /// measurable input with values in `inputs` and every length in `dt`, every Filippov solution
    /// of the model lies in the new `states` at the end and in [`Workspace::tube`] at all times
    /// between. On failure `states` is unchanged. Where solutions may or may not have jumped, `states` is
    /// the hull of [`System::step_eight`]'s boxes.
    ///
    /// Cost: that of [`System::step_eight`], which moves eight boxes in the same time, and one
    /// allocation.
    pub fn step(
        &self,
        states: &mut [Interval],
        params: &[Interval],
        inputs: &[Interval],
        dt: Interval,
        workspace: &mut Workspace,
    ) -> Result<StepReport, StepFailure> {
        let (report, ends) = self.step_one(states, params, inputs, dt, workspace);
        if report.is_ok() {
            for (i, x) in states.iter_mut().enumerate() {
                *x = ends
                    .iter()
                    .fold(Interval::EMPTY, |hull, end| hull.hull(end[i]));
            }
        }
        report
    }

    /// As [`System::step`], with the boxes at the end apart where some solutions jumped and others did
    /// not, and what is proved besides.
    pub fn step_apart(
        &self,
        states: &[Interval],
        params: &[Interval],
        inputs: &[Interval],
        dt: Interval,
        workspace: &mut Workspace,
    ) -> Result<(Vec<Vec<Interval>>, StepReport), StepFailure> {
        let (report, ends) = self.step_one(states, params, inputs, dt, workspace);
        report.map(|report| (ends, report))
    }

    fn step_one(
        &self,
        states: &[Interval],
        params: &[Interval],
        inputs: &[Interval],
        dt: Interval,
        w: &mut Workspace,
    ) -> (Result<StepReport, StepFailure>, Vec<Vec<Interval>>) {
        let splat = |x: &Interval| Interval8::splat(*x);
        let mut boxes: Vec<Interval8> = states.iter().chain(params).map(splat).collect();
        let [report, ..] = self.step_eight(&mut boxes, Mask::lane(0), inputs, dt, w);
        let first = |list: &[Interval8]| -> Vec<Interval> {
            let list = list.iter().take(states.len());
            list.map(|x| x.get(0)).collect()
        };
        (w.tube, w.velocity) = (first(&w.tubes), first(&w.velocities));
        let branches = w.branches.iter().map(|branch| branch.states.clone());
        let ends = std::iter::once(first(&boxes)).chain(branches).collect();
        (report, ends)
    }

    /// After [`System::step`] or [`System::step_apart`]: encloses the velocity of every state at almost every time of the
    /// step at which no state jumps, from the right-hand sides on the tube; `None` where they are not bounded there.
    pub(crate) fn velocity_in_tube(&self, workspace: &mut Workspace) -> Option<Vec<Interval>> {
        let mut failed = [None; LANES];
        let Workspace {
            q,
            apriori,
            registers,
            ..
        } = workspace;
        let candidate = &mut apriori.candidate;
        let known = self.velocity(q, Mask::lane(0), candidate, &mut failed, registers);
        let velocity = candidate.velocity.iter().map(|x| x.get(0));
        known.get(0).then(|| velocity.collect())
    }

    /// Moves the boxes in `lanes` over `dt` seconds. `boxes` holds the states, then the parameters.
    ///
    /// Guarantee: that of [`System::step`] for every box, the end being the new box together with its
    /// [`Workspace::branches`]; what becomes of one does not depend on its neighbours. The results of the
    /// other lanes mean nothing.
    ///
    /// Cost: one a-priori box and two bounds per state for all eight boxes together; no allocation.
    pub fn step_eight(
        &self,
        boxes: &mut [Interval8],
        lanes: Mask,
        inputs: &[Interval],
        dt: Interval,
        workspace: &mut Workspace,
    ) -> [Result<StepReport, StepFailure>; LANES] {
        let n = self.layout.states;
        let w = workspace;
        w.branches.clear();
        let start = (!self.jumps.is_empty()).then(|| boxes.to_vec());
        let mut failed = self.flow_eight(boxes, lanes, inputs, dt, w);
        if let Some(start) = start {
            self.jump_eight(&start, boxes, lanes, inputs, dt, w, &mut failed);
        }
        let moved = lanes & Mask::from_fn(|lane| failed[lane].is_none());
        w.q[..n].copy_from_slice(&w.tubes);
        self.modes_on(&w.q, moved, &mut w.modes, &mut w.registers);
        let modes = w.modes.sets();
        std::array::from_fn(|lane| match failed[lane] {
            Some(failure) => Err(failure),
            None => Ok(StepReport {
                modes_during: modes[lane],
            }),
        })
    }

    /// Replaces the flows of boxes that may jump by flights.
    #[allow(clippy::too_many_arguments, reason = "a part of step_eight")]
    fn jump_eight(
        &self,
        start: &[Interval8],
        boxes: &mut [Interval8],
        lanes: Mask,
        inputs: &[Interval],
        dt: Interval,
        w: &mut Workspace,
        failed: &mut [Option<StepFailure>; LANES],
    ) {
        let n = self.layout.states;
        let flown = lanes & Mask::from_fn(|lane| failed[lane].is_none());
        let tubes = w.tubes.clone();
        let velocities = w.velocities.clone();
        let all_jumped = boxes.iter().fold(Mask::NONE, |all, x| all | x.is_empty());
        let jumping = self.may_jump(&tubes, start, inputs, flown, w) | (flown & all_jumped);
        let mut result = (tubes, velocities);
        for lane in (lanes & (jumping | !flown)).lanes() {
            let own: Vec<Interval> = start.iter().map(|x| x.get(lane)).collect();
            let (states, params) = own.split_at(n);
            let parts = w.least_parts(dt);
            match self.fly(states, params, inputs, (dt, parts), w) {
                Err(failure) => failed[lane] = Some(failure),
                Ok(flight) => {
                    failed[lane] = None;
                    for state in 0..n {
                        result.0[state].set(lane, flight.tube[state]);
                        result.1[state].set(lane, flight.velocity[state]);
                    }
                    let mut ends = flight.ends.into_iter();
                    for (x, end) in boxes.iter_mut().zip(ends.next().unwrap_or_default()) {
                        x.set(lane, end);
                    }
                    w.branches
                        .extend(ends.map(|states| Branch { lane, states }));
                }
            }
        }
        (w.tubes, w.velocities) = result;
    }

    /// As [`System::step_eight`], without jumps: what holds until the first one. The end is empty where
    /// every solution has jumped before.
    pub(crate) fn flow_eight(
        &self,
        boxes: &mut [Interval8],
        lanes: Mask,
        inputs: &[Interval],
        dt: Interval,
        w: &mut Workspace,
    ) -> [Option<StepFailure>; LANES] {
        let n = self.layout.states;
        w.load(boxes, inputs);
        w.tubes.copy_from_slice(&boxes[..n]);
        w.velocities.fill(Interval8::EMPTY);
        let mut failed = [None; LANES];
        let least_parts = w.least_parts(dt);
        w.divisions.clear();
        w.divisions.push(Division {
            lanes,
            parts: least_parts,
            done: 0,
            halvings: 0,
        });
        // Boxes that need shorter parts go on by themselves.
        while let Some(mut now) = w.divisions.pop() {
            while now.done < now.parts && !now.lanes.none() {
                let part = if now.parts == 1 {
                    dt
                } else {
                    dt / Interval::point(now.parts as f64)
                };
                let moved = self.single_step(part, now.lanes, w, &mut failed);
                now.done += 1;
                for state in 0..n {
                    let tube = w.tubes[state].hull(&w.part_tube[state]);
                    w.tubes[state].assign(moved, &tube);
                    let velocity = w.velocities[state].hull(&w.apriori.velocity[state]);
                    w.velocities[state].assign(moved, &velocity);
                }
                let moved_on = moved.without(
                    w.q[..n]
                        .iter()
                        .fold(Mask::NONE, |gone, x| gone | x.is_empty()),
                );
                let again = if now.halvings < w.options.halvings {
                    let halve = |lane: usize| matches!(failed[lane], Some(StepFailure::Apriori(_)));
                    now.lanes.without(moved) & Mask::from_fn(halve)
                } else {
                    Mask::NONE
                };
                if !again.none() {
                    for lane in again.lanes() {
                        failed[lane] = None;
                    }
                    w.divisions.push(Division {
                        lanes: again,
                        parts: 2 * now.parts,
                        done: 2 * (now.done - 1),
                        halvings: now.halvings + 1,
                    });
                }
                now.lanes = moved_on;
            }
        }
        let moved = lanes & Mask::from_fn(|lane| failed[lane].is_none());
        for (x, end) in boxes.iter_mut().zip(&w.q[..n]) {
            x.assign(moved, end);
        }
        failed
    }

    /// One step without division: moves the states in `w.q` of the returned lanes; `failed` says
    /// what is with the others.
    fn single_step(
        &self,
        dt: Interval,
        lanes: Mask,
        w: &mut Workspace,
        failed: &mut [Option<StepFailure>; LANES],
    ) -> Mask {
        let n = self.layout.states;
        let enclosed = self.apriori(&mut w.q, lanes, dt, &mut w.apriori, &mut w.registers);
        for lane in lanes.without(enclosed).lanes() {
            failed[lane] = w.apriori.failed[lane].map(StepFailure::Apriori);
        }
        if enclosed.none() {
            return enclosed;
        }
        let step = Step {
            q: &w.q,
            dt,
            apriori: &w.apriori,
            lanes: enclosed,
        };
        self.move_faces(
            &step,
            &mut w.faces,
            &mut w.registers,
            &mut w.end,
            &mut w.part_tube,
        );
        let mut moved = enclosed;
        let mut fail = |moved: &mut Mask, lanes: Mask, failure: StepFailure| {
            for lane in (*moved & lanes).lanes() {
                failed[lane] = Some(failure);
            }
            *moved = moved.without(lanes);
        };
        // Bounds pass each other only where a jump ended the last flow before the end of the step.
        let mut gone = Mask::NONE;
        for end in &w.end {
            gone |= moved & end.is_empty();
        }
        for end in &w.end {
            let unbounded = (!end.is_bounded()).without(gone);
            fail(&mut moved, unbounded, StepFailure::Unbounded);
        }
        if let Some(domain) = &self.domain {
            let inputs = &w.q[n + self.layout.params..];
            for (state, (x, allowed)) in w.part_tube.iter().zip(&domain.states).enumerate() {
                let outside = !x.is_subset_of(&Interval8::splat(*allowed));
                fail(&mut moved, outside, StepFailure::LeavesDomain { state });
            }
            for (input, (x, allowed)) in inputs.iter().zip(&domain.inputs).enumerate() {
                let outside = !x.is_subset_of(&Interval8::splat(*allowed));
                fail(
                    &mut moved,
                    outside,
                    StepFailure::InputOutsideDomain { input },
                );
            }
        }
        for (x, end) in w.q.iter_mut().zip(&w.end) {
            x.assign(moved, end);
            x.assign(moved & gone, &Interval8::EMPTY);
        }
        moved
    }

    /// The modes whose guard, as written, holds somewhere on the boxes in `lanes` (talk, 1.3);
    /// `boxes` holds the states, then the parameters.
    pub fn active_modes(
        &self,
        boxes: &[Interval8],
        lanes: Mask,
        inputs: &[Interval],
        workspace: &mut Workspace,
    ) -> [ModeSet; LANES] {
        workspace.load(boxes, inputs);
        self.modes_on(
            &workspace.q,
            lanes,
            &mut workspace.modes,
            &mut workspace.registers,
        );
        workspace.modes.sets()
    }
}

impl Workspace {
    /// How many parts a stretch of time is divided into at least.
    fn least_parts(&self, dt: Interval) -> u64 {
        (dt.hi() / self.options.longest)
            .ceil()
            .clamp(1.0, MOST_PARTS) as u64
    }

    /// How often a step may be halved.
    pub(crate) fn halvings(&self) -> u32 {
        self.options.halvings
    }

    fn load(&mut self, boxes: &[Interval8], inputs: &[Interval]) {
        let (z, u) = self.q.split_at_mut(boxes.len());
        z.copy_from_slice(boxes);
        for (to, from) in u.iter_mut().zip(inputs) {
            *to = Interval8::splat(*from);
        }
    }
}
