//! The cube: six textures whose levels continue on their neighbours.
//!
//! Every level of a face has the nearest texels of its neighbours around it, in a corner the mean of the three texels
//! that meet. Such a texel is the neighbour's, whose grid stands at an angle: in the face's own frame its place
//! is not one texel past the last, but further from the face's middle along the edge, by a factor of 1 + 1/n. On the way
//! there, `f` texels past the last one of the face, the coordinate along the edge is divided by 1 + f/n before it is
//! looked up ([`along`]). Then both faces have the same value on their edge, to rounding, and a linear function is met to
//! second order, on all levels.
//!
//! A footprint that might read past the edge is not left to the filter, whose picture ends there: it is a mean of
//! bilinear probes, each a direction of its own with the face that it meets. `anisotropic` keeps its weights and levels;
//! so do the isotropic mipmap filters, which follow footprints up to [`STRETCH`] widths long, because that is how long a
//! round one becomes on a face; `ewa` its Gaussian; the means over the footprint (`area`, `exact`, `sat`, `stochastic`,
//! `auto`) are a grid of up to [`MOST`] probes a side, two a texel.
//!
//! Two faces see one footprint at different stretches, so each would lay its line or grid of probes differently. Around an
//! edge the lines and grids of both are mixed, half and half on the edge itself ([`Box6::spots`]), and nothing turns there.

use super::{Look, NOWHERE, Read, finite};
use crate::error::{Error, Result};
use crate::filter::{Filter, Query};
use crate::footprint::Bend;
use crate::image::{AnyView, View, for_any};
use crate::jacobian::Axes;
use crate::lod;
use crate::mapping::{Cube, Face, Layout, Mapped, SurfacePoint, Tangents};
use crate::num::log2;
use crate::sampler::Sampler;
use crate::texture::{Texture, TextureOptions, matched_faces};
use glam::{DVec2, DVec3};

/// Probes a side of a grid, at most.
const MOST: f64 = 32.0;
/// Texels a side of a grid on the level that it reads, at most.
const SIDE: f64 = 8.0;
/// Share of half a face within which the probes of neighbours are mixed in, at most.
const MIXED: f64 = 0.75;
/// How far past a face its neighbours are looked for, in faces.
const STEP: f64 = 1e-9;
/// Half the width of the ellipse of `ewa` in pixels, and where its weights end.
const ELLIPSE: f64 = 0.782_53;
/// How much longer than wide a round footprint becomes on a face, at most: the square root of 3, in the corners.
pub(super) const STRETCH: f64 = 2.0;
/// Length of the footprint from which `auto` shows the mean alone.
const FULL: f64 = 1.25;

/// The faces.
#[derive(Debug)]
pub(super) struct Box6 {
    faces: [Texture<'static>; 6],
    cube: Cube,
    n: f64,
    last_level: usize,
}

/// Where a direction meets its face.
struct Spot {
    face: usize,
    query: Query,
    /// Texels from the nearest edge.
    from_edge: f64,
    axes: Axes,
}

impl Box6 {
    pub fn new(image: AnyView<'_>, layout: Layout, options: TextureOptions) -> Result<Self> {
        let (columns, rows) = layout.cells();
        let n = image.width() / columns;
        if n == 0 || [image.width(), image.height()] != [columns * n, rows * n] {
            let got = format!("{}x{} (width x height)", image.width(), image.height());
            return Err(Error::value("image", got, format!("{columns} by {rows} square cells")));
        }
        let cube = Cube::new(layout, DVec3::ZERO)?;
        let view = |face: Face| -> Result<AnyView<'_>> {
            let (column, row) = layout.cell(face);
            for_any!(AnyView, image, v => {
                let start = row * n * v.row_stride() + column * n * v.channels();
                Ok(View::new(&v.data()[start..], n, n, v.channels(), v.row_stride())?.into())
            })
        };
        let [a, b, c, d, e, f] = Face::ALL.map(view);
        let neighbour = |face: usize, at: [i64; 2], n: usize| neighbour(&cube, Face::ALL[face], at, n);
        let faces = matched_faces([a?, b?, c?, d?, e?, f?], &options, &neighbour)?;
        let last_level = faces[0].num_levels() - 1;
        Ok(Self { faces, cube, n: n as f64, last_level })
    }

