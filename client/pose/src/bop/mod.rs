//! The layout of the BOP benchmark's datasets and results:
//! <https://github.com/thodan/bop_toolkit/blob/master/docs/bop_datasets_format.md>.

mod dataset;
mod depth;
mod json;
mod model;
mod results;
mod scene;
mod targets;
mod unit;
mod write;

pub use dataset::Dataset;
pub use depth::{Depth, encode_depth};
pub use model::{Model, Models, ModelsFolder};
pub use results::{Estimate, HEADER, parse_results, write_results};
pub use scene::{Frame, Scene, Truth};
pub use targets::{Target, parse_targets};
pub(crate) use unit::millimetres;
pub use write::{Instance, ModelInfo, SceneImage, Visibility, diameter, models_info, ply, scene_files};
