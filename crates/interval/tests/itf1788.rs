//! The ITF1788 test vectors for interval arithmetic, read from the shared data folder.
//!
//! The vectors lie outside the repository: `$VERIBOUND_SHARED/data/itf1788`, or `../shared/data/itf1788`
//! beside the checkout. Where they are absent the test says so and checks nothing.
//!
//! Operations that IEEE 1788 wants tight must give equal intervals. The others must contain the
//! expected interval and may be wider by a few floats (`sign` by more: sign(0) is [-1, 1] here). What differs by decision is listed in
//! [`DIFFERENT`].

#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

use std::collections::BTreeMap;
use std::io::Write;
use std::path::PathBuf;

use veribound_interval::{Interval, Truth};

/// Vectors that are not applied, and why.
const DIFFERENT: [(&str, &str); 4] = [
    ("not an interval", "there is no ill-formed interval"),
    (
        "signal",
        "constructors return None instead of raising a signal",
    ),
    (
        "NaN",
        "numbers describing the empty set are 0 instead of NaN",
    ),
    ("empty order", "comparisons with the empty set are Unknown"),
];

#[derive(Clone, Debug, PartialEq)]
enum Item {
    Set(Interval),
    Number(f64),
    Claim(bool),
}

/// How near to the expected interval the result has to be: floats per end.
#[derive(Clone, Copy)]
enum Near {
    Equal,
    Floats(u32),
    /// Contains the expected interval, as far as is known.
    Contains,
}

fn folder() -> PathBuf {
    match std::env::var_os("VERIBOUND_SHARED") {
        Some(shared) => PathBuf::from(shared).join("data/itf1788"),
        None => PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/itf1788"),
    }
}

/// A number literal: decimal or hexadecimal, read as the nearest float.
fn number(text: &str) -> Option<f64> {
    let lower = text.to_ascii_lowercase();
    let (negative, size) = match lower.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, lower.strip_prefix('+').unwrap_or(&lower)),
    };
    let value = match size {
        "inf" | "infinity" => f64::INFINITY,
        _ => match size.strip_prefix("0x") {
            Some(hex) => hexadecimal(hex)?,
            None => size.parse().ok().filter(|x: &f64| x.is_finite())?,
        },
    };
    Some(if negative { -value } else { value })
}

/// `h.hhhp±d`, exact for the literals of the vectors (at most 64 significant bits that fit a float).
fn hexadecimal(text: &str) -> Option<f64> {
    let (mantissa, exponent) = text.split_once('p')?;
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let digits = u64::from_str_radix(&format!("{whole}{fraction}"), 16).ok()?;
    let mut exponent: i32 = exponent.trim_start_matches('+').parse().ok()?;
    exponent -= 4 * fraction.len() as i32;
    let mut value = digits as f64;
    // Two steps, so that neither the factor nor the intermediate leaves the range of floats.
    while exponent < -1000 {
        value *= 2_f64.powi(-200);
        exponent += 200;
    }
    while exponent > 900 {
        value *= 2_f64.powi(100);
        exponent -= 100;
    }
    Some(value * 2_f64.powi(exponent))
}

fn set(text: &str) -> Option<Interval> {
    let inner = text.strip_prefix('[')?.strip_suffix(']')?.trim();
    match inner.to_ascii_lowercase().as_str() {
        "empty" => return Some(Interval::EMPTY),
        "entire" => return Some(Interval::ENTIRE),
        _ => {}
    }
    let (lo, hi) = inner.split_once(',').unwrap_or((inner, inner));
    Interval::new(number(lo.trim())?, number(hi.trim())?)
}

/// Splits at blanks outside brackets.
fn words(text: &str) -> Vec<String> {
    let (mut words, mut word, mut depth) = (Vec::new(), String::new(), 0);
    for c in text.chars() {
        match c {
            '[' => depth += 1,
            ']' => depth -= 1,
            _ => {}
        }
        if c.is_whitespace() && depth == 0 {
            if !word.is_empty() {
                words.push(std::mem::take(&mut word));
            }
        } else {
            word.push(c);
        }
    }
    if !word.is_empty() {
        words.push(word);
    }
    words
}

