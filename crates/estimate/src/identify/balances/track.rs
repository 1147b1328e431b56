//! A record as balances see it: states at samples, and what happens between them.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: samples, stretches and states of the problem"
)]

use std::ops::{Range, RangeInclusive};

use super::super::problem::{Problem, Value};
use super::said::Window;
use veribound_flow::balance::Balance;
use veribound_flow::{Acting, StepOptions, System, Workspace};
use veribound_interval::Interval;

/// States at samples are narrowed by those so many stretches away at most.
const LONGEST: usize = 1 << 10;

/// What happens between two samples is enclosed by its ends and by what acts there, in turns,
const TUBES: usize = 1;

/// Whether a stop is in one of its stretches is told by so many around.
const AROUND: usize = 256;

/// Between two samples.
pub(super) struct Stretch {
    pub(super) dt: Interval,
    /// All states at all times of it.
    pub(super) tube: Vec<Interval>,
    pub(super) inputs: Vec<Interval>,
    /// What acts on the rate.
    pub(super) acting: Acting,
    /// Which values of parameters act.
    pub(super) phase: usize,
    /// Of the rate.
    pub(super) bend: Interval,
    /// The first one of those before this one in a row which have the same bounds of `r`.
    pub(super) alike: usize,
}

/// A balance along a record.
pub(super) struct Track {
    pub(super) record: usize,
    pub(super) balance: Balance,
    /// The state and its rate at samples.
    pub(super) nodes: Vec<(Interval, Interval)>,
    /// Where a stretch was proved.
    pub(super) stretches: Vec<Option<Stretch>>,
    /// Positions of the parameters' values among the quantities.
    pub(super) phases: Vec<Vec<usize>>,
    pub(super) stops: Vec<Stop>,
    pub(super) windows: Vec<Window>,
    /// Nothing is left at some sample: there are no solutions with these parameters that agree with the record.
    pub(super) is_refuted: bool,
}

/// Stretches in a row: their time, and the integrals of `w'`, of `(b - s) w'` and of `(s - a) w'`.
#[derive(Clone, Copy)]
struct Span {
    time: Interval,
    gain: Interval,
    ahead: Interval,
    behind: Interval,
}

impl Span {
    fn then(&self, next: &Span) -> Span {
        Span {
            time: self.time + next.time,
            gain: self.gain + next.gain,
            ahead: self.ahead + next.time * self.gain + next.ahead,
            behind: self.behind + self.time * next.gain + next.behind,
        }
    }
}

/// Stretches in which the rate comes to a level once and stays there until their end; or leaves it once, after it was there from
/// their begin on.
pub(super) struct Stop {
    pub(super) stretches: Range<usize>,
    pub(super) comes: bool,
    level: f64,
}

/// For every stop of a track the stretches in one of which it is.
pub(super) type Choices = Vec<Range<usize>>;

/// What of a stretch is known.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    Open,
    Moving,
    Resting,
}

impl Stop {
    /// What is known of one of its stretches if the stop is in these.
    pub(super) fn part(&self, choice: &Range<usize>, k: usize) -> Part {
        let (is_before, is_after) = (k < choice.start, k >= choice.end);
        if self.comes && is_before || !self.comes && is_after {
            Part::Moving
        } else if is_before || is_after {
            Part::Resting
        } else {
            Part::Open
        }
    }

    /// The samples at which it is certain to be on the level.
    fn rests(&self, choice: &Range<usize>) -> RangeInclusive<usize> {
        if self.comes {
            choice.end..=self.stretches.end
        } else {
            self.stretches.start..=choice.start
        }
    }
}

impl Track {
    pub(super) fn of(record: usize, balance: &Balance) -> Track {
        Track {
            record,
            balance: balance.clone(),
            nodes: Vec::new(),
            stretches: Vec::new(),
            phases: Vec::new(),
            stops: Vec::new(),
            windows: Vec::new(),
            is_refuted: false,
        }
    }

