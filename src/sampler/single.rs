//! One sample: which filter, over which parts of its pixel.

use super::Sampler;
use crate::filter::{Cubic, Filter, Query, Reader, anisotropic, bicubic, bilinear};
use crate::filter::{
    Shape, area, auto, auto_within, ewa, exact, is_smooth, mipmap, nearest, sat, stochastic,
};
use crate::footprint::Bend;
use crate::image::Element;
use crate::num::Real;
use crate::texture::Decode;

impl Sampler {
    /// One sample, not yet finished.
    #[inline(always)]
    pub(super) fn average<T: Element, D: Decode<T>>(
        &self,
        r: &Reader<'_, T, D>,
        query: &Query,
        lod: Option<f32>,
    ) -> [T::Real; 4] {
        match self.parts(r, query, lod) {
            [1, 1] => self.straight(r, query, lod, 1.0),
            parts => self.bent(r, query, parts),
        }
    }

    /// Into how many parts the pixel is cut.
    #[inline(always)]
    pub(super) fn parts<T: Element, D: Decode<T>>(
        &self,
        r: &Reader<'_, T, D>,
        query: &Query,
        lod: Option<f32>,
    ) -> [u32; 2] {
        if query.bend == Bend::None || lod.is_some() || !self.filter.follows_shape() {
            return [1, 1];
        }
        let parts = query.bend.parts(query.jacobian_tx);
        let is_quick = || self.filter == Filter::Auto && self.tolerance.is_none() && is_smooth(r, query);
        if parts == [1, 1] || is_quick() { [1, 1] } else { parts }
    }

    /// The mean over the parts of a bent pixel.
    #[inline(never)]
    fn bent<T: Element, D: Decode<T>>(
        &self,
        r: &Reader<'_, T, D>,
        query: &Query,
        parts: [u32; 2],
    ) -> [T::Real; 4] {
        // A running mean: equal parts give their value.
        let mut mean = [T::Real::ZERO; 4];
        let mut count = 0.0;
        let ease = ease(parts);
        for j in 0..parts[1] {
            for i in 0..parts[0] {
                let value = self.straight(r, &query.part(parts, [i, j]), None, ease);
                count += 1.0;
                let share = T::Real::from_f64(1.0 / count);
                for (mean, value) in mean.iter_mut().zip(value) {
                    *mean += share * (value - *mean);
                }
            }
        }
        mean
    }

    /// One sample whose footprint is a parallelogram; `ease` times the usual error will do.
    #[inline(always)]
    fn straight<T: Element, D: Decode<T>>(
        &self,
        r: &Reader<'_, T, D>,
        query: &Query,
        lod: Option<f32>,
        ease: f64,
    ) -> [T::Real; 4] {
        let (s, t) = (query.s, query.t);
        if !(s.is_finite() && t.is_finite()) {
            return r.outside();
        }
        match self.filter {
            Filter::Nearest => nearest(r, 0, s, t),
            Filter::Bilinear => bilinear(r, 0, s, t),
            Filter::Bicubic => bicubic(r, Cubic::CATMULL_ROM, s, t),
            Filter::Mitchell => bicubic(r, Cubic::MITCHELL, s, t),
            Filter::Ewa => ewa(r, &query.with_lod(lod, self.lod_bias), self.max_anisotropy),
            Filter::Area => area(r, &query.with_lod(lod, self.lod_bias)),
            Filter::Sat => sat(r, &query.with_lod(lod, self.lod_bias)),
            Filter::Exact => exact(r, &query.with_lod(lod, self.lod_bias)),
            Filter::Stochastic => stochastic(r, &query.with_lod(lod, self.lod_bias), self.seed),
            Filter::Auto => {
                let query = query.with_lod(lod, self.lod_bias);
                match self.tolerance {
                    Some(tolerance) => auto_within(r, &query, tolerance),
                    None => auto(r, &query, &Shape::new(query.jacobian_tx), ease),
                }
            }
            Filter::Anisotropic if lod.is_none() => anisotropic(r, query, self.max_anisotropy, self.lod_bias),
            filter => {
                let lod = lod.unwrap_or_else(|| self.lod_rule.lod(query.jacobian_tx)) + self.lod_bias;
                mipmap(r, filter, s, t, lod)
            }
        }
    }
}

/// How much more error each of so many parts may have than their mean.
pub(super) fn ease(parts: [u32; 2]) -> f64 {
    f64::from(parts[0] * parts[1]).sqrt()
}
