//! Mapping functions: from a point of a surface, or a direction, to (u, v), each with its derivative.
//!
//! Every map is one file with its formula, its derivative in closed form and its inverse where it has one.
//! All arithmetic is in f64. Derivatives travel as tangents: a [`SurfacePoint`] carries the movement of the
//! point (and of its normal) for one pixel right and one pixel down, and a map answers with
//! J = ∂(u, v)/∂(x, y). No derivative is a difference of two evaluations, so the jump of u at a seam never
//! shows in one.
//!
//! # Singular sets
//! | where | uv | Jacobian |
//! |---|---|---|
//! | no answer: a NaN or infinite input, the centre of a map of directions, a ray that misses, a point behind a projector | NaN | +∞ |
//! | a pole or axis, where a derivative is unbounded | finite, by the rule of the map | +∞ in the unbounded row where the point moves off the axis, else 0 |
//! | overflow of a derivative | finite | +∞ |
//!
//! No Jacobian has a NaN. A filter takes an infinite entry for "wider than the texture", a NaN coordinate for
//! "nothing here": the border colour and coverage 0.

mod azimuthal;
pub mod barycentric;
mod batch;
pub mod checkerboard;
mod cube;
mod cylindrical;
pub mod distortion;
mod dual_paraboloid;
mod equirect;
mod facets;
mod fisheye;
mod frame;
mod light_probe;
mod linear;
mod mirror_ball;
mod octahedral;
mod patch;
mod perspective;
mod planar;
mod polygon;
mod projective;
mod sphere_map;
mod spherical;
mod stereographic;
pub mod surface;
mod two_stage;

pub use batch::{Input, Numbers, Output, faces_batch, faces_inverse_batch, inverse_batch, map_batch};
pub use cube::{Cube, Face, Layout};
pub use cylindrical::Cylindrical;
pub use dual_paraboloid::DualParaboloid;
pub use equirect::Equirect;
pub use facets::Facets;
pub use fisheye::{Fisheye, FisheyeModel};
pub use frame::Axis;
pub use light_probe::LightProbe;
pub use linear::Linear;
pub use mirror_ball::MirrorBall;
pub use octahedral::Octahedral;
pub use patch::Patch;
pub use perspective::Perspective;
pub use planar::Planar;
pub use polygon::Polygon;
pub use projective::Projective;
pub use sphere_map::SphereMap;
pub use spherical::Spherical;
pub use stereographic::Stereographic;
pub use two_stage::{Intermediate, Projection, TwoStage};

use crate::error::{Error, Result};
use crate::jacobian::Jacobian;
use glam::{DVec2, DVec3};

/// Movement of a vector for one pixel right and one pixel down.
pub type Tangents = [DVec3; 2];

/// What a map may know of a point: where it is, its normal, and how both move over the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The point, or a direction of any length for maps of directions.
    pub p: DVec3,
    /// The normal, of any length; read by the maps that say so.
    pub n: DVec3,
    /// ∂p/∂x and ∂p/∂y.
    pub dp: Tangents,
    /// ∂n/∂x and ∂n/∂y; zero on a flat facet.
    pub dn: Tangents,
}

impl SurfacePoint {
    /// A point that does not move: its Jacobian is zero.
    pub fn new(p: DVec3) -> Self {
        Self { p, n: DVec3::ZERO, dp: [DVec3::ZERO; 2], dn: [DVec3::ZERO; 2] }
    }

    /// The same with a normal.
    #[must_use]
    pub fn with_normal(self, n: DVec3) -> Self {
        Self { n, ..self }
    }

    /// The same with screen derivatives of the point.
    #[must_use]
    pub fn moving(self, dpdx: DVec3, dpdy: DVec3) -> Self {
        Self { dp: [dpdx, dpdy], ..self }
    }
}

/// A texture coordinate and its screen derivative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mapped {
    /// (u, v), v down; NaN where the map has no answer.
    pub uv: DVec2,
    /// ∂(u, v)/∂(x, y), in uv per pixel; never NaN.
    pub jacobian: Jacobian,
}

impl Mapped {
    /// The answer of a map that has none here.
    pub const NOWHERE: Self = Self { uv: DVec2::NAN, jacobian: Jacobian::new([[f64::INFINITY; 2]; 2]) };

    /// An answer from the coordinate and the two rows of its Jacobian; see the table of singular sets.
    pub fn new(uv: DVec2, du: [f64; 2], dv: [f64; 2]) -> Self {
        if !uv.is_finite() {
            return Self::NOWHERE;
        }
        let bounded = |x: f64| if x.is_nan() { f64::INFINITY } else { x };
        Self { uv, jacobian: Jacobian::new([du.map(bounded), dv.map(bounded)]) }
    }
}

/// A point or direction that a map sends to a given (u, v), with its derivatives by u and v.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inverted {
    /// The point; a unit vector for maps of directions.
    pub p: DVec3,
    /// ∂p/∂u
    pub du: DVec3,
    /// ∂p/∂v
    pub dv: DVec3,
}

/// A mapping function.
pub trait Mapping: Send + Sync {
    /// (u, v) and its Jacobian at one point.
    fn at(&self, point: &SurfacePoint) -> Mapped;

    /// The point or direction that has this (u, v); `None` outside the map's picture.
    fn inverse_at(&self, _uv: DVec2) -> Option<Inverted> {
        None
    }

    /// (u, v) alone.
    fn place(&self, point: DVec3) -> DVec2 {
        self.at(&SurfacePoint::new(point)).uv
    }

    /// The point or direction of [`Mapping::inverse_at`] alone.
    fn unplace(&self, uv: DVec2) -> Option<DVec3> {
        self.inverse_at(uv).map(|found| found.p)
    }

    /// Whether [`Mapping::inverse_at`] ever answers.
    fn has_inverse(&self) -> bool {
        false
    }

    /// Whether the map reads the normal.
    fn needs_normals(&self) -> bool {
        false
    }

    /// Whether u = 1 is the same place as u = 0, so that u lies in [0, 1).
    fn is_periodic(&self) -> bool {
        false
    }

    /// Numbers in a point: 3, or 2 for maps of parameters, which read (s, t) from x and y.
    fn dimensions(&self) -> usize {
        3
    }
}

/// Refuses parameters that are not finite.
fn check_finite(argument: &'static str, values: &[f64]) -> Result<()> {
    if values.iter().all(|x| x.is_finite()) {
        Ok(())
    } else {
        Err(Error::value(argument, format!("{values:?}"), "finite numbers"))
    }
}
