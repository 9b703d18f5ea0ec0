//! Affine maps of parameters.

use super::{Inverted, Mapped, Mapping, SurfacePoint, check_finite};
use crate::error::{Error, Result};
use glam::{DVec2, DVec3};

/// u = a s + b t + c, v = d s + e t + f, for parameters (s, t).
///
/// The Jacobian is [[a, b], [d, e]] times the parameters' own. [`Linear::inverse`] refuses a e = b d.
///
/// ```
/// use multum::mapping::Linear;
/// let map = Linear::new(2.0, 0.0, 0.1, 0.0, 4.0, 0.2)?;
/// let back = map.inverse()?;
/// assert_eq!(back.coefficients()[0], 0.5);
/// assert!(Linear::new(1.0, 2.0, 0.0, 2.0, 4.0, 0.0)?.inverse().is_err());
/// # Ok::<(), multum::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear {
    m: [f64; 6],
}

impl Linear {
    /// The map with these coefficients, in the order of the formula.
    ///
    /// # Errors
    /// [`Error::Value`] for coefficients that are not finite.
    pub fn new(a: f64, b: f64, c: f64, d: f64, e: f64, f: f64) -> Result<Self> {
        let m = [a, b, c, d, e, f];
        check_finite("coefficients", &m)?;
        Ok(Self { m })
    }

    /// a, b, c, d, e, f.
    pub fn coefficients(&self) -> [f64; 6] {
        self.m
    }

    /// a e − b d with one rounding error: the rounding of b d is found by a fused product and taken back
    /// (Kahan; Jeannerod, Louvet, Muller, Math. Comp. 2013).
    fn det(&self) -> f64 {
        let [a, b, _, d, e, _] = self.m;
        let bd = b * d;
        let error = (-b).mul_add(d, bd);
        a.mul_add(e, -bd) + error
    }

    /// The map from (u, v) back to (s, t).
    ///
    /// # Errors
    /// [`Error::Value`] where a e = b d: the map sends the plane to a line.
    pub fn inverse(&self) -> Result<Self> {
        let [a, b, c, d, e, f] = self.m;
        let det = self.det();
        let refused = || {
            let got = format!("a = {a}, b = {b}, d = {d}, e = {e} with a e - b d = {det}");
            Error::value("coefficients", got, "a e different from b d, else the map has no inverse")
        };
        if det == 0.0 || !det.is_finite() {
            return Err(refused());
        }
        let [ia, ib, id, ie] = [e / det, -b / det, -d / det, a / det];
        Self::new(ia, ib, -(ia * c + ib * f), id, ie, -(id * c + ie * f)).map_err(|_| refused())
    }
}

impl Mapping for Linear {
    fn at(&self, point: &SurfacePoint) -> Mapped {
        let [a, b, c, d, e, f] = self.m;
        let u = |p: DVec3| a * p.x + b * p.y;
        let v = |p: DVec3| d * p.x + e * p.y;
        Mapped::new(DVec2::new(u(point.p) + c, v(point.p) + f), point.dp.map(u), point.dp.map(v))
    }

    fn inverse_at(&self, uv: DVec2) -> Option<Inverted> {
        let [a, b, c, d, e, f] = self.inverse().ok()?.m;
        Some(Inverted {
            p: DVec3::new(a * uv.x + b * uv.y + c, d * uv.x + e * uv.y + f, 0.0),
            du: DVec3::new(a, d, 0.0),
            dv: DVec3::new(b, e, 0.0),
        })
    }

    fn has_inverse(&self) -> bool {
        self.inverse().is_ok()
    }

    fn dimensions(&self) -> usize {
        2
    }
}
