//! Where a map minifies: where neighbouring pixels of the output are read more than a pixel apart.

use super::remap::Map;
use crate::error::{Error, Result};
use crate::kernel::{Isa, Work, compiled_for};
use crate::par;

/// Pixels of a row that are looked at together.
pub(crate) const SEGMENT: usize = 64;

/// Pixels of a band, about: the unit of work of a thread. Smaller maps stay on the calling thread.
const BAND: usize = 1 << 15;

/// What rounding may add to differences of positions in singles, and of those in 1/32 pixel.
const ROUNDING: f64 = 1e-3;
const FIXED_ROUNDING: f64 = 1.0 / 16.0;

impl Map<'_> {
    /// Whether neighbouring pixels of an output of this size are read more than a pixel apart anywhere: whether
    /// the larger singular value of the difference quotient, or of a matrix's derivative, exceeds 1 by more than a
    /// thousandth, which is more than the rounding of singles, or by a sixteenth, which is as much as that of fixed-point
    /// maps. Differences that are not finite do not count.
    ///
    /// # Errors
    /// [`Error::Value`] when the map has another size.
    pub fn minifies(&self, width: usize, height: usize) -> Result<bool> {
        Ok(!self.minified(width, height)?.is_empty())
    }

    /// Which segments of each row of an output of this size minify, by the rule of [`Map::minifies`]:
    /// `width.div_ceil(64)` flags a row, or no flags at all where there is none to set.
    ///
    /// # Errors
    /// As [`Map::minifies`].
    pub(crate) fn minified(&self, width: usize, height: usize) -> Result<Vec<bool>> {
        let pixels = width.checked_mul(height);
        if width == 0 || !pixels.is_some_and(|pixels| self.fits(pixels)) {
            return Err(Error::value("map", self.described(), format!("{width} x {height} positions")));
        }
        if let Self::Matrix(m) = self
            && m[6] == 0.0
            && m[7] == 0.0
        {
            let w = m[8];
            let all = exceeds(ROUNDING, [m[0] / w, m[3] / w], [m[1] / w, m[4] / w]);
            return Ok(if all { vec![true; width.div_ceil(SEGMENT) * height] } else { Vec::new() });
        }
        let segments = width.div_ceil(SEGMENT);
        let mut flags = crate::image::zeros::<bool>("map", segments * height)?;
        let isa = Isa::current();
        let rows = (BAND / width).max(1);
        let band = |i: usize, flags: &mut [bool]| {
            for (row, flags) in (i * rows..).zip(flags.chunks_exact_mut(segments)) {
                // Without a row below, the step down is taken as none.
                let below = if row + 1 < height { row + 1 } else { row };
                compiled_for(isa, FlagRow { map: self, width, rows: [row, below], flags });
            }
            Ok(())
        };
        par::for_each(flags.chunks_mut(rows * segments), band)?;
        Ok(if flags.contains(&true) { flags } else { Vec::new() })
    }

    /// Sets the flags of one row, from its positions and those of the row below.
    #[inline(always)]
    fn flag(&self, width: usize, rows: [usize; 2], flags: &mut [bool]) {
        match *self {
            Self::Single(x, y) => {
                let [x, y] = [x, y].map(|p| rows.map(|row| &p[row * width..][..width]));
                flag_row(width, flags, ROUNDING, |k, i| [f64::from(x[k][i]), f64::from(y[k][i])]);
            }
            Self::Double(x, y) => {
                let [x, y] = [x, y].map(|p| rows.map(|row| &p[row * width..][..width]));
                flag_row(width, flags, ROUNDING, |k, i| [x[k][i], y[k][i]]);
            }
            Self::SinglePairs(p) => {
                let p = rows.map(|row| &p.as_chunks::<2>().0[row * width..][..width]);
                flag_row(width, flags, ROUNDING, |k, i| p[k][i].map(f64::from));
            }
            Self::DoublePairs(p) => {
                let p = rows.map(|row| &p.as_chunks::<2>().0[row * width..][..width]);
                flag_row(width, flags, ROUNDING, |k, i| p[k][i]);
            }
            Self::Fixed(p, codes) => {
                let p = rows.map(|row| &p.as_chunks::<2>().0[row * width..][..width]);
                let codes = codes.map(|codes| rows.map(|row| &codes[row * width..][..width]));
                flag_row(width, flags, FIXED_ROUNDING, |k, i| {
                    let code = codes.map_or(0, |codes| codes[k][i]);
                    let [x, y] = p[k][i].map(f64::from);
                    [x + f64::from(code & 31) / 32.0, y + f64::from((code >> 5) & 31) / 32.0]
                });
            }
            Self::Matrix(m) => {
                // d(u/w)/dx = (u' w - u w')/w^2; both numerators are free of the axis that they are derived by.
                let y = rows[0] as f64;
                let across =
                    [0, 3].map(|k| (m[k] * m[7] - m[k + 1] * m[6]) * y + (m[k] * m[8] - m[k + 2] * m[6]));
                let down = [0, 3].map(|k| (m[k + 1] * m[6] - m[k] * m[7], m[k + 1] * m[8] - m[k + 2] * m[7]));
                let w0 = m[7] * y + m[8];
                for (segment, flag) in flags.iter_mut().enumerate() {
                    let start = segment * SEGMENT;
                    let mut found = false;
                    // Whole numbers of 32 bits become doubles in one step.
                    for i in start as i32..width.min(start + SEGMENT) as i32 {
                        let x = f64::from(i);
                        let w = m[6] * x + w0;
                        let r = 1.0 / (w * w);
                        let across = [across[0] * r, across[1] * r];
                        let down = [(down[0].0 * x + down[0].1) * r, (down[1].0 * x + down[1].1) * r];
                        found |= exceeds(ROUNDING, across, down);
                    }
                    *flag = found;
                }
            }
        }
    }
}

