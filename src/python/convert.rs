//! Between NumPy arrays and the crate's slices: the only file that touches buffers of arrays.
//!
//! Inputs are borrowed where they are C-contiguous, aligned and native, else copied once.

use crate::error::{Error, Result};
use crate::image::{AnyView, Image, Pixels, View};
use crate::texel::f16;
use numpy::{
    Element, IntoPyArray, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn,
    PyReadwriteArrayDyn, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// A borrowed array of one of the element types of textures.
pub enum AnyArray<'py> {
    /// `uint8`
    U8(PyReadonlyArrayDyn<'py, u8>),
    /// `uint16`
    U16(PyReadonlyArrayDyn<'py, u16>),
    /// `float16`
    F16(PyReadonlyArrayDyn<'py, f16>),
    /// `float32`
    F32(PyReadonlyArrayDyn<'py, f32>),
    /// `float64`
    F64(PyReadonlyArrayDyn<'py, f64>),
}

/// An image argument: (H, W) or (H, W, C), C-contiguous.
pub struct ImageArg<'py> {
    array: AnyArray<'py>,
    shape: [usize; 3],
    /// Whether the array had no axis of channels.
    pub is_flat: bool,
}

/// Single or double coordinates, as they came.
#[derive(Clone, Copy)]
pub enum Floats<'a> {
    /// `float32`
    F32(&'a [f32]),
    /// `float64`
    F64(&'a [f64]),
}

/// An array of coordinates or other numbers that stay single or double; integers become double.
pub enum FloatArray<'py> {
    /// `float32`
    F32(PyReadonlyArrayDyn<'py, f32>),
    /// `float64`
    F64(PyReadonlyArrayDyn<'py, f64>),
}

fn describe(value: &Bound<'_, PyAny>) -> String {
    match value.cast::<PyUntypedArray>() {
        Ok(array) => format!("an array of shape {:?} and dtype {}", array.shape(), array.dtype()),
        Err(_) => value.get_type().name().map_or_else(|_| "an object".into(), |name| format!("a {name}")),
    }
}

/// Any array-like as an array that is C-contiguous, aligned and of native byte order.
fn ordered<'py>(argument: &'static str, value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyUntypedArray>> {
    let numpy = value.py().import("numpy")?;
    let array = match value.cast::<PyUntypedArray>() {
        Ok(array) => array.clone(),
        Err(_) => {
            let made = numpy.call_method1("asarray", (value,));
            made.map_err(|e| Error::type_(argument, format!("{} ({e})", describe(value)), "an array"))?
                .cast_into::<PyUntypedArray>()
                .map_err(|_| Error::type_(argument, describe(value), "an array"))?
        }
    };
    if array.is_c_contiguous() && array.is_aligned() && array.dtype().is_native_byteorder() != Some(false) {
        return Ok(array);
    }
    let dtype = array.dtype().call_method1("newbyteorder", ("=",))?;
    let options = PyDict::new(value.py());
    options.set_item("dtype", dtype)?;
    options.set_item("requirements", ["C", "A"])?;
    Ok(numpy.call_method("require", (array,), Some(&options))?.cast_into::<PyUntypedArray>()?)
}

fn read<'py, T: Element>(array: &Bound<'py, PyUntypedArray>) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    Ok(array.cast::<PyArrayDyn<T>>()?.try_readonly()?)
}

/// The elements of an array that [`ordered`] has seen.
fn slice<'a, T: Element>(array: &'a PyReadonlyArrayDyn<'_, T>) -> Result<&'a [T]> {
    array.as_slice().map_err(|e| Error::value("array", e, "C-contiguous memory"))
}

impl<'py> AnyArray<'py> {
    /// Borrows an array of one of the five types, of any shape.
    pub fn new(argument: &'static str, value: &Bound<'py, PyAny>) -> PyResult<Self> {
        let array = ordered(argument, value)?;
        let dtype = array.dtype();
        Ok(match (dtype.kind(), dtype.itemsize()) {
            (b'u', 1) => Self::U8(read(&array)?),
            (b'u', 2) => Self::U16(read(&array)?),
            (b'f', 2) => Self::F16(read(&array)?),
            (b'f', 4) => Self::F32(read(&array)?),
            (b'f', 8) => Self::F64(read(&array)?),
            _ => {
                let expected = "dtype uint8, uint16, float16, float32 or float64; convert with .astype()";
                return Err(Error::type_(argument, describe(&array), expected).into());
            }
        })
    }

    /// The array's shape.
    pub fn shape(&self) -> &[usize] {
        match self {
            Self::U8(a) => a.shape(),
            Self::U16(a) => a.shape(),
            Self::F16(a) => a.shape(),
            Self::F32(a) => a.shape(),
            Self::F64(a) => a.shape(),
        }
    }
}

impl<'py> ImageArg<'py> {
    /// Borrows an image.
    pub fn new(argument: &'static str, value: &Bound<'py, PyAny>) -> PyResult<Self> {
        let array = AnyArray::new(argument, value)?;
        let shape = match *array.shape() {
            [h, w] => [h, w, 1],
            [h, w, c] => [h, w, c],
            _ => {
                return Err(Error::value(argument, describe(value), "shape (H, W) or (H, W, C)").into());
            }
        };
        crate::image::check_size(argument, shape[1], shape[0], shape[2])?;
        let is_flat = array.shape().len() == 2;
        Ok(Self { array, shape, is_flat })
    }

    /// The pixels.
    pub fn view(&self) -> Result<AnyView<'_>> {
        let [h, w, c] = self.shape;
        Ok(match &self.array {
            AnyArray::U8(a) => View::new(slice(a)?, w, h, c, w * c)?.into(),
            AnyArray::U16(a) => View::new(slice(a)?, w, h, c, w * c)?.into(),
            AnyArray::F16(a) => View::new(slice(a)?, w, h, c, w * c)?.into(),
            AnyArray::F32(a) => View::new(slice(a)?, w, h, c, w * c)?.into(),
            AnyArray::F64(a) => View::new(slice(a)?, w, h, c, w * c)?.into(),
        })
    }
}

impl<'py> FloatArray<'py> {
    /// Borrows numbers whose last axes are `trailing`, e.g. `[2]` for uv; shapes are named `name` in errors.
    pub fn new(
        argument: &'static str,
        value: &Bound<'py, PyAny>,
        trailing: &[usize],
        name: &str,
    ) -> PyResult<Self> {
        let array = ordered(argument, value)?;
        let shape = array.shape();
        if shape.len() < trailing.len() || !shape.ends_with(trailing) {
            return Err(Error::value(argument, describe(&array), format!("shape {name}")).into());
        }
        let dtype = array.dtype();
        Ok(match (dtype.kind(), dtype.itemsize()) {
            (b'f', 4) => Self::F32(read(&array)?),
            (b'f', 8) => Self::F64(read(&array)?),
            (b'f', 2) => {
                let single = array.call_method1("astype", ("float32",))?;
                Self::F32(read(single.cast::<PyUntypedArray>()?)?)
            }
            (b'i' | b'u' | b'b', _) => {
                let double = array.call_method1("astype", ("float64",))?;
                Self::F64(read(double.cast::<PyUntypedArray>()?)?)
            }
            _ => {
                return Err(Error::type_(argument, describe(&array), "dtype float32 or float64").into());
            }
        })
    }

    /// The numbers.
    pub fn floats(&self) -> Result<Floats<'_>> {
        Ok(match self {
            Self::F32(a) => Floats::F32(slice(a)?),
            Self::F64(a) => Floats::F64(slice(a)?),
        })
    }

    /// The array's shape.
    pub fn shape(&self) -> &[usize] {
        match self {
            Self::F32(a) => a.shape(),
            Self::F64(a) => a.shape(),
        }
    }

    /// The shape without its last `n` axes.
    pub fn leading(&self, n: usize) -> &[usize] {
        &self.shape()[..self.shape().len() - n]
    }

    /// The numbers as doubles.
    pub fn to_f64(&self) -> Result<Vec<f64>> {
        Ok(match self.floats()? {
            Floats::F32(a) => a.iter().copied().map(f64::from).collect(),
            Floats::F64(a) => a.to_vec(),
        })
    }

    /// The numbers as singles.
    pub fn to_f32(&self) -> Result<Vec<f32>> {
        Ok(match self.floats()? {
            Floats::F32(a) => a.to_vec(),
            Floats::F64(a) => a.iter().map(|x| *x as f32).collect(),
        })
    }
}

/// Triangles: whole numbers of shape (F, 3), from 0 on.
pub fn triangles(argument: &'static str, value: &Bound<'_, PyAny>) -> PyResult<Vec<[u32; 3]>> {
    Ok(whole_numbers(argument, value, "(F, 3)", |shape| matches!(shape, [_, 3]))?.as_chunks().0.to_vec())
}

/// Indices: whole numbers of shape (N,), from 0 on.
pub fn indices(argument: &'static str, value: &Bound<'_, PyAny>) -> PyResult<Vec<u32>> {
    whole_numbers(argument, value, "(N,)", |shape| shape.len() == 1)
}

fn whole_numbers(
    argument: &'static str,
    value: &Bound<'_, PyAny>,
    name: &str,
    fits: impl Fn(&[usize]) -> bool,
) -> PyResult<Vec<u32>> {
    let array = ordered(argument, value)?;
    if !fits(array.shape()) {
        return Err(Error::value(argument, describe(&array), format!("shape {name}")).into());
    }
    let dtype = array.dtype();
    // An empty list is an array of floats for NumPy.
    if !matches!(dtype.kind(), b'i' | b'u') && array.len() > 0 {
        return Err(Error::type_(argument, describe(&array), "a dtype of whole numbers").into());
    }
    if (dtype.kind(), dtype.itemsize()) == (b'u', 4) {
        return Ok(slice(&read::<u32>(&array)?)?.to_vec());
    }
    let wide = array.call_method1("astype", ("int64",))?;
    let wide = read::<i64>(wide.cast::<PyUntypedArray>()?)?;
    let numbers = slice(&wide)?;
    if let Some(bad) = numbers.iter().find(|&&i| u32::try_from(i).is_err()) {
        return Err(Error::value(argument, format!("index {bad}"), "whole numbers from 0 on").into());
    }
    Ok(numbers.iter().map(|&i| i as u32).collect())
}

/// One truth value each.
pub fn flags(argument: &'static str, value: &Bound<'_, PyAny>) -> PyResult<Vec<bool>> {
    let array = ordered(argument, value)?;
    if array.dtype().kind() != b'b' || array.shape().len() != 1 {
        return Err(Error::type_(argument, describe(&array), "a bool array of one axis").into());
    }
    Ok(slice(&read::<bool>(&array)?)?.to_vec())
}

/// A writable output array of this type and shape.
pub fn output<'py, T: Element>(
    argument: &'static str,
    value: &Bound<'py, PyAny>,
    shape: &[usize],
    dtype: &str,
) -> PyResult<PyReadwriteArrayDyn<'py, T>> {
    let expected = || format!("a writable C-contiguous array of shape {shape:?} and dtype {dtype}");
    let Ok(array) = value.cast::<PyArrayDyn<T>>() else {
        return Err(Error::type_(argument, describe(value), expected()).into());
    };
    if array.shape() != shape || !array.is_c_contiguous() || !array.is_aligned() {
        return Err(Error::value(argument, describe(value), expected()).into());
    }
    array
        .try_readwrite()
        .map_err(|e| Error::value(argument, format!("{} ({e})", describe(value)), expected()).into())
}

