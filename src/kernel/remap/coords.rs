//! Positions, made or taken apart in short blocks that stay in the first-level cache.

use super::sample::Real;
use super::{NOWHERE, Split};
use crate::kernel::{Isa, Work, compiled_for};

/// Positions that a [`Buffer`] holds.
pub const CHUNK: usize = 256;

/// Which positions exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grid {
    /// All.
    Exact,
    /// Whole pixels: the nearest, ties to even.
    Whole,
    /// Multiples of 1/32 pixel: the nearest, ties to even.
    Thirtyseconds,
    /// Multiples of 1/32 pixel as fixed-point affine warps reach them: `m00 x` and `m01 y + m02` are rounded
    /// to 1/1024 one by one, and their sum to 1/32, ties up. Only for matrices; else as `Thirtyseconds`.
    Accumulated,
    /// Whole pixels as fixed-point affine warps reach them: as `Accumulated`, but the sum is rounded to 1. Only
    /// for matrices; else as `Whole`.
    AccumulatedWhole,
}

/// A block of positions, taken apart.
#[derive(Debug)]
pub struct Buffer<A, const N: usize = CHUNK> {
    x: [i32; N],
    y: [i32; N],
    fx: [A; N],
    fy: [A; N],
}

impl<A: Real, const N: usize> Default for Buffer<A, N> {
    fn default() -> Self {
        Self::new()
    }
}

/// Positions beyond this are as good as this: no picture is as large.
const FAR: f64 = 1_073_741_824.0;

/// The nearest multiple of 1/32.
#[inline(always)]
fn thirtysecond(x: f64) -> f64 {
    (x * 32.0).round_ties_even() * (1.0 / 32.0)
}

/// Whole part and fraction; positions further than [`FAR`] are drawn in. NaN and infinity are for the caller.
#[inline(always)]
fn take_apart<A: Real>(x: f64) -> (i32, A) {
    let low = if x > -FAR { x } else { -FAR };
    let near = if low < FAR { low } else { FAR };
    let whole = near.floor();
    (to_int(whole), A::of(near - whole))
}

/// An integer-valued double of at most 2^31 in size as an integer, without the checks of `as`: the low bits of
/// the sum with 1.5 * 2^52.
#[inline(always)]
fn to_int(x: f64) -> i32 {
    (x + 6_755_399_441_055_744.0).to_bits() as i32
}

#[inline(always)]
fn place<A: Real, const N: usize>(buffer: &mut Buffer<A, N>, i: usize, x: f64, y: f64) {
    let ((xi, fx), (yi, fy)) = (take_apart(x), take_apart(y));
    let finite = x.abs() < f64::INFINITY && y.abs() < f64::INFINITY;
    buffer.x[i] = if finite { xi } else { NOWHERE };
    buffer.y[i] = if finite { yi } else { NOWHERE };
    buffer.fx[i] = if finite { fx } else { A::default() };
    buffer.fy[i] = if finite { fy } else { A::default() };
}

/// Places the positions that an expression gives, on a grid. A macro, and not a function of a closure, so that
/// all of it is compiled for the instruction set of the function around it.
macro_rules! place_all {
    ($buffer:ident, $grid:expr, $n:expr, |$i:ident| $at:expr) => {
        // One loop a kind of grid, so that none tests it for every pixel.
        match $grid {
            Grid::Exact => {
                for $i in 0..$n.min(N) {
                    let (x, y) = $at;
                    place($buffer, $i, x, y);
                }
            }
            Grid::Whole | Grid::AccumulatedWhole => {
                for $i in 0..$n.min(N) {
                    let (x, y) = $at;
                    place($buffer, $i, x.round_ties_even(), y.round_ties_even());
                }
            }
            Grid::Thirtyseconds | Grid::Accumulated => {
                for $i in 0..$n.min(N) {
                    let (x, y) = $at;
                    place($buffer, $i, thirtysecond(x), thirtysecond(y));
                }
            }
        }
    };
}

