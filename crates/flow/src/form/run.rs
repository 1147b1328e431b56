//! Whole runs: the degree is raised, and then the set divided, until the result is tight enough.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one entry per state, unknown or stretch, from the same lists"
)]

use super::allowance::at_once;
use super::flow::{Diverged, Flow};
use super::journey::Journey;
use super::proved::Proved;
use super::set::{Form, FormOptions, MOST_TERMS, Unknown, terms, usual_degree};
use super::step::Obstacle;
use crate::modes::ModeSet;
use std::sync::Arc;
use veribound_interval::Interval;

/// Highest degree that is worth trying.
const HIGHEST_DEGREE: usize = 12;

/// A run is given up for a better one when so much of a width is not a function of the unknowns.
const HOPELESS: f64 = 0.6;

/// Time during which inputs stay inside their intervals.
///
/// Example: [`Engines`](crate::engine::Engines).
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch {
    /// Every value each input can have.
    pub inputs: Vec<Interval>,
    /// Length in seconds.
    pub dt: Interval,
}

/// When a run is good enough, and what may be spent.
///
/// Example: [`Engines`](crate::engine::Engines).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// Share of any width at the end that may be more than is a function of the unknowns.
    pub excess: f64,
    /// Most parts that the set is divided into.
    pub parts: usize,
}

impl Default for Effort {
    fn default() -> Self {
        Effort {
            excess: 0.15,
            parts: 64,
        }
    }
}

/// What is proved about a whole run.
///
/// Guarantee: all solutions from the start set exist to the end of the last stretch listed; at the end of
/// every one they lie in its box of `ends`, and during the stretch in its box of `tubes`. The same holds of
/// the values that outputs have, with inputs that are any measurable functions in those of the stretch.
///
/// ```
/// use veribound_flow::form::{Effort, Enclosure, Flow, FormOptions, Part, Standing, Stretch};
/// use veribound_interval::Interval;
///
/// # let text = "format = 1\nstates = [\"x\"]\ninit.x = [0.9, 1.1]\nparams.k = [0.5, 1]\nder.x = \"-k*x\"\noutputs.y = \"x +- 0.01\"";
/// # let model = veribound_model::Model::from_text("decay.toml", text)?;
/// let (start, params) = ([model.states[0].init], [model.params[0].bounds]);
/// let stretches = vec![Stretch { inputs: vec![], dt: Interval::point(0.5) }; 4];
/// let go_on = |standing: Standing| standing.done < 100;
/// let (options, effort) = (FormOptions::default(), Effort::default());
/// let flow = Flow::new(&model);
/// let found: Enclosure = flow.enclose_watched((&start, &params), &stretches, options, effort, &go_on);
/// assert_eq!((found.ends.len(), found.stopped.is_none()), (4, true));
/// assert!(found.tubes[0][0].contains(1.0) && found.ends[3][0].is_subset_of(found.tubes[3][0]));
/// let whole: &Part = &found.parts[0];
/// assert_eq!((found.parts.len(), whole.passed), (1, 4));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Enclosure {
    /// One box of states for the end of every stretch.
    pub ends: Vec<Vec<Interval>>,
    /// One box of states for all times of every stretch.
    pub tubes: Vec<Vec<Interval>>,
    /// One box of outputs for the start of every stretch that was begun: those listed, and the next.
    pub outputs: Vec<Vec<Interval>>,
    /// One box of outputs for all times of every stretch.
    pub output_tubes: Vec<Vec<Interval>>,
    /// For every stretch the modes that are not proved to be left out: at almost all times of it, velocities
    /// are convex combinations of theirs, group by group.
    pub modes: Vec<ModeSet>,
    /// The parts that the set was divided into.
    pub parts: Vec<Part>,
    /// For every state, how much of its width each unknown decides, as shares that add up to at most one: at the
    /// end of the way, in the part in which it is widest. What is left is what dependence could not keep.
    pub shares: Vec<Vec<(Unknown, f64)>>,
    /// Number of steps that were proved, on all ways that were tried.
    pub steps: u64,
    /// Why not all stretches are listed, if they are not.
    pub stopped: Option<Diverged>,
}

