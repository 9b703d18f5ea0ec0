//! One triangle: where a line crosses it, and which of its points is closest.

use glam::DVec3;

/// Where a line crosses a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    /// Distance along the line's direction.
    pub t: f64,
    /// Weights of the corners; none is negative.
    pub weights: [f64; 3],
    /// Whether the line comes from the side where the corners run counter-clockwise.
    pub front: bool,
}

/// A line sheared so that it runs along +z: what does not change from triangle to triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    origin: DVec3,
    axes: [usize; 3],
    shear: [f64; 3],
}

impl Line {
    /// A line through `origin` along `direction`, which is not zero.
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        let d = direction.to_array();
        let z = (0..3).max_by(|&a, &b| d[a].abs().total_cmp(&d[b].abs())).unwrap_or(2);
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if d[z] < 0.0 {
            std::mem::swap(&mut x, &mut y);
        }
        Self { origin, axes: [x, y, z], shear: [d[x] / d[z], d[y] / d[z], 1.0 / d[z]] }
    }

    /// The crossing with a triangle, if any. Neighbours that share an edge leave no gap: the sign of an edge's
    /// determinant depends on the edge alone, and a line through the edge itself crosses both.
    ///
    /// Woop, Benthin, Wald, "Watertight ray/triangle intersection", JCGT 2013; in double precision throughout.
    #[inline(always)]
    pub fn cross(&self, corners: [DVec3; 3]) -> Option<Crossing> {
        let [x, y, z] = self.axes;
        let [sx, sy, sz] = self.shear;
        let local = corners.map(|p| {
            let p = (p - self.origin).to_array();
            [p[x] - sx * p[z], p[y] - sy * p[z], sz * p[z]]
        });
        let [a, b, c] = local;
        let (u, v, w) = (c[0] * b[1] - c[1] * b[0], a[0] * c[1] - a[1] * c[0], b[0] * a[1] - b[1] * a[0]);
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let det = u + v + w;
        if det == 0.0 {
            return None;
        }
        let weights = [u / det, v / det, w / det];
        let t = weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2];
        Some(Crossing { t, weights, front: det > 0.0 })
    }
}

/// The weights of the point of a triangle that is closest to `p`.
///
/// Ericson, "Real-Time Collision Detection", 2005, section 5.1.5: the region of `p` (a corner, an edge, the
/// inside) decides.
pub(super) fn closest([a, b, c]: [DVec3; 3], p: DVec3) -> [f64; 3] {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = share(d1, d1 - d3);
        return [1.0 - v, v, 0.0];
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = share(d2, d2 - d6);
        return [1.0 - w, 0.0, w];
    }
    let va = d3 * d6 - d5 * d4;
    let (e, f) = (d4 - d3, d5 - d6);
    if va <= 0.0 && e >= 0.0 && f >= 0.0 {
        let w = share(e, e + f);
        return [0.0, 1.0 - w, w];
    }
    let sum = va + vb + vc;
    if sum <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let (v, w) = (vb / sum, vc / sum);
    [1.0 - v - w, v, w]
}

/// `part / whole`, 0 where the whole is.
fn share(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}
