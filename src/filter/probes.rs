//! Bilinear probes, a block of samples at a time: the bilinear, trilinear and anisotropic filters.
//!
//! The level of every sample is found in lanes over the block, its places on two levels in lanes over levels and axes, the
//! places of a line of probes in lanes over the probes. A probe is read in lanes over the channels of two neighbours: rows are
//! blended by the height, `v = a + fy (b - a)`, then columns, `v_left + fx (v_right - v_left)`, those of two levels at
//! once. A line of probes sums differences from one of its texels, so that equal texels give exactly their value.

use super::anisotropic::{Line, Lines};
use super::{Filter, Query, Reader, lerp4};
use crate::jacobian::Jacobian;
use crate::kernel::lanes::{LaneWork, Lanes, prefetch};
use crate::kernel::plane::Plane;
use crate::kernel::spot::Spots;
use crate::kernel::taps;
use crate::lod::{self, LodRule};
use crate::num::{Real, floor};
use crate::texel::Texel;
use crate::texture::Decode;
use crate::wrap::{EXACT, Wrap};

/// Most samples of a block.
pub(crate) const BLOCK: usize = 64;

/// Longest half line, in texels, whose places singles hold well enough.
const NEAR: f64 = 256.0;
/// Coordinates that singles can wrap.
const FAR: i32 = 1 << 20;

/// How the texels of a block are found.
#[derive(Clone, Copy)]
pub(crate) struct Probes {
    pub filter: Filter,
    pub max_anisotropy: f64,
    pub lod_bias: f32,
    pub lod_rule: LodRule,
}

/// Places and footprints of a block, number by number: what [`Query`] holds.
pub(crate) struct Samples {
    pub s: [f64; BLOCK],
    pub t: [f64; BLOCK],
    /// The Jacobian's entries, row by row.
    pub m: [[f64; BLOCK]; 4],
    /// Levels of detail that are given outright.
    pub lod: [Option<f32>; BLOCK],
}

impl Samples {
    /// Points at the origin.
    pub const NONE: Self =
        Self { s: [0.0; BLOCK], t: [0.0; BLOCK], m: [[0.0; BLOCK]; 4], lod: [None; BLOCK] };

    /// Sets sample `i`.
    pub fn set(&mut self, i: usize, query: &Query, lod: Option<f32>) {
        let [[a, b], [c, d]] = query.jacobian_tx.m;
        (self.s[i], self.t[i], self.lod[i]) = (query.s, query.t, lod);
        [self.m[0][i], self.m[1][i], self.m[2][i], self.m[3][i]] = [a, b, c, d];
    }
}

/// A block to be averaged.
pub(crate) struct Block<'a, T: Texel, D> {
    pub probes: Probes,
    pub reader: &'a Reader<'a, T, D>,
    pub samples: &'a Samples,
    pub scratch: &'a mut Scratch,
    pub out: &'a mut [[T::Real; 4]],
}

impl<T: Texel, D: Decode<T>> LaneWork for Block<'_, T, D> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { probes, reader, samples, scratch, out } = self;
        let Scratch { levels, spots } = scratch;
        let count = out.len().min(BLOCK);
        probes.find(samples, reader.last_level(), count, levels);
        let [s, t] = reader.reduced(samples);
        for i in 0..count {
            let level = levels.level[i] as usize;
            spots[i] = L::spots([s[i], t[i]], &reader.grids[level]);
            reader.ask(level, spots[i].offset[0]);
        }
        for (i, out) in out.iter_mut().enumerate().take(BLOCK) {
            let (level, fraction) = (levels.level[i] as usize, levels.fraction[i]);
            let value = if !(samples.s[i].is_finite() && samples.t[i].is_finite()) {
                *out = reader.outside();
                continue;
            } else if levels.lines.half[i] > 0.0 {
                let line = levels.lines.at(i);
                reader.line::<L>([samples.s[i], samples.t[i]], level, fraction, &line)
            } else {
                let [fx, _, next_fx, _] = spots[i].fraction;
                let near = reader.column::<L>(level, &spots[i], 0);
                if fraction == 0.0 {
                    near.met(fx)
                } else {
                    let [left, right] = near.regrouped(reader.column::<L>(level + 1, &spots[i], 1));
                    left.add(L::halves(fx, next_fx).mul(right.sub(left))).met(fraction)
                }
            };
            *out = [value[0], value[1], value[2], value[3]].map(|x| T::Real::from_f64(x.into()));
        }
    }
}

