//! From a place on the low mesh to a place on the high mesh.

use super::surface::{Place, Surface};
use super::tree::{Stack, Tree};
use super::{Method, Options};
use crate::error::{Error, Result};
use crate::mesh::check_faces;
use crate::par;
use glam::DVec3;

/// Hits closer together than this, in sides of the box around the high mesh, are one surface.
const ONE_SURFACE: f64 = 1e-6;
/// Vertices whose distance one thread measures at a time.
const VERTICES: usize = 1024;

/// A pair of places, on the low and on the high mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub low: Place,
    pub high: Place,
    /// The unit direction in which the low mesh's cage stands off.
    pub direction: DVec3,
    /// The place on the high mesh.
    pub point: DVec3,
    /// How far it lies along the direction.
    pub height: f64,
}

/// Finds places on the high mesh.
pub(super) struct Caster<'a> {
    high: &'a Surface<'a>,
    low: &'a Surface<'a>,
    tree: Tree,
    /// One a vertex of the low mesh, not unit.
    directions: Vec<[f32; 3]>,
    method: Method,
    distance: f64,
}

impl<'a> Caster<'a> {
    pub fn new(high: &'a Surface<'a>, low: &'a Surface<'a>, options: &Options) -> Result<Self> {
        let tree = Tree::new(&high.mesh.positions, &high.mesh.faces);
        let directions = match &options.cage {
            None => low.cage_directions()?,
            Some(cage) => {
                let offset = |(c, p): (&[f32; 3], &[f32; 3])| std::array::from_fn(|k| c[k] - p[k]);
                cage.iter().zip(&low.mesh.positions).map(offset).collect()
            }
        };
        let distance = match options.distance {
            Some(distance) => distance,
            None => {
                let low_tree = Tree::new(&low.mesh.positions, &low.mesh.faces);
                let far = farthest(high, &low_tree)?.max(farthest(low, &tree)?);
                // Flat and equal meshes have a distance of zero, rounding has not.
                2.0 * far + 1e-4 * tree.extent().max(low_tree.extent())
            }
        };
        Ok(Self { high, low, tree, directions, method: options.method, distance })
    }

    pub fn distance(&self) -> f64 {
        self.distance
    }

    /// The tree over the high mesh.
    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    /// The place on the high mesh for one on the low mesh, and whether there were several to choose from.
    pub fn cast(&self, stack: &mut Stack, low: Place) -> Option<(Sample, bool)> {
        let point = self.low.point(low);
        let direction = self
            .low
            .mix(&self.directions, low)
            .try_normalize()
            .unwrap_or_else(|| self.low.face_normal(low.face));
        if direction == DVec3::ZERO {
            return None;
        }
        let (high, ambiguous) = match self.method {
            Method::Closest => {
                let faces_out = |face: u32| self.high.face_normal(face).dot(direction) > 0.0;
                let found = self.tree.closest(stack, point, faces_out)?;
                if found.distance > self.distance {
                    return None;
                }
                (Place { face: found.face, weights: found.weights }, false)
            }
            Method::Outermost | Method::Nearest => self.line(stack, point, direction)?,
        };
        let found = self.high.point(high);
        let height = (found - point).dot(direction);
        Some((Sample { low, high, direction, point: found, height }, ambiguous))
    }

    /// The hit of the line along the direction that the method chooses among those that face it.
    fn line(&self, stack: &mut Stack, point: DVec3, direction: DVec3) -> Option<(Place, bool)> {
        let start = point + self.distance * direction;
        let mut best: Option<(f64, Place)> = None;
        let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
        self.tree.crossings(stack, start, -direction, [0.0, 2.0 * self.distance], |face, crossing| {
            if crossing.front {
                let height = self.distance - crossing.t;
                lowest = lowest.min(height);
                highest = highest.max(height);
                let rank = if self.method == Method::Nearest { -height.abs() } else { height };
                let better = best.is_none_or(|(r, p)| rank > r || rank == r && face < p.face);
                if better {
                    best = Some((rank, Place { face, weights: crossing.weights }));
                }
            }
            true
        });
        best.map(|(_, place)| (place, highest - lowest > ONE_SURFACE * self.tree.extent()))
    }
}

/// The largest distance of a vertex that a face uses to the surface in a tree.
fn farthest(from: &Surface<'_>, to: &Tree) -> Result<f64> {
    let mut used = vec![false; from.mesh.positions.len()];
    from.mesh.faces.iter().flatten().for_each(|&v| used[v as usize] = true);
    let vertices: Vec<DVec3> = from
        .mesh
        .positions
        .iter()
        .zip(used)
        .filter(|(_, used)| *used)
        .map(|(p, _)| DVec3::from_array(p.map(f64::from)))
        .collect();
    let mut most = vec![0.0f64; vertices.len().div_ceil(VERTICES)];
    par::for_each(most.iter_mut().zip(vertices.chunks(VERTICES)), |_, (most, chunk)| {
        let mut stack = Vec::new();
        for &p in chunk {
            *most = to.closest(&mut stack, p, |_| true).map_or(*most, |found| most.max(found.distance));
        }
        Ok(())
    })?;
    Ok(most.into_iter().fold(0.0, f64::max))
}

