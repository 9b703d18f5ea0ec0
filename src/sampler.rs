//! How to sample: a filter with its limits, over batches of places.

use crate::encode::{Encoding, Format, encode};
use crate::error::{Error, Result};
use crate::filter::{
    BLOCK, Block, Cubic, Filter, Probes, Query, Reader, Samples, Scratch, anisotropic, bicubic,
    bicubic_gradient, bilinear, bilinear_gradient,
};
use crate::filter::{Effort, area, auto, auto_within, bounded, effort, ewa, exact, is_smooth};
use crate::filter::{mipmap, nearest, sat, stochastic};
use crate::footprint::Bend;
use crate::image::Element;
use crate::jacobian::Jacobian;
use crate::kernel::lanes::with_lanes;
use crate::kernel::{Isa, Work, compiled_for};
use crate::lod::LodRule;
use crate::num::Real;
use crate::par;
use crate::texel::{DType, f16};
use crate::texture::{Decode, Decoder, Layers, Plain, Texture};

/// Samples a tile: small enough to balance, large enough to be worth a hand-over.
const TILE: usize = 4096;
/// Calls with fewer samples stay on the calling thread.
const SERIAL: usize = 10_000;

/// A filter and its options.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampler {
    /// The filter.
    pub filter: Filter,
    /// Longest footprint, in widths, that [`Filter::Anisotropic`] follows; 1 or more; more than 1024 counts as 1024.
    pub max_anisotropy: f64,
    /// Added to every level of detail.
    pub lod_bias: f32,
    /// Which extent of a footprint decides about the level of the isotropic filters.
    pub lod_rule: LodRule,
    /// Largest error of [`Filter::Auto`], in units of the result; `None` for its default.
    pub tolerance: Option<f64>,
    /// Seed of [`Filter::Stochastic`]: the same seed gives the same samples.
    pub seed: u64,
}

impl Default for Sampler {
    fn default() -> Self {
        Self {
            filter: Filter::Auto,
            max_anisotropy: 16.0,
            lod_bias: 0.0,
            lod_rule: LodRule::Major,
            tolerance: None,
            seed: 0,
        }
    }
}

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

/// Where the results of one group of channels go, from sample `first` on.
struct Slots<'a, O> {
    out: &'a mut [O],
    channels: usize,
    group: usize,
    first: usize,
}

impl<O: Copy> Slots<'_, O> {
    /// Block by block: places, then averages, then results.
    fn fill<R: Real>(
        self,
        places: &dyn Fill,
        mut average: impl FnMut(&dyn Fill, usize, &mut [[R; 4]]),
        finish: impl Fn([R; 4]) -> [O; 4],
    ) {
        let mut averages = [[R::ZERO; 4]; BLOCK];
        for (block, out) in self.out.chunks_mut(BLOCK * self.channels).enumerate() {
            let count = out.len() / self.channels;
            average(places, self.first + block * BLOCK, &mut averages[..count]);
            for (out, average) in out.chunks_exact_mut(self.channels).zip(&averages) {
                for (out, value) in out[4 * self.group..].iter_mut().zip(finish(*average)) {
                    *out = value;
                }
            }
        }
    }
}

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
        for ((query, lod), average) in self.queries.iter().zip(self.out) {
            *average = self.sampler.average(self.r, query, *lod);
        }
    }
}

/// Where sample `i` lies and what it covers.
pub(crate) type Places<'a> = dyn Fn(usize) -> (Query, Option<f32>) + Sync + 'a;

/// Where a block of samples, from `first` on, lies and what each covers.
trait Fill: Sync {
    fn fill(&self, first: usize, queries: &mut [(Query, Option<f32>)]);

    /// The same, number by number.
    fn fill_samples(&self, _isa: Isa, first: usize, count: usize, samples: &mut Samples) {
        let mut queries = [(Query::NOWHERE, None); BLOCK];
        self.fill(first, &mut queries[..count]);
        for (i, (query, lod)) in queries[..count].iter().enumerate() {
            samples.set(i, query, *lod);
        }
    }
}

/// One by one.
struct Each<'a>(&'a Places<'a>);

impl Fill for Each<'_> {
    fn fill(&self, first: usize, queries: &mut [(Query, Option<f32>)]) {
        for (index, slot) in (first..).zip(queries) {
            let (query, lod) = self.0(index);
            *slot = (Query { index: index as u64, ..query }.bounded(), lod);
        }
    }
}