/// The flags of one row, to be compiled for an instruction set.
struct FlagRow<'a, 'm> {
    map: &'a Map<'m>,
    width: usize,
    rows: [usize; 2],
    flags: &'a mut [bool],
}

impl Work for FlagRow<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        self.map.flag(self.width, self.rows, self.flags);
    }
}

/// Sets the flag of every segment of a row of which a pixel is read more than a pixel from its neighbour on the right or
/// below; `at(k, i)` is the position of pixel `i`, in the next row where `k` is 1.
#[inline(always)]
fn flag_row(width: usize, flags: &mut [bool], rounding: f64, at: impl Fn(usize, usize) -> [f64; 2]) {
    let apart = |p: [f64; 2], q: [f64; 2]| [q[0] - p[0], q[1] - p[1]];
    if width == 1 {
        flags[0] = exceeds(rounding, [0.0; 2], apart(at(0, 0), at(1, 0)));
        return;
    }
    for (segment, flag) in flags.iter_mut().enumerate() {
        let start = segment * SEGMENT;
        let mut found = false;
        // No early exit: it would keep the loop from being done in vectors.
        for i in start..(width - 1).min(start + SEGMENT) {
            let here = at(0, i);
            found |= exceeds(rounding, apart(here, at(0, i + 1)), apart(here, at(1, i)));
        }
        *flag = found;
    }
}

/// Whether the larger singular value of the matrix with these columns exceeds 1 by more than `rounding`.
#[inline(always)]
fn exceeds(rounding: f64, a: [f64; 2], b: [f64; 2]) -> bool {
    // sigma1 <= s exactly when s^2 - J^T J has no negative eigenvalue: neither trace nor determinant below 0.
    let s2 = (1.0 + rounding) * (1.0 + rounding);
    let trace = a[0] * a[0] + a[1] * a[1] + b[0] * b[0] + b[1] * b[1];
    let det = a[0] * b[1] - a[1] * b[0];
    (trace > 2.0 * s2) | (s2 * s2 - s2 * trace + det * det < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn minification_is_seen() {
        let identity = [1.0, 0.0, 0.3, 0.0, 1.0, 0.7, 0.0, 0.0, 1.0];
        let (c, s) = (0.6, 0.8);
        for (m, want) in [
            (identity, false),
            ([c, -s, 5.0, s, c, 1.0, 0.0, 0.0, 1.0], false),
            ([1.01 * c, -s, 5.0, s, c, 1.0, 0.0, 0.0, 1.0], true),
            ([1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], true),
            ([0.9, 0.0, 0.0, 0.0, 0.9, 0.0, 1e-4, 0.0, 1.0], false),
            ([0.9, 0.0, 0.0, 0.0, 0.9, 0.0, -0.01, 0.0, 1.0], true),
        ] {
            assert_eq!(Map::Matrix(&m).minifies(40, 30).unwrap(), want, "{m:?}");
            let at = |i: usize, r: usize| {
                let (x, y) = ((i % 40) as f64, (i / 40) as f64);
                (m[r] * x + m[r + 1] * y + m[r + 2]) / (m[6] * x + m[7] * y + m[8])
            };
            let x: Vec<f32> = (0..1200).map(|i| at(i, 0) as f32).collect();
            let y: Vec<f32> = (0..1200).map(|i| at(i, 3) as f32).collect();
            assert_eq!(Map::Single(&x, &y).minifies(40, 30).unwrap(), want, "{m:?}");
        }
        assert!(!Map::Double(&[5.0], &[f64::NAN]).minifies(1, 1).unwrap());
        assert!(!Map::Double(&[5.0, f64::NAN], &[1.0, 2.0]).minifies(2, 1).unwrap());
        assert!(Map::Double(&[5.0, 7.0], &[1.0, 1.0]).minifies(1, 2).unwrap());
    }

    #[test]
    fn flags_tell_where_and_do_not_depend_on_threads_or_instructions() {
        // Twice as far apart from column 100 on, and below row 200.
        let (w, h) = (300, 250);
        let bent = |i: usize, from: usize| (i + i.saturating_sub(from)) as f64;
        let xy: Vec<f64> = (0..w * h).flat_map(|i| [bent(i % w, 100), bent(i / w, 200)]).collect();
        let map = Map::DoublePairs(&xy);
        let flags = map.minified(w, h).unwrap();
        for (i, &flag) in flags.iter().enumerate() {
            let (segment, row) = (i % 5, i / 5);
            // The last row has no step down.
            assert_eq!(flag, segment >= 1 || (200..h - 1).contains(&row), "{segment} {row}");
        }
        for isa in Isa::available() {
            for threads in [1, 3] {
                let run = || crate::kernel::with_isa(isa, || map.minified(w, h).unwrap()).unwrap();
                assert!(par::with_threads(Some(threads), run) == flags);
            }
        }
        assert!(map.minified(w, h + 1).is_err() && map.minified(0, 0).is_err());
    }
}
