//! Depth textures of all lights that cast shadows.
//!
//! Far lights see the mesh along parallel rays, spots through a cone, others through the six faces of a cube. Faces that
//! are opaque cast shadows, and of masked ones what their alpha leaves; blended ones let light through.

use super::batch::{Batch, Moving};
use super::surface::Sampled;
use super::{Options, View};
use crate::error::{Error, Result};
use crate::mesh::{AlphaMode, Camera, Light, Mesh, Projection};
use crate::raster::{Fragments, Geometry, MAX_SIDE, Options as RasterOptions, rasterize, runs};
use crate::shade::{DepthMap, Receiver};
use glam::{DMat4, DVec3, DVec4};

/// Layers of masked faces that are looked through at most.
const MASK_LAYERS: usize = 16;
/// Spots with a wider half angle, in radians, see through a cube.
const WIDEST_SPOT: f32 = 1.1;
/// Nearest distance that a lamp sees, as a share of the farthest.
const NEAR: f64 = 1e-3;

/// How shadows are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowOptions {
    /// Side of the depth textures, in texels: 1 to 16384.
    pub size: usize,
    /// Least width of a shadow's edge, in texels of the depth texture.
    pub softness: f32,
}

impl Default for ShadowOptions {
    fn default() -> Self {
        Self { size: 2048, softness: 1.5 }
    }
}

impl ShadowOptions {
    pub(super) fn check(&self) -> Result<()> {
        if !(1..=MAX_SIDE).contains(&self.size) {
            return Err(Error::value("shadows", self.size, format!("1 to {MAX_SIDE} texels")));
        }
        if !(0.0..=32.0).contains(&self.softness) {
            return Err(Error::value("shadow_softness", self.softness, "0 to 32 texels"));
        }
        Ok(())
    }
}

/// Depth textures, light by light: none, one, or six.
pub(super) struct Shadows {
    maps: Vec<Vec<DepthMap>>,
    softness: f64,
}

impl Shadows {
    /// Draws what each light but ambient ones sees; `sampled` holds the masked materials.
    pub fn new(view: &View<'_>, lights: &[Light], options: &Options, shadows: ShadowOptions) -> Result<Self> {
        let mesh = view.mesh;
        let masked: Vec<Option<Sampled<'_>>> = (0..mesh.materials.len())
            .map(|m| match mesh.materials[m].alpha_mode {
                AlphaMode::Mask(_) => Sampled::new(view, m, options).map(Some),
                _ => Ok(None),
            })
            .collect::<Result<_>>()?;
        let caster = Caster { mesh, masked, size: shadows.size };
        let maps = lights
            .iter()
            .filter(|light| !matches!(light, Light::Ambient { .. }))
            .map(|light| views(light, mesh, shadows.size).into_iter().map(|m| caster.draw(m)).collect())
            .collect::<Result<_>>()?;
        Ok(Self { maps, softness: f64::from(shadows.softness) })
    }

    /// Share of light `k` that reaches a point.
    pub fn lit(&self, k: usize, point: &Moving) -> f32 {
        let receiver =
            Receiver { point: point.at.as_dvec3(), moving: [point.dx.as_dvec3(), point.dy.as_dvec3()] };
        let maps = &self.maps[k];
        let map = if maps.len() == 1 { maps.first() } else { maps.iter().find(|m| m.sees(receiver.point)) };
        map.map_or(1.0, |map| map.lit(&receiver, self.softness))
    }
}

/// World to clip space of the pictures that a light needs; none for a light that meets nothing.
fn views(light: &Light, mesh: &Mesh, size: usize) -> Vec<[[f64; 4]; 4]> {
    let points =
        || mesh.faces.iter().flatten().map(|&v| DVec3::from(mesh.positions[v as usize].map(f64::from)));
    let place = |v: &[f32; 3]| DVec3::from(v.map(f64::from));
    match light {
        Light::Ambient { .. } => Vec::new(),
        Light::Directional { direction, .. } => {
            let z = place(direction).normalize_or(DVec3::NEG_Z);
            let (x, y) = z.any_orthonormal_pair();
            let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            for p in points() {
                let own = DVec3::new(x.dot(p), y.dot(p), z.dot(p));
                (low, high) = (low.min(own), high.max(own));
            }
            let middle = 0.5 * (low + high);
            // Room for the outermost texels, and depths that nothing reaches.
            let half = 0.5 * (high - low) * (1.0 + 4.0 / size as f64);
            if !middle.is_finite() {
                return Vec::new();
            }
            let least = half.max_element() * 1e-3;
            let row = |axis: DVec3, m: f64, h: f64| {
                let scaled = axis / h.max(least).max(f64::MIN_POSITIVE);
                [scaled.x, scaled.y, scaled.z, -m / h.max(least).max(f64::MIN_POSITIVE)]
            };
            vec![[
                row(x, middle.x, half.x),
                row(y, middle.y, half.y),
                row(z, middle.z, half.z),
                [0.0, 0.0, 0.0, 1.0],
            ]]
        }
        Light::Point { position, cone, .. } => {
            let eye = place(position);
            let far = points().map(|p| p.distance(eye)).fold(0.0, f64::max) * 1.01;
            if !(far > 0.0 && far.is_finite()) {
                return Vec::new();
            }
            let look = |towards: DVec3, yfov_rad: f64| {
                let projection = Projection::Perspective { yfov_rad, near: far * NEAR, far };
                let up = towards.any_orthonormal_vector();
                Camera::look_at(eye.into(), (eye + towards).into(), up.into(), projection).matrix(size, size)
            };
            match cone {
                Some((axis, [_, outer])) if *outer <= WIDEST_SPOT => {
                    let outer = f64::from(*outer).max(1e-3);
                    vec![look(place(axis).normalize_or(DVec3::Z), 2.0 * outer * (1.0 + 4.0 / size as f64))]
                }
                _ => {
                    // Faces overlap by some texels, so that edges of shadows pass from one to the next.
                    let yfov = 2.0 * (1.0 + 8.0 / size as f64).atan();
                    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
                    axes.into_iter().flat_map(|a| [a, -a]).map(|a| look(a, yfov.min(3.0))).collect()
                }
            }
        }
    }
}

