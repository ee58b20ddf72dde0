//! Where and how turned a part may be: all templates at all places of the image, at all sizes.

use crate::candidate::{Candidate, distinct};
use crate::part::Part;
use crate::picture::Picture;
use crate::response::{MOST, Responses, STEP};
use crate::template::{SIZE, Template};
use crate::views::{over_sphere, roll, towards};
use glam::DMat3;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Directions over the sphere: neighbours are some 15 degrees apart.
const VIEWS: u32 = 180;

/// Turns about the line of sight.
const ROLLS: u32 = 24;

/// Ratio of neighbouring sizes.
const RATIO: f64 = 1.12;

/// Places that one template is kept at, for each size.
const PLACES: usize = 2;

/// Least part of the largest score.
const LEAST: f64 = 0.5;

/// What is looked for.
pub(crate) struct Templates(Vec<(DMat3, Placed)>);

/// Columns and rows from the centre, and bins, of a template that was turned.
type Placed = Vec<(i32, i32, usize)>;

impl Templates {
    pub fn new(part: &Part) -> Self {
        let views = over_sphere(VIEWS);
        let turned = views.into_par_iter().flat_map_iter(|rotation| {
            let template = Template::new(part, rotation);
            (0..ROLLS).map(move |index| {
                let angle = TAU * f64::from(index) / f64::from(ROLLS);
                (roll(angle) * template.rotation, template.turned(angle))
            })
        });
        Self(turned.collect())
    }

    /// At most `most` poses, the best first, of a part whose diameter takes between `sizes` pixels.
    pub fn search(&self, part: &Part, picture: &Picture, sizes: [f64; 2], most: usize) -> Vec<Candidate> {
        let count = (libm::log(sizes[1] / sizes[0]) / libm::log(RATIO)).ceil().max(1.0);
        let step = libm::pow(sizes[1] / sizes[0], 1.0 / count);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // tens
        let sizes: Vec<f64> = (0..=count as u32).map(|i| sizes[0] * libm::pow(step, f64::from(i))).collect();
        let found = sizes.par_iter().flat_map(|size| {
            let level = picture.scaled(SIZE / size);
            let responses = Responses::of(&level);
            self.0
                .par_iter()
                .map_init(Vec::new, |sums, (rotation, features)| {
                    responses.score(features, sums);
                    places(&responses, sums, features.len())
                        .into_iter()
                        .map(|(column, row, score)| candidate(part, &level, *rotation, column, row, score))
                        .collect::<Vec<_>>()
                })
                .flatten_iter()
                .collect::<Vec<_>>()
        });
        let mut found: Vec<Candidate> = found.collect();
        // Only the best can be among those kept; the rest would make telling them apart slow.
        found.sort_by(|a, b| b.score.total_cmp(&a.score));
        found.truncate(64 * most);
        distinct(found, most, part.centre, part.diameter)
    }
}

/// The best places, apart from each other: column, row, and the part of the largest score there is.
fn places(responses: &Responses, sums: &[u8], features: usize) -> Vec<(usize, usize, f64)> {
    #[allow(clippy::cast_precision_loss)]
    let largest = MOST * features.max(1) as f64;
    let mut best: Vec<(usize, usize, f64)> = Vec::new();
    while best.len() < PLACES {
        let mut top = (0, 0, 0u8);
        for row in 0..responses.rows {
            let values = &sums[responses.cell(0, row)..][..responses.columns];
            // A row whose largest is no more than what is known needs no second look.
            if values.iter().copied().max().unwrap_or(0) <= top.2 {
                continue;
            }
            for (column, &value) in values.iter().enumerate() {
                let apart = |(c, r, _): &(usize, usize, f64)| column.abs_diff(*c) > 2 || row.abs_diff(*r) > 2;
                if value > top.2 && best.iter().all(apart) {
                    top = (column, row, value);
                }
            }
        }
        let score = f64::from(top.2) / largest;
        if score < LEAST {
            break;
        }
        best.push((top.0, top.1, score));
    }
    best
}

fn candidate(part: &Part, level: &Picture, rotation: DMat3, column: usize, row: usize, score: f64) -> Candidate {
    #[allow(clippy::cast_precision_loss)]
    let ray = level.camera.ray((column * STEP) as f64, (row * STEP) as f64);
    let focal = (level.camera.fx * level.camera.fy).sqrt();
    let centre = ray * (focal * part.diameter / SIZE);
    Candidate { pose: part.pose(towards(ray) * rotation, centre), score }
}
