//! The picture of a pinhole camera.

use super::cube::normalized;
use super::frame::scaled;
use super::{Inverted, Mapped, Mapping, SurfacePoint};
use crate::error::{Error, Result};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// u = ½ + x/(2 z tan(fov/2)), v = ½ − aspect · y/(2 z tan(fov/2)): x right, y up, z forward.
///
/// `fov` is the horizontal angle, aspect = width/height. Directions at or behind the camera's plane have no answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Perspective {
    half: DVec2,
}

impl Perspective {
    /// A camera that sees `fov` radians across, 0 < fov < π.
    ///
    /// # Errors
    /// [`Error::Value`] for any other fov or an aspect that is not positive and finite.
    pub fn new(fov: f64, aspect: f64) -> Result<Self> {
        if !(fov > 0.0 && fov < PI) {
            return Err(Error::value(
                "fov",
                format!("{} degrees", fov.to_degrees()),
                "above 0 and below 180",
            ));
        }
        if !(aspect > 0.0 && aspect.is_finite()) {
            return Err(Error::value("aspect", aspect, "a positive number"));
        }
        let half = (0.5 * fov).tan();
        Ok(Self { half: DVec2::new(half, -half / aspect) })
    }
}

impl Mapping for Perspective {
    #[inline]
    fn at(&self, point: &SurfacePoint) -> Mapped {
        let Some((d, dd)) = scaled(point.p, point.dp) else { return Mapped::NOWHERE };
        if d.z <= 0.0 {
            return Mapped::NOWHERE;
        }
        let q = d.truncate() / d.z;
        let [dx, dy] = dd.map(|d3| (d3.truncate() - q * d3.z) / d.z / self.half * 0.5);
        Mapped::new(q / self.half * 0.5 + 0.5, [dx.x, dy.x], [dx.y, dy.y])
    }

    #[inline]
    fn inverse_at(&self, uv: DVec2) -> Option<Inverted> {
        let q = (uv * 2.0 - 1.0) * self.half;
        if !q.is_finite() {
            return None;
        }
        let (du, dv) = (DVec3::X * (2.0 * self.half.x), DVec3::Y * (2.0 * self.half.y));
        Some(normalized(q.extend(1.0), du, dv, DVec3::ZERO))
    }

    fn has_inverse(&self) -> bool {
        true
    }
}
