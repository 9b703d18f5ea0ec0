//! Cameras: where the eye is and what it sees, as matrices of GL.

use super::Mesh;

/// How a camera projects. Distances are along its axis, from the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Everything meets in the eye.
    Perspective {
        /// Angle of view from bottom to top, in radians.
        yfov_rad: f64,
        /// Nearest distance seen.
        near: f64,
        /// Farthest distance seen; infinity for no limit.
        far: f64,
    },
    /// Parallel.
    Orthographic {
        /// Half the height seen.
        half_height: f64,
        /// Nearest distance seen.
        near: f64,
        /// Farthest distance seen.
        far: f64,
    },
}

/// A camera. It looks along its own -z; its y is up in the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name in the file.
    pub name: String,
    /// World space to the camera's own space, row by row.
    pub view: [[f64; 4]; 4],
    /// How it projects.
    pub projection: Projection,
    /// Whether the angle of view (or the half height) holds for the picture's shorter side, rather than for
    /// its height.
    pub fits_shorter_side: bool,
}

/// Steps towards the middle of what is seen; each looks for the outermost points again.
const CENTRING: usize = 4;

type Vec3 = [f64; 3];

fn minus(a: Vec3, b: Vec3) -> Vec3 {
    std::array::from_fn(|k| a[k] - b[k])
}

fn dot(a: Vec3, b: Vec3) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: Vec3) -> Option<Vec3> {
    let length = dot(v, v).sqrt();
    (length > 0.0 && length.is_finite()).then(|| v.map(|c| c / length))
}

fn product(a: [[f64; 4]; 4], b: [[f64; 4]; 4]) -> [[f64; 4]; 4] {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
}

impl Camera {
    /// A camera at `eye` that looks at `target` with `up` upwards in the picture; where these leave the
    /// direction open, along -z with y up.
    pub fn look_at(eye: Vec3, target: Vec3, up: Vec3, projection: Projection) -> Self {
        let back = unit(minus(eye, target)).unwrap_or([0.0, 0.0, 1.0]);
        let right = [up, [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]].into_iter().find_map(|up| unit(cross(up, back)));
        let right = right.unwrap_or([1.0, 0.0, 0.0]);
        let axes = [right, cross(back, right), back];
        let mut view = [[0.0, 0.0, 0.0, 1.0]; 4];
        for (row, axis) in view.iter_mut().zip(axes) {
            *row = [axis[0], axis[1], axis[2], -dot(axis, eye)];
        }
        Self { name: String::new(), view, projection, fits_shorter_side: false }
    }

    /// A camera that sees the whole mesh in a picture of any aspect: [`Camera::framing_in`] a square.
    pub fn framing(mesh: &Mesh) -> Self {
        Self::framing_in(mesh, 1.0)
    }

    /// A camera that sees the whole mesh in a picture of this aspect, width by height, as large as it can: from the
    /// front (+z), a little from the right and above, with an angle of view of 45 degrees along the shorter side. What is
    /// seen lies in the middle of the picture and reaches over 19 of 20 parts of a side, but stays off the eye by a
    /// twentieth of its depth.
    ///
    /// A mesh without faces gives a camera at (0, 0, 3) that looks at the origin.
    pub fn framing_in(mesh: &Mesh, aspect: f64) -> Self {
        let yfov_rad = std::f64::consts::FRAC_PI_4;
        let up = [0.0, 1.0, 0.0];
        if mesh.faces.is_empty() {
            let projection = Projection::Perspective { yfov_rad, near: 1.0, far: 6.0 };
            let camera = Self::look_at([0.0, 0.0, 3.0], [0.0; 3], up, projection);
            return Self { fits_shorter_side: true, ..camera };
        }
        let aspect = if aspect.is_finite() && aspect > 0.0 { aspect } else { 1.0 };
        let half = 0.95 * (yfov_rad / 2.0).tan();
        let slopes = [half * aspect.max(1.0), half / aspect.min(1.0)];
        let back = unit([0.4, 0.25, 1.0]).unwrap_or(up);
        let right = unit(cross(up, back)).unwrap_or([1.0, 0.0, 0.0]);
        let axes = [right, cross(back, right), back];
        let points = || {
            let used = mesh.faces.iter().flatten();
            used.map(|&v| axes.map(|axis| dot(axis, mesh.positions[v as usize].map(f64::from))))
        };
        // With the eye at (a, b, d) on these axes, x - a <= s (d - z) and a - x <= s (d - z) for every point: the least d is
        // half the sum of the largest s z + x and s z - x, divided by s.
        let mut sides = [[f64::NEG_INFINITY; 2]; 2];
        let mut depths = [f64::INFINITY, f64::NEG_INFINITY];
        for p in points() {
            for (k, side) in sides.iter_mut().enumerate() {
                *side = [side[0].max(slopes[k] * p[2] + p[k]), side[1].max(slopes[k] * p[2] - p[k])];
            }
            depths = [depths[0].min(p[2]), depths[1].max(p[2])];
        }
        let distance = |k: usize| 0.5 * (sides[k][0] + sides[k][1]) / slopes[k];
        // A line seen along itself, or a point, has no size in the picture.
        let depth = depths[1] - depths[0];
        let room = if depth > 0.0 { 0.05 * depth } else { 1e-3 * depths[1].abs().max(1.0) };
        let d = distance(0).max(distance(1)).max(depths[1] + room);
        // Along an axis that could have come nearer, the outermost points change with the distance: move until the two are
        // as far from the middle.
        let mut middle = [0, 1].map(|k| 0.5 * (sides[k][0] - sides[k][1]));
        for _ in 0..CENTRING {
            let mut outer = [[(f64::NEG_INFINITY, 0.0, 1.0); 2]; 2];
            for p in points() {
                for k in 0..2 {
                    let away = (p[k] - middle[k]) / (d - p[2]);
                    for (outer, away) in outer[k].iter_mut().zip([away, -away]) {
                        if away > outer.0 {
                            *outer = (away, p[k], d - p[2]);
                        }
                    }
                }
            }
            // (x - a) / e = (a - y) / f
            middle = outer.map(|[(_, x, e), (_, y, f)]| (x * f + y * e) / (e + f));
        }
        let [a, b] = middle;
        let world = |z: f64| std::array::from_fn(|k| a * axes[0][k] + b * axes[1][k] + z * axes[2][k]);
        let (nearest, farthest) = (d - depths[1], d - depths[0]);
        let projection = Projection::Perspective {
            yfov_rad,
            near: (0.5 * nearest).max(1e-3 * farthest),
            far: 1.5 * farthest,
        };
        let camera = Self::look_at(world(d), world(d - farthest), up, projection);
        Self { fits_shorter_side: true, ..camera }
    }

