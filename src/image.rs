//! Pictures in memory: owned and borrowed, of any element type. Rows run down, channels are interleaved.

use crate::error::{Error, Result};
use crate::texel::{DType, Texel, f16};

/// Most elements an image may have: keeps every index and byte count far inside `isize`.
pub const MAX_ELEMENTS: usize = 1 << 40;

/// A borrowed picture. The channels of a pixel and the pixels of a row are contiguous; rows may be apart.
#[derive(Clone, Copy, Debug)]
pub struct View<'a, T> {
    data: &'a [T],
    width: usize,
    height: usize,
    channels: usize,
    row_stride: usize,
}

impl<'a, T: Texel> View<'a, T> {
    /// A view of `height` rows of `width * channels` elements, `row_stride` elements apart.
    ///
    /// # Errors
    /// [`Error::Value`] for an empty picture, overlapping rows or a slice that is too short.
    pub fn new(
        data: &'a [T],
        width: usize,
        height: usize,
        channels: usize,
        row_stride: usize,
    ) -> Result<Self> {
        check_size("image", width, height, channels)?;
        let row = width * channels;
        let needed = row_stride.checked_mul(height - 1).and_then(|n| n.checked_add(row));
        if row_stride < row || needed.is_none_or(|n| n > data.len()) {
            return Err(Error::value(
                "image",
                format!("{} elements with rows {row_stride} apart", data.len()),
                format!("room for {height} rows of {row} elements"),
            ));
        }
        Ok(Self { data, width, height, channels, row_stride })
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Numbers in a pixel.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Elements from one row's start to the next's.
    pub fn row_stride(&self) -> usize {
        self.row_stride
    }

    /// The elements from the first row's start on.
    pub fn data(&self) -> &'a [T] {
        self.data
    }

    /// Row `y`: `width * channels` elements.
    pub fn row(&self, y: usize) -> &'a [T] {
        &self.data[y * self.row_stride..][..self.width * self.channels]
    }

    /// The channels of pixel (x, y).
    pub fn pixel(&self, x: usize, y: usize) -> &'a [T] {
        &self.row(y)[x * self.channels..][..self.channels]
    }
}

/// Refuses empty and absurd sizes.
pub(crate) fn check_size(argument: &'static str, width: usize, height: usize, channels: usize) -> Result<()> {
    let elements = width.checked_mul(height).and_then(|n| n.checked_mul(channels));
    match elements {
        Some(1..=MAX_ELEMENTS) if width <= 1 << 30 && height <= 1 << 30 => Ok(()),
        _ => Err(Error::value(
            argument,
            format!("width {width}, height {height}, {channels} channel(s)"),
            "at least one pixel and one channel, sides up to 2^30 and at most 2^40 elements",
        )),
    }
}

/// So many zeros, or an error that names `argument` where memory does not suffice.
pub(crate) fn zeros<T: Clone + Default>(argument: &'static str, len: usize) -> Result<Vec<T>> {
    // A request that is given back at once: failure of the real one, which lets the system hand out zeroed
    // pages, would end the process.
    let mut probe = Vec::<T>::new();
    let refused = probe.try_reserve_exact(len).is_err();
    std::hint::black_box(&mut probe);
    drop(probe);
    if refused {
        let bytes = len.saturating_mul(size_of::<T>());
        return Err(Error::value(argument, format!("{bytes} bytes of results"), "what memory can hold"));
    }
    Ok(vec![T::default(); len])
}

/// Elements of a run-time type.
#[derive(Clone, Debug, PartialEq)]
pub enum Pixels {
    /// 8-bit integers.
    U8(Vec<u8>),
    /// 16-bit integers.
    U16(Vec<u16>),
    /// Half floats.
    F16(Vec<f16>),
    /// Single floats.
    F32(Vec<f32>),
    /// Double floats.
    F64(Vec<f64>),
}

