//! What a loop over interval operations is written against.

use super::Lanewise;
use crate::Interval;

/// One interval, or several side by side: what registers of an evaluator hold.
///
/// Example: [`Kernel`].
pub trait Value: Copy + PartialEq + std::fmt::Debug + Send + Sync + 'static {
    /// One truth value per lane.
    type Mask: Lanewise;

    /// The same interval in every lane.
    fn splat(x: Interval) -> Self;

    /// Runs a kernel on the arithmetic that is the fastest here.
    fn run<K: Kernel<Self>>(kernel: K) -> K::Output;
}

/// A loop over interval operations, written once for all values and instruction sets.
///
/// ```
/// use veribound_interval::lanes::{Arithmetic, Kernel, MaskOf, Value};
/// use veribound_interval::{Interval, Interval8};
///
/// /// Where `x² - x` may be zero.
/// struct Zero<V>(V);
///
/// impl<V: Value> Kernel<V> for Zero<V> {
///     type Output = V::Mask;
///
///     #[inline(always)]
///     fn run<A: Arithmetic<Value = V>>(self) -> MaskOf<A> {
///         A::contains_zero(&A::sub(&A::sqr(&self.0), &self.0))
///     }
/// }
///
/// let x = Interval8::from_fn(|lane| Interval::point(lane as f64));
/// assert_eq!(Interval8::run(Zero(x)).bits(), 0b11);
/// assert!(Interval::run(Zero(Interval::ONE)));
/// ```
pub trait Kernel<V: Value> {
    /// What the loop returns.
    type Output;

    /// The loop. It has to be `#[inline(always)]`, as everything it calls that contains
    /// operations of `A`: only what is inlined is compiled for the instruction set.
    fn run<A: Arithmetic<Value = V>>(self) -> Self::Output;
}

/// The masks of an [`Arithmetic`].
///
/// Example: [`Kernel`].
pub type MaskOf<A> = <<A as Arithmetic>::Value as Value>::Mask;

/// The operations on a [`Value`], for one instruction set.
///
/// *Guarantee*: lane by lane the result of the operation of [`Interval`] with the same name, to the
/// bit (the sign of a zero end aside).
///
/// Example: [`Kernel`].
pub trait Arithmetic {
    /// What it works on.
    type Value: Value;

    /// `-a`
    fn neg(a: &Self::Value) -> Self::Value;
    /// `a + b`
    fn add(a: &Self::Value, b: &Self::Value) -> Self::Value;
    /// `a - b`
    fn sub(a: &Self::Value, b: &Self::Value) -> Self::Value;
    /// `a * b`
    fn mul(a: &Self::Value, b: &Self::Value) -> Self::Value;
    /// `a * factor`, the same factor in every lane: the cheaper one if it is not negative.
    fn scale(a: &Self::Value, factor: Interval) -> Self::Value;
    /// `a / b`
    fn div(a: &Self::Value, b: &Self::Value) -> Self::Value;
    /// [`Interval::sqr`]
    fn sqr(a: &Self::Value) -> Self::Value;
    /// [`Interval::sqrt`]
    fn sqrt(a: &Self::Value) -> Self::Value;
    /// [`Interval::abs`]
    fn abs(a: &Self::Value) -> Self::Value;
    /// [`Interval::sign`]
    fn sign(a: &Self::Value) -> Self::Value;
    /// [`Interval::powi`]
    fn powi(a: &Self::Value, n: i32) -> Self::Value;
    /// [`Interval::min`]
    fn min(a: &Self::Value, b: &Self::Value) -> Self::Value;
    /// [`Interval::max`]
    fn max(a: &Self::Value, b: &Self::Value) -> Self::Value;
    /// [`Interval::exp`]
    fn exp(a: &Self::Value) -> Self::Value;
    /// [`Interval::ln`]
    fn ln(a: &Self::Value) -> Self::Value;
    /// [`Interval::sin`]
    fn sin(a: &Self::Value) -> Self::Value;
    /// [`Interval::cos`]
    fn cos(a: &Self::Value) -> Self::Value;
    /// [`Interval::tan`]
    fn tan(a: &Self::Value) -> Self::Value;
    /// [`Interval::atan`]
    fn atan(a: &Self::Value) -> Self::Value;
    /// [`Interval::tanh`]
    fn tanh(a: &Self::Value) -> Self::Value;
    /// [`Interval::intersect`]
    fn intersect(a: &Self::Value, b: &Self::Value) -> Self::Value;
    /// [`Interval::hull`]
    fn hull(a: &Self::Value, b: &Self::Value) -> Self::Value;
    /// [`Interval::is_empty`]
    fn is_empty(a: &Self::Value) -> MaskOf<Self>;
    /// `lo > 0`
    fn is_positive(a: &Self::Value) -> MaskOf<Self>;
    /// 0 is an element.
    fn contains_zero(a: &Self::Value) -> MaskOf<Self>;
    /// `a` in the lanes of the mask, `b` elsewhere.
    fn select(mask: MaskOf<Self>, a: &Self::Value, b: &Self::Value) -> Self::Value;
    /// Any other operation, lane by lane.
    fn map(a: &Self::Value, f: impl Fn(Interval) -> Interval) -> Self::Value;
    /// Any other operation of two arguments, lane by lane.
    fn map2(
        a: &Self::Value,
        b: &Self::Value,
        f: impl Fn(Interval, Interval) -> Interval,
    ) -> Self::Value;
    /// Any other operation of three arguments, lane by lane.
    fn map3(
        a: &Self::Value,
        b: &Self::Value,
        c: &Self::Value,
        f: impl Fn(Interval, Interval, Interval) -> Interval,
    ) -> Self::Value;
    /// A question, lane by lane.
    fn test(a: &Self::Value, f: impl Fn(Interval) -> bool) -> MaskOf<Self>;
    /// A question of two arguments, lane by lane.
    fn test2(
        a: &Self::Value,
        b: &Self::Value,
        f: impl Fn(Interval, Interval) -> bool,
    ) -> MaskOf<Self>;
}