/// What is found of a block before it is read; may be used again for the next one with the same filter.
pub(crate) struct Scratch {
    levels: Levels,
    spots: [Spots; BLOCK],
}

impl Scratch {
    /// Nothing yet.
    pub const NEW: Self = Self {
        levels: Levels { level: [0; BLOCK], fraction: [0.0; BLOCK], lines: Lines::POINTS },
        spots: [Spots::NONE; BLOCK],
    };
}

/// Levels and lines of a block.
struct Levels {
    level: [i32; BLOCK],
    fraction: [f32; BLOCK],
    lines: Lines,
}

impl Probes {
    /// Whether this module has the filter.
    pub fn has(filter: Filter) -> bool {
        matches!(
            filter,
            Filter::Bilinear | Filter::LinearMipmapNearest | Filter::Trilinear | Filter::Anisotropic
        )
    }

    /// Finds the levels, and the lines where the filter has them. Loops run over whole blocks, so that they become lanes.
    #[inline(always)]
    fn find(&self, samples: &Samples, last: usize, count: usize, levels: &mut Levels) {
        if self.filter == Filter::Bilinear {
            return;
        }
        let mut lod = [0.0; BLOCK];
        let [a, b, c, d] = &samples.m;
        if self.filter == Filter::Anisotropic {
            levels.lines.find(&samples.m, self.max_anisotropy, &mut lod);
        } else if self.lod_rule == LodRule::Major {
            for i in 0..BLOCK {
                lod[i] = LodRule::Major.lod(Jacobian { m: [[a[i], b[i]], [c[i], d[i]]] });
            }
        } else {
            for i in 0..BLOCK {
                lod[i] = LodRule::Area.lod(Jacobian { m: [[a[i], b[i]], [c[i], d[i]]] });
            }
        }
        for i in (0..count).filter(|i| samples.lod[*i].is_some()) {
            lod[i] = samples.lod[i].unwrap_or_default();
            levels.lines.half[i] = 0.0;
        }
        for (i, lod) in lod.into_iter().enumerate() {
            let clamped = lod::clamp(lod + self.lod_bias, last);
            // Not negative, so truncation is floor.
            levels.level[i] = clamped as i32;
            levels.fraction[i] = clamped - levels.level[i] as f32;
        }
        if self.filter == Filter::LinearMipmapNearest {
            for i in 0..BLOCK {
                levels.level[i] += i32::from(levels.fraction[i] > 0.5);
                levels.fraction[i] = 0.0;
            }
        }
    }
}