/// A place on a mesh: the first that a ray meets, or the closest to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index of the face, -1 for none.
    pub face: i32,
    /// Distance: along a ray in lengths of its direction, from a point in the mesh's unit; infinity for none.
    pub distance: f64,
    /// Weights of the face's corners.
    pub barycentric: [f64; 3],
}

const NOTHING: Hit = Hit { face: -1, distance: f64::INFINITY, barycentric: [0.0; 3] };
/// Queries that one thread answers at a time.
const RAYS: usize = 512;

fn finite(p: &[f64]) -> bool {
    p.iter().all(|c| c.is_finite())
}

fn check_lists(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Result<()> {
    check_faces(faces, positions.len())?;
    if !positions.as_flattened().iter().all(|c| c.is_finite()) {
        return Err(Error::value("positions", "a number that is not finite", "finite numbers"));
    }
    Ok(())
}

/// The place of a mesh that is closest to each point.
///
/// # Errors
/// [`Error::Value`] when a face names a vertex that is not there, or a position or point is not finite.
///
/// ```
/// let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
/// let found = multum::bake::closest(&corners, &[[0, 1, 2]], &[[-3.0, 0.5, 4.0]])?;
/// assert_eq!((found[0].face, found[0].distance, found[0].barycentric), (0, 5.0, [0.5, 0.0, 0.5]));
/// # Ok::<(), multum::Error>(())
/// ```
pub fn closest(positions: &[[f32; 3]], faces: &[[u32; 3]], points: &[[f64; 3]]) -> Result<Vec<Hit>> {
    check_lists(positions, faces)?;
    if let Some(point) = points.iter().find(|p| !finite(&p[..])) {
        return Err(Error::value("points", format!("{point:?}"), "finite numbers"));
    }
    let tree = Tree::new(positions, faces);
    let mut hits = vec![NOTHING; points.len()];
    par::for_each(hits.chunks_mut(RAYS).zip(points.chunks(RAYS)), |_, (hits, points)| {
        let mut stack = Vec::new();
        for (hit, point) in hits.iter_mut().zip(points) {
            if let Some(found) = tree.closest(&mut stack, DVec3::from_array(*point), |_| true) {
                *hit = Hit { face: found.face as i32, distance: found.distance, barycentric: found.weights };
            }
        }
        Ok(())
    })?;
    Ok(hits)
}

/// The first face that each ray meets, from either side: origin and direction, which need not be unit.
///
/// # Errors
/// [`Error::Value`] when a face names a vertex that is not there, a position, origin or direction is not
/// finite, or a direction is zero.
///
/// ```
/// let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
/// let hits = multum::bake::intersect(&corners, &[[0, 1, 2]], &[([0.25, 0.25, 3.0], [0.0, 0.0, -2.0])])?;
/// assert_eq!((hits[0].face, hits[0].distance, hits[0].barycentric), (0, 1.5, [0.5, 0.25, 0.25]));
/// # Ok::<(), multum::Error>(())
/// ```
pub fn intersect(
    positions: &[[f32; 3]],
    faces: &[[u32; 3]],
    rays: &[([f64; 3], [f64; 3])],
) -> Result<Vec<Hit>> {
    check_lists(positions, faces)?;
    let wrong = |(o, d): &&([f64; 3], [f64; 3])| !(finite(o) && finite(d) && d.iter().any(|&c| c != 0.0));
    if let Some(ray) = rays.iter().find(wrong) {
        return Err(Error::value(
            "rays",
            format!("{ray:?}"),
            "finite origins and directions that are not zero",
        ));
    }
    let tree = Tree::new(positions, faces);
    let mut hits = vec![NOTHING; rays.len()];
    par::for_each(hits.chunks_mut(RAYS).zip(rays.chunks(RAYS)), |_, (hits, rays)| {
        let mut stack = Vec::new();
        for (hit, (origin, direction)) in hits.iter_mut().zip(rays) {
            let along = DVec3::from_array(*direction);
            // Lengths at the ends of the exponents have no square.
            let largest = along.abs().max_element();
            let unit = (along / largest).normalize();
            let length = (along / largest).length() * largest;
            if let Some((face, found)) = tree.first(&mut stack, DVec3::from_array(*origin), unit) {
                *hit = Hit { face: face as i32, distance: found.t / length, barycentric: found.weights };
            }
        }
        Ok(())
    })?;
    Ok(hits)
}
