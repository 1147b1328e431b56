//! The Python package's part in Rust: models, runs and the streaming observer, as Python objects.
//!
//! Runs are those of the program (`veribound::program`), with the same checks, words and files. What is here hands
//! numbers over, lets Python's other threads work meanwhile, and asks now and then whether the user has pressed
//! Ctrl-C. The names of this module are private: `python/veribound/` is what users see.

mod build;
mod enclose;
mod identify;
mod model;
mod observe;
mod problem;
mod simulate;
mod source;
mod step;
mod table;
mod watch;
mod words;

use pyo3::prelude::*;

/// The Rust part of the package veribound.
#[pymodule]
fn _veribound(module: &Bound<'_, PyModule>) -> PyResult<()> {
    veribound::program::arithmetic().map_err(problem::raise)?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<model::PyModel>()?;
    module.add_class::<build::Builder>()?;
    module.add_class::<build::PySymbol>()?;
    module.add_class::<build::PyCondition>()?;
    module.add_class::<source::Source>()?;
    module.add_class::<observe::Observed>()?;
    module.add_class::<identify::Found>()?;
    module.add_class::<enclose::Enclosed>()?;
    module.add_class::<simulate::Simulated>()?;
    module.add_class::<step::Stepper>()?;
    module.add_class::<step::Step>()?;
    for function in [
        wrap_pyfunction!(observe::observe, module)?,
        wrap_pyfunction!(identify::identify, module)?,
        wrap_pyfunction!(enclose::enclose, module)?,
        wrap_pyfunction!(simulate::simulate, module)?,
        wrap_pyfunction!(build::call, module)?,
        wrap_pyfunction!(build::choose, module)?,
        wrap_pyfunction!(table::shown, module)?,
    ] {
        module.add_function(function)?;
    }
    Ok(())
}
