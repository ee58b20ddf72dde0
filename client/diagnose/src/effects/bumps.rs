//! Bumps: the shading normal departs from the mesh's, by a smooth height field over the object.
//!
//! The height is a sum of cosine products over the object's box (`bump`, see the format), in units of its diagonal.

use super::{Effect, Family, over_the_surface};

/// The catalogue's entry.
pub const EFFECT: Effect = Effect {
    name: "bumps",
    family: Family::Geometry,
    looks: "changes sign with the light's side",
    looks_like: &["roughness-variation", "pose-error"],
    separate_by: "light the part from three sides",
    variants: |context| context.plastics().map(|(name, _)| over_the_surface(name, "bump", 0.2)).collect(),
};
