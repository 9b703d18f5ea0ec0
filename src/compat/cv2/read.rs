//! Reading a picture at the places of a map or a matrix: which arithmetic OpenCV's flags stand for.
//!
//! | interpolation | positions |
//! |---|---|
//! | nearest | whole pixels; those of affine warps by way of 1/1024 pixel |
//! | linear | exact for `u8`, `u16` and `f32` of 1, 3 or 4 channels; else multiples of 1/32 pixel |
//! | cubic | exact |
//! | Lanczos | multiples of 1/32 pixel |

use super::Rows;
use super::antialias::{Plan, Seen};
use crate::error::{Error, Result};
use crate::image::{Element, Image, View, zeros};
use crate::kernel::remap::Sample;
use crate::texture::{Texture, TextureOptions};
use crate::warp::remap::{Edge, Grid, Interpolation, Job, Map, Outside, Source, interpolate};
use crate::wrap::Wrap;
use half::f16;

/// An element that OpenCV's warps take.
pub trait Pixel: Sample {
    /// Whether linear interpolation is exact in 1, 3 and 4 channels.
    const LINEAR_IS_EXACT: bool;
    /// What 1 stands for in results of filters.
    const FULL_SCALE: f64;
    /// What filters take it for.
    type Code: Element;
    /// The picture as a texture.
    ///
    /// # Errors
    /// [`Error::Value`] where options do not fit or memory is short.
    fn texture<'a>(source: &Rows<'a, Self>, options: TextureOptions) -> Result<Texture<'a>>;
    /// The element for what a filter gave.
    fn of_code(code: Self::Code) -> Self;
}

macro_rules! pixel {
    ($($t:ty, $exact:literal, $full:expr;)+) => {$(
        impl Pixel for $t {
            const LINEAR_IS_EXACT: bool = $exact;
            const FULL_SCALE: f64 = $full;
            type Code = Self;
            fn texture<'a>(source: &Rows<'a, Self>, options: TextureOptions) -> Result<Texture<'a>> {
                let view = View::new(source.data, source.width, source.height, source.channels, source.stride);
                Texture::borrowed(view?.into(), options)
            }
            fn of_code(code: Self) -> Self {
                code
            }
        }
    )+};
}
pixel! { u8, true, 255.0; u16, true, 65_535.0; f16, false, 1.0; f32, true, 1.0; f64, false, 1.0; }

/// The filters do not know the type: its numbers are filtered as singles.
impl Pixel for i16 {
    const LINEAR_IS_EXACT: bool = false;
    const FULL_SCALE: f64 = 1.0;
    type Code = f32;
    fn texture<'a>(source: &Rows<'a, Self>, options: TextureOptions) -> Result<Texture<'a>> {
        let row = source.width * source.channels;
        let mut numbers = zeros::<f32>("src", row * source.height)?;
        for (y, numbers) in numbers.chunks_exact_mut(row).enumerate() {
            for (number, &element) in numbers.iter_mut().zip(source.row(y)) {
                *number = f32::from(element);
            }
        }
        let image = Image::new(source.width, source.height, source.channels, numbers)?;
        Texture::new(image.view(), options)
    }
    fn of_code(code: f32) -> Self {
        Self::put(code)
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

    fn seen<'a, T>(&self, source: &'a Rows<'a, T>, border: &'a [T]) -> Seen<'a, T> {
        Seen { source, wrap: self.edge.map(wrap), border, interpolation: self.interpolation }
    }

    /// Whether every pixel is the same with and without `antialias`, whatever the map.
    pub fn is_plain(&self) -> bool {
        !self.antialias || self.interpolation == Interpolation::Nearest
    }
}

/// Fills `out`, packed pixels in rows of `width`, with the picture as it is seen at `map`. `border` is the colour
/// outside, one element a channel.
///
/// # Errors
/// [`Error::Value`] for sizes that do not fit; [`Error::Interrupted`].
///
/// ```
/// use multum::compat::cv2::{Rows, read::{Manner, Route, read}};
/// use multum::warp::remap::Map;
/// let picture = Rows::new(&[10u8, 20, 30], 3, 1, 1, 3)?;
/// let manner = Manner::new(1, 1, Route::Map, false)?;
/// let mut out = [0; 2];
/// read(&picture, &Map::Single(&[0.5, 9.0], &[0.0; 2]), &manner, &[0], 2, &mut out)?;
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
) -> Result<()> {
    let channels = source.channels;
    if width == 0 || !out.len().is_multiple_of(width * channels) {
        return Err(Error::value(
            "dst",
            format!("{} elements", out.len()),
            format!("rows of {width} pixels"),
        ));
    }
    let height = out.len() / (width * channels);
    let plan = if manner.is_plain() { None } else { Plan::new(map, width, height)? };
    let mut held = Vec::new();
    if plan.is_some() && manner.edge.is_none() {
        held = zeros("dst", out.len())?;
        held.copy_from_slice(out);
    }
    interpolated(source, map, manner, border, width, out)?;
    match plan {
        None => Ok(()),
        Some(plan) => plan.filter(&manner.seen(source, border), &held, out),
    }
}

