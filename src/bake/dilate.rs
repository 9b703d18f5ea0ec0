//! Every texel outside the islands gets the value of the nearest one inside.
//!
//! The nearest texel by the distance of centres, exactly: Felzenszwalb and Huttenlocher, "Distance transforms
//! of sampled functions", 2012, which carries the place of the nearest texel along. Of two at the same
//! distance the one further up, then further left. Linear in the number of texels.
//!
//! So a filter that reads beyond an island's edge, on any level of the pyramid, meets values of the island's
//! own edge and no background.

use crate::error::Result;
use crate::par;

const NONE: u32 = u32::MAX;

/// For each texel the index of the nearest covered texel within `reach` texels; `None` where there is none.
pub(super) fn nearest(
    covered: &(impl Fn(usize) -> bool + Sync),
    width: usize,
    height: usize,
    reach: f64,
) -> Result<Vec<Option<usize>>> {
    // The nearest covered row of each column.
    let mut rows = vec![NONE; width * height];
    for y in 0..height {
        for x in 0..width {
            let i = y * width + x;
            rows[i] = if covered(i) {
                y as u32
            } else if y > 0 {
                rows[i - width]
            } else {
                NONE
            };
        }
    }
    for y in (0..height.saturating_sub(1)).rev() {
        for x in 0..width {
            let i = y * width + x;
            let (above, below) = (rows[i], rows[i + width]);
            let gap = |row: u32| if row == NONE { usize::MAX } else { y.abs_diff(row as usize) };
            if gap(below) < gap(above) {
                rows[i] = below;
            }
        }
    }
    let mut found = vec![None; width * height];
    let limit = if reach.is_finite() { reach * reach } else { f64::INFINITY };
    par::for_each(found.chunks_mut(width.max(1)), |y, out| {
        let mut hull: Vec<Parabola> = Vec::with_capacity(width);
        for x in 0..width {
            let row = rows[y * width + x];
            if row != NONE {
                let gap = y.abs_diff(row as usize) as i64;
                push(&mut hull, Parabola { x: x as i64, row, height: gap * gap, from: i64::MIN });
            }
        }
        let mut k = 0;
        for (x, slot) in out.iter_mut().enumerate() {
            while hull.get(k + 1).is_some_and(|next| next.from <= x as i64) {
                k += 1;
            }
            *slot = hull
                .get(k)
                .filter(|p| p.at(x as i64) as f64 <= limit)
                .map(|p| p.row as usize * width + p.x as usize);
        }
        Ok(())
    })?;
    Ok(found)
}

/// Squared distances to one texel along a row: (x - self.x)^2 + height, lowest from `from` on.
struct Parabola {
    x: i64,
    row: u32,
    height: i64,
    from: i64,
}

impl Parabola {
    fn at(&self, x: i64) -> i64 {
        (x - self.x) * (x - self.x) + self.height
    }

    /// Whether the later parabola wins at x: it is lower, or as low and its texel further up.
    fn loses_to(&self, later: &Self, x: i64) -> bool {
        let (own, other) = (self.at(x), later.at(x));
        other < own || other == own && later.row < self.row
    }
}

/// Adds the parabola of the next column to the lower envelope.
fn push(hull: &mut Vec<Parabola>, mut next: Parabola) {
    while let Some(last) = hull.last() {
        // The first whole x where the difference of the two, linear in x, lets the next one win.
        let rise = next.height + next.x * next.x - last.height - last.x * last.x;
        let mut from = rise.div_euclid(2 * (next.x - last.x));
        if !last.loses_to(&next, from) {
            from += 1;
        }
        if from <= last.from {
            hull.pop();
            continue;
        }
        next.from = from;
        break;
    }
    hull.push(next);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_texel_is_the_one_a_search_finds() {
        let mut state = 1u32;
        let mut random = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 16
        };
        for (width, height, share) in [(1, 1, 1), (17, 13, 40), (31, 8, 3), (5, 40, 200), (24, 24, 100_000)] {
            let covered: Vec<bool> = (0..width * height).map(|_| random() % share == 0).collect();
            let found = nearest(&|i| covered[i], width, height, f64::INFINITY).expect("no error");
            for (i, found) in found.into_iter().enumerate() {
                let place = |j: usize| ((j % width) as i64, (j / width) as i64);
                let (x, y) = place(i);
                let distance = |j: usize| (place(j).0 - x).pow(2) + (place(j).1 - y).pow(2);
                let wanted = (0..width * height).filter(|&j| covered[j]).min_by_key(|&j| distance(j));
                assert_eq!(found.map(distance), wanted.map(distance), "{width}x{height} at {x}, {y}");
            }
        }
    }
}
