//! Linear programs over rows: an unproved vertex, from which proved bounds are made.
//!
//! A dual simplex on the few unknowns: it begins in the corner of the box that is best without any row, and
//! takes in the row that is violated most until none is. What holds the last vertex is kept for the next direction:
//! all constraints have two ends, so that each is held at the one that is best for it, and what is violated then is
//! taken in. All of it is plain floating point and no more than a hint: [`minimum`] turns the multipliers of the last
//! vertex into a bound that holds for whatever multipliers, and the multipliers of an impossible row into a proof that
//! nothing is left.
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

/// Shares and multipliers below this share of the largest one are none.
const NEGLIGIBLE: f64 = 1e-10;

/// A vertex from which another program begins is where it should be up to this share of a row's size.
const LOST: f64 = 1e-9;

/// A number of a proof is an interval, which takes about so many times as long.
const PROOF: usize = 8;

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

/// What holds a vertex, each constraint at its lower end (1) or its upper one (-1).
#[derive(Debug, Clone)]
struct Basis {
    tight: Vec<(Tight, f64)>,
    /// The inverse of their slopes, row by row for each unknown.
    inverse: Vec<f64>,
}

/// Rows that may cut a box, with their bounds as plain numbers.
pub(crate) struct Program<'a> {
    rows: &'a Rows,
    part: Vec<Interval>,
    /// What holds the vertex that was found last.
    basis: Option<Basis>,
    /// Rows that were violated anywhere on the way: most never are, and need not be asked at every step.
    pool: Vec<usize>,
    is_pooled: Vec<bool>,
    chosen: Vec<usize>,
    bounds: Vec<(f64, f64)>,
    sizes: Vec<f64>,
    /// The slopes of the chosen rows that are not zero, with their unknowns, and where each row's begin.
    sparse: Vec<(usize, f64)>,
    begins: Vec<usize>,
    /// Numbers that were looked at since somebody asked.
    work: usize,
}

