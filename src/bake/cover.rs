//! Which piece of which triangle each texel holds: the low mesh drawn in texture space, conservatively.
//!
//! A texel has a grid of n x n sample points. A point on an edge that two triangles share belongs to one of
//! them (the sign of an edge's determinant is computed once for both, ties go to the upper left side), one in
//! several triangles to that of the lowest index. A texel that triangles touch only between its sample points
//! gets one sample all the same: the centroid of the piece. So every texel that a filter may read on an
//! island's behalf has a value of its own.

use crate::error::{Error, Result};

/// Texels along the side of a tile.
pub(super) const TILE: usize = 8;
/// Most entries in the lists of triangles by rows of tiles: what hostile coordinates may make of a small mesh.
const MOST_ENTRIES: usize = 1 << 28;
const NONE: u32 = u32::MAX;

/// The uv triangles of a mesh over a grid of texels.
pub(super) struct Chart {
    /// Corners in texels.
    corners: Vec<[[f64; 2]; 3]>,
    /// Faces by rows of tiles, in ascending order.
    rows: Vec<Vec<u32>>,
    size: [usize; 2],
    per_axis: usize,
    /// Faces whose uv triangle has no area or a coordinate that is not finite.
    pub degenerate_faces: usize,
    /// Faces that reach outside the unit square.
    pub outside_faces: usize,
    /// Faces whose uv run the other way round than their corners.
    pub mirrored_faces: usize,
}

/// What a texel holds.
#[derive(Clone, Debug, Default)]
pub(super) struct Piece {
    /// Faces and the weights of their corners, one a sample point that is covered.
    pub samples: Vec<(u32, [f64; 3])>,
    /// Whether a sample point lies in several triangles.
    pub overlapping: bool,
    /// The faces that share a sample point with another, some of them several times.
    pub shared: Vec<u32>,
    /// Whether only the centroid of a piece was to be had.
    pub sliver: bool,
}

/// Determinant of an edge and a point, the same number but for its sign from either end.
fn side(a: [f64; 2], b: [f64; 2], p: [f64; 2]) -> f64 {
    let (lo, hi, sign) = if a <= b { (a, b, 1.0) } else { (b, a, -1.0) };
    sign * ((hi[0] - lo[0]) * (p[1] - lo[1]) - (hi[1] - lo[1]) * (p[0] - lo[0]))
}

/// Whether points on the edge from a to b belong to the triangle on its positive side: of the two
/// directions of an edge, one.
fn owns(a: [f64; 2], b: [f64; 2]) -> bool {
    a[1] > b[1] || a[1] == b[1] && a[0] < b[0]
}

fn bounds(corners: &[[f64; 2]; 3], axis: usize) -> [f64; 2] {
    let [a, b, c] = corners.map(|p| p[axis]);
    [a.min(b).min(c), a.max(b).max(c)]
}