/// Puts the means over what pixels cover at `map` into `out`, which is interpolated at positions near those, where the
/// manner has a border that hides what was there before.
pub(super) fn average<T: Pixel>(
    source: &Rows<'_, T>,
    map: &Map<'_>,
    manner: &Manner,
    border: &[T],
    width: usize,
    out: &mut [T],
) -> Result<()> {
    match Plan::new(map, width, out.len() / (width * source.channels))? {
        None => Ok(()),
        Some(plan) => plan.filter(&manner.seen(source, border), &[], out),
    }
}

/// [`read`] without filters.
fn interpolated<T: Pixel>(
    source: &Rows<'_, T>,
    map: &Map<'_>,
    manner: &Manner,
    border: &[T],
    width: usize,
    out: &mut [T],
) -> Result<()> {
    let channels = source.channels;
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
    interpolate(&job, map, grid, width, out)
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

    /// A chirp of waves, seen by a map that magnifies on the left and minifies on the right.
    fn bent(width: usize, height: usize) -> (Vec<f32>, Vec<f32>) {
        let x = |i: usize| 0.5 * i as f32 + 0.01 * (i * i) as f32;
        (0..width * height).map(|i| (x(i % width), (i / width) as f32)).unzip()
    }

    #[test]
    fn only_pixels_that_minify_are_filtered_whatever_the_kind_and_the_border() {
        let (w, h) = (512, 16);
        // Squares: neighbours differ by any number.
        let data: Vec<i16> = (0..w * h).map(|i| ((i * i * 31 + i * 7919) % 2003) as i16).collect();
        let doubles: Vec<f64> = data.iter().map(|&v| f64::from(v)).collect();
        let (x, y) = bent(200, h);
        let map = Map::Single(&x, &y);
        for (interpolation, border) in [(1, 1), (2, 1), (4, 0), (1, 5), (2, 5)] {
            let run = |antialias| {
                let manner = Manner::new(interpolation, border, Route::Map, antialias).unwrap();
                let (mut short, mut long) = (vec![77i16; 200 * h], vec![77.0; 200 * h]);
                let source = Rows::new(&data, w, h, 1, w).unwrap();
                read(&source, &map, &manner, &[5], 200, &mut short).unwrap();
                let source = Rows::new(&doubles, w, h, 1, w).unwrap();
                read(&source, &map, &manner, &[5.0], 200, &mut long).unwrap();
                (short, long)
            };
            let ((plain, plain_long), (mean, mean_long)) = (run(false), run(true));
            for (i, column) in (0..plain.len()).map(|i| (i, i % 200)) {
                // dx is 0.5 + 0.02 i.
                if column < 24 {
                    assert_eq!((mean[i], mean_long[i]), (plain[i], plain_long[i]), "{column}");
                }
                // Types agree, where the interpolation rounds positions alike for them.
                assert!((f64::from(mean[i]) - mean_long[i]).abs() < 1.5, "{interpolation} {border} {column}");
            }
            let changed = (40..200).filter(|&i| mean[5 * 200 + i] != plain[5 * 200 + i]).count();
            assert!(changed > 140, "{interpolation} {border}: {changed}");
            // Means of noise: its variance is smaller where more is covered.
            let spread = |v: &[f64]| {
                let part: Vec<f64> = (0..h).flat_map(|y| v[y * 200 + 150..y * 200 + 195].to_vec()).collect();
                let mean = part.iter().sum::<f64>() / part.len() as f64;
                part.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / part.len() as f64
            };
            assert!(spread(&mean_long) < 0.6 * spread(&plain_long), "{interpolation} {border}");
        }
        assert!(Manner::new(5, 0, Route::Map, true).is_err());
        assert!(Manner::new(1, 6, Route::Map, true).is_err());
    }

    #[test]
    fn nothing_jumps_where_a_scale_passes_from_magnifying_to_minifying() {
        let (w, h) = (64, 8);
        // Lines, one in three columns.
        let data: Vec<f64> = (0..w * h).map(|i| if i % w % 3 == 0 { 997.0 } else { 0.0 }).collect();
        let source = Rows::new(&data, w, h, 1, w).unwrap();
        for interpolation in [1, 2, 4] {
            let manner = Manner::new(interpolation, 1, Route::Exact, true).unwrap();
            let at = |scale: f64| {
                // About the middle, which is read at the same place for every scale.
                let m = [scale, 0.0, 32.3 - 16.0 * scale, 0.0, 1.0, 3.4, 0.0, 0.0, 1.0];
                let mut out = vec![0.0; 33];
                read(&source, &Map::Matrix(&m), &manner, &[0.0], 33, &mut out).unwrap();
                out[16]
            };
            let values: Vec<f64> = (0..=800).map(|i| at(0.9 + 0.001 * f64::from(i))).collect();
            // The share of the mean rises by at most 1.5 / 0.25 of a step, and the mean itself with its width.
            let most = values.windows(2).map(|v| (v[1] - v[0]).abs()).fold(0.0, f64::max);
            assert!(most < 997.0 * 0.001 * (6.0 + 1.0), "{interpolation}: {most}");
            assert_eq!(values[0], values[90]);
            assert!((values[800] - values[0]).abs() > 10.0);
        }
    }
}
