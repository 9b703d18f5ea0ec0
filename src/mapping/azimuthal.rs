//! What round pictures of directions share: the angle θ from the forward axis becomes a radius R(θ).
//!
//! ```text
//! frame: x right, y up, z forward (centre of the picture)
//!
//!        +-------------+      (u, v) = (1/2, 1/2) + R(θ)/2 · (x, -y)/ρ,    ρ = hypot(x, y)
//!        |   .-'y'-.   |
//!        |  /   |   \  |      R(θ) = θ/π           light probe (angular map)
//!        | |    z--x | |             sin(θ/2)      sphere map, mirror ball
//!        |  \       /  |             c tan(θ/2)    stereographic
//!        |   '-._.-'   |             c θ           fisheye, equidistant
//!        +-------------+             c sin(θ/2)    fisheye, equisolid
//! ```

use super::frame::scaled;
use super::{Inverted, Mapped, Tangents};
use glam::{DVec2, DVec3};

/// A radial law.
pub(super) trait Radial {
    /// R(θ) and R'(θ), for θ in [0, π].
    fn radius(&self, theta: f64) -> (f64, f64);

    /// θ and dθ/dR; `None` past the picture's rim.
    fn angle(&self, radius: f64) -> Option<(f64, f64)>;

    /// The largest θ in the picture.
    fn limit(&self) -> f64 {
        std::f64::consts::PI
    }
}

/// The picture's coordinate of a direction. Straight back, where the whole rim is one direction, the answer
/// lies right of the centre and all entries that the movement touches are +∞.
#[inline]
pub(super) fn project(law: &impl Radial, d: DVec3, dd: Tangents) -> Mapped {
    let Some((d, dd)) = scaled(d, dd) else { return Mapped::NOWHERE };
    let rho = d.x.hypot(d.y);
    let theta = rho.atan2(d.z);
    if theta > law.limit() {
        return Mapped::NOWHERE;
    }
    let (radius, slope) = law.radius(theta);
    let half = DVec2::new(0.5, -0.5);
    if rho == 0.0 {
        if d.z > 0.0 {
            let [dx, dy] = dd.map(|d3| d3.truncate() * half * (slope / d.z));
            return Mapped::new(DVec2::splat(0.5), [dx.x, dy.x], [dx.y, dy.y]);
        }
        let row = dd.map(|d3| if d3.truncate() == DVec2::ZERO { 0.0 } else { f64::INFINITY });
        return Mapped::new(DVec2::new(0.5 + 0.5 * radius, 0.5), row, row);
    }
    let e = d.truncate() / rho;
    let r2 = rho * rho + d.z * d.z;
    // Along e the radius grows with θ, across e the point turns on its ring.
    let [dx, dy] = dd.map(|d3| {
        let along = e.dot(d3.truncate());
        let across = e.perp_dot(d3.truncate());
        let dtheta = (d.z * along - rho * d3.z) / r2;
        (e * (slope * dtheta) + e.perp() * (radius / rho * across)) * half
    });
    Mapped::new(DVec2::splat(0.5) + e * radius * half, [dx.x, dy.x], [dx.y, dy.y])
}

/// The unit direction at a place of the picture.
#[inline]
pub(super) fn unproject(law: &impl Radial, uv: DVec2) -> Option<Inverted> {
    let q = (uv - 0.5) * DVec2::new(2.0, -2.0);
    let radius = q.x.hypot(q.y);
    if !radius.is_finite() {
        return None;
    }
    let (theta, slope) = law.angle(radius)?;
    let (sin, cos) = theta.sin_cos();
    let e = if radius == 0.0 { DVec2::X } else { q / radius };
    // sin θ/R, whose limit at the centre is dθ/dR.
    let ring = if radius == 0.0 { slope } else { sin / radius };
    let tangent = |d: DVec2| {
        let (along, across) = (e.dot(d), e.perp_dot(d));
        (e * (cos * slope * along) + e.perp() * (ring * across)).extend(-sin * slope * along)
    };
    Some(Inverted {
        p: (e * sin).extend(cos),
        du: tangent(DVec2::new(2.0, 0.0)),
        dv: tangent(DVec2::new(0.0, -2.0)),
    })
}
