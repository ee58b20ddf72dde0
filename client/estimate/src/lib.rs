//! A monocular estimator of poses: templates of gradient orientations over a view sphere find candidates (Hinterstoisser et
//! al. 2012, without depth), render-and-compare refines them and says which is best.
//!
//! It knows a part's mesh and a camera, and nothing of the scene: background and shading are learned from the image that
//! is looked at. Lengths are metres, poses take the model's coordinates to the camera's (OpenCV's axes), pixel
//! coordinates are BOP's (the centre of the upper left pixel is (0, 0)).

mod background;
mod candidate;
mod estimator;
mod gradient;
mod likelihood;
mod part;
mod picture;
mod refine;
mod response;
mod search;
mod shading;
mod simplify;
mod template;
mod views;

pub use estimator::{Estimator, Found, Settings};
