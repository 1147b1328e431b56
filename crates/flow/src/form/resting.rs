//! Jumps that leave solutions where they are: a mass on a stop, a ball on the floor.
//!
//! A jump that sets one state is *idle* on a level of that state if the new value there is the level itself. While the level is held,
//! it may happen or not: nothing changes.
//!
//! *Lemma (bars).* Let a jump be idle on `g = 0`, with a condition that is a conjunction: of `g > 0`, say, and of other comparisons, each
//! of which holds, border included, and either strictly, or it depends on states alone that no jump sets, rests while `g = 0`, and moves to
//! where it holds where `g > 0`. As long as those that hold strictly do, no solution goes from `g = 0` to `g > 0`.
//!
//! *Proof.* Let a solution have `g > 0` at some time, and look at the last time before at which `g = 0`, or at the last jump if that was later: after
//! an idle one `g = 0`, too. Since then it flows with `g > 0`, so that every comparison holds strictly. Strictly inside of a jump's region
//! nothing flows.
//!
//! So a surface is held where modes drive back from one side and a jump bars the other one, however hard a drive pushes into the
//! stop: what the jump sets stays, the other states go on (`crate::jump`, *Rest*).
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: surfaces, modes and states are named by positions in the model's lists"
)]

use super::piece::drift;
use super::regime::{Reason, Switching, Watch};
use super::surfaces::{Formula, Signs, Surfaces};
use veribound_interval::Interval;
use veribound_model::{ExprId, Graph, Model, Var};

/// A jump that changes nothing where a surface is zero.
#[derive(Debug, Clone)]
pub(super) struct Idle {
    jump: usize,
    /// A state's level: the only one that the jump sets.
    pub(super) surface: usize,
    pub(super) state: usize,
    bar: Option<Bar>,
}

/// Why solutions do not pass a surface on which a jump is idle.
#[derive(Debug, Clone)]
struct Bar {
    /// The side that they do not get to.
    side: Signs,
    others: Vec<Other>,
}

/// Another comparison of the condition.
#[derive(Debug, Clone)]
struct Other {
    surface: usize,
    allowed: Signs,
    /// It rests while the level is held, and moves to where it holds beyond.
    rests: bool,
}

/// Finds them; `rates[mode]` are the states it governs, each with its rate.
pub(super) fn idle_jumps(
    graph: &mut Graph,
    model: &Model,
    surfaces: &Surfaces,
    rates: &[Vec<(usize, ExprId)>],
) -> Vec<Idle> {
    let mut found = Vec::new();
    for (jump, described) in model.jumps.iter().enumerate() {
        let [(state, value)] = described.set[..] else {
            continue;
        };
        let mut asked = Vec::new();
        surfaces.jumps[jump].surfaces(&mut asked);
        for surface in asked {
            let level = surfaces.list[surface].level;
            let Some(level) = level.filter(|level| level.state == state) else {
                continue;
            };
            let on_level = |var: Var| (var == Var::State(state)).then_some(level.expr);
            if graph.substitute(value, &on_level) == level.expr {
                let bar = bar(graph, model, surfaces, rates, (jump, surface));
                found.push(Idle {
                    jump,
                    surface,
                    state,
                    bar,
                });
            }
        }
    }
    found
}

fn bar(
    graph: &mut Graph,
    model: &Model,
    surfaces: &Surfaces,
    rates: &[Vec<(usize, ExprId)>],
    (jump, surface): (usize, usize),
) -> Option<Bar> {
    let level = surfaces.list[surface].level?;
    let mut parts = Vec::new();
    surfaces.jumps[jump].conjunction(&mut parts)?;
    let strict = |allowed: Signs| match allowed.and(Signs::NEGATIVE.or(Signs::POSITIVE)) {
        sign @ (Signs::NEGATIVE | Signs::POSITIVE) => Some(sign),
        _ => None,
    };
    let (mut side, mut others) = (None, Vec::new());
    for (other, allowed) in parts {
        let way = strict(allowed)?;
        if other != surface {
            others.push((other, allowed, way));
        } else if side.replace(way).is_some() {
            return None;
        }
    }
    let side = side?;
    let upward = (side == Signs::POSITIVE) == level.rising;
    let mut rests = |other: usize, way: Signs| -> bool {
        let known = &surfaces.list[other];
        if !known.inputs.is_empty() {
            return false;
        }
        let mut slopes = Vec::with_capacity(known.gradient.len());
        for &(state, _) in &known.gradient {
            // What a jump sets may rest itself, and then it does not follow its rate.
            let flows = state != level.state && !model.jumps_in(state);
            let mut own = rates.iter().flatten().filter(|rate| rate.0 == state);
            match own.next() {
                Some(first) if flows && own.all(|rate| rate == first) => slopes.push(*first),
                _ => return false,
            }
        }
        let zero = graph.integer(0);
        let along = drift(graph, &known.gradient, &|state| {
            let rate = slopes.iter().find(|rate| rate.0 == state);
            rate.map_or(zero, |rate| rate.1)
        });
        let on_level = |var: Var| (var == Var::State(level.state)).then_some(level.expr);
        if graph.substitute(along, &on_level) != zero {
            return false;
        }
        let slope = graph.derivative(along, Var::State(level.state));
        let anywhere = |var: Var| match var {
            Var::Param(param) => model.params[param].bounds,
            _ => Interval::ENTIRE,
        };
        let grows = Signs::strict(graph.eval_interval(slope, &anywhere));
        grows.is_some_and(|sign| way == if upward { sign } else { sign.flipped() })
    };
    let others = others.into_iter().map(|(surface, allowed, way)| Other {
        surface,
        allowed,
        rests: rests(surface, way),
    });
    Some(Bar {
        side,
        others: others.collect(),
    })
}

