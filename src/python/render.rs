//! Rendering.

use super::convert::{ImageArg, array, indices, triangles, work};
use super::mesh::{LightParts, PyCamera, vectors};
use super::texture::Sampling;
use crate::encode::Encoding;
use crate::error::Error;
use crate::filter::Filter;
use crate::image::{AnyView, Image, for_any};
use crate::mapping::Layout;
use crate::mesh::{
    AlphaMode, Blend, ImageSource, Layer, Light, Material, Mesh, Model, NormalSpace, TextureSlot,
};
use crate::render::{Debug, Options, Report, ShadowOptions, TextureUse, View, render as draw, render_srgb8};
use crate::shade::{Environment, EnvironmentOptions, Ray, SkyForm, bumped};
use crate::wrap::Wrap;
use glam::{DMat3, DVec3, Vec3};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::path::PathBuf;
use std::sync::Arc;

/// Textures kept from one picture to the next.
#[pyclass(name = "Textures", frozen, module = "multum._multum")]
struct PyTextures(crate::render::Textures);

#[pymethods]
impl PyTextures {
    #[new]
    fn new() -> Self {
        Self(crate::render::Textures::new())
    }
}

/// A value of a dictionary that a dataclass became.
fn get<'py, T: for<'a> FromPyObject<'a, 'py>>(
    fields: &Bound<'py, PyDict>,
    name: &'static str,
) -> PyResult<T> {
    let value = fields.get_item(name)?;
    let value = value.ok_or_else(|| Error::type_(name, "nothing", "a value"))?;
    value.extract().map_err(|_| {
        let got = value.repr().map_or_else(|_| "an object".into(), |r| r.to_string());
        Error::type_(name, got, "a value of the documented type").into()
    })
}

fn slot(name: &'static str, fields: &Bound<'_, PyDict>) -> PyResult<TextureSlot> {
    let word = |argument: &'static str| -> PyResult<Option<&'static str>> {
        let Some(name) = get::<Option<String>>(fields, argument)? else { return Ok(None) };
        let found = Filter::NAMES.iter().find(|(n, _)| *n == name).map(|(n, _)| *n);
        Ok(Some(found.ok_or_else(|| Error::value(argument, format!("{name:?}"), "the name of a filter"))?))
    };
    let transform =
        fields.get_item("transform")?.ok_or_else(|| Error::type_(name, "nothing", "a transform"))?;
    let rows: Vec<[f32; 3]> = vectors("transform", &transform)?;
    let [a, b] = rows[..] else {
        return Err(Error::value("transform", format!("{} rows", rows.len()), "shape (2, 3)").into());
    };
    if !(a.iter().chain(&b)).all(|x| x.is_finite()) {
        return Err(Error::value("transform", format!("{a:?}, {b:?}"), "finite numbers").into());
    }
    let (u, v) = get::<(String, String)>(fields, "wrap")?;
    Ok(TextureSlot {
        image: get(fields, "image")?,
        uv_set: get(fields, "uv_set")?,
        transform: [a, b],
        wrap: [Wrap::parse("wrap", &u)?, Wrap::parse("wrap", &v)?],
        mag_filter: word("mag_filter")?,
        min_filter: word("min_filter")?,
        encoding: Encoding::parse("encoding", &get::<String>(fields, "encoding")?)?,
    })
}

