//! From raw photographs to what a capture is made of: linear light from RAW files, a camera's noise and colours, radiance maps
//! from exposure stacks, mattes from two backdrops, views over a hemisphere, and composites of such views.
//!
//! Pure: images and numbers go in, images, numbers and files' bytes come out. What is read from where is for the command
//! line. Every refusal is a [`SceneError`](gonio_scene::SceneError): one line that names file, key and mend.

pub mod chart;
pub mod composite;
pub mod hdr;
pub mod matte;
pub mod noise;
pub mod plan;
pub mod raw;
pub mod stored;
