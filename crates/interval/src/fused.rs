//! The fused `x y + z`, tight.

use crate::Interval;
use crate::interval::{larger, smaller};
use crate::round::{add_down, add_up, from_scaled, mul_down, mul_up, parts};

impl Interval {
    /// `x y + z` for the elements, with `x` in `self`: the ends are tight, as if rounded once.
    ///
    /// `x y + z` increases with `z`, and its extremes over the box of `x` and `y` are where those of the
    /// product are: at the corners of the table of [`Interval`]'s product.
    pub fn fma(self, y: Interval, z: Interval) -> Interval {
        if self.is_empty() || y.is_empty() || z.is_empty() {
            return Interval::EMPTY;
        }
        let ((a, b), (c, d)) = ((self.lo(), self.hi()), (y.lo(), y.hi()));
        let lo = |x, y| fused(x, y, z.lo(), false);
        let hi = |x, y| fused(x, y, z.hi(), true);
        let (lo, hi) = if a >= 0.0 {
            let (least, most) = (if c >= 0.0 { a } else { b }, if d <= 0.0 { a } else { b });
            (lo(least, c), hi(most, d))
        } else if b <= 0.0 {
            let (least, most) = (if d <= 0.0 { b } else { a }, if c >= 0.0 { b } else { a });
            (lo(least, d), hi(most, c))
        } else if c >= 0.0 {
            (lo(a, d), hi(b, d))
        } else if d <= 0.0 {
            (lo(b, c), hi(a, c))
        } else {
            (smaller(lo(a, d), lo(b, c)), larger(hi(a, c), hi(b, d)))
        };
        Interval::raw(lo, hi)
    }
}

/// The largest float not above `a b + c`, or (`up`) the smallest not below. An infinite operand is a
/// bound of real numbers: a factor 0 makes the product zero, and `c` is infinite only in the
/// direction of the rounding.
///
/// The product has at most 106 bits. Both terms get their leading bits up to bit 106, then the term with
/// the larger unit is shifted up by at most 20 bits, and the other one down as far as units still
/// differ. A bit lost there lies below more than 100 kept bits of the sum, which is therefore between two
/// neighbouring integers and not one of them, as [`from_scaled`] wants.
fn fused(a: f64, b: f64, c: f64, up: bool) -> f64 {
    if a == 0.0 || b == 0.0 || !a.is_finite() || !b.is_finite() || !c.is_finite() || c == 0.0 {
        // The product is zero or infinite, or nothing is added to it.
        return if up {
            add_up(mul_up(a, b), c)
        } else {
            add_down(mul_down(a, b), c)
        };
    }
    let ((na, ma, ea), (nb, mb, eb), (nc, mc, ec)) = (parts(a), parts(b), parts(c));
    let product = (na != nb, ma * mb, ea + eb);
    let addend = (nc, mc << 53, ec - 53);
    let ((n1, m1, e1), (n2, m2, e2)) = if product.2 >= addend.2 {
        (product, addend)
    } else {
        (addend, product)
    };
    let apart = e1 - e2;
    let shift = apart.min(20);
    let (first, e) = (m1 << shift, e1 - shift);
    let drop = apart - shift;
    let (second, rest) = if drop < 128 {
        (m2 >> drop, m2 & ((1 << drop) - 1) != 0)
    } else {
        (0, true)
    };
    let (negative, m) = if n1 == n2 {
        (n1, first + second)
    } else if first >= second {
        // A rest is taken away: the number lies between the next lower integer and this one.
        (n1, first - second - u128::from(rest))
    } else {
        (n2, second - first)
    };
    from_scaled(negative, m, i64::from(e), rest, up)
}
