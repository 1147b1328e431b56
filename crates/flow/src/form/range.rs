//! Tight bounds of a polynomial on the unit box.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: polynomials have one coefficient per monomial of the table"
)]

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::monomials::Monomials;
use super::outward::{UNIT, raised};
use veribound_interval::Interval;

/// Parts of the box looked at before the bound is taken as it is; and where that is far from the values that were met.
const MOST_PARTS: [usize; 2] = [40, 400];

/// How far, as share of the width.
const FAR: f64 = 0.02;

/// Share of the size of the polynomial that the bound may be too large.
const ENOUGH: f64 = 1e-4;

/// Encloses the values of `polynomial` on `[-1, 1]^d`.
///
/// Guarantee: every value lies inside. Branch and bound; where a derivative has one sign the variable is
/// put to its end, so that near-linear polynomials take one part.
pub(super) fn range(monomials: &Monomials, polynomial: &[f64]) -> Interval {
    if polynomial[1..].iter().all(|x| *x == 0.0) {
        return Interval::point(polynomial[0]);
    }
    let size: f64 = polynomial[1..].iter().map(|x| x.abs()).sum();
    let negated: Vec<f64> = polynomial.iter().map(|x| -x).collect();
    let mut above = Maximum::new(monomials, polynomial);
    let mut below = Maximum::new(monomials, &negated);
    let tolerance = ENOUGH * size;
    for maximum in [&mut above, &mut below] {
        maximum.refine(monomials, MOST_PARTS[0], tolerance);
    }
    // Where linear terms cancel, little of the size is left.
    let far = FAR * (above.bound() + below.bound());
    for maximum in [&mut above, &mut below] {
        if maximum.bound() > maximum.reached + far {
            maximum.refine(monomials, MOST_PARTS[1], tolerance.max(far));
        }
    }
    Interval::new(-below.bound(), above.bound()).unwrap_or(Interval::ENTIRE)
}

/// Whether `polynomial` is proved to be above `least` on `[-1, 1]^d`: as [`range`], but no more is done than that takes.
pub(super) fn is_above(monomials: &Monomials, polynomial: &[f64], least: f64) -> bool {
    let size: f64 = polynomial[1..].iter().map(|x| x.abs()).sum();
    let negated: Vec<f64> = polynomial.iter().map(|x| -x).collect();
    let mut below = Maximum::new(monomials, &negated);
    for _ in 0..MOST_PARTS[0] {
        let (bound, reached) = (below.bound(), below.reached);
        let is_undecided = bound >= -least && reached < -least;
        if !is_undecided || bound <= reached + ENOUGH * size || !below.divide(monomials) {
            break;
        }
    }
    below.bound() < -least
}

/// The value of a polynomial at the corner of the unit box at which its linear terms are least.
pub(super) fn at_corner(monomials: &Monomials, polynomial: &[f64]) -> f64 {
    let is_above = |v: usize| monomials.degree > 0 && polynomial[monomials.linear(v)] > 0.0;
    let corner: Vec<bool> = (0..monomials.variables).map(is_above).collect();
    let terms = polynomial.iter().enumerate().map(|(a, x)| {
        let odd = monomials.exponents(a).iter().zip(&corner);
        let below = odd.filter(|(e, is_below)| **is_below && !e.is_multiple_of(2));
        if below.count().is_multiple_of(2) {
            *x
        } else {
            -x
        }
    });
    terms.sum()
}

/// What is known of the maximum of a polynomial.
struct Maximum {
    /// Parts that cover the box.
    open: BinaryHeap<Part>,
    /// A value that is met, about.
    reached: f64,
}

impl Maximum {
    fn new(monomials: &Monomials, polynomial: &[f64]) -> Maximum {
        let whole = Part::new(monomials, polynomial.to_vec(), 0.0);
        Maximum {
            reached: whole.reached,
            open: BinaryHeap::from([whole]),
        }
    }

    /// An upper bound.
    fn bound(&self) -> f64 {
        self.open.peek().map_or(f64::INFINITY, |part| part.bound)
    }

    /// Divides so many parts, or until the bound is near to a value that is met.
    fn refine(&mut self, monomials: &Monomials, parts: usize, tolerance: f64) {
        for _ in 0..parts {
            if self.bound() <= self.reached + tolerance || !self.divide(monomials) {
                return;
            }
        }
    }

    /// Divides the part that says least; false if that brings nothing.
    fn divide(&mut self, monomials: &Monomials) -> bool {
        let Some(part) = self.open.pop() else {
            return false;
        };
        let Some(variable) = part.worst(monomials) else {
            self.open.push(part);
            return false;
        };
        for side in [-0.5, 0.5] {
            let (half, error) = part.half(monomials, variable, side);
            let half = Part::new(monomials, half, error);
            self.reached = self.reached.max(half.reached);
            self.open.push(half);
        }
        true
    }
}

/// The polynomial on a part of the box, as a polynomial on the unit box.
struct Part {
    polynomial: Vec<f64>,
    /// How far the polynomial can be from the true one.
    error: f64,
    /// Upper bound of the maximum, and about the value in the middle.
    bound: f64,
    reached: f64,
}

