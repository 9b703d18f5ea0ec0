//! What faces look like: numbers and the textures that replace or multiply them.

use crate::encode::Encoding;
use crate::error::{Error, Result};
use crate::image::Image;
use crate::wrap::Wrap;
use std::path::PathBuf;
use std::sync::Arc;

/// How alpha is used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    #[default]
    Opaque,
    /// Shown where alpha is at least the cut-off, else not at all.
    Mask(f32),
    /// Blended over what lies behind.
    Blend,
}

/// Which numbers of a material say how it answers to light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Model {
    /// `ambient`, `base_color` as kd, `specular` as ks and `shininess` as the exponent.
    #[default]
    Phong,
    /// `base_color`, `metallic` and `roughness`, which give kd, ks and the exponent.
    MetallicRoughness,
}

/// How a texel meets the colour that is there. t and a are the texel's colour and alpha, c and b those before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Blend {
    /// (c t, b a): scaling, light maps.
    #[default]
    Modulate,
    /// (t, a): nothing stays.
    Replace,
    /// (c (1 - a) + t a, b): a label on the surface.
    Decal,
    /// (c + t, b a).
    Add,
}

/// The space of the vectors in a normal map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NormalSpace {
    /// x along the tangent, y along the bitangent, z along the normal.
    #[default]
    Tangent,
    /// The mesh's own axes.
    Object,
}

/// Names of an enum's values and the way back.
macro_rules! words {
    ($type:ty, $($word:literal => $value:expr),+) => {
        impl $type {
            /// All values with their names.
            pub const NAMES: &'static [(&'static str, Self)] = &[$(($word, $value)),+];

            /// The value of this name.
            ///
            /// # Errors
            /// [`Error::Value`] for any other word.
            pub fn parse(argument: &'static str, name: &str) -> Result<Self> {
                Self::NAMES.iter().find(|(n, _)| *n == name).map(|(_, value)| *value).ok_or_else(|| {
                    let names: Vec<_> = Self::NAMES.iter().map(|(n, _)| format!("{n:?}")).collect();
                    Error::value(argument, format!("{name:?}"), format!("one of {}", names.join(", ")))
                })
            }

            /// The name of this value.
            pub fn name(self) -> &'static str {
                Self::NAMES.iter().find(|(_, value)| *value == self).map_or("", |(name, _)| name)
            }
        }
    };
}
words!(Model, "phong" => Self::Phong, "metallic_roughness" => Self::MetallicRoughness);
words!(
    Blend,
    "modulate" => Self::Modulate,
    "replace" => Self::Replace,
    "decal" => Self::Decal,
    "add" => Self::Add
);
words!(NormalSpace, "tangent" => Self::Tangent, "object" => Self::Object);

/// One more texture over the base colour or over the lit colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// The texture.
    pub texture: TextureSlot,
    /// How it meets what is there.
    pub blend: Blend,
    /// Whether it meets the colour after lighting (GL's texture environment) rather than the base colour.
    pub after_light: bool,
}

/// A filter that a file asks for, in the names of the samplers of this crate.
pub type SampleFilter = &'static str;

/// A texture of a material.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureSlot {
    /// Index into [`Mesh::images`](super::Mesh::images).
    pub image: usize,
    /// Which uv set.
    pub uv_set: usize,
    /// Rows (a, b, c) and (d, e, f): the texture is read at (a u + b v + c, d u + e v + f).
    pub transform: [[f32; 3]; 2],
    /// Wrap modes of u and v.
    pub wrap: [Wrap; 2],
    /// Filter for enlargement, where the file names one.
    pub mag_filter: Option<SampleFilter>,
    /// Filter for reduction, where the file names one.
    pub min_filter: Option<SampleFilter>,
    /// What the codes mean in this slot: colours are sRGB, everything else is linear.
    pub encoding: Encoding,
}

impl TextureSlot {
    /// The uv transform that changes nothing.
    pub const IDENTITY: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
}

