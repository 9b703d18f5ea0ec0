//! Pyramids against a brute force in f64 that shares no code with them, and against closed forms.

use multum::encode::{Alpha, Encoding, Format};
use multum::kernel::{Isa, with_isa};
use multum::pyramid::{Kind, Options, Target, build, build_into, level_size, num_levels};
use multum::{DType, Image, Pixels, View, Wrap, par};

const KINDS: [Kind; 3] = [Kind::Box, Kind::Kaiser, Kind::Lanczos3];

fn options(kind: Kind, encoding: Encoding, alpha: Alpha, channels: usize) -> Options {
    let format = Format::new(encoding, alpha, channels).unwrap();
    Options { kind, format, wrap: [Wrap::Clamp; 2], coverage: None }
}

fn plain(channels: usize) -> Options {
    options(Kind::Box, Encoding::Linear, Alpha::None, channels)
}

/// A small deterministic generator of numbers in 0..1.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn noise(dtype: DType, width: usize, height: usize, channels: usize, seed: u64) -> Image {
    let mut noise = Noise(seed);
    let count = width * height * channels;
    let full = dtype.full_scale();
    let pixels: Pixels = match dtype {
        DType::U8 => (0..count).map(|_| (noise.next() * full).round() as u8).collect::<Vec<_>>().into(),
        DType::U16 => (0..count).map(|_| (noise.next() * full).round() as u16).collect::<Vec<_>>().into(),
        DType::F16 => {
            (0..count).map(|_| multum::texel::f16::from_f64(noise.next())).collect::<Vec<_>>().into()
        }
        DType::F32 => (0..count).map(|_| noise.next() as f32).collect::<Vec<_>>().into(),
        DType::F64 => (0..count).map(|_| noise.next()).collect::<Vec<_>>().into(),
    };
    Image::new(width, height, channels, pixels).unwrap()
}

fn numbers(image: &Image) -> Vec<f64> {
    match image.pixels() {
        Pixels::U8(v) => v.iter().map(|&x| f64::from(x)).collect(),
        Pixels::U16(v) => v.iter().map(|&x| f64::from(x)).collect(),
        Pixels::F16(v) => v.iter().map(|&x| x.to_f64()).collect(),
        Pixels::F32(v) => v.iter().map(|&x| f64::from(x)).collect(),
        Pixels::F64(v) => v.clone(),
    }
}

/// The brute force: dense weight matrices, everything in f64.
mod brute {
    use super::*;

    fn to_light(s: f64) -> f64 {
        if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
    }

    fn from_light(l: f64) -> f64 {
        if l <= 0.04045 / 12.92 { 12.92 * l } else { 1.055 * l.powf(1.0 / 2.4) - 0.055 }
    }

    fn decode(encoding: Encoding, dtype: DType, code: f64) -> f64 {
        let full = dtype.full_scale();
        match (encoding, dtype) {
            (Encoding::Linear, _) => code / full,
            (Encoding::Srgb, _) => to_light(code / full),
            (Encoding::Normal, DType::U8) => ((code - 128.0) / 127.0).max(-1.0),
            (Encoding::Normal, DType::U16) => ((code - 32_768.0) / 32_767.0).max(-1.0),
            (Encoding::Normal, _) => 2.0 * code - 1.0,
        }
    }

    fn encode(encoding: Encoding, dtype: DType, x: f64) -> f64 {
        let full = dtype.full_scale();
        match (encoding, dtype) {
            (Encoding::Linear, _) => x * full,
            (Encoding::Srgb, _) => from_light(x) * full,
            (Encoding::Normal, DType::U8) => x * 127.0 + 128.0,
            (Encoding::Normal, DType::U16) => x * 32_767.0 + 32_768.0,
            (Encoding::Normal, _) => (x + 1.0) / 2.0,
        }
    }

    fn outside(wrap: Wrap, i: i64, n: i64) -> usize {
        let at = match wrap {
            Wrap::Repeat => (i % n + n) % n,
            Wrap::Mirror => {
                let m = (i % (2 * n) + 2 * n) % (2 * n);
                if m < n { m } else { 2 * n - 1 - m }
            }
            Wrap::MirrorOnce if i < 0 => (-1 - i).min(n - 1),
            Wrap::Mirror101 if n > 1 => {
                let m = (i % (2 * n - 2) + 2 * n - 2) % (2 * n - 2);
                if m < n { m } else { 2 * n - 2 - m }
            }
            _ => i.max(0).min(n - 1),
        };
        at as usize
    }

