//! What is proved about guards of several modes: that they only touch, or where they overlap.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod support;

use support::Dice;
use veribound_interval::Interval;
use veribound_model::{Guard, Model, Overlaps, Relation, Var};

/// States `x` and `v`, input `u`, a parameter `T` in [0.1, 0.2], a fixed one `k`, and modes with these guards.
fn model(guards: &[&str]) -> Model {
    let mut text =
        "format = 1\nstates = [\"x\", \"v\"]\ninit = { x = 0, v = 0 }\ninputs = [\"u\"]\n\
        params = { T = [0.1, 0.2], k = { fixed = 1 } }\noutputs.y = \"x +- 1\"\n[modes]\n"
            .to_string();
    for (i, guard) in guards.iter().enumerate() {
        text.push_str(&format!(
            "m{i} = {{ when = \"{guard}\", der = {{ x = \"v\", v = \"{i}\" }} }}\n"
        ));
    }
    read(text)
}

fn read(text: String) -> Model {
    Model::from_text("guards.toml", text).unwrap_or_else(|e| panic!("{}", e.render(false)))
}

/// The places of the only overlap there is.
fn only(overlaps: &Overlaps, modes: &[usize]) -> String {
    assert_eq!(overlaps.undecided, []);
    let [one] = &overlaps.found[..] else {
        panic!("{overlaps:?}")
    };
    assert_eq!(one.modes, modes, "{overlaps:?}");
    one.places.join(", or ")
}

#[test]
fn guards_that_only_touch() {
    for guards in [
        &["x >= 0", "x <= 0"][..],
        &["x != 0", "x == 0"],
        &["x > 0", "x == 0", "x < 0"],
        &["x + 1 >= v", "v >= 1 + x"],
        &[
            "v > 0 or (v == 0 and u > T)",
            "v == 0 and abs(u) <= T",
            "v < 0 or (v == 0 and u < -T)",
        ],
        &["x^2 + v^2 >= 1", "v^2 + x^2 <= 1"],
        &["sin(x) >= v*u", "sin(x) <= v*u"],
        &["abs(x) >= T", "abs(x) <= T"],
    ] {
        let overlaps = model(guards).overlaps();
        assert_eq!(overlaps.found, [], "{guards:?}");
        assert_eq!(overlaps.undecided, [], "{guards:?}");
        assert!(!overlaps.only_in_domain, "{guards:?}");
    }
    // T is never negative.
    let text = model(&["x >= 0", "x <= -T", "x <= 0 and x >= -T"]).describe();
    let wanted = "ok    the guards only touch in the domain: none overlap (proved)";
    assert!(text.contains(wanted), "{text}");
}

#[test]
fn overlaps_are_found_with_their_inside() {
    let overlaps = model(&["x <= 1", "x >= 0"]).overlaps();
    assert_eq!(only(&overlaps, &[0, 1]), "0 < x < 1");
    let [(var, whole)] = overlaps.found[0].boxes[0][..] else {
        panic!("{overlaps:?}")
    };
    assert_eq!(var, Var::State(0));
    assert_eq!(whole, Interval::new(0.0, 1.0).unwrap());
    // The velocity of x is the same in all modes.
    assert_eq!(overlaps.found[0].states, [1]);

    // What is excluded by `<` alone belongs to the closure.
    let overlaps = model(&["x != 0", "x >= 0", "x == 0"]).overlaps();
    assert_eq!(only(&overlaps, &[0, 1]), "x > 0");
    let overlaps = model(&["x >= 0", "x <= 0", "x > 5"]).overlaps();
    assert_eq!(only(&overlaps, &[0, 2]), "x > 5");
    // Three at once, where the third ends inside of the overlap of the others.
    let overlaps = model(&["x <= 1", "x >= 0", "x >= 0.5"]).overlaps();
    let modes: Vec<&[usize]> = overlaps.found.iter().map(|one| &one.modes[..]).collect();
    assert_eq!(modes.len(), 3, "{overlaps:?}");
    for wanted in [&[0, 1][..], &[0, 1, 2], &[1, 2]] {
        assert!(modes.contains(&wanted), "{modes:?}");
    }
    // A ring: no box is the whole of it.
    let overlaps = model(&["x^2 + v^2 >= 1", "x^2 + v^2 <= 2"]).overlaps();
    assert_eq!(only(&overlaps, &[0, 1]), "1 < x^2 + v^2 < 2");
    assert_eq!(overlaps.found[0].boxes.len(), 3);
    // A level that is taken on a whole stretch, and one that the only value of a parameter is.
    let overlaps = model(&["floor(x) >= 1", "floor(x) <= 1"]).overlaps();
    assert_eq!(only(&overlaps, &[0, 1]), "floor(x) = 1");
    let overlaps = model(&["k >= 1", "k < 1"]).overlaps();
    assert_eq!(only(&overlaps, &[0, 1]), "k = 1");
}

