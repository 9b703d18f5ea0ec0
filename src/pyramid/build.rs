//! One level after the other, by kernels of any width and wrap mode: each from the numbers, not the codes, of
//! the one below.

use super::codec::{Codec, Real};
use super::taps::{Taps, edge};
use super::{Kind, Options, Target, cascade, coverage};
use crate::error::Result;
use crate::image::View;
use crate::kernel::Isa;
use crate::par;
use crate::texel::Texel;
use crate::wrap::Wrap;

/// Rows of a new level that one task makes.
const ROWS: usize = 16;

/// The numbers of one level.
pub(super) struct Plane<R> {
    pub width: usize,
    pub height: usize,
    pub channels: usize,
    pub numbers: Vec<R>,
}

/// Where a level's numbers come from.
enum Source<'a, T, R> {
    Codes(View<'a, T>),
    Numbers(&'a Plane<R>),
}

pub(super) fn levels<T: Texel, R: Real>(
    base: View<'_, T>,
    lanes: usize,
    targets: &mut [Target<'_, T>],
    options: &Options,
) -> Result<()> {
    let codec = Codec::new(options.format, base.channels(), T::DTYPE);
    if options.kind == Kind::Box && options.coverage.is_none() {
        return cascade::levels::<T, R>(base, lanes, targets, &codec);
    }
    let share = options.coverage.map(|threshold| coverage::share(base, options.format, threshold));
    let (mut width, mut height) = (base.width(), base.height());
    let mut below: Option<Plane<R>> = None;
    for target in targets {
        let taps =
            [Taps::new(options.kind, width, R::from_f64), Taps::new(options.kind, height, R::from_f64)];
        let source = below.as_ref().map_or(Source::Codes(base), Source::Numbers);
        let plane = next(&source, &taps, options.wrap, &codec, lanes, target)?;
        if let (Some(threshold), Some(share)) = (options.coverage, share) {
            coverage::restore(&plane, target, lanes, options.format, threshold, share);
        }
        (width, height) = (target.width, target.height);
        below = Some(plane);
    }
    Ok(())
}

fn next<T: Texel, R: Real>(
    source: &Source<'_, T, R>,
    taps: &[Taps<R>; 2],
    wrap: [Wrap; 2],
    codec: &Codec,
    lanes: usize,
    target: &mut Target<'_, T>,
) -> Result<Plane<R>> {
    let channels = codec.lanes;
    let row = target.width * channels;
    let mut plane = Plane {
        width: target.width,
        height: target.height,
        channels,
        numbers: vec![R::default(); row * target.height],
    };
    let stride = target.row_stride;
    let codes = target.data[target.origin..].chunks_mut(stride.saturating_mul(ROWS));
    let isa = Isa::current();
    let tiles = plane.numbers.chunks_mut(row * ROWS).zip(codes);
    par::for_pixels(target.width * target.height, tiles, |tile, (numbers, codes)| {
        let mut reader = Reader::new(source, taps, wrap, codec);
        let mut scratch = vec![R::default(); row];
        for (r, (numbers, codes)) in numbers.chunks_mut(row).zip(codes.chunks_mut(stride)).enumerate() {
            reader.reduce(tile * ROWS + r, numbers);
            codec.encode_row(isa, numbers, lanes, &mut codes[..target.width * lanes], &mut scratch);
        }
        Ok(())
    })?;
    Ok(plane)
}

/// Reads rows below, reduced horizontally, and keeps those that the next row needs again.
struct Reader<'a, T, R> {
    source: &'a Source<'a, T, R>,
    taps: &'a [Taps<R>; 2],
    wrap: [Wrap; 2],
    codec: &'a Codec,
    /// One row below with what lies beyond its ends.
    padded: Vec<R>,
    /// Reduced rows; row `y` lies in slot `y mod len`.
    slots: Vec<(Option<i64>, Vec<R>)>,
}

impl<'a, T: Texel, R: Real> Reader<'a, T, R> {
    fn new(source: &'a Source<'a, T, R>, taps: &'a [Taps<R>; 2], wrap: [Wrap; 2], codec: &'a Codec) -> Self {
        let channels = codec.lanes;
        let (before, after) = taps[0].overhang();
        Self {
            source,
            taps,
            wrap: wrap.map(edge),
            codec,
            padded: vec![R::default(); (before + taps[0].old + after) * channels],
            slots: (0..taps[1].len).map(|_| (None, vec![R::default(); taps[0].new * channels])).collect(),
        }
    }

    /// Row `j` of the new level.
    fn reduce(&mut self, j: usize, out: &mut [R]) {
        let (start, len) = (self.taps[1].start(j), self.taps[1].len);
        for y in start..start + len as i64 {
            self.load(y);
        }
        let slot = |t: usize| (start + t as i64).rem_euclid(len as i64) as usize;
        let weights = self.taps[1].weights(j);
        let row = |t: usize| &self.slots[slot(t)].1[..];
        // From the outside inwards, in pairs: a mirrored picture gives mirrored levels, bit for bit.
        for t in 0..len / 2 {
            let rows = out.iter_mut().zip(row(t)).zip(row(len - 1 - t));
            let (v, w) = (weights[t], weights[len - 1 - t]);
            if t == 0 {
                rows.for_each(|((out, a), b)| *out = *a * v + *b * w);
            } else {
                rows.for_each(|((out, a), b)| *out = *out + (*a * v + *b * w));
            }
        }
        if len % 2 == 1 {
            let w = weights[len / 2];
            let rows = out.iter_mut().zip(row(len / 2));
            if len == 1 {
                rows.for_each(|(out, a)| *out = *a * w);
            } else {
                rows.for_each(|(out, a)| *out = *out + *a * w);
            }
        }
        if self.codec.is_float() && len > 2 {
            for (x, out) in out.iter_mut().enumerate() {
                let first = row(0)[x];
                if (1..len).all(|t| row(t)[x] == first) {
                    *out = first;
                }
            }
        }
    }

    fn load(&mut self, y: i64) {
        let slot = y.rem_euclid(self.slots.len() as i64) as usize;
        if self.slots[slot].0 == Some(y) {
            return;
        }
        let (taps, channels) = (&self.taps[0], self.codec.lanes);
        let height = self.taps[1].old as i64;
        let row = self.wrap[1].index(y, height).map_or(0, |y| y.clamp(0, height - 1)) as usize;
        let (before, after) = taps.overhang();
        let inner = &mut self.padded[before * channels..][..taps.old * channels];
        match self.source {
            Source::Codes(view) => self.codec.decode_row(view.row(row), view.channels(), inner),
            Source::Numbers(plane) => {
                inner.copy_from_slice(&plane.numbers[row * inner.len()..][..inner.len()]);
            }
        }
        let old = taps.old as i64;
        for x in (-(before as i64)..0).chain(old..old + after as i64) {
            let from = self.wrap[0].index(x, old).map_or(0, |x| x.clamp(0, old - 1)) as usize + before;
            let to = (x + before as i64) as usize;
            self.padded.copy_within(from * channels..(from + 1) * channels, to * channels);
        }
        let (key, reduced) = &mut self.slots[slot];
        *key = Some(y);
        for (i, out) in reduced.chunks_exact_mut(channels).enumerate() {
            let first = (taps.start(i) + before as i64) as usize * channels;
            let texels = &self.padded[first..][..taps.len * channels];
            reduce_texel(texels, taps.weights(i), out);
            if self.codec.is_float() && taps.len > 2 {
                for (c, out) in out.iter_mut().enumerate() {
                    if (1..taps.len).all(|t| texels[t * channels + c] == texels[c]) {
                        *out = texels[c];
                    }
                }
            }
        }
    }
}

fn reduce_texel<R: Real>(texels: &[R], weights: &[R], out: &mut [R]) {
    let (channels, len) = (out.len(), weights.len());
    for (c, out) in out.iter_mut().enumerate() {
        let term = |t: usize| texels[t * channels + c] * weights[t];
        let mut sum = if len == 1 { term(0) } else { term(0) + term(len - 1) };
        for t in 1..len / 2 {
            sum = sum + (term(t) + term(len - 1 - t));
        }
        if len % 2 == 1 && len > 1 {
            sum = sum + term(len / 2);
        }
        *out = sum;
    }
}
