//! Panoramas: from one form of a picture of all directions to another, at any rotation.
//!
//! A pixel of the target is a direction and two tangents; the rotation turns them, the source's map answers with
//! a place and an analytic Jacobian, and the filter averages that footprint. Where the source's map bends within a
//! pixel (towards a pole, across an edge of a cube), the pixel is cut into parts that each have their own place and
//! footprint, and their mean is taken in linear light. Work is done in bands of rows, so memory beyond the two
//! pictures stays the same for any size.
//!
//! Seams: an equirectangular picture repeats along u; a face of a cube carries one texel of its neighbours around it.

mod form;
mod source;

pub use form::Form;

use super::WarpOptions;
use crate::encode::encode;
use crate::error::{Error, Result};
use crate::filter::Query;
use crate::image::{AnyView, Element, Image, for_any};
use crate::mapping::Mapping;
use crate::num::Real;
use crate::par;
use glam::{DMat3, DVec2, DVec3};
use source::{NOWHERE, Source};

/// Pixels of a band: large enough to keep all threads busy.
const BAND: usize = 1 << 16;
/// Pixels that one thread plans at a time.
const TILE: usize = 1024;

/// Footprints of one texel and this more, by rounding, are one texel.
const SLACK: f64 = 1e-6;

/// One part of a pixel: which texture, and where.
#[derive(Clone, Copy)]
struct Part {
    texture: usize,
    query: Query,
}

/// Converts a panorama. `rotation` turns a direction of the target into one of the source; both are in the frame x
/// right, y up, z forward. Pixels outside the target's picture (corners of discs, empty cells of a cross) and
/// directions that the source does not hold get the border colour. `options.wrap` is not read: the form knows it.
///
/// # Errors
/// [`Error::Value`] for a rotation that is not orthonormal, forms that cannot have these sizes, and options that do
/// not fit the image.
pub fn convert(
    image: AnyView<'_>,
    source: Form,
    target: Form,
    [width, height]: [usize; 2],
    rotation: DMat3,
    options: &WarpOptions,
) -> Result<Image> {
    crate::image::check_size("size", width, height, image.channels())?;
    options.sampler.check()?;
    let off = rotation * rotation.transpose() - DMat3::IDENTITY;
    let error =
        off.to_cols_array().into_iter().fold(0.0, |a: f64, x| if x.is_nan() { 1.0 } else { a.max(x.abs()) });
    if error > 1e-6 {
        return Err(Error::value("rotation", rotation, "an orthonormal matrix"));
    }
    let map = target.mapping("size", width, height)?;
    let read = Source::new(image, source, options)?;
    let job = Job { source: &read, form: source, target: &*map, size: [width, height], rotation, options };
    for_any!(AnyView, image, view => {
        let mut out = vec![view.data()[0]; width * height * view.channels()];
        if read.textures()[0].is_double() { job.run::<_, f64>(&mut out)? } else { job.run::<_, f32>(&mut out)? }
        Image::new(width, height, view.channels(), out)
    })
}

struct Job<'a> {
    source: &'a Source<'a>,
    form: Form,
    target: &'a dyn Mapping,
    size: [usize; 2],
    rotation: DMat3,
    options: &'a WarpOptions,
}

