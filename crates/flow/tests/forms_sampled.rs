//! Motors with dry friction under inputs that are another level at every sample: sets that stop, turn and break away while
//! samples pass, against exact solutions.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use common::{Rng, Trials, interval, number, read, rig_step};
use std::pin::pin;
use std::task::Poll;
use veribound_flow::form::{Allowance, Effort, Flow, Form, FormOptions, Meeting, Stretch, poll};
use veribound_interval::Interval;

const MOTOR: &str = r#"
format = 1
states = ["x", "v"]
inputs = ["u"]
init = { x = 0, v = 0 }
params = { a = [-3, 0], b = [90, 210], T = [0, 0.3] }
der = { x = "v", v = "a*v + b*(u - friction(v, u, T))" }
outputs = { m = "x +- 1" }
"#;

/// Seconds between samples.
const DT: f64 = 0.01;

/// What the simulator, in plain floating point, may be off.
const SLACK: f64 = 1e-9;

/// Parameters, a speed at the start, and one level for every sample.
#[derive(Clone)]
struct Drive {
    params: [Interval; 3],
    speed: Interval,
    levels: Vec<f64>,
}

impl Drive {
    fn draw(rng: &mut Rng) -> Drive {
        let wide = rng.pick(&[1e-3, 0.01, 0.03, 0.05]);
        let mut around = |middle: f64| {
            let radius = wide * middle.abs() * rng.unit();
            interval(middle - radius, middle + radius)
        };
        let params = [around(-2.0), around(150.0), around(0.15)];
        let (size, pace, phase) = (
            rng.between(0.15, 0.5),
            rng.between(1.0, 12.0),
            rng.between(0.0, 6.0),
        );
        let rough = rng.pick(&[0.0, 0.0, 0.02]);
        let levels = (0..160).map(|k| {
            let smooth = size * (pace * f64::from(k) * DT + phase).sin();
            smooth + rough * rng.between(-1.0, 1.0)
        });
        let levels = levels.collect();
        let speed = rng.pick(&[0.0, 0.2]) * rng.unit();
        let speed = interval(speed, speed * (1.0 + wide));
        Drive {
            params,
            speed,
            levels,
        }
    }

    fn stretches(&self) -> Vec<Stretch> {
        let levels = self.levels.iter();
        levels
            .map(|u| Stretch {
                inputs: vec![Interval::point(*u)],
                dt: Interval::point(DT),
            })
            .collect()
    }

    fn start(&self) -> [Interval; 2] {
        [Interval::ZERO, self.speed]
    }

    /// A true solution at all samples, for points at the ends of the sets or inside.
    fn solution(&self, rng: &mut Rng) -> (Vec<f64>, Vec<[f64; 2]>) {
        let mut draw = |x: Interval| rng.pick(&[x.lo(), x.hi(), rng.clone().inside(x)]);
        let p = self.params.map(&mut draw);
        let (mut x, mut v) = (0.0, draw(self.speed));
        let begin = v;
        let places = self.levels.iter().map(|u| {
            (x, v) = rig_step(x, v, *u, p, DT);
            [x, v]
        });
        let places = places.collect();
        ([&[begin], &p[..]].concat(), places)
    }
}

/// No solution is lost, and where nothing is given up hulls are about as wide as sampled ones.
#[test]
fn solutions_that_stop_while_samples_pass() {
    let mut rng = Rng(number("VERIBOUND_SEED", 21));
    let flow = Flow::new(&read("motor", MOTOR));
    let (mut stops, mut tight, mut all) = (0, 0, 0);
    let mut trials = Trials::default();
    let rounds = number("VERIBOUND_ROUNDS", 25);
    for _ in 0..rounds {
        let drive = Drive::draw(&mut rng);
        let options = FormOptions {
            degree: rng.pick(&[None, None, Some(2), Some(4)]),
            ..FormOptions::default()
        };
        let effort = Effort {
            parts: rng.pick(&[1, 4, 64]),
            ..Effort::default()
        };
        let found = flow.enclose(
            &drive.start(),
            &drive.params,
            &drive.stretches(),
            options,
            effort,
        );
        assert!(found.stopped.is_none(), "{:?}", found.stopped);
        let mut inner = vec![[Interval::EMPTY; 2]; found.ends.len()];
        for _ in 0..60 {
            let (p, places) = drive.solution(&mut rng);
            trials.solutions += 1;
            trials.checks += 2 * places.len() as u64;
            for (k, place) in places.iter().enumerate() {
                let is_stop = place[1] == 0.0 && (k > 0 && places[k - 1][1] != 0.0);
                stops += usize::from(is_stop);
                for i in 0..2 {
                    let (end, tube) = (found.ends[k][i], found.tubes[k][i]);
                    for bounds in [end, tube] {
                        let wide = bounds.inflate(SLACK);
                        assert!(
                            wide.contains(place[i]),
                            "{p:?} at {k}, {i}: {place:?} {bounds}"
                        );
                    }
                    inner[k][i] = inner[k][i].hull(Interval::point(place[i]));
                }
            }
        }
        let ratio = |k: usize| {
            let ratios = [0, 1].map(|i| found.ends[k][i].width() / (inner[k][i].width() + 1e-6));
            ratios[0].max(ratios[1])
        };
        tight += (0..inner.len()).filter(|k| ratio(*k) < 1.25).count();
        all += inner.len();
    }
    println!("{stops} stops, {tight} of {all} samples tight");
    trials.told("motors that stop while samples pass");
    assert!(stops as u64 > 20 * rounds);
    assert!(tight as f64 > 0.8 * all as f64, "{tight} of {all}");
}