    fn sinc(x: f64) -> f64 {
        let t = std::f64::consts::PI * x;
        if t.abs() < 1e-12 { 1.0 } else { t.sin() / t }
    }

    /// By its integral: mean of exp(x cos t).
    fn bessel(x: f64) -> f64 {
        let steps = 2000;
        let mean = |f: &dyn Fn(f64) -> f64| {
            (0..steps).map(|k| f((f64::from(k) + 0.5) / f64::from(steps))).sum::<f64>() / f64::from(steps)
        };
        mean(&|t| (x * (std::f64::consts::PI * t).cos()).exp())
    }

    fn kernel(kind: Kind, x: f64) -> f64 {
        if x.abs() >= 3.0 {
            return 0.0;
        }
        match kind {
            Kind::Kaiser => sinc(x) * bessel(4.0 * (1.0 - x * x / 9.0).sqrt()) / bessel(4.0),
            _ => sinc(x) * sinc(x / 3.0),
        }
    }

    /// `matrix[i][k]`: weight of old texel k in new texel i.
    pub fn matrix(kind: Kind, wrap: Wrap, n: usize) -> Vec<Vec<f64>> {
        let m = (n / 2).max(1);
        let ratio = n as f64 / m as f64;
        (0..m)
            .map(|i| {
                let mut row = vec![0.0; n];
                if kind == Kind::Box || n == 1 {
                    for (k, w) in row.iter_mut().enumerate() {
                        let low = (i as f64 * ratio).max(k as f64);
                        let high = ((i + 1) as f64 * ratio).min((k + 1) as f64);
                        *w = (high - low).max(0.0) / ratio;
                    }
                    return row;
                }
                let centre = (i as f64 + 0.5) * ratio;
                let reach = (3.0 * ratio) as i64 + 2;
                let taps: Vec<(i64, f64, f64)> = (centre as i64 - reach..=centre as i64 + reach)
                    .map(|k| (k, k as f64 + 0.5 - centre))
                    .map(|(k, x)| (k, x, kernel(kind, x / ratio)))
                    .collect();
                let sum = taps.iter().map(|(_, _, w)| w).sum::<f64>();
                let tent = |x: f64| (1.0 - (x / ratio).abs()).max(0.0);
                let mass = taps.iter().map(|(_, x, _)| tent(*x)).sum::<f64>();
                let middle = taps.iter().map(|(_, x, _)| x * tent(*x)).sum::<f64>() / mass;
                let spread = taps.iter().map(|(_, x, _)| x * tent(*x) * (x - middle)).sum::<f64>();
                let centre = taps.iter().map(|(_, x, w)| x * w / sum).sum::<f64>();
                for (k, x, w) in &taps {
                    row[outside(wrap, *k, n as i64)] += w / sum - centre / spread * tent(*x) * (x - middle);
                }
                row
            })
            .collect()
    }

    /// All levels as codes not yet rounded, beginning with the base.
    pub fn levels(image: &Image, options: &Options) -> Vec<Vec<f64>> {
        let (mut w, mut h, c) = (image.width(), image.height(), image.channels());
        let (format, dtype) = (options.format, image.dtype());
        let alpha = format.alpha == Alpha::Straight;
        let encoding = |k: usize| {
            let extra = match format.encoding {
                Encoding::Linear => true,
                Encoding::Srgb => (c == 2 || c == 4) && k == c - 1,
                Encoding::Normal => k == 3,
            };
            if extra { Encoding::Linear } else { format.encoding }
        };
        let codes = numbers(image);
        let mut values: Vec<f64> =
            codes.iter().enumerate().map(|(i, &x)| decode(encoding(i % c), dtype, x)).collect();
        if alpha {
            for texel in values.chunks_mut(c) {
                for k in 0..c - 1 {
                    texel[k] *= texel[c - 1];
                }
            }
        }
        let mut all = vec![codes];
        while w > 1 || h > 1 {
            let (mx, my) =
                (matrix(options.kind, options.wrap[0], w), matrix(options.kind, options.wrap[1], h));
            let mut next = vec![0.0; mx.len() * my.len() * c];
            for (j, wy) in my.iter().enumerate() {
                for (i, wx) in mx.iter().enumerate() {
                    for (y, &a) in wy.iter().enumerate().filter(|(_, a)| **a != 0.0) {
                        for (x, &b) in wx.iter().enumerate().filter(|(_, b)| **b != 0.0) {
                            for k in 0..c {
                                next[(j * mx.len() + i) * c + k] += a * b * values[(y * w + x) * c + k];
                            }
                        }
                    }
                }
            }
            (w, h) = (mx.len(), my.len());
            values = next;
            let codes = values.chunks(c).flat_map(|texel| {
                let a = texel[c - 1];
                (0..c).map(move |k| {
                    let x = if alpha && k < c - 1 {
                        if a > 0.0 { texel[k] / a } else { decode(encoding(k), dtype, 0.0).max(0.0) }
                    } else {
                        texel[k]
                    };
                    encode(encoding(k), dtype, x)
                })
            });
            all.push(codes.collect());
        }
        all
    }
}

