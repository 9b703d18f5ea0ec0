//! Time of a filtered look-up on one thread: `cargo bench --bench lookups [filter ...]`.
//!
//! Places and Jacobians are given as singles, as a renderer has them. "near": the pixels of a turned plane, row by row;
//! "far": every look-up at a random place and angle. The footprint is two texels wide and `ratio` times as long.

use multum::par::with_threads;
use multum::{Extent, Filter, Image, Sampler, Texture, TextureOptions, Wrap};
use std::time::Instant;

/// Few enough look-ups that a run is over before another program gets its turn.
const SIDE: usize = 64;

fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1u64 << 53) as f64
}

/// uv and Jacobian of each look-up, in texture space of a texture of this size.
fn places(size: f64, ratio: f64, far: bool) -> (Vec<f32>, Vec<f32>) {
    let (mut uv, mut jacobian) = (Vec::new(), Vec::new());
    let mut state = 5;
    for i in 0..SIDE * SIDE {
        let (x, y) = ((i % SIDE) as f64, (i / SIDE) as f64);
        let angle = if far { random(&mut state) * 6.3 } else { 0.6 };
        let (sin, cos) = f64::sin_cos(angle);
        let m = [2.0 * cos, -2.0 * ratio * sin, 2.0 * sin, 2.0 * ratio * cos].map(|m| m / size);
        let place = if far {
            [random(&mut state), random(&mut state)]
        } else {
            [m[0] * x + m[1] * y, m[2] * x + m[3] * y].map(|x| x.rem_euclid(1.0))
        };
        uv.extend(place.map(|x| x as f32));
        jacobian.extend(m.map(|x| x as f32));
    }
    (uv, jacobian)
}

fn main() -> multum::Result<()> {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let names = ["bilinear", "trilinear", "anisotropic", "ewa", "area", "exact"];
    let names: Vec<&str> =
        if wanted.is_empty() { names.to_vec() } else { wanted.iter().map(String::as_str).collect() };
    println!("| filter | texture | places | ratio 1 | 4 | 16 |\n|---|---|---|---|---|---|");
    for name in names {
        let sampler = Sampler::new(Filter::parse(name)?);
        for (size, channels) in [(256, 4), (1024, 4), (1024, 1)] {
            let mut state = 3;
            let texels: Vec<u8> =
                (0..size * size * channels).map(|_| (random(&mut state) * 256.0) as u8).collect();
            let image = Image::new(size, size, channels, texels)?;
            let options = TextureOptions { wrap: [Wrap::Repeat; 2], ..Default::default() };
            let texture = Texture::new(image.view(), options)?;
            for far in [false, true] {
                let mut row =
                    format!("| {name} | {size}², {channels} ch | {} |", if far { "far" } else { "near" });
                for ratio in [1.0, 4.0, 16.0] {
                    let (uv, jacobian) = places(size as f64, ratio, far);
                    let mut out = vec![0f32; SIDE * SIDE * channels];
                    let mut best = f64::MAX;
                    for _ in 0..40 {
                        let start = Instant::now();
                        let extent = Extent::Jacobian(&jacobian);
                        with_threads(Some(1), || sampler.sample(&texture, &uv, extent, &mut out))?;
                        best = best.min(start.elapsed().as_secs_f64());
                    }
                    row += &format!(" {:.1} |", best * 1e9 / (SIDE * SIDE) as f64);
                }
                println!("{row}");
            }
        }
    }
    Ok(())
}
