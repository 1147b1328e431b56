//! The smallest intervals by exact rational numbers: every end of every argument, no case of signs.

use num_bigint::{BigInt, BigUint, Sign};
use num_traits::{One, Zero};
use veribound_interval::Interval;

/// The results of an operation that rational numbers have.
pub fn evaluate(name: &str, columns: &[Vec<Interval>]) -> Option<Vec<Interval>> {
    let f: fn(&[Interval]) -> Interval = match name {
        "neg" => |x| (Value::of(x[0].lo()).negated()).hull(&Value::of(x[0].hi()).negated()),
        "abs" => |x| power(absolute(x[0]), 1),
        "mag" => |x| Interval::symmetric(absolute(x[0]).hi()),
        "mig" => |x| Interval::symmetric(absolute(x[0]).lo()),
        "width" => |x| Interval::symmetric(sum(x[0], -x[0]).hi()),
        "add" => |x| sum(x[0], x[1]),
        "sub" => |x| sum(x[0], -x[1]),
        "mul" => |x| product(x[0], x[1]),
        "div" => |x| quotient(x[0], x[1]),
        "recip" => |x| quotient(Interval::ONE, x[0]),
        "sqr" => |x| power(x[0], 2),
        "sqrt" => |x| root(x[0]),
        "powi" => |x| power(x[0], x[1].lo() as i32),
        "fma" => |x| product_and_sum(x[0], x[1], x[2]),
        _ => return None,
    };
    let count = columns[0].len();
    let result = |case: usize| {
        let arguments: Vec<Interval> = columns.iter().map(|column| column[case]).collect();
        if arguments.iter().any(|x| x.is_empty()) {
            Interval::EMPTY
        } else {
            f(&arguments)
        }
    };
    Some((0..count).map(result).collect())
}

/// `±(above / below) 2^exponent`, or a signed infinity.
#[derive(Clone)]
enum Value {
    Finite {
        above: BigInt,
        below: BigUint,
        exponent: i64,
    },
    Infinite {
        negative: bool,
    },
}

use Value::{Finite, Infinite};

impl Value {
    fn of(x: f64) -> Value {
        if x.is_infinite() {
            return Infinite { negative: x < 0.0 };
        }
        let bits = x.to_bits();
        let biased = ((bits >> 52) & 0x7ff) as i64;
        let fraction = bits & ((1 << 52) - 1);
        let (size, exponent) = match biased {
            0 => (fraction, -1074),
            _ => (fraction | (1 << 52), biased - 1075),
        };
        // Short numbers stay short: what is exact is then seen to be.
        let spare = size.trailing_zeros().min(52);
        let size = BigInt::from(size >> spare);
        Finite {
            above: if x < 0.0 { -size } else { size },
            below: BigUint::one(),
            exponent: exponent + i64::from(spare),
        }
    }

    fn negated(self) -> Value {
        match self {
            Finite {
                above,
                below,
                exponent,
            } => Finite {
                above: -above,
                below,
                exponent,
            },
            Infinite { negative } => Infinite {
                negative: !negative,
            },
        }
    }

    fn sign(&self) -> i32 {
        match self {
            Infinite { negative: true } => -1,
            Infinite { negative: false } => 1,
            Finite { above, .. } => match above.sign() {
                Sign::Minus => -1,
                Sign::NoSign => 0,
                Sign::Plus => 1,
            },
        }
    }

    /// The product, with `0 * inf = 0`: the infinity is the bound of a set of real numbers.
    fn times(&self, other: &Value) -> Value {
        match (self, other) {
            (
                Finite {
                    above: a,
                    below: b,
                    exponent: e,
                },
                Finite {
                    above: c,
                    below: d,
                    exponent: f,
                },
            ) => Finite {
                above: a * c,
                below: b * d,
                exponent: e + f,
            },
            _ => match self.sign() * other.sign() {
                0 => Value::of(0.0),
                sign => Infinite { negative: sign < 0 },
            },
        }
    }

