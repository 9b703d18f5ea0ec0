//! Parallel projection along an axis onto the sides of a bounding box.
//!
//! ```text
//! axis   u runs along   v runs along          u = (p_a - min_a)/w,   v = (p_b - min_b)/h
//!  z         x              y
//!  x         y              z                 w, h: the box's sides along a and b
//!  y         z              x
//! ```

use super::{Axis, Mapped, Mapping, SurfacePoint, check_finite};
use crate::error::{Error, Result};
use glam::{DVec2, DVec3};

/// M(p) = (p_a/w, p_b/h) over a bounding box: the projection along one axis.
///
/// Jacobian: the tangents' components over w and h. No singular set; points outside the box leave [0, 1].
///
/// ```
/// use glam::DVec3;
/// use multum::mapping::{Axis, Mapping, Planar, SurfacePoint};
/// let map = Planar::new(Axis::Z, DVec3::ZERO, DVec3::new(4.0, 2.0, 1.0))?;
/// let at = map.at(&SurfacePoint::new(DVec3::new(1.0, 1.0, 9.0)).moving(DVec3::X, DVec3::Y));
/// assert_eq!((at.uv.x, at.uv.y), (0.25, 0.5));
/// assert_eq!(at.jacobian.m, [[0.25, 0.0], [0.0, 0.5]]);
/// # Ok::<(), multum::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Planar {
    axis: Axis,
    min: DVec3,
    max: DVec3,
}

impl Planar {
    /// A projection along `axis` over the box from `min` to `max`. A side may be negative: it mirrors.
    ///
    /// # Errors
    /// [`Error::Value`] for bounds that are not finite or are flat across the axis.
    pub fn new(axis: Axis, min: DVec3, max: DVec3) -> Result<Self> {
        let map = Self { axis, min, max };
        let size = axis.to_local(max - min);
        check_sides(min, max, &[size.x, size.y])?;
        Ok(map)
    }
}

/// Refuses boxes that are not finite or have one of these sides zero.
pub(super) fn check_sides(min: DVec3, max: DVec3, sides: &[f64]) -> Result<()> {
    check_finite("bounds", &[min.to_array(), max.to_array()].concat())?;
    if sides.iter().any(|s| *s == 0.0 || !s.is_finite()) {
        let expected = "finite sides that are not zero across the axis of projection";
        return Err(Error::value("bounds", format!("{min} to {max}"), expected));
    }
    Ok(())
}

/// The projection along `axis`.
#[inline]
pub(super) fn project(axis: Axis, min: DVec3, max: DVec3, point: &SurfacePoint) -> Mapped {
    let local = |v| axis.to_local(v).truncate();
    let size: DVec2 = local(max) - local(min);
    let [dx, dy] = point.dp.map(|d| local(d) / size);
    Mapped::new((local(point.p) - local(min)) / size, [dx.x, dy.x], [dx.y, dy.y])
}

impl Mapping for Planar {
    fn at(&self, point: &SurfacePoint) -> Mapped {
        project(self.axis, self.min, self.max, point)
    }
}
