//! One set of start states and parameters on its way through samples, and what they tell of it.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: unknowns in the order of the form's, quantities of the problem"
)]

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::past::Past;
use crate::identify::cell::Left;
use crate::identify::pass::{BLURRED, HIDDEN, WORTHWHILE, beyond, contract, hold};
use crate::identify::problem::Problem;
use crate::identify::region::{Region, scales_of};
use crate::identify::rows::{Affine, Rows};
use crate::identify::simplex::{Program, Side, minimum};
use veribound_flow::form::{Allowance, Form, FormOptions, Meeting, Stretch, Strip};
use veribound_interval::Interval;
use veribound_interval::round::{sub_down, sub_up};

/// A set that ends is moved anew, as far as it is left, where it came so many times as far as the last one.
const FARTHER: f64 = 1.2;

/// A crossing may need so many samples ahead.
pub(super) const PATIENCE: usize = 16;

/// Steps of one journey cost about so many products of coefficients: no further sample is met when that is spent,
const COST: u64 = 300_000;

/// and the journey ends after so many times that.
const MOST: u64 = 4;

/// What a linear program takes, in products of coefficients for each number of its rows.
const LINEAR: f64 = 80.0;

/// What is not affine grew, from one sample to the next, by more than this factor and this share of a width where boxes had
/// to go on for want of a crossing: with more samples ahead it may be proved.
const GROWN: f64 = 1.5;
const SHARE: f64 = 0.02;

/// What a vertex may violate, as share of a row's size, before bounds are asked for anew.
const TOLERANCE: f64 = 1e-9;

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
    /// About where quantities are least and largest, by the rows before `asked`.
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
            params,
            vertices: Vec::new(),
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
                let programs = 2 * strips.len();
                allowance.spend(self.price_of(programs)).await;
                let mut program = Program::new(&self.rows, &self.part, Side::Outer);
                let mut around = |strip: &Strip| {
                    let rest = strip.remainder + Interval::point(strip.centre);
                    let reach = strip.slopes.iter().zip(&self.part);
                    let reach = reach.fold(rest, |sum, (g, x)| sum + Interval::point(*g) * *x);
                    reach.intersect(program.bounds(&strip.slopes) + rest)
                };
                Some(strips.iter().map(&mut around).collect())
            }
        };
        // Rows of samples that will be met again.
        let has_moved = found.at > self.at || stretches.is_empty();
        self.rows.truncate(found.rows);
        (self.form, self.at, self.anchor) = (found.form, found.at, found.anchor);
        self.hidden = found.hidden;
        if self.is_told_more(rows) {
            let programs = 2 * (self.part.len() + self.region.centre.len());
            allowance.spend(self.price_of(programs)).await;
            self.tighten(problem, rows)?;
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

    /// What so many linear programs take, in products of coefficients.
    fn price_of(&self, programs: usize) -> f64 {
        LINEAR * (programs * (self.rows.len() + 1) * self.part.len()) as f64
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

    /// Whether rows say more than when they were asked, or are more than twice so many as `most`.
    fn is_told_more(&self, most: usize) -> bool {
        let is_first = self.vertices.is_empty() && self.rows.len() > 0;
        is_first || self.rows.len() > 2 * most || self.is_cut()
    }

    /// Narrows the unknowns, and leaves out the rows that say least if there are more than twice so many as `most`.
    ///
    /// Errors: all rows together leave nothing.
    fn tighten(&mut self, problem: &Problem, most: usize) -> Result<(), Option<Clash>> {
        self.part = contract(&self.rows).map_err(|_| None)?;
        if self.part.iter().any(|part| part.rad() < WORTHWHILE) {
            self.form.narrow(&self.part);
            let by = scales_of(&self.part);
            self.rows.rescale(&by);
            self.region = self.region.rescaled(&by);
            let states = self.anchor.iter_mut().flat_map(|(_, states)| states);
            for affine in states {
                affine.rescale(&[], &by);
            }
            self.part.fill(Interval::symmetric(1.0));
        }
        self.rows.prune();
        self.ask(problem);
        if self.rows.len() > 2 * most {
            self.leave_out(most);
        }
        Ok(())
    }

    /// Whether a row that is new cuts off where a quantity was least or largest.
    fn is_cut(&self) -> bool {
        (self.asked..self.rows.len()).any(|row| {
            self.vertices
                .iter()
                .any(|at| self.slack(row, at) < -TOLERANCE)
        })
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

    /// Bounds of all quantities, and where they are least and largest.
    fn ask(&mut self, problem: &Problem) {
        let mut program = Program::new(&self.rows, &self.part, Side::Outer);
        let states = problem.layout.states;
        let mut vertices = Vec::new();
        for quantity in 0..self.region.centre.len() {
            let row = &self.region.axes[quantity];
            let mut around = self.region.range(quantity, &self.part);
            if row.iter().all(|x| *x == 0.0) {
                continue;
            }
            for sign in [1.0, -1.0] {
                let direction: Vec<f64> = row.iter().map(|x| sign * x).collect();
                let vertex = program.minimize(&direction);
                if vertex.is_impossible {
                    continue;
                }
                let least = minimum(&self.rows, &self.part, &direction, &vertex.multipliers);
                vertices.push(vertex.point);
                let half = Interval::new(least, f64::INFINITY).unwrap_or(Interval::ENTIRE);
                let half = half * Interval::point(sign) + self.region.offset(quantity);
                around = around.intersect(half);
            }
            if let Some(own) = quantity.checked_sub(states) {
                // What is empty by rounding of the last digits proves nothing here: rows are asked for that.
                let both = self.params[own].intersect(around);
                self.params[own] = if both.is_empty() { around } else { both };
            }
        }
        self.vertices = vertices;
    }

    /// Leaves out all rows but those that are nearest to where a quantity is least or largest.
    fn leave_out(&mut self, most: usize) {
        let nearest = |row: usize| {
            let all = self.vertices.iter().map(|at| self.slack(row, at));
            all.fold(f64::INFINITY, f64::min)
        };
        let slacks: Vec<f64> = (0..self.rows.len()).map(nearest).collect();
        let mut order: Vec<usize> = (0..slacks.len()).collect();
        order.sort_by(|a, b| slacks[*a].total_cmp(&slacks[*b]).then(b.cmp(a)));
        let mut is_kept = vec![false; slacks.len()];
        order.iter().take(most).for_each(|row| is_kept[*row] = true);
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
        let rows = 1..=self.rows.len();
        let first = rows.take_while(|row| contract(&before(*row)).is_ok());
        let row = first.last().unwrap_or(0).min(self.rows.len() - 1);
        let (whole, before) = (vec![Interval::symmetric(1.0); unknowns], before(row));
        let bounds = Program::new(&before, &whole, Side::Outer).bounds(self.rows.slopes(row));
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
