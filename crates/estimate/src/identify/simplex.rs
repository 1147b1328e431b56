//! Linear programs over rows: an unproved vertex, from which proved bounds are made.
//!
//! A dual simplex on the few unknowns: it begins in the corner of the box that is best without any row, and
//! takes in the row that is violated most until none is. All of it is plain floating point and no more than a
//! hint: [`minimum`] turns the multipliers of the last vertex into a bound that holds for whatever
//! multipliers, and the multipliers of an impossible row into a proof that nothing is left.
//!
//! *Theorem* (Neumaier and Shcherbina, 2004). For any numbers `λ`, and every `δ` in the box with `g_k·δ ∈ [b_k]`
//! for all `k`: `d·δ = Σ λ_k (g_k·δ) + (d - Σ λ_k g_k)·δ`, so `d·δ` lies in
//! `Σ λ_k [b_k] + (d - Σ λ_k g_k)·[δ]`. If `0·δ` does not lie in that set for `d = 0`, there is no such `δ`.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: matrices are `n * n`, row by row, vectors `n` long; positions are those of rows"
)]

use super::rows::{Affine, Rows};
use veribound_interval::Interval;

/// Violations below this share of a row's size are none.
const TOLERANCE: f64 = 1e-11;

/// Steps per unknown before the vertex at hand has to do.
const MOST_STEPS: usize = 60;

/// So many rows are looked at more closely at once.
const COLLECTED: usize = 12;

/// Which side of rows a program respects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    /// What must hold where the record is met.
    Outer,
    /// What proves that it is met.
    Inner,
}

/// A vertex, about.
#[derive(Debug, Clone)]
pub(crate) struct Vertex {
    /// Where it is.
    pub(crate) point: Vec<f64>,
    /// Rows with their multipliers.
    pub(crate) multipliers: Vec<(usize, f64)>,
    /// Whether the multipliers belong to a row that nothing satisfies.
    pub(crate) is_impossible: bool,
}

/// One of the constraints that hold a vertex.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Tight {
    Unknown(usize),
    Row(usize),
}

/// Rows that may cut a box, with their bounds as plain numbers.
pub(crate) struct Program<'a> {
    rows: &'a Rows,
    part: &'a [Interval],
    chosen: Vec<usize>,
    bounds: Vec<(f64, f64)>,
    sizes: Vec<f64>,
    /// The slopes of the chosen rows that are not zero, with their unknowns, and where each row's begin.
    sparse: Vec<(usize, f64)>,
    begins: Vec<usize>,
}

