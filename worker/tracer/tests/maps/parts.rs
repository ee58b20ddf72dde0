//! Several materials in one mesh.

use crate::fixture::{SIDE, SKY, World, film, plane, square};

/// The left half is of one material of the file, the right half of another.
const HALVES: &str = "mtllib halves.mtl\nv -0.5 -0.5 0\nv 0 -0.5 0\nv 0 0.5 0\nv -0.5 0.5 0\nv 0.5 -0.5 0\nv 0.5 0.5 0\n\
                      usemtl left\nf 1 2 3 4\nusemtl right\nf 2 5 6 3\n";

fn world(materials: &str) -> World {
    let mut world = World::new("model = \"lambert\"\nbase_color = [0.5, 0.5, 0.5]\n", square(None));
    world.add("halves.obj", HALVES.as_bytes().to_vec());
    world.add("halves.mtl", b"newmtl left\nKd 0.2 0.4 0.6\nnewmtl right\nKd 0.8 0.8 0.1\n".to_vec());
    world.more = format!(
        "[[material]]\nname = \"red\"\nmodel = \"lambert\"\nbase_color = [0.9, 0.1, 0.1]\n\
         [[material]]\nname = \"said\"\nmodel = \"lambert\"\nbase_color = [1, 1, 1]\nbase_color_map = \"mesh\"\n\
         [[object]]\nname = \"halves\"\nmesh = \"halves.obj\"\n{materials}\n"
    );
    // Above the square, which it hides.
    world.more = world.more.replace(
        "mesh = \"halves.obj\"",
        "mesh = \"halves.obj\"\nobject_to_world = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.01], [0, 0, 0, 1]]",
    );
    world
}

fn colours(world: &World) -> [[f64; 3]; 2] {
    let render = plane(&film(&world.stage().prepare(&[], &[]).unwrap(), 2), 0);
    let row = (SIDE * SIDE / 2) as usize;
    [row + 4, row + SIDE as usize - 4].map(|pixel| [0, 1, 2].map(|c| render[pixel][c] / SKY[c]))
}

fn close(found: [[f64; 3]; 2], expected: [[f64; 3]; 2]) {
    for (found, expected) in found.as_flattened().iter().zip(expected.as_flattened()) {
        assert!((found - expected).abs() < 1e-4, "{found} for {expected}");
    }
}

#[test]
fn parts_have_the_materials_that_the_object_names() {
    let gray = [0.5; 3];
    close(colours(&world("material = \"paint\"\n[object.materials]\nright = \"red\"")), [gray, [0.9, 0.1, 0.1]]);
    close(colours(&world("material = \"red\"\n[object.materials]\nright = \"paint\"")), [[0.9, 0.1, 0.1], gray]);
}

#[test]
fn the_file_s_own_colours_are_factors() {
    close(colours(&world("material = \"said\"")), [[0.2, 0.4, 0.6], [0.8, 0.8, 0.1]]);
    close(
        colours(&world("material = \"said\"\n[object.materials]\nleft = \"red\"")),
        [[0.9, 0.1, 0.1], [0.8, 0.8, 0.1]],
    );
}

#[test]
fn a_part_s_number_moves_that_part() {
    let world = world("material = \"paint\"\n[object.materials]\nright = \"red\"");
    let prepared = world.stage().prepare(&[], &world.columns(&["material.red.base_color"])).unwrap();
    let derivative = plane(&film(&prepared, 2), 1);
    let row = (SIDE * SIDE / 2) as usize;
    assert_eq!(derivative[row + 4], [0.0; 3]);
    for c in 0..3 {
        assert!((derivative[row + SIDE as usize - 4][c] / SKY[c] - 1.0).abs() < 1e-3);
    }
}