/// Forms are shown at samples on the way across, too: each solution is where its own unknowns say; and whether it has been captured is
/// told by where it would be without.
#[test]
fn forms_at_samples_on_the_way_across() {
    let mut rng = Rng(number("VERIBOUND_SEED", 22));
    let flow = Flow::new(&read("motor", MOTOR));
    let (mut passing, mut captured) = (0, 0);
    let mut trials = Trials::default();
    for _ in 0..number("VERIBOUND_ROUNDS", 25) {
        let drive = Drive::draw(&mut rng);
        let solutions: Vec<_> = (0..20).map(|_| drive.solution(&mut rng)).collect();
        trials.solutions += solutions.len() as u64;
        let form = flow.start(&drive.start(), &drive.params, FormOptions::default());
        let unknowns = form.unknowns();
        let mut meet = |meeting: Meeting<'_>| {
            passing += usize::from(meeting.is_passing);
            let Some(k) = meeting.stretch.checked_sub(1) else {
                return;
            };
            for (p, places) in &solutions {
                let delta: Vec<f64> = unknowns
                    .iter()
                    .map(|(unknown, range)| {
                        let own = match unknown {
                            veribound_flow::form::Unknown::Start(_) => p[0],
                            veribound_flow::form::Unknown::Param(i) => p[1 + i],
                            veribound_flow::form::Unknown::Axis(_) => panic!("a box has no axes"),
                        };
                        (own - range.mid()) / range.rad()
                    })
                    .collect();
                let at = |centre: f64, slopes: &[f64]| {
                    let terms = slopes.iter().zip(&delta).map(|(s, d)| s * d);
                    centre + terms.sum::<f64>()
                };
                for i in 0..2 {
                    let form = meeting.form.state(i);
                    let own = Interval::point(at(form.centre, &form.slopes)) + form.remainder;
                    let wide = own.inflate(SLACK);
                    assert!(
                        wide.contains(places[k][i]),
                        "{p:?} at {k}: {:?} {own}",
                        places[k]
                    );
                }
                trials.checks += 1;
                if let Some(arriving) = &meeting.arriving {
                    let ahead = &arriving.ahead;
                    let line = Interval::point(at(ahead.centre, &ahead.slopes));
                    let ahead = line + ahead.remainder;
                    let is_on_it = places[k][1] == 0.0;
                    let is_beyond = if arriving.from_above {
                        ahead.hi() < -SLACK
                    } else {
                        ahead.lo() > SLACK
                    };
                    let is_before = if arriving.from_above {
                        ahead.lo() > SLACK
                    } else {
                        ahead.hi() < -SLACK
                    };
                    assert!(
                        if is_on_it { !is_before } else { !is_beyond },
                        "{ahead} {:?}",
                        places[k]
                    );
                    captured += usize::from(is_beyond);
                }
            }
        };
        // Where it is lost is told by the other test.
        let _ = flow.follow(form, &drive.stretches(), &mut meet, &|_| true);
    }
    println!("{passing} forms on the way, {captured} captured");
    trials.told("forms at samples on the way across");
    assert!(passing > 20 && captured > 100);
}

