//! Two paraboloid mirrors, one for each half of all directions.
//!
//! ```text
//! frame: x right, y up, z forward
//!   +---------+---------+
//!   |  .-y-.  |  .-y-.  |     left disc:  z >= 0, centre forward,  x to the right
//!   | (  z x) | ( -z -x)|     right disc: z < 0,  centre backward, -x to the right: both as seen from inside
//!   |  '-.-'  |  '-.-'  |     on a disc (a, b) = (±x, y)/(|d| + |z|): R = tan(θ/2)
//!   +---------+---------+
//! ```

use super::frame::scaled;
use super::{Inverted, Mapped, Mapping, SurfacePoint};
use glam::{DVec2, DVec3};

/// Heidrich and Seidel, "View-independent environment maps" (1998): the two halves side by side.
///
/// u = (1 + a)/4, plus ½ for the right disc; v = (1 − b)/2. The Jacobian is finite for every direction and
/// jumps in sign of u across z = 0. The zero direction has no answer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DualParaboloid;

impl Mapping for DualParaboloid {
    #[inline]
    fn at(&self, point: &SurfacePoint) -> Mapped {
        let Some((d, dd)) = scaled(point.p, point.dp) else { return Mapped::NOWHERE };
        let (side, offset) = if d.z >= 0.0 { (1.0, 0.0) } else { (-1.0, 0.5) };
        let turn = DVec3::new(side, 1.0, side);
        let (d, dd) = (d * turn, dd.map(|x| x * turn));
        let length = d.length();
        let m = length + d.z;
        let q = d.truncate() / m;
        let scale = DVec2::new(0.25, -0.5);
        let [dx, dy] = dd.map(|x| {
            let dm = d.dot(x) / length + x.z;
            (x.truncate() - q * dm) / m * scale
        });
        Mapped::new(q * scale + DVec2::new(0.25 + offset, 0.5), [dx.x, dy.x], [dx.y, dy.y])
    }

    /// The direction inside either disc.
    #[inline]
    fn inverse_at(&self, uv: DVec2) -> Option<Inverted> {
        if !uv.is_finite() {
            return None;
        }
        let (side, offset) = if uv.x < 0.5 { (1.0, 0.0) } else { (-1.0, 0.5) };
        let q = DVec2::new((uv.x - offset) * 4.0 - 1.0, 1.0 - 2.0 * uv.y);
        let r2 = q.length_squared();
        if r2 > 1.0 {
            return None;
        }
        // (2a, 2b, 1 − r²)/(1 + r²)
        let k = 1.0 + r2;
        let turn = DVec3::new(side, 1.0, side);
        let p = DVec3::new(2.0 * q.x, 2.0 * q.y, 1.0 - r2) / k;
        let slope = |dq: DVec2| {
            let dr2 = 2.0 * q.dot(dq);
            (DVec3::new(2.0 * dq.x, 2.0 * dq.y, -dr2) - p * dr2) / k * turn
        };
        Some(Inverted { p: p * turn, du: slope(DVec2::new(4.0, 0.0)), dv: slope(DVec2::new(0.0, -2.0)) })
    }

    fn has_inverse(&self) -> bool {
        true
    }
}
