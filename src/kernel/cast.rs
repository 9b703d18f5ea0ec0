//! Slices of a generic element type as slices of the type that it is.

use std::any::TypeId;

/// The same slice, where `A` and `B` are one type.
pub fn same<A: 'static, B: 'static>(slice: &[A]) -> Option<&[B]> {
    // SAFETY: the types are equal, so the slice is one of `B` already.
    (TypeId::of::<A>() == TypeId::of::<B>())
        .then(|| unsafe { std::slice::from_raw_parts(slice.as_ptr().cast(), slice.len()) })
}

/// The same mutable slice, where `A` and `B` are one type.
pub fn same_mut<A: 'static, B: 'static>(slice: &mut [A]) -> Option<&mut [B]> {
    // SAFETY: the types are equal, so the slice is one of `B` already, borrowed as long.
    (TypeId::of::<A>() == TypeId::of::<B>())
        .then(|| unsafe { std::slice::from_raw_parts_mut(slice.as_mut_ptr().cast(), slice.len()) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_same_type_is_the_same() {
        assert_eq!(same::<u8, u8>(&[1, 2]), Some(&[1u8, 2][..]));
        assert_eq!(same::<u8, i8>(&[1, 2]), None);
        assert_eq!(same_mut::<f32, f32>(&mut [1.0]), Some(&mut [1.0f32][..]));
        assert_eq!(same_mut::<f32, u32>(&mut [1.0]), None);
    }
}