impl<'a> Program<'a> {
    /// The rows that may cut the box `part`.
    pub(crate) fn new(rows: &'a Rows, part: &'a [Interval], side: Side) -> Program<'a> {
        let mut program = Program {
            rows,
            part,
            chosen: Vec::new(),
            bounds: Vec::new(),
            sizes: Vec::new(),
            sparse: Vec::new(),
            begins: vec![0],
        };
        let centre: Vec<(f64, f64)> = part.iter().map(|x| (x.mid(), x.rad())).collect();
        for row in 0..rows.len() {
            let slopes = rows.slopes(row);
            let (mut middle, mut reach, mut size) = (0.0, 0.0, 0.0_f64);
            for (slope, (at, radius)) in slopes.iter().zip(&centre) {
                middle += slope * at;
                reach += slope.abs() * radius;
                size += slope.abs();
            }
            let bounds = match side {
                Side::Outer => rows.outer(row),
                Side::Inner => rows.inner(row),
            };
            let (lo, hi) = if bounds.is_empty() {
                (f64::INFINITY, f64::NEG_INFINITY)
            } else {
                (bounds.lo(), bounds.hi())
            };
            if (middle - reach < lo || middle + reach > hi) && size > 0.0 {
                program.chosen.push(row);
                program.bounds.push((lo, hi));
                program.sizes.push(size);
                let entries = slopes.iter().copied().enumerate();
                program
                    .sparse
                    .extend(entries.filter(|(_, slope)| *slope != 0.0));
                program.begins.push(program.sparse.len());
            }
        }
        program
    }

    /// About the least `direction·δ`.
    pub(crate) fn minimize(&self, direction: &[f64]) -> Vertex {
        let n = self.part.len();
        let mut tight: Vec<(Tight, f64)> = Vec::with_capacity(n);
        for (v, d) in direction.iter().enumerate() {
            let sign = if *d < 0.0 { -1.0 } else { 1.0 };
            tight.push((Tight::Unknown(v), sign));
        }
        let mut multipliers = direction.to_vec();
        let mut inverse = vec![0.0; n * n];
        (0..n).for_each(|i| inverse[i * n + i] = 1.0);
        let mut point = vec![0.0; n];
        // Rows that were violated anywhere on the way: most never are, and need not be asked at every step.
        let mut pool: Vec<usize> = Vec::new();
        for _ in 0..MOST_STEPS * (n + 1) {
            self.place(&tight, &inverse, &mut point);
            let mut violated = self.most_violated(&point, &tight, &pool);
            if violated.is_none() && self.collect(&point, &mut pool) {
                violated = self.most_violated(&point, &tight, &pool);
            }
            let Some((entering, sign)) = violated else {
                break;
            };
            // The entering row as a sum of those that hold the vertex.
            let shares = self.shares(entering, &inverse, n);
            let mut leaving: Option<(f64, usize)> = None;
            let largest = shares.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            for (c, share) in shares.iter().enumerate() {
                // A constraint held from below has a multiplier that is not negative.
                let along = sign * share * tight[c].1;
                if along > 1e-10 * largest {
                    let ratio = (multipliers[c] * tight[c].1 / along).max(0.0);
                    let closer = leaving.is_none_or(|(best, other)| {
                        ratio < best || (ratio == best && share.abs() > shares[other].abs())
                    });
                    if closer {
                        leaving = Some((ratio, c));
                    }
                }
            }
            let Some((ratio, q)) = leaving else {
                let others = tight.iter().zip(&shares);
                let mut impossible: Vec<(usize, f64)> = others
                    .filter_map(|((held, _), share)| Some((self.row_of(*held)?, -sign * share)))
                    .collect();
                impossible.extend(self.row_of(entering).map(|row| (row, sign)));
                return Vertex {
                    point,
                    multipliers: impossible,
                    is_impossible: true,
                };
            };
            for (c, share) in shares.iter().enumerate() {
                multipliers[c] -= ratio * sign * share;
            }
            multipliers[q] = ratio * sign;
            tight[q] = (entering, sign);
            for i in 0..n {
                let row = &mut inverse[i * n..(i + 1) * n];
                let pivot = row[q] / shares[q];
                if pivot != 0.0 {
                    let pairs = row.iter_mut().zip(&shares);
                    pairs.for_each(|(x, share)| *x -= pivot * share);
                    row[q] = pivot;
                }
            }
        }
        let held = tight.iter().zip(&multipliers);
        let multipliers = held
            .filter_map(|((held, _), m)| Some((self.row_of(*held)?, *m)))
            .collect();
        Vertex {
            point,
            multipliers,
            is_impossible: false,
        }
    }

    fn row_of(&self, tight: Tight) -> Option<usize> {
        match tight {
            Tight::Row(position) => Some(self.chosen[position]),
            Tight::Unknown(_) => None,
        }
    }

    /// A constraint as a sum of those that hold a vertex, row by row of their inverse, as it lies in memory.
    fn shares(&self, tight: Tight, inverse: &[f64], n: usize) -> Vec<f64> {
        match tight {
            Tight::Unknown(v) => inverse[v * n..(v + 1) * n].to_vec(),
            Tight::Row(position) => {
                let mut shares = vec![0.0; n];
                for (v, slope) in &self.sparse[self.begins[position]..self.begins[position + 1]] {
                    let row = &inverse[v * n..(v + 1) * n];
                    let pairs = shares.iter_mut().zip(row);
                    pairs.for_each(|(share, x)| *share += slope * x);
                }
                shares
            }
        }
    }

    /// Where all these constraints hold with equality.
    fn place(&self, tight: &[(Tight, f64)], inverse: &[f64], point: &mut [f64]) {
        let n = point.len();
        let value = |(held, sign): &(Tight, f64)| {
            let (lo, hi) = match held {
                Tight::Row(position) => self.bounds[*position],
                Tight::Unknown(v) => (self.part[*v].lo(), self.part[*v].hi()),
            };
            if *sign > 0.0 { lo } else { hi }
        };
        let values: Vec<f64> = tight.iter().map(value).collect();
        for (i, x) in point.iter_mut().enumerate() {
            let row = &inverse[i * n..(i + 1) * n];
            *x = row.iter().zip(&values).map(|(m, value)| m * value).sum();
        }
    }

    /// By how much of its size a row is violated, and its side: 1 where it is too small.
    fn violation(&self, position: usize, point: &[f64]) -> (f64, f64) {
        let entries = &self.sparse[self.begins[position]..self.begins[position + 1]];
        let x: f64 = entries.iter().map(|(v, g)| g * point[*v]).sum();
        let (lo, hi) = self.bounds[position];
        outside(x, (lo, hi), self.sizes[position])
    }

    /// The constraint that the point violates most, of all unknowns and the rows in `pool`.
    fn most_violated(
        &self,
        point: &[f64],
        tight: &[(Tight, f64)],
        pool: &[usize],
    ) -> Option<(Tight, f64)> {
        let mut worst = TOLERANCE;
        let mut found = None;
        let mut ask = |held: Tight, (by, sign): (f64, f64)| {
            if by > worst && !tight.contains(&(held, sign)) {
                worst = by;
                found = Some((held, sign));
            }
        };
        for (v, x) in point.iter().enumerate() {
            let bounds = (self.part[v].lo(), self.part[v].hi());
            ask(Tight::Unknown(v), outside(*x, bounds, 1.0));
        }
        for position in pool {
            ask(Tight::Row(*position), self.violation(*position, point));
        }
        found
    }

    /// Takes the rows that the point violates most into the pool, if there are any that are not in it.
    fn collect(&self, point: &[f64], pool: &mut Vec<usize>) -> bool {
        let violations = (0..self.chosen.len()).map(|position| self.violation(position, point).0);
        let mut violated: Vec<(f64, usize)> = violations
            .zip(0..)
            .filter(|(by, position)| *by > TOLERANCE && !pool.contains(position))
            .collect();
        violated.sort_by(|a, b| b.0.total_cmp(&a.0));
        violated.truncate(COLLECTED);
        pool.extend(violated.iter().map(|(_, position)| *position));
        !violated.is_empty()
    }
}

