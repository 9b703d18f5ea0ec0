//! What the fuzzers call: each function takes any bytes, and must come back without a panic.
//!
//! `fuzz/fuzz_targets` hands them what libFuzzer finds; `tests/fuzz.rs` the corpus and mutations of it.
#![allow(dead_code)]

use multum::compat::cv2::maps::{Target, convert};
use multum::compat::cv2::read::{Manner, Pixel, Route, read};
use multum::compat::cv2::resize::{Scaling, resize};
use multum::compat::cv2::undistort::{Camera, Lens, tilt};
use multum::compat::cv2::{Rows, patch, pyramid};
use multum::encode::{Alpha, Encoding};
use multum::mesh::{Normals, Scene};
use multum::raster::{Attributes, Cull, Geometry, Options, rasterize};
use multum::warp::remap::Map;
use multum::warp::{Mapping, WarpOptions, warp};
use multum::{Extent, Filter, Image, Pixels, Sampler, Texture, TextureOptions, Wrap, files};

/// Numbers out of bytes; zeros after their end.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let mut taken = [0; N];
        let n = N.min(self.0.len());
        taken[..n].copy_from_slice(&self.0[..n]);
        self.0 = &self.0[n..];
        taken
    }

    /// A number below `n`.
    fn below(&mut self, n: usize) -> usize {
        usize::from(u16::from_le_bytes(self.take())) % n
    }

    /// Any single: NaN, infinities and denormals too.
    fn single(&mut self) -> f32 {
        f32::from_bits(u32::from_le_bytes(self.take()))
    }

    /// Any double.
    fn double(&mut self) -> f64 {
        f64::from_bits(u64::from_le_bytes(self.take()))
    }
}

/// The reader of images. What it accepts must be whole.
pub fn image(data: &[u8]) {
    if let Ok(image) = files::decode("fuzz", data) {
        assert!(image.width() > 0 && image.height() > 0 && image.channels() > 0);
    }
}

/// The readers of meshes: GLB by its first bytes, glTF by its brace, else OBJ. What they accept must hold
/// together.
pub fn mesh(data: &[u8]) {
    let first = data.iter().find(|b| !b.is_ascii_whitespace());
    let name = if first == Some(&b'{') { "nowhere/fuzz.gltf" } else { "nowhere/fuzz.obj" };
    if let Ok(scene) = Scene::decode(name, data, Normals::Auto) {
        scene.mesh.check().expect("a mesh that was read holds together");
    }
}

/// A texture of any small shape and kind, and samples of any place and footprint.
pub fn sample(data: &[u8]) {
    let mut bytes = Bytes(data);
    let (width, height, channels) = (1 + bytes.below(17), 1 + bytes.below(13), 1 + bytes.below(6));
    let count = width * height * channels;
    let pixels: Pixels = match bytes.below(4) {
        0 => (0..count).map(|i| (i * 37 % 256) as u8).collect::<Vec<_>>().into(),
        1 => (0..count).map(|i| (i * 6151 % 65_536) as u16).collect::<Vec<_>>().into(),
        2 => (0..count).map(|_| bytes.single()).collect::<Vec<_>>().into(),
        _ => (0..count).map(|_| bytes.double()).collect::<Vec<_>>().into(),
    };
    let Ok(image) = Image::new(width, height, channels, pixels) else { return };
    let wrap = [0; 2].map(|_| Wrap::NAMES[bytes.below(Wrap::NAMES.len())].1);
    let alpha = [Alpha::None, Alpha::Straight, Alpha::Premultiplied][bytes.below(3)];
    let encoding = [Encoding::Linear, Encoding::Srgb, Encoding::Normal][bytes.below(3)];
    let options = TextureOptions { wrap, alpha, encoding, ..TextureOptions::default() };
    let Ok(texture) = Texture::new(image.view(), options) else { return };
    let sampler = Sampler {
        filter: Filter::NAMES[bytes.below(Filter::NAMES.len())].1,
        max_anisotropy: f64::from(bytes.single()),
        lod_bias: bytes.single(),
        seed: u64::from_le_bytes(bytes.take()),
        ..Sampler::default()
    };
    let uv: [f32; 4] = std::array::from_fn(|_| bytes.single());
    let jacobian: [f32; 8] = std::array::from_fn(|_| bytes.single());
    let lod: [f32; 2] = std::array::from_fn(|_| bytes.single());
    let mut out = vec![0f32; 2 * channels];
    let _ = sampler.sample(&texture, &uv, Extent::Jacobian(&jacobian), &mut out);
    let _ = sampler.sample(&texture, &uv, Extent::Lod(&lod), &mut out);
    let _ = sampler.sample(&texture, &uv, Extent::Point, &mut out);
}

/// Wrapping of any index and coordinate.
pub fn wrap(data: &[u8]) {
    let mut bytes = Bytes(data);
    let n = 1 + i64::from(u32::from_le_bytes(bytes.take()) & 0x3fff_ffff);
    let i = i64::from_le_bytes(bytes.take()) >> 2;
    let s = bytes.double();
    for (name, mode) in Wrap::NAMES {
        if let Some(at) = mode.index(i, n) {
            assert!((-1..=n).contains(&at), "{name} {i} of {n}: {at}");
        }
        let (reduced, sign) = mode.reduce(s, n as f64);
        assert!(sign.abs() == 1.0);
        assert!(mode.period(n as f64).is_none() || !s.is_finite() || (0.0..=n as f64).contains(&reduced));
    }
}

