//! EWA: an elliptical weighted average, with Gaussian weights that reach zero at the ellipse's rim.
//!
//! On a level, with the footprint's covariance `C = J J^T` in its texels (the axes' lengths squared), the ellipse
//! is `r^2 = x^T Q^-1 x <= 1` with
//!
//! ```text
//! Q = C / (12 v) + I,      weight = exp(-2 r^2) - exp(-2),      v = 0.13608...
//! ```
//!
//! `v` is the variance of the weight on the unit disc along an axis, so the average has the variance `C/12` of
//! the box over the pixel, to which the unit term adds that of the reconstruction: it keeps a texel centre
//! inside the thinnest ellipse, and with no footprint the texels are interpolated. The minor axis is widened to
//! `sigma1/max_anisotropy` in the ellipse's own axes. The level is the one where it is 2 to 4 texels long, blended
//! with the next: `lambda = log2(sigma2) - 1`.
//!
//! Source: N. Greene, P. Heckbert, "Creating raster omnimax images from multiple perspective views using the
//! elliptical weighted average filter", IEEE CG&A 1986; P. Heckbert, "Fundamentals of texture mapping and image
//! warping", 1989, section 3.5. Cost: at most `8 (4 max_anisotropy + 2)` texels on the finer level and a third as
//! many on the coarser. Error: a Gaussian of the box's variance is not a box; see `docs/filters.md`.

use super::rows::Weights;
use super::sum::{Sum, placed, rows_mean};
use super::{Query, Reader, bilinear, lerp4};
use crate::jacobian::Jacobian;
use crate::kernel::window::{self, Ellipse};
use crate::lod;
use crate::num::{Real, log2};
use crate::texel::{DType, Texel};
use crate::texture::Decode;
use std::cell::RefCell;

/// Variance of `exp(-2 r^2) - exp(-2)` on the unit disc, along an axis.
const VARIANCE: f64 = 0.136_080_29;
/// Longest ellipse, in widths, where no limit is given.
const LONGEST: f64 = 4096.0;
/// Largest axis, in texels of the coarsest level: beyond, nothing changes that could be seen.
const WIDEST: f64 = 32.0;

thread_local! {
    static ROW: RefCell<Vec<f64>> = const { RefCell::new(Vec::new()) };
}

/// The filter at one place.
#[inline(never)]
pub(crate) fn ewa<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    query: &Query,
    max_anisotropy: f64,
) -> [T::Real; 4] {
    let axes = query.jacobian_tx.axes();
    if !axes.sigma1.is_finite() {
        return bilinear(r, r.last_level(), query.s, query.t);
    }
    let minor = axes.sigma2.max(axes.sigma1 / max_anisotropy.min(LONGEST));
    let [mx, my] = axes.major;
    // The ellipse's axes as columns.
    let jacobian_tx = Jacobian::new([[axes.sigma1 * mx, -minor * my], [axes.sigma1 * my, minor * mx]]);
    let query = Query { jacobian_tx, ..*query };
    let (level, fraction) = lod::split(lod::clamp(log2(minor as f32) - 1.0, r.last_level()));
    let fine = on_level(r, level, &query);
    if fraction == 0.0 {
        return fine;
    }
    lerp4(fine, on_level(r, level + 1, &query), T::Real::from_f64(f64::from(fraction)))
}

fn on_level<T: Texel, D: Decode<T>>(r: &Reader<'_, T, D>, level: usize, query: &Query) -> [T::Real; 4] {
    let place = placed(r, level, query);
    let [[a, b], [c, d]] = place.jacobian.m;
    let mut covariance = [a * a + b * b, a * c + b * d, c * c + d * d];
    if level == r.last_level() {
        let shrink = (WIDEST * WIDEST / (covariance[0] + covariance[2])).min(1.0);
        covariance = covariance.map(|x| x * shrink);
    }
    let [xx, xy, yy] = covariance.map(|x| x * (1.0 / (12.0 * VARIANCE)));
    let (xx, yy) = (xx + 1.0, yy + 1.0);
    // Of the matrix with the unit term: never less than 1.
    let det = (xx * yy - xy * xy).max(1.0);
    let centre = [place.near(0, xx.sqrt()), place.near(1, yy.sqrt())];
    if T::DTYPE != DType::F64 {
        let footprint = Ellipse { centre, q: [xx, xy, yy] };
        return rows_mean(r, level, centre, |texels| window::ellipse(r.isa, &footprint, texels));
    }
    let mut sum = Sum::new(r, level, centre);
    let height = yy.sqrt();
    let mut y = (centre[1] - height).ceil();
    ROW.with_borrow_mut(|weights| {
        while y <= centre[1] + height {
            let dy = y - centre[1];
            // The ellipse's points on this row.
            let rest = 1.0 - dy * dy / yy;
            let half = (det / yy * rest.max(0.0)).sqrt();
            let middle = centre[0] + xy / yy * dy;
            let first = (middle - half).ceil();
            let count = ((middle + half).floor() - first).max(-1.0) + 1.0;
            weights.clear();
            weights.extend((0..count as usize).map(|k| {
                let dx = first + k as f64 - middle;
                falloff(1.0 - rest + dx * dx * yy / det)
            }));
            sum.row(r, level, &Weights { row: y as i64, first: first as i64, weights, middle: 0..0 });
            y += 1.0;
        }
    });
    sum.mean()
}

/// `exp(-2 u) - exp(-2)` for u in 0..=1, at least 0; error below 1e-8.
#[inline]
fn falloff(u: f64) -> f64 {
    const RIM: f64 = 0.135_335_283_236_612_7;
    // exp(-u/4), to the eighth power.
    let z = -0.25 * u;
    let series = 1.0
        + z * (1.0
            + z * (0.5
                + z * (1.0 / 6.0 + z * (1.0 / 24.0 + z * (1.0 / 120.0 + z * (1.0 / 720.0 + z / 5040.0))))));
    let square = series * series;
    let fourth = square * square;
    (fourth * fourth - RIM).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weight_is_the_gaussian_less_its_rim() {
        for k in 0..=10_000 {
            let u = f64::from(k) / 1e4;
            assert!((falloff(u) - ((-2.0 * u).exp() - (-2.0f64).exp())).abs() < 1e-8, "{u}");
        }
    }

    #[test]
    fn the_variance_is_that_of_the_weight() {
        let n = 100_000;
        let (mut mass, mut moment) = (0.0, 0.0);
        for k in 0..n {
            let u = (f64::from(k) + 0.5) / f64::from(n);
            let w = (-2.0 * u).exp() - (-2.0f64).exp();
            mass += w;
            moment += w * u;
        }
        // Along one axis: half of the mean squared radius.
        assert!((0.5 * moment / mass - VARIANCE).abs() < 1e-6, "{}", 0.5 * moment / mass);
    }
}
