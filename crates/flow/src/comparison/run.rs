//! Both corners, and whether the order holds between them.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one entry per state, quantity, stretch or piece, from the same lists"
)]

use super::Comparison;
use super::order::{Order, Slopes, direction};
use crate::form::{Effort, Enclosure, Flow, FormOptions, Obstacle, Spent, Standing, Stretch};
use veribound_interval::Interval;
use veribound_model::Var;

/// The whole time is looked at in so many pieces at least, and in so many times more where the order does not hold.
const PIECES: f64 = 64.0;
const FINER: f64 = 4.0;

/// Why there is no order.
///
/// Example: [`Comparison`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cause {
    /// The rate of a state depends on another quantity with slopes that have no sign, or not the one that
    /// the others ask for.
    Slope {
        /// The state.
        of: usize,
        /// What its rate depends on.
        by: Var,
        /// The slopes met.
        value: Interval,
    },
    /// The rate of a state switches, not only where the state passes a level of its own, or rises there.
    Switch {
        /// The state.
        state: usize,
    },
    /// The rate of a state, or a slope of it, may be undefined or infinite, or may jump.
    Undefined {
        /// The state.
        state: usize,
    },
    /// The state may jump.
    Jump,
    /// The set, or an input, may leave the domain in which the guards are proved to leave no gap.
    LeavesDomain,
}

/// Why a quantity is in no order, and since when: seconds since the start.
///
/// Example: [`Comparison`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disorder {
    /// Why.
    pub cause: Cause,
    /// From then on, at the latest.
    pub since: f64,
}

/// What comparison bounds proved.
///
/// Example: [`Comparison`].
#[derive(Debug, Clone, PartialEq)]
pub struct Compared {
    /// The bounds: those of both corners together.
    pub enclosure: Enclosure,
    /// Uncertain quantities that the corners stand for to the end.
    pub corners: Vec<Var>,
    /// Uncertain parameters and inputs, and states, that have no place in the order, or only for a while; forms keep their
    /// intervals. Where there is none, the bounds are the exact hull, up to the accuracy of two single solutions.
    pub kept: Vec<Var>,
    /// What stood in the way of an order of all quantities.
    pub disorders: Vec<Disorder>,
}

/// An order that holds on the start box, at the start.
///
/// Example: [`Comparison`].
#[derive(Debug, Clone, PartialEq)]
pub struct Outlook {
    /// Uncertain quantities in the order.
    pub corners: Vec<Var>,
    /// Uncertain quantities that have no place in it.
    pub kept: Vec<Var>,
    /// What stood in the way of an order of all quantities.
    pub disorders: Vec<Disorder>,
}

/// The stretches cut into pieces.
pub(super) struct Pieces {
    pub(super) list: Vec<Stretch>,
    /// Number of pieces of every stretch.
    pub(super) counts: Vec<usize>,
}

impl Pieces {
    fn cut(stretches: &[Stretch], finer: f64) -> Pieces {
        let whole: f64 = stretches.iter().map(|stretch| stretch.dt.hi()).sum();
        let (mut list, mut counts) = (Vec::new(), Vec::new());
        for stretch in stretches {
            let share = PIECES * finer * stretch.dt.hi() / whole;
            let count = if share > 1.0 { share.ceil() } else { 1.0 };
            let dt = stretch.dt / Interval::point(count);
            counts.push(count as usize);
            for _ in 0..count as usize {
                list.push(Stretch {
                    inputs: stretch.inputs.clone(),
                    dt,
                });
            }
        }
        Pieces { list, counts }
    }
}

/// What is asked.
pub(super) struct Question<'a> {
    pub(super) flow: &'a Flow,
    pub(super) states: &'a [Interval],
    pub(super) params: &'a [Interval],
    options: FormOptions,
    effort: Effort,
    /// What sets with unknowns may cost, and have cost.
    most: f64,
    spent: Spent,
    go_on: &'a (dyn Fn(Standing) -> bool + Sync),
}

impl Question<'_> {
    pub(super) fn enclose(
        &self,
        states: &[Interval],
        params: &[Interval],
        pieces: &[Stretch],
    ) -> Enclosure {
        let set = (states, params);
        let go_on = |standing: Standing| {
            if standing.unknowns > 0 {
                self.spent.add(standing.cost);
            }
            self.spent.all() <= self.most && (self.go_on)(standing)
        };
        let mut enclosure =
            self.flow
                .enclose_watched(set, pieces, self.options, self.effort, &go_on);
        if let Some(stopped) = &mut enclosure.stopped
            && stopped.obstacle == Obstacle::Interrupted
            && self.spent.all() > self.most
        {
            stopped.obstacle = Obstacle::Costly;
        }
        enclosure
    }

    /// Whether both corners can be taken through so many pieces.
    fn affords(&self, order: &Order, pieces: usize) -> bool {
        let states = order.corner(0, self.states, 1);
        let params = order.corner(self.states.len(), self.params, 1);
        let form = self.flow.start(&states, &params, self.options);
        form.unknowns().is_empty()
            || self.spent.all() + 2.0 * pieces as f64 * form.cost() <= self.most
    }
}

