//! Pictures of fisheye lenses.

use super::azimuthal::{Radial, project, unproject};
use super::{Inverted, Mapped, Mapping, SurfacePoint};
use crate::error::{Error, Result};
use glam::DVec2;
use std::f64::consts::TAU;

/// The radial law of a lens.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FisheyeModel {
    /// R = θ/(fov/2): equal angles, equal distances.
    #[default]
    Equidistant,
    /// R = sin(θ/2)/sin(fov/4): equal solid angles, equal areas.
    Equisolid,
}

impl FisheyeModel {
    /// "equidistant" or "equisolid".
    ///
    /// # Errors
    /// [`Error::Value`] for any other name.
    pub fn parse(argument: &'static str, name: &str) -> Result<Self> {
        match name {
            "equidistant" => Ok(Self::Equidistant),
            "equisolid" => Ok(Self::Equisolid),
            _ => Err(Error::value(argument, format!("{name:?}"), "\"equidistant\" or \"equisolid\"")),
        }
    }
}

/// A round picture that is `fov` wide around forward. Directions past fov/2 have no answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fisheye {
    model: FisheyeModel,
    half_fov: f64,
}

impl Fisheye {
    /// A lens that sees `fov` radians, 0 < fov ≤ 2π.
    ///
    /// # Errors
    /// [`Error::Value`] for any other fov.
    pub fn new(model: FisheyeModel, fov: f64) -> Result<Self> {
        if !(fov > 0.0 && fov <= TAU) {
            return Err(Error::value(
                "fov",
                format!("{} degrees", fov.to_degrees()),
                "above 0 and up to 360",
            ));
        }
        Ok(Self { model, half_fov: 0.5 * fov })
    }
}

impl Radial for Fisheye {
    fn radius(&self, theta: f64) -> (f64, f64) {
        match self.model {
            FisheyeModel::Equidistant => (theta / self.half_fov, 1.0 / self.half_fov),
            FisheyeModel::Equisolid => {
                let scale = (0.5 * self.half_fov).sin();
                let (sin, cos) = (0.5 * theta).sin_cos();
                (sin / scale, 0.5 * cos / scale)
            }
        }
    }

    fn limit(&self) -> f64 {
        // The rim itself belongs to the picture, whichever way its angle was rounded.
        self.half_fov * (1.0 + 4.0 * f64::EPSILON)
    }

    fn angle(&self, radius: f64) -> Option<(f64, f64)> {
        if radius > 1.0 {
            return None;
        }
        Some(match self.model {
            FisheyeModel::Equidistant => (radius * self.half_fov, self.half_fov),
            FisheyeModel::Equisolid => {
                let scale = (0.5 * self.half_fov).sin();
                let s = radius * scale;
                (2.0 * s.asin(), 2.0 * scale / ((1.0 - s) * (1.0 + s)).sqrt())
            }
        })
    }
}

impl Mapping for Fisheye {
    #[inline]
    fn at(&self, point: &SurfacePoint) -> Mapped {
        project(self, point.p, point.dp)
    }

    /// The direction inside the disc; the corners of the picture have none.
    #[inline]
    fn inverse_at(&self, uv: DVec2) -> Option<Inverted> {
        unproject(self, uv)
    }

    fn has_inverse(&self) -> bool {
        true
    }
}
