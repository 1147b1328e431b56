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

mod local;
mod shares;
mod state;
mod turn;

use super::answer::{Progress, Reason, Status, Tile, Turned};
use super::cell::{BELIEVED, Cell, Clash, Known};
use super::frame::Frame;
use super::pass::{Conflict, GoOn};
use super::problem::Problem;
use super::region::Region;
use super::rows::SEVERAL;
use local::{Local, Said};
use rayon::prelude::*;
use shares::any_share;
use state::Open;
pub(crate) use state::State;
use turn::Turn;
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
    /// Goes on with what was begun, or with the prior, of which what lies outside of `outer` is closed and the rest is one open tile. These
    /// must be bounds of all parameters that agree.
    pub(crate) fn new(
        problem: &'a Problem,
        begun: Option<State>,
        share: f64,
        outer: &[Interval],
    ) -> Paving<'a> {
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
            paving.begin(outer);
        }
        paving
    }

    fn begin(&mut self, outer: &[Interval]) {
        let outside = (Status::Outside, Reason::Bounds);
        let mut rest = self.problem.prior.clone();
        if outer.iter().any(|x| x.is_empty()) {
            return self.close(rest, None, outside);
        }
        for (param, outer) in outer.iter().enumerate() {
            // Their ends may agree.
            let (lo, hi) = (outer.lo().next_down(), outer.hi().next_up());
            let x = rest[param];
            for beyond in [Interval::new(x.lo(), lo), Interval::new(hi, x.hi())] {
                if let Some(beyond) = beyond.filter(|own| own.width() > 0.0) {
                    let mut tile = rest.clone();
                    tile[param] = beyond;
                    self.close(tile, None, outside.clone());
                }
            }
            rest[param] = Interval::new(x.lo().max(lo), x.hi().min(hi)).unwrap_or(x);
        }
        self.push(rest, None, (None, 0), any_share());
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
        go_on: &(dyn Fn(&Progress) -> bool + Sync),
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
    fn look_at(&self, open: &Open, go_on: &GoOn<'_>) -> Result<(Cell, Option<Cell>), Clash> {
        let refined = |region| {
            let known = Known::default();
            self.problem.refine(region, known, false, go_on)
        };
        let cell = refined(self.region(open))?;
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
            let Some(region) = region.filter(|_| go_on()) else {
                break;
            };
            let spent = cell.passes + passes;
            let next = refined(region).map_err(|clash| Clash {
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
        go_on: &(dyn Fn(&Progress) -> bool + Sync),
    ) -> bool {
        if self.state.sets + waiting.len() > sets {
            self.state.is_spent = true;
            return true;
        }
        let paving = &*self;
        let standing = self.progress();
        let cells: Vec<_> = waiting
            .par_iter()
            .map(|open| paving.look_at(open, &|| go_on(&standing)))
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
        go_on(&self.progress())
    }

    fn progress(&self) -> Progress {
        Progress {
            sets: self.state.sets,
            waiting: self.state.open.len(),
            left: self.state.undecided / volume(&self.problem.prior),
            tightness: f64::NAN,
        }
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

fn reason(record: usize, conflict: &Conflict) -> Reason {
    match conflict {
        Conflict::Value { sample } => Reason::Sample {
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
