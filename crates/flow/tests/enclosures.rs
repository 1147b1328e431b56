//! What an enclosure tells beside states: outputs, and the modes that may act.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use common::case::{Case, options};
use common::models;
use common::{Rng, Trials, interval, number, read};
use veribound_flow::form::{Effort, Flow, FormOptions, Stretch};
use veribound_flow::{ModeSet, StepOptions, System, Workspace};
use veribound_interval::lanes::{Interval8, Mask};
use veribound_interval::{Decimal, Interval};
use veribound_model::{Model, Var};

/// The model with one more output, a product of states.
fn with_product(name: &str, text: &str) -> Model {
    let model = read(name, text);
    let first = &model.states[0].name;
    let last = &model.states[model.states.len() - 1].name;
    let output = format!("[outputs]\nproduct = \"{first}*{last} +- 1\"\n");
    read(name, &text.replace("[outputs]\n", &output))
}

/// The outputs of a point.
fn measured(model: &Model, x: &[f64], p: &[f64], u: &[f64]) -> Vec<Interval> {
    let value = |var: Var| {
        Interval::point(match var {
            Var::State(i) => x[i],
            Var::Param(i) => p[i],
            Var::Input(i) => u[i],
        })
    };
    let outputs = model.outputs.iter();
    outputs
        .map(|output| model.graph.eval_interval(output.expr, &value))
        .collect()
}

fn assert_has(what: &str, values: &[Interval], boxes: &[Interval]) {
    for (value, known) in values.iter().zip(boxes) {
        let slack = 1e-8 * (1.0 + value.mag());
        assert!(
            known.inflate(slack).intersects(*value),
            "{what}: {value} not in {known}"
        );
    }
}

/// The modes whose guards hold on a box.
fn possible(system: &System, (states, params, inputs): (&[Interval], &[f64], &[f64])) -> ModeSet {
    let params = params.iter().map(|p| Interval::point(*p));
    let boxes = states.iter().copied().chain(params).map(Interval8::splat);
    let boxes: Vec<Interval8> = boxes.collect();
    let inputs: Vec<Interval> = inputs.iter().map(|u| Interval::point(*u)).collect();
    let mut workspace = Workspace::new(system, StepOptions::default());
    system.active_modes(&boxes, Mask::lane(0), &inputs, &mut workspace)[0]
}

/// No output and no mode of a true solution is lost.
#[test]
fn outputs_and_modes_of_solutions_are_told() {
    let mut rng = Rng(number("VERIBOUND_SEED", 11));
    let (mut trials, mut claims) = (Trials::default(), 0);
    for target in models::ALL {
        let model = with_product(target.name, target.text);
        let (flow, system) = (Flow::new(&model), System::new(&model));
        for _ in 0..number("VERIBOUND_ROUNDS", 4) {
            let case = Case::draw(target, &mut rng);
            let effort = Effort {
                parts: 1 + rng.below(3),
                ..Effort::default()
            };
            let chosen = options(&mut rng);
            let found = flow.enclose(&case.start, &case.params, &case.stretches, chosen, effort);
            let all = found.ends.len();
            assert!(found.output_tubes.len() == all && found.modes.len() == all);
            assert!(found.outputs.len() >= all.min(1) && found.outputs.len() <= all + 1);
            for (_, p, mut sim) in case.solutions(target, &mut rng) {
                for k in 0..all {
                    let stretch = &case.stretches[k];
                    let what = format!("{} stretch {k} of {case:?} with {chosen:?}", target.name);
                    let u: Vec<f64> = stretch.inputs.iter().map(|u| rng.inside(*u)).collect();
                    let values = measured(&model, &sim.x, &p, &u);
                    assert_has(&what, &values, &found.outputs[k]);
                    assert_has(&what, &values, &found.output_tubes[k]);
                    let first = rng.unit() * case.lengths[k];
                    sim.advance(&u, first, &mut rng);
                    let values = measured(&model, &sim.x, &p, &u);
                    assert_has(&what, &values, &found.output_tubes[k]);
                    // Errors of the simulator may have brought it to the other side.
                    let near: Vec<Interval> = sim
                        .x
                        .iter()
                        .map(|x| interval(*x, *x).inflate(1e-7))
                        .collect();
                    let acting = possible(&system, (&near, &p, &u));
                    for group in &model.groups {
                        let told =
                            |mode: usize| acting.contains(mode) && found.modes[k].contains(mode);
                        assert!(
                            group.modes.clone().any(told),
                            "{what}: {:?} acts at {:?}, {:?} is told",
                            acting.iter().collect::<Vec<_>>(),
                            sim.x,
                            found.modes[k].iter().collect::<Vec<_>>(),
                        );
                        let told = group
                            .modes
                            .clone()
                            .filter(|mode| found.modes[k].contains(*mode));
                        claims += u64::from(told.count() < group.modes.len());
                    }
                    sim.advance(&u, case.lengths[k] - first, &mut rng);
                    trials.checks += 3;
                }
                trials.solutions += 1;
            }
        }
    }
    println!("{claims} times modes were left out");
    trials.told("outputs and modes");
    let stretches = trials.checks / 3;
    assert!(
        stretches > 3000 && 3 * claims > stretches,
        "{trials:?} {claims}"
    );
}

