use super::*;
use crate::image::Image;

fn noise(width: usize, height: usize) -> Image {
    let mut state = 1u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1u32 << 24)
    };
    let data: Vec<f64> = (0..width * height).map(|_| next()).collect();
    Image::new(width, height, 1, data).expect("fits")
}

const FILTERS: [Filter; 8] = [
    Filter::Bilinear,
    Filter::Bicubic,
    Filter::Trilinear,
    Filter::Anisotropic,
    Filter::Ewa,
    Filter::Area,
    Filter::Exact,
    Filter::Auto,
];

fn textures() -> [SphereTexture; 4] {
    let made = |layout, w, h| SphereTexture::cube(noise(w, h).view(), layout, TextureOptions::default());
    [
        SphereTexture::equirect(noise(32, 16).view(), TextureOptions::default()).expect("fits"),
        SphereTexture::equirect(noise(15, 9).view(), TextureOptions::default()).expect("fits"),
        made(Layout::Stacked, 8, 48).expect("fits"),
        made(Layout::Cross, 20, 15).expect("fits"),
    ]
}

/// A point of white noise, seen from both sides of seam, pole, edge and corner, is the same point.
#[test]
fn points_do_not_jump() {
    let across = [
        [DVec3::new(-1e-9, 0.3, -1.0), DVec3::new(1e-9, 0.3, -1.0)],
        [DVec3::new(1e-9, 1.0, 2e-9), DVec3::new(-3e-9, 1.0, 0.0)],
        [DVec3::new(1e-9, -1.0, 2e-9), DVec3::new(-3e-9, -1.0, 1e-9)],
        [DVec3::new(1.0 + 1e-9, 1.0, 0.3), DVec3::new(1.0 - 1e-9, 1.0, 0.3)],
        [DVec3::new(1.0 + 1e-9, -0.9, 1.0), DVec3::new(1.0 - 1e-9, -0.9, 1.0)],
        [DVec3::new(-1.0 - 1e-9, 0.97, -1.0), DVec3::new(-1.0 + 1e-9, 0.97, -1.0)],
        [DVec3::new(-1.0, 1.0 + 1e-9, 1.0), DVec3::new(-1.0 - 1e-9, 1.0, 1.0)],
        [DVec3::new(-1.0, 1.0, 1.0 + 1e-9), DVec3::new(-1.0 - 1e-9, 1.0, 1.0)],
    ];
    for texture in &textures() {
        for filter in [Filter::Bilinear, Filter::Trilinear, Filter::Auto, Filter::Anisotropic] {
            let sampler = Sampler::new(filter);
            for pair in across {
                let d: Vec<f64> = pair.iter().flat_map(|d| d.to_array()).collect();
                let mut got = [0f64; 2];
                texture.sample(&sampler, &d, Spread::Point, &mut got).expect("fits");
                assert!((got[0] - got[1]).abs() < 1e-7, "{filter:?} {pair:?} {got:?}");
            }
        }
    }
}

/// The same on every level of the mipmap filters.
#[test]
fn levels_do_not_jump() {
    for texture in &textures()[2..] {
        for lod in [0.0f32, 0.5, 1.0, 1.7, 2.0, 3.0, 9.0] {
            let edge = |x: f64, t: f64| [x, 1.0, t];
            for t in [-1.0, -0.99, -0.6, 0.0, 0.13, 0.8, 0.95, 1.0] {
                let d = [edge(1.0 + 1e-9, t), edge(1.0 - 1e-9, t)].concat();
                let mut got = [0f64; 2];
                let sampler = Sampler::new(Filter::Trilinear);
                texture.sample(&sampler, &d, Spread::Lod(&[lod; 2]), &mut got).expect("fits");
                assert!((got[0] - got[1]).abs() < 1e-7, "{lod} {t} {got:?}");
            }
        }
    }
}

#[test]
fn constants_stay_and_nothing_breaks_anything() {
    let awkward = [0.0, -0.0, 1.0, -1.0, 1e-300, 1e300, f64::INFINITY, f64::NAN];
    let flat = |w, h| Image::new(w, h, 1, vec![0.7f32; w * h]).expect("fits");
    let options = TextureOptions::default;
    let made = [
        SphereTexture::equirect(flat(16, 8).view(), options()).expect("fits"),
        SphereTexture::equirect(flat(1, 1).view(), options()).expect("fits"),
        SphereTexture::cube(flat(4, 24).view(), Layout::Stacked, options()).expect("fits"),
        SphereTexture::cube(flat(6, 1).view(), Layout::Strip, options()).expect("fits"),
    ];
    for texture in &made {
        for filter in FILTERS.into_iter().chain([Filter::Nearest, Filter::Sat, Filter::Stochastic]) {
            let mut seed = 7u32;
            let mut pick = || {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                awkward[(seed >> 20) as usize % awkward.len()]
            };
            let n = 300;
            let mut numbers = || (0..3 * n).map(|_| pick()).collect::<Vec<f64>>();
            let (d, x, y) = (numbers(), numbers(), numbers());
            let mut out = vec![9f32; n];
            let spread = Spread::Tangents(&x, &y);
            texture.sample(&Sampler::new(filter), &d, spread, &mut out).expect("fits");
            for (d, got) in d.chunks_exact(3).zip(out) {
                let there = d.iter().all(|x| x.is_finite()) && d.iter().any(|x| *x != 0.0);
                let want = if there { 0.7 } else { 0.0 };
                // The sixteen weights of a cubic sum to one to rounding.
                let slack = if filter == Filter::Bicubic { f32::EPSILON } else { 0.0 };
                assert!((got - want).abs() <= slack, "{filter:?} {d:?}: {got}");
            }
        }
    }
}

#[test]
fn lengths_and_shapes_are_checked() {
    let picture = noise(7, 5);
    assert!(SphereTexture::cube(picture.view(), Layout::Cross, TextureOptions::default()).is_err());
    let texture = SphereTexture::equirect(picture.view(), TextureOptions::default()).expect("fits");
    let mut out = [0f64; 1];
    let sampler = Sampler::default();
    assert!(texture.sample(&sampler, &[0.0f64; 4], Spread::Point, &mut out).is_err());
    assert!(texture.sample(&sampler, &[0.0f64; 6], Spread::Point, &mut out).is_err());
    assert!(texture.sample(&sampler, &[0.0f64; 3], Spread::Lod(&[]), &mut out).is_err());
    let short = Spread::Tangents(&[0.0; 3], &[0.0; 2]);
    assert!(texture.sample(&sampler, &[0.0f64; 3], short, &mut out).is_err());
}
