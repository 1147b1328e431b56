//! Taylor coefficients in time of expressions along a trajectory.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: registers as in `tape`; every register owns `stride` coefficients, and the \
              order asked for is below `stride`"
)]

use crate::graph::{Binary, ExprId, Graph, Unary, jump};
use crate::regular::Regular;
use crate::tape::{Branches, Compiler, Instruction, Layout, Op, Tape, choose, decided};
use veribound_interval::lanes::{Arithmetic, Kernel, Lanewise, MaskOf, Value};
use veribound_interval::{Interval, Regularity, domain};

/// A tape that evaluates Taylor coefficients in time.
///
/// States are series; parameters and inputs are constants. Source: the classical recurrences of
/// automatic differentiation in Taylor arithmetic (Moore 1966).
///
/// ```
/// use veribound_interval::Interval;
/// use veribound_interval::lanes::{Arithmetic, Kernel, Value};
/// use veribound_model::{Coefficients, Graph, Layout, SeriesTape, Var};
///
/// let layout = Layout { states: 1, params: 0, inputs: 0 };
/// let mut graph = Graph::default();
/// let x = graph.var(Var::State(0));
/// let square = graph.powi(x, 2);
/// let tape = SeriesTape::compile(&graph, layout, &[square]);
///
/// /// The square of `3 + 2 t`.
/// struct Square<'t>(&'t SeriesTape);
///
/// impl Kernel<Interval> for Square<'_> {
///     type Output = [Interval; 3];
///
///     #[inline(always)]
///     fn run<A: Arithmetic<Value = Interval>>(self) -> [Interval; 3] {
///         let mut series: Coefficients<Interval> = self.0.coefficients(2);
///         self.0.set_quantity(0, 0, Interval::point(3.0), &mut series);
///         self.0.set_quantity(0, 1, Interval::point(2.0), &mut series);
///         for order in 0..=2 {
///             self.0.compute::<A>(order, &mut series);
///         }
///         [0, 1, 2].map(|order| self.0.output(0, order, &series))
///     }
/// }
///
/// // 9 + 12 t + 4 t²
/// assert_eq!(Interval::run(Square(&tape)), [9.0, 12.0, 4.0].map(Interval::point));
/// ```
#[derive(Debug, Clone)]
pub struct SeriesTape {
    tape: Tape,
}

/// The coefficients of every register of one [`SeriesTape`], on one box or on eight side by side.
///
/// Example: [`SeriesTape`].
#[derive(Debug, Clone)]
pub struct Coefficients<V> {
    stride: usize,
    values: Vec<V>,
}

impl<V: Value> Coefficients<V> {
    #[inline(always)]
    fn at(&self, register: u32, order: usize) -> &V {
        &self.values[register as usize * self.stride + order]
    }

    #[inline(always)]
    fn set(&mut self, register: u32, order: usize, value: V) {
        self.values[register as usize * self.stride + order] = value;
    }

    /// `Σ a_j b_(k-j)` for `j` from `from` to `to`, both included.
    #[inline(always)]
    fn convolve<A: Arithmetic<Value = V>>(
        &self,
        a: u32,
        b: u32,
        k: usize,
        from: usize,
        to: usize,
    ) -> V {
        let mut sum = V::splat(Interval::ZERO);
        for j in from..=to {
            sum = A::add(&sum, &A::mul(self.at(a, j), self.at(b, k - j)));
        }
        sum
    }

    /// `Σ j a_j b_(k-j) / k` for `j` from 1 to `to`: coefficient of `∫ a' b`.
    #[inline(always)]
    fn integrate<A: Arithmetic<Value = V>>(&self, a: u32, b: u32, k: usize, to: usize) -> V {
        let mut sum = V::splat(Interval::ZERO);
        for j in 1..=to {
            let weighted = A::mul(&number::<V>(j), self.at(a, j));
            sum = A::add(&sum, &A::mul(&weighted, self.at(b, k - j)));
        }
        if k == 1 {
            sum
        } else {
            A::div(&sum, &number::<V>(k))
        }
    }