impl Chart {
    /// The triangles of `uv` on `size` texels with `per_axis`^2 sample points each.
    pub fn new(uv: &[[f32; 2]], faces: &[[u32; 3]], size: [usize; 2], per_axis: usize) -> Result<Self> {
        let tiles = size[1].div_ceil(TILE);
        let mut chart = Self {
            corners: Vec::with_capacity(faces.len()),
            rows: vec![Vec::new(); tiles],
            size,
            per_axis,
            degenerate_faces: 0,
            outside_faces: 0,
            mirrored_faces: 0,
        };
        let mut entries = 0;
        for (i, face) in faces.iter().enumerate() {
            let corners = face.map(|v| {
                let [u, v] = uv[v as usize].map(f64::from);
                [u * size[0] as f64, v * size[1] as f64]
            });
            let area = side(corners[0], corners[1], corners[2]);
            chart.corners.push(corners);
            if !(area.is_finite() && area != 0.0) {
                chart.degenerate_faces += 1;
                continue;
            }
            // v runs down, so a picture that is not mirrored turns the corners clockwise.
            chart.mirrored_faces += usize::from(area > 0.0);
            let [x, y] = [bounds(&corners, 0), bounds(&corners, 1)];
            // A thousandth of a texel outside is the rounding of whoever made the uv.
            let (w, h) = (size[0] as f64, size[1] as f64);
            chart.outside_faces +=
                usize::from(x[0] < -1e-3 || y[0] < -1e-3 || x[1] > w + 1e-3 || y[1] > h + 1e-3);
            if x[1] <= 0.0 || y[1] <= 0.0 || x[0] >= w || y[0] >= h {
                continue;
            }
            let first = y[0].max(0.0) as usize / TILE;
            let last = (y[1].ceil().min(h) as usize).saturating_sub(1) / TILE;
            entries += last - first + 1;
            if entries > MOST_ENTRIES {
                let got =
                    format!("triangles that cross more than {MOST_ENTRIES} rows of {TILE} texels in all");
                return Err(Error::value("uv", got, "fewer or smaller triangles, or a smaller map"));
            }
            for row in &mut chart.rows[first..=last] {
                row.push(i as u32);
            }
        }
        Ok(chart)
    }

    /// Tiles along x and y.
    pub fn tiles(&self) -> [usize; 2] {
        self.size.map(|n| n.div_ceil(TILE))
    }

    /// Sample points of a texel.
    pub fn samples_per_texel(&self) -> usize {
        self.per_axis * self.per_axis
    }

    /// The texels of a tile, clipped to the map: first and end along x and y.
    pub fn texels(&self, tile: [usize; 2]) -> [[usize; 2]; 2] {
        [0, 1].map(|k| [tile[k] * TILE, ((tile[k] + 1) * TILE).min(self.size[k])])
    }

    /// What the texels of a tile hold, row by row; `None` where the tile is empty.
    pub fn pieces(&self, tile: [usize; 2]) -> Option<Vec<Piece>> {
        let [[x0, x1], [y0, y1]] = self.texels(tile);
        let (width, height) = (x1 - x0, y1 - y0);
        let reaches = |face: &&u32| {
            let corners = &self.corners[**face as usize];
            let ([a, b], [c, d]) = (bounds(corners, 0), bounds(corners, 1));
            a < x1 as f64 && b > x0 as f64 && c < y1 as f64 && d > y0 as f64
        };
        let faces: Vec<u32> = self.rows[tile[1]].iter().filter(reaches).copied().collect();
        if faces.is_empty() {
            return None;
        }
        let n = self.per_axis;
        let mut owners = vec![NONE; width * height * n * n];
        let mut touching = vec![NONE; width * height];
        let mut pieces = vec![Piece::default(); width * height];
        for face in faces {
            let corners = upright(self.corners[face as usize]);
            let span = |axis: usize, from: usize, to: usize| {
                let [lo, hi] = bounds(&corners, axis);
                let first = lo.floor().max(from as f64) as usize;
                first..(hi.ceil().min(to as f64) as usize).max(first)
            };
            for y in span(1, y0, y1) {
                for x in span(0, x0, x1) {
                    let texel = (y - y0) * width + x - x0;
                    // Nothing more to learn where every point is taken, and shared: heaps of faces stay cheap.
                    let settled = pieces[texel].overlapping && pieces[texel].samples.len() == n * n;
                    if settled || !touches(&corners, [x as f64, y as f64]) {
                        continue;
                    }
                    touching[texel] = touching[texel].min(face);
                    for (k, owner) in owners[texel * n * n..][..n * n].iter_mut().enumerate() {
                        let p = self.sample([x, y], k);
                        if !holds(&corners, p) {
                            continue;
                        }
                        if *owner == NONE {
                            *owner = face;
                            pieces[texel].samples.push((face, self.weights(face, p)));
                        } else {
                            pieces[texel].overlapping = true;
                            pieces[texel].shared.extend([*owner, face]);
                        }
                    }
                }
            }
        }
        for (texel, (piece, &face)) in pieces.iter_mut().zip(&touching).enumerate() {
            if piece.samples.is_empty() && face != NONE {
                let corner = [(x0 + texel % width) as f64, (y0 + texel / width) as f64];
                let p = centroid(&self.corners[face as usize], corner);
                piece.samples.push((face, self.weights(face, p)));
                piece.sliver = true;
            }
        }
        Some(pieces)
    }

