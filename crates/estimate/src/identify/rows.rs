//! Rows: what samples say about the unknowns, as two-sided linear inequalities.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: every row has one slope per unknown, and one entry in each list"
)]

use std::cmp::Ordering;

use serde::{Deserialize, Serialize};
use veribound_flow::form::Strip;
use veribound_interval::Interval;
use veribound_interval::round::{sub_down, sub_up};

/// Rows that several samples say together have this for a sample.
pub(crate) const SEVERAL: usize = u32::MAX as usize - 1;

/// Two-sided inequalities `g·δ ∈ [b]` in unknowns `δ` of the unit box. The last of these may be products of two others.
///
/// Guarantee: for every solution that agrees with the record, and its unknowns `δ`, `g·δ` lies in
/// [`Rows::outer`]. If `g·δ` lies in [`Rows::inner`], every solution with these unknowns agrees with the sample
/// that the row is from, whatever inputs and rounding do; of samples that may be outliers there is a choice that
/// inner rows leave out.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Rows {
    unknowns: usize,
    /// The last of the unknowns are the products of these.
    products: Vec<(usize, usize)>,
    slopes: Vec<f64>,
    outer: Vec<Interval>,
    inner: Vec<Interval>,
    /// Sample and record.
    origins: Vec<(u32, u32)>,
}

impl Rows {
    pub(crate) fn new(unknowns: usize) -> Rows {
        Rows {
            unknowns,
            ..Rows::default()
        }
    }

    /// Rows in unknowns and products of these.
    pub(crate) fn with_products(unknowns: usize, products: Vec<(usize, usize)>) -> Rows {
        Rows {
            unknowns: unknowns + products.len(),
            products,
            ..Rows::default()
        }
    }

    /// Number of unknowns, products included.
    pub(crate) fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Number of unknowns that are no products.
    pub(crate) fn plain(&self) -> usize {
        self.unknowns - self.products.len()
    }

    pub(crate) fn products(&self) -> &[(usize, usize)] {
        &self.products
    }

    /// The box of the unknowns.
    pub(crate) fn whole(&self) -> Vec<Interval> {
        let plain = (0..self.plain()).map(|_| Interval::symmetric(1.0));
        plain.chain(self.products.iter().map(range_of)).collect()
    }

    pub(crate) fn len(&self) -> usize {
        self.outer.len()
    }

    pub(crate) fn slopes(&self, row: usize) -> &[f64] {
        &self.slopes[row * self.unknowns..(row + 1) * self.unknowns]
    }

    /// What `g·δ` must be where the record is met.
    pub(crate) fn outer(&self, row: usize) -> Interval {
        self.outer[row]
    }

    /// Where `g·δ` proves that the record is met; maybe empty.
    pub(crate) fn inner(&self, row: usize) -> Interval {
        self.inner[row]
    }

    /// The sample and the record a row is from.
    pub(crate) fn origin(&self, row: usize) -> (usize, usize) {
        let (sample, record) = self.origins[row];
        (sample as usize, record as usize)
    }

    /// Adds what a sample says: the quantity `rest + g·δ`, with any value of `rest`, is in `measured`.
    pub(crate) fn push(
        &mut self,
        slopes: &[f64],
        rest: Interval,
        measured: Interval,
        sample: usize,
        record: usize,
    ) {
        self.slopes.extend_from_slice(slopes);
        self.outer.push(measured - rest);
        self.inner.push(shrunk(measured, rest));
        self.origins.push((short(sample), short(record)));
    }

    /// Adds what several samples say together: `g·δ` is in `bounds`.
    pub(crate) fn push_outer(&mut self, slopes: &[f64], bounds: Interval) {
        self.slopes.extend_from_slice(slopes);
        self.outer.push(bounds);
        self.inner.push(Interval::ENTIRE);
        self.origins.push((short(SEVERAL), 0));
    }

    /// Adds what a point must meet, though others need not: the quantity `rest + g·δ` is in `measured`.
    pub(crate) fn push_inner(
        &mut self,
        slopes: &[f64],
        rest: Interval,
        measured: Interval,
        sample: usize,
    ) {
        self.slopes.extend_from_slice(slopes);
        self.outer.push(Interval::ENTIRE);
        self.inner.push(shrunk(measured, rest));
        self.origins.push((short(sample), 0));
    }

