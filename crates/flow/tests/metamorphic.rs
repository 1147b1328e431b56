//! Relations between steps that must hold whatever the true solutions are.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use common::models::{self, CHAIN, RIG_EXPLICIT, RIG_MIRRORED, RIG_SHORT, Target};
use common::{Rng, interval, read};
use veribound_flow::{StepOptions, System, Workspace};
use veribound_interval::Interval;
use veribound_interval::lanes::{Interval8, LANES, Mask};

struct Stepper {
    system: System,
    workspace: Workspace,
}

#[derive(Clone)]
struct Boxes {
    states: Vec<Interval>,
    params: Vec<Interval>,
    inputs: Vec<Interval>,
}

impl Stepper {
    fn new(target: &Target, options: StepOptions) -> Stepper {
        let system = System::new(&read(target.name, target.text));
        let workspace = Workspace::new(&system, options);
        Stepper { system, workspace }
    }

    /// States at the end and at all times; `None` when nothing is proved.
    fn step(&mut self, from: &Boxes, h: f64) -> Option<(Vec<Interval>, Vec<Interval>)> {
        let mut states = from.states.clone();
        self.system
            .step(
                &mut states,
                &from.params,
                &from.inputs,
                Interval::point(h),
                &mut self.workspace,
            )
            .ok()?;
        Some((states, self.workspace.tube().to_vec()))
    }
}

fn range(rng: &mut Rng, (lo, hi): (f64, f64), special: &[f64]) -> Interval {
    let at = if !special.is_empty() && rng.chance(0.4) {
        rng.pick(special)
    } else {
        rng.between(lo, hi)
    };
    let width = rng.pick(&[0.0, 0.01, 0.1]) * (hi - lo) * rng.unit();
    interval(at, (at + width).min(hi.max(at)))
}

fn boxes(target: &Target, rng: &mut Rng) -> Boxes {
    let list = |rng: &mut Rng, list: &[(f64, f64, &[f64])]| {
        list.iter()
            .map(|(lo, hi, special)| range(rng, (*lo, *hi), special))
            .collect()
    };
    Boxes {
        states: list(rng, target.states),
        params: target.params.iter().map(|r| range(rng, *r, &[])).collect(),
        inputs: list(rng, target.inputs),
    }
}

fn part(rng: &mut Rng, x: Interval) -> Interval {
    let (a, b) = (rng.inside(x), rng.inside(x));
    interval(a.min(b), a.max(b))
}

fn meet(a: &[Interval], b: &[Interval]) -> bool {
    a.iter().zip(b).all(|(a, b)| a.intersects(*b))
}

fn all() -> impl Iterator<Item = &'static Target> {
    models::ALL.into_iter().chain([&RIG_EXPLICIT])
}

const STEPS: [f64; 4] = [0.01, 0.001, 0.05, 0.1];

/// A box inside another has its solutions inside the other's: the enclosures meet in every
/// component, and where no switch is near the smaller one lies inside.
#[test]
fn smaller_boxes_give_enclosures_that_meet_the_larger_one() {
    for (k, target) in all().enumerate() {
        let mut rng = Rng(100 + k as u64);
        let mut stepper = Stepper::new(target, StepOptions::default());
        let (mut inside, mut count) = (0, 0);
        for case in 0..300 {
            let whole = boxes(target, &mut rng);
            let mut cut = whole.clone();
            let lists = [&mut cut.states, &mut cut.params, &mut cut.inputs];
            for x in lists.into_iter().flatten() {
                *x = part(&mut rng, *x);
            }
            let h = rng.pick(&STEPS);
            let (Some(large), Some(small)) = (stepper.step(&whole, h), stepper.step(&cut, h))
            else {
                continue;
            };
            assert!(
                meet(&large.0, &small.0),
                "{} case {case}: ends apart",
                target.name
            );
            assert!(
                meet(&large.1, &small.1),
                "{} case {case}: tubes apart",
                target.name
            );
            let excess = large.0.iter().zip(&small.0).map(|(large, small)| {
                (large.lo() - small.lo()).max(small.hi() - large.hi()) / (1e-9 + large.width())
            });
            count += 1;
            inside += u32::from(excess.fold(f64::NEG_INFINITY, f64::max) <= 1e-3);
        }
        println!("{}: {inside} of {count} inside", target.name);
        assert!(
            count > 200 && inside * 100 >= count * 80,
            "{}: {inside} of {count}",
            target.name
        );
    }
}

/// `(x, u) -> (-x, -u)` maps solutions of rig and chain to solutions; the enclosures mirror bit by
/// bit.
#[test]
fn mirrored_boxes_give_mirrored_enclosures() {
    for target in [&RIG_EXPLICIT, &RIG_SHORT, &CHAIN] {
        let mut rng = Rng(7);
        let mut stepper = Stepper::new(target, StepOptions::default());
        for case in 0..500 {
            let here = boxes(target, &mut rng);
            let mut there = here.clone();
            for x in there.states.iter_mut().chain(&mut there.inputs) {
                *x = -*x;
            }
            let h = rng.pick(&STEPS);
            let (a, b) = (stepper.step(&here, h), stepper.step(&there, h));
            let mirrored = b.map(|(end, tube)| {
                let minus = |list: Vec<Interval>| list.into_iter().map(|x| -x).collect::<Vec<_>>();
                (minus(end), minus(tube))
            });
            assert_eq!(a, mirrored, "{} case {case}", target.name);
        }
    }
}

