//! The search for the hull: regions are divided where a bound is not yet known to be near the best possible.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one pair of bounds per quantity of a region"
)]

use super::answer::{Bounds, Conclusion, Identified, IdentifyOptions, Limit, Progress, Tile};
use super::cell::{BELIEVED, Cell, Clash};
use super::pass::Conflict;
use super::pave::Paving;
use super::problem::Problem;
use super::region::Region;
use rayon::prelude::*;
use veribound_interval::Interval;

/// Regions that are divided at once, whatever the number of threads, so that this never changes a result.
const AT_ONCE: usize = 8;

/// A cell with the proved bounds of every quantity.
struct Leaf {
    cell: Cell,
    /// Unknowns that are proved to agree with all records.
    points: Vec<Vec<f64>>,
    outer: Vec<Interval>,
    /// It cannot be divided any further.
    is_atom: bool,
}

/// A search that brought bounds nearer by less than this factor for a while is over,
const WORTHWHILE: f64 = 0.8;

/// a while being this share of the sets allowed, or so many.
const PATIENCE: (usize, usize) = (20, 30);

/// So many tiles of a paving may be moved through the records for every set.
const TILES_PER_SET: usize = 20;

/// How far around a point the first probe looks, as share of the region it was found in,
const REACH: f64 = 0.5;

/// the next one where a probe was of little use, as share of that,
const NEARER: f64 = 0.4;

/// and where it ends.
const NEAREST: f64 = 0.005;

/// A probe was of use if it brought a bound nearer by this share of what was missing.
const USEFUL: f64 = 0.2;

/// The proved point at which a quantity is least or largest, and where to look for a better one.
#[derive(Clone)]
struct Best {
    region: Region,
    point: Vec<f64>,
    value: f64,
    reach: f64,
}

/// What is to be looked at.
enum Job {
    Divide(Region),
    /// Around the best point of this quantity and side,
    Climb(usize, usize),
    /// or in the middle of a leaf, where no point is known.
    Middle(Box<Cell>),
}

/// Everything that is known.
pub(crate) struct Search<'a> {
    problem: &'a Problem,
    options: &'a IdentifyOptions,
    leaves: Vec<Leaf>,
    /// Per quantity the least upper and the largest lower bound of a proved point's value; the points themselves,
    /// as boxes of all quantities.
    inner: Vec<(f64, f64)>,
    points: Vec<Vec<Interval>>,
    /// Per parameter the points where it is least and largest.
    best: Vec<[Option<Best>; 2]>,
    /// How near the middle of a leaf a point was looked for.
    middle: f64,
    clashes: Vec<Clash>,
    sets: usize,
    passes: usize,
    interrupted: bool,
}

/// What became of a job.
enum Outcome {
    Left(Box<Leaf>),
    Gone(Clash),
    /// Points that a probe proved, after so many passes.
    Proved(Option<Box<Cell>>, Vec<Vec<f64>>),
}

