//! Taylor coefficients and derivatives against exact ones: power series with rational coefficients, and closed
//! forms.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

#[path = "support/exact.rs"]
mod exact;
mod support;

use exact::{COUNT, Exact, at_zero, beside_one, contains, rational};
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};
use support::Dice;
use veribound_interval::lanes::{Arithmetic, Kernel, Value};
use veribound_interval::{Interval, rational_to_interval};
use veribound_model::{Binary, Coefficients, ExprId, Graph, Layout, Node, SeriesTape, Unary, Var};

/// An expression with its series.
type Known = (ExprId, Exact);

fn number(graph: &mut Graph, value: BigRational) -> Known {
    (graph.constant(value.clone()), Exact::constant(value))
}

fn plus(graph: &mut Graph, a: &Known, b: &Known) -> Known {
    (graph.add(a.0, b.0), a.1.zip(&b.1, |a, b| a + b))
}

/// The expression moved so that its series begins with `start`.
fn starting_at(graph: &mut Graph, a: &Known, start: BigRational) -> Known {
    let shift = number(graph, start - &a.1.0[0]);
    plus(graph, a, &shift)
}

const AT_ZERO: [Unary; 11] = [
    Unary::Exp,
    Unary::Sin,
    Unary::Cos,
    Unary::Sinh,
    Unary::Cosh,
    Unary::Atan,
    Unary::Atanh,
    Unary::Asin,
    Unary::Asinh,
    Unary::Tan,
    Unary::Tanh,
];

/// A random expression of the quantities, with its exact series.
fn expression(dice: &mut Dice, graph: &mut Graph, leaves: &[Known], levels: usize) -> Known {
    if levels == 0 {
        return match dice.below(3) {
            0 => {
                let value = rational(dice.below(9) as i64 - 4, 1 + dice.below(4) as i64);
                number(graph, value)
            }
            _ => dice.pick(leaves).clone(),
        };
    }
    let a = expression(dice, graph, leaves, levels - 1);
    let less = dice.below(levels);
    let b = expression(dice, graph, leaves, less);
    let starts_at_zero = |a: &Known| a.1.0[0].is_zero();
    match dice.below(12) {
        0 => plus(graph, &a, &b),
        1 => (graph.sub(a.0, b.0), a.1.zip(&b.1, |a, b| a - b)),
        2 | 3 => (graph.mul(a.0, b.0), a.1.times(&b.1)),
        4 if !starts_at_zero(&b) => (graph.div(a.0, b.0), a.1.times(&b.1.inverse())),
        5 => {
            let n = *dice.pick(&[2, 3, 4, 5, -1, -2, -3]);
            if n < 0 && starts_at_zero(&a) {
                return a;
            }
            (graph.powi(a.0, n), a.1.power(n))
        }
        6 if !starts_at_zero(&a) => {
            let sign = rational(if a.1.0[0].is_negative() { -1 } else { 1 }, 1);
            (graph.unary(Unary::Abs, a.0), a.1.scaled(&sign))
        }
        7 if a.1.0[0] != b.1.0[0] => {
            let (low, high) = if a.1.0[0] < b.1.0[0] {
                (&a, &b)
            } else {
                (&b, &a)
            };
            if dice.below(2) == 0 {
                (graph.min(a.0, b.0), low.1.clone())
            } else {
                (graph.max(a.0, b.0), high.1.clone())
            }
        }
        8 => {
            let function = *dice.pick(&[Unary::Sqrt, Unary::Ln]);
            let a = starting_at(graph, &a, BigRational::one());
            let series = beside_one(function);
            let from_one = starting_at(graph, &a, BigRational::zero()).1;
            (graph.unary(function, a.0), from_one.inside(&series))
        }
        _ => {
            let function = *dice.pick(&AT_ZERO);
            let a = starting_at(graph, &a, BigRational::zero());
            let series = at_zero(function).unwrap();
            (graph.unary(function, a.0), a.1.inside(&series))
        }
    }
}

struct Compute<'a> {
    series: &'a SeriesTape,
    order: usize,
    coefficients: &'a mut Coefficients<Interval>,
}

impl Kernel<Interval> for Compute<'_> {
    type Output = bool;

    fn run<A: Arithmetic<Value = Interval>>(self) -> bool {
        self.series
            .compute::<A>(self.order, self.coefficients)
            .is_smooth()
    }
}

/// The coefficients of `e` when those of the quantities are given (for parameters and inputs the first one counts);
/// `None` where the tape does not say that they are right.
fn enclosures(
    graph: &Graph,
    layout: Layout,
    e: ExprId,
    given: &[Vec<Interval>],
) -> Option<Vec<Interval>> {
    let tape = SeriesTape::compile(graph, layout, &[e]);
    let mut coefficients = tape.coefficients(COUNT - 1);
    let quantities: Vec<usize> = tape.quantities().collect();
    for (position, quantity) in quantities.iter().enumerate() {
        for (order, value) in given[*quantity].iter().enumerate() {
            tape.set_quantity(position, order, *value, &mut coefficients);
        }
    }
    let mut smooth = tape.compute_constants(&mut coefficients).is_smooth();
    for order in 0..COUNT {
        smooth &= Interval::run(Compute {
            series: &tape,
            order,
            coefficients: &mut coefficients,
        });
    }
    let all = (0..COUNT).map(|order| tape.output(0, order, &coefficients));
    smooth.then(|| all.collect())
}

