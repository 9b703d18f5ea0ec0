//! From clip-space vertices to snapped triangles with exact integer edge functions.
//!
//! An edge function of the directed edge a -> b at point p is `(b - a) x (p - a)`, positive inside. With
//! vertices in 1/256 pixel and within 2^16 pixels of each other it fits in 51 bits.

use super::{Cull, Geometry, clip::clip};
use crate::kernel::Isa;

/// Sub-pixel units in a pixel.
pub(super) const SUB: i64 = 256;
/// Up to so many columns of pixels are tested one by one.
const NARROW: i64 = 8;
/// Half-width of the guard band around the picture's centre, in pixels.
const GUARD_PX: f64 = 24_576.0;
/// Clip-space coordinates beyond this size are not drawn: their products stay finite.
const LARGEST: f64 = 1e60;

const NEAR: u8 = 1;
const FAR: u8 = 2;
const SIDES: [u8; 4] = [4, 8, 16, 32];
/// The vertex lies outside the near or far plane or the guard band.
const CUT: u8 = 64;
const INVALID: u8 = 128;

/// A vertex on the screen: snapped place in 1/256 pixel and depth z/w.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Screen {
    x: i32,
    y: i32,
    z: f32,
    code: u8,
}

/// Size of the target and what follows from it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Viewport {
    half: [f64; 2],
    guard: [f64; 2],
    size: [i64; 2],
}

impl Viewport {
    pub(super) fn new(width: usize, height: usize) -> Self {
        let half = [width as f64 / 2.0, height as f64 / 2.0];
        Self { half, guard: half.map(|h| GUARD_PX / h), size: [width as i64, height as i64] }
    }

    /// Divides and snaps. The caller knows that the vertex lies within the guard band and `w > 0`.
    fn snap(&self, [x, y, z, w]: [f64; 4]) -> Screen {
        let place = |c: f64, half: f64, guard: f64| {
            // A vertex made by clipping may lie outside by the rounding of its coordinates, and far outside
            // where these are small differences of large numbers.
            let place = ((c / w).clamp(-guard, guard) + 1.0) * half * SUB as f64 + 0.5;
            // The floor, without the call that `f64::floor` is on older processors.
            let toward_zero = place as i32;
            toward_zero - i32::from(f64::from(toward_zero) > place)
        };
        Screen {
            x: place(x, self.half[0], self.guard[0]),
            y: place(-y, self.half[1], self.guard[1]),
            z: (z / w).clamp(-1.0, 1.0) as f32,
            code: 0,
        }
    }

    /// Where a vertex lies, and its place on the screen if it needs no clipping.
    pub(super) fn project(&self, v: [f64; 4]) -> Screen {
        let [x, y, z, w] = v;
        // NaN fails the comparison.
        if !v.iter().all(|c| c.abs() <= LARGEST) {
            return Screen { code: INVALID, ..Screen::default() };
        }
        let mut code = 0;
        let tests = [x < -w, x > w, y < -w, y > w];
        for (bit, outside) in SIDES.into_iter().zip(tests) {
            code |= if outside { bit } else { 0 };
        }
        code |= if z < -w { NEAR } else { 0 };
        code |= if z > w { FAR } else { 0 };
        let within = x.abs() <= self.guard[0] * w && y.abs() <= self.guard[1] * w && w > 0.0;
        if code & (NEAR | FAR) != 0 || !within {
            return Screen { code: code | CUT, ..Screen::default() };
        }
        Screen { code, ..self.snap(v) }
    }
}

/// A triangle ready to be visited, its corners so ordered that the inside is positive.
#[derive(Clone, Copy, Debug)]
pub(super) struct Primitive {
    pub(super) face: i32,
    x: [i32; 3],
    y: [i32; 3],
    z: [f32; 3],
}

/// Which pixels a primitive may touch: columns and rows, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Bounds {
    pub(super) x: [i64; 2],
    pub(super) y: [i64; 2],
}

impl Bounds {
    pub(super) fn is_empty(&self) -> bool {
        self.x[0] > self.x[1] || self.y[0] > self.y[1]
    }
}

