//! What lies outside the texture: integer and continuous wrapping, one axis at a time.
//!
//! ```text
//!                  ...  -4 -3 -2 -1 | 0  1  2  3 | 4  5  6  7 ...      four texels a b c d
//! Clamp                  a  a  a  a | a  b  c  d | d  d  d  d
//! Repeat                 a  b  c  d | a  b  c  d | a  b  c  d
//! Mirror                 d  c  b  a | a  b  c  d | d  c  b  a
//! MirrorOnce             d  c  b  a | a  b  c  d | d  d  d  d    (and d before -4)
//! Mirror101              c  d  c  b | a  b  c  d | c  b  a  b
//! Border                 #  #  #  # | a  b  c  d | #  #  #  #    # = border colour
//! Extend                 <  <  <  < | a  b  c  d | >  >  >  >    < > = the stored extra texels
//! ```

use crate::error::{Error, Result};

/// Wrap mode of one axis; the table at the head of this module shows each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The edge texel goes on.
    #[default]
    Clamp,
    /// Periodic.
    Repeat,
    /// Periodic with every second copy reversed; the edge texel appears twice.
    Mirror,
    /// One reversed copy before the origin, then clamped on both sides.
    MirrorOnce,
    /// Mirror about the centre of the edge texel, which appears once.
    Mirror101,
    /// A constant colour.
    Border,
    /// The texture is stored with one extra texel on each side, which goes on.
    Extend,
}

impl Wrap {
    /// All modes with their names, in the order of the table above.
    pub const NAMES: [(&'static str, Self); 7] = [
        ("clamp", Self::Clamp),
        ("repeat", Self::Repeat),
        ("mirror", Self::Mirror),
        ("mirror_once", Self::MirrorOnce),
        ("mirror_101", Self::Mirror101),
        ("border", Self::Border),
        ("extend", Self::Extend),
    ];

    /// The mode of this name.
    ///
    /// # Errors
    /// [`Error::Value`] for any other word.
    pub fn parse(argument: &'static str, name: &str) -> Result<Self> {
        Self::NAMES.iter().find(|(n, _)| *n == name).map(|(_, w)| *w).ok_or_else(|| {
            let names: Vec<_> = Self::NAMES.iter().map(|(n, _)| format!("{n:?}")).collect();
            Error::value(argument, format!("{name:?}"), format!("one of {}", names.join(", ")))
        })
    }

    /// The mode's name.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, w)| *w == self).map_or("clamp", |(n, _)| n)
    }

    /// The texel that stands at index `i` of an axis of `n` texels: an index in `0..n`, or -1 and `n` for
    /// the extra texels of `Extend`, or `None` for the border colour.
    #[inline(always)]
    pub fn index(self, i: i64, n: i64) -> Option<i64> {
        debug_assert!(n > 0);
        if (0..n).contains(&i) {
            return Some(i);
        }
        match self {
            Self::Clamp => Some(i.clamp(0, n - 1)),
            Self::Repeat => Some(i.rem_euclid(n)),
            Self::Mirror => {
                let m = i.rem_euclid(2 * n);
                Some(m.min(2 * n - 1 - m))
            }
            Self::MirrorOnce => Some((if i < 0 { -1 - i } else { i }).min(n - 1)),
            Self::Mirror101 if n == 1 => Some(0),
            Self::Mirror101 => {
                let m = i.rem_euclid(2 * n - 2);
                Some(m.min(2 * n - 2 - m))
            }
            Self::Border => None,
            Self::Extend => Some(i.clamp(-1, n)),
        }
    }

    /// Brings a coordinate (texel `i` covers `i..i+1`) into `0..=n` along a periodic axis, and to the side
    /// from 0 on along [`Wrap::MirrorOnce`]; the picture seen there is the same. Other modes leave it alone.
    /// Returns the coordinate and -1.0 where the axis runs backwards there, else 1.0. NaN stays NaN.
    #[inline(always)]
    pub fn reduce(self, s: f64, n: f64) -> (f64, f64) {
        match self {
            Self::Clamp | Self::Border | Self::Extend => (s, 1.0),
            _ if s >= 0.0 && s < n && self != Self::Mirror101 => (s, 1.0),
            Self::Repeat => (modulo(s, n), 1.0),
            Self::Mirror => {
                let m = modulo(s, 2.0 * n);
                if m < n { (m, 1.0) } else { (2.0 * n - m, -1.0) }
            }
            Self::MirrorOnce => {
                if s < 0.0 {
                    (-s, -1.0)
                } else {
                    (s, 1.0)
                }
            }
            Self::Mirror101 if n == 1.0 => (s * 0.0 + 0.5, 1.0),
            Self::Mirror101 => {
                // The half comes off after the reduction, where it is not lost to rounding.
                let m = modulo(s, 2.0 * n - 2.0) - 0.5;
                let m = if m < 0.0 { m + (2.0 * n - 2.0) } else { m };
                if m < n - 1.0 { (m + 0.5, 1.0) } else { (2.0 * n - 1.5 - m, -1.0) }
            }
        }
    }

