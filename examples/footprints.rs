//! Time and error of the filters by footprint: ns a sample and rms x 255 against the exact mean.
//!
//! `cargo run --release --example footprints [white|pink|edges] [filter ...]`: one thread, 512 x 512 RGBA8, wrapped, every
//! sample at a random place and angle. Footprints are width x height in texels; `shear` slants the second side.

use multum::{Extent, Filter, Image, Sampler, Texture, TextureOptions, Wrap, par};
use std::time::Instant;

const SIZE: usize = 512;

fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1u64 << 53) as f64
}

/// White noise; noise with as much contrast in every octave; or discs of random colours.
fn picture(kind: &str) -> Vec<u8> {
    let mut state = 1;
    let mut texels = vec![0.0; SIZE * SIZE * 4];
    match kind {
        "pink" => {
            for octave in 0..8 {
                let cells = SIZE >> octave;
                let values: Vec<f64> = (0..cells * cells * 4).map(|_| random(&mut state) - 0.5).collect();
                for (i, texel) in texels.chunks_exact_mut(4).enumerate() {
                    let at = ((i / SIZE) >> octave) * cells + ((i % SIZE) >> octave);
                    texel.iter_mut().zip(&values[4 * at..]).for_each(|(t, v)| *t += 0.35 * v);
                }
            }
            texels.iter_mut().for_each(|t| *t += 0.5);
        }
        "edges" => {
            for _ in 0..300 {
                let [x, y, r] = [random(&mut state), random(&mut state), 0.1 * random(&mut state)];
                let colour: [f64; 4] = std::array::from_fn(|_| random(&mut state));
                for (i, texel) in texels.chunks_exact_mut(4).enumerate() {
                    let [dx, dy] = [(i % SIZE) as f64 / SIZE as f64 - x, (i / SIZE) as f64 / SIZE as f64 - y];
                    if dx * dx + dy * dy < r * r {
                        texel.copy_from_slice(&colour);
                    }
                }
            }
        }
        _ => texels.iter_mut().for_each(|t| *t = random(&mut state)),
    }
    texels.into_iter().map(|t| (t * 255.0).round() as u8).collect()
}

fn main() -> multum::Result<()> {
    let kind = std::env::args().nth(1).unwrap_or_else(|| "white".into());
    let image = Image::new(SIZE, SIZE, 4, picture(&kind))?;
    let options = TextureOptions { wrap: [Wrap::Repeat; 2], ..Default::default() };
    let texture = Texture::new(image.view(), options)?;
    let shapes = [
        ("2 x 2", 2.0, 2.0, 0.0),
        ("4 x 4", 4.0, 4.0, 0.0),
        ("8 x 8", 8.0, 8.0, 0.0),
        ("16 x 16", 16.0, 16.0, 0.0),
        ("64 x 64", 64.0, 64.0, 0.0),
        ("4 x 32", 4.0, 32.0, 0.0),
        ("16 x 128", 16.0, 128.0, 0.0),
        ("4 x 1, shear 1.5", 4.0, 1.0, 1.5),
        ("8 x 1/2", 8.0, 0.5, 0.0),
    ];
    let filters = [
        ("trilinear", Filter::Trilinear),
        ("anisotropic", Filter::Anisotropic),
        ("ewa", Filter::Ewa),
        ("sat", Filter::Sat),
        ("area", Filter::Area),
        ("stochastic", Filter::Stochastic),
        ("exact", Filter::Exact),
        ("auto", Filter::Auto),
    ];
    let wanted: Vec<String> = std::env::args().skip(2).collect();
    let filters: Vec<_> =
        filters.into_iter().filter(|(n, _)| wanted.is_empty() || wanted.iter().any(|w| w == n)).collect();
    println!("| footprint |{}", filters.iter().map(|(name, _)| format!(" {name} |")).collect::<String>());
    println!("|---|{}", "---|".repeat(filters.len()));
    for (name, width, height, shear) in shapes {
        let count = if width * height > 1000.0 { 2000 } else { 20_000 };
        let mut state = 9;
        let (mut uv, mut jacobian) = (Vec::new(), Vec::new());
        for _ in 0..count {
            uv.extend([random(&mut state), random(&mut state)]);
            let (sin, cos) = (random(&mut state) * std::f64::consts::TAU).sin_cos();
            let [b, d] = [shear * height, height];
            jacobian.extend(
                [cos * width, cos * b - sin * d, sin * width, sin * b + cos * d].map(|x| x / SIZE as f64),
            );
        }
        let mut truth = vec![0f32; count * 4];
        let extent = Extent::Jacobian(&jacobian);
        Sampler::new(Filter::Exact).sample(&texture, &uv, extent, &mut truth)?;
        let mut row = format!("| {name} |");
        for &(_, filter) in &filters {
            let sampler = Sampler::new(filter);
            let mut out = vec![0f32; count * 4];
            let mut best = f64::MAX;
            for _ in 0..4 {
                let start = Instant::now();
                par::with_threads(Some(1), || sampler.sample(&texture, &uv, extent, &mut out))?;
                best = best.min(start.elapsed().as_secs_f64());
            }
            let squares: f64 = out.iter().zip(&truth).map(|(a, b)| f64::from(a - b).powi(2)).sum();
            let rms = 255.0 * (squares / out.len() as f64).sqrt();
            row += &format!(" {:.0}: {rms:.3} |", best * 1e9 / count as f64);
        }
        println!("{row}");
    }
    Ok(())
}
