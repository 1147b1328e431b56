//! Elementary functions on lanes.
//!
//! The scalar functions give the neighbours of the float nearest to a value, cut by known bounds.
//! So lanes need the nearest float, too: a sum of two floats is computed whose error is proved to
//! be small, and where all numbers within this error round to the same float, this is it. Elsewhere
//! (about once in a thousand values), and for arguments out of the usual range, the scalar
//! operation does the lane.

mod arctangent;
#[cfg(test)]
mod errors;
mod exponential;
mod hyperbolic;
mod logarithm;
mod tables;
mod wave;
mod wide;

pub(super) use exponential::open;
pub(super) use wide::Wide;

use super::Interval8;
use super::basic::chunks;
use crate::Interval;
use arctangent::arctangents;
use exponential::exponentials;
use hyperbolic::tanhs;
use logarithm::logarithms;
use wave::{cosines, sines, tangents};

#[inline(always)]
pub(super) fn exp<V: Wide>(a: &Interval8) -> Interval8 {
    chunks!(V, a, a, exponentials, |a: Interval, _| a.exp())
}

#[inline(always)]
pub(super) fn ln<V: Wide>(a: &Interval8) -> Interval8 {
    chunks!(V, a, a, logarithms, |a: Interval, _| a.ln())
}

#[inline(always)]
pub(super) fn sin<V: Wide>(a: &Interval8) -> Interval8 {
    chunks!(V, a, a, sines, |a: Interval, _| a.sin())
}

#[inline(always)]
pub(super) fn cos<V: Wide>(a: &Interval8) -> Interval8 {
    chunks!(V, a, a, cosines, |a: Interval, _| a.cos())
}

#[inline(always)]
pub(super) fn tan<V: Wide>(a: &Interval8) -> Interval8 {
    chunks!(V, a, a, tangents, |a: Interval, _| a.tan())
}

#[inline(always)]
pub(super) fn atan<V: Wide>(a: &Interval8) -> Interval8 {
    chunks!(V, a, a, arctangents, |a: Interval, _| a.atan())
}

#[inline(always)]
pub(super) fn tanh<V: Wide>(a: &Interval8) -> Interval8 {
    chunks!(V, a, a, tanhs, |a: Interval, _| a.tanh())
}
