//! Baking, and simplifying before it.

use super::convert::{FloatArray, array, image_array, triangles, work, work_reporting};
use super::mesh::{mesh as mesh_parts, vectors as rows};
use super::texture::Texture;
use crate::bake::{Hit, Map, Method, Options, Paint, Space, bake, closest, intersect, layout};
use crate::encode::Encoding;
use crate::error::Error;
use crate::mesh::{Material, Mesh};
use crate::texel::DType;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The parts of a Python mesh that are geometry; materials keep their number only.
fn read_mesh(argument: &'static str, mesh: &Bound<'_, PyAny>) -> PyResult<Mesh> {
    let get = |name: &str| mesh.getattr(name);
    let list = |name| rows::<3>(argument, &get(name)?);
    let mut uv = Vec::new();
    for set in get("uv_sets")?.try_iter()? {
        uv.push(rows(argument, &set?)?);
    }
    let colors = get("colors")?;
    let faces = triangles(argument, &get("faces")?)?;
    let materials = get("materials")?.len()?;
    let face_material = get("face_material")?.call_method0("tolist")?.extract::<Vec<u32>>();
    Ok(Mesh {
        positions: list("positions")?,
        normals: list("normals")?,
        tangents: rows(argument, &get("tangents")?)?,
        uv,
        colors: if colors.is_none() { Vec::new() } else { rows(argument, &colors)? },
        faces,
        face_material: face_material
            .map_err(|e| Error::value(argument, format!("face_material ({e})"), "indices of materials"))?,
        materials: vec![Material::default(); materials],
        images: Vec::new(),
    })
}

/// Colour, texture, uv set and transform of a material.
type PaintParts<'py> = ([f32; 3], Option<PyRef<'py, Texture>>, usize, [[f32; 3]; 2]);

/// A baked map.
#[pyclass(frozen, module = "multum._multum")]
struct Baked(crate::bake::Baked);

#[pymethods]
impl Baked {
    /// (H, W) or (H, W, 3) codes.
    fn image<'py>(
        &self,
        py: Python<'py>,
        dtype: &str,
        encoding: &str,
        range: Option<[f64; 2]>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let dtype = match dtype {
            "uint8" => DType::U8,
            "uint16" => DType::U16,
            "float32" => DType::F32,
            other => return Err(Error::type_("dtype", other, "uint8, uint16 or float32").into()),
        };
        let encoding = Encoding::parse("encoding", encoding)?;
        let image = work(py, None, || self.0.image(dtype, encoding, range))?;
        image_array(py, image, self.0.channels() == 1)
    }

    /// Smallest and largest number found.
    fn range(&self) -> Option<[f32; 2]> {
        self.0.range()
    }

    /// (H, W) float32
    fn coverage<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let [w, h] = self.0.size();
        array(py, self.0.coverage().to_vec(), &[h, w])
    }

    /// (H, W) uint8
    fn flags<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let [w, h] = self.0.size();
        array(py, self.0.flags().to_vec(), &[h, w])
    }

    /// The counts, and a sentence for each thing that is not as it should be.
    fn report<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyDict>, Vec<String>)> {
        let report = self.0.report();
        let made = PyDict::new(py);
        made.set_item("texels", report.texels)?;
        made.set_item("covered", report.covered)?;
        made.set_item("missed", report.missed)?;
        made.set_item("partly_missed", report.partly_missed)?;
        made.set_item("ambiguous", report.ambiguous)?;
        made.set_item("overlapping", report.overlapping)?;
        made.set_item("rays", report.rays)?;
        made.set_item("distance", report.distance)?;
        made.set_item("mirrored_faces", report.mirrored_faces)?;
        made.set_item("degenerate_faces", report.degenerate_faces)?;
        made.set_item("outside_faces", report.outside_faces)?;
        made.set_item("non_manifold_edges", (report.non_manifold_edges[0], report.non_manifold_edges[1]))?;
        Ok((made, report.warnings()))
    }
}

/// Bakes a map. `what` is "normal", "height", "position", "occlusion", "curvature" or "color".
#[pyfunction]
#[pyo3(signature = (high, low, size, what, space, rays, radius, paints, samples, method, distance, cage, padding,
    threads, progress))]
