//! From a mesh, a camera and lights to a picture.
//!
//! ```text
//!  displacement faces cut to the size of pixels and moved by height maps
//!  shadows      depth textures from every light, where they are asked for
//!  bands        faces sorted by the rows that they reach; what follows is done for some rows at a time
//!  visibility   opaque faces: the nearest at each pixel; the others: layer behind layer, front to back
//!  batches      the pixels of some rows, sorted by material
//!  textures     each texture of a material in one call, with the uv and Jacobians of the whole batch
//!  light        Phong for each pixel of the batch; the environment by its reflected rays
//!  compositing  premultiplied, in linear light, front over back, then over the background
//!  finish       the mean of supersamples; codes for the screen, where these are wanted
//! ```
//!
//! Bands are cut by the picture alone, so its bytes do not depend on the number of threads.

mod band;
mod batch;
mod debug;
mod displace;
mod light;
mod picture;
mod report;
mod shadow;
mod surface;
mod textures;

use crate::error::{Error, Result};
use crate::filter::Filter;
use crate::mesh::{Camera, Light, Mesh};
use crate::par;
use crate::raster::{Geometry, MAX_SIDE, Projected};
use crate::sampler::Sampler;
use crate::shade::{Environment, Lights, Ray, over};
use glam::{DMat3, DVec3};
use picture::{Finish, Rows};
use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

pub use debug::Debug;
pub use displace::displaced;
pub use picture::Picture;
pub use report::{Report, TextureUse};
pub use shadow::ShadowOptions;
pub use textures::Textures;

/// Layers of transparent faces that are blended at most; what lies behind is left out.
pub const MAX_LAYERS: usize = 256;

/// What is drawn.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// The surfaces.
    pub mesh: &'a Mesh,
    /// Their textures; the same for every picture of the mesh.
    pub textures: &'a Textures,
    /// The eye.
    pub camera: &'a Camera,
    /// The lights; `None` for a default: one from behind the camera and some from everywhere.
    /// With an environment no lights are added.
    pub lights: Option<&'a [Light]>,
    /// Light from all sides, mirrored by what shines.
    pub environment: Option<&'a Environment>,
}

/// How it is drawn.
#[derive(Clone, Debug)]
pub struct Options {
    /// How textures are sampled.
    pub sampler: Sampler,
    /// Whether the filters that the file names go before `sampler.filter`.
    pub file_filters: bool,
    /// Linear colour and straight alpha behind everything.
    pub background: [f32; 4],
    /// Whether the environment is seen behind everything, before `background`.
    pub show_environment: bool,
    /// Depth textures of lights; `None` for light that passes through everything.
    pub shadows: Option<ShadowOptions>,
    /// Longest edge, in pixels of the drawing, of faces with displacement maps.
    pub displacement_edge_px: f64,
    /// Pixels of the drawing along each side of a pixel of the picture: 1 to 8.
    pub supersample: usize,
    /// Whether bump maps count the terms with the curvature of the surface.
    pub bump_curvature: bool,
    /// Draw what textures see instead of light.
    pub debug: Option<Debug>,
    /// Whether [`Picture::report`] is made.
    pub report: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            sampler: Sampler::new(Filter::Auto),
            file_filters: false,
            background: [0.0; 4],
            show_environment: false,
            shadows: None,
            displacement_edge_px: 4.0,
            supersample: 1,
            bump_curvature: false,
            debug: None,
            report: false,
        }
    }
}

/// What bands need to know.
struct Frame<'a> {
    view: View<'a>,
    options: &'a Options,
    lights: Lights,
    /// The eye, or for parallel rays the direction towards it.
    eye: Eye,
    /// World to eye space, without the place.
    eye_turn: DMat3,
    shadows: Option<shadow::Shadows>,
    materials: Vec<Option<surface::Sampled<'a>>>,
    report: report::Collector,
}

