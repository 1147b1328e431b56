//! Strips online: what samples say of parameters together, in a bounded number of rows and a fixed budget of work.
//!
//! A *runner* moves a form from sample to sample; every sample is a strip in the form's unknowns, and linear programs over
//! the strips narrow them. What is not affine in a form that was made for a wide set does not shrink with the set. So
//! when much less is left than what a runner began with, a second one begins at the oldest sample that is kept, with what
//! is left, and meets several samples for each new one, until it has caught up and takes over. Where a form tells
//! nothing more of later samples (it is too wide, or a crossing is not proved), it ends, and another one goes on
//! from the last sample that told something, with the box of states there and all that is known of parameters.
//!
//! All bounds hold for every solution that agrees with the samples so far: that of a runner is a set of such solutions
//! at some sample, and rows that are left out only leave more.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: lists as long as the model's; samples are checked when they come in"
)]

mod going;
mod past;
mod runner;

use std::sync::Arc;

use crate::identify::held::Held;
use crate::identify::problem::Problem;
use crate::identify::region::Region;
use crate::options::ObserverOptions;
use crate::verdict::{Contradiction, distance};
use going::{Going, Next};
use past::{Moment, Past};
use runner::{Clash, Fate, PATIENCE, Runner};
use veribound_flow::form::Allowance;
use veribound_interval::{Decimal, Interval};
use veribound_model::{Model, Sample};

/// A set is moved through the samples anew when less than this share of an axis is left.
const WORTHWHILE: f64 = 0.7;

/// Where a set could not be moved at all, the next one begins so many samples later.
const PAUSE: u64 = 16;

/// So often it is asked whether that is so, in samples.
const ASKS: u64 = 16;

/// Strips of a record on its way.
pub(crate) struct Polytope {
    problem: Arc<Problem>,
    /// For every quantity that a signal proves to be zero, the signal.
    signals: Vec<usize>,
    rows: usize,
    replay: usize,
    history: usize,
    /// Products of coefficients that a sample may take, and what is left of them.
    budget: i64,
    allowance: Arc<Allowance>,
    /// What the last sample took.
    pub(crate) spent: u64,
    past: Past,
    /// Parameters that are left.
    known: Vec<Interval>,
    /// The one that met most samples,
    live: Option<Going>,
    /// and one that is to catch up with it.
    chaser: Option<Going>,
    /// Whether it is to be asked if a set should begin anew.
    is_due: bool,
    /// What was known of parameters when the last one began at the oldest sample.
    begun: Vec<Interval>,
    /// No set begins anew before this sample, unless more is known.
    pause: u64,
}

/// What is left after a sample.
pub(crate) struct Left {
    pub(crate) params: Vec<Interval>,
    /// States at the sample, where the strips got so far.
    pub(crate) states: Option<Vec<Interval>>,
}

/// That nothing is left.
pub(crate) struct Refuted {
    /// The sample that cannot be met, with its line and time.
    pub(crate) sample: u64,
    pub(crate) line: usize,
    pub(crate) time: Decimal,
    pub(crate) contradiction: Contradiction,
}

/// What boxes say of a sample.
pub(crate) struct Boxes<'a> {
    /// Number of the sample, and time since the one before.
    pub(crate) position: u64,
    pub(crate) dt: Interval,
    /// For every signal whether it proves something now.
    pub(crate) proves: &'a dyn Fn(usize) -> bool,
    /// Parameters that may be new from now on.
    pub(crate) resets: &'a [bool],
    /// Enclose states and parameters of all solutions that agree with the samples.
    pub(crate) states: Vec<Interval>,
    pub(crate) params: Vec<Interval>,
}

impl Polytope {
    pub(crate) fn new(model: &Model, options: &ObserverOptions) -> Polytope {
        let problem = Problem::new(model, Held::default());
        let signals = model.signals.iter().enumerate();
        let signals = signals.flat_map(|(at, signal)| signal.proves_zero.iter().map(move |_| at));
        Polytope {
            signals: signals.collect(),
            rows: options.rows.max(1),
            replay: options.replay.max(1),
            history: options.history,
            budget: i64::try_from(options.budget.max(1)).unwrap_or(i64::MAX),
            allowance: Arc::default(),
            spent: 0,
            past: Past::default(),
            known: problem.prior.clone(),
            begun: vec![Interval::ENTIRE; problem.prior.len()],
            pause: 0,
            live: None,
            chaser: None,
            is_due: false,
            problem: Arc::new(problem),
        }
    }

