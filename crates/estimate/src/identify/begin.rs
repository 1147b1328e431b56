//! Where a search begins: a point far from any that is known.
//!
//! Coarse samples do not narrow sets that are so wide that forms of them come no farther than a few samples. A point is
//! cheap all the same: a form that is next to nothing goes through the whole record, and tells slopes. From the middle of a
//! prior a course is fitted to the begin of all records first, then to twice as much, and so on: what agrees with the first half is
//! not far from what agrees with all, while a course from anywhere has no more to do with the end of a record than
//! any other one. Nothing of this proves anything: the point is a hint, and a small set around it is proved.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one entry per axis of the region"
)]

use super::cell::{Cell, least_within};
use super::pass::GoOn;
use super::problem::{Course, Problem};
use super::region::Region;
use super::rows::Rows;
use super::told::Told;

/// So many points are begun from.
const STARTS: usize = 4;

/// Those beside the middle are in this share of the region.
const SPREAD: f64 = 0.6;

/// The first begin of a record has about so many samples, and each is so many times as long as the one before.
const SHORTEST: f64 = 48.0;
const LONGER: f64 = 2.0;

/// Sets around the point that are tried, the largest first, as shares of the region; smaller ones around a point that is to be least.
const AROUND: [f64; 4] = [1e-2, 1e-3, 1e-4, 1e-6];
const NEAR: [f64; 2] = [1e-4, 1e-6];

/// A point is lowered in so many steps at most, of this share of the region at first, until one brings no more than this share of what is
/// left.
const STEPS: usize = 24;
const TRUST: f64 = 0.5;
const ARRIVED: f64 = 1e-3;

/// From one end of an axis to the other.
const WHOLE: f64 = 2.0;

/// A point is put back so much farther than rows ask for.
const MORE: f64 = 1e-9;

impl Problem {
    /// A small set around a point of a region at which all records agree, with points in it that are proved to do so, about
    /// where each of `wanted` is least and largest there, and the share of the region that it has.
    ///
    /// Where errors have a factor, it is one with about the least, as far as one is found from here.
    pub(crate) fn begin(
        &self,
        region: &Region,
        wanted: &[Told],
        go_on: &GoOn<'_>,
    ) -> Option<(Cell, Vec<Vec<f64>>, f64)> {
        let mut point = self.fitted(region, go_on)?;
        let mut around = &AROUND[..];
        if let Some(factor) = self.factor_position() {
            point = self.lowered(region, point, factor, go_on);
            around = &NEAR[..];
        }
        around.iter().find_map(|reach| {
            let reaches = vec![*reach; point.len()];
            let cell = self.probe(region, &point, &reaches, go_on)?;
            let points = cell.points(wanted);
            // As for fits, its passes are not counted.
            let cell = Cell { passes: 0, ..cell };
            (!points.is_empty()).then_some((cell, points, *reach))
        })
    }

    /// A point with a smaller factor of errors, which is an axis of the region.
    fn lowered(
        &self,
        region: &Region,
        mut point: Vec<f64>,
        factor: usize,
        go_on: &GoOn<'_>,
    ) -> Vec<f64> {
        let axis = region.axes[factor].iter().position(|slope| *slope > 0.0);
        let (Some(axis), Some((_, mut rows))) = (axis, self.linear(region, &point, 1.0, go_on))
        else {
            return point;
        };
        let mut trust = TRUST;
        for _ in 0..STEPS {
            let step = lowest(&rows, axis, trust);
            let mut next: Vec<f64> = point.iter().zip(&step).map(|(x, by)| x + by).collect();
            let mut found = self.linear(region, &next, 1.0, go_on);
            // What is not affine asks for a larger factor than rows do.
            if let Some((_, own)) = found.as_ref().filter(|(depth, _)| *depth <= 0.0)
                && let Some(more) = needed(own, axis)
            {
                next[axis] += more + MORE;
                found = self.linear(region, &next, 1.0, go_on);
            }
            let is_lower = next[axis] < point[axis];
            match found.filter(|(depth, _)| is_lower && *depth > 0.0) {
                Some((_, own)) => {
                    let gain = point[axis] - next[axis];
                    let others = step.iter().enumerate().filter(|(own, _)| *own != axis);
                    let is_near = others.into_iter().all(|(_, x)| x.abs() < 0.9 * trust);
                    (point, rows) = (next, own);
                    trust *= 2.0;
                    if is_near && gain < ARRIVED * (1.0 + point[axis]) {
                        break;
                    }
                }
                None => trust *= 0.5,
            }
            if trust < ARRIVED {
                break;
            }
        }
        point
    }

    /// A point at which all records agree, as far as that is seen without proof.
    fn fitted(&self, region: &Region, go_on: &GoOn<'_>) -> Option<Vec<f64>> {
        let ends = self.courses.iter().map(Course::end);
        let longest = ends.max().unwrap_or(0) as f64;
        let mut shares = vec![1.0];
        let mut share = 1.0 / LONGER;
        while share * longest >= SHORTEST {
            shares.push(share);
            share /= LONGER;
        }
        (0..STARTS).find_map(|start| {
            let mut begins = shares.iter().rev();
            begins.try_fold(spread(start, region.axes()), |point, share| {
                self.fit(region, &point, *share, go_on)
            })
        })
    }
}

/// About the step to where an unknown is least of what all rows leave; no other one goes farther than `trust`.
fn lowest(rows: &Rows, axis: usize, trust: f64) -> Vec<f64> {
    let reach = |own: usize| if own == axis { WHOLE } else { trust };
    let reach: Vec<f64> = (0..rows.unknowns()).map(reach).collect();
    let mut direction = vec![0.0; reach.len()];
    direction[axis] = 1.0;
    least_within(rows.clone(), &reach, &direction)
}

/// How far an unknown must grow until all rows hold; nothing where it does not help.
fn needed(rows: &Rows, axis: usize) -> Option<f64> {
    let mut most = 0.0_f64;
    for row in 0..rows.len() {
        let (outer, slope) = (rows.outer(row), rows.slopes(row)[axis]);
        let missing = if outer.lo() > 0.0 {
            outer.lo()
        } else if outer.hi() < 0.0 {
            outer.hi()
        } else {
            continue;
        };
        let more = missing / slope;
        if !(more.is_finite() && more > 0.0) {
            return None;
        }
        most = most.max(more);
    }
    Some(most)
}

/// Points of the unit box that are far from each other (Roberts, 2018): multiples of powers of the root of `x^(n+1) = x + 1`.
fn spread(number: usize, axes: usize) -> Vec<f64> {
    let mut root = 2.0_f64;
    for _ in 0..64 {
        root = (1.0 + root).powf(1.0 / (axes as f64 + 1.0));
    }
    let place = |axis: usize| {
        let step = root.powi(-(axis as i32 + 1));
        let share = (0.5 + number as f64 * step).fract();
        SPREAD * (2.0 * share - 1.0)
    };
    (0..axes).map(place).collect()
}
