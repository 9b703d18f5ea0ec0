//! The soft parallelogram of [`Soft`] over textures of bytes, in whole numbers.
//!
//! Sixteen texels at a time: eight of two rows, or sixteen of one. With `K` half the width of a strip and `P` the distance from
//! its centre line, both over the softness,
//!
//! ```text
//! a = K - P,  b = K + P, cut to -1..1                to 1/2^11; saturated at 16 first: far inside is far inside
//! T = a (1 - |a|/2) + b (1 - |b|/2),  T' = |a| - |b|   to 1/2^14
//! w = T1 T2 + (n1 . n2)/6 T1' T2', at least 0          to 1/2^13
//! ```
//!
//! What weights round to (4e-4 of a texel at an edge) is a tenth of what a soft parallelogram gets wrong at best. Sums of weights
//! times codes are whole numbers: exact in any order, and equal texels give exactly their code. Sums in singles need an
//! addition and a product for four channels where `pmaddwd` has four of both. Vectors of 512 bits were slower: most footprints
//! are two to ten blocks, and what is done once a footprint weighs as much.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod scalar;
#[cfg(test)]
mod tests;

use super::Isa;
use super::plane::Plane;
use super::window::Soft;
use crate::num::{ceil, floor};

/// Bytes that are read for eight texels of up to four channels.
pub const READ: usize = 32;
/// Largest half extent, in texels, whose distances fit.
const FARTHEST: f64 = 500.0;
/// Least half width of a strip, in texels: weights are good to a few thousandths of themselves.
const LEAST: f64 = 0.25;
/// Blocks whose sums, all added up, fit 32 bits: 16 texels of weight 2^13 times 255.
const DRAIN: u32 = 64;
/// Fractional bits of distances.
const BITS: u32 = 20;
/// The same of what weights are made from.
const FINE: u32 = 11;
/// One, to that many.
const ONE: i16 = 1 << FINE;
/// Texels of a block.
const TEXELS: usize = 16;

/// Texels from anywhere.
pub trait Texels {
    /// Eight texels from (x, y) on along the row, as far apart as those of the plane.
    fn eight(&self, x: i32, y: i32, texels: &mut [u8; READ]);
}

/// How the texels of a block lie, and what weighs them.
struct Frame {
    /// Bytes from texel to texel, and how many of them count.
    lanes: usize,
    channels: usize,
    /// From the block's middle to its texels, in half texels, times 2^11.
    places: &'static [[i16; TEXELS]; 2],
    /// Distance that a texel along x and along y makes, for both strips, times 2^14.
    slopes: [[i16; 2]; 2],
    /// Which strips are narrower than their edges.
    narrow: [bool; 2],
    /// What the product of both slopes is multiplied by, times 2^15.
    covariance: i16,
}

const WIDE: [[i16; TEXELS]; 2] = places(16);
const TALL: [[i16; TEXELS]; 2] = places(8);

/// See [`Frame::places`], for so many texels a row.
const fn places(width: usize) -> [[i16; TEXELS]; 2] {
    let mut places = [[0; TEXELS]; 2];
    let mut i = 0;
    while i < TEXELS {
        let (x, y) = (i % width, i / width);
        places[0][i] = ONE * (2 * x as i16 - (width as i16 - 1));
        places[1][i] = ONE * (2 * y as i16 - (TEXELS / width) as i16 + 1);
        i += 1;
    }
    places
}

/// Weighted sums of codes, and of weights.
#[derive(Clone, Copy, Default)]
struct Sums {
    codes: [i64; 4],
    weight: i64,
}

/// Sums under construction.
trait Block {
    fn new(frame: &Frame) -> Self;
    /// Adds 16 texels, eight in either half. `edges` are `a` and `b` of the first strip in the middle of the block, then of the
    /// second, in units of 2^-20.
    fn add(&mut self, edges: [i32; 4], texels: [&[u8; READ]; 2]);
    /// What there is; nothing is left.
    fn drain(&mut self) -> Sums;
}