    /// The same camera carried around the vertical (y) axis through `center`, counter-clockwise seen from above.
    pub fn turned(&self, center: Vec3, angle_rad: f64) -> Self {
        let (s, c) = angle_rad.sin_cos();
        let [x, _, z] = center;
        // Turning the camera one way is turning the world the other way before it is seen.
        let turn = [
            [c, 0.0, -s, x - c * x + s * z],
            [0.0, 1.0, 0.0, 0.0],
            [s, 0.0, c, z - s * x - c * z],
            [0.0, 0.0, 0.0, 1.0],
        ];
        Self { view: product(self.view, turn), ..self.clone() }
    }

    /// World space to clip space, row by row, for a picture of this size: GL's frustum and box matrices.
    pub fn matrix(&self, width: usize, height: usize) -> [[f64; 4]; 4] {
        let aspect = width.max(1) as f64 / height.max(1) as f64;
        let by_height = aspect >= 1.0 || !self.fits_shorter_side;
        let (wide, high) = if by_height { (aspect, 1.0) } else { (1.0, 1.0 / aspect) };
        let projection = match self.projection {
            Projection::Perspective { yfov_rad, near, far } => {
                let s = 1.0 / (yfov_rad / 2.0).tan();
                let (a, b) = if far.is_finite() {
                    ((far + near) / (near - far), 2.0 * far * near / (near - far))
                } else {
                    (-1.0, -2.0 * near)
                };
                [
                    [s / wide, 0.0, 0.0, 0.0],
                    [0.0, s / high, 0.0, 0.0],
                    [0.0, 0.0, a, b],
                    [0.0, 0.0, -1.0, 0.0],
                ]
            }
            Projection::Orthographic { half_height, near, far } => {
                let s = 1.0 / half_height;
                let (a, b) = (2.0 / (near - far), (far + near) / (near - far));
                [[s / wide, 0.0, 0.0, 0.0], [0.0, s / high, 0.0, 0.0], [0.0, 0.0, a, b], [0.0, 0.0, 0.0, 1.0]]
            }
        };
        product(projection, self.view)
    }

    /// Clip-space positions of points in a picture of this size.
    pub fn project<T: Copy + Into<f64>>(
        &self,
        positions: &[[T; 3]],
        width: usize,
        height: usize,
    ) -> Vec<[f64; 4]> {
        let m = self.matrix(width, height);
        let at = |p: &[T; 3]| {
            let [x, y, z]: [f64; 3] = [p[0].into(), p[1].into(), p[2].into()];
            let row = |r: &[f64; 4]| r[0] * x + r[1] * y + r[2] * z + r[3];
            [row(&m[0]), row(&m[1]), row(&m[2]), row(&m[3])]
        };
        positions.iter().map(at).collect()
    }

    /// Where the eye is.
    pub fn eye(&self) -> [f64; 3] {
        // The view's upper left part is a rotation: its inverse is its transpose.
        let v = &self.view;
        std::array::from_fn(|k| -(v[0][k] * v[0][3] + v[1][k] * v[1][3] + v[2][k] * v[2][3]))
    }
}
