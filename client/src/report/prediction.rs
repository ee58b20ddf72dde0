//! The report of a prediction: what follows for the real part first, then curves, contrasts, images.

use super::html::{escape, significant};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gonio_pose::predict::{Interval, Prediction};
use std::fmt::Write;

/// The same image of both sets, with outlines of poses.
#[derive(Debug)]
pub struct PairPicture {
    /// Number of the scene.
    pub scene: u32,
    /// Number of the image.
    pub image: u32,
    /// The real image, PNG.
    pub real: Vec<u8>,
    /// The synthetic image, PNG.
    pub synthetic: Vec<u8>,
    /// MSSD in the real and in the synthetic image, as parts of the diameter; infinite for no estimate.
    pub errors: [f64; 2],
}

/// What a prediction's report is about.
#[derive(Debug)]
pub struct PredictionReport<'a> {
    /// The outcome.
    pub prediction: &'a Prediction,
    /// Images to show.
    pub pictures: &'a [PairPicture],
    /// The command that made it.
    pub command: &'a str,
    /// The program's version.
    pub version: &'a str,
}

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 380.0;
const LEFT: f64 = 60.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 52.0;
/// Dashes of the contrasts' curves, in turn.
const DASHES: [&str; 4] = ["2 4", "10 4", "10 4 2 4", "4 8"];

