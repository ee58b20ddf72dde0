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
        for (name, value) in plan.names.iter().zip(&plan.points[at.point]).take(SHOWN) {
            // Writing to a string does not fail.
            let _ = write!(caption, "<br>{} {}", escaped(short(name)), digits(*value));
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

/// The last three parts of a dotted name: the first says only of what kind it is.
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
