//! What identification is asked, and what it says.

use super::frame::Frame;
use serde::{Deserialize, Serialize};
use veribound_interval::round::{div_up, sub_down};
use veribound_interval::{Decimal, Interval};

/// What is wanted, and what may be spent. No option changes what is proved.
///
/// ```
/// use veribound_estimate::identify::IdentifyOptions;
///
/// let rough = IdentifyOptions { tightness: 1.5, sets: 10, ..IdentifyOptions::default() };
/// assert_eq!((rough.undecided, rough.threads), (None, 1));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifyOptions {
    /// Outer bounds need not be wider than this many times the inner ones.
    pub tightness: f64,
    /// The share of the volume that is not excluded which may stay undecided in the paving; `None` asks for no
    /// paving.
    pub undecided: Option<f64>,
    /// Most sets that are looked at. Where bounds have come hardly nearer to the best possible for a while, it ends
    /// earlier. A paving may look at twenty times as many, which are smaller.
    pub sets: usize,
    /// Threads; the result does not depend on them.
    pub threads: usize,
    /// Bytes that sets and tiles may take, about; those in work come on top of it. When they are taken nothing is
    /// divided further.
    pub memory: usize,
}

impl Default for IdentifyOptions {
    fn default() -> Self {
        IdentifyOptions {
            tightness: 1.05,
            undecided: None,
            sets: 200,
            threads: 1,
            memory: usize::MAX,
        }
    }
}

/// Bounds from both sides.
///
/// ```
/// use veribound_estimate::identify::Bounds;
/// use veribound_interval::Interval;
///
/// let interval = |lo, hi| Interval::new(lo, hi).unwrap();
/// let bounds = Bounds { outer: interval(0.5, 1.5), inner: Some(interval(0.75, 1.25)) };
/// assert_eq!(bounds.tightness(), 2.0);
/// assert_eq!(Bounds { inner: None, ..bounds }.tightness(), f64::INFINITY);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Every value that agrees with model and records lies inside; empty where none does.
    pub outer: Interval,
    /// Points that are proved to agree with model and records have a value at or below the lower end of this, and one
    /// at or above the upper end, up to the rounding of what is told: nothing narrower than this can be proved.
    pub inner: Option<Interval>,
}

impl Bounds {
    /// How many times wider the outer bounds are than the inner ones, at most; infinite without inner ones.
    pub fn tightness(&self) -> f64 {
        let Some(inner) = self.inner else {
            return f64::INFINITY;
        };
        if self.outer.is_point() {
            return 1.0;
        }
        let least = sub_down(inner.hi(), inner.lo());
        if least > 0.0 {
            div_up(self.outer.width(), least)
        } else {
            f64::INFINITY
        }
    }
}

/// What is known of the parameters in a tile.
///
/// Example: [`Tile`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Status {
    /// All agree with model and records, with some start states.
    Inside,
    /// None does.
    Outside,
    /// Not known.
    Undecided,
    /// None does but those in turned tiles, which divide it.
    Turned,
}

/// Why a tile has its status.
///
/// Example: [`Tile`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Reason {
    /// A quantity cannot have the value that this sample tells, with what samples before it leave.
    Sample {
        /// Position of the record.
        record: usize,
        /// Position of the sample.
        sample: usize,
    },
    /// It is excluded at last by these samples, by their positions, beside what samples before excluded around it;
    /// where none is named, by those of the whole record.
    Samples {
        /// Position of the record.
        record: usize,
        /// Positions of the samples, in order.
        samples: Vec<usize>,
    },
    /// All samples are met.
    Met,
    /// The budget is spent, or the tile is as small as was wanted.
    Budget,
    /// What is left of it is much smaller along other axes.
    Needle {
        /// Position of their frame.
        frame: usize,
    },
    /// It lies outside of the proved bounds of the parameters.
    Bounds,
}

/// Where a tile lies along other axes than those of the parameters.
///
/// Example: [`Tile`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Turned {
    /// Position of the frame in [`Identified::frames`].
    pub frame: usize,
    /// Its unknowns, one interval per axis of the frame.
    pub unknowns: Vec<Interval>,
}

