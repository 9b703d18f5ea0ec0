//! Within a tolerance: the mean over the footprint to no more than a given error, whatever the texture.
//!
//! A block of the texture ([`crate::bounds`]) has its mean, a plane and the largest distance from it, `stray`. The mean over a
//! part of the block, as the plane has it at the part's centroid, is wrong by `stray` at most; and because block and plane
//! have the same mean, by `stray` times what is left of the block if that is less than the part. So:
//!
//! 1. A footprint over at most 2 x 2 blocks, seen as one plane: if nothing in these strays from it by more than the
//!    tolerance, its height at the centre is the answer. Flat and smooth pictures end here, at any size of footprint.
//! 2. A footprint of at most [`SMALL`] texels a side: the integral itself ([`super::cells`]).
//! 3. Otherwise the footprint is cut into the blocks that it touches. Blocks inside count by their means, exactly; of the
//!    parts on the rim those stay whose errors sum to less than half of what is left of the tolerance, the others are
//!    cut again, down to blocks of 8 x 8, which are integrated. So detail is looked at only where it may matter: the
//!    number of parts grows with contrast over tolerance, and not with the footprint.
//!
//! Where the texture repeats, turns round or ends, the footprint is folded ([`super::fold`]) before.
//!
//! Cost: four blocks to, at worst, the cells of the rim.

use super::cells;
use super::fold::{Fold, Part};
use super::polygon::Polygon;
use crate::bounds::{Bounds, FINEST, FIRST};
use crate::filter::{Query, Reader, bilinear, exact};
use crate::num::{Real, floor};
use crate::texel::Texel;
use crate::texture::Decode;
use std::cell::RefCell;

/// Extent below which a footprint is integrated at once.
const SMALL: f64 = 20.0;
/// Below this extent, in texels, a footprint is a point.
const POINT: f64 = 1e-9;
/// Parts of a footprint that are worth their time.
const MOST_PARTS: f64 = 1_048_576.0;
/// What rounding may add to an error, as a share of the largest texel: sums of means in singles.
const ROUNDING: f64 = 1e-6;
/// A footprint thinner than this share of its length is left to [`exact`], whose sums have no negative terms.
const THIN: f64 = 1e-6;

/// An average and what it cost.
pub(crate) struct Found<R> {
    pub average: [R; 4],
    /// Blocks and texels that were read.
    pub reads: f64,
    /// Their level, by share of the footprint: the side of the blocks, 0 for texels.
    pub lod: f64,
}

/// A piece of a footprint in a block.
#[derive(Clone, Copy)]
struct Piece {
    polygon: Polygon,
    weight: f64,
    /// Share of the footprint.
    share: f64,
    value: [f64; 4],
    /// Bound of what its value adds to the footprint's error.
    error: f64,
    level: u32,
    at: [i64; 2],
}

#[derive(Default)]
struct Scratch {
    pieces: Vec<Piece>,
    next: Vec<Piece>,
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

/// The mean over the footprint, wrong by `tolerance` (in units of averages) at most.
pub(super) fn within<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    bounds: &Bounds,
    query: &Query,
    tolerance: f64,
) -> Found<T::Real> {
    let mut entries = query.jacobian_tx.m;
    if !query.jacobian_tx.is_finite() {
        return Found {
            average: bilinear(r, r.last_level(), query.s, query.t),
            reads: 4.0,
            lod: r.last_level() as f64,
        };
    }
    if entries.iter().flatten().all(|x| x.abs() < POINT) {
        return Found { average: bilinear(r, 0, query.s, query.t), reads: 4.0, lod: 0.0 };
    }
    let extent = entries.map(|row| row[0].abs() + row[1].abs());
    let longest = extent[0].max(extent[1]);
    let area = query.jacobian_tx.det().abs();
    let tolerance = tolerance - ROUNDING * bounds.largest;
    if !bounds.is_finite || tolerance <= 0.0 || area <= THIN * longest * longest.max(1.0) {
        return Found { average: exact(r, query), reads: 2.0 * longest + area + 4.0, lod: 0.0 };
    }
    let plane = &r.layers.planes[0];
    let size = [f64::from(plane.width), f64::from(plane.height)];
    let centre = [(0, query.s), (1, query.t)].map(|(axis, place)| {
        // In the first period, turned if that is.
        let (place, sign) = r.layers.wrap[axis].reduce(place, size[axis]);
        entries[axis] = entries[axis].map(|x| x * sign);
        let reach = 0.5 * extent[axis] + size[axis] + 4.0;
        (place - 0.5).clamp(-reach, reach)
    });
    let footprint = Polygon::parallelogram(centre, entries);
    let real = |value: [f64; 4]| value.map(T::Real::from_f64);
    let inside = (0..2)
        .all(|k| centre[k] - 0.5 * extent[k] >= FIRST as f64 + 1.0 && centre[k] + 0.5 * extent[k] <= size[k]);
    let mut tally =
        Tally { bounds, footprint: area, mean: [0.0; 4], share: 0.0, left: tolerance, reads: 0.0, lod: 0.0 };
    if inside {
        let (value, error) = tally.as_one(centre, extent);
        if error <= tolerance {
            return Found { average: real(value), reads: tally.reads, lod: level_of(longest).into() };
        }
        if longest <= SMALL {
            let average = real(cells::mean(r, &footprint, footprint.area().0));
            let texels = (extent[0] + 2.0) * (extent[1] + 2.0);
            return Found { average, reads: tally.reads + texels, lod: 0.0 };
        }
    }
    let fold = Fold::new(r.layers.wrap, plane.width, plane.height);
    // Seen as its mean alone: what is wrong lies in periods that the outline crosses.
    if fold.period().is_finite() {
        let [[a, b], [c, d]] = entries;
        let outline = 2.0 * (a.hypot(c) + b.hypot(d));
        let rim = 2.0 * fold.diagonal() * (outline + 2.0 * fold.diagonal());
        if 0.5 * bounds.stray * rim / area <= tolerance {
            return Found { average: real(bounds.mean), reads: 1.0, lod: r.last_level() as f64 };
        }
    }
    if fold.count(&footprint) > MOST_PARTS {
        return Found { average: exact(r, query), reads: MOST_PARTS, lod: 0.0 };
    }
    SCRATCH.with_borrow_mut(|scratch| {
        scratch.pieces.clear();
        let whole = fold.parts(footprint, &mut |part| tally.place(&part, inside, &mut scratch.pieces));
        if whole > 0.0 {
            tally.add(whole * fold.period() / area, bounds.mean, bounds.coarsest());
        }
        tally.refine(r, scratch);
    });
    let average = real(tally.mean.map(|m| m / tally.share));
    Found { average, reads: tally.reads, lod: tally.lod / tally.share }
}

