//! Baked maps against closed forms and brute force.

#![cfg(feature = "bake")]

use multum::bake::{Baked, Map, Method, Options, Paint, Space, bake, closest, flag, intersect};
use multum::encode::Encoding;
use multum::mesh::{Mesh, Normals};
use multum::{DType, Extent, Filter, Image, Sampler, Texture, TextureOptions, par};

fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1u64 << 53) as f64
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    a.map(|c| c / dot(a, a).sqrt())
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let c = cross(a, b);
    dot(c, c).sqrt().atan2(dot(a, b))
}

/// A grid of `columns` x `rows` cells, each vertex by a function of its place in [0, 1]^2 (v down), cells cut
/// from their lower left to their upper right corner.
fn grid(columns: usize, rows: usize, place: impl Fn(f64, f64) -> [f64; 3]) -> Mesh {
    let mut lists = Mesh { uv: vec![Vec::new()], ..Mesh::default() };
    for j in 0..=rows {
        for i in 0..=columns {
            let uv = [i as f64 / columns as f64, j as f64 / rows as f64];
            lists.positions.push(place(uv[0], uv[1]).map(|c| c as f32));
            lists.uv[0].push(uv.map(|c| c as f32));
        }
    }
    let at = |i: usize, j: usize| (j * (columns + 1) + i) as u32;
    for j in 0..rows {
        for i in 0..columns {
            lists.faces.push([at(i, j + 1), at(i + 1, j), at(i, j)]);
            lists.faces.push([at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    lists
}

fn mesh(lists: Mesh) -> Mesh {
    lists.completed(Normals::Smooth).expect("a mesh")
}

/// A square in z = `z` over [0, 1]^2 with the picture upright.
fn square(z: f64) -> Mesh {
    mesh(grid(1, 1, |u, v| [u, 1.0 - v, z]))
}

fn run(high: &Mesh, low: &Mesh, map: &Map<'_>, size: usize, options: &Options) -> Baked {
    bake(high, low, map, [size, size], options).expect("a map")
}

#[test]
fn rays_meet_the_faces_that_a_search_finds() {
    let mut state = 7;
    let mut point = || [0, 1, 2].map(|_| random(&mut state) * 2.0 - 1.0);
    let positions: Vec<[f32; 3]> = (0..600).map(|_| point().map(|c| c as f32)).collect();
    let faces: Vec<[u32; 3]> = (0..200).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    // Origins inside, near and far away; the far ones test that single precision boxes are enough.
    let rays: Vec<_> = (0..600)
        .map(|i| {
            let (o, d) = (point(), point());
            let away = [0.0, 3.0, 1e6][i % 3];
            ([0, 1, 2].map(|k| o[k] - away * d[k]), d)
        })
        .collect();
    let hits = intersect(&positions, &faces, &rays).expect("hits");
    let mut met = 0;
    for ((origin, d), hit) in rays.iter().zip(hits) {
        // Moller and Trumbore, in double precision, over all faces.
        let mut best = (-1, f64::INFINITY);
        for (i, face) in faces.iter().enumerate() {
            let [a, b, c] = face.map(|v| positions[v as usize].map(f64::from));
            let (e1, e2, s) = (minus(b, a), minus(c, a), minus(*origin, a));
            let p = cross(*d, e2);
            let det = dot(e1, p);
            let q = cross(s, e1);
            let (u, v, t) = (dot(s, p) / det, dot(*d, q) / det, dot(e2, q) / det);
            if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0 && t < best.1 {
                best = (i as i32, t);
            }
        }
        assert_eq!(hit.face, best.0);
        met += usize::from(hit.face >= 0);
        // Vertices are rounded to 2^-24 of the box; a slanted face turns that into more along the ray.
        assert!(hit.face < 0 || (hit.distance - best.1).abs() < 1e-4, "{hit:?} {best:?}");
    }
    assert!(met > 200, "{met}");
}

#[test]
fn the_closest_place_is_the_one_a_search_finds() {
    let mut state = 3;
    let mut point = |size: f64| [0, 1, 2].map(|_| size * (random(&mut state) * 2.0 - 1.0));
    let positions: Vec<[f32; 3]> = (0..450).map(|_| point(1.0).map(|c| c as f32)).collect();
    let faces: Vec<[u32; 3]> = (0..150).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let points: Vec<_> = (0..300).map(|i| point([0.5, 2.0, 100.0][i % 3])).collect();
    let found = closest(&positions, &faces, &points).expect("places");
    for (p, found) in points.iter().zip(found) {
        let length = |a: [f64; 3]| dot(a, a).sqrt();
        let mut best = f64::INFINITY;
        for face in &faces {
            let corners = face.map(|v| positions[v as usize].map(f64::from));
            // The foot on the plane where it is inside, else the nearest of three segments.
            let normal = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]));
            let inside = (0..3).all(|k| {
                let edge = minus(corners[(k + 1) % 3], corners[k]);
                dot(cross(edge, minus(*p, corners[k])), normal) >= 0.0
            });
            if inside {
                best = best.min((dot(minus(*p, corners[0]), normal) / length(normal)).abs());
            }
            for k in 0..3 {
                let (edge, from) = (minus(corners[(k + 1) % 3], corners[k]), minus(*p, corners[k]));
                let t = (dot(from, edge) / dot(edge, edge)).clamp(0.0, 1.0);
                best = best.min(length([0, 1, 2].map(|i| from[i] - t * edge[i])));
            }
        }
        // Vertices are rounded to 2^-24 of the box.
        assert!((found.distance - best).abs() < 3e-7, "{found:?} {best}");
        let corners = faces[found.face as usize].map(|v| positions[v as usize].map(f64::from));
        let place = [0, 1, 2].map(|i| (0..3).map(|c| found.barycentric[c] * corners[c][i]).sum::<f64>());
        assert!((length(minus(place, *p)) - best).abs() < 3e-7);
    }
}

const BUMP: f64 = 0.02;

/// A bumpy sphere over 120 degrees of longitude and latitude: place and normal.
fn bumpy(u: f64, v: f64) -> ([f64; 3], [f64; 3]) {
    let span = 120f64.to_radians();
    let (lon, lat) = ((u - 0.5) * span, (0.5 - v) * span);
    let (waves_lon, waves_lat) = (6.0, 4.0);
    let r = 1.0 + BUMP * (waves_lon * lon).sin() * (waves_lat * lat).sin();
    let r_lon = BUMP * waves_lon * (waves_lon * lon).cos() * (waves_lat * lat).sin();
    let r_lat = BUMP * waves_lat * (waves_lon * lon).sin() * (waves_lat * lat).cos();
    let out = [lon.sin() * lat.cos(), lat.sin(), lon.cos() * lat.cos()];
    let east = [lon.cos(), 0.0, -lon.sin()];
    let north = [-lon.sin() * lat.sin(), lat.cos(), -lon.cos() * lat.sin()];
    // The gradient of the surface |p| - r(direction): out - r_lon / (r cos lat) east - r_lat / r north.
    let normal = [0, 1, 2].map(|k| out[k] - r_lon / (r * lat.cos()) * east[k] - r_lat / r * north[k]);
    (out.map(|c| c * r), unit(normal))
}

/// Where the direction of a point lies on the map of [`bumpy`].
fn map_place(p: [f64; 3]) -> (f64, f64) {
    let span = 120f64.to_radians();
    (p[0].atan2(p[2]) / span + 0.5, 0.5 - (p[1] / dot(p, p).sqrt()).asin() / span)
}

const LOW: usize = 10;

/// A coarse smooth sphere under the bumps.
fn coarse(u: f64, v: f64) -> [f64; 3] {
    let span = 120f64.to_radians();
    let (lon, lat) = ((u - 0.5) * span, (0.5 - v) * span);
    [lon.sin() * lat.cos(), lat.sin(), lon.cos() * lat.cos()]
}

/// The place on the flat faces of the coarse sphere at (u, v).
fn coarse_point(u: f64, v: f64) -> [f64; 3] {
    let n = LOW as f64;
    let (i, j) = ((u * n).floor().min(n - 1.0), (v * n).floor().min(n - 1.0));
    let (s, t) = (u * n - i, v * n - j);
    let corner = |a: f64, b: f64| coarse((i + a) / n, (j + b) / n).map(|c| f64::from(c as f32));
    let [tl, tr, bl, br] = [corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0), corner(1.0, 1.0)];
    [0, 1, 2].map(|k| {
        if s + t <= 1.0 {
            tl[k] + s * (tr[k] - tl[k]) + t * (bl[k] - tl[k])
        } else {
            br[k] + (1.0 - s) * (bl[k] - br[k]) + (1.0 - t) * (tr[k] - br[k])
        }
    })
}

