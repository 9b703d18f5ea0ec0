//! From a pixel's place and footprint to its colour, one filter a file.

use crate::error::{Error, Result};
use crate::footprint::Bend;
use crate::jacobian::Jacobian;
use crate::kernel::Isa;
use crate::kernel::cast::same;
use crate::kernel::lanes::Lanes;
use crate::kernel::plane::Plane;
use crate::kernel::spot::Grid;
use crate::num::Real;
use crate::texel::{DType, Texel};
use crate::texture::{Decode, Layers};
use crate::wrap::Wrap;

mod anisotropic;
mod area;
mod auto;
mod bicubic;
mod bilinear;
mod effort;
mod ewa;
mod exact;
mod mipmap;
mod nearest;
mod passing;
mod probes;
mod rows;
mod sat;
mod stochastic;
mod sum;

pub(crate) use anisotropic::anisotropic;
pub(crate) use area::area;
use area::blended;
pub use auto::mean_share;
pub(crate) use auto::{Shape, Shapes, auto, auto_within, is_smooth};
pub(crate) use bicubic::{Cubic, bicubic, bicubic_gradient};
pub(crate) use bilinear::{bilinear, bilinear_gradient};
pub use effort::Effort;
pub(crate) use effort::effort;
pub(crate) use ewa::ewa;
pub(crate) use exact::exact;
pub(crate) use mipmap::mipmap;
pub(crate) use nearest::nearest;
pub(crate) use passing::passing;
pub(crate) use probes::{BLOCK, Block, Probes, Samples, Scratch};
pub(crate) use sat::sat;
pub(crate) use stochastic::stochastic;

/// Which filter a sampler uses. Names in Python are those of [`Filter::NAMES`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Filter {
    /// The cheapest filter that is good enough.
    #[default]
    Auto,
    /// The texel under the pixel's centre.
    Nearest,
    /// Linear interpolation of the four texels around the pixel's centre.
    Bilinear,
    /// Cubic interpolation by Catmull and Rom: sharp, exact for quadratics.
    Bicubic,
    /// The cubic of Mitchell and Netravali (B = C = 1/3): little ringing, little blur.
    Mitchell,
    /// Nearest texel of the nearest level.
    NearestMipmapNearest,
    /// Bilinear on the nearest level.
    LinearMipmapNearest,
    /// Nearest texels of two levels, blended.
    NearestMipmapLinear,
    /// Bilinear on two levels, blended: GL's linear_mipmap_linear.
    Trilinear,
    /// Trilinear probes along the footprint's major axis.
    Anisotropic,
    /// Gaussian weights over the ellipse that stands for the footprint.
    Ewa,
    /// The mean over the upright rectangle around the footprint, from a summed-area table.
    Sat,
    /// The mean over the footprint, fast and nearly exact.
    Area,
    /// The mean of the bilinear reconstruction over the footprint, exact to rounding.
    Exact,
    /// One random texel whose expectation is [`Filter::Exact`].
    Stochastic,
}

