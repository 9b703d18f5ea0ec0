//! Where samples lie and what each covers, block by block.

use crate::filter::{BLOCK, Query, Samples, bounded};
use crate::jacobian::Jacobian;
use crate::kernel::{Isa, Work, compiled_for};

/// How large a piece of the texture each sample covers.
#[derive(Clone, Copy, Debug)]
pub enum Extent<'a, U> {
    /// None: every sample is a point.
    Point,
    /// Four numbers a sample: du/dx, du/dy, dv/dx, dv/dy.
    Jacobian(&'a [U]),
    /// One level of detail a sample.
    Lod(&'a [f32]),
}

/// Number type of coordinates.
pub trait Coordinate: Copy + Into<f64> + Sync {}
impl Coordinate for f32 {}
impl Coordinate for f64 {}

/// Where samples lie and what each covers. A function of a sample's number is one: a query in texels of level 0, and a
/// level of detail where it is given outright.
pub(crate) trait Places: Sync {
    /// Those of a block of samples, from `first` on.
    fn fill(&self, first: usize, queries: &mut [(Query, Option<f32>)]);

    /// The same, number by number, without what the Jacobian does not tell.
    fn fill_samples(&self, _isa: Isa, first: usize, count: usize, samples: &mut Samples) {
        let mut queries = [(Query::NOWHERE, None); BLOCK];
        self.fill(first, &mut queries[..count]);
        for (i, (query, lod)) in queries[..count].iter().enumerate() {
            samples.set(i, query, *lod);
        }
    }
}

impl<F: Fn(usize) -> (Query, Option<f32>) + Sync> Places for F {
    fn fill(&self, first: usize, queries: &mut [(Query, Option<f32>)]) {
        for (index, slot) in (first..).zip(queries) {
            let (query, lod) = self(index);
            *slot = (Query { index: index as u64, ..query }.bounded(), lod);
        }
    }
}

/// From arrays of numbers in texture space.
pub(super) struct Arrays<'a, U> {
    pub(super) uv: &'a [U],
    pub(super) extent: Extent<'a, U>,
    pub(super) size: [f64; 2],
}

impl<U: Coordinate> Places for Arrays<'_, U> {
    fn fill(&self, first: usize, queries: &mut [(Query, Option<f32>)]) {
        let [w, h] = self.size;
        let uv = self.uv[2 * first..].chunks_exact(2);
        for (k, (slot, uv)) in queries.iter_mut().zip(uv).enumerate() {
            let index = (first + k) as u64;
            let (s, t) = (uv[0].into() * w, uv[1].into() * h);
            *slot = (Query { s, t, index, ..Query::NOWHERE }, None);
        }
        match self.extent {
            Extent::Point => {}
            Extent::Jacobian(numbers) => {
                for (slot, j) in queries.iter_mut().zip(numbers[4 * first..].chunks_exact(4)) {
                    let [a, b, c, d] = [j[0].into() * w, j[1].into() * w, j[2].into() * h, j[3].into() * h];
                    slot.0.jacobian_tx = Jacobian::new([[a, b], [c, d]]);
                    slot.0 = slot.0.bounded();
                }
            }
            Extent::Lod(lod) => {
                queries.iter_mut().zip(&lod[first..]).for_each(|(slot, lod)| slot.1 = Some(*lod));
            }
        }
    }

    fn fill_samples(&self, isa: Isa, first: usize, count: usize, samples: &mut Samples) {
        compiled_for(isa, Separated { arrays: self, first, count, samples });
    }
}

/// Numbers of a block taken apart, to be compiled for an instruction set.
struct Separated<'a, U> {
    arrays: &'a Arrays<'a, U>,
    first: usize,
    count: usize,
    samples: &'a mut Samples,
}

impl<U: Coordinate> Work for Separated<'_, U> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { arrays, first, count, samples } = self;
        let [w, h] = arrays.size;
        let count = count.min(BLOCK);
        for (i, uv) in arrays.uv[2 * first..2 * (first + count)].chunks_exact(2).enumerate() {
            (samples.s[i], samples.t[i]) = (uv[0].into() * w, uv[1].into() * h);
        }
        match arrays.extent {
            Extent::Point => {}
            Extent::Jacobian(numbers) => {
                for (i, j) in numbers[4 * first..4 * (first + count)].chunks_exact(4).enumerate() {
                    samples.m[0][i] = bounded(j[0].into() * w);
                    samples.m[1][i] = bounded(j[1].into() * w);
                    samples.m[2][i] = bounded(j[2].into() * h);
                    samples.m[3][i] = bounded(j[3].into() * h);
                }
            }
            Extent::Lod(lod) => {
                samples.lod[..count].iter_mut().zip(&lod[first..]).for_each(|(slot, lod)| *slot = Some(*lod));
            }
        }
    }
}
