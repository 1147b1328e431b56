//! Models built in Python: the builder of the Rust crate.

use crate::model::PyModel;
use crate::problem::{misuse, raise};
use pyo3::basic::CompareOp;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};
use veribound_model::build::{
    Condition, ModelBuilder, Number, Symbol, friction, if_else, pi, sticking_friction,
};

/// A value in an equation.
#[pyclass(frozen, name = "Symbol", module = "veribound._veribound", subclass)]
#[derive(Clone)]
pub struct PySymbol(Symbol);

/// A condition of symbols.
#[pyclass(frozen, name = "Condition", module = "veribound._veribound")]
#[derive(Clone)]
pub struct PyCondition(Condition);

/// What stands for a value: a symbol, or the text of an exact number, which Python's side makes.
#[derive(FromPyObject)]
pub enum Value<'py> {
    Symbol(PyRef<'py, PySymbol>),
    Text(String),
}

impl Value<'_> {
    fn symbol(self) -> Symbol {
        match self {
            Value::Symbol(symbol) => symbol.0.clone(),
            Value::Text(text) => Symbol::from(text),
        }
    }
}

/// A number as its text; whole numbers and text as they are.
fn value(x: &Bound<'_, PyAny>) -> PyResult<Symbol> {
    let exact = x.py().import("veribound._numbers")?.getattr("operand")?;
    Ok(exact.call1((x,))?.extract::<Value<'_>>()?.symbol())
}

#[pymethods]
impl PySymbol {
    fn __add__(&self, other: &Bound<'_, PyAny>) -> PyResult<PySymbol> {
        Ok(PySymbol(&self.0 + value(other)?))
    }

    fn __radd__(&self, other: &Bound<'_, PyAny>) -> PyResult<PySymbol> {
        Ok(PySymbol(value(other)? + &self.0))
    }

    fn __sub__(&self, other: &Bound<'_, PyAny>) -> PyResult<PySymbol> {
        Ok(PySymbol(&self.0 - value(other)?))
    }

    fn __rsub__(&self, other: &Bound<'_, PyAny>) -> PyResult<PySymbol> {
        Ok(PySymbol(value(other)? - &self.0))
    }

    fn __mul__(&self, other: &Bound<'_, PyAny>) -> PyResult<PySymbol> {
        Ok(PySymbol(&self.0 * value(other)?))
    }

    fn __rmul__(&self, other: &Bound<'_, PyAny>) -> PyResult<PySymbol> {
        Ok(PySymbol(value(other)? * &self.0))
    }

    fn __truediv__(&self, other: &Bound<'_, PyAny>) -> PyResult<PySymbol> {
        Ok(PySymbol(&self.0 / value(other)?))
    }

    fn __rtruediv__(&self, other: &Bound<'_, PyAny>) -> PyResult<PySymbol> {
        Ok(PySymbol(value(other)? / &self.0))
    }

    fn __pow__(
        &self,
        other: &Bound<'_, PyAny>,
        _modulo: Option<Bound<'_, PyAny>>,
    ) -> PyResult<PySymbol> {
        Ok(PySymbol(self.0.power(value(other)?)))
    }

    fn __rpow__(
        &self,
        other: &Bound<'_, PyAny>,
        _modulo: Option<Bound<'_, PyAny>>,
    ) -> PyResult<PySymbol> {
        Ok(PySymbol(value(other)?.power(&self.0)))
    }

    fn __neg__(&self) -> PySymbol {
        PySymbol(-&self.0)
    }

    fn __pos__(&self) -> PySymbol {
        self.clone()
    }

    fn __abs__(&self) -> PySymbol {
        PySymbol(self.0.abs())
    }

    fn __richcmp__(&self, other: &Bound<'_, PyAny>, how: CompareOp) -> PyResult<PyCondition> {
        let other = value(other)?;
        Ok(PyCondition(match how {
            CompareOp::Lt => self.0.below(other),
            CompareOp::Le => self.0.at_most(other),
            CompareOp::Eq => self.0.equals(other),
            CompareOp::Ne => self.0.differs(other),
            CompareOp::Gt => self.0.above(other),
            CompareOp::Ge => self.0.at_least(other),
        }))
    }

    fn __hash__(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.0.to_string().hash(&mut hasher);
        hasher.finish()
    }

    fn __bool__(&self) -> PyResult<bool> {
        Err(undecided(&self.0.to_string()))
    }

    fn __repr__(&self) -> String {
        self.0.to_string()
    }
}

#[pymethods]
impl PyCondition {
    fn __and__(&self, other: PyRef<'_, PyCondition>) -> PyCondition {
        PyCondition(self.0.and(&other.0))
    }

    fn __or__(&self, other: PyRef<'_, PyCondition>) -> PyCondition {
        PyCondition(self.0.or(&other.0))
    }

    fn __invert__(&self) -> PyCondition {
        PyCondition(!&self.0)
    }

    fn __bool__(&self) -> PyResult<bool> {
        Err(undecided(&self.0.to_string()))
    }

    fn __repr__(&self) -> String {
        self.0.to_string()
    }
}

/// A Python `if` asks for a truth value that there is none of.
fn undecided(text: &str) -> PyErr {
    misuse(&format!(
        "`{text}` has no truth value while a model is built: it stands for all values that there will be; write \
         `veribound.if_else(condition, yes, no)`, a mode, or `&`, `|`, `~` instead of and, or, not"
    ))
}

/// `if condition then yes else no`.
#[pyfunction]
pub fn choose(condition: PyRef<'_, PyCondition>, yes: Value<'_>, no: Value<'_>) -> PySymbol {
    PySymbol(if_else(&condition.0, yes.symbol(), no.symbol()))
}

/// A function of symbols by its name.
#[pyfunction]
pub fn call(name: &str, arguments: Vec<Value<'_>>) -> PyResult<PySymbol> {
    let given: Vec<Symbol> = arguments.into_iter().map(Value::symbol).collect();
    let symbol = match (name, given.as_slice()) {
        ("pi", []) => pi(),
        ("ratio", [a, b]) => a / b,
        ("sqrt", [x]) => x.sqrt(),
        ("exp", [x]) => x.exp(),
        ("ln", [x]) => x.ln(),
        ("log2", [x]) => x.log2(),
        ("log10", [x]) => x.log10(),
        ("sin", [x]) => x.sin(),
        ("cos", [x]) => x.cos(),
        ("tan", [x]) => x.tan(),
        ("asin", [x]) => x.asin(),
        ("acos", [x]) => x.acos(),
        ("atan", [x]) => x.atan(),
        ("sinh", [x]) => x.sinh(),
        ("cosh", [x]) => x.cosh(),
        ("tanh", [x]) => x.tanh(),
        ("asinh", [x]) => x.asinh(),
        ("acosh", [x]) => x.acosh(),
        ("atanh", [x]) => x.atanh(),
        ("cbrt", [x]) => x.cbrt(),
        ("floor", [x]) => x.floor(),
        ("ceil", [x]) => x.ceil(),
        ("round", [x]) => x.round(),
        ("trunc", [x]) => x.trunc(),
        ("sign", [x]) => x.sign(),
        ("minimum", [a, b]) => a.min(b),
        ("maximum", [a, b]) => a.max(b),
        ("atan2", [y, x]) => y.atan2(x),
        ("sat", [x, lower, upper]) => x.sat(lower, upper),
        ("deadzone", [x, lower, upper]) => x.deadzone(lower, upper),
        ("friction", [velocity, drive, level]) => friction(velocity, drive, level),
        ("friction", [velocity, drive, sliding, holding]) => {
            sticking_friction(velocity, drive, sliding, holding)
        }
        ("table", [x, points @ ..]) => {
            let (points, _) = points.as_chunks::<2>();
            x.table(points.iter().map(|[x, y]| (x, y)))
        }
        _ => {
            return Err(misuse(&format!(
                "no function `{name}` of so many arguments"
            )));
        }
    };
    Ok(PySymbol(symbol))
}

/// A model under construction.
#[pyclass(name = "Builder", module = "veribound._veribound", subclass)]
pub struct Builder(ModelBuilder);

/// Completes an entry with what was given.
macro_rules! given {
    ($entry:expr; $($method:ident($($value:ident),*)),*) => {$(
        #[allow(unused_parens, reason = "one value or more")]
        if let ($(Some($value)),*) = ($($value),*) {
            $entry.$method($($value),*);
        }
    )*};
}

fn pair(bounds: Option<(Value<'_>, Value<'_>)>) -> Option<(Symbol, Symbol)> {
    bounds.map(|(lower, upper)| (lower.symbol(), upper.symbol()))
}

#[pymethods]
impl Builder {
    #[new]
    fn new(name: &str) -> Builder {
        Builder(ModelBuilder::new(name))
    }

    #[pyo3(signature = (name, unit, init, domain))]
    fn state(
        &mut self,
        name: &str,
        unit: Option<&str>,
        init: (Value<'_>, Value<'_>),
        domain: Option<(Value<'_>, Value<'_>)>,
    ) -> PySymbol {
        let entry = self.0.state(name);
        given!(entry; unit(unit));
        let (lower, upper) = (init.0.symbol(), init.1.symbol());
        entry.init(lower, upper);
        if let Some((lower, upper)) = pair(domain) {
            entry.domain(lower, upper);
        }
        PySymbol(entry.symbol())
    }

    #[pyo3(signature = (name, unit, errors, error_hold, column, domain))]
    fn input(
        &mut self,
        name: &str,
        unit: Option<&str>,
        errors: (Option<String>, Option<String>),
        error_hold: Option<&str>,
        column: Option<&str>,
        domain: Option<(Value<'_>, Value<'_>)>,
    ) -> PyResult<PySymbol> {
        let entry = self.0.input(name);
        let (error, relative_error) = errors;
        given!(entry; unit(unit), error(error), relative_error(relative_error), column(column));
        match error_hold {
            None => {}
            Some("sample") => {
                entry.error_constant_between_samples();
            }
            Some("level") => {
                entry.error_constant_per_level();
            }
            Some(other) => {
                return Err(PyValueError::new_err(format!(
                    "there is no error_hold `{other}`: write \"sample\" for an error that is constant from each sample to the \
                     next, \"level\" for one that is constant as long as the recorded value stays the same, or leave it out for \
                     any function of time"
                )));
            }
        }
        if let Some((lower, upper)) = pair(domain) {
            entry.domain(lower, upper);
        }
        Ok(PySymbol(entry.symbol()))
    }

    #[pyo3(signature = (name, bounds, unit, hold))]
    fn disturbance(
        &mut self,
        name: &str,
        bounds: (Value<'_>, Value<'_>),
        unit: Option<&str>,
        hold: bool,
    ) -> PySymbol {
        let (lower, upper) = (bounds.0.symbol(), bounds.1.symbol());
        let entry = self.0.disturbance(name, lower, upper);
        given!(entry; unit(unit));
        if hold {
            entry.constant_between_samples();
        }
        PySymbol(entry.symbol())
    }

    #[pyo3(signature = (name, bounds, unit, nominal))]
    fn param(
        &mut self,
        name: &str,
        bounds: (Value<'_>, Value<'_>),
        unit: Option<&str>,
        nominal: Option<String>,
    ) -> PySymbol {
        let (lower, upper) = (bounds.0.symbol(), bounds.1.symbol());
        let entry = self.0.param(name, lower, upper);
        given!(entry; unit(unit), nominal(nominal));
        PySymbol(entry.symbol())
    }

    #[pyo3(signature = (name, value, unit))]
    fn fixed(&mut self, name: &str, value: Value<'_>, unit: Option<&str>) -> PySymbol {
        let entry = self.0.fixed(name, value.symbol());
        given!(entry; unit(unit));
        PySymbol(entry.symbol())
    }

    fn define(&mut self, name: &str, value: Value<'_>) -> PySymbol {
        PySymbol(self.0.define(name, value.symbol()))
    }

    fn der(&mut self, state: PyRef<'_, PySymbol>, velocity: Value<'_>) {
        self.0.der(&state.0, velocity.symbol());
    }

    fn mode(
        &mut self,
        name: &str,
        when: Option<PyRef<'_, PyCondition>>,
        der: Vec<(PyRef<'_, PySymbol>, Value<'_>)>,
    ) {
        let guard = when.map_or_else(Condition::always, |when| when.0.clone());
        let entry = self.0.mode(name, guard);
        for (state, velocity) in der {
            entry.der(&state.0, velocity.symbol());
        }
    }

    fn jump(
        &mut self,
        name: &str,
        when: PyRef<'_, PyCondition>,
        sets: Vec<(PyRef<'_, PySymbol>, Value<'_>)>,
    ) {
        let entry = self.0.jump(name, &when.0);
        for (state, value) in sets {
            entry.sets(&state.0, value.symbol());
        }
    }

    #[pyo3(signature = (name, value, errors, outliers, unit, column))]
    fn output(
        &mut self,
        name: &str,
        value: Value<'_>,
        errors: (String, Option<String>),
        outliers: Option<(usize, usize)>,
        unit: Option<&str>,
        column: Option<&str>,
    ) {
        let (error, relative_error) = errors;
        let entry = self.0.output(name, value.symbol(), Number::from(error));
        given!(entry; unit(unit), column(column), relative_error(relative_error));
        if let Some((most, of)) = outliers {
            entry.outliers(most, of);
        }
    }

    #[pyo3(signature = (name, proves, latency, column))]
    fn signal(
        &mut self,
        name: &str,
        proves: Vec<PyRef<'_, PyCondition>>,
        latency: String,
        column: Option<&str>,
    ) {
        let entry = self.0.signal(name);
        for equality in proves {
            entry.proves(&equality.0, latency.as_str());
        }
        given!(entry; column(column));
    }

    fn event(&mut self, name: &str, signal: &str, lasts: String, resets: Vec<PyRef<'_, PySymbol>>) {
        let entry = self.0.event(name, signal, lasts);
        for param in resets {
            entry.resets(&param.0);
        }
    }

    fn to_toml(&self) -> String {
        self.0.to_toml()
    }

    fn build(&self) -> PyResult<PyModel> {
        Ok(PyModel::new(self.0.build_in("Python").map_err(raise)?))
    }
}
