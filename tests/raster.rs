//! The rasteriser against rays, against counting, and against itself on other numbers of threads.

use multum::par;
use multum::raster::{Attributes, Cull, Fragments, Geometry, Options, rasterize};
use proptest::prelude::*;

/// A small generator with a fixed seed.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn range(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.unit()
    }

    fn point(&mut self, r: f64) -> [f64; 3] {
        std::array::from_fn(|_| self.range(-r, r))
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

const NEAR: f64 = 0.1;
const FAR: f64 = 50.0;

/// A pinhole at the origin that looks down -z: GL's frustum matrix with a 90 degree field of view.
fn project([x, y, z]: [f64; 3]) -> [f64; 4] {
    [x, y, (-z * (FAR + NEAR) - 2.0 * FAR * NEAR) / (FAR - NEAR), -z]
}

/// The ray through a place of the picture.
fn ray(x: f64, y: f64, [w, h]: [f64; 2]) -> [f64; 3] {
    [2.0 * x / w - 1.0, 1.0 - 2.0 * y / h, -1.0]
}

/// Distance along the ray and weights of corners 1 and 2, on the triangle's whole plane.
/// Möller and Trumbore, "Fast, minimum storage ray/triangle intersection", JGT 1997.
fn hit(d: [f64; 3], [a, b, c]: [[f64; 3]; 3]) -> Option<[f64; 3]> {
    let (e1, e2, s) = (minus(b, a), minus(c, a), [-a[0], -a[1], -a[2]]);
    let p = cross(d, e2);
    let det = dot(p, e1);
    if det == 0.0 {
        return None;
    }
    let q = cross(s, e1);
    Some([dot(q, e2) / det, dot(p, s) / det, dot(q, d) / det])
}

/// Distance in pixels of a place from each edge's line, positive inside, by the sign of `d . (v_j x v_k)`.
fn distances(x: f64, y: f64, size: [f64; 2], v: [[f64; 3]; 3]) -> [f64; 3] {
    let volume = dot(v[0], cross(v[1], v[2]));
    std::array::from_fn(|i| {
        let normal = cross(v[(i + 1) % 3], v[(i + 2) % 3]);
        let at = |x, y| dot(ray(x, y, size), normal);
        let slope = f64::hypot(at(x + 1.0, y) - at(x, y), at(x, y + 1.0) - at(x, y));
        at(x, y) / slope * volume.signum()
    })
}

/// Weights of a place of the picture, from -1 to 1 each way, by the lectures' system of two equations: with the place
/// moved to the origin, b1 (p1 - p0) + b2 (p2 - p0) = -p0.
fn solve([x, y]: [f64; 2], corners: [[f64; 4]; 3]) -> [f64; 3] {
    let [a, b, c] = corners.map(|[px, py, _, w]| [px - x * w, py - y * w]);
    let ([e, f], [g, h]) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
    let det = e * h - g * f;
    let (b1, b2) = ((g * a[1] - a[0] * h) / det, (a[0] * f - e * a[1]) / det);
    [1.0 - b1 - b2, b1, b2]
}

fn random_triangle(r: &mut Random, kind: usize) -> [[f64; 3]; 3] {
    let centre = [r.range(-3.0, 3.0), r.range(-3.0, 3.0), r.range(-8.0, -0.5)];
    let around = |r: &mut Random, size| {
        let p = r.point(size);
        [centre[0] + p[0], centre[1] + p[1], centre[2] + p[2]]
    };
    match kind {
        // Of any size, some behind the eye.
        0 => std::array::from_fn(|_| around(r, 4.0)),
        // Small.
        1 => std::array::from_fn(|_| around(r, 0.4)),
        // Slivers: the third corner next to the edge between the others.
        2 => {
            let (a, b) = (around(r, 4.0), around(r, 4.0));
            let (t, off) = (r.unit(), r.point(0.02));
            [a, b, std::array::from_fn(|k| a[k] + t * (b[k] - a[k]) + off[k])]
        }
        // A corner almost in the plane of the eye, where w is almost 0.
        _ => {
            let mut v = std::array::from_fn(|_| around(r, 3.0));
            v[r.unit() as usize * 2][2] = r.range(-1e-6, 1e-6);
            v
        }
    }
}

#[test]
fn coverage_depth_weights_and_derivatives_agree_with_rays() {
    let (w, h) = (24usize, 16usize);
    let size = [w as f64, h as f64];
    let mut r = Random(42);
    let (mut covered, mut borderline, mut checked) = (0, 0, 0);
    for round in 0..10_000 {
        let v = random_triangle(&mut r, round % 4);
        let uv: [[f64; 2]; 3] = std::array::from_fn(|_| [r.range(-2.0, 2.0), r.range(0.0, 1.0)]);
        let geometry = Geometry::new(v.map(project).to_vec(), vec![[0, 1, 2]]).unwrap();
        let fragments = rasterize(&geometry, (w, h), &Options::default()).unwrap();
        let attributes = Attributes::Vertex { data: uv.as_flattened(), channels: 2 };
        let (value, jacobian) =
            fragments.interpolate_with_derivatives(&geometry, attributes, f64::NAN).unwrap();
        let weights = fragments.barycentric(&geometry).unwrap();
        for p in 0..w * h {
            let (x, y) = ((p % w) as f64 + 0.5, (p / w) as f64 + 0.5);
            let shown = fragments.triangle()[p] == 0;
            covered += usize::from(shown);
            let distance = distances(x, y, size, v).into_iter().fold(f64::INFINITY, f64::min);
            let Some([t, b1, b2]) = hit(ray(x, y, size), v) else { continue };
            // Vertices move by at most half a unit of 1/256 pixel in x and in y.
            let near_an_edge = distance.abs() < 1.0 / 256.0;
            let near_a_plane = (t / NEAR - 1.0).abs() < 1e-3 || (t / FAR - 1.0).abs() < 1e-3;
            if near_an_edge || near_a_plane {
                borderline += 1;
                continue;
            }
            let visible = distance > 0.0 && t > NEAR && t < FAR;
            assert_eq!(shown, visible, "triangle {round} {v:?} at {x} {y}: distance {distance}, t {t}");
            if !shown {
                assert!(value[p * 2].is_nan() && fragments.depth()[p] == f32::INFINITY);
                continue;
            }
            let at = |x: f64, y: f64| -> Option<[f64; 3]> {
                let [t, b1, b2] = hit(ray(x, y, size), v)?;
                let mix = |c: usize| uv[0][c] + b1 * (uv[1][c] - uv[0][c]) + b2 * (uv[2][c] - uv[0][c]);
                Some([mix(0), mix(1), t])
            };
            // 1/t is linear over the picture; its relative slope bounds the curvature of everything else.
            let slope = |d: [f64; 2]| at(x + d[0], y + d[1]).map_or(1e9, |q| (t / q[2] - 1.0).abs());
            let bend = 1.0 + slope([1e-3, 0.0]).max(slope([0.0, 1e-3])) * 1e3;
            let step = 1e-4 / bend;
            // A triangle seen edge-on turns rounding of its corners into a shift of the hit.
            let n = cross(minus(v[1], v[0]), minus(v[2], v[0]));
            let d = ray(x, y, size);
            let facing = (dot(n, d) / (dot(n, n) * dot(d, d)).sqrt()).abs();
            if facing < 1e-3 {
                continue;
            }
            checked += 1;
            let b = [1.0 - b1 - b2, b1, b2];
            let solved = solve([2.0 * x / size[0] - 1.0, 1.0 - 2.0 * y / size[1]], v.map(project));
            for (i, expected) in b.into_iter().enumerate() {
                let got = f64::from(weights[p][i]);
                assert!((got - expected).abs() < 1e-6, "{b:?} {:?}", weights[p]);
                assert!((got - solved[i]).abs() < 1e-6, "{solved:?} {:?}", weights[p]);
            }
            let expected = at(x, y).unwrap();
            for c in 0..2 {
                assert!((value[p * 2 + c] - expected[c]).abs() < 1e-9 / facing);
                let difference = |dx: f64, dy: f64| {
                    let (a, b) = (at(x + dx, y + dy).unwrap(), at(x - dx, y - dy).unwrap());
                    (a[c] - b[c]) / (2.0 * (dx + dy))
                };
                let expected = [difference(step, 0.0), difference(0.0, step)];
                let scale = expected[0].abs().max(expected[1].abs()) + 1.0;
                for (got, expected) in jacobian[p * 2 + c].into_iter().zip(expected) {
                    assert!((got - expected).abs() < 1e-6 * scale * bend / facing, "{got} {expected}");
                }
            }
            // Depth comes from the snapped corners: it may be off by its slope over 1/256 pixel.
            let [_, _, z, w] = project(ray(x, y, size).map(|c| c * t));
            let depth_slope = 2.0 * FAR * NEAR / (FAR - NEAR) / t * (bend - 1.0);
            let error = (f64::from(fragments.depth()[p]) - z / w).abs();
            assert!(error < 2e-6 + depth_slope / 128.0, "depth off by {error}, slope {depth_slope}");
        }
    }
    assert!(covered > 100_000 && checked > 90_000, "{covered} covered, {checked} checked");
    assert!(borderline * 20 < covered, "{borderline} too close to call");
}

/// How many triangles, drawn one by one, cover each pixel (with peeled layers that must be empty).
fn count(positions: &[[f64; 4]], faces: &[[u32; 3]], size: (usize, usize)) -> Vec<u32> {
    let mut count = vec![0; size.0 * size.1];
    for face in faces {
        let geometry = Geometry::new(positions.to_vec(), vec![*face]).unwrap();
        let fragments = rasterize(&geometry, size, &Options::default()).unwrap();
        let behind = Options { behind: Some(&fragments), ..Options::default() };
        let second = rasterize(&geometry, size, &behind).unwrap();
        assert!(second.triangle().iter().all(|&t| t < 0), "a part of one triangle is drawn twice");
        for (n, &t) in count.iter_mut().zip(fragments.triangle()) {
            *n += u32::from(t >= 0);
        }
    }
    count
}

/// A grid of points over `[-r, r]²`, the inner ones moved a little, with alternating diagonals and windings.
fn grid(n: usize, r: f64, shake: f64, random: &mut Random) -> (Vec<[f64; 2]>, Vec<[u32; 3]>) {
    let mut points = Vec::new();
    for i in 0..=n {
        for j in 0..=n {
            let inner = |k: usize| if k == 0 || k == n { 0.0 } else { 1.0 };
            let place = |k: usize, s: f64| (2.0 * k as f64 / n as f64 - 1.0) * r + s * inner(k);
            points.push([place(j, random.range(-shake, shake)), place(i, random.range(-shake, shake))]);
        }
    }
    let at = |i: usize, j: usize| (i * (n + 1) + j) as u32;
    let mut faces = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            if (i + j) % 2 == 0 {
                faces.extend([[a, b, c], [a, d, c]]);
            } else {
                faces.extend([[b, c, d], [b, a, d]]);
            }
        }
    }
    (points, faces)
}