impl Filter {
    /// All filters with their names.
    pub const NAMES: &'static [(&'static str, Self)] = &[
        ("auto", Self::Auto),
        ("nearest", Self::Nearest),
        ("bilinear", Self::Bilinear),
        ("bicubic", Self::Bicubic),
        ("mitchell", Self::Mitchell),
        ("nearest_mipmap_nearest", Self::NearestMipmapNearest),
        ("linear_mipmap_nearest", Self::LinearMipmapNearest),
        ("nearest_mipmap_linear", Self::NearestMipmapLinear),
        ("trilinear", Self::Trilinear),
        ("linear_mipmap_linear", Self::Trilinear),
        ("anisotropic", Self::Anisotropic),
        ("ewa", Self::Ewa),
        ("sat", Self::Sat),
        ("area", Self::Area),
        ("exact", Self::Exact),
        ("stochastic", Self::Stochastic),
    ];

    /// The filter of this name.
    ///
    /// # Errors
    /// [`Error::Value`] for any other word.
    pub fn parse(name: &str) -> Result<Self> {
        Self::NAMES.iter().find(|(n, _)| *n == name).map(|(_, f)| *f).ok_or_else(|| {
            let names: Vec<_> = Self::NAMES.iter().map(|(n, _)| format!("{n:?}")).collect();
            Error::value("filter", format!("{name:?}"), format!("one of {}", names.join(", ")))
        })
    }

    /// Whether the filter reads levels beyond the first.
    pub fn uses_levels(self) -> bool {
        !matches!(
            self,
            Self::Nearest | Self::Bilinear | Self::Bicubic | Self::Mitchell | Self::Sat | Self::Stochastic
        )
    }

    /// Whether the filter is a mean over the pixel's true shape, where that is no parallelogram.
    pub fn follows_shape(self) -> bool {
        matches!(self, Self::Auto | Self::Area | Self::Exact)
    }

    /// Whether the filter is the bilinear reconstruction wherever the footprint is at most a texel.
    pub fn magnifies_bilinearly(self) -> bool {
        matches!(
            self,
            Self::Auto
                | Self::Bilinear
                | Self::LinearMipmapNearest
                | Self::Trilinear
                | Self::Anisotropic
                | Self::Sat
        )
    }
}

/// A place in the texture and the footprint around it, in texels of level 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Query {
    /// Along u: texel `i` covers `i..i+1`. Finite.
    pub s: f64,
    /// Along v, likewise.
    pub t: f64,
    /// Texels per pixel.
    pub jacobian_tx: Jacobian,
    /// Which sample of its batch it is: what tells random numbers apart.
    pub index: u64,
    /// What the Jacobian does not tell of the pixel's shape.
    pub bend: Bend,
}

/// A finite number beyond 1e30 cut to that, and one below 1e-30 to zero.
#[inline(always)]
pub(crate) fn bounded(x: f64) -> f64 {
    let size = x.abs();
    let cut = if x < 0.0 { -1e30 } else { 1e30 };
    let x = if (size > 1e30) & (size <= f64::MAX) { cut } else { x };
    if size < 1e-30 { 0.0 } else { x }
}

impl Query {
    /// A point at the origin.
    pub const NOWHERE: Self =
        Self { s: 0.0, t: 0.0, jacobian_tx: Jacobian::ZERO, index: 0, bend: Bend::None };

    /// The footprint grown by `bias` octaves; a level of detail given outright makes it a square.
    pub fn with_lod(self, lod: Option<f32>, bias: f32) -> Self {
        if lod.is_none() && bias == 0.0 {
            return self;
        }
        let (jacobian, octaves) = match lod {
            Some(lod) => (Jacobian::IDENTITY, f64::from(lod) + f64::from(bias)),
            None => (self.jacobian_tx, f64::from(bias)),
        };
        let scale = octaves.exp2();
        Self { jacobian_tx: jacobian.scaled(scale, scale), bend: Bend::None, ..self }.bounded()
    }

    /// The place and footprint of part (i, j) of the pixel cut into `parts`.
    pub fn part(&self, parts: [u32; 2], at: [u32; 2]) -> Self {
        let size = parts.map(|n| 1.0 / f64::from(n));
        let d = [0, 1].map(|k| (f64::from(at[k]) + 0.5) * size[k] - 0.5);
        let [ds, dt] = self.bend.offset(self.jacobian_tx, d);
        let m = self.bend.jacobian(self.jacobian_tx, d).m.map(|[x, y]| [x * size[0], y * size[1]]);
        let (s, t) = (self.s + ds, self.t + dt);
        Self { s, t, jacobian_tx: Jacobian::new(m), bend: Bend::None, ..*self }.bounded()
    }

    /// The same with finite derivatives beyond 1e30 texels a pixel cut to that, and those below 1e-30 to zero:
    /// no texture is that large, and squares and quotients of what is left stay finite.
    #[inline(always)]
    pub fn bounded(mut self) -> Self {
        for x in self.jacobian_tx.m.iter_mut().flatten() {
            *x = bounded(*x);
        }
        self
    }
}

