//! The stage.

use crate::fixture::{exported, full, plain, text};
use gonio_export::Format;

#[test]
fn the_stage_is_in_metres_and_names_files_that_are_there() {
    for description in [plain(), full()] {
        let export = exported(&description, Format::Usd);
        let stage = text(&export, "scene.usda");
        assert!(stage.starts_with("#usda 1.0\n"));
        for line in ["metersPerUnit = 1", "upAxis = \"Z\"", "defaultPrim = \"Scene\""] {
            assert!(stage.contains(line), "{line}");
        }
        for (open, close) in [('{', '}'), ('(', ')'), ('[', ']')] {
            assert_eq!(stage.matches(open).count(), stage.matches(close).count(), "{open}");
        }
        for path in stage.split("@./").skip(1).map(|rest| rest.split('@').next().unwrap()) {
            assert!(export.files.contains_key(path), "{path}");
        }
        assert!(stage.contains("variantSet \"photo\""));
    }
}

#[test]
fn lamps_and_lenses_follow_their_definitions() {
    let stage = text(&exported(&full(), Format::Usd), "scene.usda");
    // 4 x 0.4 over a normalised sphere's area of 4 pi r^2.
    assert!(stage.contains("float inputs:intensity = 1.6\n"), "{stage}");
    assert!(stage.contains("float inputs:shaping:focus = 2\n"));
    assert!(stage.contains("float inputs:specular_ior = 1.5\n"));
    assert!(stage.contains("uniform token info:id = \"ND_open_pbr_surface_surfaceshader\""));
    let number = |key: &str| -> f64 {
        let rest = stage.split(&format!("{key} = ")).nth(1).unwrap();
        rest.split('\n').next().unwrap().parse().unwrap()
    };
    let focal = number("focalLength");
    assert!((number("horizontalAperture") / focal - 40.0 / 60.0).abs() < 1e-12);
    assert!((number("verticalAperture") / focal - 30.0 / 61.0).abs() < 1e-12);
    assert!((number("horizontalApertureOffset") / focal + 1.0 / 60.0).abs() < 1e-12);
    // The lens's diameter: focal length in scene units over the f-number.
    assert!((focal / 10.0 / number("fStop") - 0.004).abs() < 1e-12);
}
