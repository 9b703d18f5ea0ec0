//! `resize`.

use super::arrays::{Answer, Picture, array, fill, for_kind, kind, pair, target};
use crate::compat::cv2::pyramid::Element as Smooth;
use crate::compat::cv2::read::Pixel;
use crate::compat::cv2::resize::{Nearest, Scaling, pick, resize};
use numpy::{Element, PyUntypedArray};
use pyo3::prelude::*;

/// What the call says beside the picture.
struct Call<'a, 'py> {
    py: Python<'py>,
    size: Option<[i64; 2]>,
    factors: [f64; 2],
    interpolation: i32,
    dst: Option<&'a Bound<'py, PyAny>>,
    antialias: bool,
}

impl<'py> Call<'_, 'py> {
    fn typed<T: Element + Pixel + Smooth>(&self, src: &Bound<'py, PyUntypedArray>) -> Answer<'py> {
        let Some(picture) = Picture::<T>::new(src) else { return Ok(None) };
        let Some(rows) = picture.rows() else { return Ok(None) };
        let rows = rows?;
        let [height, width, channels] = picture.shape;
        let to = Scaling::new([width, height], self.size, self.factors)?;
        let shape = [to.size[1], to.size[0], channels];
        let inputs = std::slice::from_ref(&picture.span);
        let Some(out) = target::<T>(self.py, self.dst, shape, inputs)? else { return Ok(None) };
        let nearest = match self.interpolation {
            0 => Some(Nearest::Corner),
            6 => Some(Nearest::Center),
            _ => None,
        };
        let (interpolation, antialias) = (self.interpolation, self.antialias);
        fill(self.py, &out, |out| match nearest {
            Some(nearest) => pick(&rows, &to, nearest, out),
            None => resize(&rows, &to, interpolation, antialias, out),
        })?;
        Ok(Some(out.into_any()))
    }
}

/// `resize`.
#[pyfunction]
#[pyo3(signature = (src, dsize, dst, fx, fy, interpolation, antialias))]
#[expect(clippy::too_many_arguments, reason = "as many as the function that it stands for")]
fn cv2_resize<'py>(
    py: Python<'py>,
    src: &Bound<'py, PyAny>,
    dsize: Option<&Bound<'py, PyAny>>,
    dst: Option<&Bound<'py, PyAny>>,
    fx: f64,
    fy: f64,
    interpolation: i32,
    antialias: bool,
) -> Answer<'py> {
    let size = match dsize.filter(|d| !d.is_none()) {
        None => None,
        Some(dsize) => match pair(dsize) {
            None => return Ok(None),
            // Two zeros ask for the factors.
            Some([0, 0]) => None,
            size => size,
        },
    };
    let Some(src) = array(src) else { return Ok(None) };
    let Some(kind) = kind(src) else { return Ok(None) };
    let call = Call { py, size, factors: [fx, fy], interpolation, dst, antialias };
    macro_rules! work {
        ($t:ty) => {
            call.typed::<$t>(src)
        };
    }
    for_kind!(kind, work)
}

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(cv2_resize, module)?)
}
