//! The model: immutable mathematics of a dynamic system and of what is measured of it.

use crate::diagnostic::SourceText;
use crate::graph::{ExprId, Graph};
use crate::tape::Layout;
use std::ops::Range;
use std::sync::Arc;
use veribound_interval::{Decimal, Interval};

/// A dynamic system `x' ∈ F(x, p, u)` with modes, its uncertain quantities and its outputs.
///
/// Solutions are Filippov solutions: where guards of modes overlap or touch, the right-hand side
/// is the convex hull of the modes active there. Between jumps, that is: see [`Jump`]. Parameters are constant (or new after a declared
/// reset); an input is held from one sample to the next and may be any measurable function inside
/// its declared error bound.
///
/// ```
/// use veribound_model::Model;
///
/// let text = "format = 1\nstates = [\"x [m]\"]\ninit.x = [0, 1]\nparams.k = [0.1, 2]\nder.x = \"-k*x\"\noutputs.y = \"x +- 0.01\"";
/// let model = Model::from_text("decay.toml", text)?;
/// assert_eq!((model.states[0].name.as_str(), model.states[0].unit.as_str()), ("x", "m"));
/// assert!(model.params[0].bounds.contains(0.1) && !model.params[0].bounds.contains(2.1));
/// assert!(model.describe().contains("x' = -k*x"));
/// # Ok::<(), veribound_model::Diagnostics>(())
/// ```
#[derive(Debug, Clone)]
pub struct Model {
    /// Name from the file, or the file's stem.
    pub name: String,
    /// All expressions of the model, shared.
    pub graph: Graph,
    /// States, in the order of every table.
    pub states: Vec<State>,
    /// Inputs, held from sample to sample; disturbances stand behind those that are recorded.
    pub inputs: Vec<Input>,
    /// Unknown parameters with their priors.
    pub params: Vec<Param>,
    /// Modes of all groups; at least one. A model without switches has the one mode `smooth`, always
    /// active.
    pub modes: Vec<Mode>,
    /// Which modes govern which states; every mode and every state is in exactly one group.
    pub groups: Vec<ModeGroup>,
    /// Jumps of the state.
    pub jumps: Vec<Jump>,
    /// Where solutions flow: where no jump's condition holds, the border included.
    pub flows: Guard,
    /// Measured outputs.
    pub outputs: Vec<Output>,
    /// Binary signals, and what they prove.
    pub signals: Vec<Signal>,
    /// What the right-hand sides of the states are sums of, as it is written.
    pub terms: Vec<Term>,
    /// What is known about the guards leaving no gap.
    pub coverage: Coverage,
    /// What was made of the file beyond what it says, in sentences for the user.
    pub notes: Vec<String>,
    /// The text the model was read from.
    pub source: Arc<SourceText>,
}

impl Model {
    /// The inputs that a record has a column for.
    pub fn recorded_inputs(&self) -> impl Iterator<Item = &Input> {
        self.inputs.iter().filter(|input| input.within.is_none())
    }

    /// The disturbances, each with its bounds.
    pub fn disturbances(&self) -> impl Iterator<Item = (&Input, Interval)> {
        let inputs = self.inputs.iter();
        inputs.filter_map(|input| input.within.map(|bounds| (input, bounds)))
    }

