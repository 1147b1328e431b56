//! How long what is watched along a prepared step keeps its sign.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: blocks own `monomials * stride` numbers; probes and watches have the same order"
)]

use super::monomials::Monomials;
use super::outward::raised;
use super::piece::{Piece, Probe};
use super::range::range;
use super::regime::Watch;
use super::step::Scratch;
use super::surfaces::Signs;
use veribound_interval::Interval;

/// Times are told apart up to this share of a step.
const FINEST: f64 = 1.0 / 64.0;

/// The end of the time during which everything watched keeps its sign.
#[derive(Debug, Clone, Copy)]
pub(super) struct Trouble {
    /// In scaled time.
    pub(super) from: f64,
    /// Position of the watch.
    pub(super) watch: usize,
}

impl Piece {
    /// The first time up to `span` at which something watched may change its sign.
    ///
    /// Guarantee: before it, for all solutions within the deviation of the prepared step, every watched
    /// expression has its sign or moves towards it; one that is not `steady`, a function of the state
    /// alone, has its sign.
    pub(super) fn trouble(
        &self,
        scratch: &Scratch,
        monomials: &Monomials,
        (watches, steady): (&[Watch], &[bool]),
        span: f64,
    ) -> Option<Trouble> {
        let mut first: Option<Trouble> = None;
        for (watch, asked) in watches.iter().enumerate() {
            let end = first.map_or(span, |trouble| trouble.from);
            let asked = (watch, asked.sign, steady[watch]);
            if let Some(from) = self.first_trouble((scratch, monomials), asked, end) {
                first = Some(Trouble { from, watch });
            }
        }
        first
    }

    /// As [`Piece::trouble`], for one watch, which has to keep a sign.
    pub(super) fn first_trouble(
        &self,
        (scratch, monomials): (&Scratch, &Monomials),
        (watch, sign, steady): (usize, Signs, bool),
        end: f64,
    ) -> Option<f64> {
        let probe = &self.probes[watch];
        let is_safe = |from: f64, to: f64| {
            let window = Interval::new(from, to).unwrap_or(Interval::ENTIRE);
            let keeps = |register: usize| {
                let x = self.during(scratch, monomials, register, window);
                Signs::strict(x) == Some(sign)
            };
            keeps(probe.value) || (steady && keeps(probe.rate))
        };
        let (mut from, mut length) = (0.0, end);
        while from < end {
            let to = if from + length >= end {
                end
            } else {
                from + length
            };
            if is_safe(from, to) {
                from = to;
                length *= 2.0;
            } else if length <= FINEST * end {
                return Some(from);
            } else {
                length *= 0.5;
            }
        }
        None
    }

    /// Encloses a register during a window of scaled time, for all solutions within the deviation.
    ///
    /// Proof. `R(δ, t)` is the polynomial. For any number `κ`, `q = (1 + κ (t - t_0)) R` has `q' = (R' + κ R) + κ (t - t_0) R'`. So
    /// where all coefficients decay alike, as what is left of a small rate does, `q` hardly moves from what it is at the begin `t_0`, and that
    /// is a polynomial in the unknowns alone, with a tight range.
    pub(super) fn during(
        &self,
        scratch: &Scratch,
        monomials: &Monomials,
        register: usize,
        window: Interval,
    ) -> Interval {
        let size = &scratch.errors.sizes[register];
        let quick = scratch.around(register);
        if !quick.contains(0.0) {
            return quick;
        }
        let stride = scratch.series.stride;
        let block = scratch.series.block(register);
        if size.top == 0 {
            let polynomial: Vec<f64> = block.iter().step_by(stride).copied().collect();
            let off = scratch.radii[1][register];
            return range(monomials, &polynomial).inflate(off).intersect(quick);
        }
        let row = |a: usize| {
            let orders = block[a * stride..=a * stride + size.top].iter().rev();
            orders.fold(Interval::ZERO, |sum, x| sum * window + Interval::point(*x))
        };
        let off = scratch.radii[1][register];
        let others: f64 = (1..monomials.len()).map(|a| row(a).mag()).sum();
        let first = row(0);
        let found = first
            .inflate(raised(others + off, monomials.len() + 1))
            .intersect(quick);
        if !found.contains(0.0) || first.contains(0.0) {
            return found;
        }
        let slope = |a: usize| {
            let orders = block[a * stride + 1..=a * stride + size.top].iter();
            let orders = orders.enumerate().rev();
            orders.fold(Interval::ZERO, |sum, (j, x)| {
                sum * window + Interval::point(*x) * Interval::point((j + 1) as f64)
            })
        };
        let (mut begin, mut rounding) = (Vec::with_capacity(monomials.len()), 0.0);
        for a in 0..monomials.len() {
            let orders = block[a * stride..=a * stride + size.top].iter().rev();
            let time = Interval::point(window.lo());
            let value = orders.fold(Interval::ZERO, |sum, x| sum * time + Interval::point(*x));
            begin.push(value.mid());
            rounding += value.rad();
        }
        let decay = Interval::point((-slope(0) / first).mid());
        let since = window - Interval::point(window.lo());
        let (mut change, mut moved) = (0.0, 0.0);
        for a in 0..monomials.len() {
            let slope = slope(a);
            change += (slope + decay * row(a)).mag();
            moved += slope.mag();
        }
        let moved = Interval::symmetric(raised(moved, monomials.len())) * decay * since;
        let change = moved.inflate(raised(change, monomials.len())) * since;
        let scale = Interval::ONE + decay * since;
        let begin = range(monomials, &begin).inflate(raised(rounding, monomials.len()));
        if scale.lo() > 0.0 {
            ((begin + change) / scale).inflate(off).intersect(found)
        } else {
            found
        }
    }

    /// The slopes of a watched expression, at all times of the step.
    pub(super) fn slopes_of(&self, scratch: &Scratch, probe: &Probe) -> Vec<Interval> {
        let mut slopes = vec![Interval::ZERO; self.states];
        for &(state, register) in &probe.gradient {
            slopes[state] = scratch.around(register);
        }
        slopes
    }
}