impl Idle {
    /// The side of its surface, where that is zero, to which no solution gets while the other surfaces keep these signs.
    fn barred(&self, signs: &[Signs]) -> Option<Signs> {
        let bar = self.bar.as_ref()?;
        let mut others = bar.others.iter();
        let holds = others.all(|other| {
            let known = signs[other.surface];
            known.within(other.allowed) && (other.rests || !known.has(Signs::ZERO))
        });
        (signs[self.surface] == Signs::ZERO && holds).then_some(bar.side)
    }
}

impl Switching {
    /// The side of a surface, where that is held at zero, that a jump bars.
    pub(super) fn barred(&self, surface: usize, signs: &[Signs]) -> Option<Signs> {
        self.bar_at(surface, signs).map(|(side, _)| side)
    }

    fn bar_at(&self, surface: usize, signs: &[Signs]) -> Option<(Signs, &Idle)> {
        let mut idle = self.idle.iter().filter(|idle| idle.surface == surface);
        idle.find_map(|idle| Some((idle.barred(signs)?, idle)))
    }

    /// Comparisons that a bar needs: those that rest by themselves, and those that must be watched.
    pub(super) fn needed_by_bar(
        &self,
        surface: usize,
        signs: &[Signs],
    ) -> (Vec<usize>, Vec<usize>) {
        let bar = self
            .bar_at(surface, signs)
            .and_then(|(_, idle)| idle.bar.as_ref());
        let others = bar.map_or(&[][..], |bar| &bar.others);
        let (rest, watched): (Vec<&Other>, Vec<&Other>) =
            others.iter().partition(|other| other.rests);
        let surfaces = |list: Vec<&Other>| list.iter().map(|other| other.surface).collect();
        (surfaces(rest), surfaces(watched))
    }

    /// Whether a jump may happen that changes something while these surfaces are held.
    pub(super) fn may_change(&self, held: &[usize], signs: &[Signs]) -> bool {
        let mut jumps = self.surfaces.jumps.iter().enumerate();
        jumps.any(|(jump, formula)| {
            let is_idle = |idle: &Idle| idle.jump == jump && held.contains(&idle.surface);
            formula.possible(signs) && !self.idle.iter().any(is_idle)
        })
    }

    /// Whether a state may rest because a jump bars its way: then none of its modes tells its rate.
    pub(super) fn may_rest(&self, state: usize, signs: &[Signs]) -> bool {
        let mut idle = self.idle.iter().filter(|idle| idle.state == state);
        idle.any(|idle| idle.barred(signs).is_some())
    }

    /// What must be watched so that modes drive solutions back from the side of a surface that a jump bars while it is held, too; but
    /// not `known`. `None` where its rate is none of one mode.
    pub(super) fn back_from(
        &self,
        graph: &mut Graph,
        (surface, side): (usize, Signs),
        signs: &[Signs],
        known: Option<ExprId>,
    ) -> Option<Vec<Watch>> {
        let mut signs = signs.to_vec();
        signs[surface] = side;
        let state = self.surfaces.list[surface].level?.state;
        let mut watches = Vec::new();
        for mode in self.possible(self.group_of[state], &signs) {
            let watch = Watch {
                expr: self.drift_in(graph, surface, mode)?,
                sign: side.flipped(),
                reason: Reason::Hold { surface, side },
            };
            if Some(watch.expr) != known && !watches.contains(&watch) {
                watches.push(watch);
            }
        }
        Some(watches)
    }
}

