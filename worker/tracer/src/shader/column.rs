//! Derivatives of a layered surface by its numbers: differences between surfaces that were built beforehand.

use crate::bsdf::{Built, Core, Layered, ParameterError, Recipe};
use glam::Vec3;
use gonio_scene::capture::NULL_STEP;

/// How a number is differentiated.
enum Rule {
    /// The value is linear in it: one difference over any step is exact.
    Linear,
    /// By central differences, or by three points to one side near a bound, over a step that depends on the recipe.
    Curved(fn(&Recipe) -> f32),
    /// As `Curved`, but at 0, where it has no slope, one difference over [`NULL_STEP`].
    Squared(fn(&Recipe) -> f32),
}

enum Target {
    Number(fn(&mut Recipe) -> &mut f32),
    Color(fn(&mut Recipe) -> &mut Vec3),
}

/// A number or colour of the capture format.
pub struct Key {
    /// Its name in a material.
    pub name: &'static str,
    /// Whether plain models have it, and its analytic derivative.
    pub plain: bool,
    target: Target,
    rule: Rule,
    bounds: (f32, f32),
    /// Whether it changes anything.
    counts: fn(&Recipe) -> bool,
}

const UNIT: (f32, f32) = (0.0, 1.0);
const IOR: (f32, f32) = (1.0097, 4.0);
const INDEX: (f32, f32) = (1e-3, 100.0);

/// Half a percent of a perceptual roughness: lobes change by some percent, of which single precision keeps four digits.
fn of_roughness(r: f32) -> f32 {
    0.005 * r.max(0.05)
}

/// Far enough that alpha along the tangent changes by a percent.
fn of_strength(r: &Recipe) -> f32 {
    let (alpha, s) = (r.roughness * r.roughness, r.anisotropy_strength);
    (0.005 * (alpha + s * s) / s.max(1e-3)).clamp(1e-4, 0.01)
}

const fn number(
    name: &'static str,
    target: fn(&mut Recipe) -> &mut f32,
    rule: Rule,
    bounds: (f32, f32),
    counts: fn(&Recipe) -> bool,
) -> Key {
    Key { name, plain: false, target: Target::Number(target), rule, bounds, counts }
}

const fn color(name: &'static str, target: fn(&mut Recipe) -> &mut Vec3, rule: Rule, bounds: (f32, f32)) -> Key {
    Key { name, plain: false, target: Target::Color(target), rule, bounds, counts: |_| true }
}

const fn plain(key: Key) -> Key {
    Key { plain: true, ..key }
}

/// Every number but the variations'.
pub static KEYS: [Key; 16] = [
    plain(color("base_color", |r| &mut r.base_color, Rule::Curved(|_| 0.005), UNIT)),
    plain(number("roughness", |r| &mut r.roughness, Rule::Curved(|r| of_roughness(r.roughness)), UNIT, |_| true)),
    plain(number("ior", |r| &mut r.ior, Rule::Curved(|_| 0.005), IOR, |_| true)),
    plain(color("eta", |r| &mut r.eta, Rule::Curved(|_| 0.002), INDEX)),
    plain(color("k", |r| &mut r.k, Rule::Curved(|_| 0.005), (0.0, 100.0))),
    number("diffuse_roughness", |r| &mut r.diffuse_roughness, Rule::Squared(|_| 0.01), (0.0, 2.0), |_| true),
    number("second_lobe_weight", |r| &mut r.second_lobe_weight, Rule::Linear, UNIT, |_| true),
    number(
        "second_lobe_roughness",
        |r| &mut r.second_lobe_roughness,
        Rule::Curved(|r| of_roughness(r.second_lobe_roughness)),
        UNIT,
        |r| r.second_lobe_weight > 0.0,
    ),
    // The value is quadratic in the coat's factor: any step is exact.
    number("clearcoat_factor", |r| &mut r.clearcoat_factor, Rule::Curved(|_| 0.25), UNIT, |_| true),
    number(
        "clearcoat_roughness",
        |r| &mut r.clearcoat_roughness,
        Rule::Curved(|r| of_roughness(r.clearcoat_roughness)),
        UNIT,
        |r| r.clearcoat_factor > 0.0,
    ),
    number("clearcoat_ior", |r| &mut r.clearcoat_ior, Rule::Curved(|_| 0.005), IOR, |r| r.clearcoat_factor > 0.0),
    number("metallic", |r| &mut r.metallic, Rule::Linear, UNIT, |_| true),
    number("anisotropy_strength", |r| &mut r.anisotropy_strength, Rule::Squared(of_strength), UNIT, |_| true),
    number(
        "anisotropy_rotation",
        |r| &mut r.anisotropy_rotation,
        Rule::Curved(|_| 0.005),
        (f32::MIN, f32::MAX),
        |r| r.anisotropy_strength > 0.0,
    ),
    color("sheen_color", |r| &mut r.sheen_color, Rule::Linear, UNIT),
    number(
        "sheen_roughness",
        |r| &mut r.sheen_roughness,
        Rule::Curved(|_| 0.005),
        UNIT,
        |r| r.sheen_color != Vec3::ZERO,
    ),
];

