//! A region, narrowed as far as samples do it, and what is left.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one row of axes per quantity, unknowns and rows of the same region"
)]

use super::answer::Reason;
use super::eigen::eigenvectors;
use super::pass::{Conflict, Passed, Set, Span, contract, pass};
use super::pave::reason_of;
use super::problem::Problem;
use super::region::{Region, scales_of};
use super::rows::{Affine, Rows};
use super::simplex::{Program, Side};
use serde::{Deserialize, Serialize};
use veribound_flow::form::Parallelotope;
use veribound_interval::Interval;

/// A round that leaves more than this share of every axis was not worth it.
const WORTHWHILE: f64 = 0.8;

/// Later windows are left for the next round when one leaves less than this share of an axis.
const ENOUGH: f64 = 0.6;

/// Most rounds for one region.
const ROUNDS: usize = 30;

/// A turned region is taken when its volume is smaller by this factor.
const SMALLER: f64 = 0.5;

/// A box around it may be wider by this factor.
const WIDER: f64 = 1.3;

/// Proved points keep so far from the border of the unit box.
const BORDER: f64 = 1e-6;

/// How far outside of rows, as multiple of half of what they allow, a point may have to be.
const DEEP: f64 = 16.0;

/// Points that are tried are in this.
const NEAR_BORDER: f64 = 1.0 - 2.0 * BORDER;

/// Rows that are from no sample say this instead.
pub(crate) const BELIEVED: usize = u32::MAX as usize;

/// How far a region was narrowed, and what the last pass says of the rest.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Cell {
    pub(crate) region: Region,
    /// Rows in the unknowns of the region.
    pub(crate) rows: Rows,
    /// The unknowns that rows leave.
    pub(crate) part: Vec<Interval>,
    /// Whether inner rows prove that all records are met.
    pub(crate) is_complete: bool,
    /// About how far from linear what is told depends on each axis.
    pub(crate) curvature: Vec<f64>,
    pub(crate) passes: usize,
    /// For every record the last sample that its start states were followed to.
    pub(crate) reached: Vec<usize>,
}

/// A conflict, and the record it is in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Clash {
    pub(crate) record: usize,
    pub(crate) conflict: Conflict,
    pub(crate) passes: usize,
}

impl Problem {
    /// The quantities that a pass through a record needs beside states: parameters, their values after resets, and
    /// the factor of errors.
    fn fixed_of(&self, record: usize, for_points: bool) -> Vec<usize> {
        let factor = self.factor_position();
        let later = self.later(record).take(self.count(record, for_points));
        self.params().chain(later).chain(factor).collect()
    }

    /// Number of values after resets, and of inputs, that a pass through a record knows.
    fn count(&self, record: usize, for_points: bool) -> usize {
        let course = &self.courses[record];
        if for_points {
            course.later.len()
        } else {
            course.firm
        }
    }

    /// Narrows a region round by round, until samples tell no more of it; the region may be turned where that is
    /// allowed.
    ///
    /// Guarantee: all start values and parameters of the region that agree with all records are in the part of the
    /// cell; a clash proves that there are none.
    pub(crate) fn refine(&self, mut region: Region, may_turn: bool) -> Result<Cell, Clash> {
        let mut passes = 0;
        for round in 1.. {
            let (cell, shrunk) = match self.round(region, &mut passes, true) {
                Ok(done) => done,
                Err((record, conflict)) => {
                    return Err(Clash {
                        record,
                        conflict,
                        passes,
                    });
                }
            };
            let (next, turned) = cell.smaller(may_turn);
            if round >= ROUNDS || (shrunk > WORTHWHILE && !turned) {
                return Ok(Cell { passes, ..cell });
            }
            region = next;
        }
        unreachable!("PROOF: the loop ends by returning")
    }

    /// One round for a small region around a point, only to find points that are proved to agree.
    ///
    /// The point is given in the unknowns of `region`, and `reaches` says how far around it.
    pub(crate) fn probe(&self, region: &Region, point: &[f64], reaches: &[f64]) -> Option<Cell> {
        let part: Vec<Interval> = point
            .iter()
            .zip(reaches)
            .map(|(x, reach)| Interval::point(*x).inflate(*reach))
            .collect();
        let mut passes = 0;
        let (cell, _) = self.round(region.part(&part), &mut passes, false).ok()?;
        Some(Cell { passes, ..cell })
    }