fn material(fields: &Bound<'_, PyDict>) -> PyResult<Material> {
    let texture = |name: &'static str| -> PyResult<Option<TextureSlot>> {
        get::<Option<Bound<'_, PyDict>>>(fields, name)?.map(|s| slot(name, &s)).transpose()
    };
    let alpha_mode = match get::<String>(fields, "alpha_mode")?.as_str() {
        "opaque" => AlphaMode::Opaque,
        "mask" => AlphaMode::Mask(get(fields, "alpha_cutoff")?),
        "blend" => AlphaMode::Blend,
        other => {
            let expected = "\"opaque\", \"mask\" or \"blend\"";
            return Err(Error::value("alpha_mode", format!("{other:?}"), expected).into());
        }
    };
    let layers: Vec<(Bound<'_, PyDict>, String, bool)> = get(fields, "layers")?;
    let layer = |(texture, blend, after_light): &(Bound<'_, PyDict>, String, bool)| -> PyResult<Layer> {
        let blend = Blend::parse("blend", blend)?;
        Ok(Layer { texture: slot("layers", texture)?, blend, after_light: *after_light })
    };
    let made = Material {
        name: get(fields, "name")?,
        model: Model::parse("model", &get::<String>(fields, "model")?)?,
        base_color: get(fields, "base_color")?,
        base_color_texture: texture("base_color_texture")?,
        alpha_texture: texture("alpha_texture")?,
        metallic: get(fields, "metallic")?,
        roughness: get(fields, "roughness")?,
        metallic_roughness_texture: texture("metallic_roughness_texture")?,
        normal_texture: texture("normal_texture")?,
        normal_scale: get(fields, "normal_scale")?,
        normal_space: NormalSpace::parse("normal_space", &get::<String>(fields, "normal_space")?)?,
        bump_texture: texture("bump_texture")?,
        bump_scale: get(fields, "bump_scale")?,
        displacement_texture: texture("displacement_texture")?,
        displacement_scale: get(fields, "displacement_scale")?,
        displacement_offset: get(fields, "displacement_offset")?,
        occlusion_texture: texture("occlusion_texture")?,
        occlusion_strength: get(fields, "occlusion_strength")?,
        emissive: get(fields, "emissive")?,
        emissive_texture: texture("emissive_texture")?,
        ambient: get(fields, "ambient")?,
        specular: get(fields, "specular")?,
        mirror: get(fields, "mirror")?,
        specular_texture: texture("specular_texture")?,
        shininess: get(fields, "shininess")?,
        shininess_texture: texture("shininess_texture")?,
        layers: layers.iter().map(layer).collect::<PyResult<_>>()?,
        alpha_mode,
        double_sided: get(fields, "double_sided")?,
        unlit: get(fields, "unlit")?,
    };
    Ok(made)
}

type ImageParts<'py> = (String, Option<PathBuf>, Option<Bound<'py, PyBytes>>, Option<Bound<'py, PyAny>>);

fn image((name, path, bytes, pixels): ImageParts<'_>) -> PyResult<ImageSource> {
    if let Some(pixels) = pixels {
        let pixels = ImageArg::new("pixels", &pixels)?;
        let made = for_any!(AnyView, pixels.view()?, view => {
            let data: Vec<_> = (0..view.height()).flat_map(|y| view.row(y).iter().copied()).collect();
            Image::new(view.width(), view.height(), view.channels(), data)?
        });
        return Ok(ImageSource::Pixels(Arc::new(made)));
    }
    Ok(match (path, bytes) {
        (Some(path), _) => ImageSource::File(path),
        (None, Some(bytes)) => ImageSource::Embedded { name, bytes: bytes.as_bytes().into() },
        (None, None) => ImageSource::Missing(name),
    })
}

/// A mesh from the dictionary that the Python class becomes.
fn mesh(parts: &Bound<'_, PyDict>) -> PyResult<Mesh> {
    let item = |name: &'static str| -> PyResult<Bound<'_, PyAny>> { get(parts, name) };
    let sets: Vec<Bound<'_, PyAny>> = get(parts, "uv_sets")?;
    let colors: Option<Bound<'_, PyAny>> = get(parts, "colors")?;
    let materials: Vec<Bound<'_, PyDict>> = get(parts, "materials")?;
    let images: Vec<ImageParts<'_>> = get(parts, "images")?;
    Ok(Mesh {
        positions: vectors("positions", &item("positions")?)?,
        normals: vectors("normals", &item("normals")?)?,
        tangents: vectors("tangents", &item("tangents")?)?,
        uv: sets.iter().map(|set| vectors("uv", set)).collect::<PyResult<_>>()?,
        colors: colors.map(|c| vectors("colors", &c)).transpose()?.unwrap_or_default(),
        faces: triangles("faces", &item("faces")?)?,
        face_material: indices("face_material", &item("face_material")?)?,
        materials: materials.iter().map(material).collect::<PyResult<_>>()?,
        images: images.into_iter().map(image).collect::<PyResult<_>>()?,
    })
}

fn light((kind, vector, color, falloff, cone): LightParts) -> Light {
    match kind.as_str() {
        "ambient" => Light::Ambient { color },
        "directional" => Light::Directional { direction: vector, color },
        _ => Light::Point { position: vector, color, falloff, cone },
    }
}

