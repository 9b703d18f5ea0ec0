use super::*;
use crate::kernel::remap::{Edge, Interpolation, Outside, Source};

const SIDES: [usize; 2] = [23, 17];

struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// The mean of the bilinear picture over a box, cell by cell, where it is a product of two linear functions.
fn truth(texel: impl Fn(i64, i64) -> f64, at: [f64; 2], half: [f64; 2]) -> f64 {
    let cuts = |axis: usize| {
        let (low, high) = (at[axis] - half[axis], at[axis] + half[axis]);
        let mut cuts = vec![low];
        let mut next = low.floor() + 1.0;
        while next < high {
            cuts.push(next);
            next += 1.0;
        }
        cuts.push(high);
        cuts
    };
    let mut total = 0.0;
    for y in cuts(1).windows(2) {
        for x in cuts(0).windows(2) {
            let (mx, my) = ((x[0] + x[1]) / 2.0, (y[0] + y[1]) / 2.0);
            let (i, j) = (mx.floor(), my.floor());
            let (fx, fy) = (mx - i, my - j);
            let (i, j) = (i as i64, j as i64);
            let upper = texel(i, j) * (1.0 - fx) + texel(i + 1, j) * fx;
            let lower = texel(i, j + 1) * (1.0 - fx) + texel(i + 1, j + 1) * fx;
            total += (upper * (1.0 - fy) + lower * fy) * (x[1] - x[0]) * (y[1] - y[0]);
        }
    }
    total / (4.0 * half[0] * half[1])
}

fn compare<T: Sample + PartialEq + std::fmt::Debug>(
    channels: usize,
    draw: impl Fn(f64) -> T,
    full: f64,
    bound: f64,
    top: f64,
) {
    let mut random = Random(channels as u64 + 5);
    let [w, h] = SIDES;
    let data: Vec<T> = (0..w * h * channels).map(|_| draw(random.unit())).collect();
    let border: Vec<T> = (0..channels).map(|_| draw(random.unit())).collect();
    let n = 300;
    let (mut x, mut y) = (Vec::new(), Vec::new());
    for _ in 0..n {
        x.push((random.unit() * (w as f64 + 12.0) - 6.0) as f32);
        y.push((random.unit() * (h as f64 + 12.0) - 6.0) as f32);
    }
    (x[0], y[0], x[1], y[1], x[2]) = (1e9, -1e9, 3.0, 4.0, -0.0);
    for edges in [[Edge::Repeat, Edge::Clamp], [Edge::Border; 2], [Edge::Mirror; 2]] {
        let source = Source::new(&data, w, h, channels, w * channels).expect("fits");
        let job = Job::new(source, Interpolation::Bilinear, edges, &border, Outside::Colour).expect("fits");
        for (half, lean) in [
            ([[0.5, 0.0], [0.5, 0.0]], [0.0, 0.0]),
            ([[1.0, -0.003], [0.02, 0.003]], [0.0, 0.0]),
            ([[0.0, 0.0], [3.0, 0.0]], [0.0, 0.0]),
            ([[0.6, 0.001], [0.9, 0.0]], [-0.2, 0.002]),
        ] {
            let given = Boxes { x: &x, y: &y, half, lean };
            let taps = &mut Taps::default();
            let mut want = vec![T::default(); n * channels];
            boxes(Isa::Scalar, &job, &given, taps, &mut want).expect("fits");
            let mut wide = vec![T::Acc::default(); n * channels];
            box_numbers(Isa::Scalar, &job, &given, taps, &mut wide).expect("fits");
            for isa in Isa::available() {
                let mut got = vec![T::default(); n * channels];
                boxes(isa, &job, &given, taps, &mut got).expect("fits");
                assert_eq!(got, want, "{isa:?}");
                let mut numbers = vec![T::Acc::default(); n * channels];
                box_numbers(isa, &job, &given, taps, &mut numbers).expect("fits");
                assert!(numbers == wide, "{isa:?}");
            }
            for i in 1..n {
                let side = |axis: usize| {
                    f64::from((half[axis][0] + half[axis][1] * i as f32).clamp(HALF[0], HALF[1]))
                };
                for c in 0..channels {
                    let texel = |i: i64, j: i64| {
                        let at = (edges[0].index(i, w as i64), edges[1].index(j, h as i64));
                        let value = match at {
                            (Some(x), Some(y)) => data[(y * w + x) * channels + c],
                            _ => border[c],
                        };
                        value.get().wide()
                    };
                    let at = [f64::from(x[i]), f64::from(y[i])];
                    let mean = |dx: f64, dy: f64| truth(texel, [at[0] + dx, at[1] + dy], [side(0), side(1)]);
                    let mut true_mean = mean(0.0, 0.0);
                    if lean[0] != 0.0 {
                        let across =
                            |e: f64| (mean(e, e) - mean(-e, e) - mean(e, -e) + mean(-e, -e)) / (4.0 * e * e);
                        let lean = f64::from(lean[0] + lean[1] * i as f32).clamp(-0.4, 0.4);
                        true_mean += lean * across(1e-4);
                    }
                    let off = (wide[i * channels + c].wide() - true_mean.min(top)).abs() / full;
                    assert!(off < bound, "{at:?} {half:?}: {off}");
                }
            }
        }
    }
}

