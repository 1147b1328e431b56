//! The ITF1788 test vectors on every path of the lanes.
//!
//! A vector's arguments stand in one lane; the other lanes hold arguments of vectors before it.

#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

#[path = "support/itf1788/mod.rs"]
mod itf1788;

use std::cell::{Cell, RefCell};

use itf1788::operations::{OPERATIONS, Operation};
use itf1788::reader::Item;
use itf1788::{Evaluator, Tally, hold};
use veribound_interval::lanes::{Arithmetic, Floats, Kernel, LANES, Mask, Path, Value};
use veribound_interval::{Interval, Interval8};

/// An operation of the vectors on one path.
struct Call<'a> {
    name: &'a str,
    a: &'a Interval8,
    b: &'a Interval8,
    degree: i32,
}

enum Answer {
    Sets(Interval8),
    Claims(Mask),
    Numbers(Floats),
}

/// Operations of the scalar functions that lanes do not have, and why.
const NOT_ON_LANES: &[(&str, &[&str])] = &[
    (
        "rare in models: a kernel does them one by one (`Arithmetic::map` and its like)",
        &[
            "fma",
            "cbrt",
            "rootn",
            "pow",
            "exp2",
            "exp10",
            "expm1",
            "log2",
            "log10",
            "logp1",
            "asin",
            "acos",
            "atan2",
            "sinh",
            "cosh",
            "asinh",
            "acosh",
            "atanh",
            "floor",
            "ceil",
            "trunc",
            "roundTiesToEven",
            "roundTiesToAway",
        ],
    ),
    ("on lanes it is the set-valued sign", &["sign"]),
    (
        "reverse operations, asked for one box at a time",
        &[
            "cancelMinus",
            "cancelPlus",
            "sqrRev",
            "sqrRevBin",
            "absRev",
            "absRevBin",
            "pownRev",
            "pownRevBin",
            "sinRev",
            "sinRevBin",
            "cosRev",
            "cosRevBin",
            "tanRev",
            "tanRevBin",
            "coshRev",
            "coshRevBin",
            "mulRev",
            "mulRevTen",
            "mulRevToPair",
            "powRev1",
            "powRev2",
        ],
    ),
    (
        "numbers and questions that no loop over eight asks",
        &[
            "rad",
            "midRad",
            "mig",
            "isEntire",
            "isSingleton",
            "isMember",
            "equal",
            "less",
            "strictLess",
            "precedes",
            "strictPrecedes",
            "overlap",
        ],
    ),
    (
        "construction of one interval",
        &[
            "b-numsToInterval",
            "d-numsToInterval",
            "b-textToInterval",
            "d-textToInterval",
        ],
    ),
];

impl Kernel<Interval8> for Call<'_> {
    type Output = Option<Answer>;

    #[inline(always)]
    fn run<A: Arithmetic<Value = Interval8>>(self) -> Option<Answer> {
        let Call { name, a, b, degree } = self;
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
            "pown" => A::powi(a, degree),
            "abs" => A::abs(a),
            "min" => A::min(a, b),
            "max" => A::max(a, b),
            "exp" => A::exp(a),
            "log" => A::ln(a),
            "sin" => A::sin(a),
            "cos" => A::cos(a),
            "tan" => A::tan(a),
            "atan" => A::atan(a),
            "tanh" => A::tanh(a),
            "intersection" => A::intersect(a, b),
            "convexHull" => A::hull(a, b),
            "isEmpty" => return Some(Answer::Claims(A::is_empty(a))),
            "isCommonInterval" => return Some(Answer::Claims(a.is_bounded())),
            "subset" => return Some(Answer::Claims(a.is_subset_of(b))),
            "interior" => return Some(Answer::Claims(a.is_interior_of(b))),
            "disjoint" => return Some(Answer::Claims(!a.intersects(b))),
            "inf" => return Some(Answer::Numbers(a.lo())),
            "sup" => return Some(Answer::Numbers(a.hi())),
            "mid" => return Some(Answer::Numbers(a.mid())),
            "wid" => return Some(Answer::Numbers(a.width())),
            "mag" => return Some(Answer::Numbers(a.mag())),
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
        let mut degree = 0;
        for (all, argument) in lanes.iter_mut().zip(arguments) {
            match argument {
                Item::Set(x, _) => all.set(lane, *x),
                Item::Number(n) => degree = *n as i32,
                _ => return None,
            }
        }
        let [a, b] = &*lanes;
        let name = operation.name;
        let call = Call { name, a, b, degree };
        let found = match self.path.run(call)?? {
            Answer::Sets(all) => Item::set(all.get(lane)),
            Answer::Claims(all) => Item::Claim(all.get(lane)),
            Answer::Numbers(all) => Item::Number(all[lane]),
        };
        Some(vec![found])
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
        // Every operation of the scalar functions is here, or listed with its reason.
        for operation in OPERATIONS {
            let name = operation.name;
            let lacks = NOT_ON_LANES.iter().any(|(_, names)| names.contains(&name));
            let applied = tally.applied.contains_key(name);
            assert!(
                applied != lacks,
                "{name}: applied {applied}, listed {lacks}"
            );
        }
        let listed = NOT_ON_LANES.iter().flat_map(|(_, names)| names.iter());
        assert_eq!(
            tally.applied.len(),
            OPERATIONS.len() - listed.count(),
            "{:?}",
            tally.applied.keys()
        );
    }
}
