//! Reading a picture at the places of a map or a matrix: which arithmetic OpenCV's flags stand for.
//!
//! | interpolation | positions |
//! |---|---|
//! | nearest | whole pixels; those of affine warps by way of 1/1024 pixel |
//! | linear | exact for `u8`, `u16` and `f32` of 1, 3 or 4 channels; else multiples of 1/32 pixel |
//! | cubic | exact |
//! | Lanczos | multiples of 1/32 pixel |

use super::Rows;
use crate::error::{Error, Result};
use crate::image::View;
use crate::kernel::remap::Sample;
use crate::warp::remap::{Edge, Grid, Interpolation, Job, Map, Outside, Source, interpolate};
use crate::warp::{Mapping, Maps, WarpOptions, warp_into};
use crate::wrap::Wrap;
use half::f16;

/// An element that OpenCV's warps take.
pub trait Pixel: Sample {
    /// Whether linear interpolation is exact in 1, 3 and 4 channels.
    const LINEAR_IS_EXACT: bool;
    /// The filtered warp, where the filters know the type.
    fn filtered(
        source: &Rows<'_, Self>,
        mapping: &Mapping<'_>,
        size: [usize; 2],
        options: &WarpOptions,
        out: &mut [Self],
    ) -> Option<Result<()>>;
}

macro_rules! pixel {
    ($($t:ty, $exact:literal;)+) => {$(
        impl Pixel for $t {
            const LINEAR_IS_EXACT: bool = $exact;
            fn filtered(
                source: &Rows<'_, Self>,
                mapping: &Mapping<'_>,
                size: [usize; 2],
                options: &WarpOptions,
                out: &mut [Self],
            ) -> Option<Result<()>> {
                let view = View::new(source.data, source.width, source.height, source.channels, source.stride);
                Some(view.and_then(|view| warp_into(view.into(), mapping, size[0], size[1], options, out)))
            }
        }
    )+};
}
pixel! { u8, true; u16, true; f16, false; f32, true; f64, false; }

impl Pixel for i16 {
    const LINEAR_IS_EXACT: bool = false;
    fn filtered(
        _: &Rows<'_, Self>,
        _: &Mapping<'_>,
        _: [usize; 2],
        _: &WarpOptions,
        _: &mut [Self],
    ) -> Option<Result<()>> {
        None
    }
}

/// How the function that calls reaches its positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Route {
    /// By a map, or a division.
    Map,
    /// By an affine matrix, in fixed point where they are rounded.
    Affine,
    /// Always exactly: resizing and patches.
    Exact,
}

/// The flags of a call.
#[derive(Clone, Copy, Debug)]
pub struct Manner {
    /// Between pixels.
    pub interpolation: Interpolation,
    /// Beyond the picture; `None` leaves the output as it is.
    pub edge: Option<Edge>,
    /// How positions are reached.
    pub route: Route,
    /// Whether to average where the map minifies.
    pub antialias: bool,
}

impl Manner {
    /// The meaning of `INTER_*` and `BORDER_*`.
    ///
    /// # Errors
    /// [`Error::Value`] for other numbers.
    pub fn new(interpolation: i32, border: i32, route: Route, antialias: bool) -> Result<Self> {
        let interpolation = match interpolation {
            0 => Interpolation::Nearest,
            1 | 3 => Interpolation::Bilinear,
            2 => Interpolation::Bicubic(-0.75),
            4 => Interpolation::Lanczos4,
            _ => {
                let expected = "INTER_NEAREST, _LINEAR, _CUBIC, _AREA or _LANCZOS4";
                return Err(Error::value("interpolation", interpolation, expected));
            }
        };
        const ISOLATED: i32 = 16;
        let edge = match border & !ISOLATED {
            0 => Some(Edge::Border),
            1 => Some(Edge::Clamp),
            2 => Some(Edge::Mirror),
            3 => Some(Edge::Repeat),
            4 => Some(Edge::Mirror101),
            5 => None,
            _ => {
                let expected = "one of BORDER_CONSTANT to BORDER_TRANSPARENT";
                return Err(Error::value("borderMode", border, expected));
            }
        };
        Ok(Self { interpolation, edge, route, antialias })
    }

