//! Mapping functions against closed forms, finite differences, brute force and their own inverses.

use glam::{DMat4, DVec2, DVec3, DVec4};
use multum::mapping::{
    Axis, Cube, Cylindrical, DualParaboloid, Equirect, Face, Facets, Fisheye, FisheyeModel, Input,
    Intermediate, Layout, LightProbe, Linear, Mapping, MirrorBall, Numbers, Octahedral, Output, Patch,
    Perspective, Planar, Polygon, Projection, Projective, SphereMap, Spherical, Stereographic, SurfacePoint,
    TwoStage, inverse_batch, map_batch,
};
use std::f64::consts::{PI, TAU};

/// Points a map.
const COUNT: usize = 100_000;

/// SplitMix64: the same numbers everywhere.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as f64 / 2f64.powi(64)
    }

    fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.signed(), self.signed(), self.signed())
    }

    fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.vector();
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }
}

/// Compares value and Jacobian with `reference` and its central differences of fourth order.
///
/// `regular` says whether a point is away from singular sets and from the borders between pieces.
/// Returns how many points were.
fn compare(
    name: &str,
    map: &dyn Mapping,
    reference: &dyn Fn(DVec3, DVec3) -> DVec2,
    regular: &dyn Fn(DVec3, DVec3) -> bool,
    sample: &dyn Fn(&mut Random) -> (DVec3, DVec3),
    count: usize,
) -> usize {
    let mut random = Random(7);
    let mut used = 0;
    for _ in 0..count {
        let (p, n) = sample(&mut random);
        let (dp, dn) = ([random.vector(), random.vector()], [random.vector(), random.vector()]);
        if !regular(p, n) {
            continue;
        }
        used += 1;
        let got = map.at(&SurfacePoint { p, n, dp, dn });
        let near = |d: DVec2| if map.is_periodic() { DVec2::new(d.x - d.x.round(), d.y) } else { d };
        let expected = reference(p, n);
        assert!(
            near(got.uv - expected).length() < 1e-12 * expected.length().max(1.0),
            "{name} {p} {n}: {got:?} {expected}"
        );
        let mut numeric = [[0.0; 2]; 2];
        for j in 0..2 {
            let h = 2e-4;
            let at = |k: f64| reference(p + dp[j] * (h * k), n + dn[j] * (h * k));
            let slope = (near(at(1.0) - at(-1.0)) * 8.0 - near(at(2.0) - at(-2.0))) / (12.0 * h);
            numeric[0][j] = slope.x;
            numeric[1][j] = slope.y;
        }
        let scale = numeric.iter().flatten().fold(0.0, |a: f64, b| a.max(b.abs()));
        for (row, expected) in got.jacobian.m.iter().zip(numeric) {
            for (x, e) in row.iter().zip(expected) {
                assert!((x - e).abs() <= 1e-6 * scale, "{name} {p} {n}: {got:?}, differences {numeric:?}");
            }
        }
    }
    used
}

fn check(
    name: &str,
    map: &dyn Mapping,
    reference: &dyn Fn(DVec3, DVec3) -> DVec2,
    regular: &dyn Fn(DVec3, DVec3) -> bool,
    sample: &dyn Fn(&mut Random) -> (DVec3, DVec3),
) {
    let used = compare(name, map, reference, regular, sample, COUNT);
    assert!(used > COUNT / 4, "{name}: only {used} points are regular");
}

fn anywhere(r: &mut Random) -> (DVec3, DVec3) {
    (r.vector() * 2.0, r.direction())
}

fn off_axis(p: DVec3) -> bool {
    p.x.hypot(p.y) > 0.15
}

/// All coordinates apart from zero and from each other, so that no step changes the piece.
fn generic(p: DVec3) -> bool {
    let a = p.abs();
    let gaps = [a.x, a.y, a.z, (a.x - a.y).abs(), (a.y - a.z).abs(), (a.x - a.z).abs()];
    gaps.iter().all(|g| *g > 0.02) && p.length() > 0.3
}

fn unit_turns(y: f64, x: f64) -> f64 {
    (y.atan2(x) / TAU).rem_euclid(1.0)
}