/// Whether [`soft`] can read a footprint on a plane.
#[inline(always)]
pub fn fits(footprint: &Soft, plane: &Plane<'_, u8>) -> bool {
    let Soft { extent: [x, y], strips: [p, q], softness, .. } = footprint;
    let near = *x <= FARTHEST && *y <= FARTHEST;
    near && p.half >= LEAST && q.half >= LEAST && *softness >= 0.7 && plane.lanes <= 4
}

/// The mean of the codes under a footprint that [`fits`]. What the plane does not have comes from `rest`;
/// texels of no weight may be anything.
#[inline(always)]
pub fn soft(isa: Isa, footprint: &Soft, plane: &Plane<'_, u8>, rest: &impl Texels) -> [f64; 4] {
    match isa {
        // SAFETY: a set beyond `Sse2` is in use only where the machine has it, and all of them have AVX2.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 | Isa::Avx512 if isa.is_supported() => unsafe { with_avx2(footprint, plane, rest) },
        _ => over::<scalar::Scalar>(footprint, plane, rest),
    }
}

/// # Safety
/// The machine must have AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
unsafe fn with_avx2(footprint: &Soft, plane: &Plane<'_, u8>, rest: &impl Texels) -> [f64; 4] {
    over::<avx2::Avx2>(footprint, plane, rest)
}

/// A number times 2^20, rounded.
#[inline(always)]
fn fixed(x: f64) -> i32 {
    floor(x * f64::from(1 << BITS) + 0.5) as i32
}

/// Distances from both strips' sides over the blocks of a footprint.
struct Edges {
    /// In the middle of the first block.
    start: [i32; 4],
    /// Added for a texel along x, and along y.
    along: [[i32; 4]; 2],
}

impl Edges {
    /// Of the block whose middle is `[dx, dy]` from the centre.
    #[inline(always)]
    fn new(f: &Soft, [dx, dy]: [f64; 2], sharpness: f64) -> Self {
        let [p, q] = &f.strips;
        let ([px, py], [qx, qy]) = (p.normal, q.normal);
        let [half_p, half_q] = [fixed(p.half * sharpness), fixed(q.half * sharpness)];
        let at_p = fixed((px * dx + py * dy) * sharpness);
        let at_q = fixed((qx * dx + qy * dy) * sharpness);
        let along = |a: f64, b: f64| {
            let (a, b) = (fixed(a * sharpness), fixed(b * sharpness));
            [-a, a, -b, b]
        };
        let start = [half_p - at_p, half_p + at_p, half_q - at_q, half_q + at_q];
        Self { start, along: [along(px, qx), along(py, qy)] }
    }

    /// The block so many texels further.
    #[inline(always)]
    fn at(&self, x: i32, y: i32) -> [i32; 4] {
        let [dx, dy] = &self.along;
        std::array::from_fn(|k| {
            self.start[k].wrapping_add(dx[k].wrapping_mul(x)).wrapping_add(dy[k].wrapping_mul(y))
        })
    }
}

