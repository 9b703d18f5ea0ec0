//! Meshes, scenes and cameras.

use super::convert::{FloatArray, Floats, array, triangles, work};
use crate::error::Error;
use crate::mesh::{
    AlphaMode, Camera, ImageSource, Light, Material, Mesh, Normals, Projection, Scene, TextureSlot,
    smooth_normals,
};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::path::PathBuf;

fn slot<'py>(py: Python<'py>, slot: &TextureSlot) -> PyResult<Bound<'py, PyDict>> {
    let made = PyDict::new(py);
    made.set_item("image", slot.image)?;
    made.set_item("uv_set", slot.uv_set)?;
    made.set_item("transform", array(py, slot.transform.as_flattened().to_vec(), &[2, 3])?)?;
    made.set_item("wrap", (slot.wrap[0].name(), slot.wrap[1].name()))?;
    made.set_item("mag_filter", slot.mag_filter)?;
    made.set_item("min_filter", slot.min_filter)?;
    made.set_item("encoding", slot.encoding.name())?;
    Ok(made)
}

fn material<'py>(py: Python<'py>, m: &Material) -> PyResult<Bound<'py, PyDict>> {
    let made = PyDict::new(py);
    let (alpha_mode, cutoff) = match m.alpha_mode {
        AlphaMode::Opaque => ("opaque", 0.5),
        AlphaMode::Mask(cutoff) => ("mask", cutoff),
        AlphaMode::Blend => ("blend", 0.5),
    };
    made.set_item("name", &m.name)?;
    made.set_item("model", m.model.name())?;
    made.set_item("normal_space", m.normal_space.name())?;
    made.set_item("base_color", m.base_color)?;
    made.set_item("metallic", m.metallic)?;
    made.set_item("roughness", m.roughness)?;
    made.set_item("normal_scale", m.normal_scale)?;
    made.set_item("bump_scale", m.bump_scale)?;
    made.set_item("displacement_scale", m.displacement_scale)?;
    made.set_item("displacement_offset", m.displacement_offset)?;
    made.set_item("mirror", m.mirror)?;
    made.set_item("occlusion_strength", m.occlusion_strength)?;
    made.set_item("emissive", m.emissive)?;
    made.set_item("ambient", m.ambient)?;
    made.set_item("specular", m.specular)?;
    made.set_item("shininess", m.shininess)?;
    made.set_item("alpha_mode", alpha_mode)?;
    made.set_item("alpha_cutoff", cutoff)?;
    made.set_item("double_sided", m.double_sided)?;
    made.set_item("unlit", m.unlit)?;
    for (name, texture) in m.slots().into_iter().filter(|(name, _)| *name != "layers") {
        made.set_item(name, slot(py, texture)?)?;
    }
    Ok(made)
}

/// Name, path and encoded bytes of a picture; the name tells what is wrong when both others are missing.
type ImageParts<'py> = (String, Option<PathBuf>, Option<Bound<'py, PyBytes>>);

fn image<'py>(py: Python<'py>, source: &ImageSource) -> ImageParts<'py> {
    match source {
        ImageSource::File(path) => {
            let name = path.file_name().map(|n| n.to_string_lossy().into_owned());
            (name.unwrap_or_default(), Some(path.clone()), None)
        }
        ImageSource::Embedded { name, bytes } => (name.clone(), None, Some(PyBytes::new(py, bytes))),
        ImageSource::Pixels(_) => ("pixels".into(), None, None),
        ImageSource::Missing(reason) => (reason.clone(), None, None),
    }
}

fn rows<'py, const N: usize>(py: Python<'py>, list: &[[f32; N]]) -> PyResult<Bound<'py, PyAny>> {
    array(py, list.as_flattened().to_vec(), &[list.len(), N])
}

