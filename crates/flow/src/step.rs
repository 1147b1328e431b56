//! One step of validated integration for a box of states and parameters.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: a workspace's slices have the lengths of its system's layout"
)]

use crate::apriori::{Apriori, AprioriFailure};
use crate::face::{Faces, Step};
use crate::modes::ModeSet;
use crate::system::{Registers, System};
use veribound_interval::Interval;

/// A gap between two samples is divided into at most this many steps, before halvings, so that the
/// time per sample stays bounded.
const MOST_PARTS: f64 = 1024.0;

/// Settings of the box method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepOptions {
    /// Order of the Taylor series where one smooth right-hand side is certain; 1 to 12.
    pub order: usize,
    /// A step that finds no a-priori box is halved at most this many times.
    pub halvings: u32,
    /// Longest single step in seconds; longer gaps between samples are divided, into at most 1024
    /// parts.
    pub longest: f64,
}

impl Default for StepOptions {
    fn default() -> Self {
        StepOptions {
            order: 2,
            halvings: 8,
            longest: 0.05,
        }
    }
}

/// Why a step could not be proved. It says nothing about the existence of solutions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StepFailure {
    /// No a-priori box was found, even on the shortest step allowed.
    Apriori(AprioriFailure),
    /// The box grew beyond what floating-point numbers hold.
    Unbounded,
    /// This state may leave the domain in which the guards of the modes are proved to leave no gap.
    LeavesDomain {
        /// Index of the state.
        state: usize,
    },
    /// This input lies outside the domain in which the guards are proved to leave no gap.
    InputOutsideDomain {
        /// Index of the input.
        input: usize,
    },
}

/// What is proved about one step besides the box at its end and the tube.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StepReport {
    /// Modes whose guard, as written, holds somewhere on the tube: no other was active during the
    /// step.
    pub modes_during: ModeSet,
}

/// Scratch for one thread.
#[derive(Debug, Clone)]
pub struct Workspace {
    options: StepOptions,
    q: Vec<Interval>,
    apriori: Apriori,
    clipped: Vec<Interval>,
    registers: Registers,
    faces: Faces,
    end: Vec<Interval>,
    part_tube: Vec<Interval>,
    tube: Vec<Interval>,
    velocity: Vec<Interval>,
}

impl Workspace {
    /// Scratch for steps of `system`.
    pub fn new(system: &System, options: StepOptions) -> Workspace {
        let options = StepOptions {
            order: options.order.clamp(1, 12),
            ..options
        };
        Workspace {
            options,
            q: vec![Interval::ZERO; system.layout.len()],
            apriori: Apriori::default(),
            clipped: Vec::new(),
            registers: system.registers(options.order + 1),
            faces: Faces::new(system, options.order),
            end: vec![Interval::ZERO; system.layout.states],
            part_tube: vec![Interval::ZERO; system.layout.states],
            tube: vec![Interval::ZERO; system.layout.states],
            velocity: vec![Interval::ZERO; system.layout.states],
        }
    }

    /// After [`System::step`]: encloses the states at every time of the step.
    pub fn tube(&self) -> &[Interval] {
        &self.tube
    }

    /// After [`System::step`]: encloses the velocity of every state at almost every time of the
    /// step.
    pub fn velocity(&self) -> &[Interval] {
        &self.velocity
    }
}

impl System {
    /// Moves a box of states over `dt` seconds.
    ///
    /// Guarantee: for every start state in `states`, every constant parameter in `params`, every
    /// measurable input with values in `inputs` and every length in `dt`, every Filippov solution
    /// of the model lies in the new `states` at the end and in [`Workspace::tube`] at all times
    /// between. On failure `states` is unchanged.
    ///
    /// Cost: one a-priori box and two bounds per state; no allocation.
    pub fn step(
        &self,
        states: &mut [Interval],
        params: &[Interval],
        inputs: &[Interval],
        dt: Interval,
        workspace: &mut Workspace,
    ) -> Result<StepReport, StepFailure> {
        let n = self.layout.states;
        let w = workspace;
        w.q[..n].copy_from_slice(states);
        w.q[n..n + self.layout.params].copy_from_slice(params);
        w.q[n + self.layout.params..].copy_from_slice(inputs);
        w.tube.copy_from_slice(states);
        w.velocity.fill(Interval::EMPTY);
        let least_parts = (dt.hi() / w.options.longest).ceil().clamp(1.0, MOST_PARTS) as u64;
        let mut parts = least_parts;
        let mut done = 0_u64;
        let mut halvings = 0;
        // Parts of equal length: `done` of `parts` are behind. Halving doubles both.
        while done < parts {
            let part = if parts == 1 {
                dt
            } else {
                dt / Interval::point(parts as f64)
            };
            match self.single_step(part, w) {
                Ok(()) => {
                    done += 1;
                    for (all, now) in w.tube.iter_mut().zip(&w.part_tube) {
                        *all = all.hull(*now);
                    }
                    for (all, now) in w.velocity.iter_mut().zip(&w.apriori.velocity) {
                        *all = all.hull(*now);
                    }
                }
                Err(StepFailure::Apriori(_)) if halvings < w.options.halvings => {
                    halvings += 1;
                    parts *= 2;
                    done *= 2;
                }
                Err(failure) => return Err(failure),
            }
        }
        states.copy_from_slice(&w.q[..n]);
        w.q[..n].copy_from_slice(&w.tube);
        Ok(StepReport {
            modes_during: self.modes_on(&w.q, &mut w.registers),
        })
    }

    /// One step without division; on success the states in `w.q` are moved.
    fn single_step(&self, dt: Interval, w: &mut Workspace) -> Result<(), StepFailure> {
        let n = self.layout.states;
        self.apriori(
            &mut w.q,
            dt,
            &mut w.apriori,
            &mut w.clipped,
            &mut w.registers,
        )
        .map_err(StepFailure::Apriori)?;
        let step = Step {
            q: &w.q,
            dt,
            apriori: &w.apriori,
        };
        self.move_faces(
            &step,
            &mut w.faces,
            &mut w.registers,
            &mut w.end,
            &mut w.part_tube,
        );
        if w.end.iter().any(|x| x.is_empty() || !x.is_bounded()) {
            return Err(StepFailure::Unbounded);
        }
        if let Some(domain) = &self.domain {
            let outside = |x: &[Interval], allowed: &[Interval]| {
                x.iter()
                    .zip(allowed)
                    .position(|(x, allowed)| !x.is_subset_of(*allowed))
            };
            if let Some(state) = outside(&w.part_tube, &domain.states) {
                return Err(StepFailure::LeavesDomain { state });
            }
            if let Some(input) = outside(&w.q[n + self.layout.params..], &domain.inputs) {
                return Err(StepFailure::InputOutsideDomain { input });
            }
        }
        w.q[..n].copy_from_slice(&w.end);
        Ok(())
    }

    /// The modes whose guard, as written, holds somewhere on a box (talk, 1.3).
    pub fn active_modes(
        &self,
        states: &[Interval],
        params: &[Interval],
        inputs: &[Interval],
        workspace: &mut Workspace,
    ) -> ModeSet {
        let n = self.layout.states;
        workspace.q[..n].copy_from_slice(states);
        workspace.q[n..n + self.layout.params].copy_from_slice(params);
        workspace.q[n + self.layout.params..].copy_from_slice(inputs);
        self.modes_on(&workspace.q, &mut workspace.registers)
    }
}
