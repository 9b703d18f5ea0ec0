//! One layer of one tile: gather, sample, light, composite.

use super::batch::Batch;
use super::{Drawn, Frame};
use crate::error::Result;
use crate::raster::Fragments;
use crate::shade::over;
use std::ops::Range;

/// From this alpha on nothing behind a pixel shows: less than half a code of 16 bits.
const FULL: f32 = 1.0 - 1.0 / 131_072.0;

/// Shades the pixels of a tile that a layer shows, and puts them under what `tile` holds. Of a layer with a
/// `nearest` opaque surface only what lies before that counts.
pub(super) fn shade_tile(
    frame: &Frame<'_>,
    drawn: &Drawn,
    (fragments, nearest): (&Fragments, Option<&Fragments>),
    rows: Range<usize>,
    layer: usize,
    tile: &mut [[f32; 4]],
) -> Result<()> {
    let mesh = frame.view.mesh;
    let first = rows.start * fragments.width();
    let mut batches: Vec<(u32, Batch)> = Vec::new();
    let mut current = 0;
    fragments.walk(&drawn.geometry, rows.clone(), |p, face, weights| {
        let hidden = nearest.is_some_and(|n| fragments.depth()[first + p] >= n.depth()[first + p]);
        if hidden || tile[p][3] >= FULL {
            return;
        }
        let face = drawn.faces[face] as usize;
        let material = mesh.face_material[face];
        if batches.get(current).is_none_or(|(m, _)| *m != material) {
            current = batches.iter().position(|(m, _)| *m == material).unwrap_or_else(|| {
                batches.push((material, Batch::default()));
                batches.len() - 1
            });
        }
        batches[current].1.push(p, face, weights);
    })?;
    for (material, batch) in &batches {
        let Some(sampled) = &frame.materials[*material as usize] else { continue };
        // Every batch its own random numbers, the same for any number of threads.
        let seed = ((layer as u64) << 48) ^ ((rows.start as u64) << 24) ^ u64::from(*material);
        let colors = match frame.options.debug {
            Some(debug) => debug.colors(frame, sampled, batch)?,
            None => {
                let surfaces = sampled.surfaces(frame, batch, seed)?;
                super::light::light(frame, sampled, batch, &surfaces)?
            }
        };
        for (&p, color) in batch.pixel.iter().zip(colors) {
            let pixel = &mut tile[p as usize];
            *pixel = over(*pixel, color);
        }
    }
    Ok(())
}
