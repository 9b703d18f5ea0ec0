//! Summed-area tables: the sum over any rectangle from four entries of a table.
//!
//! `table[y][x]` is the sum of all texels above and to the left of the corner `(x, y)`; it has one row and
//! one column of zeros more than the image (Crow, "Summed-area tables for texture mapping", 1984). A box
//! with whole corners is `t[y1][x1] - t[y0][x1] - t[y1][x0] + t[y0][x0]`. A box with fractional corners is
//! cut into at most nine such boxes, each with a positive weight, so it is the exact integral over texels
//! as squares.
//!
//! Sums of integers are exact (32 bits where they cannot overflow, else 64). Of floats the mean is taken off
//! first and put back per box: a small box far from the origin would otherwise be the difference of two
//! large rounded numbers. A NaN or infinite texel makes every box below or to the right of it NaN.

mod axis;

use crate::error::{Error, Result};
use crate::image::{AnyView, View};
use crate::kernel::prefix::{self, Sum};
use crate::kernel::{Isa, pages};
use crate::par;
use crate::texel::Texel;
use crate::wrap::Wrap;
use axis::Axis;

/// Rows that one task sums.
const BAND: usize = 64;
/// Boxes that one task looks up.
const BOXES: usize = 1024;

/// The entries, `(height + 1) * (width + 1) * channels` of them, channels interleaved.
#[derive(Clone, Debug, PartialEq)]
pub enum Table {
    /// Sums of `u8` codes, at most 16 843 009 texels.
    U32(Vec<u32>),
    /// Sums of `u8` and `u16` codes.
    U64(Vec<u64>),
    /// Sums of floats, each less its channel's offset.
    F64(Vec<f64>),
}

/// A table with what lies outside of it.
///
/// ```
/// use multum::sat::SummedAreaTable;
/// use multum::{Image, Wrap};
///
/// let image = Image::new(2, 2, 1, vec![0u8, 51, 102, 255])?;
/// let sat = SummedAreaTable::new(image.view(), [Wrap::Repeat; 2], None)?;
/// // Texels are squares of side 1: half of 51/255 and half of 255/255.
/// assert_eq!(sat.sum_rect::<1>(1.5, 0.0, 2.0, 2.0), [0.6]);
/// // The whole texture, any number of times.
/// assert_eq!(sat.mean_rect::<1>(-2.0, -2.0, 4.0, 2.0), [0.4]);
/// # Ok::<(), multum::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct SummedAreaTable {
    width: usize,
    height: usize,
    channels: usize,
    wrap: [Wrap; 2],
    border: Vec<f64>,
    table: Table,
    offset: Vec<f64>,
    full_scale: f64,
}

impl SummedAreaTable {
    /// Sums an image. `border`, for [`Wrap::Border`], has one value a channel, normalised as values are
    /// (integers over their full scale); zero for `None`. With [`Wrap::Extend`] on an axis the outermost
    /// texels of the image are the extra ones, outside of the texture's 0..1.
    ///
    /// # Errors
    /// [`Error::Value`] when `border` has the wrong length or is not finite, or the image is too small for
    /// [`Wrap::Extend`].
    pub fn new(image: AnyView<'_>, wrap: [Wrap; 2], border: Option<&[f64]>) -> Result<Self> {
        let (width, height, channels) = (image.width(), image.height(), image.channels());
        let border = border.map_or_else(|| vec![0.0; channels], <[f64]>::to_vec);
        if border.len() != channels || !border.iter().all(|b| b.is_finite()) {
            return Err(Error::value("border", format!("{border:?}"), format!("{channels} finite numbers")));
        }
        for (wrap, n) in [(wrap[0], width), (wrap[1], height)] {
            if wrap == Wrap::Extend && n < 3 {
                return Err(Error::value(
                    "image",
                    format!("{width} x {height} texels"),
                    "at least 3 texels on an axis that is extended",
                ));
            }
        }
        let zeros = vec![0.0; channels];
        let fits = width as u64 * height as u64 <= u64::from(u32::MAX / 255);
        let (table, offset) = match image {
            AnyView::U8(view) if fits => (Table::U32(integers(view)?), zeros),
            AnyView::U8(view) => (Table::U64(integers(view)?), zeros),
            AnyView::U16(view) => (Table::U64(integers(view)?), zeros),
            AnyView::F16(view) => floats(view)?,
            AnyView::F32(view) => floats(view)?,
            AnyView::F64(view) => floats(view)?,
        };
        let full_scale = image.dtype().full_scale();
        Ok(Self { width, height, channels, wrap, border, table, offset, full_scale })
    }

    /// Texels in a row of the image.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows of the image.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Numbers in a texel.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Wrap modes for x and y.
    pub fn wrap(&self) -> [Wrap; 2] {
        self.wrap
    }

    /// The entries: sums of codes.
    pub fn table(&self) -> &Table {
        &self.table
    }

    /// What has been taken off each texel of a float image before it was summed, per channel.
    pub fn offset(&self) -> &[f64] {
        &self.offset
    }

