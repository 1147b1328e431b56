//! A region, narrowed as far as samples do it, and what is left.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one row of axes per quantity, unknowns and rows of the same region"
)]

use std::collections::BTreeSet;

use super::answer::Reason;
use super::eigen::eigenvectors;
use super::pass::{Aim, Conflict, GoOn, Set, Span, contract, pass};
use super::pave::reason_of;
use super::problem::Problem;
use super::region::{Region, scales_of};
use super::rows::{Affine, Rows};
use super::simplex::{Deepest, Program, Side, deepest};
use super::told::Told;
use super::windows::{
    Joined, Junctions, Window, blames, common, in_common, information, joined, junctions, widths,
};
use serde::{Deserialize, Serialize};
use veribound_flow::form::Parallelotope;
use veribound_interval::Interval;

/// What is known of a quantity says something where it is no more than this share of what a region says.
const TOLD: f64 = 0.999;

/// A round that leaves more than this share of every axis was not worth it.
const WORTHWHILE: f64 = 0.8;

/// Where one window comes to the end of each record, what is not affine hides little: another round tells little more unless
/// no more than this share was left.
const HALF: f64 = 0.5;

/// So many unknowns of windows are looked at together at first, so many times as many each time, and so many at most.
const FIRST: usize = 8;
const MORE: usize = 4;
const MOST: usize = 64;

/// Most rounds for one region.
const ROUNDS: usize = 30;

/// A turned region is taken when its volume is smaller by this factor.
const SMALLER: f64 = 0.5;

/// A box around it may be wider by this factor, and by so much where nothing else brings more.
const WIDER: f64 = 1.3;
const WIDEST: f64 = 2.5;

/// Proved points keep so far from the border of the unit box.
pub(crate) const BORDER: f64 = 1e-6;

/// Slopes for a fit are those of a region of this share around a point,
const TINY: f64 = 1.0 / ((1 << 20) as f64);

/// and it moves by this share of the region at first, so many times at most.
const TRUST: f64 = 0.5;
const FITS: usize = 12;

/// fewer where nothing near agrees with the slopes after these.
const HOPELESS: usize = 2;

/// A climb has so many steps at most, keeps inside of what was measured by this share,
const CLIMBS: usize = 12;
const MARGIN: f64 = 1e-3;

/// takes steps so many times as long where they succeed or would bring too little, until this,
const LONGER: f64 = 4.0;
const FARTHEST: f64 = 1024.0;

/// keeps inside by more, so many times what a step came nearer to the border than it was to, where one came outside,
const CURVED: f64 = 1.5;

/// may be outside by this share on its way, and has arrived when a step brought no more than this share of it.
const ASTRAY: f64 = 0.1;
const ARRIVED: f64 = 0.02;

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
    /// For every record the last sample that its windows came to.
    pub(crate) reached: Vec<usize>,
    /// For every record samples at which windows began, and the states there of all solutions that are left.
    pub(crate) junctions: Vec<Junctions>,
    /// The deepest point of all windows, where there are any.
    pub(crate) deep: Option<Deepest>,
}

/// What rows leave of a region.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Left<'a> {
    pub(crate) region: &'a Region,
    /// Rows in its unknowns,
    pub(crate) rows: &'a Rows,
    /// and what these leave of the unknowns.
    pub(crate) part: &'a [Interval],
}

/// What is known of the solutions of a region that agree with all records, if anything.
#[derive(Debug, Clone, Default)]
pub(crate) struct Known {
    /// For every record the states at samples.
    pub(crate) states: Vec<Junctions>,
    /// The quantities of the region.
    pub(crate) quantities: Vec<Interval>,
}

/// A conflict, and the record it is in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Clash {
    pub(crate) record: usize,
    pub(crate) conflict: Conflict,
    pub(crate) passes: usize,
}

