//! What the reader of a fit must know, in plain words.

use crate::solve::Schedule;
use crate::uncertainty::Uncertainty;
use crate::{Score, Space};

/// Correlation from which on two parameters count as one.
const INSEPARABLE: f64 = 0.98;
/// Eigenvalue of the normal equations, scaled to a unit diagonal, below which a combination is undetermined.
const UNDETERMINED: f64 = 1e-6;

/// Variance of the estimate that is the render's over the rest of it, from which on more samples would pay.
const NOISY: f64 = 0.25;

/// The warnings about an estimate at physical `values`.
pub(crate) fn about(space: &Space, values: &[f64], uncertainty: &Uncertainty) -> Vec<String> {
    let names = space.names();
    let mut warnings = undetermined(&names, uncertainty);
    for (i, name) in names.iter().enumerate() {
        let (Some(transform), Some(value)) = (space.transforms().get(i), values.get(i)) else { continue };
        let error = uncertainty.standard_errors.get(i).copied().unwrap_or(f64::INFINITY);
        if error.is_infinite() {
            warnings.push(format!(
                "no fitted photo depends on {name}; its value is the start's: remove it from fit.parameters, or add photos that show it"
            ));
        } else if let Some(bound) = transform.bound(*value) {
            warnings.push(format!(
                "{name} is at its bound {bound}, so its standard error means little: the model, the exposure or the light may be wrong"
            ));
        } else if error > transform.span().min(span_of_open(*transform, *value)) {
            warnings.push(format!("{name} is not determined: its standard error {error:.2e} exceeds its whole range"));
        }
    }
    let disagreed: Vec<&str> = (names.iter().enumerate())
        .filter(|(i, _)| uncertainty.photos_disagree(*i))
        .map(|(_, name)| name.as_str())
        .collect();
    if !disagreed.is_empty() {
        warnings.push(format!(
            "the photos disagree about {} by more than noise explains; the standard errors are from their scatter",
            disagreed.join(" and ")
        ));
    }
    warnings
}

/// An open quantity is undetermined when its error exceeds itself.
fn span_of_open(transform: crate::Transform, value: f64) -> f64 {
    if matches!(transform, crate::Transform::Above { .. }) { value.abs() } else { f64::INFINITY }
}

/// Groups of parameters that the data cannot separate: by correlations, and by small eigenvalues.
fn undetermined(names: &[String], uncertainty: &Uncertainty) -> Vec<String> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let spectrum = &uncertainty.spectrum;
    for (k, _) in spectrum.values.iter().enumerate().filter(|(_, v)| **v < UNDETERMINED) {
        let members = (0..names.len())
            .filter(|i| spectrum.vectors[(*i, k)].abs() > 0.1 && spectrum.inverse_scale[*i] > 0.0)
            .collect();
        join(&mut groups, members);
    }
    for (i, row) in uncertainty.correlations.iter().enumerate() {
        for (j, _) in row.iter().enumerate().skip(i + 1).filter(|(_, c)| c.abs() > INSEPARABLE) {
            join(&mut groups, vec![i, j]);
        }
    }
    let largest = |group: &[usize]| {
        let pairs = group.iter().flat_map(|i| group.iter().filter(move |j| *j > i).map(move |j| (*i, *j)));
        pairs.filter_map(|(i, j)| uncertainty.correlations.get(i)?.get(j)).fold(0.0_f64, |m, c| m.max(c.abs()))
    };
    let text = |group: &Vec<usize>| {
        let members: Vec<&str> = group.iter().filter_map(|i| names.get(*i)).map(String::as_str).collect();
        format!(
            "the photos can hardly tell {} apart (correlation {:.3}): {}",
            members.join(" and "),
            largest(group),
            remedy(&members)
        )
    };
    groups.iter().filter(|g| g.len() > 1).map(text).collect()
}

/// Adds a group, merged with those that it shares a member with.
fn join(groups: &mut Vec<Vec<usize>>, mut members: Vec<usize>) {
    groups.retain(|group| {
        let shares = group.iter().any(|g| members.contains(g));
        if shares {
            members.extend(group);
        }
        !shares
    });
    members.sort_unstable();
    members.dedup();
    groups.push(members);
}

/// What would separate the members of a group.
fn remedy(names: &[&str]) -> &'static str {
    let any = |part: &str| names.iter().any(|n| n.contains(part));
    let placed = [".position", ".direction", ".azimuth"];
    let shines = |n: &&str| n.starts_with("light.") && !placed.iter().any(|key| n.contains(key));
    let light = names.iter().any(shines);
    if (light || any("gain") || any("exposure")) && any("base_color") {
        "put a part of known reflectance in view, or fix the light"
    } else if any("gain") || any("exposure") {
        "fix one photo's gain, or the light"
    } else if light && names.iter().all(shines) {
        "take photos with one light at a time"
    } else if any("roughness") || any("ior") || any(".eta") || any(".k.") {
        "take photos with the highlight in view, at mirror and at grazing angles, or fix one of them"
    } else if any("position") || any("object_to_world") || any("camera") || any("direction") {
        "take photos from more directions and distances, or fix one of them"
    } else {
        "fix one of them, or take photos that differ in them"
    }
}

/// The warnings about how the fit ended and how well it matches.
pub(crate) fn about_scores(uncertainty: &Uncertainty, fit: &Score, held_out: Option<&Score>) -> Vec<String> {
    let mut warnings = Vec::new();
    if fit.reduced_chi_square > 1.5 {
        warnings.push(format!(
            "reduced chi-square is {:.2}: the model does not explain the photos, or the sensor's noise is understated",
            fit.reduced_chi_square
        ));
    }
    if let Some(held) = held_out
        && held.reduced_chi_square > 1.5 * fit.reduced_chi_square.max(1.0)
    {
        warnings.push(format!(
            "held-out photos match much worse (reduced chi-square {:.2} against {:.2}): the fit does not carry over to them",
            held.reduced_chi_square, fit.reduced_chi_square
        ));
    }
    if Schedule::noise_ratio(uncertainty) > NOISY {
        warnings.push(format!(
            "render noise still makes {:.0} % of the estimates' variance at the most samples allowed; more samples would narrow the errors",
            100.0 * uncertainty.render_share()
        ));
    }
    warnings
}

/// The warning about samples of `which` photos that could not be used, if there were any.
pub(crate) fn about_samples(which: &str, invalid_samples: u64) -> Option<String> {
    (invalid_samples > 0).then(|| {
        format!(
            "{invalid_samples} samples of the {which} photos were NaN or infinite and count as black: look for degenerate triangles or extreme values"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_that_share_a_member_become_one() {
        let mut groups = Vec::new();
        for pair in [[0, 1], [3, 4], [1, 2], [4, 2]] {
            join(&mut groups, pair.to_vec());
        }
        assert_eq!(groups, [[0, 1, 2, 3, 4]]);
    }

    #[test]
    fn each_kind_of_confusion_has_its_remedy() {
        let cases = [
            (["material.a.base_color.r", "light.led.intensity"], "known reflectance"),
            (["photo.01.gain", "light.led.intensity"], "fix one photo's gain"),
            (["light.a.intensity", "light.b.intensity"], "one light at a time"),
            (["light.a.intensity", "light.a.position.z"], "more directions and distances"),
            (["material.a.roughness", "material.a.ior"], "highlight"),
            (["material.a.base_color.r", "material.b.base_color.r"], "fix one of them"),
        ];
        for (names, part) in cases {
            assert!(remedy(&names).contains(part), "{names:?}: {}", remedy(&names));
        }
    }
}