/// What casts shadows.
struct Caster<'a> {
    mesh: &'a Mesh,
    masked: Vec<Option<Sampled<'a>>>,
    size: usize,
}

impl Caster<'_> {
    fn draw(&self, matrix: [[f64; 4]; 4]) -> Result<DepthMap> {
        let mesh = self.mesh;
        let row = |r: [f64; 4], p: [f64; 3]| r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3];
        let clip: Vec<[f64; 4]> =
            mesh.positions.iter().map(|p| matrix.map(|r| row(r, p.map(f64::from)))).collect();
        let some = |wanted: fn(AlphaMode) -> bool| -> Vec<u32> {
            let mode = |f: u32| mesh.materials[mesh.face_material[f as usize] as usize].alpha_mode;
            (0..mesh.faces.len() as u32).filter(|&f| wanted(mode(f))).collect()
        };
        let geometry = |faces: &[u32], clip: Vec<[f64; 4]>| {
            Geometry::new(clip, faces.iter().map(|&f| mesh.faces[f as usize]).collect())
        };
        let solid = some(|mode| mode == AlphaMode::Opaque);
        let masked = some(|mode| matches!(mode, AlphaMode::Mask(_)));
        let size = (self.size, self.size);
        let mut depth =
            rasterize(&geometry(&solid, clip.clone())?, size, &RasterOptions::default())?.into_depth();
        if !masked.is_empty() {
            let geometry = geometry(&masked, clip)?;
            let mut front: Option<Fragments> = None;
            for _ in 0..MASK_LAYERS {
                let options = RasterOptions { behind: front.as_ref(), ..RasterOptions::default() };
                let layer = rasterize(&geometry, size, &options)?;
                if !layer.triangle().iter().zip(layer.depth()).zip(&depth).any(|((&t, z), d)| t >= 0 && z < d)
                {
                    break;
                }
                self.stop(&geometry, &masked, &layer, &mut depth)?;
                front = Some(layer);
            }
        }
        let columns = |k: usize| DVec4::from_array(matrix.map(|r| r[k]));
        let matrix = DMat4::from_cols(columns(0), columns(1), columns(2), columns(3));
        Ok(DepthMap::new(self.size, depth, matrix))
    }

    /// Lowers depths where a layer of masked faces is seen.
    fn stop(&self, geometry: &Geometry, faces: &[u32], layer: &Fragments, depth: &mut [f32]) -> Result<()> {
        let mut batches: Vec<Batch> = (0..self.mesh.materials.len()).map(|_| Batch::default()).collect();
        let size = (self.size, self.size);
        for y in 0..self.size {
            runs(layer.row(y), |pixels, face| {
                let of = (geometry, face);
                let face = faces[face] as usize;
                let batch = &mut batches[self.mesh.face_material[face] as usize];
                let number = batch.add(face, of, [pixels.start, y], size);
                for x in pixels {
                    let p = y * self.size + x;
                    if layer.depth()[p] < depth[p] {
                        batch.push(p, x..x + 1, y, number);
                    }
                }
                Ok(())
            })?;
        }
        for (batch, sampled) in batches.iter().zip(&self.masked) {
            let (Some(sampled), true) = (sampled, batch.len() > 0) else { continue };
            let AlphaMode::Mask(cutoff) = sampled.material.alpha_mode else { continue };
            for (p, alpha) in batch.pixels().zip(sampled.alpha(self.mesh, batch)?) {
                if alpha >= cutoff {
                    depth[p] = layer.depth()[p];
                }
            }
        }
        Ok(())
    }
}
