//! The closed form of right-hand sides that are affine in the states, against exact solutions.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use common::{Rng, Trials, interval, number, read};
use veribound_flow::engine::{Answer, Engine, Engines, Task};
use veribound_flow::form::{Effort, Enclosure, Flow, FormOptions, Obstacle, Stretch};
use veribound_interval::Interval;

fn stretches(count: usize, dt: f64, inputs: &[Interval]) -> Vec<Stretch> {
    let stretch = Stretch {
        inputs: inputs.to_vec(),
        dt: Interval::point(dt),
    };
    vec![stretch; count]
}

fn ask(
    text: &str,
    engine: Engine,
    (start, params): (&[Interval], &[Interval]),
    stretches: &[Stretch],
) -> Answer {
    let task = Task {
        states: start,
        params,
        stretches,
        options: FormOptions::default(),
        effort: Effort::default(),
    };
    Engines::new(&read("closed", text)).enclose(engine, task, &|_| true)
}

fn closed(text: &str, start: &[Interval], params: &[Interval], list: &[Stretch]) -> Enclosure {
    let answer = ask(text, Engine::Closed, (start, params), list);
    assert_eq!(answer.by, [Engine::Closed]);
    answer.enclosure
}

fn has(x: Interval, value: f64, slack: f64) -> bool {
    x.lo() - slack <= value && value <= x.hi() + slack
}

/// A part of a matrix in its normal form, with its exponential.
#[derive(Debug, Clone, Copy)]
enum Block {
    Real(i64),
    /// `[[λ, 1], [0, λ]]`
    Double(i64),
    /// `[[a, -b], [b, a]]`
    Complex(i64, i64),
}

impl Block {
    fn size(self) -> usize {
        match self {
            Block::Real(_) => 1,
            _ => 2,
        }
    }

    fn entries(self) -> Vec<i64> {
        match self {
            Block::Real(x) => vec![x],
            Block::Double(x) => vec![x, 1, 0, x],
            Block::Complex(a, b) => vec![a, -b, b, a],
        }
    }

    fn exponential(self, t: f64) -> Vec<f64> {
        match self {
            Block::Real(x) => vec![(x as f64 * t).exp()],
            Block::Double(x) => {
                let e = (x as f64 * t).exp();
                vec![e, t * e, 0.0, e]
            }
            Block::Complex(a, b) => {
                let (e, angle) = ((a as f64 * t).exp(), b as f64 * t);
                let (c, s) = (e * angle.cos(), e * angle.sin());
                vec![c, -s, s, c]
            }
        }
    }
}

/// `A = T J T^-1` with integers, so that `A` is known exactly, and `exp(A t)` up to rounding.
#[derive(Debug)]
struct Linear {
    n: usize,
    blocks: Vec<Block>,
    change: Vec<i64>,
    back: Vec<i64>,
}

impl Linear {
    fn draw(rng: &mut Rng) -> Linear {
        let n = 1 + rng.below(4);
        let mut blocks = Vec::new();
        let mut left = n;
        while left > 0 {
            let decay = -rng.pick(&[0, 0, 1, 2, 5, 100, 1000, 100_000]);
            let real = rng.pick(&[decay, decay, 1]);
            let block = match rng.below(3) {
                0 if left > 1 => Block::Double(real),
                1 if left > 1 => Block::Complex(decay, rng.pick(&[1, 3, 40])),
                _ => Block::Real(real),
            };
            left -= block.size();
            blocks.push(block);
        }
        // Products of elementary matrices have integer inverses.
        let identity = |k: usize| i64::from(k.is_multiple_of(n + 1));
        let mut change: Vec<i64> = (0..n * n).map(identity).collect();
        let mut back = change.clone();
        for _ in 0..if n > 1 { rng.below(2) } else { 0 } {
            let (i, l) = (rng.below(n), rng.below(n));
            if i != l {
                let factor = rng.pick(&[-1, 1]);
                for k in 0..n {
                    change[i * n + k] += factor * change[l * n + k];
                    back[k * n + l] -= factor * back[k * n + i];
                }
            }
        }
        Linear {
            n,
            blocks,
            change,
            back,
        }
    }

