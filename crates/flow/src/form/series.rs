//! Polynomials in time and in the unknowns, in plain floating point: only hints.
//!
//! Every register holds a polynomial `Σ v[a][j] δ^a s^j` in the normalised unknowns `δ` and the scaled
//! time `s`. What is computed here is no claim; [`super::error`] bounds how far each register is from
//! what its instruction says, whatever numbers stand here.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: a register owns `monomials * stride` numbers; orders stay below the stride"
)]

use super::code::{Code, Op};
use super::convolve::{LANES, convolve_rows};
use super::function::Functions;
use super::monomials::Monomials;
use super::outward::{UNIT, raised};
use veribound_interval::lanes::{Arithmetic, Kernel};
use veribound_interval::{Interval, Interval8};

/// The registers of a [`Code`].
#[derive(Debug, Clone)]
pub(super) struct Series {
    /// Numbers per monomial: one for every order in time, and some to make whole vectors.
    pub(super) stride: usize,
    monomials: usize,
    values: Vec<f64>,
    /// The same with the orders of every monomial backwards, and zeros behind: a convolution is then a
    /// scalar product of whole vectors. Only of registers that are convolved so,
    backwards: Vec<f64>,
    /// which begin here.
    turned: Vec<Option<usize>>,
    row: Vec<f64>,
    other: Vec<f64>,
    still: Vec<f64>,
}

/// What an absolute value is taken for: `slope * y + shift`.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Bend {
    pub(super) slope: f64,
    pub(super) shift: f64,
}

impl Bend {
    /// That of the polynomial in `block` at time zero. Where it has one sign, this is exact; else the straight
    /// line that is nowhere farther from the absolute value than half of the way from the kink to the secant.
    #[inline(always)]
    pub(super) fn of(block: &[f64], stride: usize) -> Bend {
        let centre = block[0];
        let spread: f64 = block[stride..]
            .iter()
            .step_by(stride)
            .map(|x| x.abs())
            .sum();
        if spread > centre.abs() && spread.is_finite() {
            let (above, below) = (spread + centre, spread - centre);
            Bend {
                slope: centre / spread,
                shift: 0.5 * above * (below / spread),
            }
        } else {
            let slope = if centre < 0.0 { -1.0 } else { 1.0 };
            Bend { slope, shift: 0.0 }
        }
    }

    /// How far it is from the absolute value for `y` from `lo` to `hi`: the difference is linear on both sides
    /// of zero. The bounds may be off by a rounding.
    pub(super) fn error(self, lo: f64, hi: f64) -> f64 {
        let at = |y: f64| {
            let line = self.slope * y + self.shift;
            let size = y.abs() + (self.slope * y).abs() + self.shift.abs();
            (y.abs() - line).abs() + 4.0 * UNIT * size
        };
        let kink = if lo <= 0.0 && hi >= 0.0 {
            self.shift.abs()
        } else {
            0.0
        };
        let exact = (self.slope >= 1.0 && lo >= 0.0) || (self.slope <= -1.0 && hi <= 0.0);
        if exact && self.shift == 0.0 {
            return 0.0;
        }
        raised(at(lo).max(at(hi)).max(kink), 4)
    }
}

/// A function was asked for where it is not defined.
pub(super) struct Undefined;

impl Series {
    pub(super) fn new(code: &Code, monomials: &Monomials, orders: usize) -> Series {
        let (stride, count) = ((orders + 1).next_multiple_of(LANES), monomials.len());
        let registers = code.instructions.len();
        let mut is_turned = vec![false; registers];
        for (register, step) in code.instructions.iter().enumerate() {
            match step.op {
                Op::Mul(a, b) => {
                    let both = [a, b].map(|x| code.instructions[x].moving);
                    is_turned[b] |= both == [true, true];
                }
                Op::Square(a) => is_turned[a] = true,
                Op::Recip(_) => is_turned[register] = true,
                _ => {}
            }
        }
        let size = count * (stride + LANES);
        let mut length = 0;
        let turned = is_turned.into_iter().map(|is_turned| {
            is_turned.then(|| {
                length += size;
                length - size
            })
        });
        Series {
            turned: turned.collect(),
            stride,
            monomials: count,
            values: vec![0.0; registers * count * stride],
            backwards: vec![0.0; length],
            row: vec![0.0; count],
            other: vec![0.0; count],
            still: vec![0.0; count],
        }
    }

