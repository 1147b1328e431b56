//! Models on which other programs were reported to be wrong or never to end: every solution is enclosed, by every engine
//! that can, in few steps. Docstrings name the reports; `docs/known-bugs-of-others.md` lists all of them.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use common::stem::bounce;
use common::{interval, read};
use std::f64::consts::PI;
use veribound_flow::engine::{Engine, Engines, Task};
use veribound_flow::form::{Effort, Enclosure, FormOptions, Stretch};
use veribound_interval::{Decimal, Interval};

/// Rounding of closed forms in plain floating point, for sizes around one.
const SLACK: f64 = 1e-9;

/// A model with all that its text allows, and stretches.
struct Case {
    engines: Engines,
    states: Vec<Interval>,
    params: Vec<Interval>,
    stretches: Vec<Stretch>,
}

impl Case {
    fn new(text: &str, lengths: &[&str]) -> Case {
        Case::driven(text, &lengths.iter().map(|h| (*h, 0.0)).collect::<Vec<_>>())
    }

    /// Lengths of stretches, and the input of each.
    fn driven(text: &str, stretches: &[(&str, f64)]) -> Case {
        let text = format!("format = 1\n{text}\n");
        let model = read("reported", &text);
        let stretches = stretches.iter().map(|(h, u)| Stretch {
            inputs: vec![Interval::point(*u); model.inputs.len()],
            dt: Decimal::parse(h).unwrap().to_interval(),
        });
        Case {
            engines: Engines::new(&model),
            states: model.states.iter().map(|state| state.init).collect(),
            params: model.params.iter().map(|param| param.bounds).collect(),
            stretches: stretches.collect(),
        }
    }

    fn ask(&self, engine: Engine, options: FormOptions, effort: Effort) -> Enclosure {
        let task = Task {
            states: &self.states,
            params: &self.params,
            stretches: &self.stretches,
            options,
            effort,
        };
        self.engines.enclose(engine, task, &|_| true).enclosure
    }

    /// Asks every engine; whatever it proves has `exact` in it, solutions at a time, and the usual choice goes to the end.
    fn holds(&self, exact: &dyn Fn(f64) -> Vec<Vec<f64>>) -> Enclosure {
        let ask = |engine| self.ask(engine, FormOptions::default(), Effort::default());
        for engine in Engine::ALL {
            let found = ask(engine);
            let mut time = 0.0;
            for (k, (end, tube)) in found.ends.iter().zip(&found.tubes).enumerate() {
                let h = self.stretches[k].dt.mid();
                for share in [0.0, 0.3, 0.77, 1.0] {
                    for x in exact(time + share * h) {
                        assert_inside(&x, tube, &format!("{engine:?}, on the way {k} {share}"));
                        if share == 1.0 {
                            assert_inside(&x, end, &format!("{engine:?}, end {k}"));
                        }
                    }
                }
                time += h;
            }
        }
        let found = ask(Engine::Auto);
        assert!(found.stopped.is_none(), "{:?}", found.stopped);
        found
    }
}

fn assert_inside(x: &[f64], bounds: &[Interval], what: &str) {
    for (i, (x, bounds)) in x.iter().zip(bounds).enumerate() {
        let wide = bounds.inflate(SLACK * (1.0 + x.abs()));
        assert!(wide.contains(*x), "{what}: state {i}: {x:?} in {bounds}");
    }
}

/// The number, but for rounding.
fn is_near(x: Interval, value: f64) -> bool {
    x.contains(value) && x.width() < 1e-12
}

/// The widest state at the end.
fn widest(found: &Enclosure) -> f64 {
    let ends = found.ends.last().unwrap();
    ends.iter().map(|x| x.width()).fold(0.0, f64::max)
}

