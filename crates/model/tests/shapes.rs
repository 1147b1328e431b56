//! `if`, tables, saturation, dead zone: what they stand for.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

use veribound_interval::Interval;
use veribound_model::{Coverage, Guard, Model, Relation, Var};

/// A model with one state `x`, one parameter `p` and one input `u`.
fn model(velocity: &str) -> Model {
    let text = format!(
        "format = 1\nstates = [\"x\"]\ninputs = [\"u\"]\ninit = {{ x = 0 }}\nparams = {{ p = [0, 1] }}\n\
         der = {{ x = \"{velocity}\" }}\noutputs = {{ y = \"x +- 1\" }}\n"
    );
    Model::from_text("model.toml", text)
        .unwrap_or_else(|problems| panic!("{}", problems.render(false)))
}

/// All values of the velocity of the only mode for `x` and `u` in `range`.
fn values(velocity: &str, range: (f64, f64)) -> Interval {
    let model = model(velocity);
    assert_eq!(model.modes.len(), 1, "{velocity}");
    let range = Interval::new(range.0, range.1).unwrap();
    let value = |var| match var {
        Var::State(_) | Var::Input(_) => range,
        Var::Param(_) => Interval::point(0.5),
    };
    model.graph.eval_interval(model.modes[0].der[0], &value)
}

fn exactly(lo: f64, hi: f64) -> Interval {
    Interval::new(lo, hi).unwrap()
}

#[test]
fn if_is_one_mode_for_each_answer() {
    let model = model("if x > 0 and u <= 2 then -x else if p == u then 1 else 2");
    let names: Vec<&str> = model.modes.iter().map(|mode| mode.name.as_str()).collect();
    // The inner `if` was met first.
    assert_eq!(names, ["then+then", "else+then", "then+else", "else+else"]);
    assert_eq!(model.coverage, Coverage::Everywhere);
    let Guard::All(both) = &model.modes[0].guard else {
        panic!("two conditions expected");
    };
    assert!(matches!(
        both[0],
        Guard::Atom {
            relation: Relation::Equal,
            ..
        }
    ));
    let Guard::All(neither) = &model.modes[3].guard else {
        panic!("two conditions expected");
    };
    assert!(matches!(
        neither[0],
        Guard::Atom {
            relation: Relation::NotEqual,
            ..
        }
    ));
    let Guard::Any(otherwise) = &neither[1] else {
        panic!("not (a and b) is not a or not b: {neither:?}");
    };
    assert_eq!(otherwise.len(), 2);
    assert!(matches!(
        otherwise[0],
        Guard::Atom {
            relation: Relation::LessEqual,
            ..
        }
    ));
    assert!(matches!(
        otherwise[1],
        Guard::Atom {
            relation: Relation::Greater,
            ..
        }
    ));
}

#[test]
fn an_if_without_a_choice_makes_no_modes() {
    assert_eq!(
        values("if true then 3*x else 1", (1.0, 2.0)),
        exactly(3.0, 6.0)
    );
    assert_eq!(
        values("if x > 1 then p else p", (0.0, 2.0)),
        exactly(0.5, 0.5)
    );
}

#[test]
fn the_same_condition_twice_is_one_choice() {
    assert_eq!(
        model("(if x > 0 then 1 else 2) + (if x > 0 then 1 else 2)")
            .modes
            .len(),
        2
    );
    let model =
        model("(if x > 0 then 1 else 2) * (if u > 0 then 5 else 6) + (if x > 0 then 3 else 4)");
    let shown: Vec<String> = model
        .modes
        .iter()
        .map(|mode| {
            format!(
                "{} {}",
                mode.name,
                model.graph.show(mode.der[0], &model.names())
            )
        })
        .collect();
    assert_eq!(
        shown,
        ["then+then 8", "else+then 14", "then+else 9", "else+else 16"]
    );
}

#[test]
fn saturation_and_dead_zone() {
    for (at, saturated, dead) in [
        (-3.0, -2.0, -1.0),
        (-2.0, -2.0, 0.0),
        (0.5, 0.5, 0.0),
        (1.0, 1.0, 0.0),
        (4.0, 1.0, 3.0),
    ] {
        let at = (at, at);
        assert_eq!(values("sat(x, -2, 1)", at), exactly(saturated, saturated));
        assert_eq!(values("deadzone(x, -2, 1)", at), exactly(dead, dead));
    }
    assert_eq!(values("sat(x, p)", (-3.0, 0.25)), exactly(-0.5, 0.25));
    assert_eq!(values("deadzone(x, p)", (-3.0, 0.75)), exactly(-2.5, 0.25));
}

#[test]
fn a_table_is_its_lines() {
    let table = "table(x, -1, 2, 0, 4, 2, p, 3, p)";
    for (at, value) in [
        (-9.0, 2.0),
        (-1.0, 2.0),
        (-0.5, 3.0),
        (0.0, 4.0),
        (1.0, 2.25),
        (2.0, 0.5),
        (2.5, 0.5),
        (7.0, 0.5),
    ] {
        assert_eq!(values(table, (at, at)), exactly(value, value), "at {at}");
    }
    // Where it only rises, its range is that of its ends.
    let rising = "table(x, 0, 0, 1, 1, 2, 4, 3, 9)";
    assert_eq!(values(rising, (0.5, 2.5)), exactly(0.5, 6.5));
}

#[test]
fn a_jump_in_a_table_is_a_set_or_two_modes() {
    let jump = "table(u, 0, 0, 1, 1, 1, 3, 2, 3)";
    assert_eq!(values(jump, (0.5, 0.5)), exactly(0.5, 0.5));
    assert_eq!(values(jump, (1.0, 1.0)), exactly(1.0, 3.0));
    assert_eq!(values(jump, (1.5, 1.5)), exactly(3.0, 3.0));
    let modes = model("table(x, 0, 0, 1, 1, 1, 3, 2, 3)").modes;
    let names: Vec<&str> = modes.iter().map(|mode| mode.name.as_str()).collect();
    assert_eq!(names, ["positive", "negative"]);
}

#[test]
fn logarithms_to_a_base() {
    assert!(values("log10(x)", (1000.0, 1000.0)).contains(3.0));
    assert!(values("log2(x)", (1024.0, 1024.0)).contains(10.0));
    assert!(values("log10(x)", (1000.0, 1000.0)).width() < 1e-14);
}

#[test]
fn negative_numbers_are_not_shown_behind_signs() {
    for (written, shown) in [
        ("x - -0.5", "x + 0.5"),
        ("x + -0.5", "x - 0.5"),
        ("-0.5 + x", "x - 0.5"),
        ("-0.5 - x", "-0.5 - x"),
    ] {
        let model = model(written);
        assert_eq!(
            model.graph.show(model.modes[0].der[0], &model.names()),
            shown
        );
    }
}
