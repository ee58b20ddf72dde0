//! The summary for people.

use super::{Number, Summary};
use crate::progress::plural;
use std::fmt::Write;

/// The summary in short tables; empty of what is not there.
pub(super) fn text(summary: &Summary) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write(summary, &mut out);
    out
}

fn write(summary: &Summary, out: &mut String) -> std::fmt::Result {
    if !summary.capture.is_empty() {
        writeln!(out, "capture {}", summary.capture)?;
    }
    for p in &summary.photos {
        let [r, g, b] = p.mean;
        writeln!(
            out,
            "photo   {:12} {:8} {}x{}  {} count, {} clipped, mean {r:.4} {g:.4} {b:.4}",
            p.name, p.role, p.width, p.height, p.counted, p.clipped
        )?;
    }
    for m in &summary.reflectance {
        let [r, g, b] = m.mean;
        writeln!(
            out,
            "samples {:12} {:8} {} of {}, mean {r:.4} {g:.4} {b:.4} per steradian",
            m.name, m.role, m.samples, m.material
        )?;
    }
    for o in &summary.objects {
        let [x, y, z] = o.extent.map(length);
        let shading = if o.normals { "vertex normals" } else { "face normals" };
        writeln!(
            out,
            "object  {:12} {} triangles, {shading}, {x} x {y} x {z}, {}, in view of {}",
            o.name,
            o.triangles,
            o.material,
            plural(o.photos, "photo")
        )?;
    }
    for l in &summary.lights {
        writeln!(
            out,
            "light   {:12} {} in the {} frame, on in {}",
            l.name,
            l.kind,
            l.frame,
            plural(l.photos, "photo")
        )?;
    }
    for n in &summary.parameters {
        writeln!(out, "free    {}", number(n))?;
    }
    for n in summary.numbers.iter().flatten() {
        writeln!(out, "number  {}", number(n))?;
    }
    for warning in &summary.warnings {
        writeln!(out, "warning: {warning}")?;
    }
    if summary.valid {
        writeln!(out, "valid, with {}", plural(summary.warnings.len(), "warning"))?;
    }
    Ok(())
}

fn number(n: &Number) -> String {
    let bounds = match (n.min, n.max) {
        (Some(min), Some(max)) => format!("  in {min}..={max}"),
        (Some(min), None) => format!("  at least {min}"),
        (None, Some(max)) => format!("  at most {max}"),
        (None, None) => String::new(),
    };
    format!("{} = {}{bounds}", n.name, n.value)
}

/// A length in a unit that suits it.
fn length(metres: f64) -> String {
    match metres {
        x if x >= 1.0 => format!("{x:.2} m"),
        x if x >= 1e-3 => format!("{:.1} mm", x * 1e3),
        x => format!("{:.2} um", x * 1e6),
    }
}
