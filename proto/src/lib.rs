//! gonio-proto
