//! What `antialias` adds: pixels that cover more than a pixel of the source are the mean over what they cover.
//!
//! Pixels where the map magnifies stay what the interpolation gave. Where it minifies, the interpolation goes over into
//! the mean by [`mean_share`] of the footprint's major axis, so that nothing jumps.

use super::Rows;
use super::maps::from_fixed;
use super::read::Pixel;
use crate::error::Result;
use crate::filter::{Filter, Query, mean_share};
use crate::image::{Image, zeros};
use crate::kernel::remap::Real;
use crate::par;
use crate::sampler::Sampler;
use crate::texture::{Texture, TextureOptions};
use crate::warp::remap::{Interpolation, Map};
use crate::warp::{Mapping, Maps, SEGMENT};
use crate::wrap::Wrap;

/// Output pixels that are filtered at a time, about: enough to keep threads busy, and few enough to hold.
const CHUNK: usize = 1 << 18;

/// Output pixels whose footprints a thread looks at in one go, about.
const TILE: usize = 1 << 12;

/// Which parts of an output may have pixels to filter.
pub(super) struct Plan<'a> {
    map: &'a Map<'a>,
    width: usize,
    /// One a segment, row by row.
    flags: Vec<bool>,
}

/// What is read.
pub(super) struct Seen<'a, T> {
    pub source: &'a Rows<'a, T>,
    /// What lies outside; `None` shows what the output held before.
    pub wrap: Option<Wrap>,
    pub border: &'a [T],
    pub interpolation: Interpolation,
}

/// A pixel of the output, and the mean's share of it.
type Part = (usize, f64);

/// What means are taken of.
struct Textures<'a> {
    picture: Texture<'a>,
    /// 1 where there is a picture, for outputs that show through.
    presence: Option<Texture<'static>>,
}

impl<'a> Plan<'a> {
    /// `None` where the map minifies nowhere.
    pub fn new(map: &'a Map<'a>, width: usize, height: usize) -> Result<Option<Self>> {
        let flags = map.minified(width, height)?;
        Ok((!flags.is_empty()).then_some(Self { map, width, flags }))
    }

    /// Columns of a row that may be filtered. A pixel's footprint is made of the differences on both of its sides, and
    /// flags tell of those on the right and below.
    fn columns(&self, row: usize) -> impl Iterator<Item = usize> + '_ {
        let segments = self.width.div_ceil(SEGMENT);
        let flag = move |row: usize, segment: usize| self.flags[row * segments + segment];
        (0..segments)
            .filter(move |&s| flag(row, s) || (s > 0 && flag(row, s - 1)) || (row > 0 && flag(row - 1, s)))
            .flat_map(move |s| s * SEGMENT..self.width.min((s + 1) * SEGMENT))
    }

    /// Puts means into an output that is interpolated. `held` is what it held before, where that shows.
    pub fn filter<T: Pixel>(&self, seen: &Seen<'_, T>, held: &[T], out: &mut [T]) -> Result<()> {
        let (width, channels) = (self.width, seen.source.channels);
        let height = out.len() / (width * channels);
        let mut pairs = Vec::new();
        let mapping = mapping(self.map, &mut pairs)?;
        let query = |at: usize, shape: bool| mapping.query([at % width, at / width], [width, height], shape);
        let textures = Textures::new(seen)?;
        // Differences of positions in 1/32 pixel tell no more than this.
        let least = if matches!(self.map, Map::Fixed(..)) { 1.0 + 1.0 / 32.0 } else { 1.0 };
        let rows = (CHUNK / width).max(1);
        for first in (0..height).step_by(rows) {
            let parts = self.parts(seen.interpolation, least, first..height.min(first + rows), &query)?;
            // A part of the mean is wanted exactly; all of it as well as can be seen.
            for (filter, parts) in [(Filter::Auto, &parts.0), (Filter::Area, &parts.1)] {
                if parts.is_empty() {
                    continue;
                }
                let sampler = Sampler::new(filter);
                if filter == Filter::Auto && textures.presence.is_none() {
                    let mut codes = zeros::<T::Code>("dst", parts.len() * channels)?;
                    let places = |k: usize| (query(parts[k].0, true), None);
                    sampler.sample_codes(&textures.picture, parts.len(), &places, &mut codes)?;
                    for ((at, _), codes) in parts.iter().zip(codes.chunks_exact(channels)) {
                        for (out, &code) in out[at * channels..].iter_mut().zip(codes) {
                            *out = T::of_code(code);
                        }
                    }
                } else {
                    textures.blend(&sampler, parts, &query, held, out)?;
                }
            }
        }
        Ok(())
    }

    /// The pixels of some rows that are means, and those that are partly; all have a major axis over `least`.
    fn parts(
        &self,
        interpolation: Interpolation,
        least: f64,
        rows: std::ops::Range<usize>,
        query: &(impl Fn(usize, bool) -> Query + Sync),
    ) -> Result<(Vec<Part>, Vec<Part>)> {
        let mut found: Vec<(Vec<Part>, Vec<Part>)> = rows.clone().map(|_| Default::default()).collect();
        let tile = (TILE / self.width).max(1);
        par::for_pixels(self.width * rows.len(), found.chunks_mut(tile), |i, found| {
            for (row, (full, partly)) in (rows.start + i * tile..).zip(found) {
                for column in self.columns(row) {
                    let at = row * self.width + column;
                    let query = query(at, false);
                    let sigma1 = query.jacobian_tx.sigma1();
                    if sigma1 <= least || !(query.s.is_finite() && query.t.is_finite()) {
                        continue;
                    }
                    // The filter itself goes over into the linear interpolation.
                    let share =
                        if interpolation == Interpolation::Bilinear { 1.0 } else { mean_share(sigma1) };
                    if share == 1.0 { full.push((at, share)) } else { partly.push((at, share)) }
                }
            }
            Ok(())
        })?;
        let mut all = (Vec::new(), Vec::new());
        for (mut full, mut partly) in found {
            all.0.append(&mut full);
            all.1.append(&mut partly);
        }
        Ok(all)
    }
}

