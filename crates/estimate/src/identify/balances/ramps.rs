//! Functions of time on one stretch: *up* from 0 to 1 and *down* from 1 to 0, with `ψ' + a ψ` constant: `up = (1 - e^(-a t)) / (1 - e^(-a T))`,
//! `down = 1 - up`.

use veribound_interval::Interval;

/// Below this `a T` is small enough for the first terms of its series.
const SMALL: f64 = 1.0 / 64.0;

fn unit() -> Interval {
    Interval::ZERO.hull(Interval::ONE)
}

/// `1/(1 - e^(-z)) - 1/z`, for small `z`.
///
/// Proof. It is `1/2 + L(z/2)/2` with `L(x) = coth x - 1/x = Σ 2x/(x² + n² π²)`. Each of these terms is, in absolute value, at most
/// `2x/(n² π²)` and less than that by at most `2x³/(n π)^4`; the sums are `x/3` and `x³/45`.
fn series(z: Interval) -> Interval {
    let linear = z / Interval::point(12.0);
    let less = z * z.sqr() / Interval::point(720.0);
    Interval::point(0.5) + linear - Interval::ZERO.hull(less)
}

/// `a/(1 - e^(-a t))`: what `ψ' + a ψ` is on a block of length `t` with *up*.
pub(super) fn rising(a: f64, t: Interval) -> Interval {
    let z = Interval::point(a) * t;
    if z.mag() < SMALL {
        (Interval::ONE + z * series(z)) / t
    } else {
        Interval::point(a) / (Interval::ONE - (-z).exp())
    }
}

/// The mean of *up* on a block of length `t`.
pub(super) fn share(a: f64, t: Interval) -> Interval {
    let z = Interval::point(a) * t;
    let mean = if z.mag() < SMALL {
        series(z)
    } else {
        Interval::ONE / (Interval::ONE - (-z).exp()) - Interval::ONE / z
    };
    mean.intersect(unit())
}

/// The mean of a state on a stretch, by the sum of its ends and its second derivative.
///
/// Proof. By parts, `∫ x = h (x(0) + x(h))/2 - ∫ s (h - s) x''(s) ds / 2`, and the weight `s (h - s)` is not negative and has the
/// integral `h³/6`.
pub(super) fn trapezoid(sum: Interval, bend: Interval, h: Interval) -> Interval {
    Interval::point(0.5) * sum - h.sqr() / Interval::point(12.0) * bend
}

/// The mean of a state on a stretch, weighed by the derivative of *up*.
///
/// Proof. The weight is `q = a e^(-a t)/(1 - e^(-a h))`, between `q(0) = rising` and `q(h) = rising - a`, with the integral 1; so the means differ
/// by the integral of `(q - 1/h) (x - c)`, whatever `c` is.
pub(super) fn weighed(
    rising: Interval,
    a: Interval,
    h: Interval,
    mean: Interval,
    tube: Interval,
) -> Interval {
    let first = rising * h;
    let last = first - a * h;
    let off = (first.hull(last) - Interval::ONE).mag();
    let reach = Interval::point(off) * Interval::point(tube.rad());
    (mean + Interval::symmetric(reach.hi())).intersect(tube)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean of *up*, and what it is multiplied by, at `a T` small and large, against sums of many terms.
    #[test]
    fn functions_of_a_block() {
        for z in [1e-9_f64, -1e-3, 0.01, -0.0156, 0.02, -0.3, 1.7, -5.0] {
            let t = Interval::point(0.5);
            let a = 2.0 * z;
            let up = |s: f64| (-z * s).exp_m1() / (-z).exp_m1();
            let n = 20_000;
            let mean: f64 = (0..n)
                .map(|k| up((f64::from(k) + 0.5) / f64::from(n)))
                .sum::<f64>()
                / f64::from(n);
            let (told, rise) = (share(a, t), rising(a, t));
            assert!(
                told.inflate(1e-9).contains(mean) && told.width() < 1e-7,
                "{z}: {told} {mean}"
            );
            let exact = -a / (-z).exp_m1();
            assert!(
                rise.inflate(1e-9).contains(exact) && rise.width() < 1e-6,
                "{z}: {rise} {exact}"
            );
        }
    }
}
