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

/// Most pixels of a block.
const LANES: usize = 16;

/// Does blocks that a vector kernel cannot take.
pub(super) struct Rest<'j, T: Sample> {
    isa: Isa,
    job: &'j Job<'j, T>,
    buffer: Buffer<T::Acc, LANES>,
    /// A block of border colour.
    fill: [T; 4 * LANES],
    /// Whether that is all that a block beyond the picture needs.
    fills: bool,
}

impl<'j, T: Sample> Rest<'j, T> {
    /// For a job of up to four channels.
    pub(super) fn new(isa: Isa, job: &'j Job<'j, T>) -> Self {
        let mut fill = [T::default(); 4 * LANES];
        for pixel in fill.chunks_exact_mut(job.source.channels) {
            pixel.copy_from_slice(job.border);
        }
        let fills = job.edges == [Edge::Border; 2] && job.outside == Outside::Colour;
        Self { isa, job, buffer: Buffer::new(), fill, fills }
    }

    /// Pixels `start..end` of a run, one by one.
    #[inline(never)]
    pub(super) fn pixels(&mut self, points: &Points<'_, T::Acc>, start: usize, end: usize, out: &mut [T]) {
        let channels = self.job.source.channels;
        match points {
            Points::Plain(x, y) => {
                for start in (start..end).step_by(LANES) {
                    let end = end.min(start + LANES);
                    let split = self.buffer.split_f32(self.isa, Grid::Exact, &x[start..end], &y[start..end]);
                    scalar::run(self.job, &split, &mut out[start * channels..end * channels]);
                }
            }
            Points::Split(split) => {
                scalar::run(self.job, &split.part(start, end), &mut out[start * channels..end * channels]);
            }
        }
    }

    /// Whether blocks wholly beyond the picture are filled with the border colour.
    pub(super) fn fills(&self) -> bool {
        self.fills
    }

    /// Pixels of a block wholly beyond the picture.
    pub(super) fn fill(&self, out: &mut [T]) {
        out.copy_from_slice(&self.fill[..out.len()]);
    }
}
