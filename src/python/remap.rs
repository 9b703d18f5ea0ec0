//! Plain interpolation: the base of the drop-ins.

use super::convert::work;
use crate::error::{Error, Result};
use crate::kernel::remap::Sample;
use crate::texel::f16;
use crate::warp::remap::{Edge, Grid, Interpolation, Job, Map, Outside, Source, interpolate};
use numpy::{
    Element, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray,
    PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use std::ops::Range;

/// How to read, as the front end writes it.
#[derive(FromPyObject)]
struct Manner {
    #[pyo3(item)]
    interpolation: String,
    #[pyo3(item)]
    slope: f32,
    #[pyo3(item)]
    grid: String,
    #[pyo3(item)]
    wrap: (String, String),
    #[pyo3(item)]
    outside: String,
    #[pyo3(item)]
    border: Vec<f64>,
    #[pyo3(item)]
    threads: Option<usize>,
}

/// The entry of a table that has this name.
pub(super) fn named<V: Copy>(argument: &'static str, name: &str, table: &[(&str, V)]) -> Result<V> {
    table.iter().find(|(n, _)| *n == name).map(|(_, v)| *v).ok_or_else(|| {
        let names: Vec<_> = table.iter().map(|(n, _)| format!("{n:?}")).collect();
        Error::value(argument, format!("{name:?}"), format!("one of {}", names.join(", ")))
    })
}

impl Manner {
    fn interpolation(&self) -> Result<Interpolation> {
        let table = [
            ("nearest", Interpolation::Nearest),
            ("bilinear", Interpolation::Bilinear),
            ("bicubic", Interpolation::Bicubic(self.slope)),
            ("lanczos4", Interpolation::Lanczos4),
        ];
        named("interpolation", &self.interpolation, &table)
    }

    fn grid(&self) -> Result<Grid> {
        let table = [
            ("exact", Grid::Exact),
            ("whole", Grid::Whole),
            ("thirtyseconds", Grid::Thirtyseconds),
            ("accumulated", Grid::Accumulated),
            ("accumulated_whole", Grid::AccumulatedWhole),
        ];
        named("grid", &self.grid, &table)
    }

    fn edges(&self) -> Result<[Edge; 2]> {
        let table = [
            ("border", Edge::Border),
            ("clamp", Edge::Clamp),
            ("repeat", Edge::Repeat),
            ("mirror", Edge::Mirror),
            ("mirror_once", Edge::MirrorOnce),
            ("mirror_101", Edge::Mirror101),
        ];
        Ok([named("wrap", &self.wrap.0, &table)?, named("wrap", &self.wrap.1, &table)?])
    }

    fn outside(&self) -> Result<Outside> {
        let table = [("colour", Outside::Colour), ("previous", Outside::Previous), ("keep", Outside::Keep)];
        named("outside", &self.outside, &table)
    }
}

pub(super) fn borrow<'py, T: Element>(
    array: &Bound<'py, PyUntypedArray>,
) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    Ok(array.cast::<PyArrayDyn<T>>()?.try_readonly()?)
}

pub(super) fn packed<'a, T: Element>(
    argument: &'static str,
    array: &'a PyReadonlyArrayDyn<'_, T>,
) -> Result<&'a [T]> {
    array.as_slice().map_err(|e| Error::value(argument, e, "C-contiguous memory"))
}

/// A borrowed map.
pub(super) enum MapArrays<'py> {
    Single(PyReadonlyArrayDyn<'py, f32>, Option<PyReadonlyArrayDyn<'py, f32>>),
    Double(PyReadonlyArrayDyn<'py, f64>, Option<PyReadonlyArrayDyn<'py, f64>>),
    Fixed(PyReadonlyArrayDyn<'py, i16>, Option<PyReadonlyArrayDyn<'py, u16>>),
}

impl<'py> MapArrays<'py> {
    pub(super) fn new(
        first: &Bound<'py, PyUntypedArray>,
        second: Option<&Bound<'py, PyUntypedArray>>,
    ) -> PyResult<Self> {
        let dtype = first.dtype();
        Ok(match (dtype.kind(), dtype.itemsize()) {
            (b'f', 4) => Self::Single(borrow(first)?, second.map(borrow).transpose()?),
            (b'f', 8) => Self::Double(borrow(first)?, second.map(borrow).transpose()?),
            (b'i', 2) => Self::Fixed(borrow(first)?, second.map(borrow).transpose()?),
            _ => {
                let expected = "float32, float64 or int16";
                return Err(Error::type_("map", dtype.to_string(), expected).into());
            }
        })
    }

    /// The memory of its arrays.
    pub(super) fn spans(&self) -> [Range<usize>; 2] {
        fn span<T: Element>(array: Option<&PyReadonlyArrayDyn<'_, T>>) -> Range<usize> {
            let from = array.map_or(0, |a| a.data().addr());
            from..from + array.map_or(0, |a| a.len()) * size_of::<T>()
        }
        match self {
            Self::Single(x, y) => [span(Some(x)), span(y.as_ref())],
            Self::Double(x, y) => [span(Some(x)), span(y.as_ref())],
            Self::Fixed(pairs, codes) => [span(Some(pairs)), span(codes.as_ref())],
        }
    }

