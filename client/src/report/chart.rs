//! The loss curve as an inline SVG.

use super::html::significant;
use gonio_fit::LossPoint;

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 300.0;
const LEFT: f64 = 84.0;
const RIGHT: f64 = 20.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 66.0;
/// Above this ratio of largest to smallest loss, the axis is logarithmic.
const WIDE: f64 = 10.0;
/// Narrowest gap between two labels on the horizontal axis.
const GAP: f64 = 34.0;

/// The plane of the chart.
struct Axes {
    last: f64,
    low: f64,
    high: f64,
    logarithmic: bool,
}

impl Axes {
    fn new(curve: &[LossPoint]) -> Self {
        // 1 is what a right model reaches: always in view.
        let upper = curve.iter().map(|p| p.loss + p.standard_error).fold(1.0, f64::max);
        let least = curve.iter().map(|p| p.loss).fold(1.0, f64::min);
        let lower = curve.iter().map(|p| p.loss - p.standard_error).fold(1.0, f64::min);
        let last = curve.last().map_or(1.0, |p| f64::from(p.iteration));
        let logarithmic = least > 0.0 && upper / least > WIDE;
        if logarithmic {
            let low = lower.max(0.8 * least);
            Self { last, low: 0.9 * low, high: 1.15 * upper, logarithmic }
        } else {
            let margin = 0.08 * (upper - lower).max(0.02);
            Self { last, low: lower - margin, high: upper + margin, logarithmic }
        }
    }

    fn x(&self, iteration: f64) -> f64 {
        let span = (self.last - 1.0).max(1.0);
        LEFT + (iteration - 1.0) / span * (WIDTH - LEFT - RIGHT)
    }

    fn y(&self, loss: f64) -> f64 {
        let scale = |v: f64| if self.logarithmic { v.max(self.low).log10() } else { v };
        let share = (scale(loss) - scale(self.low)) / (scale(self.high) - scale(self.low));
        HEIGHT - BOTTOM - share.clamp(0.0, 1.0) * (HEIGHT - TOP - BOTTOM)
    }

    /// Losses to label: decades with 2 and 5 between where they are few, or round steps.
    fn ticks(&self) -> Vec<f64> {
        let (low, high) = (self.low, self.high);
        if !self.logarithmic {
            let step = round_step((high - low) / 5.0);
            let first = (low / step).ceil();
            return (0..12).map(|i| (first + f64::from(i)) * step).filter(|v| *v <= high).collect();
        }
        let decades = (high / low).log10();
        let factors: &[f64] = if decades < 3.0 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let skip = (decades / 7.0).ceil().max(1.0);
        let first = (low.log10() / skip).floor();
        let all = (0..12).flat_map(|i| factors.iter().map(move |f| f * power_of_ten((first + f64::from(i)) * skip)));
        all.filter(|v| (low..=high).contains(v)).collect()
    }
}

/// The section; empty where no iteration was made.
pub(super) fn section(curve: &[LossPoint]) -> String {
    let finite: Vec<LossPoint> =
        curve.iter().filter(|p| p.loss.is_finite() && p.standard_error.is_finite()).copied().collect();
    let (Some(first), Some(last)) = (finite.first(), finite.last()) else { return String::new() };
    let axes = Axes::new(&finite);
    let kind = if axes.logarithmic { ", logarithmic" } else { "" };
    format!(
        "<section>\n<h2>Loss</h2>\n<p>Reduced chi-square (weighted squared error over what the photos' noise alone would make) after each iteration{kind}; the band \
         is the standard error by the render's noise, the dashed line what a right model reaches.</p>\n\
         <svg class=\"chart\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"Loss over {} iterations, from {} to {}\">\n\
         {}{}{}</svg>\n</section>\n",
        last.iteration,
        significant(first.loss, 3),
        significant(last.loss, 4),
        frame(&axes),
        samples(&axes, &finite),
        curves(&axes, &finite)
    )
}

fn frame(axes: &Axes) -> String {
    let (bottom, right) = (HEIGHT - BOTTOM, WIDTH - RIGHT);
    let mut svg = String::new();
    for tick in axes.ticks() {
        let y = axes.y(tick);
        let label = label(tick);
        svg += &format!("<path class=\"axis\" d=\"M{LEFT} {y:.1}H{right}\"/>");
        svg += &format!("<text x=\"{:.0}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>\n", LEFT - 8.0, y + 4.0);
    }
    let step = round_step(axes.last / 15.0).max(1.0);
    let mut iteration = if step > 1.0 { step } else { 1.0 };
    while iteration <= axes.last {
        let x = axes.x(iteration);
        svg += &format!("<text x=\"{x:.1}\" y=\"{:.0}\" text-anchor=\"middle\">{iteration:.0}</text>\n", bottom + 18.0);
        iteration += step;
    }
    let one = axes.y(1.0);
    svg += &format!("<path class=\"right\" d=\"M{LEFT} {one:.1}H{right}\"/>\n");
    svg += &format!("<text x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"end\">iteration</text>\n", LEFT - 20.0, bottom + 18.0);
    svg
}

