//! Reverse operations of powers and roots.

use crate::Interval;

impl Interval {
    /// `{x : x^n in c}`; for negative `n` the number 0 is no solution.
    pub fn powi_rev(n: i32, c: Interval, x: Interval) -> Interval {
        if n == 0 {
            return if c.contains(1.0) { x } else { Interval::EMPTY };
        }
        let roots = |c: Interval| c.intersect(Interval::NON_NEGATIVE).rootn(n);
        let above = roots(c);
        let below = if n & 1 == 0 { -above } else { -roots(-c) };
        x.intersect(below).hull(x.intersect(above))
    }

    /// `{x : the n-th root of x in c}`; see [`Interval::rootn`].
    pub fn rootn_rev(n: i32, c: Interval, x: Interval) -> Interval {
        let values = match n {
            0 => Interval::EMPTY,
            _ if n & 1 == 0 => c.intersect(Interval::NON_NEGATIVE),
            _ => c,
        };
        // For odd negative n there are two pieces, above and below 0.
        let piece = |values: Interval| x.intersect(values.powi(n));
        let (above, below) = (
            values.intersect(Interval::NON_NEGATIVE),
            (-values).intersect(Interval::NON_NEGATIVE),
        );
        piece(-below).hull(piece(above))
    }

    /// The bases `{x : x^y in c, for an exponent y in b}` of [`Interval::pow`] (IEEE 1788 `powRev1`).
    ///
    /// For `y != 0` they are `c^(1/y)`, for `y = 0` all `x > 0` if 1 is in `c`. Ends are tight up to the
    /// rounding of `1 / y`. In the limit `y → ±inf` the formula ends at 1, and for `x = 0` at 0, which may be no
    /// solutions themselves; a piece that has nothing else is empty.
    pub fn pow_rev1(b: Interval, c: Interval, x: Interval) -> Interval {
        let one = c.contains(1.0) && !b.is_empty();
        let zero = c.contains(0.0) && b.hi() > 0.0;
        let solved = |piece: Interval| {
            let missed = (piece == Interval::ONE && !one) || (piece == Interval::ZERO && !zero);
            if missed { Interval::EMPTY } else { piece }
        };
        let piece = |exponents: Interval| solved(x.intersect(c.pow(exponents.recip())));
        let above = piece(b.intersect(Interval::NON_NEGATIVE));
        let below = piece(b.intersect(-Interval::NON_NEGATIVE));
        let any = if one && b.contains(0.0) {
            solved(x.intersect(Interval::NON_NEGATIVE))
        } else {
            Interval::EMPTY
        };
        above.hull(below).hull(any)
    }

    /// The exponents `{x : y^x in c, for a base y in a}` of [`Interval::pow`] (IEEE 1788 `powRev2`).
    ///
    /// For a base other than 0 and 1 they are `log2 c / log2 y`, whose ends are a few floats from the
    /// tight ones (exact where base and value are powers of two and the quotient is a float). The base
    /// 1 has all exponents if 1 is in `c`, the base 0 the positive ones if 0 is in `c`. A piece that has
    /// nothing but the limit 0 at the bases 0 and infinity, and no `y^0 = 1` in `c`, is empty.
    pub fn pow_rev2(a: Interval, c: Interval, x: Interval) -> Interval {
        let solved = |piece: Interval| {
            let zero = c.contains(1.0) && a.hi() > 0.0;
            if piece == Interval::ZERO && !zero {
                Interval::EMPTY
            } else {
                piece
            }
        };
        let (values, bases) = (c.log2(), a.log2());
        let piece = |bases: Interval| solved(x.intersect(values / bases));
        let above = piece(bases.intersect(Interval::NON_NEGATIVE));
        let below = piece(bases.intersect(-Interval::NON_NEGATIVE));
        let of_one = if a.contains(1.0) && c.contains(1.0) {
            x
        } else {
            Interval::EMPTY
        };
        let of_zero = if a.contains(0.0) && c.contains(0.0) {
            solved(x.intersect(Interval::NON_NEGATIVE))
        } else {
            Interval::EMPTY
        };
        above.hull(below).hull(of_one).hull(of_zero)
    }
}