#[test]
fn branches_can_overlap_too() {
    let der = |right: &str| {
        let text = "format = 1\nstates = [\"x\"]\ninit.x = 0\noutputs.y = \"x +- 1\"\n";
        read(format!("{text}der.x = \"{right}\"\n"))
    };
    assert_eq!(der("sign(x)").overlaps(), Overlaps::default());
    assert_eq!(
        der("if x > 1 then 0 else 1").overlaps(),
        Overlaps::default()
    );
    let overlaps = der("-sign(deadzone(x, 1))").overlaps();
    assert_eq!(only(&overlaps, &[0, 1]), "-1 < x < 0, or 0 < x < 1");
}

#[test]
fn what_is_not_known_is_not_called_a_touch() {
    for guards in [
        // The same everywhere, which only an identity of the sine tells.
        &["sin(x)^2 + cos(x)^2 >= 1", "sin(x)^2 + cos(x)^2 <= 1"][..],
        // Zero everywhere, which only multiplication tells.
        &[
            "x^2 - v^2 >= (x - v)*(x + v)",
            "x^2 - v^2 <= (x - v)*(x + v)",
        ],
        &["1/x > 0", "x <= 0"],
    ] {
        let overlaps = model(guards).overlaps();
        assert_eq!(overlaps.found, [], "{guards:?}");
        assert!(!overlaps.undecided.is_empty(), "{guards:?}");
        let text = model(guards).describe();
        assert!(text.contains("note  whether m0, m1 overlap "), "{text}");
        assert!(!text.contains("only touch"), "{text}");
    }
}

#[test]
fn overlaps_are_told() {
    let text = model(&["x <= 1 or v > 0", "x >= 0"]).describe();
    let wanted = "\
overlaps (proved)
  m0, m1  where 0 < x < 1, or x > 1 and v > 0
          for instance x in [0, 1]; x in [1, 1000], v in [0, 1000]
          there v' is anywhere between theirs

  ok    the guards leave no gap (proved)
  note  the velocity is not unique where guards overlap; if that is not meant, let them exclude each other
";
    assert!(text.contains(wanted), "{text}");
}

/// A condition of random comparisons.
fn condition(dice: &mut Dice, depth: usize) -> String {
    if depth > 0 {
        let word = *dice.pick(&[" and ", " or "]);
        let parts = (condition(dice, depth - 1), condition(dice, depth - 1));
        return format!("({}{word}{})", parts.0, parts.1);
    }
    let side = *dice.pick(&[
        "x",
        "v",
        "x - v",
        "x + 2*v",
        "abs(x) - v",
        "max(x, v)",
        "min(x, u)",
        "x*v",
        "x - T",
        "u + T",
        "x^2 + v^2",
        "deadzone(x, 1)",
        "floor(v)",
        "sin(x)",
    ]);
    let relation = *dice.pick(&["<", "<=", ">", ">=", "==", "!="]);
    let level = *dice.pick(&["0", "1", "-1", "0.5", "2", "T", "k"]);
    format!("{side} {relation} {level}")
}

