//! Plain interpolation of a picture at the positions of a map or a matrix, without a minification filter.
//!
//! Positions are in pixels of the source, whose pixel centres are at integers: x to the right, y down.

use crate::error::{Error, Result};
use crate::kernel::Isa;
use crate::kernel::remap::{Buffer, CHUNK, Points, Row, Sample, remap};
use crate::par;

pub use crate::kernel::remap::{Edge, Grid, Interpolation, Job, Outside, Source};

/// Output pixels of a band, about: the unit of work of a thread. Smaller calls stay on the calling thread.
const BAND: usize = 1 << 15;

/// Where each output pixel is read; maps have one entry a pixel, row by row.
#[derive(Clone, Copy, Debug)]
pub enum Map<'a> {
    /// Columns and rows in singles.
    Single(&'a [f32], &'a [f32]),
    /// Columns and rows in doubles.
    Double(&'a [f64], &'a [f64]),
    /// Pairs (x, y) in singles.
    SinglePairs(&'a [f32]),
    /// Pairs (x, y) in doubles.
    DoublePairs(&'a [f64]),
    /// Pairs of whole pixels, and fractions `32 * fy + fx` in 1/32 pixel.
    Fixed(&'a [i16], Option<&'a [u16]>),
    /// A matrix, row by row, from output pixels to positions, with a division by its third row.
    Matrix(&'a [f64; 9]),
}

impl Map<'_> {
    /// Whether there is a position for each of so many pixels.
    pub fn fits(&self, pixels: usize) -> bool {
        match self {
            Self::Single(x, y) => x.len() == pixels && y.len() == pixels,
            Self::Double(x, y) => x.len() == pixels && y.len() == pixels,
            Self::SinglePairs(p) => p.len() == 2 * pixels,
            Self::DoublePairs(p) => p.len() == 2 * pixels,
            Self::Fixed(p, codes) => p.len() == 2 * pixels && codes.is_none_or(|c| c.len() == pixels),
            Self::Matrix(_) => true,
        }
    }

    /// Its lengths, for messages.
    pub(super) fn described(&self) -> String {
        match self {
            Self::Single(x, y) => format!("{} columns and {} rows", x.len(), y.len()),
            Self::Double(x, y) => format!("{} columns and {} rows", x.len(), y.len()),
            Self::SinglePairs(p) => format!("{} numbers", p.len()),
            Self::DoublePairs(p) => format!("{} numbers", p.len()),
            Self::Fixed(p, codes) => format!("{} numbers and {:?} codes", p.len(), codes.map(<[u16]>::len)),
            Self::Matrix(m) => format!("{m:?}"),
        }
    }
}

/// Fills `out`, a packed picture of `width` pixels a row, by reading the job's source at `map`.
///
/// `grid` rounds positions; [`Interpolation::Nearest`] always reads at whole ones.
///
/// # Errors
/// [`Error::Value`] when `out` or the map has another size; [`Error::Interrupted`].
///
/// ```
/// use multum::warp::remap::{Edge, Grid, Interpolation, Job, Map, Outside, Source, interpolate};
/// let ramp = [0u8, 10, 20, 30];
/// let source = Source::new(&ramp, 4, 1, 1, 4)?;
/// let job = Job::new(source, Interpolation::Bilinear, [Edge::Clamp; 2], &[0], Outside::Colour)?;
/// let mut out = [0; 3];
/// interpolate(&job, &Map::Single(&[0.5, 1.0, 9.0], &[0.0; 3]), Grid::Exact, 3, &mut out)?;
/// assert_eq!(out, [5, 10, 30]);
/// # Ok::<(), multum::Error>(())
/// ```
pub fn interpolate<T: Sample>(
    job: &Job<'_, T>,
    map: &Map<'_>,
    grid: Grid,
    width: usize,
    out: &mut [T],
) -> Result<()> {
    if out.is_empty() {
        return Ok(());
    }
    let row = width * job.channels();
    if row == 0 || !out.len().is_multiple_of(row) {
        return Err(Error::value("out", format!("{} elements", out.len()), format!("rows of {row}")));
    }
    let pixels = out.len() / job.channels();
    if !map.fits(pixels) {
        return Err(Error::value("map", map.described(), format!("{pixels} positions")));
    }
    let grid = match (job.interpolation(), grid) {
        (Interpolation::Nearest, Grid::AccumulatedWhole) => grid,
        (Interpolation::Nearest, _) => Grid::Whole,
        _ => grid,
    };
    let isa = Isa::current();
    let apron = if isa == Isa::Scalar { None } else { job.apron(pixels) };
    let job = &apron.as_deref().map_or(*job, |apron| job.with_apron(apron));
    let rows = (BAND / width).max(1);
    let bands = out.chunks_mut(rows * row);
    if bands.len() == 1 {
        // Asking how many threads there are would take longer than a small picture.
        return bands.into_iter().try_for_each(|out| band(isa, job, map, grid, width, 0, out));
    }
    par::for_each(bands, |i, out| band(isa, job, map, grid, width, i * rows, out))
}

/// Rows from `first` on.
fn band<T: Sample>(
    isa: Isa,
    job: &Job<'_, T>,
    map: &Map<'_>,
    grid: Grid,
    width: usize,
    first: usize,
    out: &mut [T],
) -> Result<()> {
    let pixels = out.len() / job.channels();
    let (start, end) = (first * width, first * width + pixels);
    if let (Map::Single(x, y), Grid::Exact | Grid::Whole) = (map, grid) {
        return remap(isa, job, &Points::Plain(&x[start..end], &y[start..end]), out);
    }
    if let (Map::Matrix(matrix), Grid::Exact | Grid::Whole) = (map, grid) {
        for (i, row) in out.chunks_mut(width * job.channels()).enumerate() {
            let y = (first + i) as f64;
            remap(isa, job, &Points::Row(Row { matrix, x0: 0.0, y }), row)?;
        }
        return Ok(());
    }
    let mut buffer: Buffer<_> = Buffer::new();
    if let Map::Matrix(m) = map {
        for (i, row) in out.chunks_mut(width * job.channels()).enumerate() {
            for (k, out) in row.chunks_mut(CHUNK * job.channels()).enumerate() {
                let n = out.len() / job.channels();
                let split = buffer.matrix(isa, grid, m, (k * CHUNK) as f64, (first + i) as f64, n);
                remap(isa, job, &Points::Split(split), out)?;
            }
        }
        return Ok(());
    }
    let (mut xs, mut ys) = ([0.0f32; CHUNK], [0.0f32; CHUNK]);
    for (k, out) in out.chunks_mut(CHUNK * job.channels()).enumerate() {
        let n = out.len() / job.channels();
        let at = start + k * CHUNK..start + k * CHUNK + n;
        let pairs = 2 * at.start..2 * at.end;
        let points = match map {
            Map::Single(x, y) => Points::Split(buffer.split_f32(isa, grid, &x[at.clone()], &y[at])),
            Map::Double(x, y) => Points::Split(buffer.split_f64(isa, grid, &x[at.clone()], &y[at])),
            Map::SinglePairs(p) => {
                for ((pair, x), y) in p[pairs].chunks_exact(2).zip(&mut xs).zip(&mut ys) {
                    (*x, *y) = (pair[0], pair[1]);
                }
                if matches!(grid, Grid::Exact | Grid::Whole) {
                    Points::Plain(&xs[..n], &ys[..n])
                } else {
                    Points::Split(buffer.split_f32(isa, grid, &xs[..n], &ys[..n]))
                }
            }
            Map::DoublePairs(p) => {
                let p = &p[pairs];
                let (mut x, mut y) = ([0.0; CHUNK], [0.0; CHUNK]);
                for ((pair, x), y) in p.chunks_exact(2).zip(&mut x).zip(&mut y) {
                    (*x, *y) = (pair[0], pair[1]);
                }
                Points::Split(buffer.split_f64(isa, grid, &x[..n], &y[..n]))
            }
            Map::Fixed(p, codes) => {
                let nearest = job.interpolation() == Interpolation::Nearest;
                Points::Split(buffer.fixed(isa, &p[pairs], codes.map(|c| &c[at]), nearest))
            }
            Map::Matrix(_) => return Ok(()),
        };
        remap(isa, job, &points, out)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_forms_of_a_map_and_all_thread_counts_agree() {
        let data: Vec<u8> = (0..50 * 40 * 3).map(|i| (i * 37 % 251) as u8).collect();
        let source = Source::new(&data, 50, 40, 3, 150).unwrap();
        let (w, h) = (300, 250);
        let m = [0.125, 0.03125, 2.0, -0.0625, 0.125, 9.0, 0.0, 0.0, 1.0];
        let at = |i: usize, r: usize| m[r] * (i % w) as f64 + m[r + 1] * (i / w) as f64 + m[r + 2];
        let x: Vec<f64> = (0..w * h).map(|i| at(i, 0)).collect();
        let y: Vec<f64> = (0..w * h).map(|i| at(i, 3)).collect();
        let (x32, y32): (Vec<f32>, Vec<f32>) = x.iter().zip(&y).map(|(&x, &y)| (x as f32, y as f32)).unzip();
        let pairs: Vec<f64> = x.iter().zip(&y).flat_map(|(&x, &y)| [x, y]).collect();
        let pairs32: Vec<f32> = pairs.iter().map(|&v| v as f32).collect();
        let whole: Vec<i16> = pairs.iter().map(|v| v.floor() as i16).collect();
        let codes: Vec<u16> = pairs
            .chunks_exact(2)
            .map(|p| ((p[0] * 32.0) as i32 & 31) as u16 + 32 * ((p[1] * 32.0) as i32 & 31) as u16)
            .collect();
        for kind in [Interpolation::Nearest, Interpolation::Bilinear, Interpolation::Bicubic(-0.75)] {
            let job = Job::new(source, kind, [Edge::Mirror; 2], &[0; 3], Outside::Colour).unwrap();
            let run = |threads: usize, map: &Map<'_>| {
                let mut out = vec![0u8; w * h * 3];
                par::with_threads(Some(threads), || interpolate(&job, map, Grid::Exact, w, &mut out))
                    .unwrap();
                out
            };
            let want = run(1, &Map::Single(&x32, &y32));
            for threads in [1, 2, 7] {
                assert!(want == run(threads, &Map::Single(&x32, &y32)));
                assert!(want == run(threads, &Map::Double(&x, &y)));
                assert!(want == run(threads, &Map::SinglePairs(&pairs32)));
                assert!(want == run(threads, &Map::DoublePairs(&pairs)));
                assert!(want == run(threads, &Map::Matrix(&m)));
                if kind != Interpolation::Nearest {
                    assert!(want == run(threads, &Map::Fixed(&whole, Some(&codes))));
                }
            }
        }
    }

    #[test]
    fn sizes_that_do_not_fit_are_refused() {
        let source = Source::new(&[0u8; 4], 2, 2, 1, 2).unwrap();
        let job = Job::new(source, Interpolation::Bilinear, [Edge::Clamp; 2], &[0], Outside::Colour).unwrap();
        let mut out = [0; 6];
        assert!(interpolate(&job, &Map::Single(&[0.0; 6], &[0.0; 5]), Grid::Exact, 3, &mut out).is_err());
        assert!(interpolate(&job, &Map::SinglePairs(&[0.0; 6]), Grid::Exact, 3, &mut out).is_err());
        assert!(interpolate(&job, &Map::Matrix(&[0.0; 9]), Grid::Exact, 4, &mut out).is_err());
        assert!(interpolate(&job, &Map::Matrix(&[0.0; 9]), Grid::Exact, 0, &mut out).is_err());
        assert!(interpolate(&job, &Map::Matrix(&[0.0; 9]), Grid::Exact, 0, &mut []).is_ok());
    }
}