/// A mesh as the crate has it; what draws it checks it.
#[pyclass(name = "Drawing", frozen, module = "multum._multum")]
struct PyDrawing {
    mesh: Mesh,
}

#[pymethods]
impl PyDrawing {
    #[new]
    fn new(parts: &Bound<'_, PyDict>) -> PyResult<Self> {
        Ok(Self { mesh: mesh(parts)? })
    }

    /// The picture, (H, W, 4), and what its textures were used for.
    #[allow(clippy::too_many_arguments, reason = "one for each keyword of the Python function")]
    fn render<'py>(
        &self,
        py: Python<'py>,
        textures: &PyTextures,
        camera: &PyCamera,
        lights: Option<Vec<LightParts>>,
        size: (usize, usize),
        sampling: &Sampling,
        file_filters: bool,
        environment: Option<&PyEnvironment>,
        background: [f32; 4],
        show_environment: bool,
        shadows: Option<(usize, f32)>,
        bump_curvature: bool,
        displacement_edge_px: f64,
        supersample: usize,
        debug: Option<&str>,
        report: bool,
        linear: bool,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(Bound<'py, PyAny>, Vec<TextureParts>)> {
        let lights: Option<Vec<Light>> = lights.map(|list| list.into_iter().map(light).collect());
        let options = Options {
            sampler: sampling.sampler,
            file_filters,
            background,
            show_environment,
            shadows: shadows.map(|(size, softness)| ShadowOptions { size, softness }),
            bump_curvature,
            displacement_edge_px,
            supersample,
            debug: debug.map(|name| Debug::parse("debug", name)).transpose()?,
            report,
        };
        let view = View {
            mesh: &self.mesh,
            textures: &textures.0,
            camera: &camera.0,
            lights: lights.as_deref(),
            environment: environment.map(|e| &e.0),
        };
        let mut tell = |done: f64| {
            Python::attach(|py| {
                let told = progress.as_ref().map_or(Ok(()), |f| f.call1(py, (done,)).map(drop));
                told.and_then(|()| py.check_signals()).map_err(|e| e.restore(py)).is_err()
            })
        };
        let shape = [size.1, size.0, 4];
        let uses = |report: Option<&Report>| {
            report.map_or_else(Vec::new, |r| r.textures.iter().map(parts).collect::<Vec<_>>())
        };
        if linear {
            let picture = work(py, sampling.threads, || draw(&view, size, &options, &mut tell))?;
            let uses = uses(picture.report());
            return Ok((array(py, picture.into_pixels().into_flattened(), &shape)?, uses));
        }
        let (codes, report) = work(py, sampling.threads, || render_srgb8(&view, size, &options, &mut tell))?;
        Ok((array(py, codes, &shape)?, uses(report.as_ref())))
    }
}

/// Image, name, size, reads, histogram, touched, recommended.
type TextureParts = (usize, String, (usize, usize), u64, Vec<u64>, f64, (usize, usize));

fn parts(t: &TextureUse) -> TextureParts {
    (t.image, t.name.clone(), t.size, t.reads, t.histogram.clone(), t.touched, t.recommended)
}

/// Light from all sides.
#[pyclass(name = "Environment", frozen, module = "multum._multum")]
pub struct PyEnvironment(Environment);

#[pymethods]
impl PyEnvironment {
    #[new]
    fn new(
        py: Python<'_>,
        image: &Bound<'_, PyAny>,
        form: &str,
        layout: &str,
        encoding: &str,
        yaw_rad: f64,
        intensity: f32,
    ) -> PyResult<Self> {
        let (shape, follows_eye) = match form {
            "equirect" => (SkyForm::Equirect, false),
            "cube" => (SkyForm::Cube(Layout::parse("layout", layout)?), false),
            "probe" => (SkyForm::LightProbe, false),
            "mirror_ball" => (SkyForm::MirrorBall, false),
            "sphere_map" => (SkyForm::MirrorBall, true),
            _ => {
                let expected = "\"equirect\", \"cube\", \"probe\", \"mirror_ball\" or \"sphere_map\"";
                return Err(Error::value("form", format!("{form:?}"), expected).into());
            }
        };
        let options = EnvironmentOptions {
            form: shape,
            follows_eye,
            encoding: Encoding::parse("encoding", encoding)?,
            yaw_rad,
            intensity,
        };
        let image = ImageArg::new("image", image)?;
        let view = image.view()?;
        Ok(Self(work(py, None, || Environment::new(view, &options))?))
    }

