//! One axis of a box: which texels it holds, how often and with which share.

use crate::wrap::Wrap;

/// Texels `start..end` of the image, each counted `weight` times.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Run {
    pub start: usize,
    pub end: usize,
    pub weight: f64,
}

/// The image's texels on one side of a box. All weights are positive: nothing cancels.
pub(super) struct Axis {
    runs: [Run; 20],
    len: usize,
    /// Length of the side, in texels.
    pub length: f64,
    /// The part of it that lies on texels rather than on the border colour.
    pub inside: f64,
}

impl Axis {
    pub fn runs(&self) -> &[Run] {
        &self.runs[..self.len]
    }

    /// The side from `x0` to `x1 >= x0` (finite, in texels) of an axis of `n`.
    pub fn new(wrap: Wrap, x0: f64, x1: f64, n: usize) -> Self {
        let mut axis = Self { runs: [Run::default(); 20], len: 0, length: x1 - x0, inside: x1 - x0 };
        let size = n as f64;
        if x0 >= 0.0 && x1 <= size {
            axis.segment(x0, x1);
            return axis;
        }
        match wrap {
            Wrap::Clamp | Wrap::Extend => axis.clamp(x0, x1, n),
            Wrap::Border => {
                let (a, b) = (x0.clamp(0.0, size), x1.clamp(0.0, size));
                axis.inside = b - a;
                axis.segment(a, b);
            }
            Wrap::MirrorOnce => {
                axis.clamp((-x1).max(0.0), (-x0).max(0.0), n);
                axis.clamp(x0.max(0.0), x1.max(0.0), n);
            }
            Wrap::Mirror101 if n == 1 => axis.push(0, 1, x1 - x0),
            Wrap::Repeat | Wrap::Mirror => axis.periods(x0, x1, size, |axis, k, a, b| {
                let backwards = wrap == Wrap::Mirror && k.rem_euclid(2.0) == 1.0;
                if backwards { axis.segment(size - b, size - a) } else { axis.segment(a, b) }
            }),
            Wrap::Mirror101 => axis.periods(x0, x1, 2.0 * size - 2.0, |axis, _, a, b| {
                axis.segment(a.min(size), b.min(size));
                // The way back: texels n-2 down to 1.
                let back = |t: f64| 2.0 * size - 1.0 - t.max(size);
                axis.segment(back(b), back(a));
            }),
        }
        axis
    }

    /// The texel at `x`, as a side of length 1; none where the border colour is.
    pub fn point(wrap: Wrap, x: f64, n: usize) -> Self {
        let mut axis = Self { runs: [Run::default(); 20], len: 0, length: 1.0, inside: 0.0 };
        let wrap = if wrap == Wrap::Extend { Wrap::Clamp } else { wrap };
        let (reduced, _) = wrap.reduce(x, n as f64);
        // One step outside says as much as any.
        let nearest = reduced.floor().clamp(-1.0, n as f64) as i64;
        let index = wrap.index(nearest, n as i64);
        if let Some(i) = index {
            axis.push(i as usize, i as usize + 1, 1.0);
            axis.inside = 1.0;
        }
        axis
    }

    /// Scales the side to length 1, where its own length squared is no normal number.
    pub fn tame(&mut self) {
        if !(1e-100..1e100).contains(&self.length) {
            self.runs[..self.len].iter_mut().for_each(|run| run.weight /= self.length);
            self.inside /= self.length;
            self.length = 1.0;
        }
    }

    fn push(&mut self, start: usize, end: usize, weight: f64) {
        if end > start && weight > 0.0 {
            self.runs[self.len] = Run { start, end, weight };
            self.len += 1;
        }
    }

    /// Texels from `a` to `b`, both inside the image.
    fn segment(&mut self, a: f64, b: f64) {
        let (i, k) = (a.floor(), b.floor());
        let (start, end) = (i as usize, k as usize);
        if start == end {
            self.push(start, start + 1, b - a);
            return;
        }
        let first = if a == i { start } else { start + 1 };
        self.push(start, first, 1.0 - (a - i));
        self.push(first, end, 1.0);
        self.push(end, end + 1, b - k);
    }

    fn clamp(&mut self, x0: f64, x1: f64, n: usize) {
        let size = n as f64;
        self.push(0, 1, x1.min(0.0) - x0.min(0.0));
        self.segment(x0.clamp(0.0, size), x1.clamp(0.0, size));
        self.push(n - 1, n, x1.max(size) - x0.max(size));
    }

    /// Cuts a side at multiples of `period`; `part(axis, k, a, b)` adds the piece `a..b` of period `k`.
    fn periods(&mut self, x0: f64, x1: f64, period: f64, part: impl Fn(&mut Self, f64, f64, f64)) {
        let (k0, k1) = ((x0 / period).floor(), (x1 / period).floor());
        let local = |x: f64, k: f64| (x - k * period).clamp(0.0, period);
        if k0 == k1 {
            part(self, k0, local(x0, k0), local(x1, k1));
            return;
        }
        part(self, k0, local(x0, k0), period);
        part(self, k1, 0.0, local(x1, k1));
        let whole = k1 - k0 - 1.0;
        if whole > 0.0 {
            let before = self.len;
            part(self, k0, 0.0, period);
            self.runs[before..self.len].iter_mut().for_each(|run| run.weight *= whole);
        }
    }
}