    /// One pass through every record; also tells the smallest share of an axis that is left.
    fn round(
        &self,
        region: Region,
        passes: &mut usize,
        has_windows: bool,
    ) -> Result<(Cell, f64), (usize, Conflict)> {
        let axes = region.axes();
        let mut curvature = vec![0.0; axes];
        let mut is_complete = true;
        let mut reached = Vec::new();
        let mut parts = Vec::new();
        for (record, course) in self.courses.iter().enumerate() {
            let fixed = self.fixed_of(record, !has_windows);
            let starts = self.starts(record).chain(fixed);
            let (rows, kept) = region.rows_of(&starts.collect::<Vec<_>>());
            let until = course.end();
            if course.instants.is_empty() {
                reached.push(until);
                continue;
            }
            let span = Span {
                from: 0,
                until,
                for_points: !has_windows,
            };
            *passes += 1;
            let passed = pass(self, course, span, self.set(record, rows, !has_windows));
            if let Some(conflict) = passed.conflict {
                return Err(of_record(record, conflict));
            }
            is_complete &= passed.is_complete;
            reached.push(passed.reached);
            for (axis, bend) in kept.iter().zip(&passed.curvature) {
                curvature[*axis] += bend;
            }
            let begin = parts.len();
            parts.push((passed, kept, record));
            if has_windows && parts[begin].0.reached < until {
                self.later_windows(&region, record, &mut parts, passes)?;
            }
        }
        // The unknowns that are left to all of them.
        let mut scales = vec![(Interval::ZERO, Interval::ONE); axes];
        let unit = Interval::symmetric(1.0);
        if let [(passed, kept, _)] = &parts[..] {
            for (axis, scale) in kept.iter().zip(&passed.scales) {
                scales[*axis] = *scale;
            }
        } else {
            let mut part = vec![unit; axes];
            for (passed, kept, _) in &parts {
                for (axis, (middle, radius)) in kept.iter().zip(&passed.scales) {
                    part[*axis] = part[*axis].intersect(*middle + *radius * unit);
                }
            }
            if let Some(axis) = part.iter().position(|x| x.is_empty()) {
                let told = parts.iter().filter(|window| window.1.contains(&axis));
                let samples = told.map(|(passed, _, record)| (passed.reached, *record));
                let samples = samples.collect();
                return Err((0, Conflict::Rows { samples }));
            }
            scales = scales_of(&part);
        }
        let mut rows = Rows::new(axes);
        for (passed, kept, record) in &mut parts {
            let to_common: Vec<(Interval, Interval)> = kept
                .iter()
                .zip(&passed.scales)
                .map(|(axis, own)| {
                    let common = scales[*axis];
                    if common == *own {
                        (Interval::ZERO, Interval::ONE)
                    } else {
                        into(own, &common)
                    }
                })
                .collect();
            passed.rows.rescale(&to_common);
            rows.take(&passed.rows, kept, *record);
        }
        let region = region.rescaled(&scales);
        for (i, believed) in self.believed().iter().enumerate() {
            // What does not depend on the unknowns may be any of its values, of which one that is believed is enough.
            let is_fixed = region.axes[i].iter().all(|x| *x == 0.0);
            if is_fixed && region.offset(i).intersects(*believed) {
                continue;
            }
            rows.push(&region.axes[i], region.offset(i), *believed, BELIEVED, 0);
        }
        rows.prune();
        let part = contract(&rows).map_err(|conflict| (0, conflict))?;
        let shrunk = scales
            .iter()
            .zip(&part)
            .map(|(scale, x)| scale.1.hi() * x.rad())
            .fold(1.0, f64::min);
        let cell = Cell {
            region,
            rows,
            part,
            is_complete,
            curvature,
            passes: 0,
            reached,
        };
        Ok((cell, shrunk))
    }
}

