//! Shares of boxes between two planes: how much of a tile rows leave.

use veribound_interval::Interval;

/// So many slopes of a row at most are not taken as something between.
const STEEP: usize = 10;

/// Slopes below this share of the largest are taken as something between.
const FLAT: f64 = 1e-3;

/// What is not known of a share.
pub(super) fn any_share() -> Interval {
    Interval::new(0.0, 1.0).unwrap_or(Interval::ENTIRE)
}

/// Encloses the share of a box in which `slopes·x` is between two bounds.
pub(super) fn between(slopes: &[f64], box_: &[Interval], bounds: Interval) -> Interval {
    if bounds.is_empty() {
        return Interval::ZERO;
    }
    below(slopes, box_, bounds.hi(), false) - below(slopes, box_, bounds.lo(), true)
}

/// Encloses the share of a box in which `slopes·x` is at most `bound`, or less than it: that differs where the sum is the same
/// everywhere.
///
/// Proof. With `x_i = lo_i + w_i t_i`, or from the upper end where the slope is negative, the sum is `s + Σ a_i t_i` with
/// positive `a_i`, and for `n` of them the share of the unit box is `Σ ± (b - s - Σ_v a_i)_+^n / (n! Π a_i)` over all
/// corners `v` of the box, with the sign of the parity of their ones. It grows with the bound, so that what is between in
/// the bound is taken at its ends.
fn below(slopes: &[f64], box_: &[Interval], bound: f64, is_open: bool) -> Interval {
    if !bound.is_finite() {
        return if bound > 0.0 {
            Interval::ONE
        } else {
            Interval::ZERO
        };
    }
    let mut rest = Interval::point(bound);
    let mut lengths: Vec<Interval> = Vec::with_capacity(slopes.len());
    for (slope, x) in slopes.iter().zip(box_) {
        let from = if *slope < 0.0 { x.hi() } else { x.lo() };
        let width = Interval::point(x.hi()) - Interval::point(x.lo());
        rest -= Interval::point(*slope) * Interval::point(from);
        lengths.push(Interval::point(slope.abs()) * width);
    }
    let largest = lengths.iter().map(|a| a.hi()).fold(0.0, f64::max);
    let mut steep: Vec<Interval> = Vec::with_capacity(lengths.len());
    for length in lengths {
        if length.lo() > FLAT * largest && steep.len() < STEEP {
            steep.push(length);
        } else {
            rest -= Interval::ZERO.hull(length);
        }
    }
    let power = |x: Interval| steep.iter().fold(Interval::ONE, |power, _| power * x);
    let size = steep.iter().zip(1_u8..);
    let size = size.fold(Interval::ONE, |size, (a, k)| {
        size * *a * Interval::point(f64::from(k))
    });
    let share = |rest: f64| {
        if steep.is_empty() {
            return if rest > 0.0 || (rest == 0.0 && !is_open) {
                Interval::ONE
            } else {
                Interval::ZERO
            };
        }
        let mut sum = Interval::ZERO;
        for corner in 0..1_usize << steep.len() {
            let ones = steep
                .iter()
                .enumerate()
                .filter(|(i, _)| corner >> i & 1 == 1);
            let left = ones.fold(Interval::point(rest), |left, (_, a)| left - *a);
            let left =
                Interval::new(left.lo().max(0.0), left.hi().max(0.0)).unwrap_or(Interval::ENTIRE);
            if corner.count_ones() % 2 == 0 {
                sum += power(left);
            } else {
                sum -= power(left);
            }
        }
        (sum / size).intersect(any_share())
    };
    Interval::new(share(rest.lo()).lo(), share(rest.hi()).hi()).unwrap_or_else(any_share)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    fn interval(lo: f64, hi: f64) -> Interval {
        Interval::new(lo, hi).unwrap()
    }

    /// What is the same everywhere and just agrees does so everywhere.
    #[test]
    fn a_sum_on_the_end_of_its_bounds_is_between_them() {
        let box_ = [interval(-1.0, 1.0), interval(2.0, 2.0)];
        for (slopes, at) in [([0.0, 0.0], 0.0), ([0.0, 3.0], 6.0)] {
            for (from, to, share) in [
                (0.0, 2.0, Interval::ONE),
                (-2.0, 0.0, Interval::ONE),
                (0.0, 0.0, Interval::ONE),
                (1.0, 2.0, Interval::ZERO),
                (-2.0, -1.0, Interval::ZERO),
            ] {
                let told = between(&slopes, &box_, interval(at + from, at + to));
                assert!(share.is_subset_of(told), "{slopes:?} {from} {to}: {told}");
            }
        }
    }

    /// Shares of boxes between two planes, against points on a grid.
    #[test]
    fn shares_are_enclosed() {
        let mut seed = 9_u64;
        let mut draw = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        const STEPS: usize = 24;
        let mut widest: f64 = 0.0;
        for round in 0..200 {
            let scale = [1.0, 1.0, if round % 3 == 0 { 1e-5 } else { 1.0 }];
            let slopes = scale.map(|scale| scale * draw());
            let box_ = scale.map(|_| interval(-2.0, -2.0) + interval(0.0, 1.1 + draw()));
            let sum = slopes.iter().zip(&box_);
            let sum = sum.fold(Interval::ZERO, |sum, (g, x)| sum + Interval::point(*g) * *x);
            let (a, b) = (draw(), draw());
            let at = |share: f64| sum.mid() + 0.6 * share * sum.width();
            let bounds = interval(at(a.min(b)), at(a.max(b)));
            let told = between(&slopes, &box_, bounds);
            let mut inside = 0;
            for cell in 0..STEPS.pow(3) {
                let index = [cell % STEPS, cell / STEPS % STEPS, cell / STEPS / STEPS];
                let terms = index.iter().zip(&box_).zip(&slopes).map(|((i, x), g)| {
                    let share = (*i as f64 + 0.5) / STEPS as f64;
                    g * (x.lo() + share * x.width())
                });
                inside += usize::from(bounds.contains(terms.sum()));
            }
            let about = inside as f64 / STEPS.pow(3) as f64;
            let near = told.inflate(0.07);
            assert!(near.contains(about), "{slopes:?} {bounds}: {told} {about}");
            widest = widest.max(told.width());
        }
        assert!(widest < 0.01, "{widest}");
    }
}
