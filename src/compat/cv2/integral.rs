//! `integral`: sums over all pixels above and left of a corner, of the pixels, of their squares, and over
//! triangles that stand on their tip.
//!
//! ```text
//! sum(X, Y)    = sum of in(x, y),   x < X, y < Y
//! square(X, Y) = sum of in(x, y)^2, x < X, y < Y
//! tilted(X, Y) = sum of in(x, y),   y < Y, |x - X + 1| <= Y - y - 1
//! ```
//!
//! Each table has a row and a column more than the picture. Integers wrap, as there is no error in OpenCV; all
//! other tables are summed in doubles, also those that are stored in singles. Source of the tilted sums, and of
//! their recurrence: Lienhart and Maydt, An extended set of Haar-like features, 2002.

use super::Rows;
use crate::error::{Error, Result};
use crate::kernel::cast::same_mut;
use crate::kernel::{Isa, compiled_for, prefix};
use half::f16;

/// What sums are kept in.
pub trait Sum: Copy + Default + 'static {
    /// `self + other`
    fn plus(self, other: Self) -> Self;
    /// `self - other`
    fn minus(self, other: Self) -> Self;
    /// `self * self`
    fn square(self) -> Self;
}

impl Sum for i32 {
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self.wrapping_add(other)
    }
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self.wrapping_sub(other)
    }
    #[inline(always)]
    fn square(self) -> Self {
        self.wrapping_mul(self)
    }
}

impl Sum for f64 {
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self + other
    }
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self - other
    }
    #[inline(always)]
    fn square(self) -> Self {
        self * self
    }
}

/// An element that is summed in `S`.
pub trait Term<S>: Copy {
    /// The element as a sum.
    fn term(self) -> S;
    /// A row of a table of sums of elements, as [`prefix::row`] makes it; `zeros` has one number a channel.
    fn row(isa: Isa, texels: &[Self], zeros: &[S], above: &[S], out: &mut [S]);
}

/// What a table of sums kept in `S` is stored in.
pub trait Stored<S>: Copy + Default + 'static {
    /// The sum, rounded.
    fn stored(sum: S) -> Self;
}

macro_rules! terms {
    ($($t:ty => $sum:ty),+) => {$(
        impl Term<$sum> for $t {
            #[inline(always)]
            fn term(self) -> $sum {
                <$sum>::from(self)
            }
            fn row(isa: Isa, texels: &[Self], zeros: &[$sum], above: &[$sum], out: &mut [$sum]) {
                prefix::row(isa, texels, zeros, above, out);
            }
        }
    )+};
}
terms!(u8 => i32, u8 => f64, u16 => f64, i16 => f64, f16 => f64, f32 => f64, f64 => f64);

impl Stored<i32> for i32 {
    #[inline(always)]
    fn stored(sum: i32) -> Self {
        sum
    }
}

impl Stored<f64> for f64 {
    #[inline(always)]
    fn stored(sum: f64) -> Self {
        sum
    }
}

impl Stored<f64> for f32 {
    #[inline(always)]
    fn stored(sum: f64) -> Self {
        sum as f32
    }
}

fn table_fits<T>(argument: &'static str, src: &Rows<'_, T>, len: usize) -> Result<()> {
    let want = src.height.checked_add(1).zip(src.width.checked_add(1));
    let want = want.and_then(|(h, w)| h.checked_mul(w)?.checked_mul(src.channels));
    if want != Some(len) {
        let expected = format!("({} + 1) x ({} + 1) x {}", src.width, src.height, src.channels);
        return Err(Error::value(argument, format!("{len} elements"), expected));
    }
    Ok(())
}

/// Sums of the pixels, or with `SQUARE` of their squares, kept in `S` and stored in `O`.
///
/// # Errors
/// [`Error::Value`] for a table of another size.
pub fn upright<T: Term<S>, S: Sum, O: Stored<S>, const SQUARE: bool>(
    src: Rows<'_, T>,
    out: &mut [O],
) -> Result<()> {
    table_fits("sum", &src, out.len())?;
    let isa = Isa::current();
    if let (false, Some(out)) = (SQUARE, same_mut::<O, S>(out)) {
        let row = (src.width + 1) * src.channels;
        let zeros = vec![S::default(); src.channels];
        let (first, rest) = out.split_at_mut(row);
        first.fill(S::default());
        let mut above: &[S] = first;
        for (y, out) in rest.chunks_exact_mut(row).enumerate() {
            T::row(isa, src.row(y), &zeros, above, out);
            above = out;
        }
        return Ok(());
    }
    match src.channels {
        1 => compiled_for(isa, || upright_of::<T, S, O, SQUARE, 1>(src, out)),
        2 => compiled_for(isa, || upright_of::<T, S, O, SQUARE, 2>(src, out)),
        3 => compiled_for(isa, || upright_of::<T, S, O, SQUARE, 3>(src, out)),
        4 => compiled_for(isa, || upright_of::<T, S, O, SQUARE, 4>(src, out)),
        channels => {
            let row = (src.width + 1) * channels;
            let mut above = vec![S::default(); row];
            let (first, rest) = out.split_at_mut(row);
            first.fill(O::default());
            for (y, out) in rest.chunks_exact_mut(row).enumerate() {
                let texels = src.row(y);
                for c in 0..channels {
                    let mut run = S::default();
                    out[c] = O::default();
                    for i in (c..texels.len()).step_by(channels) {
                        run = run.plus(value::<T, S, SQUARE>(texels[i]));
                        above[i] = above[i].plus(run);
                        out[i + channels] = O::stored(above[i]);
                    }
                }
            }
        }
    }
    Ok(())
}

