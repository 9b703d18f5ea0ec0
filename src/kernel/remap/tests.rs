use super::*;
use half::f16;

/// A small deterministic generator (xorshift).
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 >> 11
    }
    fn unit(&mut self) -> f64 {
        self.bits() as f64 / (1u64 << 53) as f64
    }
    fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }
}

/// Elements that can be drawn and compared bit by bit.
trait Probe: Sample + std::fmt::Debug {
    fn draw(random: &mut Random) -> Self;
    fn bits(self) -> u64;
    fn value(self) -> f64;
    /// Largest distance from the true value, in units of 255 or 65535 for integers, of 100 for floats.
    const BOUND: f64;
}

macro_rules! probe {
    ($type:ty, $random:ident => $draw:expr, $v:ident => $bits:expr, $bound:expr) => {
        impl Probe for $type {
            fn draw($random: &mut Random) -> Self {
                $draw
            }
            fn bits(self) -> u64 {
                let $v = self;
                $bits
            }
            fn value(self) -> f64 {
                self.get().wide()
            }
            const BOUND: f64 = $bound;
        }
    };
}
probe!(u8, r => r.bits() as u8, v => u64::from(v), 0.501);
probe!(u16, r => r.bits() as u16, v => u64::from(v), 0.6);
probe!(i16, r => r.bits() as i16, v => v as u64, 0.6);
// 24 bits of 100, some roundings; Lanczos tables are within 2e-6.
probe!(f32, r => (100.0 * r.unit()) as f32, v => u64::from(v.to_bits()), 5e-3);
probe!(f64, r => 100.0 * r.unit(), v => v.to_bits(), 5e-3);
probe!(f16, r => f16::from_f64(100.0 * r.unit()), v => u64::from(v.to_bits()), 0.07);

const EDGES: [Edge; 6] =
    [Edge::Border, Edge::Clamp, Edge::Repeat, Edge::Mirror, Edge::MirrorOnce, Edge::Mirror101];
const KINDS: [Interpolation; 5] = [
    Interpolation::Nearest,
    Interpolation::Bilinear,
    Interpolation::Bicubic(-0.75),
    Interpolation::Bicubic(-0.5),
    Interpolation::Lanczos4,
];
const OUTSIDE: [Outside; 3] = [Outside::Colour, Outside::Previous, Outside::Keep];
const SPECIAL: [f32; 12] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    1e30,
    -1e30,
    3e9,
    -1e-9,
    -1.0,
    0.0,
    0.5,
    2_147_483_648.0,
    -2_147_483_648.0,
];

fn positions(random: &mut Random, n: usize, side: usize) -> Vec<f32> {
    let wide = random.below(3) == 0;
    (0..n)
        .map(|_| match random.below(40) {
            0 => SPECIAL[random.below(SPECIAL.len())],
            1 => random.below(side + 1) as f32 - 0.5 * random.below(3) as f32,
            _ if wide => ((random.unit() * 3.0 - 1.0) * side as f64) as f32,
            _ => (random.unit() * (side as f64 - 1.0)) as f32,
        })
        .collect()
}

