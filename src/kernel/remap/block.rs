//! What the vector kernels share: which blocks they may take, and what happens to the others.

use super::coords::{Buffer, Grid};
use super::sample::Sample;
use super::{Edge, Job, Outside, Points, Source, scalar};
use crate::kernel::Isa;

/// How many columns and rows the first tap may be in, counted from 0, so that each of `taps` rows has `load`
/// elements from there on inside the slice.
///
/// For `x < bounds[0]` and `y < bounds[1]`:
/// `(y + taps - 1) * row_stride + x * channels + load <= data.len()`.
pub(super) fn bounds<T>(source: &Source<'_, T>, taps: usize, load: usize) -> [u32; 2] {
    if source.width < taps || source.height < taps || source.row_stride > u32::MAX as usize {
        return [0, 0];
    }
    let columns = source.width - taps + 1;
    let mut rows = source.height - taps + 1;
    let end = |rows: usize| (rows + taps - 2) * source.row_stride + (columns - 1) * source.channels + load;
    while rows > 0 && end(rows) > source.data.len() {
        rows -= 1;
    }
    // Sides are at most 2^30.
    [columns as u32, rows as u32]
}

/// Does blocks that a vector kernel cannot take.
pub(super) struct Rest<'j, T: Sample> {
    isa: Isa,
    job: &'j Job<'j, T>,
    buffer: Buffer<T::Acc>,
    /// Border colour of a block, where that is all that a pixel beyond the picture needs.
    fill: Option<Vec<T>>,
}

impl<'j, T: Sample> Rest<'j, T> {
    /// For blocks of up to `lanes` pixels.
    pub(super) fn new(isa: Isa, job: &'j Job<'j, T>, lanes: usize) -> Self {
        let plain = job.edges == [Edge::Border; 2] && job.outside == Outside::Colour;
        Self { isa, job, buffer: Buffer::new(), fill: plain.then(|| job.border.repeat(lanes)) }
    }

    /// Pixels `start..end` of a run, one by one.
    #[inline(never)]
    pub(super) fn pixels(&mut self, points: &Points<'_, T::Acc>, start: usize, end: usize, out: &mut [T]) {
        let channels = self.job.source.channels;
        let out = &mut out[start * channels..end * channels];
        match points {
            Points::Plain(x, y) => {
                let split = self.buffer.split_f32(self.isa, Grid::Exact, &x[start..end], &y[start..end]);
                scalar::run(self.job, &split, out);
            }
            Points::Split(split) => scalar::run(self.job, &split.part(start, end), out),
        }
    }

    /// Whether blocks wholly beyond the picture are filled with the border colour.
    pub(super) fn fills(&self) -> bool {
        self.fill.is_some()
    }

    /// Pixels of a block wholly beyond the picture.
    pub(super) fn fill(&self, out: &mut [T]) {
        if let Some(fill) = &self.fill {
            out.copy_from_slice(&fill[..out.len()]);
        }
    }
}
