//! One form through a stretch of a record, and what the samples on its way say.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: unknowns in the order of the form's, samples and quantities of the problem"
)]

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use super::cell::BELIEVED;
use super::outliers::Doubtful;
use super::problem::{Course, Moved, Problem, Value};
use super::region::scales_of;
use super::rows::{Affine, Rows, Scaled};
use super::simplex::{Program, Side, Vertex, minimum, refutes};
use serde::{Deserialize, Serialize};
use veribound_flow::form::{Arriving, Form, FormOptions, Meeting, Parallelotope, Strip};
use veribound_interval::Interval;

/// A pass ends where so many steps do not lead to the next sample: the set grows too fast to tell anything.
const MOST_STEPS: usize = 100;

/// A moment in which boxes go on, since the right-hand side is not defined on all of the form, takes as long as many steps: it
/// is worth it once in so many samples.
const UNDEFINED: usize = 16;

/// Rows are asked for narrower unknowns when so many times the samples of the last time were met.
const NEXT: f64 = 1.25;

/// Unknowns that keep more than this share of their width are not written anew on the way.
pub(crate) const WORTHWHILE: f64 = 0.8;

/// A sample tells little where what is no affine function of the unknowns is so many times wider than what was
/// measured,
pub(crate) const BLURRED: f64 = 2.0;

/// and a pass ends after so many of these in a row.
pub(crate) const HIDDEN: usize = 12;

/// Ends of the values that a parameter can have for one stretch are cut off in so many halvings.
const HALVINGS: usize = 30;

/// and in no more where none of the first so many did.
const ROUGHLY: usize = 8;

/// Samples between two questions whether to go on.
const ASKS: usize = 64;

/// Products of unknowns are unknowns, too, where there are no more than these.
const MOST_CURVED: usize = 8;

/// States are kept at so many samples of a pass at most.
const ANCHORS: usize = 12;

/// Is asked now and then whether work is to go on; who is told that it is not ends with what is proved until then.
pub(crate) type GoOn<'a> = dyn Fn() -> bool + Sync + 'a;

/// What is asked of a pass.
#[derive(Clone, Copy)]
pub(crate) struct Span<'a> {
    /// First and last sample.
    pub(crate) from: usize,
    pub(crate) until: usize,
    pub(crate) aim: Aim,
    pub(crate) go_on: &'a GoOn<'a>,
}

/// What a pass is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Aim {
    /// Proved bounds.
    Bounds,
    /// Points that are proved to agree: where any value of a parameter does, one is taken.
    Points,
    /// How what is measured depends on the unknowns, whether or not they agree with it; one value is taken as for
    /// points, and nothing but the rows is told.
    Slopes,
}

/// Quantities at the first sample of a pass, as functions of its unknowns in the unit box.
#[derive(Debug, Clone)]
pub(crate) struct Set {
    /// States, then parameters before any reset.
    pub(crate) moved: Parallelotope,
    /// Parameters after resets.
    pub(crate) later: Vec<Affine>,
    /// The factor of errors.
    pub(crate) factor: Option<Affine>,
}

impl Aim {
    /// Whether inputs have single values, too.
    pub(crate) fn is_for_points(self) -> bool {
        self != Aim::Bounds
    }
}

/// Why a set contains no solution that agrees with the record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) enum Conflict {
    /// A quantity cannot have the value that a sample tells.
    Value { sample: usize },
    /// These samples together, each with its record.
    Rows { samples: Vec<(usize, usize)> },
}

/// A sample, and the states there as functions of the unknowns of a pass.
#[derive(Debug, Clone)]
pub(crate) struct Anchor {
    pub(crate) sample: usize,
    pub(crate) states: Vec<Affine>,
}

/// What a pass came to.
pub(crate) struct Passed {
    /// What the axes are, as far as they are narrowed, each `middle + radius δ`.
    pub(crate) scales: Vec<(Interval, Interval)>,
    /// What samples say of them.
    pub(crate) rows: Rows,
    /// The last sample that was met.
    pub(crate) reached: usize,
    /// Whether every sample on the way is proved to be met by all unknowns that satisfy the inner rows.
    pub(crate) is_complete: bool,
    pub(crate) conflict: Option<Conflict>,
    /// About how far from linear what was told depends on each axis.
    pub(crate) curvature: Vec<f64>,
    /// Some of the samples that told something, in order, with the states there.
    pub(crate) anchors: Vec<Anchor>,
}