    /// `T D T^-1` of a matrix that is made of blocks.
    fn conjugated(&self, of: impl Fn(Block) -> Vec<f64>) -> Vec<f64> {
        let n = self.n;
        let mut middle = vec![0.0; n * n];
        let mut first = 0;
        for block in &self.blocks {
            let size = block.size();
            for (k, x) in of(*block).iter().enumerate() {
                middle[(first + k / size) * n + first + k % size] = *x;
            }
            first += size;
        }
        let times = |a: &dyn Fn(usize) -> f64, b: &dyn Fn(usize) -> f64| -> Vec<f64> {
            (0..n * n)
                .map(|k| (0..n).map(|m| a(k / n * n + m) * b(m * n + k % n)).sum())
                .collect()
        };
        let left = times(&|k| self.change[k] as f64, &|k| middle[k]);
        times(&|k| left[k], &|k| self.back[k] as f64)
    }

    fn text(&self) -> String {
        let n = self.n;
        let matrix = self.conjugated(|block| block.entries().iter().map(|x| *x as f64).collect());
        let names: Vec<String> = (0..n).map(|i| format!("x{i}")).collect();
        let rates: String = (0..n)
            .map(|i| {
                let sum: String = (0..n)
                    .map(|l| format!(" + ({})*x{l}", matrix[i * n + l]))
                    .collect();
                format!("x{i} = \"u*{}{sum}\"\n", i + 1)
            })
            .collect();
        let inits: String = names.iter().map(|x| format!("{x} = 0\n")).collect();
        format!(
            "format = 1\nstates = {names:?}\ninputs = [\"u\"]\n[init]\n{inits}[der]\n{rates}[outputs]\nm = \"x0 +- 1\"\n"
        )
    }

    /// Exactly, but for rounding: `x(t) = exp(A t) x0 + Φ(t) b u`, the integral by Simpson's rule in many parts of which each
    /// is short for what has not decayed.
    fn moved(&self, x: &[f64], u: f64, t: f64) -> Vec<f64> {
        let n = self.n;
        let apply = |a: &[f64], x: &[f64]| -> Vec<f64> {
            (0..n)
                .map(|i| (0..n).map(|l| a[i * n + l] * x[l]).sum())
                .collect()
        };
        let drive: Vec<f64> = (0..n).map(|i| (i + 1) as f64 * u).collect();
        let free = apply(&self.conjugated(|block| block.exponential(t)), x);
        let forced = apply(&self.conjugated(|block| integral(block, t)), &drive);
        free.iter().zip(forced).map(|(a, b)| a + b).collect()
    }
}

/// `Φ(t)` of a block, in closed form.
fn integral(block: Block, t: f64) -> Vec<f64> {
    let real = |x: f64| if x == 0.0 { t } else { (x * t).exp_m1() / x };
    match block {
        Block::Real(x) => vec![real(x as f64)],
        Block::Double(x) => {
            let x = x as f64;
            let corner = if x == 0.0 {
                t * t / 2.0
            } else {
                (t * (x * t).exp() - real(x)) / x
            };
            vec![real(x), corner, 0.0, real(x)]
        }
        Block::Complex(a, b) => {
            // (exp(z t) - 1) / z with z = a + ib
            let (a, b) = (a as f64, b as f64);
            let (e, angle) = ((a * t).exp(), b * t);
            let half = (0.5 * angle).sin();
            let re = (a * t).exp_m1() * angle.cos() - 2.0 * half * half;
            let im = e * angle.sin();
            let size = a * a + b * b;
            let (c, s) = ((re * a + im * b) / size, (im * a - re * b) / size);
            vec![c, -s, s, c]
        }
    }
}

