//! How far every register can be from what its instruction says.
//!
//! A register stands for the set of all functions of `(δ, s)` that differ from its polynomial by at most
//! its radius, pointwise for `δ` in the unit box and `s` in `[0, σ]`. The claim of this module: if the
//! states, parameters and inputs are such functions with the radii given, then the value of every
//! expression is one with the radius computed here. Since nothing is said about derivatives, the
//! functions need not even be continuous.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: registers and orders as in `series`"
)]

use super::code::{Code, Op};
use super::compose;
use super::convolve::convolve;
use super::function::Functions;
use super::monomials::Monomials;
use super::outward::{UNIT, is_lost, powers, raised};
use super::series::{Bend, Series};
use super::size::Size;
use super::step::Obstacle;
use veribound_interval::lanes::{Arithmetic, Kernel, Value};
use veribound_interval::{Interval, Interval8};

/// Why nothing can be said about a register.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Trouble {
    /// A function is not defined, or not smooth, somewhere on the set.
    Undefined,
    /// A `sign` that the rates depend on may change.
    Jump,
    /// Numbers became too large.
    Unbounded,
}

/// Measures all registers; a kernel only to be compiled for the instruction set of the processor.
struct Measure<'a> {
    sizes: &'a mut [Size],
    weights: &'a [f64],
    code: &'a Code,
    monomials: &'a Monomials,
    series: &'a Series,
    orders: (usize, usize),
}

impl Kernel<Interval8> for Measure<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic<Value = Interval8>>(self) {
        let steps = self.code.instructions.iter().enumerate();
        for ((register, step), size) in steps.zip(self.sizes) {
            let top = match (step.moving, step.primary) {
                (false, _) => 0,
                (true, true) => self.orders.0,
                (true, false) => self.orders.1,
            };
            size.measure(
                self.monomials,
                self.series.block(register),
                self.weights,
                top,
            );
        }
    }
}

impl From<Trouble> for Obstacle {
    fn from(trouble: Trouble) -> Obstacle {
        match trouble {
            Trouble::Undefined => Obstacle::Undefined,
            Trouble::Jump => Obstacle::Jump,
            Trouble::Unbounded => Obstacle::Unbounded,
        }
    }
}

/// Sizes of all registers, and what their own instructions lose.
#[derive(Debug, Clone)]
pub(super) struct Errors {
    /// Upper bounds of `σ^j`.
    pub(super) weights: Vec<f64>,
    pub(super) sizes: Vec<Size>,
    own: Vec<f64>,
    /// What absolute values and signs are taken for.
    bends: Vec<Bend>,
}

impl Errors {
    /// For registers with `stride` numbers per monomial.
    pub(super) fn new(code: &Code, monomials: &Monomials, stride: usize) -> Errors {
        let count = code.instructions.len();
        Errors {
            weights: vec![0.0; stride],
            sizes: vec![Size::new(monomials, stride); count],
            own: vec![0.0; count],
            bends: vec![Bend::default(); count],
        }
    }

    /// Sizes of all registers for `s` up to `span`, and what each instruction itself adds; `given` tells
    /// how far constants, parameters and inputs can be from their registers.
    #[inline(always)]
    pub(super) fn measure(
        &mut self,
        (code, monomials, functions): (&Code, &Monomials, &Functions),
        series: &Series,
        (span, orders, secondary): (f64, usize, usize),
        given: &dyn Fn(Op) -> f64,
    ) -> Result<(), Trouble> {
        powers(span, &mut self.weights);
        Interval8::run(Measure {
            sizes: &mut self.sizes,
            weights: &self.weights,
            code,
            monomials,
            series,
            orders: (orders, secondary),
        });
        if self.sizes.iter().any(|size| is_lost(size.total)) {
            return Err(Trouble::Unbounded);
        }
        for (register, step) in code.instructions.iter().enumerate() {
            let (sizes, own) = (&self.sizes, &self.sizes[register]);
            let rounded = raised(UNIT * own.total, 1);
            let certain = |a: usize| {
                let step = &code.instructions[a];
                !step.uncertain && !step.moving
            };
            // Orders of an operand beyond those of this register.
            let cut = |a: usize| match sizes[a].top > own.top {
                true => raised(sizes[a].time[own.top + 1..].iter().sum(), sizes[a].top),
                false => 0.0,
            };
            self.own[register] = match step.op {
                Op::Constant(_) | Op::Param(_) | Op::Input(_) => given(step.op),
                Op::State(_) | Op::Impulse(_) => 0.0,
                Op::Sign(a) => {
                    self.bends[register] = Bend::of(series.block(a), series.stride);
                    0.0
                }
                Op::Neg(a) => cut(a),
                Op::Abs(a) => {
                    let bend = Bend::of(series.block(a), series.stride);
                    self.bends[register] = bend;
                    // A sign alone rounds nothing.
                    let rounding = if bend.shift == 0.0 {
                        0.0
                    } else {
                        2.0 * rounded
                    };
                    raised(rounding + cut(a), 2)
                }
                Op::Add(a, b) | Op::Sub(a, b) => raised(rounded + cut(a) + cut(b), 2),
                Op::Mul(a, b) if certain(a) => raised(rounded + sizes[a].total * cut(b), 3),
                Op::Mul(a, b) if certain(b) => raised(rounded + sizes[b].total * cut(a), 3),
                Op::Mul(a, b) => sizes[a].product(&sizes[b], monomials, own.top),
                Op::Square(a) => sizes[a].product(&sizes[a], monomials, own.top),
                Op::Recip(a) => {
                    let blocks = (series.block(a), series.block(register));
                    self.recip_defect(monomials, blocks, (&sizes[a], own))
                }
                Op::Call {
                    function, operand, ..
                } => compose::defect(
                    (monomials, functions, &self.weights),
                    function,
                    (series.block(operand), &sizes[operand]),
                    (series.block(register), own.top),
                )
                .ok_or(Trouble::Undefined)?,
            };
        }
        Ok(())
    }

