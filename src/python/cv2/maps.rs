//! Maps: those that are given, `convertMaps`, undistortion.

use super::arrays::{Answer, Picture, array, fill, for_kind, kind, matrix, pair, target};
use crate::compat::cv2::maps::{Target, convert};
use crate::compat::cv2::read::{Pixel, projective_inverse};
use crate::compat::cv2::undistort::{Camera, Lens, tilt};
use crate::error::Error;
use crate::python::remap::MapArrays;
use numpy::{
    Element, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use std::ops::Range;

const CV_16SC2: i32 = 35;
const CV_32FC1: i32 = 5;
const CV_32FC2: i32 = 37;

/// The arrays of a map that can be read as they lie, and its height and width.
pub(super) fn map_arrays<'py>(
    first: &Bound<'py, PyAny>,
    second: &Bound<'py, PyAny>,
) -> PyResult<Option<(MapArrays<'py>, [usize; 2])>> {
    let Some(first) = array(first) else { return Ok(None) };
    let second = match second.is_none() {
        true => None,
        false => match array(second) {
            None => return Ok(None),
            second => second,
        },
    };
    let packed = |a: &Bound<'py, PyUntypedArray>| a.is_c_contiguous() && a.is_aligned();
    let (of_pixels, pairs) = match *first.shape() {
        [h, w] => ([h, w], false),
        [h, w, 2] => ([h, w], true),
        _ => return Ok(None),
    };
    let numbers = |a: &Bound<'py, PyUntypedArray>| {
        let dtype = a.dtype();
        let native = dtype.is_native_byteorder() != Some(false);
        native.then_some((dtype.kind(), dtype.itemsize()))
    };
    let fits = match (numbers(first), second.map(numbers)) {
        (Some((b'f', 4 | 8)), None) => pairs,
        (Some((b'f', n @ (4 | 8))), Some(Some((b'f', m)))) => !pairs && n == m,
        (Some((b'i', 2)), None | Some(Some((b'u', 2)))) => pairs,
        _ => false,
    };
    let fits = fits && second.is_none_or(|s| *s.shape() == of_pixels && packed(s));
    if !fits || !packed(first) || of_pixels.contains(&0) {
        return Ok(None);
    }
    Ok(Some((MapArrays::new(first, second)?, of_pixels)))
}

/// The two arrays of a map in one of its forms, filled; those given where they can be written as they lie.
fn filled<'py>(
    py: Python<'py>,
    kind: i32,
    [height, width]: [usize; 2],
    given: [Option<&Bound<'py, PyAny>>; 2],
    inputs: &[Range<usize>],
    job: impl FnOnce(Target<'_>) -> crate::error::Result<()> + Send,
) -> Answer<'py> {
    let (flat, paired) = ([height, width, 1], [height, width, 2]);
    let packed = |e: numpy::AsSliceError| Error::value("map2", e, "C-contiguous memory");
    macro_rules! both {
        ($one:ty, $first:expr, $two:ty, |$a:ident, $b:ident| $target:expr) => {{
            let Some(one) = target::<$one>(py, given[0], $first, inputs)? else { return Ok(None) };
            let Some(two) = target::<$two>(py, given[1], flat, inputs)? else { return Ok(None) };
            // The same array for both is the caller's error, which the borrow tells.
            let bad = |e: numpy::BorrowError| Error::value("map2", e, "a writable array of its own");
            let mut borrowed = two.try_readwrite().map_err(bad)?;
            let $b = borrowed.as_slice_mut().map_err(packed)?;
            fill(py, &one, |$a| job($target))?;
            drop(borrowed);
            Ok(Some((one, two).into_pyobject(py)?.into_any()))
        }};
    }
    macro_rules! alone {
        ($one:ty, |$a:ident| $target:expr) => {{
            let Some(one) = target::<$one>(py, given[0], paired, inputs)? else { return Ok(None) };
            fill(py, &one, |$a| job($target))?;
            Ok(Some((one, py.None()).into_pyobject(py)?.into_any()))
        }};
    }
    match kind {
        CV_16SC2 => both!(i16, paired, u16, |a, b| Target::Fixed(a, Some(b))),
        NEAREST => alone!(i16, |a| Target::Fixed(a, None)),
        CV_32FC1 => both!(f32, flat, f32, |a, b| Target::Planes(a, b)),
        CV_32FC2 => alone!(f32, |a| Target::Pairs(a)),
        _ => Err(Error::value("m1type", kind, "CV_16SC2, CV_32FC1 or CV_32FC2").into()),
    }
}

