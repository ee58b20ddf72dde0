//! gonio-coordinator
