//! Meshes from files: small ones written here, real ones, and damaged ones.
#![cfg(feature = "mesh")]

use multum::encode::Encoding;
use multum::mesh::{AlphaMode, Camera, ImageSource, Mesh, Normals, Projection, Scene, smooth_normals};
use multum::{Error, Wrap};
use proptest::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A folder of its own that goes away at the end.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Self {
        static NEXT: AtomicUsize = AtomicUsize::new(0);
        let name = format!("multum-mesh-{}-{}", std::process::id(), NEXT.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(name);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        fs::write(&path, bytes).unwrap();
        path
    }

    fn open(&self, name: &str, bytes: impl AsRef<[u8]>) -> multum::Result<Scene> {
        Scene::open(self.write(name, bytes), Normals::Auto)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn data() -> Option<PathBuf> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = std::env::var_os("MULTUM_DATA").map_or_else(|| here.join("../shared/data"), PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    println!("the real models are absent: set MULTUM_DATA to their folder");
    None
}

fn le(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// A square in the plane z = 0 whose picture has its upper left corner at (-1, 1): positions, uv, indices.
fn square_bytes() -> Vec<u8> {
    let mut bytes = le(&[-1., 1., 0., 1., 1., 0., 1., -1., 0., -1., -1., 0.]);
    bytes.extend(le(&[0., 0., 1., 0., 1., 1., 0., 1.]));
    bytes.extend([0u16, 3, 1, 1, 3, 2].iter().flat_map(|i| i.to_le_bytes()));
    bytes
}

const VIEWS: &str = r#""bufferViews": [
    {"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 32},
    {"buffer": 0, "byteOffset": 80, "byteLength": 12}],
  "accessors": [
    {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1,-1,0], "max": [1,1,0]},
    {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
    {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"}]"#;
const SQUARE: &str = r#"{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}"#;

/// A glTF file around the square; `rest` has nodes, materials and so on.
fn gltf(buffer_uri: &str, primitive: &str, rest: &str) -> String {
    let uri = if buffer_uri.is_empty() { String::new() } else { format!(r#", "uri": "{buffer_uri}""#) };
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"byteLength": 92{uri}}}], {VIEWS},
  "meshes": [{{"primitives": [{primitive}]}}], "scenes": [{{"nodes": [0]}}], {rest}}}"#
    )
}

const PLAIN: &str = r#""nodes": [{"mesh": 0}], "materials": [{}]"#;

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::new();
    for chunk in bytes.chunks(3) {
        let word = (0..3).fold(0u32, |w, k| w << 8 | u32::from(*chunk.get(k).unwrap_or(&0)));
        for k in 0..4 {
            let digit = DIGITS[(word >> (18 - 6 * k)) as usize & 63] as char;
            out.push(if k <= chunk.len() { digit } else { '=' });
        }
    }
    out
}

fn data_uri(bytes: &[u8]) -> String {
    format!("data:application/octet-stream;base64,{}", base64(bytes))
}

