//! Longitude and colatitude around an axis.
//!
//! ```text
//!            +axis   v = 0                    seen from +axis:
//!              |                                        b   u = 1/4
//!          ____|____                                    |
//!        /     |     \                                  |   . p
//!       |   θ  |  . p |    θ from +axis                 | φ
//!       |------+------|    v = θ/π in [0, 1]  u = 1/2 --+----- a   u = 0 and 1: the seam
//!       |      |      |    v = 1/2: equator             |
//!        \ ____|____ /                                  |
//!              |                                            u = 3/4
//!              v = 1
//!
//! axis z: a = x, b = y.   axis x: a = y, b = z.   axis y: a = z, b = x.
//! ```

use super::frame::scaled;
use super::{Axis, Inverted, Mapped, Mapping, SurfacePoint, Tangents, check_finite};
use crate::error::Result;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// u = φ/2π in [0, 1), v = θ/π in [0, 1]: φ around the axis, θ from +axis.
///
/// With ρ the distance from the axis and r from the centre,
/// du = (a db − b da)/(2π ρ²) and dv = (z dρ − ρ dz)/(π r²).
///
/// On the axis u is 0 and its row +∞ where the point moves off the axis; θ has a cone's tip there, and the row
/// of v is its one-sided slope: away from +axis, towards −axis. The centre has no answer.
///
/// ```
/// use glam::DVec3;
/// use multum::mapping::{Axis, Mapping, Spherical, SurfacePoint};
/// let map = Spherical::new(Axis::Z, DVec3::ZERO)?;
/// assert_eq!(map.at(&SurfacePoint::new(DVec3::new(0.0, 2.0, 0.0))).uv.to_array(), [0.25, 0.5]);
/// # Ok::<(), multum::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spherical {
    axis: Axis,
    center: DVec3,
}

impl Spherical {
    /// A map around `axis` through `center`.
    ///
    /// # Errors
    /// [`crate::Error::Value`] for a centre that is not finite.
    pub fn new(axis: Axis, center: DVec3) -> Result<Self> {
        check_finite("center", &center.to_array())?;
        Ok(Self { axis, center })
    }
}

/// An angle from -π to π as turns in [0, 1).
#[inline]
pub(super) fn in_turns(angle: f64) -> f64 {
    let u = angle / TAU;
    let u = if u < 0.0 { u + 1.0 } else { u };
    // A tiny negative angle rounds to a whole turn; -0 is 0.
    if u >= 1.0 { 0.0 } else { u + 0.0 }
}

/// The angle of (x, y) in turns, in [0, 1), and its tangents; on the axis 0, unbounded where the point moves.
#[inline]
pub(super) fn turns(p: DVec2, dp: [DVec2; 2]) -> (f64, [f64; 2]) {
    let rho = p.x.hypot(p.y);
    if rho == 0.0 {
        return (0.0, dp.map(|d| if d == DVec2::ZERO { 0.0 } else { f64::INFINITY }));
    }
    let e = DVec2::new(p.x / rho, p.y / rho);
    let u = in_turns(p.y.atan2(p.x));
    (u, dp.map(|d| (e.x * d.y - e.y * d.x) / rho / TAU))
}

/// The angle from +z in half turns and its tangents; the direction must have come through [`scaled`].
#[inline]
pub(super) fn half_turns(p: DVec3, dp: Tangents) -> (f64, [f64; 2]) {
    let rho = p.x.hypot(p.y);
    let r2 = rho * rho + p.z * p.z;
    let e = if rho == 0.0 { DVec2::ZERO } else { p.truncate() / rho };
    let slope = |d: DVec3| {
        let outward = if rho == 0.0 { d.x.hypot(d.y) } else { e.dot(d.truncate()) };
        (p.z * outward - rho * d.z) / r2 / PI
    };
    (rho.atan2(p.z) / PI, dp.map(slope))
}

/// Longitude and colatitude of a direction, the pole along +z.
#[inline]
pub(super) fn polar(p: DVec3, dp: Tangents) -> Mapped {
    let Some((p, dp)) = scaled(p, dp) else { return Mapped::NOWHERE };
    let (u, du) = turns(p.truncate(), dp.map(DVec3::truncate));
    let (v, dv) = half_turns(p, dp);
    Mapped::new(DVec2::new(u, v), du, dv)
}

/// The unit direction of a longitude and colatitude, the pole along +z.
#[inline]
pub(super) fn unpolar(uv: DVec2) -> Option<Inverted> {
    if !uv.is_finite() || !(0.0..=1.0).contains(&uv.y) {
        return None;
    }
    // A whole number of turns leaves before the angle grows and loses bits.
    let (sin_phi, cos_phi) = ((uv.x - uv.x.floor()) * TAU).sin_cos();
    let (sin_theta, cos_theta) = (uv.y * PI).sin_cos();
    Some(Inverted {
        p: DVec3::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta),
        du: DVec3::new(-sin_theta * sin_phi, sin_theta * cos_phi, 0.0) * TAU,
        dv: DVec3::new(cos_theta * cos_phi, cos_theta * sin_phi, -sin_theta) * PI,
    })
}

impl Mapping for Spherical {
    fn at(&self, point: &SurfacePoint) -> Mapped {
        let local = |v| self.axis.to_local(v);
        polar(local(point.p - self.center), point.dp.map(local))
    }

    fn inverse_at(&self, uv: DVec2) -> Option<Inverted> {
        unpolar(uv).map(|i| Inverted {
            p: self.axis.to_world(i.p) + self.center,
            du: self.axis.to_world(i.du),
            dv: self.axis.to_world(i.dv),
        })
    }

    fn has_inverse(&self) -> bool {
        true
    }

    fn is_periodic(&self) -> bool {
        true
    }
}
