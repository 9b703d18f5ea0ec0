//! The output pixels of a warp as places to be sampled.

use super::mapping::{Mapping, Maps, difference, perspective};
use crate::filter::{BLOCK, Query, Samples, bounded};
use crate::kernel::{Isa, Work, compiled_for};
use crate::sampler::Places;

/// All pixels, row by row.
pub(super) struct Pixels<'a> {
    pub mapping: &'a Mapping<'a>,
    /// Pixels in a row, and rows.
    pub size: [usize; 2],
    /// Whether the filter asks for the shape of a pixel.
    pub shape: bool,
}

impl Places for Pixels<'_> {
    fn fill(&self, first: usize, queries: &mut [(Query, Option<f32>)]) {
        let width = self.size[0];
        let (mut column, mut row) = (first % width, first / width);
        for (k, slot) in queries.iter_mut().enumerate() {
            let query = self.mapping.query([column, row], self.size, self.shape);
            *slot = (Query { index: (first + k) as u64, ..query }.bounded(), None);
            column += 1;
            if column == width {
                (column, row) = (0, row + 1);
            }
        }
    }

    fn fill_samples(&self, isa: Isa, first: usize, count: usize, samples: &mut Samples) {
        let width = self.size[0];
        let mut done = 0;
        while done < count {
            let (column, row) = ((first + done) % width, (first + done) / width);
            let part = (width - column).min(count - done);
            compiled_for(isa, Run { pixels: self, at: [column, row], count: part, slot: done, samples });
            done += part;
        }
    }
}

/// Pixels of one row, to be compiled for an instruction set.
struct Run<'a> {
    pixels: &'a Pixels<'a>,
    /// The first of them.
    at: [usize; 2],
    count: usize,
    /// Where it goes.
    slot: usize,
    samples: &'a mut Samples,
}

impl Work for Run<'_> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        match self.pixels.mapping {
            Mapping::Single(maps) => self.mapped(maps),
            Mapping::Double(maps) => self.mapped(maps),
            Mapping::Affine(rows) => self.affine(*rows),
            Mapping::Projective(rows) => self.projective(*rows),
        }
    }
}

impl Run<'_> {
    /// Pixels of a matrix, as [`Mapping::query`] has them.
    #[inline(always)]
    fn affine(self, [[a, b, c], [d, e, f]]: [[f64; 3]; 2]) {
        let Self { at, count, slot, samples, .. } = self;
        let y = at[1] as f64;
        for (entry, value) in samples.m.iter_mut().zip([a, b, d, e]) {
            entry[slot..][..count].fill(bounded(value));
        }
        samples.lod[slot..][..count].fill(None);
        let places = samples.s[slot..][..count].iter_mut().zip(&mut samples.t[slot..][..count]);
        for (k, (s, t)) in places.enumerate() {
            let x = column(at[0], k);
            (*s, *t) = ((a * x + b * y + c) + 0.5, (d * x + e * y + f) + 0.5);
        }
    }

    /// Likewise, with a perspective.
    #[inline(always)]
    fn projective(self, rows: [[f64; 3]; 3]) {
        let Self { at, count, slot, samples, .. } = self;
        let y = at[1] as f64;
        let Samples { s, t, m: [dx, dy, ex, ey], lod } = samples;
        let [s, t, dx, dy, ex, ey] = [s, t, dx, dy, ex, ey].map(|part| &mut part[slot..][..count]);
        lod[slot..][..count].fill(None);
        for k in 0..count {
            let ([px, py], [[a, b], [c, d]], _) = perspective(&rows, column(at[0], k), y);
            (s[k], t[k]) = (px + 0.5, py + 0.5);
            (dx[k], dy[k], ex[k], ey[k]) = (bounded(a), bounded(b), bounded(c), bounded(d));
        }
    }

    /// Pixels of a map: those with neighbours on all sides together.
    #[inline(always)]
    fn mapped<U: Copy + Into<f64>>(self, maps: &Maps<'_, U>) {
        let [width, height] = self.pixels.size;
        let [column, row] = self.at;
        let inside = row > 0 && row + 1 < height;
        let (first, last) = (column.max(1), (column + self.count).min(width - 1));
        let inner = if inside && first < last { first..last } else { column..column };
        for x in (column..column + self.count).filter(|x| !inner.contains(x)) {
            let query = self.pixels.mapping.query([x, row], self.pixels.size, false);
            self.samples.set(self.slot + x - column, &query.bounded(), None);
        }
        if inner.is_empty() {
            return;
        }
        let slot = self.slot + inner.start - column;
        let start = row * width + inner.start;
        let (places, slopes) = (&mut self.samples.s, &mut self.samples.m);
        let [across, along, ..] = slopes;
        Axis { values: maps.x, step: maps.step, period: maps.period[0] }.row(
            [start, width, inner.len()],
            &mut places[slot..],
            [&mut across[slot..], &mut along[slot..]],
        );
        let (places, slopes) = (&mut self.samples.t, &mut self.samples.m);
        let [.., across, along] = slopes;
        Axis { values: maps.y, step: maps.step, period: maps.period[1] }.row(
            [start, width, inner.len()],
            &mut places[slot..],
            [&mut across[slot..], &mut along[slot..]],
        );
        self.samples.lod[slot..slot + inner.len()].fill(None);
    }
}

/// Column `first + k`: 32 bits, which become doubles in one step.
#[inline(always)]
fn column(first: usize, k: usize) -> f64 {
    first as f64 + f64::from(k as u32)
}

/// One coordinate of a map.
struct Axis<'a, U> {
    values: &'a [U],
    step: usize,
    period: Option<f64>,
}

impl<U: Copy + Into<f64>> Axis<'_, U> {
    /// Places and derivatives of `count` pixels from number `start` on, all of them within the map.
    #[inline(always)]
    fn row(&self, [start, width, count]: [usize; 3], places: &mut [f64], [across, down]: [&mut [f64]; 2]) {
        let (mut here, mut above, mut below) = ([0.0; BLOCK + 2], [0.0; BLOCK], [0.0; BLOCK]);
        self.read(start - 1, &mut here[..count + 2]);
        self.read(start - width, &mut above[..count]);
        self.read(start + width, &mut below[..count]);
        for k in 0..count {
            let x = here[k + 1];
            places[k] = x + 0.5;
            across[k] = bounded(difference(here[k], x, here[k + 2], self.period));
            down[k] = bounded(difference(above[k], x, below[k], self.period));
        }
    }

    #[inline(always)]
    fn read(&self, start: usize, into: &mut [f64]) {
        if self.step == 1 {
            into.iter_mut().zip(&self.values[start..]).for_each(|(x, v)| *x = (*v).into());
        } else {
            let pairs = self.values[self.step * start..].chunks(self.step);
            into.iter_mut().zip(pairs).for_each(|(x, pair)| *x = pair[0].into());
        }
    }
}