/// What passes through all records came to.
///
/// All of it is of one region: nothing of it holds for solutions outside.
struct Seen {
    /// In the scales that are common to all windows,
    region: Region,
    /// of which each is so much of what it was.
    scales: Vec<(Interval, Interval)>,
    windows: Vec<Window>,
    is_complete: bool,
    curvature: Vec<f64>,
    reached: Vec<usize>,
    /// Whether it is told of all solutions.
    is_for_all: bool,
}

impl Problem {
    /// The quantities that a pass through a record needs beside states: parameters, their values after resets, and
    /// the factor of errors.
    pub(crate) fn fixed_of(&self, record: usize, for_points: bool) -> Vec<usize> {
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
    /// Guarantee: all start values and parameters of the region that agree with all records, as what is `known` of
    /// these says, are in the part of the cell; a clash proves that there are none.
    pub(crate) fn refine(
        &self,
        region: Region,
        known: Known,
        may_turn: bool,
        go_on: &GoOn<'_>,
    ) -> Result<Cell, Clash> {
        self.narrowed((region, known), may_turn, true, go_on)
    }

    /// As [`Problem::refine`] where one window comes to the end of each record; else little is done, and little is told.
    pub(crate) fn refine_at_once(&self, region: Region, go_on: &GoOn<'_>) -> Result<Cell, Clash> {
        self.narrowed((region, Known::default()), true, false, go_on)
    }

    fn narrowed(
        &self,
        (mut region, known): (Region, Known),
        may_turn: bool,
        by_windows: bool,
        go_on: &GoOn<'_>,
    ) -> Result<Cell, Clash> {
        let mut passes = 0;
        let Known {
            states: mut known,
            quantities,
        } = known;
        known.resize(self.courses.len(), Junctions::new());
        let hull = region.hull().into_iter();
        let mut within: Vec<Interval> = match quantities.is_empty() {
            true => hull.collect(),
            false => hull.zip(quantities).map(|(a, b)| a.intersect(b)).collect(),
        };
        let mut together = FIRST;
        // What to go back to where a region that was turned at last brings no more, and how large that is.
        let mut upright: Option<(Cell, f64)> = None;
        for round in 1.. {
            let clash = |(record, conflict), passes| Clash {
                record,
                conflict,
                passes,
            };
            let seen = self.passed(region, &mut passes, Some(&known), by_windows, go_on);
            let seen = seen.map_err(|found| clash(found, passes))?;
            let is_short = !by_windows && !self.ends(&seen.reached);
            let is_last = round >= ROUNDS || is_short || !go_on();
            let own = seen.windows.iter().map(Window::own).sum();
            (region, known) = loop {
                let told = self.told(&seen, &within, together);
                let (mut cell, shrunk) = told.map_err(|found| clash(found, passes))?;
                let (next, turned) = cell.left().smaller(may_turn);
                let has_ended = own == 0 && self.ends(&seen.reached);
                // The rows of a tile, which does not turn, decide many others.
                let most = if has_ended && may_turn {
                    HALF
                } else {
                    WORTHWHILE
                };
                let brings = shrunk <= most || turned;
                cell.narrow(&mut within);
                // More windows together tell more, and take longer.
                if !brings && !is_last && together < MOST.min(own) {
                    together *= MORE;
                    continue;
                }
                let states = junctions(&seen.windows, &cell.part);
                cell.junctions = states.map_err(|found| clash(found, passes))?;
                cell.junctions.resize(self.courses.len(), Junctions::new());
                if let Some((before, size)) = upright.take()
                    && size_of(&within) > WORTHWHILE * size
                {
                    return Ok(Cell { passes, ..before });
                }
                let states = widths(&cell.junctions).into_iter().zip(widths(&known));
                let mut states = states.filter(|(now, before)| *now < WORTHWHILE * before);
                if !is_last && (brings || states.next().is_some()) {
                    break (next, cell.junctions);
                }
                let turns = may_turn && !is_last && own > 0;
                let Some(turned) = cell.left().compact(WIDEST).filter(|_| turns) else {
                    return Ok(Cell { passes, ..cell });
                };
                let states = cell.junctions.clone();
                upright = Some((cell, size_of(&within)));
                break (turned, states);
            };
        }
        unreachable!("PROOF: the loop ends by returning")
    }

    /// One round for a small region around a point, only to find points that are proved to agree.
    ///
    /// The point is given in the unknowns of `region`, and `reaches` says how far around it.
    pub(crate) fn probe(
        &self,
        region: &Region,
        point: &[f64],
        reaches: &[f64],
        go_on: &GoOn<'_>,
    ) -> Option<Cell> {
        let part: Vec<Interval> = point
            .iter()
            .zip(reaches)
            .map(|(x, reach)| Interval::point(*x).inflate(*reach))
            .collect();
        let mut passes = 0;
        let seen = self
            .passed(region.part(&part), &mut passes, None, false, go_on)
            .ok()?;
        let (cell, _) = self.told(&seen, &[], 0).ok()?;
        Some(Cell { passes, ..cell })
    }

    /// Whether these samples are the last ones of all records.
    pub(crate) fn ends(&self, reached: &[usize]) -> bool {
        let mut courses = self.courses.iter().zip(reached);
        courses.all(|(course, reached)| *reached == course.end())
    }

    /// Goes from a point of the region to one nearby that agrees with the begin of all records, this share of each, as far
    /// as that is seen without proof: each time to the deepest point of what is measured as linear functions there.
    pub(crate) fn fit(
        &self,
        region: &Region,
        point: &[f64],
        share: f64,
        go_on: &GoOn<'_>,
    ) -> Option<Vec<f64>> {
        let mut at = point.to_vec();
        let mut trust = TRUST;
        let (mut depth, mut rows) = self.linear(region, &at, share, go_on)?;
        for tried in 0..FITS {
            if depth > 0.0 {
                return Some(at);
            }
            let ends = at.iter().map(|x| {
                let (lo, hi) = ((x - trust).max(-1.0), (x + trust).min(1.0));
                Interval::new(lo - x, hi - x).unwrap_or(Interval::ZERO)
            });
            let (step, hoped) = deepest(&rows, &ends.collect::<Vec<_>>());
            if tried >= HOPELESS && hoped < 0.0 {
                return None;
            }
            let next: Vec<f64> = at.iter().zip(&step).map(|(x, by)| x + by).collect();
            let better = self.linear(region, &next, share, go_on);
            match better.filter(|(own, _)| *own > depth) {
                Some(found) => (at, depth, rows) = (next, found.0, found.1),
                None => trust *= 0.3,
            }
        }
        (depth > 0.0).then_some(at)
    }

    /// Goes from a point that agrees with all records to where a quantity is least, or largest, as far as that is seen
    /// without proof, by steps that bring at least so much.
    pub(crate) fn climb(
        &self,
        region: &Region,
        point: &[f64],
        (told, is_upper): (Told, bool),
        least: f64,
        go_on: &GoOn<'_>,
    ) -> Option<Vec<f64>> {
        let sign = if is_upper { -1.0 } else { 1.0 };
        let downward = |at: &[f64]| -> Vec<f64> {
            let direction = told.direction(region, at).into_iter();
            direction.map(|x| sign * x).collect()
        };
        let height = |at: &[f64]| sign * told.height(region, at);
        let mut best = point.to_vec();
        let mut at = point.to_vec();
        let (mut trust, mut farthest, mut margin) = (TRUST, FARTHEST, MARGIN);
        let (_, mut rows) = self.linear(region, &at, 1.0, go_on)?;
        for _ in 0..CLIMBS {
            let (mut step, mut is_near);
            let mut next: Vec<f64>;
            let direction = downward(&at);
            // What is far away is reached by a longer step, as far as rows let it go.
            loop {
                step = highest(&rows, margin, trust, &direction);
                next = at.iter().zip(&step).map(|(x, by)| x + by).collect();
                is_near = step.iter().all(|x| x.abs() < 0.9 * trust);
                if is_near || trust >= farthest || height(&best) - height(&next) >= least {
                    break;
                }
                trust = farthest.min(LONGER * trust);
            }
            if height(&best) - height(&next) < least {
                break;
            }
            let found = self.linear(region, &next, 1.0, go_on);
            match found.filter(|(depth, _)| *depth > -ASTRAY) {
                Some((depth, own)) => {
                    (at, rows) = (next, own);
                    if depth > 0.0 && height(&at) < height(&best) {
                        let gain = height(&best) - height(&at);
                        let way = height(point) - height(&at);
                        best = at.clone();
                        if is_near && gain < ARRIVED * way {
                            break;
                        }
                    }
                    if depth > 0.0 {
                        trust = farthest.min(LONGER * trust);
                    } else {
                        margin = ASTRAY.min(CURVED * (margin - depth));
                    }
                }
                None => {
                    trust *= 0.2;
                    farthest = trust;
                }
            }
        }
        Some(best)
    }

    /// What is measured in the begin of all records, this share of each, as linear functions of the step from a point of a
    /// region, in its unknowns, and how deep inside of it the point is; nothing where a pass does not come to its end.
    pub(crate) fn linear(
        &self,
        region: &Region,
        point: &[f64],
        share: f64,
        go_on: &GoOn<'_>,
    ) -> Option<(f64, Rows)> {
        let part: Vec<Interval> = point
            .iter()
            .map(|x| Interval::point(*x).inflate(TINY))
            .collect();
        let region = region.part(&part);
        let mut all = Rows::new(region.axes());
        for (record, course) in self.courses.iter().enumerate() {
            if course.instants.is_empty() {
                continue;
            }
            let starts = self.starts(record).chain(self.fixed_of(record, true));
            let (rows, kept) = region.rows_of(&starts.collect::<Vec<_>>());
            let until = (course.end() as f64 * share).ceil() as usize;
            let span = Span {
                from: 0,
                until,
                aim: Aim::Slopes,
                go_on,
            };
            let set = self.set(record, rows, true);
            let passed = pass(self, course, span, set, BTreeSet::new());
            if passed.reached < until {
                return None;
            }
            all.take(&passed.rows, &kept, record);
        }
        self.believe(&region, true, &mut all);
        let steps = (Interval::ZERO, Interval::point(1.0 / TINY));
        all.rescale(&vec![steps; region.axes()]);
        Some((depth_of(&all), all))
    }

    /// Passes through every record, maybe in windows where states are known at begins of these, if only none.
    fn passed(
        &self,
        region: Region,
        passes: &mut usize,
        known_of: Option<&[Junctions]>,
        by_windows: bool,
        go_on: &GoOn<'_>,
    ) -> Result<Seen, (usize, Conflict)> {
        let axes = region.axes();
        let mut curvature = vec![0.0; axes];
        let mut is_complete = true;
        let mut reached = Vec::new();
        let mut windows: Vec<Window> = Vec::new();
        for (record, course) in self.courses.iter().enumerate() {
            let fixed = self.fixed_of(record, known_of.is_none());
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
                aim: if known_of.is_some() {
                    Aim::Bounds
                } else {
                    Aim::Points
                },
                go_on,
            };
            *passes += 1;
            let known = known_of.map(|known| &known[record]);
            let wanted: BTreeSet<usize> = known
                .iter()
                .flat_map(|known| known.keys().copied())
                .collect();
            let set = self.set(record, rows, known_of.is_none());
            let known = known.filter(|_| self.balances.is_none());
            let passed = pass(self, course, span, set, wanted);
            if let Some(conflict) = passed.conflict {
                return Err(of_record(record, conflict));
            }
            is_complete &= passed.is_complete;
            let is_short = passed.reached < until;
            windows.push(Window {
                passed,
                kept,
                record,
                link: None,
            });
            if let Some(known) = known.filter(|_| is_short && by_windows) {
                self.later_windows(&region, known, &mut windows, passes, go_on)?;
            }
            reached.push(windows.last().map_or(until, |last| last.passed.reached));
            let own = windows.iter().filter(|window| window.record == record);
            let blames = blames(&own.collect::<Vec<_>>(), axes, until);
            let sums = curvature.iter_mut().zip(blames);
            sums.for_each(|(sum, blame)| *sum += blame);
        }
        // The unknowns that are left to all of them.
        let scales = common(&windows, axes)?;
        in_common(&mut windows, &scales);
        Ok(Seen {
            region: region.rescaled(&scales),
            scales,
            windows,
            is_complete,
            curvature,
            reached,
            is_for_all: known_of.is_some(),
        })
    }

