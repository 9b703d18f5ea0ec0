//! Equal bytes on all sets, and weights as their formulas say.

use super::*;

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

const N: usize = 96;

struct Scene {
    bytes: Vec<u8>,
    words: Vec<u16>,
    singles: Vec<f32>,
}

impl Scene {
    fn noise(random: &mut Random) -> Self {
        let codes: Vec<u16> = (0..N * N * 4).map(|_| (random.unit() * 65_536.0) as u16).collect();
        Self {
            bytes: codes.iter().map(|c| (c >> 8) as u8).collect(),
            singles: codes.iter().map(|c| f32::from(*c) / 777.0).collect(),
            words: codes,
        }
    }

    /// The result for each kind of texels.
    fn all(&self, mean: impl Fn(Texels<'_>) -> [f32; 4]) -> Vec<[f32; 4]> {
        let texels = |data| Texels { data, reference: [3.0, 100.0, 7.0, 0.0] };
        [Data::Bytes(&self.bytes), Data::Words(&self.words), Data::Singles(&self.singles)]
            .map(|data| mean(texels(data)))
            .to_vec()
    }
}

#[derive(Clone, Copy)]
enum Data<'a> {
    Bytes(&'a [u8]),
    Words(&'a [u16]),
    Singles(&'a [f32]),
}

/// A picture of N x N texels of four channels.
struct Texels<'a> {
    data: Data<'a>,
    reference: [f32; 4],
}

impl Source for Texels<'_> {
    const FLOAT: bool = true;
    #[inline(always)]
    fn chunk<L: Lanes>(&mut self, row: i64, first: i64) -> [L; 4] {
        let start = 4 * (row as usize * N + first as usize);
        let [a, b, c, d] = self.reference;
        let reference = L::load(&[a, b, c, d, a, b, c, d]);
        let mut chunk = [reference; 4];
        for (k, value) in chunk.iter_mut().enumerate() {
            let part = start + 8 * k..start + 8 * k + 8;
            let texels = match self.data {
                Data::Bytes(data) => L::load_u8(data[part].try_into().expect("eight")),
                Data::Words(data) => L::load_u16(data[part].try_into().expect("eight")),
                Data::Singles(data) => L::load(data[part].try_into().expect("eight")),
            };
            *value = texels.sub(reference);
        }
        chunk
    }
}

/// Sides of a random parallelogram, up to 32 texels long.
fn sides(random: &mut Random) -> [[f64; 2]; 2] {
    let size = random.between(0.0, 5.0).exp2();
    let turn = random.between(0.0, 6.3);
    let skew = random.between(0.4, 2.7);
    let other = size * random.between(0.1, 1.0);
    [[size * turn.cos(), size * turn.sin()], [other * (turn + skew).cos(), other * (turn + skew).sin()]]
}

fn soft_footprint(random: &mut Random, softness: f64) -> Soft {
    let [p, q] = sides(random);
    let area = (p[0] * q[1] - q[0] * p[1]).abs();
    let f = Soft::new([p, q], [p, q].map(|[x, y]| x.hypot(y)), area, softness);
    let centre = [0, 1].map(|k| random.between(40.0, 50.0) * (f.extent[k] < 36.0) as u8 as f64 + 0.3);
    Soft { centre, ..f }
}

fn fits(f: &Soft) -> bool {
    (0..2).all(|k| f.centre[k] - f.extent[k] >= 0.0 && f.centre[k] + f.extent[k] < N as f64 - 10.0)
}

#[test]
fn soft_weights_are_those_of_the_formula_on_every_set() {
    let mut random = Random(7);
    let scene = Scene::noise(&mut random);
    let mut tried = 0;
    while tried < 300 {
        let softness = if random.unit() < 0.5 { 1.0 } else { 0.7 };
        let f = soft_footprint(&mut random, softness);
        if !fits(&f) {
            continue;
        }
        tried += 1;
        let results = scene.all(|rows| soft(Isa::Scalar, &f, rows));
        for isa in Isa::available() {
            let other = scene.all(|rows| soft(isa, &f, rows));
            assert_eq!(format!("{other:?}"), format!("{results:?}"), "{isa:?} {f:?}");
        }
        // All texels, in double precision.
        let step = |z: f64| {
            let c = (z / softness).clamp(-1.0, 1.0);
            0.5 + c * (1.0 - 0.5 * c.abs())
        };
        let tent = |z: f64| (1.0 - (z / softness).abs()).max(0.0);
        let [[a, b], [c, d]] = f.strips.map(|s| s.normal);
        let covariance = (a * c + b * d) / 6.0;
        let (mut total, mut sum) = (0.0, 0.0);
        for y in 0..N {
            for x in 0..N {
                let (dx, dy) = (x as f64 - f.centre[0], y as f64 - f.centre[1]);
                let [(p, p_slope), (q, q_slope)] = f.strips.map(|s| {
                    let p = s.normal[0] * dx + s.normal[1] * dy;
                    (step(s.half - p) + step(s.half + p) - 1.0, tent(s.half + p) - tent(s.half - p))
                });
                let weight = (p * q + covariance * p_slope * q_slope).max(0.0);
                sum += weight;
                total += weight * (f64::from(scene.bytes[4 * (y * N + x)]) - 3.0);
            }
        }
        assert!((f64::from(results[0][0]) - total / sum).abs() < 2e-3, "{f:?}: {results:?} {}", total / sum);
    }
}

#[test]
fn gaussian_weights_are_those_of_the_formula_on_every_set() {
    let mut random = Random(17);
    let scene = Scene::noise(&mut random);
    for _ in 0..300 {
        let [[a, b], [c, d]] = sides(&mut random);
        let q = [0.3 * (a * a + b * b) + 1.0, 0.3 * (a * c + b * d), 0.3 * (c * c + d * d) + 1.0];
        let centre = [random.between(40.0, 50.0), random.between(40.0, 50.0)];
        let f = Ellipse { centre, q };
        let results = scene.all(|rows| ellipse(Isa::Scalar, &f, rows));
        for isa in Isa::available() {
            let other = scene.all(|rows| ellipse(isa, &f, rows));
            assert_eq!(format!("{other:?}"), format!("{results:?}"), "{isa:?} {f:?}");
        }
        // All texels, in double precision.
        let det = q[0] * q[2] - q[1] * q[1];
        let (mut total, mut sum) = (0.0, 0.0);
        for y in 0..N {
            for x in 0..N {
                let (dx, dy) = (x as f64 - centre[0], y as f64 - centre[1]);
                let square = (q[2] * dx * dx - 2.0 * q[1] * dx * dy + q[0] * dy * dy) / det;
                let weight = ((-2.0 * square).exp() - (-2.0f64).exp()).max(0.0);
                sum += weight;
                total += weight * (f64::from(scene.bytes[4 * (y * N + x)]) - 3.0);
            }
        }
        // Weights are good to a few roundings of singles, of codes up to 255.
        assert!((f64::from(results[0][0]) - total / sum).abs() < 2e-3, "{f:?}: {results:?} {}", total / sum);
    }
}

#[test]
fn spans_are_the_integral_on_every_set() {
    let mut random = Random(11);
    let scene = Scene::noise(&mut random);
    for _ in 0..200 {
        // A trapezoid: two slabs with straight sides.
        let (y0, y1, y2) = (random.between(-9.0, -1.0), random.between(-0.9, 0.9), random.between(1.0, 9.0));
        let ends: [[f64; 2]; 3] = std::array::from_fn(|_| {
            let left = random.between(-9.0, 5.0);
            [left, left + random.between(0.05, 9.0)]
        });
        let slab = |a: usize, b: usize, y: [f64; 2]| Slab {
            y,
            left: [ends[a][0], ends[b][0]],
            right: [ends[a][1], ends[b][1]],
        };
        let slabs = [slab(0, 1, [y0, y1]), slab(1, 2, [y1, y2])];
        let centre = [random.between(30.0, 60.0), random.between(30.0, 60.0)];
        let f = Spans { centre, slabs: &slabs };
        let results = scene.all(|rows| spans(Isa::Scalar, &f, rows));
        for isa in Isa::available() {
            let other = scene.all(|rows| spans(isa, &f, rows));
            assert_eq!(format!("{other:?}"), format!("{results:?}"), "{isa:?} {f:?}");
        }
        // Midpoints, many a texel, of the bilinear reconstruction.
        let value = |x: f64, y: f64| {
            let (i, j) = (x.floor(), y.floor());
            let at = |i: f64, j: f64| f64::from(scene.bytes[4 * (j as usize * N + i as usize)]);
            let (a, b) = (x - i, y - j);
            let row = |j: f64| at(i, j) + a * (at(i + 1.0, j) - at(i, j));
            row(j) + b * (row(j + 1.0) - row(j))
        };
        let (mut total, mut area) = (0.0, 0.0);
        for slab in &slabs {
            let rows = 400;
            let height = (slab.y[1] - slab.y[0]) / f64::from(rows);
            for k in 0..rows {
                let t = (f64::from(k) + 0.5) / f64::from(rows);
                let y = slab.y[0] + t * (slab.y[1] - slab.y[0]);
                let left = slab.left[0] + t * (slab.left[1] - slab.left[0]);
                let width = slab.right[0] + t * (slab.right[1] - slab.right[0]) - left;
                let columns = 400;
                let mean: f64 = (0..columns)
                    .map(|c| {
                        value(
                            centre[0] + left + width * (f64::from(c) + 0.5) / f64::from(columns),
                            centre[1] + y,
                        )
                    })
                    .sum::<f64>()
                    / f64::from(columns);
                total += mean * width * height;
                area += width * height;
            }
        }
        let error = f64::from(results[0][0]) + 3.0 - total / area;
        // The documented quadrature error: a thousandth of the contrast.
        assert!(error.abs() < 0.255, "{f:?}: {error}");
    }
}

#[test]
fn equal_texels_give_their_value_and_what_has_no_weight_does_not_count() {
    let mut random = Random(13);
    let mut data = vec![0.3f32; 4 * N * N];
    // Beyond the reach of the footprint below.
    data[4 * (20 * N + 12)..][..4].fill(f32::NAN);
    let f = Soft { centre: [40.0, 40.0], ..soft_footprint(&mut random, 1.0) };
    let f = Soft { extent: f.extent.map(|e| e.min(10.0)), ..f };
    for isa in Isa::available() {
        let texels = Texels { data: Data::Singles(&data), reference: [0.3; 4] };
        assert_eq!(soft(isa, &f, texels), [0.0; 4]);
    }
}
