//! The octahedron unfolded to a square.
//!
//! ```text
//! frame: x right, y up, z forward
//!   +---------------+        centre: forward (+z);  the four corners: backward (-z)
//!   | -z   y   -z   |        inner diamond: z >= 0, (a, b) = (x, y)/(|x| + |y| + |z|)
//!   |    /   \      |        outer triangles: z < 0, folded over the diamond's sides:
//!   |  -x  z   x    |                         a = (1 - |y'|) sign x,  b = (1 - |x'|) sign y
//!   |    \   /      |
//!   | -z  -y   -z   |        u = (1 + a)/2,  v = (1 - b)/2
//!   +---------------+
//! ```

use super::cube::normalized;
use super::frame::scaled;
use super::{Inverted, Mapped, Mapping, SurfacePoint};
use glam::{DVec2, DVec3};

/// Praun and Hoppe, "Spherical parametrization and remeshing" (2003); Cigolle et al., JCGT 2014.
///
/// Continuous inside the square; each side of it is glued to itself about its middle. The Jacobian is finite
/// everywhere and jumps across the planes x = 0, y = 0 and z = 0. The zero direction has no answer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Octahedral;

/// The sign with sign(0) = sign(-0) = 1.
fn sign(x: f64) -> f64 {
    if x < 0.0 { -1.0 } else { 1.0 }
}

impl Mapping for Octahedral {
    #[inline]
    fn at(&self, point: &SurfacePoint) -> Mapped {
        let Some((d, dd)) = scaled(point.p, point.dp) else { return Mapped::NOWHERE };
        let s = DVec3::new(sign(d.x), sign(d.y), sign(d.z));
        let n1 = s.dot(d);
        let q = d.truncate() / n1;
        let slope = dd.map(|x| (x.truncate() - q * s.dot(x)) / n1);
        let s2 = s.truncate();
        let (q, [dx, dy]) = if d.z >= 0.0 {
            (q, slope)
        } else {
            let flip = |x: DVec2| -(x * s2).swapped() * s2;
            (s2 + flip(q), slope.map(flip))
        };
        let half = DVec2::new(0.5, -0.5);
        let (dx, dy) = (dx * half, dy * half);
        Mapped::new(q * half + 0.5, [dx.x, dy.x], [dx.y, dy.y])
    }

    #[inline]
    fn inverse_at(&self, uv: DVec2) -> Option<Inverted> {
        if !(0.0..=1.0).contains(&uv.x) || !(0.0..=1.0).contains(&uv.y) {
            return None;
        }
        let q = DVec2::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y);
        let s = DVec2::new(sign(q.x), sign(q.y));
        let z = 1.0 - q.x.abs() - q.y.abs();
        let lift = |d: DVec2| {
            let dz = -s.dot(d);
            if z >= 0.0 { d.extend(dz) } else { (-(d * s).swapped() * s).extend(dz) }
        };
        let xy = if z >= 0.0 { q } else { s - (q * s).swapped() * s };
        Some(normalized(xy.extend(z), lift(DVec2::new(2.0, 0.0)), lift(DVec2::new(0.0, -2.0)), DVec3::ZERO))
    }

    fn has_inverse(&self) -> bool {
        true
    }
}

/// Exchange of the two components.
trait Swapped {
    fn swapped(self) -> Self;
}

impl Swapped for DVec2 {
    fn swapped(self) -> Self {
        Self::new(self.y, self.x)
    }
}