/// By how much of its size a number is outside of bounds, and on which side: 1 where it is too small.
fn outside(x: f64, (lo, hi): (f64, f64), size: f64) -> (f64, f64) {
    let (below, above) = ((lo - x) / size, (x - hi) / size);
    if below >= above {
        (below, 1.0)
    } else {
        (above, -1.0)
    }
}

impl Program<'_> {
    /// Proved bounds of `direction·δ` over the box and the outer rows, which this program must be of; unbounded
    /// where they are lost to rounding.
    pub(crate) fn bounds(&self, direction: &[f64]) -> Interval {
        self.bounds_because(direction).0
    }

    /// Proved bounds of a quantity that is affine in the unknowns, and something between.
    pub(crate) fn around(&self, quantity: &Affine) -> Interval {
        self.bounds(&quantity.slopes) + quantity.rest
    }

    /// The same as [`Program::bounds`], with the rows that hold the lower and the upper bound, each with its multiplier.
    pub(crate) fn bounds_because(&self, direction: &[f64]) -> (Interval, [Vec<(usize, f64)>; 2]) {
        let least = |sign: f64| {
            let direction: Vec<f64> = direction.iter().map(|x| sign * x).collect();
            let vertex = self.minimize(&direction);
            let multipliers = if vertex.is_impossible {
                &[][..]
            } else {
                &vertex.multipliers
            };
            let least = minimum(self.rows, self.part, &direction, multipliers);
            (least, vertex.multipliers)
        };
        let (lo, below) = least(1.0);
        let (hi, above) = least(-1.0);
        let bounds = Interval::new(lo, -hi).unwrap_or(Interval::ENTIRE);
        (bounds, [below, above])
    }
}

