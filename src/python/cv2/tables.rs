//! `pyrDown`, `pyrUp`, `integral`.

use super::arrays::{Answer, Kind, Picture, array, fill, for_kind, kind, target};
use crate::compat::cv2::integral::{Stored, Sum, Term, tilted, upright};
use crate::compat::cv2::pyramid::{Element as Smooth, down, up};
use crate::error::{Error, Result};
use crate::wrap::Wrap;
use numpy::{Element, PyUntypedArray};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// The wrap mode of a border flag that shows pixels.
fn wrap(border: i32) -> Result<Wrap> {
    Ok(match border {
        1 => Wrap::Clamp,
        2 => Wrap::Mirror,
        3 => Wrap::Repeat,
        4 => Wrap::Mirror101,
        _ => {
            let expected = "BORDER_REPLICATE, BORDER_REFLECT, BORDER_WRAP or BORDER_REFLECT_101";
            return Err(Error::value("borderType", border, expected));
        }
    })
}

fn pyramid_of<'py, T: Element + Smooth>(
    py: Python<'py>,
    src: &Bound<'py, PyUntypedArray>,
    dst: Option<&Bound<'py, PyAny>>,
    size: Option<(i64, i64)>,
    border: i32,
    enlarge: bool,
) -> Answer<'py> {
    let Some(picture) = Picture::<T>::new(src) else { return Ok(None) };
    let Some(rows) = picture.rows() else { return Ok(None) };
    let rows = rows?;
    let [height, width, channels] = picture.shape;
    let auto = |n: usize| if enlarge { n.saturating_mul(2) } else { n.div_ceil(2) };
    let size = match size {
        // As in OpenCV, one zero is enough to ask for the usual size.
        None => [auto(width), auto(height)],
        Some((w, h)) if w == 0 || h == 0 => [auto(width), auto(height)],
        Some((w, h)) => [usize::try_from(w).unwrap_or(0), usize::try_from(h).unwrap_or(0)],
    };
    let wrap = wrap(border)?;
    if enlarge && wrap != Wrap::Mirror101 {
        return Err(Error::value("borderType", border, "BORDER_REFLECT_101").into());
    }
    // Before anything is allocated.
    let fits =
        if enlarge { crate::compat::cv2::pyramid::up_fits } else { crate::compat::cv2::pyramid::down_fits };
    if !fits(width, size[0]) || !fits(height, size[1]) {
        let got = format!("{} x {} for {width} x {height}", size[0], size[1]);
        let expected = if enlarge {
            "twice each side, or an odd number next to it"
        } else {
            "half of each side, or a pixel more or less"
        };
        return Err(Error::value("dstsize", got, expected).into());
    }
    let Some(out) = target::<T>(py, dst, [size[1], size[0], channels], std::slice::from_ref(&picture.span))?
    else {
        return Ok(None);
    };
    fill(py, &out, |out| if enlarge { up(rows, size, out) } else { down(rows, wrap, size, out) })?;
    Ok(Some(out.into_any()))
}

/// `pyrDown`, or with `enlarge` `pyrUp`.
#[pyfunction]
#[pyo3(signature = (src, dst, size, border, enlarge))]
fn cv2_pyramid<'py>(
    py: Python<'py>,
    src: &Bound<'py, PyAny>,
    dst: Option<&Bound<'py, PyAny>>,
    size: Option<(i64, i64)>,
    border: i32,
    enlarge: bool,
) -> Answer<'py> {
    let Some(src) = array(src) else { return Ok(None) };
    let Some(kind) = kind(src) else { return Ok(None) };
    macro_rules! work {
        ($t:ty) => {
            pyramid_of::<$t>(py, src, dst, size, border, enlarge)
        };
    }
    for_kind!(kind, work)
}

/// The tables asked for, each with what was given to receive it.
struct Tables<'a, 'py> {
    py: Python<'py>,
    given: [Option<&'a Bound<'py, PyAny>>; 3],
    wanted: usize,
}

