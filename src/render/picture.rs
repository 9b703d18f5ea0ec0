//! The finished picture.

use super::Report;
use crate::encode::linear_to_srgb;
use crate::error::Result;
use crate::par;
use crate::shade::over;

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

    /// Over a background, and `times` by `times` pixels to one.
    pub(super) fn new(
        (width, height): (usize, usize),
        times: usize,
        mut pixels: Vec<[f32; 4]>,
        background: [f32; 4],
        report: Option<Report>,
    ) -> Result<Self> {
        if background != [0.0; 4] {
            par::for_each(pixels.chunks_mut(1 << 16), |_, part| {
                part.iter_mut().for_each(|p| *p = over(*p, background));
                Ok(())
            })?;
        }
        if times > 1 {
            let mut small = crate::image::zeros::<[f32; 4]>("size", width * height)?;
            let scale = 1.0 / (times * times) as f32;
            par::for_each(small.chunks_mut(width), |y, row| {
                for (x, out) in row.iter_mut().enumerate() {
                    let mut sum = [0f32; 4];
                    for line in pixels[y * times * times * width..].chunks(times * width).take(times) {
                        for p in &line[x * times..][..times] {
                            (0..4).for_each(|c| sum[c] += p[c]);
                        }
                    }
                    *out = sum.map(|s| s * scale);
                }
                Ok(())
            })?;
            pixels = small;
        }
        Ok(Self { width, height, pixels, report })
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

    /// For the screen: 8-bit sRGB codes and straight alpha, four numbers a pixel. Light beyond 1 is cut off.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted) when the caller asked to stop.
    pub fn to_srgb8(&self) -> Result<Vec<u8>> {
        const PART: usize = 1 << 15;
        let table = Table::new();
        let mut out = crate::image::zeros::<u8>("size", self.pixels.len() * 4)?;
        let parts = out.chunks_mut(PART * 4).zip(self.pixels.chunks(PART));
        par::for_each(parts, |_, (out, pixels)| {
            for (out, [r, g, b, a]) in out.chunks_exact_mut(4).zip(pixels) {
                let straight = if *a > 0.0 { 1.0 / a } else { 0.0 };
                let [r, g, b] = [r, g, b].map(|c| table.code(c * straight));
                out.copy_from_slice(&[r, g, b, (a.clamp(0.0, 1.0) * 255.0 + 0.5) as u8]);
            }
            Ok(())
        })?;
        Ok(out)
    }
}

/// sRGB codes of linear light by search in the places where the code changes: exact, without powers.
struct Table {
    /// The light from which on code k + 1 is the nearest.
    limits: [f32; 255],
    /// For each 4096th of light the code at its start.
    first: Vec<u8>,
}

impl Table {
    fn new() -> Self {
        let limits = std::array::from_fn(|k| crate::encode::srgb_to_linear((k as f64 + 0.5) / 255.0) as f32);
        let first = (0..=4096).map(|i| (linear_to_srgb(f64::from(i) / 4096.0) * 255.0 + 0.5) as u8).collect();
        Self { limits, first }
    }

    fn code(&self, light: f32) -> u8 {
        if light.is_nan() || light <= 0.0 {
            return 0;
        }
        if light >= 1.0 {
            return 255;
        }
        let mut code = self.first[(light * 4096.0) as usize];
        while code > 0 && light < self.limits[usize::from(code) - 1] {
            code -= 1;
        }
        while code < 255 && light >= self.limits[usize::from(code)] {
            code += 1;
        }
        code
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_the_nearest() {
        let table = Table::new();
        for i in 0..=100_000 {
            let light = i as f32 / 100_000.0;
            let exact = linear_to_srgb(f64::from(light)) * 255.0;
            let code = f64::from(table.code(light));
            assert!((code - exact).abs() <= 0.5 + 1e-4, "{light}: {code} for {exact}");
        }
        assert_eq!((table.code(f32::NAN), table.code(f32::INFINITY), table.code(-1.0)), (0, 255, 0));
    }
}
