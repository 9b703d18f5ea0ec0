//! Arrays as they lie, or not at all.

use crate::compat::cv2::Rows;
use crate::error::{Error, Result};
use crate::python::convert::work;
use numpy::{
    Element, PyArray, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray,
    PyUntypedArrayMethods,
};
use pyo3::PyTypeInfo;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::ops::Range;

/// Elements of output below which the interpreter is not let go: it would take longer than the work.
const SMALL: usize = 1 << 14;

/// A result, or `None` where the arguments are not in the form that is read.
pub type Answer<'py> = PyResult<Option<Bound<'py, PyAny>>>;

/// Element types of images.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kind {
    U8,
    U16,
    I16,
    F16,
    F32,
    F64,
}

/// Calls `$work!(type)` for the element type of a [`Kind`].
macro_rules! for_kind {
    ($kind:expr, $work:ident) => {
        match $kind {
            $crate::python::cv2::arrays::Kind::U8 => $work!(u8),
            $crate::python::cv2::arrays::Kind::U16 => $work!(u16),
            $crate::python::cv2::arrays::Kind::I16 => $work!(i16),
            $crate::python::cv2::arrays::Kind::F16 => $work!(half::f16),
            $crate::python::cv2::arrays::Kind::F32 => $work!(f32),
            $crate::python::cv2::arrays::Kind::F64 => $work!(f64),
        }
    };
}
pub(super) use for_kind;

/// An array, if the object is one and nothing derived from it.
pub fn array<'a, 'py>(value: &'a Bound<'py, PyAny>) -> Option<&'a Bound<'py, PyUntypedArray>> {
    // Subclasses may mean something else by the same memory: masks, matrices, units.
    let array = value.cast::<PyUntypedArray>().ok()?;
    let plain = array.get_type().is(PyUntypedArray::type_object(value.py()));
    plain.then_some(array)
}

/// The element type of an array, if it is one of images and of native byte order.
pub fn kind(array: &Bound<'_, PyUntypedArray>) -> Option<Kind> {
    let dtype = array.dtype();
    let kind = match (dtype.kind(), dtype.itemsize()) {
        (b'u', 1) => Kind::U8,
        (b'u', 2) => Kind::U16,
        (b'i', 2) => Kind::I16,
        (b'f', 2) => Kind::F16,
        (b'f', 4) => Kind::F32,
        (b'f', 8) => Kind::F64,
        _ => return None,
    };
    (dtype.is_native_byteorder() != Some(false)).then_some(kind)
}

/// A borrowed image of packed pixels, in rows that may stand apart.
pub struct Picture<'py, T: Element> {
    array: PyReadonlyArrayDyn<'py, T>,
    start: usize,
    stride: usize,
    /// Height, width, channels.
    pub shape: [usize; 3],
    /// The addresses that it spans.
    pub span: Range<usize>,
}

impl<'py, T: Element> Picture<'py, T> {
    /// Borrows an image, or a rectangle of one, where it lies.
    pub fn new(array: &Bound<'py, PyUntypedArray>) -> Option<Self> {
        let array = array.cast::<PyArrayDyn<T>>().ok()?;
        let shape = match *array.shape() {
            [h, w] => [h, w, 1],
            [h, w, c] => [h, w, c],
            _ => return None,
        };
        let [height, width, channels] = shape;
        if height == 0 || width == 0 || channels == 0 || !array.is_aligned() {
            return None;
        }
        let size = size_of::<T>();
        let from = array.data().addr();
        if array.is_c_contiguous() {
            let span = from..from + array.len() * size;
            let stride = width * channels;
            return Some(Self { array: array.try_readonly().ok()?, start: 0, stride, shape, span });
        }
        let strides = array.strides();
        let packed = |axis: usize, step: usize| {
            shape[axis] == 1 || strides.get(axis).is_none_or(|&s| s == step as isize)
        };
        let stride = usize::try_from(strides[0]).ok().filter(|s| s % size == 0).map(|s| s / size)?;
        if !packed(1, channels * size) || !packed(2, size) || stride < width * channels {
            return None;
        }
        // What lies between the rows belongs to the whole that this is a rectangle of.
        let base = array.getattr("base").ok()?;
        let base = base.cast::<PyArrayDyn<T>>().ok()?;
        let span = from..from + ((height - 1) * stride + width * channels) * size;
        let whole = base.data().addr();
        let inside = span.start >= whole && span.end <= whole + base.len() * size;
        if !base.is_c_contiguous() || !inside || !(span.start - whole).is_multiple_of(size) {
            return None;
        }
        let start = (span.start - whole) / size;
        Some(Self { array: base.try_readonly().ok()?, start, stride, shape, span })
    }

    /// The elements from the first to the last, and the step from row to row.
    pub fn data(&self) -> Option<(&[T], usize)> {
        let [height, width, channels] = self.shape;
        let length = (height - 1) * self.stride + width * channels;
        Some((self.array.as_slice().ok()?.get(self.start..self.start + length)?, self.stride))
    }

