//! `resize`: which pixels, and which arithmetic, its flags stand for.

use super::Rows;
use super::area::area;
use super::pyramid::Element;
use super::read::Pixel;
use super::separable::{Axis, Kernel, stretch};
use crate::error::{Error, Result};
use crate::filter::mean_share;
use crate::kernel::remap::Real;
use crate::par;

/// Elements of output that a thread takes at a time, about.
const BAND: usize = 1 << 16;

/// Sizes of a call: those of the result, and how many pixels of the source each of its pixels stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scaling {
    /// Width and height of the result.
    pub size: [usize; 2],
    /// Along x and y.
    pub scale: [f64; 2],
    /// Their inverses, rounded each by itself.
    factor: [f64; 2],
}

/// A kind of `resize` that copies pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Nearest {
    /// Pixel `floor(i scale)`.
    Corner,
    /// The pixel under the centre; of two that meet there the second.
    Center,
}

impl Scaling {
    /// To `size` (width, height), or by factors where that is `None`.
    ///
    /// # Errors
    /// [`Error::Value`] for a side or a factor that is not positive, or a side over 2^30.
    pub fn new(from: [usize; 2], size: Option<[i64; 2]>, factors: [f64; 2]) -> Result<Self> {
        const MOST: i64 = 1 << 30;
        let Some(size) = size else {
            let sides = [0, 1].map(|k| (from[k] as f64 * factors[k]).round_ties_even());
            if !sides.iter().all(|n| (1.0..=MOST as f64).contains(n)) {
                let expected = "dsize, or factors that give a side of 1 to 2^30 pixels";
                return Err(Error::value("fx, fy", format!("{factors:?}"), expected));
            }
            let scale = factors.map(|f| 1.0 / f);
            return Ok(Self { size: sides.map(|n| n as usize), scale, factor: factors });
        };
        if !size.iter().all(|n| (1..=MOST).contains(n)) {
            return Err(Error::value("dsize", format!("{size:?}"), "a pair (width, height) of 1 to 2^30"));
        }
        let size = size.map(|n| n as usize);
        let scale = [0, 1].map(|k| from[k] as f64 / size[k] as f64);
        Ok(Self { size, scale, factor: [0, 1].map(|k| size[k] as f64 / from[k] as f64) })
    }

    /// Whether pixels are averaged by area: `INTER_AREA` of smaller sides, and `INTER_LINEAR` by exactly 2.
    pub fn averages(&self, interpolation: i32) -> bool {
        let [sx, sy] = self.scale;
        match interpolation {
            3 => sx >= 1.0 && sy >= 1.0 && sx * sy > 1.0,
            1 => sx == 2.0 && sy == 2.0,
            _ => false,
        }
    }
}

/// The source's pixel for each of `m` pixels of an axis of `n`.
fn picked(n: usize, m: usize, factor: f64, nearest: Nearest) -> Vec<usize> {
    // The factor is rounded before its inverse is taken, as OpenCV does.
    let scale = 1.0 / factor;
    match nearest {
        Nearest::Corner => (0..m).map(|i| ((i as f64 * scale).floor() as usize).min(n - 1)).collect(),
        Nearest::Center => {
            let under = |i: usize| (2 * i as u128 + 1) * n as u128 / (2 * m as u128);
            (0..m).map(|i| (under(i) as usize).min(n - 1)).collect()
        }
    }
}

/// Copies pixels of any kind.
///
/// # Errors
/// [`Error::Value`] for an `out` of another size; [`Error::Interrupted`].
///
/// ```
/// use multum::compat::cv2::{Rows, resize::{Nearest, Scaling, pick}};
/// let picture = Rows::new(&[1u8, 2, 3], 3, 1, 1, 3)?;
/// let mut out = [0; 6];
/// pick(&picture, &Scaling::new([3, 1], Some([6, 1]), [0.0; 2])?, Nearest::Corner, &mut out)?;
/// assert_eq!(out, [1, 1, 2, 2, 3, 3]);
/// # Ok::<(), multum::Error>(())
/// ```
pub fn pick<T: Copy + Send + Sync>(
    source: &Rows<'_, T>,
    to: &Scaling,
    nearest: Nearest,
    out: &mut [T],
) -> Result<()> {
    let ([width, height], channels) = (to.size, source.channels);
    let len = width.checked_mul(height).and_then(|n| n.checked_mul(channels));
    if len != Some(out.len()) || out.is_empty() {
        return Err(Error::value("dst", format!("{} elements", out.len()), format!("{width} x {height}")));
    }
    let columns = picked(source.width, width, to.factor[0], nearest);
    let rows = picked(source.height, height, to.factor[1], nearest);
    let row = width * channels;
    let work = |first: usize, out: &mut [T]| {
        for (y, out) in out.chunks_exact_mut(row).enumerate() {
            let from = source.row(rows[first + y]);
            macro_rules! fixed {
                ($n:literal) => {{
                    let from = from.as_chunks::<$n>().0;
                    for (out, &x) in out.as_chunks_mut::<$n>().0.iter_mut().zip(&columns) {
                        *out = from[x];
                    }
                }};
            }
            match channels {
                1 => fixed!(1),
                2 => fixed!(2),
                3 => fixed!(3),
                4 => fixed!(4),
                _ => {
                    for (out, &x) in out.chunks_exact_mut(channels).zip(&columns) {
                        out.copy_from_slice(&from[x * channels..(x + 1) * channels]);
                    }
                }
            }
        }
    };
    let bands = (BAND / row).max(1);
    par::for_each(out.chunks_mut(bands * row), |i, tile| {
        work(i * bands, tile);
        Ok(())
    })
}

