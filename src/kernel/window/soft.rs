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
    /// The centre line moves by this much from row to row.
    drift: f64,
    /// Half the length of a row within the strip; infinite where rows run along it.
    reach: f64,
}

impl Strip {
    /// The sides along (x, y) of a footprint with this area; edges as soft as `softness`.
    #[inline(always)]
    pub fn new(x: f64, y: f64, area: f64, softness: f64) -> Self {
        let inverse = 1.0 / (x * x + y * y).sqrt();
        let normal = [-y * inverse, x * inverse];
        let half = 0.5 * area * inverse;
        let steep = normal[0].abs() > 1e-9;
        let slope = if steep { 1.0 / normal[0] } else { 0.0 };
        let reach = if steep { (half + softness) * slope.abs() } else { f64::INFINITY };
        Self { normal, half, drift: -normal[1] * slope, reach }
    }
}

/// A parallelogram with soft edges. The weight of a texel is `T(k1, p) T(k2, q)`, with `p` and `q` its distances
/// from the centre lines of the two strips, `k1` and `k2` half their widths, and
///
/// ```text
/// T(k, p) = S(k - |p|) + S(k + |p|) - 1,      S(z) = 1/2 + c (1 - |c|/2),  c = clamp(z / softness, -1, 1)
/// ```
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

/// `S(k - |p|)`, and the other term where the strip is narrower than its edges.
#[inline(always)]
fn weigh<L: Lanes>(p: L, half: L, sharpness: L, narrow: bool) -> L {
    let p = p.abs();
    let near = ramp(half.sub(p).mul(sharpness));
    if narrow { near.add(ramp(half.add(p).mul(sharpness))).sub(L::splat(1.0)) } else { near }
}

impl Soft {
    /// Left and right end of a row, `dy` above the centre, relative to the centre: beyond them nothing has weight.
    #[inline(always)]
    pub fn row(&self, dy: f64) -> [f64; 2] {
        let [a, b] = &self.strips;
        let (a_middle, b_middle, width) = (a.drift * dy, b.drift * dy, self.extent[0]);
        [
            (a_middle - a.reach).max(b_middle - b.reach).max(-width),
            (a_middle + a.reach).min(b_middle + b.reach).min(width),
        ]
    }

    /// The weight, in double precision, of a texel at this place relative to the centre.
    pub fn weight(&self, [dx, dy]: [f64; 2]) -> f64 {
        let ramp = |z: f64| {
            let c = (z / self.softness).clamp(-1.0, 1.0);
            0.5 + c * (1.0 - 0.5 * c.abs())
        };
        let weights = self.strips.map(|s| {
            let p = (s.normal[0] * dx + s.normal[1] * dy).abs();
            ramp(s.half - p) + ramp(s.half + p) - 1.0
        });
        weights[0] * weights[1]
    }
}

impl Mean for Soft {
    #[inline(always)]
    fn over<L: Lanes, S: Source>(&self, mut source: S) -> [f32; 4] {
        let [cx, cy] = self.centre;
        let height = self.extent[1];
        let strips = &self.strips;
        let steps = L::load(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let sharpness = L::splat((1.0 / self.softness) as f32);
        let half = [L::splat(strips[0].half as f32), L::splat(strips[1].half as f32)];
        let narrow = [strips[0].half < self.softness, strips[1].half < self.softness];
        let slope = [
            steps.mul(L::splat(strips[0].normal[0] as f32)),
            steps.mul(L::splat(strips[1].normal[0] as f32)),
        ];
        let mut sum = Sum::<L>::new();
        let (mut row, last) = (ceil(cy - height), floor(cy + height));
        while row <= last {
            let dy = row as f64 - cy;
            let [left, right] = self.row(dy);
            let (mut x, end) = (ceil(cx + left), floor(cx + right));
            while x <= end {
                let dx = x as f64 - cx;
                let p = (strips[0].normal[0] * dx + strips[0].normal[1] * dy) as f32;
                let q = (strips[1].normal[0] * dx + strips[1].normal[1] * dy) as f32;
                let p = weigh(slope[0].add(L::splat(p)), half[0], sharpness, narrow[0]);
                let q = weigh(slope[1].add(L::splat(q)), half[1], sharpness, narrow[1]);
                sum.add(&mut source, row, x, p.mul(q));
                x += CHUNK as i64;
            }
            row += 1;
        }
        sum.mean()
    }
}
