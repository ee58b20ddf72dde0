//! How large a camera's noise is, measured from its photographs: variance over mean is a line (Janesick, "Photon transfer",
//! SPIE 2007), its start the square of the read noise, its slope the shot noise.
//!
//! Photos that show the same scene are a burst: the variance is that between them. A photo without such a partner is
//! searched for flat tiles: the variance is that about a smooth surface. Either way two variances are measured: a pixel's
//! own, and what its neighbours share with it (the noise's power at frequency zero, the sum of its covariances). Where the
//! second is larger, by JPEG or demosaicing, pixels are fewer independent observations than their number says, and the
//! second is what a mean over many of them obeys.

mod burst;
mod jpeg;
mod level;
mod light;
mod line;
mod measure;
mod patch;
mod plot;
mod single;

pub use jpeg::{Blocks, blocks};
pub use level::Level;
pub use light::Curve;
pub use line::Line;
pub use measure::{Channel, Noise, Photo, measure};
pub use patch::{Patch, crop};
pub use plot::plot;
