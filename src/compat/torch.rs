//! PyTorch's `grid_sample` for images: positions from -1 to 1, in the arithmetic of their own type.
//!
//! ```text
//! corners are edges    x = (u + 1) W/2 - 1/2        -1 and 1 are the outer edges of the outermost pixels
//! corners are pixels   x = (u + 1) (W - 1)/2        they are their centres
//! ```

use crate::error::{Error, Result};
use crate::image::zeros;
use crate::kernel::remap::{Edge, Interpolation, Job, Outside, Real, Sample, Source};
use crate::kernel::{Isa, Work, compiled_for};
use crate::par;
use crate::warp::remap::{Grid, Map, interpolate};
use half::f16;

/// Positions that a thread takes at a time.
const BAND: usize = 1 << 15;

/// Planes that are read together.
const GROUP: usize = 4;

/// What lies outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Padding {
    /// Zeros.
    Zeros,
    /// The outermost pixel.
    Border,
    /// The picture, reflected about the outermost edges, or centres where these are the corners.
    Reflection,
}

/// How a grid is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Manner {
    /// Between pixels.
    pub interpolation: Interpolation,
    /// Outside.
    pub padding: Padding,
    /// Whether -1 and 1 are centres of pixels.
    pub align_corners: bool,
}

/// Pictures of one size, one after the other: planes of one channel, or one whose channels are side by side.
#[derive(Clone, Copy, Debug)]
pub struct Planes<'a, T> {
    /// All their numbers.
    pub data: &'a [T],
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Numbers in a pixel.
    pub channels: usize,
}

/// An element of images and grids.
pub trait Float: Sample {
    /// What positions are computed in.
    type Position: Real;
    /// A number of a grid.
    fn position(self) -> Self::Position;
    /// Not a number.
    const NAN: Self;
    /// Positions as a map.
    fn map<'a>(x: &'a [Self::Position], y: &'a [Self::Position]) -> Map<'a>;
}

macro_rules! float {
    ($t:ty, $position:ty, $map:ident, |$x:ident| $wide:expr) => {
        impl Float for $t {
            type Position = $position;
            const NAN: Self = <$t>::NAN;
            #[inline(always)]
            fn position(self) -> $position {
                let $x = self;
                $wide
            }
            fn map<'a>(x: &'a [$position], y: &'a [$position]) -> Map<'a> {
                Map::$map(x, y)
            }
        }
    };
}
float!(f16, f32, Single, |x| x.to_f32());
float!(f32, f32, Single, |x| x);
float!(f64, f64, Double, |x| x);

impl Manner {
    /// From a grid's number along an axis of `size` pixels to pixels: factor and what is taken away.
    fn scale(&self, size: usize) -> [f64; 2] {
        if self.align_corners { [(size as f64 - 1.0) / 2.0, 0.0] } else { [size as f64 / 2.0, 0.5] }
    }

    fn edge(&self) -> Edge {
        match (self.padding, self.align_corners) {
            (Padding::Zeros, _) => Edge::Border,
            (Padding::Border, _) => Edge::Clamp,
            (Padding::Reflection, false) => Edge::Mirror,
            (Padding::Reflection, true) => Edge::Mirror101,
        }
    }

    /// Whether a position that is not finite gives NaN; else it is a pixel of the edge, or nothing.
    fn gives_nan(&self) -> bool {
        match self.interpolation {
            Interpolation::Nearest => false,
            Interpolation::Bilinear => self.padding == Padding::Zeros,
            _ => true,
        }
    }

    /// Where a position that is not finite is read, of an axis of `size` pixels.
    fn found(&self, x: f64, size: usize) -> f64 {
        let first = self.padding != Padding::Border || x != f64::INFINITY;
        if first { 0.0 } else { size as f64 - 1.0 }
    }
}

