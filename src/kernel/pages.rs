//! Large arrays in large pages.
//!
//! The first touch of a page of 4096 bytes costs about as much as filling it; pages of 2 MiB, where the system has them
//! on request, take most of that away, and most of what address translation costs at scattered reads. What a system
//! answers to the request changes nothing but time.

/// Bytes of a large page, and of an array from which on it is asked for.
#[cfg(target_os = "linux")]
const PAGE: usize = 1 << 21;

/// An array of `count` zeros.
pub fn zeros<T: Copy + Default>(count: usize) -> Vec<T> {
    let made = vec![T::default(); count];
    #[cfg(target_os = "linux")]
    if size_of_val(made.as_slice()) >= 2 * PAGE {
        let start = made.as_ptr() as usize;
        let first = start.next_multiple_of(PAGE);
        let end = (start + size_of_val(made.as_slice())) / PAGE * PAGE;
        // SAFETY: whole pages inside the array, which the advice leaves as they are.
        unsafe { libc::madvise(first as *mut libc::c_void, end - first, libc::MADV_HUGEPAGE) };
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_of_any_size_are_zero() {
        for count in [0, 1, 1000, 3 << 20] {
            let mut made = zeros::<u32>(count);
            assert!(made.len() == count && made.iter().all(|&v| v == 0));
            made.fill(7);
        }
    }
}
