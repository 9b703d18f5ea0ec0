//! Gaussian weights over an ellipse.

use super::{CHUNK, Lanes, Mean, Source, Sum};
use crate::num::{ceil, floor};

/// An ellipse `r^2 = x^T Q^-1 x <= 1` whose texels weigh `exp(-2 r^2) - exp(-2)`.
#[derive(Clone, Copy, Debug)]
pub struct Ellipse {
    /// In texels, the centre of texel (0, 0) at 0.
    pub centre: [f64; 2],
    /// `Q_xx`, `Q_xy` and `Q_yy`; the determinant is not below 1.
    pub q: [f64; 3],
}

/// `exp(-2 u)` for u in 0..=1, by the series of `exp(-u/4)` and its eighth power.
#[inline(always)]
fn gaussian<L: Lanes>(u: L) -> L {
    const SERIES: [f32; 7] = [1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0];
    let z = u.mul(L::splat(-0.25));
    let mut sum = L::splat(1.0 / 5040.0);
    for term in SERIES {
        sum = L::splat(term).add(z.mul(sum));
    }
    let square = sum.mul(sum);
    let fourth = square.mul(square);
    fourth.mul(fourth)
}

impl Mean for Ellipse {
    #[inline(always)]
    fn over<L: Lanes, S: Source>(&self, mut source: S) -> [f32; 4] {
        let [cx, cy] = self.centre;
        let [xx, xy, yy] = self.q;
        let det = (xx * yy - xy * xy).max(1.0);
        let (height, drift, across) = (yy.sqrt(), xy / yy, yy / det);
        let (inverse, width) = (1.0 / yy, det / yy);
        let one = L::splat(1.0);
        let rim = gaussian(one);
        let narrow = L::splat(across as f32);
        let steps = L::load(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let mut sum = Sum::<L>::new();
        let (mut row, last) = (ceil(cy - height), floor(cy + height));
        while row <= last {
            let dy = row as f64 - cy;
            let up = dy * dy * inverse;
            let half = (width * (1.0 - up).max(0.0)).sqrt();
            let middle = cx + drift * dy;
            let (mut x, end) = (ceil(middle - half), floor(middle + half));
            let up = L::splat(up as f32);
            while x <= end {
                let dx = L::splat((x as f64 - middle) as f32).add(steps);
                // Beyond the rim nothing weighs anything: there the difference is exactly zero.
                let u = up.add(dx.mul(dx).mul(narrow)).min(one);
                let weights = gaussian(u).sub(rim).max(L::splat(0.0));
                sum.add(&mut source, row, x, weights);
                x += CHUNK as i64;
            }
            row += 1;
        }
        sum.mean()
    }
}
