//! Batches: tiles over threads, blocks over lanes.

use super::Sampler;
use super::finish::{Codes, Finish, Results, Slots};
use super::places::Places;
use crate::error::Result;
use crate::filter::{BLOCK, Block, Filter, Probes, Query, Reader, Samples, Scratch, Shapes, auto};
use crate::image::Element;
use crate::kernel::lanes::with_lanes;
use crate::kernel::{Isa, Work, compiled_for};
use crate::num::RealsMut;
use crate::par;
use crate::texel::{DType, f16};
use crate::texture::{Decode, Plain, Texture};
use std::marker::PhantomData;

/// Samples a tile: small enough to balance, large enough to be worth a hand-over.
pub(super) const TILE: usize = 4096;

/// A block of samples, to be compiled for an instruction set.
struct Averages<'a, T: Element, D> {
    sampler: &'a Sampler,
    r: &'a Reader<'a, T, D>,
    queries: &'a [(Query, Option<f32>)],
    out: &'a mut [[T::Real; 4]],
}

impl<T: Element, D: Decode<T>> Work for Averages<'_, T, D> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { sampler, r, queries, out } = self;
        let as_given = sampler.lod_bias == 0.0 && queries.iter().all(|(_, lod)| lod.is_none());
        if sampler.filter == Filter::Auto && sampler.tolerance.is_none() && as_given {
            let mut shapes = Shapes::NONE;
            shapes.find(queries);
            for (k, ((query, lod), average)) in queries.iter().zip(out).enumerate() {
                let is_place = query.s.is_finite() && query.t.is_finite();
                *average = match sampler.parts(r, query, *lod) {
                    [1, 1] if is_place => auto(r, query, &shapes.at(k), 1.0),
                    _ => sampler.average(r, query, *lod),
                };
            }
            return;
        }
        for ((query, lod), average) in queries.iter().zip(out) {
            *average = sampler.average(r, query, *lod);
        }
    }
}

impl Sampler {
    /// Results as numbers, in either precision.
    pub(super) fn fill(
        &self,
        texture: &Texture<'_>,
        samples: usize,
        places: &dyn Places,
        out: RealsMut<'_>,
    ) -> Result<()> {
        match out {
            RealsMut::F32(out) => self.typed(texture, samples, places, &Results(PhantomData::<f32>), out),
            RealsMut::F64(out) => self.typed(texture, samples, places, &Results(PhantomData::<f64>), out),
        }
    }

    /// As [`Sampler::sample_places`], with results as codes of the texture's own type and encoding.
    pub(crate) fn sample_codes<O: Element>(
        &self,
        texture: &Texture<'_>,
        samples: usize,
        places: &dyn Places,
        out: &mut [O],
    ) -> Result<()> {
        let codes = Codes { format: texture.format(), dtype: texture.dtype() };
        self.typed(texture, samples, places, &codes, out)
    }

    fn typed<K, O: Copy + Send>(
        &self,
        texture: &Texture<'_>,
        samples: usize,
        places: &dyn Places,
        finish: &K,
        out: &mut [O],
    ) -> Result<()>
    where
        K: Finish<u8, O> + Finish<u16, O> + Finish<f16, O> + Finish<f32, O> + Finish<f64, O>,
    {
        match texture.stored_dtype() {
            DType::U8 => self.batch::<u8, K, O>(texture, samples, places, finish, out),
            DType::U16 => self.batch::<u16, K, O>(texture, samples, places, finish, out),
            DType::F16 => self.batch::<f16, K, O>(texture, samples, places, finish, out),
            DType::F32 => self.batch::<f32, K, O>(texture, samples, places, finish, out),
            DType::F64 => self.batch::<f64, K, O>(texture, samples, places, finish, out),
        }
    }

    fn batch<T: Element, K: Finish<T, O>, O: Copy + Send>(
        &self,
        texture: &Texture<'_>,
        samples: usize,
        places: &dyn Places,
        finish: &K,
        out: &mut [O],
    ) -> Result<()> {
        let channels = texture.channels();
        for group in 0..texture.num_groups() {
            let prepare = || self.layers::<T>(texture, group);
            let small = texture.width() * texture.height() < par::SERIAL;
            let layers = if small { par::with_threads(Some(1), prepare)? } else { prepare()? };
            let isa = Isa::current();
            let tiles = out.chunks_mut(TILE * channels);
            par::for_pixels(samples, tiles, |tile, out| {
                let slots = Slots { out, channels, group, first: tile * TILE };
                if layers.decoder.is_plain() {
                    let plain = Plain { full_scale: layers.decoder.full_scale };
                    let reader = Reader::new(&layers, plain, isa);
                    let averages = self.averages(&reader);
                    slots.fill(places, averages, |average| finish.plain(&reader, average, group));
                } else {
                    let reader = Reader::new(&layers, layers.decoder, isa);
                    let averages = self.averages(&reader);
                    slots.fill(places, averages, |average| finish.decoded(&reader, average, group));
                }
                Ok(())
            })?;
        }
        Ok(())
    }

    /// What averages a block of places.
    fn averages<'r, T: Element, D: Decode<T>>(
        &self,
        r: &'r Reader<'_, T, D>,
    ) -> impl FnMut(&dyn Places, usize, &mut [[T::Real; 4]]) + use<'r, '_, T, D> {
        let sampler = *self;
        let (mut samples, mut scratch) = (Samples::NONE, Scratch::NEW);
        let mut queries = [(Query::NOWHERE, None); BLOCK];
        move |places, first, out| {
            if Probes::has(sampler.filter) && T::DTYPE != DType::F64 {
                places.fill_samples(r.isa, first, out.len(), &mut samples);
                sampler.probes(r, &samples, &mut scratch, out);
            } else {
                let queries = &mut queries[..out.len()];
                places.fill(first, queries);
                sampler.one_by_one(r, queries, out);
            }
        }
    }

    /// Bilinear probes. A function of its own, so that it is compiled once for each kind of texture, however many kinds of
    /// results there are.
    #[inline(never)]
    fn probes<T: Element, D: Decode<T>>(
        &self,
        reader: &Reader<'_, T, D>,
        samples: &Samples,
        scratch: &mut Scratch,
        out: &mut [[T::Real; 4]],
    ) {
        let Self { filter, max_anisotropy, lod_bias, lod_rule, .. } = *self;
        let probes = Probes { filter, max_anisotropy, lod_bias, lod_rule };
        with_lanes(reader.isa, Block { probes, reader, samples, scratch, out });
    }

    /// Samples not yet finished, one after the other.
    #[inline(never)]
    fn one_by_one<T: Element, D: Decode<T>>(
        &self,
        r: &Reader<'_, T, D>,
        queries: &[(Query, Option<f32>)],
        out: &mut [[T::Real; 4]],
    ) {
        compiled_for(r.isa, Averages { sampler: self, r, queries, out });
    }
}
