//! Bytes in 16 bits.

#[cfg(target_arch = "x86_64")]
use super::avx2;
use super::{CHUNK, Out, ROW, TAPS, Taps, gathered, inside, numbers};
use crate::kernel::remap::{Isa, Job};
use crate::kernel::{Work, compiled_for};

/// Units of a texel.
const UNIT: f32 = 128.0;
/// Units of a weight.
const WHOLE: f32 = 32_768.0;

/// Weights in units of 1/32768, twice in each number: `w(-1), w(1), w(2)` of a box, and along each axis.
pub(super) type Words = [[[u32; CHUNK]; 3]; 2];

/// Means over boxes of bytes.
pub(in super::super) fn bytes(isa: Isa, job: &Job<'_, u8>, taps: &Taps, n: usize, out: Out<'_, u8>) {
    let channels = job.source.channels;
    if channels > TAPS {
        return numbers(isa, job, taps, n, out);
    }
    let mut words = [[[0; CHUNK]; 3]; 2];
    compiled_for(isa, Whole { taps, n, words: &mut words });
    #[cfg(target_arch = "x86_64")]
    if isa != Isa::Scalar && isa.is_supported() {
        // SAFETY: the machine has the set, and all but the scalar one have AVX2.
        return unsafe { avx2::bytes(job, taps, &words, n, out) };
    }
    scalar(job, taps, &words, n, out);
}

struct Whole<'w> {
    taps: &'w Taps,
    n: usize,
    words: &'w mut Words,
}

impl Work for Whole<'_> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        for (words, weights) in self.words.as_flattened_mut().iter_mut().zip(self.taps.weights.as_flattened())
        {
            for i in 0..self.n {
                let word = (weights[i] * WHOLE + 0.5) as i32;
                words[i] = word.clamp(0, i32::from(i16::MAX)) as u32 * 0x0001_0001;
            }
        }
    }
}

/// The definition.
fn scalar(job: &Job<'_, u8>, taps: &Taps, words: &Words, n: usize, mut out: Out<'_, u8>) {
    let channels = job.source.channels;
    for i in 0..n {
        let rows = match inside(job, taps, i) {
            Some(start) => std::array::from_fn(|k| {
                std::array::from_fn(|j| job.source.data[start + k * job.source.row_stride + j])
            }),
            None => gathered(job, taps, i, 0..channels),
        };
        let weights = |axis: usize| std::array::from_fn(|k| words[axis][k][i] as u16 as i16);
        let down: [i16; ROW] =
            std::array::from_fn(|j| sum(rows.map(|row: [u8; ROW]| i16::from(row[j]) << 7), weights(1)));
        for c in 0..channels {
            let four = std::array::from_fn(|k| down[k * channels + c]);
            put(&mut out, i * channels + c, sum(four, weights(0)));
        }
    }
}

/// Stores a sum.
#[inline(always)]
pub(super) fn put(out: &mut Out<'_, u8>, at: usize, sum: i16) {
    match out {
        Out::Elements(out) => out[at] = ((sum + 64) >> 7).clamp(0, 255) as u8,
        Out::Numbers(out) => out[at] = f32::from(sum) * (1.0 / UNIT),
    }
}

/// Sums of differences stay within 16 bits: they are means of texels but for the roundings.
fn sum([a, b, c, e]: [i16; TAPS], weights: [i16; 3]) -> i16 {
    let share = |x: i16, w: i16| ((i32::from(x - b) * i32::from(w) + (1 << 14)) >> 15) as i16;
    let (before, after) = (share(a, weights[0]), share(c, weights[1]));
    b.wrapping_add(before.wrapping_add(after).wrapping_add(share(e, weights[2])))
}