/// One derivative image: a weighted sum of surfaces that differ in one number, or in one colour's three channels, of which
/// each acts on its own.
#[derive(Clone, Debug)]
pub struct Column {
    /// The plane it adds to.
    pub plane: usize,
    /// The surfaces and their weights, per channel.
    points: Vec<(Layered, Vec3)>,
    /// Weight of the surface itself.
    center: Vec3,
}

impl Key {
    /// Builds what the column of this number needs; `None` where it changes nothing.
    ///
    /// # Errors
    /// As `Layered::new`.
    pub fn column(&self, recipe: &Recipe, plane: usize, built: &mut Built) -> Result<Option<Column>, ParameterError> {
        if !(self.counts)(recipe) {
            return Ok(None);
        }
        let value = match self.target {
            Target::Number(at) => Vec3::splat(*at(&mut recipe.clone())),
            Target::Color(at) => *at(&mut recipe.clone()),
        };
        let (low, high) = self.bounds;
        // To the side that has more room.
        let side = value.map(|v| if v - low <= high - v { 1.0 } else { -1.0 });
        let curved = |step: f32| {
            if (value - step).min_element() >= low && (value + step).max_element() <= high {
                vec![(Vec3::splat(step), 0.5), (Vec3::splat(-step), 0.5)]
            } else {
                vec![(side * step, 2.0), (side * (2.0 * step), -1.0)]
            }
        };
        // Offsets, and the weights of their difference quotients.
        let offsets = match self.rule {
            Rule::Linear => vec![(side * 0.25, 1.0)],
            Rule::Squared(_) if value.x == 0.0 => vec![(Vec3::splat(NULL_STEP as f32), 1.0)],
            Rule::Squared(step) | Rule::Curved(step) => curved(step(recipe)),
        };
        let mut column = Column { plane, points: Vec::with_capacity(offsets.len()), center: Vec3::ZERO };
        for (offset, weight) in offsets {
            let mut moved = *recipe;
            let target = value + offset;
            match self.target {
                Target::Number(at) => *at(&mut moved) = target.x,
                Target::Color(at) => *at(&mut moved) = target,
            }
            // The step taken, after rounding.
            let factor = weight / (target - value);
            column.points.push((Layered::new(moved, built)?, factor));
            column.center -= factor;
        }
        // Of two steps of one length the weights cancel but for rounding.
        if column.center.abs().max_element() * 1e3 < column.points[0].1.abs().min_element() {
            column.center = Vec3::ZERO;
        }
        Ok(Some(column))
    }
}

impl Column {
    /// Whether [`Self::derivative`] looks at its `center`.
    pub fn needs_center(&self) -> bool {
        self.center != Vec3::ZERO
    }

    /// The derivative of `value` at fixed directions; `center` is that of the surface itself.
    pub fn derivative(&self, center: Vec3, value: impl Fn(&Layered) -> Vec3) -> Vec3 {
        let start = if self.needs_center() { self.center * center } else { Vec3::ZERO };
        self.points.iter().fold(start, |sum, (surface, weight)| sum + *weight * value(surface))
    }
}

/// The least GGX alpha of a surface, 1 where it has no such lobe: the scale on which values vary with directions.
pub fn sharpness(recipe: &Recipe) -> f32 {
    let mut least = if recipe.core == Core::Lambert { 1.0 } else { recipe.roughness };
    if recipe.core != Core::Lambert && recipe.second_lobe_weight > 0.0 {
        least = least.min(recipe.second_lobe_roughness);
    }
    if recipe.clearcoat_factor > 0.0 {
        least = least.min(recipe.clearcoat_roughness);
    }
    (least * least).max(crate::bsdf::ALPHA_FLOOR)
}
