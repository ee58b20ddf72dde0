//! The matrix under which the patches come nearest to their colours.

use super::difference::{ciede2000, lab_of, parts, rgb_of};
use super::patches::{Corners, Seen, see};
use super::reference::{Edition, NAMES};
use gonio_scene::SceneError;
use gonio_scene::image::Image;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// A patch and how far it is off.
#[derive(Debug, Clone, PartialEq)]
pub struct Patch {
    /// Its name.
    pub name: &'static str,
    /// Its colour as the matrix makes it: CIELAB under D50.
    pub lab: [f64; 3],
    /// dE2000 from the published colour with one exposure for all, but without a matrix.
    pub before: f64,
    /// The same with the matrix.
    pub after: f64,
    /// Whether it is clipped, and was left out of the fit.
    pub saturated: bool,
}

/// What was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// From the photo's linear values to linear Rec. 709, exposure included: a white surface that reflects all light is 1.
    pub matrix: Matrix3<f64>,
    /// The factor on the photo's values that alone would do so for the grays.
    pub exposure: f64,
    /// The 24 patches.
    pub patches: Vec<Patch>,
    /// Mean dE2000 before and after over the patches that are not saturated.
    pub mean: [f64; 2],
}

/// A patch with more clipped pixels than this part is saturated.
const CLIPPED: f64 = 0.01;
/// Fewest patches for nine numbers.
const FEWEST: usize = 12;
/// Another order of the corners is the right one where it leaves less than this part of the error.
const CLEARLY: f64 = 0.6;
/// No camera's chart is further off on the mean (dE2000): what is there is no chart, or not of linear values.
const WORST: f64 = 12.0;
/// Steps of the fit; it settles within ten.
const STEPS: usize = 40;

/// Finds the matrix from a photo in linear values; `file` is for messages.
///
/// # Errors
/// As [`see`]; corners whose order does not fit, too many saturated patches, and a photo that shows no chart there.
pub fn fit(
    file: &str,
    image: &Image,
    clipped: &[bool],
    corners: Corners,
    edition: Edition,
) -> Result<Found, SceneError> {
    let found = of(file, &see(file, image, clipped, corners)?, edition)?;
    let other = |other: Corners| see(file, image, clipped, other).and_then(|seen| of(file, &seen, edition)).ok();
    let better = corners
        .others()
        .filter_map(|order| Some((order, other(order)?.mean[1])))
        .filter(|(_, error)| *error < CLEARLY * found.mean[1])
        .min_by(|a, b| a.1.total_cmp(&b.1));
    if let Some((order, error)) = better
        && found.mean[1] > 3.0
    {
        let points: Vec<String> = order.0.iter().flatten().map(|value| format!("{value}")).collect();
        let problem = format!(
            "shows the chart's patches {:.1} dE2000 from their colours in this order of corners, and {error:.1} in another",
            found.mean[1]
        );
        let mend = format!("the centres of dark skin, bluish green, black, white are rather {}", points.join(","));
        return Err(SceneError::new(file, problem, mend).at("--corners"));
    }
    if found.mean[1] > WORST {
        let problem =
            format!("shows no such chart there: its patches are {:.1} dE2000 from their colours", found.mean[1]);
        let mend = "correct --corners, or say by --response how values follow from light";
        return Err(SceneError::new(file, problem, mend).at("--corners"));
    }
    Ok(found)
}

fn of(file: &str, seen: &[Seen], edition: Edition) -> Result<Found, SceneError> {
    let lab = edition.lab();
    let usable: Vec<usize> = (0..24).filter(|&k| seen[k].clipped <= CLIPPED && seen[k].value.max() > 0.0).collect();
    if usable.len() < FEWEST {
        let problem =
            format!("has {} patches that are saturated or black: {FEWEST} others are needed", 24 - usable.len());
        return Err(SceneError::new(file, problem, "photograph the chart with a shorter exposure").at("saturation"));
    }
    let singular = || SceneError::new(file, "shows patches of one colour", "correct --corners").at("--corners");
    let targets: Vec<Vector3<f64>> = lab.iter().map(|lab| rgb_of(*lab)).collect::<Option<_>>().ok_or_else(singular)?;
    let exposure = exposure(seen, &targets, &usable);
    let start = linear(seen, &targets, &usable).ok_or_else(singular)?;
    let matrix = refine(start, seen, lab, &usable);
    let patches: Vec<Patch> = (0..24)
        .map(|k| {
            let made = lab_of(matrix * seen[k].value);
            Patch {
                name: NAMES[k],
                lab: made,
                before: ciede2000(lab_of(exposure * seen[k].value), lab[k]),
                after: ciede2000(made, lab[k]),
                saturated: !usable.contains(&k),
            }
        })
        .collect();
    let mean = |of: fn(&Patch) -> f64| usable.iter().map(|&k| of(&patches[k])).sum::<f64>() / usable.len() as f64;
    Ok(Found { matrix, exposure, mean: [mean(|patch| patch.before), mean(|patch| patch.after)], patches })
}

/// The factor that brings the usable patches' luminance nearest to theirs, in ratios.
fn exposure(seen: &[Seen], targets: &[Vector3<f64>], usable: &[usize]) -> f64 {
    let luminance = |rgb: &Vector3<f64>| (0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]).max(1e-6);
    let log = |&k: &usize| libm::log(luminance(&targets[k]) / luminance(&seen[k].value));
    libm::exp(usable.iter().map(log).sum::<f64>() / usable.len() as f64)
}

