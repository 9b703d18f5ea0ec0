//! Mapping functions.

use super::convert::{FloatArray, Floats, array, work};
use crate::error::{Error, Result};
use crate::mapping::surface::Surface as AnySurface;
use crate::mapping::{self, Axis, FisheyeModel, Intermediate, Layout, Numbers, Output, Projection};
use glam::{DMat4, DVec2, DVec3};
use pyo3::prelude::*;

type Pair = [f64; 2];
type Triple = [f64; 3];

/// A map with its parameters, checked.
#[pyclass(frozen, module = "multum._multum")]
pub struct Mapping {
    inner: Box<dyn mapping::Mapping>,
    /// Set where the answer is (face, s, t).
    faces: Option<mapping::Cube>,
}

impl Mapping {
    fn from_map(map: impl mapping::Mapping + 'static) -> Self {
        Self { inner: Box::new(map), faces: None }
    }
}

fn numbers<'a>(array: &'a FloatArray<'_>) -> Result<Numbers<'a>> {
    Ok(match array.floats()? {
        Floats::F32(a) => Numbers::F32(a),
        Floats::F64(a) => Numbers::F64(a),
    })
}

/// Borrows an array that, where it is given, has the shape of the points.
fn beside<'py>(
    argument: &'static str,
    value: Option<&Bound<'py, PyAny>>,
    leading: &[usize],
    trailing: &[usize],
) -> PyResult<Option<FloatArray<'py>>> {
    let Some(value) = value else { return Ok(None) };
    let shape = [leading, trailing].concat();
    FloatArray::new(argument, value, &shape, &format!("{shape:?}")).map(Some)
}

/// Two arrays or none.
fn both<'a>(arrays: &'a [Option<FloatArray<'_>>; 2]) -> Result<Option<[Numbers<'a>; 2]>> {
    match arrays {
        [Some(a), Some(b)] => Ok(Some([numbers(a)?, numbers(b)?])),
        _ => Ok(None),
    }
}

/// Room for `sizes` numbers for each of `count` points, filled by `job`, in the precision of `like`.
fn filled<'py>(
    py: Python<'py>,
    like: &FloatArray<'_>,
    leading: &[usize],
    trailing: [&[usize]; 2],
    want_second: bool,
    job: impl Fn(Output<'_>, Option<Output<'_>>) -> Result<()> + Send + Sync,
) -> PyResult<(Bound<'py, PyAny>, Option<Bound<'py, PyAny>>)> {
    let shapes = trailing.map(|t| [leading, t].concat());
    let sizes = [0, 1].map(|i| shapes[i].iter().product::<usize>());
    let second_size = if want_second { sizes[1] } else { 0 };
    macro_rules! typed {
        ($variant:ident, $zero:expr) => {{
            let (first, second) = work(py, None, || {
                let (mut first, mut second) = (vec![$zero; sizes[0]], vec![$zero; second_size]);
                job(Output::$variant(&mut first), want_second.then(|| Output::$variant(&mut second)))?;
                Ok((first, second))
            })?;
            let second = want_second.then(|| array(py, second, &shapes[1])).transpose()?;
            Ok((array(py, first, &shapes[0])?, second))
        }};
    }
    match like {
        FloatArray::F32(_) => typed!(F32, 0f32),
        FloatArray::F64(_) => typed!(F64, 0f64),
    }
}

#[pymethods]
impl Mapping {
    #[staticmethod]
    fn planar(axis: &str, min: Triple, max: Triple) -> PyResult<Self> {
        let axis = Axis::parse("axis", axis)?;
        Ok(Self::from_map(mapping::Planar::new(axis, min.into(), max.into())?))
    }

    #[staticmethod]
    fn facets(min: Triple, max: Triple) -> PyResult<Self> {
        Ok(Self::from_map(mapping::Facets::new(min.into(), max.into())?))
    }

    #[staticmethod]
    fn cube(layout: &str, center: Triple) -> PyResult<Self> {
        let faces = layout == "faces";
        let layout = if faces { Layout::Cross } else { Layout::parse("layout", layout)? };
        let cube = mapping::Cube::new(layout, center.into())?;
        Ok(Self { inner: Box::new(cube), faces: faces.then_some(cube) })
    }