fn bumpy_mesh(cells: usize) -> Mesh {
    let mut lists = grid(cells, cells, |u, v| bumpy(u, v).0);
    let n = cells as f64;
    let normal =
        |k: usize| bumpy((k % (cells + 1)) as f64 / n, (k / (cells + 1)) as f64 / n).1.map(|c| c as f32);
    lists.normals = (0..lists.positions.len()).map(normal).collect();
    mesh(lists)
}

/// Root mean square angle between baked normals and the closed form at the texels' centres. The cage is the low
/// mesh blown up from the centre, so lines run along the radius and meet the bumps at the direction of the
/// place itself. Left out: texels at the map's rim, and those that an edge of the coarse faces crosses, where
/// the map from texels to the sphere has a kink and the mean is of first order.
fn bump_error(high: &Mesh, size: usize, samples: usize) -> f64 {
    let low = mesh(grid(LOW, LOW, coarse));
    let cage = Some(low.positions.iter().map(|p| p.map(|c| 2.0 * c)).collect());
    let options = Options { samples, cage, distance: Some(0.2), ..Options::default() };
    let baked = run(high, &low, &Map::Normal(Space::Object), size, &options);
    let (mut sum, mut count) = (0.0, 0);
    for (k, value) in baked.values().chunks(3).enumerate() {
        let [u, v] = [k % size, k / size].map(|i| (i as f64 + 0.5) / size as f64);
        let kink = ((u + v) * LOW as f64).rem_euclid(1.0);
        let clear = kink.min(1.0 - kink) > LOW as f64 / size as f64 * 0.999;
        if clear && [u, v].iter().all(|c| (0.1..0.9).contains(c)) {
            let (a, b) = map_place(coarse_point(u, v));
            let n = [value[0], value[1], value[2]].map(f64::from);
            sum += angle(n, bumpy(a, b).1).powi(2);
            count += 1;
        }
    }
    (sum / f64::from(count)).sqrt()
}

