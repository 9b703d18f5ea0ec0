//! AVX2: weights of 16 texels in a vector, four texels of four channels in two products.

use super::{BITS, Block, FINE, Frame, ONE, READ, Sums};
use std::arch::x86_64::*;

/// What weighs the texels of a block. To be used, as all of this file, only inside functions compiled for AVX2 on a machine that
/// has it.
pub struct Weights {
    steps: [__m256i; 2],
    narrow: [bool; 2],
    one: __m256i,
    minus_one: __m256i,
    half: __m256i,
    full: __m256i,
    least: __m256i,
    covariance: __m256i,
    rounding: __m128i,
    spread: [__m256i; 4],
}

// SAFETY, for every block of this file: its functions are called only where the machine has AVX2; loads and stores are of whole
// arrays, but for those that say more.
impl Weights {
    #[inline(always)]
    pub fn new(frame: &Frame) -> Self {
        // SAFETY: see above.
        unsafe {
            let [x, y] = frame.places;
            let (x, y) = (_mm256_loadu_si256(x.as_ptr().cast()), _mm256_loadu_si256(y.as_ptr().cast()));
            let step = |slope: [i16; 2]| {
                let along_x = _mm256_mulhrs_epi16(x, _mm256_set1_epi16(slope[0]));
                _mm256_add_epi16(along_x, _mm256_mulhrs_epi16(y, _mm256_set1_epi16(slope[1])))
            };
            // Word k of the edges in all lanes.
            let spread = |k: i16| _mm256_set1_epi16(2 * k + ((2 * k + 1) << 8));
            Self {
                steps: [step(frame.slopes[0]), step(frame.slopes[1])],
                narrow: frame.narrow,
                one: _mm256_set1_epi16(ONE),
                minus_one: _mm256_set1_epi16(-ONE),
                half: _mm256_set1_epi16(8192),
                full: _mm256_set1_epi16(16_384),
                least: _mm256_set1_epi16(i16::MIN),
                covariance: _mm256_set1_epi16(frame.covariance),
                rounding: _mm_set1_epi32(1 << (BITS - FINE - 1)),
                spread: [spread(0), spread(1), spread(2), spread(3)],
            }
        }
    }

    /// A distance cut to -1..1 and its size, to 14 fractional bits, and `c (|c|/2 - 1)`.
    #[inline(always)]
    fn cut(&self, m: __m256i) -> (__m256i, __m256i) {
        // SAFETY: see above.
        unsafe {
            let c = _mm256_max_epi16(_mm256_min_epi16(m, self.one), self.minus_one);
            let c = _mm256_slli_epi16::<{ 14 - FINE as i32 }>(c);
            let size = _mm256_abs_epi16(c);
            (size, _mm256_mulhrs_epi16(c, _mm256_or_si256(size, self.least)))
        }
    }

    /// `T` and `T'` of a strip. Of one that is wider than its edges only the nearer matters: beyond the other all is 1.
    #[inline(always)]
    fn across<const STRIP: usize>(&self, edges: __m256i) -> [__m256i; 2] {
        // SAFETY: see above.
        unsafe {
            let a = _mm256_shuffle_epi8(edges, self.spread[2 * STRIP]);
            let b = _mm256_shuffle_epi8(edges, self.spread[2 * STRIP + 1]);
            let a = _mm256_subs_epi16(a, self.steps[STRIP]);
            let b = _mm256_adds_epi16(b, self.steps[STRIP]);
            if self.narrow[STRIP] {
                let ((a, p), (b, q)) = (self.cut(a), self.cut(b));
                let both = _mm256_add_epi16(p, q);
                return [_mm256_sub_epi16(_mm256_setzero_si256(), both), _mm256_sub_epi16(a, b)];
            }
            let (size, p) = self.cut(_mm256_min_epi16(a, b));
            let slope = _mm256_sign_epi16(_mm256_sub_epi16(self.full, size), _mm256_subs_epi16(a, b));
            [_mm256_sub_epi16(self.half, p), slope]
        }
    }

    /// Weights of a block.
    #[inline(always)]
    pub fn at(&self, edges: [i32; 4]) -> __m256i {
        // SAFETY: see above.
        unsafe {
            let edges = _mm_add_epi32(_mm_loadu_si128(edges.as_ptr().cast()), self.rounding);
            let edges = _mm_srai_epi32::<{ (BITS - FINE) as i32 }>(edges);
            let edges = _mm256_broadcastsi128_si256(_mm_packs_epi32(edges, edges));
            let ([p, p_slope], [q, q_slope]) = (self.across::<0>(edges), self.across::<1>(edges));
            let slopes = _mm256_mulhrs_epi16(_mm256_mulhrs_epi16(p_slope, q_slope), self.covariance);
            let weights = _mm256_add_epi16(_mm256_mulhrs_epi16(p, q), slopes);
            _mm256_max_epi16(weights, _mm256_setzero_si256())
        }
    }
}

