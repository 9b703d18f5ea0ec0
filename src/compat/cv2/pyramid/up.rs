//! Doubling.

use super::super::Rows;
use super::{Element, add, bands, checked, output_fits, up_fits};
use crate::error::Result;
use crate::kernel::{Isa, Work, compiled_for};

/// Fills `out`, `size` = (width, height) packed pixels, with the picture at twice its size. Beyond its first row
/// and column the picture is mirrored about them, the last ones go on; what lies beyond twice the size repeats.
///
/// # Errors
/// [`Error::Value`](crate::Error::Value) where a side of `size` is neither twice the picture's side nor odd and next to that; for
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
            let above = src.row(if at == 0 { 1.min(last) } else { at - 1 });
            let rows = [above, src.row(at), below];
            let (sums, halves) = (&mut sums, &mut halves);
            compiled_for(isa, Doubled { rows, channels, odd: y % 2 == 1, sums, halves, out });
        }
    })
}

/// One row of the output, to be compiled for an instruction set.
struct Doubled<'a, T: Element> {
    /// Above, at and below it.
    rows: [&'a [T]; 3],
    channels: usize,
    /// Whether it lies between two rows.
    odd: bool,
    /// A row of sums, with a pixel more on either side.
    sums: &'a mut [T::Sum],
    /// Room for its even and its odd pixels.
    halves: &'a mut [Vec<T>; 2],
    out: &'a mut [T],
}

impl<T: Element> Work for Doubled<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { rows: [above, here, below], channels, odd, sums, halves, out } = self;
        let n = here.len();
        let inner = &mut sums[channels..];
        if odd {
            add([here, below], inner, T::two);
        } else {
            add([above, here, below], inner, T::three);
        }
        // The column before the first is the second, the one behind the last that again.
        let mirrored = if n > channels { 2 * channels } else { channels };
        sums.copy_within(mirrored..mirrored + channels, 0);
        sums.copy_within(n..n + channels, n + channels);
        let (a, b, c) = (&sums[..n], &sums[channels..][..n], &sums[2 * channels..][..n]);
        let [evens, odds] = halves;
        let (evens, odds) = (&mut evens[..n], &mut odds[..n]);
        for i in 0..n {
            evens[i] = T::narrow::<6>(T::three([a[i], b[i], c[i]]));
        }
        for i in 0..n {
            odds[i] = T::narrow::<6>(T::two([b[i], c[i]]));
        }
        interleave(evens, odds, channels, out);
    }
}

/// Pixels of two rows in turn; a last one that finds none repeats the one before. Three numbers are copied as four: the
/// next pixel puts the last right.
#[inline(always)]
fn interleave<T: Copy>(even: &[T], odd: &[T], channels: usize, out: &mut [T]) {
    macro_rules! fixed {
        (3) => {{
            let last = out.len() / 3 - 1;
            // All but the last pixel have a number behind them.
            let pairs = last.min(2 * (even.len() / 3 - 1)) / 2 * 2;
            for x in (0..pairs).step_by(2) {
                let from = 3 * (x / 2);
                out[3 * x..3 * x + 4].copy_from_slice(&even[from..from + 4]);
                out[3 * x + 3..3 * x + 7].copy_from_slice(&odd[from..from + 4]);
            }
            singly(even, odd, 3, pairs, out);
        }};
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
    with_channels!(channels, fixed, singly(even, odd, channels, 0, out));
}

/// [`interleave`] from pixel `first` on.
#[inline(always)]
fn singly<T: Copy>(even: &[T], odd: &[T], channels: usize, first: usize, out: &mut [T]) {
    let last = even.len() / channels - 1;
    for (x, out) in out.chunks_exact_mut(channels).enumerate().skip(first) {
        // Beyond twice the size, the last pixel of all again.
        let row = if x % 2 == 0 && x / 2 <= last { even } else { odd };
        let at = (x / 2).min(last) * channels;
        out.copy_from_slice(&row[at..at + channels]);
    }
}
