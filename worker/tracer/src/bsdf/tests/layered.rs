//! Layered surfaces: without effects they are the plain models, and each layer keeps energy, reciprocity and its density.

use glam::Vec3;

use super::super::layered::{Built, Core, Layered, Recipe, Site, Spread};
use super::super::{Bsdf, Conductor, Lambert, Plastic};
use super::{GOLD_ETA, GOLD_K, Random, chi_square, direction, integrate_lobe, integrate_smooth};

const PLASTIC: Core = Core::Plastic { energy_compensation: false };

fn build(recipe: Recipe) -> Layered {
    Layered::new(recipe, &mut Built::default()).unwrap()
}

/// One surface for each effect, over a base of `base_color`, and one with all of them.
fn surfaces(base_color: Vec3) -> Vec<(&'static str, Recipe)> {
    let plastic = Recipe { base_color, roughness: 0.6, ..Recipe::plain(PLASTIC) };
    let lambert = Recipe { base_color, ..Recipe::plain(Core::Lambert) };
    let gold = Recipe { roughness: 0.6, eta: GOLD_ETA, k: GOLD_K, ..Recipe::plain(Core::Conductor) };
    let drawn = |recipe| Recipe { anisotropy_strength: 0.6, anisotropy_rotation: 0.4, ..recipe };
    let second = Recipe { second_lobe_weight: 0.4, second_lobe_roughness: 0.4, ..plastic };
    let coat = Recipe { clearcoat_factor: 1.0, clearcoat_roughness: 0.4, ..plastic };
    let sheen = |recipe| Recipe { sheen_color: Vec3::new(1.0, 0.8, 0.2), sheen_roughness: 0.6, ..recipe };
    vec![
        ("rough lambert", Recipe { diffuse_roughness: 0.6, ..lambert }),
        ("rough base", Recipe { diffuse_roughness: 0.6, ..plastic }),
        ("second lobe", second),
        ("coat", coat),
        ("metal", Recipe { metallic: 0.7, ..plastic }),
        ("drawn plastic", drawn(plastic)),
        ("drawn gold", drawn(gold)),
        ("sheen on lambert", sheen(lambert)),
        ("sheen on plastic", sheen(plastic)),
        (
            "all",
            Recipe {
                diffuse_roughness: 0.3,
                clearcoat_factor: 0.8,
                clearcoat_roughness: 0.4,
                metallic: 0.3,
                ..drawn(sheen(second))
            },
        ),
    ]
}

/// Without effects the layered code gives what the plain models give, but for rounding.
#[test]
fn without_effects_it_is_the_plain_model() {
    let color = Vec3::new(0.9, 0.5, 0.1);
    let mut pairs = vec![
        (Recipe::plain(Core::Lambert), Bsdf::Lambert(Lambert::new(color).unwrap())),
        (
            Recipe { eta: GOLD_ETA, k: GOLD_K, ..Recipe::plain(Core::Conductor) },
            Bsdf::Conductor(Conductor::new(0.5, GOLD_ETA, GOLD_K).unwrap()),
        ),
    ];
    for energy_compensation in [false, true] {
        let plain = Bsdf::Plastic(Plastic::new(color, 0.5, 1.5, energy_compensation).unwrap());
        let recipe = Recipe::plain(Core::Plastic { energy_compensation });
        pairs.push((recipe, plain.clone()));
        pairs.push((Recipe { roughness_spread: Some(Spread::By(1.5)), ..recipe }, plain));
    }
    let mut random = Random(12);
    for (recipe, plain) in pairs {
        let layered = build(Recipe { base_color: color, ..recipe });
        for _ in 0..1000 {
            let (wo, wi) = (random.direction(), random.direction());
            let (ours, theirs) = (layered.evaluate(&Site::default(), wo, wi), plain.evaluate(wo, wi));
            let error = (ours.value - theirs.value).abs().max_element();
            assert!(error < 2e-6 * theirs.value.max_element(), "{recipe:?}: {ours:?} {theirs:?}");
        }
    }
}

/// A place's roughness and colour are those of a surface built with them.
#[test]
fn a_place_is_the_surface_that_it_would_be_everywhere() {
    let base = Recipe { base_color: Vec3::new(0.6, 0.4, 0.1), ..Recipe::plain(PLASTIC) };
    let varied = build(Recipe { roughness: 0.5, roughness_spread: Some(Spread::By(1.6)), ..base });
    let mut random = Random(13);
    for (factor, albedo) in [(0.7, 1.2), (1.0, 0.5), (1.13, 2.0), (1.5, 1.0)] {
        let there =
            build(Recipe { roughness: 0.5 * factor, base_color: (base.base_color * albedo).min(Vec3::ONE), ..base });
        let site = Site { albedo: Vec3::splat(albedo), roughness: factor, ..Site::default() };
        for _ in 0..300 {
            let (wo, wi) = (random.direction(), random.direction());
            let ours = varied.evaluate(&site, wo, wi).value;
            let theirs = there.evaluate(&Site::default(), wo, wi).value;
            let error = (ours - theirs).abs().max_element();
            assert!(error < 1.5e-3 * theirs.max_element(), "{factor}: {ours} {theirs}");
        }
    }
}

#[test]
fn every_layer_is_reciprocal() {
    let mut random = Random(14);
    for (name, recipe) in surfaces(Vec3::new(0.9, 0.5, 0.1)) {
        let surface = build(recipe);
        for _ in 0..500 {
            let (wo, wi) = (random.direction(), random.direction());
            let forward = surface.evaluate(&Site::default(), wo, wi).value / wi.z;
            let backward = surface.evaluate(&Site::default(), wi, wo).value / wo.z;
            assert!(
                (forward - backward).abs().max_element() < 1e-4 * forward.max_element(),
                "{name}: {forward} {backward}"
            );
        }
    }
}

