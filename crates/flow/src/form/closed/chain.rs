//! The matrix exponential, by scaling and squaring.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: matrices are `n * n`, row by row; there is a level as long as there is a chain"
)]

use super::super::monomials::Monomials;
use super::super::outward::raised;
use super::value::{Matrix, image, product};
use std::sync::OnceLock;
use veribound_interval::Interval;

/// Orders of the series on the shortest level.
const ORDERS: usize = 13;

/// The shortest level is so long that `A` times its length has at most this norm.
const SHORT: f64 = 0.125;

/// Halvings at most.
const MOST: usize = 48;

/// What is below this share of the size of `Φ` is not looked at more closely, nor more parts than this.
const LITTLE: f64 = 0.002;
const PARTS: usize = 4096;

/// Rounds in which the units of states are balanced.
const BALANCING: usize = 16;

/// `exp(A s)` and `Φ(s) = ∫_0^s exp(A r) dr` for one time `s` and for all times up to it.
pub(super) struct Level {
    /// The time.
    pub(super) length: f64,
    /// `exp(A length)`, and bounds for all unknowns.
    pub(super) flow: Matrix,
    pub(super) end: Vec<Interval>,
    /// `Φ(length)`, and bounds for all unknowns.
    pub(super) integral: Matrix,
    moved: Vec<Interval>,
    pub(super) during: During,
    /// Bounds of `∫_0^length |exp(A r)| dr`, once they are asked for.
    reach: OnceLock<Vec<f64>>,
}

/// What holds at all times up to some time, for all unknowns.
pub(super) struct During {
    /// Of `exp(A s)`.
    pub(super) flow: Vec<Interval>,
    /// Of `Φ(s)`.
    pub(super) moving: Vec<Interval>,
}

/// Levels, each twice as long as the one before.
pub(super) struct Chain {
    /// `A`, and bounds for all unknowns.
    pub(super) slopes: Matrix,
    pub(super) steep: Vec<Interval>,
    /// The longest level that has finite numbers is the last one.
    pub(super) levels: Vec<Level>,
    /// How often the length asked for was halved.
    pub(super) halvings: usize,
    pub(super) sizes: Sizes,
}

/// `|A|` for all unknowns, and a norm that is small for it.
pub(super) struct Sizes {
    n: usize,
    sizes: Vec<f64>,
    pub(super) weights: Vec<f64>,
    /// `max_i Σ_l |A|_il weights_l / weights_i`, from above.
    norm: f64,
    /// Whether there is a way of more than `ORDERS` slopes from one state to another.
    endless: Vec<bool>,
}

impl Chain {
    /// `None` if `A` is too steep for so long, or not bounded.
    pub(super) fn new(slopes: Matrix, length: f64, monomials: &Monomials) -> Option<Chain> {
        let sizes = Sizes::of(&slopes);
        let mut halvings = 0;
        let mut unit = length;
        if !sizes.norm.is_finite() {
            return None;
        }
        while sizes.norm * unit > SHORT {
            halvings += 1;
            unit *= 0.5;
            if halvings > MOST {
                return None;
            }
        }
        if unit <= 1e-200 {
            return None;
        }
        let steep = slopes.hull();
        let first = sizes.first((&slopes, &steep), unit, monomials);
        let mut chain = Chain {
            slopes,
            steep,
            levels: vec![first],
            halvings,
            sizes,
        };
        while chain.levels.len() <= halvings {
            let next = chain.levels[chain.levels.len() - 1].doubled(monomials);
            if next.flow.is_lost() || next.integral.is_lost() {
                break;
            }
            chain.levels.push(next);
        }
        Some(chain)
    }

    /// Bounds of what rates that are off by at most `rates` at all times can move the states in the time of a level.
    pub(super) fn gathered(&self, number: usize, rates: &[f64]) -> Vec<f64> {
        if rates.iter().all(|rate| *rate == 0.0) {
            return vec![0.0; rates.len()];
        }
        let reach = self.levels[number].reach.get_or_init(|| {
            let n = rates.len();
            let mut identity = vec![Interval::ZERO; n * n];
            for i in 0..n {
                identity[i * n + i] = Interval::ONE;
            }
            let mut little = vec![0.0_f64; n * n];
            for level in &self.levels[..=number] {
                for (little, moved) in little.iter_mut().zip(&level.moved) {
                    *little = little.max(LITTLE * moved.mag());
                }
            }
            self.reached((number, &identity), &little, &mut 0)
        });
        let rows = reach.chunks_exact(rates.len());
        rows.map(|row| above(row, rates)).collect()
    }

