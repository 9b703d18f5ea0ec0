//! Linear interpolation of three and four channels, a pixel a vector of doubles.

use super::{Lerp, Real, Scaled, Split};
use std::any::TypeId;
use std::arch::x86_64::{
    __m256d, _mm_add_ps, _mm_cvtsi32_si128, _mm_loadl_epi64, _mm_loadu_ps, _mm_mul_ps, _mm_set1_ps,
    _mm256_add_pd, _mm256_cvtepi32_pd, _mm256_cvtps_pd, _mm256_loadu_pd, _mm256_max_pd, _mm256_min_pd,
    _mm256_mul_pd, _mm256_set1_pd, _mm256_storeu_pd,
};
use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch, _mm_storeu_ps, _mm256_cvtpd_ps};
use std::arch::x86_64::{_mm_cvtepu8_epi32, _mm_cvtepu16_epi32};

/// Elements of which four become doubles at once.
pub(super) trait Four: Scaled<f64> {
    /// # Safety
    /// Four elements at `at` must be readable, and the machine must have AVX2.
    unsafe fn load(at: *const Self, factor: __m256d) -> __m256d;
}

/// Loads of the integers; their factor is applied after the conversion.
macro_rules! four {
    ($type:ty, |$at:ident, $factor:ident| $body:expr) => {
        impl Four for $type {
            #[inline]
            #[target_feature(enable = "avx2")]
            unsafe fn load($at: *const Self, $factor: __m256d) -> __m256d {
                // SAFETY: the caller vouches for four elements.
                unsafe { $body }
            }
        }
    };
}
four!(f64, |at, _factor| _mm256_loadu_pd(at));
four!(f32, |at, _factor| _mm256_cvtps_pd(_mm_loadu_ps(at)));
four!(u8, |at, factor| {
    let codes = _mm_cvtsi32_si128(at.cast::<i32>().read_unaligned());
    _mm256_mul_pd(_mm256_cvtepi32_pd(_mm_cvtepu8_epi32(codes)), factor)
});
four!(u16, |at, factor| {
    let codes = _mm_loadl_epi64(at.cast());
    _mm256_mul_pd(_mm256_cvtepi32_pd(_mm_cvtepu16_epi32(codes)), factor)
});

/// Where the taps of pixel `i` start: the first one's offset, and the steps to the right and down. `None` where four
/// elements from any of them on are not all inside the picture.
#[inline(always)]
fn taps<S, H: Real, O>(lerp: &Lerp<'_, S, H, O>, split: &Split<'_, H>, i: usize) -> Option<[usize; 3]> {
    let s = &lerp.source;
    let (x, y) = (split.x[i] as u32 as usize, split.y[i] as u32 as usize);
    let right = usize::from(split.fx[i] != H::default());
    let below = usize::from(split.fy[i] != H::default());
    let last = (y + below).wrapping_mul(s.row_stride).wrapping_add((x + right) * s.channels);
    let inside = x + right < s.width && y + below < s.height && last + 4 <= s.data.len();
    inside.then_some([
        y.wrapping_mul(s.row_stride) + x * s.channels,
        right * s.channels,
        below * s.row_stride,
    ])
}

/// Stores four results.
///
/// # Safety
/// The slice must hold four elements, and the machine must have AVX2.
#[inline]
#[target_feature(enable = "avx2")]
unsafe fn store<O: Real>(value: __m256d, out: &mut [O]) {
    if TypeId::of::<O>() == TypeId::of::<f64>() {
        // SAFETY: the elements are four doubles.
        unsafe { _mm256_storeu_pd(out.as_mut_ptr().cast(), value) };
    } else if TypeId::of::<O>() == TypeId::of::<f32>() {
        // SAFETY: the elements are four singles.
        unsafe { _mm_storeu_ps(out.as_mut_ptr().cast(), _mm256_cvtpd_ps(value)) };
    }
}

/// How many pixels ahead memory is asked for.
const AHEAD: usize = 24;

