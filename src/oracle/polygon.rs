//! Small convex polygons in the pixel's plane, and cutting them along lines.

/// A point of the pixel's plane: pixels right and down from the pixel's centre.
pub(super) type Point = [f64; 2];

/// Corners a polygon can have: a square cut by five lines has at most nine; the rest is for rounding.
const CAPACITY: usize = 16;

/// A linear function `a s + b t + c` of the pixel's plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Form {
    pub(super) a: f64,
    pub(super) b: f64,
    pub(super) c: f64,
}

impl Form {
    pub(super) fn at(self, [s, t]: Point) -> f64 {
        self.a * s + self.b * t + self.c
    }

    /// `self + factor * other`.
    pub(super) fn plus(self, factor: f64, other: Self) -> Self {
        Self { a: self.a + factor * other.a, b: self.b + factor * other.b, c: self.c + factor * other.c }
    }

    pub(super) fn negated(self) -> Self {
        Self { a: -self.a, b: -self.b, c: -self.c }
    }
}

/// A convex polygon, its corners in order.
#[derive(Clone, Copy, Debug)]
pub(super) struct Polygon {
    len: usize,
    corners: [Point; CAPACITY],
}

impl Polygon {
    const EMPTY: Self = Self { len: 0, corners: [[0.0; 2]; CAPACITY] };

    pub(super) fn new(corners: &[Point]) -> Self {
        let mut polygon = Self::EMPTY;
        corners.iter().for_each(|&corner| polygon.push(corner));
        polygon
    }

    /// The rectangle between two opposite corners.
    pub(super) fn rectangle([s0, t0]: Point, [s1, t1]: Point) -> Self {
        Self::new(&[[s0, t0], [s1, t0], [s1, t1], [s0, t1]])
    }

    fn push(&mut self, corner: Point) {
        if self.len < CAPACITY {
            self.corners[self.len] = corner;
            self.len += 1;
        }
    }

    pub(super) fn corners(&self) -> &[Point] {
        &self.corners[..self.len]
    }

    /// Whether fewer than three corners are left.
    pub(super) fn is_flat(&self) -> bool {
        self.len < 3
    }

    /// The parts where `line` is negative and where it is positive. Both get the same new corners, so their
    /// areas sum to the whole's.
    pub(super) fn split(&self, line: Form) -> (Self, Self) {
        let (mut negative, mut positive) = (Self::EMPTY, Self::EMPTY);
        for (i, &corner) in self.corners().iter().enumerate() {
            let next = self.corners[(i + 1) % self.len];
            let (here, there) = (line.at(corner), line.at(next));
            if here <= 0.0 {
                negative.push(corner);
            }
            if here >= 0.0 {
                positive.push(corner);
            }
            if (here < 0.0 && there > 0.0) || (here > 0.0 && there < 0.0) {
                let share = here / (here - there);
                let crossing =
                    [corner[0] + share * (next[0] - corner[0]), corner[1] + share * (next[1] - corner[1])];
                negative.push(crossing);
                positive.push(crossing);
            }
        }
        (negative, positive)
    }

    /// Triangles that fill the polygon.
    pub(super) fn triangles(&self) -> impl Iterator<Item = [Point; 3]> + '_ {
        (2..self.len).map(|i| [self.corners[0], self.corners[i - 1], self.corners[i]])
    }
}

/// Twice the area of a triangle, never negative.
pub(super) fn twice_area([a, b, c]: [Point; 3]) -> f64 {
    ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(polygon: &Polygon) -> f64 {
        polygon.triangles().map(|t| 0.5 * twice_area(t)).sum()
    }

    #[test]
    fn parts_sum_to_the_whole() {
        let square = Polygon::rectangle([-0.5, -0.5], [0.5, 0.5]);
        for i in 0..100 {
            let angle = f64::from(i) * 0.7;
            let line = Form { a: angle.cos(), b: angle.sin(), c: f64::from(i % 11) * 0.1 - 0.5 };
            let (negative, positive) = square.split(line);
            assert!((area(&negative) + area(&positive) - 1.0).abs() < 1e-15);
        }
        let (left, right) = square.split(Form { a: 1.0, b: 0.0, c: 0.25 });
        assert!((area(&left) - 0.25).abs() < 1e-15 && (area(&right) - 0.75).abs() < 1e-15);
        let (none, all) = square.split(Form { a: 0.0, b: 0.0, c: 1.0 });
        assert!(none.is_flat() && area(&all) == 1.0);
    }
}
