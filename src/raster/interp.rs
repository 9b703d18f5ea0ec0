//! Perspective-correct attributes and their exact screen derivatives.
//!
//! With clip-space corners (x_i, y_i, w_i) and a pixel's place (X, Y) in [-1, 1]², the values
//! `a_i = (x_j - X w_j)(y_k - Y w_k) - (x_k - X w_k)(y_j - Y w_j)`, (i, j, k) cyclic, are linear in X and Y and
//! in the ratio of the perspective-correct weights, on any side of the eye and without clipping:
//!
//! ```text
//! b_i = a_i / Σa        ∂b_i = (∂a_i - b_i Σ∂a) / Σa
//! ```
//!
//! Olano and Greer, "Triangle scan conversion using 2D homogeneous coordinates", Graphics Hardware 1997.

use super::visit::{filled, zeros};
use super::{Fragments, Geometry};
use crate::error::{Error, Result};
use crate::par;
use crate::texel::Texel;
use std::ops::Range;

/// Pixels that a thread takes at a time: whole rows, about this many pixels.
const CHUNK_PX: usize = 1 << 14;

/// Numbers to interpolate over triangles.
#[derive(Clone, Copy, Debug)]
pub enum Attributes<'a, T> {
    /// `channels` numbers a vertex.
    Vertex {
        /// The numbers, vertex by vertex.
        data: &'a [T],
        /// Numbers of a vertex.
        channels: usize,
    },
    /// `channels` numbers a corner: those of a face's corners 0, 1 and 2, face by face.
    Corner {
        /// The numbers, corner by corner.
        data: &'a [T],
        /// Numbers of a corner.
        channels: usize,
    },
}

impl<'a, T> Attributes<'a, T> {
    fn check(&self, geometry: &Geometry) -> Result<usize> {
        let (data, channels, rows, word) = match self {
            Self::Vertex { data, channels } => (data, *channels, geometry.positions().len(), "vertices"),
            Self::Corner { data, channels } => (data, *channels, geometry.faces().len() * 3, "corners"),
        };
        if channels == 0 || Some(data.len()) != rows.checked_mul(channels) {
            return Err(Error::value(
                "attributes",
                format!("{} numbers in rows of {channels}", data.len()),
                format!("at least one number for each of the {rows} {word}"),
            ));
        }
        Ok(channels)
    }

    #[inline(always)]
    fn corners(&self, geometry: &Geometry, face: usize) -> [&'a [T]; 3] {
        match *self {
            Self::Vertex { data, channels } => {
                geometry.faces()[face].map(|v| &data[v as usize * channels..][..channels])
            }
            Self::Corner { data, channels } => {
                std::array::from_fn(|i| &data[(face * 3 + i) * channels..][..channels])
            }
        }
    }
}

/// Weights of a pixel's triangle and what follows from them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weights {
    /// Weights of corners 0, 1, 2: not negative, sum 1.
    pub b: [f64; 3],
    /// Derivatives of weights 1 and 2 by x (one pixel right) and y (one pixel down).
    pub db: [[f64; 2]; 2],
}

/// The functions a_i of one triangle, about one pixel, in steps of pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Planes {
    a: [f64; 3],
    /// Derivatives by x and by y.
    da: [[f64; 3]; 2],
    sum_da: [f64; 2],
    pixel: [f64; 2],
}

/// A pair of numbers, such as u and v, over a triangle: a_1 e_1 + a_2 e_2 for its differences e from corner 0, which is
/// linear as the a_i are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair {
    corner: [f64; 2],
    at: [f64; 2],
    /// Derivatives by x and by y.
    step: [[f64; 2]; 2],
}

impl Planes {
    /// Of a face of `geometry` in a picture of `size`, about the centre of pixel (x, y): moved there first, so that small
    /// triangles do not cancel.
    #[inline(always)]
    pub(crate) fn of(geometry: &Geometry, face: usize, [x, y]: [usize; 2], size: (usize, usize)) -> Self {
        Self::new(geometry.corners(face), [x, y], size)
    }

