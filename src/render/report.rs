//! What resolution a view uses: a texture never seen costs nothing, one seen from afar little.

use super::batch::Places;
use super::surface::Slot;
use crate::lod::LodRule;
use crate::mesh::{ImageSource, Mesh};
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

/// Levels that the histogram tells apart: below 0, and 0 to 15.
const BINS: usize = 17;
/// Cells along a side of the map of what was touched, at most.
const CELLS: usize = 256;

/// How a picture used its textures; only those that it read are listed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// One entry an image, in the order of the mesh.
    pub textures: Vec<TextureUse>,
}

/// How a picture used one image.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureUse {
    /// Index into the mesh's images.
    pub image: usize,
    /// Its name.
    pub name: String,
    /// Width and height in texels.
    pub size: (usize, usize),
    /// Reads of a pixel for a slot.
    pub reads: u64,
    /// Reads by level of detail λ (the footprint's longer side in texels is 2^λ): first those that enlarge
    /// (λ < 0), then 0 ≤ λ < 1, 1 ≤ λ < 2, and so on.
    pub histogram: Vec<u64>,
    /// Share of the texels that lie under the footprint of any pixel, to a cell of 1/256 of a side.
    pub touched: f64,
    /// The smallest of the sizes W/2^k by H/2^k that keeps what 95 in 100 reads can show.
    pub recommended: (usize, usize),
}

#[derive(Debug)]
struct Seen {
    size: (usize, usize),
    bins: [u64; BINS],
    cells: Vec<bool>,
    grid: (usize, usize),
}

/// Gathers from all threads; sums and unions do not depend on their order.
#[derive(Debug, Default)]
pub(super) struct Collector {
    seen: Mutex<BTreeMap<usize, Seen>>,
}

impl Collector {
    /// Notes the reads of a batch.
    pub fn add(&self, slot: &Slot<'_>, places: &Places) {
        let size = (slot.texture.width(), slot.texture.height());
        let grid = (size.0.min(CELLS), size.1.min(CELLS));
        let mut own = Seen { size, bins: [0; BINS], cells: vec![false; grid.0 * grid.1], grid };
        let mut all_touched = false;
        for (i, uv) in places.uv.iter().enumerate() {
            let jacobian = places.jacobian(i);
            let lod = LodRule::Major.lod(jacobian.scaled(size.0 as f64, size.1 as f64));
            let bin = if lod < 0.0 { 0 } else { (lod as usize + 1).min(BINS - 1) };
            own.bins[bin] += 1;
            if all_touched {
                continue;
            }
            // The upright box around the footprint, at least a texel.
            let spans = [0, 1].map(|axis| {
                let (n, cells) = if axis == 0 { (size.0, grid.0) } else { (size.1, grid.1) };
                let half = 0.5 * (jacobian.m[axis][0].abs() + jacobian.m[axis][1].abs()).max(1.0 / n as f64);
                let centre = uv[axis];
                let [lo, hi] = [centre - half, centre + half].map(|x| (x * cells as f64).floor() as i64);
                (lo, hi.min(lo.saturating_add(cells as i64 - 1)))
            });
            let wrap = slot.slot.wrap;
            let whole = |span: (i64, i64), cells: usize| span.1 - span.0 + 1 >= cells as i64;
            if wrap == [crate::wrap::Wrap::Repeat; 2] && whole(spans[0], grid.0) && whole(spans[1], grid.1) {
                own.cells.fill(true);
                all_touched = true;
                continue;
            }
            for y in spans[1].0..=spans[1].1 {
                let Some(y) = wrap[1].index(y, grid.1 as i64) else { continue };
                for x in spans[0].0..=spans[0].1 {
                    let Some(x) = wrap[0].index(x, grid.0 as i64) else { continue };
                    own.cells[y as usize * grid.0 + x as usize] = true;
                }
            }
        }
        let mut all = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        match all.get_mut(&slot.slot.image) {
            None => {
                all.insert(slot.slot.image, own);
            }
            Some(seen) => {
                seen.bins.iter_mut().zip(own.bins).for_each(|(a, b)| *a += b);
                seen.cells.iter_mut().zip(own.cells).for_each(|(a, b)| *a |= b);
            }
        }
    }

    /// The finished report.
    pub fn finish(self, mesh: &Mesh) -> Report {
        let seen = self.seen.into_inner().unwrap_or_else(PoisonError::into_inner);
        let textures = seen.into_iter().map(|(image, seen)| seen.finish(image, mesh)).collect();
        Report { textures }
    }
}

impl Seen {
    fn finish(self, image: usize, mesh: &Mesh) -> TextureUse {
        let name = match mesh.images.get(image) {
            Some(ImageSource::File(path)) => {
                path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default()
            }
            Some(ImageSource::Embedded { name, .. }) if !name.is_empty() => name.clone(),
            _ => format!("image {image}"),
        };
        let reads: u64 = self.bins.iter().sum();
        // Levels below which at most one read in twenty lies; bins 0 and 1 both need the whole texture.
        let mut finer = self.bins[0];
        let mut level = 0;
        while level + 2 < BINS {
            finer += self.bins[level + 1];
            if finer * 20 > reads {
                break;
            }
            level += 1;
        }
        let last = self.bins.iter().rposition(|&n| n > 0).map_or(0, |k| k + 1);
        let touched = self.cells.iter().filter(|c| **c).count() as f64 / (self.grid.0 * self.grid.1) as f64;
        TextureUse {
            image,
            name,
            size: self.size,
            reads,
            histogram: self.bins[..last].to_vec(),
            touched,
            recommended: ((self.size.0 >> level).max(1), (self.size.1 >> level).max(1)),
        }
    }
}