    /// Encloses what happens between samples.
    pub(super) fn walk(
        &mut self,
        problem: &Problem,
        system: &System,
        states: &mut [Vec<Interval>],
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
            if moved.is_err() {
                self.stretches.push(None);
                continue;
            }
            for (known, end) in states[k + 1].iter_mut().zip(&ends) {
                let left = known.intersect(*end);
                self.is_refuted |= left.is_empty();
                if !left.is_empty() {
                    *known = left;
                }
            }
            self.nodes[k + 1] = (states[k + 1][state], states[k + 1][rate]);
            let mut tube = workspace.tube().to_vec();
            let known = workspace.velocity()[rate];
            // What acts is known better where both ends tell where solutions are between, and the other way round.
            let mut acting = Acting::default();
            let mut bend = Some(known);
            for _ in 0..=TUBES {
                let Some(last) = bend else { break };
                self.thin(&mut tube, k, dt, last);
                let box_ = (&tube[..], &params[..], &inputs[..]);
                acting = system.acting_on(box_, rate, &mut workspace);
                bend = self
                    .balance
                    .bend(box_, &acting)
                    .map(|own| own.intersect(last));
            }
            let Some(bend) = bend else {
                self.stretches.push(None);
                continue;
            };
            let phase = self.phases.iter().position(|known| *known == values);
            let phase = phase.unwrap_or_else(|| {
                self.phases.push(values);
                self.phases.len() - 1
            });
            let before = self.stretches.last().and_then(Option::as_ref);
            let alike = before.filter(|before| {
                let same = (&before.tube[..], &before.inputs[..]);
                let is_same = self.balance.are_alike(same, (&tube, inputs));
                before.phase == phase && before.acting == acting && is_same
            });
            self.stretches.push(Some(Stretch {
                dt,
                bend,
                alike: alike.map_or(k, |before| before.alike),
                tube,
                inputs: inputs.clone(),
                acting,
                phase,
            }));
        }
    }

    /// Narrows a tube by what is known at both of its ends, and of the rate's derivative between.
    fn thin(&self, tube: &mut [Interval], k: usize, dt: Interval, bend: Interval) {
        let (state, rate) = (self.balance.state(), self.balance.rate());
        let time = Interval::ZERO.hull(dt);
        let between = |ends: [Interval; 2], slope: Interval| {
            let [begin, end] = ends;
            (begin + time * slope).intersect(end - time * slope)
        };
        let (begin, end) = (self.nodes[k], self.nodes[k + 1]);
        tube[rate] = tube[rate].intersect(between([begin.1, end.1], bend));
        tube[state] = tube[state].intersect(between([begin.0, end.0], tube[rate]));
    }

    /// Takes what is known of states and rates at a sample to the next one, and to the one before: what comes to rest
    /// is where it rests.
    pub(super) fn sweep(&mut self) {
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

    /// Narrows a state and its rate.
    fn narrow(&mut self, node: usize, (x, w): (Interval, Interval)) {
        let own = &mut self.nodes[node];
        let left = (own.0.intersect(x), own.1.intersect(w));
        if left.0.is_empty() || left.1.is_empty() {
            self.is_refuted = true;
        } else {
            *own = left;
        }
    }

    /// Narrows states and rates at samples by those 1, 2, 3, 4, 6, 8, 12, ... stretches away.
    ///
    /// Proof. Taylor's theorem with integral remainders: for `x' = w` and times `a < b`, `x(b) = x(a) + (b - a) w(a) + I` with
    /// `I = ∫ (b - s) w'(s) ds`, and `x(b) = x(a) + (b - a) w(b) - J` with `J = ∫ (s - a) w'(s) ds`; neither weight is negative. With `t` between them,
    /// the same from `t` on and until `t`, times `t - a` and `b - t`, is `x(t) = (x(a) (b - t) + x(b) (t - a))/(b - a) - R` with
    /// `R = ((t - a) I(t, b) + (b - t) J(a, t))/(b - a)`. For two neighbouring stretches `∫ w'`, `I` and `J` follow from those of each.
    pub(super) fn smooth(&mut self) {
        let half = Interval::point(0.5);
        let spans = self.stretches.iter().map(|stretch| {
            let stretch = stretch.as_ref()?;
            let moment = half * stretch.dt.sqr() * stretch.bend;
            Some(Span {
                time: stretch.dt,
                gain: stretch.dt * stretch.bend,
                ahead: moment,
                behind: moment,
            })
        });
        let spans: Vec<Option<Span>> = spans.collect();
        let joined = |first: &[Option<Span>], reach: usize, next: &[Option<Span>]| {
            let pairs = first.iter().zip(next.get(reach..).unwrap_or_default());
            let pairs = pairs.map(|(first, next)| Some(first.as_ref()?.then(next.as_ref()?)));
            pairs.collect::<Vec<Option<Span>>>()
        };
        let (mut short, mut reach) = (spans, 1);
        self.smooth_by(&short, reach);
        loop {
            let long = joined(&short, reach, &short);
            self.smooth_by(&long, 2 * reach);
            if 2 * reach >= LONGEST || 3 * reach > self.stretches.len() {
                return;
            }
            self.smooth_by(&joined(&short, reach, &long), 3 * reach);
            (short, reach) = (long, 2 * reach);
        }
    }

    /// The same with all spans of so many stretches.
    fn smooth_by(&mut self, spans: &[Option<Span>], reach: usize) {
        let nodes = (0..self.nodes.len()).map(|k| {
            let (mut x, mut w) = self.nodes[k];
            let ahead = spans.get(k).copied().flatten();
            let behind = k.checked_sub(reach).and_then(|from| *spans.get(from)?);
            let left = || self.nodes[k - reach].0;
            let right = || self.nodes[k + reach].0;
            if let (Some(behind), Some(ahead)) = (&behind, &ahead) {
                let whole = behind.time + ahead.time;
                let share = ahead.time / whole;
                let chord = right() + share * (left() - right());
                let rest = (behind.time * ahead.ahead + ahead.time * behind.behind) / whole;
                x = x.intersect(chord - rest);
            }
            if let Some(behind) = &behind {
                w = w.intersect((x - left() + behind.behind) / behind.time);
            }
            if let Some(ahead) = &ahead {
                w = w.intersect((right() - x - ahead.ahead) / ahead.time);
            }
            (x, w)
        });
        let nodes: Vec<(Interval, Interval)> = nodes.collect();
        for (node, left) in nodes.into_iter().enumerate() {
            self.narrow(node, left);
        }
    }

    /// The functions that were chosen.
    pub(super) fn windows(&self) -> &[Window] {
        &self.windows
    }

    /// Positions among the quantities of all values of parameters.
    pub(super) fn params(&self) -> impl Iterator<Item = usize> {
        self.phases.iter().flatten().copied()
    }

    /// All stretches,
    pub(super) fn all(&self) -> Range<usize> {
        0..self.stretches.len()
    }

    /// and those around a stop.
    pub(super) fn around(&self, stop: usize) -> Range<usize> {
        let stretches = &self.stops[stop].stretches;
        let end = self.stretches.len().min(stretches.end + AROUND);
        stretches.start.saturating_sub(AROUND)..end
    }

    /// Stops of which nothing is known yet.
    pub(super) fn choices(&self) -> Choices {
        let stops = self.stops.iter();
        stops.map(|stop| stop.stretches.clone()).collect()
    }

    /// Finds the stretches in which the rate comes to a level, or leaves it.
    ///
    /// Proof. On each of them the rate is on one side of the level, and does not go away from it (does not come nearer, before it
    /// leaves). So the times at which it is on the level are those from one on to the end (from the begin to one), where it is
    /// known to be there.
    pub(super) fn find_stops(&mut self) {
        let rate = self.balance.rate();
        // The level, whether the rate is above it, and whether it comes to it, for what is both moving and at rest.
        let open = |k: usize| {
            let stretch = self.stretches.get(k)?.as_ref()?;
            let [level] = stretch.acting.levels[..] else {
                return None;
            };
            let tube = stretch.tube[rate];
            let is_above = tube.lo() >= level;
            let falls = stretch.bend.hi() <= 0.0;
            let is_clear = !stretch.acting.modes.is_empty()
                && (is_above || tube.hi() <= level)
                && (falls || stretch.bend.lo() >= 0.0);
            is_clear.then_some((level, is_above, is_above == falls))
        };
        let mut stops = Vec::new();
        let mut from = 0;
        while from < self.stretches.len() {
            let Some(kind) = open(from) else {
                from += 1;
                continue;
            };
            let more = (from..).take_while(|k| open(*k) == Some(kind));
            let stretches = from..from + more.count();
            let (level, _, comes) = kind;
            let rests_at = if comes { stretches.end } else { from };
            from = stretches.end;
            if self.nodes[rests_at].1 == Interval::point(level) {
                stops.push(Stop {
                    stretches,
                    comes,
                    level,
                });
            }
        }
        self.stops = stops;
    }

    /// States at samples, where those between which the rate is on a level by choice tell each other: the state moves with the level.
    pub(super) fn nodes_with(&self, choices: &Choices) -> Vec<(Interval, Interval)> {
        let mut nodes = self.nodes.clone();
        for (stop, choice) in self.stops.iter().zip(choices) {
            let level = Interval::point(stop.level);
            let mut moved = Interval::ZERO;
            let moves = stop.rests(choice).map(|node| {
                let own = moved;
                if let Some(Some(stretch)) = self.stretches.get(node) {
                    moved += level * stretch.dt;
                }
                (node, own)
            });
            let moves: Vec<(usize, Interval)> = moves.collect();
            let known = moves
                .iter()
                .filter_map(|(node, moved)| Some(nodes.get(*node)?.0 - *moved));
            let place = known.fold(Interval::ENTIRE, Interval::intersect);
            for (node, moved) in moves {
                if let Some(own) = nodes.get_mut(node) {
                    *own = (place + moved, level);
                }
            }
        }
        nodes
    }
}
