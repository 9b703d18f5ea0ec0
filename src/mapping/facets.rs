//! One planar projection a facet: along the axis that the facet faces most.

use super::planar::{check_sides, project};
use super::{Axis, Mapped, Mapping, SurfacePoint};
use crate::error::Result;
use glam::DVec3;

/// The planar map along X, Y or Z, picked by the normal's largest component (ties: X before Y before Z).
///
/// Opposite facets share one picture, so one of the two sees it mirrored. The Jacobian is that of the picked
/// plane; it jumps where the pick changes. A zero or non-finite normal has no answer.
///
/// ```
/// use glam::DVec3;
/// use multum::mapping::{Facets, Mapping, SurfacePoint};
/// let map = Facets::new(DVec3::ZERO, DVec3::ONE)?;
/// let p = SurfacePoint::new(DVec3::new(0.25, 0.5, 1.0));
/// assert_eq!(map.at(&p.with_normal(DVec3::Z)).uv.to_array(), [0.25, 0.5]);
/// assert_eq!(map.at(&p.with_normal(DVec3::X)).uv.to_array(), [0.5, 1.0]);
/// # Ok::<(), multum::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facets {
    min: DVec3,
    max: DVec3,
}

impl Facets {
    /// Planes over the box from `min` to `max`.
    ///
    /// # Errors
    /// [`crate::Error::Value`] for bounds that are not finite or are flat.
    pub fn new(min: DVec3, max: DVec3) -> Result<Self> {
        check_sides(min, max, &(max - min).to_array())?;
        Ok(Self { min, max })
    }
}

/// The axis of the largest component; X before Y before Z on ties.
#[inline]
pub(super) fn major_axis(v: DVec3) -> Axis {
    let a = v.abs();
    if a.x >= a.y && a.x >= a.z {
        Axis::X
    } else if a.y >= a.z {
        Axis::Y
    } else {
        Axis::Z
    }
}

impl Mapping for Facets {
    fn at(&self, point: &SurfacePoint) -> Mapped {
        if !point.n.is_finite() || point.n == DVec3::ZERO {
            return Mapped::NOWHERE;
        }
        project(major_axis(point.n), self.min, self.max, point)
    }

    fn needs_normals(&self) -> bool {
        true
    }
}
