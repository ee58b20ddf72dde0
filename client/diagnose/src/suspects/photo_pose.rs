//! A single photo that was not taken from where the file says: the camera's move along and turn about its own axes.

use crate::effects::{Direction, Effect, Family, Variant, xyz};

/// The suspect.
pub const SUSPECT: Effect = Effect {
    name: "photo-pose",
    family: Family::Geometry,
    looks: "dipoles along edges, in one photo alone",
    looks_like: &["pose-error", "principal-point"],
    separate_by: "calibrate that photo's pose again, or leave it out",
    variants: |context| {
        let names = |key: &str| -> Vec<[String; 3]> {
            context.photos().map(|p| xyz(&format!("photo.{}.{key}", p.name()))).collect()
        };
        let (shifts, turns) = (names("translation"), names("rotation"));
        let axis = |all: &[[String; 3]], axis: usize| -> Vec<String> { all.iter().map(|n| n[axis].clone()).collect() };
        let shift = [0, 1, 2].map(|i| (axis(&shifts, i), 0.02));
        let turn = [0, 1, 2].map(|i| (axis(&turns, i), 0.1));
        let suspect = |(photo, p): (usize, &gonio_scene::capture::Photo)| {
            let each = shift.iter().chain(&turn);
            let directions = each.filter_map(|(names, most)| Direction::of_photo(names, photo, 0.0, *most)).collect();
            Variant { of_photos: true, suspect: Some(photo), ..Variant::of(format!("photo {}", p.name()), directions) }
        };
        let known = |p: &gonio_scene::capture::Photo| context.frees(&format!("photo.{}.translation", p.name()));
        if context.photos().any(known) { Vec::new() } else { context.photos().enumerate().map(suspect).collect() }
    },
};
