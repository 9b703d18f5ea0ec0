//! The reference.

use super::convert::{FloatArray, ImageArg, array};
use crate::error::{Error, Result};
use crate::oracle::{
    Alpha, Crew, Encoding, Estimate, Options, Pixel, PixelFilter, Reconstruction, Signal, Wrap,
};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::sync::Mutex;

/// wrap u, wrap v, border, encoding, alpha, reconstruction
type Description = (String, String, Vec<f64>, String, String, String);
/// name, sigma
type Filter = (String, f64);

fn signal(image: &Bound<'_, PyAny>, description: Description) -> PyResult<(Signal, bool)> {
    let (u, v, border, encoding, alpha, reconstruction) = description;
    let options = Options {
        wrap: [Wrap::parse(&u)?, Wrap::parse(&v)?],
        border,
        encoding: Encoding::parse(&encoding)?,
        alpha: Alpha::parse(&alpha)?,
        reconstruction: Reconstruction::parse(&reconstruction)?,
    };
    let image = ImageArg::new("image", image)?;
    Ok((Signal::new(image.view()?, &options)?, image.is_flat))
}

fn pixel((name, sigma): Filter, signal: &Signal) -> Result<Pixel> {
    Ok(Pixel::new(PixelFilter::parse(&name, sigma)?, signal.reconstruction()))
}

/// Runs long work without the interpreter lock; Ctrl-C ends it.
fn work<R: Send>(py: Python<'_>, job: impl FnOnce(&mut Crew<'_>) -> Result<R> + Send) -> PyResult<R> {
    let mut stop = || Python::attach(|py| py.check_signals().map_err(|e| e.restore(py)).is_err());
    Ok(py.detach(|| job(&mut Crew::new(crate::par::num_threads(), &mut stop)))?)
}

/// Values (..., C) and estimated errors (...).
fn results<'py>(
    py: Python<'py>,
    leading: &[usize],
    channels: usize,
    estimates: Vec<Estimate>,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    let shape: Vec<usize> = leading.iter().copied().chain([channels]).collect();
    let errors = estimates.iter().map(|estimate| estimate.error).collect();
    let values = estimates.into_iter().flat_map(|estimate| estimate.values).collect();
    Ok((array(py, values, &shape)?, array(py, errors, leading)?))
}

/// Samples at uv (..., 2) with Jacobians (..., 2, 2), already of one leading shape.
#[pyfunction]
fn reference_sample<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    uv: &Bound<'py, PyAny>,
    jacobian: Option<&Bound<'py, PyAny>>,
    description: Description,
    filter: Filter,
    tolerance: f64,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    let (signal, _) = signal(image, description)?;
    let pixel = pixel(filter, &signal)?;
    let uv = FloatArray::new("uv", uv, &[2], "(..., 2)")?;
    let jacobian =
        jacobian.map(|value| FloatArray::new("jacobian", value, &[2, 2], "(..., 2, 2)")).transpose()?;
    if let Some(jacobian) = jacobian.as_ref().filter(|jacobian| jacobian.leading(2) != uv.leading(1)) {
        let expected = format!("as many as the {:?} coordinates", uv.leading(1));
        return Err(Error::value("jacobian", format!("shape {:?}", jacobian.shape()), expected).into());
    }
    let places = uv.to_f64()?;
    let matrices = jacobian.map(|jacobian| jacobian.to_f64()).transpose()?;
    let estimates = work(py, |crew| signal.samples(&places, matrices.as_deref(), &pixel, tolerance, crew))?;
    results(py, uv.leading(1), signal.channels(), estimates)
}

/// Means over convex quads (..., 4, 2) in uv.
#[pyfunction]
fn reference_quad<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    corners: &Bound<'py, PyAny>,
    description: Description,
) -> PyResult<Bound<'py, PyAny>> {
    let (signal, _) = signal(image, description)?;
    let corners = FloatArray::new("corners", corners, &[4, 2], "(..., 4, 2)")?;
    let places = corners.to_f64()?;
    let estimates = work(py, |crew| signal.quads(&places, crew))?;
    Ok(results(py, corners.leading(2), signal.channels(), estimates)?.0)
}

/// Warps by a 3 x 3 matrix, or by a callable on (N, 2) arrays.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "one for each keyword of the Python function")]
fn reference_warp<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    matrix: Option<[[f64; 3]; 3]>,
    mapping: Option<Py<PyAny>>,
    shape: (usize, usize),
    description: Description,
    filter: Filter,
    tolerance: f64,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    let (signal, is_flat) = signal(image, description)?;
    let pixel = pixel(filter, &signal)?;
    let size = [shape.1, shape.0];
    // An exception of the callable goes around the crate's errors.
    let raised = Mutex::new(None);
    let result = work(py, |crew| match (matrix, mapping) {
        (Some(matrix), _) => signal.warp(matrix, size, &pixel, tolerance, crew),
        (None, Some(mapping)) => {
            let mut call = |places: &[[f64; 2]]| {
                Python::attach(|py| call_mapping(py, &mapping, places)).map_err(|error| {
                    *raised.lock().unwrap_or_else(std::sync::PoisonError::into_inner) = Some(error);
                    Error::Interrupted
                })
            };
            signal.warp_curved(&mut call, size, &pixel, tolerance, crew)
        }
        (None, None) => Err(Error::type_("mapping", "nothing", "a matrix or a callable")),
    });
    if let Some(error) = raised.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner) {
        return Err(error);
    }
    let field = result?;
    let full = [shape.0, shape.1, signal.channels()];
    let values = array(py, field.values, if is_flat { &full[..2] } else { &full })?;
    Ok((values, array(py, field.errors, &full[..2])?))
}

fn call_mapping(py: Python<'_>, mapping: &Py<PyAny>, places: &[[f64; 2]]) -> PyResult<Vec<[f64; 2]>> {
    let argument = array(py, places.concat(), &[places.len(), 2])?;
    let answer = mapping.call1(py, PyTuple::new(py, [argument])?)?;
    let answer = FloatArray::new("mapping", answer.bind(py), &[2], "(N, 2) of its answer")?;
    Ok(answer.to_f64()?.as_chunks().0.to_vec())
}

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(reference_sample, module)?)?;
    module.add_function(wrap_pyfunction!(reference_quad, module)?)?;
    module.add_function(wrap_pyfunction!(reference_warp, module)?)
}
