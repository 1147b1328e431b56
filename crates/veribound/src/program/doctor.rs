//! `veribound doctor`: whether this program proves what it says on this machine.

use super::arguments::Doctor;
use super::ending::Ending;
use super::message::{say, say_json};
use super::{Outcome, arithmetic};
use serde::Serialize;
use std::fmt::Write as _;
use std::thread::available_parallelism;
use veribound_interval::lanes::Path;
use veribound_interval::{Decimal, Interval};

/// A value to 40 digits, and what gives it.
type Known = (&'static str, &'static str, fn() -> Interval);

fn number(text: &str) -> Interval {
    Decimal::parse(text).map_or(Interval::EMPTY, |decimal| decimal.to_interval())
}

/// Constants as tables of mathematics have them (DLMF), cut after 40 digits.
const KNOWN: [Known; 9] = [
    ("0.1 + 0.2", "0.3", || number("0.1") + number("0.2")),
    (
        "1 / 3",
        "0.3333333333333333333333333333333333333333",
        || number("1") / number("3"),
    ),
    (
        "sqrt 2",
        "1.4142135623730950488016887242096980785696",
        || number("2").sqrt(),
    ),
    (
        "exp 1",
        "2.7182818284590452353602874713526624977572",
        || number("1").exp(),
    ),
    (
        "log 2",
        "0.6931471805599453094172321214581765680755",
        || number("2").ln(),
    ),
    (
        "sin 1",
        "0.8414709848078965066525023216302989996225",
        || number("1").sin(),
    ),
    (
        "cos 1",
        "0.5403023058681397174009366074429766037323",
        || number("1").cos(),
    ),
    (
        "atan 1",
        "0.7853981633974483096156608458198757210492",
        || number("1").atan(),
    ),
    (
        "tanh 1",
        "0.7615941559557648881194582826047935904127",
        || number("1").tanh(),
    ),
];

/// A result may be wider than the best one, and not more than by this share.
const WIDEST: f64 = 1e-15;

/// What is told.
#[derive(Serialize)]
struct Findings {
    version: &'static str,
    system: &'static str,
    processor: &'static str,
    threads: usize,
    /// The instructions that eight intervals are computed with, and all that this processor has.
    lanes: &'static str,
    lanes_available: Vec<&'static str>,
    checks: Vec<Check>,
    healthy: bool,
}

#[derive(Serialize)]
struct Check {
    name: String,
    passed: bool,
    /// What was found, where it did not pass.
    #[serde(skip_serializing_if = "Option::is_none")]
    found: Option<String>,
}

/// Looks, and tells.
pub fn run(arguments: &Doctor) -> Outcome {
    let trusted = arithmetic();
    let mut checks = vec![Check {
        name: "rounding to nearest, subnormal numbers, elementary functions".to_owned(),
        passed: trusted.is_ok(),
        found: { trusted.as_ref().err() }.map(|problems| {
            let first = problems.0.first();
            first.map_or_else(String::new, |problem| problem.message.clone())
        }),
    }];
    checks.extend(KNOWN.iter().map(known));
    let findings = Findings {
        version: env!("CARGO_PKG_VERSION"),
        system: std::env::consts::OS,
        processor: std::env::consts::ARCH,
        threads: available_parallelism().map_or(1, usize::from),
        lanes: Path::chosen().name(),
        lanes_available: Path::available().map(Path::name).collect(),
        healthy: checks.iter().all(|check| check.passed),
        checks,
    };
    if arguments.json {
        say_json(&findings)?;
    } else {
        say(&findings.told());
    }
    trusted?;
    Ok(if findings.healthy {
        Ending::Done
    } else {
        Ending::Misuse
    })
}

/// Whether an operation holds the known value, and not much else.
fn known((name, value, compute): &Known) -> Check {
    let (found, wanted) = (compute(), number(value));
    let passed = wanted.is_subset_of(found) && found.width() <= WIDEST * found.mag();
    Check {
        name: format!("{name} = {value}"),
        passed,
        found: (!passed).then(|| found.to_string()),
    }
}

impl Findings {
    fn told(&self) -> String {
        let mut text = format!(
            "  veribound {} on {}, {}\n  threads: {}\n  eight intervals at a time with: {} (here: {})\n",
            self.version,
            self.system,
            self.processor,
            self.threads,
            self.lanes,
            self.lanes_available.join(", "),
        );
        for check in &self.checks {
            let word = if check.passed { "ok     " } else { "FAILED " };
            let found =
                { check.found.as_ref() }.map_or_else(String::new, |found| format!(": {found}"));
            // Writing to a String cannot fail.
            let _ = writeln!(text, "  {word} {}{found}", check.name);
        }
        text.push_str(if self.healthy {
            "  all is well\n"
        } else {
            "  bounds from this machine prove nothing\n"
        });
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values_are_held_and_wrong_ones_are_not() {
        assert!(KNOWN.iter().map(known).all(|check| check.passed));
        let wrong: Known = ("sqrt 2", "1.414213562373096", || number("2").sqrt());
        assert!(!known(&wrong).passed);
        let wide: Known = ("1", "1", || number("0.9").hull(number("1.1")));
        assert!(!known(&wide).passed);
    }
}
