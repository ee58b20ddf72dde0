//! How a RAW file is developed.

use std::str::FromStr;

/// How to develop.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// How colours that a pixel did not measure come about.
    pub demosaic: Demosaic,
    /// What is done about the colour of the scene's light.
    pub balance: Balance,
    /// Which colours come out.
    pub colour: Colour,
}

/// How colours that a pixel did not measure come about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Demosaic {
    /// The mean of the nearest pixels that did measure it: full size, neighbours' noise is correlated.
    #[default]
    Bilinear,
    /// One pixel of a mosaic's cell, half the size (a third for X-Trans): every pixel's noise is its own.
    Superpixel,
}

/// What is done about the colour of the scene's light.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Balance {
    /// Nothing: the light keeps its colour, as a render's does.
    #[default]
    None,
    /// What the camera took for gray becomes gray.
    AsShot,
    /// What has these values in the camera's channels becomes gray.
    Neutral([f64; 3]),
}

/// Which colours come out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Colour {
    /// Rec. 709, by the file's matrices.
    #[default]
    Rec709,
    /// The camera's own channels.
    Camera,
}

impl FromStr for Demosaic {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "bilinear" => Ok(Self::Bilinear),
            "superpixel" => Ok(Self::Superpixel),
            _ => Err("write bilinear or superpixel".to_owned()),
        }
    }
}

impl FromStr for Balance {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "none" => Ok(Self::None),
            "as-shot" => Ok(Self::AsShot),
            _ => {
                let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse()).collect();
                match numbers.as_deref() {
                    Ok(&[r, g, b]) if [r, g, b].iter().all(|value| value.is_finite() && *value > 0.0) => {
                        Ok(Self::Neutral([r, g, b]))
                    }
                    _ => {
                        Err("write none, as-shot, or a gray surface's values R,G,B in the camera's channels, such as \
                              0.40,1.0,0.59"
                            .to_owned())
                    }
                }
            }
        }
    }
}

impl FromStr for Colour {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "rec709" => Ok(Self::Rec709),
            "camera" => Ok(Self::Camera),
            _ => Err("write rec709 or camera".to_owned()),
        }
    }
}
