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

/// The same in `src/chain`.
const CHAIN: [&str; 10] = [
    "model", "motion", "contact", "loads", "powers", "arrays", "newton", "rhs", "report",
    "dynamics",
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

/// Names that stand behind `prefix` in the text, unit tests and comments left out.
fn imported<'a>(text: &'a str, prefix: &'a str) -> impl Iterator<Item = String> + 'a {
    let text = text.split("#[cfg(test)]\nmod tests").next().unwrap();
    text.lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .flat_map(move |line| line.split(prefix).skip(1))
        .map(|rest| {
            rest.chars()
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect()
        })
}

fn rank(folders: &[&str], name: &str) -> Option<usize> {
    folders.iter().position(|folder| *folder == name)
}

/// Whether `folder` may import from `other`.
fn may_import(folders: &[&str], folder: &str, other: &str) -> bool {
    let side_by_side = folder == "multibody" && other == "chain";
    folder == other || (rank(folders, other) < rank(folders, folder) && !side_by_side)
}

/// Imports behind `prefix` in the files of `root` against the order of `folders`, and those that name no folder.
fn against(root: &Path, folders: &[&str], prefix: &str) -> Vec<String> {
    let mut files = Vec::new();
    rust_files(root, &mut files);
    assert!(files.len() > 50, "only {} files found", files.len());
    let mut against = Vec::new();
    for file in &files {
        let relative = file.strip_prefix(root).unwrap();
        let first = relative.components().next().unwrap().as_os_str();
        let folder = first.to_str().unwrap().trim_end_matches(".rs");
        if ["lib", "mod", "tests"].contains(&folder) {
            continue;
        }
        assert!(
            rank(folders, folder).is_some(),
            "{folder} in {} is not in the list of folders of this test",
            root.display()
        );
        let text = fs::read_to_string(file).unwrap();
        for name in imported(&text, prefix) {
            // A group in braces, or what the root re-exports, hides the folder.
            if rank(folders, &name).is_none() {
                against.push(format!(
                    "{} imports `{prefix}{name}`: name the folder",
                    relative.display()
                ));
            } else if !may_import(folders, folder, &name) {
                against.push(format!("{} imports {name}", relative.display()));
            }
        }
    }
    against
}

#[test]
fn every_import_goes_down_the_list_of_folders() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = against(&root, &FOLDERS, "crate::");
    found.extend(against(&root.join("chain"), &CHAIN, "crate::chain::"));
    assert!(
        found.is_empty(),
        "imports against the direction:\n{}",
        found.join("\n")
    );
}

#[test]
fn an_import_against_the_direction_is_found() {
    let may = |folder, other| may_import(&FOLDERS, folder, other);
    assert!(!may("force_law", "run"));
    assert!(!may("multibody", "chain"));
    assert!(!may("chain", "multibody"));
    assert!(may("run", "chain"));
    assert!(!may_import(&CHAIN, "newton", "rhs"));
    assert!(may_import(&CHAIN, "rhs", "newton"));
    let text = "use crate::run::Simulation;\n// crate::python\nuse crate::{chain::X, Drive};\nuse crate::Drive;\n";
    let names: [String; 3] = (imported(text, "crate::").collect::<Vec<_>>())
        .try_into()
        .unwrap();
    assert_eq!(names, ["run", "", "Drive"]);
    assert_eq!(
        names.map(|name| rank(&FOLDERS, &name).is_some()),
        [true, false, false]
    );
    let text = "use crate::chain::rhs::Kernels;\nuse crate::chain::Groups;\n";
    let names: Vec<String> = imported(text, "crate::chain::").collect();
    assert_eq!(names, ["rhs", "Groups"]);
}
