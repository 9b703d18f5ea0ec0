//! Primitives sorted into bands of rows, and pictures that are drawn band by band.
//!
//! A band belongs to one thread at a time, and the winner at a pixel does not depend on the order of faces, so the
//! bytes are the same for any number of threads.

use super::setup::{Bounds, Primitive, SUB, Screen, Setup, Viewport};
use super::visit::{Band, filled};
use super::{Cull, Geometry};
use crate::error::Result;
use crate::kernel::{Isa, compiled_for};
use crate::par;
use std::ops::Range;

/// Faces or vertices that a thread takes at a time.
const CHUNK: usize = 1 << 12;
/// A primitive that reaches over more bands than this goes to one list that every band reads, which bounds
/// the memory for lists.
const BIG: usize = 16;

/// Chunk and place in the chunk.
type Entry = (u32, u32);

/// Primitives of some faces by the bands of rows that they reach.
pub(super) struct Bins {
    /// Rows of a band.
    rows: i64,
    chunks: Vec<Vec<Primitive>>,
    bins: Vec<Vec<Entry>>,
    big: Vec<Entry>,
    /// First and last column that the primitives of each band may reach.
    columns: Vec<[i64; 2]>,
}

/// Columns of a band that nothing reaches.
const NOWHERE: [i64; 2] = [i64::MAX, -1];

impl Bins {
    /// Nothing yet, in bands of so many rows.
    pub(super) fn new(rows: usize, height: usize) -> Self {
        let bands = height.div_ceil(rows);
        let (bins, columns) = (vec![Vec::new(); bands], vec![NOWHERE; bands]);
        Self { rows: rows as i64, chunks: Vec::new(), bins, big: Vec::new(), columns }
    }

    /// Sets up `count` faces, the i-th of which is `face(i)`, in place of what was there.
    pub(super) fn fill(
        &mut self,
        setup: &Setup<'_>,
        count: usize,
        face: impl Fn(usize) -> usize + Sync,
    ) -> Result<()> {
        self.chunks.resize_with(count.div_ceil(CHUNK), Vec::new);
        par::for_each(self.chunks.iter_mut(), |c, out| {
            out.clear();
            for i in c * CHUNK..((c + 1) * CHUNK).min(count) {
                setup.face(face(i), |primitive| out.push(primitive));
            }
            Ok(())
        })?;
        self.bins.iter_mut().for_each(Vec::clear);
        self.big.clear();
        self.columns.fill(NOWHERE);
        for (c, chunk) in self.chunks.iter().enumerate() {
            for (k, primitive) in chunk.iter().enumerate() {
                let bounds = setup.bounds(primitive);
                let [top, bottom] = bounds.y.map(|y| (y as u32 / self.rows as u32) as usize);
                let entry = (c as u32, k as u32);
                for columns in &mut self.columns[top..=bottom] {
                    *columns = [columns[0].min(bounds.x[0]), columns[1].max(bounds.x[1])];
                }
                if bottom - top > BIG {
                    self.big.push(entry);
                } else {
                    self.bins[top..=bottom].iter_mut().for_each(|bin| bin.push(entry));
                }
            }
        }
        Ok(())
    }

    /// Columns of a band that any primitive may reach.
    fn columns(&self, band: usize) -> Range<usize> {
        let [first, last] = self.columns[band];
        if first <= last { first as usize..last as usize + 1 } else { 0..0 }
    }

    /// Whether any primitive may reach a band.
    fn reaches(&self, band: usize) -> bool {
        !(self.big.is_empty() && self.bins[band].is_empty())
    }

    /// Hands on the primitives that reach a band, with their bounds in it.
    #[inline(always)]
    pub(super) fn visit(&self, setup: &Setup<'_>, band: usize, mut work: impl FnMut(&Primitive, Bounds)) {
        let (first, last) = (band as i64 * self.rows, (band as i64 + 1) * self.rows - 1);
        for &(c, k) in self.big.iter().chain(&self.bins[band]) {
            let primitive = &self.chunks[c as usize][k as usize];
            let mut bounds = setup.bounds(primitive);
            bounds.y = [bounds.y[0].max(first), bounds.y[1].min(last)];
            if !bounds.is_empty() {
                work(primitive, bounds);
            }
        }
    }
}

