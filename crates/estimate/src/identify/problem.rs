//! A model and a record, compiled for identification.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one stretch between two samples, lists as long as those of the model"
)]

use std::ops::Range;
use std::sync::Arc;

use super::answer::{Conclusion, Refuted};
use super::balances::Balances;
use super::cell::Known;
use super::held::Held;
use super::pass::GoOn;
use super::region::Region;
use crate::signals::Signals;
use veribound_flow::form::{Flow, Output, Stretch};
use veribound_interval::{Decimal, Interval};
use veribound_model::{Layout, Model, Outliers, Ratio, Sample, Var};

/// What a sample tells.
#[derive(Debug, Clone)]
pub(crate) struct Instant {
    /// Time stamp.
    pub(crate) time: Decimal,
    /// Line in the file.
    pub(crate) line: usize,
    /// Quantities, by position in [`Problem::quantities`], with every value each can have.
    pub(crate) told: Vec<(usize, Interval)>,
    /// Inputs from now on.
    pub(crate) inputs: Vec<Interval>,
    /// Some of these, for points.
    pub(crate) nominal: Vec<Interval>,
    /// Parameters that may be new from now on.
    pub(crate) resets: Vec<usize>,
    /// Inputs that are parameters, as these are numbered, and have another value from now on.
    pub(crate) changes: Vec<usize>,
    /// What these inputs have from now on, where it is no quantity.
    pub(crate) held: Vec<Interval>,
}

/// The value that a parameter has after a reset, or that an input has for a while.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Later {
    /// Inputs that are parameters are numbered behind these.
    pub(crate) param: usize,
    /// Its values before any sample.
    pub(crate) believed: Interval,
    /// The sample from which on it holds,
    pub(crate) from: usize,
    /// and the one before which it ends: that of the next reset, or the number of samples.
    pub(crate) until: usize,
}

/// Which value of a parameter that can be reset acts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Value {
    /// That before any reset.
    First,
    /// This one of [`Course::later`].
    Later(usize),
    /// One that lasts for one stretch only, since it may be reset again at the next sample.
    Passing,
    /// That of an input, which is no quantity.
    Recorded(Interval),
}

/// The equations as a pass moves forms by them.
#[derive(Debug)]
pub(crate) struct Moved {
    pub(crate) flow: Flow,
    /// Outputs first, then what signals prove to be zero.
    pub(crate) quantities: Vec<Output>,
    /// Number of parameters, with the inputs that are parameters.
    pub(crate) params: usize,
}

impl Moved {
    fn new(model: &Model, inputs: &[usize]) -> Moved {
        let model = model.with_inputs_as_params(inputs);
        let outputs = model.outputs.iter().map(|output| output.expr);
        let zeros = model.signals.iter().flat_map(|signal| &signal.proves_zero);
        Moved {
            quantities: outputs
                .chain(zeros.copied())
                .map(|expr| Output::new(&model, expr))
                .collect(),
            params: model.params.len(),
            flow: Flow::new(&model),
        }
    }
}

/// One record, with the start states that are its own.
#[derive(Debug, Clone)]
pub(crate) struct Course {
    pub(crate) instants: Vec<Instant>,
    pub(crate) stretches: Vec<Stretch>,
    /// Those for points.
    pub(crate) nominal: Vec<Stretch>,
    /// Start values that are believed before the record.
    pub(crate) start: Vec<Interval>,
    /// Values of parameters after resets that last longer than a stretch, and of inputs that are constant for a while,
    /// in order of time; behind them those of inputs that need not be constant.
    pub(crate) later: Vec<Later>,
    /// Number of the former.
    pub(crate) firm: usize,
    /// Number of parameters, without inputs.
    pub(crate) params: usize,
    /// For every output, how many samples before one tell it.
    pub(crate) numbers: Vec<Vec<usize>>,
    /// For every parameter the first sample at which it may be reset, or the number of samples.
    first_resets: Vec<usize>,
}

impl Course {
    /// The last sample.
    pub(crate) fn end(&self) -> usize {
        self.instants.len().saturating_sub(1)
    }

    /// The next sample from `from` on, and before `until`, at which one of the first `params` parameters may have a new
    /// value.
    pub(crate) fn next_reset(&self, from: usize, until: usize, params: usize) -> Option<usize> {
        (from..until).find(|sample| {
            let instant = &self.instants[*sample];
            let mut changes = instant.changes.iter();
            !instant.resets.is_empty() || changes.any(|param| *param < params)
        })
    }

    /// The first sample at which a parameter may be reset, or the number of samples.
    pub(crate) fn first_reset(&self, param: usize) -> usize {
        let first = self.first_resets.get(param);
        first.copied().unwrap_or(self.instants.len())
    }

