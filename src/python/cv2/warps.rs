//! `remap`, `warpAffine`, `warpPerspective`, `getRectSubPix`, `warpPolar`.

use super::arrays::{Answer, Colour, Picture, array, fill, for_kind, kind, matrix, pair, target};
use super::maps::map_arrays;
use crate::compat::cv2::patch::patch;
use crate::compat::cv2::polar::Polar;
use crate::compat::cv2::read::{Manner, Pixel, Route, affine_inverse, projective_inverse, read};
use crate::error::Error;
use crate::kernel::remap::Real;
use crate::warp::remap::Map;
use numpy::{Element, PyUntypedArray};
use pyo3::prelude::*;
use std::ops::Range;

const INTER_MAX: i32 = 7;
const WARP_FILL_OUTLIERS: i32 = 8;
const WARP_INVERSE_MAP: i32 = 16;
const WARP_RELATIVE_MAP: i32 = 32;
const WARP_POLAR_LOG: i32 = 256;

/// What is given to every function here beside its map.
struct Call<'a, 'py> {
    py: Python<'py>,
    src: &'a Bound<'py, PyAny>,
    dst: Option<&'a Bound<'py, PyAny>>,
    manner: Manner,
    border: Colour,
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
        if !self.border.fits(channels) {
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
        let number = |c: usize| T::put(T::Acc::of(self.border.at(c)));
        let few: [T; 4] = std::array::from_fn(number);
        let many: Vec<T>;
        let border = match few.get(..channels) {
            Some(few) => few,
            None => {
                many = (0..channels).map(number).collect();
                &many
            }
        };
        let manner = &self.manner;
        fill(self.py, &out, |out| read(&rows, map, manner, border, width, out))?;
        Ok(Some(out.into_any()))
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
    let Some(border_value) = Colour::new(value) else { return Ok(None) };
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
    let (Some(mut m), Some(size), Some(border_value)) = (matrix(m, rows), sized(dsize), Colour::new(value))
    else {
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
    let Some(src) = array(src) else { return Ok(None) };
    let Some(kind) = kind(src) else { return Ok(None) };
    macro_rules! work {
        ($t:ty) => {
            patch_of::<$t>(py, src, [width, height], [x, y], dst)
        };
    }
    for_kind!(kind, work)
}

fn patch_of<'py, T: Element + Pixel>(
    py: Python<'py>,
    src: &Bound<'py, PyUntypedArray>,
    size: [usize; 2],
    center: [f64; 2],
    dst: Option<&Bound<'py, PyAny>>,
) -> Answer<'py> {
    let Some(picture) = Picture::<T>::new(src) else { return Ok(None) };
    let Some(rows) = picture.rows() else { return Ok(None) };
    let rows = rows?;
    let shape = [size[1], size[0], picture.shape[2]];
    let inputs = std::slice::from_ref(&picture.span);
    let Some(out) = target::<T>(py, dst, shape, inputs)? else { return Ok(None) };
    fill(py, &out, |out| patch(&rows, size, center, out))?;
    Ok(Some(out.into_any()))
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
    let call = Call { py, src, dst, manner, border: Colour::default() };
    call.run(Some(size), &Map::Single(&x, &y), &[])
}

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(cv2_remap, module)?)?;
    module.add_function(wrap_pyfunction!(cv2_warp, module)?)?;
    module.add_function(wrap_pyfunction!(cv2_patch, module)?)?;
    module.add_function(wrap_pyfunction!(cv2_polar, module)?)
}
