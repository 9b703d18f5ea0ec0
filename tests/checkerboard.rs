//! The filtered checkerboard against areas of clipped cells, and surfaces against the maps that undo them.

use glam::{DVec2, DVec3};
use multum::Jacobian;
use multum::mapping::distortion::{Distortion, distortion, tangents};
use multum::mapping::surface::Surface;
use multum::mapping::{
    Axis, Cylindrical, DualParaboloid, Mapping, Planar, Spherical, Stereographic, SurfacePoint, checkerboard,
};
use std::f64::consts::PI;

struct Random(u64);

impl Random {
    fn signed(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / 2f64.powi(52) - 1.0
    }
}

/// The part of a convex polygon where a·p ≥ b.
fn clip(polygon: &[DVec2], a: DVec2, b: f64) -> Vec<DVec2> {
    let mut out = Vec::new();
    for (i, p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let (s, t) = (a.dot(*p) - b, a.dot(q) - b);
        if s >= 0.0 {
            out.push(*p);
        }
        if (s > 0.0 && t < 0.0) || (s < 0.0 && t > 0.0) {
            out.push(*p + (q - *p) * (s / (s - t)));
        }
    }
    out
}

fn area(polygon: &[DVec2]) -> f64 {
    let twice: f64 = (0..polygon.len()).map(|i| polygon[i].perp_dot(polygon[(i + 1) % polygon.len()])).sum();
    0.5 * twice.abs()
}

/// White share of a parallelogram, cell by cell.
fn by_cells(center: DVec2, a: DVec2, b: DVec2) -> f64 {
    let corners = [-(a + b), a - b, a + b, b - a].map(|c| center + c * 0.5);
    let (low, high) = corners.iter().fold((corners[0], corners[0]), |(l, h), c| (l.min(*c), h.max(*c)));
    let mut white = 0.0;
    for y in low.y.floor() as i64..=high.y.floor() as i64 {
        for x in low.x.floor() as i64..=high.x.floor() as i64 {
            if (x + y).rem_euclid(2) == 0 {
                let (x, y) = (x as f64, y as f64);
                let mut cell = clip(&corners, DVec2::X, x);
                cell = clip(&cell, -DVec2::X, -(x + 1.0));
                cell = clip(&cell, DVec2::Y, y);
                cell = clip(&cell, -DVec2::Y, -(y + 1.0));
                white += area(&cell);
            }
        }
    }
    white / area(&corners)
}

#[test]
fn footprints_of_every_shape_match_clipped_cells() {
    let mut random = Random(1);
    for i in 0..20_000 {
        let size = 10f64.powf(random.signed() * 1.2 - 0.2);
        let mut vector = || DVec2::new(random.signed(), random.signed());
        let (center, a, b) = (vector() * 5.0, vector() * size, vector() * size);
        if a.perp_dot(b).abs() < 0.01 * size * size {
            continue;
        }
        let cells = DVec2::new(10.0, 4.0);
        let j = Jacobian::new([[a.x / 10.0, b.x / 10.0], [a.y / 4.0, b.y / 4.0]]);
        let got = checkerboard::filtered(center / cells, j, cells);
        let expected = by_cells(center, a, b);
        assert!((got - expected).abs() < 1e-9, "{i}: {center} {a} {b}: {got} {expected}");
    }
}