/// Meets samples.
struct Meeter<'a> {
    problem: &'a Problem,
    moved: &'a Moved,
    course: &'a Course,
    span: Span<'a>,
    /// Sample at the begin of the journey at hand, and at its end.
    begin: usize,
    end: usize,
    /// The form at its end.
    arrived: Option<Form>,
    later: Vec<Affine>,
    factor: Option<Affine>,
    /// Maybe with products of the unknowns.
    rows: Rows,
    /// For every output that may have outliers what its samples tell.
    doubtful: Vec<Option<Doubtful>>,
    reached: usize,
    is_complete: bool,
    conflict: Option<Conflict>,
    hidden: usize,
    next: usize,
    curvature: Vec<f64>,
    scales: Vec<(Interval, Interval)>,
    anchors: Vec<Anchor>,
    /// Samples from one anchor to the next at least.
    apart: usize,
    wanted: BTreeSet<usize>,
    over: &'a AtomicBool,
}

/// Moves a set of states at the sample `span.from`, with parameters, to the sample `span.until`. The unknowns are
/// narrowed on the way.
///
/// Guarantee: every solution in the set that agrees with all samples on the way has unknowns that the result
/// tells, and satisfies its rows; a conflict proves that there is none. If only points are wanted, nothing but
/// the inner rows is proved. States are kept at samples that are `wanted`, and at a few more.
pub(crate) fn pass(
    problem: &Problem,
    course: &Course,
    span: Span<'_>,
    set: Set,
    wanted: BTreeSet<usize>,
) -> Passed {
    // Rows of points are affine, those of bounds quadratic, and what is not is best known by polynomials of degree two; of slopes
    // alone no more than these is wanted.
    let degree = if span.aim == Aim::Slopes { 1 } else { 2 };
    let options = FormOptions {
        degree: Some(degree),
        ..FormOptions::default()
    };
    let moved = problem.moved(span.aim.is_for_points());
    let mut form = moved.flow.start_in(&set.moved, options);
    let over = AtomicBool::new(false);
    // Rows of outliers, and of factors, are made of slopes alone.
    let is_straight = set.factor.is_some() || problem.outliers.iter().any(Option::is_some);
    let unknowns = form.scales().len();
    let products = if span.aim == Aim::Bounds && !is_straight && unknowns <= MOST_CURVED {
        form.products()
    } else {
        Vec::new()
    };
    let mut meeter = Meeter {
        problem,
        moved,
        course,
        span,
        begin: span.from,
        end: span.from,
        arrived: None,
        later: set.later,
        factor: set.factor,
        rows: Rows::with_products(unknowns, products),
        doubtful: problem
            .outliers
            .iter()
            .map(|allowed| allowed.map(Doubtful::new))
            .collect(),
        reached: span.from,
        is_complete: true,
        conflict: None,
        hidden: 0,
        next: span.from + 2,
        curvature: form.curvature(),
        scales: scales(&form),
        anchors: Vec::new(),
        apart: 1,
        wanted,
        over: &over,
    };
    // From one reset to the next.
    loop {
        meeter.renew(&mut form);
        let begin = meeter.begin;
        let reset = course.next_reset(begin + 1, span.until + 1, moved.params);
        meeter.end = reset.unwrap_or(span.until).max(begin);
        let stretches = if span.aim.is_for_points() {
            &course.nominal
        } else {
            &course.stretches
        };
        let stretches = &stretches[begin..meeter.end];
        let (steps, met) = (AtomicUsize::new(0), AtomicUsize::new(begin - span.from));
        let meet = &mut |meeting: Meeting<'_>| {
            steps.store(0, Ordering::Relaxed);
            met.fetch_add(1, Ordering::Relaxed);
            meeter.meet(meeting, reset.is_some());
        };
        let go_on = |form: &Form| {
            let steps = steps.fetch_add(1, Ordering::Relaxed) + 1;
            let met = met.load(Ordering::Relaxed);
            let is_defined = UNDEFINED * form.undefined_moments() <= met;
            !over.load(Ordering::Relaxed) && steps <= MOST_STEPS && is_defined
        };
        let done = moved.flow.follow(form, stretches, meet, &go_on);
        meeter.is_complete &= done.is_ok();
        match meeter.arrived.take() {
            Some(arrived) if reset.is_some() && done.is_ok() && !over.load(Ordering::Relaxed) => {
                form = arrived
            }
            _ => break,
        }
        meeter.begin = meeter.end;
    }
    for doubtful in std::mem::take(&mut meeter.doubtful).into_iter().flatten() {
        doubtful.finish(&mut meeter.rows);
    }
    Passed {
        is_complete: meeter.is_complete && meeter.reached == span.until,
        scales: meeter.scales,
        rows: meeter.rows,
        reached: meeter.reached,
        conflict: meeter.conflict,
        curvature: meeter.curvature,
        anchors: meeter.anchors,
    }
}

