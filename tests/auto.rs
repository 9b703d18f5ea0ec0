//! `auto` with a tolerance: never further from the integral than it was told.

use multum::encode::{Alpha, Encoding};
use multum::oracle::{self, Pixel, PixelFilter, Reconstruction, Signal};
use multum::{Extent, Filter, Image, Sampler, Texture, TextureOptions, Wrap};

/// A small deterministic generator for test cases.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.unit()
    }
}

const TOLERANCES: [f64; 6] = [0.1, 1.0 / 16.0, 1.0 / 64.0, 1.0 / 255.0, 1.0 / 2048.0, 1.0 / 65535.0];

/// From a place and a random number to a value of 0 to 1.
type Picture = fn(i64, i64, f64) -> f64;

/// Pictures that are hard in different ways.
fn pictures() -> Vec<(&'static str, Picture)> {
    vec![
        ("checker", |x, y, _| ((x + y) & 1) as f64),
        ("squares", |x, y, _| (((x >> 3) + (y >> 3)) & 1) as f64),
        ("noise", |_, _, r| r),
        ("impulses", |_, _, r| if r > 0.98 { 1.0 } else { 0.0 }),
        ("one impulse", |x, y, _| if (x, y) == (9, 12) { 1.0 } else { 0.0 }),
        ("a step", |x, _, _| if x >= 20 { 1.0 } else { 0.0 }),
        ("a slanted step", |x, y, _| if 2 * x + y >= 50 { 1.0 } else { 0.0 }),
        ("a ramp", |x, y, _| (x as f64 + 2.0 * y as f64) / 200.0),
        ("waves", |x, y, _| 0.5 + 0.5 * (x as f64 * 0.21).sin() * (y as f64 * 0.13).cos()),
        ("strokes", |x, y, r| if (x % 7 < 2 || y % 11 == 3) && r < 0.9 { 0.1 } else { 0.95 }),
    ]
}

struct Case {
    texture: Texture<'static>,
    truth: Signal,
    name: String,
    size: [f64; 2],
}

fn case(name: &str, f: fn(i64, i64, f64) -> f64, size: [usize; 2], wrap: [usize; 2], bytes: bool) -> Case {
    let wraps: Vec<Wrap> = Wrap::NAMES.iter().map(|(_, w)| *w).collect();
    let extra = wrap.map(|w| if wraps[w] == Wrap::Extend { 2 } else { 0 });
    let (w, h) = (size[0] + extra[0], size[1] + extra[1]);
    let mut random = Random(7);
    let values: Vec<f64> = (0..w * h)
        .flat_map(|k| {
            let value = f((k % w) as i64, (k / w) as i64, random.unit());
            [value, 1.0 - 0.7 * value]
        })
        .collect();
    let image = if bytes {
        Image::new(w, h, 2, values.iter().map(|v| (v * 255.0).round() as u8).collect::<Vec<_>>())
    } else {
        Image::new(w, h, 2, values)
    }
    .expect("an image");
    let border = vec![0.25, 0.5];
    let options =
        TextureOptions { wrap: wrap.map(|w| wraps[w]), border: border.clone(), ..Default::default() };
    let judge = oracle::Options {
        wrap: wrap.map(|w| {
            let name = Wrap::NAMES[w].0;
            oracle::Wrap::parse(name).expect("the same names")
        }),
        border,
        ..Default::default()
    };
    Case {
        truth: Signal::new(image.view(), &judge).expect("a signal"),
        texture: Texture::new(image.view(), options).expect("a texture"),
        name: format!("{name} {size:?} {:?} {bytes}", wrap.map(|w| Wrap::NAMES[w].0)),
        size: size.map(|n| n as f64),
    }
}

fn turned(angle: f64, width: f64, height: f64, shear: f64) -> [[f64; 2]; 2] {
    let (sin, cos) = angle.sin_cos();
    let [a, b, d] = [width, shear * width, height];
    [[cos * a, cos * b - sin * d], [sin * a, sin * b + cos * d]]
}

/// Results of both channels for places and footprints in texture space.
fn sample(texture: &Texture<'_>, tolerance: f64, places: &[([f64; 2], [[f64; 2]; 2])]) -> Vec<f64> {
    let sampler = Sampler { tolerance: Some(tolerance), ..Sampler::new(Filter::Auto) };
    let uv: Vec<f64> = places.iter().flat_map(|(p, _)| *p).collect();
    let jacobian: Vec<f64> = places.iter().flat_map(|(_, j)| j.as_flattened().to_vec()).collect();
    let mut out = vec![0.0f64; places.len() * texture.channels()];
    sampler.sample(texture, &uv, Extent::Jacobian(&jacobian), &mut out).expect("samples");
    out
}