/// Largest error in codes (or in floats) that the arithmetic may leave: half a code of rounding, and a few
/// roundings of the working precision for each level.
fn check(image: &Image, options: &Options, what: &str) {
    let truth = brute::levels(image, options);
    let levels = build(image.view(), options, None).unwrap();
    assert_eq!(levels.len(), num_levels(image.width(), image.height()), "{what}");
    assert_eq!(truth.len(), levels.len(), "{what}");
    let dtype = image.dtype();
    let full = dtype.full_scale();
    for (l, (level, truth)) in levels.iter().zip(&truth).enumerate() {
        let size = (level_size(image.width(), l), level_size(image.height(), l));
        assert_eq!((level.width(), level.height()), size, "{what}");
        assert_eq!(level.dtype(), dtype);
        // Up to 19 taps an axis of gain below 2, two axes, l levels; the sRGB slope is at most 12.92.
        let unit = if dtype == DType::F64 { 2f64.powi(-53) } else { 2f64.powi(-24) };
        let slope = if options.format.encoding == Encoding::Srgb { 12.92 } else { 1.0 };
        let drift = 40.0 * l as f64 * unit * slope * full;
        for (i, (got, want)) in numbers(level).iter().zip(truth).enumerate() {
            let rounding = match dtype {
                DType::U8 | DType::U16 => 0.5,
                DType::F16 => want.abs() * 2f64.powi(-11) + 2f64.powi(-25),
                DType::F32 => want.abs() * 2f64.powi(-24),
                DType::F64 => 0.0,
            };
            let want = if dtype.is_integer() { want.clamp(0.0, full) } else { *want };
            if want.is_finite() {
                assert!(
                    (got - want).abs() <= rounding + drift * (1.0 + want.abs() / full),
                    "{what}: level {l}, element {i}: {got}, not {want}"
                );
            }
        }
    }
}

#[test]
fn every_kind_type_and_wrap_agrees_with_the_brute_force() {
    let sizes = [(1, 1), (2, 1), (3, 5), (8, 8), (5, 17), (17, 8), (13, 2)];
    let wraps = [Wrap::Clamp, Wrap::Repeat, Wrap::Mirror, Wrap::MirrorOnce, Wrap::Mirror101, Wrap::Border];
    for dtype in [DType::U8, DType::U16, DType::F16, DType::F32, DType::F64] {
        for kind in KINDS {
            for (k, &(w, h)) in sizes.iter().enumerate() {
                let image = noise(dtype, w, h, 3, 7 + k as u64);
                for wrap in wraps {
                    let wrap = [wrap, wraps[(k + 1) % wraps.len()]];
                    let options = Options { wrap, ..options(kind, Encoding::Linear, Alpha::None, 3) };
                    check(&image, &options, &format!("{dtype:?} {kind:?} {w}x{h} {wrap:?}"));
                }
            }
        }
    }
}

