//! glTF 2.0: JSON with buffers in files, GLB or data URIs, by the crate `gltf`.
//!
//! Animations, skins and morph targets are not applied: meshes stand as their nodes put them. Lines and
//! points are left out. A node must have one parent at most, as the specification says.

use super::accessor::Buffers;
use super::material::{AlphaMode, ImageSource, Material, Model, TextureSlot};
use super::normals::{Normals, unit};
use super::uri::{Target, resolve};
use super::{Camera, Light, Mesh, Part, Projection, Scene, scene::read_file};
use crate::encode::Encoding;
use crate::wrap::Wrap;
use gltf::json::Value;
use gltf::texture::{MagFilter, MinFilter, WrappingMode};
use std::path::Path;

type Matrix = [[f64; 4]; 4];
const IDENTITY: Matrix =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// The mesh, cameras and lights of the default scene.
pub(super) fn load(folder: &Path, bytes: &[u8], normals: Normals) -> std::result::Result<Scene, String> {
    if bytes.starts_with(b"glTF") {
        // The crate subtracts the header's size from this length.
        let length = bytes.get(8..12).and_then(|b| b.try_into().ok()).map_or(0, u32::from_le_bytes);
        if length < 20 {
            return Err("a GLB file that ends in its header".into());
        }
    }
    let invalid = |e: gltf::Error| format!("no valid glTF 2.0 ({e})");
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice_without_validation(bytes).map_err(invalid)?;
    let mut json = document.into_json();
    // Integers as coordinates, which the crate does not know of and `accessor` reads.
    json.extensions_required.retain(|name| name != "KHR_mesh_quantization");
    // The crate's own validation reads these accessors before it looks whether they are there.
    let named = json.meshes.iter().flat_map(|m| &m.primitives).flat_map(|p| p.attributes.values());
    if named.into_iter().any(|accessor| accessor.value() >= json.accessors.len()) {
        return Err("no valid glTF 2.0 (a primitive names an accessor that is not there)".into());
    }
    let document = gltf::Document::from_json(json).map_err(invalid)?;
    let buffers = buffers(&document, blob, folder)?;
    let mut mesh = Mesh::default();
    for image in document.images() {
        mesh.images.push(image_source(&image, &buffers, folder)?);
    }
    for material in document.materials() {
        mesh.materials.push(read_material(&material, &mesh.images)?);
    }
    let (mut cameras, mut lights) = (Vec::new(), Vec::new());
    let mut plain = None;
    for (node, matrix) in placed_nodes(&document)? {
        if let Some(camera) = node.camera() {
            cameras.push(read_camera(&camera, node.name(), matrix));
        }
        if let Some(light) = node.light() {
            lights.push(read_light(&light, matrix));
        }
        for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
            let Some(mut part) = read_part(&primitive, &buffers)? else { continue };
            part.material = match primitive.material().index() {
                Some(index) => index as u32,
                // What primitives without a material have: one more material, at the end.
                None => *plain.get_or_insert_with(|| {
                    let metallic = 1.0;
                    let model = Model::MetallicRoughness;
                    let name = "default".into();
                    mesh.materials.push(Material { name, model, metallic, ..Material::default() });
                    mesh.materials.len() as u32 - 1
                }),
            };
            place(&mut part, matrix);
            let set = mesh.materials[part.material as usize].normal_texture.as_ref();
            let made = if normals == Normals::Auto { Normals::Flat } else { normals };
            part.complete(made, set.map_or(0, |slot| slot.uv_set));
            mesh.join(part).map_err(|e| e.to_string())?;
        }
    }
    Ok(Scene { mesh, cameras, lights })
}

fn buffers(document: &gltf::Document, blob: Option<Vec<u8>>, folder: &Path) -> Result<Buffers, String> {
    let mut blob = blob;
    let mut all = Vec::new();
    for buffer in document.buffers() {
        let data = match buffer.source() {
            gltf::buffer::Source::Bin => blob.take().ok_or("no binary chunk for the first buffer")?,
            gltf::buffer::Source::Uri(uri) => match resolve(folder, uri)? {
                Target::Data(data) => data,
                Target::File(path) => read_file(&path).map_err(|e| e.to_string())?,
            },
        };
        if data.len() < buffer.length() {
            return Err(format!(
                "buffer {} has {} bytes; expected {}",
                buffer.index(),
                data.len(),
                buffer.length()
            ));
        }
        all.push(data);
    }
    Ok(Buffers(all))
}

