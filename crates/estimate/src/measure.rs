//! Steps 4 to 6 of the observer: intersection with what was measured, and with what signals prove.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: samples and boxes have the lengths of the model's lists; `Observer::step` \
              checks the sample's"
)]

use crate::batch::Batch;
use crate::verdict::{Contradiction, distance};
use veribound_interval::lanes::{Interval8, LANES, Mask};
use veribound_interval::{Decimal, Interval};
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

/// Since when a signal may have been true.
#[derive(Debug, Clone)]
enum MayBe {
    /// It is false.
    False,
    /// Since this sample; the one before was false.
    TrueSince(Decimal),
    /// No sample says that it was ever false.
    AlwaysTrue,
}

/// What one signal proves, and since when it has been true.
///
/// A missing value proves nothing: it is no proof that the signal was true, nor that it was false.
/// So there are two clocks, one for what a true signal proves and one for what it allows. The same
/// holds for what was before the first sample.
#[derive(Debug, Clone)]
struct Witness {
    zero: Vec<Condition>,
    latency: Decimal,
    true_since: Option<Decimal>,
    may_be: MayBe,
}

/// Conditions that a sample puts on boxes.
#[derive(Debug, Clone)]
pub(crate) struct Measurements {
    layout: Layout,
    outputs: Vec<Condition>,
    witnesses: Vec<Witness>,
    q: Vec<Interval8>,
}

impl Measurements {
    pub(crate) fn new(model: &Model, layout: Layout) -> Measurements {
        let outputs = model
            .outputs
            .iter()
            .map(|o| Condition::new(model, layout, o.expr))
            .collect();
        let witnesses = model
            .signals
            .iter()
            .map(|signal| Witness {
                zero: signal
                    .proves_zero
                    .iter()
                    .map(|expr| Condition::new(model, layout, *expr))
                    .collect(),
                latency: signal.latency.clone(),
                true_since: None,
                may_be: MayBe::AlwaysTrue,
            })
            .collect();
        Measurements {
            layout,
            outputs,
            witnesses,
            q: Vec::new(),
        }
    }

    /// True when the sample has the model's outputs and signals.
    pub(crate) fn fits(&self, sample: &Sample) -> bool {
        sample.outputs.len() == self.outputs.len() && sample.signals.len() == self.witnesses.len()
    }

    /// Takes note of the signals of a sample.
    pub(crate) fn note_signals(&mut self, sample: &Sample) {
        for (witness, value) in self.witnesses.iter_mut().zip(&sample.signals) {
            if *value != Some(true) {
                witness.true_since = None;
            } else if witness.true_since.is_none() {
                witness.true_since = Some(sample.time.clone());
            }
            match (value, &witness.may_be) {
                (Some(false), _) => witness.may_be = MayBe::False,
                (_, MayBe::False) => witness.may_be = MayBe::TrueSince(sample.time.clone()),
                _ => {}
            }
        }
    }

    /// Whether a signal may have been true for at least `lasts` at `now`.
    pub(crate) fn may_have_held(&self, signal: usize, lasts: &Decimal, now: &Decimal) -> bool {
        match &self.witnesses[signal].may_be {
            MayBe::False => false,
            MayBe::TrueSince(since) => now - since >= *lasts,
            MayBe::AlwaysTrue => true,
        }
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
        found: &mut [Option<Contradiction>; LANES],
    ) {
        self.set(batch, &sample.inputs);
        for _ in 0..PASSES {
            for (signal, witness) in self.witnesses.iter_mut().enumerate() {
                let Some(since) = &witness.true_since else {
                    continue;
                };
                if &sample.time - since < witness.latency {
                    continue;
                }
                for zero in &mut witness.zero {
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