    /// The rows.
    pub fn rows(&self) -> Option<Result<Rows<'_, T>>> {
        let [height, width, channels] = self.shape;
        let (data, stride) = self.data()?;
        Some(Rows::new(data, width, height, channels, stride))
    }
}

/// The array to fill: a new one where none was given or it has another shape or dtype (as OpenCV does), the one
/// given where it can be written as it lies and shares no memory with `inputs`, or `None`.
pub fn target<'py, T: Element>(
    py: Python<'py>,
    given: Option<&Bound<'py, PyAny>>,
    shape: [usize; 3],
    inputs: &[Range<usize>],
) -> PyResult<Option<Bound<'py, PyArrayDyn<T>>>> {
    let flat = &shape[..2];
    if let Some(given) = given.filter(|g| !g.is_none()) {
        let Some(given) = array(given) else { return Ok(None) };
        if given.shape() == shape || (shape[2] == 1 && given.shape() == flat) {
            if let Ok(typed) = given.cast::<PyArrayDyn<T>>() {
                let from = typed.data().addr();
                let to = from + typed.len() * size_of::<T>();
                let apart = inputs.iter().all(|i| to <= i.start || i.end <= from);
                let usable = typed.is_c_contiguous() && typed.is_aligned() && apart;
                return Ok(usable.then(|| typed.clone()));
            }
            if given.dtype().is_native_byteorder() == Some(false) {
                return Ok(None);
            }
        }
    }
    let flat = if shape[2] == 1 { flat } else { &shape[..] };
    if shape.iter().try_fold(1, |n: usize, &s| n.checked_mul(s)).is_some_and(|n| n < 1 << 20) {
        return Ok(Some(PyArray::zeros(py, flat, false)));
    }
    // NumPy raises MemoryError where this much cannot be had.
    let made = py.import("numpy")?.call_method1("empty", (flat.into_pyobject(py)?, T::get_dtype(py)))?;
    Ok(Some(made.cast_into()?))
}

/// Runs work on an output's elements.
pub fn fill<'py, T: Element, R: Send>(
    py: Python<'py>,
    out: &Bound<'py, PyArrayDyn<T>>,
    job: impl FnOnce(&mut [T]) -> Result<R> + Send,
) -> PyResult<R> {
    let mut borrowed = out.try_readwrite().map_err(|e| Error::value("dst", e, "a writable array"))?;
    let slice = borrowed.as_slice_mut().map_err(|e| Error::value("dst", e, "C-contiguous memory"))?;
    if slice.len() < SMALL { Ok(job(slice)?) } else { work(py, None, || job(slice)) }
}

/// Two whole numbers of a tuple or list.
pub fn pair(value: &Bound<'_, PyAny>) -> Option<[i64; 2]> {
    value.extract::<(i64, i64)>().ok().map(|(a, b)| [a, b])
}

/// A colour as OpenCV's scalars are written, of any number of channels.
#[derive(Clone, Debug, Default)]
pub struct Colour {
    first: [f64; 4],
    more: Vec<f64>,
}

impl Colour {
    /// From nothing, one number, or a tuple; `None` for what the front end must look at.
    pub fn new(value: Option<&Bound<'_, PyAny>>) -> Option<Self> {
        let mut colour = Self::default();
        let Some(value) = value.filter(|v| !v.is_none()) else { return Some(colour) };
        if let Ok(tuple) = value.cast::<PyTuple>() {
            for (i, number) in tuple.iter_borrowed().enumerate() {
                let number = number.extract().ok()?;
                match colour.first.get_mut(i) {
                    Some(place) => *place = number,
                    None => colour.more.push(number),
                }
            }
            return Some(colour);
        }
        // Arrays of one number extract, too: they are for the front end.
        if array(value).is_some() {
            return None;
        }
        colour.first[0] = value.extract().ok()?;
        Some(colour)
    }

    /// Whether all its numbers have a channel; those of OpenCV's four always do.
    pub fn fits(&self, channels: usize) -> bool {
        self.more.len() <= channels.saturating_sub(4)
    }

    /// The number of a channel, 0 where none was given.
    pub fn at(&self, channel: usize) -> f64 {
        let more = || self.more.get(channel - 4).copied().unwrap_or(0.0);
        self.first.get(channel).copied().unwrap_or_else(more)
    }
}

/// A matrix of `rows` x 3 singles or doubles, filled up by (0, 0, 1).
pub fn matrix(value: &Bound<'_, PyAny>, rows: usize) -> Option<[f64; 9]> {
    let array = array(value)?;
    if array.shape() != [rows, 3] || !array.is_c_contiguous() || !array.is_aligned() {
        return None;
    }
    let mut matrix = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    if let Ok(doubles) = array.cast::<PyArrayDyn<f64>>() {
        let doubles = doubles.try_readonly().ok()?;
        matrix[..3 * rows].copy_from_slice(doubles.as_slice().ok()?);
    } else {
        let singles = array.cast::<PyArrayDyn<f32>>().ok()?.try_readonly().ok()?;
        for (place, &number) in matrix.iter_mut().zip(singles.as_slice().ok()?) {
            *place = f64::from(number);
        }
    }
    Some(matrix)
}
