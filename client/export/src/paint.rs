//! How a material varies over a part by maps: what exporters make of vertex colours and textures.

use crate::atlas;
use gonio_scene::capture::MapRole;
use gonio_scene::image::Image;
use gonio_scene::mesh::Wrap;
use gonio_scene::textures::{TextureKey, Varied};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The maps of one part's material, by [`MapRole`].
#[derive(Debug, Clone, Default)]
pub struct Paint([Option<Map>; 3]);

/// A factor on a number.
#[derive(Debug, Clone)]
struct Map {
    /// Linear RGB; the mean of the vertex colours is in it where a texture varies, too.
    factor: [f64; 3],
    over: Over,
    /// Whether vertex colours became their mean.
    averaged: bool,
}

/// What a factor varies by.
#[derive(Debug, Clone)]
enum Over {
    Nothing,
    /// Linear RGB of each vertex.
    Vertices(Arc<[[f32; 3]]>),
    Texture {
        image: Arc<Image>,
        wrap: [Wrap; 2],
    },
    /// Vertex colours in a texture of [`atlas::unwrap`].
    Atlas(Arc<Image>),
}

/// A number with its map applied.
#[derive(Debug, Clone)]
pub enum Values {
    Vertices(Vec<[f32; 3]>),
    Texture { image: Image, wrap: [Wrap; 2] },
}

impl Paint {
    /// Of a part whose vertices have `colours`.
    pub fn new(
        maps: &[Option<Varied>; 3],
        colours: Option<&[[f32; 3]]>,
        textures: &BTreeMap<TextureKey, Arc<Image>>,
    ) -> Self {
        let map = |varied: &Varied| {
            let texture = varied.texture.as_ref().and_then(|t| Some((textures.get(&t.key)?.clone(), t.wrap)));
            let colours = if varied.colours { colours } else { None };
            let mut map = Map { factor: varied.factor.map(f64::from), over: Over::Nothing, averaged: false };
            match (texture, colours) {
                (Some((image, wrap)), colours) => {
                    if let Some(mean) = colours.and_then(mean) {
                        (0..3).for_each(|c| map.factor[c] *= mean[c]);
                        map.averaged = true;
                    }
                    map.over = Over::Texture { image, wrap };
                }
                (None, Some(colours)) => map.over = Over::Vertices(colours.into()),
                (None, None) => {}
            }
            map
        };
        let mut paint = Self::default();
        paint.0.iter_mut().zip(maps).for_each(|(slot, varied)| *slot = varied.as_ref().map(map));
        paint
    }

    /// Whether nothing varies and nothing has a factor.
    pub fn is_plain(&self) -> bool {
        self.0.iter().flatten().all(|map| matches!(map.over, Over::Nothing) && map.factor == [1.0; 3])
    }

    /// Whether a number has a map that varies.
    pub fn varies(&self, role: MapRole) -> bool {
        self.map(role).is_some_and(|map| !matches!(map.over, Over::Nothing))
    }

    /// Whether vertex colours became their mean, since a texture varies the same number.
    pub fn averaged(&self, role: MapRole) -> bool {
        self.map(role).is_some_and(|map| map.averaged)
    }

    /// The vertex colours that vary a number.
    pub fn vertices(&self) -> Option<Arc<[[f32; 3]]>> {
        self.0.iter().flatten().find_map(|map| match &map.over {
            Over::Vertices(colours) => Some(colours.clone()),
            _ => None,
        })
    }

    /// With a texture of the vertex colours in their place.
    #[must_use]
    pub fn with_atlas(mut self, image: &Arc<Image>) -> Self {
        for map in self.0.iter_mut().flatten() {
            if matches!(map.over, Over::Vertices(_)) {
                map.over = Over::Atlas(image.clone());
            }
        }
        self
    }

    /// Whether a texture varies one of the numbers.
    pub fn textured(&self) -> bool {
        self.0.iter().flatten().any(|map| matches!(map.over, Over::Texture { .. } | Over::Atlas(_)))
    }

    /// What `number` is in the mean over the part's vertices or texels; as it is without a map.
    pub fn mean(&self, role: MapRole, number: [f64; 3]) -> [f64; 3] {
        let Some(map) = self.map(role) else { return number };
        let mean = match &map.over {
            Over::Nothing => None,
            Over::Vertices(colours) => mean(colours),
            // Of an atlas the fourth texels count as well: their mean is that of the corners, by their weights.
            Over::Texture { image, .. } | Over::Atlas(image) => mean(&image.pixels),
        };
        let mean = mean.unwrap_or([1.0; 3]);
        [0, 1, 2].map(|c| number[c] * map.factor[c] * mean[c])
    }

