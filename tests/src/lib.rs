//! gonio-tests
