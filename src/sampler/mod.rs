//! How to sample: a filter with its limits, over batches of places.

mod batch;
mod finish;
mod gradient;
mod places;
mod single;
mod survey;

pub use gradient::gradient;
pub(crate) use places::Places;
pub use places::{Coordinate, Extent};

use crate::error::{Error, Result};
use crate::filter::Filter;
use crate::image::Element;
use crate::lod::LodRule;
use crate::num::Real;
use crate::texture::{Layers, Texture};
use places::Arrays;

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
        self.fill(texture, samples, &Arrays { uv, extent, size: [w, h] }, O::tagged(out))
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

    /// Samples at these places.
    pub(crate) fn sample_places<O: Real>(
        &self,
        texture: &Texture<'_>,
        samples: usize,
        places: &dyn Places,
        out: &mut [O],
    ) -> Result<()> {
        self.fill(texture, samples, places, O::tagged(out))
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
}