impl<T: Texel, D: Decode<T>> Reader<'_, T, D> {
    /// The places of a block within one period of the wrap modes.
    #[inline(always)]
    fn reduced(&self, samples: &Samples) -> [[f64; BLOCK]; 2] {
        let base = &self.layers.planes[0];
        let [wu, wv] = self.layers.wrap;
        [reduced(wu, base.width.into(), &samples.s), reduced(wv, base.height.into(), &samples.t)]
    }

    /// Asks for the texels of a probe ahead of time.
    #[inline(always)]
    fn ask(&self, level: usize, offset: i32) {
        let plane = &self.layers.planes[level];
        let at = plane.origin.wrapping_add_signed(offset as isize);
        prefetch(plane.data, at);
        prefetch(plane.data, at.wrapping_add(plane.row));
    }

    /// Two columns of texels of a level, the first or the second of `spots`, blended by the height: the left neighbour in the
    /// first half.
    #[inline(always)]
    fn column<L: Lanes>(&self, level: usize, spots: &Spots, which: usize) -> L {
        let [x, y] = [spots.texel[2 * which], spots.texel[2 * which + 1]];
        let fy = spots.fraction[2 * which + 1];
        if spots.inside[which] {
            let at = self.layers.planes[level].origin.wrapping_add_signed(spots.offset[which] as isize);
            return self.rows::<L>(level, at, fy);
        }
        self.column_outside(level, [x, y], fy)
    }

    /// As [`Reader::column`], between texel (x, y) and the next.
    #[inline(always)]
    fn column_at<L: Lanes>(&self, level: usize, [x, y]: [i32; 2], fy: f32) -> L {
        let plane = &self.layers.planes[level];
        if plane.covers(x, y, x + 1, y + 1) {
            return self.rows::<L>(level, plane.at(x, y), fy);
        }
        self.column_outside(level, [x, y], fy)
    }

    /// As [`Reader::column_at`], where some of the texels lie beyond the plane.
    #[inline(always)]
    fn column_outside<L: Lanes>(&self, level: usize, [x, y]: [i32; 2], fy: f32) -> L {
        let [a, b, c, d] = self.taps_outside(level, x, y).map(|t| t.map(|x| x.to_f64() as f32));
        let ([a, b, c, d], [e, f, g, h]) = (lerp4(a, c, fy), lerp4(b, d, fy));
        L::load(&[a, b, c, d, e, f, g, h])
    }

    /// Two neighbours from `at` on, blended with those of the next row.
    #[inline(always)]
    fn rows<L: Lanes>(&self, level: usize, at: usize, fraction: f32) -> L {
        let above = self.pair::<L>(level, at);
        let below = self.pair::<L>(level, at + self.layers.planes[level].row);
        above.add(L::splat(fraction).mul(below.sub(above)))
    }

    /// Probes along a line.
    #[inline(always)]
    fn line<L: Lanes>(&self, place: [f64; 2], level: usize, fraction: f32, line: &Line) -> [f32; 4] {
        let (s, t) = self.on_level(level, place[0], place[1]);
        let [x, y] = [s, t].map(|c| floor(c) as i32);
        let plane = &self.layers.planes[level];
        let texel = if plane.is_readable(x, y) {
            self.decode.texel(plane.texel(x, y))
        } else {
            self.tap(level, x, y)
        };
        let [a, b, c, d] = texel.map(|x| x.to_f64() as f32);
        let reference = L::load(&[a, b, c, d, a, b, c, d]);
        let mut mean = self.line_on::<L>(place, level, line, reference);
        if fraction > 0.0 {
            mean = lerp4(mean, self.line_on::<L>(place, level + 1, line, reference), fraction);
        }
        [a + mean[0], b + mean[1], c + mean[2], d + mean[3]]
    }

    /// The weighted mean of probes on one level, less the reference.
    #[inline(always)]
    fn line_on<L: Lanes>(&self, place: [f64; 2], level: usize, line: &Line, reference: L) -> [f32; 4] {
        let plane = &self.layers.planes[level];
        let base = &self.layers.planes[0];
        let [kx, ky] = self.scale[level];
        let [wu, wv] = self.layers.wrap;
        // Where a mirrored copy is entered the line runs the other way.
        let (s, sign_s) = wu.reduce(place[0], base.width.into());
        let (t, sign_t) = wv.reduce(place[1], base.height.into());
        let (x, y) = (s * kx - 0.5, t * ky - 0.5);
        let step = [sign_s * line.step[0] * kx, sign_t * line.step[1] * ky];
        let half = f64::from(line.half);
        let reach = [half * step[0].abs(), half * step[1].abs()];
        let folds = [
            Fold::new(wu, x, reach[0], plane.width, plane.columns),
            Fold::new(wv, y, reach[1], plane.height, plane.rows),
        ];
        let mut sum = L::splat(0.0);
        if let [Some(fold_x), Some(fold_y)] = folds
            && reach[0] < NEAR
            && reach[1] < NEAR
            && plane.data.len() < i32::MAX as usize
        {
            let (i, j) = (floor(x), floor(y));
            let places = Places {
                x: (x - i as f64) as f32,
                y: (y - j as f64) as f32,
                texel: [i as i32, j as i32],
                folds: [fold_x, fold_y],
                step: step.map(|x| x as f32),
                half: line.half,
                outer: line.outer,
                row: plane.row as i32,
                lanes: plane.lanes as i32,
            };
            let count = 2 * line.half as usize + 1;
            if let Some((plane, _)) = self.bytes(level)
                && plane.lanes == 4
            {
                return line_of_bytes::<L>(&plane, &places, count, reference);
            }
            let mut first = 0;
            while first < count {
                let eight = places.eight(first as f32 - line.half);
                for k in 0..(count - first).min(8) {
                    let at = plane.origin.wrapping_add_signed(eight.offset[k] as isize);
                    let value = self.rows::<L>(level, at, eight.fraction[k]).sub(reference);
                    sum = sum.add(value.mul(L::halves(eight.left[k], eight.right[k])));
                }
                first += 8;
            }
            return halved(sum, line.share);
        }
        let mut i = -half;
        while i <= half {
            let (s, t) = self.on_level(level, place[0] + i * line.step[0], place[1] + i * line.step[1]);
            let (x, y) = (floor(s - 0.5), floor(t - 0.5));
            let fractions = [(s - 0.5 - x as f64) as f32, (t - 0.5 - y as f64) as f32];
            let sides = self.column_at::<L>(level, [x as i32, y as i32], fractions[1]);
            let weight = if i.abs() < half { 1.0 } else { line.outer };
            let right = weight * fractions[0];
            sum = sum.add(sides.sub(reference).mul(L::halves(weight - right, right)));
            i += 1.0;
        }
        halved(sum, line.share)
    }
}