fn item(word: &str) -> Option<Item> {
    match word {
        "true" => Some(Item::Claim(true)),
        "false" => Some(Item::Claim(false)),
        _ if word.starts_with('[') => set(word).map(Item::Set),
        _ => number(word).map(Item::Number),
    }
}

/// Statements `operation arguments = results` of one file, without comments and decorations: there are
/// none here, so the bare intervals are compared.
fn statements(text: &str) -> Vec<String> {
    let mut plain = String::new();
    let mut rest = text;
    while let Some(start) = rest.find("/*") {
        plain.push_str(&rest[..start]);
        rest = rest[start..]
            .find("*/")
            .map_or("", |end| &rest[start + end + 2..]);
    }
    plain.push_str(rest);
    let lines = plain
        .lines()
        .map(|line| line.split("//").next().unwrap_or("").trim());
    lines
        .collect::<Vec<_>>()
        .join(" ")
        .split([';', '{', '}'])
        .map(str::trim)
        .filter(|statement| statement.contains('='))
        .map(|statement| {
            ["_com", "_dac", "_def", "_trv"]
                .iter()
                .fold(statement.to_string(), |text, decoration| {
                    text.replace(&format!("]{decoration}"), "]")
                })
        })
        .collect()
}

/// The result of an operation, and how near it has to be; `None` for operations that do not exist.
fn apply(operation: &str, arguments: &[Item]) -> Option<(Vec<Item>, Near)> {
    use Item::{Claim, Number, Set};
    use Near::{Contains, Equal, Floats};
    let one = |x: Interval, near| Some((vec![Set(x)], near));
    let count = |x: f64| Some((vec![Number(x)], Equal));
    let claim = |x: bool| Some((vec![Claim(x)], Equal));
    let floats_of_power = |n: f64| {
        if (-1.0..=2.0).contains(&n) {
            Equal
        } else {
            Floats(2 * n.abs() as u32)
        }
    };
    match (operation, arguments) {
        ("pos", &[Set(x)]) => one(x, Equal),
        ("neg", &[Set(x)]) => one(-x, Equal),
        ("add", &[Set(x), Set(y)]) => one(x + y, Equal),
        ("sub", &[Set(x), Set(y)]) => one(x - y, Equal),
        ("mul", &[Set(x), Set(y)]) => one(x * y, Equal),
        ("div", &[Set(x), Set(y)]) => one(x / y, Equal),
        ("recip", &[Set(x)]) => one(x.recip(), Equal),
        ("sqr", &[Set(x)]) => one(x.sqr(), Equal),
        ("sqrt", &[Set(x)]) => one(x.sqrt(), Equal),
        ("abs", &[Set(x)]) => one(x.abs(), Equal),
        ("min", &[Set(x), Set(y)]) => one(x.min(y), Equal),
        ("max", &[Set(x), Set(y)]) => one(x.max(y), Equal),
        ("sign", &[Set(x)]) => one(x.sign(), Contains),
        ("exp", &[Set(x)]) => one(x.exp(), Floats(1)),
        ("log", &[Set(x)]) => one(x.ln(), Floats(1)),
        ("sin", &[Set(x)]) => one(x.sin(), Floats(1)),
        ("cos", &[Set(x)]) => one(x.cos(), Floats(1)),
        ("tan", &[Set(x)]) => one(x.tan(), Floats(1)),
        ("atan", &[Set(x)]) => one(x.atan(), Floats(1)),
        ("tanh", &[Set(x)]) => one(x.tanh(), Floats(1)),
        ("pown", &[Set(x), Number(n)]) => one(x.powi(n as i32), floats_of_power(n)),
        ("intersection", &[Set(x), Set(y)]) => one(x.intersect(y), Equal),
        ("convexHull", &[Set(x), Set(y)]) => one(x.hull(y), Equal),
        ("mid", &[Set(x)]) => count(x.mid()),
        ("rad", &[Set(x)]) => count(x.rad()),
        ("midRad", &[Set(x)]) => Some((vec![Number(x.mid()), Number(x.rad())], Equal)),
        ("wid", &[Set(x)]) => count(x.width()),
        ("mag", &[Set(x)]) => count(x.mag()),
        ("mig", &[Set(x)]) => count(x.mig()),
        ("inf", &[Set(x)]) => count(x.lo()),
        ("sup", &[Set(x)]) => count(x.hi()),
        ("isEmpty", &[Set(x)]) => claim(x.is_empty()),
        ("isEntire", &[Set(x)]) => claim(x == Interval::ENTIRE),
        ("isSingleton", &[Set(x)]) => claim(x.is_point()),
        ("isCommonInterval", &[Set(x)]) => claim(x.is_bounded()),
        ("isMember", &[Number(m), Set(x)]) => claim(x.contains(m)),
        ("equal", &[Set(x), Set(y)]) => claim(x == y),
        ("subset", &[Set(x), Set(y)]) => claim(x.is_subset_of(y)),
        ("interior", &[Set(x), Set(y)]) => claim(x.is_interior_of(y)),
        ("disjoint", &[Set(x), Set(y)]) => claim(!x.intersects(y)),
        ("precedes", &[Set(x), Set(y)]) => claim(x.less_equal(y) == Truth::True),
        ("strictPrecedes", &[Set(x), Set(y)]) => claim(x.less(y) == Truth::True),
        ("sqrRev", &[Set(c)]) => one(Interval::sqr_rev(c, Interval::ENTIRE), Equal),
        ("sqrRevBin", &[Set(c), Set(x)]) => one(Interval::sqr_rev(c, x), Equal),
        ("absRev", &[Set(c)]) => one(Interval::abs_rev(c, Interval::ENTIRE), Equal),
        ("absRevBin", &[Set(c), Set(x)]) => one(Interval::abs_rev(c, x), Equal),
        ("pownRev", &[Set(c), Number(n)]) => one(
            Interval::powi_rev(n as i32, c, Interval::ENTIRE),
            Floats(40),
        ),
        ("pownRevBin", &[Set(c), Set(x), Number(n)]) => {
            one(Interval::powi_rev(n as i32, c, x), Floats(40))
        }
        ("sinRev", &[Set(c)]) => one(Interval::sin_rev(c, Interval::ENTIRE), Equal),
        ("cosRev", &[Set(c)]) => one(Interval::cos_rev(c, Interval::ENTIRE), Equal),
        ("tanRev", &[Set(c)]) => one(Interval::tan_rev(c, Interval::ENTIRE), Equal),
        ("sinRevBin", &[Set(c), Set(x)]) => one(Interval::sin_rev(c, x), Floats(4)),
        ("cosRevBin", &[Set(c), Set(x)]) => one(Interval::cos_rev(c, x), Floats(4)),
        ("tanRevBin", &[Set(c), Set(x)]) => one(Interval::tan_rev(c, x), Floats(4)),
        ("mulRev", &[Set(b), Set(c)]) => one(Interval::mul_rev(b, c, Interval::ENTIRE), Equal),
        ("mulRevTen", &[Set(b), Set(c), Set(x)]) => one(Interval::mul_rev(b, c, x), Equal),
        ("mulRevToPair", &[Set(b), Set(c)]) => {
            let (first, second) = Interval::mul_rev_pair(b, c);
            Some((vec![Set(first), Set(second)], Equal))
        }
        _ => None,
    }
}

