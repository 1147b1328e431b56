//! Models built in Rust: the same as from a file, messages included.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use veribound_interval::Decimal;
use veribound_model::build::{
    Condition, ModelBuilder, Number, Symbol, friction, if_else, pi, sticking_friction,
};
use veribound_model::{Guard, Model, Node};

/// Everything a model says but for where its text came from.
fn content(model: &Model) -> String {
    fn guards(guard: &Guard, found: &mut Vec<veribound_model::ExprId>) {
        match guard {
            Guard::Always => {}
            Guard::Atom { expr, .. } => found.push(*expr),
            Guard::All(parts) | Guard::Any(parts) => {
                parts.iter().for_each(|part| guards(part, found));
            }
        }
    }
    let mut roots = Vec::new();
    for mode in &model.modes {
        guards(&mode.guard, &mut roots);
        roots.extend(&mode.der);
    }
    roots.extend(model.outputs.iter().map(|output| output.expr));
    roots.extend(model.signals.iter().flat_map(|signal| &signal.proves_zero));
    let reachable = model.graph.reachable(&roots);
    let nodes: Vec<(usize, &Node)> = reachable
        .iter()
        .map(|e| (e.index(), model.graph.node(*e)))
        .collect();
    format!(
        "{:?}\n{:?}\n{:?}\n{:?}\n{:?}\n{:?}\n{:?}\n{:?}\n{:?}\n{:?}",
        model.name,
        nodes,
        model.states,
        model.inputs,
        model.params,
        model.modes,
        model.outputs,
        model.signals,
        model.coverage,
        model.notes
    )
}

fn built(model: &ModelBuilder) -> Model {
    model
        .build()
        .unwrap_or_else(|problems| panic!("{}\n{}", model.to_toml(), problems.render(false)))
}

fn assert_same(model: &ModelBuilder, file: &str) {
    let from_file = Model::from_text("file.toml", file).unwrap();
    assert_eq!(content(&built(model)), content(&from_file));
}

fn messages(model: &ModelBuilder) -> String {
    model.build().unwrap_err().render(false)
}

#[test]
fn every_element_is_what_it_is_in_a_file() {
    let mut model = ModelBuilder::new("all \"elements\"");
    let x = model.state("x").unit("m").init("-0.2", pi() / 10).symbol();
    let v = model
        .state("v")
        .unit("m/s")
        .init(0, 0)
        .domain(-50, "5e1")
        .symbol();
    let u = model
        .input("u")
        .unit("m/s^2")
        .domain(-10, 10)
        .error("0.01")
        .relative_error(Decimal::parse("0.001").unwrap())
        .column("drive")
        .symbol();
    let wind = model.disturbance("wind", "-0.1", "0.1").symbol();
    let mu = model
        .param("µ", 0, "0.4")
        .unit("m/s^2")
        .nominal("0.25")
        .symbol();
    let k = model.fixed("k", "2.5").symbol();
    let drive = model.define("drive", &u + &wind - &k * &x);
    model.der(&x, &v);
    model.der(
        &v,
        &drive - friction(&v, &drive, &mu) + if_else(x.above(1).or(v.differs(0)), -&k, "0.5"),
    );
    model.output("position", &x, "0.01").unit("m").column("s");
    model
        .output("speed", v.abs().max(0), 0)
        .relative_error("0.1");
    model
        .signal("still")
        .proves(v.equals(0), "0.02")
        .column("switch");
    model.event("stop", "still", "0.05").resets(&mu).resets(&k);
    assert_same(
        &model,
        r#"
        format = 1
        name = "all \"elements\""
        [states]
        x = { unit = "m", init = [-0.2, "pi/10"] }
        v = { unit = "m/s", init = 0, domain = [-50, 50] }
        [inputs]
        u = { unit = "m/s^2", domain = [-10, 10], error = { absolute = 0.01, relative = 0.001 }, column = "drive" }
        [disturbances]
        wind = [-0.1, 0.1]
        [params]
        "µ" = { bounds = [0, 0.4], unit = "m/s^2", nominal = 0.25 }
        k = { fixed = 2.5 }
        [let]
        drive = "u + wind - k*x"
        [der]
        x = "v"
        v = "drive - friction(v, drive, µ) + (if x > 1 or v != 0 then -k else 0.5)"
        [outputs]
        position = { expr = "x", error = 0.01, unit = "m", column = "s" }
        speed = { expr = "max(abs(v), 0)", error = { relative = 0.1 } }
        [signals]
        still = { proves = "v == 0", latency = 0.02, column = "switch" }
        [events]
        stop = { when = "still", lasts = 0.05, action = "reset µ, k" }
        "#,
    );
}