impl Problem {
    /// Rows of states and of [`Problem::fixed_of`] as what a pass moves.
    fn set(&self, record: usize, mut rows: Parallelotope, for_points: bool) -> Set {
        let moved = self.layout.states + self.layout.params;
        let axes_of_one = rows.axes.first().map_or(0, Vec::len);
        let rest = rows.rest.split_off(moved);
        let centre = rows.centre.split_off(moved);
        let axes = rows.axes.split_off(moved);
        let affine = axes.into_iter().zip(centre.into_iter().zip(rest));
        let mut affine = affine.map(|(slopes, (centre, rest))| Affine {
            slopes,
            rest: Interval::point(centre) + Interval::symmetric(rest),
        });
        let later = self.count(record, for_points);
        // A pass begins by giving inputs that are parameters their values.
        for _ in self.layout.params..self.moved(for_points).params {
            rows.centre.push(0.0);
            rows.axes.push(vec![0.0; axes_of_one]);
            rows.rest.push(0.0);
        }
        Set {
            moved: rows,
            later: affine.by_ref().take(later).collect(),
            factor: affine.next(),
        }
    }
}

/// A conflict that a pass through a record came to: all samples are of that.
fn of_record(record: usize, conflict: Conflict) -> (usize, Conflict) {
    let conflict = match conflict {
        Conflict::Rows { samples } => Conflict::Rows {
            samples: samples
                .into_iter()
                .map(|(sample, _)| (sample, record))
                .collect(),
        },
        value => value,
    };
    (record, conflict)
}

/// Whether unknowns are in the unit box, and by so much that they are in all those that it was narrowed from, which
/// rounding may have made a little smaller: rows tell of these alone.
pub(crate) fn is_well_inside(unknowns: Interval) -> bool {
    unknowns.is_subset_of(Interval::symmetric(1.0 - BORDER))
}

/// Unknowns `common.0 + common.1 δ'` in terms of `own.0 + own.1 δ`.
fn into(own: &(Interval, Interval), common: &(Interval, Interval)) -> (Interval, Interval) {
    if own.1.contains(0.0) {
        return (Interval::ENTIRE, Interval::ENTIRE);
    }
    ((common.0 - own.0) / own.1, common.1 / own.1)
}

/// A pass, the axes of its unknowns, and its record.
type Window = (Passed, Vec<usize>, usize);

impl Problem {
    /// Goes on from where the last window of `parts` was told anything last, with start states of their own, to
    /// the end of the record; what later windows say of their start states is projected away.
    ///
    /// Parameters are the same in all windows, so that each says something of the axes of `region`.
    fn later_windows(
        &self,
        region: &Region,
        record: usize,
        parts: &mut Vec<Window>,
        passes: &mut usize,
    ) -> Result<(), (usize, Conflict)> {
        let course = &self.courses[record];
        let until = course.end();
        let (own, kept) = region.rows_of(&self.fixed_of(record, false));
        let mut from = 0;
        let mut states = parts.last().and_then(|(passed, ..)| {
            let part = contract(&passed.rows).ok()?;
            anchored(passed, &part, &mut from)
        });
        while let Some(box_) = states {
            let starts = Region::of_box(&box_);
            let fresh = starts.axes();
            let zeros = |count: usize| vec![0.0; count];
            let widened = starts
                .axes
                .iter()
                .map(|row| [&row[..], &zeros(kept.len())].concat());
            let shifted = own.axes.iter().map(|row| [&zeros(fresh)[..], row].concat());
            let rows = Parallelotope {
                centre: [&starts.centre[..], &own.centre].concat(),
                axes: widened.chain(shifted).collect(),
                rest: [&starts.rest[..], &own.rest].concat(),
            };
            let span = Span {
                from,
                until,
                for_points: false,
            };
            *passes += 1;
            let mut passed = pass(self, course, span, self.set(record, rows, false));
            if let Some(conflict) = passed.conflict {
                return Err(of_record(record, conflict));
            }
            passed.rows.prune();
            let part = contract(&passed.rows).map_err(|conflict| of_record(record, conflict))?;
            let mut next = from;
            let ended = passed.reached == until;
            states = anchored(&passed, &part, &mut next).filter(|_| !ended && next > from);
            from = next;
            let shrunk = passed.scales[fresh..]
                .iter()
                .zip(&part[fresh..])
                .map(|(scale, x)| scale.1.hi() * x.rad())
                .fold(1.0, f64::min);
            passed.rows = projected(&passed.rows, &part, fresh);
            passed.scales.drain(..fresh);
            parts.push((passed, kept.clone(), record));
            // A narrower set goes farther.
            if shrunk < ENOUGH {
                break;
            }
        }
        Ok(())
    }
}

