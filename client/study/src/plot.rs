//! The zROC of a study as an SVG picture.

use crate::Summary;
use std::fmt::Write;

const SIZE: f64 = 440.0;
const LEFT: f64 = 60.0;
const TOP: f64 = 46.0;
const HEIGHT: f64 = 560.0;
const INK: &str = "#2a5fa8";

/// A place in z units of either axis, in pixels.
struct Axes {
    reach: f64,
}

impl Axes {
    fn x(&self, z: f64) -> f64 {
        LEFT + SIZE * (z + self.reach) / (2.0 * self.reach)
    }

    fn y(&self, z: f64) -> f64 {
        TOP + SIZE * (self.reach - z) / (2.0 * self.reach)
    }
}

/// Points of the pooled ratings, each observer at the criterion, the fitted line, and what it means in words.
///
/// Self-contained: no font, script or picture from elsewhere, readable in black and white.
#[must_use]
pub fn plot(summary: &Summary) -> String {
    let points = summary.counts.z_points();
    let observers: Vec<_> = summary
        .observers
        .iter()
        .map(|row| (-row.criterion - row.d_prime / 2.0, row.d_prime / 2.0 - row.criterion))
        .collect();
    let largest = points.iter().chain(&observers).flat_map(|(f, h)| [f.abs(), h.abs()]).fold(1.5, f64::max);
    let axes = Axes { reach: (largest + 0.25).ceil() };
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {HEIGHT}\" font-family=\"sans-serif\" \
         font-size=\"13\" role=\"img\" aria-label=\"zROC\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        LEFT + SIZE + 20.0
    );
    grid(&mut svg, &axes);
    if let Some(roc) = summary.roc {
        // Where the line leaves the square.
        let clip = |x: f64| (roc.intercept + roc.slope * x).clamp(-axes.reach, axes.reach);
        let inverse = |y: f64| (y - roc.intercept) / roc.slope;
        let (x0, x1) = (inverse(clip(-axes.reach)), inverse(clip(axes.reach)));
        line(&mut svg, (axes.x(x0), axes.y(clip(x0))), (axes.x(x1), axes.y(clip(x1))), INK, "stroke-width=\"2\"");
    }
    for (f, h) in &observers {
        let _ = writeln!(
            svg,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"4\" fill=\"none\" stroke=\"#666\"/>",
            axes.x(*f),
            axes.y(*h)
        );
    }
    for (f, h) in &points {
        let _ = writeln!(svg, "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"5\" fill=\"{INK}\"/>", axes.x(*f), axes.y(*h));
    }
    legend(&mut svg, summary);
    svg + "</svg>\n"
}

fn line(svg: &mut String, from: (f64, f64), to: (f64, f64), color: &str, more: &str) {
    let _ = writeln!(
        svg,
        "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"{color}\" {more}/>",
        from.0, from.1, to.0, to.1
    );
}

fn text(svg: &mut String, (x, y): (f64, f64), more: &str, words: &str) {
    let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" {more}>{words}</text>");
}

fn grid(svg: &mut String, axes: &Axes) {
    let reach = axes.reach as i32;
    for tick in -reach..=reach {
        let z = f64::from(tick);
        let color = if tick == 0 { "#999" } else { "#ddd" };
        line(svg, (axes.x(z), TOP), (axes.x(z), TOP + SIZE), color, "");
        line(svg, (LEFT, axes.y(z)), (LEFT + SIZE, axes.y(z)), color, "");
        text(svg, (axes.x(z), TOP + SIZE + 17.0), "text-anchor=\"middle\"", &tick.to_string());
        text(svg, (LEFT - 8.0, axes.y(z) + 4.0), "text-anchor=\"end\"", &tick.to_string());
    }
    let chance = (axes.x(-axes.reach), axes.y(-axes.reach));
    line(svg, chance, (axes.x(axes.reach), axes.y(axes.reach)), "#999", "stroke-dasharray=\"4 4\"");
    text(svg, (LEFT + SIZE / 2.0, TOP + SIZE + 36.0), "text-anchor=\"middle\"", "z(real images called synthetic)");
    let middle = TOP + SIZE / 2.0;
    let turned = format!("text-anchor=\"middle\" transform=\"rotate(-90 18 {middle})\"");
    text(svg, (18.0, middle), &turned, "z(synthetic images called synthetic)");
}

fn legend(svg: &mut String, summary: &Summary) {
    let d = &summary.d_prime;
    let mut words = format!("d′ {:.2} [{:.2}, {:.2}]", d.value, d.low, d.high);
    if let (Some(d_a), Some(slope)) = (&summary.d_a, &summary.slope) {
        let _ = write!(words, "   d_a {:.2} [{:.2}, {:.2}]", d_a.value, d_a.low, d_a.high);
        let _ = write!(words, "   slope {:.2} [{:.2}, {:.2}]", slope.value, slope.low, slope.high);
    }
    text(svg, (LEFT, 28.0), "font-weight=\"bold\" xml:space=\"preserve\"", &words);
    let below = HEIGHT - 12.0;
    let _ = writeln!(svg, "<circle cx=\"{}\" cy=\"{}\" r=\"5\" fill=\"{INK}\"/>", LEFT + 6.0, below - 4.0);
    text(svg, (LEFT + 17.0, below), "", "all ratings, by criterion");
    let _ =
        writeln!(svg, "<circle cx=\"{}\" cy=\"{}\" r=\"4\" fill=\"none\" stroke=\"#666\"/>", LEFT + 196.0, below - 4.0);
    text(svg, (LEFT + 207.0, below), "", "one observer");
    line(svg, (LEFT + 310.0, below - 4.0), (LEFT + 334.0, below - 4.0), "#999", "stroke-dasharray=\"4 4\"");
    text(svg, (LEFT + 340.0, below), "", "chance");
}