    /// Coefficient `k > 0` of `out = a^exponent`, from `a out' = exponent out a'`.
    #[inline(always)]
    fn power<A: Arithmetic<Value = V>>(&self, a: u32, out: u32, exponent: &V, k: usize) -> V {
        let known = self.integrate::<A>(out, a, k, k - 1);
        let grows = A::mul(exponent, &self.integrate::<A>(a, out, k, k));
        A::div(&A::sub(&grows, &known), self.at(a, 0))
    }

    /// Coefficient `k` of `a²`; symmetric pairs are taken once so that squares stay tight.
    #[inline(always)]
    fn square<A: Arithmetic<Value = V>>(&self, a: u32, k: usize) -> V {
        let mut sum = V::splat(Interval::ZERO);
        for j in 0..k.div_ceil(2) {
            sum = A::add(&sum, &A::mul(self.at(a, j), self.at(a, k - j)));
        }
        sum = A::mul(&number::<V>(2), &sum);
        if k.is_multiple_of(2) {
            A::add(&sum, &A::sqr(self.at(a, k / 2)))
        } else {
            sum
        }
    }
}

#[inline(always)]
fn number<V: Value>(x: usize) -> V {
    V::splat(Interval::point(x as f64))
}

impl SeriesTape {
    /// A tape whose outputs are `roots`, in order.
    pub fn compile(graph: &Graph, layout: Layout, roots: &[ExprId]) -> SeriesTape {
        SeriesTape {
            tape: Compiler::compile(graph, layout, roots, true),
        }
    }

    /// Coefficients up to `order` for this tape, with its constants in place.
    pub fn coefficients<V: Value>(&self, order: usize) -> Coefficients<V> {
        let stride = order + 1;
        let values = vec![V::splat(Interval::ZERO); self.tape.register_count * stride];
        let mut coefficients = Coefficients { stride, values };
        for &(register, value) in &self.tape.constants {
            coefficients.set(register, 0, V::splat(value));
        }
        coefficients
    }

    /// The quantities the outputs depend on, in the order of the [`Layout`]; pass each one's
    /// coefficients to [`SeriesTape::set_quantity`] by its position here.
    pub fn quantities(&self) -> impl Iterator<Item = usize> + '_ {
        self.tape
            .quantities
            .iter()
            .map(|&(_, quantity)| quantity as usize)
    }

    /// Sets coefficient `order` of the quantity at `position` of [`SeriesTape::quantities`].
    pub fn set_quantity<V: Value>(
        &self,
        position: usize,
        order: usize,
        value: V,
        coefficients: &mut Coefficients<V>,
    ) {
        coefficients.set(self.tape.quantities[position].0, order, value);
    }

    /// Coefficient 0 of the quantity at `position`, as it was set.
    pub fn quantity<'a, V: Value>(
        &self,
        position: usize,
        coefficients: &'a mut Coefficients<V>,
    ) -> &'a mut V {
        let register = self.tape.quantities[position].0 as usize;
        &mut coefficients.values[register * coefficients.stride]
    }

    /// Coefficient `order` of output `index`, once computed.
    pub fn output<V: Value>(
        &self,
        index: usize,
        order: usize,
        coefficients: &Coefficients<V>,
    ) -> V {
        *coefficients.at(self.tape.outputs[index], order)
    }

    /// Computes everything that depends on parameters and inputs alone; call it after setting
    /// those, before [`SeriesTape::compute`].
    pub fn compute_constants<V: Value>(
        &self,
        coefficients: &mut Coefficients<V>,
    ) -> Regular<V::Mask> {
        // Mostly there is nothing to compute, nor a path to choose for it.
        if self.tape.instructions.iter().all(|step| step.moving) {
            return Regular::smooth();
        }
        V::run(Constants {
            tape: &self.tape,
            coefficients,
        })
    }

    /// Computes coefficient `k` of everything that moves, from the coefficients up to `k` of the
    /// quantities and below `k` of everything else. For use inside a [`Kernel`].
    ///
    /// A branch of a choice that is not taken counts too: where it is not smooth, neither is the result.
    ///
    /// Guarantee: with coefficient 0 of the quantities enclosing their values and the others
    /// enclosing their true coefficients, the results enclose the true coefficients wherever the
    /// return value is smooth (as it was for the constants); elsewhere they mean nothing.
    #[inline(always)]
    pub fn compute<A: Arithmetic>(
        &self,
        k: usize,
        coefficients: &mut Coefficients<A::Value>,
    ) -> Regular<MaskOf<A>> {
        self.tape.compute::<A>(k, true, coefficients)
    }
}

