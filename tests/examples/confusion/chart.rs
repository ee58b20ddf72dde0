//! Strengths tried, found and missed, and where half is found, as a picture: a row for each effect.

use crate::glyphs::{self, ADVANCE};
use crate::staircase::LEAST;
use crate::strengths::trials;
use crate::threshold::{Threshold, threshold};
use gonio_diagnose::effects::CATALOGUE;
use image::{Rgb, RgbImage};
use serde_json::Value;
use std::path::Path;

const ROW: u32 = 26;
/// Room for the effects' names, and beside, above and below the rows.
const NAMES: u32 = 20 * ADVANCE + 8;
const BORDER: u32 = 26;
/// Pixels per doubling of the strength.
const OCTAVE: u32 = 64;
/// Strengths that have a line, as their logarithms to base 2.
const LINES: std::ops::RangeInclusive<i32> = -6..=2;
const GREEN: [u8; 3] = [20, 120, 50];
const RED: [u8; 3] = [190, 30, 30];
const GRAY: [u8; 3] = [190, 196, 214];
const DARK: [u8; 3] = [60, 70, 120];

pub fn write(outcomes: &[Value], path: &Path) {
    let swept: Vec<_> = CATALOGUE
        .iter()
        .enumerate()
        .filter_map(|(number, effect)| {
            let all = trials(outcomes, effect.name).concat();
            Some((number + 1, effect.name, threshold(&all)?, all))
        })
        .collect();
    let (left, right) = (NAMES + BORDER, NAMES + BORDER + OCTAVE * LINES.count() as u32 - OCTAVE);
    let bottom = BORDER + ROW * swept.len() as u32;
    let mut image = RgbImage::from_pixel(right + BORDER, bottom + BORDER, Rgb([255; 3]));
    for (place, power) in LINES.enumerate() {
        let x = left + OCTAVE * place as u32;
        fill(&mut image, [x, x + 1], [BORDER, bottom], [205; 3]);
        let label = if power < 0 { format!("1/{}", 1 << -power) } else { format!("{}", 1 << power) };
        for y in [8, bottom + 8] {
            glyphs::write(&mut image, &label, x - label.len() as u32 * ADVANCE / 2 + 1, y);
        }
    }
    let across = |strength: f64| {
        let octaves = libm::log2(strength / LEAST) * f64::from(OCTAVE);
        (f64::from(left) + octaves).clamp(f64::from(left) - 8.0, f64::from(right) + 8.0) as u32
    };
    for (row, (number, name, threshold, all)) in swept.iter().enumerate() {
        let top = BORDER + ROW * row as u32;
        let middle = top + ROW / 2;
        fill(&mut image, [8, right + 8], [top, top + 1], [235; 3]);
        glyphs::write(&mut image, &format!("{number:2} {name}"), 4, middle - glyphs::HEIGHT / 2);
        let (low, half, high) = match *threshold {
            Threshold::Below(at) => (0.0, None, at),
            Threshold::Above(at) => (at, None, f64::INFINITY),
            Threshold::At { half, low, high } => (low, Some(half), high),
        };
        fill(&mut image, [across(low.max(1e-9)), across(high.min(1e9)) + 1], [middle - 3, middle + 4], GRAY);
        if let Some(half) = half {
            fill(&mut image, [across(half) - 1, across(half) + 2], [top + 3, top + ROW - 2], DARK);
        }
        for (i, trial) in all.iter().enumerate() {
            // Finds above, misses below, and what is at the same place side by side.
            let before =
                all[..i].iter().filter(|t| t.found == trial.found && across(t.strength) == across(trial.strength));
            let x = (across(trial.strength) + 4 * before.count() as u32).min(right + BORDER - 6);
            let (y, colour, inner) = if trial.found { (middle - 5, GREEN, -1.0) } else { (middle + 6, RED, 2.4) };
            ring(&mut image, x, y, colour, inner);
        }
    }
    image.save(path).unwrap();
}

fn fill(image: &mut RgbImage, [left, right]: [u32; 2], [top, bottom]: [u32; 2], colour: [u8; 3]) {
    for y in top..bottom {
        for x in left..right {
            image.put_pixel(x, y, Rgb(colour));
        }
    }
}

/// A ring of radius 4 about a pixel; a dot where the inner radius is negative.
fn ring(image: &mut RgbImage, x: u32, y: u32, colour: [u8; 3], inner: f64) {
    for dy in -4..=4 {
        for dx in -4..=4 {
            let radius = f64::from(dx).hypot(f64::from(dy));
            if radius > inner && radius <= 4.3 {
                image.put_pixel(x.saturating_add_signed(dx), y.saturating_add_signed(dy), Rgb(colour));
            }
        }
    }
}
