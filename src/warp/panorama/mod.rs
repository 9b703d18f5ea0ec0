//! Panoramas: from one form of a picture of all directions to another, at any rotation.
//!
//! Every pixel is the mean over its footprint. Where the map from the target's pixels to the source is smooth, which is
//! nearly everywhere, rectangles of pixels are read by vector kernels, from polynomials that are the map to 1/64 texel
//! (`tile.rs`, `fill.rs`); around poles, rims and folds a pixel is the mean of points, each mapped by itself
//! (`single.rs`). For filters that are asked for by
//! name every pixel has a place and an analytic Jacobian, or several (`rest.rs`). Work is done in bands of rows, so memory beyond the two pictures stays the same for any size.
//!
//! Seams: an equirectangular picture repeats along u; a face of a cube carries one texel of its neighbours around it, on
//! every level.

mod chart;
mod fill;
mod form;
mod grid;
mod pictures;
mod piece;
mod rest;
mod single;
mod source;
mod tile;

pub use form::Form;

use super::{WarpOptions, border_codes};
use crate::encode::{Encoding, Format};
use crate::error::{Error, Result};
use crate::filter::Filter;
use crate::image::{AnyView, Element, Image, Pixels, View, for_any, zeros};
use crate::kernel::Isa;
use crate::kernel::remap::{Interpolation, Sample};
use crate::mapping::{Mapping, Tangents};
use crate::par;
use crate::pyramid::Codec;
use glam::{DMat3, DVec2, DVec3};
use pictures::Pictures;
use piece::Number;
use rest::Rest;
use source::Source;
use tile::{SIDE, Show, Tiles};

/// Bands of rows between two looks at the clock.
const BANDS: usize = 8;
/// Pixels from a pole within which the map is not left to polynomials, about.
const NEAR: f64 = 24.0;

/// What averages of these elements are computed in.
type Numbers<T> = <T as Sample>::Acc;

/// The picture that is made.
#[derive(Clone, Copy)]
struct Target<'a> {
    form: Form,
    map: &'a dyn Mapping,
    size: [usize; 2],
    rotation: DMat3,
}

impl Target<'_> {
    /// The direction in the source's frame at a place within pixel `i`, in 0..=1; `None` outside the picture.
    fn point(&self, i: usize, within: DVec2) -> Option<DVec3> {
        self.map.unplace(self.uv(i, within)).map(|d| self.rotation * d)
    }

    /// The place of a place within pixel `i` in the whole picture.
    fn uv(&self, i: usize, within: DVec2) -> DVec2 {
        let corner = DVec2::new((i % self.size[0]) as f64, (i / self.size[0]) as f64);
        (corner + within) / DVec2::new(self.size[0] as f64, self.size[1] as f64)
    }

    /// The direction in the source's frame at a place within pixel `i`, in 0..=1, and what one part right and
    /// one part down add to it, `parts` a pixel; `None` outside the picture.
    fn direction(&self, i: usize, within: DVec2, parts: f64) -> Option<(DVec3, Tangents)> {
        let size = DVec2::new(self.size[0] as f64, self.size[1] as f64);
        let found = self.map.inverse_at(self.uv(i, within))?;
        let (dx, dy) = (found.du / (size.x * parts), found.dv / (size.y * parts));
        Some((self.rotation * found.p, [self.rotation * dx, self.rotation * dy]))
    }
}

/// Converts a panorama. `rotation` turns a direction of the target into one of the source; both are in the frame x
/// right, y up, z forward. Pixels outside the target's picture (corners of discs, empty cells of a cross) and
/// directions that the source does not hold get the border colour. `options.wrap` is not read: the form knows it.
///
/// [`Filter::Auto`] is the mean over each pixel's footprint; where source and target are the same picture in another
/// layout, it is that picture.
///
/// # Errors
/// [`Error::Value`] for a rotation that is not orthonormal, forms that cannot have these sizes, and options that do
/// not fit the image.
pub fn convert(
    image: AnyView<'_>,
    source: Form,
    target: Form,
    size: [usize; 2],
    rotation: DMat3,
    options: &WarpOptions,
) -> Result<Image> {
    let channels = image.channels();
    crate::image::check_size("size", size[0], size[1], channels)?;
    options.sampler.check()?;
    let off = rotation * rotation.transpose() - DMat3::IDENTITY;
    let error =
        off.to_cols_array().into_iter().fold(0.0, |a: f64, x| if x.is_nan() { 1.0 } else { a.max(x.abs()) });
    if error > 1e-6 {
        return Err(Error::value("rotation", rotation, "an orthonormal matrix"));
    }
    let map = target.mapping("size", size[0], size[1])?;
    let target = Target { form: target, map: &*map, size, rotation };
    for_any!(AnyView, image, view => {
        let out = par::alone_below(size[0] * size[1], || typed(view, image, source, target, options))?;
        Image::new(size[0], size[1], channels, out)
    })
}