struct Constants<'a, V> {
    tape: &'a Tape,
    coefficients: &'a mut Coefficients<V>,
}

impl<V: Value> Kernel<V> for Constants<'_, V> {
    type Output = Regular<V::Mask>;

    #[inline(always)]
    fn run<A: Arithmetic<Value = V>>(self) -> Regular<V::Mask> {
        self.tape.compute::<A>(0, false, self.coefficients)
    }
}

impl Tape {
    /// Coefficient `k` of everything that moves, or of everything that does not.
    #[inline(always)]
    fn compute<A: Arithmetic>(
        &self,
        k: usize,
        moving: bool,
        coefficients: &mut Coefficients<A::Value>,
    ) -> Regular<MaskOf<A>> {
        let mut regular = Regular::smooth();
        for step in &self.instructions {
            if step.moving == moving {
                regular = regular.and(step.compute::<A>(k, &self.branches, coefficients));
            }
        }
        regular
    }
}

/// The function that stands in the derivative of this one, up to its sign.
fn partner(function: Unary) -> Unary {
    match function {
        Unary::Sin => Unary::Cos,
        Unary::Cos => Unary::Sin,
        Unary::Sinh => Unary::Cosh,
        _ => Unary::Sinh,
    }
}

/// Where `a` is smaller than `b`, and where it is larger; neither where they touch, since a smaller box
/// could then decide it the other way.
#[inline(always)]
fn decided_order<A: Arithmetic>(a: &A::Value, b: &A::Value) -> (MaskOf<A>, MaskOf<A>) {
    (
        A::test2(a, b, |a, b| a.hi() < b.lo()),
        A::test2(a, b, |a, b| b.hi() < a.lo()),
    )
}

