//! How many threads calls may use.

use crate::error::{Error, Result};
use crate::kernel::Isa;
use crate::par;
use pyo3::exceptions::PyRuntimeWarning;
use pyo3::prelude::*;
use std::ffi::CString;

/// Limits every later call; 0 for all that the machine has.
#[pyfunction]
fn set_num_threads(threads: usize) {
    par::set_num_threads(threads);
}

/// Threads that a call uses now.
#[pyfunction]
fn get_num_threads() -> usize {
    par::num_threads()
}

/// The limit that the environment sets: the module's own variable, or else that of OpenMP, by which joblib and others
/// tell the processes that they start how many threads are theirs.
fn limit() -> Result<Option<usize>> {
    let own = std::env::var("MULTUM_NUM_THREADS").ok().filter(|word| !word.is_empty());
    match own.as_deref().map(str::parse) {
        Some(Ok(limit)) => Ok(Some(limit)),
        Some(Err(_)) => {
            let got = format!("{:?}", own.unwrap_or_default());
            Err(Error::value("MULTUM_NUM_THREADS", got, "a whole number, 0 for all threads"))
        }
        // A list is for nested regions; what is no number is not for this module to judge.
        None => Ok(std::env::var("OMP_NUM_THREADS")
            .ok()
            .and_then(|word| word.split(',').next()?.trim().parse().ok())),
    }
}

/// Warns of a variable of the environment that has no effect.
fn warn(py: Python<'_>, fault: &Error) -> PyResult<()> {
    let text = CString::new(format!("{fault}; the variable has no effect"))?;
    PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &text, 1)
}

/// Adds this topic to the module, and reads what the environment sets.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    match limit() {
        Ok(limit) => par::set_num_threads(limit.unwrap_or(0)),
        Err(fault) => warn(module.py(), &fault)?,
    }
    if let Err(fault) = Isa::wished() {
        warn(module.py(), &fault)?;
    }
    module.add_function(wrap_pyfunction!(set_num_threads, module)?)?;
    module.add_function(wrap_pyfunction!(get_num_threads, module)?)
}