/// From rest, friction known to 1 to 40 %, a torque that rises: solutions break away at samples of their own, and the forms that are shown at them
/// contain each, wherever it is. One form tells of all again once all have left: nearly as narrow as what they fill.
#[test]
fn sets_that_break_away_while_samples_pass() {
    let mut rng = Rng(number("VERIBOUND_SEED", 23));
    let flow = Flow::new(&read("motor", MOTOR));
    let (mut shown, mut waited, mut tight, mut all) = (0, 0, 0, 0);
    for _ in 0..number("VERIBOUND_ROUNDS", 40) {
        let wide = rng.pick(&[0.01, 0.05, 0.2, 0.4]);
        let mut around = |middle: f64, wide: f64| {
            let radius = wide * middle.abs() * rng.between(0.3, 1.0);
            interval(middle - radius, middle + radius)
        };
        let params = [around(-2.0, 0.05), around(150.0, 0.05), around(0.15, wide)];
        let way = rng.pick(&[1.0, -1.0]);
        // From below what the least friction holds to above the largest, in up to twenty samples.
        let rise = params[2].width() * rng.between(0.03, 0.5);
        let mut level = params[2].lo() - rng.between(0.0, 3.0) * rise;
        let levels = (0..60).map(|_| {
            level +=
                rise * rng.between(0.2, 1.8) * f64::from(u8::from(level < 1.05 * params[2].hi()));
            way * level
        });
        let drive = Drive {
            params,
            speed: Interval::ZERO,
            levels: levels.collect(),
        };
        // Some pull exactly as much as friction holds.
        let held = drive.levels.iter().map(|u| Interval::point(u.abs()));
        let held: Vec<Interval> = held.filter(|u| u.is_subset_of(params[2])).collect();
        let mut solutions: Vec<_> = (0..40).map(|_| drive.solution(&mut rng)).collect();
        for level in held {
            let params = [params[0], params[1], level];
            solutions.push(
                Drive {
                    params,
                    ..drive.clone()
                }
                .solution(&mut rng),
            );
        }
        let form = flow.start(&drive.start(), &drive.params, FormOptions::default());
        let unknowns = form.unknowns();
        let mut reached = 0;
        let mut meet = |meeting: Meeting<'_>| {
            let Some(k) = meeting.stretch.checked_sub(1) else {
                return;
            };
            reached = reached.max(k);
            shown += usize::from(meeting.is_passing);
            let mut inner = [Interval::EMPTY; 2];
            for (p, places) in &solutions {
                let delta: Vec<f64> = unknowns
                    .iter()
                    .map(|(unknown, range)| match unknown {
                        veribound_flow::form::Unknown::Param(i) => {
                            (p[1 + i] - range.mid()) / range.rad()
                        }
                        other => panic!("{other:?} is known"),
                    })
                    .collect();
                for i in 0..2 {
                    let form = meeting.form.state(i);
                    let terms = form.slopes.iter().zip(&delta).map(|(s, d)| s * d);
                    let line = form.centre + terms.sum::<f64>();
                    let own = (Interval::point(line) + form.remainder).inflate(SLACK);
                    assert!(
                        own.contains(places[k][i]),
                        "{p:?} at {k}: {:?} {own}",
                        places[k]
                    );
                    assert!(form.hull.inflate(SLACK).contains(places[k][i]));
                    inner[i] = inner[i].hull(Interval::point(places[k][i]));
                }
                waited += usize::from(meeting.is_passing && places[k][1] == 0.0);
            }
            if k + 1 == drive.levels.len() {
                let ratio =
                    |i: usize| meeting.form.state(i).hull.width() / (inner[i].width() + 1e-6);
                tight += usize::from(ratio(0).max(ratio(1)) < 1.5);
            }
        };
        // A record may end while some rest and others do not.
        let stretches = drive.stretches();
        let short = &stretches[..rng.between(1.0, 30.0) as usize];
        let done = flow.follow(form.clone(), short, &mut meet, &|_| true);
        assert!(done.is_ok(), "{done:?} at the end of {}", short.len());
        let done = flow.follow(form, &stretches, &mut meet, &|_| true);
        assert!(done.is_ok(), "{done:?} after {reached} samples");
        all += 1;
    }
    println!(
        "{shown} forms on the way, {waited} solutions at rest in them, {tight} of {all} tight at the end"
    );
    assert!(shown > 3 * all && waited > 20 * all && 10 * tight >= 9 * all);
}