fn image_source(image: &gltf::Image<'_>, buffers: &Buffers, folder: &Path) -> Result<ImageSource, String> {
    let name = image.name().unwrap_or_default().to_owned();
    Ok(match image.source() {
        gltf::image::Source::View { view, .. } => {
            ImageSource::Embedded { name, bytes: buffers.bytes(&view)?.into() }
        }
        gltf::image::Source::Uri { uri, .. } => match resolve(folder, uri)? {
            Target::Data(data) => ImageSource::Embedded { name, bytes: data.into() },
            Target::File(path) => ImageSource::File(path),
        },
    })
}

/// Nodes of the default scene (else the first, else all that have no parent) with their world matrices.
fn placed_nodes(document: &gltf::Document) -> Result<Vec<(gltf::Node<'_>, Matrix)>, String> {
    let nodes: Vec<_> = document.nodes().collect();
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let roots: Vec<usize> = match scene {
        Some(scene) => scene.nodes().map(|n| n.index()).collect(),
        None => {
            let mut has_parent = vec![false; nodes.len()];
            nodes.iter().flat_map(gltf::Node::children).for_each(|n| has_parent[n.index()] = true);
            (0..nodes.len()).filter(|&i| !has_parent[i]).collect()
        }
    };
    let mut seen = vec![false; nodes.len()];
    let mut waiting: Vec<(usize, Matrix)> = roots.into_iter().rev().map(|i| (i, IDENTITY)).collect();
    let mut placed = Vec::new();
    while let Some((i, parent)) = waiting.pop() {
        if std::mem::replace(&mut seen[i], true) {
            return Err(format!("node {i} is reached twice; nodes must form a tree"));
        }
        let node = nodes[i].clone();
        let columns = node.transform().matrix();
        let matrix = std::array::from_fn(|r| {
            std::array::from_fn(|c| (0..4).map(|k| parent[r][k] * f64::from(columns[c][k])).sum())
        });
        let children: Vec<usize> = node.children().map(|n| n.index()).collect();
        waiting.extend(children.into_iter().rev().map(|i| (i, matrix)));
        placed.push((node, matrix));
    }
    Ok(placed)
}

/// A triangle primitive in its own space; `None` for points and lines.
fn read_part(primitive: &gltf::Primitive<'_>, buffers: &Buffers) -> Result<Option<Part>, String> {
    use gltf::Semantic::{Colors, Normals, Positions, Tangents, TexCoords};
    use gltf::mesh::Mode;
    let mode = primitive.mode();
    if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        return Ok(None);
    }
    let positions = primitive.get(&Positions).ok_or("a primitive without positions")?;
    let positions: Vec<[f32; 3]> = buffers.rows(&positions, "POSITION")?;
    let count = positions.len();
    let fits = |name: &str, len: usize| {
        (len == count).then_some(()).ok_or_else(|| format!("{name}: {len} entries for {count} positions"))
    };
    let mut part = Part { positions, ..Part::default() };
    if let Some(accessor) = primitive.get(&Normals) {
        let list = buffers.rows(&accessor, "NORMAL")?;
        fits("NORMAL", list.len())?;
        part.normals = Some(list);
    }
    if let Some(accessor) = primitive.get(&Tangents) {
        let list = buffers.rows(&accessor, "TANGENT")?;
        fits("TANGENT", list.len())?;
        part.tangents = Some(list);
    }
    // Sets are numbered without gaps, says the specification.
    while let Some(accessor) = primitive.get(&TexCoords(part.uv.len() as u32)) {
        let list = buffers.rows(&accessor, "TEXCOORD")?;
        fits("TEXCOORD", list.len())?;
        part.uv.push(list);
    }
    if let Some(accessor) = primitive.get(&Colors(0)) {
        let (data, width) = buffers.floats(&accessor)?;
        if !(3..=4).contains(&width) {
            return Err(format!("COLOR_0: {width} numbers a colour; expected 3 or 4"));
        }
        let list: Vec<[f32; 4]> =
            data.chunks_exact(width).map(|c| [c[0], c[1], c[2], *c.get(3).unwrap_or(&1.0)]).collect();
        fits("COLOR_0", list.len())?;
        part.colors = Some(list);
    }
    let order = match primitive.indices() {
        Some(accessor) => buffers.indices(&accessor)?,
        None => (0..count as u32).collect(),
    };
    if let Some(index) = order.iter().find(|&&i| i as usize >= count) {
        return Err(format!("index {index} of {count} vertices"));
    }
    if !part.positions.as_flattened().iter().all(|c| c.is_finite()) {
        return Err("POSITION: a number that is not finite".into());
    }
    part.faces = match mode {
        Mode::TriangleFan => order.windows(2).skip(1).map(|w| [w[0], w[1], order[0]]).collect(),
        Mode::TriangleStrip => order
            .windows(3)
            .enumerate()
            .map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] })
            .collect(),
        _ => order.as_chunks().0.to_vec(),
    };
    Ok(Some(part))
}

