//! Materials: what is there beyond the plain model, and colours for renderers with simpler ones.

use crate::Result;
use crate::ledger::Kept;
use crate::ledger::Ledger;
use crate::name::Names;
use crate::paint::{Paint, Values, spread};
use crate::part::Part;
use gonio_scene::SceneError;
use gonio_scene::capture::{CAPTURE_FILE, Capture, Effects, MapRole, Material, Model};
use gonio_tracer::AIR;
use gonio_tracer::bsdf::{Exchange, ParameterError};

/// A material as a part has it, and a name for files and nodes.
pub struct Surface {
    pub stem: String,
    /// Numbers that maps vary have their means over the part.
    pub material: Material,
    /// How they vary.
    pub paint: Paint,
    /// By [`MapRole`]: the material's numbers before its maps.
    numbers: [[f64; 3]; 3],
    /// Of a plastic: its boundary.
    plastic: Option<Boundary>,
}

/// How light crosses a plastic's boundary.
#[derive(Debug, Clone, Copy)]
pub struct Boundary {
    /// As the capture says.
    pub own: Exchange,
    /// Without energy compensation.
    pub lossy: Exchange,
    /// Whether the capture asks for energy compensation.
    pub compensated: bool,
}

/// What a material may have beyond its plain model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effect {
    DiffuseRoughness,
    SecondLobe,
    Coat,
    Metallic,
    Scatter,
    Anisotropy,
    Sheen,
    AlbedoVariation,
    RoughnessVariation,
    Bump,
}

impl Effect {
    pub const ALL: [Self; 10] = [
        Self::DiffuseRoughness,
        Self::SecondLobe,
        Self::Coat,
        Self::Metallic,
        Self::Scatter,
        Self::Anisotropy,
        Self::Sheen,
        Self::AlbedoVariation,
        Self::RoughnessVariation,
        Self::Bump,
    ];

    /// The keys of `capture.toml`.
    pub fn keys(self) -> &'static [&'static str] {
        match self {
            Self::DiffuseRoughness => &["diffuse_roughness"],
            Self::SecondLobe => &["second_lobe_weight", "second_lobe_roughness"],
            Self::Coat => &["clearcoat_factor", "clearcoat_roughness", "clearcoat_ior"],
            Self::Metallic => &["metallic"],
            Self::Scatter => &["scatter_distance"],
            Self::Anisotropy => &["anisotropy_strength", "anisotropy_rotation"],
            Self::Sheen => &["sheen_color", "sheen_roughness"],
            Self::AlbedoVariation => &["albedo_variation"],
            Self::RoughnessVariation => &["roughness_variation"],
            Self::Bump => &["bump"],
        }
    }

    /// Whether it changes anything.
    pub fn is_there(self, effects: &Effects) -> bool {
        let any = |values: &[f64]| values.iter().any(|v| *v != 0.0);
        match self {
            Self::DiffuseRoughness => effects.diffuse_roughness > 0.0,
            Self::SecondLobe => effects.second_lobe_weight > 0.0,
            Self::Coat => effects.clearcoat_factor > 0.0,
            Self::Metallic => effects.metallic > 0.0,
            Self::Scatter => effects.scatter_distance > 0.0,
            Self::Anisotropy => effects.anisotropy_strength > 0.0,
            Self::Sheen => any(&effects.sheen_color),
            Self::AlbedoVariation => any(&effects.albedo_variation),
            Self::RoughnessVariation => any(&effects.roughness_variation),
            Self::Bump => any(&effects.bump),
        }
    }
}

/// The materials of a capture, and by part which one is its own: parts that maps vary have one each.
///
/// # Errors
/// A plastic whose numbers no boundary has.
pub fn surfaces(capture: &Capture, parts: &[Part]) -> Result<(Vec<Surface>, Vec<usize>)> {
    let mut names = Names::default();
    let mut surfaces = Vec::new();
    let mut of_part = vec![0; parts.len()];
    for (index, material) in capture.materials.iter().enumerate() {
        let (painted, plain): (Vec<usize>, Vec<usize>) = (0..parts.len())
            .filter(|part| parts[*part].material == index)
            .partition(|part| !parts[*part].paint.is_plain());
        if painted.is_empty() || !plain.is_empty() {
            plain.iter().for_each(|part| of_part[*part] = surfaces.len());
            surfaces.push(Surface::new(names.file(&material.name), material, Paint::default())?);
        }
        for part in painted {
            of_part[part] = surfaces.len();
            let stem = names.file(&format!("{}-{}", material.name, parts[part].stem));
            surfaces.push(Surface::new(stem, material, parts[part].paint.clone())?);
        }
    }
    Ok((surfaces, of_part))
}

