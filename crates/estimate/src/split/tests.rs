//! What is cut, and where, on the rig of the talk.

use super::*;
use veribound_flow::ModeSet;

/// The rig: states phi and omega, parameters alpha, beta and T, input u.
const RIG: &str = r#"
format = 1
name = "rig"
[states]
phi = { unit = "rad", init = [-0.2, 0.2] }
omega = { unit = "rad/s", init = 0 }
[inputs]
u = { unit = "N*m" }
[params]
alpha = { unit = "1/s", bounds = [-6, -0.05] }
beta = { unit = "1/(kg*m^2)", bounds = [1, 400] }
T = { unit = "N*m", bounds = [0, 0.3] }
[modes]
forward = { when = "omega > 0 or (omega == 0 and u > T)", der = { phi = "omega", omega = "alpha*omega + beta*(u - T)" } }
stick = { when = "omega == 0 and abs(u) <= T", der = { phi = "0", omega = "0" } }
backward = { when = "omega < 0 or (omega == 0 and u < -T)", der = { phi = "omega", omega = "alpha*omega + beta*(u + T)" } }
[outputs]
y = { expr = "phi", unit = "rad", error = { absolute = 0.1 } }
"#;

const OMEGA: usize = 1;
const ALPHA: usize = 2;
const BETA: usize = 3;
const T: usize = 4;

const DT: f64 = 0.01;

fn rig() -> (Model, Splitter) {
    let model = Model::from_text("rig.toml", RIG).unwrap();
    let splitter = Splitter::new(&model);
    (model, splitter)
}

fn x(lo: f64, hi: f64) -> Interval {
    Interval::new(lo, hi).unwrap()
}

/// Plainly forward, with a torque that no friction of the prior can hold.
fn forward_cell(model: &Model) -> Cell {
    cell(
        model,
        &["forward"],
        [
            x(1.0, 1.2),
            x(2.0, 2.001),
            x(-3.0, -2.0),
            x(190.0, 210.0),
            x(0.14, 0.16),
        ],
    )
}

fn cell(model: &Model, modes: &[&str], z: [Interval; 5]) -> Cell {
    let mut cell = Cell::new(z.to_vec());
    cell.modes = ModeSet::EMPTY;
    for (number, mode) in model.modes.iter().enumerate() {
        if modes.contains(&mode.name.as_str()) {
            cell.modes.insert(number);
        }
    }
    cell
}

/// The coordinate in which the parts differ, and the parts of it from below.
fn difference(whole: &Cell, parts: &[Cell]) -> (usize, Vec<Interval>) {
    let differs = |i: &usize| parts.iter().any(|part| part.z[*i] != whole.z[*i]);
    let coordinates: Vec<usize> = (0..whole.z.len()).filter(differs).collect();
    assert_eq!(coordinates.len(), 1, "cut in {coordinates:?}");
    let mut list: Vec<Interval> = parts.iter().map(|part| part.z[coordinates[0]]).collect();
    list.sort_by(|a, b| a.lo().total_cmp(&b.lo()));
    (coordinates[0], list)
}

/// Ends where the whole does, and without gaps in between.
fn assert_covers(whole: Interval, parts: &[Interval]) {
    assert_eq!(parts[0].lo(), whole.lo());
    assert_eq!(parts[parts.len() - 1].hi(), whole.hi());
    assert!(parts.windows(2).all(|pair| pair[0].hi() == pair[1].lo()));
}

fn cut_of(cell: &Cell, u: Interval, options: &ObserverOptions) -> (usize, Vec<Interval>) {
    let (_, mut splitter) = rig();
    let parts = splitter.split(cell, &[u], DT, options);
    let (coordinate, list) = difference(cell, &parts);
    assert_covers(cell.z[coordinate], &list);
    (coordinate, list)
}

/// A rule that no velocity is wide enough for: parameters only.
fn parameters_only(rule: ParameterRule) -> ObserverOptions {
    ObserverOptions {
        velocity_horizon: 0.0,
        parameter_rule: rule,
        ..ObserverOptions::default()
    }
}

/// At rest, with friction around the torque.
fn standing_cell(model: &Model) -> Cell {
    cell(
        model,
        &["forward", "stick"],
        [
            x(0.0, 0.1),
            Interval::ZERO,
            x(-3.0, -2.0),
            x(190.0, 210.0),
            x(0.05, 0.25),
        ],
    )
}

