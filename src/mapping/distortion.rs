//! How a map stretches areas and angles.

use super::batch::{Numbers, Output, check_length, run};
use super::{Mapping, SurfacePoint};
use crate::error::Result;
use crate::jacobian::Jacobian;
use glam::DVec3;

/// The stretch of a map's differential at a point of a surface, in texture units per unit of length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distortion {
    /// Largest stretch, the first singular value.
    pub sigma1: f64,
    /// Smallest stretch, the second singular value.
    pub sigma2: f64,
}

impl Distortion {
    /// From a Jacobian by orthonormal tangents of the surface. Infinite entries give infinite stretches.
    pub fn of(jacobian: Jacobian) -> Self {
        if !jacobian.is_finite() {
            return Self { sigma1: f64::INFINITY, sigma2: f64::INFINITY };
        }
        let axes = jacobian.axes();
        Self { sigma1: axes.sigma1, sigma2: axes.sigma2 }
    }

    /// Area in the texture for a unit of area on the surface.
    pub fn area(self) -> f64 {
        self.sigma1 * self.sigma2
    }

    /// How far a small circle becomes an ellipse: σ₁/σ₂, 1 where angles are kept, +∞ where it becomes a line.
    pub fn angle(self) -> f64 {
        let ratio = self.sigma1 / self.sigma2;
        if ratio.is_nan() && !self.sigma1.is_nan() { f64::INFINITY } else { ratio }
    }
}

/// Two unit tangents that make a right-handed frame with a normal of any length; `None` for a zero normal.
///
/// Without branches on nearly equal components (Duff et al., JCGT 2017).
pub fn tangents(normal: DVec3) -> Option<[DVec3; 2]> {
    let n = normal.try_normalize()?;
    let s = 1f64.copysign(n.z);
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    Some([DVec3::new(1.0 + s * n.x * n.x * a, s * b, -s * n.x), DVec3::new(b, s + n.y * n.y * a, -n.y)])
}

/// The distortion of `map` at a point with this normal; NaN where the map has no answer.
pub fn distortion(map: &dyn Mapping, p: DVec3, normal: DVec3) -> Distortion {
    let nothing = Distortion { sigma1: f64::NAN, sigma2: f64::NAN };
    let Some([e1, e2]) = tangents(normal) else { return nothing };
    let mapped = map.at(&SurfacePoint::new(p).with_normal(normal).moving(e1, e2));
    if mapped.uv.is_nan() { nothing } else { Distortion::of(mapped.jacobian) }
}

/// Distortions of many Jacobians by orthonormal tangents: 4 numbers each, σ₁, σ₂, area and angle stretch.
///
/// # Errors
/// [`crate::Error::Value`] for arrays of different counts.
pub fn batch(jacobians: Numbers<'_>, out: Output<'_>) -> Result<()> {
    let count = jacobians.len() / 4;
    check_length("jacobian", jacobians.len(), 4 * count)?;
    run(count, out, None, [4, 1], false, &|i, out, _| {
        let d = Distortion::of(jacobians.jacobian(i));
        out[..4].copy_from_slice(&[d.sigma1, d.sigma2, d.area(), d.angle()]);
        Ok(())
    })
}

/// Tangents of many normals: 6 numbers each, NaN for a zero normal.
///
/// # Errors
/// [`crate::Error::Value`] for arrays of different counts.
pub fn tangents_batch(normals: Numbers<'_>, out: Output<'_>) -> Result<()> {
    let count = normals.len() / 3;
    check_length("normals", normals.len(), 3 * count)?;
    run(count, out, None, [6, 1], false, &|i, out, _| {
        let [e1, e2] = tangents(normals.vector(i, 3)).unwrap_or([DVec3::NAN; 2]);
        out[..3].copy_from_slice(&e1.to_array());
        out[3..6].copy_from_slice(&e2.to_array());
        Ok(())
    })
}
