//! Maps in all the forms that `remap` takes: positions into them, and from one to another.

use crate::error::{Error, Result};
use crate::kernel::{Isa, Work, compiled_for};
use crate::par;
use crate::warp::remap::Map;

/// Steps of a fixed-point map in a pixel.
const STEPS: f64 = 32.0;

/// Positions that are converted at a time.
const CHUNK: usize = 256;

/// Positions that a thread takes at a time.
const BAND: usize = 1 << 15;

/// Positions nearer than this are whole pixels of 16 bits.
const NEAR: f64 = 32_767.0;

/// A map to fill.
#[derive(Debug)]
pub enum Target<'a> {
    /// Columns and rows.
    Planes(&'a mut [f32], &'a mut [f32]),
    /// Pairs.
    Pairs(&'a mut [f32]),
    /// Pairs of whole pixels, and fractions `32 * fy + fx` in 1/32 pixel; without these the nearest pixels.
    Fixed(&'a mut [i16], Option<&'a mut [u16]>),
}

/// What becomes of whole pixels that 16 bits do not hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beyond {
    /// The nearest that they hold.
    Saturate,
    /// Upper bits are lost.
    Wrap,
}

/// A number that can be rounded to steps.
pub trait Steps: Copy + Default + Send + Sync {
    /// Whether all positions are near: then [`Steps::near`] is right for them.
    fn all_near(positions: &[Self]) -> bool;
    /// The nearest number of steps, ties to even, of a near position.
    fn near(self, steps: f64) -> i32;
    /// The same of any position; the least number for those that are not finite or, under [`Beyond::Wrap`], too large.
    fn far(self, steps: f64, beyond: Beyond) -> i32;
    /// As a single.
    fn single(self) -> f32;
}

macro_rules! steps {
    ($t:ty, $magic:literal) => {
        impl Steps for $t {
            #[inline(always)]
            fn all_near(positions: &[Self]) -> bool {
                // No early exit, for the sake of vectors; NaN is not below anything.
                positions.iter().fold(true, |near, p| near & (p.abs() < NEAR as Self))
            }
            #[inline(always)]
            fn near(self, steps: f64) -> i32 {
                // The low bits of the sum with a number whose unit is 1.
                const MAGIC: $t = $magic;
                ((self * steps as Self + MAGIC).to_bits() as i32).wrapping_sub(MAGIC.to_bits() as i32)
            }
            #[inline(always)]
            fn far(self, steps: f64, beyond: Beyond) -> i32 {
                let x = (f64::from(self) * steps).round_ties_even();
                let fits = (-2_147_483_648.0..2_147_483_648.0).contains(&x);
                // `as` sends NaN to 0, and saturates.
                if fits || (beyond == Beyond::Saturate && x.is_finite()) { x as i32 } else { i32::MIN }
            }
            #[inline(always)]
            fn single(self) -> f32 {
                self as f32
            }
        }
    };
}
steps!(f32, 12_582_912.0);
steps!(f64, 6_755_399_441_055_744.0);

/// Writes positions as whole pixels and codes.
#[inline(always)]
fn to_fixed<A: Steps>([x, y]: [&[A]; 2], beyond: Beyond, whole: &mut [[i16; 2]], codes: Option<&mut [u16]>) {
    let narrow = |x: i32| match beyond {
        Beyond::Saturate => x.clamp(i32::from(i16::MIN), i32::from(i16::MAX)) as i16,
        Beyond::Wrap => x as i16,
    };
    let code = |x: i32, y: i32| ((y & 31) << 5 | (x & 31)) as u16;
    let places = whole.iter_mut().zip(x.iter().zip(y));
    match (codes, A::all_near(x) && A::all_near(y)) {
        (None, true) => places.for_each(|(pair, (x, y))| *pair = [x.near(1.0) as i16, y.near(1.0) as i16]),
        (None, false) => {
            places
                .for_each(|(pair, (x, y))| *pair = [narrow(x.far(1.0, beyond)), narrow(y.far(1.0, beyond))]);
        }
        (Some(codes), true) => {
            for ((pair, (x, y)), c) in places.zip(codes) {
                let (x, y) = (x.near(STEPS), y.near(STEPS));
                (*pair, *c) = ([(x >> 5) as i16, (y >> 5) as i16], code(x, y));
            }
        }
        (Some(codes), false) => {
            for ((pair, (x, y)), c) in places.zip(codes) {
                let (x, y) = (x.far(STEPS, beyond), y.far(STEPS, beyond));
                (*pair, *c) = ([narrow(x >> 5), narrow(y >> 5)], code(x, y));
            }
        }
    }
}

impl<'a> Target<'a> {
    /// Positions that it holds.
    ///
    /// # Errors
    /// [`Error::Value`] where its parts do not fit together.
    pub fn count(&self) -> Result<usize> {
        let (one, other) = match self {
            Self::Planes(x, y) => (x.len(), y.len()),
            Self::Pairs(p) => (p.len() / 2, p.len().div_ceil(2)),
            Self::Fixed(p, None) => (p.len() / 2, p.len().div_ceil(2)),
            Self::Fixed(p, Some(codes)) => {
                (codes.len(), if p.len() == 2 * codes.len() { codes.len() } else { 0 })
            }
        };
        if one == other {
            return Ok(one);
        }
        Err(Error::value("map", format!("parts for {one} and {other} positions"), "one place a pixel"))
    }

