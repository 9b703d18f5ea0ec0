//! Six faces around a centre: the sky box.
//!
//! ```text
//! Frame: x right, y up, z forward, as OpenGL's faces are seen from inside. On each face s runs right, t down.
//!
//!  face   0 +X   1 -X   2 +Y   3 -Y   4 +Z   5 -Z
//!  s      -z     +z     +x     +x     +x     -x      s = (sc/|ma| + 1)/2
//!  t      -y     -y     +z     -z     -y     -y      t = (tc/|ma| + 1)/2      (OpenGL 4.6, table 8.19)
//!  ma     +x     -x     +y     -y     +z     -z
//!
//!  "cross", 4 by 3 cells             "strip", 6 by 1 cells
//!        +----+                      +----+----+----+----+----+----+
//!        | +Y |                      | +X | -X | +Y | -Y | +Z | -Z |
//!   +----+----+----+----+            +----+----+----+----+----+----+
//!   | -X | +Z | +X | -Z |
//!   +----+----+----+----+            "stacked" is the strip upright: 1 by 6 cells
//!        | -Y |
//!        +----+
//! ```
//! In the cross every face meets its neighbours as on the cube, unturned and unmirrored.

use super::facets::major_axis;
use super::frame::scaled;
use super::{Axis, Inverted, Mapped, Mapping, SurfacePoint, Tangents, check_finite};
use crate::error::{Error, Result};
use glam::{DVec2, DVec3};

/// Where the six faces lie in one picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Layout {
    /// 4 by 3 cells, six of them used.
    #[default]
    Cross,
    /// 6 by 1 cells, in the order +X −X +Y −Y +Z −Z.
    Strip,
    /// 1 by 6 cells in the same order.
    Stacked,
}

impl Layout {
    /// "cross", "strip" or "stacked".
    ///
    /// # Errors
    /// [`Error::Value`] for any other name.
    pub fn parse(argument: &'static str, name: &str) -> Result<Self> {
        match name {
            "cross" => Ok(Self::Cross),
            "strip" => Ok(Self::Strip),
            "stacked" => Ok(Self::Stacked),
            _ => Err(Error::value(
                argument,
                format!("{name:?}"),
                "\"cross\", \"strip\", \"stacked\" or \"faces\"",
            )),
        }
    }

    /// Columns and rows of cells.
    pub fn cells(self) -> (usize, usize) {
        match self {
            Self::Cross => (4, 3),
            Self::Strip => (6, 1),
            Self::Stacked => (1, 6),
        }
    }

    /// Column and row of a face's cell.
    pub fn cell(self, face: Face) -> (usize, usize) {
        const CROSS: [(usize, usize); 6] = [(2, 1), (0, 1), (1, 0), (1, 2), (1, 1), (3, 1)];
        match self {
            Self::Cross => CROSS[face.index()],
            Self::Strip => (face.index(), 0),
            Self::Stacked => (0, face.index()),
        }
    }
}

/// A face of the cube, in OpenGL's order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Face {
    /// Right.
    PlusX,
    /// Left.
    MinusX,
    /// Up.
    PlusY,
    /// Down.
    MinusY,
    /// Forward.
    PlusZ,
    /// Backward.
    MinusZ,
}

impl Face {
    /// All six, in order.
    pub const ALL: [Self; 6] =
        [Self::PlusX, Self::MinusX, Self::PlusY, Self::MinusY, Self::PlusZ, Self::MinusZ];

    /// 0 to 5.
    pub fn index(self) -> usize {
        self as usize
    }

    /// The face that a direction meets: its largest component; X before Y before Z on ties.
    #[inline]
    pub fn of(d: DVec3) -> Self {
        match major_axis(d) {
            Axis::X if d.x >= 0.0 => Self::PlusX,
            Axis::X => Self::MinusX,
            Axis::Y if d.y >= 0.0 => Self::PlusY,
            Axis::Y => Self::MinusY,
            Axis::Z if d.z >= 0.0 => Self::PlusZ,
            Axis::Z => Self::MinusZ,
        }
    }

    /// Directions of sc, tc and ma.
    #[inline]
    pub fn frame(self) -> [DVec3; 3] {
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        match self {
            Self::PlusX => [-z, -y, x],
            Self::MinusX => [z, -y, -x],
            Self::PlusY => [x, z, y],
            Self::MinusY => [x, -z, -y],
            Self::PlusZ => [x, -y, z],
            Self::MinusZ => [-x, -y, -z],
        }
    }

