//! How the levels of a texture are made.
//!
//! Level `l` has `max(1, floor(n / 2^l))` texels on each axis, so a level covers exactly the same picture as
//! the one below it and a texel of it is `n_below / n` texels wide: 2, or a little more where `n_below` is
//! odd. The chain is kept in single precision in linear light, as vectors and premultiplied; every stored
//! level is rounded once from it, never from a rounded level. It is kept in double precision for `f64`
//! images, and for `f32` images that are not plain linear numbers. Equal texels give that texel exactly.
//!
//! | kind | weights | source |
//! |---|---|---|
//! | `box` | the area that the wide texel shares with each narrow one: (1/2, 1/2), or for `n = 2k + 1` (k-i)/n, k/n, (i+1)/n | Guthe and Heckbert, "Non-power-of-two mipmapping", 2005 |
//! | `kaiser` | sinc under a Kaiser window, radius 3 wide texels, alpha 4 | Kaiser, 1974 |
//! | `lanczos3` | sinc under the central lobe of a sinc three times as wide | Duchon, 1979 |
//!
//! Both windowed kernels `k` are taken at the narrow texels' centres, `x` wide texels from the wide one's
//! centre, and divided by their sum; where `n` is odd a little `max(0, 1 - |x|) (x - mean)` is added so that
//! the centre of the weights is the wide texel's: constants and ramps stay what they are.

mod build;
mod cascade;
mod codec;
mod coverage;
mod taps;

pub(crate) use codec::{Codec, Real};

use crate::encode::{Alpha, Encoding, Format};
use crate::error::{Error, Result};
use crate::image::{AnyView, Image, Pixels, View};
use crate::texel::{DType, Texel};
use crate::wrap::Wrap;

/// How a level is made from the one below it; the table at the head of this module has the weights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Kind {
    /// The mean over the wide texel's area. Never rings, never reads beyond the texel.
    #[default]
    Box,
    /// Sharper than the box and with less aliasing; rings a little at edges.
    Kaiser,
    /// Sharper still; rings more.
    Lanczos3,
}

impl Kind {
    /// All kinds with their names.
    pub const NAMES: &'static [(&'static str, Self)] =
        &[("box", Self::Box), ("kaiser", Self::Kaiser), ("lanczos3", Self::Lanczos3)];

    /// The kind of this name.
    ///
    /// # Errors
    /// [`Error::Value`] for any other word.
    pub fn parse(argument: &'static str, name: &str) -> Result<Self> {
        Self::NAMES.iter().find(|(n, _)| *n == name).map(|(_, k)| *k).ok_or_else(|| {
            let names: Vec<_> = Self::NAMES.iter().map(|(n, _)| format!("{n:?}")).collect();
            Error::value(argument, format!("{name:?}"), format!("one of {}", names.join(", ")))
        })
    }

    /// The kind's name.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, k)| *k == self).map_or("", |(n, _)| n)
    }
}

/// What the levels are made of and how.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Weights.
    pub kind: Kind,
    /// Meaning of the codes; averages are taken of what they mean.
    pub format: Format,
    /// What lies beyond the picture's edge, for x and y. Only `kaiser` and `lanczos3` look there;
    /// `border` and `extend` count as `clamp`, so that levels do not depend on a colour of outside.
    pub wrap: [Wrap; 2],
    /// If given, alpha is scaled on every level so that the share of texels with alpha of at least this
    /// much is the base level's: what an alpha test lets through does not shrink in the distance.
    pub coverage: Option<f64>,
}

/// How many levels a picture has: `floor(log2(max(width, height))) + 1`.
///
/// ```
/// assert_eq!(multum::pyramid::num_levels(640, 480), 10);
/// ```
pub fn num_levels(width: usize, height: usize) -> usize {
    width.max(height).max(1).ilog2() as usize + 1
}

/// Texels on an axis of level `level` when the base has `n`: `max(1, floor(n / 2^level))`.
pub fn level_size(n: usize, level: usize) -> usize {
    n.checked_shr(level as u32).unwrap_or(0).max(1)
}

/// A place for one level: rows of texels inside a larger slice.
#[derive(Debug)]
pub struct Target<'a, T> {
    /// The elements; those that belong to no texel of the level are left as they are.
    pub data: &'a mut [T],
    /// Index of the first element of texel (0, 0).
    pub origin: usize,
    /// Elements from one row's start to the next's.
    pub row_stride: usize,
    /// Texels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl<T> Target<'_, T> {
    fn check(&self, lanes: usize, width: usize, height: usize) -> Result<()> {
        let row = width.checked_mul(lanes);
        let end = row.and_then(|row| {
            self.row_stride.checked_mul(height - 1)?.checked_add(row)?.checked_add(self.origin)
        });
        let fits = end.is_some_and(|end| end <= self.data.len()) && row.is_some_and(|r| r <= self.row_stride);
        if (self.width, self.height) != (width, height) || !fits {
            return Err(Error::value(
                "targets",
                format!(
                    "{} x {} texels, rows {} apart from element {} of {}",
                    self.width,
                    self.height,
                    self.row_stride,
                    self.origin,
                    self.data.len()
                ),
                format!("room for {width} x {height} texels of {lanes} elements"),
            ));
        }
        Ok(())
    }
}

fn check_options(options: &Options) -> Result<()> {
    Format::new(options.format.encoding, options.format.alpha, options.format.channels)?;
    let Some(coverage) = options.coverage else { return Ok(()) };
    if !(coverage > 0.0 && coverage <= 1.0) {
        return Err(Error::value("coverage", coverage, "an alpha above 0 and up to 1"));
    }
    if options.format.alpha_channel().is_none() {
        return Err(Error::value("coverage", coverage, "none, or alpha=\"straight\" or \"premultiplied\""));
    }
    Ok(())
}