    pub fn textures(&self) -> &[Texture<'static>] {
        &self.faces
    }

    fn spot(&self, d: DVec3, dd: Tangents) -> Option<Spot> {
        let (face, mapped) = self.cube.face_at(&SurfacePoint::new(d).moving(dd[0], dd[1]))?;
        Some(self.spot_on(face, mapped))
    }

    fn spot_on(&self, face: Face, mapped: Mapped) -> Spot {
        let (s, t) = (mapped.uv.x * self.n, mapped.uv.y * self.n);
        let jacobian_tx = mapped.jacobian.scaled(self.n, self.n);
        let from_edge = s.min(self.n - s).min(t).min(self.n - t);
        let query = Query { s, t, jacobian_tx, index: 0, bend: Bend::None };
        Spot { face: face.index(), query, from_edge, axes: jacobian_tx.axes() }
    }

    /// The look-ups of a unit direction and its tangents.
    pub fn plan(&self, sampler: &Sampler, d: DVec3, dd: Tangents, looks: &mut Vec<Look>) {
        if !finite(dd) {
            return self.probe(d, self.last_level as f32, 1.0, looks);
        }
        let Some(spot) = self.spot(d, dd) else { return looks.push(NOWHERE) };
        let isotropic = matches!(sampler.filter, Filter::Trilinear | Filter::LinearMipmapNearest);
        let read = if isotropic { Read::Line(spot.face) } else { Read::Own(spot.face) };
        let own = |weight: f64| Look { read, query: spot.query, weight };
        let grown = f64::from(sampler.lod_bias).exp2();
        let nearest = d.abs().max_element();
        // A face stretches by no more than the square of the distance to its plane; the same on both sides of an edge.
        let reach = self.n * dd[0].length().hypot(dd[1].length()) * grown / (nearest * nearest) + 2.0;
        // What a filter reads around the place, in texels.
        let margin = match sampler.filter {
            Filter::Nearest | Filter::NearestMipmapNearest | Filter::NearestMipmapLinear => 0.0,
            Filter::Bilinear => 0.5,
            Filter::Bicubic | Filter::Mitchell => 1.5,
            _ => reach,
        };
        if spot.from_edge >= margin {
            return looks.push(own(1.0));
        }
        match sampler.filter {
            Filter::Bicubic | Filter::Mitchell => {
                // Sharp inside, bilinear where one row of neighbours is all there is.
                let share = (spot.from_edge - 0.5).clamp(0.0, 1.0);
                if share > 0.0 {
                    looks.push(own(share));
                }
                self.probe(d, 0.0, 1.0 - share, looks);
            }
            Filter::Bilinear => self.probe(d, 0.0, 1.0, looks),
            Filter::LinearMipmapNearest | Filter::Trilinear => {
                let sampler = Sampler { max_anisotropy: STRETCH, ..*sampler };
                self.spots(d, dd, reach, |spot, share| self.line(&sampler, d, dd, spot, share, looks));
            }
            Filter::Anisotropic => {
                self.spots(d, dd, reach, |spot, share| self.line(sampler, d, dd, spot, share, looks));
            }
            Filter::Auto if sampler.tolerance.is_none() => {
                self.spots(d, dd, reach, |spot, share| {
                    let x = ((spot.axes.sigma1 * grown - 1.0) / (FULL - 1.0)).clamp(0.0, 1.0);
                    let full = x * x * (3.0 - 2.0 * x);
                    if full < 1.0 {
                        self.probe(d, 0.0, (1.0 - full) * share, looks);
                    }
                    if full > 0.0 {
                        self.grid(d, dd, spot, grown, false, full * share, looks);
                    }
                });
            }
            filter => self.spots(d, dd, reach, |spot, share| {
                self.grid(d, dd, spot, grown, filter == Filter::Ewa, share, looks);
            }),
        }
    }

