//! The photograph of a mirror ball.
//!
//! ```text
//! camera --- looks forward (+z) ---> ( ball )
//!
//!        +-------------+
//!        |   .-'y'-.   |      centre: backward (-z), towards the camera
//!        |  /       \  |      rim: forward (+z), behind the ball, one direction all round
//!        | |   -z  x | |      x right, y up: seen from the ball's centre the picture is mirrored
//!        |  \       /  |
//!        |   '-._.-'   |
//!        +-------------+
//! ```

use super::azimuthal::{project, unproject};
use super::{Inverted, Mapped, Mapping, SphereMap, SurfacePoint};
use glam::{DVec2, DVec3};

/// What a camera far away sees in a mirror ball: R = sin(θ'/2), θ' the angle from backward.
///
/// The normal at a place of the ball is half way between the view and the mirrored direction, so this is
/// the [`SphereMap`] of (x, y, −z). Straight forward, at the rim, the Jacobian is +∞.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MirrorBall;

const BACK: DVec3 = DVec3::new(1.0, 1.0, -1.0);

impl Mapping for MirrorBall {
    #[inline]
    fn at(&self, point: &SurfacePoint) -> Mapped {
        project(&SphereMap, point.p * BACK, point.dp.map(|d| d * BACK))
    }

    #[inline]
    fn inverse_at(&self, uv: DVec2) -> Option<Inverted> {
        unproject(&SphereMap, uv).map(|i| Inverted { p: i.p * BACK, du: i.du * BACK, dv: i.dv * BACK })
    }

    fn has_inverse(&self) -> bool {
        true
    }
}