#[test]
fn planes_and_facets() {
    let (min, max) = (DVec3::new(-1.0, 0.5, 2.0), DVec3::new(1.0, 3.5, 2.5));
    let z = Planar::new(Axis::Z, min, max).expect("bounds");
    check("planar z", &z, &|p, _| DVec2::new((p.x + 1.0) / 2.0, (p.y - 0.5) / 3.0), &|_, _| true, &anywhere);
    let x = Planar::new(Axis::X, min, max).expect("bounds");
    check("planar x", &x, &|p, _| DVec2::new((p.y - 0.5) / 3.0, (p.z - 2.0) / 0.5), &|_, _| true, &anywhere);
    let y = Planar::new(Axis::Y, min, max).expect("bounds");
    check("planar y", &y, &|p, _| DVec2::new((p.z - 2.0) / 0.5, (p.x + 1.0) / 2.0), &|_, _| true, &anywhere);
    let facets = Facets::new(DVec3::ZERO, DVec3::ONE).expect("bounds");
    let picked = |p: DVec3, n: DVec3| match n.abs().to_array() {
        [a, b, c] if a >= b && a >= c => DVec2::new(p.y, p.z),
        [_, b, c] if b >= c => DVec2::new(p.z, p.x),
        _ => DVec2::new(p.x, p.y),
    };
    check("facets", &facets, &picked, &|_, n| generic(n), &anywhere);
    assert!(facets.at(&SurfacePoint::new(DVec3::ONE)).uv.is_nan());
    assert!(Planar::new(Axis::Z, DVec3::ZERO, DVec3::new(1.0, 0.0, 1.0)).is_err());
    assert!(Planar::new(Axis::Z, DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0)).is_ok());
    assert!(Facets::new(DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0)).is_err());
    assert!(Planar::new(Axis::Z, DVec3::ZERO, DVec3::new(f64::NAN, 1.0, 1.0)).is_err());
}

#[test]
fn sphere_and_cylinder() {
    let c = DVec3::new(0.1, -0.2, 0.3);
    let sphere = Spherical::new(Axis::Z, c).expect("a map");
    let closed = |p: DVec3, _: DVec3| {
        let d = (p - c).normalize();
        DVec2::new(unit_turns(d.y, d.x), d.x.hypot(d.y).atan2(d.z) / PI)
    };
    check("spherical", &sphere, &closed, &|p, _| off_axis(p - c), &anywhere);
    let about_x = Spherical::new(Axis::X, DVec3::ZERO).expect("a map");
    let closed = |p: DVec3, _: DVec3| DVec2::new(unit_turns(p.z, p.y), (p.x / p.length()).acos() / PI);
    check("spherical x", &about_x, &closed, &|p, _| p.y.hypot(p.z) > 0.3, &anywhere);
    let tube = Cylindrical::new(Axis::Y, c, [1.0, -3.0]).expect("a map");
    let closed = |p: DVec3, _: DVec3| {
        let d = p - c;
        DVec2::new(unit_turns(d.x, d.z), (1.0 - d.y) / 4.0)
    };
    check("cylindrical y", &tube, &closed, &|p, _| (p.x - c.x).hypot(p.z - c.z) > 0.15, &anywhere);
    assert!(Cylindrical::new(Axis::Z, c, [1.0, 1.0]).is_err());
    assert!(Spherical::new(Axis::Z, DVec3::INFINITY).is_err());
}

/// Rows and columns of the face table of the OpenGL specification, typed once more.
fn gl_face(p: DVec3) -> (usize, f64, f64) {
    let a = p.abs();
    let (face, sc, tc, ma) = if a.x >= a.y && a.x >= a.z {
        if p.x > 0.0 { (0, -p.z, -p.y, a.x) } else { (1, p.z, -p.y, a.x) }
    } else if a.y >= a.z {
        if p.y > 0.0 { (2, p.x, p.z, a.y) } else { (3, p.x, -p.z, a.y) }
    } else if p.z > 0.0 {
        (4, p.x, -p.y, a.z)
    } else {
        (5, -p.x, -p.y, a.z)
    };
    (face, 0.5 * (sc / ma + 1.0), 0.5 * (tc / ma + 1.0))
}

#[test]
fn cube_in_every_layout() {
    let cells = [(2.0, 1.0), (0.0, 1.0), (1.0, 0.0), (1.0, 2.0), (1.0, 1.0), (3.0, 1.0)];
    let cross = |p: DVec3, _: DVec3| {
        let (face, s, t) = gl_face(p);
        DVec2::new((cells[face].0 + s) / 4.0, (cells[face].1 + t) / 3.0)
    };
    let map = |layout| Cube::new(layout, DVec3::ZERO).expect("a map");
    check("cross", &map(Layout::Cross), &cross, &|p, _| generic(p), &anywhere);
    let strip = |p: DVec3, _: DVec3| {
        let (face, s, t) = gl_face(p);
        DVec2::new((face as f64 + s) / 6.0, t)
    };
    check("strip", &map(Layout::Strip), &strip, &|p, _| generic(p), &anywhere);
    let stacked = |p: DVec3, _: DVec3| {
        let (face, s, t) = gl_face(p);
        DVec2::new(s, (face as f64 + t) / 6.0)
    };
    check("stacked", &map(Layout::Stacked), &stacked, &|p, _| generic(p), &anywhere);
    // Ties have one answer, the centre has none, and empty cells of the cross have no direction.
    let cube = map(Layout::Cross);
    assert_eq!(cube.face_at(&SurfacePoint::new(DVec3::ONE)).map(|f| f.0), Some(Face::PlusX));
    assert_eq!(
        cube.face_at(&SurfacePoint::new(DVec3::new(0.0, -1.0, -1.0))).map(|f| f.0),
        Some(Face::MinusY)
    );
    assert!(cube.at(&SurfacePoint::new(DVec3::ZERO)).uv.is_nan());
    assert!(
        cube.inverse_at(DVec2::new(0.1, 0.1)).is_none() && cube.inverse_at(DVec2::new(1.1, 0.5)).is_none()
    );
}

