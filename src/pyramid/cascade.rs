//! Box levels in one pass: a row is handed up as soon as the rows below it are there, while they are warm.

use super::codec::{Codec, Real};
use super::taps::Taps;
use super::{Kind, Target};
use crate::error::Result;
use crate::image::View;
use crate::kernel::{Isa, box_down};
use crate::par;
use crate::texel::Texel;

/// Levels that one pass makes.
const GROUP: usize = 6;
/// Rows of the topmost of them that one task makes.
const ROWS: usize = 8;

/// Where the rows below come from.
#[derive(Clone, Copy)]
enum Source<'a, T, R> {
    Codes(View<'a, T>),
    Numbers(&'a [R], usize),
}

/// One level while rows run through it: the last three rows, row `y` in slot `y mod 3`.
struct Stage<R> {
    rows: [Vec<R>; 3],
    /// The first row that this task makes.
    start: usize,
}

/// The rows of one level that one task stores.
struct Slot<'a, T> {
    codes: &'a mut [T],
    first: usize,
    end: usize,
    row_stride: usize,
    width: usize,
}

/// How the rows of one level become one of the next.
struct Step<R> {
    taps: [Taps<R>; 2],
}

pub(super) fn levels<T: Texel, R: Real>(
    base: View<'_, T>,
    lanes: usize,
    targets: &mut [Target<'_, T>],
    codec: &Codec,
) -> Result<()> {
    let mut below: Option<Vec<R>> = None;
    let (mut width, mut height) = (base.width(), base.height());
    for group in targets.chunks_mut(GROUP) {
        let source =
            below.as_deref().map_or(Source::Codes(base), |n| Source::Numbers(n, width * codec.lanes));
        let top = pass(source, [width, height], lanes, group, codec)?;
        below = Some(top);
        if let Some(last) = group.last() {
            (width, height) = (last.width, last.height);
        }
    }
    Ok(())
}

/// Makes a group of levels; returns the numbers of the topmost.
fn pass<T: Texel, R: Real>(
    source: Source<'_, T, R>,
    [width, height]: [usize; 2],
    lanes: usize,
    targets: &mut [Target<'_, T>],
    codec: &Codec,
) -> Result<Vec<R>> {
    let mut steps = Vec::new();
    let (mut w, mut h) = (width, height);
    for target in targets.iter() {
        let taps = |n| Taps::new(Kind::Box, n, R::from_f64);
        steps.push(Step { taps: [taps(w), taps(h)] });
        (w, h) = (target.width, target.height);
    }
    let count = targets.len();
    let mut top = vec![R::default(); w * h * codec.lanes];
    let bands = h.div_ceil(ROWS);
    let mut slots: Vec<Vec<Slot<'_, T>>> = (0..bands).map(|_| Vec::with_capacity(count)).collect();
    for (level, target) in targets.iter_mut().enumerate() {
        // Rows of this level under one row of the topmost; the last band has what is left.
        let scale = ROWS << (count - 1 - level);
        let mut rest = &mut target.data[target.origin..];
        for (band, slots) in slots.iter_mut().enumerate() {
            let first = band * scale;
            let end = if band + 1 == bands { target.height } else { first + scale };
            let len = if band + 1 == bands { rest.len() } else { (end - first) * target.row_stride };
            let (codes, after) = rest.split_at_mut(len);
            rest = after;
            slots.push(Slot { codes, first, end, row_stride: target.row_stride, width: target.width });
        }
    }
    let isa = Isa::current();
    let tops = top.chunks_mut(w * codec.lanes * ROWS);
    par::for_pixels(width * height, slots.into_iter().zip(tops), |_, (slots, top)| {
        Band::new(source, &steps, slots, top, lanes, codec, isa).run();
        Ok(())
    })?;
    Ok(top)
}

/// One task: a band of rows of every level of a group.
struct Band<'a, 'b, T, R> {
    source: Source<'a, T, R>,
    steps: &'a [Step<R>],
    /// `stages[0]` is the source.
    stages: Vec<Stage<R>>,
    slots: Vec<Slot<'b, T>>,
    top: &'b mut [R],
    /// One row of numbers between the two directions, and what [`Codec`] needs.
    scratch: [Vec<R>; 2],
    /// One past the last row needed of each level.
    ends: Vec<usize>,
    lanes: usize,
    codec: &'a Codec,
    isa: Isa,
}

impl<'a, 'b, T: Texel, R: Real> Band<'a, 'b, T, R> {
    fn new(
        source: Source<'a, T, R>,
        steps: &'a [Step<R>],
        slots: Vec<Slot<'b, T>>,
        top: &'b mut [R],
        lanes: usize,
        codec: &'a Codec,
        isa: Isa,
    ) -> Self {
        let last = &slots[slots.len() - 1];
        let (mut start, mut end) = (last.first, last.end);
        let mut stages = Vec::new();
        let mut ends = vec![end];
        let stage = |width: usize, start| Stage {
            rows: std::array::from_fn(|_| vec![R::default(); width * codec.lanes]),
            start,
        };
        stages.push(stage(last.width, start));
        for step in steps.iter().rev() {
            let taps = &step.taps[1];
            start *= 2;
            end = if taps.old == 1 { 1 } else { 2 * (end - 1) + taps.len };
            stages.push(stage(step.taps[0].old, start));
            ends.push(end);
        }
        stages.reverse();
        ends.reverse();
        let width = steps[0].taps[0].old * codec.lanes;
        let scratch = std::array::from_fn(|_| vec![R::default(); width]);
        Self { source, steps, stages, slots, top, scratch, ends, lanes, codec, isa }
    }

    fn run(mut self) {
        let [across, down] = &self.steps[0].taps;
        let even = across.old.is_multiple_of(2) && down.old.is_multiple_of(2);
        let mut decoded = self.stages[0].start;
        for j in self.stages[1].start..self.ends[1] {
            let (below, above) = self.stages.split_at_mut(1);
            let out = &mut above[0].rows[j % 3];
            let first = down.start(j) as usize;
            let rows = first..first + down.len;
            let direct = match self.source {
                Source::Codes(view) => {
                    even && self.codec.halve(self.isa, [view.row(first), view.row(first + 1)], out)
                }
                Source::Numbers(..) => false,
            };
            if !direct {
                let whole = match self.source {
                    Source::Numbers(numbers, row) => Some((numbers, row)),
                    Source::Codes(view) => self
                        .codec
                        .as_numbers(view.data(), view.channels())
                        .map(|numbers| (numbers, view.row_stride())),
                };
                if let Some((numbers, stride)) = whole {
                    let row =
                        |y: usize| &numbers[y.min(down.old - 1) * stride..][..across.old * self.codec.lanes];
                    let rows = [row(first), row(first + 1), row(first + 2)];
                    reduce(&self.steps[0], j, rows, self.codec.lanes, self.isa, &mut self.scratch[0], out);
                } else if let Source::Codes(view) = self.source {
                    for y in decoded.max(rows.start)..rows.end {
                        self.codec.decode_row(view.row(y), view.channels(), &mut below[0].rows[y % 3]);
                    }
                    decoded = rows.end;
                    let rows = below[0].window(first);
                    reduce(&self.steps[0], j, rows, self.codec.lanes, self.isa, &mut self.scratch[0], out);
                }
            }
            self.hand_up(1, j);
        }
    }

    /// Row `y` of stage `level` is there: stores it and makes what it completes.
    fn hand_up(&mut self, level: usize, y: usize) {
        let slot = &mut self.slots[level - 1];
        let owned = (slot.first..slot.end).contains(&y);
        if owned {
            let codes = &mut slot.codes[(y - slot.first) * slot.row_stride..][..slot.width * self.lanes];
            let numbers = &self.stages[level].rows[y % 3];
            self.codec.encode_row(self.isa, numbers, self.lanes, codes, &mut self.scratch[1]);
        }
        let Some(step) = self.steps.get(level) else {
            if owned {
                let numbers = &self.stages[level].rows[y % 3];
                self.top[(y - slot.first) * numbers.len()..][..numbers.len()].copy_from_slice(numbers);
            }
            return;
        };
        let (below, above) = self.stages.split_at_mut(level + 1);
        let below = &below[level];
        let next = match step.taps[1].len {
            1 => Some(0),
            2 if y % 2 == 1 => Some(y / 2),
            3 if y.is_multiple_of(2) && y >= below.start + 2 => Some(y / 2 - 1),
            _ => None,
        };
        if let Some(j) = next {
            let out = &mut above[0].rows[j % 3];
            let rows = below.window(step.taps[1].start(j) as usize);
            reduce(step, j, rows, self.codec.lanes, self.isa, &mut self.scratch[0], out);
            self.hand_up(level + 1, j);
        }
    }
}

impl<R> Stage<R> {
    /// Rows `first`, `first + 1` and `first + 2`, as far as they are there.
    fn window(&self, first: usize) -> [&[R]; 3] {
        std::array::from_fn(|t| &self.rows[(first + t) % 3][..])
    }
}

/// Row `j` of the next level from the up to three rows below it.
fn reduce<R: Real>(
    step: &Step<R>,
    j: usize,
    rows: [&[R]; 3],
    channels: usize,
    isa: Isa,
    scratch: &mut [R],
    out: &mut [R],
) {
    let [across, down] = &step.taps;
    if across.len == 2 && down.len == 2 {
        return box_down::halve_both(isa, rows[0], rows[1], channels, out);
    }
    let scratch = &mut scratch[..rows[0].len()];
    let row = match down.len {
        1 => rows[0],
        2 => {
            box_down::halve_rows(isa, rows[0], rows[1], scratch);
            &*scratch
        }
        _ => {
            let w = down.weights(j);
            box_down::mix_rows(isa, rows, [w[0], w[1], w[2]], scratch);
            &*scratch
        }
    };
    match across.len {
        1 => out.copy_from_slice(row),
        2 => box_down::halve_columns(isa, row, channels, out),
        _ => box_down::mix_columns(isa, row, across.all_weights(), channels, out),
    }
}