#[test]
fn fans_cover_each_pixel_once() {
    let mut random = Random(3);
    for round in 0..6 {
        // Centres on a pixel's centre, on a corner, and anywhere.
        let centre = [[1.0 / 32.0, 1.0 / 32.0], [0.0, 0.0], [random.range(-0.4, 0.4), 0.1]][round % 3];
        let n = 40 + round * 31;
        let mut positions = vec![[centre[0], centre[1], 0.0, 1.0]];
        for k in 0..n {
            let angle = (k as f64 + 0.4 * random.unit()) / n as f64 * std::f64::consts::TAU;
            let w = random.range(0.5, 2.0);
            positions.push([3.0 * angle.cos() * w, 3.0 * angle.sin() * w, 0.0, w]);
        }
        let faces: Vec<[u32; 3]> = (0..n as u32).map(|k| [0, 1 + k, 1 + (k + 1) % n as u32]).collect();
        assert!(count(&positions, &faces, (32, 32)).iter().all(|&n| n == 1));
    }
}

#[test]
fn fine_grids_cover_each_pixel_once() {
    let mut random = Random(4);
    // Points on pixel corners, on pixel centres (24 cells of 1.5 pixels) and off them.
    for (n, r, shake) in [(32, 1.0, 0.0), (24, 18.0 / 16.0, 0.0), (40, 1.1, 0.01)] {
        let (points, faces) = grid(n, r, shake, &mut random);
        let positions: Vec<_> = points.iter().map(|p| [p[0], p[1], 0.0, 1.0]).collect();
        assert!(count(&positions, &faces, (32, 32)).iter().all(|&n| n == 1), "grid of {n}");
    }
}