impl Enclosure {
    /// What both prove of the same solutions on their way through the same stretches; the longer one goes on
    /// alone, and tells of parts and shares.
    pub fn both(self, other: Enclosure) -> Enclosure {
        let (mut longer, mut shorter) = if other.ends.len() > self.ends.len() {
            (other, self)
        } else {
            (self, other)
        };
        let mut proved = longer.take_proved();
        proved.restrict(&shorter.take_proved());
        longer.steps += shorter.steps;
        longer.with(proved)
    }

    fn take_proved(&mut self) -> Proved {
        let mut proved = Proved::default();
        proved.ends = std::mem::take(&mut self.ends);
        proved.tubes = std::mem::take(&mut self.tubes);
        proved.outputs = std::mem::take(&mut self.outputs);
        proved.output_tubes = std::mem::take(&mut self.output_tubes);
        proved.modes = std::mem::take(&mut self.modes);
        proved
    }

    fn with(self, proved: Proved) -> Enclosure {
        Enclosure {
            ends: proved.ends,
            tubes: proved.tubes,
            outputs: proved.outputs,
            output_tubes: proved.output_tubes,
            modes: proved.modes,
            ..self
        }
    }
}

/// A part of the start set, and where it went.
///
/// Example: [`Enclosure`].
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Start values.
    pub states: Vec<Interval>,
    /// Parameters.
    pub params: Vec<Interval>,
    /// Number of stretches that were proved for it, maybe more than are listed.
    pub passed: usize,
    /// The states at the end of the last of them.
    pub end: Vec<Interval>,
}

/// How far an enclosure has come.
///
/// Example: [`Enclosure`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Standing {
    /// Time since the start that the part at hand has reached on this way.
    pub reached: f64,
    /// Number of parts that are done.
    pub done: usize,
    /// Number of parts that wait, without the one at hand.
    pub waiting: usize,
    /// Number of unknowns; where there is none, a single solution is enclosed.
    pub unknowns: usize,
    /// About what the next step costs: products of coefficients in one multiplication of polynomials.
    pub cost: f64,
}

/// Narrow sets need no more than this degree,
const LOW: usize = 2;

/// if what is no function of the unknowns is this share of what would do,
const SMALL: f64 = 0.1;

/// or this one where switches take some in any case.
const MODEST: f64 = 0.4;

/// A higher degree is worth it where it makes the excess smaller by this factor.
const WORTHWHILE: f64 = 0.9;

/// Start values and parameters.
type Set = (Vec<Interval>, Vec<Interval>);

/// How one form went through the stretches, as far as it came.
struct Passage {
    proved: Proved,
    failure: Option<Diverged>,
    /// The form at the end, or its parts, where outcomes parted,
    last: Vec<Form>,
    /// and those in between.
    borders: Vec<Form>,
    /// How much each unknown decides when surfaces are met that could not be crossed.
    torn: Vec<f64>,
}

impl Passage {
    /// Smaller is better.
    fn excess(&self) -> f64 {
        if self.failure.is_some() {
            return f64::INFINITY;
        }
        if let ([form], []) = (&self.last[..], &self.borders[..]) {
            return form.excess();
        }
        let (parts, borders) = (self.around(&self.last), self.around(&self.borders));
        let of_state = |(state, parts): (usize, &Interval)| {
            let rests = self.last.iter().map(|form| form.rest(state));
            let rest = rests.fold(0.0, f64::max);
            let own = if rest > 0.0 {
                rest / (rest + parts.rad())
            } else {
                0.0
            };
            // Borders do not become narrower by division. They matter where they reach beyond the parts, seen
            // from how wide the set was on its way.
            let beyond = parts.hull(borders[state]).rad() - parts.rad();
            let ends = self.proved.ends.iter().map(|end| end[state].rad());
            let largest = ends.fold(0.0, f64::max);
            own.max(if beyond > 0.0 { beyond / largest } else { 0.0 })
        };
        parts.iter().enumerate().map(of_state).fold(0.0, f64::max)
    }

