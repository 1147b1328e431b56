//! Comparison bounds: random wide sets and true solutions, exact hulls, and models without an order.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use common::models::{self, Target};
use common::truth::{Events, Sim};
use common::{Rng, Trials, interval, monotone, number, read};
use veribound_flow::comparison::{Cause, Compared, Comparison, Disorder};
use veribound_flow::form::{Effort, Flow, FormOptions, Obstacle, Stretch};
use veribound_interval::Interval;
use veribound_model::{Model, Var};

/// Error of the simulator in `common::truth`.
const SLACK: f64 = 4e-9;

const ONCE: Effort = Effort {
    excess: 0.15,
    parts: 1,
};

struct Engine {
    flow: Flow,
    comparison: Comparison,
}

impl Engine {
    fn new(model: &Model) -> Engine {
        Engine {
            flow: Flow::new(model),
            comparison: Comparison::new(model),
        }
    }

    fn enclose(
        &self,
        start: &[Interval],
        params: &[Interval],
        stretches: &[Stretch],
        effort: Effort,
    ) -> Result<Compared, Vec<Disorder>> {
        let options = FormOptions::default();
        self.comparison.enclose(
            &self.flow,
            (start, params),
            stretches,
            (options, effort, f64::INFINITY),
            &|_| true,
        )
    }
}

#[derive(Debug, Default)]
struct Tally {
    events: Events,
    /// Runs with corners, without any, and those that ended early.
    ordered: u64,
    refused: u64,
    ended: u64,
    /// Runs that kept nothing.
    whole: u64,
    trials: Trials,
}

fn draw(rng: &mut Rng, lo: f64, hi: f64, special: &[f64]) -> Interval {
    let at = if !special.is_empty() && rng.chance(0.3) {
        rng.pick(special)
    } else {
        rng.between(lo, hi)
    };
    let width = match rng.below(3) {
        0 => 0.0,
        1 => rng.unit() * 0.01 * (hi - lo),
        _ => rng.unit() * 0.5 * (hi - lo),
    };
    let share = rng.pick(&[0.0, 0.5, 1.0, rng.clone().unit()]);
    interval(
        (at - share * width).max(lo),
        (at + (1.0 - share) * width).min(hi),
    )
}

