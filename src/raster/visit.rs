//! The visit: spans of pixels, depth test, visibility buffer, coverage.
//!
//! Faces are taken in batches; each batch is sorted into bands of rows, and drawn band by band.

use super::bins::{Bins, Projected};
use super::setup::{Bounds, DepthRow, Group, LANES, Primitive, SUB, Setup};
use super::{Fragments, Geometry, Options};
use crate::error::{Error, Result};
use crate::kernel::compiled_for;
use crate::par;

/// Rows of a band.
const BAND: usize = 32;
/// Faces set up together: bounds the memory for primitives.
const BATCH: usize = 1 << 16;

/// Draws all faces of checked arguments.
pub(super) fn visit(
    geometry: &Geometry,
    (width, height): (usize, usize),
    options: &Options<'_>,
) -> Result<Fragments> {
    let projected = Projected::new(geometry, (width, height))?;
    let pixels = width * height;
    let mut triangle = filled(pixels, -1i32)?;
    let mut depth = filled(pixels, f32::INFINITY)?;
    let mut setup = projected.setup(options.cull);
    let rows = |i: usize| i * BAND * width..;
    let behind = options.behind.map(|front| (front.depth(), front.triangle()));
    let mut bands: Vec<Band<'_>> = depth
        .chunks_mut(BAND * width)
        .zip(triangle.chunks_mut(BAND * width))
        .enumerate()
        .map(|(i, (depth, triangle))| Band {
            first_row: (i * BAND) as i64,
            left: 0,
            width,
            depth,
            triangle,
            behind: behind.map(|(d, t)| (&d[rows(i)], &t[rows(i)])),
        })
        .collect();
    draw(&setup, height, &mut bands, |band, primitive, bounds| band.draw_centres(primitive, bounds))?;

    let samples = sample_places(options.samples);
    let coverage = if samples.is_empty() {
        None
    } else {
        let mut masks = filled(pixels, 0u16)?;
        let mut bands: Vec<SampledBand<'_>> = bands
            .into_iter()
            .zip(masks.chunks_mut(BAND * width))
            .map(|(band, masks)| SampledBand {
                free: band.triangle.iter().map(|&t| t < 0).collect(),
                band,
                masks,
                samples: &samples,
            })
            .collect();
        setup.reach = [0, SUB - 1];
        draw(&setup, height, &mut bands, |band, primitive, bounds| band.draw_samples(primitive, bounds))?;
        let share = 1.0 / samples.len() as f32;
        Some(masks.iter().map(|mask| mask.count_ones() as f32 * share).collect())
    };
    Ok(Fragments { width, height, triangle, depth, coverage })
}

/// Places of the samples in a pixel: the first points of the Hammersley sequence, off the pixel's borders.
fn sample_places(samples: usize) -> Vec<[i64; 2]> {
    if samples < 2 {
        return Vec::new();
    }
    let bits = samples.trailing_zeros();
    let step = SUB / samples as i64;
    let place = |i: usize| i as i64 * step + step / 2;
    (0..samples).map(|i| [place(i), place(i.reverse_bits() >> (usize::BITS - bits))]).collect()
}

/// A vector of equal elements, or an error where memory does not suffice.
pub(super) fn filled<T: Clone>(len: usize, value: T) -> Result<Vec<T>> {
    let mut out = room(len)?;
    out.resize(len, value);
    Ok(out)
}

/// An empty vector with room for so many elements, or an error where memory does not suffice.
fn room<T>(len: usize) -> Result<Vec<T>> {
    let mut out = Vec::new();
    if out.try_reserve_exact(len).is_err() {
        let bytes = len.saturating_mul(size_of::<T>());
        return Err(Error::value(
            "size",
            format!("{bytes} bytes of output"),
            "an output that fits in memory",
        ));
    }
    Ok(out)
}

/// A vector of zeros, straight from the system where it gives cleared memory.
pub(super) fn zeros<T: Clone + Default>(len: usize) -> Result<Vec<T>> {
    // Only asks whether there is room: `vec!` cannot fail softly.
    drop(room::<T>(len)?);
    Ok(vec![T::default(); len])
}

/// Sets up all faces and hands each band the primitives that reach it.
fn draw<B: Send>(
    setup: &Setup<'_>,
    height: usize,
    bands: &mut [B],
    work: impl Fn(&mut B, &Primitive, Bounds) + Sync,
) -> Result<()> {
    let faces = setup.geometry.faces().len();
    let mut bins = Bins::new(BAND, height);
    for batch in (0..faces).step_by(BATCH) {
        bins.fill(setup, BATCH.min(faces - batch), |i| batch + i)?;
        par::for_each(bands.iter_mut(), |i, band| {
            compiled_for(setup.isa, || {
                bins.visit(setup, i, |primitive, bounds| work(band, primitive, bounds));
            });
            Ok(())
        })?;
    }
    Ok(())
}

/// Rows of the outputs that one thread draws.
pub(super) struct Band<'a> {
    pub(super) first_row: i64,
    /// First column.
    pub(super) left: i64,
    /// Columns.
    pub(super) width: usize,
    pub(super) depth: &'a mut [f32],
    pub(super) triangle: &'a mut [i32],
    /// Depths and faces that are seen through.
    pub(super) behind: Option<(&'a [f32], &'a [i32])>,
}

