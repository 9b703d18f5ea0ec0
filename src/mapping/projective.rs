//! Projecting a picture onto a scene: decals, slides, shadow maps.

use super::{Mapped, Mapping, SurfacePoint, check_finite};
use crate::error::{Error, Result};
use glam::{DMat4, DVec2, DVec3, DVec4, Vec4Swizzles};

/// (s, t, r, q) = M (p, 1), then u = s/q and v = t/q, by a matrix that already ends in texture space.
///
/// du = (ds − u dq)/q. Points with q ≤ 0 are behind the projector and have no answer; nor has, where
/// [`Projective::front_only`] asks for it, a point whose normal is turned away from the projector.
///
/// ```
/// use glam::{DMat4, DVec3, DVec4};
/// use multum::mapping::{Mapping, Projective, SurfacePoint};
/// // A slide projector at the origin that looks along +z.
/// let rows = DMat4::from_cols(DVec4::X, DVec4::Y, DVec4::new(0.5, 0.5, 1.0, 1.0), DVec4::ZERO);
/// let map = Projective::new(rows)?;
/// assert_eq!(map.at(&SurfacePoint::new(DVec3::new(1.0, 0.0, 4.0))).uv.to_array(), [0.75, 0.5]);
/// assert!(map.at(&SurfacePoint::new(DVec3::new(1.0, 0.0, -4.0))).uv.is_nan());
/// # Ok::<(), multum::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projective {
    matrix: DMat4,
    /// Where the light comes from, homogeneous, when back faces are left out.
    source: Option<DVec4>,
}

impl Projective {
    /// A projector with this matrix (glam's column order).
    ///
    /// # Errors
    /// [`Error::Value`] for entries that are not finite and for a matrix whose rows s, t and q depend on each
    /// other: it has no centre of projection.
    pub fn new(matrix: DMat4) -> Result<Self> {
        check_finite("matrix", &matrix.to_cols_array())?;
        if center(matrix) == DVec4::ZERO {
            return Err(Error::value(
                "matrix",
                matrix,
                "rows 0, 1 and 3 (s, t and q) that are linearly independent",
            ));
        }
        Ok(Self { matrix, source: None })
    }

    /// The same, leaving out faces turned away: those with normal · (projector − p) ≤ 0.
    ///
    /// A projector at infinity shines along increasing r (the third row).
    ///
    /// # Errors
    /// [`Error::Value`] where the projector is at infinity and r does not tell its side.
    pub fn front_only(self) -> Result<Self> {
        let c = center(self.matrix);
        let source = if c.w != 0.0 {
            (c.xyz() / c.w).extend(1.0)
        } else {
            let depth = self.matrix.row(2).xyz().dot(c.xyz());
            if depth == 0.0 {
                let expected = "a third row (r) that grows away from the parallel projector";
                return Err(Error::value("matrix", self.matrix, expected));
            }
            c * -depth.signum()
        };
        Ok(Self { source: Some(source), ..self })
    }
}

/// The point that rows 0, 1 and 3 all send to zero: their four-dimensional cross product.
fn center(matrix: DMat4) -> DVec4 {
    let [a, b, c] = [matrix.row(0), matrix.row(1), matrix.row(3)];
    let minor = |drop: fn(DVec4) -> DVec3| drop(a).dot(drop(b).cross(drop(c)));
    DVec4::new(minor(|v| v.yzw()), -minor(|v| v.xzw()), minor(|v| v.xyw()), -minor(|v| v.xyz()))
}

impl Mapping for Projective {
    fn at(&self, point: &SurfacePoint) -> Mapped {
        let h = self.matrix * point.p.extend(1.0);
        if !(h.w > 0.0 && h.w.is_finite()) {
            return Mapped::NOWHERE;
        }
        if let Some(source) = self.source {
            let towards = source.xyz() - point.p * source.w;
            let faces = point.n.dot(towards) > 0.0;
            if !faces {
                return Mapped::NOWHERE;
            }
        }
        let uv = h.xy() / h.w;
        let [dx, dy]: [DVec2; 2] = point.dp.map(|d| {
            let dh = self.matrix * d.extend(0.0);
            (dh.xy() - uv * dh.w) / h.w
        });
        Mapped::new(uv, [dx.x, dy.x], [dx.y, dy.y])
    }

    fn needs_normals(&self) -> bool {
        self.source.is_some()
    }
}
