//! The page of a command that runs.

use gonio_tests::browser::{self, Browser};
use gonio_tests::captures;
use gonio_tests::cluster::{Process, command};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

/// Longer than a command of these tests runs.
const LONG: Duration = Duration::from_secs(600);

/// Starts a command with `--watch`; the process, and where its page is.
pub fn watched(arguments: &[&str]) -> (Process, String) {
    let mut command = command("gonio", arguments);
    let mut child = command.arg("--watch").stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
    let url = lines.find_map(|line| line.strip_prefix("watch at ").map(str::to_owned)).unwrap();
    // The rest must be read, too, or the program waits for ever to say it.
    std::thread::spawn(move || lines.for_each(drop));
    (child.into(), url)
}

fn json(file: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap()
}

/// Where pictures of pages are kept for people to look at, if they are wanted.
pub fn album() -> Option<std::path::PathBuf> {
    std::env::var_os("GONIO_SCREENSHOTS").map(Into::into)
}

/// The page in light, dark, and on a phone, where nothing must be wider than the screen.
pub fn look(browser: &mut Browser, name: &str) {
    for (kind, scheme, width) in [("light", "light", 1280), ("dark", "dark", 1280), ("phone", "light", 360)] {
        browser.resize(width, 800);
        browser.scheme(scheme);
        browser.value("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))");
        let wide = browser.value("document.documentElement.scrollWidth").as_u64().unwrap();
        assert!(wide <= width.into(), "{name} is {wide} pixels wide on a screen of {width}");
        if let Some(album) = album() {
            browser.screenshot(&album.join(format!("{name}-{kind}.png")), true);
        }
    }
    browser.resize(1280, 800);
}

/// Values and standard errors of the table of parameters, by name.
const SHOWN: &str = "[...document.querySelectorAll('#parameter-rows tr')].map((tr) => \
                     [tr.children[0].textContent, ...[...tr.querySelectorAll('data')].map((d) => d.value)])";

#[test]
fn a_page_follows_a_fit_to_its_written_numbers() {
    let Some(program) = browser::find() else { return };
    let out = tempfile::tempdir().unwrap();
    let capture = captures().join("none-201");
    let capture = capture.to_str().unwrap();
    let mut browser = Browser::start(&program, 1280, 800);
    let out_path = out.path().to_str().unwrap();
    let (mut fit, url) = watched(&["fit", capture, "--out", out_path, "--samples", "128", "--threads", "1"]);
    browser.open(&url);
    browser.wait("document.title.startsWith('Fit of none-201')");
    // While it runs: a loss with its band, parameters, a photo beside its render.
    browser.wait_for("document.querySelectorAll('#loss-chart circle').length >= 2", LONG);
    browser.wait_for("document.querySelector('#photo-list img')?.naturalWidth > 100", LONG);
    let live = browser.value(SHOWN);
    assert!(live.as_array().unwrap().len() >= 6, "{live}");
    assert_eq!(browser.value("document.querySelector('#loss-chart .band') !== null"), true);
    assert!(
        browser
            .value("document.getElementById('loss-chart').getAttribute('aria-label')")
            .as_str()
            .unwrap()
            .contains("Loss after")
    );
    assert_eq!(browser.value("document.body.dataset.status"), "live");
    if let Some(album) = album() {
        browser.screenshot(&album.join("fit-live.png"), true);
    }
    browser.wait_for("document.body.dataset.status === 'over'", LONG);
    assert_eq!(fit.wait_for(Duration::from_secs(20)).and_then(|status| status.code()), Some(0));
    let written = json(&out.path().join("fit.json"));
    let shown = browser.value(SHOWN);
    let (shown, written_parameters) = (shown.as_array().unwrap(), written["parameters"].as_array().unwrap());
    assert_eq!(shown.len(), written_parameters.len());
    for (shown, written) in shown.iter().zip(written_parameters) {
        assert_eq!(shown[0], written["name"]);
        for (text, number) in [(&shown[1], &written["value"]), (&shown[2], &written["standard_error"])] {
            // To the last bit.
            assert_eq!(text.as_str().unwrap().parse::<f64>().ok(), number.as_f64(), "{shown} {written}");
        }
    }
    let points = browser.value("document.querySelectorAll('#loss-rows tr').length");
    assert_eq!(points.as_u64().unwrap() as usize, written["loss_curve"].as_array().unwrap().len());
    let summary = browser.value("document.getElementById('summary').textContent");
    assert!(summary.as_str().unwrap().contains("converged after"), "{summary}");
    // All photos now, those held out too, and none of them broken.
    assert_eq!(browser.value("document.querySelectorAll('#photo-list article').length"), 8);
    assert_eq!(
        browser.value(
            "[...document.querySelectorAll('#photo-list img')].every((i) => i.complete && i.naturalWidth > 0 && i.alt)"
        ),
        true
    );
    look(&mut browser, "fit");
    assert_eq!(browser.complaints(), Vec::<String>::new());
    assert_eq!(browser.hosts().len(), 1, "{:?}", browser.hosts());
}

