//! Boxes that may jump during a step.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: boxes have one interval per state, and lists of the system its lengths"
)]

use super::Jumps;
use super::timing::{Course, Times};
use crate::apriori::{AprioriFailure, Candidate};
use crate::step::{StepFailure, Workspace};
use crate::system::System;
use veribound_interval::lanes::{Interval8, LANES, Mask};
use veribound_interval::{Interval, round};

/// Jumps that are told apart in one part of a step; a sweep covers those after them.
const FLIGHTS: u32 = 3;

/// Flows looked at for one box in one part of a step, at most.
const MOST_FLOWS: u32 = 3000;

/// Boxes at the end of a step, at most.
const MOST_ENDS: usize = 6;

/// Rounds in which the time of a jump is narrowed: each about squares the error.
const TIME_ROUNDS: usize = 4;

/// Rounds of a sweep before it is given up.
const SWEEP_ROUNDS: i32 = 16;

/// How far behind a wall flows are looked at, as a share of the states that it stops.
const BEHIND_WALL: f64 = 1e-10;

/// Steps in which the length of the longest flow is looked for.
const FLOW_ROUNDS: usize = 20;

/// Flows that end within this share of the time asked for are not told from none.
const AT_ONCE: f64 = 1e-15;

/// Pieces of time for which a rate is bounded by the difference quotient of its integral, each shorter
/// than the one after it by a fifth.
const PIECES: usize = 32;

/// A box of states.
type Box = Vec<Interval>;

/// What becomes of a box during a stretch of time.
pub(crate) struct Flight {
    /// Boxes that together contain every solution at the end.
    pub(crate) ends: Vec<Box>,
    /// Contains every solution at all times.
    pub(crate) tube: Box,
    /// Every velocity; of a state that may have jumped, everything.
    pub(crate) velocity: Box,
}

/// A flow without jumps.
struct Flow {
    end: Box,
    tube: Box,
    velocity: Box,
    /// No solution flows longer.
    longest: Interval,
}

/// When jumps happen along a flow: `span` seconds from a box on, the tube of which is known.
struct Window {
    /// Time before.
    base: Interval,
    span: f64,
    tube: Box,
    /// Every velocity of flows in it.
    velocity: Box,
    /// Before the end of the step every solution has jumped.
    is_forced: bool,
    /// Everything that touches a condition's region at the start can flow off and does so at once.
    flows_off: bool,
}

/// Values of a comparison that flows do not leave.
struct Wall {
    position: usize,
    allowed: Interval,
    /// The only state it compares, if it grows or falls with that.
    alone: Option<Alone>,
}

/// A state that a wall bounds alone: it is where the comparison has the values `border`, or not farther behind than it was
/// at the start of the flow. So no rounding moves what stands at the wall.
struct Alone {
    state: usize,
    border: Interval,
    /// The wall is an upper bound of the state.
    is_above: bool,
}

/// One box on its way.
pub(crate) struct Solver<'a> {
    system: &'a System,
    params: Box,
    inputs: &'a [Interval],
    w: &'a mut Workspace,
    candidate: Candidate,
    tube: Box,
    velocity: Box,
    /// States that may have jumped.
    jumped: Vec<usize>,
    /// Flows that may still be looked at, so that the time of a step is bounded.
    budget: u32,
}

impl System {
    /// Where some jump's condition holds on the boxes.
    pub(crate) fn may_jump(
        &self,
        states: &[Interval8],
        boxes: &[Interval8],
        inputs: &[Interval],
        lanes: Mask,
        w: &mut Workspace,
    ) -> Mask {
        let n = self.layout.states;
        let mut all = Mask::NONE;
        for jump in 0..self.jumps.list.len() {
            let mut q: Vec<Interval8> = states.to_vec();
            q.extend_from_slice(&boxes[n..]);
            q.extend(inputs.iter().map(|u| Interval8::splat(*u)));
            let condition = self.mode_count() + jump;
            let guards = &mut w.registers.guards;
            all |= self.guards.clip(condition, &mut q, lanes, None, guards);
        }
        all
    }

