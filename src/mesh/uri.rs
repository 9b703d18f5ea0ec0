//! Names of files inside files: data URIs, and relative paths that stay in the folder.

use base64::Engine;
use std::path::{Component, Path, PathBuf};

/// What a URI stands for.
pub(super) enum Target {
    /// A file in or below the folder.
    File(PathBuf),
    /// Bytes in the URI itself.
    Data(Vec<u8>),
}

/// Reads a URI of a file in `folder`. Schemes other than `data:`, absolute paths and paths that lead out of
/// the folder are refused: a mesh from elsewhere must not read other files of its reader.
pub(super) fn resolve(folder: &Path, uri: &str) -> Result<Target, String> {
    if let Some(rest) = uri.strip_prefix("data:") {
        let (head, body) = rest.split_once(',').ok_or("a data URI without a comma")?;
        if !head.ends_with(";base64") {
            return Ok(Target::Data(urlencoding::decode_binary(body.as_bytes()).into_owned()));
        }
        let body = body.trim_end_matches('=').as_bytes();
        let engine = base64::engine::general_purpose::STANDARD_NO_PAD;
        return engine.decode(body).map(Target::Data).map_err(|e| format!("a damaged data URI ({e})"));
    }
    let name = urlencoding::decode(uri).map_err(|_| shown(uri, "is not UTF-8"))?;
    inside(folder, &name).map(Target::File)
}

/// The file of this relative name, in or below the folder.
pub(super) fn inside(folder: &Path, name: &str) -> Result<PathBuf, String> {
    let mut path = folder.to_path_buf();
    let mut depth = 0usize;
    // A colon is a scheme or a drive, a zero byte ends names for the system.
    if name.is_empty() || name.contains(['\0', ':']) {
        return Err(shown(name, "is no relative path"));
    }
    // Exporters on Windows write backslashes.
    for part in Path::new(&name.replace('\\', "/")).components() {
        match part {
            Component::Normal(part) => {
                path.push(part);
                depth += 1;
            }
            Component::CurDir => {}
            Component::ParentDir if depth > 0 => {
                path.pop();
                depth -= 1;
            }
            Component::ParentDir => return Err(shown(name, "leads out of the file's folder")),
            Component::RootDir | Component::Prefix(_) => return Err(shown(name, "is an absolute path")),
        }
    }
    if depth == 0 { Err(shown(name, "names no file")) } else { Ok(path) }
}

fn shown(name: &str, reason: &str) -> String {
    let short: String = name.chars().take(80).collect();
    format!("URI {short:?} {reason}; expected a data URI or a path in the file's folder")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_stay_in_the_folder() {
        let folder = Path::new("models");
        let file = |uri| match resolve(folder, uri) {
            Ok(Target::File(path)) => Some(path),
            _ => None,
        };
        assert_eq!(file("a%20b.png"), Some("models/a b.png".into()));
        assert_eq!(file("./textures/../a.bin"), Some("models/a.bin".into()));
        for bad in [
            "../a.bin",
            "a/../../b",
            "/etc/passwd",
            "%2e%2e/a",
            "..%2Fa",
            "..\\a",
            "file:///etc/passwd",
            "http://host/a",
            "C:\\a",
            "",
            ".",
            "a/..",
            "a%00b",
        ] {
            assert_eq!(file(bad), None, "{bad}");
        }
    }

    #[test]
    fn data_uris_are_decoded() {
        let data = |uri| match resolve(Path::new(""), uri) {
            Ok(Target::Data(bytes)) => Some(bytes),
            _ => None,
        };
        assert_eq!(data("data:application/octet-stream;base64,AAEC/w=="), Some(vec![0, 1, 2, 255]));
        assert_eq!(data("data:text/plain,a%20b"), Some(b"a b".to_vec()));
        assert_eq!(data("data:;base64,%%%"), None);
        assert_eq!(data("data:"), None);
    }
}
