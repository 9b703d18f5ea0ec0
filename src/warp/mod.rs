//! Image warps: for each output pixel a place in the input and the piece of it that the pixel covers.
//!
//! Pixel centres are at whole numbers, x to the right, y down, as in OpenCV and scikit-image. The footprint
//! comes from the map itself, so where the map minifies the result is anti-aliased and where it magnifies it
//! is the interpolation.

use crate::encode::{Alpha, Encoding, Format, decode};
use crate::error::{Error, Result};
use crate::filter::{Effort, Filter, Query};
use crate::footprint::Bend;
use crate::image::{AnyView, Element, Image, View, for_any, zeros};
use crate::jacobian::Jacobian;
use crate::kernel::remap::Sample;
use crate::sampler::Sampler;
use crate::texel::DType;
use crate::texture::{Texture, TextureOptions};
use crate::wrap::Wrap;

pub mod band;
pub mod lerp;
mod mapping;
mod minify;
pub mod panorama;
mod pixels;
pub mod remap;

pub use mapping::{Mapping, Maps};
pub(crate) use minify::SEGMENT;
use pixels::Pixels;
use remap::{Edge, Grid, Interpolation, Job, Outside, Source, interpolate};

/// How an image is warped.
#[derive(Clone, Debug)]
pub struct WarpOptions {
    /// Filter and its options.
    pub sampler: Sampler,
    /// What lies outside the image, along x and y.
    pub wrap: [Wrap; 2],
    /// Colour outside under [`Wrap::Border`] and for places that are not finite, in codes of the image, one
    /// number a channel; missing numbers are 0.
    pub border: Vec<f64>,
    /// Meaning of the image's codes, and of the result's.
    pub encoding: Encoding,
    /// Meaning of the last of two or four channels.
    pub alpha: Alpha,
}

impl Default for WarpOptions {
    fn default() -> Self {
        Self {
            sampler: Sampler::default(),
            wrap: [Wrap::Border; 2],
            border: Vec::new(),
            encoding: Encoding::Linear,
            alpha: Alpha::None,
        }
    }
}

/// Warps an image: pixel (X, Y) of the result shows the input at `mapping(X, Y)`. The result has the image's
/// element type, rounded to nearest.
///
/// ```
/// use multum::warp::{Mapping, WarpOptions, warp};
/// use multum::Image;
/// let image = Image::new(2, 2, 1, vec![0u8, 100, 0, 100])?;
/// // Half a pixel to the right of each pixel.
/// let shift = Mapping::Affine([[1.0, 0.0, 0.5], [0.0, 1.0, 0.0]]);
/// let moved = warp(image.view(), &shift, 1, 2, &WarpOptions::default())?;
/// assert_eq!(moved, Image::new(1, 2, 1, vec![50u8, 50])?);
/// # Ok::<(), multum::Error>(())
/// ```
///
/// # Errors
/// [`Error::Value`] for options, a map or a size that do not fit.
pub fn warp(
    image: AnyView<'_>,
    mapping: &Mapping<'_>,
    width: usize,
    height: usize,
    options: &WarpOptions,
) -> Result<Image> {
    let channels = image.channels();
    crate::image::check_size("shape", width, height, channels)?;
    for_any!(AnyView, image, view => {
        let mut out = zeros_of(view, width * height * channels)?;
        warp_into(image, mapping, width, height, options, &mut out)?;
        Image::new(width, height, channels, out)
    })
}

/// Room for results of the view's type.
fn zeros_of<T: Element>(_like: View<'_, T>, len: usize) -> Result<Vec<T>> {
    zeros("shape", len)
}

/// As [`warp`], into packed rows of `width * channels` elements of the image's type.
///
/// # Errors
/// As [`warp`], and [`Error::Value`] when `out` has another length or type than the result.
pub fn warp_into<T: Element + Sample>(
    image: AnyView<'_>,
    mapping: &Mapping<'_>,
    width: usize,
    height: usize,
    options: &WarpOptions,
    out: &mut [T],
) -> Result<()> {
    mapping.check(width, height)?;
    options.sampler.check()?;
    let dtype = image.dtype();
    let channels = image.channels();
    if T::DTYPE != dtype || out.len() != width * height * channels {
        let got = format!("{} elements of {}", out.len(), T::DTYPE.name());
        let expected = format!("{} elements of {}", width * height * channels, dtype.name());
        return Err(Error::value("out", got, expected));
    }
    let matrix = mapping.matrix();
    let plain = mapping.plain(&matrix);
    let mut sampler = options.sampler;
    if sampler.magnifies_bilinearly() && !plain.minifies(width, height)? {
        // Nothing to average anywhere: these filters are their reconstruction, and no level is needed.
        sampler.filter = Filter::Bilinear;
    }
    let format = Format::new(options.encoding, options.alpha, channels)?;
    let border = border_codes(image.dtype(), channels, options)?;
    let interpolation = match sampler.filter {
        Filter::Bilinear => Some(Interpolation::Bilinear),
        Filter::Bicubic => Some(Interpolation::Bicubic(-0.5)),
        _ => None,
    };
    if let (Some(interpolation), Encoding::Linear, false, Some(view)) =
        (interpolation, format.encoding, format.multiplies(), T::of_view(&image))
    {
        // Codes may be interpolated as they stand.
        let source = Source::new(view.data(), view.width(), view.height(), channels, view.row_stride())?;
        let border: Vec<T> = border.iter().map(|b| T::from_f64(*b)).collect();
        let job = Job::new(source, interpolation, options.wrap.map(edge), &border, Outside::Colour)?;
        return interpolate(&job, &plain, Grid::Exact, width, out);
    }
    let texture = texture(image, format, &border, options)?;
    let places = Pixels { mapping, size: [width, height], shape: sampler.filter.follows_shape() };
    sampler.sample_codes(&texture, width * height, &places, out)
}