    /// Coefficients of `register`: `stride` of every monomial.
    #[inline(always)]
    pub(super) fn block(&self, register: usize) -> &[f64] {
        let size = self.monomials * self.stride;
        &self.values[register * size..(register + 1) * size]
    }

    #[inline(always)]
    fn backwards(&self, register: usize) -> &[f64] {
        let size = self.monomials * (self.stride + LANES);
        // PROOF: what is convolved so is listed when the registers are made.
        let begin = self.turned[register].unwrap_or(0);
        &self.backwards[begin..begin + size]
    }

    #[inline(always)]
    fn backwards_mut(&mut self, register: usize) -> Option<&mut [f64]> {
        let size = self.monomials * (self.stride + LANES);
        let begin = self.turned[register]?;
        Some(&mut self.backwards[begin..begin + size])
    }

    /// Forgets everything but order 0 of what does not move.
    pub(super) fn clear(&mut self, code: &Code) {
        for (register, step) in code.instructions.iter().enumerate() {
            if step.moving {
                self.block_mut(register).fill(0.0);
                if let Some(block) = self.backwards_mut(register) {
                    block.fill(0.0);
                }
            }
        }
    }

    #[inline(always)]
    fn block_mut(&mut self, register: usize) -> &mut [f64] {
        let size = self.monomials * self.stride;
        &mut self.values[register * size..(register + 1) * size]
    }

    /// Puts the coefficients of order 0 of `register`.
    pub(super) fn start(&mut self, register: usize, polynomial: &[f64]) {
        let stride = self.stride;
        let block = self.block_mut(register);
        for (slot, value) in block.chunks_exact_mut(stride).zip(polynomial) {
            slot[0] = *value;
        }
        if let Some(block) = self.backwards_mut(register) {
            for (slot, value) in block.chunks_exact_mut(stride + LANES).zip(polynomial) {
                slot[stride - 1] = *value;
            }
        }
    }

    #[inline(always)]
    fn store(&mut self, register: usize, order: usize, row: &[f64]) {
        let (stride, size) = (self.stride, self.monomials * self.stride);
        let block = &mut self.values[register * size..(register + 1) * size];
        for (slot, value) in block.chunks_exact_mut(stride).zip(row) {
            slot[order] = *value;
        }
        if let Some(block) = self.backwards_mut(register) {
            for (slot, value) in block.chunks_exact_mut(stride + LANES).zip(row) {
                slot[stride - 1 - order] = *value;
            }
        }
    }

    /// Computes order `j` of everything, from the orders up to `j` of the states; registers that are not
    /// primary only up to order `secondary`.
    #[inline(always)]
    pub(super) fn compute(
        &mut self,
        (code, monomials, functions): (&Code, &Monomials, &Functions),
        (j, secondary): (usize, usize),
    ) -> Result<(), Undefined> {
        let (mut row, mut other, mut still) = (
            std::mem::take(&mut self.row),
            std::mem::take(&mut self.other),
            std::mem::take(&mut self.still),
        );
        let result = self.rows(
            (code, monomials, functions),
            (j, secondary),
            &mut row,
            (&mut other, &mut still),
        );
        (self.row, self.other, self.still) = (row, other, still);
        result
    }

