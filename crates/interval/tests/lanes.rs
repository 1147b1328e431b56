//! Eight lanes against one: on every path of this machine, each lane of a result has the bits of
//! the scalar operation (the sign of a zero end aside). `VERIBOUND_LANES` restricts the tests to
//! one path.

#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod support;

use std::io::Write;
use std::sync::Once;

use support::Source;
use veribound_interval::lanes::{Arithmetic, Kernel, LANES, Mask, MaskOf, Path};
use veribound_interval::{Interval, Interval8};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Operation {
    Neg,
    Add,
    Sub,
    Mul,
    Div,
    Sqr,
    Sqrt,
    Abs,
    Sign,
    Power(i32),
    Min,
    Max,
    Intersect,
    Hull,
    Exp,
    Ln,
    Sin,
    Cos,
    Tan,
    Atan,
    Tanh,
}

use Operation::*;

const BINARY: [Operation; 8] = [Add, Sub, Mul, Div, Min, Max, Intersect, Hull];
const UNARY: [Operation; 14] = [
    Neg,
    Sqr,
    Sqrt,
    Abs,
    Sign,
    Power(-2),
    Power(-1),
    Power(0),
    Power(1),
    Power(2),
    Power(3),
    Power(4),
    Power(11),
    Power(64),
];
const ELEMENTARY: [Operation; 7] = [Exp, Ln, Sin, Cos, Tan, Atan, Tanh];

/// One operation, on lanes and on scalars alike.
#[inline(always)]
fn apply<A: Arithmetic>(operation: Operation, a: &A::Value, b: &A::Value) -> A::Value {
    match operation {
        Neg => A::neg(a),
        Add => A::add(a, b),
        Sub => A::sub(a, b),
        Mul => A::mul(a, b),
        Div => A::div(a, b),
        Sqr => A::sqr(a),
        Sqrt => A::sqrt(a),
        Abs => A::abs(a),
        Sign => A::sign(a),
        Power(n) => A::powi(a, n),
        Min => A::min(a, b),
        Max => A::max(a, b),
        Intersect => A::intersect(a, b),
        Hull => A::hull(a, b),
        Exp => A::exp(a),
        Ln => A::ln(a),
        Sin => A::sin(a),
        Cos => A::cos(a),
        Tan => A::tan(a),
        Atan => A::atan(a),
        Tanh => A::tanh(a),
    }
}

fn scalar(operation: Operation, a: Interval, b: Interval) -> Interval {
    match operation {
        Neg => -a,
        Add => a + b,
        Sub => a - b,
        Mul => a * b,
        Div => a / b,
        Sqr => a.sqr(),
        Sqrt => a.sqrt(),
        Abs => a.abs(),
        Sign => a.sign(),
        Power(n) => a.powi(n),
        Min => a.min(b),
        Max => a.max(b),
        Intersect => a.intersect(b),
        Hull => a.hull(b),
        Exp => a.exp(),
        Ln => a.ln(),
        Sin => a.sin(),
        Cos => a.cos(),
        Tan => a.tan(),
        Atan => a.atan(),
        Tanh => a.tanh(),
    }
}

/// The paths under test; what this processor lacks is told once.
fn paths() -> Vec<Path> {
    static TOLD: Once = Once::new();
    TOLD.call_once(|| {
        for path in Path::ALL.into_iter().filter(|path| !path.is_available()) {
            let name = path.name();
            let line = format!("SKIPPED {name}: this processor does not have it; no lanes there\n");
            // Past the capture of the test program, which hides the output of tests that pass.
            std::io::stderr().write_all(line.as_bytes()).unwrap();
        }
    });
    match std::env::var_os("VERIBOUND_LANES") {
        Some(_) if Path::refused().is_none() => vec![Path::chosen()],
        _ => Path::available().collect(),
    }
}

/// An operation on a whole list.
struct Apply<'a> {
    operation: Operation,
    a: &'a [Interval8],
    b: &'a [Interval8],
    out: &'a mut Vec<Interval8>,
}

