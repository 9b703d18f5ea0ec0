//! Derivatives of the reconstruction.

use super::Coordinate;
use super::batch::TILE;
use crate::error::{Error, Result};
use crate::filter::{Cubic, Filter, Reader, bicubic_gradient, bilinear_gradient};
use crate::image::Element;
use crate::kernel::Isa;
use crate::num::{Real, RealsMut};
use crate::par;
use crate::texel::{DType, f16};
use crate::texture::{Decode, Plain, Texture};

/// Derivatives of the reconstruction by u and v: `out` receives `texture.channels()` pairs a point.
///
/// `filter` is [`Filter::Bilinear`] (on the line through texel centres the slope towards larger coordinates),
/// [`Filter::Bicubic`] or [`Filter::Mitchell`]. Straight colour `P/A` has the derivative `(P' - (P/A) A')/A`.
/// A coordinate that is not finite gives 0.
///
/// # Errors
/// [`Error::Value`] when lengths do not fit together or the filter is another.
pub fn gradient<U: Coordinate, O: Real>(
    texture: &Texture<'_>,
    filter: Filter,
    uv: &[U],
    out: &mut [O],
) -> Result<()> {
    let samples = uv.len() / 2;
    if uv.len() != 2 * samples || out.len() != samples * texture.channels() * 2 {
        let expected = format!("2 numbers a point and {} results a point", texture.channels() * 2);
        return Err(Error::value("uv", format!("{} numbers and room for {}", uv.len(), out.len()), expected));
    }
    if !matches!(filter, Filter::Bilinear | Filter::Bicubic | Filter::Mitchell) {
        return Err(Error::value(
            "filter",
            format!("{filter:?}"),
            "\"bilinear\", \"bicubic\" or \"mitchell\"",
        ));
    }
    let place = |i: usize| [uv[2 * i].into(), uv[2 * i + 1].into()];
    match O::tagged(out) {
        RealsMut::F32(out) => by_dtype(texture, filter, &place, out),
        RealsMut::F64(out) => by_dtype(texture, filter, &place, out),
    }
}

/// u and v of point `i`.
type Place<'a> = dyn Fn(usize) -> [f64; 2] + Sync + 'a;

fn by_dtype<O: Real>(texture: &Texture<'_>, filter: Filter, place: &Place<'_>, out: &mut [O]) -> Result<()> {
    match texture.stored_dtype() {
        DType::U8 => typed::<u8, O>(texture, filter, place, out),
        DType::U16 => typed::<u16, O>(texture, filter, place, out),
        DType::F16 => typed::<f16, O>(texture, filter, place, out),
        DType::F32 => typed::<f32, O>(texture, filter, place, out),
        DType::F64 => typed::<f64, O>(texture, filter, place, out),
    }
}

fn typed<T: Element, O: Real>(
    texture: &Texture<'_>,
    filter: Filter,
    place: &Place<'_>,
    out: &mut [O],
) -> Result<()> {
    let size = [texture.width() as f64, texture.height() as f64];
    let channels = texture.channels();
    for group in 0..texture.num_groups() {
        let layers = texture.layers::<T>(group, false)?;
        let isa = Isa::current();
        par::for_pixels(out.len() / (2 * channels), out.chunks_mut(TILE * channels * 2), |tile, out| {
            let mut put = |slopes: &dyn Fn(f64, f64) -> [[T::Real; 2]; 4]| {
                for (k, out) in out.chunks_exact_mut(channels * 2).enumerate() {
                    let [u, v] = place(tile * TILE + k);
                    let (s, t) = (u * size[0], v * size[1]);
                    let [wu, wv] = texture.wrap();
                    let signs = [wu.reduce(s, size[0]).1, wv.reduce(t, size[1]).1];
                    for (out, pair) in out[8 * group..].chunks_exact_mut(2).zip(slopes(s, t)) {
                        for axis in 0..2 {
                            out[axis] = O::from_f64(pair[axis].to_f64() * size[axis] * signs[axis]);
                        }
                    }
                }
            };
            if layers.decoder.is_plain() {
                let reader = Reader::new(&layers, Plain { full_scale: layers.decoder.full_scale }, isa);
                put(&|s, t| slopes(&reader, filter, s, t));
            } else {
                let reader = Reader::new(&layers, layers.decoder, isa);
                put(&|s, t| slopes(&reader, filter, s, t));
            }
            Ok(())
        })?;
    }
    Ok(())
}

/// Derivatives of each lane's result by s and t.
fn slopes<T: Element, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    filter: Filter,
    s: f64,
    t: f64,
) -> [[T::Real; 2]; 4] {
    if !(s.is_finite() && t.is_finite()) {
        return [[T::Real::ZERO; 2]; 4];
    }
    let [value, ds, dt] = match filter {
        Filter::Bilinear => bilinear_gradient(r, s, t),
        Filter::Mitchell => bicubic_gradient(r, Cubic::MITCHELL, s, t),
        _ => bicubic_gradient(r, Cubic::CATMULL_ROM, s, t),
    };
    let (ds, dt) = (r.finish_slope(value, ds), r.finish_slope(value, dt));
    std::array::from_fn(|lane| [ds[lane], dt[lane]])
}
