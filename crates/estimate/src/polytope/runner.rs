//! One set of start states and parameters on its way through samples, and what they tell of it.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: unknowns in the order of the form's, quantities of the problem"
)]

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::past::Past;
use crate::identify::cell::Left;
use crate::identify::pass::{
    BLURRED, Conflict, HIDDEN, WORTHWHILE, beyond, hold, narrow, narrow_end,
};
use crate::identify::problem::Problem;
use crate::identify::region::{Region, scales_of};
use crate::identify::rows::{Affine, Rows};
use crate::identify::simplex::{Program, Side, minimum};
use veribound_flow::form::{Allowance, Form, FormOptions, Meeting, Stretch, Strip};
use veribound_interval::Interval;
use veribound_interval::round::{sub_down, sub_up};

/// A set that ends is moved anew, as far as it is left, where it came so many times as far as the last one.
const FARTHER: f64 = 1.2;

/// What is known of a parameter tells something where it is less than this share of what the set says.
const TOLD: f64 = 0.9;

/// A crossing may need so many samples ahead.
pub(super) const PATIENCE: usize = 16;

/// Steps of one journey cost about so many products of coefficients: no further sample is met when that is spent,
const COST: u64 = 300_000;

/// and the journey ends after so many times that.
const MOST: u64 = 4;

/// What a number that a linear program looks at takes, in products of coefficients.
const NUMBER: f64 = 4.0;

/// What is not affine grew, from one sample to the next, by more than this factor and this share of a width where boxes had
/// to go on for want of a crossing: with more samples ahead it may be proved.
const GROWN: f64 = 1.5;
const SHARE: f64 = 0.02;

/// What a vertex may violate, as share of a row's size, before bounds are asked for anew.
const TOLERANCE: f64 = 1e-9;

/// and how far it may be outside of what unknowns may be.
const OUTSIDE: f64 = 1e-6;

/// A set on its way.
pub(super) struct Runner {
    /// Start states at the sample `base`, then parameters, as functions of the unknowns.
    region: Region,
    /// The sample it began at,
    pub(super) base: u64,
    /// and the last that was met.
    pub(super) at: u64,
    form: Form,
    rows: Rows,
    /// The unknowns that rows leave.
    part: Vec<Interval>,
    /// Parameters that rows leave.
    params: Vec<Interval>,
    /// About where every unknown, then every parameter, is least and largest, by the rows before `asked`; empty where nobody asked.
    vertices: Vec<Vec<f64>>,
    asked: usize,
    /// The last sample that told something, and the states there.
    anchor: Option<(u64, Vec<Affine>)>,
    /// So many samples in a row told little.
    hidden: usize,
    /// The last sample that an earlier set met which began at the same one.
    reach: u64,
    /// Where it stands, it is moved again when this sample is known.
    again: u64,
}

/// What stands in the way of a sample: no solution of the set agrees with it.
#[derive(Debug)]
pub(super) struct Clash {
    pub(super) sample: u64,
    pub(super) quantity: usize,
    /// Every value that the quantity could have, and every one it has.
    pub(super) enclosure: Interval,
    pub(super) told: Interval,
}

/// What became of a set.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Fate {
    /// It goes on.
    Alive,
    /// It tells nothing of later samples.
    Ended,
}

/// What a journey brings.
struct Found {
    form: Form,
    at: u64,
    /// Rows of the samples until then.
    rows: usize,
    anchor: Option<(u64, Vec<Affine>)>,
    hidden: usize,
}

impl Runner {
    /// A set at a sample, whose own states are in the region.
    pub(super) fn new(problem: &Problem, region: &Region, base: u64) -> Runner {
        let all: Vec<usize> = (0..region.centre.len()).collect();
        let (set, _) = region.rows_of(&all);
        let options = FormOptions {
            degree: Some(2),
            ..FormOptions::default()
        };
        let form = problem.outer.flow.start_in(&set, options);
        let unknowns = form.scales().len();
        let region = Region {
            centre: set.centre,
            axes: set.axes,
            rest: set.rest,
        };
        let part = vec![Interval::symmetric(1.0); unknowns];
        let params = region.hull().split_off(problem.layout.states);
        Runner {
            region,
            base,
            at: base,
            form,
            rows: Rows::new(unknowns),
            part,
            vertices: vec![Vec::new(); 2 * (unknowns + params.len())],
            params,
            asked: 0,
            anchor: None,
            hidden: 0,
            reach: base,
            again: 0,
        }
    }

