//! The operations of the vectors by name: how they are called, how near to the tight result they have
//! to be, and how regular they are said to be.

use veribound_interval::{Interval, Overlap, Regularity, domain};

use super::reader::Item;

/// How an operation is called.
#[derive(Clone, Copy)]
pub enum Call {
    One(fn(Interval) -> Interval),
    Two(fn(Interval, Interval) -> Interval),
    Three(fn(Interval, Interval, Interval) -> Interval),
    /// Of an interval and a whole number.
    Whole(fn(Interval, i32) -> Interval),
    /// Of two intervals and a whole number.
    TwoWhole(fn(Interval, Interval, i32) -> Interval),
    TwoResults(fn(Interval, Interval) -> (Interval, Interval)),
    Number(fn(Interval) -> f64),
    TwoNumbers(fn(Interval) -> (f64, f64)),
    Claim(fn(Interval) -> bool),
    Relation(fn(Interval, Interval) -> bool),
    Member(fn(Interval, f64) -> bool),
    Lying(fn(Interval, Interval) -> Overlap),
    Numbers(fn(f64, f64) -> Option<Interval>),
    Text(fn(&str) -> Option<Interval>),
}

/// How regular an operation is, by its arguments.
#[derive(Clone, Copy)]
pub enum Rule {
    /// Not a point operation.
    None,
    Everywhere,
    One(fn(Interval) -> Regularity),
    Two(fn(Interval, Interval) -> Regularity),
    Whole(fn(Interval, i32) -> Regularity),
}

/// An operation of the vectors.
pub struct Operation {
    pub name: &'static str,
    pub call: Call,
    /// Each end is at most so many floats further out than the tight one.
    pub floats: u32,
    pub rule: Rule,
}

const fn operation(name: &'static str, call: Call, floats: u32, rule: Rule) -> Operation {
    Operation {
        name,
        call,
        floats,
        rule,
    }
}

const ALL: Interval = Interval::ENTIRE;

