//! Light on the surfaces of a batch.

use super::Frame;
use super::batch::Batch;
use super::surface::{Sampled, Surface, Surfaces};
use crate::mesh::{AlphaMode, Camera, Light, Model};
use crate::shade::{Phong, blend, toksvig};
use glam::Vec3;

/// Lights of a scene that has none: a lamp above the viewer's left shoulder, and light from everywhere.
pub(super) fn default_lights(camera: &Camera) -> [Light; 2] {
    let [right, up, back] = [0, 1, 2].map(|k| {
        let row = camera.view[k];
        Vec3::new(row[0] as f32, row[1] as f32, row[2] as f32)
    });
    let towards = -0.5 * right + 0.7 * up + back;
    [
        Light::Directional { direction: (-towards).to_array(), color: [0.8; 3] },
        Light::Ambient { color: [0.2; 3] },
    ]
}

/// Premultiplied colours of a batch.
pub(super) fn light(
    frame: &Frame<'_>,
    sampled: &Sampled<'_>,
    batch: &Batch,
    surfaces: &Surfaces,
) -> Vec<[f32; 4]> {
    let slack = sampled.normal_slack();
    let mut colors = Vec::with_capacity(batch.len());
    for (i, s) in surfaces.list.iter().enumerate() {
        let alpha = match sampled.material.alpha_mode {
            AlphaMode::Opaque => 1.0,
            AlphaMode::Mask(cutoff) if s.base[3] < cutoff => {
                colors.push([0.0; 4]);
                continue;
            }
            AlphaMode::Mask(_) => 1.0,
            AlphaMode::Blend => s.base[3].clamp(0.0, 1.0),
        };
        let lit = if sampled.material.unlit {
            Vec3::new(s.base[0], s.base[1], s.base[2])
        } else {
            lit(frame, sampled, s, slack)
        };
        let mut color = [lit.x, lit.y, lit.z, alpha];
        for (mode, texels) in &surfaces.after_light {
            color = blend(*mode, color, texels[i]);
        }
        let [r, g, b, a] = color;
        let a = if sampled.material.alpha_mode == AlphaMode::Opaque { 1.0 } else { a.clamp(0.0, 1.0) };
        colors.push([r * a, g * a, b * a, a]);
    }
    colors
}

/// The colour that a surface sends to the eye.
fn lit(frame: &Frame<'_>, sampled: &Sampled<'_>, s: &Surface, slack: f32) -> Vec3 {
    let base = Vec3::new(s.base[0], s.base[1], s.base[2]);
    let m = sampled.material;
    let (mut phong, _) = match m.model {
        Model::MetallicRoughness => Phong::from_metallic_roughness(base, s.metallic, s.roughness),
        Model::Phong => {
            let ka = Vec3::from(m.ambient) * base;
            (Phong { ka, kd: base, ks: s.specular, p: s.shininess }, s.specular)
        }
    };
    if s.normal_length < 1.0 {
        let (p, strength) = toksvig(s.normal_length, phong.p, slack);
        (phong.p, phong.ks) = (p, phong.ks * strength);
    }
    let v = frame.eye.from(s.point.at);
    let lights = &frame.lights;
    let mut sum = s.emissive + phong.ka * lights.ambient * s.occlusion;
    for k in 0..lights.len() {
        let (l, light) = lights.at(k, s.point.at);
        sum += phong.lit(light, l, s.normal, v);
    }
    sum
}
