//! Shows what a simulation gets wrong: from photographs and a fitted model to a named cause, an extended model and a measured
//! gain, or to "nothing", or to "something, but none of these".
//!
//! [`diagnose`] fits the base model, scores every effect of the [`effects::CATALOGUE`] at its null in one pass, fits those that
//! promise most, adds what survives cross-validation between photos, and judges the outcome on photos that nothing
//! before has read. Like a fit, it knows nothing of where a photo is rendered: it takes a [`Workshop`].

mod advance;
mod backward;
pub mod context;
pub mod covariates;
mod cross;
mod diagnose;
pub mod effects;
mod error;
mod event;
mod finer;
mod folds;
mod judge;
mod measured;
mod model;
mod options;
mod overlay;
pub mod probe;
mod quadratic;
mod ranking;
mod reduced;
mod refit;
mod result;
pub mod score;
mod search;
mod select;
mod shortlist;
mod structure;
mod trial;
pub mod variant;
mod workshop;

pub use diagnose::{Diagnosed, diagnose};
pub use error::DiagnoseError;
pub use event::DiagnoseEvent;
pub use judge::Judgement;
pub use model::{Model, Part};
pub use options::Options;
pub use overlay::{AddedFile, Overlay};
pub use result::{Considered, Diagnosis, Finding, FoundParameter, HeldOut, Verdict};
pub use structure::{STRONG, Seen, Structure};
pub use workshop::{Observer, Workshop};
