//! Both corners from piece to piece.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one entry per state, quantity, stretch or piece, from the same lists"
)]

use super::Comparison;
use super::levels::Place;
use super::order::{Order, Slopes};
use super::run::{Cause, Disorder, Known, Pieces, Question};
use crate::form::{Diverged, Enclosure, Obstacle, Part, Stretch};
use veribound_interval::Interval;

/// Boxes between both corners, after every piece and during it.
pub(super) struct Bounds {
    ends: Vec<Vec<Interval>>,
    tubes: Vec<Vec<Interval>>,
    steps: u64,
    stopped: Option<Diverged>,
}

impl Comparison {
    /// Slopes along one solution in the middle: a hint.
    pub(super) fn along_middle(&self, question: &Question<'_>, pieces: &Pieces, known: &mut Known) {
        let middle = |list: &[Interval]| -> Vec<Interval> {
            list.iter().map(|x| Interval::point(x.mid())).collect()
        };
        let inputs = pieces.list.iter().map(|piece| Stretch {
            inputs: middle(&piece.inputs),
            ..piece.clone()
        });
        let inputs: Vec<Stretch> = inputs.collect();
        let (states, params) = (middle(question.states), middle(question.params));
        let solution = question.enclose(&states, &params, &inputs);
        let all = Order {
            sign: vec![1; self.layout.len()],
        };
        let mut time = 0.0;
        for (tube, piece) in solution.tubes.iter().zip(&pieces.list) {
            let place = Place::new(tube, question.params, &piece.inputs);
            match self.slopes(&place, &all) {
                Ok(slopes) => {
                    // One that loses its sign later may have its place until then.
                    for (entry, slope) in slopes.iter() {
                        known.slopes.add_if_signed(entry, slope);
                    }
                }
                // What is so on a part is so on the box between corners.
                Err(cause @ Cause::Undefined { state }) if !known.kept[state] => {
                    known.kept[state] = true;
                    known.disorders.push(Disorder { cause, since: time });
                }
                Err(_) => {}
            }
            time += piece.dt.lo();
        }
    }

    /// Both corners from piece to piece.
    pub(super) fn corners(
        &self,
        question: &Question<'_>,
        pieces: &Pieces,
        order: &Order,
    ) -> Bounds {
        let layout = self.layout;
        let corner = |which: i8| {
            let states = order.corner(0, question.states, which);
            let params = order.corner(layout.states, question.params, which);
            let inputs = |piece: &Stretch| Stretch {
                inputs: order.corner(layout.states + layout.params, &piece.inputs, which),
                dt: piece.dt,
            };
            let inputs: Vec<Stretch> = pieces.list.iter().map(inputs).collect();
            question.enclose(&states, &params, &inputs)
        };
        let (lower, upper) = (corner(-1), corner(1));
        let between = |lower: Vec<Vec<Interval>>, upper: Vec<Vec<Interval>>| {
            let both = lower.into_iter().zip(upper);
            both.map(|(lower, upper)| between(&lower, &upper, order))
                .collect()
        };
        let first = |a: Option<Diverged>, b: Option<Diverged>| match (a, b) {
            (Some(a), Some(b)) if b.reached.lo() < a.reached.lo() => Some(b),
            (a, b) => a.or(b),
        };
        Bounds {
            ends: between(lower.ends, upper.ends),
            tubes: between(lower.tubes, upper.tubes),
            steps: lower.steps + upper.steps,
            stopped: first(lower.stopped, upper.stopped),
        }
    }

    /// The number of pieces during which the order holds, and why not longer; slopes that do not fit become
    /// known.
    pub(super) fn holds(
        &self,
        question: &Question<'_>,
        (pieces, bounds): (&Pieces, &Bounds),
        order: &Order,
        known: &mut Known,
    ) -> (usize, Option<Disorder>) {
        let mut since = 0.0;
        for (held, (tube, piece)) in bounds.tubes.iter().zip(&pieces.list).enumerate() {
            if let Some(cause) = self.fails(
                (tube, question.params, &piece.inputs),
                order,
                (known, since),
            ) {
                return (held, Some(Disorder { cause, since }));
            }
            since += piece.dt.lo();
        }
        (bounds.tubes.len(), None)
    }

