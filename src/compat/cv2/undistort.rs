//! Where an undistorted picture is read: the camera models of `initUndistortRectifyMap` and of its fisheye form.
//!
//! ```text
//! (x, y) = (a/c, b/c),  (a, b, c) = inverse (j, i, 1)          output pixel (j, i); inverse = (P R)^-1
//! standard  r2 = x^2 + y^2,  k = (1 + k1 r2 + k2 r2^2 + k3 r2^3) / (1 + k4 r2 + k5 r2^2 + k6 r2^3)
//!           x' = x k + 2 p1 x y + p2 (r2 + 2 x^2) + s1 r2 + s2 r2^2
//!           y' = y k + p1 (r2 + 2 y^2) + 2 p2 x y + s3 r2 + s4 r2^2
//!           x'', y'' by the sensor's tilt
//! fisheye   t = atan r,  (x', y') = (x, y) t (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4 t^8) / r
//! place     u = fx x'' + cx,  v = fy y'' + cy
//! ```
//!
//! Sources: Brown, Decentering distortion of lenses, 1966; Kannala and Brandt, A generic camera model, 2006;
//! the documentation of OpenCV's `calib3d`, whose names these are. Everything is computed in doubles.

use crate::error::{Error, Result};
use crate::par;

/// Output pixels that a thread takes at a time, about.
const BAND: usize = 1 << 14;

/// How a lens moves points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4, and the tilt's matrix row by row.
    Standard([f64; 12], [f64; 9]),
    /// k1 to k4.
    Fisheye([f64; 4]),
}

/// A lens before a sensor, and how output pixels see it.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// fx, fy
    pub focal: [f64; 2],
    /// cx, cy
    pub center: [f64; 2],
    /// The lens.
    pub lens: Lens,
    /// From output pixels to directions, row by row.
    pub inverse: [f64; 9],
}

/// Positions to fill, in the forms that `remap` takes.
#[derive(Debug)]
pub enum Target<'a> {
    /// Columns and rows.
    Planes(&'a mut [f32], &'a mut [f32]),
    /// Pairs.
    Pairs(&'a mut [f32]),
    /// Pairs of whole pixels, and fractions `32 * fy + fx` in 1/32 pixel.
    Fixed(&'a mut [i16], &'a mut [u16]),
}

/// The matrix of a sensor turned by `x` and then `y` radians about its axes: rotation, then projection back onto
/// the plane of the lens.
pub fn tilt(x: f64, y: f64) -> [f64; 9] {
    if x == 0.0 && y == 0.0 {
        return [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    }
    let ((sx, cx), (sy, cy)) = (x.sin_cos(), y.sin_cos());
    let r = [[cy, sy * sx, -sy * cx], [0.0, cx, sx], [sy, -cy * sx, cy * cx]];
    let c = r[2];
    let row = |k: usize| [0, 1, 2].map(|i| c[2] * r[k][i] - r[k][2] * c[i]);
    let ([a0, a1, a2], [b0, b1, b2]) = (row(0), row(1));
    [a0, a1, a2, b0, b1, b2, c[0], c[1], c[2]]
}

impl Lens {
    #[inline(always)]
    fn bend(&self, x: f64, y: f64) -> (f64, f64) {
        match self {
            Self::Standard([k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4], t) => {
                let (x2, y2, xy2) = (x * x, y * y, 2.0 * x * y);
                let r2 = x2 + y2;
                let k = (1.0 + ((k3 * r2 + k2) * r2 + k1) * r2) / (1.0 + ((k6 * r2 + k5) * r2 + k4) * r2);
                let u = x * k + p1 * xy2 + p2 * (r2 + 2.0 * x2) + s1 * r2 + s2 * r2 * r2;
                let v = y * k + p1 * (r2 + 2.0 * y2) + p2 * xy2 + s3 * r2 + s4 * r2 * r2;
                let w = t[6] * u + t[7] * v + t[8];
                let w = if w == 0.0 { 1.0 } else { 1.0 / w };
                (w * (t[0] * u + t[1] * v + t[2]), w * (t[3] * u + t[4] * v + t[5]))
            }
            Self::Fisheye([k1, k2, k3, k4]) => {
                let r = (x * x + y * y).sqrt();
                let t = r.atan();
                let t2 = t * t;
                let bent = t * (1.0 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4))));
                let scale = if r == 0.0 { 1.0 } else { bent / r };
                (x * scale, y * scale)
            }
        }
    }
}