impl Kernel<Interval8> for Apply<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic<Value = Interval8>>(self) {
        let pairs = self.a.iter().zip(self.b);
        self.out.clear();
        for (a, b) in pairs {
            self.out.push(apply::<A>(self.operation, a, b));
        }
    }
}

fn pack(intervals: impl Iterator<Item = Interval>) -> Vec<Interval8> {
    let mut all: Vec<Interval> = intervals.collect();
    while !all.len().is_multiple_of(LANES) {
        all.push(Interval::EMPTY);
    }
    let eight = |part: &[Interval]| Interval8::from_fn(|lane| part[lane]);
    all.chunks(LANES).map(eight).collect()
}

/// Every path, every operation, every lane.
fn check(operations: &[Operation], pairs: &[(Interval, Interval)]) -> u64 {
    let a = pack(pairs.iter().map(|pair| pair.0));
    let b = pack(pairs.iter().map(|pair| pair.1));
    let mut out = Vec::new();
    let mut cases = 0;
    for &operation in operations {
        let expected: Vec<Interval> = (a.iter().zip(&b))
            .flat_map(|(a, b)| (0..LANES).map(|lane| scalar(operation, a.get(lane), b.get(lane))))
            .collect();
        for path in paths() {
            let kernel = Apply {
                operation,
                a: &a,
                b: &b,
                out: &mut out,
            };
            path.run(kernel).unwrap();
            for (i, expected) in expected.iter().enumerate() {
                let (at, lane) = (i / LANES, i % LANES);
                let result = out[at].get(lane);
                assert!(
                    result == *expected,
                    "{path:?} {operation:?} lane {lane} of {:?} and {:?}: {result:?} instead of {expected:?}",
                    a[at],
                    b[at],
                );
                cases += 1;
            }
        }
    }
    cases
}

/// Ends at which something changes: the case, the range, the rounding.
fn ends() -> Vec<f64> {
    let mut sizes = vec![
        0.0,
        f64::from_bits(1),
        f64::from_bits(3),
        f64::MIN_POSITIVE.next_down(),
        f64::MIN_POSITIVE,
        1.0_f64.next_down(),
        1.0,
        1.0_f64.next_up(),
        3.0,
        0.1,
        2_f64.powi(970),
        1.5 * 2_f64.powi(971),
        2_f64.powi(1023),
        f64::MAX.next_down(),
        f64::MAX,
    ];
    for exponent in [-1021, -960, -537, -511, -480, 480, 511] {
        sizes.push(2_f64.powi(exponent));
        sizes.push(2_f64.powi(exponent).next_down());
    }
    let mut all: Vec<f64> = sizes.iter().flat_map(|&x| [-x, x]).collect();
    all.extend([f64::INFINITY, f64::NEG_INFINITY]);
    all
}

fn intervals(ends: &[f64]) -> Vec<Interval> {
    let mut all = vec![Interval::EMPTY];
    for &lo in ends {
        all.extend(ends.iter().filter_map(|&hi| Interval::new(lo, hi)));
    }
    all
}

/// The pairs in an order that puts unlike ones side by side.
fn shuffled<T: Copy>(items: &[T]) -> Vec<T> {
    let count = items.len();
    let step = (count / 3..count)
        .find(|step| num_integer::gcd(*step, count) == 1)
        .unwrap_or(1);
    (0..count).map(|i| items[i * step % count]).collect()
}

#[test]
fn special_ends_on_every_path() {
    let all = intervals(&ends());
    let single: Vec<_> = all.iter().map(|&x| (x, x)).collect();
    check(&UNARY, &shuffled(&single));
    check(&ELEMENTARY, &shuffled(&single));
    let mut pairs = Vec::new();
    for (i, &x) in all.iter().enumerate() {
        // A third of all pairs, another third for each row.
        pairs.extend(all.iter().skip(i % 3).step_by(3).map(|&y| (x, y)));
    }
    check(&BINARY, &shuffled(&pairs));
}

