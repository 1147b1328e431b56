//! Floats side by side on any processor: arrays that the compiler puts into whatever registers
//! there are.
//!
//! Fused multiplication is used where it belongs to the compilation target; elsewhere Dekker's
//! product gives the errors, within a range that leaves out the very large and the very small
//! numbers.

use super::vector::Vector;
use super::{Floats, Interval8, basic};
use crate::Interval;
use crate::round::{Elementwise, LEAST, MOST, SMALL};

/// True where products have exact errors by a fused operation and so without an upper limit.
const FUSED: bool = cfg!(any(target_feature = "fma", target_arch = "aarch64"));

/// `N` floats.
#[derive(Clone, Copy)]
pub(super) struct Array<const N: usize>([f64; N]);

/// All bits of a lane are set or none.
#[derive(Clone, Copy)]
pub(super) struct Bits<const N: usize>([u64; N]);

/// A nearest float, and the true value minus this float (of which the sign counts).
#[derive(Clone, Copy)]
pub(super) struct Nearest<const N: usize> {
    value: Array<N>,
    error: Array<N>,
}

impl<const N: usize> Array<N> {
    #[inline(always)]
    fn each(self, f: impl Fn(f64) -> f64) -> Array<N> {
        Array(std::array::from_fn(|i| f(self.0[i])))
    }

    #[inline(always)]
    fn with(self, other: Array<N>, f: impl Fn(f64, f64) -> f64) -> Array<N> {
        Array(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }

    #[inline(always)]
    fn question(self, other: Array<N>, f: impl Fn(f64, f64) -> bool) -> Bits<N> {
        let all = |i: usize| {
            if f(self.0[i], other.0[i]) {
                u64::MAX
            } else {
                0
            }
        };
        Bits(std::array::from_fn(all))
    }

    #[inline(always)]
    fn minus(self, other: Array<N>) -> Array<N> {
        self.with(other, |a, b| a - b)
    }

    /// The floats where the mask is set, 0 elsewhere.
    #[inline(always)]
    fn kept(self, mask: Bits<N>) -> Array<N> {
        Array(std::array::from_fn(|i| {
            f64::from_bits(self.0[i].to_bits() & mask.0[i])
        }))
    }

    /// The next float above where the mask is set; it is not set for 0, `+inf` and NaN.
    ///
    /// The bits of the floats of one sign are ordered as their magnitudes.
    #[inline(always)]
    fn raised(self, mask: Bits<N>) -> Array<N> {
        Array(std::array::from_fn(|i| {
            let bits = self.0[i].to_bits();
            let step = ((bits as i64) >> 63) as u64 | 1;
            f64::from_bits(bits.wrapping_add(step & mask.0[i]))
        }))
    }

    /// `a b - p`, as [`Elementwise::product_error`].
    #[inline(always)]
    fn product_error(self, other: Array<N>, p: Array<N>) -> Array<N> {
        Array(std::array::from_fn(|i| {
            f64::product_error(self.0[i], other.0[i], p.0[i])
        }))
    }

    /// `2^-480 < x < 2^480`
    #[inline(always)]
    fn is_ordinary(self) -> Bits<N> {
        self.question(self, |x, _| (x > LEAST) & (x < MOST))
    }
}

impl<const N: usize> Vector for Array<N> {
    type Mask = Bits<N>;
    type Upper = Nearest<N>;
    const WIDTH: usize = N;

    #[inline(never)]
    fn mul(a: &Interval8, b: &Interval8) -> Interval8 {
        basic::mul::<Self>(a, b)
    }

    #[inline(never)]
    fn scale(a: &Interval8, factor: Interval) -> Interval8 {
        basic::scale::<Self>(a, factor)
    }

    #[inline(never)]
    fn div(a: &Interval8, b: &Interval8) -> Interval8 {
        basic::div::<Self>(a, b)
    }

    #[inline(never)]
    fn sqr(a: &Interval8) -> Interval8 {
        basic::sqr::<Self>(a)
    }

    #[inline(never)]
    fn sqrt(a: &Interval8) -> Interval8 {
        basic::sqrt::<Self>(a)
    }

    #[inline(always)]
    fn load(from: &Floats, chunk: usize) -> Array<N> {
        Array(std::array::from_fn(|i| from[N * chunk + i]))
    }

    #[inline(always)]
    fn store(self, to: &mut Floats, chunk: usize) {
        for (i, x) in self.0.into_iter().enumerate() {
            to[N * chunk + i] = x;
        }
    }