    /// The modes that govern a state, by their position in [`Model::modes`], each with the right-hand
    /// side it gives the state.
    pub fn governing(&self, state: usize) -> impl Iterator<Item = (usize, ExprId)> + '_ {
        let group = self.groups.iter().find_map(|group| {
            let position = group.states.iter().position(|known| *known == state)?;
            Some((group.modes.clone(), position))
        });
        let modes = group.into_iter().flat_map(|(modes, position)| {
            let list = self.modes.get(modes.clone()).unwrap_or_default();
            let of = list.iter().map(move |mode| mode.der.get(position).copied());
            modes.zip(of)
        });
        modes.filter_map(|(mode, rhs)| Some((mode, rhs?)))
    }

    /// Whether some jump changes this state.
    pub fn jumps_in(&self, state: usize) -> bool {
        let changed = self.jumps.iter().flat_map(|jump| &jump.set);
        changed.into_iter().any(|(set, _)| *set == state)
    }

    /// The states a mode gives a right-hand side, with it.
    pub fn governed(&self, mode: usize) -> impl Iterator<Item = (usize, ExprId)> + '_ {
        let group = self.groups.iter().find(|group| group.modes.contains(&mode));
        let states = group.into_iter().flat_map(|group| &group.states).copied();
        let rhs = self.modes.get(mode).into_iter().flat_map(|mode| &mode.der);
        states.zip(rhs.copied())
    }

    /// Where states, parameters and inputs stand in a flat list.
    pub fn layout(&self) -> Layout {
        Layout {
            states: self.states.len(),
            params: self.params.len(),
            inputs: self.inputs.len(),
        }
    }
}

/// A state of the system.
///
/// ```
/// use veribound_model::Model;
/// # let text = r#"
/// #     format = 1
/// #     states = ["x [m]", "v [m/s]"]
/// #     init   = { x = 0, v = [-1, 1] }
/// #     inputs = ["F [m/s^2]"]
/// #     [params]
/// #     T = [0, 3]
/// #     [der]
/// #     x = "v"
/// #     v = "F - friction(v, F, T)"
/// #     [outputs]
/// #     y = "x +- 0.1"
/// #     [signals]
/// #     still = { proves = "v == 0", latency = 0.02 }
/// #     [events.stop]
/// #     when = "still"
/// #     lasts = 0.5
/// #     action = "reset T"
/// # "#;
/// # let model = Model::from_text("sled.toml", text)?;
/// let v = &model.states[1];
/// assert_eq!((v.name.as_str(), v.unit.as_str()), ("v", "m/s"));
/// assert!(v.init.contains(-1.0) && v.domain.is_none());
/// # Ok::<(), veribound_model::Diagnostics>(())
/// ```
#[derive(Debug, Clone)]
pub struct State {
    /// The user's name.
    pub name: String,
    /// The user's unit, as written; empty when none is given.
    pub unit: String,
    /// Start box.
    pub init: Interval,
    /// Where the guards must cover; `None` when the user declared none.
    pub domain: Option<Interval>,
}

/// An input, known at the samples up to its error bound and held between them, or a disturbance.
///
/// ```
/// use veribound_model::Model;
/// # let text = r#"
/// #     format = 1
/// #     states = ["x [m]", "v [m/s]"]
/// #     init   = { x = 0, v = [-1, 1] }
/// #     inputs = ["F [m/s^2]"]
/// #     [params]
/// #     T = [0, 3]
/// #     [der]
/// #     x = "v"
/// #     v = "F - friction(v, F, T)"
/// #     [outputs]
/// #     y = "x +- 0.1"
/// #     [signals]
/// #     still = { proves = "v == 0", latency = 0.02 }
/// #     [events.stop]
/// #     when = "still"
/// #     lasts = 0.5
/// #     action = "reset T"
/// # "#;
/// # let model = Model::from_text("sled.toml", text)?;
/// let force = &model.inputs[0];
/// assert_eq!((force.name.as_str(), force.unit.as_str()), ("F", "m/s^2"));
/// assert!(force.error.absolute.is_zero() && force.within.is_none()); // exact, and a column of the record
/// # Ok::<(), veribound_model::Diagnostics>(())
/// ```
#[derive(Debug, Clone)]
pub struct Input {
    /// The user's name.
    pub name: String,
    /// The user's unit, as written.
    pub unit: String,
    /// Name of the record's column, where it is not the input's own.
    pub column: Option<String>,
    /// Hard error bound.
    pub error: ErrorBound,
    /// Where the guards must cover; `None` when the user declared none.
    pub domain: Option<Interval>,
    /// Of a disturbance, which no column records: it may be any measurable function of time with
    /// values in here.
    pub within: Option<Interval>,
    /// What is known of the course of its error, or of a disturbance.
    pub hold: Hold,
}

