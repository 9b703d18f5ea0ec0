//! Image warps.

use super::convert::{FloatArray, Floats, ImageArg, array, output, work};
use super::texture::Sampling;
use crate::encode::{Alpha, Encoding};
use crate::error::{Error, Result};
use crate::image::{AnyView, Element, Image, Pixels};
use crate::warp::{self, Mapping, Maps, WarpOptions};
use crate::wrap::Wrap;
use pyo3::prelude::*;

/// One array of pairs, or two arrays, of places.
enum MapArg<'py> {
    Pairs(FloatArray<'py>),
    Two(FloatArray<'py>, FloatArray<'py>),
}

/// All options of a warp but the mapping, checked.
#[pyclass(frozen, module = "multum._multum")]
pub struct Warping {
    options: WarpOptions,
    threads: Option<usize>,
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

type Period = (Option<f64>, Option<f64>);

/// Calls `job` with the mapping that the arguments hold.
fn with_mapping<R>(
    matrix: Option<[[f64; 3]; 3]>,
    maps: Option<&MapArg<'_>>,
    period: Period,
    job: impl FnOnce(Mapping<'_>) -> R,
) -> Result<R> {
    let period = [period.0, period.1];
    let mixed = || Error::type_("map_y", "another dtype than map_x", "the same dtype");
    Ok(match (matrix, maps) {
        (Some(matrix), _) => job(Mapping::from_matrix(matrix)),
        (None, Some(MapArg::Pairs(pairs))) => match pairs.floats()? {
            Floats::F32(xy) => job(Mapping::Single(Maps::pairs(xy, period))),
            Floats::F64(xy) => job(Mapping::Double(Maps::pairs(xy, period))),
        },
        (None, Some(MapArg::Two(x, y))) => match (x.floats()?, y.floats()?) {
            (Floats::F32(x), Floats::F32(y)) => job(Mapping::Single(Maps { x, y, step: 1, period })),
            (Floats::F64(x), Floats::F64(y)) => job(Mapping::Double(Maps { x, y, step: 1, period })),
            _ => return Err(mixed()),
        },
        (None, None) => return Err(Error::type_("mapping", "None", "a matrix, a map or a callable")),
    })
}

fn map_arg<'py>(
    x: Option<&Bound<'py, PyAny>>,
    y: Option<&Bound<'py, PyAny>>,
) -> PyResult<Option<MapArg<'py>>> {
    Ok(match (x, y) {
        (Some(x), Some(y)) => {
            let (x, y) =
                (FloatArray::new("map_x", x, &[], "(H, W)")?, FloatArray::new("map_y", y, &[], "(H, W)")?);
            if x.shape() != y.shape() {
                return Err(Error::value(
                    "map_y",
                    format!("shape {:?}", y.shape()),
                    format!("{:?}", x.shape()),
                )
                .into());
            }
            Some(MapArg::Two(x, y))
        }
        (Some(xy), None) => Some(MapArg::Pairs(FloatArray::new("mapping", xy, &[2], "(H, W, 2)")?)),
        _ => None,
    })
}

/// The warped image.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "one for each argument of the Python functions")]
#[pyo3(signature = (image, matrix, map_x, map_y, period, shape, warping, out))]
fn warp_image<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    matrix: Option<[[f64; 3]; 3]>,
    map_x: Option<&Bound<'py, PyAny>>,
    map_y: Option<&Bound<'py, PyAny>>,
    period: Period,
    shape: (usize, usize),
    warping: &Warping,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let image = ImageArg::new("image", image)?;
    let maps = map_arg(map_x, map_y)?;
    let call = Call {
        image: image.view()?,
        matrix,
        maps: maps.as_ref(),
        period,
        shape,
        warping,
        flat: image.is_flat,
    };
    match call.image {
        AnyView::U8(_) => call.run::<u8>(py, out),
        AnyView::U16(_) => call.run::<u16>(py, out),
        AnyView::F16(_) => call.run::<crate::texel::f16>(py, out),
        AnyView::F32(_) => call.run::<f32>(py, out),
        AnyView::F64(_) => call.run::<f64>(py, out),
    }
}

struct Call<'a> {
    image: AnyView<'a>,
    matrix: Option<[[f64; 3]; 3]>,
    maps: Option<&'a MapArg<'a>>,
    period: Period,
    shape: (usize, usize),
    warping: &'a Warping,
    flat: bool,
}

impl Call<'_> {
    fn run<'py, T: Element + numpy::Element>(
        &self,
        py: Python<'py>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (height, width) = self.shape;
        let channels = self.image.channels();
        crate::image::check_size("shape", width, height, channels)?;
        let full = [height, width, channels];
        let shape = if self.flat { &full[..2] } else { &full[..] };
        let job = |slice: &mut [T]| {
            let (image, options) = (self.image, &self.warping.options);
            with_mapping(self.matrix, self.maps, self.period, |mapping| {
                work(py, self.warping.threads, || {
                    warp::warp_into(image, &mapping, width, height, options, slice)
                })
            })
        };
        match out {
            Some(given) => {
                let mut borrowed = output::<T>("out", given, shape, T::DTYPE.name())?;
                let slice =
                    borrowed.as_slice_mut().map_err(|e| Error::value("out", e, "C-contiguous memory"))?;
                job(slice)??;
                Ok(given.clone())
            }
            None => {
                let mut made = vec![T::default(); full.iter().product()];
                job(&mut made)??;
                array(py, made, shape)
            }
        }
    }
}

/// The share of each output pixel inside an image of this shape.
#[pyfunction]
#[pyo3(signature = (image_shape, matrix, map_x, map_y, period, shape, warping))]
#[allow(clippy::too_many_arguments, reason = "one for each argument of the Python functions")]
fn warp_coverage<'py>(
    py: Python<'py>,
    image_shape: (usize, usize),
    matrix: Option<[[f64; 3]; 3]>,
    map_x: Option<&Bound<'py, PyAny>>,
    map_y: Option<&Bound<'py, PyAny>>,
    period: Period,
    shape: (usize, usize),
    warping: &Warping,
) -> PyResult<Bound<'py, PyAny>> {
    let maps = map_arg(map_x, map_y)?;
    let size = [image_shape.1, image_shape.0];
    let made = with_mapping(matrix, maps.as_ref(), period, |mapping| {
        work(py, warping.threads, || warp::coverage(size, &mapping, shape.1, shape.0, &warping.options))
    })??;
    singles(py, made, &[shape.0, shape.1])
}

fn singles<'py>(py: Python<'py>, image: Image, shape: &[usize]) -> PyResult<Bound<'py, PyAny>> {
    match image.into_pixels() {
        Pixels::F32(data) => array(py, data, shape),
        other => Err(Error::type_("coverage", format!("{other:?}"), "single floats").into()),
    }
}

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Warping>()?;
    module.add_function(wrap_pyfunction!(warp_image, module)?)?;
    module.add_function(wrap_pyfunction!(warp_coverage, module)?)
}
