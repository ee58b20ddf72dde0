//! Poses that are corrected and objects that were there for a part of the exposure.

use crate::fixture::{Text, distance, film, plane, radiance};

fn block(keys: &str) -> Text {
    Text { block: keys.to_owned(), ..Text::default() }
}

/// The correction against the same motion written into the matrix: a turn about z and one about an axis askew.
#[test]
fn a_correction_is_the_same_as_the_matrix_that_it_makes() {
    // A turn by a third about (1, 1, 1) takes x to y, y to z, z to x.
    let third = 2.0 * std::f64::consts::PI / 3.0 / 3f64.sqrt();
    for (rotation, rows) in [
        ([0.0, 0.0, 0.5], {
            let (s, c) = libm::sincos(0.5);
            [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
        }),
        ([third; 3], [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
        ([1e-5, 0.0, 0.0], [[1.0, 0.0, 0.0], [0.0, 1.0, -1e-5], [0.0, 1e-5, 1.0]]),
    ] {
        let text = block(&format!("rotation = {rotation:?}\ntranslation = [0.01, -0.02, 0.03]"));
        let mut capture = text.capture();
        let found = capture.objects[1].placement();
        let was = capture.objects[1].object_to_world;
        let origin = [0.02 + 0.01, 0.01 - 0.02, 0.051 + 0.03];
        for i in 0..3 {
            for j in 0..3 {
                let expected: f64 = (0..3).map(|k| rows[i][k] * was[k][j]).sum();
                assert!((found[i][j] - expected).abs() < 1e-11, "{rotation:?} at {i} {j}: {found:?}");
            }
            assert!((found[i][3] - origin[i]).abs() < 1e-15);
        }
        capture.objects[1] =
            gonio_scene::capture::Object { object_to_world: found, ..block("").capture().objects[1].clone() };
        let stage = gonio_tracer::Stage::new(capture, crate::fixture::assets());
        assert_eq!(text.render(4), radiance(&stage.prepare(&[], &[]).unwrap(), 4));
    }
}

#[test]
fn presence_is_the_share_of_the_samples_with_the_object() {
    let (absent, half, there) = (block("presence = 0"), block("presence = 0.25"), block(""));
    let (without, with) = (absent.render(256), there.render(256));
    let mixed: Vec<f64> = without.iter().zip(&with).map(|(a, b)| 0.75 * a + 0.25 * b).collect();
    let error = distance(&half.render(256), &mixed);
    assert!(error < 0.02, "{error}");
    assert!(distance(&without, &with) > 0.2);
}

#[test]
fn presence_has_the_difference_of_both_as_its_derivative() {
    let text = block("presence = 0");
    let stage = text.stage();
    let columns = text.columns(&["object.block.presence"]);
    let [with, without] = [block(""), text.clone()].map(|t| t.render(4));
    let expected: Vec<f64> = with.iter().zip(&without).map(|(a, b)| a - b).collect();
    for (value, tolerance) in [(0.0, 1e-5), (1.0, 1e-5), (0.5, 1e-5)] {
        let at = [("object.block.presence".to_owned(), value)];
        let mut columns = columns.clone();
        columns[0].value = value;
        let found = plane(&film(&stage.prepare(&at, &columns).unwrap(), 0, 4, 0), 1);
        assert!(distance(&found, &expected) < tolerance, "{value}");
    }
}

#[test]
fn two_objects_for_a_part_of_the_exposure_are_refused() {
    let mut text = block("presence = 0.5");
    text.board = "presence = 0.25".into();
    let error = text.parse().unwrap_err().to_string();
    assert!(error.contains("object.block.presence") && error.contains("object.board.presence"), "{error}");
    text.board = "presence = 0".into();
    let at = [("object.board.presence".to_owned(), 0.5)];
    let error = text.stage().prepare(&at, &[]).err().unwrap().to_string();
    assert!(error.contains("object.block.presence") && error.contains("object.board.presence"), "{error}");
}

/// An object that is absent may move without anyone seeing it; one that is there moves the image.
#[test]
fn poses_have_derivatives_where_the_object_is_there() {
    for (presence, moves) in [(0.0, false), (1.0, true)] {
        let text = block(&format!("presence = {presence:?}"));
        let columns = text.columns(&["object.block.translation.x", "object.block.rotation.z"]);
        let film = film(&text.stage().prepare(&[], &columns).unwrap(), 0, 4, 0);
        for index in [1, 2] {
            assert_eq!(plane(&film, index).iter().any(|v| *v != 0.0), moves);
        }
    }
}
