//! A material as `UsdPreviewSurface`, and as OpenPBR by MaterialX.

use super::text::triple;
use super::texture;
use crate::ledger::{Kept, Ledger};
use crate::surface::{Effect, NO_TEXTURE, SAME_DIFFUSE_LIGHT, Surface, metal_at_normal};
use gonio_scene::capture::{MapRole, Model};
use std::fmt::Write;

/// What both shaders are made of.
struct Plain {
    colour: [f64; 3],
    roughness: f64,
    ior: f64,
    /// Share of a metal of that colour, and the metal's colour.
    metallic: f64,
    metal_colour: [f64; 3],
    /// 0 where nothing is reflected at the surface itself.
    specular: f64,
}

fn plain(surface: &Surface) -> Plain {
    let effects = &surface.material.effects;
    match &surface.material.model {
        Model::Lambert { base_color } => Plain {
            colour: *base_color,
            roughness: 1.0,
            ior: 1.5,
            metallic: 0.0,
            metal_colour: *base_color,
            specular: 0.0,
        },
        Model::Plastic { base_color, roughness, ior, .. } => Plain {
            colour: surface.plain_colour(*roughness),
            roughness: *roughness,
            ior: *ior,
            metallic: effects.metallic,
            metal_colour: *base_color,
            specular: 1.0,
        },
        Model::Conductor { roughness, eta, k } => {
            let colour = [0, 1, 2].map(|c| metal_at_normal(eta[c], k[c]));
            Plain { colour, roughness: *roughness, ior: 1.5, metallic: 1.0, metal_colour: colour, specular: 1.0 }
        }
    }
}

/// The material `name`.
pub fn write(surface: &Surface, name: &str, out: &mut String) -> std::fmt::Result {
    let effects = &surface.material.effects;
    let path = format!("/Scene/Materials/{name}");
    let plain = plain(surface);
    // A single colour serves base and metal.
    let mixed = [0, 1, 2].map(|c| plain.colour[c] * (1.0 - plain.metallic) + plain.metal_colour[c] * plain.metallic);
    writeln!(out, "        def Material \"{name}\"\n        {{")?;
    writeln!(out, "            token outputs:surface.connect = <{path}/Preview.outputs:surface>")?;
    writeln!(out, "            token outputs:mtlx:surface.connect = <{path}/OpenPBR.outputs:out>\n")?;
    texture::write(surface, &path, out)?;
    let mut shader = |prim: &str, id: &str, inputs: &[(&str, String)], output: &str| {
        writeln!(out, "            def Shader \"{prim}\"\n            {{")?;
        writeln!(out, "                uniform token info:id = \"{id}\"")?;
        for (input, value) in inputs {
            let connect = if value.starts_with('<') { ".connect" } else { "" };
            let kind = match *input {
                "diffuseColor" | "base_color" => "color3f",
                "useSpecularWorkflow" => "int",
                _ if value.starts_with('(') => "color3f",
                _ => "float",
            };
            writeln!(out, "                {kind} inputs:{input}{connect} = {value}")?;
        }
        writeln!(out, "                token outputs:{output}\n            }}")
    };
    let preview_of = |role: MapRole, number: String| texture::preview(surface, role, &path).unwrap_or(number);
    let open_of = |role: MapRole, number: String| texture::open(surface, role, &path).unwrap_or(number);
    let mut preview = vec![
        ("diffuseColor", preview_of(MapRole::BaseColor, triple(mixed))),
        ("roughness", preview_of(MapRole::Roughness, plain.roughness.to_string())),
        ("metallic", preview_of(MapRole::Metallic, plain.metallic.to_string())),
        ("ior", if plain.specular > 0.0 { plain.ior } else { 1.0 }.to_string()),
    ];
    if plain.specular == 0.0 {
        preview.extend([("useSpecularWorkflow", "1".to_owned()), ("specularColor", triple([0.0; 3]))]);
    }
    let mut open = vec![
        ("base_color", open_of(MapRole::BaseColor, triple(mixed))),
        ("base_metalness", open_of(MapRole::Metallic, plain.metallic.to_string())),
        ("base_diffuse_roughness", (effects.diffuse_roughness.min(1.0)).to_string()),
        ("specular_weight", plain.specular.to_string()),
        ("specular_roughness", open_of(MapRole::Roughness, plain.roughness.to_string())),
        ("specular_ior", plain.ior.to_string()),
    ];
    if surface.has(Effect::Coat) {
        let (factor, roughness) = (effects.clearcoat_factor.to_string(), effects.clearcoat_roughness.to_string());
        preview.extend([("clearcoat", factor.clone()), ("clearcoatRoughness", roughness.clone())]);
        let ior = effects.clearcoat_ior.to_string();
        open.extend([("coat_weight", factor), ("coat_roughness", roughness), ("coat_ior", ior)]);
        // OpenPBR darkens what is below a coat by reflection inside of it; a capture's coat does not.
        open.push(("coat_darkening", "0".to_owned()));
    }
    if surface.has(Effect::Sheen) {
        let brightest = effects.sheen_color.into_iter().fold(0.0, f64::max);
        open.push(("fuzz_weight", brightest.to_string()));
        open.push(("fuzz_color", triple(effects.sheen_color.map(|c| c / brightest))));
        open.push(("fuzz_roughness", effects.sheen_roughness.to_string()));
    }
    if surface.has(Effect::Scatter) {
        open.push(("subsurface_weight", "1".to_owned()));
        open.push(("subsurface_color", triple(plain.colour)));
        open.push(("subsurface_radius", effects.scatter_distance.to_string()));
        open.push(("subsurface_radius_scale", triple([1.0; 3])));
    }
    shader("Preview", "UsdPreviewSurface", &preview, "surface")?;
    shader("OpenPBR", "ND_open_pbr_surface_surfaceshader", &open, "out")?;
    writeln!(out, "        }}")
}