    /// Takes a sample, with what boxes say of it.
    ///
    /// Guarantee: every solution that agrees with the samples so far has its parameters, and states now, in what is left;
    /// a refutation proves that there is none.
    pub(crate) fn take(&mut self, sample: &Sample, boxes: Boxes<'_>) -> Result<Left, Refuted> {
        self.note(sample, &boxes)?;
        // What was left over is lost, and what was overdrawn is paid for.
        let overdrawn = self.allowance.left().min(0);
        self.allowance.give(overdrawn - self.allowance.left());
        let half = self.budget / if self.chaser.is_some() { 2 } else { 1 };
        self.allowance.give(half);
        let mut states = None;
        if let Some(live) = self.live.take() {
            let (live, here) = self.go(live)?;
            states = here;
            self.live = live;
        }
        self.allowance.give(self.budget - half);
        if let Some(chaser) = self.chaser.take() {
            let (chaser, here) = self.go(chaser)?;
            states = both(states, here);
            self.chaser = chaser;
            self.take_over();
        }
        self.is_due |= boxes.position.is_multiple_of(ASKS);
        if self.chaser.is_none() && (self.live.is_none() || self.is_due) {
            self.begin();
        }
        let spent = overdrawn.saturating_add(self.budget) - self.allowance.left();
        self.spent = u64::try_from(spent).unwrap_or(0);
        Ok(Left {
            params: self.known.clone(),
            states,
        })
    }

    /// Remembers a sample.
    fn note(&mut self, sample: &Sample, boxes: &Boxes<'_>) -> Result<(), Refuted> {
        if boxes.resets.iter().any(|reset| *reset) {
            self.past.clear();
            (self.live, self.chaser) = (None, None);
            self.begun.fill(Interval::ENTIRE);
            for (param, _) in boxes.resets.iter().enumerate().filter(|reset| *reset.1) {
                self.known[param] = self.problem.prior[param];
            }
        }
        let outputs = sample.outputs.iter().enumerate();
        let outputs = outputs.filter_map(|(output, measured)| Some((output, (*measured)?)));
        let zeros = self.signals.iter().enumerate();
        let zeros = zeros.filter(|(_, signal)| (boxes.proves)(**signal));
        let zeros = zeros.map(|(at, _)| (self.problem.outputs + at, Interval::ZERO));
        let moment = Moment {
            time: sample.time.clone(),
            line: sample.line,
            told: outputs.chain(zeros).collect(),
            inputs: sample.inputs.clone(),
            dt: boxes.dt,
            states: boxes.states.clone(),
        };
        self.past.push(boxes.position, moment, self.history);
        let oldest = self.past.first();
        for runner in [&mut self.live, &mut self.chaser] {
            if runner.as_ref().is_some_and(|runner| runner.at < oldest) {
                *runner = None;
            }
        }
        self.learn(&boxes.params)
    }

    /// Parameters are in these intervals, too.
    fn learn(&mut self, params: &[Interval]) -> Result<(), Refuted> {
        for (param, x) in params.iter().enumerate() {
            let left = self.known[param].intersect(*x);
            if left.is_empty() {
                let (newest, sample) = (self.past.newest(), self.past.moment(self.past.newest()));
                return Err(Refuted {
                    sample: newest,
                    line: sample.line,
                    time: sample.time.clone(),
                    contradiction: Contradiction::Apart {
                        quantity: self.problem.layout.states + param,
                        enclosure: self.known[param],
                        allowed: *x,
                    },
                });
            }
            self.known[param] = left;
        }
        Ok(())
    }

    /// One set through some samples, as far as the allowance reaches; what goes on, and states at the newest sample.
    fn go(&mut self, set: Going) -> Result<(Option<Going>, Option<Vec<Interval>>), Refuted> {
        let limits = ((self.replay, self.rows), self.replay + PATIENCE);
        let told = (&self.past, &self.known[..]);
        let (gone, newest) = match set.go_on(&self.problem, told, limits, &self.allowance) {
            Next::Rests(set) => return Ok((Some(set), None)),
            Next::Arrived(gone, newest) => (gone, newest),
        };
        let runner = *gone.runner;
        let (fate, states) = gone
            .found
            .map_err(|clash| self.refuted(clash.unwrap_or_else(|| runner.explain(&self.past))))?;
        let states = states.filter(|_| newest == self.past.newest());
        self.learn(runner.params())?;
        if fate == Fate::Alive {
            return Ok((Some(Going::new(runner)), states));
        }
        // A narrower set goes farther; else another one goes on.
        let oldest = self.past.first();
        let again = Some(runner.smaller())
            .filter(|(_, turned)| *turned || runner.left() < WORTHWHILE)
            .filter(|_| runner.base >= oldest && runner.has_gone_farther());
        let next = match again {
            Some((region, _)) => Some(runner.again(&self.problem, &region)),
            None => {
                let next = runner.anchored().filter(|(at, _)| *at >= oldest);
                next.and_then(|(sample, states)| self.window(sample, Some(&states)))
            }
        };
        if next.is_none() {
            self.pause = self.past.newest() + PAUSE;
        }
        Ok((next.map(Going::new), states))
    }

