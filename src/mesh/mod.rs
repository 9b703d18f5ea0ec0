//! Triangles with what textures need: normals, tangents, uv sets, materials; read from glTF, GLB and OBJ.
//!
//! A file becomes one [`Mesh`] in world space: the nodes of a scene are applied, primitives are joined, and
//! `face_material` tells which material each triangle has. Texture coordinates run as everywhere in the
//! crate, v down; OBJ files, whose v runs up, are flipped once when loaded.

mod camera;
mod light;
mod material;
mod normals;

#[cfg(feature = "mesh")]
mod accessor;
#[cfg(feature = "mesh")]
mod gltf;
#[cfg(feature = "mesh")]
mod obj;
#[cfg(feature = "mesh")]
mod scene;
#[cfg(feature = "simplify")]
mod simplify;
#[cfg(feature = "mesh")]
mod tangent;
#[cfg(feature = "simplify")]
mod unfold;
#[cfg(feature = "mesh")]
mod uri;

use crate::error::{Error, Result};

pub use camera::{Camera, Projection};
pub use light::Light;
pub use material::{
    AlphaMode, Blend, ImageSource, Layer, Material, Model, NormalSpace, SampleFilter, TextureSlot,
};
pub(crate) use normals::grouped as grouped_normals;
pub use normals::{Normals, smooth_normals};
#[cfg(feature = "mesh")]
pub use scene::Scene;

/// Most vertices or faces that a file may unfold to: a small file can name one mesh a million times.
pub const MAX_ELEMENTS: usize = 1 << 25;

/// Triangles of one or many materials. All lists of vertices have one entry a vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Places, in the file's own unit.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals.
    pub normals: Vec<[f32; 3]>,
    /// Unit tangents with the sign w of the bitangent, `w * cross(normal, tangent)`, in the sense of normal
    /// maps in files: green points to the top of the picture. Where there is no uv, any unit vector in the
    /// surface.
    pub tangents: Vec<[f32; 4]>,
    /// Sets of texture coordinates, v down; zeros for vertices whose part of the file lacks the set.
    pub uv: Vec<Vec<[f32; 2]>>,
    /// Linear colours with alpha, multiplied with the material's; empty where the file has none.
    pub colors: Vec<[f32; 4]>,
    /// Triangles, counter-clockwise seen from the front.
    pub faces: Vec<[u32; 3]>,
    /// Index into `materials` for each face.
    pub face_material: Vec<u32>,
    /// Materials; there is at least one where there is a face.
    pub materials: Vec<Material>,
    /// Pictures that materials name.
    pub images: Vec<ImageSource>,
}

impl Mesh {
    /// Checks what every user of a mesh relies on.
    ///
    /// # Errors
    /// [`Error::Value`] when a list has another length than `positions` or `faces`, a face names a vertex or
    /// material that is not there, a material names an image that is not there, or a position is not finite.
    pub fn check(&self) -> Result<()> {
        let vertices = self.positions.len();
        let lists = [("normals", self.normals.len()), ("tangents", self.tangents.len())]
            .into_iter()
            .chain(self.uv.iter().map(|set| ("uv", set.len())))
            .chain((!self.colors.is_empty()).then_some(("colors", self.colors.len())));
        for (name, len) in lists {
            if len != vertices {
                return Err(Error::value(
                    name,
                    format!("{len} entries"),
                    format!("one a vertex, {vertices}"),
                ));
            }
        }
        if self.face_material.len() != self.faces.len() {
            let got = format!("{} entries", self.face_material.len());
            return Err(Error::value("face_material", got, format!("one a face, {}", self.faces.len())));
        }
        check_faces(&self.faces, vertices)?;
        if let Some(i) = self.positions.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
            return Err(Error::value(
                "positions",
                format!("{:?} at {i}", self.positions[i]),
                "finite numbers",
            ));
        }
        if let Some(m) = self.face_material.iter().find(|&&m| m as usize >= self.materials.len()) {
            return Err(Error::value("face_material", m, format!("below {}", self.materials.len())));
        }
        let slots = self.materials.iter().flat_map(Material::slots);
        if let Some((name, slot)) = slots.into_iter().find(|(_, slot)| slot.image >= self.images.len()) {
            return Err(Error::value("materials", format!("{name} with image {}", slot.image), "an image"));
        }
        Ok(())
    }

    /// Opposite corners of the box around all vertices that faces use; `None` without faces.
    pub fn bounds(&self) -> Option<[[f32; 3]; 2]> {
        let mut used = self.faces.iter().flatten().map(|&v| self.positions[v as usize]);
        let first = used.next()?;
        Some(used.fold([first, first], |[lo, hi], p| {
            [std::array::from_fn(|k| lo[k].min(p[k])), std::array::from_fn(|k| hi[k].max(p[k]))]
        }))
    }
}

/// Refuses faces that name vertices that are not there.
pub(crate) fn check_faces(faces: &[[u32; 3]], vertices: usize) -> Result<()> {
    match faces.iter().enumerate().find(|(_, f)| f.iter().any(|&v| v as usize >= vertices)) {
        None => Ok(()),
        Some((i, face)) => Err(Error::value(
            "faces",
            format!("face {i} with vertices {face:?}"),
            format!("indices below the number of vertices, {vertices}"),
        )),
    }
}

