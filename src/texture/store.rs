//! How levels lie in memory.

use crate::error::Result;
use crate::image::{Element, Pixels, View};
use crate::kernel::plane::Plane;
use crate::pyramid;
use crate::texel::{DType, Texel};
use crate::wrap::Wrap;

/// A stored level: texel (0, 0) stands one row and one texel into `texels`.
#[derive(Debug)]
pub(super) struct Level {
    pub texels: Pixels,
    pub width: usize,
    pub height: usize,
    pub lanes: usize,
}

/// Stored elements a texel for this many channels.
pub(super) fn lanes_of(channels: usize) -> usize {
    if channels <= 2 { channels } else { channels.next_multiple_of(4) }
}

impl Level {
    /// Elements from one row to the next.
    pub fn row(&self) -> usize {
        (self.width + 2) * self.lanes
    }

    /// Index of the first channel of texel (0, 0).
    pub fn origin(&self) -> usize {
        self.row() + self.lanes
    }

    pub fn dtype(&self) -> DType {
        match &self.texels {
            Pixels::U8(_) => DType::U8,
            Pixels::U16(_) => DType::U16,
            Pixels::F16(_) => DType::F16,
            Pixels::F32(_) => DType::F32,
            Pixels::F64(_) => DType::F64,
        }
    }

    /// A level from a picture as it is. Along an axis of [`Wrap::Extend`] the picture brings its apron.
    pub fn copy<T: Element>(view: View<'_, T>, wrap: [Wrap; 2]) -> Self {
        Self::convert(view, wrap, |texel, lanes| lanes[..texel.len()].copy_from_slice(texel))
    }

    /// A level from a picture with `f(channel, code)` in place of each code.
    pub fn store<S: Texel, T: Element>(
        view: View<'_, S>,
        wrap: [Wrap; 2],
        f: impl Fn(usize, f64) -> T,
    ) -> Self {
        Self::convert(view, wrap, |texel, lanes| {
            for (c, (from, to)) in texel.iter().zip(lanes).enumerate() {
                *to = f(c, from.to_f64());
            }
        })
    }

    fn convert<S: Texel, T: Element>(
        view: View<'_, S>,
        wrap: [Wrap; 2],
        put: impl Fn(&[S], &mut [T]),
    ) -> Self {
        let extra = wrap.map(|w| usize::from(w == Wrap::Extend));
        let (width, height) = (view.width() - 2 * extra[0], view.height() - 2 * extra[1]);
        let lanes = lanes_of(view.channels());
        let row = (width + 2) * lanes;
        let mut data = vec![T::default(); row * (height + 2)];
        for y in 0..view.height() {
            let start = (y + 1 - extra[1]) * row + (1 - extra[0]) * lanes;
            let places = data[start..].chunks_exact_mut(lanes);
            for (texel, place) in view.row(y).chunks_exact(view.channels()).zip(places) {
                put(texel, place);
            }
        }
        fill_apron(&mut data, width, height, lanes, wrap);
        Self { texels: T::into_pixels(data), width, height, lanes }
    }

    /// One group of channels of the level, where it is of type `T`.
    pub fn plane<T: Element>(&self, group: usize, wrap: [Wrap; 2]) -> Option<Plane<'_, T>> {
        // The border colour need not be a code, so texels beyond such an edge are never read.
        let bounds = |n: usize, wrap: Wrap| {
            let edge = i32::from(wrap != Wrap::Border);
            (-edge, n as i32 - 1 + edge)
        };
        Some(Plane {
            data: T::of_pixels(&self.texels)?,
            origin: self.origin() + 4 * group,
            row: self.row(),
            lanes: self.lanes,
            // A padded lane costs nothing and makes the texel one load.
            channels: self.lanes.min(4),
            width: self.width as i32,
            height: self.height as i32,
            columns: bounds(self.width, wrap[0]),
            rows: bounds(self.height, wrap[1]),
        })
    }
}

