//! The equirectangular panorama.
//!
//! ```text
//! frame: x right, y up, z forward
//!
//!  v = 0  +-------------------------------+  up (+y), the whole row one direction
//!         |   -z   :  -x   :  +z  :  +x   |
//!  v = ½  | back   : left  : fwd  : right | back       u = 1/2 + atan2(x, z)/2π
//!         |        :       :      :       |            v = acos(y/|d|)/π
//!  v = 1  +-------------------------------+  down (-y)
//!         u = 0    ¼      ½      ¾       1   seam: backward
//! ```

use super::frame::scaled;
use super::spherical::{in_turns, polar, unpolar};
use super::{Axis, Inverted, Mapped, Mapping, SurfacePoint};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Direction to panorama, forward at the centre of the picture.
///
/// The spherical map about +y, turned by half a turn; its poles are singular in the same way:
/// straight up and down u is ½ and its row +∞.
///
/// ```
/// use glam::DVec3;
/// use multum::mapping::{Equirect, Mapping, SurfacePoint};
/// assert_eq!(Equirect.at(&SurfacePoint::new(DVec3::Z)).uv.to_array(), [0.5, 0.5]);
/// assert_eq!(Equirect.at(&SurfacePoint::new(DVec3::X)).uv.to_array(), [0.75, 0.5]);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Equirect;

/// Turns from backward from turns from forward.
#[inline]
fn from_forward(u: f64) -> f64 {
    let u = if u >= 0.5 { u - 0.5 } else { u + 0.5 };
    if u >= 1.0 { 0.0 } else { u }
}

impl Mapping for Equirect {
    #[inline]
    fn at(&self, point: &SurfacePoint) -> Mapped {
        let local = |v| Axis::Y.to_local(v);
        let mut mapped = polar(local(point.p), point.dp.map(local));
        mapped.uv.x = from_forward(mapped.uv.x);
        mapped
    }

    #[inline]
    fn place(&self, point: DVec3) -> DVec2 {
        let Some((d, _)) = scaled(Axis::Y.to_local(point), [DVec3::ZERO; 2]) else { return DVec2::NAN };
        let u = in_turns(d.y.atan2(d.x));
        DVec2::new(from_forward(u), (d.x * d.x + d.y * d.y).sqrt().atan2(d.z) / PI)
    }

    #[inline]
    fn inverse_at(&self, uv: DVec2) -> Option<Inverted> {
        unpolar(uv - DVec2::new(0.5, 0.0)).map(|i| Inverted {
            p: Axis::Y.to_world(i.p),
            du: Axis::Y.to_world(i.du),
            dv: Axis::Y.to_world(i.dv),
        })
    }

    fn has_inverse(&self) -> bool {
        true
    }

    fn is_periodic(&self) -> bool {
        true
    }
}
