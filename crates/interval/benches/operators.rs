//! Nanoseconds per interval operation, over arrays of 1024 pseudo-random arguments.
//!
//! `cargo bench -p veribound-interval`; the fastest of 50 rounds is printed, as text or, with `--json`
//! after `--`, as one JSON object.

use std::hint::black_box;
use std::time::Instant;

use veribound_interval::{Decimal, Interval, text};

const COUNT: usize = 1024;
const ROUNDS: usize = 50;

/// A small generator with a fixed seed (xorshift), so that every run sees the same numbers.
struct Source(u64);

impl Source {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn intervals(&mut self, from: f64, to: f64) -> Vec<Interval> {
        (0..COUNT)
            .map(|_| {
                let lo = from + (to - from) * self.unit();
                Interval::point(lo).hull(Interval::point(lo + 0.01 * (to - lo) * self.unit()))
            })
            .collect()
    }
}

fn fastest(mut pass: impl FnMut()) -> f64 {
    (0..ROUNDS)
        .map(|_| {
            let start = Instant::now();
            pass();
            start.elapsed().as_nanos() as f64 / COUNT as f64
        })
        .fold(f64::INFINITY, f64::min)
}

fn unary(x: &[Interval], f: impl Fn(Interval) -> Interval) -> f64 {
    let mut out = vec![Interval::ZERO; COUNT];
    fastest(|| {
        for (result, &x) in out.iter_mut().zip(black_box(x)) {
            *result = f(x);
        }
        black_box(&out);
    })
}

fn binary(x: &[Interval], y: &[Interval], f: impl Fn(Interval, Interval) -> Interval) -> f64 {
    let mut out = vec![Interval::ZERO; COUNT];
    fastest(|| {
        for ((result, &x), &y) in out.iter_mut().zip(black_box(x)).zip(black_box(y)) {
            *result = f(x, y);
        }
        black_box(&out);
    })
}

fn main() {
    let mut source = Source(0x9e37_79b9_7f4a_7c15);
    let positive = source.intervals(0.1, 10.0);
    let other = source.intervals(0.2, 20.0);
    let mixed = source.intervals(-10.0, 10.0);
    let points: Vec<Interval> = mixed.iter().map(|x| Interval::point(x.mid())).collect();
    let wide: Vec<Interval> = mixed.iter().map(|x| x.hull(Interval::ZERO)).collect();
    let texts: Vec<String> = mixed.iter().map(|x| format!("{:.6}", x.mid())).collect();

    let mut results: Vec<(&str, f64)> = vec![
        ("add", binary(&positive, &mixed, |x, y| x + y)),
        ("sub", binary(&positive, &mixed, |x, y| x - y)),
        ("mul same sign", binary(&positive, &other, |x, y| x * y)),
        ("mul any sign", binary(&mixed, &other, |x, y| x * y)),
        ("mul both any sign", binary(&mixed, &points, |x, y| x * y)),
        ("mul with a zero end", binary(&wide, &other, |x, y| x * y)),
        (
            "mul by zero",
            binary(&mixed, &other, |x, _| x * Interval::ZERO),
        ),
        (
            "mul by two",
            binary(&mixed, &other, |x, _| x * Interval::point(black_box(2.0))),
        ),
        ("div", binary(&mixed, &other, |x, y| x / y)),
        ("sqr", unary(&mixed, Interval::sqr)),
        ("powi 3", unary(&mixed, |x| x.powi(3))),
        ("sqrt", unary(&positive, Interval::sqrt)),
        ("intersect", binary(&positive, &other, Interval::intersect)),
        ("hull", binary(&positive, &other, Interval::hull)),
        ("exp", unary(&mixed, Interval::exp)),
        ("ln", unary(&positive, Interval::ln)),
        ("sin", unary(&mixed, Interval::sin)),
        ("cos", unary(&mixed, Interval::cos)),
        ("tan", unary(&mixed, Interval::tan)),
        ("atan", unary(&mixed, Interval::atan)),
        ("tanh", unary(&mixed, Interval::tanh)),
        (
            "mul_rev",
            binary(&mixed, &other, |x, y| {
                Interval::mul_rev(x, y, Interval::ENTIRE)
            }),
        ),
        ("sqr_rev", binary(&positive, &other, Interval::sqr_rev)),
        ("sin_rev", binary(&positive, &mixed, Interval::sin_rev)),
    ];
    let decimals = fastest(|| {
        for text in black_box(&texts) {
            black_box(Decimal::parse(text).map(|number| number.to_interval()).ok());
        }
    });
    let printed = fastest(|| {
        for x in black_box(&mixed) {
            black_box(text::lower(x.lo(), 10));
        }
    });
    results.push(("decimal in", decimals));
    results.push(("decimal out", printed));

    if std::env::args().any(|argument| argument == "--json") {
        let fields: Vec<String> = results
            .iter()
            .map(|(name, ns)| format!("\"{name}\": {ns:.2}"))
            .collect();
        println!("{{{}}}", fields.join(", "));
    } else {
        for (name, ns) in results {
            println!("{name:<22} {ns:8.2} ns");
        }
    }
}
