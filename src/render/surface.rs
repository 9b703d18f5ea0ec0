//! What textures make of a batch: the numbers that light needs, pixel by pixel.

use super::batch::{Batch, Moving, Places, Spot};
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

/// Straight colour and alpha of a batch, and the textures that meet the lit colours.
pub(super) struct Colors {
    pub base: Vec<[f32; 4]>,
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

    /// Texels with four numbers: grey becomes three equal ones, missing alpha 1.
    fn rgba(&self, texels: &[f32]) -> Vec<[f32; 4]> {
        let alpha = |a: f32| if self.has_alpha { a } else { 1.0 };
        match self.texture.channels() {
            1 => texels.iter().map(|&l| [l, l, l, 1.0]).collect(),
            2 => texels.as_chunks().0.iter().map(|&[l, a]| [l, l, l, alpha(a)]).collect(),
            3 => texels.as_chunks().0.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect(),
            n => texels.chunks_exact(n).map(|t| [t[0], t[1], t[2], alpha(t[3])]).collect(),
        }
    }

    /// One texel a place.
    pub fn sample(&self, places: &Places, seed: u64) -> Result<Vec<[f32; 4]>> {
        let (channels, count) = (self.texture.channels(), places.uv.len());
        let mut texels = vec![0f32; count * channels];
        let run = |sampler: &Sampler, places: &Places, out: &mut [f32]| {
            let sampler = Sampler { seed: sampler.seed ^ seed, ..*sampler };
            let jacobian = places.jacobian.as_flattened();
            sampler.sample(&self.texture, places.uv.as_flattened(), Extent::Jacobian(jacobian), out)
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
                        uv: chosen.iter().map(|&i| places.uv[i]).collect(),
                        jacobian: chosen.iter().map(|&i| places.jacobian[i]).collect(),
                    };
                    let mut own = vec![0f32; chosen.len() * channels];
                    run(sampler, &part, &mut own)?;
                    for (i, texel) in chosen.iter().zip(own.chunks_exact(channels)) {
                        texels[i * channels..][..channels].copy_from_slice(texel);
                    }
                }
            }
        }
        Ok(self.rgba(&texels))
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

/// Reads textures at the places of a batch, which are computed once for all slots that share them.
pub(super) struct Looks<'b, 'a> {
    frame: &'b Frame<'a>,
    pub batch: &'b Batch,
    /// For random numbers: every batch its own, the same for any number of threads.
    seed: u64,
    made: Vec<(&'b TextureSlot, Places)>,
}

impl<'b, 'a> Looks<'b, 'a> {
    pub fn new(frame: &'b Frame<'a>, batch: &'b Batch, seed: u64) -> Self {
        Self { frame, batch, seed, made: Vec::new() }
    }

    /// One texel a pixel.
    fn read(&mut self, slot: &'b Slot<'a>) -> Result<Vec<[f32; 4]>> {
        let (frame, seed) = (self.frame, self.seed);
        let places = self.of(slot.slot);
        if frame.options.report {
            frame.report.add(slot, places);
        }
        slot.sample(places, seed)
    }

    /// One texel a pixel, where there is a texture.
    fn look(&mut self, slot: &'b Option<Slot<'a>>) -> Result<Vec<[f32; 4]>> {
        slot.as_ref().map_or_else(|| Ok(Vec::new()), |slot| self.read(slot))
    }