impl<'a> Search<'a> {
    pub(crate) fn new(problem: &'a Problem, options: &'a IdentifyOptions) -> Search<'a> {
        Search {
            problem,
            options,
            leaves: Vec::new(),
            inner: vec![(f64::INFINITY, f64::NEG_INFINITY); problem.believed().len()],
            points: Vec::new(),
            best: vec![[None, None]; problem.layout.params],
            middle: REACH,
            clashes: Vec::new(),
            sets: 0,
            passes: 0,
            interrupted: false,
        }
    }

    /// First of the parameters among the quantities.
    fn first(&self) -> usize {
        self.problem.first_param()
    }

    fn quantities(&self) -> usize {
        self.inner.len()
    }

    /// Looks at the whole box; it is kept, and all there is, if it is excluded or comes to the end of every record.
    pub(crate) fn reaches(&mut self, quantities: &[Interval]) -> bool {
        let job = Job::Divide(Region::of_box(quantities));
        let outcome = self.look_at(&job);
        let is_kept = match &outcome {
            Outcome::Left(leaf) => self.has_ended(&leaf.cell),
            _ => true,
        };
        if is_kept {
            self.take(&job, outcome);
        }
        is_kept
    }

    fn has_ended(&self, cell: &Cell) -> bool {
        let courses = self.problem.courses.iter().zip(&cell.reached);
        courses
            .into_iter()
            .all(|(course, reached)| *reached == course.horizon())
    }

    /// Nothing agrees with the records.
    pub(crate) fn refute(&mut self, clash: Clash) {
        self.clashes.push(clash);
    }

    fn look_at(&self, job: &Job) -> Outcome {
        let first = self.first();
        let probed = match job {
            Job::Divide(region) => {
                return match self.problem.refine(region.clone(), true) {
                    Ok(cell) => {
                        // Regions may reach out of what is believed a little.
                        let believed = self.problem.believed().into_iter().enumerate();
                        let outer = believed.map(|(i, x)| cell.outer(i).intersect(x)).collect();
                        Outcome::Left(Box::new(Leaf {
                            points: cell.points(first..self.quantities()),
                            cell,
                            outer,
                            is_atom: false,
                        }))
                    }
                    Err(clash) => Outcome::Gone(clash),
                };
            }
            Job::Climb(param, side) => self.best[*param][*side]
                .as_ref()
                .and_then(|best| self.problem.probe(&best.region, &best.point, best.reach)),
            Job::Middle(cell) => self
                .problem
                .probe(&cell.region, &cell.middle(), self.middle),
        };
        let points = probed
            .as_ref()
            .map_or(Vec::new(), |cell| cell.points(first..self.quantities()));
        Outcome::Proved(probed.map(Box::new), points)
    }

    fn take(&mut self, job: &Job, outcome: Outcome) {
        match outcome {
            Outcome::Gone(clash) => {
                self.sets += 1;
                self.passes += clash.passes;
                self.clashes.push(clash);
            }
            Outcome::Left(leaf) => {
                self.sets += 1;
                self.passes += leaf.cell.passes;
                for point in &leaf.points {
                    self.learn(&leaf.cell, point, REACH);
                }
                self.leaves.push(*leaf);
            }
            Outcome::Proved(cell, points) => {
                let before = match job {
                    Job::Climb(param, side) => self.best[*param][*side].clone(),
                    _ => None,
                };
                if let Some(cell) = cell {
                    self.passes += cell.passes;
                    for point in &points {
                        self.learn(&cell, point, 1.0);
                    }
                }
                match job {
                    Job::Climb(param, side) => self.step_back(*param, *side, before),
                    _ => self.middle *= NEARER,
                }
            }
        }
    }

    /// Looks nearer the best point of a parameter, where the last probe brought little.
    fn step_back(&mut self, param: usize, side: usize, before: Option<Best>) {
        let outer = self.outer(self.first() + param);
        let end = if side == 0 { outer.lo() } else { outer.hi() };
        let (Some(before), Some(best)) = (before, &mut self.best[param][side]) else {
            return;
        };
        let missing = (end - before.value).abs();
        if (best.value - before.value).abs() < USEFUL * missing {
            // In the unknowns of the region it was found in now.
            best.reach *= NEARER;
        }
    }

    /// Takes in a proved point; the next probe around it looks so far, as share of what is left of its cell.
    fn learn(&mut self, cell: &Cell, point: &[f64], reach: f64) {
        let at: Vec<Interval> = point.iter().map(|x| Interval::point(*x)).collect();
        let box_: Vec<Interval> = (0..self.quantities())
            .map(|i| cell.region.range(i, &at))
            .collect();
        let mut is_new = self.points.is_empty();
        for (inner, x) in self.inner.iter_mut().zip(&box_) {
            // The point is somewhere in x: only what is between all of it counts.
            *inner = (inner.0.min(x.hi()), inner.1.max(x.lo()));
        }
        let first = self.first();
        for (param, sides) in self.best.iter_mut().enumerate() {
            let x = box_[first + param];
            for (side, (best, value)) in sides.iter_mut().zip([x.hi(), x.lo()]).enumerate() {
                let is_better = best.as_ref().is_none_or(|best| {
                    if side == 0 {
                        value < best.value
                    } else {
                        value > best.value
                    }
                });
                if is_better {
                    is_new = true;
                    *best = Some(Best {
                        region: cell.region.part(&cell.part),
                        point: inside(&cell.part, point),
                        value,
                        reach,
                    });
                }
            }
        }
        if is_new {
            self.points.push(box_);
        }
    }

    /// What is between proved points.
    fn inner(&self, quantity: usize) -> Option<Interval> {
        let (lo, hi) = self.inner[quantity];
        Interval::new(lo, hi)
    }

    /// Proved bounds of a quantity.
    fn outer(&self, quantity: usize) -> Interval {
        self.leaves.iter().fold(Interval::EMPTY, |hull, leaf| {
            hull.hull(leaf.outer[quantity])
        })
    }

    /// How much of a bound may be too wide, as share of what is wanted; by parameter and side.
    fn gaps(&self) -> Vec<(f64, usize, bool)> {
        let mut gaps = Vec::new();
        for quantity in self.first()..self.quantities() {
            let outer = self.outer(quantity);
            if outer.width() == 0.0 {
                continue;
            }
            let (below, above) = match self.inner(quantity) {
                Some(inner) => {
                    let allowed = 0.5 * (self.options.tightness - 1.0) * inner.width();
                    let share = |gap: f64| {
                        if gap <= 0.0 {
                            0.0
                        } else {
                            gap / (allowed + 1e-300)
                        }
                    };
                    (
                        share(inner.lo() - outer.lo()),
                        share(outer.hi() - inner.hi()),
                    )
                }
                None => (f64::INFINITY, f64::INFINITY),
            };
            gaps.push((below, quantity, false));
            gaps.push((above, quantity, true));
        }
        gaps
    }

    /// How far bounds are from what is known to be possible: the sum of gaps, or the widths where nothing is known.
    fn missing(&self) -> f64 {
        let prior = &self.problem.prior;
        let share = |param: usize| {
            let quantity = self.first() + param;
            let whole = prior[param].width().max(1e-300);
            match self.inner(quantity) {
                Some(inner) => (self.outer(quantity).width() - inner.width()).max(0.0) / whole,
                // So that the first point is worth going on.
                None => 1.0 + self.outer(quantity).width() / whole,
            }
        };
        (0..prior.len()).map(share).sum()
    }

    /// The leaves that decide bounds which may be too wide, the worst first.
    fn worst(&self) -> Vec<usize> {
        let mut gaps: Vec<_> = self.gaps().into_iter().filter(|gap| gap.0 > 1.0).collect();
        gaps.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut chosen: Vec<usize> = Vec::new();
        for (_, quantity, upper) in gaps {
            let end = |leaf: &Leaf| {
                let x = leaf.outer[quantity];
                if upper { -x.hi() } else { x.lo() }
            };
            let mut order: Vec<usize> = (0..self.leaves.len())
                .filter(|k| !self.leaves[*k].is_atom)
                .collect();
            order.sort_by(|a, b| end(&self.leaves[*a]).total_cmp(&end(&self.leaves[*b])));
            if let Some(extreme) = order.first()
                && !chosen.contains(extreme)
            {
                chosen.push(*extreme);
            }
        }
        chosen.truncate(AT_ONCE);
        chosen
    }

    pub(crate) fn progress(&self) -> Progress {
        let prior = &self.problem.prior;
        let left = (0..prior.len()).map(|param| {
            let whole = prior[param].width();
            let outer = self.outer(self.first() + param).width();
            if whole > 0.0 { outer / whole } else { 1.0 }
        });
        let tightness = self.bounds(self.first()..self.quantities());
        Progress {
            sets: self.sets,
            waiting: self.leaves.len(),
            left: left.product(),
            tightness: tightness.iter().map(Bounds::tightness).fold(1.0, f64::max),
        }
    }

    /// Goes on, with another region if there is one, until bounds are near enough to the best possible, or the budget
    /// is spent.
    pub(crate) fn run(&mut self, region: Option<Region>, go_on: &dyn Fn(&Progress) -> bool) {
        let mut jobs: Vec<Job> = match region {
            Some(region) => vec![Job::Divide(region)],
            None => self.next_jobs(),
        };
        let patience = PATIENCE.1.max(self.options.sets / PATIENCE.0);
        let mut before = (0, f64::INFINITY);
        while !jobs.is_empty() {
            let search = &*self;
            let outcomes: Vec<Outcome> = jobs.par_iter().map(|job| search.look_at(job)).collect();
            for (job, outcome) in jobs.iter().zip(outcomes) {
                self.take(job, outcome);
            }
            if !go_on(&self.progress()) {
                self.interrupted = true;
                return;
            }
            if self.sets >= before.0 + patience {
                let missing = self.missing();
                if missing > WORTHWHILE * before.1 {
                    return;
                }
                before = (self.sets, missing);
            }
            jobs = self.next_jobs();
        }
    }

    fn next_jobs(&mut self) -> Vec<Job> {
        let mut jobs = self.probes();
        jobs.extend(self.divisions());
        jobs
    }

    /// Where better points may be.
    fn probes(&self) -> Vec<Job> {
        if self.points.is_empty() {
            let ended = |leaf: &Leaf| self.has_ended(&leaf.cell);
            let leaf = self.leaves.iter().find(|leaf| ended(leaf));
            let is_worth_it = self.middle > NEAREST;
            return leaf
                .filter(|_| is_worth_it)
                .map(|leaf| Job::Middle(Box::new(leaf.cell.clone())))
                .into_iter()
                .collect();
        }
        let gaps = self.gaps().into_iter();
        let wanted = gaps
            .filter(|gap| gap.0 > 1.0)
            .map(|(_, quantity, upper)| (quantity - self.first(), usize::from(upper)));
        wanted
            .filter(|(param, side)| {
                let best = self.best[*param][*side].as_ref();
                best.is_some_and(|best| best.reach > NEAREST)
            })
            .map(|(param, side)| Job::Climb(param, side))
            .collect()
    }

    /// Halves of the leaves that decide what is not known well enough.
    fn divisions(&mut self) -> Vec<Job> {
        let mut chosen = self.worst();
        let room = self.options.sets.saturating_sub(self.sets) / 2;
        chosen.truncate(room);
        chosen.sort_unstable_by(|a, b| b.cmp(a));
        let mut jobs = Vec::new();
        for position in chosen {
            match self.leaves[position].cell.halves() {
                Some(halves) => {
                    self.leaves.swap_remove(position);
                    jobs.extend(halves.map(Job::Divide));
                }
                None => self.leaves[position].is_atom = true,
            }
        }
        jobs
    }

    /// Paves the prior, so that undecided tiles are at most this share of the volume that is not excluded.
    pub(crate) fn pave(&mut self, share: f64, go_on: &dyn Fn(&Progress) -> bool) -> Vec<Tile> {
        let mut paving = Paving::new(self.problem);
        let sets = self.options.sets.saturating_mul(TILES_PER_SET);
        let goes_on = paving.run(share, sets, go_on);
        self.interrupted |= !goes_on;
        self.sets += paving.sets;
        self.passes += paving.passes;
        paving.tiles()
    }

    fn bounds(&self, quantities: std::ops::Range<usize>) -> Vec<Bounds> {
        quantities
            .map(|quantity| Bounds {
                outer: self.outer(quantity),
                inner: self.inner(quantity),
            })
            .collect()
    }

    /// What was proved.
    pub(crate) fn answer(self, tiles: Vec<Tile>) -> Identified {
        let n = self.problem.layout.states;
        let first = self.first();
        let conclusion = if self.leaves.is_empty() {
            self.refuted()
        } else if self.points.is_empty() {
            Conclusion::Undecided
        } else {
            Conclusion::Consistent
        };
        let gaps = self.gaps();
        let all_ended = self.leaves.iter().all(|leaf| self.has_ended(&leaf.cell));
        let limits = (first..self.quantities()).map(|quantity| {
            let is_tight = gaps
                .iter()
                .filter(|gap| gap.1 == quantity)
                .all(|gap| gap.0 <= 1.0);
            if is_tight {
                Limit::Record
            } else if all_ended {
                Limit::Budget
            } else {
                Limit::Enclosure
            }
        });
        Identified {
            conclusion,
            limits: limits.collect(),
            params: self.bounds(first..self.quantities()),
            starts: (0..self.problem.courses.len())
                .map(|record| self.bounds(record * n..(record + 1) * n))
                .collect(),
            points: self
                .points
                .iter()
                .map(|point| point[first..].to_vec())
                .collect(),
            tiles,
            sets: self.sets,
            passes: self.passes,
            interrupted: self.interrupted,
        }
    }

    /// Samples that took part last in excluding regions, as candidates, and how far any record was read.
    fn refuted(&self) -> Conclusion {
        let mut all: Vec<(usize, usize)> = Vec::new();
        for clash in &self.clashes {
            match &clash.conflict {
                Conflict::Value { sample, .. } => all.push((*sample, clash.record)),
                Conflict::Rows { samples } => all.extend(samples),
            }
        }
        all.retain(|(sample, _)| *sample != BELIEVED);
        all.sort_unstable();
        all.dedup();
        let record = all.last().map_or(0, |last| last.1);
        let own = all.iter().filter(|(_, own)| *own == record);
        let samples: Vec<usize> = own.map(|(sample, _)| *sample).collect();
        self.problem.refuted(record, samples)
    }
}

/// A point in unknowns of which `part` is the unit box.
fn inside(part: &[Interval], point: &[f64]) -> Vec<f64> {
    let pairs = part.iter().zip(point);
    pairs
        .map(|(part, x)| {
            let (middle, radius) = part.mid_rad();
            if radius > 0.0 {
                (x - middle) / radius
            } else {
                0.0
            }
        })
        .collect()
}