/// By [`MapRole`], each in three channels.
fn numbers(material: &Material) -> [[f64; 3]; 3] {
    let (base_color, roughness) = match &material.model {
        Model::Lambert { base_color } => (*base_color, 1.0),
        Model::Plastic { base_color, roughness, .. } => (*base_color, *roughness),
        Model::Conductor { roughness, .. } => ([1.0; 3], *roughness),
    };
    [base_color, [roughness; 3], [material.effects.metallic; 3]]
}

/// `material` with the means of what `paint` varies.
fn averaged(material: &Material, paint: &Paint) -> Material {
    let numbers = numbers(material);
    let mean = |role: MapRole| spread(role, paint.mean(role, numbers[role as usize]));
    let mut material = material.clone();
    match &mut material.model {
        Model::Lambert { base_color } => *base_color = mean(MapRole::BaseColor),
        Model::Plastic { base_color, roughness, .. } => {
            *base_color = mean(MapRole::BaseColor);
            *roughness = mean(MapRole::Roughness)[0];
        }
        Model::Conductor { roughness, .. } => *roughness = mean(MapRole::Roughness)[0],
    }
    material.effects.metallic = mean(MapRole::Metallic)[0];
    material
}

/// The boundary of a plastic, at another roughness than its own perhaps.
#[allow(clippy::cast_possible_truncation)] // The tracer's tables are of single-precision numbers.
fn boundary(model: &Model, roughness: f64) -> std::result::Result<Boundary, ParameterError> {
    let (ior, compensated) = match model {
        Model::Plastic { ior, energy_compensation, .. } => (*ior, *energy_compensation),
        _ => (1.5, false),
    };
    let exchange = |compensated| Exchange::new(roughness as f32, (ior / AIR) as f32, compensated);
    Ok(Boundary { own: exchange(compensated)?, lossy: exchange(false)?, compensated })
}

impl Surface {
    fn new(stem: String, material: &Material, paint: Paint) -> Result<Self> {
        let numbers = numbers(material);
        let material = averaged(material, &paint);
        let plastic = match &material.model {
            Model::Plastic { roughness, .. } => Some(boundary(&material.model, *roughness).map_err(|error| {
                SceneError::new(CAPTURE_FILE, error.to_string(), "choose a value inside the model's domain")
                    .at(format!("material.{}", material.name))
            })?),
            _ => None,
        };
        Ok(Self { stem, material, paint, numbers, plastic })
    }

    /// A number of the material by vertex or texel, as `convert` makes it another renderer's; `None` where it is the same
    /// everywhere. Numbers of one channel have it three times.
    pub fn values(&self, role: MapRole, convert: impl Fn([f64; 3]) -> [f64; 3]) -> Option<Values> {
        self.paint.values(role, self.numbers[role as usize], |value| convert(spread(role, value)))
    }

    /// Judges the effects and the maps: effects that are not there are kept, of the others `says` tells; of maps that vary
    /// something, `map`.
    pub fn judge_effects(
        &self,
        ledger: &mut Ledger,
        map: impl Fn(MapRole) -> Kept,
        mut says: impl FnMut(&mut Ledger, Effect, &str),
    ) {
        for role in MapRole::ALL {
            if !self.paint.varies(role) {
                ledger.exact(&self.key(role.key()), "a factor on its number");
                continue;
            }
            ledger.judge(&self.key(role.key()), map(role));
            if self.paint.averaged(role) {
                ledger.approximated(&self.key(role.key()), "vertex colours by their mean, which the texture holds");
            }
        }
        for effect in Effect::ALL {
            for key in effect.keys() {
                let name = format!("material.{}.{key}", self.material.name);
                if effect.is_there(&self.material.effects) {
                    says(ledger, effect, &name);
                } else {
                    ledger.exact(&name, "not there");
                }
            }
        }
    }

    /// The boundary of a plastic, with another roughness in place of its own; `None` of another model.
    pub fn boundary(&self, roughness: f64) -> Option<Boundary> {
        let own = self.plastic?;
        // A roughness in 0..=1 beside an index that was taken before is never refused.
        Some(boundary(&self.material.model, roughness).unwrap_or(own))
    }