/// Zero, double and complex eigenvalues, and decays a hundred thousand times as fast as others: one step for every stretch,
/// the exact hull at its end, and no solution lost at any time of it.
#[test]
fn random_affine_systems() {
    let mut rng = Rng(number("VERIBOUND_SEED", 11));
    let (mut stiff, mut at_once, mut trials) = (0, 0, Trials::default());
    let rounds = number("VERIBOUND_ROUNDS", 200);
    for round in 0..rounds {
        let linear = Linear::draw(&mut rng);
        let n = linear.n;
        let radius = rng.pick(&[0.0, 0.125]);
        let start: Vec<Interval> = (0..n)
            .map(|_| Interval::point(f64::from(rng.below(9) as u32) - 4.0).inflate(radius))
            .collect();
        let t = rng.pick(&[0.01, 0.25, 1.0, 3.0]);
        let u = rng.between(-1.0, 1.0);
        let list = stretches(2, t, &[Interval::point(u)]);
        let found = closed(&linear.text(), &start, &[], &list);
        let what = format!("{round}: {linear:?} {t} {u} {start:?}");
        assert!(found.stopped.is_none(), "{what} {:?}", found.stopped);
        let fast = linear.blocks.iter().any(|block| block.entries()[0] < -500);
        if fast {
            stiff += 1;
            // Where nothing is left but what rounding took, another way is tried.
            at_once += u64::from(found.steps == 2);
        }
        let exact = linear.conjugated(|block| block.exponential(t));
        let size: f64 = 1.0 + found.tubes[1].iter().map(|x| x.mag()).fold(0.0, f64::max);
        let slack = 1e-9 * size;
        // Rounding is doubled with every doubling of time, and multiplied by how far eigenvectors are from independent, and by the root of two for what turns.
        let entries = linear.blocks.iter().flat_map(|block| block.entries());
        let fastest = entries.map(i64::abs).max().unwrap() as f64;
        let independence = (0..n).map(|i| {
            let row = |l: usize| (linear.change[i * n + l].abs(), l);
            let sums = (0..n).map(row).map(|(x, l)| {
                let back = (0..n).map(|m| linear.back[l * n + m].abs());
                x * back.sum::<i64>()
            });
            sums.sum::<i64>() as f64
        });
        let independence = independence.fold(1.0, f64::max);
        let doublings = (64.0 * fastest * t).max(1.0).log2();
        let rounding = 1e-16 * size * (2.9 * independence).powf(doublings);
        for i in 0..n {
            let width: f64 = (0..n).map(|l| exact[i * n + l].abs() * 2.0 * radius).sum();
            let own = found.ends[0][i].width();
            assert!(
                own <= width * (1.0 + 1e-4) + slack + rounding,
                "{what}: {own} {width}"
            );
        }
        for _ in 0..5 {
            let x: Vec<f64> = start.iter().map(|x| rng.inside(*x)).collect();
            let half = linear.moved(&x, u, t);
            for (time, before) in [(rng.unit() * t, &x), (rng.unit() * t, &half)] {
                let between = linear.moved(before, u, time);
                let tube = &found.tubes[usize::from(std::ptr::eq(before, &half))];
                for (value, x) in between.iter().zip(tube) {
                    assert!(has(*x, *value, slack), "{what}: {value} {x} at {time}");
                }
            }
            for (end, value) in found.ends[0].iter().zip(&half) {
                assert!(has(*end, *value, slack), "{what}: {value} {end}");
            }
            let last = linear.moved(&half, u, t);
            for (end, value) in found.ends[1].iter().zip(&last) {
                assert!(has(*end, *value, slack), "{what}: {value} {end}");
            }
            trials.solutions += 1;
            trials.checks += 4;
        }
    }
    trials.told("affine systems in closed form");
    assert!(stiff > rounds / 7, "{stiff}");
    assert!(10 * at_once > 9 * stiff, "{at_once} of {stiff}");
}

