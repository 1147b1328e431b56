//! Boxes of the list, eight side by side.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: a batch is used with the list it was made for, whose positions it holds; \
              lanes are counted below LANES"
)]

use crate::cell::Cell;
use veribound_interval::Interval;
use veribound_interval::lanes::{Interval8, LANES, Mask};

/// Up to eight boxes.
#[derive(Debug, Clone, Default)]
pub(crate) struct Batch {
    /// States, then parameters.
    pub(crate) boxes: Vec<Interval8>,
    /// The lanes that hold a box.
    pub(crate) lanes: Mask,
    position: [usize; LANES],
}

impl Batch {
    /// Each lane with the position of its box in the list.
    pub(crate) fn positions(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.lanes.lanes().map(|lane| (lane, self.position[lane]))
    }

    /// One interval of every box, by the position of the box in the list.
    pub(crate) fn gather(&self, of: impl Fn(usize) -> Interval) -> Interval8 {
        Interval8::from_fn(|lane| of(self.position[lane]))
    }

    /// Takes the boxes over from the list; lanes without one repeat the first.
    pub(crate) fn load(&mut self, cells: &[Cell]) {
        let dimension = cells.first().map_or(0, |cell| cell.z.len());
        self.boxes.resize(dimension, Interval8::ZERO);
        for (coordinate, x) in self.boxes.iter_mut().enumerate() {
            let position = &self.position;
            *x = Interval8::from_fn(|lane| cells[position[lane]].z[coordinate]);
        }
    }

    /// Puts the boxes back into the list.
    pub(crate) fn store(&self, cells: &mut [Cell]) {
        for (lane, position) in self.positions() {
            for (x, from) in cells[position].z.iter_mut().zip(&self.boxes) {
                *x = from.get(lane);
            }
        }
    }
}

/// How a list is divided into batches; keeps its memory.
#[derive(Debug, Clone, Default)]
pub(crate) struct Batches {
    order: Vec<usize>,
    batches: Vec<Batch>,
}

impl Batches {
    /// Boxes that are near in the list side by side.
    pub(crate) fn of_neighbours(&mut self, cells: &[Cell]) -> &mut [Batch] {
        self.order.clear();
        self.order.extend(0..cells.len());
        self.divide()
    }

    /// Boxes with the same modes side by side: they take the same way through a step.
    pub(crate) fn of_alike(&mut self, cells: &[Cell]) -> &mut [Batch] {
        self.order.clear();
        self.order.extend(0..cells.len());
        self.order.sort_by_key(|position| cells[*position].modes);
        self.divide()
    }

    fn divide(&mut self) -> &mut [Batch] {
        let count = self.order.len().div_ceil(LANES);
        self.batches.resize_with(count, Batch::default);
        for (batch, positions) in self.batches.iter_mut().zip(self.order.chunks(LANES)) {
            batch.lanes = Mask::first(positions.len());
            batch.position =
                std::array::from_fn(|lane| *positions.get(lane).unwrap_or(&positions[0]));
        }
        &mut self.batches
    }
}