    /// Adds a row in other unknowns: its outer and inner bounds are of sums to which there is something to be added, for the
    /// outer ones any of the first, for the inner ones whatever of the second.
    pub(crate) fn push_moved(
        &mut self,
        slopes: &[f64],
        (wide, narrow): (Interval, Interval),
        (outer, inner): (Interval, Interval),
        (sample, record): (usize, usize),
    ) {
        self.slopes.extend_from_slice(slopes);
        self.outer.push(outer - wide);
        self.inner.push(shrunk(inner, narrow));
        self.origins.push((short(sample), short(record)));
    }

    /// Adds rows in some of the unknowns, of which `kept` tells the positions, from another record.
    pub(crate) fn take(&mut self, other: &Rows, kept: &[usize], record: usize) {
        for row in 0..other.len() {
            let begin = self.slopes.len();
            self.slopes.resize(begin + self.unknowns, 0.0);
            for (axis, slope) in kept.iter().zip(other.slopes(row)) {
                self.slopes[begin + axis] = *slope;
            }
            self.outer.push(other.outer[row]);
            self.inner.push(other.inner[row]);
            self.origins.push((other.origins[row].0, short(record)));
        }
    }

    /// Goes over to other unknowns `δ'` of the unit box: `δ_i = middle_i + radius_i δ'_i`, with some numbers
    /// of these intervals.
    pub(crate) fn rescale(&mut self, scales: &[(Interval, Interval)]) {
        let same = (Interval::ZERO, Interval::ONE);
        if scales.iter().all(|scale| *scale == same) {
            return;
        }
        for row in 0..self.len() {
            let slopes = &mut self.slopes[row * self.unknowns..(row + 1) * self.unknowns];
            let moved = rescale(slopes, &self.products, scales);
            self.outer[row] -= moved;
            self.inner[row] = shrunk(self.inner[row], moved);
        }
    }

    /// Leaves out the rows that say nothing about the unit box.
    pub(crate) fn prune(&mut self) {
        self.retain(|rows, row| {
            let reach: f64 = rows.slopes(row).iter().map(|g| g.abs()).sum();
            let reach = Interval::symmetric(reach * (1.0 + 1e-12));
            !(reach.is_subset_of(rows.inner[row]) && reach.is_subset_of(rows.outer[row]))
        });
    }

    /// Leaves out the rows of which another one with the same slopes says no less by its outer bounds; what inner bounds say is lost.
    pub(crate) fn leave_out_implied(&mut self) {
        let by_slopes = |a: &usize, b: &usize| {
            let pairs = self.slopes(*a).iter().zip(self.slopes(*b));
            let mut orders = pairs.map(|(x, y)| x.total_cmp(y));
            orders
                .find(|order| order.is_ne())
                .unwrap_or(Ordering::Equal)
        };
        let mut order: Vec<usize> = (0..self.len()).collect();
        order.sort_by(by_slopes);
        let mut is_kept = vec![false; self.len()];
        for same in order.chunk_by(|a, b| by_slopes(a, b).is_eq()) {
            // The first of them where several are alike.
            let lo = |row: &&usize| self.outer[**row].lo();
            let hi = |row: &&usize| self.outer[**row].hi();
            let lower = same.iter().rev().max_by(|a, b| lo(a).total_cmp(&lo(b)));
            let upper = same.iter().min_by(|a, b| hi(a).total_cmp(&hi(b)));
            lower
                .into_iter()
                .chain(upper)
                .for_each(|row| is_kept[*row] = true);
        }
        self.retain(|_, row| is_kept[row]);
    }

    /// Leaves out all rows but those that are wanted: what holds for some goes on to hold.
    pub(crate) fn retain(&mut self, is_wanted: impl Fn(&Rows, usize) -> bool) {
        let unknowns = self.unknowns;
        let mut kept = 0;
        for row in 0..self.len() {
            if !is_wanted(self, row) {
                continue;
            }
            if kept < row {
                self.slopes
                    .copy_within(row * unknowns..(row + 1) * unknowns, kept * unknowns);
                self.outer[kept] = self.outer[row];
                self.inner[kept] = self.inner[row];
                self.origins[kept] = self.origins[row];
            }
            kept += 1;
        }
        self.truncate(kept);
    }

