//! Look-ups in blocks against the same filters one by one in doubles, and equal bytes on every instruction set.

use multum::encode::{Alpha, Encoding};
use multum::kernel::{Isa, with_isa};
use multum::texel::f16;
use multum::{DType, Extent, Filter, Image, Sampler, Texture, TextureOptions, Wrap};

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

const WRAPS: [Wrap; 7] =
    [Wrap::Clamp, Wrap::Repeat, Wrap::Mirror, Wrap::MirrorOnce, Wrap::Mirror101, Wrap::Border, Wrap::Extend];

/// Values that all types hold exactly: multiples of 1/255 as bytes, or of 1/1024 as floats.
fn texture(dtype: DType, size: [usize; 2], channels: usize, options: &TextureOptions) -> Texture<'static> {
    let extra = options.wrap.map(|w| if w == Wrap::Extend { 2 } else { 0 });
    let [w, h] = [size[0] + extra[0], size[1] + extra[1]];
    let mut random = Random(9 + channels as u64);
    let codes: Vec<u16> = (0..w * h * channels).map(|_| (random.unit() * 256.0) as u16).collect();
    let image = match dtype {
        DType::U8 => Image::new(w, h, channels, codes.iter().map(|c| *c as u8).collect::<Vec<_>>()),
        DType::U16 => Image::new(w, h, channels, codes.iter().map(|c| c * 257).collect::<Vec<_>>()),
        DType::F16 => {
            let halves: Vec<f16> = codes.iter().map(|c| f16::from_f32(f32::from(*c) / 1024.0)).collect();
            Image::new(w, h, channels, halves)
        }
        DType::F32 => {
            Image::new(w, h, channels, codes.iter().map(|c| f32::from(*c) / 1024.0).collect::<Vec<_>>())
        }
        DType::F64 => {
            Image::new(w, h, channels, codes.iter().map(|c| f64::from(*c) / 1024.0).collect::<Vec<_>>())
        }
    };
    Texture::new(image.expect("an image").view(), options.clone()).expect("a texture")
}

/// Places in and around a texture, with footprints of all kinds, in texture space.
fn places(random: &mut Random, size: [usize; 2], count: usize, spread: f64) -> (Vec<f64>, Vec<f64>) {
    let (mut uv, mut jacobian) = (Vec::new(), Vec::new());
    for _ in 0..count {
        uv.extend([random.between(-spread, spread + 1.0), random.between(-spread, spread + 1.0)]);
        let width = 2f64.powf(random.between(-2.0, 3.0));
        let length = width * 2f64.powf(random.between(0.0, 5.0));
        let (sin, cos) = random.between(0.0, 7.0).sin_cos();
        let shear = random.between(-1.0, 1.0) * width;
        let m = [cos * length, cos * shear - sin * width, sin * length, sin * shear + cos * width];
        let [w, h] = size.map(|n| n as f64);
        jacobian.extend([m[0] / w, m[1] / w, m[2] / h, m[3] / h]);
    }
    (uv, jacobian)
}

const FILTERS: [Filter; 4] =
    [Filter::Bilinear, Filter::LinearMipmapNearest, Filter::Trilinear, Filter::Anisotropic];

#[test]
fn blocks_of_singles_agree_with_doubles_one_by_one() {
    let mut random = Random(3);
    for (k, wrap) in WRAPS.into_iter().enumerate() {
        for (size, channels) in [([1, 1], 1), ([3, 2], 2), ([17, 5], 3), ([64, 64], 4), ([96, 50], 6)] {
            let wrap = [wrap, WRAPS[(k + size[0]) % 7]];
            let options = TextureOptions { wrap, border: vec![0.125; channels], ..Default::default() };
            let [single, double] = [DType::F32, DType::F64].map(|t| texture(t, size, channels, &options));
            let (uv, jacobian) = places(&mut random, size, 150, 1.2);
            for filter in FILTERS {
                for (max_anisotropy, lod_bias) in [(16.0, 0.0), (3.0, 0.7), (f64::INFINITY, -0.4)] {
                    let sampler = Sampler { max_anisotropy, lod_bias, ..Sampler::new(filter) };
                    let mut own = vec![0f32; 150 * channels];
                    let mut truth = vec![0f64; 150 * channels];
                    let extent = Extent::Jacobian(&jacobian);
                    sampler.sample(&single, &uv, extent, &mut own).expect("samples");
                    sampler.sample(&double, &uv, extent, &mut truth).expect("samples");
                    for (i, (own, truth)) in own.iter().zip(&truth).enumerate() {
                        // Values within 0..1/4 of all texels. Places of probes are singles up to 256 texels from the
                        // middle: half an ulp, 1.5e-5, on both axes, times the steepest slope, 1/4 a texel.
                        let error = (f64::from(*own) - truth).abs();
                        assert!(
                            error < 8e-6,
                            "{filter:?} {wrap:?} {size:?} {max_anisotropy}: sample {} is {own}, not {truth}",
                            i / channels
                        );
                    }
                }
            }
        }
    }
}

/// All bits of a batch on one set.
fn bits(isa: Isa, sampler: &Sampler, texture: &Texture<'_>, uv: &[f64], extent: Extent<'_, f64>) -> Vec<u32> {
    let mut out = vec![0f32; uv.len() / 2 * texture.channels()];
    with_isa(isa, || sampler.sample(texture, uv, extent, &mut out)).expect("a set").expect("samples");
    out.iter().map(|x| x.to_bits()).collect()
}

