//! `if` outside of right-hand sides: enclosed on points, boxes and lanes, with slopes, and contracted.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod support;

use support::Dice;
use veribound_interval::Interval;
use veribound_interval::lanes::{Interval8, LANES};
use veribound_model::{Coefficients, Model, SeriesTape, Tape, Var};

/// A model of `x`, `v` and `k` with this output.
fn model(output: &str) -> Model {
    let text = format!(
        "format = 1\nstates = [\"x\", \"v\"]\ninit = {{ x = 0, v = 0 }}\nparams.k = [-1, 1]\n\
         der = {{ x = \"v\", v = \"-k*x\" }}\noutputs.y = \"{output} +- 0.1\"\n"
    );
    Model::from_text("choices.toml", text).unwrap_or_else(|e| panic!("{}", e.render(false)))
}

fn interval(lo: f64, hi: f64) -> Interval {
    Interval::new(lo, hi).unwrap()
}

/// Outputs, and their values at points: all that are possible at a border.
type Values = fn(f64, f64, f64) -> Vec<f64>;

fn by(test: f64, yes: f64, no: f64) -> Vec<f64> {
    match test {
        _ if test > 0.0 => vec![yes],
        _ if test < 0.0 => vec![no],
        _ => vec![yes, no, (yes + no) / 2.0],
    }
}

const OUTPUTS: &[(&str, Values)] = &[
    ("if x > 0 then 2*x + v else -1", |x, v, _| {
        by(x, 2.0 * x + v, -1.0)
    }),
    ("if x <= v then x*k else v^2", |x, v, k| {
        by(v - x, x * k, v * v)
    }),
    ("if x > 0 then sqrt(x) else x", |x, _, _| {
        by(x, x.max(0.0).sqrt(), x)
    }),
    ("1 + (if x > 0 and v < k then 1/x else v)*k", |x, v, k| {
        let inner = by(x.min(k - v), if x == 0.0 { f64::NAN } else { 1.0 / x }, v);
        inner.into_iter().map(|y| 1.0 + y * k).collect()
    }),
    (
        "if x > 0.5 or x < -0.5 then x else if v > 0 then 3 else sin(k)",
        |x, v, k| {
            let outer = (x - 0.5).max(-0.5 - x);
            let mut all = Vec::new();
            for inner in by(v, 3.0, k.sin()) {
                all.extend(by(outer, x, inner));
            }
            all
        },
    ),
    ("if x == 0.5 then 4 else 1 - x", |x, _, _| {
        by(-(x - 0.5).abs(), 4.0, 1.0 - x)
    }),
    ("if x != 0.5 then abs(v) else -2", |x, v, _| {
        by((x - 0.5).abs(), v.abs(), -2.0)
    }),
    ("if abs(x) > 1 then x - sign(x) else 0", |x, _, _| {
        by(x.abs() - 1.0, x - x.signum(), 0.0)
    }),
];

/// Dyadic ends, so that points lie on borders often.
fn range(dice: &mut Dice) -> Interval {
    let mut end = || dice.below(17) as f64 / 4.0 - 2.0;
    let (a, b) = (end(), end());
    interval(a.min(b), a.max(b))
}

fn inside(dice: &mut Dice, range: Interval) -> f64 {
    range.lo() + dice.below(9) as f64 / 8.0 * (range.hi() - range.lo())
}

