//! Rectangles of pixels on polynomials, row by row, by the vector kernels of `remap`.
//!
//! Codes that may be averaged as they stand are read where they are. Of others the piece of the picture that the
//! rectangle meets is decoded first, to linear light and to colour times alpha, and means are encoded.

use super::Numbers;
use super::chart::Line;
use super::grid::{Grid, Parts, covariance, half_sides};
use super::piece::{Number, Span, gather};
use super::tile::{Rect, Room, Sheet, Show, Tiles};
use crate::error::Result;
use crate::image::{AnyView, Element, Pixels, View};
use crate::kernel::remap::{
    Boxes, Interpolation, Job, Outside, Points, Real, Sample, Source, Taps, box_numbers, boxes, remap,
};
use crate::kernel::{Work, compiled_for};
use crate::sphere::along;
use glam::DVec2;

/// Texels that boxes read beyond their middles.
const BEYOND: f64 = 1.0;

/// Places of a row's points, and the pictures they lie in.
#[derive(Default)]
pub(super) struct Places {
    x: Vec<f32>,
    y: Vec<f32>,
    face: Vec<u8>,
}

/// What a row's points and boxes read, and their means.
pub(super) struct Values<S: Sample> {
    points: Vec<S>,
    numbers: Vec<S::Acc>,
    taps: Box<Taps>,
    sums: Vec<S::Acc>,
    means: Vec<S>,
}

impl<S: Sample> Values<S> {
    pub fn new() -> Self {
        Self {
            points: Vec::new(),
            numbers: Vec::new(),
            taps: Box::default(),
            sums: Vec::new(),
            means: Vec::new(),
        }
    }
}

/// What pixels are taken apart into.
#[derive(Clone, Copy)]
enum Cover {
    Points(Grid),
    Boxes(Parts),
}

impl Cover {
    fn level(self) -> usize {
        match self {
            Self::Points(grid) => grid.level,
            Self::Boxes(parts) => parts.level,
        }
    }

    /// How many rows of places there are at a time.
    fn count(self) -> usize {
        match self {
            Self::Points(grid) => grid.count(),
            Self::Boxes(_) => 1,
        }
    }
}

/// A picture, or a piece of one, and its upper left texel.
struct Page<'p, S> {
    job: Job<'p, S>,
    origin: DVec2,
}

