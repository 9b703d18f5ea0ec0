//! The reference: what every filter is judged against, in f64, slow and meant to be read.
//!
//! The true colour of a pixel is the integral of the *reconstructed* texture over the pixel's preimage,
//! weighted by the pixel filter:
//!
//! ```text
//! value = ∫∫ reconstruction(map(x + s, y + t)) weight(s, t) ds dt,     ∫∫ weight ds dt = 1
//! ```
//!
//! where `map` takes the output to the texture, `reconstruction` is bilinear unless said otherwise and
//! `weight` is the box over the pixel's square unless said otherwise. The integral is taken on the output: a
//! perspective weights what lies near more than what lies far, and a footprint without area needs no special
//! case.
//!
//! The pixel's square is cut along the edges of the reconstruction's cells, pulled back to the output, where
//! affine and perspective maps leave them straight. On every piece the reconstruction is one polynomial, so
//! Gauss-Legendre rules of its degree are exact. `docs/oracle.md` tells what is exact, what is estimated and
//! what it costs.
//!
//! This module shares no code with the library: wrapping, decoding, kernels, cutting and threads are
//! written a second time, from the definitions.

mod axis;
mod crew;
mod curved;
mod decode;
mod gauss;
mod integral;
mod options;
mod pixel;
mod polygon;
mod signal;
mod warp;

pub use crew::Crew;
pub use curved::Curve;
pub use options::{Alpha, Encoding, PixelFilter, Reconstruction, Wrap};
pub use pixel::Pixel;
pub use signal::{Estimate, Options, Signal};
pub use warp::Field;
