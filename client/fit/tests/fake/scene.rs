//! The fake's capture, its truth and where its pixels look.

use super::shading::Pixel;
use super::uniform;
use gonio_scene::Capture;
use std::fmt::Write;

/// What a test wants to see.
#[derive(Debug, Clone)]
pub struct Scene {
    pub fit_photos: usize,
    pub held_out_photos: usize,
    pub pixels_per_photo: usize,
    /// Names freed; `gray` as in the capture.
    pub free: Vec<&'static str>,
    pub gray: Vec<&'static str>,
    /// First guesses: roughness, index of refraction, intensity.
    pub start: [f64; 3],
    /// Numbers of the truth where they differ from the first guess.
    pub truth: Vec<(String, f64)>,
    pub read_noise: f64,
    pub render_noise: f64,
    pub data_seed: u64,
}

impl Default for Scene {
    fn default() -> Self {
        let number = |name: &str, value| (name.to_owned(), value);
        Self {
            fit_photos: 5,
            held_out_photos: 2,
            pixels_per_photo: 400,
            free: vec![
                "material.shell.base_color",
                "material.shell.roughness",
                "material.shell.ior",
                "light.led.intensity",
            ],
            gray: vec!["light.led.intensity"],
            start: [0.4, 1.5, 0.1],
            truth: vec![
                number("material.shell.base_color.r", 0.44),
                number("material.shell.base_color.g", 0.3),
                number("material.shell.base_color.b", 0.55),
                number("material.shell.roughness", 0.36),
                number("material.shell.ior", 1.52),
                number("light.led.intensity.r", 0.19),
                number("light.led.intensity.g", 0.19),
                number("light.led.intensity.b", 0.19),
            ],
            read_noise: 0.01,
            render_noise: 0.03,
            data_seed: 1,
        }
    }
}

impl Scene {
    pub fn capture(&self) -> Capture {
        let quote = |names: &[&str]| names.iter().map(|n| format!("\"{n}\"")).collect::<Vec<_>>().join(", ");
        let [roughness, ior, intensity] = self.start;
        let mut text = format!(
            r#"
            format = 1
            name = "fake"
            [camera]
            width = 20
            height = 20
            fx = 30.0
            fy = 30.0
            cx = 10.0
            cy = 10.0
            [sensor]
            read_noise = {read}
            [[material]]
            name = "shell"
            model = "plastic"
            base_color = [0.5, 0.5, 0.5]
            roughness = {roughness:?}
            ior = {ior:?}
            [[material]]
            name = "board"
            model = "lambert"
            base_color = [0.8, 0.8, 0.8]
            [[light]]
            name = "led"
            kind = "point"
            frame = "camera"
            position = [0.05, 0.0, 0.0]
            intensity = [{intensity:?}, {intensity:?}, {intensity:?}]
            [fit]
            parameters = [{free}]
            gray = [{gray}]
            "#,
            read = self.read_noise,
            free = quote(&self.free),
            gray = quote(&self.gray),
        );
        for i in 0..self.fit_photos + self.held_out_photos {
            let role = if i < self.fit_photos { "fit" } else { "held-out" };
            let pose = "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]";
            write!(text, "[[photo]]\nfile = \"{i:02}.exr\"\nrole = \"{role}\"\ncamera_to_world = {pose}\n").unwrap();
        }
        Capture::parse(&text).unwrap()
    }

    /// The pixels of one photo: one in five on the board, the others on the visible half of a ball.
    pub fn pixels(&self, photo: usize) -> Vec<Pixel> {
        // Camera at the origin of directions, the lamp beside it at an angle of its own in every photo.
        let tilt = 0.1 + 0.15 * photo as f64;
        let to_light = [libm::sin(tilt), 0.0, libm::cos(tilt)];
        let half = [libm::sin(0.5 * tilt), 0.0, libm::cos(0.5 * tilt)];
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let mut pixels = Vec::new();
        for i in 0.. {
            if pixels.len() == self.pixels_per_photo {
                break;
            }
            let at = |k: u64| 2.0 * uniform(&[11, photo as u64, i, k]) - 1.0;
            let (x, y) = (at(0), at(1));
            let board = i % 5 == 0;
            let normal = if board { [0.0, 0.3, 0.953_939_2] } else { [x, y, (1.0 - x * x - y * y).max(0.0).sqrt()] };
            let pixel = Pixel {
                material: usize::from(board),
                light: dot(normal, to_light),
                view: normal[2],
                half: dot(normal, half).min(1.0),
                difference: dot(half, to_light),
                distance: 0.3 + 0.03 * x,
            };
            if pixel.light > 0.05 && pixel.view > 0.1 {
                pixels.push(pixel);
            }
        }
        pixels
    }

    /// The true value of a parameter or number.
    pub fn true_value(&self, name: &str) -> f64 {
        let exact = self.truth.iter().find(|(n, _)| n == name || *n == format!("{name}.r"));
        exact.map_or_else(|| self.capture().numbers()[name].0, |t| t.1)
    }
}
