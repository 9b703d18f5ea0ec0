//! From averages to what the caller gets.

use super::places::Places;
use crate::encode::{Encoding, Format, encode};
use crate::filter::{BLOCK, Reader};
use crate::image::Element;
use crate::num::Real;
use crate::texel::DType;
use crate::texture::{Decoder, Plain};

/// Where the results of one group of channels go, from sample `first` on.
pub(super) struct Slots<'a, O> {
    pub(super) out: &'a mut [O],
    pub(super) channels: usize,
    pub(super) group: usize,
    pub(super) first: usize,
}

impl<O: Copy> Slots<'_, O> {
    /// Block by block: places, then averages, then results.
    pub(super) fn fill<R: Real>(
        self,
        places: &dyn Places,
        mut average: impl FnMut(&dyn Places, usize, &mut [[R; 4]]),
        finish: impl Fn([R; 4]) -> [O; 4],
    ) {
        let mut averages = [[R::ZERO; 4]; BLOCK];
        for (block, out) in self.out.chunks_mut(BLOCK * self.channels).enumerate() {
            let count = out.len() / self.channels;
            average(places, self.first + block * BLOCK, &mut averages[..count]);
            for (out, average) in out.chunks_exact_mut(self.channels).zip(&averages) {
                let [x, y, z, w] = finish(*average);
                match &mut out[4 * self.group..] {
                    [a, b, c, d, ..] => (*a, *b, *c, *d) = (x, y, z, w),
                    [a, b, c] => (*a, *b, *c) = (x, y, z),
                    [a, b] => (*a, *b) = (x, y),
                    [a] => *a = x,
                    [] => {}
                }
            }
        }
    }
}

/// From averages to what the caller gets.
pub(super) trait Finish<T: Element, O>: Sync {
    /// Of codes proportional to results.
    fn plain(&self, r: &Reader<'_, T, Plain>, average: [T::Real; 4], group: usize) -> [O; 4];
    /// Of decoded codes.
    fn decoded(&self, r: &Reader<'_, T, Decoder>, average: [T::Real; 4], group: usize) -> [O; 4];
}

/// Numbers: linear, straight where the texture is.
pub(super) struct Results<O>(pub(super) std::marker::PhantomData<O>);

impl<T: Element, O: Real> Finish<T, O> for Results<O> {
    #[inline(always)]
    fn plain(&self, r: &Reader<'_, T, Plain>, average: [T::Real; 4], _group: usize) -> [O; 4] {
        r.finish(average).map(|x| O::from_f64(x.to_f64()))
    }

    #[inline(always)]
    fn decoded(&self, r: &Reader<'_, T, Decoder>, average: [T::Real; 4], _group: usize) -> [O; 4] {
        r.finish(average).map(|x| O::from_f64(x.to_f64()))
    }
}

/// Codes of the texture's own type and encoding, rounded to nearest.
pub(super) struct Codes {
    pub(super) format: Format,
    pub(super) dtype: DType,
}

impl<T: Element, O: Element> Finish<T, O> for Codes {
    #[inline(always)]
    fn plain(&self, r: &Reader<'_, T, Plain>, average: [T::Real; 4], group: usize) -> [O; 4] {
        if T::DTYPE == O::DTYPE && self.format.encoding == Encoding::Linear {
            // Averages of codes are codes: no division and product to disturb a half.
            return average.map(|x| O::from_f64(x.to_f64()));
        }
        self.encoded(r.finish(average), group)
    }

    fn decoded(&self, r: &Reader<'_, T, Decoder>, average: [T::Real; 4], group: usize) -> [O; 4] {
        self.encoded(r.finish(average), group)
    }
}

impl Codes {
    fn encoded<R: Real, O: Element>(&self, results: [R; 4], group: usize) -> [O; 4] {
        std::array::from_fn(|lane| {
            let encoding = self.format.channel_encoding(4 * group + lane);
            O::from_f64(encode(encoding, self.dtype, results[lane].to_f64()))
        })
    }
}