impl Instruction {
    #[inline(always)]
    fn compute<A: Arithmetic>(
        &self,
        k: usize,
        branches: &[Branches],
        c: &mut Coefficients<A::Value>,
    ) -> Regular<MaskOf<A>> {
        let (a, b, out) = (self.a, self.b, self.out);
        let mut regular = Regular::smooth();
        let value = match self.op {
            Op::Square => c.square::<A>(a, k),
            // As tight as in range tapes, so that a series proves no less than plain ranges do.
            Op::Power(n) if k == 0 => A::powi(c.at(a, 0), n),
            Op::Power(_) => *c.at(b, k),
            // Constants have one coefficient only.
            Op::Binary(Binary::Add) if k > 0 && !self.moving_operands.0 => *c.at(b, k),
            Op::Binary(Binary::Add | Binary::Sub) if k > 0 && !self.moving_operands.1 => {
                *c.at(a, k)
            }
            Op::Binary(Binary::Sub) if k > 0 && !self.moving_operands.0 => A::neg(c.at(b, k)),
            Op::Binary(Binary::Add) => A::add(c.at(a, k), c.at(b, k)),
            Op::Binary(Binary::Sub) => A::sub(c.at(a, k), c.at(b, k)),
            Op::Binary(Binary::Mul) if !self.moving_operands.0 => A::mul(c.at(a, 0), c.at(b, k)),
            Op::Binary(Binary::Mul) if !self.moving_operands.1 => A::mul(c.at(a, k), c.at(b, 0)),
            Op::Binary(Binary::Mul) => c.convolve::<A>(a, b, k, 0, k),
            Op::Binary(Binary::Div) => {
                regular = Regular::undefined(A::contains_zero(c.at(b, 0)));
                let known = if k == 0 || !self.moving_operands.1 {
                    None
                } else {
                    Some(c.convolve::<A>(out, b, k, 0, k - 1))
                };
                let over = match known {
                    None => *c.at(a, k),
                    Some(known) => A::sub(c.at(a, k), &known),
                };
                A::div(&over, c.at(b, 0))
            }
            // What does not move has no second coefficient to get wrong.
            Op::Binary(function @ (Binary::Min | Binary::Max)) if !self.moving => {
                function.apply::<A>(c.at(a, 0), c.at(b, 0))
            }
            Op::Binary(function @ (Binary::Min | Binary::Max)) => {
                let (a_smaller, b_smaller) = decided_order::<A>(c.at(a, 0), c.at(b, 0));
                regular = Regular::kink(!(a_smaller | b_smaller));
                let takes_a = if function == Binary::Min {
                    a_smaller
                } else {
                    b_smaller
                };
                A::select(takes_a, c.at(a, k), c.at(b, k))
            }
            Op::Binary(Binary::Pow) => {
                let start = c.at(a, 0);
                regular = Regular::undefined(if self.moving {
                    !A::is_positive(start)
                } else {
                    A::test2(start, c.at(b, 0), |a, b| {
                        domain::pow(a, b) == Regularity::Undefined
                    })
                });
                if self.moving_operands.1 {
                    // Only numbers are exponents.
                    regular = Regular::undefined(MaskOf::<A>::splat(true));
                }
                if k == 0 {
                    Binary::Pow.apply::<A>(start, c.at(b, 0))
                } else {
                    c.power::<A>(a, out, c.at(b, 0), k)
                }
            }
            Op::Binary(function @ (Binary::Atan2 | Binary::Atan2Cut)) => {
                let (y, x) = (c.at(a, 0), c.at(b, 0));
                regular = Regular::by_lane(|wanted| {
                    A::test2(y, x, |y, x| jump::atan2_regularity(y, x) == wanted)
                });
                if k == 0 {
                    function.apply::<A>(y, x)
                } else if function == Binary::Atan2Cut {
                    number::<A::Value>(0)
                } else {
                    // (x² + y²) angle' = x y' - y x'; the companion is the sum of squares.
                    let turns =
                        A::sub(&c.integrate::<A>(a, b, k, k), &c.integrate::<A>(b, a, k, k));
                    let known = c.integrate::<A>(out, self.companion, k, k - 1);
                    A::div(&A::sub(&turns, &known), c.at(self.companion, 0))
                }
            }
            Op::Unary(function) => return self.compute_unary::<A>(function, k, c),
            Op::Choose(number) => {
                let no = branches[number as usize].no.0;
                let (taken, refused) = decided::<A>(c.at(a, 0));
                regular = Regular::jump(!(taken | refused));
                choose::<A>((taken, refused), c.at(b, k), c.at(no, k))
            }
        };
        c.set(out, k, value);
        regular
    }