/// One group of channels, opened for reading: texels by wrapped index, decoded.
pub(crate) struct Reader<'a, T: Texel, D> {
    pub layers: &'a Layers<'a, T>,
    /// The instruction set of the kernels.
    pub isa: Isa,
    decode: D,
    outside: [T::Real; 4],
    /// The border colour as bytes, where averages are averages of bytes and it is one, or where there is no border.
    outside_bytes: Option<[u8; 4]>,
    /// Texels of each level per texel of level 0, along u and v.
    scale: Vec<[f64; 2]>,
    /// Each level with the next coarser one.
    grids: Vec<Grid>,
}

impl<'a, T: Texel, D: Decode<T>> Reader<'a, T, D> {
    /// Opens `layers`, whose codes `decode` understands.
    pub fn new(layers: &'a Layers<'a, T>, decode: D, isa: Isa) -> Self {
        let base = &layers.planes[0];
        let scale = layers
            .planes
            .iter()
            .map(|p| {
                [f64::from(p.width) / f64::from(base.width), f64::from(p.height) / f64::from(base.height)]
            })
            .collect();
        let grids = (0..layers.planes.len()).map(|level| grid(&layers.planes, level)).collect();
        let outside = decode.outside(layers.border);
        let bytes = outside.map(|x| x.to_f64() as u8);
        let has_border = layers.wrap.contains(&Wrap::Border);
        let is_byte = |(x, byte): (T::Real, u8)| x.to_f64() == f64::from(byte);
        let fits = !has_border || outside.into_iter().zip(bytes).all(is_byte);
        let outside_bytes = (D::CODES && T::DTYPE == DType::U8 && fits).then_some(bytes);
        Self { layers, isa, decode, outside, outside_bytes, scale, grids }
    }

    /// A level whose averages are averages of bytes, and the border colour.
    #[inline(always)]
    fn bytes(&self, level: usize) -> Option<(Plane<'_, u8>, [u8; 4])> {
        let outside = self.outside_bytes?;
        let &Plane { data, origin, row, lanes, channels, width, height, columns, rows } =
            &self.layers.planes[level];
        let data = same(data)?;
        Some((Plane { data, origin, row, lanes, channels, width, height, columns, rows }, outside))
    }

    /// Index of the coarsest level.
    pub fn last_level(&self) -> usize {
        self.layers.planes.len() - 1
    }

    /// The place (s, t) of level 0 on another level: reduced by the wrap mode's period, then clamped to
    /// where the picture still changes.
    #[inline(always)]
    fn on_level(&self, level: usize, s: f64, t: f64) -> (f64, f64) {
        let (base, plane) = (&self.layers.planes[0], &self.layers.planes[level]);
        let [kx, ky] = self.scale[level];
        let s = self.layers.wrap[0].reduce(s, base.width.into()).0 * kx;
        let t = self.layers.wrap[1].reduce(t, base.height.into()).0 * ky;
        // Beyond one texel outside, a wrap mode that does not repeat shows one colour.
        (s.clamp(-1.0, f64::from(plane.width) + 1.0), t.clamp(-1.0, f64::from(plane.height) + 1.0))
    }

    /// The decoded texel at any place.
    #[inline]
    fn tap(&self, level: usize, x: i32, y: i32) -> [T::Real; 4] {
        let plane = &self.layers.planes[level];
        let [wu, wv] = self.layers.wrap;
        let at = (wu.index(x.into(), plane.width.into()), wv.index(y.into(), plane.height.into()));
        match at {
            (Some(x), Some(y)) => self.decode.texel(plane.texel(x as i32, y as i32)),
            _ => self.outside,
        }
    }

