//! The report of a diagnosis: the verdict in one sentence first, then what it rests on.

use super::covariates;
use super::html::{escape, significant, with_error};
use super::panel::Panel;
use super::picture::legend;
use super::reflectance::{self, ReflectancePanel};
use super::share;
use gonio_diagnose::effects;
use gonio_diagnose::{Diagnosis, Finding, Structure, Verdict};

/// What a diagnosis' report is about.
#[derive(Debug)]
pub struct DiagnosisReport<'a> {
    /// The outcome.
    pub diagnosis: &'a Diagnosis,
    /// The fitted photos under the base model.
    pub before: &'a [Panel],
    /// The same under the final model.
    pub after: &'a [Panel],
    /// The fitted files of measured reflectance under the base model.
    pub files_before: &'a [ReflectancePanel],
    /// The same under the final model.
    pub files_after: &'a [ReflectancePanel],
    /// What each covariate explains of the base model's residuals.
    pub structure_before: &'a [Structure],
    /// And of the final model's.
    pub structure_after: &'a [Structure],
    /// The command that made it.
    pub command: &'a str,
    /// The program's version.
    pub version: &'a str,
}

impl DiagnosisReport<'_> {
    /// The page.
    #[must_use]
    pub fn page(&self) -> String {
        let body = [
            self.verdict(),
            self.found(),
            share::section(self.diagnosis),
            self.held_out(),
            covariates::section(self.structure_before, self.structure_after),
            self.photos(),
            self.files(),
            self.ranking(),
            self.base(),
            format!(
                "<footer>\n<p>Made by gonio {} with <code>{}</code> in {:.1} s.</p>\n</footer>\n",
                escape(self.version),
                escape(self.command),
                self.diagnosis.seconds
            ),
        ]
        .concat();
        super::page(&format!("Diagnosis of {}", escape(&self.diagnosis.capture)), &body)
    }

    fn verdict(&self) -> String {
        let d = self.diagnosis;
        let base = significant(d.base.fit.reduced_chi_square, 4);
        let held = d.found.first().and_then(|f| f.held_out);
        let gain = held.map_or_else(String::new, |h| {
            let percent = 100.0 * (1.0 - (h.reduced_chi_square_after / h.reduced_chi_square_before).sqrt());
            let error = if self.of_files() {
                format!("the error falls by {} %, ", significant(percent, 3))
            } else {
                String::new()
            };
            format!(
                "; on {} that nothing was fitted to, {error}reduced chi-square {}from {} to {}",
                self.targets(),
                if self.of_files() { "" } else { "falls " },
                significant(h.reduced_chi_square_before, 4),
                significant(h.reduced_chi_square_after, 4)
            )
        });
        let sentence = match d.verdict {
            Verdict::None => {
                format!("Nothing that matters: the residuals look like noise (reduced chi-square {base}).")
            }
            Verdict::Named => {
                let names: Vec<String> = d.found.iter().map(names).collect();
                format!("The simulation lacks {}{gain}.", names.join(", and "))
            }
            Verdict::Unexplained => {
                "Something is left in the residuals that no effect of the catalogue explains.".to_owned()
            }
        };
        let left = d.unexplained.as_ref().map_or_else(String::new, |s| {
            format!(
                "<p>What is left follows the {}, which predicts {} % of the residuals' variance in {} that it was not estimated \
                 from.</p>\n",
                escape(&s.covariate),
                significant(100.0 * s.strength, 2),
                if self.of_files() { "samples" } else { "pixels" }
            )
        });
        let noise = d.noise.map_or_else(String::new, |channels| {
            let each = channels.map(|c| with_error(c.factor().0, Some(c.factor().1)));
            format!(
                "<p>The photographs are noisier than the sensor is said to be: {} times in red, green and blue, by what no neighbour shares. \
                 Chi-square is held against that.</p>\n",
                each.join(", ")
            )
        });
        format!("<p class=\"summary\"><strong>{sentence}</strong></p>\n{noise}{left}")
    }

    /// What is compared with.
    fn targets(&self) -> &'static str {
        if self.of_files() { "files" } else { "photos" }
    }

    fn of_files(&self) -> bool {
        self.before.is_empty() && !self.files_before.is_empty()
    }

    fn found(&self) -> String {
        let each: String = self
            .diagnosis
            .found
            .iter()
            .map(|f| {
                let rows: String = f
                    .parameters
                    .iter()
                    .map(|p| {
                        format!(
                            "<tr><th scope=\"row\"><code>{}</code></th><td class=\"value\">{}</td><td>{}</td><td>{}</td></tr>\n",
                            escape(&p.name),
                            with_error(p.value, p.standard_error),
                            p.standard_error.map_or_else(|| "undetermined".to_owned(), |e| significant(e, 2)),
                            p.null.map_or_else(|| "–".to_owned(), |n| significant(n, 4))
                        )
                    })
                    .collect();
                format!(
                    "<h3>{}</h3>\n<p>{}</p>\n<p>To be sure, {}.</p>\n<div class=\"wide\"><table>\n<thead><tr><th scope=\"col\">Number</th>\
                     <th scope=\"col\">Value</th><th scope=\"col\">Standard error</th><th scope=\"col\">Without the effect</th></tr></thead>\n\
                     <tbody>\n{rows}</tbody>\n</table></div>\n",
                    escape(&if f.subject.is_empty() { names(f) } else { format!("{}: {}", names(f), f.subject) }),
                    escape(&looks(f)),
                    escape(&f.separate_by)
                )
            })
            .collect();
        if each.is_empty() { each } else { format!("<section>\n<h2>What was found</h2>\n{each}</section>\n") }
    }

    fn held_out(&self) -> String {
        let Some(h) = self.diagnosis.found.first().and_then(|f| f.held_out) else { return String::new() };
        let row = |what: &str, before: f64, after: f64| {
            format!(
                "<tr><th scope=\"row\">{what}</th><td>{}</td><td class=\"value\">{}</td></tr>\n",
                significant(before, 4),
                significant(after, 4)
            )
        };
        let psnr = match (h.psnr_before, h.psnr_after) {
            (Some(before), Some(after)) => row("PSNR (dB)", before, after),
            _ => String::new(),
        };
        let error = h.standard_error.map_or_else(String::new, |e| format!(" ± {}", significant(e, 2)));
        format!(
            "<section>\n<h2>Held-out {}</h2>\n<div class=\"wide\"><table>\n<caption>Not read before the model was final. The log predictive \
             density of an observation gains {}{error} nats.</caption>\n<thead><tr><th scope=\"col\">Score</th><th scope=\"col\">Before</th>\
             <th scope=\"col\">After</th></tr></thead>\n<tbody>\n{}{}{psnr}</tbody>\n</table></div>\n</section>\n",
            self.targets(),
            significant(h.log_density_gain, 3),
            row("Reduced chi-square", h.reduced_chi_square_before, h.reduced_chi_square_after),
            row("RMSE (compared values)", h.rmse_before, h.rmse_after)
        )
    }

    fn files(&self) -> String {
        if self.diagnosis.found.is_empty() {
            reflectance::section(self.files_before, &[])
        } else {
            reflectance::section(self.files_after, self.files_before)
        }
    }

    fn photos(&self) -> String {
        if self.before.is_empty() {
            return String::new();
        }
        let changed = !self.diagnosis.found.is_empty();
        let each: String = self
            .before
            .iter()
            .zip(self.after)
            .map(|(before, after)| {
                let name = escape(&before.name);
                let ((old, width, height), (new, ..)) = (before.pictures(), after.pictures());
                let figure = |picture: &str, caption: &str| {
                    format!(
                        "<figure><img src=\"{picture}\" width=\"{width}\" height=\"{height}\" alt=\"Photo {name}: {caption}\">\
                         <figcaption>{caption}</figcaption></figure>\n"
                    )
                };
                let third = if changed {
                    figure(&new[2], "Residual of the extended model")
                } else {
                    figure(&old[1], "Render")
                };
                let numbers = if changed {
                    format!(
                        "{} before, {} after",
                        significant(before.reduced_chi_square, 4),
                        significant(after.reduced_chi_square, 4)
                    )
                } else {
                    significant(before.reduced_chi_square, 4)
                };
                format!(
                    "<section class=\"photo\">\n<h3>Photo {name}</h3>\n<p>Reduced chi-square {numbers}.</p>\n<div class=\"triple\">\n{}{}{third}</div>\n</section>\n",
                    figure(&old[0], "Photo"),
                    figure(&old[2], "Residual of the base model")
                )
            })
            .collect();
        format!(
            "<section>\n<h2>Residuals</h2>\n<p>(photo \u{2212} render) / \u{3c3}, the mean of the three channels in units of its standard deviation by the \
             sensor's noise. Only photos that were fitted to.</p>\n{}{each}</section>\n",
            legend()
        )
    }

    fn ranking(&self) -> String {
        let rows: String = self
            .diagnosis
            .candidates
            .iter()
            // Of a material alone, what only a picture could show goes without saying.
            .filter(|c| !self.of_files() || c.score.is_some())
            .map(|c| {
                let number = |x: Option<f64>, digits| x.map_or_else(|| "–".to_owned(), |x| significant(x, digits));
                let change: Vec<String> = c
                    .expected_change
                    .iter()
                    .take(3)
                    .map(|(name, x)| format!("{} {}", name.rsplit('.').take(2).collect::<Vec<_>>().into_iter().rev().collect::<Vec<_>>().join("."), significant(*x, 3)))
                    .collect();
                let more = if c.expected_change.len() > 3 { ", …" } else { "" };
                format!(
                    "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td class=\"word\">{}{more}</td><td class=\"word\">{}</td></tr>\n",
                    escape(&c.effect),
                    number(c.gain, 3),
                    number(c.score, 4),
                    number(c.p_value, 2),
                    number(c.power, 2),
                    escape(&change.join(", ")),
                    escape(c.refused_because.as_deref().unwrap_or("found"))
                )
            })
            .collect();
        format!(
            "<section>\n<h2>All effects</h2>\n<div class=\"wide\"><table>\n<caption>At the base model. Gain: decrease of chi-square per observation on {} \
             left out one at a time. Score: promised decrease of chi-square over its dispersion. {}</caption>\n<thead><tr><th scope=\"col\">Effect</th><th scope=\"col\">Gain</th><th scope=\"col\">Score</th><th scope=\"col\">p</th>\
             <th scope=\"col\">Power</th><th scope=\"col\" class=\"word\">Expected change</th><th scope=\"col\" class=\"word\">Outcome</th></tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n</section>\n",
            self.targets(),
            if self.of_files() {
                "p is as if samples were independent, which they are not: what counts is the error on files left out."
            } else {
                "Power: chance that the score test notices an effect of the smallest gain of interest."
            }
        )
    }

    fn base(&self) -> String {
        let d = self.diagnosis;
        let rows: String = d
            .base
            .parameters
            .iter()
            .map(|p| {
                let last = d.last.parameters.iter().find(|l| l.name == p.name);
                format!(
                    "<tr><th scope=\"row\"><code>{}</code></th><td>{}</td><td class=\"value\">{}</td></tr>\n",
                    escape(&p.name),
                    with_error(p.value, p.standard_error),
                    last.map_or_else(|| "–".to_owned(), |l| with_error(l.value, l.standard_error))
                )
            })
            .collect();
        format!(
            "<section>\n<h2>The model's own numbers</h2>\n<div class=\"wide\"><table>\n<thead><tr><th scope=\"col\">Number</th><th scope=\"col\">Before</th>\
             <th scope=\"col\">After</th></tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n</section>\n"
        )
    }
}

fn names(finding: &Finding) -> String {
    finding.effects.join(" (or ") + &")".repeat(finding.effects.len().saturating_sub(1))
}

fn looks(finding: &Finding) -> String {
    let of = |name: &String| effects::all().find(|e| e.name == *name).map(|e| format!("{}: {}", e.name, e.looks));
    finding.effects.iter().filter_map(of).collect::<Vec<_>>().join("; ") + "."
}
