//! What is sampled: levels, what lies outside them and what their codes mean. Never how.
//!
//! A level is stored row by row, its texels padded to 1, 2 or 4 lanes (more than four channels: to a
//! multiple of four), with an apron of one texel that continues the picture by its wrap mode. So a bilinear
//! read near an edge needs no wrap arithmetic.

use crate::bounds::Bounds;
use crate::detail::Detail;
use crate::encode::{Alpha, Encoding, Format, decode, encode};
use crate::error::{Error, Result};
use crate::image::{AnyView, Element, Image, Pixels, View, for_any};
use crate::pyramid;
use crate::sat::SummedAreaTable;
use crate::texel::{DType, Texel, f16};
use crate::wrap::Wrap;
use std::sync::OnceLock;

mod faces;
mod layers;
mod store;

pub(crate) use faces::matched_faces;
pub(crate) use layers::{Decode, Decoder, Layers, Plain};
use store::{Level, borrowed_plane, lanes_of};

/// Options of a texture, each with its default.
#[derive(Clone, Debug)]
pub struct TextureOptions {
    /// Wrap modes along u and v.
    pub wrap: [Wrap; 2],
    /// Colour outside under [`Wrap::Border`], one number a channel, in the space of the results: linear and,
    /// where there is alpha, premultiplied. Missing numbers are 0.
    pub border: Vec<f64>,
    /// Meaning of the codes.
    pub encoding: Encoding,
    /// Meaning of the last of two or four channels.
    pub alpha: Alpha,
    /// How levels are made.
    pub pyramid: pyramid::Kind,
    /// Keep, on every level, the share of texels whose alpha is at least this.
    pub coverage: Option<f64>,
}

impl Default for TextureOptions {
    fn default() -> Self {
        Self {
            wrap: [Wrap::Clamp; 2],
            border: Vec::new(),
            encoding: Encoding::Linear,
            alpha: Alpha::None,
            pyramid: pyramid::Kind::Box,
            coverage: None,
        }
    }
}

/// A texture. Levels beyond the first are made when they are first needed, once, by one thread.
///
/// ```
/// use multum::{Image, Sampler, Texture, TextureOptions};
/// let image = Image::new(2, 1, 1, vec![0u8, 255])?;
/// let texture = Texture::new(image.view(), TextureOptions::default())?;
/// let mut middle = [0.0f32];
/// Sampler::default().sample_points(&texture, &[0.5f32, 0.5], &mut middle)?;
/// assert_eq!(middle, [0.5]);
/// # Ok::<(), multum::Error>(())
/// ```
#[derive(Debug)]
pub struct Texture<'a> {
    width: usize,
    height: usize,
    dtype: DType,
    format: Format,
    /// Meaning of the stored codes: floats are stored decoded.
    stored: Format,
    options: TextureOptions,
    base: Base<'a>,
    levels: OnceLock<Vec<Level>>,
    /// One a group of channels.
    tables: Vec<OnceLock<SummedAreaTable>>,
    /// One a group of channels.
    bounds: Vec<OnceLock<Bounds>>,
    /// One a group of channels.
    details: Vec<OnceLock<Detail>>,
}

#[derive(Debug)]
enum Base<'a> {
    Owned(Level),
    Borrowed(AnyView<'a>),
}

