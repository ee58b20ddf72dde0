//! Generates the messages and services of `farm.proto` and `journal.proto`, with a compiler written in Rust: no `protoc` is needed.

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("cargo:rerun-if-changed=farm.proto");
    println!("cargo:rerun-if-changed=journal.proto");
    let descriptors = protox::compile(["farm.proto", "journal.proto"], ["."])?;
    tonic_prost_build::configure()
        // Film and blob payloads are sliced out of the received buffer, not copied.
        .bytes(".")
        .compile_fds(descriptors)?;
    Ok(())
}
