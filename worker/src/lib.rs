//! gonio-worker