/// In the cross, walking over the four inner edges of +Z and along the middle row, direction stays continuous.
#[test]
fn faces_of_the_cross_fit_each_other() {
    let cube = Cube::new(Layout::Cross, DVec3::ZERO).expect("a map");
    let joints = [(0.25, 0.5), (0.5, 0.5), (0.75, 0.5)].map(|(u, v)| (DVec2::new(u, v), DVec2::X));
    let upright = [(0.375, 1.0 / 3.0), (0.375, 2.0 / 3.0)].map(|(u, v)| (DVec2::new(u, v), DVec2::Y));
    for (at, across) in joints.into_iter().chain(upright) {
        for i in -4..=4 {
            let along = DVec2::new(across.y / 9.0, across.x / 9.0 * 4.0 / 3.0) * f64::from(i) * 0.25;
            let side = |s: f64| cube.inverse_at(at + along + across * (s * 1e-9)).expect("a direction").p;
            assert!(side(1.0).distance(side(-1.0)) < 1e-7, "{at} {along}");
        }
    }
}

#[test]
fn round_pictures() {
    let e = |p: DVec3, r: f64| {
        let rho = p.x.hypot(p.y);
        DVec2::new(0.5 + 0.5 * r * p.x / rho, 0.5 - 0.5 * r * p.y / rho)
    };
    let away = |p: DVec3, _: DVec3| p.length() > 0.3 && (off_axis(p));
    check("probe", &LightProbe, &|p, _| e(p, (p.z / p.length()).acos() / PI), &away, &anywhere);
    // OpenGL 2.1, equation of GL_SPHERE_MAP, with t turned down.
    let gl = |p: DVec3, _: DVec3| {
        let r = p.normalize();
        let m = 2.0 * (r.x * r.x + r.y * r.y + (r.z + 1.0).powi(2)).sqrt();
        DVec2::new(r.x / m + 0.5, 1.0 - (r.y / m + 0.5))
    };
    check("sphere map", &SphereMap, &gl, &away, &anywhere);
    // The ball's normal is half way between the mirrored direction and the way to the camera.
    let ball = |p: DVec3, _: DVec3| {
        let n = (p.normalize() + DVec3::new(0.0, 0.0, -1.0)).normalize();
        DVec2::new(0.5 + 0.5 * n.x, 0.5 - 0.5 * n.y)
    };
    check("mirror ball", &MirrorBall, &ball, &away, &anywhere);
    let planet = Stereographic::new(PI).expect("a map");
    let closed = |p: DVec3, _: DVec3| {
        let d = p.normalize();
        DVec2::new(0.5 + 0.5 * d.x / (1.0 + d.z), 0.5 - 0.5 * d.y / (1.0 + d.z))
    };
    check("stereographic", &planet, &closed, &|p, n| away(p, n) && p.z / p.length() > -0.9, &anywhere);
    let fish = Fisheye::new(FisheyeModel::Equidistant, 1.5 * PI).expect("a map");
    let inside = |p: DVec3, n: DVec3| away(p, n) && (p.z / p.length()).acos() < 0.74 * PI;
    check("equidistant", &fish, &|p, _| e(p, (p.z / p.length()).acos() / (0.75 * PI)), &inside, &anywhere);
    let fish = Fisheye::new(FisheyeModel::Equisolid, 1.5 * PI).expect("a map");
    let solid = |p: DVec3, _: DVec3| e(p, (0.5 * (1.0 - p.z / p.length())).sqrt() / (0.375 * PI).sin());
    check("equisolid", &fish, &solid, &inside, &anywhere);
    assert!(fish.at(&SurfacePoint::new(-DVec3::Z)).uv.is_nan());
    assert!(Fisheye::new(FisheyeModel::Equisolid, 0.0).is_err() && Stereographic::new(TAU).is_err());
}

