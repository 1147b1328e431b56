//! What equations say when they are integrated over stretches of a record: [`veribound_flow::balance`].
//!
//! Inputs that may have any course make forms of solutions grow, so that windows are short. Here nothing is moved: a row is
//! told by states at a few samples, by the means of a measured state between them, and by bounds of right-hand sides
//! on boxes that the observer proved. It says of the parameters what no other value can be, whatever the course is.
//!
//! Functions `ψ` of time are put together from blocks of 1, 2, 4, ... stretches. On a block of length `T` there are two, *up* from 0
//! to 1 and *down* from 1 to 0, with `ψ' + a ψ` constant: `up = (1 - e^(-a t)) / (1 - e^(-a T))`, `down = 1 - up`. On a block of two
//! parts, `λ` being its *up* where they meet, *up* is `λ up` on the first part and `λ down + up` on the second one, so all
//! integrals of a block are sums of those of its parts, and none of their factors is negative.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: samples, states and quantities of the problem, blocks of a track"
)]

use std::collections::{BTreeMap, BTreeSet};

use super::problem::{Problem, Value};
use super::region::Region;
use super::rows::Rows;
use veribound_flow::balance::{Balance, FromCorner, FromCorners};
use veribound_flow::{ModeSet, StepOptions, System, Workspace};
use veribound_interval::Interval;
use veribound_model::Model;

/// Values of `ψ` where blocks of one size meet. Where it does not begin or end with zero, the rate itself tells something.
const SHAPES: [&[f64]; 16] = [
    &[0.0, 1.0, 0.0],
    &[0.0, 0.5, 1.0, 0.5, 0.0],
    &[0.0, 1.0, 0.5, 0.0],
    &[0.0, 0.5, 1.0, 0.0],
    &[0.0, 1.0, 1.0, 0.0],
    &[0.0, 1.0, 1.0, 1.0, 0.0],
    &[1.0, 0.0],
    &[1.0, 0.5, 0.0],
    &[1.0, 1.0, 0.0],
    &[1.0, 1.0, 1.0, 0.0],
    &[0.0, 1.0],
    &[0.0, 0.5, 1.0],
    &[0.0, 1.0, 1.0],
    &[0.0, 1.0, 1.0, 1.0],
    &[1.0, 1.0],
    &[1.0, 1.0, 1.0],
];

/// States at samples are narrowed by so many neighbours on each side.
const NEIGHBOURS: usize = 16;

/// Then what happens between samples is enclosed anew, so often in all.
const ROUNDS: usize = 2;

/// Functions that say nearly the same of the parameters are those whose slopes, as shares of the largest, are the same in so many
/// parts; of these the best ones are kept.
const DIRECTIONS: f64 = 6.0;
const ALIKE: usize = 6;

/// A function is left out where it misses a region by this share.
const NEARLY: f64 = 1.1;

/// Below this `a T` is small enough for the first terms of its series.
const SMALL: f64 = 1.0 / 64.0;

/// Between two samples.
struct Stretch {
    dt: Interval,
    /// All states at all times of it.
    tube: Vec<Interval>,
    inputs: Vec<Interval>,
    modes: ModeSet,
    /// Which values of parameters act.
    phase: usize,
    /// Of the rate.
    bend: Interval,
}

/// A function `ψ`.
struct Window {
    /// Blocks of `2^level` stretches, from this one on.
    level: usize,
    from: usize,
    shape: &'static [f64],
}

/// A balance along a record.
struct Track {
    record: usize,
    balance: Balance,
    /// The state and its rate at samples.
    nodes: Vec<(Interval, Interval)>,
    /// Where a stretch was proved.
    stretches: Vec<Option<Stretch>>,
    /// Positions of the parameters' values among the quantities.
    phases: Vec<Vec<usize>>,
    windows: Vec<Window>,
}

/// Integrals over a block, with *up* and *down*.
#[derive(Clone)]
struct Block {
    time: Interval,
    phase: usize,
    up: FromCorners,
    down: FromCorners,
    /// Of the state times the derivative of *up*.
    mean: Interval,
}

