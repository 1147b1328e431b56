//! Squares, integer powers and integer roots.
//!
//! *Guarantee*: as in [`crate::arith`]. Squares are tight. The ends of powers and roots are tight, or in
//! rare cases (a float among the last of 128 bits) one float further out; values that are floats are
//! exact. All of it is proved: powers are sums of two floats with a bounded error ([`double`]) or, where that
//! does not decide, integers with a counted one ([`scaled`]); a root is a float whose power has been
//! compared.

mod double;
mod real;
mod scaled;

use crate::Interval;
use crate::arith::inward;
use crate::interval::larger;
use crate::round::{Pair, mul_down, mul_up, product_up};
use double::Near;
use scaled::Scaled;

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

    #[inline(never)]
    fn sqr_extreme(self) -> Interval {
        if self.is_empty() {
            return self;
        }
        let (near, far) = (self.mig(), self.mag());
        Interval::raw(mul_down(near, near), mul_up(far, far))
    }

    /// The `n`-th powers of the elements; `x^0 = 1` also at 0, and for negative `n` the element 0 has
    /// no power.
    ///
    /// Ends are tight or one float further out. *Cost*: about `2 log2 |n|` products in twice the precision
    /// of floats; of 128 bits, several times as dear, for `|n| > 64` and very large or small powers.
    #[inline]
    pub fn powi(self, n: i32) -> Interval {
        match n {
            _ if self.is_empty() => self,
            0 => Interval::ONE,
            1 => self,
            2 => self.sqr(),
            -1 => self.recip(),
            _ => self.by_pieces(n & 1 == 1, |x| power_of_positive(x, n)),
        }
    }

    /// The real `n`-th roots of the elements, for negative `n` their reciprocals: for odd `n` of all
    /// elements, for even `n` of those `>= 0`; the inverse of [`Interval::powi`] on `x >= 0`.
    ///
    /// There is no root for `n = 0` (empty), and none of 0 for negative `n`. Ends are tight or one
    /// float further out. *Cost*: some ten powers for each end.
    #[inline]
    pub fn rootn(self, n: i32) -> Interval {
        match n {
            0 => Interval::EMPTY,
            1 => self,
            2 => self.sqrt(),
            -1 => self.recip(),
            _ => {
                let positive = root_of_positive(self.intersect(Interval::NON_NEGATIVE), n);
                if n & 1 == 0 {
                    return positive;
                }
                let negative = root_of_positive((-self).intersect(Interval::NON_NEGATIVE), n);
                positive.hull(-negative)
            }
        }
    }

    /// A function that is monotone on `x >= 0`, and odd or even.
    #[inline]
    fn by_pieces(self, odd: bool, f: impl Fn(Interval) -> Interval) -> Interval {
        if self.lo() >= 0.0 {
            f(self)
        } else if !odd {
            f(self.abs())
        } else if self.hi() <= 0.0 {
            -f(-self)
        } else {
            let below = f(Interval::raw(0.0, -self.lo()));
            f(Interval::raw(0.0, self.hi())).hull(-below)
        }
    }
}

/// The `n`-th powers of a nonempty set of numbers `>= 0`, for `n != 0`.
fn power_of_positive(x: Interval, n: i32) -> Interval {
    let (first, last) = if n > 0 {
        (x.lo(), x.hi())
    } else if x.hi() == 0.0 {
        return Interval::EMPTY;
    } else {
        (x.hi(), x.lo())
    };
    let near = Near::power(Pair::new(first, last), n);
    let (lo, hi) = near.map_or((None, None), |near| (near.down(), near.up()));
    Interval::raw(
        lo.unwrap_or_else(|| power_down(first, n)),
        hi.unwrap_or_else(|| power_up(last, n)),
    )
}

/// A lower bound of `x^n` for `0 <= x <= inf`, in the limit at the ends. The lower end of a set of powers
/// has no infinite limit.
fn power_down(x: f64, n: i32) -> f64 {
    limit(x, n).unwrap_or_else(|| Scaled::power(x, n).down())
}

/// An upper bound of `x^n`; see [`power_down`].
fn power_up(x: f64, n: i32) -> f64 {
    limit(x, n).unwrap_or_else(|| Scaled::power(x, n).up())
}

/// The limit of `x^n` (or of the root) at 0 and infinity.
fn limit(x: f64, n: i32) -> Option<f64> {
    match (x == 0.0, x.is_infinite(), n > 0) {
        (true, _, true) | (_, true, false) => Some(0.0),
        (true, _, false) | (_, true, true) => Some(f64::INFINITY),
        _ => None,
    }
}

/// The `n`-th roots of a set of numbers `>= 0`, for `|n| >= 2`.
fn root_of_positive(x: Interval, n: i32) -> Interval {
    if x.is_empty() || (n < 0 && x.hi() == 0.0) {
        return Interval::EMPTY;
    }
    let (first, last) = if n > 0 {
        (x.lo(), x.hi())
    } else {
        (x.hi(), x.lo())
    };
    Interval::raw(root_down(first, n), root_up(last, n))
}

/// A lower bound of the `n`-th root of `a >= 0`, `|n| >= 2`: the largest float whose power is proved to
/// be on the side of `a` where the root is not smaller.
fn root_down(a: f64, n: i32) -> f64 {
    if let Some(limit) = limit(a, n) {
        return limit;
    }
    let bound = Scaled::of(a);
    last_that_holds(root_guess(a, n), |x| {
        x == 0.0 || {
            let power = Scaled::power(x, n);
            if n > 0 {
                power.is_at_most(bound)
            } else {
                power.is_at_least(bound)
            }
        }
    })
    .0
}

/// An upper bound of the `n`-th root; see [`root_down`].
fn root_up(a: f64, n: i32) -> f64 {
    if let Some(limit) = limit(a, n) {
        return limit;
    }
    let bound = Scaled::of(a);
    last_that_holds(root_guess(a, n), |x| {
        x == 0.0 || {
            let power = Scaled::power(x, n);
            !if n > 0 {
                power.is_at_least(bound)
            } else {
                power.is_at_most(bound)
            }
        }
    })
    .1
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

/// A positive finite float near the root, which needs no guarantee. The power with a rounded exponent
/// is a few hundred floats off at most (the logarithm of a float is below 745).
fn root_guess(a: f64, n: i32) -> f64 {
    let guess = match n {
        3 => core_math::cbrt(a),
        _ => core_math::pow(a, f64::from(n).recip()),
    };
    guess.clamp(f64::MIN_POSITIVE, f64::MAX)
}
