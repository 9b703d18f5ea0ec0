//! Nearest and linear interpolation in the arithmetic of scikit-image and SciPy, of which every bit counts where a
//! program changes only an import:
//!
//! ```text
//! upper = (1 - fx) a + fx b        a b   upper row
//! lower = (1 - fx) c + fx d        c d   lower row
//! (1 - fy) upper + fy lower, in doubles
//! ```
//!
//! A position on a column reads that column alone, and one on a row that row alone: what lies beside it, NaN or the
//! border, does not count. Nearest is `floor(x + 1/2)`, after a position beyond the picture has been brought inside.

use super::{Edge, NOWHERE, Real, Source, Split};
use crate::kernel::Isa;

#[cfg(target_arch = "x86_64")]
mod avx2;

/// An element that becomes a number by a factor, which only integers use.
pub trait Scaled<H: Real>: Copy + Send + Sync {
    /// The number.
    fn scaled(self, factor: H) -> H;
    /// Does a run of three or four channels with vectors of `isa`; `false` where there is no such kernel.
    fn vector<O: Real>(isa: Isa, lerp: &Lerp<'_, Self, H, O>, split: &Split<'_, H>, out: &mut [O]) -> bool;
}

macro_rules! scaled {
    ($($from:ty => $to:ty, $kernel:ident, |$v:ident, $factor:ident| $body:expr;)*) => {
        $(impl Scaled<$to> for $from {
            #[inline(always)]
            fn scaled(self, $factor: $to) -> $to {
                let $v = self;
                $body
            }

            #[cfg_attr(not(target_arch = "x86_64"), expect(unused_variables, reason = "no vectors"))]
            fn vector<O: Real>(
                isa: Isa,
                lerp: &Lerp<'_, Self, $to, O>,
                split: &Split<'_, $to>,
                out: &mut [O],
            ) -> bool {
                match isa {
                    #[cfg(target_arch = "x86_64")]
                    Isa::Avx2 | Isa::Avx512 if isa.is_supported() => {
                        // SAFETY: the machine has AVX2.
                        unsafe { avx2::$kernel(lerp, split, out) };
                        true
                    }
                    _ => false,
                }
            }
        })*
    };
}
scaled! {
    u8 => f64, wide, |v, factor| f64::from(v) * factor;
    u16 => f64, wide, |v, factor| f64::from(v) * factor;
    f64 => f64, wide, |v, _factor| v;
    f32 => f64, wide, |v, _factor| f64::from(v);
    f32 => f32, single, |v, _factor| v;
}

/// Linear interpolation of a picture of `S`, along rows in `H`, with results in `O`.
#[derive(Clone, Copy, Debug)]
pub struct Lerp<'a, S, H, O> {
    /// What is read.
    pub source: Source<'a, S>,
    /// Beyond the ends of x and y.
    pub edges: [Edge; 2],
    /// What a unit of an integer stands for.
    pub factor: H,
    /// The number beyond a [`Edge::Border`].
    pub border: H,
    /// The result at a position that is not finite.
    pub nowhere: O,
    /// The least and the greatest result.
    pub limits: [f64; 2],
}

