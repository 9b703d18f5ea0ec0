//! `remap`, `warpAffine`, `warpPerspective`, `getRectSubPix`, `warpPolar`.

use super::arrays::{Answer, Picture, array, fill, for_kind, kind, matrix, pair, scalar, target};
use crate::compat::cv2::maps::Polar;
use crate::compat::cv2::read::{Manner, Pixel, Route, affine_inverse, projective_inverse, read};
use crate::error::Error;
use crate::kernel::remap::Real;
use crate::python::remap::MapArrays;
use crate::warp::remap::Map;
use numpy::{Element, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use std::ops::Range;

const INTER_MAX: i32 = 7;
const WARP_FILL_OUTLIERS: i32 = 8;
const WARP_INVERSE_MAP: i32 = 16;
const WARP_RELATIVE_MAP: i32 = 32;
const WARP_POLAR_LOG: i32 = 256;

/// Channels that a colour has; pictures of more are for the front end.
const MOST_CHANNELS: usize = 4;

/// What is given to every function here beside its map.
struct Call<'a, 'py> {
    py: Python<'py>,
    src: &'a Bound<'py, PyAny>,
    dst: Option<&'a Bound<'py, PyAny>>,
    manner: Manner,
    border: [f64; 4],
}

impl<'py> Call<'_, 'py> {
    /// A result of `size` (width, height; `None` for that of the source), read at `map`, which spans `inputs`.
    fn run(&self, size: Option<[usize; 2]>, map: &Map<'_>, inputs: &[Range<usize>]) -> Answer<'py> {
        let Some(src) = array(self.src) else { return Ok(None) };
        let Some(kind) = kind(src) else { return Ok(None) };
        macro_rules! work {
            ($t:ty) => {
                self.typed::<$t>(src, size, map, inputs)
            };
        }
        for_kind!(kind, work)
    }

    fn typed<T: Element + Pixel>(
        &self,
        src: &Bound<'py, PyUntypedArray>,
        size: Option<[usize; 2]>,
        map: &Map<'_>,
        inputs: &[Range<usize>],
    ) -> Answer<'py> {
        let Some(picture) = Picture::<T>::new(src) else { return Ok(None) };
        let Some(rows) = picture.rows() else { return Ok(None) };
        let rows = rows?;
        let [height, width, channels] = picture.shape;
        if channels > MOST_CHANNELS {
            return Ok(None);
        }
        let [width, height] = size.unwrap_or([width, height]);
        // Where nothing was given to keep, only small outputs are new zeros.
        let keeps = self.manner.edge.is_none();
        if keeps && self.dst.is_none_or(|dst| dst.is_none()) && width.saturating_mul(height) >= 1 << 18 {
            return Ok(None);
        }
        let mut spans = [picture.span.clone(), 0..0, 0..0];
        for (place, input) in spans[1..].iter_mut().zip(inputs) {
            *place = input.clone();
        }
        let used = &spans[..1 + inputs.len().min(2)];
        let Some(out) = target::<T>(self.py, self.dst, [height, width, channels], used)? else {
            return Ok(None);
        };
        let border: [T; MOST_CHANNELS] = self.border.map(|v| T::put(T::Acc::of(v)));
        let manner = &self.manner;
        let done = fill(self.py, &out, |out| read(&rows, map, manner, &border[..channels], width, out))?;
        Ok(done.then(|| out.into_any()))
    }
}

/// A size of a call: `None` in the outer place for what the front end must look at.
fn sized(dsize: &Bound<'_, PyAny>) -> Option<Option<[usize; 2]>> {
    const MOST: i64 = 1 << 30;
    match pair(dsize)? {
        [0, 0] => Some(None),
        size if size.iter().all(|n| (1..=MOST).contains(n)) => Some(Some(size.map(|n| n as usize))),
        _ => None,
    }
}

