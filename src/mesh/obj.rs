//! Wavefront OBJ and MTL, by the crate `tobj`, which is fed clean lines.
//!
//! What `tobj` 4.0.5 does not do is done here before or after: continued and indented lines, tabs, options in
//! front of texture names, indices too large for its arithmetic, and corners without a normal among corners
//! with one (it repeats the corner before: all normals are made anew instead).

use super::material::{AlphaMode, ImageSource, Material, TextureSlot};
use super::scene::read_file;
use super::uri::inside;
use super::{Mesh, Normals, Part};
use crate::encode::Encoding;
use crate::wrap::Wrap;
use std::collections::HashMap;
use std::path::Path;

/// The mesh of an OBJ file. Missing material libraries are no error: the geometry is there.
pub(super) fn load(folder: &Path, bytes: &[u8], normals: Normals) -> Result<Mesh, String> {
    let clean = Clean::new(bytes)?;
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..Default::default()
    };
    let loader = |name: &Path| {
        let name = name.to_str().ok_or(tobj::LoadError::OpenFileFailed)?;
        let path = inside(folder, name).map_err(|_| tobj::LoadError::OpenFileFailed)?;
        let text = read_file(&path).map_err(|_| tobj::LoadError::OpenFileFailed)?;
        let mut lines = String::new();
        logical_lines(&text, |_, line| {
            lines.push_str(line);
            lines.push('\n');
            Ok(())
        })
        .map_err(|_| tobj::LoadError::ReadError)?;
        tobj::load_mtl_buf(&mut lines.as_bytes())
    };
    let (models, materials) = tobj::load_obj_buf(&mut clean.text.as_bytes(), &options, loader)
        .map_err(|e| format!("no valid OBJ ({e})"))?;
    let mut mesh = Mesh::default();
    let mut images = HashMap::new();
    for material in materials.iter().flatten() {
        let material = read_material(material, folder, &mut images, &mut mesh.images)?;
        mesh.materials.push(material);
    }
    let mut whole = Part::default();
    let mut part_materials: Vec<(usize, u32)> = Vec::new();
    let mut plain = None;
    let has_uv = models.iter().any(|m| !m.mesh.texcoord_indices.is_empty());
    let has_normals = !clean.lacks_normals && models.iter().any(|m| !m.mesh.normal_indices.is_empty());
    let has_colors = models.iter().any(|m| !m.mesh.vertex_color.is_empty());
    let (mut uv, mut given, mut colors) = (Vec::new(), Vec::new(), Vec::new());
    for model in &models {
        let m = &model.mesh;
        let mut vertices: HashMap<[u32; 3], u32> = HashMap::new();
        let mut corners = Vec::with_capacity(m.indices.len());
        for (k, &p) in m.indices.iter().enumerate() {
            let at = |list: &[u32]| list.get(k).copied().unwrap_or(u32::MAX);
            let key = [p, at(&m.texcoord_indices), if has_normals { at(&m.normal_indices) } else { 0 }];
            let next = whole.positions.len() as u32;
            let vertex = *vertices.entry(key).or_insert(next);
            if vertex == next {
                let row = |list: &[f32], i: u32| -> [f32; 3] {
                    list.get(i as usize * 3..).and_then(|r| r.first_chunk()).copied().unwrap_or_default()
                };
                whole.positions.push(row(&m.positions, key[0]));
                given.push(row(&m.normals, key[2]));
                let [r, g, b] =
                    if m.vertex_color.is_empty() { [1.0; 3] } else { row(&m.vertex_color, key[0]) };
                colors.push([r, g, b, 1.0]);
                let pair = (key[1] != u32::MAX).then(|| m.texcoords.get(key[1] as usize * 2..)).flatten();
                // v runs up in OBJ and down here.
                uv.push(pair.and_then(|r| r.first_chunk()).map_or([0.0; 2], |&[u, v]| [u, 1.0 - v]));
            }
            corners.push(vertex);
        }
        whole.faces.extend(corners.as_chunks::<3>().0);
        let material = match m.material_id {
            Some(id) => id as u32,
            // What faces without `usemtl` have: one more material, at the end.
            None => *plain.get_or_insert_with(|| {
                mesh.materials.push(Material { name: "default".into(), ..Material::default() });
                mesh.materials.len() as u32 - 1
            }),
        };
        part_materials.push((whole.faces.len(), material));
    }
    if !whole.positions.as_flattened().iter().chain(uv.as_flattened()).all(|c| c.is_finite()) {
        return Err("a coordinate that is not finite".into());
    }
    whole.uv = if has_uv { vec![uv] } else { Vec::new() };
    whole.colors = has_colors.then_some(colors);
    whole.normals =
        has_normals.then(|| given.iter().map(|n| super::normals::unit(n.map(f64::from))).collect());
    whole.complete(if normals == Normals::Auto { Normals::Smooth } else { normals }, 0);
    mesh.join(whole).map_err(|e| e.to_string())?;
    let mut start = 0;
    for (end, material) in part_materials {
        mesh.face_material[start..end].fill(material);
        start = end;
    }
    Ok(mesh)
}