#[test]
fn other_pictures_of_directions() {
    let closed = |p: DVec3, _: DVec3| {
        DVec2::new((0.5 + p.x.atan2(p.z) / TAU).rem_euclid(1.0), (p.y / p.length()).acos() / PI)
    };
    check("equirect", &Equirect, &closed, &|p, _| p.x.hypot(p.z) > 0.3, &anywhere);
    let camera = Perspective::new(PI / 2.0, 2.0).expect("a map");
    let closed = |p: DVec3, _: DVec3| DVec2::new(0.5 + 0.5 * p.x / p.z, 0.5 - p.y / p.z);
    check("perspective", &camera, &closed, &|p, _| p.z > 0.1, &anywhere);
    assert!(camera.at(&SurfacePoint::new(DVec3::X)).uv.is_nan());
    let closed = |p: DVec3, _: DVec3| {
        let d = p.normalize();
        let (side, offset) = if d.z >= 0.0 { (1.0, 0.0) } else { (-1.0, 0.5) };
        let m = 1.0 + d.z.abs();
        DVec2::new((1.0 + side * d.x / m) / 4.0 + offset, (1.0 - d.y / m) / 2.0)
    };
    check("dual paraboloid", &DualParaboloid, &closed, &|p, _| generic(p), &anywhere);
    let closed = |p: DVec3, _: DVec3| {
        let d = p / (p.x.abs() + p.y.abs() + p.z.abs());
        let (mut a, mut b) = (d.x, d.y);
        if d.z < 0.0 {
            (a, b) = ((1.0 - d.y.abs()) * d.x.signum(), (1.0 - d.x.abs()) * d.y.signum());
        }
        DVec2::new(0.5 + 0.5 * a, 0.5 - 0.5 * b)
    };
    check("octahedral", &Octahedral, &closed, &|p, _| generic(p), &anywhere);
}

#[test]
fn linear_and_patch() {
    let map = Linear::new(2.0, -0.5, 0.25, 1.5, 3.0, -1.0).expect("a map");
    let closed = |p: DVec3, _: DVec3| DVec2::new(2.0 * p.x - 0.5 * p.y + 0.25, 1.5 * p.x + 3.0 * p.y - 1.0);
    check("linear", &map, &closed, &|_, _| true, &anywhere);
    let patch = Patch::new([0.0, 2.0], [1.0, 3.0], [0.5, 0.75], [1.0, 0.0]).expect("a map");
    let closed = |p: DVec3, _: DVec3| DVec2::new(0.5 + p.x / 8.0, 1.0 - (p.y - 1.0) / 2.0);
    check("patch", &patch, &closed, &|_, _| true, &anywhere);
    let refused = Linear::new(0.1, 0.3, 0.0, 0.2, 0.6, 0.0).expect("a map").inverse();
    let text = refused.expect_err("0.1 * 0.6 is 0.3 * 0.2 to the last bit of both").to_string();
    assert!(text.contains("coefficients") && text.contains("a e"), "{text}");
    // One part in 10^15 from singular is still a map, and its inverse is right.
    let thin = Linear::new(1.0, 1.0, 0.0, 1.0, 1.0 + 1e-15, 0.0).expect("a map");
    let back = thin.inverse().expect("an inverse");
    assert!((back.coefficients()[0] * 1e-15 - 1.0).abs() < 0.2);
    assert!(Patch::new([1.0, 1.0], [0.0, 1.0], [0.0, 1.0], [0.0, 1.0]).is_err());
    assert!(Linear::new(f64::NAN, 0.0, 0.0, 0.0, 0.0, 0.0).is_err());
}

#[test]
fn projectors() {
    // Rows s, t, r, q of a camera at (0, 0, -3) that looks along +z and a little aside.
    let rows = [
        DVec4::new(1.0, 0.1, 0.5, 1.5),
        DVec4::new(-0.2, 0.9, 0.4, 1.2),
        DVec4::new(0.0, 0.0, 1.0, 2.0),
        DVec4::new(0.1, 0.0, 1.0, 3.0),
    ];
    let matrix = DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose();
    let map = Projective::new(matrix).expect("a map");
    let q = move |p: DVec3| rows[3].dot(p.extend(1.0));
    let closed =
        move |p: DVec3, _: DVec3| DVec2::new(rows[0].dot(p.extend(1.0)), rows[1].dot(p.extend(1.0))) / q(p);
    check("projective", &map, &closed, &move |p, _| q(p) > 0.3, &anywhere);
    let front = map.front_only().expect("a map");
    let mut random = Random(3);
    // s = t = q = 0 at the projector.
    let source = DVec3::new(0.0, 0.0, -3.0);
    assert!(rows.iter().enumerate().all(|(i, r)| i == 2 || r.dot(source.extend(1.0)).abs() < 1e-12));
    for _ in 0..10_000 {
        let (p, n) = (random.vector() * 6.0, random.direction());
        let lit = q(p) > 0.0 && n.dot(source - p) > 0.0;
        assert_eq!(!front.at(&SurfacePoint::new(p).with_normal(n)).uv.is_nan(), lit, "{p} {n}");
        assert_eq!(map.at(&SurfacePoint::new(p)).uv.is_nan(), q(p) <= 0.0);
    }
    // Parallel light along -z: r grows downwards, only upward faces are lit.
    let sun = DMat4::from_cols(DVec4::X, DVec4::Y, DVec4::new(0.0, 0.0, -1.0, 0.0), DVec4::W);
    let sun = Projective::new(sun).expect("a map").front_only().expect("a side");
    for (n, lit) in [(DVec3::Z, true), (-DVec3::Z, false), (DVec3::X, false)] {
        assert_eq!(!sun.at(&SurfacePoint::new(DVec3::ONE).with_normal(n)).uv.is_nan(), lit);
    }
    assert!(Projective::new(DMat4::ZERO).is_err());
    let flat = DMat4::from_cols(DVec4::X, DVec4::Y, DVec4::ZERO, DVec4::W);
    assert!(Projective::new(flat).expect("a map").front_only().is_err());
}

