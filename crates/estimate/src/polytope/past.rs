//! The samples that may be met again.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: who asks for a sample knows that it is kept"
)]

use std::collections::VecDeque;
use std::sync::Arc;

use veribound_flow::form::Stretch;
use veribound_interval::{Decimal, Interval};

/// What a sample told, and where solutions were.
#[derive(Debug, Clone)]
pub(super) struct Moment {
    pub(super) time: Decimal,
    pub(super) line: usize,
    /// Quantities, by position in `Problem::quantities`, with every value each can have.
    pub(super) told: Vec<(usize, Interval)>,
    /// Inputs from now on.
    pub(super) inputs: Vec<Interval>,
    /// Time since the sample before.
    pub(super) dt: Interval,
    /// Encloses the states of all solutions that agree with the samples until then.
    pub(super) states: Vec<Interval>,
}

/// The last samples, so many at most.
#[derive(Debug, Default)]
pub(super) struct Past {
    moments: VecDeque<Arc<Moment>>,
    first: u64,
    /// Inputs until the oldest of them.
    before: Option<Vec<Interval>>,
}

impl Past {
    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.first += self.moments.len() as u64;
        self.before = self.moments.back().map(|last| last.inputs.clone());
        self.moments.clear();
    }

    /// Takes note of a sample, the one with number `sample`.
    pub(super) fn push(&mut self, sample: u64, moment: Moment, most: usize) {
        if self.moments.is_empty() {
            self.first = sample;
        }
        self.moments.push_back(Arc::new(moment));
        if self.moments.len() > most.max(2) {
            let oldest = self.moments.pop_front();
            self.before = oldest.map(|oldest| oldest.inputs.clone());
            self.first += 1;
        }
    }

    /// A sample and so many after it at most, with what is known of inputs until then.
    pub(super) fn from(&self, sample: u64, most: usize) -> Past {
        let begin = self.place(sample).min(self.moments.len());
        let later = self.moments.range(begin..);
        Past {
            moments: later.take(most + 1).cloned().collect(),
            first: sample,
            before: match begin.checked_sub(1) {
                None => self.before.clone(),
                Some(before) => Some(self.moments[before].inputs.clone()),
            },
        }
    }

    /// Number of the oldest sample that is kept.
    pub(super) fn first(&self) -> u64 {
        self.first
    }

    /// Number of the newest sample.
    pub(super) fn newest(&self) -> u64 {
        (self.first + self.moments.len() as u64).saturating_sub(1)
    }

    /// A sample that is kept.
    pub(super) fn moment(&self, sample: u64) -> &Moment {
        &self.moments[self.place(sample)]
    }

    fn place(&self, sample: u64) -> usize {
        usize::try_from(sample.saturating_sub(self.first)).unwrap_or(usize::MAX)
    }

    /// What a sample told of a quantity.
    pub(super) fn told(&self, sample: u64, quantity: usize) -> Option<Interval> {
        let moment = self.moments.get(self.place(sample))?;
        let mut told = moment.told.iter().filter(|told| told.0 == quantity);
        told.next().map(|told| told.1)
    }

    /// The stretches between the samples that are kept.
    pub(super) fn stretches(&self) -> Vec<Stretch> {
        let later = self.moments.iter().zip(self.moments.iter().skip(1));
        let stretches = later.map(|(moment, next)| Stretch {
            inputs: moment.inputs.clone(),
            dt: next.dt,
        });
        stretches.collect()
    }

    /// The inputs that may act at a sample: those until then, and those from then on.
    pub(super) fn inputs_at(&self, sample: u64) -> Vec<Interval> {
        let place = self.place(sample);
        let now = &self.moments[place].inputs;
        let before = match place.checked_sub(1) {
            None => self.before.as_ref(),
            Some(before) => Some(&self.moments[before].inputs),
        };
        match before {
            None => now.clone(),
            Some(before) => before.iter().zip(now).map(|(a, b)| a.hull(*b)).collect(),
        }
    }
}