    /// (s, t) of a direction on this face and its Jacobian, by the quotient rule; the direction must lie on
    /// the face's side. Past the face's edges s and t leave [0, 1].
    #[inline]
    pub fn project(self, d: DVec3, dd: Tangents) -> Mapped {
        let [sc, tc, ma] = self.frame();
        let m = ma.dot(d);
        if m <= 0.0 {
            return Mapped::NOWHERE;
        }
        let (s, t) = (sc.dot(d) / m, tc.dot(d) / m);
        let slope = |axis: DVec3, q: f64| dd.map(|d| (axis.dot(d) - q * ma.dot(d)) / m * 0.5);
        Mapped::new((DVec2::new(s, t) + 1.0) * 0.5, slope(sc, s), slope(tc, t))
    }
}

/// The sky box: a direction meets a face, and the face has a cell in a picture.
///
/// Footprints stay with the face of their centre; the Jacobian jumps at the edges of the cube. The zero
/// direction has no answer, nor has the inverse in the cross's empty cells.
///
/// ```
/// use glam::DVec3;
/// use multum::mapping::{Cube, Layout, Mapping, SurfacePoint};
/// let map = Cube::new(Layout::Cross, DVec3::ZERO)?;
/// assert_eq!(map.at(&SurfacePoint::new(DVec3::Z)).uv.to_array(), [0.375, 0.5]);
/// # Ok::<(), multum::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cube {
    layout: Layout,
    center: DVec3,
}

impl Cube {
    /// Directions from `center`.
    ///
    /// # Errors
    /// [`Error::Value`] for a centre that is not finite.
    pub fn new(layout: Layout, center: DVec3) -> Result<Self> {
        check_finite("center", &center.to_array())?;
        Ok(Self { layout, center })
    }

    /// The face and (s, t) on it, each in [0, 1]; `None` for the centre itself and for non-finite points.
    pub fn face_at(&self, point: &SurfacePoint) -> Option<(Face, Mapped)> {
        let (d, dd) = scaled(point.p - self.center, point.dp)?;
        let face = Face::of(d);
        Some((face, face.project(d, dd)))
    }

    /// The direction at (s, t) of a face, a unit vector, with its derivatives by s and t.
    pub fn face_inverse(&self, face: Face, st: DVec2) -> Option<Inverted> {
        if !st.is_finite() {
            return None;
        }
        let [sc, tc, ma] = face.frame();
        let q = st * 2.0 - 1.0;
        Some(normalized(ma + sc * q.x + tc * q.y, sc * 2.0, tc * 2.0, self.center))
    }

    /// A place on a face as a place in the picture.
    pub(super) fn place(&self, face: Face, on_face: Mapped) -> Mapped {
        let ((columns, rows), (column, row)) = (self.layout.cells(), self.layout.cell(face));
        let cells = DVec2::new(columns as f64, rows as f64);
        let j = on_face.jacobian.scaled(1.0 / cells.x, 1.0 / cells.y);
        Mapped::new((on_face.uv + DVec2::new(column as f64, row as f64)) / cells, j.m[0], j.m[1])
    }
}

/// A direction of any length and its derivatives, made a unit vector from `center`.
pub(super) fn normalized(q: DVec3, du: DVec3, dv: DVec3, center: DVec3) -> Inverted {
    let length = q.length();
    let p = q / length;
    let across = |d: DVec3| (d - p * p.dot(d)) / length;
    Inverted { p: p + center, du: across(du), dv: across(dv) }
}

impl Mapping for Cube {
    #[inline]
    fn at(&self, point: &SurfacePoint) -> Mapped {
        self.face_at(point).map_or(Mapped::NOWHERE, |(face, st)| self.place(face, st))
    }

    #[inline]
    fn inverse_at(&self, uv: DVec2) -> Option<Inverted> {
        if !(0.0..=1.0).contains(&uv.x) || !(0.0..=1.0).contains(&uv.y) {
            return None;
        }
        let (columns, rows) = self.layout.cells();
        let cells = DVec2::new(columns as f64, rows as f64);
        let place = uv * cells;
        let cell = place.floor().min(cells - 1.0);
        let found = |f: &Face| self.layout.cell(*f) == (cell.x as usize, cell.y as usize);
        let face = Face::ALL.into_iter().find(found)?;
        let i = self.face_inverse(face, place - cell)?;
        Some(Inverted { p: i.p, du: i.du * cells.x, dv: i.dv * cells.y })
    }

    fn has_inverse(&self) -> bool {
        true
    }
}