/// See [`soft`].
#[inline(always)]
fn over<B: Block>(f: &Soft, plane: &Plane<'_, u8>, rest: &impl Texels) -> [f64; 4] {
    let ([cx, cy], [reach_x, reach_y]) = (f.centre, f.extent);
    let (left, right) = (ceil(cx - reach_x) as i32, floor(cx + reach_x) as i32);
    let (top, bottom) = (ceil(cy - reach_y) as i32, floor(cy + reach_y) as i32);
    let tall = right - left < 8;
    let sharpness = 1.0 / f.softness;
    let [p, q] = &f.strips;
    let slope = |x: f64| floor(x * sharpness * 16_384.0 + 0.5) as i16;
    let frame = Frame {
        lanes: plane.lanes,
        channels: plane.channels,
        places: if tall { &TALL } else { &WIDE },
        slopes: [[slope(p.normal[0]), slope(p.normal[1])], [slope(q.normal[0]), slope(q.normal[1])]],
        narrow: [p.half < f.softness, q.half < f.softness],
        covariance: floor(f.covariance() * 32_768.0 + 0.5) as i16,
    };
    let middle = if tall { [3.5, 0.5] } else { [7.5, 0.0] };
    let corner = [f64::from(left) - cx, f64::from(top) - cy];
    let edges = Edges::new(f, [corner[0] + middle[0], corner[1] + middle[1]], sharpness);
    // Where all of it is readable, and so much behind that no block ends beyond the data, blocks are read as they stand.
    let step = if tall { 2 } else { 1 };
    let inside =
        plane.covers(left, top, right, bottom) && plane.at(left, bottom + 1) + 2 * READ <= plane.data.len();
    let block = B::new(&frame);
    let mut run = Run { plane, rest, right, block, blocks: 0, sums: Sums::default() };
    if right - left < TEXELS as i32 {
        let second = if tall { plane.row } else { 8 * plane.lanes };
        let mut at = plane.at(left, top);
        let mut y = top;
        while y <= bottom {
            let edges = edges.at(0, y - top);
            if inside {
                run.add(edges, [whole(plane.data, at), whole(plane.data, at + second)]);
            } else {
                let other = if tall { [left, y + 1] } else { [left + 8, y] };
                run.add_copies(edges, [[left, y], other]);
            }
            y += step;
            at = at.wrapping_add(step as usize * plane.row);
        }
    } else {
        let rows = f.rows();
        for y in top..=bottom {
            let [start, end] = rows.at(f64::from(y) - cy);
            let (mut x, end) = (ceil(cx + start) as i32, floor(cx + end) as i32);
            while x <= end {
                let edges = edges.at(x - left, y - top);
                run.add_copies(edges, [[x, y], [x + 8, y]]);
                x += TEXELS as i32;
            }
        }
    }
    let Sums { codes, weight } = plus(run.sums, run.block.drain());
    let [a, b, c, d] = codes;
    let share = weight as f64;
    [a as f64 / share, b as f64 / share, c as f64 / share, d as f64 / share]
}

/// The bytes from `at` on.
#[inline(always)]
fn whole(data: &[u8], at: usize) -> &[u8; READ] {
    let (bytes, _) = data[at..].as_chunks::<READ>();
    &bytes[0]
}

#[inline(always)]
fn plus(a: Sums, b: Sums) -> Sums {
    Sums { codes: std::array::from_fn(|c| a.codes[c] + b.codes[c]), weight: a.weight + b.weight }
}

/// A mean under way.
struct Run<'a, B, R> {
    plane: &'a Plane<'a, u8>,
    rest: &'a R,
    /// Last column that has weight.
    right: i32,
    block: B,
    /// Blocks since the last drain.
    blocks: u32,
    sums: Sums,
}

impl<B: Block, R: Texels> Run<'_, B, R> {
    /// Adds a block.
    #[inline(always)]
    fn add(&mut self, edges: [i32; 4], texels: [&[u8; READ]; 2]) {
        if self.blocks == DRAIN {
            self.sums = plus(self.sums, self.block.drain());
            self.blocks = 0;
        }
        self.blocks += 1;
        self.block.add(edges, texels);
    }

    /// Adds a block whose halves begin at these places; texels that the plane does not have in a row are copied.
    #[inline(always)]
    fn add_copies(&mut self, edges: [i32; 4], at: [[i32; 2]; 2]) {
        let (plane, rest, right) = (self.plane, self.rest, self.right);
        let mut copies = [[0; READ]; 2];
        for ([x, y], copy) in at.into_iter().zip(&mut copies) {
            let begin = plane.at(x, y);
            let end = begin.wrapping_add(READ);
            match plane.data.get(begin..end) {
                Some(bytes) if plane.covers(x, y, right.min(x + 7), y) => copy.copy_from_slice(bytes),
                _ => rest.eight(x, y, copy),
            }
        }
        self.add(edges, [&copies[0], &copies[1]]);
    }
}