/// The white furnace, over white bases: nothing gains but Oren and Nayar's factor, whose own model gains up to 1.5 %.
#[test]
fn no_layer_gains() {
    for (name, recipe) in surfaces(Vec3::ONE) {
        let surface = build(recipe);
        let limit = if recipe.diffuse_roughness > 0.0 { 1.016 } else { 1.001 };
        for cos in [0.03, 0.1, 0.3, 0.6, 1.0] {
            let wo = direction(cos, 0.3);
            // Lobes here are wide, and each half suits the one or the other rule.
            let value = |wi: Vec3| surface.evaluate(&Site::default(), wo, wi).value;
            let near = |wi: Vec3| {
                let half = (wo + wi).normalize();
                (half.z * half.z).powi(8)
            };
            let returned = integrate_lobe(wo, 0.3, |wi| value(wi) * near(wi))
                + integrate_smooth(|wi| value(wi) * (1.0 - near(wi)));
            assert!(returned.max_element() < limit, "{name} cos {cos}: {returned}");
            assert!(returned.max_element() > 0.3, "{name} cos {cos}: {returned}");
        }
    }
}

/// A white energy-compensated base under each coat and sheen: the hardest furnace.
#[test]
fn coats_and_sheens_over_a_lossless_base_hardly_gain() {
    let base =
        Recipe { base_color: Vec3::ONE, roughness: 0.6, ..Recipe::plain(Core::Plastic { energy_compensation: true }) };
    for roughness in [0.4, 0.7, 1.0] {
        let coat = Recipe { clearcoat_factor: 1.0, clearcoat_roughness: roughness, ..base };
        let sheen = Recipe { sheen_color: Vec3::ONE, sheen_roughness: roughness, ..base };
        for (name, recipe) in [("coat", coat), ("sheen", sheen)] {
            let surface = build(recipe);
            for cos in [0.05, 0.3, 0.6, 1.0] {
                let wo = direction(cos, 0.3);
                let returned = integrate_smooth(|wi| surface.evaluate(&Site::default(), wo, wi).value).x;
                assert!(returned < 1.001, "{name} {roughness} cos {cos}: {returned}");
            }
        }
    }
}

#[test]
fn every_layer_draws_its_density() {
    for (i, (name, recipe)) in surfaces(Vec3::new(0.5, 0.7, 0.2)).into_iter().enumerate() {
        let surface = build(recipe);
        let site = Site { axis: direction(0.4, 1.1), ..Site::default() };
        let evaluate = |wo, wi| surface.evaluate(&site, wo, wi).pdf;
        let sample =
            |wo, u| surface.sample_direction(&site, wo, u).filter(|wi| surface.evaluate(&site, wo, *wi).pdf > 0.0);
        chi_square::check_density(name, &evaluate, &sample, 51 + i as u64);
    }
}

/// Each effect does what its name says.
#[test]
fn effects_have_their_signs() {
    let plain = Recipe { base_color: Vec3::new(0.6, 0.4, 0.1), roughness: 0.5, ..Recipe::plain(PLASTIC) };
    let at = |recipe: Recipe, wo: Vec3, wi: Vec3| build(recipe).evaluate(&Site::default(), wo, wi).value;
    let (up, aslant, mirror) = (Vec3::Z, direction(0.6, 0.0), direction(0.6, std::f32::consts::PI));
    let grazing = direction(0.1, 0.0);
    // Rough bases shine back to the light, and darken seen from above.
    let rough = Recipe { diffuse_roughness: 0.5, ..plain };
    assert!(at(rough, grazing, grazing).x > at(plain, grazing, grazing).x);
    assert!(at(rough, up, aslant).x < at(plain, up, aslant).x);
    // A sharp second lobe and a coat raise the mirror direction; a coat darkens the rest.
    let second = Recipe { second_lobe_weight: 0.3, ..plain };
    let coat = Recipe { clearcoat_factor: 0.5, ..plain };
    assert!(at(second, aslant, mirror).x > at(plain, aslant, mirror).x);
    assert!(at(coat, aslant, mirror).x > at(plain, aslant, mirror).x);
    assert!(at(coat, up, grazing).x < at(plain, up, grazing).x);
    // Metal: highlights take the base's colour, the diffuse part falls.
    let metal = Recipe { metallic: 0.8, ..plain };
    let (lit, dull) = (at(metal, aslant, mirror), at(plain, aslant, mirror));
    assert!(lit.x / lit.z > 1.5 * dull.x / dull.z);
    assert!(at(metal, aslant, aslant).x < at(plain, aslant, aslant).x);
    // The highlight reaches further along the tangent, -y here, than across.
    let drawn = Recipe { anisotropy_strength: 0.7, ..plain };
    let (along, across) = (direction(0.8, -std::f32::consts::FRAC_PI_2), direction(0.8, 0.0));
    assert!(at(drawn, up, along).x > at(drawn, up, across).x * 1.1);
    let turned = Recipe { anisotropy_rotation: std::f32::consts::FRAC_PI_2, ..drawn };
    assert!((at(turned, up, across) - at(drawn, up, along)).abs().max_element() < 1e-5);
    // Sheen brightens grazing angles.
    let sheen = Recipe { sheen_color: Vec3::splat(0.5), ..plain };
    assert!(at(sheen, grazing, grazing).x > at(plain, grazing, grazing).x);
}
