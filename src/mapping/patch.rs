//! One patch of a group of parametric surfaces: its range of parameters onto its part of the texture.

use super::{Inverted, Linear, Mapped, Mapping, SurfacePoint, check_finite};
use crate::error::{Error, Result};
use glam::DVec2;

/// u = u0 + (s − s0)/(s1 − s0) (u1 − u0), v alike from t: the corners of the patch go to the corners given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    linear: Linear,
}

impl Patch {
    /// The patch with parameters `s` and `t` at `u` and `v` of the texture. Ranges may run backwards.
    ///
    /// # Errors
    /// [`Error::Value`] for numbers that are not finite and for an empty range of parameters.
    pub fn new(s: [f64; 2], t: [f64; 2], u: [f64; 2], v: [f64; 2]) -> Result<Self> {
        for (name, range) in [("s", s), ("t", t), ("u", u), ("v", v)] {
            check_finite(name, &range)?;
        }
        for (name, range) in [("s", s), ("t", t)] {
            if range[0] == range[1] {
                return Err(Error::value(name, format!("{range:?}"), "a range with two different ends"));
            }
        }
        let (a, e) = ((u[1] - u[0]) / (s[1] - s[0]), (v[1] - v[0]) / (t[1] - t[0]));
        Ok(Self { linear: Linear::new(a, 0.0, u[0] - a * s[0], 0.0, e, v[0] - e * t[0])? })
    }
}

impl Mapping for Patch {
    fn at(&self, point: &SurfacePoint) -> Mapped {
        self.linear.at(point)
    }

    fn inverse_at(&self, uv: DVec2) -> Option<Inverted> {
        self.linear.inverse_at(uv)
    }

    fn has_inverse(&self) -> bool {
        self.linear.has_inverse()
    }

    fn dimensions(&self) -> usize {
        2
    }
}
