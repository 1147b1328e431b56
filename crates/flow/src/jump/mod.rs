//! Jumps of the state.
//!
//! # What is proved
//!
//! A solution flows in the closed set `C` where no jump's condition holds, and jumps at points of the
//! closed regions `D_j` of the conditions. A stretch of time is enclosed in two ways.
//!
//! * **Sweep.** Let `A` contain the start and all images of jumps from the tube of flows that start in
//!   `A` and last at most as long as the stretch. Every piece of a solution between two jumps starts in
//!   `A`, so that tube contains the solution at all times, after any number of jumps; being closed, it
//!   also contains the limit of infinitely many.
//! * **First jump.** Along a flow a comparison `g < 0` in a condition changes with a rate that is
//!   bounded on the flow's tube. So there is a time before which it cannot hold, and one after which it
//!   holds strictly; strictly inside `D_j` nothing flows, so by then every solution has jumped.
//!   On the tube between the two times the rate is bounded more tightly, and so on. Then the images
//!   of the jump go on from the second time, and their sweep over the time between covers that jumps
//!   happen at different times.
//!
//! A solution that has not jumped and one that has are different boxes, so that neither loses what is
//! known of it. After some jumps in one stretch a sweep covers the rest of it, which ends the chain of
//! ever shorter flights of a ball that comes to rest.

mod solve;
mod timing;

pub use solve::reduced;

use crate::system::Integral;
use timing::{Atom, Timing};
use veribound_interval::lanes::Interval8;
use veribound_model::{ExprId, Graph, Layout, Model, Tape};

/// All jumps of a model.
#[derive(Debug, Clone, Default)]
pub(crate) struct Jumps {
    list: Vec<Jump>,
    atoms: Vec<Atom>,
    /// States that are integrals of others that jump: between two jumps the relation holds.
    integrals: Vec<Integral>,
}

#[derive(Debug, Clone)]
struct Jump {
    timing: Timing,
    /// Positions of the states it changes.
    states: Vec<usize>,
    /// Their new values.
    values: Tape,
}

/// Scratch for [`Jumps`].
#[derive(Debug, Clone)]
pub(crate) struct JumpRegisters {
    values: Vec<Vec<Interval8>>,
    /// Per comparison its value and its slopes.
    atoms: Vec<[Vec<Interval8>; 2]>,
}

impl Jumps {
    pub(crate) fn compile(
        graph: &mut Graph,
        layout: Layout,
        model: &Model,
        integrals: &[Integral],
    ) -> Jumps {
        let mut atoms = Vec::new();
        let jumps = model.jumps.iter().map(|jump| {
            let (states, values): (Vec<usize>, Vec<ExprId>) = jump.set.iter().copied().unzip();
            Jump {
                timing: Timing::compile(&jump.guard, graph, layout, &mut atoms),
                states,
                values: Tape::compile(graph, layout, &values),
            }
        });
        let list = jumps.collect();
        let integrals = integrals
            .iter()
            .filter(|pair| !model.jumps_in(pair.state) && model.jumps_in(pair.rate));
        Jumps {
            list,
            atoms,
            integrals: integrals.copied().collect(),
        }
    }

    /// True when nothing jumps.
    pub(crate) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    pub(crate) fn registers(&self) -> JumpRegisters {
        let jumps = self.list.iter();
        let atoms = self.atoms.iter();
        JumpRegisters {
            values: jumps.map(|jump| jump.values.registers()).collect(),
            atoms: atoms.map(Atom::registers).collect(),
        }
    }
}
