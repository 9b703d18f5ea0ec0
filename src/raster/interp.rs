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
struct Planes {
    a: [f64; 3],
    da: [[f64; 2]; 3],
    sum_da: [f64; 2],
    x: f64,
}

impl Planes {
    /// About the centre of pixel (x, y): moved there first, so that small triangles do not cancel.
    fn new(corners: [[f64; 4]; 3], x: usize, y: usize, size: [f64; 2]) -> Self {
        let (px, py) = (2.0 / size[0], -2.0 / size[1]);
        let (cx, cy) = ((x as f64 + 0.5) * px - 1.0, (y as f64 + 0.5) * py + 1.0);
        let moved = corners.map(|[x, y, _, w]| [x - cx * w, y - cy * w, w]);
        let mut planes = Self { a: [0.0; 3], da: [[0.0; 2]; 3], sum_da: [0.0; 2], x: x as f64 };
        for i in 0..3 {
            let ([xj, yj, wj], [xk, yk, wk]) = (moved[(i + 1) % 3], moved[(i + 2) % 3]);
            planes.a[i] = xj * yk - xk * yj;
            planes.da[i] = [(wk * yj - wj * yk) * px, (xk * wj - xj * wk) * py];
        }
        planes.sum_da = std::array::from_fn(|j| planes.da[0][j] + planes.da[1][j] + planes.da[2][j]);
        planes
    }

    /// Weights at another pixel of the same row.
    #[inline(always)]
    fn at(&self, x: usize) -> Weights {
        let step = x as f64 - self.x;
        let a: [f64; 3] = std::array::from_fn(|i| self.a[i] + step * self.da[i][0]);
        let inverse = 1.0 / (a[0] + a[1] + a[2]);
        let b = a.map(|a| a * inverse);
        if !(b[0].abs() + b[1].abs() + b[2].abs()).is_finite() {
            // A triangle seen exactly edge-on: it has no inside, and every weight is as good.
            return Weights { b: [1.0 / 3.0; 3], db: [[0.0; 2]; 2] };
        }
        let db = std::array::from_fn(|i| {
            std::array::from_fn(|j| (self.da[i + 1][j] - b[i + 1] * self.sum_da[j]) * inverse)
        });
        Weights { b: inside(b), db }
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
    pub(crate) fn walk(
        &self,
        geometry: &Geometry,
        rows: std::ops::Range<usize>,
        mut work: impl FnMut(usize, usize, &Weights),
    ) -> Result<()> {
        let (size, faces) = ([self.width as f64, self.height as f64], geometry.faces().len());
        for (row, y) in rows.enumerate() {
            let mut current = (-1, None);
            for (x, &id) in self.triangle[y * self.width..][..self.width].iter().enumerate() {
                let Ok(face) = usize::try_from(id) else { continue };
                if face >= faces {
                    return Err(Error::value(
                        "geometry",
                        format!("{faces} faces"),
                        format!("the geometry that was drawn, with a face {face}"),
                    ));
                }
                if current.0 != id || current.1.is_none() {
                    current = (id, Some(Planes::new(geometry.corners(face), x, y, size)));
                }
                if let Some(planes) = &current.1 {
                    work(row * self.width + x, face, &planes.at(x));
                }
            }
        }
        Ok(())
    }
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
