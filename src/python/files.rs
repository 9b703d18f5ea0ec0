//! Image files.

use super::convert::{ImageArg, image_array, work};
use crate::files;
use pyo3::prelude::*;
use std::path::PathBuf;

/// Reads an image file; grey images have no axis of channels.
#[pyfunction]
fn read_image<'py>(py: Python<'py>, path: PathBuf) -> PyResult<Bound<'py, PyAny>> {
    let image = work(py, None, || files::read(&path))?;
    let flat = image.channels() == 1;
    image_array(py, image, flat)
}

/// The image in a file's content; `name` stands for the path in errors.
#[pyfunction]
fn decode_image<'py>(py: Python<'py>, name: &str, data: &[u8]) -> PyResult<Bound<'py, PyAny>> {
    let image = work(py, None, || files::decode(name, data))?;
    let flat = image.channels() == 1;
    image_array(py, image, flat)
}

/// Writes an image file.
#[pyfunction]
fn write_image(py: Python<'_>, path: PathBuf, image: &Bound<'_, PyAny>) -> PyResult<()> {
    let image = ImageArg::new("image", image)?;
    let view = image.view()?;
    work(py, None, || files::write(&path, view))
}

/// Format, width, height, channels and dtype of an image file, from its header.
#[pyfunction]
fn image_info(py: Python<'_>, path: PathBuf) -> PyResult<(String, usize, usize, usize, &'static str)> {
    let info = work(py, None, || files::info(&path))?;
    Ok((info.format, info.width, info.height, info.channels, info.dtype.name()))
}

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(read_image, module)?)?;
    module.add_function(wrap_pyfunction!(decode_image, module)?)?;
    module.add_function(wrap_pyfunction!(write_image, module)?)?;
    module.add_function(wrap_pyfunction!(image_info, module)?)
}
