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

/// Return the files of `src` outside of unit tests, and their texts.
fn sources() -> Vec<(String, String)> {
    let source = root().join("src");
    let mut files = Vec::new();
    rust_files(&source, &mut files);
    assert!(files.len() > 100, "only {} files found", files.len());
    let mut found = Vec::new();
    for file in files {
        let place = file.strip_prefix(&source).unwrap().to_str().unwrap();
        if !place.ends_with("/testing.rs") && !place.ends_with("/tests.rs") {
            let text = fs::read_to_string(&file).unwrap();
            let text = text.split("#[cfg(test)]\nmod tests").next().unwrap();
            found.push((place.to_string(), text.to_string()));
        }
    }
    found
}

/// Return the constants of `src` outside of unit tests: (file, name) to (type, value).
fn constants() -> BTreeMap<(String, String), (String, String)> {
    let mut found = BTreeMap::new();
    for (place, text) in sources() {
        for (name, kind, value) in text.lines().filter_map(constant) {
            let key = (place.clone(), name.to_string());
            found.insert(key, (kind.to_string(), value.to_string()));
        }
    }
    found
}

/// Numbers with a negative exponent that are no constants: (file, number). A formula of ISO 606 has its coefficient in millimetres.
const COEFFICIENTS: [(&str, &str); 1] = [("geometry/tooth/iso.rs", "0.069e-3")];

/// Return the text without comments and contents of strings.
fn code(text: &str) -> String {
    let text = text.replace("'\"'", "").replace("'\\\"'", "");
    let mut found = String::new();
    let (mut rest, mut in_string) = (text.as_str(), false);
    while let Some(next) = rest.chars().next() {
        let mut taken = next.len_utf8();
        if in_string && next == '\\' {
            taken = 2;
        } else if next == '"' {
            in_string = !in_string;
        } else if !in_string && rest.starts_with("//") {
            taken = rest.find('\n').unwrap_or(rest.len());
        } else if !in_string {
            found.push(next);
        }
        rest = &rest[taken..];
    }
    found
}

/// Return the numbers with a negative exponent outside of `const` and `static` items and of modules for tests.
fn small_numbers(text: &str) -> Vec<String> {
    let code = code(text);
    let mut found = Vec::new();
    let (mut item, mut depth, mut in_tests) = (false, 0_i32, false);
    let mut before = "";
    for line in code.lines() {
        in_tests |= before == "#[cfg(test)]" && line.ends_with('{');
        before = line;
        if in_tests {
            in_tests = line != "}";
            continue;
        }
        if constant(&line.replacen("static ", "const ", 1)).is_some() {
            (item, depth) = (true, 0);
        }
        for word in line.split(|c: char| !c.is_alphanumeric() && !"._-".contains(c)) {
            let parts = word.to_lowercase();
            let number = parts.rsplit_once("e-").is_some_and(|(digits, power)| {
                let digits = digits.rsplit('-').next().unwrap_or_default();
                digits.starts_with(|c: char| c.is_ascii_digit())
                    && !digits.contains(char::is_alphabetic)
                    && power.starts_with(|c: char| c.is_ascii_digit())
            });
            if number && !item {
                found.push(word.trim_start_matches('-').to_string());
            }
        }
        // An item ends at a semicolon outside of brackets, as in `[f64; 2]`.
        for c in line.chars() {
            depth += i32::from("([{".contains(c)) - i32::from(")]}".contains(c));
            item &= c != ';' || depth > 0;
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
fn small_numbers_stand_in_constants() {
    let mut found = Vec::new();
    for (place, text) in sources() {
        found.extend(small_numbers(&text).into_iter().map(|n| (place.clone(), n)));
    }
    let expected = COEFFICIENTS.map(|(place, number)| (place.to_string(), number.to_string()));
    assert_eq!(found, expected, "numbers outside of constants");
}

#[test]
fn small_numbers_are_found_outside_of_constants_comments_strings_and_tests() {
    for line in [
        "    if x > 1e-9 {",
        "let a = value-2.5E-3;",
        "f(-1e-12, [0.1])",
        "x * 1_0e-3f64",
        "let q = '\"'; 1e-9",
        "const fn f() -> f64 { 1e-9 }",
        "    const RUBBED: bool,\n> { 1e-9 }",
        "static A: f64 = 1e-9;\n1e-9",
    ] {
        assert_eq!(small_numbers(line).len(), 1, "{line}");
    }
    for line in [
        "const A: f64 = 1e-9;",
        "    pub(super) static A: [f64; 2] = [\n    1e-9,\n    2e-9,\n];",
        "// 1e-9",
        "\"to 1e-9 \\\" and \\\n 1e-9\"; a // 1e-9",
        "size-1; 1e9; 0x1e-9; name1e-9",
        "#[cfg(test)]\nmod checks {\n    1e-9\n}\n",
    ] {
        assert_eq!(small_numbers(line), Vec::<String>::new(), "{line}");
    }
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
