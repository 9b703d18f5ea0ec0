//! What footprints alone tell, whatever the texture: a block at a time, in lanes.

use crate::filter::{BLOCK, Query};
use crate::jacobian::Jacobian;
use crate::num::log2;

/// Square of the soft parallelogram's constant: .26 on noise, .5 on pictures with as much contrast in every octave, .8 on
/// edges.
const SOFT: f64 = 0.36;
/// Texels in the smaller height, on the coarsest level that is read by soft weights.
const LEAST_HEIGHT: f64 = 2.5;
/// Octaves beyond, for long footprints.
const MORE: f32 = 1.3;
/// Longest footprint, in widths; see [`crate::filter::area`].
const LONGEST: f64 = 512.0;

/// One footprint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    /// Length of the major axis, in texels of level 0.
    pub sigma1: f64,
    /// Its level of detail.
    pub smooth: f32,
    /// `log2(4 A^2/(C^2 P))`, with the area, the perimeter and [`SOFT`]; no number where the footprint is not finite.
    pub room: f32,
    /// Level on which the smaller height has [`LEAST_HEIGHT`] texels.
    pub sure: f32,
    /// The coarsest level that is thought of.
    pub most: f32,
}

impl Shape {
    /// Without branches, so that a loop over it becomes lanes.
    #[inline(always)]
    pub fn new(jacobian: Jacobian) -> Self {
        let [[a, b], [c, d]] = jacobian.m;
        let squares = [a * a + c * c, b * b + d * d];
        let lengths = squares.map(f64::sqrt);
        let longest = if lengths[0] > lengths[1] { lengths[0] } else { lengths[1] };
        let thinnest = longest * (1.0 / LONGEST);
        let height = jacobian.det().abs() / longest;
        let height = if height > thinnest { height } else { thinnest };
        let area = height * longest;
        let sigma1 = jacobian.sigma1();
        let sure = log2((height * (1.0 / LEAST_HEIGHT)) as f32);
        // The longer a footprint is the more of its error averages out along it.
        let octaves = 0.5 * log2((longest / height) as f32);
        let octaves = if octaves < MORE { octaves } else { MORE };
        let octaves = if octaves > 0.0 { octaves } else { 0.0 };
        let room = log2((area * area * (2.0 / SOFT) / (lengths[0] + lengths[1])) as f32);
        let finite = squares[0] + squares[1] <= f64::MAX;
        let room = if finite { room } else { f32::NAN };
        Self { sigma1, smooth: log2(sigma1 as f32), room, sure, most: sure + octaves }
    }
}

/// Those of a block, number by number.
pub(crate) struct Shapes {
    sigma1: [f64; BLOCK],
    smooth: [f32; BLOCK],
    room: [f32; BLOCK],
    sure: [f32; BLOCK],
    most: [f32; BLOCK],
}

impl Shapes {
    /// None found yet.
    pub const NONE: Self = Self {
        sigma1: [0.0; BLOCK],
        smooth: [0.0; BLOCK],
        room: [0.0; BLOCK],
        sure: [0.0; BLOCK],
        most: [0.0; BLOCK],
    };

    /// Finds those of a block's queries.
    #[inline(always)]
    pub fn find(&mut self, queries: &[(Query, Option<f32>)]) {
        let mut m = [[0.0; BLOCK]; 4];
        for (k, (query, _)) in queries.iter().enumerate().take(BLOCK) {
            let [[a, b], [c, d]] = query.jacobian_tx.m;
            (m[0][k], m[1][k], m[2][k], m[3][k]) = (a, b, c, d);
        }
        let [a, b, c, d] = m;
        for k in 0..BLOCK {
            let shape = Shape::new(Jacobian::new([[a[k], b[k]], [c[k], d[k]]]));
            (self.sigma1[k], self.smooth[k], self.room[k]) = (shape.sigma1, shape.smooth, shape.room);
            (self.sure[k], self.most[k]) = (shape.sure, shape.most);
        }
    }

    /// Number `k`.
    #[inline(always)]
    pub fn at(&self, k: usize) -> Shape {
        let Self { sigma1, smooth, room, sure, most } = self;
        Shape { sigma1: sigma1[k], smooth: smooth[k], room: room[k], sure: sure[k], most: most[k] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rectangle of 4 by 16 texels: perimeter 40, area 64.
    #[test]
    fn a_rectangle_is_what_it_is() {
        let shape = Shape::new(Jacobian::new([[0.0, 16.0], [4.0, 0.0]]));
        let near =
            |got: f32, expected: f64| assert!((f64::from(got) - expected).abs() < 1e-5, "{got} {expected}");
        assert_eq!(shape.sigma1, 16.0);
        near(shape.smooth, 4.0);
        near(shape.sure, (4.0 / LEAST_HEIGHT).log2());
        near(shape.most - shape.sure, 1.0);
        near(shape.room, (4.0 * 64.0 * 64.0 / (SOFT * 40.0)).log2());
    }

    #[test]
    fn what_is_not_finite_has_no_room() {
        for x in [f64::NAN, f64::INFINITY, 1e200] {
            assert!(Shape::new(Jacobian::new([[x, 0.0], [0.0, 1.0]])).room.is_nan());
        }
        assert!(!Shape::new(Jacobian::new([[1e30, 0.0], [0.0, 1e-30]])).room.is_nan());
    }
}