fn agree<T: Probe>(random: &mut Random, channels: usize, kind: Interpolation) {
    let (width, height) = (1 + random.below(67), 1 + random.below(67));
    let stride = width * channels + random.below(5);
    let skip = random.below(4);
    // No element after the last row: a load beyond it would leave the slice.
    let data: Vec<T> =
        (0..skip + stride * (height - 1) + width * channels).map(|_| T::draw(random)).collect();
    let border: Vec<T> = (0..channels).map(|_| T::draw(random)).collect();
    let source = Source::new(&data[skip..], width, height, channels, stride).unwrap();
    let edges = [EDGES[random.below(6)], EDGES[random.below(6)]];
    let outside = OUTSIDE[random.below(3)];
    let job = Job::new(source, kind, edges, &border, outside).unwrap();
    let n = random.below(68);
    let (x, y) = (positions(random, n, width), positions(random, n, height));
    let before: Vec<T> = (0..skip + n * channels).map(|_| T::draw(random)).collect();
    let run = |isa: Isa, taken_apart: bool, job: &Job<'_, T>| {
        let mut out = before.clone();
        let mut buffer: Buffer<_> = Buffer::new();
        let points = if taken_apart {
            let grid = if kind == Interpolation::Nearest { Grid::Whole } else { Grid::Exact };
            Points::Split(buffer.split_f32(isa, grid, &x, &y))
        } else {
            Points::Plain(&x, &y)
        };
        remap(isa, job, &points, &mut out[skip..]).unwrap();
        out.into_iter().map(T::bits).collect::<Vec<_>>()
    };
    let want = run(Isa::Scalar, true, &job);
    let apron = job.apron(usize::MAX);
    let with_apron = apron.as_deref().map_or(job, |apron| job.with_apron(apron));
    for isa in Isa::available() {
        for taken_apart in [false, true] {
            assert!(
                run(isa, taken_apart, &job) == want && run(isa, taken_apart, &with_apron) == want,
                "{isa:?} {kind:?} {channels} channels {width}x{height} {edges:?} {outside:?}"
            );
        }
    }
}

#[test]
fn instruction_sets_give_equal_bytes() {
    let mut random = Random(0x1234_5678_9abc_def1);
    for kind in KINDS {
        for channels in [1, 2, 3, 4, 5] {
            for _ in 0..60 {
                agree::<u8>(&mut random, channels, kind);
                agree::<u16>(&mut random, channels, kind);
                agree::<f32>(&mut random, channels, kind);
            }
            agree::<i16>(&mut random, channels, kind);
            agree::<f16>(&mut random, channels, kind);
            agree::<f64>(&mut random, channels, kind);
        }
    }
}

/// Rows of an output that a matrix maps, in parts of any length.
fn rows_agree<T: Probe>(random: &mut Random, channels: usize, kind: Interpolation) {
    let (width, height) = (1 + random.below(67), 1 + random.below(67));
    let data: Vec<T> = (0..width * height * channels).map(|_| T::draw(random)).collect();
    let border: Vec<T> = (0..channels).map(|_| T::draw(random)).collect();
    let source = Source::new(&data, width, height, channels, width * channels).unwrap();
    let edges = [EDGES[random.below(6)], EDGES[random.below(6)]];
    let job = Job::new(source, kind, edges, &border, OUTSIDE[random.below(3)]).unwrap();
    let mut number = |scale: f64| (random.unit() - 0.5) * scale;
    let mut matrix = [0.0; 9].map(|_| number(3.0));
    (matrix[2], matrix[5]) = (number(2.0 * width as f64), number(2.0 * height as f64));
    match random.below(4) {
        0 => (matrix[6], matrix[7]) = (0.01 * matrix[6], 0.01 * matrix[7]),
        // A row of zero divisors, and numbers that no integer holds.
        1 => (matrix[6], matrix[7], matrix[8]) = (1.0, 0.0, -9.0),
        2 => matrix[0] = 1e300,
        _ => (matrix[6], matrix[7], matrix[8]) = (0.0, 0.0, 1.0),
    }
    let n = random.below(300);
    let row = Row { matrix: &matrix, x0: random.below(9) as f64, y: random.below(50) as f64 };
    let before: Vec<T> = (0..n * channels).map(|_| T::draw(random)).collect();
    let run = |isa: Isa, job: &Job<'_, T>| {
        let mut out = before.clone();
        remap(isa, job, &Points::Row(row), &mut out).unwrap();
        out.into_iter().map(T::bits).collect::<Vec<_>>()
    };
    let want = run(Isa::Scalar, &job);
    let apron = job.apron(usize::MAX);
    let with_apron = apron.as_deref().map_or(job, |apron| job.with_apron(apron));
    for isa in Isa::available() {
        assert!(
            run(isa, &job) == want && run(isa, &with_apron) == want,
            "{isa:?} {kind:?} {channels} channels {width}x{height} {edges:?} {matrix:?}"
        );
    }
}

