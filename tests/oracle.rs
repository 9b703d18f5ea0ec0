//! The reference against closed forms and against a second integration, by polygon moments on the texture.

use multum::oracle::{Alpha, Crew, Encoding, Options, Pixel, PixelFilter, Reconstruction, Signal, Wrap};
use multum::{Error, Image};

/// Numbers in [0, 1) that look random: the fractional parts of a quadratic sequence.
fn noise(count: usize, seed: f64) -> Vec<f64> {
    (0..count)
        .map(|i| (i as f64 * i as f64 * 0.618_033_988_749 + i as f64 * 0.754_877 + seed).fract())
        .collect()
}

fn signal(width: usize, height: usize, data: Vec<f64>, wrap: Wrap, kind: Reconstruction) -> Signal {
    let image = Image::new(width, height, data.len() / (width * height), data).unwrap();
    let options = Options { wrap: [wrap; 2], border: vec![0.25], reconstruction: kind, ..Options::default() };
    Signal::new(image.view(), &options).unwrap()
}

const KINDS: [Reconstruction; 3] =
    [Reconstruction::Nearest, Reconstruction::Bilinear, Reconstruction::Bicubic];
const FILTERS: [PixelFilter; 3] = [PixelFilter::Box, PixelFilter::Tent, PixelFilter::Gaussian { sigma: 0.5 }];

#[test]
fn constants_stay_for_every_wrap_kernel_and_filter() {
    for (_, wrap) in Wrap::ALL {
        for kind in KINDS {
            let flat = signal(5, 4, vec![0.25; 20], wrap, kind);
            for filter in FILTERS {
                let pixel = Pixel::new(filter, kind);
                for jacobian in
                    [[[0.1, 0.3], [-0.2, 0.4]], [[3.0, 0.1], [0.2, 2.0]], [[0.5, 0.5], [0.5, 0.5]]]
                {
                    let got = flat.sample([0.9, -0.2], Some(jacobian), &pixel, 1e-9).unwrap();
                    let smooth = matches!(filter, PixelFilter::Gaussian { .. });
                    assert!(if smooth { got.error < 1e-8 } else { got.error == 0.0 });
                    assert!(
                        (got.values[0] - 0.25).abs() < 1e-14 + got.error,
                        "{wrap:?} {kind:?} {filter:?} {got:?}"
                    );
                }
            }
        }
    }
}

/// Catmull-Rom reproduces quadratics, so x², xy and y² average to the squares at the centre plus the second
/// moments of the footprint: the filter's variance (1/12, 1/6, sigma² less the tails) times J Jᵀ.
#[test]
fn quadratics_measure_the_variance_of_the_filter() {
    let (width, height) = (40usize, 30usize);
    let data = (0..width * height).flat_map(|k| {
        let (x, y) = ((k % width) as f64 + 0.5, (k / width) as f64 + 0.5);
        [x, y, x * x, x * y, y * y]
    });
    let ramps = signal(width, height, data.collect(), Wrap::Clamp, Reconstruction::Bicubic);
    // A normal variable that is cut off at 4 deviations loses 8 phi(4) / (2 Phi(4) - 1) of its variance.
    let cut = 1.0 - 8.0 * 1.338_302_257_648_853_7e-4 / 0.999_936_657_516_334;
    for (filter, variance) in [
        (PixelFilter::Box, 1.0 / 12.0),
        (PixelFilter::Tent, 1.0 / 6.0),
        (PixelFilter::Gaussian { sigma: 0.5 }, 0.25 * cut),
        (PixelFilter::Gaussian { sigma: 0.3 }, 0.09 * cut),
    ] {
        let pixel = Pixel::new(filter, Reconstruction::Bicubic);
        for [a, b, c, d] in
            [[3.0, 1.0, -0.5, 2.0], [0.2, 0.0, 0.1, 0.05], [2.0, 2.0, 2.0, 2.0], [0.0, 3.0, 0.0, 0.0]]
        {
            let (cx, cy) = (19.3, 14.8);
            let (w, h) = (width as f64, height as f64);
            let jacobian = [[a / w, b / w], [c / h, d / h]];
            let got = ramps.sample([cx / w, cy / h], Some(jacobian), &pixel, 1e-11).unwrap();
            let expected = [
                cx,
                cy,
                cx * cx + variance * (a * a + b * b),
                cx * cy + variance * (a * c + b * d),
                cy * cy + variance * (c * c + d * d),
            ];
            for (value, want) in got.values.iter().zip(expected) {
                assert!((value - want).abs() < 1e-9, "{filter:?} {jacobian:?}: {value} {want}");
            }
        }
    }
}

