//! Panoramas.

use super::convert::{ImageArg, image_array, work_reporting};
use super::warp::Warping;
use crate::error::{Error, Result};
use crate::mapping::{FisheyeModel, Layout};
use crate::warp::panorama::{Form, convert};
use glam::DMat3;
use pyo3::prelude::*;

/// A form from its name, layout of a cube, model of a fisheye and angle in degrees.
type Words = (String, String, String, Option<f64>);

fn form(argument: &'static str, (name, layout, model, fov): &Words) -> Result<Form> {
    let angle = |default: f64| fov.unwrap_or(default).to_radians();
    let form = match name.as_str() {
        "equirect" => Form::Equirect,
        "cube" => Form::Cube(Layout::parse("layout", layout)?),
        "perspective" => Form::Perspective(angle(90.0)),
        "fisheye" => Form::Fisheye(FisheyeModel::parse("model", model)?, angle(180.0)),
        "probe" => Form::LightProbe,
        "mirror_ball" => Form::MirrorBall,
        "stereographic" => Form::Stereographic(angle(270.0)),
        "dual_paraboloid" => Form::DualParaboloid,
        "octahedral" => Form::Octahedral,
        _ => {
            let expected = "\"equirect\", \"cube\", \"perspective\", \"fisheye\", \"probe\", \"mirror_ball\", \
                            \"stereographic\", \"dual_paraboloid\" or \"octahedral\"";
            return Err(Error::value(argument, format!("{name:?}"), expected));
        }
    };
    match (form, fov) {
        (Form::Perspective(_) | Form::Fisheye(..) | Form::Stereographic(_), _) | (_, None) => Ok(form),
        (_, Some(fov)) => Err(Error::value("fov", fov, format!("None for {argument}={name:?}"))),
    }
}

/// The converted picture.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "one for each argument of the Python function")]
fn panorama_convert<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    source: Words,
    target: Words,
    size: (usize, usize),
    rotation: [[f64; 3]; 3],
    warping: &Warping,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let image = ImageArg::new("image", image)?;
    let view = image.view()?;
    let (source, target) = (form("source", &source)?, form("target", &target)?);
    let rotation = DMat3::from_cols_array_2d(&rotation).transpose();
    let size = [size.0, size.1];
    let made = work_reporting(py, warping.threads, progress, || {
        convert(view, source, target, size, rotation, &warping.options)
    })?;
    image_array(py, made, image.is_flat)
}

/// Adds this topic to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(panorama_convert, module)?)
}