#[test]
fn normals_of_a_bumpy_sphere_meet_the_closed_form_with_second_order() {
    // At one sample a texel nothing is averaged: the error is the interpolation of the high mesh's normals,
    // which falls with the square of its cells.
    // (Cells that do not fit the texels, or all samples would lie at the same place of a cell.)
    let errors: Vec<f64> = [37, 74, 148].iter().map(|&n| bump_error(&bumpy_mesh(n), 80, 1)).collect();
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((1.8..2.2).contains(&order), "{errors:?}");
    }
    // With many samples the mean over the texel differs from the value at its centre by the second derivative
    // times a twenty-fourth of the texel squared.
    let high = bumpy_mesh(320);
    let errors: Vec<f64> = [20, 40, 80].iter().map(|&n| bump_error(&high, n, 4)).collect();
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((1.8..2.2).contains(&order), "{errors:?}");
    }
}

#[test]
fn bytes_do_not_depend_on_threads_or_on_the_hook() {
    let (high, low) = (bumpy_mesh(60), mesh(grid(LOW, LOW, coarse)));
    for map in [Map::Normal(Space::Tangent), Map::Height, Map::Occlusion { rays: 20, radius: 0.3 }] {
        let bytes = |threads| {
            let options = Options::default();
            let baked = par::with_threads(Some(threads), || run(&high, &low, &map, 50, &options));
            (baked.values().iter().map(|x| x.to_bits()).collect::<Vec<_>>(), baked.flags().to_vec())
        };
        let one = bytes(1);
        assert!(one == bytes(2) && one == bytes(7));
    }
    let stopped = par::with_interrupt(
        |_| true,
        || bake(&high, &low, &Map::Height, [400, 400], &Options::default()).map(|_| ()),
    );
    assert!(matches!(stopped, Err(multum::Error::Interrupted)));
}

