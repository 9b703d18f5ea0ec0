//! The angle around an axis and the height along it.
//!
//! ```text
//!      +axis                         seen from +axis: φ as in the spherical map,
//!        |   _ _ _ _                 u = φ/2π in [0, 1), the seam at u = 0 along a
//!      .-|-----.    h1   v = 1
//!     ( '-|-' ' )                    axis z: a = x, b = y
//!     |   |     |        v = (p·axis − h0)/(h1 − h0)      axis x: a = y, b = z
//!     |   |     |                    axis y: a = z, b = x
//!      '-.|.-.-'    h0   v = 0       (heights (1, 0) put v = 0 at the top)
//! ```

use super::spherical::turns;
use super::{Axis, Inverted, Mapped, Mapping, SurfacePoint, check_finite};
use crate::error::{Error, Result};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// u = φ/2π in [0, 1), v = (p·axis − h0)/(h1 − h0), both about `center`.
///
/// du = (a db − b da)/(2π ρ²); the row of v is the height's. On the axis u is 0 and its row +∞ where the point
/// moves off the axis, else 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylindrical {
    axis: Axis,
    center: DVec3,
    height: [f64; 2],
}

impl Cylindrical {
    /// A map around `axis` through `center`; `height` is measured from `center` along the axis.
    ///
    /// # Errors
    /// [`Error::Value`] for numbers that are not finite and for equal heights.
    pub fn new(axis: Axis, center: DVec3, height: [f64; 2]) -> Result<Self> {
        check_finite("center", &center.to_array())?;
        check_finite("height", &height)?;
        if height[0] == height[1] || !(height[1] - height[0]).is_finite() {
            return Err(Error::value("height", format!("{height:?}"), "two different heights"));
        }
        Ok(Self { axis, center, height })
    }
}

impl Mapping for Cylindrical {
    fn at(&self, point: &SurfacePoint) -> Mapped {
        let p = self.axis.to_local(point.p - self.center);
        if !p.is_finite() {
            return Mapped::NOWHERE;
        }
        let dp = point.dp.map(|d| self.axis.to_local(d));
        let (u, du) = turns(p.truncate(), dp.map(DVec3::truncate));
        let [h0, h1] = self.height;
        Mapped::new(DVec2::new(u, (p.z - h0) / (h1 - h0)), du, dp.map(|d| d.z / (h1 - h0)))
    }

    /// The point at distance 1 from the axis.
    fn inverse_at(&self, uv: DVec2) -> Option<Inverted> {
        if !uv.is_finite() {
            return None;
        }
        let (sin, cos) = ((uv.x - uv.x.floor()) * TAU).sin_cos();
        let [h0, h1] = self.height;
        let world = |v| self.axis.to_world(v);
        Some(Inverted {
            p: world(DVec3::new(cos, sin, h0 + uv.y * (h1 - h0))) + self.center,
            du: world(DVec3::new(-sin, cos, 0.0) * TAU),
            dv: world(DVec3::new(0.0, 0.0, h1 - h0)),
        })
    }

    fn has_inverse(&self) -> bool {
        true
    }

    fn is_periodic(&self) -> bool {
        true
    }
}
