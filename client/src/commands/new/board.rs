//! The board that the parts stand on, as objects.

use crate::commands::draft::Place;
use crate::failure::Failure;
use gonio_calibrate::{Board, Draft};
use gonio_scene::capture::{Material, Model, Object};
use gonio_scene::mesh::{Mesh, write_ply};

/// Name, and the share of light that is reflected: of matt paper and of toner, by measurements of laser prints between 0.75 and
/// 0.85, and between 0.03 and 0.06.
const PARTS: [(&str, f64); 2] = [("board-white", 0.8), ("board-black", 0.04)];

/// Writes the board's meshes beside the capture and adds them, in the plane z = 0 of the world.
///
/// # Errors
/// A disk that cannot be written to.
pub(super) fn add(place: &Place, board: &Board, draft: &mut Draft) -> Result<(), Failure> {
    for ((name, color), mesh) in PARTS.into_iter().zip(board.meshes()) {
        let file = format!("{name}.ply");
        place.add(&file, &write_ply(&Mesh { ..mesh }))?;
        let model = Model::Lambert { base_color: [color; 3] };
        draft.capture.materials.push(Material { name: name.to_owned(), model, ..Material::default() });
        draft.guess("[[material]]", name, "base_color", "of printed paper; measure it, or free it under [fit] as gray");
        let (mesh, material) = (file, name.to_owned());
        draft.capture.objects.push(Object { name: name.to_owned(), mesh, material, ..Object::default() });
    }
    Ok(())
}