    /// Where a slot is read.
    fn of(&mut self, slot: &'b TextureSlot) -> &Places {
        let same = |s: &TextureSlot| s.uv_set == slot.uv_set && s.transform == slot.transform;
        let known = self.made.iter().position(|(s, _)| same(s));
        let index = known.unwrap_or_else(|| {
            self.made.push((slot, self.batch.places(self.frame.view.mesh, slot)));
            self.made.len() - 1
        });
        &self.made[index].1
    }
}

/// What light makes of a material's slot of this name; `None` for those that it does not read.
fn purpose(material: &Material, name: &str) -> Option<Use> {
    match name {
        "base_color_texture" => Some(match material.alpha_mode {
            AlphaMode::Opaque => Use::Color,
            AlphaMode::Blend => Use::ColorAlpha,
            // The share of alpha above the cut-off is that of texture times factor.
            AlphaMode::Mask(cutoff) => match cutoff / material.base_color[3] {
                share if share > 0.0 => Use::Cutout(share.min(1.0).to_bits()),
                _ => Use::ColorAlpha,
            },
        }),
        "alpha_texture" => Some(Use::Data),
        "layers" => Some(Use::ColorAlpha),
        "displacement_texture" => None,
        // What only light would show.
        _ if material.unlit => None,
        "normal_texture" => Some(Use::Normal),
        "bump_texture" => Some(Use::Slopes),
        "emissive_texture" | "specular_texture" => Some(Use::Color),
        _ => Some(Use::Data),
    }
}

impl<'a> Sampled<'a> {
    /// Whether the textures of a material have all been made.
    pub fn are_known(view: &View<'_>, material: usize) -> bool {
        let material = &view.mesh.materials[material];
        let wanted = material.slots().into_iter();
        view.textures.have(wanted.filter_map(|(name, slot)| Some((slot, purpose(material, name)?))))
    }

    /// Reads the textures of a material.
    pub fn new(view: &View<'a>, material: usize, options: &Options) -> Result<Self> {
        let mesh: &'a Mesh = view.mesh;
        let material = &mesh.materials[material];
        let open = |name, slot: &'a Option<TextureSlot>| match (slot, purpose(material, name)) {
            (Some(slot), Some(what)) => Slot::new(view, slot, what, options).map(Some),
            _ => Ok(None),
        };
        let layer = |layer: &'a crate::mesh::Layer| {
            let slot = Slot::new(view, &layer.texture, Use::ColorAlpha, options)?;
            Ok((slot, layer.blend, layer.after_light))
        };
        Ok(Self {
            material,
            base: open("base_color_texture", &material.base_color_texture)?,
            alpha: open("alpha_texture", &material.alpha_texture)?,
            metallic_roughness: open("metallic_roughness_texture", &material.metallic_roughness_texture)?,
            normal: open("normal_texture", &material.normal_texture)?,
            bump: open("bump_texture", &material.bump_texture)?,
            occlusion: open("occlusion_texture", &material.occlusion_texture)?,
            emissive: open("emissive_texture", &material.emissive_texture)?,
            specular: open("specular_texture", &material.specular_texture)?,
            shininess: open("shininess_texture", &material.shininess_texture)?,
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
        let mut alpha: Vec<f32> = batch.spots().map(|spot| start * spot.color(mesh)[3]).collect();
        for (slot, channel) in [(&self.base, 3), (&self.alpha, 0)] {
            let Some(slot) = slot else { continue };
            for (a, texel) in alpha.iter_mut().zip(slot.sample(&batch.places(mesh, slot.slot), 0)?) {
                *a *= texel[channel];
            }
        }
        Ok(alpha)
    }

    /// Colour and alpha before light.
    pub fn colors<'b>(&'b self, looks: &mut Looks<'b, 'a>) -> Result<Colors> {
        let (mesh, factor) = (looks.frame.view.mesh, self.material.base_color);
        let mut base = looks.look(&self.base)?;
        if base.is_empty() {
            base.resize(looks.batch.len(), factor);
        } else if factor != [1.0; 4] {
            base.iter_mut().for_each(|c| *c = blend(Blend::Modulate, factor, *c));
        }
        if !mesh.colors.is_empty() {
            for (c, spot) in base.iter_mut().zip(looks.batch.spots()) {
                *c = blend(Blend::Modulate, *c, spot.color(mesh));
            }
        }
        for (c, t) in base.iter_mut().zip(looks.look(&self.alpha)?) {
            c[3] *= t[0];
        }
        let mut after_light = Vec::new();
        for (slot, mode, after) in &self.layers {
            let texels = looks.read(slot)?;
            if *after {
                after_light.push((*mode, texels));
            } else {
                base.iter_mut().zip(texels).for_each(|(c, t)| *c = blend(*mode, *c, t));
            }
        }
        Ok(Colors { base, after_light })
    }

