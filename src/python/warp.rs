//! Image warps.

use super::convert::{FloatArray, Floats, ImageArg, array, output, work};
use super::texture::{Sampling, efforts};
use crate::encode::{Alpha, Encoding};
use crate::error::Error;
use crate::image::{AnyView, Element, Pixels};
use crate::kernel::remap::Sample;
use crate::texel::f16;
use crate::warp::{self, Mapping, Maps, WarpOptions};
use crate::wrap::Wrap;
use pyo3::prelude::*;

/// All options of a warp but the mapping, checked.
#[pyclass(frozen, module = "multum._multum")]
pub struct Warping {
    pub(super) options: WarpOptions,
    pub(super) threads: Option<usize>,
}

#[pymethods]
impl Warping {
    #[new]
    fn new(
        sampling: &Sampling,
        wrap: (String, String),
        border: Vec<f64>,
        encoding: &str,
        alpha: &str,
    ) -> PyResult<Self> {
        let options = WarpOptions {
            sampler: sampling.sampler,
            wrap: [Wrap::parse("wrap", &wrap.0)?, Wrap::parse("wrap", &wrap.1)?],
            border,
            encoding: Encoding::parse("encoding", encoding)?,
            alpha: Alpha::parse("alpha", alpha)?,
        };
        Ok(Self { options, threads: sampling.threads })
    }
}

/// Where each output pixel lies: a matrix, an array of pairs, or two arrays.
#[pyclass(frozen, module = "multum._multum")]
pub struct Places {
    matrix: Option<[[f64; 3]; 3]>,
    map_x: Option<Py<PyAny>>,
    map_y: Option<Py<PyAny>>,
    period: [Option<f64>; 2],
}

#[pymethods]
impl Places {
    #[new]
    #[pyo3(signature = (matrix, map_x, map_y, period))]
    fn new(
        matrix: Option<[[f64; 3]; 3]>,
        map_x: Option<Py<PyAny>>,
        map_y: Option<Py<PyAny>>,
        period: (Option<f64>, Option<f64>),
    ) -> Self {
        Self { matrix, map_x, map_y, period: [period.0, period.1] }
    }
}

impl Places {
    /// Calls `job` with the mapping, its arrays borrowed.
    fn with<R>(&self, py: Python<'_>, job: impl FnOnce(Mapping<'_>) -> PyResult<R>) -> PyResult<R> {
        let period = self.period;
        let array = |argument, value: &Option<Py<PyAny>>, trailing: &[usize], name| {
            value.as_ref().map(|v| FloatArray::new(argument, v.bind(py), trailing, name)).transpose()
        };
        if let Some(matrix) = self.matrix {
            return job(Mapping::from_matrix(matrix));
        }
        if self.map_y.is_none() {
            let Some(pairs) = array("mapping", &self.map_x, &[2], "(H, W, 2)")? else {
                return Err(Error::type_("mapping", "None", "a matrix, a map or a callable").into());
            };
            return match pairs.floats()? {
                Floats::F32(xy) => job(Mapping::Single(Maps::pairs(xy, period))),
                Floats::F64(xy) => job(Mapping::Double(Maps::pairs(xy, period))),
            };
        }
        let (x, y) =
            (array("map_x", &self.map_x, &[], "(H, W)")?, array("map_y", &self.map_y, &[], "(H, W)")?);
        let (Some(x), Some(y)) = (x, y) else {
            return Err(Error::type_("map_x", "None", "an array").into());
        };
        if x.shape() != y.shape() {
            return Err(
                Error::value("map_y", format!("shape {:?}", y.shape()), format!("{:?}", x.shape())).into()
            );
        }
        match (x.floats()?, y.floats()?) {
            (Floats::F32(x), Floats::F32(y)) => job(Mapping::Single(Maps { x, y, step: 1, period })),
            (Floats::F64(x), Floats::F64(y)) => job(Mapping::Double(Maps { x, y, step: 1, period })),
            _ => Err(Error::type_("map_y", "another dtype than map_x", "the same dtype").into()),
        }
    }
}

/// The warped image.
#[pyfunction]
#[pyo3(signature = (image, places, shape, warping, out))]
fn warp_image<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    places: &Places,
    shape: (usize, usize),
    warping: &Warping,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let image = ImageArg::new("image", image)?;
    let (view, flat) = (image.view()?, image.is_flat);
    match view {
        AnyView::U8(_) => warp_typed::<u8>(py, view, flat, places, shape, warping, out),
        AnyView::U16(_) => warp_typed::<u16>(py, view, flat, places, shape, warping, out),
        AnyView::F16(_) => warp_typed::<f16>(py, view, flat, places, shape, warping, out),
        AnyView::F32(_) => warp_typed::<f32>(py, view, flat, places, shape, warping, out),
        AnyView::F64(_) => warp_typed::<f64>(py, view, flat, places, shape, warping, out),
    }
}

fn warp_typed<'py, T: Element + Sample + numpy::Element>(
    py: Python<'py>,
    image: AnyView<'_>,
    flat: bool,
    places: &Places,
    (height, width): (usize, usize),
    warping: &Warping,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let channels = image.channels();
    crate::image::check_size("shape", width, height, channels)?;
    let full = [height, width, channels];
    let shape = if flat { &full[..2] } else { &full[..] };
    let job = |slice: &mut [T]| {
        let options = &warping.options;
        places.with(py, |mapping| {
            work(py, warping.threads, || warp::warp_into(image, &mapping, width, height, options, slice))
        })
    };
    match out {
        Some(given) => {
            let mut borrowed = output::<T>("out", given, shape, T::DTYPE.name())?;
            let slice = borrowed.as_slice_mut().map_err(|e| Error::value("out", e, "C-contiguous memory"))?;
            job(slice)?;
            Ok(given.clone())
        }
        None => {
            let mut made = crate::image::zeros::<T>("shape", full.iter().product())?;
            job(&mut made)?;
            array(py, made, shape)
        }
    }
}

/// The share of each output pixel inside an image of this shape.
#[pyfunction]
fn warp_coverage<'py>(
    py: Python<'py>,
    image_shape: (usize, usize),
    places: &Places,
    shape: (usize, usize),
    warping: &Warping,
) -> PyResult<Bound<'py, PyAny>> {
    let size = [image_shape.1, image_shape.0];
    let made = places.with(py, |mapping| {
        work(py, warping.threads, || warp::coverage(size, &mapping, shape.1, shape.0, &warping.options))
    })?;
    match made.into_pixels() {
        Pixels::F32(data) => array(py, data, &[shape.0, shape.1]),
        other => Err(Error::type_("coverage", format!("{other:?}"), "single floats").into()),
    }
}

/// Cost and level of each pixel of a warp.
#[pyfunction]
fn warp_survey<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    places: &Places,
    shape: (usize, usize),
    warping: &Warping,
) -> PyResult<Bound<'py, PyAny>> {
    let image = ImageArg::new("image", image)?;
    let view = image.view()?;
    let made = places.with(py, |mapping| {
        work(py, warping.threads, || warp::survey(view, &mapping, shape.1, shape.0, &warping.options))
    })?;
    efforts(py, &made, &[shape.0, shape.1])
}

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Warping>()?;
    module.add_class::<Places>()?;
    module.add_function(wrap_pyfunction!(warp_image, module)?)?;
    module.add_function(wrap_pyfunction!(warp_coverage, module)?)?;
    module.add_function(wrap_pyfunction!(warp_survey, module)?)
}
