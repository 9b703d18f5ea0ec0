//! Hand-made coordinates of a planar polygon.

use super::barycentric::area2;
use super::{Axis, Mapped, Mapping, SurfacePoint, check_finite, facets};
use crate::error::{Error, Result};
use glam::{DMat2, DVec2, DVec3};

/// (u, v) given by hand at the corners of a planar polygon, interpolated in triangles.
///
/// The polygon may be concave; it is cut by ear clipping, and each triangle interpolates linearly, as renderers
/// do. The Jacobian is constant in a triangle. Points outside the polygon have no answer; the distance from its plane
/// is not looked at, only the place seen along the plane's largest axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    axis: Axis,
    triangles: Vec<Triangle>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Triangle {
    corners: [DVec2; 3],
    det: f64,
    uv: [DVec2; 3],
    /// ∂(u, v)/∂(place)
    slope: DMat2,
}

/// More corners than this are a mesh.
const MOST_CORNERS: usize = 1024;
/// Share of the polygon's size by which corners may leave its plane, and weights of a point may be below 0.
const SLACK: f64 = 1e-6;

impl Polygon {
    /// A polygon from its corners in order and their coordinates.
    ///
    /// # Errors
    /// [`Error::Value`] for fewer than 3 or more than 1024 corners, unequal counts, numbers that are not finite, corners
    /// off one plane, and outlines that cross themselves or have no area.
    pub fn new(corners: &[DVec3], uv: &[DVec2]) -> Result<Self> {
        let count = corners.len();
        if !(3..=MOST_CORNERS).contains(&count) {
            return Err(Error::value("corners", format!("{count} points"), "3 to 1024 points"));
        }
        if uv.len() != count {
            return Err(Error::value(
                "uv",
                format!("{} coordinates", uv.len()),
                format!("{count}, one a corner"),
            ));
        }
        check_finite("corners", &corners.iter().flat_map(|p| p.to_array()).collect::<Vec<_>>())?;
        check_finite("uv", &uv.iter().flat_map(|p| p.to_array()).collect::<Vec<_>>())?;
        let first = corners[0];
        let size = corners.iter().map(|p| (*p - first).length()).fold(0.0, f64::max);
        // Newell's normal: the sum of the cross products of all sides.
        let sides = (0..count).map(|i| (corners[i] - first).cross(corners[(i + 1) % count] - first));
        let normal = sides.sum::<DVec3>().normalize_or_zero();
        let off = corners.iter().map(|p| (*p - first).dot(normal).abs()).fold(0.0, f64::max);
        if normal == DVec3::ZERO || off > SLACK * size {
            let got = format!("points up to {off} off a plane, normal {normal}");
            return Err(Error::value("corners", got, "a polygon with area, all corners in one plane"));
        }
        let axis = facets::major_axis(normal);
        let flat: Vec<DVec2> = corners.iter().map(|p| axis.to_local(*p).truncate()).collect();
        Ok(Self { axis, triangles: clip_ears(&flat, uv)? })
    }
}

/// Cuts a simple polygon into triangles (Meisters 1975): an ear is a convex corner with no other corner in its
/// triangle.
fn clip_ears(flat: &[DVec2], uv: &[DVec2]) -> Result<Vec<Triangle>> {
    let count = flat.len();
    let whole: f64 = (1..count - 1).map(|i| area2(flat[0], flat[i], flat[i + 1])).sum();
    let turn = whole.signum();
    let mut left: Vec<usize> = (0..count).collect();
    let mut triangles = Vec::with_capacity(count - 2);
    while left.len() >= 3 {
        let n = left.len();
        let corner = |i: usize| [left[(i + n - 1) % n], left[i], left[(i + 1) % n]];
        let is_ear = |i: &usize| {
            let t = corner(*i).map(|k| flat[k]);
            let area = area2(t[0], t[1], t[2]) * turn;
            // A corner on a straight side is cut off without a triangle.
            let blocked = |k: &usize| {
                let p = flat[*k];
                !t.contains(&p) && (0..3).all(|e| area2(t[e], t[(e + 1) % 3], p) * turn >= 0.0)
            };
            area == 0.0 || (area > 0.0 && !left.iter().any(blocked))
        };
        let Some(i) = (0..n).find(is_ear) else {
            return Err(Error::value(
                "corners",
                format!("{count} points"),
                "an outline that does not cross itself",
            ));
        };
        let ids = corner(i);
        let [a, b, c] = ids.map(|k| flat[k]);
        let det = area2(a, b, c);
        if det != 0.0 {
            let [p, q, r] = ids.map(|k| uv[k]);
            let slope = DMat2::from_cols(q - p, r - p) * DMat2::from_cols(b - a, c - a).inverse();
            triangles.push(Triangle { corners: [a, b, c], det, uv: [p, q, r], slope });
        }
        left.remove(i);
    }
    Ok(triangles)
}

impl Triangle {
    fn weights(&self, p: DVec2) -> [f64; 3] {
        let [a, b, c] = self.corners;
        [area2(p, b, c), area2(a, p, c), area2(a, b, p)].map(|s| s / self.det)
    }
}

impl Mapping for Polygon {
    fn at(&self, point: &SurfacePoint) -> Mapped {
        let p = self.axis.to_local(point.p).truncate();
        // The triangle that the point is deepest in: on a shared side either gives the same coordinate.
        let mut best = (f64::NEG_INFINITY, [0.0; 3], None);
        for triangle in &self.triangles {
            let w = triangle.weights(p);
            let depth = w[0].min(w[1]).min(w[2]);
            if depth > best.0 {
                best = (depth, w, Some(triangle));
            }
        }
        let (depth, w, Some(triangle)) = best else { return Mapped::NOWHERE };
        if depth < -SLACK {
            return Mapped::NOWHERE;
        }
        let uv = triangle.uv[0] * w[0] + triangle.uv[1] * w[1] + triangle.uv[2] * w[2];
        let [dx, dy] = point.dp.map(|d| triangle.slope * self.axis.to_local(d).truncate());
        Mapped::new(uv, [dx.x, dy.x], [dx.y, dy.y])
    }
}
