//! Pavings of sets that are needles: turned tiles cover what is left of the prior, and are what they are said to be.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

#[path = "../../flow/tests/common/mod.rs"]
mod common;

use common::{Rng, number, read};
use veribound_estimate::identify::{
    Frame, Identified, IdentifyOptions, Reason, Status, Tile, identify,
};
use veribound_interval::{Decimal, Interval};
use veribound_model::Sample;

const COMPARTMENTS: &str = "format = 1\nstates = [\"x1\", \"x2\"]\ninit = { x1 = 1, x2 = 0 }\n[params]\np1 = [0.01, 1]\n\
    p2 = [0.01, 1]\np3 = [0.01, 1]\n[der]\nx1 = \"-(p1+p3)*x1+p2*x2\"\nx2 = \"p1*x1-p2*x2\"\n[outputs]\ny = \"x2 +- 0.005\"\n";

fn samples(told: &[(&str, Option<Interval>)]) -> Vec<Sample> {
    let sample = |(k, (time, told)): (usize, &(&str, Option<Interval>))| Sample {
        time: Decimal::parse(time).unwrap(),
        inputs: Vec::new(),
        outputs: vec![*told],
        signals: Vec::new(),
        line: k + 2,
    };
    told.iter().enumerate().map(sample).collect()
}

fn compartments() -> Vec<Sample> {
    let told = [
        0.36, 0.47, 0.49, 0.48, 0.46, 0.44, 0.42, 0.40, 0.38, 0.36, 0.35, 0.33, 0.31, 0.30, 0.28,
    ];
    let times: Vec<String> = (0..=15).map(|k: i32| k.to_string()).collect();
    let mut rows = vec![("0", None)];
    rows.extend(told.iter().zip(&times[1..]).map(|(y, time)| {
        let y = Decimal::parse(&format!("{y}")).unwrap().to_interval();
        (
            time.as_str(),
            Some(y + Decimal::parse("0.005").unwrap().to_interval() * Interval::symmetric(1.0)),
        )
    }));
    samples(&rows)
}

/// Points agree for sure that are so far inside of all measurements.
const MARGIN: f64 = 1e-9;

/// Volumes of the tiles with this status.
fn volume(found: &Identified, status: Status) -> Interval {
    let tiles = found.tiles.iter().filter(|tile| tile.status == status);
    let volumes = tiles.map(|tile| match &tile.turned {
        Some(turned) => found.frames[turned.frame].volume(&turned.unknowns),
        None => tile.params.iter().fold(Interval::ONE, |product, x| {
            product * (Interval::point(x.hi()) - Interval::point(x.lo()))
        }),
    });
    volumes.fold(Interval::ZERO, |sum, volume| sum + volume)
}

/// The second state at a time, exactly but for rounding: the rates are the roots of `s² + (p1 + p2 + p3) s + p2 p3`.
fn second(p: &[f64], time: f64) -> f64 {
    let (sum, product) = (p[0] + p[1] + p[2], p[1] * p[2]);
    let root = (0.25 * sum * sum - product).sqrt();
    // The root is far from zero where these are used.
    let fast = -0.5 * sum - root;
    let slow = product / fast;
    p[0] * ((slow * time).exp() - (fast * time).exp()) / (slow - fast)
}

/// By how much a point is inside of all measurements; below zero where it is outside.
fn depth(p: &[f64], record: &[Sample]) -> f64 {
    let depths = record.iter().filter_map(|sample| {
        let told = sample.outputs[0]?;
        let x = second(p, sample.time.to_interval().mid());
        Some((x - told.lo()).min(told.hi() - x))
    });
    depths.fold(f64::INFINITY, f64::min)
}

/// Whether a point surely is, or may be, in a tile; a turned one is asked by its own coordinates.
fn holds(found: &Identified, tile: &Tile, p: &[f64]) -> (bool, bool) {
    let Some(turned) = &tile.turned else {
        let is_in = tile.params.iter().zip(p).all(|(x, p)| x.contains(*p));
        return (is_in, is_in);
    };
    let y = coordinates(&found.frames[turned.frame], p);
    let both = turned.unknowns.iter().zip(&y);
    let mut surely = both.clone();
    let mut maybe = both;
    (
        surely.all(|(x, y)| x.contains(y - 1e-9) && x.contains(y + 1e-9)),
        maybe.all(|(x, y)| x.inflate(1e-9).contains(*y)),
    )
}

/// Coordinates of a point by Cramer's rule.
fn coordinates(frame: &Frame, p: &[f64]) -> Vec<f64> {
    let a = &frame.axes;
    let det = |m: &dyn Fn(usize, usize) -> f64| {
        m(0, 0) * (m(1, 1) * m(2, 2) - m(1, 2) * m(2, 1))
            - m(0, 1) * (m(1, 0) * m(2, 2) - m(1, 2) * m(2, 0))
            + m(0, 2) * (m(1, 0) * m(2, 1) - m(1, 1) * m(2, 0))
    };
    let whole = det(&|i, j| a[i][j]);
    let replaced = |axis: usize| {
        let entry = |i: usize, j: usize| {
            if j == axis {
                p[i] - frame.centre[i]
            } else {
                a[i][j]
            }
        };
        det(&entry)
    };
    (0..3).map(|axis| replaced(axis) / whole).collect()
}