    /// What passes say, windows with so many unknowns being looked at together, of solutions whose quantities are
    /// `within`, if that is known; also tells the smallest share of an axis that is left.
    fn told(
        &self,
        seen: &Seen,
        within: &[Interval],
        together: usize,
    ) -> Result<(Cell, f64), (usize, Conflict)> {
        let region = &seen.region;
        let Joined {
            mut rows,
            deepest: deep,
        } = joined(&seen.windows, region.axes(), together)?;
        self.believe(region, false, &mut rows);
        for ((quantity, known), whole) in within.iter().enumerate().zip(region.hull()) {
            if whole.intersect(*known).width() < TOLD * whole.width() {
                rows.push_outer(&region.axes[quantity], *known - region.offset(quantity));
            }
        }
        let balances = self.balances.as_ref().filter(|_| seen.is_for_all);
        let bends = balances.map(|balances| balances.tell(region, &mut rows));
        rows.prune();
        let part = contract(&rows).map_err(|conflict| (0, conflict))?;
        let shrunk = seen
            .scales
            .iter()
            .zip(&part)
            .map(|(scale, x)| scale.1.hi() * x.rad())
            .fold(1.0, f64::min);
        let cell = Cell {
            region: region.clone(),
            rows,
            part,
            is_complete: seen.is_complete,
            curvature: bends.unwrap_or_else(|| seen.curvature.clone()),
            passes: 0,
            reached: seen.reached.clone(),
            junctions: vec![Junctions::new(); self.courses.len()],
            deep,
        };
        Ok((cell, shrunk))
    }
}