#[test]
fn the_impulse_spreads_by_one_six_one_over_edge_aligned_boxes() {
    let mut data = vec![0.0; 25];
    data[12] = 64.0;
    let impulse = signal(5, 5, data, Wrap::Clamp, Reconstruction::Bilinear);
    let pixel = Pixel::new(PixelFilter::Box, Reconstruction::Bilinear);
    for y in 0..5usize {
        for x in 0..5usize {
            let weight = |i: usize| [0.0, 1.0, 6.0, 1.0, 0.0][i];
            let uv = [(x as f64 + 0.5) / 5.0, (y as f64 + 0.5) / 5.0];
            let got = impulse.sample(uv, Some([[0.2, 0.0], [0.0, 0.2]]), &pixel, 1e-9).unwrap();
            assert!((got.values[0] - weight(x) * weight(y)).abs() < 1e-13);
            // Between four centres the mean is the plain mean of the corners.
            let got = impulse
                .sample([uv[0] + 0.1, uv[1] + 0.1], Some([[0.2, 0.0], [0.0, 0.2]]), &pixel, 1e-9)
                .unwrap();
            let near = (1..3).contains(&x) && (1..3).contains(&y);
            assert!((got.values[0] - if near { 16.0 } else { 0.0 }).abs() < 1e-13);
        }
    }
}

/// Integral of `1`, `x`, `y` and `x y` over a polygon, corner by corner (Green's theorem).
fn moments(polygon: &[[f64; 2]]) -> [f64; 4] {
    let mut sum = [0.0; 4];
    for (i, &[x0, y0]) in polygon.iter().enumerate() {
        let [x1, y1] = polygon[(i + 1) % polygon.len()];
        let cross = x0 * y1 - x1 * y0;
        sum[0] += cross / 2.0;
        sum[1] += cross * (x0 + x1) / 6.0;
        sum[2] += cross * (y0 + y1) / 6.0;
        sum[3] += cross * (2.0 * x0 * y0 + x0 * y1 + x1 * y0 + 2.0 * x1 * y1) / 24.0;
    }
    sum
}

/// The part of a polygon where `sign * (p[axis] - edge)` is not negative.
fn clip(polygon: &[[f64; 2]], axis: usize, edge: f64, sign: f64) -> Vec<[f64; 2]> {
    let mut kept = Vec::new();
    for (i, &p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let (d, e) = (sign * (p[axis] - edge), sign * (q[axis] - edge));
        if d >= 0.0 {
            kept.push(p);
        }
        if (d < 0.0) != (e < 0.0) {
            kept.push([0, 1].map(|k| p[k] + d / (d - e) * (q[k] - p[k])));
        }
    }
    kept
}

/// Mean of the bilinear reconstruction over a polygon in texels, cell after cell.
fn by_moments(texel: &dyn Fn(i64, i64) -> f64, polygon: &[[f64; 2]]) -> f64 {
    let limit =
        |axis: usize, pick: fn(f64, f64) -> f64| polygon.iter().map(|p| p[axis]).reduce(pick).unwrap();
    let range =
        |axis| (limit(axis, f64::min) - 0.5).floor() as i64..=(limit(axis, f64::max) - 0.5).floor() as i64;
    let (mut sum, mut area) = (0.0, 0.0);
    for j in range(1) {
        for i in range(0) {
            let (x, y) = (i as f64 + 0.5, j as f64 + 0.5);
            let mut part = clip(polygon, 0, x, 1.0);
            for (axis, edge, sign) in [(0, x + 1.0, -1.0), (1, y, 1.0), (1, y + 1.0, -1.0)] {
                part = clip(&part, axis, edge, sign);
            }
            if part.is_empty() {
                continue;
            }
            let part: Vec<_> = part.iter().map(|p| [p[0] - x, p[1] - y]).collect();
            let [one, mx, my, mxy] = moments(&part);
            let (a, b, c, d) = (texel(i, j), texel(i + 1, j), texel(i, j + 1), texel(i + 1, j + 1));
            sum += a * one + (b - a) * mx + (c - a) * my + (a - b - c + d) * mxy;
            area += one;
        }
    }
    sum / area
}

