//! One axis of the plane: which cell a position lies in, and which texels the cell reads.
//!
//! Positions are in texels from the texture's outer edge: texel `i` covers `[i, i + 1]`. Cell `k` is the
//! interval on which the reconstruction is one polynomial: the texel itself for nearest, from the centre of
//! texel `k` to the next for bilinear and bicubic. Where the texture does not repeat, everything beyond the
//! last texel that still changes is one cell without an outer end, on which the polynomial is constant.

use super::options::{Reconstruction, Wrap};

/// An axis of `n` texels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    wrap: Wrap,
    n: i64,
    kind: Reconstruction,
    ends: Option<(i64, i64)>,
}

impl Axis {
    pub(super) fn new(wrap: Wrap, n: i64, kind: Reconstruction) -> Self {
        // Texels at and beyond these indices are alike.
        let alike = match wrap {
            Wrap::Clamp => Some((0, n - 1)),
            Wrap::MirrorOnce => Some((-n, n - 1)),
            Wrap::Border | Wrap::Extend => Some((-1, n)),
            Wrap::Repeat | Wrap::Mirror | Wrap::Mirror101 => None,
        };
        let (first, last) = kind.reach();
        Self { wrap, n, kind, ends: alike.map(|(low, high)| (low - last, high - first)) }
    }

    /// Number of texels, without the extra ones of `Extend`.
    pub(super) fn len(&self) -> i64 {
        self.n
    }

    /// Texels after which the axis repeats.
    pub(super) fn period(&self) -> Option<i64> {
        match self.wrap {
            Wrap::Repeat => Some(self.n),
            Wrap::Mirror => Some(2 * self.n),
            Wrap::Mirror101 => Some((2 * (self.n - 1)).max(1)),
            _ => None,
        }
    }

    /// Where texel `i` is stored; `None` for the border colour.
    pub(super) fn stored(&self, i: i64) -> Option<usize> {
        let n = self.n;
        let index = match self.wrap {
            Wrap::Clamp => i.max(0).min(n - 1),
            Wrap::Repeat => i.rem_euclid(n),
            Wrap::Mirror if i.div_euclid(n) % 2 == 0 => i.rem_euclid(n),
            Wrap::Mirror => n - 1 - i.rem_euclid(n),
            Wrap::MirrorOnce if i >= 0 => i.min(n - 1),
            Wrap::MirrorOnce => (-i - 1).min(n - 1),
            Wrap::Mirror101 if n == 1 => 0,
            Wrap::Mirror101 => {
                let last = n - 1;
                (i.rem_euclid(2 * last) - last).abs().abs_diff(last) as i64
            }
            Wrap::Border if i < 0 || i >= n => return None,
            Wrap::Border => i,
            Wrap::Extend => i.max(-1).min(n) + 1,
        };
        Some(index as usize)
    }

    /// The cell that holds `x`.
    pub(super) fn cell(&self, x: f64) -> i64 {
        let k = (x - self.kind.start()).floor() as i64;
        self.ends.map_or(k, |(low, high)| k.max(low).min(high))
    }

    /// Where cell `k` begins and ends.
    pub(super) fn edges(&self, k: i64) -> (f64, f64) {
        let from = k as f64 + self.kind.start();
        match self.ends {
            Some((low, high)) => (
                if k <= low { f64::NEG_INFINITY } else { from },
                if k >= high { f64::INFINITY } else { from + 1.0 },
            ),
            None => (from, from + 1.0),
        }
    }

    /// The cells from `from` to `to` that have both ends, as a half-open range.
    pub(super) fn whole_cells(&self, from: f64, to: f64) -> (i64, i64) {
        let start = self.kind.start();
        let (first, end) = ((from - start).ceil() as i64, (to - start).floor() as i64);
        self.ends.map_or((first, end), |(low, high)| (first.max(low + 1), end.min(high)))
    }

    /// Weights of the texels that cell `k` reads, at `x`. In a cell without an end they are constant in
    /// effect, so the share may be limited there.
    pub(super) fn weights(&self, k: i64, x: f64) -> [f64; 4] {
        self.kind.weights((x - self.kind.start() - k as f64).clamp(0.0, 1.0))
    }

    /// Where the texels that cell `k` reads are stored.
    pub(super) fn taps(&self, k: i64) -> impl Iterator<Item = Option<usize>> + '_ {
        let (first, last) = self.kind.reach();
        (k + first..=k + last).map(|i| self.stored(i))
    }

    /// Largest whole number of periods that is not above `x`, in texels.
    pub(super) fn periods_below(&self, x: f64) -> f64 {
        match self.period() {
            Some(period) => {
                let period = period as f64;
                x - x.rem_euclid(period)
            }
            None => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROWS: [(Wrap, &str); 7] = [
        (Wrap::Clamp, "aaaaaaaaabcddddddddd"),
        (Wrap::Repeat, "abcdabcdabcdabcdabcd"),
        (Wrap::Mirror, "abcddcbaabcddcbaabcd"),
        (Wrap::MirrorOnce, "dddddcbaabcddddddddd"),
        (Wrap::Mirror101, "cbabcdcbabcdcbabcdcb"),
        (Wrap::Border, "########abcd########"),
        (Wrap::Extend, "<<<<<<<<abcd>>>>>>>>"),
    ];

    #[test]
    fn texels_follow_the_written_rows() {
        for (wrap, row) in ROWS {
            let axis = Axis::new(wrap, 4, Reconstruction::Bilinear);
            let letters = if wrap == Wrap::Extend { "<abcd>" } else { "abcd" };
            for (place, expected) in row.chars().enumerate() {
                let i = place as i64 - 8;
                let got = axis.stored(i).map_or('#', |k| letters.as_bytes()[k] as char);
                assert_eq!(got, expected, "{wrap:?} {i}");
            }
        }
    }

    #[test]
    fn cells_tile_the_axis_and_end_cells_are_constant() {
        for (wrap, _) in ROWS {
            for kind in [Reconstruction::Nearest, Reconstruction::Bilinear, Reconstruction::Bicubic] {
                for n in 1..6 {
                    let axis = Axis::new(wrap, n, kind);
                    for step in -200..200 {
                        let x = f64::from(step) / 8.0;
                        let k = axis.cell(x);
                        let (from, to) = axis.edges(k);
                        assert!(from <= x && x < to, "{wrap:?} {kind:?} {n} {x}");
                        if from.is_infinite() || to.is_infinite() {
                            let taps: Vec<_> = axis.taps(k).collect();
                            assert!(taps.iter().all(|t| *t == taps[0]), "{wrap:?} {kind:?} {n} {x}");
                        } else {
                            assert_eq!(axis.cell(to), k + 1);
                        }
                    }
                }
            }
        }
    }
}
