//! Into how many points or boxes a pixel is taken apart, and on which level.

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
/// Points of a single pixel, at least, and along a long footprint at most.
const FOUR: usize = 4;
/// See [`FOUR`].
const MOST: f64 = 256.0;
/// Sides of a part, in texels, at most. Boxes hold two: a quarter more blurs by a tenth less.
const SIDE: f64 = 2.25;
/// Boxes a pixel in each direction, at most.
const BOXES: usize = 32;
/// Correlation of the columns and rows of a part, at most, which boxes follow to first order; and a covariance, in texels
/// squared, that is always small enough.
const LEANING: f64 = 0.6;
/// See [`LEANING`].
const SLIGHT: f64 = 0.05;
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

/// Points scattered over a single pixel, whose shadow on any line is even: as many as a long footprint needs along it, also
/// where it lies aslant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scatter {
    pub level: usize,
    pub count: usize,
}

impl Scatter {
    /// The four of Gauss on the first level: for footprints of up to some three texels.
    pub const SMALL: Self = Self { level: 0, count: FOUR };
    /// Pixels from one of the four to the next.
    pub const APART: f64 = 2.0 * GAUSS;

    /// The points for a footprint.
    pub fn of([x, y]: [DVec2; 2], last_level: usize) -> Self {
        let axes = Jacobian::new([[x.x, y.x], [x.y, y.y]]).axes();
        let wanted = (axes.sigma2 / FINE).max(axes.sigma1 * DENSITY / MOST).log2().ceil();
        let level = wanted.clamp(0.0, last_level as f64);
        let [long, wide] = [axes.sigma1, axes.sigma2].map(|s| DENSITY * s / level.exp2());
        let count = (long * wide.max(1.0)).ceil().clamp(FOUR as f64, MOST * FINE * DENSITY) as usize;
        Self { level: level as usize, count }
    }

    /// Where point `k` lies in the pixel, 0 to 1.
    pub fn place(self, k: usize) -> DVec2 {
        /// The golden section.
        const TURN: f64 = 0.618_033_988_749_894_9;
        match self.count {
            FOUR => Grid { level: 0, points: [2; 2] }.place(k),
            n => {
                let k = k as f64 + 0.5;
                DVec2::new(k / n as f64, (k * TURN).fract())
            }
        }
    }
}

/// The parts of a pixel that upright boxes stand for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Parts {
    pub level: usize,
    /// Columns and rows.
    pub count: [usize; 2],
}

impl Parts {
    /// The parts for some footprints of pixels: what a pixel right and a pixel down add, in texels. Each has sides of at
    /// most [`SIDE`] texels, and leans by at most [`LEANING`], so that boxes with the parts' own moments have means close to theirs.
    /// Neighbours along a row are `alike`: footprints that are longer than all boxes are filled by them with gaps.
    pub fn of(footprints: &[[DVec2; 2]], alike: f64, last_level: usize) -> Self {
        let (mut long, mut width) = (0.0f64, 0.0f64);
        let shorter = DVec2::new(alike, 1.0);
        for [x, y] in footprints.iter().map(|sides| sides.map(|x| x * shorter)) {
            long = long.max(x.length()).max(y.length());
            width = width.max(Jacobian::new([[x.x, y.x], [x.y, y.y]]).axes().sigma2);
        }
        let wanted = (width / FINE).max(long / (SIDE * BOXES as f64)).log2().ceil();
        let level = wanted.clamp(0.0, last_level as f64);
        let scale = (-level).exp2();
        let mut count = [1; 2];
        for [x, y] in footprints {
            let (x, y) = (*x * scale, *y * scale);
            loop {
                let [nx, ny] = count.map(|n| n as f64);
                let (a, b) = (x / nx, y / ny);
                let sides = half_sides([a, b]) * 2.0;
                let more = if sides.max_element() > SIDE {
                    usize::from(b.length_squared() > a.length_squared())
                } else if covariance([a, b]).abs() > (LEANING * sides.x * sides.y / 12.0).max(SLIGHT) {
                    usize::from((b.x * b.y).abs() > (a.x * a.y).abs())
                } else {
                    break;
                };
                if count[more] == BOXES {
                    break;
                }
                count[more] += 1;
            }
        }
        Self { level: level as usize, count }
    }

    /// Where part `k` lies in the pixel, 0 to 1.
    pub fn place(self, k: usize) -> DVec2 {
        let [nx, ny] = self.count;
        DVec2::new(((k % nx) as f64 + 0.5) / nx as f64, ((k / nx) as f64 + 0.5) / ny as f64)
    }
}

/// Half the sides of the upright box whose variances are those of a parallelogram.
pub(super) fn half_sides([a, b]: [DVec2; 2]) -> DVec2 {
    DVec2::new(a.x.hypot(b.x), a.y.hypot(b.y)) * 0.5
}

/// Covariance of the columns and rows of a parallelogram.
pub(super) fn covariance([a, b]: [DVec2; 2]) -> f64 {
    (a.x * a.y + b.x * b.y) / 12.0
}

/// By how much movements along a row of the picture, at `v` from its upper end, are shortened before points are counted: towards the
/// poles of an equirectangular picture neighbours along a ring are ever more alike, so the count grows as the root.
pub(super) fn along_row(form: Form, v: f64) -> f64 {
    if form == Form::Equirect { (v * std::f64::consts::PI).sin().abs().max(LEAST_RING).sqrt() } else { 1.0 }
}