    /// A box around some of the forms at the end.
    fn around(&self, forms: &[Form]) -> Vec<Interval> {
        let states = self.proved.ends.first().map_or(0, Vec::len);
        forms
            .iter()
            .fold(vec![Interval::EMPTY; states], |all, form| {
                let hull = form.quick_hull();
                all.iter().zip(&hull).map(|(a, b)| a.hull(*b)).collect()
            })
    }

    fn forms(&self) -> impl Iterator<Item = &Form> {
        self.last.iter().chain(&self.borders)
    }

    /// The part in which a state is widest.
    fn widest(&self, state: usize) -> Option<(f64, &Form)> {
        let widths = self.forms().map(|form| {
            let hull = form.quick_hull();
            (hull[state].width(), form)
        });
        widths.max_by(|a, b| a.0.total_cmp(&b.0))
    }

    fn is_interrupted(&self) -> bool {
        let failure = self.failure.as_ref();
        failure.is_some_and(|failure| failure.obstacle == Obstacle::Interrupted)
    }

    /// Takes in what else is proved of all its solutions.
    fn restrict(&mut self, other: &Passed) {
        if other.0.len() > self.proved.len() {
            self.failure.clone_from(&other.1);
        }
        self.proved.restrict(&other.0);
    }
}

/// What is proved of a set, and why no more.
type Passed = (Proved, Option<Diverged>);

/// What all passages go through, and who watches.
struct Task<'a> {
    stretches: &'a [Stretch],
    options: FormOptions,
    effort: Effort,
    /// Asked at every step whether to go on, with the form that will be moved.
    go_on: &'a (dyn Fn(&Form) -> bool + Sync),
}

impl Flow {
    /// Encloses all solutions that start in `states` with parameters in `params`, over all stretches.
    ///
    /// Guarantee: that of [`Enclosure`]. The degree is raised while that helps, unless the options fix
    /// it; then the set is divided, as far as `effort` allows, at the unknown that decides when a surface is
    /// met which could not be crossed, or else at the one that is least linear. What is not good enough then
    /// is returned as it is, as far as all parts could be proved.
    pub fn enclose(
        &self,
        states: &[Interval],
        params: &[Interval],
        stretches: &[Stretch],
        options: FormOptions,
        effort: Effort,
    ) -> Enclosure {
        self.enclose_watched((states, params), stretches, options, effort, &|_| true)
    }