fn attack(target: &Target, engine: &Engine, rng: &mut Rng, tally: &mut Tally) {
    let list = |rng: &mut Rng, ranges: &[(f64, f64, &'static [f64])]| -> Vec<Interval> {
        let ranges = ranges.iter();
        ranges
            .map(|(lo, hi, special)| draw(rng, *lo, *hi, special))
            .collect()
    };
    let start = list(rng, target.states);
    let params: Vec<Interval> = target
        .params
        .iter()
        .map(|(lo, hi)| draw(rng, *lo, *hi, &[]))
        .collect();
    let lengths: Vec<f64> = (0..1 + rng.below(4))
        .map(|_| rng.between(0.01, 0.5))
        .collect();
    let stretches: Vec<Stretch> = lengths
        .iter()
        .map(|h| Stretch {
            inputs: list(rng, target.inputs),
            dt: Interval::point(*h),
        })
        .collect();
    let compared = match engine.enclose(&start, &params, &stretches, ONCE) {
        Ok(compared) => compared,
        Err(disorders) => {
            tally.refused += 1;
            assert!(disorders.iter().all(|d| d.since >= 0.0));
            return;
        }
    };
    let proved = &compared.enclosure;
    assert!(!compared.corners.is_empty() || proved.stopped.is_some() || !compared.kept.is_empty());
    assert_eq!(
        proved.stopped.is_none(),
        proved.ends.len() == stretches.len()
    );
    match proved.stopped {
        None => tally.ordered += 1,
        Some(_) => tally.ended += 1,
    }
    tally.whole += u64::from(compared.kept.is_empty());
    for _ in 0..24 {
        // Corners are where bounds are attained.
        let extreme = rng.chance(0.5);
        let point = |rng: &mut Rng, x: &Interval| match extreme {
            true => rng.pick(&[x.lo(), x.hi()]),
            false => rng.inside(*x),
        };
        let x: Vec<f64> = start.iter().map(|x| point(rng, x)).collect();
        let p: Vec<f64> = params.iter().map(|x| point(rng, x)).collect();
        let mut sim = Sim::new(target.truth, &x, &p);
        for (k, stretch) in stretches.iter().enumerate().take(proved.ends.len()) {
            let cuts = 1 + rng.below(3);
            for _ in 0..cuts {
                let u: Vec<f64> = stretch.inputs.iter().map(|x| point(rng, x)).collect();
                sim.advance(&u, lengths[k] / cuts as f64, rng);
                inside(target, &sim, &proved.tubes[k], "tube", &compared);
                tally.trials.checks += 1;
            }
            inside(target, &sim, &proved.ends[k], "end", &compared);
            tally.trials.checks += 1;
        }
        tally.events.add(sim.events);
        tally.trials.solutions += 1;
    }
}

fn inside(target: &Target, sim: &Sim, boxes: &[Interval], what: &str, compared: &Compared) {
    for (i, (x, b)) in sim.x.iter().zip(boxes).enumerate() {
        let slack = SLACK * (1.0 + x.abs());
        assert!(
            *x >= b.lo() - slack && *x <= b.hi() + slack,
            "{} {what}: state {i} is {x:?}, outside {b:?} by {:e}; {compared:?}",
            target.name,
            (b.lo() - x).max(x - b.hi()),
        );
    }
}

fn attack_all(targets: &[&Target], rounds: u64) -> Tally {
    let mut rng = Rng(number("VERIBOUND_SEED", 11));
    let mut all = Tally::default();
    for target in targets {
        let engine = Engine::new(&read(target.name, target.text));
        let mut tally = Tally::default();
        for _ in 0..rounds {
            attack(target, &engine, &mut rng, &mut tally);
        }
        println!("{:40} {tally:?}", target.name);
        all.events.add(tally.events);
        all.ordered += tally.ordered;
        all.whole += tally.whole;
        all.trials.add(tally.trials);
    }
    println!("{all:?}");
    all.trials.told("corners");
    all
}

#[test]
fn no_solution_is_lost_between_corners() {
    let rounds = number("VERIBOUND_ROUNDS", 8);
    let all = attack_all(&monotone::ALL, rounds);
    assert!(all.ordered > 3 * rounds && all.whole > rounds && all.trials.checks > 250 * rounds);
    assert!(all.events.captures > 10 * rounds && all.events.crossings > 10 * rounds);
}

#[test]
fn no_solution_is_lost_where_the_order_is_in_doubt() {
    let rounds = number("VERIBOUND_ROUNDS", 1);
    // What jumps everywhere takes long and shows little.
    let jumps = |target: &Target| ["floor", "encoder", "angle"].contains(&target.name);
    let targets: Vec<&Target> = models::ALL
        .into_iter()
        .filter(|target| rounds > 1 || !jumps(target))
        .collect();
    let all = attack_all(&targets, rounds);
    assert!(all.trials.checks > 50 * rounds);
}

/// A model whose true solutions are sampled at the ends of stretches, and what is uncertain.
struct Sampled<'a> {
    text: &'a str,
    truth: common::truth::Truth,
    start: Vec<Interval>,
    params: Vec<Interval>,
    stretches: Vec<Stretch>,
}

impl Sampled<'_> {
    /// Proves bounds, samples solutions from the corners and a grid of `grid` values, and returns the largest ratio of
    /// widths, for every state.
    fn ratios(&self, grid: usize) -> (Compared, Vec<f64>) {
        let engine = Engine::new(&read("sampled", self.text));
        // All samples count, not only the last, by which sets are divided.
        let effort = Effort {
            excess: 0.01,
            ..Effort::default()
        };
        let compared = engine.enclose(&self.start, &self.params, &self.stretches, effort);
        let compared = compared.unwrap();
        let states = self.start.len();
        assert_eq!(
            compared.enclosure.ends.len(),
            self.stretches.len(),
            "{compared:?}"
        );
        let uncertain: Vec<Interval> = self.start.iter().chain(&self.params).copied().collect();
        let inputs = self.stretches[0].inputs.len();
        let mut hulls = vec![vec![Interval::EMPTY; states]; self.stretches.len()];
        let total = uncertain.iter().filter(|x| !x.is_point()).count() + inputs;
        for number in 0..grid.pow(total as u32) {
            let mut digits = number;
            let mut digit = || {
                let digit = digits % grid;
                digits /= grid;
                digit as f64 / (grid - 1) as f64
            };
            let mut at = |x: Interval| match x.is_point() {
                true => x.lo(),
                false => (x.lo() + digit() * x.width()).clamp(x.lo(), x.hi()),
            };
            let point: Vec<f64> = uncertain.iter().map(|x| at(*x)).collect();
            let shares: Vec<f64> = (0..inputs).map(|_| at(interval(0.0, 1.0))).collect();
            let mut sim = Sim::new(self.truth, &point[..states], &point[states..]);
            let mut rng = Rng(1);
            for (hull, stretch) in hulls.iter_mut().zip(&self.stretches) {
                let input = |(x, share): (&Interval, &f64)| x.lo() + share * x.width();
                let u: Vec<f64> = stretch.inputs.iter().zip(&shares).map(input).collect();
                sim.advance(&u, stretch.dt.mid(), &mut rng);
                for (hull, x) in hull.iter_mut().zip(&sim.x) {
                    *hull = hull.hull(Interval::point(*x));
                }
            }
        }
        let mut worst = vec![0.0_f64; states];
        for (inner, outer) in hulls.iter().zip(&compared.enclosure.ends) {
            for (worst, (inner, outer)) in worst.iter_mut().zip(inner.iter().zip(outer)) {
                let slack = SLACK * (1.0 + inner.mag());
                assert!(outer.lo() <= inner.lo() + slack && outer.hi() >= inner.hi() - slack);
                if inner.width() > 1e-6 {
                    *worst = worst.max(outer.width() / inner.width());
                }
            }
        }
        (compared, worst)
    }
}