    /// Moves one box of states over `dt` seconds, in `parts` equal parts, with its jumps.
    pub(crate) fn fly(
        &self,
        start: &[Interval],
        params: &[Interval],
        inputs: &[Interval],
        (dt, parts): (Interval, u64),
        w: &mut Workspace,
    ) -> Result<Flight, StepFailure> {
        let halvings = w.halvings();
        let mut solver = Solver::new(self, start, params, inputs, w);
        solver.budget = MOST_FLOWS.saturating_mul(parts as u32);
        let part = dt / Interval::point(parts as f64);
        let mut ends = vec![start.to_vec()];
        for _ in 0..parts {
            let mut next = Vec::new();
            for x in &ends {
                next.extend(solver.advance_or_halve(x, part, halvings)?);
            }
            ends = reduced(next);
        }
        if ends.is_empty() {
            // Not a contradiction: the model does not say how solutions go on.
            return Err(StepFailure::Apriori(AprioriFailure::NoMode));
        }
        let mut velocity = solver.velocity;
        for state in solver.jumped {
            velocity[state] = Interval::ENTIRE;
        }
        Ok(Flight {
            ends,
            tube: solver.tube,
            velocity,
        })
    }
}

impl<'a> Solver<'a> {
    pub(super) fn new(
        system: &'a System,
        start: &[Interval],
        params: &[Interval],
        inputs: &'a [Interval],
        w: &'a mut Workspace,
    ) -> Solver<'a> {
        Solver {
            system,
            params: params.to_vec(),
            inputs,
            w,
            candidate: Candidate::default(),
            tube: start.to_vec(),
            velocity: vec![Interval::EMPTY; start.len()],
            jumped: Vec::new(),
            budget: MOST_FLOWS,
        }
    }

    /// States that may have jumped, each once.
    pub(super) fn jumped(mut self) -> Vec<usize> {
        self.jumped.sort_unstable();
        self.jumped.dedup();
        self.jumped
    }

    /// Boxes with every solution from `x` after `dt`.
    fn advance_or_halve(
        &mut self,
        x: &[Interval],
        dt: Interval,
        halvings: u32,
    ) -> Result<Vec<Box>, StepFailure> {
        let half = match self.advance(x, dt, 0) {
            Err(StepFailure::Apriori(_)) if halvings > 0 && self.budget > 0 => {
                dt / Interval::point(2.0)
            }
            other => return other,
        };
        let mut ends = Vec::new();
        for middle in self.advance_or_halve(x, half, halvings - 1)? {
            ends.extend(self.advance_or_halve(&middle, half, halvings - 1)?);
        }
        Ok(reduced(ends))
    }

    /// As [`Solver::advance_or_halve`], in one piece; `flights` jumps lie behind `x`.
    fn advance(
        &mut self,
        x: &[Interval],
        dt: Interval,
        flights: u32,
    ) -> Result<Vec<Box>, StepFailure> {
        let mut ends = Vec::new();
        // Where and when solutions jump first. A point of `x` at which nothing flows jumps at once.
        let mut windows = Vec::new();
        let mut at_once = true;
        if let Some(flowing) = self.flowing(x) {
            let flow = self.flow(&flowing, dt)?;
            let mut window = self.window(&flowing, &flow, dt)?;
            if !window.as_ref().is_some_and(|window| window.is_forced) {
                self.note(&flow);
                ends.extend(self.end_without_jump(&flowing, &flow, dt));
            }
            if let Some(window) = &mut window
                && window.base == Interval::ZERO
            {
                window.tube = hull(&window.tube, x);
                window.flows_off &= is_inside(x, &flowing);
                at_once = false;
            }
            windows.extend(window);
        }
        if at_once {
            windows.push(Window {
                base: Interval::ZERO,
                span: 0.0,
                tube: x.to_vec(),
                velocity: vec![Interval::EMPTY; x.len()],
                is_forced: false,
                flows_off: false,
            });
        }
        for window in windows {
            self.widen_tube(&window.tube);
            self.velocity = hull(&self.velocity, &window.velocity);
            let rest = dt - window.base;
            for (_, image) in self.images(&window.tube)? {
                // Jumps at the start into the box itself lead to solutions that are followed already.
                if window.span == 0.0
                    && window.base == Interval::ZERO
                    && window.flows_off
                    && is_inside(&image, x)
                {
                    continue;
                }
                ends.extend(self.after_jump(&image, rest, window.span, flights)?);
            }
        }
        Ok(reduced(ends))
    }

    /// Boxes with every solution that jumped to `image` up to `span` seconds after there were `rest`
    /// seconds left.
    fn after_jump(
        &mut self,
        image: &[Interval],
        rest: Interval,
        span: f64,
        flights: u32,
    ) -> Result<Vec<Box>, StepFailure> {
        self.widen_tube(image);
        let most = rest.hi().max(0.0);
        if flights >= FLIGHTS {
            return Ok(vec![self.sweep(image, most)?]);
        }
        if span == 0.0 && rest.lo() > 0.0 {
            return self.advance(image, rest, flights + 1);
        }
        let least = round::sub_down(rest.lo(), span).max(0.0);
        let starts = if least > 0.0 {
            self.advance(image, Interval::point(least), flights + 1)?
        } else {
            vec![image.to_vec()]
        };
        let more = round::sub_up(most, least);
        let mut ends = Vec::new();
        for start in &starts {
            ends.extend(self.sweep_apart(start, more, flights + 1)?);
        }
        Ok(ends)
    }

    /// Boxes that together contain every solution from `x` at all times up to `most`: one before the
    /// first jump and others after, so that a memory is either old or new.
    pub(super) fn sweep_apart(
        &mut self,
        x: &[Interval],
        most: f64,
        flights: u32,
    ) -> Result<Vec<Box>, StepFailure> {
        if flights >= FLIGHTS {
            return Ok(vec![self.sweep(x, most)?]);
        }
        let mut tube = x.to_vec();
        if most > 0.0
            && let Some(flowing) = self.flowing(x)
        {
            let flow = self.flow(&flowing, Interval::point(most))?;
            tube = hull(&tube, &self.narrowed_tube(&flowing, &flow));
            self.velocity = hull(&self.velocity, &flow.velocity);
        }
        self.widen_tube(&tube);
        let images = self.images(&tube)?;
        let mut boxes = vec![tube];
        for (_, image) in images {
            // What jumps back into the box it came from is followed already.
            if !is_inside(&image, x) {
                boxes.extend(self.sweep_apart(&image, most, flights + 1)?);
            }
        }
        Ok(boxes)
    }

    /// When solutions from `x`, the flow of which is known, jump first; `None` where none does within
    /// `dt`.
    fn window(
        &mut self,
        x: &[Interval],
        flow: &Flow,
        dt: Interval,
    ) -> Result<Option<Window>, StepFailure> {
        let mut window = Window {
            base: Interval::ZERO,
            span: dt.hi(),
            tube: self.narrowed_tube(x, flow),
            velocity: flow.velocity.clone(),
            is_forced: false,
            flows_off: false,
        };
        let mut at = x.to_vec();
        for _ in 0..TIME_ROUNDS {
            let Some(times) = self.times(&at, &window.tube)? else {
                return Ok(None);
            };
            if times.earliest > window.span {
                return Ok(None);
            }
            // At the end itself it may happen, and must where it was forced before.
            if times.earliest == window.span {
                break;
            }
            // Beyond the window nothing is known of the rates.
            let is_known = times.certain <= window.span;
            window.is_forced |= is_known && times.certain < (dt - window.base).lo();
            let last = window.span.min(times.certain).min(times.last);
            if last < times.earliest {
                return Ok(None);
            }
            window.flows_off |= window.base == Interval::ZERO && times.last == 0.0;
            let span = round::sub_up(last, times.earliest).max(0.0);
            if span > 0.9 * window.span {
                break;
            }
            if times.earliest > 0.0 {
                let to = Interval::point(times.earliest);
                let Some(flowing) = self.flowing(&at) else {
                    break;
                };
                let flow = self.flow(&flowing, to)?;
                if is_empty(&flow.end) {
                    return Ok(None);
                }
                self.note(&flow);
                at = flow.end;
                window.base += to;
            }
            window.span = span;
            let Some(flowing) = self.flowing(&at) else {
                window.tube = at;
                window.span = 0.0;
                break;
            };
            window.tube = at.clone();
            if span > 0.0 {
                let flow = self.flow(&flowing, Interval::point(span))?;
                window.tube = hull(&self.narrowed_tube(&flowing, &flow), &at);
                window.velocity = flow.velocity;
            } else {
                break;
            }
        }
        Ok(Some(window))
    }

    /// When the first jump along flows from `at` with this tube can happen, and by when one must have;
    /// `None` where none can.
    fn times(&mut self, at: &[Interval], tube: &[Interval]) -> Result<Option<Times>, StepFailure> {
        let velocity = self.velocity(tube)?;
        let (start, always) = (self.load(at), self.load(tube));
        let registers = &mut self.w.registers;
        let Jumps { list, atoms, .. } = &self.system.jumps;
        let courses: Vec<Course> = atoms
            .iter()
            .zip(&mut registers.jumps.atoms)
            .map(|(atom, registers)| atom.course(&start, &always, &velocity, registers))
            .collect();
        let mut all: Option<Times> = None;
        for (number, jump) in list.iter().enumerate() {
            if self.where_jumps(number, tube).is_none() {
                continue;
            }
            let times = jump.timing.times(&courses);
            all = Some(all.map_or(times, |all| all.or(times)));
        }
        Ok(all)
    }

    /// The part of a box on which a jump may happen, with parameters and inputs; `None` where it cannot.
    fn where_jumps(&mut self, jump: usize, x: &[Interval]) -> Option<Vec<Interval8>> {
        let mut q = self.load(x);
        let condition = self.system.mode_count() + jump;
        let (guards, registers) = (&self.system.guards, &mut self.w.registers.guards);
        let possible = guards.clip(condition, &mut q, Mask::lane(0), None, registers);
        possible.get(0).then_some(q)
    }

    /// Every jump that may happen on a box, with its image.
    pub(super) fn images(&mut self, x: &[Interval]) -> Result<Vec<(usize, Box)>, StepFailure> {
        let mut images = Vec::new();
        for (number, jump) in self.system.jumps.list.iter().enumerate() {
            let Some(q) = self.where_jumps(number, x) else {
                continue;
            };
            let registers = &mut self.w.registers;
            let values = &mut registers.jumps.values[number];
            let regular = jump.values.eval(&q, values);
            let mut image: Box = (0..x.len()).map(|state| q[state].get(0)).collect();
            for (position, state) in jump.states.iter().enumerate() {
                let value: Interval = jump.values.output(position, values).get(0);
                if !regular.is_defined().get(0) {
                    let failure = AprioriFailure::Undefined { state: *state };
                    return Err(StepFailure::Apriori(failure));
                }
                if !value.is_bounded() {
                    return Err(StepFailure::Unbounded);
                }
                image[*state] = value;
            }
            self.jumped.extend(&jump.states);
            images.push((number, image));
        }
        Ok(images)
    }

    /// Contains every solution from `x` at all times up to `most`, after any number of jumps.
    ///
    /// A flow starts at `x` or after a jump. What the jump does not set has flowed, for `most` seconds in
    /// all, since the start or since some jump set it.
    fn sweep(&mut self, x: &[Interval], most: f64) -> Result<Box, StepFailure> {
        let mut starts = x.to_vec();
        for round in 0..SWEEP_ROUNDS {
            let mut tube = starts.clone();
            let mut drift = vec![Interval::ZERO; x.len()];
            if most > 0.0
                && let Some(flowing) = self.flowing(&starts)
            {
                let flow = self.flow(&flowing, Interval::point(most))?;
                tube = hull(&tube, &self.narrowed_tube(&flowing, &flow));
                self.velocity = hull(&self.velocity, &flow.velocity);
                let whole = Interval::ZERO.hull(Interval::point(most));
                drift = flow.velocity.iter().map(|v| *v * whole).collect();
            }
            let mut images = self.images(&tube)?;
            let list = &self.system.jumps.list;
            let mut reach = x.to_vec();
            for (jump, image) in &images {
                for state in &list[*jump].states {
                    reach[*state] = reach[*state].hull(image[*state]);
                }
            }
            for (jump, image) in &mut images {
                for (state, y) in image.iter_mut().enumerate() {
                    if !list[*jump].states.contains(&state) {
                        *y = y.intersect(reach[state] + drift[state]);
                    }
                }
            }
            images.retain(|(_, image)| !is_empty(image));
            if images.iter().all(|(_, image)| is_inside(image, &starts)) {
                self.widen_tube(&tube);
                return Ok(tube);
            }
            for (_, image) in &images {
                for (start, y) in starts.iter_mut().zip(image) {
                    *start = grown(*start, *y, round);
                }
            }
        }
        Err(StepFailure::Apriori(AprioriFailure::TooLong))
    }

    /// The end of a flow without a jump.
    fn end_without_jump(&mut self, x: &[Interval], flow: &Flow, dt: Interval) -> Option<Box> {
        if is_empty(&flow.end) {
            return None;
        }
        let mut end = self.flowing(&flow.end)?;
        for pair in &self.system.jumps.integrals {
            let (mean, acceleration) = (end[pair.state] - x[pair.state], flow.velocity[pair.rate]);
            let rate = mean_rate(mean, dt, acceleration);
            end[pair.rate] = end[pair.rate].intersect(rate);
            if end[pair.rate].is_empty() {
                return None;
            }
        }
        Some(end)
    }

    /// The tube of flows from `x`, its rates narrowed to what their integrals allow: a ball that is
    /// still above the floor after some time was not fast all the time.
    fn narrowed_tube(&mut self, x: &[Interval], flow: &Flow) -> Box {
        let mut tube = flow.tube.clone();
        for pair in &self.system.jumps.integrals {
            let change = tube[pair.state] - x[pair.state];
            let acceleration = flow.velocity[pair.rate];
            let half = acceleration * Interval::point(0.5);
            let rate_at = |time: Interval| x[pair.rate] + acceleration * time;
            let state_at = |time: Interval| x[pair.state] + time * (x[pair.rate] + half * time);
            let mut later = flow.longest.hi();
            let first = |later| Interval::new(0.0, later).unwrap_or(Interval::ENTIRE);
            let (mut rate, mut state) = (Interval::EMPTY, Interval::EMPTY);
            for _ in 0..PIECES {
                let sooner = 0.8 * later;
                let piece = Interval::new(sooner, later).unwrap_or(Interval::ENTIRE);
                let by_mean = mean_rate(change, piece, acceleration);
                rate = rate.hull(rate_at(piece).intersect(by_mean));
                state = state.hull(state_at(piece));
                later = sooner;
            }
            rate = rate.hull(rate_at(first(later)));
            state = state.hull(state_at(first(later)));
            tube[pair.state] = tube[pair.state].intersect(state);
            tube[pair.rate] = tube[pair.rate].intersect(rate);
        }
        self.flowing(&tube).unwrap_or(tube)
    }

    /// What of a box can flow.
    fn flowing(&mut self, x: &[Interval]) -> Option<Box> {
        let mut q = self.load(x);
        let guards = &self.system.guards;
        let registers = &mut self.w.registers.guards;
        let left = guards.clip_to_flow(&mut q, Mask::lane(0), None, registers);
        left.get(0)
            .then(|| (0..x.len()).map(|state| q[state].get(0)).collect())
    }

    /// Every velocity of flows on a box.
    fn velocity(&mut self, x: &[Interval]) -> Result<Box, StepFailure> {
        let q = self.load(x);
        let mut failed = [None; LANES];
        let registers = &mut self.w.registers;
        let candidate = &mut self.candidate;
        let known = self
            .system
            .velocity(&q, Mask::lane(0), candidate, &mut failed, registers);
        match failed[0] {
            Some(failure) if known.none() => Err(StepFailure::Apriori(failure)),
            _ => Ok(candidate.velocity.iter().map(|v| v.get(0)).collect()),
        }
    }

    /// A flow that does not jump, for `dt` at most; its end is empty where none lasts that long.
    fn flow(&mut self, x: &[Interval], dt: Interval) -> Result<Flow, StepFailure> {
        let mut flow = self.whole_flow(x, dt)?;
        if !is_empty(&flow.end) {
            flow.longest = dt;
            return Ok(flow);
        }
        let (mut shorter, mut longer) = (0.0, dt.hi());
        // What rests on a stop does not flow at all.
        let least = AT_ONCE * longer;
        if let Ok(other) = self.whole_flow(x, Interval::point(least))
            && is_empty(&other.end)
        {
            return Ok(Flow {
                longest: Interval::point(least),
                ..other
            });
        }
        // The longest flow: by halves to its size, then by bisection.
        for round in 0..FLOW_ROUNDS {
            let middle = if shorter == 0.0 {
                0.125 * longer
            } else if round + 1 < FLOW_ROUNDS && longer > 1.05 * shorter {
                0.5 * (shorter + longer)
            } else {
                break;
            };
            match self.whole_flow(x, Interval::point(middle)) {
                Ok(other) if is_empty(&other.end) => (flow, longer) = (other, middle),
                _ => shorter = middle,
            }
        }
        flow.longest = Interval::point(longer);
        Ok(flow)
    }

    fn whole_flow(&mut self, x: &[Interval], dt: Interval) -> Result<Flow, StepFailure> {
        let Some(left) = self.budget.checked_sub(1) else {
            return Err(StepFailure::Apriori(AprioriFailure::TooLong));
        };
        self.budget = left;
        let splat = |x: &Interval| Interval8::splat(*x);
        let mut boxes: Vec<Interval8> = x.iter().chain(&self.params).map(splat).collect();
        let lane = Mask::lane(0);
        let [failed, ..] = self
            .system
            .flow_eight(&mut boxes, lane, self.inputs, dt, self.w);
        if let Some(failure) = failed {
            return Err(failure);
        }
        let first = |list: &[Interval8]| -> Box {
            let list = list.iter().take(x.len());
            list.map(|x| x.get(0)).collect()
        };
        let (mut end, velocity) = (first(&boxes), first(self.w.velocities()));
        // A wall holds a bound of the box in place, but nothing that flows lies behind it.
        for pair in &self.system.jumps.integrals {
            let bend = velocity[pair.rate] * dt.sqr() * Interval::point(0.5);
            let free = x[pair.state] + x[pair.rate] * dt + bend;
            end[pair.state] = end[pair.state].intersect(free);
        }
        let mut tube = first(self.w.tubes());
        for wall in self.walls(x, &tube) {
            self.keep_before(&wall, x, &mut end);
            self.keep_before(&wall, x, &mut tube);
        }
        if is_empty(&end) {
            end.fill(Interval::EMPTY);
        }
        Ok(Flow {
            end,
            tube,
            velocity,
            longest: dt,
        })
    }

    /// Comparisons that flows from `x` cannot make true, though they may touch their border: where one
    /// would hold, what flows there only makes it less true. Such is the place of a stop or a floor.
    fn walls(&mut self, x: &[Interval], tube: &[Interval]) -> Vec<Wall> {
        let sides = self.system.jumps.list.iter();
        let mut sides: Vec<(usize, bool)> = sides.flat_map(|jump| jump.timing.atoms()).collect();
        sides.sort_unstable();
        sides.dedup();
        let sides = sides.into_iter();
        sides
            .filter_map(|(position, below)| self.wall(position, below, x, tube))
            .collect()
    }

    fn wall(
        &mut self,
        position: usize,
        below: bool,
        x: &[Interval],
        tube: &[Interval],
    ) -> Option<Wall> {
        let atom = &self.system.jumps.atoms[position];
        let registers = &mut self.w.registers.jumps.atoms[position];
        let half = |lo, hi| Interval::new(lo, hi).unwrap_or(Interval::ENTIRE);
        // A little behind the border, where the condition holds for certain.
        let depth = BEHIND_WALL * atom.magnitude(x);
        let beyond = if below {
            half(f64::NEG_INFINITY, -depth)
        } else {
            half(depth, f64::INFINITY)
        };
        let load = |x: &[Interval]| -> Vec<Interval8> {
            let all = x.iter().chain(&self.params).chain(self.inputs);
            all.map(|x| Interval8::splat(*x)).collect()
        };
        let start = atom.at(&load(x), registers)?;
        let mut q = load(tube);
        if atom.narrow(&mut q, beyond, registers) {
            let there: Box = (0..x.len()).map(|state| q[state].get(0)).collect();
            if let Some(there) = self.flowing(&there) {
                let velocity = self.velocity(&there).ok()?;
                let q = self.load(&there);
                let registers = &mut self.w.registers.jumps.atoms[position];
                let atom = &self.system.jumps.atoms[position];
                let rate = atom.course(&q, &q, &velocity, registers).rate;
                let leaves = if below {
                    rate.lo() >= 0.0
                } else {
                    rate.hi() <= 0.0
                };
                if !leaves {
                    return None;
                }
            }
        }
        let up_to = |start: f64| {
            if below {
                half(start.min(-depth), f64::INFINITY)
            } else {
                half(f64::NEG_INFINITY, start.max(depth))
            }
        };
        let q = self.load(tube);
        let atom = &self.system.jumps.atoms[position];
        let alone = atom.alone(&q, &mut self.w.registers.jumps.atoms[position]);
        Some(Wall {
            position,
            allowed: up_to(if below { start.lo() } else { start.hi() }),
            alone: alone.map(|(state, rises)| Alone {
                state,
                border: up_to(0.0),
                is_above: rises != below,
            }),
        })
    }

    /// Cuts where flows from `start` are.
    fn keep_before(&mut self, wall: &Wall, start: &[Interval], x: &mut [Interval]) {
        if is_empty(x) {
            return;
        }
        if let Some(alone) = &wall.alone {
            let state = alone.state;
            let mut q = self.load(x);
            let atom = &self.system.jumps.atoms[wall.position];
            let registers = &mut self.w.registers.jumps.atoms[wall.position];
            let mut before = start[state];
            if atom.narrow(&mut q, alone.border, registers) {
                before = before.hull(q[state].get(0));
            }
            let before = if alone.is_above {
                Interval::new(f64::NEG_INFINITY, before.hi())
            } else {
                Interval::new(before.lo(), f64::INFINITY)
            };
            x[state] = x[state].intersect(before.unwrap_or(Interval::ENTIRE));
            return;
        }
        let mut q = self.load(x);
        let atom = &self.system.jumps.atoms[wall.position];
        let registers = &mut self.w.registers.jumps.atoms[wall.position];
        let left = atom.narrow(&mut q, wall.allowed, registers);
        for (state, x) in x.iter_mut().enumerate() {
            *x = if left {
                q[state].get(0)
            } else {
                Interval::EMPTY
            };
        }
    }

    fn load(&self, x: &[Interval]) -> Vec<Interval8> {
        let all = x.iter().chain(&self.params).chain(self.inputs);
        all.map(|x| Interval8::splat(*x)).collect()
    }

    fn note(&mut self, flow: &Flow) {
        self.widen_tube(&flow.tube);
        self.velocity = hull(&self.velocity, &flow.velocity);
    }

    fn widen_tube(&mut self, x: &[Interval]) {
        self.tube = hull(&self.tube, x);
    }
}

