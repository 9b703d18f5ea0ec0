//! A mesh as a surface: places, normals and frames inside faces.

use crate::error::Result;
use crate::mesh::{Mesh, smooth_normals};
use glam::DVec3;
use std::collections::HashMap;

/// A mesh with the numbers that its faces are read by.
pub(super) struct Surface<'a> {
    pub mesh: &'a Mesh,
}

/// A place on a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub face: u32,
    pub weights: [f64; 3],
}

/// A tangent frame by the rules of MikkTSpace: nothing is made unit or orthogonal inside a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub tangent: DVec3,
    pub bitangent: DVec3,
    pub normal: DVec3,
}

fn wide(p: [f32; 3]) -> DVec3 {
    DVec3::from_array(p.map(f64::from))
}

impl<'a> Surface<'a> {
    pub fn new(mesh: &'a Mesh) -> Self {
        Self { mesh }
    }

    fn corners(&self, face: u32) -> [usize; 3] {
        self.mesh.faces[face as usize].map(|v| v as usize)
    }

    /// Vectors of vertices, weighted.
    pub fn mix(&self, list: &[[f32; 3]], at: Place) -> DVec3 {
        let [a, b, c] = self.corners(at.face).map(|v| wide(list[v]));
        a * at.weights[0] + b * at.weights[1] + c * at.weights[2]
    }

    /// Numbers of vertices, weighted.
    pub fn mix_scalar(&self, list: &[f32], at: Place) -> f64 {
        let [a, b, c] = self.corners(at.face).map(|v| f64::from(list[v]));
        a * at.weights[0] + b * at.weights[1] + c * at.weights[2]
    }

    pub fn point(&self, at: Place) -> DVec3 {
        self.mix(&self.mesh.positions, at)
    }

    /// The interpolated normal at unit length; the face's own where that has no direction.
    pub fn normal(&self, at: Place) -> DVec3 {
        self.mix(&self.mesh.normals, at).try_normalize().unwrap_or_else(|| self.face_normal(at.face))
    }

    /// The plane's unit normal, on the side where the corners run counter-clockwise; zero without an area.
    pub fn face_normal(&self, face: u32) -> DVec3 {
        let [a, b, c] = self.corners(face).map(|v| wide(self.mesh.positions[v]));
        (b - a).cross(c - a).normalize_or_zero()
    }

    /// The interpolated frame; the bitangent is `w * cross(normal, tangent)` of the interpolated two.
    pub fn frame(&self, at: Place) -> Frame {
        let corners = self.corners(at.face);
        let normal = self.mix(&self.mesh.normals, at);
        let tangent = corners.iter().zip(at.weights).fold(DVec3::ZERO, |sum, (&v, weight)| {
            let [x, y, z, _] = self.mesh.tangents[v].map(f64::from);
            sum + weight * DVec3::new(x, y, z)
        });
        let w = f64::from(self.mesh.tangents[corners[0]][3]).signum();
        Frame { tangent, bitangent: w * normal.cross(tangent), normal }
    }

    /// Gradients of the three corner weights on the face's plane; zeros without an area.
    pub fn gradients(&self, face: u32) -> [DVec3; 3] {
        let [a, b, c] = self.corners(face).map(|v| wide(self.mesh.positions[v]));
        let normal = (b - a).cross(c - a);
        let square = normal.length_squared();
        if square > 0.0 {
            [c - b, a - c, b - a].map(|edge| normal.cross(edge) / square)
        } else {
            [DVec3::ZERO; 3]
        }
    }

    /// Mean curvature at each vertex in 1 / unit of length, positive where the surface is convex: half the
    /// divergence of the interpolated normals, which is one number a face, averaged by area over the faces
    /// around a place.
    pub fn curvature(&self) -> Vec<f32> {
        let mesh = self.mesh;
        let welded = weld(&mesh.positions);
        let mut sums = vec![[0.0f64; 2]; mesh.positions.len()];
        for (i, corners) in mesh.faces.iter().enumerate() {
            let corners = corners.map(|v| v as usize);
            let [a, b, c] = corners.map(|v| wide(mesh.positions[v]));
            let area = 0.5 * (b - a).cross(c - a).length();
            let divergence: f64 = corners
                .iter()
                .zip(self.gradients(i as u32))
                .map(|(&v, gradient)| wide(mesh.normals[v]).dot(gradient))
                .sum();
            for corner in corners {
                sums[welded[corner]][0] += area * 0.5 * divergence;
                sums[welded[corner]][1] += area;
            }
        }
        let mean = |[sum, area]: [f64; 2]| if area > 0.0 { (sum / area) as f32 } else { 0.0 };
        welded.iter().map(|&v| mean(sums[v])).collect()
    }

    /// Edges, between places in space, that more than two faces share, or two that run along them the same
    /// way.
    pub fn non_manifold_edges(&self) -> usize {
        let welded = weld(&self.mesh.positions);
        let mut edges: HashMap<[usize; 2], [u32; 2]> = HashMap::new();
        for face in &self.mesh.faces {
            let corners = face.map(|v| welded[v as usize]);
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                if a != b {
                    edges.entry([a.min(b), a.max(b)]).or_default()[usize::from(a > b)] += 1;
                }
            }
        }
        edges.values().filter(|uses| uses.iter().any(|&n| n > 1)).count()
    }

    /// Directions in which the cage stands off: normals that are one at each place in space, so that rays of
    /// neighbouring faces leave no gap at hard edges.
    pub fn cage_directions(&self) -> Result<Vec<[f32; 3]>> {
        smooth_normals(&self.mesh.positions, &self.mesh.faces)
    }
}

/// For each vertex the first vertex at the same place.
fn weld(positions: &[[f32; 3]]) -> Vec<usize> {
    let mut first = HashMap::with_capacity(positions.len());
    // Adding 0 makes one zero of the two.
    let key = |p: &[f32; 3]| p.map(|c| (c + 0.0).to_bits());
    positions.iter().enumerate().map(|(i, p)| *first.entry(key(p)).or_insert(i)).collect()
}

impl Frame {
    /// The coordinates (x, y, z) for which x T + y B + z N points along a vector: what a shader that adds the
    /// three up needs to find. `None` where the frame is flat.
    pub fn coordinates(&self, v: DVec3) -> Option<DVec3> {
        let cross = [
            self.bitangent.cross(self.normal),
            self.normal.cross(self.tangent),
            self.tangent.cross(self.bitangent),
        ];
        let det = self.tangent.dot(cross[0]);
        let size = self.tangent.length() * self.bitangent.length() * self.normal.length();
        if det.abs() <= 1e-12 * size {
            return None;
        }
        DVec3::from_array(cross.map(|c| c.dot(v) / det)).try_normalize()
    }
}
