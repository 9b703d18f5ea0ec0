//! The 2x2 derivative of a map, with closed-form singular values.

/// `m[i][j]` is the derivative of coordinate `i` (u or x, then v or y) by output pixel axis `j`
/// (one pixel right, then one pixel down). The unit of the rows is the caller's: uv or texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jacobian {
    /// The matrix, row by row.
    pub m: [[f64; 2]; 2],
}

/// Singular values `sigma1 >= sigma2 >= 0` and the unit vector of the major axis in the space of the rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes {
    /// Largest stretch: full width of the footprint along its major axis.
    pub sigma1: f64,
    /// Smallest stretch: full width across the major axis.
    pub sigma2: f64,
    /// Direction of the major axis, a unit vector; (1, 0) where every direction is equally long.
    pub major: [f64; 2],
}

impl Jacobian {
    /// The identity: one unit right per pixel right, one unit down per pixel down.
    pub const IDENTITY: Self = Self { m: [[1.0, 0.0], [0.0, 1.0]] };
    /// No extent: the pixel is a point.
    pub const ZERO: Self = Self { m: [[0.0; 2]; 2] };

    /// A Jacobian from its rows.
    #[inline(always)]
    pub const fn new(m: [[f64; 2]; 2]) -> Self {
        Self { m }
    }

    /// Rows multiplied by `sx` and `sy`: from uv to texels with the texture's width and height.
    #[inline(always)]
    pub fn scaled(self, sx: f64, sy: f64) -> Self {
        let [[a, b], [c, d]] = self.m;
        Self::new([[a * sx, b * sx], [c * sy, d * sy]])
    }

    /// The product `self * other`: the chain rule, `other` applied first.
    pub fn after(self, other: Self) -> Self {
        let ([[a, b], [c, d]], [[e, f], [g, h]]) = (self.m, other.m);
        Self::new([[a * e + b * g, a * f + b * h], [c * e + d * g, c * f + d * h]])
    }

    /// Determinant: the signed area of the pixel's footprint.
    #[inline(always)]
    pub fn det(self) -> f64 {
        self.m[0][0] * self.m[1][1] - self.m[0][1] * self.m[1][0]
    }

    /// Whether all four entries are finite.
    pub fn is_finite(self) -> bool {
        self.m.iter().flatten().all(|x| x.is_finite())
    }

    /// The largest singular value alone; see [`Jacobian::axes`].
    #[inline(always)]
    pub fn sigma1(self) -> f64 {
        let [[a, b], [c, d]] = self.m;
        // Plain square roots: entries beyond 1e±150 count as infinite or zero.
        0.5 * (length(a + d, c - b) + length(a - d, b + c))
    }

    /// Singular values and major axis.
    ///
    /// `sigma1` is the length of the sum of the matrix's two conformal parts,
    /// `(hypot(a+d, c-b) + hypot(a-d, b+c))/2`, and `sigma2 = |det|/sigma1`, which does not cancel
    /// where the difference of the two lengths would. Blinn, "Consider the lowly 2x2 matrix", IEEE CG&A 1996.
    #[inline(always)]
    pub fn axes(self) -> Axes {
        let [[a, b], [c, d]] = self.m;
        let sigma1 = self.sigma1();
        if sigma1 == 0.0 {
            return Axes { sigma1: 0.0, sigma2: 0.0, major: [1.0, 0.0] };
        }
        let sigma2 = (self.det().abs() / sigma1).min(sigma1);
        // The major axis bisects the directions of the two parts; J J^T's eigenvector without angles.
        let p = 0.5 * ((a * a + b * b) - (c * c + d * d));
        let q = a * c + b * d;
        let r = length(p, q);
        let major = if r == 0.0 {
            [1.0, 0.0]
        } else if p >= 0.0 {
            normalized(p + r, q)
        } else {
            normalized(q, r - p)
        };
        Axes { sigma1, sigma2, major }
    }
}

#[inline(always)]
fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

#[inline(always)]
fn normalized(x: f64, y: f64) -> [f64; 2] {
    let n = length(x, y);
    [x / n, y / n]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Builds `U diag(s1, s2) V^T` and asks for the parts back.
    #[test]
    fn recovers_axes_of_every_angle_and_ratio() {
        for i in 0..36 {
            for k in 0..36 {
                for e in 0..7 {
                    let (t, f) = (f64::from(i) * 0.1745, f64::from(k) * 0.1745);
                    let (s1, s2) = (2000.0, 2000.0 / 10f64.powi(e));
                    let u = [[t.cos(), -t.sin()], [t.sin(), t.cos()]];
                    let v = [[f.cos(), f.sin()], [-f.sin(), f.cos()]];
                    let j =
                        Jacobian::new(u).after(Jacobian::new([[s1, 0.0], [0.0, s2]])).after(Jacobian::new(v));
                    let axes = j.axes();
                    let condition = s1 / s2;
                    assert!((axes.sigma1 / s1 - 1.0).abs() < 4.0 * f64::EPSILON * 4.0);
                    assert!((axes.sigma2 / s2 - 1.0).abs() < 4.0 * f64::EPSILON * condition.max(4.0));
                    if e > 0 {
                        let cross = axes.major[0] * u[1][0] - axes.major[1] * u[0][0];
                        assert!(cross.abs() < 1e-13, "{cross} at {i} {k} {e}");
                    }
                }
            }
        }
    }

    #[test]
    fn sheared_columns_do_not_pass_for_round() {
        for m in [[[10.0, 10.0], [10.0, 10.1]], [[10.0, 10.0], [10.1, 10.0]]] {
            // The squares sum to the squared entries, the product is the determinant.
            let [[a, b], [c, d]]: [[f64; 2]; 2] = m;
            let sum = a * a + b * b + c * c + d * d;
            let det = (a * d - b * c).abs();
            let expected = (0.5 * (sum + (sum * sum - 4.0 * det * det).sqrt())).sqrt();
            let axes = Jacobian::new(m).axes();
            assert!((axes.sigma1 - expected).abs() < 1e-9, "{axes:?}");
            assert!((axes.sigma2 - det / expected).abs() < 1e-9, "{axes:?}");
        }
    }

    #[test]
    fn degenerate_matrices_have_defined_axes() {
        assert_eq!(Jacobian::ZERO.axes(), Axes { sigma1: 0.0, sigma2: 0.0, major: [1.0, 0.0] });
        let line = Jacobian::new([[0.0, 0.0], [64.0, 0.0]]).axes();
        assert_eq!((line.sigma1, line.sigma2, line.major), (64.0, 0.0, [0.0, 1.0]));
        assert!(Jacobian::new([[f64::NAN, 0.0], [0.0, 1.0]]).axes().sigma1.is_nan());
    }
}