    /// The value of a parameter from this sample to the next.
    pub(crate) fn value(&self, param: usize, sample: usize) -> Value {
        let later = self.later.iter();
        let own = later.enumerate().filter(|(_, later)| later.param == param);
        let mut own = own.filter(|(_, later)| later.from <= sample && sample < later.until);
        if let Some((position, _)) = own.next() {
            return Value::Later(position);
        }
        if let Some(input) = param.checked_sub(self.params) {
            Value::Recorded(self.instants[sample].held[input])
        } else if self.first_reset(param) <= sample {
            Value::Passing
        } else {
            Value::First
        }
    }

    /// The values after resets that last longer than a stretch.
    fn lasting(instants: &[Instant], priors: &[Interval]) -> Vec<Later> {
        let mut later = Vec::new();
        for (param, believed) in priors.iter().enumerate() {
            let list = instants.iter().enumerate();
            let list = list.filter(|(_, instant)| instant.resets.contains(&param));
            let resets: Vec<usize> = list.map(|(sample, _)| sample).collect();
            for (k, from) in resets.iter().enumerate() {
                let until = resets.get(k + 1).copied().unwrap_or(instants.len());
                if until > from + 1 {
                    later.push(Later {
                        param,
                        believed: *believed,
                        from: *from,
                        until,
                    });
                }
            }
        }
        later
    }

    /// The same with what these samples tell alone.
    fn with(&self, is_kept: &dyn Fn(usize) -> bool) -> Course {
        let mut course = self.clone();
        for (sample, instant) in course.instants.iter_mut().enumerate() {
            if !is_kept(sample) {
                instant.told.clear();
            }
        }
        course
    }

    /// The inputs that may act at a sample: those until then, and those from then on.
    pub(crate) fn inputs_at(&self, sample: usize) -> Vec<Interval> {
        let now = &self.instants[sample].inputs;
        match sample.checked_sub(1) {
            None => now.clone(),
            Some(before) => {
                let before = self.instants[before].inputs.iter();
                before.zip(now).map(|(a, b)| a.hull(*b)).collect()
            }
        }
    }
}

/// Samples that refute a model together are named if there are no more.
const MOST_NAMED: usize = 24;

/// So often it is tried to do with fewer.
const MOST_PROOFS: usize = 60;

/// Of `samples`, which refute together with `others`, those that are needed, about (Junker, QuickXplain, 2004).
fn needed(
    refutes: &mut dyn FnMut(&[usize]) -> bool,
    others: &[usize],
    is_new: bool,
    samples: &[usize],
) -> Vec<usize> {
    if is_new && refutes(others) {
        return Vec::new();
    }
    if samples.len() < 2 {
        return samples.to_vec();
    }
    let (early, late) = samples.split_at(samples.len() / 2);
    let with_early = [others, early].concat();
    let late = needed(refutes, &with_early, true, late);
    let with_late = [others, &late].concat();
    let early = needed(refutes, &with_late, !late.is_empty(), early);
    [early, late].concat()
}

/// How many samples before each tell an output.
fn numbers(samples: &[Sample], output: usize) -> Vec<usize> {
    let mut count = 0;
    let number = |sample: &Sample| {
        let before = count;
        count += usize::from(sample.outputs[output].is_some());
        before
    };
    samples.iter().map(number).collect()
}

/// A model with all its records.
#[derive(Debug)]
pub(crate) struct Problem {
    /// Equations of what is proved of all solutions. Inputs that are constant for a while are parameters.
    pub(crate) outer: Arc<Moved>,
    /// Equations of points that are proved to agree: for these it is enough that inputs may be constant for a while.
    pub(crate) points: Arc<Moved>,
    /// Inputs that are parameters.
    held: Held,
    pub(crate) layout: Layout,
    /// Number of outputs among the quantities.
    pub(crate) outputs: usize,
    /// For each of them how many samples may be outliers, if some may.
    pub(crate) outliers: Vec<Option<Outliers>>,
    /// For every parameter whether a quantity depends on it directly.
    pub(crate) is_told_of: Vec<bool>,
    pub(crate) courses: Vec<Course>,
    /// Bounds of the parameters that are believed before the records.
    pub(crate) prior: Vec<Interval>,
    /// Measurement errors may be so many times as large as the model says: one quantity more.
    pub(crate) factor: Option<Interval>,
    /// What parameters of the user's model are in those of this one, where they are not the same.
    pub(crate) ratios: Vec<Option<Ratio>>,
    /// The user's bounds of these.
    pub(crate) user: Vec<Interval>,
    /// What equations say when they are integrated along the records, where that was asked.
    pub(crate) balances: Option<Balances>,
}

