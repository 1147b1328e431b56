//! What functions of time say of parameters, by the balance of a record.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: samples, phases and stretches of a track, parameters of the problem"
)]

use std::ops::Range;

use super::super::region::Region;
use super::super::rows::Rows;
use super::adjoint::{Function, Known, Push, refuting};
use super::ramps::{rising, share, trapezoid, weighed};
use super::track::{Choices, Part, Track};
use veribound_flow::balance::{FromCorner, FromCorners};
use veribound_flow::{Acting, ModeSet};
use veribound_interval::Interval;

/// Functions are looked for among so many pushes at most: those of stretches of a long record are taken together.
const MOST_PUSHES: usize = 4096;

/// A function `ψ`, made for parameters of one phase and this value of `A`.
pub(super) struct Window {
    phase: usize,
    near: f64,
    function: Function,
}

/// Values of parameters for a region.
struct Phase {
    /// The corners that bounds are seen from,
    corners: [Vec<f64>; 2],
    /// and bounds of `A`.
    factor: FromCorners,
}

/// What bounds there are for a region.
pub(super) struct View {
    phases: Vec<Option<Phase>>,
    nodes: Vec<(Interval, Interval)>,
    rests: Rests,
}

/// Bounds of `r`, and which of these each stretch has.
struct Rests {
    all: Vec<FromCorners>,
    of: Vec<Option<usize>>,
}

/// A point of a region, and what is known there.
pub(super) struct Posed<'a> {
    track: &'a Track,
    /// Values of parameters in each phase.
    params: Vec<Vec<Interval>>,
    rests: Rests,
    nodes: Vec<(Interval, Interval)>,
    within: Range<usize>,
}

/// What a function says.
struct Told {
    /// What is zero for true parameters, as functions of these.
    sums: FromCorners,
    /// How far the integral of the rate is unsure.
    unsure: f64,
}

impl Track {
    /// What bounds there are for a region, if stops are where they may be by choice.
    pub(super) fn view(&self, region: &Region, choices: &Choices) -> View {
        let whole = vec![Interval::symmetric(1.0); region.axes()];
        let values = |values: &Vec<usize>| -> Vec<Interval> {
            let ranges = values.iter().map(|value| region.range(*value, &whole));
            ranges.collect()
        };
        let params: Vec<Vec<Interval>> = self.phases.iter().map(values).collect();
        let phase = |params: &Vec<Interval>| {
            if !params.iter().all(|x| x.is_bounded()) {
                return None;
            }
            Some(Phase {
                corners: [
                    params.iter().map(|x| x.lo()).collect(),
                    params.iter().map(|x| x.hi()).collect(),
                ],
                factor: self.balance.factor(params)?,
            })
        };
        View {
            phases: params.iter().map(phase).collect(),
            nodes: self.nodes_with(choices),
            rests: self.rests(&params, choices, self.all()),
        }
    }

    /// Bounds of `r` with these parameters in each phase, over some stretches.
    fn rests(&self, params: &[Vec<Interval>], choices: &Choices, within: Range<usize>) -> Rests {
        let mut parts = vec![Part::Open; self.stretches.len()];
        for (stop, choice) in self.stops.iter().zip(choices) {
            for k in stop.stretches.clone() {
                parts[k] = stop.part(choice, k);
            }
        }
        let mut rests = Rests {
            all: Vec::new(),
            of: vec![None; self.stretches.len()],
        };
        let mut last = None;
        for (k, part) in within.clone().zip(&parts[within]) {
            let part = *part;
            let Some(stretch) = &self.stretches[k] else {
                continue;
            };
            if last == Some((stretch.alike, part)) {
                rests.of[k] = rests.of[k - 1];
                continue;
            }
            last = Some((stretch.alike, part));
            let box_ = (
                &stretch.tube[..],
                &params[stretch.phase][..],
                &stretch.inputs[..],
            );
            let acting = stretch.acting.clone();
            let acting = match part {
                Part::Open => acting,
                Part::Moving => Acting {
                    levels: Vec::new(),
                    ..acting
                },
                Part::Resting => Acting {
                    modes: ModeSet::EMPTY,
                    ..acting
                },
            };
            if let Some(own) = self.balance.rest(box_, &acting) {
                rests.all.push(own);
                rests.of[k] = Some(rests.all.len() - 1);
            }
        }
        rests
    }

