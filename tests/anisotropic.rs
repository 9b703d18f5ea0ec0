//! Footprints that are round to the last bit, and all but round.

use multum::{Extent, Filter, Image, Sampler, Texture, TextureOptions};

#[test]
fn nearly_round_footprints_are_finite_and_all_but_trilinear() -> multum::Result<()> {
    let pixels: Vec<f32> = (0..64).map(|i| (i * 37 % 64) as f32 / 63.0).collect();
    let image = Image::new(8, 8, 1, pixels)?;
    let texture = Texture::new(image.view(), TextureOptions::default())?;
    let sample = |filter, jacobian: &[f64; 4]| -> multum::Result<f32> {
        let mut out = [0f32];
        Sampler { filter, ..Sampler::default() }.sample(
            &texture,
            &[0.43, 0.61],
            Extent::Jacobian(jacobian),
            &mut out,
        )?;
        Ok(out[0])
    };
    for i in 0..20_000 {
        let (sin, cos) = (f64::from(i) * 0.0007).sin_cos();
        let size = 0.2 + f64::from(i % 97) * 0.005;
        // A turn times a mirror, one entry moved by some ulp.
        let nudged = cos * size * (1.0 + f64::from(i % 5) * f64::EPSILON);
        let jacobian = [nudged, sin * size, sin * size, -cos * size];
        let (long, round) = (sample(Filter::Anisotropic, &jacobian)?, sample(Filter::Trilinear, &jacobian)?);
        assert!((long - round).abs() < 1e-5, "{jacobian:?}: {long} and {round}");
    }
    Ok(())
}
