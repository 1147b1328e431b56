//! The search for the hull: regions are divided where a bound is not yet known to be near the best possible.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one pair of bounds per quantity of a region"
)]

use super::Keep;
use super::answer::{
    AfterReset, Bounds, Conclusion, Identified, IdentifyOptions, Limit, Progress, Unreadable,
};
use super::cell::{BELIEVED, Cell, Clash, Known};
use super::pass::{Conflict, GoOn};
use super::pave::{self, Paved, Paving};
use super::problem::Problem;
use super::region::{Region, is_thin};
use super::rows::SEVERAL;
use super::told::Told;
use super::windows::Junctions;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use veribound_interval::Interval;

/// Regions that are divided at once, whatever the number of threads, so that this never changes a result.
const AT_ONCE: usize = 8;

/// A cell with the proved bounds of every quantity.
#[derive(Serialize, Deserialize)]
struct Leaf {
    cell: Cell,
    /// Unknowns that are proved to agree with all records.
    points: Vec<Vec<f64>>,
    outer: Vec<Interval>,
    /// It cannot be divided any further.
    is_atom: bool,
}

impl Leaf {
    /// Where it ends, so that the least of several decides a bound.
    fn end(&self, quantity: usize, upper: bool) -> f64 {
        let x = self.outer[quantity];
        if upper { -x.hi() } else { x.lo() }
    }
}

/// A search that brought bounds nearer by less than this factor for a while is over,
const WORTHWHILE: f64 = 0.8;

/// a while being this share of the sets allowed, or so many.
const PATIENCE: (usize, usize) = (10, 30);

/// Bounds of which no point is known miss so many times as much as others.
const UNKNOWN: f64 = 1e9;

/// Where so many sets in a row do not come to the ends of records, and bounds keep this share of their widths all the while, it is over: sets
/// would have to be much smaller.
const HOPELESS: usize = 12;
const SAME: f64 = 0.95;

/// So many tiles of a paving may be moved through the records for every set.
const TILES_PER_SET: usize = 20;

/// How far around a point the first probe looks, as share of the region it was found in,
const REACH: f64 = 0.5;

/// and around the end of a climb,
const CLOSE: f64 = 0.02;

/// one that proves nothing where sets come nowhere is tried so often in all, each time with this share of it,
const SMALLER: i32 = 4;
const SMALL: f64 = 0.1;

/// the next one where a probe was of little use, as share of that,
const NEARER: f64 = 0.4;

/// A climb goes on while a step may bring this share of what is missing,
const WORTH: f64 = 0.05;

/// and where it ends.
const NEAREST: f64 = 0.002;

/// So many climbs of little use end it.
const IDLE: usize = 2;

/// and where no more than this share is missing than then, climbs begin again.
const LESS: f64 = 0.5;

/// Where no point is known, it is looked for so often, and anew after so many sets.
const TRIES: i32 = 6;
const ANEW: usize = 8;

/// A probe was of use if it brought a bound nearer by this share of what was missing.
const USEFUL: f64 = 0.1;

/// The proved point at which a quantity is least or largest, and where to look for a better one.
#[derive(Clone, Serialize, Deserialize)]
struct Best {
    region: Region,
    point: Vec<f64>,
    value: f64,
    reach: f64,
    /// How many probes in a row were of little use,
    idle: usize,
    /// and how much was missing to the bound then.
    missing: f64,
}

impl Best {
    /// Whether its lists have the lengths of a problem with so many quantities.
    fn fits(&self, quantities: usize) -> bool {
        let rows = &self.region.axes;
        let lists = [self.region.centre.len(), rows.len(), self.region.rest.len()];
        lists == [quantities; 3] && rows.iter().all(|row| row.len() == self.point.len())
    }
}

/// What is to be looked at.
enum Job {
    /// A region, with the states and the bounds of quantities that are known of its solutions,
    Divide(Region, Vec<Junctions>, Vec<Interval>),
    /// the same, if one window comes to the end of each record.
    Whole(Region, Vec<Interval>),
    /// About where a course agrees that is fitted from the middle of a region,
    Begin(Region),
    /// around the best point of this quantity and side, from which so much is missing to the bound,
    Climb(usize, usize, f64),
    /// in the middle of a cell, where no point is known, with this reach,
    Middle(Box<Cell>, f64),
    /// or around some point with all values of this quantity.
    All(usize),
}

