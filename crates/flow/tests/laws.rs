//! Laws of enclosures: a shorter run is the beginning of a longer one, parts of sets have parts of enclosures, and
//! options change how tight a result is, never what it says.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use common::case::Case;
use common::models::{self, Target};
use common::smooth::{SMOOTH, part};
use common::{Rng, number, read};
use veribound_flow::form::{Effort, Enclosure, Flow, FormOptions, Stretch};
use veribound_interval::Interval;

/// A set of solutions of some model.
struct Sets {
    name: &'static str,
    flow: Flow,
    start: Vec<Interval>,
    params: Vec<Interval>,
    stretches: Vec<Stretch>,
}

impl Sets {
    fn enclose(&self, options: FormOptions, effort: Effort) -> Enclosure {
        let Sets {
            flow,
            start,
            params,
            stretches,
            ..
        } = self;
        flow.enclose(start, params, stretches, options, effort)
    }
}

fn smooth(rng: &mut Rng) -> Vec<Sets> {
    let models = SMOOTH.iter().map(|model| {
        let widest = rng.pick(&[1e-6, 1e-3, 0.03]);
        let start = model.states.iter().map(|range| part(rng, *range, widest));
        let start = start.collect();
        let params = model.params.iter().map(|range| part(rng, *range, widest));
        let params = params.collect();
        let stretches = (0..12).map(|_| Stretch {
            inputs: model
                .inputs
                .iter()
                .map(|range| part(rng, *range, 0.01))
                .collect(),
            dt: Interval::point(model.time / 12.0),
        });
        Sets {
            name: model.name,
            flow: Flow::new(&read(model.name, model.text)),
            start,
            params,
            stretches: stretches.collect(),
        }
    });
    models.collect()
}

fn switching(rng: &mut Rng, target: &'static Target) -> Sets {
    let case = Case::draw(target, rng);
    Sets {
        name: target.name,
        flow: Flow::new(&read(target.name, target.text)),
        start: case.start,
        params: case.params,
        stretches: case.stretches,
    }
}

const ONE: Effort = Effort {
    excess: 0.15,
    parts: 1,
};

/// What is proved up to a time does not depend on what comes after it, if the degree is given and nothing is divided:
/// both are chosen by what a whole run comes to.
#[test]
fn a_shorter_run_is_the_beginning_of_a_longer_one() {
    let mut rng = Rng(number("VERIBOUND_SEED", 5));
    for mut sets in smooth(&mut rng) {
        let options = FormOptions {
            degree: Some(2),
            ..FormOptions::default()
        };
        let long = sets.enclose(options, ONE);
        for m in [11, 6, 1] {
            sets.stretches.truncate(m);
            let short = sets.enclose(options, ONE);
            let m = m.min(long.ends.len());
            assert!(short.ends.len() == m, "{}", sets.name);
            // A crossing of a kink under way at the end is the only thing that looks ahead.
            let sure = if sets.name.contains("kink") { 0 } else { m };
            let is_same = short.ends[..sure] == long.ends[..sure]
                && short.tubes[..sure] == long.tubes[..sure]
                && short.output_tubes[..sure] == long.output_tubes[..sure];
            assert!(
                is_same && short.modes[..sure] == long.modes[..sure],
                "{} to {m}",
                sets.name
            );
        }
    }
}

/// Whatever the options, the same solutions are enclosed: two results always meet.
#[test]
fn options_never_contradict_each_other() {
    let mut rng = Rng(number("VERIBOUND_SEED", 6));
    let mut all = smooth(&mut rng);
    all.extend(models::ALL.iter().map(|target| switching(&mut rng, target)));
    for sets in &all {
        let results: Vec<Enclosure> = [
            (1, None, 1, false),
            (2, None, 1, false),
            (2, Some(6), 1, false),
            (2, None, 2, false),
            (2, None, 1, true),
        ]
        .into_iter()
        .map(|(degree, order, parts, closed)| {
            let options = FormOptions {
                degree: Some(degree),
                order,
                closed,
                ..FormOptions::default()
            };
            sets.enclose(options, Effort { parts, ..ONE })
        })
        .collect();
        for one in &results {
            for other in &results {
                let pairs = one.ends.iter().zip(&other.ends);
                let pairs = pairs.chain(one.tubes.iter().zip(&other.tubes));
                let pairs = pairs.chain(one.outputs.iter().zip(&other.outputs));
                for (x, y) in pairs.flat_map(|(x, y)| x.iter().zip(y)) {
                    assert!(x.intersects(*y), "{}: {x} and {y}", sets.name);
                }
            }
        }
        // What is proved of the whole set is proved of its parts.
        for (whole, divided) in results[1].ends.iter().zip(&results[3].ends) {
            let mut pairs = whole.iter().zip(divided);
            assert!(
                pairs.all(|(whole, divided)| divided.is_subset_of(*whole)),
                "{}",
                sets.name
            );
        }
        assert!(
            results[3].ends.len() >= results[1].ends.len(),
            "{}",
            sets.name
        );
    }
}
