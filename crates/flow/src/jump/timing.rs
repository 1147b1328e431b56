//! When a condition can hold first along a flow, and from when on it must.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: comparisons are numbered as they are compiled"
)]

use crate::side::{earliest, latest};
use veribound_interval::Interval;
use veribound_interval::lanes::Interval8;
use veribound_model::{ExprId, Graph, Guard, Layout, Relation, Tape, Var};

/// A comparison of a condition.
#[derive(Debug, Clone)]
pub(super) struct Atom {
    expr: ExprId,
    value: Tape,
    /// Derivatives with respect to `states`.
    slopes: Tape,
    states: Vec<usize>,
    /// It compares an input, which may change at any time within its bound.
    of_inputs: bool,
}

/// A condition, for its times.
#[derive(Debug, Clone)]
pub(super) enum Timing {
    /// Some comparison is below zero (`true`) or above.
    Atom(usize, bool),
    All(Vec<Timing>),
    Any(Vec<Timing>),
}

/// When something can be true first and last, and from when on it is for certain, in seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Times {
    pub(super) earliest: f64,
    pub(super) last: f64,
    pub(super) certain: f64,
}

/// What is known of a comparison along a flow.
#[derive(Debug, Clone, Copy)]
pub(super) struct Course {
    /// At the start.
    pub(super) start: Interval,
    /// At all times.
    pub(super) always: Interval,
    /// Its derivative in time.
    pub(super) rate: Interval,
}

impl Times {
    /// Of one or the other.
    pub(super) fn or(self, other: Times) -> Times {
        Times {
            earliest: self.earliest.min(other.earliest),
            last: self.last.max(other.last),
            certain: self.certain.min(other.certain),
        }
    }
}

impl Atom {
    pub(super) fn registers(&self) -> [Vec<Interval8>; 2] {
        [self.value.registers(), self.slopes.registers()]
    }

    /// The difference of both sides, where it is defined and no input is in it.
    pub(super) fn at(
        &self,
        q: &[Interval8],
        registers: &mut [Vec<Interval8>; 2],
    ) -> Option<Interval> {
        let [values, _] = registers;
        let regular = self.value.eval(q, values);
        let continuous = regular.is_defined().get(0) && regular.is_continuous().get(0);
        (continuous && !self.of_inputs).then(|| self.value.output(0, values).get(0))
    }

    /// The size of the states it compares.
    pub(super) fn magnitude(&self, x: &[Interval]) -> f64 {
        let sizes = self.states.iter().map(|state| x[*state].mag());
        sizes.fold(f64::MIN_POSITIVE, f64::max)
    }

    /// The only state it compares, if it grows with it everywhere on a box (`true`), or falls.
    pub(super) fn alone(
        &self,
        q: &[Interval8],
        registers: &mut [Vec<Interval8>; 2],
    ) -> Option<(usize, bool)> {
        let [state] = self.states[..] else {
            return None;
        };
        let [_, slopes] = registers;
        let regular = self.slopes.eval(q, slopes);
        let slope: Interval = self.slopes.output(0, slopes).get(0);
        let is_known = regular.is_defined().get(0) && !slope.is_empty() && !slope.contains(0.0);
        is_known.then_some((state, slope.lo() > 0.0))
    }

    /// Cuts a box down to what can have a difference in `target`; false when nothing can.
    pub(super) fn narrow(
        &self,
        q: &mut [Interval8],
        target: Interval,
        registers: &mut [Vec<Interval8>; 2],
    ) -> bool {
        let [values, _] = registers;
        self.value.contract(q, target, values).get(0)
    }

    /// The comparison along flows from `start`, with `tube` and `velocity` at all times; all hold
    /// states, parameters and inputs.
    pub(super) fn course(
        &self,
        start: &[Interval8],
        tube: &[Interval8],
        velocity: &[Interval],
        registers: &mut [Vec<Interval8>; 2],
    ) -> Course {
        let [values, slopes] = registers;
        let mut value = |q: &[Interval8]| {
            let regular = self.value.eval(q, values);
            if regular.is_defined().get(0) {
                self.value.output(0, values).get(0)
            } else {
                Interval::ENTIRE
            }
        };
        let (start, always) = (value(start), value(tube));
        let regular = self.value.eval(tube, values);
        let rate = if self.of_inputs || !regular.is_continuous().get(0) {
            Interval::ENTIRE
        } else {
            self.slopes.eval(tube, slopes);
            let terms = self.states.iter().enumerate().map(|(i, state)| {
                let slope: Interval = self.slopes.output(i, slopes).get(0);
                if slope.is_empty() {
                    Interval::ENTIRE
                } else {
                    slope * velocity[*state]
                }
            });
            terms.fold(Interval::ZERO, |sum, term| sum + term)
        };
        Course {
            start,
            always,
            rate,
        }
    }
}

impl Timing {
    /// The times of `guard`, its comparisons added to `atoms`.
    pub(super) fn compile(
        guard: &Guard,
        graph: &mut Graph,
        layout: Layout,
        atoms: &mut Vec<Atom>,
    ) -> Timing {
        match guard {
            Guard::Always => Timing::All(Vec::new()),
            Guard::All(parts) | Guard::Any(parts) => {
                let parts = parts.iter();
                let parts = parts.map(|part| Timing::compile(part, graph, layout, atoms));
                match guard {
                    Guard::All(_) => Timing::All(parts.collect()),
                    _ => Timing::Any(parts.collect()),
                }
            }
            Guard::Atom { expr, relation } => {
                let known = atoms.iter().position(|atom| atom.expr == *expr);
                let position = known.unwrap_or_else(|| {
                    atoms.push(Atom::compile(*expr, graph, layout));
                    atoms.len() - 1
                });
                let below = matches!(relation, Relation::Less | Relation::LessEqual);
                Timing::Atom(position, below)
            }
        }
    }