/// Fills levels 1, 2, … from level 0.
///
/// A texel of `base` has `base.channels()` elements, one of a target has `lanes`; of both the first
/// `options.format.channels` are used, the rest of a target's texel is set to zero. As many levels are made
/// as there are targets. Straight colour is averaged weighted by alpha; where alpha is zero it is zero.
///
/// # Errors
/// [`Error::Value`] when a target has the wrong size or too little room, when lanes are fewer than channels,
/// or for impossible options.
pub fn build_into<T: Texel>(
    base: View<'_, T>,
    lanes: usize,
    targets: &mut [Target<'_, T>],
    options: &Options,
) -> Result<()> {
    check_options(options)?;
    let channels = options.format.channels;
    if base.channels() < channels {
        return Err(Error::value("base", format!("{} channel(s)", base.channels()), channels));
    }
    if lanes < channels {
        return Err(Error::value("lanes", lanes, format!("at least {channels}")));
    }
    for (i, target) in targets.iter().enumerate() {
        target.check(lanes, level_size(base.width(), i + 1), level_size(base.height(), i + 1))?;
    }
    // What singles mean is no single where it is computed by a power, a product or a shift: kept in
    // double, a constant picture comes back to the bit.
    let plain = options.format.encoding == Encoding::Linear && options.format.alpha != Alpha::Straight;
    if T::DTYPE == DType::F64 || (T::DTYPE == DType::F32 && !plain) {
        build::levels::<T, f64>(base, lanes, targets, options)
    } else {
        build::levels::<T, f32>(base, lanes, targets, options)
    }
}

/// The first `levels` levels (all of them for `None`), packed, beginning with a copy of the base.
///
/// # Errors
/// [`Error::Value`] when the image has not `options.format.channels` channels, for impossible options and
/// when `levels` is 0 or more than there are.
///
/// ```
/// use multum::encode::{Alpha, Encoding, Format};
/// use multum::pyramid::{Kind, Options, build};
/// use multum::{Image, Pixels, Wrap};
///
/// let format = Format::new(Encoding::Srgb, Alpha::None, 1)?;
/// let options = Options { kind: Kind::Box, format, wrap: [Wrap::Clamp; 2], coverage: None };
/// let checker = Image::new(2, 2, 1, vec![0u8, 255, 255, 0])?;
/// let levels = build(checker.view(), &options, None)?;
/// // Half the light is code 188, not 128.
/// assert_eq!(levels[1].pixels(), &Pixels::U8(vec![188]));
/// # Ok::<(), multum::Error>(())
/// ```
pub fn build(base: AnyView<'_>, options: &Options, levels: Option<usize>) -> Result<Vec<Image>> {
    let above = build_above(base, options, levels)?;
    let copy = match base {
        AnyView::U8(view) => packed(view)?,
        AnyView::U16(view) => packed(view)?,
        AnyView::F16(view) => packed(view)?,
        AnyView::F32(view) => packed(view)?,
        AnyView::F64(view) => packed(view)?,
    };
    Ok(std::iter::once(copy).chain(above).collect())
}

/// As [`build`], without the copy of the base: levels 1 to `levels - 1`.
///
/// # Errors
/// As [`build`].
pub fn build_above(base: AnyView<'_>, options: &Options, levels: Option<usize>) -> Result<Vec<Image>> {
    match base {
        AnyView::U8(view) => above(view, options, levels),
        AnyView::U16(view) => above(view, options, levels),
        AnyView::F16(view) => above(view, options, levels),
        AnyView::F32(view) => above(view, options, levels),
        AnyView::F64(view) => above(view, options, levels),
    }
}

fn packed<T: Texel>(view: View<'_, T>) -> Result<Image>
where
    Pixels: From<Vec<T>>,
{
    let mut copy = Vec::with_capacity(view.width() * view.height() * view.channels());
    (0..view.height()).for_each(|y| copy.extend_from_slice(view.row(y)));
    Image::new(view.width(), view.height(), view.channels(), copy)
}

fn above<T: Texel>(base: View<'_, T>, options: &Options, levels: Option<usize>) -> Result<Vec<Image>>
where
    Pixels: From<Vec<T>>,
{
    let (width, height, channels) = (base.width(), base.height(), base.channels());
    let most = num_levels(width, height);
    let levels = levels.unwrap_or(most);
    if levels == 0 || levels > most {
        return Err(Error::value("levels", levels, format!("1 to {most}")));
    }
    if options.format.channels != channels {
        return Err(Error::value("image", format!("{channels} channel(s)"), options.format.channels));
    }
    let size = |level| (level_size(width, level), level_size(height, level));
    let mut made: Vec<Vec<T>> = (1..levels)
        .map(|level| {
            let (w, h) = size(level);
            vec![T::default(); w * h * channels]
        })
        .collect();
    let mut targets: Vec<_> = made
        .iter_mut()
        .enumerate()
        .map(|(i, data)| {
            let (width, height) = size(i + 1);
            Target { data, origin: 0, row_stride: width * channels, width, height }
        })
        .collect();
    build_into(base, channels, &mut targets, options)?;
    let image = |(i, data)| {
        let (w, h) = size(i + 1);
        Image::new(w, h, channels, data)
    };
    made.into_iter().enumerate().map(image).collect()
}
