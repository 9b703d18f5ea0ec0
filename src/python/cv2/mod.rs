//! OpenCV's functions, for calls that need no conversion.
//!
//! Each function takes what its namesake in Python was given and answers `None` where an argument is not in
//! the form that the loops read (another byte order, strides, a list in place of an array, an output that shares
//! memory with an input, ...). The front end then brings the arguments into that form, or refuses them, and
//! calls again. So an ordinary call costs one step from Python to here.

mod arrays;
mod maps;
mod resize;
mod tables;
mod warps;

use pyo3::prelude::*;

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    maps::register(module)?;
    resize::register(module)?;
    tables::register(module)?;
    warps::register(module)
}
