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

use super::spherical::{polar, unpolar};
use super::{Axis, Inverted, Mapped, Mapping, SurfacePoint};
use glam::DVec2;

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

impl Mapping for Equirect {
    fn at(&self, point: &SurfacePoint) -> Mapped {
        let local = |v| Axis::Y.to_local(v);
        let mut mapped = polar(local(point.p), point.dp.map(local));
        let u = mapped.uv.x;
        mapped.uv.x = if u >= 0.5 { u - 0.5 } else { u + 0.5 };
        if mapped.uv.x >= 1.0 {
            mapped.uv.x = 0.0;
        }
        mapped
    }

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
