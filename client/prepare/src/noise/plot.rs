//! Variance over mean as a picture.

use super::{Line, Noise};
use std::fmt::Write;

const SIZE: [f64; 2] = [640.0, 440.0];
const MARGIN: f64 = 64.0;
/// Most points of a channel that are drawn.
const POINTS: usize = 600;

/// The points and lines of the three channels as an SVG file, in light.
#[must_use]
pub fn plot(noise: &Noise) -> String {
    let chosen = |line: &Line, x: f64| line.variance(x);
    let brightest = |c: usize| noise.channels[c].levels.iter().map(|level| level.mean).fold(0.0, f64::max);
    let most = [0, 1, 2].map(brightest).into_iter().fold(1e-9, f64::max);
    let high = noise.channels.iter().map(|channel| chosen(&channel.light, most)).fold(1e-12, f64::max) * 1.4;
    let x = |mean: f64| MARGIN + mean / most * (SIZE[0] - 1.5 * MARGIN);
    let y = |variance: f64| SIZE[1] - MARGIN - (variance / high).clamp(0.0, 1.0) * (SIZE[1] - 1.5 * MARGIN);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" \
         font-family=\"sans-serif\" font-size=\"12\"><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        SIZE[0], SIZE[1]
    );
    // Writing to a string cannot fail.
    for k in 0..=4 {
        let part = f64::from(k) / 4.0;
        let (across, up) = (x(part * most), y(part * high));
        let _ = write!(svg, "<path d=\"M{across:.1} {:.1}V{:.1}\" stroke=\"#ddd\"/>", y(high), y(0.0));
        let _ = write!(svg, "<path d=\"M{:.1} {up:.1}H{:.1}\" stroke=\"#ddd\"/>", x(0.0), x(most));
        let (low, label) = (y(0.0) + 16.0, part * most);
        let _ = writeln!(svg, "<text x=\"{across:.1}\" y=\"{low:.1}\" text-anchor=\"middle\">{label:.3}</text>");
        let (left, label) = (x(0.0) - 6.0, part * high);
        let _ = writeln!(svg, "<text x=\"{left:.1}\" y=\"{:.1}\" text-anchor=\"end\">{label:.1e}</text>", up + 4.0);
    }
    for (channel, colour) in noise.channels.iter().zip(["#c22", "#2a2", "#22c"]) {
        let every = channel.levels.len().div_ceil(POINTS).max(1);
        for level in channel.levels.iter().step_by(every) {
            let variance = if noise.shared { level.shared } else { level.variance };
            let (cx, cy) = (x(level.mean), y(variance));
            let _ =
                write!(svg, "<circle cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"2\" fill=\"{colour}\" fill-opacity=\"0.4\"/>");
        }
        let (from, to) = (y(channel.light.variance(0.0)), y(channel.light.variance(most)));
        let _ = writeln!(svg, "<path d=\"M{:.1} {from:.1}L{:.1} {to:.1}\" stroke=\"{colour}\"/>", x(0.0), x(most));
    }
    let middle = y(0.5 * high);
    let _ = writeln!(
        svg,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">mean, in light</text>\
         <text x=\"14\" y=\"{middle:.1}\" transform=\"rotate(-90 14 {middle:.1})\" text-anchor=\"middle\">variance{}</text></svg>",
        x(0.5 * most),
        SIZE[1] - 18.0,
        if noise.shared { ", with what neighbours share" } else { "" }
    );
    svg
}