/// Random intervals: of all magnitudes, often narrow, with equal or zero ends, sometimes unbounded
/// or empty.
fn interval(source: &mut Source) -> Interval {
    let (a, b) = source.floats();
    let (lo, hi) = match source.below(16) {
        0 => return Interval::EMPTY,
        1 => (f64::NEG_INFINITY, a),
        2 => (a, f64::INFINITY),
        3 => (a.min(0.0), a.max(0.0)),
        4 => (a, a),
        5 | 6 => (a, a + a.abs() * source.unit()),
        7 => (f64::from_bits(a.to_bits()), a.next_up()),
        _ => (a.min(b), a.max(b)),
    };
    Interval::new(lo, hi).unwrap_or(Interval::ENTIRE)
}

/// Rounds of 4096 pairs; `VERIBOUND_CASES` multiplies them.
fn rounds(count: usize) -> usize {
    let factor = std::env::var("VERIBOUND_CASES").ok();
    count * factor.and_then(|text| text.parse().ok()).unwrap_or(1)
}

#[test]
fn random_intervals_on_every_path() {
    let mut source = Source(0x1a2e_5d01);
    for _ in 0..rounds(100) {
        let pairs: Vec<_> = (0..4096)
            .map(|_| {
                let x = interval(&mut source);
                // Related ends, where sums cancel and products are near each other.
                let y = match source.below(8) {
                    0 => -x,
                    1 => x,
                    2 => Interval::new(-x.hi(), -x.hi().next_down()).unwrap_or(x),
                    _ => interval(&mut source),
                };
                (x, y)
            })
            .collect();
        check(&BINARY, &pairs);
        check(&UNARY, &pairs);
    }
}

/// Ordinary numbers, for which the fast ways are taken in all lanes.
#[test]
fn ordinary_intervals_on_every_path() {
    let mut source = Source(0x07d1_4a27);
    for _ in 0..rounds(50) {
        let mut ordinary = || {
            let lo = source.between(-10.0, 10.0);
            Interval::new(lo, lo + source.between(0.0, 4.0)).unwrap()
        };
        let pairs: Vec<_> = (0..4096).map(|_| (ordinary(), ordinary())).collect();
        check(&BINARY, &pairs);
        check(&UNARY, &pairs);
        check(&ELEMENTARY, &pairs[..512]);
    }
}

/// Arguments of the elementary functions from the ranges where they are computed in different ways,
/// and at the borders of these.
fn argument(source: &mut Source) -> f64 {
    let x = match source.below(10) {
        0 => source.between(0.0, 1.0),
        1 => source.between(0.0, 10.0),
        2 => source.between(0.0, 1000.0),
        3 => source.between(0.0, 1.1e6),
        // Small and large.
        4 | 5 => (1.0 + source.unit()) * 2_f64.powi(source.below(300) as i32 - 260),
        6 => f64::from_bits(source.below(0x7ff << 52)),
        // Near the multiples of π/128, and so of π/2, and those of ln 2 / 128.
        7 => {
            let size = 1 + source.below(25);
            let k = source.below(1 << size) as f64;
            let step = [std::f64::consts::FRAC_PI_2, std::f64::consts::PI / 128.0]
                [source.below(2) as usize];
            let bits = (k * step).to_bits() as i64 + source.below(9) as i64 - 4;
            f64::from_bits(bits.max(0) as u64)
        }
        8 => {
            let k = source.below(200_000) as f64 + 0.5 * source.below(2) as f64;
            let bits = (k * (std::f64::consts::LN_2 / 128.0)).to_bits() as i64;
            f64::from_bits((bits + source.below(9) as i64 - 4).max(0) as u64)
        }
        // Near 1, and near the borders of the pieces of an octave.
        _ => {
            let piece = (0x3fe6 << 48) + (source.below(128) << 45);
            let exponent = (source.below(5) << 52).wrapping_sub(2 << 52);
            f64::from_bits((piece.wrapping_add(exponent)).wrapping_add(source.below(9)) - 4)
        }
    };
    if source.below(2) == 0 { x } else { -x }
}

#[test]
fn elementary_functions_on_every_path() {
    let mut source = Source(0xe1e_3e27);
    for _ in 0..rounds(40) {
        let pairs: Vec<_> = (0..4096)
            .map(|_| {
                let x = argument(&mut source);
                let y = match source.below(4) {
                    0 => x,
                    1 => x + source.between(0.0, 7.0),
                    2 => x.next_up(),
                    _ => argument(&mut source),
                };
                let x = Interval::new(x.min(y), x.max(y)).unwrap();
                (x, x)
            })
            .collect();
        check(&ELEMENTARY, &pairs);
    }
}

