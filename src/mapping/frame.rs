//! Axes, and scaling that keeps lengths away from overflow.

use super::Tangents;
use crate::error::{Error, Result};
use glam::DVec3;

/// The axis that a map is built around.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Axis {
    /// (1, 0, 0); the plane across it is (y, z).
    X,
    /// (0, 1, 0); the plane across it is (z, x).
    Y,
    /// (0, 0, 1); the plane across it is (x, y).
    #[default]
    Z,
}

impl Axis {
    /// "x", "y" or "z".
    ///
    /// # Errors
    /// [`Error::Value`] for any other name.
    pub fn parse(argument: &'static str, name: &str) -> Result<Self> {
        match name {
            "x" => Ok(Self::X),
            "y" => Ok(Self::Y),
            "z" => Ok(Self::Z),
            _ => Err(Error::value(argument, format!("{name:?}"), "\"x\", \"y\" or \"z\"")),
        }
    }

    /// Components along the two axes across and along this one, in cyclic order, so that handedness stays.
    #[inline]
    pub fn to_local(self, v: DVec3) -> DVec3 {
        match self {
            Self::X => DVec3::new(v.y, v.z, v.x),
            Self::Y => DVec3::new(v.z, v.x, v.y),
            Self::Z => v,
        }
    }

    /// The reverse of [`Axis::to_local`].
    #[inline]
    pub fn to_world(self, v: DVec3) -> DVec3 {
        match self {
            Self::X => DVec3::new(v.z, v.x, v.y),
            Self::Y => DVec3::new(v.y, v.z, v.x),
            Self::Z => v,
        }
    }
}

/// A direction and its tangents divided by the power of two in its largest component, which rounds nothing;
/// `None` for a zero or non-finite direction.
pub(super) fn scaled(p: DVec3, dp: Tangents) -> Option<(DVec3, Tangents)> {
    let largest = p.abs().max_element();
    if !p.is_finite() || largest == 0.0 {
        return None;
    }
    const EXPONENT_BITS: u64 = 0x7ff0_0000_0000_0000;
    let power = f64::from_bits(largest.to_bits() & EXPONENT_BITS).max(f64::MIN_POSITIVE);
    Some((p / power, dp.map(|d| d / power)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn local_frames_are_right_handed_and_return() {
        for axis in [Axis::X, Axis::Y, Axis::Z] {
            let v = DVec3::new(1.0, 2.0, 3.0);
            assert_eq!(axis.to_world(axis.to_local(v)), v);
            let [a, b, c] = [DVec3::X, DVec3::Y, DVec3::Z].map(|e| axis.to_world(e));
            assert_eq!(a.cross(b), c);
        }
        assert!(Axis::parse("axis", "w").is_err());
    }

    #[test]
    fn scaling_is_exact_at_every_size() {
        for exponent in [-1074, -1030, -500, 0, 3, 1023] {
            let x = f64::exp2(f64::from(exponent)) * if exponent > -1022 { 1.75 } else { 1.0 };
            let (p, _) = scaled(DVec3::new(0.0, -x, x), [DVec3::ZERO; 2]).expect("a direction");
            assert!(p.y == -p.z && p.z > 0.0 && p.z < 2.0);
        }
        assert!(scaled(DVec3::ZERO, [DVec3::ZERO; 2]).is_none());
        assert!(scaled(DVec3::NAN, [DVec3::ZERO; 2]).is_none());
    }
}
