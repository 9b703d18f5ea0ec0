//! Displacement: vertices moved along their normals by a height map, after faces have been cut so small that no edge
//! is longer in the picture than so many pixels.
//!
//! ```text
//! pass by pass   every edge that is too long gets a vertex in its middle; a face with 1, 2 or 3 of them
//!                becomes 2, 3 or 4
//! then           p' = p + (scale h(u, v) + offset) n
//! ```
//!
//! Whether an edge is too long depends on its two places alone, so faces on both sides of it agree and no cracks open;
//! vertices of one place (seams of uv, creases) move by the mean of their movements and stay together. Heights are
//! averaged over the distance between neighbouring vertices, so a map finer than the faces does not alias. Normals are
//! made anew from the moved faces, with the old creases.
//!
//! Cook, "Shade trees", SIGGRAPH 1984 (displacement); Cook, Carpenter and Catmull, "The Reyes image rendering
//! architecture", SIGGRAPH 1987 (surfaces cut to the size of pixels).

use super::View;
use super::textures::Use;
use crate::error::{Error, Result};
use crate::filter::Filter;
use crate::mesh::{Camera, MAX_ELEMENTS, Mesh, Projection, TextureSlot, grouped_normals};
use crate::sampler::{Extent, Sampler};
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// Passes at most: an edge is halved so often.
const PASSES: usize = 24;

/// The mesh with its displacement maps carried out for a picture of `size` by this camera, edges at most `edge_px` long;
/// `None` where no material has such a map.
///
/// # Errors
/// [`Error::Value`] for a length that is not positive, and for more than [`MAX_ELEMENTS`] faces; errors of reading
/// textures.
pub fn displaced(view: &View<'_>, size: (usize, usize), edge_px: f64) -> Result<Option<Mesh>> {
    if !(edge_px >= 0.1 && edge_px.is_finite()) {
        return Err(Error::value("displacement_edge", edge_px, "pixels, at least 0.1"));
    }
    let moves = |m: &u32| view.mesh.materials[*m as usize].displacement_texture.is_some();
    if !view.mesh.face_material.iter().any(moves) {
        return Ok(None);
    }
    let lens = Lens::new(view.camera, size, edge_px);
    let mut mesh = view.mesh.clone();
    for _ in 0..PASSES {
        if !split(&mut mesh, &lens)? {
            break;
        }
    }
    shift(view, &mut mesh)?;
    Ok(Some(mesh))
}

/// Lengths in pixels.
struct Lens {
    eye: DVec3,
    back: DVec3,
    /// Pixels of a length of 1 at the distance 1, or anywhere for parallel rays.
    scale: f64,
    is_parallel: bool,
    near: f64,
    limit: f64,
}

impl Lens {
    fn new(camera: &Camera, (width, height): (usize, usize), limit: f64) -> Self {
        let m = camera.matrix(width, height);
        // The second row of the matrix is the camera's y axis times its scale in half heights.
        let scale = 0.5 * height as f64 * DVec3::new(m[1][0], m[1][1], m[1][2]).length();
        let back = camera.view[2];
        let (is_parallel, near) = match camera.projection {
            Projection::Perspective { near, .. } => (false, near),
            Projection::Orthographic { near, .. } => (true, near),
        };
        let back = DVec3::new(back[0], back[1], back[2]);
        Self { eye: camera.eye().into(), back, scale, is_parallel, near, limit }
    }

    /// Whether an edge is too long. Edges that lie behind the eye are not.
    fn is_long(&self, a: [f32; 3], b: [f32; 3]) -> bool {
        let [a, b] = [a, b].map(|p| DVec3::from(p.map(f64::from)));
        let length = a.distance(b) * self.scale;
        if self.is_parallel {
            return length > self.limit;
        }
        let depth = [a, b].map(|p| self.back.dot(self.eye - p));
        let nearest = depth[0].min(depth[1]).max(self.near);
        depth[0].max(depth[1]) > 0.0 && length > self.limit * nearest
    }
}