#[test]
fn polygons_made_by_hand() {
    // A concave arrow in a tilted plane, its coordinates an affine image of the outline: any triangulation
    // must give that affine map back.
    let plane = |a: f64, b: f64| DVec3::new(a, b, 0.5 * a - 0.25 * b + 1.0);
    let affine = |a: f64, b: f64| DVec2::new(0.5 * a + 0.1 * b, 0.3 - 0.2 * a + b);
    let outline = [(0.0, 0.0), (2.0, -1.0), (1.0, 0.0), (2.0, 1.0), (0.0, 0.5)];
    let corners = outline.map(|(a, b)| plane(a, b));
    for turn in [false, true] {
        let mut corners = corners.to_vec();
        let mut uv = outline.map(|(a, b)| affine(a, b)).to_vec();
        if turn {
            corners.reverse();
            uv.reverse();
        }
        let map = Polygon::new(&corners, &uv).expect("a polygon");
        let closed = |p: DVec3, _: DVec3| affine(p.x, p.y);
        let sample = |r: &mut Random| {
            // Inside the triangle (0,0) (1,0) (0,0.5).
            let (mut s, mut t) = (r.unit(), r.unit());
            if s + t > 1.0 {
                (s, t) = (1.0 - s, 1.0 - t);
            }
            (plane(s, 0.5 * t), DVec3::Z)
        };
        check("polygon", &map, &closed, &|_, _| true, &sample);
        assert!(map.at(&SurfacePoint::new(plane(1.9, 0.0))).uv.is_nan(), "the notch is outside");
        assert!(!map.at(&SurfacePoint::new(plane(1.8, 0.85))).uv.is_nan());
    }
    let square = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
    assert!(Polygon::new(&square[..2], &[DVec2::ZERO; 2]).is_err());
    assert!(Polygon::new(&square, &[DVec2::ZERO; 3]).is_err());
    assert!(
        Polygon::new(&[square[0], square[1], square[2], DVec3::new(0.0, 1.0, 0.5)], &[DVec2::ZERO; 4])
            .is_err()
    );
    assert!(Polygon::new(&[DVec3::ZERO, DVec3::X, DVec3::X * 2.0], &[DVec2::ZERO; 3]).is_err());
    let bow = [square[0], square[2], square[1], square[3]];
    assert!(Polygon::new(&bow, &[DVec2::ZERO; 4]).is_err());
}

/// How far outside the unit surface a point is, by definition.
fn outside(surface: usize, q: DVec3) -> f64 {
    match surface {
        0 => q.length() - 1.0,
        1 => q.x.hypot(q.y) - 1.0,
        2 => q.z - 1.0,
        _ => q.abs().max_element() - 1.0,
    }
}

/// The S stage typed once more.
fn texture(surface: usize, q: DVec3) -> DVec2 {
    match surface {
        0 => DVec2::new(unit_turns(q.y, q.x), q.x.hypot(q.y).atan2(q.z) / PI),
        1 => DVec2::new(unit_turns(q.y, q.x), (q.z + 1.0) / 3.0),
        2 => DVec2::new(0.5 + 0.5 * q.x, 0.5 + 0.5 * q.y),
        _ => {
            let (face, s, t) = gl_face(q);
            DVec2::new((face as f64 + s) / 6.0, t)
        }
    }
}

/// The crossing of a ray from inside, by bisection.
fn march(surface: usize, o: DVec3, d: DVec3) -> Option<DVec3> {
    let (mut low, mut high) = (0.0, 1.0);
    while outside(surface, o + d * high) < 0.0 {
        (low, high) = (high, high * 2.0);
        if high > 1e6 {
            return None;
        }
    }
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if outside(surface, o + d * middle) < 0.0 { low = middle } else { high = middle }
    }
    Some(o + d * high)
}

