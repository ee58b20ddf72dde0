//! Which derivative image a number of the scene feeds.

use gonio_scene::derivative::{Plan, Plane};

/// Index of a forward derivative plane, if the number is wanted.
pub type PlaneIndex = Option<usize>;

/// The plane of `plan` that holds the derivative by `name`, a colour's or a number's dotted name.
#[must_use]
pub fn find(plan: &Plan, name: &str) -> PlaneIndex {
    plan.planes.iter().position(|plane| match plane {
        Plane::Colour { prefix } => prefix == name,
        Plane::Scalar { number } => number == name,
        Plane::Difference { .. } => false,
    })
}
