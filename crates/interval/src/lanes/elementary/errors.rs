//! The sums of two floats against big integers: the errors are below the proved bounds, and not much.

use std::arch::is_x86_feature_detected;
use std::io::Write;

use num_bigint::BigInt;
use num_traits::{One, Signed, ToPrimitive, Zero};

use super::super::avx2::F64x4;
use super::super::vector::Vector;
use super::arctangent::atan_sum;
use super::exponential::exp_sum;
use super::hyperbolic::{large, moderate};
use super::logarithm::ln_sum;
use super::tables::exact::{BITS, ln_2, of, pi, series, unit};
use super::wave::{sin_sum, tan_sum};
use super::wide::Sum;
use crate::lanes::Floats;

type Four = [f64; 4];

/// High and low parts, errors and exponents; NaN where the sum is not valid.
type Parts = [Four; 4];

/// # Safety
/// The processor has AVX2 and FMA.
#[target_feature(enable = "avx2,fma")]
unsafe fn evaluate(function: Function, x: Four) -> Parts {
    let mut padded: Floats = [0.0; 8];
    padded[..4].copy_from_slice(&x);
    let x = F64x4::load(&padded, 0);
    let zero = F64x4::splat(0.0);
    let (sum, exponent): (Sum<F64x4>, F64x4) = match function {
        Function::Exp => exp_sum(x),
        Function::Ln => (ln_sum(x), zero),
        Function::Sin => (sin_sum(x, 0), zero),
        Function::Cos => (sin_sum(x, 64), zero),
        Function::Tan => (tan_sum(x), zero),
        Function::Atan => (atan_sum(x), zero),
        Function::TanhModerate => (moderate(x), zero),
        Function::TanhLarge => (large(x), zero),
    };
    let high = F64x4::select(sum.valid, sum.high, F64x4::splat(f64::NAN));
    [high, sum.low, sum.error, exponent].map(|v| {
        let mut all: Floats = [0.0; 8];
        v.store(&mut all, 0);
        [all[0], all[1], all[2], all[3]]
    })
}

#[derive(Clone, Copy, Debug)]
enum Function {
    Exp,
    Ln,
    Sin,
    Cos,
    Tan,
    Atan,
    TanhModerate,
    TanhLarge,
}

fn times(a: &BigInt, b: &BigInt) -> BigInt {
    (a * b) >> BITS
}

fn over(a: &BigInt, b: &BigInt) -> BigInt {
    (a << BITS) / b
}

fn exp(x: &BigInt) -> BigInt {
    let small = x >> 12;
    let (mut term, mut power, mut n) = (unit(0), unit(0), 1);
    while term.abs() > BigInt::one() {
        term = times(&term, &small) / n;
        power += &term;
        n += 1;
    }
    (0..12).fold(power, |power, _| times(&power, &power))
}

fn ln(x: f64) -> BigInt {
    let k = (x.to_bits() >> 52) as i32 - 1023;
    let m = of(x / 2_f64.powi(k));
    series(&over(&(&m - unit(0)), &(&m + unit(0))), 1) * 2 + ln_2() * k
}

fn sin_cos(x: &BigInt) -> (BigInt, BigInt) {
    let turn = pi() * 2;
    let x = x - num_integer::Integer::div_floor(x, &turn) * &turn;
    let (mut term, mut sin, mut cos, mut n) = (unit(0), BigInt::zero(), BigInt::zero(), 0);
    while term.abs() > BigInt::one() {
        match n % 4 {
            0 => cos += &term,
            1 => sin += &term,
            2 => cos -= &term,
            _ => sin -= &term,
        }
        n += 1;
        term = times(&term, &x) / n;
    }
    (sin, cos)
}

fn atan(x: &BigInt) -> BigInt {
    let mut t = x.clone();
    for _ in 0..5 {
        let root = ((unit(0) + times(&t, &t)) << BITS).sqrt();
        t = over(&t, &(unit(0) + root));
    }
    series(&t, -1) * 32
}

fn truth(function: Function, x: f64) -> BigInt {
    match function {
        Function::Exp => exp(&of(x)),
        Function::Ln => ln(x),
        Function::Sin => sin_cos(&of(x)).0,
        Function::Cos => sin_cos(&of(x)).1,
        Function::Tan => {
            let (sin, cos) = sin_cos(&of(x));
            over(&sin, &cos)
        }
        Function::Atan => atan(&of(x)),
        Function::TanhModerate | Function::TanhLarge => {
            let power = exp(&(of(x) * 2));
            over(&(&power - unit(0)), &(&power + unit(0)))
        }
    }
}

