//! Weighted means of the texels under a footprint, eight at a time.
//!
//! [`soft`] weighs by the distance from the footprint's sides, [`spans`] by integrals along rows, [`ellipse`] by a Gaussian.
//! All read rows of four-channel texels from a [`Source`] and sum differences from a reference texel, so that equal
//! texels give exactly their value.

mod ellipse;
mod soft;
mod spans;
#[cfg(test)]
mod tests;

use super::Isa;
use super::lanes::{LaneWork, Lanes, with_lanes};
pub use ellipse::Ellipse;
pub use soft::Soft;
pub use spans::{LONGEST, Slab, Spans};

/// Texels that are weighed at once.
pub const CHUNK: usize = 8;

/// Where texels come from: four channels each, less a reference.
pub trait Source {
    /// Whether a texel may be infinite or no number.
    const FLOAT: bool;
    /// Texels (first, row) to (first + 7, row), two a value. Those that have no weight may be anything. To be marked
    /// `#[inline(always)]`.
    fn chunk<L: Lanes>(&mut self, row: i64, first: i64) -> [L; 4];
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

/// A mean and what it is of.
struct Of<'m, M, S>(&'m M, S);

impl<M: Mean, S: Source> LaneWork for Of<'_, M, S> {
    type Output = [f32; 4];
    #[inline(always)]
    fn run<L: Lanes>(self) -> [f32; 4] {
        self.0.over::<L, S>(self.1)
    }
}

/// The mean by soft weights, less the reference; see [`Soft`].
pub fn soft(isa: Isa, footprint: &Soft, texels: impl Source) -> [f32; 4] {
    with_lanes(isa, Of(footprint, texels))
}

/// The mean by integrals along rows, less the reference; see [`Spans`].
pub fn spans(isa: Isa, footprint: &Spans<'_>, texels: impl Source) -> [f32; 4] {
    with_lanes(isa, Of(footprint, texels))
}

/// The mean by Gaussian weights, less the reference; see [`Ellipse`].
pub fn ellipse(isa: Isa, footprint: &Ellipse, texels: impl Source) -> [f32; 4] {
    with_lanes(isa, Of(footprint, texels))
}
