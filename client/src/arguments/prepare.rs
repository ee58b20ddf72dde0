//! What may be written after the commands that prepare data.

use clap::Args;
use gonio_prepare::chart::{Corners, Edition};
use gonio_prepare::composite::Method;
use gonio_prepare::hdr::Region;
use gonio_prepare::noise::{Curve, Patch};
use gonio_prepare::raw::{Balance, Colour, Demosaic};
use std::path::PathBuf;

/// `gonio hdr`.
#[derive(Debug, Args)]
pub struct HdrArguments {
    /// Photos of one scene at different exposure times
    #[arg(required = true)]
    pub photos: Vec<PathBuf>,
    /// List of lines `file,seconds`; absent, or for a photo that it leaves out, the time is taken from EXIF
    #[arg(long, value_name = "TIMES.csv")]
    pub times: Option<PathBuf>,
    /// OpenEXR to write; <name>.response.json, .response.svg, .preview.png and .marks.png are written beside it
    #[arg(long, value_name = "MAP.exr")]
    pub out: PathBuf,
    /// Part of the photos that the response is learnt from: all, or central:PART (of the front half of a panorama)
    #[arg(long, value_name = "REGION", default_value = "all")]
    pub region: Region,
    /// Response that an earlier run wrote, instead of learning one
    #[arg(long, value_name = "RESPONSE.json")]
    pub response: Option<PathBuf>,
    /// Shift the photos of a hand-held stack onto each other
    #[arg(long)]
    pub align: bool,
    /// Colour that marks what lies outside of a photo's frame, such as #0000ff
    #[arg(long, value_name = "#RRGGBB", value_parser = colour)]
    pub exclude: Option<[u8; 3]>,
    /// Turn a panorama: what lies this far to the right of the middle comes to the middle
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_hyphen_values = true)]
    pub turn: f64,
    /// Level a panorama whose camera was pitched up and rolled clockwise by these angles
    #[arg(long, value_name = "PITCH,ROLL", value_delimiter = ',', num_args = 1, allow_hyphen_values = true)]
    pub level: Vec<f64>,
    /// Fill a panorama further than this below the horizon from what lies just above there
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    pub fill_below: Option<f64>,
    /// Write the summary as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// `gonio noise`.
