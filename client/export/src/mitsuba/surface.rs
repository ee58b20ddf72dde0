//! A material as Mitsuba's BSDF.

use super::node::{Node, Value};
use crate::ledger::Ledger;
use crate::surface::{Boundary, Effect, Surface, dielectric_at_normal};
use gonio_scene::capture::{Effects, Model};
use gonio_tracer::AIR;

/// The BSDF of a surface.
pub fn bsdf(surface: &Surface) -> Node {
    match &surface.material.model {
        Model::Lambert { base_color } => Node::new("bsdf", "diffuse").with("reflectance", Value::Rgb(*base_color)),
        Model::Conductor { roughness, eta, k } => Node::new("bsdf", "roughconductor")
            .with("distribution", Value::Text("ggx"))
            .with("alpha", Value::Number(alpha(*roughness)))
            .with("eta", Value::Rgb(*eta))
            .with("k", Value::Rgb(*k)),
        Model::Plastic { base_color, roughness, ior, .. } => {
            let effects = &surface.material.effects;
            let coat = surface.has(Effect::Coat).then(|| Coat::new(effects));
            let base = |roughness: f64| {
                let base = surface.boundary(roughness).map_or(*base_color, |boundary| {
                    let diffuse = coat.as_ref().map_or(1.0, |coat| coat.diffuse);
                    base_color.map(|b| base_for(&boundary, b, diffuse))
                });
                plastic(base, roughness, *ior)
            };
            let mut node = base(*roughness);
            if surface.has(Effect::SecondLobe) {
                node = blend(effects.second_lobe_weight, node, base(effects.second_lobe_roughness));
            }
            if surface.has(Effect::Metallic) {
                let metal = Node::new("bsdf", "principled")
                    .with("base_color", Value::Rgb(*base_color))
                    .with("roughness", Value::Number(*roughness))
                    .with("metallic", Value::Number(1.0));
                node = blend(effects.metallic, node, metal);
            }
            match coat {
                Some(coat) => blend(coat.weight, node, coat.node),
                None => node,
            }
        }
    }
}

fn alpha(roughness: f64) -> f64 {
    (roughness * roughness).max(f64::from(gonio_tracer::bsdf::ALPHA_FLOOR))
}

fn plastic(base: [f64; 3], roughness: f64, ior: f64) -> Node {
    Node::new("bsdf", "roughplastic")
        .with("distribution", Value::Text("ggx"))
        .with("alpha", Value::Number(alpha(roughness)))
        .with("int_ior", Value::Number(ior))
        .with("ext_ior", Value::Number(AIR))
        .with("nonlinear", Value::Switch(true))
        .with("diffuse_reflectance", Value::Rgb(base))
}

/// (1 - weight) first + weight second.
fn blend(weight: f64, first: Node, second: Node) -> Node {
    Node::new("bsdf", "blendbsdf")
        .with("weight", Value::Number(weight))
        .with("first", Value::Node(first))
        .with("second", Value::Node(second))
}

/// The base below `roughplastic`, which loses light between facets, that shows `factor` times the diffuse albedo of `b`.
fn base_for(boundary: &Boundary, b: f64, factor: f64) -> f64 {
    if factor == 1.0 && !boundary.compensated {
        return b;
    }
    boundary.lossy.base_of(boundary.own.diffuse_albedo(b) * factor).min(1.0)
}

/// A clear coat, which Mitsuba's BSDFs do not have: a lobe of its own, mixed in with the share of light at normal incidence
/// that the coat takes from what is below, so that highlights below need no factor.
struct Coat {
    weight: f64,
    node: Node,
    /// What the coat leaves of the diffuse light, over what the weight leaves.
    diffuse: f64,
}

impl Coat {
    fn new(effects: &Effects) -> Self {
        let (factor, ior) = (effects.clearcoat_factor, effects.clearcoat_ior);
        let through = |reflected: f64| (1.0 - factor * reflected) * (1.0 - factor * reflected);
        let at_normal = through(dielectric_at_normal(ior / AIR));
        let weight = 1.0 - at_normal;
        let node = plastic([0.0; 3], effects.clearcoat_roughness, ior)
            .with("specular_reflectance", Value::Uniform(factor / weight));
        Self { weight, node, diffuse: through(crate::surface::dielectric_mean(ior / AIR)) / at_normal }
    }
}

/// Judges a material's numbers.
pub fn judge(surface: &Surface, ledger: &mut Ledger) {
    let key = |name: &str| surface.key(name);
    match surface.material.model {
        Model::Lambert { .. } => ledger.exact(&key("base_color"), "diffuse.reflectance"),
        Model::Conductor { .. } => {
            ledger.exact(&key("eta"), "roughconductor.eta");
            ledger.exact(&key("k"), "roughconductor.k");
            ledger.exact(&key("roughness"), "roughconductor.alpha = roughness^2");
        }
        Model::Plastic { energy_compensation, .. } => {
            ledger.exact(&key("roughness"), "roughplastic.alpha = roughness^2");
            ledger.exact(&key("ior"), "roughplastic.int_ior");
            if energy_compensation {
                let how = "roughplastic loses light between facets: its base is lighter by as much, up to white";
                ledger.approximated(&key("energy_compensation"), how);
                ledger.approximated(&key("base_color"), how);
            } else if surface.has(Effect::Coat) {
                ledger.approximated(
                    &key("base_color"),
                    "darker by what the coat takes on average, the same at all angles",
                );
            } else {
                ledger.exact(&key("base_color"), "roughplastic.diffuse_reflectance");
            }
            ledger.exact(&key("energy_compensation"), "roughplastic has none");
        }
    }
    surface.judge_effects(ledger, |ledger, effect, name| match effect {
        Effect::SecondLobe => ledger.exact(name, "a second roughplastic in a blendbsdf"),
        Effect::Metallic => ledger.approximated(name, "principled's metal in a blendbsdf"),
        Effect::Coat => ledger.approximated(
            name,
            "a second lobe in a blendbsdf; what it takes from below is that of normal incidence for highlights, of the mean for \
             diffuse light",
        ),
        Effect::Anisotropy => ledger.lost(name, "Mitsuba takes tangents from texture coordinates, which the meshes lack"),
        Effect::Bump => ledger.lost(name, "Mitsuba takes bumps from textures, and the meshes lack texture coordinates"),
        Effect::DiffuseRoughness | Effect::Scatter | Effect::Sheen => {
            ledger.lost(name, "roughplastic and diffuse have nothing like it");
        }
        Effect::AlbedoVariation | Effect::RoughnessVariation => ledger.lost(name, crate::surface::NO_TEXTURE),
    });
}
