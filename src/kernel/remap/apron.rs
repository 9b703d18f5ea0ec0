//! Small pictures with what lies beyond them laid around them.
//!
//! Of a picture of a few dozen pixels a side a large share of all pixels has taps beyond it, and the rules of edges, tap by
//! tap, take longer than the rest. A copy with an apron as wide as the kernel has none: taps are what they were, and so
//! are results, bit by bit. Pixels further outside are left to the rules.

use super::sample::Sample;
use super::{Interpolation, Job, Outside, Source};

/// Bytes of a picture up to which a copy costs less than it saves.
const SMALL: usize = 1 << 14;

/// Elements behind the last row that kernels may load.
const SLACK: usize = 64;

/// A picture with an apron.
#[derive(Clone, Copy, Debug)]
pub(super) struct Apron<'a, T> {
    pub source: Source<'a, T>,
    /// Pixels on each side.
    pub width: usize,
}

impl<T: Sample> Job<'_, T> {
    /// Pixels on each side that this job reads beyond a picture for a pixel with a tap inside it.
    fn reach(&self) -> usize {
        match self.interpolation {
            Interpolation::Nearest => 0,
            Interpolation::Bilinear => 1,
            Interpolation::Bicubic(_) => 3,
            Interpolation::Lanczos4 => 7,
        }
    }

    /// The picture with its apron, packed, for an output of so many pixels; none where that would not pay.
    pub fn apron(&self, pixels: usize) -> Option<Vec<T>> {
        let s = &self.source;
        let (apron, n) = (self.reach(), s.channels);
        let size = s.width.saturating_mul(s.height).saturating_mul(n * size_of::<T>());
        if apron == 0 || size > SMALL || pixels < s.width * s.height / 2 || self.outside != Outside::Colour {
            return None;
        }
        let row = (s.width + 2 * apron) * n;
        let mut data = Vec::with_capacity(row * (s.height + 2 * apron) + SLACK);
        let around = |axis: usize, size: usize| {
            let edge = self.edges[axis];
            move |i: usize| edge.index(i as i64 - apron as i64, size as i64)
        };
        let (column, line) = (around(0, s.width), around(1, s.height));
        for y in 0..s.height + 2 * apron {
            let Some(y) = line(y) else {
                for _ in 0..s.width + 2 * apron {
                    data.extend_from_slice(self.border);
                }
                continue;
            };
            let pixels = &s.data[y * s.row_stride..][..s.width * n];
            let beyond = |data: &mut Vec<T>, x: usize| match column(x) {
                Some(x) => data.extend_from_slice(&pixels[x * n..(x + 1) * n]),
                None => data.extend_from_slice(self.border),
            };
            (0..apron).for_each(|x| beyond(&mut data, x));
            data.extend_from_slice(pixels);
            (s.width + apron..s.width + 2 * apron).for_each(|x| beyond(&mut data, x));
        }
        data.resize(data.len() + SLACK, T::default());
        Some(data)
    }

    /// The same job, with the apron that [`Job::apron`] made.
    pub fn with_apron<'b>(&'b self, data: &'b [T]) -> Job<'b, T> {
        let (s, width) = (&self.source, self.reach());
        let channels = s.channels;
        let row_stride = (s.width + 2 * width) * channels;
        let source =
            Source { data, width: s.width + 2 * width, height: s.height + 2 * width, channels, row_stride };
        let fits = data.len() >= source.height * row_stride;
        Job { apron: fits.then_some(Apron { source, width }), ..*self }
    }
}
