//! Fits the free parameters of a capture by analysis-by-synthesis, over anything that implements [`Evaluate`].
//!
//! [`fit`] minimises chi-square between renders and the photographs that are not held out. It knows nothing of how a
//! photo is rendered, nor where: it asks for the sums over a photo's pixels (loss, normal equations) at parameters of
//! its choice.

mod checkpoint;
mod error;
pub mod evaluate;
mod event;
mod fit;
mod normal;
mod objective;
mod options;
mod result;
mod solve;
mod space;
mod transform;
mod uncertainty;
mod warnings;

pub use checkpoint::Checkpoint;
pub use error::FitError;
pub use evaluate::{Evaluate, EvaluateError, Watch};
pub use event::{FitEvent, Iteration};
pub use fit::fit;
pub use normal::{Normal, Spectrum};
pub use objective::Observer;
pub use options::{Options, SolverName};
pub use result::{Estimate, FitResult, LossPoint, Score};
pub use space::Space;
pub use transform::Transform;
