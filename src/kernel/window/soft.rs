//! Weights by the distance from the footprint's sides.

use super::{CHUNK, Lanes, Mean, Source, Sum};
use crate::num::{ceil, floor};

/// One pair of sides: the distance of a point from their centre line is `normal . (x, y)`.
#[derive(Clone, Copy, Debug)]
pub struct Strip {
    /// Unit vector across.
    pub normal: [f64; 2],
    /// Half the distance of the sides.
    pub half: f64,
}

impl Strip {
    /// The sides along (x, y), one over whose length is `inverse`, of a footprint with this area.
    #[inline(always)]
    pub fn new([x, y]: [f64; 2], inverse: f64, area: f64) -> Self {
        Self { normal: [-y * inverse, x * inverse], half: 0.5 * area * inverse }
    }

    /// How far the centre line moves from row to row, and half the length of a row within the strip, edges of this softness
    /// included; infinite where rows run along it.
    #[inline(always)]
    fn row(&self, softness: f64) -> [f64; 2] {
        if self.normal[0].abs() <= 1e-9 {
            return [0.0, f64::INFINITY];
        }
        let slope = 1.0 / self.normal[0];
        [-self.normal[1] * slope, (self.half + softness) * slope.abs()]
    }
}

/// A parallelogram with soft edges. The weight of a texel, with `p` and `q` its distances from the centre lines of the two
/// strips, `k1` and `k2` half their widths and `n1` and `n2` their normals, is
///
/// ```text
/// T(k1, p) T(k2, q) + (n1 . n2)/6 T'(k1, p) T'(k2, q), at least 0
///
/// T(k, p) = S(k - p) + S(k + p) - 1,      S(z) = 1/2 + c (1 - |c|/2),  c = clamp(z, -1, 1)
/// T'(k, p) = s(k + p) - s(k - p),         s(z) = 1 - |c|
/// ```
///
/// with all lengths in units of the softness. The first product is the share of the parallelogram in a texel's tent if what
/// blurs one strip has nothing to do with what blurs the other. A tent's variance is 1/6 in every direction, so its parts
/// across the two strips have the covariance `(n1 . n2)/6`, and the second product is the first term of the expansion in
/// it (for a Gaussian that of Mehler).
#[derive(Clone, Copy, Debug)]
pub struct Soft {
    /// In texels, the centre of texel (0, 0) at 0.
    pub centre: [f64; 2],
    /// The two pairs of sides.
    pub strips: [Strip; 2],
    /// Half the extent along x and y, soft edges included.
    pub extent: [f64; 2],
    /// Width of an edge.
    pub softness: f64,
}

/// The integral of the tent up to z.
#[inline(always)]
pub(super) fn ramp<L: Lanes>(z: L) -> L {
    let c = z.min(L::splat(1.0)).max(L::splat(-1.0));
    L::splat(0.5).add(c.mul(L::splat(1.0).sub(c.abs().mul(L::splat(0.5)))))
}

/// `T` and `T'` of a strip, all lengths in units of the softness.
#[inline(always)]
fn across<L: Lanes>(p: L, half: L) -> [L; 2] {
    let one = L::splat(1.0);
    let clamped = |z: L| z.min(one).max(L::splat(-1.0));
    let (near, far) = (clamped(half.sub(p)), clamped(half.add(p)));
    let (a, b) = (near.abs(), far.abs());
    let share = near.add(far).sub(L::splat(0.5).mul(near.mul(a).add(far.mul(b))));
    [share, a.sub(b)]
}

/// Where rows of a [`Soft`] begin and end.
#[derive(Clone, Copy, Debug)]
pub struct Rows {
    /// See [`Strip::row`], for both.
    strips: [[f64; 2]; 2],
    width: f64,
}

impl Rows {
    /// Left and right end of a row, `dy` above the centre, relative to the centre: beyond them nothing has weight.
    #[inline(always)]
    pub fn at(&self, dy: f64) -> [f64; 2] {
        let [[a_drift, a_reach], [b_drift, b_reach]] = self.strips;
        let (a, b, width) = (a_drift * dy, b_drift * dy, self.width);
        [(a - a_reach).max(b - b_reach).max(-width), (a + a_reach).min(b + b_reach).min(width)]
    }
}

