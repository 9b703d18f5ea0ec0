//! The layers hold: a file names only modules of ranks below its own, or of its own folder.

use std::fs;
use std::path::Path;

/// Ranks of the top-level modules, as the crate's documentation draws them.
const RANKS: &[(&str, u32)] = &[
    ("error", 0),
    ("num", 0),
    ("par", 0),
    ("jacobian", 1),
    ("kernel", 1),
    ("texel", 2),
    ("encode", 3),
    ("image", 3),
    ("files", 4),
    ("wrap", 3),
    ("pyramid", 4),
    ("sat", 4),
    ("bounds", 4),
    ("detail", 4),
    ("texture", 5),
    ("footprint", 6),
    ("lod", 6),
    ("filter", 7),
    ("sampler", 8),
    ("mapping", 8),
    ("sphere", 9),
    ("warp", 10),
    ("compat", 11),
    ("mesh", 11),
    ("raster", 12),
    ("shade", 13),
    ("render", 14),
    ("bake", 15),
    ("python", 16),
    ("lib", 17),
];

/// The reference may read nothing of what it judges.
const ORACLE_MAY_USE: &[&str] = &["error", "image", "texel"];

fn rank(module: &str) -> Option<u32> {
    RANKS.iter().find(|(name, _)| *name == module).map(|(_, rank)| *rank)
}

fn files(folder: &Path, found: &mut Vec<std::path::PathBuf>) {
    for entry in fs::read_dir(folder).expect("src is readable") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// Every module name that follows `crate::` in code, outside comments and tests. `crate::Name` in
/// CamelCase is a re-export of lib.rs, which only the top may use.
fn mentions(source: &str) -> Vec<String> {
    let code = source.split("#[cfg(test)]").next().unwrap_or("");
    let mut names = Vec::new();
    for line in code.lines().map(|l| l.split("//").next().unwrap_or("")) {
        for part in line.split("crate::").skip(1) {
            let name: String = part.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            if !name.is_empty() {
                names.push(name);
            }
        }
    }
    names
}

#[test]
fn files_import_only_from_lower_ranks() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    files(&root, &mut found);
    assert!(found.len() > 5);
    let mut wrong = Vec::new();
    for path in found {
        let relative = path.strip_prefix(&root).expect("inside src");
        let first = relative.components().next().expect("a name").as_os_str().to_string_lossy().into_owned();
        let module = first.trim_end_matches(".rs").to_owned();
        if module == "lib" {
            continue;
        }
        let source = fs::read_to_string(&path).expect("a source file");
        for name in mentions(&source) {
            let fine = if name == module || name == "error" {
                true
            } else if module == "oracle" {
                ORACLE_MAY_USE.contains(&name.as_str())
            } else if name == "oracle" {
                module == "python"
            } else {
                match (rank(&module), rank(&name)) {
                    (Some(own), Some(other)) => other < own,
                    _ => false,
                }
            };
            if !fine {
                wrong.push(format!("{} names crate::{name}", relative.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "imports against the layers:\n{}", wrong.join("\n"));
}

#[test]
fn unsafe_stays_in_the_kernel_layer() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    files(&root, &mut found);
    for path in found.iter().filter(|p| !p.starts_with(root.join("kernel"))) {
        let source = fs::read_to_string(path).expect("a source file");
        let code = source.lines().map(|l| l.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n");
        assert!(!code.contains("unsafe"), "{} has unsafe code", path.display());
    }
}
