//! What textures make of a batch: the numbers that light needs, pixel by pixel.

use super::batch::{Batch, Moving, Places};
use super::textures::Use;
use super::{Frame, Options, View};
use crate::error::Result;
use crate::filter::Filter;
use crate::mesh::{AlphaMode, Blend, Material, Mesh, NormalSpace, TextureSlot};
use crate::sampler::{Extent, Sampler};
use crate::shade::{blend, bumped, tangent_normal};
use crate::texel::DType;
use crate::texture::Texture;
use glam::Vec3;
use std::sync::Arc;

/// A slot with its texture and how that is read.
pub(super) struct Slot<'a> {
    pub slot: &'a TextureSlot,
    pub texture: Arc<Texture<'static>>,
    how: How,
    /// Whether the fourth number is alpha.
    has_alpha: bool,
}

enum How {
    One(Sampler),
    /// As files ask: a filter for enlarging, one for reducing, and the level between them.
    Two {
        mag: Sampler,
        min: Sampler,
        limit: f32,
    },
}

/// A material with its textures.
pub(super) struct Sampled<'a> {
    pub material: &'a Material,
    base: Option<Slot<'a>>,
    alpha: Option<Slot<'a>>,
    metallic_roughness: Option<Slot<'a>>,
    normal: Option<Slot<'a>>,
    bump: Option<Slot<'a>>,
    occlusion: Option<Slot<'a>>,
    emissive: Option<Slot<'a>>,
    specular: Option<Slot<'a>>,
    shininess: Option<Slot<'a>>,
    layers: Vec<(Slot<'a>, Blend, bool)>,
}

/// A pixel's surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    pub point: Moving,
    /// The normal before maps, with its movement, on the side of the eye.
    pub smooth: Moving,
    /// Unit normal for light.
    pub normal: Vec3,
    /// Length of the mean of the normal map's vectors, 1 without a map.
    pub normal_length: f32,
    /// Straight colour and alpha.
    pub base: [f32; 4],
    pub metallic: f32,
    pub roughness: f32,
    pub specular: Vec3,
    pub mirror: Vec3,
    pub shininess: f32,
    pub occlusion: f32,
    pub emissive: Vec3,
}

/// The surfaces of a batch, and the textures that meet their lit colours.
pub(super) struct Surfaces {
    pub list: Vec<Surface>,
    pub after_light: Vec<(Blend, Vec<[f32; 4]>)>,
}

impl<'a> Slot<'a> {
    fn new(view: &View<'a>, slot: &'a TextureSlot, what: Use, options: &Options) -> Result<Self> {
        let how = How::new(slot, options)?;
        let reducing = match &how {
            How::One(sampler) => sampler,
            How::Two { min, .. } => min,
        };
        let texture = view.textures.get(view.mesh, slot, what, reducing)?;
        let has_alpha = matches!(what, Use::ColorAlpha | Use::Cutout(_));
        Ok(Self { slot, texture, how, has_alpha })
    }

    /// Grey becomes three equal numbers, missing alpha 1.
    fn rgba(&self, texel: &[f32]) -> [f32; 4] {
        let [r, g, b, a] = match *texel {
            [l] => [l, l, l, 1.0],
            [l, a] => [l, l, l, a],
            [r, g, b] => [r, g, b, 1.0],
            [r, g, b, a, ..] => [r, g, b, a],
            [] => [0.0; 4],
        };
        [r, g, b, if self.has_alpha { a } else { 1.0 }]
    }