    /// What a white surface with each of these unit normals shows.
    fn diffuse<'py>(&self, py: Python<'py>, normals: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let normals: Vec<[f32; 3]> = vectors("normals", normals)?;
        let light = |n: &[f32; 3]| self.0.diffuse((*n).into(), DMat3::IDENTITY).to_array();
        let out: Vec<[f32; 3]> = normals.iter().map(light).collect();
        array(py, out.as_flattened().to_vec(), &[normals.len(), 3])
    }

    /// The light along each direction, averaged by a lobe and over a movement.
    fn radiance<'py>(
        &self,
        py: Python<'py>,
        directions: &Bound<'py, PyAny>,
        moving: Option<&Bound<'py, PyAny>>,
        exponent: f32,
        sampling: &Sampling,
    ) -> PyResult<Bound<'py, PyAny>> {
        let directions: Vec<[f32; 3]> = vectors("directions", directions)?;
        let moving: Vec<[f32; 3]> = moving.map_or(Ok(Vec::new()), |m| vectors("moving", m))?;
        if !moving.is_empty() && moving.len() != 2 * directions.len() {
            let expected = format!("two for each direction, {}", 2 * directions.len());
            return Err(Error::value("moving", format!("{} vectors", moving.len()), expected).into());
        }
        let place = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let rays: Vec<Ray> = directions
            .iter()
            .enumerate()
            .map(|(i, &d)| Ray {
                direction: place(d),
                moving: [0, 1].map(|k| moving.get(2 * i + k).map_or(DVec3::ZERO, |m| place(*m))),
            })
            .collect();
        let exponents = vec![exponent; rays.len()];
        let light = work(py, sampling.threads, || {
            self.0.mirrored(&rays, &exponents, DMat3::IDENTITY, &sampling.sampler)
        })?;
        let numbers = light.iter().flat_map(|c| c.to_array()).collect();
        array(py, numbers, &[directions.len(), 3])
    }
}

/// Normals of surfaces moved by a height: one for each row.
#[pyfunction]
#[pyo3(signature = (p_u, p_v, normals, slopes, heights, n_u, n_v))]
#[allow(clippy::too_many_arguments, reason = "one for each vector of the formula")]
fn bumped_normals<'py>(
    py: Python<'py>,
    p_u: &Bound<'py, PyAny>,
    p_v: &Bound<'py, PyAny>,
    normals: &Bound<'py, PyAny>,
    slopes: &Bound<'py, PyAny>,
    heights: Option<&Bound<'py, PyAny>>,
    n_u: Option<&Bound<'py, PyAny>>,
    n_v: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let rows = |name, v: &Bound<'py, PyAny>| vectors::<3>(name, v);
    let (p_u, p_v, n) = (rows("p_u", p_u)?, rows("p_v", p_v)?, rows("normals", normals)?);
    let slopes: Vec<[f32; 2]> = vectors("slopes", slopes)?;
    let curved = match (heights, n_u, n_v) {
        (Some(d), Some(u), Some(v)) => Some((vectors::<1>("heights", d)?, rows("n_u", u)?, rows("n_v", v)?)),
        _ => None,
    };
    let lens = [("p_u", p_u.len()), ("p_v", p_v.len()), ("slopes", slopes.len())].into_iter().chain(
        curved.iter().flat_map(|(d, u, v)| [("heights", d.len()), ("n_u", u.len()), ("n_v", v.len())]),
    );
    for (name, len) in lens {
        if len != n.len() {
            return Err(Error::value(
                name,
                format!("{len} rows"),
                format!("as many as normals, {}", n.len()),
            )
            .into());
        }
    }
    let made: Vec<[f32; 3]> = (0..n.len())
        .map(|i| {
            let curvature = curved.as_ref().map(|(d, u, v)| (d[i][0], [Vec3::from(u[i]), Vec3::from(v[i])]));
            bumped([p_u[i].into(), p_v[i].into()], n[i].into(), slopes[i], curvature).to_array()
        })
        .collect();
    array(py, made.as_flattened().to_vec(), &[n.len(), 3])
}

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyTextures>()?;
    module.add_class::<PyDrawing>()?;
    module.add_class::<PyEnvironment>()?;
    module.add_function(wrap_pyfunction!(bumped_normals, module)?)
}
