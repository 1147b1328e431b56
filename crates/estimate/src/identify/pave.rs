//! The paving: tiles of parameters inside, outside, and undecided.
//!
//! The largest undecided tile is halved again and again. Rows that samples give on a larger tile around decide most
//! halves without moving anything through the record; only where what is not affine hides the answer, the tile
//! is moved itself.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one interval per parameter, unknowns and rows of the same region"
)]

use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};

use super::answer::{Progress, Reason, Status, Tile};
use super::cell::{BELIEVED, Cell, is_well_inside};
use super::pass::Conflict;
use super::problem::Problem;
use super::region::Region;
use super::rows::SEVERAL;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use veribound_interval::Interval;

/// Most tiles of a paving.
const MOST_TILES: usize = 400_000;

/// Tiles that are moved through the records at once, whatever the number of threads.
const AT_ONCE: usize = 8;

/// Tiles are moved with so much around them, as share of their width.
const MARGIN: f64 = 1e-5;

/// Rows hide the answer where this share of a tile's reach is not affine.
const HIDDEN: f64 = 0.5;

/// Rows in unknowns of which some are parameters, each alone.
#[derive(Debug, Serialize, Deserialize)]
struct Local {
    cell: Cell,
    /// For every parameter its axis, if it has one.
    axes: Vec<Option<usize>>,
    /// Unknowns of the start states that may agree.
    starts: Vec<f64>,
}

/// A tile that is not decided.
#[derive(Debug, Serialize, Deserialize)]
struct Open {
    params: Vec<Interval>,
    volume: f64,
    /// The rows that hold on it, unless it has to be moved itself: a key of [`State::locals`].
    local: Option<usize>,
    /// The parameter to halve.
    axis: usize,
    order: usize,
}

impl PartialEq for Open {
    fn eq(&self, other: &Open) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Open {}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Open) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Open {
    fn cmp(&self, other: &Open) -> Ordering {
        let volumes = self.volume.total_cmp(&other.volume);
        volumes.then(other.order.cmp(&self.order))
    }
}

/// What rows say of a tile.
enum Said {
    Inside,
    Outside(Reason),
    /// Not decided; the parameter to halve.
    Halve(usize),
    /// What is not affine hides the answer.
    Hidden(usize),
}

/// All tiles.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(crate) struct State {
    open: BinaryHeap<Open>,
    /// Rows by key, and how many open tiles they hold on.
    locals: BTreeMap<usize, (Local, usize)>,
    tiles: Vec<Tile>,
    undecided: f64,
    inside: f64,
    next: usize,
    /// Bytes that rows take, about.
    held: usize,
    /// No more tiles are moved through the records.
    is_spent: bool,
    pub(crate) sets: usize,
    pub(crate) passes: usize,
}

/// A paving under way.
pub(crate) struct Paving<'a> {
    problem: &'a Problem,
    pub(crate) state: State,
}

fn volume(params: &[Interval]) -> f64 {
    let wide = params.iter().filter(|x| x.width() > 0.0);
    wide.map(|x| x.width()).product()
}

