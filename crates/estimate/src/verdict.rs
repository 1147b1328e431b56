//! What the observer says after each sample.

use veribound_flow::{AprioriFailure, Integral, ModeSet, StepFailure};
use veribound_interval::round::sub_down;
use veribound_interval::{Decimal, Interval};

/// The state of knowledge after a sample.
///
/// ```
/// use veribound_estimate::{Observer, ObserverOptions, Verdict};
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
/// let mut observer = Observer::new(&model, ObserverOptions::default());
/// assert!(matches!(observer.step(&sample("0", 1.0))?, Verdict::Consistent(_)));
/// // No k of [0, 2] makes x grow.
/// assert!(matches!(observer.step(&sample("1", 1.5))?, Verdict::Inconsistent(_)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub enum Verdict {
    /// Some boxes are left; whether they contain a solution is not proved.
    Consistent(Estimate),
    /// Proved: no start state and parameters inside the declared bounds, with errors and inputs
    /// inside theirs, explain the record up to this sample.
    Inconsistent(Refutation),
    /// Nothing could be proved about this sample; the estimate of the sample before still holds.
    Undecided(Undecided),
}

/// Bounds after one sample. Every solution that agrees with the record so far lies in them.
///
/// ```
/// use veribound_estimate::{Observer, ObserverOptions, Verdict};
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
/// let mut observer = Observer::new(&model, ObserverOptions::default());
/// observer.step(&sample("0", 1.0))?;
/// let Verdict::Consistent(estimate) = observer.step(&sample("0.5", 0.6065))? else { panic!() };
/// // The true value of x, and what the sample says of it.
/// assert!(estimate.states[0].contains((-0.5_f64).exp()));
/// assert!(estimate.outputs[0].is_subset_of(Interval::new(0.5964, 0.6166).unwrap()));
/// assert_eq!((estimate.resets, estimate.boxes), (vec![false], 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// One interval per state.
    pub states: Vec<Interval>,
    /// One interval per parameter.
    pub params: Vec<Interval>,
    /// One interval per output: its values on the boxes, after the measurement.
    pub outputs: Vec<Interval>,
    /// Modes that are possible now or were possible at some time since the sample before.
    pub modes: ModeSet,
    /// Parameters that may have taken a new value at this sample.
    pub resets: Vec<bool>,
    /// Number of boxes in the list.
    pub boxes: usize,
    /// Box steps done for this sample.
    pub box_steps: u64,
}

/// What removed the last boxes.
///
/// ```
/// use veribound_estimate::Contradiction;
/// use veribound_interval::Interval;
///
/// let enclosure = Interval::new(0.1, 1.0).unwrap();
/// let stays = Contradiction::Signal { signal: 0, enclosure };
/// assert!(matches!(stays, Contradiction::Signal { enclosure, .. } if enclosure.mig() > 0.0));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum Contradiction {
    /// The output cannot have the measured value.
    Output {
        /// Index of the output.
        output: usize,
        /// Every value the output could have had.
        enclosure: Interval,
        /// Every value the measurement allows.
        measured: Interval,
        /// A lower bound of the distance between the two.
        gap: f64,
    },
    /// What the signal proves cannot hold.
    Signal {
        /// Index of the signal.
        signal: usize,
        /// Every value the expression that should be zero could have had.
        enclosure: Interval,
    },
    /// A state cannot have moved as its measurements say with any rate the model allows.
    Motion {
        /// The state that moved, and the state that is its rate.
        pair: Integral,
        /// Every rate possible now by the model.
        enclosure: Interval,
        /// Every rate possible now by how far the state moved.
        needed: Interval,
    },
    /// What boxes leave of a state or parameter is not what the strips of all samples leave.
    Apart {
        /// Its index: states first, then parameters.
        quantity: usize,
        /// What one of them leaves.
        enclosure: Interval,
        /// What the other one leaves.
        allowed: Interval,
    },
}