/// One step and the same time in two steps enclose the same solutions; what holds for the short
/// time holds as a prefix of the long one.
#[test]
fn divided_steps_meet_the_whole_one() {
    for (k, target) in all().enumerate() {
        let mut rng = Rng(200 + k as u64);
        let whole = StepOptions {
            longest: 1.0,
            ..StepOptions::default()
        };
        let mut stepper = Stepper::new(target, whole);
        for case in 0..300 {
            let from = boxes(target, &mut rng);
            let h = rng.pick(&STEPS);
            // Of few digits, so that the rest of the time is exact too.
            let part = f64::from((rng.pick(&[0.5, 0.5, 0.1, 0.9]) * h) as f32);
            let (Some(long), Some(first)) = (stepper.step(&from, h), stepper.step(&from, part))
            else {
                continue;
            };
            assert!(
                meet(&long.1, &first.0),
                "{} case {case}: prefix",
                target.name
            );
            let middle = Boxes {
                states: first.0,
                ..from.clone()
            };
            let Some(second) = stepper.step(&middle, h - part) else {
                continue;
            };
            assert!(
                meet(&long.0, &second.0),
                "{} case {case}: ends",
                target.name
            );
            assert!(
                meet(&long.1, &second.1),
                "{} case {case}: tubes",
                target.name
            );
        }
    }
}

/// The rig as three modes with guards and as one equation with the friction law.
#[test]
fn both_forms_of_the_rig_agree() {
    let mut rng = Rng(11);
    let mut explicit = Stepper::new(&RIG_EXPLICIT, StepOptions::default());
    let mut short = Stepper::new(&RIG_SHORT, StepOptions::default());
    let mut worst = 0.0_f64;
    for case in 0..2000 {
        let from = boxes(&RIG_SHORT, &mut rng);
        let (Some(a), Some(b)) = (explicit.step(&from, 0.01), short.step(&from, 0.01)) else {
            panic!("case {case}: not proved");
        };
        assert!(meet(&a.0, &b.0) && meet(&a.1, &b.1), "case {case}: apart");
        for (a, b) in a.0.iter().zip(&b.0) {
            let apart = (a.lo() - b.lo()).abs().max((a.hi() - b.hi()).abs());
            worst = worst.max(apart / (1.0 + a.mag()));
        }
    }
    assert!(worst < 1e-3, "the forms differ by {worst:e}");
}

/// Guards mean the same when both sides are exchanged.
#[test]
fn mirrored_guards_agree() {
    let mut rng = Rng(12);
    let mut explicit = Stepper::new(&RIG_EXPLICIT, StepOptions::default());
    let mut mirrored = Stepper::new(&RIG_MIRRORED, StepOptions::default());
    for case in 0..2000 {
        let from = boxes(&RIG_SHORT, &mut rng);
        let (a, b) = (explicit.step(&from, 0.01), mirrored.step(&from, 0.01));
        assert_eq!(a, b, "case {case}");
    }
}

/// Order, longest step and number of halvings change how tight bounds are, never what is true.
#[test]
fn settings_give_enclosures_that_meet() {
    for (k, target) in all().enumerate() {
        let mut rng = Rng(300 + k as u64);
        let mut steppers: Vec<Stepper> = [(1, 0.05), (2, 1.0), (4, 0.003), (8, 0.05)]
            .map(|(order, longest)| {
                Stepper::new(
                    target,
                    StepOptions {
                        order,
                        longest,
                        halvings: 8,
                    },
                )
            })
            .into();
        for case in 0..100 {
            let from = boxes(target, &mut rng);
            let h = rng.pick(&STEPS);
            let ends: Vec<_> = steppers
                .iter_mut()
                .filter_map(|s| s.step(&from, h))
                .collect();
            for a in &ends {
                for b in &ends {
                    assert!(
                        meet(&a.0, &b.0) && meet(&a.1, &b.1),
                        "{} case {case}",
                        target.name
                    );
                }
            }
        }
    }
}