/// Two compartments that may be exchanged: the volume of what agrees is 2.80e-6, in a box a thousand times as large, and
/// twice a needle. Upright tiles cover the prior. Points that agree lie in tiles that may agree, of turned ones where an
/// upright one is divided so; those of tiles that are inside do agree.
#[test]
fn the_volume_of_two_compartments() {
    let (model, record) = (read("compartments", COMPARTMENTS), compartments());
    let options = IdentifyOptions {
        undecided: Some(0.7),
        sets: 300,
        ..IdentifyOptions::default()
    };
    let found = identify(&model, std::slice::from_ref(&record), &options, &|_| true);
    let inside = volume(&found, Status::Inside);
    let outer = inside + volume(&found, Status::Undecided);
    let told = found.volume.unwrap();
    println!(
        "{told} of {inside} {outer}: {} tiles, {} sets",
        found.tiles.len(),
        found.sets
    );
    assert!(
        told.contains(2.80e-6) && told.lo() > 2.5e-6 && told.hi() < 1.1 * 2.80e-6,
        "{told}"
    );
    assert!(inside.lo() > 0.0 && inside.hi() <= told.lo() && told.hi() <= outer.hi());
    assert!(found.frames.len() > 1);

    let upright: Vec<&Tile> = found
        .tiles
        .iter()
        .filter(|tile| tile.turned.is_none())
        .collect();
    let sizes = upright
        .iter()
        .map(|tile| tile.params.iter().map(|x| x.width()).product::<f64>());
    let (all, whole) = (sizes.sum::<f64>(), 0.99_f64.powi(3));
    assert!((all - whole).abs() < 1e-9 * whole, "{all}");

    let mut rng = Rng(number("VERIBOUND_SEED", 4));
    let mut agreeing = Vec::new();
    let is_covered = |p: &[f64], depth: f64| {
        let Some(around) = upright.iter().find(|tile| holds(&found, tile, p).0) else {
            return;
        };
        if depth.is_nan() {
            return;
        }
        if around.status == Status::Outside {
            assert!(depth < MARGIN, "{p:?} {depth} {around:?}");
        }
        if let Reason::Needle { frame } = around.reason {
            let own = found.tiles.iter().filter(|tile| {
                let turned = tile.turned.as_ref();
                turned.is_some_and(|turned| turned.frame == frame) && tile.status != Status::Outside
            });
            let is_held = own.into_iter().any(|tile| holds(&found, tile, p).1);
            assert!(is_held || depth < MARGIN, "{p:?} {depth} {around:?}");
        }
    };
    let pieces: Vec<&Tile> = found
        .tiles
        .iter()
        .filter(|tile| tile.turned.is_some())
        .collect();
    for round in 0..20_000 {
        let p = if round % 2 == 0 {
            // Near one of the two needles: `p2 p3` and the sum are what records tell.
            let sum = rng.between(1.02, 1.18);
            let (p1, product) = (rng.between(0.58, 0.624), rng.between(0.049, 0.056));
            let root = (0.25 * (sum - p1) * (sum - p1) - product).sqrt();
            let p2 = 0.5 * (sum - p1) + rng.pick(&[-1.0, 1.0]) * root;
            [p1, p2, sum - p1 - p2]
        } else {
            // Near a tile.
            let near = rng.pick(&pieces);
            [0, 1, 2].map(|i| {
                let x = near.params[i];
                rng.between(x.lo() - 2.0 * x.width(), x.hi() + 2.0 * x.width())
            })
        };
        let depth = depth(&p, &record);
        if depth > MARGIN {
            agreeing.push(p);
        }
        is_covered(&p, depth);
    }
    assert!(agreeing.len() > 500, "{}", agreeing.len());
    // From points that agree as far as others do, along the axes of tiles and between them: near the ends of what agrees.
    for _ in 0..20_000 {
        let from = rng.pick(&agreeing);
        let axes = &found.frames[rng.pick(&pieces).turned.as_ref().unwrap().frame].axes;
        let own = [0, 1, 2].map(|_| rng.pick(&[0.0, 0.0, 1.0]) * rng.between(-1.0, 1.0));
        let way = [0, 1, 2].map(|i| (0..3).map(|j| axes[i][j] * own[j]).sum::<f64>());
        let at = |t: f64| [0, 1, 2].map(|i| from[i] + t * way[i]);
        let agrees = |t: f64| depth(&at(t), &record) > MARGIN;
        let (mut inside, mut outside) = (0.0, 1.0);
        while outside < 1e6 && agrees(outside) {
            outside *= 2.0;
        }
        for _ in 0..40 {
            let middle = 0.5 * (inside + outside);
            *(if agrees(middle) {
                &mut inside
            } else {
                &mut outside
            }) = middle;
        }
        is_covered(&at(inside), depth(&at(inside), &record));
    }
    for tile in found.tiles.iter().filter(|tile| tile.turned.is_some()) {
        let turned = tile.turned.as_ref().unwrap();
        let frame = &found.frames[turned.frame];
        let y: Vec<f64> = turned.unknowns.iter().map(|y| rng.inside(*y)).collect();
        let p: Vec<f64> = (0..3)
            .map(|i| frame.centre[i] + (0..3).map(|j| frame.axes[i][j] * y[j]).sum::<f64>())
            .collect();
        match tile.status {
            Status::Inside => {
                assert!(depth(&p, &record) > -1e-9, "{p:?} {tile:?}");
                assert!(
                    tile.params
                        .iter()
                        .zip(&p)
                        .all(|(x, p)| x.inflate(1e-12).contains(*p))
                );
            }
            Status::Outside => assert!(depth(&p, &record) < 1e-9, "{p:?} {tile:?}"),
            Status::Undecided | Status::Turned => {}
        }
    }
}