fn glb(json: &str, bin: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut out = b"glTF".to_vec();
    let total = 12 + 8 + json.len() + 8 + bin.len();
    for number in [2, total as u32, json.len() as u32] {
        out.extend(number.to_le_bytes());
    }
    out.extend(b"JSON");
    out.extend(json);
    out.extend((bin.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(bin);
    out
}

#[test]
fn one_square_from_files_glb_data_uris_and_obj_is_the_same_mesh() {
    let folder = Folder::new();
    folder.write("a b.bin", square_bytes());
    let by_file = folder.open("file.gltf", gltf("a%20b.bin", SQUARE, PLAIN)).unwrap().mesh;
    let by_glb = folder.open("x.glb", glb(&gltf("", SQUARE, PLAIN), &square_bytes())).unwrap().mesh;
    let by_uri = folder.open("uri.gltf", gltf(&data_uri(&square_bytes()), SQUARE, PLAIN)).unwrap().mesh;
    assert_eq!(by_file, by_glb);
    assert_eq!(by_file, by_uri);
    // v runs up in OBJ.
    let obj = "v -1 1 0\nv 1 1 0\nv 1 -1 0\nv -1 -1 0\nvt 0 1\nvt 1 1\nvt 1 0\nvt 0 0\nf 1/1 4/4 2/2\nf 2/2 4/4 3/3\n";
    let by_obj = folder.open("x.obj", obj).unwrap().mesh;
    let corners = |m: &Mesh| -> Vec<_> {
        let row = |v: &u32| {
            let v = *v as usize;
            (m.positions[v], m.normals[v], m.tangents[v], m.uv[0][v])
        };
        m.faces.iter().flatten().map(row).collect()
    };
    assert_eq!(corners(&by_file), corners(&by_obj));
    let upper_left = corners(&by_obj)[0];
    // Normal to the viewer, tangent to the right, bitangent up.
    assert_eq!(upper_left, ([-1., 1., 0.], [0., 0., 1.], [1., 0., 0., 1.], [0., 0.]));
}

#[test]
fn nodes_place_their_meshes_and_mirrors_turn_the_winding() {
    let folder = Folder::new();
    // A quarter turn about y below a move by 5 in x, and a mirror in x.
    let rest = r#""materials": [{}], "nodes": [{"children": [1, 2], "translation": [5, 0, 0]},
        {"mesh": 0, "rotation": [0, 0.70710678, 0, 0.70710678]}, {"mesh": 0, "scale": [-2, 1, 1]}]"#;
    let mesh = folder.open("x.gltf", gltf(&data_uri(&square_bytes()), SQUARE, rest)).unwrap().mesh;
    assert_eq!(mesh.faces.len(), 4);
    let close = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    let corner = |f: usize, c: usize| mesh.faces[f][c] as usize;
    assert!(close(mesh.positions[corner(0, 0)], [5., 1., 1.]), "{:?}", mesh.positions[corner(0, 0)]);
    assert!(close(mesh.normals[corner(0, 0)], [1., 0., 0.]));
    assert!(close(mesh.positions[corner(2, 0)], [7., 1., 0.]));
    // Mirrored, the square still faces +z, and its picture is seen from behind: the frame's sign is -1.
    assert!(close(mesh.normals[corner(2, 0)], [0., 0., 1.]));
    let [x, y, z, w] = mesh.tangents[corner(2, 0)];
    assert!(close([x, y, z], [-1., 0., 0.]) && w == -1.0);
    for face in &mesh.faces {
        let p = face.map(|v| mesh.positions[v as usize]);
        let e = |k: usize| -> [f32; 3] { std::array::from_fn(|i| p[k][i] - p[0][i]) };
        let (a, b) = (e(1), e(2));
        let n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        let given = mesh.normals[face[0] as usize];
        assert!(n.iter().zip(given).map(|(a, b)| a * b).sum::<f32>() > 0.0, "winding agrees with normals");
    }
}

#[test]
fn materials_samplers_and_extensions_are_read() {
    let folder = Folder::new();
    let rest = r#""nodes": [{"mesh": 0}], "extensionsUsed": ["KHR_texture_transform", "KHR_materials_unlit"],
      "images": [{"uri": "a.png"}, {"bufferView": 1, "mimeType": "image/png", "name": "inside"}],
      "samplers": [{"magFilter": 9728, "minFilter": 9985, "wrapS": 33071, "wrapT": 33648}, {"minFilter": 9987}],
      "textures": [{"source": 0, "sampler": 0}, {"source": 1}, {"source": 0, "sampler": 1}],
      "materials": [{"name": "m", "doubleSided": true, "alphaMode": "MASK", "alphaCutoff": 0.25,
        "pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0.25, 0.75], "roughnessFactor": 0.5,
          "baseColorTexture": {"index": 0, "texCoord": 1, "extensions": {"KHR_texture_transform":
            {"offset": [0.5, 0.25], "rotation": 1.57079632679, "scale": [2, 3], "texCoord": 0}}},
          "metallicRoughnessTexture": {"index": 1}},
        "normalTexture": {"index": 2, "scale": 0.5, "extensions": {"KHR_texture_transform": {"scale": [4, 5]}}},
        "extensions": {"KHR_materials_unlit": {}}}, {"alphaMode": "BLEND"}]"#;
    let mesh = folder.open("x.gltf", gltf(&data_uri(&square_bytes()), SQUARE, rest)).unwrap().mesh;
    let m = &mesh.materials[0];
    assert_eq!((m.name.as_str(), m.double_sided, m.unlit), ("m", true, true));
    assert_eq!(
        (m.alpha_mode, m.base_color, m.roughness),
        (AlphaMode::Mask(0.25), [1.0, 0.5, 0.25, 0.75], 0.5)
    );
    assert_eq!(mesh.materials[1].alpha_mode, AlphaMode::Blend);
    let base = m.base_color_texture.as_ref().unwrap();
    assert_eq!((base.image, base.uv_set, base.encoding), (0, 0, Encoding::Srgb));
    assert_eq!(base.wrap, [Wrap::Clamp, Wrap::Mirror]);
    assert_eq!((base.mag_filter, base.min_filter), (Some("nearest"), Some("linear_mipmap_nearest")));
    // Scale first, then a quarter turn that takes +u to -v (up in the picture), then the move.
    let at = |[u, v]: [f32; 2]| base.transform.map(|[a, b, c]| a * u + b * v + c);
    let close = |a: [f32; 2], b: [f32; 2]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    assert!(close(at([0., 0.]), [0.5, 0.25]));
    assert!(close(at([1., 0.]), [0.5, -1.75]), "{:?}", at([1., 0.]));
    assert!(close(at([0., 1.]), [3.5, 0.25]));
    let roughness = m.metallic_roughness_texture.as_ref().unwrap();
    assert_eq!((roughness.encoding, roughness.wrap), (Encoding::Linear, [Wrap::Repeat; 2]));
    assert_eq!((roughness.mag_filter, roughness.min_filter), (None, None));
    let normal = m.normal_texture.as_ref().unwrap();
    assert_eq!(
        (normal.encoding, m.normal_scale, normal.min_filter),
        (Encoding::Normal, 0.5, Some("trilinear"))
    );
    assert_eq!(normal.transform, [[4.0, 0.0, 0.0], [0.0, 5.0, 0.0]]);
    assert_eq!(mesh.images[0], ImageSource::File(folder.0.join("a.png")));
    assert!(
        matches!(&mesh.images[1], ImageSource::Embedded { name, bytes } if name == "inside" && bytes.len() == 32)
    );
}

