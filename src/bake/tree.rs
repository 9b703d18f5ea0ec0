//! A tree of boxes over the triangles of a mesh: lines, rays and closest points in logarithmic time.
//!
//! The tree is built by `obvhs`. Boxes are single precision in a space where the mesh fills the unit cube,
//! grown by more than their rounding; triangles are tested in double precision. So a box never hides a
//! triangle, and results depend on the triangles alone, not on the shape of the tree: of equal candidates
//! the lowest face index wins.

use super::triangle::{Crossing, Line, closest};
use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::{Boundable, BvhBuildParams};
use std::collections::HashSet;
use std::time::Duration;

/// Least growth of boxes, in sides of the unit cube: 16 times the rounding of the box test.
const PAD: f32 = 4e-6;

/// Nodes still to be visited; kept between queries.
pub(super) type Stack = Vec<u32>;

/// A closest point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest {
    pub face: u32,
    pub weights: [f64; 3],
    pub distance: f64,
}

struct Bounded(Aabb);

impl Boundable for Bounded {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

/// The tree.
pub(super) struct Tree {
    nodes: Vec<Bvh2Node>,
    /// Faces in the order of the leaves.
    order: Vec<u32>,
    /// Their corners in the unit cube about the origin.
    corners: Vec<[[f32; 3]; 3]>,
    centre: DVec3,
    scale: f64,
}

fn wide(p: [f32; 3]) -> DVec3 {
    DVec3::from_array(p.map(f64::from))
}

impl Tree {
    /// A tree over the faces that have an area; positions are finite. Of several faces with the same corners in
    /// the same order the first is kept.
    pub fn new(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Self {
        let used = || faces.iter().flatten().map(|&v| wide(positions[v as usize]));
        let low = used().fold(DVec3::INFINITY, DVec3::min);
        let high = used().fold(DVec3::NEG_INFINITY, DVec3::max);
        let extent = (high - low).max_element();
        let (centre, scale) = if extent > 0.0 && extent.is_finite() {
            (0.5 * (low + high), extent.recip())
        } else {
            (DVec3::ZERO, 1.0)
        };
        let unit = |v: u32| (scale * (wide(positions[v as usize]) - centre)).as_vec3().to_array();
        // Of faces at the same place the first is enough.
        let mut seen = HashSet::with_capacity(faces.len());
        let mut order = Vec::with_capacity(faces.len());
        let mut corners = Vec::with_capacity(faces.len());
        for (i, face) in faces.iter().enumerate() {
            let p = face.map(unit);
            let [a, b, c] = p.map(wide);
            if (b - a).cross(c - a) != DVec3::ZERO && seen.insert(p.map(|q| q.map(f32::to_bits))) {
                order.push(i as u32);
                corners.push(p);
            }
        }
        let boxes: Vec<_> = corners
            .iter()
            .enumerate()
            .map(|(i, p)| {
                let points = p.map(Vec3A::from_array);
                // Equal boxes make the builder's time quadratic; growing each a little differently parts them.
                let pad = Vec3A::splat(PAD * (1.0 + (i as f64 * 0.618_033_988_749_894_9).fract() as f32));
                Bounded(Aabb::new(
                    points[0].min(points[1]).min(points[2]) - pad,
                    points[0].max(points[1]).max(points[2]) + pad,
                ))
            })
            .collect();
        let mut nodes = Vec::new();
        if !boxes.is_empty() {
            let built = build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut Duration::default());
            nodes = built.nodes;
            let leaves = built.primitive_indices;
            order = leaves.iter().map(|&i| order[i as usize]).collect();
            corners = leaves.iter().map(|&i| corners[i as usize]).collect();
        }
        Self { nodes, order, corners, centre, scale }
    }

    /// Length of the longest side of the box around the mesh, in the mesh's unit.
    pub fn extent(&self) -> f64 {
        self.scale.recip()
    }

    /// Calls `visit(face, crossing)` for every crossing at a distance from `near` to `far` along a unit
    /// direction, in no fixed order, until it answers `false`.
    pub fn crossings(
        &self,
        stack: &mut Stack,
        origin: DVec3,
        direction: DVec3,
        [near, far]: [f64; 2],
        mut visit: impl FnMut(u32, Crossing) -> bool,
    ) {
        let Some(root) = self.nodes.first() else { return };
        let local = self.scale * (origin - self.centre);
        // Begin where the line enters the cube, so that single precision is enough however far the origin is.
        let Some([enter, leave]) = clip(local, direction, [near * self.scale, far * self.scale]) else {
            return;
        };
        let start = local + enter * direction;
        let ray = Slabs::new(start.as_vec3a(), direction.as_vec3a(), (leave - enter) as f32);
        let line = Line::new(start, direction);
        stack.clear();
        let mut node = root;
        if !ray.meets(node.aabb()) {
            return;
        }
        loop {
            let first = node.first_index as usize;
            if node.is_leaf() {
                for k in first..first + node.prim_count as usize {
                    let Some(found) = line.cross(self.corners[k].map(wide)) else { continue };
                    let t = (found.t + enter) / self.scale;
                    if t >= near && t <= far && !visit(self.order[k], Crossing { t, ..found }) {
                        return;
                    }
                }
            } else {
                let (left, right) = (&self.nodes[first], &self.nodes[first + 1]);
                match (ray.meets(left.aabb()), ray.meets(right.aabb())) {
                    (true, true) => {
                        stack.push(first as u32 + 1);
                        node = left;
                        continue;
                    }
                    (true, false) => {
                        node = left;
                        continue;
                    }
                    (false, true) => {
                        node = right;
                        continue;
                    }
                    (false, false) => {}
                }
            }
            let Some(next) = stack.pop() else { return };
            node = &self.nodes[next as usize];
        }
    }

