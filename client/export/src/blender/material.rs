//! A material as `scene.py` reads it.

use crate::Result;
use crate::files::FileMap;
use crate::ledger::{Kept, Ledger};
use crate::paint::Values;
use crate::surface::{Effect, NO_TEXTURE, SAME_DIFFUSE_LIGHT, Surface, metal_at_normal};
use crate::texture::{self, Storage};
use gonio_scene::capture::{MapRole, Model};
use gonio_scene::mesh::Wrap;
use serde_json::{Value, json};

/// Colours are those of renderers without reflection below the boundary.
pub fn description(surface: &Surface) -> Value {
    let effects = &surface.material.effects;
    let (roughness, ior, eta, k, compensated) = match &surface.material.model {
        Model::Lambert { .. } => (1.0, 1.5, [1.0; 3], [0.0; 3], false),
        Model::Plastic { roughness, ior, energy_compensation, .. } => {
            (*roughness, *ior, [1.0; 3], [0.0; 3], *energy_compensation)
        }
        Model::Conductor { roughness, eta, k } => (*roughness, 1.5, *eta, *k, false),
    };
    let mut lobes = vec![lobe(surface, roughness, 1.0 - effects.second_lobe_weight)];
    if surface.has(Effect::SecondLobe) {
        lobes.push(lobe(surface, effects.second_lobe_roughness, effects.second_lobe_weight));
    }
    let coat = surface.has(Effect::Coat).then(|| {
        json!({ "factor": effects.clearcoat_factor, "roughness": effects.clearcoat_roughness, "ior": effects.clearcoat_ior })
    });
    let sheen = surface
        .has(Effect::Sheen)
        .then(|| json!({ "color": effects.sheen_color, "roughness": effects.sheen_roughness }));
    let metal = [0, 1, 2].map(|c| metal_at_normal(eta[c], k[c]));
    json!({
        "maps": maps(surface), "name": surface.stem, "model": surface.material.model.word(), "lobes": lobes, "ior": ior, "eta": eta, "k": k,
        "metal_color": metal, "energy_compensation": compensated,
        "metallic": effects.metallic, "coat": coat, "sheen": sheen, "scatter_distance": effects.scatter_distance,
        "diffuse_roughness": effects.diffuse_roughness,
        "anisotropic_rotation": (effects.anisotropy_rotation / std::f64::consts::TAU).rem_euclid(1.0),
    })
}

/// A number by vertex or texel, as Cycles takes it.
pub fn values(surface: &Surface, role: MapRole) -> Option<Values> {
    match role {
        MapRole::BaseColor => surface.values(role, |colour| surface.plain_colour_of(colour)),
        MapRole::Roughness | MapRole::Metallic => surface.values(role, |value| value),
    }
}

/// The files of a surface's textures.
///
/// # Errors
/// A texture without pixels.
pub fn textures(surface: &Surface, files: &mut FileMap) -> Result<()> {
    MapRole::ALL
        .into_iter()
        .try_for_each(|role| texture::add(files, surface, role, Storage::Exact, values(surface, role).as_ref()))
}

/// What varies, by Principled's socket: an image, or the mesh's colours.
fn maps(surface: &Surface) -> Value {
    let sockets =
        [(MapRole::BaseColor, "Base Color"), (MapRole::Roughness, "Roughness"), (MapRole::Metallic, "Metallic")];
    let map = |(role, socket): (MapRole, &str)| {
        let map = match values(surface, role)? {
            Values::Vertices(_) => json!({ "file": null }),
            Values::Texture { wrap, .. } => {
                let extension = match wrap[0] {
                    Wrap::Repeat => "REPEAT",
                    Wrap::Mirror => "MIRROR",
                    Wrap::Clamp => "EXTEND",
                };
                json!({ "file": texture::file(surface, role, Storage::Exact), "extension": extension })
            }
        };
        Some((socket.to_owned(), map))
    };
    Value::Object(sockets.into_iter().filter_map(map).collect())
}

/// One GGX lobe with what is below it. Principled stretches a lobe to alpha = roughness^2 / a along its tangent and
/// roughness^2 a across, a = sqrt(1 - 0.9 anisotropic).
fn lobe(surface: &Surface, roughness: f64, weight: f64) -> Value {
    let effects = &surface.material.effects;
    let across = (roughness * roughness).max(1e-4);
    let along = across + (1.0 - across) * effects.anisotropy_strength * effects.anisotropy_strength;
    let drawn = surface.has(Effect::Anisotropy);
    let shown = if drawn { (along * across).sqrt().sqrt() } else { roughness };
    let anisotropic = if drawn { ((1.0 - across / along) / 0.9).min(1.0) } else { 0.0 };
    json!({ "color": surface.plain_colour(roughness), "roughness": shown, "weight": weight, "anisotropic": anisotropic })
}

/// Judges a material's numbers.
pub fn judge(surface: &Surface, ledger: &mut Ledger) {
    let key = |name: &str| surface.key(name);
    match surface.material.model {
        Model::Lambert { .. } => ledger.exact(&key("base_color"), "the diffuse colour"),
        Model::Conductor { .. } => {
            let place =
                "the Metallic BSDF from Blender 4.3 on; before, Principled's metal by its reflectance along the normal";
            ledger.exact(&key("roughness"), "roughness");
            ledger.approximated(&key("eta"), place);
            ledger.approximated(&key("k"), place);
        }
        Model::Plastic { .. } => {
            ledger.approximated(&key("base_color"), SAME_DIFFUSE_LIGHT);
            ledger.exact(&key("roughness"), "Principled's roughness");
            ledger.exact(&key("ior"), "Principled's IOR");
            ledger.exact(&key("energy_compensation"), "the distribution: multiscatter GGX, or GGX");
        }
    }
    let map = |_| Kept::Exact("an image texture, or the mesh's colours, of these numbers".to_owned());
    surface.judge_effects(ledger, map, |ledger, effect, name| match effect {
        Effect::SecondLobe => ledger.exact(name, "a second Principled in a mix shader"),
        Effect::Metallic => ledger.approximated(name, "Principled's metal"),
        Effect::Coat => ledger.approximated(name, "Principled's coat, which takes other shares of the light below it"),
        Effect::Scatter => {
            ledger.approximated(name, "Principled's Burley subsurface, which has no boundary of its own");
        }
        Effect::Anisotropy => {
            ledger.approximated(
                name,
                "Principled's, with tangents around the object's z axis; at most 10 times as wide as high",
            );
        }
        Effect::Sheen => ledger.approximated(name, "Principled's sheen, another lobe"),
        Effect::DiffuseRoughness => {
            ledger.approximated(
                name,
                "another model of rough diffuse surfaces, up to 1; from Blender 4.3 on for plastic",
            );
        }
        Effect::AlbedoVariation | Effect::RoughnessVariation | Effect::Bump => ledger.lost(name, NO_TEXTURE),
    });
}