impl Primitive {
    /// Pixels whose sample points (`lo` to `hi` in sub-pixel units from the pixel's corner) may lie inside.
    #[inline(always)]
    fn bounds(&self, viewport: &Viewport, lo: i64, hi: i64) -> Bounds {
        let range = |c: [i32; 3], size: i64| {
            let min = i64::from(c[0].min(c[1]).min(c[2]));
            let max = i64::from(c[0].max(c[1]).max(c[2]));
            // The first pixel whose last sample is not left of `min`, the last whose first is not right of `max`.
            [(min - hi + SUB - 1).div_euclid(SUB).max(0), (max - lo).div_euclid(SUB).min(size - 1)]
        };
        Bounds { x: range(self.x, viewport.size[0]), y: range(self.y, viewport.size[1]) }
    }

    /// Edge functions and depth.
    #[inline(always)]
    pub(super) fn edges(&self) -> Edges {
        let (x, y) = (self.x.map(i64::from), self.y.map(i64::from));
        let mut dx = [0; 3];
        let mut dy = [0; 3];
        let mut constant = [0; 3];
        for i in 0..3 {
            let j = (i + 1) % 3;
            (dx[i], dy[i]) = (x[j] - x[i], y[j] - y[i]);
            // Top edges run right, left edges run up; only they own the points on them.
            let owns = dy[i] < 0 || (dy[i] == 0 && dx[i] > 0);
            constant[i] = dy[i] * x[i] - dx[i] * y[i] - i64::from(!owns);
        }
        Edges { dx, dy, constant }
    }

    /// The plane of depths.
    #[inline(always)]
    pub(super) fn depth(&self) -> Depth {
        let ([x0, x1, x2], [y0, y1, y2]) = (self.x.map(f64::from), self.y.map(f64::from));
        let z = self.z.map(f64::from);
        // Whole numbers below 2^26: differences are exact, and so is the area, below 2^53.
        let (x1, y1, x2, y2) = (x1 - x0, y1 - y0, x2 - x0, y2 - y0);
        let (z1, z2) = (z[1] - z[0], z[2] - z[0]);
        let inverse_area = 1.0 / (x1 * y2 - x2 * y1);
        let [a, b, c] = self.z;
        Depth {
            origin: [self.x[0], self.y[0]],
            z0: z[0],
            slope: [(z1 * y2 - z2 * y1) * inverse_area, (z2 * x1 - z1 * x2) * inverse_area],
            hull: [a.min(b).min(c), a.max(b).max(c)],
        }
    }
}

/// Edge functions of one triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edges {
    dx: [i64; 3],
    dy: [i64; 3],
    constant: [i64; 3],
}

/// Depth over one triangle: linear in the places of pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Depth {
    origin: [i32; 2],
    z0: f64,
    slope: [f64; 2],
    /// Smallest and largest depth of the corners.
    hull: [f32; 2],
}

/// Depth along one row, the same for a pixel whichever one is the first.
#[derive(Clone, Copy, Debug)]
pub(super) struct DepthRow {
    start: f64,
    /// From corner 0 to the first pixel, in sub-pixel units.
    x: f64,
    slope: f64,
    hull: [f32; 2],
}

impl Depth {
    /// Along row `y` from column `first` on.
    #[inline(always)]
    pub(super) fn row(&self, y: i64, first: i64) -> DepthRow {
        let sub = SUB as i32;
        let [dx, dy] = [first, y].map(|c| c as i32 * sub + sub / 2);
        let (dx, dy) = (f64::from(dx - self.origin[0]), f64::from(dy - self.origin[1]));
        DepthRow { start: self.z0 + dy * self.slope[1], x: dx, slope: self.slope[0], hull: self.hull }
    }
}

impl DepthRow {
    /// Depth at the k-th pixel. Rounding may not take it out of the triangle's range.
    #[inline(always)]
    pub(super) fn at(&self, k: usize) -> f32 {
        let z = (self.start + (self.x + f64::from(k as i32 * SUB as i32)) * self.slope) as f32;
        // Comparisons that a plain maximum and minimum instruction can do: NaN, which an overflowing slope of
        // a sliver gives, becomes the lower end.
        let z = if z > self.hull[0] { z } else { self.hull[0] };
        if z < self.hull[1] { z } else { self.hull[1] }
    }
}

