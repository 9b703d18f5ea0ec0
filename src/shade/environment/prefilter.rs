//! The prefiltered pyramid: what mirrors show that are not smooth.
//!
//! A Phong lobe of exponent p averages the light around the reflected ray r with weights `max(0, r·ω)^p`; its spread
//! is 1/√p. The pyramid has one lat-long picture for each of a few exponents, as large as its lobe needs. Between two
//! exponents, the two are mixed so that the mean square of the spread, 1/p, is right.
//!
//! Heidrich and Seidel, "Realistic, hardware-accelerated shading and lighting", SIGGRAPH 1999 (prefiltered maps);
//! Miller and Hoffman, "Illumination and reflection maps", SIGGRAPH course 1984 (the idea).

use crate::error::Result;
use crate::par;
use glam::DVec3;
use std::f64::consts::PI;

/// Exponents of the pictures, sharpest first. Beyond the first the mirrored picture itself is mixed in.
pub(super) const EXPONENTS: [f64; 6] = [1024.0, 256.0, 64.0, 16.0, 4.0, 1.0];
/// Texels of a picture in the spread of its lobe.
const TEXELS_A_SPREAD: f64 = 2.5;
/// Rows that no picture falls short of.
const LEAST_ROWS: usize = 16;
/// Weights below this share of the largest are left out.
const NEGLIGIBLE: f64 = 1e-4;

/// Rows of the picture of exponent p.
pub(super) fn rows(p: f64) -> usize {
    ((PI * p.sqrt() * TEXELS_A_SPREAD).ceil() as usize).max(LEAST_ROWS)
}

/// The direction at (u, v) of a lat-long picture, in the frame x right, y up, z forward.
pub(super) fn direction(u: f64, v: f64) -> DVec3 {
    let ((sp, cp), (st, ct)) = (((u - 0.5) * 2.0 * PI).sin_cos(), (v * PI).sin_cos());
    DVec3::new(st * sp, ct, st * cp)
}

/// Solid angle of a texel in row `i` of `rows`, exactly; there are twice as many columns.
pub(super) fn solid_angle(i: usize, rows: usize) -> f64 {
    let edge = |i: usize| (i as f64 / rows as f64 * PI).cos();
    (edge(i) - edge(i + 1)) * PI / rows as f64
}

/// A lat-long picture of `rows` by `2 rows` texels averaged by the lobe of exponent p.
pub(super) fn lobe(light: &[[f32; 3]], rows: usize, p: f64) -> Result<Vec<[f32; 3]>> {
    let columns = 2 * rows;
    let mut out = vec![[0f32; 3]; rows * columns];
    let reach = NEGLIGIBLE.powf(1.0 / p).acos();
    par::for_each(out.chunks_mut(columns), |i, row| {
        let middle = |i: usize| (i as f64 + 0.5) / rows as f64;
        let centre = direction(0.5, middle(i));
        let mut sums = vec![[0f64; 3]; columns];
        let mut total = 0.0;
        for k in 0..rows {
            if (middle(k) - middle(i)).abs() * PI > reach {
                continue;
            }
            let (angle, texels) = (solid_angle(k, rows), &light[k * columns..][..columns]);
            // Weights depend on the difference of columns alone, and are the same to both sides.
            for step in 0..=rows {
                let cosine = centre.dot(direction(0.5 + step as f64 / columns as f64, middle(k)));
                let weight = cosine.max(0.0).powf(p);
                if weight < NEGLIGIBLE {
                    break;
                }
                let sides = if step == 0 || step == rows { 1 } else { 2 };
                total += weight * angle * f64::from(sides);
                for (j, sum) in sums.iter_mut().enumerate() {
                    let after = texels[(j + step) % columns];
                    let before = if sides == 2 { texels[(j + columns - step) % columns] } else { [0.0; 3] };
                    for c in 0..3 {
                        sum[c] += weight * angle * f64::from(after[c] + before[c]);
                    }
                }
            }
        }
        for (out, sum) in row.iter_mut().zip(sums) {
            *out = sum.map(|s| (s / total) as f32);
        }
        Ok(())
    })?;
    Ok(out)
}

/// Between which pictures exponent p lies, counting the mirrored one as -1: the sharper, and the share of the other.
pub(super) fn between(p: f64) -> (isize, f64) {
    let spread = 1.0 / p.max(1e-6);
    let mut sharper = 0.0;
    for (k, e) in EXPONENTS.into_iter().enumerate() {
        let wider = 1.0 / e;
        if spread < wider {
            return (k as isize - 1, (spread - sharper) / (wider - sharper));
        }
        sharper = wider;
    }
    (EXPONENTS.len() as isize - 1, 0.0)
}
