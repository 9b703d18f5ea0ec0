//! The visit: bands of rows, spans of pixels, depth test, visibility buffer, coverage.
//!
//! Faces are taken in batches; each batch is set up in chunks, sorted into bands of rows, and drawn band by
//! band. A band belongs to one thread at a time and the winner at a pixel does not depend on the order of
//! faces, so the bytes are the same for any number of threads.

use super::setup::{Bounds, Edges, Primitive, SUB, Screen, Setup, Viewport};
use super::{Fragments, Geometry, Options};
use crate::error::{Error, Result};
use crate::par;

/// Rows of a band.
const BAND: usize = 32;
/// Faces set up together: bounds the memory for primitives.
const BATCH: usize = 1 << 16;
/// Faces or vertices that a thread takes at a time.
const CHUNK: usize = 1 << 12;
/// A primitive that reaches over more bands than this goes to one list that every band reads, which bounds
/// the memory for lists.
const BIG: i64 = 16;

/// Draws all faces of checked arguments.
pub(super) fn visit(
    geometry: &Geometry,
    (width, height): (usize, usize),
    options: &Options<'_>,
) -> Result<Fragments> {
    let viewport = Viewport::new(width, height);
    let mut screen = filled(geometry.positions().len(), Screen::default())?;
    let tiles = screen.chunks_mut(CHUNK).zip(geometry.positions().chunks(CHUNK));
    par::for_each(tiles, |_, (out, positions)| {
        for (out, &position) in out.iter_mut().zip(positions) {
            *out = viewport.project(position);
        }
        Ok(())
    })?;

    let pixels = width * height;
    let mut triangle = filled(pixels, -1i32)?;
    let mut depth = filled(pixels, f32::INFINITY)?;
    let centre = SUB / 2;
    let mut setup =
        Setup { geometry, screen: &screen, viewport, cull: options.cull, reach: [centre, centre] };
    let rows = |i: usize| i * BAND * width..;
    let behind = options.behind.map(|front| (front.depth(), front.triangle()));
    let mut bands: Vec<Band<'_>> = depth
        .chunks_mut(BAND * width)
        .zip(triangle.chunks_mut(BAND * width))
        .enumerate()
        .map(|(i, (depth, triangle))| Band {
            first_row: (i * BAND) as i64,
            width,
            depth,
            triangle,
            behind: behind.map(|(d, t)| (&d[rows(i)], &t[rows(i)])),
        })
        .collect();
    draw(&setup, &mut bands, |band, primitive, bounds| band.draw_centres(primitive, bounds))?;

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
        draw(&setup, &mut bands, |band, primitive, bounds| band.draw_samples(primitive, bounds))?;
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
    bands: &mut [B],
    work: impl Fn(&mut B, &Primitive, Bounds) + Sync,
) -> Result<()> {
    let faces = setup.geometry.faces().len();
    let mut chunks: Vec<Vec<Primitive>> = vec![Vec::new(); BATCH.min(faces).div_ceil(CHUNK)];
    let mut bins: Vec<Vec<(u32, u32)>> = vec![Vec::new(); bands.len()];
    for batch in (0..faces).step_by(BATCH) {
        par::for_each(chunks.iter_mut(), |i, out| {
            out.clear();
            let start = (batch + i * CHUNK).min(faces);
            for face in start..(start + CHUNK).min(batch + BATCH).min(faces) {
                setup.face(face, |primitive| out.push(primitive));
            }
            Ok(())
        })?;
        bins.iter_mut().for_each(Vec::clear);
        let mut big = Vec::new();
        for (c, chunk) in chunks.iter().enumerate() {
            for (k, primitive) in chunk.iter().enumerate() {
                let [top, bottom] = setup.bounds(primitive).y.map(|y| y / BAND as i64);
                let entry = (c as u32, k as u32);
                if bottom - top > BIG {
                    big.push(entry);
                } else {
                    for bin in &mut bins[top as usize..=bottom as usize] {
                        bin.push(entry);
                    }
                }
            }
        }
        par::for_each(bands.iter_mut().zip(&bins), |i, (band, bin)| {
            let rows = [(i * BAND) as i64, (i * BAND + BAND - 1) as i64];
            for &(c, k) in big.iter().chain(bin) {
                let primitive = &chunks[c as usize][k as usize];
                let mut bounds = setup.bounds(primitive);
                bounds.y = [bounds.y[0].max(rows[0]), bounds.y[1].min(rows[1])];
                if !bounds.is_empty() {
                    work(band, primitive, bounds);
                }
            }
            Ok(())
        })?;
    }
    Ok(())
}