/// A box of parameters, or one along other axes, and what is known of it.
///
/// ```
/// # use veribound_estimate::identify::*;
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
/// let record: Vec<Sample> = [("0", 1.0), ("0.5", 0.6065), ("1", 0.3679)].map(|(t, y)| sample(t, y)).into();
/// let options = IdentifyOptions { undecided: Some(0.1), ..Default::default() };
/// let found = identify(&model, &[record], &options, &|_| true);
/// let truth = found.tiles.iter().find(|tile| tile.params[0].contains(1.0)).unwrap();
/// // Only needles are divided along axes of their own.
/// let turned: Option<&Turned> = truth.turned.as_ref();
/// assert_eq!((truth.status, turned), (Status::Inside, None));
/// let far = found.tiles.iter().find(|tile| tile.params[0].contains(1.9)).unwrap();
/// assert_eq!(far.status, Status::Outside);
/// assert_ne!(far.reason, Reason::Met);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tile {
    /// One interval per parameter; of a turned tile the box around it, as far as it is in the tile that it divides.
    pub params: Vec<Interval>,
    /// Where it lies, if it is turned.
    pub turned: Option<Turned>,
    /// What is known.
    pub status: Status,
    /// Why.
    pub reason: Reason,
}

/// What contradicts the model.
///
/// ```
/// # use veribound_estimate::identify::*;
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
/// let record = [("0", 1.0), ("0.5", 0.9), ("1", 1.5)].map(|(t, y)| sample(t, y)).into();
/// let found = identify(&model, &[record], &IdentifyOptions::default(), &|_| true);
/// let Conclusion::Inconsistent(refuted) = found.conclusion else { panic!("x cannot grow") };
/// // The last sample contradicts the start, whatever was read between.
/// assert_eq!((refuted.record, refuted.samples), (0, vec![2]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Refuted {
    /// Position of a record that takes part.
    pub record: usize,
    /// Positions of samples of it that refute the model together without any other, as few as were found, in order;
    /// empty where no few were found.
    pub samples: Vec<usize>,
    /// Time stamp of the last of them, or of the last sample of the record.
    pub time: Decimal,
    /// Its line in the file.
    pub line: usize,
}

/// The value of a parameter between two resets that there may have been. Values that may be reset again at the next sample
/// are not told.
///
/// ```
/// use veribound_estimate::identify::{AfterReset, IdentifyOptions, identify};
/// # use veribound_interval::{Decimal, Interval};
/// # use veribound_model::{Model, Sample};
///
/// // A height that may be another one where the signal is true.
/// let text = r#"
///     format = 1
///     states = ["x"]
///     init.x = 1
///     params.c = [0, 1]
///     der.x = "-x"
///     outputs.y = "x + c +- 0.01"
///     signals.new = { from = "column" }
///     events.lift = { when = "new", lasts = 0, action = "reset c" }
/// "#;
/// let model = Model::from_text("m.toml", text)?;
/// # let sample = |time: &str, y: f64| Sample {
/// #     time: Decimal::parse(time).unwrap(),
/// #     inputs: vec![],
/// #     outputs: vec![Some(model.outputs[0].error.enclose(Interval::point(y)))],
/// #     signals: vec![None; model.signals.len()],
/// #     line: 1,
/// # };
/// let mut record = [("0", 1.5), ("1", 0.8679), ("2", 0.3853), ("3", 0.2998)].map(|(t, y)| sample(t, y));
/// for (at, sample) in record.iter_mut().enumerate() {
///     sample.signals = vec![Some(at == 2)];
/// }
/// let found = identify(&model, &[record.into()], &IdentifyOptions::default(), &|_| true);
/// let later: &AfterReset = &found.resets[0][0];
/// assert!(found.params[0].outer.contains(0.5) && later.bounds.outer.contains(0.25));
/// assert_eq!((later.param, later.from.to_string()), (0, "2".to_owned()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct AfterReset {
    /// Position of the parameter.
    pub param: usize,
    /// Time stamp of the sample from which on it holds.
    pub from: Decimal,
    /// Time stamp of the next sample at which it may be reset, or of the last of the record.
    pub until: Decimal,
    /// Its values that agree with model and records.
    pub bounds: Bounds,
}

