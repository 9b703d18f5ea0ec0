//! Tangents by the MikkTSpace method, which bakers of normal maps use: a renderer must use the same frames.
//!
//! Mikkelsen, "Simulation of wrinkled surfaces revisited", 2008. The method gives a frame to each corner;
//! corners that share a vertex but not the frame (mirrored uv) split the vertex.

use super::Part;
use super::normals::any_tangent;
use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use std::collections::HashMap;

struct Corners<'a> {
    part: &'a Part,
    normals: &'a [[f32; 3]],
    uv: &'a [[f32; 2]],
    tangents: Vec<[f32; 4]>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.part.faces[face][corner] as usize
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.part.faces.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.part.positions[self.vertex(face, corner)]
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.normals[self.vertex(face, corner)]
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        // The method's v runs up, so that green of a normal map is up in the picture.
        let [u, v] = self.uv[self.vertex(face, corner)];
        [u, 1.0 - v]
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        let normal = self.normals[self.vertex(face, corner)];
        let found = space.map(|space| space.tangent_encoded());
        let usable = found.filter(|t| t.iter().all(|c| c.is_finite()) && t[..3].iter().any(|&c| c != 0.0));
        self.tangents[face * 3 + corner] = usable.unwrap_or_else(|| frame(normal));
    }
}

fn frame(normal: [f32; 3]) -> [f32; 4] {
    let [x, y, z] = any_tangent(normal);
    [x, y, z, 1.0]
}

/// Gives tangents to a part that has normals, by one of its uv sets if it has that.
pub(super) fn complete(part: &mut Part, set: usize) {
    let Some(normals) = &part.normals else { return };
    let Some(uv) = part.uv.get(set).or_else(|| part.uv.first()) else {
        part.tangents = Some(normals.iter().map(|&n| frame(n)).collect());
        return;
    };
    let tangents = vec![[0.0; 4]; part.faces.len() * 3];
    let mut corners = Corners { part, normals, uv, tangents };
    let Ok(()) = generate_tangents(&mut corners) else {
        part.tangents = Some(normals.iter().map(|&n| frame(n)).collect());
        return;
    };
    let corner_tangents = corners.tangents;
    // The first frame of a vertex stays with it, each other one makes a vertex of its own.
    let mut source: Vec<usize> = (0..part.positions.len()).collect();
    let mut tangents: Vec<Option<[f32; 4]>> = vec![None; source.len()];
    let mut split: HashMap<(u32, [u32; 4]), u32> = HashMap::new();
    for (vertex, tangent) in part.faces.iter_mut().flatten().zip(corner_tangents) {
        let slot = &mut tangents[*vertex as usize];
        if slot.is_none_or(|t| t == tangent) {
            *slot = Some(tangent);
            continue;
        }
        *vertex = *split.entry((*vertex, tangent.map(f32::to_bits))).or_insert_with(|| {
            source.push(*vertex as usize);
            tangents.push(Some(tangent));
            tangents.len() as u32 - 1
        });
    }
    part.select(&source);
    let normals = part.normals.as_deref().unwrap_or_default();
    part.tangents = Some(tangents.iter().zip(normals).map(|(t, &n)| t.unwrap_or_else(|| frame(n))).collect());
}
