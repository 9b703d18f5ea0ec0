//! Fewer triangles for the same shape, by meshoptimizer's quadric error metrics.
//!
//! Garland and Heckbert, "Surface simplification using quadric error metrics" and "Simplifying surfaces with
//! color and texture using quadric error metrics", 1997 and 1998. Edges collapse onto one of their ends, so the
//! vertices that stay are vertices that were there, with their texture coordinates and colours. Where texture
//! coordinates, colours or materials part, both sides collapse alike: cuts stay cuts, and nothing tears. Folds are
//! then taken out by swapping edges.

use super::Mesh;
use super::normals::{Normals, smooth_normals};
use super::unfold::{Vertices, unfold};
use crate::error::{Error, Result};
use meshopt::{SimplifyOptions, simplify_with_attributes_and_locks_decoder};
use std::collections::HashMap;

/// Vertices at places that differ by less are at one place, in sides of the box around the mesh.
const SAME_PLACE: f64 = 1e-6;
/// What a change of colour by 1 counts, in sides of the box around the mesh.
const COLOR_WEIGHT: f32 = 0.1;
/// No error is too large: the number of faces decides.
const ANY_ERROR: f32 = 1e18;

impl Mesh {
    /// The mesh with about `ratio` of its faces. Normals and tangents are made anew, smooth ones; all else is
    /// that of the vertices and faces that stay.
    ///
    /// An error in the first texture coordinates counts like the way on the surface that it stands for, on the
    /// mean of the mesh.
    ///
    /// # Errors
    /// [`Error::Value`] when the mesh is not what [`Mesh::check`] asks for, the ratio is not above 0 and at
    /// most 1, or no face would be left.
    ///
    /// ```
    /// use multum::mesh::Mesh;
    /// // A flat grid of 8 x 8 squares needs two triangles.
    /// let place = |i: u32| [(i % 9) as f32, (i / 9) as f32, 0.0];
    /// let corner = |i: u32| i % 8 + i / 8 * 9;
    /// let mesh = Mesh {
    ///     positions: (0..81).map(place).collect(),
    ///     faces: (0..64).flat_map(|i| [[0, 1, 10], [0, 10, 9]].map(|f| f.map(|k| corner(i) + k))).collect(),
    ///     ..Mesh::default()
    /// };
    /// let simple = mesh.completed(Default::default())?.simplified(1.0 / 64.0)?;
    /// assert_eq!((simple.faces.len(), simple.positions.len()), (2, 4));
    /// # Ok::<(), multum::Error>(())
    /// ```
    pub fn simplified(&self, ratio: f64) -> Result<Self> {
        self.check()?;
        if !(ratio > 0.0 && ratio <= 1.0) {
            return Err(Error::value("ratio", ratio, "a number above 0 and at most 1"));
        }
        let Some([low, high]) = self.bounds() else { return Ok(self.clone()) };
        let wanted = ((ratio * self.faces.len() as f64).round() as usize).max(1);
        let extent = (0..3).map(|k| f64::from(high[k]) - f64::from(low[k])).fold(0.0, f64::max);
        let shared = Shared::new(self, &places(&self.positions, extent));
        if wanted >= shared.faces.len() {
            return Ok(self.clone());
        }
        let unit = |p: [f32; 3]| -> [f32; 3] {
            std::array::from_fn(|k| ((f64::from(p[k]) - f64::from(low[k])) / extent) as f32)
        };
        let positions: Vec<[f32; 3]> = shared.places.iter().map(|&v| unit(self.positions[v])).collect();
        let (attributes, weights) = self.attributes(&shared, extent);
        let kept = simplify_with_attributes_and_locks_decoder(
            shared.faces.as_flattened(),
            &positions,
            &attributes,
            &weights,
            size_of_val(&weights[..]),
            &vec![false; positions.len()],
            3 * wanted,
            ANY_ERROR,
            SimplifyOptions::None,
            None,
        );
        if kept.is_empty() {
            return Err(Error::value("ratio", ratio, "a number that leaves a face"));
        }
        let mut kept = kept.as_chunks().0.to_vec();
        let normals = smooth_normals(&self.positions, &self.faces)?;
        let uv: Option<Vec<_>> = self.uv.first().map(|set| shared.vertices.iter().map(|&v| set[v]).collect());
        let vertices = Vertices {
            positions: &positions,
            normals: &shared.places.iter().map(|&v| normals[v]).collect::<Vec<_>>(),
            uv: uv.as_deref(),
        };
        unfold(&vertices, &mut kept);
        self.part_of(&shared, &kept)
    }

    /// What else than places is to be kept, as numbers a vertex, and what each counts.
    fn attributes(&self, shared: &Shared, extent: f64) -> (Vec<f32>, Vec<f32>) {
        let mut columns: Vec<(f32, Vec<f32>)> = Vec::new();
        if let Some(uv) = self.uv.first() {
            let weight = self.length_of_uv(uv, extent) as f32;
            columns.extend((0..2).map(|k| (weight, shared.vertices.iter().map(|&v| uv[v][k]).collect())));
        }
        if !self.colors.is_empty() {
            let channel = |k: usize| shared.vertices.iter().map(|&v| self.colors[v][k]).collect();
            columns.extend((0..4).map(|k| (COLOR_WEIGHT, channel(k))));
        }
        // Numbers without a finite square would make every error infinite.
        columns.retain(|(weight, column)| *weight > 0.0 && column.iter().all(|x| x.abs() < 1e15));
        let rows = (0..shared.vertices.len()).flat_map(|v| columns.iter().map(move |(_, column)| column[v]));
        (rows.collect(), columns.iter().map(|(weight, _)| *weight).collect())
    }