/// Whether the closed guard holds: surely, surely not, or not known.
fn holds(model: &Model, guard: &Guard, value: &dyn Fn(Var) -> Interval) -> Option<bool> {
    let each = |list: &[Guard]| -> Vec<Option<bool>> {
        list.iter().map(|part| holds(model, part, value)).collect()
    };
    match guard {
        Guard::Always => Some(true),
        Guard::All(list) => {
            let parts = each(list);
            let all = parts.iter().all(|part| *part == Some(true));
            if all {
                Some(true)
            } else {
                parts.contains(&Some(false)).then_some(false)
            }
        }
        Guard::Any(list) => {
            let parts = each(list);
            let none = parts.iter().all(|part| *part == Some(false));
            if none {
                Some(false)
            } else {
                parts.contains(&Some(true)).then_some(true)
            }
        }
        Guard::Atom { expr, relation } => {
            let difference = model.graph.eval_interval(*expr, value);
            let (lo, hi) = (difference.lo(), difference.hi());
            match relation {
                Relation::Less | Relation::LessEqual if hi <= 0.0 => Some(true),
                Relation::Less | Relation::LessEqual => (lo > 0.0).then_some(false),
                Relation::Greater | Relation::GreaterEqual if lo >= 0.0 => Some(true),
                Relation::Greater | Relation::GreaterEqual => (hi < 0.0).then_some(false),
                Relation::Equal if (lo, hi) == (0.0, 0.0) => Some(true),
                Relation::Equal => (lo > 0.0 || hi < 0.0).then_some(false),
                Relation::NotEqual => Some(true),
            }
        }
    }
}

/// What is claimed of random guards against random points: a box lies in all guards that are named, and points
/// in several guards lie in a place that is named. Points have dyadic coordinates and a small share
/// beside them, another one for each, so that none lies on a border by chance.
#[test]
fn random_points_agree() {
    let mut dice = Dice(5);
    let (mut boxes, mut shared, mut refuted) = (0, 0, 0);
    for _ in 0..80 {
        let guards: Vec<String> = (0..2)
            .map(|_| {
                let depth = dice.below(3);
                condition(&mut dice, depth)
            })
            .collect();
        let rest = format!("not ({}) and not ({})", guards[0], guards[1]);
        let model = model(&[&guards[0], &guards[1], &rest]);
        let overlaps = model.overlaps();
        let within = |mode: usize, value: &dyn Fn(Var) -> Interval| {
            holds(&model, &model.modes[mode].guard, value)
        };
        for one in &overlaps.found {
            for part in &one.boxes {
                boxes += 1;
                for _ in 0..20 {
                    let shares: Vec<f64> =
                        (0..8).map(|_| dice.below(1025) as f64 / 1024.0).collect();
                    let value = |var: Var| {
                        let known = part.iter().position(|(known, _)| *known == var);
                        let Some(at) = known else {
                            return Interval::point(0.3);
                        };
                        let range = part[at].1;
                        let point = range.lo() + shares[at] * (range.hi() - range.lo());
                        Interval::point(point.clamp(range.lo(), range.hi()))
                    };
                    for mode in &one.modes {
                        assert_ne!(
                            within(*mode, &value),
                            Some(false),
                            "{guards:?} {overlaps:?}"
                        );
                    }
                }
            }
        }
        for _ in 0..100 {
            let mut number = |less: f64| dice.below(4097) as f64 / 1024.0 - 2.0 + less / 65536.0;
            let (x, v, u) = (number(1.0), number(3.0), number(10.0));
            let value = |var: Var| match var {
                Var::State(0) => Interval::point(x),
                Var::State(_) => Interval::point(v),
                Var::Input(_) => Interval::point(u),
                Var::Param(0) => Interval::point(0.15),
                Var::Param(_) => Interval::ONE,
            };
            let inside: Vec<usize> = (0..3)
                .filter(|mode| within(*mode, &value) == Some(true))
                .collect();
            if inside.len() < 2 {
                refuted += 1;
                continue;
            }
            shared += 1;
            let names_all = |modes: &[usize]| inside.iter().all(|mode| modes.contains(mode));
            let is_named = overlaps.found.iter().any(|one| names_all(&one.modes))
                || overlaps
                    .undecided
                    .iter()
                    .any(|doubt| names_all(doubt.modes()));
            assert!(
                is_named,
                "{guards:?} at {x} {v} {u} in {inside:?}: {overlaps:?}"
            );
        }
    }
    assert!(
        boxes > 50 && shared > 500 && refuted > 1000,
        "{boxes} {shared} {refuted}"
    );
}
