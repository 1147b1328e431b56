//! Squares, integer powers, and bounds of integer roots.
//!
//! *Guarantee*: as in [`crate::arith`]. Squares are tight; other powers are products of directed
//! roundings.

use crate::Interval;
use crate::arith::{inward, outward};
use crate::interval::larger;
use crate::round::{Lanes, Pair, mul_down, mul_up, product_up};

impl Interval {
    /// The squares of the elements: never negative, unlike `x * x`.
    #[inline]
    pub fn sqr(self) -> Interval {
        let (a, b) = (self.lo(), self.hi());
        let (near, far) = if a >= 0.0 {
            (a, b)
        } else if b <= 0.0 {
            (b, a)
        } else {
            (0.0, larger(-a, b))
        };
        match product_up(Pair::new(-near, far), Pair::new(near, far)) {
            (squares, true) => inward(squares),
            _ => self.sqr_extreme(),
        }
    }

    /// The `n`-th powers of the elements; `x^0 = 1` also at 0, and for negative `n` the element 0 has
    /// no power.
    ///
    /// The ends are products of directed roundings, at most about `|n|` floats from the tight ones.
    #[inline]
    pub fn powi(self, n: i32) -> Interval {
        match n {
            _ if self.is_empty() => self,
            0 => Interval::ONE,
            1 => self,
            2 => self.sqr(),
            _ if n < 0 => self.negative_power(n.unsigned_abs()),
            _ => self.positive_power(n.unsigned_abs()),
        }
    }

    /// Powers for `-n`: the reciprocal of the power, or where that overflows, also the power of the
    /// reciprocal; both contain all powers.
    fn negative_power(self, n: u32) -> Interval {
        let power = self.positive_power(n);
        if power.is_bounded() || !self.is_bounded() {
            return power.recip();
        }
        power.recip().intersect(self.recip().positive_power(n))
    }

    /// Powers for `n >= 1`: increasing for odd `n`, a function of `|x|` for even `n`.
    ///
    /// Repeated squaring of `[-lo, hi]`, or `[-mig, mag]` for even `n`, where the factors keep the sign
    /// of the first: a negative lane then rounds its magnitude down, a positive one up, as the end it
    /// becomes needs.
    fn positive_power(self, n: u32) -> Interval {
        let even = n.is_multiple_of(2);
        let mut square = if even {
            Pair::new(-self.mig(), self.mag())
        } else {
            outward(self)
        };
        let (mut product, mut started, mut fast, mut rest) = (square, false, true, n);
        while fast {
            if rest & 1 == 1 {
                (product, fast) = if started {
                    product_up(product, square.abs())
                } else {
                    (square, true)
                };
                started = true;
            }
            rest >>= 1;
            if rest == 0 {
                break;
            }
            let (next, holds) = product_up(square, square.abs());
            (square, fast) = (next, fast & holds);
        }
        if fast {
            inward(product)
        } else {
            self.power_extreme(n)
        }
    }

    /// Powers for `n >= 1`, each end by itself.
    #[inline(never)]
    fn power_extreme(self, n: u32) -> Interval {
        if n.is_multiple_of(2) {
            return Interval::raw(power_down(self.mig(), n), power_up(self.mag(), n));
        }
        let end = |x: f64, up: bool| match (x < 0.0, up) {
            (false, false) => power_down(x, n),
            (false, true) => power_up(x, n),
            (true, false) => -power_up(-x, n),
            (true, true) => -power_down(-x, n),
        };
        Interval::raw(end(self.lo(), false), end(self.hi(), true))
    }

    #[inline(never)]
    fn sqr_extreme(self) -> Interval {
        if self.is_empty() {
            return self;
        }
        let (near, far) = (self.mig(), self.mag());
        Interval::raw(mul_down(near, near), mul_up(far, far))
    }
}

/// A lower bound of `a^n` for `a >= 0`, `n >= 1`: repeated squaring, every product rounded down.
/// Products of lower bounds of numbers that are not negative are lower bounds.
pub(crate) fn power_down(a: f64, n: u32) -> f64 {
    power(a, n, mul_down)
}

/// An upper bound of `a^n` for `a >= 0`, `n >= 1`; mirror image of [`power_down`].
pub(crate) fn power_up(a: f64, n: u32) -> f64 {
    power(a, n, mul_up)
}

fn power(a: f64, n: u32, times: impl Fn(f64, f64) -> f64) -> f64 {
    let (mut square, mut rest) = (a, n);
    let mut product = None;
    loop {
        if rest & 1 == 1 {
            product = Some(product.map_or(square, |p| times(p, square)));
        }
        rest >>= 1;
        match product {
            Some(p) if rest == 0 => return p,
            _ => square = times(square, square),
        }
    }
}

/// A lower bound of the `n`-th root of `a >= 0`, `n >= 2`: the largest float whose power, rounded up,
/// is not above `a`.
pub(crate) fn root_down(a: f64, n: u32) -> f64 {
    if a == 0.0 || a.is_infinite() {
        return if a == 0.0 { 0.0 } else { f64::MAX };
    }
    last_that_holds(root_guess(a, n), |x| power_up(x, n) <= a).0
}

/// An upper bound of the `n`-th root; the smallest float whose power, rounded down, is not below `a`.
pub(crate) fn root_up(a: f64, n: u32) -> f64 {
    if a == 0.0 || a.is_infinite() {
        return a;
    }
    last_that_holds(root_guess(a, n), |x| power_down(x, n) < a).1
}

/// Two neighbours, the first with the property and the second without. Required: 0 has it, the largest
/// float has not. The search starts at the guess with growing steps, then bisects; both answers have
/// been tested, so nothing depends on the guess or on monotony.
fn last_that_holds(guess: f64, property: impl Fn(f64) -> bool) -> (f64, f64) {
    let holds = |bits: u64| property(f64::from_bits(bits));
    let (mut with, mut step) = (guess.to_bits(), 1);
    let mut without = with;
    while !holds(with) {
        without = with;
        with = with.saturating_sub(step);
        step *= 2;
    }
    while without == with || holds(without) {
        with = without;
        without = (without + step).min(f64::MAX.to_bits());
        step *= 2;
    }
    while without - with > 1 {
        let middle = with + (without - with) / 2;
        if holds(middle) {
            with = middle;
        } else {
            without = middle;
        }
    }
    (f64::from_bits(with), f64::from_bits(without))
}

/// A positive finite float near the root, which needs no guarantee: a power with a rounded exponent,
/// improved by one Newton step.
fn root_guess(a: f64, n: u32) -> f64 {
    let degree = f64::from(n);
    let rough = core_math::pow(a, degree.recip());
    let better = rough - rough * ((power_down(rough, n) / a - 1.0) / degree);
    // The powers of subnormal numbers are too coarse for the step.
    let guess = if a > 1e-290 && better.is_finite() {
        better
    } else {
        rough
    };
    guess.clamp(f64::MIN_POSITIVE, f64::MAX)
}