/// `start` grown to contain `y`, and a little more where it grows, so that the next image finds itself
/// inside.
fn grown(start: Interval, y: Interval, round: i32) -> Interval {
    let share = 0.1 * 4.0_f64.powi(round);
    let more = |growth: f64| share * growth + 1e-12 * y.mag();
    let (below, above) = (start.lo() - y.lo(), y.hi() - start.hi());
    let lo = if below > 0.0 {
        y.lo() - more(below)
    } else {
        start.lo()
    };
    let hi = if above > 0.0 {
        y.hi() + more(above)
    } else {
        start.hi()
    };
    Interval::new(lo, hi).unwrap_or(Interval::ENTIRE).hull(y)
}

/// The rate after `time` where its integral changed by `change` and its own derivative is within
/// `acceleration`: `v(T) = change / T + (1 / T) * integral of s v'(s) over 0..T`.
fn mean_rate(change: Interval, time: Interval, acceleration: Interval) -> Interval {
    change / time + acceleration * time * Interval::point(0.5)
}

fn is_empty(x: &[Interval]) -> bool {
    x.iter().any(|x| x.is_empty())
}

fn hull(a: &[Interval], b: &[Interval]) -> Box {
    a.iter().zip(b).map(|(a, b)| a.hull(*b)).collect()
}