#[test]
fn every_encoding_and_alpha_agrees_with_the_brute_force() {
    for dtype in [DType::U8, DType::U16, DType::F16, DType::F32, DType::F64] {
        for (encoding, alpha, channels) in [
            (Encoding::Srgb, Alpha::None, 1),
            (Encoding::Srgb, Alpha::None, 3),
            (Encoding::Srgb, Alpha::Straight, 2),
            (Encoding::Srgb, Alpha::Straight, 4),
            (Encoding::Srgb, Alpha::Premultiplied, 4),
            (Encoding::Normal, Alpha::None, 3),
            (Encoding::Normal, Alpha::Straight, 4),
            (Encoding::Linear, Alpha::Straight, 4),
            (Encoding::Linear, Alpha::Straight, 2),
            (Encoding::Linear, Alpha::None, 7),
        ] {
            for (w, h) in [(16, 8), (7, 9), (64, 3)] {
                let image = noise(dtype, w, h, channels, 3);
                check(
                    &image,
                    &options(Kind::Box, encoding, alpha, channels),
                    &format!("{dtype:?} {encoding:?} {alpha:?} {channels} {w}x{h}"),
                );
            }
        }
    }
}

fn column(image: &Image) -> Vec<f64> {
    numbers(image)
}

/// Mean and centre of mass (texels as squares of constant light) of a strip, in texture coordinates.
fn mass(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let sum: f64 = values.iter().sum();
    let moment: f64 = values.iter().enumerate().map(|(i, v)| v * (i as f64 + 0.5) / n).sum();
    (sum / n, moment / sum)
}

#[test]
fn means_centres_and_ramps_hold_at_every_size_in_both_directions() {
    for n in 1..=67usize {
        let strip: Vec<f64> = (0..n).map(|i| 1.0 + ((i * i * 37) % 11) as f64).collect();
        let symmetric: Vec<f64> = (0..n).map(|i| strip[i] + strip[n - 1 - i]).collect();
        let ramp: Vec<f64> = (0..n).map(|i| (i as f64 + 0.5) / n as f64).collect();
        for (w, h) in [(n, 1), (1, n)] {
            for kind in KINDS {
                let options = options(kind, Encoding::Linear, Alpha::None, 1);
                let levels = |data: &[f64]| {
                    let image = Image::new(w, h, 1, data.to_vec()).unwrap();
                    build(image.view(), &options, None).unwrap()
                };
                for level in levels(&symmetric) {
                    let (_, centre) = mass(&column(&level));
                    assert!((centre - 0.5).abs() < 1e-12, "{kind:?} {n}: centre {centre}");
                }
                let mirrored: Vec<f64> = strip.iter().rev().copied().collect();
                for (a, b) in levels(&strip).iter().zip(&levels(&mirrored)) {
                    let b: Vec<f64> = column(b).into_iter().rev().collect();
                    assert_eq!(column(a), b, "{kind:?} {n}: a mirrored picture gives mirrored levels");
                }
            }
            let image = Image::new(w, h, 1, strip.clone()).unwrap();
            let (mean, centre) = mass(&strip);
            for (l, level) in build(image.view(), &plain(1), None).unwrap().iter().enumerate() {
                let (m, c) = mass(&column(level));
                assert!((m - mean).abs() < 1e-13 * mean, "{n}, level {l}: mean {m}, not {mean}");
                // Light moves inside a wide texel only, at most half its width.
                let reach = 0.5 / column(level).len() as f64;
                assert!((c - centre).abs() <= reach, "{n}, level {l}: centre {c}, not {centre}");
            }
            let image = Image::new(w, h, 1, ramp.clone()).unwrap();
            let mut below = 1.0 / n as f64;
            let mut slack = 0.0;
            for level in build(image.view(), &plain(1), None).unwrap() {
                let values = column(&level);
                for (i, v) in values.iter().enumerate() {
                    let want = (i as f64 + 0.5) / values.len() as f64;
                    assert!((v - want).abs() <= slack + 1e-13, "{n}: ramp {v}, not {want}");
                }
                // A part f of a narrow texel counts with the texel's centre: off by f (1 - f)/2 <= 1/8
                // at each of two ends, over a width of at least two.
                slack += if values.len() % 2 == 1 { below / 8.0 } else { 0.0 };
                below = 1.0 / values.len() as f64;
            }
        }
    }
}