/// Two squares side by side in space, the right one mirrored on the map, with normals that lean outwards.
fn mirrored_pair() -> Mesh {
    let mut split = Mesh { uv: vec![Vec::new()], ..Mesh::default() };
    for (side, x) in [(0, 0.0f32), (1, 1.0)] {
        let first = split.positions.len() as u32;
        for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0f32)] {
            split.positions.push([x + dx, dy, 0.0]);
            let u = if side == 0 { 0.05 + 0.4 * dx } else { 0.95 - 0.4 * dx };
            split.uv[0].push([u, 0.9 - 0.8 * dy]);
            let lean = 0.3 * (x + dx - 1.0);
            split.normals.push(unit([lean, 0.2 * (dy - 0.5), 1.0].map(f64::from)).map(|c| c as f32));
        }
        split.faces.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    mesh(split)
}

#[test]
fn shading_with_the_baked_map_gives_back_the_normals_also_where_it_is_mirrored() {
    let low = mirrored_pair();
    let mut high = low.clone();
    let true_normal = unit([0.35, -0.25, 0.8]);
    high.normals.iter_mut().for_each(|n| *n = true_normal.map(|c| c as f32));
    let options = Options { samples: 1, ..Options::default() };
    let size = 64;
    let baked = run(&high, &low, &Map::Normal(Space::Tangent), size, &options);
    assert_eq!(baked.report().mirrored_faces, 2);
    let codes = baked.image(DType::U8, Encoding::Normal, None).expect("codes");
    let multum::Pixels::U8(codes) = codes.pixels() else { panic!("not bytes") };
    let mut checked = 0;
    for (f, face) in low.faces.iter().enumerate() {
        let corner = |c: usize| face[c] as usize;
        let tx = |c: usize| low.uv[0][corner(c)].map(|x| f64::from(x) * size as f64);
        let (a, b, c) = (tx(0), tx(1), tx(2));
        let det = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        for (k, code) in codes.chunks(3).enumerate() {
            let p = [(k % size) as f64 + 0.5, (k / size) as f64 + 0.5];
            let w1 = ((p[0] - a[0]) * (c[1] - a[1]) - (p[1] - a[1]) * (c[0] - a[0])) / det;
            let w2 = ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])) / det;
            let w = [1.0 - w1 - w2, w1, w2];
            if w.iter().any(|&w| w < 1e-3) {
                continue;
            }
            // What a shader does: interpolated normal and tangent as they are, the bitangent from the two.
            let mix = |read: &dyn Fn(usize) -> [f32; 3]| {
                [0, 1, 2].map(|i| (0..3).map(|c| w[c] * f64::from(read(corner(c))[i])).sum::<f64>())
            };
            let n = mix(&|v| low.normals[v]);
            let t = mix(&|v| [low.tangents[v][0], low.tangents[v][1], low.tangents[v][2]]);
            let sign = f64::from(low.tangents[corner(0)][3]);
            let bi = cross(n, t).map(|c| sign * c);
            let m = [0, 1, 2].map(|i| (f64::from(code[i]) - 128.0) / 127.0);
            let shaded = unit([0, 1, 2].map(|i| m[0] * t[i] + m[1] * bi[i] + m[2] * n[i]));
            // Half a code in each of three numbers.
            assert!(angle(shaded, true_normal) < 0.5 * 3f64.sqrt() / 127.0 * 1.3, "face {f} texel {k}");
            checked += 1;
        }
    }
    assert!(checked > 1500, "{checked}");
}

