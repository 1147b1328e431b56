//! How large measurement errors must be at least.
//!
//! The factor of all errors is a quantity, which the search brings together from both sides where sets come to the ends of
//! records. Where they do not, a point is fitted, and lowered without proof before it is proved; and factors below are tried: what the
//! observer and balances refute bounds the least one.

use super::answer::{IdentifyOptions, LeastError, Progress};
use super::balances::Balances;
use super::pave::Paved;
use super::problem::Problem;
use super::rows::widened;
use super::search::Search;
use super::{Keep, narrowed, on_threads};
use veribound_interval::Interval;
use veribound_model::{Model, Sample};

/// How often the largest factor tried is taken of the one before.
const LARGER: f64 = 8.0;

/// Larger ones are tried, too, where no point is known and so much times the least one is as large as those tried.
const NEAR: f64 = 1.05;

/// Factors that are tried at most: measurement errors that large say nothing.
const LARGEST: f64 = 1e9;

/// Factors that are tried below the one of a point, the first as share of that.
const TRIES: usize = 2;
const FIRST: f64 = 0.3;

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
        let keep = Keep::new(&|_| (), go_on);
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
            let told = problem.told_before();
            let is_whole = search.reaches(&told, &keep) || search.reaches_by_windows(&told, &keep);
            let above = search.least().1.map_or(factor.hi(), |least| least.0);
            let state = search.into_state();
            let left = if is_whole {
                None
            } else if Balances::are_there(model) {
                let below = refuted(model, records, above, options.tightness, &keep);
                let left = Interval::new(below.min(factor.hi()), factor.hi());
                problem.factor = Some(left.unwrap_or(factor));
                Some(Ok(problem.believed()))
            } else {
                let wider = scaled(records, factor.hi());
                Some(narrowed(&mut problem, (model, &wider), told, &keep))
            };
            let mut search = Search::with(&problem, options, state);
            search.begin(left, &keep);
            let (below, least) = search.least();
            let spent = search.answer(Paved::default());
            found.sets += spent.sets;
            found.passes += spent.passes;
            found.interrupted = spent.interrupted;
            let above = least.as_ref().map_or(f64::INFINITY, |least| least.0);
            let known = Interval::new(below.max(found.factor.lo()), above);
            found.factor = known.unwrap_or(found.factor);
            found.point = least.map(|least| least.1);
            if found.point.is_some() || found.interrupted || NEAR * below < factor.hi() {
                break;
            }
            tried = Interval::new(factor.hi(), factor.hi() * LARGER);
        }
        found
    };
    on_threads(options.threads, work)
}

/// Records with measurement errors that many times as large, about: they are not narrower than what rows are made from.
fn scaled(records: &[Vec<Sample>], times: f64) -> Vec<Vec<Sample>> {
    let wider = |sample: &Sample| {
        let mut sample = sample.clone();
        for told in sample.outputs.iter_mut().flatten() {
            *told = widened(*told, times);
        }
        sample
    };
    let records = records.iter();
    records
        .map(|samples| samples.iter().map(wider).collect())
        .collect()
}

/// The largest factor that was tried, below one that is known to be enough, of which the observer and balances leave nothing.
fn refuted(
    model: &Model,
    records: &[Vec<Sample>],
    enough: f64,
    tightness: f64,
    keep: &Keep<'_>,
) -> f64 {
    let (mut below, mut open) = (0.0_f64, enough);
    let mut factor = FIRST * enough;
    for _ in 0..TRIES {
        if open <= below * tightness || keep.has_ended() {
            break;
        }
        let wider = scaled(records, factor);
        let mut problem = Problem::of(model, &wider);
        let told = problem.told_before();
        let left = narrowed(&mut problem, (model, &wider), told, keep);
        match left {
            Err(_) => below = factor,
            Ok(_) => open = factor,
        }
        factor = if below > 0.0 {
            (below * open).sqrt()
        } else {
            FIRST * open
        };
    }
    below
}