    /// The footprint on the faces that lie within `reach` texels, each with its share: all of it far from edges, a half on an
    /// edge, a third in a corner.
    fn spots(&self, d: DVec3, dd: Tangents, reach: f64, mut look: impl FnMut(&Spot, f64)) {
        let reach = reach.min(MIXED * 0.5 * self.n);
        let nearest = d.abs().max_element();
        let nearness = |face: Face| {
            let beyond = 0.5 * self.n * (1.0 - face.frame()[2].dot(d) / nearest);
            (1.0 - beyond / reach).max(0.0)
        };
        let total: f64 = Face::ALL.into_iter().map(nearness).sum();
        for face in Face::ALL {
            let share = nearness(face) / total;
            if share > 0.0 {
                look(&self.spot_on(face, face.project(d, dd)), share);
            }
        }
    }

    /// The look-up of a mipmap filter on a level of detail.
    pub fn level(&self, sampler: &Sampler, d: DVec3, lod: f32, looks: &mut Vec<Look>) {
        let lod = lod::clamp(lod, self.last_level);
        let nearest = sampler.filter == Filter::LinearMipmapNearest;
        self.probe(d, if nearest { lod::nearest(lod) as f32 } else { lod }, 1.0, looks);
    }

    /// A trilinear probe of weight `weight`.
    fn probe(&self, d: DVec3, lod: f32, weight: f64, looks: &mut Vec<Look>) {
        let Some(spot) = self.spot(d, [DVec3::ZERO; 2]) else { return looks.push(NOWHERE) };
        let (level, fraction) = lod::split(lod::clamp(lod, self.last_level));
        for (level, share) in [(level, 1.0 - fraction), (level + 1, fraction)] {
            if share > 0.0 {
                let size = self.faces[0].width() >> level;
                let at = DVec2::new(spot.query.s, spot.query.t) / self.n * 2.0 - 1.0;
                let at = (along(at, size.max(1) as f64) + 1.0) * 0.5 * self.n;
                let query = Query { s: at.x, t: at.y, ..spot.query };
                let read = Read::Level(spot.face, level as f32);
                looks.push(Look { read, query, weight: weight * f64::from(share) });
            }
        }
    }

    /// The probes of the anisotropic filter, each where its direction leads.
    fn line(
        &self,
        sampler: &Sampler,
        d: DVec3,
        dd: Tangents,
        spot: &Spot,
        share: f64,
        looks: &mut Vec<Look>,
    ) {
        let Axes { sigma1, sigma2, major } = spot.axes;
        let width = sigma2.max(sigma1 / sampler.max_anisotropy.min(1024.0));
        let lod = log2(width as f32) + sampler.lod_bias;
        let ratio = sigma1 / width;
        if sigma1 <= 1.0 || ratio.is_nan() || ratio <= 1.0 {
            return self.probe(d, lod, share, looks);
        }
        let half = ((ratio - 1.0) / 2.0).ceil();
        let weight = |i: f64| (0.5 * ratio + 0.5 - i.abs()).clamp(0.0, 1.0);
        let inner = half - 1.0;
        let second_moment =
            inner * (inner + 1.0) * (2.0 * inner + 1.0) / 3.0 + 2.0 * weight(half) * half * half;
        if second_moment == 0.0 {
            return self.probe(d, lod, share, looks);
        }
        let spacing = ((ratio * ratio - 1.0) / 12.0 / (second_moment / ratio)).sqrt() / ratio;
        // What the whole major axis adds to the direction: the pixel's direction that the Jacobian stretches most.
        let [[a, b], [c, e]] = spot.query.jacobian_tx.m;
        let pixel = [(a * major[0] + c * major[1]) / sigma1, (b * major[0] + e * major[1]) / sigma1];
        let step = (dd[0] * pixel[0] + dd[1] * pixel[1]) * spacing;
        let mut i = -half;
        while i <= half {
            if weight(i) > 0.0 {
                self.probe(d + step * i, lod, share * weight(i) / ratio, looks);
            }
            i += 1.0;
        }
    }