#[test]
fn strips_and_fans_become_triangles_and_lines_are_left_out() {
    let folder = Folder::new();
    let faces = |mode: u32| {
        let primitive = format!(r#"{{"attributes": {{"POSITION": 0}}, "mode": {mode}}}"#);
        folder.open("x.gltf", gltf(&data_uri(&square_bytes()), &primitive, PLAIN)).unwrap().mesh
    };
    let corners = |m: Mesh| -> Vec<[f32; 2]> {
        m.faces.iter().flatten().map(|&v| [m.positions[v as usize][0], m.positions[v as usize][1]]).collect()
    };
    let [a, b, c, d] = [[-1., 1.], [1., 1.], [1., -1.], [-1., -1.]];
    assert_eq!(corners(faces(5)), [a, b, c, b, d, c]);
    assert_eq!(corners(faces(6)), [b, c, a, c, d, a]);
    assert!(corners(faces(1)).is_empty());
    assert_eq!(corners(faces(4)), [a, b, c]);
}

#[test]
fn cameras_are_read_and_made() {
    let folder = Folder::new();
    let rest = r#""materials": [{}], "nodes": [{"children": [1, 2]}, {"mesh": 0},
          {"camera": 0, "translation": [0, 0, 4], "scale": [2, 2, 2]}],
        "cameras": [{"type": "perspective", "name": "eye",
          "perspective": {"yfov": 1.57079632679, "znear": 1, "zfar": 9}}]"#;
    let scene = folder.open("x.gltf", gltf(&data_uri(&square_bytes()), SQUARE, rest)).unwrap();
    let camera = scene.camera();
    assert_eq!((camera.name.as_str(), camera.eye()), ("eye", [0.0, 0.0, 4.0]));
    assert!(matches!(camera.projection, Projection::Perspective { near: 1.0, far: 9.0, .. }));
    let close = |a: [f64; 4], b: [f64; 4]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    // On the near plane, half-way to the top, in a picture twice as wide as high.
    let clip = camera.project(&[[1., 0.5, 3.], [0., 0., -5.]], 200, 100);
    assert!(close(clip[0], [0.5, 0.5, -1., 1.]) && close(clip[1], [0., 0., 9., 9.]), "{clip:?}");
    let plain = folder.open("y.gltf", gltf(&data_uri(&square_bytes()), SQUARE, PLAIN)).unwrap();
    for size in [(100, 100), (300, 100), (100, 300)] {
        for v in plain.camera().project(&plain.mesh.positions, size.0, size.1) {
            assert!(v[..3].iter().all(|c| c.abs() < v[3]), "{v:?} is seen");
        }
    }
    let empty = Camera::framing(&Mesh::default());
    assert!(empty.matrix(10, 10).iter().flatten().all(|c| c.is_finite()));
}