    #[inline(always)]
    fn splat(x: f64) -> Array<N> {
        Array([x; N])
    }

    #[inline(always)]
    fn negated(self) -> Array<N> {
        self.each(|x| -x)
    }

    #[inline(always)]
    fn abs(self) -> Array<N> {
        self.each(f64::abs)
    }

    #[inline(always)]
    fn larger(self, other: Array<N>) -> Array<N> {
        self.with(other, crate::interval::larger)
    }

    #[inline(always)]
    fn smaller(self, other: Array<N>) -> Array<N> {
        self.with(other, crate::interval::smaller)
    }

    #[inline(always)]
    fn above(self, other: Array<N>) -> Bits<N> {
        self.question(other, |a, b| a > b)
    }

    #[inline(always)]
    fn at_most(self, other: Array<N>) -> Bits<N> {
        self.question(other, |a, b| a <= b)
    }

    #[inline(always)]
    fn equals(self, other: Array<N>) -> Bits<N> {
        self.question(other, |a, b| a == b)
    }

    #[inline(always)]
    fn both(a: Bits<N>, b: Bits<N>) -> Bits<N> {
        Bits(std::array::from_fn(|i| a.0[i] & b.0[i]))
    }

    #[inline(always)]
    fn either(a: Bits<N>, b: Bits<N>) -> Bits<N> {
        Bits(std::array::from_fn(|i| a.0[i] | b.0[i]))
    }

    #[inline(always)]
    fn without(a: Bits<N>, b: Bits<N>) -> Bits<N> {
        Bits(std::array::from_fn(|i| a.0[i] & !b.0[i]))
    }

    #[inline(always)]
    fn select(mask: Bits<N>, a: Array<N>, b: Array<N>) -> Array<N> {
        Array(std::array::from_fn(|i| {
            let kept = a.0[i].to_bits() & mask.0[i];
            f64::from_bits(kept | (b.0[i].to_bits() & !mask.0[i]))
        }))
    }

    #[inline(always)]
    fn bits(mask: Bits<N>) -> u32 {
        let mut bits = 0;
        for i in 0..N {
            bits |= ((mask.0[i] & 1) as u32) << i;
        }
        bits
    }

    #[inline(always)]
    fn mask(bits: u32) -> Bits<N> {
        Bits(std::array::from_fn(|i| {
            if bits >> i & 1 == 1 { u64::MAX } else { 0 }
        }))
    }

    #[inline(always)]
    fn floor(empty: Bits<N>) -> Array<N> {
        let (none, lowest) = (f64::NEG_INFINITY, f64::MIN);
        Array::select(empty, Array::splat(none), Array::splat(lowest))
    }

    #[inline(always)]
    fn or_lowest(self) -> Array<N> {
        self.larger(Array::splat(f64::MIN))
    }

    /// Knuth's TwoSum of the larger operand `p` and the smaller one `q`, for all finite operands.
    ///
    /// `s` is the nearest float to `p + q`, and the error `e` is exact if nothing overflows (sums
    /// below the normal range are exact). If `e > 0` the true sum lies strictly between `s` and the
    /// next float, and `s` is not zero.
    ///
    /// *Overflow.* An infinite `s` is not changed. Let it be finite.
    /// - Same signs: `s` is the one of largest magnitude, `s - p` and `s - (s - p)` lie between 0 and
    ///   `s`, and the differences from `p` and `q` are smaller.
    /// - `p >= 0 >= q`, so that `q <= s <= p`. `p - s` is `|q| + e` rounded, which overflows only if
    ///   `q = f64::MIN` and `e` is at least half the distance of the largest floats, hence positive;
    ///   then `s - p = -inf`, `p - inf = -inf`, `q + inf = inf`, and their sum is NaN: the step is
    ///   made for NaN. Otherwise `t = p - s` is finite. `s + t` cannot overflow for `s <= 0`; for
    ///   `s >= p / 2` the difference `t` is exact (Sterbenz), and `s + t = p`. For `0 < s < p / 2`
    ///   it is `|q| >= p / 2`, up to one bit, so `s = p + q` is exact (Sterbenz), hence `t = -q`
    ///   and `s + t = p`. The last differences are of the size of errors.
    ///
    #[inline(always)]
    fn sum_up(self, other: Array<N>) -> Array<N> {
        let (p, q) = (self.larger(other), self.smaller(other));
        let s = p.with(q, |p, q| p + q);
        let from_q = s.minus(p);
        let from_p = s.minus(from_q);
        let (first, second) = (p.minus(from_p), q.minus(from_q));
        let e = first.with(second, |a, b| a + b);
        let exact = e.at_most(Array::splat(0.0));
        let finite = Array::splat(f64::INFINITY).above(s.abs());
        s.raised(Self::without(finite, exact))
    }