#[test]
fn windowed_kernels_keep_ramps_inside() {
    for n in [64, 67, 99, 128] {
        for kind in [Kind::Kaiser, Kind::Lanczos3] {
            let ramp: Vec<f64> = (0..n).map(|i| (i as f64 + 0.5) / n as f64).collect();
            let image = Image::new(n, 1, 1, ramp).unwrap();
            let options = options(kind, Encoding::Linear, Alpha::None, 1);
            let level = build(image.view(), &options, Some(2)).unwrap().pop().unwrap();
            let m = level.width();
            for (i, v) in numbers(&level).iter().enumerate().skip(4).take(m - 8) {
                let want = (i as f64 + 0.5) / m as f64;
                assert!((v - want).abs() < 1e-14, "{kind:?} {n}: {v}, not {want}");
            }
        }
    }
}

#[test]
fn constants_stay_exact() {
    let texels = [201.0, 3.0, 77.0, 153.0];
    for kind in KINDS {
        for (w, h) in [(67, 13), (1, 9), (32, 32)] {
            for (encoding, alpha) in [
                (Encoding::Linear, Alpha::None),
                (Encoding::Linear, Alpha::Straight),
                (Encoding::Srgb, Alpha::Straight),
                (Encoding::Normal, Alpha::Straight),
            ] {
                let bytes: Vec<u8> = texels.map(|x| x as u8).repeat(w * h);
                let words: Vec<u16> = texels.map(|x| x as u16 * 131 + 1).repeat(w * h);
                let singles: Vec<f32> = texels.map(|x| x as f32 / 210.0).repeat(w * h);
                let images: [Pixels; 3] = [bytes.into(), words.into(), singles.into()];
                for pixels in images {
                    let image = Image::new(w, h, 4, pixels).unwrap();
                    let options = options(kind, encoding, alpha, 4);
                    let texel = numbers(&image)[..4].to_vec();
                    for level in build(image.view(), &options, None).unwrap() {
                        let same = numbers(&level).chunks(4).all(|t| t == texel);
                        assert!(same, "{kind:?} {encoding:?} {alpha:?} {:?}", image.dtype());
                    }
                }
            }
        }
    }
}

#[test]
fn srgb_codes_survive_and_a_checker_is_188() {
    for full in [255u32, 65_535] {
        let flat: Vec<u16> = (0..=full).flat_map(|c| [c as u16; 2]).collect();
        let pixels: Pixels = if full == 255 {
            flat.iter().map(|&c| c as u8).collect::<Vec<_>>().into()
        } else {
            flat.clone().into()
        };
        let image = Image::new(flat.len(), 1, 1, pixels).unwrap();
        let options = options(Kind::Box, Encoding::Srgb, Alpha::None, 1);
        let level = build(image.view(), &options, Some(2)).unwrap().pop().unwrap();
        assert!(numbers(&level).iter().enumerate().all(|(c, &v)| v == c as f64));
    }
    let checker: Vec<u8> = (0..256).map(|i| if (i + i / 16) % 2 == 0 { 0 } else { 255 }).collect();
    let image = Image::new(16, 16, 1, checker).unwrap();
    let options = options(Kind::Box, Encoding::Srgb, Alpha::None, 1);
    for level in &build(image.view(), &options, None).unwrap()[1..] {
        assert!(numbers(level).iter().all(|&v| v == 188.0));
    }
}

#[test]
fn hidden_colour_never_bleeds() {
    // Opaque red beside transparent green.
    let texels: Vec<u8> =
        (0..15 * 9).flat_map(|i| if i % 3 == 0 { [255, 0, 0, 255] } else { [0, 255, 0, 0] }).collect();
    let image = Image::new(15, 9, 4, texels).unwrap();
    for kind in KINDS {
        for encoding in [Encoding::Linear, Encoding::Srgb] {
            let options = options(kind, encoding, Alpha::Straight, 4);
            for level in &build(image.view(), &options, None).unwrap()[1..] {
                for texel in numbers(level).chunks(4) {
                    assert_eq!(texel[1], 0.0, "green, {kind:?}");
                    assert!(texel[3] == 0.0 || texel[0] == 255.0, "red, {kind:?}");
                }
            }
        }
    }
    let empty = Image::new(4, 4, 4, [0.3f32, 7.0, -2.0, 0.0].repeat(16)).unwrap();
    let options = options(Kind::Box, Encoding::Linear, Alpha::Straight, 4);
    for level in &build(empty.view(), &options, None).unwrap()[1..] {
        assert!(numbers(level).iter().all(|&v| v == 0.0));
    }
}