/// One pass over the faces of displaced materials, and over the edges that others share with them.
fn split(mesh: &mut Mesh, lens: &Lens) -> Result<bool> {
    let place = |p: [f32; 3]| p.map(|c| (c + 0.0).to_bits());
    let between = |a: [f32; 3], b: [f32; 3]| {
        let (a, b) = (place(a), place(b));
        if a < b { (a, b) } else { (b, a) }
    };
    let moves: Vec<bool> = mesh.materials.iter().map(|m| m.displacement_texture.is_some()).collect();
    // Edges that faces of displaced materials cut, by their places: their neighbours must be cut as well.
    let mut cut = std::collections::HashSet::new();
    for (face, &m) in mesh.faces.iter().zip(&mesh.face_material) {
        for k in 0..3 {
            let [a, b] = [face[k], face[(k + 1) % 3]].map(|v| mesh.positions[v as usize]);
            if moves[m as usize] && lens.is_long(a, b) {
                cut.insert(between(a, b));
            }
        }
    }
    if cut.is_empty() {
        return Ok(false);
    }
    let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
    let (old_faces, old_materials) =
        (std::mem::take(&mut mesh.faces), std::mem::take(&mut mesh.face_material));
    let mut faces = Vec::with_capacity(old_faces.len() * 3);
    let mut materials = Vec::with_capacity(faces.capacity());
    for (face, m) in old_faces.into_iter().zip(old_materials) {
        let middle: [Option<u32>; 3] = std::array::from_fn(|k| {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            let places = between(mesh.positions[a as usize], mesh.positions[b as usize]);
            let key = (a.min(b), a.max(b));
            cut.contains(&places).then(|| *middles.entry(key).or_insert_with(|| add_middle(mesh, key)))
        });
        let before = faces.len();
        cut_face(mesh, face, middle, &mut faces);
        materials.resize(materials.len() + faces.len() - before, m);
        if faces.len() > MAX_ELEMENTS || mesh.positions.len() > MAX_ELEMENTS {
            let expected = format!("at most {MAX_ELEMENTS} faces; longer edges need fewer");
            return Err(Error::value("displacement_edge", lens.limit, expected));
        }
    }
    (mesh.faces, mesh.face_material) = (faces, materials);
    Ok(true)
}

/// The parts of a face with vertices in the middle of some of its edges.
fn cut_face(mesh: &Mesh, face: [u32; 3], middle: [Option<u32>; 3], out: &mut Vec<[u32; 3]>) {
    let turn = |k: usize| ([0, 1, 2].map(|i| face[(i + k) % 3]), [0, 1, 2].map(|i| middle[(i + k) % 3]));
    match middle.iter().flatten().count() {
        0 => out.push(face),
        1 => {
            let k = middle.iter().position(Option::is_some).unwrap_or(0);
            let ([a, b, c], [m, ..]) = turn(k);
            let m = m.unwrap_or(a);
            out.extend([[a, m, c], [m, b, c]]);
        }
        2 => {
            // Turned so that the whole edge is the last, from c to a.
            let k = middle.iter().position(Option::is_none).unwrap_or(0) + 1;
            let ([a, b, c], [m, n, _]) = turn(k % 3);
            let (m, n) = (m.unwrap_or(a), n.unwrap_or(b));
            out.push([m, b, n]);
            // Of the two diagonals of the rest the shorter.
            let far = |i: u32, j: u32| {
                let [p, q] = [i, j].map(|v| Vec3::from(mesh.positions[v as usize]));
                p.distance_squared(q)
            };
            if far(a, n) <= far(m, c) {
                out.extend([[a, m, n], [a, n, c]]);
            } else {
                out.extend([[a, m, c], [m, n, c]]);
            }
        }
        _ => {
            let ([a, b, c], [m, n, o]) = turn(0);
            let (m, n, o) = (m.unwrap_or(a), n.unwrap_or(b), o.unwrap_or(c));
            out.extend([[a, m, o], [m, b, n], [o, n, c], [m, n, o]]);
        }
    }
}

/// A vertex in the middle of an edge; the same numbers whichever way the edge runs.
fn add_middle(mesh: &mut Mesh, (a, b): (u32, u32)) -> u32 {
    let (a, b) = (a as usize, b as usize);
    fn mean<const N: usize>(list: &mut Vec<[f32; N]>, a: usize, b: usize) {
        let [p, q] = [list[a], list[b]];
        list.push(std::array::from_fn(|k| 0.5 * p[k] + 0.5 * q[k]));
    }
    let index = mesh.positions.len() as u32;
    mean(&mut mesh.positions, a, b);
    mean(&mut mesh.normals, a, b);
    let [p, q] = [a, b].map(|v| mesh.normals[v]);
    if let Some(n) = Vec3::from(mesh.normals[index as usize]).try_normalize() {
        mesh.normals[index as usize] = n.to_array();
    } else {
        mesh.normals[index as usize] = if p < q { p } else { q };
    }
    mean(&mut mesh.tangents, a, b);
    mesh.tangents[index as usize][3] = mesh.tangents[a][3];
    for set in &mut mesh.uv {
        mean(set, a, b);
    }
    if !mesh.colors.is_empty() {
        mean(&mut mesh.colors, a, b);
    }
    index
}

