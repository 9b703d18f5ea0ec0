//! Pictures band by band: what is seen in some rows, its layers from front to back, its light, and the finished rows.
//!
//! Everything that a band needs beside the mesh fits in a cache, and is used again for the next band.

use super::batch::Batch;
use super::picture::{Finish, Rows};
use super::{Frame, MAX_LAYERS};
use crate::error::Result;
use crate::mesh::{AlphaMode, Mesh};
use crate::raster::{Banded, Cull, Geometry, Layer, Projected, runs};
use crate::shade::over;
use std::collections::BTreeSet;
use std::ops::Range;

/// Least rows of a band.
const BAND: usize = 32;
/// Pixels that are lit together: whole rows, about this many pixels.
const SLICE_PX: usize = 1 << 13;
/// From this alpha on nothing behind a pixel shows: less than half a code of 16 bits.
const FULL: f32 = 1.0 - 1.0 / 131_072.0;

/// How a drawing is cut into rows: by its size alone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cut {
    size: (usize, usize),
    times: usize,
    /// Rows of a slice: a multiple of those that make one row of the picture.
    slice: usize,
    /// Rows of a band: a multiple of those of a slice.
    band: usize,
}

impl Cut {
    /// For a drawing of `size` whose rows are averaged `times` by `times`.
    pub fn new(size: (usize, usize), times: usize) -> Self {
        let slice = (SLICE_PX / size.0 / times).max(1) * times;
        Self { size, times, slice, band: BAND.div_ceil(slice) * slice }
    }

    /// Rows of a band.
    pub fn rows(&self) -> usize {
        self.band
    }
}

/// The faces of a mesh, ready to be drawn band by band.
pub(super) struct Stage<'a> {
    geometry: &'a Geometry,
    cut: Cut,
    /// Opaque faces: the nearest is seen.
    solid: Banded<'a>,
    /// The others: layer behind layer.
    clear: Banded<'a>,
}

/// Faces by kind, and whose backs are left out.
pub(super) struct Kinds {
    solid: Vec<u32>,
    clear: Vec<u32>,
    single_sided: Vec<bool>,
}

impl Kinds {
    /// Of a mesh's faces; `all_solid` takes every one for opaque.
    pub fn new(mesh: &Mesh, all_solid: bool) -> Self {
        let of: Vec<(bool, bool)> = mesh
            .materials
            .iter()
            .map(|m| (all_solid || m.alpha_mode == AlphaMode::Opaque, !m.double_sided))
            .collect();
        let material = |f: &u32| of[mesh.face_material[*f as usize] as usize];
        let faces = 0..mesh.faces.len() as u32;
        let (solid, clear) = faces.clone().partition(|f| material(f).0);
        Self { solid, clear, single_sided: faces.map(|f| material(&f).1).collect() }
    }
}

impl<'a> Stage<'a> {
    pub fn new(
        projected: &'a Projected<'_>,
        geometry: &'a Geometry,
        kinds: &'a Kinds,
        cut: Cut,
    ) -> Result<Self> {
        let sorted = |faces| Banded::new(projected, Cull::BackOf(&kinds.single_sided), faces, cut.band);
        Ok(Self { geometry, cut, solid: sorted(&kinds.solid)?, clear: sorted(&kinds.clear)? })
    }

    /// Faces that may be seen, some of them several times.
    pub fn faces(&self) -> impl Iterator<Item = usize> {
        self.solid.faces().chain(self.clear.faces())
    }

    /// Columns of a band that any face may reach, cut so that they make whole pixels of the picture.
    fn window(&self, band: usize) -> Range<usize> {
        let (solid, clear) = (self.solid.columns(band), self.clear.columns(band));
        let columns = match (solid.is_empty(), clear.is_empty()) {
            (_, true) => solid,
            (true, false) => clear,
            (false, false) => solid.start.min(clear.start)..solid.end.max(clear.end),
        };
        let times = self.cut.times;
        columns.start / times * times..columns.end.div_ceil(times) * times
    }

    /// Rows of a band.
    fn rows(&self, band: usize) -> usize {
        self.cut.band.min(self.cut.size.1 - band * self.cut.band)
    }

