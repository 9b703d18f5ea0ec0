//! Shadows: a depth texture seen from the light, read through a projective map.
//!
//! ```text
//! (s, t, z) = viewport(M p / w)        share of light = Σ weight(i, j) [depth(i, j) >= z(i, j) - bias]
//! ```
//!
//! The weights are those of the exact mean over the pixel's footprint on the texture: what is averaged is the answer
//! of the comparison, not the depth. z(i, j) is the depth of the receiving surface's own plane at the texel, so a plane
//! does not shade itself however long the footprint is; the bias covers what is left, that the plane is not the
//! surface: half the change of depth over the wider of a texel and the footprint's shorter side, and rounding.
//!
//! Williams, "Casting curved shadows on curved surfaces", SIGGRAPH 1978; Reeves, Salesin and Cook, "Rendering
//! antialiased shadows with depth maps", SIGGRAPH 1987 (percentage-closer filtering).

use crate::filter::{Query, passing};
use crate::footprint::Bend;
use crate::jacobian::Jacobian;
use glam::{DMat4, DVec2, DVec3, DVec4};

/// Longest footprint that is followed, in texels.
const LONGEST: f64 = 48.0;
/// Rounding of depths, in units of depth (-1 to 1).
const ROUNDING: f64 = 1e-6;
/// The steepest plane that is followed, in depth a texel.
const STEEPEST: f64 = 0.05;

/// What a light sees: depths z/w from -1 to 1, infinity for nothing, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthMap {
    width: usize,
    depth: Vec<f32>,
    matrix: DMat4,
}

/// A point that may lie in shadow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// The point.
    pub point: DVec3,
    /// Its movement for one pixel right and one down, in the plane of its face.
    pub moving: [DVec3; 2],
}

impl DepthMap {
    /// Depths of a picture of `width` pixels a row, drawn with `matrix` from world to clip space.
    pub fn new(width: usize, depth: Vec<f32>, matrix: DMat4) -> Self {
        Self { width, depth, matrix }
    }

    /// Whether a point projects into the picture.
    pub fn sees(&self, point: DVec3) -> bool {
        let clip = self.matrix * point.extend(1.0);
        clip.w > 0.0 && clip.truncate().abs().max_element() <= clip.w
    }

    /// Share of the light that reaches a receiver, 0 to 1. `softness` is the least width of the edge, in texels.
    pub fn lit(&self, receiver: &Receiver, softness: f64) -> f32 {
        let height = self.depth.len() / self.width.max(1);
        let clip = self.matrix * receiver.point.extend(1.0);
        if clip.w.is_nan() || clip.w <= 0.0 {
            return 1.0;
        }
        let size = DVec2::new(self.width as f64, height as f64);
        let at = clip.truncate() / clip.w;
        // Movement of x/w is (dx - x/w dw)/w.
        let slopes = receiver.moving.map(|d| {
            let d: DVec4 = self.matrix * d.extend(0.0);
            (d.truncate() - at * d.w) / clip.w
        });
        let half = DVec2::new(0.5, -0.5) * size;
        let place = (DVec2::new(at.x, at.y) * DVec2::new(1.0, -1.0) + 1.0) * 0.5 * size;
        // Far outside there is nothing to ask.
        let near = place.cmpge(DVec2::splat(-2.0 * LONGEST)).all() && place.cmple(size + 2.0 * LONGEST).all();
        if !(near && at.z.is_finite()) {
            return 1.0;
        }
        let columns = slopes.map(|d| DVec2::new(d.x, d.y) * half);
        let jacobian = Jacobian::new([[columns[0].x, columns[1].x], [columns[0].y, columns[1].y]]);
        let plane = plane(columns, slopes.map(|d| d.z));
        let footprint = at_least(jacobian, softness);
        let wide = footprint.axes().sigma2.max(1.0);
        let bias = ROUNDING + 0.5 * wide * (plane.x.abs() + plane.y.abs());
        let query = Query { s: place.x, t: place.y, jacobian_tx: footprint, index: 0, bend: Bend::None };
        passing(&query, |i, j| {
            let inside = (0..self.width as i64).contains(&i) && (0..height as i64).contains(&j);
            if !inside {
                return true;
            }
            let offset = DVec2::new(i as f64 + 0.5, j as f64 + 0.5) - place;
            let depth = f64::from(self.depth[j as usize * self.width + i as usize]);
            depth >= at.z + plane.dot(offset) - bias
        })
    }
}