#[test]
fn all_sixteen_pairs_of_stages() {
    let (center, radius) = (DVec3::new(0.5, -0.25, 1.0), 2.0);
    let eye = DVec3::new(0.3, 0.4, 9.0);
    let surfaces = [
        Intermediate::Sphere,
        Intermediate::Cylinder([-2.0, 4.0]),
        Intermediate::Plane,
        Intermediate::Cube(Layout::Strip),
    ];
    let rules = [
        Projection::Centroid,
        Projection::ObjectNormal,
        Projection::IntermediateNormal,
        Projection::ReflectedRay(eye),
    ];
    for (s, surface) in surfaces.into_iter().enumerate() {
        for (k, rule) in rules.into_iter().enumerate() {
            let map = TwoStage::new(surface, rule, center, radius, Axis::Z).expect("a map");
            // In units of the radius, about the centre.
            let ray = |p: DVec3, n: DVec3| {
                let o = (p - center) / radius;
                match k {
                    0 => (DVec3::ZERO, o),
                    1 => (o, n),
                    2 => (
                        o,
                        match s {
                            0 => o,
                            1 => DVec3::new(o.x, o.y, 0.0),
                            2 => DVec3::Z,
                            _ => Face::of(o).frame()[2],
                        },
                    ),
                    _ => {
                        let i = p - eye;
                        let n = n.normalize();
                        (o, i - n * (2.0 * n.dot(i)))
                    }
                }
            };
            let found = |p: DVec3, n: DVec3| {
                let (o, d) = ray(p, n);
                march(s, o, d.normalize())
            };
            let reference = |p, n| found(p, n).map_or(DVec2::NAN, |q| texture(s, q));
            // Away from the poles and edges of the surface, and not met at a grazing angle or far away.
            let regular = |p: DVec3, n: DVec3| {
                let o = (p - center) / radius;
                let steep = |q: DVec3| {
                    let d = ray(p, n).1.normalize();
                    (outside(s, q + d * 1e-3) - outside(s, q)) / 1e-3 > 0.2
                };
                let clear = |q: DVec3| match s {
                    0 | 1 => off_axis(q) && q.length() < 20.0,
                    2 => q.length() < 20.0,
                    _ => generic(q) && (k != 2 || generic(o)),
                };
                o.length() > 0.2
                    && (k != 2 || o.x.hypot(o.y) > 0.15)
                    && outside(s, o) < -0.05
                    && (p - eye).length() > 1.0
                    && found(p, n).is_some_and(|q| clear(q) && steep(q))
            };
            let sample = |r: &mut Random| (center + r.vector() * 1.8, r.direction() * (0.5 + r.unit()));
            let used = compare(&format!("stages {s} {k}"), &map, &reference, &regular, &sample, COUNT);
            assert!(used > COUNT / 10, "stages {s} {k}: only {used} points are regular");
            // A ray that does not meet the surface has no answer.
            let mut random = Random(11);
            for _ in 0..1000 {
                let (p, n) = sample(&mut random);
                let o = (p - center) / radius;
                if k != 2 && outside(s, o) < -0.05 && found(p, n).is_none() {
                    let got = map.at(&SurfacePoint::new(p).with_normal(n).moving(DVec3::X, DVec3::Y));
                    assert!(got.uv.is_nan() || got.uv.length() > 1e4, "{s} {k} {p} {n}: {got:?}");
                }
            }
        }
    }
    assert!(TwoStage::new(surfaces[0], rules[0], center, 0.0, Axis::Z).is_err());
    assert!(TwoStage::new(Intermediate::Cylinder([1.0, 1.0]), rules[0], center, 1.0, Axis::Z).is_err());
    assert!(TwoStage::new(surfaces[0], Projection::ReflectedRay(DVec3::NAN), center, 1.0, Axis::Z).is_err());
}

#[test]
fn inverses_come_back() {
    let planet = Stereographic::new(1.5 * PI).expect("a map");
    let fish = |model| Fisheye::new(model, 1.9 * PI).expect("a map");
    let cube = |layout| Cube::new(layout, DVec3::ZERO).expect("a map");
    let maps: Vec<(&str, Box<dyn Mapping>)> = vec![
        ("spherical", Box::new(Spherical::new(Axis::X, DVec3::ZERO).expect("a map"))),
        ("cylindrical", Box::new(Cylindrical::new(Axis::Y, DVec3::ONE, [2.0, -1.0]).expect("a map"))),
        ("equirect", Box::new(Equirect)),
        ("probe", Box::new(LightProbe)),
        ("sphere map", Box::new(SphereMap)),
        ("mirror ball", Box::new(MirrorBall)),
        ("stereographic", Box::new(planet)),
        ("equidistant", Box::new(fish(FisheyeModel::Equidistant))),
        ("equisolid", Box::new(fish(FisheyeModel::Equisolid))),
        ("perspective", Box::new(Perspective::new(2.0, 1.5).expect("a map"))),
        ("dual paraboloid", Box::new(DualParaboloid)),
        ("octahedral", Box::new(Octahedral)),
        ("cross", Box::new(cube(Layout::Cross))),
        ("strip", Box::new(cube(Layout::Strip))),
        ("stacked", Box::new(cube(Layout::Stacked))),
        ("linear", Box::new(Linear::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0).expect("a map"))),
        ("patch", Box::new(Patch::new([0.0, 2.0], [1.0, 3.0], [0.5, 0.75], [1.0, 0.0]).expect("a map"))),
    ];
    for (name, map) in &maps {
        assert!(map.has_inverse());
        let mut random = Random(5);
        let mut used = 0;
        for _ in 0..COUNT {
            // Off the rims, seams and edges, where two places are one direction.
            let uv = DVec2::new(0.001 + 0.998 * random.unit(), 0.001 + 0.998 * random.unit());
            let Some(inverse) = map.inverse_at(uv) else { continue };
            used += 1;
            let point = SurfacePoint::new(inverse.p).moving(inverse.du, inverse.dv);
            let back = map.at(&point);
            // At the rim of a disc a direction keeps half of the digits.
            assert!((back.uv - uv).length() < 1e-9, "{name} {uv}: {back:?}");
            // Mapping after its inverse: the identity, and so is the product of their derivatives.
            let m = back.jacobian.m;
            let off = (m[0][0] - 1.0).abs().max((m[1][1] - 1.0).abs()).max(m[0][1].abs()).max(m[1][0].abs());
            assert!(off < 1e-6, "{name} {uv}: {back:?}");
        }
        assert!(used > COUNT / 3, "{name}: {used}");
    }
    assert!(!Planar::new(Axis::Z, DVec3::ZERO, DVec3::ONE).expect("a map").has_inverse());
}