/// A number in `[0, 1)` from a small generator (splitmix64).
fn next(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (*state ^ (*state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// The largest error of some sums, as a part of the bound.
fn worst(function: Function, argument: impl Fn(&mut u64) -> f64) -> f64 {
    let (mut state, mut worst) = (7, 0.0_f64);
    for _ in 0..250 {
        let x: Four = std::array::from_fn(|_| argument(&mut state));
        // SAFETY: the caller has seen that the processor has AVX2 and FMA.
        let [high, low, error, exponent] = unsafe { evaluate(function, x) };
        for i in 0..4 {
            if high[i].is_nan() {
                continue;
            }
            let e = exponent[i].to_bits() as i64 >> 52;
            let (mut value, mut bound) = (of(high[i]) + of(low[i]), of(error[i]));
            if e > 0 {
                (value, bound) = (value << e as u64, bound << e as u64);
            } else {
                (value, bound) = (value >> (-e) as u64, bound >> (-e) as u64);
            }
            let missed: BigInt = (value - truth(function, x[i])).abs();
            // In millionths.
            let part: BigInt = missed * 1_000_000 / bound;
            worst = worst.max(part.to_f64().unwrap_or(f64::INFINITY) / 1e6);
        }
    }
    worst
}

#[test]
fn errors_are_below_their_bounds() {
    if !(is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")) {
        let line =
            b"SKIPPED avx2: not in this processor, so no errors of its elementary functions\n";
        // Past the capture of the test program, which hides the output of tests that pass.
        std::io::stderr().write_all(line).unwrap();
        return;
    }
    let between = |from: f64, to: f64| move |state: &mut u64| from + (to - from) * next(state);
    let small = |state: &mut u64| 2_f64.powf(-30.0 * next(state)) * (next(state) - 0.5);
    // Beside the multiples of π/2, where the reduction loses most.
    let beside = |state: &mut u64| {
        let k = (next(state) * 600_000.0).floor();
        k * std::f64::consts::FRAC_PI_2 + 2_f64.powf(-28.0 * next(state))
    };
    let results = [
        (Function::Exp, worst(Function::Exp, between(-40.0, 40.0))),
        (Function::Exp, worst(Function::Exp, between(-0.5, 0.5))),
        (Function::Ln, worst(Function::Ln, between(0.5, 2.0))),
        (Function::Ln, worst(Function::Ln, between(0.98, 1.03))),
        (Function::Ln, worst(Function::Ln, between(2.0, 1e9))),
        (Function::Sin, worst(Function::Sin, between(-10.0, 10.0))),
        (Function::Sin, worst(Function::Sin, between(0.0, 0.2))),
        (Function::Sin, worst(Function::Sin, beside)),
        (Function::Cos, worst(Function::Cos, between(-1e6, 1e6))),
        (Function::Cos, worst(Function::Cos, beside)),
        (Function::Tan, worst(Function::Tan, between(-10.0, 10.0))),
        (Function::Tan, worst(Function::Tan, beside)),
        (Function::Atan, worst(Function::Atan, between(0.0, 1.0))),
        (Function::Atan, worst(Function::Atan, between(0.0, 0.05))),
        (Function::Atan, worst(Function::Atan, between(1.0, 40.0))),
        (
            Function::TanhModerate,
            worst(Function::TanhModerate, between(0.0, 3.98)),
        ),
        (
            Function::TanhModerate,
            worst(Function::TanhModerate, between(0.0, 0.05)),
        ),
        (
            Function::TanhLarge,
            worst(Function::TanhLarge, between(3.98, 20.0)),
        ),
        (Function::Sin, worst(Function::Sin, small)),
        (Function::Tan, worst(Function::Tan, small)),
    ];
    for (function, part) in results {
        println!("{function:?} {part}");
        assert!(part < 1.0, "{function:?}: {part} of the bound");
    }
    // None of the bounds is so wide that a much narrower one would go unnoticed.
    for function in ["Exp", "Ln", "Sin", "Tan", "Atan", "TanhModerate"] {
        let largest = results
            .iter()
            .filter(|(other, _)| format!("{other:?}") == function)
            .fold(0.0_f64, |largest, (_, part)| largest.max(*part));
        assert!(largest > 1.0 / 64.0, "{function}: {largest}");
    }
}