/// Positions of one row of a matrix: `(m0 x + (m1 y + m2), m3 x + (m4 y + m5))`, divided by
/// `m6 x + (m7 y + m8)` unless that is always 1. A zero divisor gives position (0, 0) on a grid of
/// fractions and none elsewhere, as OpenCV's warps do.
#[inline(always)]
fn matrix_with<A: Real, const N: usize>(
    buffer: &mut Buffer<A, N>,
    grid: Grid,
    m: &[f64; 9],
    x0: f64,
    y: f64,
    n: usize,
) {
    let (cx, cy, cw) = (m[1] * y + m[2], m[4] * y + m[5], m[7] * y + m[8]);
    let affine = m[6] == 0.0 && m[7] == 0.0 && m[8] == 1.0;
    let at_infinity = if matches!(grid, Grid::Thirtyseconds | Grid::Accumulated) { 0.0 } else { f64::NAN };
    if affine && grid == Grid::Accumulated {
        let (bx, by) = (fixed(cx) + 16.0, fixed(cy) + 16.0);
        place_all!(buffer, Grid::Exact, n, |i| {
            let x = x0 + f64::from(i as u32);
            (snap(fixed(m[0] * x) + bx), snap(fixed(m[3] * x) + by))
        });
    } else if affine && grid == Grid::AccumulatedWhole {
        let (bx, by) = (fixed(cx) + 512.0, fixed(cy) + 512.0);
        place_all!(buffer, Grid::Exact, n, |i| {
            let x = x0 + f64::from(i as u32);
            (
                ((fixed(m[0] * x) + bx) * (1.0 / 1024.0)).floor(),
                ((fixed(m[3] * x) + by) * (1.0 / 1024.0)).floor(),
            )
        });
    } else if affine {
        place_all!(buffer, grid, n, |i| {
            let x = x0 + f64::from(i as u32);
            (m[0] * x + cx, m[3] * x + cy)
        });
    } else {
        place_all!(buffer, grid, n, |i| {
            let x = x0 + f64::from(i as u32);
            let w = m[6] * x + cw;
            let r = if w == 0.0 { at_infinity } else { 1.0 / w };
            ((m[0] * x + cx) * r, (m[3] * x + cy) * r)
        });
    }
}

/// In 1/1024 pixel.
#[inline(always)]
fn fixed(x: f64) -> f64 {
    (x * 1024.0).round_ties_even()
}

/// From 1/1024 pixel down to 1/32.
#[inline(always)]
fn snap(x: f64) -> f64 {
    (x * (1.0 / 32.0)).floor() * (1.0 / 32.0)
}

/// Compiles one body for every instruction set. The operations are the same, and so are their results.
macro_rules! dispatched {
    ($(#[$doc:meta])* $name:ident, $avx2:ident, $avx512:ident, $body:ident, ($($arg:ident: $type:ty),*)) => {
        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = "avx2")]
        fn $avx2<A: Real, const N: usize>(buffer: &mut Buffer<A, N>, $($arg: $type),*) {
            $body(buffer, $($arg),*);
        }
        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq")]
        fn $avx512<A: Real, const N: usize>(buffer: &mut Buffer<A, N>, $($arg: $type),*) {
            $body(buffer, $($arg),*);
        }
        impl<A: Real, const N: usize> Buffer<A, N> {
            $(#[$doc])*
            pub fn $name(&mut self, isa: Isa, $($arg: $type),*) -> Split<'_, A> {
                match isa {
                    // SAFETY: a set other than `Scalar` is in use only where the machine has it.
                    #[cfg(target_arch = "x86_64")]
                    Isa::Avx512 if isa.is_supported() => unsafe { $avx512(self, $($arg),*) },
                    // SAFETY: as above.
                    #[cfg(target_arch = "x86_64")]
                    Isa::Avx2 if isa.is_supported() => unsafe { $avx2(self, $($arg),*) },
                    _ => $body(self, $($arg),*),
                }
                self.view(dispatched!(@count $($arg)*))
            }
        }
    };
    (@count $grid:ident $x:ident $y:ident) => { $x.len() };
    (@count $grid:ident $m:ident $x0:ident $y:ident $n:ident) => { $n };
}

