//! Textures of a GLB: PNG images in its buffer.

use super::buffer::Buffer;
use crate::Result;
use crate::paint::Values;
use crate::surface::Surface;
use crate::texture::png;
use gonio_scene::capture::MapRole;
use gonio_scene::image::Image;
use gonio_scene::mesh::Wrap;
use serde_json::{Value, json};

/// Images, samplers and textures, one of each for one another.
#[derive(Default)]
pub struct Textures {
    images: Vec<Value>,
    samplers: Vec<Value>,
    textures: Vec<Value>,
}

/// A number by vertex or texel. A single colour serves base and metal.
pub fn values(surface: &Surface, role: MapRole) -> Option<Values> {
    surface.values(role, |value| if role == MapRole::BaseColor { surface.mixed_colour_of(value) } else { value })
}

impl Textures {
    /// Puts what varies `surface` into its `material`: its numbers become ones there.
    ///
    /// # Errors
    /// A texture without pixels.
    pub fn vary(&mut self, surface: &Surface, material: &mut Value, buffer: &mut Buffer) -> Result<()> {
        let plain = &mut material["pbrMetallicRoughness"];
        let colour = values(surface, MapRole::BaseColor);
        if colour.is_some() {
            plain["baseColorFactor"] = json!([1.0, 1.0, 1.0, 1.0]);
        }
        if let Some(Values::Texture { image, wrap }) = &colour {
            plain["baseColorTexture"] = self.add(surface, image, *wrap, true, buffer)?;
        }
        let (roughness, metallic) = (values(surface, MapRole::Roughness), values(surface, MapRole::Metallic));
        if let Some((image, wrap)) = together(surface, roughness.as_ref(), metallic.as_ref()) {
            plain["roughnessFactor"] = 1.0.into();
            plain["metallicFactor"] = 1.0.into();
            plain["metallicRoughnessTexture"] = self.add(surface, &image, wrap, false, buffer)?;
        }
        Ok(())
    }

    fn add(
        &mut self,
        surface: &Surface,
        image: &Image,
        wrap: [Wrap; 2],
        curved: bool,
        buffer: &mut Buffer,
    ) -> Result<Value> {
        let view = buffer.image(&png(&surface.stem, image, curved)?);
        self.images.push(json!({ "name": surface.stem, "bufferView": view, "mimeType": "image/png" }));
        let [s, t] = wrap.map(|wrap| match wrap {
            Wrap::Repeat => 10497,
            Wrap::Mirror => 33648,
            Wrap::Clamp => 33071,
        });
        // Linear between texels and between sizes.
        self.samplers.push(json!({ "magFilter": 9729, "minFilter": 9987, "wrapS": s, "wrapT": t }));
        let index = self.textures.len();
        self.textures.push(json!({ "sampler": index, "source": index }));
        Ok(json!({ "index": index }))
    }

    /// Adds them to the GLB's JSON.
    pub fn finish(self, root: &mut Value) {
        if !self.textures.is_empty() {
            root["images"] = self.images.into();
            root["samplers"] = self.samplers.into();
            root["textures"] = self.textures.into();
        }
    }
}

/// One image of roughness (green) and metallic (blue), as large as the larger of both; the number where one does not vary.
fn together(surface: &Surface, roughness: Option<&Values>, metallic: Option<&Values>) -> Option<(Image, [Wrap; 2])> {
    let texture = |values: Option<&Values>| match values {
        Some(Values::Texture { image, wrap }) => Some((image.clone(), *wrap)),
        _ => None,
    };
    let (rough, metal) = (texture(roughness), texture(metallic));
    let (_, wrap) = rough.as_ref().or(metal.as_ref())?;
    let sides = [&rough, &metal].into_iter().flatten().map(|(image, _)| (image.width, image.height));
    let (width, height) = sides.fold((1, 1), |a, b| (a.0.max(b.0), a.1.max(b.1)));
    let numbers = surface.shown_roughness_and_metallic();
    let at = |of: &Option<(Image, [Wrap; 2])>, number: f64, x: u32, y: u32| match of {
        // The nearest texel: images of a material as a rule have one size.
        Some((image, _)) => {
            let (x, y) = (x * image.width / width, y * image.height / height);
            image.pixels[(y * image.width + x) as usize][0]
        }
        #[allow(clippy::cast_possible_truncation)] // Images are single precision.
        None => number as f32,
    };
    let pixels = (0..width * height)
        .map(|k| {
            let (x, y) = (k % width, k / width);
            [0.0, at(&rough, numbers[0], x, y), at(&metal, numbers[1], x, y)]
        })
        .collect();
    Some((Image { width, height, pixels }, *wrap))
}