pub(super) fn mesh<'py>(py: Python<'py>, mesh: &Mesh) -> PyResult<Bound<'py, PyDict>> {
    let made = PyDict::new(py);
    made.set_item("positions", rows(py, &mesh.positions)?)?;
    made.set_item("normals", rows(py, &mesh.normals)?)?;
    made.set_item("tangents", rows(py, &mesh.tangents)?)?;
    let sets: Vec<_> = mesh.uv.iter().map(|set| rows(py, set)).collect::<PyResult<_>>()?;
    made.set_item("uv_sets", sets)?;
    let colors = (!mesh.colors.is_empty()).then(|| rows(py, &mesh.colors)).transpose()?;
    made.set_item("colors", colors)?;
    made.set_item("faces", array(py, mesh.faces.as_flattened().to_vec(), &[mesh.faces.len(), 3])?)?;
    made.set_item("face_material", array(py, mesh.face_material.clone(), &[mesh.faces.len()])?)?;
    let materials: Vec<_> = mesh.materials.iter().map(|m| material(py, m)).collect::<PyResult<_>>()?;
    made.set_item("materials", materials)?;
    made.set_item("images", mesh.images.iter().map(|source| image(py, source)).collect::<Vec<_>>())?;
    Ok(made)
}

/// A camera.
#[pyclass(name = "Camera", frozen, module = "multum._multum")]
pub(super) struct PyCamera(pub(super) Camera);

#[pymethods]
impl PyCamera {
    /// A perspective camera at `eye` that looks at `target`.
    #[new]
    fn new(
        eye: [f64; 3],
        target: [f64; 3],
        up: [f64; 3],
        yfov_rad: f64,
        near: f64,
        far: f64,
    ) -> PyResult<Self> {
        let finite = |name, v: [f64; 3]| match v.iter().all(|c| c.is_finite()) {
            true => Ok(()),
            false => Err(Error::value(name, format!("{v:?}"), "finite numbers")),
        };
        finite("eye", eye)?;
        finite("target", target)?;
        finite("up", up)?;
        if !(yfov_rad > 0.0 && yfov_rad < std::f64::consts::PI) {
            return Err(
                Error::value("fov", yfov_rad.to_degrees(), "an angle between 0 and 180 degrees").into()
            );
        }
        if !(near > 0.0 && near < far) {
            return Err(Error::value("near", format!("{near} and far {far}"), "0 < near < far").into());
        }
        Ok(Self(Camera::look_at(eye, target, up, Projection::Perspective { yfov_rad, near, far })))
    }

    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    /// A camera that sees the whole mesh in a picture of an aspect.
    #[staticmethod]
    fn framing(positions: &Bound<'_, PyAny>, faces: &Bound<'_, PyAny>, aspect: f64) -> PyResult<Self> {
        let mesh = Mesh {
            positions: vectors("positions", positions)?,
            faces: triangles("faces", faces)?,
            ..Mesh::default()
        };
        if let Some(v) = mesh.faces.iter().flatten().find(|v| **v as usize >= mesh.positions.len()) {
            let expected = format!("indices below the number of vertices, {}", mesh.positions.len());
            return Err(Error::value("faces", format!("index {v}"), expected).into());
        }
        Ok(Self(Camera::framing_in(&mesh, aspect)))
    }

    /// Carried around the vertical axis through a point.
    fn turned(&self, center: [f64; 3], angle_rad: f64) -> PyResult<Self> {
        if !(angle_rad.is_finite() && center.iter().all(|c| c.is_finite())) {
            let got = format!("{} degrees around {center:?}", angle_rad.to_degrees());
            return Err(Error::value("degrees", got, "finite numbers").into());
        }
        Ok(Self(self.0.turned(center, angle_rad)))
    }

    #[getter]
    fn eye(&self) -> [f64; 3] {
        self.0.eye()
    }

    /// World to camera space, (4, 4).
    fn view<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, self.0.view.as_flattened().to_vec(), &[4, 4])
    }

    /// World to clip space, (4, 4).
    fn matrix<'py>(&self, py: Python<'py>, size: (usize, usize)) -> PyResult<Bound<'py, PyAny>> {
        array(py, self.0.matrix(size.0, size.1).as_flattened().to_vec(), &[4, 4])
    }

    /// Clip-space positions (..., 4) of points (..., 3).
    fn project<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
        size: (usize, usize),
    ) -> PyResult<Bound<'py, PyAny>> {
        let points = FloatArray::new("points", points, &[3], "(..., 3)")?;
        let shape = [points.leading(1), &[4]].concat();
        let numbers = points.to_f64()?;
        let clip = work(py, None, || Ok(self.0.project(numbers.as_chunks().0, size.0, size.1)))?;
        array(py, clip.into_flattened(), &shape)
    }
}

