//! `convertMaps`.

use super::arrays::{Answer, fill, target};
use crate::compat::cv2::maps::{from_fixed, to_fixed};
use crate::error::Error;
use crate::python::remap::MapArrays;
use crate::warp::remap::Map;
use numpy::{Element, PyArray, PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;

const CV_16SC2: i32 = 35;
const CV_32FC1: i32 = 5;
const CV_32FC2: i32 = 37;

/// The position of pixel `i`.
fn place(map: &Map<'_>, i: usize) -> [f64; 2] {
    match map {
        Map::Single(x, y) => [f64::from(x[i]), f64::from(y[i])],
        Map::Double(x, y) => [x[i], y[i]],
        Map::SinglePairs(p) => [f64::from(p[2 * i]), f64::from(p[2 * i + 1])],
        Map::DoublePairs(p) => [p[2 * i], p[2 * i + 1]],
        Map::Fixed(p, codes) => {
            from_fixed([p[2 * i], p[2 * i + 1]], codes.map_or(0, |c| c[i])).map(f64::from)
        }
        Map::Matrix(_) => [0.0; 2],
    }
}

fn new<'py, T: Element>(py: Python<'py>, shape: [usize; 3]) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    Ok(match target::<T>(py, None, shape, &[])? {
        Some(made) => made,
        None => PyArray::zeros(py, &shape[..], false),
    })
}

/// `convertMaps` of maps that are packed and fit together.
#[pyfunction]
fn cv2_convert<'py>(
    py: Python<'py>,
    first: &Bound<'py, PyUntypedArray>,
    second: Option<&Bound<'py, PyUntypedArray>>,
    kind: i32,
    nearest: bool,
) -> Answer<'py> {
    let &[height, width, ..] = first.shape() else {
        return Err(Error::value("map1", format!("shape {:?}", first.shape()), "(H, W) or (H, W, 2)").into());
    };
    let arrays = MapArrays::new(first, second)?;
    let map = arrays.map()?;
    if !map.fits(width * height) {
        return Err(Error::value("map2", "another size", format!("{width} x {height}")).into());
    }
    let (flat, paired) = ([height, width, 1], [height, width, 2]);
    match kind {
        CV_16SC2 => {
            let whole = new::<i16>(py, paired)?;
            if nearest {
                fill(py, &whole, |whole| to_fixed(|i| place(&map, i), whole, None))?;
                return Ok(Some((whole, py.None()).into_pyobject(py)?.into_any()));
            }
            let codes = new::<u16>(py, flat)?;
            let mut borrowed = codes.try_readwrite().map_err(|e| Error::value("dstmap2", e, "writable"))?;
            let slice = borrowed.as_slice_mut().map_err(|e| Error::value("dstmap2", e, "packed"))?;
            fill(py, &whole, |whole| to_fixed(|i| place(&map, i), whole, Some(slice)))?;
            drop(borrowed);
            Ok(Some((whole, codes).into_pyobject(py)?.into_any()))
        }
        CV_32FC2 => {
            let out = new::<f32>(py, paired)?;
            fill(py, &out, |out| {
                for (i, pair) in out.as_chunks_mut::<2>().0.iter_mut().enumerate() {
                    *pair = place(&map, i).map(|v| v as f32);
                }
                Ok(())
            })?;
            Ok(Some((out, py.None()).into_pyobject(py)?.into_any()))
        }
        CV_32FC1 => {
            let made = [new::<f32>(py, flat)?, new::<f32>(py, flat)?];
            for (axis, out) in made.iter().enumerate() {
                fill(py, out, |out| {
                    out.iter_mut().enumerate().for_each(|(i, v)| *v = place(&map, i)[axis] as f32);
                    Ok(())
                })?;
            }
            let [x, y] = made;
            Ok(Some((x, y).into_pyobject(py)?.into_any()))
        }
        _ => Err(Error::value("dstmap1type", kind, "CV_16SC2, CV_32FC1 or CV_32FC2").into()),
    }
}

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(cv2_convert, module)?)
}