impl<'py> Tables<'_, 'py> {
    /// `T`: of pixels; `S`, `O`: how sums are kept and stored; `R`, `Q`: the same of squares.
    fn make<T, S, O, R, Q>(&self, src: &Bound<'py, PyUntypedArray>) -> Answer<'py>
    where
        T: Element + Term<S> + Term<R> + Sync,
        S: Sum,
        R: Sum,
        O: Element + Stored<S>,
        Q: Element + Stored<R>,
    {
        let Some(picture) = Picture::<T>::new(src) else { return Ok(None) };
        let Some(rows) = picture.rows() else { return Ok(None) };
        let rows = rows?;
        let shape = [picture.shape[0] + 1, picture.shape[1] + 1, picture.shape[2]];
        let py = self.py;
        let inputs = std::slice::from_ref(&picture.span);
        let Some(sum) = target::<O>(py, self.given[0], shape, inputs)? else { return Ok(None) };
        if self.wanted == 1 {
            fill(py, &sum, |out| upright::<T, S, O, false>(rows, out))?;
            return Ok(Some(sum.into_any()));
        }
        let Some(square) = target::<Q>(py, self.given[1], shape, inputs)? else { return Ok(None) };
        let slanted = match self.wanted {
            2 => None,
            _ => match target::<O>(py, self.given[2], shape, inputs)? {
                None => return Ok(None),
                slanted => slanted,
            },
        };
        fill(py, &sum, |out| upright::<T, S, O, false>(rows, out))?;
        fill(py, &square, |out| upright::<T, R, Q, true>(rows, out))?;
        let Some(slanted) = slanted else {
            return Ok(Some((sum, square).into_pyobject(py)?.into_any()));
        };
        fill(py, &slanted, |out| tilted::<T, S, O>(rows, out))?;
        Ok(Some((sum, square, slanted).into_pyobject(py)?.into_any()))
    }
}

/// `integral`, `integral2`, `integral3`: as many tables as `given` has places.
#[pyfunction]
#[pyo3(signature = (src, given, sum_depth, square_depth))]
fn cv2_integral<'py>(
    py: Python<'py>,
    src: &Bound<'py, PyAny>,
    given: &Bound<'py, PyTuple>,
    sum_depth: i32,
    square_depth: i32,
) -> Answer<'py> {
    let Some(src) = array(src) else { return Ok(None) };
    let Some(kind) = kind(src) else { return Ok(None) };
    let items: Vec<_> = given.iter().collect();
    let mut places = [None; 3];
    for (place, item) in places.iter_mut().zip(&items) {
        *place = Some(item);
    }
    let tables = Tables { py, given: places, wanted: items.len() };
    const I32: i32 = 4;
    const F32: i32 = 5;
    const F64: i32 = 6;
    let sum_depth = match sum_depth {
        ..=0 if kind == Kind::U8 => I32,
        ..=0 => F64,
        depth => depth,
    };
    let square_depth = if square_depth <= 0 { F64 } else { square_depth };
    match (kind, sum_depth, square_depth) {
        (Kind::U8, I32, I32) => tables.make::<u8, i32, i32, i32, i32>(src),
        (Kind::U8, I32, F32) => tables.make::<u8, i32, i32, f64, f32>(src),
        (Kind::U8, I32, F64) => tables.make::<u8, i32, i32, f64, f64>(src),
        (Kind::U8, F32, F32) => tables.make::<u8, f64, f32, f64, f32>(src),
        (Kind::U8, F32, F64) => tables.make::<u8, f64, f32, f64, f64>(src),
        (Kind::U8, F64, F64) => tables.make::<u8, f64, f64, f64, f64>(src),
        (Kind::U16, F64, F64) => tables.make::<u16, f64, f64, f64, f64>(src),
        (Kind::I16, F64, F64) => tables.make::<i16, f64, f64, f64, f64>(src),
        (Kind::F16, F64, F64) => tables.make::<half::f16, f64, f64, f64, f64>(src),
        (Kind::F32, F32, F32) => tables.make::<f32, f64, f32, f64, f32>(src),
        (Kind::F32, F32, F64) => tables.make::<f32, f64, f32, f64, f64>(src),
        (Kind::F32, F64, F64) => tables.make::<f32, f64, f64, f64, f64>(src),
        (Kind::F64, F64, F64) => tables.make::<f64, f64, f64, f64, f64>(src),
        _ => {
            let got = format!("{sum_depth} and {square_depth} for {kind:?}");
            let expected = "CV_64F and CV_64F; for uint8 also CV_32S with any, CV_32F with CV_32F or CV_64F; for \
                            float32 also CV_32F with CV_32F or CV_64F";
            Err(Error::value("sdepth, sqdepth", got, expected).into())
        }
    }
}

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(cv2_pyramid, module)?)?;
    module.add_function(wrap_pyfunction!(cv2_integral, module)?)
}
