//! gonio-tracer