    #[inline(always)]
    fn rows(
        &mut self,
        (code, monomials, functions): (&Code, &Monomials, &Functions),
        (j, secondary): (usize, usize),
        row: &mut [f64],
        (other, still): (&mut [f64], &mut [f64]),
    ) -> Result<(), Undefined> {
        let k = self.stride;
        for (register, step) in code.instructions.iter().enumerate() {
            if (j > 0 && !step.moving) || (!step.primary && j > secondary) {
                continue;
            }
            let moves = |a: usize| code.instructions[a].moving;
            match step.op {
                Op::State(_) | Op::Param(_) | Op::Input(_) | Op::Constant(_) => continue,
                Op::Add(a, b) => {
                    let (a, b) = (self.block(a), self.block(b));
                    for (c, slot) in row.iter_mut().enumerate() {
                        *slot = a[c * k + j] + b[c * k + j];
                    }
                }
                Op::Sub(a, b) => {
                    let (a, b) = (self.block(a), self.block(b));
                    for (c, slot) in row.iter_mut().enumerate() {
                        *slot = a[c * k + j] - b[c * k + j];
                    }
                }
                Op::Neg(a) => {
                    let a = self.block(a);
                    for (c, slot) in row.iter_mut().enumerate() {
                        *slot = -a[c * k + j];
                    }
                }
                Op::Mul(a, b) => {
                    let resting = if !moves(a) {
                        Some((a, b))
                    } else if !moves(b) {
                        Some((b, a))
                    } else {
                        None
                    };
                    match resting {
                        Some((a, b)) if !code.instructions[a].uncertain => {
                            let (factor, b) = (self.block(a)[0], self.block(b));
                            for (c, slot) in row.iter_mut().enumerate() {
                                *slot = factor * b[c * k + j];
                            }
                        }
                        Some((a, b)) => {
                            // Side by side: it is most of the work where modes are affine.
                            let (a, b) = (self.block(a), self.block(b));
                            for (slot, a) in still.iter_mut().zip(a.chunks_exact(k)) {
                                *slot = a[0];
                            }
                            for (slot, b) in other.iter_mut().zip(b.chunks_exact(k)) {
                                *slot = b[j];
                            }
                            // Pairs stand in the order of their first factors, and the first of all is the constant.
                            let last = still.iter().rposition(|x| *x != 0.0).unwrap_or(0);
                            for (slot, b) in row.iter_mut().zip(&*other) {
                                *slot = still[0] * b;
                            }
                            for (c, slot) in row.iter_mut().enumerate() {
                                let mut sum = *slot;
                                for &(x, y) in &monomials.factors(c)[1..] {
                                    if x as usize > last {
                                        break;
                                    }
                                    sum += still[x as usize] * other[y as usize];
                                }
                                *slot = sum;
                            }
                        }
                        None => {
                            convolve_rows(monomials, self.block(a), self.backwards(b), (k, j), row);
                        }
                    }
                }
                Op::Square(a) => {
                    convolve_rows(monomials, self.block(a), self.backwards(a), (k, j), row);
                }
                Op::Recip(a) => {
                    if j == 0 {
                        if let Some(block) = self.backwards_mut(register) {
                            block.fill(0.0);
                        }
                        let below = self.block(a);
                        let centre = below[0];
                        if centre == 0.0 {
                            return Err(Undefined);
                        }
                        let mut next = 1.0 / centre;
                        let coefficients: Vec<f64> = (0..=monomials.degree)
                            .map(|_| {
                                let now = next;
                                next = -now / centre;
                                now
                            })
                            .collect();
                        compose(monomials, &coefficients, below, k, row, other);
                    } else {
                        let (below, own) = (self.block(a), self.block(register));
                        // The order that is not known yet stands as zero.
                        let known = self.backwards(register);
                        convolve_rows(monomials, below, known, (k, j), other);
                        for (c, slot) in row.iter_mut().enumerate() {
                            let factors = monomials.factors(c).iter();
                            *slot = -factors
                                .map(|&(x, y)| own[x as usize * k] * other[y as usize])
                                .sum::<f64>();
                        }
                    }
                }
                Op::Call {
                    function,
                    operand,
                    slope,
                } => {
                    let inner = self.block(operand);
                    if j == 0 {
                        let centre = Interval::point(inner[0]);
                        let coefficients: Vec<f64> = functions
                            .expand(function, centre, monomials.degree)
                            .ok_or(Undefined)?
                            .into_iter()
                            .map(Interval::mid)
                            .collect();
                        compose(monomials, &coefficients, self.block(operand), k, row, other);
                    } else {
                        let slope = self.block(slope);
                        for (c, slot) in row.iter_mut().enumerate() {
                            let mut sum = 0.0;
                            for &(x, y) in monomials.factors(c) {
                                let (x, y) = (x as usize * k, y as usize * k);
                                for i in 1..=j {
                                    sum += i as f64 * inner[x + i] * slope[y + j - i];
                                }
                            }
                            *slot = sum / j as f64;
                        }
                    }
                }
                Op::Abs(a) => {
                    let a = self.block(a);
                    let Bend { slope, shift } = Bend::of(a, k);
                    for (c, slot) in row.iter_mut().enumerate() {
                        *slot = slope * a[c * k + j];
                    }
                    if j == 0 {
                        row[0] += shift;
                    }
                }
                Op::Impulse(_) => row.fill(0.0),
                Op::Sign(a) => {
                    row.fill(0.0);
                    row[0] = Bend::of(self.block(a), k).slope;
                }
            }
            self.store(register, j, row);
        }
        Ok(())
    }