    /// `1 / x`; zero is approached from the side of `sign`.
    fn inverse(&self, sign: i32) -> Value {
        match self {
            Infinite { .. } => Value::of(0.0),
            Finite { above, .. } if above.is_zero() => Infinite { negative: sign < 0 },
            Finite {
                above,
                below,
                exponent,
            } => Finite {
                above: BigInt::from_biguint(above.sign(), below.clone()),
                below: above.magnitude().clone(),
                exponent: -exponent,
            },
        }
    }

    /// The sum of a number and another with the denominator 1. Required: not two infinities of
    /// different sign.
    fn plus(&self, other: &Value) -> Value {
        let (
            Finite {
                above: a,
                below: b,
                exponent: e,
            },
            Finite {
                above: c,
                below: d,
                exponent: f,
            },
        ) = (self, other)
        else {
            return if let Infinite { .. } = self {
                self.clone()
            } else {
                other.clone()
            };
        };
        assert!(b.is_one() && d.is_one());
        let exponent = *e.min(f);
        Finite {
            above: (a << (e - exponent) as u64) + (c << (f - exponent) as u64),
            below: BigUint::one(),
            exponent,
        }
    }

    fn power(&self, n: u32) -> Value {
        match self {
            Infinite { negative } => Infinite {
                negative: *negative && n % 2 == 1,
            },
            Finite {
                above,
                below,
                exponent,
            } => Finite {
                above: above.pow(n),
                below: below.pow(n),
                exponent: exponent * i64::from(n),
            },
        }
    }

    /// The nearest float below (above, if `up`) or equal.
    fn rounded(&self, up: bool) -> f64 {
        match self {
            Infinite { negative: true } => f64::NEG_INFINITY,
            Infinite { negative: false } => f64::INFINITY,
            Finite {
                above,
                below,
                exponent,
            } => {
                let negative = above.sign() == Sign::Minus;
                // At least 60 bits before the point of the quotient, and whether anything is behind it.
                let size = above.magnitude();
                let shift = (60 + below.bits() as i64 - size.bits() as i64).max(0);
                let shifted = size << shift as u64;
                let (whole, more) = if below.is_one() {
                    (shifted, false)
                } else {
                    let whole = &shifted / below;
                    let more = &whole * below != shifted;
                    (whole, more)
                };
                float(negative, &whole, more, exponent - shift, up)
            }
        }
    }

    fn hull(&self, other: &Value) -> Interval {
        hull(&[self.clone(), other.clone()])
    }
}

/// The float next to `±(whole + rest) 2^exponent`, where `0 < rest < 1` if `more` (and `whole >= 2^54`) and
/// else `rest = 0`.
fn float(negative: bool, whole: &BigUint, more: bool, exponent: i64, up: bool) -> f64 {
    if whole.is_zero() && !more {
        return 0.0;
    }
    // The exponent of the last bit a float around the value has.
    let last = (exponent + whole.bits() as i64 - 53).max(-1074);
    let drop = last - exponent;
    let (mut kept, exact) = if drop <= 0 {
        (whole << (-drop) as u64, true)
    } else {
        let kept = whole >> drop as u64;
        let exact = (&kept << drop as u64) == *whole;
        (kept, exact)
    };
    if (!exact || more) && up != negative {
        kept += 1_u32;
    }
    let digits = u64::try_from(&kept).unwrap();
    assert!(digits <= 1 << 53);
    // Both factors and the product are floats, unless it is beyond the largest one.
    let size = match last {
        -1074..=971 => {
            let half = last / 2;
            digits as f64 * 2_f64.powi(half as i32) * 2_f64.powi((last - half) as i32)
        }
        _ => f64::INFINITY,
    };
    let size = if size.is_infinite() && up == negative {
        f64::MAX
    } else {
        size
    };
    if negative { -size } else { size }
}