#[test]
fn parallelograms_and_quads_agree_with_polygon_moments() {
    let (width, height) = (7i64, 5i64);
    let data = noise(35, 0.3);
    for wrap in [Wrap::Clamp, Wrap::Repeat, Wrap::Border] {
        let texture = signal(7, 5, data.clone(), wrap, Reconstruction::Bilinear);
        let texel = |i: i64, j: i64| match wrap {
            Wrap::Clamp => data[(j.clamp(0, 4) * 7 + i.clamp(0, 6)) as usize],
            Wrap::Repeat => data[(j.rem_euclid(height) * 7 + i.rem_euclid(width)) as usize],
            _ if (0..width).contains(&i) && (0..height).contains(&j) => data[(j * 7 + i) as usize],
            _ => 0.25,
        };
        let pixel = Pixel::new(PixelFilter::Box, Reconstruction::Bilinear);
        let random = noise(6 * 200, 0.1);
        for row in random.chunks(6) {
            let (cx, cy) = (row[0] * 14.0 - 3.5, row[1] * 10.0 - 2.5);
            let [a, b, c, d] = [row[2], row[3], row[4], row[5]].map(|x| (x - 0.5) * 24.0);
            let jacobian = [[a / 7.0, b / 7.0], [c / 5.0, d / 5.0]];
            let got = texture.sample([cx / 7.0, cy / 5.0], Some(jacobian), &pixel, 1e-9).unwrap().values[0];
            let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]
                .map(|[s, t]| [cx + a * s + b * t, cy + c * s + d * t]);
            let expected = by_moments(&texel, &corners);
            // Thin footprints cost the moments digits, not the reference.
            let thin = 144.0 / (a * d - b * c).abs();
            assert!((got - expected).abs() < 1e-12 * (1.0 + thin), "{wrap:?} {jacobian:?} {got} {expected}");

            // A convex quad: the parallelogram with one corner moved along its diagonal.
            let mut quad = corners;
            quad[2] = [0, 1].map(|k| quad[2][k] + row[0] * 0.9 * (corners[2][k] - corners[0][k]));
            let uv = quad.map(|[x, y]| [x / 7.0, y / 5.0]);
            let got = texture.quad(uv).unwrap()[0];
            let expected = by_moments(&texel, &quad);
            assert!((got - expected).abs() < 1e-12 * (1.0 + thin), "{wrap:?} {quad:?} {got} {expected}");
        }
    }
}

/// A perspective with a closed form: x / (1 + k x) over the unit pixel, for a linear ramp.
#[test]
fn a_perspective_of_a_ramp_has_a_closed_form() {
    let ramp: Vec<f64> = (0..200).map(f64::from).collect();
    let texture = signal(200, 1, ramp, Wrap::Clamp, Reconstruction::Bilinear);
    let pixel = Pixel::new(PixelFilter::Box, Reconstruction::Bilinear);
    let mut never = || false;
    for k in [0.01, 0.1, 0.7] {
        let matrix = [[40.0, 0.0, 3.0], [0.0, 1.0, 0.0], [k, 0.0, 1.0]];
        let field = texture.warp(matrix, [3, 1], &pixel, 1e-10, &mut Crew::new(0, &mut never)).unwrap();
        for x in 0..3 {
            // (40 x + 3) / (k x + 1) = 40 / k + (3 - 40 / k) / (k x + 1)
            let (from, to) = (f64::from(x) - 0.5, f64::from(x) + 0.5);
            let exact = |a: f64, b: f64| {
                (b - a) * 40.0 / k + (3.0 - 40.0 / k) / k * ((k * b + 1.0) / (k * a + 1.0)).ln()
            };
            // Left of the first texel's centre the ramp is flat at 0.
            let expected = exact(f64::max(from, -3.0 / 40.0), to);
            let got = field.values[x as usize];
            assert!((got - expected).abs() < 1e-9, "{k} {x}: {got} {expected}");
            assert!(field.errors[x as usize] < 1e-9);
        }
    }
}