/// Everything that is known, but of which quantities.
#[derive(Serialize, Deserialize)]
pub(crate) struct State {
    leaves: Vec<Leaf>,
    /// Per quantity the least upper and the largest lower bound of a proved point's value; the points themselves,
    /// as boxes of all quantities.
    inner: Vec<(f64, f64)>,
    points: Vec<Vec<Interval>>,
    /// For each of the quantities that bounds are wanted of the points where it is least and largest.
    best: Vec<[Option<Best>; 2]>,
    /// Whether quantities that bounds are not wanted of, since they last for a stretch only, had all their values around some point.
    had_all: bool,
    /// How often a point was looked for in vain, since so many sets, and where last.
    tries: i32,
    tries_since: usize,
    tried: Option<(Box<Cell>, f64)>,
    clashes: Vec<Clash>,
    sets: usize,
    passes: usize,
    /// What was missing after so many sets.
    judged: (usize, f64),
    /// So many sets in a row did not come to the ends of records, since bounds had these widths.
    idle: usize,
    idle_since: f64,
}

impl State {
    /// Nothing is known.
    pub(crate) fn new(problem: &Problem) -> State {
        State {
            leaves: Vec::new(),
            inner: vec![(f64::INFINITY, f64::NEG_INFINITY); problem.told_before().len()],
            points: Vec::new(),
            best: vec![[None, None]; Search::wanted(problem).len()],
            had_all: false,
            tries: 0,
            tries_since: 0,
            tried: None,
            clashes: Vec::new(),
            sets: 0,
            passes: 0,
            judged: (0, f64::INFINITY),
            idle: 0,
            idle_since: f64::INFINITY,
        }
    }
}

/// A search for bounds.
pub(crate) struct Search<'a> {
    problem: &'a Problem,
    options: &'a IdentifyOptions,
    /// Everything that bounds are told of.
    told: Vec<Told>,
    /// Positions there of what bounds are wanted of,
    wanted: Vec<usize>,
    /// and what of everything is believed before any sample.
    believed: Vec<Interval>,
    state: State,
    interrupted: bool,
}

/// What became of a job.
enum Outcome {
    Left(Box<Leaf>),
    Gone(Clash),
    /// Points that a probe proved, so far around another one, as share of a region.
    Proved(Option<Box<Cell>>, Vec<Vec<f64>>, f64),
}