#[test]
fn modes_and_functions_are_what_they_are_in_a_file() {
    let mut model = ModelBuilder::new("modes");
    let x = model.state("x").init(1, 1).symbol();
    let p = model.param("p", 0, 1).symbol();
    let inside = x.at_most(2).and(!x.below(-2));
    let outside = Condition::always().and(x.at_least(2)).or(x.at_most(-2));
    let smooth: Symbol = [
        x.exp(),
        x.sin(),
        x.cos(),
        x.atan(),
        x.sinh(),
        x.cosh(),
        x.tanh(),
        x.asinh(),
    ]
    .into_iter()
    .sum();
    let partial = x.sqrt() * x.ln() / x.log2() - x.log10() * x.tan() + x.asin() - x.acos()
        + x.acosh() * x.atanh();
    model.mode("inside", inside).der(&x, smooth + partial);
    model.mode("outside", outside).der(
        &x,
        x.sat(-1, &p) + x.deadzone(-&p, 1) * x.min(&p).pow(-2) - 3 * p.sign()
            + x.table([("0", "1"), ("1.5", "2")])
            + sticking_friction(&x, 1, "0.1", "0.2") / "0.5",
    );
    model.output("x_m", &x, 1);
    assert_same(
        &model,
        r#"
        format = 1
        name = "modes"
        states = ["x"]
        init.x = 1
        params.p = [0, 1]
        outputs.x_m = "x +- 1"
        [modes.inside]
        when = "x <= 2 and not x < -2"
        der.x = "exp(x) + sin(x) + cos(x) + atan(x) + sinh(x) + cosh(x) + tanh(x) + asinh(x) + (sqrt(x)*log(x)/log2(x) - log10(x)*tan(x) + asin(x) - acos(x) + acosh(x)*atanh(x))"
        [modes.outside]
        when = "true and x >= 2 or x <= -2"
        der.x = "sat(x, -1, p) + deadzone(x, -p, 1)*min(x, p)^-2 - 3*sign(p) + table(x, 0, 1, 1.5, 2) + friction(x, 1, 0.1, 0.2)/0.5"
        "#,
    );
}

#[test]
fn a_model_in_code_grows_with_its_number_of_parts() {
    let mut model = ModelBuilder::new("chain");
    let count = 30;
    let stiffness = model.param("c", 1, 2).symbol();
    let places: Vec<Symbol> = (0..count)
        .map(|i| model.state(&format!("x{i}")).init(i, i).symbol())
        .collect();
    for (i, x) in places.iter().enumerate() {
        let neighbours: Symbol = [i.checked_sub(1), Some(i + 1)]
            .into_iter()
            .flatten()
            .filter_map(|j| places.get(j))
            .map(|other| other - x)
            .sum();
        model.der(x, &stiffness * neighbours);
    }
    model.output("end", &places[count - 1], "0.1");
    assert_eq!(built(&model).states.len(), count);
}

/// Saved and read again, under any name.
#[test]
fn every_model_is_saved_and_read_again_without_change() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut count = 0;
    let mut folders = vec![root.join("../../examples"), root.join("testdata/good")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path: PathBuf = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "toml") {
                let model = Model::from_file(&path).unwrap();
                let again = Model::from_text(&model.source.name, model.to_toml()).unwrap();
                assert_eq!(content(&model), content(&again), "{}", path.display());
                count += 1;
            }
        }
    }
    assert!(count >= 15, "{count}");
}

