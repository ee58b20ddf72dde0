//! Sweeps that were damaged anywhere: an error or a plan, never a panic, never more frames than there may be.

use crate::fixture::{HEAD, capture, digests, plan_of};
use gonio_sweep::MOST_FRAMES;
use proptest::prelude::*;

const LINES: &str = r#"samples = 8
seeds = "independent"
outputs = ["exr", "png"]
photos = ["00"]
[[design]]
kind = "grid"
axes = [{ name = "material.shell.roughness", from = 0.1, to = 0.6, count = 3 }, { name = "material.shell.base_color", values = [0.1, [0.2, 0.3, 0.4]] }]
[[design]]
kind = "csv"
file = "list.csv"
[[view]]
name = "dome"
kind = "hemisphere"
target = [0.0, 0.0, 0.02]
radius = [0.35, 0.45]
count = 3
[view.camera]
width = 20
"#;
const LIST: &str = "material.shell.ior,light.led.intensity\n1.3,0.5\n1.7,2\n";

/// Pieces that mean something to the readers.
const PIECES: &[&str] = &[
    "[[design]]",
    "[[view]]",
    "nan",
    "inf",
    "-1",
    "1e308",
    "99999999999",
    "\"",
    "]",
    "}",
    "{",
    "=",
    ",",
    "\n",
    "count",
    "values",
    "from",
    "0",
    "kind = \"sobol\"",
    "é",
    "\u{0}",
    "[]",
];

fn damaged(text: &'static str) -> impl Strategy<Value = String> {
    let edit = (0..text.len(), 0..20_usize, 0..PIECES.len());
    proptest::collection::vec(edit, 1..4).prop_map(move |edits| {
        let mut bytes = text.as_bytes().to_vec();
        for (at, length, piece) in edits {
            let at = at.min(bytes.len());
            let end = (at + length).min(bytes.len());
            bytes.splice(at..end, PIECES[piece].bytes());
        }
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damage_is_an_error_or_a_plan(lines in damaged(LINES), list in damaged(LIST)) {
        for (lines, list) in [(lines.as_str(), LIST), (LINES, list.as_str())] {
            if let Ok(plan) = plan_of(&capture(), lines, list) {
                prop_assert!(plan.frames.len() as u64 <= MOST_FRAMES);
                prop_assert!(plan.points.iter().flatten().all(|value| value.is_finite()));
                if plan.frames.len() < 1000 {
                    prop_assert_eq!(digests(&plan).len(), plan.frames.len());
                }
            } else {
                let error = plan_of(&capture(), lines, list).unwrap_err().to_string();
                prop_assert!(!error.contains('\n'), "{error}");
            }
        }
    }

    #[test]
    fn any_text_at_all(text in "\\PC*") {
        let _ = plan_of(&capture(), &text, &text);
        let _ = gonio_sweep::Sweep::parse("s", &text, 100);
    }
}

#[test]
fn the_undamaged_sweep_is_one() {
    assert_eq!(plan_of(&capture(), LINES, LIST).unwrap().frames.len(), 3 * 2 * 2 * 4);
    assert!(HEAD.starts_with("format = 1"));
}
