//! Tables as CSV, in the files' units: millimetres, pixels, degrees.

use super::Evaluation;
use super::score::{Measure, Scores};
use crate::bop::millimetres;
use std::collections::BTreeMap;
use std::fmt::Write;

/// One row per estimate and true pose that it was held against.
#[must_use]
pub fn errors_table(evaluation: &Evaluation) -> String {
    let mut text = "scene_id,im_id,obj_id,est,score,gt,visib_fract,target,vsd_tau_0.2,mssd_mm,mspd_px,add_mm,add_s_mm,\
                    projection_px,rotation_deg,translation_mm,diameter_mm\n"
        .to_owned();
    for group in &evaluation.groups {
        for pair in &group.pairs {
            let e = &pair.errors;
            let of = |list: &[f64], index: usize| list.get(index).copied().unwrap_or(f64::NAN);
            let vsd = e.vsd.and_then(|vsd| vsd.get(3).copied()).map_or(String::new(), |vsd| vsd.to_string());
            let _ = writeln!(
                text,
                "{},{},{},{},{},{},{},{},{vsd},{},{},{},{},{},{},{},{}",
                group.scene,
                group.image,
                group.object,
                pair.estimate,
                of(&group.scores, pair.estimate),
                pair.truth,
                of(&group.visible, pair.truth),
                u8::from(group.wanted.get(pair.truth) == Some(&true)),
                millimetres(e.mssd),
                e.mspd,
                millimetres(e.add),
                millimetres(e.add_s),
                e.projection,
                e.rotation,
                millimetres(e.translation),
                millimetres(e.diameter)
            );
        }
    }
    text
}

/// One row per image: targets, how many were found by MSSD at 0.1 of the diameter, and the mean recalls of MSSD and MSPD.
#[must_use]
pub fn images_table(evaluation: &Evaluation) -> String {
    let mut images: BTreeMap<(u32, u32), Vec<_>> = BTreeMap::new();
    for group in &evaluation.groups {
        images.entry((group.scene, group.image)).or_default().push(group);
    }
    let mut text = "scene_id,im_id,targets,found_mssd_0.1,mssd_recall,mspd_recall\n".to_owned();
    for ((scene, image), groups) in images {
        let found = |group: &&super::Group| group.matches(0.1, |e| Measure::Mssd.of(e)).iter().flatten().count();
        let found: usize = groups.iter().map(found).sum();
        let scores = Scores::new(&groups, false);
        let _ = writeln!(text, "{scene},{image},{},{found},{},{}", scores.targets, scores.mssd, scores.mspd);
    }
    text
}

/// One row per object (and `all`), measure and threshold.
#[must_use]
pub fn recalls_table(evaluation: &Evaluation) -> String {
    let mut text = "obj_id,targets,measure,threshold,recall\n".to_owned();
    let all = evaluation.scores.iter().map(|scores| ("all".to_owned(), scores));
    for (name, scores) in all.chain(evaluation.objects.iter().map(|(id, scores)| (id.to_string(), scores))) {
        let curves = [("vsd", &scores.vsd_recalls), ("mssd", &scores.mssd_recalls), ("mspd", &scores.mspd_recalls)];
        for (measure, curve) in curves {
            for point in curve {
                let _ = writeln!(text, "{name},{},{measure},{},{}", scores.targets, point.threshold, point.recall);
            }
        }
    }
    text
}
