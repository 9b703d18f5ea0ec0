//! Convex polygons of few corners: what is left of a footprint in a block of texels.

/// Most corners: four sides, and one for each line that cuts.
const MOST: usize = 20;

/// Corners in order, either way round.
#[derive(Clone, Copy, Debug)]
pub(super) struct Polygon {
    corners: [[f64; 2]; MOST],
    len: usize,
}

impl Polygon {
    /// The parallelogram around a centre with these sides.
    pub fn parallelogram([x, y]: [f64; 2], [[a, b], [c, d]]: [[f64; 2]; 2]) -> Self {
        let mut corners = [[0.0; 2]; MOST];
        for (k, (p, q)) in [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].into_iter().enumerate() {
            corners[k] = [x + a * p + b * q, y + c * p + d * q];
        }
        Self { corners, len: 4 }
    }

    pub fn corners(&self) -> &[[f64; 2]] {
        &self.corners[..self.len]
    }

    fn push(&mut self, corner: [f64; 2]) {
        if self.len < MOST {
            self.corners[self.len] = corner;
            self.len += 1;
        }
    }

    /// Least and largest coordinate along an axis.
    pub fn range(&self, axis: usize) -> (f64, f64) {
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        for corner in self.corners() {
            range = (range.0.min(corner[axis]), range.1.max(corner[axis]));
        }
        range
    }

    /// Range of the other axis on a line where this axis has one coordinate; `None` where no corner lies on it.
    pub fn range_on(&self, axis: usize, at: f64) -> Option<(f64, f64)> {
        let on = self.corners().iter().filter(|c| c[axis] == at).map(|c| c[1 - axis]);
        on.fold(None, |range, x| {
            let (low, high) = range.unwrap_or((x, x));
            Some((x.min(low), x.max(high)))
        })
    }

    /// The parts below and above a coordinate along an axis; `None` for a part without corners.
    pub fn split(&self, axis: usize, at: f64) -> [Option<Self>; 2] {
        let (low, high) = self.range(axis);
        if high <= at {
            return [Some(*self), None];
        }
        if low >= at {
            return [None, Some(*self)];
        }
        let empty = Self { corners: [[0.0; 2]; MOST], len: 0 };
        let (mut below, mut above) = (empty, empty);
        let corners = self.corners();
        let mut p = corners[corners.len() - 1];
        for &q in corners {
            if (p[axis] < at && q[axis] > at) || (p[axis] > at && q[axis] < at) {
                let f = (at - p[axis]) / (q[axis] - p[axis]);
                let other = p[1 - axis] + f * (q[1 - axis] - p[1 - axis]);
                let cut = if axis == 0 { [at, other] } else { [other, at] };
                below.push(cut);
                above.push(cut);
            }
            if q[axis] <= at {
                below.push(q);
            }
            if q[axis] >= at {
                above.push(q);
            }
            p = q;
        }
        [Some(below), Some(above)]
    }

    /// Every coordinate along an axis as `scale` times it plus `shift`.
    pub fn mapped(mut self, axis: usize, scale: f64, shift: f64) -> Self {
        for corner in &mut self.corners[..self.len] {
            corner[axis] = scale * corner[axis] + shift;
        }
        self
    }

    /// The area, positive if corners go from x to y, and the centroid; a corner for a polygon without area.
    pub fn area(&self) -> (f64, [f64; 2]) {
        let corners = self.corners();
        let o = corners[0];
        let (mut twice, mut moment) = (0.0, [0.0; 2]);
        for pair in corners[1..].windows(2) {
            let [p, q] = [0, 1].map(|k| [pair[k][0] - o[0], pair[k][1] - o[1]]);
            let cross = p[0] * q[1] - p[1] * q[0];
            twice += cross;
            moment[0] += cross * (p[0] + q[0]);
            moment[1] += cross * (p[1] + q[1]);
        }
        if twice == 0.0 {
            return (0.0, o);
        }
        (0.5 * twice, [o[0] + moment[0] / (3.0 * twice), o[1] + moment[1] / (3.0 * twice)])
    }
}