/// Moves a part into world space: normals by the cofactors, tangents by the matrix; a mirroring matrix turns
/// the winding and the sign of the bitangent.
fn place(part: &mut Part, m: Matrix) {
    let linear = |v: [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|r| m[r][0] * v[0] + m[r][1] * v[1] + m[r][2] * v[2])
    };
    let cofactor: [[f64; 3]; 3] = std::array::from_fn(|r| {
        std::array::from_fn(|c| {
            let (r1, r2, c1, c2) = ((r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3);
            m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]
        })
    });
    let det: f64 = (0..3).map(|c| m[0][c] * cofactor[0][c]).sum();
    let sign = if det < 0.0 { -1.0 } else { 1.0 };
    for p in &mut part.positions {
        let moved = linear(p.map(f64::from));
        *p = std::array::from_fn(|k| (moved[k] + m[k][3]) as f32);
    }
    for n in part.normals.iter_mut().flatten() {
        let v = n.map(f64::from);
        *n = unit(cofactor.map(|row| sign * (row[0] * v[0] + row[1] * v[1] + row[2] * v[2])));
    }
    for [x, y, z, w] in part.tangents.iter_mut().flatten() {
        [*x, *y, *z] = unit(linear([*x, *y, *z].map(f64::from)));
        *w = if *w < 0.0 { -1.0 } else { 1.0 } * sign as f32;
    }
    if det < 0.0 {
        part.faces.iter_mut().for_each(|face| face.swap(1, 2));
    }
}

fn read_camera(camera: &gltf::Camera<'_>, node: Option<&str>, m: Matrix) -> Camera {
    let projection = match camera.projection() {
        gltf::camera::Projection::Perspective(p) => Projection::Perspective {
            yfov_rad: f64::from(p.yfov()),
            near: f64::from(p.znear()),
            far: p.zfar().map_or(f64::INFINITY, f64::from),
        },
        gltf::camera::Projection::Orthographic(o) => Projection::Orthographic {
            half_height: f64::from(o.ymag()),
            near: f64::from(o.znear()),
            far: f64::from(o.zfar()),
        },
    };
    let column = |c: usize| -> [f64; 3] { std::array::from_fn(|r| m[r][c]) };
    // A camera's scale does not count.
    let (eye, back) = (column(3), column(2));
    let target = std::array::from_fn(|k| eye[k] - back[k]);
    let name = camera.name().or(node).unwrap_or_default().to_owned();
    Camera { name, ..Camera::look_at(eye, target, column(1), projection) }
}

/// Photometric units become those of [`Light`]: 683 lumen to the watt, and a white surface sends out 1/π of
/// the light that it gets.
fn read_light(light: &gltf::khr_lights_punctual::Light<'_>, m: Matrix) -> Light {
    use gltf::khr_lights_punctual::Kind;
    let column = |c: usize| -> [f64; 3] { std::array::from_fn(|r| m[r][c]) };
    let scale = light.intensity() / (683.0 * std::f32::consts::PI);
    let color = light.color().map(|c| c * scale);
    let (direction, position) = (unit(column(2).map(|c| -c)), column(3).map(|c| c as f32));
    match light.kind() {
        Kind::Directional => Light::Directional { direction, color },
        Kind::Point => Light::Point { position, color, falloff: Some(1.0), cone: None },
        Kind::Spot { inner_cone_angle, outer_cone_angle } => {
            let cone = Some((direction, [inner_cone_angle, outer_cone_angle]));
            Light::Point { position, color, falloff: Some(1.0), cone }
        }
    }
}

