//! Shows what a simulation gets wrong: from photographs and a fitted model to a named cause, an extended model and a measured
//! gain, or to "nothing", or to "something, but none of these".
//!
//! [`diagnose`] fits the base model, scores every effect of the [`effects::CATALOGUE`] at its null in one pass, fits those that
//! promise most, adds what survives cross-validation between photos, and judges the outcome on photos that nothing
//! before has read. Like a fit, it knows nothing of where a photo is rendered: it takes a [`Workshop`].

mod conclude;
pub mod context;
pub mod decide;
mod diagnose;
pub mod effects;
mod error;
mod event;
pub mod evidence;
mod options;
mod overlay;
mod policy;
mod result;
pub mod suspects;
pub mod variant;
mod workshop;

pub use decide::Verdict;
pub use diagnose::{Diagnosed, diagnose};
pub use error::DiagnoseError;
pub use event::DiagnoseEvent;
pub use evidence::gather::structure::Seen;
pub use evidence::{ChannelNoise, Structure};
pub use options::Options;
pub use overlay::{AddedFile, Overlay};
pub use policy::Policy;
pub use result::{Considered, Diagnosis, Finding, FoundParameter, HeldOut};
pub use workshop::{Observer, Workshop};
