//! The search for the hull: regions are divided where a bound is not yet known to be near the best possible.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one pair of bounds per quantity of a region"
)]

use super::answer::{Bounds, Conclusion, Identified, IdentifyOptions, Limit, Progress, Refuted};
use super::cell::{BELIEVED, Cell, Clash};
use super::pass::Conflict;
use super::problem::Problem;
use super::region::Region;
use rayon::prelude::*;
use veribound_interval::Interval;

/// Regions that are divided at once, whatever the number of threads, so that this never changes a result.
const AT_ONCE: usize = 8;

/// A cell with the proved bounds of every quantity.
struct Leaf {
    cell: Cell,
    outer: Vec<Interval>,
    /// It cannot be divided any further.
    is_atom: bool,
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
    clashes: Vec<Clash>,
    sets: usize,
    passes: usize,
    interrupted: bool,
}

/// What became of a region.
enum Outcome {
    Left(Box<Leaf>, Vec<Vec<Interval>>),
    Gone(Clash),
}

impl<'a> Search<'a> {
    pub(crate) fn new(problem: &'a Problem, options: &'a IdentifyOptions) -> Search<'a> {
        Search {
            problem,
            options,
            leaves: Vec::new(),
            inner: vec![(f64::INFINITY, f64::NEG_INFINITY); problem.believed().len()],
            points: Vec::new(),
            clashes: Vec::new(),
            sets: 0,
            passes: 0,
            interrupted: false,
        }
    }

    /// First of the parameters among the quantities.
    fn first(&self) -> usize {
        self.problem.courses.len() * self.problem.layout.states
    }

    fn quantities(&self) -> usize {
        self.inner.len()
    }

    /// Whether one region that is the whole box comes to the end of every record.
    pub(crate) fn is_within_reach(&self, quantities: &[Interval]) -> bool {
        let cell = self.problem.refine(Region::of_box(quantities));
        cell.map_or(true, |cell| self.has_ended(&cell))
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

    fn look_at(&self, region: Region) -> Outcome {
        let cell = match self.problem.refine(region) {
            Ok(cell) => cell,
            Err(clash) => return Outcome::Gone(clash),
        };
        let outer: Vec<Interval> = (0..self.quantities()).map(|i| cell.outer(i)).collect();
        let points = cell.points(self.first()..self.quantities());
        let boxes = points.iter().map(|point| {
            let at: Vec<Interval> = point.iter().map(|x| Interval::point(*x)).collect();
            (0..outer.len())
                .map(|i| cell.region.range(i, &at))
                .collect()
        });
        let boxes = boxes.collect();
        let leaf = Leaf {
            cell,
            outer,
            is_atom: false,
        };
        Outcome::Left(Box::new(leaf), boxes)
    }

    fn take(&mut self, outcome: Outcome) {
        self.sets += 1;
        match outcome {
            Outcome::Gone(clash) => {
                self.passes += clash.passes;
                self.clashes.push(clash);
            }
            Outcome::Left(leaf, points) => {
                self.passes += leaf.cell.passes;
                self.leaves.push(*leaf);
                for point in points {
                    for (inner, x) in self.inner.iter_mut().zip(&point) {
                        // The point is somewhere in x: only what is between all of it counts.
                        *inner = (inner.0.min(x.hi()), inner.1.max(x.lo()));
                    }
                    self.points.push(point);
                }
            }
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

    /// Goes on until bounds are near enough to the best possible, or the budget is spent.
    pub(crate) fn run(&mut self, regions: Vec<Region>, go_on: &dyn Fn(&Progress) -> bool) {
        let mut next = regions;
        while !next.is_empty() {
            let search = &*self;
            let outcomes: Vec<Outcome> = next
                .into_par_iter()
                .map(|region| search.look_at(region))
                .collect();
            outcomes.into_iter().for_each(|outcome| self.take(outcome));
            next = Vec::new();
            if !go_on(&self.progress()) {
                self.interrupted = true;
                return;
            }
            let mut chosen = self.worst();
            let room = self.options.sets.saturating_sub(self.sets) / 2;
            chosen.truncate(room);
            chosen.sort_unstable_by(|a, b| b.cmp(a));
            for position in chosen {
                let halves = self.leaves[position].cell.halves();
                match halves {
                    Some(halves) => {
                        self.leaves.swap_remove(position);
                        next.extend(halves);
                    }
                    None => self.leaves[position].is_atom = true,
                }
            }
        }
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
    pub(crate) fn answer(self) -> Identified {
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
            tiles: Vec::new(),
            sets: self.sets,
            passes: self.passes,
            interrupted: self.interrupted,
        }
    }

    /// The samples that refute all regions, in the record that has to be read farthest.
    fn refuted(&self) -> Conclusion {
        let mut all: Vec<(usize, usize)> = Vec::new();
        for clash in &self.clashes {
            match &clash.conflict {
                Conflict::Value { sample, .. } => all.push((clash.record, *sample)),
                Conflict::Rows { samples } => all.extend(
                    samples
                        .iter()
                        .filter(|(sample, _)| *sample != BELIEVED)
                        .map(|(sample, record)| (clash.record.max(*record), *sample)),
                ),
            }
        }
        all.sort_unstable();
        all.dedup();
        let record = all.last().map_or(0, |last| last.0);
        let samples: Vec<usize> = all
            .iter()
            .filter(|(own, _)| *own == record)
            .map(|(_, sample)| *sample)
            .collect();
        let last = samples.last().copied().unwrap_or(0);
        let instant = &self.problem.courses[record].instants[last];
        Conclusion::Inconsistent(Refuted {
            record,
            samples,
            time: instant.time.clone(),
            line: instant.line,
        })
    }
}