/// Kind ("ambient", "directional", "point"), place or direction, colour, falloff, and cone: axis and angles.
pub(super) type LightParts = (String, [f32; 3], [f32; 3], Option<f32>, Option<([f32; 3], [f32; 2])>);

fn light(light: &Light) -> LightParts {
    match light {
        Light::Ambient { color } => ("ambient".into(), [0.0; 3], *color, None, None),
        Light::Directional { direction, color } => ("directional".into(), *direction, *color, None, None),
        Light::Point { position, color, falloff, cone } => {
            ("point".into(), *position, *color, *falloff, *cone)
        }
    }
}

type SceneParts<'py> = (Bound<'py, PyDict>, Vec<PyCamera>, Vec<LightParts>);

/// The mesh, the cameras and the lights of a file.
#[pyfunction]
fn open_scene<'py>(py: Python<'py>, path: PathBuf, normals: &str) -> PyResult<SceneParts<'py>> {
    let normals = Normals::parse("normals", normals)?;
    let scene = work(py, None, || Scene::open(&path, normals))?;
    let lights = scene.lights.iter().map(light).collect();
    Ok((mesh(py, &scene.mesh)?, scene.cameras.into_iter().map(PyCamera).collect(), lights))
}

/// A mesh of one material from arrays; what is missing is made.
#[pyfunction]
fn build_mesh<'py>(
    py: Python<'py>,
    positions: &Bound<'py, PyAny>,
    faces: &Bound<'py, PyAny>,
    normals: Option<&Bound<'py, PyAny>>,
    uv_sets: Vec<Bound<'py, PyAny>>,
    colors: Option<&Bound<'py, PyAny>>,
    missing: &str,
) -> PyResult<Bound<'py, PyDict>> {
    let missing = Normals::parse("missing", missing)?;
    let given = Mesh {
        positions: vectors("positions", positions)?,
        normals: normals.map(|n| vectors("normals", n)).transpose()?.unwrap_or_default(),
        uv: uv_sets.iter().map(|set| vectors("uv", set)).collect::<PyResult<_>>()?,
        colors: colors.map(|c| vectors("colors", c)).transpose()?.unwrap_or_default(),
        faces: triangles("faces", faces)?,
        ..Mesh::default()
    };
    let made = work(py, None, || given.completed(missing))?;
    mesh(py, &made)
}

/// Rows of N numbers.
pub(super) fn vectors<const N: usize>(
    argument: &'static str,
    value: &Bound<'_, PyAny>,
) -> PyResult<Vec<[f32; N]>> {
    let array = FloatArray::new(argument, value, &[N], &format!("(..., {N})"))?;
    if array.shape().len() != 2 {
        return Err(Error::value(argument, format!("shape {:?}", array.shape()), format!("(V, {N})")).into());
    }
    Ok(match array.floats()? {
        Floats::F32(a) => a.as_chunks().0.to_vec(),
        Floats::F64(a) => a.as_chunks().0.iter().map(|row: &[f64; N]| row.map(|x| x as f32)).collect(),
    })
}

/// Angle-weighted normals (V, 3) of positions (V, 3) and faces (F, 3).
#[pyfunction]
fn vertex_normals<'py>(
    py: Python<'py>,
    positions: &Bound<'py, PyAny>,
    faces: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let positions = FloatArray::new("positions", positions, &[3], "(V, 3)")?.to_f64()?;
    let faces = triangles("faces", faces)?;
    let normals = work(py, None, || {
        let positions: Vec<[f32; 3]> =
            positions.as_chunks().0.iter().map(|p: &[f64; 3]| p.map(|c| c as f32)).collect();
        smooth_normals(&positions, &faces)
    })?;
    rows(py, &normals)
}

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyCamera>()?;
    module.add_function(wrap_pyfunction!(open_scene, module)?)?;
    module.add_function(wrap_pyfunction!(build_mesh, module)?)?;
    module.add_function(wrap_pyfunction!(vertex_normals, module)?)
}
