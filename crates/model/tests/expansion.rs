//! Set-valued functions become the modes that one would write by hand.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

use veribound_model::{Coverage, Guard, Mode, Model, Relation};

fn read(text: &str) -> Model {
    Model::from_text("model.toml", text)
        .unwrap_or_else(|problems| panic!("{}", problems.render(false)))
}

fn good(name: &str) -> Model {
    Model::from_file(format!("testdata/good/{name}.toml"))
        .unwrap_or_else(|problems| panic!("{}", problems.render(false)))
}

/// Modes in words, independent of the order in which expressions were built.
fn words(model: &Model) -> Vec<String> {
    fn guard(model: &Model, guard_: &Guard) -> String {
        match guard_ {
            Guard::Always => "always".into(),
            Guard::Atom { expr, relation } => {
                format!(
                    "{} {relation:?} 0",
                    sorted(&model.graph.show(*expr, &model.names()))
                )
            }
            Guard::All(list) => {
                format!(
                    "all({})",
                    list.iter()
                        .map(|g| guard(model, g))
                        .collect::<Vec<_>>()
                        .join(", ")
                )
            }
            Guard::Any(list) => {
                format!(
                    "any({})",
                    list.iter()
                        .map(|g| guard(model, g))
                        .collect::<Vec<_>>()
                        .join(", ")
                )
            }
        }
    }
    // Sums and products print in the order of construction; their letters do not.
    fn sorted(text: &str) -> String {
        let mut letters: Vec<char> = text.chars().collect();
        letters.sort_unstable();
        letters.into_iter().collect()
    }
    model
        .modes
        .iter()
        .map(|mode| {
            let der: Vec<String> = mode
                .der
                .iter()
                .map(|e| sorted(&model.graph.show(*e, &model.names())))
                .collect();
            format!(
                "{} when {}: {}",
                mode.name,
                guard(model, &mode.guard),
                der.join("; ")
            )
        })
        .collect()
}

#[test]
fn friction_is_the_three_modes_of_the_rig() {
    let (short, explicit) = (good("rig-short"), good("rig-explicit"));
    assert_eq!(words(&short), words(&explicit));
    assert_eq!(short.coverage, Coverage::Everywhere);
    assert_eq!(explicit.coverage, Coverage::Everywhere);
    assert!(short.notes[0].contains("Filippov"), "{:?}", short.notes);
}

#[test]
fn friction_and_explicit_modes_in_one_graph_are_the_same_expressions() {
    // One file with both: the friction law stands inside of one explicit mode.
    let model = read(
        r#"
        format = 1
        states = ["phi", "omega"]
        inputs = ["u"]
        init = { phi = 0, omega = 0 }
        params = { a = [1, 2], b = [1, 2], T = [0, 1] }
        outputs = { y = "phi +- 1" }
        [modes.law]
        when = "true"
        der = { phi = "omega", omega = "a*omega + b*(u - friction(omega, u, T))" }
        [modes.forward]
        when = "omega > 0 or (omega == 0 and u > T)"
        der = { phi = "omega", omega = "a*omega + b*(u - T)" }
        [modes.stick]
        when = "omega == 0 and abs(u) <= T"
        der = { phi = "0", omega = "0" }
        [modes.backward]
        when = "omega < 0 or (omega == 0 and u < -T)"
        der = { phi = "omega", omega = "a*omega + b*(u + T)" }
        "#,
    );
    let find = |name: &str| -> &Mode { model.modes.iter().find(|mode| mode.name == name).unwrap() };
    for name in ["forward", "stick", "backward"] {
        let (law, explicit) = (find(&format!("law+{name}")), find(name));
        assert_eq!(law.der, explicit.der, "{name}");
        assert_eq!(law.guard, explicit.guard, "{name}");
    }
}