impl Part {
    fn new(monomials: &Monomials, mut polynomial: Vec<f64>, mut error: f64) -> Part {
        let mut fixed = vec![false; monomials.variables];
        loop {
            let mut changed = false;
            // What stands beside the slope of each variable. It only becomes smaller while others are put to
            // their ends, up to roundings that are paid for below.
            let mut rests = vec![0.0; monomials.variables];
            for (a, x) in polynomial.iter().enumerate().skip(1) {
                if *x == 0.0 {
                    continue;
                }
                for (v, e) in monomials.exponents(a).iter().enumerate() {
                    if *e > 0 && a != monomials.linear(v) {
                        rests[v] += f64::from(*e) * x.abs();
                    }
                }
            }
            for (v, is_fixed) in fixed.iter_mut().enumerate() {
                if *is_fixed || monomials.degree == 0 {
                    continue;
                }
                let slope = polynomial[monomials.linear(v)];
                let operations = (2 + monomials.variables) * monomials.len();
                if slope.abs() > raised(rests[v], operations) {
                    error += put(monomials, &mut polynomial, v, slope.signum());
                    *is_fixed = true;
                    changed = true;
                }
            }
            if !changed {
                break;
            }
        }
        let mut above = 0.0;
        for (a, x) in polynomial.iter().enumerate().skip(1) {
            if *x != 0.0 {
                above += if monomials.is_even(a) {
                    x.max(0.0)
                } else {
                    x.abs()
                };
            }
        }
        let operations = polynomial.len() + 2;
        let size = polynomial[0].abs() + above;
        let bound = polynomial[0] + above + raised(2.0 * UNIT * size, operations);
        Part {
            bound: bound + raised(above * operations as f64 * UNIT, 2) + raised(error, 1),
            reached: polynomial[0] - error,
            polynomial,
            error,
        }
    }

    /// The variable in the largest terms that are not linear.
    fn worst(&self, monomials: &Monomials) -> Option<usize> {
        let is_linear = |a: usize| monomials.exponents(a).iter().sum::<u8>() == 1;
        let weight = |v: usize| -> f64 {
            (1..monomials.len())
                .filter(|a| !is_linear(*a))
                .map(|a| f64::from(monomials.exponents(a)[v]) * self.polynomial[a].abs())
                .sum()
        };
        (0..monomials.variables)
            .map(|v| (v, weight(v)))
            .filter(|(_, w)| *w > 0.0)
            .max_by(|x, y| x.1.total_cmp(&y.1))
            .map(|(v, _)| v)
    }

    /// The polynomial with `middle + x / 2` for variable `v`, and its error.
    fn half(&self, monomials: &Monomials, v: usize, middle: f64) -> (Vec<f64>, f64) {
        let mut polynomial = self.polynomial.clone();
        let lost = monomials.substitute(&mut polynomial, v, middle, 0.5);
        (polynomial, raised(self.error + lost, 1))
    }
}

/// Puts variable `v` to `±1`; returns what rounding can have taken.
fn put(monomials: &Monomials, polynomial: &mut [f64], v: usize, end: f64) -> f64 {
    let size: f64 = polynomial.iter().map(|x| x.abs()).sum();
    for a in (0..monomials.len()).rev() {
        let exponent = monomials.exponents(a)[v];
        if exponent == 0 || polynomial[a] == 0.0 {
            continue;
        }
        let below = (0..exponent).fold(a, |b, _| monomials.quotient(b, v));
        let sign = if exponent.is_multiple_of(2) { 1.0 } else { end };
        polynomial[below] += sign * polynomial[a];
        polynomial[a] = 0.0;
    }
    raised(UNIT * size * (monomials.degree + 1) as f64, monomials.len())
}

impl PartialEq for Part {
    fn eq(&self, other: &Part) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Part {}

impl PartialOrd for Part {
    fn partial_cmp(&self, other: &Part) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Part {
    fn cmp(&self, other: &Part) -> Ordering {
        self.bound.total_cmp(&other.bound)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form::draw::Draw;

    /// Random polynomials: no value at a point of a fine grid lies outside, and the ends are nearly
    /// reached.
    #[test]
    fn ranges_are_ranges() {
        let mut draws = Draw(5);
        let mut draw = || draws.next();
        let monomials = Monomials::new(&[1, 1], 4);
        for round in 0..60 {
            let flat = f64::powi(0.5, round % 6);
            let polynomial: Vec<f64> = (0..monomials.len())
                .map(|a| {
                    let degree: u8 = monomials.exponents(a).iter().sum();
                    draw() * flat.powi(i32::from(degree))
                })
                .collect();
            let bounds = range(&monomials, &polynomial);
            let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
            for i in 0..=80 {
                for l in 0..=80 {
                    let at = [f64::from(i) / 40.0 - 1.0, f64::from(l) / 40.0 - 1.0];
                    let value: f64 = (0..monomials.len())
                        .map(|a| {
                            let e = monomials.exponents(a);
                            polynomial[a] * at[0].powi(e[0].into()) * at[1].powi(e[1].into())
                        })
                        .sum();
                    assert!(bounds.contains(value), "{value} in {bounds}");
                    (lo, hi) = (lo.min(value), hi.max(value));
                }
            }
            let least = lo - 0.02 * (hi - lo) - 1e-9;
            assert!(is_above(&monomials, &polynomial, least), "{least} of {lo}");
            assert!(!is_above(&monomials, &polynomial, lo), "{lo}");
            assert!(bounds.contains(at_corner(&monomials, &polynomial)));
            assert!(
                bounds.width() <= 1.01 * (hi - lo) + 1e-12,
                "{bounds} for {lo} {hi}"
            );
        }
    }
}