    /// The first crossing of a ray with a face, from either side.
    pub fn first(&self, stack: &mut Stack, origin: DVec3, direction: DVec3) -> Option<(u32, Crossing)> {
        let root = self.nodes.first()?;
        let local = self.scale * (origin - self.centre);
        let [enter, leave] = clip(local, direction, [0.0, f64::INFINITY])?;
        let start = local + enter * direction;
        let mut ray = Slabs::new(start.as_vec3a(), direction.as_vec3a(), (leave - enter) as f32);
        let line = Line::new(start, direction);
        let mut best: Option<(u32, Crossing)> = None;
        stack.clear();
        if ray.enters(root.aabb()).is_finite() {
            stack.push(0);
        }
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index as usize];
            let first = node.first_index as usize;
            if !node.is_leaf() {
                let [left, right] = [first, first + 1].map(|i| ray.enters(self.nodes[i].aabb()));
                let (near, far) = if left <= right { (first, first + 1) } else { (first + 1, first) };
                if left.max(right).is_finite() {
                    stack.push(far as u32);
                }
                if left.min(right).is_finite() {
                    stack.push(near as u32);
                }
                continue;
            }
            for k in first..first + node.prim_count as usize {
                let Some(found) = line.cross(self.corners[k].map(wide)) else { continue };
                let face = self.order[k];
                let found = Crossing { t: (found.t + enter) / self.scale, ..found };
                let better = |(f, b): (u32, Crossing)| found.t < b.t || found.t == b.t && face < f;
                if found.t >= 0.0 && best.is_none_or(better) {
                    best = Some((face, found));
                    ray.far = (found.t * self.scale - enter) as f32 + PAD;
                }
            }
        }
        best
    }

    /// The closest point among the faces that `accept` takes.
    pub fn closest(&self, stack: &mut Stack, point: DVec3, accept: impl Fn(u32) -> bool) -> Option<Nearest> {
        let p = self.scale * (point - self.centre);
        let mut best: Option<Nearest> = None;
        let mut limit = f64::INFINITY;
        stack.clear();
        if !self.nodes.is_empty() {
            stack.push(0);
        }
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index as usize];
            if distance_squared(node.aabb(), p) > limit {
                continue;
            }
            let first = node.first_index as usize;
            if !node.is_leaf() {
                let [near, far] = [first, first + 1].map(|i| distance_squared(self.nodes[i].aabb(), p));
                let (left, right) = (first as u32, first as u32 + 1);
                stack.extend(if near <= far { [right, left] } else { [left, right] });
                continue;
            }
            for k in first..first + node.prim_count as usize {
                let face = self.order[k];
                let corners = self.corners[k].map(wide);
                let weights = closest(corners, p);
                let found = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
                let d = found.distance_squared(p);
                if (d < limit || d == limit && best.is_none_or(|b| face < b.face)) && accept(face) {
                    limit = d;
                    best = Some(Nearest { face, weights, distance: d.sqrt() / self.scale });
                }
            }
        }
        best
    }
}

/// The part of a line inside the unit cube about the origin, a little grown.
fn clip(origin: DVec3, direction: DVec3, [mut near, mut far]: [f64; 2]) -> Option<[f64; 2]> {
    let half = 0.5 + 4.0 * f64::from(PAD);
    for (o, d) in origin.to_array().into_iter().zip(direction.to_array()) {
        if d == 0.0 {
            if o.abs() > half {
                return None;
            }
            continue;
        }
        let (a, b) = ((-half - o) / d, (half - o) / d);
        near = near.max(a.min(b));
        far = far.min(a.max(b));
    }
    (near <= far).then_some([near, far])
}

fn distance_squared(aabb: &Aabb, p: DVec3) -> f64 {
    let q = p.clamp(aabb.min.as_dvec3(), aabb.max.as_dvec3());
    q.distance_squared(p)
}

/// A ray for box tests.
struct Slabs {
    origin: Vec3A,
    inverse: Vec3A,
    far: f32,
}

impl Slabs {
    fn new(origin: Vec3A, direction: Vec3A, far: f32) -> Self {
        // A component of zero becomes tiny: the slab's planes are then as good as infinitely far.
        let inverse = Vec3A::from_array(
            direction.to_array().map(|d| if d.abs() < 1e-18 { 1e18f32.copysign(d) } else { d.recip() }),
        );
        Self { origin, inverse, far: far + PAD }
    }

    /// Where the ray enters a box; infinity where it misses.
    #[inline(always)]
    fn enters(&self, aabb: &Aabb) -> f32 {
        let a = (aabb.min - self.origin) * self.inverse;
        let b = (aabb.max - self.origin) * self.inverse;
        let near = a.min(b).max_element().max(-PAD);
        if near <= a.max(b).min_element().min(self.far) { near } else { f32::INFINITY }
    }

    #[inline(always)]
    fn meets(&self, aabb: &Aabb) -> bool {
        self.enters(aabb) < f32::INFINITY
    }
}
