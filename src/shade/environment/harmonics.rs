//! Diffuse light by spherical harmonics: nine numbers a colour for all normals.
//!
//! ```text
//! L_lm = ∫ L(ω) Y_lm(ω) dω            E(n)/π = Σ Â_l L_lm Y_lm(n),   Â_0 = 1, Â_1 = 2/3, Â_2 = 1/4
//! ```
//!
//! E is the irradiance; E/π is what a white surface shows. Higher bands add at most a few per cent.
//! Ramamoorthi and Hanrahan, "An efficient representation for irradiance environment maps", SIGGRAPH 2001.

use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// Light of all directions as a surface averages it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Harmonics([DVec3; 9]);

impl Harmonics {
    /// Adds light that comes from a unit direction, over a solid angle.
    pub fn add(&mut self, direction: DVec3, light: DVec3, solid_angle: f64) {
        for (sum, y) in self.0.iter_mut().zip(basis(direction)) {
            *sum += light * (y * solid_angle);
        }
    }

    /// What a white surface with this unit normal shows; not negative.
    pub fn diffuse(&self, n: Vec3) -> Vec3 {
        const BAND: [f64; 9] = [1.0, 2.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0, 0.25, 0.25, 0.25, 0.25, 0.25];
        let y = basis(n.as_dvec3());
        let sum = (0..9).fold(DVec3::ZERO, |sum, k| sum + self.0[k] * (BAND[k] * y[k]));
        sum.max(DVec3::ZERO).as_vec3()
    }
}

/// The real harmonics of bands 0, 1 and 2.
fn basis(d: DVec3) -> [f64; 9] {
    let c = |square: f64| (square / PI).sqrt();
    let (one, two, five) = (0.5 * c(1.0), c(0.75), c(3.75));
    [
        one,
        two * d.y,
        two * d.z,
        two * d.x,
        five * d.x * d.y,
        five * d.y * d.z,
        0.25 * c(5.0) * (3.0 * d.z * d.z - 1.0),
        five * d.x * d.z,
        0.5 * five * (d.x * d.x - d.y * d.y),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light that is a polynomial of the second degree is held exactly: against the integral itself.
    #[test]
    fn quadratic_light_is_exact() {
        let light = |d: DVec3| 0.7 + 0.4 * d.y - 0.3 * d.x + 0.5 * d.x * d.z + 0.2 * d.y * d.y;
        let steps = 400;
        let mut harmonics = Harmonics::default();
        let n = DVec3::new(0.36, 0.48, -0.8);
        let mut exact = 0.0;
        for i in 0..steps {
            for j in 0..2 * steps {
                let theta = (f64::from(i) + 0.5) / f64::from(steps) * PI;
                let phi = (f64::from(j) + 0.5) / f64::from(steps) * PI;
                let d = DVec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin());
                let angle = theta.sin() * (PI / f64::from(steps)).powi(2);
                harmonics.add(d, DVec3::splat(light(d)), angle);
                exact += light(d) * d.dot(n).max(0.0) * angle / PI;
            }
        }
        // The midpoint rule's error is about (π/400)²; that of the clamped cosine's edge no more.
        assert!((f64::from(harmonics.diffuse(n.as_vec3()).x) - exact).abs() < 1e-4);
    }
}
