//! The patches' colours in a photograph.

use gonio_scene::SceneError;
use gonio_scene::image::Image;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use std::str::FromStr;

/// The centres of the four patches at the chart's corners, in pixels: dark skin, bluish green, black, white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corners(pub [[f64; 2]; 4]);

/// A patch as a photograph shows it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// The mean of its middle.
    pub value: Vector3<f64>,
    /// Part of its pixels that are clipped.
    pub clipped: f64,
}

/// Half the side of a patch's middle, in units of the distance of patches: a patch fills about 0.87 of that.
const HALF: f64 = 0.22;
/// Samples along a side of the middle.
const SAMPLES: usize = 24;
/// Least distance of neighbouring patches in pixels.
const LEAST: f64 = 5.0;

impl FromStr for Corners {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse()).collect();
        match numbers.as_deref() {
            Ok(&[a, b, c, d, e, f, g, h]) if [a, b, c, d, e, f, g, h].iter().all(|value| value.is_finite()) => {
                Ok(Self([[a, b], [c, d], [e, f], [g, h]]))
            }
            _ => Err(
                "write X,Y of the centres of four patches in pixels: dark skin, bluish green, black, white, such as \
                      716,624,1252,613,1259,923,703,932"
                    .to_owned(),
            ),
        }
    }
}

impl Corners {
    /// Every other order of the four: turned, and mirrored.
    pub(super) fn others(self) -> impl Iterator<Item = Self> {
        let Self(points) = self;
        (1..8).map(move |k| {
            let place = |i: usize| if k < 4 { points[(i + k) % 4] } else { points[(k + 3 - i) % 4] };
            Self([place(0), place(1), place(2), place(3)])
        })
    }

    /// From the chart's columns 0..=5 and rows 0..=3 to pixels: the plane's projection through four points.
    fn projection(self) -> Option<Matrix3<f64>> {
        let chart = [[0.0, 0.0], [5.0, 0.0], [5.0, 3.0], [0.0, 3.0]];
        let mut a = SMatrix::<f64, 8, 8>::zeros();
        let mut b = SVector::<f64, 8>::zeros();
        for (k, ([x, y], [u, v])) in chart.into_iter().zip(self.0).enumerate() {
            a.set_row(2 * k, &SMatrix::<f64, 1, 8>::from_row_slice(&[x, y, 1.0, 0.0, 0.0, 0.0, -u * x, -u * y]));
            a.set_row(2 * k + 1, &SMatrix::<f64, 1, 8>::from_row_slice(&[0.0, 0.0, 0.0, x, y, 1.0, -v * x, -v * y]));
            (b[2 * k], b[2 * k + 1]) = (u, v);
        }
        let h = a.lu().solve(&b)?;
        let matrix = Matrix3::new(h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1.0);
        // A photograph shows the whole chart in front of the camera.
        let ahead = chart.iter().all(|&[x, y]| h[6] * x + h[7] * y + 1.0 > 1e-6);
        (ahead && matrix.iter().all(|value| value.is_finite())).then_some(matrix)
    }
}

/// The 24 patches, row by row from the dark skin. `clipped` says which pixels do not count; `file` is for messages.
///
/// # Errors
/// Corners outside of the photo, of no quadrangle, or too near each other.
pub fn see(file: &str, image: &Image, clipped: &[bool], corners: Corners) -> Result<Vec<Seen>, SceneError> {
    let refuse = |problem: String| {
        let mend = "give the centres of the dark skin, bluish green, black and white patch, X,Y each, in this order";
        SceneError::new(file, problem, mend).at("--corners")
    };
    let projection = corners.projection().ok_or_else(|| refuse("has corners that are no quadrangle".to_owned()))?;
    let place = |column: f64, row: f64| {
        let at = projection * Vector3::new(column, row, 1.0);
        [at[0] / at[2], at[1] / at[2]]
    };
    let mut patches = Vec::with_capacity(24);
    for k in 0..24 {
        let (column, row) = (f64::from(k % 6), f64::from(k / 6));
        let ([x, y], [right, lower]) = (place(column, row), place(column + 0.5, row));
        if 2.0 * (right - x).hypot(lower - y) < LEAST {
            return Err(refuse(format!("shows patches less than {LEAST} pixels apart, too small to be measured")));
        }
        let (mut sum, mut clips, mut count) = (Vector3::zeros(), 0.0, 0.0);
        for sample in 0..SAMPLES * SAMPLES {
            let off = |k: usize| HALF * ((2 * k + 1) as f64 / SAMPLES as f64 - 1.0);
            let [x, y] = place(column + off(sample % SAMPLES), row + off(sample / SAMPLES));
            if !(x >= 0.0 && y >= 0.0 && x < f64::from(image.width) && y < f64::from(image.height)) {
                return Err(refuse(format!(
                    "is {} x {} pixels, and the chart reaches beyond",
                    image.width, image.height
                )));
            }
            let pixel = y as usize * image.width as usize + x as usize;
            sum += Vector3::from(image.pixels[pixel].map(f64::from));
            clips += f64::from(u8::from(clipped[pixel]));
            count += 1.0;
        }
        patches.push(Seen { value: sum / count, clipped: clips / count });
    }
    Ok(patches)
}
