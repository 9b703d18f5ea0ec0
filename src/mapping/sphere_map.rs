//! OpenGL's sphere map: a reflected direction in eye space to a disc.

use super::azimuthal::{Radial, project, unproject};
use super::{Inverted, Mapped, Mapping, SurfacePoint};
use glam::DVec2;

/// u = r_x/m + ½, v = ½ − r_y/m with m = 2 √(r_x² + r_y² + (r_z + 1)²) (OpenGL 2.1, section 2.11.4).
///
/// The direction r is the view ray mirrored by the surface, in eye space: x right, y up, +z towards the
/// viewer. OpenGL's own t runs up; v = 1 − t here, as v runs down. With θ from +z this is R = sin(θ/2), so r
/// may have any length. Straight away from the viewer, at the rim, the Jacobian is +∞.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SphereMap;

impl Radial for SphereMap {
    fn radius(&self, theta: f64) -> (f64, f64) {
        let (sin, cos) = (0.5 * theta).sin_cos();
        (sin, 0.5 * cos)
    }

    fn angle(&self, radius: f64) -> Option<(f64, f64)> {
        // At the rim the slope is infinite: every movement inwards turns the direction at once.
        (radius <= 1.0).then(|| (2.0 * radius.asin(), 2.0 / ((1.0 - radius) * (1.0 + radius)).sqrt()))
    }
}

impl Mapping for SphereMap {
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
