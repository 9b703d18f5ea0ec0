//! `pyrDown` and `pyrUp`: halving and doubling with the binomial weights (1, 4, 6, 4, 1) / 16.
//!
//! ```text
//! down  out(x, y) = sum_ij w_i w_j in(2x + i - 2, 2y + j - 2) / 256
//! up    the same weights times 4 over the picture with zeros between its pixels: along an axis
//!       out(2x) = (in(x-1) + 6 in(x) + in(x+1)) / 8, out(2x + 1) = (in(x) + in(x+1)) / 2
//! ```
//!
//! Integers are summed exactly and divided once, halves up. Source of the weights: Burt and Adelson, The
//! Laplacian pyramid as a compact image code, 1983. Columns are summed before rows: both passes then run over
//! neighbouring elements, whatever the number of channels; every second pixel of the result is kept.

use super::Rows;
use crate::error::{Error, Result};
use crate::kernel::{Isa, compiled_for};
use crate::par;
use crate::wrap::Wrap;
use half::f16;

/// Elements of output that a thread takes at a time, about.
const BAND: usize = 1 << 15;

/// An element that pyramids are made of.
pub trait Element: Copy + Default + Send + Sync + 'static {
    /// Holds 256 times the largest element, and half of that step.
    type Sum: Copy + Default + Send + Sync;
    /// `a + e + 4 (b + d) + 6 c`
    fn five(v: [Self::Sum; 5]) -> Self::Sum;
    /// `a + 6 b + c`
    fn three(v: [Self::Sum; 3]) -> Self::Sum;
    /// `(a + b) + (c + d)`
    fn four(v: [Self::Sum; 4]) -> Self::Sum;
    /// `4 (a + b)`
    fn two(v: [Self::Sum; 2]) -> Self::Sum;
    /// The element as a sum.
    fn wide(self) -> Self::Sum;
    /// The sum over `2^BITS`, rounded to nearest, halves up.
    fn narrow<const BITS: u32>(sum: Self::Sum) -> Self;
}

macro_rules! element {
    ($($t:ty, $sum:ty, |$s:ident| $wide:expr, |$n:ident, $bits:ident| $narrow:expr;)+) => {$(
        impl Element for $t {
            type Sum = $sum;
            #[inline(always)]
            fn five([a, b, c, d, e]: [$sum; 5]) -> $sum {
                a + e + (b + d) * (4 as $sum) + c * (6 as $sum)
            }
            #[inline(always)]
            fn three([a, b, c]: [$sum; 3]) -> $sum {
                a + c + b * (6 as $sum)
            }
            #[inline(always)]
            fn four([a, b, c, d]: [$sum; 4]) -> $sum {
                (a + b) + (c + d)
            }
            #[inline(always)]
            fn two([a, b]: [$sum; 2]) -> $sum {
                (a + b) * (4 as $sum)
            }
            #[inline(always)]
            fn wide(self) -> $sum {
                let $s = self;
                $wide
            }
            #[inline(always)]
            fn narrow<const $bits: u32>($n: $sum) -> $t {
                $narrow
            }
        }
    )+};
}

element! {
    // 255 * 256 + 128 fits.
    u8, u16, |s| u16::from(s), |n, BITS| ((n + (1 << (BITS - 1))) >> BITS) as u8;
    u16, i32, |s| i32::from(s), |n, BITS| ((n + (1 << (BITS - 1))) >> BITS) as u16;
    i16, i32, |s| i32::from(s), |n, BITS| ((n + (1 << (BITS - 1))) >> BITS) as i16;
    f16, f32, |s| s.to_f32(), |n, BITS| f16::from_f32(n * (1.0 / (1u32 << BITS) as f32));
    f32, f32, |s| s, |n, BITS| n * (1.0 / (1u32 << BITS) as f32);
    f64, f64, |s| s, |n, BITS| n * (1.0 / f64::from(1u32 << BITS));
}

/// Whether `pyrDown` makes `n` pixels of `m`: half of them, one less or one more.
pub fn down_fits(m: usize, n: usize) -> bool {
    n > 0 && (2 * n).abs_diff(m) <= 2
}

