//! Plain Rust: the definition.

use super::{BITS, Block, FINE, Frame, ONE, READ, Sums, TEXELS};

/// `a b` of numbers of 15 fractional bits, rounded: what `pmulhrsw` does.
fn product(a: i16, b: i16) -> i16 {
    ((((i32::from(a) * i32::from(b)) >> 14) + 1) >> 1) as i16
}

/// `T` and `T'` of a strip, to 14 fractional bits.
fn across(a: i16, b: i16) -> [i16; 2] {
    let [a, b] = [a, b].map(|m| m.clamp(-ONE, ONE) << (14 - FINE));
    // |c| - 2 in place of 2 - |c|, which would not fit.
    let [p, q] = [a, b].map(|c| product(c, c.abs().wrapping_add(i16::MIN)));
    [-p - q, a.abs() - b.abs()]
}

/// Sums under construction.
pub struct Scalar {
    steps: [[i16; TEXELS]; 2],
    covariance: i16,
    lanes: usize,
    channels: usize,
    sums: Sums,
}

impl Block for Scalar {
    fn new(frame: &Frame) -> Self {
        let [x, y] = frame.places;
        let steps = frame.slopes.map(|slope| {
            std::array::from_fn(|i| product(x[i], slope[0]).wrapping_add(product(y[i], slope[1])))
        });
        let &Frame { covariance, lanes, channels, .. } = frame;
        Self { steps, covariance, lanes, channels, sums: Sums::default() }
    }

    fn add(&mut self, edges: [i32; 4], texels: [&[u8; READ]; 2]) {
        let half = 1 << (BITS - FINE - 1);
        let edges = edges.map(|e| {
            let fine = e.wrapping_add(half) >> (BITS - FINE);
            fine.clamp(i16::MIN.into(), i16::MAX.into()) as i16
        });
        for i in 0..TEXELS {
            let [[p, p_slope], [q, q_slope]] = [0, 1].map(|k| {
                let step = self.steps[k][i];
                across(edges[2 * k].saturating_sub(step), edges[2 * k + 1].saturating_add(step))
            });
            let weight = product(p, q) + product(product(p_slope, q_slope), self.covariance);
            let weight = i64::from(weight.max(0));
            self.sums.weight += weight;
            let texel = &texels[i / 8][i % 8 * self.lanes..];
            for (sum, code) in self.sums.codes.iter_mut().zip(&texel[..self.channels]) {
                *sum += weight * i64::from(*code);
            }
        }
    }

    fn drain(&mut self) -> Sums {
        std::mem::take(&mut self.sums)
    }
}
