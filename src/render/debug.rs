//! Pictures of what textures see, in place of light.

use super::Frame;
use super::batch::{Batch, Places};
use super::surface::{Looks, Sampled};
use crate::encode::srgb_to_linear;
use crate::error::{Error, Result};
use crate::jacobian::Jacobian;
use crate::lod::LodRule;
use crate::mapping::checkerboard;
use crate::mesh::TextureSlot;
use crate::wrap::Wrap;
use glam::DVec2;

/// What is shown of the first texture of each material (base colour, else normals, and so on).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Debug {
    /// The fraction of u as red, that of v as green.
    Uv,
    /// The ratio of the footprint's axes: blue for 1, red for 16 and more.
    Footprint,
    /// The level of detail: blue for 0, red for 6 and more; white where the texture is enlarged.
    Lod,
    /// The normal for light, (n + 1)/2.
    Normals,
    /// 32 by 32 fields over the unit square of uv, filtered exactly.
    Checker,
}

impl Debug {
    /// All values with their names.
    pub const NAMES: [(&'static str, Self); 5] = [
        ("uv", Self::Uv),
        ("footprint", Self::Footprint),
        ("lod", Self::Lod),
        ("normals", Self::Normals),
        ("checker", Self::Checker),
    ];

    /// The value of this name.
    ///
    /// # Errors
    /// [`Error::Value`] for any other word.
    pub fn parse(argument: &'static str, name: &str) -> Result<Self> {
        let found = Self::NAMES.iter().find(|(n, _)| *n == name).map(|(_, value)| *value);
        found.ok_or_else(|| {
            let names = Self::NAMES.map(|(n, _)| format!("{n:?}")).join(", ");
            Error::value(argument, format!("{name:?}"), format!("one of {names}"))
        })
    }

    /// Colours of a batch, opaque.
    pub(super) fn colors<'a>(
        self,
        frame: &Frame<'a>,
        sampled: &Sampled<'a>,
        batch: &Batch,
    ) -> Result<Vec<[f32; 4]>> {
        if self == Self::Normals {
            let base = vec![[1.0; 4]; batch.len()];
            let surfaces = sampled.surfaces(&mut Looks::new(frame, batch, 0), &base)?;
            return Ok(surfaces.iter().map(|s| shown(s.normal.map(|c| 0.5 * c + 0.5).into())).collect());
        }
        let plain = TextureSlot {
            image: 0,
            uv_set: 0,
            transform: TextureSlot::IDENTITY,
            wrap: [Wrap::Repeat; 2],
            mag_filter: None,
            min_filter: None,
            encoding: crate::encode::Encoding::Linear,
        };
        let slot = sampled.first_slot();
        let places = batch.places(frame.view.mesh, slot.map_or(&plain, |s| s.slot));
        let size = slot.map_or([1024.0; 2], |s| [s.texture.width() as f64, s.texture.height() as f64]);
        Ok((0..batch.len()).map(|i| shown(self.color(&places, i, size))).collect())
    }

    /// The code, in [0, 1], of one pixel.
    fn color(self, places: &Places, i: usize, [w, h]: [f64; 2]) -> [f32; 3] {
        let [u, v] = places.uv[i];
        let texels: Jacobian = places.jacobian(i).scaled(w, h);
        match self {
            Self::Uv => [(u - u.floor()) as f32, (v - v.floor()) as f32, 0.25],
            Self::Footprint => {
                let axes = texels.axes();
                heat(((axes.sigma1 / axes.sigma2.max(1e-30)).log2() / 4.0) as f32)
            }
            Self::Lod => match LodRule::Major.lod(texels) {
                lod if lod < 0.0 => [1.0; 3],
                lod => heat(lod / 6.0),
            },
            Self::Normals | Self::Checker => {
                let white = checkerboard::filtered(DVec2::new(u, v), places.jacobian(i), DVec2::splat(32.0));
                // The mean of light, not of codes.
                [crate::encode::linear_to_srgb(0.1 + 0.8 * white) as f32; 3]
            }
        }
    }
}

/// An opaque pixel that shows these codes on the screen.
fn shown(codes: [f32; 3]) -> [f32; 4] {
    let [r, g, b] = codes.map(|c| srgb_to_linear(f64::from(c.clamp(0.0, 1.0))) as f32);
    [r, g, b, 1.0]
}

/// Blue, cyan, green, yellow, red for 0 to 1.
fn heat(x: f32) -> [f32; 3] {
    let x = if x.is_nan() { 1.0 } else { x.clamp(0.0, 1.0) } * 4.0;
    [(x - 2.0).clamp(0.0, 1.0), (2.0 - (x - 2.0).abs()).clamp(0.0, 1.0), (2.0 - x).clamp(0.0, 1.0)]
}
