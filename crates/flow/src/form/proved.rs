//! What is proved on the way, stretch by stretch: states, outputs, and the modes that may act.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one entry per output; a tape has one result per output that is no state"
)]

use super::flow::Flow;
use super::output::Output;
use super::run::Stretch;
use super::set::Form;
use crate::modes::ModeSet;
use veribound_interval::Interval;
use veribound_model::{ExprId, Graph, Model, Node, Tape, Var};

/// The outputs of a model, compiled.
#[derive(Debug)]
pub(super) struct Outputs {
    list: Vec<Kind>,
    /// Those that are no states.
    tape: Tape,
}

#[derive(Debug)]
enum Kind {
    State(usize),
    Other(Output),
}

impl Outputs {
    pub(super) fn compile(graph: &mut Graph, model: &Model) -> Outputs {
        let mut others: Vec<ExprId> = Vec::new();
        let outputs = model.outputs.iter().map(|output| {
            if let Node::Var(Var::State(state)) = *graph.node(output.expr) {
                return Kind::State(state);
            }
            others.push(output.expr);
            Kind::Other(Output::compile(graph, model.states.len(), output.expr))
        });
        let list = outputs.collect();
        let tape = Tape::compile(graph, model.layout(), &others);
        Outputs { list, tape }
    }

    /// Encloses the outputs wherever they are defined on a box of states, parameters and inputs.
    pub(super) fn on_box(&self, quantities: &[Interval]) -> Vec<Interval> {
        let mut registers = self.tape.registers();
        if !self.tape.is_empty() {
            // Where an output is not defined nothing is claimed of it.
            let _ = self.tape.eval(quantities, &mut registers);
        }
        let mut next = 0;
        let mut other = || {
            next += 1;
            self.tape.output::<Interval>(next - 1, &registers)
        };
        let kinds = self.list.iter();
        kinds
            .map(|kind| match kind {
                Kind::State(state) => quantities[*state],
                Kind::Other(_) => other(),
            })
            .collect()
    }

    /// As [`Outputs::on_box`], for the states of a form that lie in the box, too.
    pub(super) fn on_form(
        &self,
        form: &Form,
        quantities: &[Interval],
        inputs: &[Interval],
    ) -> Vec<Interval> {
        let mut values = self.on_box(quantities);
        for (value, kind) in values.iter_mut().zip(&self.list) {
            if let Kind::Other(output) = kind
                && let Ok(tighter) = form.output(output, inputs)
            {
                *value = value.intersect(tighter.hull);
            }
        }
        values
    }
}

/// What is proved of the stretches gone through, and of the one at hand.
#[derive(Debug, Clone, Default)]
pub(super) struct Proved {
    /// One box of states for the end of every stretch gone through, and one for all its times.
    pub(super) ends: Vec<Vec<Interval>>,
    pub(super) tubes: Vec<Vec<Interval>>,
    /// One box of outputs for the start of every stretch begun, if anybody asked,
    pub(super) outputs: Vec<Vec<Interval>>,
    /// and for all times of every one gone through.
    pub(super) output_tubes: Vec<Vec<Interval>>,
    /// The modes that may have acted during every stretch gone through.
    pub(super) modes: Vec<ModeSet>,
    /// Number of steps.
    pub(super) steps: u64,
    /// Of the stretch at hand.
    during: Vec<Interval>,
    acting: ModeSet,
}

/// A place on the way.
#[derive(Debug, Clone)]
pub(super) struct Mark {
    known: usize,
    during: Vec<Interval>,
    acting: ModeSet,
}

impl Proved {
    /// Number of stretches gone through.
    pub(super) fn len(&self) -> usize {
        self.ends.len()
    }

    /// The same, to be gone on with beside others; no step is counted twice.
    pub(super) fn fork(&self) -> Proved {
        Proved {
            steps: 0,
            ..self.clone()
        }
    }

    /// Begins a stretch at whose start outputs lie in `outputs`.
    pub(super) fn begin(&mut self, outputs: Vec<Interval>) {
        self.acting = ModeSet::EMPTY;
        self.during.clone_from(&outputs);
        self.outputs.push(outputs);
    }

    /// Takes what holds on a part of the stretch.
    pub(super) fn pass(&mut self, outputs: &[Interval], modes: ModeSet) {
        for (during, more) in self.during.iter_mut().zip(outputs) {
            *during = during.hull(*more);
        }
        self.acting = self.acting.union(modes);
    }

    /// Where it stands, to be taken back to.
    pub(super) fn mark(&self) -> Mark {
        Mark {
            known: self.len(),
            during: self.during.clone(),
            acting: self.acting,
        }
    }

    /// Takes back what was proved since `mark`.
    pub(super) fn back_to(&mut self, mark: Mark) {
        self.truncate(mark.known);
        (self.during, self.acting) = (mark.during, mark.acting);
    }