/// Whether `pyrUp` makes `n` pixels of `m`: twice as many, or an odd number next to it.
pub fn up_fits(m: usize, n: usize) -> bool {
    n > 0 && n.abs_diff(2 * m) == n % 2
}

fn checked(source: [usize; 2], size: [usize; 2], fits: fn(usize, usize) -> bool, rule: &str) -> Result<()> {
    if size[0] > 1 << 31 || size[1] > 1 << 31 || !fits(source[0], size[0]) || !fits(source[1], size[1]) {
        let got = format!("{} x {} from {} x {}", size[0], size[1], source[0], source[1]);
        return Err(Error::value("dstsize", got, rule));
    }
    Ok(())
}

fn output_fits(len: usize, width: usize, height: usize, channels: usize) -> Result<()> {
    let want = width.checked_mul(height).and_then(|n| n.checked_mul(channels));
    if want != Some(len) {
        return Err(Error::value(
            "dst",
            format!("{len} elements"),
            format!("{width} x {height} x {channels}"),
        ));
    }
    Ok(())
}

/// Bands of whole rows over threads; one band stays on the calling thread.
fn bands<T: Send>(
    out: &mut [T],
    row: usize,
    step: usize,
    work: impl Fn(usize, &mut [T]) + Sync,
) -> Result<()> {
    let rows = (BAND / row).max(1).next_multiple_of(step);
    let tiles = out.chunks_mut(rows * row);
    if tiles.len() == 1 {
        tiles.into_iter().for_each(|out| work(0, out));
        return Ok(());
    }
    par::for_each(tiles, |i, out| {
        work(i * rows, out);
        Ok(())
    })
}

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
            compiled_for(isa, || {
                let inner = &mut sums[2 * channels..];
                add(five, inner, T::five);
                outer(&mut sums, channels, src.width, &columns);
                smooth::<T>(&sums, channels, &mut fine);
                every_second(&fine, channels, out);
            });
            if let Some(last) = &last {
                for (c, out) in out[row - channels..].iter_mut().enumerate() {
                    let taps = std::array::from_fn(|k| sums[(last[k] + 2) * channels + c]);
                    *out = T::narrow::<8>(T::five(taps));
                }
            }
        }
    })
}

