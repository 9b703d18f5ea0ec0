//! Means of the bilinear picture over boxes of up to two texels: four by four taps.
//!
//! The mean over [x - h, x + h] x [y - k, y + k] is a weighted sum of 4 x 4 texels whose weights are products. Along an
//! axis, for a box whose middle is `d` past texel 0, 0 <= d < 1 and h <= 1, the integrals of the tents are
//!
//! ```text
//! w(-1) = max(0, h - d)^2 / 4h        w(2) = max(0, d + h - 1)^2 / 4h
//! w(1)  = d + w(-1) - 2 w(2)          w(0) = 1 - w(-1) - w(1) - w(2)
//! ```
//!
//! since weights of all texels sum to 1 and their first moment is `d`. Texel 0 is the base: what is summed are the others'
//! differences from it, first down the columns, then along the row, so that equal texels give exactly their value:
//!
//! ```text
//! b + (((a - b) w(-1) + (c - b) w(1)) + (e - b) w(2))
//! ```
//!
//! Bytes of up to four channels are summed in 16 bits: texels in units of 1/128, weights of 1/32768, each product
//! rounded to nearest; everything else as numbers, never fused.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod bytes;
#[cfg(test)]
mod tests;

use super::sample::{Real, Sample};
use super::{Isa, Job};
use crate::error::{Error, Result};
use crate::kernel::{Work, compiled_for};
pub(super) use bytes::bytes;

/// Boxes that are worked on at once.
const CHUNK: usize = 64;
/// Texels a side of what a box reads.
const TAPS: usize = 4;
/// Elements of a row of texels that are read at once: four texels of up to four channels.
const ROW: usize = 16;
/// Half the side of the smallest box, in texels; and that of the largest.
const HALF: [f32; 2] = [1.0 / 1024.0, 1.0];

/// A run of boxes.
#[derive(Clone, Copy, Debug)]
pub struct Boxes<'b> {
    /// Columns of the middles, in pixels of the source.
    pub x: &'b [f32],
    /// Rows of the middles.
    pub y: &'b [f32],
    /// Half the sides across and down: of the first box, and what each next one adds. Cut to at most 1.
    pub half: [[f32; 2]; 2],
}

/// Where the results go.
pub enum Out<'o, T: Sample> {
    /// Rounded to elements.
    Elements(&'o mut [T]),
    /// As they are.
    Numbers(&'o mut [T::Acc]),
}

impl<T: Sample> Out<'_, T> {
    fn len(&self) -> usize {
        match self {
            Self::Elements(out) => out.len(),
            Self::Numbers(out) => out.len(),
        }
    }

    #[inline(always)]
    fn put(&mut self, at: usize, value: T::Acc) {
        match self {
            Self::Elements(out) => out[at] = T::put(value),
            Self::Numbers(out) => out[at] = value,
        }
    }
}

/// Means over boxes, packed, rounded to elements. A box whose middle is not finite has no defined value. The
/// interpolation of the job is not read.
///
/// # Errors
/// [`Error::Value`] when the numbers of boxes and output pixels differ.
pub fn boxes<T: Sample>(isa: Isa, job: &Job<'_, T>, boxes: &Boxes<'_>, out: &mut [T]) -> Result<()> {
    run(isa, job, boxes, Out::Elements(out))
}

/// [`boxes`] as numbers.
///
/// # Errors
/// As [`boxes`].
pub fn box_numbers<T: Sample>(
    isa: Isa,
    job: &Job<'_, T>,
    boxes: &Boxes<'_>,
    out: &mut [T::Acc],
) -> Result<()> {
    run(isa, job, boxes, Out::Numbers(out))
}