#[test]
fn poles_and_axes_have_their_rule() {
    let sphere = Spherical::new(Axis::Z, DVec3::ZERO).expect("a map");
    let inf = f64::INFINITY;
    for (z, slope) in [(2.0, 1.0), (-2.0, -1.0)] {
        let pole = SurfacePoint::new(DVec3::Z * z).moving(DVec3::X, DVec3::Z);
        let at = sphere.at(&pole);
        assert_eq!(at.uv.to_array(), [0.0, if z > 0.0 { 0.0 } else { 1.0 }]);
        assert_eq!(at.jacobian.m, [[inf, 0.0], [slope / (2.0 * PI), 0.0]]);
    }
    let tube = Cylindrical::new(Axis::Z, DVec3::ZERO, [0.0, 1.0]).expect("a map");
    let at = tube.at(&SurfacePoint::new(DVec3::Z * 0.5).moving(DVec3::Z, DVec3::new(0.0, 1e-300, 0.0)));
    assert_eq!((at.uv.to_array(), at.jacobian.m), ([0.0, 0.5], [[0.0, inf], [1.0, 0.0]]));
    // Within 1e-12 of a pole everything is finite and v is the same all round.
    for i in 0..64 {
        let (sin, cos) = (f64::from(i) / 64.0 * TAU).sin_cos();
        for z in [1.0, -1.0] {
            let p = SurfacePoint::new(DVec3::new(1e-12 * cos, 1e-12 * sin, z)).moving(DVec3::X, DVec3::Y);
            let at = sphere.at(&p);
            assert!(at.jacobian.is_finite() && (at.uv.y - if z > 0.0 { 0.0 } else { 1.0 }).abs() < 1e-12);
        }
    }
    // u never shows its jump: on both sides of the seam the Jacobian is the same.
    for map in [&sphere as &dyn Mapping, &tube] {
        let beside = |y: f64| {
            let at = map.at(&SurfacePoint::new(DVec3::new(1.0, y, 0.5)).moving(DVec3::Y, DVec3::Z));
            assert!((0.0..1.0).contains(&at.uv.x));
            at.jacobian.m
        };
        let (a, b) = (beside(1e-14), beside(-1e-14));
        assert!(a.as_flattened().iter().zip(b.as_flattened()).all(|(a, b)| (a - b).abs() < 1e-12));
    }
    assert_eq!(sphere.at(&SurfacePoint::new(DVec3::new(1.0, -1e-300, 0.0))).uv.x, 0.0);
    for map in [&LightProbe as &dyn Mapping, &SphereMap, &MirrorBall] {
        let front = if map.at(&SurfacePoint::new(DVec3::Z)).uv.x == 0.5 { 1.0 } else { -1.0 };
        let at = |z: f64| map.at(&SurfacePoint::new(DVec3::Z * z).moving(DVec3::X, DVec3::Z));
        assert_eq!(at(front).uv.to_array(), [0.5, 0.5]);
        assert!(at(front).jacobian.is_finite() && at(front).jacobian.m[0][0] > 0.0);
        assert_eq!(at(-front).jacobian.m, [[inf, 0.0], [inf, 0.0]]);
    }
}

