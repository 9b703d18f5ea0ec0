//! What the vector kernels share: positions of blocks, taken apart a few blocks ahead so that memory can be asked for
//! in time; which pixels a kernel may take; and what happens to the others.

use super::coords::{Buffer, Grid};
use super::sample::Sample;
use super::{Edge, Interpolation, Job, Outside, Points, Source, scalar};
use crate::kernel::Isa;

/// Most pixels of a block.
pub(super) const MOST: usize = 16;

/// Pixels between taking positions apart and reading there, where the source is larger than the caches next to the
/// core. Slanted lines are no pattern that the machine sees: of 48, 64, 128 and 256 pixels ahead 64 were fastest.
const AHEAD: usize = 64;

/// Slots of blocks that are on their way: a power of two, more than blocks in [`AHEAD`] for any set.
const SLOTS: usize = 32;

/// Bytes of a source from which on memory is asked for ahead of time.
const LARGE: usize = 1 << 19;

/// A block of positions, taken apart.
#[repr(align(64))]
pub(super) struct Slot {
    /// Where the first taps are, in bytes from the source's first element; 0 where they are not all inside.
    pub offsets: [u64; MOST],
    /// Fractions along x.
    pub fx: [f32; MOST],
    /// Fractions along y.
    pub fy: [f32; MOST],
    /// One bit a pixel: whether all its taps are inside the bounds.
    pub inside: u32,
    /// One bit a pixel: whether any of its taps may be inside the picture.
    pub near: u32,
    /// Whether rows are further than 32 from that of the first pixel.
    pub scattered: bool,
}

impl Slot {
    const EMPTY: Self =
        Self { offsets: [0; MOST], fx: [0.0; MOST], fy: [0.0; MOST], inside: 0, near: 0, scattered: false };
}

/// What is asked of positions.
pub(super) struct Frame {
    /// Taps before the pixel itself, less the pixels of the apron.
    pub before: i32,
    /// First taps must be below these.
    pub limit: [u32; 2],
    /// `whole part + reach` is below these where any tap can be inside.
    pub span: [u32; 2],
    /// Half the taps.
    pub reach: i32,
    /// Bytes from row to row and from pixel to pixel.
    pub bytes: [u64; 2],
}

/// How an instruction set takes positions apart.
pub(super) trait Set {
    /// Its name.
    const ISA: Isa;
    /// Pixels of a block.
    const LANES: usize;
    /// Takes the positions from `i` on apart.
    ///
    /// # Safety
    /// The machine has the set, and `i + LANES` positions exist.
    unsafe fn take(points: &Points<'_, f32>, i: usize, whole: bool, frame: &Frame, slot: &mut Slot);
    /// Asks for the memory at an address; any will do.
    fn fetch(at: *const u8);
}

/// A block kernel. `rows` points at element 0 of the source.
pub(super) trait Kernel<T> {
    /// Channels.
    const CHANNELS: usize;
    /// Taps an axis.
    const TAPS: usize;
    /// Elements that may be read from a row's first tap on.
    const LOAD: usize;
    /// Whether memory is asked for ahead of time also where neighbours are read from near rows, for every second pixel,
    /// and not only where rows are scattered.
    const FETCHES: bool;
    /// # Safety
    /// The machine has the instruction set of the kernel. From each of the slot's offsets on, in bytes behind `rows`,
    /// and `j * stride` elements further for `j < TAPS`, `LOAD` elements are readable; `out` has room for a block.
    unsafe fn block(&self, rows: *const T, stride: usize, slot: &Slot, out: *mut T);
}

/// How many columns and rows the first tap may be in, counted from 0, so that each of `taps` rows has `load`
/// elements from there on inside the slice.
///
/// For `x < bounds[0]` and `y < bounds[1]`:
/// `(y + taps - 1) * row_stride + x * channels + load <= data.len()`.
fn bounds<T>(source: &Source<'_, T>, taps: usize, load: usize) -> [u32; 2] {
    if source.width < taps || source.height < taps || source.row_stride > (u32::MAX / 16) as usize {
        return [0, 0];
    }
    let columns = source.width - taps + 1;
    let mut rows = source.height - taps + 1;
    let end = |rows: usize| (rows + taps - 2) * source.row_stride + (columns - 1) * source.channels + load;
    while rows > 0 && end(rows) > source.data.len() {
        rows -= 1;
    }
    // Sides are at most 2^30.
    if rows == 0 { [0, 0] } else { [columns as u32, rows as u32] }
}

/// Runs a kernel over all blocks and the scalar code over what it cannot take.
///
/// # Safety
/// The machine has the set, and the function around this one is compiled for it.
#[inline(always)]
pub(super) unsafe fn drive<S: Set, T: Sample<Acc = f32>, K: Kernel<T>>(
    kernel: &K,
    job: &Job<'_, T>,
    points: &Points<'_, f32>,
    out: &mut [T],
) {
    let source = &job.source;
    let count = out.len() / K::CHANNELS;
    let blocks = count / S::LANES;
    let whole = job.interpolation == Interpolation::Nearest;
    let mut rest = Rest::new(S::ISA, job);
    let (read, apron) = job.apron.as_ref().map_or((source, 0), |apron| (&apron.source, apron.width));
    let frame = Frame {
        before: K::TAPS as i32 / 2 - 1 + i32::from(K::TAPS == 1) - apron as i32,
        limit: bounds(read, K::TAPS, K::LOAD),
        // A pixel at -taps/2 - 1 or at the side + taps/2 - 1 and beyond has no tap inside.
        span: [source.width, source.height].map(|n| (n + K::TAPS - 1) as u32),
        reach: K::TAPS as i32 / 2,
        bytes: [read.row_stride * size_of::<T>(), K::CHANNELS * size_of::<T>()].map(|n| n as u64),
    };
    let ahead = if size_of_val(read.data) > LARGE { AHEAD / S::LANES } else { 0 };
    let base = read.data.as_ptr();
    // Many are cleared only where there are many.
    let (mut one, mut many);
    let slots: &mut [Slot] = if ahead == 0 {
        one = [Slot::EMPTY];
        &mut one
    } else {
        many = [Slot::EMPTY; SLOTS];
        &mut many
    };
    let last = slots.len() - 1;
    for step in 0..blocks + ahead {
        if step < blocks {
            let slot = &mut slots[step & last];
            // SAFETY: the machine has the set; there are `blocks` blocks of positions.
            unsafe { S::take(points, step * S::LANES, whole, &frame, slot) };
            if ahead > 0 && (K::FETCHES || slot.scattered) {
                for offset in slot.offsets[..S::LANES].iter().step_by(if slot.scattered { 1 } else { 2 }) {
                    let first = base.wrapping_byte_add(*offset as usize);
                    for row in 0..K::TAPS {
                        S::fetch(first.wrapping_add(row * read.row_stride).cast());
                    }
                }
            }
        }
        if step < ahead {
            continue;
        }
        let start = (step - ahead) * S::LANES;
        let slot = &slots[(step - ahead) & last];
        let pixels = &mut out[start * K::CHANNELS..(start + S::LANES) * K::CHANNELS];
        if slot.inside == u32::MAX >> (32 - S::LANES) {
            // SAFETY: the first taps are below `bounds`, which keeps every load inside the slice.
            unsafe { kernel.block(base, read.row_stride, slot, pixels.as_mut_ptr()) };
        } else if slot.inside == 0 && slot.near == 0 && rest.fills {
            pixels.copy_from_slice(&rest.fill[..pixels.len()]);
        } else {
            let mut made = [T::default(); 4 * MOST];
            if slot.inside != 0 {
                // SAFETY: as above; taps that are not inside have offset 0, where there are as many elements.
                unsafe { kernel.block(base, read.row_stride, slot, made.as_mut_ptr()) };
            }
            rest.mixed(points, start, S::LANES, slot, &made, out);
        }
    }
    rest.pixels(points, blocks * S::LANES, count, out);
}

/// Does blocks that a vector kernel cannot take.
struct Rest<'j, T: Sample> {
    isa: Isa,
    job: &'j Job<'j, T>,
    grid: Grid,
    buffer: Buffer<T::Acc, MOST>,
    /// A block of border colour.
    fill: [T; 4 * MOST],
    /// Whether that is all that a pixel beyond the picture needs.
    fills: bool,
}