/// Where the picture is seen from.
#[derive(Clone, Copy, Debug)]
enum Eye {
    At(glam::Vec3),
    Along(glam::Vec3),
}

impl Eye {
    fn of(camera: &Camera) -> Self {
        match camera.projection {
            crate::mesh::Projection::Perspective { .. } => Self::At(camera.eye().map(|c| c as f32).into()),
            crate::mesh::Projection::Orthographic { .. } => {
                let row = camera.view[2];
                Self::Along(glam::DVec3::new(row[0], row[1], row[2]).normalize_or(glam::DVec3::Z).as_vec3())
            }
        }
    }

    /// Unit vector from a point to the eye.
    #[inline]
    fn from(self, point: glam::Vec3) -> glam::Vec3 {
        match self {
            Self::At(eye) => (eye - point).normalize_or(glam::Vec3::Z),
            Self::Along(direction) => direction,
        }
    }
}

/// Draws a picture.
///
/// `progress` is called now and then with the share that is done; when it answers `true`, drawing ends with
/// [`Error::Interrupted`].
///
/// # Errors
/// [`Error::Value`] for a size below 1 or, with supersampling, above [`MAX_SIDE`], for a mesh, lights or options
/// that are out of order; errors of reading textures; [`Error::Interrupted`].
///
/// ```
/// use multum::mesh::{Camera, Material, Mesh};
/// use multum::render::{Options, Textures, View, render};
///
/// let mesh = Mesh {
///     positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]],
///     normals: vec![[0.0, 0.0, 1.0]; 3],
///     tangents: vec![[1.0, 0.0, 0.0, 1.0]; 3],
///     faces: vec![[0, 1, 2]],
///     face_material: vec![0],
///     materials: vec![Material { base_color: [1.0, 0.0, 0.0, 1.0], unlit: true, ..Material::default() }],
///     ..Mesh::default()
/// };
/// let (camera, textures) = (Camera::framing(&mesh), Textures::new());
/// let view = View { mesh: &mesh, textures: &textures, camera: &camera, lights: None, environment: None };
/// let picture = render(&view, (32, 24), &Options::default(), &mut |_| false)?;
/// assert_eq!(picture.pixels()[12 * 32 + 16], [1.0, 0.0, 0.0, 1.0]); // red, opaque
/// assert_eq!(picture.pixels()[0], [0.0; 4]); // nothing in the corner
/// # Ok::<(), multum::Error>(())
/// ```
pub fn render(
    view: &View<'_>,
    size: (usize, usize),
    options: &Options,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Picture> {
    check(view, size, options)?;
    let mut pixels = crate::image::zeros::<[f32; 4]>("size", size.0 * size.1)?;
    let report = draw(view, size, options, progress, Rows::Light(&mut pixels))?;
    Ok(Picture::new(size, pixels, report))
}

/// As [`render`], for the screen: 8-bit sRGB codes and straight alpha, four numbers a pixel, and the report where the
/// options asked for it. Light beyond 1 is cut off.
///
/// # Errors
/// As [`render`].
///
/// ```
/// # use multum::mesh::{Camera, Mesh};
/// # use multum::render::{Options, Textures, View, render_srgb8};
/// let (mesh, textures) = (Mesh::default(), Textures::new());
/// let view = View {
///     mesh: &mesh,
///     textures: &textures,
///     camera: &Camera::framing(&mesh),
///     lights: None,
///     environment: None,
/// };
/// let options = Options { background: [0.5, 0.5, 0.5, 1.0], ..Options::default() };
/// let (codes, _) = render_srgb8(&view, (3, 2), &options, &mut |_| false)?;
/// assert_eq!(codes, [188, 188, 188, 255].repeat(6));
/// # Ok::<(), multum::Error>(())
/// ```
pub fn render_srgb8(
    view: &View<'_>,
    size: (usize, usize),
    options: &Options,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<(Vec<u8>, Option<Report>)> {
    check(view, size, options)?;
    let mut codes = crate::image::zeros::<u8>("size", 4 * size.0 * size.1)?;
    let report = draw(view, size, options, progress, Rows::Codes(&mut codes))?;
    Ok((codes, report))
}

/// Draws what has been checked, into all rows of a picture.
fn draw(
    view: &View<'_>,
    size: (usize, usize),
    options: &Options,
    progress: &mut dyn FnMut(f64) -> bool,
    out: Rows<'_>,
) -> Result<Option<Report>> {
    let times = options.supersample;
    let fine = (size.0 * times, size.1 * times);
    let moved = displaced(view, fine, options.displacement_edge_px)?;
    let view = &View { mesh: moved.as_ref().unwrap_or(view.mesh), ..*view };
    let mesh = view.mesh;
    let default_lights = light::default_lights(view.camera);
    let lights = match (view.lights, view.environment) {
        (Some(lights), _) => lights,
        (None, Some(_)) => &[],
        (None, None) => &default_lights,
    };
    let shadows = match options.shadows {
        Some(shadows) if options.debug.is_none() => {
            Some(shadow::Shadows::new(view, lights, options, shadows)?)
        }
        _ => None,
    };
    let [x, y, z] = [0, 1, 2].map(|k| DVec3::from_slice(&view.camera.view[k][..3]));
    let mut frame = Frame {
        view: *view,
        options,
        lights: Lights::new(lights)?,
        eye: Eye::of(view.camera),
        eye_turn: DMat3::from_cols(x, y, z).transpose(),
        shadows,
        materials: (0..mesh.materials.len()).map(|_| None).collect(),
        report: report::Collector::default(),
    };
    let mut step = |done: f64| if progress(done) { Err(Error::Interrupted) } else { Ok(()) };
    step(0.0)?;

    let geometry = Geometry::new(view.camera.project(&mesh.positions, fine.0, fine.1), mesh.faces.clone())?;
    let projected = Projected::new(&geometry, fine)?;
    let kinds = band::Kinds::new(mesh, options.debug.is_some());
    let cut = band::Cut::new(fine, times);
    let stage = band::Stage::new(&projected, &geometry, &kinds, cut)?;
    let pool = Pool::default();
    frame.prepare(&stage, fine.1.div_ceil(cut.rows()), &pool)?;
    step(0.1)?;

    let finish = Finish::new(size.0, times, Picture::premultiplied(options.background), &out);
    let mut bands = out.split(size.0 * cut.rows() / times);
    let total = bands.len();
    // So many bands between two calls of `step`.
    let group = total.div_ceil(32).max(16);
    let mut first = 0;
    while first < total {
        let own: Vec<Rows<'_>> = bands.by_ref().take(group).collect();
        par::for_each(own.into_iter(), |i, rows| {
            // Sampling a batch is this thread's own work.
            pool.with(|scratch| {
                par::with_threads(Some(1), || band::draw(&frame, &stage, first + i, &finish, rows, scratch))
            })
        })?;
        first = (first + group).min(total);
        step(0.1 + 0.9 * first as f64 / total as f64)?;
    }
    Ok(options.report.then(|| frame.report.finish(mesh)))
}

/// Rooms to work in, handed from band to band.
#[derive(Default)]
struct Pool(Mutex<Vec<band::Scratch>>);

impl Pool {
    fn with<R>(&self, work: impl FnOnce(&mut band::Scratch) -> R) -> R {
        let lock = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = lock().pop();
        let mut scratch = known.unwrap_or_default();
        let result = work(&mut scratch);
        lock().push(scratch);
        result
    }
}

/// Refuses what cannot be drawn.
fn check(view: &View<'_>, (width, height): (usize, usize), options: &Options) -> Result<()> {
    let times = options.supersample;
    if !(1..=8).contains(&times) {
        return Err(Error::value("supersample", times, "1 to 8"));
    }
    if !(1..=MAX_SIDE / times).contains(&width) || !(1..=MAX_SIDE / times).contains(&height) {
        let most = MAX_SIDE / times;
        let expected = format!("sides of 1 to {most} pixels (16384 of them or of their supersamples)");
        return Err(Error::value("size", format!("({width}, {height})"), expected));
    }
    if !options.background.iter().all(|c| c.is_finite()) {
        let got = format!("{:?}", options.background);
        return Err(Error::value("background", got, "finite numbers"));
    }
    if let Some(shadows) = options.shadows {
        shadows.check()?;
    }
    options.sampler.check()?;
    view.mesh.check()
}

impl<'a> Frame<'a> {
    /// Opens the materials that are seen. Textures that no pixel shows are not decoded.
    fn prepare(&mut self, stage: &band::Stage<'_>, bands: usize, pool: &Pool) -> Result<()> {
        let mesh = self.view.mesh;
        let mut near = vec![false; mesh.materials.len()];
        stage.faces().for_each(|face| near[mesh.face_material[face] as usize] = true);
        let mut all_known = true;
        for material in (0..near.len()).filter(|&m| near[m]) {
            if surface::Sampled::are_known(&self.view, material) {
                self.materials[material] = Some(surface::Sampled::new(&self.view, material, self.options)?);
            } else {
                all_known = false;
            }
        }
        if all_known {
            return Ok(());
        }
        let seen = Mutex::new(BTreeSet::new());
        par::for_each(0..bands, |_, band| {
            let own = pool.with(|scratch| stage.materials(mesh, band, scratch));
            seen.lock().unwrap_or_else(PoisonError::into_inner).extend(own);
            Ok(())
        })?;
        for material in seen.into_inner().unwrap_or_else(PoisonError::into_inner) {
            let place = &mut self.materials[material as usize];
            if place.is_none() {
                *place = Some(surface::Sampled::new(&self.view, material as usize, self.options)?);
            }
        }
        Ok(())
    }

    /// The environment, where it is to be seen.
    fn sky(&self) -> Option<&Environment> {
        self.view.environment.filter(|_| self.options.show_environment)
    }

    /// Puts the environment, where it is to be seen, under what the pixels of some rows hold.
    fn fill(&self, size: (usize, usize), top: usize, pixels: &mut [[f32; 4]]) -> Result<()> {
        let Some(sky) = self.sky() else { return Ok(()) };
        for (row, y) in pixels.chunks_mut(size.0).zip(top..) {
            let open: Vec<usize> = (0..size.0).filter(|&x| row[x][3] < 1.0).collect();
            let rays: Vec<Ray> = open.iter().map(|&x| self.ray(x, y, size)).collect();
            let sharp = vec![f32::INFINITY; rays.len()];
            let light = sky.mirrored(&rays, &sharp, self.eye_turn, &self.options.sampler)?;
            for (x, light) in open.into_iter().zip(light) {
                row[x] = over(row[x], light.extend(1.0).to_array());
            }
        }
        Ok(())
    }

    /// The ray from the eye through a pixel's centre: where the planes of its column and its row meet.
    fn ray(&self, x: usize, y: usize, (width, height): (usize, usize)) -> Ray {
        if let Eye::Along(towards) = self.eye {
            return Ray { direction: -towards.as_dvec3(), moving: [DVec3::ZERO; 2] };
        }
        let m = self.view.camera.matrix(width, height);
        let [right, up, w] = [0, 1, 3].map(|k| DVec3::from_slice(&m[k][..3]));
        let (px, py) = (2.0 / width as f64, -2.0 / height as f64);
        let column = right - ((x as f64 + 0.5) * px - 1.0) * w;
        let row = up - ((y as f64 + 0.5) * py + 1.0) * w;
        let direction = column.cross(row);
        let side = if direction.dot(w) < 0.0 { -1.0 } else { 1.0 };
        let moving = [(-px * w).cross(row), column.cross(-py * w)];
        Ray { direction: side * direction, moving: moving.map(|d| side * d) }
    }
}
