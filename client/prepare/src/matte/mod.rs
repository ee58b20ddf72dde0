//! Mattes from two backdrops, by triangulation: Smith and Blinn, "Blue screen matting", SIGGRAPH 1996, theorem 4.

mod drift;
mod encode;
mod shadow;
mod triangulate;

pub use drift::Drift;
pub use encode::{Depth, encode};

use gonio_scene::SceneError;
use gonio_scene::image::Image;

/// An object before one backdrop, and that backdrop alone.
#[derive(Debug, Clone, Default)]
pub struct Backed {
    /// The photo's file, for messages.
    pub name: String,
    /// The object before the backdrop, values 0..1.
    pub on: Image,
    /// The backdrop's file or colour, for messages.
    pub plate_name: String,
    /// The backdrop alone, of the same size.
    pub plate: Image,
}

/// A matte with the colour of what it shows.
#[derive(Debug, Clone, Default)]
pub struct Matte {
    /// Unmixed foreground colour, 0..1, not multiplied by alpha; 0 where alpha is.
    pub colour: Image,
    /// Coverage 0..1, one a pixel.
    pub alpha: Vec<f32>,
    /// How either photo differs from its backdrop in exposure and balance.
    pub drift: [Drift; 2],
    /// Pixels that were a shadow on the backdrop.
    pub shadow: usize,
}

impl Matte {
    /// Rounds the alpha to 0 or 1, for comparison.
    pub fn harden(&mut self) {
        for alpha in &mut self.alpha {
            *alpha = if *alpha < 0.5 { 0.0 } else { 1.0 };
        }
    }
}

/// What becomes of shadows on the backdrop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shadows {
    /// They fall to the background.
    #[default]
    Remove,
    /// They stay, as a black veil: what triangulation alone says.
    Keep,
}

/// Solves alpha and foreground of every pixel from two backdrops. Drift of exposure and colour balance between photo and
/// backdrop is estimated where the backdrop shows, and undone. Where both photos are the backdrop darkened, over more than a
/// hair's breadth, it is taken for a shadow.
///
/// # Errors
/// Sizes differ, the backdrops are alike, or a photo does not show its backdrop.
pub fn matte(backed: &[Backed; 2], shadows: Shadows) -> Result<Matte, SceneError> {
    let [a, b] = backed;
    let size = (a.on.width, a.on.height);
    for (name, image) in [(&b.name, &b.on), (&a.plate_name, &a.plate), (&b.plate_name, &b.plate)] {
        if (image.width, image.height) != size {
            let problem =
                format!("is {} x {} pixels, but {} is {} x {}", image.width, image.height, a.name, size.0, size.1);
            return Err(SceneError::new(name, problem, "give photos and plates of one size").at("--on, --plate"));
        }
    }
    let drift = [drift::estimate(a)?, drift::estimate(b)?];
    let side = drift::side(backed, &drift);
    let [(on_a, plate_a), (on_b, plate_b)] = [drift::undone(a, &drift[0], side), drift::undone(b, &drift[1], side)];
    triangulate::check(backed, &plate_a, &plate_b)?;
    let (mut colour, mut alpha) = triangulate::solve([&on_a, &on_b], [&plate_a, &plate_b]);
    let shadow = match shadows {
        Shadows::Remove => shadow::remove([&on_a, &on_b], [&plate_a, &plate_b], &mut colour, &mut alpha),
        Shadows::Keep => 0,
    };
    Ok(Matte { colour, alpha, drift, shadow })
}
