//! Resizing along one axis after the other: linear, cubic and Lanczos interpolation, and means over pixels that cover
//! more than one of the source.
//!
//! ```text
//! position   x = (i + 1/2) s - 1/2            of output pixel i, each of which stands for s pixels; beyond its ends the
//!                                             picture goes on as its last pixel
//! linear     w_0 = 1 - f,  w_1 = f            f = x - floor x
//! mean       w_j = (S(x + s/2 - j) - S(x - s/2 - j)) / s
//!            S(z) = 1/2 + c (1 - |c|/2),      c = clamp(z, -1, 1): the integral of the tent
//! value      p + w_0 (p_0 - p) + w_1 (p_1 - p) + ...    where p is the pixel in the middle
//! ```
//!
//! The mean is the integral of the linear interpolation over the pixel, exactly, as [`crate::filter::Filter::Exact`] has it:
//! for a footprint whose sides are upright it is a product of one for each axis. Values are sums of differences, so
//! that a constant stays as it is. Rows of the source are stretched once each and kept while they are needed.

use super::Rows;
use crate::error::{Error, Result};
use crate::image::zeros;
use crate::kernel::remap::{Real, Sample, cubic, lanczos};
use crate::kernel::{Isa, Work, compiled_for};
use crate::par;

/// Elements of output that a thread takes at a time, about.
const BAND: usize = 1 << 16;

/// Output elements that are summed at a time.
const LANES: usize = 32;

/// Elements behind the last pixel of a row that may be touched.
const SLACK: usize = LANES;

/// What an output pixel of an axis is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kernel {
    /// Two pixels.
    Linear,
    /// Four, with this slope parameter.
    Cubic(f64),
    /// Eight.
    Lanczos4,
    /// All that it covers.
    Mean,
}

/// Other axes, and their share of the result.
pub type Blend<'a, A> = (&'a [Axis<A>; 2], A);

/// The weights of every output pixel of an axis.
#[derive(Clone, Debug)]
pub struct Axis<A> {
    /// First pixel of each, counted from `before` pixels ahead of the picture.
    first: Vec<usize>,
    /// `taps` for each, of which that of the pixel in the middle is never read: it is what the others leave.
    weights: Vec<A>,
    taps: usize,
    /// Pixels that are read ahead of the picture and behind it.
    before: usize,
    after: usize,
    /// Pixels of the source.
    size: usize,
}

impl<A: Real> Axis<A> {
    /// Output pixels at these places of an axis of `size` pixels, each of which stands for `scale` of them.
    ///
    /// # Errors
    /// [`Error::Value`] where there is no memory for so many weights.
    pub fn new(
        kernel: Kernel,
        size: usize,
        count: usize,
        scale: f64,
        at: impl Fn(usize) -> f64,
    ) -> Result<Self> {
        // No size that a factor gives is rounded so far that a pixel stands for more than twice what there is.
        let scale = scale.min(2.0 * size as f64);
        // A mean of many pixels reaches over its own and one more on each side.
        let taps = match kernel {
            Kernel::Linear => 2,
            Kernel::Cubic(_) => 4,
            Kernel::Lanczos4 => 8,
            Kernel::Mean => (scale.ceil() as usize).saturating_add(3),
        };
        let mut weights = zeros::<A>("dsize", count.saturating_mul(taps))?;
        let mut first = zeros::<usize>("dsize", count)?;
        // Further outside than all taps nothing changes.
        let far = taps as f64 + 0.5 * scale + 1.0;
        let place = |i: usize| at(i).clamp(-far, size as f64 + far);
        let start = |x: f64| match kernel {
            Kernel::Mean => (x - 0.5 * scale).floor() as i64,
            _ => x.floor() as i64 - (taps as i64 / 2 - 1),
        };
        let least = (0..count).map(|i| start(place(i))).min().unwrap_or(0).min(0);
        let before = least.unsigned_abs() as usize;
        let mut after = 0;
        for ((i, first), weights) in (0..count).zip(&mut first).zip(weights.chunks_exact_mut(taps)) {
            let x = place(i);
            let from = start(x);
            *first = (from - least) as usize;
            after = after.max((*first + taps).saturating_sub(before + size));
            fill(kernel, x, scale, from, weights);
        }
        Ok(Self { first, weights, taps, before, after, size })
    }

    /// Output pixels whose edges lie on edges of the source's.
    ///
    /// # Errors
    /// As [`Axis::new`].
    pub fn scaled(kernel: Kernel, size: usize, count: usize, scale: f64) -> Result<Self> {
        Self::new(kernel, size, count, scale, |i| (i as f64 + 0.5) * scale - 0.5)
    }

