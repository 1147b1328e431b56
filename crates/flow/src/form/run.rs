//! Whole runs: the degree is raised, and then the set divided, until the result is tight enough.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one entry per state, unknown or stretch, from the same lists"
)]

use super::flow::{Diverged, Flow};
use super::journey::Journey;
use super::set::{Form, FormOptions, MOST_TERMS, Unknown, terms, usual_degree};
use veribound_interval::Interval;

/// Highest degree that is worth trying.
const HIGHEST_DEGREE: usize = 12;

/// A run is given up for a better one when so much of a width is not a function of the unknowns.
const HOPELESS: f64 = 0.6;

/// Time during which inputs stay inside their intervals.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch {
    /// Every value each input can have.
    pub inputs: Vec<Interval>,
    /// Length in seconds.
    pub dt: Interval,
}

/// When a run is good enough, and what may be spent.
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
/// every one they lie in its box of `ends`, and during the stretch in its box of `tubes`.
#[derive(Debug, Clone, PartialEq)]
pub struct Enclosure {
    /// One box of states for the end of every stretch.
    pub ends: Vec<Vec<Interval>>,
    /// One box of states for all times of every stretch.
    pub tubes: Vec<Vec<Interval>>,
    /// Number of parts that the set was divided into.
    pub parts: usize,
    /// Why not all stretches are listed, if they are not.
    pub stopped: Option<Diverged>,
}

/// Narrow sets need no more than this degree,
const LOW: usize = 2;

/// if what is no function of the unknowns is this share of what would do,
const SMALL: f64 = 0.1;

/// or this one where switches take some in any case.
const MODEST: f64 = 0.4;

/// A higher degree is worth it where it makes the excess smaller by this factor.
const WORTHWHILE: f64 = 0.9;

/// One part of the start set.
type Part = (Vec<Interval>, Vec<Interval>);

/// How one form went through the stretches, as far as it came.
struct Passage {
    ends: Vec<Vec<Interval>>,
    tubes: Vec<Vec<Interval>>,
    failure: Option<Diverged>,
    last: Form,
    /// How much each unknown decides when surfaces are met that could not be crossed.
    torn: Vec<f64>,
}

impl Passage {
    /// Smaller is better.
    fn excess(&self) -> f64 {
        match self.failure {
            None => self.last.excess(),
            Some(_) => f64::INFINITY,
        }
    }
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
        let mut open: Vec<Part> = vec![(states.to_vec(), params.to_vec())];
        let mut result = Enclosure {
            ends: Vec::new(),
            tubes: Vec::new(),
            parts: 0,
            stopped: None,
        };
        while let Some(part) = open.pop() {
            let passage = self.best_passage(&part, stretches, options, effort);
            let divisible = result.parts + open.len() + 2 <= effort.parts;
            let halves = if divisible && passage.excess() > effort.excess {
                divide(&part, &passage)
            } else {
                None
            };
            if let Some(halves) = halves {
                open.extend(halves);
                continue;
            }
            let is_first = result.parts == 0;
            result.parts += 1;
            merge(&mut result.ends, passage.ends, is_first);
            merge(&mut result.tubes, passage.tubes, is_first);
            if let Some(stopped) = passage.failure {
                let before = result.stopped.as_ref().map(|known| known.reached.lo());
                if before.is_none_or(|before| stopped.reached.lo() < before) {
                    result.stopped = Some(stopped);
                }
                // Nothing beyond can be proved for all parts, and further parts are not worth it.
                if result.ends.is_empty() {
                    break;
                }
            }
        }
        result
    }

    /// The passage of the lowest degree that is good enough, or the best one.
    fn best_passage(
        &self,
        part: &Part,
        stretches: &[Stretch],
        options: FormOptions,
        effort: Effort,
    ) -> Passage {
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
            self.pass(part, stretches, with(degree), most)
        };
        if options.degree.is_none() && LOW < first {
            let quick = pass(LOW);
            // Higher degrees do not help against what switches take.
            let share = if self.is_smooth() { SMALL } else { MODEST };
            if quick.excess() <= share * effort.excess {
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
            if next.excess() <= best.excess() {
                best = next;
            }
            if !helps && !has_failed {
                break;
            }
        }
        best
    }

    /// One form through all stretches; it gives up where its excess passes `most`.
    fn pass(&self, part: &Part, stretches: &[Stretch], options: FormOptions, most: f64) -> Passage {
        let form = self.start(&part.0, &part.1, options);
        let mut journey = Journey::new(self, form, stretches);
        journey.most = most;
        let failure = journey.run().err();
        Passage {
            ends: journey.ends,
            tubes: journey.tubes,
            failure,
            last: journey.form,
            torn: journey.torn,
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
fn divide((states, params): &Part, passage: &Passage) -> Option<[Part; 2]> {
    let form = &passage.last;
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
        }
    }
    Some(halves)
}

/// Hulls of boxes, one by one, as far as both lists go.
fn merge(into: &mut Vec<Vec<Interval>>, from: Vec<Vec<Interval>>, is_first: bool) {
    if is_first {
        *into = from;
        return;
    }
    into.truncate(from.len());
    for (into, from) in into.iter_mut().zip(from) {
        for (x, y) in into.iter_mut().zip(from) {
            *x = x.hull(y);
        }
    }
}
