//! A smooth map over a rectangle of pixels as two cubics in each direction.
//!
//! The map is evaluated at 4 x 4 nodes, the Chebyshev-Lobatto points -1, -1/2, 1/2, 1 of the rectangle, sides
//! included; the tensor product of cubics through them misses an analytic map by at most `f'''' h^4 / 96` in each
//! direction, h half the side. It is compared with the map at [`CHECKS`], where that error is large, and refused where
//! it is too far off: then the rectangle is to be cut. A jump or a fold within the rectangle fails in the same way.

use crate::kernel::{Isa, Work, compiled_for};
use glam::DVec2;

/// The nodes of one direction.
const NODES: [f64; 4] = [-1.0, -0.5, 0.5, 1.0];
/// Coefficients of 1, x, x^2, x^3 from the values at the nodes.
const COEFFICIENTS: [[f64; 4]; 4] = [
    [-1.0 / 6.0, 2.0 / 3.0, 2.0 / 3.0, -1.0 / 6.0],
    [1.0 / 6.0, -4.0 / 3.0, 4.0 / 3.0, -1.0 / 6.0],
    [2.0 / 3.0, -2.0 / 3.0, -2.0 / 3.0, 2.0 / 3.0],
    [-2.0 / 3.0, 4.0 / 3.0, -4.0 / 3.0, 2.0 / 3.0],
];
/// Where a cubic is compared with the map: its error is largest at 0 and at 0.79.
const CHECKS: [[f64; 2]; 7] =
    [[0.0, 0.0], [0.79, 0.0], [-0.79, 0.0], [0.0, 0.79], [0.0, -0.79], [0.79, -0.79], [-0.79, 0.79]];

/// The places of a rectangle at which [`Chart::fit`] wants the map: first the nodes, then the checks; each in -1..=1.
pub(super) fn places() -> impl Iterator<Item = DVec2> {
    let nodes = (0..16).map(|k| DVec2::new(NODES[k % 4], NODES[k / 4]));
    nodes.chain(CHECKS.map(DVec2::from_array))
}

/// How many there are.
pub(super) const PLACES: usize = 16 + CHECKS.len();

/// A pair of bicubic polynomials over -1..=1 squared.
#[derive(Clone, Debug)]
pub(super) struct Chart {
    /// `[axis][power of y][power of x]`
    c: [[[f64; 4]; 4]; 2],
}

impl Chart {
    /// The polynomials through the map's values at [`places`], or how many times farther off than allowed they are; `excess`
    /// tells that for a place and an error.
    pub fn fit(values: &[DVec2; PLACES], excess: impl Fn(&Self, DVec2, DVec2) -> f64) -> Result<Self, f64> {
        let mut c = [[[0.0; 4]; 4]; 2];
        for (axis, c) in c.iter_mut().enumerate() {
            let mut across = [[0.0; 4]; 4];
            for (row, across) in across.iter_mut().enumerate() {
                for (power, weights) in COEFFICIENTS.iter().enumerate() {
                    across[power] = (0..4).map(|k| weights[k] * values[4 * row + k][axis]).sum();
                }
            }
            for (power, weights) in COEFFICIENTS.iter().enumerate() {
                for (x, c) in c[power].iter_mut().enumerate() {
                    *c = (0..4).map(|row| weights[row] * across[row][x]).sum();
                }
            }
        }
        let chart = Self { c };
        let mut most = 0.0f64;
        for (p, value) in CHECKS.iter().zip(&values[16..]) {
            let p = DVec2::from_array(*p);
            let excess = excess(&chart, p, chart.at(p) - *value);
            most = if excess.is_nan() { f64::INFINITY } else { most.max(excess) };
        }
        if most <= 1.0 { Ok(chart) } else { Err(most) }
    }

    /// A box that holds all places: its middle and half its sides.
    pub fn bounds(&self) -> [DVec2; 2] {
        let sizes = self.c.map(|c| c.as_flattened().iter().skip(1).map(|x| x.abs()).sum());
        [DVec2::new(self.c[0][0][0], self.c[1][0][0]), DVec2::from_array(sizes)]
    }

    /// The place that a point of the rectangle leads to.
    pub fn at(&self, p: DVec2) -> DVec2 {
        let value = |c: &[[f64; 4]; 4]| horner(&c.map(|row| horner(&row, p.x)), p.y);
        DVec2::new(value(&self.c[0]), value(&self.c[1]))
    }