/// Every operation of the vectors that exists here.
#[rustfmt::skip]
pub const OPERATIONS: &[Operation] = &[
    operation("pos", Call::One(|x| x), 0, Rule::Everywhere),
    operation("neg", Call::One(|x| -x), 0, Rule::Everywhere),
    operation("add", Call::Two(|x, y| x + y), 0, Rule::Everywhere),
    operation("sub", Call::Two(|x, y| x - y), 0, Rule::Everywhere),
    operation("mul", Call::Two(|x, y| x * y), 0, Rule::Everywhere),
    operation("div", Call::Two(|x, y| x / y), 0, Rule::Two(domain::div)),
    operation("fma", Call::Three(Interval::fma), 0, Rule::Everywhere),
    operation("recip", Call::One(Interval::recip), 0, Rule::One(domain::recip)),
    operation("sqr", Call::One(Interval::sqr), 0, Rule::Everywhere),
    operation("sqrt", Call::One(Interval::sqrt), 0, Rule::One(domain::sqrt)),
    operation("cbrt", Call::One(|x| x.rootn(3)), 0, Rule::One(|x| domain::rootn(x, 3))),
    operation("rootn", Call::Whole(Interval::rootn), 0, Rule::Whole(domain::rootn)),
    operation("pown", Call::Whole(Interval::powi), 0, Rule::Whole(domain::powi)),
    operation("pow", Call::Two(Interval::pow), 1, Rule::Two(domain::pow)),
    operation("exp", Call::One(Interval::exp), 1, Rule::Everywhere),
    operation("exp2", Call::One(Interval::exp2), 1, Rule::Everywhere),
    operation("exp10", Call::One(Interval::exp10), 1, Rule::Everywhere),
    operation("expm1", Call::One(Interval::expm1), 1, Rule::Everywhere),
    operation("log", Call::One(Interval::ln), 1, Rule::One(domain::ln)),
    operation("log2", Call::One(Interval::log2), 1, Rule::One(domain::ln)),
    operation("log10", Call::One(Interval::log10), 1, Rule::One(domain::ln)),
    operation("logp1", Call::One(Interval::log1p), 1, Rule::One(domain::log1p)),
    operation("sin", Call::One(Interval::sin), 1, Rule::Everywhere),
    operation("cos", Call::One(Interval::cos), 1, Rule::Everywhere),
    operation("tan", Call::One(Interval::tan), 1, Rule::One(domain::tan)),
    operation("asin", Call::One(Interval::asin), 1, Rule::One(domain::asin)),
    operation("acos", Call::One(Interval::acos), 1, Rule::One(domain::acos)),
    operation("atan", Call::One(Interval::atan), 1, Rule::Everywhere),
    operation("atan2", Call::Two(Interval::atan2), 1, Rule::Two(domain::atan2)),
    operation("sinh", Call::One(Interval::sinh), 1, Rule::Everywhere),
    operation("cosh", Call::One(Interval::cosh), 1, Rule::Everywhere),
    operation("tanh", Call::One(Interval::tanh), 1, Rule::Everywhere),
    operation("asinh", Call::One(Interval::asinh), 1, Rule::Everywhere),
    operation("acosh", Call::One(Interval::acosh), 1, Rule::One(domain::acosh)),
    operation("atanh", Call::One(Interval::atanh), 1, Rule::One(domain::atanh)),
    operation("abs", Call::One(Interval::abs), 0, Rule::One(domain::abs)),
    operation("min", Call::Two(Interval::min), 0, Rule::Two(domain::min)),
    operation("max", Call::Two(Interval::max), 0, Rule::Two(domain::max)),
    operation("sign", Call::One(Interval::sign_with_zero), 0, Rule::One(domain::sign_with_zero)),
    operation("floor", Call::One(Interval::floor), 0, Rule::One(domain::floor)),
    operation("ceil", Call::One(Interval::ceil), 0, Rule::One(domain::ceil)),
    operation("trunc", Call::One(Interval::trunc), 0, Rule::One(domain::trunc)),
    operation("roundTiesToEven", Call::One(Interval::round_ties_to_even), 0, Rule::One(domain::round_ties_to_even)),
    operation("roundTiesToAway", Call::One(Interval::round_ties_to_away), 0, Rule::One(domain::round_ties_to_away)),
    operation("intersection", Call::Two(Interval::intersect), 0, Rule::None),
    operation("convexHull", Call::Two(Interval::hull), 0, Rule::None),
    operation("cancelMinus", Call::Two(Interval::cancel_minus), 0, Rule::None),
    operation("cancelPlus", Call::Two(Interval::cancel_plus), 0, Rule::None),
    operation("mid", Call::Number(Interval::mid), 0, Rule::None),
    operation("rad", Call::Number(Interval::rad), 0, Rule::None),
    operation("midRad", Call::TwoNumbers(Interval::mid_rad), 0, Rule::None),
    operation("wid", Call::Number(Interval::width), 0, Rule::None),
    operation("mag", Call::Number(Interval::mag), 0, Rule::None),
    operation("mig", Call::Number(Interval::mig), 0, Rule::None),
    operation("inf", Call::Number(Interval::lo), 0, Rule::None),
    operation("sup", Call::Number(Interval::hi), 0, Rule::None),
    operation("isEmpty", Call::Claim(Interval::is_empty), 0, Rule::None),
    operation("isEntire", Call::Claim(Interval::is_entire), 0, Rule::None),
    operation("isSingleton", Call::Claim(Interval::is_point), 0, Rule::None),
    operation("isCommonInterval", Call::Claim(Interval::is_bounded), 0, Rule::None),
    operation("isMember", Call::Member(Interval::contains), 0, Rule::None),
    operation("equal", Call::Relation(|x, y| x == y), 0, Rule::None),
    operation("subset", Call::Relation(Interval::is_subset_of), 0, Rule::None),
    operation("interior", Call::Relation(Interval::is_interior_of), 0, Rule::None),
    operation("disjoint", Call::Relation(Interval::is_disjoint_from), 0, Rule::None),
    operation("less", Call::Relation(Interval::is_weakly_less), 0, Rule::None),
    operation("strictLess", Call::Relation(Interval::is_strictly_less), 0, Rule::None),
    operation("precedes", Call::Relation(Interval::precedes), 0, Rule::None),
    operation("strictPrecedes", Call::Relation(Interval::strictly_precedes), 0, Rule::None),
    operation("overlap", Call::Lying(Interval::overlap), 0, Rule::None),
    operation("sqrRev", Call::One(|c| Interval::sqr_rev(c, ALL)), 0, Rule::None),
    operation("sqrRevBin", Call::Two(Interval::sqr_rev), 0, Rule::None),
    operation("absRev", Call::One(|c| Interval::abs_rev(c, ALL)), 0, Rule::None),
    operation("absRevBin", Call::Two(Interval::abs_rev), 0, Rule::None),
    operation("pownRev", Call::Whole(|c, n| Interval::powi_rev(n, c, ALL)), 0, Rule::None),
    operation("pownRevBin", Call::TwoWhole(|c, x, n| Interval::powi_rev(n, c, x)), 0, Rule::None),
    operation("sinRev", Call::One(|c| Interval::sin_rev(c, ALL)), 0, Rule::None),
    operation("sinRevBin", Call::Two(Interval::sin_rev), 3, Rule::None),
    operation("cosRev", Call::One(|c| Interval::cos_rev(c, ALL)), 0, Rule::None),
    operation("cosRevBin", Call::Two(Interval::cos_rev), 3, Rule::None),
    operation("tanRev", Call::One(|c| Interval::tan_rev(c, ALL)), 0, Rule::None),
    operation("tanRevBin", Call::Two(Interval::tan_rev), 3, Rule::None),
    operation("coshRev", Call::One(|c| Interval::cosh_rev(c, ALL)), 1, Rule::None),
    operation("coshRevBin", Call::Two(Interval::cosh_rev), 1, Rule::None),
    operation("mulRev", Call::Two(|b, c| Interval::mul_rev(b, c, ALL)), 0, Rule::None),
    operation("mulRevTen", Call::Three(Interval::mul_rev), 0, Rule::None),
    operation("mulRevToPair", Call::TwoResults(Interval::mul_rev_to_pair), 0, Rule::None),
    operation("powRev1", Call::Three(Interval::pow_rev1), 1, Rule::None),
    operation("powRev2", Call::Three(Interval::pow_rev2), 3, Rule::None),
    operation("b-numsToInterval", Call::Numbers(Interval::new), 0, Rule::None),
    operation("d-numsToInterval", Call::Numbers(Interval::new), 0, Rule::None),
    operation("b-textToInterval", Call::Text(|text| text.parse().ok()), 0, Rule::None),
    operation("d-textToInterval", Call::Text(|text| text.parse().ok()), 0, Rule::None),
];