impl<'a, T: Element + Sample> Tiles<'a, '_, T>
where
    View<'a, T>: Into<AnyView<'a>>,
    Pixels: From<Vec<T>>,
    Numbers<T>: Number,
{
    pub(super) fn fill(
        &self,
        rect: Rect,
        sheets: &[Sheet],
        first: usize,
        out: &mut [T],
        room: &mut Room<T>,
    ) -> Result<()> {
        let channels = self.pictures.channels();
        let cover = match self.show {
            Show::Mean if sheets.len() == 1 && !sheets[0].edge => Cover::Boxes(self.parts(rect, &sheets[0])),
            _ => Cover::Points(self.grid(rect, &sheets[0])),
        };
        let level = cover.level();
        let interpolation = match self.show {
            Show::Mean => Interpolation::Bilinear,
            Show::Centre(interpolation) => interpolation,
        };
        let width = self.target.size[0];
        let row = |y: usize| {
            let place = ((rect.y + y - first) * width + rect.x) * channels;
            place..place + rect.w * channels
        };
        if self.is_plain || interpolation == Interpolation::Nearest {
            let page = |sheet: &Sheet| {
                let job = self.pictures.job(level, sheet.face, interpolation)?;
                Ok(Page { job, origin: DVec2::ZERO })
            };
            let pages: Vec<_> = sheets.iter().map(page).collect::<Result<_>>()?;
            return self.rows(rect, sheets, cover, &pages, &mut room.places, &mut room.codes, |y, means| {
                out[row(y)].copy_from_slice(means);
            });
        }
        let edges = self.pictures.edges();
        room.pieces.resize_with(sheets.len().max(room.pieces.len()), Vec::new);
        let mut spans = Vec::with_capacity(sheets.len());
        let (scale, offset) = self.to_level(level);
        for (sheet, piece) in sheets.iter().zip(&mut room.pieces) {
            let view = self.pictures.view(level, sheet.face)?;
            let [middle, half] = sheet.chart.bounds();
            let reach = half * scale + BEYOND;
            let (low, high) = (middle * scale + offset - reach, middle * scale + offset + reach);
            let span = [
                Span::of([low.x, high.x], edges[0], view.width()),
                Span::of([low.y, high.y], edges[1], view.height()),
            ];
            gather(&view, span, edges, self.pictures.border(), &mut room.gathered);
            piece.resize(room.gathered.len(), Numbers::<T>::default());
            self.codec.decode_row(&room.gathered, channels, piece);
            spans.push(span);
        }
        let mut pages = Vec::with_capacity(sheets.len());
        for (piece, [across, down]) in room.pieces.iter().zip(&spans) {
            let source = Source::new(piece, across.count, down.count, channels, across.count * channels)?;
            let ends = [across.edge, down.edge];
            let job = Job::new(source, interpolation, ends, &self.border, Outside::Colour)?;
            pages.push(Page { job, origin: DVec2::new(across.first as f64, down.first as f64) });
        }
        let scratch = &mut room.scratch;
        scratch.resize(rect.w * channels, Numbers::<T>::default());
        self.rows(rect, sheets, cover, &pages, &mut room.places, &mut room.numbers, |y, means| {
            self.codec.encode_row(self.isa, means, channels, &mut out[row(y)], scratch);
        })
    }

    /// From texels of the first level to those of another, in its frame.
    fn to_level(&self, level: usize) -> (DVec2, DVec2) {
        let (texels, frame) = self.pictures.level_size(level);
        (texels / self.pictures.size(), DVec2::splat(frame - 0.5))
    }

    /// Means of the rows of a rectangle.
    #[expect(clippy::too_many_arguments, reason = "one call for codes and numbers")]
    fn rows<S: Sample<Acc = Numbers<T>>>(
        &self,
        rect: Rect,
        sheets: &[Sheet],
        cover: Cover,
        pages: &[Page<'_, S>],
        places: &mut Places,
        values: &mut Values<S>,
        put: impl FnMut(usize, &[S]),
    ) -> Result<()> {
        let points = cover.count() * rect.w;
        places.x.resize(points * sheets.len(), 0.0);
        places.y.resize(points * sheets.len(), 0.0);
        let len = rect.w * self.pictures.channels();
        values.sums.resize(len, S::Acc::default());
        values.means.resize(len, S::default());
        match cover {
            Cover::Boxes(parts) => self.boxes(rect, &sheets[0], parts, &pages[0], places, values, put),
            Cover::Points(grid) => self.points(rect, sheets, grid, pages, places, values, put),
        }
    }

    #[expect(clippy::too_many_arguments, reason = "one call for codes and numbers")]
    fn boxes<S: Sample<Acc = Numbers<T>>>(
        &self,
        rect: Rect,
        sheet: &Sheet,
        parts: Parts,
        page: &Page<'_, S>,
        places: &mut Places,
        values: &mut Values<S>,
        mut put: impl FnMut(usize, &[S]),
    ) -> Result<()> {
        let (scale, offset) = self.to_level(parts.level);
        let offset = offset - page.origin;
        let [nx, ny] = parts.count;
        // At both ends of the first and the last row; between them moments are drawn by lines.
        let moments = |x: f64, y: f64| {
            let [right, down] = sheet.chart.footprint(rect, DVec2::new(x, y));
            let part = [right * scale / nx as f64, down * scale / ny as f64];
            half_sides(part).extend(covariance(part))
        };
        let ends = [[moments(-1.0, -1.0), moments(1.0, -1.0)], [moments(-1.0, 1.0), moments(1.0, 1.0)]];
        let len = values.means.len();
        values.numbers.resize(len * nx * ny, S::Acc::default());
        for row in 0..rect.h {
            let down = (row as f64 + 0.5) / rect.h as f64;
            let [left, right] = [0, 1].map(|k| ends[0][k].lerp(ends[1][k], down));
            let step = (right - left) / rect.w as f64;
            let first = left + 0.5 * step;
            let [across, down, lean] = [0, 1, 2].map(|k| [first[k] as f32, step[k] as f32]);
            for part in 0..nx * ny {
                let line = line(rect, row, parts.place(part), scale, offset);
                let (x, y) = (&mut places.x[..rect.w], &mut places.y[..rect.w]);
                sheet.chart.row(self.isa, &line, [&mut *x, &mut *y]);
                let given = Boxes { x, y, half: [across, down], lean };
                let taps = &mut values.taps;
                if nx * ny == 1 {
                    boxes(self.isa, &page.job, &given, taps, &mut values.means)?;
                } else {
                    let numbers = &mut values.numbers[part * len..(part + 1) * len];
                    box_numbers(self.isa, &page.job, &given, taps, numbers)?;
                }
            }
            if nx * ny > 1 {
                let (read, sums) = (&values.numbers[..], &mut values.sums[..]);
                compiled_for(self.isa, Mean { values: read, sums, out: &mut values.means[..] });
            }
            put(row, &values.means);
        }
        Ok(())
    }

    #[expect(clippy::too_many_arguments, reason = "one call for codes and numbers")]
    fn points<S: Sample<Acc = Numbers<T>>>(
        &self,
        rect: Rect,
        sheets: &[Sheet],
        grid: Grid,
        pages: &[Page<'_, S>],
        places: &mut Places,
        values: &mut Values<S>,
        mut put: impl FnMut(usize, &[S]),
    ) -> Result<()> {
        let channels = self.pictures.channels();
        let (scale, offset) = self.to_level(grid.level);
        let whole = sheets.len() == 1 && !sheets[0].edge;
        let points = grid.count() * rect.w;
        values.points.resize(points * channels, S::default());
        for row in 0..rect.h {
            for (k, (sheet, page)) in sheets.iter().zip(pages).enumerate() {
                for part in 0..grid.count() {
                    let offset = if whole { offset - page.origin } else { offset };
                    let line = line(rect, row, grid.place(part), scale, offset);
                    let at = k * points + part * rect.w..k * points + (part + 1) * rect.w;
                    sheet.chart.row(self.isa, &line, [&mut places.x[at.clone()], &mut places.y[at]]);
                }
            }
            let read = &mut values.points[..points * channels];
            if whole {
                let places = Points::Plain(&places.x[..points], &places.y[..points]);
                remap(self.isa, &pages[0].job, &places, read)?;
            } else {
                choose(places, points, self.pictures.level_size(grid.level).0.x, pages);
                let mut start = 0;
                while start < points {
                    let face = places.face[start];
                    let same = places.face[start..points].iter().take_while(|f| **f == face).count();
                    let run = start..start + same;
                    let places = Points::Plain(&places.x[run.clone()], &places.y[run.clone()]);
                    let read = &mut read[run.start * channels..run.end * channels];
                    remap(self.isa, &pages[usize::from(face)].job, &places, read)?;
                    start = run.end;
                }
            }
            if grid.count() == 1 {
                put(row, read);
            } else {
                let sums = &mut values.sums[..];
                compiled_for(self.isa, Mean { values: read, sums, out: &mut values.means[..] });
                put(row, &values.means);
            }
        }
        Ok(())
    }
}

/// One place of every pixel of a row of a rectangle.
fn line(rect: Rect, row: usize, within: DVec2, scale: DVec2, offset: DVec2) -> Line {
    let sides = DVec2::new(rect.w as f64, rect.h as f64);
    let first = (DVec2::new(0.0, row as f64) + within) * 2.0 / sides - 1.0;
    Line { y: first.y, first: first.x, step: 2.0 / sides.x, scale, offset }
}

/// For every point the first picture whose face it lies on, or else the nearest; its place there, squeezed along the
/// edge, goes to the front. `n` texels a side, and one around.
fn choose<S>(places: &mut Places, points: usize, n: f64, pages: &[Page<'_, S>]) {
    let Places { x, y, face: faces } = places;
    faces.clear();
    for i in 0..points {
        let mut best = (f64::INFINITY, 0, DVec2::ZERO);
        for k in 0..x.len() / points {
            let at = DVec2::new(f64::from(x[k * points + i]), f64::from(y[k * points + i]));
            // The outermost texels and those around are 1 and 0, n and n + 1.
            let q = (at - 0.5) / n * 2.0 - 1.0;
            let beyond = q.abs().max_element();
            if beyond < best.0 {
                best = (beyond, k, q);
            }
            if beyond <= 1.0 {
                break;
            }
        }
        let (_, face, q) = best;
        let at = (along(q.clamp(DVec2::NEG_ONE, DVec2::ONE), n) + 1.0) * 0.5 * n + 0.5 - pages[face].origin;
        (x[i], y[i]) = (at.x as f32, at.y as f32);
        faces.push(face as u8);
    }
}

/// Means of several rows of values, one row after the other.
struct Mean<'s, V: Sample, T: Sample> {
    values: &'s [V],
    sums: &'s mut [T::Acc],
    out: &'s mut [T],
}

impl<V: Sample<Acc = T::Acc>, T: Sample> Work for Mean<'_, V, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let len = self.out.len();
        let (base, rest) = self.values.split_at(len);
        self.sums.fill(T::Acc::default());
        // Sums of differences: equal values give exactly that.
        for row in rest.chunks_exact(len) {
            for ((sum, value), base) in self.sums.iter_mut().zip(row).zip(base) {
                *sum = *sum + (value.get() - base.get());
            }
        }
        let share = T::Acc::of(1.0 / (self.values.len() / len) as f64);
        for ((out, sum), base) in self.out.iter_mut().zip(self.sums.iter()).zip(base) {
            *out = T::put(base.get() + *sum * share);
        }
    }
}