/// Arguments whose values lie so near the middle of two floats that the fast way has to give up.
#[test]
fn values_that_are_hard_to_round() {
    let lines = include_str!("../testdata/hard_to_round.txt").lines();
    let arguments = lines
        .filter(|line| !line.starts_with('#'))
        .filter_map(|line| line.split_whitespace().nth(1)?.parse().ok());
    let pairs: Vec<_> = arguments
        .map(|x: f64| (Interval::point(x), Interval::point(x)))
        .collect();
    assert!(pairs.len() > 20);
    check(&ELEMENTARY, &pairs);
}

/// What stands in the other lanes changes nothing.
#[test]
fn lanes_are_independent() {
    let mut source = Source(0x5eed_1a9e);
    let all = intervals(&ends());
    for _ in 0..rounds(4000) {
        let (x, y) = (interval(&mut source), interval(&mut source));
        let lane = source.below(LANES as u64) as usize;
        let mut fill = || {
            let mut all8 = Interval8::from_fn(|_| all[source.below(all.len() as u64) as usize]);
            all8.set(lane, x);
            all8
        };
        let (a, mut b) = (fill(), fill());
        b.set(lane, y);
        for operation in BINARY.into_iter().chain(UNARY).chain(ELEMENTARY) {
            for path in paths() {
                let mut out = Vec::new();
                path.run(Apply {
                    operation,
                    a: &[a],
                    b: &[b],
                    out: &mut out,
                })
                .unwrap();
                let expected = scalar(operation, x, y);
                assert_eq!(
                    out[0].get(lane),
                    expected,
                    "{path:?} {operation:?} {lane} {a:?} {b:?}"
                );
            }
        }
    }
}

/// The questions, and the choice by a mask.
struct Questions<'a>(&'a Interval8, &'a Interval8, Mask);

impl Kernel<Interval8> for Questions<'_> {
    type Output = ([Mask; 3], Interval8);

    #[inline(always)]
    fn run<A: Arithmetic<Value = Interval8>>(self) -> Self::Output {
        let Questions(a, b, mask) = self;
        let answers: [MaskOf<A>; 3] = [A::is_empty(a), A::is_positive(a), A::contains_zero(a)];
        (answers, A::select(mask, a, b))
    }
}

/// One factor for all lanes.
struct Scale<'a>(&'a [Interval8], Interval, &'a mut Vec<Interval8>);

impl Kernel<Interval8> for Scale<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic<Value = Interval8>>(self) {
        let Scale(all, factor, out) = self;
        out.clear();
        for a in all {
            out.push(A::scale(a, factor));
        }
    }
}

/// Special ends and random ones, times factors of every sign: the cheap products and the general ones.
#[test]
fn products_with_one_factor_on_every_path() {
    let mut source = Source(0x5ca1_e000);
    let special = intervals(&ends());
    let some = |source: &mut Source| interval(source);
    let mut arguments: Vec<Interval> = (0..1024).map(|_| some(&mut source)).collect();
    arguments.extend(shuffled(&special));
    let packed = pack(arguments.into_iter());
    let mut factors: Vec<Interval> = (0..rounds(100)).map(|_| some(&mut source)).collect();
    // Factors that are not negative have code of their own.
    factors.extend((0..rounds(100)).map(|_| some(&mut source).abs()));
    factors.extend(shuffled(&special).into_iter().step_by(3));
    let mut out = Vec::new();
    for factor in factors {
        for path in paths() {
            path.run(Scale(&packed, factor, &mut out)).unwrap();
            for (a, result) in packed.iter().zip(&out) {
                for lane in 0..LANES {
                    let (x, found) = (a.get(lane), result.get(lane));
                    assert!(
                        found == x * factor,
                        "{path:?} {x:?} * {factor:?}: {found:?}"
                    );
                }
            }
        }
    }
}