fn held(inputs: &[Interval], dt: f64, count: usize) -> Vec<Stretch> {
    let stretch = Stretch {
        inputs: inputs.to_vec(),
        dt: Interval::point(dt),
    };
    vec![stretch; count]
}

/// Levels from 0.1 to 1.5 m, so that some spill from the start and some later; the opening between the tanks has no place
/// in the order.
#[test]
fn tanks_from_wide_starts() {
    let tanks = Sampled {
        text: models::TANKS.text,
        truth: models::TANKS.truth,
        start: vec![interval(0.1, 1.5), interval(0.1, 1.0)],
        params: vec![interval(0.36, 0.44), Interval::point(2.0)],
        stretches: held(&[Interval::point(0.35)], 0.5, 14),
    };
    let (compared, worst) = tanks.ratios(3);
    assert_eq!(compared.kept, [Var::Param(0)]);
    assert_eq!(compared.corners, [Var::State(0), Var::State(1)]);
    assert!(worst.iter().all(|ratio| *ratio < 1.2), "{worst:?}");
}

/// Every opening known: the exact hull.
#[test]
fn tanks_whose_openings_are_known() {
    let tanks = Sampled {
        text: models::TANKS.text,
        truth: models::TANKS.truth,
        start: vec![interval(0.1, 1.5), interval(0.1, 1.0)],
        params: vec![Interval::point(0.4), interval(1.0, 3.0)],
        stretches: held(&[interval(0.3, 0.4)], 0.5, 40),
    };
    let (compared, worst) = tanks.ratios(2);
    assert!(compared.kept.is_empty() && compared.disorders.is_empty());
    assert!(worst.iter().all(|ratio| *ratio < 1.001), "{worst:?}");
}

/// Some start, some stick and some turn, all with one input of any course in its interval.
#[test]
fn friction_under_an_input_of_any_course() {
    let slider = Sampled {
        text: monotone::ALL[0].text,
        truth: monotone::ALL[0].truth,
        start: vec![interval(-1.0, 1.5)],
        params: vec![Interval::point(0.5), Interval::point(0.25)],
        stretches: [(-0.4, 0.7), (-1.0, 0.2), (0.1, 0.3)]
            .into_iter()
            .flat_map(|(lo, hi)| held(&[interval(lo, hi)], 0.1, 20))
            .collect(),
    };
    let (compared, worst) = slider.ratios(2);
    assert!(compared.kept.is_empty() && compared.enclosure.stopped.is_none());
    assert!(worst[0] < 1.000_01, "{worst:?}");
}

fn refusal(der: &str, more: &str) -> Result<Compared, Vec<Disorder>> {
    let text = format!(
        "format = 1\nstates = [\"x\", \"y\"]\ninputs = [\"u\"]\n[init]\nx = 0\ny = 0\n[params]\np = [0, 1]\n{der}\n[outputs]\n\
         m = \"x +- 1\"\n{more}"
    );
    let engine = Engine::new(&read("refused", &text));
    let start = [interval(-0.5, 0.5), interval(-0.5, 0.5)];
    let params = [interval(0.2, 0.8)];
    engine.enclose(
        &start,
        &params,
        &held(&[interval(-0.1, 0.1)], 0.25, 8),
        ONCE,
    )
}