/// A field of blobs, dense enough that a third of it passes.
fn foliage(n: usize) -> Vec<u8> {
    let mut noise = Noise(5);
    let leaves: Vec<[f64; 3]> = (0..n * n / 160)
        .map(|_| [noise.next() * n as f64, noise.next() * n as f64, 2.0 + 4.0 * noise.next()])
        .collect();
    let mut mask = vec![0u8; n * n];
    for [x, y, r] in leaves {
        for j in (y - r).max(0.0) as usize..((y + r) as usize + 1).min(n) {
            for i in (x - r).max(0.0) as usize..((x + r) as usize + 1).min(n) {
                if (i as f64 - x).hypot(j as f64 - y) < r {
                    mask[j * n + i] = 255;
                }
            }
        }
    }
    mask
}

#[test]
fn coverage_keeps_the_passing_share() {
    let mask = foliage(200);
    let texels: Vec<u8> = mask.iter().flat_map(|&a| [40, 120, 30, a]).collect();
    let image = Image::new(200, 200, 4, texels).unwrap();
    for alpha in [Alpha::Straight, Alpha::Premultiplied] {
        for threshold in [0.2, 0.5, 0.9] {
            let plain = options(Kind::Box, Encoding::Srgb, alpha, 4);
            let options = Options { coverage: Some(threshold), ..plain };
            let share = |level: &Image| {
                let texels = numbers(level);
                let passing = texels.chunks(4).filter(|t| t[3] / 255.0 >= threshold).count();
                passing as f64 / (level.width() * level.height()) as f64
            };
            let levels = build(image.view(), &options, None).unwrap();
            let base = share(&levels[0]);
            assert!(base > 0.2 && base < 0.8, "{base}");
            for (l, level) in levels.iter().enumerate() {
                let texels = (level.width() * level.height()) as f64;
                let bound = 0.5 / texels + 1e-12;
                assert!((share(level) - base).abs() <= bound, "{alpha:?} {threshold}, level {l}");
            }
            let without = build(image.view(), &plain, None).unwrap();
            if threshold == 0.9 {
                assert!((share(&without[4]) - base).abs() > 0.05, "the option does something");
            }
        }
    }
    assert!(build(image.view(), &Options { coverage: Some(0.5), ..plain(4) }, None).is_err());
}

#[test]
fn opposite_slopes_average_to_a_short_upward_normal() {
    let s = 0.5f64.sqrt();
    let code = |x: f64| (x * 0.5 + 0.5) as f32;
    let texels = [[code(s), 0.5, code(s)], [code(-s), 0.5, code(s)]].concat();
    let image = Image::new(2, 1, 3, texels).unwrap();
    let options = options(Kind::Box, Encoding::Normal, Alpha::None, 3);
    let top = numbers(&build(image.view(), &options, None).unwrap()[1]);
    let vector: Vec<f64> = top.iter().map(|x| 2.0 * x - 1.0).collect();
    assert!(vector[0].abs() < 1e-7 && vector[1].abs() < 1e-7, "up");
    assert!((vector[2] - s).abs() < 1e-6, "length cos 45°");
    let flat = Image::new(2, 2, 3, [128u8, 128, 255].repeat(4)).unwrap();
    assert_eq!(numbers(&build(flat.view(), &options, None).unwrap()[1]), [128.0, 128.0, 255.0]);
}

#[test]
fn a_chain_of_bytes_gathers_no_rounding_bias() {
    let image = noise(DType::U8, 1024, 1024, 1, 11);
    let base = numbers(&image);
    let mean = base.iter().sum::<f64>() / base.len() as f64;
    let last = build(image.view(), &plain(1), None).unwrap().pop().unwrap();
    let top = numbers(&last)[0];
    assert!((top - mean).abs() <= 0.5 + 1e-3, "{top}, not {mean}");
}

#[test]
fn byte_boxes_are_the_exact_mean_rounded_half_up() {
    let image = noise(DType::U8, 512, 512, 1, 2);
    let base = numbers(&image);
    let level = build(image.view(), &plain(1), Some(2)).unwrap().pop().unwrap();
    for (i, &v) in numbers(&level).iter().enumerate() {
        let (x, y) = (2 * (i % 256), 2 * (i / 256));
        let sum =
            base[y * 512 + x] + base[y * 512 + x + 1] + base[(y + 1) * 512 + x] + base[(y + 1) * 512 + x + 1];
        assert_eq!(v, ((sum + 2.0) / 4.0).floor());
    }
}

