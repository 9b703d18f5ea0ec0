//! Parametric surfaces: point, partial derivatives and unit normal at (u, v).

use super::batch::{Numbers, Output, run};
use super::{Axis, check_finite};
use crate::error::{Error, Result};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// A place of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// p(u, v)
    pub p: DVec3,
    /// ∂p/∂u
    pub p_u: DVec3,
    /// ∂p/∂v
    pub p_v: DVec3,
    /// Unit normal: outward on closed surfaces, p_u × p_v on patches.
    pub n: DVec3,
}

/// A surface with parameters in [0, 1]².
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// c + r (sin πv cos 2πu, sin πv sin 2πu, cos πv) about +z: u and v are those of the spherical map.
    /// At the poles p_u is zero; the normal is still the radius.
    Sphere {
        /// c
        center: DVec3,
        /// r > 0
        radius: f64,
    },
    /// c + (r cos 2πu, r sin 2πu, h0 + v (h1 − h0)): u and v are those of the cylindrical map.
    Cylinder {
        /// c
        center: DVec3,
        /// r > 0
        radius: f64,
        /// h0, h1
        height: [f64; 2],
    },
    /// c + ((R + r cos 2πv) cos 2πu, (R + r cos 2πv) sin 2πu, r sin 2πv).
    Torus {
        /// c
        center: DVec3,
        /// R > 0, from the centre to the middle of the tube
        major: f64,
        /// r > 0, of the tube
        minor: f64,
    },
    /// A bicubic Bézier patch, Σ B_i(v) B_j(u) c_ij: rows of the control net run along u. Where p_u × p_v
    /// is zero (a side drawn together to a point) the normal is the one a millionth towards the middle.
    Bezier(Box<[[DVec3; 4]; 4]>),
}

impl Surface {
    /// Checks the numbers that define the surface.
    ///
    /// # Errors
    /// [`Error::Value`] for numbers that are not finite, radii that are not positive and equal heights.
    pub fn checked(self) -> Result<Self> {
        let positive = |name: &'static str, r: f64| {
            if r > 0.0 && r.is_finite() { Ok(()) } else { Err(Error::value(name, r, "a positive number")) }
        };
        match &self {
            Self::Sphere { center, radius } => {
                check_finite("center", &center.to_array())?;
                positive("radius", *radius)?;
            }
            Self::Cylinder { center, radius, height } => {
                positive("radius", *radius)?;
                super::Cylindrical::new(Axis::Z, *center, *height)?;
            }
            Self::Torus { center, major, minor } => {
                check_finite("center", &center.to_array())?;
                positive("major", *major)?;
                positive("minor", *minor)?;
            }
            Self::Bezier(net) => {
                check_finite(
                    "control",
                    &net.iter().flatten().flat_map(|p| p.to_array()).collect::<Vec<_>>(),
                )?;
            }
        }
        Ok(self)
    }

    /// The place at (u, v); all NaN where a parameter is not finite.
    pub fn at(&self, uv: DVec2) -> Place {
        let (su, cu) = (uv.x * TAU).sin_cos();
        match self {
            Self::Sphere { center, radius } => {
                let (sv, cv) = (uv.y * PI).sin_cos();
                let n = DVec3::new(sv * cu, sv * su, cv);
                let p_u = DVec3::new(-sv * su, sv * cu, 0.0) * (TAU * radius);
                let p_v = DVec3::new(cv * cu, cv * su, -sv) * (PI * radius);
                Place { p: *center + n * *radius, p_u, p_v, n }
            }
            Self::Cylinder { center, radius, height: [h0, h1] } => {
                let n = DVec3::new(cu, su, 0.0);
                let p = *center + n * *radius + DVec3::Z * (h0 + uv.y * (h1 - h0));
                Place { p, p_u: DVec3::new(-su, cu, 0.0) * (TAU * radius), p_v: DVec3::Z * (h1 - h0), n }
            }
            Self::Torus { center, major, minor } => {
                let (sv, cv) = (uv.y * TAU).sin_cos();
                let out = DVec3::new(cu, su, 0.0);
                let n = out * cv + DVec3::Z * sv;
                let p_u = DVec3::new(-su, cu, 0.0) * (TAU * (major + minor * cv));
                let p_v = (DVec3::Z * cv - out * sv) * (TAU * minor);
                Place { p: *center + out * *major + n * *minor, p_u, p_v, n }
            }
            Self::Bezier(net) => {
                let (p, p_u, p_v) = bezier(net, uv);
                let cross = p_u.cross(p_v);
                let n = if cross == DVec3::ZERO {
                    let (_, a, b) = bezier(net, uv.lerp(DVec2::splat(0.5), 1e-6));
                    a.cross(b).normalize_or_zero()
                } else {
                    cross.normalize()
                };
                Place { p, p_u, p_v, n }
            }
        }
    }
}

impl Surface {
    /// The places of all (u, v): 12 numbers each, p, p_u, p_v and n.
    ///
    /// # Errors
    /// [`Error::Value`] for room of another size.
    pub fn batch(&self, uv: Numbers<'_>, places: Output<'_>) -> Result<()> {
        run(uv.len() / 2, places, None, [12, 1], false, &|i, out, _| {
            let place = self.at(uv.pair(i));
            for (k, v) in [place.p, place.p_u, place.p_v, place.n].into_iter().enumerate() {
                out[3 * k..3 * k + 3].copy_from_slice(&v.to_array());
            }
            Ok(())
        })
    }
}

/// De Casteljau along u in each row, then along v.
fn bezier(net: &[[DVec3; 4]; 4], uv: DVec2) -> (DVec3, DVec3, DVec3) {
    let rows = net.map(|row| casteljau(row, uv.x));
    let (p, p_v) = casteljau(rows.map(|r| r.0), uv.y);
    let (p_u, _) = casteljau(rows.map(|r| r.1), uv.y);
    (p, p_u, p_v)
}

/// Value and derivative of a cubic.
fn casteljau([a, b, c, d]: [DVec3; 4], t: f64) -> (DVec3, DVec3) {
    let (ab, bc, cd) = (a.lerp(b, t), b.lerp(c, t), c.lerp(d, t));
    let (abc, bcd) = (ab.lerp(bc, t), bc.lerp(cd, t));
    (abc.lerp(bcd, t), (bcd - abc) * 3.0)
}
