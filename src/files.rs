//! Image files, through the `image` crate: PNG, JPEG, TIFF, Radiance HDR and OpenEXR.

use crate::error::{Error, Result};
use crate::image::{AnyView, Image, Pixels, for_any};
use crate::texel::{DType, Texel};
use image::{
    ColorType, DynamicImage, ExtendedColorType, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits,
};
use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Cursor, Seek, Write};
use std::path::{Path, PathBuf};

/// Extensions of the formats that are read and written.
pub const EXTENSIONS: [&str; 7] = ["png", "jpg", "jpeg", "tif", "tiff", "hdr", "exr"];

/// What a file's header says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Info {
    /// Name of the format, such as "Png".
    pub format: String,
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Numbers in a pixel.
    pub channels: usize,
    /// Type of the numbers.
    pub dtype: DType,
}

fn io_error(path: &Path, source: std::io::Error) -> Error {
    Error::Io { path: path.to_owned(), source }
}

fn file_error(path: &Path, message: impl ToString) -> Error {
    Error::File { path: path.to_owned(), message: message.to_string() }
}

fn decode_error(path: &Path, error: ImageError) -> Error {
    match error {
        ImageError::IoError(source) if source.raw_os_error().is_some() => io_error(path, source),
        ImageError::Limits(e) => file_error(
            path,
            format!("claims far more pixels than its bytes can hold ({e}); expected an undamaged image"),
        ),
        e => file_error(path, format!("{e}; expected an undamaged {}", EXTENSIONS.join(", "))),
    }
}

/// Opens a file with a limit on memory that its size can justify: deflate packs at most 1032 to 1, and the
/// other formats less, so a short file that claims a huge picture is refused before anything is allocated. Returns the limit, too.
fn open(path: &Path) -> Result<(ImageReader<BufReader<File>>, u64)> {
    let file = File::open(path).map_err(|e| io_error(path, e))?;
    let bytes = file.metadata().map_err(|e| io_error(path, e))?.len();
    limited(path, BufReader::new(file), bytes)
}

fn limited<R: BufRead + Seek>(path: &Path, reader: R, bytes: u64) -> Result<(ImageReader<R>, u64)> {
    let mut reader = ImageReader::new(reader).with_guessed_format().map_err(|e| io_error(path, e))?;
    if reader.format().is_none() {
        return Err(file_error(
            path,
            format!("not an image of a known kind; expected {}", EXTENSIONS.join(", ")),
        ));
    }
    let most = bytes.saturating_mul(2048).saturating_add(64 << 20);
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(most);
    reader.limits(limits);
    Ok((reader, most))
}

fn kind_of(color: ColorType) -> Option<(usize, DType)> {
    Some(match color {
        ColorType::L8 => (1, DType::U8),
        ColorType::La8 => (2, DType::U8),
        ColorType::Rgb8 => (3, DType::U8),
        ColorType::Rgba8 => (4, DType::U8),
        ColorType::L16 => (1, DType::U16),
        ColorType::La16 => (2, DType::U16),
        ColorType::Rgb16 => (3, DType::U16),
        ColorType::Rgba16 => (4, DType::U16),
        ColorType::Rgb32F => (3, DType::F32),
        ColorType::Rgba32F => (4, DType::F32),
        _ => return None,
    })
}

/// Reads a file's header.
///
/// # Errors
/// [`Error::Io`] when it cannot be opened, [`Error::File`] when it is no image or damaged.
pub fn info(path: impl AsRef<Path>) -> Result<Info> {
    let path = path.as_ref();
    let (reader, _) = open(path)?;
    let format = reader.format().map_or(String::new(), |f| format!("{f:?}"));
    let decoder = reader.into_decoder().map_err(|e| decode_error(path, e))?;
    let (width, height) = decoder.dimensions();
    let color = decoder.color_type();
    let (channels, dtype) =
        kind_of(color).ok_or_else(|| file_error(path, format!("unknown pixels {color:?}")))?;
    Ok(Info { format, width: width as usize, height: height as usize, channels, dtype })
}