/// One primitive of a file, before it joins the others.
#[cfg(feature = "mesh")]
#[derive(Clone, Debug, Default)]
struct Part {
    positions: Vec<[f32; 3]>,
    normals: Option<Vec<[f32; 3]>>,
    tangents: Option<Vec<[f32; 4]>>,
    uv: Vec<Vec<[f32; 2]>>,
    colors: Option<Vec<[f32; 4]>>,
    faces: Vec<[u32; 3]>,
    material: u32,
}

#[cfg(feature = "mesh")]
impl Part {
    /// Each face gets corners of its own.
    fn unshare(&mut self) {
        let corners: Vec<usize> = self.faces.iter().flatten().map(|&v| v as usize).collect();
        self.select(&corners);
        self.faces = (0..corners.len() as u32 / 3).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
    }

    /// Keeps the named vertices in the named order; faces are the caller's.
    fn select(&mut self, vertices: &[usize]) {
        fn take<T: Copy>(list: &mut Vec<T>, vertices: &[usize]) {
            *list = vertices.iter().map(|&v| list[v]).collect();
        }
        take(&mut self.positions, vertices);
        self.uv.iter_mut().for_each(|set| take(set, vertices));
        self.normals.iter_mut().for_each(|list| take(list, vertices));
        self.tangents.iter_mut().for_each(|list| take(list, vertices));
        self.colors.iter_mut().for_each(|list| take(list, vertices));
    }

    /// Makes what is missing. `tangent_set` is the uv set of the material's normal map.
    fn complete(&mut self, normals: Normals, tangent_set: usize) {
        if self.normals.is_none() {
            // Tangents belong to normals; without these they have no meaning.
            self.tangents = None;
            if normals == Normals::Flat {
                self.unshare();
            }
            self.normals = Some(normals::missing(&self.positions, &self.faces, normals));
        }
        if self.tangents.is_none() {
            tangent::complete(self, tangent_set);
        }
    }
}

#[cfg(feature = "mesh")]
impl Mesh {
    /// The mesh with what it lacks: normals (where the list is empty), tangents, one material where there is
    /// none. Vertices may be split for that. [`Normals::Auto`] makes smooth ones.
    ///
    /// # Errors
    /// [`Error::Value`] as [`Mesh::check`].
    pub fn completed(mut self, normals: Normals) -> Result<Self> {
        if self.materials.is_empty() {
            self.materials.push(Material::default());
        }
        self.face_material.resize(self.faces.len(), 0);
        let vertices = self.positions.len();
        if !self.normals.is_empty() && self.normals.len() != vertices {
            let got = format!("{} entries", self.normals.len());
            return Err(Error::value("normals", got, format!("one a vertex, {vertices}")));
        }
        // The other lists are checked before anything walks over them.
        let given = std::mem::take(&mut self.normals);
        let checked = Self {
            normals: vec![[0.0, 0.0, 1.0]; vertices],
            tangents: vec![[1.0, 0.0, 0.0, 1.0]; vertices],
            ..self
        };
        checked.check()?;
        let Self { positions, uv, colors, faces, face_material, materials, images, .. } = checked;
        let set = materials.iter().find_map(|m| m.normal_texture.as_ref()).map_or(0, |slot| slot.uv_set);
        let mut part = Part {
            positions,
            normals: (!given.is_empty()).then_some(given),
            tangents: None,
            uv,
            colors: (!colors.is_empty()).then_some(colors),
            faces,
            material: 0,
        };
        part.complete(if normals == Normals::Auto { Normals::Smooth } else { normals }, set);
        let mut made = Self { materials, images, ..Self::default() };
        made.join(part)?;
        made.face_material = face_material;
        Ok(made)
    }

    /// Adds a complete part.
    fn join(&mut self, part: Part) -> Result<()> {
        let first = self.positions.len();
        let total = first + part.positions.len();
        if total > MAX_ELEMENTS || self.faces.len() + part.faces.len() > MAX_ELEMENTS {
            return Err(Error::value(
                "mesh",
                format!("{total} vertices and {} faces or more", self.faces.len() + part.faces.len()),
                format!("at most {MAX_ELEMENTS} of each"),
            ));
        }
        while self.uv.len() < part.uv.len() {
            self.uv.push(vec![[0.0; 2]; first]);
        }
        for (k, set) in self.uv.iter_mut().enumerate() {
            set.extend(part.uv.get(k).into_iter().flatten());
            set.resize(total, [0.0; 2]);
        }
        if let Some(colors) = part.colors {
            self.colors.resize(first, [1.0; 4]);
            self.colors.extend(colors);
        } else if !self.colors.is_empty() {
            self.colors.resize(total, [1.0; 4]);
        }
        self.positions.extend(part.positions);
        self.normals.extend(part.normals.into_iter().flatten());
        self.tangents.extend(part.tangents.into_iter().flatten());
        self.face_material.resize(self.faces.len() + part.faces.len(), part.material);
        self.faces.extend(part.faces.into_iter().map(|f| f.map(|v| v + first as u32)));
        Ok(())
    }
}
