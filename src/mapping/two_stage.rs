//! Two-stage maps (Bier and Sloan, "Two-part texture mappings", IEEE CG&A 1986).
//!
//! The S stage wraps the texture around a simple intermediate surface; the O stage carries it to the object.
//! Seen from a point of the object the O stage is a ray, and the texture is read where it meets the surface:
//!
//! ```text
//!  projection            ray from         along                         (all about `center`)
//!  centroid              the centre       p − centre
//!  object_normal         p                n
//!  intermediate_normal   p                the surface's normal through p, either way
//!  reflected_ray         p                i − 2 (n·i)/(n·n) n,  i = p − eye
//!
//!  intermediate  surface                                uv of a point on it
//!  sphere        |q| = radius                           Spherical about `axis`
//!  cylinder      a tube of that radius about `axis`     Cylindrical, v over `height`; open, endless: v may leave [0, 1]
//!  plane         q·axis = radius                        over [−radius, radius] across the axis; endless
//!  cube          max |q_i| = radius                     Cube, in its layout
//! ```

use super::cube::{Cube, Face, Layout};
use super::spherical::{polar, turns};
use super::{Axis, Mapped, Mapping, SurfacePoint, Tangents, check_finite};
use crate::error::{Error, Result};
use glam::{DVec2, DVec3};

/// The surface of the S stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Intermediate {
    /// A sphere.
    Sphere,
    /// An open tube; v runs over these heights along the axis.
    Cylinder([f64; 2]),
    /// A plane across the axis, at a distance of the radius.
    Plane,
    /// A cube with sides of two radii along the axes of the world.
    Cube(Layout),
}

/// The rule of the O stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// From the centre through the point.
    Centroid,
    /// From the point along its normal.
    ObjectNormal,
    /// To the foot of the perpendicular on the intermediate surface.
    IntermediateNormal,
    /// From the point along the mirrored view ray; the eye's position.
    ReflectedRay(DVec3),
}

/// One of the sixteen pairs of stages.
///
/// A ray meets the surface where it leaves it, when it starts inside, else where it enters. A start within
/// 1e-9 radii of the surface counts as inside. Rays that miss have no answer (coverage 0); so have the centre
/// under `Centroid`, and normals that are zero.
///
/// The Jacobian follows from F(o + t d) = 0: dt = −∇F·(do + t dd)/(∇F·d), dq = do + t dd + dt d, then the
/// derivative of the S stage. It takes ∂n/∂x and ∂n/∂y into account; with none given, the facet is flat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoStage {
    intermediate: Intermediate,
    projection: Projection,
    center: DVec3,
    radius: f64,
    axis: Axis,
}

/// Share of the radius by which a start may lie outside and still count as on the surface.
const SKIN: f64 = 1e-9;

/// A ray whose start and direction move over the screen.
struct Ray {
    o: DVec3,
    d: DVec3,
    do_: Tangents,
    dd: Tangents,
}

impl TwoStage {
    /// The pair about `center`, with `axis` for all but the cube.
    ///
    /// # Errors
    /// [`Error::Value`] for numbers that are not finite, a radius that is not positive, or equal heights.
    pub fn new(
        intermediate: Intermediate,
        projection: Projection,
        center: DVec3,
        radius: f64,
        axis: Axis,
    ) -> Result<Self> {
        check_finite("center", &center.to_array())?;
        if !(radius > 0.0 && radius.is_finite()) {
            return Err(Error::value("radius", radius, "a positive number"));
        }
        if let Projection::ReflectedRay(eye) = projection {
            check_finite("eye", &eye.to_array())?;
        }
        if let Intermediate::Cylinder(height) = intermediate {
            super::Cylindrical::new(axis, center, height)?;
        }
        Ok(Self { intermediate, projection, center, radius, axis })
    }

    /// Coordinates in which the centre is the origin, the radius 1 and the axis z.
    fn to_local(self, v: DVec3) -> DVec3 {
        let v = v / self.radius;
        if matches!(self.intermediate, Intermediate::Cube(_)) { v } else { self.axis.to_local(v) }
    }

    /// The S stage: uv of a point q of the unit surface.
    fn texture(&self, q: DVec3, dq: Tangents, face: Face) -> Mapped {
        match self.intermediate {
            Intermediate::Sphere => polar(q, dq),
            Intermediate::Cylinder([h0, h1]) => {
                let (u, du) = turns(q.truncate(), dq.map(DVec3::truncate));
                let scale = self.radius / (h1 - h0);
                let v = (q.z * self.radius - h0) / (h1 - h0);
                Mapped::new(DVec2::new(u, v), du, dq.map(|d| d.z * scale))
            }
            Intermediate::Plane => {
                let uv = (q.truncate() + 1.0) * 0.5;
                Mapped::new(uv, dq.map(|d| d.x * 0.5), dq.map(|d| d.y * 0.5))
            }
            Intermediate::Cube(layout) => {
                let on_face = face.project(q, dq);
                if !on_face.uv.cmpge(DVec2::splat(-SKIN)).all()
                    || !on_face.uv.cmple(DVec2::splat(1.0 + SKIN)).all()
                {
                    return Mapped::NOWHERE;
                }
                Cube::new(layout, DVec3::ZERO).map_or(Mapped::NOWHERE, |cube| cube.place(face, on_face))
            }
        }
    }

    /// The foot of the perpendicular from p.
    fn foot(&self, p: DVec3, dp: Tangents) -> Mapped {
        if !p.is_finite() {
            return Mapped::NOWHERE;
        }
        let face = Face::of(p);
        if !matches!(self.intermediate, Intermediate::Cube(_)) {
            // The S stages of the others read only what the perpendicular leaves alone.
            return self.texture(p, dp, face);
        }
        if p == DVec3::ZERO {
            return Mapped::NOWHERE;
        }
        let ma = face.frame()[2];
        let across = |v: DVec3| v - ma * ma.dot(v);
        self.texture(across(p) + ma, dp.map(across), face)
    }