    /// One texel a place.
    pub fn sample(&self, places: &Places, seed: u64) -> Result<Vec<[f32; 4]>> {
        let (channels, count) = (self.texture.channels(), places.uv.len() / 2);
        let mut texels = vec![0f32; count * channels];
        let run = |sampler: &Sampler, places: &Places, out: &mut [f32]| {
            let sampler = Sampler { seed: sampler.seed ^ seed, ..*sampler };
            sampler.sample(&self.texture, &places.uv, Extent::Jacobian(&places.jacobian), out)
        };
        match &self.how {
            How::One(sampler) => run(sampler, places, &mut texels)?,
            How::Two { mag, min, limit } => {
                let (w, h) = (self.texture.width() as f64, self.texture.height() as f64);
                for (sampler, enlarges) in [(mag, true), (min, false)] {
                    let lod = |i: usize| sampler.lod_rule.lod(places.jacobian(i).scaled(w, h));
                    let chosen: Vec<usize> =
                        (0..count).filter(|&i| (lod(i) + sampler.lod_bias <= *limit) == enlarges).collect();
                    let part = Places {
                        uv: chosen.iter().flat_map(|i| &places.uv[2 * i..][..2]).copied().collect(),
                        jacobian: chosen
                            .iter()
                            .flat_map(|i| &places.jacobian[4 * i..][..4])
                            .copied()
                            .collect(),
                    };
                    let mut own = vec![0f32; chosen.len() * channels];
                    run(sampler, &part, &mut own)?;
                    for (i, texel) in chosen.iter().zip(own.chunks_exact(channels)) {
                        texels[i * channels..][..channels].copy_from_slice(texel);
                    }
                }
            }
        }
        Ok(texels.chunks_exact(channels).map(|texel| self.rgba(texel)).collect())
    }
}

impl How {
    fn new(slot: &TextureSlot, options: &Options) -> Result<Self> {
        let sampler = options.sampler;
        if !options.file_filters || (slot.mag_filter.is_none() && slot.min_filter.is_none()) {
            return Ok(Self::One(sampler));
        }
        let filter = |name: Option<&str>, default| name.map_or(Ok(default), Filter::parse);
        let mag = filter(slot.mag_filter, Filter::Bilinear)?;
        let min = filter(slot.min_filter, sampler.filter)?;
        // GL 4.6, section 8.15: a linear filter for enlarging begins half a level earlier before nearest levels.
        let nearest = matches!(min, Filter::NearestMipmapNearest | Filter::NearestMipmapLinear);
        let limit = if mag == Filter::Bilinear && nearest { 0.5 } else { 0.0 };
        Ok(Self::Two {
            mag: Sampler { filter: mag, ..sampler },
            min: Sampler { filter: min, ..sampler },
            limit,
        })
    }
}

/// Places by uv set and transform, computed once for all slots that share them.
struct Shared<'a> {
    batch: &'a Batch,
    mesh: &'a Mesh,
    made: Vec<(&'a TextureSlot, Places)>,
}

impl<'a> Shared<'a> {
    fn of(&mut self, slot: &'a TextureSlot) -> &Places {
        let same = |s: &TextureSlot| s.uv_set == slot.uv_set && s.transform == slot.transform;
        let known = self.made.iter().position(|(s, _)| same(s));
        let index = known.unwrap_or_else(|| {
            self.made.push((slot, self.batch.places(self.mesh, slot)));
            self.made.len() - 1
        });
        &self.made[index].1
    }
}

