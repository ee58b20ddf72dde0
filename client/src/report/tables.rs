//! The tables of parameters and of photos.

use super::Panel;
use super::html::{escape, grouped, significant, with_error};
use gonio_fit::FitResult;

/// What was estimated.
pub(super) fn parameters(result: &FitResult) -> String {
    if result.parameters.is_empty() {
        return "<section>\n<h2>Parameters</h2>\n<p>Nothing was free.</p>\n</section>\n".to_owned();
    }
    let error = |error: Option<f64>| error.map_or_else(|| "–".to_owned(), |e| significant(e, 2));
    let rows: String = result
        .parameters
        .iter()
        .map(|p| {
            format!(
                "<tr><th scope=\"row\"><code>{}</code></th><td>{}</td><td class=\"value\">{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
                escape(&p.name),
                significant(p.start, 4),
                with_error(p.value, p.standard_error),
                error(p.standard_error),
                error(p.model_error),
                error(p.between_photos_error)
            )
        })
        .collect();
    format!(
        "<section>\n<h2>Parameters</h2>\n<div class=\"wide\"><table>\n<caption>Estimates in the capture's units. The standard \
         error is the larger of the model's (from the curvature of the loss) and the scatter between photos where the two \
         disagree, else the model's.</caption>\n<thead><tr><th scope=\"col\">Name</th><th scope=\"col\">Start</th>\
         <th scope=\"col\">Value</th><th scope=\"col\">Standard error</th><th scope=\"col\">of the model</th>\
         <th scope=\"col\">between photos</th></tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n</section>\n"
    )
}

/// How well each photo is matched.
pub(super) fn photos(panels: &[Panel], samples: u32) -> String {
    if panels.is_empty() {
        return String::new();
    }
    let rows: String = panels
        .iter()
        .map(|panel| {
            format!(
                "<tr{}><th scope=\"row\">{}</th><td class=\"word\">{}</td><td>{}</td><td>{}</td><td class=\"value\">{}</td><td>{}</td></tr>\n",
                if panel.held_out { " class=\"held-out\"" } else { "" },
                escape(&panel.name),
                if panel.held_out { "held out" } else { "fit" },
                grouped(panel.counted),
                grouped(panel.clipped),
                significant(panel.reduced_chi_square, 4),
                significant(panel.rmse, 3)
            )
        })
        .collect();
    format!(
        "<section>\n<h2>Photos</h2>\n<div class=\"wide\"><table>\n<caption>Reduced chi-square is 1 where residuals are what sensor \
         noise and render noise explain. Only pixels inside the mask that are not clipped count. Rendered anew for this \
         report, with {samples} samples per pixel.</caption>\n\
         <thead><tr><th scope=\"col\">Photo</th><th scope=\"col\" class=\"word\">Role</th><th scope=\"col\">Pixels that count</th>\
         <th scope=\"col\">Clipped</th><th scope=\"col\">Reduced chi-square</th><th scope=\"col\">RMSE</th></tr></thead>\n\
         <tbody>\n{rows}</tbody>\n</table></div>\n</section>\n"
    )
}
