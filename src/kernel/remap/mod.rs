//! Plain interpolation of a picture at given positions, without any minification filter.
//!
//! A run of output pixels is read at positions in pixels of the source, whose pixel centres are at integers.
//! Arithmetic is in `f32` (`f64` for `f64` elements), never fused, in this order:
//!
//! ```text
//! bilinear  l = a + fy (c - a)      a b   upper row
//!           r = b + fy (d - b)      c d   lower row
//!           l + fx (r - l)
//! K x K     v_i = ((wy_0 p_0i + wy_1 p_1i) + wy_2 p_2i) + ...           down each column
//!           p_i = wx_i v_i, then halves are added: p_i + p_(i+K/2), ...  along the row
//! ```
//!
//! Integers are rounded to nearest, ties to even, and saturated. The scalar code defines every bit of this;
//! the vector kernels take blocks of pixels whose taps all lie inside the picture and leave the rest to it.

use super::Isa;
use crate::error::{Error, Result};

mod apron;
#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(target_arch = "x86_64")]
mod block;
mod boxes;
mod coords;
#[cfg(target_arch = "x86_64")]
mod copy;
mod lerp;
mod sample;
mod scalar;
#[cfg(test)]
mod tests;
mod weights;

pub use boxes::{Boxes, Taps, box_numbers, boxes};
pub use coords::{Buffer, CHUNK, Grid};
pub use lerp::{Lerp, Scaled, nearest, within};
pub use sample::{Real, Sample};
pub use weights::{cubic, lanczos};

/// A borrowed picture: `height` rows of `width * channels` elements, `row_stride` elements apart.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a, T> {
    data: &'a [T],
    width: usize,
    height: usize,
    channels: usize,
    row_stride: usize,
}

impl<'a, T> Source<'a, T> {
    /// Checks that the rows fit into the slice.
    ///
    /// # Errors
    /// [`Error::Value`] for an empty picture, sides over 2^30, overlapping rows or a slice that is too short.
    pub fn new(
        data: &'a [T],
        width: usize,
        height: usize,
        channels: usize,
        row_stride: usize,
    ) -> Result<Self> {
        let fits = |row: usize| {
            let needed = row_stride.checked_mul(height - 1)?.checked_add(row)?;
            (row_stride >= row && needed <= data.len() && needed < 1 << 44).then_some(())
        };
        let sane = (1..=1 << 30).contains(&width) && (1..=1 << 30).contains(&height) && channels > 0;
        if !sane || width.checked_mul(channels).and_then(fits).is_none() {
            return Err(Error::value(
                "source",
                format!(
                    "{width} x {height} x {channels} in {} elements, rows {row_stride} apart",
                    data.len()
                ),
                "at least one pixel, sides up to 2^30, and a slice that holds all rows",
            ));
        }
        Ok(Self { data, width, height, channels, row_stride })
    }

    /// Elements a pixel.
    pub fn channels(&self) -> usize {
        self.channels
    }
}

/// What an axis reads beyond its ends; the names are those of the crate's wrap modes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edge {
    /// The border colour.
    Border,
    /// The last pixel goes on.
    Clamp,
    /// Periodic.
    Repeat,
    /// Reversed in every second copy; the last pixel appears twice.
    Mirror,
    /// One reversed copy before the origin, then the last pixel on both sides.
    MirrorOnce,
    /// Reversed in every second copy; the last pixel appears once.
    Mirror101,
}

impl Edge {
    /// The pixel that stands at `i` of an axis of `n` pixels; `None` for the border colour.
    #[inline]
    pub fn index(self, i: i64, n: i64) -> Option<usize> {
        if (0..n).contains(&i) {
            return Some(i as usize);
        }
        let inside = match self {
            Self::Border => return None,
            Self::Clamp => i.clamp(0, n - 1),
            Self::Repeat => i.rem_euclid(n),
            Self::Mirror => {
                let m = i.rem_euclid(2 * n);
                m.min(2 * n - 1 - m)
            }
            Self::MirrorOnce => (if i < 0 { -1 - i } else { i }).min(n - 1),
            Self::Mirror101 if n == 1 => 0,
            Self::Mirror101 => {
                let m = i.rem_euclid(2 * n - 2);
                m.min(2 * n - 2 - m)
            }
        };
        Some(inside as usize)
    }
}

/// How values between pixels are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Interpolation {
    /// The nearest pixel; at equal distances the one of even index.
    Nearest,
    /// Linear in both directions.
    Bilinear,
    /// Cubic convolution with this slope parameter: -0.75, or -0.5 for Catmull-Rom.
    Bicubic(f32),
    /// Lanczos with eight taps an axis.
    Lanczos4,
}

/// What happens to pixels that are read, wholly or in part, beyond a [`Edge::Border`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outside {
    /// Taps there have the border colour.
    Colour,
    /// Taps there have the colour that the output pixel already has.
    Previous,
    /// An output pixel stays as it is where the pixel left of and above its position, or for
    /// [`Interpolation::Nearest`] the nearest one, is there; other taps go on as [`Edge::Clamp`] for
    /// [`Interpolation::Bilinear`], else as [`Edge::Mirror101`].
    Keep,
}

/// Everything but the positions.
#[derive(Clone, Copy, Debug)]
pub struct Job<'a, T> {
    source: Source<'a, T>,
    edges: [Edge; 2],
    border: &'a [T],
    outside: Outside,
    interpolation: Interpolation,
    apron: Option<apron::Apron<'a, T>>,
}