    /// Bounds of `∫ |exp(A r) m| dr` over the time of a level, by entries, where parts of at most `little` are not looked
    /// at more closely.
    ///
    /// Proof. An entry that keeps its sign has the integral of its absolute value in `|Φ m|`. Any other is at most its
    /// largest value times the length, and at most what both halves give, of which the second begins at
    /// `exp(A length / 2) m`.
    fn reached(
        &self,
        (number, m): (usize, &[Interval]),
        little: &[f64],
        parts: &mut usize,
    ) -> Vec<f64> {
        let (n, level) = (self.slopes.n, &self.levels[number]);
        let flow = product(n, &level.during.flow, m);
        let moved = product(n, &level.moved, m);
        let mut is_open = false;
        let mut found: Vec<f64> = flow
            .iter()
            .zip(moved)
            .zip(little)
            .map(|((flow, moved), little)| {
                if flow.lo() >= 0.0 || flow.hi() <= 0.0 {
                    return moved.mag();
                }
                let most = raised(flow.mag() * level.length, 1);
                is_open |= most > *little;
                most
            })
            .collect();
        *parts += 1;
        if is_open && number > 0 && *parts < PARTS {
            let half = &self.levels[number - 1];
            let later = product(n, &half.end, m);
            let first = self.reached((number - 1, m), little, parts);
            let second = self.reached((number - 1, &later), little, parts);
            for (own, (first, second)) in found.iter_mut().zip(first.iter().zip(second)) {
                *own = own.min(if first + second == 0.0 {
                    0.0
                } else {
                    raised(first + second, 1)
                });
            }
        }
        found
    }

    /// Bounds for all times up to `length`, which is at most that of the shortest level.
    pub(super) fn short(&self, length: f64) -> During {
        self.sizes.short(&self.steep, length).0
    }
}

impl Sizes {
    fn of(slopes: &Matrix) -> Sizes {
        let n = slopes.n;
        let sizes: Vec<f64> = slopes.entries.iter().map(|x| x.size()).collect();
        let (weights, norm) = balanced(n, &sizes);
        let pattern: Vec<bool> = sizes.iter().map(|x| *x != 0.0).collect();
        let mut endless = pattern.clone();
        for _ in 0..ORDERS {
            endless = walks(n, &endless, &pattern);
        }
        // Any further ones: longer walks of at most n steps more reach all there is.
        for _ in 0..n {
            let more = walks(n, &endless, &pattern);
            endless
                .iter_mut()
                .zip(more)
                .for_each(|(own, more)| *own |= more);
        }
        Sizes {
            n,
            sizes,
            weights,
            norm,
            endless,
        }
    }

    /// Bounds of what the series `Σ (A t)^k / (k + 1)!` has beyond its orders.
    ///
    /// Proof. With `|A t| w <= θ w` in every component, `(|A t|^k)_il w_l <= (|A t|^k w)_i <= θ^k w_i`; and
    /// `Σ_{k > K} θ^k / (k + 1)! <= θ^(K+1) / ((K + 2)! (1 - θ))`. Where no walk of more than `K` slopes leads from
    /// `l` to `i` all these powers are zero there.
    fn beyond(&self, t: f64) -> Vec<f64> {
        let n = self.n;
        let theta = raised(self.norm * t, 1);
        let mut share = 1.0 / (1.0 - theta).max(0.25);
        for _ in 0..=ORDERS {
            share = raised(share * theta, 2);
        }
        for k in 1..=ORDERS + 2 {
            share = raised(share / k as f64, 2);
        }
        let entry = |k: usize| match self.endless[k] {
            true => raised(share * self.weights[k / n] / self.weights[k % n], 3),
            false => 0.0,
        };
        (0..n * n).map(entry).collect()
    }

    /// Bounds for all times up to `length`, and the norm `Σ_{k >= 1} |A length|^k / (k + 1)!` by entries.
    ///
    /// `Φ(s) = s (1 + Σ_{k >= 1} (A s)^k / (k + 1)!)` and `exp(A s) = 1 + A Φ(s)`.
    fn short(&self, steep: &[Interval], length: f64) -> (During, Vec<f64>) {
        let n = self.n;
        let mut sum = vec![0.0; n * n];
        for k in (1..=ORDERS).rev() {
            let mut next = vec![0.0; n * n];
            for i in 0..n {
                for m in (0..n).filter(|m| self.sizes[i * n + m] != 0.0) {
                    let factor = self.sizes[i * n + m] * length / (k + 1) as f64;
                    for l in 0..n {
                        let one = if m == l { 1.0 } else { 0.0 };
                        next[i * n + l] += factor * (one + sum[m * n + l]);
                    }
                }
            }
            for x in next.iter_mut().filter(|x| **x != 0.0) {
                *x = raised(*x, n + 4);
            }
            sum = next;
        }
        for (x, more) in sum.iter_mut().zip(self.beyond(length)) {
            if more > 0.0 {
                *x = raised(*x + more, 1);
            }
        }
        let time = Interval::new(0.0, length).unwrap_or(Interval::ENTIRE);
        let moving: Vec<Interval> = (0..n * n)
            .map(|k| {
                let one = if k % (n + 1) == 0 {
                    Interval::ONE
                } else {
                    Interval::ZERO
                };
                if sum[k] == 0.0 {
                    time * one
                } else {
                    time * (one + Interval::symmetric(sum[k]))
                }
            })
            .collect();
        let mut flow = product(n, steep, &moving);
        for i in 0..n {
            flow[i * n + i] += Interval::ONE;
        }
        (During { flow, moving }, sum)
    }