impl Contradiction {
    /// True when this one misses by less: of all boxes, the one that died last by the smallest
    /// margin tells the user most.
    pub(crate) fn is_nearer_than(&self, other: &Contradiction) -> bool {
        let miss = |c: &Contradiction| match c {
            Contradiction::Output { gap, .. } => (0, *gap),
            Contradiction::Motion {
                enclosure, needed, ..
            } => (1, distance(*enclosure, *needed)),
            Contradiction::Signal { enclosure, .. } => (2, enclosure.mig()),
            Contradiction::Apart {
                enclosure, allowed, ..
            } => (3, distance(*enclosure, *allowed)),
        };
        let ((kind, size), (other_kind, other_size)) = (miss(self), miss(other));
        kind < other_kind || (kind == other_kind && size < other_size)
    }
}

/// A proof that model and record contradict each other.
///
/// With [`Method::Polytope`](crate::Method::Polytope) the sample may be an earlier one, which was met again with what later
/// samples leave of the parameters: all samples so far take part.
///
/// ```
/// use veribound_estimate::{Contradiction, Observer, ObserverOptions, Verdict};
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
/// let mut observer = Observer::new(&model, ObserverOptions::default());
/// observer.step(&sample("0", 1.0))?;
/// let Verdict::Inconsistent(refutation) = observer.step(&sample("1", 1.5))? else { panic!() };
/// assert_eq!((refutation.sample, refutation.time.to_string()), (1, "1".to_string()));
/// let Contradiction::Output { output: 0, enclosure, measured, gap } = refutation.contradiction else { panic!() };
/// assert!(enclosure.hi() < measured.lo() && gap > 0.48);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Refutation {
    /// Position of the sample in the record, from 0.
    pub sample: u64,
    /// Line of the sample in its file.
    pub line: usize,
    /// Time stamp of the sample.
    pub time: Decimal,
    /// What removed the last boxes.
    pub contradiction: Contradiction,
}

/// Why nothing was proved about a sample.
///
/// ```
/// use veribound_estimate::{Observer, ObserverOptions, Verdict};
/// # use veribound_interval::{Decimal, Interval};
/// # use veribound_model::{Model, Sample};
/// // x' = k x^2 from 1 is infinite at 1/k.
/// let text = "format = 1\nstates = [\"x\"]\ninit.x = 1\nparams.k = [1, 2]\nder.x = \"k*x^2\"\noutputs.y = \"x +- 9\"";
/// let model = Model::from_text("explosion.toml", text)?;
/// # let sample = |time: &str| Sample {
/// #     time: Decimal::parse(time).unwrap(), inputs: vec![], outputs: vec![None], signals: vec![], line: 1,
/// # };
/// let mut observer = Observer::new(&model, ObserverOptions::default());
/// observer.step(&sample("0"))?;
/// let Verdict::Undecided(why) = observer.step(&sample("2"))? else { panic!() };
/// assert_eq!(why.cell, [model.states[0].init, model.params[0].bounds]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Undecided {
    /// Position of the sample in the record, from 0.
    pub sample: u64,
    /// Line of the sample in its file.
    pub line: usize,
    /// Time stamp of the sample that was not reached.
    pub time: Decimal,
    /// What failed.
    pub reason: StepFailure,
    /// A box on which it failed: states, then parameters.
    pub cell: Vec<Interval>,
}

impl Undecided {
    /// The state whose right-hand side is not defined somewhere on the box, if that is the reason.
    pub fn undefined_state(&self) -> Option<usize> {
        match self.reason {
            StepFailure::Apriori(AprioriFailure::Undefined { state }) => Some(state),
            _ => None,
        }
    }
}

/// A lower bound of the distance between two intervals; zero where they meet.
pub(crate) fn distance(a: Interval, b: Interval) -> f64 {
    if a.is_empty() || b.is_empty() {
        return 0.0;
    }
    sub_down(a.lo(), b.hi())
        .max(sub_down(b.lo(), a.hi()))
        .max(0.0)
}