impl<S: Scaled<H>, H: Real, O: Real> Lerp<'_, S, H, O> {
    /// Fills a run of packed pixels; lengths that do not fit end the run early.
    pub fn run(&self, isa: Isa, split: &Split<'_, H>, out: &mut [O]) {
        match self.source.channels {
            3 | 4 if S::vector(isa, self, split, out) => {}
            1 => self.counted::<1, 1>(split, out),
            2 => self.counted::<2, 2>(split, out),
            3 => self.counted::<3, 4>(split, out),
            4 => self.counted::<4, 4>(split, out),
            channels => {
                for i in 0..split.x.len().min(out.len() / channels) {
                    self.beyond(split, i, &mut out[i * channels..(i + 1) * channels]);
                }
            }
        }
    }

    /// `C` channels, which are read and written `L` at a time.
    #[inline(always)]
    fn counted<const C: usize, const L: usize>(&self, split: &Split<'_, H>, out: &mut [O]) {
        let s = &self.source;
        let count =
            split.x.len().min(split.y.len()).min(split.fx.len()).min(split.fy.len()).min(out.len() / C);
        for i in 0..count {
            let (x, y) = (split.x[i] as u32 as usize, split.y[i] as u32 as usize);
            let (fx, fy) = (split.fx[i], split.fy[i]);
            let right = usize::from(fx != H::default());
            let below = usize::from(fy != H::default());
            let at = i * C;
            if x + right < s.width && y + below < s.height && at + L <= out.len() {
                let start = y * s.row_stride + x * C;
                let (right, below) = (right * C, below * s.row_stride);
                if let (Some(a), Some(b), Some(c), Some(d)) = (
                    self.load::<L>(start),
                    self.load::<L>(start + right),
                    self.load::<L>(start + below),
                    self.load::<L>(start + below + right),
                ) {
                    let value: [O; L] = std::array::from_fn(|k| self.blend([a[k], b[k], c[k], d[k]], fx, fy));
                    // The lane beyond the pixel's own is written over by the next pixel.
                    out[at..at + L].copy_from_slice(&value);
                    continue;
                }
            }
            self.beyond(split, i, &mut out[at..at + C]);
        }
    }

    #[inline(always)]
    fn load<const L: usize>(&self, start: usize) -> Option<[H; L]> {
        let part = self.source.data.get(start..start + L)?;
        Some(std::array::from_fn(|k| part[k].scaled(self.factor)))
    }

    /// A pixel with taps beyond the picture, or of unusual size.
    #[inline(never)]
    fn beyond(&self, split: &Split<'_, H>, i: usize, out: &mut [O]) {
        if split.x[i] == NOWHERE {
            out.fill(self.nowhere);
            return;
        }
        let s = &self.source;
        let f = [split.fx[i], split.fy[i]];
        let place = |axis: usize, n: usize| {
            let first = i64::from([split.x, split.y][axis][i]);
            let second = first + i64::from(f[axis] != H::default());
            [first, second].map(|at| self.edges[axis].index(at, n as i64))
        };
        let (columns, rows) = (place(0, s.width), place(1, s.height));
        for (k, o) in out.iter_mut().enumerate() {
            let tap = |row: Option<usize>, column: Option<usize>| match (row, column) {
                (Some(y), Some(x)) => s.data[y * s.row_stride + x * s.channels + k].scaled(self.factor),
                _ => self.border,
            };
            let [a, b] = columns.map(|column| tap(rows[0], column));
            let [c, d] = columns.map(|column| tap(rows[1], column));
            *o = self.blend([a, b, c, d], f[0], f[1]);
        }
    }

    #[inline(always)]
    fn blend(&self, [a, b, c, d]: [H; 4], fx: H, fy: H) -> O {
        let (gx, gy) = (H::of(1.0) - fx, H::of(1.0) - fy);
        let (upper, lower) = (gx * a + fx * b, gx * c + fx * d);
        O::of(within(gy.wide() * upper.wide() + fy.wide() * lower.wide(), self.limits))
    }
}

/// A number drawn into limits; NaN stays.
#[inline(always)]
pub fn within(x: f64, [low, high]: [f64; 2]) -> f64 {
    let x = if x < low { low } else { x };
    if x > high { high } else { x }
}

/// Copies the nearest pixels of a picture of any elements to a run of packed pixels.
///
/// # Panics
/// Never: lengths that do not fit end the run early.
pub fn nearest<T: Copy>(
    source: &Source<'_, T>,
    edges: [Edge; 2],
    border: &[T],
    at: [&[f64]; 2],
    out: &mut [T],
) {
    let channels = source.channels;
    let places = at[0].iter().zip(at[1]);
    for ((&x, &y), out) in places.zip(out.chunks_exact_mut(channels)) {
        let column = nearest_index(x, source.width, edges[0]);
        let row = nearest_index(y, source.height, edges[1]);
        match (row, column) {
            (Some(row), Some(column)) => {
                let start = row * source.row_stride + column * channels;
                out.copy_from_slice(&source.data[start..start + channels]);
            }
            _ => out.copy_from_slice(border),
        }
    }
}

