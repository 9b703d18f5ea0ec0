//! Halving.

use super::super::Rows;
use super::{Element, add, bands, checked, down_fits, output_fits};
use crate::error::{Error, Result};
use crate::kernel::{Isa, Work, compiled_for};
use crate::wrap::Wrap;

/// Fills `out`, `size` = (width, height) packed pixels, with the picture at half its size. Beyond its sides the
/// picture goes on by `wrap`. As in OpenCV, a column more than half of an even width shows the last column.
///
/// # Errors
/// [`Error::Value`] where a side of `size` is not half of the picture's side, or one pixel off; for
/// [`Wrap::Border`] and [`Wrap::Extend`], which show no pixel of the picture; for `out` of another size.
pub fn down<T: Element>(src: Rows<'_, T>, wrap: Wrap, size: [usize; 2], out: &mut [T]) -> Result<()> {
    checked([src.width, src.height], size, down_fits, "half of each side, or one pixel more or less")?;
    let ([width, height], channels) = (size, src.channels);
    output_fits(out.len(), width, height, channels)?;
    // Column 2 (width - 1) + 2 is the last that is read.
    let columns = indices(wrap, -2, 2 * width + 3, src.width)?;
    let rows = indices(wrap, -2, 2 * height + 3, src.height)?;
    // One column more than half of an even width: OpenCV centres it on the last column, not beyond it.
    let last = if src.width >= 4 && 2 * (width - 1) == src.width {
        Some(indices(wrap, src.width as i64 - 3, 5, src.width)?)
    } else {
        None
    };
    let isa = Isa::current();
    let row = width * channels;
    let wide = (2 * width + 3).max(src.width + 2) * channels;
    bands(out, row, 1, |first, out| {
        let mut sums = vec![T::Sum::default(); wide];
        let mut fine = vec![T::default(); (2 * width - 1) * channels];
        for (y, out) in out.chunks_exact_mut(row).enumerate() {
            let five: [&[T]; 5] = std::array::from_fn(|j| src.row(rows[2 * (first + y) + j]));
            let halved = Halved {
                five,
                channels,
                columns: &columns,
                sums: &mut sums,
                fine: &mut fine,
                out: &mut *out,
            };
            compiled_for(isa, halved);
            if let Some(last) = &last {
                for (c, out) in out[row - channels..].iter_mut().enumerate() {
                    let taps = std::array::from_fn(|k| sums[(last[k] + 2) * channels + c]);
                    *out = T::narrow::<8>(T::five(taps));
                }
            }
        }
    })
}

/// One row of the output, to be compiled for an instruction set.
struct Halved<'a, T: Element> {
    five: [&'a [T]; 5],
    channels: usize,
    /// The picture's columns, from two before it on.
    columns: &'a [usize],
    /// A row of sums, from two pixels before the picture on.
    sums: &'a mut [T::Sum],
    /// Room for all its pixels.
    fine: &'a mut [T],
    out: &'a mut [T],
}

impl<T: Element> Work for Halved<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { five, channels, columns, sums, fine, out } = self;
        add(five, &mut sums[2 * channels..], T::five);
        outer(sums, channels, five[0].len() / channels, columns);
        smooth::<T>(sums, channels, fine);
        every_second(fine, channels, out);
    }
}

/// The picture's index for each of `count` places from `first` on.
fn indices(wrap: Wrap, first: i64, count: usize, n: usize) -> Result<Vec<usize>> {
    let refused = || Error::value("borderType", wrap.name(), "a mode that shows pixels of the picture");
    if matches!(wrap, Wrap::Border | Wrap::Extend) {
        return Err(refused());
    }
    (0..count as i64)
        .map(|i| wrap.index(first + i, n as i64).map(|i| i as usize).ok_or_else(refused))
        .collect()
}

/// Fills the columns outside the picture; the sums start two columns before it.
#[inline(always)]
fn outer<S: Copy>(sums: &mut [S], channels: usize, width: usize, columns: &[usize]) {
    for (i, &column) in columns.iter().enumerate() {
        // Inside, the picture's own column stands there already.
        if i < 2 || i >= width + 2 {
            let from = (column + 2) * channels;
            sums.copy_within(from..from + channels, i * channels);
        }
    }
}