#[inline(always)]
fn plain_f32<A: Real, const N: usize>(buffer: &mut Buffer<A, N>, grid: Grid, x: &[f32], y: &[f32]) {
    let n = x.len().min(y.len()).min(N);
    let (x, y) = (&x[..n], &y[..n]);
    place_all!(buffer, grid, n, |i| (f64::from(x[i]), f64::from(y[i])));
}

#[inline(always)]
fn plain_f64<A: Real, const N: usize>(buffer: &mut Buffer<A, N>, grid: Grid, x: &[f64], y: &[f64]) {
    let n = x.len().min(y.len()).min(N);
    let (x, y) = (&x[..n], &y[..n]);
    place_all!(buffer, grid, n, |i| (x[i], y[i]));
}

dispatched!(
    /// Takes positions in singles apart; at most `N`.
    split_f32, f32_avx2, f32_avx512, plain_f32, (grid: Grid, x: &[f32], y: &[f32])
);
dispatched!(
    /// Takes positions in doubles apart; at most `N`.
    split_f64, f64_avx2, f64_avx512, plain_f64, (grid: Grid, x: &[f64], y: &[f64])
);
dispatched!(
    /// Makes the positions that a 3x3 matrix gives to `n` output pixels (`x0`, `y`), (`x0 + 1`, `y`), ...; at most
    /// `N`. In `f64`, whatever the elements: what is kept is the pixel and a fraction rounded once.
    matrix, matrix_avx2, matrix_avx512, matrix_with, (grid: Grid, m: &[f64; 9], x0: f64, y: f64, n: usize)
);

impl<A: Real, const N: usize> Buffer<A, N> {
    /// Room for `N` positions.
    pub fn new() -> Self {
        Self { x: [0; N], y: [0; N], fx: [A::default(); N], fy: [A::default(); N] }
    }

    /// The first `n` positions.
    fn view(&self, n: usize) -> Split<'_, A> {
        let n = n.min(N);
        Split { x: &self.x[..n], y: &self.y[..n], fx: &self.fx[..n], fy: &self.fy[..n] }
    }

    /// Positions of a fixed-point map: pairs of whole pixels, and for each pair a code `32 * fy + fx` of
    /// fractions in 1/32 pixel (of which only ten bits count). Without codes the fractions are zero. With
    /// `nearest`, fractions of a half and more lead to the next pixel.
    pub fn fixed(&mut self, isa: Isa, whole: &[i16], codes: Option<&[u16]>, nearest: bool) -> Split<'_, A> {
        let pairs = whole.as_chunks::<2>().0;
        let n = codes.map_or(pairs.len(), |codes| codes.len().min(pairs.len())).min(N);
        let pairs = &pairs[..n];
        let codes = codes.map(|codes| &codes[..n]);
        compiled_for(isa, Fixed { buffer: self, pairs, codes, nearest });
        self.view(n)
    }
}

/// A part of a fixed-point map, to be compiled for an instruction set.
struct Fixed<'a, A, const N: usize> {
    buffer: &'a mut Buffer<A, N>,
    pairs: &'a [[i16; 2]],
    codes: Option<&'a [u16]>,
    nearest: bool,
}

