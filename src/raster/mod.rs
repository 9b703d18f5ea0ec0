//! Triangles to pixels: clip, snap, visit, interpolate.
//!
//! ```text
//!  clip space (GL)                     picture
//!        y = +w                        (0,0) ------> x (right)
//!          |                             |  +---+---+
//!  x = -w -+- x = +w        --->         |  | . | . |     pixel centres at + 1/2
//!          |                             v  +---+---+
//!        y = -w                          y (down); row 0 is the top, clip y = +w
//! ```
//!
//! A point is visible where `-w <= x, y, z <= w`. Vertices are snapped to 1/256 of a pixel and edges are
//! tested in exact integers with the top-left rule, so a pixel centre on an edge that two triangles share
//! belongs to exactly one of them. What is interpolated later uses the unsnapped vertices.
//!
//! Depth is `z / w`, from -1 (near plane) to 1 (far plane). Of two fragments at the same depth the one of
//! the lower face index is in front, so that every picture and every peeled layer is well defined.

mod bins;
mod clip;
mod interp;
mod setup;
mod visit;

use crate::error::{Error, Result};

pub(crate) use bins::{Banded, Layer, Projected};
pub use interp::Attributes;
pub(crate) use interp::{Pair, Planes, Weights, runs};

/// Longest side of a target, in pixels.
pub const MAX_SIDE: usize = 16_384;

/// Vertices in clip space and the triangles between them: checked once, drawn as often as wanted.
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry {
    positions: Vec<[f64; 4]>,
    faces: Vec<[u32; 3]>,
}

impl Geometry {
    /// Geometry from clip-space positions (x, y, z, w) and vertex indices.
    ///
    /// A triangle with a vertex that is not finite, or with a coordinate beyond 1e60, is never drawn.
    ///
    /// # Errors
    /// [`Error::Value`] when a face names a vertex that is not there, or there are more than 2^31 - 1
    /// vertices or faces.
    pub fn new(positions: Vec<[f64; 4]>, faces: Vec<[u32; 3]>) -> Result<Self> {
        const MOST: usize = i32::MAX as usize;
        if positions.len() > MOST || faces.len() > MOST {
            let got = format!("{} vertices and {} faces", positions.len(), faces.len());
            return Err(Error::value("faces", got, "at most 2^31 - 1 of each"));
        }
        if let Some((i, face)) =
            faces.iter().enumerate().find(|(_, f)| f.iter().any(|&v| v as usize >= positions.len()))
        {
            return Err(Error::value(
                "faces",
                format!("face {i} with vertices {face:?}"),
                format!("indices below the number of vertices, {}", positions.len()),
            ));
        }
        Ok(Self { positions, faces })
    }

    /// The clip-space positions.
    pub fn positions(&self) -> &[[f64; 4]] {
        &self.positions
    }

    /// The triangles.
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// The clip-space corners of a face.
    #[inline(always)]
    fn corners(&self, face: usize) -> [[f64; 4]; 3] {
        self.faces[face].map(|v| self.positions[v as usize])
    }
}

/// Which sides of triangles are left out. The front is where the corners run counter-clockwise in the
/// picture, as in GL and glTF.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Cull<'a> {
    /// Both sides are drawn.
    #[default]
    None,
    /// Only fronts are drawn.
    Back,
    /// Only backs are drawn.
    Front,
    /// Backs are left out of the faces whose entry is true (one entry a face).
    BackOf(&'a [bool]),
}

/// How to draw.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options<'a> {
    /// Which sides are left out.
    pub cull: Cull<'a>,
    /// Sample points of a pixel for [`Fragments::coverage`]: 4, 8 or 16; 0 or 1 for the centre alone.
    pub samples: usize,
    /// Draw only what lies behind these fragments: the next layer of a depth peel.
    pub behind: Option<&'a Fragments>,
}

/// What is seen at each pixel. Rows run down from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Fragments {
    width: usize,
    height: usize,
    triangle: Vec<i32>,
    depth: Vec<f32>,
    coverage: Option<Vec<f32>>,
}

impl Fragments {
    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Index of the nearest face at each pixel, -1 for none.
    pub fn triangle(&self) -> &[i32] {
        &self.triangle
    }

    /// Depth `z / w` of the nearest face at each pixel's centre, +infinity for none.
    pub fn depth(&self) -> &[f32] {
        &self.depth
    }

    /// The same, given away.
    pub fn into_depth(self) -> Vec<f32> {
        self.depth
    }

    /// Share of each pixel's sample points that lie in some triangle, 0..=1. With the centre as the only
    /// sample this is 1 where there is a triangle and 0 elsewhere.
    pub fn coverage(&self) -> Vec<f32> {
        self.coverage
            .clone()
            .unwrap_or_else(|| self.triangle.iter().map(|&t| if t < 0 { 0.0 } else { 1.0 }).collect())
    }
}

/// Draws triangles: for each pixel centre the nearest triangle that covers it.
///
/// With [`Options::samples`] above 1 a pixel whose centre is free but that has a covered sample shows the
/// nearest of the triangles that cover its samples, so that silhouettes can be blended by coverage.
///
/// # Errors
/// [`Error::Value`] for a side of 0 or above [`MAX_SIDE`], another number of samples, a cull mask or a layer
/// of another size; [`Error::Interrupted`] when the caller asked to stop.
///
/// ```
/// use multum::raster::{Geometry, Options, rasterize};
///
/// let corners = vec![[-1.0, -1.0, 0.0, 1.0], [1.0, -1.0, 0.0, 1.0], [-1.0, 1.0, 0.0, 1.0]];
/// let geometry = Geometry::new(corners, vec![[0, 1, 2]]).unwrap();
/// let fragments = rasterize(&geometry, (4, 3), &Options::default()).unwrap();
/// assert_eq!(fragments.triangle()[8..], [0, 0, 0, -1]); // the bottom row
/// ```
pub fn rasterize(geometry: &Geometry, size: (usize, usize), options: &Options<'_>) -> Result<Fragments> {
    let (width, height) = size;
    if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
        return Err(Error::value(
            "size",
            format!("({width}, {height})"),
            format!("sides of 1 to {MAX_SIDE} pixels"),
        ));
    }
    if let Cull::BackOf(mask) = options.cull
        && mask.len() != geometry.faces.len()
    {
        return Err(Error::value(
            "cull",
            format!("{} entries", mask.len()),
            format!("one entry a face, {}", geometry.faces.len()),
        ));
    }
    if let Some(front) = options.behind
        && (front.width, front.height) != size
    {
        return Err(Error::value(
            "behind",
            format!("fragments of ({}, {})", front.width, front.height),
            format!("fragments of the same size, ({width}, {height})"),
        ));
    }
    if !matches!(options.samples, 0 | 1 | 4 | 8 | 16) {
        return Err(Error::value("samples", options.samples, "1, 4, 8 or 16"));
    }
    visit::visit(geometry, size, options)
}
