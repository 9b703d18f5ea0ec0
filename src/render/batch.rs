//! Pixels of one material, gathered so that each texture is sampled in one call.

use crate::jacobian::Jacobian;
use crate::mesh::{Mesh, TextureSlot};
use crate::raster::Weights;
use glam::Vec3;

/// Pixels of a tile that show one material.
#[derive(Debug, Default)]
pub(super) struct Batch {
    /// Pixels, counted from the tile's first.
    pub pixel: Vec<u32>,
    /// Their faces in the mesh.
    pub face: Vec<u32>,
    weights: Vec<Weights>,
}

/// A vector with its change for one pixel right and one pixel down.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moving {
    pub at: Vec3,
    pub dx: Vec3,
    pub dy: Vec3,
}

/// Where a texture is read: two numbers and four derivatives a pixel.
#[derive(Debug, Default)]
pub(super) struct Places {
    pub uv: Vec<f64>,
    pub jacobian: Vec<f64>,
}

impl Places {
    /// The Jacobian of pixel `i`.
    pub fn jacobian(&self, i: usize) -> Jacobian {
        let j = &self.jacobian[4 * i..];
        Jacobian::new([[j[0], j[1]], [j[2], j[3]]])
    }
}

impl Batch {
    /// Adds a pixel.
    pub fn push(&mut self, pixel: usize, face: usize, weights: &Weights) {
        self.pixel.push(pixel as u32);
        self.face.push(face as u32);
        self.weights.push(*weights);
    }

    pub fn len(&self) -> usize {
        self.pixel.len()
    }

    /// A vertex attribute of N numbers at pixel `i`.
    #[inline]
    fn blend<const N: usize>(&self, mesh: &Mesh, list: &[[f32; N]], i: usize) -> [f32; N] {
        let corners = mesh.faces[self.face[i] as usize].map(|v| list[v as usize]);
        let b = &self.weights[i].b;
        std::array::from_fn(|k| {
            let [v0, v1, v2] = corners.map(|c| f64::from(c[k]));
            (v0 + b[1] * (v1 - v0) + b[2] * (v2 - v0)) as f32
        })
    }

    /// A vertex attribute of three numbers, with its derivatives.
    pub fn vector(&self, mesh: &Mesh, list: &[[f32; 3]], i: usize) -> Moving {
        let corners = mesh.faces[self.face[i] as usize].map(|v| list[v as usize]);
        let Weights { b, db } = &self.weights[i];
        let mut out = [[0f32; 3]; 3];
        for k in 0..3 {
            let [v0, v1, v2] = corners.map(|c| f64::from(c[k]));
            let (e1, e2) = (v1 - v0, v2 - v0);
            out[0][k] = (v0 + b[1] * e1 + b[2] * e2) as f32;
            out[1][k] = (db[0][0] * e1 + db[1][0] * e2) as f32;
            out[2][k] = (db[0][1] * e1 + db[1][1] * e2) as f32;
        }
        Moving { at: out[0].into(), dx: out[1].into(), dy: out[2].into() }
    }

    /// The tangent of pixel `i`, and the sign of its bitangent.
    pub fn tangent(&self, mesh: &Mesh, i: usize) -> (Vec3, f32) {
        let [x, y, z, w] = self.blend(mesh, &mesh.tangents, i);
        (Vec3::new(x, y, z), if w < 0.0 { -1.0 } else { 1.0 })
    }

    /// The vertex colour of pixel `i`, white where the mesh has none.
    pub fn color(&self, mesh: &Mesh, i: usize) -> [f32; 4] {
        if mesh.colors.is_empty() { [1.0; 4] } else { self.blend(mesh, &mesh.colors, i) }
    }

    /// The normal of the face of pixel `i`, of any length; its corners run counter-clockwise around it.
    pub fn face_normal(&self, mesh: &Mesh, i: usize) -> Vec3 {
        let [a, b, c] = mesh.faces[self.face[i] as usize].map(|v| Vec3::from(mesh.positions[v as usize]));
        let (e1, e2) = (b - a, c - a);
        // Faces can be tiny: no product of their sides may vanish.
        let scale = e1.abs().max_element().max(e2.abs().max_element());
        if scale > 0.0 { (e1 / scale).cross(e2 / scale) } else { Vec3::ZERO }
    }

    /// Where a slot reads its texture. Meshes without the uv set are read at (0, 0).
    pub fn places(&self, mesh: &Mesh, slot: &TextureSlot) -> Places {
        let mut out =
            Places { uv: Vec::with_capacity(2 * self.len()), jacobian: Vec::with_capacity(4 * self.len()) };
        let Some(list) = mesh.uv.get(slot.uv_set) else {
            out.uv.resize(2 * self.len(), 0.0);
            out.jacobian.resize(4 * self.len(), 0.0);
            return out;
        };
        let [[a, b, c], [d, e, f]] = slot.transform.map(|row| row.map(f64::from));
        for (&face, Weights { b: w, db }) in self.face.iter().zip(&self.weights) {
            let corners = mesh.faces[face as usize].map(|v| list[v as usize].map(f64::from));
            let [u0, v0] = corners[0];
            let [e1, e2] = [1, 2].map(|k: usize| [corners[k][0] - u0, corners[k][1] - v0]);
            let (u, v) = (u0 + w[1] * e1[0] + w[2] * e2[0], v0 + w[1] * e1[1] + w[2] * e2[1]);
            let j: [[f64; 2]; 2] = std::array::from_fn(|i| {
                std::array::from_fn(|axis| db[0][axis] * e1[i] + db[1][axis] * e2[i])
            });
            out.uv.extend([a * u + b * v + c, d * u + e * v + f]);
            let moved = Jacobian::new([[a, b], [d, e]]).after(Jacobian::new(j)).m;
            out.jacobian.extend(moved.as_flattened());
        }
        out
    }
}
