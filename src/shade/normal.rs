//! Normals from normal maps.

use glam::Vec3;

/// The unit normal that a map's vector (x, y, z) stands for: x T + y B + z N with B = sign · N × T.
///
/// N and T are taken as they were interpolated, neither normalised nor made perpendicular again: that is what
/// bakers assume (Mikkelsen 2008). `scale` multiplies x and y. N itself where nothing is left.
#[inline]
pub fn tangent_normal(n: Vec3, t: Vec3, sign: f32, vector: Vec3, scale: f32) -> Vec3 {
    let b = n.cross(t) * sign;
    let sum = t * (vector.x * scale) + b * (vector.y * scale) + n * vector.z;
    sum.try_normalize().unwrap_or_else(|| n.normalize_or(Vec3::Z))
}

/// Exponent and strength of a highlight on a surface whose normals differ within the pixel, from the length of
/// their mean.
///
/// The mean of unit normals is the shorter the more they differ, so the length of a filtered texel says how
/// rough the surface below the pixel is. For the exponent s of the half-vector, `s' = f s` with
/// `f = |n|/(|n| + s (1 - |n|))`, and (1 + s')/(1 + s) multiplies ks; a reflected ray turns twice as fast as the
/// normal, so that s = 4 p here. `slack` is the shortening that the codes' rounding explains.
///
/// Toksvig, "Mipmapping normal maps", Journal of Graphics Tools 2005.
#[inline]
pub fn toksvig(length: f32, p: f32, slack: f32) -> (f32, f32) {
    let (length, s) = ((length + slack).clamp(1e-3, 1.0), 4.0 * p);
    let f = length / (length + s * (1.0 - length));
    (f * p, (1.0 + f * s) / (1.0 + s))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_codes_change_nothing_and_mirrored_frames_turn_green() {
        let (n, t) = (Vec3::Z, Vec3::X);
        assert_eq!(tangent_normal(n, t, 1.0, Vec3::Z, 1.0), n);
        assert_eq!(tangent_normal(n, t, 1.0, Vec3::Y, 1.0), Vec3::Y);
        assert_eq!(tangent_normal(n, t, -1.0, Vec3::Y, 1.0), -Vec3::Y);
        assert_eq!(tangent_normal(n, t, 1.0, Vec3::X, 0.0), n);
    }

    #[test]
    fn rough_pixels_have_wide_weak_highlights() {
        assert_eq!(toksvig(1.0, 50.0, 0.0), (50.0, 1.0));
        let (p, strength) = toksvig(0.9, 50.0, 0.0);
        assert!((p - 0.9 * 50.0 / 20.9).abs() < 1e-4 && strength < 0.2);
    }
}