/// Operations of the vectors that do not exist here, and why.
pub const NOT_HERE: &[(&str, &[&str])] = &[
    (
        "not asked for by IEEE 1788.1; the language of models has no use for them",
        &[
            "sec", "csc", "cot", "acot", "sech", "csch", "coth", "acoth", "hypot",
        ],
    ),
    (
        "there are no decorated intervals; `domain` answers for the operations instead",
        &[
            "newDec",
            "setDec",
            "decorationPart",
            "intervalPart",
            "isNaI",
        ],
    ),
    (
        "reductions of float vectors, no interval operations",
        &[
            "sum_nearest",
            "sum_abs_nearest",
            "sum_sqr_nearest",
            "dot_nearest",
        ],
    ),
];

impl Operation {
    pub fn named(name: &str) -> Option<&'static Operation> {
        OPERATIONS.iter().find(|operation| operation.name == name)
    }

    /// The results; `None` where the arguments are of the wrong kind.
    pub fn apply(&self, arguments: &[Item]) -> Option<Vec<Item>> {
        use Item::{Number, Set, Text};
        let one = |x: Interval| Some(vec![Item::set(x)]);
        let made = |x: Option<Interval>| Some(vec![x.map_or(Item::Refused, Item::set)]);
        match (self.call, arguments) {
            (Call::One(f), [Set(x, _)]) => one(f(*x)),
            (Call::Two(f), [Set(x, _), Set(y, _)]) => one(f(*x, *y)),
            (Call::Three(f), [Set(x, _), Set(y, _), Set(z, _)]) => one(f(*x, *y, *z)),
            (Call::Whole(f), [Set(x, _), Number(n)]) => one(f(*x, *n as i32)),
            (Call::TwoWhole(f), [Set(x, _), Set(y, _), Number(n)]) => one(f(*x, *y, *n as i32)),
            (Call::TwoResults(f), [Set(x, _), Set(y, _)]) => {
                let (first, second) = f(*x, *y);
                Some(vec![Item::set(first), Item::set(second)])
            }
            (Call::Number(f), [Set(x, _)]) => Some(vec![Number(f(*x))]),
            (Call::TwoNumbers(f), [Set(x, _)]) => {
                let (first, second) = f(*x);
                Some(vec![Number(first), Number(second)])
            }
            (Call::Claim(f), [Set(x, _)]) => Some(vec![Item::Claim(f(*x))]),
            (Call::Relation(f), [Set(x, _), Set(y, _)]) => Some(vec![Item::Claim(f(*x, *y))]),
            (Call::Member(f), [Number(m), Set(x, _)]) => Some(vec![Item::Claim(f(*x, *m))]),
            (Call::Lying(f), [Set(x, _), Set(y, _)]) => {
                // `ContainedBy` here is `containedBy` there.
                let name = format!("{:?}", f(*x, *y));
                let (first, rest) = name.split_at(1);
                Some(vec![Item::Word(first.to_lowercase() + rest)])
            }
            (Call::Numbers(f), [Number(lo), Number(hi)]) => made(f(*lo, *hi)),
            (Call::Text(f), [Text(text)]) => made(f(text)),
            _ => None,
        }
    }

    /// How regular the operation is said to be on these arguments.
    pub fn regularity(&self, arguments: &[Item]) -> Option<Regularity> {
        use Item::{Number, Set};
        match (self.rule, arguments) {
            (Rule::Everywhere, [Set(x, _)]) => Some(domain::everywhere([*x])),
            (Rule::Everywhere, [Set(x, _), Set(y, _)]) => Some(domain::everywhere([*x, *y])),
            (Rule::Everywhere, [Set(x, _), Set(y, _), Set(z, _)]) => {
                Some(domain::everywhere([*x, *y, *z]))
            }
            (Rule::One(f), [Set(x, _)]) => Some(f(*x)),
            (Rule::Two(f), [Set(x, _), Set(y, _)]) => Some(f(*x, *y)),
            (Rule::Whole(f), [Set(x, _), Number(n)]) => Some(f(*x, *n as i32)),
            _ => None,
        }
    }
}
