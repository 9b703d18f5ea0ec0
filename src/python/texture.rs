//! Textures and sampling.

use super::convert::{FloatArray, Floats, ImageArg, array, filled, image_array, work};
use crate::encode::{Alpha, Encoding};
use crate::error::{Error, Result};
use crate::filter::{Effort, Filter};
use crate::lod::LodRule;
use crate::num::Real;
use crate::pyramid::Kind;
use crate::sampler::{Coordinate, Extent, Sampler, gradient};
use crate::texture::TextureOptions;
use crate::wrap::Wrap;
use numpy::Element;
use pyo3::prelude::*;

/// A texture: an image with its levels, wrap modes, border colour and encoding.
#[pyclass(frozen, module = "multum._multum")]
pub struct Texture {
    pub(super) inner: crate::texture::Texture<'static>,
    /// Whether the image had no axis of channels.
    is_flat: bool,
}

/// One filter with all its options, checked.
#[pyclass(frozen, module = "multum._multum")]
#[derive(Clone, Copy)]
pub struct Sampling {
    pub(super) sampler: Sampler,
    pub(super) threads: Option<usize>,
}

#[pymethods]
impl Sampling {
    #[new]
    #[allow(clippy::too_many_arguments, reason = "one for each keyword of the Python functions")]
    #[pyo3(signature = (filter, max_anisotropy, lod_bias, lod_rule, tolerance, seed, threads))]
    fn new(
        filter: &str,
        max_anisotropy: f64,
        lod_bias: f32,
        lod_rule: &str,
        tolerance: Option<f64>,
        seed: u64,
        threads: Option<usize>,
    ) -> PyResult<Self> {
        let sampler = Sampler {
            filter: Filter::parse(filter)?,
            max_anisotropy,
            lod_bias,
            lod_rule: LodRule::parse(lod_rule)?,
            tolerance,
            seed,
        };
        sampler.check()?;
        Ok(Self { sampler, threads })
    }
}

#[pymethods]
impl Texture {
    #[new]
    #[allow(clippy::too_many_arguments, reason = "one for each keyword of the Python class")]
    fn new(
        py: Python<'_>,
        image: &Bound<'_, PyAny>,
        wrap: (String, String),
        border: Vec<f64>,
        encoding: &str,
        alpha: &str,
        pyramid: &str,
        coverage: Option<f64>,
    ) -> PyResult<Self> {
        let image = ImageArg::new("image", image)?;
        let view = image.view()?;
        let options = TextureOptions {
            wrap: [Wrap::parse("wrap", &wrap.0)?, Wrap::parse("wrap", &wrap.1)?],
            border,
            encoding: Encoding::parse("encoding", encoding)?,
            alpha: Alpha::parse("alpha", alpha)?,
            pyramid: Kind::parse("pyramid", pyramid)?,
            coverage,
        };
        let inner = work(py, None, || crate::texture::Texture::new(view, options))?;
        Ok(Self { inner, is_flat: image.is_flat })
    }

    #[getter]
    fn width(&self) -> usize {
        self.inner.width()
    }

    #[getter]
    fn height(&self) -> usize {
        self.inner.height()
    }

    #[getter]
    fn channels(&self) -> usize {
        self.inner.channels()
    }

    #[getter]
    fn dtype(&self) -> &'static str {
        self.inner.dtype().name()
    }

    #[getter]
    fn num_levels(&self) -> usize {
        self.inner.num_levels()
    }

    #[getter]
    fn nbytes(&self) -> usize {
        self.inner.nbytes()
    }

    #[getter]
    fn wrap(&self) -> (&'static str, &'static str) {
        let [u, v] = self.inner.wrap();
        (u.name(), v.name())
    }

    #[getter]
    fn border(&self) -> Vec<f64> {
        self.inner.border().to_vec()
    }

    #[getter]
    fn encoding(&self) -> &'static str {
        self.inner.format().encoding.name()
    }

    #[getter]
    fn alpha(&self) -> &'static str {
        self.inner.format().alpha.name()
    }

    #[getter]
    fn pyramid(&self) -> &'static str {
        self.inner.pyramid().name()
    }

    fn level<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Bound<'py, PyAny>> {
        let image = work(py, None, || self.inner.level(index))?;
        image_array(py, image, self.is_flat)
    }

    #[pyo3(signature = (uv, jacobian, lod, sampling, out))]
    fn sample<'py>(
        &self,
        py: Python<'py>,
        uv: &Bound<'py, PyAny>,
        jacobian: Option<&Bound<'py, PyAny>>,
        lod: Option<&Bound<'py, PyAny>>,
        sampling: &Sampling,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        if self.inner.is_double() {
            self.sample_as::<f64>(py, uv, jacobian, lod, sampling, out, "float64")
        } else {
            self.sample_as::<f32>(py, uv, jacobian, lod, sampling, out, "float32")
        }
    }

    #[pyo3(signature = (uv, jacobian, lod, sampling))]
    fn survey<'py>(
        &self,
        py: Python<'py>,
        uv: &Bound<'py, PyAny>,
        jacobian: Option<&Bound<'py, PyAny>>,
        lod: Option<&Bound<'py, PyAny>>,
        sampling: &Sampling,
    ) -> PyResult<Bound<'py, PyAny>> {
        let uv = FloatArray::new("uv", uv, &[2], "(..., 2)")?;
        let jacobian =
            jacobian.map(|j| FloatArray::new("jacobian", j, &[2, 2], "(..., 2, 2)")).transpose()?;
        let lod = lod.map(|l| FloatArray::new("lod", l, &[], "(...)")).transpose()?;
        let lod = lod.map(|l| l.to_f32()).transpose()?;
        let jacobian = jacobian.map(|j| j.to_f64()).transpose()?;
        let places = uv.to_f64()?;
        let extent = extent(jacobian.as_deref(), lod.as_deref());
        let made = work(py, sampling.threads, || sampling.sampler.survey(&self.inner, &places, extent))?;
        efforts(py, &made, uv.leading(1))
    }

    fn gradient<'py>(
        &self,
        py: Python<'py>,
        uv: &Bound<'py, PyAny>,
        filter: &str,
        threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyAny>> {
        if self.inner.is_double() {
            self.gradient_as::<f64>(py, uv, filter, threads)
        } else {
            self.gradient_as::<f32>(py, uv, filter, threads)
        }
    }
}

