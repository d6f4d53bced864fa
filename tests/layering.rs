//! The direction of imports between the folders of `src`, as docs/development/architecture.md states it.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};

/// Folders from the bottom to the top. A folder imports from those before it and from itself.
///
/// `chain` and `multibody` are two systems side by side: neither imports the other.
const FOLDERS: [&str; 14] = [
    "error",
    "panics",
    "math",
    "geometry",
    "force_law",
    "integrator",
    "drive",
    "layout",
    "system",
    "chain",
    "multibody",
    "run",
    "fmu",
    "python",
];

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
}

/// Names that stand behind `crate::` in the text, unit tests and comments left out.
fn imported(text: &str) -> impl Iterator<Item = String> + '_ {
    let text = text.split("#[cfg(test)]\nmod tests").next().unwrap();
    text.lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .flat_map(|line| line.split("crate::").skip(1))
        .map(|rest| {
            rest.chars()
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect()
        })
}

fn rank(name: &str) -> Option<usize> {
    FOLDERS.iter().position(|folder| *folder == name)
}

/// Whether `folder` may import from `other`.
fn may_import(folder: &str, other: &str) -> bool {
    let side_by_side = folder == "multibody" && other == "chain";
    folder == other || (rank(other) < rank(folder) && !side_by_side)
}

#[test]
fn every_import_goes_down_the_list_of_folders() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    rust_files(&root, &mut files);
    assert!(files.len() > 100, "only {} files found", files.len());
    let mut against = Vec::new();
    for file in &files {
        let relative = file.strip_prefix(&root).unwrap();
        let first = relative.components().next().unwrap().as_os_str();
        let folder = first.to_str().unwrap().trim_end_matches(".rs");
        if folder == "lib" {
            continue;
        }
        assert!(
            rank(folder).is_some(),
            "src/{folder} is not in the list of folders of this test"
        );
        let text = fs::read_to_string(file).unwrap();
        for name in imported(&text) {
            // A group in braces, or what the root re-exports, hides the folder.
            if rank(&name).is_none() {
                against.push(format!(
                    "{} imports `crate::{name}`: name the folder",
                    relative.display()
                ));
            } else if !may_import(folder, &name) {
                against.push(format!("{} imports {name}", relative.display()));
            }
        }
    }
    assert!(
        against.is_empty(),
        "imports against the direction:\n{}",
        against.join("\n")
    );
}

#[test]
fn an_import_against_the_direction_is_found() {
    assert!(!may_import("force_law", "run"));
    assert!(!may_import("multibody", "chain"));
    assert!(!may_import("chain", "multibody"));
    assert!(may_import("run", "chain"));
    let text = "use crate::run::Simulation;\n// crate::python\nuse crate::{chain::X, Drive};\nuse crate::Drive;\n";
    let names: [String; 3] = imported(text).collect::<Vec<_>>().try_into().unwrap();
    assert_eq!(names, ["run", "", "Drive"]);
    assert_eq!(
        names.map(|name| rank(&name).is_some()),
        [true, false, false]
    );
}
