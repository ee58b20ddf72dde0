//! Columns that are finite differences, against renders at both ends.

use crate::fixture::{Text, distance, film, film_along, lamp, plane};
use gonio_scene::Parameter;

fn with_step(mut columns: Vec<Parameter>, step: f64) -> Vec<Parameter> {
    columns.iter_mut().for_each(|c| c.step = Some(step));
    columns
}

/// A step makes a difference of what is usually carried along the path: central inside the range, one-sided at a bound.
#[test]
fn a_step_inside_the_range_is_central_and_at_a_bound_one_sided() {
    for (start, ends) in [(0.4, [0.42, 0.38]), (0.0, [0.02, 0.0]), (1.0, [1.0, 0.98])] {
        let text = Text::default();
        let stage = text.stage();
        let number = |value: f64| [("material.white.base_color.g".to_owned(), value)];
        let columns = with_step(text.columns(&["material.white.base_color.g"]), 0.02);
        let middle = stage.prepare(&number(start), &columns).unwrap();
        let film = film(&middle, 0, 4, 0);
        let [above, below] = ends.map(|value| {
            let end = stage.prepare(&number(value), &[]).unwrap();
            plane(&film_along(&end, &middle, 0, 4, [0, 0]), 0)
        });
        let expected: Vec<f64> = above.iter().zip(below).map(|(a, b)| (a - b) / (ends[0] - ends[1])).collect();
        let error = distance(&plane(&film, 1), &expected);
        assert!(error < 1e-4, "at {start}: {error}");
    }
}

/// A difference and a forward derivative of the same number agree; nothing else about the film changes.
#[test]
fn a_difference_agrees_with_the_forward_derivative_and_leaves_radiance_alone() {
    let text = Text::default();
    let stage = text.stage();
    let names = ["light.lamp.intensity.r", "material.glossy.roughness"];
    let forward = film(&stage.prepare(&[], &text.columns(&names)).unwrap(), 0, 8, 0);
    let columns = with_step(text.columns(&names), 0.01);
    let difference = film(&stage.prepare(&[], &columns).unwrap(), 0, 8, 0);
    let bits = |film| plane(film, 0).iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&forward), bits(&difference));
    let red = |values: Vec<f64>| values.into_iter().step_by(3).collect::<Vec<_>>();
    for index in [1, 2] {
        let error = distance(&red(plane(&difference, index)), &red(plane(&forward, index)));
        assert!(error < 5e-3, "{}: {error}", names[index - 1]);
    }
}

/// The difference takes the leading samples alone: what an evaluation of so few would give, to the bit.
#[test]
fn few_difference_samples_are_the_leading_ones() {
    let text = Text::default();
    let stage = text.stage();
    let columns = text.columns(&["light.lamp.position.x", "light.lamp.intensity.r"]);
    let prepared = stage.prepare(&[], &columns).unwrap();
    let (few, many, some) = (film(&prepared, 0, 4, 0), film(&prepared, 0, 16, 0), film(&prepared, 0, 16, 4));
    let bits = |film, index| plane(film, index).iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&some, 1), bits(&few, 1));
    assert_ne!(bits(&some, 1), bits(&many, 1));
    for index in [0, 2] {
        assert_eq!(bits(&some, index), bits(&many, index));
        assert_ne!(bits(&some, index), bits(&few, index));
    }
}

/// The same of derivatives that are carried along the paths; lamps that shine only for these shift no other number.
#[test]
fn few_forward_samples_are_the_leading_ones() {
    let mut text = Text::default();
    text.lights.push_str(&lamp("dark", "point", [-0.4, 0.3, 0.7], 0.0, ""));
    let stage = text.stage();
    let columns = text.columns(&["light.lamp.position.x", "light.lamp.intensity.r", "light.dark.intensity.r"]);
    let prepared = stage.prepare(&[], &columns).unwrap();
    let shares = |samples, forward| film_along(&prepared, &prepared, 0, samples, [0, forward]);
    let (few, many, some) = (shares(4, 0), shares(16, 0), shares(16, 4));
    let bits = |film, index| plane(film, index).iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    for index in [2, 3] {
        assert_eq!(bits(&some, index), bits(&few, index));
        assert_ne!(bits(&some, index), bits(&many, index));
    }
    for index in [0, 1] {
        assert_eq!(bits(&some, index), bits(&many, index));
        assert_ne!(bits(&some, index), bits(&few, index));
    }
}

/// A photo whose numbers stay gets zeros; the one whose number moves gets its difference.
#[test]
fn a_difference_concerns_the_photos_that_it_moves() {
    let mut text = Text::default();
    text.camera.push_str("distortion = [0.01, 0, 0, 0, 0]");
    let stage = text.stage();
    let columns = text.columns(&["photo.b.camera_to_world.0.3"]);
    let prepared = stage.prepare(&[], &columns).unwrap();
    assert!(plane(&film(&prepared, 0, 4, 0), 1).iter().all(|v| *v == 0.0));
    assert!(plane(&film(&prepared, 1, 4, 0), 1).iter().any(|v| v.abs() > 0.1));
}

/// Where a step fits to neither side there is no difference.
#[test]
fn a_step_wider_than_the_range_is_refused() {
    let text = Text::default();
    let columns = with_step(text.columns(&["material.white.base_color.g"]), 2.0);
    let error = text.stage().prepare(&[], &columns).err().unwrap().to_string();
    assert!(error.contains("material.white.base_color.g") && error.contains("smaller step"), "{error}");
}