    /// Sample point k of a texel, in texels.
    fn sample(&self, [x, y]: [usize; 2], k: usize) -> [f64; 2] {
        let n = self.per_axis;
        let place = |i: usize| (i as f64 + 0.5) / n as f64;
        [x as f64 + place(k % n), y as f64 + place(k / n)]
    }

    /// Weights of a face's corners at a point, none below zero.
    fn weights(&self, face: u32, p: [f64; 2]) -> [f64; 3] {
        let [a, b, c] = self.corners[face as usize];
        let area = side(a, b, c);
        let raw = [side(b, c, p), side(c, a, p), side(a, b, p)].map(|e| (e / area).clamp(0.0, 1.0));
        let sum: f64 = raw.iter().sum();
        if sum > 0.0 { raw.map(|w| w / sum) } else { [1.0, 0.0, 0.0] }
    }

    /// Change of a face's corner weights one texel to the right and one down.
    pub fn slopes(&self, face: u32) -> [[f64; 2]; 3] {
        let [a, b, c] = self.corners[face as usize];
        let area = side(a, b, c);
        [(b, c), (c, a), (a, b)].map(|(p, q)| [(p[1] - q[1]) / area, (q[0] - p[0]) / area])
    }
}

/// The corners in the order in which the area is positive.
fn upright([a, b, c]: [[f64; 2]; 3]) -> [[f64; 2]; 3] {
    if side(a, b, c) >= 0.0 { [a, b, c] } else { [a, c, b] }
}

