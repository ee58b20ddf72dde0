//! A file of measured reflectance in a report: values and residuals against the half angle, one chart of each per angle of
//! incidence.

mod bins;
mod chart;

use super::html::{escape, grouped, significant};
use bins::{BIN, Group, Sample, groups};
use chart::charts;
use gonio_scene::capture::{Role, Target};
use gonio_scene::reflectance::Pair;
use gonio_scene::{Capture, Film, PhotoStatistics, Photograph, SensorStage};

/// A file with its model, ready to be shown; holds sums over bins, no values.
#[derive(Debug, Clone)]
pub struct ReflectancePanel {
    /// The file's name.
    pub name: String,
    /// The material that was measured.
    pub material: String,
    /// Whether it was kept from the fit.
    pub held_out: bool,
    /// Its samples.
    pub samples: u64,
    /// Chi-square per observation.
    pub reduced_chi_square: f64,
    /// Root of the mean squared residual, in the values that are compared.
    pub rmse: f64,
    /// Where ratios turn into differences, 1/sr; absent where values are compared as they are.
    scale: Option<f64>,
    groups: Vec<Group>,
}

impl ReflectancePanel {
    /// A panel of file `statistics.photo` of `capture`, from its values, its directions, its film and its comparison at the
    /// same parameters. `None` where these do not belong together, or it is a photo.
    #[must_use]
    pub fn new(
        capture: &Capture,
        measured: &Photograph,
        pairs: &[Pair],
        film: &Film,
        statistics: &PhotoStatistics,
    ) -> Option<Self> {
        let Some(Target::Reflectance(file)) = capture.target(statistics.photo) else { return None };
        let fits = film.channels.len() == 3
            && film.channels.iter().all(|channel| channel.len() >= pairs.len())
            && measured.image.pixels.len() >= pairs.len();
        if !fits || pairs.is_empty() {
            return None;
        }
        let scale = (file.relative_noise > 0.0).then(|| file.noise / file.relative_noise);
        let stage = SensorStage::of(capture, statistics.photo);
        let sensor = capture.sensor_of(statistics.photo);
        let samples = pairs.iter().enumerate().map(|(i, pair)| {
            let model = stage.value([0, 1, 2].map(|c| f64::from(film.channels[c][i])), 0, 0).value;
            let values = measured.image.pixels[i].map(f64::from);
            let variance: f64 = model.iter().map(|v| sensor.variance(*v)).sum();
            let (sum, of_model): (f64, f64) = (values.iter().sum(), model.iter().sum());
            Sample {
                incidence: libm::acos(pair.incident[2].clamp(-1.0, 1.0)).to_degrees(),
                half: pair.half_angle().to_degrees(),
                measured: sum / 3.0 / scale.unwrap_or(1.0),
                model: of_model / 3.0 / scale.unwrap_or(1.0),
                residual: (sum - of_model) / variance.max(f64::MIN_POSITIVE).sqrt(),
            }
        });
        #[allow(clippy::cast_precision_loss)]
        let observations = (statistics.observations as f64).max(1.0);
        Some(Self {
            name: file.name().to_owned(),
            material: file.material.clone(),
            held_out: file.role == Role::HeldOut,
            samples: pairs.len() as u64,
            reduced_chi_square: statistics.reduced_chi_square(),
            rmse: (statistics.squared_error.max(0.0) / observations).sqrt(),
            scale,
            groups: groups(samples.collect()),
        })
    }

    /// `base` is the same file under a model before, if there was one.
    fn html(&self, base: Option<&Self>) -> String {
        let (class, badge) =
            if self.held_out { (" held-out", " <span class=\"badge\">held out</span>") } else { ("", "") };
        let before = base.map_or_else(String::new, |b| format!("{} before, ", significant(b.reduced_chi_square, 4)));
        let after = if base.is_some() { " after" } else { "" };
        let figures: String = self
            .groups
            .iter()
            .enumerate()
            .map(|(i, group)| charts(self, group, base.and_then(|b| b.groups.get(i))))
            .collect();
        format!(
            "<section class=\"photo{class}\">\n<h3>File {}{badge}</h3>\n<p>Material {}, {} samples; reduced chi-square {before}{}{after}.</p>\n\
             <div class=\"pairs\">\n{figures}</div>\n</section>\n",
            escape(&self.name),
            escape(&self.material),
            grouped(self.samples),
            significant(self.reduced_chi_square, 4)
        )
    }
}

