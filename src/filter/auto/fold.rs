//! From the endless plane to the texture and its nearest surroundings: a footprint cut where the texture repeats, turns
//! round or ends.
//!
//! With texel centres on whole numbers: periodic axes are cut into periods, which are moved (and turned) to the first;
//! what lies beyond the end of another axis sees one colour across, so it may as well be as narrow as a cell.

use super::polygon::Polygon;
use crate::num::floor;
use crate::wrap::Wrap;

/// A part of a footprint over the texture: its area counts `weight` times.
pub(super) struct Part {
    pub polygon: Polygon,
    pub weight: f64,
}

/// Where an axis of `n` texels is cut.
#[derive(Clone, Copy)]
struct Folds {
    wrap: Wrap,
    n: f64,
    /// First place of the first period, and the length of a period.
    start: f64,
    length: f64,
}

impl Folds {
    fn new(wrap: Wrap, n: i32) -> Self {
        let n = f64::from(n);
        let (start, length) = match wrap {
            Wrap::Repeat | Wrap::Mirror => (-0.5, n),
            Wrap::Mirror101 => (0.0, (n - 1.0).max(1.0)),
            _ => (0.0, f64::INFINITY),
        };
        Self { wrap, n, start, length }
    }

    fn is_periodic(&self) -> bool {
        self.length.is_finite()
    }

    /// The period that holds a place.
    fn period(&self, x: f64) -> i64 {
        floor((x - self.start) / self.length)
    }

    /// Where a period begins.
    fn begin(&self, k: i64) -> f64 {
        self.start + k as f64 * self.length
    }

    /// A polygon of period `k`, moved to the first.
    fn moved(&self, polygon: Polygon, axis: usize, k: i64) -> Polygon {
        if self.wrap != Wrap::Repeat && k.rem_euclid(2) == 1 {
            polygon.mapped(axis, -1.0, self.begin(k + 1) + self.start)
        } else {
            polygon.mapped(axis, 1.0, -(k as f64) * self.length)
        }
    }
}

/// A footprint whose parts are sought.
pub(super) struct Fold {
    folds: [Folds; 2],
}

impl Fold {
    pub fn new(wrap: [Wrap; 2], width: i32, height: i32) -> Self {
        Self { folds: [Folds::new(wrap[0], width), Folds::new(wrap[1], height)] }
    }

    /// About how many parts the polygon has.
    pub fn count(&self, polygon: &Polygon) -> f64 {
        let along = |axis: usize| {
            let folds = self.folds[axis];
            let (low, high) = polygon.range(axis);
            if folds.is_periodic() { (high - low) / folds.length + 1.0 } else { 3.0 }
        };
        // Of whole periods along both axes only those that the outline crosses are visited.
        let [x, y] = [along(0), along(1)];
        if self.folds.iter().all(Folds::is_periodic) { 2.0 * (x + y) } else { x * y }
    }

    /// Hands out the parts. Whole periods of both axes are counted, and their number returned.
    pub fn parts(&self, polygon: Polygon, emit: &mut impl FnMut(Part)) -> f64 {
        let [across, along] = self.folds;
        let mut whole = 0.0;
        along.axis(polygon, 1, 1.0, &mut |row, weight, period| {
            let band = period.map(|k| (along.begin(k), along.begin(k + 1)));
            let full = band.filter(|_| across.is_periodic()).and_then(|(y0, y1)| {
                let (bottom, top) = (row.range_on(1, y0)?, row.range_on(1, y1)?);
                let (left, right) = (bottom.0.max(top.0), bottom.1.min(top.1));
                let (first, last) = (across.period(left) + 1, across.period(right) - 1);
                let clear = left < right && first <= last;
                clear.then_some((first, last))
            });
            let row = match period {
                Some(k) => along.moved(row, 1, k),
                None => row,
            };
            let Some((first, last)) = full else {
                return across.axis(row, 0, weight, &mut |part, weight, k| {
                    let polygon = k.map_or(part, |k| across.moved(part, 0, k));
                    emit(Part { polygon, weight });
                });
            };
            whole += (last - first + 1) as f64;
            let [left, rest] = row.split(0, across.begin(first));
            let right = rest.and_then(|rest| rest.split(0, across.begin(last + 1))[1]);
            for side in [left, right].into_iter().flatten() {
                across.axis(side, 0, weight, &mut |part, weight, k| {
                    let polygon = k.map_or(part, |k| across.moved(part, 0, k));
                    emit(Part { polygon, weight });
                });
            }
        });
        whole
    }

    /// Texels of a whole period.
    pub fn period(&self) -> f64 {
        self.folds[0].length * self.folds[1].length
    }

    /// Length of a period's diagonal.
    pub fn diagonal(&self) -> f64 {
        self.folds[0].length.hypot(self.folds[1].length)
    }
}

impl Folds {
    /// Cuts along one axis: pieces with their weight, and with their period where there is one.
    fn axis(
        &self,
        polygon: Polygon,
        axis: usize,
        weight: f64,
        emit: &mut impl FnMut(Polygon, f64, Option<i64>),
    ) {
        if self.is_periodic() {
            let (low, high) = polygon.range(axis);
            let (first, last) = (self.period(low), self.period(high));
            let mut rest = Some(polygon);
            for k in first..=last {
                let Some(polygon) = rest else { break };
                let [part, after] =
                    if k < last { polygon.split(axis, self.begin(k + 1)) } else { [Some(polygon), None] };
                if let Some(part) = part {
                    emit(part, weight, Some(k));
                }
                rest = after;
            }
            return;
        }
        // Between these the picture changes.
        let (first, last) = match self.wrap {
            Wrap::Border | Wrap::Extend => (-1.0, self.n),
            _ => (0.0, self.n - 1.0),
        };
        let mut straight = |part: Polygon| {
            let [inside, above] = part.split(axis, last);
            if let Some((above, weight)) = above.and_then(|part| squashed(part, axis, weight, last)) {
                emit(above, weight, None);
            }
            if let Some(inside) = inside {
                emit(inside, weight, None);
            }
        };
        if self.wrap == Wrap::MirrorOnce {
            let [turned, rest] = polygon.split(axis, -0.5);
            turned.map(|part| part.mapped(axis, -1.0, -1.0)).into_iter().chain(rest).for_each(straight);
            return;
        }
        let [below, rest] = polygon.split(axis, first);
        if let Some(rest) = rest {
            straight(rest);
        }
        if let Some((below, weight)) = below.and_then(|part| squashed(part, axis, weight, first - 1.0)) {
            emit(below, weight, None);
        }
    }
}

/// A polygon made as wide as a cell, from a place on; `None` for one without width.
fn squashed(polygon: Polygon, axis: usize, weight: f64, from: f64) -> Option<(Polygon, f64)> {
    let (low, high) = polygon.range(axis);
    let width = high - low;
    let scale = 1.0 / width;
    (width > 0.0 && scale.is_finite())
        .then(|| (polygon.mapped(axis, scale, from - low * scale), weight * width))
}
