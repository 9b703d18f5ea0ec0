//! Clipping in homogeneous coordinates, before any division.
//!
//! Only triangles that reach outside the near or far plane or a wide guard band are cut; the sides of the
//! picture are left to the bounding box. A cut edge is always computed from its inner to its outer end, so
//! two triangles that share the edge get the same new vertex, to the bit.
//! Sutherland and Hodgman, "Reentrant polygon clipping", CACM 1974.

/// A convex polygon of clip-space vertices: a triangle after at most six cuts.
pub(super) struct Polygon {
    vertices: [[f64; 4]; 9],
    len: usize,
}

impl Polygon {
    /// The vertices in order.
    pub(super) fn vertices(&self) -> &[[f64; 4]] {
        &self.vertices[..self.len]
    }

    fn push(&mut self, vertex: [f64; 4]) {
        // A convex polygon gains at most one vertex a plane; rounding must not make it more.
        if self.len < self.vertices.len() {
            self.vertices[self.len] = vertex;
            self.len += 1;
        }
    }
}

/// The part of a triangle with `-w <= z <= w`, `|x| <= guard[0] w` and `|y| <= guard[1] w`, which implies
/// `w >= 0`. Fewer than three vertices: nothing is left.
pub(super) fn clip(corners: [[f64; 4]; 3], guard: [f64; 2]) -> Polygon {
    let mut polygon = Polygon { vertices: [[0.0; 4]; 9], len: 0 };
    for corner in corners {
        polygon.push(corner);
    }
    let planes: [[f64; 4]; 6] = [
        [0.0, 0.0, 1.0, 1.0],
        [0.0, 0.0, -1.0, 1.0],
        [1.0, 0.0, 0.0, guard[0]],
        [-1.0, 0.0, 0.0, guard[0]],
        [0.0, 1.0, 0.0, guard[1]],
        [0.0, -1.0, 0.0, guard[1]],
    ];
    for plane in planes {
        polygon = cut(&polygon, plane);
        if polygon.len < 3 {
            break;
        }
    }
    polygon
}

fn cut(polygon: &Polygon, plane: [f64; 4]) -> Polygon {
    let distance = |v: [f64; 4]| (0..4).map(|k| plane[k] * v[k]).sum::<f64>();
    let mut out = Polygon { vertices: [[0.0; 4]; 9], len: 0 };
    let vertices = polygon.vertices();
    for (i, &here) in vertices.iter().enumerate() {
        let next = vertices[(i + 1) % vertices.len()];
        let (d_here, d_next) = (distance(here), distance(next));
        if d_here >= 0.0 {
            out.push(here);
        }
        if (d_here >= 0.0) != (d_next >= 0.0) {
            out.push(if d_here >= 0.0 {
                crossing(here, next, d_here, d_next)
            } else {
                crossing(next, here, d_next, d_here)
            });
        }
    }
    out
}

/// The point of the plane between an inner vertex (distance >= 0) and an outer one (distance < 0).
fn crossing(inner: [f64; 4], outer: [f64; 4], d_inner: f64, d_outer: f64) -> [f64; 4] {
    let t = d_inner / (d_inner - d_outer);
    std::array::from_fn(|k| inner[k] + t * (outer[k] - inner[k]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_inside_is_left_alone() {
        let corners = [[0.1, 0.2, 0.3, 1.0], [0.5, 0.2, -0.3, 2.0], [-0.1, 0.9, 0.0, 1.5]];
        assert_eq!(clip(corners, [3.0, 3.0]).vertices(), corners);
    }

    #[test]
    fn what_is_left_lies_inside_even_for_vertices_behind_the_eye() {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64 * 2.0 - 1.0
        };
        let mut kept = 0;
        for _ in 0..20_000 {
            let corners: [[f64; 4]; 3] =
                std::array::from_fn(|_| [random() * 9.0, random() * 9.0, random() * 2.0, random()]);
            let polygon = clip(corners, [3.0, 5.0]);
            if polygon.vertices().len() >= 3 {
                kept += 1;
            }
            for &[x, y, z, w] in polygon.vertices() {
                let slack = 1e-13;
                assert!(w >= -slack && z.abs() <= w + slack);
                assert!(x.abs() <= 3.0 * w + slack && y.abs() <= 5.0 * w + slack);
            }
        }
        assert!(kept > 2000);
    }

    #[test]
    fn a_shared_edge_is_cut_at_the_same_place_from_both_sides() {
        let (a, b) = ([0.3, 0.7, -5.0, 1.0], [-0.4, 0.1, 0.2, 1.3]);
        let one = clip([a, b, [2.0, 1.0, 0.0, 1.0]], [3.0, 3.0]);
        let other = clip([b, a, [-2.0, 0.5, 0.1, 1.0]], [3.0, 3.0]);
        let shared = one.vertices().iter().filter(|v| other.vertices().contains(v)).count();
        assert_eq!(shared, 2);
    }
}