    /// Ends the stretch.
    pub(super) fn end(&mut self, end: Vec<Interval>, tube: Vec<Interval>) {
        self.ends.push(end);
        self.tubes.push(tube);
        self.output_tubes.push(std::mem::take(&mut self.during));
        self.modes.push(self.acting);
    }

    /// Takes back all but the first `known` stretches.
    pub(super) fn truncate(&mut self, known: usize) {
        self.ends.truncate(known);
        self.tubes.truncate(known);
        self.outputs.truncate(known + 1);
        self.output_tubes.truncate(known);
        self.modes.truncate(known);
    }

    /// Cuts with what another way through the same stretches proved of the same solutions; the longer one
    /// goes on alone.
    pub(super) fn restrict(&mut self, other: &Proved) {
        cut(&mut self.ends, &other.ends);
        cut(&mut self.tubes, &other.tubes);
        cut(&mut self.outputs, &other.outputs);
        cut(&mut self.output_tubes, &other.output_tubes);
        // Several sets of modes may tell of the same velocities: one of them is enough.
        let more = other.modes.get(self.modes.len()..).unwrap_or_default();
        self.modes.extend(more);
    }

    /// Adds what is proved of other solutions, as far as both go.
    pub(super) fn join(&mut self, other: &Proved) {
        join(&mut self.ends, &other.ends);
        join(&mut self.tubes, &other.tubes);
        join(&mut self.outputs, &other.outputs);
        join(&mut self.output_tubes, &other.output_tubes);
        self.modes.truncate(other.modes.len());
        for (own, other) in self.modes.iter_mut().zip(&other.modes) {
            *own = own.union(*other);
        }
        for (own, other) in self.during.iter_mut().zip(&other.during) {
            *own = own.hull(*other);
        }
    }
}

impl Flow {
    /// Cuts tubes with how far solutions can be from where they are at both ends of a stretch.
    ///
    /// Proof. At almost all times of the stretch velocities are convex combinations of those of the modes that
    /// act, on the tube; they are bounded by the hull, and so is their mean from either end. A state that may
    /// jump is left out.
    pub(super) fn tighten(
        &self,
        proved: &mut Proved,
        (start, params): (&[Interval], &[Interval]),
        stretches: &[Stretch],
    ) {
        let known = proved.len();
        for (k, stretch) in stretches.iter().take(known).enumerate() {
            let since = Interval::new(0.0, stretch.dt.hi()).unwrap_or(Interval::ENTIRE);
            for _ in 0..ROUNDS {
                let quantities = [&proved.tubes[k], params, &stretch.inputs].concat();
                let Some(velocities) = self.velocities(&quantities, proved.modes[k]) else {
                    break;
                };
                let (before, after) = match k {
                    0 => (start, &proved.ends[0]),
                    _ => (&proved.ends[k - 1][..], &proved.ends[k]),
                };
                let ends = before.iter().zip(after);
                for ((x, (before, after)), v) in
                    proved.tubes[k].iter_mut().zip(ends).zip(velocities)
                {
                    let moved = since * v;
                    *x = x.intersect(*before + moved).intersect(*after - moved);
                }
            }
            let quantities = [&proved.tubes[k], params, &stretch.inputs].concat();
            let outputs = self.outputs.on_box(&quantities);
            for (x, y) in proved.output_tubes[k].iter_mut().zip(outputs) {
                *x = x.intersect(y);
            }
        }
    }

    /// The hull of the velocities in these modes; `None` where one is undefined, or something may jump.
    fn velocities(&self, quantities: &[Interval], modes: ModeSet) -> Option<Vec<Interval>> {
        let field = self.switching.field(quantities)?;
        if self.switching.jump_possible(&field.signs()) {
            return None;
        }
        let mut velocities = vec![Interval::EMPTY; self.layout.states];
        for mode in modes.iter() {
            let rates = self.switching.rates[mode].iter().zip(&field.rates[mode]);
            for ((state, _), (_, rate)) in rates {
                velocities[*state] = velocities[*state].hull(*rate);
            }
        }
        velocities
            .iter()
            .all(|v| !v.is_empty())
            .then_some(velocities)
    }
}

/// Velocities on a tube that was cut are narrower again.
const ROUNDS: usize = 2;

fn cut(own: &mut Vec<Vec<Interval>>, other: &[Vec<Interval>]) {
    for (own, other) in own.iter_mut().zip(other) {
        for (x, y) in own.iter_mut().zip(other) {
            *x = x.intersect(*y);
        }
    }
    own.extend_from_slice(other.get(own.len()..).unwrap_or_default());
}

fn join(own: &mut Vec<Vec<Interval>>, other: &[Vec<Interval>]) {
    own.truncate(other.len());
    for (own, other) in own.iter_mut().zip(other) {
        for (x, y) in own.iter_mut().zip(other) {
            *x = x.hull(*y);
        }
    }
}
