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
//! * **Rest.** A solution that no flow takes away from a point, and that a jump leaves where it is, rests:
//!   what the jump sets stays, the other states go on. The point is in `C` and in the jump's region, so
//!   while it is in `A` it is in the image of a jump too. Where it moves out through a face of `A`, the
//!   rate of that face, taken over `C`, moves the face out in the tube as well, and with it the image; so
//!   no sweep ends, and no image is passed over, before `A` contains all that the other states can drift.
//!
//! A solution that has not jumped and one that has are different boxes, so that neither loses what is
//! known of it. After some jumps in one stretch a sweep covers the rest of it, which ends the chain of
//! ever shorter flights of a ball that comes to rest.

mod at_once;
mod solve;
mod timing;

pub use at_once::AtOnce;
pub use solve::reduced;

use crate::system::Integral;
use timing::{Atom, Timing};
use veribound_interval::lanes::Interval8;
use veribound_model::{ExprId, Graph, Guard, Layout, Model, Tape, Var};

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
    /// Quantities, by their position in the layout, in its condition or in new values.
    reads: Vec<usize>,
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
            let mut read: Vec<Var> = values.iter().flat_map(|e| graph.variables(*e)).collect();
            compared(&jump.guard, graph, &mut read);
            Jump {
                timing: Timing::compile(&jump.guard, graph, layout, &mut atoms),
                reads: read.into_iter().map(|var| layout.index(var)).collect(),
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

/// The quantities in a condition.
fn compared(guard: &Guard, graph: &Graph, found: &mut Vec<Var>) {
    match guard {
        Guard::Always => {}
        Guard::Atom { expr, .. } => found.extend(graph.variables(*expr)),
        Guard::All(parts) | Guard::Any(parts) => {
            for part in parts {
                compared(part, graph, found);
            }
        }
    }
}
