//! Drop-in sampling for PyTorch's `grid_sample`.

use super::convert::work;
use super::remap::{borrow, named, packed};
use crate::compat::torch::{Float, Manner, Padding, Planes, grid_sample};
use crate::error::Error;
use crate::texel::f16;
use crate::warp::remap::Interpolation;
use numpy::{
    Element, PyArray, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::prelude::*;

/// Numbers of output below which the interpreter is not let go: it would take longer than the work.
const SMALL: usize = 1 << 14;

fn sampled<'py, T: Element + Float>(
    py: Python<'py>,
    images: &Bound<'py, PyUntypedArray>,
    grid: &Bound<'py, PyUntypedArray>,
    manner: &Manner,
    last: bool,
) -> PyResult<Option<Bound<'py, PyAny>>> {
    let (Ok(_), Ok(_)) = (images.cast::<PyArrayDyn<T>>(), grid.cast::<PyArrayDyn<T>>()) else {
        return Ok(None);
    };
    let (&[batch, a, b, c], &[grids, h, w, 2]) = (images.shape(), grid.shape()) else { return Ok(None) };
    let (channels, height, width) = if last { (c, a, b) } else { (a, b, c) };
    if batch != grids || channels == 0 || height == 0 || width == 0 {
        return Ok(None);
    }
    let (shape, together) =
        if last { ([batch, h, w, channels], channels) } else { ([batch, channels, h, w], 1) };
    let total = shape.iter().try_fold(1usize, |n, &s| n.checked_mul(s)).filter(|&n| n <= 1 << 40);
    let total = total
        .ok_or_else(|| Error::value("grid", format!("an output of {shape:?}"), "at most 2^40 numbers"))?;
    let (images, grid) = (borrow::<T>(images)?, borrow::<T>(grid)?);
    let (images, grid) = (packed("input", &images)?, packed("grid", &grid)?);
    let out = if total < 1 << 20 {
        PyArray::<T, _>::zeros(py, &shape[..], false)
    } else {
        // NumPy raises MemoryError where this much cannot be had.
        py.import("numpy")?.call_method1("empty", (shape.to_vec(), T::get_dtype(py)))?.cast_into()?
    };
    if total > 0 {
        let mut borrowed = out.try_readwrite()?;
        let slice = borrowed.as_slice_mut().map_err(|e| Error::value("grid", e, "C-contiguous memory"))?;
        let (one, places, made) = (channels * height * width, 2 * h * w, channels * h * w);
        let mut job = || {
            for (n, out) in slice.chunks_exact_mut(made).enumerate() {
                let data = &images[n * one..(n + 1) * one];
                let picture = Planes { data, width, height, channels: together };
                grid_sample(&picture, manner, &grid[n * places..(n + 1) * places], w, out)?;
            }
            Ok(())
        };
        if total < SMALL { job()? } else { work(py, None, job)? }
    }
    Ok(Some(out.into_any()))
}

/// `grid_sample` of packed images (N, C, H, W), or (N, H, W, C) where channels are `last`, at a packed grid of the same
/// type; answers `None` for arguments in any other form.
#[pyfunction]
#[pyo3(signature = (images, grid, mode, padding_mode, align_corners, last))]
fn torch_grid_sample<'py>(
    py: Python<'py>,
    images: &Bound<'py, PyAny>,
    grid: &Bound<'py, PyAny>,
    mode: &str,
    padding_mode: &str,
    align_corners: bool,
    last: bool,
) -> PyResult<Option<Bound<'py, PyAny>>> {
    let kinds = [
        ("bilinear", Interpolation::Bilinear),
        ("nearest", Interpolation::Nearest),
        ("bicubic", Interpolation::Bicubic(-0.75)),
    ];
    let paddings =
        [("zeros", Padding::Zeros), ("border", Padding::Border), ("reflection", Padding::Reflection)];
    let manner = Manner {
        interpolation: named("mode", mode, &kinds)?,
        padding: named("padding_mode", padding_mode, &paddings)?,
        align_corners,
    };
    let (Ok(images), Ok(grid)) = (images.cast::<PyUntypedArray>(), grid.cast::<PyUntypedArray>()) else {
        return Ok(None);
    };
    let (dtype, other) = (images.dtype(), grid.dtype());
    let form = |a: &Bound<'py, PyUntypedArray>| a.is_c_contiguous() && a.is_aligned();
    let native = |d: &Bound<'py, numpy::PyArrayDescr>| d.is_native_byteorder() != Some(false);
    if !form(images) || !form(grid) || !native(&dtype) || !native(&other) {
        return Ok(None);
    }
    match (dtype.kind(), dtype.itemsize()) {
        (b'f', 2) => sampled::<f16>(py, images, grid, &manner, last),
        (b'f', 4) => sampled::<f32>(py, images, grid, &manner, last),
        (b'f', 8) => sampled::<f64>(py, images, grid, &manner, last),
        _ => Ok(None),
    }
}

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(torch_grid_sample, module)?)
}
