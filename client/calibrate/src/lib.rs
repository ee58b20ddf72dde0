//! Where the cameras of a capture come from: poses that others estimated, a calibration with a ChArUco board, and the
//! draft of a `capture.toml` in which every guess is marked.
//!
//! Does no I/O: texts, gray images and sizes come in, cameras and the capture's text go out.

mod adjust;
mod board;
mod draft;
mod geometry;
mod homography;
mod import;
mod json;
mod refine;
mod view;
mod zhang;

pub use adjust::{Calibration, PhotoFit, calibrate, determines_pose};
pub use board::{Board, Corner};
pub use draft::{Draft, Part, ring};
pub use geometry::{Pose, project};
pub use import::{bop, colmap, colmap_binary, transforms};
pub use view::{Imported, Located, View};
