//! A material of glTF: metallic-roughness with its extensions.

use super::texture;
use crate::ledger::{Kept, Ledger};
use crate::surface::{Effect, NO_TEXTURE, SAME_DIFFUSE_LIGHT, Surface, metal_at_normal};
use gonio_scene::capture::{MapRole, Model};
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;

/// The material; `used` gains the names of the extensions that it needs.
pub fn of(surface: &Surface, used: &mut BTreeSet<&'static str>) -> Value {
    let effects = &surface.material.effects;
    let mut extensions = Map::new();
    let mut extend = |name: &'static str, value: Value| {
        used.insert(name);
        extensions.insert(name.to_owned(), value);
    };
    let (colour, metallic, roughness) = match &surface.material.model {
        Model::Lambert { base_color } => {
            extend("KHR_materials_specular", json!({ "specularFactor": 0.0 }));
            (*base_color, 0.0, 1.0)
        }
        Model::Plastic { base_color, roughness, ior, .. } => {
            extend("KHR_materials_ior", json!({ "ior": ior }));
            // A single colour serves base and metal.
            (surface.mixed_colour_of(*base_color), effects.metallic, *roughness)
        }
        Model::Conductor { roughness, eta, k } => ([0, 1, 2].map(|c| metal_at_normal(eta[c], k[c])), 1.0, *roughness),
    };
    if surface.has(Effect::Coat) {
        let (factor, roughness) = (effects.clearcoat_factor, effects.clearcoat_roughness);
        extend("KHR_materials_clearcoat", json!({ "clearcoatFactor": factor, "clearcoatRoughnessFactor": roughness }));
    }
    if surface.has(Effect::Sheen) {
        let (colour, roughness) = (effects.sheen_color, effects.sheen_roughness);
        extend("KHR_materials_sheen", json!({ "sheenColorFactor": colour, "sheenRoughnessFactor": roughness }));
    }
    if surface.has(Effect::Anisotropy) {
        // The turn is in the tangents.
        extend("KHR_materials_anisotropy", json!({ "anisotropyStrength": effects.anisotropy_strength }));
    }
    let [r, g, b] = colour;
    let mut material = json!({
        "name": surface.stem,
        "pbrMetallicRoughness": { "baseColorFactor": [r, g, b, 1.0], "metallicFactor": metallic, "roughnessFactor": roughness },
    });
    if !extensions.is_empty() {
        material["extensions"] = extensions.into();
    }
    material
}

/// Judges a material's numbers.
pub fn judge(surface: &Surface, ledger: &mut Ledger) {
    let key = |name: &str| surface.key(name);
    match surface.material.model {
        Model::Lambert { .. } => ledger.exact(&key("base_color"), "baseColorFactor, with a specularFactor of 0"),
        Model::Conductor { .. } => {
            ledger.exact(&key("roughness"), "roughnessFactor");
            for name in ["eta", "k"] {
                ledger.approximated(&key(name), "the reflectance along the normal, and Schlick's Fresnel from there");
            }
        }
        Model::Plastic { .. } => {
            ledger.approximated(&key("base_color"), SAME_DIFFUSE_LIGHT);
            ledger.exact(&key("roughness"), "roughnessFactor");
            ledger.approximated(&key("ior"), "KHR_materials_ior, and Schlick's Fresnel");
            ledger.approximated(
                &key("energy_compensation"),
                "in the diffuse colour; between facets each renderer has its own",
            );
        }
    }
    let map = |role: MapRole| match texture::values(surface, role) {
        Some(crate::paint::Values::Texture { .. }) => Kept::Approximated("a PNG of 8 bits".to_owned()),
        _ => Kept::Exact("the mesh's COLOR_0".to_owned()),
    };
    surface.judge_effects(ledger, map, |ledger, effect, name| match effect {
        Effect::Coat if name.ends_with("ior") && surface.material.effects.clearcoat_ior != 1.5 => {
            ledger.lost(name, "KHR_materials_clearcoat has 1.5");
        }
        Effect::Coat if name.ends_with("ior") => ledger.exact(name, "KHR_materials_clearcoat"),
        Effect::Coat => {
            ledger.approximated(name, "KHR_materials_clearcoat, which takes other shares of the light below it");
        }
        Effect::Sheen => {
            ledger.approximated(name, "KHR_materials_sheen, whose lobe leaves other shares to what is below");
        }
        Effect::Anisotropy => {
            ledger.approximated(
                name,
                "KHR_materials_anisotropy, by tangents at the vertices; not on meshes without normals",
            );
        }
        Effect::Metallic => ledger.approximated(name, "metallicFactor; one colour serves base and metal"),
        Effect::SecondLobe => ledger.lost(name, "glTF has no second lobe"),
        Effect::Scatter => ledger.lost(name, "no ratified extension of glTF spreads light below a surface"),
        Effect::DiffuseRoughness => ledger.lost(name, "glTF's diffuse light is Lambert's"),
        Effect::AlbedoVariation | Effect::RoughnessVariation | Effect::Bump => ledger.lost(name, NO_TEXTURE),
    });
}
