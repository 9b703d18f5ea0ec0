//! Normals for meshes that have none.

use super::check_faces;
use crate::error::{Error, Result};
use std::collections::HashMap;

/// What to do where a file has no normals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Normals {
    /// What the format asks for: flat for glTF (its specification, section 3.7.2.1), smooth for OBJ.
    #[default]
    Auto,
    /// One normal a place in space, each face weighted by its angle there.
    Smooth,
    /// One normal a face; faces share no vertices then.
    Flat,
}

impl Normals {
    /// All values with their names.
    pub const NAMES: [(&'static str, Self); 3] =
        [("auto", Self::Auto), ("smooth", Self::Smooth), ("flat", Self::Flat)];

    /// The value of this name.
    ///
    /// # Errors
    /// [`Error::Value`] for any other word.
    pub fn parse(argument: &'static str, name: &str) -> Result<Self> {
        let found = Self::NAMES.iter().find(|(n, _)| *n == name).map(|(_, value)| *value);
        found.ok_or_else(|| {
            Error::value(argument, format!("{name:?}"), "one of \"auto\", \"smooth\", \"flat\"")
        })
    }
}

pub(super) fn minus(a: [f32; 3], b: [f32; 3]) -> [f64; 3] {
    std::array::from_fn(|k| f64::from(a[k]) - f64::from(b[k]))
}

pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vector at length 1, or +z where it has no direction.
pub(super) fn unit(v: [f64; 3]) -> [f32; 3] {
    let largest = v.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
    if !(largest > 0.0 && largest.is_finite()) {
        return [0.0, 0.0, 1.0];
    }
    let v = v.map(|c| c / largest);
    let length = dot(v, v).sqrt();
    v.map(|c| (c / length) as f32)
}

/// A unit vector at a right angle to a unit normal.
///
/// Duff et al., "Building an orthonormal basis, revisited", JCGT 2017.
#[cfg(feature = "mesh")]
pub(super) fn any_tangent([x, y, z]: [f32; 3]) -> [f32; 3] {
    let sign = 1f32.copysign(z);
    let a = -1.0 / (sign + z);
    [1.0 + sign * x * x * a, sign * x * y * a, -sign * x]
}

/// Smooth unit normals: at each place in space the sum of the normals of the faces that meet there, each
/// weighted by its angle there, so that the result does not depend on how the surface was triangulated.
/// Vertices at the same place share their normal, which uv seams need. +z where no face has an area.
///
/// Thürmer and Wüthrich, "Computing vertex normals from polygonal facets", JGT 1998.
///
/// # Errors
/// [`Error::Value`](crate::Error::Value) when a face names a vertex that is not there.
///
/// ```
/// // The corner of a cube: three faces, one of them cut in two, weigh the same.
/// let p = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.], [1., 1., 0.]];
/// let faces = [[0, 2, 4], [0, 4, 1], [0, 1, 3], [0, 3, 2]];
/// let n = multum::mesh::smooth_normals(&p, &faces).unwrap()[0];
/// assert!(n.iter().all(|c| (c + 3f32.sqrt().recip()).abs() < 1e-6));
/// ```
pub fn smooth_normals(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Result<Vec<[f32; 3]>> {
    check_faces(faces, positions.len())?;
    Ok(missing(positions, faces, Normals::Smooth))
}

/// Normals of checked faces. Flat needs vertices of its own for each face.
pub(super) fn missing(positions: &[[f32; 3]], faces: &[[u32; 3]], normals: Normals) -> Vec<[f32; 3]> {
    let welded: Vec<usize> =
        if normals == Normals::Flat { (0..positions.len()).collect() } else { weld(positions) };
    grouped(positions, faces, &welded)
}

/// Normals of checked faces, shared by the vertices that name the same vertex in `groups`.
pub(crate) fn grouped(positions: &[[f32; 3]], faces: &[[u32; 3]], groups: &[usize]) -> Vec<[f32; 3]> {
    let mut sums = vec![[0.0; 3]; positions.len()];
    for face in faces {
        let corners = face.map(|v| v as usize);
        let p = corners.map(|v| positions[v]);
        let normal = cross(minus(p[1], p[0]), minus(p[2], p[0]));
        let area = dot(normal, normal).sqrt();
        if !(area > 0.0 && area.is_finite()) {
            continue;
        }
        for (i, &corner) in corners.iter().enumerate() {
            let (a, b) = (minus(p[(i + 1) % 3], p[i]), minus(p[(i + 2) % 3], p[i]));
            let weight = dot(cross(a, b), cross(a, b)).sqrt().atan2(dot(a, b)) / area;
            let sum: &mut [f64; 3] = &mut sums[groups[corner]];
            sum.iter_mut().zip(normal).for_each(|(s, n)| *s += n * weight);
        }
    }
    groups.iter().map(|&v| unit(sums[v])).collect()
}

/// For each vertex the first vertex at the same place.
fn weld(positions: &[[f32; 3]]) -> Vec<usize> {
    let mut first = HashMap::with_capacity(positions.len());
    // Adding 0 makes one zero of the two.
    positions
        .iter()
        .enumerate()
        .map(|(i, p)| *first.entry(p.map(|c| (c + 0.0).to_bits())).or_insert(i))
        .collect()
}