    /// The decoded texel at any place of level 0, quickly where it is in the picture or its apron.
    #[inline(always)]
    fn near(&self, x: i32, y: i32) -> [T::Real; 4] {
        let plane = &self.layers.planes[0];
        if plane.is_readable(x, y) { self.decode.texel(plane.texel(x, y)) } else { self.tap(0, x, y) }
    }

    /// The 2x2 decoded texels from (x, y) on, row by row.
    #[inline(always)]
    fn taps(&self, level: usize, x: i32, y: i32) -> [[T::Real; 4]; 4] {
        let plane = &self.layers.planes[level];
        if plane.covers(x, y, x + 1, y + 1) {
            let [a, b, c, d] = plane.quad(x, y);
            [self.decode.texel(a), self.decode.texel(b), self.decode.texel(c), self.decode.texel(d)]
        } else {
            self.taps_outside(level, x, y)
        }
    }

    /// As [`Reader::taps`], where some of them lie beyond the plane.
    #[cold]
    fn taps_outside(&self, level: usize, x: i32, y: i32) -> [[T::Real; 4]; 4] {
        [
            self.tap(level, x, y),
            self.tap(level, x + 1, y),
            self.tap(level, x, y + 1),
            self.tap(level, x + 1, y + 1),
        ]
    }

    /// The texels of a level that begin at `at` and one texel further, decoded.
    #[inline(always)]
    fn pair<L: Lanes>(&self, level: usize, at: usize) -> L {
        let plane = &self.layers.planes[level];
        // Lanes, not codes, are what the two ways have in common: codes would be carried one by one.
        match plane.packed_pair(at) {
            Some(codes) => self.decode.pair(codes),
            None => self.decode.pair(&plane.pair(at)),
        }
    }

    /// An average as a result.
    #[inline(always)]
    pub fn finish(&self, average: [T::Real; 4]) -> [T::Real; 4] {
        self.decode.finish(average)
    }

    /// The derivative of the result, from the average and its derivative.
    pub fn finish_slope(&self, average: [T::Real; 4], slope: [T::Real; 4]) -> [T::Real; 4] {
        self.decode.finish_slope(average, slope)
    }

    /// The border colour as an average.
    pub fn outside(&self) -> [T::Real; 4] {
        self.outside
    }
}

/// How places are found on a level and the next.
fn grid<T: Texel>(planes: &[Plane<'_, T>], level: usize) -> Grid {
    let base = &planes[0];
    let two = [&planes[level], planes.get(level + 1).unwrap_or(&planes[level])];
    // Offsets of a larger plane are no numbers of 32 bits: all its texels are looked for one by one.
    let fits = two.map(|p| p.data.len() < i32::MAX as usize);
    let each = |along: &dyn Fn(usize, usize) -> i32| [along(0, 0), along(0, 1), along(1, 0), along(1, 1)];
    let size = each(&|k, axis| [two[k].width, two[k].height][axis]);
    let full = [base.width, base.height].map(f64::from);
    Grid {
        scale: std::array::from_fn(|i| f64::from(size[i]) / full[i % 2]),
        most: size.map(|n| f64::from(n) + 1.0),
        first: each(&|k, axis| if fits[k] { [two[k].columns.0, two[k].rows.0][axis] } else { i32::MAX }),
        last: each(&|k, axis| [two[k].columns.1, two[k].rows.1][axis] - 1),
        stride: each(&|k, axis| if fits[k] { [two[k].lanes, two[k].row][axis] as i32 } else { 0 }),
    }
}

/// `a + t (b - a)` in every lane.
#[inline(always)]
fn lerp4<R: Real>(a: [R; 4], b: [R; 4], t: R) -> [R; 4] {
    use crate::num::lerp;
    [lerp(a[0], b[0], t), lerp(a[1], b[1], t), lerp(a[2], b[2], t), lerp(a[3], b[3], t)]
}

/// The whole and the fractional part of a coordinate.
#[inline(always)]
fn whole_and_part<R: Real>(x: f64) -> (i32, R) {
    let whole = crate::num::floor(x);
    (whole as i32, R::from_f64(x - whole as f64))
}