    /// Bytes of the entries.
    pub fn nbytes(&self) -> usize {
        match &self.table {
            Table::U32(t) => size_of_val(t.as_slice()),
            Table::U64(t) => size_of_val(t.as_slice()),
            Table::F64(t) => size_of_val(t.as_slice()),
        }
    }

    /// The texture's size, without the extra texels of [`Wrap::Extend`].
    fn inner(&self) -> [usize; 2] {
        let less = |wrap, n| if wrap == Wrap::Extend { n - 2 } else { n };
        [less(self.wrap[0], self.width), less(self.wrap[1], self.height)]
    }

    /// Integral of the texture over a box of texel coordinates: values times texel areas. `C` is the number
    /// of channels to return. Reversed sides count negative; a coordinate that is not finite gives NaN.
    pub fn sum_rect<const C: usize>(&self, x0: f64, y0: f64, x1: f64, y1: f64) -> [f64; C] {
        self.rect([x0, y0, x1, y1], false, 0)
    }

    /// Mean of the texture over a box of texel coordinates; a side of no length stands for the texel that
    /// holds it. The order of opposite sides does not matter; a coordinate that is not finite gives the
    /// border colour. `C` is the number of channels to return.
    pub fn mean_rect<const C: usize>(&self, x0: f64, y0: f64, x1: f64, y1: f64) -> [f64; C] {
        self.rect([x0, y0, x1, y1], true, 0)
    }

    /// Channels `first..first + C` of a box.
    fn rect<const C: usize>(&self, [x0, y0, x1, y1]: [f64; 4], mean: bool, first: usize) -> [f64; C] {
        let channel = |c: usize| (first + c).min(self.channels - 1);
        if ![x0, y0, x1, y1, x1 - x0, y1 - y0].iter().all(|x| x.is_finite()) {
            return std::array::from_fn(|c| if mean { self.border[channel(c)] } else { f64::NAN });
        }
        let sides = [(x0, x1, self.wrap[0], self.width), (y0, y1, self.wrap[1], self.height)];
        let mut sign = 1.0;
        let mut axes = sides.map(|(a, b, wrap, n)| {
            let shift = if wrap == Wrap::Extend { 1.0 } else { 0.0 };
            let (low, high) = (a.min(b) + shift, a.max(b) + shift);
            if a > b && !mean {
                sign = -sign;
            }
            if low == high && mean { Axis::point(wrap, low, n) } else { Axis::new(wrap, low, high, n) }
        });
        if mean {
            axes.iter_mut().for_each(Axis::tame);
        }
        let mut sums = match &self.table {
            Table::U32(t) => self.weighted(t, &axes, first, |a, b| a.wrapping_sub(b), f64::from),
            Table::U64(t) => self.weighted(t, &axes, first, |a, b| a.wrapping_sub(b), |x| x as f64),
            Table::F64(t) => self.weighted(t, &axes, first, |a, b| a - b, |x| x),
        };
        let inside = axes[0].inside * axes[1].inside;
        let area = axes[0].length * axes[1].length;
        for (c, sum) in sums.iter_mut().enumerate() {
            let outside = self.border[channel(c)] * (area - inside);
            *sum = if mean {
                // Dividing the sum before the offset returns keeps a constant image what it is.
                (*sum / area + self.offset[channel(c)] * (inside / area)) / self.full_scale + outside / area
            } else {
                sign * ((*sum + self.offset[channel(c)] * inside) / self.full_scale + outside)
            };
        }
        sums
    }

    /// Sum over the runs of both axes of weight times box sum; box sums come first, so integers are exact.
    fn weighted<S: Copy + Default, const C: usize>(
        &self,
        table: &[S],
        axes: &[Axis; 2],
        first: usize,
        minus: impl Fn(S, S) -> S,
        to_f64: impl Fn(S) -> f64,
    ) -> [f64; C] {
        let count = C.min(self.channels - first);
        let entry = |x: usize, y: usize| {
            let at = (y * (self.width + 1) + x) * self.channels + first;
            let entry = &table[at..at + count];
            std::array::from_fn::<S, C, _>(|c| entry.get(c).copied().unwrap_or_default())
        };
        let mut total = [0.0; C];
        for y in axes[1].runs() {
            let mut strip = [0.0; C];
            for x in axes[0].runs() {
                let (a, b) = (entry(x.start, y.start), entry(x.end, y.start));
                let (c, d) = (entry(x.start, y.end), entry(x.end, y.end));
                for k in 0..C {
                    strip[k] += x.weight * to_f64(minus(minus(d[k], b[k]), minus(c[k], a[k])));
                }
            }
            for k in 0..C {
                total[k] += y.weight * strip[k];
            }
        }
        total
    }

