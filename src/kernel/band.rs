//! Weighted sums of neighbours along the axes of a picture: one output pixel a row of a banded matrix.
//!
//! Sums run upwards over the taps, in doubles, columns of the picture first (down), then rows (across).

use super::remap::{Edge, Real, Scaled, within};
use super::{Isa, compiled_for};
use crate::error::{Error, Result};

/// Numbers that are summed at a time.
const LANES: usize = 16;

/// A banded matrix along an axis of `size` pixels that goes on beyond its ends.
#[derive(Clone, Debug)]
pub struct Band<'a> {
    first: &'a [i64],
    weights: &'a [f64],
    taps: usize,
    edge: Edge,
    size: usize,
}

impl<'a> Band<'a> {
    /// Row j of the matrix has `weights[j * taps..(j + 1) * taps]` at pixels `first[j]` and on.
    ///
    /// # Errors
    /// [`Error::Value`] for lengths that do not fit, or taps further from the axis than it is long plus 2^20.
    pub fn new(first: &'a [i64], weights: &'a [f64], edge: Edge, size: usize) -> Result<Self> {
        let taps = weights.len().checked_div(first.len()).unwrap_or(0);
        let far = size as i64 + (1 << 20);
        let fits = taps > 0 && taps as i64 <= far && weights.len() == taps * first.len() && size > 0;
        if !fits || first.iter().any(|&at| at < -far || at > far) {
            let got = format!("{} rows, {} weights, {size} pixels", first.len(), weights.len());
            return Err(Error::value("band", got, "the same number of weights a row, near the axis"));
        }
        Ok(Self { first, weights, taps, edge, size })
    }

    /// Pixels of the output.
    pub fn rows(&self) -> usize {
        self.first.len()
    }

    fn row(&self, j: usize) -> (i64, &'a [f64]) {
        (self.first[j], &self.weights[j * self.taps..(j + 1) * self.taps])
    }

    /// How many pixels before the axis and behind it are read.
    fn margins(&self) -> [usize; 2] {
        let (low, high) = self.first.iter().fold((0, 0), |(low, high), &at| (at.min(low), at.max(high)));
        let end = high + self.taps as i64 - self.size as i64;
        [-low as usize, end.max(0) as usize]
    }
}

/// A picture to be resampled along both axes: `height` packed rows of `width * channels` elements.
#[derive(Clone, Debug)]
pub struct Resample<'a, S> {
    /// The picture.
    pub data: &'a [S],
    /// Numbers a pixel.
    pub channels: usize,
    /// Down the columns.
    pub down: Band<'a>,
    /// Along the rows; `None` leaves them as they are.
    pub across: Option<Band<'a>>,
    /// Pixels of a row.
    pub width: usize,
    /// What a unit of an integer stands for.
    pub factor: f64,
    /// The number beyond a [`Edge::Border`].
    pub border: f64,
    /// The least and the greatest result.
    pub limits: [f64; 2],
}