    /// What light needs of each pixel, given the colours.
    pub fn surfaces<'b>(&'b self, looks: &mut Looks<'b, 'a>, base: &[[f32; 4]]) -> Result<Vec<Surface>> {
        let (frame, batch, m) = (looks.frame, looks.batch, self.material);
        let mesh = frame.view.mesh;
        let mut list: Vec<Surface> =
            batch.spots().zip(base).map(|(spot, base)| self.bare(frame, &spot, *base)).collect();
        for (s, t) in list.iter_mut().zip(looks.look(&self.metallic_roughness)?) {
            (s.roughness, s.metallic) = (s.roughness * t[1], s.metallic * t[2]);
        }
        for (s, t) in list.iter_mut().zip(looks.look(&self.occlusion)?) {
            s.occlusion = 1.0 + m.occlusion_strength * (t[0] - 1.0);
        }
        for (s, t) in list.iter_mut().zip(looks.look(&self.emissive)?) {
            s.emissive *= Vec3::new(t[0], t[1], t[2]);
        }
        for (s, t) in list.iter_mut().zip(looks.look(&self.specular)?) {
            let gloss = Vec3::new(t[0], t[1], t[2]);
            (s.specular, s.mirror) = (s.specular * gloss, s.mirror * gloss);
        }
        for (s, t) in list.iter_mut().zip(looks.look(&self.shininess)?) {
            s.shininess *= t[0];
        }
        let vectors = looks.look(&self.normal)?;
        for ((s, t), spot) in list.iter_mut().zip(vectors).zip(batch.spots()) {
            self.turn(s, mesh, &spot, Vec3::new(t[0], t[1], t[2]));
        }
        if let Some(slot) = &self.bump {
            let heights = looks.read(slot)?;
            let places = looks.of(slot.slot);
            for (i, (s, [d, du, dv, _])) in list.iter_mut().zip(heights).enumerate() {
                let j = places.jacobian(i).m;
                let slope = [0, 1].map(|axis| {
                    m.bump_scale * (f64::from(du) * j[0][axis] + f64::from(dv) * j[1][axis]) as f32
                });
                let n = &s.smooth;
                let curvature = frame.options.bump_curvature.then_some((m.bump_scale * d, [n.dx, n.dy]));
                // Of the smooth surface that the faces stand for: without a slope its normal is left.
                let tangents = [s.point.dx, s.point.dy].map(|d| d - s.normal * s.normal.dot(d));
                s.normal = bumped(tangents, s.normal, slope, curvature);
            }
        }
        Ok(list)
    }

    /// A pixel's surface without textures.
    fn bare(&self, frame: &Frame<'_>, spot: &Spot, base: [f32; 4]) -> Surface {
        let (mesh, m) = (frame.view.mesh, self.material);
        let point = spot.vector(mesh, &mesh.positions);
        let n = spot.vector(mesh, &mesh.normals);
        let back = m.double_sided && spot.face_normal(mesh).dot(frame.eye.from(point.at)) < 0.0;
        let side = if back { -1.0 } else { 1.0 };
        let length = n.at.length();
        let scale = if length > 0.0 { side / length } else { 0.0 };
        let normal = (n.at * scale).normalize_or(Vec3::Z);
        // The derivative of the normalised normal lies in its plane.
        let [dx, dy] = [n.dx, n.dy].map(|d| (d - normal * normal.dot(d)) * scale);
        let smooth = Moving { at: normal, dx, dy };
        Surface {
            point,
            smooth,
            normal,
            normal_length: 1.0,
            base,
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
    fn turn(&self, s: &mut Surface, mesh: &Mesh, spot: &Spot, vector: Vec3) {
        s.normal_length = vector.length();
        let n = spot.normal(mesh);
        // The interpolated normal, not the one that may have been turned round to the back.
        let side = if n.dot(s.smooth.at) < 0.0 { -1.0 } else { 1.0 };
        s.normal = side
            * match self.material.normal_space {
                NormalSpace::Tangent => {
                    let (t, sign) = spot.tangent(mesh);
                    tangent_normal(n, t, sign, vector, self.material.normal_scale)
                }
                NormalSpace::Object => vector.try_normalize().unwrap_or(n.normalize_or(Vec3::Z)),
            };
    }
}
