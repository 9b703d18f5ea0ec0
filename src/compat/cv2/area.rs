//! `INTER_AREA` where both sides shrink: the mean of the pixels under each output pixel, by their shares.
//!
//! Output pixel i of an axis covers `i s .. (i + 1) s` of it; shares below 1/1000 of a pixel are dropped, as in
//! OpenCV. Columns are summed before rows: that pass runs over neighbouring elements, whatever the number of
//! channels.

use super::Rows;
use super::pyramid::Element;
use super::read::Pixel;
use crate::error::{Error, Result};
use crate::kernel::cast::{same, same_mut};
use crate::kernel::remap::Real;
use crate::kernel::{Isa, box_down, compiled_for};
use crate::par;

/// Elements of input that a thread takes at a time, about.
const BAND: usize = 1 << 16;

/// The pixels under every pixel of an output's axis.
struct Shares<A> {
    /// First pixel, and where its shares begin and end in `weights`.
    spans: Vec<(usize, usize, usize)>,
    weights: Vec<A>,
}

impl<A: Real> Shares<A> {
    /// `n` pixels seen `scale` at a time as `m`.
    fn new(n: usize, m: usize, scale: f64) -> Self {
        let mut spans = Vec::with_capacity(m);
        let mut weights = Vec::with_capacity((m as f64 * (scale + 2.0)) as usize);
        let end = n as f64;
        for i in 0..m {
            let low = (i as f64 * scale).min(end - 1.0);
            let high = (low + scale).min(end);
            let cell = high - low;
            let last = (high.floor() as usize).min(n - 1);
            let first = (low.ceil() as usize).min(last);
            let start = weights.len();
            let mut from = first;
            let before = first as f64 - low;
            if before > 1e-3 {
                from = first - 1;
                weights.push(A::of(before / cell));
            }
            weights.extend((first..last).map(|_| A::of(1.0 / cell)));
            let behind = high - last as f64;
            if behind > 1e-3 || weights.len() == start {
                weights.push(A::of(behind.min(1.0).min(cell) / cell));
            }
            spans.push((from, start, weights.len()));
        }
        Self { spans, weights }
    }

    fn of(&self, i: usize) -> (usize, &[A]) {
        let (first, start, end) = self.spans[i];
        (first, &self.weights[start..end])
    }
}

/// Fills `out`, `size` = (width, height) packed pixels, each of which covers `scale` pixels of the source.
///
/// # Errors
/// [`Error::Value`] for an `out` of another size or a scale below 1; [`Error::Interrupted`].
///
/// ```
/// use multum::compat::cv2::{Rows, area::area};
/// let picture = Rows::new(&[0u8, 10, 20, 30, 40], 5, 1, 1, 5)?;
/// let mut out = [0; 2];
/// area(&picture, [2, 1], [2.5, 1.0], &mut out)?;
/// assert_eq!(out, [8, 32]); // (0 + 10 + 20/2) / 2.5 and (20/2 + 30 + 40) / 2.5
/// # Ok::<(), multum::Error>(())
/// ```
pub fn area<T: Pixel + Element>(
    source: &Rows<'_, T>,
    size: [usize; 2],
    scale: [f64; 2],
    out: &mut [T],
) -> Result<()> {
    let [width, height] = size;
    let channels = source.channels;
    let len = width.checked_mul(height).and_then(|n| n.checked_mul(channels));
    if len != Some(out.len()) || out.is_empty() || !(scale[0] >= 1.0 && scale[1] >= 1.0) {
        let got = format!("{} elements, {scale:?}", out.len());
        return Err(Error::value("dst", got, format!("{width} x {height} pixels of at least one each")));
    }
    let isa = Isa::current();
    let row = width * channels;
    let per_row = (source.width * channels).saturating_mul(scale[1].ceil() as usize);
    let rows = (BAND / per_row.max(1)).max(1);
    let halves = scale == [2.0, 2.0] && source.width >= 2 * width && source.height >= 2 * height;
    let across = Shares::<T::Acc>::new(source.width, width, scale[0]);
    let down = Shares::<T::Acc>::new(source.height, height, scale[1]);
    let work = |first: usize, out: &mut [T]| {
        if halves {
            for (y, out) in out.chunks_exact_mut(row).enumerate() {
                let pair = [source.row(2 * (first + y)), source.row(2 * (first + y) + 1)];
                if let ([Some(a), Some(b)], Some(out)) = (pair.map(same::<T, u8>), same_mut::<T, u8>(out)) {
                    box_down::halve_codes(isa, a, b, channels, out);
                } else {
                    compiled_for(isa, || halve(pair, channels, out));
                }
            }
            return;
        }
        let mut sums = vec![T::Acc::default(); source.width * channels];
        for (y, out) in out.chunks_exact_mut(row).enumerate() {
            let (top, weights) = down.of(first + y);
            compiled_for(isa, || {
                sum_rows(source, top, weights, &mut sums);
                sum_columns(&sums, channels, &across, out);
            });
        }
    };
    let bands = out.chunks_mut(rows * row);
    if bands.len() == 1 {
        bands.into_iter().for_each(|band| work(0, band));
        return Ok(());
    }
    par::for_each(bands, |i, band| {
        work(i * rows, band);
        Ok(())
    })
}