#[test]
fn a_built_model_is_saved_and_read_again_without_change() {
    let mut model = ModelBuilder::new("rig");
    let omega = model
        .state("omega")
        .unit("rad/s")
        .init("-0.1", "1/3")
        .symbol();
    model.der(&omega, "-0.1" * &omega);
    model.output("omega_m", &omega, Number::exactly(0.1));
    let problems = messages(&model);
    assert!(
        problems.contains("`1/3` is not a decimal number"),
        "{problems}"
    );
    let mut model = ModelBuilder::new("rig");
    let omega = model
        .state("omega")
        .init(Symbol::from(-1) / 3, Number::exactly(1e300))
        .symbol();
    model.der(&omega, Symbol::from(Number::exactly(1e-20)) * omega.pow(3));
    model.output("omega_m", &omega, Number::exactly(0.1));
    let first = built(&model);
    let again = Model::from_text("elsewhere.toml", first.to_toml()).unwrap();
    assert_eq!(content(&first), content(&again));
    assert_eq!(first.outputs[0].error.absolute.to_rational().to_string(), {
        "3602879701896397/36028797018963968"
    });
}

#[test]
fn messages_point_into_the_text_of_the_file() {
    let mut model = ModelBuilder::new("rig");
    let omega = model.state("omega").init("0,5", 1).symbol();
    model.der(&omega, "1e999" * &omega);
    model.output("omega_m", &omega, Number::exactly(f64::INFINITY));
    assert_eq!(
        messages(&model),
        "\
error[E0108]: `0,5` is not a decimal number
 --> rig (built in Rust):5:19
  |
5 | omega = { init = [0,5, 1] }
  |                   ^^^ not a decimal number
  |
  = help: write digits, as in 2.5 or 1e-3

error[E0108]: a number is too long or too far from one
 --> rig (built in Rust):8:9
  |
8 | omega = \"1e999\"
  |         ^^^^^^^ cannot be used
  |
  = help: write at most 400 digits and exponents up to 400

error[E0108]: a number is infinite
  --> rig (built in Rust):11:50
   |
11 | omega_m = { expr = \"omega\", error = { absolute = inf } }
   |                                                  ^^^ not a decimal number
   |
   = help: write a finite number
"
    );
    let mut model = ModelBuilder::new("rig");
    let omega = model.state("omega").init("0.5", 1).symbol();
    let other = ModelBuilder::new("other").param("alpah", 0, 1).symbol();
    model.param("alpha", 0, 1);
    model.der(&omega, &other * &omega);
    model.output("omega_m", &omega, 1);
    assert_eq!(
        messages(&model),
        "\
error[E0201]: `alpah` is not declared
  --> rig (built in Rust):11:10
   |
11 | omega = \"alpah*omega\"
   |          ^^^^^ not a state, input, parameter or [let]
   |
   = help: did you mean `alpha`?
"
    );
}

#[test]
fn what_is_too_long_is_refused_at_once() {
    let start = Instant::now();
    let mut model = ModelBuilder::new("long");
    let x = model.state("x").init(0, 1).symbol();
    let (mut doubled, mut nested) = (x.clone(), x.clone());
    for _ in 0..100_000 {
        doubled = &doubled * &doubled;
        nested = nested.sin();
    }
    model.der(&x, &doubled);
    model.output("x_m", &nested, 1);
    assert_eq!(
        messages(&model),
        "\
error[E0113]: the expression is too long
 --> long (built in Rust):8:5
  |
8 | x = \"...\"
  |     ^^^^^ more than can be read
  |
  = help: give parts of it a name with define

error[E0113]: the expression is too long
  --> long (built in Rust):11:16
   |
11 | x_m = { expr = \"...\", error = { absolute = 1 } }
   |                ^^^^^ more than can be read
   |
   = help: give parts of it a name with define
"
    );
    let mut model = ModelBuilder::new("long");
    let x = model.state("x").init(0, 1).symbol();
    model.der(&x, -&x);
    for i in 0..9_000 {
        model.output(&format!("x_{i}"), &x, 1);
    }
    assert_eq!(
        messages(&model),
        "\
error[E0113]: the text of the model has 448974 bytes
 |
 = help: stay below 262144: name parts that are used often with define
"
    );
    assert!(start.elapsed() < Duration::from_secs(5));
}