#[test]
fn instruction_sets_give_equal_rows() {
    let mut random = Random(0xfeed_5678_9abc_def1);
    for kind in KINDS {
        for channels in 1..=5 {
            for _ in 0..40 {
                rows_agree::<u8>(&mut random, channels, kind);
                rows_agree::<u16>(&mut random, channels, kind);
                rows_agree::<f32>(&mut random, channels, kind);
            }
            rows_agree::<f64>(&mut random, channels, kind);
        }
    }
}

/// A source that is read through the blocks on their way.
#[test]
fn large_sources_give_equal_bytes() {
    let mut random = Random(99);
    for (channels, kind) in [(1, KINDS[0]), (3, KINDS[0]), (1, KINDS[1]), (3, KINDS[1]), (4, KINDS[2])] {
        let (width, height) = (800, 700 / channels + 60);
        let data: Vec<u16> = (0..width * height * channels).map(|_| u16::draw(&mut random)).collect();
        let source = Source::new(&data, width, height, channels, width * channels).unwrap();
        let border = vec![9; channels];
        let job = Job::new(source, kind, [Edge::Border; 2], &border, Outside::Colour).unwrap();
        let place = |i: usize, k: f64| (i as f64 * k - 20.0) as f32;
        let mut x: Vec<f32> = (0..1000).map(|i| place(i, 0.9)).collect();
        let mut y: Vec<f32> = (0..1000).map(|i| place(i, 0.3)).collect();
        x.extend((0..1000).map(|_| (random.unit() * width as f64) as f32));
        y.extend((0..1000).map(|_| (random.unit() * height as f64) as f32));
        let mut all = Isa::available().into_iter().map(|isa| {
            let mut out = vec![0u16; x.len() * channels];
            remap(isa, &job, &Points::Plain(&x, &y), &mut out).unwrap();
            out
        });
        let first = all.next().unwrap();
        assert!(all.all(|other| other == first), "{channels} {kind:?}");
    }
}

#[test]
fn every_size_gives_equal_bytes_inside() {
    let mut random = Random(77);
    for side in 1..=67usize {
        for (channels, kind) in [(1, KINDS[1]), (3, KINDS[1]), (4, KINDS[1]), (3, KINDS[2]), (4, KINDS[4])] {
            let data: Vec<u8> = (0..side * side * channels).map(|_| u8::draw(&mut random)).collect();
            let source = Source::new(&data, side, side, channels, side * channels).unwrap();
            let border = vec![9; channels];
            let job = Job::new(source, kind, [Edge::Repeat; 2], &border, Outside::Colour).unwrap();
            let inside = |random: &mut Random| -> Vec<f32> {
                (0..67).map(|_| (random.unit() * (side as f64 - 1.0)) as f32).collect()
            };
            let (x, y) = (inside(&mut random), inside(&mut random));
            let mut all = Isa::available().into_iter().map(|isa| {
                let mut out = vec![0u8; 67 * channels];
                remap(isa, &job, &Points::Plain(&x, &y), &mut out).unwrap();
                out
            });
            let first = all.next().unwrap();
            assert!(all.all(|other| other == first), "{side} {channels} {kind:?}");
        }
    }
}

/// The pixel at `i` by walking step by step from pixel 0.
fn walk(edge: Edge, i: i64, n: i64) -> Option<i64> {
    if edge == Edge::Border {
        return (0..n).contains(&i).then_some(i);
    }
    let (mut at, mut step) = (0, i.signum());
    for passed in 0..i.abs() {
        let next = at + step;
        if (0..n).contains(&next) {
            at = next;
            continue;
        }
        match edge {
            Edge::Repeat => at = if step > 0 { 0 } else { n - 1 },
            // The edge pixel again, then back.
            Edge::Mirror => step = -step,
            Edge::Mirror101 if n > 1 => {
                step = -step;
                at += step;
            }
            Edge::MirrorOnce if i < 0 && passed == 0 => step = -step,
            _ => {}
        }
    }
    Some(at)
}