impl Soft {
    /// The parallelogram around the origin with these sides, their lengths and its area.
    #[inline(always)]
    pub fn new(sides: [[f64; 2]; 2], lengths: [f64; 2], area: f64, softness: f64) -> Self {
        let [p, q] = sides;
        let [p_inverse, q_inverse] = [1.0 / lengths[0], 1.0 / lengths[1]];
        // Between the sides along q lies what p spans.
        let strips = [Strip::new(q, q_inverse, area), Strip::new(p, p_inverse, area)];
        // Each side is lengthened as far as the edges along the other reach.
        let soft = softness / area;
        let (grow_p, grow_q) = (0.5 + soft * lengths[1], 0.5 + soft * lengths[0]);
        let extent = [p[0].abs() * grow_p + q[0].abs() * grow_q, p[1].abs() * grow_p + q[1].abs() * grow_q];
        Self { centre: [0.0; 2], strips, extent, softness }
    }

    /// Where its rows begin and end.
    #[inline(always)]
    pub fn rows(&self) -> Rows {
        let [p, q] = &self.strips;
        Rows { strips: [p.row(self.softness), q.row(self.softness)], width: self.extent[0] }
    }

    /// What the product of both strips' derivatives is multiplied by.
    #[inline(always)]
    pub fn covariance(&self) -> f64 {
        let [[a, b], [c, d]] = self.strips.map(|s| s.normal);
        (a * c + b * d) / 6.0
    }

    /// The weight, in double precision, of a texel at this place relative to the centre.
    pub fn weight(&self, [dx, dy]: [f64; 2]) -> f64 {
        let [p, q] = self.strips.map(|s| {
            let p = s.normal[0] * dx + s.normal[1] * dy;
            let [a, b] = [s.half - p, s.half + p].map(|z| (z / self.softness).clamp(-1.0, 1.0));
            (a * (1.0 - 0.5 * a.abs()) + b * (1.0 - 0.5 * b.abs()), a.abs() - b.abs())
        });
        (p.0 * q.0 + self.covariance() * p.1 * q.1).max(0.0)
    }
}

impl Mean for Soft {
    #[inline(always)]
    fn over<L: Lanes, S: Source>(&self, mut source: S) -> [f32; 4] {
        let [cx, cy] = self.centre;
        let height = self.extent[1];
        let strips = &self.strips;
        let steps = L::load(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let sharpness = 1.0 / self.softness;
        let half = [0, 1].map(|k| L::splat((strips[k].half * sharpness) as f32));
        let normal = [0, 1].map(|k| strips[k].normal.map(|n| n * sharpness));
        let slope = [steps.mul(L::splat(normal[0][0] as f32)), steps.mul(L::splat(normal[1][0] as f32))];
        let covariance = L::splat(self.covariance() as f32);
        let rows = self.rows();
        let mut sum = Sum::<L>::new();
        let (mut row, last) = (ceil(cy - height), floor(cy + height));
        while row <= last {
            let dy = row as f64 - cy;
            let [left, right] = rows.at(dy);
            let (mut x, end) = (ceil(cx + left), floor(cx + right));
            while x <= end {
                let dx = x as f64 - cx;
                let p = L::splat((normal[0][0] * dx + normal[0][1] * dy) as f32);
                let q = L::splat((normal[1][0] * dx + normal[1][1] * dy) as f32);
                let [p, p_slope] = across(slope[0].add(p), half[0]);
                let [q, q_slope] = across(slope[1].add(q), half[1]);
                let weights = p.mul(q).add(covariance.mul(p_slope.mul(q_slope)));
                sum.add(&mut source, row, x, weights.max(L::splat(0.0)));
                x += CHUNK as i64;
            }
            row += 1;
        }
        sum.mean()
    }
}
