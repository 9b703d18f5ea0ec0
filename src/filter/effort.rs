//! What a filter spends on a pixel: how many texels and table entries it looks at, and on which level.
//!
//! Counts are those of the formulas at the head of each filter; a mean over a footprint of area `A` and perimeter `P`, in
//! texels of the level, looks at about `A + P + 4` texels. `auto` reports its own decisions.

use super::{Filter, Query, Reader, auto};
use crate::lod;
use crate::num::log2;
use crate::texel::Texel;
use crate::texture::Decode;

/// Look-ups, and the level of detail that they are made on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effort {
    /// Texels and entries of tables that are looked at.
    pub cost: f32,
    /// The level, with a fraction between two.
    pub lod: f32,
}

impl Effort {
    pub(super) fn new(cost: f64, lod: f32) -> Self {
        Self { cost: cost as f32, lod }
    }
}

/// Texels under a footprint on a level.
pub(super) fn under(query: &Query, level: f32) -> f64 {
    let scale = f64::from(-level).exp2();
    let [[a, b], [c, d]] = query.jacobian_tx.scaled(scale, scale).m;
    (a * d - b * c).abs() + 2.0 * (a.hypot(c) + b.hypot(d)) + 4.0
}

/// What `filter` spends on a footprint whose level of detail, for the filters that have one, is `detail`.
pub(crate) fn effort<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    filter: Filter,
    query: &Query,
    detail: f32,
    max_anisotropy: f64,
    tolerance: Option<f64>,
    ease: f64,
) -> Effort {
    let last = r.last_level();
    let level = lod::clamp(detail, last);
    let levels = if lod::split(level).1 > 0.0 { 2.0 } else { 1.0 };
    let axes = query.jacobian_tx.axes();
    match filter {
        Filter::Nearest | Filter::Stochastic => Effort::new(1.0, 0.0),
        Filter::Bilinear => Effort::new(4.0, 0.0),
        Filter::Bicubic | Filter::Mitchell => Effort::new(16.0, 0.0),
        Filter::NearestMipmapNearest => Effort::new(1.0, lod::nearest(level) as f32),
        Filter::LinearMipmapNearest => Effort::new(4.0, lod::nearest(level) as f32),
        Filter::NearestMipmapLinear => Effort::new(levels, level),
        Filter::Trilinear => Effort::new(4.0 * levels, level),
        Filter::Anisotropic => {
            let width = axes.sigma2.max(axes.sigma1 / max_anisotropy.min(1024.0));
            let ratio = if axes.sigma1 > 1.0 && width > 0.0 { axes.sigma1 / width } else { 1.0 };
            let probes = 2.0 * ((ratio - 1.0) / 2.0).ceil().max(0.0) + 1.0;
            let level = lod::clamp(log2(width as f32), last);
            let levels = if lod::split(level).1 > 0.0 { 2.0 } else { 1.0 };
            Effort::new(4.0 * levels * probes, level)
        }
        Filter::Sat => Effort::new(16.0, 0.0),
        Filter::Exact => Effort::new(under(query, 0.0), 0.0),
        Filter::Area | Filter::Ewa => {
            let longest = axes.sigma1;
            let height = (axes.sigma2).max(longest / 512.0);
            let level = lod::clamp(log2((height / 3.0) as f32), last);
            Effort::new(under(query, level.floor()), level)
        }
        Filter::Auto => match tolerance {
            Some(tolerance) => auto::effort_within(r, query, tolerance),
            None => auto::effort(r, query, ease),
        },
    }
}