#[test]
fn tiny_thin_huge_and_broken_footprints() {
    let one = DVec2::ONE;
    let at = |x: f64, y: f64, m| checkerboard::filtered(DVec2::new(x, y), Jacobian::new(m), one);
    // A tiny square that lies to 30 % over a border.
    for e in 1..15 {
        let s = 10f64.powi(-e);
        let place = 3.0 + 0.2 * s;
        let over = 0.5 - (place - 3.0) / s;
        let got = at(place, 0.5, [[s, 0.0], [0.0, s]]);
        // The coordinate itself has an absolute precision of one ulp of 3.
        assert!((got - over).abs() < 1e-12 + 2.0 * f64::EPSILON * 3.0 / s, "{e}: {got} {over}");
    }
    // A point, a segment within a cell, and one half over the border.
    assert_eq!(at(0.5, 0.5, [[0.0; 2]; 2]), 1.0);
    assert_eq!(at(1.5, 0.5, [[0.2, 0.0], [0.1, 0.0]]), 0.0);
    assert!((at(1.0, 0.5, [[0.2, 0.0], [0.1, 0.0]]) - 0.5).abs() < 1e-12);
    // Two movements along one line weigh its middle more: 3/4 of a unit triangle within a half of its centre.
    let line = at(0.5, 0.5, [[1.0, 1.0], [0.0, 0.0]]);
    assert!((line - 0.75).abs() < 1e-12, "{line}");
    // Along the diagonal every cell is white.
    assert!((at(0.5, 0.5, [[64.0, 1e-14], [64.0, -1e-14]]) - 1.0).abs() < 1e-6);
    // Whole periods are grey, and so is everything too large to look at.
    assert!((at(0.3, 0.1, [[2.0, 0.0], [0.0, 3.0]]) - 0.5).abs() < 1e-12);
    for huge in [1e9, f64::INFINITY, f64::NAN] {
        assert_eq!(at(0.3, 0.1, [[huge, 0.0], [0.0, huge]]), 0.5);
    }
    assert!(at(f64::NAN, 0.0, [[1.0, 0.0], [0.0, 1.0]]).is_nan());
    assert!(checkerboard::point(DVec2::new(f64::INFINITY, 0.0), one).is_nan());
    // Negative coordinates go on alternating.
    let row: Vec<f64> =
        (-3..3).map(|i| checkerboard::point(DVec2::new(f64::from(i) + 0.5, 0.5), one)).collect();
    assert_eq!(row, [0.0, 1.0, 0.0, 1.0, 0.0, 1.0]);
}

#[test]
fn long_footprints_stay_exact() {
    // Sheared and long: compared with cells, at sizes where rounding would show.
    let (a, b) = (DVec2::new(211.3, 97.1), DVec2::new(-1.7, 2.9));
    let center = DVec2::new(0.377, -0.61);
    let got = checkerboard::filtered(center, Jacobian::new([[a.x, b.x], [a.y, b.y]]), DVec2::ONE);
    assert!((got - by_cells(center, a, b)).abs() < 1e-9);
}

fn surfaces() -> Vec<(Surface, Option<Box<dyn Mapping>>)> {
    let center = DVec3::new(0.5, -1.0, 2.0);
    let sphere = Spherical::new(Axis::Z, center).expect("a map");
    let tube = Cylindrical::new(Axis::Z, center, [-1.0, 2.0]).expect("a map");
    let mut net = [[DVec3::ZERO; 4]; 4];
    for (j, row) in net.iter_mut().enumerate() {
        for (i, c) in row.iter_mut().enumerate() {
            let (x, y) = (i as f64, j as f64);
            *c = DVec3::new(x, y + 0.2 * x, (x * 1.3 + y * 0.7).sin());
        }
    }
    let list = [
        (Surface::Sphere { center, radius: 1.5 }, Some(Box::new(sphere) as Box<dyn Mapping>)),
        (Surface::Cylinder { center, radius: 0.7, height: [-1.0, 2.0] }, Some(Box::new(tube))),
        (Surface::Torus { center, major: 2.0, minor: 0.5 }, None),
        (Surface::Bezier(Box::new(net)), None),
    ];
    list.into_iter().map(|(s, m)| (s.checked().expect("a surface"), m)).collect()
}