impl Texture<'static> {
    /// A texture that keeps a copy of `image`.
    ///
    /// Under [`Wrap::Extend`] the image has one extra texel on both sides of that axis.
    ///
    /// # Errors
    /// [`Error::Value`] when options do not fit the image.
    pub fn new(image: AnyView<'_>, options: TextureOptions) -> Result<Self> {
        let format = Format::new(options.encoding, options.alpha, image.channels())?;
        let options = checked(options, format)?;
        let extra = options.wrap.map(|w| usize::from(w == Wrap::Extend));
        let (width, height) = (image.width(), image.height());
        if width <= 2 * extra[0] || height <= 2 * extra[1] {
            return Err(Error::value(
                "image",
                format!("{width}x{height} (width x height)"),
                "at least 3 texels along an axis whose wrap mode is \"extend\"",
            ));
        }
        let dtype = image.dtype();
        // Integers keep their codes. Floats are decoded once, here, which is exact to rounding.
        let decodes = !dtype.is_integer() && format.encoding != Encoding::Linear;
        let stored = if decodes { Format { encoding: Encoding::Linear, ..format } } else { format };
        let single = |c, x| decode(format.channel_encoding(c), dtype, x) as f32;
        let level = match image {
            AnyView::F16(view) if decodes => Level::store(view, options.wrap, single),
            AnyView::F32(view) if decodes => Level::store(view, options.wrap, single),
            AnyView::F64(view) if decodes => {
                Level::store(view, options.wrap, |c, x| decode(format.channel_encoding(c), dtype, x))
            }
            _ => for_any!(AnyView, image, view => Level::copy(view, options.wrap)),
        };
        Ok(Self {
            width: level.width,
            height: level.height,
            dtype,
            format,
            stored,
            options,
            base: Base::Owned(level),
            levels: OnceLock::new(),
            tables: vec![OnceLock::new(); format.channels.div_ceil(4)],
            bounds: (0..format.channels.div_ceil(4)).map(|_| OnceLock::new()).collect(),
            details: (0..format.channels.div_ceil(4)).map(|_| OnceLock::new()).collect(),
        })
    }
}

impl<'a> Texture<'a> {
    /// A texture whose first level is `image` itself, not copied. Made for a single pass over few pixels
    /// or many; reads near the edge are slower than those of [`Texture::new`].
    ///
    /// # Errors
    /// [`Error::Value`] when options do not fit the image, under [`Wrap::Extend`], and for floats that are
    /// not linear: these need a copy.
    pub fn borrowed(image: AnyView<'a>, options: TextureOptions) -> Result<Self> {
        let format = Format::new(options.encoding, options.alpha, image.channels())?;
        let options = checked(options, format)?;
        if options.wrap.contains(&Wrap::Extend) {
            return Err(Error::value("wrap", "\"extend\"", "another mode for an image that is not copied"));
        }
        if !image.dtype().is_integer() && format.encoding != Encoding::Linear {
            return Err(Error::value("encoding", options.encoding.name(), "\"linear\" for borrowed floats"));
        }
        Ok(Self {
            width: image.width(),
            height: image.height(),
            dtype: image.dtype(),
            format,
            stored: format,
            options,
            base: Base::Borrowed(image),
            levels: OnceLock::new(),
            tables: vec![OnceLock::new(); format.channels.div_ceil(4)],
            bounds: (0..format.channels.div_ceil(4)).map(|_| OnceLock::new()).collect(),
            details: (0..format.channels.div_ceil(4)).map(|_| OnceLock::new()).collect(),
        })
    }

    /// Texels in a row of the first level, without extra texels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows of the first level, without extra texels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Numbers in a texel.
    pub fn channels(&self) -> usize {
        self.format.channels
    }

    /// Element type of the image that the texture was made from.
    pub fn dtype(&self) -> DType {
        self.dtype
    }

    /// What the codes mean.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Wrap modes along u and v.
    pub fn wrap(&self) -> [Wrap; 2] {
        self.options.wrap
    }

    /// The border colour, one number a channel.
    pub fn border(&self) -> &[f64] {
        &self.options.border
    }

    /// How levels are made.
    pub fn pyramid(&self) -> pyramid::Kind {
        self.options.pyramid
    }

    /// Number of levels: `floor(log2(max(width, height))) + 1`.
    pub fn num_levels(&self) -> usize {
        pyramid::num_levels(self.width, self.height)
    }

    /// Whether results are doubles: they are for `f64` textures, singles for all others.
    pub fn is_double(&self) -> bool {
        self.dtype == DType::F64
    }