#[test]
fn values_and_contractions_lose_no_point() {
    let mut dice = Dice(1);
    for (text, values) in OUTPUTS {
        let model = model(text);
        let (expr, layout) = (model.outputs[0].expr, model.layout());
        let tape = Tape::compile(&model.graph, layout, &[expr]);
        let mut scalar = tape.registers::<Interval>();
        let mut lanes = tape.registers::<Interval8>();
        let (mut on_border, mut refuted) = (0, 0);
        for _ in 0..2000 {
            let boxes: Vec<[Interval; 3]> = (0..LANES)
                .map(|_| [range(&mut dice), range(&mut dice), range(&mut dice)])
                .collect();
            let points: Vec<[f64; 3]> = boxes
                .iter()
                .map(|one| [0, 1, 2].map(|i| inside(&mut dice, one[i])))
                .collect();
            let mut side: Vec<Interval8> = (0..3)
                .map(|i| Interval8::from_fn(|lane| boxes[lane][i]))
                .collect();
            let regular = tape.eval(&side, &mut lanes);
            let found = tape.output(0, &lanes);
            let target = interval(-0.5, 0.75);
            let whole = side.clone();
            let left = tape.contract(&mut side, target, &mut lanes);
            for (lane, point) in points.iter().enumerate() {
                let q: Vec<Interval> = whole.iter().map(|part| part.get(lane)).collect();
                let alone = tape.eval(&q, &mut scalar);
                let range = tape.output(0, &scalar);
                assert_eq!(range, found.get(lane), "{text}");
                assert_eq!(alone.is_smooth(), regular.is_smooth().get(lane), "{text}");
                assert_eq!(alone.is_defined(), regular.is_defined().get(lane), "{text}");
                let graph = model.graph.eval_interval(expr, &|var| q[layout.index(var)]);
                let mut narrow = q.clone();
                let kept = tape.contract(&mut narrow, target, &mut scalar);
                assert_eq!(kept, left.get(lane), "{text}");
                refuted += usize::from(!kept);
                let [x, v, k] = *point;
                let possible = values(x, v, k);
                on_border += usize::from(possible.len() > 1);
                for y in possible.into_iter().filter(|y| y.is_finite()) {
                    let near = interval(y - 1e-12, y + 1e-12);
                    assert!(
                        range.intersects(near),
                        "{text} at {x} {v} {k}: {y} not in {range}"
                    );
                    assert!(
                        graph.intersects(near),
                        "{text} at {x} {v} {k}: {y} not in {graph}"
                    );
                    if (-0.5..=0.75).contains(&y) {
                        assert!(kept, "{text} at {x} {v} {k}: {y} in {q:?}");
                        for (i, value) in [x, v, k].into_iter().enumerate() {
                            let near = interval(value - 1e-12, value + 1e-12);
                            assert!(
                                narrow[i].intersects(near),
                                "{text} at {x} {v} {k}: {narrow:?}"
                            );
                            let near = narrow[i] == side[i].get(lane);
                            assert!(near, "{text}: {narrow:?}");
                        }
                    }
                }
            }
        }
        assert!(on_border > 20, "{text}: {on_border}");
        assert!(refuted > 100, "{text}: {refuted}");
    }
}

#[test]
fn a_branch_that_is_not_taken_need_not_be_defined() {
    let model = model("if x > 0 then sqrt(x) + 1/v else if x < -1 then log(-1 - x) else 5");
    let tape = Tape::compile(&model.graph, model.layout(), &[model.outputs[0].expr]);
    let mut registers = tape.registers::<Interval>();
    let mut at = |x: (f64, f64), v: (f64, f64)| {
        let q = [interval(x.0, x.1), interval(v.0, v.1), Interval::ZERO];
        let regular = tape.eval(&q, &mut registers);
        let shape = (regular.is_smooth(), regular.is_defined());
        (shape, tape.output(0, &registers))
    };
    assert_eq!(
        at((-0.5, -0.25), (-1.0, 1.0)),
        ((true, true), Interval::point(5.0))
    );
    assert_eq!(at((-3.0, -2.0), (0.0, 0.0)).0, (true, true));
    assert_eq!(
        at((1.0, 4.0), (1.0, 1.0)),
        ((true, true), interval(2.0, 3.0))
    );
    assert_eq!(at((1.0, 4.0), (0.0, 1.0)).0, (false, false));
    assert_eq!(at((-0.5, 4.0), (1.0, 1.0)).0, (false, false));
    assert_eq!(at((-1.5, -0.5), (1.0, 1.0)).0, (false, false));
    let mut q = [interval(-3.0, -2.0), Interval::ZERO, Interval::ZERO];
    assert!(tape.contract(&mut q, interval(0.0, 0.5), &mut registers));
    // log(-1 - x) <= 0.5
    assert!(q[0].lo() > -2.65 && q[0].contains(-2.6), "{}", q[0]);
}

#[test]
fn a_measurement_decides() {
    let model = model("if x > 1 then v else 5");
    let tape = Tape::compile(&model.graph, model.layout(), &[model.outputs[0].expr]);
    let mut registers = tape.registers::<Interval>();
    let mut narrowed = |target: Interval| {
        let mut q = [interval(0.0, 2.0), interval(-1.0, 1.0), Interval::ZERO];
        let kept = tape.contract(&mut q, target, &mut registers);
        kept.then_some(q[0])
    };
    assert_eq!(narrowed(interval(-1.0, 1.0)), Some(interval(1.0, 2.0)));
    assert_eq!(narrowed(interval(4.0, 6.0)), Some(interval(0.0, 1.0)));
    // Between the branches there are values at the border alone.
    assert_eq!(narrowed(interval(2.0, 3.0)), Some(Interval::ONE));
    // The other branch is too small, so this one has to be large, at the border too.
    let model = self::model("if x > 1 then 2*x else v");
    let tape = Tape::compile(&model.graph, model.layout(), &[model.outputs[0].expr]);
    let mut registers = tape.registers::<Interval>();
    let mut q = [interval(0.0, 9.0), interval(-1.0, 1.0), Interval::ZERO];
    for wanted in [interval(2.5, 9.0), interval(2.5, 3.0)] {
        assert!(tape.contract(&mut q, interval(5.0, 6.0), &mut registers));
        assert_eq!(q[0], wanted);
    }
}

