//! Models built in Rust code.
//!
//! A [`ModelBuilder`] writes the text of a model file: symbols are pieces of equations, and
//! [`ModelBuilder::build`] reads the text as [`Model::from_text`] does. So a model means the same whichever way it
//! came, messages about it point into the text it would have as a file, and it is saved as that
//! text: [`ModelBuilder::to_toml`], [`Model::to_toml`].
//!
//! ```
//! use veribound_model::build::{ModelBuilder, friction};
//!
//! let mut model = ModelBuilder::new("drive train rig");
//! let phi = model.state("phi").unit("rad").init("-0.2", "0.2").symbol();
//! let omega = model.state("omega").unit("rad/s").init(0, 0).symbol();
//! let u = model.input("u").unit("N*m").symbol();
//! let alpha = model.param("alpha", -6, "-0.05").symbol();
//! let beta = model.param("beta", 1, 400).symbol();
//! let level = model.param("T_Fs", 0, "0.3").unit("N*m").symbol();
//!
//! model.der(&phi, &omega);
//! model.der(&omega, &alpha * &omega + &beta * (&u - friction(&omega, &u, &level)));
//! model.output("phi_m", &phi, "0.1");
//! model.signal("still").proves(omega.equals(0), 0);
//!
//! let model = model.build()?;
//! assert_eq!(model.modes.len(), 3); // forward, stick, backward
//! # Ok::<(), veribound_model::Diagnostics>(())
//! ```

mod condition;
mod entries;
mod number;
mod symbol;
mod text;
mod tree;

pub use condition::{Condition, friction, if_else, pi, sticking_friction};
pub use entries::{
    DisturbanceEntry, EventEntry, InputEntry, JumpEntry, ModeEntry, OutputEntry, ParamEntry,
    SignalEntry, StateEntry,
};
pub use number::Number;
pub use symbol::Symbol;

use crate::diagnostic::{Diagnostic, Diagnostics, SourceText};
use crate::file::LARGEST_FILE;
use crate::model::Model;
use crate::syntax::{Problem, number as numbers};
use entries::Entry;
use std::sync::Arc;
use text::{Text, Value};
use tree::Flaw;

/// A model under construction; see the [module](self).
///
/// Quantities are told apart by their names: a name that is declared twice, or a symbol of another model
/// whose name this one does not have, is refused by [`ModelBuilder::build`].
///
/// ```
/// use veribound_model::build::ModelBuilder;
///
/// let mut model = ModelBuilder::new("decay");
/// let x = model.state("x").init("0.9", "1.1").symbol();
/// let k = model.param("k", 0, 2).symbol();
/// model.der(&x, -(&k * &x));
/// let problems = model.build().unwrap_err(); // nothing is measured
/// assert_eq!(problems.0[0].code, "E0109");
///
/// model.output("x_m", &x, "0.01");
/// assert_eq!(model.build()?.params[0].name, "k");
/// # Ok::<(), veribound_model::Diagnostics>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct ModelBuilder {
    name: String,
    states: Vec<StateEntry>,
    inputs: Vec<InputEntry>,
    disturbances: Vec<DisturbanceEntry>,
    params: Vec<ParamEntry>,
    lets: Vec<(String, Value)>,
    der: Vec<(String, Value)>,
    modes: Vec<ModeEntry>,
    jumps: Vec<JumpEntry>,
    outputs: Vec<OutputEntry>,
    signals: Vec<SignalEntry>,
    events: Vec<EventEntry>,
}

/// Adds the entry and gives it back to be completed.
fn added<T>(list: &mut Vec<T>, entry: T) -> &mut T {
    let at = list.len();
    list.push(entry);
    #[allow(clippy::indexing_slicing, reason = "PROOF: it was pushed above")]
    &mut list[at]
}

impl ModelBuilder {
    /// A model without anything in it; the name is for figures and reports.
    pub fn new(name: &str) -> ModelBuilder {
        ModelBuilder {
            name: name.to_string(),
            ..ModelBuilder::default()
        }
    }

    /// Declares a state; it needs a start box ([`StateEntry::init`]) and a derivative.
    pub fn state(&mut self, name: &str) -> &mut StateEntry {
        added(&mut self.states, StateEntry(Entry::new(name)))
    }

    /// Declares an input, a column of the record.
    pub fn input(&mut self, name: &str) -> &mut InputEntry {
        added(&mut self.inputs, InputEntry(Entry::new(name)))
    }

    /// Declares a disturbance: any function of time with values in the bounds.
    pub fn disturbance(
        &mut self,
        name: &str,
        lower: impl Into<Symbol>,
        upper: impl Into<Symbol>,
    ) -> &mut DisturbanceEntry {
        let mut entry = Entry::new(name);
        entry.set("bounds", Value::range(lower, upper));
        added(&mut self.disturbances, DisturbanceEntry(entry))
    }

    /// Declares an unknown parameter with its prior.
    pub fn param(
        &mut self,
        name: &str,
        lower: impl Into<Symbol>,
        upper: impl Into<Symbol>,
    ) -> &mut ParamEntry {
        let mut entry = Entry::new(name);
        entry.set("bounds", Value::range(lower, upper));
        added(&mut self.params, ParamEntry(entry))
    }

    /// Declares a parameter whose value is known.
    pub fn fixed(&mut self, name: &str, value: impl Into<Symbol>) -> &mut ParamEntry {
        let mut entry = Entry::new(name);
        entry.set("fixed", Value::Constant(value.into()));
        added(&mut self.params, ParamEntry(entry))
    }

