//! Identification: the parameters that whole records leave, proved from both sides.

mod answer;
mod balances;
mod begin;
pub(crate) mod cell;
mod disturbance;
mod eigen;
mod frame;
mod gross;
pub(crate) mod held;
mod least;
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
pub use least::least_error;

use balances::Balances;
use cell::{Clash, Known};
use pave::Paved;
use problem::Problem;
use region::Region;
use search::{Search, State};
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
        let balanced = if problem.is_driven_freely() {
            // Equations are integrated in the user's parameters.
            if !problem.is_upright() {
                problem = Problem::upright(model, records);
            }
            let told = problem.told_before();
            Some(narrowed(&mut problem, (model, records), told, &keep))
        } else {
            None
        };
        let (mut search, tiles) = if let Some(saved) = checkpoints.from {
            let mut search = Search::new(&problem, options);
            let tiles = search.read(saved)?;
            if tiles.is_none() {
                search.run(None, &keep);
            }
            (search, tiles)
        } else {
            let (state, left) = match balanced {
                Some(left) => (State::new(&problem), Some(left)),
                None => prepared(&mut problem, (model, records), options, &keep),
            };
            let mut search = Search::with(&problem, options, state);
            search.begin(left, &keep);
            (search, None)
        };
        let tiles = match options.undecided {
            Some(share) if problem.is_upright() => search.pave(&problem, tiles, share, &keep),
            // Tiles are boxes of the user's parameters.
            Some(share) => {
                let upright = Problem::upright(model, records);
                search.pave(&upright, tiles, share, &keep)
            }
            None => Paved::default(),
        };
        let standing = search.progress();
        let mut found = search.answer(tiles);
        if let Conclusion::Inconsistent(refuted) = found.conclusion {
            found.conclusion = problem.confirm(refuted, &|| keep.goes_on(&standing));
            found.interrupted |= keep.has_ended();
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

    /// Whether it was told to end.
    pub(crate) fn has_ended(&self) -> bool {
        self.ends.load(Ordering::Relaxed)
    }

    /// Whether to go on; once that is denied, it stays so.
    pub(crate) fn goes_on(&self, progress: &Progress) -> bool {
        if !self.ends.load(Ordering::Relaxed) && !(self.go_on)(progress) {
            self.ends.store(true, Ordering::Relaxed);
        }
        !self.ends.load(Ordering::Relaxed)
    }
}

/// So often the observer goes through the records, with what balances left of the prior, where inputs may have any course
const LOOKS: usize = 4;

/// and where they are known.
const LOOKS_KNOWN: usize = 12;

/// A look that leaves more than this share of every parameter was the last one.
const NARROWED: f64 = 0.9;

/// States at the samples of every record.
type States = Vec<Vec<Vec<Interval>>>;

/// The observer and balances narrow what is told, in turns: what they leave of all quantities.
fn narrowed(
    problem: &mut Problem,
    records: (&Model, &[Vec<Sample>]),
    told: Vec<Interval>,
    keep: &Keep<'_>,
) -> Result<Vec<Interval>, Clash> {
    narrowed_until(problem, records, (told, None), &mut |_, _| false, keep)
}

/// As [`narrowed`], but no farther than is enough. What an observer has `seen` of all solutions with what is told spares the first one.
fn narrowed_until(
    problem: &mut Problem,
    (model, records): (&Model, &[Vec<Sample>]),
    (mut told, mut seen): (Vec<Interval>, Option<States>),
    is_enough: &mut dyn FnMut(&mut Problem, &[Interval]) -> bool,
    keep: &Keep<'_>,
) -> Result<Vec<Interval>, Clash> {
    let progress = Progress {
        sets: 0,
        waiting: 0,
        left: 1.0,
        tightness: f64::INFINITY,
    };
    let alive = || keep.goes_on(&progress);
    let own = if problem.is_upright() {
        model.clone()
    } else {
        model.with_ratios().0
    };
    let all = problem.told_quantities();
    let mut box_ = problem.around(&told);
    let looks = if problem.is_driven_freely() {
        LOOKS
    } else {
        LOOKS_KNOWN
    };
    for _ in 0..looks {
        let before = box_.clone();
        let seen = match seen.take() {
            Some(seen) => seen,
            None => gross::narrow(problem, model, records, &mut told, &alive)?,
        };
        let cut = |box_: &mut [Interval], by: &[Interval]| {
            let pairs = box_.iter_mut().zip(by);
            pairs.for_each(|(x, by)| *x = x.intersect(*by));
        };
        cut(&mut box_, &problem.around(&told));
        problem.balances = Some(Balances::of(&own, problem, &seen, &box_, &alive));
        let cell = problem.refine(Region::of_box(&box_), Known::default(), false, &alive)?;
        let left: Vec<Interval> = all.iter().map(|own| cell.bounds(*own)).collect();
        cut(&mut told, &left);
        cut(&mut box_, &problem.around(&told));
        let params = |list: &[Interval]| list.get(problem.params()).unwrap_or_default().to_vec();
        let pairs = params(&before).into_iter().zip(params(&box_));
        let mut shares = pairs.map(|(before, now)| {
            let whole = before.width();
            whole == 0.0 || now.width() > NARROWED * whole
        });
        if shares.all(|stays| stays) || !alive() || is_enough(problem, &told) {
            break;
        }
    }
    Ok(box_)
}

/// What is known before the prior is divided, and what the observer and balances leave of it where it is too wide for forms.
fn prepared(
    problem: &mut Problem,
    (model, records): (&Model, &[Vec<Sample>]),
    options: &IdentifyOptions,
    keep: &Keep<'_>,
) -> (State, Option<Result<Vec<Interval>, Clash>>) {
    let mut search = Search::new(problem, options);
    let mut told = problem.told_before();
    if search.reaches(&told, keep) {
        return (search.into_state(), None);
    }
    let seen = {
        let alive = || keep.goes_on(&search.progress());
        gross::narrow(problem, model, records, &mut told, &alive)
    };
    let seen = match seen {
        Ok(seen) => seen,
        Err(clash) => return (search.into_state(), Some(Err(clash))),
    };
    let is_whole = search.reaches(&told, keep) || search.reaches_by_windows(&told, keep);
    let state = search.into_state();
    if is_whole {
        return (state, None);
    }
    let (mut state, mut is_whole) = (state, false);
    let mut is_enough = |problem: &mut Problem, told: &[Interval]| {
        // Windows tell more where inputs are known.
        problem.balances = None;
        let known = std::mem::replace(&mut state, State::new(problem));
        let mut search = Search::with(problem, options, known);
        is_whole = search.reaches(told, keep);
        state = search.into_state();
        is_whole
    };
    let begin = (told, Some(seen));
    let left = narrowed_until(problem, (model, records), begin, &mut is_enough, keep);
    problem.balances = None;
    (state, (!is_whole).then_some(left))
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
