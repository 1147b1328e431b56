//! Every operation, on one interval and on every path of eight, against two oracles that share nothing
//! with it and nothing with each other: exact rational numbers, and inari with MPFR.
//!
//! A result has to contain the oracle's, which is the smallest possible, and its ends may lie as many floats
//! further out as the table in `operation` says. The environment says how much is asked:
//! - `VERIBOUND_ORACLE_CASES`: random cases of every operation, beside the directed ones;
//! - `VERIBOUND_ORACLE_SEED`: draws others;
//! - `VERIBOUND_ORACLE_ONLY`: operations, separated by commas (name the test to run, too);
//! - `VERIBOUND_PEERS`: the folder of the peers (`peers/build`); without it inari is SKIPPED.
//!
//! Usually 2.7 million cases by rational numbers and 7.2 million by inari and MPFR; `./nightly` asks 37 and 128
//! million. A case is one operation on one set of arguments, and every path is judged on it.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod contest;
mod draw;
mod exact;
mod operation;
mod peers;
mod subject;
#[path = "../support/mod.rs"]
mod support;

use contest::{Oracle, Subject, contest, say, subjects};
use operation::{OPERATIONS, Operation};
use peers::Peers;
use subject::batch;
use veribound_interval::{Interval, self_test};

/// Random cases of every operation, where the environment does not say.
const USUAL: usize = 20_000;

/// What rational numbers have to judge.
const BASIC: [&str; 9] = [
    "neg", "add", "sub", "mul", "div", "sqr", "sqrt", "recip", "powi",
];

fn cases() -> usize {
    contest::number("VERIBOUND_ORACLE_CASES").map_or(USUAL, |number| number as usize)
}

#[test]
fn exact_rational_numbers_agree() {
    let oracle = Oracle {
        name: "exact rationals",
        evaluate: &|operation, columns| exact::evaluate(operation.name, columns),
    };
    contest(&oracle, cases(), &subjects).assert_none();
}

#[test]
fn inari_and_mpfr_agree() {
    let Some(peers) = peers() else { return };
    let oracle = Oracle {
        name: "inari and MPFR",
        evaluate: &|operation, columns| peers.evaluate(operation.peer, columns),
    };
    contest(&oracle, cases(), &subjects).assert_none();
    self_test().expect("the library left the arithmetic as it was");
}

/// The oracles judge one another: rational numbers against inari, with none of our floats between them.
#[test]
fn oracles_agree() {
    let Some(peers) = peers() else { return };
    let oracle = Oracle {
        name: "one another",
        evaluate: &|operation, columns| peers.evaluate(operation.peer, columns),
    };
    let exact = |operation: &'static Operation| {
        let subject = Subject {
            path: "exact rationals".to_owned(),
            slack: 0,
            evaluate: Box::new(|columns| exact::evaluate(operation.name, columns).unwrap()),
        };
        let none = vec![Vec::new(); operation.arity()];
        let known = exact::evaluate(operation.name, &none).is_some();
        known.then_some(subject).into_iter().collect()
    };
    contest(&oracle, cases() / 10, &exact).assert_none();
}

/// No operation of the table is left out because nobody has it.
#[test]
fn every_operation_is_judged() {
    let peers = peers();
    let mut waiting = Vec::new();
    for operation in OPERATIONS {
        let none = vec![Vec::new(); operation.arity()];
        let name = operation.name;
        assert!(subject::scalar(name).is_some(), "no scalar {name}");
        if exact::evaluate(name, &none).is_some() {
            continue;
        }
        // Rational numbers have all that everything else is made of, also where inari is missing.
        assert!(!BASIC.contains(&name), "rational numbers lack {name}");
        match &peers {
            Some(peers) => {
                let judged = peers.evaluate(operation.peer, &none).is_some();
                assert!(judged, "no oracle has {name}");
            }
            None => waiting.push(name),
        }
    }
    if !waiting.is_empty() {
        let count = waiting.len();
        say(&format!(
            "SKIPPED: {count} operations that only inari and MPFR judge: {}",
            waiting.join(" ")
        ));
    }
}

/// The contest itself bites: sums rounded to nearest, squares without the case of zero inside, ends one
/// float further out than allowed.
#[test]
fn broken_operations_are_caught() {
    let violations = |name: &'static str, slack: u32, f: subject::Batch| {
        let oracle = Oracle {
            name: "exact rationals, on purpose",
            evaluate: &|operation, columns| exact::evaluate(operation.name, columns),
        };
        let broken = |operation: &'static Operation| -> Vec<Subject> {
            let subject = Subject {
                path: "broken".to_owned(),
                slack,
                evaluate: Box::new(move |columns| {
                    let mut results = vec![Interval::ENTIRE; columns[0].len()];
                    f(columns, &mut results);
                    results
                }),
            };
            let wanted = operation.name == name;
            wanted.then_some(subject).into_iter().collect()
        };
        contest(&oracle, 500, &broken).violations
    };
    let nearest: subject::Batch = batch!(|x, y| {
        let ends = (x.lo() + y.lo(), x.hi() + y.hi());
        Interval::new(ends.0, ends.1).unwrap_or(x + y)
    });
    let wide: subject::Batch = batch!(|x, y| outward(x * y));
    assert!(violations("add", 0, nearest) > 100);
    assert!(violations("sqr", 0, batch!(|x| x * x)) > 10);
    assert!(violations("mul", 0, wide) > 100);
    assert_eq!(violations("mul", 1, wide), 0);
}

fn outward(x: Interval) -> Interval {
    Interval::new(x.lo().next_down(), x.hi().next_up()).unwrap_or(x)
}

fn peers() -> Option<Peers> {
    match Peers::load("haswell") {
        Ok(Some(peers)) => Some(peers),
        Ok(None) => {
            say(
                "SKIPPED: inari and MPFR as an oracle; run peers/build and set VERIBOUND_PEERS to its folder",
            );
            None
        }
        Err(error) => panic!("{error}"),
    }
}