fn agrees(found: &Item, expected: &Item, near: Near) -> bool {
    let (Item::Set(found), Item::Set(expected)) = (found, expected) else {
        return found == expected;
    };
    let floats = match near {
        Near::Equal => return found == expected,
        Near::Contains => return expected.is_subset_of(*found),
        Near::Floats(floats) => floats,
    };
    let (mut lo, mut hi) = (expected.lo(), expected.hi());
    for _ in 0..floats {
        (lo, hi) = (lo.next_down(), hi.next_up());
    }
    let emptiness = found.is_empty() == expected.is_empty();
    emptiness
        && expected.is_subset_of(*found)
        && (found.is_empty() || (found.lo() >= lo && found.hi() <= hi))
}

/// Why a statement is not applied, if its text says so.
fn left_out(operation: &str, statement: &str) -> Option<&'static str> {
    let decorated = statement.contains("[nai]") || statement.contains("_ill");
    let order = operation == "precedes" || operation == "strictPrecedes";
    if decorated {
        Some("not an interval")
    } else if statement.contains("signal") {
        Some("signal")
    } else if statement.contains("NaN") {
        Some("NaN")
    } else if order && statement.contains("[empty]") {
        Some("empty order")
    } else {
        None
    }
}

/// Writes past the capture of the test program, which hides the output of tests that pass.
fn say(line: &str) {
    std::io::stderr()
        .write_all(format!("{line}\n").as_bytes())
        .unwrap();
}

