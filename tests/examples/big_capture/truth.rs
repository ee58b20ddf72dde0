//! What a capture is truly like, as its `answer.json` says.

use gonio_scene::Capture;
use serde_json::Value;
use std::path::Path;

/// The numbers of the answer, and what they are called in the capture.
const SCALARS: [(&str, &str); 2] = [("roughness", "material.shell.roughness"), ("ior", "material.shell.ior")];

/// `capture` with the numbers of the answer.
pub fn of(capture: &Capture, folder: &Path) -> Capture {
    let text = std::fs::read_to_string(folder.join("answer.json")).unwrap();
    let answer: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(answer["cause"], "none", "the source hides an effect, which this program does not render");
    let number = |value: &Value| value.as_f64().unwrap();
    let mut numbers: Vec<(String, f64)> =
        SCALARS.iter().map(|(key, name)| ((*name).to_owned(), number(&answer[*key]))).collect();
    for (channel, suffix) in ["r", "g", "b"].into_iter().enumerate() {
        numbers.push((format!("material.shell.base_color.{suffix}"), number(&answer["base_color"][channel])));
        numbers.push((format!("light.led.intensity.{suffix}"), number(&answer["intensity"])));
    }
    let mut truth = capture.clone();
    truth.set_numbers(&numbers).unwrap();
    truth
}
