//! The examples run.

#[path = "../examples/sample_texture.rs"]
mod sample_texture;
#[path = "../examples/warp_image.rs"]
mod warp_image;

#[test]
fn sample_texture_runs() {
    sample_texture::main().expect("the example finds nothing to complain about");
}

#[test]
fn warp_image_runs() {
    warp_image::main().expect("the example finds nothing to complain about");
}