impl<'j, T: Sample> Rest<'j, T> {
    /// For a job of up to four channels.
    fn new(isa: Isa, job: &'j Job<'j, T>) -> Self {
        let mut fill = [T::default(); 4 * MOST];
        // Twice as much with every copy: rows of an output may be short, and each comes here.
        let mut made = job.border.len().min(fill.len());
        fill[..made].copy_from_slice(&job.border[..made]);
        while made < fill.len() {
            let more = made.min(fill.len() - made);
            fill.copy_within(..more, made);
            made += more;
        }
        let fills = job.edges == [Edge::Border; 2] && job.outside == Outside::Colour;
        let grid = if job.interpolation == Interpolation::Nearest { Grid::Whole } else { Grid::Exact };
        Self { isa, job, grid, buffer: Buffer::new(), fill, fills }
    }

    /// A block of which some pixels are made already.
    #[inline(never)]
    fn mixed(
        &mut self,
        points: &Points<'_, T::Acc>,
        start: usize,
        lanes: usize,
        slot: &Slot,
        made: &[T; 4 * MOST],
        out: &mut [T],
    ) {
        let channels = self.job.source.channels;
        let fills = self.fills;
        let kind = |i: usize| (slot.inside >> i & 1, fills && slot.near >> i & 1 == 0);
        let mut i = 0;
        while i < lanes {
            let mut end = i + 1;
            while end < lanes && kind(end) == kind(i) {
                end += 1;
            }
            let to = (start + i) * channels..(start + end) * channels;
            match kind(i) {
                (1, _) => out[to].copy_from_slice(&made[i * channels..end * channels]),
                (_, true) => out[to].copy_from_slice(&self.fill[i * channels..end * channels]),
                _ => self.pixels(points, start + i, start + end, out),
            }
            i = end;
        }
    }

    /// Pixels `start..end` of a run, one by one.
    #[inline(never)]
    fn pixels(&mut self, points: &Points<'_, T::Acc>, start: usize, end: usize, out: &mut [T]) {
        let channels = self.job.source.channels;
        for start in (start..end).step_by(MOST) {
            let end = end.min(start + MOST);
            let split = match points {
                Points::Plain(x, y) => {
                    self.buffer.split_f32(self.isa, self.grid, &x[start..end], &y[start..end])
                }
                Points::Row(row) => {
                    let x0 = row.x0 + start as f64;
                    self.buffer.matrix(self.isa, self.grid, row.matrix, x0, row.y, end - start)
                }
                Points::Split(split) => split.part(start, end),
            };
            scalar::run(self.job, &split, &mut out[start * channels..end * channels]);
        }
    }
}
