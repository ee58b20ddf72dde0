//! A material of pbrt-v4.

use super::list;
use crate::Result;
use crate::files::FileMap;
use crate::ledger::{Kept, Ledger};
use crate::paint::Values;
use crate::surface::{Effect, NO_TEXTURE, Surface};
use crate::texture::{self, Storage};
use gonio_scene::capture::{MapRole, Model};
use gonio_scene::mesh::Wrap;
use std::fmt::Write;

/// What varies over texels.
fn texels(surface: &Surface, role: MapRole) -> Option<Values> {
    match role {
        MapRole::BaseColor => surface.values(role, |colour| colour),
        MapRole::Roughness => surface.values(role, |roughness| roughness.map(alpha)),
        MapRole::Metallic => None,
    }
}

/// The files of a surface's textures.
///
/// # Errors
/// A texture without pixels.
pub fn textures(surface: &Surface, files: &mut FileMap) -> Result<()> {
    MapRole::ALL
        .into_iter()
        .try_for_each(|role| texture::add(files, surface, role, Storage::Exact, texels(surface, role).as_ref()))
}

/// The named material, after its textures.
pub fn write(surface: &Surface, out: &mut String) -> std::fmt::Result {
    let effects = &surface.material.effects;
    let name = &surface.stem;
    for (role, kind) in [(MapRole::BaseColor, "spectrum"), (MapRole::Roughness, "float")] {
        let Some(Values::Texture { wrap, .. }) = texels(surface, role) else { continue };
        let file = texture::file(surface, role, Storage::Exact);
        // pbrt cannot mirror.
        let wrap = if wrap[0] == Wrap::Clamp { "clamp" } else { "repeat" };
        let image = format!("\"string filename\" [ \"{file}\" ] \"string wrap\" [ \"{wrap}\" ]");
        writeln!(out, "Texture \"{name}.{kind}\" \"{kind}\" \"imagemap\" {image}")?;
    }
    let reflectance = |colour: &[f64; 3]| match texels(surface, MapRole::BaseColor) {
        Some(_) => format!("\"texture reflectance\" [ \"{name}.spectrum\" ]"),
        None => format!("\"rgb reflectance\" [ {} ]", list(colour)),
    };
    let own_facets = |roughness: f64| match texels(surface, MapRole::Roughness) {
        Some(_) => format!("\"texture roughness\" [ \"{name}.float\" ] \"bool remaproughness\" [ false ]"),
        None => facets(roughness),
    };
    match &surface.material.model {
        Model::Lambert { base_color } => make(out, name, "diffuse", &reflectance(base_color)),
        Model::Conductor { roughness, eta, k } => {
            let index = format!("\"rgb eta\" [ {} ] \"rgb k\" [ {} ]", list(eta), list(k));
            make(out, name, "conductor", &format!("{index}\n    {}", own_facets(*roughness)))
        }
        Model::Plastic { base_color, roughness, ior, .. } => {
            let base = |facets: String| format!("{} \"float eta\" [ {ior} ]\n    {facets}", reflectance(base_color));
            if !surface.has(Effect::SecondLobe) {
                return make(out, name, "coateddiffuse", &base(own_facets(*roughness)));
            }
            let (first, second) = (format!("{name}.first"), format!("{name}.second"));
            make(out, &first, "coateddiffuse", &base(own_facets(*roughness)))?;
            make(out, &second, "coateddiffuse", &base(facets(effects.second_lobe_roughness)))?;
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
    format!("\"float roughness\" [ {} ] \"bool remaproughness\" [ false ]", alpha(roughness))
}

fn alpha(roughness: f64) -> f64 {
    roughness * roughness
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
    let map = |role: MapRole| match (role, surface.values(role, |value| value)) {
        (MapRole::Metallic, _) => Kept::Lost("coateddiffuse has no metal".to_owned()),
        (_, Some(Values::Texture { wrap, .. })) if wrap.contains(&Wrap::Mirror) => {
            Kept::Approximated("an image that repeats where the mesh mirrors it".to_owned())
        }
        _ => Kept::Exact("an imagemap".to_owned()),
    };
    surface.judge_effects(ledger, map, |ledger, effect, name| match effect {
        Effect::SecondLobe => ledger.exact(name, "a mix of two coateddiffuse"),
        Effect::Coat => ledger.lost(name, "coateddiffuse has one boundary"),
        Effect::Metallic | Effect::Sheen => ledger.lost(name, "coateddiffuse has nothing like it"),
        Effect::Scatter => ledger.lost(name, "coateddiffuse does not spread light"),
        Effect::Anisotropy => ledger.lost(name, "the meshes lack texture coordinates, which tangents follow from"),
        Effect::DiffuseRoughness => ledger.lost(name, "diffuse light is Lambert's in pbrt-v4"),
        Effect::AlbedoVariation | Effect::RoughnessVariation | Effect::Bump => ledger.lost(name, NO_TEXTURE),
    });
}
