//! Latitude and longitude: one picture that goes on over both poles.
//!
//! ```text
//!   rows 0 .. H      the picture, up at the top
//!   rows H .. 2H     the picture upside down and turned by half a turn: what lies beyond the lower pole
//!   and around       row -1 is row 2H - 1: what lies beyond the upper pole
//! ```
//! Both axes repeat, so every filter and every level reads across the seam and the poles as inside. A width that is
//! odd is turned by the mean of two texels.
//!
//! Near a pole the pixel is cut into up to [`MOST_PARTS`] squared parts, each with its own place and Jacobian; the
//! isotropic mipmap filters, which would blur there along the meridian, fade into `anisotropic` between 26 and 46 degrees of latitude; a
//! row of a Jacobian is cut to the whole ring, whose average an unbounded footprint is. A point within half a texel
//! of a pole: along the meridian the picture is interpolated between the texels on both sides, `even + t odd`, `t` the
//! distance from the pole in half texels; the even part fades to the ring's mean, `ring + t (even - ring)`, so that
//! all longitudes agree on the pole.

use super::{Look, Read, finite};
use crate::error::Result;
use crate::filter::{Filter, Query};
use crate::footprint::Bend;
use crate::image::{AnyView, Image, Pixels, View, for_any};
use crate::jacobian::Jacobian;
use crate::mapping::{Equirect, Mapping, SurfacePoint, Tangents};
use crate::sampler::Sampler;
use crate::texel::Texel;
use crate::texture::{Texture, TextureOptions};
use crate::wrap::Wrap;
use glam::DVec3;

/// Parts a side into which a pixel is cut at most.
const MOST_PARTS: f64 = 16.0;
/// Angle, in radians, over which the map counts as straight.
const STRAIGHT: f64 = 0.1;
/// Parts a side are this times the pixel's reach over its distance from the pole.
const BEND: f64 = 4.0;
/// Lengths of a ring, as a share of the equator, between which isotropic filters become lines of probes.
const ROUND: f64 = 0.9;
/// See [`ROUND`].
const STRETCHED: f64 = 0.7;
/// Footprints of one texel and this more, by rounding, are one texel.
const SLACK: f64 = 1e-6;

/// The picture, twice as high, and the means of its first and last row.
#[derive(Debug)]
pub(super) struct Globe {
    texture: [Texture<'static>; 1],
    rings: [Vec<f64>; 2],
}

impl Globe {
    pub fn new(image: AnyView<'_>, options: TextureOptions) -> Result<Self> {
        crate::image::check_size("image", image.width(), 2 * image.height(), image.channels())?;
        let both = for_any!(AnyView, image, view => over_pole(&view, view.height(), true))?;
        let options = TextureOptions { wrap: [Wrap::Repeat; 2], ..options };
        let texture = Texture::new(both.view(), options)?;
        let (width, height) = (texture.width() as f64, image.height() as f64);
        let ring = |t: f64| {
            let whole = Jacobian::new([[width, 0.0], [0.0, 0.0]]);
            let query = Query { s: 0.0, t, jacobian_tx: whole, index: 0, bend: Bend::None };
            let mut mean = vec![0f64; texture.channels()];
            let exact = Sampler::new(Filter::Exact);
            exact.sample_places(&texture, 1, &|_| (query, None), &mut mean).map(|()| mean)
        };
        let rings = [ring(0.5)?, ring(height - 0.5)?];
        Ok(Self { texture: [texture], rings })
    }

    pub fn textures(&self) -> &[Texture<'static>] {
        &self.texture
    }

    pub fn rings(&self) -> &[Vec<f64>; 2] {
        &self.rings
    }

    /// A look-up of weight `weight`. Where the map stretches texels along a ring, the isotropic filters would blur
    /// across it: towards the poles they fade into lines of probes.
    fn look(&self, filter: Filter, query: Query, weight: f64, looks: &mut Vec<Look>) {
        let isotropic = matches!(filter, Filter::Trilinear | Filter::LinearMipmapNearest);
        let height = 0.5 * self.texture[0].height() as f64;
        let ring = (query.t / height * std::f64::consts::PI).sin().abs();
        let line = if isotropic { ((ROUND - ring) / (ROUND - STRETCHED)).clamp(0.0, 1.0) } else { 0.0 };
        for (read, share) in [(Read::Own(0), 1.0 - line), (Read::Line(0), line)] {
            if share > 0.0 {
                looks.push(Look { read, query, weight: weight * share });
            }
        }
    }

