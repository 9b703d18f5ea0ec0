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

use super::Rows;
use super::maps::{Beyond, Target};
use super::read::{Manner, Pixel, Route, average, read};
use crate::error::{Error, Result};
use crate::image::zeros;
use crate::kernel::{Isa, Work, compiled_for};
use crate::par;
use crate::warp::remap::Map;

/// Output pixels that a thread takes at a time, about.
const BAND: usize = 1 << 14;

/// Places that are computed at a time.
const CHUNK: usize = 256;

/// No tilt.
const UPRIGHT: [f64; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];

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

/// The matrix of a sensor turned by `x` and then `y` radians about its axes: rotation, then projection back onto
/// the plane of the lens.
pub fn tilt(x: f64, y: f64) -> [f64; 9] {
    if x == 0.0 && y == 0.0 {
        return UPRIGHT;
    }
    let ((sx, cx), (sy, cy)) = (x.sin_cos(), y.sin_cos());
    let r = [[cy, sy * sx, -sy * cx], [0.0, cx, sx], [sy, -cy * sx, cy * cx]];
    let c = r[2];
    let row = |k: usize| [0, 1, 2].map(|i| c[2] * r[k][i] - r[k][2] * c[i]);
    let ([a0, a1, a2], [b0, b1, b2]) = (row(0), row(1));
    [a0, a1, a2, b0, b1, b2, c[0], c[1], c[2]]
}

/// Where a point of the plane of the lens is seen.
trait Bend {
    /// Whether what lies behind the camera is infinitely far away.
    const SEES_BEHIND: bool;
    fn bend(&self, x: f64, y: f64) -> (f64, f64);
}

/// The standard lens before an upright sensor.
struct Upright([f64; 12]);

/// The standard lens before a tilted sensor.
struct Tilted([f64; 12], [f64; 9]);

/// A fisheye.
struct Fisheye([f64; 4]);

impl Bend for Upright {
    const SEES_BEHIND: bool = false;
    #[inline(always)]
    fn bend(&self, x: f64, y: f64) -> (f64, f64) {
        let [k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4] = self.0;
        let (x2, y2, xy2) = (x * x, y * y, 2.0 * x * y);
        let r2 = x2 + y2;
        let k = (1.0 + ((k3 * r2 + k2) * r2 + k1) * r2) / (1.0 + ((k6 * r2 + k5) * r2 + k4) * r2);
        let u = x * k + p1 * xy2 + p2 * (r2 + 2.0 * x2) + s1 * r2 + s2 * r2 * r2;
        let v = y * k + p1 * (r2 + 2.0 * y2) + p2 * xy2 + s3 * r2 + s4 * r2 * r2;
        (u, v)
    }
}

impl Bend for Tilted {
    const SEES_BEHIND: bool = false;
    #[inline(always)]
    fn bend(&self, x: f64, y: f64) -> (f64, f64) {
        let ((u, v), t) = (Upright(self.0).bend(x, y), &self.1);
        let w = t[6] * u + t[7] * v + t[8];
        let w = if w == 0.0 { 1.0 } else { 1.0 / w };
        (w * (t[0] * u + t[1] * v + t[2]), w * (t[3] * u + t[4] * v + t[5]))
    }
}

impl Bend for Fisheye {
    const SEES_BEHIND: bool = true;
    #[inline(always)]
    fn bend(&self, x: f64, y: f64) -> (f64, f64) {
        let [k1, k2, k3, k4] = self.0;
        let r = (x * x + y * y).sqrt();
        let t = r.atan();
        let t2 = t * t;
        let bent = t * (1.0 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4))));
        let scale = if r == 0.0 { 1.0 } else { bent / r };
        (x * scale, y * scale)
    }
}