/// Encloses the states at the last sample that told something.
fn anchored(passed: &Passed, part: &[Interval], from: &mut usize) -> Option<Vec<Interval>> {
    let (sample, states) = passed.anchor.as_ref()?;
    *from = *sample;
    let program = Program::new(&passed.rows, part, Side::Outer);
    let around = |state: &Affine| program.bounds(&state.slopes) + state.rest;
    let box_: Vec<Interval> = states.iter().map(around).collect();
    box_.iter().all(|x| x.is_bounded()).then_some(box_)
}

/// What rows say of all unknowns but the first `fresh`.
fn projected(rows: &Rows, part: &[Interval], fresh: usize) -> Rows {
    let n = part.len();
    let matrix = information(rows, part);
    // What is left of the information when the first unknowns are free.
    let mut left = matrix;
    for v in 0..fresh {
        let pivot = left[v * n + v];
        if pivot <= 0.0 {
            continue;
        }
        for i in 0..n {
            let factor = left[i * n + v] / pivot;
            for l in 0..n {
                if i != v {
                    left[i * n + l] -= factor * left[v * n + l];
                }
            }
        }
    }
    let kept = n - fresh;
    let corner: Vec<f64> = (fresh..n)
        .flat_map(|i| left[i * n + fresh..(i + 1) * n].to_vec())
        .collect();
    let mut directions = eigenvectors(kept, &corner);
    directions.extend((0..kept).map(|v| {
        let mut unit = vec![0.0; kept];
        unit[v] = 1.0;
        unit
    }));
    let program = Program::new(rows, part, Side::Outer);
    let mut told = Rows::new(kept);
    let sample = (0..rows.len()).map(|row| rows.origin(row).0).max();
    for direction in directions {
        let whole = [&vec![0.0; fresh][..], &direction].concat();
        let bounds = program.bounds(&whole);
        if bounds.is_bounded() {
            told.push(&direction, Interval::ZERO, bounds, sample.unwrap_or(0), 0);
        }
    }
    told
}

/// How much rows say of the directions of unknowns, seen from a part of their box: a hint.
fn information(rows: &Rows, part: &[Interval]) -> Vec<f64> {
    let n = part.len();
    let mut matrix = vec![0.0; n * n];
    for row in 0..rows.len() {
        let slopes = rows.slopes(row);
        let reach: f64 = slopes
            .iter()
            .zip(part)
            .map(|(g, x)| g.abs() * x.rad())
            .sum();
        let width = rows.outer(row).rad().max(1e-30);
        if reach < width {
            continue;
        }
        for i in 0..n {
            for l in 0..n {
                matrix[i * n + l] += slopes[i] * slopes[l] / (width * width);
            }
        }
    }
    matrix
}

impl Cell {
    /// What it takes in memory, about.
    pub(crate) fn bytes(&self) -> usize {
        let axes = self.part.len();
        let row = 8 * axes + 40;
        row * self.rows.len() + 8 * (axes + 2) * self.region.centre.len() + 300
    }

    /// Whether its lists have the lengths of a problem with so many quantities and records.
    pub(crate) fn fits(&self, quantities: usize, records: usize) -> bool {
        let axes = self.part.len();
        let region = &self.region;
        let lists = [region.centre.len(), region.axes.len(), region.rest.len()];
        lists == [quantities; 3]
            && region.axes.iter().all(|row| row.len() == axes)
            && self.rows.unknowns() == axes
            && self.curvature.len() == axes
            && self.reached.len() == records
    }

    /// The region that is left, turned along its rows where that makes it much smaller.
    pub(crate) fn smaller(&self, may_turn: bool) -> (Region, bool) {
        let upright = self.region.part(&self.part);
        match self.turned().filter(|_| may_turn) {
            Some(turned) => (turned, true),
            None => (upright, false),
        }
    }

