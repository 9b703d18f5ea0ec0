//! The share of a footprint where a test of texels holds: percentage-closer filtering.
//!
//! Texels weigh as in [`super::exact`]: the answers, 0 or 1, are reconstructed bilinearly and averaged over the
//! footprint. There are no levels: answers cannot be averaged before they are asked.

use super::Query;
use super::rows::{Bounds, Scratch, Slabs, lifted, walk};
use std::cell::RefCell;

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

/// The share, 0 to 1, of the footprint whose texels (i, j) pass. Place and footprint are finite; the footprint's texels
/// are all asked.
pub(crate) fn passing(query: &Query, mut test: impl FnMut(i64, i64) -> bool) -> f32 {
    let endless = Bounds { first: f64::NEG_INFINITY, last: f64::INFINITY };
    let slabs = Slabs::parallelogram(lifted(query.jacobian_tx));
    let (mut passed, mut total) = (0.0, 0.0);
    SCRATCH.with_borrow_mut(|scratch| {
        walk([query.s - 0.5, query.t - 0.5], &slabs, [endless; 2], scratch, |row| {
            for (i, &weight) in (row.first..).zip(row.weights) {
                total += weight;
                if weight > 0.0 && test(i, row.row) {
                    passed += weight;
                }
            }
        });
    });
    if passed == total { 1.0 } else { (passed / total).clamp(0.0, 1.0) as f32 }
}