    /// `number` at each vertex or texel, as `convert` makes it another renderer's; `None` where nothing varies.
    #[allow(clippy::cast_possible_truncation)] // Images and vertices are single precision.
    pub fn values(&self, role: MapRole, number: [f64; 3], convert: impl Fn([f64; 3]) -> [f64; 3]) -> Option<Values> {
        let map = self.map(role)?;
        let of =
            |at: &[f32; 3]| convert([0, 1, 2].map(|c| number[c] * map.factor[c] * f64::from(at[c]))).map(|v| v as f32);
        Some(match &map.over {
            Over::Nothing => return None,
            Over::Vertices(colours) => Values::Vertices(colours.iter().map(of).collect()),
            Over::Atlas(image) => {
                let mut pixels: Vec<[f32; 3]> = image.pixels.iter().map(of).collect();
                let width = image.width as usize;
                for y in (0..image.height as usize).step_by(2) {
                    for x in (0..width).step_by(2) {
                        let at = [y * width + x, y * width + x + 1, (y + 1) * width + x];
                        pixels[at[2] + 1] = atlas::fourth(at.map(|texel| pixels[texel]));
                    }
                }
                let image = Image { width: image.width, height: image.height, pixels };
                Values::Texture { image, wrap: [Wrap::Clamp; 2] }
            }
            Over::Texture { image, wrap } => {
                let pixels = image.pixels.iter().map(of).collect();
                Values::Texture { image: Image { width: image.width, height: image.height, pixels }, wrap: *wrap }
            }
        })
    }

    fn map(&self, role: MapRole) -> Option<&Map> {
        self.0[role as usize].as_ref()
    }
}

/// The channel of a map that a number of one channel takes, in all three.
pub fn spread(role: MapRole, value: [f64; 3]) -> [f64; 3] {
    match role {
        MapRole::BaseColor => value,
        MapRole::Roughness => [value[1]; 3],
        MapRole::Metallic => [value[2]; 3],
    }
}

fn mean(values: &[[f32; 3]]) -> Option<[f64; 3]> {
    let count = values.len() as f64;
    let sum = |c: usize| values.iter().map(|value| f64::from(value[c])).sum::<f64>();
    (!values.is_empty()).then(|| [0, 1, 2].map(|c| sum(c) / count))
}

#[cfg(test)]
mod tests {
    use super::*;
    use gonio_scene::image::Curve;
    use gonio_scene::textures::Texture;

    const COLOURS: [[f32; 3]; 2] = [[0.2, 0.4, 0.6], [0.4, 0.8, 1.0]];

    fn varied(colours: bool, texture: bool) -> [Option<Varied>; 3] {
        let key = TextureKey { place: "wood.png".to_owned(), curve: Curve::Colour };
        let texture = texture.then_some(Texture { key, embedded: None, wrap: [Wrap::Clamp; 2] });
        [Some(Varied { factor: [0.5, 1.0, 1.0], colours, texture }), None, None]
    }

    fn textures() -> BTreeMap<TextureKey, Arc<Image>> {
        let image = Image { width: 2, height: 1, pixels: vec![[0.5, 0.5, 0.5], [1.0, 0.0, 0.5]] };
        BTreeMap::from([(TextureKey { place: "wood.png".to_owned(), curve: Curve::Colour }, Arc::new(image))])
    }

    #[test]
    fn vertex_colours_and_textures_multiply_the_number() {
        let paint = Paint::new(&varied(true, false), Some(&COLOURS), &textures());
        assert!(paint.varies(MapRole::BaseColor) && !paint.textured() && !paint.varies(MapRole::Roughness));
        let Some(Values::Vertices(values)) = paint.values(MapRole::BaseColor, [0.5, 0.5, 0.5], |c| c) else { panic!() };
        assert_eq!(values, [[0.05, 0.2, 0.3], [0.1, 0.4, 0.5]]);
        let mean = paint.mean(MapRole::BaseColor, [1.0; 3]);
        assert!((mean[0] - 0.15).abs() < 1e-6 && (mean[2] - 0.8).abs() < 1e-6);
        let paint = Paint::new(&varied(false, true), Some(&COLOURS), &textures());
        let Some(Values::Texture { image, wrap }) = paint.values(MapRole::BaseColor, [1.0; 3], |c| c.map(|x| x * x))
        else {
            panic!()
        };
        assert_eq!((image.pixels[1], wrap), ([0.25, 0.0, 0.25], [Wrap::Clamp; 2]));
    }

    #[test]
    fn where_both_vary_colours_become_their_mean() {
        let paint = Paint::new(&varied(true, true), Some(&COLOURS), &textures());
        assert!(paint.averaged(MapRole::BaseColor) && paint.textured());
        let Some(Values::Texture { image, .. }) = paint.values(MapRole::BaseColor, [1.0; 3], |c| c) else { panic!() };
        // 0.5 x the mean red 0.3 x 0.5.
        assert!((image.pixels[0][0] - 0.075).abs() < 1e-6);
    }

    #[test]
    fn a_map_that_says_nothing_is_plain() {
        let nothing = [Some(Varied { factor: [1.0; 3], colours: false, texture: None }), None, None];
        assert!(Paint::new(&nothing, None, &textures()).is_plain());
        assert!(!Paint::new(&varied(false, false), None, &textures()).is_plain());
        assert_eq!(spread(MapRole::Roughness, [0.1, 0.2, 0.3]), [0.2; 3]);
    }
}