    /// Order `j + 1` of a state from order `j` of its rate, both in scaled time.
    #[inline(always)]
    fn integrate(&mut self, state: usize, rate: usize, j: usize, unit: f64) {
        let (k, factor) = (self.stride, unit / (j + 1) as f64);
        let mut row = std::mem::take(&mut self.row);
        for (slot, rate) in row.iter_mut().zip(self.block(rate).chunks_exact(k)) {
            *slot = factor * rate[j];
        }
        self.store(state, j + 1, &row);
        self.row = row;
    }
}

/// `Σ g_m (a - a_0)^m` for the polynomial `a` in the unknowns that is order 0 of a register, by
/// Horner's rule.
fn compose(
    monomials: &Monomials,
    coefficients: &[f64],
    a: &[f64],
    stride: usize,
    row: &mut [f64],
    other: &mut [f64],
) {
    row.fill(0.0);
    for g in coefficients.iter().rev() {
        for (c, slot) in other.iter_mut().enumerate() {
            let factors = monomials.factors(c).iter();
            *slot = factors
                .filter(|(x, _)| *x > 0)
                .map(|&(x, y)| a[x as usize * stride] * row[y as usize])
                .sum();
        }
        row.copy_from_slice(other);
        row[0] += g;
    }
}

/// Coefficients of the solution that starts with order 0 of the states.
pub(super) struct Recursion<'a> {
    pub(super) series: &'a mut Series,
    pub(super) context: (&'a Code, &'a Monomials, &'a Functions),
    /// States that move, each with its rate.
    pub(super) rates: &'a [(usize, usize)],
    /// Highest order, and highest order of what is not primary.
    pub(super) orders: (usize, usize),
    /// Length of the unit of time.
    pub(super) unit: f64,
}

/// A kernel only to be compiled for the instruction set of the processor.
impl Kernel<Interval8> for Recursion<'_> {
    type Output = Result<(), Undefined>;

    #[inline(always)]
    fn run<A: Arithmetic<Value = Interval8>>(self) -> Result<(), Undefined> {
        let (orders, secondary) = self.orders;
        for j in 0..=orders {
            self.series.compute(self.context, (j, secondary))?;
            if j < orders {
                for (state, rate) in self.rates {
                    self.series.integrate(*state, *rate, j, self.unit);
                }
            }
        }
        Ok(())
    }
}