/// ValidatedNumerics.jl#191, IntervalArithmetic.jl#524, RangeEnclosures.jl#91: `if x > 2` on an interval took one branch.
#[test]
fn an_if_on_an_interval_takes_both_branches() {
    let case = Case::new(
        "states = [\"x\"]\ninit.x = [1, 3]\nder.x = \"if x > 2 then 1 else 2\"\noutputs.y = \"x +- 1\"",
        &["0.25"; 4],
    );
    let exact = |x0: f64, t: f64| match (2.0 - x0) / 2.0 {
        passes if passes > t => x0 + 2.0 * t,
        passes if passes > 0.0 => 2.0 + t - passes,
        _ => x0 + t,
    };
    let starts = [1.0, 1.2, 1.7, 1.999, 2.0, 2.001, 2.5, 3.0];
    let found = case.holds(&|t| starts.map(|x0| vec![exact(x0, t)]).to_vec());
    let end = found.ends[3][0];
    assert!(
        (end.lo() - 2.5).abs() < 1e-6 && (end.hi() - 4.0).abs() < 1e-6,
        "{end}"
    );
}

/// casadi#2669: at the switch of `if x > 0.25 then 0 else 0.1` an integrator looped for ever.
#[test]
fn what_an_if_stops_stays() {
    let case = Case::new(
        "states = [\"x\"]\ninit.x = 0\nder.x = \"if x > 0.25 then 0 else 0.1\"\noutputs.y = \"x +- 1\"",
        &["1"; 4],
    );
    let found = case.holds(&|t| vec![vec![f64::min(0.1 * t, 0.25)]]);
    assert!(widest(&found) < 1e-9, "{:?}", found.ends);
    assert!(found.steps < 100, "{} steps", found.steps);
}

/// casadi#4393, diffrax#380: a guard at 0.5 was ignored, or met in one direction only.
#[test]
fn guards_are_met_in_both_directions() {
    for (start, rate) in [(0.0, 1.0), (1.0, -1.0)] {
        let sign = if rate > 0.0 { ">" } else { "<" };
        let text = format!(
            "states = [\"x\", \"m\"]\ninit = {{ x = {start}, m = 0 }}\nder = {{ x = \"{rate}\", m = \"0\" }}\n\
             outputs.y = \"x +- 1\"\njumps.event = {{ when = \"x {sign} 0.5 and m < 0.5\", set = {{ m = \"1\" }} }}"
        );
        let case = Case::new(&text, &["0.3"; 3]);
        let found = case.holds(&|t| {
            let jumped = f64::from(u8::from(t > 0.5));
            vec![vec![start + rate * t, jumped]]
        });
        for (end, told) in found.ends.iter().zip([0.0, 1.0, 1.0]) {
            assert!(is_near(end[1], told), "{end:?}");
        }
    }
}

/// llnl/sundials#881, stan-dev/docs#213: a tenth of a second at a rate of 10000 is stepped over, unless somebody divides
/// the time by hand.
#[test]
fn a_short_pulse_is_not_stepped_over() {
    let case = Case::new(
        "states = [\"s\", \"x\"]\ninit = { s = 0, x = 0 }\n\
         der = { s = \"1\", x = \"if s > 20 and s < 20.1 then 10000 else 0\" }\noutputs.y = \"x +- 1\"",
        &["15", "15"],
    );
    let found = case.holds(&|t| vec![vec![t, 10_000.0 * (t - 20.0).clamp(0.0, 0.1)]]);
    // A pulse shorter than a step is swept over by the hull of both branches.
    assert!(found.ends[1][1].width() < 200.0, "{:?}", found.ends[1]);
    let closed = case.ask(Engine::Closed, FormOptions::default(), Effort::default());
    assert!(closed.ends[1][1].width() < 1e-3, "{:?}", closed.ends[1]);
}