/// Means of 2 x 2 pixels; those of integers round halves up.
#[inline(always)]
fn halve<T: Element>([upper, lower]: [&[T]; 2], channels: usize, out: &mut [T]) {
    macro_rules! fixed {
        ($n:literal) => {{
            let pairs = upper.as_chunks::<{ 2 * $n }>().0.iter().zip(lower.as_chunks::<{ 2 * $n }>().0);
            for (out, (a, b)) in out.as_chunks_mut::<$n>().0.iter_mut().zip(pairs) {
                for c in 0..$n {
                    let four = [a[c].wide(), a[c + $n].wide(), b[c].wide(), b[c + $n].wide()];
                    out[c] = T::narrow::<2>(T::four(four));
                }
            }
        }};
    }
    match channels {
        1 => fixed!(1),
        2 => fixed!(2),
        3 => fixed!(3),
        4 => fixed!(4),
        _ => {
            let pairs = upper.chunks_exact(2 * channels).zip(lower.chunks_exact(2 * channels));
            for (out, (a, b)) in out.chunks_exact_mut(channels).zip(pairs) {
                for (c, out) in out.iter_mut().enumerate() {
                    let four = [a[c].wide(), a[c + channels].wide(), b[c].wide(), b[c + channels].wide()];
                    *out = T::narrow::<2>(T::four(four));
                }
            }
        }
    }
}

/// The weighted sum of rows from `top` on.
#[inline(always)]
fn sum_rows<T: Pixel>(source: &Rows<'_, T>, top: usize, weights: &[T::Acc], sums: &mut [T::Acc]) {
    let n = sums.len();
    let row = |k: usize| &source.row(top + k)[..n];
    match *weights {
        [a] => {
            let first = row(0);
            for i in 0..n {
                sums[i] = a * first[i].get();
            }
        }
        [a, b] => {
            let (first, second) = (row(0), row(1));
            for i in 0..n {
                sums[i] = a * first[i].get() + b * second[i].get();
            }
        }
        [a, b, c, ref rest @ ..] => {
            let (first, second, third) = (row(0), row(1), row(2));
            for i in 0..n {
                sums[i] = a * first[i].get() + b * second[i].get() + c * third[i].get();
            }
            for (k, pair) in rest.chunks(2).enumerate() {
                let next = row(3 + 2 * k);
                if let [a, b] = *pair {
                    let after = row(4 + 2 * k);
                    for i in 0..n {
                        sums[i] = sums[i] + (a * next[i].get() + b * after[i].get());
                    }
                } else {
                    for i in 0..n {
                        sums[i] = sums[i] + pair[0] * next[i].get();
                    }
                }
            }
        }
        [] => {}
    }
}