#[test]
fn obj_statements_that_people_write_are_read() {
    let folder = Folder::new();
    folder.write(
        "a b.mtl",
        "newmtl red paint\t\n\tKd 1 0 0\nKs .5 .5 .5\nNs 20\nd 0.5\nmap_Kd -s 2 3 1 my picture.png\n\
         map_Bump -bm 0.25 height.png\nmap_d mask.png\nnewmtl other\nKd 0 1 0\nTr 0\nmap_Kd my picture.png\n",
    );
    let obj = "\u{feff}# a comment\nmtllib a b.mtl\n  v 0 0 0\nv\t1 0 0\nv 1 1 0 \nv 0 1 0\nvt 0 0\nvt 1 0 0\nvt 1 1\n\
        usemtl  red paint\nf 1/1 2/2 \\\n 3/3\nusemtl other\nf -4/-3 -2/-1 -1\no next\nf 1 2 3 4\n";
    let mesh = folder.open("x.obj", obj).unwrap().mesh;
    assert_eq!((mesh.faces.len(), mesh.face_material.as_slice()), (4, &[0, 1, 1, 1][..]));
    let red = &mesh.materials[0];
    assert_eq!((red.name.as_str(), red.base_color, red.shininess), ("red paint", [1., 0., 0., 0.5], 20.0));
    assert_eq!((red.specular, red.bump_scale, red.alpha_mode), ([0.5; 3], 0.25, AlphaMode::Blend));
    let base = red.base_color_texture.as_ref().unwrap();
    // Twice in u; three times in v about the bottom, where v is 1 here.
    assert_eq!((base.transform, base.encoding), ([[2., 0., 0.], [0., 3., -2.]], Encoding::Srgb));
    assert_eq!(mesh.images[base.image], ImageSource::File(folder.0.join("my picture.png")));
    assert_eq!(mesh.materials[1].base_color_texture.as_ref().unwrap().image, base.image);
    assert_eq!(mesh.materials[1].alpha_mode, AlphaMode::Opaque);
    assert_eq!(red.bump_texture.as_ref().unwrap().encoding, Encoding::Linear);
    // A missing library leaves the geometry.
    let alone = folder.open("y.obj", "mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap().mesh;
    assert_eq!((alone.faces.len(), alone.materials.len(), alone.uv.len()), (1, 1, 0));
}

#[test]
fn smooth_normals_weigh_by_angle_and_cross_uv_seams() {
    // A cube, every side cut differently, vertices not shared: at corners the normal is the diagonal.
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    for axis in 0..3 {
        for side in [-1.0f32, 1.0] {
            let first = positions.len() as u32;
            for [a, b] in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0f32]] {
                let mut p = [0.0; 3];
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, a * side, b);
                positions.push(p);
            }
            faces.extend([[0, 1, 2], [0, 2, 3]].map(|f: [u32; 3]| f.map(|v| v + first)));
        }
    }
    let normals = smooth_normals(&positions, &faces).unwrap();
    for (p, n) in positions.iter().zip(&normals) {
        assert!(p.iter().zip(n).all(|(p, n)| (p / 3f32.sqrt() - n).abs() < 1e-6), "{p:?} {n:?}");
    }
    assert!(smooth_normals(&positions, &[[0, 1, 99]]).is_err());
    // Faces without area, and a place without a face, point to +z.
    assert_eq!(smooth_normals(&[[0.; 3]; 4], &[[0, 1, 2]]).unwrap(), [[0., 0., 1.]; 4]);
}

