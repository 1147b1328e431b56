//! What equations say when they are integrated over stretches of a record: [`veribound_flow::balance`].
//!
//! Inputs that may have any course make forms of solutions grow, so that windows are short. Here nothing is moved: a row is
//! told by states at a few samples, by the means of a measured state between them, and by bounds of right-hand sides
//! on boxes that the observer proved. It says of the parameters what no other value can be, whatever the course is.
//!
//! Functions `ψ` of time have `ψ' + a ψ` constant on every stretch between two samples, and any values at samples, so that what is
//! integrated is told by the states there. They are those that refute parameters at the border of what others leave ([`adjoint`], [`cuts`]).
#![allow(clippy::indexing_slicing, reason = "PROOF: states of the model")]

mod adjoint;
mod cuts;
mod ramps;
mod said;
mod track;

use super::pass::GoOn;
use super::problem::Problem;
use super::region::Region;
use super::rows::Rows;
use cuts::Cuts;
use track::Track;
use veribound_flow::System;
use veribound_flow::balance::Balance;
use veribound_interval::Interval;
use veribound_model::Model;

/// What happens between samples is enclosed so often, each time with what is known of states at samples by then.
const ROUNDS: usize = 2;

/// Functions are looked for at so many vertices for each end of a parameter, and at so many for a part of what is left.
const MOST: usize = 12;
const OWN: usize = 3;

/// This is done anew for what is left, which is smaller, so often, and no more where it leaves more than this share of every parameter.
const LOOKS: usize = 6;
const NARROWED: f64 = 0.9;

/// What all balances of all records say.
pub(crate) struct Balances {
    tracks: Vec<Track>,
}

impl std::fmt::Debug for Balances {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Balances").finish_non_exhaustive()
    }
}

impl Balances {
    /// Whether a model has any.
    pub(crate) fn are_there(model: &Model) -> bool {
        !Balance::of(model).is_empty()
    }

    /// The balances of a model along records, of which `seen` tells the states at the first samples of each.
    ///
    /// The states must be those of all solutions with quantities in `box_` that agree with the records.
    pub(crate) fn of(
        model: &Model,
        problem: &Problem,
        seen: &[Vec<Vec<Interval>>],
        box_: &[Interval],
        go_on: &GoOn<'_>,
    ) -> Balances {
        let system = System::new(model);
        let balances = Balance::of(model);
        let mut tracks = Vec::new();
        for (record, seen) in seen.iter().enumerate() {
            let mut states = seen.clone();
            let own = balances.iter().map(|balance| Track::of(record, balance));
            let mut own: Vec<Track> = own.collect();
            for _ in 0..ROUNDS {
                for track in &mut own {
                    track.walk(problem, &system, &mut states, box_);
                    track.sweep();
                    track.smooth();
                    let (state, rate) = (track.balance.state(), track.balance.rate());
                    for (box_, node) in states.iter_mut().zip(&track.nodes) {
                        (box_[state], box_[rate]) = *node;
                    }
                }
            }
            own.iter_mut().for_each(Track::find_stops);
            tracks.append(&mut own);
        }
        let mut balances = Balances { tracks };
        balances.choose(box_, go_on);
        balances
    }

    /// Adds what is told of the unknowns of a region, and tells about how far from linear that is in each axis.
    pub(crate) fn tell(&self, region: &Region, rows: &mut Rows) -> Vec<f64> {
        let mut cuts = Cuts::of(&self.tracks, region.clone());
        cuts.trim();
        cuts.ends(OWN);
        let every: Vec<usize> = (0..region.axes()).collect();
        rows.take(&cuts.rows, &every, 0);
        cuts.bends()
    }