/// Judges a material's numbers.
pub fn judge(surface: &Surface, ledger: &mut Ledger) {
    let key = |name: &str| surface.key(name);
    match surface.material.model {
        Model::Lambert { .. } => ledger.exact(&key("base_color"), "diffuseColor, base_color"),
        Model::Conductor { .. } => {
            ledger.exact(&key("roughness"), "roughness, specular_roughness");
            for name in ["eta", "k"] {
                ledger.approximated(
                    &key(name),
                    "the reflectance along the normal; towards grazing angles each shader has its own",
                );
            }
        }
        Model::Plastic { energy_compensation, .. } => {
            ledger.approximated(&key("base_color"), SAME_DIFFUSE_LIGHT);
            ledger.exact(&key("roughness"), "roughness, specular_roughness");
            ledger.exact(&key("ior"), "ior, specular_ior");
            if energy_compensation {
                ledger.approximated(
                    &key("energy_compensation"),
                    "in the diffuse colour; between facets each renderer has its own",
                );
            } else {
                ledger.approximated(
                    &key("energy_compensation"),
                    "in the diffuse colour; a renderer may add what facets lose",
                );
            }
        }
    }
    let map = |role: MapRole| match texture::values(surface, role) {
        Some(crate::paint::Values::Texture { .. }) => Kept::Approximated("a PNG of 8 bits".to_owned()),
        _ => Kept::Exact("the mesh's displayColor".to_owned()),
    };
    surface.judge_effects(ledger, map, |ledger, effect, name| match effect {
        Effect::Coat if name.ends_with("ior") => {
            ledger.approximated(name, "OpenPBR's coat_ior; UsdPreviewSurface has 1.5");
        }
        Effect::Coat => ledger.approximated(name, "another coat, which takes other shares of the light below it"),
        Effect::Metallic => ledger.approximated(name, "one colour serves base and metal"),
        Effect::Sheen => ledger.approximated(name, "OpenPBR's fuzz, another lobe; UsdPreviewSurface has none"),
        Effect::Scatter => ledger.approximated(name, "OpenPBR's subsurface; UsdPreviewSurface has none"),
        Effect::DiffuseRoughness => {
            ledger.approximated(name, "OpenPBR's, another model, up to 1; UsdPreviewSurface has none");
        }
        Effect::SecondLobe => ledger.lost(name, "neither shader has a second lobe"),
        Effect::Anisotropy => ledger.lost(name, "the meshes lack texture coordinates, which tangents follow from"),
        Effect::AlbedoVariation | Effect::RoughnessVariation | Effect::Bump => ledger.lost(name, NO_TEXTURE),
    });
}