/// Values of parameters for a region.
struct Phase {
    /// The corners that bounds are seen from.
    corners: [Vec<f64>; 2],
    /// A number near `A`,
    near: f64,
    /// and how far `A` is from it.
    factor: FromCorners,
}

/// What a function says.
struct Told {
    /// What is zero for true parameters, as functions of these,
    sums: FromCorners,
    /// and their phase.
    at: usize,
    /// How far the integral of the rate is unsure.
    unsure: f64,
}

/// What all balances of all records say.
pub(crate) struct Balances {
    tracks: Vec<Track>,
}

impl std::fmt::Debug for Balances {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Balances").finish_non_exhaustive()
    }
}

impl Balances {
    /// Whether a model has any.
    pub(crate) fn are_there(model: &Model) -> bool {
        !Balance::of(model).is_empty()
    }

    /// The balances of a model along records, of which `seen` tells the states at the first samples of each.
    ///
    /// The states must be those of all solutions with quantities in `box_` that agree with the records.
    pub(crate) fn of(
        model: &Model,
        problem: &Problem,
        seen: &[Vec<Vec<Interval>>],
        box_: &[Interval],
    ) -> Balances {
        let system = System::new(model);
        let balances = Balance::of(model);
        let mut tracks = Vec::new();
        for (record, seen) in seen.iter().enumerate() {
            let mut states = seen.clone();
            let of = |balance: &Balance| Track {
                record,
                balance: balance.clone(),
                nodes: Vec::new(),
                stretches: Vec::new(),
                phases: Vec::new(),
                windows: Vec::new(),
            };
            let mut own: Vec<Track> = balances.iter().map(of).collect();
            for _ in 0..ROUNDS {
                for track in &mut own {
                    track.walk(problem, &system, &states, box_);
                    track.sweep();
                    track.smooth();
                    let (state, rate) = (track.balance.state(), track.balance.rate());
                    for (box_, node) in states.iter_mut().zip(&track.nodes) {
                        (box_[state], box_[rate]) = *node;
                    }
                }
            }
            for track in &mut own {
                track.choose(&Region::of_box(box_));
            }
            tracks.append(&mut own);
        }
        Balances { tracks }
    }

    /// Adds what is told of the unknowns of a region, and tells about how far from linear that is in each axis.
    pub(crate) fn tell(&self, region: &Region, rows: &mut Rows) -> Vec<f64> {
        let mut bends = vec![0.0; region.axes()];
        for track in &self.tracks {
            track.tell(region, rows, &mut bends);
        }
        bends
    }
}

impl Track {
    /// Encloses what happens between samples.
    fn walk(
        &mut self,
        problem: &Problem,
        system: &System,
        states: &[Vec<Interval>],
        box_: &[Interval],
    ) {
        let course = &problem.courses[self.record];
        let (state, rate) = (self.balance.state(), self.balance.rate());
        self.nodes = states.iter().map(|x| (x[state], x[rate])).collect();
        self.stretches.clear();
        let mut workspace = Workspace::new(system, StepOptions::default());
        for (k, stretch) in course.stretches.iter().enumerate() {
            if k + 1 >= states.len() {
                break;
            }
            let later = problem.later(self.record).start;
            let first = problem.params().start;
            let values = (0..problem.layout.params).map(|param| match course.value(param, k) {
                Value::First => Some(first + param),
                Value::Later(position) => Some(later + position),
                Value::Passing | Value::Recorded(_) => None,
            });
            let Some(values) = values.collect::<Option<Vec<usize>>>() else {
                self.stretches.push(None);
                continue;
            };
            let params: Vec<Interval> = values.iter().map(|value| box_[*value]).collect();
            let mut ends = states[k].clone();
            let inputs = &course.instants[k].inputs;
            let dt = stretch.dt;
            let moved = system.step(&mut ends, &params, inputs, dt, &mut workspace);
            let acting = moved
                .ok()
                .and_then(|_| system.modes_in_tube(&mut workspace));
            let Some(modes) = acting else {
                self.stretches.push(None);
                continue;
            };
            let phase = self.phases.iter().position(|known| *known == values);
            let phase = phase.unwrap_or_else(|| {
                self.phases.push(values);
                self.phases.len() - 1
            });
            let tube = workspace.tube().to_vec();
            self.stretches.push(Some(Stretch {
                dt,
                bend: workspace.velocity()[rate],
                tube,
                inputs: inputs.clone(),
                modes,
                phase,
            }));
        }
    }