/// How long what is unknown of an input stays the same.
///
/// ```
/// use veribound_model::{Hold, Model, Outliers};
/// let text = r#"
///     format = 1
///     states = ["x [m]"]
///     init   = { x = 0 }
///     inputs = { u = { unit = "m/s", error = { relative = 0.1, hold = "level" } } }
///     [der]
///     x = "u"
///     [outputs]
///     y = { expr = "x", unit = "m", error = { absolute = 0.01 }, outliers = "2 in 100" }
/// "#;
/// let model = Model::from_text("model.toml", text)?;
/// assert_eq!(model.inputs[0].hold, Hold::Level);
/// assert_eq!(model.outputs[0].outliers, Some(Outliers { most: 2, of: 100 }));
/// # Ok::<(), veribound_model::Diagnostics>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hold {
    /// It may be any function of time.
    Free,
    /// It is constant from each sample to the next.
    Sample,
    /// It is constant as long as samples record the same value: the same float, where a value has more digits.
    Level,
}

/// An unknown parameter.
///
/// ```
/// use veribound_model::Model;
/// # let text = r#"
/// #     format = 1
/// #     states = ["x [m]", "v [m/s]"]
/// #     init   = { x = 0, v = [-1, 1] }
/// #     inputs = ["F [m/s^2]"]
/// #     [params]
/// #     T = [0, 3]
/// #     [der]
/// #     x = "v"
/// #     v = "F - friction(v, F, T)"
/// #     [outputs]
/// #     y = "x +- 0.1"
/// #     [signals]
/// #     still = { proves = "v == 0", latency = 0.02 }
/// #     [events.stop]
/// #     when = "still"
/// #     lasts = 0.5
/// #     action = "reset T"
/// # "#;
/// # let model = Model::from_text("sled.toml", text)?;
/// let level = &model.params[0];
/// assert!(level.bounds.contains(0.0) && level.bounds.contains(3.0) && level.nominal.is_none());
/// # Ok::<(), veribound_model::Diagnostics>(())
/// ```
#[derive(Debug, Clone)]
pub struct Param {
    /// The user's name.
    pub name: String,
    /// The user's unit, as written.
    pub unit: String,
    /// Prior bounds.
    pub bounds: Interval,
    /// A value that only figures show; never used in a proof.
    pub nominal: Option<Decimal>,
}

/// Whether every point of the domain lies in the guard of some mode.
///
/// ```
/// use veribound_model::{Coverage, Model};
///
/// let text = "format = 1\nstates = [\"x [m]\"]\ninit.x = [0, 1]\nparams.k = [0.1, 2]\nder.x = \"-k*x\"\noutputs.y = \"x +- 0.01\"";
/// let model = Model::from_text("decay.toml", text)?;
/// assert_eq!(model.coverage, Coverage::Everywhere); // one mode, no guards
/// # Ok::<(), veribound_model::Diagnostics>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum Coverage {
    /// Proved for every value of states, inputs and parameters.
    Everywhere,
    /// Proved for every value inside the declared domains (`[-1000, 1000]` where a state or input
    /// declares none) and the prior.
    InDomain {
        /// One interval per state.
        states: Vec<Interval>,
        /// One interval per input.
        inputs: Vec<Interval>,
    },
    /// Neither proved nor refuted within the budget; the text says where.
    Unproved(String),
}

