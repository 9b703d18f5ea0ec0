//! Single pixels of a panorama, each a place and an analytic Jacobian for the filter.
//!
//! A pixel of the target is a direction and two tangents; the rotation turns them, the source's map answers with a place and
//! a Jacobian, and the filter averages that footprint. Where the source's map bends within a pixel (towards a pole, across
//! a fold), the pixel is cut into parts that each have their own place and footprint, and their mean is taken in linear
//! light.

use super::super::WarpOptions;
use super::source::{NOWHERE, One, Source};
use super::{Form, Target};
use crate::encode::{Format, encode};
use crate::error::Result;
use crate::filter::{Filter, Query};
use crate::image::Element;
use crate::mapping::Tangents;
use crate::num::Real;
use crate::par;
use crate::sphere::{SphereTexture, Spread};
use crate::texel::DType;
use glam::{DVec2, DVec3};

/// Pixels that are planned, averaged and written together.
const BAND: usize = 1 << 16;
/// Pixels that one thread plans at a time.
const TILE: usize = 1024;
/// Share of a pixel by which the map may leave its tangents.
const STRAIGHT: f64 = 0.02;
/// Parts a side of a pixel within which the target's map bends, at most.
const MOST_BENT: f64 = 6.0;
/// Footprints of one texel and this more, by rounding, are one texel.
const SLACK: f64 = 1e-6;

/// What all pixels share.
pub(super) struct Rest<'a> {
    pub source: &'a Source<'a>,
    pub form: Form,
    pub target: Target<'a>,
    pub options: &'a WarpOptions,
}

/// Parts of the pixels of a tile, each with its texture, and how many a side each pixel has.
type Plan = (Vec<(usize, Query)>, Vec<usize>);