/// An OBJ file with one statement a line.
struct Clean {
    text: String,
    lacks_normals: bool,
}

impl Clean {
    fn new(bytes: &[u8]) -> Result<Self, String> {
        let mut clean = Self { text: String::with_capacity(bytes.len()), lacks_normals: false };
        logical_lines(bytes, |number, line| {
            let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
            if word == "f" {
                for corner in rest.split_whitespace() {
                    clean.lacks_normals |= corner.split('/').nth(2).is_none_or(str::is_empty);
                    // Ten characters hold every index below the limit on elements, and its sign.
                    if corner.split('/').any(|index| index.len() > 10) {
                        let short: String = corner.chars().take(40).collect();
                        return Err(format!("line {number}: index {short:?} is too large"));
                    }
                }
            }
            clean.text.push_str(word);
            clean.text.push(' ');
            clean.text.push_str(rest.trim());
            clean.text.push('\n');
            Ok(())
        })?;
        Ok(clean)
    }
}

/// Calls `each` with the number and text of every statement that is not a comment: lines that end in a
/// backslash go on, outer white space goes away.
fn logical_lines(
    bytes: &[u8],
    mut each: impl FnMut(usize, &str) -> Result<(), String>,
) -> Result<(), String> {
    let text = String::from_utf8_lossy(bytes);
    let mut held = String::new();
    for (i, line) in text.lines().enumerate() {
        if let Some(part) = line.trim_end().strip_suffix('\\') {
            held.push_str(part);
            held.push(' ');
            continue;
        }
        held.push_str(line);
        let statement = held.trim();
        if !statement.is_empty() && !statement.starts_with('#') {
            each(i + 1, statement)?;
        }
        held.clear();
    }
    Ok(())
}

/// A texture statement: options, then a name that may have spaces.
struct TextureName<'a> {
    name: &'a str,
    bump_scale: f32,
    scale: [f32; 2],
    offset: [f32; 2],
    clamp: bool,
}

fn texture_name(statement: &str) -> TextureName<'_> {
    let mut found = TextureName {
        name: statement.trim(),
        bump_scale: 1.0,
        scale: [1.0; 2],
        offset: [0.0; 2],
        clamp: false,
    };
    while let Some(option) = found.name.strip_prefix('-') {
        let (word, mut rest) = option.split_once(char::is_whitespace).unwrap_or((option, ""));
        let mut numbers = Vec::new();
        let mut words = 0;
        let most = match word {
            "o" | "s" | "t" => 3,
            "mm" => 2,
            "bm" | "boost" | "texres" | "blendu" | "blendv" | "cc" | "clamp" | "imfchan" | "type" => 1,
            // No option but a name that starts with a dash.
            _ => break,
        };
        while words < most {
            let (value, after) = rest.trim_start().split_once(char::is_whitespace).unwrap_or((rest, ""));
            let number = value.trim().parse::<f32>();
            // The second and third number of an option may be left out.
            if words > 0 && number.is_err() || after.is_empty() {
                break;
            }
            if word == "clamp" {
                found.clamp = value.trim() == "on";
            }
            numbers.extend(number.ok());
            rest = after;
            words += 1;
        }
        let pair = |default: f32| [0, 1].map(|k| numbers.get(k).copied().unwrap_or(default));
        match word {
            "bm" => found.bump_scale = numbers.first().copied().unwrap_or(1.0),
            "s" => found.scale = pair(1.0),
            "o" => found.offset = pair(0.0),
            _ => {}
        }
        found.name = rest.trim();
    }
    found
}