    #[staticmethod]
    fn spherical(axis: &str, center: Triple) -> PyResult<Self> {
        Ok(Self::from_map(mapping::Spherical::new(Axis::parse("axis", axis)?, center.into())?))
    }

    #[staticmethod]
    fn cylindrical(axis: &str, center: Triple, height: Pair) -> PyResult<Self> {
        let axis = Axis::parse("axis", axis)?;
        Ok(Self::from_map(mapping::Cylindrical::new(axis, center.into(), height)?))
    }

    #[staticmethod]
    fn linear(a: f64, b: f64, c: f64, d: f64, e: f64, f: f64) -> PyResult<Self> {
        Ok(Self::from_map(mapping::Linear::new(a, b, c, d, e, f)?))
    }

    #[staticmethod]
    fn patch(s: Pair, t: Pair, u: Pair, v: Pair) -> PyResult<Self> {
        Ok(Self::from_map(mapping::Patch::new(s, t, u, v)?))
    }

    #[staticmethod]
    #[allow(clippy::too_many_arguments, reason = "one for each keyword of the Python class")]
    fn two_stage(
        intermediate: &str,
        projection: &str,
        eye: Option<Triple>,
        center: Triple,
        radius: f64,
        axis: &str,
        height: Pair,
        layout: &str,
    ) -> PyResult<Self> {
        let surface = match intermediate {
            "sphere" => Intermediate::Sphere,
            "cylinder" => Intermediate::Cylinder(height),
            "plane" => Intermediate::Plane,
            "cube" => Intermediate::Cube(Layout::parse("layout", layout)?),
            _ => {
                let expected = "\"sphere\", \"cylinder\", \"plane\" or \"cube\"";
                return Err(Error::value("intermediate", format!("{intermediate:?}"), expected).into());
            }
        };
        let rule = match (projection, eye) {
            ("centroid", _) => Projection::Centroid,
            ("object_normal", _) => Projection::ObjectNormal,
            ("intermediate_normal", _) => Projection::IntermediateNormal,
            ("reflected_ray", Some(eye)) => Projection::ReflectedRay(eye.into()),
            ("reflected_ray", None) => {
                return Err(
                    Error::value("eye", "None", "the eye's position (x, y, z) for reflected rays").into()
                );
            }
            _ => {
                let expected =
                    "\"centroid\", \"object_normal\", \"intermediate_normal\" or \"reflected_ray\"";
                return Err(Error::value("projection", format!("{projection:?}"), expected).into());
            }
        };
        let axis = Axis::parse("axis", axis)?;
        Ok(Self::from_map(mapping::TwoStage::new(surface, rule, center.into(), radius, axis)?))
    }

    #[staticmethod]
    fn direction(kind: &str) -> PyResult<Self> {
        Ok(match kind {
            "sphere_map" => Self::from_map(mapping::SphereMap),
            "light_probe" => Self::from_map(mapping::LightProbe),
            "mirror_ball" => Self::from_map(mapping::MirrorBall),
            "equirect" => Self::from_map(mapping::Equirect),
            "dual_paraboloid" => Self::from_map(mapping::DualParaboloid),
            "octahedral" => Self::from_map(mapping::Octahedral),
            _ => {
                return Err(
                    Error::value("kind", format!("{kind:?}"), "the name of a map of directions").into()
                );
            }
        })
    }

    #[staticmethod]
    fn stereographic(fov: f64) -> PyResult<Self> {
        Ok(Self::from_map(mapping::Stereographic::new(fov.to_radians())?))
    }

    #[staticmethod]
    fn fisheye(model: &str, fov: f64) -> PyResult<Self> {
        let model = FisheyeModel::parse("model", model)?;
        Ok(Self::from_map(mapping::Fisheye::new(model, fov.to_radians())?))
    }

    #[staticmethod]
    fn perspective(fov: f64, aspect: f64) -> PyResult<Self> {
        Ok(Self::from_map(mapping::Perspective::new(fov.to_radians(), aspect)?))
    }