fn truth<T: Probe>(job: &Job<'_, T>, x: f64, y: f64, k: usize) -> f64 {
    let (kernel, radius): (Box<dyn Fn(f64) -> f64>, i64) = match job.interpolation {
        Interpolation::Nearest => (Box::new(|t| if t == 0.0 { 1.0 } else { 0.0 }), 1),
        Interpolation::Bilinear => (Box::new(|t| (1.0 - t.abs()).max(0.0)), 1),
        Interpolation::Bicubic(a) => {
            let a = f64::from(a);
            let cubic = move |t: f64| match t.abs() {
                t if t < 1.0 => ((a + 2.0) * t - (a + 3.0)) * t * t + 1.0,
                t if t < 2.0 => ((a * t - 5.0 * a) * t + 8.0 * a) * t - 4.0 * a,
                _ => 0.0,
            };
            (Box::new(cubic), 2)
        }
        Interpolation::Lanczos4 => {
            let sinc = |t: f64| {
                if t == 0.0 { 1.0 } else { (std::f64::consts::PI * t).sin() / (std::f64::consts::PI * t) }
            };
            (Box::new(move |t: f64| if t.abs() < 4.0 { sinc(t) * sinc(t / 4.0) } else { 0.0 }), 4)
        }
    };
    let (x, y) = match job.interpolation {
        Interpolation::Nearest => (x.round_ties_even(), y.round_ties_even()),
        _ => (x, y),
    };
    let s = &job.source;
    let (mut sum, mut total) = (0.0, 0.0);
    for row in y.floor() as i64 - radius + 1..=y.floor() as i64 + radius {
        for column in x.floor() as i64 - radius + 1..=x.floor() as i64 + radius {
            let weight = kernel(x - column as f64) * kernel(y - row as f64);
            let at = (walk(job.edges[0], column, s.width as i64), walk(job.edges[1], row, s.height as i64));
            let value = match at {
                (Some(i), Some(j)) => s.data[j as usize * s.row_stride + i as usize * s.channels + k],
                _ => job.border[k],
            };
            sum += weight * value.value();
            total += weight;
        }
    }
    sum / total
}

fn is_true<T: Probe>(random: &mut Random) {
    for kind in KINDS {
        for edge in EDGES {
            let (width, height, channels) = (1 + random.below(9), 1 + random.below(9), 1 + random.below(5));
            let data: Vec<T> = (0..width * height * channels).map(|_| T::draw(random)).collect();
            let border: Vec<T> = (0..channels).map(|_| T::draw(random)).collect();
            let source = Source::new(&data, width, height, channels, width * channels).unwrap();
            let job = Job::new(source, kind, [edge; 2], &border, Outside::Colour).unwrap();
            let at = |side: usize, random: &mut Random| ((random.unit() * 4.0 - 1.5) * side as f64) as f32;
            let x: Vec<f32> = (0..40).map(|_| at(width, random)).collect();
            let y: Vec<f32> = (0..40).map(|_| at(height, random)).collect();
            let mut out = vec![T::default(); 40 * channels];
            remap(Isa::current(), &job, &Points::Plain(&x, &y), &mut out).unwrap();
            for (i, &got) in out.iter().enumerate() {
                let (x, y) = (f64::from(x[i / channels]), f64::from(y[i / channels]));
                let want = truth(&job, x, y, i % channels);
                // Saturation is part of the definition for integers.
                let (low, high) = (T::put(T::Acc::of(-1e9)).value(), T::put(T::Acc::of(1e9)).value());
                let want = want.clamp(low, high);
                assert!(
                    (got.value() - want).abs() <= T::BOUND,
                    "{kind:?} {edge:?} at {x} {y} of {width}x{height}: {got:?}, not {want}"
                );
            }
        }
    }
}

