//! Alpha tests in the distance: the share of texels that pass stays the base's.
//!
//! Castaño, "Computing alpha mipmaps", 2010, scales alpha by one factor a level. Where many texels have the
//! same alpha one factor cannot pass just some of them, so texels that would come out on the wrong side are
//! moved to the nearest code on the right one: exactly `round(share * texels)` pass on every level. Among
//! equal alphas those pass whose neighbourhood is more opaque.

use super::Target;
use super::build::Plane;
use super::codec::Real;
use crate::encode::{Alpha, Format, decode, encode};
use crate::image::View;
use crate::texel::Texel;

/// The share of texels with alpha of at least `threshold`.
pub(super) fn share<T: Texel>(base: View<'_, T>, format: Format, threshold: f64) -> f64 {
    let limit = threshold * T::DTYPE.full_scale();
    let alpha = format.channels - 1;
    let passing: usize = (0..base.height())
        .map(|y| {
            base.row(y).chunks_exact(base.channels()).filter(|texel| texel[alpha].to_f64() >= limit).count()
        })
        .sum();
    passing as f64 / (base.width() as f64 * base.height() as f64)
}

/// The least code that passes and the greatest that does not.
fn codes<T: Texel>(threshold: f64) -> (T, T) {
    let limit = threshold * T::DTYPE.full_scale();
    if T::DTYPE.is_integer() {
        let least = limit.ceil();
        return (T::from_f64(least), T::from_f64(least - 1.0));
    }
    let above = |x: f64| T::from_f64(x).to_f64() >= limit;
    // Relative steps from a thousandth of the finest type's spacing up to the coarsest's.
    let mut step = limit * 1e-19;
    let (mut pass, mut fail) = (limit, limit);
    while !above(pass) || above(fail) {
        if !above(pass) {
            pass = limit + step;
        }
        if above(fail) {
            fail = limit - step;
        }
        step *= 2.0;
    }
    (T::from_f64(pass), T::from_f64(fail))
}

/// Rewrites alpha (and premultiplied colour) of a finished level.
pub(super) fn restore<T: Texel, R: Real>(
    plane: &Plane<R>,
    target: &mut Target<'_, T>,
    lanes: usize,
    format: Format,
    threshold: f64,
    share: f64,
) {
    let (width, height, channels) = (plane.width, plane.height, plane.channels);
    let full = T::DTYPE.full_scale();
    let alpha = |x: usize, y: usize| plane.numbers[(y * width + x) * channels + channels - 1].to_f64() / full;
    let around = |x: usize, y: usize| {
        let mut sum = 0.0;
        for ny in y.saturating_sub(1)..=(y + 1).min(height - 1) {
            for nx in x.saturating_sub(1)..=(x + 1).min(width - 1) {
                sum += alpha(nx, ny);
            }
        }
        sum
    };
    let total = width * height;
    let passing = (share * total as f64).round() as usize;
    let mut order: Vec<usize> = (0..total).collect();
    let rank = |&i: &usize, &k: &usize| {
        let (p, q) = ((i % width, i / width), (k % width, k / width));
        alpha(q.0, q.1)
            .total_cmp(&alpha(p.0, p.1))
            .then_with(|| around(q.0, q.1).total_cmp(&around(p.0, p.1)))
            .then(i.cmp(&k))
    };
    let mut passes = vec![passing == total; total];
    let mut scale = 1.0;
    if passing > 0 && passing < total {
        let (least, last, rest) = order.select_nth_unstable_by(passing - 1, rank);
        let best = rest.iter().min_by(|a, b| rank(a, b)).copied().unwrap_or(*last);
        let middle = 0.5 * (alpha(*last % width, *last / width) + alpha(best % width, best / width));
        if middle > 0.0 {
            scale = threshold / middle;
        }
        passes[*last] = true;
        least.iter().for_each(|&i| passes[i] = true);
    }
    let (pass, fail) = codes::<T>(threshold);
    for y in 0..height {
        let row = &mut target.data[target.origin + y * target.row_stride..][..width * lanes];
        for (x, texel) in row.chunks_exact_mut(lanes).enumerate() {
            let before = alpha(x, y);
            let code = T::from_f64((before * scale).clamp(0.0, before.max(1.0)) * full);
            let good = code.to_f64() >= pass.to_f64();
            let code = match (passes[y * width + x], good) {
                (true, false) => pass,
                (false, true) => fail,
                _ => code,
            };
            if format.alpha == Alpha::Premultiplied && before > 0.0 {
                let gain = code.to_f64() / full / before;
                for (c, code) in texel[..channels - 1].iter_mut().enumerate() {
                    *code = scaled(*code, format, c, gain);
                }
            }
            texel[channels - 1] = code;
        }
    }
}

fn scaled<T: Texel>(code: T, format: Format, c: usize, gain: f64) -> T {
    let (encoding, dtype) = (format.channel_encoding(c), T::DTYPE);
    T::from_f64(encode(encoding, dtype, decode(encoding, dtype, code.to_f64()) * gain))
}