impl<'a, T> Job<'a, T> {
    /// A job whose border colour is `border`, one element a channel. `edges` are those of x and y.
    ///
    /// # Errors
    /// [`Error::Value`] when `border` has another length.
    pub fn new(
        source: Source<'a, T>,
        interpolation: Interpolation,
        edges: [Edge; 2],
        border: &'a [T],
        outside: Outside,
    ) -> Result<Self> {
        if border.len() != source.channels {
            return Err(Error::value("border", format!("{} numbers", border.len()), source.channels));
        }
        Ok(Self { source, edges, border, outside, interpolation, apron: None })
    }

    /// Channels of source and output.
    pub fn channels(&self) -> usize {
        self.source.channels
    }

    /// The way of interpolation.
    pub fn interpolation(&self) -> Interpolation {
        self.interpolation
    }
}

/// Whole pixels and fractions of positions: `x + fx`, `y + fy`. A position that is not finite has
/// [`NOWHERE`] in both.
#[derive(Clone, Copy, Debug)]
pub struct Split<'a, A> {
    /// Column of the pixel at or left of each position.
    pub x: &'a [i32],
    /// Row of the pixel at or above each position.
    pub y: &'a [i32],
    /// Fraction in 0..=1 by which the position is right of that pixel.
    pub fx: &'a [A],
    /// Fraction in 0..=1 by which the position is below that pixel.
    pub fy: &'a [A],
}

/// The pixel of a position that is not finite: it has the border colour for every [`Edge`].
pub const NOWHERE: i32 = i32::MIN;

impl<A> Split<'_, A> {
    /// Positions `start..end`.
    fn part(&self, start: usize, end: usize) -> Self {
        Self {
            x: &self.x[start..end],
            y: &self.y[start..end],
            fx: &self.fx[start..end],
            fy: &self.fy[start..end],
        }
    }
}

/// Part of a row of an output that a matrix maps: pixels (`x0`, `y`), (`x0 + 1`, `y`), ...
#[derive(Clone, Copy, Debug)]
pub struct Row<'a> {
    /// From output pixels to positions, with a division by the third row; see [`Buffer::matrix`].
    pub matrix: &'a [f64; 9],
    /// Column of the first pixel.
    pub x0: f64,
    /// Row of all pixels.
    pub y: f64,
}

/// Where a run of output pixels is read.
#[derive(Clone, Copy, Debug)]
pub enum Points<'a, A> {
    /// Where a matrix says.
    Row(Row<'a>),
    /// Columns and rows as they are.
    Plain(&'a [f32], &'a [f32]),
    /// Taken apart; for [`Interpolation::Nearest`] already rounded.
    Split(Split<'a, A>),
}

/// Reads the source at `points` into `out`, packed.
///
/// # Errors
/// [`Error::Value`] when the numbers of positions and output pixels differ.
pub fn remap<T: Sample>(
    isa: Isa,
    job: &Job<'_, T>,
    points: &Points<'_, T::Acc>,
    out: &mut [T],
) -> Result<()> {
    let count = out.len() / job.source.channels;
    let lengths = match points {
        Points::Row(_) => [count; 4],
        Points::Plain(x, y) => [x.len(), y.len(), count, count],
        Points::Split(s) => [s.x.len(), s.y.len(), s.fx.len(), s.fy.len()],
    };
    if !out.len().is_multiple_of(job.source.channels) || lengths != [count; 4] {
        let got = format!("{} elements for {lengths:?} positions", out.len());
        return Err(Error::value("out", got, "one pixel a position"));
    }
    // The others take positions that are taken apart.
    let direct = matches!(job.interpolation, Interpolation::Bilinear | Interpolation::Nearest);
    if direct && isa != Isa::Scalar && T::vector(isa, job, points, out) {
        return Ok(());
    }
    let grid = if job.interpolation == Interpolation::Nearest { Grid::Whole } else { Grid::Exact };
    let mut buffer: Buffer<_> = Buffer::new();
    for (k, out) in out.chunks_mut(CHUNK * job.source.channels).enumerate() {
        let start = k * CHUNK;
        let n = out.len() / job.source.channels;
        let split = match points {
            Points::Row(row) => buffer.matrix(isa, grid, row.matrix, row.x0 + start as f64, row.y, n),
            Points::Plain(x, y) => buffer.split_f32(isa, grid, &x[start..start + n], &y[start..start + n]),
            Points::Split(split) => split.part(start, start + n),
        };
        if isa == Isa::Scalar || direct || !T::vector(isa, job, &Points::Split(split), out) {
            scalar::run(job, &split, out);
        }
    }
    Ok(())
}

/// Sends a run to the vector kernels of one element type.
macro_rules! vector_dispatch {
    ($name:ident, $type:ty, $run:ident) => {
        fn $name(isa: Isa, job: &Job<'_, $type>, points: &Points<'_, f32>, out: &mut [$type]) -> bool {
            match isa {
                // SAFETY: the machine has the set.
                #[cfg(target_arch = "x86_64")]
                Isa::Avx512 if isa.is_supported() => unsafe { avx512::$run(job, points, out) },
                // SAFETY: the machine has the set.
                #[cfg(target_arch = "x86_64")]
                Isa::Avx2 if isa.is_supported() => unsafe { avx2::$run(job, points, out) },
                _ => false,
            }
        }
    };
}
vector_dispatch!(vector_u8, u8, run_u8);
vector_dispatch!(vector_u16, u16, run_u16);
vector_dispatch!(vector_f32, f32, run_f32);
