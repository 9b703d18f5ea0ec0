//! The true shape of a pixel on the texture, where the map is not straight within it.
//!
//! A pixel's preimage under a straight map is the parallelogram of its Jacobian. A perspective makes a quad of it, any
//! other map something with curved sides, and on both the density of pixels varies: the truth is a mean over the
//! *pixel*, and what is nearer to the viewer counts more. So a bent pixel is cut into parts of equal size on the screen,
//! each with its own place and parallelogram; their mean follows the shape and the density.
//!
//! With `d` the distance from the pixel's centre in pixels, `J` the Jacobian there:
//!
//! ```text
//! perspective   p(d) = p + J d / (1 + g.d)          g = slope of the denominator over the denominator; exact
//! curved        p(d) = p + J d + (d, H d)/2         H = second derivatives of both coordinates
//! ```

use crate::jacobian::Jacobian;

/// How a map departs from the straight one of its Jacobian, within a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Bend {
    /// Not at all.
    #[default]
    None,
    /// The slope of the perspective's denominator along both pixel axes, relative to it.
    Perspective([f64; 2]),
    /// Second derivatives by xx, xy and yy, of both coordinates.
    Curved([[f64; 3]; 2]),
}

/// Parts along one axis, at most.
const MOST: u32 = 8;
/// How far a part's corners may be from where they should be, in widths of the footprint.
const OFF: f64 = 0.08;

impl Bend {
    /// How far the place at `d` pixels from the centre is from the centre's.
    #[inline]
    pub fn offset(&self, jacobian: Jacobian, d: [f64; 2]) -> [f64; 2] {
        let [[a, b], [c, e]] = jacobian.m;
        let straight = [a * d[0] + b * d[1], c * d[0] + e * d[1]];
        match self {
            Self::None => straight,
            Self::Perspective(g) => {
                let scale = 1.0 / (1.0 + g[0] * d[0] + g[1] * d[1]);
                straight.map(|x| x * scale)
            }
            Self::Curved(h) => std::array::from_fn(|axis| {
                let [xx, xy, yy] = h[axis];
                straight[axis] + 0.5 * (xx * d[0] * d[0] + yy * d[1] * d[1]) + xy * d[0] * d[1]
            }),
        }
    }

    /// The Jacobian at `d` pixels from the centre.
    #[inline]
    pub fn jacobian(&self, jacobian: Jacobian, d: [f64; 2]) -> Jacobian {
        match self {
            Self::None => jacobian,
            Self::Perspective(g) => {
                let scale = 1.0 / (1.0 + g[0] * d[0] + g[1] * d[1]);
                let offset = self.offset(jacobian, d);
                let m = std::array::from_fn(|axis| {
                    std::array::from_fn(|k| (jacobian.m[axis][k] - offset[axis] * g[k]) * scale)
                });
                Jacobian::new(m)
            }
            Self::Curved(h) => {
                let m = std::array::from_fn(|axis| {
                    let ([a, b], [xx, xy, yy]) = (jacobian.m[axis], h[axis]);
                    [a + xx * d[0] + xy * d[1], b + xy * d[0] + yy * d[1]]
                });
                Jacobian::new(m)
            }
        }
    }