/// Places of the pixels of a row from `pixel` on, written to a target; to be compiled for an instruction set.
struct Run<'a, 't> {
    camera: &'a Camera,
    pixel: [usize; 2],
    places: [&'a mut [f64]; 2],
    at: usize,
    target: &'a mut Target<'t>,
}

impl Work for Run<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { camera, pixel: [first, row], places: [xs, ys], at, target } = self;
        // One loop a kind of lens, so that none tests it for every pixel.
        match camera.lens {
            Lens::Standard(k, t) if t == UPRIGHT => camera.places(&Upright(k), row, first, xs, ys),
            Lens::Standard(k, t) => camera.places(&Tilted(k, t), row, first, xs, ys),
            Lens::Fisheye(k) => camera.places(&Fisheye(k), row, first, xs, ys),
        }
        target.write(at, xs, ys, Beyond::Wrap);
    }
}

impl Camera {
    /// Places of the pixels of a row from `first` on.
    #[inline(always)]
    fn places<B: Bend>(&self, lens: &B, row: usize, first: usize, xs: &mut [f64], ys: &mut [f64]) {
        let m = &self.inverse;
        let y = row as f64;
        let [a0, b0, w0] = [0, 3, 6].map(|k| m[k + 1] * y + m[k + 2]);
        for (i, (px, py)) in xs.iter_mut().zip(ys).enumerate() {
            // Whole numbers of 32 bits become doubles in one step.
            let x = f64::from(first as i32 + i as i32);
            let (a, b, w) = (m[0] * x + a0, m[3] * x + b0, m[6] * x + w0);
            let (bx, by) = lens.bend(a / w, b / w);
            (*px, *py) = (self.focal[0] * bx + self.center[0], self.focal[1] * by + self.center[1]);
            if B::SEES_BEHIND && w <= 0.0 {
                // Behind the camera.
                let side = |v: f64| if v > 0.0 { f64::NEG_INFINITY } else { f64::INFINITY };
                (*px, *py) = (side(a), side(b));
            }
        }
    }

    /// Fills a map of `width` pixels a row.
    ///
    /// # Errors
    /// [`Error::Value`] for a target whose parts do not fit; [`Error::Interrupted`].
    pub fn fill(&self, width: usize, target: Target<'_>) -> Result<()> {
        let len = target.count()?;
        if len == 0 || width == 0 || !len.is_multiple_of(width) {
            return Err(Error::value("map", format!("{len} places"), format!("rows of {width}")));
        }
        let isa = Isa::current();
        let rows = (BAND / width).max(1);
        if len <= rows * width {
            self.rows(isa, 0, width, target);
            return Ok(());
        }
        par::for_each(target.bands(rows * width).into_iter(), |i, band| {
            self.rows(isa, i * rows, width, band);
            Ok(())
        })
    }

    /// Rows of a map from `row` on.
    fn rows(&self, isa: Isa, row: usize, width: usize, mut target: Target<'_>) {
        let (mut xs, mut ys) = ([0.0; CHUNK], [0.0; CHUNK]);
        let rows = target.count().unwrap_or(0) / width;
        for y in 0..rows {
            for first in (0..width).step_by(CHUNK) {
                let n = (width - first).min(CHUNK);
                let places = [&mut xs[..n], &mut ys[..n]];
                let at = y * width + first;
                let target = &mut target;
                compiled_for(isa, Run { camera: self, pixel: [first, row + y], places, at, target });
            }
        }
    }