/// A state that is told to be at a point is there, where the form does not say it as well.
pub(crate) fn hold(form: &mut Form, state: usize, told: Interval) {
    let mut states = vec![Interval::ENTIRE; form.strips().len()];
    states[state] = told;
    form.restrict(&states);
}

/// A sample tells that a state is on the level that it is on its way to: without capture it would be there or
/// beyond. What is added to the slopes of the state without capture, and where the sum is.
pub(crate) fn beyond(arriving: &Arriving) -> (Interval, Interval) {
    let level = arriving.level;
    let beyond = if arriving.from_above {
        Interval::new(f64::NEG_INFINITY, level.hi())
    } else {
        Interval::new(level.lo(), f64::INFINITY)
    };
    let rest = arriving.ahead.remainder + Interval::point(arriving.ahead.centre);
    (rest, beyond.unwrap_or(Interval::ENTIRE))
}

fn scales(form: &Form) -> Vec<(Interval, Interval)> {
    let list = form.scales().into_iter();
    list.map(|(_, middle, radius)| (middle, radius)).collect()
}

impl Meeter<'_> {
    /// Gives parameters the values that they may have from the sample `begin` on.
    ///
    /// First all of them: what is known of one must not rest on what another was before.
    fn renew(&mut self, form: &mut Form) {
        let is_first = self.begin == self.span.from;
        let instant = &self.course.instants[self.begin];
        let (mut passing, mut first) = (Vec::new(), Vec::new());
        for param in 0..self.moved.params {
            let is_new = instant.resets.contains(&param) || instant.changes.contains(&param);
            if !is_first && !is_new {
                continue;
            }
            match self.course.value(param, self.begin) {
                Value::First if self.course.first_reset(param) == self.begin + 1 => {
                    first.push(param)
                }
                Value::First => {}
                Value::Recorded(value) => form.set_param(param, &[], value),
                Value::Later(position) => {
                    let later = &self.later[position];
                    form.set_param(param, &later.slopes, later.rest);
                }
                Value::Passing => {
                    form.set_param(param, &[], self.problem.prior[param]);
                    passing.push(param);
                }
            }
        }
        for param in first {
            // Sets may reach out of what is believed by rounding.
            let own = form.param_box()[param].intersect(self.problem.prior[param]);
            if !own.is_empty() && self.rests_with_any(form, param, own) {
                form.set_param(param, &[], Interval::point(own.mid()));
            }
        }
        for param in passing {
            let value = self.passing(form, param);
            form.set_param(param, &[], value);
        }
    }

    /// Whether everything rests from the sample `begin` to the next with any of these values of a parameter, and any of the
    /// other parameters in the form, and no output depends on it: then it makes no difference which one it is.
    fn rests_with_any(&self, form: &Form, param: usize, values: Interval) -> bool {
        let after = || {
            let stretch = self.course.stretches.get(self.begin)?;
            let mut params = form.param_box();
            params[param] = values;
            let states = self.states(form);
            self.moved.flow.box_after(&states, &params, stretch)
        };
        !self.problem.is_told_of[param] && after().is_some_and(|after| after.rests)
    }

    /// The states of the form at the sample `begin`, cut with what that tells of them.
    fn states(&self, form: &Form) -> Vec<Interval> {
        let mut states = form.hull();
        for (state, told) in self.told_of_states(self.begin) {
            let both = states[state].intersect(told);
            // The sample is met later, and that is what a conflict is then.
            if !both.is_empty() {
                states[state] = both;
            }
        }
        states
    }

    /// What a sample tells for sure of single states.
    fn told_of_states(&self, sample: usize) -> Vec<(usize, Interval)> {
        // What a state is at a sample may be after a jump there, which other inputs and parameters decide.
        if self.moved.flow.has_jumps() {
            return Vec::new();
        }
        let told = self.course.instants[sample].told.iter();
        let is_sure = |quantity: usize| !self.doubtful.get(quantity).is_some_and(Option::is_some);
        let told = told.filter(|(quantity, _)| is_sure(*quantity));
        let told = told.filter_map(|(quantity, told)| {
            let state = self.moved.quantities[*quantity].state()?;
            let is_output = *quantity < self.problem.outputs;
            let factor = self.factor.as_ref().filter(|_| is_output);
            let scaled = factor.and_then(|factor| Scaled::of(*told, factor));
            Some((state, scaled.map_or(*told, |scaled| scaled.largest())))
        });
        told.collect()
    }

    /// The values of a parameter for one stretch with which what states are told to be at its end can be.
    ///
    /// One of them stands for all where it makes no difference.
    fn passing(&mut self, form: &Form, param: usize) -> Interval {
        let believed = self.problem.prior[param];
        let Some(stretch) = self.course.stretches.get(self.begin) else {
            return believed;
        };
        if self.rests_with_any(form, param, believed) {
            return Interval::point(believed.mid());
        }
        let told = self.told_of_states(self.begin + 1);
        let states = self.states(form);
        let mut params = form.param_box();
        let mut is_excluded = |lo: f64, hi: f64| {
            let after = Interval::new(lo, hi).and_then(|part| {
                params[param] = part;
                self.moved.flow.box_after(&states, &params, stretch)
            });
            after.is_some_and(|after| {
                let mut told = told.iter();
                told.any(|(state, told)| !after.states[*state].intersects(*told))
            })
        };
        let (mut lo, mut hi) = (believed.lo(), believed.hi());
        for is_lower in [true, false] {
            let mut step = hi - lo;
            for halving in 0..HALVINGS {
                step *= 0.5;
                let (from, to) = if is_lower {
                    (lo, lo + step)
                } else {
                    (hi - step, hi)
                };
                if from < to && from >= lo && to <= hi && is_excluded(from, to) {
                    if is_lower {
                        lo = to;
                    } else {
                        hi = from;
                    }
                } else if halving > ROUGHLY && hi - lo == believed.width() {
                    break;
                }
            }
        }
        let left = Interval::new(lo, hi).unwrap_or(believed);
        if self.span.aim.is_for_points() {
            Interval::point(left.mid())
        } else {
            self.is_complete = false;
            left
        }
    }

    fn meet(&mut self, meeting: Meeting<'_>, ends_in_reset: bool) {
        if self.over.load(Ordering::Relaxed) {
            return;
        }
        let sample = self.begin + meeting.stretch;
        if sample == self.end && ends_in_reset {
            // It is met with the new values.
            self.arrived = Some(meeting.form.clone());
            return;
        }
        let instant = &self.course.instants[sample];
        self.reached = sample;
        if sample.is_multiple_of(ASKS) && !(self.span.go_on)() {
            self.over.store(true, Ordering::Relaxed);
            self.is_complete = false;
        }
        let inputs = if self.span.aim.is_for_points() {
            &instant.nominal
        } else {
            &instant.inputs
        };
        let form = meeting.form;
        let both = self.course.inputs_at(sample);
        if self.moved.flow.may_jump(form, &both) {
            self.is_complete = false;
            return;
        }
        let factor = self.factor.clone();
        let (mut clear, mut blurred) = (false, false);
        for (quantity, told) in &instant.told {
            let on_forms = &self.moved.quantities[*quantity];
            let Ok(strip) = form.strip(on_forms, inputs) else {
                self.is_complete = false;
                continue;
            };
            let rest = strip.remainder + Interval::point(strip.centre);
            let reach: f64 = strip.slopes.iter().map(|g| g.abs()).sum();
            let reach = Interval::symmetric(reach * (1.0 + 1e-12));
            let scaled = match &factor {
                Some(factor) if *quantity < self.problem.outputs => Scaled::of(*told, factor),
                _ => None,
            };
            let largest = scaled.as_ref().map_or(*told, Scaled::largest);
            let is_doubtful = self.doubtful.get(*quantity).is_some_and(Option::is_some);
            let number = (*quantity < self.problem.outputs)
                .then(|| self.course.numbers[*quantity][sample])
                .filter(|_| is_doubtful);
            let is_possible = self.judge((sample, *quantity), number, rest + reach, largest);
            if let (Some(state), true, false) = (on_forms.state(), told.is_point(), is_doubtful) {
                hold(form, state, *told);
            }
            if *quantity < self.problem.outputs {
                let untold = if self.is_curved() {
                    strip.rest
                } else {
                    strip.remainder
                };
                let is_blurred = untold.width() > BLURRED * told.width();
                clear |= !is_blurred;
                blurred |= is_blurred;
            }
            let list = match &scaled {
                Some(scaled) => scaled.rows(&strip.slopes, rest).to_vec(),
                None => {
                    let Affine { slopes, rest } = self.affine(strip);
                    vec![(slopes, rest, *told)]
                }
            };
            if let (Some(number), Some(Some(doubtful))) = (number, self.doubtful.get_mut(*quantity))
            {
                let list = list.into_iter();
                let list = list.map(|(slopes, rest, told)| (Affine { slopes, rest }, told));
                if is_possible {
                    doubtful.push((number, sample), list.collect(), &mut self.rows);
                }
                continue;
            }
            let arriving = meeting.arriving.as_ref().filter(|arriving| {
                on_forms.state() == Some(arriving.state)
                    && arriving.level.is_point()
                    && arriving.level == *told
            });
            match arriving {
                None => {
                    for (slopes, rest, told) in list {
                        self.rows.push(&slopes, rest, told, sample, 0);
                    }
                }
                Some(arriving) => self.arriving(arriving, sample),
            }
        }
        if clear {
            self.hidden = 0;
            self.anchor(sample, form);
        } else if blurred {
            self.hidden += 1;
            self.curvature = form.curvature();
        }
        if self.span.aim == Aim::Slopes {
            return;
        }
        if sample >= self.next && self.conflict.is_none() && !meeting.is_passing {
            let met = (sample - self.span.from) as f64;
            self.next = self.span.from + (met * NEXT).ceil() as usize + 1;
            self.narrow(form);
        }
        if sample == self.span.until {
            self.curvature = form.curvature();
        }
        if self.conflict.is_some() || self.hidden > HIDDEN {
            self.over.store(true, Ordering::Relaxed);
        }
    }

    /// Keeps the states at a sample for windows to come, and in the long run of so many samples, about equally far from
    /// each other.
    fn anchor(&mut self, sample: usize, form: &Form) {
        let is_wanted = self.wanted.contains(&sample);
        let is_next = (sample - self.span.from).is_multiple_of(self.apart);
        if self.span.aim.is_for_points() || !(is_wanted || is_next) {
            return;
        }
        let strips = form.strips().into_iter();
        let states = strips.map(|strip| self.affine(strip)).collect();
        self.anchors.push(Anchor { sample, states });
        if self.anchors.len() > ANCHORS + self.wanted.len() {
            self.apart *= 2;
            let (from, apart, wanted) = (self.span.from, self.apart, &self.wanted);
            self.anchors.retain(|own| {
                (own.sample - from).is_multiple_of(apart) || wanted.contains(&own.sample)
            });
        }
    }

    /// Whether a quantity may have a value that is told; if it cannot, that is a conflict, or an outlier where the sample,
    /// of this number, may be one.
    fn judge(
        &mut self,
        (sample, quantity): (usize, usize),
        number: Option<usize>,
        enclosure: Interval,
        told: Interval,
    ) -> bool {
        if self.span.aim == Aim::Slopes || enclosure.intersects(told) || enclosure.is_empty() {
            return true;
        }
        let conflict = match (number, self.doubtful.get_mut(quantity)) {
            (Some(number), Some(Some(doubtful))) => {
                let samples = doubtful.exclude(number, sample);
                samples.map(|samples| Conflict::Rows {
                    samples: samples.into_iter().map(|sample| (sample, 0)).collect(),
                })
            }
            _ => Some(Conflict::Value { sample }),
        };
        if self.conflict.is_none() {
            self.conflict = conflict;
        }
        false
    }

    fn arriving(&mut self, arriving: &Arriving, sample: usize) {
        let (rest, beyond) = beyond(arriving);
        let mut slopes = arriving.ahead.slopes.clone();
        slopes.resize(self.rows.unknowns(), 0.0);
        self.rows.push(&slopes, rest, beyond, sample, 0);
    }

    /// Whether products of unknowns are unknowns.
    fn is_curved(&self) -> bool {
        !self.rows.products().is_empty()
    }

    /// A strip in the unknowns of the rows.
    fn affine(&self, strip: Strip) -> Affine {
        if self.is_curved() {
            Affine::curved(strip)
        } else {
            Affine::from(strip)
        }
    }

    /// Writes the unknowns anew where the rows leave little of them.
    fn narrow(&mut self, form: &mut Form) {
        self.rows.prune();
        match contract(&self.rows) {
            Err(conflict) => self.conflict = Some(conflict),
            Ok(parts) => {
                if parts.iter().any(|part| part.rad() < WORTHWHILE) {
                    form.narrow(&parts);
                    let by = scales_of(&parts);
                    self.rows.rescale(&by);
                    let states = self.anchors.iter_mut().flat_map(|own| &mut own.states);
                    states.for_each(|state| state.rescale(self.rows.products(), &by));
                    let fixed = self.later.iter_mut().chain(&mut self.factor);
                    fixed.for_each(|affine| affine.rescale(&[], &by));
                    for doubtful in self.doubtful.iter_mut().flatten() {
                        doubtful.rescale(&by);
                    }
                    self.scales = scales(form);
                }
                self.curvature = form.curvature();
            }
        }
    }
}

