//! Recall over the threshold as an SVG picture.

use super::Evaluation;
use super::score::Recall;
use std::fmt::Write;

const LEFT: f64 = 56.0;
const TOP: f64 = 20.0;
const WIDTH: f64 = 460.0;
const HEIGHT: f64 = 300.0;
/// Right end of the axis of thresholds.
const LAST: f64 = 0.5;

/// The recalls of VSD, MSSD and MSPD; `None` where there is no recall (BOP24).
///
/// Self-contained: no font, script or picture from elsewhere; lines differ in their dashes, too.
#[must_use]
pub fn plot(evaluation: &Evaluation) -> Option<String> {
    let scores = evaluation.scores.as_ref()?;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" font-size=\"13\" \
         role=\"img\" aria-label=\"Recall over threshold\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        LEFT + WIDTH + 24.0,
        TOP + HEIGHT + 92.0
    );
    for tick in 0..=5 {
        let (recall, threshold) = (f64::from(tick) / 5.0, f64::from(tick) / 10.0);
        let (row, column) = (y(recall), x(threshold));
        let _ = writeln!(svg, "<path d=\"M{LEFT} {row:.1}h{WIDTH}M{column:.1} {TOP}v{HEIGHT}\" stroke=\"#ddd\"/>");
        let _ =
            writeln!(svg, "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{recall:.1}</text>", LEFT - 8.0, row + 4.0);
        let below = TOP + HEIGHT + 17.0;
        let _ = writeln!(svg, "<text x=\"{column:.1}\" y=\"{below}\" text-anchor=\"middle\">{threshold:.1}</text>");
    }
    let middle = LEFT + WIDTH / 2.0;
    let words = "threshold: of the diameter (MSSD), of 100 px (MSPD), of the surface (VSD)";
    let _ = writeln!(svg, "<text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">{words}</text>", TOP + HEIGHT + 40.0);
    let curves = [
        ("MSSD", &scores.mssd_recalls, "#2a5fa8", ""),
        ("MSPD", &scores.mspd_recalls, "#b3541e", "stroke-dasharray=\"7 4\""),
        ("VSD", &scores.vsd_recalls, "#3a7d44", "stroke-dasharray=\"2 3\""),
    ];
    let mut column = LEFT;
    for (name, curve, colour, dashes) in curves {
        if curve.is_empty() {
            continue;
        }
        let points: Vec<String> = curve.iter().map(|p| format!("{:.1},{:.1}", x(p.threshold), y(p.recall))).collect();
        let line = format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\" {dashes}");
        let _ = writeln!(svg, "<polyline points=\"{}\" {line}/>", points.join(" "));
        let row = TOP + HEIGHT + 70.0;
        let _ = writeln!(svg, "<path d=\"M{column} {}h28\" {line}/>", row - 4.0);
        let _ = writeln!(svg, "<text x=\"{}\" y=\"{row}\">{name}, mean {:.3}</text>", column + 34.0, average(curve));
        column += 158.0;
    }
    Some(svg + "</svg>\n")
}

fn average(curve: &[Recall]) -> f64 {
    super::score::mean(curve.iter().map(|point| point.recall))
}

fn x(threshold: f64) -> f64 {
    LEFT + threshold / LAST * WIDTH
}

fn y(recall: f64) -> f64 {
    TOP + (1.0 - recall) * HEIGHT
}