/// Least squares in linear values, each patch weighted by about what its lightness changes: the start.
fn linear(seen: &[Seen], targets: &[Vector3<f64>], usable: &[usize]) -> Option<Matrix3<f64>> {
    let (mut a, mut b) = (Matrix3::zeros(), Matrix3::zeros());
    for &k in usable {
        let weight = 1.0 / (0.02 + targets[k].norm()).powi(2);
        a += weight * seen[k].value * seen[k].value.transpose();
        b += weight * targets[k] * seen[k].value.transpose();
    }
    let matrix = b * a.try_inverse()?;
    matrix.iter().all(|value| value.is_finite()).then_some(matrix)
}

/// Levenberg-Marquardt on the weighted differences of lightness, chroma and hue.
fn refine(start: Matrix3<f64>, seen: &[Seen], lab: &[[f64; 3]; 24], usable: &[usize]) -> Matrix3<f64> {
    let residuals = |matrix: &Matrix3<f64>| {
        let each = usable.iter().flat_map(|&k| parts(lab[k], lab_of(matrix * seen[k].value)).0);
        DVector::from_iterator(3 * usable.len(), each)
    };
    let (mut matrix, mut damping) = (start, 1e-3);
    let mut current = residuals(&matrix);
    for _ in 0..STEPS {
        let mut jacobian = DMatrix::zeros(current.len(), 9);
        for k in 0..9 {
            let step = 1e-5 * matrix.norm();
            let mut moved = matrix;
            moved[k] += step;
            jacobian.set_column(k, &((residuals(&moved) - &current) / step));
        }
        let mut normal = jacobian.transpose() * &jacobian;
        for k in 0..9 {
            normal[(k, k)] *= 1.0 + damping;
        }
        let Some(step) = normal.lu().solve(&(jacobian.transpose() * &current)) else { break };
        let mut next = matrix;
        (0..9).for_each(|k| next[k] -= step[k]);
        let after = residuals(&next);
        if after.norm_squared() < current.norm_squared() {
            let settled = after.norm_squared() > (1.0 - 1e-9) * current.norm_squared();
            (matrix, current, damping) = (next, after, damping * 0.3);
            if settled {
                break;
            }
        } else {
            damping *= 5.0;
        }
    }
    matrix
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A photograph of the chart by a camera whose channels are a known mixture: patches of 20 pixels every 24.
    fn photograph(camera: &Matrix3<f64>) -> Image {
        let lab = Edition::Since2014.lab();
        let pixel = |k: usize| {
            let (x, y) = (k % 160, k / 160);
            let inside = |at: usize| at >= 8 && (at - 8) % 24 < 20;
            let (column, row) = (x.saturating_sub(8) / 24, y.saturating_sub(8) / 24);
            if !inside(x) || !inside(y) || column > 5 || row > 3 {
                return [0.01; 3];
            }
            let made = camera * rgb_of(lab[row * 6 + column]).unwrap();
            [made[0] as f32, made[1] as f32, made[2] as f32]
        };
        Image { width: 160, height: 112, pixels: (0..160 * 112).map(pixel).collect() }
    }

    #[test]
    fn a_known_mixture_is_undone_and_a_wrong_order_is_refused() {
        let camera = Matrix3::new(0.30, 0.12, 0.02, 0.08, 0.45, 0.10, 0.01, 0.09, 0.25);
        let image = photograph(&camera);
        let clipped = vec![false; image.pixels.len()];
        let right = Corners([[18.0, 18.0], [138.0, 18.0], [138.0, 90.0], [18.0, 90.0]]);
        let found = fit("a.exr", &image, &clipped, right, Edition::Since2014).unwrap();
        assert!((found.matrix * camera - Matrix3::identity()).norm() < 1e-4, "{}", found.matrix * camera);
        assert!(found.mean[1] < 0.01 && found.mean[0] > 5.0, "{:?}", found.mean);
        for order in right.others() {
            let error = fit("a.exr", &image, &clipped, order, Edition::Since2014).unwrap_err().to_string();
            assert!(error.contains("--corners") && error.contains("18,18,138,18,138,90,18,90"), "{error}");
        }
    }

    #[test]
    fn saturated_patches_are_named_and_too_many_are_refused() {
        let image = photograph(&Matrix3::identity());
        let right = Corners([[18.0, 18.0], [138.0, 18.0], [138.0, 90.0], [18.0, 90.0]]);
        let limit = |limit: f32| image.pixels.iter().map(|pixel| pixel.iter().any(|v| *v >= limit)).collect::<Vec<_>>();
        let found = fit("a.exr", &image, &limit(0.85), right, Edition::Since2014).unwrap();
        let named: Vec<_> = found.patches.iter().filter(|patch| patch.saturated).map(|patch| patch.name).collect();
        assert_eq!(named, ["white"]);
        let error = fit("a.exr", &image, &limit(0.1), right, Edition::Since2014).unwrap_err().to_string();
        assert!(error.contains("saturated") && error.contains("shorter exposure"), "{error}");
    }
}