#[test]
fn vectors_of_itf1788() {
    let folder = folder();
    let Ok(files) = std::fs::read_dir(&folder) else {
        say(&format!(
            "SKIPPED: no ITF1788 vectors in {}; set VERIBOUND_SHARED",
            folder.display()
        ));
        return;
    };
    let mut names: Vec<PathBuf> = files
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "itl"))
        .collect();
    names.sort();
    let (mut applied, mut failures) = (BTreeMap::new(), Vec::new());
    let mut missing: BTreeMap<String, usize> = BTreeMap::new();
    let mut skipped: BTreeMap<&str, usize> = BTreeMap::new();
    for path in &names {
        let text = std::fs::read_to_string(path).unwrap();
        for statement in statements(&text) {
            let (call, expected) = statement.split_once('=').unwrap();
            let call = words(call);
            let Some(operation) = call.first().cloned() else {
                continue;
            };
            if let Some(reason) = left_out(&operation, &statement) {
                *skipped.entry(reason).or_default() += 1;
                continue;
            }
            let expected = expected.split("<=").next().unwrap_or("");
            let arguments: Option<Vec<Item>> = call[1..].iter().map(|word| item(word)).collect();
            let expected: Option<Vec<Item>> =
                words(expected).iter().map(|word| item(word)).collect();
            let result = arguments
                .as_deref()
                .and_then(|given| apply(&operation, given));
            let (Some((found, near)), Some(expected)) = (result, expected) else {
                *missing.entry(operation).or_default() += 1;
                continue;
            };
            *applied.entry(operation).or_insert(0_usize) += 1;
            let all = found.len() == expected.len()
                && found.iter().zip(&expected).all(|(a, b)| agrees(a, b, near));
            if !all {
                let file = path.file_name().unwrap().to_string_lossy().into_owned();
                failures.push(format!("{file}: {statement}\n    found {found:?}"));
            }
        }
    }
    let total: usize = applied.values().sum();
    let operations = applied.len();
    say(&format!(
        "ITF1788: {total} vectors of {operations} operations in {} files",
        names.len()
    ));
    for (reason, why) in DIFFERENT {
        let count = skipped.get(reason).copied().unwrap_or(0);
        say(&format!("  {count} vectors left out ({reason}): {why}"));
    }
    say(&format!(
        "  operations that do not exist here, with their vectors: {missing:?}"
    ));
    assert!(
        failures.is_empty(),
        "{} fail:\n{}",
        failures.len(),
        failures.join("\n")
    );
    assert!(total > 2500, "only {total} vectors were read");
}