    #[inline(always)]
    fn new(corners: [[f64; 4]; 3], [x, y]: [usize; 2], (width, height): (usize, usize)) -> Self {
        let pixel = [x as f64, y as f64];
        let (px, py) = (2.0 / width as f64, -2.0 / height as f64);
        let (cx, cy) = ((pixel[0] + 0.5) * px - 1.0, (pixel[1] + 0.5) * py + 1.0);
        let moved = |[x, y, _, w]: [f64; 4]| [x - cx * w, y - cy * w, w];
        let moved = [moved(corners[0]), moved(corners[1]), moved(corners[2])];
        let mut planes = Self { a: [0.0; 3], da: [[0.0; 3]; 2], sum_da: [0.0; 2], pixel };
        for i in 0..3 {
            let ([xj, yj, wj], [xk, yk, wk]) = (moved[(i + 1) % 3], moved[(i + 2) % 3]);
            planes.a[i] = xj * yk - xk * yj;
            planes.da[0][i] = (wk * yj - wj * yk) * px;
            planes.da[1][i] = (xk * wj - xj * wk) * py;
        }
        planes.sum_da = planes.da.map(|[a, b, c]| a + b + c);
        planes
    }

    /// The a_i at a pixel.
    #[inline(always)]
    fn a(&self, x: usize, y: usize) -> [f64; 3] {
        let [n, m] = [x as f64 - self.pixel[0], y as f64 - self.pixel[1]];
        std::array::from_fn(|i| self.a[i] + m * self.da[1][i] + n * self.da[0][i])
    }

    /// Weights at a pixel.
    #[inline(always)]
    pub(crate) fn at(&self, x: usize, y: usize) -> Weights {
        let a = self.a(x, y);
        let inverse = 1.0 / (a[0] + a[1] + a[2]);
        let b = a.map(|a| a * inverse);
        if !(b[0].abs() + b[1].abs() + b[2].abs()).is_finite() {
            // A triangle seen exactly edge-on: it has no inside, and every weight is as good.
            return Weights { b: [1.0 / 3.0; 3], db: [[0.0; 2]; 2] };
        }
        let db = std::array::from_fn(|i| {
            std::array::from_fn(|j| (self.da[j][i + 1] - b[i + 1] * self.sum_da[j]) * inverse)
        });
        Weights { b: inside(b), db }
    }

    /// A pair of numbers over the triangle, given those of its corners.
    #[inline(always)]
    pub(crate) fn pair(&self, [v0, v1, v2]: [[f64; 2]; 3]) -> Pair {
        let (e1, e2) = ([v1[0] - v0[0], v1[1] - v0[1]], [v2[0] - v0[0], v2[1] - v0[1]]);
        let sum = |[_, a1, a2]: [f64; 3]| [a1 * e1[0] + a2 * e2[0], a1 * e1[1] + a2 * e2[1]];
        Pair { corner: v0, at: sum(self.a), step: self.da.map(sum) }
    }

    /// The values and derivatives of a pair at the pixels `x` of row `y`: two and four numbers a pixel. `corners` are those
    /// that `pair` was made of.
    #[inline(always)]
    pub(crate) fn fill(
        &self,
        pair: &Pair,
        corners: impl FnOnce() -> [[f64; 2]; 3],
        x: Range<usize>,
        y: usize,
        out: &mut [[f64; 2]],
        jacobian: &mut [[f64; 4]],
    ) {
        if !self.hold(&x, y) {
            let [v0, v1, v2] = corners();
            for ((x, out), jacobian) in x.zip(out).zip(jacobian) {
                let Weights { b, db: [d1, d2] } = self.at(x, y);
                let mix = |w1: f64, w2: f64, k: usize| w1 * (v1[k] - v0[k]) + w2 * (v2[k] - v0[k]);
                *out = [0, 1].map(|k| v0[k] + mix(b[1], b[2], k));
                *jacobian = std::array::from_fn(|k| mix(d1[k % 2], d2[k % 2], k / 2));
            }
            return;
        }
        // One division a pixel.
        let (m, first) = (y as f64 - self.pixel[1], x.start as f64 - self.pixel[0]);
        let sum = self.a[0] + self.a[1] + self.a[2] + m * self.sum_da[1];
        let at = [0, 1].map(|k| pair.at[k] + m * pair.step[1][k]);
        for (i, (out, jacobian)) in out.iter_mut().zip(jacobian).enumerate() {
            let n = first + i as u32 as f64;
            let inverse = 1.0 / (sum + n * self.sum_da[0]);
            let [u, v] = [0, 1].map(|k| (at[k] + n * pair.step[0][k]) * inverse);
            *out = [pair.corner[0] + u, pair.corner[1] + v];
            *jacobian = [
                (pair.step[0][0] - u * self.sum_da[0]) * inverse,
                (pair.step[1][0] - u * self.sum_da[1]) * inverse,
                (pair.step[0][1] - v * self.sum_da[0]) * inverse,
                (pair.step[1][1] - v * self.sum_da[1]) * inverse,
            ];
        }
    }

