//! The reports in a real browser, where this machine has one: they parse, no script or style fails, nothing is fetched.

use crate::devtools::{HEADLESS, NAMES, browser};
use crate::fixture::{photographed, succeeds};
use std::path::Path;
use std::process::Command;

/// The page's document once it is loaded, and what the browser has to say.
fn open(browser: &Path, page: &Path) -> (String, String) {
    let profile = tempfile::tempdir().unwrap();
    let output = Command::new(browser)
        .args(HEADLESS)
        .arg("--enable-logging=stderr")
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg("--dump-dom")
        .arg(format!("file://{}", page.display()))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    (String::from_utf8(output.stdout).unwrap(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn a_browser_shows_the_reports_of_fit_and_diagnosis() {
    let Some(browser) = browser() else {
        eprintln!("skipped: none of {NAMES:?} is on the PATH");
        return;
    };
    let top = photographed(64);
    for (command, says) in [("fit", "Fit of ball on a board"), ("diagnose", "Diagnosis of ball on a board")] {
        succeeds(top.path(), &[command, "capture", "--out", command, "--samples", "8"]);
        let (document, console) = open(&browser, &top.path().join(command).join("report.html"));
        let text = document.split_once("<h1").unwrap().1;
        assert!(text.contains(says), "{text}");
        assert!(document.trim_end().ends_with("</html>"), "the document is cut");
        assert!(!console.contains("CONSOLE"), "{console}");
        // Self-contained: every picture and style is in the file.
        for elsewhere in ["src=\"http", "href=\"http", "url(http", "@import"] {
            assert!(!document.contains(elsewhere), "{elsewhere}");
        }
        assert!(document.contains("src=\"data:image/png;base64,"));
    }
}
