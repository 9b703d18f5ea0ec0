//! From stored numbers to the numbers that are filtered, written from the definitions.

use super::options::{Alpha, Encoding};
use crate::error::{Error, Result};
use crate::image::{AnyView, View};
use crate::texel::Texel;

/// All texels as f64, in linear light and multiplied by alpha; rows packed, channels interleaved.
pub(super) fn decode(image: AnyView<'_>, encoding: Encoding, alpha: Alpha) -> Result<Vec<f64>> {
    let channels = image.channels();
    if alpha != Alpha::None && channels != 2 && channels != 4 {
        return Err(Error::value("alpha", format!("{channels} channel(s) with alpha"), "2 or 4 channels"));
    }
    if encoding == Encoding::Normal && channels != 3 && channels != 4 {
        return Err(Error::value("encoding", format!("normals of {channels} channel(s)"), "3 or 4 channels"));
    }
    Ok(match image {
        AnyView::U8(view) => texels(view, 255.0, true, encoding, alpha),
        AnyView::U16(view) => texels(view, 65_535.0, true, encoding, alpha),
        AnyView::F16(view) => texels(view, 1.0, false, encoding, alpha),
        AnyView::F32(view) => texels(view, 1.0, false, encoding, alpha),
        AnyView::F64(view) => texels(view, 1.0, false, encoding, alpha),
    })
}

fn texels<T: Texel>(
    view: View<'_, T>,
    full: f64,
    integer: bool,
    encoding: Encoding,
    alpha: Alpha,
) -> Vec<f64> {
    let channels = view.channels();
    let mut all = Vec::with_capacity(view.width() * view.height() * channels);
    for y in 0..view.height() {
        for x in 0..view.width() {
            let stored = view.pixel(x, y);
            let colours = all.len();
            for (c, code) in stored.iter().enumerate() {
                let code = code.to_f64();
                // The second of two and the fourth of four channels are no colour.
                let colour = !matches!((channels, c), (2, 1) | (4, 3));
                all.push(match encoding {
                    Encoding::Srgb if colour => light(code / full),
                    Encoding::Normal if colour && integer => {
                        // Codes run from -1 at 1 over 0 at the middle code to +1 at the largest.
                        let middle = (full + 1.0) / 2.0;
                        f64::max((code - middle) / (full - middle), -1.0)
                    }
                    Encoding::Normal if colour => 2.0 * code - 1.0,
                    _ => code / full,
                });
            }
            if alpha == Alpha::Straight {
                let opacity = all[colours + channels - 1];
                for colour in &mut all[colours..colours + channels - 1] {
                    *colour *= opacity;
                }
            }
        }
    }
    all
}

/// Linear light of an sRGB value (IEC 61966-2-1), odd about zero.
fn light(value: f64) -> f64 {
    if value < 0.0 {
        return -light(-value);
    }
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}