#[inline(always)]
fn value<T: Term<S>, S: Sum, const SQUARE: bool>(texel: T) -> S {
    if SQUARE { texel.term().square() } else { texel.term() }
}

#[inline(always)]
fn upright_of<T: Term<S>, S: Sum, O: Stored<S>, const SQUARE: bool, const C: usize>(
    src: Rows<'_, T>,
    out: &mut [O],
) {
    let mut above = vec![[S::default(); C]; src.width];
    let (first, rest) = out.as_chunks_mut::<C>().0.split_at_mut(src.width + 1);
    first.fill([O::default(); C]);
    for (y, out) in rest.chunks_exact_mut(src.width + 1).enumerate() {
        let texels = src.row(y).as_chunks::<C>().0;
        let mut run = [S::default(); C];
        out[0] = [O::default(); C];
        for ((texel, above), out) in texels.iter().zip(&mut above).zip(&mut out[1..]) {
            for c in 0..C {
                run[c] = run[c].plus(value::<T, S, SQUARE>(texel[c]));
                above[c] = above[c].plus(run[c]);
                out[c] = O::stored(above[c]);
            }
        }
    }
}

/// Sums over triangles, kept in `S` and stored in `O`.
///
/// With zeros outside the picture, `tilted(X, Y) = tilted(X - 1, Y - 1) + tilted(X + 1, Y - 1) -
/// tilted(X, Y - 2) + in(X - 1, Y - 1) + in(X - 1, Y - 2)`; beyond its columns `tilted(-1, Y) = tilted(0, Y - 1)`
/// and `tilted(W + 1, Y) = tilted(W, Y - 1)`, as the triangles there hold the same pixels.
///
/// # Errors
/// [`Error::Value`] for a table of another size.
pub fn tilted<T: Term<S>, S: Sum, O: Stored<S>>(src: Rows<'_, T>, out: &mut [O]) -> Result<()> {
    table_fits("tilted", &src, out.len())?;
    let (n, row) = (src.channels, (src.width + 1) * src.channels);
    // Rows Y - 2, Y - 1 and Y, with a column more on either side.
    let mut two = vec![S::default(); row + 2 * n];
    let mut one = two.clone();
    let mut now = two.clone();
    let (first, rest) = out.split_at_mut(row);
    first.fill(O::default());
    for (y, out) in rest.chunks_exact_mut(row).enumerate() {
        let here = src.row(y);
        let above = (y > 0).then(|| src.row(y - 1));
        for i in 0..row {
            let mut sum = one[i].plus(one[i + 2 * n]).minus(two[i + n]);
            if i >= n {
                sum = sum.plus(here[i - n].term());
                if let Some(above) = above {
                    sum = sum.plus(above[i - n].term());
                }
            }
            now[i + n] = sum;
            out[i] = O::stored(sum);
        }
        // What the next row reads beyond the columns of this one.
        now[..n].copy_from_slice(&one[n..2 * n]);
        now[row + n..].copy_from_slice(&one[row..row + n]);
        std::mem::swap(&mut two, &mut one);
        std::mem::swap(&mut one, &mut now);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn brute(src: &Rows<'_, u8>, c: usize, inside: impl Fn(i64, i64) -> bool) -> i32 {
        let mut sum = 0;
        for j in 0..src.height {
            for i in 0..src.width {
                if inside(i as i64, j as i64) {
                    sum += i32::from(src.row(j)[i * src.channels + c]);
                }
            }
        }
        sum
    }

    #[test]
    fn tables_are_the_sums_that_they_claim() {
        for (w, h, n) in [(1, 1, 1), (1, 6, 2), (7, 1, 3), (6, 9, 1), (5, 4, 6), (9, 5, 4)] {
            let data: Vec<u8> = (0..h * (w * n + 3)).map(|i| (i * 97 % 251) as u8).collect();
            let src = Rows::new(&data, w, h, n, w * n + 3).unwrap();
            let count = (w + 1) * (h + 1) * n;
            let mut sum = vec![9i32; count];
            let mut lean = vec![9f32; count];
            let mut square = vec![9f64; count];
            upright::<_, i32, i32, false>(src, &mut sum).unwrap();
            upright::<_, f64, f64, true>(src, &mut square).unwrap();
            tilted::<_, f64, f32>(src, &mut lean).unwrap();
            for (i, (&sum, &lean)) in sum.iter().zip(&lean).enumerate() {
                let (x, y, c) = (i / n % (w + 1), i / n / (w + 1), i % n);
                let (x0, y0) = (x as i64, y as i64);
                assert_eq!(sum, brute(&src, c, |i, j| i < x0 && j < y0));
                let cone = |i: i64, j: i64| j < y0 && (i - x0 + 1).abs() < y0 - j;
                assert_eq!(lean, brute(&src, c, cone) as f32, "{w} x {h} x {n}: {x} {y} {c}");
            }
            let all: f64 =
                (0..h).flat_map(|y| src.row(y).iter().step_by(n)).map(|&v| f64::from(v).powi(2)).sum();
            assert_eq!(square[count - n], all);
            assert!(upright::<_, i32, i32, false>(src, &mut sum[1..]).is_err());
            assert!(tilted::<_, f64, f32>(src, &mut lean[1..]).is_err());
        }
    }
}