    /// A point of a region over some stretches, if stops are where they may be by choice.
    pub(super) fn posed(
        &self,
        (region, point): (&Region, &[f64]),
        choices: &Choices,
        within: Range<usize>,
    ) -> Posed<'_> {
        let at = |value: &usize| {
            let slopes = region.axes[*value].iter().zip(point);
            let off: f64 = slopes.map(|(slope, x)| slope * x).sum();
            Interval::point(region.centre[*value] + off)
        };
        let params = self
            .phases
            .iter()
            .map(|values| values.iter().map(at).collect());
        let params: Vec<Vec<Interval>> = params.collect();
        Posed {
            rests: self.rests(&params, choices, within.clone()),
            nodes: self.nodes_with(choices),
            track: self,
            params,
            within,
        }
    }

    fn balanced(&self, window: &Window, view: &View) -> Option<Told> {
        let phase = view.phases[window.phase].as_ref()?;
        let near = Interval::point(window.near);
        let params = phase.corners[0].len();
        let mut sums = [FromCorner::zero(params), FromCorner::zero(params)];
        // What states at samples and their means say, with rates where the function jumps.
        let (mut known, mut integral) = (Interval::ZERO, Interval::ZERO);
        // Of the last stretch: the value at its end, and `ψ' + a ψ`.
        let (mut before, mut constant) = (Interval::ZERO, Interval::ZERO);
        let mut weights: Option<Weights> = None;
        let mut alike: Option<Alike> = None;
        let from = window.function.from;
        let node = |position: usize| view.nodes[from + position];
        for (position, [begin, end]) in window.function.values.iter().enumerate() {
            let stretch = self.stretches[from + position].as_ref()?;
            let own = weights.filter(|weights| weights.dt == stretch.dt);
            let own = own.unwrap_or_else(|| Weights::of(window.near, stretch.dt));
            let Weights { rise, share, .. } = own;
            weights = Some(own);
            let (begin, end) = (Interval::point(*begin), Interval::point(*end));
            let own = begin * (near - rise) + end * rise;
            let (x, w) = node(position);
            if before != begin {
                known += (before - begin) * w;
                integral += (before - begin) * x;
            }
            known += (own - constant) * x;
            (before, constant) = (end, own);
            integral -= (end - begin) * self.mean(view, from + position, (rise, window.near))?;
            let rest = view.rests.of[from + position]?;
            let alike = match &mut alike {
                Some(alike) if alike.rest == rest => alike,
                other => {
                    let last = other.replace(Alike::from(rest));
                    if let Some(last) = last {
                        last.close(view, &mut sums);
                    }
                    other.as_mut()?
                }
            };
            alike.add(begin * (stretch.dt * (Interval::ONE - share)));
            alike.add(end * (stretch.dt * share));
        }
        alike?.close(view, &mut sums);
        let (x, w) = node(window.function.values.len());
        known += before * w - constant * x;
        integral += before * x;
        let is_known = |x: Interval| x.is_bounded() && !x.is_empty();
        if !(is_known(known) && is_known(integral)) {
            return None;
        }
        for (sum, factor) in sums.iter_mut().zip(&phase.factor) {
            let mut factor = factor.clone();
            factor.at -= near;
            sum.add(integral, &factor);
            sum.at -= known;
        }
        Some(Told {
            sums,
            unsure: integral.width(),
        })
    }

    /// The mean of the state on a stretch, weighed by the derivative of *up*.
    fn mean(&self, view: &View, k: usize, (rise, near): (Interval, f64)) -> Option<Interval> {
        let stretch = self.stretches[k].as_ref()?;
        let tube = stretch.tube[self.balance.state()];
        let sum = view.nodes[k].0 + view.nodes[k + 1].0;
        let mean = trapezoid(sum, stretch.bend, stretch.dt).intersect(tube);
        Some(weighed(rise, Interval::point(near), stretch.dt, mean, tube))
    }

    /// Adds what a function says of the unknowns of a region, and tells about how far from linear that is in each axis.
    pub(super) fn say(
        &self,
        window: &Window,
        (region, view): (&Region, &View),
        rows: &mut Rows,
    ) -> Vec<f64> {
        let axes = region.axes();
        let mut bent = vec![0.0; axes];
        let Some(Told { sums, unsure }) = self.balanced(window, view) else {
            return bent;
        };
        let Some(phase) = &view.phases[window.phase] else {
            return bent;
        };
        let values = &self.phases[window.phase];
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
            let apart = (low.slopes[param].mid() - high.slopes[param].mid()).abs();
            for (bent, axis) in bent.iter_mut().zip(&region.axes[*value]) {
                *bent += (factor * unsure + apart) * axis.abs();
            }
        }
        bent
    }
}

