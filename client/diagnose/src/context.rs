//! What the catalogue may look at when it says how an effect could be present in a capture.

use gonio_scene::capture::{Light, LightKind, Material, Model};
use gonio_scene::{Assets, Capture};

/// A capture without its held-out photos, and where its things are.
#[derive(Debug)]
pub struct Context<'a> {
    /// The capture at the current model's values.
    pub capture: &'a Capture,
    /// Per object, the corners of its box in the world (smallest, largest), metres.
    pub boxes: Vec<[[f64; 3]; 2]>,
    /// Largest photo value among the fitted photos.
    pub peak: f64,
}

impl<'a> Context<'a> {
    /// Measures a capture.
    #[must_use]
    pub fn new(capture: &'a Capture, assets: &Assets, peak: f64) -> Self {
        let boxes = capture
            .objects
            .iter()
            .map(|object| {
                let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
                for p in assets.meshes.get(&object.mesh).map(|m| m.positions.as_slice()).unwrap_or_default() {
                    let world = [0, 1, 2].map(|axis| {
                        let m = &object.object_to_world[axis];
                        m[3] + (0..3).map(|k| m[k] * f64::from(p[k])).sum::<f64>()
                    });
                    include(&mut bounds, world, world);
                }
                bounds
            })
            .collect();
        Self { capture, boxes, peak }
    }

    /// The materials in question: those that the capture's fit frees a number of; where it frees none, all.
    pub fn materials(&self) -> impl Iterator<Item = &'a Material> + '_ {
        let freed = |m: &&Material| {
            let prefix = format!("material.{}.", m.name);
            self.capture.fit.parameters.iter().any(|n| n.starts_with(&prefix))
        };
        let any = self.capture.materials.iter().any(|m| freed(&m));
        self.capture.materials.iter().filter(move |m| freed(m) || !any)
    }

    /// The materials in question that are plastics: name, perceptual roughness.
    pub fn plastics(&self) -> impl Iterator<Item = (&'a str, f64)> + '_ {
        self.materials().filter_map(|m| match &m.model {
            Model::Plastic { roughness, .. } => Some((m.name.as_str(), *roughness)),
            _ => None,
        })
    }

    /// The photos, in the capture's order.
    pub fn photos(&self) -> impl Iterator<Item = &'a gonio_scene::capture::Photo> + '_ {
        self.capture.photos.iter()
    }

    /// Whether the capture's fit frees a number, or a colour or point that holds it.
    #[must_use]
    pub fn frees(&self, name: &str) -> bool {
        let below =
            |free: &String| name == free || name.strip_prefix(free.as_str()).is_some_and(|r| r.starts_with('.'));
        let above = |free: &String| free.strip_prefix(name).is_some_and(|r| r.starts_with('.'));
        self.capture.fit.parameters.iter().any(|free| below(free) || above(free))
    }

    /// Lights that come from one place.
    pub fn lamps(&self) -> impl Iterator<Item = &'a Light> + '_ {
        let lamp = |l: &&Light| matches!(l.kind, LightKind::Point { .. } | LightKind::Sphere { .. });
        self.capture.lights.iter().filter(lamp)
    }

    /// Indices of the objects made of a material in question.
    pub fn parts(&self) -> impl Iterator<Item = usize> + '_ {
        let of = |name: &str| self.materials().any(|m| m.name == name);
        (0..self.capture.objects.len()).filter(move |i| of(&self.capture.objects[*i].material))
    }

    /// The box round all parts: centre and half extents, metres.
    #[must_use]
    pub fn part_box(&self) -> ([f64; 3], [f64; 3]) {
        let mut all = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        for part in self.parts() {
            let [low, high] = self.boxes[part];
            include(&mut all, low, high);
        }
        let middle = |axis: usize| if all[0][axis] <= all[1][axis] { 0.5 * (all[0][axis] + all[1][axis]) } else { 0.0 };
        let half = |axis: usize| (0.5 * (all[1][axis] - all[0][axis])).max(1e-6);
        let (centre, half) = ([0, 1, 2].map(middle), [0, 1, 2].map(half));
        (centre, if half.iter().all(|h| h.is_finite()) { half } else { [0.05; 3] })
    }

    /// Mean distance of the cameras from the parts' middle, metres.
    #[must_use]
    pub fn distance(&self) -> f64 {
        let (centre, _) = self.part_box();
        let far = |p: &gonio_scene::capture::Photo| {
            let d = [0, 1, 2].map(|i| p.pose()[i][3] - centre[i]);
            d.iter().map(|x| x * x).sum::<f64>().sqrt()
        };
        let photos = &self.capture.photos;
        photos.iter().map(far).sum::<f64>() / (photos.len().max(1) as f64)
    }
}

/// Grows a box so that it holds another.
fn include(bounds: &mut [[f64; 3]; 2], low: [f64; 3], high: [f64; 3]) {
    bounds[0] = [0, 1, 2].map(|axis| bounds[0][axis].min(low[axis]));
    bounds[1] = [0, 1, 2].map(|axis| bounds[1][axis].max(high[axis]));
}
