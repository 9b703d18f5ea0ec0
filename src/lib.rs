//! Texture sampling and filtering on the CPU: what is the colour of this pixel, when the pixel covers that
//! piece of that texture?
//!
//! ```text
//!  image            texture             sampler                 result
//!  texels in    ->  levels, wrap,   ->  filter and options  ->  one colour
//!  rows             border, encoding        ^                   a query
//!                                           |
//!                   place (u, v) and how far it moves from pixel to pixel (the Jacobian)
//!                                           ^
//!            warp: output pixels | mapping: points, directions | raster: triangles
//! ```
//!
//! - [`Image`] and [`View`] hold pixels, [`files`] reads and writes them.
//! - [`Texture`] is *what* is sampled: levels ([`pyramid`]), what lies outside ([`Wrap`]), what the codes mean
//!   ([`encode`]). Levels are made when a filter first reads them.
//! - [`Sampler`] is *how*: a [`Filter`] and its limits, over batches of places with their [`Extent`].
//! - [`warp`] turns images into images, [`mapping`] points and directions into places, with derivatives;
//!   [`sphere`] reads pictures of all directions; [`raster`] and [`mesh`] bring triangles to the screen, [`shade`] and [`render`] light them.
//! - [`compat`] is the arithmetic of other libraries, for the drop-ins.
//!
//! # Conventions
//!
//! - Texture space is (u, v) in \[0, 1\]: u to the right, v down, row 0 at v = 0. Texel (i, j) has its centre at
//!   ((i + 1/2)/W, (j + 1/2)/H).
//! - `J[i][j]` is the derivative of coordinate i of (u, v) by pixel axis j: column 0 is one pixel right, column 1
//!   one pixel down. Its singular values in texels are the footprint's length and width.
//! - Pixels of image warps have their centres at whole numbers, pixels of the rasteriser at one half.
//! - Integers stand for code / max. Values are filtered in linear light and premultiplied, where the texture
//!   says that its codes are not.
//! - The right value of a pixel is the mean of the bilinear reconstruction over the pixel's footprint
//!   ([`Filter::Exact`]); other filters approximate it.
//! - A coordinate that is not finite gives the border colour; a Jacobian that is not finite the coarsest level.
//! - Results do not depend on the number of threads or on the instruction set.
//!
//! # Features
//!
//! `rayon` (default): threads. `image` (default): image files. `mesh` (default): glTF and OBJ. `bake` (default):
//! maps from one mesh to another. `python`: the bindings; no
//! other build needs Python.

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

mod bounds;
mod detail;

pub mod texture;

mod footprint;
pub mod lod;

pub mod filter;

pub mod sampler;

pub mod warp;

pub mod compat;

pub mod mapping;

pub mod sphere;

pub mod mesh;
pub mod raster;

pub mod shade;

pub mod render;

#[cfg(feature = "bake")]
pub mod bake;

pub mod oracle;

#[cfg(feature = "python")]
pub mod python;

pub use crate::error::{Error, Result};
pub use crate::filter::{Effort, Filter};
pub use crate::image::{AnyView, Image, Pixels, View};
pub use crate::jacobian::Jacobian;
pub use crate::lod::LodRule;
pub use crate::sampler::{Extent, Sampler};
pub use crate::texel::DType;
pub use crate::texture::{Texture, TextureOptions};
pub use crate::wrap::Wrap;

/// The README's Rust code, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