/// A motor moves, stops, sticks and turns: one mode at a time, two where it changes.
#[test]
fn modes_follow_each_other() {
    let text = "format = 1\nstates = [\"x\", \"v\"]\ninputs = [\"u\"]\n[init]\nx = 0\nv = 0\n[params]\n\
        b = [99, 101]\n[der]\nx = \"v\"\nv = \"-2*v + b*(u - friction(v, u, 0.1))\"\n\
        [outputs]\nforce = \"b*u +- 1\"\n";
    let model = read("motor", text);
    let flow = Flow::new(&model);
    let levels = ["0.3", "0.3", "0.05", "0.05", "0.05", "0.05", "0.05", "-0.3"];
    let number = |text: &str| Decimal::parse(text).unwrap().to_interval();
    let mut stretches: Vec<Stretch> = Vec::new();
    for level in levels {
        let (inputs, dt) = (vec![number(level)], number("0.2"));
        stretches.push(Stretch { inputs, dt });
    }
    let params = [interval(99.0, 101.0)];
    let found = flow.enclose(
        &[Interval::ZERO; 2],
        &params,
        &stretches,
        FormOptions::default(),
        Effort::default(),
    );
    assert!(found.stopped.is_none());
    let names = |set: ModeSet| -> Vec<&str> {
        set.iter()
            .map(|mode| model.modes[mode].name.as_str())
            .collect()
    };
    let told: Vec<Vec<&str>> = found.modes.iter().map(|set| names(*set)).collect();
    let told: Vec<String> = told.iter().map(|names| names.join(" ")).collect();
    let expected =
        ["forward"; 4]
            .into_iter()
            .chain(["forward stick", "stick", "stick", "backward"]);
    let expected: Vec<&str> = expected.collect();
    assert_eq!(told, expected);
    // Exactly the product of two intervals.
    let force = found.outputs[0][0];
    assert!(
        force.contains(29.7) && force.contains(30.3) && force.width() < 0.601,
        "{force}"
    );
    assert_eq!(found.parts.len(), 1);
    assert!(found.steps > 0 && found.shares[1].iter().map(|share| share.1).sum::<f64>() < 1.01);
}

/// While some solutions have stopped and others have not, over several samples, both modes are told.
#[test]
fn a_set_that_straddles_samples_has_both_modes() {
    let text = "format = 1\nstates = [\"x\"]\n[init]\nx = [0.9, 1.1]\n[der]\nx = \"-friction(x, 0, 1)\"\n[outputs]\ny = \"x +- 1\"\n";
    let model = read("decay", text);
    let stretch = Stretch {
        inputs: Vec::new(),
        dt: Interval::point(0.0625),
    };
    let stretches = vec![stretch; 24];
    let flow = Flow::new(&model);
    let start = [interval(0.9, 1.1)];
    let found = flow.enclose(
        &start,
        &[],
        &stretches,
        FormOptions::default(),
        Effort::default(),
    );
    let counts: Vec<usize> = found.modes.iter().map(|modes| modes.len()).collect();
    let expected = [[1; 14].as_slice(), &[2; 4], &[1; 6]].concat();
    assert_eq!(counts, expected, "{counts:?}");
}