    /// As [`Flow::enclose`]; `go_on` is asked at every step whether to go on.
    ///
    /// Guarantee: that of [`Enclosure`], also where the answer was no: then what was proved until then is
    /// listed, and the rest is [`Obstacle::Interrupted`].
    pub fn enclose_watched(
        &self,
        (states, params): (&[Interval], &[Interval]),
        stretches: &[Stretch],
        options: FormOptions,
        effort: Effort,
        go_on: &(dyn Fn(Standing) -> bool + Sync),
    ) -> Enclosure {
        let whole: Set = (states.to_vec(), params.to_vec());
        // Each with what was proved of it before it was divided.
        let mut open: Vec<(Set, Option<Arc<Passed>>)> = vec![(whole, None)];
        let mut all: Option<Proved> = None;
        let mut result = Enclosure::default();
        let mut widths = vec![-1.0; states.len()];
        result.shares = vec![Vec::new(); states.len()];
        while let Some((part, before)) = open.pop() {
            let task = Task {
                stretches,
                options,
                effort,
                go_on: &|form| {
                    go_on(Standing {
                        reached: form.elapsed.mid(),
                        done: result.parts.len(),
                        waiting: open.len(),
                        unknowns: form.unknowns.len(),
                        cost: form.cost(),
                    })
                },
            };
            let most = (effort.parts).saturating_sub(result.parts.len() + open.len());
            let mut passage = self.best_passage(&part, &task, most.max(1));
            result.steps += passage.proved.steps;
            let excess = passage.excess();
            if let Some(before) = &before {
                passage.restrict(before);
            }
            let divisible = result.parts.len() + open.len() + 2 <= effort.parts;
            let halves = if divisible && excess > effort.excess && !passage.is_interrupted() {
                divide(&part, &passage)
            } else {
                None
            };
            if let Some(halves) = halves {
                let passed = Arc::new((passage.proved, passage.failure));
                open.extend(halves.map(|half| (half, Some(Arc::clone(&passed)))));
                continue;
            }
            for (state, known) in widths.iter_mut().enumerate() {
                if let Some((width, form)) = passage.widest(state)
                    && width > *known
                {
                    *known = width;
                    result.shares[state] = form.shares(state);
                }
            }
            result.parts.push(Part {
                states: part.0,
                params: part.1,
                passed: passage.proved.len(),
                end: passage.proved.ends.last().cloned().unwrap_or_default(),
            });
            match &mut all {
                Some(all) => all.join(&passage.proved),
                None => all = Some(passage.proved),
            }
            if let Some(stopped) = passage.failure {
                let before = result.stopped.as_ref().map(|known| known.reached.lo());
                if before.is_none_or(|before| stopped.reached.lo() < before) {
                    result.stopped = Some(stopped);
                }
                // Nothing beyond can be proved for all parts, and further parts are not worth it.
                if all.as_ref().is_some_and(|all| all.len() == 0) {
                    break;
                }
            }
        }
        result.with(all.unwrap_or_default())
    }

    /// The passage of the lowest degree that is good enough, or the best one.
    fn best_passage(&self, part: &Set, task: &Task<'_>, parts: usize) -> Passage {
        let (options, effort) = (task.options, task.effort);
        let unknowns = self.start(&part.0, &part.1, options).unknowns().len();
        let (first, last) = match options.degree {
            Some(degree) => (degree, degree),
            None if self.is_smooth() => (usual_degree(unknowns), highest_degree(unknowns)),
            None => (usual_degree(unknowns), usual_degree(unknowns)),
        };
        let with = |degree: usize| FormOptions {
            degree: Some(degree),
            ..options
        };
        let pass = |degree: usize| {
            // Where modes mix for a moment, states forget and become functions of the unknowns again.
            let most = if !self.is_smooth() {
                f64::INFINITY
            } else if degree == LOW && LOW < first {
                SMALL * effort.excess
            } else if degree < last {
                HOPELESS
            } else {
                f64::INFINITY
            };
            self.pass(part, task, with(degree), (most, parts))
        };
        let low = self.low_degree(unknowns, task.stretches);
        if options.degree.is_none() && low < first {
            let quick = pass(low);
            // Higher degrees do not help against what switches take.
            let share = if self.is_smooth() { SMALL } else { MODEST };
            if quick.excess() <= share * effort.excess || quick.is_interrupted() {
                return quick;
            }
        }
        let mut best = pass(first);
        for degree in first + 1..=last {
            if best.excess() <= effort.excess {
                break;
            }
            let next = pass(degree);
            let helps = next.excess() <= WORTHWHILE * best.excess();
            let has_failed = best.failure.is_some();
            let is_better = next.excess() <= best.excess();
            let (better, other) = if is_better {
                (next, best)
            } else {
                (best, next)
            };
            let is_over = other.is_interrupted();
            best = better;
            best.proved.steps += other.proved.steps;
            best.restrict(&(other.proved, other.failure));
            if is_over || (!helps && !has_failed) {
                break;
            }
        }
        best
    }