    /// `sup |1 - a z|` for the polynomial `z` that shall be `1 / a`.
    fn recip_defect(
        &self,
        monomials: &Monomials,
        (below, own): (&[f64], &[f64]),
        (size_below, size_own): (&Size, &Size),
    ) -> f64 {
        let (k, top) = (self.weights.len(), size_own.top);
        let mut sum = 0.0;
        for c in 0..monomials.len() {
            for j in 0..=top {
                let mut coefficient = 0.0;
                for &(x, y) in monomials.factors(c) {
                    let (x, y) = (x as usize * k, y as usize * k);
                    coefficient += convolve(&below[x..=x + j], &own[y..=y + j]);
                }
                if c == 0 && j == 0 {
                    coefficient -= 1.0;
                }
                sum += coefficient.abs() * self.weights[j];
            }
        }
        // Taking away the one is exact, or the product is not near it and a rounding does not matter.
        let kept = raised(sum, monomials.len() * (top + 1) + 4);
        raised(kept + size_below.product(size_own, monomials, top), 1)
    }

    /// The radius of every register, when states have the radii `states`.
    pub(super) fn radii(
        &self,
        code: &Code,
        functions: &Functions,
        states: &[f64],
        radii: &mut [f64],
    ) -> Result<(), Trouble> {
        for (register, step) in code.instructions.iter().enumerate() {
            let (own, sizes) = (self.own[register], &self.sizes);
            // Half the width of the range of a register around its constant.
            let reach = |a: usize, radii: &[f64]| raised(sizes[a].deviation + radii[a], 1);
            let radius = match step.op {
                Op::Constant(_) | Op::Param(_) | Op::Input(_) => own,
                Op::State(i) => states[i],
                Op::Neg(a) => raised(own + radii[a], 1),
                Op::Add(a, b) | Op::Sub(a, b) => raised(own + radii[a] + radii[b], 2),
                Op::Mul(a, b) => {
                    let (x, y) = (radii[a], radii[b]);
                    let cross = sizes[a].total * y + sizes[b].total * x + x * y;
                    raised(own + cross, 6)
                }
                Op::Square(a) => {
                    let x = radii[a];
                    raised(own + (2.0 * sizes[a].total + x) * x, 4)
                }
                // 1/(a + e) - z = (1 - a z - e z) / (a + e)
                Op::Recip(a) => {
                    let least = sizes[a].centre.abs() - reach(a, radii);
                    let least = least * (1.0 - 4.0 * UNIT);
                    if least.is_nan() || least <= 0.0 {
                        return Err(Trouble::Undefined);
                    }
                    raised((own + radii[a] * sizes[register].total) / least, 6)
                }
                // |g(a + e) - g(a)| <= |e| sup |g'|
                Op::Call {
                    function, operand, ..
                } => {
                    let centre = Interval::point(sizes[operand].centre);
                    let range = centre.inflate(reach(operand, radii));
                    let list = functions.expand(function, range, 1);
                    let list = list.ok_or(Trouble::Undefined)?;
                    let steepest = list.get(1).map_or(f64::INFINITY, |slope| slope.mag());
                    raised(own + radii[operand] * steepest, 3)
                }
                // |y| - (m a + c) = (|y| - m y - c) + m (y - a) with |m| <= 1 for the true value y.
                Op::Abs(a) => {
                    let (centre, reach) = (sizes[a].centre, reach(a, radii));
                    let (lo, hi) = (centre - reach, centre + reach);
                    raised(own + radii[a] + self.bends[register].error(lo, hi), 2)
                }
                Op::Impulse(a) if reach(a, radii) < sizes[a].centre.abs() => 0.0,
                Op::Impulse(_) => return Err(Trouble::Jump),
                Op::Sign(a) => {
                    let decided = reach(a, radii) < sizes[a].centre.abs();
                    match (decided, step.primary) {
                        (true, _) => 0.0,
                        // Stands in a derivative only: the generalised one.
                        (false, false) => raised(1.0 + self.bends[register].slope.abs(), 1),
                        (false, true) => return Err(Trouble::Jump),
                    }
                }
            };
            if is_lost(radius) {
                return Err(Trouble::Unbounded);
            }
            radii[register] = radius;
        }
        Ok(())
    }
}