/// What is known of the order so far.
pub(super) struct Known {
    pub(super) slopes: Slopes,
    /// States that no order is asked of.
    pub(super) kept: Vec<bool>,
    /// Why, where it is not for slopes.
    pub(super) disorders: Vec<Disorder>,
    /// Quantities that are uncertain, for any time.
    wide: Vec<bool>,
}

impl Known {
    /// Keeps the state that a disorder is about, which is no slope; false where there is none, or it is kept.
    fn keep(&mut self, disorder: Disorder) -> bool {
        self.disorders.push(disorder);
        match disorder.cause {
            Cause::Switch { state } | Cause::Undefined { state } => {
                !std::mem::replace(&mut self.kept[state], true)
            }
            _ => false,
        }
    }
}

impl Comparison {
    /// Encloses all solutions that start in `states` with parameters in `params`, over all stretches, between
    /// two corners; `flow` is the same model, and `go_on` is asked at every step whether to go on. Sets with unknowns may
    /// cost `most` ([`Standing::cost`]).
    ///
    /// Guarantee: that of [`Enclosure`]. It ends where the order ends: then [`Enclosure::stopped`] is
    /// [`NotMonotone`](crate::form::Obstacle::NotMonotone), and the last of the disorders tells why.
    ///
    /// Errors: where no uncertain quantity has a place in an order, or bounds would cost too much, what stands in the way.
    pub fn enclose(
        &self,
        flow: &Flow,
        (states, params): (&[Interval], &[Interval]),
        stretches: &[Stretch],
        (options, effort, most): (FormOptions, Effort, f64),
        go_on: &(dyn Fn(Standing) -> bool + Sync),
    ) -> Result<Compared, Vec<Disorder>> {
        let question = Question {
            flow,
            states,
            params,
            options,
            effort,
            most,
            spent: Spent::default(),
            go_on,
        };
        let mut known = Known {
            slopes: Slopes::new(self.layout.states, self.layout.len()),
            kept: vec![false; self.layout.states],
            disorders: Vec::new(),
            wide: self.wide((states, params), stretches),
        };
        let mut pieces = Pieces::cut(stretches, 1.0);
        let mut is_fine = false;
        self.along_middle(&question, &pieces, &mut known);
        let mut found: Option<Enclosure> = None;
        // Every round but one keeps a quantity more.
        loop {
            let order = self.order(&mut known);
            let corners = order.as_ref().map_or(Vec::new(), |order| {
                let of = |q: &usize| order.sign[*q] != 0 && known.wide[*q];
                (0..known.wide.len()).filter(of).collect::<Vec<_>>()
            });
            let worth = |order: &Order| question.affords(order, pieces.list.len());
            let order = order.filter(|order| !corners.is_empty() && worth(order));
            let Some(order) = order else {
                let disorders = self.disorders(&known, None);
                return match found {
                    Some(enclosure) => Ok(self.compared(enclosure, None, &known, disorders)),
                    None => Err(disorders),
                };
            };
            // The corners begin with the start box between them.
            let first = pieces.list.first().and_then(|piece| {
                self.fails((states, params, &piece.inputs), &order, (&mut known, 0.0))
            });
            let broken = match first {
                Some(cause) => Some(Disorder { cause, since: 0.0 }),
                None => {
                    let bounds = self.corners(&question, &pieces, &order);
                    let (held, broken) =
                        self.holds(&question, (&pieces, &bounds), &order, &mut known);
                    if let (Some(_), false) = (&broken, is_fine) {
                        is_fine = true;
                        pieces = Pieces::cut(stretches, FINER);
                        continue;
                    }
                    let here = self.collapse(&question, (&pieces, &bounds), held, broken.as_ref());
                    found = Some(match found {
                        Some(before) => before.both(here),
                        None => here,
                    });
                    broken
                }
            };
            let goes_on = match broken {
                None => false,
                Some(disorder) => match disorder.cause {
                    Cause::Slope { .. } => true,
                    _ => known.keep(disorder),
                },
            };
            if !goes_on {
                let disorders = self.disorders(&known, Some(&order));
                return match found {
                    Some(found) => Ok(self.compared(found, Some(&order), &known, disorders)),
                    None => Err(disorders),
                };
            }
        }
    }

