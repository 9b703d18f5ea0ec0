//! Equal bytes on all sets, and weights as their formula says.

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

/// Side of the picture, which repeats itself without an apron.
const N: i32 = 96;

struct Repeated<'a>(&'a Plane<'a, u8>);

impl Repeated<'_> {
    fn texel(&self, x: i32, y: i32) -> [u8; 4] {
        self.0.texel(x.rem_euclid(N), y.rem_euclid(N))
    }
}

impl Texels for Repeated<'_> {
    fn eight(&self, x: i32, y: i32, texels: &mut [u8; READ]) {
        for k in 0..8 {
            let texel = self.texel(x + k, y);
            texels[k as usize * self.0.lanes..][..self.0.channels].copy_from_slice(&texel[..self.0.channels]);
        }
    }
}

fn plane(data: &[u8], lanes: usize, channels: usize) -> Plane<'_, u8> {
    let (row, last) = (N as usize * lanes, N - 1);
    let (columns, rows) = ((0, last), (0, last));
    Plane { data, origin: 0, row, lanes, channels, width: N, height: N, columns, rows }
}

/// A random parallelogram at least `least` texels high.
fn footprint(random: &mut Random, softness: f64, least: f64) -> Soft {
    loop {
        let size = random.between(0.0, 6.0).exp2();
        let turn = random.between(0.0, 6.3);
        let skew = random.between(0.4, 2.7);
        let other = size * random.between(0.1, 1.0);
        let [a, c] = [size * turn.cos(), size * turn.sin()];
        let [b, d] = [other * (turn + skew).cos(), other * (turn + skew).sin()];
        let f = Soft::new([[a, c], [b, d]], [size, other], (a * d - b * c).abs(), softness);
        let centre = [random.between(-20.0, 120.0), random.between(-20.0, 120.0)];
        if f.strips.iter().all(|s| 2.0 * s.half >= least) {
            return Soft { centre, ..f };
        }
    }
}

#[test]
fn weights_are_those_of_the_formula_on_every_set() {
    let mut random = Random(7);
    let data: Vec<u8> = (0..N * N * 4).map(|_| (random.unit() * 256.0) as u8).collect();
    for softness in [1.0, 0.7] {
        for (lanes, channels) in [(1, 1), (2, 2), (3, 3), (4, 4), (4, 3)] {
            let plane = plane(&data, lanes, channels);
            let rest = Repeated(&plane);
            for _ in 0..120 {
                let f = footprint(&mut random, softness, 0.5);
                assert!(fits(&f, &plane));
                let mean = soft(Isa::Scalar, &f, &plane, &rest);
                for isa in Isa::available() {
                    assert_eq!(soft(isa, &f, &plane, &rest), mean, "{isa:?} {lanes} {f:?}");
                }
                // All texels, in double precision; and how far roundings may move the mean.
                let ([cx, cy], [ex, ey]) = (f.centre, f.extent);
                let (mut total, mut sum, mut rim) = ([0.0; 4], 0.0, 0);
                for y in (cy - ey).floor() as i32..=(cy + ey).ceil() as i32 {
                    for x in (cx - ex).floor() as i32..=(cx + ex).ceil() as i32 {
                        let weight = f.weight([f64::from(x) - cx, f64::from(y) - cy]);
                        sum += weight;
                        rim += i32::from(weight > 0.0 && weight < 1.0);
                        for (total, code) in total.iter_mut().zip(rest.texel(x, y)) {
                            *total += weight * f64::from(code);
                        }
                    }
                }
                // A distance is rounded four times, to 2^-11 at worst; with it a weight changes by that at most, and a third
                // for the slopes, once a strip; four products are rounded to 2^-13 at worst.
                let one = 2.0 * 4.0 * 0.5 / 2048.0 * 4.0 / 3.0 + 4.0 * 0.5 / 8192.0;
                let bound = 255.0 * one * f64::from(rim) / sum;
                for c in 0..channels {
                    let error = (mean[c] - total[c] / sum).abs();
                    assert!(error < bound, "{lanes} {f:?}: {error} {bound}");
                }
            }
        }
    }
}

#[test]
fn equal_texels_give_exactly_their_code() {
    let mut random = Random(11);
    for code in [0, 1, 77, 254, 255] {
        let data = vec![code; (N * N * 4) as usize];
        let plane = plane(&data, 4, 4);
        for isa in Isa::available() {
            let f = footprint(&mut random, 1.0, 0.5);
            assert_eq!(soft(isa, &f, &plane, &Repeated(&plane)), [f64::from(code); 4]);
        }
    }
}

#[test]
fn long_footprints_do_not_overflow() {
    let data = vec![255; (N * N * 4) as usize];
    let plane = plane(&data, 4, 4);
    for [a, c] in [[900.0, 30.0], [30.0, 900.0]] {
        let [b, d]: [f64; 2] = [-c, a].map(|x| 0.2 * x);
        let length = f64::hypot(a, c);
        let f = Soft::new([[a, c], [b, d]], [length, 0.2 * length], 0.2 * length * length, 1.0);
        let f = Soft { centre: [40.0, 50.0], extent: f.extent.map(|e| e.min(500.0)), ..f };
        for isa in Isa::available() {
            assert_eq!(soft(isa, &f, &plane, &Repeated(&plane)), [255.0; 4], "{isa:?}");
        }
    }
}
