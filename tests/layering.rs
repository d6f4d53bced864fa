//! The direction of imports between the folders of `src`, as docs/development/architecture.md states it, and between files.

#![allow(clippy::unwrap_used)]

use std::collections::{BTreeMap, BTreeSet};
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

/// Imports of each module, by its path from the root of the crate; those of its own parents are left out.
type Imports = BTreeMap<Vec<String>, BTreeSet<Vec<String>>>;

/// Path of the module in a file, from the root of the crate.
fn module_of(relative: &Path) -> Vec<String> {
    let names = relative.with_extension("");
    let mut names: Vec<String> = names
        .iter()
        .map(|name| name.to_str().unwrap().to_string())
        .collect();
    if names.last().is_some_and(|name| name == "mod") {
        names.pop();
    }
    names
}

/// What stands behind `use` in a text.
fn imported_trees(text: &str) -> Vec<String> {
    let mut lines = text.lines().map(str::trim);
    let mut found = Vec::new();
    while let Some(line) = lines.next() {
        let begins = line.starts_with("use ") || line.starts_with("pub");
        let Some((_, tree)) = line.split_once("use ").filter(|_| begins) else {
            continue;
        };
        let mut tree = tree.to_string();
        while !tree.ends_with(';') {
            tree.push_str(lines.next().unwrap());
        }
        found.push(tree.trim_end_matches(';').to_string());
    }
    found
}

/// Paths that a tree of imports such as `a::{b, c::{d, e}}` has.
fn paths(tree: &str) -> Vec<String> {
    let Some((before, rest)) = tree.split_once('{') else {
        return vec![tree.trim().to_string()];
    };
    let inside = rest.rsplit_once('}').unwrap().0;
    let (mut depth, mut parts) = (0, vec![String::new()]);
    for c in inside.chars() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            _ => {}
        }
        if c == ',' && depth == 0 {
            parts.push(String::new());
        } else {
            parts.last_mut().unwrap().push(c);
        }
    }
    let parts = parts.iter().filter(|part| !part.trim().is_empty());
    parts
        .flat_map(|part| paths(part))
        .map(|path| format!("{}{path}", before.trim()))
        .collect()
}

/// Module that a path of an import in `module` names, the longest that `exists`.
fn resolved(
    module: &[String],
    path: &str,
    exists: impl Fn(&[String]) -> bool,
) -> Option<Vec<String>> {
    let mut steps = path.split("::").map(str::trim).peekable();
    // From the root, or from this module: its parts and other crates, too.
    let mut at = if *steps.peek()? == "crate" {
        Vec::new()
    } else {
        module.to_vec()
    };
    for step in steps {
        match step {
            "crate" | "self" => {}
            "super" => {
                at.pop();
            }
            name => at.push(name.to_string()),
        }
    }
    while !at.is_empty() && !exists(&at) {
        at.pop();
    }
    (!at.is_empty()).then_some(at)
}

fn imports_between_files(root: &Path) -> Imports {
    let mut files = Vec::new();
    rust_files(root, &mut files);
    let modules: BTreeMap<Vec<String>, &PathBuf> = files
        .iter()
        .map(|file| (module_of(file.strip_prefix(root).unwrap()), file))
        .filter(|(module, _)| !module.contains(&"tests".to_string()))
        .collect();
    let mut imports = Imports::new();
    for (module, file) in &modules {
        let text = fs::read_to_string(file).unwrap();
        let text = text.split("#[cfg(test)]\nmod tests").next().unwrap();
        let found = imports.entry(module.clone()).or_default();
        for tree in imported_trees(text) {
            for path in paths(&tree) {
                let exists = |at: &[String]| modules.contains_key(at);
                if let Some(other) = resolved(module, &path, exists)
                    && !module.starts_with(&other)
                    // What a module hands on of its own parts.
                    && !other.starts_with(module)
                {
                    found.insert(other);
                }
            }
        }
    }
    imports
}

/// Modules that import each other in a circle, if there are any.
fn circle(imports: &Imports) -> Option<Vec<String>> {
    fn visit<'a>(
        module: &'a Vec<String>,
        imports: &'a Imports,
        open: &mut Vec<&'a Vec<String>>,
        done: &mut BTreeSet<&'a Vec<String>>,
    ) -> Option<Vec<String>> {
        if let Some(begin) = open.iter().position(|other| *other == module) {
            return Some(open[begin..].iter().map(|names| names.join("/")).collect());
        }
        if !done.insert(module) {
            return None;
        }
        open.push(module);
        let mut others = imports.get(module).into_iter().flatten();
        let found = others.find_map(|other| visit(other, imports, open, done));
        open.pop();
        found
    }
    let mut done = BTreeSet::new();
    imports
        .keys()
        .find_map(|module| visit(module, imports, &mut Vec::new(), &mut done))
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let imports = imports_between_files(&root);
    let count: usize = imports.values().map(BTreeSet::len).sum();
    assert!(count > 800, "only {count} imports found");
    assert_eq!(circle(&imports), None);
}

#[test]
fn a_circle_of_imports_is_found() {
    assert_eq!(
        paths("a::{b, c::{d, e::F}, g}"),
        ["a::b", "a::c::d", "a::c::e::F", "a::g"]
    );
    let names = |path: &str| -> Vec<String> { path.split('/').map(str::to_string).collect() };
    let exists = |at: &[String]| ["a", "a/b", "c"].contains(&at.join("/").as_str());
    for (path, expected) in [
        ("super::b::Thing", Some("a/b")),
        ("crate::c::function", Some("c")),
        ("super::super::c", Some("c")),
    ] {
        let found = resolved(&names("a/x"), path, exists);
        assert_eq!(found, expected.map(names), "{path}");
    }
    let of = |edges: &[(&str, &str)]| {
        let mut imports = Imports::new();
        for (from, to) in edges {
            imports.entry(names(from)).or_default().insert(names(to));
        }
        circle(&imports)
    };
    assert_eq!(of(&[("a", "b"), ("a", "c"), ("b", "c")]), None);
    let found = of(&[("a", "b"), ("b", "c"), ("c", "d"), ("d", "b")]).unwrap();
    assert_eq!(found, ["b", "c", "d"]);
}
