//! A material of pbrt-v4.

use super::list;
use crate::ledger::Ledger;
use crate::surface::{Effect, NO_TEXTURE, Surface};
use gonio_scene::capture::Model;
use std::fmt::Write;

/// The named material.
pub fn write(surface: &Surface, out: &mut String) -> std::fmt::Result {
    let effects = &surface.material.effects;
    let name = &surface.stem;
    match &surface.material.model {
        Model::Lambert { base_color } => {
            make(out, name, "diffuse", &format!("\"rgb reflectance\" [ {} ]", list(base_color)))
        }
        Model::Conductor { roughness, eta, k } => {
            let index = format!("\"rgb eta\" [ {} ] \"rgb k\" [ {} ]", list(eta), list(k));
            make(out, name, "conductor", &format!("{index}\n    {}", facets(*roughness)))
        }
        Model::Plastic { base_color, roughness, ior, .. } => {
            let base = |roughness: f64| {
                let index = format!("\"rgb reflectance\" [ {} ] \"float eta\" [ {ior} ]", list(base_color));
                format!("{index}\n    {}", facets(roughness))
            };
            if !surface.has(Effect::SecondLobe) {
                return make(out, name, "coateddiffuse", &base(*roughness));
            }
            let (first, second) = (format!("{name}.first"), format!("{name}.second"));
            make(out, &first, "coateddiffuse", &base(*roughness))?;
            make(out, &second, "coateddiffuse", &base(effects.second_lobe_roughness))?;
            let amount = effects.second_lobe_weight;
            make(
                out,
                name,
                "mix",
                &format!("\"string materials\" [ \"{first}\" \"{second}\" ] \"float amount\" [ {amount} ]"),
            )
        }
    }
}

fn make(out: &mut String, name: &str, kind: &str, parameters: &str) -> std::fmt::Result {
    writeln!(out, "MakeNamedMaterial \"{name}\" \"string type\" [ \"{kind}\" ] {parameters}")
}

/// pbrt's roughness is GGX's alpha where it is not remapped.
fn facets(roughness: f64) -> String {
    format!("\"float roughness\" [ {} ] \"bool remaproughness\" [ false ]", roughness * roughness)
}

/// Judges a material's numbers.
pub fn judge(surface: &Surface, ledger: &mut Ledger) {
    let key = |name: &str| surface.key(name);
    match surface.material.model {
        Model::Lambert { .. } => ledger.exact(&key("base_color"), "diffuse.reflectance"),
        Model::Conductor { .. } => {
            ledger.exact(&key("roughness"), "conductor.roughness = roughness^2, not remapped");
            for name in ["eta", "k"] {
                ledger.approximated(&key(name), "a smooth spectrum through the three channels");
            }
        }
        Model::Plastic { energy_compensation, .. } => {
            ledger.exact(&key("base_color"), "coateddiffuse.reflectance");
            ledger.exact(&key("roughness"), "coateddiffuse.roughness = roughness^2, not remapped");
            ledger.exact(&key("ior"), "coateddiffuse.eta");
            if energy_compensation {
                ledger.lost(&key("energy_compensation"), "coateddiffuse loses the light that its facets reflect twice");
            } else {
                ledger.approximated(
                    &key("energy_compensation"),
                    "coateddiffuse follows light between base and boundary by chance: what facets lose differs at high roughness",
                );
            }
        }
    }
    surface.judge_effects(ledger, |ledger, effect, name| match effect {
        Effect::SecondLobe => ledger.exact(name, "a mix of two coateddiffuse"),
        Effect::Coat => ledger.lost(name, "coateddiffuse has one boundary"),
        Effect::Metallic | Effect::Sheen => ledger.lost(name, "coateddiffuse has nothing like it"),
        Effect::Scatter => ledger.lost(name, "coateddiffuse does not spread light"),
        Effect::Anisotropy => ledger.lost(name, "the meshes lack texture coordinates, which tangents follow from"),
        Effect::DiffuseRoughness => ledger.lost(name, "diffuse light is Lambert's in pbrt-v4"),
        Effect::AlbedoVariation | Effect::RoughnessVariation | Effect::Bump => ledger.lost(name, NO_TEXTURE),
    });
}
