//! Where the points of each design are.

use crate::fixture::{capture, plan, plan_of};

const ROUGHNESS: &str = "material.shell.roughness";

#[test]
fn a_grid_changes_its_last_axis_first_and_ends_where_it_should() {
    let plan = plan(
        "photos = [\"01\"]\n[[design]]\nkind = \"grid\"\naxes = [\n\
         { name = \"material.shell.roughness\", from = 0.1, to = 0.7, count = 3 },\n\
         { name = \"material.shell.ior\", values = [1.3, 1.6] }]\n",
    );
    assert_eq!(plan.names, [ROUGHNESS, "material.shell.ior"]);
    let expected = [[0.1, 1.3], [0.1, 1.6], [0.4, 1.3], [0.4, 1.6], [0.7, 1.3], [0.7, 1.6]];
    for (point, expected) in plan.points.iter().zip(expected) {
        assert!(point.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{point:?}");
    }
    // Both ends to the last bit: a bound would refuse what rounding carries beyond it.
    assert_eq!((plan.points[0][0], plan.points[5][0]), (0.1, 0.7));
    assert!(plan.frames.iter().enumerate().all(|(i, frame)| (frame.point, frame.photo) == (i, 1)));
}

#[test]
fn logarithmic_steps_have_equal_ratios() {
    let plan = plan(
        "[[design]]\nkind = \"grid\"\naxes = [{ name = \"material.shell.roughness\", from = 0.01, to = 1, count = 5, scale = \"log\" }]",
    );
    for pair in plan.points.windows(2) {
        assert!((pair[1][0] / pair[0][0] - 10.0_f64.sqrt()).abs() < 1e-12);
    }
}

#[test]
fn a_colour_takes_one_value_or_three() {
    let plan = plan(
        "[[design]]\nkind = \"grid\"\naxes = [{ name = \"material.shell.base_color\", values = [0.2, [0.1, 0.5, 0.9]] }]",
    );
    assert_eq!(plan.names, ["r", "g", "b"].map(|c| format!("material.shell.base_color.{c}")));
    assert_eq!(plan.points, [[0.2, 0.2, 0.2], [0.1, 0.5, 0.9]]);
}

#[test]
fn designs_are_multiplied_and_points_see_every_photo() {
    let plan = plan(
        "[[design]]\nkind = \"latin-hypercube\"\ncount = 5\naxes = [{ name = \"material.shell.roughness\", from = 0, to = 1 }]\n\
         [[design]]\nkind = \"grid\"\naxes = [{ name = \"material.shell.ior\", values = [1.3, 1.5, 1.7] }]",
    );
    assert_eq!((plan.points.len(), plan.frames.len()), (15, 30));
    for (i, frame) in plan.frames.iter().enumerate() {
        assert_eq!((frame.point, frame.photo), (i / 2, i % 2));
    }
    // One roughness in each fifth, each with every index.
    let mut fifths: Vec<usize> = plan.points.iter().map(|p| (p[0] * 5.0) as usize).collect();
    fifths.sort_unstable();
    assert_eq!(fifths, (0..5).flat_map(|i| [i; 3]).collect::<Vec<_>>());
}

#[test]
fn sobol_points_fill_every_elementary_interval() {
    let plan = plan(
        "photos = [\"00\"]\n[[design]]\nkind = \"sobol\"\ncount = 64\nseed = 3\naxes = [\
         { name = \"material.shell.roughness\", from = 0, to = 1 }, { name = \"material.shell.base_color.g\", from = 0, to = 1 }]",
    );
    // A (0, 6, 2)-net: one point in each of 64 rectangles, whatever their shape.
    for bits in 0..=6 {
        let (columns, rows) = (f64::from(1 << bits), f64::from(1 << (6 - bits)));
        let mut cells: Vec<(u32, u32)> =
            plan.points.iter().map(|p| ((p[0] * columns) as u32, (p[1] * rows) as u32)).collect();
        cells.sort_unstable();
        cells.dedup();
        assert_eq!(cells.len(), 64, "{columns} x {rows}");
    }
}

#[test]
fn lists_give_their_rows() {
    let list = "\u{feff}\"material.shell.roughness\", light.led.intensity\n# a remark\n0.25, 0.5\n\n1e-1,2\n";
    let plan = plan_of(&capture(), "[[design]]\nkind = \"csv\"\nfile = \"list.csv\"\n", list).unwrap();
    assert_eq!(plan.names.len(), 4);
    assert_eq!(plan.points, [[0.25, 0.5, 0.5, 0.5], [0.1, 2.0, 2.0, 2.0]]);
}

#[test]
fn without_a_design_the_capture_is_rendered_as_it_is() {
    let plan = plan("samples = 8\nseed = 5");
    assert_eq!((plan.points.len(), plan.frames.len(), plan.samples), (1, 2, 8));
    assert!(plan.frames.iter().all(|frame| frame.seed == 5) && plan.numbers(&plan.frames[0]).is_empty());
}

#[test]
fn independent_seeds_follow_the_values_and_not_their_place() {
    let grid = |values: &str| {
        plan(&format!(
            "seeds = \"independent\"\n[[design]]\nkind = \"grid\"\naxes = [{{ name = \"material.shell.roughness\", values = {values} }}]"
        ))
    };
    let (few, more) = (grid("[0.1, 0.3]"), grid("[0.1, 0.2, 0.3]"));
    let seeds = |plan: &gonio_sweep::Plan| plan.frames.iter().map(|f| f.seed).collect::<Vec<_>>();
    assert_eq!(seeds(&few), [&seeds(&more)[..2], &seeds(&more)[4..]].concat());
    let mut all = seeds(&more);
    assert!(all.iter().all(|seed| i64::try_from(*seed).is_ok()));
    all.sort_unstable();
    all.dedup();
    assert_eq!(all.len(), 3, "the photos of a point share its seed, points do not");
}