/// Triangles of any corners, drawn and interpolated.
pub fn raster(data: &[u8]) {
    let mut bytes = Bytes(data);
    let size = (1 + bytes.below(48), 1 + bytes.below(48));
    let vertices = 3 + bytes.below(6);
    let faces: Vec<[u32; 3]> =
        (0..1 + bytes.below(6)).map(|_| [0; 3].map(|_| bytes.below(vertices + 1) as u32)).collect();
    let cull = [Cull::None, Cull::Back, Cull::Front][bytes.below(3)];
    let samples = [0, 4, 8, 16, 3][bytes.below(5)];
    let positions: Vec<[f64; 4]> = (0..vertices).map(|_| [0; 4].map(|_| f64::from(bytes.single()))).collect();
    let Ok(geometry) = Geometry::new(positions, faces) else { return };
    let Ok(fragments) = rasterize(&geometry, size, &Options { cull, samples, behind: None }) else { return };
    let last = geometry.faces().len() as i32;
    assert!(fragments.triangle().iter().all(|t| (-1..last).contains(t)));
    let values: Vec<f32> = (0..2 * vertices).map(|i| i as f32).collect();
    let attributes = Attributes::Vertex { data: &values, channels: 2 };
    fragments
        .interpolate_with_derivatives(&geometry, attributes, 0.0)
        .expect("fragments can be interpolated");
}

/// Warps of any matrix and map.
pub fn warps(data: &[u8]) {
    let mut bytes = Bytes(data);
    let (width, height) = (1 + bytes.below(12), 1 + bytes.below(12));
    let pixels: Vec<u8> = (0..width * height).map(|i| (i * 37 % 256) as u8).collect();
    let Ok(image) = Image::new(width, height, 1, pixels) else { return };
    let wrap_modes = [0; 2].map(|_| Wrap::NAMES[bytes.below(Wrap::NAMES.len())].1);
    let filter = Filter::NAMES[bytes.below(Filter::NAMES.len())].1;
    let options = WarpOptions { wrap: wrap_modes, sampler: Sampler::new(filter), ..WarpOptions::default() };
    let matrix = [[0; 3]; 3].map(|row| row.map(|_| bytes.double()));
    let _ =
        warp(image.view(), &Mapping::from_matrix(matrix), 1 + bytes.below(6), 1 + bytes.below(6), &options);
    let places: [f32; 24] = std::array::from_fn(|_| bytes.single());
    let maps = multum::warp::Maps::pairs(&places, [None, Some(f64::from(bytes.single()))]);
    let _ = warp(image.view(), &Mapping::Single(maps), 4, 3, &options);
}

/// The drop-ins for OpenCV, on a picture of any small shape and any numbers.
pub fn compat(data: &[u8]) {
    let mut bytes = Bytes(data);
    match bytes.below(3) {
        0 => compat_of::<u8>(&mut bytes, |b| b.take::<1>()[0]),
        1 => compat_of::<i16>(&mut bytes, |b| i16::from_le_bytes(b.take())),
        _ => compat_of::<f32>(&mut bytes, |b| b.single()),
    }
}

fn compat_of<T: Pixel + pyramid::Element>(bytes: &mut Bytes<'_>, number: fn(&mut Bytes<'_>) -> T) {
    let (width, height, channels) = (1 + bytes.below(9), 1 + bytes.below(9), 1 + bytes.below(5));
    let stride = width * channels + bytes.below(3);
    let pixels: Vec<T> = (0..stride * height).map(|_| number(bytes)).collect();
    let source = Rows::new(&pixels, width, height, channels, stride).expect("a picture in its slice");
    let border: Vec<T> = (0..channels).map(|_| number(bytes)).collect();
    let route = [Route::Map, Route::Affine, Route::Exact][bytes.below(3)];
    let (kind, edge, antialias) = (bytes.below(8) as i32, bytes.below(7) as i32, bytes.below(2) == 0);
    let (w, h) = (1 + bytes.below(9), 1 + bytes.below(9));
    let mut out = vec![T::default(); w * h * channels];
    let places: Vec<f32> = (0..2 * w * h).map(|_| bytes.single()).collect();
    let matrix: [f64; 9] = std::array::from_fn(|_| bytes.double());
    let (mut whole, mut codes) = (vec![0; 2 * w * h], vec![0; w * h]);
    convert(&Map::SinglePairs(&places), Target::Fixed(&mut whole, Some(&mut codes))).expect("sizes fit");
    if let Ok(manner) = Manner::new(kind, edge, route, antialias) {
        let maps = [Map::SinglePairs(&places), Map::Matrix(&matrix), Map::Fixed(&whole, Some(&codes))];
        for map in &maps {
            read(&source, map, &manner, &border, w, &mut out).expect("sizes fit");
        }
    }
    let center = [bytes.double(), bytes.double()];
    patch::patch(&source, [w, h], center, &mut out).expect("sizes fit");
    if let Ok(to) = Scaling::new([width, height], Some([w as i64, h as i64]), [0.0; 2]) {
        let _ = resize(&source, &to, kind, antialias, &mut out);
    }
    let factors = [bytes.double(), bytes.double()];
    if let Ok(to) = Scaling::new([width, height], None, factors)
        && to.size[0] * to.size[1] < 4096
    {
        let mut out = vec![T::default(); to.size[0] * to.size[1] * channels];
        let _ = resize(&source, &to, kind, antialias, &mut out);
    }
    let lens = Lens::Standard(std::array::from_fn(|_| bytes.double()), tilt(bytes.double(), bytes.double()));
    let camera = Camera { focal: center, center: factors, lens, inverse: matrix };
    let mut seen = vec![T::default(); width * height * channels];
    camera.undistort(&source, antialias, &mut seen).expect("sizes fit");
}