    #[inline(always)]
    fn compute_unary<A: Arithmetic>(
        &self,
        function: Unary,
        k: usize,
        c: &mut Coefficients<A::Value>,
    ) -> Regular<MaskOf<A>> {
        let (a, out, companion) = (self.a, self.out, self.companion);
        let one = number::<A::Value>(1);
        let mut regular = Regular::smooth();
        let start = *c.at(a, 0);
        let value = match function {
            Unary::Neg => A::neg(c.at(a, k)),
            Unary::Abs if !self.moving => A::abs(&start),
            Unary::Abs => {
                // Strict: a box and a box inside it must not take different branches.
                let (above, below) = (A::is_positive(&start), A::is_positive(&A::neg(&start)));
                regular = Regular::kink(!(above | below));
                A::select(above, c.at(a, k), &A::neg(c.at(a, k)))
            }
            Unary::Sign | Unary::Impulse => {
                let at_zero = A::contains_zero(&start);
                regular = if function == Unary::Sign {
                    Regular::jump(at_zero)
                } else {
                    Regular::undefined(at_zero)
                };
                if k == 0 {
                    function.apply::<A>(&start)
                } else {
                    number::<A::Value>(0)
                }
            }
            Unary::Floor | Unary::FloorSlope => {
                regular = Regular::jump(A::test(&start, |x| {
                    jump::floor_regularity(x) == Regularity::Jump
                }));
                if k == 0 {
                    function.apply::<A>(&start)
                } else {
                    number::<A::Value>(0)
                }
            }
            Unary::Cbrt => {
                regular = Regular::kink(A::contains_zero(&start));
                if k == 0 {
                    function.apply::<A>(&start)
                } else {
                    let third = A::div(&one, &number::<A::Value>(3));
                    c.power::<A>(a, out, &third, k)
                }
            }
            Unary::Sqrt => {
                regular = Regular::undefined(!A::is_positive(&start));
                if k == 0 {
                    A::sqrt(&start)
                } else {
                    let known = c.convolve::<A>(out, out, k, 1, k - 1);
                    let twice = A::mul(&number::<A::Value>(2), c.at(out, 0));
                    A::div(&A::sub(c.at(a, k), &known), &twice)
                }
            }
            Unary::Exp if k == 0 => A::exp(&start),
            Unary::Exp => c.integrate::<A>(a, out, k, k),
            Unary::Ln => {
                regular = Regular::undefined(!A::is_positive(&start));
                if k == 0 {
                    A::ln(&start)
                } else {
                    let known = c.integrate::<A>(out, a, k, k - 1);
                    A::div(&A::sub(c.at(a, k), &known), &start)
                }
            }
            // The companion is the other one: sin' = cos, cos' = -sin, sinh' = cosh, cosh' = sinh.
            Unary::Sin | Unary::Cos | Unary::Sinh | Unary::Cosh => {
                let (value, other) = if k == 0 {
                    (
                        function.apply::<A>(&start),
                        partner(function).apply::<A>(&start),
                    )
                } else {
                    (
                        c.integrate::<A>(a, companion, k, k),
                        c.integrate::<A>(a, out, k, k),
                    )
                };
                let (value, other) = match function {
                    _ if k == 0 => (value, other),
                    Unary::Sin => (value, A::neg(&other)),
                    Unary::Cos => (A::neg(&value), other),
                    _ => (value, other),
                };
                c.set(companion, k, other);
                value
            }
            // The slope was computed before; where it does not exist, it said so.
            Unary::Asin | Unary::Acos | Unary::Asinh | Unary::Acosh | Unary::Atanh => {
                if k == 0 {
                    function.apply::<A>(&start)
                } else {
                    c.integrate::<A>(a, self.b, k, k)
                }
            }
            Unary::Tan | Unary::Tanh => {
                // The companion is the outer derivative: 1 + tan², 1 - tanh².
                let value = if k == 0 {
                    function.apply::<A>(&start)
                } else {
                    c.integrate::<A>(a, companion, k, k)
                };
                if function == Unary::Tan {
                    let tangent = function.apply::<A>(&start);
                    regular = Regular::undefined(A::test(&tangent, |x| !x.is_bounded()));
                }
                c.set(out, k, value);
                let square = c.square::<A>(out, k);
                let signed = if function == Unary::Tan {
                    square
                } else {
                    A::neg(&square)
                };
                let other = if k == 0 {
                    A::add(&one, &signed)
                } else {
                    signed
                };
                c.set(companion, k, other);
                value
            }
            Unary::Atan => {
                // atan' = a' / (1 + a²); the companion is the denominator.
                let square = c.square::<A>(a, k);
                let other = if k == 0 {
                    A::add(&one, &square)
                } else {
                    square
                };
                c.set(companion, k, other);
                if k == 0 {
                    function.apply::<A>(&start)
                } else {
                    let known = c.integrate::<A>(out, companion, k, k - 1);
                    A::div(&A::sub(c.at(a, k), &known), c.at(companion, 0))
                }
            }
        };
        c.set(out, k, value);
        regular
    }
}
