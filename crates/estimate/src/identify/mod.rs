//! Identification: the parameters that whole records leave, proved from both sides.

mod answer;
mod balances;
pub(crate) mod cell;
mod disturbance;
mod eigen;
mod frame;
mod gross;
pub(crate) mod held;
mod outliers;
pub(crate) mod pass;
mod pave;
pub(crate) mod problem;
pub(crate) mod region;
pub(crate) mod rows;
mod search;
pub(crate) mod simplex;
mod told;
mod windows;

pub use answer::{
    AfterReset, Bounds, Checkpoints, Conclusion, Identified, IdentifyOptions, LeastError, Limit,
    Progress, Reason, Refuted, Save, Status, Tile, Turned, Unreadable,
};
pub use disturbance::least_disturbance;
pub use frame::Frame;

use balances::Balances;
use cell::{Clash, Known};
use pave::Paved;
use problem::Problem;
use region::Region;
use search::Search;
use std::sync::atomic::{AtomicBool, Ordering};
use veribound_interval::Interval;
use veribound_model::{Model, Sample};

/// Bounds the parameters of `model` that agree with all `records`, each with start states of its own and samples in
/// order of time.
///
/// Guarantee: that of [`Identified`], also where `go_on`, which is asked now and then, ends it early.
pub fn identify(
    model: &Model,
    records: &[Vec<Sample>],
    options: &IdentifyOptions,
    go_on: &(dyn Fn(&Progress) -> bool + Sync),
) -> Identified {
    let none = Checkpoints {
        from: None,
        save: &|_| (),
    };
    match resume(model, records, options, &none, go_on) {
        Ok(found) => found,
        Err(Unreadable) => unreachable!("PROOF: nothing is read"),
    }
}

/// As [`identify`], which goes on where an earlier run was saved, and saves itself.
///
/// Guarantee: that of [`identify`], with the same result to the bit as a run that was never ended.
///
/// Errors: [`Unreadable`].
pub fn resume(
    model: &Model,
    records: &[Vec<Sample>],
    options: &IdentifyOptions,
    checkpoints: &Checkpoints<'_>,
    go_on: &(dyn Fn(&Progress) -> bool + Sync),
) -> Result<Identified, Unreadable> {
    let work = || {
        let mut problem = Problem::of(model, records);
        let keep = Keep::new(checkpoints.save, go_on);
        let balanced = balanced(&mut problem, (model, records), &keep);
        let mut search = Search::new(&problem, options);
        let tiles = match checkpoints.from {
            Some(saved) => search.read(saved)?,
            None => None,
        };
        if tiles.is_none() {
            match balanced {
                _ if checkpoints.from.is_some() => search.run(None, &keep),
                Ok(Some(box_)) => search.run(Some(Region::of_box(&box_)), &keep),
                Ok(None) => searched(&mut search, (model, records), &keep),
                Err(clash) => search.refute(clash),
            }
        }
        let tiles = match options.undecided {
            Some(share) if problem.is_upright() => search.pave(&problem, tiles, share, &keep),
            // Tiles are boxes of the user's parameters.
            Some(share) => {
                let upright = Problem::upright(model, records);
                search.pave(&upright, tiles, share, &keep)
            }
            None => Paved::default(),
        };
        let mut found = search.answer(tiles);
        if let Conclusion::Inconsistent(refuted) = found.conclusion {
            found.conclusion = problem.confirm(refuted);
        }
        Ok(found)
    };
    on_threads(options.threads, work)
}

/// Whom a search tells how far it is.
pub(crate) struct Keep<'a> {
    save: &'a Save<'a>,
    go_on: &'a (dyn Fn(&Progress) -> bool + Sync),
    /// Whether it was told to end: what it did last is not whole then.
    ends: AtomicBool,
}

impl<'a> Keep<'a> {
    pub(crate) fn new(
        save: &'a Save<'a>,
        go_on: &'a (dyn Fn(&Progress) -> bool + Sync),
    ) -> Keep<'a> {
        let ends = AtomicBool::new(false);
        Keep { save, go_on, ends }
    }

    /// Whether to go on; once that is denied, it stays so.
    pub(crate) fn goes_on(&self, progress: &Progress) -> bool {
        if !self.ends.load(Ordering::Relaxed) && !(self.go_on)(progress) {
            self.ends.store(true, Ordering::Relaxed);
        }
        !self.ends.load(Ordering::Relaxed)
    }
}

/// How often the largest factor tried is taken of the one before.
const LARGER: f64 = 8.0;

/// Factors that are tried at most: measurement errors that large say nothing.
const LARGEST: f64 = 1e9;