/// Samples all planes of one picture at one grid, pairs (x, y) in rows of `width`, into `out`: planes, or pixels, as the
/// picture's.
///
/// # Errors
/// [`Error::Value`] for lengths that do not fit; [`Error::Interrupted`].
///
/// ```
/// use multum::compat::torch::{Manner, Padding, Planes, grid_sample};
/// use multum::warp::remap::Interpolation;
/// let picture = Planes { data: &[0.0, 10.0, 20.0, 30.0], width: 2, height: 2, channels: 1 };
/// let manner = Manner { interpolation: Interpolation::Bilinear, padding: Padding::Zeros, align_corners: false };
/// let mut out = [0.0];
/// grid_sample(&picture, &manner, &[0.0, 0.0], 1, &mut out)?;
/// assert_eq!(out, [15.0]);
/// # Ok::<(), multum::Error>(())
/// ```
pub fn grid_sample<T: Float>(
    picture: &Planes<'_, T>,
    manner: &Manner,
    grid: &[T],
    width: usize,
    out: &mut [T],
) -> Result<()> {
    let Planes { data, width: w, height: h, channels } = *picture;
    let plane = w.checked_mul(h).and_then(|n| n.checked_mul(channels)).filter(|&n| n > 0);
    let count = grid.len() / 2;
    let planes = plane.map_or(0, |plane| data.len() / plane);
    let whole = plane.is_some_and(|plane| data.len() == planes * plane);
    if !whole || out.len() != planes * count * channels || !grid.len().is_multiple_of(2) {
        let got = format!("{} numbers, {} of the grid, {} of the output", data.len(), grid.len(), out.len());
        return Err(Error::value("grid", got, format!("a pair for each pixel of {planes} planes {w} x {h}")));
    }
    if out.is_empty() {
        return Ok(());
    }
    let isa = Isa::current();
    let (mut x, mut y) = (zeros::<T::Position>("grid", count)?, zeros::<T::Position>("grid", count)?);
    let pairs = grid.as_chunks::<2>().0;
    let band = |i: usize, (x, y): (&mut [T::Position], &mut [T::Position])| {
        compiled_for(isa, Positions { manner, size: [w, h], pairs: &pairs[i * BAND..], x, y });
        Ok(())
    };
    par::for_each(x.chunks_mut(BAND).zip(y.chunks_mut(BAND)), band)?;
    let strange = |x: T::Position, y: T::Position| !(x.wide().is_finite() && y.wide().is_finite());
    let mut lost = Vec::new();
    if x.iter().zip(&y).fold(false, |any, (&x, &y)| any | strange(x, y)) {
        lost.extend((0..count).filter(|&i| strange(x[i], y[i])));
        let reads =
            manner.padding != Padding::Zeros && !matches!(manner.interpolation, Interpolation::Bicubic(_));
        for &i in lost.iter().filter(|_| reads) {
            for (at, size) in [(&mut x[i], w), (&mut y[i], h)] {
                if !at.wide().is_finite() {
                    *at = Real::of(manner.found(at.wide(), size));
                }
            }
        }
    }
    let map = T::map(&x, &y);
    let read = |data: &[T], channels: usize, out: &mut [T]| {
        let border = vec![T::default(); channels];
        let source = Source::new(data, w, h, channels, w * channels)?;
        let job = Job::new(source, manner.interpolation, [manner.edge(); 2], &border, Outside::Colour)?;
        interpolate(&job, &map, Grid::Exact, width, out)?;
        for &i in lost.iter().filter(|_| manner.gives_nan()) {
            out[i * channels..(i + 1) * channels].fill(T::NAN);
        }
        Ok(())
    };
    let (plane, made) = (w * h * channels, count * channels);
    if channels > 1 || !matches!(manner.interpolation, Interpolation::Bicubic(_)) || 2 * count < w * h {
        let planes = data.chunks_exact(plane).zip(out.chunks_exact_mut(made));
        return planes.into_iter().try_for_each(|(data, out)| read(data, channels, out));
    }
    // Sixteen weights a pixel: worth a copy of four planes side by side, which are read as one picture.
    let (mut source, mut target) = (zeros::<T>("input", GROUP * plane)?, zeros::<T>("grid", GROUP * made)?);
    for (data, out) in data.chunks(GROUP * plane).zip(out.chunks_mut(GROUP * made)) {
        for (c, plane) in data.chunks_exact(plane).enumerate() {
            source[c..].iter_mut().step_by(GROUP).zip(plane).for_each(|(to, &from)| *to = from);
        }
        read(&source, GROUP, &mut target)?;
        for (c, made) in out.chunks_exact_mut(made).enumerate() {
            made.iter_mut().zip(target[c..].iter().step_by(GROUP)).for_each(|(to, &from)| *to = from);
        }
    }
    Ok(())
}

