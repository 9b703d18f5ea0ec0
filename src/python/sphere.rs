//! Textures of directions.

use super::convert::{FloatArray, Floats, ImageArg, filled, work};
use super::texture::Sampling;
use crate::encode::{Alpha, Encoding};
use crate::error::{Error, Result};
use crate::mapping::Layout;
use crate::num::Real;
use crate::pyramid::Kind;
use crate::sphere::Spread;
use crate::texture::TextureOptions;
use numpy::Element;
use pyo3::prelude::*;
use std::borrow::Cow;

/// A picture of all directions.
#[pyclass(frozen, module = "multum._multum")]
pub struct SphereTexture {
    pub(super) inner: crate::sphere::SphereTexture,
}

fn doubles<'a>(array: &'a FloatArray<'_>) -> Result<Cow<'a, [f64]>> {
    Ok(match array.floats()? {
        Floats::F32(a) => Cow::Owned(a.iter().copied().map(f64::from).collect()),
        Floats::F64(a) => Cow::Borrowed(a),
    })
}

#[pymethods]
impl SphereTexture {
    #[new]
    #[allow(clippy::too_many_arguments, reason = "one for each keyword of the Python class")]
    fn new(
        py: Python<'_>,
        image: &Bound<'_, PyAny>,
        form: &str,
        layout: &str,
        border: Vec<f64>,
        encoding: &str,
        alpha: &str,
        pyramid: &str,
    ) -> PyResult<Self> {
        let image = ImageArg::new("image", image)?;
        let view = image.view()?;
        let options = TextureOptions {
            border,
            encoding: Encoding::parse("encoding", encoding)?,
            alpha: Alpha::parse("alpha", alpha)?,
            pyramid: Kind::parse("pyramid", pyramid)?,
            ..TextureOptions::default()
        };
        let layout = Layout::parse("layout", layout)?;
        let inner = match form {
            "equirect" => work(py, None, || crate::sphere::SphereTexture::equirect(view, options))?,
            "cube" => work(py, None, || crate::sphere::SphereTexture::cube(view, layout, options))?,
            _ => return Err(Error::value("form", format!("{form:?}"), "\"equirect\" or \"cube\"").into()),
        };
        Ok(Self { inner })
    }

    #[getter]
    fn size(&self) -> (usize, usize) {
        self.inner.size().into()
    }

    #[getter]
    fn is_cube(&self) -> bool {
        self.inner.is_cube()
    }

    #[getter]
    fn channels(&self) -> usize {
        self.inner.channels()
    }

    #[getter]
    fn num_levels(&self) -> usize {
        self.inner.num_levels()
    }

    #[getter]
    fn nbytes(&self) -> usize {
        self.inner.nbytes()
    }

    #[allow(clippy::too_many_arguments, reason = "one for each argument of the Python method")]
    fn sample<'py>(
        &self,
        py: Python<'py>,
        directions: &Bound<'py, PyAny>,
        ddx: Option<&Bound<'py, PyAny>>,
        ddy: Option<&Bound<'py, PyAny>>,
        lod: Option<&Bound<'py, PyAny>>,
        sampling: &Sampling,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let directions = FloatArray::new("directions", directions, &[3], "(..., 3)")?;
        let ddx = ddx.map(|d| FloatArray::new("ddx", d, directions.shape(), "of directions")).transpose()?;
        let ddy = ddy.map(|d| FloatArray::new("ddy", d, directions.shape(), "of directions")).transpose()?;
        let lod =
            lod.map(|l| FloatArray::new("lod", l, directions.leading(1), "of directions")).transpose()?;
        let tangents = match (&ddx, &ddy) {
            (Some(x), Some(y)) => Some((doubles(x)?, doubles(y)?)),
            _ => None,
        };
        let lod = lod.map(|l| l.to_f32()).transpose()?;
        let spread = match (&tangents, &lod) {
            (Some((x, y)), _) => Spread::Tangents(x, y),
            (None, Some(lod)) => Spread::Lod(lod),
            (None, None) => Spread::Point,
        };
        let d = doubles(&directions)?;
        let shape = [directions.leading(1), &[self.inner.channels()]].concat();
        if self.inner.is_double() {
            self.fill::<f64>(py, &d, spread, sampling, out, &shape, "float64")
        } else {
            self.fill::<f32>(py, &d, spread, sampling, out, &shape, "float32")
        }
    }
}

impl SphereTexture {
    #[allow(clippy::too_many_arguments, reason = "one for each argument of the Python method")]
    fn fill<'py, O: Real + Element>(
        &self,
        py: Python<'py>,
        d: &[f64],
        spread: Spread<'_, f64>,
        sampling: &Sampling,
        out: Option<&Bound<'py, PyAny>>,
        shape: &[usize],
        dtype: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        let run = |out: &mut [O]| self.inner.sample(&sampling.sampler, d, spread, out);
        filled(py, out, shape, dtype, sampling.threads, run)
    }
}

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<SphereTexture>()
}