    /// Whether all weights are positive numbers, none of them cut off, at the pixels `x` of row `y`: the a_i have one sign at
    /// the first and the last of them, and so they have between.
    #[inline(always)]
    fn hold(&self, x: &Range<usize>, y: usize) -> bool {
        if x.is_empty() {
            return false;
        }
        let first = self.sign(x.start, y);
        first != 0.0 && (x.len() == 1 || self.sign(x.end - 1, y) == first)
    }

    /// The sign that all a_i at a pixel have; 0 where they have not, or where nothing can be divided by their sum.
    #[inline(always)]
    fn sign(&self, x: usize, y: usize) -> f64 {
        let a = self.a(x, y);
        let sum = a[0] + a[1] + a[2];
        let all = |sign: f64| a.iter().all(|a| sign * a >= 0.0) && sign * sum >= f64::MIN_POSITIVE;
        match sum.is_finite() {
            true if all(1.0) => 1.0,
            true if all(-1.0) => -1.0,
            _ => 0.0,
        }
    }
}

/// Vertices are snapped for coverage but not here, so a pixel's centre may lie up to 1/256 pixel outside.
#[inline(always)]
fn inside(b: [f64; 3]) -> [f64; 3] {
    if b[0] >= 0.0 && b[1] >= 0.0 && b[2] >= 0.0 {
        return b;
    }
    let clamped = b.map(|b| b.max(0.0));
    let sum: f64 = clamped.iter().sum();
    clamped.map(|b| b / sum)
}

impl Fragments {
    /// Perspective-correct weights of corners 0, 1 and 2 at each pixel's centre, zeros where there is no
    /// triangle. `geometry` is the one that was drawn.
    ///
    /// # Errors
    /// [`Error::Value`] when the fragments name faces that `geometry` does not have.
    pub fn barycentric(&self, geometry: &Geometry) -> Result<Vec<[f32; 3]>> {
        let mut out = zeros::<[f32; 3]>(self.width * self.height)?;
        self.for_rows(geometry, out.chunks_mut(self.rows_at_a_time() * self.width), |out, p, _, weights| {
            out[p] = weights.b.map(|b| b as f32);
        })?;
        Ok(out)
    }

    /// Attributes at each pixel's centre, perspective-correct, and where there is no triangle `fill`:
    /// `channels` numbers a pixel, row by row.
    ///
    /// A constant comes out exactly.
    ///
    /// # Errors
    /// [`Error::Value`] when the numbers do not fit `geometry`, or the fragments are not of `geometry`.
    pub fn interpolate<T: Texel>(
        &self,
        geometry: &Geometry,
        attributes: Attributes<'_, T>,
        fill: T,
    ) -> Result<Vec<T>> {
        let channels = attributes.check(geometry)?;
        let mut values = background(self.elements(channels)?, fill)?;
        let tiles = values.chunks_mut(self.rows_at_a_time() * self.width * channels);
        self.for_rows(geometry, tiles, |out, p, face, weights| {
            blend(attributes.corners(geometry, face), weights, &mut out[p * channels..][..channels]);
        })?;
        Ok(values)
    }