    #[staticmethod]
    fn projective(rows: [[f64; 4]; 4], back_faces: bool) -> PyResult<Self> {
        let map = mapping::Projective::new(DMat4::from_cols_array_2d(&rows).transpose())?;
        Ok(Self::from_map(if back_faces { map } else { map.front_only()? }))
    }

    #[staticmethod]
    fn polygon(corners: Vec<Triple>, uv: Vec<Pair>) -> PyResult<Self> {
        let corners: Vec<DVec3> = corners.into_iter().map(DVec3::from).collect();
        let uv: Vec<DVec2> = uv.into_iter().map(DVec2::from).collect();
        Ok(Self::from_map(mapping::Polygon::new(&corners, &uv)?))
    }

    #[getter]
    fn dimensions(&self) -> usize {
        self.inner.dimensions()
    }

    #[getter]
    fn has_inverse(&self) -> bool {
        self.inner.has_inverse()
    }

    #[getter]
    fn needs_normals(&self) -> bool {
        self.inner.needs_normals()
    }

    #[allow(clippy::too_many_arguments, reason = "one for each argument of the Python call")]
    fn apply<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
        normals: Option<&Bound<'py, PyAny>>,
        dpdx: Option<&Bound<'py, PyAny>>,
        dpdy: Option<&Bound<'py, PyAny>>,
        dndx: Option<&Bound<'py, PyAny>>,
        dndy: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<(Bound<'py, PyAny>, Option<Bound<'py, PyAny>>)> {
        let size = self.inner.dimensions();
        let points = FloatArray::new("points", points, &[size], &format!("(..., {size})"))?;
        let leading = points.leading(1);
        let normals = beside("normals", normals, leading, &[3])?;
        let dp = [beside("dpdx", dpdx, leading, &[size])?, beside("dpdy", dpdy, leading, &[size])?];
        let dn = [beside("dndx", dndx, leading, &[3])?, beside("dndy", dndy, leading, &[3])?];
        let input = mapping::Input {
            points: numbers(&points)?,
            normals: normals.as_ref().map(numbers).transpose()?,
            dp: both(&dp)?,
            dn: both(&dn)?,
        };
        let first: &[usize] = if self.faces.is_some() { &[3] } else { &[2] };
        let want_jacobian = input.dp.is_some();
        filled(py, &points, leading, [first, &[2, 2]], want_jacobian, |uv, jacobian| match &self.faces {
            Some(cube) => mapping::faces_batch(cube, input, uv, jacobian),
            None => mapping::map_batch(&*self.inner, input, uv, jacobian),
        })
    }

    fn inverse<'py>(&self, py: Python<'py>, uv: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let (size, name) = if self.faces.is_some() { (3, "(..., 3): face, s, t") } else { (2, "(..., 2)") };
        let uv = FloatArray::new("uv", uv, &[size], name)?;
        let input = numbers(&uv)?;
        let trailing = [self.inner.dimensions()];
        let made = filled(py, &uv, uv.leading(1), [&trailing, &[]], false, |points, _| match &self.faces {
            Some(cube) => mapping::faces_inverse_batch(cube, input, points),
            None => mapping::inverse_batch(&*self.inner, input, points),
        })?;
        Ok(made.0)
    }
}

/// A parametric surface, checked.
#[pyclass(frozen, module = "multum._multum")]
pub struct Surface(AnySurface);

#[pymethods]
impl Surface {
    #[staticmethod]
    fn sphere(radius: f64, center: Triple) -> PyResult<Self> {
        Ok(Self(AnySurface::Sphere { center: center.into(), radius }.checked()?))
    }

    #[staticmethod]
    fn cylinder(radius: f64, height: Pair, center: Triple) -> PyResult<Self> {
        Ok(Self(AnySurface::Cylinder { center: center.into(), radius, height }.checked()?))
    }

    #[staticmethod]
    fn torus(major: f64, minor: f64, center: Triple) -> PyResult<Self> {
        Ok(Self(AnySurface::Torus { center: center.into(), major, minor }.checked()?))
    }