#[test]
fn mirrored_uv_splits_vertices_and_keeps_each_side_right() {
    // Two squares side by side, the picture mirrored at the shared edge x = 0.
    let obj = "v -1 0 0\nv 0 0 0\nv 1 0 0\nv -1 1 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\n\
        f 1/1 2/2 5/4\nf 1/1 5/4 4/3\nf 2/2 3/1 6/3\nf 2/2 6/3 5/4\n";
    let mesh = Folder::new().open("x.obj", obj).unwrap().mesh;
    assert_eq!(mesh.positions.len(), 8, "the two shared vertices are split");
    for (f, expected) in
        [[1., 0., 0., 1.], [1., 0., 0., 1.], [-1., 0., 0., -1.], [-1., 0., 0., -1.]].into_iter().enumerate()
    {
        for v in mesh.faces[f] {
            assert_eq!(mesh.tangents[v as usize], expected, "face {f}");
        }
    }
}

#[test]
fn what_leaves_the_folder_or_does_not_fit_is_refused_by_name() {
    let folder = Folder::new();
    let refused = |name: &str, content: String, words: &str| match folder.open(name, content) {
        Err(error) => {
            let text = error.to_string();
            assert!(matches!(error, Error::File { .. }) && text.contains(words), "{text}");
        }
        Ok(_) => panic!("{words}: accepted"),
    };
    let uri = data_uri(&square_bytes());
    for bad in
        ["../a.bin", "/etc/passwd", "file:///etc/passwd", "https://host/a.bin", "x/../../a", "%2e%2e/a"]
    {
        refused("x.gltf", gltf(bad, SQUARE, PLAIN), "URI");
        let image = format!(r#"{PLAIN}, "images": [{{"uri": "{bad}"}}]"#);
        refused("x.gltf", gltf(&uri, SQUARE, &image), "URI");
    }
    folder.write("bad.mtl", "newmtl m\nmap_Kd ../../secret.png\n");
    refused("x.obj", "mtllib bad.mtl\nv 0 0 0\nf 1 1 1\n".into(), "URI");
    let short = data_uri(&square_bytes()[..60]);
    refused("x.gltf", gltf(&short, SQUARE, PLAIN), "buffer 0 has 60 bytes");
    let wide = gltf(&uri, SQUARE, PLAIN).replace(r#""count": 6"#, r#""count": 9"#);
    refused("x.gltf", wide, "indices: 9 elements");
    let many = gltf(&uri, SQUARE, PLAIN)
        .replace(r#""count": 4, "type": "VEC2""#, r#""count": 4294967296, "type": "VEC2""#);
    refused("x.gltf", many, "at most");
    let mut bytes = square_bytes();
    bytes[80] = 4;
    refused("x.gltf", gltf(&data_uri(&bytes), SQUARE, PLAIN), "index 4 of 4 vertices");
    let mut bytes = square_bytes();
    bytes[..4].copy_from_slice(&f32::NAN.to_le_bytes());
    refused("x.gltf", gltf(&data_uri(&bytes), SQUARE, PLAIN), "not finite");
    let cycle = r#""materials": [{}], "nodes": [{"mesh": 0, "children": [1]}, {"children": [0]}]"#;
    refused("x.gltf", gltf(&uri, SQUARE, cycle), "tree");
    refused("x.gltf", "{}".into(), "glTF");
    refused("x.gltf", String::new(), "glTF");
    refused("x.stl", "solid".into(), "unknown kind");
    refused("x.obj", "v 0 0 0\nf 1 2 3\n".into(), "OBJ");
    refused("x.obj", "v 0 nan 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n".into(), "not finite");
    refused("x.obj", "v 0 0 0\nvt 0 0\nf 1/9223372036854775807 1/1 1/1\n".into(), "too large");
    assert!(matches!(Scene::open(folder.0.join("none.glb"), Normals::Auto), Err(Error::Io { .. })));
    assert!(matches!(Scene::open(&folder.0, Normals::Auto), Err(Error::File { .. })));
}

#[test]
fn a_small_file_cannot_unfold_without_bound() {
    let folder = Folder::new();
    // A sparse accessor without data of its own is zeros but for one vertex.
    let sparse = r#"{"componentType": 5126, "count": 30000000, "type": "VEC3", "min": [-1,-1,0], "max": [1,1,0],
        "sparse": {"count": 1, "indices": {"bufferView": 2, "componentType": 5123}, "values": {"bufferView": 0}}},
        {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"}"#;
    let json = gltf(&data_uri(&square_bytes()), r#"{"attributes": {"POSITION": 0}}"#, PLAIN);
    let start = json.find(r#""accessors": ["#).unwrap() + 14;
    let end = start + json[start..].find("}]").unwrap();
    let json = format!("{}{sparse}{}", &json[..start], &json[end + 1..]);
    assert!(folder.open("y.gltf", json.replace("30000000", "6")).unwrap().mesh.faces.len() == 2);
    let error = folder.open("x.gltf", json).unwrap_err();
    assert!(error.to_string().contains("at most"), "{error}");
}

#[test]
fn real_models_load_with_the_expected_counts() {
    let Some(data) = data() else { return };
    // Triangles and materials with a face.
    for (name, triangles, sets) in [
        ("gltf/FlightHelmet/FlightHelmet.gltf", 94_722, 1),
        ("gltf/SheenChair/MixedLightingExample.gltf", 40_898, 2),
        ("gltf/BoxTextured/BoxTextured.gltf", 12, 1),
        ("gltf/Fox.glb", 576, 1),
        ("gltf/AlphaBlendModeTest.glb", 61, 1),
        ("obj/fuze/fuze.obj", 1_000, 1),
        ("obj/asteroid/asteroid-low.obj", 480, 1),
        ("obj/asteroid/asteroid-high.obj", 48_000, 0),
    ] {
        let scene = Scene::open(data.join(name), Normals::Auto).unwrap();
        let mesh = &scene.mesh;
        assert_eq!((mesh.faces.len(), mesh.uv.len()), (triangles, sets), "{name}");
        let unit = |v: &[f32]| (v.iter().map(|c| c * c).sum::<f32>() - 1.0).abs() < 1e-2;
        assert!(mesh.normals.iter().all(|n| unit(n)), "{name}");
        assert!(mesh.tangents.iter().all(|t| unit(&t[..3]) && t[3].abs() == 1.0), "{name}");
        for image in &mesh.images {
            match image {
                ImageSource::File(path) => assert!(path.is_file(), "{path:?}"),
                ImageSource::Embedded { bytes, .. } => assert!(bytes.len() > 1000),
                ImageSource::Missing(reason) => panic!("{reason}"),
                ImageSource::Pixels(_) => panic!("files hold no decoded pixels"),
            }
        }
        let visible = scene.camera().project(&mesh.positions, 64, 64);
        assert!(visible.iter().any(|v| v[..3].iter().all(|c| c.abs() <= v[3])), "{name} is in view");
    }
    let fuze = Scene::open(data.join("obj/fuze/fuze.obj"), Normals::Auto).unwrap().mesh;
    assert!(matches!(&fuze.images[0], ImageSource::File(p) if p.ends_with("fuze uv.jpg")));
    let alpha = Scene::open(data.join("gltf/AlphaBlendModeTest.glb"), Normals::Auto).unwrap().mesh;
    let modes: Vec<_> = alpha.materials.iter().map(|m| m.alpha_mode).collect();
    for mode in [AlphaMode::Mask(0.25), AlphaMode::Mask(0.5), AlphaMode::Mask(0.75), AlphaMode::Blend] {
        assert!(modes.contains(&mode), "{mode:?} in {modes:?}");
    }
    let chair =
        Scene::open(data.join("gltf/SheenChair/MixedLightingExample.gltf"), Normals::Auto).unwrap().mesh;
    let moved = chair.materials.iter().filter_map(|m| m.base_color_texture.as_ref());
    assert!(moved.clone().any(|t| (t.transform[0][0] - 3.0 * 0.0873f32.cos()).abs() < 1e-3));
}

#[test]
fn made_tangents_agree_with_those_that_a_model_brings() {
    let Some(data) = data() else { return };
    let path = data.join("gltf/FlightHelmet/FlightHelmet.gltf");
    let given = Scene::open(&path, Normals::Auto).unwrap().mesh;
    // The same file without its tangents.
    let folder = Folder::new();
    folder.write("FlightHelmet.bin", fs::read(path.with_extension("bin")).unwrap());
    let json = fs::read_to_string(&path).unwrap().replace("\"TANGENT\"", "\"_OLD\"");
    let made = folder.open("x.gltf", json).unwrap().mesh;
    assert_eq!(given.faces.len(), made.faces.len());
    let (mut same, mut total) = (0, 0);
    for (f, g) in given.faces.iter().flatten().zip(made.faces.iter().flatten()) {
        let (a, b) = (given.tangents[*f as usize], made.tangents[*g as usize]);
        let cosine: f32 = (0..3).map(|k| a[k] * b[k]).sum();
        same += usize::from(cosine > 0.97 && a[3] == b[3]);
        total += 1;
    }
    assert!(same * 100 > total * 98, "{same} of {total} corners agree");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Cut and flipped files: an answer or an error, never a panic; an answer is a mesh that holds together.
    #[test]
    fn damaged_files_are_errors_or_sound_meshes(
        kind in 0..4usize,
        cut in 0.0..1.3f64,
        flips in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
    ) {
        let folder = Folder::new();
        folder.write("m.mtl", "newmtl m\nKd 1 0 0\nmap_Kd a b.png\n");
        let json = gltf(&data_uri(&square_bytes()), SQUARE, PLAIN);
        let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nusemtl m\nf 1/1/1 2/1/1 3/1/1\nf 1 2 3\n";
        let (name, mut bytes) = match kind {
            0 => ("x.glb", glb(&gltf("", SQUARE, PLAIN), &square_bytes())),
            1 => ("x.gltf", json.into_bytes()),
            2 => ("x.obj", obj.as_bytes().to_vec()),
            // Damage in the binary chunk alone.
            _ => {
                let mut bin = square_bytes();
                for (at, value) in &flips {
                    let at = at.index(bin.len());
                    bin[at] ^= value;
                }
                ("y.glb", glb(&gltf("", SQUARE, PLAIN), &bin))
            }
        };
        if kind < 3 {
            for (at, value) in &flips {
                let at = at.index(bytes.len());
                bytes[at] ^= value;
            }
            if cut < 1.0 {
                bytes.truncate((bytes.len() as f64 * cut) as usize);
            }
        }
        for normals in [Normals::Auto, Normals::Smooth] {
            if let Ok(scene) = Scene::open(folder.write(name, &bytes), normals) {
                prop_assert!(scene.mesh.check().is_ok());
            }
        }
    }
}