impl Job<'_> {
    /// The parts of pixel `i`, appended to `parts`; how many a side.
    fn plan(&self, i: usize, parts: &mut Vec<Part>) -> usize {
        let [width, height] = self.size.map(|n| n as f64);
        let (x, y) = ((i % self.size[0]) as f64, (i / self.size[0]) as f64);
        let part = |at: DVec2, k: f64| {
            let found = self.target.inverse_at(at / DVec2::new(width, height))?;
            let (dx, dy) = (self.rotation * found.du / (width * k), self.rotation * found.dv / (height * k));
            Some((self.rotation * found.p, [dx, dy]))
        };
        let read = |at: Option<_>| match at {
            Some((d, dd)) => self.source.query(d, dd),
            None => (0, NOWHERE),
        };
        let middle = part(DVec2::new(x + 0.5, y + 0.5), 1.0);
        let (texture, query) = read(middle);
        // A pixel within a texel is one look-up: there is nothing in it to average.
        let most = (query.jacobian_tx.axes().sigma1 - SLACK).ceil().max(1.0) as usize;
        let reach = |dd: [DVec3; 2]| dd[0].length().max(dd[1].length());
        let count = middle.map_or(1, |(d, dd)| self.form.parts(d, reach(dd)).min(most));
        if count == 1 {
            parts.push(Part { texture, query: Query { index: i as u64 * 256, ..query } });
            return 1;
        }
        for k in 0..count * count {
            let inside = DVec2::new((k % count) as f64 + 0.5, (k / count) as f64 + 0.5) / count as f64;
            let (texture, query) = read(part(DVec2::new(x, y) + inside, count as f64));
            parts.push(Part { texture, query: Query { index: (i * 256 + k) as u64, ..query } });
        }
        count
    }

    /// Fills the picture band by band; averages are in `R`.
    fn run<T: Element, R: Real>(&self, out: &mut [T]) -> Result<()> {
        let channels = self.source.textures()[0].channels();
        let rows = (BAND / self.size[0]).max(1);
        let band_pixels = rows * self.size[0];
        for (band, out) in out.chunks_mut(band_pixels * channels).enumerate() {
            let pixels = out.len() / channels;
            let mut plans: Vec<(Vec<Part>, Vec<usize>)> = vec![Default::default(); pixels.div_ceil(TILE)];
            par::for_each(plans.iter_mut(), |tile, (parts, counts)| {
                let last = pixels.min((tile + 1) * TILE);
                counts.extend((tile * TILE..last).map(|i| self.plan(band * band_pixels + i, parts)));
                Ok(())
            })?;
            let (parts, counts): (Vec<_>, Vec<_>) = plans.into_iter().unzip();
            let (parts, counts) = (parts.concat(), counts.concat());
            let values = self.sample::<R>(&parts, channels)?;
            self.finish(&values, &counts, channels, out);
        }
        Ok(())
    }

    /// The filtered value of every part.
    fn sample<R: Real>(&self, parts: &[Part], channels: usize) -> Result<Vec<R>> {
        let sampler = &self.options.sampler;
        let mut values = vec![R::ZERO; parts.len() * channels];
        if let [texture] = self.source.textures() {
            sampler.sample_places(texture, parts.len(), &|i| (parts[i].query, None), &mut values)?;
            return Ok(values);
        }
        for (k, texture) in self.source.textures().iter().enumerate() {
            let own: Vec<usize> = (0..parts.len()).filter(|i| parts[*i].texture == k).collect();
            let mut found = vec![R::ZERO; own.len() * channels];
            sampler.sample_places(texture, own.len(), &|i| (parts[own[i]].query, None), &mut found)?;
            for (i, value) in own.into_iter().zip(found.chunks_exact(channels)) {
                values[i * channels..][..channels].copy_from_slice(value);
            }
        }
        Ok(values)
    }

    /// Means of the parts of each pixel, as codes.
    fn finish<T: Element, R: Real>(&self, values: &[R], counts: &[usize], channels: usize, out: &mut [T]) {
        let texture = &self.source.textures()[0];
        let (format, dtype) = (texture.format(), texture.dtype());
        // Straight colour is averaged by its alpha.
        let alpha = if format.multiplies() { format.alpha_channel() } else { None };
        let mut first = 0;
        for (pixel, count) in out.chunks_exact_mut(channels).zip(counts) {
            let parts = &values[first * channels..][..count * count * channels];
            first += count * count;
            let weight = |part: &[R], c: usize| match alpha {
                Some(a) if a != c && *count > 1 => part[a].to_f64(),
                _ => 1.0,
            };
            for (c, code) in pixel.iter_mut().enumerate() {
                let (mut sum, mut total) = (0.0, 0.0);
                for part in parts.chunks_exact(channels) {
                    sum += part[c].to_f64() * weight(part, c);
                    total += weight(part, c);
                }
                let mean = if total == 0.0 { 0.0 } else { sum / total };
                *code = T::from_f64(encode(format.channel_encoding(c), dtype, mean));
            }
        }
    }
}
