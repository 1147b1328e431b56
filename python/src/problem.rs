//! Problems as Python exceptions, with the words of the program.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use veribound_model::diagnostic::{Diagnostic, Diagnostics};

/// The exception for these problems.
pub fn raise(problems: Diagnostics) -> PyErr {
    Python::attach(|py| exception(py, &problems).unwrap_or_else(|error| error))
}

/// The exception for what is no problem of a text: a wrong option.
pub fn misuse(message: &str) -> PyErr {
    Python::attach(|py| {
        let none = PyList::empty(py);
        instance(py, message, none).unwrap_or_else(|error| error)
    })
}

/// A problem as the program shows it.
pub fn shown(problem: Diagnostic) -> String {
    Diagnostics::from(problem).render(false)
}

fn exception(py: Python<'_>, problems: &Diagnostics) -> PyResult<PyErr> {
    let list = PyList::empty(py);
    for problem in &problems.0 {
        list.append(entry(py, problem)?)?;
    }
    instance(py, &problems.render(false), list)
}

fn instance(py: Python<'_>, text: &str, problems: Bound<'_, PyList>) -> PyResult<PyErr> {
    let class = py.import("veribound._errors")?.getattr("Error")?;
    Ok(PyErr::from_value(class.call1((text, problems))?))
}

fn entry<'py>(py: Python<'py>, problem: &Diagnostic) -> PyResult<Bound<'py, PyDict>> {
    let entry = PyDict::new(py);
    entry.set_item("code", problem.code)?;
    entry.set_item("message", &problem.message)?;
    entry.set_item("label", &problem.label)?;
    entry.set_item("help", &problem.help)?;
    let (mut file, mut line, mut text) = (None, None, None);
    if let Some((source, range)) = &problem.place {
        let before = source.text.get(..range.start).unwrap_or(&source.text);
        let within = before.matches('\n').count();
        file = Some(source.name.as_str());
        line = Some(source.first_line + within);
        text = source.text.lines().nth(within);
    }
    entry.set_item("file", file)?;
    entry.set_item("line", line)?;
    entry.set_item("text", text)?;
    Ok(entry)
}