#[test]
fn misses_choices_and_shared_texels_are_counted_and_marked() {
    let low = square(0.0);
    // Left half: one square below. Middle: two above each other. Right: nothing.
    let strip = |x0: f64, x1: f64, z: f64| grid(1, 1, move |u, v| [x0 + (x1 - x0) * u, 1.0 - v, z]);
    let mut lists = Mesh::default();
    for (x0, x1, z) in [(0.0, 0.75, -0.1), (0.25, 0.75, 0.2)] {
        let part = strip(x0, x1, z);
        let first = lists.positions.len() as u32;
        lists.positions.extend(part.positions);
        lists.faces.extend(part.faces.iter().map(|f| f.map(|v| v + first)));
    }
    let high = mesh(lists);
    let options = Options { distance: Some(0.5), padding: Some(0), ..Options::default() };
    for (method, middle) in [(Method::Outermost, 0.2f32), (Method::Nearest, -0.1), (Method::Closest, -0.1)] {
        let options = Options { method, ..options.clone() };
        let baked = run(&high, &low, &Map::Height, 16, &options);
        let at = |x: usize| baked.values()[5 * 16 + x];
        assert!((at(1) + 0.1).abs() < 1e-6 && (at(8) - middle).abs() < 1e-6, "{method:?}");
        let report = baked.report();
        if method == Method::Closest {
            // The closest point of the edge is within reach of every texel.
            assert_eq!((report.covered, report.missed, report.ambiguous), (256, 0, 0));
            continue;
        }
        assert_eq!((report.covered, report.missed, report.ambiguous), (192, 64, 128), "{method:?}");
        assert_eq!(baked.flags()[5 * 16 + 8], flag::COVERED | flag::AMBIGUOUS);
        assert_eq!(baked.flags()[5 * 16 + 14], flag::MISSED);
        assert!(report.warnings().iter().any(|w| w.starts_with("64 texels of the low mesh found nothing")));
        // Filled from the neighbour: the nearest column that has an answer.
        let filled = run(&high, &low, &Map::Height, 16, &Options { padding: None, ..options });
        assert_eq!(filled.values()[5 * 16 + 15], filled.values()[5 * 16 + 11]);
    }
    // The same square twice: all texels are shared; and its edges are each used twice the same way.
    let mut twice = square(0.0);
    twice.faces.extend(twice.faces.clone());
    twice.face_material.extend(twice.face_material.clone());
    let baked = run(&square(0.1), &twice, &Map::Height, 8, &Options::default());
    assert_eq!((baked.report().overlapping, baked.report().covered), (64, 64));
    assert_eq!(baked.report().non_manifold_edges, [0, 5]);
    assert_eq!(baked.report().warnings().len(), 2);
    // Faces that look the other way are not found.
    let mut back = square(0.1);
    back.faces.iter_mut().for_each(|f| f.swap(0, 1));
    assert_eq!(run(&back, &low, &Map::Height, 8, &Options::default()).report().missed, 64);
}

