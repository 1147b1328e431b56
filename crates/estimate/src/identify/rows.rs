//! Rows: what samples say about the unknowns, as two-sided linear inequalities.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: every row has one slope per unknown, and one entry in each list"
)]

use serde::{Deserialize, Serialize};
use veribound_flow::form::Strip;
use veribound_interval::Interval;
use veribound_interval::round::{sub_down, sub_up};

/// Rows that several samples say together have this for a sample.
pub(crate) const SEVERAL: usize = u32::MAX as usize - 1;

/// Two-sided inequalities `g·δ ∈ [b]` in unknowns `δ` of the unit box.
///
/// Guarantee: for every solution that agrees with the record, and its unknowns `δ`, `g·δ` lies in
/// [`Rows::outer`]. If `g·δ` lies in [`Rows::inner`], every solution with these unknowns agrees with the sample
/// that the row is from, whatever inputs and rounding do; of samples that may be outliers there is a choice that
/// inner rows leave out.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Rows {
    unknowns: usize,
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

    /// Number of unknowns.
    pub(crate) fn unknowns(&self) -> usize {
        self.unknowns
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
            let moved = rescale(slopes, scales);
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
    /// In other unknowns, as [`Rows::rescale`].
    pub(crate) fn rescale(&mut self, scales: &[(Interval, Interval)]) {
        let moved = rescale(&mut self.slopes, scales);
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

/// Writes slopes for unknowns `δ_i = middle_i + radius_i δ'_i`; encloses what is to be added.
///
/// Proof. `g·δ = g·m + (g r)·δ'`, and the product `g r` is rounded to `g'`; what it lost, times `δ'` of the
/// unit box, is added to `g·m`.
fn rescale(slopes: &mut [f64], scales: &[(Interval, Interval)]) -> Interval {
    let unit = Interval::symmetric(1.0);
    let mut moved = Interval::ZERO;
    for (slope, (middle, radius)) in slopes.iter_mut().zip(scales) {
        if *slope == 0.0 || (*middle == Interval::ZERO && *radius == Interval::ONE) {
            continue;
        }
        let old = Interval::point(*slope);
        let product = old * *radius;
        let rounded = product.mid();
        moved += old * *middle;
        moved += (product - Interval::point(rounded)) * unit;
        *slope = rounded;
    }
    moved
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

    #[test]
    fn rows_that_cut_nothing_are_left_out() {
        let mut rows = Rows::new(1);
        rows.push(&[0.1], Interval::ZERO, interval(-0.2, 0.2), 7, 0);
        rows.push(&[0.1], Interval::ZERO, interval(-0.2, 0.05), 8, 0);
        rows.prune();
        assert_eq!((rows.len(), rows.origin(0)), (1, (8, 0)));
    }
}
