//! What the proofs in `upward` ask of numbers: one float, or two side by side ([`super::Pair`]).

/// A fixed number of floats with elementwise round-to-nearest arithmetic.
pub(crate) trait Elementwise: Copy {
    /// One truth value per float.
    type Mask: Copy;

    fn splat(x: f64) -> Self;
    fn plus(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
    fn over(self, other: Self) -> Self;
    fn root(self) -> Self;
    fn negated(self) -> Self;
    fn abs(self) -> Self;
    /// `self > other`, false for NaN.
    fn above(self, other: Self) -> Self::Mask;
    /// `self == other`, false for NaN.
    fn equals(self, other: Self) -> Self::Mask;
    /// The floats where the mask is set, 0 elsewhere.
    fn kept(self, mask: Self::Mask) -> Self;
    fn both(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    fn either(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    fn all(mask: Self::Mask) -> bool;

    /// `a b - p` without error, for `p` the product rounded to nearest.
    ///
    /// Required of each float: `|a|, |b| < 2^995`, and `2^-962 <= |a b| < 2^1001` or a factor 0.
    ///
    /// Proof (Dekker's product with Veltkamp's splitting). `split` gives `x = h + l` exactly, where
    /// `h` and `l` have at most 26 significant bits; `(2^27 + 1) x` does not overflow. The partial
    /// products have at most 52 bits and are multiples of `ulp(a) ulp(b) > |a b| 2^-106 >= 2^-1068`,
    /// a multiple of the smallest subnormal, so they are exact. The four sums are exact by Dekker's
    /// theorem and end with `a b - p`. A factor 0 makes every term 0.
    #[cfg(not(any(target_feature = "fma", target_arch = "aarch64")))]
    #[inline(always)]
    fn product_error(a: Self, b: Self, p: Self) -> Self {
        let (ah, al) = a.split();
        let (bh, bl) = b.split();
        let rest = ah.times(bh).minus(p).plus(ah.times(bl)).plus(al.times(bh));
        rest.plus(al.times(bl))
    }

    /// The same by the fused instruction, where it is part of the compilation target and therefore
    /// never a library call: `a b - p` is representable, and one rounding leaves it as it is.
    #[cfg(any(target_feature = "fma", target_arch = "aarch64"))]
    fn product_error(a: Self, b: Self, p: Self) -> Self;

    /// High and low half of the significand.
    #[cfg(not(any(target_feature = "fma", target_arch = "aarch64")))]
    #[inline(always)]
    fn split(self) -> (Self, Self) {
        let scaled = Self::splat(134_217_729.0).times(self);
        let high = scaled.minus(scaled.minus(self));
        (high, self.minus(high))
    }
}

impl Elementwise for f64 {
    type Mask = bool;

    #[inline(always)]
    fn splat(x: f64) -> f64 {
        x
    }

    #[inline(always)]
    fn plus(self, other: f64) -> f64 {
        self + other
    }

    #[inline(always)]
    fn minus(self, other: f64) -> f64 {
        self - other
    }

    #[inline(always)]
    fn times(self, other: f64) -> f64 {
        self * other
    }

    #[inline(always)]
    fn over(self, other: f64) -> f64 {
        self / other
    }

    #[inline(always)]
    fn root(self) -> f64 {
        self.sqrt()
    }

    #[inline(always)]
    fn negated(self) -> f64 {
        -self
    }

    #[inline(always)]
    fn abs(self) -> f64 {
        f64::abs(self)
    }

    #[inline(always)]
    fn above(self, other: f64) -> bool {
        self > other
    }

    #[inline(always)]
    fn equals(self, other: f64) -> bool {
        self == other
    }

    #[inline(always)]
    fn kept(self, mask: bool) -> f64 {
        if mask { self } else { 0.0 }
    }

    #[inline(always)]
    fn both(a: bool, b: bool) -> bool {
        a & b
    }

    #[inline(always)]
    fn either(a: bool, b: bool) -> bool {
        a | b
    }

    #[inline(always)]
    fn all(mask: bool) -> bool {
        mask
    }

    #[cfg(any(target_feature = "fma", target_arch = "aarch64"))]
    #[inline(always)]
    fn product_error(a: f64, b: f64, p: f64) -> f64 {
        a.mul_add(b, -p)
    }
}