fn typed<'a, T: Element + Sample>(
    view: View<'a, T>,
    image: AnyView<'a>,
    form: Form,
    target: Target<'_>,
    options: &WarpOptions,
) -> Result<Vec<T>>
where
    View<'a, T>: Into<AnyView<'a>>,
    Pixels: From<Vec<T>>,
    Numbers<T>: Number,
{
    let map = form.mapping("image", image.width(), image.height())?;
    let channels = image.channels();
    let border = border_codes(image.dtype(), channels, options)?;
    let format = Format::new(options.encoding, options.alpha, channels)?;
    let pixels = target.size[0] * target.size[1];
    let mut out = zeros::<T>("size", pixels * channels)?;
    let Some(show) = show([image.width(), image.height()], form, target, options) else {
        let source = Source::new(image, form, &border, options, near_poles(target, image.height()))?;
        Rest { source: &source, form, target, options }.all(pixels, &mut out)?;
        return Ok(out);
    };
    let pictures = Pictures::new(view, form, format, &border)?;
    let codec = Codec::new(format, channels, T::DTYPE);
    let mut decoded = vec![Numbers::<T>::default(); channels];
    codec.decode_row(pictures.border(), channels, &mut decoded);
    let tiles = Tiles {
        pictures,
        form,
        map: &*map,
        target,
        show,
        codec,
        is_plain: format.encoding == Encoding::Linear && !format.multiplies(),
        border: decoded,
        isa: Isa::current(),
    };
    let band = SIDE * target.size[0] * channels;
    let total = out.len();
    let mut done = 0;
    for (group, out) in out.chunks_mut(BANDS * band).enumerate() {
        done += out.len();
        par::for_each(out.chunks_mut(band), |i, out| tiles.band((group * BANDS + i) * SIDE, out))?;
        par::check_interrupt(done as f64 / total as f64)?;
    }
    Ok(out)
}

impl Rest<'_> {
    /// [`Rest::fill`] in the precision of the source.
    fn all<T: Element>(&self, count: usize, out: &mut [T]) -> Result<()> {
        if T::DTYPE == crate::texel::DType::F64 {
            self.fill::<T, f64>(count, out)
        } else {
            self.fill::<T, f32>(count, out)
        }
    }
}

/// Rows of an equirectangular source from a pole within which a pixel of the target may look over it.
fn near_poles(target: Target<'_>, height: usize) -> f64 {
    let middle = (target.size[1] / 2) * target.size[0] + target.size[0] / 2;
    let reach = target
        .direction(middle, DVec2::splat(0.5), 1.0)
        .map_or(f64::INFINITY, |(_, [dx, dy])| dx.length().max(dy.length()));
    NEAR * (reach * height as f64 / std::f64::consts::PI).max(1.0)
}

/// What the kernels are to show of each pixel; `None` where only filters can.
fn show([width, height]: [usize; 2], form: Form, target: Target<'_>, options: &WarpOptions) -> Option<Show> {
    let sampler = &options.sampler;
    if sampler.filter == Filter::Nearest {
        return Some(Show::Centre(Interpolation::Nearest));
    }
    let same = match (form, target.form) {
        (Form::Cube(from), Form::Cube(to)) => width / from.cells().0 == target.size[0] / to.cells().0,
        (from, to) => from == to && [width, height] == target.size,
    };
    if same && target.rotation == DMat3::IDENTITY && sampler.filter == Filter::Auto {
        return Some(Show::Centre(Interpolation::Nearest));
    }
    match sampler.filter {
        Filter::Auto if sampler.tolerance.is_none() => Some(Show::Mean),
        Filter::Bilinear => Some(Show::Centre(Interpolation::Bilinear)),
        _ => None,
    }
}