/// Every map with numbers from a hostile set: no panic, no NaN in a Jacobian, uv finite or NaN.
#[test]
fn hostile_numbers_do_no_harm() {
    let odd =
        [0.0, -0.0, 1.0, -1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e-320, -1e-300, 1e300, -1.7e308];
    let (c, one) = (DVec3::ZERO, DVec3::ONE);
    let mut maps: Vec<Box<dyn Mapping>> = vec![
        Box::new(Planar::new(Axis::X, c, one).expect("a map")),
        Box::new(Facets::new(c, one).expect("a map")),
        Box::new(Cube::new(Layout::Cross, c).expect("a map")),
        Box::new(Spherical::new(Axis::Z, c).expect("a map")),
        Box::new(Cylindrical::new(Axis::Z, c, [0.0, 1.0]).expect("a map")),
        Box::new(Linear::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0).expect("a map")),
        Box::new(Equirect),
        Box::new(LightProbe),
        Box::new(SphereMap),
        Box::new(MirrorBall),
        Box::new(Octahedral),
        Box::new(DualParaboloid),
        Box::new(Stereographic::new(3.0).expect("a map")),
        Box::new(Fisheye::new(FisheyeModel::Equisolid, 6.0).expect("a map")),
        Box::new(Perspective::new(1.0, 1.0).expect("a map")),
        Box::new(Projective::new(DMat4::IDENTITY).expect("a map")),
        Box::new(Polygon::new(&[c, DVec3::X, DVec3::Y], &[DVec2::ZERO; 3]).expect("a map")),
    ];
    let surfaces = [
        Intermediate::Sphere,
        Intermediate::Cylinder([0.0, 1.0]),
        Intermediate::Plane,
        Intermediate::Cube(Layout::Cross),
    ];
    let eye = Projection::ReflectedRay(one);
    for surface in surfaces {
        for rule in [Projection::Centroid, Projection::ObjectNormal, Projection::IntermediateNormal, eye] {
            maps.push(Box::new(TwoStage::new(surface, rule, c, 1.0, Axis::Z).expect("a map")));
        }
    }
    let mut random = Random(1);
    for map in &maps {
        for _ in 0..20_000 {
            let mut pick = || odd[(random.unit() * odd.len() as f64) as usize];
            let mut vector = || DVec3::new(pick(), pick(), pick());
            let (p, n, dp, dn) = (vector(), vector(), [vector(), vector()], [vector(), vector()]);
            let got = map.at(&SurfacePoint { p, n, dp, dn });
            assert!(got.jacobian.m.iter().flatten().all(|x| !x.is_nan()), "{p} {n} {dp:?} {dn:?}: {got:?}");
            assert!(got.uv.is_finite() || got.uv.is_nan_mask().all(), "{p} {n}: {got:?}");
            let _ = map.inverse_at(DVec2::new(p.x, p.y));
        }
    }
}

#[test]
fn batches_are_the_single_points_for_any_thread_count() {
    let mut random = Random(9);
    let count = 10_001;
    let points: Vec<f64> = (0..3 * count).map(|_| random.signed()).collect();
    let moves: Vec<f32> = (0..3 * count).map(|_| random.signed() as f32).collect();
    let input = Input {
        points: Numbers::F64(&points),
        normals: None,
        dp: Some([Numbers::F32(&moves), Numbers::F32(&moves)]),
        dn: None,
    };
    let map = Spherical::new(Axis::Z, DVec3::ZERO).expect("a map");
    let run = |threads| {
        let (mut uv, mut j) = (vec![0.0; 2 * count], vec![0.0; 4 * count]);
        multum::par::with_threads(Some(threads), || {
            map_batch(&map, input, Output::F64(&mut uv), Some(Output::F64(&mut j)))
        })
        .expect("a batch");
        (uv, j)
    };
    let (uv, j) = run(1);
    assert!(run(2) == (uv.clone(), j.clone()) && run(7) == (uv.clone(), j.clone()));
    for i in [0, 4095, 4096, count - 1] {
        let d = DVec3::from_slice(&moves[3 * i..].iter().map(|x| f64::from(*x)).collect::<Vec<_>>());
        let at = map.at(&SurfacePoint::new(DVec3::from_slice(&points[3 * i..])).moving(d, d));
        assert_eq!((at.uv.x, at.uv.y), (uv[2 * i], uv[2 * i + 1]));
        assert_eq!(at.jacobian.m.as_flattened(), &j[4 * i..4 * i + 4]);
    }
    // u just below 1 rounds to 1 in single precision, which is the same place as 0.
    let mut single = [0f32; 2];
    let seam = Input { points: Numbers::F64(&[1.0, -1e-12, 0.0]), normals: None, dp: None, dn: None };
    map_batch(&map, seam, Output::F32(&mut single), None).expect("a batch");
    assert_eq!(single, [0.0, 0.5]);
    // Arrays that do not fit are refused.
    let mut uv = vec![0.0; 2];
    assert!(map_batch(&map, input, Output::F64(&mut uv), None).is_err());
    let facets = Facets::new(DVec3::ZERO, DVec3::ONE).expect("a map");
    assert!(map_batch(&facets, seam, Output::F64(&mut uv), None).is_err());
    assert!(inverse_batch(&facets, Numbers::F64(&[0.5, 0.5]), Output::F64(&mut [0.0; 3])).is_err());
}
