//! The operations by name: each a loop of its own, in which the compiler sees inari's code.

use inari::Interval;

use crate::tight;

type Unary = fn(&[Interval], &mut [Interval]);
type Binary = fn(&[Interval], &[Interval], &mut [Interval]);
type Ternary = fn(&[Interval], &[Interval], &[Interval], &mut [Interval]);

pub enum Operation {
    Unary(Unary),
    Binary(Binary),
    Ternary(Ternary),
}

macro_rules! unary {
    (|$x:ident| $value:expr) => {
        Operation::Unary(|x, out| {
            for (result, &$x) in out.iter_mut().zip(x) {
                *result = $value;
            }
        })
    };
}

macro_rules! binary {
    (|$x:ident, $y:ident| $value:expr) => {
        Operation::Binary(|x, y, out| {
            for ((result, &$x), &$y) in out.iter_mut().zip(x).zip(y) {
                *result = $value;
            }
        })
    };
}

impl Operation {
    /// Integer arguments are passed as intervals of one number. `tight sin` and its like do not lose
    /// anything for large arguments, as inari's own do.
    pub fn named(name: &[u8]) -> Option<Operation> {
        Some(match name {
            b"neg" => unary!(|x| -x),
            b"abs" => unary!(|x| x.abs()),
            b"mag" => unary!(|x| tight::around_zero(x.mag())),
            b"mig" => unary!(|x| tight::around_zero(x.mig())),
            b"width" => unary!(|x| tight::around_zero(x.wid())),
            b"sqr" => unary!(|x| x.sqr()),
            b"sqrt" => unary!(|x| x.sqrt()),
            b"recip" => unary!(|x| x.recip()),
            b"floor" => unary!(|x| x.floor()),
            b"ceil" => unary!(|x| x.ceil()),
            b"trunc" => unary!(|x| x.trunc()),
            b"round_ties_to_away" => unary!(|x| x.round()),
            b"round_ties_to_even" => unary!(|x| x.round_ties_even()),
            b"sign_with_zero" => unary!(|x| x.sign()),
            b"exp" => unary!(|x| x.exp()),
            b"exp2" => unary!(|x| x.exp2()),
            b"exp10" => unary!(|x| x.exp10()),
            b"expm1" => unary!(|x| tight::expm1(x)),
            b"log1p" => unary!(|x| tight::log1p(x)),
            b"ln" => unary!(|x| x.ln()),
            b"log2" => unary!(|x| x.log2()),
            b"log10" => unary!(|x| x.log10()),
            b"sin" => unary!(|x| x.sin()),
            b"cos" => unary!(|x| x.cos()),
            b"tan" => unary!(|x| x.tan()),
            b"tight sin" => unary!(|x| tight::sin(x)),
            b"tight cos" => unary!(|x| tight::cos(x)),
            b"tight tan" => unary!(|x| tight::tan(x)),
            b"asin" => unary!(|x| x.asin()),
            b"acos" => unary!(|x| x.acos()),
            b"atan" => unary!(|x| x.atan()),
            b"sinh" => unary!(|x| x.sinh()),
            b"cosh" => unary!(|x| x.cosh()),
            b"tanh" => unary!(|x| x.tanh()),
            b"asinh" => unary!(|x| x.asinh()),
            b"acosh" => unary!(|x| x.acosh()),
            b"atanh" => unary!(|x| x.atanh()),
            b"add" => binary!(|x, y| x + y),
            b"sub" => binary!(|x, y| x - y),
            b"mul" => binary!(|x, y| x * y),
            b"div" => binary!(|x, y| x / y),
            b"min" => binary!(|x, y| x.min(y)),
            b"max" => binary!(|x, y| x.max(y)),
            b"cancel_minus" => binary!(|x, y| x.cancel_minus(y)),
            b"cancel_plus" => binary!(|x, y| x.cancel_plus(y)),
            b"mul_rev_to_pair.0" => binary!(|x, y| x.mul_rev_to_pair(y)[0]),
            b"mul_rev_to_pair.1" => binary!(|x, y| x.mul_rev_to_pair(y)[1]),
            b"powi" => binary!(|x, n| x.powi(n.inf() as i32)),
            b"rootn" => binary!(|x, n| tight::rootn(x, n.inf() as i32)),
            b"pow" => binary!(|x, y| x.pow(y)),
            b"atan2" => binary!(|y, x| y.atan2(x)),
            b"fma" => Operation::Ternary(|x, y, z, out| {
                for (((result, &x), &y), &z) in out.iter_mut().zip(x).zip(y).zip(z) {
                    *result = x.mul_add(y, z);
                }
            }),
            _ => return None,
        })
    }

    pub fn arity(&self) -> usize {
        match self {
            Operation::Unary(_) => 1,
            Operation::Binary(_) => 2,
            Operation::Ternary(_) => 3,
        }
    }

    pub fn pass(&self, arguments: &[Vec<Interval>], results: &mut [Interval]) {
        match (self, arguments) {
            (Operation::Unary(f), [x]) => f(x, results),
            (Operation::Binary(f), [x, y]) => f(x, y, results),
            (Operation::Ternary(f), [x, y, z]) => f(x, y, z, results),
            _ => {}
        }
    }
}