/// Change of depth for one texel along each axis, from how place and depth move over the screen: zero where the plane
/// is seen edge-on and has none.
fn plane([x, y]: [DVec2; 2], depth: [f64; 2]) -> DVec2 {
    let det = x.perp_dot(y);
    let slope = DVec2::new(depth[0] * y.y - depth[1] * x.y, depth[1] * x.x - depth[0] * y.x) / det;
    if slope.is_finite() { slope.clamp(DVec2::splat(-STEEPEST), DVec2::splat(STEEPEST)) } else { DVec2::ZERO }
}

/// The footprint with every width grown to the root of its square plus that of `softness`, and cut at [`LONGEST`]:
/// the symmetric root of J Jᵀ + softness² I.
fn at_least(jacobian: Jacobian, softness: f64) -> Jacobian {
    let m = jacobian.m.map(|row| row.map(|x| if x.is_finite() { x.clamp(-1e6, 1e6) } else { 1e6 }));
    let [[a, b], [c, d]] = m;
    let (xx, xy, yy) =
        (a * a + b * b + softness * softness, a * c + b * d, c * c + d * d + softness * softness);
    let root = (xx * yy - xy * xy).max(0.0).sqrt();
    let scale = (xx + yy + 2.0 * root).sqrt();
    if scale <= 0.0 {
        return Jacobian::ZERO;
    }
    // The larger width is at most the root of the trace.
    let shrink = (LONGEST / (xx + yy).sqrt()).min(1.0) / scale;
    Jacobian::new([[(xx + root) * shrink, xy * shrink], [xy * shrink, (yy + root) * shrink]])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A light that looks down -z onto the square from -1 to 1; a wall at z = 0.5 covers x < 0.
    fn wall(n: usize) -> DepthMap {
        let depth = (0..n * n).map(|i| if i % n < n / 2 { -0.5 } else { f32::INFINITY }).collect();
        let matrix = DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0));
        DepthMap::new(n, depth, matrix)
    }

    #[test]
    fn the_edge_is_the_share_of_the_footprint() {
        let map = wall(64);
        let receive = |x: f64, width: f64| {
            let moving = [DVec3::X * width, DVec3::Y * width];
            map.lit(&Receiver { point: DVec3::new(x, 0.1, 0.0), moving }, 0.0)
        };
        assert_eq!((receive(-0.5, 0.01), receive(0.5, 0.01)), (0.0, 1.0));
        // A footprint of 12.8 texels a side whose centre lies 3.2 texels inside the light: three quarters.
        assert!((receive(0.1, 0.4) - 0.75).abs() < 1e-6);
        assert!((receive(0.0, 0.4) - 0.5).abs() < 1e-6);
        assert!((receive(-0.15, 0.4) - 0.125).abs() < 1e-6);
    }

    #[test]
    fn a_plane_does_not_shade_itself() {
        // Depth of the plane z = 0.3 x + 0.2 y at texel centres.
        let n = 32;
        let at = |k: usize| (k as f64 + 0.5) / n as f64 * 2.0 - 1.0;
        let depth = (0..n * n).map(|i| -(0.3 * at(i % n) - 0.2 * at(i / n)) as f32).collect::<Vec<_>>();
        let map = DepthMap::new(n, depth, DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0)));
        for k in 0..200 {
            let (x, y) = ((f64::from(k) * 0.61).sin() * 0.9, (f64::from(k) * 0.37).cos() * 0.9);
            let size = 10f64.powf(-3.0 + 3.0 * f64::from(k % 50) / 50.0);
            let moving = [DVec3::new(size, 0.0, 0.3 * size), DVec3::new(0.0, size, 0.2 * size)];
            let receiver = Receiver { point: DVec3::new(x, y, 0.3 * x + 0.2 * y), moving };
            assert_eq!(map.lit(&receiver, 1.5), 1.0, "{k}");
        }
    }

    #[test]
    fn outside_and_behind_the_light_nothing_is_in_shadow() {
        let map = wall(8);
        let receiver = |point| Receiver { point, moving: [DVec3::X, DVec3::Y] };
        assert_eq!(map.lit(&receiver(DVec3::new(-900.0, 0.0, 0.0)), 1.0), 1.0);
        assert_eq!(map.lit(&receiver(DVec3::NAN), 1.0), 1.0);
        assert!(!map.sees(DVec3::new(-3.0, 0.0, 0.0)) && map.sees(DVec3::new(-0.3, 0.0, 0.0)));
    }
}