impl<A: Real, const N: usize> Work for Fixed<'_, A, N> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { buffer: Buffer { x, y, fx, fy }, pairs, codes, nearest } = self;
        let n = pairs.len().min(N);
        for ((x, y), pair) in x.iter_mut().zip(&mut *y).zip(pairs) {
            (*x, *y) = (i32::from(pair[0]), i32::from(pair[1]));
        }
        let Some(codes) = codes else {
            fx[..n].fill(A::default());
            fy[..n].fill(A::default());
            return;
        };
        for ((fx, fy), &code) in fx.iter_mut().zip(fy).zip(codes) {
            *fx = A::of(f64::from(code & 31) * (1.0 / 32.0));
            *fy = A::of(f64::from((code >> 5) & 31) * (1.0 / 32.0));
        }
        if nearest {
            for ((x, y), &code) in x.iter_mut().zip(y).zip(codes) {
                *x += i32::from((code >> 4) & 1);
                *y += i32::from((code >> 9) & 1);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_come_apart_and_together() {
        let cases = [0.0, -0.25, 1.5, -1e-9, 41.999_999, 1e30, -1e30, f64::NAN, f64::INFINITY, 3e9, -7.0];
        for isa in Isa::available() {
            let mut buffer = Buffer::<f64, CHUNK>::new();
            let split = buffer.split_f64(isa, Grid::Exact, &cases, &[0.0; 11]);
            for (i, &x) in cases.iter().enumerate() {
                if x.is_finite() {
                    let want = x.clamp(-FAR, FAR);
                    let sum = f64::from(split.x[i]) + split.fx[i];
                    assert!((sum - want).abs() < 1e-16, "{isa:?} {x}: {sum}");
                    assert!((0.0..=1.0).contains(&split.fx[i]));
                } else {
                    assert_eq!((split.x[i], split.y[i]), (NOWHERE, NOWHERE), "{x}");
                }
            }
        }
    }

    #[test]
    fn grids_round_as_described() {
        let mut buffer = Buffer::<f32, CHUNK>::new();
        let x = [0.5f32, 1.5, 2.5, -0.5, -0.51, 0.015_625, 0.046_875];
        let whole = buffer.split_f32(Isa::Scalar, Grid::Whole, &x, &[0.0; 7]);
        assert_eq!(whole.x, [0, 2, 2, 0, -1, 0, 0]);
        let fine = buffer.split_f32(Isa::Scalar, Grid::Thirtyseconds, &x, &[0.0; 7]);
        assert_eq!(fine.fx, [0.5, 0.5, 0.5, 0.5, 0.5, 0.0, 0.0625]);
        assert_eq!(fine.x, [0, 1, 2, -1, -1, 0, 0]);
        let fixed = buffer.fixed(Isa::Scalar, &[3, -4], Some(&[5 + 32 * 7]), false);
        assert_eq!((fixed.x[0], fixed.y[0], fixed.fx[0], fixed.fy[0]), (3, -4, 5.0 / 32.0, 7.0 / 32.0));
        let nearest = buffer.fixed(Isa::Scalar, &[3, -4], Some(&[15 + 32 * 16]), true);
        assert_eq!((nearest.x[0], nearest.y[0]), (3, -3));
    }

    #[test]
    fn matrices_give_the_same_positions_on_every_instruction_set() {
        let matrices = [
            [0.9, -0.2, 3.7, 0.2, 0.9, -8.0, 0.0, 0.0, 1.0],
            [0.9, -0.2, 3.7, 0.2, 0.9, -8.0, 1e-3, -2e-3, 1.0],
            [0.0; 9],
            [1e300, 0.0, 0.0, 0.0, 1e300, f64::NAN, 0.0, 1e-300, 0.0],
        ];
        for m in &matrices {
            for grid in
                [Grid::Exact, Grid::Whole, Grid::Thirtyseconds, Grid::Accumulated, Grid::AccumulatedWhole]
            {
                let mut buffers = Isa::available().into_iter().map(|isa| {
                    let mut buffer = Buffer::<f32, CHUNK>::new();
                    buffer.matrix(isa, grid, m, 5.0, 77.0, 67);
                    buffer
                });
                let first = buffers.next().expect("scalar");
                for other in buffers {
                    assert_eq!((first.x, first.y), (other.x, other.y));
                    assert_eq!(first.fx.map(f32::to_bits), other.fx.map(f32::to_bits));
                    assert_eq!(first.fy.map(f32::to_bits), other.fy.map(f32::to_bits));
                }
            }
        }
    }
}