    /// Leaves out all rows but the first.
    pub(crate) fn truncate(&mut self, kept: usize) {
        self.slopes.truncate(kept * self.unknowns);
        self.outer.truncate(kept);
        self.inner.truncate(kept);
        self.origins.truncate(kept);
    }
}

fn short(position: usize) -> u32 {
    u32::try_from(position).unwrap_or(u32::MAX)
}

/// A quantity that is an affine function of the unknowns, and something between.
#[derive(Debug, Clone)]
pub(crate) struct Affine {
    pub(crate) slopes: Vec<f64>,
    pub(crate) rest: Interval,
}

impl From<Strip> for Affine {
    fn from(strip: Strip) -> Affine {
        Affine {
            rest: strip.remainder + Interval::point(strip.centre),
            slopes: strip.slopes,
        }
    }
}

impl Affine {
    /// A strip with its products as unknowns.
    pub(crate) fn curved(strip: Strip) -> Affine {
        Affine {
            rest: strip.rest + Interval::point(strip.centre),
            slopes: [strip.slopes, strip.products].concat(),
        }
    }
}

impl Affine {
    /// In other unknowns, as [`Rows::rescale`]; the last slopes are those of these products, if there are any.
    pub(crate) fn rescale(&mut self, products: &[(usize, usize)], scales: &[(Interval, Interval)]) {
        let moved = rescale(&mut self.slopes, products, scales);
        self.rest += moved;
    }
}

/// What a sample tells when its error may be any of so many times as large: `middle + factor [-error, error]`.
///
/// What was read is rounded; so much more and less is taken that both sides stay proved.
#[derive(Debug)]
pub(crate) struct Scaled<'a> {
    middle: Interval,
    error: Interval,
    factor: &'a Affine,
}

/// What reading a measurement and its error can round away, as share of the measurement.
pub(crate) const READ: f64 = 1.0 / ((1_u64 << 44) as f64);

/// A measurement whose error is so many times as large.
pub(crate) fn widened(told: Interval, times: f64) -> Interval {
    let factor = Affine {
        slopes: Vec::new(),
        rest: Interval::point(times),
    };
    Scaled::of(told, &factor).map_or(told, |scaled| scaled.largest())
}

impl Scaled<'_> {
    /// Nothing where the measurement has no error, or no end.
    pub(crate) fn of(told: Interval, factor: &Affine) -> Option<Scaled<'_>> {
        if !told.is_bounded() || told.width() == 0.0 {
            return None;
        }
        let (middle, error) = told.mid_rad();
        let read = told.mag() * READ;
        Some(Scaled {
            middle: Interval::point(middle).inflate(read),
            error: Interval::point(error).inflate(read),
            factor,
        })
    }

    fn reach(&self) -> Interval {
        let slopes = self.factor.slopes.iter();
        let reach: f64 = slopes.map(|g| g.abs()).sum();
        self.factor.rest + Interval::symmetric(reach * (1.0 + 1e-12))
    }

    /// What it tells with the largest factor.
    pub(crate) fn largest(&self) -> Interval {
        let most = self.error.hi() * self.reach().hi().max(0.0);
        self.middle + Interval::symmetric(most * (1.0 + 1e-12))
    }

    /// That `g·δ + rest` is at most so far below, and above: slopes, rest and what that must be, twice.
    ///
    /// With `factor = f·δ + r` and an error `e` the first is `(g - e f)·δ + rest - e r - middle <= 0`; products are
    /// rounded, and what they lost is in the rest.
    pub(crate) fn rows(
        &self,
        slopes: &[f64],
        rest: Interval,
    ) -> [(Vec<f64>, Interval, Interval); 2] {
        let unit = Interval::symmetric(1.0);
        let row = |sign: f64| {
            let error = Interval::point(sign) * self.error;
            let mut own = rest - self.middle + error * self.factor.rest;
            let slopes = slopes.iter().zip(&self.factor.slopes).map(|(g, f)| {
                let exact = Interval::point(*g) + error * Interval::point(*f);
                let rounded = exact.mid();
                own += (exact - Interval::point(rounded)) * unit;
                rounded
            });
            let slopes: Vec<f64> = slopes.collect();
            let side = if sign < 0.0 {
                Interval::new(f64::NEG_INFINITY, 0.0)
            } else {
                Interval::new(0.0, f64::INFINITY)
            };
            (slopes, own, side.unwrap_or(Interval::ENTIRE))
        };
        [row(-1.0), row(1.0)]
    }
}

