//! Bytes in 16 bits.

#[cfg(target_arch = "x86_64")]
use super::avx2;
use super::{
    ACROSS, DOWN, Out, ROW, SLOPE_ACROSS, SLOPE_DOWN, TAPS, Taps, gathered, inside, nearest, numbers,
};
use crate::kernel::remap::{Isa, Job};
use crate::kernel::{Work, compiled_for};

/// Units of a texel.
pub(super) const UNIT: f32 = 128.0;
/// Units of a weight.
const WHOLE: f32 = 32_768.0;

/// Means over boxes of bytes.
pub(in super::super) fn bytes(isa: Isa, job: &Job<'_, u8>, taps: &mut Taps, out: Out<'_, u8>) {
    if job.source.channels > TAPS {
        return numbers(isa, job, taps, out);
    }
    compiled_for(isa, Whole(taps));
    #[cfg(target_arch = "x86_64")]
    if isa != Isa::Scalar && isa.is_supported() {
        // SAFETY: the machine has the set, and all but the scalar one have AVX2.
        return unsafe { avx2::bytes(job, taps, out) };
    }
    scalar(job, taps, out);
}

/// Weights as words.
struct Whole<'w>(&'w mut Taps);

impl Work for Whole<'_> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Taps { n, leans, weights, words, .. } = self.0;
        let kinds = if *leans { 4 } else { 2 };
        for (words, weights) in words[..kinds].as_flattened_mut().iter_mut().zip(weights.as_flattened()) {
            for (word, weight) in words[..*n].iter_mut().zip(&weights[..*n]) {
                let whole = nearest(weight * WHOLE).min(i32::from(i16::MAX));
                *word = (whole as u32 & 0xffff) * 0x0001_0001;
            }
        }
    }
}

/// The definition.
fn scalar(job: &Job<'_, u8>, taps: &Taps, mut out: Out<'_, u8>) {
    let channels = job.source.channels;
    for i in 0..taps.n {
        let rows = match inside(job, taps, i) {
            Some(start) => std::array::from_fn(|k| {
                std::array::from_fn(|j| job.source.data[start + k * job.source.row_stride + j])
            }),
            None => gathered(job, taps, i, 0..channels),
        };
        let weights = |which: usize| std::array::from_fn(|k| taps.words[which][k][i] as u16 as i16);
        let down = |which: usize| -> [i16; ROW] {
            std::array::from_fn(|j| rest(rows.map(|row: [u8; ROW]| i16::from(row[j]) << 7), weights(which)))
        };
        let upright = down(DOWN);
        let leaning = down(SLOPE_DOWN);
        for c in 0..channels {
            let level: [i16; TAPS] = std::array::from_fn(|k| {
                let at = k * channels + c;
                (i16::from(rows[1][at]) << 7).wrapping_add(upright[at])
            });
            let mut sum = level[1].wrapping_add(rest(level, weights(ACROSS)));
            if taps.leans {
                let four = std::array::from_fn(|k| leaning[k * channels + c]);
                sum = sum.saturating_add(rest(four, weights(SLOPE_ACROSS)));
            }
            match &mut out {
                Out::Elements(out) => {
                    out[i * channels + c] = (sum.saturating_add(64) >> 7).clamp(0, 255) as u8;
                }
                Out::Numbers(out) => out[i * channels + c] = f32::from(sum) * (1.0 / UNIT),
            }
        }
    }
}

/// What the others add to the base. Upright sums stay within 16 bits: they are means of texels but for the roundings.
fn rest([a, b, c, e]: [i16; TAPS], weights: [i16; 3]) -> i16 {
    let share = |x: i16, w: i16| ((i32::from(x.wrapping_sub(b)) * i32::from(w) + (1 << 14)) >> 15) as i16;
    let (before, after) = (share(a, weights[0]), share(c, weights[1]));
    before.wrapping_add(after).wrapping_add(share(e, weights[2]))
}