/// The smallest box around what the outer rows leave of the unit box, about, and proved to contain it; products of
/// unknowns are not told.
pub(crate) fn contract(rows: &Rows) -> Result<Vec<Interval>, Conflict> {
    if rows.products().is_empty() {
        return contract_curved(rows);
    }
    let mut part = contract_curved(&rows.curved(BELIEVED))?;
    part.truncate(rows.plain());
    Ok(part)
}

/// As [`contract`], of rows that say what bounds products; these are told as well.
pub(crate) fn contract_curved(rows: &Rows) -> Result<Vec<Interval>, Conflict> {
    let mut part = rows.whole();
    narrow(rows, &mut part, 0..rows.plain())?;
    Ok(part)
}

/// Narrows some unknowns of a box to what the outer rows leave of it, as [`contract`].
pub(crate) fn narrow(
    rows: &Rows,
    part: &mut [Interval],
    unknowns: Range<usize>,
) -> Result<(), Conflict> {
    let mut program = Program::new(rows, part, Side::Outer);
    for v in unknowns {
        for sign in [1.0, -1.0] {
            narrow_end(&mut program, (rows, part), (v, sign))?;
        }
    }
    Ok(())
}

/// Narrows the lower end of an unknown (1), or its upper one (-1), by the program of these outer rows and this box; gives where it is,
/// about.
pub(crate) fn narrow_end(
    program: &mut Program<'_>,
    (rows, part): (&Rows, &mut [Interval]),
    (v, sign): (usize, f64),
) -> Result<Vertex, Conflict> {
    let mut direction = vec![0.0; part.len()];
    direction[v] = sign;
    let vertex = program.minimize(&direction);
    let samples = || {
        let rows_held = vertex.multipliers.iter();
        let mut samples: Vec<(usize, usize)> =
            rows_held.map(|(row, _)| rows.origin(*row)).collect();
        samples.sort_unstable();
        samples.dedup();
        samples
    };
    if vertex.is_impossible {
        if refutes(rows, part, &vertex.multipliers) {
            return Err(Conflict::Rows { samples: samples() });
        }
        return Ok(vertex);
    }
    let least = minimum(rows, part, &direction, &vertex.multipliers);
    let half = if sign > 0.0 {
        Interval::new(least, f64::INFINITY)
    } else {
        Interval::new(f64::NEG_INFINITY, -least)
    };
    let narrowed = half.map_or(Interval::EMPTY, |half| part[v].intersect(half));
    if narrowed.is_empty() {
        return Err(Conflict::Rows { samples: samples() });
    }
    part[v] = narrowed;
    program.narrow(v, narrowed);
    Ok(vertex)
}
