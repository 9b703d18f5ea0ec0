//! `getRectSubPix`: a patch around a place between pixels, linear along both axes, with the same fractions everywhere.

use super::Rows;
use crate::error::{Error, Result};
use crate::kernel::remap::{Real, Sample};
use crate::kernel::{Isa, Work, compiled_for};
use crate::par;

/// Elements of output that a thread takes at a time, about.
const BAND: usize = 1 << 16;

/// Fills `out`, `size` = (width, height) packed pixels, with the picture around `center` (x, y). The outermost pixels go
/// on beyond the picture; a centre that is not finite gives zeros.
///
/// # Errors
/// [`Error::Value`] for an `out` of another size; [`Error::Interrupted`].
///
/// ```
/// use multum::compat::cv2::{Rows, patch::patch};
/// let picture = Rows::new(&[10u8, 20, 30], 3, 1, 1, 3)?;
/// let mut out = [0; 4];
/// patch(&picture, [4, 1], [1.0, 0.0], &mut out)?;
/// assert_eq!(out, [10, 15, 25, 30]);
/// # Ok::<(), multum::Error>(())
/// ```
pub fn patch<T: Sample>(
    source: &Rows<'_, T>,
    size: [usize; 2],
    center: [f64; 2],
    out: &mut [T],
) -> Result<()> {
    let ([width, height], n) = (size, source.channels);
    let len = width.checked_mul(height).and_then(|pixels| pixels.checked_mul(n));
    if len != Some(out.len()) || out.is_empty() {
        let expected = format!("{width} x {height} x {n}");
        return Err(Error::value("patch", format!("{} elements", out.len()), expected));
    }
    if !center.iter().all(|c| c.is_finite()) {
        out.fill(T::default());
        return Ok(());
    }
    let from = [source.width, source.height];
    let [(x0, fx), (y0, fy)] = [0, 1].map(|k| {
        let first = center[k] - 0.5 * (size[k] as f64 - 1.0);
        // Further outside nothing changes.
        let first = first.clamp(-(size[k] as f64) - 1.0, from[k] as f64 + 1.0);
        (first.floor() as i64, T::Acc::of(first - first.floor()))
    });
    let isa = Isa::current();
    let rows = (BAND / (width * n)).max(1);
    let row = |y: i64| source.row(y.clamp(0, source.height as i64 - 1) as usize);
    // Whether all columns lie in the picture, and the one after the last.
    let inside = x0 >= 0 && x0 as usize + width < source.width;
    let work = |first: usize, out: &mut [T]| {
        let mut lines = [Vec::new(), Vec::new()];
        for (y, out) in (y0 + first as i64..).zip(out.chunks_exact_mut(width * n)) {
            let [upper, lower] = if inside {
                [y, y + 1].map(|y| &row(y)[x0 as usize * n..][..(width + 1) * n])
            } else {
                for (line, y) in lines.iter_mut().zip([y, y + 1]) {
                    line.clear();
                    for x in x0..=x0 + width as i64 {
                        let x = x.clamp(0, source.width as i64 - 1) as usize;
                        line.extend_from_slice(&row(y)[x * n..(x + 1) * n]);
                    }
                }
                [&lines[0][..], &lines[1][..]]
            };
            compiled_for(isa, Lerp { rows: [upper, lower], f: [fx, fy], n, out });
        }
    };
    par::for_each(out.chunks_mut(rows * width * n), |i, out| {
        work(i * rows, out);
        Ok(())
    })
}

/// A row between two rows and between their pixels, to be compiled for an instruction set.
struct Lerp<'a, T: Sample> {
    rows: [&'a [T]; 2],
    f: [T::Acc; 2],
    n: usize,
    out: &'a mut [T],
}

impl<T: Sample> Work for Lerp<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { rows: [upper, lower], f: [fx, fy], n, out } = self;
        let count = out.len();
        let (a, b) = (&upper[..count], &upper[n..n + count]);
        let (c, d) = (&lower[..count], &lower[n..n + count]);
        for i in 0..count {
            let (a, b) = (a[i].get(), b[i].get());
            let left = a + fy * (c[i].get() - a);
            let right = b + fy * (d[i].get() - b);
            out[i] = T::put(left + fx * (right - left));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::remap::{Edge, Interpolation, Job, Outside, Source};
    use crate::kernel::with_isa;
    use crate::warp::remap::{Grid, Map, interpolate};

    #[test]
    fn patches_are_what_the_general_way_reads_on_every_instruction_set_and_thread_count() {
        for ([w, h, n], size, center) in [
            ([9, 7, 3], [4, 5], [4.25, 3.5]),
            ([9, 7, 1], [6, 3], [-1.5, 6.75]),
            ([5, 1, 4], [7, 2], [2.0, 0.0]),
            ([3, 4, 2], [2, 2], [1e300, -1e300]),
            ([400, 300, 3], [300, 280], [200.125, 150.25]),
        ] {
            let data: Vec<u16> = (0..w * h * n).map(|i| (i * 7919 % 65_521) as u16).collect();
            let source = Rows::new(&data, w, h, n, w * n).unwrap();
            let at = |k: usize| center[k] - 0.5 * (size[k] as f64 - 1.0);
            let m = [1.0, 0.0, at(0), 0.0, 1.0, at(1), 0.0, 0.0, 1.0];
            let border = vec![0; n];
            let picture = Source::new(&data, w, h, n, w * n).unwrap();
            let job = Job::new(picture, Interpolation::Bilinear, [Edge::Clamp; 2], &border, Outside::Colour);
            let mut want = vec![0; size[0] * size[1] * n];
            interpolate(&job.unwrap(), &Map::Matrix(&m), Grid::Exact, size[0], &mut want).unwrap();
            for isa in Isa::available() {
                for threads in [1, 3] {
                    let mut out = vec![9; want.len()];
                    let run = || with_isa(isa, || patch(&source, size, center, &mut out));
                    par::with_threads(Some(threads), run).unwrap().unwrap();
                    assert!(out == want, "{isa:?} {w} x {h} x {n}");
                }
            }
        }
        let source = Rows::new(&[1u8, 2], 2, 1, 1, 2).unwrap();
        let mut out = [7; 2];
        patch(&source, [2, 1], [f64::NAN, 0.0], &mut out).unwrap();
        assert_eq!(out, [0, 0]);
        assert!(patch(&source, [3, 1], [0.0, 0.0], &mut out).is_err());
    }
}
