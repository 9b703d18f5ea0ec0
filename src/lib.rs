//! Texture sampling and filtering on the CPU.
//!
//! Given a texture and the piece of it that a pixel covers, return the right colour, fast.

mod error;
pub mod num;
pub mod par;

pub mod jacobian;
pub mod kernel;

pub mod encode;
#[cfg(feature = "image")]
pub mod files;
pub mod image;
pub mod pyramid;
pub mod sat;
pub mod texel;
pub mod wrap;

pub mod texture;

pub mod lod;

pub mod filter;

pub mod sampler;

pub mod warp;

pub mod mapping;

pub mod mesh;
pub mod raster;

pub mod oracle;

#[cfg(feature = "python")]
pub mod python;

pub use crate::error::{Error, Result};
pub use crate::filter::Filter;
pub use crate::image::{AnyView, Image, Pixels, View};
pub use crate::jacobian::Jacobian;
pub use crate::lod::LodRule;
pub use crate::sampler::{Extent, Sampler};
pub use crate::texel::DType;
pub use crate::texture::{Texture, TextureOptions};
pub use crate::wrap::Wrap;