/// llnl/sundials#881, stan example-models#159: a root function that stays zero is an error. Here both sides of it, and all in between, are solutions.
#[test]
fn a_root_that_stays_zero() {
    let case = Case::new(
        "states = [\"y\", \"x\"]\ninit = { y = 0, x = 0 }\nder = { y = \"0\", x = \"if y > 0 then 1 else -1\" }\n\
         outputs.z = \"x +- 1\"",
        &["0.5"; 4],
    );
    let found = case.holds(&|t| [-1.0, -0.5, 0.0, 1.0].map(|s| vec![0.0, s * t]).to_vec());
    assert!(found.ends[3][1].width() < 8.0, "{:?}", found.ends[3]);
    let boxes = case.ask(Engine::Boxes, FormOptions::default(), Effort::default());
    assert!(boxes.ends[3][1].width() < 4.0 + 1e-9, "{:?}", boxes.ends[3]);
}

/// scipy#18039, OpenModelica#7581: a system in pieces was integrated across their borders, silently wrong. Half turns of an oscillator
/// whose spring is four times as stiff on one side are known.
#[test]
fn an_oscillator_in_two_pieces_keeps_its_period() {
    let case = Case::new(
        "states = [\"x\", \"v\"]\ninit = { x = 1, v = 0 }\nder = { x = \"v\", v = \"if x > 0 then -x else -4*x\" }\n\
         outputs.y = \"x +- 1\"",
        &["1"; 40],
    );
    let exact = |t: f64| {
        let since = (t + PI / 2.0) % (1.5 * PI);
        if since < PI {
            vec![since.sin(), since.cos()]
        } else {
            let turn = 2.0 * (since - PI);
            vec![-0.5 * turn.sin(), -turn.cos()]
        }
    };
    let found = case.holds(&|t| vec![exact(t)]);
    assert!(widest(&found) < 1e-7, "{:?}", found.ends[39]);
}

/// AMICI#2861 with #2804: two events at the same time could not be simulated, whatever the tolerances.
#[test]
fn two_events_at_once() {
    let case = Case::new(
        "states = [\"a\", \"b\", \"s\", \"one\", \"two\"]\ninit = { a = 1, b = 2, s = 0, one = 0, two = 0 }\n\
         der = { a = \"1\", b = \"1\", s = \"1\", one = \"0\", two = \"0\" }\noutputs.y = \"a +- 1\"\n\
         [jumps]\nfirst = { when = \"s >= 1 and one < 0.5\", set = { a = \"a + 10\", one = \"1\" } }\n\
         second = { when = \"s >= 1 and two < 0.5\", set = { b = \"b + 10\", two = \"1\" } }",
        &["0.6"; 3],
    );
    let found = case.holds(&|t| {
        let jumped = f64::from(u8::from(t > 1.0));
        vec![vec![
            1.0 + t + 10.0 * jumped,
            2.0 + t + 10.0 * jumped,
            t,
            jumped,
            jumped,
        ]]
    });
    assert!(widest(&found) < 1e-9, "{:?}", found.ends[2]);
}

/// AMICI#772, AMICI#2724, AMICI#1317: a step function whose step is at the start: stuck in an event, or begun with the wrong branch.
#[test]
fn an_event_at_the_start() {
    let case = Case::new(
        "states = [\"s\", \"x\", \"m\"]\ninit = { s = 0, x = 0, m = 0 }\n\
         der = { s = \"1\", x = \"if s >= 0 then 1 - x else 5\", m = \"0\" }\noutputs.y = \"x +- 1\"\n\
         jumps.first = { when = \"s >= 0 and m < 0.5\", set = { m = \"1\" } }",
        &["0.5"; 4],
    );
    let found = case.holds(&|t| {
        let jumped = f64::from(u8::from(t > 0.0));
        vec![vec![t, 1.0 - (-t).exp(), jumped]]
    });
    assert!(found.steps < 200, "{}", found.steps);
    assert!(found.ends[3][2].contains(1.0) && found.ends[3][1].width() < 0.05);
}