/// A mode: where it is active, and the right-hand side there.
///
/// ```
/// use veribound_model::Model;
/// # let text = r#"
/// #     format = 1
/// #     states = ["x [m]", "v [m/s]"]
/// #     init   = { x = 0, v = [-1, 1] }
/// #     inputs = ["F [m/s^2]"]
/// #     [params]
/// #     T = [0, 3]
/// #     [der]
/// #     x = "v"
/// #     v = "F - friction(v, F, T)"
/// #     [outputs]
/// #     y = "x +- 0.1"
/// #     [signals]
/// #     still = { proves = "v == 0", latency = 0.02 }
/// #     [events.stop]
/// #     when = "still"
/// #     lasts = 0.5
/// #     action = "reset T"
/// # "#;
/// # let model = Model::from_text("sled.toml", text)?;
/// // `friction` stands for three modes: forward, stick, backward.
/// assert_eq!(model.modes.len(), 3);
/// assert!(model.describe().contains(model.modes[1].name.as_str()));
/// # Ok::<(), veribound_model::Diagnostics>(())
/// ```
#[derive(Debug, Clone)]
pub struct Mode {
    /// The user's name, or one made from the set-valued functions it comes from.
    pub name: String,
    /// Where the mode is active.
    pub guard: Guard,
    /// Time derivatives of the states its group governs, in the order of [`ModeGroup::states`].
    pub der: Vec<ExprId>,
}

/// States that switch together, and the modes that say how.
///
/// At any time one mode of every group acts, independently of the other groups: where several modes
/// of a group are possible, the velocity of its states is in the convex hull of theirs. Fifty masses
/// with friction are fifty groups of three modes; as modes of the whole model they were `3^50`.
///
/// ```
/// use veribound_model::{Jump, Model, ModeGroup, Term};
///
/// let text = r#"
///     format = 1
///     states = ["h", "v"]
///     init = { h = [1, 2], v = 0 }
///     der = { h = "v", v = "-9.81 - sign(v)*0.1" }
///     jumps.floor = { when = "h <= 0 and v <= 0", set.v = "-0.8*v" }
///     outputs.y = "h +- 0.1"
/// "#;
/// let model = Model::from_text("ball.toml", text)?;
/// let free: &ModeGroup = &model.groups[0];
/// assert_eq!(free.modes, 0..model.modes.len());
/// let floor: &Jump = &model.jumps[0];
/// assert_eq!((floor.name.as_str(), floor.set[0].0), ("floor", 1));
/// let drag: &Term = model.terms.iter().find(|term| term.text.contains("sign")).unwrap();
/// assert_eq!(drag.state, 1);
/// # Ok::<(), veribound_model::Diagnostics>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModeGroup {
    /// Indices into [`Model::states`], growing.
    pub states: Vec<usize>,
    /// Positions in [`Model::modes`].
    pub modes: Range<usize>,
}

/// A jump of the state, as of a velocity at an impact, or of a memory.
///
/// Solutions flow where no jump's condition holds and jump where one does. On the border they may do
/// either; one that no flow takes away from a point, and that a jump leaves where it is, stays there, as
/// a ball at rest on the floor does.
///
/// Example: [`ModeGroup`].
#[derive(Debug, Clone, PartialEq)]
pub struct Jump {
    /// The user's name.
    pub name: String,
    /// Where it happens, the border included. No equality stands in it: its region has an inside.
    pub guard: Guard,
    /// States that change, each with its new value in terms of the quantities before the jump.
    pub set: Vec<(usize, ExprId)>,
}

/// A condition on states, inputs and parameters.
///
/// ```
/// use veribound_model::{Guard, Model, Relation};
/// # let text = r#"
/// #     format = 1
/// #     states = ["x [m]", "v [m/s]"]
/// #     init   = { x = 0, v = [-1, 1] }
/// #     inputs = ["F [m/s^2]"]
/// #     [params]
/// #     T = [0, 3]
/// #     [der]
/// #     x = "v"
/// #     v = "F - friction(v, F, T)"
/// #     [outputs]
/// #     y = "x +- 0.1"
/// #     [signals]
/// #     still = { proves = "v == 0", latency = 0.02 }
/// #     [events.stop]
/// #     when = "still"
/// #     lasts = 0.5
/// #     action = "reset T"
/// # "#;
/// # let model = Model::from_text("sled.toml", text)?;
/// // Backward motion: v < 0, or v = 0 with the force beyond the friction.
/// let Guard::Any(ways) = &model.modes[2].guard else { panic!("two ways") };
/// assert!(matches!(ways[0], Guard::Atom { relation: Relation::Less, .. }));
/// # Ok::<(), veribound_model::Diagnostics>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum Guard {
    /// True everywhere.
    Always,
    /// `expr relation 0`.
    Atom {
        /// Left side minus right side of the comparison as written.
        expr: ExprId,
        /// How it compares to zero.
        relation: Relation,
    },
    /// Every one holds.
    All(Vec<Guard>),
    /// At least one holds.
    Any(Vec<Guard>),
}