/// Reads an image with its own number of channels and element type (8 or 16 bit, or single floats), turned
/// upright where its metadata say so.
///
/// # Errors
/// [`Error::Io`] when it cannot be opened, [`Error::File`] when it is no image, damaged, or claims more
/// pixels than a file of its size can hold.
pub fn read(path: impl AsRef<Path>) -> Result<Image> {
    let path = path.as_ref();
    pixels_of(path, open(path)?)
}

/// As [`read`], of a file's content; `name` stands for the path in errors.
///
/// # Errors
/// As [`read`].
pub fn decode(name: impl AsRef<Path>, bytes: &[u8]) -> Result<Image> {
    let name = name.as_ref();
    pixels_of(name, limited(name, Cursor::new(bytes), bytes.len() as u64)?)
}

fn pixels_of<R: BufRead + Seek>(path: &Path, (reader, most): (ImageReader<R>, u64)) -> Result<Image> {
    let mut decoder = reader.into_decoder().map_err(|e| decode_error(path, e))?;
    // Decoders hold their own working memory to the limit, but not the picture that they fill.
    let claimed = decoder.total_bytes();
    if claimed > most || crate::image::zeros::<u8>("path", claimed as usize).is_err() {
        let (width, height) = decoder.dimensions();
        let message = format!("claims {width}x{height} pixels in {claimed} bytes; expected at most {most}");
        return Err(file_error(path, message));
    }
    let orientation = decoder.orientation().map_err(|e| decode_error(path, e))?;
    let mut picture = DynamicImage::from_decoder(decoder).map_err(|e| decode_error(path, e))?;
    picture.apply_orientation(orientation);
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let color = picture.color();
    let (channels, _) =
        kind_of(color).ok_or_else(|| file_error(path, format!("unknown pixels {color:?}")))?;
    let pixels: Pixels = match picture {
        DynamicImage::ImageLuma8(p) => p.into_raw().into(),
        DynamicImage::ImageLumaA8(p) => p.into_raw().into(),
        DynamicImage::ImageRgb8(p) => p.into_raw().into(),
        DynamicImage::ImageRgba8(p) => p.into_raw().into(),
        DynamicImage::ImageLuma16(p) => p.into_raw().into(),
        DynamicImage::ImageLumaA16(p) => p.into_raw().into(),
        DynamicImage::ImageRgb16(p) => p.into_raw().into(),
        DynamicImage::ImageRgba16(p) => p.into_raw().into(),
        DynamicImage::ImageRgb32F(p) => p.into_raw().into(),
        DynamicImage::ImageRgba32F(p) => p.into_raw().into(),
        _ => return Err(file_error(path, "unknown pixels")),
    };
    Image::new(width, height, channels, pixels)
}

/// Writes an image; the extension names the format. PNG takes 8 and 16 bit of 1 to 4 channels, TIFF
/// of 1, 3 or 4 and single floats of 3 or 4, JPEG 8 bit of 1 or 3, HDR floats of 3 and EXR floats of 3 or 4.
/// The file is written beside its place and then renamed, so it is whole or absent.
///
/// # Errors
/// [`Error::Value`] for an extension or pixels that the format cannot hold, [`Error::Io`] for the rest.
pub fn write(path: impl AsRef<Path>, image: AnyView<'_>) -> Result<()> {
    let path = path.as_ref();
    let known = || format!("a name ending in one of {}", EXTENSIONS.join(", "));
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let format = ImageFormat::from_extension(&extension)
        .filter(|_| EXTENSIONS.contains(&extension.as_str()))
        .ok_or_else(|| Error::value("path", path.display(), known()))?;
    let float = matches!(format, ImageFormat::Hdr | ImageFormat::OpenExr);
    let allowed: &[ExtendedColorType] = match format {
        ImageFormat::Jpeg => &[ExtendedColorType::L8, ExtendedColorType::Rgb8],
        ImageFormat::Hdr => &[ExtendedColorType::Rgb32F],
        ImageFormat::OpenExr => &[ExtendedColorType::Rgb32F, ExtendedColorType::Rgba32F],
        ImageFormat::Tiff => &TIFF_COLORS,
        _ => &PNG_COLORS,
    };
    let color = color_of(image.channels(), image.dtype());
    let Some(color) = color.filter(|c| allowed.contains(c)) else {
        let got = format!("{} channel(s) of {}", image.channels(), image.dtype().name());
        let expected =
            format!("{allowed:?} for .{extension}{}", if float { " (convert with astype)" } else { "" });
        return Err(Error::value("image", got, expected));
    };
    let bytes = packed_bytes(image);
    let (width, height) = (image.width() as u32, image.height() as u32);
    write_beside(path, |out| {
        image::write_buffer_with_format(out, &bytes, width, height, color, format)
            .map_err(|e| file_error(path, format!("cannot be encoded: {e}")))
    })
}

