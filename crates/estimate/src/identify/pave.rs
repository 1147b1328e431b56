//! The paving: tiles of parameters inside, outside, and undecided.
//!
//! The largest undecided tile is halved again and again. Rows that samples give on a larger tile around decide most
//! halves without moving anything through the record; only where what is not affine hides the answer, the tile
//! is moved itself.
//!
//! Where what is left of a tile is much smaller along other axes, it is divided along these ([`Frame`]).
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one interval per coordinate of a tile, unknowns and rows of the same region"
)]

use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};

use super::answer::{Progress, Reason, Status, Tile, Turned};
use super::cell::{BELIEVED, BORDER, Cell, Clash, Known, is_well_inside};
use super::frame::{Frame, inverse};
use super::pass::Conflict;
use super::problem::Problem;
use super::region::Region;
use super::rows::{Rows, SEVERAL};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use veribound_interval::Interval;

/// Most tiles of a paving.
const MOST_TILES: usize = 400_000;

/// Tiles that are moved through the records at once, whatever the number of threads.
const AT_ONCE: usize = 8;

/// Tiles are moved with so much around them, as share of their width.
const MARGIN: f64 = 1e-5;

/// Tiles of this share of all that is not excluded are tried along other axes.
const NOTABLE: f64 = 0.003;

/// So often a tile is turned, first to a set that may be so many times as large, then to one that is smaller by this
/// factor each time,
const TURNS: usize = 6;
const LARGER: f64 = 1.0;
const SHRINKS: f64 = 0.7;

/// and stays so if what is left of it is smaller by this factor.
const NEEDLE: f64 = 0.3;

/// Halves along other axes are moved where what is not affine would leave more than this share undecided of what may be,
const BLURRED: f64 = 0.5;

/// unless they are smaller than this share of what was turned.
const PIECES: f64 = 1.0 / 128.0;

/// So many slopes of a row at most are not taken as something between where volumes are told.
const STEEP: usize = 10;

/// Rows hide the answer where this share of a tile's reach is not affine.
const HIDDEN: f64 = 0.5;

/// What rows say of tiles, in coordinates of these.
#[derive(Debug, Serialize, Deserialize)]
struct Local {
    /// Rows in the coordinates, from `base` on: outer ones for all start states, inner ones for one of them.
    rows: Rows,
    /// How much of each row is not affine.
    gaps: Vec<f64>,
    base: Vec<f64>,
    /// What widths of the coordinates are compared with.
    sizes: Vec<f64>,
    /// Whether inner rows prove that all records are met.
    is_complete: bool,
    /// So many of the last rows are borders of the upright tile around.
    borders: usize,
}

/// Axes of tiles that lie in one upright tile, `clip`, of which they are all that is not excluded.
#[derive(Debug, Serialize, Deserialize)]
struct Turn {
    frame: Frame,
    clip: Vec<Interval>,
    /// Volume of a unit of the coordinates.
    size: f64,
    /// How many of these all are together.
    whole: f64,
}

/// A tile that is not decided.
#[derive(Debug, Serialize, Deserialize)]
struct Open {
    /// Its coordinates: parameters, or unknowns of a frame.
    within: Vec<Interval>,
    /// A position in [`State::turns`].
    frame: Option<usize>,
    volume: f64,
    /// The rows that hold on it, unless it has to be moved itself: a key of [`State::locals`].
    local: Option<usize>,
    /// The coordinate to halve.
    axis: usize,
    /// The share of it that agrees, as far as rows told that do not decide it.
    agrees: Interval,
    order: usize,
}

/// What is not known of a share.
fn any_share() -> Interval {
    Interval::new(0.0, 1.0).unwrap_or(Interval::ENTIRE)
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
    /// No point of it is in the upright tile that it divides.
    Beyond,
    /// Not decided; the coordinate to halve.
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
    turns: Vec<Turn>,
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

impl Local {
    /// Whether its lists have the lengths of so many coordinates.
    fn fits(&self, coordinates: usize) -> bool {
        self.rows.unknowns() == coordinates
            && self.gaps.len() == self.rows.len()
            && self.base.len() == coordinates
            && self.sizes.len() == coordinates
    }
}

impl State {
    /// Whether its lists have the lengths of a problem with so many parameters, and what it points to is there.
    pub(crate) fn fits(&self, params: usize) -> bool {
        let coordinates = |frame: Option<usize>| match frame {
            None => Some(params),
            Some(frame) => Some(
                self.turns
                    .get(frame)?
                    .frame
                    .axes
                    .first()
                    .map_or(0, Vec::len),
            ),
        };
        let is_frame = |turn: &Turn| {
            let axes = &turn.frame.axes;
            let lists = [turn.frame.centre.len(), axes.len(), turn.clip.len()];
            lists == [params; 3] && axes.iter().all(|row| row.len() == axes[0].len())
        };
        let is_open = |open: &Open| {
            let local = open.local.map(|key| self.locals.get(&key));
            coordinates(open.frame).is_some_and(|coordinates| {
                open.within.len() == coordinates
                    && (open.axis < coordinates || coordinates == 0)
                    && local.is_none_or(|local| local.is_some_and(|own| own.0.fits(coordinates)))
            })
        };
        let is_closed = |tile: &Tile| {
            let turned = tile.turned.as_ref();
            tile.params.len() == params
                && turned.is_none_or(|turned| {
                    coordinates(Some(turned.frame)) == Some(turned.unknowns.len())
                })
                && match tile.reason {
                    Reason::Needle { frame } => frame < self.turns.len(),
                    _ => true,
                }
        };
        self.turns.iter().all(is_frame)
            && self.open.iter().all(is_open)
            && self.tiles.iter().all(is_closed)
    }
}

/// A paving under way.
pub(crate) struct Paving<'a> {
    problem: &'a Problem,
    /// Whether tiles may be divided along other axes: where start states are known, tiles and sets are the same.
    may_turn: bool,
    /// What may stay undecided.
    share: f64,
    pub(crate) state: State,
}

