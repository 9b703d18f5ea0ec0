//! The area filters against the integral that they stand for, computed here by other means.

use multum::{DType, Extent, Filter, Image, Sampler, Texture, TextureOptions, Wrap, par};

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

type Footprint = [[f64; 2]; 2];

struct Scene {
    width: usize,
    height: usize,
    channels: usize,
    texels: Vec<f64>,
    wrap: [Wrap; 2],
    border: f64,
}

impl Scene {
    fn noise(width: usize, height: usize, channels: usize, wrap: [Wrap; 2], seed: u64) -> Self {
        let mut random = Random(seed);
        let extra = wrap.map(|w| if w == Wrap::Extend { 2 } else { 0 });
        let count = (width + extra[0]) * (height + extra[1]) * channels;
        let texels = (0..count).map(|_| random.unit()).collect();
        Self { width, height, channels, texels, wrap, border: 0.25 }
    }

    fn texture(&self) -> Texture<'static> {
        let extra = self.wrap.map(|w| if w == Wrap::Extend { 2 } else { 0 });
        let (w, h) = (self.width + extra[0], self.height + extra[1]);
        let image = Image::new(w, h, self.channels, self.texels.clone()).expect("an image");
        let options = TextureOptions {
            wrap: self.wrap,
            border: vec![self.border; self.channels],
            ..Default::default()
        };
        Texture::new(image.view(), options).expect("a texture")
    }

    /// Channel 0 of the texel that stands at (i, j).
    fn texel(&self, i: i64, j: i64) -> f64 {
        let at = |axis: usize, i: i64, n: usize| {
            let shift = i64::from(self.wrap[axis] == Wrap::Extend);
            self.wrap[axis].index(i, n as i64).map(|i| (i + shift) as usize)
        };
        match (at(0, i, self.width), at(1, j, self.height)) {
            (Some(x), Some(y)) => {
                let row = self.width + if self.wrap[0] == Wrap::Extend { 2 } else { 0 };
                self.texels[(y * row + x) * self.channels]
            }
            _ => self.border,
        }
    }

    fn bilinear(&self, s: f64, t: f64) -> f64 {
        let (x, y) = (s - 0.5, t - 0.5);
        let (i, j) = (x.floor(), y.floor());
        let (a, b) = (x - i, y - j);
        let at = |di: i64, dj: i64| self.texel(i as i64 + di, j as i64 + dj);
        (1.0 - b) * ((1.0 - a) * at(0, 0) + a * at(1, 0)) + b * ((1.0 - a) * at(0, 1) + a * at(1, 1))
    }

    /// The mean over a parallelogram: cut by every cell of the reconstruction, triangle by triangle. The
    /// reconstruction is a quadratic on each, whose mean is that of the three edge midpoints.
    fn mean(&self, [s, t]: [f64; 2], j: Footprint) -> f64 {
        let corner =
            |p: f64, q: f64| [s - 0.5 + p * j[0][0] + q * j[0][1], t - 0.5 + p * j[1][0] + q * j[1][1]];
        let corners = vec![corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5)];
        let low = |k: usize| corners.iter().map(|c| c[k]).fold(f64::MAX, f64::min).floor() as i64;
        let high = |k: usize| corners.iter().map(|c| c[k]).fold(f64::MIN, f64::max).floor() as i64;
        let (mut sum, mut area) = (0.0, 0.0);
        for y in low(1)..=high(1) {
            let strip = clip(&clip(&corners, 1, y as f64, 1.0), 1, y as f64 + 1.0, -1.0);
            for x in low(0)..=high(0) {
                let cell = clip(&clip(&strip, 0, x as f64, 1.0), 0, x as f64 + 1.0, -1.0);
                for k in 2..cell.len() {
                    let (p, q, r) = (cell[0], cell[k - 1], cell[k]);
                    let twice = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
                    let middle = |a: [f64; 2], b: [f64; 2]| {
                        self.bilinear(0.5 * (a[0] + b[0]) + 0.5, 0.5 * (a[1] + b[1]) + 0.5)
                    };
                    sum += twice.abs() * (middle(p, q) + middle(q, r) + middle(r, p)) / 3.0;
                    area += twice.abs();
                }
            }
        }
        sum / area
    }
}