#[test]
fn values_are_those_of_the_definition() {
    let mut random = Random(5);
    for _ in 0..6 {
        is_true::<u8>(&mut random);
        is_true::<u16>(&mut random);
        is_true::<i16>(&mut random);
        is_true::<f16>(&mut random);
        is_true::<f32>(&mut random);
        is_true::<f64>(&mut random);
    }
}

#[test]
fn constants_stay_constant() {
    for code in 0..=255u8 {
        let data = [code; 20 * 20 * 3];
        let source = Source::new(&data, 20, 20, 3, 60).unwrap();
        let mut random = Random(u64::from(code) + 1);
        for kind in KINDS {
            let job = Job::new(source, kind, [Edge::Clamp; 2], &[0; 3], Outside::Colour).unwrap();
            let x: Vec<f32> = (0..33).map(|_| (random.unit() * 19.0) as f32).collect();
            let mut out = [0; 99];
            remap(Isa::current(), &job, &Points::Plain(&x, &x), &mut out).unwrap();
            assert!(out.iter().all(|&v| v == code), "{kind:?} {code}");
        }
    }
}

#[test]
fn positions_that_are_not_finite_have_the_border_colour() {
    let data = [1u8; 9];
    let source = Source::new(&data, 3, 3, 1, 3).unwrap();
    for kind in KINDS {
        for edge in EDGES {
            let job = Job::new(source, kind, [edge; 2], &[200], Outside::Colour).unwrap();
            let mut out = [0; 4];
            let x = [f32::NAN, 1.0, f32::INFINITY, f32::NEG_INFINITY];
            let y = [1.0, f32::NAN, 1.0, 1.0];
            remap(Isa::current(), &job, &Points::Plain(&x, &y), &mut out).unwrap();
            assert_eq!(out, [200; 4], "{kind:?} {edge:?}");
        }
    }
}

#[test]
fn pixels_beyond_are_kept_as_asked() {
    let data = [100u8; 16];
    let source = Source::new(&data, 4, 4, 1, 4).unwrap();
    let x = [-1.5f32, -0.25, 0.0, 2.5, 3.0, 3.25];
    let y = [1.0; 6];
    let run = |kind, outside| {
        let job = Job::new(source, kind, [Edge::Border; 2], &[0], outside).unwrap();
        let mut out = [200; 6];
        remap(Isa::current(), &job, &Points::Plain(&x, &y), &mut out).unwrap();
        out
    };
    assert_eq!(run(Interpolation::Bilinear, Outside::Keep), [200, 200, 100, 100, 100, 100]);
    assert_eq!(run(Interpolation::Bilinear, Outside::Previous), [200, 125, 100, 100, 100, 125]);
    assert_eq!(run(Interpolation::Lanczos4, Outside::Keep), [200, 200, 100, 100, 100, 100]);
    assert_eq!(run(Interpolation::Nearest, Outside::Keep), [200, 100, 100, 100, 100, 100]);
}

#[test]
fn sources_and_jobs_that_do_not_fit_are_refused() {
    let data = [0u8; 12];
    assert!(Source::new(&data, 2, 2, 3, 6).is_ok());
    for (w, h, c, stride) in
        [(2, 2, 3, 7), (0, 2, 3, 6), (2, 2, 0, 6), (2, 2, 3, 5), (usize::MAX, 2, 2, 6), (2, 2, 1, usize::MAX)]
    {
        assert!(Source::new(&data, w, h, c, stride).is_err(), "{w} {h} {c} {stride}");
    }
    let source = Source::new(&data, 2, 2, 3, 6).unwrap();
    assert!(Job::new(source, KINDS[0], [Edge::Clamp; 2], &[0; 2], Outside::Colour).is_err());
    let job = Job::new(source, KINDS[0], [Edge::Clamp; 2], &[0; 3], Outside::Colour).unwrap();
    assert!(remap(Isa::Scalar, &job, &Points::Plain(&[0.0], &[0.0]), &mut [0; 4]).is_err());
    assert!(remap(Isa::Scalar, &job, &Points::Plain(&[0.0], &[]), &mut [0; 3]).is_err());
}
