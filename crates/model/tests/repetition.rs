//! A model with templates is the model written out.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

use veribound_model::{Model, Names};

fn read(text: &str) -> Model {
    Model::from_text("model.toml", text)
        .unwrap_or_else(|problems| panic!("{}", problems.render(false)))
}

/// All there is to a model but the text it was read from.
fn content(model: &Model) -> String {
    let names = |list: Vec<&String>| list.into_iter().cloned().collect();
    let names = Names {
        states: names(model.states.iter().map(|state| &state.name).collect()),
        params: names(model.params.iter().map(|param| &param.name).collect()),
        inputs: names(model.inputs.iter().map(|input| &input.name).collect()),
    };
    let mut text = format!(
        "{}\n{:?}\n{:?}\n{:?}\n{:?}\n{:?}\n",
        model.describe(),
        model.states,
        model.inputs,
        model.params,
        model.signals,
        model.coverage
    );
    for mode in &model.modes {
        for e in &mode.der {
            text.push_str(&format!("{}\n", model.graph.show(*e, &names)));
        }
    }
    for output in &model.outputs {
        let shown = model.graph.show(output.expr, &names);
        let (name, unit, column) = (&output.name, &output.unit, &output.column);
        text.push_str(&format!(
            "{name} {unit} {column:?} {:?} {shown}\n",
            output.error
        ));
    }
    text
}

#[test]
fn a_chain_of_ten_masses() {
    let short = include_str!("../testdata/good/chain.toml");
    let n = 10;
    let list = |one: &dyn Fn(usize) -> String, from: usize, to: usize, between: &str| {
        (from..=to).map(one).collect::<Vec<_>>().join(between)
    };
    let all = |one: &dyn Fn(usize) -> String, between: &str| list(one, 1, n, between);
    let positions = all(&|i| format!("\"x{i} [m]\""), ", ");
    let velocities = all(&|i| format!("\"v{i} [m/s]\""), ", ");
    let starts = all(&|i| format!("x{i} = 0"), ", ");
    let stands = list(&|i| format!("v{i} = 0"), 1, n - 1, ", ");
    let masses = all(
        &|i| format!("m{i} = {{ bounds = [0.9, 1.1], unit = \"kg\" }}"),
        "\n",
    );
    let kinetic = all(&|i| format!("m{i}*v{i}^2"), " + ");
    let elastic = list(&|i| format!("(x{i} - x{})^2", i - 1), 2, n, " + ");
    let moves = all(&|i| format!("x{i} = \"v{i}\""), "\n");
    let force = |i| format!("v{i} = \"k*(x{} - 2*x{i} + x{})/m{i}\"", i - 1, i + 1);
    let pulled = list(&force, 2, n - 1, "\n");
    let measured = all(
        &|i| format!("x_m{i} = {{ expr = \"x{i}\", error = 0.001, column = \"mass {i}\" }}"),
        "\n",
    );
    let moment = all(&|i| format!("m{i}*x{i}"), " + ");
    let mass = all(&|i| format!("m{i}"), " + ");
    let long = format!(
        "format = 1\nname = \"chain\"\nstates = [{positions}, {velocities}]\n\
         init = {{ {starts}, {stands}, v10 = [-0.01, 0.01] }}\n\
         inputs = [\"F [N]\"]\n[params]\n{masses}\nk = {{ bounds = [90, 110], unit = \"N/m\" }}\n\
         [let]\nenergy = \"({kinetic})/2 + k*(x1^2 + ({elastic}))/2\"\n\
         [der]\n{moves}\nv1 = \"k*(x2 - 2*x1)/m1\"\n{pulled}\nv10 = \"(F - k*(x10 - x9))/m10\"\n\
         [outputs]\n{measured}\nmiddle = \"({moment})/({mass}) +- 0.001 [m]\"\n\
         E = {{ expr = \"energy\", unit = \"J\", error = 0.01 }}\n"
    );
    let model = read(short);
    assert_eq!(content(&model), content(&read(&long)));
    assert_eq!(model.outputs[6].column.as_deref(), Some("mass 7"));
    assert_eq!(
        model.source.text, short,
        "the model keeps the text it was written in"
    );
}

/// The velocity of `x` where `[let]` holds more, with `n = 3`.
fn velocity(written: &str) -> String {
    let text = format!(
        "format = 1\nsizes = {{ n = 3 }}\nstates = [\"x\"]\ninit.x = 0\nder.x = \"{written}\"\n\
         params.\"p{{i=0..4}}\" = [0, 1]\nparams.\"q{{i=1..2}}_{{j=1..i}}\" = [0, 1]\n\
         outputs.y = \"x +- 1\"\n"
    );
    content(&read(&text))
}

#[test]
fn braces_stand_for_what_the_page_says() {
    for (short, long) in [
        ("p{n+1} - p{2*n-5}", "p4 - p1"),
        ("sum{i=1..n}(p{i}*{i})", "p1*1 + p2*2 + p3*3"),
        ("2*sum{i=1..2}(p{i})^2", "2*(p1 + p2)^2"),
        (
            "product{i=0..n}(x - p{i})",
            "(x - p0)*(x - p1)*(x - p2)*(x - p3)",
        ),
        ("x/product{i=1..2}(p{i})", "x/(p1*p2)"),
        ("min{i=1..n} (p{i}*x)", "min(p1*x, p2*x, p3*x)"),
        ("max{i=n..n}(p{i})", "p3"),
        ("sum{i=1..0}(p{i}) + product{i=2..1}(p{i})", "1"),
        ("x*{1-n}^2", "x*4"),
        ("x^{n} - {n-4}", "x^3 + 1"),
        ("sum{i=1..2}(sum{j=1..i}(q{i}_{j}))", "q1_1 + (q2_1 + q2_2)"),
        ("sum{i=1..2}(sum{k=i..2}({10*i+k}))", "45"),
        (
            "if any{i=1..2}(x > p{i}) and all{i=2..1}(x > 3) then 1 else 2",
            "if x > p1 or x > p2 then 1 else 2",
        ),
        (
            "if all{i=1..2}(x > p{i}) then 1 else 2",
            "if x > p1 and x > p2 then 1 else 2",
        ),
    ] {
        assert_eq!(velocity(short), velocity(long), "{short}");
    }
}