/// Moves the vertices.
fn shift(view: &View<'_>, mesh: &mut Mesh) -> Result<()> {
    let count = mesh.positions.len();
    // Vertices of one place move together; those that share a normal too will share one again.
    let mut places = HashMap::with_capacity(count);
    let mut creases = HashMap::with_capacity(count);
    let bits = |v: [f32; 3]| v.map(|c| (c + 0.0).to_bits());
    let (mut group, mut crease) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for (i, (p, n)) in mesh.positions.iter().zip(&mesh.normals).enumerate() {
        group.push(*places.entry(bits(*p)).or_insert(i));
        crease.push(*creases.entry((bits(*p), bits(*n))).or_insert(i));
    }
    let mut moves = vec![(DVec3::ZERO, 0u32); count];
    let mut still = vec![false; count];
    for (index, material) in mesh.materials.iter().enumerate() {
        let own = mesh.faces.iter().zip(&mesh.face_material).filter(|(_, m)| **m as usize == index);
        let Some(slot) = &material.displacement_texture else {
            // Where a surface that stays meets one that moves, both stay.
            own.for_each(|(face, _)| face.iter().for_each(|&v| still[group[v as usize]] = true));
            continue;
        };
        let heights = heights(view, mesh, slot, own.map(|(face, _)| *face))?;
        for (v, height) in heights {
            let d = f64::from(material.displacement_scale * height + material.displacement_offset);
            let sum = &mut moves[group[v]];
            sum.0 += DVec3::from(mesh.normals[v].map(f64::from)) * d;
            sum.1 += 1;
        }
    }
    for (p, &g) in mesh.positions.iter_mut().zip(&group) {
        let (sum, n) = moves[g];
        if n > 0 && !still[g] {
            let moved = DVec3::from(p.map(f64::from)) + sum / f64::from(n);
            *p = moved.as_vec3().to_array();
        }
    }
    let made = grouped_normals(&mesh.positions, &mesh.faces, &crease);
    for (i, n) in made.into_iter().enumerate() {
        if moves[group[i]].1 == 0 || still[group[i]] {
            continue;
        }
        mesh.normals[i] = n;
        let [x, y, z, w] = mesh.tangents[i];
        let (n, t) = (Vec3::from(n), Vec3::new(x, y, z));
        let t = (t - n * n.dot(t)).try_normalize().unwrap_or_else(|| n.any_orthonormal_vector());
        mesh.tangents[i] = [t.x, t.y, t.z, w];
    }
    Ok(())
}

/// The height at each vertex of some faces, averaged over a square as wide as the mean of its edges in uv.
fn heights(
    view: &View<'_>,
    mesh: &Mesh,
    slot: &TextureSlot,
    faces: impl Iterator<Item = [u32; 3]>,
) -> Result<Vec<(usize, f32)>> {
    let sampler = Sampler::new(Filter::Area);
    let texture = view.textures.get(view.mesh, slot, Use::Data, &sampler)?;
    let [[a, b, c], [d, e, f]] = slot.transform.map(|row| row.map(f64::from));
    let uv = |v: u32| {
        let [u, v] = mesh.uv.get(slot.uv_set).map_or([0.0; 2], |set| set[v as usize]).map(f64::from);
        [a * u + b * v + c, d * u + e * v + f]
    };
    let mut edges = vec![(0f64, 0u32); mesh.positions.len()];
    for face in faces {
        for k in 0..3 {
            let (i, j) = (face[k], face[(k + 1) % 3]);
            let ([u0, v0], [u1, v1]) = (uv(i), uv(j));
            let length = (u1 - u0).hypot(v1 - v0);
            for v in [i, j] {
                edges[v as usize].0 += length;
                edges[v as usize].1 += 1;
            }
        }
    }
    let own: Vec<usize> = (0..edges.len()).filter(|&v| edges[v].1 > 0).collect();
    let places: Vec<f64> = own.iter().flat_map(|&v| uv(v as u32)).collect();
    let widths = own.iter().flat_map(|&v| {
        let width = edges[v].0 / f64::from(edges[v].1);
        [width, 0.0, 0.0, width]
    });
    let mut out = vec![0f32; own.len() * texture.channels()];
    sampler.sample(&texture, &places, Extent::Jacobian(&widths.collect::<Vec<_>>()), &mut out)?;
    Ok(own.into_iter().zip(out.chunks_exact(texture.channels()).map(|t| t[0])).collect())
}
