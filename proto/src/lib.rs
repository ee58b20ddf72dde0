//! What crosses a process boundary: the messages of `farm.proto` and, from one coordinator to the next, of `journal.proto`; and their conversions to and from domain types.
//!
//! [`wire`] holds the generated code, which is committed so that no build waits for its compilers (`tests/generated.rs` makes it); nothing outside [`convert`] should look into a message without having it checked
//! there first.

pub mod convert;
pub mod limits;
pub mod pem;

/// Generated from `farm.proto` and `journal.proto`, whose comments say who speaks first and what zero means.
#[allow(missing_docs, clippy::all, unused_qualifications)]
pub mod wire {
    include!("generated/gonio.farm.v1.rs");
}

/// Generated from `externalscaler.proto`: what KEDA asks of the coordinator.
#[allow(missing_docs, clippy::all, unused_qualifications)]
pub mod scaler {
    include!("generated/externalscaler.rs");
}

pub use convert::{Digest, Key, WireError};

/// The version of the protocol and of everything that shapes a film: a farm's programs all have the same.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