/// A borrowed picture of a run-time type.
#[derive(Clone, Copy, Debug)]
pub enum AnyView<'a> {
    /// 8-bit integers.
    U8(View<'a, u8>),
    /// 16-bit integers.
    U16(View<'a, u16>),
    /// Half floats.
    F16(View<'a, f16>),
    /// Single floats.
    F32(View<'a, f32>),
    /// Double floats.
    F64(View<'a, f64>),
}

/// Runs one expression for whatever element type a [`Pixels`], [`AnyView`] or alike enum holds.
macro_rules! for_any {
    ($enum:ident, $value:expr, $name:ident => $body:expr) => {
        match $value {
            $enum::U8($name) => $body,
            $enum::U16($name) => $body,
            $enum::F16($name) => $body,
            $enum::F32($name) => $body,
            $enum::F64($name) => $body,
        }
    };
}

pub(crate) use for_any;

/// An element type together with its places in [`Pixels`] and [`AnyView`].
pub trait Element: Texel {
    /// The elements, where they are of this type.
    fn of_pixels(pixels: &Pixels) -> Option<&[Self]>;
    /// The view, where it is of this type.
    fn of_view<'a>(view: &AnyView<'a>) -> Option<View<'a, Self>>;
    /// Tags a vector with its type.
    fn into_pixels(data: Vec<Self>) -> Pixels;
}

macro_rules! wrap_typed {
    ($($variant:ident $type:ty),+) => {$(
        impl Element for $type {
            fn of_pixels(pixels: &Pixels) -> Option<&[Self]> {
                if let Pixels::$variant(data) = pixels { Some(data) } else { None }
            }
            fn of_view<'a>(view: &AnyView<'a>) -> Option<View<'a, Self>> {
                if let AnyView::$variant(view) = view { Some(*view) } else { None }
            }
            fn into_pixels(data: Vec<Self>) -> Pixels {
                Pixels::$variant(data)
            }
        }
        impl From<Vec<$type>> for Pixels {
            fn from(data: Vec<$type>) -> Self {
                Self::$variant(data)
            }
        }
        impl<'a> From<View<'a, $type>> for AnyView<'a> {
            fn from(view: View<'a, $type>) -> Self {
                Self::$variant(view)
            }
        }
    )+};
}
wrap_typed!(U8 u8, U16 u16, F16 f16, F32 f32, F64 f64);

impl AnyView<'_> {
    /// Pixels in a row.
    pub fn width(&self) -> usize {
        for_any!(AnyView, self, v => v.width())
    }

    /// Rows.
    pub fn height(&self) -> usize {
        for_any!(AnyView, self, v => v.height())
    }

    /// Numbers in a pixel.
    pub fn channels(&self) -> usize {
        for_any!(AnyView, self, v => v.channels())
    }

    /// Element type.
    pub fn dtype(&self) -> DType {
        match self {
            Self::U8(_) => DType::U8,
            Self::U16(_) => DType::U16,
            Self::F16(_) => DType::F16,
            Self::F32(_) => DType::F32,
            Self::F64(_) => DType::F64,
        }
    }
}

/// An owned picture, packed.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: usize,
    height: usize,
    channels: usize,
    pixels: Pixels,
}

impl Image {
    /// A picture from packed elements, row by row, channels interleaved.
    ///
    /// # Errors
    /// [`Error::Value`] when the number of elements is not `width * height * channels`, or is zero.
    ///
    /// ```
    /// let grey = multum::Image::new(2, 1, 1, vec![0u8, 255]).unwrap();
    /// assert_eq!(grey.dtype(), multum::DType::U8);
    /// assert!(multum::Image::new(2, 2, 1, vec![0u8, 255]).is_err());
    /// ```
    pub fn new(width: usize, height: usize, channels: usize, pixels: impl Into<Pixels>) -> Result<Self> {
        check_size("image", width, height, channels)?;
        let pixels = pixels.into();
        let len = for_any!(Pixels, &pixels, v => v.len());
        if len != width * height * channels {
            return Err(Error::value("pixels", format!("{len} elements"), width * height * channels));
        }
        Ok(Self { width, height, channels, pixels })
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Numbers in a pixel.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Element type.
    pub fn dtype(&self) -> DType {
        self.view().dtype()
    }

    /// The elements.
    pub fn pixels(&self) -> &Pixels {
        &self.pixels
    }

    /// The elements, given away.
    pub fn into_pixels(self) -> Pixels {
        self.pixels
    }

    /// Borrows the picture.
    pub fn view(&self) -> AnyView<'_> {
        let (width, height, channels) = (self.width, self.height, self.channels);
        for_any!(Pixels, &self.pixels, data => {
            AnyView::from(View { data, width, height, channels, row_stride: width * channels })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_refuse_what_does_not_fit() {
        let data = [0u8; 24];
        assert!(View::new(&data, 2, 4, 3, 6).is_ok());
        assert!(View::new(&data, 2, 4, 3, 5).is_err(), "rows overlap");
        assert!(View::new(&data, 3, 4, 3, 9).is_err(), "too short");
        assert!(View::new(&data, 0, 4, 3, 6).is_err(), "empty");
        assert!(View::new(&data, usize::MAX, 2, 3, 6).is_err(), "overflow");
        assert!(View::new(&data, 2, usize::MAX / 2, 3, 6).is_err(), "overflow");
    }

    #[test]
    fn rows_may_be_apart() {
        let data: Vec<u16> = (0..20).collect();
        let view = View::new(&data, 2, 2, 3, 10).unwrap();
        assert_eq!(view.pixel(1, 1), &[13, 14, 15]);
        assert_eq!(view.row(0), &[0, 1, 2, 3, 4, 5]);
    }
}