    /// A bound on how far a corner, or the middle of a side, is from where the straight map has it; `longest` is the length
    /// of the longer column of the Jacobian.
    #[inline(always)]
    fn most(&self, longest: f64) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Perspective([g, h]) => {
                let most = 0.5 * (g.abs() + h.abs());
                if most < 1.0 { longest * most / (1.0 - most) } else { f64::INFINITY }
            }
            Self::Curved(h) => {
                let along = |[xx, xy, yy]: [f64; 3]| 0.125 * (xx.abs() + yy.abs()) + 0.25 * xy.abs();
                along(h[0]) + along(h[1])
            }
        }
    }

    /// Into how many parts along x and y the pixel is cut, so that none is off by more than a twelfth of the width of
    /// the footprint: (1, 1) for straight maps.
    #[inline]
    pub fn parts(&self, jacobian: Jacobian) -> [u32; 2] {
        if *self == Self::None {
            return [1, 1];
        }
        self.cut(jacobian)
    }

    fn cut(&self, jacobian: Jacobian) -> [u32; 2] {
        let [[a, b], [c, d]] = jacobian.m;
        let longest = (a * a + c * c).max(b * b + d * d).sqrt();
        let height = jacobian.det().abs() / longest;
        if !(longest.is_finite() && height > 0.0) || longest <= 1.0 {
            // Interpolated, or beyond all shape.
            return [1, 1];
        }
        let width = height.max(1.0).max(longest / 64.0);
        if 2.0 * self.most(longest) <= width * OFF {
            return [1, 1];
        }
        let off = |d: [f64; 2]| {
            let (bent, straight) = (self.offset(jacobian, d), Self::None.offset(jacobian, d));
            let off = (bent[0] - straight[0]).hypot(bent[1] - straight[1]);
            if off.is_finite() { off } else { f64::INFINITY }
        };
        let along = [off([0.5, 0.0]).max(off([-0.5, 0.0])), off([0.0, 0.5]).max(off([0.0, -0.5]))];
        let corners = [[0.5, 0.5], [0.5, -0.5], [-0.5, 0.5], [-0.5, -0.5]].map(off);
        let corner = corners.into_iter().fold(0.0, f64::max);
        let both = (corner - along[0] - along[1]).max(0.0);
        let total = along[0] + along[1];
        [0, 1].map(|k| {
            let share = if total > 0.0 { along[k] / total } else { 0.5 };
            let off = if both.is_finite() { along[k] + both * share } else { f64::INFINITY };
            let horizon = match self {
                // The denominator changes its sign within the pixel.
                Self::Perspective(g) => g[k].abs() >= 1.0,
                _ => false,
            };
            let parts = (off / (width * OFF)).sqrt().ceil();
            if horizon { MOST } else { (parts as u32).clamp(1, MOST) }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const J: Jacobian = Jacobian::new([[3.0, 1.0], [-0.5, 4.0]]);

    #[test]
    fn jacobians_are_derivatives_of_offsets() {
        for bend in
            [Bend::None, Bend::Perspective([0.2, -0.3]), Bend::Curved([[0.3, -0.1, 0.2], [0.05, 0.4, -0.2]])]
        {
            for d in [[0.0, 0.0], [0.3, -0.4], [-0.5, 0.5]] {
                let e = 1e-5;
                let got = bend.jacobian(J, d);
                for k in 0..2 {
                    let mut ahead = d;
                    let mut back = d;
                    ahead[k] += e;
                    back[k] -= e;
                    let (p, q) = (bend.offset(J, ahead), bend.offset(J, back));
                    for axis in 0..2 {
                        let slope = (p[axis] - q[axis]) / (2.0 * e);
                        assert!((slope - got.m[axis][k]).abs() < 1e-7, "{bend:?} {d:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_perspective_form_is_the_quotient() {
        // x = (2 X + Y + 3)/w, y = (X - Y + 1)/w, w = 0.1 X + 0.3 Y + 2, at the origin.
        let place = |x: f64, y: f64| {
            let w = 0.1 * x + 0.3 * y + 2.0;
            [(2.0 * x + y + 3.0) / w, (x - y + 1.0) / w]
        };
        let here = place(0.0, 0.0);
        let j = Jacobian::new([
            [(2.0 - here[0] * 0.1) / 2.0, (1.0 - here[0] * 0.3) / 2.0],
            [(1.0 - here[1] * 0.1) / 2.0, (-1.0 - here[1] * 0.3) / 2.0],
        ]);
        let bend = Bend::Perspective([0.05, 0.15]);
        for d in [[0.5, 0.5], [-0.5, 0.2], [1.0, -1.0]] {
            let (got, there) = (bend.offset(j, d), place(d[0], d[1]));
            for axis in 0..2 {
                assert!((here[axis] + got[axis] - there[axis]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn no_corner_is_further_off_than_the_bound() {
        let at = [0.5, 0.0, -0.5];
        for bend in [
            Bend::Perspective([0.2, -0.3]),
            Bend::Perspective([-0.9, 0.4]),
            Bend::Curved([[0.3, -0.1, 0.2], [0.05, 0.4, -0.2]]),
        ] {
            let longest = (3.0f64 * 3.0 + 0.25).sqrt().max((1.0f64 + 16.0).sqrt());
            for d in at.iter().flat_map(|x| at.iter().map(move |y| [*x, *y])) {
                let (bent, straight) = (bend.offset(J, d), Bend::None.offset(J, d));
                let off = (bent[0] - straight[0]).hypot(bent[1] - straight[1]);
                assert!(off <= bend.most(longest), "{bend:?} at {d:?}: {off}");
            }
        }
    }

    #[test]
    fn straight_pixels_stay_whole_and_bent_ones_do_not() {
        assert_eq!(Bend::None.parts(J), [1, 1]);
        assert_eq!(Bend::Perspective([0.0; 2]).parts(J), [1, 1]);
        assert_eq!(Bend::Perspective([0.0, 1.5]).parts(J)[1], MOST);
        let cut = Bend::Curved([[0.0, 0.0, 2.0], [0.0; 3]]).parts(J);
        assert!(cut[0] < cut[1] && cut[1] > 1, "{cut:?}");
    }
}