    /// Takes what is known of states and rates at a sample to the next one, and to the one before: what comes to rest
    /// is where it rests.
    fn sweep(&mut self) {
        let (state, rate) = (self.balance.state(), self.balance.rate());
        let last = self.nodes.len().saturating_sub(1).min(self.stretches.len());
        let forward = (0..last).map(|k| (k, k + 1));
        let back = (0..last).rev().map(|k| (k + 1, k));
        for (from, to) in forward.chain(back) {
            let Some(stretch) = &self.stretches[from.min(to)] else {
                continue;
            };
            let time = if from < to { stretch.dt } else { -stretch.dt };
            let (x, w) = self.nodes[from];
            let x = (x + time * stretch.tube[rate]).intersect(stretch.tube[state]);
            let w = (w + time * stretch.bend).intersect(stretch.tube[rate]);
            self.narrow(to, (x, w));
        }
    }

    /// Narrows a state and its rate; that nothing is left is for rows to say.
    fn narrow(&mut self, node: usize, (x, w): (Interval, Interval)) {
        let own = &mut self.nodes[node];
        let left = (own.0.intersect(x), own.1.intersect(w));
        if !(left.0.is_empty() || left.1.is_empty()) {
            *own = left;
        }
    }

    /// Narrows states and rates at samples by their neighbours.
    ///
    /// Proof. Taylor's theorem with integral remainders: for times `a < t < b` with `w'` in `V` almost everywhere between,
    /// `x(t) = (x(a) (b - t) + x(b) (t - a))/(b - a) - R` with `R` in `(t - a) (b - t)/2 V`, since Green's function is not negative and has
    /// that integral; and `w(t) = (x(b) - x(t))/(b - t) - (b - t)/2 v` with some `v` in `V`, likewise backwards.
    fn smooth(&mut self) {
        let half = Interval::point(0.5);
        // Times and accelerations from a sample on, in one direction.
        let reach = |from: usize, is_back: bool| {
            let (mut time, mut bend) = (Interval::ZERO, Interval::EMPTY);
            let mut list = Vec::new();
            for by in 1..=NEIGHBOURS {
                let at = if is_back {
                    from.checked_sub(by)
                } else {
                    Some(from + by - 1)
                };
                let stretch = at.and_then(|at| self.stretches.get(at)?.as_ref());
                let Some(stretch) = stretch else { break };
                time += stretch.dt;
                bend = bend.hull(stretch.bend);
                list.push((time, bend));
            }
            list
        };
        let nodes = (0..self.nodes.len()).map(|k| {
            let (mut x, mut w) = self.nodes[k];
            let (back, ahead) = (reach(k, true), reach(k, false));
            for (p, (before, first)) in back.iter().enumerate() {
                let left = self.nodes[k - p - 1].0;
                w = w.intersect((x - left) / *before + half * *before * *first);
                for (q, (after, second)) in ahead.iter().enumerate() {
                    let right = self.nodes[k + q + 1].0;
                    let share = *after / (*before + *after);
                    let chord = right + share * (left - right);
                    let rest = half * *before * *after * first.hull(*second);
                    x = x.intersect(chord - rest);
                }
            }
            for (q, (after, bend)) in ahead.iter().enumerate() {
                let right = self.nodes[k + q + 1].0;
                w = w.intersect((right - x) / *after - half * *after * *bend);
            }
            (x, w)
        });
        let nodes: Vec<(Interval, Interval)> = nodes.collect();
        for (node, left) in nodes.into_iter().enumerate() {
            self.narrow(node, left);
        }
    }

