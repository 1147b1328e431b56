//! Moving faces: each bound of the box advances with the right-hand side on its own face.
//!
//! # What is proved
//!
//! Let `B` be the a-priori box (every solution stays in it for the whole step). For each state `i`
//! and each side a function `V(t)` is built, starting at or outside the bound of the start box,
//! such that no solution passes it. Written for the upper bound:
//!
//! > (*) for almost every `t` and every `x` in `B` whose other states lie between their own bounds
//! > and whose `x_i` is just beyond `V(t)`: every velocity of state `i` in the Filippov hull at `x`
//! > is at most `V'(t) + L (x_i - V(t))`.
//!
//! Let `e(t)` be the largest distance by which a solution lies beyond any of the bounds. By (*) and
//! because the right-hand sides used with *moving* bounds of other states are Lipschitz in those
//! states, `e' <= L e` almost everywhere, and `e(0) = 0`; hence `e = 0`. (Müller's theorem, in the
//! form for differential inclusions; jumps of `V` outward do no harm, inward ones never happen.)
//!
//! The levels at which guards compare state `i` with a constant cut its axis into open regions and
//! thin zones. The rule is one-sided: only the modes possible *beyond* the bound count.
//!
//! * **Region.** `V` moves with a bound of the velocity over `x_i` between `V` and the end of `B`,
//!   inside the region, the other states anywhere in `B`: either as the solution of the
//!   comparison equation (a Taylor series, the lanes in `series` of a [`Bound`]) or with one constant rate.
//! * **Reaching a level from inside** (outward): `V` is put on the far side of the zone no later
//!   than the straight line reaches it. This is a jump outward.
//! * **Reaching a level from outside** (inward): `V` is put on the near edge of the zone no earlier
//!   than the line reaches it.
//! * **At a zone.** Solutions beyond it have the velocities of the region outside. If those push
//!   back, nothing passes: `V` may rest at the outer edge. It may move in only when every velocity
//!   possible *in* the zone points inward too; then it crosses the zone with the slowest of them
//!   and goes on in the region behind, which solutions cannot leave outward through the zone.
//!
//! A standing rig is the case in point: at velocity 0 the region above has the forward mode alone,
//! which brakes while `u <= T`, the region below has the backward mode alone, so both bounds rest
//! at exactly zero; the plain hull of the three modes would let them drift apart.
//!
//! Parameters are constants, so a right-hand side that is monotone in one is largest at its end;
//! one that is not keeps the whole interval, which is sound for every fixed value. Inputs and
//! states may change in time; where the monotonicity is unknown, the mean value theorem turns them
//! into a constant slack.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: states, right-hand sides and quantities are positions in the system's lists"
)]

mod bound;
mod corner;
mod rough;
mod series;

use crate::advance::advance;
use crate::apriori::Apriori;
use crate::side::Side;
use crate::system::{Registers, System};
use bound::{Bound, Survey};
use veribound_interval::Interval;
use veribound_interval::lanes::{Interval8, Mask};

/// Scratch and result of [`System::move_faces`].
#[derive(Debug, Clone)]
pub(crate) struct Faces {
    bounds: Vec<[Bound; 2]>,
    face: Vec<Interval8>,
    clipped: Vec<Interval8>,
    /// `1 / (k + 1)`
    reciprocals: Vec<Interval>,
    survey: Survey,
    order: usize,
}

impl Faces {
    pub(crate) fn new(system: &System, order: usize) -> Faces {
        let pair = |rhs: &Vec<_>| [(); 2].map(|()| Bound::new(rhs, order));
        Faces {
            bounds: system.right_hand_sides.iter().map(pair).collect(),
            face: vec![Interval8::ZERO; system.layout.len()],
            clipped: Vec::new(),
            reciprocals: (0..order + 2)
                .map(|k| Interval::point((k + 1) as f64).recip())
                .collect(),
            survey: Survey::default(),
            order,
        }
    }
}

/// Both bounds of one state, the step's data, and scratch.
struct Face<'a> {
    system: &'a System,
    /// States (start boxes), parameters and inputs.
    q: &'a [Interval8],
    dt: Interval,
    apriori: &'a Apriori,
    state: usize,
    /// The boxes on the face; scratch.
    face: &'a mut Vec<Interval8>,
    /// The same, as far as modes or corners cut them down.
    clipped: &'a mut Vec<Interval8>,
    survey: &'a mut Survey,
    registers: &'a mut Registers,
}

/// The start boxes, parameters and inputs of a step, its length, what holds for all of it, and the
/// lanes that have a box.
pub(crate) struct Step<'a> {
    pub(crate) q: &'a [Interval8],
    pub(crate) dt: Interval,
    pub(crate) apriori: &'a Apriori,
    pub(crate) lanes: Mask,
}

impl System {
    /// Encloses the states at the end of the step into `end`, and at all its times into `tube`.
    ///
    /// Source: own; see the module's comment.
    pub(crate) fn move_faces(
        &self,
        step: &Step<'_>,
        faces: &mut Faces,
        registers: &mut Registers,
        end: &mut [Interval8],
        tube: &mut [Interval8],
    ) {
        for state in 0..self.layout.states {
            self.with_face(step, state, faces, registers, |face, bounds| {
                face.begin(bounds, step.lanes);
            });
        }
        self.move_series(step, faces, registers);
        let whole = Interval::ZERO.hull(step.dt);
        // The plain bounds with the hull of all velocities hold as well.
        let velocity = &step.apriori.velocity;
        advance(step.q, step.dt, velocity, end);
        advance(step.q, whole, velocity, tube);
        for (state, [lower, upper]) in faces.bounds.iter().enumerate() {
            let moved = Interval8::between(lower.end, upper.end);
            end[state] = end[state].intersect(&moved);
            let swept = Interval8::between(lower.range.lo(), upper.range.hi());
            tube[state] = tube[state].intersect(&swept);
        }
    }

    fn with_face(
        &self,
        step: &Step<'_>,
        state: usize,
        faces: &mut Faces,
        registers: &mut Registers,
        action: impl FnOnce(&mut Face<'_>, &mut [Bound; 2]),
    ) {
        let Faces {
            bounds,
            face,
            clipped,
            survey,
            ..
        } = faces;
        let mut face = Face {
            system: self,
            q: step.q,
            dt: step.dt,
            apriori: step.apriori,
            state,
            face,
            clipped,
            survey,
            registers,
        };
        action(&mut face, &mut bounds[state]);
    }

    /// The bound as [`Face::finish_roughly`] gives it.
    fn give_up_series(
        &self,
        step: &Step<'_>,
        (state, side): (usize, Side),
        lanes: Mask,
        faces: &mut Faces,
        registers: &mut Registers,
    ) {
        if !lanes.none() {
            self.with_face(step, state, faces, registers, |face, bounds| {
                face.finish_roughly(side, &mut bounds[side.index()], lanes);
            });
        }
    }
}