impl<'a> Sampled<'a> {
    /// Reads the textures of a material.
    pub fn new(view: &View<'a>, material: usize, options: &Options) -> Result<Self> {
        let mesh: &'a Mesh = view.mesh;
        let material = &mesh.materials[material];
        let color = match material.alpha_mode {
            AlphaMode::Opaque => Use::Color,
            AlphaMode::Blend => Use::ColorAlpha,
            // The share of alpha above the cut-off is that of texture times factor.
            AlphaMode::Mask(cutoff) => {
                Use::Cutout((cutoff / material.base_color[3]).clamp(0.0, 1.0).to_bits())
            }
        };
        let open = |slot: &'a Option<TextureSlot>, what| {
            slot.as_ref().map(|slot| Slot::new(view, slot, what, options)).transpose()
        };
        let layer = |layer: &'a crate::mesh::Layer| {
            let slot = Slot::new(view, &layer.texture, Use::ColorAlpha, options)?;
            Ok((slot, layer.blend, layer.after_light))
        };
        Ok(Self {
            material,
            base: open(&material.base_color_texture, color)?,
            alpha: open(&material.alpha_texture, Use::Data)?,
            metallic_roughness: open(&material.metallic_roughness_texture, Use::Data)?,
            normal: open(&material.normal_texture, Use::Normal)?,
            bump: open(&material.bump_texture, Use::Slopes)?,
            occlusion: open(&material.occlusion_texture, Use::Data)?,
            emissive: open(&material.emissive_texture, Use::Color)?,
            specular: open(&material.specular_texture, Use::Color)?,
            shininess: open(&material.shininess_texture, Use::Data)?,
            layers: material.layers.iter().map(layer).collect::<Result<_>>()?,
        })
    }

    /// The first texture of the material, for pictures of what textures see.
    pub fn first_slot(&self) -> Option<&Slot<'a>> {
        let single = [&self.base, &self.normal, &self.metallic_roughness, &self.occlusion, &self.bump];
        single.into_iter().flatten().next()
    }

    /// Slack of the normal map's lengths, which rounding to codes explains: half a code of 127 along the vector.
    pub fn normal_slack(&self) -> f32 {
        match self.normal.as_ref().map(|slot| slot.texture.dtype()) {
            Some(DType::U8) => 0.5 / 127.0,
            _ => 0.0,
        }
    }

    /// Alpha of a batch, before layers.
    pub fn alpha(&self, mesh: &Mesh, batch: &Batch) -> Result<Vec<f32>> {
        let start = self.material.base_color[3];
        let mut alpha: Vec<f32> = (0..batch.len()).map(|i| start * batch.color(mesh, i)[3]).collect();
        for (slot, channel) in [(&self.base, 3), (&self.alpha, 0)] {
            let Some(slot) = slot else { continue };
            for (a, texel) in alpha.iter_mut().zip(slot.sample(&batch.places(mesh, slot.slot), 0)?) {
                *a *= texel[channel];
            }
        }
        Ok(alpha)
    }

    /// Samples every texture and sorts the numbers by pixel.
    pub fn surfaces(&self, frame: &Frame<'a>, batch: &Batch, seed: u64) -> Result<Surfaces> {
        let (mesh, m) = (frame.view.mesh, self.material);
        let mut shared = Shared { batch, mesh, made: Vec::new() };
        let mut list: Vec<Surface> = (0..batch.len()).map(|i| self.bare(frame, batch, i)).collect();
        let mut read = |slot: &Option<Slot<'a>>| -> Result<Option<Vec<[f32; 4]>>> {
            let Some(slot) = slot else { return Ok(None) };
            let places = shared.of(slot.slot);
            if frame.options.report {
                frame.report.add(slot, places);
            }
            slot.sample(places, seed).map(Some)
        };
        for (s, t) in list.iter_mut().zip(read(&self.base)?.into_iter().flatten()) {
            s.base = blend(Blend::Modulate, s.base, t);
        }
        for (s, t) in list.iter_mut().zip(read(&self.alpha)?.into_iter().flatten()) {
            s.base[3] *= t[0];
        }
        for (s, t) in list.iter_mut().zip(read(&self.metallic_roughness)?.into_iter().flatten()) {
            (s.roughness, s.metallic) = (s.roughness * t[1], s.metallic * t[2]);
        }
        for (s, t) in list.iter_mut().zip(read(&self.occlusion)?.into_iter().flatten()) {
            s.occlusion = 1.0 + m.occlusion_strength * (t[0] - 1.0);
        }
        for (s, t) in list.iter_mut().zip(read(&self.emissive)?.into_iter().flatten()) {
            s.emissive *= Vec3::new(t[0], t[1], t[2]);
        }
        for (s, t) in list.iter_mut().zip(read(&self.specular)?.into_iter().flatten()) {
            let gloss = Vec3::new(t[0], t[1], t[2]);
            (s.specular, s.mirror) = (s.specular * gloss, s.mirror * gloss);
        }
        for (s, t) in list.iter_mut().zip(read(&self.shininess)?.into_iter().flatten()) {
            s.shininess *= t[0];
        }
        for (i, t) in read(&self.normal)?.into_iter().flatten().enumerate() {
            self.turn(&mut list[i], mesh, batch, i, Vec3::new(t[0], t[1], t[2]));
        }
        let bumps = read(&self.bump)?;
        let mut after_light = Vec::new();
        for (slot, mode, after) in &self.layers {
            let places = shared.of(slot.slot);
            if frame.options.report {
                frame.report.add(slot, places);
            }
            let texels = slot.sample(places, seed)?;
            if *after {
                after_light.push((*mode, texels));
                continue;
            }
            for (s, t) in list.iter_mut().zip(texels) {
                s.base = blend(*mode, s.base, t);
            }
        }
        if let (Some(heights), Some(slot)) = (bumps, &self.bump) {
            let places = shared.of(slot.slot);
            for (i, (s, [d, du, dv, _])) in list.iter_mut().zip(heights).enumerate() {
                let j = places.jacobian(i).m;
                let slope = [0, 1].map(|axis| {
                    m.bump_scale * (f64::from(du) * j[0][axis] + f64::from(dv) * j[1][axis]) as f32
                });
                let n = &s.smooth;
                let curvature = frame.options.bump_curvature.then_some((m.bump_scale * d, [n.dx, n.dy]));
                s.normal = bumped([s.point.dx, s.point.dy], s.normal, slope, curvature);
            }
        }
        Ok(Surfaces { list, after_light })
    }

    /// A pixel's surface without textures.
    fn bare(&self, frame: &Frame<'_>, batch: &Batch, i: usize) -> Surface {
        let (mesh, m) = (frame.view.mesh, self.material);
        let point = batch.vector(mesh, &mesh.positions, i);
        let n = batch.vector(mesh, &mesh.normals, i);
        let back = m.double_sided && batch.face_normal(mesh, i).dot(frame.eye.from(point.at)) < 0.0;
        let side = if back { -1.0 } else { 1.0 };
        let length = n.at.length();
        let scale = if length > 0.0 { side / length } else { 0.0 };
        let normal = (n.at * scale).normalize_or(Vec3::Z);
        // The derivative of the normalised normal lies in its plane.
        let [dx, dy] = [n.dx, n.dy].map(|d| (d - normal * normal.dot(d)) * scale);
        let smooth = Moving { at: normal, dx, dy };
        let vertex = batch.color(mesh, i);
        Surface {
            point,
            smooth,
            normal,
            normal_length: 1.0,
            base: std::array::from_fn(|c| m.base_color[c] * vertex[c]),
            metallic: m.metallic,
            roughness: m.roughness,
            specular: m.specular.into(),
            mirror: m.mirror.into(),
            shininess: m.shininess,
            occlusion: 1.0,
            emissive: m.emissive.into(),
        }
    }

    /// Turns the normal by the vector of a normal map.
    fn turn(&self, s: &mut Surface, mesh: &Mesh, batch: &Batch, i: usize, vector: Vec3) {
        s.normal_length = vector.length();
        let n = batch.vector(mesh, &mesh.normals, i).at;
        // The interpolated normal, not the one that may have been turned round to the back.
        let side = if n.dot(s.smooth.at) < 0.0 { -1.0 } else { 1.0 };
        s.normal = side
            * match self.material.normal_space {
                NormalSpace::Tangent => {
                    let (t, sign) = batch.tangent(mesh, i);
                    tangent_normal(n, t, sign, vector, self.material.normal_scale)
                }
                NormalSpace::Object => vector.try_normalize().unwrap_or(n.normalize_or(Vec3::Z)),
            };
    }
}