fn edges([a, b, c]: [[f64; 2]; 3]) -> [[[f64; 2]; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// Whether an upright triangle holds a point, by the rule for shared edges.
fn holds(corners: &[[f64; 2]; 3], p: [f64; 2]) -> bool {
    edges(*corners).into_iter().all(|[a, b]| {
        let e = side(a, b, p);
        e > 0.0 || e == 0.0 && owns(a, b)
    })
}

/// Whether an upright triangle and the unit square at `corner` share more than an edge: no axis of the square
/// and no side of the triangle separates them.
fn touches(corners: &[[f64; 2]; 3], corner: [f64; 2]) -> bool {
    let apart = (0..2).any(|axis| {
        let [lo, hi] = bounds(corners, axis);
        hi <= corner[axis] || lo >= corner[axis] + 1.0
    });
    let centre = corner.map(|c| c + 0.5);
    !apart
        && edges(*corners)
            .into_iter()
            .all(|[a, b]| side(a, b, centre) + 0.5 * ((b[0] - a[0]).abs() + (b[1] - a[1]).abs()) > 0.0)
}

/// Centroid of the part of a triangle inside the unit square at `corner`.
fn centroid(corners: &[[f64; 2]; 3], corner: [f64; 2]) -> [f64; 2] {
    let mut polygon = corners.map(|p| [p[0] - corner[0], p[1] - corner[1]]).to_vec();
    // Sutherland and Hodgman, one side of the square after the other.
    for (axis, sign, limit) in [(0, 1.0, 0.0), (0, -1.0, -1.0), (1, 1.0, 0.0), (1, -1.0, -1.0)] {
        let height = |p: [f64; 2]| sign * p[axis] - limit;
        let mut inside = Vec::with_capacity(polygon.len() + 1);
        for (i, &p) in polygon.iter().enumerate() {
            let q = polygon[(i + 1) % polygon.len()];
            let (hp, hq) = (height(p), height(q));
            if hp >= 0.0 {
                inside.push(p);
            }
            if (hp >= 0.0) != (hq >= 0.0) {
                let t = hp / (hp - hq);
                inside.push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
            }
        }
        polygon = inside;
    }
    let Some(&first) = polygon.first() else { return [corner[0] + 0.5, corner[1] + 0.5] };
    let (mut area, mut moment) = (0.0, [0.0; 2]);
    for pair in polygon.windows(2).skip(1) {
        let double = side(first, pair[0], pair[1]);
        area += double;
        for (k, m) in moment.iter_mut().enumerate() {
            *m += double * (first[k] + pair[0][k] + pair[1][k]) / 3.0;
        }
    }
    let inner = if area != 0.0 { moment.map(|m| m / area) } else { first };
    [corner[0] + inner[0].clamp(0.0, 1.0), corner[1] + inner[1].clamp(0.0, 1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A disc of triangles about a point that is no corner of a texel.
    fn fan() -> (Vec<[f32; 2]>, Vec<[u32; 3]>) {
        let mut uv = vec![[0.487f32, 0.513]];
        uv.extend((0..13).map(|i| {
            let angle = i as f32 / 13.0 * std::f32::consts::TAU;
            [0.487 + 0.4 * angle.cos(), 0.513 + 0.4 * angle.sin()]
        }));
        (uv, (0..13).map(|i| [0, 1 + i, 1 + (i + 1) % 13]).collect())
    }

    #[test]
    fn triangles_that_share_edges_share_no_sample_point() {
        let (uv, faces) = fan();
        for (size, per_axis) in [([40, 24], 4), ([8, 8], 1), ([33, 9], 3)] {
            let chart = Chart::new(&uv, &faces, size, per_axis).expect("a chart");
            let [tx, ty] = chart.tiles();
            let mut count = 0;
            for tile in (0..tx * ty).map(|t| [t % tx, t / tx]) {
                for piece in chart.pieces(tile).unwrap_or_default() {
                    assert!(!piece.overlapping);
                    count += if piece.sliver { 0 } else { piece.samples.len() };
                }
            }
            // Points inside the polygon, found by its outline.
            let corner = |i: usize| [uv[1 + i % 13][0] as f64, uv[1 + i % 13][1] as f64];
            let mut inside = 0;
            for i in 0..size[0] * per_axis {
                for j in 0..size[1] * per_axis {
                    let p = [
                        (i as f64 + 0.5) / (size[0] * per_axis) as f64,
                        (j as f64 + 0.5) / (size[1] * per_axis) as f64,
                    ];
                    let turn = |k: usize| {
                        let (a, b) = (corner(k), corner(k + 1));
                        (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
                    };
                    inside += usize::from((0..13).all(|k| turn(k) >= 0.0));
                }
            }
            assert_eq!(count, inside, "{size:?}");
        }
    }

    #[test]
    fn every_texel_that_a_triangle_touches_has_a_sample_of_its_own() {
        // A sliver between the sample points, across many texels.
        let uv = [[0.01f32, 0.02], [0.97, 0.505], [0.97, 0.506]];
        let chart = Chart::new(&uv, &[[0, 1, 2]], [32, 32], 1).expect("a chart");
        let mut texels = 0;
        for tile in (0..16).map(|t| [t % 4, t / 4]) {
            for piece in chart.pieces(tile).unwrap_or_default() {
                texels += piece.samples.len();
                for (_, w) in piece.samples {
                    assert!(w.iter().all(|w| (0.0..=1.0).contains(w)));
                    assert!((w.iter().sum::<f64>() - 1.0).abs() < 1e-12);
                }
            }
        }
        // A line from column 0 to 31 and row 0 to 16 crosses 32 columns and changes its row 16 times.
        assert!((46..=50).contains(&texels), "{texels}");
        let flipped = Chart::new(&uv, &[[0, 2, 1]], [32, 32], 1).expect("a chart");
        assert_eq!(chart.mirrored_faces + flipped.mirrored_faces, 1);
    }
}