    /// The reflectance that a renderer without reflection from inside needs: of a plastic, of the base that shows the same
    /// diffuse light ([`Exchange::plain_colour`]), of `roughness`; of a lambert its own; of a metal black.
    pub fn plain_colour(&self, roughness: f64) -> [f64; 3] {
        match (&self.material.model, self.boundary(roughness)) {
            (Model::Plastic { base_color, .. }, Some(boundary)) => base_color.map(|b| boundary.own.plain_colour(b)),
            (Model::Lambert { base_color }, _) => *base_color,
            _ => [0.0; 3],
        }
    }

    /// As [`Surface::plain_colour`], of another base colour at the material's own roughness.
    pub fn plain_colour_of(&self, colour: [f64; 3]) -> [f64; 3] {
        self.plastic.map_or(colour, |boundary| colour.map(|b| boundary.own.plain_colour(b)))
    }

    /// The single colour of a surface that serves base and metal, of another base colour; as [`Surface::plain_colour_of`].
    pub fn mixed_colour_of(&self, colour: [f64; 3]) -> [f64; 3] {
        let (below, metal) = (self.plain_colour_of(colour), self.material.effects.metallic);
        [0, 1, 2].map(|c| below[c] * (1.0 - metal) + colour[c] * metal)
    }

    /// Roughness and the share of metal, as metallic-roughness models have them.
    pub fn shown_roughness_and_metallic(&self) -> [f64; 2] {
        match &self.material.model {
            Model::Lambert { .. } => [1.0, 0.0],
            Model::Plastic { roughness, .. } => [*roughness, self.material.effects.metallic],
            Model::Conductor { roughness, .. } => [*roughness, 1.0],
        }
    }

    /// Whether `effect` changes anything.
    pub fn has(&self, effect: Effect) -> bool {
        effect.is_there(&self.material.effects)
    }

    /// The dotted name of a key of this material.
    pub fn key(&self, key: &str) -> String {
        format!("material.{}.{key}", self.material.name)
    }
}

/// Reflectance of a metal of complex index `eta` + i `k` at normal incidence.
pub fn metal_at_normal(eta: f64, k: f64) -> f64 {
    ((eta - 1.0) * (eta - 1.0) + k * k) / ((eta + 1.0) * (eta + 1.0) + k * k)
}

/// Reflectance of a dielectric of relative index `ior` at normal incidence.
pub fn dielectric_at_normal(ior: f64) -> f64 {
    let r = (ior - 1.0) / (ior + 1.0);
    r * r
}

/// Mean reflectance of a smooth dielectric of relative index `n` above 1 for light from all sides (Walsh 1926, "The reflection
/// factor of a polished glass surface for diffused light", as Judd 1942 gives it).
pub fn dielectric_mean(n: f64) -> f64 {
    let (n2, n4) = (n * n, n * n * n * n);
    let (sum, difference) = (n2 + 1.0, n2 - 1.0);
    0.5 + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0) * (n + 1.0))
        + n2 * difference * difference / (sum * sum * sum) * libm::log((n - 1.0) / (n + 1.0))
        - 2.0 * n * n2 * (n2 + 2.0 * n - 1.0) / (sum * (n4 - 1.0))
        + 8.0 * n4 * (n4 + 1.0) / (sum * (n4 - 1.0) * (n4 - 1.0)) * libm::log(n)
}

/// What a renderer without such a map shows.
pub const MEAN: &str = "its mean over the part";

/// Why a variation over the surface does not travel.
pub const NO_TEXTURE: &str = "it varies over the object's box, and the meshes have no texture coordinates for a map";

/// How a plastic's base colour travels to a renderer that reflects nothing below the boundary.
pub const SAME_DIFFUSE_LIGHT: &str =
    "the colour whose diffuse light, averaged over directions, is the same without reflection below the boundary";

#[cfg(test)]
mod tests {
    use super::*;

    /// Fresnel's equations, averaged by the cosine.
    #[test]
    fn walshs_mean_is_that_of_fresnels_equations() {
        for n in [1.1, 1.3, 1.5, 2.0, 3.5] {
            let steps = 20_000;
            let mean: f64 = (0..steps)
                .map(|k| {
                    let cos = (f64::from(k) + 0.5) / f64::from(steps);
                    let inside = (1.0 - (1.0 - cos * cos) / (n * n)).sqrt();
                    let across = (cos - n * inside) / (cos + n * inside);
                    let along = (n * cos - inside) / (n * cos + inside);
                    (across * across + along * along) * cos / f64::from(steps)
                })
                .sum();
            assert!((dielectric_mean(n) - mean).abs() < 1e-6, "{n}: {} {mean}", dielectric_mean(n));
        }
    }
}
