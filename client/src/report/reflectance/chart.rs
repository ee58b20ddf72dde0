//! The two charts of one angle of incidence, as inline SVG.

use super::super::html::{escape, significant};
use super::ReflectancePanel;
use super::bins::{Bin, Group};

const WIDTH: f64 = 460.0;
const HEIGHT: f64 = 190.0;
const LEFT: f64 = 48.0;
const RIGHT: f64 = 8.0;
const BOTTOM: f64 = 36.0;
const TOP: f64 = 8.0;

/// The plane of a chart.
struct Axes {
    /// Largest half angle, degrees.
    widest: f64,
    low: f64,
    high: f64,
}

impl Axes {
    fn x(&self, half: f64) -> f64 {
        LEFT + half / self.widest * (WIDTH - LEFT - RIGHT)
    }

    fn y(&self, value: f64) -> f64 {
        TOP + (self.high - value) / (self.high - self.low).max(1e-12) * (HEIGHT - TOP - BOTTOM)
    }

    /// Labels of half angles, and lines with labels at `ticks`: place, text.
    fn frame(&self, ticks: &[(f64, String)]) -> String {
        let (bottom, right) = (HEIGHT - BOTTOM, WIDTH - RIGHT);
        let mut svg = String::new();
        for (place, label) in ticks {
            let y = self.y(*place);
            svg += &format!(
                "<path class=\"axis\" d=\"M{LEFT} {y:.1}H{right}\"/><text x=\"{:.0}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
                LEFT - 6.0,
                y + 4.0
            );
        }
        let mut half = 0.0;
        while half <= self.widest {
            let x = self.x(half);
            svg += &format!("<text x=\"{x:.1}\" y=\"{:.0}\" text-anchor=\"middle\">{half:.0}°</text>", bottom + 16.0);
            half += 15.0;
        }
        svg + &format!("<text x=\"{right}\" y=\"{:.0}\" text-anchor=\"end\">half angle</text>", bottom + 31.0)
    }

    fn line(&self, bins: &[Bin], value: fn(&Bin) -> f64, class: &str) -> String {
        let points = bins.iter().map(|b| format!("{:.1} {:.1}", self.x(b.half), self.y(value(b))));
        format!("<path class=\"curve {class}\" d=\"M{}\"/>", points.collect::<Vec<_>>().join("L"))
    }
}

/// Values and residuals of one angle of incidence; `base` is the same under a model before.
pub(super) fn charts(panel: &ReflectancePanel, group: &Group, base: Option<&Group>) -> String {
    let [from, to] = group.incidence.map(f64::round);
    let at = if from == to { format!("{from:.0}°") } else { format!("{from:.0}° to {to:.0}°") };
    let name = escape(&panel.name);
    let figure = |what: &str, body: &str| {
        format!(
            "<figure><svg class=\"chart\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"File {name}: {what} against half angle, incidence {at}\">{body}</svg>\
             <figcaption>{what}, incidence {at}</figcaption></figure>\n"
        )
    };
    figure("BRDF (1/sr)", &values(panel.scale, group, base)) + &figure("Residual (\u{3c3})", &residuals(group, base))
}

/// The model's curves, an old one under a new one.
fn curves(axes: &Axes, group: &Group, base: Option<&Group>, value: fn(&Bin) -> f64) -> String {
    let old = base.map_or_else(String::new, |b| axes.line(&b.bins, value, "old"));
    old + &axes.line(&group.bins, value, "new")
}

fn widest(group: &Group) -> f64 {
    group.bins.last().map_or(1.0, |b| b.half).max(1.0)
}

fn values(scale: Option<f64>, group: &Group, base: Option<&Group>) -> String {
    let models = || group.bins.iter().chain(base.iter().flat_map(|b| &b.bins));
    let all = || models().flat_map(|b| [b.measured[1], b.measured[2], b.model]).filter(|v| v.is_finite());
    let (low, high) = (all().fold(f64::INFINITY, f64::min).min(0.0), all().fold(0.1, f64::max));
    let axes = Axes { widest: widest(group), low, high: high + 0.03 * (high - low) };
    let ticks: Vec<(f64, String)> = match scale {
        // Decades from the scale on: below it, the axis is linear.
        Some(scale) => {
            let decades = (-9..=9).map(|k| 10_f64.powi(k)).filter(|v| *v >= scale);
            let places = decades.map(|v| (libm::asinh(v / scale), significant(v, 1)));
            std::iter::once((0.0, "0".to_owned())).chain(places.filter(|(u, _)| *u <= axes.high)).collect()
        }
        None => [0.0, 0.5, 1.0].map(|part| (part * high, significant(part * high, 2))).into(),
    };
    let measured: String = group
        .bins
        .iter()
        .map(|b| {
            let (x, [mean, low, high]) = (axes.x(b.half), b.measured.map(|v| axes.y(v)));
            format!("<path class=\"axis\" d=\"M{x:.1} {low:.1}V{high:.1}\"/><circle class=\"measured\" cx=\"{x:.1}\" cy=\"{mean:.1}\" r=\"2.2\"/>")
        })
        .collect();
    axes.frame(&ticks) + &measured + &curves(&axes, group, base, |b| b.model)
}

fn residuals(group: &Group, base: Option<&Group>) -> String {
    let all = group.bins.iter().chain(base.iter().flat_map(|b| &b.bins));
    let reach = all.map(|b| b.residual.abs()).filter(|r| r.is_finite()).fold(2.0, f64::max);
    let axes = Axes { widest: widest(group), low: -1.05 * reach, high: 1.05 * reach };
    let ticks = [-reach, 0.0, reach].map(|r| (r, significant(r, 2)));
    axes.frame(&ticks) + &curves(&axes, group, base, |b| b.residual)
}