/// ModelingToolkit.jl#3327, DifferentialEquations.jl#703: the cosine of time passes -1/2 and 1/2; a solver took two million steps at the first one.
#[test]
fn events_do_not_trap_time() {
    let case = Case::new(
        "states = [\"s\", \"z\"]\ninit = { s = 0, z = 0 }\noutputs.y = \"z +- 1\"\n\
         der = { s = \"1\", z = \"sign(cos(s) - 0.5) + sign(cos(s) + 0.5)\" }",
        &["0.7"; 9],
    );
    let exact = |t: f64| {
        let borders = [PI / 3.0, 2.0 * PI / 3.0, 4.0 * PI / 3.0, 5.0 * PI / 3.0];
        let [a, b, c, d] = borders.map(|border| (t - border).max(0.0));
        2.0 * t - 2.0 * (a + b) + 2.0 * (c + d)
    };
    let found = case.holds(&|t| vec![vec![t, exact(t)]]);
    assert!(
        widest(&found) < 1e-6 && found.steps < 1000,
        "{:?} {}",
        found.ends[8],
        found.steps
    );
}

/// OpenModelica#8461, #13912, #12190, PR#16022: bearing friction never settled to stuck where the motor's speed passed zero. Two motors
/// with friction each, one of which stops while the other turns.
#[test]
fn friction_settles() {
    let case = Case::driven(
        "states = [\"v\", \"w\"]\ninputs = [\"u\"]\ninit = { v = 0, w = 0 }\noutputs.y = \"v +- 1\"\n\
         der = { v = \"u - friction(v, u, 0.1)\", w = \"2*u - friction(w, 2*u, 0.3)\" }",
        &[
            ("1", 0.5),
            ("1", -0.125),
            ("1", -0.125),
            ("1", 0.05),
            ("1", -0.15),
        ],
    );
    // 0.4 after a second; then -0.225 a second until 0 and -0.025 after it; at rest from the first slower sample on.
    let first = |t: f64| {
        let turn = 1.0 + 0.4 / 0.225;
        match t {
            t if t <= 1.0 => 0.4 * t,
            t if t <= turn => 0.4 - 0.225 * (t - 1.0),
            t if t <= 3.0 => -0.025 * (t - turn),
            t if t <= 4.0 => (-0.025 * (3.0 - turn) + 0.15 * (t - 3.0)).min(0.0),
            t => -0.05 * (t - 4.0),
        }
    };
    // 0.7 after a second; -0.55 a second until it stops; neither -0.25 nor 0.1 nor -0.3 moves it.
    let second = |t: f64| f64::min(0.7 * t, (0.7 - 0.55 * (t - 1.0)).max(0.0));
    let found = case.holds(&|t| vec![vec![first(t), second(t)]]);
    assert_eq!(
        (found.ends[3][0], found.ends[3][1]),
        (Interval::ZERO, Interval::ZERO)
    );
    assert!(
        widest(&found) < 1e-9 && found.steps < 200,
        "{:?} {}",
        found.ends,
        found.steps
    );
}

/// ModelicaStandardLibrary#4129, #4272: friction on something whose speed is prescribed was singular where it locks. A mass on a belt, whose
/// speed is an input that jumps.
#[test]
fn friction_against_a_prescribed_speed() {
    let case = Case::driven(
        "states = [\"v\"]\ninputs = [\"u\"]\ninit = { v = 0 }\noutputs.y = \"v +- 1\"\nder.v = \"-friction(v - u, 0, 1)\"",
        &[("1", 0.5), ("0.75", -0.5), ("1", -0.5), ("1", 0.0)],
    );
    let exact = |t: f64| match t {
        t if t <= 1.0 => t.min(0.5),
        t if t <= 2.75 => (0.5 - (t - 1.0)).max(-0.5),
        t => (-0.5 + (t - 2.75)).min(0.0),
    };
    let found = case.holds(&|t| vec![vec![exact(t)]]);
    assert!(widest(&found) < 1e-9, "{:?}", found.ends);
}