/// The part of a convex polygon on one side of a line of constant x or y.
fn clip(polygon: &[[f64; 2]], axis: usize, at: f64, side: f64) -> Vec<[f64; 2]> {
    let mut kept = Vec::new();
    for (k, p) in polygon.iter().enumerate() {
        let q = polygon[(k + 1) % polygon.len()];
        let (a, b) = (side * (p[axis] - at), side * (q[axis] - at));
        if a >= 0.0 {
            kept.push(*p);
        }
        if (a < 0.0) != (b < 0.0) {
            let f = a / (a - b);
            let mut cut = [p[0] + f * (q[0] - p[0]), p[1] + f * (q[1] - p[1])];
            cut[axis] = at;
            kept.push(cut);
        }
    }
    kept
}

/// Channel 0 of samples at places and footprints given in texels.
fn sample(sampler: &Sampler, texture: &Texture<'_>, places: &[([f64; 2], Footprint)]) -> Vec<f64> {
    let (w, h) = (texture.width() as f64, texture.height() as f64);
    let uv: Vec<f64> = places.iter().flat_map(|(p, _)| [p[0] / w, p[1] / h]).collect();
    let jacobian: Vec<f64> =
        places.iter().flat_map(|(_, j)| [j[0][0] / w, j[0][1] / w, j[1][0] / h, j[1][1] / h]).collect();
    let mut out = vec![0.0; places.len() * texture.channels()];
    sampler.sample(texture, &uv, Extent::Jacobian(&jacobian), &mut out).expect("samples");
    out.chunks(texture.channels()).map(|c| c[0]).collect()
}

fn turned(angle: f64, width: f64, height: f64, shear: f64) -> Footprint {
    let (sin, cos) = angle.sin_cos();
    let [a, b, d] = [width, shear * width, height];
    [[cos * a, cos * b - sin * d], [sin * a, sin * b + cos * d]]
}

const WRAPS: [Wrap; 7] =
    [Wrap::Clamp, Wrap::Repeat, Wrap::Mirror, Wrap::MirrorOnce, Wrap::Mirror101, Wrap::Border, Wrap::Extend];

#[test]
fn exact_is_the_integral_for_every_wrap_size_and_shape() {
    let mut random = Random(7);
    for (k, wrap) in WRAPS.into_iter().enumerate() {
        for (width, height) in [(1, 1), (1, 5), (2, 3), (5, 2), (8, 8), (17, 4)] {
            let scene = Scene::noise(width, height, 1, [wrap, WRAPS[(k + 2) % 7]], 3 + k as u64);
            let texture = scene.texture();
            let places: Vec<_> = (0..40)
                .map(|_| {
                    let size = 8f64.powf(random.between(-1.0, 1.4));
                    let thin = 10f64.powf(random.between(-3.0, 0.0));
                    let angle = if random.unit() < 0.3 {
                        std::f64::consts::FRAC_PI_2 * (4.0 * random.unit()).floor()
                    } else {
                        random.between(0.0, 6.3)
                    };
                    let j = turned(angle, size, size * thin, random.between(-1.0, 1.0));
                    let place =
                        [random.between(-1.5, 2.5) * width as f64, random.between(-1.5, 2.5) * height as f64];
                    (place, j)
                })
                .collect();
            for ((place, j), value) in
                places.iter().zip(sample(&Sampler::new(Filter::Exact), &texture, &places))
            {
                let truth = scene.mean(*place, *j);
                // The judge itself loses digits where it divides by a small area.
                assert!(
                    (value - truth).abs() < 1e-9,
                    "{wrap:?} {width}x{height} {place:?} {j:?}: {value} {truth}"
                );
            }
        }
    }
}

#[test]
fn exact_in_the_limits_of_a_line_and_a_point() {
    let scene = Scene::noise(16, 16, 1, [Wrap::Repeat, Wrap::Mirror], 5);
    let texture = scene.texture();
    let exact = Sampler::new(Filter::Exact);
    let cases = [
        [[9.3, 0.0], [0.0, 0.0]],
        [[0.0, 0.0], [0.0, 9.3]],
        [[0.0, 0.0], [5.0, 0.0]],
        [[3.0, 6.0], [2.0, 4.0]],
        [[3.0, 6.0], [0.0, 0.0]],
        [[-7.0, 0.0], [7.0, 0.0]],
        [[1e-14, 6.0], [3.0, 1e-13]],
    ];
    for j in cases {
        let place = [4.3, 6.1];
        let value = sample(&exact, &texture, &[(place, j)])[0];
        // A fine grid over the pixel: the midpoint rule, error of the order of (length/n)^2.
        let n = 1500;
        let mut truth = 0.0;
        for p in 0..n {
            for q in 0..n {
                let [p, q] = [p, q].map(|k| (f64::from(k) + 0.5) / f64::from(n) - 0.5);
                let offset = [j[0][0] * p + j[0][1] * q, j[1][0] * p + j[1][1] * q];
                truth += scene.bilinear(place[0] + offset[0], place[1] + offset[1]);
            }
        }
        truth /= f64::from(n * n);
        assert!((value - truth).abs() < 2e-5, "{j:?}: {value} {truth}");
    }
    for extent in [0.0, 1e-300, 1e-12, 1e-9, 1e-7] {
        let value = sample(&exact, &texture, &[([4.3, 6.1], [[extent, 0.0], [extent, extent]])])[0];
        assert!((value - scene.bilinear(4.3, 6.1)).abs() < 2e-7, "{extent}");
    }
}

