//! Drop-in interpolation for scikit-image: positions in bands, read by the kernels of the same arithmetic.

use crate::error::{Error, Result};
use crate::kernel::remap::{Buffer, CHUNK, Grid, Real, Split, nearest};
use crate::kernel::{Isa, compiled_for};
use crate::par;

pub use crate::kernel::remap::{Edge, Lerp, Scaled, Source};

/// Output pixels of a band, about: the unit of work of a thread.
const BAND: usize = 1 << 14;

/// Where each output pixel is read, in pixels of the source.
#[derive(Clone, Copy, Debug)]
pub enum Where<'a> {
    /// `(m0 x + m1 y + m2, m3 x + m4 y + m5)`, divided by `m6 x + m7 y + m8` unless that is always 1; summed
    /// from left to right.
    Matrix(&'a [f64; 9]),
    /// Columns and rows.
    Planes(&'a [f64], &'a [f64]),
}

impl Where<'_> {
    fn check(&self, pixels: usize) -> Result<()> {
        match self {
            Self::Planes(x, y) if x.len() != pixels || y.len() != pixels => Err(Error::value(
                "coordinates",
                format!("{} columns and {} rows", x.len(), y.len()),
                format!("{pixels} of each"),
            )),
            _ => Ok(()),
        }
    }
}

/// Numbers in which positions may be computed.
pub trait Position: Real + std::ops::Div<Output = Self> {
    /// Takes positions apart into the buffer.
    fn split<'b>(buffer: &'b mut Buffer<Self>, isa: Isa, x: &[Self], y: &[Self]) -> Split<'b, Self>;
}

impl Position for f32 {
    fn split<'b>(buffer: &'b mut Buffer<Self>, isa: Isa, x: &[Self], y: &[Self]) -> Split<'b, Self> {
        buffer.split_f32(isa, Grid::Exact, x, y)
    }
}

impl Position for f64 {
    fn split<'b>(buffer: &'b mut Buffer<Self>, isa: Isa, x: &[Self], y: &[Self]) -> Split<'b, Self> {
        buffer.split_f64(isa, Grid::Exact, x, y)
    }
}

/// Positions of a part of an output row.
#[inline(always)]
fn on_row<H: Position>(m: &[H; 9], first: usize, y: usize, xs: &mut [H], ys: &mut [H]) {
    let y = H::of(y as f64);
    // Whole numbers below 2^32 become doubles in one step.
    let column = |i: usize| H::of(f64::from((first + i) as u32));
    for (i, (px, py)) in xs.iter_mut().zip(&mut *ys).enumerate() {
        let x = column(i);
        (*px, *py) = (m[0] * x + m[1] * y + m[2], m[3] * x + m[4] * y + m[5]);
    }
    if m[6] != H::default() || m[7] != H::default() || m[8] != H::of(1.0) {
        for (i, (px, py)) in xs.iter_mut().zip(ys).enumerate() {
            let w = m[6] * column(i) + m[7] * y + m[8];
            (*px, *py) = (*px / w, *py / w);
        }
    }
}

/// Calls `work(start, chunk)` for chunks of rows of `out` in bands, with the index of the first pixel of each.
fn in_bands<O: Send>(
    out: &mut [O],
    width: usize,
    channels: usize,
    work: impl Fn(usize, &mut [O]) + Sync,
) -> Result<()> {
    let row = width * channels;
    if out.is_empty() {
        return Ok(());
    }
    if row == 0 || !out.len().is_multiple_of(row) {
        return Err(Error::value("out", format!("{} elements", out.len()), format!("rows of {row}")));
    }
    let rows = (BAND / width).max(1);
    let bands = out.chunks_mut(rows * row);
    let whole_band = |i: usize, band: &mut [O]| {
        for (k, out_row) in band.chunks_mut(row).enumerate() {
            work((i * rows + k) * width, out_row);
        }
        Ok(())
    };
    if bands.len() == 1 {
        // Asking how many threads there are would take longer than a small picture.
        return bands.into_iter().try_for_each(|band| whole_band(0, band));
    }
    par::for_each(bands, whole_band)
}

