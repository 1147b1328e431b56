//! Long records of coarse samples: no set that is as wide as the prior is narrowed by a few of them, and errors drift all the
//! while. That the model agrees is proved all the same, and so is how large errors must be at least, from both sides.

#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

#[path = "../../flow/tests/common/mod.rs"]
mod common;

use common::{Rng, number, read, rig_step};
use veribound_estimate::identify::{
    Conclusion, Identified, IdentifyOptions, LeastError, identify, least_error,
};
use veribound_interval::{Decimal, Interval};
use veribound_model::{Model, Sample};

const ERROR: f64 = 0.05;

const AXIS: &str = "format = 1\nstates = [\"q\", \"v\"]\ninputs = [\"u\"]\n[init]\nq = [-4, 4]\nv = [-4, 4]\n[params]\nm = [0.5, 2]\n\
    d = [0, 8]\nc = [0, 2]\noff = [-0.5, 0.5]\n[let]\npush = \"u - d*v - off\"\n[der]\nq = \"v\"\n\
    v = \"(push - friction(v, push, c))/m\"\n[outputs]\ny = \"q +- 0.05\"\n";

/// Mass, viscous and dry friction, offset.
type Truth = [f64; 4];

/// A true course under a force that takes another value at every sample, with errors that drift, and the largest of these.
fn record(rng: &mut Rng, truth: Truth, samples: usize) -> (Vec<Sample>, f64) {
    let [m, d, c, off] = truth;
    let h = Decimal::parse("0.02").unwrap();
    let (mut x, mut time) = (
        [rng.between(-0.2, 0.2), rng.between(-0.2, 0.2)],
        Decimal::zero(),
    );
    let drift = [rng.between(0.2, 0.6), rng.between(0.0, 6.0)];
    let mut largest = 0.0_f64;
    let mut list = Vec::new();
    for line in 0..samples {
        let t = line as f64 * 0.02;
        let u = 5.0 * (1.1 * t).sin() + 2.0 * (2.9 * t + drift[1]).sin();
        let error =
            0.7 * ERROR * (drift[0] * t + drift[1]).sin() + 0.2 * ERROR * rng.between(-1.0, 1.0);
        largest = largest.max(error.abs());
        list.push(Sample {
            time: time.clone(),
            inputs: vec![Interval::point(u)],
            outputs: vec![Some(Interval::point(x[0] + error).inflate(ERROR))],
            signals: Vec::new(),
            line: line + 2,
        });
        let (q, v) = rig_step(
            x[0],
            x[1],
            u - off,
            [-d / m, 1.0 / m, c],
            h.to_interval().mid(),
        );
        (x, time) = ([q, v], &time + &h);
    }
    (list, largest / ERROR)
}

fn identified(model: &Model, record: &[Sample]) -> Identified {
    let options = IdentifyOptions {
        sets: 4,
        ..IdentifyOptions::default()
    };
    identify(model, &[record.to_vec()], &options, &|_| true)
}

fn least(model: &Model, record: &[Sample]) -> LeastError {
    let options = IdentifyOptions {
        sets: 1,
        ..IdentifyOptions::default()
    };
    least_error(model, &[record.to_vec()], &options, &|_| true)
}

/// The true parameters are kept, the model is proved to agree, and the least error is not larger than the true one, nor
/// proved to be larger; it is enclosed from both sides.
#[test]
fn the_least_error_of_long_coarse_records() {
    let model = read("axis", AXIS);
    let mut rng = Rng(number("VERIBOUND_SEED", 11));
    for _ in 0..number("VERIBOUND_ROUNDS", 1) {
        let truth = [
            rng.between(0.8, 1.4),
            rng.between(2.0, 4.0),
            rng.between(0.3, 1.2),
            rng.between(-0.2, 0.2),
        ];
        let (record, largest) = record(&mut rng, truth, 1000);
        let found = identified(&model, &record);
        println!("{truth:?}: {:?} {:?}", found.conclusion, found.params);
        assert!(
            matches!(found.conclusion, Conclusion::Consistent),
            "{truth:?}"
        );
        for (bounds, true_value) in found.params.iter().zip(truth) {
            assert!(bounds.outer.contains(true_value), "{truth:?} {bounds:?}");
        }
        let found = least(&model, &record);
        println!("largest {largest}: {found:?}");
        let (below, above) = (found.factor.lo(), found.factor.hi());
        assert!(below <= largest, "{truth:?} {largest} {found:?}");
        assert!(
            0.05 < below && above < 1.02 * largest,
            "{truth:?} {largest} {found:?}"
        );
        assert_eq!(found.point.map(|point| point.len()), Some(4));
    }
}