#[test]
fn heights_positions_and_curvature_meet_their_closed_forms() {
    let low = square(0.0);
    // A slanted plane z = 0.1 + 0.2 x: height is linear, so the mean over a texel is its value at the centre.
    let high =
        mesh(grid(1, 1, |u, v| [u * 1.5 - 0.25, (1.0 - v) * 1.5 - 0.25, 0.1 + 0.2 * (u * 1.5 - 0.25)]));
    let baked = run(&high, &low, &Map::Height, 10, &Options::default());
    let places = run(&high, &low, &Map::Position, 10, &Options::default());
    for k in 0..100 {
        let (x, y) = ((k % 10) as f32 / 10.0 + 0.05, 0.95 - (k / 10) as f32 / 10.0);
        let z = 0.1 + 0.2 * x;
        assert!((baked.values()[k] - z).abs() < 1e-6);
        let p = &places.values()[3 * k..][..3];
        assert!((p[0] - x).abs() < 1e-6 && (p[1] - y).abs() < 1e-6 && (p[2] - z).abs() < 1e-6);
    }
    assert_eq!(baked.report().missed, 0);
    let codes = baked.image(DType::U16, Encoding::Linear, Some([0.1, 0.3])).expect("codes");
    let multum::Pixels::U16(codes) = codes.pixels() else { panic!("not 16 bits") };
    assert_eq!(codes[0], (0.05f64 * 65535.0).round() as u16);
    // Spheres: 1 / r, seen from outside positive, from inside negative.
    for r in [0.5, 4.0] {
        let high = mesh(grid(60, 60, |u, v| coarse(u, v).map(|c| r * c)));
        let low = mesh(grid(LOW, LOW, |u, v| coarse(u, v).map(|c| r * c)));
        let baked = run(&high, &low, &Map::Curvature, 24, &Options::default());
        for k in (0..24 * 24).filter(|k| (4..20).contains(&(k % 24)) && (4..20).contains(&(k / 24))) {
            // A chord of 2 degrees: the polygon's curvature differs by its square over 24 and less.
            assert!((f64::from(baked.values()[k]) * r - 1.0).abs() < 2e-3, "{}", baked.values()[k]);
        }
    }
}

#[test]
fn the_sky_beside_a_wall_is_what_the_view_factor_says() {
    // A long wall of height h at x = 0, the floor beside it. A point at distance d sees the share
    // (1 + d / sqrt(d^2 + h^2)) / 2 of the sky: Howell, "A catalog of radiation configuration factors", B-5.
    let (h, long) = (2.0, 400.0);
    let floor = grid(1, 1, |u, v| [4.0 * u, 0.5 - v, 0.0]);
    let mut lists = floor.clone();
    let first = lists.positions.len() as u32;
    let wall = grid(1, 1, |u, v| [0.0, (u - 0.5) * long, h * (1.0 - v)]);
    lists.positions.extend(wall.positions);
    lists.faces.extend(wall.faces.iter().map(|f| f.map(|v| v + first)));
    lists.uv.clear();
    let (high, low) = (mesh(lists), mesh(floor));
    let options = Options { samples: 2, distance: Some(0.01), ..Options::default() };
    let baked = bake(&high, &low, &Map::Occlusion { rays: 16384, radius: f64::INFINITY }, [8, 2], &options);
    let baked = baked.expect("a map");
    for k in 0..16 {
        // The mean over the texel's four sample points, at two distances.
        let sky: f64 = [0.25, 0.75]
            .iter()
            .map(|s| {
                let d = ((k % 8) as f64 + s) / 2.0;
                0.25 * (1.0 + d / (d * d + h * h).sqrt())
            })
            .sum();
        // 16384 points whose discrepancy falls nearly as one over their number.
        assert!((f64::from(baked.values()[k]) - sky).abs() < 2e-3, "{k}: {} {sky}", baked.values()[k]);
    }
    let near = Map::Occlusion { rays: 64, radius: 0.25 };
    let baked = bake(&high, &low, &near, [8, 2], &options).expect("a map");
    assert!(baked.values().iter().skip(1).take(7).all(|&sky| sky == 1.0));
}

