//! What varies a material: shaders that read images or the mesh's colours, one set for each of its two models.

use crate::Result;
use crate::files::FileMap;
use crate::paint::Values;
use crate::surface::Surface;
use crate::texture::{self, Storage};
use gonio_scene::capture::MapRole;
use gonio_scene::mesh::Wrap;
use std::fmt::Write;

/// A number by vertex or texel. A single colour serves base and metal.
pub fn values(surface: &Surface, role: MapRole) -> Option<Values> {
    surface.values(role, |value| if role == MapRole::BaseColor { surface.mixed_colour_of(value) } else { value })
}

/// The files of a surface's textures.
///
/// # Errors
/// A texture without pixels.
pub fn files(surface: &Surface, files: &mut FileMap) -> Result<()> {
    MapRole::ALL
        .into_iter()
        .try_for_each(|role| texture::add(files, surface, role, Storage::Png, values(surface, role).as_ref()))
}

/// The prims that vary `surface`, whose material is at `path`.
pub fn write(surface: &Surface, path: &str, out: &mut String) -> std::fmt::Result {
    if surface.paint.textured() {
        let reader = [("string inputs:varname", "\"st\"".to_owned()), ("float2 outputs:result", String::new())];
        shader(out, "Coordinates", "UsdPrimvarReader_float2", &reader)?;
    }
    for role in MapRole::ALL {
        let Some(values) = values(surface, role) else { continue };
        let prim = prim(role);
        let colour = role == MapRole::BaseColor;
        let kind = if colour { "color3" } else { "float" };
        let value = if colour { "color3f outputs:out" } else { "float outputs:out" };
        match values {
            Values::Vertices(_) => {
                let name = "\"displayColor\"".to_owned();
                let reader = [("string inputs:varname", name.clone()), ("float3 outputs:result", String::new())];
                shader(out, &format!("Preview{prim}"), "UsdPrimvarReader_float3", &reader)?;
                let reader = [("string inputs:geomprop", name), (value, String::new())];
                shader(out, &format!("OpenPBR{prim}"), &format!("ND_geompropvalue_{kind}"), &reader)?;
            }
            Values::Texture { wrap, .. } => {
                let file = format!("@./{}@", texture::file(surface, role, Storage::Png));
                let space = if colour { "\"sRGB\"" } else { "\"raw\"" };
                let mut reader = vec![
                    ("asset inputs:file", file.clone()),
                    ("token inputs:sourceColorSpace", space.to_owned()),
                    ("float2 inputs:st.connect", format!("<{path}/Coordinates.outputs:result>")),
                ];
                for (input, wrap) in ["token inputs:wrapS", "token inputs:wrapT"].into_iter().zip(wrap) {
                    reader.push((input, word(wrap, ["\"repeat\"", "\"mirror\"", "\"clamp\""])));
                }
                reader.extend([("float3 outputs:rgb", String::new()), ("float outputs:r", String::new())]);
                shader(out, &format!("Preview{prim}"), "UsdUVTexture", &reader)?;
                let space = if colour { "srgb_texture" } else { "raw" };
                let mut reader = vec![("asset inputs:file", format!("{file} ( colorSpace = \"{space}\" )"))];
                for (input, wrap) in ["string inputs:uaddressmode", "string inputs:vaddressmode"].into_iter().zip(wrap)
                {
                    reader.push((input, word(wrap, ["\"periodic\"", "\"mirror\"", "\"clamp\""])));
                }
                reader.push((value, String::new()));
                shader(out, &format!("OpenPBR{prim}"), &format!("ND_image_{kind}"), &reader)?;
            }
        }
    }
    Ok(())
}

/// Where `UsdPreviewSurface` gets a number that varies.
pub fn preview(surface: &Surface, role: MapRole, path: &str) -> Option<String> {
    let output = match values(surface, role)? {
        Values::Vertices(_) => "result",
        Values::Texture { .. } if role == MapRole::BaseColor => "rgb",
        Values::Texture { .. } => "r",
    };
    Some(format!("<{path}/Preview{}.outputs:{output}>", prim(role)))
}

/// Where OpenPBR gets a number that varies.
pub fn open(surface: &Surface, role: MapRole, path: &str) -> Option<String> {
    values(surface, role)?;
    Some(format!("<{path}/OpenPBR{}.outputs:out>", prim(role)))
}

fn prim(role: MapRole) -> &'static str {
    match role {
        MapRole::BaseColor => "BaseColor",
        MapRole::Roughness => "Roughness",
        MapRole::Metallic => "Metallic",
    }
}

fn word(wrap: Wrap, [repeat, mirror, clamp]: [&str; 3]) -> String {
    match wrap {
        Wrap::Repeat => repeat,
        Wrap::Mirror => mirror,
        Wrap::Clamp => clamp,
    }
    .to_owned()
}

/// A shader with its properties; those without a value are outputs.
fn shader(out: &mut String, prim: &str, id: &str, properties: &[(&str, String)]) -> std::fmt::Result {
    writeln!(out, "            def Shader \"{prim}\"\n            {{")?;
    writeln!(out, "                uniform token info:id = \"{id}\"")?;
    for (property, value) in properties {
        let equals = if value.is_empty() { "" } else { " = " };
        writeln!(out, "                {property}{equals}{value}")?;
    }
    writeln!(out, "            }}")
}