/// Orders of bytes for each number of lanes and channels, once.
const ORDERS: [[[u8; 16]; 4]; 4] = {
    let mut orders = [[[0x80; 16]; 4]; 4];
    let mut lanes = 1;
    while lanes <= 4 {
        let mut channels = 1;
        while channels <= lanes {
            let mut lane = 0;
            while lane < 16 {
                let (pair, channel, second) = (lane / 8, lane % 8 / 2, lane % 2);
                if channel < channels {
                    orders[lanes - 1][channels - 1][lane] = ((2 * pair + second) * lanes + channel) as u8;
                }
                lane += 1;
            }
            channels += 1;
        }
        lanes += 1;
    }
    orders
};

/// Sums under construction.
pub struct Avx2 {
    weights: Weights,
    order: __m256i,
    /// Bytes from four texels to the next.
    four: usize,
    codes: [__m256i; 2],
    weight: __m256i,
}

impl Avx2 {
    /// Eight texels, weighted by half `HALF` of the weights.
    #[inline(always)]
    fn half<const HALF: i32>(&mut self, texels: &[u8; READ], weights: __m256i) {
        // SAFETY: see above; `four` is at most 16, so both loads of 16 bytes lie in the 32.
        unsafe {
            let first = _mm_loadu_si128(texels.as_ptr().cast());
            let second = _mm_loadu_si128(texels.as_ptr().add(self.four).cast());
            let texels = _mm256_shuffle_epi8(_mm256_set_m128i(second, first), self.order);
            let zero = _mm256_setzero_si256();
            let even = _mm256_unpacklo_epi8(texels, zero);
            let odd = _mm256_unpackhi_epi8(texels, zero);
            let k = 4 * HALF;
            let for_even = _mm256_setr_epi32(k, k, k, k, k + 2, k + 2, k + 2, k + 2);
            let for_odd = _mm256_setr_epi32(k + 1, k + 1, k + 1, k + 1, k + 3, k + 3, k + 3, k + 3);
            let even = _mm256_madd_epi16(even, _mm256_permutevar8x32_epi32(weights, for_even));
            let odd = _mm256_madd_epi16(odd, _mm256_permutevar8x32_epi32(weights, for_odd));
            self.codes[0] = _mm256_add_epi32(self.codes[0], even);
            self.codes[1] = _mm256_add_epi32(self.codes[1], odd);
        }
    }
}

impl Block for Avx2 {
    #[inline(always)]
    fn new(frame: &Frame) -> Self {
        let order = &ORDERS[frame.lanes - 1][frame.channels - 1];
        // SAFETY: see above.
        unsafe {
            let zero = _mm256_setzero_si256();
            Self {
                weights: Weights::new(frame),
                order: _mm256_broadcastsi128_si256(_mm_loadu_si128(order.as_ptr().cast())),
                four: 4 * frame.lanes,
                codes: [zero; 2],
                weight: zero,
            }
        }
    }

    #[inline(always)]
    fn add(&mut self, edges: [i32; 4], texels: [&[u8; READ]; 2]) {
        let weights = self.weights.at(edges);
        self.half::<0>(texels[0], weights);
        self.half::<1>(texels[1], weights);
        // SAFETY: see above.
        unsafe {
            let pairs = _mm256_madd_epi16(weights, _mm256_set1_epi16(1));
            self.weight = _mm256_add_epi32(self.weight, pairs);
        }
    }

    #[inline(always)]
    fn drain(&mut self) -> Sums {
        let (mut codes, mut weights) = ([0i32; 4], [0i32; 4]);
        // SAFETY: see above.
        unsafe {
            let zero = _mm256_setzero_si256();
            let folded =
                |all: __m256i| _mm_add_epi32(_mm256_castsi256_si128(all), _mm256_extracti128_si256::<1>(all));
            let all = folded(_mm256_add_epi32(self.codes[0], self.codes[1]));
            _mm_storeu_si128(codes.as_mut_ptr().cast(), all);
            _mm_storeu_si128(weights.as_mut_ptr().cast(), folded(self.weight));
            (self.codes, self.weight) = ([zero; 2], zero);
        }
        Sums { codes: codes.map(i64::from), weight: weights.iter().sum::<i32>().into() }
    }
}