    fn weights(&self, i: usize) -> &[A] {
        &self.weights[i * self.taps..(i + 1) * self.taps]
    }

    /// The source's pixel that stands at tap `k` of output pixel `i`.
    fn pixel(&self, i: usize, k: usize) -> usize {
        (self.first[i] + k).saturating_sub(self.before).min(self.size - 1)
    }
}

/// Weights of the pixels from `from` on for an output pixel at `x`.
fn fill<A: Real>(kernel: Kernel, x: f64, scale: f64, from: i64, weights: &mut [A]) {
    let f = x - x.floor();
    match kernel {
        Kernel::Linear => weights.copy_from_slice(&[1.0 - f, f].map(A::of)),
        Kernel::Cubic(a) => weights.copy_from_slice(&cubic(a, f).map(A::of)),
        Kernel::Lanczos4 => weights.copy_from_slice(&lanczos(f).map(A::of)),
        Kernel::Mean => {
            let step = |z: f64| {
                let c = z.clamp(-1.0, 1.0);
                0.5 + c * (1.0 - 0.5 * c.abs())
            };
            for (j, weight) in (from..).zip(weights) {
                let d = x - j as f64;
                *weight = A::of((step(d + 0.5 * scale) - step(d - 0.5 * scale)) / scale);
            }
        }
    }
}

/// Fills `out`, packed pixels, with the picture as its two axes (along x and y) say. With `blend` = (axes, share)
/// it is that share of the picture by the other axes, and the rest by the first.
///
/// # Errors
/// [`Error::Value`] for axes of another picture or an `out` of another size; [`Error::Interrupted`].
///
/// ```
/// use multum::compat::cv2::{Rows, separable::{Axis, Kernel, stretch}};
/// let picture = Rows::new(&[0u8, 100], 2, 1, 1, 2)?;
/// let axes = [Axis::scaled(Kernel::Linear, 2, 4, 0.5)?, Axis::scaled(Kernel::Linear, 1, 1, 1.0)?];
/// let mut out = [0; 4];
/// stretch(&picture, &axes, None, &mut out)?;
/// assert_eq!(out, [0, 25, 75, 100]);
/// # Ok::<(), multum::Error>(())
/// ```
pub fn stretch<T: Sample>(
    source: &Rows<'_, T>,
    axes: &[Axis<T::Acc>; 2],
    blend: Option<Blend<'_, T::Acc>>,
    out: &mut [T],
) -> Result<()> {
    let [width, height] = [axes[0].first.len(), axes[1].first.len()];
    let channels = source.channels;
    let sizes = [axes[0].size, axes[1].size];
    let alike = blend.is_none_or(|(other, _)| {
        [0, 1].map(|k| (other[k].first.len(), other[k].size)) == [(width, sizes[0]), (height, sizes[1])]
    });
    let len = width.checked_mul(height).and_then(|n| n.checked_mul(channels));
    if len != Some(out.len()) || out.is_empty() || sizes != [source.width, source.height] || !alike {
        let expected = format!("{width} x {height} x {channels} from {sizes:?}");
        return Err(Error::value("dst", format!("{} elements", out.len()), expected));
    }
    let isa = Isa::current();
    let row = width * channels;
    let rows = (BAND / row).max(1);
    let work = |first: usize, out: &mut [T]| {
        let mut main = Window::new(source, axes)?;
        let mut other = match blend {
            Some((axes, share)) => Some((Window::new(source, axes)?, share)),
            None => None,
        };
        for (y, out) in out.chunks_exact_mut(row).enumerate() {
            compiled_for(isa, OutputRow { main: &mut main, other: other.as_mut(), y: first + y, out });
        }
        Ok(())
    };
    par::for_each(out.chunks_mut(rows * row), |i, band| work(i * rows, band))
}

/// One row of the output, to be compiled for an instruction set.
struct OutputRow<'w, 'a, T: Sample> {
    main: &'w mut Window<'a, T>,
    other: Option<&'w mut (Window<'a, T>, T::Acc)>,
    y: usize,
    out: &'w mut [T],
}

impl<T: Sample> Work for OutputRow<'_, '_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { main, other, y, out } = self;
        main.fetch(y);
        let Some((other, share)) = other else {
            for (k, out) in out.chunks_mut(LANES).enumerate() {
                let sums = main.part(y, k * LANES);
                for (out, &sum) in out.iter_mut().zip(&sums) {
                    *out = T::put(sum);
                }
            }
            return;
        };
        other.fetch(y);
        for (k, out) in out.chunks_mut(LANES).enumerate() {
            let (sums, others) = (main.part(y, k * LANES), other.part(y, k * LANES));
            for ((out, &a), &b) in out.iter_mut().zip(&sums).zip(&others) {
                *out = T::put(a + *share * (b - a));
            }
        }
    }
}