    /// Chooses the functions that tell most of a region, some for every direction.
    fn choose(&mut self, region: &Region) {
        let phases = self.phases(region);
        let levels = self.blocks(region, &phases);
        // By direction, with how far they cut into the region.
        let mut best: BTreeMap<Vec<i8>, Vec<(f64, usize)>> = BTreeMap::new();
        let mut windows = Vec::new();
        for (level, blocks) in levels.iter().enumerate() {
            for shape in SHAPES {
                for from in 0..(blocks.len() + 2).saturating_sub(shape.len()) {
                    let window = Window { level, from, shape };
                    let Some(told) = self.balanced(&window, &levels, &phases) else {
                        continue;
                    };
                    let Some(phase) = &phases[told.at] else {
                        continue;
                    };
                    let [low, high] = &phase.corners;
                    for is_above in [true, false] {
                        let sign = if is_above { 1.0 } else { -1.0 };
                        let slopes = told.sums[0].slopes.iter().zip(low.iter().zip(high));
                        let slopes = slopes.map(|(slope, (lo, hi))| {
                            sign * end(*slope, is_above) * 0.5 * (hi - lo)
                        });
                        let slopes: Vec<f64> = slopes.collect();
                        let middle = sign * end(told.sums[0].at, is_above);
                        let middle = middle + slopes.iter().sum::<f64>();
                        let largest = slopes.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                        let sum: f64 = slopes.iter().map(|x| x.abs()).sum();
                        let may_cut = sum > 0.0 && middle <= NEARLY * sum;
                        if !may_cut {
                            continue;
                        }
                        let mut direction: Vec<i8> = slopes
                            .iter()
                            .map(|x| (DIRECTIONS * x / largest).round() as i8)
                            .collect();
                        direction.push(told.at as i8);
                        let list = best.entry(direction).or_default();
                        list.push((middle / sum, windows.len()));
                    }
                    windows.push(Some(window));
                }
            }
        }
        let mut kept = BTreeSet::new();
        for list in best.values_mut() {
            list.sort_by(|a, b| a.0.total_cmp(&b.0));
            kept.extend(list.iter().take(ALIKE).map(|(_, window)| *window));
        }
        let chosen = kept.into_iter().filter_map(|window| windows[window].take());
        self.windows = chosen.collect();
    }

    /// The phases for a region; nothing where the factor is not known.
    fn phases(&self, region: &Region) -> Vec<Option<Phase>> {
        let whole = vec![Interval::symmetric(1.0); region.axes()];
        let phase = |values: &Vec<usize>| {
            let ranges = values.iter().map(|value| region.range(*value, &whole));
            let params: Vec<Interval> = ranges.collect();
            if !params.iter().all(|x| x.is_bounded()) {
                return None;
            }
            let mut factor = self.balance.factor(&params)?;
            let middles = params.iter().map(|x| Interval::point(x.mid()));
            let middles: Vec<Interval> = middles.collect();
            let [middle, _] = self.balance.factor(&middles)?;
            let near = middle.at.mid();
            for side in &mut factor {
                side.at -= Interval::point(near);
            }
            Some(Phase {
                corners: [
                    params.iter().map(|x| x.lo()).collect(),
                    params.iter().map(|x| x.hi()).collect(),
                ],
                near,
                factor,
            })
        };
        self.phases.iter().map(phase).collect()
    }

    /// Blocks of 1, 2, 4, ... stretches.
    fn blocks(&self, region: &Region, phases: &[Option<Phase>]) -> Vec<Vec<Option<Block>>> {
        let whole = vec![Interval::symmetric(1.0); region.axes()];
        let one = |(k, stretch): (usize, &Option<Stretch>)| {
            let stretch = stretch.as_ref()?;
            let near = phases[stretch.phase].as_ref()?.near;
            let values = self.phases[stretch.phase].iter();
            let params: Vec<Interval> = values.map(|value| region.range(*value, &whole)).collect();
            let box_ = (&stretch.tube[..], &params[..], &stretch.inputs[..]);
            let rest = self.balance.rest(box_, stretch.modes)?;
            let params = params.len();
            let times = |time: Interval| {
                let mut both = [FromCorner::zero(params), FromCorner::zero(params)];
                let pairs = both.iter_mut().zip(&rest);
                pairs.for_each(|(own, rest)| own.add(time, rest));
                both
            };
            let rise = share(near, stretch.dt);
            let fall = Interval::ONE - rise;
            let tube = stretch.tube[self.balance.state()];
            let sum = self.nodes[k].0 + self.nodes[k + 1].0;
            let mean = trapezoid(sum, stretch.bend, stretch.dt).intersect(tube);
            Some(Block {
                time: stretch.dt,
                phase: stretch.phase,
                up: times(rise * stretch.dt),
                down: times(fall * stretch.dt),
                mean: weighed(near, stretch.dt, mean, tube),
            })
        };
        let mut levels: Vec<Vec<Option<Block>>> =
            vec![self.stretches.iter().enumerate().map(one).collect()];
        while let Some(parts) = levels.last().filter(|parts| parts.len() > 1) {
            let pairs = parts.chunks_exact(2);
            let joined = pairs.map(|pair| {
                let (first, second) = (pair[0].as_ref()?, pair[1].as_ref()?);
                let near = phases[first.phase].as_ref()?.near;
                (first.phase == second.phase).then(|| first.join(second, near))
            });
            let joined = joined.collect();
            levels.push(joined);
        }
        levels
    }