#[test]
fn friction_is_cut_just_beyond_the_torque() {
    // The torque compared with friction, and friction compared with the torque.
    let mirrored = RIG
        .replace("u > T", "T < u")
        .replace("u < -T", "T < -u")
        .replace("abs(u) <= T", "T >= abs(u)");
    for text in [RIG, &mirrored] {
        let model = Model::from_text("rig.toml", text).unwrap();
        let mut splitter = Splitter::new(&model);
        let standing = standing_cell(&model);
        let width = model.params[T - ALPHA].bounds.width();
        for epsilon in [1e-3, 0.1] {
            let options = ObserverOptions {
                epsilon,
                ..ObserverOptions::default()
            };
            for u in [x(0.1, 0.12), x(-0.12, -0.1)] {
                let parts = splitter.split(&standing, &[u], DT, &options);
                let (coordinate, parts) = difference(&standing, &parts);
                assert_covers(standing.z[T], &parts);
                assert_eq!((coordinate, parts.len()), (T, 2));
                assert_eq!(parts[0].hi(), 0.12 + epsilon * width, "{u}");
                // What lies above holds the torque for sure.
                assert!(u.mag() < parts[1].lo());
            }
        }
    }
}

#[test]
fn friction_is_cut_in_the_middle_where_nothing_lies_beyond_the_torque() {
    let (model, _) = rig();
    let standing = standing_cell(&model);
    // A rule that would never choose friction.
    let options = parameters_only(ParameterRule::WidestTerm);
    for u in [x(0.1, 0.2499), x(-0.2499, -0.1), x(0.1, 0.3), x(-0.3, -0.1)] {
        let (coordinate, parts) = cut_of(&standing, u, &options);
        assert_eq!((coordinate, parts.len()), (T, 2));
        assert_eq!(parts[0].hi(), standing.z[T].mid(), "{u}");
    }
}

#[test]
fn friction_that_the_torque_decides_is_not_cut_for_it() {
    let (model, mut splitter) = rig();
    let still = forward_cell(&model);
    for u in [0.3, 0.1, 0.0, -0.1, -0.3] {
        let mut q = still.z.clone();
        q.push(x(u, u + 0.01));
        assert_eq!(splitter.ambiguous_guard(&q, 1e-3), None, "{u}");
    }
}

#[test]
fn a_velocity_around_its_level_is_cut_into_three() {
    let (model, _) = rig();
    let mut around = forward_cell(&model);
    around.z[OMEGA] = x(-3.0, 5.0);
    let all = cell(&model, &["forward", "stick", "backward"], [x(0.0, 1.0); 5]).modes;
    let options = ObserverOptions {
        velocity_horizon: 1e3,
        ..ObserverOptions::default()
    };
    let trisecting = ObserverOptions {
        trisect: true,
        ..options.clone()
    };
    let u = x(0.5, 0.51);

    around.modes = all;
    let (coordinate, parts) = cut_of(&around, u, &trisecting);
    assert_eq!(coordinate, OMEGA);
    assert_eq!(parts, [x(-3.0, -0.4), x(-0.4, 0.4), x(0.4, 5.0)]);
    // Not where it is not asked for, not in one mode alone, not away from the level.
    assert_eq!(
        cut_of(&around, u, &options),
        (OMEGA, vec![x(-3.0, 1.0), x(1.0, 5.0)])
    );
    let mut in_one_mode = around.clone();
    in_one_mode.modes = forward_cell(&model).modes;
    assert_eq!(cut_of(&in_one_mode, u, &trisecting).1.len(), 2);
    let mut above = around.clone();
    above.z[OMEGA] = x(0.0, 5.0);
    assert_eq!(
        cut_of(&above, u, &trisecting),
        (OMEGA, vec![x(0.0, 2.5), x(2.5, 5.0)])
    );
    // A level near an end: the part beyond it is left out where the middle one reaches the end.
    let mut near = around;
    near.z[OMEGA] = x(-0.125, 3.875);
    assert_eq!(
        cut_of(&near, u, &trisecting).1,
        [x(-0.125, 0.2), x(0.2, 3.875)]
    );
}

#[test]
fn a_velocity_is_cut_from_the_width_of_the_measured_angle_on() {
    let (model, _) = rig();
    let u = x(0.5, 0.51);
    // The angle is 1/4 wide; a velocity is cut from 1/4 / (4 * 1/64) = 4 on.
    let mut cell = forward_cell(&model);
    cell.z[0] = x(1.0, 1.25);
    let options = ObserverOptions {
        velocity_horizon: 4.0,
        ..ObserverOptions::default()
    };
    let dt = 1.0 / 64.0;
    let (_, mut splitter) = rig();
    let mut coordinate = |hi: f64, options: &ObserverOptions| {
        cell.z[OMEGA] = x(8.0, hi);
        let parts = splitter.split(&cell, &[u], dt, options);
        difference(&cell, &parts).0
    };
    assert_eq!(coordinate(12.0, &options), OMEGA);
    assert_ne!(coordinate(12.0_f64.next_down(), &options), OMEGA);
    assert_ne!(coordinate(15.99, &options), T, "the torque is decided");
    // Half the horizon asks for twice the width.
    let shorter = ObserverOptions {
        velocity_horizon: 2.0,
        ..options
    };
    assert_ne!(coordinate(15.99, &shorter), OMEGA);
    assert_eq!(coordinate(16.0, &shorter), OMEGA);
}