/// The least factor of all measurement errors with which `model` agrees with all `records`, from both sides. Inputs and
/// signals are taken as they are.
///
/// Guarantee: that of [`LeastError`], also where `go_on` ends it early.
pub fn least_error(
    model: &Model,
    records: &[Vec<Sample>],
    options: &IdentifyOptions,
    go_on: &(dyn Fn(&Progress) -> bool + Sync),
) -> LeastError {
    let work = || {
        let mut problem = Problem::of(model, records);
        let mut found = LeastError {
            factor: Interval::new(0.0, f64::INFINITY).unwrap_or(Interval::ENTIRE),
            point: None,
            sets: 0,
            passes: 0,
            interrupted: false,
        };
        let mut tried = Interval::new(0.0, 2.0);
        while let Some(factor) = tried.filter(|factor| factor.hi() < LARGEST) {
            problem.factor = Some(factor);
            let mut search = Search::new(&problem, options);
            let wider: Vec<Vec<Sample>> = records
                .iter()
                .map(|samples| {
                    samples
                        .iter()
                        .map(|sample| scaled(sample, factor.hi()))
                        .collect()
                })
                .collect();
            let keep = Keep::new(&|_| (), go_on);
            searched(&mut search, (model, &wider), &keep);
            let (below, least) = search.least();
            let spent = search.answer(Paved::default());
            found.sets += spent.sets;
            found.passes += spent.passes;
            found.interrupted = spent.interrupted;
            let above = least.as_ref().map_or(f64::INFINITY, |least| least.0);
            let known = Interval::new(below.max(found.factor.lo()), above);
            found.factor = known.unwrap_or(found.factor);
            found.point = least.map(|least| least.1);
            if found.point.is_some() || found.interrupted || below < factor.hi() {
                break;
            }
            tried = Interval::new(factor.hi(), factor.hi() * LARGER);
        }
        found
    };
    on_threads(options.threads, work)
}

/// A sample with measurement errors that many times as large, about: it is not narrower than what rows are made from.
fn scaled(sample: &Sample, times: f64) -> Sample {
    let mut sample = sample.clone();
    for told in sample.outputs.iter_mut().flatten() {
        *told = rows::widened(*told, times);
    }
    sample
}

/// So often the observer goes through the records, with what balances left of the prior.
const LOOKS: usize = 4;

/// A look that leaves more than this share of every parameter was the last one.
const NARROWED: f64 = 0.9;

/// Where inputs may have any course, the observer and balances narrow the prior: it is told what they leave of all quantities.
fn balanced(
    problem: &mut Problem,
    (model, records): (&Model, &[Vec<Sample>]),
    keep: &Keep<'_>,
) -> Result<Option<Vec<Interval>>, Clash> {
    if !problem.is_driven_freely() {
        return Ok(None);
    }
    // Equations are integrated in the user's parameters.
    if !problem.is_upright() {
        *problem = Problem::upright(model, records);
    }
    let progress = Progress {
        sets: 0,
        waiting: 0,
        left: 1.0,
        tightness: f64::INFINITY,
    };
    let alive = || keep.goes_on(&progress);
    let mut box_ = problem.believed();
    for _ in 0..LOOKS {
        let before = box_.clone();
        let seen = gross::narrow(problem, model, records, &mut box_, &alive)?;
        problem.balances = Some(Balances::of(model, problem, &seen, &box_, &alive));
        let cell = problem.refine(Region::of_box(&box_), Known::default(), false, &alive)?;
        for (quantity, x) in box_.iter_mut().enumerate() {
            *x = x.intersect(cell.outer(quantity));
        }
        let params = |list: &[Interval]| list.get(problem.params()).unwrap_or_default().to_vec();
        let pairs = params(&before).into_iter().zip(params(&box_));
        let mut shares = pairs.map(|(before, now)| {
            let whole = before.width();
            whole == 0.0 || now.width() > NARROWED * whole
        });
        if shares.all(|stays| stays) || !alive() {
            break;
        }
    }
    Ok(Some(box_))
}

/// Divides the prior, after the observer where it is too wide for forms.
fn searched(search: &mut Search<'_>, (model, records): (&Model, &[Vec<Sample>]), keep: &Keep<'_>) {
    let problem = search.problem();
    if search.reaches(keep) {
        search.run(None, keep);
        return;
    }
    let mut told = problem.told_before();
    let alive = || keep.goes_on(&search.progress());
    match gross::narrow(problem, model, records, &mut told, &alive) {
        Ok(_) => search.run(Some(Region::of_box(&problem.around(&told))), keep),
        Err(clash) => search.refute(clash),
    }
}

/// Does the work with so many threads.
fn on_threads<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.max(1))
        .build();
    match pool {
        Ok(pool) => pool.install(work),
        // The system gives no threads: the one at hand does it.
        Err(_) => work(),
    }
}