/// Asks for the memory of a pixel that is read soon: positions along a slanted line are no pattern to the machine.
#[inline(always)]
fn fetch<S, H, O>(lerp: &Lerp<'_, S, H, O>, split: &Split<'_, H>, i: usize) {
    let s = &lerp.source;
    let at = (split.y[i] as isize)
        .wrapping_mul(s.row_stride as isize)
        .wrapping_add((split.x[i] as isize).wrapping_mul(s.channels as isize));
    let start = s.data.as_ptr().wrapping_offset(at);
    // SAFETY: a prefetch of any address is harmless.
    unsafe {
        _mm_prefetch::<_MM_HINT_T0>(start.cast());
        _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(s.row_stride).cast());
    }
}

/// One loop for both kinds of arithmetic: `$upper_lower` makes the two rows' values, as doubles.
macro_rules! kernel {
    ($(#[$doc:meta])* $name:ident<$s:ident: $bound:path, $h:ty>, |$lerp:ident, $at:ident, $fx:ident| $rows:expr) => {
        $(#[$doc])*
        ///
        /// # Safety
        /// The machine must have AVX2.
        #[target_feature(enable = "avx2")]
        pub(super) unsafe fn $name<$s: $bound, O: Real>(
            $lerp: &Lerp<'_, $s, $h, O>,
            split: &Split<'_, $h>,
            out: &mut [O],
        ) {
            let channels = $lerp.source.channels;
            let lengths = [split.y.len(), split.fx.len(), split.fy.len(), out.len() / channels];
            let count = lengths.into_iter().fold(split.x.len(), usize::min);
            let [low, high] = $lerp.limits.map(|v| _mm256_set1_pd(v));
            for i in 0..count {
                if i + AHEAD < count {
                    fetch($lerp, split, i + AHEAD);
                }
                let to = i * channels;
                let ($at, $fx) = match taps($lerp, split, i) {
                    Some(taps) if to + 4 <= out.len() => (taps, split.fx[i]),
                    _ => {
                        $lerp.beyond(split, i, &mut out[to..to + channels]);
                        continue;
                    }
                };
                // SAFETY: `taps` has found four elements inside the slice at each of the four places.
                let [upper, lower] = unsafe { $rows };
                let fy = split.fy[i].wide();
                let gy = (<$h>::of(1.0) - split.fy[i]).wide();
                let value = _mm256_add_pd(
                    _mm256_mul_pd(_mm256_set1_pd(gy), upper),
                    _mm256_mul_pd(_mm256_set1_pd(fy), lower),
                );
                // The second operand wins where one is NaN.
                let value = _mm256_min_pd(high, _mm256_max_pd(low, value));
                // The lane beyond the pixel's own is written over by the next pixel.
                // SAFETY: the slice holds four elements, and the machine has AVX2.
                unsafe { store(value, &mut out[to..to + 4]) };
            }
        }
    };
}

kernel!(
    /// Rows in doubles.
    wide<S: Four, f64>, |lerp, at, fx| {
        let (f, g) = (_mm256_set1_pd(fx), _mm256_set1_pd(1.0 - fx));
        let factor = _mm256_set1_pd(lerp.factor);
        let [start, right, below] = at;
        [start, start + below].map(|row| {
            let a = S::load(lerp.source.data.as_ptr().add(row), factor);
            let b = S::load(lerp.source.data.as_ptr().add(row + right), factor);
            _mm256_add_pd(_mm256_mul_pd(g, a), _mm256_mul_pd(f, b))
        })
    }
);

/// Singles, of which there is one kind.
pub(super) trait Single: Scaled<f32> {
    /// As a pointer to singles.
    fn singles(data: &[Self]) -> *const f32;
}

impl Single for f32 {
    fn singles(data: &[Self]) -> *const f32 {
        data.as_ptr()
    }
}

kernel!(
    /// Rows in singles.
    single<S: Single, f32>, |lerp, at, fx| {
        let (f, g) = (_mm_set1_ps(fx), _mm_set1_ps(1.0 - fx));
        let data = S::singles(lerp.source.data);
        let [start, right, below] = at;
        [start, start + below].map(|row| {
            let (a, b) = (_mm_loadu_ps(data.add(row)), _mm_loadu_ps(data.add(row + right)));
            _mm256_cvtps_pd(_mm_add_ps(_mm_mul_ps(g, a), _mm_mul_ps(f, b)))
        })
    }
);
