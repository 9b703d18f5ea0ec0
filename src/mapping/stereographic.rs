//! The stereographic picture ("little planet" when it looks down).

use super::azimuthal::{Radial, project, unproject};
use super::{Inverted, Mapped, Mapping, SurfacePoint};
use crate::error::{Error, Result};
use glam::DVec2;

/// R = tan(θ/2)/tan(fov/4): angles stay true everywhere, sizes grow outwards.
///
/// The picture's half width is `fov`/2 from forward; directions past it have uv outside [0, 1]. Straight back
/// has no answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stereographic {
    scale: f64,
}

impl Stereographic {
    /// A picture that is `fov` radians wide, 0 < fov < 2π.
    ///
    /// # Errors
    /// [`Error::Value`] for any other fov.
    pub fn new(fov: f64) -> Result<Self> {
        if !(fov > 0.0 && fov < std::f64::consts::TAU) {
            return Err(Error::value(
                "fov",
                format!("{} degrees", fov.to_degrees()),
                "above 0 and below 360",
            ));
        }
        Ok(Self { scale: (0.25 * fov).tan() })
    }
}

impl Radial for Stereographic {
    fn radius(&self, theta: f64) -> (f64, f64) {
        let t = (0.5 * theta).tan();
        (t / self.scale, 0.5 * (1.0 + t * t) / self.scale)
    }

    fn angle(&self, radius: f64) -> Option<(f64, f64)> {
        let t = radius * self.scale;
        Some((2.0 * t.atan(), 2.0 * self.scale / (1.0 + t * t)))
    }

    fn limit(&self) -> f64 {
        // π itself as a double is a little less than π, and its tangent would pass for a place.
        std::f64::consts::PI.next_down()
    }
}

impl Mapping for Stereographic {
    #[inline]
    fn at(&self, point: &SurfacePoint) -> Mapped {
        project(self, point.p, point.dp)
    }

    #[inline]
    fn inverse_at(&self, uv: DVec2) -> Option<Inverted> {
        unproject(self, uv)
    }

    fn has_inverse(&self) -> bool {
        true
    }
}