/// drake#2537: friction that is steep instead of a jump lets creep what should stand. A block on a slope, for half an hour, and
/// the smallest pull above the level moves it.
#[test]
fn a_block_on_a_slope_stands() {
    let text = "states = [\"x\", \"v\"]\ninit = { x = 0, v = 0 }\ninputs = [\"u\"]\noutputs.y = \"x +- 1\"\n\
                der = { x = \"v\", v = \"u - friction(v, u, 2)\" }";
    let stands = Case::driven(text, &[("1800", 2.0)]).holds(&|_| vec![vec![0.0, 0.0]]);
    for bounds in [&stands.ends[0], &stands.tubes[0]] {
        assert!(bounds.iter().all(|x| is_near(*x, 0.0)), "{bounds:?}");
    }
    let moves = 2.0_f64.next_up();
    let case = Case::driven(text, &[("1800", moves)]);
    let found = case.holds(&|t| vec![vec![0.5 * (moves - 2.0) * t * t, (moves - 2.0) * t]]);
    assert!(found.ends[0][1].hi() > 0.0);
}

/// diffsol/examples/bouncing-ball: the official example puts the ball above the ground by an epsilon. Ten metres, 0.8 of the speed.
#[test]
fn a_ball_needs_no_epsilon() {
    let case = Case::new(
        "states = [\"h\", \"v\"]\ninit = { h = 10, v = 0 }\noutputs.y = \"h +- 1\"\nder = { h = \"v\", v = \"-9.81\" }\n\
         jumps.bounce = { when = \"h <= 0 and v < 0\", set = { v = \"-0.8*v\" } }",
        &["0.5"; 16],
    );
    let found = case.holds(&|t| {
        let mut state = [10.0, 0.0];
        bounce(&mut state, [0.8, 9.81], t);
        vec![state.to_vec()]
    });
    assert!(widest(&found) < 1e-6, "{:?}", found.ends[15]);
    assert!(found.ends.iter().all(|end| end[0].lo() > -1e-9));
    // A floor holds a face of a box, at all times.
    let boxes = case.ask(Engine::Boxes, FormOptions::default(), Effort::default());
    assert!(boxes.tubes.len() > 3 && boxes.tubes.iter().all(|tube| tube[0].lo() > -1e-9));
}

/// ReachabilityAnalysis.jl#468: horizons of 0.03 and 0.04 gave flow pipes that contradict each other.
#[test]
fn horizons_do_not_contradict() {
    let text = "states = [\"x\", \"v\", \"u\"]\ninit = { x = 1.2, v = 0.2, u = -0.78 }\noutputs.y = \"x +- 1\"\n\
                der = { x = \"v\", v = \"2*sin(x) + 8*u\", u = \"0\" }";
    let sought = [["0.03"].as_slice(), &["0.03", "0.01"], &["0.04"]];
    let [short, both, long] = sought.map(|lengths| {
        let options = FormOptions {
            order: Some(10),
            degree: Some(1),
            ..FormOptions::default()
        };
        Case::new(text, lengths).ask(Engine::Forms, options, Effort::default())
    });
    assert_eq!(short.ends[0], both.ends[0]);
    assert_eq!(short.tubes[0], both.tubes[0]);
    for i in 0..3 {
        assert!(both.ends[1][i].intersects(long.ends[0][i]));
        assert!(short.tubes[0][i].intersects(long.tubes[0][i]));
        assert!(short.ends[0][i].intersects(long.tubes[0][i]) && long.ends[0][i].width() < 1e-12);
    }
}