/// Index of the pixel that is nearest to a position, upwards at equal distances.
fn nearest_index(x: f64, size: usize, edge: Edge) -> Option<usize> {
    let n = size as f64;
    let inside = if (0.0..=n - 1.0).contains(&x) {
        x
    } else if !x.is_finite() {
        return None;
    } else {
        folded(x, n, edge)
    };
    edge.index((inside + 0.5).floor() as i64, size as i64)
}

/// A position beyond the picture brought inside, or within a pixel of it, as SciPy does: of two equally near pixels
/// of a reversed copy it is then the other one that is met.
fn folded(x: f64, n: f64, edge: Edge) -> f64 {
    match edge {
        Edge::Mirror => {
            let m = x % (2.0 * n);
            if m >= n {
                2.0 * n - 1.0 - m
            } else if m >= 0.0 {
                m
            } else if m < -n {
                m + 2.0 * n
            } else {
                -m - 1.0
            }
        }
        Edge::Mirror101 if n > 1.0 => {
            let m = x % (2.0 * n - 2.0);
            if m >= n {
                2.0 * n - 2.0 - m
            } else if m <= 1.0 - n {
                m + 2.0 * n - 2.0
            } else {
                m.abs()
            }
        }
        Edge::Mirror101 => 0.0,
        _ => x,
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Buffer, CHUNK, Grid};
    use super::*;

    const EDGES: [Edge; 5] = [Edge::Border, Edge::Clamp, Edge::Repeat, Edge::Mirror, Edge::Mirror101];

    #[test]
    fn every_instruction_set_and_number_of_channels_follows_the_formula() {
        let (w, h) = (7usize, 5usize);
        for channels in 1..=6 {
            let data: Vec<f64> = (0..w * h * channels).map(|i| (i * 7919 % 1013) as f64 / 1013.0).collect();
            let source = Source::new(&data, w, h, channels, w * channels).unwrap();
            let xs: Vec<f64> = (0..CHUNK).map(|i| (i * 37 % 64) as f64 / 5.0 - 3.0).collect();
            let ys: Vec<f64> = (0..CHUNK).map(|i| (i * 11 % 37) as f64 / 4.0 - 2.0).collect();
            for edge in EDGES {
                let lerp = Lerp {
                    source,
                    edges: [edge; 2],
                    factor: 1.0,
                    border: 0.5,
                    nowhere: 0.0,
                    limits: [0.1, 0.9],
                };
                let at = |x: i64, y: i64, k: usize| match (edge.index(x, w as i64), edge.index(y, h as i64)) {
                    (Some(x), Some(y)) => data[(y * w + x) * channels + k],
                    _ => 0.5,
                };
                let want: Vec<f64> = (0..CHUNK * channels)
                    .map(|i| {
                        let (x, y, k) = (xs[i / channels], ys[i / channels], i % channels);
                        let ([x0, y0], [x1, y1]) = ([x.floor(), y.floor()], [x.ceil(), y.ceil()]);
                        let row = |y: f64| {
                            (1.0 - (x - x0)) * at(x0 as i64, y as i64, k)
                                + (x - x0) * at(x1 as i64, y as i64, k)
                        };
                        ((1.0 - (y - y0)) * row(y0) + (y - y0) * row(y1)).clamp(0.1, 0.9)
                    })
                    .collect();
                for isa in Isa::available() {
                    let mut buffer = Buffer::<f64>::new();
                    let split = buffer.split_f64(isa, Grid::Exact, &xs, &ys);
                    let mut got = vec![0f64; CHUNK * channels];
                    lerp.run(isa, &split, &mut got);
                    assert!(
                        got.iter().zip(&want).all(|(a, b)| a.to_bits() == b.to_bits()),
                        "{isa:?} {edge:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn elements_of_every_type_give_equal_bytes() {
        fn check<S: Scaled<H>, H: Real, O: Real>(make: impl Fn(usize) -> S, factor: f64) {
            let bits = |out: &[O]| out.iter().map(|v| v.wide().to_bits()).collect::<Vec<_>>();
            for channels in 1..=5 {
                let data: Vec<S> = (0..9 * 6 * channels).map(&make).collect();
                let source = Source::new(&data, 9, 6, channels, 9 * channels).unwrap();
                let (edges, border, nowhere) = ([Edge::Mirror; 2], H::of(0.5), O::of(0.25));
                let lerp =
                    Lerp { source, edges, factor: H::of(factor), border, nowhere, limits: [0.01, 0.97] };
                let x: Vec<i32> = (0..200).map(|i| i * 7 % 12 - 2).collect();
                let y: Vec<i32> = (0..200).map(|i| i * 5 % 9 - 1).collect();
                let [fx, fy] = [3, 11]
                    .map(|k| (0..200).map(|i| H::of(f64::from(i * k % 17) / 17.0)).collect::<Vec<_>>());
                let split = Split { x: &x, y: &y, fx: &fx, fy: &fy };
                let outs = Isa::available().into_iter().map(|isa| {
                    let mut out = vec![O::default(); 200 * channels];
                    lerp.run(isa, &split, &mut out);
                    bits(&out)
                });
                let outs: Vec<_> = outs.collect();
                assert!(outs.windows(2).all(|pair| pair[0] == pair[1]), "{channels} channels");
            }
        }
        let number = |i: usize| (i * 7919 % 1013) as f64 / 1013.0;
        check::<u8, f64, f64>(|i| (i * 37 % 256) as u8, 1.0 / 255.0);
        check::<u16, f64, f64>(|i| (i * 7919 % 65_536) as u16, 1.0 / 65_535.0);
        check::<f64, f64, f64>(|i| if i % 41 == 5 { f64::NAN } else { number(i) }, 1.0);
        check::<f32, f64, f32>(|i| number(i) as f32, 1.0);
        check::<f32, f32, f32>(|i| if i % 41 == 5 { f32::NAN } else { number(i) as f32 }, 1.0);
    }

    #[test]
    fn a_position_on_a_pixel_reads_it_alone_and_none_reads_nothing() {
        let data = [1.0f32, f32::NAN, 3.0, f32::NAN];
        let source = Source::new(&data, 2, 2, 1, 2).unwrap();
        let lerp = Lerp {
            source,
            edges: [Edge::Border; 2],
            factor: 1.0,
            border: 9.0,
            nowhere: 5.0,
            limits: [0.0, 9.0],
        };
        let mut buffer = Buffer::<f32>::new();
        let split =
            buffer.split_f32(Isa::Scalar, Grid::Exact, &[0.0, 0.0, f32::NAN, -3.0], &[0.0, 0.5, 0.0, 0.0]);
        let mut got = [0.0f32; 4];
        lerp.run(Isa::Scalar, &split, &mut got);
        assert_eq!(got, [1.0, 2.0, 5.0, 9.0]);
    }

    #[test]
    fn the_nearest_of_reversed_copies_is_the_one_that_scipy_meets() {
        let data = [0u8, 1, 2, 3];
        let source = Source::new(&data, 4, 1, 1, 4).unwrap();
        let xs = [-1.5, -0.5, 0.5, 3.5, 4.5, 7.5, -7.5, f64::NAN];
        // scipy.ndimage.map_coordinates(arange(4), [xs], order=0, mode=...)
        for (edge, want) in [
            (Edge::Border, [9, 0, 1, 9, 9, 9, 9, 9]),
            (Edge::Clamp, [0, 0, 1, 3, 3, 3, 0, 9]),
            (Edge::Repeat, [3, 0, 1, 0, 1, 0, 1, 9]),
            (Edge::Mirror, [1, 0, 1, 3, 3, 0, 1, 9]),
            (Edge::Mirror101, [2, 1, 1, 2, 2, 2, 2, 9]),
        ] {
            let mut got = [7; 8];
            nearest(&source, [edge; 2], &[9], [&xs, &[0.0; 8]], &mut got);
            assert_eq!(got, want, "{edge:?}");
        }
    }
}