#[test]
fn the_widest_term_gives_its_parameter() {
    let (model, _) = rig();
    let rule = parameters_only(ParameterRule::WidestTerm);
    let mut cell = forward_cell(&model);
    // alpha*omega is about [-6, -4]; beta*(u - T) is [66.5, 77.7] and wider.
    let (coordinate, parts) = cut_of(&cell, x(0.5, 0.51), &rule);
    assert_eq!(coordinate, BETA);
    assert_eq!(parts, [x(190.0, 200.0), x(200.0, 210.0)]);
    // At forty times the speed alpha*omega is 80 wide.
    cell.z[OMEGA] = x(80.0, 80.001);
    assert_eq!(cut_of(&cell, x(0.5, 0.51), &rule).0, ALPHA);
    // A parameter known exactly is not cut, however wide its term is.
    cell.z[ALPHA] = Interval::point(-2.0);
    cell.z[OMEGA] = x(80.0, 180.0);
    assert_eq!(cut_of(&cell, x(0.5, 0.51), &rule).0, BETA);
}

#[test]
fn overlapping_terms_give_the_parameter_of_the_last_one() {
    let (model, _) = rig();
    let rule = parameters_only(ParameterRule::OverlappingTerms);
    let mut cell = forward_cell(&model);
    // alpha*omega < 0 < beta*(u - T): apart, though the second is wider.
    assert_eq!(cut_of(&cell, x(0.5, 0.51), &rule).0, ALPHA);
    // Backward torque in forward motion, beta*(u - T) = [-8.4, -3.8]: they overlap.
    cell.z[T] = x(0.1401, 0.15);
    let u = x(0.11, 0.12);
    assert_eq!(cut_of(&cell, u, &rule).0, BETA);
    // The widest term would be the same; the most influential parameter is not.
    cell.z[ALPHA] = x(-4.0, -0.5);
    assert_eq!(
        cut_of(&cell, u, &parameters_only(ParameterRule::WidestTerm)).0,
        ALPHA
    );
    assert_eq!(cut_of(&cell, u, &rule).0, BETA);
}

#[test]
fn the_most_influential_parameter_is_the_one_whose_own_width_counts() {
    let (model, _) = rig();
    let rule = parameters_only(ParameterRule::WidestInfluence);
    let mut cell = forward_cell(&model);
    let u = x(0.5, 0.51);
    // Influences: alpha 2 * 1, beta 0.37 * 20 = 7.4, T 210 * 0.01 = 2.1.
    cell.z[T] = x(0.14, 0.15);
    assert_eq!(cut_of(&cell, u, &rule).0, BETA);
    // T 210 * 0.04 = 8.4: guarded parameters count, too.
    cell.z[T] = x(0.14, 0.18);
    assert_eq!(cut_of(&cell, u, &rule).0, T);
    // alpha 5 * 2 = 10.
    cell.z[ALPHA] = x(-6.0, -1.0);
    assert_eq!(cut_of(&cell, u, &rule).0, ALPHA);
}

#[test]
fn at_rest_the_widest_share_of_a_prior_is_cut() {
    let (model, _) = rig();
    let mut resting = forward_cell(&model);
    resting.modes = cell(&model, &["stick"], [x(0.0, 1.0); 5]).modes;
    for rule in [
        ParameterRule::WidestTerm,
        ParameterRule::OverlappingTerms,
        ParameterRule::WidestInfluence,
    ] {
        let rule = parameters_only(rule);
        // Shares: alpha 1/5.95, beta 20/399, T 0.02/0.3.
        assert_eq!(cut_of(&resting, Interval::ZERO, &rule).0, ALPHA);
        let mut wider = resting.clone();
        wider.z[BETA] = x(190.0, 290.0);
        assert_eq!(cut_of(&wider, Interval::ZERO, &rule).0, BETA);
    }
}

#[test]
fn a_point_is_not_cut() {
    let (model, mut splitter) = rig();
    let mut cell = forward_cell(&model);
    cell.z = cell.z.iter().map(|x| Interval::point(x.mid())).collect();
    for rule in [
        ParameterRule::WidestTerm,
        ParameterRule::OverlappingTerms,
        ParameterRule::WidestInfluence,
    ] {
        let parts = splitter.split(&cell, &[x(0.1, 0.2)], DT, &parameters_only(rule));
        assert_eq!(parts, [cell.clone()]);
    }
}
