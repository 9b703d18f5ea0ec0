//! Whole arrays of points, in tiles on all threads: single or double numbers in, f64 in between, out as asked.

use super::{Cube, Face, Mapped, Mapping, SurfacePoint};
use crate::error::{Error, Result};
use crate::jacobian::Jacobian;
use crate::num::Real;
use crate::par;
use glam::{DVec2, DVec3};

/// Numbers of either precision, borrowed.
#[derive(Clone, Copy, Debug)]
pub enum Numbers<'a> {
    /// Single precision.
    F32(&'a [f32]),
    /// Double precision.
    F64(&'a [f64]),
}

impl Numbers<'_> {
    /// How many.
    pub fn len(&self) -> usize {
        match self {
            Self::F32(a) => a.len(),
            Self::F64(a) => a.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number `i` as a double.
    #[inline]
    pub fn get(&self, i: usize) -> f64 {
        match self {
            Self::F32(a) => f64::from(a[i]),
            Self::F64(a) => a[i],
        }
    }

    /// The pair at place `i`.
    #[inline]
    pub(super) fn pair(&self, i: usize) -> DVec2 {
        DVec2::new(self.get(2 * i), self.get(2 * i + 1))
    }

    /// The Jacobian at place `i`.
    #[inline]
    pub(super) fn jacobian(&self, i: usize) -> Jacobian {
        let at = |k: usize| self.get(4 * i + k);
        Jacobian::new([[at(0), at(1)], [at(2), at(3)]])
    }

    /// The vector of `dimensions` numbers at place `i`, the rest zero.
    #[inline]
    pub(super) fn vector(&self, i: usize, dimensions: usize) -> DVec3 {
        let at = i * dimensions;
        let z = if dimensions == 3 { self.get(at + 2) } else { 0.0 };
        DVec3::new(self.get(at), self.get(at + 1), z)
    }
}

/// Room for results of either precision.
#[derive(Debug)]
pub enum Output<'a> {
    /// Single precision, rounded to nearest.
    F32(&'a mut [f32]),
    /// Double precision.
    F64(&'a mut [f64]),
}

/// What a batch knows of its points: packed vectors, one a point in each array.
#[derive(Clone, Copy, Debug)]
pub struct Input<'a> {
    /// Points or directions, [`Mapping::dimensions`] numbers each.
    pub points: Numbers<'a>,
    /// Normals, three numbers each.
    pub normals: Option<Numbers<'a>>,
    /// ∂p/∂x and ∂p/∂y.
    pub dp: Option<[Numbers<'a>; 2]>,
    /// ∂n/∂x and ∂n/∂y.
    pub dn: Option<[Numbers<'a>; 2]>,
}

impl Input<'_> {
    /// How many points there are, if every array has that many.
    fn check(&self, map: &dyn Mapping) -> Result<usize> {
        let dimensions = map.dimensions();
        let count = self.points.len() / dimensions;
        check_length("points", self.points.len(), count * dimensions)?;
        if map.needs_normals() && self.normals.is_none() {
            return Err(Error::value("normals", "None", "one normal a point: this map reads them"));
        }
        for (name, array, size) in [
            ("normals", self.normals, 3),
            ("dpdx", self.dp.map(|d| d[0]), dimensions),
            ("dpdy", self.dp.map(|d| d[1]), dimensions),
            ("dndx", self.dn.map(|d| d[0]), 3),
            ("dndy", self.dn.map(|d| d[1]), 3),
        ] {
            if let Some(array) = array {
                check_length(name, array.len(), count * size)?;
            }
        }
        Ok(count)
    }

    /// Point `i` with all that is known of it.
    #[inline]
    fn point(&self, i: usize, dimensions: usize) -> SurfacePoint {
        let pair = |arrays: Option<[Numbers<'_>; 2]>, size: usize| {
            arrays.map_or([DVec3::ZERO; 2], |a| a.map(|a| a.vector(i, size)))
        };
        SurfacePoint {
            p: self.points.vector(i, dimensions),
            n: self.normals.map_or(DVec3::ZERO, |n| n.vector(i, 3)),
            dp: pair(self.dp, dimensions),
            dn: pair(self.dn, 3),
        }
    }
}

/// Points a tile: enough work to hand out, few enough to balance.
const TILE: usize = 4096;
/// Most numbers that a point has in an output.
const MOST: usize = 12;

/// One point of a batch: its number, then its places in the two outputs.
type Job<'a> = dyn Fn(usize, &mut [f64], &mut [f64]) -> Result<()> + Sync + 'a;

/// Runs `job` for every point. The outputs hold `sizes` numbers a point; a `periodic` first number that rounds to 1 is 0.
fn drive<T: Real>(
    first: &mut [T],
    second: Option<&mut [T]>,
    sizes: [usize; 2],
    periodic: bool,
    job: &Job<'_>,
) -> Result<()> {
    let points = first.len() / sizes[0];
    let mut seconds = second.map(|s| s.chunks_mut(TILE * sizes[1]));
    let tiles: Vec<_> =
        first.chunks_mut(TILE * sizes[0]).map(|a| (a, seconds.as_mut().and_then(Iterator::next))).collect();
    par::for_pixels(points, tiles.into_iter(), |tile, (a, b)| {
        let mut rest = b.map(|b| b.chunks_exact_mut(sizes[1]));
        for (k, out) in a.chunks_exact_mut(sizes[0]).enumerate() {
            let (mut x, mut y) = ([0.0; MOST], [0.0; MOST]);
            job(tile * TILE + k, &mut x, &mut y)?;
            for (o, x) in out.iter_mut().zip(x) {
                *o = T::from_f64(x);
            }
            if periodic && out[0] == T::ONE {
                out[0] = T::ZERO;
            }
            if let Some(out) = rest.as_mut().and_then(Iterator::next) {
                for (o, y) in out.iter_mut().zip(y) {
                    *o = T::from_f64(y);
                }
            }
        }
        Ok(())
    })
}

/// Runs `job` for `count` points into outputs of either precision.
pub(super) fn run(
    count: usize,
    first: Output<'_>,
    second: Option<Output<'_>>,
    sizes: [usize; 2],
    periodic: bool,
    job: &Job<'_>,
) -> Result<()> {
    let length = |o: &Output<'_>| match o {
        Output::F32(a) => a.len(),
        Output::F64(a) => a.len(),
    };
    check_length("out", length(&first), count * sizes[0])?;
    if let Some(second) = &second {
        check_length("out", length(second), count * sizes[1])?;
    }
    match (first, second) {
        (Output::F32(a), None) => drive(a, None, sizes, periodic, job),
        (Output::F64(a), None) => drive(a, None, sizes, periodic, job),
        (Output::F32(a), Some(Output::F32(b))) => drive(a, Some(b), sizes, periodic, job),
        (Output::F64(a), Some(Output::F64(b))) => drive(a, Some(b), sizes, periodic, job),
        _ => Err(Error::type_("out", "two precisions", "outputs of one precision")),
    }
}

/// Refuses an array of another length than its points ask for.
pub(super) fn check_length(argument: &'static str, length: usize, expected: usize) -> Result<()> {
    if length == expected {
        return Ok(());
    }
    Err(Error::value(argument, format!("{length} numbers"), format!("{expected} numbers")))
}

/// Maps every point: `uv` takes 2 numbers a point, `jacobian` 4 (row by row).
///
/// # Errors
/// [`Error::Value`] for arrays of different counts and for a map that needs normals and has none.
pub fn map_batch(
    map: &dyn Mapping,
    input: Input<'_>,
    uv: Output<'_>,
    jacobian: Option<Output<'_>>,
) -> Result<()> {
    let count = input.check(map)?;
    run(count, uv, jacobian, [2, 4], map.is_periodic(), &|i, uv, j| {
        let mapped = map.at(&input.point(i, map.dimensions()));
        uv[..2].copy_from_slice(&mapped.uv.to_array());
        j[..4].copy_from_slice(mapped.jacobian.m.as_flattened());
        Ok(())
    })
}

/// Faces of a cube: `faces` takes 3 numbers a point (face, s, t), NaN at the centre, and `jacobian` 4, of (s, t).
///
/// # Errors
/// [`Error::Value`] for arrays of different counts.
pub fn faces_batch(
    cube: &Cube,
    input: Input<'_>,
    faces: Output<'_>,
    jacobian: Option<Output<'_>>,
) -> Result<()> {
    let count = input.check(cube)?;
    run(count, faces, jacobian, [3, 4], false, &|i, out, j| {
        let found = cube.face_at(&input.point(i, 3));
        let face = found.map_or(f64::NAN, |(face, _)| face.index() as f64);
        let mapped = found.map_or(Mapped::NOWHERE, |(_, mapped)| mapped);
        out[..3].copy_from_slice(&[face, mapped.uv.x, mapped.uv.y]);
        j[..4].copy_from_slice(mapped.jacobian.m.as_flattened());
        Ok(())
    })
}

/// The direction for every (face, s, t); NaN for a face that is not 0 to 5.
///
/// # Errors
/// [`Error::Value`] for arrays of different counts.
pub fn faces_inverse_batch(cube: &Cube, faces: Numbers<'_>, points: Output<'_>) -> Result<()> {
    run(faces.len() / 3, points, None, [3, 1], false, &|i, out, _| {
        let [face, s, t] = faces.vector(i, 3).to_array();
        let known = Face::ALL.into_iter().find(|f| f.index() as f64 == face);
        let at = known.and_then(|face| cube.face_inverse(face, DVec2::new(s, t)));
        out[..3].copy_from_slice(&at.map_or(DVec3::NAN, |a| a.p).to_array());
        Ok(())
    })
}

/// The point or direction for every (u, v): [`Mapping::dimensions`] numbers each, NaN where there is none.
///
/// # Errors
/// [`Error::Value`] for arrays of different counts and for a map without an inverse.
pub fn inverse_batch(map: &dyn Mapping, uv: Numbers<'_>, points: Output<'_>) -> Result<()> {
    if !map.has_inverse() {
        return Err(Error::value("self", "a map without an inverse", "a map with one"));
    }
    let dimensions = map.dimensions();
    run(uv.len() / 2, points, None, [dimensions, 1], false, &|i, out, _| {
        let at = map.inverse_at(uv.pair(i));
        out[..3].copy_from_slice(&at.map_or(DVec3::NAN, |a| a.p).to_array());
        Ok(())
    })
}
