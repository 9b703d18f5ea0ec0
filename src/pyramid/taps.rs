//! Weights along one axis.

use super::Kind;
use crate::wrap::Wrap;
use std::f64::consts::PI;

/// Half width of both windowed kernels, in texels of the new level.
const RADIUS: f64 = 3.0;
/// Shape of the Kaiser window; more is a wider main lobe with lower side lobes.
const KAISER_ALPHA: f64 = 4.0;

/// For every texel of the new axis the first texel of the old one that it reads (it may lie outside) and
/// `len` weights.
pub(super) struct Taps<R> {
    pub old: usize,
    pub new: usize,
    pub len: usize,
    starts: Vec<i64>,
    weights: Vec<R>,
}

impl<R> Taps<R> {
    pub fn start(&self, i: usize) -> i64 {
        self.starts[i]
    }

    pub fn weights(&self, i: usize) -> &[R] {
        &self.weights[i * self.len..][..self.len]
    }

    /// The weights of all new texels, `len` each.
    pub fn all_weights(&self) -> &[R] {
        &self.weights
    }

    /// How far the taps reach beyond the first and the last texel.
    pub fn overhang(&self) -> (usize, usize) {
        let before = self.starts.iter().map(|s| -s).max().unwrap_or(0).max(0);
        let after = self.starts.iter().map(|s| s + self.len as i64 - self.old as i64).max().unwrap_or(0);
        (before as usize, after.max(0) as usize)
    }

    pub fn new(kind: Kind, old: usize, from_f64: impl Fn(f64) -> R) -> Self {
        let new = (old / 2).max(1);
        let len = match kind {
            _ if old == 1 => 1,
            Kind::Box => 2 + old % 2,
            _ if old.is_multiple_of(2) => 4 * RADIUS as usize,
            // The taps lie up to half a texel off the centre; an odd number of them, as of the texels.
            _ => ((2.0 * RADIUS * old as f64 / new as f64).ceil() as usize + 1) | 1,
        };
        let side = |i: usize| match kind {
            _ if old == 1 => (0, vec![1.0]),
            Kind::Box => (2 * i as i64, box_weights(old, i)),
            Kind::Kaiser => windowed(old, new, i, len, kaiser),
            Kind::Lanczos3 => windowed(old, new, i, len, lanczos3),
        };
        let mut starts = Vec::with_capacity(new);
        let mut weights = Vec::with_capacity(new * len);
        for i in 0..new {
            // The second half mirrors the first, so that a mirrored picture gives mirrored levels.
            let (mirrored, opposite) = (2 * i >= new, new - 1 - i);
            let (start, mut row) = side(if mirrored { opposite } else { i });
            if i == opposite {
                row = (0..len).map(|t| 0.5 * (row[t] + row[len - 1 - t])).collect();
            }
            if mirrored {
                row.reverse();
            }
            starts.push(if mirrored { old as i64 - start - len as i64 } else { start });
            weights.extend(row.into_iter().map(&from_f64));
        }
        Self { old, new, len, starts, weights }
    }
}

/// The mode in which a pyramid reads beyond an edge.
pub(super) fn edge(wrap: Wrap) -> Wrap {
    match wrap {
        Wrap::Border | Wrap::Extend => Wrap::Clamp,
        other => other,
    }
}

fn box_weights(old: usize, i: usize) -> Vec<f64> {
    if old.is_multiple_of(2) {
        return vec![0.5, 0.5];
    }
    let (k, n) = (old / 2, old as f64);
    vec![(k - i) as f64 / n, k as f64 / n, (i + 1) as f64 / n]
}

/// The kernel at the old texels' centres around new texel `i`, corrected to sum 1 and centre 0.
fn windowed(old: usize, new: usize, i: usize, len: usize, kernel: fn(f64) -> f64) -> (i64, Vec<f64>) {
    let ratio = old as f64 / new as f64;
    let centre = (i as f64 + 0.5) * ratio;
    // Texel k has its centre at k + 1/2; the taps lie evenly about the new centre.
    let start = (centre - len as f64 / 2.0).round() as i64;
    let place = |t: usize| (start + t as i64) as f64 + 0.5 - centre;
    let mut weights: Vec<f64> = (0..len).map(|t| kernel(place(t) / ratio)).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|w| *w /= sum);
    // A ramp under a tent moves the centre and not the sum. (The kernels' own second moment is near zero,
    // so a factor a + b x would not do.)
    let tent: Vec<f64> = (0..len).map(|t| (1.0 - (place(t) / ratio).abs()).max(0.0)).collect();
    let middle = (0..len).map(|t| tent[t] * place(t)).sum::<f64>() / tent.iter().sum::<f64>();
    let ramp: Vec<f64> = (0..len).map(|t| tent[t] * (place(t) - middle)).collect();
    let moment = |w: &[f64]| (0..len).map(|t| w[t] * place(t)).sum::<f64>();
    let gain = moment(&weights) / moment(&ramp);
    for (w, r) in weights.iter_mut().zip(&ramp) {
        *w -= gain * r;
    }
    (start, weights)
}

fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) }
}

fn lanczos3(x: f64) -> f64 {
    if x.abs() < RADIUS { sinc(x) * sinc(x / RADIUS) } else { 0.0 }
}

fn kaiser(x: f64) -> f64 {
    let inside = 1.0 - (x / RADIUS) * (x / RADIUS);
    if inside > 0.0 {
        sinc(x) * bessel_i0(KAISER_ALPHA * inside.sqrt()) / bessel_i0(KAISER_ALPHA)
    } else {
        0.0
    }
}

/// Modified Bessel function of the first kind, order 0, by its power series.
fn bessel_i0(x: f64) -> f64 {
    let quarter = x * x / 4.0;
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..40 {
        term *= quarter / f64::from(k * k);
        sum += term;
    }
    sum
}