/// Fills `out`, a packed picture of `width` pixels a row, by linear interpolation at `places`.
///
/// # Errors
/// [`Error::Value`] when `out` or the places have another size; [`Error::Interrupted`].
///
/// ```
/// use multum::warp::lerp::{Edge, Lerp, Source, Where, linear};
/// let source = Source::new(&[0.0, 1.0, f64::NAN, 3.0], 4, 1, 1, 4)?;
/// let lerp = Lerp { source, edges: [Edge::Clamp; 2], factor: 1.0, border: 0.0, nowhere: f64::NAN, limits: [0.0, 9.0] };
/// let mut out = [0.0; 3];
/// // A position on a pixel reads that pixel alone.
/// linear(&lerp, Where::Planes(&[0.25, 1.0, 7.0], &[0.0; 3]), 3, &mut out)?;
/// assert_eq!(out, [0.25, 1.0, 3.0]);
/// # Ok::<(), multum::Error>(())
/// ```
pub fn linear<S: Scaled<H>, H: Position, O: Real>(
    lerp: &Lerp<'_, S, H, O>,
    places: Where<'_>,
    width: usize,
    out: &mut [O],
) -> Result<()> {
    let channels = lerp.source.channels();
    places.check(out.len() / channels)?;
    let isa = Isa::current();
    let matrix = match places {
        Where::Matrix(m) => m.map(H::of),
        Where::Planes(..) => [H::default(); 9],
    };
    in_bands(out, width, channels, |start, out_row| {
        let (mut xs, mut ys) = ([H::default(); CHUNK], [H::default(); CHUNK]);
        let mut buffer = Buffer::new();
        for (k, out) in out_row.chunks_mut(CHUNK * channels).enumerate() {
            let n = out.len() / channels;
            let (xs, ys) = (&mut xs[..n], &mut ys[..n]);
            match places {
                Where::Matrix(_) => {
                    compiled_for(isa, || on_row(&matrix, k * CHUNK, start / width, &mut *xs, &mut *ys));
                }
                Where::Planes(px, py) => {
                    let at = start + k * CHUNK;
                    for (to, from) in [(&mut *xs, px), (&mut *ys, py)] {
                        for (to, &from) in to.iter_mut().zip(&from[at..at + n]) {
                            *to = H::of(from);
                        }
                    }
                }
            }
            lerp.run(isa, &H::split(&mut buffer, isa, xs, ys), out);
        }
    })
}

/// Fills `out` with copies of the nearest pixels, of elements of any type. A matrix's zero divisors count as 2^-52.
///
/// # Errors
/// As [`linear`].
pub fn closest<T: Copy + Send + Sync>(
    source: &Source<'_, T>,
    edges: [Edge; 2],
    border: &[T],
    places: Where<'_>,
    width: usize,
    out: &mut [T],
) -> Result<()> {
    let channels = source.channels();
    if border.len() != channels {
        return Err(Error::value("border", format!("{} elements", border.len()), channels));
    }
    places.check(out.len() / channels)?;
    in_bands(out, width, channels, |start, out_row| match places {
        Where::Planes(x, y) => {
            let end = start + width;
            nearest(source, edges, border, [&x[start..end], &y[start..end]], out_row);
        }
        Where::Matrix(m) => {
            let (mut xs, mut ys) = ([0.0; CHUNK], [0.0; CHUNK]);
            let y = (start / width) as f64;
            for (k, out) in out_row.chunks_mut(CHUNK * channels).enumerate() {
                let n = out.len() / channels;
                for i in 0..n {
                    let x = (k * CHUNK + i) as f64;
                    let w = m[6] * x + m[7] * y + m[8];
                    let w = if w == 0.0 { f64::EPSILON } else { w };
                    xs[i] = (m[0] * x + m[1] * y + m[2]) / w;
                    ys[i] = (m[3] * x + m[4] * y + m[5]) / w;
                }
                nearest(source, edges, border, [&xs[..n], &ys[..n]], out);
            }
        }
    })
}
