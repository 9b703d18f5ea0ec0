//! Which method will do, by what is known of the texture around a footprint.
//!
//! [`crate::detail`] tells for each level the variance `V` of what it and the levels below have that the next has not.
//! With the footprint's sides, perimeter `P` and area `A` in texels of level 0, and squared errors as found on noise,
//! photographs and edges:
//!
//! ```text
//! trilinear at lambda                  .26 V(lambda)
//! soft parallelogram on level l >= 1   C^2 V(l - 1)/4 8^l P/A^2
//! soft parallelogram on level 0        ((.03 + .42 rho)/A)^2 V(0)        rho: cosine between the sides
//! ```
//!
//! The level is the coarsest whose error is below the target, as a number with a fraction; what stands along a long
//! footprint is looked at in three places. All of this is continuous in the place and in the footprint.

use crate::detail::Detail;
use crate::filter::{Query, Reader};
use crate::lod;
use crate::num::{Real, log2};
use crate::texel::Texel;
use crate::texture::Decode;

/// Error that is aimed at, as a share of full scale: a step of 8 bits.
pub(super) const TARGET: f64 = 1.0 / 255.0;
/// Square of the soft parallelogram's constant: .26 on noise, .5 on pictures with as much contrast in every octave, .8 on
/// edges.
const SOFT: f32 = 0.36;
/// Trilinear's constant.
const TRILINEAR: f32 = 0.26;
/// Texels in the smaller height, on the coarsest level that is read by soft weights.
const LEAST_HEIGHT: f64 = 2.5;
/// Octaves beyond, for long footprints.
const MORE: f32 = 1.3;
/// Longest footprint, in widths; see [`crate::filter::area`].
const LONGEST: f64 = 512.0;

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
    ease: f64,
) -> Option<Choice> {
    let detail = r.layers.detail?;
    let [[a, b], [c, d]] = query.jacobian_tx.m;
    let squares = [a * a + c * c, b * b + d * d];
    if !(squares[0] + squares[1]).is_finite() {
        return None;
    }
    let lengths = squares.map(f64::sqrt);
    let longest = lengths[0].max(lengths[1]);
    let height = (query.jacobian_tx.det().abs() / longest).max(longest / LONGEST);
    let unit = r.decode.outside([1.0; 4])[0].to_f64();
    let target = (TARGET * unit * ease) as f32;
    let last = r.last_level();
    let near = Near::new(r, detail, query);

    // The longest axis in place of the ellipse's: never too short, and no root of a root.
    let smooth = lod::clamp(log2(query.jacobian_tx.sigma1() as f32), last);
    let (whole, fraction) = lod::split(smooth);
    let (fine, coarse) = (near.variance(whole), near.variance(whole + 1));
    let error = TRILINEAR * (fine + fraction * (coarse - fine)) / (target * target);
    // None up to a quarter of the target's square, all from the whole on.
    let x = ((error - 0.25) / 0.75).clamp(0.0, 1.0);
    let share = x * x * (3.0 - 2.0 * x);
    if share == 0.0 {
        return Some(Choice { smooth, share, level: 0.0, trusted: 0.0 });
    }

    let area = (height * longest) as f32;
    let perimeter = 2.0 * (lengths[0] + lengths[1]) as f32;
    // Level l will do where log2 V(l - 1) + 3 l is below this.
    let enough = log2(4.0 * target * target * area * area / (SOFT * perimeter));
    let sure = log2((height / LEAST_HEIGHT) as f32);
    // The longer a footprint is the more of its error averages out along it.
    let octaves = (0.5 * log2((longest / height) as f32)).clamp(0.0, MORE);
    let level = coarsest(&near, enough, sure, lod::clamp(sure + octaves, last));
    let contrast = near.variance(0).sqrt();
    let trusted = f64::from(target / contrast.max(1e-30));
    Some(Choice { smooth, share, level, trusted })
}

/// The largest level up to `most` whose error is low enough; between whole levels the logarithm is taken as linear. Beyond
/// `sure` texels are as wide as the footprint, and what they show is blurred across as well as what they do not.
#[inline(always)]
fn coarsest<T: Texel, D: Decode<T>>(near: &Near<'_, T, D>, enough: f32, sure: f32, most: f32) -> f32 {
    let need = |level: usize| {
        let wide = (level as f32 - sure).clamp(0.0, 1.0);
        let own = if wide > 0.0 { 4.0 * wide * near.variance(level) } else { 0.0 };
        log2((near.variance(level - 1) + own).max(1e-30)) + 3.0 * level as f32
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

/// Where the table is looked at: along the longer side, in three places.
struct Near<'a, T: Texel, D> {
    r: &'a Reader<'a, T, D>,
    detail: &'a Detail,
    places: [[f64; 2]; 3],
}

impl<'a, T: Texel, D: Decode<T>> Near<'a, T, D> {
    #[inline(always)]
    fn new(r: &'a Reader<'a, T, D>, detail: &'a Detail, query: &Query) -> Self {
        // Nothing along a round footprint, whose major axis may point anywhere.
        let axes = query.jacobian_tx.axes();
        let step = axes.major.map(|m| m * 0.35 * (axes.sigma1 - axes.sigma2));
        let places = [-1.0, 0.0, 1.0].map(|k| {
            let at = |axis: usize, x: f64| {
                let plane = &r.layers.planes[0];
                let n = f64::from([plane.width, plane.height][axis]);
                r.layers.wrap[axis].reduce(x, n).0.clamp(-1.0, n + 1.0)
            };
            [at(0, query.s + k * step[0]), at(1, query.t + k * step[1])]
        });
        Self { r, detail, places }
    }

    #[inline(always)]
    fn variance(&self, level: usize) -> f32 {
        let level = level.min(self.r.last_level());
        let [p, q, o] = self.places.map(|[s, t]| self.detail.at(level, s, t));
        0.25 * (p + o) + 0.5 * q
    }
}