/// Between two points of a box that differ in one quantity the difference quotient lies in the slope.
#[test]
fn slopes_contain_difference_quotients() {
    let mut dice = Dice(3);
    for (text, values) in OUTPUTS {
        let mut model = model(text);
        let layout = model.layout();
        let mut jumps = 0;
        for (index, var) in [Var::State(0), Var::State(1), Var::Param(0)]
            .into_iter()
            .enumerate()
        {
            let slope = model.graph.derivative(model.outputs[0].expr, var);
            let tape = Tape::compile(&model.graph, layout, &[slope]);
            let mut registers = tape.registers::<Interval>();
            for _ in 0..2000 {
                let q = [range(&mut dice), range(&mut dice), range(&mut dice)];
                let from = [0, 1, 2].map(|i| inside(&mut dice, q[i]));
                let mut to = from;
                to[index] = inside(&mut dice, q[index]);
                let step = to[index] - from[index];
                tape.eval(&q, &mut registers);
                let slope = tape.output(0, &registers);
                if step == 0.0 || slope.is_empty() {
                    continue;
                }
                jumps += usize::from(slope == Interval::ENTIRE);
                let (starts, ends) = (
                    values(from[0], from[1], from[2]),
                    values(to[0], to[1], to[2]),
                );
                // Where a test stays zero, every mixture of the branches is a value all along.
                let stays = starts.len() > 1 && ends.len() > 1;
                for (i, a) in starts.iter().enumerate() {
                    for (j, b) in ends.iter().enumerate() {
                        let quotient = (b - a) / step;
                        if quotient.is_finite() && (!stays || i == j) {
                            let near = interval(quotient - 1e-9, quotient + 1e-9);
                            assert!(
                                slope.intersects(near),
                                "{text} by {var:?} from {from:?} to {to:?}: {quotient} not in {slope}"
                            );
                        }
                    }
                }
            }
        }
        assert!(jumps > 50, "{text}: {jumps}");
    }
}

/// Along `x = x0 + t`, where the branch is decided on the whole box, its own series.
#[test]
fn series_follow_the_branch_that_is_taken() {
    let model = model("if x > 0 then x^2 else 3*x - v");
    let tape = SeriesTape::compile(&model.graph, model.layout(), &[model.outputs[0].expr]);
    for (start, wanted) in [
        (2.0, Some([4.0, 4.0, 1.0])),
        (-2.0, Some([-7.0, 3.0, 0.0])),
        (0.0, None),
    ] {
        let mut coefficients: Coefficients<Interval> = tape.coefficients(2);
        let quantities: Vec<usize> = tape.quantities().collect();
        for (position, quantity) in quantities.into_iter().enumerate() {
            let series = if quantity == 0 {
                [start, 1.0, 0.0]
            } else {
                [1.0, 0.0, 0.0]
            };
            for (order, value) in series.into_iter().enumerate() {
                tape.set_quantity(position, order, Interval::point(value), &mut coefficients);
            }
        }
        let mut smooth = tape.compute_constants(&mut coefficients).is_smooth();
        for order in 0..3 {
            smooth &= Orders::compute(&tape, order, &mut coefficients);
        }
        assert_eq!(smooth, wanted.is_some());
        for (order, value) in wanted.into_iter().flatten().enumerate() {
            let found = tape.output(0, order, &coefficients);
            assert!(
                found.contains(value) && found.width() < 1e-12,
                "{start} {order}: {found}"
            );
        }
    }
}

/// Runs one order of a series.
struct Orders<'a>(&'a SeriesTape, usize, &'a mut Coefficients<Interval>);

impl Orders<'_> {
    fn compute(tape: &SeriesTape, order: usize, coefficients: &mut Coefficients<Interval>) -> bool {
        use veribound_interval::lanes::Value;
        Interval::run(Orders(tape, order, coefficients))
    }
}

impl veribound_interval::lanes::Kernel<Interval> for Orders<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<A: veribound_interval::lanes::Arithmetic<Value = Interval>>(self) -> bool {
        self.0.compute::<A>(self.1, self.2).is_smooth()
    }
}

#[test]
fn outputs_with_if_are_told() {
    let shown = |output: &str| {
        let text = model(output).describe();
        let line = text
            .lines()
            .find(|line| line.starts_with("  y "))
            .unwrap()
            .to_owned();
        line.split("  error").next().unwrap()[5..].trim().to_owned()
    };
    for (output, wanted) in [
        ("if x > 0 then 2*x else -1", "= if x > 0 then x*2 else -1"),
        (
            "1 + (if x <= v then k else 0)*2",
            "= 1 + 2*(if v > x then k else 0)",
        ),
        (
            "if x > 0 and not v == 1 then 1 else 2",
            "= if x > 0 and v != 1 then 1 else 2",
        ),
    ] {
        assert_eq!(shown(output), wanted);
    }
}