    /// Its parts of so many positions each, in order.
    pub fn bands(self, size: usize) -> Vec<Target<'a>> {
        match self {
            Self::Planes(x, y) => {
                x.chunks_mut(size).zip(y.chunks_mut(size)).map(|(x, y)| Target::Planes(x, y)).collect()
            }
            Self::Pairs(p) => p.chunks_mut(2 * size).map(Target::Pairs).collect(),
            Self::Fixed(p, None) => p.chunks_mut(2 * size).map(|p| Target::Fixed(p, None)).collect(),
            Self::Fixed(p, Some(codes)) => {
                let parts = p.chunks_mut(2 * size).zip(codes.chunks_mut(size));
                parts.map(|(p, codes)| Target::Fixed(p, Some(codes))).collect()
            }
        }
    }

    /// Writes positions from place `at` on.
    #[inline(always)]
    pub fn write<A: Steps>(&mut self, at: usize, x: &[A], y: &[A], beyond: Beyond) {
        let range = at..at + x.len();
        match self {
            Self::Planes(px, py) => {
                for (to, from) in [(&mut px[range.clone()], x), (&mut py[range], y)] {
                    to.iter_mut().zip(from).for_each(|(to, from)| *to = from.single());
                }
            }
            Self::Pairs(p) => {
                let places = p.as_chunks_mut::<2>().0[range].iter_mut().zip(x.iter().zip(y));
                places.for_each(|(pair, (x, y))| *pair = [x.single(), y.single()]);
            }
            Self::Fixed(p, codes) => {
                let codes = codes.as_mut().map(|codes| &mut codes[range.clone()]);
                to_fixed([x, y], beyond, &mut p.as_chunks_mut::<2>().0[range], codes);
            }
        }
    }
}

/// Writes a map in another form. Positions are rounded to nearest and saturated where they become fixed-point numbers;
/// those that are not finite are as far left and above as there are pixels.
///
/// # Errors
/// [`Error::Value`] for a matrix, or a target of another size; [`Error::Interrupted`].
///
/// ```
/// use multum::compat::cv2::maps::{Target, convert};
/// use multum::warp::remap::Map;
/// let (mut whole, mut codes) = ([0; 2], [0]);
/// convert(&Map::Single(&[1.5], &[2.25]), Target::Fixed(&mut whole, Some(&mut codes)))?;
/// assert_eq!((whole, codes), ([1, 2], [16 + 32 * 8]));
/// # Ok::<(), multum::Error>(())
/// ```
pub fn convert(map: &Map<'_>, target: Target<'_>) -> Result<()> {
    let count = target.count()?;
    if !map.fits(count) || matches!(map, Map::Matrix(_)) {
        return Err(Error::value("dstmap1", format!("{count} places"), "one for each position of map1"));
    }
    let isa = Isa::current();
    let work = |first: usize, mut band: Target<'_>| -> Result<()> {
        let len = band.count()?;
        for at in (0..len).step_by(CHUNK) {
            let range = first + at..first + (at + CHUNK).min(len);
            compiled_for(isa, Chunk { map, range, at, target: &mut band });
        }
        Ok(())
    };
    if count <= BAND {
        return work(0, target);
    }
    par::for_each(target.bands(BAND).into_iter(), |i, band| work(i * BAND, band))
}

/// Some positions of a map, to place `at` of a target; to be compiled for an instruction set.
struct Chunk<'a, 'm, 't> {
    map: &'a Map<'m>,
    range: std::ops::Range<usize>,
    at: usize,
    target: &'a mut Target<'t>,
}

impl Work for Chunk<'_, '_, '_> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        chunk(self.map, self.range, self.at, self.target);
    }
}

#[inline(always)]
fn chunk(map: &Map<'_>, range: std::ops::Range<usize>, at: usize, target: &mut Target<'_>) {
    let n = range.len().min(CHUNK);
    let pairs = 2 * range.start..2 * range.end;
    match *map {
        Map::Single(x, y) => target.write(at, &x[range.clone()], &y[range], Beyond::Saturate),
        Map::Double(x, y) => target.write(at, &x[range.clone()], &y[range], Beyond::Saturate),
        Map::SinglePairs(p) => {
            let (mut x, mut y) = ([0f32; CHUNK], [0f32; CHUNK]);
            apart(&p[pairs], &mut x, &mut y);
            target.write(at, &x[..n], &y[..n], Beyond::Saturate);
        }
        Map::DoublePairs(p) => {
            let (mut x, mut y) = ([0f64; CHUNK], [0f64; CHUNK]);
            apart(&p[pairs], &mut x, &mut y);
            target.write(at, &x[..n], &y[..n], Beyond::Saturate);
        }
        Map::Fixed(p, codes) => {
            let (mut x, mut y) = ([0f32; CHUNK], [0f32; CHUNK]);
            let places = x.iter_mut().zip(&mut y).zip(p[pairs].as_chunks::<2>().0);
            match codes {
                None => places.for_each(|((x, y), pair)| [*x, *y] = from_fixed(*pair, 0)),
                Some(codes) => places
                    .zip(&codes[range])
                    .for_each(|(((x, y), pair), &code)| [*x, *y] = from_fixed(*pair, code)),
            }
            target.write(at, &x[..n], &y[..n], Beyond::Saturate);
        }
        Map::Matrix(_) => {}
    }
}