/// Fills `out`, `size` = (width, height) packed pixels, with the picture at twice its size. Beyond its first row
/// and column the picture is mirrored about them, the last ones go on; what lies beyond twice the size repeats.
///
/// # Errors
/// [`Error::Value`] where a side of `size` is neither twice the picture's side nor odd and next to that; for
/// `out` of another size.
pub fn up<T: Element>(src: Rows<'_, T>, size: [usize; 2], out: &mut [T]) -> Result<()> {
    checked([src.width, src.height], size, up_fits, "twice each side, or an odd number next to it")?;
    let ([width, height], channels) = (size, src.channels);
    output_fits(out.len(), width, height, channels)?;
    let isa = Isa::current();
    let row = width * channels;
    let last = src.height - 1;
    bands(out, row, 2, |first, out| {
        let mut sums = vec![T::Sum::default(); (src.width + 2) * channels];
        let mut halves = [vec![T::default(); src.width * channels], vec![T::default(); src.width * channels]];
        for (y, out) in out.chunks_exact_mut(row).enumerate() {
            // A row beyond twice the size repeats the last even one.
            let y = if first + y == 2 * src.height { first + y - 2 } else { first + y };
            let at = y / 2;
            let below = src.row((at + 1).min(last));
            compiled_for(isa, || {
                let inner = &mut sums[channels..];
                if y % 2 == 0 {
                    let above = src.row(if at == 0 { 1.min(last) } else { at - 1 });
                    add([above, src.row(at), below], inner, T::three);
                } else {
                    add([src.row(at), below], inner, T::two);
                }
                let n = src.width * channels;
                sums.copy_within(
                    if src.width > 1 { 2 * channels..3 * channels } else { channels..2 * channels },
                    0,
                );
                sums.copy_within(n..n + channels, n + channels);
                let (even, odd) = halves.split_at_mut(1);
                for (i, (even, odd)) in even[0].iter_mut().zip(&mut odd[0]).enumerate() {
                    let (a, b, c) = (sums[i], sums[i + channels], sums[i + 2 * channels]);
                    *even = T::narrow::<6>(T::three([a, b, c]));
                    *odd = T::narrow::<6>(T::two([b, c]));
                }
                interleave(&halves[0], &halves[1], channels, out);
            });
        }
    })
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

/// Combines rows element by element.
#[inline(always)]
fn add<T: Element, const N: usize>(
    mut rows: [&[T]; N],
    out: &mut [T::Sum],
    sum: impl Fn([T::Sum; N]) -> T::Sum,
) {
    let n = rows[0].len().min(out.len());
    for row in &mut rows {
        *row = &row[..n];
    }
    for (i, out) in out[..n].iter_mut().enumerate() {
        // Not by `map`: it is a call of its own for every element here.
        let mut taps = [T::Sum::default(); N];
        for (tap, row) in taps.iter_mut().zip(&rows) {
            *tap = row[i].wide();
        }
        *out = sum(taps);
    }
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

/// Calls `$work` with the number of channels as a constant where it is small.
macro_rules! with_channels {
    ($channels:expr, $work:ident, $any:expr) => {
        match $channels {
            1 => $work!(1),
            2 => $work!(2),
            3 => $work!(3),
            4 => $work!(4),
            _ => $any,
        }
    };
}

#[inline(always)]
fn every_second<T: Copy>(fine: &[T], channels: usize, out: &mut [T]) {
    macro_rules! fixed {
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

/// Pixels of two rows in turn; a last one that finds none repeats the one before.
#[inline(always)]
fn interleave<T: Copy>(even: &[T], odd: &[T], channels: usize, out: &mut [T]) {
    macro_rules! fixed {
        ($n:literal) => {{
            let (even, odd) = (even.as_chunks::<$n>().0, odd.as_chunks::<$n>().0);
            let (pairs, rest) = out.as_chunks_mut::<$n>().0.as_chunks_mut::<2>();
            for ((pair, even), odd) in pairs.iter_mut().zip(even).zip(odd) {
                *pair = [*even, *odd];
            }
            if let (Some(rest), Some(before)) = (rest.first_mut(), even.get(pairs.len()).or(odd.last())) {
                *rest = *before;
            }
        }};
    }
    with_channels!(channels, fixed, {
        let last = even.len() / channels - 1;
        for (x, out) in out.chunks_exact_mut(channels).enumerate() {
            let row = if x % 2 == 0 && x / 2 <= last { even } else { odd };
            let at = (x / 2).min(last) * channels;
            out.copy_from_slice(&row[at..at + channels]);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::with_isa;

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

    #[test]
    fn constants_stay_and_wrong_sizes_are_refused() {
        let data = [77u8; 35];
        let src = Rows::new(&data, 7, 5, 1, 7).unwrap();
        for size in [[14, 10], [13, 9], [15, 11]] {
            let mut out = vec![0; size[0] * size[1]];
            up(src, size, &mut out).unwrap();
            assert!(out.iter().all(|&v| v == 77));
        }
        let mut out = vec![0; 12];
        down(src, Wrap::Mirror101, [4, 3], &mut out).unwrap();
        assert_eq!(out, [77; 12]);
        assert!(down(src, Wrap::Border, [4, 3], &mut out).is_err());
        assert!(down(src, Wrap::Clamp, [4, 3], &mut out[1..]).is_err());
        assert!(down(src, Wrap::Clamp, [6, 2], &mut out).is_err());
        assert!(up(src, [12, 1], &mut out).is_err());
        assert!(Rows::new(&data, 7, 6, 1, 7).is_err() && Rows::new(&data, 7, 5, 1, 6).is_err());
        assert!(Rows::new(&data, usize::MAX, 2, 2, 7).is_err() && Rows::new(&data, 0, 5, 1, 7).is_err());
    }
}