impl<'a> Program<'a> {
    /// The rows that may cut the box `part`.
    pub(crate) fn new(rows: &'a Rows, part: &[Interval], side: Side) -> Program<'a> {
        let mut program = Program {
            rows,
            part: part.to_vec(),
            basis: None,
            pool: Vec::new(),
            is_pooled: Vec::new(),
            chosen: Vec::new(),
            bounds: Vec::new(),
            sizes: Vec::new(),
            sparse: Vec::new(),
            begins: vec![0],
            work: rows.len() * part.len(),
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
        program.is_pooled = vec![false; program.chosen.len()];
        program
    }

    /// Goes on with a box of which one unknown is narrower.
    pub(crate) fn narrow(&mut self, unknown: usize, part: Interval) {
        self.part[unknown] = part;
    }

    /// Numbers that were looked at since this was asked last, those of proofs of what was found included: what it took, about.
    pub(crate) fn took(&mut self) -> f64 {
        std::mem::take(&mut self.work) as f64
    }

    /// About the least `direction·δ`.
    pub(crate) fn minimize(&mut self, direction: &[f64]) -> Vertex {
        let n = self.part.len();
        self.work += PROOF * n * (n + 1);
        let mut point = vec![0.0; n];
        if n == 0 {
            // Nothing is unknown.
            return Vertex {
                point,
                multipliers: Vec::new(),
                is_impossible: false,
            };
        }
        let kept = self.basis.take();
        let kept = kept.and_then(|basis| self.turned(basis, direction, &mut point));
        let (mut basis, mut multipliers) =
            kept.unwrap_or_else(|| self.corner(direction, &mut point));
        let (mut shares, mut ratios) = (vec![0.0; n], Vec::with_capacity(n));
        for _ in 0..MOST_STEPS * (n + 1) {
            self.work += (self.pool.len() + 4 * n) * n;
            let mut violated = self.most_violated(&point, &basis.tight);
            if violated.is_none() && self.collect(&point) {
                violated = self.most_violated(&point, &basis.tight);
            }
            let Some((entering, sign, by)) = violated else {
                break;
            };
            // The entering row as a sum of those that hold the vertex.
            self.write_shares(entering, &basis.inverse, &mut shares);
            ratios.clear();
            let left = self.leaving(
                &mut basis.tight,
                (&multipliers, &shares),
                (sign, by),
                &mut ratios,
            );
            let Some((q, ratio)) = left else {
                let others = basis.tight.iter().zip(&shares);
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
            basis.tight[q] = (entering, sign);
            for row in basis.inverse.chunks_exact_mut(n) {
                let pivot = row[q] / shares[q];
                if pivot != 0.0 {
                    let pairs = row.iter_mut().zip(&shares);
                    pairs.for_each(|(x, share)| *x -= pivot * share);
                    row[q] = pivot;
                }
            }
            self.place(&basis, &mut point);
        }
        // One of the other sign is rounding, and that end may be infinite.
        let held = basis.tight.iter().zip(&multipliers);
        let held = held.filter(|((_, sign), m)| *m * sign > 0.0);
        let multipliers = held
            .filter_map(|((held, _), m)| Some((self.row_of(*held)?, *m)))
            .collect();
        self.basis = Some(basis);
        Vertex {
            point,
            multipliers,
            is_impossible: false,
        }
    }

    /// The corner of the box that is best for a direction, and the multipliers of its sides.
    fn corner(&self, direction: &[f64], point: &mut [f64]) -> (Basis, Vec<f64>) {
        let n = direction.len();
        let sign = |d: f64| if d < 0.0 { -1.0 } else { 1.0 };
        let tight = direction.iter().enumerate();
        let mut basis = Basis {
            tight: tight.map(|(v, d)| (Tight::Unknown(v), sign(*d))).collect(),
            inverse: vec![0.0; n * n],
        };
        (0..n).for_each(|i| basis.inverse[i * n + i] = 1.0);
        self.place(&basis, point);
        (basis, direction.to_vec())
    }

    /// The constraints that held a vertex, each at the end that is best for another direction, and their multipliers.
    ///
    /// Nothing where one has no such end, or the vertex is not where it should be: the inverse lost its digits.
    fn turned(
        &self,
        mut basis: Basis,
        direction: &[f64],
        point: &mut [f64],
    ) -> Option<(Basis, Vec<f64>)> {
        let n = direction.len();
        let mut multipliers = vec![0.0; n];
        for (d, row) in direction.iter().zip(basis.inverse.chunks_exact(n)) {
            if *d != 0.0 {
                let pairs = multipliers.iter_mut().zip(row);
                pairs.for_each(|(m, x)| *m += d * x);
            }
        }
        let largest = multipliers.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        for ((held, sign), m) in basis.tight.iter_mut().zip(&mut multipliers) {
            if m.abs() <= NEGLIGIBLE * largest {
                *m = 0.0;
            } else if *m * *sign < 0.0 {
                *sign = -*sign;
            }
            if !self.end(*held, *sign).is_finite() {
                return None;
            }
        }
        self.place(&basis, point);
        let is_there = |(held, sign): &(Tight, f64)| {
            let (at, size) = match held {
                Tight::Unknown(v) => (point[*v], 1.0),
                Tight::Row(position) => (self.value(*position, point), self.sizes[*position]),
            };
            (at - self.end(*held, *sign)).abs() <= LOST * size
        };
        basis
            .tight
            .iter()
            .all(is_there)
            .then_some((basis, multipliers))
    }

    /// Which constraint leaves the vertex for one that is violated `by` so much, and what the multiplier of that becomes; nothing
    /// where no point of the box satisfies it.
    ///
    /// As the multiplier grows, others become zero one by one. Where the other end of such a constraint is not far enough
    /// to satisfy the entering one, it goes over to that, and the multiplier grows on.
    fn leaving(
        &self,
        tight: &mut [(Tight, f64)],
        (multipliers, shares): (&[f64], &[f64]),
        (sign, by): (f64, f64),
        ratios: &mut Vec<(f64, usize)>,
    ) -> Option<(usize, f64)> {
        let largest = shares.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        for (c, share) in shares.iter().enumerate() {
            // A constraint held from below has a multiplier that is not negative.
            let along = sign * share * tight[c].1;
            if along > NEGLIGIBLE * largest {
                let ratio = (multipliers[c] * tight[c].1 / along).max(0.0);
                ratios.push((ratio, c));
            }
        }
        ratios.sort_unstable_by(|(a, c), (b, l)| {
            let by_share = shares[*l].abs().total_cmp(&shares[*c].abs());
            a.total_cmp(b).then(by_share).then(c.cmp(l))
        });
        let mut left = by;
        for (ratio, c) in ratios.iter() {
            let (held, own) = tight[*c];
            let reach = (self.end(held, -own) - self.end(held, own)).abs();
            left -= shares[*c].abs() * reach;
            if left <= TOLERANCE * by {
                return Some((*c, *ratio));
            }
            tight[*c].1 = -own;
        }
        None
    }

    /// The lower end of a constraint (1), or its upper one (-1).
    fn end(&self, tight: Tight, sign: f64) -> f64 {
        let (lo, hi) = match tight {
            Tight::Row(position) => self.bounds[position],
            Tight::Unknown(v) => (self.part[v].lo(), self.part[v].hi()),
        };
        if sign > 0.0 { lo } else { hi }
    }

    fn row_of(&self, tight: Tight) -> Option<usize> {
        match tight {
            Tight::Row(position) => Some(self.chosen[position]),
            Tight::Unknown(_) => None,
        }
    }

    /// A constraint as a sum of those that hold a vertex, row by row of their inverse, as it lies in memory.
    fn write_shares(&self, tight: Tight, inverse: &[f64], shares: &mut [f64]) {
        let n = shares.len();
        match tight {
            Tight::Unknown(v) => shares.copy_from_slice(&inverse[v * n..(v + 1) * n]),
            Tight::Row(position) => {
                shares.fill(0.0);
                for (v, slope) in &self.sparse[self.begins[position]..self.begins[position + 1]] {
                    let row = &inverse[v * n..(v + 1) * n];
                    let pairs = shares.iter_mut().zip(row);
                    pairs.for_each(|(share, x)| *share += slope * x);
                }
            }
        }
    }

    /// Where all these constraints hold with equality.
    fn place(&self, basis: &Basis, point: &mut [f64]) {
        let ends = basis
            .tight
            .iter()
            .map(|(held, sign)| self.end(*held, *sign));
        let ends: Vec<f64> = ends.collect();
        for (x, row) in point.iter_mut().zip(basis.inverse.chunks_exact(ends.len())) {
            *x = row.iter().zip(&ends).map(|(m, end)| m * end).sum();
        }
    }

    /// The value of a row at a point.
    fn value(&self, position: usize, point: &[f64]) -> f64 {
        let entries = &self.sparse[self.begins[position]..self.begins[position + 1]];
        entries.iter().map(|(v, g)| g * point[*v]).sum()
    }

    /// By how much of its size a row is violated, and its side: 1 where it is too small.
    fn violation(&self, position: usize, point: &[f64]) -> (f64, f64) {
        let x = self.value(position, point);
        outside(x, self.bounds[position], self.sizes[position])
    }

    /// The constraint that the point violates most, of all unknowns and the rows in the pool, its side, and by how much.
    fn most_violated(&self, point: &[f64], tight: &[(Tight, f64)]) -> Option<(Tight, f64, f64)> {
        let mut worst = TOLERANCE;
        let mut found = None;
        let mut ask = |held: Tight, (by, sign): (f64, f64), size: f64| {
            if by > worst && !tight.contains(&(held, sign)) {
                worst = by;
                found = Some((held, sign, by * size));
            }
        };
        for (v, x) in point.iter().enumerate() {
            let bounds = (self.part[v].lo(), self.part[v].hi());
            ask(Tight::Unknown(v), outside(*x, bounds, 1.0), 1.0);
        }
        for &position in &self.pool {
            let violation = self.violation(position, point);
            ask(Tight::Row(position), violation, self.sizes[position]);
        }
        found
    }

    /// Takes the rows that the point violates most into the pool, if there are any that are not in it.
    fn collect(&mut self, point: &[f64]) -> bool {
        self.work += self.chosen.len() * point.len();
        let others = (0..self.chosen.len()).filter(|position| !self.is_pooled[*position]);
        let violations = others.map(|position| (self.violation(position, point).0, position));
        let mut violated: Vec<(f64, usize)> =
            violations.filter(|(by, _)| *by > TOLERANCE).collect();
        let order = |a: &(f64, usize), b: &(f64, usize)| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
        if violated.len() > COLLECTED {
            violated.select_nth_unstable_by(COLLECTED, order);
            violated.truncate(COLLECTED);
        }
        violated.sort_unstable_by(order);
        for (_, position) in &violated {
            self.is_pooled[*position] = true;
            self.pool.push(*position);
        }
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
    pub(crate) fn bounds(&mut self, direction: &[f64]) -> Interval {
        self.bounds_because(direction).0
    }

    /// Proved bounds of a quantity that is affine in the unknowns, and something between.
    pub(crate) fn around(&mut self, quantity: &Affine) -> Interval {
        self.bounds(&quantity.slopes) + quantity.rest
    }

    /// The same as [`Program::bounds`], with the rows that hold the lower and the upper bound, each with its multiplier.
    pub(crate) fn bounds_because(
        &mut self,
        direction: &[f64],
    ) -> (Interval, [Vec<(usize, f64)>; 2]) {
        let mut least = |sign: f64| {
            let direction: Vec<f64> = direction.iter().map(|x| sign * x).collect();
            let vertex = self.minimize(&direction);
            let multipliers = if vertex.is_impossible {
                &[][..]
            } else {
                &vertex.multipliers
            };
            let least = minimum(self.rows, &self.part, &direction, multipliers);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers in [-1, 1] (Marsaglia's xorshift).
    struct Draw(u64);

    impl Draw {
        fn next(&mut self) -> f64 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }

        /// Rows around a point of the box, some of them with one end; maybe with one that it does not satisfy.
        fn rows(&mut self, n: usize, count: usize, is_possible: bool) -> Rows {
            let at: Vec<f64> = (0..n).map(|_| 0.9 * self.next()).collect();
            let mut rows = Rows::new(n);
            for k in 0..count {
                let slopes: Vec<f64> = (0..n)
                    .map(|_| if self.next() < -0.4 { 0.0 } else { self.next() })
                    .collect();
                let value: f64 = slopes.iter().zip(&at).map(|(g, x)| g * x).sum();
                let mut lo = value - 0.3 * self.next().abs();
                let mut hi = value + 0.3 * self.next().abs();
                match k % 4 {
                    0 => lo = f64::NEG_INFINITY,
                    1 => hi = f64::INFINITY,
                    _ => {}
                }
                if !is_possible && k == count - 1 {
                    let reach: f64 = slopes.iter().map(|g| g.abs()).sum();
                    (lo, hi) = (1.01 * reach, 2.0 * reach + 1.0);
                }
                let told = Interval::new(lo, hi).unwrap_or(Interval::ENTIRE);
                rows.push(&slopes, Interval::ZERO, told, k, 0);
            }
            rows
        }
    }

    /// The least `direction·δ` over all vertices of the box and the rows, that satisfy all.
    fn least(rows: &Rows, part: &[Interval], direction: &[f64]) -> f64 {
        let mut planes: Vec<(Vec<f64>, f64)> = Vec::new();
        for v in 0..3 {
            let mut slopes = vec![0.0; 3];
            slopes[v] = 1.0;
            planes.push((slopes.clone(), part[v].lo()));
            planes.push((slopes, part[v].hi()));
        }
        for row in 0..rows.len() {
            for end in [rows.outer(row).lo(), rows.outer(row).hi()] {
                if end.is_finite() {
                    planes.push((rows.slopes(row).to_vec(), end));
                }
            }
        }
        let cross = |a: &[f64], b: &[f64]| -> Vec<f64> {
            vec![
                a[1] * b[2] - a[2] * b[1],
                a[2] * b[0] - a[0] * b[2],
                a[0] * b[1] - a[1] * b[0],
            ]
        };
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(x, y)| x * y).sum() };
        let mut least = f64::INFINITY;
        for (i, (a, ka)) in planes.iter().enumerate() {
            for (l, (b, kb)) in planes.iter().enumerate().skip(i + 1) {
                for (c, kc) in &planes[l + 1..] {
                    let det = dot(a, &cross(b, c));
                    if det.abs() < 1e-9 {
                        continue;
                    }
                    let (bc, ca, ab) = (cross(b, c), cross(c, a), cross(a, b));
                    let at: Vec<f64> = (0..3)
                        .map(|v| (ka * bc[v] + kb * ca[v] + kc * ab[v]) / det)
                        .collect();
                    let is_met = |(x, y): (f64, Interval)| y.inflate(1e-9).contains(x);
                    let in_box = at.iter().copied().zip(part.iter().copied()).all(is_met);
                    let in_rows = (0..rows.len())
                        .map(|row| (dot(rows.slopes(row), &at), rows.outer(row)))
                        .all(is_met);
                    if in_box && in_rows {
                        least = least.min(dot(direction, &at));
                    }
                }
            }
        }
        least
    }

    /// One program after another from where the last one ended, with unknowns that become narrower: each finds what all
    /// vertices tell, and its proved bound is there.
    #[test]
    fn programs_in_a_row_find_the_best_vertex() {
        let mut draw = Draw(0x51_3d);
        for round in 0..40 {
            let rows = draw.rows(3, 3 + round % 9, true);
            let mut part = vec![Interval::symmetric(1.0); 3];
            let mut program = Program::new(&rows, &part, Side::Outer);
            for turn in 0..12 {
                let direction = match turn % 3 {
                    0 => vec![draw.next(), draw.next(), draw.next()],
                    1 => vec![0.0, if turn % 2 == 0 { 1.0 } else { -1.0 }, 0.0],
                    _ => vec![draw.next(), 0.0, draw.next()],
                };
                let exact = least(&rows, &part, &direction);
                let vertex = program.minimize(&direction);
                assert!(!vertex.is_impossible);
                let proved = minimum(&rows, &part, &direction, &vertex.multipliers);
                assert!(proved <= exact + 1e-8, "{proved} {exact}");
                assert!(proved >= exact - 1e-8, "{proved} {exact}, {round} {turn}");
                // What is narrower holds from now on.
                let v = turn % 3;
                let mut unit = vec![0.0; 3];
                unit[v] = 1.0;
                let (lo, hi) = (least(&rows, &part, &unit), {
                    let down: Vec<f64> = unit.iter().map(|x| -x).collect();
                    -least(&rows, &part, &down)
                });
                if let Some(narrower) = Interval::new(lo, hi).filter(|_| turn > 3) {
                    part[v] = part[v].intersect(narrower.inflate(1e-6));
                    program.narrow(v, part[v]);
                }
            }
        }
    }

    /// Rows that leave nothing are refuted, whatever was asked before.
    #[test]
    fn what_nothing_satisfies_is_refuted() {
        let mut draw = Draw(0x77_01);
        for round in 0..40 {
            let n = 2 + round % 7;
            let rows = draw.rows(n, 20, round % 2 == 0);
            let part = vec![Interval::symmetric(1.0); n];
            let mut program = Program::new(&rows, &part, Side::Outer);
            for _ in 0..4 {
                let direction: Vec<f64> = (0..n).map(|_| draw.next()).collect();
                let vertex = program.minimize(&direction);
                let refuted = vertex.is_impossible && refutes(&rows, &part, &vertex.multipliers);
                assert_eq!(refuted, round % 2 == 1);
            }
        }
    }

    /// Bounds from where the last program ended are those from a corner of the box.
    #[test]
    fn where_a_program_begins_makes_no_difference() {
        let mut draw = Draw(0x2f_19);
        for n in [2, 6, 17, 40] {
            let rows = draw.rows(n, 30 * n, true);
            let part = vec![Interval::symmetric(1.0); n];
            let mut program = Program::new(&rows, &part, Side::Outer);
            for v in 0..n {
                let mut direction = vec![0.0; n];
                direction[v] = 1.0;
                let warm = program.bounds(&direction);
                let cold = Program::new(&rows, &part, Side::Outer).bounds(&direction);
                let near = |a: f64, b: f64| (a - b).abs() <= 1e-8;
                assert!(
                    near(warm.lo(), cold.lo()) && near(warm.hi(), cold.hi()),
                    "{warm} {cold}"
                );
            }
        }
    }
}
