//! The reconstructed texture: a function of the whole plane.

use super::axis::Axis;
use super::decode::decode;
use super::options::{Alpha, Encoding, Reconstruction, Wrap};
use crate::error::{Error, Result};
use crate::image::AnyView;

/// What a [`Signal`] is made of besides the picture.
#[derive(Clone, Debug)]
pub struct Options {
    /// What lies outside, along u and along v.
    pub wrap: [Wrap; 2],
    /// The border colour in the space of the filter (linear light, multiplied by alpha): one number for all
    /// channels, or one for each.
    pub border: Vec<f64>,
    /// Meaning of the stored numbers.
    pub encoding: Encoding,
    /// Meaning of the last channel.
    pub alpha: Alpha,
    /// How texels become a function.
    pub reconstruction: Reconstruction,
}

impl Default for Options {
    /// Repeat, border 0, linear, no alpha, bilinear.
    fn default() -> Self {
        Self {
            wrap: [Wrap::Repeat; 2],
            border: vec![0.0],
            encoding: Encoding::Linear,
            alpha: Alpha::None,
            reconstruction: Reconstruction::Bilinear,
        }
    }
}

/// Values of all channels, and how far they may be from the true integral.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// One number a channel.
    pub values: Vec<f64>,
    /// Largest estimated error of a channel; 0 where the integral is in closed form.
    pub error: f64,
}

/// A texture as a function of the plane, in f64: decoded, wrapped and reconstructed.
///
/// Positions inside are in texels from the texture's outer corner: texel (i, j) covers `[i, i+1] x [j, j+1]`.
#[derive(Clone, Debug)]
pub struct Signal {
    texels: Vec<f64>,
    stride: usize,
    channels: usize,
    border: Vec<f64>,
    straight: bool,
    pub(super) axes: [Axis; 2],
    pub(super) reconstruction: Reconstruction,
    mean: Vec<f64>,
    spread: f64,
}

impl Signal {
    /// Decodes a picture.
    ///
    /// # Errors
    /// [`Error::Value`] when the border has neither one number nor one for each channel, when the encoding
    /// or alpha does not fit the number of channels, and when `extend` finds fewer than three texels.
    pub fn new(image: AnyView<'_>, options: &Options) -> Result<Self> {
        let channels = image.channels();
        let border = match options.border.as_slice() {
            [one] => vec![*one; channels],
            all if all.len() == channels => all.to_vec(),
            other => {
                let expected = format!("1 or {channels} numbers");
                return Err(Error::value("border", format!("{} numbers", other.len()), expected));
            }
        };
        let stored = [image.width(), image.height()];
        let mut axes = [Axis::new(Wrap::Clamp, 1, options.reconstruction); 2];
        let mut extra = [0; 2];
        for (i, wrap) in options.wrap.into_iter().enumerate() {
            extra[i] = usize::from(wrap == Wrap::Extend);
            if stored[i] <= 2 * extra[i] {
                let expected = "at least 3 texels on an axis that is stored with its extra texels";
                return Err(Error::value("image", format!("{} by {}", stored[0], stored[1]), expected));
            }
            axes[i] = Axis::new(wrap, (stored[i] - 2 * extra[i]) as i64, options.reconstruction);
        }
        let texels = decode(image, options.encoding, options.alpha)?;
        let mut mean = vec![0.0; channels];
        let inner = stored[0] - 2 * extra[0];
        for y in extra[1]..stored[1] - extra[1] {
            let row = &texels[(y * stored[0] + extra[0]) * channels..][..inner * channels];
            for pixel in row.chunks_exact(channels) {
                mean.iter_mut().zip(pixel).for_each(|(m, v)| *m += v);
            }
        }
        let count = (inner * (stored[1] - 2 * extra[1])) as f64;
        mean.iter_mut().for_each(|m| *m /= count);
        let spread = (0..channels)
            .map(|c| {
                let channel = texels.iter().skip(c).step_by(channels).chain(&border[c..=c]);
                let limits = channel
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &v| (low.min(v), high.max(v)));
                limits.1 - limits.0
            })
            .fold(0.0, f64::max);
        Ok(Self {
            texels,
            stride: stored[0],
            channels,
            border,
            straight: options.alpha == Alpha::Straight,
            axes,
            reconstruction: options.reconstruction,
            mean,
            spread,
        })
    }

    /// Numbers in a value.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// How texels become a function.
    pub fn reconstruction(&self) -> Reconstruction {
        self.reconstruction
    }

    /// Texels along u and v, without extra ones.
    pub fn size(&self) -> [i64; 2] {
        self.axes.map(|axis| axis.len())
    }

    /// The stored texel, or the border colour.
    pub(super) fn texel(&self, x: Option<usize>, y: Option<usize>) -> &[f64] {
        match (x, y) {
            (Some(x), Some(y)) => &self.texels[(y * self.stride + x) * self.channels..][..self.channels],
            _ => &self.border,
        }
    }

    /// The border colour.
    pub(super) fn border(&self) -> &[f64] {
        &self.border
    }

    /// The mean of all texels: what a footprint without end sees.
    pub(super) fn mean(&self) -> &[f64] {
        &self.mean
    }

    /// Largest difference of two texels in one channel.
    pub(super) fn spread(&self) -> f64 {
        self.spread
    }

    /// The reconstruction at a position in texels; the border colour where that is not finite.
    pub(super) fn point(&self, position: [f64; 2]) -> Vec<f64> {
        if !position.iter().all(|x| x.is_finite()) {
            return self.border.clone();
        }
        let [x, y] = [0, 1].map(|i| position[i] - self.axes[i].periods_below(position[i]));
        let [u, v] = &self.axes;
        let (column, row) = (u.cell(x), v.cell(y));
        let (across, down) = (u.weights(column, x), v.weights(row, y));
        let mut sum = vec![0.0; self.channels];
        for (j, wy) in v.taps(row).zip(down) {
            for (i, wx) in u.taps(column).zip(across) {
                sum.iter_mut().zip(self.texel(i, j)).for_each(|(s, t)| *s += wx * wy * t);
            }
        }
        sum
    }

    /// The value that is given back: divided by alpha if alpha is straight, 0 where alpha is 0.
    pub(super) fn finish(&self, mut values: Vec<f64>, mut error: f64) -> Estimate {
        if self.straight {
            let (colours, alpha) = values.split_at_mut(self.channels - 1);
            let alpha = alpha[0];
            for colour in colours.iter_mut() {
                *colour = if alpha == 0.0 { 0.0 } else { *colour / alpha };
            }
            if alpha != 0.0 && error > 0.0 {
                let largest = colours.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
                error *= (1.0 + largest) / alpha.abs();
            }
        }
        Estimate { values, error }
    }

    /// The reconstruction at (u, v), both 0 to 1 across the texture, v down. A coordinate that is not
    /// finite gives the border colour.
    pub fn at(&self, uv: [f64; 2]) -> Vec<f64> {
        self.finish(self.point(self.texels_of(uv)), 0.0).values
    }

    /// From uv to texels. Finite coordinates stay finite.
    pub(super) fn texels_of(&self, uv: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| {
            let x = uv[i] * self.axes[i].len() as f64;
            if uv[i].is_finite() { x.clamp(f64::MIN, f64::MAX) } else { x }
        })
    }
}