fn run<T: Sample>(isa: Isa, job: &Job<'_, T>, boxes: &Boxes<'_>, mut out: Out<'_, T>) -> Result<()> {
    let (count, channels) = (boxes.x.len(), job.source.channels);
    if boxes.y.len() != count || count.checked_mul(channels) != Some(out.len()) {
        let got = format!("{} elements for {count} columns and {} rows", out.len(), boxes.y.len());
        return Err(Error::value("out", got, "one pixel a box"));
    }
    let mut taps = Box::new(Taps::new());
    for start in (0..count).step_by(CHUNK) {
        let n = CHUNK.min(count - start);
        compiled_for(isa, Weigh { boxes, start, n, taps: &mut taps });
        let pixels = start * channels..(start + n) * channels;
        let out = match &mut out {
            Out::Elements(out) => Out::Elements(&mut out[pixels]),
            Out::Numbers(out) => Out::Numbers(&mut out[pixels]),
        };
        T::boxes(isa, job, &taps, n, out);
    }
    Ok(())
}

/// First texels and weights of a chunk of boxes.
pub struct Taps {
    /// Column and row of texel 0 of each box.
    at: [[i32; CHUNK]; 2],
    /// `w(-1), w(1), w(2)` along each axis.
    weights: [[[f32; CHUNK]; 3]; 2],
}

impl Taps {
    fn new() -> Self {
        Self { at: [[0; CHUNK]; 2], weights: [[[0.0; CHUNK]; 3]; 2] }
    }

    /// Weights of box `i` along an axis.
    #[inline(always)]
    fn of<A: Real>(&self, axis: usize, i: usize) -> [A; 3] {
        std::array::from_fn(|k| A::of(f64::from(self.weights[axis][k][i])))
    }
}

struct Weigh<'w, 'b> {
    boxes: &'w Boxes<'b>,
    start: usize,
    n: usize,
    taps: &'w mut Taps,
}

impl Work for Weigh<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { boxes, start, n, taps } = self;
        for (axis, at) in [boxes.x, boxes.y].into_iter().enumerate() {
            let at = &at[start..start + n];
            let whole = &mut taps.at[axis][..n];
            let [before, after, last] = &mut taps.weights[axis];
            let (before, after, last) = (&mut before[..n], &mut after[..n], &mut last[..n]);
            let [first, step] = boxes.half[axis];
            let first = first + step * start as f32;
            for i in 0..n {
                let h = between(first + step * (i as i32) as f32, HALF);
                let floor = at[i].floor();
                let d = at[i] - floor;
                let share = 0.25 / h;
                let (left, right) = (above(h - d), above(d + h - 1.0));
                whole[i] = floor as i32;
                before[i] = left * left * share;
                last[i] = right * right * share;
                after[i] = d + before[i] - 2.0 * last[i];
            }
        }
    }
}

#[inline(always)]
fn above(x: f32) -> f32 {
    if x > 0.0 { x } else { 0.0 }
}

#[inline(always)]
fn between(x: f32, [low, high]: [f32; 2]) -> f32 {
    let x = if x > low { x } else { low };
    if x < high { x } else { high }
}

/// Where the four rows of a box start in the source, from texel -1 on; `None` where they are not all inside, or fewer than
/// [`ROW`] elements are left from there.
#[inline(always)]
fn inside<T>(job: &Job<'_, T>, taps: &Taps, i: usize) -> Option<usize> {
    let s = &job.source;
    let (x, y) = (taps.at[0][i] as isize as usize, taps.at[1][i] as isize as usize);
    // Negative places are huge ones.
    let is_inside = |i: usize, n: usize| i.wrapping_sub(1) < n.saturating_sub(TAPS - 1);
    if !is_inside(x, s.width) || !is_inside(y, s.height) {
        return None;
    }
    let start = (y - 1) * s.row_stride + (x - 1) * s.channels;
    (start + (TAPS - 1) * s.row_stride + ROW <= s.data.len()).then_some(start)
}

