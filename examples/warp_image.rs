//! An image turned by 30 degrees and halved, each pixel the average of what it covers.

use multum::Image;
use multum::warp::{Mapping, WarpOptions, warp};

/// Warps stripes and, with the feature `image`, writes them to the path that is given.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let stripes: Vec<u8> = (0..200 * 200).map(|i| if i % 200 % 2 == 0 { 255 } else { 0 }).collect();
    let image = Image::new(200, 200, 1, stripes)?;
    let (sin, cos) = 30f64.to_radians().sin_cos();
    // Output pixel (X, Y) shows the input around 2 R (X - 50, Y - 50) + (100, 100).
    let turn = Mapping::Affine([
        [2.0 * cos, -2.0 * sin, 100.0 - 100.0 * (cos - sin)],
        [2.0 * sin, 2.0 * cos, 100.0 - 100.0 * (sin + cos)],
    ]);
    let small = warp(image.view(), &turn, 100, 100, &WarpOptions::default())?;
    println!("{} x {} pixels", small.width(), small.height());
    #[cfg(feature = "image")]
    if let Some(path) = std::env::args().nth(1).filter(|name| name.ends_with(".png")) {
        multum::files::write(&path, small.view())?;
        println!("wrote {path}");
    }
    Ok(())
}