    fn balanced(
        &self,
        window: &Window,
        levels: &[Vec<Option<Block>>],
        phases: &[Option<Phase>],
    ) -> Option<Told> {
        let (from, shape) = (window.from, window.shape);
        let blocks = levels[window.level].get(from..from + shape.len() - 1)?;
        let first = blocks.first()?.as_ref()?.phase;
        let phase = phases[first].as_ref()?;
        let near = Interval::point(phase.near);
        let node = |position: usize| self.nodes[(from + position) << window.level];
        let value = |position: usize| Interval::point(shape[position]);
        let last = shape.len() - 1;
        let params = phase.corners[0].len();
        let mut sums = [FromCorner::zero(params), FromCorner::zero(params)];
        // What states at samples and their means say, with their rates at both ends.
        let mut known = value(last) * node(last).1 - value(0) * node(0).1;
        let mut integral = value(last) * node(last).0 - value(0) * node(0).0;
        let mut before = Interval::ZERO;
        for (position, block) in blocks.iter().enumerate() {
            let block = block.as_ref().filter(|block| block.phase == first)?;
            let (begin, end) = (value(position), value(position + 1));
            let rise = rising(phase.near, block.time);
            let constant = begin * (near - rise) + end * rise;
            known += node(position).0 * (constant - before);
            before = constant;
            integral -= (end - begin) * block.mean;
            for (sum, (up, down)) in sums.iter_mut().zip(block.up.iter().zip(&block.down)) {
                for (factor, part) in [(begin, down), (end, up)] {
                    if factor != Interval::ZERO {
                        sum.add(factor, part);
                    }
                }
            }
        }
        known -= node(last).0 * before;
        let is_known = |x: Interval| x.is_bounded() && !x.is_empty();
        if !(is_known(known) && is_known(integral)) {
            return None;
        }
        for (sum, factor) in sums.iter_mut().zip(&phase.factor) {
            sum.add(integral, factor);
            sum.at -= known;
        }
        Some(Told {
            sums,
            at: first,
            unsure: integral.width(),
        })
    }