    /// Fills `out`, a picture of the source's size, with what the camera sees: linear between pixels at positions rounded
    /// to 1/32, as `initUndistortRectifyMap` and `remap` do, row by row, so that no map is kept. Black lies outside.
    ///
    /// # Errors
    /// [`Error::Value`] for an `out` of another size; [`Error::Interrupted`].
    pub fn undistort<T: Pixel>(&self, source: &Rows<'_, T>, antialias: bool, out: &mut [T]) -> Result<()> {
        let (width, channels) = (source.width, source.channels);
        let row = width * channels;
        if out.len() != row * source.height {
            let expected = format!("{width} x {} x {channels}", source.height);
            return Err(Error::value("dst", format!("{} elements", out.len()), expected));
        }
        let isa = Isa::current();
        let black = vec![T::default(); channels];
        const CONSTANT: i32 = 0;
        let manner = Manner::new(1, CONSTANT, Route::Map, false)?;
        let rows = (BAND / width).max(1);
        let work = |i: usize, out: &mut [T]| {
            let pixels = out.len() / channels;
            let (mut pairs, mut codes) = (vec![0; 2 * pixels], vec![0; pixels]);
            self.rows(isa, i * rows, width, Target::Fixed(&mut pairs, Some(&mut codes)));
            read(source, &Map::Fixed(&pairs, Some(&codes)), &manner, &black, width, out)
        };
        par::for_each(out.chunks_mut(rows * row), work)?;
        if !antialias {
            return Ok(());
        }
        // Footprints are those of the positions before they are rounded.
        let pixels = width * source.height;
        let (mut x, mut y) = (zeros::<f32>("src", pixels)?, zeros::<f32>("src", pixels)?);
        self.fill(width, Target::Planes(&mut x, &mut y))?;
        average(source, &Map::Single(&x, &y), &Manner { antialias, ..manner }, &black, width, out)
    }
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
        camera.fill(200, Target::Fixed(&mut pairs, Some(&mut codes))).unwrap();
        for i in 0..x.len() {
            let (j, k) = ((i % 200) as f32, (i / 200) as f32);
            assert!((x[i] - j).abs() < 1e-4 && (y[i] - k).abs() < 1e-4);
            assert_eq!((f32::from(pairs[2 * i]), f32::from(pairs[2 * i + 1]), codes[i]), (j, k, 0));
        }
        assert!(camera.fill(200, Target::Planes(&mut x, &mut y[1..])).is_err());
        assert!(camera.fill(200, Target::Fixed(&mut pairs, Some(&mut codes[1..]))).is_err());
    }

    #[test]
    fn pictures_are_read_at_the_places_of_the_map_on_every_instruction_set_and_thread_count() {
        let (w, h) = (150, 130);
        let data: Vec<u8> = (0..w * h * 3).map(|i| (i * 7919 % 251) as u8).collect();
        let source = Rows::new(&data, w, h, 3, w * 3).unwrap();
        let numbers = [-0.2, 0.05, 0.01, -0.01, 0.02, 0.01, 0.0, 0.0, 0.001, 0.0, 0.0, 0.002];
        let inverse = [0.01, 0.001, -0.8, 0.0, 0.012, -0.7, 0.0, 0.0, 1.0];
        for lens in [Lens::Standard(numbers, tilt(0.1, 0.05)), Lens::Fisheye([0.1, 0.02, 0.0, 0.0])] {
            let camera = Camera { focal: [90.0, 95.0], center: [70.0, 66.0], lens, inverse };
            let (mut pairs, mut codes) = (vec![0; 2 * w * h], vec![0; w * h]);
            camera.fill(w, Target::Fixed(&mut pairs, Some(&mut codes))).unwrap();
            let manner = Manner::new(1, 0, Route::Map, false).unwrap();
            let mut want = vec![0; data.len()];
            read(&source, &Map::Fixed(&pairs, Some(&codes)), &manner, &[0; 3], w, &mut want).unwrap();
            for isa in Isa::available() {
                for threads in [1, 3] {
                    let mut out = vec![9; data.len()];
                    let run = || crate::kernel::with_isa(isa, || camera.undistort(&source, false, &mut out));
                    par::with_threads(Some(threads), run).unwrap().unwrap();
                    assert!(out == want, "{isa:?}");
                }
            }
            assert!(camera.undistort(&source, true, &mut want[3..]).is_err());
        }
    }

    #[test]
    fn a_tilt_keeps_the_axis_and_is_a_homography_of_the_rotation() {
        let t = tilt(0.3, -0.2);
        // The optical axis meets the tilted sensor at its origin.
        assert!(t[2].abs() < 1e-15 && t[5].abs() < 1e-15 && t[8] > 0.0);
        assert_eq!(tilt(0.0, 0.0), [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    }
}
