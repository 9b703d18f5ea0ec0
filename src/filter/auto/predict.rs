//! Which method will do, by what is known of the texture around a footprint.
//!
//! [`crate::detail`] tells for each level the variance `V` of what it and the levels below have that the next has not.
//! With the footprint's sides, perimeter `P` and area `A` in texels of level 0, and squared errors as found on noise,
//! photographs and edges:
//!
//! ```text
//! trilinear at lambda                  .26 V(lambda)
//! soft parallelogram on level l >= 1   C^2 V(l - 1)/4 8^l P/A^2
//! soft parallelogram on level 0        V(0) times the square of what crate::filter::area tells
//! ```
//!
//! The level is the coarsest whose error is below the target, as a number with a fraction. All of this is continuous in the
//! place and in the footprint.

use super::shape::Shape;
use crate::detail::LEVELS;
use crate::filter::{Query, Reader};
use crate::lod;
use crate::num::{Real, log2};
use crate::texel::Texel;
use crate::texture::Decode;
use crate::wrap::Wrap;

/// Error that is aimed at, as a share of full scale: a step of 8 bits.
pub(super) const TARGET: f64 = 1.0 / 255.0;
/// Trilinear's constant.
const TRILINEAR: f32 = 0.26;
/// Octaves below that level, at most: 28 texels in the smaller height, whatever the contrast, so that what a pixel costs is
/// bounded where numbers are large. The contrast of 8 bits never asks for as much.
const FINER: f32 = 3.5;

/// How a footprint is to be read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Choice {
    /// Level of detail of the trilinear look-up.
    pub smooth: f32,
    /// Share of the soft or exact mean; the rest is the look-up's.
    pub share: f32,
    /// Level of that mean, with a fraction.
    pub level: f32,
    /// Up to which share of the contrast soft weights on level 0 may err.
    pub trusted: f64,
}

/// The choice for one footprint; `None` where it has no extent that could be judged. `ease` multiplies the target: the
/// mean of n parts of a pixel, each with an error of its own, has the root of n less.
#[inline(always)]
pub(super) fn choose<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    query: &Query,
    shape: &Shape,
    ease: f64,
) -> Option<Choice> {
    let detail = r.layers.detail?;
    if shape.room.is_nan() {
        return None;
    }
    let unit = r.decode.outside([1.0; 4])[0].to_f64();
    let target = (TARGET * unit * ease) as f32;
    let last = r.last_level();

    let smooth = lod::clamp(shape.smooth, last);
    let mut variance = [0.0; LEVELS];
    detail.around(smooth, place(r, query), &mut variance);
    let (whole, fraction) = lod::split(smooth);
    let (fine, coarse) = (variance[whole], variance[whole + 1]);
    let error = TRILINEAR * (fine + fraction * (coarse - fine)) / (target * target);
    // None up to a quarter of the target's square, all from the whole on.
    let x = ((error - 0.25) / 0.75).clamp(0.0, 1.0);
    let share = x * x * (3.0 - 2.0 * x);
    if share == 0.0 {
        return Some(Choice { smooth, share, level: 0.0, trusted: 0.0 });
    }

    let most = lod::clamp(shape.most, last).min(smooth);
    let level = if most > 0.0 {
        // Level l will do where log2 V(l - 1) + 3 l is below this.
        let enough = shape.room + 2.0 * log2(target);
        coarsest(&variance, enough, shape.sure, most).max(shape.sure - FINER).min(most)
    } else {
        0.0
    };
    let contrast = variance[0].sqrt();
    let trusted = f64::from(target / contrast.max(1e-30));
    Some(Choice { smooth, share, level, trusted })
}

/// The largest level up to `most` whose error is low enough; between whole levels the logarithm is taken as linear. Beyond
/// `sure` texels are as wide as the footprint, and what they show is blurred across as well as what they do not.
#[inline(always)]
fn coarsest(variance: &[f32; LEVELS], enough: f32, sure: f32, most: f32) -> f32 {
    let need = |level: usize| {
        let wide = (level as f32 - sure).clamp(0.0, 1.0);
        let own = if wide > 0.0 { 4.0 * wide * variance[level] } else { 0.0 };
        log2((variance[level - 1] + own).max(1e-30)) + 3.0 * level as f32
    };
    let (whole, fraction) = lod::split(most);
    let mut level = whole + usize::from(fraction > 0.0);
    if level == 0 {
        return 0.0;
    }
    let mut above = need(level);
    if above <= enough {
        return most;
    }
    while level > 1 {
        let below = need(level - 1);
        if below <= enough {
            let part = (enough - below) / (above - below);
            return most.min((level - 1) as f32 + part);
        }
        (level, above) = (level - 1, below);
    }
    // Level 0 has no such error; as if it were an octave of the finest less.
    most.min(((enough - above) / 3.0 + 1.0).max(0.0))
}

/// Where the footprint's centre lies within the texture.
#[inline(always)]
fn place<T: Texel, D: Decode<T>>(r: &Reader<'_, T, D>, query: &Query) -> [f64; 2] {
    let plane = &r.layers.planes[0];
    let along = |axis: usize, x: f64, n: f64| {
        let wrap = r.layers.wrap[axis];
        // Only this mode turns within the first period.
        if x >= 0.0 && x <= n && wrap != Wrap::Mirror101 {
            x
        } else {
            wrap.reduce(x, n).0.clamp(-1.0, n + 1.0)
        }
    };
    [along(0, query.s, plane.width.into()), along(1, query.t, plane.height.into())]
}