fn read_material(
    material: &tobj::Material,
    folder: &Path,
    known: &mut HashMap<String, usize>,
    images: &mut Vec<ImageSource>,
) -> Result<Material, String> {
    let mut slot = |statement: Option<&String>, encoding| -> Result<Option<TextureSlot>, String> {
        let Some(statement) = statement else { return Ok(None) };
        let texture = texture_name(statement);
        let path = inside(folder, texture.name)?;
        let image = *known.entry(texture.name.to_owned()).or_insert_with(|| {
            images.push(ImageSource::File(path));
            images.len() - 1
        });
        // The file's v' = s v + o runs up; with v = 1 - v that is s v + (1 - s - o) downwards.
        let ([su, sv], [ou, ov]) = (texture.scale, texture.offset);
        let transform = [[su, 0.0, ou], [0.0, sv, 1.0 - sv - ov]];
        let wrap = [if texture.clamp { Wrap::Clamp } else { Wrap::Repeat }; 2];
        let (mag_filter, min_filter) = (None, None);
        Ok(Some(TextureSlot { image, uv_set: 0, transform, wrap, mag_filter, min_filter, encoding }))
    };
    let unknown = |name: &str| material.unknown_param.get(name);
    let base_color_texture = slot(material.diffuse_texture.as_ref(), Encoding::Srgb)?;
    let alpha_texture = slot(material.dissolve_texture.as_ref(), Encoding::Linear)?;
    let opacity = material.dissolve.or_else(|| {
        // Some writers mean opacity by Tr, some its opposite: 1 and 0 both stand for opaque.
        unknown("Tr")?.trim().parse().ok().map(|tr: f32| if tr == 0.0 || tr == 1.0 { 1.0 } else { 1.0 - tr })
    });
    let alpha = opacity.unwrap_or(1.0);
    let [r, g, b] = material.diffuse.unwrap_or([1.0; 3]);
    let bump = material.normal_texture.as_ref();
    Ok(Material {
        name: material.name.clone(),
        base_color: [r, g, b, alpha],
        alpha_mode: if alpha < 1.0 || alpha_texture.is_some() { AlphaMode::Blend } else { AlphaMode::Opaque },
        base_color_texture,
        alpha_texture,
        normal_texture: slot(unknown("norm"), Encoding::Normal)?,
        bump_scale: bump.map_or(1.0, |statement| texture_name(statement).bump_scale),
        bump_texture: slot(bump, Encoding::Linear)?,
        emissive: material.emissive.unwrap_or_default(),
        emissive_texture: slot(unknown("map_Ke"), Encoding::Srgb)?,
        ambient: material.ambient.unwrap_or([1.0; 3]),
        specular: material.specular.unwrap_or_default(),
        specular_texture: slot(material.specular_texture.as_ref(), Encoding::Srgb)?,
        shininess: material.shininess.unwrap_or(1.0),
        shininess_texture: slot(material.shininess_texture.as_ref(), Encoding::Linear)?,
        ..Material::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texture_names_keep_spaces_and_lose_options() {
        let name = |s| texture_name(s).name.to_owned();
        assert_eq!(name("fuze uv.jpg"), "fuze uv.jpg");
        assert_eq!(name("-s 2 3 1 -o 0.5 a b.png"), "a b.png");
        assert_eq!(name("-s 2 a b.png"), "a b.png");
        assert_eq!(name("-clamp on -bm 0.5 x.png"), "x.png");
        assert_eq!(name("-strange.png"), "-strange.png");
        assert_eq!(name("-s"), "");
        let t = texture_name("-s 2 3 1 -o 0.5 -bm 0.25 -clamp on a.png");
        assert_eq!((t.scale, t.offset, t.bump_scale, t.clamp), ([2.0, 3.0], [0.5, 0.0], 0.25, true));
    }
}