    /// Where a ray meets the unit surface: t, ∇F there, and the face of a cube.
    fn hit(&self, o: DVec3, d: DVec3) -> Option<(f64, DVec3, Face)> {
        match self.intermediate {
            Intermediate::Sphere => {
                let t = quadratic(d.dot(d), o.dot(d), o.dot(o), o.cross(d).length_squared())?;
                Some((t, o + d * t, Face::PlusX))
            }
            Intermediate::Cylinder(_) => {
                let (o2, d2) = (o.truncate(), d.truncate());
                let cross = o2.perp_dot(d2);
                let t = quadratic(d2.dot(d2), o2.dot(d2), o2.dot(o2), cross * cross)?;
                Some((t, (o2 + d2 * t).extend(0.0), Face::PlusX))
            }
            Intermediate::Plane => {
                let t = (1.0 - o.z) / d.z;
                (t.is_finite() && (t >= 0.0 || (1.0 - o.z).abs() <= SKIN)).then_some((
                    t,
                    DVec3::Z,
                    Face::PlusX,
                ))
            }
            Intermediate::Cube(_) => slabs(o, d),
        }
    }

    fn along(&self, ray: &Ray) -> Mapped {
        let largest = ray.d.abs().max_element();
        if !ray.o.is_finite() || !ray.d.is_finite() || largest == 0.0 {
            return Mapped::NOWHERE;
        }
        let (d, dd) = (ray.d / largest, ray.dd.map(|x| x / largest));
        let Some((t, gradient, face)) = self.hit(ray.o, d) else { return Mapped::NOWHERE };
        let slope = gradient.dot(d);
        let dq = [0, 1].map(|i| {
            let moved = ray.do_[i] + dd[i] * t;
            moved - d * (gradient.dot(moved) / slope)
        });
        self.texture(ray.o + d * t, dq, face)
    }
}

/// The parameter where a ray meets |o + t d| = 1: `a` = d·d, `b` = o·d, `oo` = o·o, `cross2` = |o × d|²,
/// which gives the discriminant b² − a (oo − 1) = a − |o × d|² without cancellation of large squares.
fn quadratic(a: f64, b: f64, oo: f64, cross2: f64) -> Option<f64> {
    let root = (a - cross2).sqrt();
    let c = oo - 1.0;
    if a == 0.0 || root.is_nan() {
        return None;
    }
    if c <= SKIN {
        // Inside: the larger root, written without subtracting near equals.
        return Some(if b <= 0.0 { (root - b) / a } else { -c / (b + root) });
    }
    (b < 0.0).then(|| c / (root - b))
}

/// The parameter where a ray leaves the cube max |q_i| = 1, or enters it from outside.
fn slabs(o: DVec3, d: DVec3) -> Option<(f64, DVec3, Face)> {
    let (mut enter, mut leave) = ((f64::NEG_INFINITY, 0), (f64::INFINITY, 0));
    for i in 0..3 {
        if d[i] == 0.0 {
            if o[i].abs() > 1.0 + SKIN {
                return None;
            }
            continue;
        }
        let side = d[i].signum();
        let (near, far) = ((-side - o[i]) / d[i], (side - o[i]) / d[i]);
        if near > enter.0 {
            enter = (near, i);
        }
        if far < leave.0 {
            leave = (far, i);
        }
    }
    let inside = o.abs().max_element() <= 1.0 + SKIN;
    let ((t, i), direction) = if inside { (leave, 1.0) } else { (enter, -1.0) };
    let enters = enter.0 >= 0.0 && enter.0 <= leave.0;
    if !inside && !enters {
        return None;
    }
    let mut normal = DVec3::ZERO;
    normal[i] = direction * d[i].signum();
    Some((t, normal, Face::of(normal)))
}

impl Mapping for TwoStage {
    fn at(&self, point: &SurfacePoint) -> Mapped {
        let local = |v: DVec3| self.to_local(v);
        let (p, dp) = (local(point.p - self.center), point.dp.map(local));
        let (n, dn) = (local(point.n), point.dn.map(local));
        match self.projection {
            Projection::Centroid => self.along(&Ray { o: DVec3::ZERO, d: p, do_: [DVec3::ZERO; 2], dd: dp }),
            Projection::ObjectNormal => self.along(&Ray { o: p, d: n, do_: dp, dd: dn }),
            Projection::IntermediateNormal => self.foot(p, dp),
            Projection::ReflectedRay(eye) => {
                let (d, dd) = reflect(p - local(eye - self.center), dp, n, dn);
                self.along(&Ray { o: p, d, do_: dp, dd })
            }
        }
    }

    fn needs_normals(&self) -> bool {
        matches!(self.projection, Projection::ObjectNormal | Projection::ReflectedRay(_))
    }

    fn is_periodic(&self) -> bool {
        matches!(self.intermediate, Intermediate::Sphere | Intermediate::Cylinder(_))
    }
}

/// The ray i mirrored at the plane across n, i − 2 (n·i)/(n·n) n, and its tangents. NaN for a zero normal.
fn reflect(i: DVec3, di: Tangents, n: DVec3, dn: Tangents) -> (DVec3, Tangents) {
    let nn = n.dot(n);
    let k = 2.0 * n.dot(i) / nn;
    let slope = |j: usize| {
        let dk = 2.0 * (dn[j].dot(i) + n.dot(di[j]) - k * n.dot(dn[j])) / nn;
        di[j] - n * dk - dn[j] * k
    };
    (i - n * k, [slope(0), slope(1)])
}