#[test]
fn exact_takes_any_extent_in_bounded_time() {
    for wrap in WRAPS {
        let scene = Scene::noise(8, 4, 1, [wrap; 2], 11);
        let texture = scene.texture();
        for extent in [1e3, 1e12, 1e300] {
            let places = [
                ([3.0, 2.0], turned(0.3, extent, extent, 0.2)),
                ([1e18, -1e18], turned(0.3, extent, 0.1, 0.2)),
            ];
            let values = sample(&Sampler::new(Filter::Exact), &texture, &places);
            assert!(values.iter().all(|v| (0.0..=1.0).contains(v)), "{wrap:?} {extent} {values:?}");
            if wrap == Wrap::Border && extent >= 1e12 {
                assert!((values[0] - 0.25).abs() < 1e-6, "{values:?}");
            }
        }
    }
    // Whole periods are the mean.
    let scene = Scene::noise(8, 4, 1, [Wrap::Repeat, Wrap::Mirror], 11);
    let mean = scene.texels.iter().sum::<f64>() / 32.0;
    let value =
        sample(&Sampler::new(Filter::Exact), &scene.texture(), &[([3.3, 1.7], [[0.0, 800.0], [80.0, 0.0]])])
            [0];
    assert!((value - mean).abs() < 1e-12, "{value} {mean}");
}

#[test]
fn stochastic_converges_to_the_exact_mean() {
    let scene = Scene::noise(9, 7, 1, [Wrap::Mirror, Wrap::Border], 17);
    let texture = scene.texture();
    for j in [[[0.0; 2]; 2], turned(0.4, 6.0, 2.0, 0.5), turned(1.0, 30.0, 3.0, 0.0)] {
        let count = 40_000;
        let place = [7.1, -0.2];
        let places = vec![(place, j); count];
        let sampler = Sampler { seed: 3, ..Sampler::new(Filter::Stochastic) };
        let values = sample(&sampler, &texture, &places);
        let truth = sample(&Sampler::new(Filter::Exact), &texture, &places[..1])[0];
        let mean = values.iter().sum::<f64>() / count as f64;
        let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / count as f64;
        // Five standard errors.
        assert!(
            (mean - truth).abs() < 5.0 * (variance / count as f64).sqrt() + 1e-12,
            "{j:?}: {mean} {truth}"
        );
        // Another seed is another sample, the same seed the same, on any number of threads.
        let again = |seed, threads| {
            let sampler = Sampler { seed, ..sampler };
            par::with_threads(Some(threads), || sample(&sampler, &texture, &places))
        };
        assert_eq!(values, again(3, 1));
        assert_eq!(values, again(3, 3));
        assert_ne!(values, again(4, 1));
    }
}

/// Filters that average over the footprint.
const AREA: [Filter; 5] = [Filter::Exact, Filter::Area, Filter::Ewa, Filter::Sat, Filter::Stochastic];