    /// A set at the same sample, part of this one.
    pub(super) fn again(&self, problem: &Problem, region: &Region) -> Runner {
        Runner {
            reach: self.at,
            ..Runner::new(problem, region, self.base)
        }
    }

    /// Whether it came much farther than an earlier one.
    pub(super) fn has_gone_farther(&self) -> bool {
        let farther = |at: u64| (at - self.base) as f64;
        farther(self.at) > FARTHER * farther(self.reach)
    }

    /// Proved bounds of the parameters of all its solutions that agree with the samples met.
    pub(super) fn params(&self) -> &[Interval] {
        &self.params
    }

    /// The smallest share that is left of an axis since the begin.
    pub(super) fn left(&self) -> f64 {
        let scales = self.form.scales().into_iter().zip(&self.part);
        scales
            .map(|((_, _, radius), part)| radius.hi() * part.rad())
            .fold(1.0, f64::min)
    }

    /// The set that is left at its begin, and whether it was turned along what rows say.
    pub(super) fn smaller(&self) -> (Region, bool) {
        let left = Left {
            region: &self.region,
            rows: &self.rows,
            part: &self.part,
        };
        left.smaller(true)
    }

    /// Goes on through at most `most` samples of `past`, which begins at its own, and keeps at most twice so many rows as `rows`;
    /// `newest` is the last one of the record. It waits wherever it has spent what `allowance` gave.
    ///
    /// Gives what becomes of it, and the states at the newest sample if it came so far.
    ///
    /// Errors: a sample that no solution of the set agrees with; or nothing, where the rows together leave none.
    pub(super) async fn go(
        &mut self,
        problem: &Problem,
        (past, newest): (&Past, u64),
        (most, rows): (usize, usize),
        allowance: &Allowance,
    ) -> Result<(Fate, Option<Vec<Interval>>), Option<Clash>> {
        let stretches = past.stretches();
        let followed = self.follow(problem, (past, newest), (&stretches, most), allowance);
        let (found, here) = followed.await?;
        let states = match here {
            None => None,
            Some(strips) => {
                let mut program = Program::new(&self.rows, &self.part, Side::Outer);
                let mut states = Vec::with_capacity(strips.len());
                for strip in &strips {
                    let rest = strip.remainder + Interval::point(strip.centre);
                    let reach = strip.slopes.iter().zip(&self.part);
                    let reach = reach.fold(rest, |sum, (g, x)| sum + Interval::point(*g) * *x);
                    states.push(reach.intersect(program.bounds(&strip.slopes) + rest));
                    allowance.spend(NUMBER * program.took()).await;
                }
                Some(states)
            }
        };
        // Rows of samples that will be met again.
        let has_moved = found.at > self.at || stretches.is_empty();
        self.rows.truncate(found.rows);
        (self.form, self.at, self.anchor) = (found.form, found.at, found.anchor);
        self.hidden = found.hidden;
        self.tighten(allowance).await.map_err(|_| None)?;
        if self.rows.len() > 2 * rows {
            self.leave_out(rows);
        }
        self.asked = self.rows.len();
        // One that stands waits for more samples, as long as they may help.
        let waits = self.at + PATIENCE as u64 > newest;
        if !has_moved {
            self.again = newest + (newest - self.at).min(PATIENCE as u64);
        }
        let fate = if self.hidden > HIDDEN || !(has_moved || waits) {
            Fate::Ended
        } else {
            Fate::Alive
        };
        Ok((fate, states))
    }

    /// Parameters are in these intervals for all solutions that agree with the samples so far.
    ///
    /// Proof. A parameter is `c + Σ g_v δ_v`, up to the region's rest, so each `δ_v` lies in what is known less the others, divided by `g_v`.
    pub(super) fn learn(&mut self, known: &[Interval]) {
        for (param, known) in known.iter().enumerate() {
            if known.width() > TOLD * self.params[param].width() {
                continue;
            }
            let quantity = self.states() + param;
            for (v, slope) in self.region.axes[quantity].iter().enumerate() {
                if *slope == 0.0 {
                    continue;
                }
                let pairs = self.region.axes[quantity]
                    .iter()
                    .zip(&self.part)
                    .enumerate();
                let others = pairs.filter(|(other, _)| *other != v);
                let others = others.fold(self.region.offset(quantity), |sum, (_, (g, x))| {
                    sum + Interval::point(*g) * *x
                });
                let left = (*known - others) / Interval::point(*slope);
                // Rows are asked whether nothing is left.
                let left = self.part[v].intersect(left);
                if !left.is_empty() {
                    self.part[v] = left;
                }
            }
            bound(&mut self.params[param], *known);
        }
        self.shrink();
    }

