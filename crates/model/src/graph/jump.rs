//! Functions that jump, as sets: at a jump every value between the one-sided limits.
//!
//! With these sets the range of an expression on a box contains its limits from inside the box, so it
//! encloses the Filippov hull at each point of it. What a step adds to the derivative is zero on boxes without
//! a jump, and on others every number that a difference quotient can be.

use veribound_interval::{Interval, Regularity, domain};

/// The largest integers not above the elements; everything from `n - 1` to `n` at an integer `n`.
pub(crate) fn floor(x: Interval) -> Interval {
    (x.ceil() - Interval::ONE).hull(x.floor())
}

/// The elements of `x` where [`floor`] has a value in `values`.
///
/// A whole value `n` is taken on `[n, n + 1]`, one between two integers at the upper one.
pub(crate) fn floor_rev(values: Interval, x: Interval) -> Interval {
    x.intersect(values.ceil().hull(values.floor() + Interval::ONE))
}

/// Every difference quotient of [`floor`]; it never falls.
pub(crate) fn floor_slope(x: Interval) -> Interval {
    match floor_regularity(x) {
        _ if x.is_empty() => x,
        Regularity::Jump => Interval::new(0.0, f64::INFINITY).unwrap_or(Interval::ENTIRE),
        _ => Interval::ZERO,
    }
}

pub(crate) fn floor_regularity(x: Interval) -> Regularity {
    if floor(x).is_point() {
        Regularity::Smooth
    } else {
        Regularity::Jump
    }
}

/// The angles of points other than the origin; everything from `-π` to `π` on the negative half of the
/// axis `y = 0`.
pub(crate) fn atan2(y: Interval, x: Interval) -> Interval {
    let angles = y.atan2(x);
    if meets_cut(y, x) {
        angles.hull(Interval::PI.hull(-Interval::PI))
    } else {
        angles
    }
}

/// The elements of `y` and `x` with an angle in `angles`, limits included.
///
/// The sign of `y` is that of the angle, that of `x` the one of its cosine, and where that is not zero
/// `y = x tan(angle)`; at the cut the limits `-π` and `π` fit too.
pub(crate) fn atan2_rev(angles: Interval, y: Interval, x: Interval) -> (Interval, Interval) {
    // A quarter turn lies between this float and the next.
    let quarter = std::f64::consts::FRAC_PI_2;
    let half = |lo, hi| Interval::new(lo, hi).unwrap_or(Interval::ENTIRE);
    let (above, below) = (half(0.0, f64::INFINITY), half(f64::NEG_INFINITY, 0.0));
    let mut sides = (Interval::ENTIRE, Interval::ENTIRE);
    if angles.lo() >= 0.0 {
        sides.0 = above;
    } else if angles.hi() <= 0.0 {
        sides.0 = below;
    }
    let is_steep = if angles.mag() < quarter {
        sides.1 = above;
        false
    } else if angles.mig() > quarter.next_up() {
        sides.1 = below;
        false
    } else {
        true
    };
    let (y, x) = (y.intersect(sides.0), x.intersect(sides.1));
    if is_steep {
        return (y, x);
    }
    let slope = angles.tan();
    let y = y.intersect(x * slope);
    (y, Interval::mul_rev(slope, y, x))
}

/// What the jump of [`atan2`] adds to its slopes.
pub(crate) fn atan2_cut(y: Interval, x: Interval) -> Interval {
    match atan2_regularity(y, x) {
        _ if y.is_empty() || x.is_empty() => Interval::EMPTY,
        Regularity::Smooth | Regularity::Kink => Interval::ZERO,
        _ => Interval::ENTIRE,
    }
}

pub(crate) fn atan2_regularity(y: Interval, x: Interval) -> Regularity {
    match domain::atan2(y, x) {
        Regularity::Undefined => Regularity::Undefined,
        _ if meets_cut(y, x) => Regularity::Jump,
        other => other,
    }
}

