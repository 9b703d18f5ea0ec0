//! Sampling and warping through the public interface: any numbers, any thread count.

use multum::par::with_threads;
use multum::warp::{Mapping, Maps, WarpOptions, warp};
use multum::{Extent, Filter, Image, Sampler, Texture, TextureOptions, Wrap};
use proptest::prelude::*;

fn noise(width: usize, height: usize, channels: usize) -> Vec<u8> {
    (0..(width * height * channels) as u64)
        .map(|i| (i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 56) as u8)
        .collect()
}

fn filters() -> Vec<Filter> {
    let mut all: Vec<_> = Filter::NAMES.iter().map(|(_, filter)| *filter).collect();
    all.dedup();
    all
}

#[test]
fn every_filter_gives_the_same_bytes_for_any_thread_count() {
    let samples = 20_000usize;
    let numbers = |n: usize, scale: f64| -> Vec<f64> {
        (0..n).map(|i| ((i as f64 * 0.618_033_988_75).fract() * 3.0 - 1.0) * scale).collect()
    };
    let (uv, jacobian) = (numbers(2 * samples, 1.0), numbers(4 * samples, 0.02));
    for filter in filters() {
        let run = |threads| {
            with_threads(Some(threads), || {
                let image = Image::new(67, 45, 3, noise(67, 45, 3)).expect("a whole image");
                let options =
                    TextureOptions { wrap: [Wrap::Repeat, Wrap::Mirror], ..TextureOptions::default() };
                let texture = Texture::new(image.view(), options).expect("a texture");
                let mut out = vec![0f32; samples * 3];
                Sampler::new(filter)
                    .sample(&texture, &uv, Extent::Jacobian(&jacobian), &mut out)
                    .expect("samples");
                out.iter().map(|x| x.to_bits()).collect::<Vec<_>>()
            })
        };
        let one = run(1);
        assert!(run(2) == one && run(7) == one, "{filter:?}");
    }
}

/// Any bit pattern is a coordinate.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![any::<u64>().prop_map(f64::from_bits), -4.0..4.0, Just(0.0), Just(f64::INFINITY)]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, ..ProptestConfig::default() })]

    /// No filter panics, and results are averages of texels: finite, and within the cubics' overshoot.
    #[test]
    fn any_number_gives_a_finite_result(
        uv in prop::array::uniform2(any_number()),
        jacobian in prop::array::uniform4(any_number()),
        lod in any::<u32>().prop_map(f32::from_bits),
        wrap in prop::sample::select(Wrap::NAMES.to_vec()),
        width in 3usize..9,
        height in 3usize..9,
    ) {
        let image = Image::new(width, height, 2, noise(width, height, 2)).expect("a whole image");
        let options = TextureOptions { wrap: [wrap.1; 2], ..TextureOptions::default() };
        let texture = Texture::new(image.view(), options).expect("a texture");
        for filter in filters() {
            let sampler = Sampler::new(filter);
            let mut out = [f32::NAN; 2];
            sampler.sample(&texture, &uv, Extent::Jacobian(&jacobian), &mut out).expect("a sample");
            prop_assert!(out.iter().all(|x| x.is_finite() && x.abs() < 1.6), "{filter:?} {out:?}");
            sampler.sample(&texture, &uv, Extent::Lod(&[lod]), &mut out).expect("a sample");
            prop_assert!(out.iter().all(|x| x.is_finite() && x.abs() < 1.6), "{filter:?} {out:?}");
        }
    }

    /// The same for maps and matrices of any numbers.
    #[test]
    fn any_map_gives_a_picture(
        numbers in prop::collection::vec(any_number(), 24),
        wrap in prop::sample::select(Wrap::NAMES[..6].to_vec()),
    ) {
        let image = Image::new(5, 4, 1, noise(5, 4, 1)).expect("a whole image");
        for filter in filters() {
            let options = WarpOptions {
                sampler: Sampler::new(filter), wrap: [wrap.1; 2], ..WarpOptions::default()
            };
            let map = Mapping::Double(Maps::pairs(&numbers, [None; 2]));
            let made = warp(image.view(), &map, 4, 3, &options).expect("a picture");
            prop_assert_eq!((made.width(), made.height()), (4, 3));
            let rows = [[numbers[0], numbers[1], numbers[2]], [numbers[3], numbers[4], numbers[5]],
                [numbers[6], numbers[7], numbers[8]]];
            let made = warp(image.view(), &Mapping::from_matrix(rows), 4, 3, &options);
            // A matrix with a number that is not finite is refused, all others are maps.
            prop_assert_eq!(made.is_ok(), numbers[..9].iter().all(|x| x.is_finite()));
        }
    }
}