impl Band<'_> {
    /// Position of pixel (x, y) in the band's slices.
    fn index(&self, x: i64, y: i64) -> usize {
        (y - self.first_row) as usize * self.width + (x - self.left) as usize
    }

    /// Draws a primitive where it covers centres of pixels.
    #[inline(always)]
    pub(super) fn draw_centres(&mut self, primitive: &Primitive, bounds: Bounds) {
        if self.width >= LANES && bounds.x[1] - bounds.x[0] < LANES as i64 {
            let left = bounds.x[0].min(self.left + (self.width - LANES) as i64);
            if let Some(group) = Group::new(primitive, [left, bounds.y[0]]) {
                return self.draw_group(primitive, group, left, bounds.y);
            }
        }
        let (edges, depths) = (primitive.edges(), primitive.depth());
        edges.spans(bounds, [SUB / 2, SUB / 2], |y, first, last| {
            let start = self.index(first, y);
            let span = start..start + (last - first) as usize + 1;
            let line = Line { depth: depths.row(y, first), face: primitive.face };
            let (depth, triangle) = (&mut self.depth[span.clone()], &mut self.triangle[span.clone()]);
            match self.behind {
                None => line.draw(depth, triangle),
                Some((d, t)) => line.draw_behind(depth, triangle, &d[span.clone()], &t[span]),
            }
        });
    }

    /// Draws a primitive none of whose rows is longer than a group of pixels, the first of which is in column `left`.
    #[inline(always)]
    fn draw_group(&mut self, primitive: &Primitive, mut group: Group, left: i64, rows: [i64; 2]) {
        let depths = primitive.depth();
        for y in rows[0]..=rows[1] {
            let mut outside = group.next_row();
            let at = self.index(left, y);
            let line = Line { depth: depths.row(y, left), face: primitive.face };
            if let Some((d, t)) = self.behind {
                line.hide(&mut outside, &d[at..at + LANES], &t[at..at + LANES]);
            }
            let own = (self.depth[at..].first_chunk_mut(), self.triangle[at..].first_chunk_mut());
            if let (Some(depth), Some(triangle)) = own {
                line.draw_group(&outside, depth, triangle);
            }
        }
    }
}

/// One triangle along one row.
struct Line {
    depth: DepthRow,
    face: i32,
}

impl Line {
    #[inline(always)]
    fn draw(&self, depth: &mut [f32], triangle: &mut [i32]) {
        for (k, (d, t)) in depth.iter_mut().zip(triangle).enumerate() {
            let z = self.depth.at(k);
            let nearer = (z < *d) | ((z == *d) & (self.face < *t));
            *d = if nearer { z } else { *d };
            *t = if nearer { self.face } else { *t };
        }
    }

    /// As [`Line::draw`], where `outside` is not negative: all is read before anything is written, so that the pixels can be
    /// worked on together.
    #[inline(always)]
    fn draw_group(&self, outside: &[i32; LANES], depth: &mut [f32; LANES], triangle: &mut [i32; LANES]) {
        let (before, owner) = (*depth, *triangle);
        let (mut nearest, mut face) = (before, owner);
        for k in 0..LANES {
            let z = self.depth.at(k);
            let nearer = ((z < before[k]) | ((z == before[k]) & (self.face < owner[k]))) & (outside[k] >= 0);
            nearest[k] = if nearer { z } else { before[k] };
            face[k] = if nearer { self.face } else { owner[k] };
        }
        (*depth, *triangle) = (nearest, face);
    }

    #[inline(always)]
    fn is_behind(&self, z: f32, front_d: f32, front_t: i32) -> bool {
        z > front_d || (z == front_d && self.face > front_t)
    }

    /// Makes `outside` negative where this is not behind what is in front.
    #[inline(always)]
    fn hide(&self, outside: &mut [i32; LANES], front_d: &[f32], front_t: &[i32]) {
        for (k, (out, (&d, &t))) in outside.iter_mut().zip(front_d.iter().zip(front_t)).enumerate() {
            if !self.is_behind(self.depth.at(k), d, t) {
                *out = -1;
            }
        }
    }

    #[inline(always)]
    fn draw_behind(&self, depth: &mut [f32], triangle: &mut [i32], front_d: &[f32], front_t: &[i32]) {
        let fronts = front_d.iter().zip(front_t);
        for (k, ((d, t), (&fd, &ft))) in depth.iter_mut().zip(triangle).zip(fronts).enumerate() {
            let z = self.depth.at(k);
            if self.is_behind(z, fd, ft) && (z < *d || (z == *d && self.face < *t)) {
                (*d, *t) = (z, self.face);
            }
        }
    }
}

/// A band whose centres are drawn, and the samples that were hit in each pixel.
struct SampledBand<'a> {
    band: Band<'a>,
    masks: &'a mut [u16],
    /// Pixels that no triangle covers at the centre.
    free: Vec<bool>,
    samples: &'a [[i64; 2]],
}

impl SampledBand<'_> {
    fn draw_samples(&mut self, primitive: &Primitive, bounds: Bounds) {
        let (edges, depths) = (primitive.edges(), primitive.depth());
        for (bit, &sample) in self.samples.iter().enumerate() {
            edges.spans(bounds, sample, |y, first, last| {
                let start = self.band.index(first, y);
                let line = Line { depth: depths.row(y, first), face: primitive.face };
                for k in 0..=(last - first) as usize {
                    let (p, z) = (start + k, line.depth.at(k));
                    if !self.band.behind.is_none_or(|(d, t)| line.is_behind(z, d[p], t[p])) {
                        continue;
                    }
                    self.masks[p] |= 1 << bit;
                    if self.free[p] {
                        let line = Line { depth: depths.row(y, first + k as i64), face: primitive.face };
                        line.draw(&mut self.band.depth[p..=p], &mut self.band.triangle[p..=p]);
                    }
                }
            });
        }
    }
}
