//! Nearest: whole pixels are copied.

use super::block::{Kernel, Slot};

/// Copies pixels of `C` channels, of which `N` are a block. What a wide move carries beyond a pixel is written over by
/// the next.
pub(super) struct Copy<const C: usize, const N: usize>;

impl<const C: usize, const N: usize> Copy<C, N> {
    /// Bytes of the move for a pixel.
    const fn wide(pixel: usize) -> usize {
        if pixel <= 2 { pixel } else { pixel.next_power_of_two() }
    }
}

/// Moves `W` bytes.
///
/// # Safety
/// They are readable and writable.
#[inline(always)]
unsafe fn carry<const W: usize>(from: *const u8, to: *mut u8) {
    // SAFETY: the caller vouches for the bytes; they need no alignment.
    unsafe { to.cast::<[u8; W]>().write_unaligned(from.cast::<[u8; W]>().read_unaligned()) };
}

impl<T: std::marker::Copy, const C: usize, const N: usize> Kernel<T> for Copy<C, N> {
    const CHANNELS: usize = C;
    const TAPS: usize = 1;
    const LOAD: usize = Self::wide(C * size_of::<T>()).div_ceil(size_of::<T>());
    const FETCHES: bool = true;

    #[inline(always)]
    unsafe fn block(&self, rows: *const T, _stride: usize, slot: &Slot, out: *mut T) {
        let pixel = C * size_of::<T>();
        for (i, &offset) in slot.offsets[..N].iter().enumerate() {
            // SAFETY: `LOAD` elements are readable; the output has room for all pixels of the block, and the last is
            // moved as it is.
            unsafe {
                let (from, to) = (rows.cast::<u8>().add(offset as usize), out.add(i * C).cast::<u8>());
                if i + 1 == N {
                    std::ptr::copy_nonoverlapping(from, to, pixel);
                } else {
                    match Self::wide(pixel) {
                        1 => carry::<1>(from, to),
                        2 => carry::<2>(from, to),
                        4 => carry::<4>(from, to),
                        8 => carry::<8>(from, to),
                        16 => carry::<16>(from, to),
                        _ => std::ptr::copy_nonoverlapping(from, to, pixel),
                    }
                }
            }
        }
    }
}
