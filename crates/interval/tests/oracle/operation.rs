//! The operations that are judged: names, kinds of arguments, how tight the ends have to be.

/// What the numbers of an argument are like.
#[derive(Clone, Copy)]
pub enum Kind {
    /// Any float; of two such arguments, often related ones.
    Any,
    /// Where the function is not constant or undefined, with the places where it turns.
    Range(f64, f64, &'static [f64]),
    /// For functions of angles.
    Angle,
    /// One integer, the same at both ends: the degree of a power or a root.
    Degree,
    /// An exponent that keeps the power of the first argument in range.
    Exponent,
}

use Kind::{Angle, Any, Degree, Exponent, Range};

pub struct Operation {
    pub name: &'static str,
    /// Its name in the library of the peers, where that is a different one.
    pub peer: &'static str,
    pub kinds: &'static [Kind],
    /// How many floats an end may lie further out than the tight one.
    pub slack: u32,
}

impl Operation {
    pub fn arity(&self) -> usize {
        self.kinds.len()
    }
}

const fn tight(name: &'static str, kinds: &'static [Kind]) -> Operation {
    Operation {
        name,
        peer: name,
        kinds,
        slack: 0,
    }
}

const fn near(name: &'static str, kinds: &'static [Kind]) -> Operation {
    Operation {
        name,
        peer: name,
        kinds,
        slack: 1,
    }
}

const fn near_as(name: &'static str, peer: &'static str, kinds: &'static [Kind]) -> Operation {
    Operation {
        name,
        peer,
        kinds,
        slack: 1,
    }
}

const MAX: f64 = f64::MAX;
const UNIT: Kind = Range(-1.0, 1.0, &[0.0, 0.5, 1.0, -1.0]);
const POSITIVE: Kind = Range(
    0.0,
    MAX,
    &[1.0, std::f64::consts::E, 10.0, 1e22, 8.0, 1024.0],
);
const HALVES: Kind = Range(-1e16, 1e16, &[0.0, 0.5, 1.5, 2.5, 4_503_599_627_370_495.5]);
const EXPONENTS: Kind = Range(
    -746.0,
    711.0,
    &[
        0.0,
        1.0,
        709.782712893384,
        -745.1332191019412,
        -708.3964185322641,
    ],
);
const HYPERBOLIC: Kind = Range(-711.0, 711.0, &[0.0, 1.0, 710.475860073944, 22.0]);

pub const OPERATIONS: &[Operation] = &[
    tight("neg", &[Any]),
    tight("abs", &[Any]),
    tight("sign_with_zero", &[Any]),
    tight("floor", &[HALVES]),
    tight("ceil", &[HALVES]),
    tight("trunc", &[HALVES]),
    tight("round_ties_to_even", &[HALVES]),
    tight("round_ties_to_away", &[HALVES]),
    tight("mag", &[Any]),
    tight("mig", &[Any]),
    tight("width", &[Any]),
    tight("sqr", &[Any]),
    tight("sqrt", &[Any]),
    tight("recip", &[Any]),
    tight("add", &[Any, Any]),
    tight("sub", &[Any, Any]),
    tight("mul", &[Any, Any]),
    tight("div", &[Any, Any]),
    tight("fma", &[Any, Any, Any]),
    tight("min", &[Any, Any]),
    tight("max", &[Any, Any]),
    tight("cancel_minus", &[Any, Any]),
    tight("cancel_plus", &[Any, Any]),
    tight("mul_rev_to_pair.0", &[Any, Any]),
    tight("mul_rev_to_pair.1", &[Any, Any]),
    near("powi", &[Any, Degree]),
    near("rootn", &[Any, Degree]),
    near("pow", &[POSITIVE, Exponent]),
    near("exp", &[EXPONENTS]),
    near("expm1", &[EXPONENTS]),
    near(
        "exp2",
        &[Range(
            -1076.0,
            1025.0,
            &[0.0, 1.0, 10.0, 1024.0, -1022.0, -1074.0],
        )],
    ),
    near(
        "exp10",
        &[Range(
            -325.0,
            309.0,
            &[0.0, 1.0, 22.0, 308.25471555991674, -323.6],
        )],
    ),
    near("ln", &[POSITIVE]),
    near("log1p", &[Range(-1.0, MAX, &[0.0, -1.0, 1.0])]),
    near("log2", &[POSITIVE]),
    near("log10", &[POSITIVE]),
    near_as("sin", "tight sin", &[Angle]),
    near_as("cos", "tight cos", &[Angle]),
    near_as("tan", "tight tan", &[Angle]),
    near("asin", &[UNIT]),
    near("acos", &[UNIT]),
    near("atan", &[Range(-1e17, 1e17, &[0.0, 1.0, -1.0])]),
    near("atan2", &[Any, Any]),
    near("sinh", &[HYPERBOLIC]),
    near("cosh", &[HYPERBOLIC]),
    near("tanh", &[Range(-20.0, 20.0, &[0.0, 1.0, 19.06])]),
    near("asinh", &[Range(-MAX, MAX, &[0.0, 1.0])]),
    near("acosh", &[Range(1.0, MAX, &[1.0, 2.0])]),
    near("atanh", &[UNIT]),
];