    /// The set that has caught up takes over where it leaves less.
    fn take_over(&mut self) {
        let newest = self.past.newest();
        let chaser = self.chaser.as_ref().and_then(Going::standing);
        let Some(chaser) = chaser.filter(|chaser| chaser.at == newest) else {
            return;
        };
        let is_better = match self.live.as_ref().map(Going::standing) {
            None => true,
            // It is compared with where the other one arrives.
            Some(None) => return,
            Some(Some(live)) => is_better(chaser, live),
        };
        let chaser = self.chaser.take();
        if is_better {
            self.live = chaser;
        }
    }

    /// A set that begins at a sample, with all that is known.
    fn window(&self, sample: u64, states: Option<&[Interval]>) -> Option<Runner> {
        let known = self.past.moment(sample).states.iter();
        let mut all: Vec<Interval> = match states {
            Some(states) => known.zip(states).map(|(x, y)| x.intersect(*y)).collect(),
            None => known.copied().collect(),
        };
        all.extend(&self.known);
        all.iter()
            .all(|x| x.is_bounded() && !x.is_empty())
            .then(|| Runner::new(&self.problem, &Region::of_box(&all), sample))
    }

    /// Begins at the oldest sample anew where much less is left than the last time.
    fn begin(&mut self) {
        let oldest = self.past.first();
        let shares = self.known.iter().zip(&self.begun);
        let is_narrower = shares
            .into_iter()
            .any(|(now, before)| now.width() < WORTHWHILE * before.width());
        let own = match self.live.as_ref().map(Going::standing) {
            // It is asked where it arrives.
            Some(None) => return,
            own => own.flatten().filter(|live| live.base == oldest),
        };
        self.is_due = false;
        let turned = own.map(|live| (live.smaller(), live.left()));
        let turned = turned.filter(|((_, turned), left)| *turned || *left < WORTHWHILE);
        let runner = match turned {
            Some(((region, _), _)) => Some(Runner::new(&self.problem, &region, oldest)),
            None if is_narrower => self.window(oldest, None),
            None => None,
        };
        if runner.is_some() {
            self.begun.clone_from(&self.known);
            self.chaser = runner.map(Going::new);
        } else if self.live.is_none() && self.past.newest() >= self.pause {
            let live = self.window(self.past.newest(), None);
            self.live = live.map(Going::new);
        }
    }

    fn refuted(&self, clash: Clash) -> Refuted {
        let moment = self.past.moment(clash.sample.max(self.past.first()));
        let contradiction = match clash.quantity.checked_sub(self.problem.outputs) {
            None => Contradiction::Output {
                output: clash.quantity,
                enclosure: clash.enclosure,
                measured: clash.told,
                gap: distance(clash.enclosure, clash.told),
            },
            Some(zero) => Contradiction::Signal {
                signal: self.signals[zero],
                enclosure: clash.enclosure,
            },
        };
        Refuted {
            sample: clash.sample,
            line: moment.line,
            time: moment.time.clone(),
            contradiction,
        }
    }
}

/// Whether a set that has caught up leaves less than another one.
fn is_better(own: &Runner, other: &Runner) -> bool {
    let pairs = own.params().iter().zip(other.params());
    let shares = pairs.filter(|(_, other)| other.width() > 0.0);
    shares
        .map(|(own, other)| own.width() / other.width())
        .product::<f64>()
        < 1.0
}

/// What two enclosures of the same states leave.
fn both(a: Option<Vec<Interval>>, b: Option<Vec<Interval>>) -> Option<Vec<Interval>> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.iter().zip(&b).map(|(x, y)| x.intersect(*y)).collect()),
        (a, b) => a.or(b),
    }
}