    fn tell(&self, region: &Region, rows: &mut Rows, bends: &mut [f64]) {
        let phases = self.phases(region);
        let levels = self.blocks(region, &phases);
        let axes = region.axes();
        for window in &self.windows {
            let Some(Told { sums, at, unsure }) = self.balanced(window, &levels, &phases) else {
                continue;
            };
            let Some(phase) = &phases[at] else { continue };
            let values = &self.phases[at];
            for (is_upper, (sum, corner)) in [false, true]
                .into_iter()
                .zip(sums.iter().zip(&phase.corners))
            {
                // At most as large as the upper line, which is not below zero then; and at least the lower one.
                for is_above in [true, false] {
                    let mut rest = Interval::point(end(sum.at, is_above));
                    let mut slopes = vec![Interval::ZERO; axes];
                    for ((value, slope), corner) in values.iter().zip(&sum.slopes).zip(corner) {
                        let slope = Interval::point(end(*slope, is_above != is_upper));
                        rest += slope * (region.offset(*value) - Interval::point(*corner));
                        for (own, axis) in slopes.iter_mut().zip(&region.axes[*value]) {
                            *own += slope * Interval::point(*axis);
                        }
                    }
                    let points: Vec<f64> = slopes.iter().map(|slope| slope.mid()).collect();
                    for (slope, point) in slopes.iter().zip(&points) {
                        let lost = *slope - Interval::point(*point);
                        rest += lost * Interval::symmetric(1.0);
                    }
                    let side = if is_above {
                        Interval::new(0.0, f64::INFINITY)
                    } else {
                        Interval::new(f64::NEG_INFINITY, 0.0)
                    };
                    let side = side.unwrap_or(Interval::ENTIRE);
                    rows.push_outer(&points, side - rest);
                }
            }
            let [low, high] = &sums;
            for (param, value) in values.iter().enumerate() {
                let factor = phase.factor[0].slopes[param].mag();
                let bent = (low.slopes[param].mid() - high.slopes[param].mid()).abs();
                for (bend, axis) in bends.iter_mut().zip(&region.axes[*value]) {
                    *bend += (factor * unsure + bent) * axis.abs();
                }
            }
        }
    }
}

fn end(x: Interval, is_upper: bool) -> f64 {
    if is_upper { x.hi() } else { x.lo() }
}

impl Block {
    fn join(&self, other: &Block, near: f64) -> Block {
        let time = self.time + other.time;
        let at = rising(near, time) / rising(near, self.time);
        let at = at.intersect(unit());
        let left = (Interval::ONE - at).intersect(unit());
        let sum = |parts: [(Interval, &FromCorners); 3]| {
            let params = self.up[0].slopes.len();
            let mut both = [FromCorner::zero(params), FromCorner::zero(params)];
            for (factor, part) in parts {
                let pairs = both.iter_mut().zip(part);
                pairs.for_each(|(own, part)| own.add(factor, part));
            }
            both
        };
        Block {
            time,
            phase: self.phase,
            up: sum([
                (at, &self.up),
                (at, &other.down),
                (Interval::ONE, &other.up),
            ]),
            down: sum([
                (Interval::ONE, &self.down),
                (left, &self.up),
                (left, &other.down),
            ]),
            mean: at * self.mean + left * other.mean,
        }
    }
}

fn unit() -> Interval {
    Interval::ZERO.hull(Interval::ONE)
}

/// `1/(1 - e^(-z)) - 1/z`, for small `z`.
///
/// Proof. It is `1/2 + L(z/2)/2` with `L(x) = coth x - 1/x = Σ 2x/(x² + n² π²)`. Each of these terms is, in absolute value, at most
/// `2x/(n² π²)` and less than that by at most `2x³/(n π)^4`; the sums are `x/3` and `x³/45`.
fn series(z: Interval) -> Interval {
    let linear = z / Interval::point(12.0);
    let less = z * z.sqr() / Interval::point(720.0);
    Interval::point(0.5) + linear - Interval::ZERO.hull(less)
}

/// `a/(1 - e^(-a t))`: what `ψ' + a ψ` is on a block of length `t` with *up*.
fn rising(a: f64, t: Interval) -> Interval {
    let z = Interval::point(a) * t;
    if z.mag() < SMALL {
        (Interval::ONE + z * series(z)) / t
    } else {
        Interval::point(a) / (Interval::ONE - (-z).exp())
    }
}

/// The mean of *up* on a block of length `t`.
fn share(a: f64, t: Interval) -> Interval {
    let z = Interval::point(a) * t;
    let mean = if z.mag() < SMALL {
        series(z)
    } else {
        Interval::ONE / (Interval::ONE - (-z).exp()) - Interval::ONE / z
    };
    mean.intersect(unit())
}

/// The mean of a state on a stretch, by the sum of its ends and its second derivative.
///
/// Proof. By parts, `∫ x = h (x(0) + x(h))/2 - ∫ s (h - s) x''(s) ds / 2`, and the weight `s (h - s)` is not negative and has the
/// integral `h³/6`.
fn trapezoid(sum: Interval, bend: Interval, h: Interval) -> Interval {
    Interval::point(0.5) * sum - h.sqr() / Interval::point(12.0) * bend
}

