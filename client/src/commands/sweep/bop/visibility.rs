//! Silhouettes: where an object would be seen, and where it is.

use crate::failure::Failure;
use glam::DVec3;
use gonio_pose::bop::Visibility;
use gonio_pose::render::visible;
use gonio_pose::{Intrinsics, Pose};
use gonio_scene::mesh::Mesh;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};

/// An affine placement in front of a camera: what is scaled hides as well.
pub(super) struct Placed([[f64; 4]; 3]);

impl Placed {
    /// The way from a mesh's coordinates to a camera's.
    pub fn new(placement: &[[f64; 4]; 4], camera_to_world: &[[f64; 4]; 4]) -> Self {
        // The camera's rotation transposed, after its place is taken off.
        Self([0, 1, 2].map(|i| {
            let along = |column: usize| (0..3).map(|k| camera_to_world[k][i] * placement[k][column]).sum::<f64>();
            let shift = (0..3).map(|k| camera_to_world[k][i] * (placement[k][3] - camera_to_world[k][3])).sum();
            [along(0), along(1), along(2), shift]
        }))
    }

    /// z of what each pixel sees of a mesh, metres; 0 where it sees none.
    pub fn depth(&self, mesh: &Mesh, camera: &Intrinsics, (width, height): (u32, u32)) -> Vec<f32> {
        let place = |p: &[f32; 3]| {
            let [x, y, z] = p.map(f64::from);
            DVec3::from_array(self.0.map(|row| row[0] * x + row[1] * y + row[2] * z + row[3]))
        };
        let points: Vec<DVec3> = mesh.positions.iter().map(place).collect();
        visible(&points, &mesh.triangles, camera, width, height).metres
    }
}

/// What is said of an object whose silhouette in the image is `whole`, and `seen` where nothing hides it.
pub(super) fn visibility(
    mesh: &Mesh,
    pose: &Pose,
    camera: &Intrinsics,
    size: (u32, u32),
    whole: &[bool],
    seen: &[bool],
) -> Visibility {
    let (in_image, own_box) = extent(whole, size.0, (0, 0));
    let (visible_count, visible_box) = extent(seen, size.0, (0, 0));
    let [column, row, width, height] = own_box;
    let touches = in_image == 0
        || column == 0
        || row == 0
        || column + width == i64::from(size.0)
        || row + height == i64::from(size.1);
    let (all, all_box) = if touches {
        // As BOP's toolkit does: on a canvas three times as wide and high.
        let canvas = (3 * size.0, 3 * size.1);
        let wide = Intrinsics { cx: camera.cx + f64::from(size.0), cy: camera.cy + f64::from(size.1), ..*camera };
        let points: Vec<DVec3> =
            mesh.positions.iter().map(|p| pose.apply(DVec3::from_array(p.map(f64::from)))).collect();
        let depth = visible(&points, &mesh.triangles, &wide, canvas.0, canvas.1).metres;
        let silhouette: Vec<bool> = depth.iter().map(|z| *z > 0.0).collect();
        extent(&silhouette, canvas.0, (i64::from(size.0), i64::from(size.1)))
    } else {
        (in_image, own_box)
    };
    Visibility { all, valid: in_image, visible: visible_count, all_box, visible_box }
}

/// How many pixels are set, and the box around them, its corner less `corner`.
fn extent(pixels: &[bool], width: u32, corner: (i64, i64)) -> (u64, [i64; 4]) {
    let mut count = 0;
    let (mut low, mut high) = ([i64::MAX; 2], [i64::MIN; 2]);
    for (index, _) in pixels.iter().enumerate().filter(|(_, set)| **set) {
        count += 1;
        #[allow(clippy::cast_possible_wrap)] // an image's sides
        let place = [(index % width as usize) as i64, (index / width as usize) as i64];
        for axis in 0..2 {
            low[axis] = low[axis].min(place[axis]);
            high[axis] = high[axis].max(place[axis]);
        }
    }
    if count == 0 {
        return (0, [-1; 4]);
    }
    (count, [low[0] - corner.0, low[1] - corner.1, high[0] - low[0] + 1, high[1] - low[1] + 1])
}

/// A mask's file: 255 where it is set.
pub(super) fn mask(pixels: &[bool], (width, height): (u32, u32)) -> Result<Vec<u8>, Failure> {
    let values: Vec<u8> = pixels.iter().map(|set| if *set { 255 } else { 0 }).collect();
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes)
        .write_image(&values, width, height, ExtendedColorType::L8)
        .map_err(|error| Failure::Failed(format!("a mask is no PNG: {error}")))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Mesh {
        let positions = vec![[-0.1, -0.1, 0.0], [0.1, -0.1, 0.0], [0.1, 0.1, 0.0], [-0.1, 0.1, 0.0]];
        Mesh { positions, normals: None, triangles: vec![[0, 1, 2], [0, 2, 3]], degenerate: 0 }
    }

    #[test]
    fn what_lies_out_of_the_image_counts_as_hidden() {
        // 40 x 40 pixels around the left edge of an image of 60 x 50: half of it is out.
        let camera = Intrinsics { fx: 100.0, fy: 100.0, cx: -0.5, cy: 24.5 };
        let pose = Pose { translation: DVec3::new(0.0, 0.0, 0.5), ..Pose::IDENTITY };
        let placement = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.5], [0.0, 0.0, 0.0, 1.0]];
        let identity = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
        let depth = Placed::new(&placement, &identity).depth(&square(), &camera, (60, 50));
        let whole: Vec<bool> = depth.iter().map(|z| *z > 0.0).collect();
        // The upper half of the image is hidden by something.
        let seen: Vec<bool> = whole.iter().enumerate().map(|(i, set)| *set && i / 60 >= 25).collect();
        let found = visibility(&square(), &pose, &camera, (60, 50), &whole, &seen);
        assert_eq!((found.all, found.valid, found.visible), (1600, 800, 400));
        assert_eq!((found.all_box, found.visible_box), ([-20, 5, 40, 40], [0, 25, 20, 20]));
        assert_eq!(found.fraction(), 0.25);
    }

    #[test]
    fn an_object_behind_the_camera_is_nowhere() {
        let camera = Intrinsics { fx: 100.0, fy: 100.0, cx: 30.0, cy: 25.0 };
        let pose = Pose { translation: DVec3::new(0.0, 0.0, -0.5), ..Pose::IDENTITY };
        let nothing = vec![false; 3000];
        let found = visibility(&square(), &pose, &camera, (60, 50), &nothing, &nothing);
        assert_eq!((found.all, found.all_box, found.fraction()), (0, [-1; 4], 0.0));
    }
}