/// Writes slopes for unknowns `δ_i = middle_i + radius_i δ'_i`, and for products of these; encloses what is to be added.
///
/// Proof. `g·δ = g·m + (g r)·δ'`, and the product `g r` is rounded to `g'`; what it lost, times `δ'` of the
/// unit box, is added to `g·m`. A product is `δ_i δ_j = m_i m_j + m_j r_i δ'_i + m_i r_j δ'_j + r_i r_j δ'_i δ'_j`.
fn rescale(
    slopes: &mut [f64],
    products: &[(usize, usize)],
    scales: &[(Interval, Interval)],
) -> Interval {
    let same = |scale: &(Interval, Interval)| *scale == (Interval::ZERO, Interval::ONE);
    let unit = Interval::symmetric(1.0);
    let mut moved = Interval::ZERO;
    let (slopes, curved) = slopes.split_at_mut(scales.len());
    // What products add to slopes.
    let mut added: Vec<Interval> = Vec::new();
    for (slope, (i, j)) in curved.iter_mut().zip(products) {
        let (left, right) = (scales[*i], scales[*j]);
        if *slope == 0.0 || same(&left) && same(&right) {
            continue;
        }
        added.resize(scales.len(), Interval::ZERO);
        let old = Interval::point(*slope);
        moved += old * left.0 * right.0;
        added[*i] += old * right.0 * left.1;
        added[*j] += old * left.0 * right.1;
        let product = old * left.1 * right.1;
        let rounded = product.mid();
        moved += (product - Interval::point(rounded)) * unit;
        *slope = rounded;
    }
    for (v, (slope, scale)) in slopes.iter_mut().zip(scales).enumerate() {
        let added = added.get(v).copied().unwrap_or(Interval::ZERO);
        if added == Interval::ZERO && (*slope == 0.0 || same(scale)) {
            continue;
        }
        let old = Interval::point(*slope);
        let sum = old * scale.1 + added;
        let rounded = sum.mid();
        moved += old * scale.0;
        moved += (sum - Interval::point(rounded)) * unit;
        *slope = rounded;
    }
    moved
}

/// The values of a product of two unknowns of the unit box.
fn range_of((i, j): &(usize, usize)) -> Interval {
    let unit = Interval::symmetric(1.0);
    if i == j {
        unit.intersect(Interval::new(0.0, 1.0).unwrap_or(unit))
    } else {
        unit
    }
}

/// Where tangents touch the squares that they bound.
const TANGENTS: [f64; 5] = [-1.0, -0.5, 0.0, 0.5, 1.0];

/// Products with slopes below this share of what a row allows are not unknowns of linear programs.
pub(crate) const SLIGHT: f64 = 0.02;

impl Rows {
    /// The products that tell something.
    pub(crate) fn notable(&self) -> Vec<(usize, usize)> {
        let plain = self.plain();
        let is_notable = |position: &usize| {
            (0..self.len()).any(|row| {
                let slope = self.slopes(row)[plain + position].abs();
                slope > SLIGHT * self.outer[row].width()
            })
        };
        let positions = (0..self.products.len()).filter(is_notable);
        positions.map(|position| self.products[position]).collect()
    }

    /// Adds rows in some of the unknowns, as [`Rows::take`], with those of their products that these rows have; others are
    /// something between.
    pub(crate) fn take_curved(&mut self, other: &Rows, kept: &[usize], record: usize) {
        let places = self.places(&other.products, kept);
        let plain = other.plain();
        for row in 0..other.len() {
            let begin = self.slopes.len();
            self.slopes.resize(begin + self.unknowns, 0.0);
            let (straight, curved) = other.slopes(row).split_at(plain);
            for (axis, slope) in kept.iter().zip(straight) {
                self.slopes[begin + axis] = *slope;
            }
            let mut rest = Interval::ZERO;
            for ((slope, place), product) in curved.iter().zip(&places).zip(&other.products) {
                match place {
                    Some(place) => self.slopes[begin + place] = *slope,
                    None if *slope == 0.0 => {}
                    None => rest += Interval::point(*slope) * range_of(product),
                }
            }
            self.outer.push(other.outer[row] - rest);
            self.inner.push(shrunk(other.inner[row], rest));
            self.origins.push((other.origins[row].0, short(record)));
        }
    }

