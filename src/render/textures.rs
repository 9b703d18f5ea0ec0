//! Textures of a mesh's materials: decoded when first seen, kept for the next picture.

use crate::encode::{Alpha, Encoding};
use crate::error::{Error, Result};
use crate::image::{Image, View};
use crate::mesh::{ImageSource, Mesh, TextureSlot};
use crate::sampler::{Extent, Sampler};
use crate::texture::{Texture, TextureOptions};
use crate::wrap::Wrap;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// What a slot's numbers are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Use {
    /// Colours; alpha, where there is any, is dropped.
    Color,
    /// Colours with straight alpha.
    ColorAlpha,
    /// As `ColorAlpha`, with the share of texels above this cut-off (the bits of a float) kept on all levels.
    Cutout(u32),
    /// Numbers as they are.
    Data,
    /// Unit vectors.
    Normal,
    /// A height and its slopes by u and v.
    Slopes,
}

type Key = (usize, Encoding, [Wrap; 2], Use);

/// Textures made so far. Keep one for each mesh, and make a new one when its images change.
#[derive(Debug, Default)]
pub struct Textures {
    made: Mutex<HashMap<Key, Arc<Texture<'static>>>>,
}

impl Textures {
    /// No textures yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Whether every texture in this list of slots and uses has been made.
    pub(super) fn have<'a>(&self, slots: impl IntoIterator<Item = (&'a TextureSlot, Use)>) -> bool {
        let made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        slots.into_iter().all(|(slot, what)| made.contains_key(&key(slot, what)))
    }

    /// The texture of a slot, with what `sampler` reads of it made.
    pub(super) fn get(
        &self,
        mesh: &Mesh,
        slot: &TextureSlot,
        what: Use,
        sampler: &Sampler,
    ) -> Result<Arc<Texture<'static>>> {
        let key = key(slot, what);
        let lock = || self.made.lock().unwrap_or_else(PoisonError::into_inner);
        let known = lock().get(&key).cloned();
        let texture = match known {
            Some(texture) => texture,
            None => {
                let source = mesh.images.get(slot.image);
                let source = source.ok_or_else(|| Error::value("materials", slot.image, "an image"))?;
                let made = Arc::new(make(source, slot, what)?);
                lock().insert(key, made.clone());
                made
            }
        };
        // Levels and tables are made here, by one thread, before work is handed out.
        let mut one = vec![0f32; texture.channels()];
        sampler.sample(&texture, &[0.5f32, 0.5], Extent::Jacobian(&[1.0, 0.0, 0.0, 1.0]), &mut one)?;
        Ok(texture)
    }
}

fn key(slot: &TextureSlot, what: Use) -> Key {
    (slot.image, slot.encoding, slot.wrap, what)
}

/// Pixels of an image, wherever they are.
fn pixels(source: &ImageSource) -> Result<Arc<Image>> {
    match source {
        ImageSource::Pixels(image) => Ok(image.clone()),
        #[cfg(feature = "image")]
        ImageSource::File(path) => crate::files::read(path).map(Arc::new),
        #[cfg(feature = "image")]
        ImageSource::Embedded { name, bytes } => {
            let name = if name.is_empty() { "embedded image" } else { name };
            crate::files::decode(name, bytes).map(Arc::new)
        }
        #[cfg(not(feature = "image"))]
        ImageSource::File(_) | ImageSource::Embedded { .. } => {
            Err(Error::value("images", "an encoded picture", "decoded pixels, without the feature \"image\""))
        }
        ImageSource::Missing(reason) => Err(Error::value("images", reason, "a picture that can be read")),
    }
}

fn make(source: &ImageSource, slot: &TextureSlot, what: Use) -> Result<Texture<'static>> {
    let image = pixels(source)?;
    if what == Use::Slopes {
        return slopes(&image, slot.wrap);
    }
    let has_alpha = matches!(image.channels(), 2 | 4);
    let alpha = match what {
        Use::ColorAlpha | Use::Cutout(_) if has_alpha => Alpha::Straight,
        _ => Alpha::None,
    };
    let coverage = match what {
        Use::Cutout(bits) if has_alpha => Some(f64::from(f32::from_bits(bits))),
        _ => None,
    };
    let encoding = match what {
        Use::Normal => Encoding::Normal,
        Use::Data => Encoding::Linear,
        _ => slot.encoding,
    };
    Texture::new(
        image.view(),
        TextureOptions { wrap: slot.wrap, encoding, alpha, coverage, ..TextureOptions::default() },
    )
}

/// The first channel as a height, with its derivatives by u and v at the texels' centres: central differences,
/// whose averages over a footprint are the slopes of the averaged height.
fn slopes(image: &Image, wrap: [Wrap; 2]) -> Result<Texture<'static>> {
    let (w, h, channels) = (image.width(), image.height(), image.channels());
    let plain = Texture::new(image.view(), TextureOptions { wrap, ..TextureOptions::default() })?;
    let centre = |k: isize, n: usize| (k as f64 + 0.5) / n as f64;
    // A frame of one texel on all sides, as the wrap modes continue the picture.
    let (fw, fh) = (w + 2, h + 2);
    let mut uv = Vec::with_capacity(fw * fh * 2);
    for y in -1..=h as isize {
        for x in -1..=w as isize {
            uv.extend([centre(x, w), centre(y, h)]);
        }
    }
    let mut values = vec![0f32; fw * fh * channels];
    Sampler::new(crate::filter::Filter::Nearest).sample_points(&plain, &uv, &mut values)?;
    let at = |x: usize, y: usize| values[(y * fw + x) * channels];
    let mut data = Vec::with_capacity(w * h * 3);
    for y in 1..=h {
        for x in 1..=w {
            let du = (at(x + 1, y) - at(x - 1, y)) * 0.5 * w as f32;
            let dv = (at(x, y + 1) - at(x, y - 1)) * 0.5 * h as f32;
            data.extend([at(x, y), du, dv]);
        }
    }
    let view = View::new(&data, w, h, 3, w * 3)?;
    Texture::new(view.into(), TextureOptions { wrap, ..TextureOptions::default() })
}
