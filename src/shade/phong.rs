//! The Phong model, and the lights it sums over.
//!
//! ```text
//! L = Σ  ka Ia + kd Id max(0, l·n) + ks Is max(0, v·r)^p,     r = 2 (l·n) n - l
//! ```
//!
//! Phong, "Illumination for computer generated pictures", CACM 1975. A light behind the surface (l·n ≤ 0) gives
//! no highlight, and an exponent of 0, which files write for "none", neither.

use crate::error::Result;
use crate::mesh::Light;
use glam::Vec3;

/// How a surface answers to light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phong {
    /// Share of ambient light that comes back.
    pub ka: Vec3,
    /// Diffuse reflection.
    pub kd: Vec3,
    /// Specular reflection.
    pub ks: Vec3,
    /// Exponent of the highlight.
    pub p: f32,
}

impl Phong {
    /// The Phong surface nearest to glTF's metallic-roughness model.
    ///
    /// kd = (1 - m) c, F = 0.04 (1 - m) + m c, and for a microfacet width α = roughness² the half-vector exponent
    /// 2/α² - 2, a quarter of which is that of v·r. ks = F (p + 2)/2 keeps the lobe's energy: the light in a
    /// highlight does not depend on its width.
    ///
    /// Walter et al., "Microfacet models for refraction through rough surfaces", EGSR 2007 (exponent);
    /// Lewis, "Making shaders more physically plausible", 1993 (energy).
    pub fn from_metallic_roughness(color: Vec3, metallic: f32, roughness: f32) -> (Self, Vec3) {
        let metallic = metallic.clamp(0.0, 1.0);
        // Narrower than this, a light that is a point shows nothing of its highlight.
        let alpha = (roughness * roughness).clamp(0.01, 1.0);
        // Chalk too sends some light off its surface.
        let p = (0.5 / (alpha * alpha) - 0.5).max(0.1);
        let facing = Vec3::splat(0.04).lerp(color, metallic);
        (Self { ka: color, kd: color * (1.0 - metallic), ks: facing * (0.5 * p + 1.0), p }, facing)
    }

    /// What one light adds: `light` from direction `l`, seen from `v`.
    #[inline]
    pub fn lit(&self, light: Vec3, l: Vec3, n: Vec3, v: Vec3) -> Vec3 {
        let facing = l.dot(n);
        if facing <= 0.0 || facing.is_nan() {
            return Vec3::ZERO;
        }
        light * (self.kd * facing + self.highlight(l, n, v))
    }

    fn highlight(&self, l: Vec3, n: Vec3, v: Vec3) -> Vec3 {
        if self.p <= 0.0 || self.ks == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let reflected = 2.0 * l.dot(n) * n - l;
        self.ks * v.dot(reflected).max(0.0).powf(self.p)
    }
}

/// Lights, sorted for a loop over pixels.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    /// The sum of ambient lights.
    pub ambient: Vec3,
    sources: Vec<Source>,
}

#[derive(Clone, Debug)]
struct Source {
    color: Vec3,
    /// Towards the light where it is far away, else where it is.
    place: Vec3,
    is_far: bool,
    falloff: Option<f32>,
    /// Axis and the cosines of the angles where it is full and where it ends.
    cone: Option<(Vec3, [f32; 2])>,
}

impl Lights {
    /// Checks and sorts lights.
    ///
    /// # Errors
    /// As [`Light::check`].
    pub fn new(lights: &[Light]) -> Result<Self> {
        let mut made = Self::default();
        for light in lights {
            light.check()?;
            match light {
                Light::Ambient { color } => made.ambient += Vec3::from(*color),
                Light::Directional { direction, color } => made.sources.push(Source {
                    color: (*color).into(),
                    place: -unit(*direction),
                    is_far: true,
                    falloff: None,
                    cone: None,
                }),
                Light::Point { position, color, falloff, cone } => made.sources.push(Source {
                    color: (*color).into(),
                    place: (*position).into(),
                    is_far: false,
                    falloff: *falloff,
                    cone: cone.map(|(axis, angles)| (unit(axis), angles.map(f32::cos))),
                }),
            }
        }
        Ok(made)
    }

