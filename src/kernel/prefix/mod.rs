//! Prefix sums of rows and sums of columns: what summed-area tables are made of.
//!
//! A table's row is the row above plus the running sum of the texels to the left, added in that order, so the
//! order of additions is fixed. The loops are plain Rust: they wait for memory, not for arithmetic.

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
integer_sum!(u8 => u32, u8 => u64, u16 => u64);

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
float_sum!(f16, f32, f64);

/// One row of a table: `out[0..C] = 0`, and behind texel `i` the row above there plus the sum of texels
/// `0..=i`. `above` and `out` have `C` elements more than `texels`; `C = offset.len()`.
pub fn row<T: Copy, S: Sum<T>>(texels: &[T], offset: &[S], above: &[S], out: &mut [S]) {
    match offset.len() {
        1 => row_of::<T, S, 1>(texels, offset, above, out),
        2 => row_of::<T, S, 2>(texels, offset, above, out),
        3 => row_of::<T, S, 3>(texels, offset, above, out),
        4 => row_of::<T, S, 4>(texels, offset, above, out),
        channels => {
            out[..channels].fill(S::default());
            for (c, &offset) in offset.iter().enumerate() {
                let mut run = S::default();
                for i in (c..texels.len()).step_by(channels) {
                    run = run.plus(S::term(texels[i], offset));
                    out[i + channels] = above[i + channels].plus(run);
                }
            }
        }
    }
}

fn row_of<T: Copy, S: Sum<T>, const C: usize>(texels: &[T], offset: &[S], above: &[S], out: &mut [S]) {
    let mut run = [S::default(); C];
    let offset: [S; C] = std::array::from_fn(|c| offset[c]);
    let (texels, _) = texels.as_chunks::<C>();
    let (above, _) = above.as_chunks::<C>();
    let (out, _) = out.as_chunks_mut::<C>();
    let Some((first, out)) = out.split_first_mut() else { return };
    *first = run;
    for ((texel, above), out) in texels.iter().zip(&above[1..]).zip(out) {
        for c in 0..C {
            run[c] = run[c].plus(S::term(texel[c], offset[c]));
            out[c] = above[c].plus(run[c]);
        }
    }
}

/// Adds a row of texels, element by element, to sums of columns.
pub fn add_columns<T: Copy, S: Sum<T>>(texels: &[T], sums: &mut [S]) {
    for (sum, texel) in sums.iter_mut().zip(texels) {
        *sum = sum.plus(S::term(*texel, S::default()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_running_sums_at_any_number_of_channels() {
        for channels in 1..=6usize {
            let texels: Vec<u8> = (0..channels * 9).map(|i| (i * 89 % 251) as u8).collect();
            let above: Vec<u32> = (0..channels * 10).map(|i| (i * i) as u32).collect();
            let mut out = vec![9u32; channels * 10];
            row(&texels, &vec![0; channels], &above, &mut out);
            for (i, &v) in out.iter().enumerate() {
                let run: u32 =
                    (0..i / channels).map(|t| u32::from(texels[t * channels + i % channels])).sum();
                let above = if i < channels { 0 } else { above[i] };
                assert_eq!(v, above + run, "{channels} channels, element {i}");
            }
        }
    }
}
