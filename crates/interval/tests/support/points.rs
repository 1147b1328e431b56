//! Functions of one number at points, held against the oracle.

#![allow(dead_code, reason = "each test uses a part")]

use std::cmp::Ordering;

use num_traits::Zero;
use veribound_interval::Interval;

use crate::oracle::Fixed;
use crate::support::{Dyadic, Source, compare};

/// Enough bits for the argument: 600 for ordinary ones, more for tiny and huge ones.
pub struct Precisions {
    usual: Fixed,
    most: Fixed,
}

impl Precisions {
    pub fn new() -> Precisions {
        Precisions {
            usual: Fixed::new(600),
            most: Fixed::new(1074 + 400),
        }
    }

    pub fn of(&self, x: f64) -> &Fixed {
        let size = x.abs();
        if size == 0.0 || (size > 1e-20 && size < 1e60) {
            &self.usual
        } else {
            &self.most
        }
    }
}

/// Asserts that `[lo, hi]` encloses the value, and that each end is within one float of the tight one. A
/// single number must agree to 100 bits more than floats have: the oracle cannot tell equality.
pub fn assert_encloses(result: Interval, exact: &Dyadic, what: &str) {
    let (lo, hi) = (result.lo(), result.hi());
    if result.is_point() {
        let difference = exact.plus(&Dyadic::of(-lo));
        let close = lo != 0.0 && difference.size() < Dyadic::of(lo).size() - 150;
        assert!(close || difference.m.is_zero(), "{what}: {result:?}");
        return;
    }
    assert_ne!(compare(lo, exact), Ordering::Greater, "{what}: {result:?}");
    assert_ne!(compare(hi, exact), Ordering::Less, "{what}: {result:?}");
    let further = (lo.next_up().next_up(), hi.next_down().next_down());
    assert_eq!(
        compare(further.0, exact),
        Ordering::Greater,
        "{what}: {result:?}"
    );
    assert_eq!(
        compare(further.1, exact),
        Ordering::Less,
        "{what}: {result:?}"
    );
}

pub type Function = fn(Interval) -> Interval;
pub type Exact = fn(&Fixed, f64) -> Dyadic;

/// Points drawn by `draw`, each function value compared with the series.
pub fn check(
    name: &str,
    f: Function,
    exact: Exact,
    seed: u64,
    cases: usize,
    draw: impl Fn(&mut Source) -> f64,
) {
    let precisions = Precisions::new();
    let mut source = Source(seed);
    for _ in 0..cases {
        let x = draw(&mut source);
        let value = exact(precisions.of(x), x);
        assert_encloses(f(Interval::point(x)), &value, &format!("{name}({x:e})"));
    }
}

/// Floats of all magnitudes up to `most`, near zero and near `anchors`.
pub fn anywhere(source: &mut Source, most: f64, anchors: &[f64]) -> f64 {
    loop {
        let x = match source.below(4) {
            0 => source.float(),
            1 if !anchors.is_empty() => {
                let anchor = anchors
                    .get(source.below(anchors.len() as u64) as usize)
                    .unwrap();
                let steps = source.below(9) as i64 - 4;
                f64::from_bits((anchor.to_bits() as i64 + steps) as u64)
            }
            2 => source.between(-1.0, 1.0) * 2_f64.powi(-(source.below(60) as i32)),
            _ => source.between(-most.min(50.0), most.min(50.0)),
        };
        if x.abs() <= most && x.is_finite() {
            return x;
        }
    }
}