impl Edges {
    /// Calls `span(y, first, last)` for each row of `bounds` that has samples inside the triangle; `sample`
    /// is the sample's place in its pixel. A sample at an edge shared by two triangles is in one of them.
    ///
    /// Along a row each edge function is linear in x, so its sign changes at a quotient of integers: no
    /// pixel of a wide triangle needs testing. Values at samples of one row differ by multiples of 256, so dividing by 256
    /// (rounding down) keeps every sign.
    #[inline(always)]
    pub(super) fn spans(&self, bounds: Bounds, sample: [i64; 2], mut span: impl FnMut(i64, i64, i64)) {
        let [x0, y0] = [bounds.x[0] * SUB + sample[0], bounds.y[0] * SUB + sample[1]];
        let columns = bounds.x[1] - bounds.x[0];
        // At (x0, y0): dx (y0 - ya) - dy (x0 - xa).
        let mut value: [i64; 3] =
            std::array::from_fn(|i| (self.dx[i] * y0 - self.dy[i] * x0 + self.constant[i]) >> 8);
        for y in bounds.y[0]..=bounds.y[1] {
            if columns < NARROW {
                // Testing a few pixels costs less than dividing.
                let mut hits = 0u32;
                let mut here = value;
                for k in 0..=columns {
                    hits |= u32::from((here[0] | here[1] | here[2]) >= 0) << k;
                    here = std::array::from_fn(|i| here[i] - self.dy[i]);
                }
                value = std::array::from_fn(|i| value[i] + self.dx[i]);
                if hits != 0 {
                    let (first, last) = (i64::from(hits.trailing_zeros()), i64::from(hits.ilog2()));
                    span(y, bounds.x[0] + first, bounds.x[0] + last);
                }
                continue;
            }
            let (mut first, mut last) = (0, columns);
            for (i, e) in value.iter_mut().enumerate() {
                let step = -self.dy[i];
                if *e < 0 {
                    // Enters where e + k step >= 0.
                    first = if step > 0 { first.max(ceil_div(-*e, step)) } else { columns + 1 };
                } else if step < 0 {
                    // Leaves after the last k with e + k step >= 0; most edges lie past the row's end.
                    if *e + last * step < 0 {
                        last = *e / -step;
                    }
                }
                *e += self.dx[i];
            }
            if first <= last {
                span(y, bounds.x[0] + first, bounds.x[0] + last);
            }
        }
    }
}

/// Pixels of a row that are tested together.
pub(super) const LANES: usize = 8;
/// Primitives of at most this extent, in sub-pixel units, have edge functions of 32 bits.
const SMALL: i32 = 1 << 13;

/// What the visit of a small triangle needs: every row of it is tested in one group of pixels.
pub(super) struct Group {
    /// Edge functions at the group's first pixel in the first row, less 1 where the edge does not own its points.
    first: [i32; 3],
    /// Their change from row to row.
    down: [i32; 3],
    /// Their change from the first pixel to each of the group.
    right: [[i32; LANES]; 3],
}

impl Group {
    /// For the centres of pixels from column `left` on, from row `top` on; `None` where the primitive is too large.
    #[inline(always)]
    pub(super) fn new(primitive: &Primitive, [left, top]: [i64; 2]) -> Option<Self> {
        let extent = |c: [i32; 3]| c[0].max(c[1]).max(c[2]) - c[0].min(c[1]).min(c[2]);
        if extent(primitive.x) > SMALL || extent(primitive.y) > SMALL {
            return None;
        }
        // At most a group and a primitive away from the corners: products stay below 2^28.
        let at = |c: [i32; 3], pixel: i64| c.map(|c| c - (pixel as i32 * SUB as i32 + SUB as i32 / 2));
        let (x, y) = (at(primitive.x, left), at(primitive.y, top));
        let mut group = Self { first: [0; 3], down: [0; 3], right: [[0; LANES]; 3] };
        for i in 0..3 {
            let j = (i + 1) % 3;
            let (dx, dy) = (x[j] - x[i], y[j] - y[i]);
            let owns = dy < 0 || (dy == 0 && dx > 0);
            group.first[i] = dy * x[i] - dx * y[i] - i32::from(!owns);
            group.down[i] = dx * SUB as i32;
            group.right[i] = std::array::from_fn(|k| -dy * SUB as i32 * k as i32);
        }
        Some(group)
    }

