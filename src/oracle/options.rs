//! The words that describe a texture and a pixel, written anew so that nothing is shared with the library.

use crate::error::{Error, Result};

/// What lies beyond the texture, on one axis of texels `a b c d`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// `a a a | a b c d | d d d`
    Clamp,
    /// `b c d | a b c d | a b c`
    Repeat,
    /// `c b a | a b c d | d c b`
    Mirror,
    /// One reversed copy on the left, `d` before it; `d d d` on the right.
    MirrorOnce,
    /// `d c b | a b c d | c b a`
    Mirror101,
    /// A constant colour on both sides.
    Border,
    /// The first and the last stored texel are no part of the texture and go on outwards.
    Extend,
}

/// What stored numbers mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Proportional to the quantity.
    Linear,
    /// IEC 61966-2-1 colour; alpha is linear.
    Srgb,
    /// Unit vectors: integers around the middle code, floats as `2 x - 1`.
    Normal,
}

/// Meaning of the last of two or four channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Alpha {
    /// No alpha.
    None,
    /// Colour independent of alpha; filtered as a product, returned divided.
    Straight,
    /// Colour times alpha, returned so.
    Premultiplied,
}

/// How texels become a function of the plane. Every kernel is separable and a polynomial between knots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reconstruction {
    /// Each texel is a square of constant colour.
    Nearest,
    /// Linear between texel centres on each axis.
    Bilinear,
    /// Cubic convolution with a = -1/2 (Catmull-Rom): R. Keys 1981.
    Bicubic,
}

/// Weight over the pixel, as a function of the distance (s, t) from its centre in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PixelFilter {
    /// The value at the centre alone.
    Point,
    /// 1 on the pixel's square, |s|, |t| <= 1/2.
    Box,
    /// (1 - |s|) (1 - |t|) on |s|, |t| <= 1.
    Tent,
    /// exp(-(s² + t²) / 2 sigma²) on |s|, |t| <= 4 sigma, scaled to the integral 1.
    Gaussian {
        /// Standard deviation in pixels, above 0.
        sigma: f64,
    },
}

fn find<T: Copy>(argument: &'static str, name: &str, table: &[(&str, T)]) -> Result<T> {
    table.iter().find(|(word, _)| *word == name).map(|(_, value)| *value).ok_or_else(|| {
        let words: Vec<_> = table.iter().map(|(word, _)| format!("{word:?}")).collect();
        Error::value(argument, format!("{name:?}"), format!("one of {}", words.join(", ")))
    })
}

impl Wrap {
    /// Every mode with its name.
    pub const ALL: [(&'static str, Self); 7] = [
        ("clamp", Self::Clamp),
        ("repeat", Self::Repeat),
        ("mirror", Self::Mirror),
        ("mirror_once", Self::MirrorOnce),
        ("mirror_101", Self::Mirror101),
        ("border", Self::Border),
        ("extend", Self::Extend),
    ];

    /// The mode of this name.
    ///
    /// # Errors
    /// [`Error::Value`] for any other word.
    pub fn parse(name: &str) -> Result<Self> {
        find("wrap", name, &Self::ALL)
    }
}

impl Encoding {
    /// The encoding of this name: linear, srgb, normal.
    ///
    /// # Errors
    /// [`Error::Value`] for any other word.
    pub fn parse(name: &str) -> Result<Self> {
        let table = [("linear", Self::Linear), ("srgb", Self::Srgb), ("normal", Self::Normal)];
        find("encoding", name, &table)
    }
}

impl Alpha {
    /// The meaning of this name: none, straight, premultiplied.
    ///
    /// # Errors
    /// [`Error::Value`] for any other word.
    pub fn parse(name: &str) -> Result<Self> {
        let table =
            [("none", Self::None), ("straight", Self::Straight), ("premultiplied", Self::Premultiplied)];
        find("alpha", name, &table)
    }
}

impl Reconstruction {
    /// The reconstruction of this name: nearest, bilinear, bicubic.
    ///
    /// # Errors
    /// [`Error::Value`] for any other word.
    pub fn parse(name: &str) -> Result<Self> {
        let table = [("nearest", Self::Nearest), ("bilinear", Self::Bilinear), ("bicubic", Self::Bicubic)];
        find("reconstruction", name, &table)
    }

    /// First and last texel that cell `k` reads, relative to `k`.
    pub(super) fn reach(self) -> (i64, i64) {
        match self {
            Self::Nearest => (0, 0),
            Self::Bilinear => (0, 1),
            Self::Bicubic => (-1, 2),
        }
    }

    /// Where cell `k` begins, relative to texel `k`'s outer edge: at the edge, or at the texel's centre.
    pub(super) fn start(self) -> f64 {
        if self == Self::Nearest { 0.0 } else { 0.5 }
    }

    /// Degree of the kernel's polynomials.
    pub(super) fn degree(self) -> usize {
        match self {
            Self::Nearest => 0,
            Self::Bilinear => 1,
            Self::Bicubic => 3,
        }
    }

    /// Weights of the texels in [`Self::reach`] at the share `t` of the way through the cell.
    pub(super) fn weights(self, t: f64) -> [f64; 4] {
        match self {
            Self::Nearest => [1.0, 0.0, 0.0, 0.0],
            Self::Bilinear => [1.0 - t, t, 0.0, 0.0],
            Self::Bicubic => {
                let (t2, t3) = (t * t, t * t * t);
                [
                    -0.5 * t + t2 - 0.5 * t3,
                    1.0 - 2.5 * t2 + 1.5 * t3,
                    0.5 * t + 2.0 * t2 - 1.5 * t3,
                    -0.5 * t2 + 0.5 * t3,
                ]
            }
        }
    }

    /// Integrals of [`Self::weights`] over the cell.
    pub(super) fn cell_weights(self) -> [f64; 4] {
        match self {
            Self::Nearest => [1.0, 0.0, 0.0, 0.0],
            Self::Bilinear => [0.5, 0.5, 0.0, 0.0],
            Self::Bicubic => [-1.0 / 24.0, 13.0 / 24.0, 13.0 / 24.0, -1.0 / 24.0],
        }
    }
}

impl PixelFilter {
    /// The filter of this name: point, box, tent, gaussian; `sigma` matters to the last alone.
    ///
    /// # Errors
    /// [`Error::Value`] for any other word, and for a sigma that is not in (0, 64].
    pub fn parse(name: &str, sigma: f64) -> Result<Self> {
        let table = [
            ("point", Self::Point),
            ("box", Self::Box),
            ("tent", Self::Tent),
            ("gaussian", Self::Gaussian { sigma }),
        ];
        let filter = find("pixel_filter", name, &table)?;
        if sigma > 0.0 && sigma <= 64.0 {
            Ok(filter)
        } else {
            Err(Error::value("sigma", sigma, "a number of pixels above 0 and at most 64"))
        }
    }
}