    pub(super) fn map(&self) -> Result<Map<'_>> {
        Ok(match self {
            Self::Single(x, Some(y)) => Map::Single(packed("map_x", x)?, packed("map_y", y)?),
            Self::Single(pairs, None) => Map::SinglePairs(packed("map", pairs)?),
            Self::Double(x, Some(y)) => Map::Double(packed("map_x", x)?, packed("map_y", y)?),
            Self::Double(pairs, None) => Map::DoublePairs(packed("map", pairs)?),
            Self::Fixed(pairs, codes) => {
                let codes = codes.as_ref().map(|c| packed("map", c)).transpose()?;
                Map::Fixed(packed("map", pairs)?, codes)
            }
        })
    }
}

fn run<T: Sample + Element>(
    py: Python<'_>,
    image: &Bound<'_, PyUntypedArray>,
    map: &Map<'_>,
    manner: &Manner,
    out: &Bound<'_, PyUntypedArray>,
) -> PyResult<()> {
    let source = borrow::<T>(image)?;
    let (&[height, width, channels], &[_, out_width, out_channels]) = (image.shape(), out.shape()) else {
        return Err(Error::value("image", format!("shape {:?}", image.shape()), "(H, W, C)").into());
    };
    if channels != out_channels {
        return Err(Error::value("out", format!("{out_channels} channels"), channels).into());
    }
    let border: Vec<T> = manner.border.iter().map(|&v| T::put(crate::kernel::remap::Real::of(v))).collect();
    let data = packed("image", &source)?;
    let source = Source::new(data, width, height, channels, width * channels)?;
    let job = Job::new(source, manner.interpolation()?, manner.edges()?, &border, manner.outside()?)?;
    let grid = manner.grid()?;
    let mut target = out.cast::<PyArrayDyn<T>>()?.try_readwrite()?;
    let target = target.as_slice_mut().map_err(|e| Error::value("out", e, "C-contiguous memory"))?;
    work(py, manner.threads, || interpolate(&job, map, grid, out_width, target))
}

/// Reads `image` (H, W, C) at a map (two arrays, or one of pairs) or a 3x3 matrix into `out` (h, w, C).
#[pyfunction]
#[pyo3(name = "interpolate", signature = (image, first, second, matrix, manner, out))]
fn interpolate_array<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyUntypedArray>,
    first: Option<&Bound<'py, PyUntypedArray>>,
    second: Option<&Bound<'py, PyUntypedArray>>,
    matrix: Option<[f64; 9]>,
    manner: Manner,
    out: &Bound<'py, PyUntypedArray>,
) -> PyResult<()> {
    let arrays = first.map(|first| MapArrays::new(first, second)).transpose()?;
    let map = match (&arrays, &matrix) {
        (Some(arrays), None) => arrays.map()?,
        (None, Some(matrix)) => Map::Matrix(matrix),
        _ => return Err(Error::value("map", "none or both", "a map or a matrix").into()),
    };
    let dtype = image.dtype();
    match (dtype.kind(), dtype.itemsize()) {
        (b'u', 1) => run::<u8>(py, image, &map, &manner, out),
        (b'u', 2) => run::<u16>(py, image, &map, &manner, out),
        (b'i', 2) => run::<i16>(py, image, &map, &manner, out),
        (b'f', 2) => run::<f16>(py, image, &map, &manner, out),
        (b'f', 4) => run::<f32>(py, image, &map, &manner, out),
        (b'f', 8) => run::<f64>(py, image, &map, &manner, out),
        _ => Err(Error::type_(
            "image",
            format!("dtype {dtype}"),
            "dtype uint8, uint16, int16, float16, float32 or float64",
        )
        .into()),
    }
}

/// Whether a map or a matrix minifies anywhere in an output of this size.
#[pyfunction]
#[pyo3(signature = (first, second, matrix, width, height))]
fn map_minifies<'py>(
    py: Python<'py>,
    first: Option<&Bound<'py, PyUntypedArray>>,
    second: Option<&Bound<'py, PyUntypedArray>>,
    matrix: Option<[f64; 9]>,
    width: usize,
    height: usize,
) -> PyResult<bool> {
    let arrays = first.map(|first| MapArrays::new(first, second)).transpose()?;
    let map = match (&arrays, &matrix) {
        (Some(arrays), None) => arrays.map()?,
        (None, Some(matrix)) => Map::Matrix(matrix),
        _ => return Err(Error::value("map", "none or both", "a map or a matrix").into()),
    };
    Ok(py.detach(|| map.minifies(width, height))?)
}

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(interpolate_array, module)?)?;
    module.add_function(wrap_pyfunction!(map_minifies, module)?)
}
