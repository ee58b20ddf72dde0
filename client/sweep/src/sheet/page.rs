//! The contact sheet as a page: every frame under its values, with links to its files.

use super::Sheet;
use crate::digest::FrameDigest;
use crate::record::Record;
use std::fmt::Write;

const STYLE: &str = "body{background:#202020;color:#ddd;font:13px/1.4 system-ui,sans-serif;margin:1.5em}h1{font-size:1.3em}\
p{max-width:60em;color:#aaa}main{display:flex;flex-wrap:wrap;gap:12px}figure{margin:0;max-width:14em}\
i{display:block;background-repeat:no-repeat}figcaption{font-size:11px;color:#bbb;overflow-wrap:anywhere}a{color:#8cf}";

/// Values of a point that a caption shows; the table has all.
const SHOWN: usize = 6;

/// The page's text.
pub(super) fn write(
    sheet: &Sheet<'_>,
    title: &str,
    picture: &str,
    digests: &[FrameDigest],
    records: &[&Record],
) -> String {
    let (plan, (width, _)) = (sheet.plan, sheet.size());
    // Small frames are shown larger.
    let zoom = (96 / sheet.cell.0.max(sheet.cell.1)).clamp(1, 3);
    let title = escaped(title);
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{title}</title><style>{STYLE}\
         i{{background-image:url(\"{picture}\");background-size:{}px;image-rendering:pixelated}}</style></head>\n<body>\
         <h1>{title}</h1>\n<p>{} of {} frames, {} samples a pixel, all equally bright. \
         <a href=\"table.csv\">Table</a></p>\n<main>\n",
        zoom * width,
        sheet.shown.len(),
        plan.frames.len(),
        plan.samples,
    );
    for (i, &frame) in sheet.shown.iter().enumerate() {
        let (Some(at), Some(digest), Some(record)) = (plan.frames.get(frame), digests.get(frame), records.get(frame))
        else {
            continue;
        };
        let (x, y) = sheet.place(i);
        let (w, h) = (record.thumbnail.width, record.thumbnail.height);
        let links: Vec<String> = plan
            .outputs
            .iter()
            .map(|output| format!("<a href=\"{}\">{}</a>", digest.path(output.ending()), output.word()))
            .collect();
        let view = escaped(plan.capture.photos.get(at.photo).map_or("", |photo| photo.name()));
        let mut caption = format!("{frame}: {view} {}", links.join(" "));
        for (name, value) in values(&plan.names, &plan.points[at.point]).into_iter().take(SHOWN) {
            // Writing to a string does not fail.
            let _ = write!(caption, "<br>{} {}", escaped(short(name)), digits(value));
        }
        let _ = writeln!(
            page,
            "<figure><i style=\"width:{}px;height:{}px;background-position:-{}px -{}px\"></i>\
             <figcaption>{caption}</figcaption></figure>",
            zoom * w,
            zoom * h,
            zoom * x,
            zoom * y
        );
    }
    page + "</main></body></html>\n"
}

/// Names and values of a point; channels that have the same value appear once, as their colour.
fn values<'n>(names: &'n [String], point: &[f64]) -> Vec<(&'n str, f64)> {
    let colour = |name: &'n String| name.rsplit_once('.').map_or(name.as_str(), |(colour, _)| colour);
    let mut values = Vec::new();
    let mut i = 0;
    while let (Some(name), Some(value)) = (names.get(i), point.get(i)) {
        let alike = |k: usize| {
            names.get(k).map(colour) == Some(colour(name)) && point.get(k).map(|v| v.to_bits()) == Some(value.to_bits())
        };
        let gray = name.ends_with(".r") && alike(i + 1) && alike(i + 2);
        values.push((if gray { colour(name) } else { name.as_str() }, *value));
        i += if gray { 3 } else { 1 };
    }
    values
}

/// A dotted name without its first part, which says only of what kind it is.
fn short(name: &str) -> &str {
    name.split_once('.').map_or(name, |(_, rest)| rest)
}

/// A value with four digits.
fn digits(x: f64) -> String {
    if x == 0.0 || (1e-3..1e5).contains(&x.abs()) {
        let text = format!("{x:.4}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        format!("{x:.3e}")
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gray_colours_are_one_value() {
        let names = ["light.led.intensity.r", "light.led.intensity.g", "light.led.intensity.b", "material.a.ior"];
        let names = names.map(str::to_owned);
        let gray = values(&names, &[0.2, 0.2, 0.2, 1.5]);
        assert_eq!(gray, [("light.led.intensity", 0.2), ("material.a.ior", 1.5)]);
        assert_eq!(values(&names, &[0.2, 0.2, 0.3, 1.5]).len(), 4);
        assert_eq!(values(&names[..1], &[0.2]), [("light.led.intensity.r", 0.2)]);
    }

    #[test]
    fn captions_are_short() {
        assert_eq!(["0.5", "0.1235", "1e6"].map(|x| digits(x.parse().unwrap())), ["0.5", "0.1235", "1.000e6"]);
        assert_eq!(digits(0.0), "0");
        assert_eq!(short("material.shell.roughness"), "shell.roughness");
        assert_eq!(escaped("<a&\"b\">"), "&lt;a&amp;&quot;b&quot;&gt;");
    }
}
