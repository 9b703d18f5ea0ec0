//! Bicubic: the two-parameter family of Mitchell and Netravali, "Reconstruction filters in computer
//! graphics", SIGGRAPH 1988, equation 8.
//!
//! With `c0..c3` at `-1..2` around a fraction `f` in `[0, 1)`, Catmull-Rom is B = 0, C = 1/2 and the
//! paper's recommendation B = C = 1/3. The weights sum to one. Cost: sixteen texels.

use super::{Reader, whole_and_part};
use crate::num::Real;
use crate::texel::Texel;
use crate::texture::Decode;

/// The parameters of the family.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cubic {
    b: f64,
    c: f64,
}

impl Cubic {
    /// Interpolates the texels; reproduces quadratics.
    pub const CATMULL_ROM: Self = Self { b: 0.0, c: 0.5 };
    /// Smooths a little; reproduces linear functions.
    pub const MITCHELL: Self = Self { b: 1.0 / 3.0, c: 1.0 / 3.0 };

    /// Weights of the texels at -1, 0, 1, 2 for the fraction `f`. The largest is the rest to one, so that
    /// equal texels give their value to the last rounding.
    fn weights<R: Real>(self, f: R) -> [R; 4] {
        let inner = |x: f64| {
            ((12.0 - 9.0 * self.b - 6.0 * self.c) * x + (-18.0 + 12.0 * self.b + 6.0 * self.c)) * x * x
                + (6.0 - 2.0 * self.b)
        };
        let outer = |x: f64| {
            (((-self.b - 6.0 * self.c) * x + (6.0 * self.b + 30.0 * self.c)) * x
                + (-12.0 * self.b - 48.0 * self.c))
                * x
                + (8.0 * self.b + 24.0 * self.c)
        };
        let f = f.to_f64();
        let w = [outer(1.0 + f), inner(f), inner(1.0 - f), outer(2.0 - f)];
        w.map(|w| R::from_f64(w / 6.0))
    }

    /// Derivatives of the weights by the position `f`.
    fn slopes<R: Real>(self, f: R) -> [R; 4] {
        let inner = |x: f64| {
            (3.0 * (12.0 - 9.0 * self.b - 6.0 * self.c) * x + 2.0 * (-18.0 + 12.0 * self.b + 6.0 * self.c))
                * x
        };
        let outer = |x: f64| {
            (3.0 * (-self.b - 6.0 * self.c) * x + 2.0 * (6.0 * self.b + 30.0 * self.c)) * x
                + (-12.0 * self.b - 48.0 * self.c)
        };
        let f = f.to_f64();
        let w = [outer(1.0 + f), inner(f), -inner(1.0 - f), -outer(2.0 - f)];
        w.map(|w| R::from_f64(w / 6.0))
    }
}

/// The cubic reconstruction of level 0 at (s, t).
#[inline(always)]
pub(crate) fn bicubic<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    cubic: Cubic,
    s: f64,
    t: f64,
) -> [T::Real; 4] {
    let (i, fx) = place::<T, D>(r, 0, s);
    let (j, fy) = place::<T, D>(r, 1, t);
    sum(r, i, j, cubic.weights(fx), cubic.weights(fy))
}

/// Value and derivatives by s and t (texels of level 0), along the picture as stored: where a mirrored copy
/// runs backwards the caller turns the sign.
pub(crate) fn bicubic_gradient<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    cubic: Cubic,
    s: f64,
    t: f64,
) -> [[T::Real; 4]; 3] {
    let (i, fx) = place::<T, D>(r, 0, s);
    let (j, fy) = place::<T, D>(r, 1, t);
    let (wx, wy) = (cubic.weights(fx), cubic.weights(fy));
    [sum(r, i, j, wx, wy), sum(r, i, j, cubic.slopes(fx), wy), sum(r, i, j, wx, cubic.slopes(fy))]
}

/// Texel and fraction on one axis, clamped to where the reconstruction still changes.
fn place<T: Texel, D: Decode<T>>(r: &Reader<'_, T, D>, axis: usize, s: f64) -> (i32, T::Real) {
    let plane = &r.layers.planes[0];
    let n = if axis == 0 { plane.width } else { plane.height };
    let s = r.layers.wrap[axis].reduce(s, n.into()).0;
    whole_and_part((s - 0.5).clamp(-4.0, f64::from(n) + 4.0))
}

fn sum<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    i: i32,
    j: i32,
    wx: [T::Real; 4],
    wy: [T::Real; 4],
) -> [T::Real; 4] {
    let plane = &r.layers.planes[0];
    let inside = plane.covers(i - 1, j - 1, i + 2, j + 2);
    let mut total = [T::Real::ZERO; 4];
    for (dy, wy) in (-1..).zip(wy) {
        let mut row = [T::Real::ZERO; 4];
        for (dx, wx) in (-1..).zip(wx) {
            let texel =
                if inside { r.decode.texel(plane.texel(i + dx, j + dy)) } else { r.tap(0, i + dx, j + dy) };
            for (sum, value) in row.iter_mut().zip(texel) {
                *sum += wx * value;
            }
        }
        for (sum, value) in total.iter_mut().zip(row) {
            *sum += wy * value;
        }
    }
    total
}