/// The samples per pixel, at every iteration that changes them.
fn samples(axes: &Axes, curve: &[LossPoint]) -> String {
    let y = HEIGHT - BOTTOM + 42.0;
    let mut svg = format!("<text x=\"{:.0}\" y=\"{y:.0}\" text-anchor=\"end\">samples</text>\n", LEFT - 20.0);
    svg += &format!("<text x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"end\">per pixel</text>\n", LEFT - 20.0, y + 14.0);
    let (mut shown, mut free) = (0, f64::MIN);
    for point in curve {
        let x = axes.x(f64::from(point.iteration));
        if point.samples != shown && x >= free {
            svg += &format!("<text x=\"{x:.1}\" y=\"{y:.0}\" text-anchor=\"middle\">{}</text>\n", point.samples);
            (shown, free) = (point.samples, x + GAP);
        }
    }
    svg
}

fn curves(axes: &Axes, curve: &[LossPoint]) -> String {
    let at = |p: &LossPoint, loss: f64| format!("{:.1},{:.1}", axes.x(f64::from(p.iteration)), axes.y(loss));
    let upper = curve.iter().map(|p| at(p, p.loss + p.standard_error));
    let lower = curve.iter().rev().map(|p| at(p, p.loss - p.standard_error));
    let band: Vec<String> = upper.chain(lower).collect();
    let line: Vec<String> = curve.iter().map(|p| at(p, p.loss)).collect();
    let mut svg = format!("<polygon class=\"band\" points=\"{}\"/>\n", band.join(" "));
    svg += &format!("<polyline class=\"curve\" points=\"{}\"/>\n", line.join(" "));
    if curve.len() <= 80 {
        for p in curve {
            let (x, y) = (axes.x(f64::from(p.iteration)), axes.y(p.loss));
            svg += &format!(
                "<circle class=\"point\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.5\"><title>iteration {}: {} ± {}, {} samples per pixel</title></circle>\n",
                p.iteration,
                significant(p.loss, 5),
                significant(p.standard_error, 2),
                p.samples
            );
        }
    }
    svg
}

/// A round number without zeros at its end.
fn label(tick: f64) -> String {
    let text = significant((tick * 1e6).round() / 1e6, 4);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

fn power_of_ten(exponent: f64) -> f64 {
    #[allow(clippy::cast_possible_truncation)]
    let exponent = exponent as i32;
    10f64.powi(exponent)
}

/// The next of 1, 2, 5 times a power of ten.
fn round_step(x: f64) -> f64 {
    let power = power_of_ten(x.max(1e-300).log10().floor());
    [1.0, 2.0, 5.0].iter().map(|f| f * power).find(|step| *step >= x * (1.0 - 1e-9)).unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(losses: &[f64]) -> Vec<LossPoint> {
        (1..)
            .zip(losses)
            .map(|(iteration, &loss)| LossPoint { iteration, samples: 4 * iteration, loss, standard_error: 0.01 })
            .collect()
    }

    #[test]
    fn the_axis_is_logarithmic_where_the_loss_falls_far() {
        assert!(!Axes::new(&curve(&[5.0, 1.1])).logarithmic);
        let axes = Axes::new(&curve(&[5000.0, 30.0, 1.1]));
        assert!(axes.logarithmic);
        // The same factor is the same distance.
        let (a, b, c) = (axes.y(2.0), axes.y(20.0), axes.y(200.0));
        assert!((a - b - (b - c)).abs() < 1e-9 && a > b);
        assert!((3..=12).contains(&axes.ticks().len()), "{:?}", axes.ticks());
    }

    #[test]
    fn odd_curves_make_a_chart_or_none() {
        assert_eq!(section(&[]), "");
        assert_eq!(section(&curve(&[f64::NAN])), "");
        for losses in [vec![1.0], vec![0.0, 0.0], vec![-1.0, 2.0], vec![1e300, 1.0], vec![1.0; 2000]] {
            let svg = section(&curve(&losses));
            assert!(svg.contains("<svg") && !svg.contains("NaN") && !svg.contains("inf"), "{losses:?}");
        }
    }

    #[test]
    fn labels_are_short() {
        assert_eq!(
            (label(1.0), label(0.1 + 0.2), label(1000.0)),
            ("1".to_owned(), "0.3".to_owned(), "1000".to_owned())
        );
    }

    #[test]
    fn steps_are_round() {
        for (x, step) in [(0.13, 0.2), (1.0, 1.0), (2.2, 5.0), (70.0, 100.0)] {
            assert!((round_step(x) - step).abs() < 1e-12, "{x}");
        }
    }
}
