//! Opening files: one door for all formats.

use super::{Camera, Light, Mesh, Normals, gltf, obj};
use crate::error::{Error, Result};
use std::fs;
use std::path::Path;

/// Largest file that is read, in bytes.
const MAX_FILE: u64 = 1 << 32;

/// A mesh, and the cameras and lights of its file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Everything with a surface, in world space.
    pub mesh: Mesh,
    /// Cameras, in the order of the file.
    pub cameras: Vec<Camera>,
    /// Lights, in the order of the file.
    pub lights: Vec<Light>,
}

/// The bytes of a regular file of bearable size.
pub(super) fn read_file(path: &Path) -> Result<Vec<u8>> {
    let io = |source| Error::Io { path: path.to_owned(), source };
    let meta = fs::metadata(path).map_err(io)?;
    if !meta.is_file() || meta.len() > MAX_FILE {
        let message = format!("expected a regular file of at most {MAX_FILE} bytes");
        return Err(Error::File { path: path.to_owned(), message });
    }
    fs::read(path).map_err(io)
}

impl Scene {
    /// Reads a `.gltf`, `.glb` or `.obj` file. What the file lacks is made: normals as `normals` says,
    /// tangents by MikkTSpace. Files that it names must lie in or below its folder.
    ///
    /// # Errors
    /// [`Error::Io`] when a file cannot be read, [`Error::File`] when its content is damaged, hostile or of
    /// another kind.
    pub fn open(path: impl AsRef<Path>, normals: Normals) -> Result<Self> {
        let path = path.as_ref();
        Self::decode(path, &read_file(path)?, normals)
    }

    /// As [`Scene::open`], of a file's content; `path` tells its kind and the folder of the files that it names.
    ///
    /// # Errors
    /// As [`Scene::open`].
    ///
    /// ```
    /// use multum::mesh::{Normals, Scene};
    /// let triangle = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    /// let scene = Scene::decode("triangle.obj", triangle, Normals::Auto)?;
    /// assert_eq!(scene.mesh.faces, [[0, 1, 2]]);
    /// # Ok::<(), multum::Error>(())
    /// ```
    pub fn decode(path: impl AsRef<Path>, bytes: &[u8], normals: Normals) -> Result<Self> {
        let path = path.as_ref();
        let folder = path.parent().unwrap_or(Path::new(""));
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        let read = match extension.as_deref() {
            _ if bytes.starts_with(b"glTF") => gltf::load(folder, bytes, normals),
            Some("gltf" | "glb") => gltf::load(folder, bytes, normals),
            Some("obj") => obj::load(folder, bytes, normals).map(|mesh| Self { mesh, ..Self::default() }),
            _ => Err("an unknown kind of mesh; .gltf, .glb and .obj files are read".into()),
        };
        let scene = read.map_err(|message| Error::File { path: path.to_owned(), message })?;
        scene.mesh.check().map_err(|e| Error::File { path: path.to_owned(), message: e.to_string() })?;
        Ok(scene)
    }

    /// The file's first camera, or one that frames the mesh.
    pub fn camera(&self) -> Camera {
        self.cameras.first().cloned().unwrap_or_else(|| Camera::framing(&self.mesh))
    }
}
