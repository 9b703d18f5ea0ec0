//! Pixels one by one, each of its points where its own direction leads: around poles, rims and folds.

use super::grid::{Scatter, along_row};
use super::piece::{Number, four};
use super::tile::{Rect, Room, Show, Tiles};
use super::{Form, Numbers};
use crate::error::Result;
use crate::image::{AnyView, Element, Pixels, View};
use crate::kernel::remap::{Edge, Interpolation, Real, Sample};
use crate::mapping::{Face, SurfacePoint, Tangents};
use crate::sphere::along;
use glam::{DVec2, DVec3};

/// A picture, and a place in it, 0 to 1.
type Spot = (usize, DVec2);

/// Room that every pixel uses anew.
pub(super) struct Points<T, R> {
    spots: Vec<Spot>,
    codes: Vec<T>,
    fractions: Vec<[R; 2]>,
    numbers: Vec<R>,
    mean: Vec<R>,
    scratch: Vec<R>,
}

impl<T, R> Points<T, R> {
    pub fn new() -> Self {
        Self {
            spots: Vec::new(),
            codes: Vec::new(),
            fractions: Vec::new(),
            numbers: Vec::new(),
            mean: Vec::new(),
            scratch: Vec::new(),
        }
    }
}

impl<'a, T: Element + Sample> Tiles<'a, '_, T>
where
    View<'a, T>: Into<AnyView<'a>>,
    Pixels: From<Vec<T>>,
    Numbers<T>: Number,
{
    /// Fills the pixels of a rectangle.
    pub(super) fn singles(&self, rect: Rect, first: usize, out: &mut [T], room: &mut Room<T>) -> Result<()> {
        let channels = self.pictures.channels();
        for y in rect.y..rect.y + rect.h {
            for x in rect.x..rect.x + rect.w {
                let at = (y - first) * self.target.size[0] + x;
                let out = &mut out[at * channels..][..channels];
                self.single(y * self.target.size[0] + x, out, &mut room.points)?;
            }
        }
        Ok(())
    }

    fn single(&self, pixel: usize, out: &mut [T], room: &mut Points<T, Numbers<T>>) -> Result<()> {
        let channels = self.pictures.channels();
        room.spots.clear();
        let level = self.spots(pixel, &mut room.spots);
        let (edges, border) = (self.pictures.edges(), self.pictures.border());
        if room.spots.is_empty() {
            out.copy_from_slice(border);
            return Ok(());
        }
        let (size, frame) = self.pictures.level_size(level);
        let mut views: [Option<View<'_, T>>; 6] = [None; 6];
        room.codes.clear();
        room.fractions.clear();
        let nearest = self.show == Show::Centre(Interpolation::Nearest);
        for (face, uv) in &room.spots {
            let view = match views[*face] {
                Some(view) => view,
                None => *views[*face].insert(self.pictures.view(level, *face)?),
            };
            let place = *uv * size + frame - if nearest { 0.0 } else { 0.5 };
            let corner = place.floor();
            let whole = if place.is_finite() { corner.to_array().map(|x| x as i64) } else { [i64::MIN; 2] };
            let part = if place.is_finite() { place - corner } else { DVec2::ZERO };
            let edges = if place.is_finite() { edges } else { [Edge::Border; 2] };
            four(&view, whole.map(|x| x.clamp(-FAR, FAR)), edges, border, &mut room.codes);
            room.fractions.push([Numbers::<T>::of(part.x), Numbers::<T>::of(part.y)]);
        }
        if nearest {
            out.copy_from_slice(&room.codes[..channels]);
            return Ok(());
        }
        room.numbers.resize(room.codes.len(), Numbers::<T>::default());
        self.codec.decode_row(&room.codes, channels, &mut room.numbers);
        mean(&room.numbers, &room.fractions, channels, &mut room.mean);
        room.scratch.resize(channels, Numbers::<T>::default());
        self.codec.encode_row(self.isa, &room.mean, channels, out, &mut room.scratch);
        Ok(())
    }

    /// The places that a pixel is the mean of, and their level; none where there is no picture.
    fn spots(&self, pixel: usize, spots: &mut Vec<Spot>) -> usize {
        let middle =
            || self.target.point(pixel, DVec2::splat(0.5)).map(|d| self.spot(d, self.pictures.size().x));
        if self.show != Show::Mean {
            spots.extend(middle());
            return 0;
        }
        if let Some(four) = self.small(pixel) {
            spots.extend(four);
            return 0;
        }
        let Some((d, dd)) = self.target.direction(pixel, DVec2::splat(0.5), 1.0) else { return 0 };
        let scatter = self.scatter(d, dd);
        let n = self.pictures.level_size(scatter.level).0.x;
        // Where a disc ends within the pixel, the part that is there.
        let points = (0..scatter.count).filter_map(|k| self.target.point(pixel, scatter.place(k)));
        spots.extend(points.map(|d| self.spot(d, n)));
        if spots.is_empty() {
            spots.push(self.spot(d, n));
        }
        scatter.level
    }

    /// The four points of a pixel that is about as small as they say: their places are close, and the corners of a
    /// parallelogram.
    fn small(&self, pixel: usize) -> Option<[Spot; 4]> {
        /// Texels by which the last corner may be off.
        const BENT: f64 = 0.25;
        let size = self.pictures.size();
        let mut spots = [(0, DVec2::ZERO); 4];
        for (k, spot) in spots.iter_mut().enumerate() {
            *spot = self.spot(self.target.point(pixel, Scatter::SMALL.place(k))?, size.x);
        }
        let [a, b, c, d] = spots;
        if !spots.iter().all(|spot| spot.0 == a.0 && spot.1.is_finite()) {
            return None;
        }
        let shorter = DVec2::new(along_row(self.form, a.1.y), 1.0);
        let way = |from: Spot, to: Spot| {
            let mut way = to.1 - from.1;
            if self.map.is_periodic() {
                way.x -= way.x.round();
            }
            way * size * shorter
        };
        let (right, down) = (way(a, b), way(a, c));
        let footprint = [right, down].map(|x| x / Scatter::APART);
        let is_small = (way(c, d) - right).length() < BENT
            && Scatter::of(footprint, self.pictures.last_level()) == Scatter::SMALL;
        is_small.then_some(spots)
    }

    /// Where a direction leads: the picture, of `n` texels a side for a face, and the place in it.
    fn spot(&self, d: DVec3, n: f64) -> Spot {
        if matches!(self.form, Form::Cube(_)) {
            let face = Face::of(d);
            let at = face.project(d, [DVec3::ZERO; 2]).uv * 2.0 - 1.0;
            (face.index(), (along(at, n) + 1.0) * 0.5)
        } else {
            (0, self.map.place(d))
        }
    }

    fn scatter(&self, d: DVec3, dd: Tangents) -> Scatter {
        let mapped = if matches!(self.form, Form::Cube(_)) {
            Face::of(d).project(d, dd)
        } else {
            self.map.at(&SurfacePoint::new(d).moving(dd[0], dd[1]))
        };
        let size = self.pictures.size();
        let shorter = DVec2::new(along_row(self.form, mapped.uv.y), 1.0);
        // At most the whole picture.
        let rows =
            mapped.jacobian.m.map(|row| row.map(|x| if x.is_nan() { 0.0 } else { x.clamp(-1.0, 1.0) }));
        let column = |k: usize| DVec2::new(rows[0][k], rows[1][k]) * size * shorter;
        Scatter::of([column(0), column(1)], self.pictures.last_level())
    }
}

/// Farther out than any picture.
const FAR: i64 = 1 << 32;

/// The mean of points, each between four texels.
fn mean<R: Number>(numbers: &[R], fractions: &[[R; 2]], channels: usize, mean: &mut Vec<R>) {
    let share = R::of(1.0 / fractions.len() as f64);
    mean.clear();
    for c in 0..channels {
        let value = |k: usize| {
            let at = |i: usize| numbers[(4 * k + i) * channels + c];
            let [fx, fy] = fractions[k];
            let left = at(0) + fy * (at(2) - at(0));
            let right = at(1) + fy * (at(3) - at(1));
            left + fx * (right - left)
        };
        // Sums of differences: equal values give exactly that.
        let base = value(0);
        let sum = (1..fractions.len()).fold(R::default(), |sum, k| sum + (value(k) - base));
        mean.push(base + sum * share);
    }
}