    /// Materials that a band shows.
    pub fn materials(&self, mesh: &Mesh, band: usize, scratch: &mut Scratch) -> BTreeSet<u32> {
        let mut found = BTreeSet::new();
        let mut note = |faces: &[i32]| {
            let mut last = -1;
            for &face in faces {
                if face >= 0 && face != last {
                    found.insert(mesh.face_material[face as usize]);
                }
                last = face;
            }
        };
        let layers = &mut scratch.layers;
        layers.start(self, band, self.window(band));
        note(&layers.nearest.triangle);
        let mut number = 0;
        while layers.next(self, band, number, &[]) {
            note(&layers.shown);
            number += 1;
        }
        found
    }
}

/// What is seen in a band, layer by layer.
#[derive(Default)]
struct Layers {
    nearest: Layer,
    front: Layer,
    current: Layer,
    /// Faces of the current layer, -1 where nothing of it is seen.
    shown: Vec<i32>,
    /// Columns that all of them have.
    window: Range<usize>,
}

impl Layers {
    fn start(&mut self, stage: &Stage<'_>, band: usize, window: Range<usize>) {
        stage.solid.draw(band, &window, None, &mut self.nearest);
        self.window = window;
    }

    /// Draws layer `number` of what is not opaque, and tells whether anything of it is seen: before the opaque faces,
    /// and behind `pixels` that are not full yet.
    fn next(&mut self, stage: &Stage<'_>, band: usize, number: usize, pixels: &[[f32; 4]]) -> bool {
        if number >= MAX_LAYERS || !stage.clear.reaches(band) {
            return false;
        }
        std::mem::swap(&mut self.front, &mut self.current);
        let front = (number > 0).then_some(&self.front);
        stage.clear.draw(band, &self.window, front, &mut self.current);
        self.shown.clear();
        let solid = self.nearest.depth.iter();
        let is_open = |(z, solid): (&f32, &f32)| z < solid;
        let own = self.current.triangle.iter();
        self.shown.extend(
            own.zip(self.current.depth.iter().zip(solid)).map(|(&t, z)| if is_open(z) { t } else { -1 }),
        );
        for (t, _) in self.shown.iter_mut().zip(pixels).filter(|(_, p)| p[3] >= FULL) {
            *t = -1;
        }
        self.shown.iter().any(|&t| t >= 0)
    }
}

/// Room that one thread works in.
#[derive(Default)]
pub(super) struct Scratch {
    layers: Layers,
    pixels: Vec<[f32; 4]>,
    gathered: Gathered,
}

/// Draws one band and finishes its rows.
pub(super) fn draw(
    frame: &Frame<'_>,
    stage: &Stage<'_>,
    band: usize,
    finish: &Finish,
    out: Rows<'_>,
    scratch: &mut Scratch,
) -> Result<()> {
    let cut = stage.cut;
    let Scratch { layers, pixels, gathered } = scratch;
    // Where the environment is seen no pixel is empty.
    let window = if frame.sky().is_some() { 0..cut.size.0 } else { stage.window(band) };
    let (rows, width, first) = (stage.rows(band), window.len(), band * cut.band);
    let slices = (0..rows).step_by(cut.slice).map(|top| top..(top + cut.slice).min(rows));
    let place = |slice: &Range<usize>| Place { top: first + slice.start, window: window.clone() };
    layers.start(stage, band, window.clone());
    pixels.clear();
    pixels.resize(rows * width, [0.0; 4]);
    let mut number = 0;
    while layers.next(stage, band, number, pixels) {
        for slice in slices.clone() {
            let own = slice.start * width..slice.end * width;
            let (shown, pixels) = (&layers.shown[own.clone()], &mut pixels[own]);
            shade(frame, stage, gathered, shown, &place(&slice), number, pixels)?;
        }
        number += 1;
    }
    let mut out = out;
    for slice in slices {
        let own = slice.start * width..slice.end * width;
        let (shown, pixels) = (&mut layers.nearest.triangle[own.clone()], &mut pixels[own]);
        if number > 0 {
            shown.iter_mut().zip(&*pixels).filter(|(_, p)| p[3] >= FULL).for_each(|(t, _)| *t = -1);
        }
        let place = place(&slice);
        shade(frame, stage, gathered, shown, &place, MAX_LAYERS, pixels)?;
        frame.fill(cut.size, place.top, pixels)?;
        out = finish.rows(pixels, &window, slice.len(), out);
    }
    Ok(())
}