    /// A parallelotope around what is left, if it is much smaller than the part of the region.
    fn turned(&self) -> Option<Region> {
        let n = self.part.len();
        if n < 2 {
            return None;
        }
        // Rows in unknowns of which the part is the unit box.
        let mut rows = self.rows.clone();
        rows.rescale(&scales_of(&self.part));
        let whole = vec![Interval::symmetric(1.0); n];
        let matrix = information(&rows, &whole);
        let columns = eigenvectors(n, &matrix);
        let program = Program::new(&rows, &whole, Side::Outer);
        let mut along = Vec::with_capacity(n);
        for column in &columns {
            along.push(program.bounds(column));
        }
        if !along.iter().all(|x| x.is_bounded()) {
            return None;
        }
        let volume: f64 = along.iter().map(|x| x.rad()).product();
        if volume > SMALLER {
            return None;
        }
        let upright = self.region.part(&self.part);
        let turned = upright.turned(&columns, &along)?;
        // A box around it must not be much larger, since right-hand sides are asked on that.
        let is_compact = upright
            .hull()
            .iter()
            .zip(turned.hull())
            .all(|(before, after)| after.width() <= WIDER * before.width());
        is_compact.then_some(turned)
    }

    /// Proved bounds of a quantity: those of the solutions that agree with all records.
    pub(crate) fn outer(&self, quantity: usize) -> Interval {
        self.outer_because(quantity).0
    }

    /// As [`Cell::outer`], with what excludes the values below and above.
    pub(crate) fn outer_because(&self, quantity: usize) -> (Interval, [Reason; 2]) {
        let program = Program::new(&self.rows, &self.part, Side::Outer);
        let (bounds, held) = program.bounds_because(&self.region.axes[quantity]);
        let because = held.map(|held| {
            let held = held.iter().filter(|(_, multiplier)| *multiplier != 0.0);
            let samples: Vec<(usize, usize)> =
                held.map(|(row, _)| self.rows.origin(*row)).collect();
            reason_of(0, &samples)
        });
        let around = self.region.range(quantity, &self.part);
        (
            (bounds + self.region.offset(quantity)).intersect(around),
            because,
        )
    }

    /// Unknowns that are proved to agree with all records, about where each of the quantities is least and largest.
    pub(crate) fn points(&self, quantities: &[usize]) -> Vec<Vec<f64>> {
        if !self.is_complete {
            return Vec::new();
        }
        let program = Program::new(&self.rows, &self.part, Side::Inner);
        let mut found: Vec<Vec<f64>> = Vec::new();
        for &quantity in quantities {
            for sign in [1.0, -1.0] {
                let row = self.region.axes[quantity].iter();
                let direction: Vec<f64> = row.map(|x| sign * x).collect();
                if direction.iter().all(|x| *x == 0.0) && !found.is_empty() {
                    continue;
                }
                let vertex = program.minimize(&direction);
                if vertex.is_impossible {
                    return Vec::new();
                }
                found.push(vertex.point);
            }
        }
        let n = self.part.len();
        let count = found.len().max(1) as f64;
        let middle: Vec<f64> = (0..n)
            .map(|v| found.iter().map(|point| point[v]).sum::<f64>() / count)
            .collect();
        // A vertex is on the border, up to rounding: a little inside is proved.
        let inside = |vertex: &[f64], middle: &[f64]| {
            [1e-9, 1e-7, 1e-5, 1e-3, 0.05, 1.0]
                .iter()
                .find_map(|share| {
                    let pairs = vertex.iter().zip(middle);
                    // An unknown that nothing depends on is at its end in every vertex.
                    let point: Vec<f64> = pairs
                        .map(|(x, m)| (x + share * (m - x)).clamp(-NEAR_BORDER, NEAR_BORDER))
                        .collect();
                    self.proves(&point).then_some(point)
                })
        };
        let mut proved: Vec<Vec<f64>> = found
            .iter()
            .filter_map(|vertex| inside(vertex, &middle))
            .collect();
        if proved.is_empty() {
            // All vertices, and so their middle, may be on one side of what is left.
            let deep = self.deepest().0;
            let inner = found.iter().filter_map(|vertex| inside(vertex, &deep));
            proved.extend(inner);
        }
        proved
    }