/// Stands for [`CV_16SC2`] without fractions.
const NEAREST: i32 = -2;

/// `convertMaps`.
#[pyfunction]
#[pyo3(signature = (map1, map2, kind, dst1, dst2, nearest))]
fn cv2_convert<'py>(
    py: Python<'py>,
    map1: &Bound<'py, PyAny>,
    map2: &Bound<'py, PyAny>,
    kind: i32,
    dst1: Option<&Bound<'py, PyAny>>,
    dst2: Option<&Bound<'py, PyAny>>,
    nearest: bool,
) -> Answer<'py> {
    if ![CV_16SC2, CV_32FC1, CV_32FC2].contains(&kind) {
        return Err(Error::value("dstmap1type", kind, "CV_16SC2, CV_32FC1 or CV_32FC2").into());
    }
    let Some((arrays, size)) = map_arrays(map1, map2)? else { return Ok(None) };
    let kind = if nearest && kind == CV_16SC2 { NEAREST } else { kind };
    let map = arrays.map()?;
    filled(py, kind, size, [dst1, dst2], &arrays.spans(), |target| convert(&map, target))
}

/// A camera from fx, fy, cx, cy; the twelve numbers of the standard lens and its two tilts, or the four of a fisheye; and
/// the matrix from output pixels to directions.
fn camera(intrinsics: [f64; 4], lens: &[f64], inverse: [f64; 9]) -> crate::error::Result<Camera> {
    let lens = match lens {
        &[k1, k2, k3, k4] => Lens::Fisheye([k1, k2, k3, k4]),
        lens => {
            let (Some(numbers), Some(&[x, y])) = (lens.first_chunk::<12>(), lens.get(12..14)) else {
                return Err(Error::value(
                    "distCoeffs",
                    format!("{} numbers", lens.len()),
                    "14, or 4 of a fisheye",
                ));
            };
            Lens::Standard(*numbers, tilt(x, y))
        }
    };
    let [fx, fy, cx, cy] = intrinsics;
    Ok(Camera { focal: [fx, fy], center: [cx, cy], lens, inverse })
}

/// A map of `remap` with the places where an undistorted picture of `size` (width, height) is read.
#[pyfunction]
#[pyo3(signature = (intrinsics, lens, inverse, size, kind, map1, map2))]
#[expect(clippy::too_many_arguments, reason = "the front end names them all")]
fn cv2_undistortion<'py>(
    py: Python<'py>,
    intrinsics: [f64; 4],
    lens: Vec<f64>,
    inverse: [f64; 9],
    size: (usize, usize),
    kind: i32,
    map1: Option<&Bound<'py, PyAny>>,
    map2: Option<&Bound<'py, PyAny>>,
) -> Answer<'py> {
    let camera = camera(intrinsics, &lens, inverse)?;
    let (width, height) = size;
    // As in OpenCV, -1 and 0 stand for the fixed-point form.
    let kind = if kind <= 0 { CV_16SC2 } else { kind };
    filled(py, kind, [height, width], [map1, map2], &[], |target| camera.fill(width, target))
}

/// The numbers of a lens of the standard model, zeros where none are given.
fn coefficients(value: Option<&Bound<'_, PyAny>>) -> Option<[f64; 14]> {
    let mut lens = [0.0; 14];
    let Some(value) = value.filter(|v| !v.is_none()) else { return Some(lens) };
    let array = array(value)?;
    let flat = match *array.shape() {
        [_] => true,
        [a, b] => a == 1 || b == 1,
        _ => false,
    };
    let doubles = array.cast::<PyArrayDyn<f64>>().ok()?.try_readonly().ok()?;
    let numbers = doubles.as_slice().ok()?;
    if !flat || ![0, 4, 5, 8, 12, 14].contains(&numbers.len()) {
        return None;
    }
    lens[..numbers.len()].copy_from_slice(numbers);
    Some(lens)
}