/// Quantities of a region are in this order: the start states of every record, the values after resets of every
/// record, the factor of errors if there is one, the parameters.
impl Problem {
    /// The equations for all solutions, or for points that are proved to agree.
    pub(crate) fn moved(&self, for_points: bool) -> &Moved {
        if for_points {
            &self.points
        } else {
            &self.outer
        }
    }

    /// Whether some input may have any course within what is known of it, which no state can make jump.
    pub(crate) fn is_driven_freely(&self) -> bool {
        self.held.is_free()
            && !self.outer.flow.has_jumps()
            && self.outliers.iter().all(Option::is_none)
    }

    /// Positions of the start states of a record.
    pub(crate) fn starts(&self, record: usize) -> Range<usize> {
        let n = self.layout.states;
        record * n..(record + 1) * n
    }

    /// Positions of the values after resets of a record.
    pub(crate) fn later(&self, record: usize) -> Range<usize> {
        let before = self.courses[..record].iter();
        let begin = before.fold(self.starts(self.courses.len()).start, |sum, course| {
            sum + course.later.len()
        });
        begin..begin + self.courses[record].later.len()
    }

    /// Position of the factor of errors.
    pub(crate) fn factor_position(&self) -> Option<usize> {
        self.factor.map(|_| self.first_param() - 1)
    }

    /// Position of the first parameter.
    pub(crate) fn first_param(&self) -> usize {
        let later = self.courses.iter().map(|course| course.later.len());
        self.starts(self.courses.len()).start
            + later.sum::<usize>()
            + usize::from(self.factor.is_some())
    }

    /// Positions of the parameters.
    pub(crate) fn params(&self) -> Range<usize> {
        let first = self.first_param();
        first..first + self.layout.params
    }

    /// What of [`Problem::told_quantities`] are the values of parameters, after resets too, that last longer than a stretch of some
    /// record.
    pub(crate) fn lasting(&self) -> Vec<usize> {
        let records = 0..self.courses.len();
        let after = records.flat_map(|record| self.after_resets(record).map(|(_, at)| at));
        let first = self.told_params().into_iter().enumerate();
        let first = first.filter(|(param, _)| {
            let mut courses = self.courses.iter();
            courses.any(|course| course.first_reset(*param) > 1 || course.end() < 1)
        });
        after.chain(first.map(|(_, quantity)| quantity)).collect()
    }

    /// The values of parameters after resets in a record, each with its position.
    pub(crate) fn after_resets(&self, record: usize) -> impl Iterator<Item = (Later, usize)> + '_ {
        let later = self.courses[record].later.iter().copied();
        let list = later.zip(self.later(record));
        list.filter(|(later, _)| later.param < self.layout.params)
    }

    /// What is believed of every quantity before any sample.
    pub(crate) fn believed(&self) -> Vec<Interval> {
        let starts = self.courses.iter().flat_map(|course| course.start.iter());
        let later = self.courses.iter().flat_map(|course| &course.later);
        let later = later.map(|later| &later.believed);
        let all = starts.chain(later).chain(&self.factor).chain(&self.prior);
        all.copied().collect()
    }
}

impl Problem {
    /// A model with records, the samples of each in order of time. Its parameters are those in which it bends least.
    pub(crate) fn of(model: &Model, records: &[Vec<Sample>]) -> Problem {
        let (new, ratios) = model.with_ratios();
        Problem {
            ratios,
            user: model.params.iter().map(|param| param.bounds).collect(),
            ..Problem::upright(&new, records)
        }
    }

    /// The same with the parameters of the model.
    pub(crate) fn upright(model: &Model, records: &[Vec<Sample>]) -> Problem {
        let mut problem = Problem::new(model, Held::of(model, records));
        for samples in records {
            problem.add(model, samples);
        }
        problem
    }

    /// A model without records.
    pub(crate) fn new(model: &Model, held: Held) -> Problem {
        let outer = Arc::new(Moved::new(model, &held.inputs[..held.firm]));
        let outputs = model.outputs.iter().map(|output| output.expr);
        let zeros = model.signals.iter().flat_map(|signal| &signal.proves_zero);
        let told: Vec<Var> = outputs
            .chain(zeros.copied())
            .flat_map(|expr| model.graph.variables(expr))
            .collect();
        let params = 0..model.params.len();
        Problem {
            is_told_of: params
                .map(|param| told.contains(&Var::Param(param)))
                .collect(),
            points: if held.inputs.len() > held.firm {
                Arc::new(Moved::new(model, &held.inputs))
            } else {
                outer.clone()
            },
            outer,
            held,
            layout: model.layout(),
            outputs: model.outputs.len(),
            outliers: model
                .outputs
                .iter()
                .map(|output| output.outliers.filter(|outliers| outliers.most > 0))
                .collect(),
            courses: Vec::new(),
            prior: model.params.iter().map(|param| param.bounds).collect(),
            factor: None,
            ratios: vec![None; model.params.len()],
            user: model.params.iter().map(|param| param.bounds).collect(),
            balances: None,
        }
    }