    /// An affine function of unknowns and products, in the unknowns of these rows, as [`Rows::take_curved`].
    pub(crate) fn adopt(
        &self,
        affine: &Affine,
        products: &[(usize, usize)],
        kept: &[usize],
    ) -> Affine {
        let mut slopes = vec![0.0; self.unknowns];
        let mut rest = affine.rest;
        let (straight, curved) = affine.slopes.split_at(affine.slopes.len() - products.len());
        for (axis, slope) in kept.iter().zip(straight) {
            slopes[*axis] = *slope;
        }
        let places = self.places(products, kept);
        for ((slope, place), product) in curved.iter().zip(places).zip(products) {
            match place {
                Some(place) => slopes[place] = *slope,
                None if *slope == 0.0 => {}
                None => rest += Interval::point(*slope) * range_of(product),
            }
        }
        Affine { slopes, rest }
    }

    /// Where products of unknowns that are `kept` here stand.
    fn places(&self, products: &[(usize, usize)], kept: &[usize]) -> Vec<Option<usize>> {
        let place = |(i, j): &(usize, usize)| {
            let pair = in_order(kept[*i], kept[*j]);
            let position = self.products.iter().position(|own| *own == pair)?;
            Some(self.plain() + position)
        };
        products.iter().map(place).collect()
    }

    /// Adds what bounds products by their factors: the planes through the corners of the unit box (McCormick, 1976), and
    /// tangents of squares.
    pub(crate) fn bound_products(&mut self, origin: usize) {
        let plain = self.plain();
        let half = |lo: f64| Interval::new(lo, f64::INFINITY).unwrap_or(Interval::ENTIRE);
        for (position, (i, j)) in self.products.clone().into_iter().enumerate() {
            let mut slopes = vec![0.0; self.unknowns];
            slopes[plain + position] = 1.0;
            if i == j {
                // `(x - a)² >= 0`
                for at in TANGENTS {
                    slopes[i] = -2.0 * at;
                    self.push(&slopes, Interval::ZERO, half(-at * at), origin, 0);
                }
                continue;
            }
            // `(1 ± x)(1 ± y) >= 0`
            for (left, right) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                slopes[plain + position] = left * right;
                slopes[i] = left;
                slopes[j] = right;
                self.push(&slopes, Interval::ZERO, half(-1.0), origin, 0);
            }
        }
    }

    /// The same rows with the products that tell something, and what bounds these; without any, no products are unknowns.
    pub(crate) fn curved(&self, origin: usize) -> Rows {
        let every: Vec<usize> = (0..self.plain()).collect();
        let mut rows = Rows::with_products(self.plain(), self.notable());
        rows.take_curved(self, &every, 0);
        for (own, old) in rows.origins.iter_mut().zip(&self.origins) {
            *own = *old;
        }
        rows.bound_products(origin);
        rows
    }
}

/// A pair, the smaller first.
pub(crate) fn in_order(a: usize, b: usize) -> (usize, usize) {
    (a.min(b), a.max(b))
}

