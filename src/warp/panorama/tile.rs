//! The fast way through a panorama: rectangles of pixels on which the map is a pair of cubics.
//!
//! In a rectangle of up to [`SIDE`] squared pixels whose map [`Chart`] meets, every pixel is the mean over upright boxes that
//! stand for it or for its parts ([`Parts`]), by the vector kernels of `remap` (`fill.rs`); next to the edges of a cube's
//! faces, of a regular grid of points ([`Grid`]). Where pixels are large a coarser level is read.
//! Rectangles that the cubics do not meet are cut into squares; those of [`LEAST`] pixels (around poles, rims and folds)
//! are filled pixel by pixel (`single.rs`).

use super::chart::{Chart, PLACES, places};
use super::fill::{Places, Values};
use super::grid::{Grid, Parts, along_row};
use super::pictures::Pictures;
use super::piece::Number;
use super::single::Points;
use super::{Form, Numbers, Target};
use crate::error::Result;
use crate::image::{AnyView, Element, Pixels, View};
use crate::kernel::Isa;
use crate::kernel::remap::{Interpolation, Sample};
use crate::mapping::{Face, Mapping};
use crate::pyramid::Codec;
use glam::{DMat2, DVec2, DVec3};

/// Pixels a side of a rectangle, at most.
pub(super) const SIDE: usize = 64;
/// Pixels a side of a rectangle that is not cut any more.
const LEAST: usize = 4;
/// Largest error of the cubics, in texels.
const TEXELS: f64 = 1.0 / 64.0;
/// Or in pixels, where means are taken.
const SHARE: f64 = 1.0 / 32.0;
/// How far too inexact a rectangle is that is to be cut once.
const ONE_STEP: f64 = 2.0;
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
pub(super) struct Tiles<'a, 'm, T: Sample> {
    pub pictures: Pictures<'a, T>,
    pub form: Form,
    pub map: &'m dyn Mapping,
    pub target: Target<'m>,
    pub show: Show,
    pub codec: Codec,
    /// Whether codes may be averaged as they stand.
    pub is_plain: bool,
    /// The border's colour, decoded.
    pub border: Vec<Numbers<T>>,
    pub isa: Isa,
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rect {
    pub x: usize,
    pub y: usize,
    pub w: usize,
    pub h: usize,
}

/// The map of a rectangle to one picture of the source, in texels of its first level.
pub(super) struct Sheet {
    pub face: usize,
    pub chart: Chart,
    /// Whether texels around a face may be read.
    pub edge: bool,
}

/// What is known of a rectangle; else how many times less exact than allowed it is.
type Sheets = std::result::Result<Vec<Sheet>, f64>;

/// Room that every rectangle uses anew.
pub(super) struct Room<T: Sample>
where
    Numbers<T>: Number,
{
    pub places: Places,
    pub codes: Values<T>,
    pub numbers: Values<Numbers<T>>,
    pub gathered: Vec<T>,
    pub pieces: Vec<Vec<Numbers<T>>>,
    pub scratch: Vec<Numbers<T>>,
    pub points: Points<T, Numbers<T>>,
}

impl<T: Sample> Room<T>
where
    Numbers<T>: Number,
{
    fn new() -> Self {
        Self {
            places: Places::default(),
            codes: Values::new(),
            numbers: Values::new(),
            gathered: Vec::new(),
            pieces: Vec::new(),
            scratch: Vec::new(),
            points: Points::new(),
        }
    }
}

impl<'a, T: Element + Sample> Tiles<'a, '_, T>
where
    View<'a, T>: Into<AnyView<'a>>,
    Pixels: From<Vec<T>>,
    Numbers<T>: Number,
{
    /// Fills the rows from `first` on.
    pub fn band(&self, first: usize, out: &mut [T]) -> Result<()> {
        let width = self.target.size[0];
        let rows = out.len() / (width * self.pictures.channels());
        let mut room = Room::new();
        for x in (0..width).step_by(SIDE) {
            for y in (0..rows).step_by(SIDE) {
                let rect = Rect { x, y: first + y, w: SIDE.min(width - x), h: SIDE.min(rows - y) };
                self.rect(rect, first, out, &mut room)?;
            }
        }
        Ok(())
    }

    fn rect(&self, rect: Rect, first: usize, out: &mut [T], room: &mut Room<T>) -> Result<()> {
        let excess = match self.sheets(rect) {
            Ok(sheets) => return self.fill(rect, &sheets, first, out, room),
            Err(excess) => excess,
        };
        if rect.w.max(rect.h) <= LEAST {
            return self.singles(rect, first, out, room);
        }
        // The error of cubics falls with the fourth power of the sides.
        let wanted = (excess.log2() / 4.0).ceil();
        let halvings = if wanted.is_finite() { wanted.clamp(1.0, 2.0) as u32 } else { 1 };
        let side = (rect.w.max(rect.h).next_power_of_two() >> halvings).max(LEAST);
        for y in (0..rect.h).step_by(side) {
            for x in (0..rect.w).step_by(side) {
                let (w, h) = (side.min(rect.w - x), side.min(rect.h - y));
                self.rect(Rect { x: rect.x + x, y: rect.y + y, w, h }, first, out, room)?;
            }
        }
        Ok(())
    }

    /// The maps of a rectangle, one for each picture of the source that it meets, or how far too inexact they would be.
    fn sheets(&self, rect: Rect) -> Sheets {
        /// Pixels by which corners are drawn in, so that they lie on one side of the line between two pieces.
        const IN: f64 = 1e-6;
        let Rect { x, y, w, h } = rect;
        let size = DVec2::new(self.target.size[0] as f64, self.target.size[1] as f64);
        let (corner, sides) = (DVec2::new(x as f64, y as f64), DVec2::new(w as f64, h as f64));
        let uv = |p: DVec2| (corner + (p + 1.0) * 0.5 * (sides - 2.0 * IN) + IN) / size;
        let piece = |x: f64, y: f64| self.target.form.piece(uv(DVec2::new(x, y)));
        let own = piece(-1.0, -1.0).ok_or(ONE_STEP)?;
        if [(1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].into_iter().any(|(x, y)| piece(x, y) != Some(own)) {
            return Err(ONE_STEP);
        }
        let mut directions = [DVec3::ZERO; PLACES];
        for (d, p) in directions.iter_mut().zip(places()) {
            *d = self.target.rotation * self.target.map.unplace(uv(p)).ok_or(ONE_STEP)?;
        }
        if matches!(self.form, Form::Cube(_)) {
            return self.cube_sheets(rect, &directions);
        }
        let texels = self.pictures.size();
        let whole = [texels.x as usize, texels.y as usize];
        let mut values = [DVec2::ZERO; PLACES];
        let mut patch = None;
        for (value, d) in values.iter_mut().zip(directions) {
            let uv = self.map.place(d);
            let here = self.form.patch(d, uv, whole).ok_or(ONE_STEP)?;
            if !uv.is_finite() || *patch.get_or_insert(here) != here {
                return Err(ONE_STEP);
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
        Ok(vec![Sheet { face: 0, chart: self.chart(rect, &values)?, edge: false }])
    }

    /// The polynomials, where they are the map.
    fn chart(&self, rect: Rect, values: &[DVec2; PLACES]) -> std::result::Result<Chart, f64> {
        Chart::fit(values, |chart, p, off| {
            let texels = off.abs().max_element() / TEXELS;
            if texels <= 1.0 || self.show != Show::Mean {
                return texels;
            }
            let [x, y] = chart.footprint(rect, p);
            let pixels = DMat2::from_cols(x, y).inverse() * off;
            // Where a pixel has no area the texels count.
            if pixels.is_finite() { texels.min(pixels.abs().max_element() / SHARE) } else { texels }
        })
    }

    fn cube_sheets(&self, rect: Rect, directions: &[DVec3; PLACES]) -> Sheets {
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
                    return Err(ONE_STEP);
                }
                *value = uv * n;
            }
            let inside = |v: &DVec2| v.min_element() > EDGE && v.max_element() < n - EDGE;
            let edge = !values.iter().all(inside);
            Ok(Sheet { face: face.index(), chart: self.chart(rect, &values)?, edge })
        };
        met.iter().map(sheet).collect()
    }

    /// The points of the pixels of a rectangle.
    pub(super) fn grid(&self, rect: Rect, sheet: &Sheet) -> Grid {
        if self.show != Show::Mean {
            return Grid::CENTRE;
        }
        let alike = self.alike(sheet);
        let shorter = DVec2::new(alike, 1.0);
        let footprints = footprints(rect, sheet).map(|sides| sides.map(|x| x * shorter));
        Grid::of(footprints.into_iter(), self.pictures.last_level())
    }

    /// The boxes of the pixels of a rectangle.
    pub(super) fn parts(&self, rect: Rect, sheet: &Sheet) -> Parts {
        Parts::of(&footprints(rect, sheet), self.alike(sheet), self.pictures.last_level())
    }

    /// [`along_row`] in the middle of a rectangle.
    fn alike(&self, sheet: &Sheet) -> f64 {
        along_row(self.form, sheet.chart.at(DVec2::ZERO).y / self.pictures.size().y)
    }
}

/// What a pixel right and a pixel down add, in texels of the first level, in the middle and the corners of a rectangle.
fn footprints(rect: Rect, sheet: &Sheet) -> [[DVec2; 2]; 5] {
    let places = [[0.0, 0.0], [-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]].map(DVec2::from_array);
    places.map(|p| sheet.chart.footprint(rect, p))
}

impl Chart {
    /// What a pixel right and a pixel down add at a place of a rectangle.
    pub(super) fn footprint(&self, rect: Rect, p: DVec2) -> [DVec2; 2] {
        let [x, y] = self.slopes(p);
        [x * (2.0 / rect.w as f64), y * (2.0 / rect.h as f64)]
    }
}