    /// One form through all stretches, in at most so many `parts` where outcomes part; it gives up where its excess
    /// passes `most`.
    fn pass(
        &self,
        part: &Set,
        task: &Task<'_>,
        options: FormOptions,
        (most, parts): (f64, usize),
    ) -> Passage {
        let form = self.start(&part.0, &part.1, options);
        let mut journey = Journey::new(self, form, task.stretches).telling_outputs();
        journey.most = most;
        journey.go_on = task.go_on;
        let mut passage = Passage {
            proved: Proved::default(),
            failure: None,
            last: Vec::new(),
            borders: Vec::new(),
            torn: vec![0.0; journey.torn.len()],
        };
        let mut steps = 0;
        let mut open = vec![journey];
        while let Some(mut journey) = open.pop() {
            journey.others = open.len() + passage.forms().count();
            journey.may_part = parts.saturating_sub(journey.others);
            let failure = at_once(journey.run()).err();
            steps += journey.proved.steps;
            if !journey.parts.is_empty() {
                open.append(&mut journey.parts);
                continue;
            }
            for (all, own) in passage.torn.iter_mut().zip(&journey.torn) {
                *all = all.max(*own);
            }
            let reached = |failure: &Diverged| failure.reached.lo();
            let is_first = passage.forms().next().is_none();
            if let Some(failure) = failure
                && passage
                    .failure
                    .as_ref()
                    .is_none_or(|known| reached(&failure) < reached(known))
            {
                passage.failure = Some(failure);
            }
            if is_first {
                passage.proved = journey.proved;
            } else {
                passage.proved.join(&journey.proved);
            }
            if journey.is_border {
                passage.borders.push(journey.form);
            } else {
                passage.last.push(journey.form);
            }
        }
        passage.proved.steps = steps;
        self.tighten(&mut passage.proved, (&part.0, &part.1), task.stretches);
        passage
    }
}

impl Flow {
    /// The degree that is tried first. Where inputs drive modes that switch, it is one more if that costs little: positions that
    /// come back to where they were then depend on nothing but what is of high degree.
    fn low_degree(&self, unknowns: usize, stretches: &[Stretch]) -> usize {
        let counts = (unknowns, self.layout.states);
        let mut pairs = stretches.windows(2);
        let is_driven = !self.is_smooth() && pairs.any(|pair| pair[0].inputs != pair[1].inputs);
        if is_driven && terms(counts, LOW, LOW + 1) <= 2 * terms(counts, 1, LOW) {
            LOW + 1
        } else {
            LOW
        }
    }
}

/// The highest degree whose polynomials are small enough.
fn highest_degree(unknowns: usize) -> usize {
    let mut degrees = (0..=HIGHEST_DEGREE).rev();
    let highest = degrees.find(|degree| terms((unknowns, 0), 1, *degree) <= MOST_TERMS);
    highest.unwrap_or(0).max(usual_degree(unknowns))
}

/// The halves of a part along the unknown that most crossings were lost by, or that its form depends on least
/// linearly.
fn divide((states, params): &Set, passage: &Passage) -> Option<[Set; 2]> {
    let curved = |form: &Form| form.curvature().iter().sum::<f64>();
    let form = passage
        .forms()
        .max_by(|a, b| curved(a).total_cmp(&curved(b)))?;
    let weights = if passage.torn.iter().any(|weight| *weight > 0.0) {
        passage.torn.clone()
    } else {
        form.curvature()
    };
    let v = (0..weights.len()).max_by(|a, b| weights[*a].total_cmp(&weights[*b]))?;
    let mut halves = [
        (states.clone(), params.clone()),
        (states.clone(), params.clone()),
    ];
    let whole = match form.unknowns().get(v)?.0 {
        Unknown::Start(i) => states[i],
        Unknown::Param(i) => params[i],
        Unknown::Axis(_) => return None,
    };
    let middle = whole.mid();
    let parts = [
        Interval::new(whole.lo(), middle)?,
        Interval::new(middle, whole.hi())?,
    ];
    for (half, x) in halves.iter_mut().zip(parts) {
        match form.unknowns().get(v)?.0 {
            Unknown::Start(i) => half.0[i] = x,
            Unknown::Param(i) => half.1[i] = x,
            Unknown::Axis(_) => return None,
        }
    }
    Some(halves)
}
