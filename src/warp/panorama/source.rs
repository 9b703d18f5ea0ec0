//! What single pixels of a panorama are read from: a texture and the map to it, or a cube.

use super::super::{WarpOptions, texture, texture_options};
use super::Form;
use crate::encode::Format;
use crate::error::Result;
use crate::filter::Query;
use crate::footprint::Bend;
use crate::image::{AnyView, for_any};
use crate::jacobian::Jacobian;
use crate::mapping::{Mapping, SurfacePoint, Tangents};
use crate::sphere::{SphereTexture, over_pole};
use crate::texture::Texture;
use glam::DVec3;

/// The picture, ready for filters.
pub(super) enum Source<'a> {
    One(One<'a>),
    Cube(Box<SphereTexture>),
}

/// One picture and the map to it; of an equirectangular one also the rows next to both poles, as they go on beyond.
pub(super) struct One<'a> {
    /// The picture, then the upper and the lower cap.
    pub textures: Vec<Texture<'a>>,
    pub map: Box<dyn Mapping>,
    /// Rows of a cap that belong to the picture.
    rows: usize,
}

/// The query of a place that there is not.
pub(super) const NOWHERE: Query =
    Query { s: f64::NAN, t: f64::NAN, jacobian_tx: Jacobian::ZERO, index: 0, bend: Bend::None };

impl<'a> Source<'a> {
    /// Takes an image of this form; `border` is in codes. `near` texels from a pole there may be pixels that look over it.
    pub fn new(
        image: AnyView<'a>,
        form: Form,
        border: &[f64],
        options: &WarpOptions,
        near: f64,
    ) -> Result<Self> {
        let format = Format::new(options.encoding, options.alpha, image.channels())?;
        if let Form::Cube(layout) = form {
            let options = texture_options(image, format, border, options);
            return Ok(Self::Cube(Box::new(SphereTexture::cube(image, layout, options)?)));
        }
        let map = form.mapping("image", image.width(), image.height())?;
        let options = WarpOptions { wrap: form.wrap(), ..options.clone() };
        let mut one = One { textures: vec![texture(image, format, border, &options)?], map, rows: 0 };
        if form == Form::Equirect {
            // A NaN or infinite wish is for all rows.
            one.rows = (2.0 * near).ceil().clamp(1.0, image.height() as f64) as usize;
            for lower in [false, true] {
                let cap = for_any!(AnyView, image, view => over_pole(&view, one.rows, lower))?;
                one.textures
                    .push(Texture::new(cap.view(), texture_options(image, format, border, &options))?);
            }
        }
        Ok(Self::One(one))
    }
}

impl One<'_> {
    /// Which texture a direction meets, where, and what it covers there.
    pub fn query(&self, d: DVec3, dd: Tangents) -> (usize, Query) {
        let mapped = self.map.at(&SurfacePoint::new(d).moving(dd[0], dd[1]));
        let (w, h) = (self.textures[0].width() as f64, self.textures[0].height() as f64);
        let j = Jacobian::new(mapped.jacobian.m.map(bounded));
        let query = Query {
            s: mapped.uv.x * w,
            t: mapped.uv.y * h,
            jacobian_tx: j.scaled(w, h),
            index: 0,
            bend: Bend::None,
        };
        let rows = self.rows as f64;
        if query.t < 0.5 * rows {
            (1, Query { t: query.t + rows, ..query })
        } else if query.t > h - 0.5 * rows {
            (2, Query { t: query.t - (h - rows), ..query })
        } else {
            (0, query)
        }
    }
}

/// A row of a Jacobian that spans at most the whole picture: at a pole the footprint is the whole ring.
fn bounded(row: [f64; 2]) -> [f64; 2] {
    let row = row.map(|x| x.clamp(-1.0, 1.0));
    let length = row[0].hypot(row[1]);
    if length > 1.0 { row.map(|x| x / length) } else { row }
}