/// The smallest interval with floats as ends around some values.
fn hull(values: &[Value]) -> Interval {
    let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
    for value in values {
        lo = lo.min(value.rounded(false));
        hi = hi.max(value.rounded(true));
    }
    Interval::new(lo, hi).unwrap()
}

fn ends(x: Interval) -> [Value; 2] {
    [Value::of(x.lo()), Value::of(x.hi())]
}

fn sum(x: Interval, y: Interval) -> Interval {
    let ([a, b], [c, d]) = (ends(x), ends(y));
    Interval::new(a.plus(&c).rounded(false), b.plus(&d).rounded(true)).unwrap()
}

fn products(x: &[Value; 2], y: &[Value; 2]) -> Vec<Value> {
    let pairs = x.iter().flat_map(|a| y.iter().map(move |b| (a, b)));
    pairs.map(|(a, b)| a.times(b)).collect()
}

fn product(x: Interval, y: Interval) -> Interval {
    hull(&products(&ends(x), &ends(y)))
}

fn product_and_sum(x: Interval, y: Interval, z: Interval) -> Interval {
    let products = products(&ends(x), &ends(y));
    // An infinite end of the summand is a bound, whatever the product.
    let end = |z: f64, up: bool| {
        if z.is_infinite() {
            return z;
        }
        let sums = products.iter().map(|p| p.plus(&Value::of(z)).rounded(up));
        if up {
            sums.fold(f64::NEG_INFINITY, f64::max)
        } else {
            sums.fold(f64::INFINITY, f64::min)
        }
    };
    Interval::new(end(z.lo(), false), end(z.hi(), true)).unwrap()
}

/// The reciprocals of the numbers of one sign: a zero end is approached from inside.
fn reciprocals(y: Interval) -> [Value; 2] {
    let sign = if y.hi() > 0.0 { 1 } else { -1 };
    ends(y).map(|end| end.inverse(sign))
}

fn quotient(x: Interval, y: Interval) -> Interval {
    if y == Interval::ZERO {
        Interval::EMPTY
    } else if x == Interval::ZERO {
        Interval::ZERO
    } else if y.lo() < 0.0 && y.hi() > 0.0 {
        Interval::ENTIRE
    } else {
        hull(&products(&ends(x), &reciprocals(y)))
    }
}

fn absolute(x: Interval) -> Interval {
    let size = x.lo().abs().max(x.hi().abs());
    let least = if x.lo() <= 0.0 && x.hi() >= 0.0 {
        0.0
    } else {
        x.lo().abs().min(x.hi().abs())
    };
    Interval::new(least, size).unwrap()
}

fn power(x: Interval, n: i32) -> Interval {
    let x = if n % 2 == 0 { absolute(x) } else { x };
    if n < 0 {
        if x == Interval::ZERO {
            return Interval::EMPTY;
        }
        if x.lo() < 0.0 && x.hi() > 0.0 {
            return Interval::ENTIRE;
        }
        return hull(&reciprocals(x).map(|end| end.power(n.unsigned_abs())));
    }
    if n == 0 {
        return Interval::ONE;
    }
    hull(&ends(x).map(|end| end.power(n.unsigned_abs())))
}

fn root(x: Interval) -> Interval {
    if x.hi() < 0.0 {
        return Interval::EMPTY;
    }
    let end = |x: f64, up: bool| match Value::of(x.max(0.0)) {
        Finite {
            above, exponent, ..
        } => {
            // An even exponent, and a root of at least 60 bits.
            let shift = 120 + exponent.rem_euclid(2);
            let shifted = above.magnitude() << shift as u64;
            let whole = shifted.sqrt();
            let more = &whole * &whole != shifted;
            float(false, &whole, more, (exponent - shift) / 2, up)
        }
        Infinite { .. } => f64::INFINITY,
    };
    Interval::new(end(x.lo(), false), end(x.hi(), true)).unwrap()
}