impl Rest<'_> {
    /// Fills the `count` pixels of the picture; averages are in `R`.
    pub fn fill<T: Element, R: Real>(&self, count: usize, out: &mut [T]) -> Result<()> {
        for start in (0..count).step_by(BAND) {
            let pixels: Vec<usize> = (start..count.min(start + BAND)).collect();
            match self.source {
                Source::One(one) => self.parts::<T, R>(one, &pixels, out)?,
                Source::Cube(cube) => self.directions::<T, R>(cube, &pixels, out)?,
            }
            par::check_interrupt((start + pixels.len()) as f64 / count as f64)?;
        }
        Ok(())
    }

    fn parts<T: Element, R: Real>(&self, one: &One<'_>, pixels: &[usize], out: &mut [T]) -> Result<()> {
        let mut plans: Vec<Plan> = vec![Default::default(); pixels.len().div_ceil(TILE)];
        par::for_each(plans.iter_mut().zip(pixels.chunks(TILE)), |_, ((parts, counts), pixels)| {
            counts.extend(pixels.iter().map(|i| self.plan(one, *i, parts)));
            Ok(())
        })?;
        let (parts, counts): (Vec<_>, Vec<_>) = plans.into_iter().unzip();
        let (parts, counts) = (parts.concat(), counts.concat());
        let texture = &one.textures[0];
        let channels = texture.channels();
        let mut values = vec![R::ZERO; parts.len() * channels];
        for (k, texture) in one.textures.iter().enumerate() {
            let own: Vec<usize> = (0..parts.len()).filter(|i| parts[*i].0 == k).collect();
            // A texture that nothing is read from makes no levels.
            if own.is_empty() {
                continue;
            }
            let mut found = vec![R::ZERO; own.len() * channels];
            let places = |i: usize| (parts[own[i]].1, None);
            self.options.sampler.sample_places(texture, own.len(), &places, &mut found)?;
            for (i, value) in own.into_iter().zip(found.chunks_exact(channels)) {
                values[i * channels..][..channels].copy_from_slice(value);
            }
        }
        finish(texture.format(), texture.dtype(), &values, pixels, &counts, out);
        Ok(())
    }

    /// The parts of pixel `i`, appended to `parts`; how many a side.
    fn plan(&self, one: &One<'_>, i: usize, parts: &mut Vec<(usize, Query)>) -> usize {
        let read = |at: Option<(DVec3, Tangents)>| at.map_or((0, NOWHERE), |(d, dd)| one.query(d, dd));
        let half = DVec2::splat(0.5);
        let middle = self.target.direction(i, half, 1.0);
        let found = read(middle);
        // A pixel within a texel is one look-up: there is nothing in it to average.
        let most = (found.1.jacobian_tx.axes().sigma1 - SLACK).ceil().max(1.0) as usize;
        let reach = |dd: Tangents| dd[0].length().max(dd[1].length());
        let point = matches!(
            self.options.sampler.filter,
            Filter::Nearest | Filter::Bilinear | Filter::Bicubic | Filter::Mitchell
        );
        let count = middle.filter(|_| !point).map_or(1, |(d, dd)| {
            let bent = self.bent(i, d, dd, reach(dd));
            self.form.parts(d, reach(dd)).max(bent).min(most)
        });
        if count == 1 {
            parts.push(found);
            return 1;
        }
        for k in 0..count * count {
            let inside = DVec2::new((k % count) as f64 + 0.5, (k / count) as f64 + 0.5) / count as f64;
            parts.push(read(self.target.direction(i, inside, count as f64)));
        }
        count
    }

    /// Into how many parts a side pixel `i` is to be cut because the target's own map bends within it.
    fn bent(&self, i: usize, d: DVec3, [dx, dy]: Tangents, reach: f64) -> usize {
        let off = |at: f64| {
            let corner = self.target.direction(i, DVec2::splat(at), 1.0)?;
            Some((corner.0 - (d + (dx + dy) * (at - 0.5))).length() / reach)
        };
        match (off(0.0), off(1.0)) {
            // In parts of 1/k the map is straighter by k squared.
            (Some(a), Some(b)) => (a.max(b) / STRAIGHT).sqrt().ceil().clamp(1.0, MOST_BENT) as usize,
            // The picture ends within the pixel: parts beyond its rim would bring in the border colour.
            _ => 1,
        }
    }

    fn directions<T: Element, R: Real>(
        &self,
        cube: &SphereTexture,
        pixels: &[usize],
        out: &mut [T],
    ) -> Result<()> {
        let mut vectors = vec![[f64::NAN; 9]; pixels.len()];
        par::for_each(vectors.chunks_mut(TILE), |tile, vectors| {
            for (vector, i) in vectors.iter_mut().zip(&pixels[tile * TILE..]) {
                if let Some((d, [x, y])) = self.target.direction(*i, DVec2::splat(0.5), 1.0) {
                    *vector = [d.x, d.y, d.z, x.x, x.y, x.z, y.x, y.y, y.z];
                }
            }
            Ok(())
        })?;
        let part = |k: usize| vectors.iter().flat_map(|v| v[3 * k..3 * k + 3].iter().copied()).collect();
        let [d, x, y]: [Vec<f64>; 3] = [part(0), part(1), part(2)];
        let mut values = vec![R::ZERO; pixels.len() * cube.channels()];
        cube.sample(&self.options.sampler, &d, Spread::Tangents(&x, &y), &mut values)?;
        finish(cube.format(), T::DTYPE, &values, pixels, &vec![1; pixels.len()], out);
        Ok(())
    }
}

/// Means of the parts of each pixel, as codes.
fn finish<T: Element, R: Real>(
    format: Format,
    dtype: DType,
    values: &[R],
    pixels: &[usize],
    counts: &[usize],
    out: &mut [T],
) {
    let channels = format.channels;
    // Straight colour is averaged by its alpha.
    let alpha = if format.multiplies() { format.alpha_channel() } else { None };
    let mut first = 0;
    for (pixel, count) in pixels.iter().zip(counts) {
        let parts = &values[first * channels..][..count * count * channels];
        first += count * count;
        let weight = |part: &[R], c: usize| match alpha {
            Some(a) if a != c && *count > 1 => part[a].to_f64(),
            _ => 1.0,
        };
        for (c, code) in out[pixel * channels..][..channels].iter_mut().enumerate() {
            let (mut mean, mut total) = (0.0, 0.0);
            for part in parts.chunks_exact(channels) {
                let weight = weight(part, c);
                total += weight;
                if total != 0.0 {
                    mean += weight / total * (part[c].to_f64() - mean);
                }
            }
            *code = T::from_f64(encode(format.channel_encoding(c), dtype, mean));
        }
    }
}