fn meets_cut(y: Interval, x: Interval) -> bool {
    x.lo() < 0.0 && y.contains(0.0)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    fn interval(lo: f64, hi: f64) -> Interval {
        Interval::new(lo, hi).unwrap()
    }

    #[test]
    fn floor_has_both_limits_at_integers() {
        for (lo, hi, from, to) in [
            (0.5, 0.7, 0.0, 0.0),
            (2.0, 2.0, 1.0, 2.0),
            (1.5, 2.0, 1.0, 2.0),
            (2.0, 2.5, 1.0, 2.0),
            (-0.5, 3.5, -1.0, 3.0),
            (-2.0, -2.0, -3.0, -2.0),
        ] {
            assert_eq!(floor(interval(lo, hi)), interval(from, to), "[{lo}, {hi}]");
        }
        assert_eq!(floor(Interval::ENTIRE), Interval::ENTIRE);
        assert_eq!(floor(Interval::EMPTY), Interval::EMPTY);
        let large = floor(Interval::point(9e15));
        assert!(large.contains(9e15) && large.contains(9e15 - 1.0) && large.is_bounded());
        assert_eq!(floor_slope(interval(0.5, 0.7)), Interval::ZERO);
        assert_eq!(
            floor_slope(interval(1.0, 1.0)),
            interval(0.0, f64::INFINITY)
        );
        assert_eq!(floor_slope(Interval::EMPTY), Interval::EMPTY);
    }

    /// Points with every value that the set there has: none is lost on the way back.
    #[test]
    fn no_point_of_a_floor_is_lost_on_the_way_back() {
        let points = (-40..=40).map(|i| f64::from(i) / 8.0);
        for x in points {
            let set = floor(Interval::point(x));
            for share in 0..=8 {
                let value = set.lo() + f64::from(share) / 8.0 * set.width();
                for more in [0.0, 0.25, 1.0] {
                    let values = interval(value - more, value + more / 2.0);
                    let back = floor_rev(values, interval(-10.0, 10.0));
                    assert!(back.contains(x), "{x}: {values}: {back}");
                }
            }
        }
        assert_eq!(
            floor_rev(interval(2.0, 2.0), Interval::ENTIRE),
            interval(2.0, 3.0)
        );
        assert_eq!(
            floor_rev(interval(2.5, 2.7), Interval::ENTIRE),
            interval(3.0, 3.0)
        );
        assert_eq!(
            floor_rev(interval(-1.0, 0.5), Interval::ENTIRE),
            interval(-1.0, 1.0)
        );
    }

    #[test]
    fn angles_have_both_limits_at_the_cut() {
        let turn = atan2(Interval::ZERO, interval(-2.0, -1.0));
        assert!(turn.contains(std::f64::consts::PI) && turn.contains(-std::f64::consts::PI));
        let turn = atan2(interval(0.0, 1.0), interval(-2.0, 1.0));
        assert!(turn.contains(-std::f64::consts::PI));
        let quarter = atan2(interval(1.0, 2.0), interval(1.0, 2.0));
        assert!(quarter.lo() > 0.46 && quarter.hi() < 1.11);
        assert_eq!(
            atan2_cut(interval(1.0, 2.0), interval(-2.0, 2.0)),
            Interval::ZERO
        );
        assert_eq!(
            atan2_cut(interval(-1.0, 2.0), interval(-2.0, -1.0)),
            Interval::ENTIRE
        );
        assert_eq!(
            atan2_cut(interval(-1.0, 2.0), interval(1.0, 2.0)),
            Interval::ZERO
        );
    }

    #[test]
    fn no_point_is_lost_on_the_way_back_from_its_angle() {
        let ends: Vec<f64> = (-6..=6).map(f64::from).collect();
        for &y in &ends {
            for &x in &ends {
                if x == 0.0 && y == 0.0 {
                    continue;
                }
                let mut angles = vec![y.atan2(x)];
                if y == 0.0 && x < 0.0 {
                    angles.push(-std::f64::consts::PI);
                }
                for angle in angles {
                    for (less, more) in [(0.0, 0.0), (0.1, 0.0), (0.0, 0.1), (1.0, 2.0)] {
                        let near = interval(angle - less - 1e-15, angle + more + 1e-15);
                        let (ys, xs) = atan2_rev(near, interval(-7.0, 7.0), interval(-8.0, 8.0));
                        assert!(
                            ys.contains(y) && xs.contains(x),
                            "{y} {x} {near}: {ys} {xs}"
                        );
                    }
                }
            }
        }
    }
}