/// The kernels' word for a wrap mode. [`Wrap::Extend`] needs a texture of its own, and has been refused.
fn edge(wrap: Wrap) -> Edge {
    match wrap {
        Wrap::Clamp | Wrap::Extend => Edge::Clamp,
        Wrap::Repeat => Edge::Repeat,
        Wrap::Mirror => Edge::Mirror,
        Wrap::MirrorOnce => Edge::MirrorOnce,
        Wrap::Mirror101 => Edge::Mirror101,
        Wrap::Border => Edge::Border,
    }
}

/// The border colour, one code a channel.
fn border_codes(dtype: DType, channels: usize, options: &WarpOptions) -> Result<Vec<f64>> {
    if options.wrap.contains(&Wrap::Extend) {
        return Err(Error::value("wrap", "\"extend\"", "another mode; only textures have extra texels"));
    }
    if options.border.len() > channels || options.border.iter().any(|b| !b.is_finite()) {
        let expected = format!("at most {channels} finite numbers, one a channel");
        return Err(Error::value("border", format!("{:?}", options.border), expected));
    }
    let (low, high) = if dtype.is_integer() { (0.0, dtype.full_scale()) } else { (f64::MIN, f64::MAX) };
    Ok((0..channels).map(|c| options.border.get(c).copied().unwrap_or(0.0).clamp(low, high)).collect())
}

/// The share of each output pixel that lies inside the image: 0 to 1, with the same filter as the image;
/// 1 for wrap modes that have no outside. Places that are not finite have 0.
///
/// # Errors
/// As [`warp`].
pub fn coverage(
    image_size: [usize; 2],
    mapping: &Mapping<'_>,
    width: usize,
    height: usize,
    options: &WarpOptions,
) -> Result<Image> {
    mapping.check(width, height)?;
    crate::image::check_size("shape", width, height, 1)?;
    let ones = vec![255u8; image_size[0] * image_size[1]];
    let white = Image::new(image_size[0], image_size[1], 1, ones)?;
    let options =
        WarpOptions { border: vec![0.0], encoding: Encoding::Linear, alpha: Alpha::None, ..options.clone() };
    let format = Format::new(options.encoding, options.alpha, 1)?;
    let texture = texture(white.view(), format, &options.border, &options)?;
    let mut out = zeros::<f32>("shape", width * height)?;
    let shape = options.sampler.filter.follows_shape();
    let places = Pixels { mapping, size: [width, height], shape };
    options.sampler.sample_places(&texture, width * height, &places, &mut out)?;
    Image::new(width, height, 1, out)
}

/// What each pixel of a warp costs, and on which level it is read (see [`Sampler::survey`]), row by row.
///
/// # Errors
/// As [`warp`].
pub fn survey(
    image: AnyView<'_>,
    mapping: &Mapping<'_>,
    width: usize,
    height: usize,
    options: &WarpOptions,
) -> Result<Vec<Effort>> {
    mapping.check(width, height)?;
    options.sampler.check()?;
    crate::image::check_size("shape", width, height, 2)?;
    let format = Format::new(options.encoding, options.alpha, image.channels())?;
    let border = border_codes(image.dtype(), image.channels(), options)?;
    let texture = texture(image, format, &border, options)?;
    let shape = options.sampler.filter.follows_shape();
    let places = Pixels { mapping, size: [width, height], shape };
    options.sampler.survey_places(&texture, width * height, &places)
}

/// The image as a texture, borrowed where its codes can be read as they stand; `border` is in codes.
fn texture<'a>(
    image: AnyView<'a>,
    format: Format,
    border: &[f64],
    options: &WarpOptions,
) -> Result<Texture<'a>> {
    let texture_options = texture_options(image, format, border, options);
    if image.dtype().is_integer() || options.encoding == Encoding::Linear {
        Texture::borrowed(image, texture_options)
    } else {
        Texture::new(image, texture_options)
    }
}

/// The options of the image's texture, with the border's codes decoded.
fn texture_options(
    image: AnyView<'_>,
    format: Format,
    border: &[f64],
    options: &WarpOptions,
) -> TextureOptions {
    let mut border: Vec<f64> = (border.iter().enumerate())
        .map(|(c, code)| decode(format.channel_encoding(c), image.dtype(), *code))
        .collect();
    if format.multiplies()
        && let Some((alpha, colour)) = border.split_last_mut()
    {
        colour.iter_mut().for_each(|c| *c *= *alpha);
    }
    TextureOptions {
        wrap: options.wrap,
        border,
        encoding: options.encoding,
        alpha: options.alpha,
        ..TextureOptions::default()
    }
}

/// The matrix that resizes an image of `from` pixels to `to` pixels, edges on edges:
/// `x = (X + 1/2) from/to - 1/2`.
pub fn resize_mapping(from: [usize; 2], to: [usize; 2]) -> Mapping<'static> {
    let scale = |axis: usize| from[axis] as f64 / to[axis] as f64;
    let (sx, sy) = (scale(0), scale(1));
    Mapping::Affine([[sx, 0.0, 0.5 * sx - 0.5], [0.0, sy, 0.5 * sy - 0.5]])
}

/// A query at the input pixel (x, y), whose centre is half a texel from its corner.
fn query_at(x: f64, y: f64, jacobian_tx: Jacobian, bend: Bend) -> Query {
    Query { s: x + 0.5, t: y + 0.5, jacobian_tx, index: 0, bend }
}
