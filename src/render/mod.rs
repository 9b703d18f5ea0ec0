//! From a mesh, a camera and lights to a picture.
//!
//! ```text
//!  displacement faces cut to the size of pixels and moved by height maps
//!  shadows      depth textures from every light, where they are asked for
//!  visibility   opaque faces: the nearest at each pixel; the others: layer behind layer, front to back
//!  batches      the pixels of a tile, sorted by material
//!  textures     each texture of a material in one call, with the uv and Jacobians of the whole batch
//!  light        Phong for each pixel of the batch; the environment by its reflected rays
//!  compositing  premultiplied, in linear light, front over back, then over the background
//! ```
//!
//! Tiles are cut by the picture alone, so its bytes do not depend on the number of threads.

mod batch;
mod debug;
mod displace;
mod layer;
mod light;
mod picture;
mod report;
mod shadow;
mod surface;
mod textures;

use crate::error::{Error, Result};
use crate::filter::Filter;
use crate::mesh::{AlphaMode, Camera, Light, Mesh};
use crate::par;
use crate::raster::{Cull, Fragments, Geometry, MAX_SIDE, Options as RasterOptions, rasterize};
use crate::sampler::Sampler;
use crate::shade::{Environment, Lights, Ray, over};
use glam::{DMat3, DVec3};

pub use debug::Debug;
pub use displace::displaced;
pub use picture::Picture;
pub use report::{Report, TextureUse};
pub use shadow::ShadowOptions;
pub use textures::Textures;

/// Pixels that a thread takes at a time: whole rows, about this many pixels.
const TILE_PX: usize = 1 << 13;
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