    /// Derivatives along x and along y, over the sides' halves.
    pub fn slopes(&self, p: DVec2) -> [DVec2; 2] {
        let derived = |c: [f64; 4]| [c[1], 2.0 * c[2], 3.0 * c[3], 0.0];
        let by_x = |c: &[[f64; 4]; 4]| horner(&c.map(|row| horner(&derived(row), p.x)), p.y);
        let by_y = |c: &[[f64; 4]; 4]| horner(&derived(c.map(|row| horner(&row, p.x))), p.y);
        [DVec2::new(by_x(&self.c[0]), by_x(&self.c[1])), DVec2::new(by_y(&self.c[0]), by_y(&self.c[1]))]
    }

    /// Places of a row of points `first + i step`, scaled and moved: `scale * place + offset`, in singles, whose error
    /// is that of the largest.
    pub fn row(&self, isa: Isa, line: &Line, out: [&mut [f32]; 2]) {
        let [xs, ys] = out;
        for (axis, out) in [xs, ys].into_iter().enumerate() {
            let mut c = [0.0; 4];
            for (power, c) in c.iter_mut().enumerate() {
                *c = horner(&std::array::from_fn(|j| self.c[axis][j][power]), line.y) * line.scale[axis];
            }
            c[0] += line.offset[axis];
            let c = c.map(|x| x as f32);
            compiled_for(isa, Row { c, first: line.first as f32, step: line.step as f32, out });
        }
    }
}

/// A row of points of a rectangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub y: f64,
    pub first: f64,
    pub step: f64,
    pub scale: DVec2,
    pub offset: DVec2,
}

#[inline(always)]
fn horner(c: &[f64; 4], x: f64) -> f64 {
    ((c[3] * x + c[2]) * x + c[1]) * x + c[0]
}

struct Row<'a> {
    c: [f32; 4],
    first: f32,
    step: f32,
    out: &'a mut [f32],
}

impl Work for Row<'_> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let [a, b, c, d] = self.c;
        for (i, out) in self.out.iter_mut().enumerate() {
            let x = self.first + self.step * (i as i32) as f32;
            *out = ((d * x + c) * x + b) * x + a;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fit(f: impl Fn(DVec2) -> DVec2, tolerance: f64) -> Option<Chart> {
        let values: Vec<DVec2> = places().map(f).collect();
        Chart::fit(&values.try_into().expect("as many"), |_, _, off| {
            if off.is_nan() { f64::NAN } else { off.abs().max_element() / tolerance }
        })
        .ok()
    }

    #[test]
    fn cubics_are_met_and_their_slopes() {
        let f = |p: DVec2| {
            DVec2::new(p.x * p.x * p.x * p.y - 3.0 * p.y * p.y + 7.0, 2.0 * p.y * p.y * p.y - p.x + p.x * p.y)
        };
        let chart = fit(f, 1e-12).expect("a cubic");
        for p in [DVec2::new(0.3, -0.7), DVec2::new(-1.0, 1.0), DVec2::new(0.9, 0.1)] {
            assert!((chart.at(p) - f(p)).length() < 1e-13);
            let [x, y] = chart.slopes(p);
            assert!((x - DVec2::new(3.0 * p.x * p.x * p.y, -1.0 + p.y)).length() < 1e-12);
            assert!((y - DVec2::new(p.x * p.x * p.x - 6.0 * p.y, 6.0 * p.y * p.y + p.x)).length() < 1e-12);
            let [middle, half] = chart.bounds();
            assert!((f(p) - middle).abs().cmple(half).all());
        }
        for isa in Isa::available() {
            let (mut xs, mut ys) = ([0.0; 37], [0.0; 37]);
            let (scale, offset) = (DVec2::new(2.0, 0.5), DVec2::new(-1.0, 4.0));
            let line = Line { y: 0.25, first: -1.0, step: 0.05, scale, offset };
            chart.row(isa, &line, [&mut xs, &mut ys]);
            for (i, (x, y)) in xs.iter().zip(ys).enumerate() {
                let want = f(DVec2::new(-1.0 + 0.05 * i as f64, 0.25)) * scale + offset;
                assert!((f64::from(*x) - want.x).abs() < 1e-5 && (f64::from(y) - want.y).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn folds_and_jumps_are_refused() {
        assert!(fit(|p| DVec2::new(p.x.abs(), p.y), 1e-3).is_none());
        assert!(fit(|p| DVec2::new(p.x + f64::from(u8::from(p.y > 0.6)), p.y), 1e-3).is_none());
        assert!(fit(|p| DVec2::new(p.x, if p.x > 0.7 { f64::NAN } else { p.y }), 1e-3).is_none());
        assert!(fit(|p| DVec2::new((0.2 * p.x).sin(), (0.2 * p.y).cos()), 1e-4).is_some());
    }
}
