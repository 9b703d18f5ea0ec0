//! Pixels of one material, gathered so that each texture is sampled in one call.

use crate::jacobian::Jacobian;
use crate::mesh::{Mesh, TextureSlot};
use crate::raster::{Geometry, Pair, Planes, Weights};
use glam::Vec3;
use std::ops::Range;

/// Pixels that show one material, in runs along rows.
#[derive(Debug, Default)]
pub(super) struct Batch {
    faces: Vec<Face>,
    runs: Vec<Run>,
    len: usize,
}

/// A face that is seen, whatever the number of its runs.
#[derive(Clone, Debug)]
struct Face {
    index: usize,
    planes: Planes,
}

/// Neighbouring pixels of a row that show one face.
#[derive(Clone, Debug)]
struct Run {
    /// The first one's place in the slice of the picture that is drawn.
    pixel: u32,
    /// Columns.
    x: Range<u32>,
    y: u32,
    /// Position in `faces`.
    face: u32,
}

impl Run {
    fn columns(&self) -> Range<usize> {
        self.x.start as usize..self.x.end as usize
    }
}

/// A pixel on a face of the mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    pub face: usize,
    weights: Weights,
}

/// A vector with its change for one pixel right and one pixel down.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moving {
    pub at: Vec3,
    pub dx: Vec3,
    pub dy: Vec3,
}

/// Where a texture is read.
#[derive(Debug, Default)]
pub(super) struct Places {
    pub uv: Vec<[f64; 2]>,
    /// du/dx, du/dy, dv/dx, dv/dy.
    pub jacobian: Vec<[f64; 4]>,
}

impl Places {
    /// The Jacobian of pixel `i`.
    pub fn jacobian(&self, i: usize) -> Jacobian {
        let [a, b, c, d] = self.jacobian[i];
        Jacobian::new([[a, b], [c, d]])
    }
}

impl Batch {
    /// Adds face `index`, whose planes are those of face `drawn` of a geometry about one of its pixels in a picture of `size`,
    /// and tells its number.
    #[inline(always)]
    pub fn add(
        &mut self,
        index: usize,
        (geometry, drawn): (&Geometry, usize),
        pixel: [usize; 2],
        size: (usize, usize),
    ) -> u32 {
        self.faces.push(Face { index, planes: Planes::of(geometry, drawn, pixel, size) });
        self.faces.len() as u32 - 1
    }

    /// Adds pixels of row `y` in the columns `x`, the first of which is number `pixel` of the slice, to a face of this number.
    #[inline]
    pub fn push(&mut self, pixel: usize, x: Range<usize>, y: usize, face: u32) {
        self.len += x.len();
        self.runs.push(Run { pixel: pixel as u32, x: x.start as u32..x.end as u32, y: y as u32, face });
    }

    /// Takes everything out.
    pub fn clear(&mut self) {
        self.faces.clear();
        self.runs.clear();
        self.len = 0;
    }

    /// Pixels.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Numbers of the pixels in the slice.
    pub fn pixels(&self) -> impl Iterator<Item = usize> {
        self.runs.iter().flat_map(|run| run.pixel as usize..run.pixel as usize + run.x.len())
    }

    /// The pixels' places on the mesh.
    pub fn spots(&self) -> impl Iterator<Item = Spot> {
        self.runs.iter().flat_map(|run| {
            let Face { index, planes } = &self.faces[run.face as usize];
            let y = run.y as usize;
            run.columns().map(move |x| Spot { face: *index, weights: planes.at(x, y) })
        })
    }

    /// Where a slot reads its texture. Meshes without the uv set are read at (0, 0).
    pub fn places(&self, mesh: &Mesh, slot: &TextureSlot) -> Places {
        let mut out = Places { uv: vec![[0.0; 2]; self.len], jacobian: vec![[0.0; 4]; self.len] };
        let Some(list) = mesh.uv.get(slot.uv_set) else { return out };
        let transform = slot.transform.map(|row| row.map(f64::from));
        let is_plain = slot.transform == TextureSlot::IDENTITY;
        let corners = |face: usize| {
            mesh.faces[face].map(|v| {
                let [u, v] = list[v as usize].map(f64::from);
                if is_plain { [u, v] } else { transform.map(|[a, b, c]| a * u + b * v + c) }
            })
        };
        let pairs: Vec<Pair> = self.faces.iter().map(|f| f.planes.pair(corners(f.index))).collect();
        let (mut uv, mut jacobian) = (&mut out.uv[..], &mut out.jacobian[..]);
        for run in &self.runs {
            let (own_uv, own_jacobian);
            (own_uv, uv) = uv.split_at_mut(run.x.len());
            (own_jacobian, jacobian) = jacobian.split_at_mut(run.x.len());
            let (Face { index, planes }, pair) = (&self.faces[run.face as usize], &pairs[run.face as usize]);
            let (x, y) = (run.columns(), run.y as usize);
            planes.fill(pair, || corners(*index), x, y, own_uv, own_jacobian);
        }
        out
    }
}

impl Spot {
    /// A vertex attribute of N numbers.
    #[inline]
    fn blend<const N: usize>(&self, mesh: &Mesh, list: &[[f32; N]]) -> [f32; N] {
        let corners = mesh.faces[self.face].map(|v| list[v as usize]);
        let b = &self.weights.b;
        std::array::from_fn(|k| {
            let [v0, v1, v2] = corners.map(|c| f64::from(c[k]));
            (v0 + b[1] * (v1 - v0) + b[2] * (v2 - v0)) as f32
        })
    }

    /// A vertex attribute of three numbers, with its derivatives.
    pub fn vector(&self, mesh: &Mesh, list: &[[f32; 3]]) -> Moving {
        let corners = mesh.faces[self.face].map(|v| list[v as usize]);
        let Weights { b, db } = &self.weights;
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

    /// The normal as it is interpolated.
    pub fn normal(&self, mesh: &Mesh) -> Vec3 {
        self.blend(mesh, &mesh.normals).into()
    }

    /// The tangent, and the sign of its bitangent.
    pub fn tangent(&self, mesh: &Mesh) -> (Vec3, f32) {
        let [x, y, z, w] = self.blend(mesh, &mesh.tangents);
        (Vec3::new(x, y, z), if w < 0.0 { -1.0 } else { 1.0 })
    }

    /// The vertex colour, white where the mesh has none.
    pub fn color(&self, mesh: &Mesh) -> [f32; 4] {
        if mesh.colors.is_empty() { [1.0; 4] } else { self.blend(mesh, &mesh.colors) }
    }

    /// The normal of the face, of any length; its corners run counter-clockwise around it.
    pub fn face_normal(&self, mesh: &Mesh) -> Vec3 {
        let [a, b, c] = mesh.faces[self.face].map(|v| Vec3::from(mesh.positions[v as usize]));
        let (e1, e2) = (b - a, c - a);
        // Faces can be tiny: no product of their sides may vanish.
        let scale = e1.abs().max_element().max(e2.abs().max_element());
        if scale > 0.0 { (e1 / scale).cross(e2 / scale) } else { Vec3::ZERO }
    }
}
