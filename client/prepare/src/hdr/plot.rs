//! A response curve as a picture.

use super::response::{LEVELS, Response};
use std::fmt::Write;

const SIZE: [f64; 2] = [560.0, 420.0];
const MARGIN: f64 = 56.0;

/// The three curves as an SVG file: code 0..255 over exposure in stops, relative to code 128.
pub fn plot(response: &Response) -> String {
    let stops = |g: f64| g / std::f64::consts::LN_2;
    // The last codes at either end are hardly ever seen, and swing far.
    let shown = 3..LEVELS - 2;
    let ends = |table: &Vec<f64>| (stops(table[shown.start]).floor(), stops(table[shown.end - 1]).ceil());
    let (least, most) = response
        .log_exposure
        .iter()
        .map(ends)
        .fold((-1.0_f64, 1.0_f64), |(least, most), (low, high)| (least.min(low), most.max(high)));
    let (least, most) = (least.max(-16.0), most.min(16.0));
    let x = |stop: f64| MARGIN + (stop - least) / (most - least) * (SIZE[0] - 1.5 * MARGIN);
    let y = |code: f64| SIZE[1] - MARGIN - code / 255.0 * (SIZE[1] - 1.5 * MARGIN);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" \
         font-family=\"sans-serif\" font-size=\"12\"><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        SIZE[0], SIZE[1]
    );
    // Writing to a string cannot fail.
    for stop in least as i32..=most as i32 {
        let (at, top, bottom) = (x(f64::from(stop)), y(255.0), y(0.0));
        let _ = write!(svg, "<path d=\"M{at:.1} {top:.1}V{bottom:.1}\" stroke=\"#ddd\"/>");
        let _ = writeln!(svg, "<text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{stop}</text>", bottom + 16.0);
    }
    for code in [0, 64, 128, 192, 255] {
        let (at, left, right) = (y(f64::from(code)), x(least), x(most));
        let _ = write!(svg, "<path d=\"M{left:.1} {at:.1}H{right:.1}\" stroke=\"#ddd\"/>");
        let _ = writeln!(svg, "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{code}</text>", left - 6.0, at + 4.0);
    }
    for (table, colour) in response.log_exposure.iter().zip(["#c22", "#2a2", "#22c"]) {
        let _ = write!(svg, "<polyline fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\" points=\"");
        for code in shown.clone() {
            let _ = write!(svg, "{:.1},{:.1} ", x(stops(table[code]).clamp(least, most)), y(code as f64));
        }
        svg.push_str("\"/>\n");
    }
    let _ = writeln!(
        svg,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">exposure / stops from code 128</text>\
         <text x=\"16\" y=\"{:.1}\" transform=\"rotate(-90 16 {:.1})\" text-anchor=\"middle\">code</text></svg>",
        x(0.5 * (least + most)),
        SIZE[1] - 14.0,
        y(127.5),
        y(127.5)
    );
    svg
}