/// `initUndistortRectifyMap` of the standard model, for matrices of 3 x 3.
#[pyfunction]
#[pyo3(signature = (matrix3, lens, r, new, size, kind, map1, map2))]
#[expect(clippy::too_many_arguments, reason = "as many as the function that it stands for")]
fn cv2_rectify<'py>(
    py: Python<'py>,
    matrix3: &Bound<'py, PyAny>,
    lens: Option<&Bound<'py, PyAny>>,
    r: Option<&Bound<'py, PyAny>>,
    new: Option<&Bound<'py, PyAny>>,
    size: &Bound<'py, PyAny>,
    kind: i32,
    map1: Option<&Bound<'py, PyAny>>,
    map2: Option<&Bound<'py, PyAny>>,
) -> Answer<'py> {
    let (Some(k), Some(lens)) = (matrix(matrix3, 3), coefficients(lens)) else { return Ok(None) };
    let given = |value: Option<&Bound<'py, PyAny>>, default: [f64; 9]| {
        value.filter(|v| !v.is_none()).map_or(Some(default), |v| matrix(v, 3))
    };
    const IDENTITY: [f64; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    let (Some(turn), Some(new)) = (given(r, IDENTITY), given(new, k)) else { return Ok(None) };
    let Some([width, height]) = pair(size).filter(|size| size.iter().all(|n| (1..=1 << 30).contains(n)))
    else {
        return Ok(None);
    };
    let whole = std::array::from_fn(|i| (0..3).map(|j| new[i / 3 * 3 + j] * turn[3 * j + i % 3]).sum());
    let camera = camera([k[0], k[4], k[2], k[5]], &lens, projective_inverse(whole))?;
    let kind = if kind <= 0 { CV_16SC2 } else { kind };
    let (width, height) = (width as usize, height as usize);
    filled(py, kind, [height, width], [map1, map2], &[], |target| camera.fill(width, target))
}

/// `undistort`.
#[pyfunction]
#[pyo3(signature = (src, matrix3, lens, dst, new, antialias))]
fn cv2_undistort<'py>(
    py: Python<'py>,
    src: &Bound<'py, PyAny>,
    matrix3: &Bound<'py, PyAny>,
    lens: Option<&Bound<'py, PyAny>>,
    dst: Option<&Bound<'py, PyAny>>,
    new: Option<&Bound<'py, PyAny>>,
    antialias: bool,
) -> Answer<'py> {
    let (Some(k), Some(lens)) = (matrix(matrix3, 3), coefficients(lens)) else { return Ok(None) };
    let Some(new) = new.filter(|n| !n.is_none()).map_or(Some(k), |new| matrix(new, 3)) else {
        return Ok(None);
    };
    let camera = camera([k[0], k[4], k[2], k[5]], &lens, projective_inverse(new))?;
    let Some(src) = array(src) else { return Ok(None) };
    let Some(kind) = kind(src) else { return Ok(None) };
    macro_rules! work {
        ($t:ty) => {
            undistorted::<$t>(py, src, &camera, dst, antialias)
        };
    }
    for_kind!(kind, work)
}

fn undistorted<'py, T: Element + Pixel>(
    py: Python<'py>,
    src: &Bound<'py, PyUntypedArray>,
    camera: &Camera,
    dst: Option<&Bound<'py, PyAny>>,
    antialias: bool,
) -> Answer<'py> {
    let Some(picture) = Picture::<T>::new(src) else { return Ok(None) };
    let Some(rows) = picture.rows() else { return Ok(None) };
    let rows = rows?;
    let inputs = std::slice::from_ref(&picture.span);
    let Some(out) = target::<T>(py, dst, picture.shape, inputs)? else { return Ok(None) };
    fill(py, &out, |out| camera.undistort(&rows, antialias, out))?;
    Ok(Some(out.into_any()))
}

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(cv2_convert, module)?)?;
    module.add_function(wrap_pyfunction!(cv2_rectify, module)?)?;
    module.add_function(wrap_pyfunction!(cv2_undistort, module)?)?;
    module.add_function(wrap_pyfunction!(cv2_undistortion, module)?)
}
