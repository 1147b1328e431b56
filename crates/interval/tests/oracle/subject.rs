//! What is judged and timed: the scalar operations, and every path of the lanes.

use veribound_interval::lanes::{Arithmetic, Kernel, LANES, Path};
use veribound_interval::{Interval, Interval8};

/// A loop over columns of arguments.
pub type Batch = fn(&[Vec<Interval>], &mut [Interval]);

macro_rules! batch {
    (|$x:ident| $value:expr) => {
        |columns, out| {
            if let [x, ..] = columns {
                for (result, &$x) in out.iter_mut().zip(x) {
                    *result = $value;
                }
            }
        }
    };
    (|$x:ident, $y:ident| $value:expr) => {
        |columns, out| {
            if let [x, y, ..] = columns {
                for ((result, &$x), &$y) in out.iter_mut().zip(x).zip(y) {
                    *result = $value;
                }
            }
        }
    };
    (|$x:ident, $y:ident, $z:ident| $value:expr) => {
        |columns, out| {
            if let [x, y, z, ..] = columns {
                for (((result, &$x), &$y), &$z) in out.iter_mut().zip(x).zip(y).zip(z) {
                    *result = $value;
                }
            }
        }
    };
}
pub(crate) use batch;

/// The operation with this name on one interval after the other.
pub fn scalar(name: &str) -> Option<Batch> {
    Some(match name {
        "neg" => batch!(|x| -x),
        "abs" => batch!(|x| x.abs()),
        "mag" => batch!(|x| size(x, Interval::mag)),
        "mig" => batch!(|x| size(x, Interval::mig)),
        "width" => batch!(|x| size(x, Interval::width)),
        "sqr" => batch!(|x| x.sqr()),
        "sqrt" => batch!(|x| x.sqrt()),
        "recip" => batch!(|x| x.recip()),
        "add" => batch!(|x, y| x + y),
        "sub" => batch!(|x, y| x - y),
        "mul" => batch!(|x, y| x * y),
        "div" => batch!(|x, y| x / y),
        "mul_rev_to_pair.0" => batch!(|x, y| Interval::mul_rev_to_pair(x, y).0),
        "mul_rev_to_pair.1" => batch!(|x, y| Interval::mul_rev_to_pair(x, y).1),
        "min" => batch!(|x, y| x.min(y)),
        "max" => batch!(|x, y| x.max(y)),
        "sign_with_zero" => batch!(|x| x.sign_with_zero()),
        "floor" => batch!(|x| x.floor()),
        "ceil" => batch!(|x| x.ceil()),
        "trunc" => batch!(|x| x.trunc()),
        "round_ties_to_even" => batch!(|x| x.round_ties_to_even()),
        "round_ties_to_away" => batch!(|x| x.round_ties_to_away()),
        "fma" => batch!(|x, y, z| x.fma(y, z)),
        "cancel_minus" => batch!(|x, y| x.cancel_minus(y)),
        "cancel_plus" => batch!(|x, y| x.cancel_plus(y)),
        "powi" => batch!(|x, y| x.powi(y.lo() as i32)),
        "rootn" => batch!(|x, y| x.rootn(y.lo() as i32)),
        "pow" => batch!(|x, y| x.pow(y)),
        "exp" => batch!(|x| x.exp()),
        "expm1" => batch!(|x| x.expm1()),
        "exp2" => batch!(|x| x.exp2()),
        "exp10" => batch!(|x| x.exp10()),
        "log1p" => batch!(|x| x.log1p()),
        "log2" => batch!(|x| x.log2()),
        "log10" => batch!(|x| x.log10()),
        "ln" => batch!(|x| x.ln()),
        "sin" => batch!(|x| x.sin()),
        "cos" => batch!(|x| x.cos()),
        "tan" => batch!(|x| x.tan()),
        "asin" => batch!(|x| x.asin()),
        "acos" => batch!(|x| x.acos()),
        "atan2" => batch!(|x, y| x.atan2(y)),
        "sinh" => batch!(|x| x.sinh()),
        "cosh" => batch!(|x| x.cosh()),
        "asinh" => batch!(|x| x.asinh()),
        "acosh" => batch!(|x| x.acosh()),
        "atanh" => batch!(|x| x.atanh()),
        "atan" => batch!(|x| x.atan()),
        "tanh" => batch!(|x| x.tanh()),
        _ => return None,
    })
}

/// A number that tells about a set, as an interval around zero; no number for the empty set.
fn size(x: Interval, f: fn(Interval) -> f64) -> Interval {
    if x.is_empty() {
        x
    } else {
        Interval::symmetric(f(x))
    }
}

/// Intervals in groups of eight; missing ones at the end are empty.
pub fn pack(column: &[Interval]) -> Vec<Interval8> {
    let eight = |cases: &[Interval]| {
        Interval8::from_fn(|lane| cases.get(lane).copied().unwrap_or(Interval::EMPTY))
    };
    column.chunks(LANES).map(eight).collect()
}

/// The operation with this name on this path; false where the lanes have no code of their own for it.
pub fn lanes(path: Path, name: &str, columns: &[Vec<Interval8>], out: &mut [Interval8]) -> bool {
    let eight = Eight { name, columns, out };
    path.run(eight).unwrap_or(false)
}

struct Eight<'a> {
    name: &'a str,
    columns: &'a [Vec<Interval8>],
    out: &'a mut [Interval8],
}

impl Kernel<Interval8> for Eight<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<A: Arithmetic<Value = Interval8>>(self) -> bool {
        let none = Vec::new();
        let column = |number: usize| self.columns.get(number).unwrap_or(&none);
        let (x, y) = (column(0), column(1));
        macro_rules! each {
            ($operation:ident(_)) => {
                for (result, x) in self.out.iter_mut().zip(x) {
                    *result = A::$operation(x);
                }
            };
            ($operation:ident(_, _)) => {
                for ((result, x), y) in self.out.iter_mut().zip(x).zip(y) {
                    *result = A::$operation(x, y);
                }
            };
        }
        match self.name {
            "neg" => each!(neg(_)),
            "abs" => each!(abs(_)),
            "sqr" => each!(sqr(_)),
            "sqrt" => each!(sqrt(_)),
            "exp" => each!(exp(_)),
            "ln" => each!(ln(_)),
            "sin" => each!(sin(_)),
            "cos" => each!(cos(_)),
            "tan" => each!(tan(_)),
            "atan" => each!(atan(_)),
            "tanh" => each!(tanh(_)),
            "add" => each!(add(_, _)),
            "sub" => each!(sub(_, _)),
            "mul" => each!(mul(_, _)),
            "div" => each!(div(_, _)),
            "min" => each!(min(_, _)),
            "max" => each!(max(_, _)),
            // One degree for all lanes is what there is; here every lane may have its own.
            "powi" => {
                for ((result, x), y) in self.out.iter_mut().zip(x).zip(y) {
                    let degrees = y.lo().map(|degree| degree as i32);
                    *result = A::powi(x, degrees[0]);
                    for (lane, &degree) in degrees.iter().enumerate() {
                        if degree != degrees[0] {
                            result.set(lane, A::powi(x, degree).get(lane));
                        }
                    }
                }
            }
            _ => return false,
        }
        true
    }
}