#[test]
fn constants_stay_what_they_are() {
    let mut random = Random(23);
    for filter in AREA {
        for wrap in WRAPS {
            for (value, dtype) in [(77.0 / 255.0, DType::U8), (0.1, DType::F32), (1.0 / 3.0, DType::F64)] {
                let extra = if wrap == Wrap::Extend { 2 } else { 0 };
                let (w, h) = (17, 5);
                let count = (w + extra) * (h + extra) * 3;
                let image = match dtype {
                    DType::U8 => Image::new(w + extra, h + extra, 3, vec![77u8; count]),
                    DType::F32 => Image::new(w + extra, h + extra, 3, vec![value as f32; count]),
                    _ => Image::new(w + extra, h + extra, 3, vec![value; count]),
                }
                .expect("an image");
                let border = if dtype == DType::F32 { f64::from(value as f32) } else { value };
                let options =
                    TextureOptions { wrap: [wrap; 2], border: vec![border; 3], ..Default::default() };
                let texture = Texture::new(image.view(), options).expect("a texture");
                let places: Vec<_> = (0..60)
                    .map(|_| {
                        let size = 10f64.powf(random.between(-3.0, 2.5));
                        let thin = 10f64.powf(random.between(-4.0, 0.0));
                        let j =
                            turned(random.between(0.0, 7.0), size, size * thin, random.between(-2.0, 2.0));
                        ([random.between(-30.0, 50.0), random.between(-30.0, 50.0)], j)
                    })
                    .collect();
                for (place, got) in places.iter().zip(sample(&Sampler::new(filter), &texture, &places)) {
                    let expected = match dtype {
                        DType::F64 => value,
                        DType::F32 => f64::from(value as f32),
                        _ => f64::from(77.0f32 / 255.0),
                    };
                    // A table holds sums of doubles, which are not exact.
                    let slack = if (filter, dtype) == (Filter::Sat, DType::F64) { 1e-14 } else { 0.0 };
                    assert!(
                        (got - expected).abs() <= slack,
                        "{filter:?} {wrap:?} {dtype:?} {place:?}: {got}"
                    );
                }
            }
        }
    }
}

#[test]
fn footprints_that_are_no_numbers() {
    let scene = Scene::noise(8, 8, 1, [Wrap::Repeat; 2], 29);
    let texture = scene.texture();
    let mean = scene.texels.iter().sum::<f64>() / 64.0;
    for filter in AREA.into_iter().filter(|f| *f != Filter::Stochastic) {
        for j in [
            [[f64::NAN, 0.0], [0.0, 1.0]],
            [[f64::INFINITY, 0.0], [0.0, 1.0]],
            [[1.0, f64::NEG_INFINITY], [f64::NAN; 2]],
        ] {
            let value = sample(&Sampler::new(filter), &texture, &[([2.0, 3.0], j)])[0];
            assert!((value - mean).abs() < 1e-12, "{filter:?} {j:?}: {value}");
        }
    }
    for filter in AREA {
        for place in [[f64::NAN, 0.0], [1.0, f64::INFINITY]] {
            assert_eq!(sample(&Sampler::new(filter), &texture, &[(place, [[1.0, 0.0], [0.0, 1.0]])]), [0.25]);
        }
    }
}

/// Footprints of many sizes, ratios, angles and shears.
fn footprints(random: &mut Random, count: usize) -> Vec<Footprint> {
    (0..count)
        .map(|_| {
            let size = 2f64.powf(random.between(-4.0, 6.0));
            let thin = 10f64.powf(random.between(-4.0, 0.0));
            turned(random.between(0.0, 7.0), size, size * thin, random.between(-1.0, 1.0))
        })
        .collect()
}

#[test]
fn turning_the_pixel_or_moving_by_periods_changes_nothing() {
    let mut random = Random(31);
    let scene = Scene::noise(17, 12, 3, [Wrap::Repeat, Wrap::Mirror], 37);
    let texture = scene.texture();
    let places: Vec<_> = footprints(&mut random, 60)
        .into_iter()
        .map(|j| ([random.between(0.0, 17.0), random.between(0.0, 12.0)], j))
        .collect();
    let quarter: Vec<_> = places.iter().map(|(p, [[a, b], [c, d]])| (*p, [[*b, -a], [*d, -c]])).collect();
    let moved: Vec<_> = places.iter().map(|(p, j)| ([p[0] - 17.0 * 3.0, p[1] + 24.0 * 5.0], *j)).collect();
    for filter in AREA.into_iter().filter(|f| *f != Filter::Stochastic) {
        let sampler = Sampler::new(filter);
        let values = sample(&sampler, &texture, &places);
        for other in [&quarter, &moved] {
            for ((value, same), place) in values.iter().zip(sample(&sampler, &texture, other)).zip(&places) {
                // Level and blend come from a logarithm in single precision.
                assert!((value - same).abs() < 1e-6, "{filter:?} {place:?}: {value} {same}");
            }
        }
    }
}

