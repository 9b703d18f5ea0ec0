//! OpenCV's own arithmetic, of its version 5: rounding, borders and sizes as there.

mod antialias;
pub mod area;
pub mod integral;
pub mod maps;
pub mod patch;
pub mod polar;
pub mod pyramid;
pub mod read;
pub mod resize;
pub mod separable;
pub mod undistort;

use crate::error::{Error, Result};

/// A picture to read: packed pixels in rows that may stand apart.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a, T> {
    data: &'a [T],
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Numbers in a pixel.
    pub channels: usize,
    stride: usize,
}

impl<'a, T> Rows<'a, T> {
    /// A picture whose rows start `stride` elements apart.
    ///
    /// # Errors
    /// [`Error::Value`] for an empty picture, rows that overlap or a slice that is too short.
    pub fn new(data: &'a [T], width: usize, height: usize, channels: usize, stride: usize) -> Result<Self> {
        let end = |row: usize| height.checked_sub(1)?.checked_mul(stride)?.checked_add(row);
        let fits = |row: usize| (stride >= row && end(row)? <= data.len()).then_some(());
        if width == 0 || channels == 0 || width.checked_mul(channels).and_then(fits).is_none() {
            let got =
                format!("{width} x {height} x {channels}, rows {stride} apart, in {} elements", data.len());
            return Err(Error::value("src", got, "a picture of at least one pixel in its slice"));
        }
        Ok(Self { data, width, height, channels, stride })
    }

    /// A row's elements.
    #[inline(always)]
    pub fn row(&self, y: usize) -> &'a [T] {
        &self.data[y * self.stride..][..self.width * self.channels]
    }
}