/// Both columns together, times a factor.
#[inline(always)]
fn halved<L: Lanes>(sum: L, factor: f32) -> [f32; 4] {
    let [a, b, c, d, e, f, g, h] = sum.store();
    [factor * (a + e), factor * (b + f), factor * (c + g), factor * (d + h)]
}

/// The weighted mean of the probes of a line over bytes, less the reference. Weights are whole numbers, good to 1/16384 of
/// one; the mean is divided by their sum, so that equal texels give exactly their code.
#[inline(always)]
fn line_of_bytes<L: Lanes>(plane: &Plane<'_, u8>, places: &Places, count: usize, reference: L) -> [f32; 4] {
    let (mut sums, mut weight) = (L::no_taps(), 0);
    let mut first = 0;
    while first < count {
        let eight = places.eight(first as f32 - places.half);
        let (mut left, mut right, mut both) = ([0; 8], [0; 8], [0; 8]);
        for k in 0..8 {
            let column = |weight: f32| {
                let (all, lower) = (whole(weight * taps::ONE), whole(weight * eight.fraction[k] * taps::ONE));
                (all, taps::pair(all - lower, lower))
            };
            let (p, q) = (column(eight.left[k]), column(eight.right[k]));
            (both[k], left[k], right[k]) = (p.0 + q.0, p.1, q.1);
        }
        for k in 0..(count - first).min(8) {
            let at = plane.origin.wrapping_add_signed(eight.offset[k] as isize);
            if let (Some(upper), Some(lower)) = (plane.packed_pair(at), plane.packed_pair(at + plane.row)) {
                sums = L::add_taps(sums, [upper, lower], left[k], right[k]);
                weight += both[k];
            }
        }
        first += 8;
    }
    let [a, b, c, d, ..] = reference.store();
    let share = 1.0 / f64::from(weight);
    let total = L::taps_total(sums);
    let mean = |k: usize| f64::from(total[k]) * share;
    [mean(0) as f32 - a, mean(1) as f32 - b, mean(2) as f32 - c, mean(3) as f32 - d]
}

/// [`Wrap::reduce`] of a block, in lanes where the numbers allow it.
#[inline(always)]
fn reduced(wrap: Wrap, n: f64, places: &[f64; BLOCK]) -> [f64; BLOCK] {
    let mut reduced = *places;
    let Some(period) = wrap.period(n) else {
        if wrap == Wrap::MirrorOnce {
            reduced.iter_mut().for_each(|x| *x = wrap.reduce(*x, n).0);
        }
        return reduced;
    };
    let (mut outside, mut most) = (false, 0.0f64);
    for x in places {
        outside |= !(*x >= 0.0 && *x < n);
        // The sum is no number where one of them is none.
        most += x.abs();
    }
    if !outside && wrap != Wrap::Mirror101 {
        return reduced;
    }
    // No number is too large.
    let is_near = most < EXACT;
    if wrap == Wrap::Mirror101 || !is_near {
        reduced.iter_mut().for_each(|x| *x = wrap.reduce(*x, n).0);
        return reduced;
    }
    let turns = wrap == Wrap::Mirror;
    for x in &mut reduced {
        let m = *x - period * (*x / period).floor();
        let m = if m > 0.0 { m } else { 0.0 };
        let m = if m < period { m } else { period };
        let m = if turns & (m >= n) { period - m } else { m };
        *x = if (*x >= 0.0) & (*x < n) { *x } else { m };
    }
    reduced
}

/// Where texels of a level beyond its readable ones stand, along one axis. Left and right neighbour stay neighbours, as the
/// apron has those beyond the edge.
#[derive(Clone, Copy)]
enum Fold {
    /// There are none.
    Inside,
    /// Beyond the edge one colour: the apron's.
    Edge(i32),
    /// Periodic: texels of a period, and one over it.
    Repeat(i32, f32),
    /// Periodic, the second half backwards: texels in a picture, and half of one over it.
    Mirror(i32, f32),
}