/// A proved lower bound of `direction·δ` over the box `part` and the outer rows, from some multipliers.
pub(crate) fn minimum(
    rows: &Rows,
    part: &[Interval],
    direction: &[f64],
    multipliers: &[(usize, f64)],
) -> f64 {
    let sum = combined(rows, part, direction, multipliers);
    if sum.is_empty() {
        f64::INFINITY
    } else {
        sum.lo()
    }
}

/// Whether the multipliers prove that no unknowns of the box `part` satisfy the outer rows.
pub(crate) fn refutes(rows: &Rows, part: &[Interval], multipliers: &[(usize, f64)]) -> bool {
    let zero = vec![0.0; part.len()];
    !combined(rows, part, &zero, multipliers).contains(0.0)
}

/// `Σ λ_k [b_k] + (d - Σ λ_k g_k)·[δ]`.
fn combined(
    rows: &Rows,
    part: &[Interval],
    direction: &[f64],
    multipliers: &[(usize, f64)],
) -> Interval {
    let mut rest: Vec<Interval> = direction.iter().map(|d| Interval::point(*d)).collect();
    let mut sum = Interval::ZERO;
    for (row, multiplier) in multipliers {
        if !multiplier.is_finite() || *multiplier == 0.0 {
            continue;
        }
        let multiplier = Interval::point(*multiplier);
        sum += multiplier * rows.outer(*row);
        for (rest, slope) in rest.iter_mut().zip(rows.slopes(*row)) {
            *rest -= multiplier * Interval::point(*slope);
        }
    }
    let left = rest.iter().zip(part);
    left.fold(sum, |sum, (rest, x)| sum + *rest * *x)
}

/// How far outside of rows, as multiple of half of what they allow, a point may have to be.
const DEEP: f64 = 1024.0;

/// Unknowns, and how far inside of all rows they are.
pub(crate) type Deepest = (Vec<f64>, f64);

/// About the unknowns that are farthest from the ends of all rows, as share of what each allows in the box `part`:
/// inside of them, or where that is not possible, as little outside as can be; and how far that is.
pub(crate) fn deepest(rows: &Rows, part: &[Interval]) -> Deepest {
    let n = part.len();
    let mut sides = Rows::new(n + 1);
    let mut is_used = vec![false; n];
    for row in 0..rows.len() {
        let outer = rows.outer(row);
        let slopes = rows.slopes(row);
        let reach: f64 = slopes
            .iter()
            .zip(part)
            .map(|(g, x)| g.abs() * x.rad())
            .sum();
        let depth = 0.5 * DEEP * outer.width().min(reach);
        for (is_used, slope) in is_used.iter_mut().zip(slopes) {
            *is_used |= *slope != 0.0;
        }
        let half = |lo: f64, hi: f64| Interval::new(lo, hi).unwrap_or(Interval::ENTIRE);
        let both = [
            (half(outer.lo(), f64::INFINITY), -depth),
            (half(f64::NEG_INFINITY, outer.hi()), depth),
        ];
        for (side, depth) in both.into_iter().filter(|side| side.0 != Interval::ENTIRE) {
            sides.push(&[slopes, &[depth]].concat(), Interval::ZERO, side, 0, 0);
        }
    }
    let mut whole = part.to_vec();
    whole.push(Interval::symmetric(1.0));
    let mut direction = vec![0.0; n + 1];
    direction[n] = -1.0;
    let vertex = Program::new(&sides, &whole, Side::Outer).minimize(&direction);
    let mut point = vertex.point;
    let depth = point.pop().unwrap_or(f64::NEG_INFINITY);
    // An unknown that no row depends on is anywhere.
    for (v, x) in point.iter_mut().enumerate().filter(|(v, _)| !is_used[*v]) {
        *x = part[v].mid();
    }
    (point, depth)
}