#[test]
fn coefficients_and_derivatives_contain_the_exact_ones() {
    let layout = Layout {
        states: 1,
        params: 0,
        inputs: 0,
    };
    let mut dice = Dice(5);
    let (mut series, mut slopes) = (0, 0);
    for _ in 0..4000 {
        let mut graph = Graph::default();
        let mut time = Exact::constant(BigRational::zero());
        time.0[1] = BigRational::one();
        let clock = graph.var(Var::State(0));
        let levels = 1 + dice.below(4);
        let (e, exact) = expression(&mut dice, &mut graph, &[(clock, time.clone())], levels);
        let given: Vec<Interval> = time.0.iter().map(rational_to_interval).collect();
        if let Some(found) = enclosures(&graph, layout, e, &[given]) {
            for (order, (found, exact)) in found.iter().zip(&exact.0).enumerate() {
                assert!(
                    contains(*found, exact),
                    "coefficient {order} of {} is {exact}, not in {found}",
                    graph.show(e, &Default::default())
                );
                series += 1;
            }
        }
        let (mut slope, mut factor) = (e, BigRational::one());
        for order in 1..4_usize {
            slope = graph.derivative(slope, Var::State(0));
            factor *= BigInt::from(order);
            let found = graph.eval_interval(slope, &|_| Interval::ZERO);
            let exact = &exact.0[order] * &factor;
            // Empty says nothing: the root in the slope of acos at its end, for instance.
            assert!(
                found.is_empty() || contains(found, &exact),
                "derivative {order} of {} is {exact}, not in {found}",
                graph.show(e, &Default::default())
            );
            slopes += usize::from(found.is_bounded() && !found.is_empty());
        }
    }
    println!("{series} coefficients, {slopes} derivatives");
    assert!(series > 20_000 && slopes > 8_000);
}

/// `e` with the quantities replaced by series: for sums, products and quotients only.
fn evaluate(graph: &Graph, e: ExprId, quantity: &dyn Fn(Var) -> Exact) -> Exact {
    let of = |e: ExprId| evaluate(graph, e, quantity);
    match *graph.node(e) {
        Node::Constant(ref value) => Exact::constant(value.clone()),
        Node::Var(var) => quantity(var),
        Node::Unary(Unary::Neg, a) => of(a).scaled(&rational(-1, 1)),
        Node::Power(a, n) => of(a).power(n),
        Node::Binary(Binary::Add, a, b) => of(a).zip(&of(b), |a, b| a + b),
        Node::Binary(Binary::Sub, a, b) => of(a).zip(&of(b), |a, b| a - b),
        Node::Binary(Binary::Mul, a, b) => of(a).times(&of(b)),
        ref other => panic!("{other:?}"),
    }
}

fn polynomial(dice: &mut Dice, graph: &mut Graph, leaves: &[ExprId], levels: usize) -> ExprId {
    if levels == 0 {
        return match dice.below(4) {
            0 => graph.constant(rational(dice.below(7) as i64 - 3, 1 + dice.below(3) as i64)),
            _ => *dice.pick(leaves),
        };
    }
    let a = polynomial(dice, graph, leaves, levels - 1);
    let less = dice.below(levels);
    let b = polynomial(dice, graph, leaves, less);
    match dice.below(5) {
        0 => graph.add(a, b),
        1 => graph.sub(a, b),
        2 => {
            let power = 2 + dice.below(2) as i32;
            graph.powi(a, power)
        }
        _ => graph.mul(a, b),
    }
}

