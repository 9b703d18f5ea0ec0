//! Pyramids.

use super::convert::{ImageArg, image_array, work};
use crate::encode::{Alpha, Encoding, Format};
use crate::pyramid::{Kind, Options, build_above};
use crate::wrap::Wrap;
use pyo3::prelude::*;

/// The levels of an image from 1 on.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "one for each keyword of the Python function")]
fn build_pyramid<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    kind: &str,
    encoding: &str,
    alpha: &str,
    wrap: (String, String),
    coverage: Option<f64>,
    levels: Option<usize>,
) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let image = ImageArg::new("image", image)?;
    let view = image.view()?;
    let (encoding, alpha) = (Encoding::parse("encoding", encoding)?, Alpha::parse("alpha", alpha)?);
    let options = Options {
        kind: Kind::parse("kind", kind)?,
        format: Format::new(encoding, alpha, view.channels())?,
        wrap: [Wrap::parse("wrap", &wrap.0)?, Wrap::parse("wrap", &wrap.1)?],
        coverage,
    };
    let made = work(py, None, || build_above(view, &options, levels))?;
    made.into_iter().map(|level| image_array(py, level, image.is_flat)).collect()
}

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(build_pyramid, module)?)
}