impl Posed<'_> {
    /// Functions over some stretches that refute the point, also where what is known of states had this share more of its width.
    pub(super) fn refuting(&self, margin: f64) -> Vec<Window> {
        let Posed {
            track,
            params,
            rests,
            nodes,
            within,
        } = self;
        let known = |node: &(Interval, Interval)| {
            let is_bounded = node.0.is_bounded() && node.1.is_bounded();
            let wider = |x: Interval| {
                let (middle, radius) = x.mid_rad();
                let radius = (1.0 + margin) * radius;
                [middle - radius, middle + radius]
            };
            is_bounded.then(|| [wider(node.0), wider(node.1)])
        };
        let known: Vec<Option<Known>> = nodes.iter().map(known).collect();
        let together = within.len().div_ceil(MOST_PUSHES).max(1);
        let mut windows = Vec::new();
        let (mut from, end) = (within.start, within.end);
        while from < end {
            let Some(phase) = track.stretches[from].as_ref().map(|stretch| stretch.phase) else {
                from += 1;
                continue;
            };
            let push = |k: usize| {
                let stretch = track.stretches[k].as_ref();
                let stretch = stretch.filter(|stretch| stretch.phase == phase)?;
                let [rest, _] = &rests.all[rests.of[k]?];
                Some(Push {
                    dt: stretch.dt.mid(),
                    least: rest.at.lo(),
                    most: rest.at.hi(),
                })
            };
            // Stretches in a row are one push, until what follows is not known.
            let (mut nodes, mut pushes, mut groups) = (Vec::new(), Vec::new(), Vec::new());
            nodes.extend(known[from]);
            let mut at = from;
            while at < end && !nodes.is_empty() {
                let group = (at..end.min(at + together)).map_while(push);
                let group: Vec<Push> = group.collect();
                let next = at + group.len();
                let (Some(push), Some(node)) = (Push::together(&group), known[next]) else {
                    break;
                };
                pushes.push(push);
                nodes.push(node);
                groups.push((at, group));
                at = next;
            }
            if let (Some([factor, _]), false) =
                (track.balance.factor(&params[phase]), pushes.is_empty())
            {
                let near = factor.at.mid();
                let functions = refuting(near, &nodes, &pushes).into_iter();
                windows.extend(functions.map(|function| Window {
                    phase,
                    near,
                    function: function.apart(near, &groups),
                }));
            }
            from = at.max(from + 1);
        }
        windows
    }
}

fn end(x: Interval, is_upper: bool) -> f64 {
    if is_upper { x.hi() } else { x.lo() }
}

/// What the values at both ends of a stretch of some length are multiplied by: [`rising`] and [`share`].
#[derive(Clone, Copy)]
struct Weights {
    dt: Interval,
    rise: Interval,
    share: Interval,
}

impl Weights {
    fn of(a: f64, dt: Interval) -> Weights {
        Weights {
            dt,
            rise: rising(a, dt),
            share: share(a, dt),
        }
    }
}

/// Integrals of a function over stretches with the same bounds of `r`, of what is above and of what is below zero.
struct Alike {
    rest: usize,
    integrals: [Interval; 2],
}

impl Alike {
    fn from(rest: usize) -> Alike {
        Alike {
            rest,
            integrals: [Interval::ZERO; 2],
        }
    }

    fn add(&mut self, integral: Interval) {
        self.integrals[usize::from(integral.lo() < 0.0)] += integral;
    }

    /// Adds what it is with `r`: by the mean value theorem there is one value of `r` for each of the two.
    fn close(&self, view: &View, sums: &mut FromCorners) {
        let rest = &view.rests.all[self.rest];
        let own = self.integrals.iter();
        for integral in own.filter(|integral| **integral != Interval::ZERO) {
            let pairs = sums.iter_mut().zip(rest);
            pairs.for_each(|(own, rest)| own.add(*integral, rest));
        }
    }
}
