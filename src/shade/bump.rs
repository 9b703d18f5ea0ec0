//! Bump maps: the normal of a surface moved along its normal by a height d, without moving it.
//!
//! ```text
//! p' = p + d n       p'_u = p_u + d_u n + d n_u       n' = p'_u × p'_v
//!                    p'_v = p_v + d_v n + d n_v
//! ```
//!
//! Blinn, "Simulation of wrinkled surfaces", SIGGRAPH 1978, drops the terms with n_u and n_v, which are small
//! where d is small against the radius of curvature. n' has the same direction whatever parameters the surface
//! is described by, so on meshes u and v may be the pixel's x and y.

use glam::Vec3;

/// The perturbed unit normal, on the side of `n`.
///
/// `tangents` are p_u and p_v, `slope` is (d_u, d_v), `curvature` the height d with n_u and n_v, or `None` to
/// drop their terms. `n` where the perturbed surface has no normal.
///
/// ```
/// use glam::Vec3;
/// // A plane with the height d = u: its normal leans against u.
/// let n = multum::shade::bumped([Vec3::X, Vec3::Y], Vec3::Z, [1.0, 0.0], None);
/// assert!((n - Vec3::new(-1.0, 0.0, 1.0).normalize()).length() < 1e-6);
/// ```
#[inline]
pub fn bumped(tangents: [Vec3; 2], n: Vec3, slope: [f32; 2], curvature: Option<(f32, [Vec3; 2])>) -> Vec3 {
    let [p_u, p_v] = tangents;
    // The sense of u × v decides, not that of the result, which may lean past the horizon.
    let side = if p_u.cross(p_v).dot(n) < 0.0 { -1.0 } else { 1.0 };
    let (d, [n_u, n_v]) = curvature.unwrap_or((0.0, [Vec3::ZERO; 2]));
    let moved = [p_u + slope[0] * n + d * n_u, p_v + slope[1] * n + d * n_v];
    // Lengths of a pixel can be tiny: no square of them may vanish.
    let scale = moved[0].abs().max_element().max(moved[1].abs().max_element());
    let cross = (moved[0] / scale).cross(moved[1] / scale);
    (side * cross).try_normalize().unwrap_or(n)
}