/// The five-tap mean at every pixel between the sums' outer two.
#[inline(always)]
fn smooth<T: Element>(sums: &[T::Sum], channels: usize, out: &mut [T]) {
    let n = out.len();
    let at: [&[T::Sum]; 5] = std::array::from_fn(|k| &sums[k * channels..][..n]);
    for (i, out) in out.iter_mut().enumerate() {
        *out = T::narrow::<8>(T::five([at[0][i], at[1][i], at[2][i], at[3][i], at[4][i]]));
    }
}

/// Every second pixel. Three numbers are copied as four: the next pixel puts the last right.
#[inline(always)]
fn every_second<T: Copy>(fine: &[T], channels: usize, out: &mut [T]) {
    macro_rules! fixed {
        (3) => {{
            let last = out.len() - 3;
            for (from, to) in (0..).step_by(6).zip((0..last).step_by(3)) {
                out[to..to + 4].copy_from_slice(&fine[from..from + 4]);
            }
            out[last..].copy_from_slice(&fine[2 * last..2 * last + 3]);
        }};
        ($n:literal) => {{
            let (fine, out) = (fine.as_chunks::<$n>().0, out.as_chunks_mut::<$n>().0);
            for (out, pixel) in out.iter_mut().zip(fine.iter().step_by(2)) {
                *out = *pixel;
            }
        }};
    }
    with_channels!(channels, fixed, {
        for (out, pixel) in out.chunks_exact_mut(channels).zip(fine.chunks_exact(channels).step_by(2)) {
            out.copy_from_slice(pixel);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::with_isa;
    use crate::par;

    /// The definitions, pixel by pixel.
    fn down_plainly(src: &Rows<'_, i16>, wrap: Wrap, at: [usize; 3]) -> i16 {
        let weights = [1, 4, 6, 4, 1];
        let [x, y, c] = at;
        let mut sum = 0;
        for (j, wj) in weights.iter().enumerate() {
            for (i, wi) in weights.iter().enumerate() {
                let place = |at: usize, k: usize, n: usize| {
                    wrap.index((2 * at + k) as i64 - 2, n as i64).unwrap() as usize
                };
                let pixel = src.row(place(y, j, src.height))[place(x, i, src.width) * src.channels + c];
                sum += wi * wj * i32::from(pixel);
            }
        }
        ((sum + 128) >> 8) as i16
    }

    #[test]
    fn every_pixel_is_the_weighted_sum_on_every_instruction_set_and_thread_count() {
        for (w, h, n) in [(1, 1, 1), (5, 1, 2), (1, 7, 3), (9, 6, 4), (33, 70, 1), (301, 260, 5)] {
            let data: Vec<i16> = (0..w * h * n).map(|i| (i * 7919 % 65_536) as u16 as i16).collect();
            let src = Rows::new(&data, w, h, n, w * n).unwrap();
            let size = [w.div_ceil(2), h.div_ceil(2)];
            for wrap in [Wrap::Clamp, Wrap::Mirror, Wrap::Repeat, Wrap::Mirror101] {
                let mut first = None;
                for isa in Isa::available() {
                    for threads in [1, 3] {
                        let mut out = vec![0; size[0] * size[1] * n];
                        par::with_threads(Some(threads), || {
                            with_isa(isa, || down(src, wrap, size, &mut out))
                        })
                        .unwrap()
                        .unwrap();
                        assert!(first.get_or_insert_with(|| out.clone()) == &out);
                    }
                }
                let out = first.unwrap();
                for (i, &v) in out.iter().enumerate().step_by(if w > 100 { 97 } else { 1 }) {
                    let at = [i / n % size[0], i / n / size[0], i % n];
                    assert_eq!(v, down_plainly(&src, wrap, at), "{w} x {h} x {n} {wrap:?} {at:?}");
                }
            }
        }
    }
}
