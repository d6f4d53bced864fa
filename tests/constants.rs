//! The list of constants in docs/development/constants.md against the constants of `src`.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

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

/// Return name, type and value of the constant that a line defines; the value is empty where it continues on the next line.
fn constant(line: &str) -> Option<(&str, &str, &str)> {
    let line = line.trim();
    let line = line
        .strip_prefix("pub")
        .map_or(line, |rest| rest.split_once(' ').map_or(rest, |(_, l)| l));
    let (name, rest) = line.strip_prefix("const ")?.split_once(": ")?;
    let (kind, value) = rest.split_once(" =")?;
    let value = value.split_once(';').map_or("", |(value, _)| value.trim());
    Some((name, kind, value))
}

/// Return the constants of `src` outside of unit tests: (file, name) to (type, value).
fn constants() -> BTreeMap<(String, String), (String, String)> {
    let source = root().join("src");
    let mut files = Vec::new();
    rust_files(&source, &mut files);
    assert!(files.len() > 100, "only {} files found", files.len());
    let mut found = BTreeMap::new();
    for file in files {
        let place = file.strip_prefix(&source).unwrap().to_str().unwrap();
        if place.ends_with("/testing.rs") || place.ends_with("/tests.rs") {
            continue;
        }
        let text = fs::read_to_string(&file).unwrap();
        let text = text.split("#[cfg(test)]\nmod tests").next().unwrap();
        for (name, kind, value) in text.lines().filter_map(constant) {
            let key = (place.to_string(), name.to_string());
            found.insert(key, (kind.to_string(), value.to_string()));
        }
    }
    found
}

/// Return the rows of the list: (file, name) to value.
fn listed() -> BTreeMap<(String, String), String> {
    let text = fs::read_to_string(root().join("docs/development/constants.md")).unwrap();
    let mut found = BTreeMap::new();
    for row in text.lines().filter(|line| line.starts_with("| `")) {
        let cells: Vec<&str> = row
            .split('|')
            .map(|cell| cell.trim().trim_matches('`'))
            .collect();
        let key = (cells[2].to_string(), cells[1].to_string());
        assert!(
            found.insert(key, cells[3].to_string()).is_none(),
            "twice in the list: {row}"
        );
    }
    found
}

#[test]
fn every_constant_of_floating_type_is_in_the_list() {
    let listed = listed();
    let missing: Vec<String> = constants()
        .into_iter()
        .filter(|(key, (kind, _))| kind.contains("f64") && !listed.contains_key(key))
        .map(|((file, name), _)| format!("{name} of src/{file}"))
        .collect();
    assert!(
        missing.is_empty(),
        "missing in docs/development/constants.md: {missing:#?}"
    );
}

#[test]
fn every_constant_of_the_list_exists_with_its_value() {
    let constants = constants();
    let mut wrong = Vec::new();
    for ((file, name), value) in listed() {
        match constants.get(&(file.clone(), name.clone())) {
            None => wrong.push(format!("no {name} in src/{file}")),
            Some((_, own)) if value != "table" && *own != value => {
                wrong.push(format!("{name} of src/{file} is {own}, listed as {value}"));
            }
            Some((_, own)) => assert!(
                value != "table" || own.is_empty() || own.starts_with(['[', '(']),
                "{name} of src/{file} is no table: {own}"
            ),
        }
    }
    assert!(
        wrong.is_empty(),
        "docs/development/constants.md: {wrong:#?}"
    );
}

#[test]
fn constants_are_found_in_all_forms_of_definition() {
    let found = |line| constant(line).map(|(name, kind, _)| (name, kind));
    assert_eq!(constant("const A: f64 = 1e-3;"), Some(("A", "f64", "1e-3")));
    assert_eq!(
        found("    pub(crate) const B: [f64; 2] = ["),
        Some(("B", "[f64; 2]"))
    );
    assert_eq!(found("pub const C: u32 = 3; // three"), Some(("C", "u32")));
    assert_eq!(found("const RUBBED: bool,"), None);
    assert_eq!(found("pub const fn length() -> f64 {"), None);
}