fn is_inside(a: &[Interval], b: &[Interval]) -> bool {
    a.iter().zip(b).all(|(a, b)| a.is_subset_of(*b))
}

/// The same boxes with those joined that overlap in all states, and at most six of them; the union
/// does not shrink.
pub fn reduced(boxes: Vec<Box>) -> Vec<Box> {
    let mut left: Vec<Box> = Vec::new();
    for x in boxes {
        let mut x = x;
        // What overlaps after joining is found in the next round.
        while let Some(position) = left.iter().position(|known| overlap(known, &x)) {
            x = hull(&x, &left.swap_remove(position));
        }
        left.push(x);
    }
    while left.len() > MOST_ENDS {
        let pairs = (0..left.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        let cost = |(i, j): &(usize, usize)| growth(&left[*i], &left[*j]);
        let Some((i, j)) = pairs.min_by(|a, b| cost(a).total_cmp(&cost(b))) else {
            break;
        };
        let other = left.swap_remove(i);
        left[j] = hull(&left[j], &other);
    }
    left
}

fn overlap(a: &[Interval], b: &[Interval]) -> bool {
    a.iter().zip(b).all(|(a, b)| a.intersects(*b))
}

/// How much wider the hull is than the boxes; it only ranks pairs.
fn growth(a: &[Interval], b: &[Interval]) -> f64 {
    let of = |(a, b): (&Interval, &Interval)| a.hull(*b).width() - a.width().max(b.width());
    a.iter().zip(b).map(of).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every box stays inside of one of those that are left, however many there were.
    #[test]
    fn fewer_boxes_contain_all() {
        let range = |lo: f64, width: f64| Interval::new(lo, lo + width).unwrap_or(Interval::EMPTY);
        for count in [1, 2, 6, 7, 20] {
            let boxes: Vec<Box> = (0..count)
                .map(|i| {
                    let i = f64::from(i);
                    vec![range(i * i, 0.9), range(10.0 - 7.0 * i, 1.0)]
                })
                .collect();
            let left = reduced(boxes.clone());
            assert!(left.len() <= MOST_ENDS, "{left:?}");
            for x in &boxes {
                assert!(
                    left.iter().any(|y| is_inside(x, y)),
                    "{x:?} not in {left:?}"
                );
            }
        }
    }
}
