//! Derivatives against difference quotients: by the mean value theorem the quotient of any two points of a box
//! that differ in one quantity lies in the enclosure of the derivative on the box, at kinks and jumps too.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod support;

use support::Dice;
use veribound_interval::Interval;
use veribound_interval::lanes::Interval8;
use veribound_model::build::{
    Condition, ModelBuilder, Symbol, friction, if_else, sticking_friction,
};
use veribound_model::{ExprId, Graph, Layout, Model, Regular, Tape, Var};

const VARS: [Var; 4] = [Var::State(0), Var::State(1), Var::Param(0), Var::Input(0)];
const LAYOUT: Layout = Layout {
    states: 2,
    params: 1,
    inputs: 1,
};

/// Between 0 and 1.
fn share(dice: &mut Dice) -> f64 {
    dice.below(1 << 30) as f64 / f64::from(1 << 30)
}

/// An end of a box: often a number at which something bends, jumps or ends.
fn end(dice: &mut Dice) -> f64 {
    match dice.below(3) {
        0 => *dice.pick(&[-2.0, -1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0]),
        1 => 6.0 * share(dice) - 3.0,
        _ => {
            let near = *dice.pick(&[-1.0, 0.0, 0.5, 1.0]);
            near + (2.0 * share(dice) - 1.0) * 10f64.powi(-(dice.below(9) as i32))
        }
    }
}

fn interval(dice: &mut Dice) -> Interval {
    let (a, b) = (end(dice), end(dice));
    let b = if dice.below(3) == 0 {
        a + share(dice) * 10f64.powi(-(dice.below(7) as i32))
    } else {
        b
    };
    Interval::new(a.min(b), a.max(b)).unwrap()
}

/// A point of a box, often one of its ends.
fn inside(dice: &mut Dice, x: Interval) -> f64 {
    match dice.below(4) {
        0 => x.lo(),
        1 => x.hi(),
        _ => (x.lo() + share(dice) * (x.hi() - x.lo())).clamp(x.lo(), x.hi()),
    }
}

/// A random equation in `x`, `y`, `p` and `u`, with every word of the language.
fn equation(dice: &mut Dice, symbols: &[Symbol], levels: usize) -> Symbol {
    if levels == 0 {
        return match dice.below(3) {
            0 => Symbol::from(*dice.pick(&["-2", "-1", "-0.5", "0", "0.5", "1", "2", "0.1"])),
            _ => dice.pick(symbols).clone(),
        };
    }
    let a = equation(dice, symbols, levels - 1);
    let less = dice.below(levels);
    let b = equation(dice, symbols, less);
    match dice.below(41) {
        0 | 1 => a + b,
        2 | 3 => a - b,
        4..=6 => a * b,
        7 => a / b,
        8 => a.abs(),
        9 => a.sign(),
        10 => a.min(b),
        11 => a.max(b),
        12 => a.pow(*dice.pick(&[-3, -2, -1, 2, 3, 4])),
        13 => a.sqrt(),
        14 => a.exp(),
        15 => a.ln(),
        16 => a.log2() + b.log10(),
        17 => a.sin(),
        18 => a.cos(),
        19 => a.tan(),
        20 => a.asin(),
        21 => a.acos(),
        22 => a.atan(),
        23 => a.sinh(),
        24 => a.cosh(),
        25 => a.tanh(),
        26 => a.asinh(),
        27 => a.acosh(),
        28 => a.atanh(),
        29 => a.sat("-0.5", b.abs()),
        30 => a.deadzone(-b.abs(), 1),
        31 => {
            let jump = *dice.pick(&["0", "0.5"]);
            a.table([
                ("-1", "2"),
                ("0", "1"),
                (jump, "0"),
                ("1", "-0.5"),
                ("2", "3"),
            ])
        }
        32 => a.floor() + b.ceil(),
        33 => a.round(),
        34 => a.trunc(),
        35 => a.cbrt(),
        36 => a.atan2(b),
        37 => a.power(b),
        38 => a.abs().power("1.5"),
        39 => {
            let condition: Condition = dice.pick(symbols).above(dice.pick(symbols));
            if_else(condition, a, b)
        }
        _ => {
            let velocity = dice.pick(&symbols[..2]);
            if dice.below(2) == 0 {
                friction(velocity, a, b)
            } else {
                sticking_friction(velocity, a, b, 1)
            }
        }
    }
}