impl Texture {
    #[allow(clippy::too_many_arguments, reason = "one for each argument of the Python method")]
    fn sample_as<'py, O: Real + Element>(
        &self,
        py: Python<'py>,
        uv: &Bound<'py, PyAny>,
        jacobian: Option<&Bound<'py, PyAny>>,
        lod: Option<&Bound<'py, PyAny>>,
        sampling: &Sampling,
        out: Option<&Bound<'py, PyAny>>,
        dtype: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        let uv = FloatArray::new("uv", uv, &[2], "(..., 2)")?;
        let leading = uv.leading(1).to_vec();
        let jacobian =
            jacobian.map(|j| FloatArray::new("jacobian", j, &[2, 2], "(..., 2, 2)")).transpose()?;
        let lod = lod.map(|l| FloatArray::new("lod", l, &[], "(...)")).transpose()?;
        let mut shape = leading.clone();
        shape.push(self.inner.channels());
        let same = |argument, array: &FloatArray<'_>, trailing: usize| {
            if array.leading(trailing) == leading {
                return Ok(());
            }
            let expected = format!("leading axes {leading:?}, those of uv");
            Err(Error::value(argument, format!("an array of shape {:?}", array.shape()), expected))
        };
        if let Some(jacobian) = &jacobian {
            same("jacobian", jacobian, 2)?;
        }
        if let Some(lod) = &lod {
            same("lod", lod, 0)?;
        }
        let lod = lod.map(|l| l.to_f32()).transpose()?;
        let lod = lod.as_deref();
        let jacobian = jacobian.as_ref().map(FloatArray::floats).transpose()?;
        let uv = uv.floats()?;
        let sampler = sampling.sampler;
        let run = |out: &mut [O]| match (uv, jacobian) {
            (Floats::F32(uv), Some(Floats::F32(j))) => self.run(&sampler, uv, Some(j), lod, out),
            (Floats::F32(uv), None) => self.run(&sampler, uv, None, lod, out),
            (Floats::F64(uv), Some(Floats::F64(j))) => self.run(&sampler, uv, Some(j), lod, out),
            (Floats::F64(uv), None) => self.run(&sampler, uv, None, lod, out),
            (Floats::F32(uv), Some(Floats::F64(j))) => self.run(&sampler, &doubles(uv), Some(j), lod, out),
            (Floats::F64(uv), Some(Floats::F32(j))) => self.run(&sampler, uv, Some(&doubles(j)), lod, out),
        };
        filled(py, out, &shape, dtype, sampling.threads, run)
    }

    fn run<U: Coordinate, O: Real>(
        &self,
        sampler: &Sampler,
        uv: &[U],
        jacobian: Option<&[U]>,
        lod: Option<&[f32]>,
        out: &mut [O],
    ) -> Result<()> {
        sampler.sample(&self.inner, uv, extent(jacobian, lod), out)
    }

    fn gradient_as<'py, O: Real + Element>(
        &self,
        py: Python<'py>,
        uv: &Bound<'py, PyAny>,
        filter: &str,
        threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let uv = FloatArray::new("uv", uv, &[2], "(..., 2)")?;
        let filter = Filter::parse(filter)?;
        let mut shape = uv.leading(1).to_vec();
        shape.extend([self.inner.channels(), 2]);
        let mut out = crate::image::zeros::<O>("uv", shape.iter().product())?;
        let places = uv.floats()?;
        work(py, threads, || match places {
            Floats::F32(uv) => gradient(&self.inner, filter, uv, &mut out),
            Floats::F64(uv) => gradient(&self.inner, filter, uv, &mut out),
        })?;
        array(py, out, &shape)
    }
}

fn extent<'a, U>(jacobian: Option<&'a [U]>, lod: Option<&'a [f32]>) -> Extent<'a, U> {
    match (jacobian, lod) {
        (_, Some(lod)) => Extent::Lod(lod),
        (Some(jacobian), None) => Extent::Jacobian(jacobian),
        (None, None) => Extent::Point,
    }
}

/// Costs and levels as an array of shape (2, ...).
pub(super) fn efforts<'py>(
    py: Python<'py>,
    made: &[Effort],
    leading: &[usize],
) -> PyResult<Bound<'py, PyAny>> {
    let numbers = made.iter().map(|e| e.cost).chain(made.iter().map(|e| e.lod)).collect();
    let shape: Vec<usize> = std::iter::once(2).chain(leading.iter().copied()).collect();
    array(py, numbers, &shape)
}

fn doubles(singles: &[f32]) -> Vec<f64> {
    singles.iter().copied().map(f64::from).collect()
}

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Texture>()?;
    module.add_class::<Sampling>()
}