/// From arrays of numbers in texture space.
struct Arrays<'a, U> {
    uv: &'a [U],
    extent: Extent<'a, U>,
    size: [f64; 2],
}

impl<U: Coordinate> Fill for Arrays<'_, U> {
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

/// From averages to what the caller gets.
trait Finish<T: Element, O>: Sync {
    /// Of codes proportional to results.
    fn plain(&self, r: &Reader<'_, T, Plain>, average: [T::Real; 4], group: usize) -> [O; 4];
    /// Of decoded codes.
    fn decoded(&self, r: &Reader<'_, T, Decoder>, average: [T::Real; 4], group: usize) -> [O; 4];
}

/// Numbers: linear, straight where the texture is.
struct Results<O>(std::marker::PhantomData<O>);

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
struct Codes {
    format: Format,
    dtype: DType,
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

impl Sampler {
    /// A sampler with this filter and default options.
    pub fn new(filter: Filter) -> Self {
        Self { filter, ..Self::default() }
    }

    /// Whether every sample with a footprint of at most a texel is the bilinear reconstruction at its centre.
    pub fn magnifies_bilinearly(&self) -> bool {
        // A tolerance is about the mean over the footprint, however small.
        self.filter.magnifies_bilinearly() && !(self.filter == Filter::Auto && self.tolerance.is_some())
    }

    /// Checks the options.
    ///
    /// # Errors
    /// [`Error::Value`] for a limit of anisotropy below 1 or a bias that is not finite.
    pub fn check(&self) -> Result<()> {
        if self.max_anisotropy.is_nan() || self.max_anisotropy < 1.0 {
            return Err(Error::value("max_anisotropy", self.max_anisotropy, "a number of 1 or more"));
        }
        if !self.lod_bias.is_finite() {
            return Err(Error::value("lod_bias", self.lod_bias, "a finite number"));
        }
        if let Some(tolerance) = self.tolerance.filter(|t| t.is_nan() || *t <= 0.0) {
            return Err(Error::value("tolerance", tolerance, "None or a positive number"));
        }
        Ok(())
    }

    /// Samples at points: `uv` holds two numbers a sample, `out` receives the channels of each.
    ///
    /// # Errors
    /// As [`Sampler::sample`].
    pub fn sample_points<U: Coordinate, O: Real>(
        &self,
        texture: &Texture<'_>,
        uv: &[U],
        out: &mut [O],
    ) -> Result<()> {
        self.sample(texture, uv, Extent::Point, out)
    }

    /// Samples a batch. `uv` holds u and v of each sample in texture space (texel (i, j) of level 0 has its
    /// centre at ((i + 1/2)/width, (j + 1/2)/height)); `out` receives `texture.channels()` numbers a sample.
    /// A coordinate that is not finite gives the border colour. The result does not depend on threads.
    ///
    /// # Errors
    /// [`Error::Value`] when lengths do not fit together or options are out of range.
    pub fn sample<U: Coordinate, O: Real>(
        &self,
        texture: &Texture<'_>,
        uv: &[U],
        extent: Extent<'_, U>,
        out: &mut [O],
    ) -> Result<()> {
        let samples = self.fits(uv, extent)?;
        let numbers = samples * texture.channels();
        if out.len() != numbers {
            let expected = format!("{numbers} for {samples} samples");
            return Err(Error::value("out", format!("{} numbers", out.len()), expected));
        }
        let (w, h) = (texture.width() as f64, texture.height() as f64);
        self.sample_filled(texture, samples, &Arrays { uv, extent, size: [w, h] }, out)
    }

    /// The number of samples, if options and lengths are in order.
    fn fits<U: Coordinate>(&self, uv: &[U], extent: Extent<'_, U>) -> Result<usize> {
        self.check()?;
        let samples = uv.len() / 2;
        let expect = |argument, got: usize, expected: usize| {
            if got == expected {
                return Ok(());
            }
            let expected = format!("{expected} for {samples} samples");
            Err(Error::value(argument, format!("{got} numbers"), expected))
        };
        expect("uv", uv.len(), samples * 2)?;
        match extent {
            Extent::Point => {}
            Extent::Jacobian(jacobian) => expect("jacobian", jacobian.len(), samples * 4)?,
            Extent::Lod(lod) => expect("lod", lod.len(), samples)?,
        }
        Ok(samples)
    }

    /// Samples at the places that `places(i)` names: a query in texels of level 0, and a level of detail
    /// where it is given outright.
    pub(crate) fn sample_places<O: Real>(
        &self,
        texture: &Texture<'_>,
        samples: usize,
        places: &Places<'_>,
        out: &mut [O],
    ) -> Result<()> {
        self.sample_filled(texture, samples, &Each(places), out)
    }

    fn sample_filled<O: Real>(
        &self,
        texture: &Texture<'_>,
        samples: usize,
        places: &dyn Fill,
        out: &mut [O],
    ) -> Result<()> {
        let result = Results::<O>(std::marker::PhantomData);
        match texture.stored_dtype() {
            DType::U8 => self.batch::<u8, _, O>(texture, samples, places, &result, out),
            DType::U16 => self.batch::<u16, _, O>(texture, samples, places, &result, out),
            DType::F16 => self.batch::<f16, _, O>(texture, samples, places, &result, out),
            DType::F32 => self.batch::<f32, _, O>(texture, samples, places, &result, out),
            DType::F64 => self.batch::<f64, _, O>(texture, samples, places, &result, out),
        }
    }

    /// As [`Sampler::sample_places`], with results as codes of the texture's own type and encoding.
    pub(crate) fn sample_codes<O: Element>(
        &self,
        texture: &Texture<'_>,
        samples: usize,
        places: &Places<'_>,
        out: &mut [O],
    ) -> Result<()> {
        let codes = Codes { format: texture.format(), dtype: texture.dtype() };
        let places: &dyn Fill = &Each(places);
        match texture.stored_dtype() {
            DType::U8 => self.batch::<u8, _, O>(texture, samples, places, &codes, out),
            DType::U16 => self.batch::<u16, _, O>(texture, samples, places, &codes, out),
            DType::F16 => self.batch::<f16, _, O>(texture, samples, places, &codes, out),
            DType::F32 => self.batch::<f32, _, O>(texture, samples, places, &codes, out),
            DType::F64 => self.batch::<f64, _, O>(texture, samples, places, &codes, out),
        }
    }

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
        self.survey_filled(texture, samples, &Arrays { uv, extent, size })
    }

    /// As [`Sampler::survey`], at the places that `places(i)` names.
    pub(crate) fn survey_places(
        &self,
        texture: &Texture<'_>,
        samples: usize,
        places: &Places<'_>,
    ) -> Result<Vec<Effort>> {
        self.survey_filled(texture, samples, &Each(places))
    }

    fn survey_filled(&self, texture: &Texture<'_>, samples: usize, places: &dyn Fill) -> Result<Vec<Effort>> {
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
    fn efforts<T: Element>(&self, texture: &Texture<'_>, places: &dyn Fill, out: &mut [f32]) -> Result<()> {
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

    /// The levels and tables that the filter reads. They are made here, on the calling thread, before work is handed out.
    fn layers<'t, T: Element>(&self, texture: &'t Texture<'_>, group: usize) -> Result<Layers<'t, T>> {
        let mut layers = texture.layers::<T>(group, self.filter.uses_levels())?;
        if self.filter == Filter::Sat {
            layers.sums = Some(texture.table::<T>(group)?);
        }
        match (self.filter, self.tolerance) {
            (Filter::Auto, Some(_)) => layers.bounds = Some(texture.bounds::<T>(group)?),
            (Filter::Auto, None) => layers.detail = Some(texture.detail::<T>(group)?),
            _ => {}
        }
        Ok(layers)
    }

    fn batch<T: Element, K: Finish<T, O>, O: Copy + Send>(
        &self,
        texture: &Texture<'_>,
        samples: usize,
        places: &dyn Fill,
        finish: &K,
        out: &mut [O],
    ) -> Result<()> {
        let channels = texture.channels();
        for group in 0..texture.num_groups() {
            let layers = self.layers::<T>(texture, group)?;
            let isa = Isa::current();
            let tiles = out.chunks_mut(TILE * channels);
            let run = || {
                par::for_each(tiles, |tile, out| {
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
                })
            };
            if samples < SERIAL { par::with_threads(Some(1), run)? } else { run()? }
        }
        Ok(())
    }

    /// What averages a block of places.
    fn averages<'r, T: Element, D: Decode<T>>(
        &self,
        r: &'r Reader<'_, T, D>,
    ) -> impl FnMut(&dyn Fill, usize, &mut [[T::Real; 4]]) + use<'r, '_, T, D> {
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

    /// One sample, not yet finished.
    #[inline(always)]
    fn average<T: Element, D: Decode<T>>(
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
    fn parts<T: Element, D: Decode<T>>(
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
                    None => auto(r, &query, ease),
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
fn ease(parts: [u32; 2]) -> f64 {
    f64::from(parts[0] * parts[1]).sqrt()
}

/// Derivatives of the reconstruction by u and v: `out` receives `texture.channels()` pairs a point.
///
/// `filter` is [`Filter::Bilinear`] (on the line through texel centres the slope towards larger coordinates),
/// [`Filter::Bicubic`] or [`Filter::Mitchell`]. Straight colour `P/A` has the derivative `(P' - (P/A) A')/A`.
/// A coordinate that is not finite gives 0.
///
/// # Errors
/// [`Error::Value`] when lengths do not fit together or the filter is another.
pub fn gradient<U: Coordinate, O: Real>(
    texture: &Texture<'_>,
    filter: Filter,
    uv: &[U],
    out: &mut [O],
) -> Result<()> {
    let samples = uv.len() / 2;
    if uv.len() != 2 * samples || out.len() != samples * texture.channels() * 2 {
        let expected = format!("2 numbers a point and {} results a point", texture.channels() * 2);
        return Err(Error::value("uv", format!("{} numbers and room for {}", uv.len(), out.len()), expected));
    }
    if !matches!(filter, Filter::Bilinear | Filter::Bicubic | Filter::Mitchell) {
        return Err(Error::value(
            "filter",
            format!("{filter:?}"),
            "\"bilinear\", \"bicubic\" or \"mitchell\"",
        ));
    }
    match texture.stored_dtype() {
        DType::U8 => gradient_typed::<u8, U, O>(texture, filter, uv, out),
        DType::U16 => gradient_typed::<u16, U, O>(texture, filter, uv, out),
        DType::F16 => gradient_typed::<f16, U, O>(texture, filter, uv, out),
        DType::F32 => gradient_typed::<f32, U, O>(texture, filter, uv, out),
        DType::F64 => gradient_typed::<f64, U, O>(texture, filter, uv, out),
    }
}

fn gradient_typed<T: Element, U: Coordinate, O: Real>(
    texture: &Texture<'_>,
    filter: Filter,
    uv: &[U],
    out: &mut [O],
) -> Result<()> {
    let size = [texture.width() as f64, texture.height() as f64];
    let channels = texture.channels();
    for group in 0..texture.num_groups() {
        let layers = texture.layers::<T>(group, false)?;
        par::for_each(out.chunks_mut(TILE * channels * 2), |tile, out| {
            for (k, out) in out.chunks_exact_mut(channels * 2).enumerate() {
                let i = 2 * (tile * TILE + k);
                let (s, t) = (uv[i].into() * size[0], uv[i + 1].into() * size[1]);
                let pairs = if layers.decoder.is_plain() {
                    let plain = Plain { full_scale: layers.decoder.full_scale };
                    slopes(&Reader::new(&layers, plain, Isa::current()), filter, s, t)
                } else {
                    slopes(&Reader::new(&layers, layers.decoder, Isa::current()), filter, s, t)
                };
                let signs = [texture.wrap()[0].reduce(s, size[0]).1, texture.wrap()[1].reduce(t, size[1]).1];
                for (out, pair) in out[8 * group..].chunks_exact_mut(2).zip(pairs) {
                    for axis in 0..2 {
                        out[axis] = O::from_f64(pair[axis].to_f64() * size[axis] * signs[axis]);
                    }
                }
            }
            Ok(())
        })?;
    }
    Ok(())
}

/// Derivatives of each lane's result by s and t.
fn slopes<T: Element, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    filter: Filter,
    s: f64,
    t: f64,
) -> [[T::Real; 2]; 4] {
    if !(s.is_finite() && t.is_finite()) {
        return [[T::Real::ZERO; 2]; 4];
    }
    let [value, ds, dt] = match filter {
        Filter::Bilinear => bilinear_gradient(r, s, t),
        Filter::Mitchell => bicubic_gradient(r, Cubic::MITCHELL, s, t),
        _ => bicubic_gradient(r, Cubic::CATMULL_ROM, s, t),
    };
    let (ds, dt) = (r.finish_slope(value, ds), r.finish_slope(value, dt));
    std::array::from_fn(|lane| [ds[lane], dt[lane]])
}
