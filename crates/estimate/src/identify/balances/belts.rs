//! Random masses on springs and belts: what balances say is true of their solutions, also where these move along with a
//! level of their rate.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use super::common::{Rng, number, read};
use super::cuts::Cuts;
use super::*;
use veribound_interval::Decimal;
use veribound_model::Sample;

/// A mass on a spring and a belt, slowed down above some speed: its rate has two levels, at each of which it may stay.
struct Belt {
    spring: f64,
    damping: f64,
    gain: f64,
    /// Each level of the rate, and by how much its derivative falls there.
    levels: [(f64, f64); 2],
}

/// Between two levels, as many being below; or on one of them.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Where {
    Above(usize),
    On(usize),
}

impl Belt {
    fn bend(&self, [x, w]: [f64; 2], u: f64, below: usize) -> f64 {
        let free = -self.spring * x.sin() - self.damping * w + self.gain * u;
        let fallen = self.levels.iter().take(below).map(|level| level.1);
        free + 0.5 * self.levels[0].1 - fallen.sum::<f64>()
    }

    /// By the classical Runge-Kutta method.
    fn moved(&self, [x, w]: [f64; 2], (u, below): (f64, usize), by: f64) -> [f64; 2] {
        let slope = |x: f64, w: f64| [w, self.bend([x, w], u, below)];
        let [a, b] = slope(x, w);
        let [c, d] = slope(x + 0.5 * by * a, w + 0.5 * by * b);
        let [e, f] = slope(x + 0.5 * by * c, w + 0.5 * by * d);
        let [g, h] = slope(x + by * e, w + by * f);
        [
            x + by / 6.0 * (a + 2.0 * c + 2.0 * e + g),
            w + by / 6.0 * (b + 2.0 * d + 2.0 * f + h),
        ]
    }

    /// The first time at which it is so, at most `by`.
    fn first(by: f64, is_so: impl Fn(f64) -> bool) -> f64 {
        let (mut before, mut after) = (0.0, by);
        for _ in 0..60 {
            let middle = 0.5 * (before + after);
            if is_so(middle) {
                after = middle;
            } else {
                before = middle;
            }
        }
        after
    }

    fn travel(&self, at: &mut [f64; 2], place: &mut Where, u: f64, time: f64) {
        let mut left = time;
        while left > 1e-15 {
            let by = left.min(time / 8.0);
            match *place {
                Where::On(level) => {
                    let speed = self.levels[level].0;
                    let ends =
                        |x: f64| [level, level + 1].map(|below| self.bend([x, speed], u, below));
                    let [under, over] = ends(at[0]);
                    if under < 0.0 || over > 0.0 {
                        *place = Where::Above(if under < 0.0 { level } else { level + 1 });
                        continue;
                    }
                    let leaves = |by: f64| {
                        let [under, over] = ends(at[0] + speed * by);
                        under < 0.0 || over > 0.0
                    };
                    let by = if leaves(by) {
                        Belt::first(by, leaves)
                    } else {
                        by
                    };
                    *at = [at[0] + speed * by, speed];
                    left -= by;
                }
                Where::Above(below) => {
                    let lo = below
                        .checked_sub(1)
                        .map(|level| (level, self.levels[level].0));
                    let hi = self.levels.get(below).map(|level| (below, level.0));
                    let met = |by: f64| {
                        let w = self.moved(*at, (u, below), by)[1];
                        hi.filter(|hi| w > hi.1).or(lo.filter(|lo| w < lo.1))
                    };
                    let by = if met(by).is_some() {
                        Belt::first(by, |by| met(by).is_some())
                    } else {
                        by
                    };
                    let level = met(by);
                    *at = self.moved(*at, (u, below), by);
                    left -= by;
                    if let Some((level, speed)) = level {
                        at[1] = speed;
                        let [under, over] =
                            [level, level + 1].map(|below| self.bend(*at, u, below));
                        *place = match level == below {
                            true if over > 0.0 => Where::Above(level + 1),
                            false if under < 0.0 => Where::Above(level),
                            _ => Where::On(level),
                        };
                    }
                }
            }
        }
    }
}

