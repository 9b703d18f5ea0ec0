//! Pieces of a picture as numbers that may be averaged: linear light, colour times alpha.

use crate::image::{Element, View};
use crate::kernel::remap::{self, Edge, Sample};
use crate::pyramid::Real;

/// What averages are computed in.
pub(super) trait Number: Real + remap::Real + Sample<Acc = Self> {}
impl Number for f32 {}
impl Number for f64 {}

/// Texels that follow one another along an axis, and what lies beyond them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    pub first: i64,
    pub count: usize,
    pub edge: Edge,
}

impl Span {
    /// Everything that interpolation between `low` and `high` reads of an axis of `n` texels.
    pub fn of([low, high]: [f64; 2], edge: Edge, n: usize) -> Self {
        /// Places are rounded to singles later, by less than this.
        const SLACK: f64 = 0.01;
        /// Farther out than any picture.
        const FAR: f64 = (1u64 << 32) as f64;
        let n = n as i64;
        let whole = |x: f64| x.clamp(-FAR, FAR).floor() as i64;
        let (low, high) = (whole(low - SLACK), whole(high + SLACK) + 1);
        let [first, last] = match edge {
            Edge::Repeat if high - low >= n => return Self { first: 0, count: n as usize, edge },
            Edge::Repeat => [low, high],
            // A texel of the border's colour at each end goes on.
            Edge::Border => [low.clamp(-1, n), high.clamp(-1, n)],
            _ => [low.clamp(0, n - 1), high.clamp(0, n - 1)],
        };
        Self { first, count: (last - first + 1) as usize, edge: Edge::Clamp }
    }
}

/// The texels of a piece, packed.
pub(super) fn gather<T: Element>(
    view: &View<'_, T>,
    [across, down]: [Span; 2],
    edges: [Edge; 2],
    border: &[T],
    out: &mut Vec<T>,
) {
    out.clear();
    let channels = view.channels();
    for y in 0..down.count as i64 {
        let row = edges[1].index(down.first + y, view.height() as i64).map(|y| view.row(y));
        let mut x = 0;
        while x < across.count {
            let at = edges[0].index(across.first + x as i64, view.width() as i64);
            let (Some(row), Some(at)) = (row, at) else {
                out.extend_from_slice(border);
                x += 1;
                continue;
            };
            let run = (view.width() - at).min(across.count - x);
            out.extend_from_slice(&row[at * channels..(at + run) * channels]);
            x += run;
        }
    }
}

/// The four texels around a place: upper left, upper right, lower left, lower right.
pub(super) fn four<T: Element>(
    view: &View<'_, T>,
    [x, y]: [i64; 2],
    edges: [Edge; 2],
    border: &[T],
    out: &mut Vec<T>,
) {
    for y in [y, y + 1] {
        let y = edges[1].index(y, view.height() as i64);
        for x in [x, x + 1] {
            let x = edges[0].index(x, view.width() as i64);
            out.extend_from_slice(x.zip(y).map_or(border, |(x, y)| view.pixel(x, y)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_what_edges_say() {
        let data: Vec<f32> = (0..20).map(|i| i as f32).collect();
        let view = View::new(&data, 5, 4, 1, 5).expect("fits");
        for edge in [Edge::Repeat, Edge::Clamp, Edge::Border] {
            for (low, high) in [(-7.3, -6.1), (-1.5, 0.2), (0.0, 3.9), (1.2, 9.7), (4.0, 4.5), (-20.0, 20.0)]
            {
                let across = Span::of([low, high], edge, 5);
                let down = Span::of([low, high], Edge::Clamp, 4);
                let mut piece = Vec::new();
                gather(&view, [across, down], [edge, Edge::Clamp], &[-1.0], &mut piece);
                assert_eq!(piece.len(), across.count * down.count);
                for k in 0..=40 {
                    let x = (low + (high - low) * f64::from(k) / 40.0).floor() as i64;
                    for x in [x, x + 1] {
                        let want = edge.index(x, 5).map_or(-1.0, |x| view.row(down.first as usize)[x]);
                        let there = across.edge.index(x - across.first, across.count as i64).expect("inside");
                        assert_eq!(piece[there], want, "{edge:?} {low} {high} {x}");
                    }
                }
            }
        }
        let mut texels = Vec::new();
        four(&view, [4, 3], [Edge::Repeat, Edge::Clamp], &[-1.0], &mut texels);
        four(&view, [i64::MAX - 1, 0], [Edge::Border; 2], &[-1.0], &mut texels);
        assert_eq!(texels, [19.0, 15.0, 19.0, 15.0, -1.0, -1.0, -1.0, -1.0]);
    }
}
