//! Level of detail: which level of the pyramid a footprint asks for.
//!
//! Two rules, both in texels of level 0 per pixel, both 0 where a texel is a pixel and 1 where it is half one:
//!
//! - [`LodRule::Major`]: `lambda = log2(sigma1)`, the length of the footprint's longest axis. This is the
//!   scale factor that OpenGL 4.6, section 8.14.1, approximates from the lengths of the derivative vectors.
//! - [`LodRule::Area`]: `lambda = log2(|det J|)/2`, the level whose texels have the footprint's area `A W H`
//!   (A in texture space): the lectures' `d = log2(A W H)/2`.
//!
//! The major axis is the default: it is the rule of GL, and it never shows more than the truth does when the
//! picture moves. The rules differ by half the log of the footprint's ratio, always downwards: along a
//! footprint's long axis the area rule reads texels that are smaller than the pixel's extent, and what it saves
//! in blur across comes back as aliasing along. In a still picture of a slanted plane that is often the smaller
//! error; moving patterns of high contrast flicker. `docs/lod.md` has the numbers.

use crate::error::{Error, Result};
use crate::jacobian::Jacobian;
use crate::num::log2_of_normal;

/// Which extent of a footprint decides about the level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LodRule {
    /// The longest axis.
    #[default]
    Major,
    /// The square root of the area.
    Area,
}

impl LodRule {
    /// The rule of this name: "major" or "area".
    ///
    /// # Errors
    /// [`Error::Value`] for any other word.
    pub fn parse(name: &str) -> Result<Self> {
        match name {
            "major" => Ok(Self::Major),
            "area" => Ok(Self::Area),
            _ => Err(Error::value("lod_rule", format!("{name:?}"), "\"major\" or \"area\"")),
        }
    }

    /// Level of detail of a Jacobian in texels per pixel. Zero gives minus infinity, entries that are
    /// infinite or no numbers give infinity, which [`clamp`] turns into the coarsest level.
    #[inline(always)]
    pub fn lod(self, jacobian_tx: Jacobian) -> f32 {
        match self {
            Self::Major => level_of(jacobian_tx.sigma1()),
            Self::Area => 0.5 * level_of(jacobian_tx.det().abs()),
        }
    }
}

/// `log2` of an extent in texels: minus infinity for zero, infinity for what is infinite or no number. Without branches, so that
/// a loop over it becomes lanes.
#[inline(always)]
pub(crate) fn level_of(extent_tx: f64) -> f32 {
    let x = extent_tx as f32;
    let normal = if x > f32::MIN_POSITIVE { x } else { f32::MIN_POSITIVE };
    let normal = if normal < f32::MAX { normal } else { f32::MAX };
    let log = log2_of_normal(normal);
    let log = if x > 0.0 { log } else { f32::NEG_INFINITY };
    if x <= f32::MAX { log } else { f32::INFINITY }
}

/// Brings a biased level of detail into `[0, last]`; NaN becomes `last`.
#[inline(always)]
pub fn clamp(lod: f32, last: usize) -> f32 {
    let last = last as f32;
    if lod <= 0.0 {
        0.0
    } else if lod < last {
        lod
    } else {
        last
    }
}

/// The finer of the two levels to blend, and the weight of the coarser.
#[inline(always)]
pub fn split(clamped: f32) -> (usize, f32) {
    // Not negative, so truncation is floor.
    let level = clamped as usize;
    (level, clamped - level as f32)
}

/// The nearest level; halves go down. OpenGL 4.6, section 8.14.3: `ceil(lambda + 1/2) - 1`.
#[inline(always)]
pub fn nearest(clamped: f32) -> usize {
    // Adding the half would round what lies just above it back down.
    let (level, fraction) = split(clamped);
    level + usize::from(fraction > 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identity_is_level_zero_and_halving_level_one() {
        for rule in [LodRule::Major, LodRule::Area] {
            assert_eq!(rule.lod(Jacobian::IDENTITY), 0.0);
            assert_eq!(rule.lod(Jacobian::IDENTITY.scaled(2.0, 2.0)), 1.0);
        }
        let long = Jacobian::IDENTITY.scaled(16.0, 4.0);
        assert_eq!((LodRule::Major.lod(long), LodRule::Area.lod(long)), (4.0, 3.0));
    }

    #[test]
    fn turning_the_footprint_changes_nothing() {
        for i in 0..=90 {
            let (s, c) = f64::from(i).to_radians().sin_cos();
            let lod = LodRule::Major.lod(Jacobian::new([[3.0 * c, -5.0 * s], [3.0 * s, 5.0 * c]]));
            assert!((f64::from(lod) - 5f64.log2()).abs() < 1e-5);
        }
    }

    #[test]
    fn extremes_clamp_to_a_level() {
        let nan = Jacobian::new([[f64::NAN, 0.0], [0.0, 1.0]]);
        assert_eq!(clamp(LodRule::Major.lod(nan), 7), 7.0);
        assert_eq!(clamp(LodRule::Major.lod(Jacobian::ZERO), 7), 0.0);
        assert_eq!(clamp(LodRule::Major.lod(Jacobian::IDENTITY.scaled(1e30, 1e-30)), 7), 7.0);
        assert_eq!(clamp(LodRule::Area.lod(Jacobian::IDENTITY.scaled(f64::INFINITY, 1.0)), 7), 7.0);
    }

    #[test]
    fn halves_go_down() {
        for (lod, level) in
            [(0.0, 0), (0.5, 0), (0.5f32.next_up(), 1), (0.500_001, 1), (1.5, 1), (1.500_001, 2), (2.5, 2)]
        {
            assert_eq!(nearest(lod), level, "{lod}");
        }
    }
}