#[allow(clippy::too_many_arguments, reason = "one for each keyword of the Python functions")]
fn bake_map(
    py: Python<'_>,
    high: &Bound<'_, PyAny>,
    low: &Bound<'_, PyAny>,
    size: (usize, usize),
    what: &str,
    space: &str,
    rays: usize,
    radius: f64,
    paints: Vec<PaintParts<'_>>,
    samples: usize,
    method: &str,
    distance: Option<f64>,
    cage: Option<&Bound<'_, PyAny>>,
    padding: Option<usize>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Baked> {
    let (high, low) = (read_mesh("high", high)?, read_mesh("low", low)?);
    let cage = cage.map(|places| rows("cage", places)).transpose()?;
    let options = Options { samples, method: Method::parse("method", method)?, distance, cage, padding };
    let paints: Vec<Paint<'_>> = paints
        .iter()
        .map(|(color, texture, uv_set, transform)| Paint {
            color: *color,
            texture: texture.as_ref().map(|texture| &texture.inner),
            uv_set: *uv_set,
            transform: *transform,
        })
        .collect();
    let map = match what {
        "normal" => Map::Normal(Space::parse("space", space)?),
        "height" => Map::Height,
        "position" => Map::Position,
        "occlusion" => Map::Occlusion { rays, radius },
        "curvature" => Map::Curvature,
        _ => Map::Color(&paints),
    };
    work_reporting(py, threads, progress, || bake(&high, &low, &map, [size.0, size.1], &options).map(Baked))
}

/// Faces (...), distances (...) and weights (..., 3).
type Places<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>);

fn places<'py>(py: Python<'py>, hits: &[Hit], shape: &[usize]) -> PyResult<Places<'py>> {
    let weights: Vec<f64> = hits.iter().flat_map(|h| h.barycentric).collect();
    Ok((
        array(py, hits.iter().map(|h| h.face).collect::<Vec<_>>(), shape)?,
        array(py, hits.iter().map(|h| h.distance).collect::<Vec<_>>(), shape)?,
        array(py, weights, &[shape, &[3]].concat())?,
    ))
}

/// The first hits of rays (..., 3).
#[pyfunction]
fn cast_rays<'py>(
    py: Python<'py>,
    positions: &Bound<'py, PyAny>,
    faces: &Bound<'py, PyAny>,
    origins: &Bound<'py, PyAny>,
    directions: &Bound<'py, PyAny>,
    threads: Option<usize>,
) -> PyResult<Places<'py>> {
    let positions = rows("positions", positions)?;
    let faces = triangles("faces", faces)?;
    let origins = FloatArray::new("origins", origins, &[3], "(..., 3)")?;
    let directions = FloatArray::new("directions", directions, &[3], "(..., 3)")?;
    if origins.shape() != directions.shape() {
        let got = format!("shape {:?}", directions.shape());
        return Err(Error::value("directions", got, format!("that of origins, {:?}", origins.shape())).into());
    }
    let (o, d) = (origins.to_f64()?, directions.to_f64()?);
    let rays: Vec<_> = o.as_chunks().0.iter().copied().zip(d.as_chunks().0.iter().copied()).collect();
    let hits = work(py, threads, || intersect(&positions, &faces, &rays))?;
    places(py, &hits, origins.leading(1))
}

/// The closest places to points (..., 3).
#[pyfunction]
fn closest_points<'py>(
    py: Python<'py>,
    positions: &Bound<'py, PyAny>,
    faces: &Bound<'py, PyAny>,
    points: &Bound<'py, PyAny>,
    threads: Option<usize>,
) -> PyResult<Places<'py>> {
    let positions = rows("positions", positions)?;
    let faces = triangles("faces", faces)?;
    let points = FloatArray::new("points", points, &[3], "(..., 3)")?;
    let numbers = points.to_f64()?;
    let hits = work(py, threads, || closest(&positions, &faces, numbers.as_chunks().0))?;
    places(py, &hits, points.leading(1))
}

/// Texels that faces touch, texels that several share, and the faces that share.
#[pyfunction]
fn uv_layout<'py>(
    py: Python<'py>,
    uv: &Bound<'py, PyAny>,
    faces: &Bound<'py, PyAny>,
    size: (usize, usize),
    samples: usize,
) -> PyResult<(usize, usize, Bound<'py, PyAny>)> {
    let uv = rows("uv", uv)?;
    let faces = triangles("faces", faces)?;
    let found = work(py, None, || layout(&uv, &faces, [size.0, size.1], samples))?;
    let count = found.shared.len();
    Ok((found.touched, found.overlapping, array(py, found.shared, &[count])?))
}

/// The parts of a mesh with fewer faces; materials and pictures stay as they are.
#[pyfunction]
fn simplify_mesh<'py>(py: Python<'py>, mesh: &Bound<'py, PyAny>, ratio: f64) -> PyResult<Bound<'py, PyDict>> {
    let given = read_mesh("mesh", mesh)?;
    mesh_parts(py, &work(py, None, || given.simplified(ratio))?)
}

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Baked>()?;
    module.add_function(wrap_pyfunction!(bake_map, module)?)?;
    module.add_function(wrap_pyfunction!(cast_rays, module)?)?;
    module.add_function(wrap_pyfunction!(closest_points, module)?)?;
    module.add_function(wrap_pyfunction!(uv_layout, module)?)?;
    module.add_function(wrap_pyfunction!(simplify_mesh, module)?)
}
