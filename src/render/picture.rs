//! The finished picture.

use super::Report;
use crate::shade::over;
use std::ops::Range;

/// A picture: linear light, premultiplied alpha. Rows run down from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    width: usize,
    height: usize,
    pixels: Vec<[f32; 4]>,
    report: Option<Report>,
}

impl Picture {
    /// Colour and straight alpha as premultiplied.
    pub(super) fn premultiplied([r, g, b, a]: [f32; 4]) -> [f32; 4] {
        [r * a, g * a, b * a, a]
    }

    pub(super) fn new(
        (width, height): (usize, usize),
        pixels: Vec<[f32; 4]>,
        report: Option<Report>,
    ) -> Self {
        Self { width, height, pixels, report }
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Premultiplied linear colours with alpha.
    pub fn pixels(&self) -> &[[f32; 4]] {
        &self.pixels
    }

    /// The same, given away.
    pub fn into_pixels(self) -> Vec<[f32; 4]> {
        self.pixels
    }

    /// What textures were used for, where the options asked for it.
    pub fn report(&self) -> Option<&Report> {
        self.report.as_ref()
    }
}

/// Rows of a picture that is being made, in one of its forms.
pub(super) enum Rows<'o> {
    /// Premultiplied linear colours.
    Light(&'o mut [[f32; 4]]),
    /// sRGB codes with straight alpha, four a pixel.
    Codes(&'o mut [u8]),
}

impl<'o> Rows<'o> {
    /// The rows, so many pixels at a time.
    pub fn split(self, pixels: usize) -> Box<dyn ExactSizeIterator<Item = Rows<'o>> + 'o> {
        match self {
            Self::Light(all) => Box::new(all.chunks_mut(pixels).map(Rows::Light)),
            Self::Codes(all) => Box::new(all.chunks_mut(4 * pixels).map(Rows::Codes)),
        }
    }
}

/// What is done to drawn rows.
pub(super) struct Finish {
    /// Pixels in a row of the picture.
    width: usize,
    times: usize,
    background: [f32; 4],
    /// A pixel in which nothing is drawn.
    empty: [f32; 4],
    table: Option<Table>,
}

impl Finish {
    /// Over a premultiplied background, and `times` by `times` pixels to one of `out`, which has `width` a row.
    pub fn new(width: usize, times: usize, background: [f32; 4], out: &Rows<'_>) -> Self {
        let empty = mean(&vec![background; times * times], times, times);
        let table = matches!(out, Rows::Codes(_)).then(Table::new);
        Self { width, times, background, empty, table }
    }

    /// Finishes `rows` rows of the drawing, whole rows of the picture, of which `pixels` hold the columns of `window`, into
    /// the first of `out`, and hands back the others.
    pub fn rows<'o>(
        &self,
        pixels: &mut [[f32; 4]],
        window: &Range<usize>,
        rows: usize,
        out: Rows<'o>,
    ) -> Rows<'o> {
        if self.background != [0.0; 4] {
            pixels.iter_mut().for_each(|p| *p = over(*p, self.background));
        }
        let (times, rows) = (self.times, rows / self.times);
        let width = window.len() / times;
        if times > 1 {
            // In place: what is written lies before what is still to be read.
            for i in 0..width * rows {
                let (x, y) = (i % width * times, i / width * times);
                pixels[i] = mean(&pixels[y * window.len() + x..], window.len(), times);
            }
        }
        let columns = window.start / times..window.start / times + width;
        let drawn = (0..rows).map(|y| &pixels[y * width..(y + 1) * width]);
        match (out, &self.table) {
            (Rows::Light(out), _) => {
                let (own, rest) = out.split_at_mut(self.width * rows);
                for (row, drawn) in own.chunks_mut(self.width).zip(drawn) {
                    row[..columns.start].fill(self.empty);
                    row[columns.clone()].copy_from_slice(drawn);
                    row[columns.end..].fill(self.empty);
                }
                Rows::Light(rest)
            }
            (Rows::Codes(out), table) => {
                let (own, rest) = out.split_at_mut(4 * self.width * rows);
                if let Some(table) = table {
                    let mut empty = [0; 4];
                    table.codes(&[self.empty], &mut empty);
                    for (row, drawn) in own.chunks_mut(4 * self.width).zip(drawn) {
                        let row = row.as_chunks_mut().0;
                        table.codes(drawn, row[columns.clone()].as_flattened_mut());
                        // The rows are zeros as they come.
                        if empty != [0; 4] {
                            row[..columns.start].fill(empty);
                            row[columns.end..].fill(empty);
                        }
                    }
                }
                Rows::Codes(rest)
            }
        }
    }
}

