//! Whatever a file holds, reading it ends with a model or with messages.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

use std::time::{Duration, Instant};
use veribound_model::Model;

/// Numbers without pattern, the same in every run.
struct Dice(u64);

impl Dice {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % limit.max(1)
    }
}

const PIECES: [&str; 44] = [
    "(",
    ")",
    "[",
    "]",
    "{",
    "}",
    "\"",
    "'",
    "\"\"\"",
    "=",
    "==",
    "<=",
    ">",
    "!=",
    ",",
    ".",
    "+-",
    "±",
    "^",
    "**",
    "-",
    "+",
    "*",
    "/",
    "\n",
    "\\",
    "\\u00e9",
    "sign(omega)",
    "friction(omega, u, T_Fs)",
    "min(",
    "abs(",
    "not ",
    " and ",
    " or ",
    "1e308",
    "1e-400",
    "9999999999999999999999",
    "0x1F",
    "nan",
    "inf",
    "pi",
    "omega",
    "^-1000",
    "é",
];

fn read(text: &str) {
    match Model::from_text("garbage.toml", text) {
        Ok(model) => assert!(!model.describe().is_empty()),
        Err(problems) => {
            assert!(!problems.0.is_empty());
            assert!(problems.render(false).starts_with("error[E"));
            for problem in &problems.0 {
                if let Some((source, range)) = &problem.place {
                    assert!(range.start <= range.end && range.end <= source.text.len());
                }
            }
        }
    }
}

#[test]
fn changed_models_never_panic() {
    let mut dice = Dice(1);
    let texts: Vec<String> = ["rig-long", "rig-short", "pendulum", "tanks", "emps"]
        .iter()
        .map(|name| std::fs::read_to_string(format!("testdata/good/{name}.toml")).unwrap())
        .collect();
    let start = Instant::now();
    let mut count = 0;
    while count < 4000 && start.elapsed() < Duration::from_secs(20) {
        let mut symbols: Vec<char> = texts[dice.below(texts.len())].chars().collect();
        for _ in 0..=dice.below(4) {
            let at = dice.below(symbols.len());
            match dice.below(4) {
                0 => {
                    symbols.remove(at);
                }
                1 => {
                    let other = dice.below(symbols.len());
                    symbols.swap(at, other);
                }
                2 => {
                    let end = (at + dice.below(40)).min(symbols.len());
                    symbols.drain(at..end);
                }
                _ => {
                    let piece = PIECES[dice.below(PIECES.len())];
                    symbols.splice(at..at, piece.chars());
                }
            }
            if symbols.is_empty() {
                break;
            }
        }
        let text: String = symbols.into_iter().collect();
        read(&text);
        count += 1;
    }
    assert!(count > 200, "only {count} texts in time");
}

#[test]
fn random_expressions_never_panic() {
    let mut dice = Dice(2);
    let start = Instant::now();
    let mut count = 0;
    while count < 4000 && start.elapsed() < Duration::from_secs(20) {
        let mut expression = String::new();
        for _ in 0..dice.below(30) {
            expression.push_str(PIECES[dice.below(PIECES.len())]);
            if dice.below(2) == 0 {
                expression.push_str(["omega", "u", "T_Fs", "2", "0"][dice.below(5)]);
            }
        }
        read(&format!(
            "format = 1\nstates = [\"phi\", \"omega\"]\ninputs = [\"u\"]\ninit = {{ phi = 0, omega = 0 }}\n\
             params = {{ T_Fs = [0, 1] }}\noutputs = {{ y = '''phi +- 1''' }}\n\
             [modes.one]\nwhen = '''{expression}'''\nder = {{ phi = '''{expression}''', omega = \"0\" }}\n"
        ));
        count += 1;
    }
    assert!(count > 200, "only {count} texts in time");
}

#[test]
fn shared_definitions_do_not_explode() {
    let mut text = String::from(
        "format = 1\nstates = [\"x\"]\ninit = { x = 0 }\nder = { x = \"a199\" }\noutputs = { y = \"x +- 1\" }\n[let]\n",
    );
    // In reverse order, and each needs the next one twice.
    for i in (1..200).rev() {
        text.push_str(&format!("a{i} = \"sin(a{0}) * cos(a{0})\"\n", i - 1));
    }
    text.push_str("a0 = \"x\"\n");
    let model = Model::from_text("m.toml", text).unwrap();
    assert!(model.describe().contains("an expression of"));
}

#[test]
fn huge_files_are_refused() {
    read(&"x = 1\n".repeat(100_000));
    read(&"[".repeat(100_000));
    read(&format!(
        "a = {}1{}",
        "[".repeat(60_000),
        "]".repeat(60_000)
    ));
    read(&format!(
        "[params]\n{}",
        (0..20_000)
            .map(|i| format!("p{i} = 1\n"))
            .collect::<String>()
    ));
    let states: String = (0..3000).map(|i| format!("\"s{i}\",")).collect();
    read(&format!("format = 1\nstates = [{states}]"));
}