/// The least measurement errors with which model and records agree.
///
/// ```
/// use veribound_estimate::identify::{IdentifyOptions, LeastError, least_error};
/// # use veribound_interval::{Decimal, Interval};
/// # use veribound_model::{Model, Sample};
///
/// // A constant, read as 0 and as 1: errors of 0.1 cannot be, errors of 0.5 can.
/// let text = "format = 1\nstates = [\"x\"]\ninit.x = [0, 1]\nder.x = \"0\"\noutputs.y = \"x +- 0.1\"";
/// let model = Model::from_text("m.toml", text)?;
/// # let sample = |time: &str, y: f64| Sample {
/// #     time: Decimal::parse(time).unwrap(),
/// #     inputs: vec![],
/// #     outputs: vec![Some(model.outputs[0].error.enclose(Interval::point(y)))],
/// #     signals: vec![None; model.signals.len()],
/// #     line: 1,
/// # };
/// let record = [("0", 0.0), ("1", 1.0)].map(|(t, y)| sample(t, y)).into();
/// let least: LeastError = least_error(&model, &[record], &IdentifyOptions::default(), &|_| true);
/// assert!(least.factor.contains(5.0) && least.factor.width() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct LeastError {
    /// Proved: with declared measurement errors (half widths of what samples say of outputs) multiplied by less than the
    /// lower end of this nothing agrees; multiplied by the upper end, which may be infinite, something does. What a
    /// sample says exactly, or from one side alone, is taken as it is.
    pub factor: Interval,
    /// Parameters with which something does, if any are known, as narrow as rounding allows.
    pub point: Option<Vec<Interval>>,
    /// Sets that were looked at.
    pub sets: usize,
    /// Times that a set was moved through a record.
    pub passes: usize,
    /// Whether it ended because it was asked to.
    pub interrupted: bool,
}

/// How it ended.
///
/// ```
/// # use veribound_estimate::identify::*;
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
/// let record = [("0", 1.0), ("1", 1.5)].map(|(t, y)| sample(t, y)).into();
/// let found = identify(&model, &[record], &IdentifyOptions::default(), &|_| true);
/// let Conclusion::Inconsistent(refuted) = found.conclusion else { panic!("x cannot grow") };
/// assert_eq!(refuted.time.to_string(), "1");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum Conclusion {
    /// A point is proved to agree with model and records.
    Consistent,
    /// Proved: nothing does.
    Inconsistent(Refuted),
    /// Neither is proved.
    Undecided,
}

/// What was proved about parameters and start states.
///
/// ```
/// # use veribound_estimate::identify::*;
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
/// let record: Vec<Sample> = [("0", 1.0), ("0.5", 0.6065), ("1", 0.3679)].map(|(t, y)| sample(t, y)).into();
/// let found = identify(&model, &[record], &IdentifyOptions::default(), &|_| true);
/// assert_eq!(found.conclusion, Conclusion::Consistent);
/// let k = found.params[0];
/// assert!(k.outer.contains(1.0) && k.inner.unwrap().is_subset_of(k.outer));
/// assert!(k.tightness() < 1.05 && found.limits == [Limit::Record]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Identified {
    /// How it ended.
    pub conclusion: Conclusion,
    /// One entry per parameter. Of one that a signal may reset: its value until the first reset there may be.
    pub params: Vec<Bounds>,
    /// For every record the values after resets, in order of time.
    pub resets: Vec<Vec<AfterReset>>,
    /// For every record, one entry per state at its first sample.
    pub starts: Vec<Vec<Bounds>>,
    /// Boxes of parameters with a point in each that is proved to agree with model and records; they are as small as
    /// rounding allows. Among them are the points where parameters reach farthest.
    pub points: Vec<Vec<Interval>>,
    /// Tiles that are not turned cover the prior, if a paving was asked. What of one that is divided along other axes
    /// agrees is in turned tiles, which may reach out of it where they are undecided.
    pub tiles: Vec<Tile>,
    /// The axes of turned tiles.
    pub frames: Vec<Frame>,
    /// Encloses the volume of the parameters that agree, if a paving was asked: in undecided tiles by the part that rows
    /// leave. Parameters that are known exactly do not count.
    pub volume: Option<Interval>,
    /// Sets that were looked at.
    pub sets: usize,
    /// Times that a set was moved through a record.
    pub passes: usize,
    /// Whether it ended because it was asked to.
    pub interrupted: bool,
    /// What limits the bounds, one entry per parameter.
    pub limits: Vec<Limit>,
}