#[test]
fn nothing_jumps_as_a_footprint_grows_turns_or_collapses() {
    let scene = Scene::noise(32, 32, 1, [Wrap::Repeat; 2], 41);
    let texture = scene.texture();
    let steps = 4000;
    let sweeps: [&dyn Fn(f64) -> Footprint; 5] = [
        &|x| turned(0.3, 0.1 * 640f64.powf(x), 0.1 * 640f64.powf(x), 0.0),
        &|x| turned(0.3, 8.0, 8.0 * 1e-4f64.powf(x), 0.0),
        &|x| turned(6.3 * x, 9.0, 4.0, 0.3),
        &|x| turned(1.0, 6.0, 4.0 * (2.0 * x - 1.0), 0.5),
        &|x| turned(0.0, 12.0, 0.0, 20.0 * (x - 0.5)),
    ];
    for filter in AREA.into_iter().filter(|f| *f != Filter::Stochastic) {
        for (k, sweep) in sweeps.iter().enumerate() {
            let places: Vec<_> =
                (0..=steps).map(|i| ([13.3, 7.7], sweep(f64::from(i) / f64::from(steps)))).collect();
            let values = sample(&Sampler::new(filter), &texture, &places);
            let largest = values.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
            // A step moves a side by at most 1/600 of its length. Weights then move by at most a few times as
            // much, and values are within 0..1; EWA and area blend levels over a quarter of an octave.
            assert!(largest < 0.01, "{filter:?}, sweep {k}: {largest}");
        }
    }
}

#[test]
fn sat_is_the_mean_of_squares_over_the_bounds() {
    let mut random = Random(43);
    for wrap in WRAPS {
        let scene = Scene::noise(5, 4, 2, [wrap; 2], 47);
        let texture = scene.texture();
        for j in footprints(&mut random, 30) {
            let place = [random.between(-6.0, 11.0), random.between(-6.0, 11.0)];
            let side = |k: usize| 0.5 * (j[k][0].abs() + j[k][1].abs()).max(1.0);
            let (hx, hy) = (side(0), side(1));
            let (mut sum, overlap) = (0.0, |i: i64, centre: f64, half: f64| {
                let i = i as f64;
                ((i + 1.0).min(centre + half) - i.max(centre - half)).max(0.0)
            });
            for y in (place[1] - hy).floor() as i64..=(place[1] + hy).floor() as i64 {
                for x in (place[0] - hx).floor() as i64..=(place[0] + hx).floor() as i64 {
                    // As a square an extra texel has no more than its own colour beyond it.
                    sum += scene.texel(x, y) * overlap(x, place[0], hx) * overlap(y, place[1], hy);
                }
            }
            let value = sample(&Sampler::new(Filter::Sat), &texture, &[(place, j)])[0];
            let truth = sum / (4.0 * hx * hy);
            assert!((value - truth).abs() < 1e-9, "{wrap:?} {place:?} {j:?}: {value} {truth}");
        }
    }
}

#[test]
fn area_errors_stay_below_the_bound_of_their_weights() {
    let mut random = Random(53);
    let scene = Scene::noise(64, 64, 1, [Wrap::Repeat; 2], 59);
    let texture = scene.texture();
    let places: Vec<_> = footprints(&mut random, 1500)
        .into_iter()
        .map(|j| ([random.between(0.0, 64.0), random.between(0.0, 64.0)], j))
        .collect();
    let truth = sample(&Sampler::new(Filter::Exact), &texture, &places);
    for ((place, value), truth) in
        places.iter().zip(sample(&Sampler::new(Filter::Area), &texture, &places)).zip(truth)
    {
        let [[a, b], [c, d]] = place.1;
        let (p, q) = (a.hypot(c), b.hypot(d));
        let height = (a * d - b * c).abs() / p.max(q);
        // On level 0 less than the estimate up to which soft weights are trusted, several times over; beyond,
        // the weights of at most the outline's texels are wrong, by a quarter: E = P / 4A in texels of a level
        // that is at least 3/2 texels high.
        let bound =
            if height < 3.0 { 0.02 } else { 0.25 * 2.0 * (p + q) / (p * q) * (height / 1.5).min(64.0) };
        assert!((value - truth).abs() <= bound, "{place:?}: {value} {truth}, bound {bound}");
    }
}

#[test]
fn results_do_not_depend_on_threads() {
    let mut random = Random(61);
    let scene = Scene::noise(33, 20, 5, [Wrap::Clamp, Wrap::Repeat], 67);
    let texture = scene.texture();
    let js = footprints(&mut random, 12_000);
    let places: Vec<_> =
        js.into_iter().map(|j| ([random.between(-9.0, 40.0), random.between(-9.0, 40.0)], j)).collect();
    for filter in [Filter::Area, Filter::Ewa, Filter::Sat] {
        let run =
            |threads| par::with_threads(Some(threads), || sample(&Sampler::new(filter), &texture, &places));
        assert_eq!(run(1), run(3), "{filter:?}");
    }
}