/// Trajectories of polynomial systems: the coefficients of each point of the start box lie in those of the box.
#[test]
fn solutions_of_polynomial_systems_lie_in_the_coefficients() {
    let layout = Layout {
        states: 2,
        params: 1,
        inputs: 1,
    };
    let vars = [Var::State(0), Var::State(1), Var::Param(0), Var::Input(0)];
    let mut dice = Dice(9);
    let mut compared = 0;
    for _ in 0..400 {
        let mut graph = Graph::default();
        let leaves = vars.map(|var| graph.var(var));
        let velocities = [0, 1].map(|_| polynomial(&mut dice, &mut graph, &leaves, 3));
        // A box, and rational points of it.
        let corner: Vec<BigRational> = vars
            .iter()
            .map(|_| rational(dice.below(17) as i64 - 8, 4))
            .collect();
        let width = *dice.pick(&[0, 1, 100]);
        let cube: Vec<Interval> = corner
            .iter()
            .map(|low| {
                let high = rational_to_interval(&(low + rational(width, 100)));
                rational_to_interval(low).hull(high)
            })
            .collect();
        let unknown = || vec![Interval::ZERO; COUNT];
        let mut boxes = [unknown(), unknown(), unknown(), unknown()];
        for (coefficients, start) in boxes.iter_mut().zip(&cube) {
            coefficients[0] = *start;
        }
        // Coefficient k + 1 of a state is coefficient k of its velocity over k + 1.
        for k in 0..COUNT - 1 {
            let of = |e| enclosures(&graph, layout, e, &boxes).unwrap()[k];
            let next = velocities.map(of);
            for (state, next) in next.into_iter().enumerate() {
                boxes[state][k + 1] = next / Interval::point((k + 1) as f64);
            }
        }
        for _ in 0..3 {
            let point = corner
                .iter()
                .map(|low| low + rational(width, 100) * rational(dice.below(5) as i64, 4));
            let mut exact: Vec<Exact> = point.map(Exact::constant).collect();
            for k in 0..COUNT - 1 {
                let quantity = |var| exact[layout.index(var)].clone();
                let next = velocities.map(|e| evaluate(&graph, e, &quantity).0[k].clone());
                for (state, next) in next.into_iter().enumerate() {
                    exact[state].0[k + 1] = next / BigInt::from(k + 1);
                }
            }
            for state in 0..2 {
                for (found, exact) in boxes[state].iter().zip(&exact[state].0) {
                    assert!(contains(*found, exact));
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 15_000);
}

/// First and second derivatives with values that are not rational, or at other points than 0.
#[test]
fn closed_forms() {
    let half = Interval::point(0.5);
    let root = |x: f64| Interval::point(x).sqrt();
    let cases: [(Unary, f64, Interval, Interval); 8] = [
        (
            Unary::Acos,
            0.6,
            Interval::point(-1.25),
            Interval::point(-75.0) / Interval::point(64.0),
        ),
        (
            Unary::Acosh,
            1.25,
            Interval::point(4.0) / Interval::point(3.0),
            Interval::point(-80.0) / Interval::point(27.0),
        ),
        (
            Unary::Asin,
            0.6,
            Interval::point(1.25),
            Interval::point(75.0) / Interval::point(64.0),
        ),
        (
            Unary::Sqrt,
            2.0,
            half / root(2.0),
            -Interval::point(0.125) / root(2.0),
        ),
        (
            Unary::Ln,
            4.0,
            Interval::point(0.25),
            Interval::point(-0.0625),
        ),
        (
            Unary::Tan,
            0.5,
            half.cos().sqr().recip(),
            Interval::point(2.0) * half.tan() / half.cos().sqr(),
        ),
        (
            Unary::Tanh,
            0.5,
            half.cosh().sqr().recip(),
            Interval::point(-2.0) * half.tanh() / half.cosh().sqr(),
        ),
        (Unary::Atan, 1.0, half, -half),
    ];
    for (function, at, first, second) in cases {
        let mut graph = Graph::default();
        let x = graph.var(Var::State(0));
        let e = graph.unary(function, x);
        let slope = graph.derivative(e, Var::State(0));
        let curvature = graph.derivative(slope, Var::State(0));
        // 0.6 is no float: its neighbours stand for it.
        let at = Interval::new(at.next_down(), at.next_up()).unwrap();
        for (e, exact) in [(slope, first), (curvature, second)] {
            let found = graph.eval_interval(e, &|_| at);
            assert!(
                found.intersects(exact) && found.width() < 1e-13,
                "{function:?}: {found}, {exact}"
            );
        }
    }
}

/// The slope of a kink is the set between its sides; that of a jump is every number, never 0 alone.
#[test]
fn kinks_and_jumps() {
    let mut graph = Graph::default();
    let x = graph.var(Var::State(0));
    let size = graph.unary(Unary::Abs, x);
    let slope = graph.derivative(size, Var::State(0));
    let curvature = graph.derivative(slope, Var::State(0));
    let third = graph.derivative(curvature, Var::State(0));
    let unit = Interval::new(-1.0, 1.0).unwrap();
    let on =
        |e: ExprId, lo: f64, hi: f64| graph.eval_interval(e, &|_| Interval::new(lo, hi).unwrap());
    for (lo, hi, slopes, more) in [
        (-2.0, -1.0, Interval::point(-1.0), Interval::ZERO),
        (1.0, 2.0, Interval::ONE, Interval::ZERO),
        (-1.0, 2.0, unit, Interval::ENTIRE),
        (0.0, 0.0, unit, Interval::ENTIRE),
        (0.0, 1.0, unit, Interval::ENTIRE),
    ] {
        assert_eq!(on(slope, lo, hi), slopes);
        assert_eq!(on(curvature, lo, hi), more);
        assert_eq!(on(third, lo, hi), more);
    }
}