/// Vertices of a geometry on the screen.
pub(crate) struct Projected<'a> {
    pub(super) geometry: &'a Geometry,
    pub(super) screen: Vec<Screen>,
    pub(super) viewport: Viewport,
    size: (usize, usize),
    isa: Isa,
}

impl<'a> Projected<'a> {
    /// Projects and snaps all vertices for a picture of a checked size.
    pub(crate) fn new(geometry: &'a Geometry, size: (usize, usize)) -> Result<Self> {
        let viewport = Viewport::new(size.0, size.1);
        let mut screen = filled(geometry.positions().len(), Screen::default())?;
        let tiles = screen.chunks_mut(CHUNK).zip(geometry.positions().chunks(CHUNK));
        par::for_each(tiles, |_, (out, positions)| {
            for (out, &position) in out.iter_mut().zip(positions) {
                *out = viewport.project(position);
            }
            Ok(())
        })?;
        Ok(Self { geometry, screen, viewport, size, isa: Isa::current() })
    }

    /// What the set-up of faces needs.
    pub(super) fn setup(&self, cull: Cull<'a>) -> Setup<'_> {
        let centre = SUB / 2;
        let Self { geometry, screen, viewport, isa, .. } = self;
        Setup { geometry, screen, viewport: *viewport, cull, isa: *isa, reach: [centre, centre] }
    }
}

/// What is seen of some faces, to be drawn band by band.
pub(crate) struct Banded<'a> {
    setup: Setup<'a>,
    size: (usize, usize),
    bins: Bins,
}

/// One surface of a band: depth and face at each pixel, as in [`Fragments`](super::Fragments).
#[derive(Default)]
pub(crate) struct Layer {
    pub(crate) depth: Vec<f32>,
    pub(crate) triangle: Vec<i32>,
}

impl<'a> Banded<'a> {
    /// Sorts `faces` into bands of `rows` rows.
    pub(crate) fn new(
        projected: &'a Projected<'_>,
        cull: Cull<'a>,
        faces: &[u32],
        rows: usize,
    ) -> Result<Self> {
        let setup = projected.setup(cull);
        let mut bins = Bins::new(rows, projected.size.1);
        bins.fill(&setup, faces.len(), |i| faces[i] as usize)?;
        Ok(Self { setup, size: projected.size, bins })
    }

    /// Whether any face may be seen in a band.
    pub(crate) fn reaches(&self, band: usize) -> bool {
        self.bins.reaches(band)
    }

    /// Faces that may be seen, some of them several times.
    pub(crate) fn faces(&self) -> impl Iterator<Item = usize> {
        self.bins.chunks.iter().flatten().map(|primitive| primitive.face as usize)
    }

    /// Columns of a band that any face may reach; an empty range for none.
    pub(crate) fn columns(&self, band: usize) -> Range<usize> {
        self.bins.columns(band)
    }

    /// Draws what is nearest in a band, or nearest behind another layer of it. Of each row there are the columns of
    /// `window` alone, all that [`Banded::columns`] names among them.
    pub(crate) fn draw(&self, band: usize, window: &Range<usize>, behind: Option<&Layer>, out: &mut Layer) {
        let first_row = band * self.bins.rows as usize;
        let pixels = window.len() * (self.bins.rows as usize).min(self.size.1 - first_row);
        out.depth.clear();
        out.depth.resize(pixels, f32::INFINITY);
        out.triangle.clear();
        out.triangle.resize(pixels, -1);
        let mut target = Band {
            first_row: first_row as i64,
            left: window.start as i64,
            width: window.len(),
            depth: &mut out.depth,
            triangle: &mut out.triangle,
            behind: behind.map(|layer| (&layer.depth[..], &layer.triangle[..])),
        };
        compiled_for(self.setup.isa, || {
            self.bins.visit(&self.setup, band, |primitive, bounds| target.draw_centres(primitive, bounds));
        });
    }
}
