//! The ITF1788 test vectors for interval arithmetic, read from the shared data folder.
//!
//! Operations that are tight here must give equal intervals. The others must contain the expected
//! interval and may be wider by the few floats of the table of operations. Where the vectors are absent the
//! test says so and checks nothing.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

#[path = "support/itf1788/mod.rs"]
mod itf1788;

use std::collections::BTreeMap;

use itf1788::operations::{NOT_HERE, OPERATIONS, Operation};
use itf1788::reader::{Decoration, Item, vectors};
use itf1788::{Scalar, Tally, hold, say};
use veribound_interval::Regularity;

#[test]
fn vectors_of_itf1788() {
    let Some(tally) = hold(&Scalar) else { return };
    tally.say("scalar functions");
    assert!(
        tally.failures.is_empty(),
        "{} fail:\n{}",
        tally.failures.len(),
        tally.failures.join("\n")
    );
    // Every operation of the table has vectors, and what has no function is listed with its reason.
    for operation in OPERATIONS {
        assert!(
            tally.applied.contains_key(operation.name),
            "no vector of {}",
            operation.name
        );
    }
    for (reason, names) in NOT_HERE {
        let count: usize = names
            .iter()
            .map(|name| tally.missing.get(*name).unwrap_or(&0))
            .sum();
        say(&format!("  {count} vectors of {names:?}: {reason}"));
    }
    let listed = |name: &String| {
        NOT_HERE
            .iter()
            .any(|(_, names)| names.contains(&name.as_str()))
    };
    assert!(tally.missing.keys().all(listed), "{:?}", tally.missing);
    assert_eq!(
        (
            Tally::total(&tally.applied),
            Tally::total(&tally.missing),
            tally.left_out.values().sum::<usize>(),
        ),
        (8910, 492, 140)
    );
}

/// The decorations of the vectors are an independent opinion on [`veribound_interval::domain`].
#[test]
fn decorations_of_itf1788() {
    let Some(vectors) = vectors() else { return };
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for vector in vectors.into_iter().flatten() {
        let decorations: Option<Vec<Decoration>> = vector
            .arguments
            .iter()
            .filter_map(|argument| match argument {
                Item::Set(_, decoration) => Some(*decoration),
                _ => None,
            })
            .collect();
        let (Some(given), Some(&Item::Set(_, Some(result)))) =
            (decorations, vector.results.first())
        else {
            continue;
        };
        let Some(operation) = Operation::named(&vector.operation) else {
            continue;
        };
        let Some(found) = operation.regularity(&vector.arguments) else {
            continue;
        };
        // The result's decoration is the worst of the arguments' and the operation's own.
        let worst = given.into_iter().min().unwrap_or(Decoration::Com);
        let agree = match result {
            _ if result == worst && worst < Decoration::Dac => {
                found
                    >= [Regularity::Undefined, Regularity::Jump]
                        [usize::from(result == Decoration::Def)]
            }
            Decoration::Trv => found == Regularity::Undefined,
            Decoration::Def => found == Regularity::Jump,
            Decoration::Dac | Decoration::Com => found >= Regularity::Kink,
        };
        assert!(agree, "{}: {}: {found:?}", vector.file, vector.text);
        *counts.entry(operation.name).or_default() += 1;
    }
    say(&format!(
        "ITF1788: {} decorated vectors of {} operations agree with the domains",
        counts.values().sum::<usize>(),
        counts.len()
    ));
    assert!(counts.len() >= 40, "{counts:?}");
}