/// Stretched rows of the source: as many as an output row is made of.
struct Window<'a, T: Sample> {
    source: &'a Rows<'a, T>,
    axes: &'a [Axis<T::Acc>; 2],
    /// Elements of the place of a stretched row.
    stride: usize,
    kept: Vec<T::Acc>,
    /// Which row of the source stands in each place: row `y` in place `y % which.len()`.
    which: Vec<usize>,
    /// Where the taps of the output row that was fetched start in `kept`.
    starts: Vec<usize>,
    /// A row of the source as numbers, with what is read beyond its ends.
    line: Vec<T::Acc>,
}

impl<'a, T: Sample> Window<'a, T> {
    fn new(source: &'a Rows<'a, T>, axes: &'a [Axis<T::Acc>; 2]) -> Result<Self> {
        let channels = source.channels;
        let stride = axes[0].first.len() * channels + SLACK;
        let places = axes[1].taps.min(source.height);
        Ok(Self {
            source,
            axes,
            stride,
            kept: zeros("dsize", places.saturating_mul(stride))?,
            which: vec![usize::MAX; places],
            starts: zeros("dsize", axes[1].taps)?,
            line: zeros("dsize", (axes[0].before + source.width + axes[0].after) * channels + SLACK)?,
        })
    }

    /// Makes the rows that output row `y` needs.
    #[inline(always)]
    fn fetch(&mut self, y: usize) {
        let down = &self.axes[1];
        let [first, last] = [down.pixel(y, 0), down.pixel(y, down.taps - 1)];
        for at in first..=last {
            let place = at % self.which.len();
            if self.which[place] != at {
                self.which[place] = at;
                self.stretch(at, place);
            }
        }
        for (k, start) in self.starts.iter_mut().enumerate() {
            *start = down.pixel(y, k) % self.which.len() * self.stride;
        }
    }

    /// One row of the source, stretched into its place.
    #[inline(always)]
    fn stretch(&mut self, at: usize, place: usize) {
        let across = &self.axes[0];
        let channels = self.source.channels;
        let start = across.before * channels;
        let row = self.source.row(at);
        let (ahead, rest) = self.line.split_at_mut(start);
        let (inner, behind) = rest.split_at_mut(row.len());
        for (number, &element) in inner.iter_mut().zip(row) {
            *number = element.get();
        }
        for pixel in ahead.chunks_exact_mut(channels) {
            pixel.copy_from_slice(&inner[..channels]);
        }
        for pixel in behind[..across.after * channels].chunks_exact_mut(channels) {
            pixel.copy_from_slice(&inner[inner.len() - channels..]);
        }
        let out = &mut self.kept[place * self.stride..][..self.stride];
        match (across.taps, channels) {
            (2, 1) => pixels::<_, 2, 1>(across, &self.line, out, 1, 2),
            (4, 1) => pixels::<_, 4, 1>(across, &self.line, out, 1, 4),
            (8, 1) => pixels::<_, 8, 1>(across, &self.line, out, 1, 8),
            (taps, 1) => pixels::<_, 0, 1>(across, &self.line, out, 1, taps),
            (2, 3) => pixels::<_, 2, 4>(across, &self.line, out, 3, 2),
            (2, 4) => pixels::<_, 2, 4>(across, &self.line, out, 4, 2),
            (4, 3 | 4) => pixels::<_, 4, 4>(across, &self.line, out, channels, 4),
            (8, 3 | 4) => pixels::<_, 8, 4>(across, &self.line, out, channels, 8),
            (taps, 2..=4) => pixels::<_, 0, 4>(across, &self.line, out, channels, taps),
            (taps, _) => {
                for c in 0..channels {
                    for (x, out) in out[c..].iter_mut().step_by(channels).take(across.first.len()).enumerate()
                    {
                        let from = across.first[x] * channels + c;
                        let base = self.line[from + middle(taps) * channels];
                        let mut sum = base;
                        for (k, &w) in across.weights(x).iter().enumerate() {
                            if k != middle(taps) {
                                sum = sum + w * (self.line[from + k * channels] - base);
                            }
                        }
                        *out = sum;
                    }
                }
            }
        }
    }

    /// The part of output row `y` from element `start` on. Rows end in slack: whole parts can be read, and what is too much
    /// is for the caller to leave.
    #[inline(always)]
    fn part(&self, y: usize, start: usize) -> [T::Acc; LANES] {
        let weights = self.axes[1].weights(y);
        match weights.len() {
            2 => self.part_of::<2>(weights, start),
            4 => self.part_of::<4>(weights, start),
            _ => self.part_of::<0>(weights, start),
        }
    }