/// Takes pairs apart.
#[inline(always)]
fn apart<A: Copy>(pairs: &[A], x: &mut [A], y: &mut [A]) {
    for ((x, y), pair) in x.iter_mut().zip(y).zip(pairs.as_chunks::<2>().0) {
        [*x, *y] = *pair;
    }
}

/// The position that a pair of whole pixels and a code stand for.
#[inline(always)]
pub fn from_fixed(pair: [i16; 2], code: u16) -> [f32; 2] {
    [
        f32::from(pair[0]) + f32::from(code & 31) * (1.0 / 32.0),
        f32::from(pair[1]) + f32::from(code >> 5 & 31) * (1.0 / 32.0),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The definition, position by position.
    fn plainly(x: f64) -> (i16, u16) {
        let steps = (x * 32.0).round_ties_even();
        let steps = if steps.is_finite() { steps as i32 } else { i32::MIN };
        ((steps >> 5).clamp(-32_768, 32_767) as i16, (steps & 31) as u16)
    }

    #[test]
    fn fixed_point_is_the_nearest_step_for_any_form_and_size() {
        let strange =
            [40_000.0, -1e300, f64::NAN, f64::INFINITY, 32_766.99, -32_767.5, 1.0 / 64.0, -3.0 / 64.0];
        for n in [1usize, 5, 255, 256, 257, 70_000] {
            let x: Vec<f64> =
                (0..n).map(|i| (i as f64 * 0.37 - 20.0) * if i % 7 == 0 { -3.1 } else { 1.0 }).collect();
            let mut y: Vec<f64> = x.iter().rev().map(|x| x * 0.71 + 0.01).collect();
            if n > 256 {
                y[200..208].copy_from_slice(&strange);
            }
            let pairs: Vec<f64> = x.iter().zip(&y).flat_map(|(&x, &y)| [x, y]).collect();
            let single = |v: &[f64]| v.iter().map(|&v| v as f32).collect::<Vec<_>>();
            let (x32, y32, pairs32) = (single(&x), single(&y), single(&pairs));
            for (map, exact) in [
                (Map::Double(&x, &y), true),
                (Map::DoublePairs(&pairs), true),
                (Map::Single(&x32, &y32), false),
                (Map::SinglePairs(&pairs32), false),
            ] {
                let (mut whole, mut codes) = (vec![0; 2 * n], vec![0; n]);
                convert(&map, Target::Fixed(&mut whole, Some(&mut codes))).unwrap();
                for i in 0..n {
                    let at = |v: f64| plainly(if exact { v } else { f64::from(v as f32) });
                    let ((px, fx), (py, fy)) = (at(x[i]), at(y[i]));
                    assert_eq!(
                        ([whole[2 * i], whole[2 * i + 1]], codes[i]),
                        ([px, py], fx + 32 * fy),
                        "{n} {i}"
                    );
                }
                // And back, where the pixels are whole numbers of 16 bits.
                let (mut back_x, mut back) = (vec![0.0; n], vec![0.0; 2 * n]);
                let mut back_y = back_x.clone();
                let fixed = Map::Fixed(&whole, Some(&codes));
                convert(&fixed, Target::Planes(&mut back_x, &mut back_y)).unwrap();
                convert(&fixed, Target::Pairs(&mut back)).unwrap();
                for i in 0..n {
                    assert_eq!([back_x[i], back_y[i]], [back[2 * i], back[2 * i + 1]]);
                    let fits = x[i].abs() < 32_767.0;
                    assert!(!fits || (f64::from(back_x[i]) - x[i]).abs() < 1.0 / 64.0 + 0.01);
                }
                convert(&map, Target::Fixed(&mut whole, None)).unwrap();
                let nearest = |v: f64| {
                    if v.is_finite() { v.round_ties_even().clamp(-32_768.0, 32_767.0) } else { -32_768.0 }
                };
                assert!((0..n).all(|i| f64::from(whole[2 * i + 1])
                    == nearest(if exact { y[i] } else { f64::from(y[i] as f32) })));
            }
        }
        let mut whole = [0; 4];
        assert!(
            convert(&Map::Single(&[0.0; 2], &[0.0; 2]), Target::Fixed(&mut whole, Some(&mut [0]))).is_err()
        );
        assert!(convert(&Map::Single(&[0.0], &[0.0]), Target::Fixed(&mut whole, None)).is_err());
        assert!(convert(&Map::Matrix(&[0.0; 9]), Target::Fixed(&mut whole, None)).is_err());
    }
}