/// All files of a report; `base` holds them under a model before, or nothing.
pub(super) fn section(panels: &[ReflectancePanel], base: &[ReflectancePanel]) -> String {
    if panels.is_empty() {
        return String::new();
    }
    let of_base = |panel: &ReflectancePanel| base.iter().find(|b| b.name == panel.name);
    let files: String = panels.iter().map(|panel| panel.html(of_base(panel))).collect();
    let models = if base.is_empty() {
        "the model's in colour"
    } else {
        "the base model's in gray, the extended one's in colour"
    };
    format!(
        "<section>\n<h2>Measured reflectance</h2>\n<p>Against the angle between normal and half vector, over bins of {BIN} degrees, mean of the three \
         channels. Left: measured means as dots, with bars from the smallest to the largest sample, and {models}; logarithmic where values are large. \
         Right: the residual (measured \u{2212} model) in units of its stated standard deviation. Neighbouring samples err alike, so that curves away from zero are no noise.</p>\n\
         {files}</section>\n"
    )
}

/// How well each file is matched.
pub(super) fn table(panels: &[ReflectancePanel]) -> String {
    if panels.is_empty() {
        return String::new();
    }
    let rows: String = panels
        .iter()
        .map(|panel| {
            format!(
                "<tr{}><th scope=\"row\">{}</th><td class=\"word\">{}</td><td class=\"word\">{}</td><td>{}</td><td class=\"value\">{}</td><td>{}</td></tr>\n",
                if panel.held_out { " class=\"held-out\"" } else { "" },
                escape(&panel.name),
                escape(&panel.material),
                if panel.held_out { "held out" } else { "fit" },
                grouped(panel.samples),
                significant(panel.reduced_chi_square, 4),
                significant(panel.rmse, 3)
            )
        })
        .collect();
    format!(
        "<section>\n<h2>Files of reflectance</h2>\n<div class=\"wide\"><table>\n<caption>Reduced chi-square is 1 where residuals are what the stated noise explains. \
         RMSE in the values that are compared, see the capture format.</caption>\n<thead><tr><th scope=\"col\">File</th><th scope=\"col\" class=\"word\">Material</th>\
         <th scope=\"col\" class=\"word\">Role</th><th scope=\"col\">Samples</th><th scope=\"col\">Reduced chi-square</th><th scope=\"col\">RMSE</th></tr></thead>\n\
         <tbody>\n{rows}</tbody>\n</table></div>\n</section>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::bins::GROUPS;
    use super::*;
    use gonio_scene::capture::Reflectance;
    use gonio_scene::image::Image;
    use std::f64::consts::PI;

    fn panel(model: f32) -> Option<ReflectancePanel> {
        let file = Reflectance { file: "s/<a>.csv".to_owned(), role: Role::HeldOut, ..Reflectance::default() };
        let capture = Capture { reflectance: vec![file.clone()], ..Capture::default() };
        let angles = (0..40).map(|i| [0.1 + 0.2 * f64::from(i / 8), 0.0, 0.15 * f64::from(i % 8), PI]);
        let pairs: Vec<Pair> = angles.map(Pair::of_angles).collect();
        #[allow(clippy::cast_possible_truncation)]
        let value = file.value(0.5).0 as f32;
        let image = Image { width: 40, height: 1, pixels: vec![[value; 3]; 40] };
        let measured = Photograph::new(image, vec![true; 40], 0);
        let film = Film { photo: 0, width: 40, height: 1, channels: vec![vec![model; 40]; 3] };
        let statistics =
            PhotoStatistics { observations: 120, gram: vec![60.0], noise_floor: 120.0, ..PhotoStatistics::default() };
        ReflectancePanel::new(&capture, &measured, &pairs, &film, &statistics)
    }

    #[test]
    fn samples_are_grouped_and_compared() {
        let panel = panel(0.5).unwrap();
        assert_eq!((panel.groups.len(), panel.samples), (GROUPS, 40));
        let bins = || panel.groups.iter().flat_map(|g| &g.bins);
        assert!(bins().count() > 20);
        // asinh(0.5 / 0.02), and no residual where both agree.
        assert!(bins().all(|b| (b.measured[0] - libm::asinh(25.0)).abs() < 1e-3 && b.residual.abs() < 1e-2));
        let groups: Vec<[f64; 2]> = panel.groups.iter().map(|g| g.incidence.map(f64::round)).collect();
        assert_eq!(groups[0], [6.0, 17.0], "{groups:?}");
        assert_eq!(groups[3], [52.0, 52.0], "{groups:?}");
    }

    #[test]
    fn a_page_shows_both_models_and_no_markup_of_a_name() {
        let (base, last) = (panel(0.3).unwrap(), panel(0.5).unwrap());
        let html = section(std::slice::from_ref(&last), std::slice::from_ref(&base)) + &table(&[last]);
        assert!(html.contains("held out") && html.contains("&lt;a&gt;") && !html.contains("<a>"));
        assert_eq!(html.matches("<svg").count(), 2 * GROUPS);
        assert!(html.contains("curve old") && html.contains("curve new") && !html.contains("NaN"));
        assert_eq!(section(&[], &[]) + &table(&[]), "");
    }
}