/// A material: the metallic-roughness model of glTF and the Phong model of MTL side by side, each number
/// with the texture that multiplies it. What a format does not have keeps its default.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the file.
    pub name: String,
    /// Which of the numbers below count.
    pub model: Model,
    /// Linear colour and alpha (MTL: Kd and d).
    pub base_color: [f32; 4],
    /// Multiplies `base_color` (MTL: `map_Kd`).
    pub base_color_texture: Option<TextureSlot>,
    /// Multiplies alpha with its first channel (MTL: `map_d`).
    pub alpha_texture: Option<TextureSlot>,
    /// 0 for dielectrics, 1 for metals.
    pub metallic: f32,
    /// 0 for mirrors, 1 for chalk.
    pub roughness: f32,
    /// Green multiplies roughness, blue metallic.
    pub metallic_roughness_texture: Option<TextureSlot>,
    /// Normals.
    pub normal_texture: Option<TextureSlot>,
    /// Multiplies x and y of the normals read.
    pub normal_scale: f32,
    /// The space of these normals.
    pub normal_space: NormalSpace,
    /// Heights (MTL: `map_Bump`).
    pub bump_texture: Option<TextureSlot>,
    /// Scale of the heights (MTL: `-bm`).
    pub bump_scale: f32,
    /// Heights by which vertices move along their normals (MTL: `disp`).
    pub displacement_texture: Option<TextureSlot>,
    /// How far the height 1 moves a vertex, in the mesh's unit.
    pub displacement_scale: f32,
    /// How far the height 0 moves a vertex.
    pub displacement_offset: f32,
    /// Red tells how much ambient light arrives.
    pub occlusion_texture: Option<TextureSlot>,
    /// How much of the occlusion is applied.
    pub occlusion_strength: f32,
    /// Linear light that the surface sends out itself.
    pub emissive: [f32; 3],
    /// Multiplies `emissive`.
    pub emissive_texture: Option<TextureSlot>,
    /// Share of `base_color` that answers to ambient light (MTL: Ka).
    pub ambient: [f32; 3],
    /// Specular reflection (MTL: Ks).
    pub specular: [f32; 3],
    /// Share of an environment that is mirrored as in a smooth mirror: a reflection map.
    pub mirror: [f32; 3],
    /// Multiplies `specular` and `mirror` (MTL: `map_Ks`).
    pub specular_texture: Option<TextureSlot>,
    /// Phong exponent (MTL: Ns); 0 for no highlight.
    pub shininess: f32,
    /// Multiplies `shininess` (MTL: `map_Ns`).
    pub shininess_texture: Option<TextureSlot>,
    /// More textures, in this order.
    pub layers: Vec<Layer>,
    /// How alpha is used.
    pub alpha_mode: AlphaMode,
    /// Whether backs are shown too.
    pub double_sided: bool,
    /// Whether light is ignored and `base_color` shown as it is.
    pub unlit: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            model: Model::Phong,
            base_color: [1.0; 4],
            base_color_texture: None,
            alpha_texture: None,
            metallic: 0.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            normal_space: NormalSpace::Tangent,
            bump_texture: None,
            bump_scale: 1.0,
            displacement_texture: None,
            displacement_scale: 1.0,
            displacement_offset: 0.0,
            occlusion_texture: None,
            occlusion_strength: 1.0,
            emissive: [0.0; 3],
            emissive_texture: None,
            ambient: [1.0; 3],
            specular: [0.0; 3],
            mirror: [0.0; 3],
            specular_texture: None,
            shininess: 1.0,
            shininess_texture: None,
            layers: Vec::new(),
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            unlit: false,
        }
    }
}

impl Material {
    /// The textures that are there, with the names of their slots.
    pub fn slots(&self) -> Vec<(&'static str, &TextureSlot)> {
        let all = [
            ("base_color_texture", &self.base_color_texture),
            ("alpha_texture", &self.alpha_texture),
            ("metallic_roughness_texture", &self.metallic_roughness_texture),
            ("normal_texture", &self.normal_texture),
            ("bump_texture", &self.bump_texture),
            ("displacement_texture", &self.displacement_texture),
            ("occlusion_texture", &self.occlusion_texture),
            ("emissive_texture", &self.emissive_texture),
            ("specular_texture", &self.specular_texture),
            ("shininess_texture", &self.shininess_texture),
        ];
        let single = all.into_iter().filter_map(|(name, slot)| slot.as_ref().map(|slot| (name, slot)));
        single.chain(self.layers.iter().map(|layer| ("layers", &layer.texture))).collect()
    }
}

/// Where a picture's bytes are; it is read when it is first needed.
#[derive(Clone, Debug, PartialEq)]
pub enum ImageSource {
    /// In a file of its own, in or below the mesh's folder.
    File(PathBuf),
    /// In the mesh's file, still encoded (PNG, JPEG).
    Embedded {
        /// Name in the file.
        name: String,
        /// The encoded picture.
        bytes: Arc<[u8]>,
    },
    /// Decoded already.
    Pixels(Arc<Image>),
    /// Named by a file but in no form that is read here; the reason.
    Missing(String),
}
