//! How far a polynomial is from an elementary function of another one.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: blocks own `monomials * stride` numbers; orders stay below the stride"
)]

use super::convolve::{LANES, convolve_rows};
use super::function::Functions;
use super::monomials::Monomials;
use super::outward::{UNIT, raised};
use super::size::Size;
use veribound_interval::lanes::{Arithmetic, Kernel, Value};
use veribound_interval::{Interval, Interval8};
use veribound_model::Unary;

/// So many terms are enough on short steps; more are computed where they are not.
const FEW: usize = 12;

/// `sup |z - g(a)|` for the polynomial `z` (orders up to `top`) that shall be `g(a)`; `None` where `g` is
/// not smooth on the range of `a`.
///
/// Proof. `g(c + d) = Σ_(m<M) g_m d^m + g_M(ξ) d^M` with `c` the constant of `a`, `|d|` at most its
/// deviation, and `g_M(ξ)` in the Taylor coefficient of `g` on the range. The sum is computed by Horner's
/// rule, `acc <- acc d + g_m`; what a product loses is added to the radius of `acc`, and the radius so
/// far is multiplied by the deviation. At the end the two polynomials are compared.
pub(super) fn defect(
    (monomials, functions, weights): (&Monomials, &Functions, &[f64]),
    function: Unary,
    (inner, inner_size): (&[f64], &Size),
    (own, top): (&[f64], usize),
) -> Option<f64> {
    let count = monomials.len();
    let (centre, deviation) = (inner_size.centre, inner_size.deviation);
    let range = Interval::point(centre).inflate(deviation);
    // Higher powers of `d` have no term that is kept.
    let most = top + monomials.degree + 1;
    let (mut terms, mut remainder) = (0, f64::INFINITY);
    for orders in [FEW.min(most), most] {
        let wide = functions.expand(function, range, orders)?;
        let enough = 0.25 * UNIT * (wide.first()?.mag() + 1e-30);
        let mut power = 1.0;
        for (m, g) in wide.iter().enumerate() {
            remainder = raised(power * g.mag(), 1);
            terms = m;
            if remainder <= enough {
                break;
            }
            power = raised(power * deviation, 1);
        }
        if remainder <= enough {
            break;
        }
    }
    let thin = functions.expand(function, Interval::point(centre), terms)?;
    let mut moving = inner.to_vec();
    moving[0] = 0.0;
    let horner = Horner {
        monomials,
        weights,
        inner: (&moving, inner_size.top, deviation),
        outer: &thin[..terms],
        top,
        own,
    };
    let (sum, radius) = Interval8::run(horner);
    let apart = raised(sum, count * (top + 1) + 2);
    Some(raised(apart + radius + remainder, 2))
}

/// The sum of `outer[m] d^m`; a kernel only to be compiled for the instruction set of the processor.
struct Horner<'a> {
    monomials: &'a Monomials,
    weights: &'a [f64],
    /// The polynomial `d`, its highest order, and a bound of it.
    inner: (&'a [f64], usize, f64),
    outer: &'a [Interval],
    /// Highest order that is kept.
    top: usize,
    /// What the sum shall be.
    own: &'a [f64],
}

impl Kernel<Interval8> for Horner<'_> {
    /// How far the sum computed is from `own`, and how far it can be from the true one.
    type Output = (f64, f64);

    #[inline(always)]
    fn run<A: Arithmetic<Value = Interval8>>(self) -> (f64, f64) {
        let Horner {
            monomials,
            weights,
            inner: (moving, inner_top, deviation),
            outer,
            top,
            own,
        } = self;
        let (stride, count) = (weights.len(), monomials.len());
        let mut moving_size = Size::new(monomials, stride);
        moving_size.measure(monomials, moving, weights, inner_top);
        let mut acc_size = Size::new(monomials, stride);
        let mut acc = vec![0.0; count * stride];
        // The same with the orders of every monomial backwards, and zeros behind.
        let mut backwards = vec![0.0; count * (stride + LANES)];
        let mut row = vec![0.0; count];
        let mut radius = 0.0;
        for g in outer.iter().rev() {
            acc_size.measure(monomials, &acc, weights, top);
            let lost = moving_size.product(&acc_size, monomials, top);
            for (c, orders) in acc.chunks_exact(stride).enumerate() {
                let place = &mut backwards[c * (stride + LANES)..][..stride];
                for (slot, x) in place.iter_mut().rev().zip(orders) {
                    *slot = *x;
                }
            }
            for j in 0..=top {
                convolve_rows(monomials, moving, &backwards, (stride, j), &mut row);
                for (slot, x) in acc[j..].iter_mut().step_by(stride).zip(&row) {
                    *slot = *x;
                }
            }
            acc[0] += g.mid();
            let rounding = UNIT * acc[0].abs();
            radius = raised(radius * deviation + lost + rounding + g.rad(), 4);
        }
        let mut sum = 0.0;
        for (own, acc) in own.chunks_exact(stride).zip(acc.chunks_exact(stride)) {
            for ((x, y), weight) in own.iter().zip(acc).zip(weights).take(top + 1) {
                sum += (x - y).abs() * weight;
            }
        }
        (sum, radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form::code::Code;
    use veribound_model::{Graph, Var};

    type Function = fn(f64) -> f64;

    /// Polynomials that are far from the function, and some that are near: the distance at points is never
    /// more than said.
    #[test]
    fn the_distance_is_told() {
        let monomials = Monomials::new(&[1], 2);
        let weights = [1.0; 4];
        let mut inner = vec![0.0; 12];
        (inner[0], inner[1], inner[4]) = (0.8, 0.1, 0.2);
        let mut size = Size::new(&monomials, 4);
        size.measure(&monomials, &inner, &weights, 3);
        let cases: [(Unary, Function); 5] = [
            (Unary::Exp, f64::exp),
            (Unary::Sin, f64::sin),
            (Unary::Sqrt, f64::sqrt),
            (Unary::Tanh, f64::tanh),
            (Unary::Atan, f64::atan),
        ];
        for (function, value) in cases {
            let mut graph = Graph::default();
            let x = graph.var(Var::State(0));
            let call = graph.unary(function, x);
            let code = Code::compile(&mut graph, &[false], &[call], &[]);
            let functions = Functions::of(&code);
            for (constant, linear) in [(0.0, 0.0), (value(0.8), 0.0), (value(0.8), 0.5)] {
                let mut own = vec![0.0; 12];
                (own[0], own[1], own[4]) = (constant, 0.5 * linear, linear);
                let context = (&monomials, &functions, &weights[..]);
                let said = defect(context, function, (&inner, &size), (&own, 3)).unwrap();
                let mut most: f64 = 0.0;
                for (d, s) in [(1.0, 1.0), (-1.0, 1.0), (1.0, 0.0), (-1.0, 0.0), (0.3, 0.7)] {
                    let exact = value(0.8 + 0.1 * s + 0.2 * d);
                    most = most.max((constant + 0.5 * linear * s + linear * d - exact).abs());
                }
                assert!(most <= said, "{function:?}: {most} of {said}");
            }
        }
    }
}
