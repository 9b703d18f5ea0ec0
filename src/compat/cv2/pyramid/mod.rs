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

use crate::error::{Error, Result};
use crate::par;
use half::f16;

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

mod down;
mod up;

pub use down::down;
pub use up::up;

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

/// Bands of whole rows over threads.
fn bands<T: Send>(
    out: &mut [T],
    row: usize,
    step: usize,
    work: impl Fn(usize, &mut [T]) + Sync,
) -> Result<()> {
    let rows = (BAND / row).max(1).next_multiple_of(step);
    par::for_each(out.chunks_mut(rows * row), |i, out| {
        work(i * rows, out);
        Ok(())
    })
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

#[cfg(test)]
mod tests {
    use super::super::Rows;
    use super::*;
    use crate::wrap::Wrap;

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