/// The sampled sine that integrators are compared with, all its stops and break-aways: at every sample nearly as narrow as what 729 exact
/// solutions fill.
#[test]
fn the_sampled_sine_is_tight_at_every_sample() {
    let drive = Drive {
        params: [
            interval(-2.05, -1.95),
            interval(99.0, 101.0),
            interval(0.098, 0.102),
        ],
        speed: Interval::ZERO,
        levels: (0..1000)
            .map(|k| 0.25 * (0.8 * DT * f64::from(k)).sin())
            .collect(),
    };
    let flow = Flow::new(&read("motor", MOTOR));
    let (options, effort) = (FormOptions::default(), Effort::default());
    let found = flow.enclose(
        &drive.start(),
        &drive.params,
        &drive.stretches(),
        options,
        effort,
    );
    assert!(found.stopped.is_none() && found.ends.len() == 1000);
    let mut inner = vec![[Interval::EMPTY; 2]; 1000];
    for number in 0..729_usize {
        let share = |i: u32| (number / 9_usize.pow(i) % 9) as f64 / 8.0;
        let p = [0, 1, 2].map(|i: u32| {
            let range = drive.params[i as usize];
            (range.lo() + share(i) * range.width()).min(range.hi())
        });
        let (mut x, mut v) = (0.0, 0.0);
        for (k, u) in drive.levels.iter().enumerate() {
            (x, v) = rig_step(x, v, *u, p, DT);
            for (i, value) in [x, v].into_iter().enumerate() {
                assert!(
                    found.ends[k][i].inflate(SLACK).contains(value),
                    "{p:?} at {k}"
                );
                inner[k][i] = inner[k][i].hull(Interval::point(value));
            }
        }
    }
    let mut worst = (0.0, 0, 0);
    for (k, (end, inner)) in found.ends.iter().zip(&inner).enumerate() {
        for i in 0..2 {
            let ratio = (end[i].width() - 1e-6) / (inner[i].width() + 1e-12);
            if ratio > worst.0 {
                worst = (ratio, k, i);
            }
        }
    }
    let last = [0, 1].map(|i| found.ends[999][i].width() / inner[999][i].width());
    println!("at most {worst:?}, at the end {last:?}");
    assert!(worst.0 < 1.5 && last[0].max(last[1]) < 1.005);
}

/// However often a journey is put aside, it shows the same forms at the same samples; and it is put aside where its allowance is spent.
#[test]
fn journeys_that_are_put_aside_are_the_same() {
    let flow = Flow::new(&read("motor", MOTOR));
    let (mut met, mut pauses) = (0, 0);
    for round in 0..number("VERIBOUND_ROUNDS", 1) * 8 {
        let mut rng = Rng(number("VERIBOUND_SEED", 1) * 1_000_081 + round);
        let drive = Drive::draw(&mut rng);
        let stretches = drive.stretches();
        let start = || flow.start(&drive.start(), &drive.params, FormOptions::default());
        let seen = |all: &mut Vec<String>, meeting: &Meeting<'_>| {
            let form: &Form = meeting.form;
            all.push(format!(
                "{} {:?} {:?}",
                meeting.stretch,
                form.strips(),
                meeting.arriving
            ));
        };
        let (mut whole, mut parts) = (Vec::new(), Vec::new());
        let mut meet = |meeting: Meeting<'_>| seen(&mut whole, &meeting);
        let done = flow.follow(start(), &stretches, &mut meet, &|_| true);
        let allowance = Allowance::default();
        let given = rng.pick(&[1, 10_000, 1_000_000]);
        let mut most = 0;
        {
            let mut meet = |meeting: Meeting<'_>| seen(&mut parts, &meeting);
            let journey = flow.travel(start(), &stretches, &mut meet, &|_| true, &allowance);
            let mut journey = pin!(journey);
            let put_aside = loop {
                match poll(journey.as_mut()) {
                    Poll::Ready(done) => break done,
                    Poll::Pending => {
                        assert!(allowance.left() <= 0, "round {round}");
                        most = most.max(-allowance.left());
                        pauses += 1;
                        allowance.give(given - allowance.left());
                    }
                }
            };
            assert_eq!(put_aside, done, "round {round}");
        }
        // A piece is some steps at most, of polynomials as they are drawn here.
        assert!(most < 10_000_000, "round {round}: {most}");
        assert_eq!(whole, parts, "round {round}");
        met += whole.len();
    }
    assert!(met > 500 && pauses > 1000, "{met} {pauses}");
}