impl<'a> Paving<'a> {
    /// Goes on with what was begun, or with the prior as one open tile.
    pub(crate) fn new(problem: &'a Problem, begun: Option<State>) -> Paving<'a> {
        let is_new = begun.is_none();
        let mut paving = Paving {
            problem,
            state: begun.unwrap_or_default(),
        };
        if is_new {
            paving.push(problem.prior.clone(), None, 0);
        }
        paving
    }

    fn push(&mut self, params: Vec<Interval>, local: Option<usize>, axis: usize) {
        let volume = volume(&params);
        self.state.undecided += volume;
        self.state.next += 1;
        self.state.open.push(Open {
            params,
            volume,
            local,
            axis,
            order: self.state.next,
        });
    }

    fn close(&mut self, params: Vec<Interval>, status: Status, reason: Reason) {
        if status == Status::Inside {
            self.state.inside += volume(&params);
        }
        self.state.tiles.push(Tile {
            params,
            status,
            reason,
        });
    }

    /// Goes on until open tiles are at most this share of the volume that is not excluded, `sets` tiles were moved
    /// through the records, or so many bytes are taken; false if it was asked to end.
    pub(crate) fn run(
        &mut self,
        (share, sets, memory): (f64, usize, usize),
        save: &dyn Fn(&State),
        go_on: &dyn Fn(&Progress) -> bool,
    ) -> bool {
        let mut waiting: Vec<Open> = Vec::new();
        while !self.state.is_spent
            && self.state.undecided > share * (self.state.undecided + self.state.inside)
            && self.state.tiles.len() + self.state.open.len() < MOST_TILES
            && self.bytes() <= memory
        {
            let Some(open) = self.state.open.pop() else {
                if waiting.is_empty() {
                    break;
                }
                if !self.move_all(&mut waiting, sets, go_on) {
                    return false;
                }
                self.keep(save);
                continue;
            };
            self.state.undecided -= open.volume;
            match open.local {
                None => {
                    self.state.undecided += open.volume;
                    waiting.push(open);
                    if waiting.len() >= AT_ONCE {
                        if !self.move_all(&mut waiting, sets, go_on) {
                            return false;
                        }
                        self.keep(save);
                    }
                }
                Some(local) => self.halve(&open, local),
            }
        }
        self.state.open.extend(waiting);
        true
    }

    /// Saves, but not where tiles still wait that no list holds.
    fn keep(&self, save: &dyn Fn(&State)) {
        if !self.state.is_spent {
            save(&self.state);
        }
    }

    /// What tiles and rows take in memory, about.
    fn bytes(&self) -> usize {
        let tile = 16 * self.problem.layout.params + 150;
        self.state.held + tile * (self.state.tiles.len() + self.state.open.len())
    }

    /// The open tiles stay undecided.
    pub(crate) fn tiles(mut self) -> Vec<Tile> {
        let open = std::mem::take(&mut self.state.open);
        for open in open.into_sorted_vec() {
            self.close(open.params, Status::Undecided, Reason::Budget);
        }
        self.state.tiles
    }

    /// Moves tiles through the records.
    fn move_all(
        &mut self,
        waiting: &mut Vec<Open>,
        sets: usize,
        go_on: &dyn Fn(&Progress) -> bool,
    ) -> bool {
        if self.state.sets + waiting.len() > sets {
            self.state.is_spent = true;
            return true;
        }
        let problem = self.problem;
        let mut starts = problem.believed();
        starts.truncate(problem.first_param());
        let cells: Vec<_> = waiting
            .par_iter()
            .map(|open| {
                // A little more, so that the border of the tile is inside of what rows tell about.
                let params = open.params.iter().map(|x| x.inflate(MARGIN * x.width()));
                let params: Vec<Interval> = params.collect();
                let whole = [&starts[..], &params].concat();
                problem.refine(Region::of_box(&whole), Vec::new(), false, &|| true)
            })
            .collect();
        for (open, cell) in waiting.drain(..).zip(cells) {
            self.state.undecided -= open.volume;
            self.state.sets += 1;
            match cell {
                Err(clash) => {
                    self.state.passes += clash.passes;
                    self.close(
                        open.params,
                        Status::Outside,
                        reason(clash.record, &clash.conflict),
                    );
                }
                Ok(cell) => {
                    self.state.passes += cell.passes;
                    self.moved(open.params, cell);
                }
            }
        }
        go_on(&Progress {
            sets: self.state.sets,
            waiting: self.state.open.len(),
            left: self.state.undecided / volume(&problem.prior),
            tightness: f64::NAN,
        })
    }

    /// Cuts off what the cell excludes; the rest is open, with the rows of the cell.
    fn moved(&mut self, params: Vec<Interval>, cell: Cell) {
        let first = self.problem.first_param();
        let mut rest = params;
        for param in 0..rest.len() {
            let (bounds, because) = cell.outer_because(first + param);
            let whole = rest[param];
            // What is cut off is closed: its end must be excluded, too.
            let kept = whole.intersect(bounds.inflate(f64::MIN_POSITIVE));
            if kept.is_empty() {
                self.close(rest, Status::Outside, because[0].clone());
                return;
            }
            let ends = [(whole.lo(), kept.lo()), (kept.hi(), whole.hi())];
            for ((lo, hi), because) in ends.into_iter().zip(because) {
                if lo < hi
                    && let Some(piece) = Interval::new(lo, hi)
                {
                    let mut slab = rest.clone();
                    slab[param] = piece;
                    self.close(slab, Status::Outside, because);
                }
            }
            rest[param] = kept;
        }
        let axes: Vec<Option<usize>> = (0..rest.len())
            .map(|param| {
                let row = &cell.region.axes[first + param];
                row.iter().position(|x| *x != 0.0)
            })
            .collect();
        let starts = cell.deepest().0;
        let local = Local { cell, axes, starts };
        let widest = |a: &usize, b: &usize| {
            let share = |p: usize| rest[p].width() / self.problem.prior[p].width().max(1e-300);
            share(*a).total_cmp(&share(*b))
        };
        let axis = (0..rest.len()).max_by(widest).unwrap_or(0);
        match local.says(&rest, self.problem) {
            Said::Inside => self.close(rest, Status::Inside, Reason::Met),
            Said::Outside(reason) => self.close(rest, Status::Outside, reason),
            Said::Halve(axis) => {
                let key = self.state.next;
                self.state.held += local.cell.bytes();
                self.state.locals.insert(key, (local, 1));
                self.push(rest, Some(key), axis);
            }
            // Halves are moved themselves.
            Said::Hidden(_) => {
                let halves = halves(&rest, axis);
                if halves.is_empty() {
                    self.close(rest, Status::Undecided, Reason::Budget);
                }
                for half in halves {
                    self.push(half, None, axis);
                }
            }
        }
    }

    fn halve(&mut self, open: &Open, key: usize) {
        let halves = halves(&open.params, open.axis);
        if halves.is_empty() {
            self.close(open.params.clone(), Status::Undecided, Reason::Budget);
        }
        let Some((local, mut count)) = self.state.locals.remove(&key) else {
            return;
        };
        count -= 1;
        for half in halves {
            match local.says(&half, self.problem) {
                Said::Inside => self.close(half, Status::Inside, Reason::Met),
                Said::Outside(reason) => self.close(half, Status::Outside, reason),
                Said::Halve(axis) => {
                    count += 1;
                    self.push(half, Some(key), axis);
                }
                Said::Hidden(axis) => self.push(half, None, axis),
            }
        }
        if count > 0 {
            self.state.locals.insert(key, (local, count));
        } else {
            self.state.held -= local.cell.bytes();
        }
    }
}

/// Both halves; none where the tile cannot be halved.
fn halves(params: &[Interval], axis: usize) -> Vec<Vec<Interval>> {
    let whole = params[axis];
    let at = whole.mid();
    if !(whole.lo() < at && at < whole.hi()) {
        return Vec::new();
    }
    let ends = [(whole.lo(), at), (at, whole.hi())];
    ends.into_iter()
        .filter_map(|(lo, hi)| {
            let mut half = params.to_vec();
            half[axis] = Interval::new(lo, hi)?;
            Some(half)
        })
        .collect()
}

pub(crate) fn reason(record: usize, conflict: &Conflict) -> Reason {
    match conflict {
        Conflict::Value { sample, .. } => Reason::Sample {
            record,
            sample: *sample,
        },
        Conflict::Rows { samples } => reason_of(record, samples),
    }
}

/// The samples of one of the records that exclude something.
pub(crate) fn reason_of(record: usize, samples: &[(usize, usize)]) -> Reason {
    let told = samples.iter().filter(|(sample, _)| *sample != BELIEVED);
    let last = told.clone().map(|(_, record)| *record).max();
    let record = last.unwrap_or(record);
    let own = told.filter(|(_, own)| *own == record);
    let mut samples: Vec<usize> = own.map(|(sample, _)| *sample).collect();
    samples.sort_unstable();
    samples.dedup();
    if samples.last() == Some(&SEVERAL) {
        samples.clear();
    }
    Reason::Samples { record, samples }
}

impl Local {
    /// What the rows say of a tile inside of the cell.
    ///
    /// Proof. A parameter is `offset + M δ` with one axis of its own, so parameters of the tile have `δ` in the
    /// interval computed. With all start states of the cell, rows that cannot be met exclude the tile. With one
    /// point of these, rows that are met by all `δ` of the tile prove it.
    fn says(&self, params: &[Interval], problem: &Problem) -> Said {
        let cell = &self.cell;
        let first = problem.first_param();
        let mut wide = cell.part.clone();
        let mut is_inside = cell.is_complete;
        let mut narrow: Vec<Interval> = self.starts.iter().map(|x| Interval::point(*x)).collect();
        for (param, (axis, x)) in self.axes.iter().zip(params).enumerate() {
            let Some(axis) = axis else { continue };
            let slope = Interval::point(cell.region.axes[first + param][*axis]);
            let own = (*x - cell.region.offset(first + param)) / slope;
            narrow[*axis] = own;
            wide[*axis] = own.intersect(wide[*axis]);
            if wide[*axis].is_empty() {
                return Said::Outside(Reason::Samples {
                    record: 0,
                    samples: Vec::new(),
                });
            }
        }
        is_inside &= narrow.iter().all(|x| is_well_inside(*x));
        let mut worst = None;
        let mut missing = 0.0;
        for row in 0..cell.rows.len() {
            let slopes = cell.rows.slopes(row);
            let (sample, record) = cell.rows.origin(row);
            let sum = |at: &[Interval]| {
                let terms = slopes.iter().zip(at);
                terms.fold(Interval::ZERO, |sum, (g, x)| sum + Interval::point(*g) * *x)
            };
            let all = sum(&wide);
            let outer = cell.rows.outer(row);
            if !all.intersects(outer) {
                return Said::Outside(reason_of(record, &[(sample, record)]));
            }
            let some = sum(&narrow);
            let inner = cell.rows.inner(row);
            if some.is_subset_of(inner) {
                continue;
            }
            is_inside = false;
            // How much of what is missing no halving brings.
            // Of one that may be an outlier nothing is known but what proves that it is none.
            let gap = if outer == Interval::ENTIRE {
                0.0
            } else {
                outer.width() - if inner.is_empty() { 0.0 } else { inner.width() }
            };
            let reach = some.width().max(1e-300);
            let below = (inner.lo() - some.lo()).max(some.hi() - inner.hi());
            let below = if below.is_finite() { below } else { reach };
            if below > missing || worst.is_none() {
                missing = below.max(0.0);
                worst = Some((row, gap / reach));
            }
        }
        if is_inside {
            return Said::Inside;
        }
        let widest = || {
            let share = |p: &usize| params[*p].width() / problem.prior[*p].width().max(1e-300);
            (0..params.len()).max_by(|a, b| share(a).total_cmp(&share(b)))
        };
        let Some((row, gap)) = worst else {
            return Said::Hidden(widest().unwrap_or(0));
        };
        let slopes = cell.rows.slopes(row);
        let reach = |param: usize| {
            let axis = self.axes[param];
            axis.map_or(0.0, |axis| (slopes[axis] * narrow[axis].width()).abs())
        };
        let axis = (0..params.len())
            .max_by(|a, b| reach(*a).total_cmp(&reach(*b)))
            .filter(|param| reach(*param) > 0.0)
            .or_else(widest)
            .unwrap_or(0);
        if gap > HIDDEN || !cell.is_complete {
            Said::Hidden(axis)
        } else {
            Said::Halve(axis)
        }
    }
}