impl Problem {
    /// Rows of states and of [`Problem::fixed_of`] as what a pass moves.
    pub(crate) fn set(&self, record: usize, mut rows: Parallelotope, for_points: bool) -> Set {
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

/// How large a box is, whatever the units of its quantities are: to be compared with parts of it.
fn size_of(quantities: &[Interval]) -> f64 {
    let widths = quantities.iter().map(|x| x.width());
    widths.filter(|width| *width > 0.0).product()
}

/// About the unknowns, none farther than `trust`, that are least in a direction of those inside of all rows by a share of what
/// each allows.
fn highest(rows: &Rows, share: f64, trust: f64, direction: &[f64]) -> Vec<f64> {
    let mut inner = Rows::new(rows.unknowns());
    for row in 0..rows.len() {
        let outer = rows.outer(row);
        let margin = outer.width() * share;
        let inside = Interval::new(outer.lo() + margin, outer.hi() - margin);
        let inside = inside.unwrap_or(outer);
        inner.push(rows.slopes(row), Interval::ZERO, inside, 0, 0);
    }
    least_within(inner, &vec![trust; rows.unknowns()], direction)
}

/// About the unknowns of all rows, none farther than it may `reach`, that are least in a direction of shares of their reaches.
pub(crate) fn least_within(mut rows: Rows, reach: &[f64], direction: &[f64]) -> Vec<f64> {
    // A program's tolerances are those of the unit box.
    let scales = reach.iter().map(|x| (Interval::ZERO, Interval::point(*x)));
    rows.rescale(&scales.collect::<Vec<_>>());
    let unit = vec![Interval::symmetric(1.0); reach.len()];
    let vertex = Program::new(&rows, &unit, Side::Outer).minimize(direction);
    let pairs = vertex.point.iter().zip(reach);
    pairs.map(|(x, reach)| reach * x).collect()
}

/// How far inside of all rows, as share of what each allows, the middle of the unknowns is; below zero where outside. A row with
/// one end allows as much as the unknowns move it.
fn depth_of(rows: &Rows) -> f64 {
    let depths = (0..rows.len()).map(|row| {
        let outer = rows.outer(row);
        let size = if outer.is_bounded() {
            outer.width()
        } else {
            rows.slopes(row).iter().map(|g| g.abs()).sum()
        };
        (-outer.lo()).min(outer.hi()) / size
    });
    depths.filter(|depth| !depth.is_nan()).fold(1.0, f64::min)
}

/// A conflict that a pass through a record came to: all samples are of that.
pub(crate) fn of_record(record: usize, conflict: Conflict) -> (usize, Conflict) {
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

impl Cell {
    /// What it takes in memory, about.
    pub(crate) fn bytes(&self) -> usize {
        let axes = self.part.len();
        let row = 8 * axes + 40;
        let known = self.junctions.iter().flat_map(|known| known.values());
        let known: usize = known.map(|box_| 16 * box_.len() + 48).sum();
        known + row * self.rows.len() + 8 * (axes + 2) * self.region.centre.len() + 300
    }

    /// Whether its lists have the lengths of a problem with so many quantities, states and records.
    pub(crate) fn fits(&self, (quantities, states): (usize, usize), records: usize) -> bool {
        let axes = self.part.len();
        let region = &self.region;
        let lists = [region.centre.len(), region.axes.len(), region.rest.len()];
        lists == [quantities; 3]
            && region.axes.iter().all(|row| row.len() == axes)
            && self.rows.unknowns() == axes
            && self.curvature.len() == axes
            && self.reached.len() == records
            && self.junctions.len() == records
            && self
                .junctions
                .iter()
                .flat_map(Junctions::values)
                .all(|box_| box_.len() == states)
            && self.deep.as_ref().is_none_or(|deep| deep.0.len() == axes)
    }

    /// Narrows quantities to what is left.
    fn narrow(&self, within: &mut [Interval]) {
        for (quantity, known) in within.iter_mut().enumerate() {
            let is_axis = self.region.axes[quantity].iter().filter(|x| **x != 0.0);
            let left = match is_axis.count() {
                0 | 1 => self.region.range(quantity, &self.part),
                _ => self.outer(quantity),
            };
            let left = left.intersect(*known);
            if !left.is_empty() {
                *known = left;
            }
        }
    }

    /// What its rows leave of the region.
    pub(crate) fn left(&self) -> Left<'_> {
        Left {
            region: &self.region,
            rows: &self.rows,
            part: &self.part,
        }
    }

    /// Proved bounds of a quantity: those of the solutions that agree with all records.
    pub(crate) fn outer(&self, quantity: usize) -> Interval {
        self.outer_because(quantity).0
    }

    /// As [`Cell::outer`], with what excludes the values below and above.
    pub(crate) fn outer_because(&self, quantity: usize) -> (Interval, [Reason; 2]) {
        let (bounds, because) = self.along(&self.region.axes[quantity]);
        let around = self.region.range(quantity, &self.part);
        (
            (bounds + self.region.offset(quantity)).intersect(around),
            because,
        )
    }

    /// Proved bounds in a direction of the unknowns, with what excludes those below and above.
    pub(crate) fn along(&self, direction: &[f64]) -> (Interval, [Reason; 2]) {
        let mut program = Program::new(&self.rows, &self.part, Side::Outer);
        let (bounds, held) = program.bounds_because(direction);
        let because = held.map(|held| {
            let held = held.iter().filter(|(_, multiplier)| *multiplier != 0.0);
            let samples: Vec<(usize, usize)> =
                held.map(|(row, _)| self.rows.origin(*row)).collect();
            reason_of(0, &samples)
        });
        (bounds, because)
    }

    /// Unknowns that are proved to agree with all records, about where each of these is least and largest.
    pub(crate) fn points(&self, told: &[Told]) -> Vec<Vec<f64>> {
        if !self.is_complete {
            return Vec::new();
        }
        let mut program = Program::new(&self.rows, &self.part, Side::Inner);
        let mut found: Vec<Vec<f64>> = Vec::new();
        let middle: Vec<f64> = self.part.iter().map(|x| x.mid()).collect();
        for &told in told {
            for sign in [1.0, -1.0] {
                let mut at = middle.clone();
                for _ in 0..told.programs() {
                    let direction = told.direction(&self.region, &at);
                    let direction: Vec<f64> = direction.iter().map(|x| sign * x).collect();
                    if direction.iter().all(|x| *x == 0.0) && !found.is_empty() {
                        break;
                    }
                    let vertex = program.minimize(&direction);
                    if vertex.is_impossible {
                        return Vec::new();
                    }
                    at = vertex.point;
                }
                found.push(at);
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

    /// Where solutions are most likely to agree with all records, as [`deepest`], and how far inside that is.
    pub(crate) fn deepest(&self) -> Deepest {
        match &self.deep {
            Some(deep) => deep.clone(),
            None => deepest(&self.rows, &self.part),
        }
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

impl Left<'_> {
    /// The region that is left, turned along its rows where that makes it much smaller.
    pub(crate) fn smaller(self, may_turn: bool) -> (Region, bool) {
        let upright = self.region.part(self.part);
        match self.compact(WIDER).filter(|_| may_turn) {
            Some(turned) => (turned, true),
            None => (upright, false),
        }
    }

    /// A parallelotope around what is left, if it is much smaller than the part of the region.
    ///
    /// A box around it is no wider than by a factor, since right-hand sides are asked on that.
    fn compact(self, wider: f64) -> Option<Region> {
        let turned = self.turned(SMALLER)?;
        let upright = self.region.part(self.part).hull();
        let pairs = upright.iter().zip(turned.hull());
        let is_compact = pairs
            .into_iter()
            .all(|(before, after)| after.width() <= wider * before.width());
        is_compact.then_some(turned)
    }

    /// A parallelotope around what is left, if it is at most so many times as large as the part of the region.
    pub(crate) fn turned(self, most: f64) -> Option<Region> {
        let n = self.part.len();
        if n < 2 {
            return None;
        }
        // Rows in unknowns of which the part is the unit box.
        let mut rows = self.rows.clone();
        rows.rescale(&scales_of(self.part));
        let whole = vec![Interval::symmetric(1.0); n];
        let matrix = information(&rows, &whole);
        let columns = eigenvectors(n, &matrix);
        let mut program = Program::new(&rows, &whole, Side::Outer);
        let mut along = Vec::with_capacity(n);
        for column in &columns {
            along.push(program.bounds(column));
        }
        if !along.iter().all(|x| x.is_bounded()) {
            return None;
        }
        let volume: f64 = along.iter().map(|x| x.rad()).product();
        if volume > most {
            return None;
        }
        self.region.part(self.part).turned(&columns, &along)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// However long the step that may be taken, a vertex of rows in nearly one direction is inside of all of them: their
    /// slopes are small, and the ends of the box are far.
    #[test]
    fn the_farthest_point_is_inside_of_all_rows() {
        let mut rows = Rows::new(4);
        for k in 0..300 {
            let t = f64::from(k) * 0.01;
            let slopes = [1.0, 1e-2 * t, 1e-4 * t * t, 1e-5 * (7.0 * t).sin()].map(|g| 1e-3 * g);
            let around = 1e-3 * (11.0 * t).cos();
            let told = Interval::point(around).inflate(3e-3);
            rows.push(&slopes, Interval::ZERO, told, 0, 0);
        }
        for direction in [
            [0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, -1.0, 0.0],
            [0.1, 0.0, 0.0, 1.0],
        ] {
            for trust in [1.0, 1e3, 1e6] {
                let point = highest(&rows, MARGIN, trust, &direction);
                for row in 0..rows.len() {
                    let value = rows.slopes(row).iter().zip(&point);
                    let value: f64 = value.map(|(g, x)| g * x).sum();
                    let outer = rows.outer(row);
                    let rounding = 1e-6 * outer.width();
                    assert!(
                        outer.inflate(rounding).contains(value),
                        "{value} in {outer} with {trust}"
                    );
                }
            }
        }
    }
}