/// Compares at all tolerances; returns how many results there were.
fn judge(case: &Case, places: &[([f64; 2], [[f64; 2]; 2])]) -> usize {
    let pixel = Pixel::new(PixelFilter::Box, Reconstruction::Bilinear);
    let truths: Vec<Vec<f64>> = places
        .iter()
        .map(|(uv, j)| case.truth.sample(*uv, Some(*j), &pixel, 0.0).expect("the truth").values)
        .collect();
    for tolerance in TOLERANCES {
        let values = sample(&case.texture, tolerance, places);
        let channels = case.texture.channels();
        for ((place, truth), value) in places.iter().zip(&truths).zip(values.chunks(channels)) {
            for (value, truth) in value.iter().zip(truth) {
                assert!(
                    (value - truth).abs() <= tolerance,
                    "{} within {tolerance:.6} at {place:?}: {value} for {truth}",
                    case.name
                );
            }
        }
    }
    TOLERANCES.len() * places.len()
}

fn places(random: &mut Random, size: [f64; 2], count: usize, largest: f64) -> Vec<([f64; 2], [[f64; 2]; 2])> {
    (0..count)
        .map(|_| {
            let long = 2f64.powf(random.between(-3.0, largest));
            let thin = 10f64.powf(random.between(-2.5, 0.0));
            let upright = random.unit() < 0.2;
            let angle = if upright { 0.0 } else { random.between(0.0, 6.3) };
            let j = turned(angle, long, long * thin, random.between(-1.5, 1.5));
            let uv = [random.between(-1.5, 2.5), random.between(-1.5, 2.5)];
            (uv, [j[0].map(|x| x / size[0]), j[1].map(|x| x / size[1])])
        })
        .collect()
}

#[test]
fn a_tolerance_is_kept_on_every_picture_and_wrap() {
    let mut random = Random(101);
    let mut count = 0;
    for (n, (name, picture)) in pictures().into_iter().enumerate() {
        for wrap in 0..Wrap::NAMES.len() {
            // Different modes along the two axes, each mode on each axis.
            let wraps = [wrap, (wrap * 3 + n) % Wrap::NAMES.len()];
            let size = [[37, 23], [64, 64], [5, 90], [40, 1]][(n + wrap) % 4];
            let case = case(name, picture, size, wraps, (n + wrap) % 2 == 0);
            count += judge(&case, &places(&mut random, case.size, 40, 7.0));
        }
    }
    assert!(count > 10_000);
}

#[test]
fn a_tolerance_is_kept_where_footprints_are_huge() {
    let mut random = Random(103);
    for (name, picture) in [pictures()[2], pictures()[1], pictures()[8]] {
        for wrap in [[1, 1], [2, 4], [1, 0], [5, 2]] {
            let case = case(name, picture, [61, 48], wrap, true);
            judge(&case, &places(&mut random, case.size, 12, 13.0));
        }
    }
}

#[test]
fn a_tolerance_is_kept_in_linear_light_and_behind_alpha() {
    let mut random = Random(107);
    for (encoding, alpha) in [
        (Encoding::Srgb, Alpha::None),
        (Encoding::Srgb, Alpha::Straight),
        (Encoding::Linear, Alpha::Straight),
        (Encoding::Linear, Alpha::Premultiplied),
    ] {
        let codes: Vec<u8> = (0..40 * 30)
            .flat_map(|_| {
                let alpha = if random.unit() < 0.4 { 0.0 } else { random.unit() };
                [random.unit(), random.unit(), random.unit(), alpha].map(|v| (v * 255.0) as u8)
            })
            .collect();
        let image = Image::new(40, 30, 4, codes).expect("an image");
        let options = TextureOptions { wrap: [Wrap::Repeat; 2], encoding, alpha, ..Default::default() };
        let judged = oracle::Options {
            wrap: [oracle::Wrap::Repeat; 2],
            encoding: oracle::Encoding::parse(encoding.name()).expect("the same names"),
            alpha: oracle::Alpha::parse(alpha.name()).expect("the same names"),
            ..Default::default()
        };
        let case = Case {
            truth: Signal::new(image.view(), &judged).expect("a signal"),
            texture: Texture::new(image.view(), options).expect("a texture"),
            name: format!("{encoding:?} {alpha:?}"),
            size: [40.0, 30.0],
        };
        judge(&case, &places(&mut random, case.size, 60, 7.0));
    }
}
