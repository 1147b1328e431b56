//! What `docs/model-file.md` shows can be read, and it shows all functions.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

use veribound_model::Model;

const PAGE: &str = include_str!("../../../docs/model-file.md");

/// The TOML blocks of the page.
fn blocks() -> Vec<&'static str> {
    let parts = PAGE.split("```toml\n").skip(1);
    parts
        .map(|part| part.split("```").next().unwrap())
        .collect()
}

fn read(text: &str) -> Model {
    Model::from_text("model.toml", text)
        .unwrap_or_else(|problems| panic!("{}", problems.render(false)))
}

#[test]
fn its_examples_can_be_read() {
    let [whole, chain, modes, bounce, relay, signals] = blocks()[..] else {
        panic!("another number of examples: {}", blocks().len());
    };
    let model = read(whole);
    assert_eq!((model.modes.len(), model.inputs.len()), (3, 2));
    let model = read(&format!(
        "format = 1\n{chain}[outputs]\ny = \"x1 +- 0.1\"\n"
    ));
    assert_eq!((model.states.len(), model.params.len()), (20, 11));
    let model = read(&format!(
        "format = 1\nstates = [\"h\", \"v\", \"T\", \"on\"]\n\
         init = {{ h = 1, v = 0, T = 20, on = 0 }}\nparams.e = [0, 1]\n\
         der = {{ h = \"v\", v = \"-9.81\", T = \"on - T\", on = \"0\" }}\n\
         outputs.y = \"h +- 0.1\"\n{bounce}{}",
        relay.replace("[jumps]\n", "")
    ));
    assert_eq!(model.jumps.len(), 3);
    let frame = "format = 1\nstates = [\"phi\", \"omega\"]\ninputs = [\"u\"]\n\
                 init = { phi = 0, omega = 0 }\noutputs.y = \"phi +- 0.1\"\n";
    let model = read(&format!("{frame}{modes}{signals}"));
    assert_eq!(model.modes.len(), 3);
    assert_eq!(model.signals[0].resets[0].param, 0);
    let other = "T = { bounds = [0, 0.3], resets = \"standstill\" }";
    let said = signals
        .replace("T = [0, 0.3]", other)
        .replace(", action = \"reset T\"", "");
    assert_ne!(said, signals);
    assert_eq!(
        read(&format!("{frame}{modes}{said}")).signals[0].resets[0].param,
        0
    );
}

#[test]
fn it_names_every_function() {
    let text = "format = 1\nstates = [\"x\"]\ninit.x = 0\nder.x = \"qqqqqqqqq(x)\"\n\
                outputs.y = \"x +- 1\"\n";
    let problems = Model::from_text("model.toml", text).unwrap_err();
    let help = &problems.0[0].help;
    let list = help.strip_prefix("known functions are ").unwrap();
    let names: Vec<&str> = list.split("; ").next().unwrap().split(", ").collect();
    assert!(names.len() > 20, "{help}");
    for name in names {
        let spoken = |before: char| PAGE.contains(&format!("{before}{name}"));
        assert!(spoken('`') || spoken(' '), "`{name}` is not on the page");
    }
}

#[test]
fn what_it_says_of_functions_holds() {
    let velocity = |text: &str| {
        let text = format!(
            "format = 1\nstates = [\"x\"]\ninit.x = 0\nparams.T = [0, 1]\nder.x = \"{text}\"\n\
             outputs.y = \"x +- 1\"\n"
        );
        read(&text).modes.len()
    };
    for (text, modes) in [
        ("sign(x)", 2),
        ("floor(x) + round(x)*atan2(T, x) + x^T", 1),
        ("if x > 0 then 1 else 2", 2),
        ("table(x, 0, 0, 1, T)", 1),
        ("table(x, 0, 0, 0, T)", 2),
        ("-friction(x, 0.5, T)", 3),
        ("-friction(x, 0.5, T, T + 1) - friction(x + 1, 0, T)", 9),
        (
            "sat(x, 1) + sat(x, -T, 2) + deadzone(x, 1) + deadzone(x, -1, T)",
            1,
        ),
        ("1 + if x > 0 then 1 else 2 + 3", 2),
    ] {
        assert_eq!(velocity(text), modes, "{text}");
    }
}