    /// All comparisons, each with its side.
    pub(super) fn atoms(&self) -> Vec<(usize, bool)> {
        match self {
            Timing::Atom(position, below) => vec![(*position, *below)],
            Timing::All(parts) | Timing::Any(parts) => {
                parts.iter().flat_map(Timing::atoms).collect()
            }
        }
    }

    /// The times along flows on which the comparisons take these courses.
    pub(super) fn times(&self, courses: &[Course]) -> Times {
        match self {
            Timing::Atom(position, below) => {
                let course = courses[*position];
                if *below {
                    times(course)
                } else {
                    times(Course {
                        start: -course.start,
                        always: -course.always,
                        rate: -course.rate,
                    })
                }
            }
            Timing::All(parts) => {
                let both = |a: Times, b: Times| Times {
                    earliest: a.earliest.max(b.earliest),
                    last: a.last.min(b.last),
                    certain: a.certain.max(b.certain),
                };
                let parts = parts.iter().map(|part| part.times(courses));
                let always = Times {
                    earliest: 0.0,
                    last: f64::INFINITY,
                    certain: 0.0,
                };
                parts.fold(always, both)
            }
            Timing::Any(parts) => {
                let parts = parts.iter().map(|part| part.times(courses));
                let never = Times {
                    earliest: f64::INFINITY,
                    last: 0.0,
                    certain: f64::INFINITY,
                };
                parts.fold(never, Times::or)
            }
        }
    }
}

impl Atom {
    fn compile(expr: ExprId, graph: &mut Graph, layout: Layout) -> Atom {
        let variables = graph.variables(expr);
        let states: Vec<usize> = (0..layout.states)
            .filter(|state| variables.contains(&Var::State(*state)))
            .collect();
        let slopes: Vec<ExprId> = states
            .iter()
            .map(|state| graph.derivative(expr, Var::State(*state)))
            .collect();
        Atom {
            expr,
            value: Tape::compile(graph, layout, &[expr]),
            slopes: Tape::compile(graph, layout, &slopes),
            states,
            of_inputs: variables.iter().any(|var| matches!(var, Var::Input(_))),
        }
    }
}

/// When `g <= 0` can hold first and last, and from when on `g < 0` holds at all times.
fn times(course: Course) -> Times {
    let Course {
        start,
        always,
        rate,
    } = course;
    let unknown = start.is_empty() || always.is_empty() || rate.is_empty();
    let earliest_time = if unknown || start.lo() <= 0.0 {
        0.0
    } else if always.lo() > 0.0 || rate.lo() >= 0.0 {
        f64::INFINITY
    } else {
        earliest(Interval::point(start.lo()), rate.lo())
    };
    let last = if unknown || start.lo() == f64::NEG_INFINITY {
        f64::INFINITY
    } else if always.lo() > 0.0 || (rate.lo() > 0.0 && start.lo() >= 0.0) {
        0.0
    } else if rate.lo() > 0.0 {
        latest(Interval::point(start.lo()), rate.lo())
    } else {
        f64::INFINITY
    };
    let certain = if unknown {
        f64::INFINITY
    } else if always.hi() < 0.0 {
        0.0
    } else if rate.hi() < 0.0 && start.hi().is_finite() {
        if start.hi() < 0.0 {
            0.0
        } else {
            latest(Interval::point(start.hi()), rate.hi())
        }
    } else {
        f64::INFINITY
    };
    Times {
        earliest: earliest_time,
        last,
        certain,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_falling_value_has_a_first_and_a_last_time() {
        let course = |start: (f64, f64), rate: (f64, f64)| Course {
            start: Interval::new(start.0, start.1).unwrap(),
            always: Interval::ENTIRE,
            rate: Interval::new(rate.0, rate.1).unwrap(),
        };
        let seen = |c: Course| (times(c).earliest, times(c).certain);
        assert_eq!(times(course((0.0, 2.0), (0.5, 1.0))).last, 0.0);
        assert_eq!(times(course((-1.0, 2.0), (0.5, 1.0))).last, 2.0);
        assert_eq!(times(course((-1.0, 2.0), (0.0, 1.0))).last, f64::INFINITY);
        assert_eq!(seen(course((1.0, 2.0), (-4.0, -2.0))), (0.25, 1.0));
        assert_eq!(seen(course((-1.0, 2.0), (-4.0, 1.0))), (0.0, f64::INFINITY));
        assert_eq!(
            seen(course((1.0, 2.0), (0.0, 1.0))),
            (f64::INFINITY, f64::INFINITY)
        );
        assert_eq!(seen(course((-2.0, -1.0), (-1.0, -0.5))), (0.0, 0.0));
        assert_eq!(
            seen(course((-2.0, -1.0), (-1.0, 0.5))),
            (0.0, f64::INFINITY)
        );
        let both = Timing::All(vec![Timing::Atom(0, true), Timing::Atom(1, false)]);
        let courses = [
            course((1.0, 2.0), (-4.0, -2.0)),
            course((-3.0, -2.0), (1.0, 2.0)),
        ];
        let wanted = Times {
            earliest: 1.0,
            last: f64::INFINITY,
            certain: 3.0,
        };
        assert_eq!(both.times(&courses), wanted);
    }
}
