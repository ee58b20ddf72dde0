//! gonio-fit