/// The weighted sums of neighbouring pixels.
#[inline(always)]
fn sum_columns<T: Pixel>(sums: &[T::Acc], channels: usize, across: &Shares<T::Acc>, out: &mut [T]) {
    macro_rules! fixed {
        ($n:literal) => {{
            let pixels = sums.as_chunks::<$n>().0;
            for (x, out) in out.as_chunks_mut::<$n>().0.iter_mut().enumerate() {
                let (first, weights) = across.of(x);
                let mut sum = [T::Acc::default(); $n];
                for (pixel, &w) in pixels[first..].iter().zip(weights) {
                    for c in 0..$n {
                        sum[c] = sum[c] + w * pixel[c];
                    }
                }
                for c in 0..$n {
                    out[c] = T::put(sum[c]);
                }
            }
        }};
    }
    match channels {
        1 => fixed!(1),
        2 => fixed!(2),
        3 => fixed!(3),
        4 => fixed!(4),
        _ => {
            for (x, out) in out.chunks_exact_mut(channels).enumerate() {
                let (first, weights) = across.of(x);
                for (c, out) in out.iter_mut().enumerate() {
                    let mut sum = T::Acc::default();
                    for (k, &w) in weights.iter().enumerate() {
                        sum = sum + w * sums[(first + k) * channels + c];
                    }
                    *out = T::put(sum);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::with_isa;

    /// The mean by its definition, in doubles.
    fn mean(data: &[f64], n: [usize; 3], scale: [f64; 2], at: [usize; 3]) -> f64 {
        let share = |i: usize, k: usize, scale: f64, n: usize| {
            let (low, high) = (i as f64 * scale, ((i + 1) as f64 * scale).min(n as f64));
            ((k + 1) as f64).min(high) - (k as f64).max(low)
        };
        let (mut sum, mut whole) = (0.0, 0.0);
        for y in 0..n[1] {
            for x in 0..n[0] {
                let w = share(at[0], x, scale[0], n[0]).max(0.0) * share(at[1], y, scale[1], n[1]).max(0.0);
                sum += w * data[(y * n[0] + x) * n[2] + at[2]];
                whole += w;
            }
        }
        sum / whole
    }

    #[test]
    fn every_pixel_is_the_mean_on_every_instruction_set_and_thread_count() {
        for ([w, h, n], [dw, dh]) in [
            ([7, 5, 1], [3, 2]),
            ([8, 6, 3], [4, 3]),
            ([301, 40, 4], [97, 13]),
            ([12, 9, 5], [12, 1]),
            ([9, 9, 2], [2, 9]),
        ] {
            let data: Vec<f64> = (0..w * h * n).map(|i| (i * 7919 % 1009) as f64).collect();
            let source = Rows::new(&data, w, h, n, w * n).unwrap();
            let scale = [w as f64 / dw as f64, h as f64 / dh as f64];
            let mut first = None;
            for isa in Isa::available() {
                for threads in [1, 3] {
                    let mut out = vec![0.0; dw * dh * n];
                    let run = || with_isa(isa, || area(&source, [dw, dh], scale, &mut out));
                    par::with_threads(Some(threads), run).unwrap().unwrap();
                    assert!(first.get_or_insert_with(|| out.clone()) == &out);
                }
            }
            for (i, v) in first.unwrap().into_iter().enumerate() {
                let at = [i / n % dw, i / n / dw, i % n];
                let want = mean(&data, [w, h, n], scale, at);
                // A share below 1/1000 may be missing on each side of both axes.
                assert!((v - want).abs() < 4e-3 * 1009.0 && ((v - want).abs() < 1e-9 || w > 100), "{at:?}");
            }
        }
    }

    #[test]
    fn wrong_sizes_are_refused() {
        let source = Rows::new(&[1u8; 12], 4, 3, 1, 4).unwrap();
        let mut out = [0; 2];
        assert!(area(&source, [2, 1], [2.0, 3.0], &mut out).is_ok() && out == [1, 1]);
        assert!(area(&source, [2, 2], [2.0, 1.5], &mut out).is_err());
        assert!(area(&source, [2, 1], [0.5, 3.0], &mut out).is_err());
        assert!(area(&source, [2, 1], [f64::NAN, 3.0], &mut out).is_err());
    }
}