    /// Gives a part of an equation a name. What is used often should have one: a symbol without a
    /// name is written out wherever it stands.
    pub fn define(&mut self, name: &str, value: impl Into<Symbol>) -> Symbol {
        self.lets.push((name.to_string(), Value::equation(value)));
        Symbol::name(name)
    }

    /// The time derivative of a state, for models without modes of their own.
    pub fn der(&mut self, state: &Symbol, velocity: impl Into<Symbol>) {
        let velocity = Value::equation(velocity);
        self.der.push((state.to_string(), velocity));
    }

    /// Declares a mode with its guard; the guards of all modes must leave no gap.
    pub fn mode(&mut self, name: &str, guard: impl Into<Condition>) -> &mut ModeEntry {
        let mut entry = Entry::new(name);
        entry.set("when", Value::condition(guard));
        added(&mut self.modes, ModeEntry(entry))
    }

    /// Declares a jump: solutions flow where its condition does not hold.
    pub fn jump(&mut self, name: &str, when: impl Into<Condition>) -> &mut JumpEntry {
        let mut entry = Entry::new(name);
        entry.set("when", Value::condition(when));
        added(&mut self.jumps, JumpEntry(entry))
    }

    /// Declares what is measured, with the largest error of a recorded value.
    pub fn output(
        &mut self,
        name: &str,
        value: impl Into<Symbol>,
        error: impl Into<Number>,
    ) -> &mut OutputEntry {
        let mut entry = Entry::new(name);
        entry.set("expr", Value::equation(value));
        let output = added(&mut self.outputs, OutputEntry(entry));
        output.error(error)
    }

    /// Declares a binary column of the record; what it proves is up to the model.
    pub fn signal(&mut self, name: &str) -> &mut SignalEntry {
        added(&mut self.signals, SignalEntry(Entry::new(name)))
    }

    /// Declares an event: `signal` may have been true for `lasts` seconds.
    pub fn event(&mut self, name: &str, signal: &str, lasts: impl Into<Number>) -> &mut EventEntry {
        let mut entry = Entry::new(name);
        entry.set("when", Value::Text(signal.to_string()));
        entry.set("lasts", Value::Number(lasts.into()));
        added(&mut self.events, EventEntry(entry))
    }

    /// The model file.
    pub fn to_toml(&self) -> String {
        self.write().text
    }

    /// Reads the model.
    ///
    /// # Errors
    /// Everything that is wrong with it, each with its place in [`ModelBuilder::to_toml`].
    pub fn build(&self) -> Result<Model, Diagnostics> {
        self.build_in("Rust")
    }

    /// The same for a builder in another language, which messages name.
    ///
    /// # Errors
    /// As [`ModelBuilder::build`].
    pub fn build_in(&self, language: &str) -> Result<Model, Diagnostics> {
        let Text { text, flaws } = self.write();
        let name = format!("{} (built in {language})", self.name);
        if text.len() > LARGEST_FILE {
            let message = format!("the text of the model has {} bytes", text.len());
            let help =
                format!("stay below {LARGEST_FILE}: name parts that are used often with define");
            return Err(Diagnostic::new("E0113", message).help(help).into());
        }
        if flaws.is_empty() {
            return Model::from_text(&name, text);
        }
        let source = Arc::new(SourceText::new(name, text));
        let problems = flaws.into_iter().map(|(range, flaw)| {
            let problem = match flaw {
                Flaw::NoNumber(text) => numbers::decimal(&text, range.clone()).err(),
                Flaw::TooLong => None,
            };
            let problem = problem.unwrap_or_else(|| {
                Problem::new(
                    "E0113",
                    "the expression is too long",
                    range,
                    "more than can be read",
                    "give parts of it a name with define",
                )
            });
            Diagnostic::new(problem.code, problem.message)
                .at(&source, problem.range, problem.label)
                .help(problem.help)
        });
        Err(Diagnostics(problems.collect()))
    }

    fn write(&self) -> Text {
        let mut text = Text {
            text: "format = 1\n".to_string(),
            flaws: Vec::new(),
        };
        text.line("name", &Value::Text(self.name.clone()));
        text.entries("states", self.states.iter().map(|entry| &entry.0));
        text.entries("inputs", self.inputs.iter().map(|entry| &entry.0));
        text.entries(
            "disturbances",
            self.disturbances.iter().map(|entry| &entry.0),
        );
        text.entries("params", self.params.iter().map(|entry| &entry.0));
        text.section("let", &self.lets);
        text.section("der", &self.der);
        text.entries("modes", self.modes.iter().map(|entry| &entry.0));
        text.entries("jumps", self.jumps.iter().map(|entry| &entry.0));
        text.entries("outputs", self.outputs.iter().map(|entry| &entry.0));
        text.entries("signals", self.signals.iter().map(|entry| &entry.0));
        text.entries("events", self.events.iter().map(|entry| &entry.0));
        text
    }
}

impl Model {
    /// The text of the model file that the model was read from or, built in Rust, would have been; read
    /// again it gives the same model.
    ///
    /// ```
    /// # let text = "format = 1\nname = \"clock\"\nstates = [\"t\"]\ninit.t = 0\nder.t = 1\noutputs.t_m = \"t +- 1\"";
    /// # use veribound_model::Model;
    /// let model = Model::from_text("clock.toml", text)?;
    /// assert_eq!(model.to_toml(), text);
    /// # Ok::<(), veribound_model::Diagnostics>(())
    /// ```
    pub fn to_toml(&self) -> &str {
        &self.source.text
    }
}
