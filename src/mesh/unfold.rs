//! Folds taken out of a simplified mesh: pairs of faces whose common edge runs the wrong way.
//!
//! Collapsing edges now and then leaves a thin face on its back, under its neighbours. Where the other diagonal
//! of the two triangles along an edge makes both lie more as the vertices' normals ask, it is taken. Vertices,
//! their number and the number of faces stay.

use super::normals::{cross, dot, minus};
use std::collections::HashMap;

/// Faces whose normal and that of their vertices have a smaller cosine are looked at.
const FOLDED: f64 = 0.3;
/// A swap must raise the lower of the two cosines by as much.
const GAIN: f64 = 0.05;
/// Rounds; each swap makes way for others.
const ROUNDS: usize = 8;
/// An edge of several faces.
const MANY: usize = usize::MAX;

/// Positions, unit normals and texture coordinates of vertices.
pub(super) struct Vertices<'a> {
    pub positions: &'a [[f32; 3]],
    pub normals: &'a [[f32; 3]],
    pub uv: Option<&'a [[f32; 2]]>,
}

impl Vertices<'_> {
    /// Cosine between a face's normal and the sum of its vertices'; -1 without an area.
    fn upright(&self, face: [u32; 3]) -> f64 {
        let [a, b, c] = face.map(|v| self.positions[v as usize]);
        let normal = cross(minus(b, a), minus(c, a));
        let sum: [f64; 3] =
            std::array::from_fn(|k| face.iter().map(|&v| f64::from(self.normals[v as usize][k])).sum());
        let cosine = dot(normal, sum) / (dot(normal, normal) * dot(sum, sum)).sqrt();
        if cosine.is_finite() { cosine } else { -1.0 }
    }

    /// Twice the signed area of a face in texture space; 0 without texture coordinates.
    fn turn(&self, face: [u32; 3]) -> f64 {
        let Some(uv) = self.uv else { return 0.0 };
        let [a, b, c] = face.map(|v| uv[v as usize].map(f64::from));
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    }

    /// Whether two faces in the place of two others turn the same way in texture space as the larger of those.
    fn keep_turn(&self, old: [[u32; 3]; 2], new: [[u32; 3]; 2]) -> bool {
        let [p, q] = old.map(|face| self.turn(face));
        let sense = if p.abs() >= q.abs() { p } else { q };
        self.uv.is_none() || new.iter().all(|&face| self.turn(face) * sense > 0.0)
    }
}

/// Swaps edges of folded faces.
pub(super) fn unfold(vertices: &Vertices<'_>, faces: &mut [[u32; 3]]) {
    for _ in 0..ROUNDS {
        let mut sides: HashMap<[u32; 2], usize> = HashMap::with_capacity(3 * faces.len());
        for (i, face) in faces.iter().enumerate() {
            for k in 0..3 {
                sides.entry([face[k], face[(k + 1) % 3]]).and_modify(|f| *f = MANY).or_insert(i);
            }
        }
        let mut touched = vec![false; faces.len()];
        let mut swaps = 0;
        for i in 0..faces.len() {
            if touched[i] || vertices.upright(faces[i]) >= FOLDED {
                continue;
            }
            let best = (0..3)
                .filter_map(|k| {
                    let [a, b, c] = [faces[i][k], faces[i][(k + 1) % 3], faces[i][(k + 2) % 3]];
                    let j = *sides.get(&[b, a])?;
                    if j == MANY || touched[j] || sides.get(&[a, b]) == Some(&MANY) {
                        return None;
                    }
                    let d = faces[j].into_iter().find(|&v| v != a && v != b)?;
                    // The new edge must not be there already, as on a tetrahedron.
                    if c == d || sides.contains_key(&[c, d]) || sides.contains_key(&[d, c]) {
                        return None;
                    }
                    let (old, new) = ([faces[i], faces[j]], [[a, d, c], [d, b, c]]);
                    let [before, after] =
                        [old, new].map(|pair| vertices.upright(pair[0]).min(vertices.upright(pair[1])));
                    (after > before + GAIN && vertices.keep_turn(old, new)).then_some((after, j, new))
                })
                .max_by(|x, y| x.0.total_cmp(&y.0));
            if let Some((_, j, new)) = best {
                [faces[i], faces[j]] = new;
                [touched[i], touched[j]] = [true; 2];
                swaps += 1;
                // What is new this round is not looked at before the next.
                for face in new {
                    for k in 0..3 {
                        let edge = [face[k], face[(k + 1) % 3]];
                        sides.entry(edge).or_insert(MANY);
                    }
                }
            }
        }
        if swaps == 0 {
            break;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_edge_of_a_fold_is_swapped_and_others_stay() {
        // A dart seen from above: the edge 0-1 runs outside of it, so one of its faces lies on its back.
        let positions = [[0., 0., 0.], [2., 0., 0.], [1., 3., 0.], [1., 1., 0.]];
        let normals = [[0., 0., 1.]; 4];
        let vertices = Vertices { positions: &positions, normals: &normals, uv: None };
        let folded = [[0, 1, 2], [1, 0, 3]];
        let mut faces = folded;
        unfold(&vertices, &mut faces);
        assert_eq!(faces, [[2, 0, 3], [1, 2, 3]]);
        // With texture coordinates in which the swapped faces would lie on their back it is left as it is.
        let uv = [[0., 0.], [2., 0.], [1., 3.], [1., -1.]];
        let mut faces = folded;
        unfold(&Vertices { uv: Some(&uv), ..vertices }, &mut faces);
        assert_eq!(faces, [[2, 0, 3], [1, 2, 3]]);
        let uv = [[0., 0.], [2., 0.], [1., 3.], [9., -9.]];
        let mut faces = folded;
        unfold(&Vertices { positions: &positions, normals: &normals, uv: Some(&uv) }, &mut faces);
        assert_eq!(faces, folded);
    }
}