    fn grid(&self, exact: bool) -> Grid {
        match (self.interpolation, self.route) {
            (Interpolation::Nearest, Route::Affine) if !exact => Grid::AccumulatedWhole,
            (Interpolation::Nearest, _) => Grid::Whole,
            (Interpolation::Bicubic(_), _) | (_, Route::Exact) => Grid::Exact,
            (Interpolation::Bilinear, _) if exact => Grid::Exact,
            (_, Route::Affine) => Grid::Accumulated,
            (_, Route::Map) => Grid::Thirtyseconds,
        }
    }

    /// Whether every pixel is the same with and without `antialias`, whatever the map.
    pub fn is_plain(&self) -> bool {
        !self.antialias || self.interpolation == Interpolation::Nearest
    }
}

/// Fills `out`, packed pixels in rows of `width`, with the picture as it is seen at `map`. `border` is the colour
/// outside, one element a channel.
///
/// Answers `false`, with `out` as it was, where the map minifies and this needs what only a front end can
/// do: another kind of element, or a blend of the filtered picture with another.
///
/// # Errors
/// [`Error::Value`] for sizes that do not fit or a matrix that is not finite where it minifies.
///
/// ```
/// use multum::compat::cv2::{Rows, read::{Manner, Route, read}};
/// use multum::warp::remap::Map;
/// let picture = Rows::new(&[10u8, 20, 30], 3, 1, 1, 3)?;
/// let manner = Manner::new(1, 1, Route::Map, false)?;
/// let mut out = [0; 2];
/// assert!(read(&picture, &Map::Single(&[0.5, 9.0], &[0.0; 2]), &manner, &[0], 2, &mut out)?);
/// assert_eq!(out, [15, 30]);
/// # Ok::<(), multum::Error>(())
/// ```
pub fn read<T: Pixel>(
    source: &Rows<'_, T>,
    map: &Map<'_>,
    manner: &Manner,
    border: &[T],
    width: usize,
    out: &mut [T],
) -> Result<bool> {
    let channels = source.channels;
    if width == 0 || !out.len().is_multiple_of(width * channels) {
        return Err(Error::value(
            "dst",
            format!("{} elements", out.len()),
            format!("rows of {width} pixels"),
        ));
    }
    let height = out.len() / (width * channels);
    if !manner.is_plain() && map.minifies(width, height)? {
        let (Interpolation::Bilinear, Some(edge)) = (manner.interpolation, manner.edge) else {
            return Ok(false);
        };
        let Some(mapping) = mapping(map) else { return Ok(false) };
        let options = WarpOptions {
            wrap: [wrap(edge); 2],
            border: border.iter().map(|&b| crate::kernel::remap::Real::wide(b.get())).collect(),
            ..WarpOptions::default()
        };
        // What the filters do where the map magnifies is this interpolation.
        return match T::filtered(source, &mapping, [width, height], &options, out) {
            None => Ok(false),
            Some(done) => done.map(|()| true),
        };
    }
    // Fixed-point maps are read by the older code.
    let exact = T::LINEAR_IS_EXACT && matches!(channels, 1 | 3 | 4) && !matches!(map, Map::Fixed(..));
    let grid = manner.grid(exact);
    let outside = match (manner.edge, grid, manner.interpolation) {
        (Some(_), ..) => Outside::Colour,
        (None, _, Interpolation::Nearest) => Outside::Keep,
        (None, Grid::Exact, _) => Outside::Previous,
        (None, ..) => Outside::Keep,
    };
    let picture = Source::new(source.data, source.width, source.height, channels, source.stride)?;
    let edge = manner.edge.unwrap_or(Edge::Border);
    let job = Job::new(picture, manner.interpolation, [edge; 2], border, outside)?;
    interpolate(&job, map, grid, width, out)?;
    Ok(true)
}