impl Formula {
    /// Adds what must hold together; `None` where one of several conditions is enough.
    fn conjunction(&self, into: &mut Vec<(usize, Signs)>) -> Option<()> {
        match self {
            Formula::Always => Some(()),
            Formula::Sign { surface, allowed } => {
                into.push((*surface, *allowed));
                Some(())
            }
            Formula::All(parts) => parts.iter().try_for_each(|part| part.conjunction(into)),
            Formula::Any(_) => None,
        }
    }
}

#[cfg(test)]
#[allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]
mod tests {
    use super::*;

    /// A state `v` and its integral, by what `x` changes with, when it jumps, and to what.
    fn found(rate: &str, when: &str, set: &str) -> Vec<Idle> {
        let text = format!(
            "format = 1\nstates = [\"x\", \"v\", \"w\"]\ninputs = [\"u\"]\ninit = {{ x = 0, v = 0, w = 0 }}\nparams.e = [0.1, 0.9]\n\
             [der]\nx = \"{rate}\"\nv = \"u\"\nw = \"0\"\n[jumps]\nstop = {{ when = \"{when}\", set = {set} }}\n[outputs]\ny = \"x +- 1\"\n"
        );
        let model = Model::from_text("stop", &text);
        let model = model.unwrap_or_else(|problems| panic!("{}", problems.render(false)));
        let mut graph = model.graph.clone();
        Switching::compile(&mut graph, &model).idle
    }

    #[test]
    fn jumps_that_change_nothing_and_bar_the_way() {
        let both = "x >= 1 and v > 0";
        let at = |rests: bool| Some(vec![rests]);
        // Whether a jump is idle, whether it bars a side, and which of the other comparisons rest.
        let cases = [
            ("v", both, "{ v = \"0\" }", Some(at(true))),
            ("2*v/e", both, "{ v = \"-e*v\" }", Some(at(true))),
            ("v^3", both, "{ v = \"0\" }", Some(at(false))),
            (
                "v - 0.1",
                "x >= 1 and v > 0.1",
                "{ v = \"0.1\" }",
                Some(at(true)),
            ),
            // It does not rest, moves away, or is moved from outside.
            ("v + w", both, "{ v = \"0\" }", Some(at(false))),
            ("-v", both, "{ v = \"0\" }", Some(at(false))),
            ("v", "x >= u and v > 0", "{ v = \"0\" }", Some(at(false))),
            ("v", "x >= v and v > 0", "{ v = \"0\" }", Some(at(false))),
            // What another jump sets may be kept from moving.
            (
                "v",
                both,
                "{ v = \"0\" } }\ncap = { when = \"x > 1\", set = { w = \"0\", x = \"1\" }",
                Some(at(false)),
            ),
            // One of two conditions, or two levels.
            ("v", "x >= 1 or v > 0", "{ v = \"0\" }", Some(None)),
            // Something changes.
            ("v", both, "{ v = \"0.1\" }", None),
            ("v", both, "{ v = \"e*v + w\" }", None),
            ("v", both, "{ v = \"0\", w = \"1\" }", None),
            ("v", "x >= 1 and w > 0", "{ v = \"0\" }", None),
        ];
        for (rate, when, set, expected) in cases {
            let found = found(rate, when, set);
            let bars = found.first().map(|idle| {
                let bar = idle.bar.as_ref();
                bar.map(|bar| bar.others.iter().map(|other| other.rests).collect())
            });
            assert_eq!(bars, expected, "{rate}; {when}; {set}");
            assert!(found.len() < 2, "{rate}; {when}; {set}");
        }
    }

    #[test]
    fn a_side_is_barred_while_the_other_comparisons_hold() {
        let idle = found("v", "x >= 1 and v > 0", "{ v = \"0\" }");
        let [idle] = &idle[..] else {
            panic!("{idle:?}");
        };
        let other = idle.bar.as_ref().unwrap().others[0].surface;
        let barred = |place: Signs, level: Signs| {
            let mut signs = vec![Signs::ANY; 2];
            (signs[other], signs[idle.surface]) = (place, level);
            idle.barred(&signs)
        };
        let (down, zero, up) = (Signs::NEGATIVE, Signs::ZERO, Signs::POSITIVE);
        let past = Some(up);
        assert_eq!(barred(zero, zero), past);
        assert_eq!(barred(up.or(zero), zero), past);
        assert_eq!(barred(down.or(zero), zero), None);
        assert_eq!(barred(Signs::ANY, zero), None);
        assert_eq!(barred(up, up.or(zero)), None);
    }
}
