//! The fast way through a panorama: rectangles of pixels on which the map is a pair of cubics, read by the kernels.
//!
//! A rectangle of up to [`SIDE`] squared pixels whose map [`Chart`] meets is sampled at a regular grid of points in every
//! pixel, at least two and about [`DENSITY`] a texel in each direction, by the vector kernels of `remap`; the pixel is their mean. So the
//! footprint is the pixel's true preimage, bent as it is, not a parallelogram. Where texels are smaller than `1/FINE`
//! pixel the grid reads the coarser level on which they are not. Rectangles that the cubics do not meet are quartered; what
//! is left at [`LEAST`] pixels (around poles, rims and folds) is for the caller.

use super::Form;
use super::chart::{Chart, Line, PLACES, places};
use super::pictures::Pictures;
use crate::error::Result;
use crate::image::{AnyView, Element, Pixels, View};
use crate::jacobian::Jacobian;
use crate::kernel::remap::{Interpolation, Points, Real, Sample, remap};
use crate::kernel::{Isa, Work, compiled_for};
use crate::mapping::{Face, Mapping, SurfacePoint};
use crate::sphere::along;
use glam::{DMat3, DVec2, DVec3};

/// Pixels a side of a rectangle, at most.
pub(super) const SIDE: usize = 64;
/// Pixels a side of a rectangle that is not cut any more.
const LEAST: usize = 4;
/// Largest error of the cubics, in texels.
const TOLERANCE: f64 = 1.0 / 128.0;
/// Shortest ring around a pole, as a share of the equator, whose texels count as small.
const LEAST_RING: f64 = 1.0 / 64.0;
/// Points a texel in each direction.
const DENSITY: f64 = 1.3;
/// Two points from the middle of a pixel: those of Gauss, right for cubics.
const GAUSS: f64 = 0.288_675_134_594_812_9;
/// Texels a pixel, across its footprint, up to which the first level is read.
const FINE: f64 = 2.5;
/// Points a pixel in each direction, at least and at most.
const POINTS: [f64; 2] = [2.0, 32.0];
/// Texels from a face's edge within which neighbours may be read.
const EDGE: f64 = 4.0;

/// What is shown of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Show {
    /// The mean over its footprint.
    Mean,
    /// The picture at its centre.
    Centre(Interpolation),
}

/// Everything about a conversion that does not change from rectangle to rectangle.
pub(super) struct Tiles<'a, 'm, T> {
    pub pictures: Pictures<'a, T>,
    pub form: Form,
    pub map: &'m dyn Mapping,
    pub target_form: Form,
    pub target: &'m dyn Mapping,
    pub size: [usize; 2],
    pub rotation: DMat3,
    pub show: Show,
    pub isa: Isa,
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug)]
struct Rect {
    x: usize,
    y: usize,
    w: usize,
    h: usize,
}

/// The map of a rectangle to one picture of the source, in texels of its first level.
struct Sheet {
    face: usize,
    chart: Chart,
    /// Whether texels around a face may be read.
    edge: bool,
}

/// Room that every rectangle uses anew.
pub(super) struct Scratch<T: Sample> {
    x: Vec<f32>,
    y: Vec<f32>,
    face: Vec<u8>,
    values: Vec<T>,
    sums: Vec<T::Acc>,
}

impl<T: Sample> Scratch<T> {
    pub fn new() -> Self {
        Self { x: Vec::new(), y: Vec::new(), face: Vec::new(), values: Vec::new(), sums: Vec::new() }
    }
}

