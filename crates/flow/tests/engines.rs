//! All engines prove the same claim; the choice between them says what it took.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use common::models::{self, Target};
use common::truth::Sim;
use common::{Rng, interval, monotone, read};
use veribound_flow::engine::{Answer, Engine, Engines, Task};
use veribound_flow::form::{Effort, FormOptions, Obstacle, Standing, Stretch};
use veribound_interval::Interval;

struct Case {
    target: &'static Target,
    start: Vec<Interval>,
    params: Vec<Interval>,
    stretches: Vec<Stretch>,
}

impl Case {
    fn new(
        target: &'static Target,
        start: &[(f64, f64)],
        params: &[(f64, f64)],
        inputs: &[(f64, f64)],
    ) -> Case {
        let list = |list: &[(f64, f64)]| list.iter().map(|x| interval(x.0, x.1)).collect();
        let stretch = Stretch {
            inputs: list(inputs),
            dt: Interval::point(0.125),
        };
        Case {
            target,
            start: list(start),
            params: list(params),
            stretches: vec![stretch; 8],
        }
    }

    fn engines(&self) -> Engines {
        Engines::new(&read(self.target.name, self.target.text))
    }

    fn task(&self) -> Task<'_> {
        Task {
            states: &self.start,
            params: &self.params,
            stretches: &self.stretches,
            options: FormOptions::default(),
            effort: Effort {
                parts: 2,
                ..Effort::default()
            },
        }
    }

    fn ask(&self, engine: Engine) -> Answer {
        self.engines().enclose(engine, self.task(), &|_| true)
    }

    fn contains(&self, answer: &Answer) {
        let mut rng = Rng(5);
        let proved = &answer.enclosure;
        assert_eq!(proved.ends.len(), proved.tubes.len());
        assert_eq!(proved.ends.len(), proved.modes.len());
        for _ in 0..20 {
            let mut point =
                |list: &[Interval]| -> Vec<f64> { list.iter().map(|x| rng.inside(*x)).collect() };
            let (x, p) = (point(&self.start), point(&self.params));
            let mut sim = Sim::new(self.target.truth, &x, &p);
            for (k, end) in proved.ends.iter().enumerate() {
                let inputs = &self.stretches[k].inputs;
                let u: Vec<f64> = inputs.iter().map(|x| rng.inside(*x)).collect();
                sim.advance(&u, 0.125, &mut rng);
                for (x, bounds) in sim.x.iter().zip(end) {
                    let slack = 4e-9 * (1.0 + x.abs());
                    assert!(
                        *x >= bounds.lo() - slack && *x <= bounds.hi() + slack,
                        "{:?}",
                        answer.by
                    );
                }
            }
        }
    }
}

fn cases() -> Vec<Case> {
    vec![
        Case::new(
            &models::TANKS,
            &[(0.2, 0.9), (0.2, 0.6)],
            &[(0.38, 0.42), (0.5, 2.0)],
            &[(0.3, 0.4)],
        ),
        Case::new(
            monotone::ALL[0],
            &[(-0.5, 0.5)],
            &[(0.25, 0.25), (0.5, 0.5)],
            &[(-1.0, 1.0)],
        ),
        Case::new(
            &models::BELT,
            &[(1.0, 1.05), (0.0, 0.0)],
            &[(1.0, 1.0), (0.1, 0.1), (0.3, 0.35)],
            &[],
        ),
    ]
}

#[test]
fn every_engine_contains_the_solutions() {
    for case in cases() {
        for engine in Engine::ALL {
            let answer = case.ask(engine);
            assert!(!answer.by.contains(&Engine::Auto));
            case.contains(&answer);
        }
        // What is chosen is not wider than forms.
        let (auto, forms) = (case.ask(Engine::Auto), case.ask(Engine::Forms));
        if auto.by.contains(&Engine::Forms) {
            for (auto, forms) in auto.enclosure.ends.iter().zip(&forms.enclosure.ends) {
                assert!(auto.iter().zip(forms).all(|(a, b)| a.is_subset_of(*b)));
            }
        }
    }
}

#[test]
fn the_choice_follows_the_order() {
    let by: Vec<Vec<Engine>> = cases()
        .iter()
        .map(|case| case.ask(Engine::Auto).by)
        .collect();
    assert_eq!(by[0], [Engine::Forms, Engine::Comparison]);
    assert_eq!(by[1], [Engine::Comparison]);
    assert_eq!(by[2], [Engine::Forms]);
    // Modes are affine, and what is held for long takes one step.
    let mut long = cases().remove(2);
    for stretch in &mut long.stretches {
        stretch.dt = Interval::point(4.0);
    }
    let answer = long.ask(Engine::Auto);
    assert_eq!(answer.by, [Engine::Closed]);
    assert!(answer.enclosure.stopped.is_none());
    // Asked for where there is no order, comparison bounds prove nothing and say why.
    let none = cases()[2].ask(Engine::Comparison);
    assert!(none.enclosure.ends.is_empty() && !none.disorders.is_empty());
    assert_eq!(
        (none.enclosure.outputs.len(), none.enclosure.parts.len()),
        (1, 1)
    );
    let stopped = none.enclosure.stopped.map(|stopped| stopped.obstacle);
    assert_eq!(stopped, Some(Obstacle::NotMonotone));
}

/// Two corners through 64 pieces, several times, are not worth it where one step of forms does.
#[test]
fn the_choice_never_costs_many_times_what_forms_cost() {
    for case in cases() {
        let mut case = case;
        case.stretches.truncate(1);
        let engines = case.engines();
        let cost = |engine: Engine| {
            let cost = Mutex::new(0.0);
            let answer = engines.enclose(engine, case.task(), &|standing: Standing| {
                if standing.unknowns > 0 {
                    *cost.lock().unwrap() += standing.cost;
                }
                true
            });
            case.contains(&answer);
            cost.into_inner().unwrap()
        };
        let (forms, auto) = (cost(Engine::Forms), cost(Engine::Auto));
        assert!(auto <= 6.0 * forms, "{auto} {forms}");
    }
}

#[test]
fn every_engine_can_be_interrupted() {
    let cases = cases();
    for engine in Engine::ALL {
        // Not all models have a closed form.
        let case = &cases[if engine == Engine::Closed { 2 } else { 0 }];
        let engines = case.engines();
        let asked = AtomicU64::new(0);
        let go_on = |_: Standing| asked.fetch_add(1, Ordering::Relaxed) + 1 < 4;
        let answer = engines.enclose(engine, case.task(), &go_on);
        let stopped = answer.enclosure.stopped.map(|stopped| stopped.obstacle);
        assert_eq!(stopped, Some(Obstacle::Interrupted), "{engine:?}");
    }
}
