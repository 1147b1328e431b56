//! Whatever a file holds, reading it ends with a model or with messages.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

use std::time::{Duration, Instant};
use veribound_interval::Interval;
use veribound_model::{Model, Tape};

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

const PIECES: [&str; 70] = [
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
    "if ",
    " then ",
    " else ",
    "table(omega, ",
    "sat(",
    "deadzone(",
    "asin(",
    "cosh(",
    "floor(",
    "round(",
    "atan2(",
    "^0.5",
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
    "{i}",
    "{i+1}",
    "{n}",
    "{",
    "{i=1..n}",
    "{j=1..3}",
    "{i=n..2}",
    "{i=1..999}",
    "..",
    "sum{j=1..n}(",
    "max{j=1..n-1}(",
    "product{i=1..3}(x{i})",
    "any{j=2..n}(x{j} > 0)",
    "2*",
];

/// Longer for one text is a hang; the machine may be busy with other tests.
const LONGEST: Duration = Duration::from_secs(5);

/// How long one test goes on: `VERIBOUND_FUZZ_SECONDS`, else until it has read some thousand texts.
fn goes_on(start: Instant, count: usize) -> bool {
    let asked = std::env::var("VERIBOUND_FUZZ_SECONDS").ok();
    match asked.and_then(|seconds| seconds.parse().ok()) {
        Some(seconds) => start.elapsed() < Duration::from_secs(seconds),
        None => count < 4000 && start.elapsed() < Duration::from_secs(20),
    }
}

fn read(text: &str) {
    let start = Instant::now();
    understand(text);
    assert!(
        start.elapsed() < LONGEST,
        "{:?} for\n{text}",
        start.elapsed()
    );
}

