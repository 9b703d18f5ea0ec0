//! Weighted means of the texels under a footprint, eight at a time.
//!
//! [`soft`] weighs by the distance from the footprint's sides, [`spans`] by integrals along rows. Both read rows of
//! four-channel texels, in place or through a closure, and sum differences from a reference texel, so that equal
//! texels give exactly their value.

mod soft;
mod spans;
#[cfg(test)]
mod tests;

use super::Isa;
#[cfg(target_arch = "x86_64")]
use super::lanes::Avx2;
use super::lanes::{Lanes, Portable};
pub use soft::{Soft, Strip};
pub use spans::{LONGEST, Slab, Spans};

/// Texels that are weighed at once.
pub const CHUNK: usize = 8;

/// Fills in 8 texels of 4 channels from a row (first argument) and a column (second) on.
pub type Fetch<'a> = dyn FnMut(i64, i64, &mut [f32; 4 * CHUNK]) + 'a;

/// Rows of four-channel texels around a footprint.
pub enum Rows<'a, 'f> {
    /// Bytes in place.
    U8(Grid<'a, u8>),
    /// Words in place.
    U16(Grid<'a, u16>),
    /// Singles in place.
    F32(Grid<'a, f32>),
    /// Any texels, as differences from the reference.
    Fetch(&'f mut Fetch<'f>),
}

/// Texels in place, four elements each: texel (x, y) begins at `origin + y row + 4 x`.
#[derive(Clone, Copy)]
pub struct Grid<'a, E> {
    /// The elements.
    pub data: &'a [E],
    /// Index of texel (0, 0).
    pub origin: usize,
    /// Elements from one row to the next.
    pub row: usize,
    /// What is subtracted from every texel.
    pub reference: [f32; 4],
}

/// An element that lanes can be loaded from.
trait Load: Copy {
    /// Whether an element may be infinite or no number.
    const FLOAT: bool;
    fn load<L: Lanes>(from: &[Self; 8]) -> L;
}

impl Load for u8 {
    const FLOAT: bool = false;
    #[inline(always)]
    fn load<L: Lanes>(from: &[Self; 8]) -> L {
        L::load_u8(from)
    }
}

impl Load for u16 {
    const FLOAT: bool = false;
    #[inline(always)]
    fn load<L: Lanes>(from: &[Self; 8]) -> L {
        L::load_u16(from)
    }
}

impl Load for f32 {
    const FLOAT: bool = true;
    #[inline(always)]
    fn load<L: Lanes>(from: &[Self; 8]) -> L {
        L::load(from)
    }
}

/// Where a chunk of texels comes from.
trait Source {
    const FLOAT: bool;
    /// Texels (row, first) to (row, first + 7), two a value, less the reference.
    fn chunk<L: Lanes>(&mut self, row: i64, first: i64) -> [L; 4];
}

impl<E: Load> Source for Grid<'_, E> {
    const FLOAT: bool = E::FLOAT;
    #[inline(always)]
    fn chunk<L: Lanes>(&mut self, row: i64, first: i64) -> [L; 4] {
        let start = self.origin as isize + row as isize * self.row as isize + 4 * first as isize;
        let texels: &[E] = &self.data[start as usize..start as usize + 4 * CHUNK];
        let [a, b, c, d] = self.reference;
        let reference = L::load(&[a, b, c, d, a, b, c, d]);
        let ([a, b, c, d], _) = texels.as_chunks::<8>() else { unreachable!() };
        [
            E::load::<L>(a).sub(reference),
            E::load::<L>(b).sub(reference),
            E::load::<L>(c).sub(reference),
            E::load::<L>(d).sub(reference),
        ]
    }
}

impl Source for &mut Fetch<'_> {
    const FLOAT: bool = true;
    #[inline(always)]
    fn chunk<L: Lanes>(&mut self, row: i64, first: i64) -> [L; 4] {
        let mut texels = [0.0; 4 * CHUNK];
        self(row, first, &mut texels);
        let ([a, b, c, d], _) = texels.as_chunks::<8>() else { unreachable!() };
        [L::load(a), L::load(b), L::load(c), L::load(d)]
    }
}

/// A weighted sum under construction. Texels at even places are summed in the first four lanes of both totals,
/// those at odd places in the others.
#[derive(Clone, Copy)]
struct Sum<L> {
    total: [L; 2],
    weight: L,
}

impl<L: Lanes> Sum<L> {
    #[inline(always)]
    fn new() -> Self {
        Self { total: [L::splat(0.0); 2], weight: L::splat(0.0) }
    }

    /// Adds eight texels with their weights.
    #[inline(always)]
    fn add<S: Source>(&mut self, source: &mut S, row: i64, first: i64, weights: L) {
        let [a, b, c, d] = source.chunk::<L>(row, first);
        self.weight = self.weight.add(weights);
        self.total[0] = self.total[0].add(product::<L, S>(a, weights.spread::<0>()));
        self.total[1] = self.total[1].add(product::<L, S>(b, weights.spread::<1>()));
        self.total[0] = self.total[0].add(product::<L, S>(c, weights.spread::<2>()));
        self.total[1] = self.total[1].add(product::<L, S>(d, weights.spread::<3>()));
    }

    /// The mean, less the reference.
    #[inline(always)]
    fn mean(self) -> [f32; 4] {
        let total = self.total[0].add(self.total[1]).store();
        let w = self.weight.store();
        let weight = ((w[0] + w[4]) + (w[1] + w[5])) + ((w[2] + w[6]) + (w[3] + w[7]));
        std::array::from_fn(|c| (total[c] + total[c + 4]) / weight)
    }
}

/// Texels times weights; what is not finite counts only where it has weight.
#[inline(always)]
fn product<L: Lanes, S: Source>(texels: L, weights: L) -> L {
    if S::FLOAT { texels.where_not_zero(weights).mul(weights) } else { texels.mul(weights) }
}

/// A mean over rows, written once for all lanes and sources. No closure may touch lanes: a closure that is not inlined
/// is not compiled for the set, and each operation becomes a call.
trait Mean {
    fn over<L: Lanes, S: Source>(&self, source: S) -> [f32; 4];
}

#[inline(always)]
fn run<M: Mean, S: Source>(isa: Isa, mean: &M, source: S) -> [f32; 4] {
    match isa {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: a set other than `Scalar` is in use only where the machine has it, and both have AVX2.
        Isa::Avx2 | Isa::Avx512 if isa.is_supported() => unsafe { with_avx2(mean, source) },
        _ => mean.over::<Portable, S>(source),
    }
}

/// # Safety
/// The machine must have AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
unsafe fn with_avx2<M: Mean, S: Source>(mean: &M, source: S) -> [f32; 4] {
    mean.over::<Avx2, S>(source)
}

fn dispatch<M: Mean>(isa: Isa, mean: &M, rows: Rows<'_, '_>) -> [f32; 4] {
    match rows {
        Rows::U8(grid) => run(isa, mean, grid),
        Rows::U16(grid) => run(isa, mean, grid),
        Rows::F32(grid) => run(isa, mean, grid),
        Rows::Fetch(fetch) => run(isa, mean, fetch),
    }
}

/// The mean by soft weights, less the reference; see [`Soft`].
pub fn soft(isa: Isa, footprint: &Soft, rows: Rows<'_, '_>) -> [f32; 4] {
    dispatch(isa, footprint, rows)
}

/// The mean by integrals along rows, less the reference; see [`Spans`].
pub fn spans(isa: Isa, footprint: &Spans<'_>, rows: Rows<'_, '_>) -> [f32; 4] {
    dispatch(isa, footprint, rows)
}
