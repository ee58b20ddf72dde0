//! Captures whose photographs are right and whose file is wrong: one number of it, by an amount that people get wrong.

use super::world::PART;
use gonio_scene::Capture;
use gonio_scene::capture::{LightKind, Model};

/// A number that the file has wrong.
pub struct Misstatement {
    /// The suspect that a diagnosis should name.
    pub suspect: &'static str,
    /// The number that it should correct.
    pub number: &'static str,
    /// What that number is in truth, of a capture at its true numbers.
    pub truth: fn(&Capture) -> f64,
    /// Makes the file wrong.
    pub apply: fn(&mut Capture),
}

/// What is misstated. Photographs have 64 x 48 pixels: 1.2 of them are 3 of a picture of 160.
pub const MISSTATEMENTS: [Misstatement; 8] = [
    Misstatement {
        suspect: "focal-length",
        number: "camera.fx",
        truth: |truth| truth.camera.fx,
        apply: |said| (said.camera.fx, said.camera.fy) = (1.01 * said.camera.fx, 1.01 * said.camera.fy),
    },
    Misstatement {
        suspect: "principal-point",
        number: "camera.cx",
        truth: |truth| truth.camera.cx,
        apply: |said| said.camera.cx += 1.2,
    },
    Misstatement {
        suspect: "photo-pose",
        number: "photo.02.translation.x",
        truth: |_| -0.004,
        apply: |said| {
            // Along the camera's own x axis.
            for row in said.photos[2].camera_to_world.iter_mut().take(3) {
                row[3] += 0.004 * row[0];
            }
        },
    },
    Misstatement {
        suspect: "base-color",
        number: "material.board.base_color.g",
        truth: |truth| match truth.materials[1].model {
            Model::Lambert { base_color } => base_color[1],
            _ => f64::NAN,
        },
        apply: |said| {
            if let Model::Lambert { base_color } = &mut said.materials[1].model {
                *base_color = base_color.map(|c| 0.85 * c);
            }
        },
    },
    Misstatement {
        suspect: "mesh-scale",
        number: "object.part.scale.x",
        truth: |_| 1.0,
        apply: |said| said.objects.iter_mut().filter(|o| o.name == PART).for_each(|o| o.scale = [1.02; 3]),
    },
    Misstatement {
        suspect: "photo-exposure",
        number: "photo.04.gain",
        truth: |_| 1.0 / 1.05,
        apply: |said| said.photos[4].exposure *= 1.05,
    },
    Misstatement {
        suspect: "lamp-color",
        number: "light.led.intensity.r",
        truth: |truth| match truth.lights[0].kind {
            LightKind::Point { intensity, .. } => intensity[0],
            _ => f64::NAN,
        },
        apply: |said| {
            if let LightKind::Point { intensity, .. } = &mut said.lights[0].kind {
                *intensity = [0.19 * 1.05, 0.19, 0.19];
            }
            said.fit.parameters.retain(|name| name != "light.led.intensity");
            said.fit.gray.clear();
        },
    },
    Misstatement {
        suspect: "photo-balance",
        number: "photo.01.balance.r",
        truth: |_| 1.0,
        apply: |said| said.photos[1].balance[0] = 1.0 / 1.05,
    },
];