    /// Length after which the axis repeats itself, in texels; `None` where it never does.
    #[inline(always)]
    pub fn period(self, n: f64) -> Option<f64> {
        match self {
            Self::Repeat => Some(n),
            Self::Mirror => Some(2.0 * n),
            Self::Mirror101 => Some((2.0 * n - 2.0).max(1.0)),
            Self::Clamp | Self::MirrorOnce | Self::Border | Self::Extend => None,
        }
    }
}

/// Up to here `n * floor(s / n)` is a whole number that f64 holds exactly, and so is the rounding of its difference to `s`.
pub(crate) const EXACT: f64 = 1.1e12;

/// `s` modulo a whole `n`, in `0..=n`.
#[inline(always)]
pub(crate) fn modulo(s: f64, n: f64) -> f64 {
    if s.abs() < EXACT { (s - n * crate::num::floor(s / n) as f64).clamp(0.0, n) } else { s.rem_euclid(n) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rows of the table in the module's head, and wider, by writing the picture out.
    #[test]
    fn indices_agree_with_the_written_out_sequence() {
        for n in 1..=9i64 {
            let forward: Vec<i64> = (0..n).collect();
            let backward: Vec<i64> = (0..n).rev().collect();
            let inner: Vec<i64> = (1..n - 1).rev().collect();
            let unroll = |parts: [&[i64]; 2]| -> Vec<i64> { parts.concat().repeat(40) };
            let (repeat, mirror) = (unroll([&forward, &[]]), unroll([&forward, &backward]));
            let mirror101 = if n == 1 { vec![0; 40] } else { unroll([&forward, &inner]) };
            for i in -4 * n..=4 * n {
                let at = |cycle: &[i64], period: i64| Some(cycle[(i + 20 * period) as usize % cycle.len()]);
                assert_eq!(Wrap::Repeat.index(i, n), at(&repeat, n), "repeat {i} of {n}");
                assert_eq!(Wrap::Mirror.index(i, n), at(&mirror, 2 * n), "mirror {i} of {n}");
                let period = if n == 1 { 1 } else { 2 * n - 2 };
                assert_eq!(Wrap::Mirror101.index(i, n), at(&mirror101, period), "101 {i} of {n}");
                assert_eq!(Wrap::Clamp.index(i, n), Some(i.max(0).min(n - 1)));
                let once = if i < -n {
                    n - 1
                } else if i < 0 {
                    -i - 1
                } else {
                    i.min(n - 1)
                };
                assert_eq!(Wrap::MirrorOnce.index(i, n), Some(once), "once {i} of {n}");
                assert_eq!(Wrap::Border.index(i, n), (i >= 0 && i < n).then_some(i));
                assert_eq!(Wrap::Extend.index(i, n), Some(i.max(-1).min(n)));
            }
        }
    }

    /// A linear reconstruction read at the reduced place equals the one read at the original place.
    #[test]
    fn reducing_does_not_change_the_reconstruction() {
        let value = |w: Wrap, i: i64, n: i64| w.index(i, n).map_or(-7.0, |i| ((i + 3) * (i + 3)) as f64);
        let read = |w: Wrap, s: f64, n: i64| {
            let x = s - 0.5;
            let (i, f) = (x.floor() as i64, x - x.floor());
            value(w, i, n) * (1.0 - f) + value(w, i + 1, n) * f
        };
        for (_, w) in Wrap::NAMES {
            for n in [1i64, 2, 3, 5, 8] {
                for k in -64 * n..=64 * n {
                    let s = k as f64 / 16.0;
                    let (reduced, sign) = w.reduce(s, n as f64);
                    if w.period(n as f64).is_some() {
                        assert!((0.0..=n as f64).contains(&reduced), "{w:?} {s} of {n} -> {reduced}");
                    }
                    assert!(
                        (read(w, s, n) - read(w, reduced, n)).abs() < 1e-9,
                        "{w:?} {s} of {n} -> {reduced}"
                    );
                    // The sign is that of the axis: a step forwards is a step of this sign.
                    let (ahead, _) = w.reduce(s + 1e-3, n as f64);
                    if (ahead - reduced).abs() < 0.01 && n > 1 {
                        assert_eq!((ahead - reduced).signum(), sign, "{w:?} {s} of {n}");
                    }
                }
            }
        }
    }

    #[test]
    fn any_finite_coordinate_reduces_into_range() {
        for (_, w) in Wrap::NAMES.iter().filter(|(_, w)| w.period(2.0).is_some()) {
            for n in [1.0, 2.0, 41.0, 47.0, 16_384.0] {
                for s in [1e300, -1e300, -1e-300, 1e15, 0.0, n, -1e-9, 3.0 * n, f64::MAX] {
                    let (reduced, _) = w.reduce(s, n);
                    assert!((0.0..=n).contains(&reduced), "{w:?} {s} of {n} -> {reduced}");
                }
                assert!(w.reduce(f64::NAN, n).0.is_nan());
            }
        }
    }
}