impl Camera {
    #[inline(always)]
    fn place(&self, column: usize, row: usize) -> (f64, f64) {
        let (j, i, m) = (column as f64, row as f64, &self.inverse);
        let w = m[6] * j + m[7] * i + m[8];
        let (a, b) = (m[0] * j + m[1] * i + m[2], m[3] * j + m[4] * i + m[5]);
        if matches!(self.lens, Lens::Fisheye(_)) && w <= 0.0 {
            // Behind the camera.
            let side = |v: f64| if v > 0.0 { f64::NEG_INFINITY } else { f64::INFINITY };
            return (side(a), side(b));
        }
        let (x, y) = (a / w, b / w);
        let (x, y) = self.lens.bend(x, y);
        (self.focal[0] * x + self.center[0], self.focal[1] * y + self.center[1])
    }

    /// Fills a map of `width` pixels a row.
    ///
    /// # Errors
    /// [`Error::Value`] for slices whose lengths do not fit; [`Error::Interrupted`].
    pub fn fill(&self, width: usize, target: Target<'_>) -> Result<()> {
        let uneven = || Error::value("map", "arrays of different sizes", "one place an output pixel");
        let rows = (BAND / width.max(1)).max(1);
        let at = |band: usize, i: usize| self.place(i % width, band * rows + i / width);
        match target {
            Target::Planes(x, y) => {
                if x.len() != y.len() {
                    return Err(uneven());
                }
                par::for_each(x.chunks_mut(rows * width).zip(y.chunks_mut(rows * width)), |band, (x, y)| {
                    for (i, (x, y)) in x.iter_mut().zip(y).enumerate() {
                        let (u, v) = at(band, i);
                        (*x, *y) = (u as f32, v as f32);
                    }
                    Ok(())
                })
            }
            Target::Pairs(pairs) => par::for_each(pairs.chunks_mut(2 * rows * width), |band, pairs| {
                for (i, pair) in pairs.chunks_exact_mut(2).enumerate() {
                    let (u, v) = at(band, i);
                    pair.copy_from_slice(&[u as f32, v as f32]);
                }
                Ok(())
            }),
            Target::Fixed(pairs, codes) => {
                if pairs.len() != 2 * codes.len() {
                    return Err(uneven());
                }
                let tiles = pairs.chunks_mut(2 * rows * width).zip(codes.chunks_mut(rows * width));
                par::for_each(tiles, |band, (pairs, codes)| {
                    for (i, (pair, code)) in pairs.chunks_exact_mut(2).zip(codes).enumerate() {
                        let (u, v) = at(band, i);
                        let (u, v) = (thirtyseconds(u), thirtyseconds(v));
                        // As there, whole pixels beyond 16 bits lose their upper bits.
                        pair.copy_from_slice(&[(u >> 5) as i16, (v >> 5) as i16]);
                        *code = ((v & 31) * 32 + (u & 31)) as u16;
                    }
                    Ok(())
                })
            }
        }
    }
}

/// The nearest number of steps of 1/32; NaN and what is too large give the least number there is, as the
/// processor's own conversion does.
#[inline(always)]
pub fn thirtyseconds(v: f64) -> i32 {
    let steps = (v * 32.0).round_ties_even();
    if (-2_147_483_648.0..2_147_483_648.0).contains(&steps) { steps as i32 } else { i32::MIN }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lens_without_distortion_shows_the_matrix() {
        let none = Lens::Standard([0.0; 12], tilt(0.0, 0.0));
        let inverse = [0.01, 0.0, -0.5, 0.0, 0.01, -0.25, 0.0, 0.0, 1.0];
        let camera = Camera { focal: [100.0, 100.0], center: [50.0, 25.0], lens: none, inverse };
        let (mut x, mut y) = (vec![0.0; 200 * 150], vec![0.0; 200 * 150]);
        camera.fill(200, Target::Planes(&mut x, &mut y)).unwrap();
        let mut pairs = vec![0; 200 * 150 * 2];
        let mut codes = vec![0; 200 * 150];
        camera.fill(200, Target::Fixed(&mut pairs, &mut codes)).unwrap();
        for i in 0..x.len() {
            let (j, k) = ((i % 200) as f32, (i / 200) as f32);
            assert!((x[i] - j).abs() < 1e-4 && (y[i] - k).abs() < 1e-4);
            assert_eq!((f32::from(pairs[2 * i]), f32::from(pairs[2 * i + 1]), codes[i]), (j, k, 0));
        }
        assert!(camera.fill(200, Target::Planes(&mut x, &mut y[1..])).is_err());
        assert!(camera.fill(200, Target::Fixed(&mut pairs, &mut codes[1..])).is_err());
    }

    #[test]
    fn a_tilt_keeps_the_axis_and_is_a_homography_of_the_rotation() {
        let t = tilt(0.3, -0.2);
        // The optical axis meets the tilted sensor at its origin.
        assert!(t[2].abs() < 1e-15 && t[5].abs() < 1e-15 && t[8] > 0.0);
        assert_eq!(tilt(0.0, 0.0), [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
        assert_eq!(thirtyseconds(f64::NAN), i32::MIN);
        assert_eq!(thirtyseconds(-1.5), -48);
    }
}