    #[inline(always)]
    fn product(self, other: Array<N>) -> Nearest<N> {
        let value = self.with(other, |a, b| a * b);
        let error = self.product_error(other, value);
        Nearest { value, error }
    }

    #[inline(always)]
    fn negated_product(self, other: Array<N>) -> Nearest<N> {
        self.negated().product(other)
    }

    /// Where the nearest products are equal, the larger error tells whether the larger true product is
    /// above. Errors of the smaller one count as zero.
    #[inline(always)]
    fn larger_upper(a: Nearest<N>, b: Nearest<N>) -> Nearest<N> {
        let error_a = a.error.kept(b.value.at_most(a.value));
        let error_b = b.error.kept(a.value.at_most(b.value));
        Nearest {
            value: a.value.larger(b.value),
            error: error_a.larger(error_b),
        }
    }

    /// The requirements of [`Elementwise::product_error`], which a fused operation needs only below.
    ///
    /// With it a product that overflows to `+inf` has the error `-inf` or NaN and stays; one that
    /// is `-inf` stays or gives `f64::MIN`.
    #[inline(always)]
    fn proved<const M: usize>(
        mut products: [Nearest<N>; M],
        factors: [(Array<N>, Array<N>); M],
    ) -> ([Nearest<N>; M], u32) {
        const FACTOR: f64 = f64::from_bits((1023 + 995) << 52);
        const PRODUCT: f64 = f64::from_bits((1023 + 1000) << 52);
        let mut open = Self::mask(0);
        for (product, (x, y)) in products.iter_mut().zip(factors) {
            let value = product.value;
            let zero = x.question(y, |x, y| (x == 0.0) | (y == 0.0));
            let large = value.question(value, |p, _| p.abs() >= SMALL);
            let mut fine = Self::either(large, zero);
            if FUSED {
                let number = value.equals(value);
                fine = Self::either(fine, Self::without(zero, number));
                product.value = value.kept(number);
                product.error = product.error.kept(number);
            } else {
                let factors = x.question(y, |x, y| (x.abs() < FACTOR) & (y.abs() < FACTOR));
                let no_overflow = value.question(value, |p, _| p.abs() < PRODUCT);
                fine = Self::both(fine, Self::both(factors, no_overflow));
            }
            open = Self::either(open, Self::without(Self::mask(u32::MAX), fine));
        }
        (products, Self::bits(open))
    }

    /// The remainder `n - q d` has the sign of `n / d - q`; it is exact for ordinary operands and
    /// `n = 0` (`remainder` in `round::upward`).
    #[inline(always)]
    fn quotient(self, divisor: Array<N>) -> (Nearest<N>, Bits<N>) {
        let value = self.with(divisor, |n, d| n / d);
        let p = value.with(divisor, |q, d| q * d);
        let error = self.minus(p).minus(value.product_error(divisor, p));
        let dividend = Self::either(self.abs().is_ordinary(), self.equals(Array::splat(0.0)));
        let fine = Self::both(divisor.is_ordinary(), dividend);
        let open = Self::without(Self::mask(u32::MAX), fine);
        (Nearest { value, error }, open)
    }

    /// The remainder `a - s^2` has the sign of `sqrt(a) - s`, and is exact in the same way.
    #[inline(always)]
    fn root(self) -> (Nearest<N>, Bits<N>) {
        let value = self.each(f64::sqrt);
        let p = value.with(value, |s, t| s * t);
        let error = self.minus(p).minus(value.product_error(value, p));
        let fine = Self::either(self.is_ordinary(), self.equals(Array::splat(0.0)));
        let open = Self::without(Self::mask(u32::MAX), fine);
        (Nearest { value, error }, open)
    }

    #[inline(always)]
    fn negated_root(self) -> (Nearest<N>, Bits<N>) {
        let (root, open) = self.root();
        let negated = Nearest {
            value: root.value.negated(),
            error: root.error.negated(),
        };
        (negated, open)
    }

    #[inline(always)]
    fn round_up(value: Nearest<N>) -> Array<N> {
        value.value.raised(value.error.above(Array::splat(0.0)))
    }
}