/// What limits the bounds of a parameter.
///
/// Example: [`Identified`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// The record tells no more: outer and inner bounds are as near to each other as was wanted.
    Record,
    /// More sets would have to be looked at.
    Budget,
    /// More sets would have to be kept.
    Memory,
    /// Solutions could not be enclosed to the end of the record.
    Enclosure,
    /// Inputs may have any course within their errors, so that no set of solutions comes to the end of the record: what
    /// equations say when they are integrated over it is known, and no more.
    Inputs,
}

/// Is given what makes the bytes to save, now and then; it may save or not.
///
/// Example: [`Checkpoints`].
pub type Save<'a> = dyn Fn(&dyn Fn() -> Vec<u8>) + Sync + 'a;

/// Where an identification is kept, so that it can go on after its end was forced.
///
/// ```
/// use std::sync::Mutex;
/// use veribound_estimate::identify::{Checkpoints, IdentifyOptions, Progress, Save, Unreadable, identify, resume};
/// # use veribound_interval::{Decimal, Interval};
/// # use veribound_model::{Model, Sample};
///
/// # let text = "format = 1\nstates = [\"x\"]\ninit.x = 1\nparams.k = [0, 2]\nder.x = \"-k*x\"\noutputs.y = \"x +- 0.01\"";
/// # let model = Model::from_text("decay.toml", text)?;
/// # let sample = |time: &str, y: f64| Sample {
/// #     time: Decimal::parse(time).unwrap(),
/// #     inputs: vec![],
/// #     outputs: vec![Some(model.outputs[0].error.enclose(Interval::point(y)))],
/// #     signals: vec![None; model.signals.len()],
/// #     line: 1,
/// # };
/// let record: Vec<Sample> = [("0", 1.0), ("0.5", 0.6065), ("1", 0.3679)].map(|(t, y)| sample(t, y)).into();
/// let (records, options) = ([record], IdentifyOptions { tightness: 1.0001, ..IdentifyOptions::default() });
/// let kept = Mutex::new(Vec::new());
/// let save: &Save<'_> = &|bytes| *kept.lock().unwrap() = bytes();
/// let go_on = |standing: &Progress| standing.sets < 1000;
/// let begun = Checkpoints { from: None, save };
/// let whole = resume(&model, &records, &options, &begun, &go_on).unwrap();
/// assert_eq!(whole.params, identify(&model, &records, &options, &go_on).params);
/// // From what was saved last it comes to the same; from anything else to nothing.
/// let last = kept.lock().unwrap().clone();
/// let again = Checkpoints { from: Some(&last), save: &|_| () };
/// assert_eq!(resume(&model, &records, &options, &again, &go_on), Ok(whole));
/// let wrong = Checkpoints { from: Some(&[7]), save: &|_| () };
/// assert_eq!(resume(&model, &records, &options, &wrong, &go_on), Err(Unreadable));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Checkpoints<'a> {
    /// What was saved last by a run with the same model, records and options.
    pub from: Option<&'a [u8]>,
    /// Who saves.
    pub save: &'a Save<'a>,
}

/// What was saved is not of this model, these records or this version.
///
/// Example: [`Checkpoints`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unreadable;

/// How far identification has come.
///
/// Example: [`Checkpoints`].
#[derive(Debug, Clone, PartialEq)]
pub struct Progress {
    /// Sets that were looked at.
    pub sets: usize,
    /// Sets that wait.
    pub waiting: usize,
    /// Volume of the box around all sets that are left, as share of the prior.
    pub left: f64,
    /// The largest ratio of outer and inner bounds so far.
    pub tightness: f64,
}