/// What `run` makes, in the array that was given for it, or in a new one.
pub fn filled<'py, T: Element + Default + Clone + Send>(
    py: Python<'py>,
    given: Option<&Bound<'py, PyAny>>,
    shape: &[usize],
    dtype: &str,
    threads: Option<usize>,
    run: impl FnOnce(&mut [T]) -> Result<()> + Send,
) -> PyResult<Bound<'py, PyAny>> {
    let Some(given) = given else {
        let mut made = crate::image::zeros::<T>("shape", shape.iter().product())?;
        work(py, threads, || run(&mut made))?;
        return array(py, made, shape);
    };
    let mut borrowed = output::<T>("out", given, shape, dtype)?;
    let slice = borrowed.as_slice_mut().map_err(|e| Error::value("out", e, "C-contiguous memory"))?;
    work(py, threads, || run(slice))?;
    Ok(given.clone())
}

/// A new array from packed elements.
pub fn array<'py, T: Element>(py: Python<'py>, data: Vec<T>, shape: &[usize]) -> PyResult<Bound<'py, PyAny>> {
    Ok(data.into_pyarray(py).reshape(shape)?.into_any())
}

/// A new array of shape (H, W, C), or (H, W) where `flat`, from an image.
pub fn image_array<'py>(py: Python<'py>, image: Image, flat: bool) -> PyResult<Bound<'py, PyAny>> {
    let full = [image.height(), image.width(), image.channels()];
    let shape = if flat { &full[..2] } else { &full[..] };
    match image.into_pixels() {
        Pixels::U8(data) => array(py, data, shape),
        Pixels::U16(data) => array(py, data, shape),
        Pixels::F16(data) => array(py, data, shape),
        Pixels::F32(data) => array(py, data, shape),
        Pixels::F64(data) => array(py, data, shape),
    }
}

/// Runs long work without the interpreter lock; Ctrl-C ends it.
pub fn work<R: Send>(
    py: Python<'_>,
    threads: Option<usize>,
    job: impl FnOnce() -> Result<R> + Send,
) -> PyResult<R> {
    work_reporting(py, threads, None, job)
}

/// As [`work`], and calls `progress` now and then with the share that is done; what it raises ends the work.
pub fn work_reporting<R: Send>(
    py: Python<'_>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
    job: impl FnOnce() -> Result<R> + Send,
) -> PyResult<R> {
    let check = move |done: f64| {
        Python::attach(|py| {
            let called = progress.as_ref().map_or(Ok(()), |call| call.call1(py, (done,)).map(drop));
            called.and_then(|()| py.check_signals()).map_err(|e| e.restore(py)).is_err()
        })
    };
    let run = || crate::par::with_threads(threads, || crate::par::with_interrupt(check, job));
    Ok(py.detach(run)?)
}
