//! What the recent past says about a rate: difference quotients of its integral.
//!
//! Where `x' = v` in every mode, a box can remember where `x` was some samples ago. With the
//! accelerations `a = v'` enclosed in every step,
//!
//! > `x(t) - x(t0) = ∫ v ds = T v(t) - J`,  `T = t - t0`,  `J = ∫ (s - t0) a(s) ds`,
//!
//! so `v(t) = (x(t) - x(t0) + J) / T`. `J` grows in a step of length `h` by something in
//! `[a] (T h + h²/2)`, since the weight `s - t0` is not negative. A measured position thus bounds a
//! velocity that nothing measures; without it, a box keeps every velocity it was once given.
//! Source: own.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: every box has one memory per pair and window, made by `Windows::fresh`"
)]

use crate::batch::Batch;
use crate::cell::Cell;
use crate::verdict::Contradiction;
use veribound_flow::{Integral, System};
use veribound_interval::Interval;
use veribound_interval::lanes::{Interval8, LANES};

/// What one box remembers for one pair of states and one window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Memory {
    /// Where the integral was when the window began.
    start: Interval,
    /// `∫ (s - t0) a(s) ds` since then.
    moment: Interval,
}

impl Memory {
    pub(crate) fn hull(self, other: Memory) -> Memory {
        Memory {
            start: self.start.hull(other.start),
            moment: self.moment.hull(other.moment),
        }
    }
}

/// One stretch of the past, the same for all boxes.
#[derive(Debug, Clone)]
struct Window {
    /// Samples after which it begins anew.
    length: u64,
    age: u64,
    /// Time since it began.
    elapsed: Interval,
}

/// The stretches of the past that boxes remember.
#[derive(Debug, Clone)]
pub(crate) struct Windows {
    pairs: Vec<Integral>,
    windows: Vec<Window>,
}

impl Windows {
    pub(crate) fn new(system: &System, lengths: &[u64]) -> Windows {
        let window = |length: &u64| Window {
            length: *length,
            age: 0,
            elapsed: Interval::ZERO,
        };
        Windows {
            pairs: system.integrals().to_vec(),
            windows: lengths
                .iter()
                .filter(|length| **length > 0)
                .map(window)
                .collect(),
        }
    }

    /// Begins all windows anew on every box.
    pub(crate) fn restart(&mut self, cells: &mut [Cell]) {
        for window in &mut self.windows {
            window.age = 0;
            window.elapsed = Interval::ZERO;
        }
        for cell in cells {
            cell.memories.clear();
            for pair in &self.pairs {
                let memory = Memory {
                    start: cell.z[pair.state],
                    moment: Interval::ZERO,
                };
                cell.memories.extend(self.windows.iter().map(|_| memory));
            }
        }
    }

    /// Takes note of a step of length `dt` of the boxes in `batch`, with the accelerations in
    /// `velocities`.
    pub(crate) fn extend(
        &self,
        cells: &mut [Cell],
        batch: &Batch,
        velocities: &[Interval8],
        dt: Interval,
    ) {
        let half = Interval::point(0.5) * dt.sqr();
        let mut place = 0;
        for pair in &self.pairs {
            for window in &self.windows {
                let weight = Interval8::splat(window.elapsed * dt + half);
                let more = velocities[pair.rate] * weight;
                let known = batch.gather(|position| cells[position].memories[place].moment);
                let moment = known + more;
                for (lane, position) in batch.positions() {
                    cells[position].memories[place].moment = moment.get(lane);
                }
                place += 1;
            }
        }
    }

    /// Forgets what a box knows of rates that jumped: they are no integrals of their derivatives.
    pub(crate) fn forget(&self, cell: &mut Cell, jumped: &[usize]) {
        let pairs = self.pairs.iter();
        let each = pairs.flat_map(|pair| self.windows.iter().map(|_| jumped.contains(&pair.rate)));
        for (memory, jumped) in cell.memories.iter_mut().zip(each) {
            if jumped {
                memory.moment = Interval::ENTIRE;
            }
        }
    }

    /// Moves the clock of all windows, once all boxes took note of the step.
    pub(crate) fn advance(&mut self, dt: Interval) {
        for window in &mut self.windows {
            window.age += 1;
            window.elapsed += dt;
        }
    }

    /// Narrows the rates of the boxes in `batch` to the difference quotients of their integrals.
    ///
    /// Guarantee: every point of a box that a trajectory through the remembered past can have
    /// reached is kept. Boxes without one get their contradiction.
    pub(crate) fn narrow(
        &self,
        cells: &[Cell],
        batch: &mut Batch,
        found: &mut [Option<Contradiction>; LANES],
    ) {
        let mut place = 0;
        for pair in &self.pairs {
            for window in &self.windows {
                place += 1;
                if window.age == 0 {
                    continue;
                }
                let start = batch.gather(|position| cells[position].memories[place - 1].start);
                let moment = batch.gather(|position| cells[position].memories[place - 1].moment);
                let change = batch.boxes[pair.state] - start;
                let needed = (change + moment) / Interval8::splat(window.elapsed);
                let enclosure = batch.boxes[pair.rate];
                let narrowed = enclosure.intersect(&needed);
                for lane in (batch.lanes & narrowed.is_empty()).lanes() {
                    found[lane].get_or_insert_with(|| Contradiction::Motion {
                        pair: *pair,
                        enclosure: enclosure.get(lane),
                        needed: needed.get(lane),
                    });
                }
                batch.boxes[pair.rate] = narrowed;
            }
        }
    }

    /// Begins those windows anew whose time is over.
    pub(crate) fn renew(&mut self, cells: &mut [Cell]) {
        let count = self.windows.len();
        for (position, window) in self.windows.iter_mut().enumerate() {
            if window.age < window.length {
                continue;
            }
            window.age = 0;
            window.elapsed = Interval::ZERO;
            for cell in &mut *cells {
                for (index, pair) in self.pairs.iter().enumerate() {
                    cell.memories[index * count + position] = Memory {
                        start: cell.z[pair.state],
                        moment: Interval::ZERO,
                    };
                }
            }
        }
    }
}
