//! The definition of every result, one pixel at a time.

use super::sample::{Real, Sample};
use super::weights;
use super::{Edge, Interpolation, Job, NOWHERE, Outside, Split};
use std::any::Any;

/// Reads a run of pixels. The usual channel counts are compiled one by one.
pub(super) fn run<T: Sample>(job: &Job<'_, T>, split: &Split<'_, T::Acc>, out: &mut [T]) {
    match job.source.channels {
        1 => counted::<T, 1>(job, split, out),
        3 => counted::<T, 3>(job, split, out),
        4 => counted::<T, 4>(job, split, out),
        _ => counted::<T, 0>(job, split, out),
    }
}

/// Runs the body for every pixel of a run.
macro_rules! each {
    ($split:ident, $out:ident, $channels:ident, |$at:ident, $f:ident, $pixel:ident| $body:expr) => {
        let whole = $split.x.iter().zip($split.y);
        let rest = $split.fx.iter().zip($split.fy);
        for (((&x, &y), (&fx, &fy)), $pixel) in whole.zip(rest).zip($out.chunks_exact_mut($channels)) {
            let ($at, $f) = ([x, y], [fx, fy]);
            $body;
        }
    };
}

/// `C` channels, or any number where `C` is 0.
#[inline(always)]
fn counted<T: Sample, const C: usize>(job: &Job<'_, T>, split: &Split<'_, T::Acc>, out: &mut [T]) {
    let channels = if C == 0 { job.source.channels } else { C };
    match job.interpolation {
        Interpolation::Nearest => {
            each!(split, out, channels, |at, _f, pixel| nearest(job, channels, at, pixel));
        }
        Interpolation::Bilinear => {
            each!(split, out, channels, |at, f, pixel| bilinear(job, channels, at, f, pixel));
        }
        Interpolation::Bicubic(a) => {
            let a = T::Acc::of(f64::from(a));
            each!(split, out, channels, |at, f, pixel| {
                let weights = [weights::cubic(a, f[0]), weights::cubic(a, f[1])];
                separable(job, channels, at, weights, pixel);
            });
        }
        Interpolation::Lanczos4 => {
            let table = lanczos_table::<T::Acc>();
            each!(split, out, channels, |at, f, pixel| {
                let weights = [weights::look_up(table, f[0]), weights::look_up(table, f[1])];
                separable(job, channels, at, weights, pixel);
            });
        }
    }
}

/// The Lanczos table of this number type.
pub(super) fn lanczos_table<A: Real>() -> &'static weights::Table<A> {
    let single: &'static dyn Any = weights::table_f32();
    let double: &'static dyn Any = weights::table_f64();
    let found = single.downcast_ref().or_else(|| double.downcast_ref());
    found.expect("a Real is f32 or f64")
}

/// A position that is not finite: border colour, or nothing.
#[cold]
fn nowhere<T: Sample>(job: &Job<'_, T>, out: &mut [T]) {
    if job.outside == Outside::Colour {
        out.copy_from_slice(job.border);
    }
}

#[inline(always)]
fn nearest<T: Sample>(job: &Job<'_, T>, channels: usize, [x, y]: [i32; 2], out: &mut [T]) {
    let s = &job.source;
    if (x as u32 as usize) < s.width && (y as u32 as usize) < s.height {
        let start = y as usize * s.row_stride + x as usize * channels;
        out.copy_from_slice(&s.data[start..start + channels]);
        return;
    }
    if x == NOWHERE {
        return nowhere(job, out);
    }
    let found =
        [job.edges[0].index(i64::from(x), s.width as i64), job.edges[1].index(i64::from(y), s.height as i64)];
    match found {
        [Some(x), Some(y)] if job.outside != Outside::Keep => {
            let start = y * s.row_stride + x * channels;
            out.copy_from_slice(&s.data[start..start + channels]);
        }
        _ => nowhere(job, out),
    }
}

#[inline(always)]
fn lerp<A: Real>(a: A, b: A, t: A) -> A {
    a + t * (b - a)
}

#[inline(always)]
fn blend<T: Sample>(taps: [T; 4], f: [T::Acc; 2]) -> T {
    let [a, b, c, d] = taps.map(T::get);
    T::put(lerp(lerp(a, c, f[1]), lerp(b, d, f[1]), f[0]))
}

