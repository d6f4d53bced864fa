//! URI of the folder of resources, as FMI 2.0 has it.

use std::path::PathBuf;

use crate::error::{Error, Result};

/// Return the path of a URI of the scheme `file`.
pub(super) fn path_of(uri: &str) -> Result<PathBuf> {
    let rest = uri.strip_prefix("file:");
    let path = rest.map(|rest| match rest.strip_prefix("//") {
        // An authority stands before the path: none, or this machine.
        Some(rest) => rest.strip_prefix("localhost").unwrap_or(rest),
        None => rest,
    });
    let Some(path) = path.and_then(decoded) else {
        let expected = "must be the URI of a folder, such as file:///tmp/fmu/resources";
        return Err(Error::invalid("fmuResourceLocation", uri, expected));
    };
    // file:///C:/folder has its path behind the third slash.
    let drive = path.as_bytes().get(2) == Some(&b':') && cfg!(windows);
    Ok(PathBuf::from(&path[usize::from(drive)..]))
}

/// Return a text with %20 and the like decoded; `None` if that is no text.
fn decoded(text: &str) -> Option<String> {
    let mut bytes = Vec::new();
    let mut rest = text.as_bytes();
    while let Some((&first, behind)) = rest.split_first() {
        (bytes, rest) = if first == b'%' {
            let code = std::str::from_utf8(behind.get(..2)?).ok()?;
            bytes.push(u8::from_str_radix(code, 16).ok()?);
            (bytes, &behind[2..])
        } else {
            bytes.push(first);
            (bytes, behind)
        };
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_uri_is_a_path() {
        for (uri, path) in [
            ("file:///tmp/a%20b/resources", "/tmp/a b/resources"),
            ("file:/tmp/resources", "/tmp/resources"),
            ("file://localhost/tmp/%C3%A9", "/tmp/é"),
        ] {
            assert_eq!(path_of(uri).unwrap(), PathBuf::from(path));
        }
        for uri in [
            "/tmp/resources",
            "http://host/x",
            "file:///a%2",
            "file:///a%zz",
        ] {
            assert!(path_of(uri).is_err(), "{uri}");
        }
    }
}
