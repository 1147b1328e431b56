//! Columns of bounds on their way to NumPy.

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList};
use veribound::program::numbers::{show, show_inside, show_prior, show_reached, shrink};
use veribound_interval::{Decimal, Interval};

/// The nearest float to a time stamp.
pub fn seconds(time: &Decimal) -> f64 {
    time.to_string().parse().unwrap_or(f64::NAN)
}

/// Floats as bytes for `numpy.frombuffer`.
pub fn floats<'py>(py: Python<'py>, values: impl Iterator<Item = f64>) -> Bound<'py, PyBytes> {
    let bytes: Vec<u8> = values.flat_map(f64::to_ne_bytes).collect();
    PyBytes::new(py, &bytes)
}

/// Bounds over time: for every row as many intervals as there are quantities.
#[derive(Debug, Default)]
pub struct Bands {
    quantities: usize,
    ends: Vec<(f64, f64)>,
}

impl Bands {
    /// Of so many quantities.
    pub fn new(quantities: usize) -> Bands {
        Bands {
            quantities,
            ends: Vec::new(),
        }
    }

    /// Adds a row.
    pub fn push(&mut self, row: &[Interval]) {
        let row = row.iter().map(|x| ends(*x));
        let missing = std::iter::repeat((f64::NAN, f64::NAN));
        self.ends.extend(row.chain(missing).take(self.quantities));
    }

    /// Adds a row in which some are missing.
    pub fn push_some(&mut self, row: &[Option<Interval>]) {
        let row = row.iter().map(|x| x.map_or((f64::NAN, f64::NAN), ends));
        self.ends.extend(row);
    }

    /// Names with lower and upper ends: `[(name, bytes, bytes), ...]`.
    pub fn to_python<'py, 'n>(
        &self,
        py: Python<'py>,
        names: impl Iterator<Item = &'n str>,
    ) -> PyResult<Bound<'py, PyList>> {
        let list = PyList::empty(py);
        for (at, name) in names.enumerate() {
            let column = || self.ends.iter().skip(at).step_by(self.quantities);
            let lo = floats(py, column().map(|ends| ends.0));
            let hi = floats(py, column().map(|ends| ends.1));
            list.append((name, lo, hi))?;
        }
        Ok(list)
    }
}

/// Texts of which few differ: `(the different ones, the position of each)`.
#[derive(Debug, Default)]
pub struct Words {
    different: Vec<String>,
    positions: Vec<u32>,
}

impl Words {
    /// Adds the next one.
    pub fn push(&mut self, word: String) {
        let last = self.positions.last().copied();
        let is = |at: u32| self.different.get(at as usize) == Some(&word);
        let known = last.filter(|at| is(*at)).or_else(|| {
            let at = self.different.iter().position(|known| *known == word);
            at.map(|at| at as u32)
        });
        let at = known.unwrap_or_else(|| {
            self.different.push(word);
            self.different.len() as u32 - 1
        });
        self.positions.push(at);
    }

    /// The different ones, and the positions as bytes of 32 bits each.
    pub fn to_python<'py>(&self, py: Python<'py>) -> (Vec<String>, Bound<'py, PyBytes>) {
        let positions = self.positions.iter();
        let bytes: Vec<u8> = positions.flat_map(|at| at.to_ne_bytes()).collect();
        (self.different.clone(), PyBytes::new(py, &bytes))
    }
}

/// What is told of one quantity.
pub struct Told<'a> {
    pub name: &'a str,
    pub unit: &'a str,
    pub prior: Option<Interval>,
    pub bounds: Interval,
}

impl Told<'_> {
    /// `{name, unit, prior, bounds, shown, shrink}`, with texts rounded outward.
    pub fn to_python<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let entry = PyDict::new(py);
        entry.set_item("name", self.name)?;
        entry.set_item("unit", self.unit)?;
        entry.set_item("prior", self.prior.map(ends))?;
        entry.set_item("prior_shown", self.prior.map(show_prior))?;
        entry.set_item("bounds", ends(self.bounds))?;
        let prior = self.prior.unwrap_or(Interval::EMPTY);
        entry.set_item("shown", show_inside(self.bounds, prior))?;
        entry.set_item("shrink", shrink(self.bounds, prior))?;
        Ok(entry)
    }
}

/// Both ends; NaN of what is empty.
pub fn ends(x: Interval) -> (f64, f64) {
    if x.is_empty() {
        (f64::NAN, f64::NAN)
    } else {
        // No zero with a sign: it is the same number, and looks like another one.
        (x.lo() + 0.0, x.hi() + 0.0)
    }
}

/// Bounds as text with few digits, rounded outward, or inward for what is proved to be reached.
#[pyfunction]
#[pyo3(signature = (lo, hi, inward = false))]
pub fn shown(lo: f64, hi: f64, inward: bool) -> String {
    let bounds = Interval::new(lo, hi).unwrap_or(Interval::EMPTY);
    if inward {
        show_reached(Some(bounds), 1.0)
    } else {
        show(bounds)
    }
}