/// All numbers `x` with `x + rest` inside `whole`, whatever `rest` is: rounded inward.
pub(crate) fn shrunk(whole: Interval, rest: Interval) -> Interval {
    if whole.is_empty() || rest.is_empty() {
        return Interval::EMPTY;
    }
    let lo = sub_up(whole.lo(), rest.lo());
    let hi = sub_down(whole.hi(), rest.hi());
    Interval::new(lo, hi).unwrap_or(Interval::EMPTY)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn interval(lo: f64, hi: f64) -> Interval {
        Interval::new(lo, hi).unwrap_or(Interval::EMPTY)
    }

    #[test]
    fn outer_is_wider_and_inner_narrower() {
        let mut rows = Rows::new(1);
        rows.push(&[0.1], interval(0.3, 0.4), interval(0.0, 1.0), 0, 0);
        assert!(rows.outer(0).lo() <= -0.4 && rows.outer(0).hi() >= 0.7);
        assert!(rows.inner(0).lo() >= -0.3 && rows.inner(0).hi() <= 0.6);
        rows.push(&[0.1], interval(0.0, 2.0), interval(0.0, 1.0), 1, 0);
        rows.push(
            &[0.1],
            interval(0.0, 2.0),
            interval(f64::NEG_INFINITY, 1.0),
            2,
            0,
        );
        assert_eq!(
            (rows.inner(2), rows.outer(2)),
            (
                interval(f64::NEG_INFINITY, -1.0),
                interval(f64::NEG_INFINITY, 1.0)
            )
        );
        assert!(rows.inner(1).is_empty());
    }

    /// Whatever the unknowns, a row in new ones says no more than before outside, and no less inside.
    #[test]
    fn rows_in_new_unknowns_mean_the_same() {
        let third = Interval::ONE / Interval::point(3.0);
        let scales = [
            (Interval::point(0.2), third),
            (Interval::ZERO, Interval::ONE),
        ];
        let mut rows = Rows::new(2);
        for at in [[-1.0, -0.5], [0.2, 0.9], [1.0, 1.0], [0.3, -1.0]] {
            let old = (scales[0].0 + third * Interval::point(at[0]), at[1]);
            let value = Interval::point(0.3) * old.0 + Interval::point(-0.7 * old.1);
            // A measurement that ends just there.
            rows.push(
                &[0.3, -0.7],
                Interval::ZERO,
                interval(value.hi(), 2.0),
                0,
                0,
            );
            rows.push(
                &[0.3, -0.7],
                Interval::ZERO,
                interval(-2.0, value.lo()),
                0,
                0,
            );
        }
        rows.rescale(&scales);
        for (k, at) in [[-1.0, -0.5], [0.2, 0.9], [1.0, 1.0], [0.3, -1.0]]
            .iter()
            .enumerate()
        {
            for row in [2 * k, 2 * k + 1] {
                let g = rows.slopes(row);
                let value = Interval::point(g[0]) * Interval::point(at[0])
                    + Interval::point(g[1]) * Interval::point(at[1]);
                assert!(
                    value.intersects(rows.outer(row)),
                    "{value} {}",
                    rows.outer(row)
                );
                assert!(rows.inner(row).is_subset_of(rows.outer(row)));
            }
        }
    }

    /// A sum of slopes times unknowns and their products, at some unknowns.
    fn value(rows: &Rows, row: usize, at: &[f64]) -> Interval {
        let products = rows.products().iter();
        let products = products.map(|(i, j)| Interval::point(at[*i]) * Interval::point(at[*j]));
        let all = at.iter().map(|x| Interval::point(*x)).chain(products);
        let terms = rows.slopes(row).iter().zip(all);
        terms.fold(Interval::ZERO, |sum, (g, x)| sum + Interval::point(*g) * x)
    }

    /// Unknowns that satisfy a row with products satisfy it in new unknowns, with those products alone that tell something,
    /// without any, and beside what bounds products; sharp rows cut off the others.
    #[test]
    fn rows_with_products_mean_the_same() {
        let mut state = 7_u64;
        let mut draw = |from: f64, to: f64| {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            from + (to - from) * (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let products = vec![(0, 0), (0, 1), (1, 1), (0, 2), (2, 2)];
        let mut cut = 0;
        for _ in 0..2000 {
            let scales: Vec<(Interval, Interval)> = (0..3)
                .map(|_| {
                    let middle = draw(-0.5, 0.5);
                    (Interval::point(middle), Interval::point(draw(0.01, 0.5)))
                })
                .collect();
            let new: Vec<f64> = (0..3).map(|_| draw(-1.0, 1.0)).collect();
            let old: Vec<Interval> = scales
                .iter()
                .zip(&new)
                .map(|((middle, radius), x)| *middle + *radius * Interval::point(*x))
                .collect();
            let mut rows = Rows::with_products(3, products.clone());
            // Some products are too slight to be unknowns.
            let slight = [1.0, 1e-3, 0.0];
            let slopes: Vec<f64> = (0..8)
                .map(|k| draw(-1.0, 1.0) * if k > 5 { slight[k % 3] } else { 1.0 })
                .collect();
            let squares = products.iter().map(|(i, j)| old[*i] * old[*j]);
            let all = old.iter().copied().chain(squares);
            let sum = slopes.iter().zip(all);
            let sum = sum.fold(Interval::ZERO, |sum, (g, x)| sum + Interval::point(*g) * x);
            let narrow = draw(1e-3, 0.1);
            rows.push(
                &slopes,
                Interval::ZERO,
                interval(sum.lo(), sum.hi() + narrow),
                3,
                0,
            );
            let beyond = interval(sum.lo() - narrow, sum.lo() - 1e-12);
            rows.push(&slopes, Interval::ZERO, beyond, 4, 0);
            rows.rescale(&scales);
            assert!(value(&rows, 0, &new).intersects(rows.outer(0)));
            assert!(!value(&rows, 1, &new).is_subset_of(rows.outer(1)));
            assert!(!value(&rows, 1, &new).intersects(rows.inner(1)));
            let curved = rows.curved(9);
            assert_eq!(curved.origin(0), (3, 0));
            cut += usize::from(curved.products().len() < products.len());
            for row in (0..curved.len()).filter(|row| *row != 1) {
                let value = value(&curved, row, &new);
                assert!(value.inflate(1e-14).intersects(curved.outer(row)), "{row}");
            }
            let mut flat = Rows::new(4);
            flat.take_curved(&rows, &[3, 0, 2], 5);
            let at = [new[1], 0.0, new[2], new[0]];
            assert!(value(&flat, 0, &at).intersects(flat.outer(0)));
            assert!(!value(&flat, 1, &at).intersects(flat.inner(1)));
            let mut joint = Rows::with_products(4, vec![(0, 3), (3, 3)]);
            joint.take_curved(&rows, &[3, 0, 2], 5);
            assert!(value(&joint, 0, &at).intersects(joint.outer(0)));
            let affine = Affine {
                slopes: rows.slopes(0).to_vec(),
                rest: Interval::ZERO,
            };
            let adopted = joint.adopt(&affine, rows.products(), &[3, 0, 2]);
            let mut alone = Rows::with_products(4, joint.products().to_vec());
            alone.push(&adopted.slopes, adopted.rest, rows.outer(0), 0, 0);
            assert!(value(&alone, 0, &at).intersects(alone.outer(0)));
        }
        assert!(cut > 100, "{cut}");
    }

    /// Of rows with the same slopes those are kept that say most, and others stay as they are.
    #[test]
    fn rows_that_others_imply_are_left_out() {
        let mut rows = Rows::new(2);
        let told = [
            ([0.1, 0.2], (-0.2, 0.2)),
            ([0.1, 0.3], (-0.9, 0.9)),
            ([0.1, 0.2], (-0.1, 0.4)),
            ([0.1, 0.2], (-0.3, 0.1)),
            ([0.1, 0.2], (-0.1, 0.1)),
            ([0.1, 0.2], (-0.1, 0.1)),
            ([0.1, 0.3], (-0.2, 1.0)),
        ];
        for (k, (slopes, (lo, hi))) in told.into_iter().enumerate() {
            rows.push(&slopes, Interval::ZERO, interval(lo, hi), k, 0);
        }
        let before = rows.clone();
        rows.leave_out_implied();
        let kept: Vec<usize> = (0..rows.len()).map(|row| rows.origin(row).0).collect();
        assert_eq!(kept, [1, 2, 3, 6]);
        for (row, origin) in kept.into_iter().enumerate() {
            assert_eq!(rows.outer(row), before.outer(origin));
            assert_eq!(rows.slopes(row), before.slopes(origin));
        }
        // The bounds of all together are the same.
        for slopes in [[0.1, 0.2], [0.1, 0.3]] {
            let all = |rows: &Rows| {
                let same = (0..rows.len()).filter(|row| *rows.slopes(*row) == slopes);
                same.fold(Interval::ENTIRE, |all, row| all.intersect(rows.outer(row)))
            };
            assert_eq!(all(&rows), all(&before));
        }
    }

    #[test]
    fn rows_that_cut_nothing_are_left_out() {
        let mut rows = Rows::new(1);
        rows.push(&[0.1], Interval::ZERO, interval(-0.2, 0.2), 7, 0);
        rows.push(&[0.1], Interval::ZERO, interval(-0.2, 0.05), 8, 0);
        rows.prune();
        assert_eq!((rows.len(), rows.origin(0)), (1, (8, 0)));
    }
}