    /// Lights that come from somewhere.
    pub fn len(&self) -> usize {
        self.sources.len()
    }

    /// Whether no light comes from anywhere.
    pub fn is_empty(&self) -> bool {
        self.sources.is_empty()
    }

    /// Direction to light `i` from a point, and what arrives there.
    #[inline]
    pub fn at(&self, i: usize, point: Vec3) -> (Vec3, Vec3) {
        let source = &self.sources[i];
        if source.is_far {
            return (source.place, source.color);
        }
        let way = source.place - point;
        let distance = way.length();
        if distance.is_nan() || distance <= 0.0 {
            return (Vec3::ZERO, Vec3::ZERO);
        }
        let l = way / distance;
        let fade = source.falloff.map_or(1.0, |f| (f / distance) * (f / distance));
        let cone = source.cone.map_or(1.0, |(axis, [inner, outer])| {
            let cos = -l.dot(axis);
            if cos >= inner { 1.0 } else { ((cos - outer) / (inner - outer)).clamp(0.0, 1.0).powi(2) }
        });
        (l, source.color * fade * cone)
    }

    /// All lights on one surface, without shadows.
    pub fn on(&self, surface: &Phong, point: Vec3, n: Vec3, v: Vec3) -> Vec3 {
        (0..self.len()).fold(surface.ka * self.ambient, |sum, i| {
            let (l, light) = self.at(i, point);
            sum + surface.lit(light, l, n, v)
        })
    }
}

/// A vector of any length that is not zero, at length 1.
fn unit(v: [f32; 3]) -> Vec3 {
    let v = glam::DVec3::from(v.map(f64::from));
    v.normalize_or(glam::DVec3::Z).as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_is_the_formula() {
        let surface =
            Phong { ka: Vec3::splat(0.5), kd: Vec3::new(0.8, 0.4, 0.2), ks: Vec3::splat(0.3), p: 7.0 };
        let lights = Lights::new(&[
            Light::Ambient { color: [0.1, 0.2, 0.3] },
            Light::Directional { direction: [0.0, -3.0, -4.0], color: [1.0; 3] },
            Light::Point { position: [2.0, 0.0, 0.0], color: [1.0; 3], falloff: Some(1.0), cone: None },
        ])
        .expect("lights");
        let v = Vec3::new(0.6, 0.0, 0.8);
        // l = (0, 0.6, 0.8): n·l = 0.8, r = (0, -0.6, 0.8), v·r = 0.64. The point light is level with the surface.
        let expected = |c: usize, kd: f32| 0.05 * (c + 1) as f32 + kd * 0.8 + 0.3 * 0.64f32.powi(7);
        let got = lights.on(&surface, Vec3::ZERO, Vec3::Z, v);
        for (c, kd) in [0.8, 0.4, 0.2].into_iter().enumerate() {
            assert!((got[c] - expected(c, kd)).abs() < 1e-6, "{got}");
        }
        // Raised to face the normal, at distance 2: a quarter.
        let (l, light) = lights.at(1, Vec3::new(0.0, 0.0, 0.0));
        assert_eq!((l, light), (Vec3::X, Vec3::splat(0.25)));
    }

    #[test]
    fn a_highlight_keeps_its_energy() {
        // ∫ F (p + 2)/2 cos^p θ cos θ dω / π over the hemisphere is F for every p.
        for roughness in [0.2, 0.5, 0.9] {
            let (phong, facing) = Phong::from_metallic_roughness(Vec3::ONE, 1.0, roughness);
            let steps = 20_000;
            let integral: f64 = (0..steps)
                .map(|i| {
                    let t = (f64::from(i) + 0.5) / f64::from(steps) * std::f64::consts::FRAC_PI_2;
                    f64::from(phong.ks.x) * t.cos().powf(f64::from(phong.p) + 1.0) * t.sin() * 2.0
                })
                .sum::<f64>()
                * std::f64::consts::FRAC_PI_2
                / f64::from(steps);
            assert!((integral - f64::from(facing.x)).abs() < 1e-3, "{integral}");
        }
    }
}
