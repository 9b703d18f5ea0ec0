//! Drop-in interpolation and resampling for scikit-image.

use super::convert::work;
use super::remap::{borrow, named, packed};
use crate::error::{Error, Result};
use crate::kernel::Isa;
use crate::kernel::range::range;
use crate::kernel::remap::Real;
use crate::warp::band::{Band, Resample, resample};
use crate::warp::lerp::{Edge, Lerp, Position, Scaled, Source, Where, closest, linear};
use numpy::{
    Element, PyArray1, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn,
    PyReadwriteArrayDyn, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::prelude::*;

/// scikit-image's words for what lies beyond a picture.
fn edge(mode: &str) -> Result<Edge> {
    let table = [
        ("constant", Edge::Border),
        ("edge", Edge::Clamp),
        ("symmetric", Edge::Mirror),
        ("reflect", Edge::Mirror101),
        ("wrap", Edge::Repeat),
    ];
    named("mode", mode, &table)
}

type Planes<'py> = (Bound<'py, PyUntypedArray>, Bound<'py, PyUntypedArray>);

/// Columns and rows, or a matrix.
struct Places<'py> {
    matrix: Option<[f64; 9]>,
    planes: Option<[PyReadonlyArrayDyn<'py, f64>; 2]>,
}

impl<'py> Places<'py> {
    fn new(matrix: Option<[f64; 9]>, planes: Option<&Planes<'py>>) -> PyResult<Self> {
        let planes = planes.map(|(x, y)| Ok::<_, PyErr>([borrow(x)?, borrow(y)?])).transpose()?;
        Ok(Self { matrix, planes })
    }

    fn get(&self) -> Result<Where<'_>> {
        match (&self.matrix, &self.planes) {
            (Some(matrix), None) => Ok(Where::Matrix(matrix)),
            (None, Some([x, y])) => Ok(Where::Planes(packed("columns", x)?, packed("rows", y)?)),
            _ => Err(Error::value("places", "none or both", "a matrix or planes")),
        }
    }
}

fn target<'py, T: Element>(out: &Bound<'py, PyUntypedArray>) -> PyResult<PyReadwriteArrayDyn<'py, T>> {
    Ok(out.cast::<PyArrayDyn<T>>()?.try_readwrite()?)
}

fn slice_of<'a, T: Element>(out: &'a mut PyReadwriteArrayDyn<'_, T>) -> Result<&'a mut [T]> {
    out.as_slice_mut().map_err(|e| Error::value("out", e, "C-contiguous memory"))
}

fn three(array: &Bound<'_, PyUntypedArray>) -> Result<[usize; 3]> {
    let got = || Error::value("image", format!("shape {:?}", array.shape()), "(H, W, C)");
    array.shape().try_into().map_err(|_| got())
}

/// What the linear interpolation needs beside the picture and the places.
struct Manner {
    edge: Edge,
    factor: f64,
    border: f64,
    nowhere: f64,
    limits: [f64; 2],
}

fn run<S: Scaled<H> + Element, H: Position, O: Real + Element>(
    py: Python<'_>,
    image: &Bound<'_, PyUntypedArray>,
    places: &Places<'_>,
    manner: &Manner,
    out: &Bound<'_, PyUntypedArray>,
) -> PyResult<()> {
    let [height, width, channels] = three(image)?;
    let data = borrow::<S>(image)?;
    let lerp = Lerp {
        source: Source::new(packed("image", &data)?, width, height, channels, width * channels)?,
        edges: [manner.edge; 2],
        factor: H::of(manner.factor),
        border: H::of(manner.border),
        nowhere: O::of(manner.nowhere),
        limits: manner.limits,
    };
    let [_, out_width, out_channels] = three(out)?;
    if out_channels != channels {
        return Err(Error::value("out", format!("{out_channels} channels"), channels).into());
    }
    let mut target = target::<O>(out)?;
    let (target, places) = (slice_of(&mut target)?, places.get()?);
    work(py, None, || linear(&lerp, places, out_width, target))
}