    /// Why the order does not hold on a box of states; slopes that do not fit become known.
    pub(super) fn fails(
        &self,
        (states, params, inputs): (&[Interval], &[Interval], &[Interval]),
        order: &Order,
        (known, time): (&mut Known, f64),
    ) -> Option<Cause> {
        if !self.is_in_domain(states, inputs) {
            return Some(Cause::LeavesDomain);
        }
        let place = Place::new(states, params, inputs);
        let slopes = self.slopes(&place, order);
        slopes.map_or_else(Some, |slopes| self.misfit(&slopes, order, known, time))
    }

    /// A slope that does not fit to the order; all of them become known.
    fn misfit(
        &self,
        slopes: &Slopes,
        order: &Order,
        known: &mut Known,
        time: f64,
    ) -> Option<Cause> {
        let mut first = None;
        for (entry, value) in slopes.iter() {
            if !order.fits(entry, value) {
                known.slopes.add(entry, value, time);
                let (of, q) = entry;
                let by = self.layout.var(q);
                first = first.or(Some(Cause::Slope { of, by, value }));
            }
        }
        first
    }

    /// What the first pieces prove, stretch by stretch.
    pub(super) fn collapse(
        &self,
        question: &Question<'_>,
        (pieces, bounds): (&Pieces, &Bounds),
        held: usize,
        broken: Option<&Disorder>,
    ) -> Enclosure {
        let mut result = Enclosure {
            shares: vec![Vec::new(); self.layout.states],
            steps: bounds.steps,
            ..Enclosure::default()
        };
        let outputs = |states: &[Interval], inputs: &[Interval]| {
            let quantities = [states, question.params, inputs].concat();
            question.flow.outputs_on(&quantities)
        };
        let mut next = 0;
        for count in &pieces.counts {
            let own = next..next + count;
            let inputs = &pieces.list[own.start].inputs;
            let begin = result.ends.last().map_or(question.states, |end| &end[..]);
            result.outputs.push(outputs(begin, inputs));
            next = own.end;
            if next > held {
                break;
            }
            result.ends.push(bounds.ends[next - 1].clone());
            let mut whole = bounds.tubes[own.start].clone();
            for tube in &bounds.tubes[own] {
                for (whole, x) in whole.iter_mut().zip(tube) {
                    *whole = whole.hull(*x);
                }
            }
            result.output_tubes.push(outputs(&whole, inputs));
            result
                .modes
                .push(self.modes(&[&whole, question.params, inputs].concat()));
            result.tubes.push(whole);
        }
        result.parts.push(Part {
            states: question.states.to_vec(),
            params: question.params.to_vec(),
            passed: result.ends.len(),
            end: result.ends.last().cloned().unwrap_or_default(),
        });
        let stopped = broken.map(|disorder| Diverged {
            obstacle: Obstacle::NotMonotone,
            state: match disorder.cause {
                Cause::Slope { of: state, .. }
                | Cause::Switch { state }
                | Cause::Undefined { state } => state,
                Cause::Jump | Cause::LeavesDomain => 0,
            },
            reached: Interval::point(disorder.since),
        });
        result.stopped = stopped.or_else(|| bounds.stopped.clone());
        result
    }

    fn is_in_domain(&self, states: &[Interval], inputs: &[Interval]) -> bool {
        let within = |list: &[Interval], allowed: &[Interval]| {
            let mut both = list.iter().zip(allowed);
            both.all(|(x, allowed)| x.is_subset_of(*allowed))
        };
        let domain = self.domain.as_ref();
        domain.is_none_or(|(s, u)| within(states, s) && within(inputs, u))
    }
}

/// What lies between both corners; of what is kept, what lies in both.
fn between(lower: &[Interval], upper: &[Interval], order: &Order) -> Vec<Interval> {
    let both = lower.iter().zip(upper).zip(&order.sign);
    both.map(|((a, b), sign)| match sign {
        0 if a.intersects(*b) => a.intersect(*b),
        _ => a.hull(*b),
    })
    .collect()
}