    /// Sums or means of many boxes `u0 v0 u1 v1` in texture coordinates, into `channels` numbers each.
    ///
    /// # Errors
    /// [`Error::Value`] when `out` has not `channels` numbers for each box.
    pub fn boxes_uv(&self, boxes: &[[f64; 4]], mean: bool, out: &mut [f64]) -> Result<()> {
        if out.len() != boxes.len() * self.channels {
            return Err(Error::value("out", out.len(), boxes.len() * self.channels));
        }
        let [w, h] = self.inner().map(|n| n as f64);
        let tiles = out.chunks_mut(BOXES * self.channels).zip(boxes.chunks(BOXES));
        par::for_pixels(boxes.len(), tiles, |_, (out, boxes)| {
            for (out, b) in out.chunks_exact_mut(self.channels).zip(boxes) {
                let sides = [b[0] * w, b[1] * h, b[2] * w, b[3] * h];
                match self.channels {
                    1 => out.copy_from_slice(&self.rect::<1>(sides, mean, 0)),
                    2 => out.copy_from_slice(&self.rect::<2>(sides, mean, 0)),
                    3 => out.copy_from_slice(&self.rect::<3>(sides, mean, 0)),
                    _ => {
                        for (part, out) in out.chunks_mut(4).enumerate() {
                            let values = self.rect::<4>(sides, mean, 4 * part);
                            out.copy_from_slice(&values[..out.len()]);
                        }
                    }
                }
            }
            Ok(())
        })
    }
}

/// Sums of columns of every band of rows, added up from band to band and along the row: the table's last
/// row above each band.
fn carries<T: Texel, S: Sum<T> + Send + Sync>(
    image: View<'_, T>,
    offset: impl FnOnce(&[Vec<S>]) -> Vec<S>,
    less: impl Fn(S, S, usize) -> S,
) -> Result<(Vec<Vec<S>>, Vec<S>)> {
    let (row, channels) = (image.width() * image.channels(), image.channels());
    let bands = image.height().div_ceil(BAND);
    let isa = Isa::current();
    let mut columns: Vec<Vec<S>> = vec![vec![S::default(); row]; bands];
    par::for_pixels(image.width() * image.height(), columns.iter_mut(), |band, sums| {
        for y in band * BAND..((band + 1) * BAND).min(image.height()) {
            prefix::add_columns(isa, image.row(y), sums);
        }
        Ok(())
    })?;
    let offset = offset(&columns);
    let mut above = vec![S::default(); row + channels];
    let mut carries = Vec::with_capacity(bands);
    for sums in &columns {
        carries.push(above.clone());
        let mut run = vec![S::default(); channels];
        for (i, sum) in sums.iter().enumerate() {
            let c = i % channels;
            run[c] = run[c].plus(less(*sum, offset[c], BAND));
            above[i + channels] = above[i + channels].plus(run[c]);
        }
    }
    Ok((carries, offset))
}

/// All rows of the table; `carries` has the row above each band.
fn fill<T: Texel, S: Sum<T> + Send + Sync>(
    image: View<'_, T>,
    offset: &[S],
    carries: &[Vec<S>],
    band: usize,
) -> Result<Vec<S>> {
    let row = (image.width() + 1) * image.channels();
    let mut table = pages::zeros(row * (image.height() + 1));
    let isa = Isa::current();
    let tiles = table[row..].chunks_mut(row * band).zip(carries);
    par::for_pixels(image.width() * image.height(), tiles, |tile, (rows, carry)| {
        let mut above: &[S] = carry;
        for (r, out) in rows.chunks_exact_mut(row).enumerate() {
            prefix::row(isa, image.row(tile * band + r), offset, above, out);
            above = out;
        }
        Ok(())
    })?;
    Ok(table)
}

fn integers<T: Texel, S: Sum<T> + Send + Sync>(image: View<'_, T>) -> Result<Vec<S>> {
    let zeros = vec![S::default(); image.channels()];
    if par::num_threads() == 1 {
        // Exact sums do not depend on the order: one pass.
        let carry = vec![S::default(); (image.width() + 1) * image.channels()];
        return fill(image, &zeros, &[carry], image.height());
    }
    let (carries, _) = carries(image, |_| zeros.clone(), |sum, _, _| sum)?;
    fill(image, &zeros, &carries, BAND)
}

fn floats<T: Texel>(image: View<'_, T>) -> Result<(Table, Vec<f64>)>
where
    f64: Sum<T>,
{
    let channels = image.channels();
    let texels = image.width() as f64 * image.height() as f64;
    let mean = |columns: &[Vec<f64>]| {
        let mut totals = vec![0.0; channels];
        for band in columns {
            band.chunks_exact(channels).for_each(|t| totals.iter_mut().zip(t).for_each(|(a, b)| *a += b));
        }
        // Rounded to single, so that taking it off a single is mostly exact.
        let mean = totals.iter().map(|t| f64::from((t / texels) as f32));
        mean.map(|m| if m.is_finite() { m } else { 0.0 }).collect()
    };
    let (carries, offset) = carries(image, mean, |sum, offset, rows| sum - rows as f64 * offset)?;
    Ok((Table::F64(fill(image, &offset, &carries, BAND)?), offset))
}