impl Fold {
    /// For texels as far as `reach` from `x` on both sides; `None` where each has to be looked for on its own.
    #[inline(always)]
    fn new(wrap: Wrap, x: f64, reach: f64, n: i32, (first, last): (i32, i32)) -> Option<Self> {
        // This mode turns at the centres of level 0's outer texels, which coarser levels have within theirs.
        let (first, last) = if wrap == Wrap::Mirror101 { (0, n - 1) } else { (first, last) };
        // A little more than the line, for singles round.
        if x - reach - 0.01 > first.into() && x + reach + 0.01 < last.into() {
            return Some(Self::Inside);
        }
        if (first, last) != (-1, n) || n >= FAR || x.abs() >= FAR.into() {
            return None;
        }
        match wrap {
            Wrap::Clamp | Wrap::Extend => Some(Self::Edge(n)),
            Wrap::Repeat => Some(Self::Repeat(n, 1.0 / n as f32)),
            Wrap::Mirror => Some(Self::Mirror(n, 0.5 / n as f32)),
            Wrap::MirrorOnce | Wrap::Mirror101 | Wrap::Border => None,
        }
    }

    #[inline(always)]
    fn fold(self, texel: &mut [i32; 8], fraction: &mut [f32; 8]) {
        // Half a texel away from whole periods, the quotient's rounding cannot cross one.
        let period = |x: i32, inverse: f32| whole(((x as f32 + 0.5) * inverse).floor());
        match self {
            Self::Inside => {}
            Self::Edge(n) => {
                for k in 0..8 {
                    let x = texel[k];
                    fraction[k] = if x < -1 { 0.0 } else { fraction[k] };
                    fraction[k] = if x > n - 1 { 1.0 } else { fraction[k] };
                    texel[k] = x.max(-1).min(n - 1);
                }
            }
            Self::Repeat(n, inverse) => {
                for x in texel {
                    *x -= n * period(*x, inverse);
                }
            }
            Self::Mirror(n, inverse) => {
                for k in 0..8 {
                    let x = texel[k] - 2 * n * period(texel[k], inverse);
                    fraction[k] = if x < n { fraction[k] } else { 1.0 - fraction[k] };
                    texel[k] = if x < n { x } else { 2 * n - 2 - x };
                }
            }
        }
    }
}

/// A line among the texels of a level.
struct Places {
    /// From `texel` to the middle of the line.
    x: f32,
    y: f32,
    texel: [i32; 2],
    folds: [Fold; 2],
    step: [f32; 2],
    half: f32,
    outer: f32,
    row: i32,
    lanes: i32,
}

/// Eight probes of a line.
struct Eight {
    /// Elements from texel (0, 0) to that left of and above the probe.
    offset: [i32; 8],
    /// How far the probe is below that texel.
    fraction: [f32; 8],
    /// Weights of the left and right column.
    left: [f32; 8],
    right: [f32; 8],
}

impl Places {
    /// Probes from number `first` on; the middle one is 0.
    #[inline(always)]
    fn eight(&self, first: f32) -> Eight {
        let (mut column, mut row, mut fx, mut fy) = ([0; 8], [0; 8], [0.0; 8], [0.0; 8]);
        let (mut left, mut right) = ([0.0; 8], [0.0; 8]);
        for k in 0..8 {
            let i = first + k as f32;
            let (x, y) = (self.x + i * self.step[0], self.y + i * self.step[1]);
            let (i, j) = (x.floor(), y.floor());
            (fx[k], fy[k]) = (x - i, y - j);
            (column[k], row[k]) = (self.texel[0] + whole(i), self.texel[1] + whole(j));
        }
        self.folds[0].fold(&mut column, &mut fx);
        self.folds[1].fold(&mut row, &mut fy);
        for k in 0..8 {
            let i = first + k as f32;
            let weight = if i.abs() < self.half { 1.0 } else { self.outer };
            right[k] = weight * fx[k];
            left[k] = weight - right[k];
        }
        let offset = std::array::from_fn(|k| row[k] * self.row + column[k] * self.lanes);
        Eight { offset, fraction: fy, left, right }
    }
}

/// A whole number below 2^22 in size, as such: one addition, and no care for what is not finite.
#[inline(always)]
fn whole(x: f32) -> i32 {
    const MAGIC: f32 = 12_582_912.0;
    (x + MAGIC).to_bits() as i32 - MAGIC.to_bits() as i32
}