    /// Bytes that the texture holds now: its levels and tables as far as they are made. Borrowed pixels do not
    /// count.
    pub fn nbytes(&self) -> usize {
        let bytes = |level: &Level| for_any!(Pixels, &level.texels, v => size_of_val(v.as_slice()));
        let base = match &self.base {
            Base::Owned(level) => bytes(level),
            Base::Borrowed(_) => 0,
        };
        let levels = self.levels.get().map_or(0, |levels| levels.iter().map(bytes).sum());
        let tables = self.tables.iter().filter_map(OnceLock::get).map(SummedAreaTable::nbytes);
        let bounds = self.bounds.iter().filter_map(OnceLock::get).map(Bounds::nbytes);
        let details = self.details.iter().filter_map(OnceLock::get).map(Detail::nbytes);
        base + levels + tables.sum::<usize>() + bounds.sum::<usize>() + details.sum::<usize>()
    }

    /// A level as an image of the texture's own type and encoding (level 0: what was given).
    ///
    /// # Errors
    /// [`Error::Value`] when there is no such level.
    pub fn level(&self, index: usize) -> Result<Image> {
        if index >= self.num_levels() {
            return Err(Error::value("level", index, format!("0 to {}", self.num_levels() - 1)));
        }
        let level = match (index, &self.base) {
            (0, Base::Owned(level)) => level,
            (0, Base::Borrowed(view)) => return packed(*view),
            _ => &self.levels()?[index - 1],
        };
        let channels = self.channels();
        let mut codes = Vec::with_capacity(level.width * level.height * channels);
        for_any!(Pixels, &level.texels, texels => {
            for y in 0..level.height {
                let row = &texels[level.origin() + y * level.row()..][..level.width * level.lanes];
                for texel in row.chunks_exact(level.lanes) {
                    codes.extend(texel[..channels].iter().map(|t| t.to_f64()));
                }
            }
        });
        if self.stored != self.format {
            for (i, code) in codes.iter_mut().enumerate() {
                *code = encode(self.format.channel_encoding(i % channels), self.dtype, *code);
            }
        }
        let pixels = match self.dtype {
            DType::U8 => from_codes::<u8>(&codes),
            DType::U16 => from_codes::<u16>(&codes),
            DType::F16 => from_codes::<f16>(&codes),
            DType::F32 => from_codes::<f32>(&codes),
            DType::F64 => Pixels::F64(codes),
        };
        Image::new(level.width, level.height, channels, pixels)
    }

    /// Levels from the second on.
    fn levels(&self) -> Result<&[Level]> {
        if let Some(levels) = self.levels.get() {
            return Ok(levels);
        }
        let built = match &self.base {
            Base::Borrowed(view) => for_any!(AnyView, view, v => self.build_levels(*v, None))?,
            Base::Owned(level) => for_any!(Pixels, &level.texels, texels => {
                let inner = View::new(&texels[level.origin()..], level.width, level.height, level.lanes, level.row())?;
                self.build_levels(inner, Some((level, texels.as_slice())))
            })?,
        };
        Ok(self.levels.get_or_init(|| built))
    }

    /// Makes all levels; `base` is the stored first level where it has extra texels to reduce.
    fn build_levels<T: Element>(
        &self,
        image: View<'_, T>,
        base: Option<(&Level, &[T])>,
    ) -> Result<Vec<Level>> {
        let lanes = lanes_of(self.channels());
        let options = pyramid::Options {
            kind: self.options.pyramid,
            format: self.stored,
            wrap: self.options.wrap,
            coverage: self.options.coverage,
        };
        let sizes: Vec<_> = (1..self.num_levels())
            .map(|l| (pyramid::level_size(self.width, l), pyramid::level_size(self.height, l)))
            .collect();
        let mut stores: Vec<Vec<T>> =
            sizes.iter().map(|(w, h)| vec![T::default(); (w + 2) * (h + 2) * lanes]).collect();
        let mut targets: Vec<_> = (stores.iter_mut().zip(&sizes))
            .map(|(data, &(width, height))| pyramid::Target {
                data,
                origin: (width + 3) * lanes,
                row_stride: (width + 2) * lanes,
                width,
                height,
            })
            .collect();
        pyramid::build_into(image, lanes, &mut targets, &options)?;
        if let Some((base, texels)) = base {
            store::reduce_extra(base, texels, &sizes, &mut stores, &options)?;
        }
        let wrap = self.options.wrap;
        Ok(stores
            .into_iter()
            .zip(sizes)
            .map(|(mut data, (width, height))| {
                store::fill_apron(&mut data, width, height, lanes, wrap);
                Level { texels: T::into_pixels(data), width, height, lanes }
            })
            .collect())
    }