fn unknown(image: &Bound<'_, PyUntypedArray>, expected: &str) -> PyErr {
    Error::type_("image", format!("dtype {}", image.dtype()), format!("dtype {expected}")).into()
}

/// Linear interpolation of `image` (H, W, C) at a matrix or at planes of columns and rows into `out` (h, w, C),
/// which is double, or single for single images. Positions of a matrix are computed in the type of `out`.
#[pyfunction]
#[pyo3(signature = (image, matrix, planes, mode, factor, border, nowhere, limits, out))]
#[expect(clippy::too_many_arguments, reason = "the front end names them all")]
fn lerp_image<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyUntypedArray>,
    matrix: Option<[f64; 9]>,
    planes: Option<Planes<'py>>,
    mode: &str,
    factor: f64,
    border: f64,
    nowhere: f64,
    limits: [f64; 2],
    out: &Bound<'py, PyUntypedArray>,
) -> PyResult<()> {
    let places = Places::new(matrix, planes.as_ref())?;
    let manner = Manner { edge: edge(mode)?, factor, border, nowhere, limits };
    let dtype = image.dtype();
    match (dtype.kind(), dtype.itemsize(), places.planes.is_some()) {
        (b'u', 1, _) => run::<u8, f64, f64>(py, image, &places, &manner, out),
        (b'u', 2, _) => run::<u16, f64, f64>(py, image, &places, &manner, out),
        (b'f', 8, _) => run::<f64, f64, f64>(py, image, &places, &manner, out),
        (b'f', 4, true) => run::<f32, f64, f32>(py, image, &places, &manner, out),
        (b'f', 4, false) => run::<f32, f32, f32>(py, image, &places, &manner, out),
        _ => Err(unknown(image, "uint8, uint16, float32 or float64")),
    }
}

fn copy<T: Element + Copy>(
    py: Python<'_>,
    image: &Bound<'_, PyUntypedArray>,
    places: &Places<'_>,
    edge: Edge,
    border: &Bound<'_, PyUntypedArray>,
    out: &Bound<'_, PyUntypedArray>,
) -> PyResult<()> {
    let [height, width, channels] = three(image)?;
    let (data, border) = (borrow::<T>(image)?, borrow::<T>(border)?);
    let source = Source::new(packed("image", &data)?, width, height, channels, width * channels)?;
    let [_, out_width, out_channels] = three(out)?;
    if out_channels != channels {
        return Err(Error::value("out", format!("{out_channels} channels"), channels).into());
    }
    let mut target = target::<T>(out)?;
    let (target, places, border) = (slice_of(&mut target)?, places.get()?, packed("border", &border)?);
    work(py, None, || closest(&source, [edge; 2], border, places, out_width, target))
}

/// The nearest pixels of `image` (H, W, C) of unsigned integers, which may stand for anything, at a matrix or at
/// planes of columns and rows, into `out` (h, w, C); `border` (C) is what lies beyond.
#[pyfunction]
#[pyo3(signature = (image, matrix, planes, mode, border, out))]
fn nearest_image<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyUntypedArray>,
    matrix: Option<[f64; 9]>,
    planes: Option<Planes<'py>>,
    mode: &str,
    border: &Bound<'py, PyUntypedArray>,
    out: &Bound<'py, PyUntypedArray>,
) -> PyResult<()> {
    let (places, edge) = (Places::new(matrix, planes.as_ref())?, edge(mode)?);
    let dtype = image.dtype();
    match (dtype.kind(), dtype.itemsize()) {
        (b'u', 1) => copy::<u8>(py, image, &places, edge, border, out),
        (b'u', 2) => copy::<u16>(py, image, &places, edge, border, out),
        (b'u', 4) => copy::<u32>(py, image, &places, edge, border, out),
        (b'u', 8) => copy::<u64>(py, image, &places, edge, border, out),
        _ => Err(unknown(image, "uint8, uint16, uint32 or uint64")),
    }
}