impl<'a> Textures<'a> {
    fn new<T: Pixel>(seen: &Seen<'a, T>) -> Result<Self> {
        let channels = seen.source.channels;
        let border: Vec<f64> = match seen.wrap {
            Some(_) => seen.border.iter().map(|&b| b.get().wide() / T::FULL_SCALE).collect(),
            None => vec![0.0; channels],
        };
        let wrap = [seen.wrap.unwrap_or(Wrap::Border); 2];
        let picture = T::texture(seen.source, TextureOptions { wrap, border, ..TextureOptions::default() })?;
        let presence = match seen.wrap {
            Some(_) => None,
            None => {
                let (width, height) = (seen.source.width, seen.source.height);
                let mut ones = zeros::<u8>("src", width * height)?;
                ones.fill(u8::MAX);
                let ones = Image::new(width, height, 1, ones)?;
                Some(Texture::new(ones.view(), TextureOptions { wrap, ..TextureOptions::default() })?)
            }
        };
        Ok(Self { picture, presence })
    }

    /// Mixes means into what is interpolated, and what was held before into those that reach beyond the picture.
    fn blend<T: Pixel>(
        &self,
        sampler: &Sampler,
        parts: &[Part],
        query: &(impl Fn(usize, bool) -> Query + Sync),
        held: &[T],
        out: &mut [T],
    ) -> Result<()> {
        let channels = self.picture.channels();
        let places = |k: usize| (query(parts[k].0, true), None);
        let mut means = zeros::<f64>("dst", parts.len() * channels)?;
        sampler.sample_places(&self.picture, parts.len(), &places, &mut means)?;
        let mut inside = Vec::new();
        if let Some(presence) = &self.presence {
            inside = zeros::<f32>("dst", parts.len())?;
            sampler.sample_places(presence, parts.len(), &places, &mut inside)?;
        }
        for (k, (&(at, share), means)) in parts.iter().zip(means.chunks_exact(channels)).enumerate() {
            let rest = inside.get(k).map_or(0.0, |&inside| 1.0 - f64::from(inside));
            for (i, &mean) in (at * channels..).zip(means) {
                let before = held.get(i).map_or(0.0, |held| held.get().wide());
                let (mean, plain) = (mean * T::FULL_SCALE + rest * before, out[i].get().wide());
                out[i] = T::put(T::Acc::of(plain + share * (mean - plain)));
            }
        }
        Ok(())
    }
}

/// The map with its derivatives; positions of a fixed-point map go to `pairs`.
fn mapping<'a>(map: &Map<'a>, pairs: &'a mut Vec<f32>) -> Result<Mapping<'a>> {
    let period = [None; 2];
    Ok(match *map {
        Map::Single(x, y) => Mapping::Single(Maps { x, y, step: 1, period }),
        Map::Double(x, y) => Mapping::Double(Maps { x, y, step: 1, period }),
        Map::SinglePairs(xy) => Mapping::Single(Maps::pairs(xy, period)),
        Map::DoublePairs(xy) => Mapping::Double(Maps::pairs(xy, period)),
        Map::Matrix(&[a, b, c, d, e, f, g, h, i]) => Mapping::from_matrix([[a, b, c], [d, e, f], [g, h, i]]),
        Map::Fixed(whole, codes) => {
            *pairs = zeros("map1", whole.len())?;
            let places = pairs.as_chunks_mut::<2>().0.iter_mut().zip(whole.as_chunks::<2>().0);
            for (i, (place, &pixel)) in places.enumerate() {
                *place = from_fixed(pixel, codes.map_or(0, |codes| codes[i]));
            }
            Mapping::Single(Maps::pairs(pairs, period))
        }
    })
}