#[inline(always)]
fn bilinear<T: Sample>(job: &Job<'_, T>, channels: usize, at: [i32; 2], f: [T::Acc; 2], out: &mut [T]) {
    let s = &job.source;
    let [x, y] = at.map(|i| i as u32 as usize);
    if x + 1 < s.width && y + 1 < s.height {
        let start = y * s.row_stride + x * channels;
        let upper = &s.data[start..start + 2 * channels];
        let lower = &s.data[start + s.row_stride..start + s.row_stride + 2 * channels];
        for (k, o) in out.iter_mut().enumerate() {
            *o = blend([upper[k], upper[channels + k], lower[k], lower[channels + k]], f);
        }
        return;
    }
    beyond::<T, 2>(job, channels, at, 0, out, |taps| {
        blend([taps[0][0], taps[0][1], taps[1][0], taps[1][1]], f)
    });
}

/// The weighted sum of `K` x `K` taps.
#[inline(always)]
fn weigh<T: Sample, const K: usize>(taps: [[T; K]; K], weights: &[[T::Acc; K]; 2]) -> T {
    let mut sums: [T::Acc; K] = std::array::from_fn(|i| {
        let mut sum = weights[1][0] * taps[0][i].get();
        for j in 1..K {
            sum = sum + weights[1][j] * taps[j][i].get();
        }
        weights[0][i] * sum
    });
    let mut half = K / 2;
    while half > 0 {
        for i in 0..half {
            sums[i] = sums[i] + sums[i + half];
        }
        half /= 2;
    }
    T::put(sums[0])
}

#[inline(always)]
fn separable<T: Sample, const K: usize>(
    job: &Job<'_, T>,
    channels: usize,
    at: [i32; 2],
    weights: [[T::Acc; K]; 2],
    out: &mut [T],
) {
    let s = &job.source;
    let before = K as i32 / 2 - 1;
    let [x, y] = at.map(|i| i.wrapping_sub(before) as u32 as usize);
    if x + K <= s.width && y + K <= s.height {
        let start = y * s.row_stride + x * channels;
        let rows: [&[T]; K] = std::array::from_fn(|j| &s.data[start + j * s.row_stride..][..K * channels]);
        for (k, o) in out.iter_mut().enumerate() {
            *o = weigh(std::array::from_fn(|j| std::array::from_fn(|i| rows[j][i * channels + k])), &weights);
        }
        return;
    }
    beyond::<T, K>(job, channels, at, before, out, |taps| weigh(taps, &weights));
}

/// A pixel with taps beyond the picture: applies the edge rules tap by tap.
#[inline(never)]
fn beyond<T: Sample, const K: usize>(
    job: &Job<'_, T>,
    channels: usize,
    at: [i32; 2],
    before: i32,
    out: &mut [T],
    combine: impl Fn([[T; K]; K]) -> T,
) {
    if at[0] == NOWHERE {
        return nowhere(job, out);
    }
    let s = &job.source;
    let size = [s.width as i64, s.height as i64];
    let mut edges = job.edges;
    if job.outside == Outside::Keep {
        if (0..2).any(|axis| at[axis] < 0 || i64::from(at[axis]) >= size[axis]) {
            return;
        }
        edges = [if K == 2 { Edge::Clamp } else { Edge::Mirror101 }; 2];
    }
    let [columns, rows]: [[Option<usize>; K]; 2] = std::array::from_fn(|axis| {
        let first = i64::from(at[axis]) - i64::from(before);
        std::array::from_fn(|i| edges[axis].index(first + i as i64, size[axis]))
    });
    if columns.iter().all(Option::is_none) || rows.iter().all(Option::is_none) {
        return nowhere(job, out);
    }
    for (k, o) in out.iter_mut().enumerate() {
        let border = if job.outside == Outside::Previous { *o } else { job.border[k] };
        let taps = rows.map(|row| {
            columns.map(|column| match (column, row) {
                (Some(x), Some(y)) => s.data[y * s.row_stride + x * channels + k],
                _ => border,
            })
        });
        *o = combine(taps);
    }
}