/// A comparison with zero.
///
/// Example: [`Guard`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Relation {
    /// `< 0`
    Less,
    /// `<= 0`
    LessEqual,
    /// `> 0`
    Greater,
    /// `>= 0`
    GreaterEqual,
    /// `== 0`
    Equal,
    /// `!= 0`
    NotEqual,
}

/// A term of a right-hand side, to be named in messages.
///
/// Example: [`ModeGroup`].
#[derive(Debug, Clone)]
pub struct Term {
    /// Index into [`Model::states`] of the state whose derivative it belongs to.
    pub state: usize,
    /// Its value; of what switches in it, all values together.
    pub expr: ExprId,
    /// As the user wrote it.
    pub text: String,
    /// Line of the model file (first line is 1).
    pub line: usize,
}

/// A measured output.
///
/// ```
/// use veribound_model::Model;
/// # let text = r#"
/// #     format = 1
/// #     states = ["x [m]", "v [m/s]"]
/// #     init   = { x = 0, v = [-1, 1] }
/// #     inputs = ["F [m/s^2]"]
/// #     [params]
/// #     T = [0, 3]
/// #     [der]
/// #     x = "v"
/// #     v = "F - friction(v, F, T)"
/// #     [outputs]
/// #     y = "x +- 0.1"
/// #     [signals]
/// #     still = { proves = "v == 0", latency = 0.02 }
/// #     [events.stop]
/// #     when = "still"
/// #     lasts = 0.5
/// #     action = "reset T"
/// # "#;
/// # let model = Model::from_text("sled.toml", text)?;
/// let y = &model.outputs[0];
/// assert_eq!((y.name.as_str(), y.error.absolute.to_string()), ("y", "0.1".to_string()));
/// # Ok::<(), veribound_model::Diagnostics>(())
/// ```
#[derive(Debug, Clone)]
pub struct Output {
    /// The user's name.
    pub name: String,
    /// The user's unit, as written.
    pub unit: String,
    /// Name of the record's column, where it is not the output's own.
    pub column: Option<String>,
    /// What is measured.
    pub expr: ExprId,
    /// Hard error bound.
    pub error: ErrorBound,
    /// How many samples may be off by more than the error bound.
    pub outliers: Option<Outliers>,
}

/// At most so many of any so many samples in a row, of those that tell an output, are off by more than its error bound: as
/// far as they like.
///
/// Example: [`Hold`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outliers {
    /// How many may be,
    pub most: usize,
    /// of how many in a row.
    pub of: usize,
}

/// A hard bound on the difference between a recorded and the true value:
/// `|true - recorded| <= absolute + relative * |recorded|`.
///
/// ```
/// use veribound_interval::{Decimal, Interval};
/// use veribound_model::ErrorBound;
///
/// let number = |text| Decimal::parse(text).unwrap();
/// let error = ErrorBound { absolute: number("0.1"), relative: number("0.01") };
/// // A tenth, and a hundredth of 20.
/// let truth = error.enclose(Interval::point(20.0));
/// assert!(truth.contains(19.71) && truth.contains(20.29) && !truth.contains(20.31));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorBound {
    /// In the unit of the quantity.
    pub absolute: Decimal,
    /// Share of the recorded value: 0.1 is ten percent.
    pub relative: Decimal,
}

impl ErrorBound {
    /// Every value the true quantity can have when `recorded` was recorded.
    pub fn enclose(&self, recorded: Interval) -> Interval {
        let size = self.absolute.to_interval() + self.relative.to_interval() * recorded.abs();
        let reach = Interval::new(-size.hi(), size.hi()).unwrap_or(Interval::ENTIRE);
        recorded + reach
    }
}