/// What moves on a spring, stays at two levels of its rate and is driven by anything satisfies all rows, and comes to levels where
/// it may.
#[test]
fn belts_satisfy_all_rows() {
    let mut rng = Rng(number("VERIBOUND_SEED", 3));
    let (mut all, mut cutting, mut stops, mut resting) = (0, 0, 0, 0);
    for _ in 0..number("VERIBOUND_ROUNDS", 24) {
        let first = rng.pick(&[0.0, 0.0, 0.0625, 0.5, -0.25]);
        let levels = [
            (first, 2.0 * rng.pick(&[0.5, 1.0, 2.5])),
            (first + rng.pick(&[0.25, 1.0]), rng.pick(&[0.5, 1.5, 4.0])),
        ];
        let belt = Belt {
            spring: rng.pick(&[0.0, 3.0, 30.0]),
            damping: rng.between(0.1, 3.0),
            gain: rng.between(5.0, 20.0),
            levels,
        };
        let truth = [
            belt.spring,
            belt.damping,
            belt.gain,
            0.5 * levels[0].1,
            levels[1].1,
        ];
        let text = format!(
            "format = 1\nstates = [\"x\", \"w\"]\n[inputs]\nu = {{ error = {{ relative = 0.1 }} }}\n[init]\nx = [-9, 9]\n\
             w = [-9, 9]\n[params]\nk = [0, 40]\nb = [0, 6]\nc = [1, 30]\nT = [0, 4]\ne = [0, 6]\n[let]\n\
             drive = \"c*u - k*sin(x) - b*w\"\n[der]\nx = \"w\"\n\
             w = \"drive - friction(w - ({}), drive, T) - (if w > {} then e else 0)\"\n[outputs]\ny = \"x +- 0.1\"\n",
            levels[0].0, levels[1].0,
        );
        let model = read("belt", &text);
        // Where it is at samples, and what is known of that.
        let mut at = [rng.between(-0.5, 0.5), levels[0].0];
        let mut place = Where::On(0);
        let (mut u, mut left, mut time) = (0.0, 0, Decimal::zero());
        let reach = rng.pick(&[1e-3, 0.03, 0.3]);
        let noise = rng.pick(&[1e-3, 0.03]);
        let (mut record, mut seen, mut places) = (Vec::new(), Vec::new(), Vec::new());
        for line in 0..60 + rng.below(140) {
            if left == 0 {
                u = rng.pick(&[0.0, 1.0, -1.0]) * rng.between(0.05, 0.5);
                left = 5 + rng.below(40);
            }
            left -= 1;
            record.push(Sample {
                time: time.clone(),
                inputs: vec![Interval::point(u) * (Interval::ONE + Interval::symmetric(0.1))],
                outputs: vec![Some(Interval::point(at[0]).inflate(0.1))],
                signals: Vec::new(),
                line,
            });
            let off = noise * rng.pick(&[-1.0, 1.0, 0.0]);
            let (lo, hi) = match place {
                Where::On(_) if rng.chance(0.3) => (at[1], at[1]),
                Where::On(_) => {
                    let side = rng.pick(&[[0.0, 1.0], [1.0, 0.0]]);
                    (at[1] - side[0] * reach, at[1] + side[1] * reach)
                }
                // On which side of levels it is may be known.
                Where::Above(below) if rng.chance(0.8) => {
                    let level = |k: usize| levels.get(k).map(|level| level.0);
                    let lo = below.checked_sub(1).and_then(level).unwrap_or(-9.0);
                    let hi = level(below).unwrap_or(9.0);
                    ((at[1] - reach).max(lo), (at[1] + reach).min(hi))
                }
                Where::Above(_) => (at[1] - reach, at[1] + reach),
            };
            seen.push(vec![
                Interval::point(at[0] + off).inflate(noise + 1e-8),
                Interval::new(lo, hi).unwrap(),
            ]);
            places.push((at, place));
            let step = rng.pick(&["0.01", "0.01", "0.025"]);
            let h = Decimal::parse(step).unwrap();
            let parts = 1 + rng.below(2);
            for _ in 0..parts {
                let share = rng.pick(&[-1.0, 1.0, 0.0]) * 0.1 * (1.0 - 1e-9);
                let time = h.to_interval().mid() / parts as f64;
                belt.travel(&mut at, &mut place, u * (1.0 + share), time);
            }
            time = &time + &h;
        }
        let problem = Problem::upright(&model, std::slice::from_ref(&record));
        let mut box_ = problem.believed();
        let share = rng.pick(&[0.5, 0.1, 0.01, 1e-4]);
        for (quantity, truth) in problem.params().zip(truth) {
            let (below, above) = (rng.pick(&[0.0, 1.0]), rng.pick(&[0.0, 0.5, 1.0]));
            let size = share * (truth + 0.1);
            let whole = Interval::new(truth - below * size, truth + above * size).unwrap();
            box_[quantity] = whole.inflate(1e-9).intersect(box_[quantity]);
        }
        let go_on = || true;
        let balances = Balances::of(&model, &problem, std::slice::from_ref(&seen), &box_, &go_on);
        let region = Region::of_box(&box_);
        let mut unknowns = vec![Interval::ZERO; region.axes()];
        for (quantity, truth) in problem.params().zip(truth) {
            if let Some(axis) = region.axes[quantity].iter().position(|x| *x != 0.0) {
                let at = Interval::point(truth) - Interval::point(region.centre[quantity]);
                unknowns[axis] = at / Interval::point(region.axes[quantity][axis]);
            }
        }
        let mut cuts = Cuts::of(&balances.tracks, region.clone());
        cuts.trim();
        for (track, found) in balances.tracks.iter().zip(&cuts.choices) {
            let mut choices = track.choices();
            for ((choice, stop), found) in choices.iter_mut().zip(&track.stops).zip(found) {
                let is_on = |k: usize| matches!(places[k].1, Where::On(_));
                let turns = |k: &usize| is_on(*k) != is_on(*k + 1);
                if let Some(k) = stop.stretches.clone().find(turns) {
                    assert!(
                        found.contains(&k),
                        "{truth:?} {levels:?}: {k} not in {found:?}"
                    );
                    *choice = k..k + 1;
                    stops += 1;
                    resting += stop.stretches.len() - 1;
                }
            }
            for ((x, w), (at, _)) in track.nodes_with(&choices).iter().zip(&places) {
                let is_there = x.inflate(1e-7).contains(at[0]) && w.inflate(1e-7).contains(at[1]);
                assert!(is_there, "{truth:?} {levels:?}: {x} {w} {at:?}");
            }
        }
        let mut rows = Rows::new(region.axes());
        balances.tell(&region, &mut rows);
        for row in 0..rows.len() {
            let slopes = rows.slopes(row).iter().zip(&unknowns);
            let value = slopes.fold(Interval::ZERO, |sum, (slope, x)| {
                sum + Interval::point(*slope) * *x
            });
            let reach: f64 = rows.slopes(row).iter().map(|slope| slope.abs()).sum();
            let outer = rows.outer(row);
            assert!(
                value.inflate(1e-7 * reach).intersects(outer),
                "{truth:?} {levels:?}: {value} {outer}"
            );
            cutting += usize::from(!Interval::symmetric(reach).is_subset_of(outer));
            all += 1;
        }
    }
    println!("trials of belts: {all} rows, cutting {cutting}, stops {stops}, at rest {resting}");
    assert!(all > 500 && stops > 5, "{all} {stops}");
}