/// The arrays of a map that can be read as they lie, and its height and width.
fn map_arrays<'py>(
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
        let native = numpy::PyArrayDescrMethods::is_native_byteorder(&dtype) != Some(false);
        native.then_some((
            numpy::PyArrayDescrMethods::kind(&dtype),
            numpy::PyArrayDescrMethods::itemsize(&dtype),
        ))
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

/// `remap`.
#[pyfunction]
#[pyo3(signature = (src, map1, map2, flags, dst, border, value, antialias))]
#[expect(clippy::too_many_arguments, reason = "as many as the function that it stands for")]
fn cv2_remap<'py>(
    py: Python<'py>,
    src: &Bound<'py, PyAny>,
    map1: &Bound<'py, PyAny>,
    map2: &Bound<'py, PyAny>,
    flags: i32,
    dst: Option<&Bound<'py, PyAny>>,
    border: i32,
    value: Option<&Bound<'py, PyAny>>,
    antialias: bool,
) -> Answer<'py> {
    if flags & WARP_RELATIVE_MAP != 0 {
        return Ok(None);
    }
    let Some(border_value) = scalar(value) else { return Ok(None) };
    let Some((arrays, [height, width])) = map_arrays(map1, map2)? else { return Ok(None) };
    let manner = Manner::new(flags, border, Route::Map, antialias)?;
    let call = Call { py, src, dst, manner, border: border_value };
    call.run(Some([width, height]), &arrays.map()?, &arrays.spans())
}

/// `warpAffine` (2 rows) and `warpPerspective` (3 rows).
#[pyfunction]
#[pyo3(signature = (src, m, rows, dsize, dst, flags, border, value, antialias))]
#[expect(clippy::too_many_arguments, reason = "as many as the functions that it stands for")]
fn cv2_warp<'py>(
    py: Python<'py>,
    src: &Bound<'py, PyAny>,
    m: &Bound<'py, PyAny>,
    rows: usize,
    dsize: &Bound<'py, PyAny>,
    dst: Option<&Bound<'py, PyAny>>,
    flags: i32,
    border: i32,
    value: Option<&Bound<'py, PyAny>>,
    antialias: bool,
) -> Answer<'py> {
    let (Some(mut m), Some(size), Some(border_value)) = (matrix(m, rows), sized(dsize), scalar(value)) else {
        return Ok(None);
    };
    let inverted = flags & WARP_INVERSE_MAP == 0;
    let route = if rows == 2 {
        if inverted {
            let [a, b, c, d, e, f, ..] = m;
            m[..6].copy_from_slice(&affine_inverse([a, b, c, d, e, f]));
        }
        Route::Affine
    } else {
        if inverted {
            m = projective_inverse(m);
        }
        Route::Map
    };
    let manner = Manner::new(flags & INTER_MAX, border, route, antialias)?;
    let call = Call { py, src, dst, manner, border: border_value };
    call.run(size, &Map::Matrix(&m), &[])
}

/// `getRectSubPix` of the image's own depth.
#[pyfunction]
fn cv2_patch<'py>(
    py: Python<'py>,
    src: &Bound<'py, PyAny>,
    size: &Bound<'py, PyAny>,
    center: &Bound<'py, PyAny>,
    dst: Option<&Bound<'py, PyAny>>,
) -> Answer<'py> {
    let (Some(Some([width, height])), Ok((x, y))) =
        (sized(size).flatten().map(Some), center.extract::<(f64, f64)>())
    else {
        return Ok(None);
    };
    const REPLICATE: i32 = 1;
    let manner = Manner::new(1, REPLICATE, Route::Exact, false)?;
    let at = |c: f64, n: usize| c - 0.5 * (n as f64 - 1.0);
    let m = [1.0, 0.0, at(x, width), 0.0, 1.0, at(y, height), 0.0, 0.0, 1.0];
    let call = Call { py, src, dst, manner, border: [0.0; 4] };
    call.run(Some([width, height]), &Map::Matrix(&m), &[])
}