    #[staticmethod]
    fn bezier(control: [[Triple; 4]; 4]) -> PyResult<Self> {
        let net = control.map(|row| row.map(DVec3::from));
        Ok(Self(AnySurface::Bezier(Box::new(net)).checked()?))
    }

    fn at<'py>(&self, py: Python<'py>, uv: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let uv = FloatArray::new("uv", uv, &[2], "(..., 2)")?;
        let input = numbers(&uv)?;
        Ok(filled(py, &uv, uv.leading(1), [&[4, 3], &[]], false, |out, _| self.0.batch(input, out))?.0)
    }
}

/// The checkerboard at every uv.
#[pyfunction]
fn checkerboard<'py>(
    py: Python<'py>,
    uv: &Bound<'py, PyAny>,
    cells: Pair,
    jacobian: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let uv = FloatArray::new("uv", uv, &[2], "(..., 2)")?;
    let leading = uv.leading(1);
    let jacobian = beside("jacobian", jacobian, leading, &[2, 2])?;
    let (input, j) = (numbers(&uv)?, jacobian.as_ref().map(numbers).transpose()?);
    let fill =
        |out: Output<'_>, _: Option<Output<'_>>| mapping::checkerboard::batch(input, j, cells.into(), out);
    Ok(filled(py, &uv, leading, [&[], &[]], false, fill)?.0)
}

/// Barycentric weights and whether each point is inside (1 or 0).
#[pyfunction]
fn barycentric<'py>(
    py: Python<'py>,
    points: &Bound<'py, PyAny>,
    triangle: &Bound<'py, PyAny>,
) -> PyResult<(Bound<'py, PyAny>, Option<Bound<'py, PyAny>>)> {
    let points = FloatArray::new("points", points, &[2], "(..., 2)")?;
    let triangle = FloatArray::new("triangle", triangle, &[3, 2], "(3, 2) or (..., 3, 2)")?;
    let (input, corners) = (numbers(&points)?, numbers(&triangle)?);
    filled(py, &points, points.leading(1), [&[3], &[]], true, |weights, inside| match inside {
        Some(inside) => mapping::barycentric::batch(input, corners, weights, inside),
        None => Ok(()),
    })
}

/// Both singular values, area and angle stretch of every Jacobian.
#[pyfunction]
fn distortion<'py>(py: Python<'py>, jacobian: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let jacobian = FloatArray::new("jacobian", jacobian, &[2, 2], "(..., 2, 2)")?;
    let input = numbers(&jacobian)?;
    let fill = |out: Output<'_>, _: Option<Output<'_>>| mapping::distortion::batch(input, out);
    Ok(filled(py, &jacobian, jacobian.leading(2), [&[4], &[]], false, fill)?.0)
}

/// Two unit tangents for every normal.
#[pyfunction]
fn tangents<'py>(py: Python<'py>, normals: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let normals = FloatArray::new("normals", normals, &[3], "(..., 3)")?;
    let input = numbers(&normals)?;
    let fill = |out: Output<'_>, _: Option<Output<'_>>| mapping::distortion::tangents_batch(input, out);
    Ok(filled(py, &normals, normals.leading(1), [&[2, 3], &[]], false, fill)?.0)
}

/// Coefficients of the inverse of a linear map.
#[pyfunction]
fn linear_inverse(a: f64, b: f64, c: f64, d: f64, e: f64, f: f64) -> PyResult<[f64; 6]> {
    Ok(mapping::Linear::new(a, b, c, d, e, f)?.inverse()?.coefficients())
}

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Mapping>()?;
    module.add_class::<Surface>()?;
    module.add_function(wrap_pyfunction!(linear_inverse, module)?)?;
    module.add_function(wrap_pyfunction!(checkerboard, module)?)?;
    module.add_function(wrap_pyfunction!(barycentric, module)?)?;
    module.add_function(wrap_pyfunction!(distortion, module)?)?;
    module.add_function(wrap_pyfunction!(tangents, module)?)
}
