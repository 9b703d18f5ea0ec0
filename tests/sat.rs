//! Summed-area tables against sums over written-out pictures.

use multum::sat::{SummedAreaTable, Table};
use multum::{DType, Image, Wrap, par};

fn noise(width: usize, height: usize, channels: usize, seed: u64) -> Vec<f64> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..width * height * channels).map(|_| next()).collect()
}

fn bytes(width: usize, height: usize, channels: usize, seed: u64) -> (Image, Vec<f64>) {
    let codes: Vec<u8> = noise(width, height, channels, seed).iter().map(|x| (x * 255.99) as u8).collect();
    let values = codes.iter().map(|&c| f64::from(c) / 255.0).collect();
    (Image::new(width, height, channels, codes).unwrap(), values)
}

/// The axis written out from `-reach` to `n + reach`: which texel stands at each place, none for the border.
fn written_out(wrap: Wrap, n: i64, reach: i64) -> Vec<Option<usize>> {
    let cycle: Vec<i64> = match wrap {
        Wrap::Mirror => (0..n).chain((0..n).rev()).collect(),
        Wrap::Mirror101 => (0..n).chain((1..(n - 1).max(1)).rev()).collect(),
        _ => (0..n).collect(),
    };
    (-reach..n + reach)
        .map(|i| match wrap {
            Wrap::Repeat | Wrap::Mirror | Wrap::Mirror101 => {
                let c = cycle.len() as i64;
                Some(cycle[((i % c + c) % c) as usize] as usize)
            }
            Wrap::Border => (i >= 0 && i < n).then_some(i as usize),
            Wrap::MirrorOnce if i < 0 => Some((-1 - i).min(n - 1) as usize),
            _ => Some(i.clamp(0, n - 1) as usize),
        })
        .collect()
}

/// Share of each written-out texel that lies between `a` and `b`.
fn shares(a: f64, b: f64, count: usize, reach: i64) -> Vec<f64> {
    (0..count)
        .map(|i| {
            let low = (i as i64 - reach) as f64;
            (b.min(low + 1.0) - a.max(low)).max(0.0)
        })
        .collect()
}

#[test]
fn every_box_of_a_small_image_is_the_direct_sum() {
    let (image, values) = bytes(5, 5, 3, 1);
    let sat = SummedAreaTable::new(image.view(), [Wrap::Clamp; 2], None).unwrap();
    assert!(matches!(sat.table(), Table::U32(t) if t.len() == 6 * 6 * 3));
    for y0 in 0..=5usize {
        for y1 in y0..=5 {
            for x0 in 0..=5usize {
                for x1 in x0..=5 {
                    let sum = sat.sum_rect::<3>(x0 as f64, y0 as f64, x1 as f64, y1 as f64);
                    for (c, sum) in sum.iter().enumerate() {
                        let texel = |x: usize, y: usize| values[(y * 5 + x) * 3 + c] * 255.0;
                        let codes: f64 = (y0..y1).flat_map(|y| (x0..x1).map(move |x| texel(x, y))).sum();
                        assert_eq!(*sum, codes.round() / 255.0);
                    }
                }
            }
        }
    }
}

