//! The six faces of a cube as textures whose levels continue on their neighbours.

use super::store::Level;
use super::{Base, Texture, TextureOptions};
use crate::encode::{decode, encode};
use crate::error::Result;
use crate::image::{AnyView, Element, Image, Pixels, View, for_any};
use crate::texel::Texel;
use crate::wrap::Wrap;

/// Texel (column, row) of a face.
pub(crate) type Place = (usize, [usize; 2]);

/// The texel that continues a face of `n` texels a side at a place one outside it, not beyond a corner.
pub(crate) type Neighbour<'a> = dyn Fn(usize, [i64; 2], usize) -> Place + 'a;

/// Textures of square faces with extra texels around every level: those of the neighbouring faces, level by
/// level, and in the corners the mean of the three texels that meet there. All levels are made at once.
///
/// # Errors
/// Those of [`Texture::new`].
pub(crate) fn matched_faces(
    views: [AnyView<'_>; 6],
    options: &TextureOptions,
    neighbour: &Neighbour<'_>,
) -> Result<[Texture<'static>; 6]> {
    let framed = |view: AnyView<'_>| {
        let image = for_any!(AnyView, view, v => frame(&v))?;
        let options = TextureOptions { wrap: [Wrap::Extend; 2], ..options.clone() };
        Texture::new(image.view(), options)
    };
    let [a, b, c, d, e, f] = views;
    let mut faces = [framed(a)?, framed(b)?, framed(c)?, framed(d)?, framed(e)?, framed(f)?];
    match_level(&mut faces, 0, neighbour);
    for face in &faces {
        face.levels()?;
    }
    for level in 1..faces[0].num_levels() {
        match_level(&mut faces, level, neighbour);
    }
    Ok(faces)
}

/// The view with room for extra texels.
fn frame<T: Element>(view: &View<'_, T>) -> Result<Image>
where
    Pixels: From<Vec<T>>,
{
    let (n, channels) = (view.width(), view.channels());
    let mut data = vec![T::default(); (n + 2) * (n + 2) * channels];
    for y in 0..n {
        let start = ((y + 1) * (n + 2) + 1) * channels;
        data[start..start + n * channels].copy_from_slice(view.row(y));
    }
    Image::new(n + 2, n + 2, channels, data)
}

/// Writes the extra texels of one level of all faces.
fn match_level(faces: &mut [Texture<'static>; 6], index: usize, neighbour: &Neighbour<'_>) {
    let n = faces[0].stored_level(index).map_or(0, |level| level.width);
    let last = n as i64;
    let mut writes = Vec::new();
    for face in 0..6 {
        let beyond = |at| {
            let (f, [x, y]) = neighbour(face, at, n);
            faces[f].texel_codes(index, [x as i64, y as i64])
        };
        for i in 0..last {
            for at in [[-1, i], [last, i], [i, -1], [i, last]] {
                writes.push((face, at, beyond(at)));
            }
        }
        for (x, near_x) in [(-1, 0), (last, last - 1)] {
            for (y, near_y) in [(-1, 0), (last, last - 1)] {
                let own = faces[face].texel_codes(index, [near_x, near_y]);
                let three = [own, beyond([x, near_y]), beyond([near_x, y])];
                writes.push((face, [x, y], faces[face].mean_of(&three)));
            }
        }
    }
    for (face, at, codes) in writes {
        faces[face].set_texel(index, at, &codes);
    }
}

impl Texture<'static> {
    fn stored_level(&self, index: usize) -> Option<&Level> {
        match (index, &self.base) {
            (0, Base::Owned(level)) => Some(level),
            (0, Base::Borrowed(_)) => None,
            _ => self.levels.get()?.get(index - 1),
        }
    }

    /// The stored codes of a texel, which may be an extra one.
    fn texel_codes(&self, index: usize, at: [i64; 2]) -> Vec<f64> {
        self.stored_level(index).map_or(Vec::new(), |level| {
            let start = start_of(level, at);
            for_any!(Pixels, &level.texels, texels => {
                texels[start..start + level.lanes].iter().map(|t| t.to_f64()).collect()
            })
        })
    }

    fn set_texel(&mut self, index: usize, at: [i64; 2], codes: &[f64]) {
        let level = match (index, &mut self.base) {
            (0, Base::Owned(level)) => Some(level),
            (0, Base::Borrowed(_)) => None,
            _ => self.levels.get_mut().and_then(|levels| levels.get_mut(index - 1)),
        };
        if let Some(level) = level {
            let start = start_of(level, at);
            for_any!(Pixels, &mut level.texels, texels => {
                for (texel, code) in texels[start..].iter_mut().zip(codes) {
                    *texel = Texel::from_f64(*code);
                }
            });
        }
    }

    /// The mean of texels, in linear light; straight colour counts by its alpha.
    fn mean_of(&self, texels: &[Vec<f64>; 3]) -> Vec<f64> {
        let dtype = self.stored_dtype();
        let alpha = if self.stored.multiplies() { self.stored.alpha_channel() } else { None };
        (0..texels[0].len())
            .map(|c| {
                let encoding = self.stored.channel_encoding(c);
                let (mut sum, mut total) = (0.0, 0.0);
                for texel in texels {
                    let weight = alpha.filter(|a| *a != c).map_or(1.0, |a| texel[a]);
                    sum += weight * decode(encoding, dtype, texel[c]);
                    total += weight;
                }
                encode(encoding, dtype, if total == 0.0 { 0.0 } else { sum / total })
            })
            .collect()
    }
}

/// Index of the first code of a texel of a stored level.
fn start_of(level: &Level, [x, y]: [i64; 2]) -> usize {
    (y + 1) as usize * level.row() + (x + 1) as usize * level.lanes
}