/// Where a slice lies in the drawing.
struct Place {
    /// First row.
    top: usize,
    /// Columns.
    window: Range<usize>,
}

/// Shades the faces that a layer shows in a slice, and puts them under what `pixels` hold.
fn shade(
    frame: &Frame<'_>,
    stage: &Stage<'_>,
    gathered: &mut Gathered,
    shown: &[i32],
    place: &Place,
    layer: usize,
    pixels: &mut [[f32; 4]],
) -> Result<()> {
    gathered.fill(stage, frame.view.mesh, shown, place)?;
    for (material, batch) in gathered.used() {
        let Some(sampled) = &frame.materials[*material as usize] else { continue };
        // Every batch its own random numbers, the same for any number of threads.
        let seed = ((layer as u64) << 48) ^ ((place.top as u64) << 24) ^ u64::from(*material);
        let colors = match frame.options.debug {
            Some(debug) => debug.colors(frame, sampled, batch)?,
            None => super::light::light(frame, sampled, batch, seed)?,
        };
        for (p, color) in batch.pixels().zip(colors) {
            pixels[p] = over(pixels[p], color);
        }
    }
    Ok(())
}

/// Faces that are looked up quickly, a power of two.
const KNOWN: usize = 1 << 10;

/// What a slice shows, sorted by material. Rooms are kept for the next slice.
#[derive(Default)]
struct Gathered {
    batches: Vec<(u32, Batch)>,
    used: usize,
    /// Faces met lately, by the last bits of their index.
    known: Vec<Known>,
    /// Number of the slice: tells entries of this slice from older ones.
    round: u32,
}

/// Where a face went.
#[derive(Clone, Copy, Default)]
struct Known {
    face: u32,
    round: u32,
    batch: u32,
    number: u32,
}

impl Gathered {
    fn used(&self) -> &[(u32, Batch)] {
        &self.batches[..self.used]
    }

    /// Gathers rows of faces, -1 for none.
    fn fill(&mut self, stage: &Stage<'_>, mesh: &Mesh, shown: &[i32], place: &Place) -> Result<()> {
        let size = stage.cut.size;
        self.used = 0;
        self.round = self.round.wrapping_add(1);
        if self.round <= 1 {
            self.round = 1;
            self.known.clear();
            self.known.resize(KNOWN, Known::default());
        }
        let (left, width) = (place.window.start, place.window.len());
        for (k, row) in shown.chunks(width.max(1)).enumerate() {
            let y = place.top + k;
            runs(row, |own: Range<usize>, face| {
                let x = own.start + left..own.end + left;
                let slot = face % KNOWN;
                let mut known = self.known[slot];
                if (known.face as usize, known.round) != (face, self.round) {
                    let batch = self.batch(mesh.face_material[face]);
                    let of = (stage.geometry, face);
                    let number = self.batches[batch].1.add(face, of, [x.start, y], size);
                    known = Known { face: face as u32, round: self.round, batch: batch as u32, number };
                    self.known[slot] = known;
                }
                let batch = &mut self.batches[known.batch as usize].1;
                batch.push(k * width + own.start, x, y, known.number);
                Ok(())
            })?;
        }
        Ok(())
    }

    /// The batch of a material, empty where it is new.
    fn batch(&mut self, material: u32) -> usize {
        let known = self.used().iter().position(|(m, _)| *m == material);
        known.unwrap_or_else(|| {
            if self.used == self.batches.len() {
                self.batches.push((material, Batch::default()));
            }
            let (of, batch) = &mut self.batches[self.used];
            *of = material;
            batch.clear();
            self.used += 1;
            self.used - 1
        })
    }
}