    /// Negative numbers for the pixels of a row that lie outside, and the step to the next row.
    #[inline(always)]
    pub(super) fn next_row(&mut self) -> [i32; LANES] {
        let ([a, b, c], [p, q, r]) = (self.first, &self.right);
        self.first = std::array::from_fn(|i| self.first[i] + self.down[i]);
        std::array::from_fn(|k| (a + p[k]) | (b + q[k]) | (c + r[k]))
    }
}

/// Smallest k with `k * b >= a`, for positive a and b.
#[inline(always)]
fn ceil_div(a: i64, b: i64) -> i64 {
    (a + b - 1) / b
}

/// Cull, clip and snap of some faces.
pub(super) struct Setup<'a> {
    pub(super) geometry: &'a Geometry,
    pub(super) screen: &'a [Screen],
    pub(super) viewport: Viewport,
    pub(super) cull: Cull<'a>,
    /// What the visit is compiled for.
    pub(super) isa: Isa,
    /// First and last sample place in a pixel, in sub-pixel units.
    pub(super) reach: [i64; 2],
}

impl Setup<'_> {
    /// Pixels that a primitive may touch.
    #[inline(always)]
    pub(super) fn bounds(&self, primitive: &Primitive) -> Bounds {
        primitive.bounds(&self.viewport, self.reach[0], self.reach[1])
    }

    /// Hands on the primitives of one face that may cover a sample.
    pub(super) fn face(&self, face: usize, mut emit: impl FnMut(Primitive)) {
        let corners = self.geometry.faces[face].map(|v| self.screen[v as usize]);
        let [a, b, c] = corners.map(|v| v.code);
        // Nothing is seen of a triangle that lies outside one plane with all its corners.
        if (a | b | c) & INVALID != 0 || a & b & c & !CUT != 0 {
            return;
        }
        if (a | b | c) & CUT == 0 {
            self.triangle(face, corners, None, &mut emit);
            return;
        }
        let corners = self.geometry.corners(face);
        let polygon = clip(corners, self.viewport.guard);
        let vertices = polygon.vertices();
        if vertices.len() < 3 || vertices.iter().any(|v| v[3].is_nan() || v[3] <= 0.0) {
            return;
        }
        // The sign of the homogeneous determinant is the orientation that survives any clipping.
        let front = determinant(corners) > 0.0;
        let first = self.viewport.snap(vertices[0]);
        for pair in vertices[1..].windows(2) {
            let rest = [self.viewport.snap(pair[0]), self.viewport.snap(pair[1])];
            self.triangle(face, [first, rest[0], rest[1]], Some(front), &mut emit);
        }
    }

    fn triangle(
        &self,
        face: usize,
        [a, b, c]: [Screen; 3],
        front: Option<bool>,
        emit: &mut impl FnMut(Primitive),
    ) {
        let d = |p: Screen, q: Screen| (i64::from(q.x) - i64::from(p.x), i64::from(q.y) - i64::from(p.y));
        let ((x1, y1), (x2, y2)) = (d(a, b), d(a, c));
        let area = x1 * y2 - x2 * y1;
        // With y down, counter-clockwise as seen is negative. A part whose snapped corners turned the other
        // way than its face is thinner than a sub-pixel unit.
        let seen_front = area < 0;
        if area == 0 || front.is_some_and(|front| front != seen_front) {
            return;
        }
        let culled = match self.cull {
            Cull::None => false,
            Cull::Back => !seen_front,
            Cull::Front => seen_front,
            Cull::BackOf(mask) => !seen_front && mask[face],
        };
        if culled {
            return;
        }
        let [a, b, c] = if seen_front { [a, c, b] } else { [a, b, c] };
        let primitive =
            Primitive { face: face as i32, x: [a.x, b.x, c.x], y: [a.y, b.y, c.y], z: [a.z, b.z, c.z] };
        if !self.bounds(&primitive).is_empty() {
            emit(primitive);
        }
    }
}