fn read_material(material: &gltf::Material<'_>, images: &[ImageSource]) -> Result<Material, String> {
    let pbr = material.pbr_metallic_roughness();
    let info = |info: Option<gltf::texture::Info<'_>>, encoding| {
        info.and_then(|info| {
            let transform = info.texture_transform().map(|t| {
                let set = t.tex_coord().map(|set| set as usize);
                (uv_transform(t.offset(), t.rotation(), t.scale()), set)
            });
            slot(&info.texture(), info.tex_coord(), transform, encoding)
        })
    };
    let normal = material.normal_texture();
    let occlusion = material.occlusion_texture();
    let emissive = material.emissive_strength().unwrap_or(1.0);
    let made = Material {
        name: material.name().unwrap_or_default().to_owned(),
        model: Model::MetallicRoughness,
        base_color: pbr.base_color_factor(),
        base_color_texture: info(pbr.base_color_texture(), Encoding::Srgb),
        metallic: pbr.metallic_factor(),
        roughness: pbr.roughness_factor(),
        metallic_roughness_texture: info(pbr.metallic_roughness_texture(), Encoding::Linear),
        normal_scale: normal.as_ref().map_or(1.0, |n| n.scale()),
        normal_texture: normal.and_then(|n| {
            let transform = transform_of_value(n.extension_value("KHR_texture_transform"));
            slot(&n.texture(), n.tex_coord(), transform, Encoding::Normal)
        }),
        occlusion_strength: occlusion.as_ref().map_or(1.0, |o| o.strength()),
        occlusion_texture: occlusion.and_then(|o| {
            let transform = transform_of_value(o.extension_value("KHR_texture_transform"));
            slot(&o.texture(), o.tex_coord(), transform, Encoding::Linear)
        }),
        emissive: material.emissive_factor().map(|c| c * emissive),
        emissive_texture: info(material.emissive_texture(), Encoding::Srgb),
        alpha_mode: match material.alpha_mode() {
            gltf::material::AlphaMode::Opaque => AlphaMode::Opaque,
            gltf::material::AlphaMode::Mask => AlphaMode::Mask(material.alpha_cutoff().unwrap_or(0.5)),
            gltf::material::AlphaMode::Blend => AlphaMode::Blend,
        },
        double_sided: material.double_sided(),
        unlit: material.unlit(),
        ..Material::default()
    };
    match made.slots().into_iter().find(|(_, slot)| slot.image >= images.len()) {
        Some((name, slot)) => Err(format!("{name} names image {} of {}", slot.image, images.len())),
        None => Ok(made),
    }
}

type Transform = Option<([[f32; 3]; 2], Option<usize>)>;

/// `None` for a texture that has no picture in PNG or JPEG.
fn slot(
    texture: &gltf::Texture<'_>,
    uv_set: u32,
    transform: Transform,
    encoding: Encoding,
) -> Option<TextureSlot> {
    let sampler = texture.sampler();
    let wrap = |mode| match mode {
        WrappingMode::ClampToEdge => Wrap::Clamp,
        WrappingMode::MirroredRepeat => Wrap::Mirror,
        WrappingMode::Repeat => Wrap::Repeat,
    };
    let (transform, set) = transform.unwrap_or((TextureSlot::IDENTITY, None));
    Some(TextureSlot {
        image: texture.source()?.index(),
        uv_set: set.unwrap_or(uv_set as usize),
        transform,
        wrap: [wrap(sampler.wrap_s()), wrap(sampler.wrap_t())],
        mag_filter: sampler.mag_filter().map(|filter| match filter {
            MagFilter::Nearest => "nearest",
            MagFilter::Linear => "bilinear",
        }),
        min_filter: sampler.min_filter().map(|filter| match filter {
            MinFilter::Nearest => "nearest",
            MinFilter::Linear => "bilinear",
            MinFilter::NearestMipmapNearest => "nearest_mipmap_nearest",
            MinFilter::LinearMipmapNearest => "linear_mipmap_nearest",
            MinFilter::NearestMipmapLinear => "nearest_mipmap_linear",
            MinFilter::LinearMipmapLinear => "trilinear",
        }),
        encoding,
    })
}

/// KHR_texture_transform: scale, then rotate, then move. The rotation is counter-clockwise as seen with v
/// down, as the extension's words and its sample model have it.
fn uv_transform([ox, oy]: [f32; 2], angle: f32, [sx, sy]: [f32; 2]) -> [[f32; 3]; 2] {
    let (s, c) = f64::from(angle).sin_cos();
    let (sx, sy) = (f64::from(sx), f64::from(sy));
    [[(c * sx) as f32, (s * sy) as f32, ox], [(-s * sx) as f32, (c * sy) as f32, oy]]
}

/// The transform of a slot whose type in the crate has none.
fn transform_of_value(value: Option<&Value>) -> Transform {
    let value = value?;
    let number = |v: Option<&Value>, default: f32| v.and_then(Value::as_f64).map_or(default, |x| x as f32);
    let pair = |name: &str, default| [0, 1].map(|k| number(value.get(name).and_then(|p| p.get(k)), default));
    let set = value.get("texCoord").and_then(Value::as_u64).map(|set| set as usize);
    Some((uv_transform(pair("offset", 0.0), number(value.get("rotation"), 0.0), pair("scale", 1.0)), set))
}