    /// The look-ups of a unit direction and its tangents.
    pub fn plan(&self, sampler: &Sampler, d: DVec3, dd: Tangents, looks: &mut Vec<Look>) {
        let texture = &self.texture[0];
        let (w, h) = (texture.width() as f64, 0.5 * texture.height() as f64);
        let query = |d: DVec3, dd: Tangents| {
            let mapped = Equirect.at(&SurfacePoint::new(d).moving(dd[0], dd[1]));
            let j = Jacobian::new(mapped.jacobian.m.map(at_most_a_turn));
            Query {
                s: mapped.uv.x * w,
                t: mapped.uv.y * h,
                jacobian_tx: j.scaled(w, h),
                index: 0,
                bend: Bend::None,
            }
        };
        if !finite(dd) {
            let middle = query(d, [DVec3::ZERO; 2]);
            let endless = Jacobian::new([[f64::INFINITY; 2]; 2]);
            let query = Query { jacobian_tx: endless, ..middle };
            return looks.push(Look { read: Read::Own(0), query, weight: 1.0 });
        }
        let middle = query(d, dd);
        let mut own = |query: Query, weight: f64| self.look(sampler.filter, query, weight, looks);
        let averages = !matches!(
            sampler.filter,
            Filter::Nearest | Filter::Bilinear | Filter::Bicubic | Filter::Mitchell
        );
        let count = if averages { parts(d, dd, middle.jacobian_tx) } else { 1.0 };
        if count > 1.0 {
            // Between two whole numbers one grid fades into the other.
            let fraction = count.fract();
            for (k, share) in [(count.floor(), 1.0 - fraction), (count.floor() + 1.0, fraction)] {
                if share == 0.0 {
                    continue;
                }
                let weight = share / (k * k);
                let at = |i: usize| (i as f64 + 0.5) / k - 0.5;
                for i in 0..(k * k) as usize {
                    let d = d + dd[0] * at(i % k as usize) + dd[1] * at(i / k as usize);
                    own(query(d, dd.map(|x| x / k)), weight);
                }
            }
            return;
        }
        own(middle, 1.0);
        let from_pole = middle.t.min(h - middle.t);
        let interpolates = !matches!(
            sampler.filter,
            Filter::Nearest | Filter::NearestMipmapNearest | Filter::NearestMipmapLinear | Filter::Stochastic
        );
        if from_pole < 0.5 && interpolates {
            let pole = usize::from(middle.t > 0.5 * h);
            let weight = 1.0 - 2.0 * from_pole;
            let on_pole = Query { t: pole as f64 * h, jacobian_tx: Jacobian::ZERO, ..middle };
            looks.push(Look { read: Read::Ring(pole), query: on_pole, weight });
            looks.push(Look { read: Read::Level(0, 0.0), query: on_pole, weight: -weight });
        }
    }
}

/// Into how many parts a side a pixel around `d` is cut, so that the map is close to linear on each.
fn parts(d: DVec3, dd: Tangents, jacobian_tx: Jacobian) -> f64 {
    // A pixel within a texel is one look-up: there is nothing in it to average.
    let most = (jacobian_tx.axes().sigma1 - SLACK).max(1.0);
    let reach = dd[0].length().max(dd[1].length());
    let wanted = (BEND * reach / d.x.hypot(d.z)).max(reach / STRAIGHT);
    // A NaN or infinite wish ends at the limit.
    wanted.clamp(1.0, MOST_PARTS).min(most)
}

/// A row of a Jacobian that spans at most the whole ring.
fn at_most_a_turn(row: [f64; 2]) -> [f64; 2] {
    let row = row.map(|x| x.clamp(-1.0, 1.0));
    let length = row[0].hypot(row[1]);
    if length > 1.0 { row.map(|x| x / length) } else { row }
}

/// `rows` rows next to a pole, and beyond the pole the same rows mirrored and turned by half a turn: those of the upper
/// pole below their mirror image, those of the lower pole above it.
pub(crate) fn over_pole<T: Texel>(view: &View<'_, T>, rows: usize, lower: bool) -> Result<Image>
where
    Pixels: From<Vec<T>>,
{
    let (width, height, channels) = (view.width(), view.height(), view.channels());
    let mut data = Vec::with_capacity(2 * rows * width * channels);
    let turned = |data: &mut Vec<T>, y: usize| {
        let row = view.row(y);
        let texel = |x: usize| &row[x % width * channels..][..channels];
        for x in 0..width {
            let across = texel(x + width / 2);
            if width.is_multiple_of(2) {
                data.extend_from_slice(across);
            } else {
                let next = texel(x + width / 2 + 1);
                let mean = |(a, b): (&T, &T)| T::from_f64(0.5 * (a.to_f64() + b.to_f64()));
                data.extend(across.iter().zip(next).map(mean));
            }
        }
    };
    if lower {
        (height - rows..height).for_each(|y| data.extend_from_slice(view.row(y)));
        (height - rows..height).rev().for_each(|y| turned(&mut data, y));
    } else {
        (0..rows).rev().for_each(|y| turned(&mut data, y));
        (0..rows).for_each(|y| data.extend_from_slice(view.row(y)));
    }
    Image::new(width, 2 * rows, channels, data)
}
