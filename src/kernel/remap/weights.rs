//! Weights of the cubic and Lanczos kernels at a fraction of a pixel.

use super::sample::Real;
use std::sync::OnceLock;

/// Weights of the four taps at -1, 0, 1, 2 for a position `f` in [0, 1] after tap 0.
///
/// Cubic convolution with slope parameter `a` (Keys, IEEE Trans. ASSP 29, 1981):
/// `w(t) = (a+2)|t|^3 - (a+3)|t|^2 + 1` for `|t| < 1`, `a|t|^3 - 5a|t|^2 + 8a|t| - 4a` for `|t| < 2`.
/// The outer one of the left is factored as `a f (1-f)^2`, the rest alike; the last is what the others leave
/// of 1, so that constants stay constant.
#[inline(always)]
pub fn cubic<A: Real>(a: A, f: A) -> [A; 4] {
    let one = A::of(1.0);
    let g = one - f;
    let (b, c) = (a + A::of(2.0), a + A::of(3.0));
    let w0 = a * f * (g * g);
    let w1 = (b * f - c) * (f * f) + one;
    let w2 = (b * g - c) * (g * g) + one;
    [w0, w1, w2, one - w0 - w1 - w2]
}

/// Intervals of the Lanczos tables.
const STEPS: usize = 1024;

/// Weights at the multiples of `1 / STEPS`, both ends included.
pub type Table<A> = [[A; 8]; STEPS + 1];

/// Weights of the taps at -3..=4 for a position `f` in [0, 1]: `sinc(t) sinc(t/4)`, divided by their sum.
pub fn lanczos(f: f64) -> [f64; 8] {
    use std::f64::consts::PI;
    if f == 0.0 || f == 1.0 {
        return std::array::from_fn(|i| if i as f64 == 3.0 + f { 1.0 } else { 0.0 });
    }
    let raw: [f64; 8] = std::array::from_fn(|i| {
        let t = PI * (f + 3.0 - i as f64);
        t.sin() * (0.25 * t).sin() / (t * t)
    });
    let sum: f64 = raw.iter().sum();
    raw.map(|w| w / sum)
}

fn build<A: Real>() -> Box<Table<A>> {
    let mut table = Box::new([[A::default(); 8]; STEPS + 1]);
    for (i, row) in table.iter_mut().enumerate() {
        *row = lanczos(i as f64 / STEPS as f64).map(A::of);
    }
    table
}

/// The table for singles.
pub fn table_f32() -> &'static Table<f32> {
    static TABLE: OnceLock<Box<Table<f32>>> = OnceLock::new();
    TABLE.get_or_init(build)
}

/// The table for doubles.
pub fn table_f64() -> &'static Table<f64> {
    static TABLE: OnceLock<Box<Table<f64>>> = OnceLock::new();
    TABLE.get_or_init(build)
}

/// Lanczos weights at `f` in [0, 1], linear between the table's rows: exact at multiples of 1/1024,
/// within 2e-6 elsewhere.
#[inline(always)]
pub fn look_up<A: Real>(table: &Table<A>, f: A) -> [A; 8] {
    let scaled = f.wide() * STEPS as f64;
    let i = (scaled as usize).min(STEPS - 1);
    let rest = A::of(scaled - i as f64);
    let (low, high) = (&table[i], &table[i + 1]);
    std::array::from_fn(|k| low[k] + rest * (high[k] - low[k]))
}

/// Weights of `K` taps.
pub trait Weights<const K: usize> {
    /// Weights at fraction `f`.
    fn at(&self, f: f32) -> [f32; K];
}

/// Cubic convolution with this parameter.
pub struct Cubic(pub f32);

impl Weights<4> for Cubic {
    #[inline(always)]
    fn at(&self, f: f32) -> [f32; 4] {
        cubic(self.0, f)
    }
}

/// Lanczos weights from the table.
pub struct Lanczos(pub &'static Table<f32>);

impl Weights<8> for Lanczos {
    #[inline(always)]
    fn at(&self, f: f32) -> [f32; 8] {
        look_up(self.0, f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubic_weights_are_keys() {
        for a in [-0.75f64, -0.5] {
            for step in 0..=64 {
                let f = f64::from(step) / 64.0;
                let near = |t: f64| (a + 2.0) * t.powi(3) - (a + 3.0) * t * t + 1.0;
                let far = |t: f64| a * t.powi(3) - 5.0 * a * t * t + 8.0 * a * t - 4.0 * a;
                let want = [far(1.0 + f), near(f), near(1.0 - f), far(2.0 - f)];
                for (w, v) in cubic(a, f).into_iter().zip(want) {
                    assert!((w - v).abs() < 1e-14, "{a} {f}: {w} {v}");
                }
            }
        }
    }

    #[test]
    fn lanczos_weights_interpolate_and_sum_to_one() {
        for step in 0..=5000 {
            let f = f64::from(step) / 5000.0;
            let (got, want) = (look_up(table_f64(), f), lanczos(f));
            assert!((got.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            for (g, w) in got.into_iter().zip(want) {
                assert!((g - w).abs() < 2e-6, "{f}: {g} {w}");
            }
        }
        assert_eq!(look_up(table_f32(), 0.0)[3], 1.0);
        assert_eq!(look_up(table_f32(), 1.0)[4], 1.0);
    }
}
