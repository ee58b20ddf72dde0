//! A cut-out part over a picture.

use super::pyramid::{LEVELS, Pyramid};
use super::sprite::Sprite;
use gonio_scene::image::Image;
use std::str::FromStr;

/// How a part is blended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// By alpha, over the picture low-passed the more, the less of it comes through: what a glossy or clouded part shows of
    /// its background has no sharp edges.
    #[default]
    AlphaBlur,
    /// By alpha, over the picture as it is.
    Alpha,
    /// All or nothing, at alpha 0.5.
    Binary,
}

impl FromStr for Method {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "alpha-blur" => Ok(Self::AlphaBlur),
            "alpha" => Ok(Self::Alpha),
            "binary" => Ok(Self::Binary),
            _ => Err("write alpha-blur, alpha or binary".to_owned()),
        }
    }
}

/// Where the sprite's upper left corner lies in the picture: column and row, possibly outside.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Place {
    /// Column.
    pub column: i64,
    /// Row.
    pub row: i64,
}

/// Draws `sprite` into `picture` in place: C = alpha F + (1 - alpha) B, with B the picture at the low-pass level that
/// `method` says for the pixel: level alpha * 5 of a pyramid, which averages over about 2^level pixels. Works on one
/// thread, and touches only the sprite's rectangle, so that frames of a video can be drawn over.
pub fn composite(picture: &mut Image, sprite: &Sprite, place: Place, method: Method) {
    let clip = |from: i64, size: usize, whole: u32| {
        let end = from.saturating_add(size as i64).clamp(0, i64::from(whole));
        (from.clamp(0, i64::from(whole)) as usize, end as usize)
    };
    let (left, right) = clip(place.column, sprite.width, picture.width);
    let (top, bottom) = clip(place.row, sprite.height, picture.height);
    if left >= right || top >= bottom {
        return;
    }
    // Beyond the sprite's rectangle by the coarsest level's reach, so that its border does not show.
    let reach = 1_usize << LEVELS;
    let frame = [
        left.saturating_sub(reach),
        top.saturating_sub(reach),
        (right + reach).min(picture.width as usize),
        (bottom + reach).min(picture.height as usize),
    ];
    let pyramid = (method == Method::AlphaBlur).then(|| Pyramid::new(picture, frame));
    for y in top..bottom {
        let row = (y as i64 - place.row) as usize * sprite.width;
        for x in left..right {
            let [r, g, b, alpha] = sprite.pixels[row + (x as i64 - place.column) as usize];
            if alpha <= 0.0 {
                continue;
            }
            let pixel = &mut picture.pixels[y * picture.width as usize + x];
            if method == Method::Binary {
                if alpha >= 0.5 {
                    *pixel = [r / alpha, g / alpha, b / alpha];
                }
                continue;
            }
            let through = 1.0 - alpha;
            let level = alpha * (LEVELS - 1) as f32;
            let behind = match &pyramid {
                // A hundredth of a level is not seen; noise of a matte's empty parts must not cost time.
                Some(pyramid) if through > 1e-3 && level > 0.01 => {
                    pyramid.at(*pixel, x - frame[0], y - frame[1], level)
                }
                _ => *pixel,
            };
            *pixel = [r + through * behind[0], g + through * behind[1], b + through * behind[2]];
        }
    }
}