#[derive(Debug, Args)]
pub struct NoiseArguments {
    /// Photos of one still scene (a burst: 2 or more, best 8), of even fields at several exposures, or one photo with flat
    /// patches. What shows the same scene is found by itself
    #[arg(required = true)]
    pub photos: Vec<PathBuf>,
    /// How values follow from light: linear, srgb or gamma:EXPONENT [default: srgb for JPEG and 8-bit PNG, else linear]
    #[arg(long, value_name = "RESPONSE")]
    pub response: Option<Curve>,
    /// The part of every photo that counts, pixels [default: all, or the middle of very large photos]
    #[arg(long, value_name = "X,Y,WIDTH,HEIGHT")]
    pub patch: Option<Patch>,
    /// Value at and above which a pixel is clipped [default: 0.98 of the largest value, where that is 0.9 or more]
    #[arg(long, value_name = "VALUE")]
    pub saturation: Option<f32>,
    /// File to write the lines of a capture's [sensor] to; <name>.svg, variance over mean, is written beside it
    #[arg(long, value_name = "SENSOR.toml")]
    pub out: Option<PathBuf>,
    /// Write the result as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// `gonio develop`.
#[derive(Debug, Args)]
pub struct DevelopArguments {
    /// A camera's RAW file (DNG, CR2, CR3, NEF, ARW, RAF, RW2, ORF and others), or another photo
    pub photo: PathBuf,
    /// OpenEXR of linear light to write, 1 where a gray surface clips; <name>.mask.png beside it is black where a value is clipped
    #[arg(long, value_name = "RADIANCE.exr")]
    pub out: PathBuf,
    /// How colours that a pixel did not measure come about: bilinear (full size, neighbours correlated) or superpixel (half the
    /// size, a third for X-Trans, every pixel on its own)
    #[arg(long, value_name = "HOW", default_value = "bilinear")]
    pub demosaic: Demosaic,
    /// none keeps the light's colour; as-shot makes gray what the camera took for gray; R,G,B what has these values in the
    /// camera's channels
    #[arg(long, value_name = "WHAT", default_value = "none")]
    pub white_balance: Balance,
    /// rec709, by the file's matrices, or camera, the camera's own channels
    #[arg(long, value_name = "COLOURS", default_value = "rec709")]
    pub colour: Colour,
    /// The camera's colour matrix as `gonio chart` wrote it, instead of the file's
    #[arg(long, value_name = "MATRIX.json", conflicts_with = "colour")]
    pub matrix: Option<PathBuf>,
    /// How a photo's values follow from light, of other files than RAW: linear, srgb or gamma:EXPONENT [default: srgb for JPEG
    /// and 8-bit PNG, else linear]
    #[arg(long, value_name = "RESPONSE")]
    pub response: Option<Curve>,
    /// Write the summary as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// `gonio chart`.
#[derive(Debug, Args)]
pub struct ChartArguments {
    /// Photo of a ColorChecker Classic (24 patches), evenly lit: RAW, or any other
    pub photo: PathBuf,
    /// Centres of the patches at the chart's corners, pixels: dark skin, bluish green, black, white
    #[arg(long, value_name = "X,Y,X,Y,X,Y,X,Y")]
    pub corners: Corners,
    /// When the chart was made, since its pigments changed: since-2014 or before-2014 (November)
    #[arg(long, value_name = "WHEN", default_value = "since-2014")]
    pub edition: Edition,
    /// How values follow from light, of other files than RAW [default: srgb for JPEG and 8-bit PNG, else linear]
    #[arg(long, value_name = "RESPONSE")]
    pub response: Option<Curve>,
    /// Linear value at and above which a pixel is clipped [default: the white level, or 0.98 of the largest value]
    #[arg(long, value_name = "VALUE")]
    pub saturation: Option<f32>,
    /// Matrix and patches to write, for `gonio develop --matrix`
    #[arg(long, value_name = "MATRIX.json")]
    pub out: Option<PathBuf>,
    /// Write the photo with the matrix applied
    #[arg(long, value_name = "PHOTO.exr")]
    pub apply: Option<PathBuf>,
    /// Write the result as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// `gonio matte`.
#[derive(Debug, Args)]
pub struct MatteArguments {
    /// Photo of the part before a backdrop; given twice
    #[arg(long, value_name = "PHOTO", required = true)]
    pub on: Vec<PathBuf>,
    /// Photo of the backdrop alone, or its colour as #RRGGBB; given twice, in the order of --on
    #[arg(long, value_name = "PHOTO|#RRGGBB", required = true)]
    pub plate: Vec<String>,
    /// RGBA PNG to write, not multiplied by alpha
    #[arg(long, value_name = "MATTE.png")]
    pub out: PathBuf,
    /// Bits of a channel
    #[arg(long, value_name = "BITS", default_value_t = 8, value_parser = depth)]
    pub depth: u8,
    /// Leave shadows on the backdrop in the matte, as a black veil
    #[arg(long)]
    pub keep_shadows: bool,
    /// Round alpha to 0 or 1, for comparison
    #[arg(long)]
    pub binary: bool,
    /// Write the summary as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// A colour such as #0000ff.
pub fn colour(text: &str) -> Result<[u8; 3], String> {
    let mend = "write a colour as #RRGGBB, such as #0000ff";
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6).ok_or(mend)?;
    let number = u32::from_str_radix(digits, 16).map_err(|_| mend)?;
    Ok([(number >> 16) as u8, (number >> 8) as u8, number as u8])
}

fn depth(text: &str) -> Result<u8, String> {
    match text {
        "8" => Ok(8),
        "16" => Ok(16),
        _ => Err("write 8 or 16".to_owned()),
    }
}

/// `gonio plan`.
#[derive(Debug, Args)]
pub struct PlanArguments {
    /// Degrees between neighbouring views: 15 gives 104
    #[arg(long, value_name = "DEGREES", default_value_t = 15.0, allow_hyphen_values = true)]
    pub interval: f64,
    /// Distance of the cameras from the part, in any unit
    #[arg(long, value_name = "DISTANCE", default_value_t = 1.0, allow_hyphen_values = true)]
    pub radius: f64,
    /// File to write: .json, which `gonio composite` reads, or .csv
    #[arg(long, value_name = "VIEWS.json|.csv")]
    pub out: PathBuf,
}

/// `gonio composite`.
#[derive(Debug, Args)]
pub struct CompositeArguments {
    /// The plan; beside it lies <view name>.png for its views, as `gonio matte` writes them
    #[arg(value_name = "VIEWS.json")]
    pub views: PathBuf,
    /// Picture to blend into: one for all cameras, or one for each, such as a video's frames
    #[arg(long, value_name = "IMAGE", required = true, num_args = 1..)]
    pub background: Vec<PathBuf>,
    /// Azimuth and elevation in degrees, and distance in the plan's unit; may be repeated
    #[arg(long, value_name = "AZ,EL,DISTANCE", value_parser = camera, required_unless_present = "cameras", allow_hyphen_values = true)]
    pub camera: Vec<[f64; 3]>,
    /// File of such cameras, one a line, after those of --camera
    #[arg(long, value_name = "CAMERAS.csv")]
    pub cameras: Option<PathBuf>,
    /// Where the part's middle lies in the picture, pixels from the upper left; absent, in the picture's middle
    #[arg(long, value_name = "X,Y", value_delimiter = ',', num_args = 1, allow_hyphen_values = true)]
    pub at: Vec<i64>,
    /// How to blend: alpha-blur, alpha or binary
    #[arg(long, value_name = "METHOD", default_value = "alpha-blur")]
    pub method: Method,
    /// Folder to write frame_0000.png and so on to; created if need be
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Write the summary as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// A camera such as 30,45,1.5.
pub fn camera(text: &str) -> Result<[f64; 3], String> {
    let mend = "write AZIMUTH,ELEVATION,DISTANCE with a distance above 0, such as 30,45,1.5";
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse::<f64>()).collect();
    match numbers.as_deref() {
        Ok(&[azimuth, elevation, distance])
            if azimuth.is_finite() && elevation.is_finite() && distance.is_finite() && distance > 0.0 =>
        {
            Ok([azimuth, elevation, distance])
        }
        _ => Err(mend.to_owned()),
    }
}
