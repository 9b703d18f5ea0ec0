//! Rasterising.

use super::convert::{FloatArray, Floats, array, flags, triangles, work};
use crate::error::{Error, Result};
use crate::raster::{Attributes, Cull, Fragments, Geometry, Options, rasterize as draw};
use crate::texel::Texel;
use numpy::Element;
use pyo3::prelude::*;
use std::sync::Arc;

/// What was drawn, and what is seen of it.
#[pyclass(name = "Fragments", frozen, module = "multum._multum")]
struct PyFragments {
    geometry: Arc<Geometry>,
    fragments: Fragments,
}

/// Draws triangles. `cull` is "none", "back" or "front"; `back_of` chooses the faces whose backs are left out.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "one for each keyword of the Python function")]
fn rasterize(
    py: Python<'_>,
    clip_positions: &Bound<'_, PyAny>,
    faces: &Bound<'_, PyAny>,
    size: (usize, usize),
    cull: &str,
    back_of: Option<&Bound<'_, PyAny>>,
    samples: usize,
    threads: Option<usize>,
) -> PyResult<PyFragments> {
    let positions = FloatArray::new("clip_positions", clip_positions, &[4], "(V, 4)")?;
    if positions.shape().len() != 2 {
        return Err(Error::value("clip_positions", format!("shape {:?}", positions.shape()), "(V, 4)").into());
    }
    let positions = positions.to_f64()?.as_chunks().0.to_vec();
    let faces = triangles("faces", faces)?;
    let mask = back_of.map(|mask| flags("cull", mask)).transpose()?;
    let cull = match (&mask, cull) {
        (Some(mask), _) => Cull::BackOf(mask),
        (None, "none") => Cull::None,
        (None, "back") => Cull::Back,
        (None, "front") => Cull::Front,
        (None, _) => {
            let expected = "\"none\", \"back\", \"front\" or a bool array with one entry a face";
            return Err(Error::value("cull", format!("{cull:?}"), expected).into());
        }
    };
    work(py, threads, || {
        let geometry = Arc::new(Geometry::new(positions, faces)?);
        let fragments = draw(&geometry, size, &Options { cull, samples, behind: None })?;
        Ok(PyFragments { geometry, fragments })
    })
}

#[pymethods]
impl PyFragments {
    /// (width, height)
    #[getter]
    fn size(&self) -> (usize, usize) {
        (self.fragments.width(), self.fragments.height())
    }

    /// The next layer: what lies behind these fragments.
    fn behind(
        &self,
        py: Python<'_>,
        cull: &str,
        back_of: Option<&Bound<'_, PyAny>>,
        samples: usize,
    ) -> PyResult<Self> {
        let mask = back_of.map(|mask| flags("cull", mask)).transpose()?;
        let cull = match (&mask, cull) {
            (Some(mask), _) => Cull::BackOf(mask),
            (None, "back") => Cull::Back,
            (None, "front") => Cull::Front,
            (None, _) => Cull::None,
        };
        work(py, None, || {
            let options = Options { cull, samples, behind: Some(&self.fragments) };
            let fragments = draw(&self.geometry, self.size(), &options)?;
            Ok(Self { geometry: self.geometry.clone(), fragments })
        })
    }

    /// (H, W) int32
    fn triangle<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, self.fragments.triangle().to_vec(), &self.shape())
    }

    /// (H, W) float32
    fn depth<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, self.fragments.depth().to_vec(), &self.shape())
    }

    /// (H, W) float32
    fn coverage<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, self.fragments.coverage(), &self.shape())
    }

    /// (H, W, 3) float32
    fn barycentric<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let weights = work(py, None, || self.fragments.barycentric(&self.geometry))?;
        let [h, w] = self.shape();
        array(py, weights.into_flattened(), &[h, w, 3])
    }

    /// Values (H, W, C) and, if asked for, derivatives (H, W, C, 2); without the axis C for attributes (V,).
    fn interpolate<'py>(
        &self,
        py: Python<'py>,
        attributes: &Bound<'py, PyAny>,
        derivatives: bool,
        fill: f64,
    ) -> PyResult<(Bound<'py, PyAny>, Option<Bound<'py, PyAny>>)> {
        let numbers = FloatArray::new("attributes", attributes, &[], "(V,), (V, C) or (F, 3, C)")?;
        let (channels, corner) = match *numbers.shape() {
            [_] => (1, false),
            [_, channels] => (channels, false),
            [_, 3, channels] => (channels, true),
            ref other => {
                let expected = "(V,), (V, C) or (F, 3, C)";
                return Err(Error::value("attributes", format!("shape {other:?}"), expected).into());
            }
        };
        let [h, w] = self.shape();
        let full = [h, w, channels, 2];
        let shape = if numbers.shape().len() == 1 { &full[..2] } else { &full[..3] };
        let form = Form { channels, corner, derivatives };
        match numbers.floats()? {
            Floats::F32(data) => self.blend(py, data, form, fill as f32, shape),
            Floats::F64(data) => self.blend(py, data, form, fill, shape),
        }
    }
}

/// What attributes look like and what is wanted of them.
#[derive(Clone, Copy)]
struct Form {
    channels: usize,
    corner: bool,
    derivatives: bool,
}

impl PyFragments {
    fn shape(&self) -> [usize; 2] {
        [self.fragments.height(), self.fragments.width()]
    }

    fn blend<'py, T: Texel + Element>(
        &self,
        py: Python<'py>,
        data: &[T],
        form: Form,
        fill: T,
        shape: &[usize],
    ) -> PyResult<(Bound<'py, PyAny>, Option<Bound<'py, PyAny>>)> {
        let channels = form.channels;
        let attributes = if form.corner {
            Attributes::Corner { data, channels }
        } else {
            Attributes::Vertex { data, channels }
        };
        let (values, jacobian) = work(py, None, || -> Result<_> {
            if !form.derivatives {
                return Ok((self.fragments.interpolate(&self.geometry, attributes, fill)?, None));
            }
            let (values, jacobian) =
                self.fragments.interpolate_with_derivatives(&self.geometry, attributes, fill)?;
            Ok((values, Some(jacobian.into_flattened())))
        })?;
        let pairs = [shape, &[2]].concat();
        let jacobian = jacobian.map(|jacobian| array(py, jacobian, &pairs)).transpose()?;
        Ok((array(py, values, shape)?, jacobian))
    }
}

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyFragments>()?;
    module.add_function(wrap_pyfunction!(rasterize, module)?)
}