/// A sum of pieces under construction.
struct Tally<'a> {
    bounds: &'a Bounds,
    /// Area of the footprint.
    footprint: f64,
    mean: [f64; 4],
    share: f64,
    /// What is left of the tolerance.
    left: f64,
    reads: f64,
    /// Sum of shares times levels.
    lod: f64,
}

impl Tally<'_> {
    fn add(&mut self, share: f64, value: [f64; 4], level: u32) {
        self.share += share;
        self.lod += share * f64::from(level);
        for (mean, value) in self.mean.iter_mut().zip(value) {
            *mean += share * value;
        }
    }

    /// What lies within `extent` of a centre as one plane: its height at the centre, and how far anything strays from it.
    fn as_one(&mut self, centre: [f64; 2], extent: [f64; 2]) -> ([f64; 4], f64) {
        let longest = extent[0].max(extent[1]).max((1 << FINEST) as f64);
        let level = level_of(longest).min(self.bounds.coarsest());
        let side = (1u64 << level) as f64;
        let from = |axis: usize, sign: f64| centre[axis] + 0.5 * sign * extent[axis] - FIRST as f64;
        let [(i0, i1), (j0, j1)] =
            [0, 1].map(|axis| (floor(from(axis, -1.0) / side), floor(from(axis, 1.0) / side)));
        let middle = |k: i64| (k as f64 + 0.5) * side + FIRST as f64;
        let blocks = (i1 - i0 + 1) as f64 * (j1 - j0 + 1) as f64;
        self.reads += blocks;
        if blocks == 1.0 {
            let block = self.bounds.block(level, i0, j0);
            let value = block.plane(centre[0] - middle(i0), centre[1] - middle(j0));
            return (value, block.stray.iter().fold(0.0, |a, s| f64::max(a, (*s).into())));
        }
        let (mut value, mut slope) = ([0.0; 4], [[0.0; 4]; 2]);
        let each = || (j0..=j1).flat_map(move |j| (i0..=i1).map(move |i| (i, j)));
        for (i, j) in each() {
            let block = self.bounds.block(level, i, j);
            let height = block.plane(centre[0] - middle(i), centre[1] - middle(j));
            for c in 0..4 {
                value[c] += height[c] / blocks;
                slope[0][c] += f64::from(block.slope[0][c]) / blocks;
                slope[1][c] += f64::from(block.slope[1][c]) / blocks;
            }
        }
        let mut error = 0.0f64;
        for (i, j) in each() {
            let block = self.bounds.block(level, i, j);
            // The part of the block within the bounds: its middle and half its sides.
            let [x, y] = [(0, i), (1, j)].map(|(axis, k)| {
                let (low, high) = (k as f64 * side, (k + 1) as f64 * side);
                let (low, high) = (low.max(from(axis, -1.0)), high.min(from(axis, 1.0)));
                (0.5 * (low + high) + FIRST as f64, 0.5 * (high - low).max(0.0))
            });
            let height = block.plane(x.0 - middle(i), y.0 - middle(j));
            for c in 0..4 {
                let one = value[c] + (x.0 - centre[0]) * slope[0][c] + (y.0 - centre[1]) * slope[1][c];
                let tilt = x.1 * (f64::from(block.slope[0][c]) - slope[0][c]).abs()
                    + y.1 * (f64::from(block.slope[1][c]) - slope[1][c]).abs();
                error = error.max((height[c] - one).abs() + tilt + f64::from(block.stray[c]));
            }
        }
        (value, error)
    }

    /// Puts a part of the footprint into the blocks that it touches.
    fn place(&mut self, part: &Part, seen: bool, pieces: &mut Vec<Piece>) {
        let [x, y] = [0, 1].map(|axis| {
            let (low, high) = part.polygon.range(axis);
            (low - FIRST as f64, high - FIRST as f64)
        });
        let longest = (x.1 - x.0).max(y.1 - y.0);
        // What did not do as one plane will not do as four.
        let level = level_of(if seen { 0.5 * longest } else { longest }).min(self.bounds.coarsest());
        let side = (1u64 << level) as f64;
        let mut rest = Some(part.polygon);
        let (j0, j1) = (floor(y.0 / side), floor(y.1 / side));
        for j in j0..=j1 {
            let Some(polygon) = rest else { break };
            let edge = (j + 1) as f64 * side + FIRST as f64;
            let [row, above] = if j < j1 { polygon.split(1, edge) } else { [Some(polygon), None] };
            rest = above;
            let Some(row) = row else { continue };
            let (low, high) = row.range(0);
            let (i0, i1) = (floor((low - FIRST as f64) / side), floor((high - FIRST as f64) / side));
            let mut rest = Some(row);
            for i in i0..=i1 {
                let Some(polygon) = rest else { break };
                let edge = (i + 1) as f64 * side + FIRST as f64;
                let [piece, right] = if i < i1 { polygon.split(0, edge) } else { [Some(polygon), None] };
                rest = right;
                if let Some(piece) = piece {
                    self.piece(piece, part.weight, level, [i, j], pieces);
                }
            }
        }
    }

    /// A polygon within a block: added where it is the whole block, else kept.
    fn piece(&mut self, polygon: Polygon, weight: f64, level: u32, at: [i64; 2], pieces: &mut Vec<Piece>) {
        let (area, centroid) = polygon.area();
        let area = area.abs();
        let share = area * weight / self.footprint;
        if share == 0.0 {
            return;
        }
        self.reads += 1.0;
        let block = self.bounds.block(level, at[0], at[1]);
        let side = (1u64 << level) as f64;
        let rest = side * side - area;
        let from = |axis: usize| centroid[axis] - (at[axis] as f64 + 0.5) * side - FIRST as f64;
        let value = block.plane(from(0), from(1));
        let stray = block.stray.iter().fold(0.0, |a, s| f64::max(a, (*s).into()));
        let least = if self.bounds.is_complete(level, at[0], at[1]) { rest.clamp(0.0, area) } else { area };
        if least <= 1e-9 * area {
            return self.add(share, value, level);
        }
        let error = stray * share * (least / area);
        pieces.push(Piece { polygon, weight, share, value, error, level, at });
    }

    /// Cuts pieces until their errors fit into the tolerance.
    fn refine<T: Texel, D: Decode<T>>(&mut self, r: &Reader<'_, T, D>, scratch: &mut Scratch) {
        let Scratch { pieces, next } = scratch;
        while !pieces.is_empty() {
            let total: f64 = pieces.iter().map(|p| p.error).sum();
            let most = if total <= self.left { f64::INFINITY } else { 0.5 * self.left / pieces.len() as f64 };
            next.clear();
            for piece in pieces.iter() {
                if piece.error <= most {
                    self.left -= piece.error;
                    self.add(piece.share, piece.value, piece.level);
                } else if piece.level == FINEST {
                    let (area, _) = piece.polygon.area();
                    self.reads += 81.0;
                    self.add(piece.share, cells::mean(r, &piece.polygon, area), 0);
                } else {
                    self.cut(piece, next);
                }
            }
            std::mem::swap(pieces, next);
        }
    }

    fn cut(&mut self, piece: &Piece, next: &mut Vec<Piece>) {
        let half = (1u64 << (piece.level - 1)) as f64;
        let middle = |axis: usize| (2 * piece.at[axis] + 1) as f64 * half + FIRST as f64;
        for (j, row) in piece.polygon.split(1, middle(1)).into_iter().enumerate() {
            let Some(row) = row else { continue };
            for (i, quarter) in row.split(0, middle(0)).into_iter().enumerate() {
                if let Some(quarter) = quarter {
                    let at = [2 * piece.at[0] + i as i64, 2 * piece.at[1] + j as i64];
                    self.piece(quarter, piece.weight, piece.level - 1, at, next);
                }
            }
        }
    }
}

/// The level whose blocks are at least this long.
#[inline(always)]
fn level_of(length: f64) -> u32 {
    let mut level = FINEST;
    while ((1u64 << level) as f64) < length && level < 62 {
        level += 1;
    }
    level
}
