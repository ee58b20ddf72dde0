//! A material as Mitsuba's BSDF.

use super::node::{Node, Value};
use crate::Result;
use crate::files::FileMap;
use crate::ledger::{Kept, Ledger};
use crate::paint::Values;
use crate::surface::{Boundary, Effect, MEAN, Surface, dielectric_at_normal};
use crate::texture::{self, Storage};
use gonio_scene::capture::{Effects, MapRole, Model};
use gonio_scene::mesh::Wrap;
use gonio_tracer::AIR;

/// The BSDF of a surface; its textures go to `files`.
///
/// # Errors
/// A texture without pixels.
pub fn bsdf(surface: &Surface, files: &mut FileMap) -> Result<Node> {
    let mut varied = |role: MapRole, values: Option<Values>, plain: Value| {
        texture::add(files, surface, role, Storage::Exact, values.as_ref())?;
        Ok::<_, crate::ExportError>(values.and_then(|values| node_of(surface, role, &values)).unwrap_or(plain))
    };
    Ok(match &surface.material.model {
        Model::Lambert { base_color } => {
            let reflectance = varied(MapRole::BaseColor, colours(surface), Value::Rgb(*base_color))?;
            Node::new("bsdf", "diffuse").with("reflectance", reflectance)
        }
        Model::Conductor { roughness, eta, k } => {
            let facets = surface.values(MapRole::Roughness, |roughness| roughness.map(alpha));
            Node::new("bsdf", "roughconductor")
                .with("distribution", Value::Text("ggx"))
                .with("alpha", varied(MapRole::Roughness, facets, Value::Number(alpha(*roughness)))?)
                .with("eta", Value::Rgb(*eta))
                .with("k", Value::Rgb(*k))
        }
        Model::Plastic { base_color, roughness, ior, .. } => {
            let effects = &surface.material.effects;
            let coat = surface.has(Effect::Coat).then(|| Coat::new(effects));
            let reflectance = varied(MapRole::BaseColor, colours(surface), Value::Rgb([0.0; 3]))?;
            let base = |roughness: f64| {
                let below = match &reflectance {
                    Value::Rgb(_) => Value::Rgb(below(surface, *base_color, roughness)),
                    texture => texture.clone(),
                };
                plastic(below, roughness, *ior)
            };
            let mut node = base(*roughness);
            if surface.has(Effect::SecondLobe) {
                let weight = Value::Number(effects.second_lobe_weight);
                node = blend(weight, node, base(effects.second_lobe_roughness));
            }
            if surface.has(Effect::Metallic) {
                let colour = if matches!(reflectance, Value::Rgb(_)) { Value::Rgb(*base_color) } else { reflectance };
                let metal = Node::new("bsdf", "principled")
                    .with("base_color", colour)
                    .with("roughness", Value::Number(*roughness))
                    .with("metallic", Value::Number(1.0));
                let share = surface.values(MapRole::Metallic, |share| share);
                node = blend(varied(MapRole::Metallic, share, Value::Number(effects.metallic))?, node, metal);
            }
            match coat {
                Some(coat) => blend(Value::Number(coat.weight), node, coat.node),
                None => node,
            }
        }
    })
}

/// The base colours of a surface that varies, as its vertices or texels have them in Mitsuba.
pub fn colours(surface: &Surface) -> Option<Values> {
    let roughness = match &surface.material.model {
        Model::Plastic { roughness, .. } => *roughness,
        _ => 1.0,
    };
    surface.values(MapRole::BaseColor, |colour| below(surface, colour, roughness))
}

/// The base colour below a surface's boundary: of a lambert as it is.
fn below(surface: &Surface, colour: [f64; 3], roughness: f64) -> [f64; 3] {
    let coat = surface.has(Effect::Coat).then(|| Coat::new(&surface.material.effects));
    let diffuse = coat.map_or(1.0, |coat| coat.diffuse);
    surface.boundary(roughness).map_or(colour, |boundary| colour.map(|b| base_for(&boundary, b, diffuse)))
}

/// A texture of values that are linear; the number as it is without one.
fn node_of(surface: &Surface, role: MapRole, values: &Values) -> Option<Value> {
    // Vertex colours are textures here: see the scene.
    let Values::Texture { wrap, .. } = values else { return None };
    let wrap = match wrap[0] {
        Wrap::Repeat => "repeat",
        Wrap::Mirror => "mirror",
        Wrap::Clamp => "clamp",
    };
    let bitmap = Node::new("texture", "bitmap")
        .with("filename", Value::File(texture::file(surface, role, Storage::Exact)))
        .with("raw", Value::Switch(true))
        .with("wrap_mode", Value::Text(wrap));
    Some(Value::Node(bitmap))
}

fn alpha(roughness: f64) -> f64 {
    (roughness * roughness).max(f64::from(gonio_tracer::bsdf::ALPHA_FLOOR))
}

fn plastic(base: Value, roughness: f64, ior: f64) -> Node {
    Node::new("bsdf", "roughplastic")
        .with("distribution", Value::Text("ggx"))
        .with("alpha", Value::Number(alpha(roughness)))
        .with("int_ior", Value::Number(ior))
        .with("ext_ior", Value::Number(AIR))
        .with("nonlinear", Value::Switch(true))
        .with("diffuse_reflectance", base)
}

/// (1 - weight) first + weight second.
fn blend(weight: Value, first: Node, second: Node) -> Node {
    Node::new("bsdf", "blendbsdf")
        .with("weight", weight)
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
        let node = plastic(Value::Rgb([0.0; 3]), effects.clearcoat_roughness, ior)
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
    let plastic = matches!(surface.material.model, Model::Plastic { .. });
    let map = |role: MapRole| match role {
        MapRole::BaseColor => Kept::Exact("a texture of these reflectances".to_owned()),
        MapRole::Roughness if plastic => Kept::Approximated(format!("roughplastic has one alpha: {MEAN}")),
        MapRole::Roughness => Kept::Exact("a texture of alpha = roughness^2".to_owned()),
        MapRole::Metallic => Kept::Exact("a texture of blendbsdf's weight".to_owned()),
    };
    surface.judge_effects(ledger, map, |ledger, effect, name| match effect {
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