    /// Whether inner rows prove that solutions with these unknowns agree with all records.
    fn proves(&self, point: &[f64]) -> bool {
        let unknowns = point.iter().map(|x| Interval::point(*x));
        unknowns.into_iter().all(is_well_inside)
            && (0..self.rows.len()).all(|row| {
                let slopes = self.rows.slopes(row).iter().zip(point);
                let value = slopes.fold(Interval::ZERO, |sum, (g, x)| {
                    sum + Interval::point(*g) * Interval::point(*x)
                });
                value.is_subset_of(self.rows.inner(row))
            })
    }

    /// How far around its middle a point is looked for, with this share of the axes: twice as far along those of which
    /// samples tell nothing but to points.
    pub(crate) fn reaches(&self, share: f64) -> Vec<f64> {
        let told = (0..self.rows.len()).filter(|row| self.rows.origin(*row).0 != BELIEVED);
        let told: Vec<usize> = told.collect();
        let is_told = |axis: usize| told.iter().any(|row| self.rows.slopes(*row)[axis] != 0.0);
        let reach = |axis| {
            if is_told(axis) {
                share
            } else {
                (2.0 * share).min(1.0)
            }
        };
        (0..self.part.len()).map(reach).collect()
    }

    /// About the unknowns that are farthest from the ends of all rows, as share of what each allows: inside of
    /// them, or where that is not possible, as little outside as can be; and how far that is.
    pub(crate) fn deepest(&self) -> (Vec<f64>, f64) {
        let n = self.part.len();
        let mut rows = Rows::new(n + 1);
        for row in 0..self.rows.len() {
            let outer = self.rows.outer(row);
            let slopes = self.rows.slopes(row);
            let reach: f64 = slopes.iter().map(|g| g.abs()).sum();
            let depth = 0.5 * DEEP * outer.width().min(reach);
            let half = |lo: f64, hi: f64| Interval::new(lo, hi).unwrap_or(Interval::ENTIRE);
            let sides = [
                (half(outer.lo(), f64::INFINITY), -depth),
                (half(f64::NEG_INFINITY, outer.hi()), depth),
            ];
            for (side, depth) in sides.into_iter().filter(|side| side.0 != Interval::ENTIRE) {
                let slopes = [slopes, &[depth]].concat();
                rows.push(&slopes, Interval::ZERO, side, 0, 0);
            }
        }
        let mut part = self.part.clone();
        part.push(Interval::symmetric(1.0));
        let mut direction = vec![0.0; n + 1];
        direction[n] = -1.0;
        let vertex = Program::new(&rows, &part, Side::Outer).minimize(&direction);
        let mut point = vertex.point;
        let depth = point.pop().unwrap_or(f64::NEG_INFINITY);
        // An unknown that no row depends on is anywhere.
        for (v, x) in point.iter_mut().enumerate() {
            if (0..self.rows.len()).all(|row| self.rows.slopes(row)[v] == 0.0) {
                *x = self.part[v].mid();
            }
        }
        (point, depth)
    }

    /// The halves along the axis that bends most what is told.
    pub(crate) fn halves(&self) -> Option<[Region; 2]> {
        let weights = self.curvature.iter().zip(&self.part);
        let weights: Vec<f64> = weights.map(|(bend, part)| bend * part.rad()).collect();
        let mut axis = (0..weights.len()).max_by(|a, b| weights[*a].total_cmp(&weights[*b]))?;
        if weights[axis] <= 0.0 {
            axis = (0..weights.len())
                .max_by(|a, b| self.part[*a].rad().total_cmp(&self.part[*b].rad()))?;
        }
        let whole = self.part[axis];
        let at = whole.mid();
        let half = |lo: f64, hi: f64| {
            let mut part = self.part.clone();
            part[axis] = Interval::new(lo, hi)?;
            Some(self.region.part(&part))
        };
        (whole.lo() < at && at < whole.hi())
            .then(|| Some([half(whole.lo(), at)?, half(at, whole.hi())?]))?
    }
}
