//! Barycentric coordinates by the inverse of a 2x2 matrix, stable for slivers.
//!
//! With P − A = β (B − A) + γ (C − A), Cramer's rule gives three ratios of signed areas,
//! (α, β, γ) = (PBC, APC, ABP)/ABC. Each area is a difference of products of differences; for a sliver almost
//! everything cancels, so areas are summed in double-double arithmetic (Dekker 1971; Shewchuk 1997) and come
//! out right to the last bits until the triangle is thinner than 1e-30 of its length.

use super::batch::{Numbers, Output, run};
use crate::error::{Error, Result};
use glam::DVec2;

/// Weights of A, B and C, and whether the point is inside (edges and corners included).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// α, β, γ, which sum to 1.
    pub weights: [f64; 3],
    /// All three areas have the triangle's sign or are zero.
    pub inside: bool,
}

/// a − b as a rounded difference and its exact error.
fn two_diff(a: f64, b: f64) -> (f64, f64) {
    let x = a - b;
    let virtual_b = a - x;
    let virtual_a = x + virtual_b;
    (x, (a - virtual_a) + (virtual_b - b))
}

/// A product of two such differences, to about twice the precision of a double.
fn product((a, a_low): (f64, f64), (b, b_low): (f64, f64)) -> (f64, f64) {
    let p = a * b;
    (p, a.mul_add(b, -p) + (a * b_low + a_low * b))
}

/// Twice the signed area of a triangle: (b − a) × (c − a).
pub fn area2(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let (p, p_low) = product(two_diff(b.x, a.x), two_diff(c.y, a.y));
    let (q, q_low) = product(two_diff(b.y, a.y), two_diff(c.x, a.x));
    let (high, low) = two_diff(p, q);
    high + (low + (p_low - q_low))
}

/// Barycentric coordinates of a point.
///
/// # Errors
/// [`Error::Value`] for a triangle without area or with corners that are not finite. A NaN point is not an
/// error: its weights are NaN and it is not inside.
pub fn barycentric(point: DVec2, triangle: [DVec2; 3]) -> Result<Weights> {
    let [a, b, c] = triangle;
    let det = area2(a, b, c);
    if det == 0.0 || !det.is_finite() {
        let expected = "three finite corners that are not on one line (determinant 0)";
        return Err(Error::value("triangle", format!("{a} {b} {c}"), expected));
    }
    let areas = [area2(point, b, c), area2(a, point, c), area2(a, b, point)];
    let inside = areas.iter().all(|s| s * det.signum() >= 0.0);
    Ok(Weights { weights: areas.map(|s| s / det), inside })
}

/// Barycentric coordinates of many points: 3 numbers each in `weights` and 1 in `inside` (1 or 0).
/// `triangles` holds 6 numbers: one triangle for all points, or one each.
///
/// # Errors
/// Those of [`barycentric`], and [`Error::Value`] for arrays of different counts.
pub fn batch(
    points: Numbers<'_>,
    triangles: Numbers<'_>,
    weights: Output<'_>,
    inside: Output<'_>,
) -> Result<()> {
    let count = points.len() / 2;
    let shared = triangles.len() == 6;
    if !shared {
        super::batch::check_length("triangle", triangles.len(), 6 * count)?;
    }
    run(count, weights, Some(inside), [3, 1], false, &|i, out, flag| {
        let first = if shared { 0 } else { 3 * i };
        let corners = [0, 1, 2].map(|k| triangles.pair(first + k));
        let found = barycentric(points.pair(i), corners)?;
        out[..3].copy_from_slice(&found.weights);
        flag[0] = f64::from(u8::from(found.inside));
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slivers_keep_their_weights() {
        // A point on the middle of the long side; thickness down to one part in 10^16 of the length.
        for e in 0..17 {
            let h = 10f64.powi(-e);
            let t = [DVec2::new(1.0, 1.0), DVec2::new(2.0, 2.0), DVec2::new(1.5, 1.5 + h)];
            let thickness = t[2].y - 1.5;
            if thickness == 0.0 {
                assert!(barycentric(DVec2::new(1.5, 1.5), t).is_err());
                continue;
            }
            let got = barycentric(DVec2::new(1.25, 1.25 + 0.25 * thickness), t).expect("a triangle");
            let sum: f64 = got.weights.iter().sum();
            assert!((sum - 1.0).abs() < 4.0 * f64::EPSILON, "{e}: {got:?}");
            // 1.25 + thickness/4 is rounded where the thickness has few bits: judge by its own distance.
            let gamma = ((1.25 + 0.25 * thickness) - 1.25) / thickness;
            assert!((got.weights[2] - gamma).abs() <= 4.0 * f64::EPSILON * gamma.max(1.0), "{e}: {got:?}");
            assert!(got.inside);
        }
    }

    #[test]
    fn lines_and_bad_numbers() {
        let line = [DVec2::ZERO, DVec2::new(0.1, 0.1), DVec2::new(0.3, 0.3)];
        assert!(barycentric(DVec2::ZERO, line).is_err());
        assert!(barycentric(DVec2::ZERO, [DVec2::ZERO, DVec2::X, DVec2::NAN]).is_err());
        let fine = [DVec2::ZERO, DVec2::X, DVec2::Y];
        let lost = barycentric(DVec2::NAN, fine).expect("a triangle");
        assert!(!lost.inside && lost.weights[0].is_nan());
        for winding in [fine, [fine[0], fine[2], fine[1]]] {
            assert!(barycentric(DVec2::new(0.5, 0.5), winding).expect("a triangle").inside);
            assert!(!barycentric(DVec2::new(0.51, 0.5), winding).expect("a triangle").inside);
        }
    }
}
