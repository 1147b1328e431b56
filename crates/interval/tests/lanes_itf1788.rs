//! The ITF1788 test vectors on every path of the lanes.
//!
//! A vector's arguments stand in one lane; the other lanes hold arguments of vectors before it.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "support/itf1788/mod.rs"]
mod itf1788;

use std::cell::{Cell, RefCell};

use itf1788::operations::Operation;
use itf1788::reader::Item;
use itf1788::{Evaluator, Tally, hold};
use veribound_interval::lanes::{Arithmetic, Kernel, LANES, Mask, Path, Value};
use veribound_interval::{Interval, Interval8};

/// An operation of the vectors on one path.
struct Call<'a> {
    name: &'a str,
    a: &'a Interval8,
    b: &'a Interval8,
}

enum Answer {
    Sets(Interval8),
    Claims(Mask),
}

impl Kernel<Interval8> for Call<'_> {
    type Output = Option<Answer>;

    #[inline(always)]
    fn run<A: Arithmetic<Value = Interval8>>(self) -> Option<Answer> {
        let Call { name, a, b } = self;
        let sets = match name {
            "pos" => *a,
            "neg" => A::neg(a),
            "add" => A::add(a, b),
            "sub" => A::sub(a, b),
            "mul" => A::mul(a, b),
            "div" => A::div(a, b),
            "recip" => A::div(&Interval8::splat(Interval::ONE), a),
            "sqr" => A::sqr(a),
            "sqrt" => A::sqrt(a),
            "abs" => A::abs(a),
            "min" => A::min(a, b),
            "max" => A::max(a, b),
            "exp" => A::exp(a),
            "log" => A::ln(a),
            "sin" => A::sin(a),
            "cos" => A::cos(a),
            "intersection" => A::intersect(a, b),
            "convexHull" => A::hull(a, b),
            "isEmpty" => return Some(Answer::Claims(A::is_empty(a))),
            "isCommonInterval" => return Some(Answer::Claims(a.is_bounded())),
            "subset" => return Some(Answer::Claims(a.is_subset_of(b))),
            "interior" => return Some(Answer::Claims(a.is_interior_of(b))),
            "disjoint" => return Some(Answer::Claims(!a.intersects(b))),
            _ => return None,
        };
        Some(Answer::Sets(sets))
    }
}

struct Lanes {
    path: Path,
    lane: Cell<usize>,
    arguments: RefCell<[Interval8; 2]>,
}

impl Evaluator for Lanes {
    fn apply(&self, operation: &Operation, arguments: &[Item]) -> Option<Vec<Item>> {
        let lane = (self.lane.get() + 1) % LANES;
        self.lane.set(lane);
        let mut lanes = self.arguments.borrow_mut();
        for (all, argument) in lanes.iter_mut().zip(arguments) {
            match argument {
                Item::Set(x, _) => all.set(lane, *x),
                _ => return None,
            }
        }
        let [a, b] = &*lanes;
        let name = operation.name;
        match self.path.run(Call { name, a, b })?? {
            Answer::Sets(all) => Some(vec![Item::set(all.get(lane))]),
            Answer::Claims(all) => Some(vec![Item::Claim(all.get(lane))]),
        }
    }
}

#[test]
fn vectors_of_itf1788_on_every_path() {
    for path in Path::available() {
        let empty = <Interval8 as Value>::splat(Interval::EMPTY);
        let lanes = Lanes {
            path,
            lane: Cell::new(0),
            arguments: RefCell::new([empty; 2]),
        };
        let Some(tally) = hold(&lanes) else { return };
        itf1788::say(&format!(
            "ITF1788, lanes, {}: {} vectors of {} operations",
            path.name(),
            Tally::total(&tally.applied),
            tally.applied.len()
        ));
        assert!(
            tally.failures.is_empty(),
            "{} fail:\n{}",
            tally.failures.len(),
            tally.failures.join("\n")
        );
        assert_eq!(tally.applied.len(), 23, "{:?}", tally.applied.keys());
    }
}
