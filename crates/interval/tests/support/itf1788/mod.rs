//! The ITF1788 test vectors, and how an evaluator is held against them.
//!
//! The vectors lie outside the repository: `$VERIBOUND_SHARED/data/itf1788`, or
//! `../shared/data/itf1788` beside the checkout.

#![allow(dead_code, reason = "each test uses a part")]
#![allow(clippy::indexing_slicing, reason = "a test fails by panicking")]

pub mod operations;
pub mod reader;

use std::collections::BTreeMap;
use std::io::Write;

use operations::Operation;
use reader::{Item, LEFT_OUT};

/// Vectors whose expected interval is not the tight one, so that a result may lie inside it.
///
/// - `2^(1074/7)` lies above `0x1.588cea3f093bdp+153`, the next float.
/// - `log2 [2, inf] / log2 [0.25, 0.5] = [1, inf] / [-2, -1]` ends at -0.5; the base 1 adds nothing.
const NOT_TIGHT: [&str; 6] = [
    "pownRev [0X0P+0,0X0.0000000000001P-1022] -7 = [0x1.588cea3f093bcp+153,infinity]",
    "pownRev [-0X0.0000000000001P-1022,-0X0P+0] -7 = [-infinity,-0x1.588cea3f093bcp+153]",
    "pownRev [0X0P+0,0X0.0000000000001P-1022]_def -7 = [0x1.588cea3f093bcp+153,infinity]_trv",
    "pownRev [-0X0.0000000000001P-1022,-0X0P+0]_def -7 = [-infinity,-0x1.588cea3f093bcp+153]_trv",
    "powRev2 [0.25, 0.5] [2.0, infinity] [entire] = [entire]",
    "powRev2 [0.25, 1.0] [2.0, infinity] [entire] = [-infinity, 0.0]",
];

/// A way to evaluate operations: the scalar functions, or a lane path.
pub trait Evaluator {
    /// The results of an operation; `None` where the evaluator does not have it.
    fn apply(&self, operation: &Operation, arguments: &[Item]) -> Option<Vec<Item>>;

    /// By how many floats an end may be further out than the tight one.
    fn floats(&self, operation: &Operation) -> u32 {
        operation.floats
    }
}

/// The functions of [`veribound_interval::Interval`].
pub struct Scalar;

impl Evaluator for Scalar {
    fn apply(&self, operation: &Operation, arguments: &[Item]) -> Option<Vec<Item>> {
        operation.apply(arguments)
    }
}

/// What became of the vectors.
#[derive(Default)]
pub struct Tally {
    /// Vectors applied, by operation.
    pub applied: BTreeMap<String, usize>,
    /// Vectors of operations that the evaluator does not have.
    pub missing: BTreeMap<String, usize>,
    /// Vectors left out, by reason.
    pub left_out: BTreeMap<&'static str, usize>,
    /// Vectors whose result is not near enough.
    pub failures: Vec<String>,
}

impl Tally {
    pub fn total(counts: &BTreeMap<String, usize>) -> usize {
        counts.values().sum()
    }

    /// Prints the numbers, past the capture of the test program.
    pub fn say(&self, who: &str) {
        say(&format!(
            "ITF1788, {who}: {} vectors of {} operations",
            Tally::total(&self.applied),
            self.applied.len()
        ));
        for (reason, why) in LEFT_OUT {
            let count = self.left_out.get(reason).copied().unwrap_or(0);
            say(&format!("  {count} vectors left out ({reason}): {why}"));
        }
        say(&format!(
            "  operations without an answer: {:?}",
            self.missing
        ));
    }
}

/// Writes past the capture of the test program, which hides the output of tests that pass.
pub fn say(line: &str) {
    std::io::stderr()
        .write_all(format!("{line}\n").as_bytes())
        .unwrap();
}

/// Holds an evaluator against all vectors; `None`, with a word on the terminal, where there are none.
pub fn hold(evaluator: &dyn Evaluator) -> Option<Tally> {
    let Some(vectors) = reader::vectors() else {
        say(&format!(
            "SKIPPED: no ITF1788 vectors in {}; set VERIBOUND_SHARED",
            reader::folder().display()
        ));
        return None;
    };
    let mut tally = Tally::default();
    for vector in vectors {
        let vector = match vector {
            Ok(vector) => vector,
            Err((reason, _)) => {
                *tally.left_out.entry(reason).or_default() += 1;
                continue;
            }
        };
        let known = Operation::named(&vector.operation);
        let found = known.and_then(|operation| {
            let found = evaluator.apply(operation, &vector.arguments)?;
            Some((found, evaluator.floats(operation)))
        });
        let Some((found, floats)) = found else {
            *tally.missing.entry(vector.operation).or_default() += 1;
            continue;
        };
        *tally.applied.entry(vector.operation).or_default() += 1;
        let may_be_inside = NOT_TIGHT.contains(&vector.text.as_str());
        let agree = found.len() == vector.results.len()
            && found.iter().zip(&vector.results).all(|(found, expected)| {
                agrees(found, expected, floats) || (may_be_inside && inside(found, expected))
            });
        if !agree {
            tally.failures.push(format!(
                "{}: {}\n    found {found:?}",
                vector.file, vector.text
            ));
        }
    }
    Some(tally)
}

/// A set has to contain the expected one, be empty where it is, and have ends that are not too far out;
/// anything else has to be equal.
fn agrees(found: &Item, expected: &Item, floats: u32) -> bool {
    let (Item::Set(found, _), Item::Set(expected, _)) = (found, expected) else {
        return found == expected;
    };
    let (mut lo, mut hi) = (expected.lo(), expected.hi());
    for _ in 0..floats {
        (lo, hi) = (lo.next_down(), hi.next_up());
    }
    found.is_empty() == expected.is_empty()
        && expected.is_subset_of(*found)
        && (found.is_empty() || (found.lo() >= lo && found.hi() <= hi))
}

fn inside(found: &Item, expected: &Item) -> bool {
    match (found, expected) {
        (Item::Set(found, _), Item::Set(expected, _)) => {
            !found.is_empty() && found.is_subset_of(*expected)
        }
        _ => false,
    }
}