    /// As [`Fragments::interpolate`], with the derivatives of each number by x (one pixel right) and y (one
    /// pixel down): `channels` pairs a pixel, zeros where there is no triangle.
    ///
    /// The derivatives are those of the triangle's plane, exact even where it covers a single pixel.
    ///
    /// # Errors
    /// As [`Fragments::interpolate`].
    ///
    /// ```
    /// use multum::raster::{Attributes, Geometry, Options, rasterize};
    ///
    /// let corners = vec![[-1.0, -1.0, 0.0, 1.0], [3.0, -1.0, 0.0, 1.0], [-1.0, 3.0, 0.0, 1.0]];
    /// let geometry = Geometry::new(corners, vec![[0, 1, 2]]).unwrap();
    /// let fragments = rasterize(&geometry, (4, 4), &Options::default()).unwrap();
    /// // u grows by 1 over the picture's width, v by 1 over its height, downwards.
    /// let uv = Attributes::Vertex { data: &[0.0f32, 1.0, 2.0, 1.0, 0.0, -1.0], channels: 2 };
    /// let (value, jacobian) = fragments.interpolate_with_derivatives(&geometry, uv, 0.0).unwrap();
    /// assert_eq!(value[..2], [0.125, 0.125]);
    /// assert_eq!(jacobian[0], [0.25, 0.0]);
    /// assert_eq!(jacobian[1], [0.0, 0.25]);
    /// ```
    pub fn interpolate_with_derivatives<T: Texel>(
        &self,
        geometry: &Geometry,
        attributes: Attributes<'_, T>,
        fill: T,
    ) -> Result<(Vec<T>, Vec<[T; 2]>)> {
        let channels = attributes.check(geometry)?;
        let elements = self.elements(channels)?;
        let mut values = background(elements, fill)?;
        let mut derivatives = zeros::<[T; 2]>(elements)?;
        let chunk = self.rows_at_a_time() * self.width * channels;
        let tiles = values.chunks_mut(chunk).zip(derivatives.chunks_mut(chunk));
        self.for_rows(geometry, tiles, |(values, derivatives), p, face, weights| {
            let corners = attributes.corners(geometry, face);
            blend(corners, weights, &mut values[p * channels..][..channels]);
            let [d1, d2] = weights.db;
            for (c, out) in derivatives[p * channels..][..channels].iter_mut().enumerate() {
                let [v0, v1, v2] = corners.map(|corner| corner[c].to_f64());
                *out = std::array::from_fn(|j| T::from_f64(d1[j] * (v1 - v0) + d2[j] * (v2 - v0)));
            }
        })?;
        Ok((values, derivatives))
    }

    fn elements(&self, channels: usize) -> Result<usize> {
        (self.width * self.height).checked_mul(channels).ok_or_else(|| {
            Error::value(
                "attributes",
                format!("{channels} numbers a vertex"),
                "an output that fits in memory",
            )
        })
    }

    fn rows_at_a_time(&self) -> usize {
        (CHUNK_PX / self.width).max(1)
    }

    /// Calls `work(tile, pixel in tile, face, weights)` for every pixel that shows a triangle. A tile is
    /// [`Fragments::rows_at_a_time`] rows.
    fn for_rows<B: Send>(
        &self,
        geometry: &Geometry,
        tiles: impl ExactSizeIterator<Item = B> + Send,
        work: impl Fn(&mut B, usize, usize, &Weights) + Sync,
    ) -> Result<()> {
        let rows = self.rows_at_a_time();
        par::for_each(tiles, |i, mut tile| {
            let own = i * rows..((i + 1) * rows).min(self.height);
            self.walk(geometry, own, |p, face, weights| work(&mut tile, p, face, weights))
        })
    }

    /// Calls `work(pixel counted from the first of these rows, face, weights)` for every pixel of the rows that
    /// shows a triangle.
    fn walk(
        &self,
        geometry: &Geometry,
        rows: Range<usize>,
        mut work: impl FnMut(usize, usize, &Weights),
    ) -> Result<()> {
        let (size, faces) = ((self.width, self.height), geometry.faces().len());
        for (row, y) in rows.enumerate() {
            runs(self.row(y), |pixels, face| {
                if face >= faces {
                    return Err(Error::value(
                        "geometry",
                        format!("{faces} faces"),
                        format!("the geometry that was drawn, with a face {face}"),
                    ));
                }
                let planes = Planes::of(geometry, face, [pixels.start, y], size);
                for x in pixels {
                    work(row * self.width + x, face, &planes.at(x, y));
                }
                Ok(())
            })?;
        }
        Ok(())
    }