#[test]
fn surfaces_have_true_derivatives_and_normals() {
    let mut random = Random(2);
    for (surface, map) in surfaces() {
        for _ in 0..10_000 {
            let uv = DVec2::new(0.5 + 0.49 * random.signed(), 0.5 + 0.49 * random.signed());
            let place = surface.at(uv);
            let h = 1e-3;
            for (d, slope) in [(DVec2::X, place.p_u), (DVec2::Y, place.p_v)] {
                let at = |k: f64| surface.at(uv + d * (k * h)).p;
                let numeric = ((at(1.0) - at(-1.0)) * 8.0 - (at(2.0) - at(-2.0))) / (12.0 * h);
                assert!((slope - numeric).length() < 1e-6 * numeric.length().max(1.0), "{surface:?} {uv}");
            }
            let cross = place.p_u.cross(place.p_v).normalize();
            assert!((place.n.length() - 1.0).abs() < 1e-12);
            assert!((cross.dot(place.n).abs() - 1.0).abs() < 1e-9, "{surface:?} {uv}");
            if let Some(map) = &map {
                let at = map.at(&SurfacePoint::new(place.p).moving(place.p_u, place.p_v));
                assert!((at.uv - uv).length() < 1e-12);
                let m = at.jacobian.m;
                assert!((m[0][0] - 1.0).abs() + m[0][1].abs() + m[1][0].abs() + (m[1][1] - 1.0).abs() < 1e-9);
            }
        }
    }
    // Outward, also at the pole of the sphere and on a patch with one side drawn to a point.
    let sphere = Surface::Sphere { center: DVec3::ZERO, radius: 2.0 };
    assert!((sphere.at(DVec2::ZERO).n - DVec3::Z).length() < 1e-15);
    let fan =
        std::array::from_fn(|j| std::array::from_fn(|i| DVec3::new(i as f64 * j as f64, j as f64, 0.0)));
    let fan = Surface::Bezier(Box::new(fan));
    assert!((fan.at(DVec2::new(0.3, 0.0)).n - DVec3::Z).length() < 1e-9);
    assert!(Surface::Torus { center: DVec3::ZERO, major: 0.0, minor: 1.0 }.checked().is_err());
}

#[test]
fn distortion_of_maps_that_keep_areas_or_angles() {
    let mut random = Random(4);
    let planet = Stereographic::new(PI).expect("a map");
    let plane = Planar::new(Axis::Z, DVec3::ZERO, DVec3::ONE).expect("a map");
    let sphere = Spherical::new(Axis::Z, DVec3::ZERO).expect("a map");
    for _ in 0..10_000 {
        let d = DVec3::new(random.signed(), random.signed(), random.signed()).normalize();
        let [e1, e2] = tangents(d).expect("a frame");
        let frame = [e1.dot(e2), e1.dot(d), e2.dot(d), e1.length() - 1.0, e2.length() - 1.0];
        assert!(frame.iter().all(|x| x.abs() < 1e-14) && e1.cross(e2).dot(d) > 0.0);
        if d.z > -0.99 {
            // Angles stay; a paraboloid's half is the same map at half the size.
            assert!((distortion(&planet, d, d).angle() - 1.0).abs() < 1e-9);
            let half = distortion(&DualParaboloid, d, d);
            assert!((half.angle() - 2.0).abs() < 1e-9, "its cells are half as wide as high: {half:?}");
        }
        // On the unit sphere du dv = sin θ / (2π · π sin²θ) of an area element.
        if d.z.abs() < 0.99 {
            let sin = d.x.hypot(d.y);
            assert!((distortion(&sphere, d, d).area() * 2.0 * PI * PI * sin - 1.0).abs() < 1e-9);
        }
        // A plane seen at an angle shrinks by its cosine.
        let seen = distortion(&plane, d, d);
        assert!((seen.area() - d.z.abs()).abs() < 1e-12 && (seen.sigma1 - 1.0).abs() < 1e-12);
    }
    let pole = distortion(&sphere, DVec3::Z, DVec3::Z);
    assert!(pole.sigma1.is_infinite() && distortion(&sphere, DVec3::ZERO, DVec3::Z).sigma1.is_nan());
    assert!(Distortion { sigma1: 1.0, sigma2: 0.0 }.angle().is_infinite());
    assert!(tangents(DVec3::ZERO).is_none());
}