/// Where nothing can be said it is said why.
#[test]
fn models_without_an_order() {
    let why = |der: &str| refusal(der, "").unwrap_err();
    // A spring turns the order round.
    let spring = why("[der]\nx = \"y\"\ny = \"u - p - x\"");
    let slope = |d: &Disorder| {
        matches!(
            d.cause,
            Cause::Slope {
                of: 0 | 1,
                by: Var::State(_),
                ..
            }
        )
    };
    assert!(spring.iter().any(slope), "{spring:?}");
    // The slope in x changes its sign.
    let product = why("[der]\nx = \"y^2 - x\"\ny = \"x*(u + p) - y\"");
    assert!(product.iter().any(slope), "{product:?}");
    // A relay that jumps with another state, and one that jumps upwards with its own.
    for der in [
        "x = \"sign(y)\"\ny = \"x + u + p\"",
        "x = \"sign(x) + y\"\ny = \"x + u + p\"",
    ] {
        let relay = why(&format!("[der]\n{der}"));
        let switch = |d: &Disorder| matches!(d.cause, Cause::Switch { state: 0 });
        assert!(relay.iter().any(switch), "{relay:?}");
    }
    // What holds may stay or start: its solutions are not unique.
    let holds = why("[der]\nx = \"u + p + y - friction(x, u + p + y, 0.1, 2)\"\ny = \"x + u + p\"");
    let switch = |d: &Disorder| matches!(d.cause, Cause::Switch { state: 0 });
    assert!(holds.iter().any(switch), "{holds:?}");
    // A floor.
    let floor = why("[der]\nx = \"floor(4*x) + y + u + p\"\ny = \"x + u + p\"");
    let undefined = |d: &Disorder| matches!(d.cause, Cause::Undefined { state: 0 });
    assert!(floor.iter().any(undefined), "{floor:?}");
    // What does not depend on the rest of the model has its motion kept, and the rest its corners.
    let partial = refusal("[der]\nx = \"floor(4*x) + u + p\"\ny = \"x - y\"", "").unwrap();
    assert_eq!(partial.corners, [Var::State(1)]);
    // A root has no slope where it ends.
    let root = why("[der]\nx = \"sqrt(y + 0.5) + u + p\"\ny = \"x + u + p\"");
    assert!(root.iter().any(undefined), "{root:?}");
}

/// A parameter whose slope is the velocity has its corner until the velocity turns; forms keep it then.
#[test]
fn the_order_ends_where_a_slope_changes_its_sign() {
    let text = "format = 1\nstates = [\"v\"]\ninputs = [\"u\"]\ninit = { v = 1 }\n[params]\na = [0, 1]\n[der]\nv = \"u - a*v\"\n\
        [outputs]\nm = \"v +- 1\"\n";
    let engine = Engine::new(&read("turning", text));
    let stretches = held(&[Interval::point(-1.0)], 0.125, 16);
    let start = [interval(1.0, 1.25)];
    let params = [interval(0.25, 0.5)];
    let compared = engine.enclose(&start, &params, &stretches, ONCE).unwrap();
    assert_eq!(compared.kept, [Var::Param(0)]);
    assert_eq!(compared.corners, [Var::State(0)]);
    let [disorder] = compared.disorders[..] else {
        panic!("{compared:?}");
    };
    // The first of all is at rest at ln(1.5) / 0.5.
    let first = 1.5_f64.ln() / 0.5;
    assert!(
        disorder.since <= first && disorder.since > first - 0.2,
        "{disorder:?}"
    );
    assert!(matches!(
        disorder.cause,
        Cause::Slope {
            of: 0,
            by: Var::Param(0),
            ..
        }
    ));
    // Exact before: (v0 + 1/a) e^(-a t) - 1/a.
    let v = |v0: f64, a: f64, t: f64| (v0 + 1.0 / a) * (-a * t).exp() - 1.0 / a;
    let end = compared.enclosure.ends[3][0];
    assert!(
        (end.lo() - v(1.0, 0.5, 0.5)).abs() < 1e-9 && (end.hi() - v(1.25, 0.25, 0.5)).abs() < 1e-9
    );
    assert!(compared.enclosure.stopped.is_none() && compared.enclosure.ends.len() == 16);
}

/// Bounds end where a jump of the state may come, and where the guards are not proved to cover.
#[test]
fn nothing_is_claimed_past_a_jump() {
    let jump = "[jumps]\nback = { when = \"x > 0.8\", set = { x = \"0\" } }\n";
    let der = "[der]\nx = \"1 + u + p\"\ny = \"x - y\"";
    let compared = refusal(der, jump).unwrap();
    let stopped = compared.enclosure.stopped.unwrap();
    assert_eq!(stopped.obstacle, Obstacle::NotMonotone);
    // The first is there after 0.3 / 1.9 s.
    assert!(stopped.reached.hi() <= 0.3 / 1.9 && compared.enclosure.ends.is_empty());
    assert_eq!(compared.disorders.last().unwrap().cause, Cause::Jump);
}
