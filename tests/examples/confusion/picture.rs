//! The matrix as a picture.

use crate::glyphs;
use crate::outcome::{SWEPT, named};
use gonio_diagnose::effects::CATALOGUE;
use gonio_tests::hidden::STRENGTHS;
use image::{Rgb, RgbImage};
use serde_json::Value;
use std::path::Path;

const CELL: u32 = 20;
const BORDER: u32 = 26;

pub fn write(outcomes: &[Value], path: &Path) {
    let count = CATALOGUE.len() as u32;
    let index = |name: &str| CATALOGUE.iter().position(|e| e.name == name).map(|i| i as u32);
    let mut image =
        RgbImage::from_pixel(BORDER + (count + 2) * CELL + 1, BORDER + (count + 1) * CELL + 1, Rgb([255; 3]));
    for i in 0..=count + 2 {
        let at = BORDER + i * CELL;
        if i <= count + 1 {
            (BORDER..image.width()).for_each(|x| image.put_pixel(x, at, Rgb([205; 3])));
        }
        (BORDER..image.height()).for_each(|y| image.put_pixel(at, y, Rgb([205; 3])));
        if i < count {
            let number = format!("{:2}", i + 1);
            glyphs::write(&mut image, &number, at + 4, 8);
            glyphs::write(&mut image, &number, 8, at + 5);
        }
    }
    // Outcomes per cell, and how many of a row's halves there are in all.
    let width = (count + 2) as usize;
    let mut shares = vec![[0.0f64; 2]; width * (count + 1) as usize];
    let mut totals = vec![[0.0f64; 2]; (count + 1) as usize];
    for o in outcomes.iter().filter(|o| o["strength"] != SWEPT) {
        let row = index(o["effect"].as_str().unwrap_or_default()).unwrap_or(count) as usize;
        let halves = match STRENGTHS.iter().position(|(label, _)| o["strength"] == *label) {
            Some(half) => half..half + 1,
            None => 0..2,
        };
        let sets = named(o);
        for half in halves {
            totals[row][half] += 1.0;
            let none = if o["verdict"] == "none" { count + 1 } else { count };
            match sets.first() {
                None => shares[row * width + none as usize][half] += 1.0,
                Some(set) => {
                    for (rank, name) in set.iter().enumerate() {
                        let column = index(name).unwrap_or(count) as usize;
                        shares[row * width + column][half] += if rank == 0 { 1.0 } else { 0.4 };
                    }
                }
            }
        }
    }
    for (i, share) in shares.iter().enumerate() {
        let (row, column) = (i / width, i % width);
        for half in 0..2 {
            let part = share[half] / totals[row][half].max(1.0);
            if part == 0.0 {
                continue;
            }
            // Green where the name is right, red where it is wrong, gray where there is none.
            let silent = column >= count as usize;
            let right = if row == count as usize { column == width - 1 } else { row == column };
            let full = if right {
                [20, 120, 50]
            } else if silent {
                [110, 110, 110]
            } else {
                [190, 30, 30]
            };
            let colour = full.map(|c: u8| (255.0 + part.min(1.0) * (f64::from(c) - 255.0)) as u8);
            let left = BORDER + column as u32 * CELL + 1 + half as u32 * (CELL / 2);
            for y in 0..CELL - 1 {
                for x in 0..CELL / 2 - 1 {
                    image.put_pixel(left + x, BORDER + row as u32 * CELL + 1 + y, Rgb(colour));
                }
            }
        }
    }
    image.save(path).unwrap();
}