/// What inputs of any course reach, in closed form: a decay, and an oscillator that is driven against itself.
#[test]
fn inputs_of_any_course() {
    let decay = "format = 1\nstates = [\"x\"]\ninputs = [\"u\"]\n[init]\nx = 0\n[der]\nx = \"-1000*x + u\"\n[outputs]\nm = \"x +- 1\"\n";
    let u = interval(-1.0, 3.0);
    let found = closed(decay, &[Interval::ONE], &[], &stretches(3, 0.5, &[u]));
    let x = found.ends[2][0];
    let exact = interval(-1e-3, 3e-3);
    assert!(
        exact.is_subset_of(x.inflate(1e-12)) && x.width() < 1.001 * exact.width(),
        "{x}"
    );
    assert_eq!(found.steps, 3);
    // x'' = -x + u: |sin| integrates to 2 every half turn, and the first amplitude lasts.
    let turning = "format = 1\nstates = [\"x\", \"v\"]\ninputs = [\"u\"]\n[init]\nx = 0\nv = 0\n[der]\nx = \"v\"\nv = \"-x + u\"\n[outputs]\nm = \"x +- 1\"\n";
    let turn = std::f64::consts::PI;
    let list = stretches(1, 4.0 * turn, &[interval(-0.5, 0.5)]);
    let found = closed(turning, &[Interval::ONE, Interval::ZERO], &[], &list);
    for (x, middle) in found.ends[0].iter().zip([1.0, 0.0]) {
        let most = 0.5 * 8.0;
        assert!(
            has(*x, middle - most, 1e-9) && has(*x, middle + most, 1e-9),
            "{x}"
        );
        assert!(x.width() < 2.0 * 1.05 * most, "{x}");
    }
    // Held for a fifth of a turn each, with a friction that forgets: what is added turns with what is there.
    let damped = turning.replace("-x + u", "-x - 0.2*v + u");
    let list = stretches(30, 1.0, &[interval(-0.1, 0.1)]);
    let found = closed(&damped, &[Interval::ZERO; 2], &[], &list);
    let forms = ask(&damped, Engine::Forms, (&[Interval::ZERO; 2], &[]), &list).enclosure;
    for (own, known) in found.ends[29].iter().zip(&forms.ends[29]) {
        assert!(own.width() < 0.95 * known.width(), "{own} {known}");
    }
}

/// Rates that parameters decide, wide: the hull of the exact solution, also around zero, where nothing may be divided.
#[test]
fn parameters_in_the_matrix() {
    let text = "format = 1\nstates = [\"x\", \"v\"]\ninputs = [\"u\"]\n[init]\nx = 0\nv = 0\n[params]\na = [-400, 1]\n[der]\nx = \"v\"\nv = \"a*v + u\"\n\
        [outputs]\nm = \"x +- 1\"\n";
    for (lo, hi, t) in [
        (-2.2, -1.8, 2.0),
        (-0.1, 0.1, 2.0),
        (-0.5, 0.5, 0.5),
        (-330.0, -300.0, 1.0),
    ] {
        let u = 0.75;
        let start = [Interval::ZERO, interval(0.9, 1.1)];
        let list = stretches(2, t, &[Interval::point(u)]);
        let found = closed(text, &start, &[interval(lo, hi)], &list);
        assert!(found.stopped.is_none());
        let mut inner = [Interval::EMPTY; 2];
        for k in 0..=64 {
            for v in [0.9, 1.0, 1.1] {
                let a = lo + (hi - lo) * f64::from(k) / 64.0;
                let t = 2.0 * t;
                let first = if a == 0.0 { t } else { (a * t).exp_m1() / a };
                let second = if a.abs() < 1e-3 {
                    t * t / 2.0 + a * t * t * t / 6.0
                } else {
                    (first - t) / a
                };
                let state = [v * first + u * second, v * (a * t).exp() + u * first];
                for (inner, x) in inner.iter_mut().zip(state) {
                    *inner = inner.hull(Interval::point(x));
                }
            }
        }
        for (inner, outer) in inner.iter().zip(&found.ends[1]) {
            assert!(inner.is_subset_of(outer.inflate(1e-8)), "{inner} {outer}");
            assert!(
                outer.width() < 1.01 * inner.width(),
                "{lo} {hi}: {inner} {outer}"
            );
        }
    }
}

