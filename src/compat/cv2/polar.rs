//! Maps to polar coordinates and back.

use crate::error::{Error, Result};

/// A circle, seen with radius along x and angle along y.
#[derive(Clone, Copy, Debug)]
pub struct Polar {
    /// Its centre, in pixels.
    pub center: [f64; 2],
    /// Its radius.
    pub radius: f64,
    /// Whether x is the logarithm of the radius and 1.
    pub log: bool,
}

impl Polar {
    /// Radius of one column, or of its logarithm.
    fn step(&self, width: usize) -> f64 {
        if self.log { self.radius.ln() / width as f64 } else { self.radius / width as f64 }
    }

    /// Where pixels of a polar picture of this size lie in the flat one. Angles run from x towards y.
    ///
    /// # Errors
    /// [`Error::Value`] for slices that do not fit.
    pub fn flat(&self, size: [usize; 2], x: &mut [f32], y: &mut [f32]) -> Result<()> {
        let [width, height] = size;
        check(size, x, y)?;
        let step = self.step(width);
        let radii: Vec<f64> = (0..width)
            .map(|i| {
                let rho = i as f64 * step;
                f64::from(if self.log { (rho.exp() - 1.0) as f32 } else { rho as f32 })
            })
            .collect();
        let turn = std::f64::consts::TAU / height as f64;
        for (j, (x, y)) in x.chunks_exact_mut(width).zip(y.chunks_exact_mut(width)).enumerate() {
            let (sin, cos) = (turn * j as f64).sin_cos();
            for ((x, y), rho) in x.iter_mut().zip(y).zip(&radii) {
                *x = (rho * cos + self.center[0]) as f32;
                *y = (rho * sin + self.center[1]) as f32;
            }
        }
        Ok(())
    }

    /// Where pixels of a flat picture of this size lie in the polar one, of size `from`, below its first row by
    /// one. Angles are OpenCV's: an odd polynomial of degree 7 that is off by up to a hundredth of a degree.
    ///
    /// # Errors
    /// [`Error::Value`] for slices that do not fit.
    pub fn polar(&self, from: [usize; 2], size: [usize; 2], x: &mut [f32], y: &mut [f32]) -> Result<()> {
        let width = size[0];
        check(size, x, y)?;
        let (step, turn) = (self.step(from[0]), std::f64::consts::TAU / from[1] as f64);
        let center = self.center.map(|c| c as f32);
        for (j, (x, y)) in x.chunks_exact_mut(width).zip(y.chunks_exact_mut(width)).enumerate() {
            let dy = j as f32 - center[1];
            for (i, (x, y)) in x.iter_mut().zip(y).enumerate() {
                let dx = i as f32 - center[0];
                let rho = (dx * dx + dy * dy).sqrt();
                let rho = if self.log { (rho + 1.0).ln() } else { rho };
                *x = (f64::from(rho) / step) as f32;
                *y = (f64::from(angle(dx, dy)) / turn) as f32 + 1.0;
            }
        }
        Ok(())
    }
}

fn check([width, height]: [usize; 2], x: &[f32], y: &[f32]) -> Result<()> {
    let len = width.checked_mul(height);
    if width > 0 && len == Some(x.len()) && len == Some(y.len()) {
        return Ok(());
    }
    let got = format!("{} and {} positions", x.len(), y.len());
    Err(Error::value("dsize", got, format!("{width} x {height}")))
}

/// The angle of (x, y), from 0 to a whole turn, in radians.
fn angle(x: f32, y: f32) -> f32 {
    const DEGREES: f32 = (180.0 / std::f64::consts::PI) as f32;
    const P: [f32; 4] =
        [0.999_787_84 * DEGREES, -0.325_808_4 * DEGREES, 0.155_578_65 * DEGREES, -0.044_326_555 * DEGREES];
    let (ax, ay) = (x.abs(), y.abs());
    let tiny = f64::EPSILON as f32;
    let c = ax.min(ay) / (ax.max(ay) + tiny);
    let c2 = c * c;
    let mut degrees = (((P[3] * c2 + P[2]) * c2 + P[1]) * c2 + P[0]) * c;
    if ax < ay {
        degrees = 90.0 - degrees;
    }
    if x < 0.0 {
        degrees = 180.0 - degrees;
    }
    if y < 0.0 {
        degrees = 360.0 - degrees;
    }
    degrees * (std::f64::consts::PI / 180.0) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polar_maps_undo_each_other() {
        for log in [false, true] {
            let polar = Polar { center: [20.0, 30.0], radius: 16.0, log };
            let (mut x, mut y) = ([0.0; 48], [0.0; 48]);
            polar.flat([8, 6], &mut x, &mut y).unwrap();
            let (mut back_x, mut back_y) = (vec![0.0; 41 * 61], vec![0.0; 41 * 61]);
            polar.polar([8, 6], [41, 61], &mut back_x, &mut back_y).unwrap();
            // Angle 0: along x, where places of the linear map are whole.
            for i in 1..8 {
                assert_eq!(y[i], 30.0);
                if !log {
                    let at = 30 * 41 + x[i] as usize;
                    assert!((back_x[at] - i as f32).abs() < 1e-5 && (back_y[at] - 1.0).abs() < 1e-5);
                }
            }
            assert!(polar.flat([8, 7], &mut x, &mut y).is_err());
        }
        let worst = (0..3600).map(|i| f64::from(i).to_radians() / 10.0).map(|a| {
            let got = f64::from(angle(a.cos() as f32, a.sin() as f32));
            (got - a).abs().min(std::f64::consts::TAU - (got - a).abs())
        });
        assert!(worst.fold(0.0, f64::max) < 2e-4);
    }
}