/// Determinant of the rows (x, y, w): positive where the corners run counter-clockwise with y up.
pub(super) fn determinant([a, b, c]: [[f64; 4]; 3]) -> f64 {
    a[0] * (b[1] * c[3] - c[1] * b[3]) - a[1] * (b[0] * c[3] - c[0] * b[3])
        + a[3] * (b[0] * c[1] - c[0] * b[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vertices at the limits of the guard band of the largest picture, every product redone in 128 bits,
    /// pixel by pixel.
    #[test]
    fn spans_agree_with_128_bit_edge_functions_at_the_limits() {
        let side = super::super::MAX_SIDE;
        let viewport = Viewport::new(side, side);
        let centre = side as i32 * 128;
        let limit = GUARD_PX as i32 * 256;
        let mut state = 7u64;
        let mut random = |n: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) % n) as i64
        };
        let mut seen = 0;
        for round in 0..400 {
            let mut coordinate = || match random(4) {
                0 => centre - limit,
                1 => centre + limit,
                2 => centre + random(1 << 12) as i32 - (1 << 11),
                _ => centre + (random(2 * limit as u64) - i64::from(limit)) as i32,
            };
            let (mut x, mut y) = ([0; 3], [0; 3]);
            for i in 0..3 {
                (x[i], y[i]) = (coordinate(), coordinate());
            }
            let wide = |v: i32| i128::from(v);
            let area = (wide(x[1]) - wide(x[0])) * (wide(y[2]) - wide(y[0]))
                - (wide(x[2]) - wide(x[0])) * (wide(y[1]) - wide(y[0]));
            if area == 0 {
                continue;
            }
            if area < 0 {
                x.swap(1, 2);
                y.swap(1, 2);
            }
            let primitive = Primitive { face: 0, x, y, z: [0.0; 3] };
            let sample = if round % 2 == 0 { [128, 128] } else { [8, 200] };
            let mut bounds = primitive.bounds(&viewport, sample[0].min(sample[1]), sample[0].max(sample[1]));
            if bounds.is_empty() {
                continue;
            }
            // Three rows of the full width suffice.
            let row = bounds.y[0] + random((bounds.y[1] - bounds.y[0] + 1) as u64);
            bounds.y = [row, (row + 2).min(bounds.y[1])];
            let mut rows = [(0, -1); 3];
            primitive.edges().spans(bounds, sample, |y, a, b| rows[(y - row) as usize] = (a, b));
            for py in bounds.y[0]..=bounds.y[1] {
                let (first, last) = rows[(py - row) as usize];
                for px in (0..side as i64).step_by(61).chain([first, first - 1, last, last + 1]) {
                    let (qx, qy) = (i128::from(px * 256 + sample[0]), i128::from(py * 256 + sample[1]));
                    let inside = (0..3).all(|i| {
                        let j = (i + 1) % 3;
                        let (dx, dy) = (wide(x[j]) - wide(x[i]), wide(y[j]) - wide(y[i]));
                        let e = dx * (qy - wide(y[i])) - dy * (qx - wide(x[i]));
                        e > 0 || (e == 0 && (dy < 0 || (dy == 0 && dx > 0)))
                    });
                    let within = (0..side as i64).contains(&px);
                    assert_eq!((first..=last).contains(&px), inside && within, "{x:?} {y:?} at {px} {py}");
                    seen += usize::from(inside && within);
                }
            }
        }
        assert!(seen > 1000);
    }

    #[test]
    fn snapping_rounds_down_at_halves_on_both_sides_of_zero() {
        let viewport = Viewport::new(16, 16);
        // 1/512 pixel is half a unit: clip x = -1 is pixel 0.
        for (px, expected) in [(0.0, 0), (1.0 / 512.0, 1), (-1.0 / 512.0, 0), (-3.0 / 512.0, -1), (1.0, 256)]
        {
            assert_eq!(viewport.project([px / 8.0 - 1.0, 0.0, 0.0, 1.0]).x, expected);
        }
    }
}