/// One group of channels of a picture without apron.
pub(super) fn borrowed_plane<T: Texel>(view: View<'_, T>, group: usize) -> Plane<'_, T> {
    Plane {
        data: view.data(),
        origin: 4 * group,
        row: view.row_stride(),
        lanes: view.channels(),
        channels: (view.channels() - 4 * group).min(4),
        width: view.width() as i32,
        height: view.height() as i32,
        columns: (0, view.width() as i32 - 1),
        rows: (0, view.height() as i32 - 1),
    }
}

/// Writes the apron around a stored level. Sides of [`Wrap::Extend`] are there already; those of
/// [`Wrap::Border`] are never read.
pub(super) fn fill_apron<T: Texel>(
    data: &mut [T],
    width: usize,
    height: usize,
    lanes: usize,
    wrap: [Wrap; 2],
) {
    let row = (width + 2) * lanes;
    let outside = |axis: usize, i: i64, n: usize| match wrap[axis] {
        Wrap::Extend | Wrap::Border => None,
        w => w.index(i, n as i64).map(|i| i as usize),
    };
    for y in 0..height + 2 {
        for (i, place) in [(-1, 0), (width as i64, width + 1)] {
            if let Some(x) = outside(0, i, width) {
                let from = y * row + (x + 1) * lanes;
                data.copy_within(from..from + lanes, y * row + place * lanes);
            }
        }
    }
    for (i, place) in [(-1, 0), (height as i64, height + 1)] {
        if let Some(y) = outside(1, i, height) {
            let from = (y + 1) * row;
            data.copy_within(from..from + row, place * row);
        }
    }
}

/// Reduces the extra texels of [`Wrap::Extend`]: each strip along its own axis, corners as they are.
pub(super) fn reduce_extra<T: Element>(
    base: &Level,
    texels: &[T],
    sizes: &[(usize, usize)],
    stores: &mut [Vec<T>],
    options: &pyramid::Options,
) -> Result<()> {
    let lanes = base.lanes;
    let strip_options = pyramid::Options { wrap: [Wrap::Clamp; 2], coverage: None, ..*options };
    for axis in 0..2 {
        if options.wrap[axis] != Wrap::Extend {
            continue;
        }
        for far in [false, true] {
            // The strip on the near or far side, as a picture one texel wide or high.
            let (length, start, step) = if axis == 0 {
                let column = if far { base.width + 1 } else { 0 };
                (base.height, base.row() + column * lanes, base.row())
            } else {
                let row = if far { base.height + 1 } else { 0 };
                (base.width, row * base.row() + lanes, lanes)
            };
            let strip: Vec<T> =
                (0..length).flat_map(|i| texels[start + i * step..][..lanes].iter().copied()).collect();
            let count = pyramid::num_levels(length, 1);
            let mut reduced: Vec<Vec<T>> =
                (1..count).map(|l| vec![T::default(); pyramid::level_size(length, l) * lanes]).collect();
            let mut targets: Vec<_> = reduced
                .iter_mut()
                .enumerate()
                .map(|(l, data)| {
                    let n = pyramid::level_size(length, l + 1);
                    pyramid::Target { data, origin: 0, row_stride: n * lanes, width: n, height: 1 }
                })
                .collect();
            pyramid::build_into(
                View::new(&strip, length, 1, lanes, length * lanes)?,
                lanes,
                &mut targets,
                &strip_options,
            )?;
            for (l, (data, &(w, h))) in stores.iter_mut().zip(sizes).enumerate() {
                let source = reduced.get(l.min(reduced.len().saturating_sub(1))).unwrap_or(&strip);
                let row = (w + 2) * lanes;
                let (n, start, step) = if axis == 0 {
                    (h, row + if far { (w + 1) * lanes } else { 0 }, row)
                } else {
                    (w, if far { (h + 1) * row } else { 0 } + lanes, lanes)
                };
                for i in 0..n {
                    data[start + i * step..][..lanes].copy_from_slice(&source[i * lanes..][..lanes]);
                }
            }
        }
    }
    if options.wrap == [Wrap::Extend; 2] {
        for (data, &(w, h)) in stores.iter_mut().zip(sizes) {
            for (x, y) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let from = y * (base.height + 1) * base.row() + x * (base.width + 1) * lanes;
                let to = y * (h + 1) * (w + 2) * lanes + x * (w + 1) * lanes;
                data[to..to + lanes].copy_from_slice(&texels[from..from + lanes]);
            }
        }
    }
    Ok(())
}