    /// The order with which a run begins, and what has no place in it.
    pub fn outlook(
        &self,
        states: &[Interval],
        params: &[Interval],
        stretches: &[Stretch],
    ) -> Outlook {
        let mut known = Known {
            slopes: Slopes::new(self.layout.states, self.layout.len()),
            kept: vec![false; self.layout.states],
            disorders: Vec::new(),
            wide: self.wide((states, params), stretches),
        };
        loop {
            let mut order = self.order(&mut known);
            let broken = order.as_ref().zip(stretches.first());
            let broken = broken.and_then(|(order, first)| {
                self.fails((states, params, &first.inputs), order, (&mut known, 0.0))
            });
            if let Some(cause) = broken {
                let keeps = match cause {
                    Cause::Slope { .. } => true,
                    _ => known.keep(Disorder { cause, since: 0.0 }),
                };
                if keeps {
                    continue;
                }
                order = None;
            }
            let disorders = self.disorders(&known, order.as_ref());
            let (corners, kept) = self.places(order.as_ref(), &known);
            return Outlook {
                corners,
                kept,
                disorders,
            };
        }
    }

    /// Quantities that are uncertain, for any time.
    fn wide(
        &self,
        (states, params): (&[Interval], &[Interval]),
        stretches: &[Stretch],
    ) -> Vec<bool> {
        let start = states.iter().chain(params);
        let mut wide: Vec<bool> = start.map(|x| !x.is_point()).collect();
        let inputs = 0..self.layout.inputs;
        wide.extend(inputs.map(|input| stretches.iter().any(|s| !s.inputs[input].is_point())));
        wide
    }

    /// An order that all known slopes fit to; what cannot be ordered is kept.
    fn order(&self, known: &mut Known) -> Option<Order> {
        loop {
            self.influences.close(&mut known.kept);
            if known.kept.iter().all(|kept| *kept) {
                return None;
            }
            let (slopes, kept) = (&known.slopes, &known.kept);
            match Order::choose(slopes, kept, &known.wide, &self.influences) {
                Ok(order) => return Some(order),
                Err(conflict) => {
                    known.kept[conflict.by] = true;
                    known
                        .disorders
                        .push(self.slope_disorder(known, (conflict.of, conflict.by)));
                }
            }
        }
    }

    fn slope_disorder(&self, known: &Known, (of, q): (usize, usize)) -> Disorder {
        let since = known.slopes.since[of][q];
        Disorder {
            cause: Cause::Slope {
                of,
                by: self.layout.var(q),
                value: known.slopes.of[of][q],
            },
            since: if since.is_finite() { since } else { 0.0 },
        }
    }

    /// What stood in the way of an order of all uncertain quantities.
    fn disorders(&self, known: &Known, order: Option<&Order>) -> Vec<Disorder> {
        let mut list = known.disorders.clone();
        let Some(order) = order else {
            return list;
        };
        let states = self.layout.states;
        let kept = |q: &usize| known.wide[*q] && order.sign[*q] == 0;
        for q in (states..known.wide.len()).filter(kept) {
            let of = |i: &usize| !known.kept[*i] && direction(known.slopes.of[*i][q]) != Ok(None);
            let without = |i: &usize| direction(known.slopes.of[*i][q]).is_err();
            let state = (0..states).filter(of).find(without);
            let state = state.or_else(|| (0..states).find(of));
            list.extend(state.map(|of| self.slope_disorder(known, (of, q))));
        }
        list
    }

    fn compared(
        &self,
        enclosure: Enclosure,
        order: Option<&Order>,
        known: &Known,
        disorders: Vec<Disorder>,
    ) -> Compared {
        let (corners, kept) = self.places(order, known);
        Compared {
            enclosure,
            corners,
            kept,
            disorders,
        }
    }

    /// Uncertain quantities in the order, and the others.
    fn places(&self, order: Option<&Order>, known: &Known) -> (Vec<Var>, Vec<Var>) {
        let ordered = |q: &usize| order.is_some_and(|order| order.sign[*q] != 0);
        let uncertain = (0..known.wide.len()).filter(|q| known.wide[*q]);
        let (corners, kept): (Vec<usize>, Vec<usize>) = uncertain.partition(ordered);
        let names = |list: Vec<usize>| list.into_iter().map(|q| self.layout.var(q)).collect();
        (names(corners), names(kept))
    }
}