#[test]
fn colours_are_averaged_over_texels_in_linear_light() {
    // A checkerboard of 256 x 256 black and white texels becomes even grey of half the light.
    let board: Vec<u8> = (0..256 * 256).map(|k| if (k % 256 + k / 256) % 2 == 0 { 255 } else { 0 }).collect();
    let image = Image::new(256, 256, 1, board).expect("an image");
    let options = TextureOptions { encoding: Encoding::Srgb, ..TextureOptions::default() };
    let texture = Texture::new(image.view(), options).expect("a texture");
    let paint = Paint {
        color: [1.0, 0.5, 0.25],
        texture: Some(&texture),
        uv_set: 0,
        transform: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    };
    let (high, low) = (square(0.1), square(0.0));
    let paints = [paint];
    let baked = run(&high, &low, &Map::Color(&paints), 16, &Options::default());
    for color in baked.values().chunks(3) {
        for (value, wanted) in color.iter().zip([0.5, 0.25, 0.125]) {
            assert!((value - wanted).abs() < 2e-3, "{color:?}");
        }
    }
    let codes = baked.image(DType::U8, Encoding::Srgb, None).expect("codes");
    // sRGB code of half the light.
    assert!(matches!(codes.pixels(), multum::Pixels::U8(codes) if codes[0] == 188));
    // A picture keeps its place: the same texture one to one.
    let ramp: Vec<u8> = (0..64).collect();
    let image = Image::new(8, 8, 1, ramp.clone()).expect("an image");
    let texture = Texture::new(image.view(), TextureOptions::default()).expect("a texture");
    let paints = [Paint { color: [1.0; 3], texture: Some(&texture), ..paint }];
    let options = Options { samples: 1, ..Options::default() };
    let baked = run(&high, &low, &Map::Color(&paints), 8, &options);
    let codes: Vec<u8> = baked.values().chunks(3).map(|c| (c[0] * 255.0).round() as u8).collect();
    assert_eq!(codes, ramp);
}

/// Two pieces of the coarse sphere as islands with background between and around them.
fn islands() -> Mesh {
    let half = LOW / 2;
    let mut split = Mesh { uv: vec![Vec::new()], ..Mesh::default() };
    for side in 0..2 {
        let first = split.positions.len() as u32;
        let part = grid(half, LOW, |u, v| coarse(0.5 * (u + side as f64), v));
        let place = |[u, v]: [f32; 2]| [0.07 + 0.38 * u + 0.48 * side as f32, 0.06 + 0.88 * v];
        split.positions.extend(part.positions);
        split.uv[0].extend(part.uv[0].iter().copied().map(place));
        split.faces.extend(part.faces.iter().map(|f| f.map(|v| v + first)));
    }
    mesh(split)
}

#[test]
fn a_seam_is_neither_darker_nor_lighter_on_any_level() {
    let low = islands();
    let mut high = bumpy_mesh(80);
    high.colors = vec![[0.75, 0.5, 0.25, 1.0]; high.positions.len()];
    let paint =
        Paint { color: [1.0; 3], texture: None, uv_set: 0, transform: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] };
    let size = 128;
    let paints = [paint];
    let sampler = Sampler::new(Filter::Trilinear);
    let read = |baked: &Baked, uv: [f64; 2], lod: f32| {
        let image = Image::new(size, size, 3, baked.values().to_vec()).expect("an image");
        let texture = Texture::new(image.view(), TextureOptions::default()).expect("a texture");
        let mut out = [0.0f32; 3];
        sampler.sample(&texture, &uv, Extent::Lod(&[lod]), &mut out).expect("a sample");
        out.map(f64::from)
    };
    // One colour all over the surface is that colour at every place and level.
    let baked = run(&high, &low, &Map::Color(&paints), size, &Options::default());
    for lod in 0..=7 {
        for (u, v) in [(0.07, 0.06), (0.45, 0.5), (0.55, 0.5), (0.93, 0.94), (0.5, 0.5), (0.0, 1.0)] {
            let color = read(&baked, [u, v], lod as f32);
            assert!(
                color.iter().zip([0.75, 0.5, 0.25]).all(|(a, b)| (a - b).abs() < 1e-6),
                "{color:?} at {lod}"
            );
        }
    }
    // Shading along the seam, read four levels down, against the mean over the islands alone: the levels of
    // value times coverage over those of coverage.
    let light = unit([0.3, 0.4, 0.85]);
    let bent = |padding: Option<usize>| {
        let options = Options { padding, ..Options::default() };
        run(&high, &low, &Map::Normal(Space::Object), size, &options)
    };
    let (filled, bare) = (bent(None), bent(Some(0)));
    let inside: Vec<f32> = bare.flags().iter().map(|f| f32::from(f & flag::COVERED)).collect();
    let inside = Image::new(size, size, 1, inside).expect("an image");
    let inside = Texture::new(inside.view(), TextureOptions::default()).expect("a texture");
    let (mut with, mut without) = (0.0f64, 0.0f64);
    for i in 0..40 {
        let v = 0.15 + 0.7 * i as f64 / 39.0;
        for u in [0.45, 0.55] {
            let mut share = [0.0f32];
            sampler.sample(&inside, &[u, v], Extent::Lod(&[4.0]), &mut share).expect("a sample");
            let [full, empty] = [&filled, &bare].map(|baked| dot(read(baked, [u, v], 4.0), light));
            let truth = empty / f64::from(share[0]);
            with = with.max((full - truth).abs());
            without = without.max((empty - truth).abs());
        }
    }
    assert!(with < without / 5.0, "{with} {without}");
}

