//! Steps 4 to 6 of the observer: intersection with what was measured, and with what signals prove.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: samples and boxes have the lengths of the model's lists; `Observer::step` \
              checks the sample's"
)]

use crate::batch::Batch;
use crate::signals::Signals;
use crate::verdict::{Contradiction, distance};
use veribound_interval::Interval;
use veribound_interval::lanes::{Interval8, LANES, Mask};
use veribound_model::{ExprId, Layout, Model, Sample, Tape};

/// Passes over all conditions per sample; later ones can narrow what earlier ones see.
const PASSES: usize = 2;

#[derive(Debug, Clone)]
struct Condition {
    tape: Tape,
    registers: Vec<Interval8>,
}

impl Condition {
    fn new(model: &Model, layout: Layout, expr: ExprId) -> Condition {
        let tape = Tape::compile(&model.graph, layout, &[expr]);
        let registers = tape.registers();
        Condition { tape, registers }
    }

    fn value(&mut self, q: &[Interval8]) -> Interval8 {
        self.tape.eval(q, &mut self.registers);
        self.tape.output(0, &self.registers)
    }

    fn contract(&mut self, q: &mut [Interval8], target: Interval) -> Mask {
        self.tape.contract(q, target, &mut self.registers)
    }
}

/// Conditions that a sample puts on boxes.
#[derive(Debug, Clone)]
pub(crate) struct Measurements {
    layout: Layout,
    outputs: Vec<Condition>,
    /// For every signal what is zero where it proves something.
    zeros: Vec<Vec<Condition>>,
    q: Vec<Interval8>,
}

impl Measurements {
    pub(crate) fn new(model: &Model, layout: Layout) -> Measurements {
        let outputs = model
            .outputs
            .iter()
            .map(|o| Condition::new(model, layout, o.expr))
            .collect();
        let zeros = model.signals.iter().map(|signal| {
            let exprs = signal.proves_zero.iter();
            exprs.map(|e| Condition::new(model, layout, *e)).collect()
        });
        let zeros = zeros.collect();
        Measurements {
            layout,
            outputs,
            zeros,
            q: Vec::new(),
        }
    }

    /// Number of outputs.
    pub(crate) fn len(&self) -> usize {
        self.outputs.len()
    }

    /// Values of the outputs on the boxes of `batch`.
    pub(crate) fn outputs(&mut self, batch: &Batch, inputs: &[Interval]) -> Vec<Interval8> {
        self.set(batch, inputs);
        self.outputs
            .iter_mut()
            .map(|output| output.value(&self.q))
            .collect()
    }

    fn set(&mut self, batch: &Batch, inputs: &[Interval]) {
        self.q.clear();
        self.q.extend_from_slice(&batch.boxes);
        self.q.extend(inputs.iter().map(|u| Interval8::splat(*u)));
    }

    /// Narrows the boxes of `batch` to what agrees with the sample; those with which nothing does
    /// get their contradiction.
    ///
    /// Guarantee: every point of a box at which all measured outputs lie inside their bounds and
    /// everything the signals prove holds is kept.
    pub(crate) fn narrow(
        &mut self,
        batch: &mut Batch,
        sample: &Sample,
        signals: &Signals,
        found: &mut [Option<Contradiction>; LANES],
    ) {
        self.set(batch, &sample.inputs);
        for _ in 0..PASSES {
            for (signal, zeros) in self.zeros.iter_mut().enumerate() {
                if !signals.proves(signal, &sample.time) {
                    continue;
                }
                for zero in zeros {
                    let enclosure = zero.value(&self.q);
                    let left = zero.contract(&mut self.q, Interval::ZERO);
                    for lane in batch.lanes.without(left).lanes() {
                        found[lane].get_or_insert_with(|| Contradiction::Signal {
                            signal,
                            enclosure: enclosure.get(lane),
                        });
                    }
                }
            }
            for (output, condition) in self.outputs.iter_mut().enumerate() {
                let Some(measured) = sample.outputs[output] else {
                    continue;
                };
                let enclosure = condition.value(&self.q);
                let left = condition.contract(&mut self.q, measured);
                for lane in batch.lanes.without(left).lanes() {
                    found[lane].get_or_insert_with(|| Contradiction::Output {
                        output,
                        enclosure: enclosure.get(lane),
                        measured,
                        gap: distance(enclosure.get(lane), measured),
                    });
                }
            }
        }
        let kept = self.layout.states + self.layout.params;
        batch.boxes.copy_from_slice(&self.q[..kept]);
    }
}
