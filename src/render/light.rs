//! Light on the surfaces of a batch.

use super::batch::Batch;
use super::surface::{Colors, Looks, Sampled, Surface};
use super::{Eye, Frame};
use crate::error::Result;
use crate::mesh::{AlphaMode, Camera, Light, Model};
use crate::shade::{Environment, Phong, Ray, blend, toksvig};
use glam::{DVec3, Vec3};

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
pub(super) fn light<'b, 'a>(
    frame: &'b Frame<'a>,
    sampled: &'b Sampled<'a>,
    batch: &'b Batch,
    seed: u64,
) -> Result<Vec<[f32; 4]>> {
    let mut looks = Looks::new(frame, batch, seed);
    let Colors { base: mut colors, after_light } = sampled.colors(&mut looks)?;
    if !sampled.material.unlit {
        let surfaces = sampled.surfaces(&mut looks, &colors)?;
        let slack = sampled.normal_slack();
        let sky = match frame.view.environment {
            Some(sky) => around(frame, sampled, &surfaces, sky, slack)?,
            None => Vec::new(),
        };
        for (i, (s, color)) in surfaces.iter().zip(&mut colors).enumerate() {
            if matches!(sampled.material.alpha_mode, AlphaMode::Mask(cutoff) if color[3] < cutoff) {
                continue;
            }
            let lit = lit(frame, sampled, s, slack) + sky.get(i).copied().unwrap_or_default();
            *color = [lit.x, lit.y, lit.z, color[3]];
        }
    }
    // Where a mask lets through nothing is left, whatever layers make of the alpha.
    let open: Vec<bool> = match sampled.material.alpha_mode {
        AlphaMode::Mask(cutoff) => colors.iter().map(|c| c[3] < cutoff).collect(),
        _ => Vec::new(),
    };
    let start: fn(f32) -> f32 = match sampled.material.alpha_mode {
        AlphaMode::Blend => |a| a.clamp(0.0, 1.0),
        _ => |_| 1.0,
    };
    colors.iter_mut().for_each(|c| c[3] = start(c[3]));
    for (mode, texels) in after_light {
        colors.iter_mut().zip(texels).for_each(|(c, t)| *c = blend(mode, *c, t));
    }
    if sampled.material.alpha_mode == AlphaMode::Opaque {
        colors.iter_mut().for_each(|c| c[3] = 1.0);
        return Ok(colors);
    }
    for [r, g, b, a] in &mut colors {
        *a = a.clamp(0.0, 1.0);
        (*r, *g, *b) = (*r * *a, *g * *a, *b * *a);
    }
    colors.iter_mut().zip(open).filter(|(_, open)| *open).for_each(|(c, _)| *c = [0.0; 4]);
    Ok(colors)
}

/// The Phong surface of a pixel, and what it reflects head-on.
fn phong(sampled: &Sampled<'_>, s: &Surface) -> (Phong, Vec3) {
    let base = Vec3::new(s.base[0], s.base[1], s.base[2]);
    let m = sampled.material;
    match m.model {
        Model::MetallicRoughness => Phong::from_metallic_roughness(base, s.metallic, s.roughness),
        Model::Phong => {
            let ka = Vec3::from(m.ambient) * base;
            // The mean over the sky of a lobe with the height ks: ∫ ks cos^p θ dω/π = 2 ks/(p + 1).
            let facing =
                if s.shininess > 0.0 { s.specular * (2.0 / (s.shininess + 1.0)) } else { Vec3::ZERO };
            (Phong { ka, kd: base, ks: s.specular, p: s.shininess }, facing)
        }
    }
}

/// What the environment adds to each pixel: diffuse, in the highlight's lobe, and mirrored.
fn around(
    frame: &Frame<'_>,
    sampled: &Sampled<'_>,
    list: &[Surface],
    sky: &Environment,
    slack: f32,
) -> Result<Vec<Vec3>> {
    let mut sum = Vec::with_capacity(list.len());
    let (mut rays, mut exponents, mut shares) = (Vec::new(), Vec::new(), Vec::new());
    for (i, s) in list.iter().enumerate() {
        let (phong, facing) = phong(sampled, s);
        sum.push(phong.kd * sky.diffuse(s.normal, frame.eye_turn) * s.occlusion);
        let v = frame.eye.from(s.point.at);
        let mut share = facing;
        if sampled.material.model == Model::MetallicRoughness {
            // Schlick, "An inexpensive BRDF model for physically-based rendering", Eurographics 1994; rough surfaces
            // do not reach 1 at the rim.
            let rim = (1.0 - v.dot(s.normal)).clamp(0.0, 1.0).powi(5);
            share += (Vec3::splat(1.0 - s.roughness).max(facing) - facing) * rim;
        }
        let (towards, moving) = match frame.eye {
            Eye::At(eye) => ((s.point.at - eye).as_dvec3(), [s.point.dx, s.point.dy].map(|d| d.as_dvec3())),
            Eye::Along(back) => (-back.as_dvec3(), [DVec3::ZERO; 2]),
        };
        let n = s.normal.as_dvec3();
        let turning = [s.smooth.dx, s.smooth.dy].map(|d| d.as_dvec3());
        let ray = Ray { direction: towards, moving }.mirrored(n, turning);
        for (share, p) in [(share, phong.p), (s.mirror, f32::MAX)] {
            if share != Vec3::ZERO {
                let p = if s.normal_length < 1.0 { toksvig(s.normal_length, p, slack).0 } else { p };
                rays.push(ray);
                exponents.push(p);
                shares.push((i, share));
            }
        }
    }
    let light = sky.mirrored(&rays, &exponents, frame.eye_turn, &frame.options.sampler)?;
    for ((i, share), light) in shares.into_iter().zip(light) {
        sum[i] += share * light;
    }
    Ok(sum)
}

/// The colour that a surface sends to the eye.
fn lit(frame: &Frame<'_>, sampled: &Sampled<'_>, s: &Surface, slack: f32) -> Vec3 {
    let (mut phong, _) = phong(sampled, s);
    if s.normal_length < 1.0 {
        let (p, strength) = toksvig(s.normal_length, phong.p, slack);
        (phong.p, phong.ks) = (p, phong.ks * strength);
    }
    let v = frame.eye.from(s.point.at);
    let lights = &frame.lights;
    let mut sum = s.emissive + phong.ka * lights.ambient * s.occlusion;
    for k in 0..lights.len() {
        let (l, light) = lights.at(k, s.point.at);
        let added = phong.lit(light, l, s.normal, v);
        sum += match &frame.shadows {
            Some(shadows) if added != Vec3::ZERO => added * shadows.lit(k, &s.point),
            _ => added,
        };
    }
    sum
}