/// Two masses with friction as two groups of three modes, and written as the nine modes of the
/// whole: bounds of one are those of the other.
#[test]
fn groups_of_modes_are_their_product() {
    let law = |head: &str| {
        format!(
            r#"
            format = 1
            states = ["x", "v", "w"]
            inputs = ["u"]
            init = {{ x = 0, v = 0, w = 0 }}
            params = {{ k = [0.5, 2], T = [0, 0.5], S = [0, 0.5] }}
            outputs = {{ y = "x +- 1" }}
            {head}
            x = "v - w"
            v = "u - k*x - friction(v, u - k*x, T)"
            w = "k*x - 0.1*w - friction(w, k*x, S)"
            "#
        )
    };
    let grouped = law("[der]");
    let product = law("modes.all.when = 'true'\n[modes.all.der]");
    let stepper = |text: &str, groups, modes| {
        let model = read("two masses", text);
        assert_eq!((model.groups.len(), model.modes.len()), (groups, modes));
        let system = System::new(&model);
        let workspace = Workspace::new(&system, StepOptions::default());
        Stepper { system, workspace }
    };
    let mut grouped = stepper(&grouped, 3, 7);
    let mut product = stepper(&product, 1, 9);
    let mut rng = Rng(11);
    let mut sticking = 0;
    for case in 0..2000 {
        let near = |rng: &mut Rng| range(rng, (-0.3, 0.3), &[0.0, 0.0, -0.01, 0.01]);
        let from = Boxes {
            states: (0..3).map(|_| near(&mut rng)).collect(),
            params: vec![
                range(&mut rng, (0.5, 2.0), &[]),
                range(&mut rng, (0.0, 0.5), &[0.0]),
                range(&mut rng, (0.0, 0.5), &[0.0]),
            ],
            inputs: vec![near(&mut rng)],
        };
        let h = rng.pick(&STEPS);
        let (Some(a), Some(b)) = (grouped.step(&from, h), product.step(&from, h)) else {
            panic!("case {case}: {from:?}", from = from.states);
        };
        for (a, b) in a.0.iter().chain(&a.1).zip(b.0.iter().chain(&b.1)) {
            let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * (1.0 + a.abs());
            assert!(
                near(a.lo(), b.lo()) && near(a.hi(), b.hi()),
                "case {case}: {a} and {b}"
            );
        }
        sticking += usize::from(a.0[1] == Interval::ZERO);
    }
    assert!(sticking > 50, "hardly any case sticks: {sticking}");
}

/// A step says the same again, whatever its scratch was used for before.
#[test]
fn scratch_leaves_no_trace() {
    for (k, target) in all().enumerate() {
        let mut rng = Rng(400 + k as u64);
        let mut used = Stepper::new(target, StepOptions::default());
        for case in 0..50 {
            let from = boxes(target, &mut rng);
            let h = rng.pick(&STEPS);
            let mut fresh = Stepper {
                workspace: Workspace::new(&used.system, StepOptions::default()),
                system: used.system.clone(),
            };
            assert_eq!(
                used.step(&from, h),
                fresh.step(&from, h),
                "{} case {case}",
                target.name
            );
        }
    }
}

/// What becomes of a box does not depend on those beside it: eight different boxes in one step end
/// where each of them ends alone, modes and failures included.
#[test]
fn eight_boxes_are_eight_single_ones() {
    let mut failures = 0;
    for (k, target) in all().enumerate() {
        let mut rng = Rng(500 + k as u64);
        // Every other model in long steps that are divided little, so that some of them fail.
        let options = if k % 2 == 0 {
            StepOptions::default()
        } else {
            StepOptions {
                longest: 10.0,
                halvings: 1,
                ..StepOptions::default()
            }
        };
        let mut together = Stepper::new(target, options);
        let mut alone = Stepper::new(target, options);
        for case in 0..40 {
            let inputs = boxes(target, &mut rng).inputs;
            let list: Vec<Boxes> = (0..LANES)
                .map(|_| Boxes {
                    inputs: inputs.clone(),
                    ..boxes(target, &mut rng)
                })
                .collect();
            let h = if k % 2 == 0 {
                rng.pick(&STEPS)
            } else {
                rng.between(0.1, 3.0)
            };
            let h = Interval::point(h);
            let lanes = Mask::from_fn(|_| true).without(Mask::lane(case % LANES));
            let coordinate = |i: usize| {
                let of = |b: &Boxes| b.states.iter().chain(&b.params).copied().nth(i).unwrap();
                Interval8::from_fn(|lane| of(&list[lane]))
            };
            let dimension = list[0].states.len() + list[0].params.len();
            let mut eight: Vec<Interval8> = (0..dimension).map(coordinate).collect();
            let Stepper { system, workspace } = &mut together;
            let reports = system.step_eight(&mut eight, lanes, &inputs, h, workspace);
            for lane in lanes.lanes() {
                let mut states = list[lane].states.clone();
                let Stepper { system, workspace } = &mut alone;
                let params = &list[lane].params;
                let report = system.step(&mut states, params, &inputs, h, workspace);
                let story = format!("{} case {case} lane {lane}", target.name);
                assert_eq!(reports[lane], report, "{story}");
                failures += usize::from(report.is_err());
                for (state, x) in states.iter().enumerate() {
                    assert_eq!(eight[state].get(lane), *x, "{story}");
                    if report.is_ok() {
                        let tube = together.workspace.tubes()[state].get(lane);
                        assert_eq!(tube, alone.workspace.tube()[state], "{story}");
                        let velocity = together.workspace.velocities()[state].get(lane);
                        assert_eq!(velocity, alone.workspace.velocity()[state], "{story}");
                    }
                }
            }
        }
    }
    assert!(failures > 0, "no step failed: failures are not compared");
}