#[test]
fn sign_is_two_modes_that_touch() {
    let model = good("pendulum");
    let names: Vec<&str> = model.modes.iter().map(|mode| mode.name.as_str()).collect();
    assert_eq!(names, ["positive", "negative"]);
    let relations: Vec<Relation> = model
        .modes
        .iter()
        .map(|mode| match mode.guard {
            Guard::Atom { relation, .. } => relation,
            _ => panic!("one comparison expected"),
        })
        .collect();
    assert_eq!(relations, [Relation::GreaterEqual, Relation::LessEqual]);
}

#[test]
fn several_set_valued_functions_multiply() {
    let model = read(
        r#"
        format = 1
        states = ["x", "v", "w"]
        init = { x = 0, v = 0, w = 0 }
        let = { f = "friction(v - w, -x, 1)", g = "sign(x)" }
        der = { x = "v + g", v = "-x - f", w = "f - friction(w, f, 2) + g" }
        outputs = { y = "x + g +- 1" }
        "#,
    );
    assert_eq!(model.modes.len(), 18);
    assert_eq!(model.modes[0].name, "forward+positive+forward");
    assert_eq!(model.coverage, Coverage::Everywhere);
    // In stick of both, the second drive is the first friction value, and v = w = 0 is used.
    let stick = model
        .modes
        .iter()
        .find(|mode| mode.name == "stick+positive+stick")
        .unwrap();
    let shown: Vec<String> = stick
        .der
        .iter()
        .map(|e| model.graph.show(*e, &model.names()))
        .collect();
    assert_eq!(shown[1], "0");
    assert_eq!(
        model.graph.show(model.outputs[0].expr, &model.names()),
        "x + sign(x)"
    );
}

#[test]
fn states_that_share_no_switch_are_groups_of_their_own() {
    let model = read(
        r#"
        format = 1
        states = ["x", "v", "w", "h", "g"]
        init = { x = 0, v = 0, w = 0, h = 1, g = 1 }
        [der]
        x = "v"
        v = "-x - friction(v, -x, 1)"
        w = "-w*sign(w)"
        h = "if x > 1 then 1 else 0"
        g = "if x > 1 then h else if w > 0 then 1 else 2"
        [outputs]
        y = "x +- 1"
        "#,
    );
    let states: Vec<&[usize]> = model.groups.iter().map(|g| &g.states[..]).collect();
    assert_eq!(states, [&[1][..], &[2], &[3, 4], &[0]]);
    let names: Vec<&str> = model.modes.iter().map(|mode| mode.name.as_str()).collect();
    let wanted = [
        "v:forward",
        "v:stick",
        "v:backward",
        "w:positive",
        "w:negative",
        "h:then+then",
        "h:else+then",
        "h:then+else",
        "h:else+else",
        "smooth",
    ];
    assert_eq!(names, wanted);
    let shown = |state| {
        let of = |(mode, rhs)| (mode, model.graph.show(rhs, &model.names()));
        model.governing(state).map(of).collect::<Vec<_>>()
    };
    assert_eq!(shown(0), [(9, "v".to_string())]);
    assert_eq!(shown(4)[3], (8, "2".to_string()));
    assert_eq!(
        model.governed(6).map(|(s, _)| s).collect::<Vec<_>>(),
        [3, 4]
    );
    assert_eq!(model.coverage, Coverage::Everywhere);
}

#[test]
fn a_sign_of_inputs_alone_makes_no_modes() {
    let model = read(
        r#"
        format = 1
        states = ["x"]
        inputs = ["u"]
        init = { x = 0 }
        der = { x = "sign(u) - abs(x) + max(x, u, 1)" }
        outputs = { y = "x +- 1" }
        "#,
    );
    assert_eq!(model.modes.len(), 1);
    assert_eq!(model.modes[0].name, "smooth");
    assert_eq!(model.modes[0].guard, Guard::Always);
}

#[test]
fn a_jump_in_the_velocity_is_not_solved_for() {
    // v + sign(v) has slope 1 on both sides, but is nowhere zero except at v = 0.
    let model = read(
        r#"
        format = 1
        states = ["v"]
        init = { v = 1 }
        der = { v = "-friction(v + sign(v), 0, 1)" }
        outputs = { y = "v +- 1" }
        "#,
    );
    assert_eq!(model.modes.len(), 6);
}
