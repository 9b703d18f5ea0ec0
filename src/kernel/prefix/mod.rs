//! Prefix sums of rows and sums of columns: what summed-area tables are made of.
//!
//! A table's row is the row above plus the running sum of the texels to the left, added in that order, so the
//! order of additions is fixed. The loops are plain Rust, compiled for each instruction set: a texel's channels are
//! the lanes of a vector, and memory is what they wait for.

use super::{Isa, Work, compiled_for};
use half::f16;

/// A number that sums of `T` are kept in.
pub trait Sum<T>: Copy + Default {
    /// The number to add for a texel; `offset` has been taken off it where sums are rounded.
    fn term(texel: T, offset: Self) -> Self;
    /// `self + other`; integers are chosen wide enough.
    fn plus(self, other: Self) -> Self;
}

macro_rules! integer_sum {
    ($($texel:ty => $sum:ty),+) => {$(
        impl Sum<$texel> for $sum {
            #[inline(always)]
            fn term(texel: $texel, _offset: Self) -> Self {
                Self::from(texel)
            }
            #[inline(always)]
            fn plus(self, other: Self) -> Self {
                self.wrapping_add(other)
            }
        }
    )+};
}
integer_sum!(u8 => u32, u8 => u64, u16 => u64, u8 => i32);

macro_rules! float_sum {
    ($($texel:ty),+) => {$(
        impl Sum<$texel> for f64 {
            #[inline(always)]
            fn term(texel: $texel, offset: Self) -> Self {
                f64::from(texel) - offset
            }
            #[inline(always)]
            fn plus(self, other: Self) -> Self {
                self + other
            }
        }
    )+};
}
float_sum!(u8, u16, i16, f16, f32, f64);

/// One row of a table: `out[0..C] = 0`, and behind texel `i` the row above there plus the sum of texels
/// `0..=i`. `above` and `out` have `C` elements more than `texels`; `C = offset.len()`.
pub fn row<T: Copy + Default, S: Sum<T>>(isa: Isa, texels: &[T], offset: &[S], above: &[S], out: &mut [S]) {
    compiled_for(isa, RowOf { texels, offset, above, out });
}

struct RowOf<'a, T, S> {
    texels: &'a [T],
    offset: &'a [S],
    above: &'a [S],
    out: &'a mut [S],
}

impl<T: Copy + Default, S: Sum<T>> Work for RowOf<'_, T, S> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        match self.offset.len() {
            1 => self.single(),
            2 => self.counted::<2, 2>(),
            3 => self.counted::<3, 4>(),
            4 => self.counted::<4, 4>(),
            channels => {
                self.out[..channels].fill(S::default());
                for (c, &offset) in self.offset.iter().enumerate() {
                    let mut run = S::default();
                    for i in (c..self.texels.len()).step_by(channels) {
                        run = run.plus(S::term(self.texels[i], offset));
                        self.out[i + channels] = self.above[i + channels].plus(run);
                    }
                }
            }
        }
    }
}

impl<T: Copy + Default, S: Sum<T>> RowOf<'_, T, S> {
    #[inline(always)]
    fn single(self) {
        let (Some((first, out)), Some((_, above))) = (self.out.split_first_mut(), self.above.split_first())
        else {
            return;
        };
        let (mut run, offset) = (S::default(), self.offset[0]);
        *first = run;
        for ((&texel, &above), out) in self.texels.iter().zip(above).zip(out) {
            run = run.plus(S::term(texel, offset));
            *out = above.plus(run);
        }
    }

    /// `C` channels, which are read and written `L` at a time: what a store carries beyond a texel is written over by
    /// the next.
    #[inline(always)]
    fn counted<const C: usize, const L: usize>(self) {
        let offset: [S; L] = std::array::from_fn(|c| self.offset.get(c).copied().unwrap_or_default());
        let mut run = [S::default(); L];
        self.out[..C].fill(S::default());
        let count = self.texels.len() / C;
        // All but the last texel have `L` elements from their first on.
        let whole = if C == L { count } else { count.saturating_sub(1) };
        let (Some(above), Some(out)) = (self.above.get(C..), self.out.get_mut(C..)) else { return };
        for i in 0..whole {
            let at = i * C;
            let (Some(texel), Some(above), Some(out)) =
                (self.texels.get(at..at + L), above.get(at..at + L), out.get_mut(at..at + L))
            else {
                return;
            };
            // All sums before any store, so that they are one vector.
            run = std::array::from_fn(|c| run[c].plus(S::term(texel[c], offset[c])));
            let sums: [S; L] = std::array::from_fn(|c| above[c].plus(run[c]));
            out.copy_from_slice(&sums);
        }
        for i in whole * C..count * C {
            let c = i % C;
            run[c] = run[c].plus(S::term(self.texels[i], offset[c]));
            out[i] = above[i].plus(run[c]);
        }
    }
}

/// Adds a row of texels, element by element, to sums of columns.
pub fn add_columns<T: Copy, S: Sum<T>>(isa: Isa, texels: &[T], sums: &mut [S]) {
    compiled_for(isa, || {
        for (sum, texel) in sums.iter_mut().zip(texels) {
            *sum = sum.plus(S::term(*texel, S::default()));
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_running_sums_at_any_number_of_channels() {
        for channels in 1..=6usize {
            let texels: Vec<u8> = (0..channels * 9).map(|i| (i * 89 % 251) as u8).collect();
            let above: Vec<u32> = (0..channels * 10).map(|i| (i * i) as u32).collect();
            for isa in Isa::available() {
                let mut out = vec![9u32; channels * 10];
                row(isa, &texels, &vec![0; channels], &above, &mut out);
                for (i, &v) in out.iter().enumerate() {
                    let run: u32 =
                        (0..i / channels).map(|t| u32::from(texels[t * channels + i % channels])).sum();
                    let above = if i < channels { 0 } else { above[i] };
                    assert_eq!(v, above + run, "{isa:?} {channels} channels, element {i}");
                }
            }
        }
    }
}