    /// Goes over to unknowns of the unit box where much less of it is left.
    fn shrink(&mut self) {
        if self.part.iter().all(|part| part.rad() >= WORTHWHILE) {
            return;
        }
        self.form.narrow(&self.part);
        let by = scales_of(&self.part);
        self.rows.rescale(&by);
        self.region = self.region.rescaled(&by);
        let states = self.anchor.iter_mut().flat_map(|(_, states)| states);
        for affine in states {
            affine.rescale(&[], &by);
        }
        for at in &mut self.vertices {
            for (x, (middle, radius)) in at.iter_mut().zip(&by) {
                let radius = radius.mid();
                // Nothing depends on what is a point any more.
                *x = if radius > 0.0 {
                    (*x - middle.mid()) / radius
                } else {
                    0.0
                };
            }
        }
        self.part.fill(Interval::symmetric(1.0));
    }

    /// Whether there is a sample that it has not met, and may meet now that `newest` is known.
    pub(super) fn may_go(&self, newest: u64) -> bool {
        (self.at < newest || self.at == self.base) && newest >= self.again
    }

    /// Moves the form, and writes down what samples say.
    async fn follow(
        &mut self,
        problem: &Problem,
        (past, newest): (&Past, u64),
        (stretches, most): (&[Stretch], usize),
        allowance: &Allowance,
    ) -> Result<(Found, Option<Vec<Strip>>), Clash> {
        let begin = self.at;
        let is_first = begin == self.base && self.asked == 0;
        let (over, spent) = (AtomicBool::new(false), AtomicU64::new(0));
        let (ends, is_over) = (
            || over.store(true, Ordering::Relaxed),
            || over.load(Ordering::Relaxed),
        );
        let form = self.form.clone();
        let before = form.strips();
        let mut found = Found {
            form: self.form.clone(),
            at: begin,
            rows: self.rows.len(),
            anchor: self.anchor.take(),
            hidden: self.hidden,
        };
        let (mut here, mut clash) = (None, None);
        let meet = &mut |meeting: Meeting<'_>| {
            let sample = begin + meeting.stretch as u64;
            if clash.is_some() || is_over() || (sample == begin && !is_first) {
                return;
            }
            let is_passing = meeting.is_passing;
            let told = self.meet(problem, past, meeting, sample);
            let (form, sight) = match told {
                Ok(met) => met,
                Err(found) => {
                    clash = Some(found);
                    ends();
                    return;
                }
            };
            // What has jumped there is not in the form.
            let strips = form.strips();
            if sample == newest && sight != Sight::Jumping {
                here = Some(strips.clone());
            }
            let may_wait = begin + PATIENCE as u64 > newest;
            if is_passing || may_wait && has_grown(&before, &strips) {
                return;
            }
            match sight {
                Sight::Clear => {
                    found.hidden = 0;
                    let states = strips.into_iter().map(Affine::from);
                    found.anchor = Some((sample, states.collect()));
                }
                Sight::Blurred => found.hidden += 1,
                Sight::None | Sight::Jumping => {}
            }
            found.form = form.clone();
            found.at = sample;
            found.rows = self.rows.len();
            if sample >= begin + most as u64 || spent.load(Ordering::Relaxed) >= COST {
                ends();
            }
        };
        let go_on = |form: &Form| {
            let cost = form.cost() as u64;
            let spent = spent.fetch_add(cost, Ordering::Relaxed) + cost;
            !is_over() && spent <= MOST * COST.max(cost)
        };
        // On failure what was met stays.
        let flow = &problem.outer.flow;
        let _ = flow.travel(form, stretches, meet, &go_on, allowance).await;
        match clash {
            Some(clash) => Err(clash),
            None => Ok((found, here)),
        }
    }

    /// Writes down what a sample says of a form.
    fn meet<'f>(
        &mut self,
        problem: &Problem,
        past: &Past,
        meeting: Meeting<'f>,
        sample: u64,
    ) -> Result<(&'f mut Form, Sight), Clash> {
        let form = meeting.form;
        let moment = past.moment(sample);
        let mut sight = Sight::None;
        if problem.outer.flow.may_jump(form, &past.inputs_at(sample)) {
            return Ok((form, Sight::Jumping));
        }
        for (quantity, told) in &moment.told {
            let output = &problem.outer.quantities[*quantity];
            let Ok(strip) = form.strip(output, &moment.inputs) else {
                continue;
            };
            let rest = strip.remainder + Interval::point(strip.centre);
            let reach = strip.slopes.iter().zip(&self.part);
            let enclosure = reach.fold(rest, |sum, (g, x)| sum + Interval::point(*g) * *x);
            if !enclosure.intersects(*told) && !enclosure.is_empty() {
                return Err(Clash {
                    sample,
                    quantity: *quantity,
                    enclosure,
                    told: *told,
                });
            }
            if let (Some(state), true) = (output.state(), told.is_point()) {
                hold(form, state, *told);
            }
            if *quantity < problem.outputs {
                let is_blurred = strip.remainder.width() > BLURRED * told.width();
                if !is_blurred {
                    sight = Sight::Clear;
                } else if sight == Sight::None {
                    sight = Sight::Blurred;
                }
            }
            let arriving = meeting.arriving.as_ref().filter(|arriving| {
                output.state() == Some(arriving.state)
                    && arriving.level.is_point()
                    && arriving.level == *told
            });
            let position = usize::try_from(sample).unwrap_or(usize::MAX);
            if let Some(arriving) = arriving {
                let (rest, beyond) = beyond(arriving);
                let slopes = &arriving.ahead.slopes;
                self.rows.push(slopes, rest, beyond, position, *quantity);
            } else if !enclosure.is_subset_of(*told) {
                self.rows
                    .push(&strip.slopes, rest, *told, position, *quantity);
            }
        }
        Ok((form, sight))
    }

    /// Narrows unknowns and parameters where a row that is new cuts off what was least or largest: elsewhere it says nothing.
    ///
    /// Errors: all rows together leave nothing.
    async fn tighten(&mut self, allowance: &Allowance) -> Result<(), Conflict> {
        let cut = self.cut();
        if cut.is_empty() {
            return Ok(());
        }
        let (unknowns, before) = (self.part.len(), self.part.clone());
        let mut program = Program::new(&self.rows, &self.part, Side::Outer);
        for end in cut {
            let sign = if end % 2 == 0 { 1.0 } else { -1.0 };
            let vertex = match (end / 2).checked_sub(unknowns) {
                None => {
                    let all = (&self.rows, &mut self.part[..]);
                    let narrowed = narrow_end(&mut program, all, (end / 2, sign));
                    if narrowed.is_err() {
                        // Rows are asked which of them it is, from here.
                        self.part.clone_from(&before);
                    }
                    narrowed?
                }
                Some(param) => {
                    let quantity = self.states() + param;
                    let row = self.region.axes[quantity].iter();
                    let direction: Vec<f64> = row.map(|x| sign * x).collect();
                    let vertex = program.minimize(&direction);
                    if !vertex.is_impossible {
                        let least =
                            minimum(&self.rows, &self.part, &direction, &vertex.multipliers);
                        let half = Interval::new(least, f64::INFINITY).unwrap_or(Interval::ENTIRE);
                        let half = half * Interval::point(sign) + self.region.offset(quantity);
                        bound(&mut self.params[param], half);
                    }
                    vertex
                }
            };
            self.vertices[end] = vertex.point;
            allowance.spend(NUMBER * program.took()).await;
        }
        for param in 0..self.params.len() {
            let quantity = self.states() + param;
            let range = self.region.range(quantity, &self.part);
            bound(&mut self.params[param], range);
        }
        self.shrink();
        self.rows.prune();
        Ok(())
    }

    /// Number of states in the region.
    fn states(&self) -> usize {
        self.region.centre.len() - self.params.len()
    }

    /// The ends of unknowns and parameters that rows since `asked` or what was learned cut off, or that nobody asked for. A parameter that follows one unknown
    /// has no end of its own.
    fn cut(&self) -> Vec<usize> {
        let is_own = |end: &usize| match (end / 2).checked_sub(self.part.len()) {
            None => true,
            Some(param) => {
                let row = self.region.axes[self.states() + param].iter();
                row.filter(|x| **x != 0.0).count() > 1
            }
        };
        let new = self.asked..self.rows.len();
        let is_cut = |end: &usize| {
            let at = &self.vertices[*end];
            let mut pairs = at.iter().zip(&self.part);
            let is_beyond =
                |(x, part): (&f64, &Interval)| (*x - part.mid()).abs() > part.rad() + OUTSIDE;
            let mut new = new.clone();
            at.is_empty() || pairs.any(is_beyond) || new.any(|row| self.slack(row, at) < -TOLERANCE)
        };
        if new.is_empty() {
            return Vec::new();
        }
        let ends = 0..self.vertices.len();
        ends.filter(is_own).filter(is_cut).collect()
    }

    /// About how far a point is from the nearer end of a row, as share of the row's size; negative outside.
    fn slack(&self, row: usize, at: &[f64]) -> f64 {
        let slopes = self.rows.slopes(row);
        let (mut value, mut size) = (0.0, 1e-300);
        for (g, x) in slopes.iter().zip(at) {
            value += g * x;
            size += g.abs();
        }
        let outer = self.rows.outer(row);
        (value - outer.lo()).min(outer.hi() - value) / size
    }

    /// Leaves out all rows but so many of those that are nearest to where an unknown or a parameter is least or largest: the nearest to
    /// each, then the next ones.
    fn leave_out(&mut self, most: usize) {
        self.rows.leave_out_implied();
        let asked = self.vertices.iter().filter(|at| !at.is_empty());
        let nearest = asked.map(|at| {
            let slacks = (0..self.rows.len()).map(|row| (self.slack(row, at), row));
            let mut slacks: Vec<(f64, usize)> = slacks.collect();
            slacks.sort_by(|(a, old), (b, new)| a.total_cmp(b).then(new.cmp(old)));
            slacks
        });
        let nearest: Vec<Vec<(f64, usize)>> = nearest.collect();
        let mut is_kept = vec![false; self.rows.len()];
        let mut left = most;
        for place in 0..self.rows.len() {
            for (_, row) in nearest.iter().filter_map(|rows| rows.get(place)) {
                if left > 0 && !is_kept[*row] {
                    is_kept[*row] = true;
                    left -= 1;
                }
            }
        }
        self.rows.retain(|_, row| is_kept[row]);
    }

    /// The first row that leaves nothing, as a sample and what the rows before say of it.
    pub(super) fn explain(&self, past: &Past) -> Clash {
        let unknowns = self.rows.unknowns();
        let before = |row: usize| {
            let mut before = self.rows.clone();
            before.truncate(row);
            before
        };
        let leaves = |row: &usize| {
            let mut part = self.part.clone();
            narrow(&before(*row), &mut part, 0..unknowns).is_ok()
        };
        let first = (1..=self.rows.len()).take_while(leaves);
        let row = first.last().unwrap_or(0).min(self.rows.len() - 1);
        let before = before(row);
        let bounds = Program::new(&before, &self.part, Side::Outer).bounds(self.rows.slopes(row));
        let (sample, quantity) = self.rows.origin(row);
        let told = past
            .told(sample as u64, quantity)
            .unwrap_or(Interval::ENTIRE);
        // The row says that `bounds + rest` meets what is told, or is beyond it.
        let outer = self.rows.outer(row);
        let lo = if outer.hi().is_finite() {
            (told.hi(), sub_down(told.hi(), outer.hi()))
        } else {
            (f64::INFINITY, f64::NEG_INFINITY)
        };
        let hi = if outer.lo().is_finite() {
            (told.lo(), sub_up(told.lo(), outer.lo()))
        } else {
            (f64::NEG_INFINITY, f64::INFINITY)
        };
        let rest = Interval::new(lo.1, hi.1).unwrap_or(Interval::ENTIRE);
        Clash {
            sample: sample as u64,
            quantity,
            enclosure: bounds + rest,
            told: Interval::new(hi.0, lo.0).unwrap_or(told),
        }
    }

    /// States at the last sample that told something, where that is not the one it began at.
    pub(super) fn anchored(&self) -> Option<(u64, Vec<Interval>)> {
        let (sample, states) = self.anchor.as_ref()?;
        let mut program = Program::new(&self.rows, &self.part, Side::Outer);
        let states = states.iter();
        let box_: Vec<Interval> = states.map(|state| program.around(state)).collect();
        let is_bounded = box_.iter().all(|x| x.is_bounded());
        (is_bounded && *sample > self.base).then_some((*sample, box_))
    }
}

/// A parameter is in this interval, too.
fn bound(param: &mut Interval, known: Interval) {
    // What is empty by rounding of the last digits proves nothing here: rows are asked for that.
    let both = param.intersect(known);
    *param = if both.is_empty() { known } else { both };
}

/// Whether much more is not affine in some state than before.
fn has_grown(before: &[Strip], now: &[Strip]) -> bool {
    before.iter().zip(now).any(|(before, now)| {
        let (was, is) = (before.remainder.width(), now.remainder.width());
        let reach: f64 = now.slopes.iter().map(|g| g.abs()).sum();
        is > GROWN * was + SHARE * (reach + is)
    })
}

/// How much a sample tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sight {
    /// What is at the sample may have jumped there.
    Jumping,
    None,
    Blurred,
    Clear,
}
