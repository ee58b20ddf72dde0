//! Where the cameras of a capture come from: poses that others estimated, a calibration with a ChArUco board, a chessboard
//! or a grid of markers, and the draft of a `capture.toml` in which every guess is marked.
//!
//! Does no I/O: texts, gray images and sizes come in, cameras and the capture's text go out.

mod align;
mod board;
mod draft;
mod geometry;
mod homography;
mod import;
mod json;
mod solve;
mod view;

pub use align::{Ambiguity, Click, Contour, Field, Placed, Station, from_clicks, from_outlines};
pub use board::{Board, Corner, Sighting};
pub use draft::{Draft, Part, ring};
pub use geometry::{Pose, project};
pub use import::{bop, colmap, colmap_binary, transforms};
pub use solve::{Calibration, Model, PhotoFit, Refusal, calibrate, determines_pose, locate};
pub use view::{Imported, Located, View};