    /// A grid of probes over the pixel, or over the ellipse that stands for it.
    #[expect(clippy::too_many_arguments, reason = "one call for all means over a footprint")]
    fn grid(
        &self,
        d: DVec3,
        dd: Tangents,
        spot: &Spot,
        grown: f64,
        gaussian: bool,
        share: f64,
        looks: &mut Vec<Look>,
    ) {
        let extent = if gaussian { 2.0 * ELLIPSE } else { 1.0 };
        let dd = dd.map(|x| x * grown * extent);
        let [[a, b], [c, e]] = spot.query.jacobian_tx.m.map(|row| row.map(|x| x * grown * extent));
        let columns = [a.hypot(c), b.hypot(e)];
        let (short, long) = (columns[0].min(columns[1]), columns[0].max(columns[1]));
        let lod = log2((short / SIDE).max(long / (0.5 * MOST)) as f32).max(0.0);
        let probes = columns.map(|x| (2.0 * x / f64::from(lod).exp2()).ceil().clamp(2.0, MOST));
        let at = |i: f64, n: f64| (i + 0.5) / n - 0.5;
        let weight = |x: f64, y: f64| {
            let r2 = 4.0 * (x * x + y * y);
            if !gaussian {
                1.0
            } else if r2 >= 1.0 {
                0.0
            } else {
                (-2.0 * r2).exp() - (-2.0f64).exp()
            }
        };
        let places = || {
            (0..probes[1] as usize).flat_map(move |j| {
                (0..probes[0] as usize).map(move |i| (at(i as f64, probes[0]), at(j as f64, probes[1])))
            })
        };
        let total: f64 = places().map(|(x, y)| weight(x, y)).sum();
        for (x, y) in places() {
            let weight = weight(x, y);
            if weight > 0.0 {
                self.probe(d + dd[0] * x + dd[1] * y, lod, share * weight / total, looks);
            }
        }
    }
}

/// A place on a face, in -1..=1, as a place among its texels and those around it, `n` a side: what lies between the
/// outermost texels and the edge is drawn together along the edge. Corners and edges stay where they are.
pub(crate) fn along(at: DVec2, n: f64) -> DVec2 {
    let last = 1.0 - 1.0 / n;
    let squeeze = |x: f64, other: f64| {
        let by = 1.0 + 0.5 * (other.abs() - last).max(0.0);
        let (size, limit) = (x.abs(), last * by);
        let squeezed =
            if size <= limit { size / by } else { last + (size - limit) * (1.0 - last) / (1.0 - limit) };
        squeezed.copysign(x)
    };
    DVec2::new(squeeze(at.x, at.y), squeeze(at.y, at.x))
}

/// The texel of another face that continues this one.
pub(crate) fn neighbour(cube: &Cube, face: Face, at: [i64; 2], n: usize) -> (usize, [usize; 2]) {
    let place = |i: i64| match i {
        -1 => -STEP,
        i if i == n as i64 => 1.0 + STEP,
        i => (i as f64 + 0.5) / n as f64,
    };
    let beyond = cube.face_inverse(face, DVec2::new(place(at[0]), place(at[1])));
    let met = beyond.and_then(|at| cube.face_at(&SurfacePoint::new(at.p)));
    let index = |x: f64| ((x * n as f64) as usize).min(n - 1);
    met.map_or((face.index(), [0; 2]), |(face, mapped)| {
        (face.index(), [index(mapped.uv.x), index(mapped.uv.y)])
    })
}
