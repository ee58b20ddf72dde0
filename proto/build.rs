//! Generates the messages and services of the `.proto` files, with a compiler written in Rust: no `protoc` is needed.

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let files = ["farm.proto", "journal.proto", "externalscaler.proto"];
    for file in files {
        println!("cargo:rerun-if-changed={file}");
    }
    let descriptors = protox::compile(files, ["."])?;
    tonic_prost_build::configure()
        // Film and blob payloads are sliced out of the received buffer, not copied.
        .bytes(".")
        .compile_fds(descriptors)?;
    Ok(())
}