/// The mean of the first `times` pixels of `times` rows, of `width` pixels each.
fn mean(pixels: &[[f32; 4]], width: usize, times: usize) -> [f32; 4] {
    let mut sum = [0f32; 4];
    for line in 0..times {
        for p in &pixels[line * width..][..times] {
            for (sum, p) in sum.iter_mut().zip(p) {
                *sum += p;
            }
        }
    }
    let share = 1.0 / (times * times) as f32;
    [sum[0] * share, sum[1] * share, sum[2] * share, sum[3] * share]
}

/// Fields of the table of codes in the light from 0 to 1.
const FIELDS: usize = 4096;
/// 2^23: sums with it are whole numbers, in the last bits.
const WHOLE: f32 = 8_388_608.0;

/// sRGB codes of linear light by search in the places where the code changes: exact, without powers.
struct Table {
    /// The light from which on code k + 1 is the nearest; no light beyond the last.
    limits: [f32; 256],
    /// For each multiple of 1/4096 of light the code of what is least among that which it is nearest to. Codes are further
    /// apart than that.
    first: Box<[u8; 2 * FIELDS]>,
}

impl Table {
    fn new() -> Self {
        let limit = |k: usize| crate::encode::srgb_to_linear((k as f64 + 0.5) / 255.0) as f32;
        let limits = std::array::from_fn(|k| if k < 255 { limit(k) } else { f32::INFINITY });
        let least = |i: usize| (i as f32 - 0.5) / FIELDS as f32;
        let code = |i: usize| limits.partition_point(|&limit| limit <= least(i)) as u8;
        Self { limits, first: Box::new(std::array::from_fn(code)) }
    }

    /// 8-bit codes, colours divided by their alpha. Light beyond 1 is cut off.
    fn codes(&self, pixels: &[[f32; 4]], out: &mut [u8]) {
        for (out, &[r, g, b, a]) in out.as_chunks_mut::<4>().0.iter_mut().zip(pixels) {
            *out = if a == 1.0 {
                let [r, g, b] = self.code([r, g, b]);
                [r, g, b, 255]
            } else if a > 0.0 {
                let times = 1.0 / a;
                let [r, g, b] = self.code([r * times, g * times, b * times]);
                [r, g, b, (a.min(1.0) * 255.0 + 0.5) as u8]
            } else {
                [0; 4]
            };
        }
    }

    #[inline(always)]
    fn code(&self, light: [f32; 3]) -> [u8; 3] {
        let mut codes = [0; 3];
        for (code, light) in codes.iter_mut().zip(light) {
            // Not a number, and what is negative, becomes 0.
            let light = if light > 0.0 { light } else { 0.0 };
            let light = if light < 1.0 { light } else { 1.0 };
            let field = (light * FIELDS as f32 + WHOLE).to_bits() as usize % (2 * FIELDS);
            *code = self.first[field];
            *code += u8::from(light >= self.limits[usize::from(*code)]);
        }
        codes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::linear_to_srgb;

    #[test]
    fn codes_are_the_nearest() {
        let table = Table::new();
        for i in 0..=100_000 {
            let light = i as f32 / 100_000.0;
            let exact = linear_to_srgb(f64::from(light)) * 255.0;
            let code = f64::from(table.code([light; 3])[0]);
            assert!((code - exact).abs() <= 0.5 + 1e-4, "{light}: {code} for {exact}");
        }
        assert_eq!(table.code([f32::NAN, f32::INFINITY, -1.0]), [0, 255, 0]);
        for (k, &limit) in table.limits[..255].iter().enumerate() {
            assert_eq!(table.code([limit, limit.next_down(), 1.0]), [k as u8 + 1, k as u8, 255]);
        }
    }
}