#[test]
fn the_page_stops_a_fit_as_a_signal_does() {
    let Some(program) = browser::find() else { return };
    let out = tempfile::tempdir().unwrap();
    let capture = captures().join("none-201");
    let mut browser = Browser::start(&program, 1280, 800);
    let (capture, out_path) = (capture.to_str().unwrap(), out.path().to_str().unwrap());
    let (mut fit, url) = watched(&[
        "fit",
        capture,
        "--out",
        out_path,
        "--solver",
        "particle-swarm",
        "--threads",
        "1",
        "--samples",
        "64",
    ]);
    browser.open(&url);
    browser.wait_for("document.querySelectorAll('#loss-rows tr').length >= 1", LONG);
    browser.value("document.getElementById('stop').click()");
    browser.value("document.querySelector('#sure button[value=stop]').click()");
    browser.wait_for("document.body.dataset.status === 'over'", LONG);
    assert_eq!(fit.wait_for(Duration::from_secs(20)).and_then(|status| status.code()), Some(130));
    let text = browser.value("document.getElementById('phase').textContent");
    assert!(text.as_str().unwrap().contains("--resume"), "{text}");
    assert_eq!(json(&out.path().join("fit.json"))["converged"], false);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
fn a_page_follows_a_diagnosis_to_its_verdict() {
    let Some(program) = browser::find() else { return };
    let out = tempfile::tempdir().unwrap();
    let capture = captures().join("vignetting-204");
    let mut browser = Browser::start(&program, 1280, 800);
    let (capture, out_path) = (capture.to_str().unwrap(), out.path().to_str().unwrap());
    let (mut diagnosis, url) = watched(&["diagnose", capture, "--out", out_path, "--samples", "16"]);
    browser.open(&url);
    browser.wait_for("document.querySelectorAll('#ranking-rows tr').length > 5", LONG);
    let first = "document.querySelector('#ranking-rows th').textContent";
    assert_eq!(browser.value(first), "vignetting");
    browser.wait_for("document.body.dataset.status === 'over'", LONG);
    assert_eq!(diagnosis.wait_for(Duration::from_secs(20)).and_then(|status| status.code()), Some(0));
    let written = json(&out.path().join("diagnosis.json"));
    let found = written["found"][0]["effects"][0].as_str().unwrap().to_owned();
    let verdict = browser.value("document.getElementById('verdict-text').innerText");
    assert!(verdict.as_str().unwrap().starts_with(&format!("Found: {found}")), "{verdict}");
    let shown = browser.value(SHOWN);
    for (shown, written) in shown.as_array().unwrap().iter().zip(written["final"]["parameters"].as_array().unwrap()) {
        assert_eq!((&shown[0], shown[1].as_str().unwrap().parse().ok()), (&written["name"], written["value"].as_f64()));
    }
    assert_eq!(
        browser.value(
            "[...document.querySelectorAll('#photo-list img')].every((i) => i.complete && i.naturalWidth > 0 && i.alt)"
        ),
        true
    );
    look(&mut browser, "diagnosis");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
fn a_page_shows_a_sweeps_sheet_as_it_fills() {
    let Some(program) = browser::find() else { return };
    let top = tempfile::tempdir().unwrap();
    let text = format!(
        "format = 1\ncapture = {:?}\nsamples = 64\nresolution = 0.5\noutputs = [\"png\"]\n[[design]]\nkind = \"grid\"\n\
         axes = [{{ name = \"material.shell.roughness\", from = 0.1, to = 0.6, count = 24 }}]\n[[view]]\nname = \"top\"\n\
         kind = \"look-at\"\nposition = [0.0, 0.0, 0.32]\ntarget = [0.0, 0.0, 0.0]\n",
        captures().join("none-201")
    );
    std::fs::write(top.path().join("sweep.toml"), text).unwrap();
    let [sweep, out] = ["sweep.toml", "out"].map(|name| top.path().join(name).to_str().unwrap().to_owned());
    let mut browser = Browser::start(&program, 1280, 800);
    let (mut sweep, url) = watched(&["sweep", &sweep, "--out", &out, "--threads", "1"]);
    browser.open(&url);
    browser.wait_for("document.getElementById('sheet-image').naturalWidth > 50", LONG);
    browser.wait_for("document.body.dataset.status === 'over'", LONG);
    assert_eq!(sweep.wait_for(Duration::from_secs(20)).and_then(|status| status.code()), Some(0));
    let said = browser.value("document.getElementById('sheet-caption').textContent");
    assert!(said.as_str().unwrap().starts_with("24 of 24 frames"), "{said}");
    look(&mut browser, "sweep");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}
