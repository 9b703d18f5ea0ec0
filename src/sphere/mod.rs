//! Textures of directions: latitude-longitude pictures and cubes, filtered across the seam, over the poles and
//! across the edges of the cube, on every level.
//!
//! A sample is a direction and what one pixel to the right and one down add to it: a small parallelogram on the
//! sphere. It becomes one look-up in a texture, or several whose weighted mean it is:
//!
//! - far from poles and edges one, by the sampler's own filter on the map's analytic Jacobian;
//! - near a pole, where the map to the picture bends within a pixel, parts of the parallelogram, each with its own
//!   place and Jacobian, in a picture that goes on over the pole (`equirect.rs`);
//! - near an edge of the cube, probes on all faces they meet, on levels whose texels continue on the
//!   neighbouring faces (`cube.rs`).
//!
//! Directions are seen in the frame x right, y up, z forward; those of any length will do.

mod cube;
mod equirect;

pub(crate) use cube::{along, neighbour};
pub(crate) use equirect::over_pole;

use crate::encode::Format;
use crate::error::{Error, Result};
use crate::filter::{Filter, Query};
use crate::footprint::Bend;
use crate::image::AnyView;
use crate::jacobian::Jacobian;
use crate::mapping::{Layout, Tangents};
use crate::num::Real;
use crate::par;
use crate::sampler::{Coordinate, Sampler};
use crate::texture::{Texture, TextureOptions};
use glam::DVec3;

/// Samples that one thread plans at a time.
const TILE: usize = 1024;
/// Calls with fewer samples stay on the calling thread.
const SERIAL: usize = 8192;

/// How large a piece of the sphere each sample covers.
#[derive(Clone, Copy, Debug)]
pub enum Spread<'a, U> {
    /// None: every sample is a point.
    Point,
    /// What one pixel right and one pixel down add to the direction, three numbers a sample each.
    Tangents(&'a [U], &'a [U]),
    /// One level of detail a sample: a square on the sphere, as wide as `2^lod` texels in the middle of a face
    /// or on the equator. The mipmap filters of a cube read that level on all of a face.
    Lod(&'a [f32]),
}

/// A picture of all directions.
///
/// ```
/// use multum::sphere::{SphereTexture, Spread};
/// use multum::{Image, Sampler, TextureOptions};
/// // White above, black below.
/// let image = Image::new(4, 2, 1, vec![255u8, 255, 255, 255, 0, 0, 0, 0])?;
/// let sky = SphereTexture::equirect(image.view(), TextureOptions::default())?;
/// let mut up_and_forward = [0f32; 2];
/// sky.sample(&Sampler::default(), &[0.0, 1.0, 0.0, 0.0, 0.0, 1.0], Spread::Point, &mut up_and_forward)?;
/// assert_eq!(up_and_forward, [1.0, 0.5]);
/// # Ok::<(), multum::Error>(())
/// ```
#[derive(Debug)]
pub struct SphereTexture(Kind);

#[derive(Debug)]
enum Kind {
    Equirect(Box<equirect::Globe>),
    Cube(Box<cube::Box6>),
}

/// What a look-up reads.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Read {
    /// Texture by the sampler's own filter.
    Own(usize),
    /// Texture by a line of trilinear probes.
    Line(usize),
    /// Texture, bilinear on one level.
    Level(usize, f32),
    /// The mean of all texels next to the upper (0) or lower (1) pole.
    Ring(usize),
}

/// One look-up and its weight.
#[derive(Clone, Copy, Debug)]
struct Look {
    read: Read,
    query: Query,
    weight: f64,
}

/// A place that there is not: the border colour.
const NOWHERE: Look = Look {
    read: Read::Own(0),
    query: Query { s: f64::NAN, t: f64::NAN, jacobian_tx: Jacobian::ZERO, index: 0, bend: Bend::None },
    weight: 1.0,
};

impl SphereTexture {
    /// A latitude-longitude picture: forward at its centre, up at row 0, right at three quarters of its width.
    /// `options.wrap` is not read. It is stored twice, the second time mirrored and turned by half a turn, so
    /// that every filter goes on over the poles.
    ///
    /// # Errors
    /// [`Error::Value`] when options do not fit the image.
    pub fn equirect(image: AnyView<'_>, options: TextureOptions) -> Result<Self> {
        Ok(Self(Kind::Equirect(Box::new(equirect::Globe::new(image, options)?))))
    }

    /// A cube whose faces lie in one picture as `layout` says. `options.wrap` is not read. Levels are made at once.
    ///
    /// # Errors
    /// [`Error::Value`] when the picture is not of square cells or options do not fit.
    pub fn cube(image: AnyView<'_>, layout: Layout, options: TextureOptions) -> Result<Self> {
        Ok(Self(Kind::Cube(Box::new(cube::Box6::new(image, layout, options)?))))
    }

    /// The textures behind: one of twice the picture's height, or six faces.
    fn textures(&self) -> &[Texture<'static>] {
        match &self.0 {
            Kind::Equirect(globe) => globe.textures(),
            Kind::Cube(cube) => cube.textures(),
        }
    }

