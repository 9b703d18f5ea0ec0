//! Resampling by banded matrices, in bands of rows: Gaussian filters, resizing, and both at once.

use crate::error::{Error, Result};
use crate::kernel::Isa;
use crate::kernel::remap::{Real, Scaled};
use crate::par;

pub use crate::kernel::band::{Band, Resample};

/// Multiplications that are worth a thread.
const WORK: usize = 1 << 16;

/// Applies a [`Resample`] to its picture.
///
/// # Errors
/// [`Error::Value`] for sizes that do not fit; [`Error::Interrupted`].
///
/// ```
/// use multum::warp::band::{Band, Resample, resample};
/// use multum::warp::lerp::Edge;
/// // Means of two rows.
/// let down = Band::new(&[0, 2], &[0.5, 0.5, 0.5, 0.5], Edge::Clamp, 4)?;
/// let job = Resample { data: &[0.0, 2.0, 4.0, 8.0], channels: 1, down, across: None, width: 1, factor: 1.0, border: 0.0, limits: [0.0, 9.0] };
/// let mut out = [0.0; 2];
/// resample(&job, &mut out)?;
/// assert_eq!(out, [1.0, 6.0]);
/// # Ok::<(), multum::Error>(())
/// ```
pub fn resample<S: Scaled<f64>, O: Real>(job: &Resample<'_, S>, out: &mut [O]) -> Result<()> {
    job.check()?;
    let row = job.out_row();
    if out.len() != row * job.down.rows() {
        let expected = format!("{} rows of {row}", job.down.rows());
        return Err(Error::value("out", format!("{} elements", out.len()), expected));
    }
    if out.is_empty() {
        return Ok(());
    }
    let isa = Isa::current();
    let rows = (WORK / job.row_cost().max(1)).max(1);
    let bands = out.chunks_mut(rows * row);
    if bands.len() == 1 {
        bands.into_iter().for_each(|band| job.rows(isa, 0, band));
        return Ok(());
    }
    par::for_pixels(job.data.len() / job.channels, bands, |i, band| {
        job.rows(isa, i * rows, band);
        Ok(())
    })
}
