//! How many points a pixel is averaged over, and on which level.

use super::Form;
use crate::jacobian::Jacobian;
use glam::DVec2;

/// Points a texel in each direction.
const DENSITY: f64 = 1.3;
/// Two points from the middle of a pixel: those of Gauss, right for cubics.
const GAUSS: f64 = 0.288_675_134_594_812_9;
/// Texels a pixel, across its footprint, up to which the first level is read.
const FINE: f64 = 5.0;
/// Points a pixel in each direction, at least and at most.
const POINTS: [f64; 2] = [2.0, 32.0];
/// Shortest ring around a pole, as a share of the equator.
const LEAST_RING: f64 = 1e-6;

/// A regular grid of points within a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grid {
    pub level: usize,
    /// Columns and rows.
    pub points: [usize; 2],
}

impl Grid {
    /// One point, in the middle.
    pub const CENTRE: Self = Self { level: 0, points: [1; 2] };

    /// The grid for the longest of some footprints of pixels: what a pixel right and a pixel down add, in texels.
    pub fn of(footprints: impl Iterator<Item = [DVec2; 2]>, last_level: usize) -> Self {
        let (mut texels, mut width) = ([0.0f64; 2], 0.0f64);
        for [x, y] in footprints {
            texels = [texels[0].max(x.length()), texels[1].max(y.length())];
            width = width.max(Jacobian::new([[x.x, y.x], [x.y, y.y]]).axes().sigma2);
        }
        let long = texels[0].max(texels[1]);
        let wanted = (width / FINE).max(long * DENSITY / POINTS[1]).log2().ceil();
        let level = wanted.clamp(0.0, last_level as f64);
        let points = texels.map(|t| (DENSITY * t / level.exp2()).ceil().clamp(POINTS[0], POINTS[1]) as usize);
        Self { level: level as usize, points }
    }

    /// How many points there are.
    pub fn count(self) -> usize {
        self.points[0] * self.points[1]
    }

    /// Where point `k` lies in the pixel, 0 to 1.
    pub fn place(self, k: usize) -> DVec2 {
        let [nx, ny] = self.points;
        let within = |i: usize, n: usize| match (n, i) {
            (2, 0) => 0.5 - GAUSS,
            (2, _) => 0.5 + GAUSS,
            _ => (i as f64 + 0.5) / n as f64,
        };
        DVec2::new(within(k % nx, nx), within(k / nx, ny))
    }
}

/// By how much movements along a row of the picture, at `v` from its upper end, are shortened before points are counted: towards the
/// poles of an equirectangular picture neighbours along a ring are ever more alike, so the count grows as the root.
pub(super) fn along_row(form: Form, v: f64) -> f64 {
    if form == Form::Equirect {
        (v * std::f64::consts::PI).sin().abs().max(LEAST_RING).sqrt()
    } else {
        1.0
    }
}