#[test]
fn hostile_meshes_and_options_are_refused_or_harmless() {
    let (high, low) = (square(0.1), square(0.0));
    let with =
        |options: Options| bake(&high, &low, &Map::Height, [4, 4], &options).err().map(|e| e.to_string());
    for (options, argument) in [
        (Options { samples: 0, ..Options::default() }, "samples"),
        (Options { samples: 9, ..Options::default() }, "samples"),
        (Options { distance: Some(f64::NAN), ..Options::default() }, "distance"),
        (Options { distance: Some(-1.0), ..Options::default() }, "distance"),
        (Options { cage: Some(vec![[0.0; 3]]), ..Options::default() }, "cage"),
        (Options { cage: Some(vec![[f32::NAN; 3]; 4]), ..Options::default() }, "cage"),
    ] {
        assert!(with(options).is_some_and(|text| text.starts_with(argument)), "{argument}");
    }
    for size in [[0, 4], [4, 16385]] {
        assert!(bake(&high, &low, &Map::Height, size, &Options::default()).is_err());
    }
    assert!(
        bake(&high, &low, &Map::Occlusion { rays: 0, radius: 1.0 }, [4, 4], &Options::default()).is_err()
    );
    assert!(bake(&high, &low, &Map::Color(&[]), [4, 4], &Options::default()).is_err());
    // A cage on the surface itself has no direction: the face's normal serves.
    let flat = Options { cage: Some(low.positions.clone()), ..Options::default() };
    assert_eq!(run(&high, &low, &Map::Height, 4, &flat).report().covered, 16);
    // Nothing to meet, and nothing to cover.
    let nothing = Mesh { faces: Vec::new(), face_material: Vec::new(), ..square(0.0) };
    assert_eq!(run(&nothing, &low, &Map::Height, 4, &Options::default()).report().missed, 16);
    let empty = run(&high, &nothing, &Map::Normal(Space::Tangent), 4, &Options::default());
    assert!(empty.values().chunks(3).all(|n| n == [0.0, 0.0, 1.0]));
    assert!(empty.report().warnings()[0].contains("the map is empty"));
    // uv that are not numbers, huge, or outside; the same face a thousand times; flat faces.
    for odd in [f32::NAN, f32::INFINITY, 1e30, -1e30, 3.5] {
        let mut bad = square(0.0);
        bad.uv[0][1] = [odd, 0.5];
        let report = run(&high, &bad, &Map::Height, 8, &Options::default()).report().clone();
        assert!(report.degenerate_faces + report.outside_faces > 0, "{odd}");
    }
    let mut many = square(0.1);
    many.faces = vec![[2, 1, 0]; 20_000];
    many.faces.push([1, 1, 2]);
    many.face_material = vec![0; many.faces.len()];
    let baked = run(&many, &low, &Map::Height, 8, &Options::default());
    assert!(baked.report().covered > 0 && baked.report().ambiguous == 0);
    many.faces.pop();
    many.face_material.pop();
    let huge =
        Mesh { positions: high.positions.iter().map(|p| p.map(|c| c * 3e38)).collect(), ..square(0.0) };
    assert!(bake(&huge, &low, &Map::Height, [4, 4], &Options::default()).is_ok());
    assert!(intersect(&high.positions, &[[0, 1, 9]], &[]).is_err());
    assert!(intersect(&high.positions, &high.faces, &[([0.0; 3], [0.0; 3])]).is_err());
}