    /// That nothing agrees with the records, by these samples of one of them if they are enough.
    pub(crate) fn refuted(&self, record: usize, samples: Vec<usize>) -> Conclusion {
        let last = samples.last().copied();
        let instants = self
            .courses
            .get(record)
            .map_or(&[][..], |course| &course.instants);
        let instant = last.and_then(|last| instants.get(last)).or(instants.last());
        Conclusion::Inconsistent(Refuted {
            record,
            samples,
            time: instant.map_or_else(Decimal::zero, |instant| instant.time.clone()),
            line: instant.map_or(0, |instant| instant.line),
        })
    }

    /// Looks for few samples of one record that refute the model together, those of `found` first.
    ///
    /// Guarantee: the samples named refute the model without any other, since that was proved once more with them
    /// alone. None is named where `go_on` denies it on the way.
    pub(crate) fn confirm(mut self, found: Refuted, go_on: &GoOn<'_>) -> Conclusion {
        let whole = std::mem::take(&mut self.courses);
        // All samples are in these.
        self.balances = None;
        let count = whole
            .get(found.record)
            .map_or(0, |course| course.instants.len());
        let mut refutes = |kept: &[usize]| {
            let courses = whole.iter().enumerate();
            let only = courses.map(|(position, course)| {
                let is_kept = |sample| position == found.record && kept.contains(&sample);
                course.with(&is_kept)
            });
            self.courses = only.collect();
            let prior = Region::of_box(&self.believed());
            go_on() && self.refine(prior, Known::default(), true, go_on).is_err()
        };
        let mut left = MOST_PROOFS;
        let mut tries = |kept: &[usize]| {
            left = left.saturating_sub(1);
            left > 0 && refutes(kept)
        };
        let all: Vec<usize> = (0..count).collect();
        let begin = [found.samples, all]
            .into_iter()
            .find(|samples| tries(samples));
        let mut kept = begin.map_or(Vec::new(), |samples| {
            needed(&mut tries, &[], false, &samples)
        });
        kept.sort_unstable();
        // What is left when all tries are spent may be too much, and too many are no help.
        if kept.len() > MOST_NAMED || !refutes(&kept) {
            kept.clear();
        }
        self.courses = whole;
        self.refuted(found.record, kept)
    }

    /// Adds a record, whose samples are in order of time and have the lists of the model.
    fn add(&mut self, model: &Model, samples: &[Sample]) {
        let mut signals = Signals::new(model);
        let mut instants = Vec::with_capacity(samples.len());
        for (k, sample) in samples.iter().enumerate() {
            signals.note(sample);
            let outputs = sample.outputs.iter().enumerate();
            let mut told: Vec<(usize, Interval)> = outputs
                .filter_map(|(output, measured)| Some((output, (*measured)?)))
                .collect();
            let mut quantity = self.outputs;
            for (signal, one) in model.signals.iter().enumerate() {
                for _ in &one.proves_zero {
                    if signals.proves(signal, &sample.time) {
                        told.push((quantity, Interval::ZERO));
                    }
                    quantity += 1;
                }
            }
            let resets = signals.resets(&sample.time).into_iter().enumerate();
            let resets = resets.filter_map(|(param, reset)| (reset && k > 0).then_some(param));
            instants.push(Instant {
                time: sample.time.clone(),
                line: sample.line,
                told,
                inputs: sample.inputs.clone(),
                nominal: self.held.for_points(&sample.inputs),
                resets: resets.collect(),
                changes: Vec::new(),
                held: Vec::new(),
            });
        }
        let stretches = |inputs: &dyn Fn(&Instant) -> Vec<Interval>| {
            let pairs = instants.windows(2);
            let stretches = pairs.map(|pair| Stretch {
                inputs: inputs(&pair[0]),
                dt: (&pair[1].time - &pair[0].time).to_interval(),
            });
            stretches.collect()
        };
        let first_reset = |param: usize| {
            let is_reset = |instant: &Instant| instant.resets.contains(&param);
            let first = instants.iter().position(is_reset);
            first.unwrap_or(instants.len())
        };
        let mut course = Course {
            first_resets: (0..model.params.len()).map(first_reset).collect(),
            later: Course::lasting(&instants, &self.prior),
            firm: 0,
            params: model.params.len(),
            numbers: (0..self.outputs)
                .map(|output| numbers(samples, output))
                .collect(),
            stretches: stretches(&|instant| instant.inputs.clone()),
            nominal: stretches(&|instant| instant.nominal.clone()),
            instants,
            start: model.states.iter().map(|state| state.init).collect(),
        };
        self.held.add(model, samples, &mut course);
        self.courses.push(course);
    }
}
