//! The light probe: all directions in one disc, the angle from forward as the radius.
//!
//! ```text
//! frame: x right, y up, z forward
//!        +-------------+
//!        |   .-'y'-.   |      centre: forward (+z)
//!        |  /       \  |      half way out: the sides (θ = 90°)
//!        | |    z  x | |      rim: backward (-z), one direction all round
//!        |  \       /  |
//!        |   '-._.-'   |      (u, v) = (1/2, 1/2) + θ/(2π) · (x, -y)/hypot(x, y)
//!        +-------------+
//! ```

use super::azimuthal::{Radial, project, unproject};
use super::{Inverted, Mapped, Mapping, SurfacePoint};
use glam::DVec2;
use std::f64::consts::{FRAC_1_PI, PI};

/// The angular map of a chrome sphere: R = θ/π (P. Debevec's light probes).
///
/// Straight back the Jacobian is +∞; the zero direction has no answer. Directions may have any length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightProbe;

impl Radial for LightProbe {
    fn radius(&self, theta: f64) -> (f64, f64) {
        (theta * FRAC_1_PI, FRAC_1_PI)
    }

    fn angle(&self, radius: f64) -> Option<(f64, f64)> {
        (radius <= 1.0).then_some((radius * PI, PI))
    }
}

impl Mapping for LightProbe {
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
