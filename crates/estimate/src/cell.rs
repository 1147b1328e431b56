//! One box of the observer's list.

use crate::engine::Kept;
use crate::history::Memory;
use veribound_flow::ModeSet;
use veribound_interval::Interval;

/// A box of states and parameters.
///
/// ```
/// use veribound_estimate::{Observer, ObserverOptions};
/// # use veribound_interval::{Decimal, Interval};
/// # use veribound_model::{Model, Sample};
/// # let text = "format = 1\nstates = [\"x\"]\ninit.x = 1\nparams.k = [0, 2]\nder.x = \"-k*x\"\noutputs.y = \"x +- 0.01\"";
/// # let model = Model::from_text("decay.toml", text)?;
/// # let sample = |time: &str, y: f64| Sample {
/// #     time: Decimal::parse(time).unwrap(),
/// #     inputs: vec![],
/// #     outputs: vec![Some(model.outputs[0].error.enclose(Interval::point(y)))],
/// #     signals: vec![],
/// #     line: 1,
/// # };
/// let observer = Observer::new(&model, ObserverOptions::default());
/// let [cell] = observer.cells() else { panic!("one box before the first sample") };
/// assert_eq!(cell.z, [model.states[0].init, model.params[0].bounds]);
/// assert!(cell.is_subset_of(cell));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// States first, then parameters.
    pub z: Vec<Interval>,
    /// Modes whose guard holds somewhere on the box, with the input of the coming step.
    pub modes: ModeSet,
    /// Modes possible at some time since the sample before.
    pub(crate) modes_during: ModeSet,
    /// Where its trajectories come from, per pair of states and window.
    pub(crate) memories: Vec<Memory>,
    /// How its trajectories depend on where they come from, where an engine keeps that.
    pub(crate) kept: Kept,
}

impl Cell {
    /// A box without a past.
    pub(crate) fn new(z: Vec<Interval>) -> Cell {
        Cell {
            z,
            modes: ModeSet::EMPTY,
            modes_during: ModeSet::EMPTY,
            memories: Vec::new(),
            kept: Kept::default(),
        }
    }

    /// Becomes a copy of `other`, in its own memory.
    pub(crate) fn copy_from(&mut self, other: &Cell) {
        self.z.clone_from(&other.z);
        self.modes = other.modes;
        self.modes_during = other.modes_during;
        self.memories.clone_from(&other.memories);
        self.kept.clone_from(&other.kept);
    }

    /// Takes over the past of a box that lies inside this one, so that `other` can be dropped.
    pub(crate) fn absorb(&mut self, other: &Cell) {
        self.modes_during = self.modes_during.union(other.modes_during);
        // Trajectories of the other box need not be in it.
        self.kept = Kept::default();
        for (memory, more) in self.memories.iter_mut().zip(&other.memories) {
            *memory = memory.hull(*more);
        }
    }

    /// True when every point of this box is one of `other` too.
    pub fn is_subset_of(&self, other: &Cell) -> bool {
        self.z.iter().zip(&other.z).all(|(a, b)| a.is_subset_of(*b))
    }

    /// Grows this box to contain `other`.
    pub fn join(&mut self, other: &Cell) {
        for (a, b) in self.z.iter_mut().zip(&other.z) {
            *a = a.hull(*b);
        }
        self.modes = self.modes.union(other.modes);
        self.absorb(other);
    }
}

/// Cuts `x` at `point`: the two parts share the point, so nothing is lost. `None` when the point
/// is not strictly inside.
pub(crate) fn cut(x: Interval, point: f64) -> Option<(Interval, Interval)> {
    if !(x.lo() < point && point < x.hi()) {
        return None;
    }
    Some((Interval::new(x.lo(), point)?, Interval::new(point, x.hi())?))
}

/// Removes boxes that lie inside another one.
pub(crate) fn remove_contained(cells: &mut Vec<Cell>) {
    let mut kept: Vec<Cell> = Vec::with_capacity(cells.len());
    for cell in cells.drain(..) {
        insert(&mut kept, cell);
    }
    *cells = kept;
}

/// Adds a box to a list in which no box lies inside another one.
pub(crate) fn insert(kept: &mut Vec<Cell>, mut cell: Cell) {
    if let Some(other) = kept.iter_mut().find(|other| cell.is_subset_of(other)) {
        other.absorb(&cell);
        return;
    }
    kept.retain(|other| {
        let inside = other.is_subset_of(&cell);
        if inside {
            cell.absorb(other);
        }
        !inside
    });
    kept.push(cell);
}