#[test]
fn bytes_do_not_depend_on_threads_or_instructions() {
    let formats =
        [(Encoding::Linear, Alpha::None), (Encoding::Srgb, Alpha::Straight), (Encoding::Srgb, Alpha::None)];
    for (encoding, alpha) in formats {
        for (w, h) in [(300, 211), (256, 256), (5, 700), (24, 1100)] {
            let image = noise(DType::U8, w, h, 4, 1);
            for kind in KINDS {
                let options = options(kind, encoding, alpha, 4);
                let run = |n| par::with_threads(Some(n), || build(image.view(), &options, None).unwrap());
                let one = run(1);
                for n in [2, 3, 7] {
                    assert_eq!(run(n), one, "{kind:?} {n} threads");
                }
                for isa in Isa::available() {
                    assert_eq!(with_isa(isa, || run(2)).unwrap(), one, "{kind:?} {isa:?}");
                }
            }
        }
    }
}

#[test]
fn levels_go_into_rows_with_aprons_and_more_lanes() {
    let image = noise(DType::U8, 13, 9, 3, 4);
    let Pixels::U8(data) = image.pixels() else { unreachable!("made as bytes") };
    let packed = build(image.view(), &plain(3), None).unwrap();
    for base_lanes in [3, 4] {
        let texels: Vec<u8> = data
            .chunks(3)
            .flat_map(|t| [t, &[99u8][..]].concat().into_iter().take(base_lanes).collect::<Vec<_>>())
            .collect();
        let base = View::new(&texels, 13, 9, base_lanes, 13 * base_lanes).unwrap();
        let mut stores: Vec<Vec<u8>> =
            (1..4).map(|l| vec![77; (level_size(13, l) + 2) * 4 * (level_size(9, l) + 2)]).collect();
        let mut targets: Vec<Target<'_, u8>> = stores
            .iter_mut()
            .enumerate()
            .map(|(i, data)| {
                let (width, height) = (level_size(13, i + 1), level_size(9, i + 1));
                let row_stride = (width + 2) * 4;
                Target { data, origin: row_stride + 4, row_stride, width, height }
            })
            .collect();
        build_into(base, 4, &mut targets, &plain(3)).unwrap();
        for (i, store) in stores.iter().enumerate() {
            let (w, h) = (level_size(13, i + 1), level_size(9, i + 1));
            let want = numbers(&packed[i + 1]);
            for (k, texel) in store.chunks(4).enumerate() {
                let (x, y) = (k % (w + 2), k / (w + 2));
                if (1..=w).contains(&x) && (1..=h).contains(&y) {
                    let at = ((y - 1) * w + x - 1) * 3;
                    let want: Vec<u8> = want[at..at + 3].iter().map(|&v| v as u8).chain([0]).collect();
                    assert_eq!(texel, want, "level {}", i + 1);
                } else {
                    assert_eq!(texel, [77; 4], "the apron is not touched");
                }
            }
        }
    }
}

#[test]
fn impossible_requests_are_refused() {
    let image = noise(DType::U8, 8, 8, 3, 4);
    assert!(build(image.view(), &plain(4), None).is_err(), "channels");
    assert!(build(image.view(), &plain(3), Some(0)).is_err(), "no level");
    assert!(build(image.view(), &plain(3), Some(5)).is_err(), "too many levels");
    assert_eq!(build(image.view(), &plain(3), Some(4)).unwrap().len(), 4);
    let data = [0u8; 192];
    let base = View::new(&data, 8, 8, 3, 24).unwrap();
    let mut store = [0u8; 47];
    for (origin, row_stride, width, height, lanes) in [
        (0, 12, 4, 4, 3),
        (1, 11, 4, 4, 3),
        (0, 12, 5, 4, 3),
        (usize::MAX, 12, 4, 4, 3),
        (0, usize::MAX, 4, 4, 3),
        (0, 8, 4, 4, 2),
    ] {
        let target = Target { data: &mut store, origin, row_stride, width, height };
        assert!(build_into(base, lanes, &mut [target], &plain(3)).is_err());
    }
}
