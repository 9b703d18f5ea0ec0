//! Texture sampling and filtering on the CPU.
//!
//! Given a texture and the piece of it that a pixel covers, return the right colour, fast.

mod error;
pub mod num;
pub mod par;

pub mod jacobian;
pub mod kernel;

pub mod encode;
pub mod image;
pub mod pyramid;
pub mod texel;
pub mod wrap;

pub mod raster;

#[cfg(feature = "python")]
pub mod python;

pub use crate::error::{Error, Result};
pub use crate::image::{AnyView, Image, Pixels, View};
pub use crate::jacobian::Jacobian;
pub use crate::texel::DType;
pub use crate::wrap::Wrap;