/// What tiles need to know.
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
/// assert_eq!(picture.to_srgb8()?[..4], [0, 0, 0, 0]); // nothing in the corner
/// # Ok::<(), multum::Error>(())
/// ```
pub fn render(
    view: &View<'_>,
    size: (usize, usize),
    options: &Options,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Picture> {
    check(view, size, options)?;
    let times = options.supersample;
    let fine = (size.0 * times, size.1 * times);
    let moved = displaced(view, fine, options.displacement_edge_px)?;
    let view = &View { mesh: moved.as_ref().unwrap_or(view.mesh), ..*view };
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
        materials: (0..view.mesh.materials.len()).map(|_| None).collect(),
        report: report::Collector::default(),
    };
    let mut step = |done: f64| if progress(done) { Err(Error::Interrupted) } else { Ok(()) };
    step(0.0)?;

    let mut pixels = crate::image::zeros::<[f32; 4]>("size", fine.0 * fine.1)?;
    let clip = view.camera.project(&view.mesh.positions, fine.0, fine.1);
    let solid = Drawn::new(view.mesh, &clip, options.debug.is_some(), true)?;
    let clear = Drawn::new(view.mesh, &clip, options.debug.is_some(), false)?;
    drop(clip);
    let nearest = solid.draw(fine, None)?;
    step(0.2)?;

    let mut front: Option<Fragments> = None;
    for layer in 0..if clear.faces.is_empty() { 0 } else { MAX_LAYERS } {
        let fragments = clear.draw(fine, front.as_ref())?;
        if !seen(&fragments, &nearest) {
            break;
        }
        frame.prepare(&clear, &fragments)?;
        frame.shade(&clear, &fragments, Some(&nearest), layer, &mut pixels, &mut |_| Ok(()))?;
        front = Some(fragments);
        step(0.2 + 0.3 * (1.0 - 0.8f64.powi(layer as i32 + 1)))?;
    }
    drop(front);
    frame.prepare(&solid, &nearest)?;
    frame.shade(&solid, &nearest, None, MAX_LAYERS, &mut pixels, &mut |share| step(0.5 + 0.5 * share))?;

    if let (true, Some(sky)) = (options.show_environment, view.environment) {
        frame.fill(sky, fine.0, &mut pixels)?;
    }
    let background = Picture::premultiplied(options.background);
    let report = options.report.then(|| frame.report.finish(view.mesh));
    Picture::new(size, times, pixels, background, report)
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

/// Faces that are drawn together.
struct Drawn {
    geometry: Geometry,
    /// Their numbers in the mesh.
    faces: Vec<u32>,
    /// Whose backs are left out.
    single_sided: Vec<bool>,
}

impl Drawn {
    /// The faces of opaque materials, or all others. `all_solid` takes every face for opaque.
    fn new(mesh: &Mesh, clip: &[[f64; 4]], all_solid: bool, solid: bool) -> Result<Self> {
        let material = |&face: &u32| &mesh.materials[mesh.face_material[face as usize] as usize];
        let faces: Vec<u32> = (0..mesh.faces.len() as u32)
            .filter(|f| (all_solid || material(f).alpha_mode == AlphaMode::Opaque) == solid)
            .collect();
        let single_sided = faces.iter().map(|f| !material(f).double_sided).collect();
        let corners = faces.iter().map(|&f| mesh.faces[f as usize]).collect::<Vec<_>>();
        let positions = if faces.is_empty() { Vec::new() } else { clip.to_vec() };
        Ok(Self { geometry: Geometry::new(positions, corners)?, faces, single_sided })
    }

    fn draw(&self, size: (usize, usize), behind: Option<&Fragments>) -> Result<Fragments> {
        let cull = Cull::BackOf(&self.single_sided);
        rasterize(&self.geometry, size, &RasterOptions { cull, samples: 1, behind })
    }
}

/// Whether a layer has a pixel in front of what is opaque.
fn seen(layer: &Fragments, nearest: &Fragments) -> bool {
    let pairs = layer.depth().iter().zip(nearest.depth());
    layer.triangle().iter().zip(pairs).any(|(&t, (z, solid))| t >= 0 && z < solid)
}

impl<'a> Frame<'a> {
    /// Loads the textures of the materials that a layer shows.
    fn prepare(&mut self, drawn: &Drawn, fragments: &Fragments) -> Result<()> {
        let mut last = -1;
        for &t in fragments.triangle() {
            if t < 0 || t == last {
                continue;
            }
            last = t;
            let face = drawn.faces[t as usize] as usize;
            let material = self.view.mesh.face_material[face] as usize;
            if self.materials[material].is_none() {
                let made = surface::Sampled::new(&self.view, material, self.options)?;
                self.materials[material] = Some(made);
            }
        }
        Ok(())
    }

    /// Shades a layer and puts it under what the pixels hold.
    fn shade(
        &self,
        drawn: &Drawn,
        fragments: &Fragments,
        nearest: Option<&Fragments>,
        layer: usize,
        pixels: &mut [[f32; 4]],
        step: &mut dyn FnMut(f64) -> Result<()>,
    ) -> Result<()> {
        let width = fragments.width();
        let rows = (TILE_PX / width).max(1);
        let tiles = fragments.height().div_ceil(rows);
        // So many tiles between two calls of `step`.
        let group = tiles.div_ceil(32).max(64);
        for (g, part) in pixels.chunks_mut(group * rows * width).enumerate() {
            par::for_each(part.chunks_mut(rows * width), |i, tile| {
                let first = (g * group + i) * rows;
                let own = first..(first + rows).min(fragments.height());
                // Sampling a batch is this thread's own work.
                par::with_threads(Some(1), || {
                    layer::shade_tile(self, drawn, (fragments, nearest), own, layer, tile)
                })
            })?;
            step(((g + 1) * group).min(tiles) as f64 / tiles as f64)?;
        }
        Ok(())
    }

    /// Puts the environment under what the pixels hold.
    fn fill(&self, sky: &Environment, width: usize, pixels: &mut [[f32; 4]]) -> Result<()> {
        let size = (width, pixels.len() / width);
        par::for_each(pixels.chunks_mut(width), |y, row| {
            let open: Vec<usize> = (0..width).filter(|&x| row[x][3] < 1.0).collect();
            let rays: Vec<Ray> = open.iter().map(|&x| self.ray(x, y, size)).collect();
            let sharp = vec![f32::INFINITY; rays.len()];
            let light = par::with_threads(Some(1), || {
                sky.mirrored(&rays, &sharp, self.eye_turn, &self.options.sampler)
            })?;
            for (x, light) in open.into_iter().zip(light) {
                row[x] = over(row[x], light.extend(1.0).to_array());
            }
            Ok(())
        })
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