impl<S: Scaled<f64>> Resample<'_, S> {
    /// Checks that the parts fit together.
    ///
    /// # Errors
    /// [`Error::Value`] when they do not.
    pub fn check(&self) -> Result<()> {
        let row = self.width.checked_mul(self.channels);
        let whole = row.and_then(|row| row.checked_mul(self.down.size));
        let across = self.across.as_ref().is_none_or(|band| band.size == self.width);
        if whole == Some(self.data.len()) && across && self.channels > 0 {
            return Ok(());
        }
        let got = format!("{} elements for {} x {}", self.data.len(), self.down.size, self.width);
        Err(Error::value("image", got, "bands of its own height and width"))
    }

    /// Multiplications of an output row, about.
    pub fn row_cost(&self) -> usize {
        let across = self.across.as_ref().map_or(0, |band| band.taps * band.rows());
        (self.down.taps * self.width + across) * self.channels
    }

    /// Numbers of an output row.
    pub fn out_row(&self) -> usize {
        self.channels * self.across.as_ref().map_or(self.width, Band::rows)
    }

    /// Output rows from `first` on, packed; call [`Resample::check`] before.
    pub fn rows<O: Real>(&self, isa: Isa, first: usize, out: &mut [O]) {
        compiled_for(isa, || {
            let margins = self.across.as_ref().map_or([0; 2], Band::margins);
            let start = margins[0] * self.channels;
            let row = self.width * self.channels;
            // Loads of a whole vector may reach beyond the last pixel.
            let mut line = vec![0.0; start + row + margins[1] * self.channels + LANES];
            for (j, out) in out.chunks_exact_mut(self.out_row().max(1)).enumerate() {
                self.sum_down(first + j, &mut line[start..start + row]);
                match &self.across {
                    None => {
                        for (o, &v) in out.iter_mut().zip(&line) {
                            *o = O::of(within(v, self.limits));
                        }
                    }
                    Some(band) => {
                        self.extend(band.edge, margins, &mut line);
                        match self.channels {
                            1 => across::<1, 1, O>(band, margins[0], &line, self.limits, out),
                            2 => across::<2, 2, O>(band, margins[0], &line, self.limits, out),
                            3 => across::<3, 4, O>(band, margins[0], &line, self.limits, out),
                            4 => across::<4, 4, O>(band, margins[0], &line, self.limits, out),
                            channels => across_any(band, margins[0], channels, &line, self.limits, out),
                        }
                    }
                }
            }
        });
    }

    /// The weighted sum of the rows of the picture that row `j` of the band names.
    #[inline(always)]
    fn sum_down(&self, j: usize, line: &mut [f64]) {
        let (top, weights) = self.down.row(j);
        let source = |k: usize| {
            let row = self.down.edge.index(top + k as i64, self.down.size as i64)?;
            Some(&self.data[row * line_len(self)..(row + 1) * line_len(self)])
        };
        let taps: Vec<(f64, Option<&[S]>)> =
            weights.iter().enumerate().map(|(k, &w)| (w, source(k))).collect();
        let whole = line.len() / LANES * LANES;
        for at in (0..whole).step_by(LANES) {
            let mut sums = [0.0; LANES];
            for &(weight, row) in &taps {
                match row.and_then(|row| row[at..].first_chunk::<LANES>()) {
                    Some(part) => {
                        for (sum, v) in sums.iter_mut().zip(part) {
                            *sum += weight * v.scaled(self.factor);
                        }
                    }
                    None => sums.iter_mut().for_each(|sum| *sum += weight * self.border),
                }
            }
            line[at..at + LANES].copy_from_slice(&sums);
        }
        for (at, value) in line.iter_mut().enumerate().skip(whole) {
            *value = taps.iter().fold(0.0, |sum, &(weight, row)| {
                sum + weight * row.map_or(self.border, |row| row[at].scaled(self.factor))
            });
        }
    }

    /// Fills the margins of a line by the rule of the edge.
    fn extend(&self, edge: Edge, margins: [usize; 2], line: &mut [f64]) {
        let (channels, width) = (self.channels, self.width as i64);
        let before = -(margins[0] as i64)..0;
        let behind = width..width + margins[1] as i64;
        for at in before.chain(behind) {
            let to = (at + margins[0] as i64) as usize * channels;
            match edge.index(at, width) {
                Some(from) => {
                    let from = (from + margins[0]) * channels;
                    line.copy_within(from..from + channels, to);
                }
                None => line[to..to + channels].fill(self.border),
            }
        }
    }
}

fn line_len<S>(resample: &Resample<'_, S>) -> usize {
    resample.width * resample.channels
}

/// Sums along a line of `C` channels, `L` numbers at a time.
#[inline(always)]
fn across<const C: usize, const L: usize, O: Real>(
    band: &Band<'_>,
    margin: usize,
    line: &[f64],
    limits: [f64; 2],
    out: &mut [O],
) {
    for (j, out) in out.chunks_exact_mut(C).enumerate() {
        let (first, weights) = band.row(j);
        let start = (first + margin as i64) as usize * C;
        let mut sums = [0.0; L];
        let part = &line[start..start + (weights.len() - 1) * C + L];
        for (k, &weight) in weights.iter().enumerate() {
            for (sum, v) in sums.iter_mut().zip(&part[k * C..k * C + L]) {
                *sum += weight * v;
            }
        }
        for (o, sum) in out.iter_mut().zip(sums) {
            *o = O::of(within(sum, limits));
        }
    }
}