    /// The shortest level.
    fn first(
        &self,
        (slopes, steep): (&Matrix, &[Interval]),
        length: f64,
        monomials: &Monomials,
    ) -> Level {
        let n = self.n;
        let scaled = slopes.times_float(length);
        let mut series = Matrix::zero(n).plus_identity();
        for k in (1..=ORDERS).rev() {
            let factor = scaled.times(&series, monomials);
            series = factor.divided((k + 1) as f64).plus_identity();
        }
        for (entry, more) in series.entries.iter_mut().zip(self.beyond(length)) {
            *entry = entry.clone().widened(more);
        }
        let flow = scaled.times(&series, monomials).plus_identity();
        let integral = series.times_float(length);
        let (during, _) = self.short(steep, length);
        Level {
            length,
            end: flow.hull(),
            moved: integral.hull(),
            flow,
            integral,
            during,
            reach: OnceLock::new(),
        }
    }
}

impl Level {
    /// The level of twice the time: `exp(2 A t) = exp(A t)^2`, `Φ(2 t) = Φ(t) + exp(A t) Φ(t)`; and at the times
    /// `t + s` of the second half the same with `s` for one of the two.
    fn doubled(&self, monomials: &Monomials) -> Level {
        let n = self.flow.n;
        let flow = self.flow.times(&self.flow, monomials);
        let integral = self
            .integral
            .plus(&self.flow.times(&self.integral, monomials));
        let later = product(n, &self.end, &self.during.flow);
        let further = product(n, &self.end, &self.during.moving);
        let both = self.during.flow.iter().zip(later);
        let moving = self.during.moving.iter().zip(&self.moved).zip(further);
        Level {
            length: 2.0 * self.length,
            end: flow.hull(),
            moved: integral.hull(),
            flow,
            integral,
            during: During {
                flow: both.map(|(first, second)| first.hull(second)).collect(),
                moving: moving
                    .map(|((first, moved), second)| first.hull(*moved + second))
                    .collect(),
            },
            reach: OnceLock::new(),
        }
    }

    /// Bounds of `exp(A length)` times a vector whose entries are at most `x` in size.
    pub(super) fn carried(&self, x: &[f64]) -> Vec<f64> {
        let rows = self.end.chunks_exact(self.flow.n);
        rows.map(|row| {
            let sizes: Vec<f64> = row.iter().map(|a| a.mag()).collect();
            above(&sizes, x)
        })
        .collect()
    }
}

impl During {
    /// Where a vector in `x` is at these times.
    pub(super) fn carry(&self, x: &[Interval]) -> Vec<Interval> {
        image(x.len(), &self.flow, x)
    }

    /// How far a velocity in `v` at the start moves states.
    pub(super) fn moves(&self, v: &[Interval]) -> Vec<Interval> {
        image(v.len(), &self.moving, v)
    }
}

/// Weights `w`, and an upper bound of `max_i Σ_l sizes_il w_l / w_i`, near the spectral radius of a matrix that is not
/// negative: that for weights near the eigenvector of Perron, which make it least. Any weights are right.
pub(in super::super) fn balanced(n: usize, sizes: &[f64]) -> (Vec<f64>, f64) {
    let mut weights = vec![1.0; n];
    for _ in 0..BALANCING {
        let rows = sizes.chunks_exact(n);
        let product: Vec<f64> = rows
            .map(|row| row.iter().zip(&weights).map(|(a, w)| a * w).sum())
            .collect();
        let ratios = product.iter().zip(&weights).map(|(x, w)| x / w);
        let shift = 0.5 * ratios.fold(0.0, f64::max) + 1e-300;
        let shifted = product.iter().zip(&weights).map(|(x, w)| x + shift * w);
        let shifted: Vec<f64> = shifted.collect();
        let largest = shifted.iter().fold(1e-300, |most: f64, x| most.max(*x));
        for (w, x) in weights.iter_mut().zip(shifted) {
            *w = (x / largest).max(1e-12);
        }
    }
    let ratios = sizes.chunks_exact(n).zip(&weights).map(|(row, own)| {
        let sum: f64 = row.iter().zip(&weights).map(|(a, w)| a * w).sum();
        if sum == 0.0 {
            0.0
        } else {
            raised(sum / own, n + 2)
        }
    });
    let norm = ratios.fold(
        0.0,
        |most: f64, x| if x > most || x.is_nan() { x } else { most },
    );
    (weights, norm)
}

/// An upper bound of a sum of products of numbers that are not negative.
fn above(a: &[f64], x: &[f64]) -> f64 {
    let sum: f64 = a.iter().zip(x).map(|(a, x)| a * x).sum();
    if sum == 0.0 && a.iter().zip(x).all(|(a, x)| *a == 0.0 || *x == 0.0) {
        return 0.0;
    }
    raised(sum, a.len() + 1)
}

/// Where a walk of `first`, then one step of `second`, leads.
fn walks(n: usize, first: &[bool], second: &[bool]) -> Vec<bool> {
    (0..n * n)
        .map(|k| (0..n).any(|m| first[k / n * n + m] && second[m * n + k % n]))
        .collect()
}