    /// Number of groups of up to four channels.
    pub(crate) fn num_groups(&self) -> usize {
        self.channels().div_ceil(4)
    }

    /// The levels of one group of channels, ready to be read: level 0 alone, or all.
    ///
    /// # Errors
    /// [`Error::Type`] when the stored type is not `T`; errors of making levels.
    pub(crate) fn layers<T: Element>(&self, group: usize, all: bool) -> Result<Layers<'_, T>> {
        let wrong = || Error::type_("texture", self.dtype.name(), T::DTYPE.name());
        let mut planes = Vec::new();
        planes.push(match &self.base {
            Base::Owned(level) => level.plane(group, self.options.wrap).ok_or_else(wrong)?,
            Base::Borrowed(view) => borrowed_plane(T::of_view(view).ok_or_else(wrong)?, group),
        });
        if all {
            for level in self.levels()? {
                planes.push(level.plane(group, self.options.wrap).ok_or_else(wrong)?);
            }
        }
        let border =
            std::array::from_fn(|lane| self.options.border.get(4 * group + lane).copied().unwrap_or(0.0));
        let decoder = Decoder::new::<T>(self.stored, group);
        Ok(Layers {
            planes,
            wrap: self.options.wrap,
            border,
            decoder,
            sums: None,
            bounds: None,
            detail: None,
        })
    }

    /// The summed-area table of one group of channels, made when it is first needed, once.
    ///
    /// # Errors
    /// As [`Texture::layers`], and errors of making the table.
    pub(crate) fn table<T: Element>(&self, group: usize) -> Result<&SummedAreaTable> {
        let slot = &self.tables[group];
        if let Some(table) = slot.get() {
            return Ok(table);
        }
        let layers = self.layers::<T>(group, false)?;
        let (plane, decoder) = (&layers.planes[0], &layers.decoder);
        let channels = (self.channels() - 4 * group).min(4);
        let wrap = self.options.wrap;
        // Extra texels are part of what the table sums.
        let extra = wrap.map(|w| i32::from(w == Wrap::Extend));
        let columns = -extra[0]..plane.width + extra[0];
        let places = (-extra[1]..plane.height + extra[1]).flat_map(|y| columns.clone().map(move |x| (x, y)));
        let texels = places.map(|(x, y)| plane.texel(x, y));
        let (w, h) = (self.width + 2 * extra[0] as usize, self.height + 2 * extra[1] as usize);
        let image = if decoder.is_plain() {
            let codes: Vec<T> = texels.flat_map(|t| t.into_iter().take(channels)).collect();
            Image::new(w, h, channels, T::into_pixels(codes))?
        } else {
            let decoded = texels
                .flat_map(|t| decoder.texel(t).map(crate::num::Real::to_f64).into_iter().take(channels));
            Image::new(w, h, channels, decoded.collect::<Vec<f64>>())?
        };
        let made = SummedAreaTable::new(image.view(), wrap, Some(&layers.border[..channels]))?;
        Ok(slot.get_or_init(|| made))
    }

    /// The bounds of one group of channels, in the space of averages, made when they are first needed, once.
    ///
    /// # Errors
    /// As [`Texture::layers`].
    pub(crate) fn bounds<T: Element>(&self, group: usize) -> Result<&Bounds> {
        let slot = &self.bounds[group];
        if let Some(bounds) = slot.get() {
            return Ok(bounds);
        }
        let layers = self.layers::<T>(group, false)?;
        let made = if layers.decoder.is_plain() {
            self.bounds_of(&layers, Plain { full_scale: layers.decoder.full_scale })?
        } else {
            self.bounds_of(&layers, layers.decoder)?
        };
        Ok(slot.get_or_init(|| made))
    }

    fn bounds_of<T: Element, D: Decode<T>>(&self, layers: &Layers<'_, T>, decode: D) -> Result<Bounds> {
        let texel = texels(layers, decode);
        Bounds::new([self.width, self.height], layers.wrap, |x, y| texel(0, x, y))
    }

    /// What each level of one group of channels lacks, made when it is first needed, once.
    ///
    /// # Errors
    /// As [`Texture::layers`].
    pub(crate) fn detail<T: Element>(&self, group: usize) -> Result<&Detail> {
        let slot = &self.details[group];
        if let Some(detail) = slot.get() {
            return Ok(detail);
        }
        let layers = self.layers::<T>(group, true)?;
        let sizes: Vec<_> = layers.planes.iter().map(|p| [p.width as usize, p.height as usize]).collect();
        let made = if layers.decoder.is_plain() {
            let plain = Plain { full_scale: layers.decoder.full_scale };
            Detail::new(&sizes, layers.wrap, rows(&layers, plain))?
        } else {
            Detail::new(&sizes, layers.wrap, rows(&layers, layers.decoder))?
        };
        Ok(slot.get_or_init(|| made))
    }

    /// The type of the stored elements: the texture's own, but single for decoded half floats.
    pub(crate) fn stored_dtype(&self) -> DType {
        match &self.base {
            Base::Owned(level) => level.dtype(),
            Base::Borrowed(view) => view.dtype(),
        }
    }
}

