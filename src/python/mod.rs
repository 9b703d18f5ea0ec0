//! The compiled half of the Python module: thin, one file a topic, no arithmetic.

use pyo3::prelude::*;

mod bake;
pub mod convert;
mod cv2;
mod errors;
mod files;
mod mapping;
mod mesh;
mod panorama;
mod pyramid;
mod raster;
mod reference;
mod remap;
mod render;
mod resample;
mod sat;
mod sphere;
mod texture;
mod threads;
mod torch;
mod warp;

/// Texture sampling and filtering on the CPU (the compiled part).
#[pymodule]
fn _multum(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    cv2::register(module)?;
    bake::register(module)?;
    files::register(module)?;
    mapping::register(module)?;
    mesh::register(module)?;
    panorama::register(module)?;
    pyramid::register(module)?;
    raster::register(module)?;
    sat::register(module)?;
    sphere::register(module)?;
    remap::register(module)?;
    render::register(module)?;
    resample::register(module)?;
    texture::register(module)?;
    threads::register(module)?;
    torch::register(module)?;
    warp::register(module)?;
    reference::register(module)?;
    Ok(())
}