    /// Faces along a row.
    pub(crate) fn row(&self, y: usize) -> &[i32] {
        &self.triangle[y * self.width..][..self.width]
    }
}

/// Calls `work(pixels, face)` for every run of pixels of a row that shows one triangle; `row` holds faces, -1 for none.
///
/// # Errors
/// Those of `work`.
#[inline(always)]
pub(crate) fn runs(row: &[i32], mut work: impl FnMut(Range<usize>, usize) -> Result<()>) -> Result<()> {
    let mut x = 0;
    while x < row.len() {
        let (id, first) = (row[x], x);
        x += row[first..].iter().take_while(|&&other| other == id).count();
        if let Ok(face) = usize::try_from(id) {
            work(first..x, face)?;
        }
    }
    Ok(())
}

fn background<T: Texel>(len: usize, fill: T) -> Result<Vec<T>> {
    if fill == T::default() { zeros(len) } else { filled(len, fill) }
}

#[inline(always)]
fn blend<T: Texel>([c0, c1, c2]: [&[T]; 3], weights: &Weights, out: &mut [T]) {
    let [_, b1, b2] = weights.b;
    for (((out, v0), v1), v2) in out.iter_mut().zip(c0).zip(c1).zip(c2) {
        let (v0, v1, v2) = (v0.to_f64(), v1.to_f64(), v2.to_f64());
        *out = T::from_f64(v0 + b1 * (v1 - v0) + b2 * (v2 - v0));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs of pixels, one division each, against the weights of each pixel.
    #[test]
    fn pairs_are_those_of_the_weights() {
        let mut state = 3u64;
        let mut random = |low: f64, high: f64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            low + (state >> 11) as f64 / (1u64 << 53) as f64 * (high - low)
        };
        let (mut quick, mut cut) = (0, 0);
        for _ in 0..2000 {
            let corners: [[f64; 4]; 3] = std::array::from_fn(|_| {
                let w = random(-0.3, 3.0);
                [random(-1.5, 1.5) * w, random(-1.5, 1.5) * w, 0.0, w]
            });
            let pairs: [[f64; 2]; 3] = std::array::from_fn(|_| [random(-2.0, 2.0), random(0.0, 1.0)]);
            let (first, count) = (random(0.0, 30.0) as usize, 1 + random(0.0, 9.0) as usize);
            let (x, y) = (first..first + count, random(0.0, 30.0) as usize);
            let about = [random(0.0, 30.0) as usize, random(0.0, 30.0) as usize];
            let planes = Planes::new(corners, about, (40, 30));
            let (mut got, mut jacobian) = (vec![[0.0; 2]; count], vec![[0.0; 4]; count]);
            planes.fill(&planes.pair(pairs), || pairs, x.clone(), y, &mut got, &mut jacobian);
            let inner = planes.hold(&x, y);
            (quick, cut) = (quick + usize::from(inner), cut + usize::from(!inner));
            for ((x, got), jacobian) in x.zip(got).zip(jacobian) {
                let Weights { b, db } = planes.at(x, y);
                for k in 0..2 {
                    let value: f64 = (0..3).map(|i| b[i] * pairs[i][k]).sum();
                    assert!((got[k] - value).abs() < 1e-9, "{got:?} {value}");
                    for j in 0..2 {
                        let slope =
                            db[0][j] * (pairs[1][k] - pairs[0][k]) + db[1][j] * (pairs[2][k] - pairs[0][k]);
                        assert!(
                            (jacobian[2 * k + j] - slope).abs()
                                < 1e-9 * (1.0 + slope.abs()) * (1.0 + slope.abs())
                        );
                    }
                }
            }
        }
        assert!(quick > 100 && cut > 100, "{quick} {cut}");
    }
}