#[test]
fn every_set_gives_the_same_bytes() {
    let mut random = Random(5);
    let dtypes = [DType::U8, DType::U16, DType::F16, DType::F32];
    for (k, wrap) in WRAPS.into_iter().enumerate() {
        for size in [[1, 1], [2, 7], [33, 16], [128, 40]] {
            for dtype in dtypes {
                for (channels, encoding, alpha) in [
                    (1, Encoding::Linear, Alpha::None),
                    (2, Encoding::Srgb, Alpha::Straight),
                    (3, Encoding::Srgb, Alpha::None),
                    (3, Encoding::Normal, Alpha::None),
                    (4, Encoding::Linear, Alpha::None),
                    (4, Encoding::Srgb, Alpha::Straight),
                    (5, Encoding::Linear, Alpha::None),
                ] {
                    let wrap = [wrap, WRAPS[(k + 3) % 7]];
                    let options = TextureOptions { wrap, encoding, alpha, ..Default::default() };
                    let texture = texture(dtype, size, channels, &options);
                    let (uv, jacobian) = places(&mut random, size, 70, 0.7);
                    for filter in FILTERS.into_iter().chain([Filter::Area, Filter::Ewa]) {
                        let sampler = Sampler::new(filter);
                        let extent = Extent::Jacobian(&jacobian);
                        let scalar = bits(Isa::Scalar, &sampler, &texture, &uv, extent);
                        for isa in Isa::available() {
                            let same = bits(isa, &sampler, &texture, &uv, extent) == scalar;
                            assert!(same, "{isa:?} {filter:?} {wrap:?} {size:?} {dtype:?} {channels}");
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn a_round_footprint_is_one_trilinear_read_bit_for_bit() {
    let options = TextureOptions { wrap: [Wrap::Repeat; 2], ..Default::default() };
    let texture = texture(DType::U8, [64, 32], 4, &options);
    let mut random = Random(11);
    let (uv, mut jacobian) = places(&mut random, [64, 32], 500, 1.0);
    for j in jacobian.chunks_exact_mut(4) {
        let size = 2f64.powf(random.between(-3.0, 6.0));
        let (sin, cos) = random.between(0.0, 7.0).sin_cos();
        j.copy_from_slice(&[cos * size / 64.0, -sin * size / 64.0, sin * size / 32.0, cos * size / 32.0]);
    }
    let [round, long] = [Filter::Trilinear, Filter::Anisotropic]
        .map(|f| bits(Isa::current(), &Sampler::new(f), &texture, &uv, Extent::Jacobian(&jacobian)));
    assert_eq!(round, long);
}

#[test]
fn equal_texels_give_exactly_their_value() {
    let mut random = Random(13);
    for wrap in WRAPS {
        let extra = if wrap == Wrap::Extend { 2 } else { 0 };
        let image = Image::new(24 + extra, 9 + extra, 3, vec![77u8; (24 + extra) * (9 + extra) * 3]);
        let options = TextureOptions { wrap: [wrap; 2], border: vec![77.0 / 255.0; 3], ..Default::default() };
        let texture = Texture::new(image.expect("an image").view(), options).expect("a texture");
        let (uv, jacobian) = places(&mut random, [24, 9], 300, 2.0);
        for filter in FILTERS {
            for x in bits(Isa::current(), &Sampler::new(filter), &texture, &uv, Extent::Jacobian(&jacobian)) {
                assert_eq!(f32::from_bits(x), 77.0f32 / 255.0, "{filter:?} {wrap:?}");
            }
        }
    }
}

#[test]
fn far_tiles_keep_the_precision_of_their_coordinates() {
    // 16384 texels a row, and tiles up to 1000 away: doubles in, less than a thousandth of a texel lost.
    let (w, h) = (16_384, 4);
    let ramp: Vec<f32> = (0..w * h).map(|i| ((i % w) % 64) as f32).collect();
    let image = Image::new(w, h, 1, ramp).expect("an image");
    let options = TextureOptions { wrap: [Wrap::Repeat; 2], ..Default::default() };
    let texture = Texture::new(image.view(), options).expect("a texture");
    let mut random = Random(17);
    for filter in FILTERS {
        for _ in 0..300 {
            let column = (random.between(0.0, 16_384.0)).floor();
            let inside = random.between(12.0, 50.0);
            let s = (column / 64.0).floor() * 64.0 + inside;
            let u = s / 16_384.0 + random.between(-1000.0, 1000.0).floor();
            let mut out = [0f32];
            // Twelve texels along the ramp, whose mean is that of its middle.
            let jacobian = [12.0 / 16_384.0, 0.0, 0.0, 0.25];
            let sampler = Sampler { max_anisotropy: 64.0, ..Sampler::new(filter) };
            let extent = Extent::Jacobian(&jacobian);
            if matches!(filter, Filter::Bilinear | Filter::Anisotropic) {
                sampler.sample(&texture, &[u, 0.5], extent, &mut out).expect("a sample");
                // u as a double near 1000 is good to 1.2e-13 of the width; the rest is rounding in singles.
                assert!((f64::from(out[0]) - (inside - 0.5)).abs() < 2e-5, "{filter:?} {inside} {out:?}");
            }
        }
    }
}
