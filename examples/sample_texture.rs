//! A texture sampled where a ray tracer would: a place, and how far it moves from pixel to pixel.

use multum::{Extent, Filter, Image, Sampler, Texture, TextureOptions, Wrap};

/// Prints a checkerboard's value as it recedes: interpolation flickers, filtering settles at the mean.
pub fn main() -> multum::Result<()> {
    let pixels: Vec<u8> = (0..64 * 64).map(|i| if (i / 8 + i / 512) % 2 == 0 { 255 } else { 0 }).collect();
    let image = Image::new(64, 64, 1, pixels)?;
    let texture =
        Texture::new(image.view(), TextureOptions { wrap: [Wrap::Repeat; 2], ..TextureOptions::default() })?;
    for filter in [Filter::Bilinear, Filter::Trilinear, Filter::Anisotropic] {
        let sampler = Sampler { filter, ..Sampler::default() };
        for depth in [1.0, 4.0, 16.0] {
            let uv = [0.3, depth];
            // du/dx, du/dy, dv/dx, dv/dy: a pixel is longer along v.
            let jacobian = [depth / 100.0, 0.0, 0.0, depth * depth / 100.0];
            let mut value = [0f32];
            sampler.sample(&texture, &uv, Extent::Jacobian(&jacobian), &mut value)?;
            println!("{filter:?} at depth {depth}: {:.3}", value[0]);
        }
    }
    Ok(())
}
