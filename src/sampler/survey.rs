//! What samples cost, without taking them.

use super::Sampler;
use super::places::{Arrays, Coordinate, Extent, Places};
use super::single::ease;
use crate::error::Result;
use crate::filter::{BLOCK, Effort, Query, Reader, effort};
use crate::image::Element;
use crate::kernel::Isa;
use crate::par;
use crate::texel::{DType, f16};
use crate::texture::{Decode, Plain, Texture};

impl Sampler {
    /// What each sample of a batch costs, and on which level it is made: texels and entries of tables that the filter
    /// looks at, all channels together, and the level of detail, by share of the footprint where there are several.
    ///
    /// # Errors
    /// As [`Sampler::sample`].
    pub fn survey<U: Coordinate>(
        &self,
        texture: &Texture<'_>,
        uv: &[U],
        extent: Extent<'_, U>,
    ) -> Result<Vec<Effort>> {
        let samples = self.fits(uv, extent)?;
        let size = [texture.width() as f64, texture.height() as f64];
        self.survey_places(texture, samples, &Arrays { uv, extent, size })
    }

    /// As [`Sampler::survey`], at these places.
    pub(crate) fn survey_places(
        &self,
        texture: &Texture<'_>,
        samples: usize,
        places: &dyn Places,
    ) -> Result<Vec<Effort>> {
        let mut out = crate::image::zeros::<f32>("out", 2 * samples)?;
        match texture.stored_dtype() {
            DType::U8 => self.efforts::<u8>(texture, places, &mut out),
            DType::U16 => self.efforts::<u16>(texture, places, &mut out),
            DType::F16 => self.efforts::<f16>(texture, places, &mut out),
            DType::F32 => self.efforts::<f32>(texture, places, &mut out),
            DType::F64 => self.efforts::<f64>(texture, places, &mut out),
        }?;
        Ok(out.chunks_exact(2).map(|pair| Effort { cost: pair[0], lod: pair[1] }).collect())
    }

    /// Adds the cost of every group of channels; the level is that of the first.
    fn efforts<T: Element>(&self, texture: &Texture<'_>, places: &dyn Places, out: &mut [f32]) -> Result<()> {
        for group in 0..texture.num_groups() {
            let layers = self.layers::<T>(texture, group)?;
            let isa = Isa::current();
            par::for_each(out.chunks_mut(2 * BLOCK), |block, out| {
                let mut queries = [(Query::NOWHERE, None); BLOCK];
                let queries = &mut queries[..out.len() / 2];
                places.fill(block * BLOCK, queries);
                let put = |effort: &dyn Fn(&Query, Option<f32>) -> Effort, out: &mut [f32]| {
                    for ((query, lod), pair) in queries.iter().zip(out.chunks_exact_mut(2)) {
                        let found = effort(query, *lod);
                        pair[0] += found.cost;
                        if group == 0 {
                            pair[1] = found.lod;
                        }
                    }
                };
                if layers.decoder.is_plain() {
                    let plain = Plain { full_scale: layers.decoder.full_scale };
                    let reader = Reader::new(&layers, plain, isa);
                    put(&|query, lod| self.effort(&reader, query, lod), out);
                } else {
                    let reader = Reader::new(&layers, layers.decoder, isa);
                    put(&|query, lod| self.effort(&reader, query, lod), out);
                }
                Ok(())
            })?;
        }
        Ok(())
    }

    /// What one sample takes.
    fn effort<T: Element, D: Decode<T>>(
        &self,
        r: &Reader<'_, T, D>,
        query: &Query,
        lod: Option<f32>,
    ) -> Effort {
        if !(query.s.is_finite() && query.t.is_finite()) {
            return Effort::default();
        }
        let cut = self.parts(r, query, lod);
        let detail = lod.unwrap_or_else(|| self.lod_rule.lod(query.jacobian_tx)) + self.lod_bias;
        let straight = |query: &Query| {
            let query = query.with_lod(lod, self.lod_bias);
            effort(r, self.filter, &query, detail, self.max_anisotropy, self.tolerance, ease(cut))
        };
        if cut == [1, 1] {
            return straight(query);
        }
        let mut sum = Effort::default();
        let count = (cut[0] * cut[1]) as f32;
        for j in 0..cut[1] {
            for i in 0..cut[0] {
                let part = straight(&query.part(cut, [i, j]));
                sum.cost += part.cost;
                sum.lod += part.lod / count;
            }
        }
        sum
    }
}