/// Rows of a banded matrix: first taps and weights.
#[derive(FromPyObject)]
struct Rows<'py>(Bound<'py, PyArray1<i64>>, Bound<'py, PyUntypedArray>);

struct Borrowed<'py>(PyReadonlyArrayDyn<'py, i64>, PyReadonlyArrayDyn<'py, f64>);

impl<'py> Borrowed<'py> {
    fn new(rows: &Rows<'py>) -> PyResult<Self> {
        Ok(Self(borrow(rows.0.as_untyped())?, borrow(&rows.1)?))
    }

    fn band(&self, edge: Edge, size: usize) -> Result<Band<'_>> {
        Band::new(packed("first", &self.0)?, packed("weights", &self.1)?, edge, size)
    }
}

fn sums<S: Scaled<f64> + Element, O: Real + Element>(
    py: Python<'_>,
    image: &Bound<'_, PyUntypedArray>,
    bands: (&Borrowed<'_>, Option<&Borrowed<'_>>),
    edge: Edge,
    numbers: (f64, f64, [f64; 2]),
    out: &Bound<'_, PyUntypedArray>,
) -> PyResult<()> {
    let [height, width, channels] = three(image)?;
    let data = borrow::<S>(image)?;
    let job = Resample {
        data: packed("image", &data)?,
        channels,
        down: bands.0.band(edge, height)?,
        across: bands.1.map(|band| band.band(edge, width)).transpose()?,
        width,
        factor: numbers.0,
        border: numbers.1,
        limits: numbers.2,
    };
    let mut target = target::<O>(out)?;
    let target = slice_of(&mut target)?;
    work(py, None, || resample(&job, target))
}

/// Applies banded matrices to the columns and rows of `image` (H, W, C), into `out` (h, w, C) of doubles, or of
/// singles for single images. `numbers` are what a unit of an integer stands for, the number
/// beyond, and the least and the greatest result.
#[pyfunction]
#[pyo3(signature = (image, down, across, mode, numbers, out))]
fn resample_image<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyUntypedArray>,
    down: Rows<'py>,
    across: Option<Rows<'py>>,
    mode: &str,
    numbers: (f64, f64, [f64; 2]),
    out: &Bound<'py, PyUntypedArray>,
) -> PyResult<()> {
    let down = Borrowed::new(&down)?;
    let across = across.as_ref().map(Borrowed::new).transpose()?;
    let (bands, edge) = ((&down, across.as_ref()), edge(mode)?);
    let dtype = image.dtype();
    match (dtype.kind(), dtype.itemsize()) {
        (b'u', 1) => sums::<u8, f64>(py, image, bands, edge, numbers, out),
        (b'u', 2) => sums::<u16, f64>(py, image, bands, edge, numbers, out),
        (b'f', 4) => sums::<f32, f32>(py, image, bands, edge, numbers, out),
        (b'f', 8) => sums::<f64, f64>(py, image, bands, edge, numbers, out),
        _ => Err(unknown(image, "uint8, uint16, float32 or float64")),
    }
}

/// Least and greatest number of an array of singles or doubles, and whether there are NaN, which do not count.
#[pyfunction]
fn value_range(py: Python<'_>, array: &Bound<'_, PyUntypedArray>) -> PyResult<(f64, f64, bool)> {
    if array.dtype().itemsize() == 4 {
        let data = borrow::<f32>(array)?;
        let data = packed("array", &data)?;
        let (low, high, nan) = py.detach(|| range(Isa::current(), data));
        return Ok((f64::from(low), f64::from(high), nan));
    }
    let data = borrow::<f64>(array)?;
    let data = packed("array", &data)?;
    Ok(py.detach(|| range(Isa::current(), data)))
}

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(lerp_image, module)?)?;
    module.add_function(wrap_pyfunction!(nearest_image, module)?)?;
    module.add_function(wrap_pyfunction!(resample_image, module)?)?;
    module.add_function(wrap_pyfunction!(value_range, module)?)
}