/// A binary column of the record, and what it means.
///
/// ```
/// use veribound_model::Model;
/// # let text = r#"
/// #     format = 1
/// #     states = ["x [m]", "v [m/s]"]
/// #     init   = { x = 0, v = [-1, 1] }
/// #     inputs = ["F [m/s^2]"]
/// #     [params]
/// #     T = [0, 3]
/// #     [der]
/// #     x = "v"
/// #     v = "F - friction(v, F, T)"
/// #     [outputs]
/// #     y = "x +- 0.1"
/// #     [signals]
/// #     still = { proves = "v == 0", latency = 0.02 }
/// #     [events.stop]
/// #     when = "still"
/// #     lasts = 0.5
/// #     action = "reset T"
/// # "#;
/// # let model = Model::from_text("sled.toml", text)?;
/// let still = &model.signals[0];
/// assert_eq!((still.proves_zero.len(), still.latency.to_string()), (1, "0.02".to_string()));
/// # Ok::<(), veribound_model::Diagnostics>(())
/// ```
#[derive(Debug, Clone)]
pub struct Signal {
    /// The user's name.
    pub name: String,
    /// Name of the record's column, where it is not the signal's own.
    pub column: Option<String>,
    /// Expressions that are proved to be zero at time `t` when the signal was true at every sample
    /// in `[t - latency, t]` (and at least at `t`).
    pub proves_zero: Vec<ExprId>,
    /// In seconds.
    pub latency: Decimal,
    /// Parameter resets that the signal triggers.
    pub resets: Vec<Reset>,
}

/// At every sample at which the signal has been true for at least `lasts`, the parameter may have
/// taken a new value inside its prior.
///
/// ```
/// use veribound_model::Model;
/// # let text = r#"
/// #     format = 1
/// #     states = ["x [m]", "v [m/s]"]
/// #     init   = { x = 0, v = [-1, 1] }
/// #     inputs = ["F [m/s^2]"]
/// #     [params]
/// #     T = [0, 3]
/// #     [der]
/// #     x = "v"
/// #     v = "F - friction(v, F, T)"
/// #     [outputs]
/// #     y = "x +- 0.1"
/// #     [signals]
/// #     still = { proves = "v == 0", latency = 0.02 }
/// #     [events.stop]
/// #     when = "still"
/// #     lasts = 0.5
/// #     action = "reset T"
/// # "#;
/// # let model = Model::from_text("sled.toml", text)?;
/// let stop = &model.signals[0].resets[0];
/// assert_eq!((stop.event.as_str(), stop.param, stop.lasts.to_string()), ("stop", 0, "0.5".to_string()));
/// # Ok::<(), veribound_model::Diagnostics>(())
/// ```
#[derive(Debug, Clone)]
pub struct Reset {
    /// Name of the event in the file.
    pub event: String,
    /// Index into [`Model::params`].
    pub param: usize,
    /// In seconds.
    pub lasts: Decimal,
}

/// What the record says at one instant, in the order of the model's declarations.
///
/// ```
/// use veribound_interval::{Decimal, Interval};
/// use veribound_model::Sample;
///
/// // What a sample of a model with one input, two outputs and a signal says.
/// let sample = Sample {
///     time: Decimal::parse("0.01").unwrap(),
///     inputs: vec![Interval::point(0.25)],
///     outputs: vec![Interval::new(1.4, 1.6), None], // the second one was not measured
///     signals: vec![Some(true)],
///     line: 3,
/// };
/// assert_eq!(sample.time.to_string(), "0.01");
/// ```
#[derive(Debug, Clone)]
pub struct Sample {
    /// Time stamp, exactly as spelled.
    pub time: Decimal,
    /// Every value each input can have from this sample to the next.
    pub inputs: Vec<Interval>,
    /// Every value each output can have now; `None` where nothing was measured.
    pub outputs: Vec<Option<Interval>>,
    /// Signals; `None` where nothing was recorded.
    pub signals: Vec<Option<bool>>,
    /// Line of the record's file (first line is 1), for messages.
    pub line: usize,
}