/// dreal3#112: `x1' = 0, x2' = 1` for exactly a second was unsatisfiable, and satisfiable for 0.9999 to 1 s.
#[test]
fn a_time_and_a_wider_one_agree() {
    let text = "states = [\"x1\", \"x2\"]\ninit = { x1 = 0, x2 = 0 }\noutputs.y = \"x2 +- 1\"\nder = { x1 = \"0\", x2 = \"1\" }";
    let mut case = Case::new(text, &["1"]);
    case.holds(&|t| vec![vec![0.0, t]]);
    for engine in Engine::ALL {
        let ask = |case: &Case| case.ask(engine, FormOptions::default(), Effort::default());
        case.stretches[0].dt = Interval::ONE;
        let exactly = ask(&case);
        case.stretches[0].dt = interval(0.9999, 1.0);
        let about = ask(&case);
        let (Some(exactly), Some(about)) = (exactly.ends.first(), about.ends.first()) else {
            assert_ne!(engine, Engine::Auto);
            continue;
        };
        assert!(about[1].contains(0.9999) && about[1].contains(1.0));
        let pairs = exactly.iter().zip(about);
        assert!(pairs.into_iter().all(|(x, wide)| x.intersects(*wide)));
        assert!(is_near(exactly[0], 0.0) && exactly[1].contains(1.0));
    }
}

/// dreal2#61: `v' = k s` with k in [1.9, 2.1] for 17 s was unsatisfiable with one step size and satisfiable with another.
#[test]
fn step_sizes_do_not_change_what_is_possible() {
    for pieces in [1, 17, 170] {
        let length = ["17", "1", "0.1"][usize::from(pieces > 1) + usize::from(pieces > 17)];
        let case = Case::new(
            "states = [\"s\", \"v\"]\ninit = { s = 0, v = 0 }\noutputs.y = \"v +- 1\"\nparams.k = [1.9, 2.1]\n\
             der = { s = \"1\", v = \"k*s\" }",
            &vec![length; pieces],
        );
        let found = case.holds(&|t| [1.9, 2.0, 2.1].map(|k| vec![t, 0.5 * k * t * t]).to_vec());
        let v = found.ends[pieces - 1][1];
        assert!(v.contains(289.0) && v.width() < 28.9 * (1.0 + 1e-6), "{v}");
        for (steepest, order) in [(0.05, 4), (2.0, 27)] {
            let options = FormOptions {
                steepest,
                order: Some(order),
                ..FormOptions::default()
            };
            let other = case.ask(Engine::Forms, options, Effort::default());
            assert!(other.ends[pieces - 1][1].contains(289.0));
        }
    }
}

/// dreal2#62: an exception of the integrator became "unsatisfiable"; van der Pol's oscillator from (1, 0.5) does pass x = 0. So does what is proved, or
/// it ends before.
#[test]
fn what_is_reached_is_not_excluded() {
    let case = Case::new(
        "states = [\"x\", \"y\"]\ninit = { x = 1, y = 0.5 }\noutputs.z = \"x +- 1\"\nder = { x = \"y\", y = \"(1 - x^2)*y - x\" }",
        &["0.5"; 20],
    );
    for engine in Engine::ALL {
        for steepest in [0.1, 0.7, 20.0] {
            let options = FormOptions {
                steepest,
                ..FormOptions::default()
            };
            let found = case.ask(engine, options, Effort::default());
            let is_met = found.tubes.iter().any(|tube| tube[0].contains(0.0));
            assert!(is_met || found.stopped.is_some(), "{engine:?} {steepest}");
            assert!(is_met || engine != Engine::Auto);
        }
    }
}

/// IntervalRootFinding.jl#184, #146: `x + sign(x)` was said to have a single root where it has none. Solutions of `x' = -(x + sign(x))` come to rest
/// at zero, where the sign is all of [-1, 1], in finite time, and nowhere else.
#[test]
fn a_sign_has_its_root_at_the_jump() {
    let case = Case::new(
        "states = [\"x\"]\ninit.x = [-5, 5]\nder.x = \"-(x + sign(x))\"\noutputs.y = \"x +- 1\"",
        &["0.25"; 8],
    );
    let exact = |x0: f64, t: f64| x0.signum() * ((x0.abs() + 1.0) * (-t).exp() - 1.0).max(0.0);
    let starts = [-5.0, -0.48, -1e-3, 0.0, 1e-3, 0.48, 5.0];
    let found = case.holds(&|t| starts.map(|x0| vec![exact(x0, t)]).to_vec());
    // The last ones stop after ln(6) = 1.79 s.
    assert_eq!(found.ends[7][0], Interval::ZERO);
}