#[test]
fn projected_grids_cover_each_pixel_once_although_parts_lie_behind_the_eye() {
    let mut random = Random(5);
    for n in [9, 24] {
        let (points, faces) = grid(n, 30.0, 10.0 / n as f64, &mut random);
        // A ground plane one unit below an eye that looks down by 50 degrees: every ray meets it.
        let (s, c) = 50f64.to_radians().sin_cos();
        let positions: Vec<_> = points.iter().map(|&[x, z]| project([x, -c - z * s, z * c - s])).collect();
        assert!(positions.iter().any(|p| p[3] < 0.0), "some vertices are behind the eye");
        let counted = count(&positions, &faces, (32, 32));
        assert!(counted.iter().all(|&n| n == 1), "{counted:?}");
    }
}

#[test]
fn samples_of_a_split_square_add_up_to_one() {
    let mut random = Random(6);
    for samples in [4, 8, 16] {
        let (points, faces) = grid(6, 1.3, 0.1, &mut random);
        let positions: Vec<_> = points.iter().map(|p| [p[0], p[1], 0.0, 1.0]).collect();
        let mut sum = vec![0.0; 20 * 12];
        for face in &faces {
            let geometry = Geometry::new(positions.clone(), vec![*face]).unwrap();
            let options = Options { samples, ..Options::default() };
            let coverage = rasterize(&geometry, (20, 12), &options).unwrap().coverage();
            sum.iter_mut().zip(coverage).for_each(|(s, c)| *s += c);
        }
        assert!(sum.iter().all(|&s| s == 1.0), "{sum:?}");
    }
}