const PNG_COLORS: [ExtendedColorType; 8] = [
    ExtendedColorType::L8,
    ExtendedColorType::La8,
    ExtendedColorType::Rgb8,
    ExtendedColorType::Rgba8,
    ExtendedColorType::L16,
    ExtendedColorType::La16,
    ExtendedColorType::Rgb16,
    ExtendedColorType::Rgba16,
];

const TIFF_COLORS: [ExtendedColorType; 8] = [
    ExtendedColorType::L8,
    ExtendedColorType::Rgb8,
    ExtendedColorType::Rgba8,
    ExtendedColorType::L16,
    ExtendedColorType::Rgb16,
    ExtendedColorType::Rgba16,
    ExtendedColorType::Rgb32F,
    ExtendedColorType::Rgba32F,
];

fn color_of(channels: usize, dtype: DType) -> Option<ExtendedColorType> {
    let of = |colors: &[ExtendedColorType], least: usize| {
        channels.checked_sub(least).and_then(|i| colors.get(i)).copied()
    };
    match dtype {
        DType::U8 => of(&PNG_COLORS[..4], 1),
        DType::U16 => of(&PNG_COLORS[4..], 1),
        DType::F16 | DType::F32 | DType::F64 => of(&TIFF_COLORS[6..], 3),
    }
}

/// The pixels in native byte order, floats as singles.
fn packed_bytes(image: AnyView<'_>) -> Vec<u8> {
    match image {
        AnyView::U8(v) => (0..v.height()).flat_map(|y| v.row(y).iter().copied()).collect(),
        AnyView::U16(v) => {
            (0..v.height()).flat_map(|y| v.row(y).iter().flat_map(|x| x.to_ne_bytes())).collect()
        }
        _ => for_any!(AnyView, image, v => {
            (0..v.height()).flat_map(|y| v.row(y).iter().flat_map(|x| x.to_f32().to_ne_bytes())).collect()
        }),
    }
}

/// Writes `path` whole or not at all.
fn write_beside(path: &Path, fill: impl FnOnce(&mut std::io::Cursor<Vec<u8>>) -> Result<()>) -> Result<()> {
    let mut encoded = std::io::Cursor::new(Vec::new());
    fill(&mut encoded)?;
    let name = path.file_name().map_or_else(|| "image".into(), |n| n.to_string_lossy());
    let beside: PathBuf = path.with_file_name(format!(".{name}.{}.part", std::process::id()));
    let written = (|| {
        let mut out = BufWriter::new(File::create(&beside)?);
        out.write_all(encoded.get_ref())?;
        out.into_inner().map_err(std::io::IntoInnerError::into_error)?.sync_all()?;
        std::fs::rename(&beside, path)
    })();
    written.map_err(|e| {
        // What is left of a failed write is of no use; that it cannot be removed says nothing new.
        let _ = std::fs::remove_file(&beside);
        io_error(path, e)
    })
}