/// The four rows of a box that reads beyond the source, or close to its end.
#[cold]
fn gathered<T: Sample>(
    job: &Job<'_, T>,
    taps: &Taps,
    i: usize,
    channels: std::ops::Range<usize>,
) -> [[T; ROW]; TAPS] {
    let s = &job.source;
    let mut rows = [[T::default(); ROW]; TAPS];
    for (k, row) in rows.iter_mut().enumerate() {
        let y = job.edges[1].index(i64::from(taps.at[1][i]) + k as i64 - 1, s.height as i64);
        for j in 0..TAPS {
            let x = job.edges[0].index(i64::from(taps.at[0][i]) + j as i64 - 1, s.width as i64);
            let texel = match (x, y) {
                (Some(x), Some(y)) => &s.data[y * s.row_stride + x * s.channels..][..s.channels],
                _ => job.border,
            };
            let n = channels.len();
            row[j * n..(j + 1) * n].copy_from_slice(&texel[channels.clone()]);
        }
    }
    rows
}

/// Means as numbers: the definition for all elements but bytes.
pub(super) fn numbers<T: Sample>(isa: Isa, job: &Job<'_, T>, taps: &Taps, n: usize, out: Out<'_, T>) {
    match job.source.channels {
        1 => compiled_for(isa, Numbers::<T, 1> { job, taps, n, out }),
        2 => compiled_for(isa, Numbers::<T, 2> { job, taps, n, out }),
        3 => compiled_for(isa, Numbers::<T, 3> { job, taps, n, out }),
        4 => compiled_for(isa, Numbers::<T, 4> { job, taps, n, out }),
        _ => each_channel(job, taps, n, out),
    }
}

struct Numbers<'n, 'a, 'o, T: Sample, const C: usize> {
    job: &'n Job<'a, T>,
    taps: &'n Taps,
    n: usize,
    out: Out<'o, T>,
}

impl<T: Sample, const C: usize> Work for Numbers<'_, '_, '_, T, C> {
    type Output = ();
    #[inline(always)]
    fn run(mut self) {
        let Self { job, taps, n, .. } = self;
        let (data, stride) = (job.source.data, job.source.row_stride);
        for i in 0..n {
            let down = match inside(job, taps, i) {
                Some(start) => {
                    let row = |k: usize| {
                        let at = start + k * stride;
                        <&[T; ROW]>::try_from(&data[at..at + ROW]).expect("as many")
                    };
                    columns([row(0), row(1), row(2), row(3)], taps.of(1, i))
                }
                None => {
                    let rows = gathered(job, taps, i, 0..C);
                    columns([&rows[0], &rows[1], &rows[2], &rows[3]], taps.of(1, i))
                }
            };
            let weights = taps.of(0, i);
            for c in 0..C {
                let four = [down[c], down[C + c], down[2 * C + c], down[3 * C + c]];
                self.out.put(i * C + c, sum(four, weights));
            }
        }
    }
}

/// Down the columns of four rows.
#[inline(always)]
fn columns<T: Sample>(rows: [&[T; ROW]; TAPS], weights: [T::Acc; 3]) -> [T::Acc; ROW] {
    let mut down = [T::Acc::default(); ROW];
    for k in 0..ROW {
        down[k] = sum([rows[0][k].get(), rows[1][k].get(), rows[2][k].get(), rows[3][k].get()], weights);
    }
    down
}

#[inline(always)]
fn sum<A: Real>([a, b, c, e]: [A; TAPS], [before, after, last]: [A; 3]) -> A {
    b + (((a - b) * before + (c - b) * after) + (e - b) * last)
}

/// More than four channels, one by one.
fn each_channel<T: Sample>(job: &Job<'_, T>, taps: &Taps, n: usize, mut out: Out<'_, T>) {
    let channels = job.source.channels;
    for i in 0..n {
        for c in 0..channels {
            let rows = gathered(job, taps, i, c..c + 1);
            let down = columns([&rows[0], &rows[1], &rows[2], &rows[3]], taps.of(1, i));
            out.put(i * channels + c, sum([down[0], down[1], down[2], down[3]], taps.of(0, i)));
        }
    }
}