/// Texels of all levels at any place, as they are averaged.
fn texels<T: Element, D: Decode<T>>(
    layers: &Layers<'_, T>,
    decode: D,
) -> impl Fn(usize, i64, i64) -> [f64; 4] + Sync {
    let [wu, wv] = layers.wrap;
    let outside = decode.outside(layers.border).map(crate::num::Real::to_f64);
    move |level, x, y| {
        let plane = &layers.planes[level];
        let at = if plane.is_readable(x as i32, y as i32) {
            (Some(x), Some(y))
        } else {
            (wu.index(x, plane.width.into()), wv.index(y, plane.height.into()))
        };
        match at {
            (Some(x), Some(y)) => decode.texel(plane.texel(x as i32, y as i32)).map(crate::num::Real::to_f64),
            _ => outside,
        }
    }
}

/// Rows of all levels from column -1 to one beyond the last, in singles as they are averaged.
fn rows<T: Element, D: Decode<T>>(
    layers: &Layers<'_, T>,
    decode: D,
) -> impl Fn(usize, i64, &mut [[f32; 4]]) + Sync {
    let texel = texels(layers, decode);
    move |level, y, out| {
        let plane = &layers.planes[level];
        let inside = plane.rows.0.into()..=i64::from(plane.rows.1);
        let readable = if inside.contains(&y) { plane.columns } else { (0, -1) };
        for (x, out) in (-1..).zip(out) {
            *out = if x >= readable.0 && x <= readable.1 {
                decode.texel(plane.texel(x, y as i32)).map(|v| crate::num::Real::to_f64(v) as f32)
            } else {
                texel(level, x.into(), y).map(|v| v as f32)
            };
        }
    }
}

/// Checks and completes the border colour and the coverage threshold.
fn checked(mut options: TextureOptions, format: Format) -> Result<TextureOptions> {
    if options.border.len() > format.channels || options.border.iter().any(|b| !b.is_finite()) {
        return Err(Error::value(
            "border",
            format!("{:?}", options.border),
            format!("at most {} finite numbers, one a channel", format.channels),
        ));
    }
    options.border.resize(format.channels, 0.0);
    if let Some(threshold) = options.coverage {
        if format.alpha_channel().is_none() {
            return Err(Error::value("coverage", threshold, "None, or a texture with alpha"));
        }
        if !(threshold > 0.0 && threshold <= 1.0) {
            return Err(Error::value("coverage", threshold, "a threshold of alpha in (0, 1]"));
        }
    }
    Ok(options)
}

fn from_codes<T: Element>(codes: &[f64]) -> Pixels {
    T::into_pixels(codes.iter().map(|c| T::from_f64(*c)).collect())
}

fn packed(view: AnyView<'_>) -> Result<Image> {
    for_any!(AnyView, view, v => {
        let data: Vec<_> = (0..v.height()).flat_map(|y| v.row(y).iter().copied()).collect();
        Image::new(v.width(), v.height(), v.channels(), data)
    })
}
