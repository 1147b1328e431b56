//! What a model declares: each entry is a line of the file, completed step by step.

use super::condition::Condition;
use super::number::Number;
use super::symbol::Symbol;
use super::text::Value;

/// A key with its table.
#[derive(Debug, Clone)]
pub(super) struct Entry {
    pub name: String,
    pub fields: Vec<(String, Value)>,
}

impl Entry {
    pub fn new(name: &str) -> Entry {
        Entry {
            name: name.to_string(),
            fields: Vec::new(),
        }
    }

    /// The field, with `empty` in it if it is new.
    fn slot(&mut self, key: &str, empty: Value) -> Option<&mut Value> {
        let known = self.fields.iter().position(|(field, _)| field == key);
        let at = known.unwrap_or_else(|| {
            self.fields.push((key.to_string(), empty));
            self.fields.len() - 1
        });
        self.fields.get_mut(at).map(|(_, value)| value)
    }

    /// Sets a field; the last word counts.
    pub fn set(&mut self, key: &str, value: Value) {
        if let Some(slot) = self.slot(key, Value::List(Vec::new())) {
            *slot = value;
        }
    }

    /// Sets a field of the table behind a key.
    pub fn set_inside(&mut self, table: &str, key: &str, value: Value) {
        let mut inner = Entry::new(table);
        if let Some(Value::Table(fields)) = self.slot(table, Value::Table(Vec::new())) {
            inner.fields.append(fields);
            inner.set(key, value);
            *fields = inner.fields;
        }
    }

    /// Adds to the list behind a key.
    pub fn append(&mut self, key: &str, value: Value) {
        if let Some(Value::List(items)) = self.slot(key, Value::List(Vec::new())) {
            items.push(value);
        }
    }
}