impl<'a> Search<'a> {
    pub(crate) fn new(problem: &'a Problem, options: &'a IdentifyOptions) -> Search<'a> {
        Search::with(problem, options, State::new(problem))
    }

    /// What of everything that is told bounds are wanted of.
    fn wanted(problem: &Problem) -> Vec<usize> {
        match problem.factor_position() {
            Some(factor) => vec![factor],
            None => problem.lasting(),
        }
    }

    /// Goes on with what another search of the same problem found.
    pub(crate) fn with(
        problem: &'a Problem,
        options: &'a IdentifyOptions,
        state: State,
    ) -> Search<'a> {
        Search {
            problem,
            options,
            told: problem.told_quantities(),
            wanted: Search::wanted(problem),
            believed: problem.told_before(),
            state,
            interrupted: false,
        }
    }

    pub(crate) fn into_state(self) -> State {
        self.state
    }

    /// Bounds of an error are wanted from below alone: any larger one is met, too.
    fn wants_least(&self) -> bool {
        self.problem.factor.is_some()
    }

    /// Looks at all that has these bounds of what is told; it is kept, and all there is, if it is excluded or one window comes to the
    /// end of every record.
    pub(crate) fn reaches(&mut self, told: &[Interval], keep: &Keep<'_>) -> bool {
        let region = Region::of_box(&self.problem.around(told));
        self.keeps(&Job::Whole(region, told.to_vec()), keep)
    }

    /// As [`Search::reaches`] by as many windows as it takes, after a point was looked for.
    pub(crate) fn reaches_by_windows(&mut self, told: &[Interval], keep: &Keep<'_>) -> bool {
        let region = Region::of_box(&self.problem.around(told));
        // Windows may take long, and tell nothing where samples are coarse.
        let begin = Job::Begin(region.clone());
        let begun = self.look_at(&begin, &|| keep.goes_on(&self.progress()));
        self.take(&begin, begun);
        self.keeps(&Job::Divide(region, Vec::new(), told.to_vec()), keep)
    }

    /// Looks at all there is.
    fn keeps(&mut self, job: &Job, keep: &Keep<'_>) -> bool {
        let outcome = self.look_at(job, &|| keep.goes_on(&self.progress()));
        let is_kept = match &outcome {
            Outcome::Left(leaf) => self.has_ended(&leaf.cell),
            _ => true,
        };
        if is_kept {
            self.take(job, outcome);
        }
        is_kept
    }

    fn has_ended(&self, cell: &Cell) -> bool {
        self.problem.ends(&cell.reached)
    }

    /// Begins with what is left of all quantities, if anything is, or goes on with what is known.
    pub(crate) fn begin(&mut self, left: Option<Result<Vec<Interval>, Clash>>, keep: &Keep<'_>) {
        match left {
            Some(Ok(box_)) => self.run(Some(Region::of_box(&box_)), keep),
            Some(Err(clash)) => self.state.clashes.push(clash),
            None => self.run(None, keep),
        }
    }

    fn look_at(&self, job: &Job, go_on: &GoOn<'_>) -> Outcome {
        let wanted: Vec<Told> = self.wanted.iter().map(|at| self.told[*at]).collect();
        let proves = |(_, points): &(Cell, Vec<Vec<f64>>)| !points.is_empty();
        let probe = |region: &Region, point: &[f64], reaches: &[f64]| {
            let cell = self.problem.probe(region, point, reaches, go_on)?;
            let points = cell.points(&wanted);
            Some((cell, points))
        };
        let mut looked = 1.0;
        let probed = match job {
            Job::Divide(region, known, within) => {
                let known = Known {
                    states: known.clone(),
                    quantities: within[..region.centre.len()].to_vec(),
                };
                let refined = self.problem.refine(region.clone(), known, true, go_on);
                return self.left(refined, within, &wanted);
            }
            Job::Whole(region, within) => {
                let refined = self.problem.refine_at_once(region.clone(), go_on);
                return self.left(refined, within, &wanted);
            }
            Job::Begin(region) => {
                let found = self.problem.begin(region, &wanted, go_on);
                return found.map_or(
                    Outcome::Proved(None, Vec::new(), 1.0),
                    |(cell, points, reach)| Outcome::Proved(Some(Box::new(cell)), points, reach),
                );
            }
            Job::Climb(param, side, missing) => {
                let best = self.state.best[*param][*side].as_ref();
                let tries = if self.comes_nowhere(self.wanted[*param], *side == 1) {
                    SMALLER
                } else {
                    1
                };
                best.and_then(|best| {
                    let problem = self.problem;
                    let goal = (wanted[*param], *side == 1);
                    let least = WORTH * missing;
                    let end = problem.climb(&best.region, &best.point, goal, least, go_on)?;
                    let mut probed = None;
                    for smaller in 0..tries {
                        looked = best.reach * SMALL.powi(smaller);
                        probed = probe(&best.region, &end, &vec![looked; end.len()]);
                        if probed.as_ref().is_some_and(proves) {
                            break;
                        }
                    }
                    probed
                })
            }
            Job::All(quantity) => {
                let best = self.state.best.iter().flatten().flatten().next();
                best.and_then(|best| {
                    let (region, axis) =
                        best.region.reaching(*quantity, self.believed[*quantity])?;
                    looked = best.reach * SMALL;
                    let (mut point, mut reaches) =
                        (best.point.clone(), vec![looked; best.point.len()]);
                    (point[axis], reaches[axis]) = (0.0, 1.0);
                    let cell = self.problem.probe(&region, &point, &reaches, go_on)?;
                    let points = cell.points(&[self.told[*quantity]]);
                    Some((cell, points))
                })
            }
            Job::Middle(cell, reach) => {
                looked = *reach;
                let around = |point: &[f64]| match self.problem.fit(&cell.region, point, 1.0, go_on)
                {
                    // It agrees; the question is how much around it is proved.
                    Some(fitted) => (0..TRIES).find_map(|nearer| {
                        let reaches = cell.reaches(reach * NEARER.powi(nearer));
                        probe(&cell.region, &fitted, &reaches).filter(proves)
                    }),
                    None => probe(&cell.region, point, &cell.reaches(*reach)),
                };
                let deepest = around(&cell.deepest().0);
                if deepest.as_ref().is_some_and(proves) {
                    deepest
                } else {
                    // Where rows say little, and nothing of products, their deepest point is anywhere.
                    let middle: Vec<f64> = cell.part.iter().map(|x| x.mid()).collect();
                    around(&middle).filter(proves).or(deepest)
                }
            }
        };
        let (cell, points) = probed.unzip();
        Outcome::Proved(cell.map(Box::new), points.unwrap_or_default(), looked)
    }

    /// What a region was narrowed to, with what is proved of it, points where those `wanted` are least and largest among that.
    fn left(&self, refined: Result<Cell, Clash>, within: &[Interval], wanted: &[Told]) -> Outcome {
        match refined {
            Ok(cell) => {
                // Regions may reach out of what they are parts of a little, and more where it ends early.
                let pairs = self.told.iter().zip(within);
                let outer = pairs.map(|(told, x)| cell.bounds(*told).intersect(*x));
                Outcome::Left(Box::new(Leaf {
                    outer: outer.collect(),
                    points: cell.points(wanted),
                    cell,
                    is_atom: false,
                }))
            }
            Err(clash) => Outcome::Gone(clash),
        }
    }

    fn take(&mut self, job: &Job, outcome: Outcome) {
        match outcome {
            Outcome::Gone(clash) => {
                self.state.sets += 1;
                self.state.passes += clash.passes;
                self.state.clashes.push(clash);
            }
            Outcome::Left(leaf) => {
                self.state.sets += 1;
                self.state.passes += leaf.cell.passes;
                self.state.idle = if self.has_ended(&leaf.cell) {
                    0
                } else {
                    self.state.idle + 1
                };
                for point in &leaf.points {
                    self.learn(&leaf.cell, point, 1.0);
                }
                self.state.leaves.push(*leaf);
            }
            Outcome::Proved(cell, points, looked) => {
                let before = match job {
                    Job::Climb(param, side, _) => self.state.best[*param][*side].clone(),
                    _ => None,
                };
                if let Job::Middle(from, reach) = job {
                    self.state.tries += 1;
                    let ended = cell.clone().filter(|cell| self.has_ended(cell));
                    self.state.tried = Some(match ended {
                        Some(cell) => (cell, REACH),
                        None => (from.clone(), NEARER * reach),
                    });
                }
                if let Some(cell) = cell {
                    self.state.passes += cell.passes;
                    for point in &points {
                        match job {
                            // It is as good as the one that it is around.
                            Job::All(_) => drop(self.note(&cell, point)),
                            _ => self.learn(&cell, point, looked),
                        }
                    }
                }
                if let Job::Climb(param, side, missing) = job {
                    self.pace((*param, *side), before, *missing);
                }
            }
        }
    }

    /// Looks nearer the end of a climb where the last one brought little.
    fn pace(&mut self, (param, side): (usize, usize), before: Option<Best>, missing: f64) {
        let (Some(before), Some(best)) = (before, &mut self.state.best[param][side]) else {
            return;
        };
        if (best.value - before.value).abs() >= USEFUL * missing {
            best.idle = 0;
        } else {
            best.idle = before.idle + 1;
            best.reach = NEARER * before.reach;
        }
        best.missing = missing;
    }

    /// What is told at a proved point of a cell, which bounds are not narrower than.
    fn note(&mut self, cell: &Cell, point: &[f64]) -> Vec<Interval> {
        let at: Vec<Interval> = point.iter().map(|x| Interval::point(*x)).collect();
        let told = self.told.iter();
        let box_: Vec<Interval> = told.map(|told| told.range(&cell.region, &at)).collect();
        for (inner, x) in self.state.inner.iter_mut().zip(&box_) {
            // The point is somewhere in x: only what is between all of it counts.
            *inner = (inner.0.min(x.hi()), inner.1.max(x.lo()));
        }
        box_
    }

    /// Takes in a proved point of a cell that was made by looking so far around another one, as share of a region.
    fn learn(&mut self, cell: &Cell, point: &[f64], looked: f64) {
        let mut is_new = self.state.points.is_empty();
        let box_ = self.note(cell, point);
        for (quantity, sides) in self.wanted.iter().zip(&mut self.state.best) {
            let x = box_[*quantity];
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
                    // As large as that region, so that lengths keep their meaning.
                    let larger = cell.part.iter().map(|x| {
                        let (middle, radius) = x.mid_rad();
                        Interval::point(middle) + Interval::symmetric(radius / looked)
                    });
                    let larger: Vec<Interval> = larger.collect();
                    *best = Some(Best {
                        region: cell.region.part(&larger),
                        point: inside(&larger, point),
                        value,
                        reach: CLOSE,
                        idle: best.as_ref().map_or(0, |best| best.idle),
                        missing: best.as_ref().map_or(f64::INFINITY, |best| best.missing),
                    });
                }
            }
        }
        if is_new {
            self.state.points.push(box_);
        }
    }

    /// What is between proved points.
    fn inner(&self, quantity: usize) -> Option<Interval> {
        let (lo, hi) = self.state.inner[quantity];
        Interval::new(lo, hi)
    }

    /// Proved bounds of a quantity.
    fn outer(&self, quantity: usize) -> Interval {
        self.state
            .leaves
            .iter()
            .fold(Interval::EMPTY, |hull, leaf| {
                hull.hull(leaf.outer[quantity])
            })
    }

    /// How much of a bound may be too wide, as share of what is wanted; by parameter and side.
    fn gaps(&self) -> Vec<(f64, usize, bool)> {
        let wanted = self.wanted.iter();
        let gaps = wanted.flat_map(|quantity| {
            let sides = [false, true].into_iter().zip(self.gap(*quantity));
            let sides = sides.filter(|(upper, _)| !(*upper && self.wants_least()));
            sides.map(|(upper, gap)| (gap, *quantity, upper))
        });
        gaps.collect()
    }

    /// The same below and above, of one of them that may be wide.
    fn gap(&self, quantity: usize) -> Vec<f64> {
        let outer = self.outer(quantity);
        if outer.width() == 0.0 || is_thin(self.believed[quantity]) {
            return Vec::new();
        }
        let Some(inner) = self.inner(quantity) else {
            return vec![f64::INFINITY; 2];
        };
        let allowed = (self.options.tightness - 1.0)
            * if self.wants_least() {
                inner.lo()
            } else {
                0.5 * inner.width()
            };
        let share = |gap: f64| {
            if gap <= 0.0 {
                0.0
            } else {
                gap / (allowed + 1e-300)
            }
        };
        vec![
            share(inner.lo() - outer.lo()),
            share(outer.hi() - inner.hi()),
        ]
    }

    /// The widths of bounds, as shares of what was believed.
    fn widths(&self) -> f64 {
        let share = |quantity: usize| {
            let whole = self.believed[quantity].width().max(1e-300);
            self.outer(quantity).width() / whole
        };
        self.wanted.iter().copied().map(share).sum()
    }

    /// How far bounds are from what is wanted, on a logarithmic scale: the sum of gaps, or the widths where nothing is known.
    fn missing(&self) -> f64 {
        let share = |(gap, quantity, _): (f64, usize, bool)| {
            if gap.is_finite() {
                return gap.clamp(1.0, UNKNOWN).ln();
            }
            // So that the first point is worth going on.
            let whole = self.believed[quantity].width().max(1e-300);
            (UNKNOWN * self.outer(quantity).width() / whole).ln()
        };
        self.gaps().into_iter().map(share).sum()
    }

    /// The leaves that decide bounds which may be too wide, the worst first.
    fn worst(&self) -> Vec<usize> {
        let mut gaps: Vec<_> = self.gaps().into_iter().filter(|gap| gap.0 > 1.0).collect();
        gaps.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut chosen: Vec<usize> = Vec::new();
        for (_, quantity, upper) in gaps {
            let end = |position: &usize| self.state.leaves[*position].end(quantity, upper);
            let mut order: Vec<usize> = (0..self.state.leaves.len())
                .filter(|k| !self.state.leaves[*k].is_atom)
                .collect();
            order.sort_by(|a, b| end(a).total_cmp(&end(b)));
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
        let left = self.wanted.iter().map(|&quantity| {
            let whole = self.believed[quantity].width();
            let outer = self.outer(quantity).width();
            if whole > 0.0 { outer / whole } else { 1.0 }
        });
        let tightness = self.bounds(self.wanted.iter().copied());
        Progress {
            sets: self.state.sets,
            waiting: self.state.leaves.len(),
            left: left.product(),
            tightness: tightness.iter().map(Bounds::tightness).fold(1.0, f64::max),
        }
    }

    /// Goes on, with another region if there is one, until bounds are near enough to the best possible, or the budget
    /// is spent.
    pub(crate) fn run(&mut self, region: Option<Region>, keep: &Keep<'_>) {
        // What is divided stands as it is until its halves are looked at.
        let mut standing = self.progress();
        let mut jobs: Vec<Job> = match region {
            Some(region) => {
                let within = self.believed.clone();
                vec![Job::Divide(region, Vec::new(), within)]
            }
            None if keep.goes_on(&standing) => self.next_jobs(),
            None => {
                self.interrupted = true;
                return;
            }
        };
        let patience = PATIENCE.1.max(self.options.sets / PATIENCE.0);
        while !jobs.is_empty() {
            let search = &*self;
            let go_on: &GoOn<'_> = &|| keep.goes_on(&standing);
            let looked = jobs.par_iter().map(|job| search.look_at(job, go_on));
            let outcomes: Vec<Outcome> = looked.collect();
            for (job, outcome) in jobs.iter().zip(outcomes) {
                self.take(job, outcome);
            }
            standing = self.progress();
            if !keep.goes_on(&standing) {
                self.interrupted = true;
                return;
            }
            let widths = self.widths();
            if widths < SAME * self.state.idle_since {
                (self.state.idle, self.state.idle_since) = (0, widths);
            }
            if self.state.idle >= HOPELESS {
                return;
            }
            let (since, before) = self.state.judged;
            if self.state.sets >= since + patience {
                let missing = self.missing();
                if missing > before + WORTHWHILE.ln() {
                    return;
                }
                self.state.judged = (self.state.sets, missing);
            }
            (keep.save)(&|| self.saved(None));
            jobs = self.next_jobs();
        }
    }

    fn next_jobs(&mut self) -> Vec<Job> {
        let mut jobs = self.probes();
        jobs.extend(self.divisions());
        jobs
    }

    /// Where better points may be.
    fn probes(&mut self) -> Vec<Job> {
        if self.state.points.is_empty() {
            if self.state.sets >= self.state.tries_since + ANEW {
                (self.state.tries, self.state.tries_since) = (0, self.state.sets);
                self.state.tried = None;
            }
            if self.state.tries >= TRIES {
                return Vec::new();
            }
            // Each time about where rows of the last place are met best.
            if let Some((cell, reach)) = self.state.tried.take() {
                return vec![Job::Middle(cell, reach)];
            }
            let depths = self
                .state
                .leaves
                .iter()
                .map(|leaf| (leaf, leaf.cell.deepest().1));
            return depths
                .max_by(|a, b| a.1.total_cmp(&b.1))
                .map(|(leaf, _)| Job::Middle(Box::new(leaf.cell.clone()), REACH))
                .into_iter()
                .collect();
        }
        let gaps: Vec<_> = self.gaps().into_iter().filter(|gap| gap.0 > 1.0).collect();
        let position = |quantity| self.wanted.iter().position(|own| *own == quantity);
        let mut jobs = Vec::new();
        if !self.state.had_all && !self.wants_least() {
            self.state.had_all = true;
            let passing = self.problem.told_params().into_iter();
            let passing = passing.filter(|quantity| self.problem.params().contains(quantity));
            jobs.extend(passing.filter(|own| position(*own).is_none()).map(Job::All));
        }
        let mut ended = Vec::new();
        for (_, quantity, upper) in gaps {
            let Some(param) = position(quantity) else {
                continue;
            };
            let side = usize::from(upper);
            let outer = self.outer(quantity);
            let end = if upper { outer.hi() } else { outer.lo() };
            let nowhere = self.comes_nowhere(quantity, upper);
            let known = self.inner(quantity);
            let Some(best) = self.state.best[param][side].as_mut() else {
                continue;
            };
            let mut missing = (end - best.value).abs();
            if missing < LESS * best.missing {
                // Against bounds that were far too wide everything was of little use.
                (best.idle, best.reach) = (0, CLOSE);
            }
            if nowhere {
                missing = missing.min(known.map_or(missing, |x| x.width()));
            }
            if best.reach > NEAREST && best.idle < IDLE {
                jobs.push(Job::Climb(param, side, missing));
            } else {
                ended.push((quantity, upper));
            }
        }
        // Where it goes no farther from the best points, better ones may be in the sets that decide the bounds.
        if self.state.sets >= self.state.tries_since + ANEW {
            self.state.tries_since = self.state.sets;
            let mut tried = Vec::new();
            for (quantity, upper) in ended {
                if let Some(leaf) = self.extreme(quantity, upper)
                    && !tried.contains(&leaf)
                {
                    tried.push(leaf);
                    let cell = self.state.leaves[leaf].cell.clone();
                    jobs.push(Job::Middle(Box::new(cell), REACH));
                }
            }
        }
        jobs
    }

    /// Whether what decides a bound does not come to the ends of records, so that it says nothing of how far points may be.
    fn comes_nowhere(&self, quantity: usize, upper: bool) -> bool {
        let leaf = self.extreme(quantity, upper);
        let leaf = leaf.map(|leaf| &self.state.leaves[leaf].cell);
        leaf.is_some_and(|cell| !self.has_ended(cell)) && !self.wants_least()
    }

    /// The leaf that decides a bound.
    fn extreme(&self, quantity: usize, upper: bool) -> Option<usize> {
        let end = |position: &usize| self.state.leaves[*position].end(quantity, upper);
        (0..self.state.leaves.len()).min_by(|a, b| end(a).total_cmp(&end(b)))
    }

    /// Halves of the leaves that decide what is not known well enough.
    fn divisions(&mut self) -> Vec<Job> {
        if self.is_full() {
            return Vec::new();
        }
        let mut chosen = self.worst();
        let room = self.options.sets.saturating_sub(self.state.sets) / 2;
        chosen.truncate(room);
        chosen.sort_unstable_by(|a, b| b.cmp(a));
        let mut jobs = Vec::new();
        for position in chosen {
            match self.state.leaves[position].cell.halves() {
                Some(halves) => {
                    let Leaf { cell, outer, .. } = self.state.leaves.swap_remove(position);
                    let divide = |half| Job::Divide(half, cell.junctions.clone(), outer.clone());
                    jobs.extend(halves.map(divide));
                }
                None => self.state.leaves[position].is_atom = true,
            }
        }
        jobs
    }

    /// Paves the prior of the problem, whose parameters are the user's, so that undecided tiles are at most this share of the volume that is not excluded.
    pub(crate) fn pave(
        &mut self,
        problem: &Problem,
        begun: Option<pave::State>,
        share: f64,
        keep: &Keep<'_>,
    ) -> Paved {
        let params = self.problem.told_params().into_iter();
        let outer: Vec<Interval> = params.map(|at| self.outer(at)).collect();
        let mut paving = Paving::new(problem, begun, share, &outer);
        let sets = self.options.sets.saturating_mul(TILES_PER_SET);
        let limits = (sets, self.options.memory);
        let save = |state: &pave::State| (keep.save)(&|| self.saved(Some(state)));
        let go_on = |progress: &Progress| keep.goes_on(progress);
        let goes_on = paving.run(limits, &save, &go_on);
        self.interrupted |= !goes_on;
        self.state.sets += paving.state.sets;
        self.state.passes += paving.state.passes;
        paving.tiles()
    }

    /// All that is known, so that [`Search::read`] can go on from it; with the tiles, where there are some already.
    fn saved(&self, tiles: Option<&pave::State>) -> Vec<u8> {
        // Writing to memory does not fail; who reads nothing begins anew.
        postcard::to_stdvec(&(&self.state, tiles)).unwrap_or_default()
    }

    /// Goes back to what was saved, and tells the tiles.
    ///
    /// Errors: [`Unreadable`] where it is of another problem, or no such thing.
    pub(crate) fn read(&mut self, saved: &[u8]) -> Result<Option<pave::State>, Unreadable> {
        let read: Result<(State, Option<pave::State>), _> = postcard::from_bytes(saved);
        let (state, tiles) = read.map_err(|_| Unreadable)?;
        let (told, quantities) = (self.told.len(), self.problem.params().end);
        let (lengths, records) = (
            (quantities, self.problem.layout.states),
            self.problem.courses.len(),
        );
        let fits = |leaf: &Leaf| leaf.outer.len() == told && leaf.cell.fits(lengths, records);
        let is_own = state.inner.len() == told
            && state.best.len() == self.wanted.len()
            && state.points.iter().all(|point| point.len() == told)
            && state
                .best
                .iter()
                .flatten()
                .flatten()
                .all(|best| best.fits(quantities))
            && state
                .tried
                .iter()
                .all(|(cell, _)| cell.fits(lengths, records))
            && state.leaves.iter().all(fits)
            && (tiles.iter()).all(|tiles| tiles.fits(self.problem.layout.params));
        if !is_own {
            return Err(Unreadable);
        }
        self.state = state;
        Ok(tiles)
    }

    /// What the leaves take in memory, about.
    fn bytes(&self) -> usize {
        self.state.leaves.iter().map(|leaf| leaf.cell.bytes()).sum()
    }

    /// Whether no more may be kept.
    fn is_full(&self) -> bool {
        self.options.memory < usize::MAX && self.bytes() > self.options.memory
    }

    fn bounds(&self, quantities: impl Iterator<Item = usize>) -> Vec<Bounds> {
        quantities
            .map(|quantity| Bounds {
                outer: self.outer(quantity),
                inner: self.inner(quantity),
            })
            .collect()
    }

    /// What is known of the values that parameters have after resets.
    fn resets(&self, record: usize) -> Vec<AfterReset> {
        let course = &self.problem.courses[record];
        let time = |sample: usize| course.instants[sample].time.clone();
        let after = self.problem.after_resets(record);
        after
            .map(|(later, quantity)| AfterReset {
                param: later.param,
                from: time(later.from),
                until: time(later.until.min(course.end())),
                bounds: Bounds {
                    outer: self.outer(quantity),
                    inner: self.inner(quantity),
                },
            })
            .collect()
    }

    /// The least factor of errors that is not excluded, and the least with which a point is proved to agree, with its
    /// parameters.
    pub(crate) fn least(&self) -> (f64, Option<(f64, Vec<Interval>)>) {
        let factor = self.wanted[0];
        let left = self.outer(factor);
        let below = if left.is_empty() {
            self.believed[factor].hi()
        } else {
            left.lo()
        };
        let least =
            |a: &&Vec<Interval>, b: &&Vec<Interval>| a[factor].hi().total_cmp(&b[factor].hi());
        let best = self.state.points.iter().min_by(least);
        let params = self.problem.told_params();
        let params_of = |point: &[Interval]| params.iter().map(|at| point[*at]).collect();
        (
            below,
            best.map(|point| (point[factor].hi(), params_of(point))),
        )
    }

    /// What was proved.
    pub(crate) fn answer(self, paved: Paved) -> Identified {
        let params = self.problem.told_params();
        let conclusion = if self.state.leaves.is_empty() {
            self.refuted()
        } else if self.state.points.is_empty() {
            Conclusion::Undecided
        } else {
            Conclusion::Consistent
        };
        let all_ended = self
            .state
            .leaves
            .iter()
            .all(|leaf| self.has_ended(&leaf.cell));
        let limits = params.iter().map(|&quantity| {
            let is_tight = self.gap(quantity).into_iter().all(|gap| gap <= 1.0);
            if is_tight {
                Limit::Record
            } else if self.is_full() {
                Limit::Memory
            } else if all_ended {
                Limit::Budget
            } else if self.problem.balances.is_some() {
                Limit::Inputs
            } else {
                Limit::Enclosure
            }
        });
        Identified {
            conclusion,
            limits: limits.collect(),
            params: self.bounds(params.iter().copied()),
            resets: (0..self.problem.courses.len())
                .map(|record| self.resets(record))
                .collect(),
            starts: (0..self.problem.courses.len())
                .map(|record| self.bounds(self.problem.starts(record)))
                .collect(),
            points: self
                .state
                .points
                .iter()
                .map(|point| params.iter().map(|at| point[*at]).collect())
                .collect(),
            tiles: paved.tiles,
            frames: paved.frames,
            volume: paved.volume,
            sets: self.state.sets,
            passes: self.state.passes,
            interrupted: self.interrupted,
        }
    }

    /// Samples that took part last in excluding regions, as candidates, and how far any record was read.
    fn refuted(&self) -> Conclusion {
        let mut all: Vec<(usize, usize)> = Vec::new();
        for clash in &self.state.clashes {
            match &clash.conflict {
                Conflict::Value { sample, .. } => all.push((*sample, clash.record)),
                Conflict::Rows { samples } => all.extend(samples),
            }
        }
        all.retain(|(sample, _)| *sample != BELIEVED);
        all.sort_unstable();
        all.dedup();
        let record = all.last().map_or(0, |last| last.1);
        let own = all
            .iter()
            .filter(|(sample, own)| *own == record && *sample != SEVERAL);
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