    /// Chooses functions that tell the ends of parameters in a box.
    fn choose(&mut self, box_: &[Interval], go_on: &GoOn<'_>) {
        let mut box_ = box_.to_vec();
        for _ in 0..LOOKS {
            let mut cuts = Cuts::of(&self.tracks, Region::of_box(&box_));
            cuts.trim();
            let left = cuts.ends(MOST);
            let found = cuts.found;
            for (track, found) in self.tracks.iter_mut().zip(found) {
                track.windows.extend(found);
            }
            let Some(left) = left else { return };
            let mut is_over = true;
            for (own, left) in box_.iter_mut().zip(left) {
                is_over &= left.width() > NARROWED * own.width();
                *own = left;
            }
            if is_over || !go_on() {
                break;
            }
        }
        let region = Region::of_box(&box_);
        for track in &mut self.tracks {
            let view = track.view(&region, &track.choices());
            let windows = std::mem::take(&mut track.windows);
            let cutting = windows.into_iter().filter(|window| {
                let mut rows = Rows::new(region.axes());
                track.say(window, (&region, &view), &mut rows);
                rows.prune();
                rows.len() > 0
            });
            track.windows = cutting.collect();
        }
    }
}

#[cfg(test)]
mod belts;
#[cfg(test)]
#[path = "../../../../flow/tests/common/mod.rs"]
mod common;

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::common::{Rng, number, read, rig_step};
    use super::*;
    use veribound_interval::Decimal;
    use veribound_model::Sample;

    const RIG: &str = "format = 1\nstates = [\"phi\", \"omega\"]\n[inputs]\nu = { error = { relative = 0.1 } }\n[init]\nphi = [-1, 1]\n\
        omega = 0\n[params]\nalpha = [-6, -0.05]\nbeta = [1, 400]\nT = [0, 0.3]\n[der]\nphi = \"omega\"\n\
        omega = \"alpha*omega + beta*(u - friction(omega, u, T))\"\n[outputs]\nangle = \"phi +- 0.1\"\n";

    /// A true course with times, states, and inputs as recorded, of which another tenth is off at every sample.
    fn course(
        rng: &mut Rng,
        p: [f64; 3],
        samples: usize,
        signs: &[f64],
    ) -> (Vec<Sample>, Vec<[f64; 2]>) {
        let (mut x, mut u, mut left, mut time) = ([0.0, 0.0], 0.0, 0, Decimal::zero());
        let (mut record, mut states) = (Vec::new(), Vec::new());
        for line in 0..samples {
            if left == 0 {
                u = rng.pick(signs) * rng.between(0.1, 0.4);
                left = 5 + rng.below(40);
            }
            left -= 1;
            let share = rng.pick(&[-1.0, 1.0, 0.0]) * 0.1 * (1.0 - 1e-12);
            let within = Interval::point(u) * Interval::symmetric(0.1);
            record.push(Sample {
                time: time.clone(),
                inputs: vec![Interval::point(u) + within],
                outputs: vec![Some(Interval::point(x[0]).inflate(0.1))],
                signals: Vec::new(),
                line,
            });
            states.push(x);
            // Not all stretches are equally long.
            let step = rng.pick(&["0.01", "0.01", "0.025"]);
            let h = Decimal::parse(step).unwrap();
            let (phi, omega) = rig_step(x[0], x[1], u * (1.0 + share), p, h.to_interval().mid());
            (x, time) = ([phi, omega], &time + &h);
        }
        (record, states)
    }

    /// Whatever boxes of states around a true course are known, and whatever region around the true parameters is asked
    /// about, upright or turned: these satisfy all rows. Rows exclude others.
    #[test]
    fn true_parameters_satisfy_all_rows() {
        let model = read("rig", RIG);
        let mut rng = Rng(number("VERIBOUND_SEED", 5));
        let (mut all, mut cutting) = (0, 0);
        for _ in 0..number("VERIBOUND_ROUNDS", 24) {
            let p = [
                rng.between(-4.0, -0.5),
                rng.between(50.0, 300.0),
                rng.between(0.02, 0.25),
            ];
            let count = 60 + rng.below(200);
            let (record, states) = course(&mut rng, p, count, &[0.0, 1.0, -1.0, 1.0]);
            let problem = Problem::of(&model, std::slice::from_ref(&record));
            // What is known of states, often very well.
            let reach = rng.pick(&[1e-7, 1e-3, 0.05]);
            let seen = states.iter().map(|x| {
                let box_ = x.map(|x| {
                    let (below, above) = (rng.unit() * reach, rng.unit() * reach);
                    Interval::new(x - below - 1e-9, x + above + 1e-9).unwrap()
                });
                // It rests exactly.
                let rests = x[1] == 0.0;
                vec![box_[0], if rests { Interval::ZERO } else { box_[1] }]
            });
            let seen: Vec<Vec<Interval>> = seen.collect();
            let mut box_ = problem.believed();
            let size = rng.pick(&[0.3, 0.1, 0.01]);
            for (quantity, (truth, width)) in problem.params().zip(p.iter().zip([6.0, 400.0, 0.3]))
            {
                let (below, above) = (rng.pick(&[0.0, 1.0]), rng.pick(&[0.0, 0.5, 1.0]));
                let whole =
                    Interval::new(truth - below * size * width, truth + above * size * width);
                box_[quantity] = whole.unwrap().inflate(1e-9).intersect(box_[quantity]);
            }
            let balances = Balances::of(
                &model,
                &problem,
                std::slice::from_ref(&seen),
                &box_,
                &|| true,
            );
            let mut region = Region::of_box(&box_);
            let first = problem.params().start;
            // A shear keeps the truth at other unknowns.
            let axes = region.axes();
            let mut unknowns = vec![Interval::ZERO; axes];
            for (quantity, truth) in problem.params().zip(p) {
                let axis = region.axes[quantity]
                    .iter()
                    .position(|x| *x != 0.0)
                    .unwrap();
                let at = Interval::point(truth) - Interval::point(region.centre[quantity]);
                unknowns[axis] = at / Interval::point(region.axes[quantity][axis]);
            }
            if rng.chance(0.5) {
                let from = region.axes[first].iter().position(|x| *x != 0.0).unwrap();
                let slope = 0.3
                    * region.axes[first + 1]
                        .iter()
                        .fold(0.0, |m: f64, x| m.max(x.abs()));
                region.axes[first + 1][from] = slope;
                let to = region.axes[first + 1]
                    .iter()
                    .rposition(|x| *x != 0.0)
                    .unwrap();
                let moved = Interval::point(slope) * unknowns[from];
                unknowns[to] -= moved / Interval::point(region.axes[first + 1][to]);
                if !unknowns[to].is_subset_of(Interval::symmetric(1.0)) {
                    continue;
                }
            }
            let mut rows = Rows::new(axes);
            let bends = balances.tell(&region, &mut rows);
            assert!(bends.iter().all(|bend| *bend >= 0.0));
            for row in 0..rows.len() {
                let slopes = rows.slopes(row).iter().zip(&unknowns);
                let value = slopes.fold(Interval::ZERO, |sum, (slope, x)| {
                    sum + Interval::point(*slope) * *x
                });
                assert!(
                    value.intersects(rows.outer(row)),
                    "{p:?}: {value} {}",
                    rows.outer(row)
                );
                let most: f64 = rows.slopes(row).iter().map(|slope| slope.abs()).sum();
                cutting += usize::from(!Interval::symmetric(most).is_subset_of(rows.outer(row)));
                all += 1;
            }
        }
        println!("trials of balances: {all}, cutting {cutting}");
        assert!(all > 3_000 && 2 * cutting > all, "{all} {cutting}");
    }

    /// What is known of states at samples from other samples, near and far, is true, and much more than the record says of each alone.
    #[test]
    fn states_stay_in_their_boxes() {
        let model = read("rig", RIG);
        let system = System::new(&model);
        let mut rng = Rng(number("VERIBOUND_SEED", 11));
        let (mut all, mut rates) = (0, 0.0);
        for _ in 0..number("VERIBOUND_ROUNDS", 12) {
            let p = [
                rng.between(-4.0, -0.5),
                rng.between(50.0, 300.0),
                rng.between(0.05, 0.25),
            ];
            let (record, states) = course(&mut rng, p, 400, &[0.0, 1.0, -1.0, -1.0]);
            let problem = Problem::of(&model, std::slice::from_ref(&record));
            let noise = rng.pick(&[0.1, 0.01]);
            let seen = states.iter().map(|[x, _]| {
                let off = noise * rng.pick(&[-1.0, 1.0, 0.3]);
                vec![
                    Interval::point(x + off).inflate(noise + 1e-9),
                    Interval::symmetric(200.0),
                ]
            });
            let mut seen: Vec<Vec<Interval>> = seen.collect();
            let mut box_ = problem.believed();
            let share = rng.pick(&[0.1, 0.01]);
            for (quantity, truth) in problem.params().zip(p) {
                let whole = Interval::point(truth).inflate(share * truth.abs() + 1e-9);
                box_[quantity] = whole.intersect(box_[quantity]);
            }
            let mut track = Track::of(0, &Balance::of(&model)[0]);
            for _ in 0..ROUNDS {
                track.walk(&problem, &system, &mut seen, &box_);
                track.sweep();
                track.smooth();
                for (box_, node) in seen.iter_mut().zip(&track.nodes) {
                    (box_[0], box_[1]) = *node;
                }
            }
            assert!(!track.is_refuted, "{p:?}");
            for ([x, w], node) in states.iter().zip(&track.nodes) {
                let about = |own: Interval| own.inflate(1e-9 * (1.0 + own.mag()));
                let is_in = about(node.0).contains(*x) && about(node.1).contains(*w);
                assert!(is_in, "{p:?}: {x} {w} {node:?}");
                all += 1;
                rates += node.1.width();
            }
        }
        println!(
            "trials of states: {all}, rates within {}",
            rates / f64::from(all)
        );
        assert!(rates < f64::from(all), "{rates} {all}");
    }

    /// What comes to rest, or breaks away, does so in one of the stretches that are left to it, however small the region around the true
    /// parameters is; many others are refuted.
    #[test]
    fn stops_stay_where_they_are() {
        let model = read("rig", RIG);
        let mut rng = Rng(number("VERIBOUND_SEED", 7));
        let (mut stops, mut stretches, mut left) = (0, 0, 0);
        for _ in 0..number("VERIBOUND_ROUNDS", 36) {
            let p = [
                rng.between(-4.0, -0.5),
                rng.between(50.0, 300.0),
                rng.between(0.05, 0.25),
            ];
            let (record, states) = course(&mut rng, p, 200, &[0.0, 1.0, 0.0, -1.0]);
            let problem = Problem::of(&model, std::slice::from_ref(&record));
            let noise = rng.pick(&[0.1, 0.03]);
            let seen = states.iter().map(|[x, w]| {
                let off = noise * rng.between(-1.0, 1.0);
                // On which side of rest it is, is known.
                let (lo, hi) = match w.partial_cmp(&0.0).unwrap() {
                    std::cmp::Ordering::Less => (w - 3.0, (w + 3.0).min(0.0)),
                    std::cmp::Ordering::Equal => (0.0, 0.0),
                    std::cmp::Ordering::Greater => ((w - 3.0).max(0.0), w + 3.0),
                };
                let rate = Interval::new(lo, hi).unwrap();
                vec![Interval::point(x + off).inflate(noise + 1e-9), rate]
            });
            let seen: Vec<Vec<Interval>> = seen.collect();
            let mut box_ = problem.believed();
            let share = rng.pick(&[0.1, 0.02]);
            for (quantity, truth) in problem.params().zip(p) {
                let whole = Interval::point(truth).inflate(share * truth.abs() + 1e-9);
                box_[quantity] = whole.intersect(box_[quantity]);
            }
            let balances = Balances::of(
                &model,
                &problem,
                std::slice::from_ref(&seen),
                &box_,
                &|| true,
            );
            let mut cuts = Cuts::of(&balances.tracks, Region::of_box(&box_));
            cuts.trim();
            let pairs = balances.tracks.iter().zip(&cuts.choices);
            for (stop, choice) in pairs.flat_map(|(track, choices)| track.stops.iter().zip(choices))
            {
                let turns = |k: &usize| (states[*k][1] == 0.0) != (states[k + 1][1] == 0.0);
                for k in stop.stretches.clone().filter(turns) {
                    assert!(choice.contains(&k), "{p:?}: {k} not in {choice:?}");
                    stops += 1;
                    stretches += stop.stretches.len();
                    left += choice.len();
                }
            }
        }
        println!("trials of stops: {stops} in {stretches} stretches, {left} left");
        assert!(
            stops > 10 && 4 * left < 3 * stretches,
            "{stops} {stretches} {left}"
        );
    }
}