#[test]
fn every_wrap_is_the_written_out_picture_at_any_extent() {
    for (w, h) in [(1, 1), (2, 3), (5, 4), (1, 7)] {
        let (image, values) = bytes(w, h, 2, 9);
        let border = [0.25, 2.0];
        for (_, wx) in Wrap::NAMES {
            for wy in [wx, Wrap::Repeat, Wrap::Border] {
                if wx == Wrap::Extend || wy == Wrap::Extend {
                    continue;
                }
                let sat = SummedAreaTable::new(image.view(), [wx, wy], Some(&border)).unwrap();
                let reach = 3 * w.max(h) as i64;
                let (xs, ys) = (written_out(wx, w as i64, reach), written_out(wy, h as i64, reach));
                for k in 0..400 {
                    let step = |salt: usize, n: usize| {
                        let raw = (k * 7919 + salt * 104_729) % (80 * n);
                        raw as f64 / 16.0 - 2.0 * n as f64
                    };
                    let (a, b) = (step(1, w), step(2, w));
                    let (c, d) = (step(3, h), step(4, h));
                    let (x0, x1, y0, y1) = (a.min(b), a.max(b), c.min(d), c.max(d));
                    let (px, py) = (shares(x0, x1, xs.len(), reach), shares(y0, y1, ys.len(), reach));
                    let mut want = [0.0; 2];
                    for (j, q) in py.iter().enumerate().filter(|(_, q)| **q > 0.0) {
                        for (i, p) in px.iter().enumerate().filter(|(_, p)| **p > 0.0) {
                            for (ch, want) in want.iter_mut().enumerate() {
                                let value = match (xs[i], ys[j]) {
                                    (Some(x), Some(y)) => values[(y * w + x) * 2 + ch],
                                    _ => border[ch],
                                };
                                *want += p * q * value;
                            }
                        }
                    }
                    let sum = sat.sum_rect::<2>(x0, y0, x1, y1);
                    let reversed = sat.sum_rect::<2>(x1, y0, x0, y1);
                    let mean = sat.mean_rect::<2>(x1, y0, x0, y1);
                    let area = (x1 - x0) * (y1 - y0);
                    for ch in 0..2 {
                        let bound = 1e-13 * (1.0 + area * 2.0);
                        let place = format!("{wx:?} {wy:?} {w}x{h} [{x0}, {x1}] x [{y0}, {y1}]");
                        assert!((sum[ch] - want[ch]).abs() <= bound, "{place}: {} {}", sum[ch], want[ch]);
                        assert_eq!(reversed[ch], -sum[ch], "{place}");
                        if area > 0.0 {
                            assert!((mean[ch] * area - want[ch]).abs() <= bound, "{place}: mean");
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn extend_continues_the_extra_texels() {
    let (image, values) = bytes(5, 4, 1, 3);
    let sat = SummedAreaTable::new(image.view(), [Wrap::Extend; 2], None).unwrap();
    // The texture is the inner 3 x 2; texel (0, 0) is the image's (1, 1).
    assert_eq!(sat.sum_rect::<1>(0.0, 0.0, 1.0, 1.0), [values[6]]);
    assert_eq!(sat.sum_rect::<1>(-1.0, -1.0, 0.0, 0.0), [values[0]]);
    let far = sat.sum_rect::<1>(-9.0, -5.0, -8.0, -4.0)[0];
    assert!((far - values[0]).abs() < 1e-15);
    let mut out = [0.0];
    sat.boxes_uv(&[[0.0, 0.0, 1.0, 1.0]], true, &mut out).unwrap();
    let inner: f64 = [6, 7, 8, 11, 12, 13].iter().map(|&i| values[i]).sum();
    assert!((out[0] - inner / 6.0).abs() < 1e-15);
    assert!(SummedAreaTable::new(bytes(2, 9, 1, 1).0.view(), [Wrap::Extend; 2], None).is_err());
}

#[test]
fn a_sliding_box_is_linear_between_texels_and_a_point_is_its_texel() {
    let (image, values) = bytes(8, 8, 1, 4);
    let sat = SummedAreaTable::new(image.view(), [Wrap::Repeat; 2], None).unwrap();
    let at = |k: i32| sat.sum_rect::<1>(f64::from(k) / 100.0, 2.0, f64::from(k) / 100.0 + 1.7, 3.0)[0];
    for k in 1..799 {
        // Kinks where a side meets a texel's edge, and nowhere else.
        let kink = k % 100 == 0 || (k + 170) % 100 == 0;
        let bend = (at(k + 1) - 2.0 * at(k) + at(k - 1)).abs();
        assert!(kink || bend < 1e-14, "{k}: {bend}");
        assert!(bend < 0.0101);
    }
    for i in 0..8 {
        for f in [0.0, 0.3, 0.999] {
            let x = f64::from(i) + f;
            assert_eq!(sat.mean_rect::<1>(x, 5.5, x, 5.5), [values[5 * 8 + i as usize]]);
            assert_eq!(sat.sum_rect::<1>(x, 5.5, x, 7.5), [0.0]);
            let thin = sat.mean_rect::<1>(x, 5.5, x + 1e-9 * (1.0 - f), 5.5)[0];
            assert!((thin - values[5 * 8 + i as usize]).abs() < 1e-15);
        }
    }
    // A side without length averages along the other one only.
    let column = sat.mean_rect::<1>(3.5, 0.0, 3.5, 8.0)[0];
    let want = (0..8).map(|y| values[y * 8 + 3]).sum::<f64>() / 8.0;
    assert!((column - want).abs() < 1e-15);
    let border = SummedAreaTable::new(image.view(), [Wrap::Border; 2], Some(&[0.5])).unwrap();
    assert_eq!(border.mean_rect::<1>(-2.0, 3.0, -2.0, 3.0), [0.5]);
}

#[test]
fn far_corners_are_exact_past_two_to_the_24() {
    let n = 4200;
    for (value, wide) in [(1u8, false), (255, true)] {
        let image = Image::new(n, n, 1, vec![value; n * n]).unwrap();
        let sat = SummedAreaTable::new(image.view(), [Wrap::Clamp; 2], None).unwrap();
        assert!(matches!(sat.table(), Table::U64(_)), "{wide}");
        let f = n as f64;
        let corner = sat.sum_rect::<1>(f - 1.0, f - 1.0, f, f);
        assert_eq!(corner, [f64::from(value) / 255.0]);
        assert_eq!(sat.sum_rect::<1>(0.0, 0.0, f, f), [f * f * f64::from(value) / 255.0]);
    }
    let largest = Image::new(4104, 4104, 1, vec![255u8; 4104 * 4104]).unwrap();
    let sat = SummedAreaTable::new(largest.view(), [Wrap::Clamp; 2], None).unwrap();
    assert!(matches!(sat.table(), Table::U32(t) if t.last() == Some(&(4104 * 4104 * 255))));
    assert_eq!(sat.mean_rect::<1>(0.0, 0.0, 4104.0, 4104.0), [1.0]);
}

#[test]
fn small_boxes_of_a_large_noisy_image_keep_nine_digits() {
    let n = 4096;
    for offset in [0.0, 1000.0] {
        let texels: Vec<f64> = noise(n, n, 1, 6).iter().map(|x| x + offset).collect();
        let singles: Vec<f32> = texels.iter().map(|&x| x as f32).collect();
        let exact: [Vec<f64>; 2] = [singles.iter().map(|&x| f64::from(x)).collect(), texels.clone()];
        let images = [Image::new(n, n, 1, singles).unwrap(), Image::new(n, n, 1, texels).unwrap()];
        for (image, exact) in images.iter().zip(&exact) {
            let sat = SummedAreaTable::new(image.view(), [Wrap::Clamp; 2], None).unwrap();
            for k in 0..10_000 {
                let (x, y) =
                    if k == 0 { (n - 3, n - 3) } else { (k * 7919 % (n - 2), k * 104_729 % (n - 2)) };
                let sum = sat.sum_rect::<1>(x as f64, y as f64, x as f64 + 3.0, y as f64 + 3.0)[0];
                let row = |j: usize| exact[(y + j) * n + x..][..3].iter().sum::<f64>();
                let want = row(0) + row(1) + row(2);
                assert!((sum - want).abs() <= 1e-9 * want, "{:?} {x} {y}: {sum} {want}", image.dtype());
            }
        }
    }
}

#[test]
fn constants_are_exact_everywhere() {
    let images = [
        Image::new(13, 7, 5, vec![201u8; 13 * 7 * 5]).unwrap(),
        Image::new(13, 7, 5, vec![40_001u16; 13 * 7 * 5]).unwrap(),
        Image::new(13, 7, 5, vec![0.3f32; 13 * 7 * 5]).unwrap(),
    ];
    for (image, value) in images.iter().zip([201.0 / 255.0, 40_001.0 / 65_535.0, f64::from(0.3f32)]) {
        for (_, wrap) in Wrap::NAMES {
            let border = [value; 5];
            let sat = SummedAreaTable::new(image.view(), [wrap; 2], Some(&border)).unwrap();
            let boxes = [
                [0.1, 0.2, 0.7, 0.9],
                [-3.3, 0.0, 11.0, 5.0],
                [0.5; 4],
                [-1e300, -1e300, 1e300, 2.0],
                [7.0, 7.0, 7.0 + 1e-13, 1e-200],
            ];
            let mut out = [0.0; 25];
            sat.boxes_uv(&boxes, true, &mut out).unwrap();
            for mean in out {
                assert!((mean - value).abs() <= 4.0 * f64::EPSILON, "{wrap:?}: {mean}, not {value}");
                assert_eq!(mean as f32, value as f32);
            }
        }
    }
}

#[test]
fn coordinates_that_are_no_numbers_give_the_border_colour() {
    let (image, _) = bytes(4, 4, 2, 4);
    let sat = SummedAreaTable::new(image.view(), [Wrap::Repeat; 2], Some(&[0.5, 0.75])).unwrap();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for k in 0..4 {
            let mut b = [0.0, 0.0, 1.0, 1.0];
            b[k] = bad;
            assert_eq!(sat.mean_rect::<2>(b[0], b[1], b[2], b[3]), [0.5, 0.75]);
            assert!(sat.sum_rect::<2>(b[0], b[1], b[2], b[3]).iter().all(|x| x.is_nan()));
        }
    }
    assert!(SummedAreaTable::new(image.view(), [Wrap::Clamp; 2], Some(&[0.0])).is_err());
    assert!(SummedAreaTable::new(image.view(), [Wrap::Clamp; 2], Some(&[0.0, f64::NAN])).is_err());
}

#[test]
fn tables_do_not_depend_on_threads() {
    let numbers = noise(301, 333, 3, 2);
    let images = [
        bytes(301, 333, 3, 2).0,
        Image::new(301, 333, 3, numbers.iter().map(|x| (x * 65_535.0) as u16).collect::<Vec<_>>()).unwrap(),
        Image::new(301, 333, 3, numbers.iter().map(|&x| x as f32).collect::<Vec<_>>()).unwrap(),
        Image::new(301, 333, 3, numbers).unwrap(),
    ];
    for image in &images {
        let run = |n| {
            par::with_threads(Some(n), || {
                SummedAreaTable::new(image.view(), [Wrap::Clamp; 2], None).unwrap().table().clone()
            })
        };
        let one = run(1);
        assert_eq!(run(2), one);
        assert_eq!(run(5), one);
        match (&one, image.dtype()) {
            (Table::U32(_), DType::U8) | (Table::U64(_), DType::U16) | (Table::F64(_), _) => {}
            _ => panic!("wrong sums for {:?}", image.dtype()),
        }
    }
}
