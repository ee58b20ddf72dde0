//! gonio
