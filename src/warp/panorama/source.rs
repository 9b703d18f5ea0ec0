//! What a panorama is read from: one texture, or the six faces of a cube, each with its neighbours' texels around it.

use super::super::{WarpOptions, border_codes, texture, texture_options};
use super::Form;
use crate::encode::Format;
use crate::error::Result;
use crate::filter::Query;
use crate::image::{AnyView, Image, Pixels, View, for_any};
use crate::jacobian::Jacobian;
use crate::mapping::{Cube, Face, Layout, Mapping, SurfacePoint, Tangents};
use crate::texel::Texel;
use crate::texture::Texture;
use crate::wrap::Wrap;
use glam::{DVec2, DVec3};

/// The pictures and the map to them.
pub(super) enum Source<'a> {
    One { texture: Texture<'a>, map: Box<dyn Mapping> },
    Faces { textures: Vec<Texture<'static>>, cube: Cube },
}

/// The query of a place that there is not.
pub(super) const NOWHERE: Query = Query { s: f64::NAN, t: f64::NAN, jacobian_tx: Jacobian::ZERO, index: 0 };

impl<'a> Source<'a> {
    /// Takes an image of this form.
    pub fn new(image: AnyView<'a>, form: Form, options: &WarpOptions) -> Result<Self> {
        let (width, height) = (image.width(), image.height());
        let map = form.mapping("image", width, height)?;
        let format = Format::new(options.encoding, options.alpha, image.channels())?;
        let border = border_codes(image.dtype(), image.channels(), options)?;
        let Form::Cube(layout) = form else {
            let options = WarpOptions { wrap: form.wrap(), ..options.clone() };
            return Ok(Self::One { texture: texture(image, format, &border, &options)?, map });
        };
        let n = width / layout.cells().0;
        let options = WarpOptions { wrap: [Wrap::Extend; 2], ..options.clone() };
        let face_texture = |face: Face| {
            let picture = for_any!(AnyView, image, view => padded(&view, layout, face, n))?;
            Texture::new(picture.view(), texture_options(image, format, &border, &options))
        };
        let textures = Face::ALL.into_iter().map(face_texture).collect::<Result<_>>()?;
        Ok(Self::Faces { textures, cube: Cube::new(layout, DVec3::ZERO)? })
    }

    /// The textures, in the order of [`Source::query`]'s first answer.
    pub fn textures(&self) -> &[Texture<'_>] {
        match self {
            Self::One { texture, .. } => std::slice::from_ref(texture),
            Self::Faces { textures, .. } => textures,
        }
    }

    /// Which texture a direction meets, where, and what it covers there.
    pub fn query(&self, d: DVec3, dd: Tangents) -> (usize, Query) {
        let point = SurfacePoint::new(d).moving(dd[0], dd[1]);
        let (index, mapped) = match self {
            Self::One { map, .. } => (0, map.at(&point)),
            Self::Faces { cube, .. } => match cube.face_at(&point) {
                Some((face, mapped)) => (face.index(), mapped),
                None => return (0, NOWHERE),
            },
        };
        let texture = &self.textures()[index];
        let (w, h) = (texture.width() as f64, texture.height() as f64);
        let j = Jacobian::new(mapped.jacobian.m.map(bounded));
        (index, Query { s: mapped.uv.x * w, t: mapped.uv.y * h, jacobian_tx: j.scaled(w, h), index: 0 })
    }
}

/// A row of a Jacobian that spans at most the whole picture: at a pole the footprint is the whole ring.
fn bounded(row: [f64; 2]) -> [f64; 2] {
    let row = row.map(|x| x.clamp(-1.0, 1.0));
    let length = row[0].hypot(row[1]);
    if length > 1.0 { row.map(|x| x / length) } else { row }
}

/// One face with one texel of its neighbours around it; each corner takes a texel of one of them.
fn padded<T: Texel>(view: &View<'_, T>, layout: Layout, face: Face, n: usize) -> Result<Image>
where
    Pixels: From<Vec<T>>,
{
    /// How far outside the face its neighbours are looked for, in faces.
    const STEP: f64 = 1e-9;
    let texel = |face: Face, i: usize, j: usize| {
        let (column, row) = layout.cell(face);
        view.pixel(column * n + i, row * n + j)
    };
    let cube = Cube::new(layout, DVec3::ZERO)?;
    let mut data = Vec::with_capacity((n + 2) * (n + 2) * view.channels());
    for j in 0..n + 2 {
        for i in 0..n + 2 {
            let place = |k: usize| match k {
                0 => -STEP,
                k if k == n + 1 => 1.0 + STEP,
                k => (k as f64 - 0.5) / n as f64,
            };
            let outside = cube
                .face_inverse(face, DVec2::new(place(i), place(j)))
                .and_then(|at| cube.face_at(&SurfacePoint::new(at.p)));
            let (found, st) = outside.map_or((face, DVec2::ZERO), |(f, mapped)| (f, mapped.uv));
            let index = |x: f64| ((x * n as f64) as usize).min(n - 1);
            data.extend_from_slice(texel(found, index(st.x), index(st.y)));
        }
    }
    Image::new(n + 2, n + 2, view.channels(), data)
}