impl PredictionReport<'_> {
    /// The page.
    #[must_use]
    pub fn page(&self) -> String {
        let body = [
            self.verdict(),
            self.curves(),
            self.recalls(),
            self.agreement(),
            self.settings(),
            self.images(),
            format!(
                "<footer>\n<p>Made by gonio {} with <code>{}</code></p>\n</footer>\n",
                escape(self.version),
                escape(self.command)
            ),
        ]
        .concat();
        super::page("Prediction of a pose estimator's recall", &body)
    }

    fn verdict(&self) -> String {
        let p = self.prediction;
        let curve = if p.inside {
            "The synthetic images predict the recall curve of the real ones: it lies inside the band that chance leaves."
        } else {
            "The synthetic images do not predict the recall curve of the real ones: it leaves the band that chance leaves."
        };
        let equivalence = if p.equivalent {
            format!("The average recalls are equivalent to within {}.", significant(p.margin, 2))
        } else {
            format!(
                "These {} images do not show that the average recalls are equivalent to within {}.",
                p.images,
                significant(p.margin, 2)
            )
        };
        format!(
            "<section class=\"summary\">\n<p><strong>{curve}</strong></p>\n<p>Average recall {} on real, {} on synthetic images; the difference \
             is {}. {equivalence}</p>\n</section>\n",
            interval(&p.real),
            interval(&p.synthetic),
            interval(&p.gap),
        )
    }

    fn curves(&self) -> String {
        let p = self.prediction;
        let mut svg = format!(
            "<svg class=\"chart\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"Recall over the largest error allowed, on real and \
             synthetic images; the numbers are in prediction.json\">\n"
        );
        for tick in 0..=5 {
            let (recall, threshold) = (f64::from(tick) / 5.0, f64::from(tick) / 10.0);
            let (row, column) = (y(recall), x(threshold));
            let right = WIDTH - RIGHT;
            let _ =
                writeln!(svg, "<path class=\"axis\" d=\"M{LEFT} {row:.1}H{right}M{column:.1} {TOP}V{:.1}\"/>", y(0.0));
            let _ = writeln!(
                svg,
                "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{recall:.1}</text>",
                LEFT - 8.0,
                row + 4.0
            );
            let _ = writeln!(
                svg,
                "<text x=\"{column:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{threshold:.1}</text>",
                y(0.0) + 18.0
            );
        }
        let _ = writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">largest error allowed (MSSD), of the diameter</text>",
            (LEFT + WIDTH - RIGHT) / 2.0,
            HEIGHT - 10.0
        );
        let there = p.curve.iter().map(|point| (point.threshold, point.band[1]));
        let back = p.curve.iter().rev().map(|point| (point.threshold, point.band[0]));
        let _ = writeln!(svg, "<polygon class=\"band\" points=\"{}\"/>", points(there.chain(back)));
        let _ = writeln!(
            svg,
            "<polyline class=\"curve\" points=\"{}\"/>",
            points(p.curve.iter().map(|point| (point.threshold, point.real)))
        );
        let _ = writeln!(
            svg,
            "<polyline class=\"curve second\" points=\"{}\"/>",
            points(p.curve.iter().map(|point| (point.threshold, point.synthetic)))
        );
        let mut legend = "<li>solid: real, with the band in which a perfect prediction lies in 95 of \
                          100 cases, threshold by threshold</li>\n<li>dashed, violet: synthetic</li>\n"
            .to_owned();
        for (contrast, dashes) in p.contrasts.iter().zip(DASHES.iter().cycle()) {
            let thresholds = p.curve.iter().map(|point| point.threshold);
            let _ = writeln!(
                svg,
                "<polyline class=\"curve third\" stroke-dasharray=\"{dashes}\" points=\"{}\"/>",
                points(thresholds.zip(contrast.curve.iter().copied()))
            );
            let _ = writeln!(legend, "<li>thin, dashes {dashes}: {}</li>", escape(&contrast.name));
        }
        format!("<section>\n<h2>Recall</h2>\n{svg}</svg>\n<ul>\n{legend}</ul>\n</section>\n")
    }

    fn recalls(&self) -> String {
        let p = self.prediction;
        let mut rows = String::new();
        let mut row =
            |name: &str, recall: &Interval, change: Option<&Interval>, gap: Option<&Interval>, inside: Option<f64>| {
                let cell = |i: Option<&Interval>| i.map_or_else(|| "–".to_owned(), interval);
                let inside = inside.map_or_else(|| "–".to_owned(), |share| format!("{:.0} %", 100.0 * share));
                let _ = writeln!(
                    rows,
                    "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td><td>{inside}</td></tr>",
                    escape(name),
                    interval(recall),
                    cell(change),
                    cell(gap)
                );
            };
        row("real", &p.real, None, None, None);
        row("synthetic", &p.synthetic, None, Some(&p.gap), Some(p.inside_share));
        for c in &p.contrasts {
            row(&c.name, &c.recall, Some(&c.change), Some(&c.gap), Some(c.inside_share));
        }
        format!(
            "<section>\n<h2>Average recall</h2>\n<p>Mean over thresholds from 0.05 to 0.5 of the diameter; in brackets 95 % \
             intervals of a bootstrap over the {} images that the sets share, paired where two are compared.</p>\n<div class=\"wide\">\n<table>\n\
             <thead><tr><th scope=\"col\">set</th><th scope=\"col\">recall</th><th scope=\"col\">less synthetic</th>\
             <th scope=\"col\">less real</th><th scope=\"col\">of its curve in the band</th></tr></thead>\n<tbody>\n{rows}</tbody>\n\
             </table>\n</div>\n</section>\n",
            p.images
        )
    }

    fn agreement(&self) -> String {
        let a = &self.prediction.agreement;
        let number = |x: Option<f64>| x.map_or_else(|| "not defined".to_owned(), |x| significant(x, 3));
        format!(
            "<section>\n<h2>Image by image</h2>\n<p>At {} of the diameter: found in both {}, in the real image alone {}, in the \
             synthetic one alone {}, in neither {} (Cohen's kappa {}). Rank correlation of the errors (Spearman): {}.</p>\n\
             </section>\n",
            significant(a.threshold, 2),
            a.both,
            a.real_alone,
            a.synthetic_alone,
            a.neither,
            number(a.kappa),
            number(a.spearman)
        )
    }

    fn settings(&self) -> String {
        let Some(settings) = &self.prediction.settings else { return String::new() };
        let mut rows = String::new();
        for (name, real, synthetic) in &settings.list {
            let _ = writeln!(
                rows,
                "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td></tr>",
                escape(name),
                significant(*real, 3),
                significant(*synthetic, 3)
            );
        }
        let tau = settings.kendall.map_or_else(|| "not defined".to_owned(), |tau| significant(tau, 3));
        format!(
            "<section>\n<h2>Settings</h2>\n<p>Do synthetic images rank the settings as real ones do? Kendall's tau-b: {tau}.</p>\n\
             <table>\n<thead><tr><th scope=\"col\">setting</th><th scope=\"col\">real</th><th scope=\"col\">synthetic</th></tr>\
             </thead>\n<tbody>\n{rows}</tbody>\n</table>\n</section>\n"
        )
    }

    fn images(&self) -> String {
        let mut figures = String::new();
        for picture in self.pictures {
            let name = format!("scene {}, image {}", picture.scene, picture.image);
            let error = |x: f64| if x.is_finite() { significant(x, 2) } else { "no estimate".to_owned() };
            let source = |png: &[u8]| format!("data:image/png;base64,{}", STANDARD.encode(png));
            let [real, synthetic] = picture.errors.map(error);
            let _ = writeln!(
                figures,
                "<figure>\n<div class=\"duo\">\n<img src=\"{}\" alt=\"Real image with outlines, {name}\">\n<img src=\"{}\" alt=\"Synthetic image with \
                 outlines, {name}\">\n</div>\n<figcaption>{name}: error {real} real, {synthetic} synthetic</figcaption>\n</figure>",
                source(&picture.real),
                source(&picture.synthetic)
            );
        }
        format!(
            "<section>\n<h2>Images</h2>\n<p>Left real, right synthetic; true outlines green, estimated ones magenta. First the worst \
             of the real set, then those that differ most, then the middle ones.</p>\n<div class=\"pairs\">\n{figures}</div>\n\
             </section>\n"
        )
    }
}

fn interval(i: &Interval) -> String {
    format!("{} [{}, {}]", significant(i.value, 3), significant(i.low, 3), significant(i.high, 3))
}

fn points(places: impl Iterator<Item = (f64, f64)>) -> String {
    places.map(|(threshold, recall)| format!("{:.1},{:.1}", x(threshold), y(recall))).collect::<Vec<_>>().join(" ")
}

fn x(threshold: f64) -> f64 {
    LEFT + threshold / 0.5 * (WIDTH - LEFT - RIGHT)
}

fn y(recall: f64) -> f64 {
    TOP + (1.0 - recall) * (HEIGHT - TOP - BOTTOM)
}
