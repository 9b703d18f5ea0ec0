//! How many threads calls may use.

use crate::par;
use pyo3::prelude::*;

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

/// Adds this topic to the module, and reads the limit that the environment sets.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    if let Some(limit) = std::env::var("MULTUM_NUM_THREADS").ok().and_then(|n| n.parse().ok()) {
        par::set_num_threads(limit);
    }
    module.add_function(wrap_pyfunction!(set_num_threads, module)?)?;
    module.add_function(wrap_pyfunction!(get_num_threads, module)?)
}