fn understand(text: &str) {
    match Model::from_text("garbage.toml", text) {
        Ok(model) => {
            assert!(!model.describe().is_empty());
            evaluate(&model);
        }
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

/// Outputs, and new values at jumps, on a box and back.
fn evaluate(model: &Model) {
    let jumps = model.jumps.iter().flat_map(|jump| &jump.set);
    let outputs = model.outputs.iter().map(|output| output.expr);
    for e in outputs.chain(jumps.map(|(_, value)| *value)) {
        let tape = Tape::compile(&model.graph, model.layout(), &[e]);
        let mut registers = tape.registers::<Interval>();
        let mut quantities = vec![Interval::new(-1.0, 2.0).unwrap(); model.layout().len()];
        tape.eval(&quantities, &mut registers);
        tape.contract(&mut quantities, Interval::ONE, &mut registers);
    }
}

#[test]
fn changed_models_never_panic() {
    let mut dice = Dice(1);
    let texts: Vec<String> = [
        "rig-long",
        "rig-short",
        "pendulum",
        "tanks",
        "emps",
        "chain",
        "jumps",
        "if-in-output",
        "disturbed",
        "units",
    ]
    .iter()
    .map(|name| std::fs::read_to_string(format!("testdata/good/{name}.toml")).unwrap())
    .collect();
    let start = Instant::now();
    let mut count = 0;
    while goes_on(start, count) {
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
    while goes_on(start, count) {
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

/// A value, well-formed, of any shape.
fn value(dice: &mut Dice, depth: usize) -> String {
    const UNARY: [&str; 26] = [
        "sqrt", "exp", "log", "ln", "log2", "log10", "sin", "cos", "tan", "asin", "acos", "atan",
        "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "abs", "sign", "-", "cbrt", "floor",
        "ceil", "round", "trunc",
    ];
    if depth == 0 {
        return [
            "omega", "phi", "u", "T_Fs", "d", "pi", "0", "2", "0.5", "1e-9", "part",
        ][dice.below(11)]
        .to_string();
    }
    let kind = dice.below(18);
    let mut inner = || value(dice, depth - 1);
    match kind {
        0..=4 => {
            let (a, b) = (inner(), inner());
            format!("({a} {} {b})", ["+", "-", "*", "/"][dice.below(4)])
        }
        5 => {
            let a = inner();
            format!("({a})^({})", dice.below(9) as i64 - 4)
        }
        6..=9 => {
            let a = inner();
            format!("{}({a})", UNARY[dice.below(UNARY.len())])
        }
        10 => format!("min({}, {})", inner(), inner()),
        16 => format!("atan2({}, {})", inner(), inner()),
        17 => format!("({})^({})", inner(), inner()),
        11 => {
            let (a, b, c) = (inner(), inner(), inner());
            format!("(if {} then {b} else {c})", condition(dice, depth - 1, &a))
        }
        12 => format!("sat({}, {})", inner(), inner()),
        13 => format!("deadzone({}, {}, {})", inner(), inner(), inner()),
        14 => format!(
            "table({}, -1, {}, 0, {}, 0, 1, 3, 2)",
            inner(),
            inner(),
            inner()
        ),
        _ => format!(
            "friction({}, {}, {}, {})",
            inner(),
            inner(),
            inner(),
            inner()
        ),
    }
}

fn condition(dice: &mut Dice, depth: usize, left: &str) -> String {
    let right = value(dice, depth);
    let one = format!(
        "{left} {} {right}",
        ["<", "<=", ">", ">=", "==", "!="][dice.below(6)]
    );
    match dice.below(6) {
        0 if depth > 0 => format!("({one}) and {}", condition(dice, depth - 1, left)),
        1 if depth > 0 => format!("({one}) or {}", condition(dice, depth - 1, left)),
        2 => format!("not ({one})"),
        _ => one,
    }
}

#[test]
fn well_formed_expressions_are_understood_in_time() {
    let mut dice = Dice(3);
    let start = Instant::now();
    let (mut count, mut models) = (0, 0);
    while goes_on(start, count) {
        let depth = dice.below(5);
        let (part, velocity) = (value(&mut dice, depth), value(&mut dice, depth));
        // Friction is refused in outputs and jumps; most texts shall be models.
        let output = match dice.below(3) {
            0 => "phi".to_owned(),
            _ => value(&mut dice, depth.min(2)),
        };
        let law = if dice.below(3) > 0 {
            format!("der = {{ phi = \"omega\", omega = \"{velocity}\" }}")
        } else {
            let (left, other) = (value(&mut dice, 1), value(&mut dice, 1));
            let (one, two) = (
                condition(&mut dice, 2, &left),
                condition(&mut dice, 1, &other),
            );
            let der = format!("der = {{ phi = \"omega\", omega = \"{velocity}\" }}");
            format!(
                "modes.a = {{ when = \"{one}\", {der} }}\nmodes.b = {{ when = \"not ({one}) or {two}\", {der} }}"
            )
        };
        let jump = if dice.below(3) > 0 {
            String::new()
        } else {
            let new = value(&mut dice, depth.min(2));
            let border = value(&mut dice, 1);
            format!(
                "jumps.j = {{ when = \"{border} > 1 and omega < 0\", set = {{ omega = \"{new}\" }} }}\n"
            )
        };
        let text = format!(
            "format = 1\nstates = [\"phi\", \"omega\"]\ninputs = [\"u\"]\ninit = {{ phi = 0, omega = 0 }}\n\
             disturbances.d = [-1, 1]\nparams = {{ T_Fs = [0, 1] }}\nlet.part = \"{}\"\n{law}\n{jump}\
             outputs = {{ y = \"{output} +- 1\" }}\n",
            part.replace("part", "1")
        );
        read(&text);
        models += usize::from(Model::from_text("m.toml", text).is_ok());
        count += 1;
    }
    assert!(count > 200, "only {count} texts in time");
    assert!(models > count / 4, "{models} of {count} are models");
    println!("{models} models of {count} texts in {:?}", start.elapsed());
}

#[test]
fn choices_inside_choices_are_refused_at_once() {
    let nested = |levels: usize, step: &str| {
        (0..levels).fold("1".to_string(), |inner, level| {
            step.replace('#', &level.to_string()).replace('_', &inner)
        })
    };
    for expression in [
        nested(60, "if x > # then _ else 2"),
        nested(60, "(if x > # then 1 else _)"),
        nested(60, "sign(x - # + _)"),
        nested(30, "friction(x - # + _, x, 1)"),
        nested(60, "table(_, 0, 1, 1, 2, 1, x)"),
        nested(60, "sat(_, x)"),
        nested(60, "deadzone(_, #, x + 100)"),
        format!(
            "0{}",
            (0..300)
                .map(|i| format!(" + sign(x - {i})"))
                .collect::<String>()
        ),
    ] {
        read(&format!(
            "format = 1\nstates = [\"x\"]\ninit.x = 0\nder.x = \"{expression}\"\noutputs.y = \"x +- 1\"\n"
        ));
    }
}

/// A text with braces of any kind.
fn template(dice: &mut Dice, depth: usize) -> String {
    let index = |dice: &mut Dice| {
        [
            "i", "j", "n", "i+1", "2*i-1", "n-i", "-i", "0", "j*j", "(i", "k",
        ][dice.below(11)]
    };
    let range = |dice: &mut Dice| {
        let ends = [
            "1..n", "2..n-1", "n..1", "1..i", "1..1000", "0..2", "1..", "3..2",
        ];
        format!("{}={}", ["i", "j", "k"][dice.below(3)], ends[dice.below(8)])
    };
    if depth == 0 {
        return match dice.below(4) {
            0 => "x1".to_string(),
            1 => format!("{{{}}}", index(dice)),
            2 => format!("x{{{}}}_{{{}}}", index(dice), index(dice)),
            _ => format!("x{{{}}}", index(dice)),
        };
    }
    let fold = ["sum", "product", "min", "max", "all", "any", "x", ""][dice.below(8)];
    match dice.below(4) {
        0 => format!(
            "{} + {}",
            template(dice, depth - 1),
            template(dice, depth - 1)
        ),
        1 => format!("x{{{}}}", range(dice)),
        _ => format!("{fold}{{{}}}({})", range(dice), template(dice, depth - 1)),
    }
}

#[test]
fn templates_are_understood_in_time() {
    let mut dice = Dice(4);
    let start = Instant::now();
    let (mut count, mut models) = (0, 0);
    while goes_on(start, count) {
        let depth = dice.below(4);
        let (value, item, key) = (
            template(&mut dice, depth),
            template(&mut dice, 1),
            template(&mut dice, 1),
        );
        // Half of them are right but for the value.
        let (item, key) = if dice.below(2) == 0 {
            (item.as_str(), key.as_str())
        } else {
            ("y{i=1..n}", "y{i=1..n}")
        };
        let text = format!(
            "format = 1\nsizes = {{ n = {} }}\nstates = [\"x{{i=1..4}}\", \"{item}\"]\n\
             init = {{ \"x{{i=1..4}}\" = 0, \"{key}\" = 0 }}\nparams.\"p{{k=0..3}}\" = [0, {{}}]\n\
             outputs.o = \"x1 +- 1\"\n[der]\n\"x{{i=1..4}}\" = \"{value}\"\n\"{key}\" = \"p{{i-1}}\"\n",
            dice.below(5)
        )
        .replace("[0, {}]", "[0, 1]");
        read(&text);
        models += usize::from(Model::from_text("m.toml", text).is_ok());
        count += 1;
    }
    assert!(count > 200, "only {count} texts in time");
    assert!(models > count / 50, "{models} of {count} are models");
    println!("{models} models of {count} texts in {:?}", start.elapsed());
}

#[test]
fn templates_without_end_are_refused_at_once() {
    let fold = |levels: usize, last: i64| {
        let before: String = (0..levels)
            .map(|i| format!("sum{{i{i}=1..{last}}}("))
            .collect();
        format!("{before}x{}", ")".repeat(levels))
    };
    let names = |levels: usize, last: i64| -> String {
        let each = (0..levels).map(|i| format!("{{i{i}=1..{last}}}_"));
        format!("p{}", each.collect::<String>())
    };
    for (expression, name) in [
        (fold(3, 1000), "p".to_string()),
        (fold(8, 2), names(9, 2)),
        (fold(20_000, 1), "p".to_string()),
        (fold(8, 1000), names(8, 1000)),
        (fold(1, 1_000_000), names(1, 1_000_000)),
        (fold(1, i64::MAX), names(1, i64::MAX)),
        ("1".to_string(), names(8, 1000) + "{e=2..1}"),
        (
            "sum{a=1..1000}(sum{b=1..1000}(sum{c=2..1}(x)))".to_string(),
            "p".to_string(),
        ),
        ("{".repeat(50_000), "{".repeat(50_000)),
        (
            format!("x{{{}1}}", "-".repeat(50_000)),
            format!("p{{{}1}}", "(".repeat(50_000)),
        ),
    ] {
        let start = Instant::now();
        read(&format!(
            "format = 1\nstates = [\"x\"]\ninit.x = 0\nder.x = \"{expression}\"\nparams.\"{name}\" = [0, 1]\n\
             outputs.y = \"x +- 1\"\n"
        ));
        assert!(
            start.elapsed() < Duration::from_secs(1),
            "{:?}",
            start.elapsed()
        );
    }
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