/// Positions along an axis of `n` pixels where `INTER_AREA` enlarges: each pixel keeps its colour but near its edges.
fn enlarged(n: usize, factor: f64) -> impl Fn(usize) -> f64 {
    let scale = 1.0 / factor;
    move |i| {
        let whole = (i as f64 * scale).floor();
        // A single, as there: what is whole but for a last bit counts as whole.
        let rest = ((i + 1) as f64 - (whole + 1.0) * factor) as f32;
        let rest = if rest <= 0.0 { 0.0 } else { rest - rest.floor() };
        (whole + f64::from(rest)).clamp(0.0, (n - 1) as f64)
    }
}

/// Fills `out` with the picture in another size, by any interpolation but the two nearest ones. With `antialias`,
/// pixels that stand for more than one of the source along either axis are the mean over what they cover, into which the
/// interpolation goes over by [`mean_share`].
///
/// # Errors
/// [`Error::Value`] for an unknown interpolation or an `out` of another size; [`Error::Interrupted`].
pub fn resize<T: Pixel + Element>(
    source: &Rows<'_, T>,
    to: &Scaling,
    interpolation: i32,
    antialias: bool,
    out: &mut [T],
) -> Result<()> {
    if to.averages(interpolation) {
        return area(source, to.size, to.scale, out);
    }
    let kernel = match interpolation {
        // The exact linear interpolation is the linear one here.
        1 | 3 | 5 => Kernel::Linear,
        2 => Kernel::Cubic(-0.75),
        4 => Kernel::Lanczos4,
        _ => {
            let expected =
                "INTER_NEAREST, _LINEAR, _CUBIC, _AREA, _LANCZOS4, _LINEAR_EXACT or _NEAREST_EXACT";
            return Err(Error::value("interpolation", interpolation, expected));
        }
    };
    let from = [source.width, source.height];
    let axes = |kernel| -> Result<[Axis<T::Acc>; 2]> {
        let axis = |k: usize| {
            if kernel == Kernel::Linear && interpolation == 3 {
                let at = enlarged(from[k], to.factor[k]);
                return Axis::new(kernel, from[k], to.size[k], 1.0, at);
            }
            Axis::scaled(kernel, from[k], to.size[k], to.scale[k])
        };
        Ok([axis(0)?, axis(1)?])
    };
    let share = if antialias { mean_share(to.scale[0].max(to.scale[1])) } else { 0.0 };
    if share == 1.0 {
        return stretch(source, &axes(Kernel::Mean)?, None, out);
    }
    let plain = axes(kernel)?;
    if share == 0.0 {
        return stretch(source, &plain, None, out);
    }
    let mean = axes(Kernel::Mean)?;
    stretch(source, &plain, Some((&mean, Real::of(share))), out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_given_or_follow_from_factors() {
        let given = Scaling::new([30, 20], Some([10, 40]), [0.0; 2]).unwrap();
        assert_eq!(given.size, [10, 40]);
        assert!((given.scale[0] - 3.0).abs() < 1e-15 && given.scale[1] == 0.5);
        let made = Scaling::new([30, 20], None, [0.5, 2.0]).unwrap();
        assert_eq!((made.size, made.scale), ([15, 40], [2.0, 0.5]));
        for (size, factors) in [
            (None, [0.01, 1.0]),
            (None, [f64::NAN, 1.0]),
            (None, [1e12, 1.0]),
            (None, [-1.0, 1.0]),
            (Some([0, 5]), [1.0; 2]),
            (Some([5, -1]), [1.0; 2]),
            (Some([5, i64::MAX]), [1.0; 2]),
        ] {
            assert!(Scaling::new([30, 20], size, factors).is_err(), "{size:?} {factors:?}");
        }
    }

    #[test]
    fn picked_pixels_stand_under_their_places() {
        assert_eq!(picked(4, 8, 2.0, Nearest::Corner), [0, 0, 1, 1, 2, 2, 3, 3]);
        assert_eq!(picked(4, 2, 0.5, Nearest::Corner), [0, 2]);
        assert_eq!(picked(9, 3, 1.0 / 3.0, Nearest::Center), [1, 4, 7]);
        assert_eq!(picked(1, 3, 3.0, Nearest::Center), [0, 0, 0]);
        assert_eq!(picked(1 << 40, 1, 1.0 / (1u64 << 40) as f64, Nearest::Center), [1 << 39]);
    }

    #[test]
    fn enlarging_by_area_keeps_pixels_but_near_their_edges() {
        let picture = Rows::new(&[0.0f32, 10.0], 2, 1, 1, 2).unwrap();
        let to = Scaling::new([2, 1], Some([5, 1]), [0.0; 2]).unwrap();
        let mut out = [0.0; 5];
        resize(&picture, &to, 3, true, &mut out).unwrap();
        assert!((out[2] - 5.0).abs() < 1e-5 && out[1] == 0.0 && out[3] == 10.0, "{out:?}");
    }
}
