//! How long what is watched along a prepared step keeps its sign.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: blocks own `monomials * stride` numbers; probes and watches have the same order"
)]

use super::monomials::Monomials;
use super::outward::raised;
use super::piece::{Piece, Probe};
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
    pub(super) fn during(
        &self,
        scratch: &Scratch,
        monomials: &Monomials,
        register: usize,
        window: Interval,
    ) -> Interval {
        let size = &scratch.errors.sizes[register];
        let quick = scratch.around(register);
        if !quick.contains(0.0) || size.top == 0 {
            return quick;
        }
        let stride = scratch.series.stride;
        let block = scratch.series.block(register);
        let row = |a: usize| {
            let orders = block[a * stride..=a * stride + size.top].iter().rev();
            orders.fold(Interval::ZERO, |sum, x| sum * window + Interval::point(*x))
        };
        let others: f64 = (1..monomials.len()).map(|a| row(a).mag()).sum();
        row(0)
            .inflate(raised(
                others + scratch.radii[1][register],
                monomials.len() + 1,
            ))
            .intersect(quick)
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