/// What tiles a paving came to.
#[derive(Debug, Default)]
pub(crate) struct Paved {
    pub(crate) tiles: Vec<Tile>,
    pub(crate) frames: Vec<Frame>,
    /// Volume of what agrees.
    pub(crate) volume: Option<Interval>,
}

fn volume(params: &[Interval]) -> f64 {
    let wide = params.iter().filter(|x| x.width() > 0.0);
    wide.map(|x| x.width()).product()
}

impl<'a> Paving<'a> {
    /// Goes on with what was begun, or with the prior as one open tile.
    pub(crate) fn new(problem: &'a Problem, begun: Option<State>, share: f64) -> Paving<'a> {
        let is_new = begun.is_none();
        let whole = Region::of_box(&problem.believed());
        let open = problem.prior.iter().filter(|x| !x.is_point()).count();
        let starts = &whole.axes[..problem.first_param()];
        let mut paving = Paving {
            problem,
            may_turn: open > 1
                && whole.axes() == open
                && starts.iter().flatten().all(|slope| *slope == 0.0),
            share,
            state: begun.unwrap_or_default(),
        };
        if is_new {
            paving.push(problem.prior.clone(), None, (None, 0), any_share());
        }
        paving
    }

    fn volume(&self, within: &[Interval], frame: Option<usize>) -> f64 {
        match frame {
            None => volume(within),
            Some(frame) => self.state.turns[frame].size * volume(within),
        }
    }

    /// Encloses the volume of a tile; parameters that are known do not count.
    fn enclosed(&self, within: &[Interval], frame: Option<usize>) -> Interval {
        let width = |x: &Interval| Interval::point(x.hi()) - Interval::point(x.lo());
        match frame {
            Some(frame) => self.state.turns[frame].frame.volume(within),
            None => {
                let open = within.iter().zip(&self.problem.prior);
                let open = open.filter(|(_, prior)| !prior.is_point());
                open.fold(Interval::ONE, |product, (x, _)| product * width(x))
            }
        }
    }

    fn push(
        &mut self,
        within: Vec<Interval>,
        frame: Option<usize>,
        (local, axis): (Option<usize>, usize),
        agrees: Interval,
    ) {
        let volume = self.volume(&within, frame);
        self.state.undecided += volume;
        self.state.next += 1;
        self.state.open.push(Open {
            within,
            frame,
            volume,
            local,
            axis,
            agrees,
            order: self.state.next,
        });
    }

    fn close(
        &mut self,
        within: Vec<Interval>,
        frame: Option<usize>,
        (status, reason): (Status, Reason),
    ) {
        if status == Status::Inside {
            self.state.inside += self.volume(&within, frame);
        }
        let (params, turned) = match frame {
            None => (within, None),
            Some(frame) => {
                let turn = &self.state.turns[frame];
                let hull = turn.frame.hull(&within).into_iter().zip(&turn.clip);
                let turned = Turned {
                    frame,
                    unknowns: within,
                };
                let params: Vec<Interval> = hull.map(|(x, clip)| x.intersect(*clip)).collect();
                if params.iter().any(|x| x.is_empty()) {
                    // It lies beyond the tile that it divides.
                    return;
                }
                (params, Some(turned))
            }
        };
        self.state.tiles.push(Tile {
            params,
            turned,
            status,
            reason,
        });
    }

    /// Goes on until open tiles are at most this share of the volume that is not excluded, `sets` tiles were moved
    /// through the records, or so many bytes are taken; false if it was asked to end.
    pub(crate) fn run(
        &mut self,
        (sets, memory): (usize, usize),
        save: &dyn Fn(&State),
        go_on: &dyn Fn(&Progress) -> bool,
    ) -> bool {
        let mut waiting: Vec<Open> = Vec::new();
        while !self.state.is_spent
            && self.state.undecided > self.share * (self.state.undecided + self.state.inside)
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
    pub(crate) fn tiles(mut self) -> Paved {
        let mut volume = Interval::ZERO;
        for tile in &self.state.tiles {
            let agrees = match tile.status {
                Status::Inside => Interval::ONE,
                // It could not be halved.
                Status::Undecided => any_share(),
                Status::Outside | Status::Turned => continue,
            };
            let (within, frame) = match &tile.turned {
                Some(turned) => (&turned.unknowns, Some(turned.frame)),
                None => (&tile.params, None),
            };
            volume += self.enclosed(within, frame) * agrees;
        }
        let open = std::mem::take(&mut self.state.open);
        for open in open.into_sorted_vec() {
            let local = open.local.and_then(|key| self.state.locals.get(&key));
            let agrees = local.map_or(open.agrees, |(local, _)| local.share(&open.within));
            volume += self.enclosed(&open.within, open.frame) * agrees;
            self.close(open.within, open.frame, (Status::Undecided, Reason::Budget));
        }
        Paved {
            volume: Some(volume),
            tiles: self.state.tiles,
            frames: self
                .state
                .turns
                .into_iter()
                .map(|turn| turn.frame)
                .collect(),
        }
    }

    /// A tile with a little more around, so that its border is inside of what rows tell about.
    fn region(&self, open: &Open) -> Region {
        let within = open.within.iter().map(|x| x.inflate(MARGIN * x.width()));
        let within: Vec<Interval> = within.collect();
        let mut whole = self.problem.believed();
        let first = self.problem.first_param();
        let Some(frame) = open.frame else {
            whole[first..].copy_from_slice(&within);
            return Region::of_box(&whole);
        };
        let frame = &self.state.turns[frame].frame;
        for (x, centre) in whole[first..].iter_mut().zip(&frame.centre) {
            *x = Interval::point(*centre);
        }
        let mut region = Region::of_box(&whole);
        let none = vec![0.0; within.len()];
        let starts = (0..first).map(|_| none.clone());
        region.axes = starts.chain(frame.axes.iter().cloned()).collect();
        region.part(&within)
    }

    /// What samples say of a tile, and of the same along other axes where it is much smaller there.
    fn look_at(&self, open: &Open) -> Result<(Cell, Option<Cell>), Clash> {
        let cell = self
            .problem
            .refine(self.region(open), Known::default(), false, &|| true)?;
        let notable = NOTABLE * (self.state.undecided + self.state.inside);
        if !self.may_turn || open.frame.is_some() || open.volume < notable {
            return Ok((cell, None));
        }
        let mut turned: Option<Cell> = None;
        let mut passes = 0;
        for _ in 0..TURNS {
            let region = match &turned {
                None => cell.left().turned(LARGER),
                Some(turned) => turned.left().turned(SHRINKS),
            };
            let Some(region) = region else { break };
            let spent = cell.passes + passes;
            let next = self
                .problem
                .refine(region, Known::default(), false, &|| true);
            let next = next.map_err(|clash| Clash {
                passes: spent + clash.passes,
                ..clash
            })?;
            passes += next.passes;
            turned = Some(next);
        }
        Ok((cell, turned.map(|cell| Cell { passes, ..cell })))
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
        let paving = &*self;
        let cells: Vec<_> = waiting
            .par_iter()
            .map(|open| paving.look_at(open))
            .collect();
        for (open, cell) in waiting.drain(..).zip(cells) {
            self.state.undecided -= open.volume;
            self.state.sets += 1;
            match cell {
                Err(clash) => {
                    self.state.passes += clash.passes;
                    let reason = reason(clash.record, &clash.conflict);
                    self.close(open.within, open.frame, (Status::Outside, reason));
                }
                Ok((cell, turned)) => {
                    self.state.passes += cell.passes;
                    self.state.passes += turned.as_ref().map_or(0, |cell| cell.passes);
                    self.moved(open, &cell, turned.as_ref());
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
    fn moved(&mut self, open: Open, cell: &Cell, turned: Option<&Cell>) {
        let first = self.problem.first_param();
        let Open {
            within: mut rest,
            frame,
            ..
        } = open;
        let turn = frame.map(|frame| &self.state.turns[frame]);
        let bounds: Vec<_> = match turn {
            None => (0..rest.len())
                .map(|param| cell.outer_because(first + param))
                .collect(),
            Some(turn) => turn.bounds(cell, first),
        };
        for (at, (bounds, because)) in bounds.into_iter().enumerate() {
            let whole = rest[at];
            // What is cut off is closed: its end must be excluded, too.
            let kept = whole.intersect(bounds.inflate(f64::MIN_POSITIVE));
            if kept.is_empty() {
                self.close(rest, frame, (Status::Outside, because[0].clone()));
                return;
            }
            let ends = [(whole.lo(), kept.lo()), (kept.hi(), whole.hi())];
            for ((lo, hi), because) in ends.into_iter().zip(because) {
                if lo < hi
                    && let Some(piece) = Interval::new(lo, hi)
                {
                    let mut slab = rest.clone();
                    slab[at] = piece;
                    self.close(slab, frame, (Status::Outside, because));
                }
            }
            rest[at] = kept;
        }
        let own = turned.and_then(|turned| {
            let (turn, within) = Turn::of(turned, self.problem, &rest)?;
            let is_much = turn.size * volume(&within) < NEEDLE * volume(&rest);
            is_much.then_some((turn, within, turned))
        });
        let (turn, within, cell) = match (&own, frame) {
            (Some((turn, within, turned)), _) => (Some(turn), within, *turned),
            (None, frame) => (frame.map(|frame| &self.state.turns[frame]), &rest, cell),
        };
        let said = match Local::of(cell, turn, within, self.problem) {
            Some(local) => (local.says(within), Some(local)),
            None => (Said::Hidden(widest(&rest, &self.sizes(frame))), None),
        };
        match said {
            (Said::Halve(axis), Some(local)) => {
                let bent = bent(cell, first, turn.is_some());
                let blurred = local.blurred(within);
                let (frame, within) = match own {
                    None => (frame, rest),
                    Some((turn, within, _)) => {
                        let frame = self.state.turns.len();
                        self.close(rest, None, (Status::Turned, Reason::Needle { frame }));
                        self.state.turns.push(turn);
                        (Some(frame), within)
                    }
                };
                // Halves say more than rows of the whole where these leave too much undecided.
                let is_rough = frame.is_some_and(|frame| {
                    let whole = self.state.turns[frame].whole;
                    blurred > BLURRED * self.share && volume(&within) > PIECES * whole
                });
                if is_rough && let Some(axis) = bent {
                    for half in halves(&within, axis) {
                        self.push(half, frame, (None, axis), any_share());
                    }
                    return;
                }
                let key = self.state.next;
                self.state.held += local.bytes();
                self.state.locals.insert(key, (local, 1));
                self.push(within, frame, (Some(key), axis), any_share());
            }
            (Said::Inside, _) if own.is_none() => {
                self.close(rest, frame, (Status::Inside, Reason::Met));
            }
            (Said::Outside(reason), _) => self.close(rest, frame, (Status::Outside, reason)),
            (Said::Beyond, _) if own.is_none() => {}
            // Halves are moved themselves.
            _ => {
                let axis = widest(&rest, &self.sizes(frame));
                let halves = halves(&rest, axis);
                if halves.is_empty() {
                    self.close(rest, frame, (Status::Undecided, Reason::Budget));
                }
                for half in halves {
                    self.push(half, frame, (None, axis), any_share());
                }
            }
        }
    }

    /// What widths of coordinates are compared with.
    fn sizes(&self, frame: Option<usize>) -> Vec<f64> {
        match frame {
            None => self.problem.prior.iter().map(|x| x.width()).collect(),
            Some(frame) => {
                let axes = &self.state.turns[frame].frame.axes;
                vec![1.0; axes.first().map_or(0, Vec::len)]
            }
        }
    }

    fn halve(&mut self, open: &Open, key: usize) {
        let frame = open.frame;
        let halves = halves(&open.within, open.axis);
        if halves.is_empty() {
            self.close(
                open.within.clone(),
                frame,
                (Status::Undecided, Reason::Budget),
            );
        }
        let Some((local, mut count)) = self.state.locals.remove(&key) else {
            return;
        };
        count -= 1;
        for half in halves {
            match local.says(&half) {
                Said::Inside => self.close(half, frame, (Status::Inside, Reason::Met)),
                Said::Outside(reason) => self.close(half, frame, (Status::Outside, reason)),
                Said::Beyond => {}
                Said::Halve(axis) => {
                    count += 1;
                    self.push(half, frame, (Some(key), axis), any_share());
                }
                Said::Hidden(axis) => {
                    let agrees = local.share(&half);
                    self.push(half, frame, (None, axis), agrees);
                }
            }
        }
        if count > 0 {
            self.state.locals.insert(key, (local, count));
        } else {
            self.state.held -= local.bytes();
        }
    }
}

/// The coordinate on which what is told depends most in other ways than affine ones.
fn bent(cell: &Cell, first: usize, is_turned: bool) -> Option<usize> {
    let params = &cell.region.axes[first..];
    let axes: Vec<Option<usize>> = if is_turned {
        (0..cell.region.axes()).map(Some).collect()
    } else {
        let own = |row: &Vec<f64>| row.iter().position(|slope| *slope != 0.0);
        params.iter().map(own).collect()
    };
    let bend =
        |at: &usize| axes[*at].map_or(0.0, |axis| cell.curvature[axis] * cell.part[axis].rad());
    let most = (0..axes.len()).max_by(|a, b| bend(a).total_cmp(&bend(b)))?;
    (bend(&most) > 0.0).then_some(most)
}

/// Slopes below this share of the largest are taken as something between.
const FLAT: f64 = 1e-3;

/// Encloses the share of a box in which `slopes·x` is between two bounds.
fn between(slopes: &[f64], box_: &[Interval], bounds: Interval) -> Interval {
    if bounds.is_empty() {
        return Interval::ZERO;
    }
    below(slopes, box_, bounds.hi(), false) - below(slopes, box_, bounds.lo(), true)
}

/// Encloses the share of a box in which `slopes·x` is at most `bound`, or less than it: that differs where the sum is the same
/// everywhere.
///
/// Proof. With `x_i = lo_i + w_i t_i`, or from the upper end where the slope is negative, the sum is `s + Σ a_i t_i` with
/// positive `a_i`, and for `n` of them the share of the unit box is `Σ ± (b - s - Σ_v a_i)_+^n / (n! Π a_i)` over all
/// corners `v` of the box, with the sign of the parity of their ones. It grows with the bound, so that what is between in
/// the bound is taken at its ends.
fn below(slopes: &[f64], box_: &[Interval], bound: f64, is_open: bool) -> Interval {
    if !bound.is_finite() {
        return if bound > 0.0 {
            Interval::ONE
        } else {
            Interval::ZERO
        };
    }
    let mut rest = Interval::point(bound);
    let mut lengths: Vec<Interval> = Vec::with_capacity(slopes.len());
    for (slope, x) in slopes.iter().zip(box_) {
        let from = if *slope < 0.0 { x.hi() } else { x.lo() };
        let width = Interval::point(x.hi()) - Interval::point(x.lo());
        rest -= Interval::point(*slope) * Interval::point(from);
        lengths.push(Interval::point(slope.abs()) * width);
    }
    let largest = lengths.iter().map(|a| a.hi()).fold(0.0, f64::max);
    let mut steep: Vec<Interval> = Vec::with_capacity(lengths.len());
    for length in lengths {
        if length.lo() > FLAT * largest && steep.len() < STEEP {
            steep.push(length);
        } else {
            rest -= Interval::ZERO.hull(length);
        }
    }
    let power = |x: Interval| steep.iter().fold(Interval::ONE, |power, _| power * x);
    let size = steep.iter().zip(1_u8..);
    let size = size.fold(Interval::ONE, |size, (a, k)| {
        size * *a * Interval::point(f64::from(k))
    });
    let share = |rest: f64| {
        if steep.is_empty() {
            return if rest > 0.0 || (rest == 0.0 && !is_open) {
                Interval::ONE
            } else {
                Interval::ZERO
            };
        }
        let mut sum = Interval::ZERO;
        for corner in 0..1_usize << steep.len() {
            let ones = steep
                .iter()
                .enumerate()
                .filter(|(i, _)| corner >> i & 1 == 1);
            let left = ones.fold(Interval::point(rest), |left, (_, a)| left - *a);
            let left =
                Interval::new(left.lo().max(0.0), left.hi().max(0.0)).unwrap_or(Interval::ENTIRE);
            if corner.count_ones() % 2 == 0 {
                sum += power(left);
            } else {
                sum -= power(left);
            }
        }
        (sum / size).intersect(any_share())
    };
    Interval::new(share(rest.lo()).lo(), share(rest.hi()).hi()).unwrap_or_else(any_share)
}

/// The coordinate that is widest in comparison.
fn widest(within: &[Interval], sizes: &[f64]) -> usize {
    let share = |at: &usize| within[*at].width() / sizes[*at].max(1e-300);
    let order = |a: &usize, b: &usize| share(a).total_cmp(&share(b));
    (0..within.len()).max_by(order).unwrap_or(0)
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

impl Turn {
    /// The axes of a cell that was turned, around what it leaves of the upright tile `clip`, with the coordinates of that.
    fn of(cell: &Cell, problem: &Problem, clip: &[Interval]) -> Option<(Turn, Vec<Interval>)> {
        let first = problem.first_param();
        let axes = &cell.region.axes[first..];
        let used = |row: &Vec<f64>| row.iter().filter(|slope| **slope != 0.0).count();
        // Each parameter that is not known has one axis more, or it is upright.
        let open = problem.prior.iter().filter(|x| !x.is_point()).count();
        if cell.region.axes() != open || axes.iter().all(|row| used(row) <= 1) {
            return None;
        }
        let mut turn = Turn {
            frame: Frame {
                centre: cell.region.centre[first..].to_vec(),
                axes: axes.to_vec(),
            },
            clip: clip.to_vec(),
            size: 0.0,
            whole: 0.0,
        };
        turn.size = turn
            .frame
            .volume(&vec![Interval::symmetric(0.5); open])
            .hi();
        let bounds = turn.bounds(cell, first).into_iter();
        let within: Vec<Interval> = bounds
            .map(|(bounds, _)| bounds.inflate(f64::MIN_POSITIVE))
            .collect();
        turn.whole = volume(&within);
        let is_sound = within.iter().all(|x| x.is_bounded() && !x.is_empty());
        (is_sound && turn.size.is_finite()).then_some((turn, within))
    }

    /// Bounds of the coordinates of what the cell leaves, with what excludes those below and above.
    ///
    /// Proof. `p = c + A y` and `p = c' + A' δ + r`, so `y = A^-1 A' δ + A^-1 (c' - c + r)`.
    fn bounds(&self, cell: &Cell, first: usize) -> Vec<(Interval, [Reason; 2])> {
        let open = open(&self.frame.axes);
        let matrix: Vec<&[f64]> = open
            .iter()
            .map(|p| self.frame.axes[*p].as_slice())
            .collect();
        let nothing = || [Reason::Budget, Reason::Budget];
        let Some(inverse) = inverse(&matrix) else {
            return matrix
                .iter()
                .map(|_| (Interval::ENTIRE, nothing()))
                .collect();
        };
        let of_row = |row: &Vec<Interval>| {
            let mut rest = Interval::ZERO;
            let mut slopes = vec![Interval::ZERO; cell.part.len()];
            for (share, p) in row.iter().zip(&open) {
                let far = cell.region.offset(first + p) - Interval::point(self.frame.centre[*p]);
                rest += *share * far;
                for (slope, own) in slopes.iter_mut().zip(&cell.region.axes[first + p]) {
                    *slope += *share * Interval::point(*own);
                }
            }
            let direction: Vec<f64> = slopes.iter().map(|slope| slope.mid()).collect();
            for ((slope, rounded), x) in slopes.iter().zip(&direction).zip(&cell.part) {
                rest += (*slope - Interval::point(*rounded)) * *x;
            }
            let (bounds, because) = cell.along(&direction);
            (bounds + rest, because)
        };
        inverse.iter().map(of_row).collect()
    }
}

/// The parameters that some axis changes.
fn open(axes: &[Vec<f64>]) -> Vec<usize> {
    let is_open = |p: &usize| axes[*p].iter().any(|slope| *slope != 0.0);
    (0..axes.len()).filter(is_open).collect()
}

impl Local {
    /// The rows of a cell in the coordinates `y` of tiles inside of it; nothing where these do not belong to unknowns.
    ///
    /// Proof. With `p = c + A y` and `p = c' + A' δ + r` for the parameters and the unknowns that they depend on alone,
    /// `δ = A'^-1 A (y - base) + A'^-1 (c + A base - c' - r)`. A row `g·δ` is one of `y` then; of unknowns of start states it
    /// must hold for some in the cell, and for inner rows it is enough that it does so for one.
    fn of(
        cell: &Cell,
        turn: Option<&Turn>,
        within: &[Interval],
        problem: &Problem,
    ) -> Option<Local> {
        let first = problem.first_param();
        let region = &cell.region;
        let rows = open(&region.axes[first..]);
        let is_used = |axis: &usize| rows.iter().any(|p| region.axes[first + p][*axis] != 0.0);
        let columns: Vec<usize> = (0..region.axes()).filter(is_used).collect();
        if rows.len() != columns.len() {
            return None;
        }
        let square: Vec<Vec<f64>> = rows
            .iter()
            .map(|p| {
                columns
                    .iter()
                    .map(|axis| region.axes[first + p][*axis])
                    .collect()
            })
            .collect();
        let inverse = inverse(&square.iter().map(Vec::as_slice).collect::<Vec<_>>())?;
        let base: Vec<f64> = within.iter().map(|x| x.mid()).collect();
        let points: Vec<Interval> = base.iter().map(|x| Interval::point(*x)).collect();
        let begin = turn.map_or_else(|| points.clone(), |turn| turn.frame.hull(&points));
        let slope = |p: usize, at: usize| match turn {
            None => f64::from(u8::from(p == at)),
            Some(turn) => turn.frame.axes[p][at],
        };
        let around: Vec<Interval> = within
            .iter()
            .zip(&points)
            .map(|(x, base)| *x - *base)
            .collect();
        // Each unknown as slopes of the coordinates, and the rest.
        let unknowns: Vec<(Vec<Interval>, Interval)> = inverse
            .iter()
            .map(|row| {
                let slopes = (0..base.len()).map(|at| {
                    let terms = row.iter().zip(&rows);
                    terms.fold(Interval::ZERO, |sum, (share, p)| {
                        sum + *share * Interval::point(slope(*p, at))
                    })
                });
                let terms = row.iter().zip(&rows);
                let rest = terms.fold(Interval::ZERO, |sum, (share, p)| {
                    sum + *share * (begin[*p] - region.offset(first + p))
                });
                (slopes.collect(), rest)
            })
            .collect();
        // A sum of these with rounded slopes.
        let rounded = |shares: &[f64]| {
            let mut rest = Interval::ZERO;
            let mut slopes = vec![Interval::ZERO; base.len()];
            for (share, (own, by)) in shares.iter().zip(&unknowns) {
                rest += Interval::point(*share) * *by;
                for (slope, own) in slopes.iter_mut().zip(own) {
                    *slope += Interval::point(*share) * *own;
                }
            }
            let middles: Vec<f64> = slopes.iter().map(|slope| slope.mid()).collect();
            for ((slope, middle), x) in slopes.iter().zip(&middles).zip(&around) {
                rest += (*slope - Interval::point(*middle)) * *x;
            }
            (middles, rest)
        };
        let starts = cell.deepest().0;
        let is_own = |axis: &usize| columns.contains(axis);
        let others: Vec<usize> = (0..region.axes()).filter(|axis| !is_own(axis)).collect();
        let mut told = Rows::new(base.len());
        let mut gaps = Vec::with_capacity(cell.rows.len());
        for row in 0..cell.rows.len() {
            let all = cell.rows.slopes(row);
            let own: Vec<f64> = columns.iter().map(|axis| all[*axis]).collect();
            let (slopes, rest) = rounded(&own);
            let (mut wide, mut narrow) = (rest, rest);
            for axis in &others {
                wide += Interval::point(all[*axis]) * cell.part[*axis];
                narrow += Interval::point(all[*axis]) * Interval::point(starts[*axis]);
            }
            let sides = (cell.rows.outer(row), cell.rows.inner(row));
            told.push_moved(&slopes, (wide, narrow), sides, cell.rows.origin(row));
            // Of one that may be an outlier nothing is known but what proves that it is none.
            gaps.push(match sides {
                (outer, _) if outer == Interval::ENTIRE => 0.0,
                (outer, inner) if inner.is_empty() => outer.width(),
                (outer, inner) => outer.width() - inner.width(),
            });
        }
        for (position, axis) in columns.iter().enumerate() {
            let mut unit = vec![0.0; columns.len()];
            unit[position] = 1.0;
            let (slopes, rest) = rounded(&unit);
            let sides = (cell.part[*axis], Interval::symmetric(1.0 - BORDER));
            told.push_moved(&slopes, (rest, rest), sides, (SEVERAL, 0));
        }
        let own = told.len();
        if let Some(turn) = turn {
            for p in open(&turn.frame.axes) {
                told.push(&turn.frame.axes[p], begin[p], turn.clip[p], BELIEVED, 0);
            }
        }
        let borders = told.len() - own;
        gaps.resize(told.len(), 0.0);
        let sizes = match turn {
            None => problem.prior.iter().map(|x| x.width()).collect(),
            Some(_) => vec![1.0; base.len()],
        };
        let is_inside = |axis: &usize| is_well_inside(Interval::point(starts[*axis]));
        Some(Local {
            rows: told,
            gaps,
            base,
            sizes,
            is_complete: cell.is_complete && others.iter().all(is_inside),
            borders,
        })
    }

    /// What it takes in memory, about.
    fn bytes(&self) -> usize {
        (8 * self.base.len() + 40) * self.rows.len() + 16 * self.base.len() + 100
    }

    /// The largest share of a tile, about, that what is not affine leaves undecided by one row.
    fn blurred(&self, within: &[Interval]) -> f64 {
        let at = within.iter().zip(&self.base);
        let at: Vec<Interval> = at.map(|(x, base)| *x - Interval::point(*base)).collect();
        let shares = (0..self.rows.len()).map(|row| {
            let sum = self.sum(row, &at);
            if sum.is_subset_of(self.rows.inner(row)) {
                0.0
            } else {
                (self.gaps[row] / sum.width().max(1e-300)).min(1.0)
            }
        });
        shares.fold(0.0, f64::max)
    }

    /// Encloses the share of a tile that agrees: no more than any outer row leaves, no less than what inner rows leave when
    /// each takes away its own.
    fn share(&self, within: &[Interval]) -> Interval {
        let at = within.iter().zip(&self.base);
        let at: Vec<Interval> = at.map(|(x, base)| *x - Interval::point(*base)).collect();
        let (mut most, mut least) = (1.0_f64, Interval::ONE);
        for row in 0..self.rows.len() {
            let sum = self.sum(row, &at);
            let (outer, inner) = (self.rows.outer(row), self.rows.inner(row));
            if sum.is_subset_of(inner) {
                continue;
            }
            let slopes = self.rows.slopes(row);
            let between = |bounds| between(slopes, &at, bounds);
            most = most.min(between(outer).hi());
            least -= Interval::ONE - between(inner);
        }
        let least = if self.is_complete {
            least.lo().max(0.0)
        } else {
            0.0
        };
        Interval::new(least.min(most), most).unwrap_or_else(any_share)
    }

    /// Whether a tile has nothing of the upright tile that all are parts of.
    fn is_beyond(&self, at: &[Interval]) -> bool {
        let rows = self.rows.len();
        let mut borders = rows - self.borders..rows;
        borders.any(|row| !self.sum(row, at).intersects(self.rows.outer(row)))
    }

    fn sum(&self, row: usize, at: &[Interval]) -> Interval {
        let terms = self.rows.slopes(row).iter().zip(at);
        terms.fold(Interval::ZERO, |sum, (g, x)| sum + Interval::point(*g) * *x)
    }

    /// What the rows say of a tile inside of that which they were made for: those that cannot be met exclude it, those that
    /// are met by all its points prove that it is inside.
    fn says(&self, within: &[Interval]) -> Said {
        let at = within.iter().zip(&self.base);
        let at: Vec<Interval> = at.map(|(x, base)| *x - Interval::point(*base)).collect();
        let mut is_inside = self.is_complete;
        let mut worst = None;
        let mut missing = 0.0;
        for row in 0..self.rows.len() {
            let sum = self.sum(row, &at);
            let outer = self.rows.outer(row);
            if !sum.intersects(outer) {
                let (sample, record) = self.rows.origin(row);
                return if sample == BELIEVED && self.is_beyond(&at) {
                    Said::Beyond
                } else {
                    Said::Outside(reason_of(record, &[(sample, record)]))
                };
            }
            let inner = self.rows.inner(row);
            if sum.is_subset_of(inner) {
                continue;
            }
            is_inside = false;
            let reach = sum.width().max(1e-300);
            let below = (inner.lo() - sum.lo()).max(sum.hi() - inner.hi());
            let below = if below.is_finite() { below } else { reach };
            if below > missing || worst.is_none() {
                missing = below.max(0.0);
                // How much of what is missing no halving brings.
                worst = Some((row, self.gaps[row] / reach));
            }
        }
        if is_inside {
            return Said::Inside;
        }
        let Some((row, gap)) = worst else {
            return Said::Hidden(widest(within, &self.sizes));
        };
        let slopes = self.rows.slopes(row);
        let reach = |axis: usize| (slopes[axis] * at[axis].width()).abs();
        let axis = (0..within.len())
            .max_by(|a, b| reach(*a).total_cmp(&reach(*b)))
            .filter(|axis| reach(*axis) > 0.0)
            .unwrap_or_else(|| widest(within, &self.sizes));
        if gap > HIDDEN || !self.is_complete {
            Said::Hidden(axis)
        } else {
            Said::Halve(axis)
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    fn interval(lo: f64, hi: f64) -> Interval {
        Interval::new(lo, hi).unwrap()
    }

    /// What is the same everywhere and just agrees does so everywhere.
    #[test]
    fn a_sum_on_the_end_of_its_bounds_is_between_them() {
        let box_ = [interval(-1.0, 1.0), interval(2.0, 2.0)];
        for (slopes, at) in [([0.0, 0.0], 0.0), ([0.0, 3.0], 6.0)] {
            for (from, to, share) in [
                (0.0, 2.0, Interval::ONE),
                (-2.0, 0.0, Interval::ONE),
                (0.0, 0.0, Interval::ONE),
                (1.0, 2.0, Interval::ZERO),
                (-2.0, -1.0, Interval::ZERO),
            ] {
                let told = between(&slopes, &box_, interval(at + from, at + to));
                assert!(share.is_subset_of(told), "{slopes:?} {from} {to}: {told}");
            }
        }
    }

    /// Shares of boxes between two planes, against points on a grid.
    #[test]
    fn shares_are_enclosed() {
        let mut seed = 9_u64;
        let mut draw = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        const STEPS: usize = 24;
        let mut widest: f64 = 0.0;
        for round in 0..200 {
            let scale = [1.0, 1.0, if round % 3 == 0 { 1e-5 } else { 1.0 }];
            let slopes = scale.map(|scale| scale * draw());
            let box_ = scale.map(|_| interval(-2.0, -2.0) + interval(0.0, 1.1 + draw()));
            let sum = slopes.iter().zip(&box_);
            let sum = sum.fold(Interval::ZERO, |sum, (g, x)| sum + Interval::point(*g) * *x);
            let (a, b) = (draw(), draw());
            let at = |share: f64| sum.mid() + 0.6 * share * sum.width();
            let bounds = interval(at(a.min(b)), at(a.max(b)));
            let told = between(&slopes, &box_, bounds);
            let mut inside = 0;
            for cell in 0..STEPS.pow(3) {
                let index = [cell % STEPS, cell / STEPS % STEPS, cell / STEPS / STEPS];
                let terms = index.iter().zip(&box_).zip(&slopes).map(|((i, x), g)| {
                    let share = (*i as f64 + 0.5) / STEPS as f64;
                    g * (x.lo() + share * x.width())
                });
                inside += usize::from(bounds.contains(terms.sum()));
            }
            let about = inside as f64 / STEPS.pow(3) as f64;
            let near = told.inflate(0.07);
            assert!(near.contains(about), "{slopes:?} {bounds}: {told} {about}");
            widest = widest.max(told.width());
        }
        assert!(widest < 0.01, "{widest}");
    }
}