#[inline(always)]
fn across_any<O: Real>(
    band: &Band<'_>,
    margin: usize,
    channels: usize,
    line: &[f64],
    limits: [f64; 2],
    out: &mut [O],
) {
    for (j, out) in out.chunks_exact_mut(channels).enumerate() {
        let (first, weights) = band.row(j);
        let start = (first + margin as i64) as usize * channels;
        for (c, o) in out.iter_mut().enumerate() {
            let sum =
                weights.iter().enumerate().fold(0.0, |sum, (k, w)| sum + w * line[start + k * channels + c]);
            *o = O::of(within(sum, limits));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_are_matrices() {
        let (w, h) = (23i64, 9i64);
        let first_down = [-3i64, 0, 4, 8];
        let first_across: Vec<i64> = (0..17).map(|j| j * 2 - 5).collect();
        let weight = |j: usize, k: usize| ((j * 5 + k * 3) % 7) as f64 / 8.0 - 0.25;
        let down: Vec<f64> = (0..4 * 4).map(|i| weight(i / 4, i % 4)).collect();
        let across: Vec<f64> = (0..17 * 3).map(|i| weight(i / 3, i % 3)).collect();
        for edge in [Edge::Border, Edge::Clamp, Edge::Repeat, Edge::Mirror, Edge::Mirror101] {
            for channels in 1..=5usize {
                let data: Vec<u8> =
                    (0..w as usize * h as usize * channels).map(|i| (i * 73 % 251) as u8).collect();
                let job = Resample {
                    data: &data,
                    channels,
                    down: Band::new(&first_down, &down, edge, h as usize).unwrap(),
                    across: Some(Band::new(&first_across, &across, edge, w as usize).unwrap()),
                    width: w as usize,
                    factor: 0.5,
                    border: 10.0,
                    limits: [-1e3, 60.0],
                };
                job.check().unwrap();
                // Multiples of 1/64 below 2^13: every order of additions gives the same.
                let column = |j: usize, x: i64, c: usize| -> f64 {
                    let tap = |k: usize| match edge.index(first_down[j] + k as i64, h) {
                        Some(y) => f64::from(data[(y * w as usize + x as usize) * channels + c]) * 0.5,
                        None => 10.0,
                    };
                    (0..4).map(|k| down[j * 4 + k] * tap(k)).sum()
                };
                for isa in Isa::available() {
                    let mut out = vec![0f64; 4 * 17 * channels];
                    job.rows(isa, 0, &mut out);
                    for (i, &got) in out.iter().enumerate() {
                        let (j, at, c) = (i / channels / 17, i / channels % 17, i % channels);
                        let tap = |k: usize| match edge.index(first_across[at] + k as i64, w) {
                            Some(x) => column(j, x as i64, c),
                            None => 10.0,
                        };
                        let want: f64 = (0..3).map(|k| across[at * 3 + k] * tap(k)).sum();
                        assert_eq!(got, want.min(60.0), "{isa:?} {edge:?} {channels} channels, {i}");
                    }
                }
            }
        }
    }

    #[test]
    fn bands_that_do_not_fit_are_refused() {
        assert!(Band::new(&[0], &[], Edge::Clamp, 3).is_err());
        assert!(Band::new(&[0, 1], &[1.0; 3], Edge::Clamp, 3).is_err());
        assert!(Band::new(&[1 << 40], &[1.0], Edge::Clamp, 3).is_err());
        assert!(Band::new(&[0], &[1.0], Edge::Clamp, 0).is_err());
        let down = Band::new(&[0], &[1.0], Edge::Clamp, 3).unwrap();
        let job = Resample {
            data: &[0u8; 5],
            channels: 1,
            down,
            across: None,
            width: 2,
            factor: 1.0,
            border: 0.0,
            limits: [0.0, 1.0],
        };
        assert!(job.check().is_err());
    }
}
