//! Good models mean what they say.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

use num_rational::BigRational;
use veribound_interval::{Decimal, Interval};
use veribound_model::{Coverage, Guard, Model, Var};

fn good(name: &str) -> Model {
    Model::from_file(format!("testdata/good/{name}.toml"))
        .unwrap_or_else(|problems| panic!("{}", problems.render(false)))
}

fn enclosure(text: &str) -> Interval {
    Decimal::parse(text).unwrap().to_interval()
}

#[test]
fn long_form_of_the_rig() {
    let model = good("rig-long");
    assert_eq!(model.name, "drive_train_rig");
    let states: Vec<&str> = model
        .states
        .iter()
        .map(|state| state.name.as_str())
        .collect();
    assert_eq!(states, ["phi", "omega"]);
    assert_eq!(
        model.states[0].init,
        enclosure("-0.1").hull(enclosure("0.1"))
    );
    assert_eq!(model.states[1].unit, "rad/s");
    assert_eq!(
        model.params[2].bounds,
        enclosure("0.08").hull(enclosure("0.35"))
    );
    assert_eq!(
        model.params[2].nominal,
        Some(Decimal::parse("0.2").unwrap())
    );
    assert_eq!(
        model.outputs[0].error.absolute,
        Decimal::parse("0.1").unwrap()
    );
    assert_eq!(model.modes.len(), 3);
    let still = &model.signals[0];
    assert_eq!(still.column.as_deref(), Some("standstill"));
    assert_eq!(still.latency, Decimal::parse("0.02").unwrap());
    assert_eq!(
        model.graph.show(still.proves_zero[0], &model.names()),
        "omega"
    );
    assert_eq!(still.resets.len(), 1);
    assert_eq!(
        (still.resets[0].param, still.resets[0].event.as_str()),
        (2, "standstill")
    );
    assert_eq!(model.coverage, Coverage::Everywhere);
}

#[test]
fn short_form_of_the_rig() {
    let model = good("rig-short");
    assert_eq!(model.name, "rig-short");
    assert_eq!(model.inputs[0].unit, "N*m");
    assert_eq!(model.inputs[0].error.absolute, Decimal::zero());
    assert_eq!(
        model.outputs[0].error.absolute,
        Decimal::parse("0.1").unwrap()
    );
}

#[test]
fn constants_are_exact_and_bounds_are_outward() {
    let model = good("pendulum");
    let init = model.states[0].init;
    assert!((-Interval::PI).is_subset_of(init) && init.contains(1.57));
    assert!(init.width() < 4.713);
    let angle = model.outputs[0].expr;
    assert_eq!(model.graph.show(angle, &model.names()), "theta + pi");
    assert_eq!(model.outputs[0].unit, "rad");
    assert_eq!(
        model.outputs[0].error.absolute,
        Decimal::parse("0.0032").unwrap()
    );

    let model = Model::from_text(
        "m.toml",
        "format = 1\nstates = [\"x\"]\ninit = { x = \"1/3\" }\nder = { x = \"0.1*x\" }\noutputs = { y = \"x +- 1\" }",
    )
    .unwrap();
    // To the fifteen digits with which it is printed, outward.
    let around = |text: &str| Decimal::parse(text).unwrap().to_interval();
    assert_eq!(
        model.states[0].init,
        around("0.333333333333333").hull(around("0.333333333333334"))
    );
    let slope = {
        let mut graph = model.graph.clone();
        let slope = graph.derivative(model.modes[0].der[0], Var::State(0));
        graph.as_constant(slope).cloned()
    };
    assert_eq!(slope, Some(BigRational::new(1.into(), 10.into())));
    assert_eq!(model.modes[0].guard, Guard::Always);
}

#[test]
fn underscores_and_columns() {
    let model = good("emps");
    assert_eq!(model.states[1].init, Interval::new(-10.0, 10.0).unwrap());
    assert_eq!(model.inputs[0].column.as_deref(), Some("tau"));
    assert_eq!(
        model.inputs[0].error.relative,
        Decimal::parse("0.01").unwrap()
    );
    assert_eq!(model.outputs[0].column.as_deref(), Some("qm"));
}

#[test]
fn stick_at_a_moving_belt() {
    let model = good("belt");
    let stick = model
        .modes
        .iter()
        .find(|mode| mode.name == "stick")
        .unwrap();
    let shown: Vec<String> = stick
        .der
        .iter()
        .map(|e| model.graph.show(*e, &model.names()))
        .collect();
    assert_eq!(shown, ["0.2", "0"]);
}

#[test]
fn names_may_use_any_letters() {
    let text = "format = 1\nstates = [\"φ [rad]\", \"ω\"]\ninit = { \"φ\" = 0, \"ω\" = 1 }\n\
                der = { \"φ\" = \"ω\", \"ω\" = \"-sin(φ)\" }\noutputs = { y = \"φ*180/pi ± 0.1 [°]\" }";
    let model = Model::from_text("m.toml", text).unwrap();
    assert_eq!(model.outputs[0].unit, "°");
}
