//! Since when signals have been true, and what that proves.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one clock per signal of the model, and a sample has one value for each"
)]

use veribound_interval::Decimal;
use veribound_model::{Model, Sample};

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

/// One signal's past.
///
/// A missing value proves nothing: it is no proof that the signal was true, nor that it was false.
/// So there are two clocks, one for what a true signal proves and one for what it allows. The same
/// holds for what was before the first sample.
#[derive(Debug, Clone)]
struct Clock {
    latency: Decimal,
    true_since: Option<Decimal>,
    may_be: MayBe,
}

/// A declared reset: the parameter may have a new value.
#[derive(Debug, Clone)]
struct Reset {
    signal: usize,
    param: usize,
    lasts: Decimal,
}

/// The signals of a model on their way through a record.
#[derive(Debug, Clone)]
pub(crate) struct Signals {
    clocks: Vec<Clock>,
    resets: Vec<Reset>,
    params: usize,
}

impl Signals {
    pub(crate) fn new(model: &Model) -> Signals {
        let clock = |signal: &veribound_model::Signal| Clock {
            latency: signal.latency.clone(),
            true_since: None,
            may_be: MayBe::AlwaysTrue,
        };
        let resets = model.signals.iter().enumerate().flat_map(|(signal, s)| {
            s.resets.iter().map(move |reset| Reset {
                signal,
                param: reset.param,
                lasts: reset.lasts.clone(),
            })
        });
        Signals {
            clocks: model.signals.iter().map(clock).collect(),
            resets: resets.collect(),
            params: model.params.len(),
        }
    }

    /// Number of signals.
    pub(crate) fn len(&self) -> usize {
        self.clocks.len()
    }

    /// Takes note of a sample.
    pub(crate) fn note(&mut self, sample: &Sample) {
        for (clock, value) in self.clocks.iter_mut().zip(&sample.signals) {
            if *value != Some(true) {
                clock.true_since = None;
            } else if clock.true_since.is_none() {
                clock.true_since = Some(sample.time.clone());
            }
            match (value, &clock.may_be) {
                (Some(false), _) => clock.may_be = MayBe::False,
                (_, MayBe::False) => clock.may_be = MayBe::TrueSince(sample.time.clone()),
                _ => {}
            }
        }
    }

    /// Whether a signal proves now what the model says that it proves.
    pub(crate) fn proves(&self, signal: usize, now: &Decimal) -> bool {
        let clock = &self.clocks[signal];
        let since = clock.true_since.as_ref();
        since.is_some_and(|since| now - since >= clock.latency)
    }

    /// For every parameter whether it may have a new value from `now` on.
    pub(crate) fn resets(&self, now: &Decimal) -> Vec<bool> {
        let mut reset = vec![false; self.params];
        for one in &self.resets {
            reset[one.param] |= match &self.clocks[one.signal].may_be {
                MayBe::False => false,
                MayBe::TrueSince(since) => now - since >= one.lasts,
                MayBe::AlwaysTrue => true,
            };
        }
        reset
    }

    /// Whether a signal can reset the parameter.
    pub(crate) fn can_reset(&self, param: usize) -> bool {
        self.resets.iter().any(|reset| reset.param == param)
    }
}