/// The map of `warpPolar`.
fn polar_map(
    py: Python<'_>,
    from: [usize; 2],
    size: [usize; 2],
    center: [f64; 2],
    radius: f64,
    flags: i32,
) -> PyResult<[Vec<f32>; 2]> {
    let pixels = size[0].checked_mul(size[1]).filter(|&n| n <= 1 << 40);
    let pixels = pixels.ok_or_else(|| Error::value("dsize", format!("{size:?}"), "at most 2^40 pixels"))?;
    let mut x = crate::image::zeros::<f32>("dsize", pixels)?;
    let mut y = crate::image::zeros::<f32>("dsize", pixels)?;
    let polar = Polar { center, radius, log: flags & WARP_POLAR_LOG != 0 };
    py.detach(|| {
        if flags & WARP_INVERSE_MAP != 0 {
            polar.polar(from, size, &mut x, &mut y)
        } else {
            polar.flat(size, &mut x, &mut y)
        }
    })?;
    Ok([x, y])
}

/// The map of `warpPolar`: columns and rows.
#[pyfunction]
fn cv2_polar_map<'py>(
    py: Python<'py>,
    width: usize,
    height: usize,
    dsize: (usize, usize),
    center: (f64, f64),
    radius: f64,
    flags: i32,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    let size = [dsize.0, dsize.1];
    let [x, y] = polar_map(py, [width, height], size, [center.0, center.1], radius, flags)?;
    let shape = [size[1], size[0]];
    Ok((crate::python::convert::array(py, x, &shape)?, crate::python::convert::array(py, y, &shape)?))
}

/// The inverse of a matrix of 2 x 3 or 3 x 3.
#[pyfunction]
fn cv2_inverse<'py>(py: Python<'py>, matrix: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    if let Some(m) = super::arrays::matrix(matrix, 3) {
        return crate::python::convert::array(py, projective_inverse(m).to_vec(), &[3, 3]);
    }
    let Some([a, b, c, d, e, f, ..]) = super::arrays::matrix(matrix, 2) else {
        return Err(Error::value("M", "another array", "2 x 3 or 3 x 3 numbers").into());
    };
    crate::python::convert::array(py, affine_inverse([a, b, c, d, e, f]).to_vec(), &[2, 3])
}

/// `warpPolar` of a picture of `height` rows; for the inverse `src` has a row more on each side.
#[pyfunction]
#[pyo3(signature = (src, width, height, dsize, center, radius, flags, dst, antialias))]
#[expect(clippy::too_many_arguments, reason = "as many as the function that it stands for")]
fn cv2_polar<'py>(
    py: Python<'py>,
    src: &Bound<'py, PyAny>,
    width: usize,
    height: usize,
    dsize: (usize, usize),
    center: (f64, f64),
    radius: f64,
    flags: i32,
    dst: Option<&Bound<'py, PyAny>>,
    antialias: bool,
) -> Answer<'py> {
    let size = [dsize.0, dsize.1];
    let [x, y] = polar_map(py, [width, height], size, [center.0, center.1], radius, flags)?;
    const TRANSPARENT: i32 = 5;
    let border = if flags & WARP_FILL_OUTLIERS != 0 { 0 } else { TRANSPARENT };
    let manner = Manner::new(flags & INTER_MAX, border, Route::Map, antialias)?;
    let call = Call { py, src, dst, manner, border: [0.0; 4] };
    call.run(Some(size), &Map::Single(&x, &y), &[])
}

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(cv2_remap, module)?)?;
    module.add_function(wrap_pyfunction!(cv2_warp, module)?)?;
    module.add_function(wrap_pyfunction!(cv2_patch, module)?)?;
    module.add_function(wrap_pyfunction!(cv2_polar, module)?)?;
    module.add_function(wrap_pyfunction!(cv2_polar_map, module)?)?;
    module.add_function(wrap_pyfunction!(cv2_inverse, module)?)
}