impl<'a, T: Element + Sample> Tiles<'a, '_, T>
where
    View<'a, T>: Into<AnyView<'a>>,
    Pixels: From<Vec<T>>,
{
    /// Fills the rows from `first` on; pixels that are for the caller are appended to `rest`.
    pub fn band(&self, first: usize, out: &mut [T], rest: &mut Vec<usize>) -> Result<()> {
        let width = self.size[0];
        let rows = out.len() / (width * self.pictures.channels());
        let mut scratch = Scratch::new();
        let mut at = 0;
        while at < width {
            let w = SIDE.min(width - at);
            let mut row = 0;
            while row < rows {
                let h = SIDE.min(rows - row);
                self.rect(Rect { x: at, y: first + row, w, h }, first, out, rest, &mut scratch)?;
                row += h;
            }
            at += w;
        }
        Ok(())
    }

    fn rect(
        &self,
        rect: Rect,
        first: usize,
        out: &mut [T],
        rest: &mut Vec<usize>,
        scratch: &mut Scratch<T>,
    ) -> Result<()> {
        let Rect { x, y, w, h } = rect;
        if let Some(sheets) = self.sheets(rect) {
            return self.fill(rect, &sheets, first, out, scratch);
        }
        if w.max(h) <= LEAST {
            for row in y..y + h {
                rest.extend((x..x + w).map(|column| row * self.size[0] + column));
            }
            return Ok(());
        }
        let (left, upper) = if w >= h { (w / 2, h) } else { (w, h / 2) };
        self.rect(Rect { w: left, h: upper, ..rect }, first, out, rest, scratch)?;
        if left < w {
            self.rect(Rect { x: x + left, w: w - left, ..rect }, first, out, rest, scratch)
        } else {
            self.rect(Rect { y: y + upper, h: h - upper, ..rect }, first, out, rest, scratch)
        }
    }

    /// The maps of a rectangle, one for each picture of the source that it meets.
    fn sheets(&self, Rect { x, y, w, h }: Rect) -> Option<Vec<Sheet>> {
        /// Pixels by which corners are drawn in, so that they lie on one side of the line between two pieces.
        const IN: f64 = 1e-6;
        let size = DVec2::new(self.size[0] as f64, self.size[1] as f64);
        let (corner, sides) = (DVec2::new(x as f64, y as f64), DVec2::new(w as f64, h as f64));
        let uv = |p: DVec2| (corner + (p + 1.0) * 0.5 * (sides - 2.0 * IN) + IN) / size;
        let piece = |x: f64, y: f64| self.target_form.piece(uv(DVec2::new(x, y)));
        let own = piece(-1.0, -1.0)?;
        if [(1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].into_iter().any(|(x, y)| piece(x, y) != Some(own)) {
            return None;
        }
        let mut directions = [DVec3::ZERO; PLACES];
        for (d, p) in directions.iter_mut().zip(places()) {
            *d = self.rotation * self.target.inverse_at(uv(p))?.p;
        }
        if matches!(self.form, Form::Cube(_)) {
            return self.cube_sheets(&directions);
        }
        let texels = self.pictures.size();
        let whole = [texels.x as usize, texels.y as usize];
        let mut values = [DVec2::ZERO; PLACES];
        let mut patch = None;
        for (value, d) in values.iter_mut().zip(directions) {
            let uv = self.map.at(&SurfacePoint::new(d)).uv;
            let here = self.form.patch(d, uv, whole)?;
            if !uv.is_finite() || *patch.get_or_insert(here) != here {
                return None;
            }
            *value = uv * texels;
        }
        if self.map.is_periodic() {
            // The way to each node is the short one.
            let from = values[16].x;
            for value in &mut values {
                value.x -= texels.x * ((value.x - from) / texels.x).round();
            }
        }
        // Along a ring next to a pole texels are small, and a mean takes many.
        let ring = |v: DVec2| (v.y / texels.y * std::f64::consts::PI).sin().abs().max(LEAST_RING);
        let averages = self.show == Show::Mean;
        let stretch = |v: DVec2| if averages && self.form == Form::Equirect { 1.0 / ring(v) } else { 1.0 };
        let tolerance = |v: DVec2| DVec2::new(TOLERANCE * stretch(v), TOLERANCE);
        Some(vec![Sheet { face: 0, chart: Chart::fit(&values, tolerance)?, edge: false }])
    }

    fn cube_sheets(&self, directions: &[DVec3; PLACES]) -> Option<Vec<Sheet>> {
        let n = self.pictures.size().x;
        let mut met: Vec<Face> = Vec::new();
        // The middle's face comes first.
        for d in directions[16..].iter().chain(&directions[..16]) {
            let face = Face::of(*d);
            if !met.contains(&face) {
                met.push(face);
            }
        }
        let sheet = |face: &Face| {
            let mut values = [DVec2::ZERO; PLACES];
            for (value, d) in values.iter_mut().zip(directions) {
                let uv = face.project(*d, [DVec3::ZERO; 2]).uv;
                if !uv.is_finite() {
                    return None;
                }
                *value = uv * n;
            }
            let inside = |v: &DVec2| v.min_element() > EDGE && v.max_element() < n - EDGE;
            let edge = !values.iter().all(inside);
            Some(Sheet { face: face.index(), chart: Chart::fit(&values, |_| DVec2::splat(TOLERANCE))?, edge })
        };
        met.iter().map(sheet).collect()
    }

    /// The level and the points a pixel in each direction.
    fn density(&self, rect: Rect, sheet: &Sheet) -> (usize, [usize; 2]) {
        if self.show != Show::Mean {
            return (0, [1; 2]);
        }
        let per_pixel = DVec2::new(2.0 / rect.w as f64, 2.0 / rect.h as f64);
        let (mut texels, mut width) = ([0.0f64; 2], 0.0f64);
        for p in [[0.0, 0.0], [-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]] {
            let [x, y] = sheet.chart.slopes(DVec2::from_array(p));
            let (x, y) = (x * per_pixel.x, y * per_pixel.y);
            texels = [texels[0].max(x.length()), texels[1].max(y.length())];
            width = width.max(Jacobian::new([[x.x, y.x], [x.y, y.y]]).axes().sigma2);
        }
        let long = texels[0].max(texels[1]);
        let wanted = (width / FINE).max(long * DENSITY / POINTS[1]).log2().ceil();
        let level = wanted.clamp(0.0, self.pictures.last_level() as f64);
        let points = texels.map(|t| (DENSITY * t / level.exp2()).ceil().clamp(POINTS[0], POINTS[1]) as usize);
        (level as usize, points)
    }

    fn fill(
        &self,
        rect: Rect,
        sheets: &[Sheet],
        first: usize,
        out: &mut [T],
        scratch: &mut Scratch<T>,
    ) -> Result<()> {
        let channels = self.pictures.channels();
        let (level, [nx, ny]) = self.density(rect, &sheets[0]);
        let (texels, frame) = self.pictures.level_size(level);
        let interpolation = match self.show {
            Show::Mean => Interpolation::Bilinear,
            Show::Centre(interpolation) => interpolation,
        };
        let jobs: Vec<_> = (sheets.iter())
            .map(|sheet| self.pictures.job(level, sheet.face, interpolation))
            .collect::<Result<_>>()?;
        let scale = texels / self.pictures.size();
        let offset = DVec2::splat(frame - 0.5);
        let points = nx * ny * rect.w;
        let all = points * sheets.len();
        scratch.x.resize(all, 0.0);
        scratch.y.resize(all, 0.0);
        scratch.values.resize(points * channels, T::default());
        for row in 0..rect.h {
            for (k, sheet) in sheets.iter().enumerate() {
                for part in 0..nx * ny {
                    let within = |i: usize, n: usize| match (n, i) {
                        (2, 0) => 0.5 - GAUSS,
                        (2, _) => 0.5 + GAUSS,
                        _ => (i as f64 + 0.5) / n as f64,
                    };
                    let line = Line {
                        y: (row as f64 + within(part / nx, ny)) * 2.0 / rect.h as f64 - 1.0,
                        first: within(part % nx, nx) * 2.0 / rect.w as f64 - 1.0,
                        step: 2.0 / rect.w as f64,
                        scale,
                        offset,
                    };
                    let at = k * points + part * rect.w..k * points + (part + 1) * rect.w;
                    let places = [&mut scratch.x[at.clone()], &mut scratch.y[at.clone()]];
                    sheet.chart.row(self.isa, &line, places);
                }
            }
            let (values, places) = (&mut scratch.values[..points * channels], [&scratch.x, &scratch.y]);
            if sheets.len() == 1 && !sheets[0].edge {
                remap(
                    self.isa,
                    &jobs[0],
                    &Points::Plain(&places[0][..points], &places[1][..points]),
                    values,
                )?;
            } else {
                choose(&mut scratch.x, &mut scratch.y, &mut scratch.face, points, texels.x);
                let faces = &scratch.face;
                let mut start = 0;
                while start < points {
                    let same = faces[start..points].iter().take_while(|f| **f == faces[start]).count();
                    let run = start..start + same;
                    let places = Points::Plain(&scratch.x[run.clone()], &scratch.y[run.clone()]);
                    let values = &mut values[run.start * channels..run.end * channels];
                    remap(self.isa, &jobs[usize::from(faces[start])], &places, values)?;
                    start = run.end;
                }
            }
            let place = ((rect.y + row - first) * self.size[0] + rect.x) * channels;
            let out = &mut out[place..place + rect.w * channels];
            if nx * ny == 1 {
                out.copy_from_slice(values);
                continue;
            }
            scratch.sums.resize(out.len(), <T as Sample>::Acc::default());
            compiled_for(self.isa, Mean { values, sums: &mut scratch.sums[..out.len()], out });
        }
        Ok(())
    }
}

/// For every point the first picture whose face it lies on, or else the nearest; its place there, squeezed along the
/// edge, goes to the front. `n` texels a side, and one around.
fn choose(x: &mut [f32], y: &mut [f32], faces: &mut Vec<u8>, points: usize, n: f64) {
    faces.clear();
    for i in 0..points {
        let mut best = (f64::INFINITY, 0, DVec2::ZERO);
        for k in 0..x.len() / points {
            let at = DVec2::new(f64::from(x[k * points + i]), f64::from(y[k * points + i]));
            // The outermost texels and those around are 1 and 0, n and n + 1.
            let q = (at - 0.5) / n * 2.0 - 1.0;
            let beyond = q.abs().max_element();
            if beyond < best.0 {
                best = (beyond, k, q);
            }
            if beyond <= 1.0 {
                break;
            }
        }
        let (beyond, face, q) = best;
        if beyond > 1.0 - 1.0 / n {
            let at = (along(q.clamp(DVec2::NEG_ONE, DVec2::ONE), n) + 1.0) * 0.5 * n + 0.5;
            (x[i], y[i]) = (at.x as f32, at.y as f32);
        } else {
            (x[i], y[i]) = (x[face * points + i], y[face * points + i]);
        }
        faces.push(face as u8);
    }
}

/// Means of several rows of values, one row after the other.
struct Mean<'s, T: Sample> {
    values: &'s [T],
    sums: &'s mut [T::Acc],
    out: &'s mut [T],
}

impl<T: Sample> Work for Mean<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let len = self.out.len();
        let (base, rest) = self.values.split_at(len);
        self.sums.fill(T::Acc::default());
        // Sums of differences: equal values give exactly that.
        for row in rest.chunks_exact(len) {
            for ((sum, value), base) in self.sums.iter_mut().zip(row).zip(base) {
                *sum = *sum + (value.get() - base.get());
            }
        }
        let share = T::Acc::of(1.0 / (self.values.len() / len) as f64);
        for ((out, sum), base) in self.out.iter_mut().zip(self.sums.iter()).zip(base) {
            *out = T::put(base.get() + *sum * share);
        }
    }
}
