//! How large errors of inputs and disturbances must be at least, by trying.
//!
//! Any that is large enough is so for all larger ones, so a factor that is refuted bounds the least one from below, and
//! one with which a point is proved to agree from above. Between them others are tried.

use super::answer::{Conclusion, IdentifyOptions, LeastError, Progress};
use super::held::is_wide;
use super::pave::Paved;
use super::problem::Problem;
use super::rows::{READ, widened};
use super::search::Search;
use super::{Keep, on_threads, prepared};
use veribound_interval::Interval;
use veribound_interval::round::{add_up, div_up, mul_up};
use veribound_model::{Model, Sample};

/// The first factor that is tried, and how often the next one is taken of it.
const FIRST: f64 = 1.0;
const LARGER: f64 = 4.0;

/// Factors above this, and below its inverse, are not tried.
const LARGEST: f64 = 1e6;

/// More than rounding adds to an interval that is widened, and to what compares it with the exact one, as share of the factor.
const ROUNDED: f64 = 1e-11;

/// Most factors that are tried.
const TRIES: usize = 24;

/// The least factor of all errors of inputs, and of disturbances around their middles, with which `model` agrees with
/// all `records`, from both sides. Measurement errors and signals are taken as they are.
///
/// Guarantee: that of [`LeastError`] for these half widths, also where `go_on` ends it early; `None` where no sample says
/// anything that could be larger.
pub fn least_disturbance(
    model: &Model,
    records: &[Vec<Sample>],
    options: &IdentifyOptions,
    go_on: &(dyn Fn(&Progress) -> bool + Sync),
) -> Option<LeastError> {
    let inputs = records.iter().flatten().flat_map(|sample| &sample.inputs);
    let uncertain: Vec<Interval> = inputs.copied().filter(|x| is_wide(*x)).collect();
    if uncertain.is_empty() {
        return None;
    }
    Some(on_threads(options.threads, || {
        let mut trial = Trial {
            model,
            records,
            options: IdentifyOptions {
                // Any point will do.
                tightness: f64::INFINITY,
                undecided: None,
                ..options.clone()
            },
            go_on,
            found: LeastError {
                factor: Interval::new(0.0, f64::INFINITY).unwrap_or(Interval::ENTIRE),
                point: None,
                sets: 0,
                passes: 0,
                interrupted: false,
            },
            slack: uncertain.iter().map(|x| slack(*x)).fold(0.0, f64::max),
        };
        trial.search(options.tightness);
        trial.found
    }))
}

/// What rounding may add to a widened interval, as share of its half width: more is needed of the exact one.
fn slack(x: Interval) -> f64 {
    let read = mul_up(x.mag(), READ);
    mul_up(4.0, div_up(read, x.rad()))
}

struct Trial<'a> {
    model: &'a Model,
    records: &'a [Vec<Sample>],
    options: IdentifyOptions,
    go_on: &'a (dyn Fn(&Progress) -> bool + Sync),
    found: LeastError,
    slack: f64,
}

impl Trial<'_> {
    fn search(&mut self, tightness: f64) {
        let mut factor = FIRST;
        // Between these nothing was decided.
        let mut open: Option<(f64, f64)> = None;
        let mut from_below = false;
        for _ in 0..TRIES {
            if !(1.0 / LARGEST..=LARGEST).contains(&factor) {
                return;
            }
            if !self.is_decided(factor) {
                let around = open.unwrap_or((factor, factor));
                open = Some((around.0.min(factor), around.1.max(factor)));
            }
            if self.found.interrupted {
                return;
            }
            let (lo, hi) = (self.found.factor.lo(), self.found.factor.hi());
            let is_near = |lo: f64, hi: f64| hi <= lo * tightness;
            factor = match (open, lo > 0.0, hi.is_finite()) {
                _ if is_near(lo, hi) => return,
                (None, true, true) => (lo * hi).sqrt(),
                (None, false, _) => hi / LARGER,
                (None, true, false) => lo * LARGER,
                (Some((first, last)), ..) => {
                    // On both sides of it in turn.
                    let below = if lo > 0.0 {
                        (lo * first).sqrt()
                    } else {
                        first / LARGER
                    };
                    let above = if hi.is_finite() {
                        (last * hi).sqrt()
                    } else {
                        last * LARGER
                    };
                    let done = [is_near(lo, first), is_near(last, hi)];
                    if done == [true, true] {
                        return;
                    }
                    from_below = (!from_below || done[1]) && !done[0];
                    if from_below { below } else { above }
                }
            };
        }
    }

    /// Whether it was proved that this factor is enough, or that it is not.
    fn is_decided(&mut self, factor: f64) -> bool {
        let scaled = |sample: &Sample| {
            let mut sample = sample.clone();
            for input in sample.inputs.iter_mut().filter(|input| is_wide(**input)) {
                *input = widened(*input, factor);
            }
            sample
        };
        let wider = self.records.iter();
        let wider: Vec<Vec<Sample>> = wider
            .map(|samples| samples.iter().map(scaled).collect())
            .collect();
        let mut problem = Problem::of(self.model, &wider);
        let keep = Keep::new(&|_| (), self.go_on);
        let (state, left) = prepared(&mut problem, (self.model, &wider), &self.options, &keep);
        let mut search = Search::with(&problem, &self.options, state);
        search.begin(left, &keep);
        let ended = search.answer(Paved::default());
        self.found.sets += ended.sets;
        self.found.passes += ended.passes;
        self.found.interrupted = ended.interrupted;
        let known = self.found.factor;
        let (lo, hi) = match ended.conclusion {
            Conclusion::Inconsistent(_) => (factor.max(known.lo()), known.hi()),
            Conclusion::Consistent => {
                let enough = mul_up(factor, add_up(1.0 + ROUNDED, self.slack));
                let enough = add_up(enough, self.slack);
                if enough < known.hi() {
                    self.found.point = ended.points.first().cloned();
                }
                (known.lo(), enough.min(known.hi()))
            }
            Conclusion::Undecided => return false,
        };
        self.found.factor = Interval::new(lo, hi).unwrap_or(known);
        true
    }
}