/// The mean of a state on a stretch, weighed by the derivative of *up*.
///
/// Proof. The weight is `q = a e^(-a t)/(1 - e^(-a h))`, between `q(0) = rising` and `q(h) = rising - a`, with the integral 1; so the means differ
/// by the integral of `(q - 1/h) (x - c)`, whatever `c` is.
fn weighed(a: f64, h: Interval, mean: Interval, tube: Interval) -> Interval {
    let first = rising(a, h) * h;
    let last = first - Interval::point(a) * h;
    let off = (first.hull(last) - Interval::ONE).mag();
    let reach = Interval::point(off) * Interval::point(tube.rad());
    (mean + Interval::symmetric(reach.hi())).intersect(tube)
}

#[cfg(test)]
#[path = "../../../flow/tests/common/mod.rs"]
mod common;

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::common::{Rng, number, read, rig_step};
    use super::*;
    use veribound_interval::Decimal;
    use veribound_model::Sample;

    const RIG: &str = "format = 1\nstates = [\"phi\", \"omega\"]\n[inputs]\nu = { error = { relative = 0.1 } }\n[init]\nphi = [-1, 1]\n\
        omega = 0\n[params]\nalpha = [-6, -0.05]\nbeta = [1, 400]\nT = [0, 0.3]\n[der]\nphi = \"omega\"\n\
        omega = \"alpha*omega + beta*(u - friction(omega, u, T))\"\n[outputs]\nangle = \"phi +- 0.1\"\n";

    /// A true course with times, states, and inputs as recorded, of which another tenth is off at every sample.
    fn course(rng: &mut Rng, p: [f64; 3], samples: usize) -> (Vec<Sample>, Vec<[f64; 2]>) {
        let (mut x, mut u, mut left, mut time) = ([0.0, 0.0], 0.0, 0, Decimal::zero());
        let (mut record, mut states) = (Vec::new(), Vec::new());
        for line in 0..samples {
            if left == 0 {
                u = rng.pick(&[0.0, 1.0, -1.0, 1.0]) * rng.between(0.1, 0.4);
                left = 5 + rng.below(40);
            }
            left -= 1;
            let share = rng.pick(&[-1.0, 1.0, 0.0]) * 0.1 * (1.0 - 1e-12);
            let within = Interval::point(u) * Interval::symmetric(0.1);
            record.push(Sample {
                time: time.clone(),
                inputs: vec![Interval::point(u) + within],
                outputs: vec![Some(Interval::point(x[0]).inflate(0.1))],
                signals: Vec::new(),
                line,
            });
            states.push(x);
            // Not all stretches are equally long.
            let step = rng.pick(&["0.01", "0.01", "0.025"]);
            let h = Decimal::parse(step).unwrap();
            let (phi, omega) = rig_step(x[0], x[1], u * (1.0 + share), p, h.to_interval().mid());
            (x, time) = ([phi, omega], &time + &h);
        }
        (record, states)
    }

    /// Whatever boxes of states around a true course are known, and whatever region around the true parameters is asked
    /// about, upright or turned: these satisfy all rows. Rows exclude others.
    #[test]
    fn true_parameters_satisfy_all_rows() {
        let model = read("rig", RIG);
        let mut rng = Rng(number("VERIBOUND_SEED", 5));
        let (mut all, mut cutting) = (0, 0);
        for _ in 0..number("VERIBOUND_ROUNDS", 40) {
            let p = [
                rng.between(-4.0, -0.5),
                rng.between(50.0, 300.0),
                rng.between(0.02, 0.25),
            ];
            let count = 60 + rng.below(200);
            let (record, states) = course(&mut rng, p, count);
            let problem = Problem::of(&model, std::slice::from_ref(&record));
            // What is known of states, often very well.
            let reach = rng.pick(&[1e-7, 1e-3, 0.05]);
            let seen = states.iter().map(|x| {
                let box_ = x.map(|x| {
                    let (below, above) = (rng.unit() * reach, rng.unit() * reach);
                    Interval::new(x - below - 1e-9, x + above + 1e-9).unwrap()
                });
                // It rests exactly.
                let rests = x[1] == 0.0;
                vec![box_[0], if rests { Interval::ZERO } else { box_[1] }]
            });
            let seen: Vec<Vec<Interval>> = seen.collect();
            let mut box_ = problem.believed();
            let size = rng.pick(&[0.3, 0.1, 0.01]);
            for (quantity, (truth, width)) in problem.params().zip(p.iter().zip([6.0, 400.0, 0.3]))
            {
                let (below, above) = (rng.pick(&[0.0, 1.0]), rng.pick(&[0.0, 0.5, 1.0]));
                let whole =
                    Interval::new(truth - below * size * width, truth + above * size * width);
                box_[quantity] = whole.unwrap().inflate(1e-9).intersect(box_[quantity]);
            }
            let balances = Balances::of(&model, &problem, std::slice::from_ref(&seen), &box_);
            let mut region = Region::of_box(&box_);
            let first = problem.params().start;
            // A shear keeps the truth at other unknowns.
            let axes = region.axes();
            let mut unknowns = vec![Interval::ZERO; axes];
            for (quantity, truth) in problem.params().zip(p) {
                let axis = region.axes[quantity]
                    .iter()
                    .position(|x| *x != 0.0)
                    .unwrap();
                let at = Interval::point(truth) - Interval::point(region.centre[quantity]);
                unknowns[axis] = at / Interval::point(region.axes[quantity][axis]);
            }
            if rng.chance(0.5) {
                let from = region.axes[first].iter().position(|x| *x != 0.0).unwrap();
                let slope = 0.3
                    * region.axes[first + 1]
                        .iter()
                        .fold(0.0, |m: f64, x| m.max(x.abs()));
                region.axes[first + 1][from] = slope;
                let to = region.axes[first + 1]
                    .iter()
                    .rposition(|x| *x != 0.0)
                    .unwrap();
                let moved = Interval::point(slope) * unknowns[from];
                unknowns[to] -= moved / Interval::point(region.axes[first + 1][to]);
                if !unknowns[to].is_subset_of(Interval::symmetric(1.0)) {
                    continue;
                }
            }
            let mut rows = Rows::new(axes);
            let bends = balances.tell(&region, &mut rows);
            assert!(bends.iter().all(|bend| *bend >= 0.0));
            for row in 0..rows.len() {
                let slopes = rows.slopes(row).iter().zip(&unknowns);
                let value = slopes.fold(Interval::ZERO, |sum, (slope, x)| {
                    sum + Interval::point(*slope) * *x
                });
                assert!(
                    value.intersects(rows.outer(row)),
                    "{p:?}: {value} {}",
                    rows.outer(row)
                );
                let most: f64 = rows.slopes(row).iter().map(|slope| slope.abs()).sum();
                cutting += usize::from(!Interval::symmetric(most).is_subset_of(rows.outer(row)));
                all += 1;
            }
        }
        println!("trials of balances: {all}, cutting {cutting}");
        assert!(all > 5_000 && 2 * cutting > all, "{all} {cutting}");
    }

    /// The mean of *up*, and what it is multiplied by, at `a T` small and large, against sums of many terms.
    #[test]
    fn functions_of_a_block() {
        for z in [1e-9_f64, -1e-3, 0.01, -0.0156, 0.02, -0.3, 1.7, -5.0] {
            let t = Interval::point(0.5);
            let a = 2.0 * z;
            let up = |s: f64| (-z * s).exp_m1() / (-z).exp_m1();
            let n = 20_000;
            let mean: f64 = (0..n)
                .map(|k| up((f64::from(k) + 0.5) / f64::from(n)))
                .sum::<f64>()
                / f64::from(n);
            let (told, rise) = (share(a, t), rising(a, t));
            assert!(
                told.inflate(1e-9).contains(mean) && told.width() < 1e-7,
                "{z}: {told} {mean}"
            );
            let exact = -a / (-z).exp_m1();
            assert!(
                rise.inflate(1e-9).contains(exact) && rise.width() < 1e-6,
                "{z}: {rise} {exact}"
            );
        }
    }
}
