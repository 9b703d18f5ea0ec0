//! The least and the greatest number of an array.

use super::remap::Real;
use super::{Isa, compiled_for};

const LANES: usize = 16;

/// Least and greatest number of a slice, and whether there are NaN, which do not count. Without any number they are
/// infinity and minus infinity.
pub fn range<T: Real>(isa: Isa, data: &[T]) -> (T, T, bool) {
    compiled_for(isa, || {
        let mut low = [T::of(f64::INFINITY); LANES];
        let mut high = [T::of(f64::NEG_INFINITY); LANES];
        let mut nan = [false; LANES];
        let (blocks, rest) = data.as_chunks::<LANES>();
        let mut take = |i: usize, v: T| {
            low[i] = if v < low[i] { v } else { low[i] };
            high[i] = if v > high[i] { v } else { high[i] };
            nan[i] |= v.partial_cmp(&v).is_none();
        };
        for block in blocks {
            for (i, &v) in block.iter().enumerate() {
                take(i, v);
            }
        }
        for &v in rest {
            take(0, v);
        }
        let least = low.into_iter().fold(T::of(f64::INFINITY), |a, b| if b < a { b } else { a });
        let most = high.into_iter().fold(T::of(f64::NEG_INFINITY), |a, b| if b > a { b } else { a });
        (least, most, nan.contains(&true))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_leave_nan_out_and_tell() {
        for isa in Isa::available() {
            for n in 0..70 {
                let mut data: Vec<f64> = (0..n).map(|i| f64::from(i * 37 % 71)).collect();
                let least = data.iter().copied().fold(f64::INFINITY, f64::min);
                let most = data.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                assert_eq!(range(isa, &data), (least, most, false));
                data.push(f64::NAN);
                assert_eq!(range(isa, &data), (least, most, true));
            }
        }
    }
}