/// Rows of the outputs that one thread draws.
struct Band<'a> {
    first_row: i64,
    width: usize,
    depth: &'a mut [f32],
    triangle: &'a mut [i32],
    behind: Option<(&'a [f32], &'a [i32])>,
}

impl Band<'_> {
    /// Position of pixel (x, y) in the band's slices.
    fn index(&self, x: i64, y: i64) -> usize {
        (y - self.first_row) as usize * self.width + x as usize
    }

    fn draw_centres(&mut self, primitive: &Primitive, bounds: Bounds) {
        let edges = primitive.edges();
        edges.spans(bounds, [SUB / 2, SUB / 2], |y, first, last| {
            let start = self.index(first, y);
            let span = start..start + (last - first) as usize + 1;
            let line = Line::new(&edges, primitive.face, y, first);
            let (depth, triangle) = (&mut self.depth[span.clone()], &mut self.triangle[span.clone()]);
            match self.behind {
                None => line.draw(depth, triangle),
                Some((d, t)) => line.draw_behind(depth, triangle, &d[span.clone()], &t[span]),
            }
        });
    }
}

/// One triangle along one row.
struct Line {
    z: f64,
    step: f64,
    hull: [f32; 2],
    face: i32,
}

impl Line {
    #[inline(always)]
    fn new(edges: &Edges, face: i32, y: i64, first: i64) -> Self {
        let (z, step) = edges.depth_row(y, first);
        Self { z, step, hull: edges.hull(), face }
    }

    /// Depth at the k-th pixel. Rounding may not take it out of the triangle's range.
    #[inline(always)]
    fn depth(&self, k: usize) -> f32 {
        let z = (self.z + k as i32 as f64 * self.step) as f32;
        // Comparisons that a plain maximum and minimum instruction can do: NaN, which an overflowing slope of
        // a sliver gives, becomes the lower end.
        let z = if z > self.hull[0] { z } else { self.hull[0] };
        if z < self.hull[1] { z } else { self.hull[1] }
    }

    #[inline(always)]
    fn draw(&self, depth: &mut [f32], triangle: &mut [i32]) {
        for (k, (d, t)) in depth.iter_mut().zip(triangle).enumerate() {
            let z = self.depth(k);
            let nearer = (z < *d) | ((z == *d) & (self.face < *t));
            *d = if nearer { z } else { *d };
            *t = if nearer { self.face } else { *t };
        }
    }

    #[inline(always)]
    fn draw_behind(&self, depth: &mut [f32], triangle: &mut [i32], front_d: &[f32], front_t: &[i32]) {
        let fronts = front_d.iter().zip(front_t);
        for (k, ((d, t), (&fd, &ft))) in depth.iter_mut().zip(triangle).zip(fronts).enumerate() {
            let z = self.depth(k);
            let behind = z > fd || (z == fd && self.face > ft);
            if behind && (z < *d || (z == *d && self.face < *t)) {
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
        let edges = primitive.edges();
        for (bit, &sample) in self.samples.iter().enumerate() {
            edges.spans(bounds, sample, |y, first, last| {
                let start = self.band.index(first, y);
                let line = Line::new(&edges, primitive.face, y, first);
                for k in 0..=(last - first) as usize {
                    let (p, z) = (start + k, line.depth(k));
                    let behind = self
                        .band
                        .behind
                        .is_none_or(|(d, t)| z > d[p] || (z == d[p] && primitive.face > t[p]));
                    if !behind {
                        continue;
                    }
                    self.masks[p] |= 1 << bit;
                    if self.free[p] {
                        line.draw(&mut self.band.depth[p..=p], &mut self.band.triangle[p..=p]);
                    }
                }
            });
        }
    }
}