/// BM18: solutions that are known.
#[test]
fn piecewise_affine_problems_with_known_answers() {
    let clip = "format = 1\n[states]\nx = { init = 0 }\ny = { init = 0 }\n\
         [der]\nx = \"1\"\ny = \"min(max(x, -1), 1)\"\n[outputs]\nz = \"y +- 1\"\n";
    let start = [interval(0.9, 0.91), Interval::ZERO];
    let found = closed(clip, &start, &[], &stretches(1, 0.2, &[]));
    let (y, exact) = (found.ends[0][1], interval(0.195, 0.195_95));
    assert!(
        exact.is_subset_of(y.inflate(1e-12)) && y.width() < 1.01 * exact.width(),
        "{y}"
    );

    // Stops after x / (1 - u), and stays.
    let friction = "format = 1\n[states]\nx = { init = 0 }\n[inputs]\nu = { error = 0 }\n\
         [der]\nx = \"u - friction(x, u, 1)\"\n[outputs]\ny = \"x +- 1\"\n";
    let list = stretches(8, 0.25, &[Interval::point(0.5)]);
    let found = closed(friction, &[interval(0.4, 0.6)], &[], &list);
    let expected = [
        (0.275, 0.475),
        (0.15, 0.35),
        (0.025, 0.225),
        (0.0, 0.1),
        (0.0, 0.0),
    ];
    for (end, (lo, hi)) in found.ends.iter().zip(expected) {
        let x = end[0];
        assert!(has(x, lo, 1e-12) && has(x, hi, 1e-12), "{x} {lo} {hi}");
        assert!(x.width() <= hi - lo + 1e-9, "{x} {lo} {hi}");
    }
    assert_eq!(found.ends[7][0], Interval::ZERO);

    // A flight that reaches a line at 1/8, or stays below, or crosses it.
    let grazing = "format = 1\n[states]\nx = { init = 0 }\ny = { init = 0 }\nz = { init = 0 }\n[params]\nline = [0, 1]\n\
         [der]\nx = \"y\"\ny = \"-1\"\nz = \"sign(x - line)\"\n[outputs]\nw = \"z +- 1\"\n";
    for gap in [0.0, 1e-3, -1e-3, 1e-6, -1e-6, 1e-12, -1e-12, 0.05] {
        let start = [Interval::ZERO, Interval::point(0.5), Interval::ZERO];
        let line = Interval::point(0.125 - gap);
        let found = closed(grazing, &start, &[line], &stretches(4, 0.25, &[]));
        let forms = ask(
            grazing,
            Engine::Forms,
            (&start, &[line]),
            &stretches(4, 0.25, &[]),
        )
        .enclosure;
        assert!(found.stopped.is_none(), "{gap}");
        let half = f64::sqrt(2.0 * gap.max(0.0));
        for (k, end) in found.ends.iter().enumerate() {
            let t = 0.25 * (k + 1) as f64;
            let above = (t - (0.5 - half)).clamp(0.0, 2.0 * half);
            assert!(has(end[2], 2.0 * above - t, 1e-9), "{gap} {t}: {}", end[2]);
            let known = forms.ends[k][2].width();
            assert!(
                end[2].width() < 1.01 * known + 1e-6,
                "{gap} {t}: {} {known}",
                end[2]
            );
            assert!(has(end[0], 0.5 * t - 0.5 * t * t, 1e-12) && has(end[1], 0.5 - t, 1e-12));
        }
    }

    // A ball that bounces, before its bounces pile up: at 0.75 of the speed.
    let ball = "format = 1\nstates = [\"h\", \"v\"]\n[init]\nh = 1\nv = 0\n[der]\nh = \"v\"\nv = \"-9.81\"\n[jumps]\n\
        bounce = { when = \"h <= 0 and v < 0\", set = { v = \"-0.75*v\" } }\n[outputs]\nm = \"h +- 1\"\n";
    let list = stretches(3, 0.5, &[]);
    let found = closed(ball, &[interval(0.99, 1.01), Interval::ZERO], &[], &list);
    assert!(found.stopped.is_none(), "{:?}", found.stopped);
    let g = 9.81;
    for k in 0..=8 {
        let h0 = 0.99 + 0.02 * f64::from(k) / 8.0;
        for (step, end) in found.ends.iter().enumerate() {
            let (mut left, mut h, mut v): (f64, f64, f64) = (0.5 * (step + 1) as f64, h0, 0.0);
            loop {
                let fall = (v + (v * v + 2.0 * g * h).sqrt()) / g;
                if fall > left {
                    h += v * left - 0.5 * g * left * left;
                    v -= g * left;
                    break;
                }
                (v, h, left) = (-0.75 * (v - g * fall), 0.0, left - fall);
            }
            assert!(
                has(end[0], h, 1e-9) && has(end[1], v, 1e-9),
                "{h} {v} {end:?}"
            );
            assert!(end[0].width() < 0.15 && end[1].width() < 0.3, "{end:?}");
        }
    }
}