/// Against the integral, and its second derivative across. Places are singles: near 30 off by 2^-20; bytes add twelve
/// roundings of half of 1/128 of a code and twelve of weights by 2^-16 of at most 255 codes; the differences are of steps
/// of 1e-4, across which slopes of up to two a texel squared bend. Bytes end at 16 bits.
#[test]
fn boxes_are_integrals_on_every_set() {
    for channels in 1..=5 {
        let slack = 2e-4;
        let bytes = 12.0 * 0.5 / 128.0 / 255.0 + 12.0 / 65_536.0 + slack;
        compare(channels, |x| (x * 255.0).round() as u8, 255.0, bytes, 32_767.0 / 128.0);
        compare(channels, |x| (x * 65_535.0).round() as u16, 65_535.0, slack, f64::INFINITY);
        compare(channels, |x| x as f32, 1.0, slack, f64::INFINITY);
        compare(channels, |x| x, 1.0, slack, f64::INFINITY);
    }
}

#[test]
fn equal_texels_stay() {
    for value in [0u8, 1, 100, 254, 255] {
        let data = vec![value; 12 * 12 * 3];
        let source = Source::new(&data, 12, 12, 3, 36).expect("fits");
        let border = [value; 3];
        let job = Job::new(source, Interpolation::Bilinear, [Edge::Border; 2], &border, Outside::Colour)
            .expect("fits");
        let x: Vec<f32> = (0..200).map(|i| i as f32 * 0.071 - 1.0).collect();
        let mut out = vec![7; 600];
        let given = Boxes { x: &x, y: &x, half: [[0.0, 0.01], [0.9, 0.0]], lean: [0.3, -0.004] };
        boxes(Isa::current(), &job, &given, &mut Taps::default(), &mut out).expect("fits");
        assert!(out.iter().all(|v| *v == value));
    }
}

#[test]
fn lengths_are_checked() {
    let data = [0f32; 4];
    let source = Source::new(&data, 2, 2, 1, 2).expect("fits");
    let job =
        Job::new(source, Interpolation::Bilinear, [Edge::Clamp; 2], &[0.0], Outside::Colour).expect("fits");
    let given = Boxes { x: &[0.0; 2], y: &[0.0], half: [[0.5, 0.0]; 2], lean: [0.0; 2] };
    let taps = &mut Taps::default();
    assert!(boxes(Isa::current(), &job, &given, taps, &mut [0.0; 2]).is_err());
    let given = Boxes { x: &[0.0; 2], y: &[0.0; 2], half: [[0.5, 0.0]; 2], lean: [0.0; 2] };
    assert!(boxes(Isa::current(), &job, &given, taps, &mut [0.0; 3]).is_err());
}
