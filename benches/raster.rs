//! Time of the rasteriser on one thread, on a sphere of about 100,000 triangles and, where the real models are
//! found (environment variable `MULTUM_DATA`), on FlightHelmet. Run: `cargo bench --bench raster`.

use multum::par::with_threads;
use multum::raster::{Attributes, Cull, Geometry, Options, rasterize};
use std::time::Instant;

/// Best of some runs, in milliseconds.
fn best<R>(mut work: impl FnMut() -> R) -> f64 {
    let run = |_| {
        let start = Instant::now();
        std::hint::black_box(work());
        start.elapsed().as_secs_f64() * 1e3
    };
    (0..15).map(run).fold(f64::INFINITY, f64::min)
}

fn sphere(n: u32) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let mut points = Vec::new();
    let mut faces = Vec::new();
    for i in 0..=n {
        for j in 0..=2 * n {
            let (theta, phi) = (
                f64::from(i) / f64::from(n) * std::f64::consts::PI,
                f64::from(j) / f64::from(n) * std::f64::consts::PI,
            );
            points.push([theta.sin() * phi.sin(), theta.cos(), theta.sin() * phi.cos()]);
            if i < n && j < 2 * n {
                let (a, b) = (i * (2 * n + 1) + j, (i + 1) * (2 * n + 1) + j);
                faces.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
            }
        }
    }
    (points, faces)
}

fn report(name: &str, positions: Vec<[f64; 4]>, faces: Vec<[u32; 3]>) {
    let geometry = Geometry::new(positions, faces).expect("valid faces");
    let uv: Vec<f32> = (0..geometry.positions().len() * 2).map(|i| (i % 89) as f32 / 89.0).collect();
    for side in [512, 1024, 2048] {
        for (word, cull) in [("both sides", Cull::None), ("fronts", Cull::Back)] {
            let options = Options { cull, ..Options::default() };
            let draw = || rasterize(&geometry, (side, side), &options).expect("a good size");
            let fragments = draw();
            let covered = fragments.triangle().iter().filter(|&&t| t >= 0).count();
            let attributes = Attributes::Vertex { data: &uv, channels: 2 };
            let interpolate = || fragments.interpolate_with_derivatives(&geometry, attributes, 0.0);
            println!(
                "{name}, {} triangles, {side}x{side}, {word}: rasterize {:.2} ms, uv and derivatives of {covered} pixels {:.2} ms",
                geometry.faces().len(),
                best(draw),
                best(interpolate),
            );
        }
    }
}

fn main() {
    with_threads(Some(1), || {
        let (points, faces) = sphere(158);
        let positions =
            points.iter().map(|&[x, y, z]| [x * 2.4, y * 2.4, (2.8 - z) * 0.9, 3.0 - z]).collect();
        report("sphere", positions, faces);
        #[cfg(feature = "mesh")]
        if let Some(data) = std::env::var_os("MULTUM_DATA") {
            let path = std::path::Path::new(&data).join("gltf/FlightHelmet/FlightHelmet.gltf");
            match multum::mesh::Scene::open(path, multum::mesh::Normals::Auto) {
                Ok(scene) => {
                    let positions = scene.camera().project(&scene.mesh.positions, 1, 1);
                    report("FlightHelmet", positions, scene.mesh.faces);
                }
                Err(error) => println!("{error}"),
            }
        }
    });
}