/// The motor with dry friction over ten seconds: the same hulls as forms, by one step where nothing happens.
#[test]
fn stops_and_break_away() {
    let text = "format = 1\nstates = [\"x\", \"v\"]\ninputs = [\"u\"]\n[init]\nx = 0\nv = 0\n[params]\na = [-3, 0]\n\
        b = [90, 210]\nT = [0, 0.3]\n[der]\nx = \"v\"\nv = \"a*v + b*(u - friction(v, u, T))\"\n[outputs]\nm = \"x +- 1\"\n";
    let levels = [0.4, 0.1, -0.3, 0.2, -0.1, -0.5, 0.05, 0.3, -0.2, 0.0];
    let list: Vec<Stretch> = levels
        .iter()
        .flat_map(|u| stretches(4, 0.5, &[Interval::point(*u)]))
        .collect();
    let bounds = [(-2.001, -1.999), (199.9, 200.1), (0.149_925, 0.150_075)];
    let params = bounds.map(|(lo, hi)| interval(lo, hi));
    let start = [Interval::ZERO; 2];
    let found = closed(text, &start, &params, &list);
    assert!(found.stopped.is_none(), "{:?}", found.stopped);
    let forms = ask(text, Engine::Forms, (&start, &params), &list).enclosure;
    assert!(found.steps < forms.steps, "{} {}", found.steps, forms.steps);
    let mut inner = vec![[Interval::EMPTY; 2]; list.len()];
    for number in 0..27 {
        let p = [0, 1, 2].map(|i| {
            let (lo, hi) = bounds[i];
            lo + (hi - lo) * f64::from(number / 3_u32.pow(i as u32) % 3) / 2.0
        });
        let mut now = (0.0, 0.0);
        for (k, stretch) in list.iter().enumerate() {
            now = common::rig_step(now.0, now.1, stretch.inputs[0].mid(), p, 0.5);
            for (inner, x) in inner[k].iter_mut().zip([now.0, now.1]) {
                *inner = inner.hull(Interval::point(x));
            }
        }
    }
    for (k, (inner, outer)) in inner.iter().zip(&found.ends).enumerate() {
        for (inner, outer) in inner.iter().zip(outer) {
            assert!(
                inner.is_subset_of(outer.inflate(1e-8)),
                "{k}: {inner} {outer}"
            );
            assert!(
                outer.width() <= 1.02 * inner.width() + 1e-7,
                "{k}: {inner} {outer}"
            );
        }
    }
}

/// Nothing is proved where there is no closed form, and the state is named.
#[test]
fn what_is_not_affine() {
    let text = "format = 1\nstates = [\"x\", \"y\"]\n[init]\nx = 1\ny = 1\n[der]\nx = \"-x\"\ny = \"-x*y\"\n[outputs]\nm = \"x +- 1\"\n";
    let answer = ask(
        text,
        Engine::Closed,
        (&[Interval::ONE; 2], &[]),
        &stretches(2, 0.5, &[]),
    );
    let stopped = answer.enclosure.stopped.unwrap();
    assert_eq!((stopped.obstacle, stopped.state), (Obstacle::NotAffine, 1));
    assert!(answer.enclosure.ends.is_empty());
    assert_eq!(Flow::new(&read("curved", text)).curved(), Some(1));
}