macro_rules! entries {
    ($($(#[$doc:meta])* $name:ident: $($method:ident),*;)*) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone)]
        pub struct $name(pub(super) Entry);

        impl $name {
            $(entries!($method);)*
        }
    )*};
    (symbol) => {
        /// The quantity, for use in equations.
        pub fn symbol(&self) -> Symbol {
            Symbol::name(&self.0.name)
        }
    };
    (unit) => {
        /// The unit, as `"N*m"` or `"1/(kg*m^2)"`.
        pub fn unit(&mut self, unit: &str) -> &mut Self {
            self.0.set("unit", Value::Text(unit.to_string()));
            self
        }
    };
    (column) => {
        /// The name of the record's column, where it is not the name of the quantity.
        pub fn column(&mut self, column: &str) -> &mut Self {
            self.0.set("column", Value::Text(column.to_string()));
            self
        }
    };
    (domain) => {
        /// The values for which the guards must leave no gap.
        pub fn domain(&mut self, lower: impl Into<Symbol>, upper: impl Into<Symbol>) -> &mut Self {
            self.0.set("domain", Value::range(lower, upper));
            self
        }
    };
    (constant_between_samples) => {
        /// From each sample to the next the value is constant.
        pub fn constant_between_samples(&mut self) -> &mut Self {
            self.0.set("hold", Value::Text("sample".to_string()));
            self
        }
    };
    (error) => {
        /// The largest error of a recorded value, in the unit of the quantity.
        pub fn error(&mut self, absolute: impl Into<Number>) -> &mut Self {
            let bound = Value::Number(absolute.into());
            self.0.set_inside("error", "absolute", bound);
            self
        }
    };
    (held_error) => {
        /// From each sample to the next the error is constant.
        pub fn error_constant_between_samples(&mut self) -> &mut Self {
            let hold = Value::Text("sample".to_string());
            self.0.set_inside("error", "hold", hold);
            self
        }

        /// As long as the recorded value stays the same the error does, too.
        pub fn error_constant_per_level(&mut self) -> &mut Self {
            let hold = Value::Text("level".to_string());
            self.0.set_inside("error", "hold", hold);
            self
        }
    };
    (outliers) => {
        /// Of any `of` samples in a row at most `most` are off by more than the error bound.
        pub fn outliers(&mut self, most: usize, of: usize) -> &mut Self {
            let text = format!("{most} in {of}");
            self.0.set("outliers", Value::Text(text));
            self
        }
    };
    (relative_error) => {
        /// The largest error as a share of the recorded value, beside the absolute one.
        pub fn relative_error(&mut self, relative: impl Into<Number>) -> &mut Self {
            let bound = Value::Number(relative.into());
            self.0.set_inside("error", "relative", bound);
            self
        }
    };
}

entries! {
    /// A state; returned by [`ModelBuilder::state`](super::ModelBuilder::state).
    ///
    /// ```
    /// # let mut model = veribound_model::build::ModelBuilder::new("rig");
    /// let omega = model.state("omega").unit("rad/s").init("-0.1", "0.1").domain(-50, 50).symbol();
    /// assert!(model.to_toml().contains(
    ///     r#"omega = { unit = "rad/s", init = [-0.1, 0.1], domain = [-50, 50] }"#
    /// ));
    /// ```
    StateEntry: symbol, unit, domain;

    /// An input of the record; returned by [`ModelBuilder::input`](super::ModelBuilder::input). Without an error it
    /// is exact.
    ///
    /// ```
    /// # let mut model = veribound_model::build::ModelBuilder::new("rig");
    /// let u = model.input("u").unit("N*m").column("torque").relative_error("0.1").error_constant_per_level().symbol();
    /// assert!(model.to_toml().contains(
    ///     r#"u = { unit = "N*m", column = "torque", error = { relative = 0.1, hold = "level" } }"#
    /// ));
    /// ```
    InputEntry: symbol, unit, column, domain, error, relative_error, held_error;

    /// An unknown function of time inside bounds; returned by
    /// [`ModelBuilder::disturbance`](super::ModelBuilder::disturbance).
    ///
    /// ```
    /// # let mut model = veribound_model::build::ModelBuilder::new("kite");
    /// let wind = model.disturbance("wind", -2, 2).unit("m/s").symbol();
    /// assert!(model.to_toml().contains(r#"wind = { bounds = [-2, 2], unit = "m/s" }"#));
    /// let step = model.disturbance("step", 0, 1).constant_between_samples().symbol();
    /// assert!(model.to_toml().contains(r#"step = { bounds = [0, 1], hold = "sample" }"#));
    /// ```
    DisturbanceEntry: symbol, unit, constant_between_samples;

    /// A parameter; returned by [`ModelBuilder::param`](super::ModelBuilder::param) and
    /// [`ModelBuilder::fixed`](super::ModelBuilder::fixed).
    ///
    /// ```
    /// # let mut model = veribound_model::build::ModelBuilder::new("rig");
    /// let mass = model.param("m", "0.5", 5).unit("kg").nominal(2).symbol();
    /// let g = model.fixed("g", "9.81").unit("m/s^2").symbol();
    /// assert!(model.to_toml().contains(r#"g = { fixed = 9.81, unit = "m/s^2" }"#));
    /// ```
    ParamEntry: symbol, unit;

    /// A mode; returned by [`ModelBuilder::mode`](super::ModelBuilder::mode).
    ///
    /// ```
    /// # let mut model = veribound_model::build::ModelBuilder::new("heater");
    /// # let heat = model.state("T").init(20, 20).symbol();
    /// model.mode("on", heat.at_most(21)).der(&heat, 2 - "0.1" * &heat);
    /// model.mode("off", heat.at_least(21)).der(&heat, "-0.1" * &heat);
    /// assert!(model.to_toml().contains(r#"off = { when = "T >= 21", der = { T = "-0.1*T" } }"#));
    /// ```
    ModeEntry: ;

    /// A jump of the state; returned by [`ModelBuilder::jump`](super::ModelBuilder::jump).
    ///
    /// ```
    /// # let mut model = veribound_model::build::ModelBuilder::new("ball");
    /// # let h = model.state("h").init(1, 1).symbol();
    /// # let v = model.state("v").init(0, 0).symbol();
    /// # let e = model.param("e", "0.5", "0.9").symbol();
    /// model.jump("bounce", h.at_most(0).and(v.below(0))).sets(&v, -&e * &v);
    /// assert!(model.to_toml().contains(
    ///     r#"bounce = { when = "h <= 0 and v < 0", set = { v = "-e*v" } }"#
    /// ));
    /// ```
    JumpEntry: ;

    /// A measured output; returned by [`ModelBuilder::output`](super::ModelBuilder::output).
    ///
    /// ```
    /// # let mut model = veribound_model::build::ModelBuilder::new("rig");
    /// # let phi = model.state("phi").unit("rad").init(0, 0).symbol();
    /// model.output("angle", &phi, "0.01").unit("rad").relative_error("0.001").outliers(2, 100).column("phi_m");
    /// ```
    OutputEntry: unit, column, error, relative_error, outliers;

    /// A binary column of the record; returned by [`ModelBuilder::signal`](super::ModelBuilder::signal).
    ///
    /// ```
    /// # let mut model = veribound_model::build::ModelBuilder::new("rig");
    /// # let omega = model.state("omega").init(0, 0).symbol();
    /// model.signal("still").proves(omega.equals(0), "0.02").column("standstill");
    /// ```
    SignalEntry: column;

    /// What a signal does to parameters; returned by [`ModelBuilder::event`](super::ModelBuilder::event).
    ///
    /// ```
    /// # let mut model = veribound_model::build::ModelBuilder::new("rig");
    /// # let level = model.param("T", 0, "0.3").symbol();
    /// model.signal("still");
    /// model.event("standstill", "still", "0.05").resets(&level);
    /// assert!(model.to_toml().contains(
    ///     r#"standstill = { when = "still", lasts = 0.05, action = "reset T" }"#
    /// ));
    /// ```
    EventEntry: ;
}

impl StateEntry {
    /// The start box.
    pub fn init(&mut self, lower: impl Into<Symbol>, upper: impl Into<Symbol>) -> &mut Self {
        self.0.set("init", Value::range(lower, upper));
        self
    }
}

impl ParamEntry {
    /// A value that only figures show.
    pub fn nominal(&mut self, value: impl Into<Number>) -> &mut Self {
        self.0.set("nominal", Value::Number(value.into()));
        self
    }
}

impl ModeEntry {
    /// The time derivative of a state in this mode; every state needs one.
    pub fn der(&mut self, state: &Symbol, velocity: impl Into<Symbol>) -> &mut Self {
        let velocity = Value::equation(velocity);
        self.0.set_inside("der", &state.to_string(), velocity);
        self
    }
}

impl JumpEntry {
    /// The new value of a state, in terms of the quantities before the jump.
    pub fn sets(&mut self, state: &Symbol, value: impl Into<Symbol>) -> &mut Self {
        let value = Value::equation(value);
        self.0.set_inside("set", &state.to_string(), value);
        self
    }
}

impl SignalEntry {
    /// An equality that holds once the signal was true for `latency` seconds; may be given several
    /// times, the last latency counts.
    pub fn proves(
        &mut self,
        equality: impl Into<Condition>,
        latency: impl Into<Number>,
    ) -> &mut Self {
        self.0.append("proves", Value::condition(equality));
        self.0.set("latency", Value::Number(latency.into()));
        self
    }
}

impl EventEntry {
    /// A parameter that may take any value of its prior when the event happens; may be given several
    /// times.
    pub fn resets(&mut self, param: &Symbol) -> &mut Self {
        let action = self.0.fields.iter().find(|(key, _)| key == "action");
        let action = match action {
            Some((_, Value::Text(known))) => format!("{known}, {param}"),
            _ => format!("reset {param}"),
        };
        self.0.set("action", Value::Text(action));
        self
    }
}