    /// [`Self::part`] of `K` taps, or of any number where that is 0.
    #[inline(always)]
    fn part_of<const K: usize>(&self, weights: &[T::Acc], start: usize) -> [T::Acc; LANES] {
        let taps = if K == 0 { weights.len() } else { K };
        let middle = middle(taps);
        let mut base = [T::Acc::default(); LANES];
        base.copy_from_slice(&self.kept[self.starts[middle] + start..][..LANES]);
        let mut sums = base;
        for (k, &w) in weights.iter().enumerate().take(taps) {
            if k != middle {
                let taps = &self.kept[self.starts[k] + start..][..LANES];
                for i in 0..LANES {
                    sums[i] = sums[i] + w * (taps[i] - base[i]);
                }
            }
        }
        sums
    }
}

/// The tap that the others are compared with: of interpolations the one that a whole position reads alone.
#[inline(always)]
fn middle(taps: usize) -> usize {
    (taps - 1) / 2
}

/// Pixels of `channels` numbers, `V` of which are summed at a time: where that is more, the next pixel puts what is too
/// much right. `K` taps, or `taps` where that is 0.
#[inline(always)]
fn pixels<A: Real, const K: usize, const V: usize>(
    axis: &Axis<A>,
    line: &[A],
    out: &mut [A],
    channels: usize,
    taps: usize,
) {
    let taps = if K == 0 { taps } else { K };
    let reach = (taps - 1) * channels + V;
    let middle = middle(taps);
    for (x, (&first, weights)) in axis.first.iter().zip(axis.weights.chunks_exact(taps)).enumerate() {
        let from = &line[first * channels..][..reach];
        let mut base = [A::default(); V];
        base.copy_from_slice(&from[middle * channels..][..V]);
        let mut sum = base;
        for (k, &w) in weights.iter().enumerate() {
            if k != middle {
                let tap = &from[k * channels..][..V];
                for c in 0..V {
                    sum[c] = sum[c] + w * (tap[c] - base[c]);
                }
            }
        }
        out[x * channels..][..V].copy_from_slice(&sum);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::with_isa;

    /// The weighted sum by its definition, in doubles.
    fn plainly(data: &[f64], n: [usize; 3], kernel: Kernel, scale: [f64; 2], at: [usize; 3]) -> f64 {
        let weights = |i: usize, scale: f64, n: usize| {
            let x = (i as f64 + 0.5) * scale - 0.5;
            let mut found = vec![0.0; n];
            for j in -40..n as i64 + 40 {
                let d = (x - j as f64).abs();
                let w = match kernel {
                    Kernel::Linear => (1.0 - d).max(0.0),
                    Kernel::Cubic(a) if d < 1.0 => ((a + 2.0) * d - (a + 3.0)) * d * d + 1.0,
                    Kernel::Cubic(a) if d < 2.0 => ((a * d - 5.0 * a) * d + 8.0 * a) * d - 4.0 * a,
                    Kernel::Cubic(_) => 0.0,
                    Kernel::Lanczos4 => {
                        let t = std::f64::consts::PI * d;
                        let sum = lanczos(x - x.floor());
                        let k = j - x.floor() as i64 + 3;
                        if (0..8).contains(&k) {
                            // Up to the common factor that makes the sum 1.
                            let raw =
                                if d == 0.0 { 1.0 } else { t.sin() * (0.25 * t).sin() / (0.25 * t * t) };
                            assert!((raw - sum[k as usize]).abs() < 0.02);
                            sum[k as usize]
                        } else {
                            0.0
                        }
                    }
                    // A Riemann sum of the tent.
                    Kernel::Mean => {
                        let steps = 4000;
                        let inside = (0..steps).map(|k| x + scale * ((k as f64 + 0.5) / steps as f64 - 0.5));
                        inside.map(|z| (1.0 - (z - j as f64).abs()).max(0.0)).sum::<f64>() / steps as f64
                    }
                };
                found[j.clamp(0, n as i64 - 1) as usize] += w;
            }
            found
        };
        let (wx, wy) = (weights(at[0], scale[0], n[0]), weights(at[1], scale[1], n[1]));
        let mut sum = 0.0;
        for (y, wy) in wy.iter().enumerate() {
            for (x, wx) in wx.iter().enumerate() {
                sum += wy * wx * data[(y * n[0] + x) * n[2] + at[2]];
            }
        }
        sum
    }

    #[test]
    fn every_pixel_is_the_weighted_sum_on_every_instruction_set_and_thread_count() {
        for ([w, h, n], [dw, dh]) in [
            ([7, 5, 1], [11, 9]),
            ([8, 6, 3], [5, 3]),
            ([1, 9, 4], [3, 4]),
            ([6, 1, 2], [2, 5]),
            ([9, 9, 5], [4, 4]),
        ] {
            let data: Vec<f64> = (0..w * h * n).map(|i| (i * 7919 % 1009) as f64).collect();
            let source = Rows::new(&data, w, h, n, w * n).unwrap();
            let scale = [w as f64 / dw as f64, h as f64 / dh as f64];
            for kernel in [Kernel::Linear, Kernel::Cubic(-0.75), Kernel::Lanczos4, Kernel::Mean] {
                let axes = [
                    Axis::scaled(kernel, w, dw, scale[0]).unwrap(),
                    Axis::scaled(kernel, h, dh, scale[1]).unwrap(),
                ];
                let mut first = None;
                for isa in Isa::available() {
                    for threads in [1, 3] {
                        let mut out = vec![0.0; dw * dh * n];
                        let run = || with_isa(isa, || stretch(&source, &axes, None, &mut out));
                        par::with_threads(Some(threads), run).unwrap().unwrap();
                        assert!(first.get_or_insert_with(|| out.clone()) == &out);
                    }
                }
                for (i, v) in first.unwrap().into_iter().enumerate() {
                    let at = [i / n % dw, i / n / dw, i % n];
                    let want = plainly(&data, [w, h, n], kernel, scale, at);
                    let bound = if kernel == Kernel::Mean { 1e-5 * 1009.0 } else { 1e-9 };
                    assert!((v - want).abs() < bound, "{kernel:?} {w} x {h} {at:?}: {v} {want}");
                }
            }
        }
    }

    #[test]
    fn constants_stay_to_the_last_bit_and_blends_lie_between() {
        let data = [0.1f32; 35];
        let source = Rows::new(&data, 7, 5, 1, 7).unwrap();
        let axes = |kernel| {
            [Axis::scaled(kernel, 7, 3, 7.0 / 3.0), Axis::scaled(kernel, 5, 9, 5.0 / 9.0)].map(Result::unwrap)
        };
        let mut out = [0.0; 27];
        for kernel in [Kernel::Linear, Kernel::Cubic(-0.75), Kernel::Lanczos4, Kernel::Mean] {
            stretch(&source, &axes(kernel), Some((&axes(Kernel::Mean), 0.3)), &mut out).unwrap();
            assert_eq!(out, [0.1; 27]);
        }
        let ramp: Vec<f64> = (0..35).map(|i| f64::from(i * i % 23)).collect();
        let source = Rows::new(&ramp, 7, 5, 1, 7).unwrap();
        let axes = |kernel| {
            [Axis::scaled(kernel, 7, 6, 7.0 / 6.0), Axis::scaled(kernel, 5, 4, 1.25)].map(Result::unwrap)
        };
        let (linear, mean) = (axes(Kernel::Linear), axes(Kernel::Mean));
        let mut found = [[0.0; 24]; 3];
        stretch(&source, &linear, None, &mut found[0]).unwrap();
        stretch(&source, &linear, Some((&mean, 0.25)), &mut found[1]).unwrap();
        stretch(&source, &mean, None, &mut found[2]).unwrap();
        let [linear, blended, mean] = found;
        for ((linear, blended), mean) in linear.iter().zip(&blended).zip(&mean) {
            assert!((blended - (linear + 0.25 * (mean - linear))).abs() < 1e-12);
        }
    }

    #[test]
    fn wrong_sizes_are_refused() {
        let source = Rows::new(&[1u8; 12], 4, 3, 1, 4).unwrap();
        let axis = |n, m| Axis::<f32>::scaled(Kernel::Linear, n, m, n as f64 / m as f64).unwrap();
        let mut out = [0; 6];
        assert!(stretch(&source, &[axis(4, 3), axis(3, 2)], None, &mut out).is_ok());
        assert!(stretch(&source, &[axis(4, 2), axis(3, 2)], None, &mut out).is_err());
        assert!(stretch(&source, &[axis(3, 3), axis(3, 2)], None, &mut out).is_err());
        let other = [axis(4, 6), axis(3, 1)];
        assert!(stretch(&source, &[axis(4, 3), axis(3, 2)], Some((&other, 0.5)), &mut out).is_err());
        assert!(Axis::<f64>::scaled(Kernel::Mean, 4, usize::MAX, 0.1).is_err());
    }
}
