//! Which derivative image a number of the scene feeds.
//!
//! A path carries only the forward planes, and among its throughput's derivatives only those of materials: these come
//! first, so that neither differences nor lights cost a path anything until it meets light.

use gonio_scene::derivative::{Plan, Plane};

/// Position of a forward derivative plane in [`Forward::planes`], if the number is wanted.
pub type PlaneIndex = Option<usize>;

/// The planes that a path carries.
pub struct Forward {
    /// Indices into the plan's planes: materials' first, then lights'.
    pub planes: Vec<usize>,
    /// How many of them are materials'.
    pub materials: usize,
}

impl Forward {
    /// The forward planes of a plan.
    #[must_use]
    pub fn new(plan: &Plan) -> Self {
        let of = |material: bool| {
            let wanted = move |(_, plane): &(usize, &Plane)| {
                name(plane).is_some_and(|name| name.starts_with("material.") == material)
            };
            plan.planes.iter().enumerate().filter(wanted).map(|(index, _)| index)
        };
        Self { planes: of(true).chain(of(false)).collect(), materials: of(true).count() }
    }
}

/// The name of what a forward plane belongs to, a colour's or a number's.
fn name(plane: &Plane) -> Option<&str> {
    match plane {
        Plane::Colour { prefix } => Some(prefix),
        Plane::Scalar { number } => Some(number),
        Plane::Difference { .. } => None,
    }
}

/// Where paths add up the derivative by `wanted`, a colour's or a number's dotted name.
#[must_use]
pub fn find(plan: &Plan, wanted: &str) -> PlaneIndex {
    let planes = Forward::new(plan).planes;
    planes.iter().position(|plane| name(&plan.planes[*plane]) == Some(wanted))
}