fn wrap(edge: Edge) -> Wrap {
    match edge {
        Edge::Border => Wrap::Border,
        Edge::Clamp => Wrap::Clamp,
        Edge::Repeat => Wrap::Repeat,
        Edge::Mirror => Wrap::Mirror,
        Edge::MirrorOnce => Wrap::MirrorOnce,
        Edge::Mirror101 => Wrap::Mirror101,
    }
}

/// The map with its derivatives; none for fixed-point maps.
fn mapping<'a>(map: &Map<'a>) -> Option<Mapping<'a>> {
    let period = [None; 2];
    Some(match *map {
        Map::Single(x, y) => Mapping::Single(Maps { x, y, step: 1, period }),
        Map::Double(x, y) => Mapping::Double(Maps { x, y, step: 1, period }),
        Map::SinglePairs(xy) => Mapping::Single(Maps::pairs(xy, period)),
        Map::DoublePairs(xy) => Mapping::Double(Maps::pairs(xy, period)),
        Map::Matrix(&[a, b, c, d, e, f, g, h, i]) => Mapping::from_matrix([[a, b, c], [d, e, f], [g, h, i]]),
        Map::Fixed(..) => return None,
    })
}

/// The inverse of an affine matrix (two rows of three); a singular one gives zeros, as in OpenCV.
pub fn affine_inverse([a, b, c, d, e, f]: [f64; 6]) -> [f64; 6] {
    let det = a * e - b * d;
    let scale = if det == 0.0 { 0.0 } else { 1.0 / det };
    let (p, q, r, s) = (e * scale, -b * scale, -d * scale, a * scale);
    [p, q, -p * c - q * f, r, s, -r * c - s * f]
}

/// The inverse of a 3x3 matrix, row by row; a singular one gives zeros, as in OpenCV.
pub fn projective_inverse([a, b, c, d, e, f, g, h, i]: [f64; 9]) -> [f64; 9] {
    let adjugate = [
        e * i - f * h,
        c * h - b * i,
        b * f - c * e,
        f * g - d * i,
        a * i - c * g,
        c * d - a * f,
        d * h - e * g,
        b * g - a * h,
        a * e - b * d,
    ];
    let det = a * adjugate[0] + b * adjugate[3] + c * adjugate[6];
    if det == 0.0 { [0.0; 9] } else { adjugate.map(|v| v / det) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverses_undo_and_singular_matrices_give_zeros() {
        let m = [0.8, -0.3, 6.0, 0.3, 0.8, -2.0, 1e-3, 2e-3, 1.0];
        let back = projective_inverse(m);
        for row in 0..3 {
            for column in 0..3 {
                let sum: f64 = (0..3).map(|k| m[3 * row + k] * back[3 * k + column]).sum();
                assert!((sum - f64::from(row == column)).abs() < 1e-12);
            }
        }
        let [p, q, x, r, s, y] = affine_inverse([0.8, -0.3, 6.0, 0.3, 0.8, -2.0]);
        assert!((p * 6.0 - q * 2.0 + x).abs() < 1e-12 && (r * 6.0 - s * 2.0 + y).abs() < 1e-12);
        assert_eq!(affine_inverse([1.0, 2.0, 3.0, 2.0, 4.0, 5.0]), [0.0; 6]);
        assert_eq!(projective_inverse([0.0; 9]), [0.0; 9]);
    }

    #[test]
    fn what_needs_a_front_end_is_left_alone() {
        let data = [0i16; 64];
        let picture = Rows::new(&data, 8, 8, 1, 8).unwrap();
        let third = [3.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 1.0];
        let mut out = [7; 4];
        for (interpolation, border) in [(1, 1), (2, 1), (1, 5)] {
            let manner = Manner::new(interpolation, border, Route::Affine, true).unwrap();
            assert!(!read(&picture, &Map::Matrix(&third), &manner, &[0], 2, &mut out).unwrap());
            assert_eq!(out, [7; 4]);
        }
        assert!(Manner::new(5, 0, Route::Map, true).is_err());
        assert!(Manner::new(1, 6, Route::Map, true).is_err());
    }
}