#[test]
fn coverage_of_a_half_plane_is_its_area() {
    // The half left of x = 5.25 pixels of 8.
    let x = 5.25 / 4.0 - 1.0;
    let corners =
        vec![[-9.0, -9.0, 0.0, 1.0], [x, -9.0, 0.0, 1.0], [x, 9.0, 0.0, 1.0], [-9.0, 9.0, 0.0, 1.0]];
    let geometry = Geometry::new(corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    for samples in [4, 8, 16] {
        let options = Options { samples, ..Options::default() };
        let fragments = rasterize(&geometry, (8, 1), &options).unwrap();
        assert_eq!(fragments.coverage(), [1.0, 1.0, 1.0, 1.0, 1.0, 0.25, 0.0, 0.0]);
        // Its centre is free, yet it shows the triangle that covers its samples.
        assert!(fragments.triangle()[5] >= 0 && fragments.triangle()[6] < 0);
    }
    let plain = rasterize(&geometry, (8, 1), &Options::default()).unwrap();
    assert_eq!(plain.coverage(), [1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
}

#[test]
fn layers_peel_from_front_to_back_and_lose_nothing() {
    let mut random = Random(8);
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    for k in 0..60u32 {
        for _ in 0..3 {
            let v = random.point(1.5);
            // Some coplanar layers, where only the face's index tells the order.
            let z = if k % 3 == 0 { 0.25 } else { v[2] / 2.0 };
            positions.push([v[0], v[1], z, 1.0]);
        }
        faces.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    let size = (40, 30);
    let expected = count(&positions, &faces, size);
    let geometry = Geometry::new(positions, faces).unwrap();
    let mut layers: Vec<Fragments> = vec![rasterize(&geometry, size, &Options::default()).unwrap()];
    while layers[layers.len() - 1].triangle().iter().any(|&t| t >= 0) {
        let options = Options { behind: layers.last(), ..Options::default() };
        let next = rasterize(&geometry, size, &options).unwrap();
        layers.push(next);
    }
    for (p, &expected) in expected.iter().enumerate() {
        let seen: Vec<_> =
            layers.iter().map(|l| (l.depth()[p], l.triangle()[p])).filter(|(_, t)| *t >= 0).collect();
        assert_eq!(seen.len() as u32, expected);
        assert!(seen.windows(2).all(|w| w[0] < w[1]), "{seen:?}");
    }
}

#[test]
fn one_hot_attributes_are_the_weights_in_the_order_of_the_corners() {
    let corners = vec![[-1.0, -1.0, 0.0, 1.0], [3.0, -1.0, 0.0, 2.0], [-1.0, 1.0, 0.0, 1.0]];
    let geometry = Geometry::new(corners, vec![[2, 0, 1]]).unwrap();
    let fragments = rasterize(&geometry, (16, 16), &Options::default()).unwrap();
    let one_hot = [1.0f32, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    let by_vertex = Attributes::Vertex { data: &one_hot, channels: 3 };
    let by_corner = Attributes::Corner { data: &one_hot, channels: 3 };
    let vertex = fragments.interpolate(&geometry, by_vertex, 0.0).unwrap();
    let corner = fragments.interpolate(&geometry, by_corner, 0.0).unwrap();
    let weights = fragments.barycentric(&geometry).unwrap();
    for (p, b) in weights.iter().enumerate() {
        let close = |a: &[f32], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
        assert!(close(&corner[p * 3..][..3], *b));
        assert!(close(&vertex[p * 3..][..3], [b[1], b[2], b[0]]));
    }
}

fn soup(n: usize, random: &mut Random) -> Geometry {
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    for k in 0..n as u32 {
        let centre = [random.range(-5.0, 5.0), random.range(-5.0, 5.0), random.range(-9.0, 1.0)];
        let size = if k % 50 == 0 { 5.0 } else { 0.3 };
        for _ in 0..3 {
            let p = random.point(size);
            positions.push(project([centre[0] + p[0], centre[1] + p[1], centre[2] + p[2]]));
        }
        faces.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    Geometry::new(positions, faces).unwrap()
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    // More faces than one batch.
    let geometry = soup(70_000, &mut Random(9));
    let data: Vec<f32> = (0..geometry.positions().len()).map(|i| (i % 97) as f32).collect();
    let options = Options { samples: 8, cull: Cull::Back, ..Options::default() };
    let run = |threads| {
        par::with_threads(Some(threads), || {
            let fragments = rasterize(&geometry, (301, 203), &options).unwrap();
            let attributes = Attributes::Vertex { data: &data, channels: 1 };
            let values = fragments.interpolate_with_derivatives(&geometry, attributes, 0.0).unwrap();
            (fragments, values)
        })
    };
    let one = run(1);
    assert!(one.0.triangle().iter().filter(|&&t| t >= 0).count() > 10_000);
    for threads in [2, 7, 0] {
        assert!(run(threads) == one, "{threads} threads");
    }
}

#[test]
fn culling_keeps_the_sides_that_it_says() {
    // Face 0 runs counter-clockwise, face 1 clockwise.
    let corners = vec![
        [-1.0, -1.0, 0.0, 1.0],
        [0.0, -1.0, 0.0, 1.0],
        [-1.0, 1.0, 0.0, 1.0],
        [0.5, -1.0, 0.0, 1.0],
        [0.5, 1.0, 0.0, 1.0],
        [1.0, -1.0, 0.0, 1.0],
    ];
    let geometry = Geometry::new(corners, vec![[0, 1, 2], [3, 4, 5]]).unwrap();
    let ids = |cull| {
        let options = Options { cull, ..Options::default() };
        let mut ids = rasterize(&geometry, (16, 16), &options).unwrap().triangle().to_vec();
        ids.sort_unstable();
        ids.dedup();
        ids
    };
    assert_eq!(ids(Cull::None), [-1, 0, 1]);
    assert_eq!(ids(Cull::Back), [-1, 0]);
    assert_eq!(ids(Cull::Front), [-1, 1]);
    assert_eq!(ids(Cull::BackOf(&[true, true])), [-1, 0]);
    assert_eq!(ids(Cull::BackOf(&[true, false])), [-1, 0, 1]);
}

#[test]
fn degenerate_and_wrong_input_is_skipped_or_refused() {
    let corners = |z: f64| vec![[-1.0, -1.0, z, 1.0], [1.0, -1.0, z, 1.0], [0.0, 1.0, z, 1.0]];
    let draw = |positions: Vec<[f64; 4]>, faces: Vec<[u32; 3]>| {
        rasterize(&Geometry::new(positions, faces).unwrap(), (8, 8), &Options::default()).unwrap()
    };
    let empty = |f: Fragments| f.triangle().iter().all(|&t| t == -1);
    assert!(empty(draw(Vec::new(), Vec::new())));
    assert!(empty(draw(corners(f64::NAN), vec![[0, 1, 2]])));
    assert!(empty(draw(corners(f64::INFINITY), vec![[0, 1, 2]])));
    assert!(empty(draw(corners(0.0), vec![[0, 0, 2], [1, 1, 1]])));
    assert!(!empty(draw(corners(0.0), vec![[0, 1, 2]])));
    let all_zero = vec![[0.0; 4]; 3];
    assert!(empty(draw(all_zero, vec![[0, 1, 2]])));
    assert!(Geometry::new(corners(0.0), vec![[0, 1, 3]]).is_err());
    let geometry = Geometry::new(corners(0.0), vec![[0, 1, 2]]).unwrap();
    for size in [(0, 4), (4, 0), (1_000_000, 1_000_000), (usize::MAX, usize::MAX)] {
        assert!(rasterize(&geometry, size, &Options::default()).is_err());
    }
    assert!(rasterize(&geometry, (8, 8), &Options { samples: 5, ..Options::default() }).is_err());
    let mask = [true, false];
    assert!(
        rasterize(&geometry, (8, 8), &Options { cull: Cull::BackOf(&mask), ..Options::default() }).is_err()
    );
    let other = rasterize(&geometry, (4, 4), &Options::default()).unwrap();
    assert!(rasterize(&geometry, (8, 8), &Options { behind: Some(&other), ..Options::default() }).is_err());
    let short = Attributes::Vertex { data: &[0.0f32; 5], channels: 2 };
    assert!(other.interpolate(&geometry, short, 0.0).is_err());
    let none = Geometry::new(Vec::new(), Vec::new()).unwrap();
    assert!(other.barycentric(&none).is_err());
}

fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        -2.0..2.0f64,
        any::<f32>().prop_map(f64::from),
        any::<f64>(),
        prop_oneof![
            Just(0.0),
            Just(-0.0),
            Just(f64::NAN),
            Just(1e38),
            Just(-1e38),
            Just(1e-300),
            Just(1.0),
            Just(-1.0)
        ],
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Any bits as vertices: no panic, and what is shown is defined: weights in the simplex, depth in range.
    #[test]
    fn any_vertices_give_defined_fragments(
        numbers in proptest::collection::vec(any_number(), 36),
        samples in prop_oneof![Just(1usize), Just(4)],
    ) {
        let positions: Vec<[f64; 4]> = numbers.chunks_exact(4).map(|c| [c[0], c[1], c[2], c[3]]).collect();
        let geometry = Geometry::new(positions, vec![[0, 1, 2], [3, 4, 5], [6, 7, 8], [0, 4, 8]]).unwrap();
        let fragments = rasterize(&geometry, (13, 9), &Options { samples, ..Options::default() }).unwrap();
        let weights = fragments.barycentric(&geometry).unwrap();
        for (p, b) in weights.iter().enumerate() {
            if fragments.triangle()[p] >= 0 {
                prop_assert!((-1.0..=1.0).contains(&fragments.depth()[p]));
                prop_assert!(b.iter().all(|b| (0.0..=1.0).contains(b)), "{:?}", b);
                prop_assert!((b.iter().sum::<f32>() - 1.0).abs() < 1e-6);
            } else {
                prop_assert_eq!((b, fragments.depth()[p]), (&[0.0; 3], f32::INFINITY));
            }
        }
    }
}