    /// The way on the surface, in sides of the box around it, for which uv change by 1, on the mean.
    fn length_of_uv(&self, uv: &[[f32; 2]], extent: f64) -> f64 {
        let [mut surface, mut texture] = [0.0; 2];
        for face in &self.faces {
            let [a, b, c] = face.map(|v| self.positions[v as usize].map(|x| f64::from(x) / extent));
            let [e, f]: [[f64; 3]; 2] = [b, c].map(|p| std::array::from_fn(|k| p[k] - a[k]));
            let normal: [f64; 3] = std::array::from_fn(|k| {
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                e[i] * f[j] - e[j] * f[i]
            });
            surface += normal.iter().map(|n| n * n).sum::<f64>().sqrt();
            let [a, b, c] = face.map(|v| uv[v as usize].map(f64::from));
            texture += ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs();
        }
        let length = (surface / texture).sqrt();
        if length.is_finite() { length.min(1e6) } else { 0.0 }
    }

    /// The mesh of some of its shared faces.
    fn part_of(&self, shared: &Shared, kept: &[[u32; 3]]) -> Result<Self> {
        let mut order = vec![u32::MAX; shared.vertices.len()];
        let mut used = Vec::new();
        let mut faces = Vec::with_capacity(kept.len());
        for face in kept {
            faces.push(face.map(|v| {
                if order[v as usize] == u32::MAX {
                    order[v as usize] = used.len() as u32;
                    used.push(v as usize);
                }
                order[v as usize]
            }));
        }
        let vertices = || used.iter().map(|&v| shared.vertices[v]);
        Self {
            positions: used.iter().map(|&v| self.positions[shared.places[v]]).collect(),
            uv: self.uv.iter().map(|set| vertices().map(|v| set[v]).collect()).collect(),
            colors: if self.colors.is_empty() {
                Vec::new()
            } else {
                vertices().map(|v| self.colors[v]).collect()
            },
            faces,
            face_material: kept.iter().map(|face| shared.materials[face[0] as usize]).collect(),
            materials: self.materials.clone(),
            images: self.images.clone(),
            ..Self::default()
        }
        .completed(Normals::Smooth)
    }
}

/// Faces over vertices that are one where place, texture coordinates, colour and material are.
struct Shared {
    faces: Vec<[u32; 3]>,
    /// A vertex of the mesh with these coordinates and this colour.
    vertices: Vec<usize>,
    /// A vertex of the mesh at this place: the same for all at one place.
    places: Vec<usize>,
    materials: Vec<u32>,
}

impl Shared {
    fn new(mesh: &Mesh, places: &[usize]) -> Self {
        let mut made =
            Self { faces: Vec::new(), vertices: Vec::new(), places: Vec::new(), materials: Vec::new() };
        let mut known: HashMap<Vec<u32>, u32> = HashMap::new();
        // Adding 0 makes one zero of the two.
        let bits = |x: &f32| (x + 0.0).to_bits();
        for (face, &material) in mesh.faces.iter().zip(&mesh.face_material) {
            let [a, b, c] = face.map(|v| places[v as usize]);
            if a == b || b == c || c == a {
                continue;
            }
            made.faces.push(face.map(|v| {
                let v = v as usize;
                let mut key = vec![places[v] as u32, material];
                key.extend(mesh.uv.iter().flat_map(|set| &set[v]).map(bits));
                key.extend(mesh.colors.get(v).into_iter().flatten().map(bits));
                *known.entry(key).or_insert_with(|| {
                    made.vertices.push(v);
                    made.places.push(places[v]);
                    made.materials.push(material);
                    made.vertices.len() as u32 - 1
                })
            }));
        }
        made
    }
}

/// For each vertex the first at its place. Places that differ by rounding are one: along each axis, values
/// without a gap. Cracks would tear the mesh open.
fn places(positions: &[[f32; 3]], extent: f64) -> Vec<usize> {
    // In large meshes unlike values come close to each other by chance: a twentieth of their mean distance.
    let gap = extent * SAME_PLACE.min(0.05 / positions.len().max(1) as f64);
    let mut groups = vec![[0u32; 3]; positions.len()];
    let mut order: Vec<usize> = (0..positions.len()).collect();
    for axis in 0..3 {
        order.sort_by(|&a, &b| positions[a][axis].total_cmp(&positions[b][axis]));
        let mut group = 0;
        for pair in order.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(|v| f64::from(positions[v][axis]));
            group += u32::from(b - a > gap);
            groups[pair[1]][axis] = group;
        }
    }
    let mut first = HashMap::with_capacity(positions.len());
    groups.into_iter().enumerate().map(|(i, group)| *first.entry(group).or_insert(i)).collect()
}