#[test]
fn any_map_converges_to_the_matrix_and_threads_change_nothing() {
    let texture = signal(16, 16, noise(256, 0.7), Wrap::Repeat, Reconstruction::Bilinear);
    let matrix = [[3.0, 0.4, 1.0], [-0.2, 2.5, 0.5], [0.004, 0.01, 1.0]];
    let pixel = Pixel::new(PixelFilter::Box, Reconstruction::Bilinear);
    let mut never = || false;
    let truth = texture.warp(matrix, [9, 7], &pixel, 1e-10, &mut Crew::new(1, &mut never)).unwrap();
    let mut map = |places: &[[f64; 2]]| {
        let row = |r: usize, [x, y]: [f64; 2]| matrix[r][0] * x + matrix[r][1] * y + matrix[r][2];
        Ok(places.iter().map(|&p| [row(0, p) / row(2, p), row(1, p) / row(2, p)]).collect())
    };
    for tolerance in [1e-3, 1e-5] {
        let mut first = None;
        for threads in [1, 2, 7] {
            let mut crew = Crew::new(threads, &mut never);
            let got = texture.warp_curved(&mut map, [9, 7], &pixel, tolerance, &mut crew).unwrap();
            for ((a, b), error) in got.values.iter().zip(&truth.values).zip(&got.errors) {
                assert!((a - b).abs() <= tolerance && *error <= tolerance, "{tolerance} {a} {b} {error}");
            }
            assert_eq!(first.get_or_insert(got.clone()), &got);
            let again = texture.warp(matrix, [9, 7], &pixel, 1e-10, &mut Crew::new(threads, &mut never));
            assert_eq!(again.unwrap(), truth);
        }
    }
}

#[test]
fn bad_input_is_refused() {
    let image = Image::new(2, 2, 3, vec![0u8; 12]).unwrap();
    let make = |options: Options| Signal::new(image.view(), &options);
    let refused = [
        Options { wrap: [Wrap::Extend, Wrap::Clamp], ..Options::default() },
        Options { border: vec![0.0; 2], ..Options::default() },
        Options { alpha: Alpha::Straight, ..Options::default() },
    ];
    for options in refused {
        assert!(matches!(make(options.clone()), Err(Error::Value { .. })), "{options:?}");
    }
    assert!(make(Options { encoding: Encoding::Normal, ..Options::default() }).is_ok());
    let texture = make(Options::default()).unwrap();
    let pixel = Pixel::new(PixelFilter::Box, Reconstruction::Bilinear);
    let huge = texture.sample([0.5; 2], Some([[1e12, 0.0], [0.0, 1e12]]), &pixel, 1e-9);
    assert!(matches!(huge, Err(Error::Value { argument: "jacobian", .. })), "{huge:?}");
    for quad in [[[0.0; 2]; 4], [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]], [[f64::NAN; 2]; 4]] {
        assert!(texture.quad(quad).is_err());
    }
    let mut never = || false;
    let crew = &mut Crew::new(1, &mut never);
    assert!(texture.warp([[f64::NAN; 3]; 3], [2, 2], &pixel, 1e-6, crew).is_err());
    assert!(texture.warp([[1.0; 3]; 3], [0, 2], &pixel, 1e-6, crew).is_err());
    assert!(texture.warp([[1.0; 3]; 3], [2, 2], &pixel, 0.0, crew).is_err());
    assert!(texture.warp_curved(&mut |_| Ok(Vec::new()), [2, 2], &pixel, 1e-6, crew).is_err());
}