/// The methods that need no arithmetic, and the operators of the chosen path, against the scalar ones.
fn check_methods(a: &Interval8, b: &Interval8, mask: Mask) {
    let ends = (a.lo(), a.hi());
    let (mid, width, mag) = (a.mid(), a.width(), a.mag());
    let point = Interval8::point(ends.0);
    let between = Interval8::between(ends.0, b.hi());
    let (chosen, mut assigned) = (a.or_else(mask, b), *b);
    assigned.assign(mask, a);
    let sets = [
        -*a,
        *a + *b,
        *a - *b,
        *a * *b,
        *a / *b,
        a.intersect(b),
        a.hull(b),
    ];
    let claims = [
        a.is_empty(),
        a.contains_zero(),
        a.is_bounded(),
        a.is_subset_of(b),
        a.is_interior_of(b),
        a.intersects(b),
    ];
    for lane in 0..LANES {
        let (x, y) = (a.get(lane), b.get(lane));
        assert_eq!((ends.0[lane], ends.1[lane]), (x.lo(), x.hi()), "{x:?}");
        let numbers = (mid[lane], width[lane], mag[lane]);
        assert_eq!(numbers, (x.mid(), x.width(), x.mag()), "{x:?}");
        assert_eq!(point.get(lane), Interval::point(x.lo()), "{x:?}");
        let wanted = Interval::new(x.lo(), y.hi()).unwrap_or(Interval::EMPTY);
        assert_eq!(between.get(lane), wanted, "{x:?} {y:?}");
        let wanted = if mask.get(lane) { x } else { y };
        assert_eq!((chosen.get(lane), assigned.get(lane)), (wanted, wanted));
        let scalar = [-x, x + y, x - y, x * y, x / y, x.intersect(y), x.hull(y)];
        assert_eq!(sets.map(|set| set.get(lane)), scalar, "{x:?} {y:?}");
        let scalar = [
            x.is_empty(),
            x.contains(0.0),
            x.is_bounded(),
            x.is_subset_of(y),
            x.is_interior_of(y),
            !x.is_disjoint_from(y),
        ];
        assert_eq!(claims.map(|claim| claim.get(lane)), scalar, "{x:?} {y:?}");
    }
}

#[test]
fn methods_of_eight_are_those_of_one() {
    let mut source = Source(0x3e7_40d5);
    let special = shuffled(&intervals(&ends()));
    let packed = pack(special.iter().copied());
    for a in &packed {
        // The same ends, and any others.
        for shift in 0..64 {
            let from = source.below(special.len() as u64) as usize;
            let b = Interval8::from_fn(|lane| match shift {
                0 => a.get(lane),
                _ => special[(from + lane * 7) % special.len()],
            });
            check_methods(a, &b, Mask::from_bits(source.bits() as u8));
        }
    }
    for mask in [Mask::NONE, Mask::ALL] {
        check_methods(&packed[0], &packed[1], mask);
    }
    for _ in 0..rounds(100_000) {
        let mut eight = || Interval8::from_fn(|_| interval(&mut source));
        let (a, mut b) = (eight(), eight());
        // Inner and outer sets with a common end.
        let lane = source.below(LANES as u64) as usize;
        b.set(lane, a.get(lane).hull(b.get(lane)));
        check_methods(&a, &b, Mask::from_bits(source.bits() as u8));
    }
}

#[test]
fn questions_and_choices_on_every_path() {
    let all = shuffled(&intervals(&ends()));
    let packed = pack(all.into_iter());
    let mut source = Source(0xa5);
    for pair in packed.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let mask = Mask::from_bits(source.bits() as u8);
        for path in paths() {
            let ([empty, positive, zero], chosen) = path.run(Questions(&a, &b, mask)).unwrap();
            for lane in 0..LANES {
                let x = a.get(lane);
                assert_eq!(empty.get(lane), x.is_empty());
                assert_eq!(positive.get(lane), x.lo() > 0.0);
                assert_eq!(zero.get(lane), x.contains(0.0));
                let wanted = if mask.get(lane) { x } else { b.get(lane) };
                assert_eq!(chosen.get(lane), wanted);
            }
        }
    }
}
