//! The committed code of the messages is what their `.proto` files say. Whoever changes those runs this once with GONIO_GENERATE=1:
//! the compilers are written in Rust, and no `protoc` is needed.

#![allow(clippy::unwrap_used)] // a test fails by panicking

use std::collections::BTreeMap;
use std::path::Path;

const SOURCES: [&str; 3] = ["farm.proto", "journal.proto", "externalscaler.proto"];

/// The files of a folder by name.
fn files(folder: &Path) -> BTreeMap<String, String> {
    let read = |entry: std::io::Result<std::fs::DirEntry>| {
        let entry = entry.unwrap();
        (entry.file_name().into_string().unwrap(), std::fs::read_to_string(entry.path()).unwrap())
    };
    std::fs::read_dir(folder).unwrap().map(read).collect()
}

#[test]
fn code_is_what_the_proto_files_say() {
    let crate_folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let committed = crate_folder.join("src/generated");
    let fresh = tempfile::tempdir().unwrap();
    let to = if std::env::var_os("GONIO_GENERATE").is_some() { committed.as_path() } else { fresh.path() };
    tonic_prost_build::configure()
        // Film and blob payloads are sliced out of the received buffer, not copied.
        .bytes(".")
        .out_dir(to)
        .compile_fds(protox::compile(SOURCES, [crate_folder]).unwrap())
        .unwrap();
    let (made, there) = (files(to), files(&committed));
    assert_eq!(made.keys().collect::<Vec<_>>(), there.keys().collect::<Vec<_>>());
    for (name, text) in &made {
        // A whole file in a message would hide what differs.
        let line = text.lines().zip(there[name].lines()).position(|(a, b)| a != b);
        assert!(
            *text == there[name],
            "src/generated/{name} is not what the .proto files say (line {line:?}): GONIO_GENERATE=1 cargo test --test generated"
        );
    }
}