    /// Width and height of the picture, or of a face.
    pub fn size(&self) -> [usize; 2] {
        let texture = &self.textures()[0];
        match self.0 {
            Kind::Equirect(_) => [texture.width(), texture.height() / 2],
            Kind::Cube(_) => [texture.width(), texture.height()],
        }
    }

    /// Whether the picture is a cube.
    pub fn is_cube(&self) -> bool {
        matches!(self.0, Kind::Cube(_))
    }

    /// Numbers in a texel.
    pub fn channels(&self) -> usize {
        self.textures()[0].channels()
    }

    /// What the codes mean.
    pub fn format(&self) -> Format {
        self.textures()[0].format()
    }

    /// Whether results are doubles: they are for `f64` pictures.
    pub fn is_double(&self) -> bool {
        self.textures()[0].is_double()
    }

    /// Number of levels of the picture or of a face.
    pub fn num_levels(&self) -> usize {
        crate::pyramid::num_levels(self.size()[0], self.size()[1])
    }

    /// Bytes held now.
    pub fn nbytes(&self) -> usize {
        self.textures().iter().map(Texture::nbytes).sum()
    }

    /// Samples a batch: three numbers of `directions` a sample, `channels` numbers of `out`.
    ///
    /// A direction that is zero or not finite gives the border colour, a tangent that is not finite the coarsest
    /// level. The result does not depend on threads.
    ///
    /// # Errors
    /// [`Error::Value`] when lengths do not fit together or options are out of range.
    pub fn sample<U: Coordinate, O: Real>(
        &self,
        sampler: &Sampler,
        directions: &[U],
        spread: Spread<'_, U>,
        out: &mut [O],
    ) -> Result<()> {
        sampler.check()?;
        let (samples, channels) = (directions.len() / 3, self.channels());
        let expect = |argument, got: usize, expected: usize| {
            let wanted = || format!("{expected} for {samples} samples");
            if got == expected {
                Ok(())
            } else {
                Err(Error::value(argument, format!("{got} numbers"), wanted()))
            }
        };
        expect("directions", directions.len(), samples * 3)?;
        expect("out", out.len(), samples * channels)?;
        match spread {
            Spread::Point => {}
            Spread::Tangents(x, y) => {
                expect("ddx", x.len(), samples * 3)?;
                expect("ddy", y.len(), samples * 3)?;
            }
            Spread::Lod(lod) => expect("lod", lod.len(), samples)?,
        }
        // Levels and tables are made here, once, before work is handed out.
        let mut nothing = vec![O::ZERO; channels];
        for texture in self.textures() {
            sampler.sample_places(texture, 1, &|_| (NOWHERE.query, None), &mut nothing)?;
        }
        let vector = |numbers: &[U], i: usize| {
            DVec3::new(numbers[3 * i].into(), numbers[3 * i + 1].into(), numbers[3 * i + 2].into())
        };
        let tile = |index: usize, out: &mut [O]| {
            // Tiles draw different random numbers.
            let seed = sampler.seed ^ (index as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let sampler = Sampler { seed, ..*sampler };
            let mut looks = Vec::new();
            let mut ends = Vec::with_capacity(TILE);
            for i in index * TILE..index * TILE + out.len() / channels {
                let d = vector(directions, i);
                match spread {
                    Spread::Point => self.plan(&sampler, d, [DVec3::ZERO; 2], &mut looks),
                    Spread::Tangents(x, y) => {
                        self.plan(&sampler, d, [vector(x, i), vector(y, i)], &mut looks);
                    }
                    Spread::Lod(lod) => self.plan_level(&sampler, d, lod[i], &mut looks),
                }
                ends.push(looks.len());
            }
            self.average(&sampler, &looks, &ends, out)
        };
        let tiles = out.chunks_mut(TILE * channels);
        if samples < SERIAL {
            return tiles.enumerate().try_for_each(|(i, out)| par::with_threads(Some(1), || tile(i, out)));
        }
        par::for_each(tiles, |i, out| par::with_threads(Some(1), || tile(i, out)))
    }

    /// The look-ups of one sample.
    fn plan(&self, sampler: &Sampler, d: DVec3, dd: Tangents, looks: &mut Vec<Look>) {
        let Some((d, dd)) = unit(d, dd) else { return looks.push(NOWHERE) };
        match &self.0 {
            Kind::Equirect(globe) => globe.plan(sampler, d, dd, looks),
            Kind::Cube(cube) => cube.plan(sampler, d, dd, looks),
        }
    }

    /// The look-ups of one sample with a level of detail: of a cube's mipmap filters that level itself, which is the same
    /// on both sides of an edge; else those of a square.
    fn plan_level(&self, sampler: &Sampler, d: DVec3, lod: f32, looks: &mut Vec<Look>) {
        let mipmap = matches!(sampler.filter, Filter::Trilinear | Filter::LinearMipmapNearest);
        match &self.0 {
            Kind::Cube(cube) if mipmap => match unit(d, [DVec3::ZERO; 2]) {
                Some((d, _)) => cube.level(sampler, d, lod + sampler.lod_bias, looks),
                None => looks.push(NOWHERE),
            },
            _ => self.plan(sampler, d, self.square(d, f64::from(lod)), looks),
        }
    }

    /// The tangents of a square that is `2^lod` texels wide.
    fn square(&self, d: DVec3, lod: f64) -> Tangents {
        let Some((d, _)) = unit(d, [DVec3::ZERO; 2]) else { return [DVec3::ZERO; 2] };
        let texel = match &self.0 {
            Kind::Equirect(_) => std::f64::consts::PI / self.size()[1] as f64,
            Kind::Cube(_) => 2.0 / self.size()[0] as f64,
        };
        let width = texel * lod.exp2();
        let (e, f) = d.any_orthonormal_pair();
        [e * width, f * width]
    }

    /// Weighted means of the look-ups of every sample; `ends[i]` is where those of sample `i` end.
    fn average<O: Real>(
        &self,
        sampler: &Sampler,
        looks: &[Look],
        ends: &[usize],
        out: &mut [O],
    ) -> Result<()> {
        let channels = self.channels();
        let on_level =
            Sampler { filter: Filter::LinearMipmapNearest, lod_bias: 0.0, tolerance: None, ..*sampler };
        let longest = if self.is_cube() { cube::STRETCH } else { sampler.max_anisotropy };
        let on_line = Sampler { filter: Filter::Anisotropic, max_anisotropy: longest, ..*sampler };
        let mut values = vec![O::ZERO; looks.len() * channels];
        for (k, texture) in self.textures().iter().enumerate() {
            for (way, sampler) in [sampler, &on_line, &on_level].into_iter().enumerate() {
                let mine: Vec<usize> = (0..looks.len())
                    .filter(|i| match looks[*i].read {
                        Read::Own(texture) => (way, k) == (0, texture),
                        Read::Line(texture) => (way, k) == (1, texture),
                        Read::Level(texture, _) => (way, k) == (2, texture),
                        Read::Ring(_) => false,
                    })
                    .collect();
                let lod = |i: usize| if let Read::Level(_, l) = looks[i].read { Some(l) } else { None };
                let places = |i: usize| (looks[mine[i]].query, lod(mine[i]));
                if mine.len() == looks.len() {
                    sampler.sample_places(texture, mine.len(), &places, &mut values)?;
                } else if !mine.is_empty() {
                    let mut found = vec![O::ZERO; mine.len() * channels];
                    sampler.sample_places(texture, mine.len(), &places, &mut found)?;
                    for (i, value) in mine.iter().zip(found.chunks_exact(channels)) {
                        values[i * channels..][..channels].copy_from_slice(value);
                    }
                }
            }
        }
        if let Kind::Equirect(globe) = &self.0 {
            for (look, value) in looks.iter().zip(values.chunks_exact_mut(channels)) {
                if let Read::Ring(pole) = look.read {
                    for (value, mean) in value.iter_mut().zip(&globe.rings()[pole]) {
                        *value = O::from_f64(*mean);
                    }
                }
            }
        }
        let format = self.format();
        let alpha = if format.multiplies() { format.alpha_channel() } else { None };
        let mut first = 0;
        for (out, &end) in out.chunks_exact_mut(channels).zip(ends) {
            mean(&looks[first..end], &values[first * channels..end * channels], alpha, out);
            first = end;
        }
        Ok(())
    }
}

/// The weighted mean; straight colour counts by its alpha. Equal values give exactly that.
fn mean<O: Real>(looks: &[Look], values: &[O], alpha: Option<usize>, out: &mut [O]) {
    let channels = out.len();
    if looks.len() == 1 {
        return out.copy_from_slice(values);
    }
    for (c, out) in out.iter_mut().enumerate() {
        let (mut mean, mut total) = (0.0, 0.0);
        for (look, value) in looks.iter().zip(values.chunks_exact(channels)) {
            let weight = match alpha {
                Some(a) if a != c => look.weight * value[a].to_f64(),
                _ => look.weight,
            };
            total += weight;
            if total != 0.0 {
                mean += weight / total * (value[c].to_f64() - mean);
            }
        }
        *out = O::from_f64(mean);
    }
}

/// A unit direction and its tangents across it; `None` for a direction that is zero or not finite.
fn unit(d: DVec3, dd: Tangents) -> Option<(DVec3, Tangents)> {
    let largest = d.abs().max_element();
    if !d.is_finite() || largest == 0.0 {
        return None;
    }
    let near = d / largest;
    let length = near.length();
    let d = near / length;
    Some((d, dd.map(|x| x / largest / length).map(|x| x - d * d.dot(x))))
}

/// Whether both tangents are finite.
fn finite(dd: Tangents) -> bool {
    dd.iter().all(|d| d.is_finite())
}

#[cfg(test)]
mod tests;