/// A model with a random right-hand side; `None` where the reader refuses it.
fn model(dice: &mut Dice) -> Option<Model> {
    let mut model = ModelBuilder::new("random");
    let x = model.state("x").init(0, 1).symbol();
    let y = model.state("y").init(0, 1).symbol();
    let p = model.param("p", 0, 1).symbol();
    let u = model.input("u").symbol();
    let levels = 1 + dice.below(4);
    let velocity = equation(dice, &[x.clone(), y.clone(), p, u], levels);
    model.der(&x, velocity);
    model.der(&y, 0);
    model.output("x_m", &x, 1);
    model.build().ok()
}

/// Range and regularity of one expression.
fn range(graph: &Graph, e: ExprId, at: &[Interval]) -> (Interval, Regular) {
    let tape = Tape::compile(graph, LAYOUT, &[e]);
    let mut registers = tape.registers();
    let regular = tape.eval(at, &mut registers);
    let side_by_side: Vec<Interval8> = at.iter().map(|x| Interval8::splat(*x)).collect();
    let mut eight = tape.registers();
    tape.eval(&side_by_side, &mut eight);
    let value = tape.output(0, &registers);
    assert!(tape.output(0, &eight).get(5) == value);
    (value, regular)
}

#[derive(Default)]
struct Seen {
    quotients: usize,
    /// Over boxes on which a derivative jumps.
    across: usize,
    /// In the outer tenths of the enclosure.
    tight: usize,
}

/// Asks for the difference quotients of `e` whether they lie in the enclosures of `slope`.
fn compare(
    dice: &mut Dice,
    graph: &Graph,
    (e, slope, var): (ExprId, ExprId, Var),
    space: &[Interval],
    seen: &mut Seen,
) {
    let at = LAYOUT.index(var);
    let (mut slopes, slope_regular) = range(graph, slope, space);
    if slopes.is_empty() {
        slopes = Interval::ENTIRE;
    }
    for _ in 0..4 {
        let mut point: Vec<Interval> = space
            .iter()
            .map(|x| Interval::point(inside(dice, *x)))
            .collect();
        let (a, b) = (inside(dice, space[at]), inside(dice, space[at]));
        if a >= b {
            continue;
        }
        point[at] = Interval::new(a, b).unwrap();
        let (_, regular) = range(graph, e, &point);
        if !regular.is_defined() {
            continue;
        }
        let mut value = |x: f64| {
            point[at] = Interval::point(x);
            range(graph, e, &point).0
        };
        let (from, to) = (value(a), value(b));
        let width = Interval::point(b) - Interval::point(a);
        let quotient = (to - from) / width;
        seen.quotients += 1;
        if !slope_regular.is_continuous() {
            seen.across += 1;
        }
        let names = veribound_model::Names {
            states: vec!["x".into(), "y".into()],
            params: vec!["p".into()],
            inputs: vec!["u".into()],
        };
        assert!(
            slopes.intersects(quotient),
            "{} by {var:?} is {}\non {space:?}: {slopes}, but from {a} to {b} it is {quotient} ({from}, {to})",
            graph.show(e, &names),
            graph.show(slope, &names),
        );
        let tenth = 0.1 * slopes.width();
        let inner = Interval::new(slopes.lo() + tenth, slopes.hi() - tenth);
        if inner.is_some_and(|inner| !inner.intersects(quotient)) {
            seen.tight += 1;
        }
    }
}

/// First derivatives by every quantity, and the derivatives of those.
fn attack(dice: &mut Dice, graph: &mut Graph, e: ExprId, seen: &mut [Seen; 2]) {
    for var in VARS {
        let slope = graph.derivative(e, var);
        let other = *dice.pick(&VARS);
        let curvature = graph.derivative(slope, other);
        for _ in 0..3 {
            let space: Vec<Interval> = VARS.iter().map(|_| interval(dice)).collect();
            compare(dice, graph, (e, slope, var), &space, &mut seen[0]);
            compare(dice, graph, (slope, curvature, other), &space, &mut seen[1]);
        }
    }
}

#[test]
fn difference_quotients_lie_in_the_derivatives() {
    let mut dice = Dice(1);
    let mut seen = [Seen::default(), Seen::default()];
    let mut models = 0;
    while models < 4000 {
        let Some(model) = model(&mut dice) else {
            continue;
        };
        models += 1;
        let mut graph = model.graph.clone();
        for mode in model.modes.iter().take(4) {
            attack(&mut dice, &mut graph, mode.der[0], &mut seen);
        }
    }
    for (order, seen) in seen.iter().enumerate() {
        let Seen {
            quotients,
            across,
            tight,
        } = seen;
        println!(
            "derivative {}: {quotients} quotients, {across} across jumps, {tight} near an end",
            order + 1
        );
        assert!(*quotients > 10_000 && *across > 1000 && *tight > 200);
    }
}