/// From pairs of a grid to pixels, to be compiled for an instruction set.
struct Positions<'a, T: Float> {
    manner: &'a Manner,
    size: [usize; 2],
    pairs: &'a [[T; 2]],
    x: &'a mut [T::Position],
    y: &'a mut [T::Position],
}

impl<T: Float> Work for Positions<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let [[fx, dx], [fy, dy]] = self.size.map(|size| self.manner.scale(size).map(T::Position::of));
        let one = T::Position::of(1.0);
        for ((x, y), &[u, v]) in self.x.iter_mut().zip(self.y).zip(self.pairs) {
            *x = (u.position() + one) * fx - dx;
            *y = (v.position() + one) * fy - dy;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_that_are_read_together_are_those_read_alone() {
        let data: Vec<f32> = (0..6 * 35).map(|i| (i * 7919 % 251) as f32).collect();
        let grid: Vec<f32> = (0..2 * 40).map(|i| (i * 37 % 29) as f32 / 12.0 - 1.2).collect();
        let interpolation = Interpolation::Bicubic(-0.75);
        let manner = Manner { interpolation, padding: Padding::Reflection, align_corners: false };
        let mut all = vec![0.0; 6 * 40];
        let planes = Planes { data: &data, width: 7, height: 5, channels: 1 };
        grid_sample(&planes, &manner, &grid, 8, &mut all).unwrap();
        for (plane, got) in data.chunks_exact(35).zip(all.chunks_exact(40)) {
            // Few places for so large a picture: it is read as it is.
            for (grid, got) in grid.chunks_exact(16).zip(got.chunks_exact(8)) {
                let mut out = [0.0; 8];
                grid_sample(&Planes { data: plane, ..planes }, &manner, grid, 8, &mut out).unwrap();
                assert_eq!(out, got);
            }
        }
    }

    #[test]
    fn corners_are_edges_or_centres_and_planes_and_pixels_agree() {
        let data = [1.0f32, 2.0, 3.0, 4.0, 5.0, 6.0];
        let grid = [-1.0, 0.0, 0.0, 0.0, 1.0, 0.0, f32::NAN, 0.0];
        for (align_corners, padding, want) in [
            (true, Padding::Border, [1.0, 2.0, 3.0]),
            (false, Padding::Border, [1.0, 2.0, 3.0]),
            (false, Padding::Zeros, [0.5, 2.0, 1.5]),
            (true, Padding::Reflection, [1.0, 2.0, 3.0]),
        ] {
            let manner = Manner { interpolation: Interpolation::Bilinear, padding, align_corners };
            let planes = Planes { data: &data, width: 3, height: 1, channels: 1 };
            let mut out = [9.0; 8];
            grid_sample(&planes, &manner, &grid, 4, &mut out).unwrap();
            assert_eq!(
                (&out[..3], out[4]),
                (&want[..], want[0] + if padding == Padding::Zeros { 1.5 } else { 3.0 })
            );
            assert!(if padding == Padding::Zeros { out[3].is_nan() } else { out[3] == 1.0 });
            let mixed = [1.0, 4.0, 2.0, 5.0, 3.0, 6.0];
            let pixels = Planes { data: &mixed, width: 3, height: 1, channels: 2 };
            let mut side = [9.0; 8];
            grid_sample(&pixels, &manner, &grid, 4, &mut side).unwrap();
            assert!((0..3).all(|i| [side[2 * i], side[2 * i + 1]] == [out[i], out[4 + i]]));
            assert!(grid_sample(&planes, &manner, &grid[1..], 4, &mut out).is_err());
            assert!(grid_sample(&planes, &manner, &grid, 4, &mut out[1..]).is_err());
        }
    }
}
