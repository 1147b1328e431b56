//! How far a polynomial is from an elementary function of another one.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: blocks own `monomials * stride` numbers; orders stay below the stride"
)]

use super::convolve::convolve;
use super::function::Functions;
use super::monomials::Monomials;
use super::outward::{UNIT, raised};
use super::size::Size;
use veribound_interval::Interval;
use veribound_model::Unary;

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
    let (stride, count) = (weights.len(), monomials.len());
    let (centre, deviation) = (inner_size.centre, inner_size.deviation);
    let range = Interval::point(centre).inflate(deviation);
    // Higher powers of `d` have no term that is kept.
    let most = top + monomials.degree + 1;
    let wide = functions.expand(function, range, most)?;
    let thin = functions.expand(function, Interval::point(centre), most)?;
    let enough = 0.25 * UNIT * (wide.first()?.mag() + 1e-30);
    let (mut terms, mut power, mut remainder) = (0, 1.0, f64::INFINITY);
    for (m, g) in wide.iter().enumerate() {
        remainder = raised(power * g.mag(), 1);
        terms = m;
        if remainder <= enough {
            break;
        }
        power = raised(power * deviation, 1);
    }
    let mut moving = inner.to_vec();
    moving[0] = 0.0;
    let mut moving_size = Size::new(monomials, stride);
    moving_size.measure(monomials, &moving, weights, inner_size.top);
    let mut acc = vec![0.0; count * stride];
    let mut next = vec![0.0; count * stride];
    let mut acc_size = Size::new(monomials, stride);
    let mut radius = 0.0;
    for g in thin[..terms].iter().rev() {
        acc_size.measure(monomials, &acc, weights, top);
        let lost = moving_size.product(&acc_size, monomials, top);
        for c in 0..count {
            for j in 0..=top {
                let mut sum = 0.0;
                for &(x, y) in monomials.factors(c) {
                    let (x, y) = (x as usize * stride, y as usize * stride);
                    sum += convolve(&moving[x..=x + j], &acc[y..=y + j]);
                }
                next[c * stride + j] = sum;
            }
        }
        std::mem::swap(&mut acc, &mut next);
        acc[0] += g.mid();
        let rounding = UNIT * acc[0].abs();
        radius = raised(radius * deviation + lost + rounding + g.rad(), 4);
    }
    let mut sum = 0.0;
    for c in 0..count {
        for j in 0..=top {
            sum += (own[c * stride + j] - acc[c * stride + j]).abs() * weights[j];
        }
    }
    let apart = raised(sum, count * (top + 1) + 2);
    Some(raised(apart + radius + remainder, 2))
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
