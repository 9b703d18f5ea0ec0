//! How a texel meets the colour that is there, and one picture another.

use crate::mesh::Blend;

/// Straight colour and alpha after a texel; formulas at [`Blend`].
///
/// ```
/// use multum::mesh::Blend;
/// use multum::shade::blend;
/// let label = [1.0, 0.0, 0.0, 0.25];
/// assert_eq!(blend(Blend::Decal, [0.0, 1.0, 0.0, 1.0], label), [0.25, 0.75, 0.0, 1.0]);
/// ```
#[inline]
pub fn blend(mode: Blend, before: [f32; 4], texel: [f32; 4]) -> [f32; 4] {
    let a = texel[3];
    let mix = |f: fn(f32, f32, f32) -> f32, alpha: f32| {
        let [r, g, b] = std::array::from_fn(|c| f(before[c], texel[c], a));
        [r, g, b, alpha]
    };
    match mode {
        Blend::Modulate => mix(|c, t, _| c * t, before[3] * a),
        Blend::Replace => texel,
        Blend::Decal => mix(|c, t, a| c * (1.0 - a) + t * a, before[3]),
        Blend::Add => mix(|c, t, _| c + t, before[3] * a),
    }
}

/// Premultiplied `front` over premultiplied `back`.
///
/// Porter and Duff, "Compositing digital images", SIGGRAPH 1984.
#[inline]
pub fn over(front: [f32; 4], back: [f32; 4]) -> [f32; 4] {
    let rest = 1.0 - front[3];
    std::array::from_fn(|c| front[c] + rest * back[c])
}