/// CORA#73, #75: the reach set of a mass on a cubic spring exploded.
#[test]
fn a_cubic_spring_does_not_explode() {
    let case = Case::new(
        "states = [\"x\", \"v\"]\ninit = { x = [0.9, 1.1], v = [-0.1, 0.1] }\noutputs.y = \"x +- 1\"\n\
         params.d = [0.4, 0.6]\nder = { x = \"v\", v = \"-x - x^3 - d*v\" }",
        &["1"; 20],
    );
    let found = case.holds(&|_| vec![vec![]]);
    assert!(widest(&found) < 0.05, "{:?}", found.ends[19]);
}

/// TaylorModels.jl#114, #111: a horizon that is a little longer failed, though the set shrinks.
#[test]
fn a_set_that_shrinks_is_followed_for_long() {
    let case = Case::new(
        "states = [\"x\"]\ninit.x = [0.5, 1]\nder.x = \"-x^3\"\noutputs.y = \"x +- 1\"",
        &["2"; 50],
    );
    let exact = |x0: f64, t: f64| x0 / (1.0 + 2.0 * x0 * x0 * t).sqrt();
    let found = case.holds(&|t| [0.5, 0.7, 1.0].map(|x0| vec![exact(x0, t)]).to_vec());
    let x = found.ends[49][0];
    let inner = exact(1.0, 100.0) - exact(0.5, 100.0);
    assert!(x.width() < 1.2 * inner, "{x} {inner}");
}

/// TaylorIntegration.jl#66: where the solution is a polynomial, the step was infinite.
#[test]
fn polynomial_solutions_take_finite_steps() {
    let case = Case::new(
        "states = [\"x\", \"v\"]\ninit = { x = 0, v = 0 }\nder = { x = \"v\", v = \"1\" }\noutputs.y = \"x +- 1\"",
        &["1000", "1e-6"],
    );
    let found = case.holds(&|t| vec![vec![0.5 * t * t, t]]);
    assert!((2..1000).contains(&found.steps), "{}", found.steps);
    let x = found.ends[1][0];
    assert!(
        x.contains(0.5 * 1_000.000_001_f64.powi(2)) && x.width() < 1e-6,
        "{x}"
    );
}

/// CORA#51, Codac's documentation of `CtcLohner`: steps that are too long were an error, and steps of 1e-17 the end. One stretch of any
/// length is divided as it needs; what cannot be passed ends it with what was proved.
#[test]
fn long_stretches_are_divided() {
    let case = Case::new(
        "states = [\"x\", \"y\"]\ninit = { x = 1, y = 0 }\nder = { x = \"10*y\", y = \"-10*x\" }\noutputs.z = \"x +- 1\"",
        &["50"],
    );
    let found = case.holds(&|t| vec![vec![(10.0 * t).cos(), -(10.0 * t).sin()]]);
    assert!(widest(&found) < 1e-6, "{:?}", found.ends);
    let pole = Case::new(
        "states = [\"x\"]\ninit.x = 1\nder.x = \"x^2\"\noutputs.y = \"x +- 1\"",
        &["0.5", "0.4", "0.2"],
    );
    let found = pole.ask(Engine::Auto, FormOptions::default(), Effort::default());
    assert_eq!(found.ends.len(), 2);
    assert!(
        found.stopped.is_some() && found.steps < 10_000,
        "{}",
        found.steps
    );
    assert!(found.ends[1][0].contains(10.0) && found.ends[1][0].width() < 1e-6);
}
