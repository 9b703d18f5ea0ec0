//! What faces cover in texture space, and which of them lie on each other.

use super::check_grid;
use super::cover::Chart;
use crate::error::{Error, Result};
use crate::mesh::check_faces;
use crate::par;
use std::collections::BTreeSet;

/// The faces of a mesh on the texels of a map.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    /// Texels that some face touches.
    pub touched: usize,
    /// Texels with a sample point that lies in several faces.
    pub overlapping: usize,
    /// The faces that share a sample point, in ascending order.
    pub shared: Vec<u32>,
}

/// Looks at `samples` x `samples` points of each texel of a map of `size` = (width, height).
///
/// # Errors
/// [`Error::Value`] when a face names a vertex that is not there, or a number is out of its range.
///
/// ```
/// let uv = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
/// let found = multum::bake::layout(&uv, &[[0, 1, 2], [0, 2, 3], [0, 1, 3]], [4, 4], 2)?;
/// assert_eq!((found.touched, found.overlapping, found.shared), (16, 10, vec![0, 1, 2]));
/// # Ok::<(), multum::Error>(())
/// ```
pub fn layout(uv: &[[f32; 2]], faces: &[[u32; 3]], size: [usize; 2], samples: usize) -> Result<Layout> {
    check_faces(faces, uv.len())?;
    check_grid(size, samples)?;
    let chart = Chart::new(uv, faces, size, samples)?;
    let [tiles_x, tiles_y] = chart.tiles();
    let mut rows = vec![(Layout::default(), BTreeSet::new()); tiles_y];
    par::for_each(rows.iter_mut(), |y, (row, shared)| {
        for pieces in (0..tiles_x).filter_map(|x| chart.pieces([x, y])) {
            row.touched += pieces.iter().filter(|piece| !piece.samples.is_empty()).count();
            row.overlapping += pieces.iter().filter(|piece| piece.overlapping).count();
            shared.extend(pieces.iter().flat_map(|piece| &piece.shared).copied());
        }
        Ok::<(), Error>(())
    })?;
    let mut all = BTreeSet::new();
    let mut whole = Layout::default();
    for (row, shared) in rows {
        whole.touched += row.touched;
        whole.overlapping += row.overlapping;
        all.extend(shared);
    }
    whole.shared = all.into_iter().collect();
    Ok(whole)
}
